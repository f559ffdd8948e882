//! Files of unfinished runs, cut and damaged wherever they can be, and the shares of a computation.

use std::path::Path;

use kinetostat::{
    input::Inputs,
    work::{
        checkpoint::{Checkpoint, ExistingPieces, Origin},
        share::Share,
    },
};

fn origin(text: &str) -> Origin {
    Origin { program: "1".into(), inputs: Inputs::of("study.toml", text) }
}

const PIECES: [&str; 3] = ["first", "", "the third"];

/// A file with [`PIECES`], its bytes and where its records end.
fn written(path: &Path) -> (Vec<u8>, Vec<u64>) {
    let mut checkpoint = Checkpoint::create(path, &origin("a")).unwrap();
    let end = || std::fs::metadata(path).unwrap().len();
    let mut ends = vec![end()];
    for (key, piece) in PIECES.iter().enumerate() {
        checkpoint.append_piece(&[key as u8], piece.as_bytes()).unwrap();
        ends.push(end());
    }
    (std::fs::read(path).unwrap(), ends)
}

fn found(checkpoint: &mut Checkpoint) -> Vec<Option<Vec<u8>>> {
    (0..PIECES.len()).map(|key| checkpoint.bytes(&[key as u8]).unwrap()).collect()
}

#[test]
fn whole_pieces_survive_a_cut_at_any_byte_and_zeros_behind_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let (whole, ends) = written(&path);
    for (cut, zeros) in (0..=whole.len()).flat_map(|cut| [(cut, 0), (cut, 100)]) {
        // Zeros within the first record look like damage to it.
        if zeros > 0 && cut < ends[0] as usize {
            continue;
        }
        std::fs::write(&path, [&whole[..cut], &vec![0; zeros]].concat()).unwrap();
        let kept = ends.iter().filter(|end| **end <= cut as u64).count().saturating_sub(1);
        let same = if kept > 0 { ExistingPieces::Same } else { ExistingPieces::Nothing };
        assert_eq!(Checkpoint::find(&path, &origin("a")).unwrap(), same, "cut at {cut}");
        let mut checkpoint = Checkpoint::resume(&path, &origin("a")).unwrap();
        assert_eq!(checkpoint.len(), kept, "cut at {cut}, {zeros} zeros");
        for (key, piece) in PIECES.iter().enumerate() {
            let found = checkpoint.bytes(&[key as u8]).unwrap();
            assert_eq!(found.is_some(), key < kept, "cut at {cut}");
            if found.is_none() {
                checkpoint.append_piece(&[key as u8], piece.as_bytes()).unwrap();
            }
        }
        assert_eq!(std::fs::read(&path).unwrap(), whole, "cut at {cut}");
    }
}

#[test]
fn a_damaged_byte_loses_its_record_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let (mut bytes, ends) = written(&path);
    bytes[ends[1] as usize - 1] ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(Checkpoint::find(&path, &origin("a")).unwrap(), ExistingPieces::Same);
    assert_eq!(std::fs::read(&path).unwrap(), bytes, "a question changes nothing");
    let mut checkpoint = Checkpoint::resume(&path, &origin("a")).unwrap();
    assert_eq!(checkpoint.damaged_count(), 1);
    assert_eq!(found(&mut checkpoint), [None, Some(vec![]), Some(b"the third".to_vec())]);
}

#[cfg(unix)]
#[test]
fn nothing_is_written_through_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let (elsewhere, path) = (folder.path().join("elsewhere"), folder.path().join("run"));
    for content in ["", "mine"] {
        std::fs::write(&elsewhere, content).unwrap();
        std::os::unix::fs::symlink(&elsewhere, &path).unwrap();
        let errors = [
            Checkpoint::create(&path, &origin("a")).map(drop).unwrap_err(),
            Checkpoint::resume(&path, &origin("a")).map(drop).unwrap_err(),
            Checkpoint::find(&path, &origin("a")).map(drop).unwrap_err(),
        ];
        assert!(errors.iter().all(|error| error.to_string().contains("run: is a link")), "{errors:?}");
        assert_eq!(std::fs::read_to_string(&elsewhere).unwrap(), content);
        std::fs::remove_file(&path).unwrap();
    }
}

#[test]
fn another_origin_is_refused_with_what_differs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let refused = |expected: &str| {
        let error = Checkpoint::resume(&path, &origin("a")).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    let mut other = Checkpoint::create(&path, &origin("b")).unwrap();
    other.append_piece(b"key", b"piece").unwrap();
    drop(other);
    let change = "study.toml, line 1: was `b`, is `a`";
    assert_eq!(Checkpoint::find(&path, &origin("a")).unwrap(), ExistingPieces::Other(change.into()));
    refused(&format!("belongs to another run: {change}"));
    Checkpoint::create(&path, &Origin { program: "0".into(), ..origin("a") }).unwrap();
    refused("the run was made by 0, this program is 1");
    std::fs::write(&path, b"nothing of the kind").unwrap();
    refused("is not a file of an unfinished run");
}

#[test]
fn every_piece_is_in_one_part_and_parts_know_how_many() {
    for of in [1, 2, 3, 7, 100] {
        let shares: Vec<Share> = (1..=of).map(|part| Share::new(part, of).unwrap()).collect();
        for pieces in [0, 1, 2, 6, 7, 8, 50] {
            for share in &shares {
                assert_eq!(share.count(pieces), (0..pieces).filter(|&piece| share.holds(piece)).count(), "{share}");
            }
            assert!((0..pieces).all(|piece| shares.iter().filter(|share| share.holds(piece)).count() == 1));
        }
    }
}

#[test]
fn parts_that_there_are_not_are_refused_with_what_was_expected() {
    assert_eq!("3/10".parse(), Share::new(3, 10));
    for (text, expected) in [
        ("0/3", "of 3 expected a part from 1 to 3, got 0"),
        ("4/3", "of 3 expected a part from 1 to 3, got 4"),
        ("1/0", "expected 1 to 1000000 parts, got 0"),
        ("x/y", "expected i/n such as 3/10"),
        ("-1/3", "expected i/n"),
        ("3", "expected i/n"),
        ("1/2/3", "expected i/n"),
        ("", "expected i/n"),
    ] {
        let refused = text.parse::<Share>().unwrap_err();
        assert!(refused.starts_with(expected), "{text}: {refused}");
    }
}
