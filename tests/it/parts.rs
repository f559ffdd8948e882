//! Studies computed in parts: what all parts give together has the bytes of a single run, and what does not belong
//! together is refused.

use std::{
    fs,
    path::Path,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
};

use kinetostat::{
    Error, Event, Overrides, RunOptions, Study,
    run::{
        Start,
        parts::{PartInFolder, PartOptions, StudySource, read_parts},
    },
    work::{
        part_file::{Part, PartSource},
        share::Share,
    },
};
use proptest::prelude::*;

use crate::support::{
    cases::cases,
    command::{printed, told},
    placement::short_placement,
    results::{assert_same, contents},
};

/// A workspace map that is cheap per point, in three blocks.
const MAP: &str = r#"
schema = 3
question = "How far?"
machine = "orthoglide"
[workspace_map]
grid = [22, 21, 20]
slices_z_mm = [0.0]
phi_step_deg = 360.0
[process.force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
"#;

const SUPERPOSITION: &str = r#"
schema = 3
question = "May they be added?"
machine = "orthoglide"
[process.force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
[[process.chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0
[superposition]
grid = [5, 4, 4]
slices_z_mm = [0.0]
phi_step_deg = 120.0
tolerance_mm = 0.01
location = [{ point = "Q0" }, { point = "Q1" }]
"#;

/// How this program is called in the files of these tests.
const PROGRAM: &str = "these tests";

fn stop() -> Arc<AtomicBool> {
    Arc::default()
}

fn share(part: u32, of: u32) -> Share {
    Share::new(part, of).unwrap()
}

/// Does `work` on so many threads.
fn on<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// All files of a folder.
/// A folder of the study `toml`, and the study.
fn written(folder: &Path, toml: &str) -> Study {
    let study = folder.join("study");
    fs::create_dir_all(&study).unwrap();
    fs::write(study.join("study.toml"), toml).unwrap();
    Study::open(&study, &Overrides::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The study that `new TEMPLATE` writes, with some of its text replaced.
fn new(folder: &Path, template: &str, changes: &[(&str, &str)]) -> Study {
    let study = folder.join("study");
    printed(&["new", template, study.to_str().unwrap()]);
    let file = study.join("study.toml");
    let mut text = fs::read_to_string(&file).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{template}: {from}");
        text = text.replace(from, to);
    }
    fs::write(&file, text).unwrap();
    Study::open(&study, &Overrides::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn coming_with(name: &str, overrides: &Overrides) -> Study {
    Study::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(name), overrides).unwrap()
}

fn options(figures: bool) -> RunOptions {
    RunOptions { figures, program: Some(PROGRAM.into()), ..RunOptions::default() }
}

/// The parts of a round as bytes; `before` are those of the rounds before.
fn computed(study: &Study, of: u32, before: &[Vec<u8>], threads: usize) -> Vec<Vec<u8>> {
    let part =
        |number| on(threads, || study.part(share(number, of), read(before), Some(PROGRAM), stop(), |_| ())).unwrap();
    (1..=of).map(part).collect()
}

fn read(parts: &[Vec<u8>]) -> Vec<Part> {
    let source =
        |(number, bytes): (usize, &Vec<u8>)| PartSource::Bytes(format!("bytes {number}"), bytes.clone().into());
    parts.iter().enumerate().map(source).map(|source| Part::read(source).unwrap()).collect()
}

/// Merges into `out`; the number of items that were computed then.
fn merged(study: &Study, parts: &[Vec<u8>], out: &Path, figures: bool, threads: usize) -> usize {
    let computed = Arc::new(Mutex::new(0));
    let count = Arc::clone(&computed);
    let watch = move |event| {
        if let Event::Computed(items) = event {
            *count.lock().unwrap() += items;
        }
    };
    on(threads, || study.merge_into(read(parts), out, &options(figures), stop(), watch)).unwrap();
    *computed.lock().unwrap()
}

/// Computes the study alone and in so many parts, on one and two threads, and holds what is left against each other.
fn holds(folder: &Path, study: &Study, divisions: &[u32], figures: bool) {
    let whole = folder.join("whole");
    study.run_into(&whole, &options(figures), stop(), |_| ()).unwrap();
    for (number, &of) in divisions.iter().enumerate() {
        let (threads, out) = (1 + number % 2, folder.join(format!("of_{of}")));
        let parts = computed(study, of, &[], threads);
        let computed = merged(study, &parts, &out, figures, 3 - threads);
        assert_same(&out, &whole, &format!("{} in {of} parts", study.name));
        if study.kind.goes_in_rounds() {
            assert_eq!(read(&parts).iter().all(|part| part.head().is_complete), of == 1);
        } else {
            assert_eq!(computed, 0, "{} in {of} parts: computed in the merge", study.name);
        }
    }
}

#[test]
fn a_map_in_parts_is_the_whole_map() {
    let folder = tempfile::tempdir().unwrap();
    let study = written(folder.path(), MAP);
    assert_eq!(study.kind.pieces(), 3);
    let (drawn, tables): (&[u32], &[u32]) = if cases(1).cases > 1 { (&[1, 2, 3, 7], &[]) } else { (&[3], &[1, 2, 7]) };
    holds(&folder.path().join("drawn"), &study, drawn, true);
    holds(&folder.path().join("tables"), &study, tables, false);
}

#[test]
fn a_superposition_in_parts_is_the_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let study = written(folder.path(), SUPERPOSITION);
    assert_eq!(study.kind.pieces(), 5 + 2);
    holds(folder.path(), &study, &[1, 2, 3, 7], false);
}

#[test]
fn a_path_in_parts_is_the_whole_path() {
    let folder = tempfile::tempdir().unwrap();
    let study = coming_with(
        "02_groove_50mm",
        &Overrides { points: Some(cases(400).cases.min(600) as usize), ..Overrides::default() },
    );
    assert_eq!(study.kind.pieces() % 3, 0);
    holds(folder.path(), &study, &[1, 2, 3, 7], false);
}

const UNCERTAIN_PATH: &str = r#"
schema = 3
question = "How far from the path?"
machine = "orthoglide"
[uncertainty]
machine = "provenance"
[uncertainty.process]
force_relative_std = 0.15
[path]
circle = { centre_mm = [0.0, 0.0, 0.0], diameter_mm = 60.0, points = 530 }
methods = ["direct"]
[process.force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
"#;

#[test]
fn a_path_with_uncertain_inputs_in_parts_is_the_whole_path() {
    let folder = tempfile::tempdir().unwrap();
    let study = written(folder.path(), UNCERTAIN_PATH);
    assert_eq!(study.kind.pieces(), 3 * (2 * 3 + 1 + 1));
    holds(folder.path(), &study, &[2, 7], false);
}

#[test]
fn a_validation_in_parts_is_the_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let study = coming_with("06_paper", &Overrides { points: Some(24), ..Overrides::default() });
    holds(folder.path(), &study, &[1, 2, 3, 7], false);
}

#[test]
fn a_map_of_turns_in_parts_is_the_whole_map() {
    let folder = tempfile::tempdir().unwrap();
    let study = new(folder.path(), "redundancy", &[("gamma_step_deg = 15.0", "gamma_step_deg = 90.0")]);
    holds(folder.path(), &study, &[1, 2, 3, 7], false);
}

#[test]
fn an_online_study_in_parts_is_the_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let changes = [("points = 121", "points = 13"), ("seeds = 20", "seeds = 3")];
    let study = new(folder.path(), "online", &changes);
    holds(folder.path(), &study, &[1, 2, 3, 7], false);
}

fn placement(folder: &Path) -> Study {
    Study::open(&short_placement(folder), &Overrides::default()).unwrap()
}

#[test]
fn a_placement_in_parts_is_the_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let study = placement(folder.path());
    assert!(study.kind.goes_in_rounds());
    holds(folder.path(), &study, &[1, 2, 3, 7], false);
}

#[test]
fn a_placement_in_rounds_leaves_nothing_to_the_merge() {
    let folder = tempfile::tempdir().unwrap();
    let study = placement(folder.path());
    let whole = folder.path().join("whole");
    study.run_into(&whole, &options(false), stop(), |_| ()).unwrap();
    let (mut all, mut rounds) = (Vec::new(), 0);
    loop {
        rounds += 1;
        let parts = computed(&study, 3, &all, 1 + rounds % 2);
        let heads: Vec<_> = read(&parts).iter().map(|part| part.head().clone()).collect();
        assert!(heads.iter().all(|head| head.round == rounds as u32));
        all.extend(parts);
        if heads.iter().all(|head| head.is_complete) {
            break;
        }
        assert!(heads.iter().map(|head| head.pieces).sum::<u64>() > 0, "round {rounds} brought nothing");
        assert!(rounds < 30);
    }
    let out = folder.path().join("merged");
    merged(&study, &all, &out, false, 1);
    assert_same(&out, &whole, &format!("{rounds} rounds"));
    // Of rounds that are there only in part, nothing is taken.
    let last = all.len() - 1;
    let refused = study.merge_into(read(&all[..last]), &folder.path().join("no"), &options(false), stop(), |_| ());
    let expected = format!("part 3 of 3 of round {rounds}: is missing: expected all 3, got 2");
    assert_eq!(refused.unwrap_err().to_string(), expected);
}

/// A part of a later round is given what it needs: bounds, verdicts and ends of searches, not all evaluations that led to them.
#[test]
fn rounds_from_excerpts_are_the_whole_placement_and_take_few_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for (name, front) in [("best", ""), ("front", "pareto = [\"worst_deflection\", \"worst_correction\"]\n")] {
        let own = folder.path().join(name);
        let file = short_placement(&own).join("study.toml");
        let text = fs::read_to_string(&file).unwrap();
        let (before, behind) = text.split_once("pareto = [\"worst_deflection\", \"worst_correction\"]\n").unwrap();
        fs::write(&file, [before, front, behind].concat()).unwrap();
        let study = Study::open(&file, &Overrides::default()).unwrap();
        let whole = own.join("whole");
        study.run_into(&whole, &options(false), stop(), |_| ()).unwrap();
        let (mut all, mut excerpts): (Vec<Vec<u8>>, Vec<Vec<u8>>) = (Vec::new(), Vec::new());
        let mut sent_of_all = 0;
        loop {
            if !all.is_empty() {
                sent_of_all += all.iter().map(Vec::len).sum::<usize>();
                excerpts.push(study.excerpt(read(&all), Some(PROGRAM), stop()).unwrap());
            }
            let parts = computed(&study, 3, excerpts.last().map(std::slice::from_ref).unwrap_or_default(), 2);
            let is_complete = read(&parts).iter().all(|part| part.head().is_complete);
            all.extend(parts);
            if is_complete {
                break;
            }
        }
        let out = own.join("merged");
        merged(&study, &all, &out, false, 1);
        assert_same(&out, &whole, name);
        let sent: usize = excerpts.iter().map(Vec::len).sum();
        println!(
            "{name}: a part is sent {sent} bytes in {} rounds, {sent_of_all} with all that was found",
            excerpts.len()
        );
        assert!(5 * sent < 2 * sent_of_all, "{name}: {sent} of {sent_of_all}");
        let last = excerpts.last().unwrap().clone();
        let refused =
            study.merge_into(read(std::slice::from_ref(&last)), &own.join("no"), &options(false), stop(), |_| ());
        let expected = format!("bytes 0: is what round {} needs of the parts before", excerpts.len() + 1);
        assert!(refused.unwrap_err().to_string().starts_with(&expected));
        let other = study.part(share(1, 4), read(&[last]), Some(PROGRAM), stop(), |_| ()).unwrap_err().to_string();
        assert_eq!(other, "part: expected one of 3 parts, as in the rounds before, got 1 of 4");
    }
}

#[test]
fn a_part_has_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    for study in [written(folder.path(), SUPERPOSITION), placement(folder.path())] {
        assert!(computed(&study, 3, &[], 1) == computed(&study, 3, &[], 2), "{}", study.name);
    }
}

#[test]
fn any_order_of_any_number_of_parts_is_the_same_whole() {
    let folder = tempfile::tempdir().unwrap();
    let study = written(folder.path(), &SUPERPOSITION.replace("grid = [5, 4, 4]", "grid = [3, 3, 2]"));
    let whole = folder.path().join("whole");
    study.run_into(&whole, &options(false), stop(), |_| ()).unwrap();
    let orders = (1u32..=12).prop_flat_map(|of| Just((1..=of).collect::<Vec<u32>>()).prop_shuffle());
    proptest!(cases(8), |(order in orders)| {
        let parts = computed(&study, order.len() as u32, &[], 1);
        let shuffled: Vec<Vec<u8>> = order.iter().map(|number| parts[*number as usize - 1].clone()).collect();
        let out = folder.path().join("merged");
        merged(&study, &shuffled, &out, false, 2);
        assert_same(&out, &whole, &format!("{order:?}"));
    });
}

#[test]
fn what_does_not_belong_together_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let study = written(folder.path(), SUPERPOSITION);
    let parts = computed(&study, 3, &[], 2);
    let named = |number: usize, bytes: &[u8]| Part::read(PartSource::Bytes(format!("part_{number}"), bytes.into()));
    let all = |numbers: &[usize]| -> Vec<Part> { numbers.iter().map(|&k| named(k, &parts[k - 1]).unwrap()).collect() };
    let out = folder.path().join("out");
    let refused = |parts: Vec<Part>, study: &Study, expected: &str| {
        let error = study.merge_into(parts, &out, &options(false), stop(), |_| ()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\nexpected {expected}");
        assert!(!out.exists(), "{:?}", contents(&out).keys());
    };
    refused(all(&[1, 3]), &study, "part 2 of 3: is missing: expected all 3, got 2");
    refused(all(&[3]), &study, "parts 1, 2 of 3: are missing: expected all 3, got 1");
    refused(Vec::new(), &study, "expected all parts of a study, got none");
    refused(all(&[1, 2, 2, 3]), &study, "part_2: is part 2 of 3, which part_2 is, too");
    let mut mixed = all(&[1, 2]);
    mixed.push(named(9, &computed(&study, 2, &[], 1)[1]).unwrap());
    refused(mixed, &study, "part_9: is part 2 of 2, part_1 is part 1 of 3: expected parts of one division");
    let other = written(folder.path(), &SUPERPOSITION.replace("= 215.0", "= 216.0"));
    refused(
        all(&[1, 2, 3]),
        &other,
        "part_1: is a part of study and was computed from other inputs: its study.toml has the SHA-256 ",
    );
    let foreign = study.part(share(2, 3), Vec::new(), Some("version 0"), stop(), |_| ()).unwrap();
    let mut mixed = all(&[1, 3]);
    mixed.push(named(2, &foreign).unwrap());
    refused(mixed, &study, "part_2: was computed by version 0, this program is these tests");
    // Files that are not whole.
    let whole = &parts[0];
    let fault = |bytes: &[u8]| named(1, bytes).unwrap_err().to_string();
    for cut in 0..whole.len() {
        let said = fault(&whole[..cut]);
        assert!(said.contains("is cut short or damaged"), "{cut}: {said}");
    }
    let last_piece = fault(&whole[..whole.len() - 1]);
    assert!(last_piece.contains("pieces of part 1 of 3 are whole; compute that part again"), "{last_piece}");
    for place in (0..whole.len()).step_by(7) {
        let mut damaged = whole.clone();
        damaged[place] ^= 4;
        fault(&damaged);
    }
    let longer = fault(&[&whole[..], b"?"].concat());
    assert!(longer.contains("has 1 bytes behind its end"), "{longer}");
}

#[test]
fn a_part_is_stopped_and_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    let study = written(folder.path(), SUPERPOSITION);
    let out = folder.path().join("parts");
    let asked = |begin| PartOptions { begin, program: Some(PROGRAM.into()), opened: StudySource::default(), round: 1 };
    let part = |begin, stop: Arc<AtomicBool>| {
        let flag = Arc::clone(&stop);
        let watch = move |event| {
            if event == (Event::Shard { is_kept: false }) {
                flag.store(true, Ordering::Relaxed);
            }
        };
        on(1, || study.part_into(share(1, 2), &out, &asked(begin), stop, watch))
    };
    assert!(matches!(part(Start::New, stop()), Err(Error::Stopped)));
    assert!(contents(&out).keys().eq(["part_0001_of_0002.state"]));
    let error = part(Start::New, stop()).unwrap_err().to_string();
    assert!(error.contains("part_0001_of_0002.state: holds what an unfinished run has computed"), "{error}");
    // Each attempt ends one piece.
    let stops = (0..study.kind.pieces()).take_while(|_| part(Start::Resume, stop()).is_err()).count();
    assert!((1..4).contains(&stops), "stopped {stops} times more");
    let file = out.join("part_0001_of_0002.kpart");
    assert!(contents(&out).keys().eq(["part_0001_of_0002.kpart"]));
    assert!(read(&[fs::read(&file).unwrap()])[0].head().opened.contains("overrides"));
    let there = part(Start::New, stop()).unwrap();
    assert_eq!(there, PartInFolder { file: file.clone(), was_there: true, is_complete: false });
    let other = written(folder.path(), &SUPERPOSITION.replace("= 215.0", "= 216.0"));
    let error = other.part_into(share(1, 2), &out, &asked(Start::New), stop(), |_| ()).unwrap_err().to_string();
    assert!(error.contains("was computed from other inputs: its study.toml"), "{error}");
    fs::rename(&file, out.join("part_0002_of_0002.kpart")).unwrap();
    let error = study.part_into(share(2, 2), &out, &asked(Start::New), stop(), |_| ()).unwrap_err().to_string();
    assert!(error.contains("is part 1 of 2, expected part 2 of 2"), "{error}");
    let later = PartOptions { round: 2, ..asked(Start::New) };
    let error = study.part_into(share(1, 2), &out, &later, stop(), |_| ()).unwrap_err().to_string();
    assert!(error.contains("part 2 of 2: is missing"), "{error}");
}

