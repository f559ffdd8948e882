//! Placement studies from text.

use std::path::Path;

use kinetostat::{
    input::error::Result,
    study::{
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

pub fn searched(study: &PlacementStudy) -> PlacementResults {
    run(study, &Work::default()).unwrap()
}
