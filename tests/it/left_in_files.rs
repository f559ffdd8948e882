//! What a run leaves beside its results: what it was made from, how many rows ended how, folders; and what is left alone.

use std::collections::BTreeMap;

use kinetostat::{
    files::{Foreign, Manifest, PreparedFolder, Recorded, StatusCount, may_replace},
    input::Inputs,
};

fn keys(study: &str, machine: &str) -> BTreeMap<(String, String), String> {
    Recorded::by_part(&Recorded::of(&Inputs::of("study.toml", study).and(Inputs::of("arm", machine))))
}

#[test]
fn a_foot_is_found_by_its_name_and_comments_do_not_count() {
    let machine = |height: f64| {
        format!(
            "# a comment of {height}\n[[chain]]\nname = \"leg\"\nelements = [\n  {{ fixed = {{ x = 1 }} }},\n  \
             {{ beam = {{ name = \"foot\", section = {{ height_mm = {height:.1} }} }} }} ]\n"
        )
    };
    let (a, b) = (keys("machine = \"arm\"", &machine(20.0)), keys("machine = \"arm\" # same", &machine(22.0)));
    let changed: Vec<_> = a.iter().filter(|(key, value)| b.get(*key) != Some(value)).collect();
    let key = ("machine".to_string(), "chain.leg.elements.foot.beam.section.height_mm".to_string());
    assert_eq!(changed, [(&key, &"20.0".to_string())]);
    assert_eq!(b[&key], "22.0");
    assert_eq!(a[&("machine".into(), "chain.leg.elements.1.fixed.x".into())], "1");
}

#[test]
fn a_process_is_the_same_in_a_study_and_in_a_file() {
    let within = keys("[process.force]\nlaw = \"printed\"", "");
    let study = Inputs::of("study.toml", "process = \"p.toml\"").and(Inputs::of("arm", ""));
    let apart = Recorded::by_part(&Recorded::of(&study.and(Inputs::of("p.toml", "[force]\nlaw = \"printed\""))));
    let key = ("process".to_string(), "force.law".to_string());
    assert_eq!((within[&key].as_str(), apart[&key].as_str()), ("printed", "printed"));
}

#[test]
fn a_path_is_known_by_its_hash() {
    let inputs = Inputs::of("study.toml", "").and(Inputs::of("arm", "")).and(Inputs::of("part.nc", "G0 X1\nG1 X2\n"));
    let keys = Recorded::by_part(&Recorded::of(&inputs.and(Inputs::of("points of the path", "73"))));
    assert!(keys[&("part.nc".into(), String::new())].starts_with("part.nc (SHA-256 "));
    assert_eq!(keys[&("points of the path".into(), String::new())], "73");
}

#[test]
fn what_was_made_and_stays_empty_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    let (outer, inner) = (folder.path().join("new"), folder.path().join("new/inner"));
    drop(PreparedFolder::new(&inner).unwrap());
    assert!(!outer.exists() && folder.path().exists());
    let prepared = PreparedFolder::new(&inner).unwrap();
    std::fs::write(outer.join("result"), "").unwrap();
    drop(prepared);
    assert!(outer.exists() && !inner.exists());
    std::fs::create_dir(&inner).unwrap();
    drop(PreparedFolder::new(&inner).unwrap());
    assert!(inner.exists(), "it was there before");
}

#[test]
fn what_is_not_solved_is_counted_by_its_status_most_frequent_first() {
    let statuses = ["solved", "unreachable", "slow", "converged", "slow", "no_equilibrium"];
    let counts = Manifest::count(statuses.into_iter());
    let expected = "4 of 6 not solved: 2 slow, 1 unreachable, 1 no equilibrium.";
    assert_eq!(StatusCount::unsolved(&counts).as_deref(), Some(expected));
    assert_eq!(StatusCount::unsolved(&counts[..1]), None);
}

#[cfg(unix)]
#[test]
fn links_and_devices_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("map.csv");
    std::os::unix::fs::symlink("/etc/hostname", &link).unwrap();
    let error = may_replace(&link, Foreign::Replaced, || true).unwrap_err().to_string();
    assert!(error.contains("map.csv: cannot be written: is a link"), "{error}");
    let error = may_replace(std::path::Path::new("/dev/null"), Foreign::Replaced, || true).unwrap_err().to_string();
    assert!(error.contains("/dev/null: cannot be written: is a device"), "{error}");
}
