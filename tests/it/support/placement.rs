//! Placement studies from text.

use std::{
    fs,
    path::{Path, PathBuf},
};

use kinetostat::{
    input::error::Result,
    questions::{
        Overrides, Study, StudyKind,
        placement::{PlacementResults, PlacementStudy, run},
    },
    work::Work,
};

pub fn study_in(folder: &Path, toml: &str) -> Result<PlacementStudy> {
    match Study::from_toml(toml, "study.toml", folder, &Overrides::default())?.kind {
        StudyKind::Placement(placement, ()) => Ok(*placement),
        other => panic!("not a placement study: {other:?}"),
    }
}

/// The study of a circle whose sweep, searches and front are short, in `folder`/study.
pub fn short_placement(folder: &Path) -> PathBuf {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/03_placement_circle");
    let toml = fs::read_to_string(from.join("study.toml")).unwrap();
    let few = toml
        .replace("grid = { x = 9, y = 9, z = 5 }", "grid = { x = 4, y = 4, z = 3 }")
        .replace("starts = 3", "starts = 1")
        .replace("max_iterations = 80", "max_iterations = 4")
        .replace("points = 121", "points = 25");
    assert_ne!(few, toml);
    let study = folder.join("study");
    fs::create_dir_all(&study).unwrap();
    fs::copy(from.join("process.toml"), study.join("process.toml")).unwrap();
    fs::write(study.join("study.toml"), few).unwrap();
    study
}

pub fn searched(study: &PlacementStudy) -> PlacementResults {
    run(study, &Work::default()).unwrap()
}
