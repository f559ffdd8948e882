//! A placement study read for a page: the same keys and checks as [`crate::study::Study`] has, without those of other questions.

use std::{cell::Cell, collections::BTreeMap};

use serde::Deserialize;

use super::{STUDY, Scene};
use crate::{
    input::{Folder, check::Check, error::Result, toml_file},
    machine::Machine,
    process::file::chain_errors::ChainErrorSpec,
    study::{
        Given, Overrides, Question,
        placement::{PlacementStudy, spec::PlacementStudySpec},
        resolve,
        spec::{Header, MillingSpec, ProcessRef, SCHEMA},
    },
};

/// A placement study as written.
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
    milling: Option<MillingSpec>,
    chain_error: Option<Vec<ChainErrorSpec>>,
    placement: PlacementStudySpec,
}

impl Written {
    fn split(self) -> (Header, PlacementStudySpec) {
        let Self { schema, question, machine, branch, held, process, milling, chain_error, placement } = self;
        (Header { schema, question, machine, branch, held, process, milling, chain_error }, placement)
    }
}

/// The study `text`, whose files are in `folder`, and its machine without the tool of a process.
///
/// # Errors
/// As [`crate::study::Study::from_toml`].
pub(super) fn read(text: &str, folder: &Folder, overrides: &Overrides) -> Result<(Machine, PlacementStudy)> {
    let check = Check::new(STUDY);
    let (header, placement) = toml_file::parse::<Written>(text, STUDY)?.split();
    let (machine, _) = resolve::header(&header, folder, overrides, &check)?;
    let given = Given {
        machine: machine.clone(),
        folder,
        overrides,
        check: check.key("placement"),
        name: PlacementStudy::NAME,
        header: &header,
        asked_process: Cell::new(false),
        asked_map_keys: Cell::new(false),
    };
    let resolved = PlacementStudy::resolve(&placement, &given)?;
    given.refuse_unused()?;
    Ok((machine, resolved.study))
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
        milling: None,
        chain_error: None,
    };
    Ok(resolve::header(&header, folder, overrides, &Check::new(STUDY))?.0)
}