#[test]
fn the_commands_share_and_merge_by_folder_and_file() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path(), SUPERPOSITION);
    let path = |name: &str| folder.path().join(name).display().to_string();
    let study = path("study");
    printed(&["run", &study, "--grid", "3", "--out", &path("whole")]);
    let said = printed(&["run", &study, "--grid", "3", "--part", "1/2", "--out", &path("a"), "--threads", "1"]);
    assert!(said.starts_with("Part 1 of 2 of study, 2 pieces of 4, in "), "{said}");
    assert!(said.contains(&format!("With all 2 parts: kinetostat merge {}", path("a"))), "{said}");
    let said = printed(&["run", &study, "--grid", "3", "--part", "1/2", "--out", &path("a")]);
    assert!(said.contains("is there already"), "{said}");
    let (_, _, progress) =
        told(&["run", &study, "--grid", "3", "--part", "2/2", "--out", &path("b"), "--progress", "json"]);
    let last: serde_json::Value = serde_json::from_str(progress.lines().last().unwrap()).unwrap();
    assert_eq!((&last["event"], &last["part"], &last["parts"]), (&"finished".into(), &2.into(), &2.into()));
    assert!(progress.contains(r#""done":2"#) && progress.contains(r#""of":"pieces""#), "{progress}");
    let second = path("b/part_0002_of_0002.kpart");
    printed(&["merge", &second, &path("a"), "--out", &path("merged")]);
    assert_same(Path::new(&path("merged")), Path::new(&path("whole")), "by the commands");
    assert_eq!(read_parts(Path::new(&path("a"))).unwrap().len(), 1);

    let refused = |arguments: &[&str], expected: &str| {
        let (code, _, said) = told(arguments);
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(code, Some(2), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}\nexpected {expected}");
    };
    let out = path("refused");
    for (part, expected) in [
        ("0/3", "of 3 expected a part from 1 to 3, got 0"),
        ("4/3", "of 3 expected a part from 1 to 3, got 4"),
        ("x/y", "expected i/n such as 3/10: the third of ten parts"),
        ("-1/3", "expected i/n such as 3/10"),
    ] {
        refused(&["run", &study, "--part", part, "--out", &out], expected);
    }
    refused(&["run", &study, &path("other"), "--part", "1/2"], "--part: is of one study, got 2");
    refused(&["run", &study, "--part", "1/2", "--no-figures"], "cannot be used with");
    refused(&["run", &study, "--round", "2"], "--part");
    refused(
        &["run", &study, "--part", "1/2", "--round", "2", "--out", &out],
        "--round: expected 1, got 2: study study is shared",
    );
    let (of, never) = (path("a"), path("never"));
    refused(&["merge", &of, "--out", &never], &format!("{of}: part 2 of 2: is missing: expected all 2, got 1"));
    assert!(!Path::new(&never).exists());
    refused(&["merge", &path("study"), "--out", &out], "has no part files (part_….kpart)");
    refused(&["merge", &path("none"), "--out", &out], "cannot be read");
    refused(&["merge", &path("study/study.toml"), "--out", &out], "study.toml: is not a part of a study");
    // The study is elsewhere now.
    fs::rename(folder.path().join("study"), folder.path().join("moved")).unwrap();
    refused(&["merge", &second, &path("a"), "--out", &out], "say where the study is now");
    printed(&["merge", &second, &path("a"), "--study", &path("moved"), "--no-figures", "--out", &path("of_moved")]);
    let text = SUPERPOSITION.replace("= 215.0", "= 216.0");
    fs::write(folder.path().join("moved/study.toml"), text).unwrap();
    refused(
        &["merge", &second, &path("a"), "--study", &path("moved"), "--out", &out],
        "was computed from other inputs",
    );
}
