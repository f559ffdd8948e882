//! A placement study or a map read for a page: the same keys and checks as [`crate::questions::Study`] has, without those of other questions.

use std::{cell::Cell, collections::BTreeMap};

use serde::Deserialize;

use super::{STUDY, Scene};
use crate::{
    input::{Folder, check::Check, error::Result},
    machine::Machine,
    questions::{
        Given, Overrides, Question,
        map::{WorkspaceMapStudy, spec::WorkspaceMapSpec},
        placement::{PlacementStudy, spec::PlacementStudySpec},
        resolve,
        spec::{self, Header, ProcessRef, SCHEMA},
    },
};

/// A study as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    schema: u32,
    question: String,
    machine: String,
    branch: Option<String>,
    #[serde(default)]
    held: BTreeMap<String, f64>,
    process: Option<ProcessRef>,
    placement: Option<PlacementStudySpec>,
    workspace_map: Option<WorkspaceMapSpec>,
}

/// What a page can ask.
pub(super) enum Asked {
    /// Where the workpiece should stand.
    Placement(Box<PlacementStudy>),
    /// How far the tool moves.
    Map(Box<WorkspaceMapStudy>),
}

/// The study `text`, whose files are in `folder`, and its machine without the tool of a process.
///
/// # Errors
/// As [`crate::questions::Study::from_toml`].
pub(super) fn read(text: &str, folder: &Folder, overrides: &Overrides) -> Result<(Machine, Asked)> {
    let written: Written = spec::parse(text, STUDY)?;
    let Written { schema, question, machine, branch, held, process, placement, workspace_map } = written;
    let header = Header { schema, question, machine, branch, held, process };
    let check = Check::new(STUDY);
    let (machine, _) = resolve::header(&header, folder, overrides, &check)?;
    let given = |check: Check, name: &'static str| Given {
        machine: machine.clone(),
        folder,
        overrides,
        check,
        name,
        header: &header,
        asked_process: Cell::new(false),
    };
    let asked = match (placement, workspace_map) {
        (Some(spec), None) => {
            let study = resolved::<PlacementStudy>(&spec, given(check.key("placement"), PlacementStudy::NAME))?;
            Asked::Placement(Box::new(study))
        }
        (None, Some(spec)) => {
            let study = resolved(&spec, given(check.key("workspace_map"), WorkspaceMapStudy::NAME))?;
            Asked::Map(Box::new(study))
        }
        _ => return check.fail("expected one table, placement or workspace_map".into()),
    };
    Ok((machine, asked))
}

/// The placement study `text`, as [`read`].
///
/// # Errors
/// As [`read`], and of a map.
pub(super) fn read_placement(text: &str, folder: &Folder, overrides: &Overrides) -> Result<PlacementStudy> {
    match read(text, folder, overrides)?.1 {
        Asked::Placement(study) => Ok(*study),
        Asked::Map(_) => Check::new(STUDY).key("placement").fail("missing".into()),
    }
}

fn resolved<Q: Question>(spec: &Q::Spec, given: Given<'_>) -> Result<Q> {
    let resolved = Q::resolve(spec, &given)?;
    given.refuse_unused()?;
    Ok(resolved.study)
}

/// The machine of a scene without a study.
///
/// # Errors
/// There is no such machine, or its file is not of the expected form.
pub(super) fn machine(scene: &Scene, folder: &Folder, overrides: &Overrides) -> Result<Machine> {
    let header = Header {
        schema: SCHEMA,
        question: "explored".into(),
        machine: scene.machine.clone(),
        branch: None,
        held: BTreeMap::new(),
        process: None,
    };
    Ok(resolve::header(&header, folder, overrides, &Check::new(STUDY))?.0)
}
