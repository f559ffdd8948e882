//! The questions that a study file asks, a folder each: as written (`spec`), checked ([`Study`]), run, and reported.
//!
//! Each has one line in the list below; those that pages do not ask are left out of the WebAssembly build. What is cut along a toolpath
//! stands in a process file ([`crate::process::file`]) or in the same tables of the study. A study is a folder with a `study.toml`; its
//! inputs are named relative to that folder.

pub mod over_workspace;
mod question;
pub(crate) mod resolve;
pub(crate) mod spec;
#[cfg(feature = "report")]
pub(crate) mod spread_report;
#[cfg(feature = "report")]
mod template;

#[cfg(feature = "report")]
pub use question::Answered;
pub use question::{Overrides, Question, Resolved, StudyContext, Template};

#[cfg(feature = "report")]
pub use template::StudyMachine;

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    path::Path,
};

use crate::{
    input::{Folder, Inputs, check::Check, error::Result},
    process::uncertainty::spec::UncertaintySpec,
};

question::questions! {
    /// A checked study of one of the questions, with the display settings of its report.
    #[derive(Debug, Clone)]
    pub enum StudyKind {
        workspace_map: WorkspaceMap(map::WorkspaceMapStudy),
        path: Path(path::PathStudy),
        placement: Placement(placement::PlacementStudy),
        superposition: Superposition(superposition::SuperpositionStudy),
        validation: Validation(validation::ValidationStudy),
        online: Online(online::OnlineStudy),
        redundancy_map: RedundancyMap(redundancy_map::RedundancyMapStudy),
        identification: Identification(identification::IdentificationStudy),
        measurement_design: MeasurementDesign(measurement_design::MeasurementDesignStudy),
    }

    /// A study file as written: the keys of every study, and under its key the table of the question.
    #[derive(Debug, Clone, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    pub(crate) struct StudySpec {
        schema: u32,
        question: String,
        machine: String,
        branch: Option<String>,
        #[serde(default)]
        locked: BTreeMap<String, f64>,
        process: Option<spec::ProcessRef>,
        uncertainty: Option<UncertaintySpec>,
    }
}

/// A checked study, ready to run.
#[derive(Debug, Clone)]
pub struct Study {
    /// Name of the study's folder; results are written under it.
    pub name: String,
    /// The question that the study answers, one sentence.
    pub question: String,
    /// Everything that determines the results: files and overrides.
    pub inputs: Inputs,
    /// The checked study of its kind: what to compute.
    pub kind: StudyKind,
    /// Text of the study and the files read for it, by names relative to its folder; see [`crate::explore::Scene`].
    pub files: StudyFiles,
}

/// The files from which a study was read.
#[derive(Debug, Clone, Default)]
pub struct StudyFiles {
    /// Text of the study file.
    pub text: String,
    /// Contents of the files that the study names, and of those that they name, by name.
    pub named: BTreeMap<String, Vec<u8>>,
}

impl Study {
    /// Reads and checks the study in `path`: a folder with a `study.toml`, or the file itself; `overrides` replace its settings.
    ///
    /// # Errors
    /// A file that cannot be read, is not of the expected form, or holds values that make no sense.
    pub fn open(path: &Path, overrides: &Overrides) -> Result<Study> {
        let file = if path.is_dir() { path.join("study.toml") } else { path.to_path_buf() };
        let text = crate::input::toml_file::read(&file)?;
        let folder = file.parent().map(Path::to_path_buf).unwrap_or_default();
        Self::from_toml(&text, &file.display().to_string(), folder, overrides)
    }

    /// Checks a study given as TOML `text`, called `origin` in errors; its file names are relative to `folder`. `Err` as [`Study::open`].
    pub fn from_toml(text: &str, origin: &str, folder: impl Into<Folder>, overrides: &Overrides) -> Result<Study> {
        let (folder, check) = (folder.into().recording(), Check::collecting(origin));
        let spec: StudySpec = spec::parse(text, origin)?;
        let (header, table) = spec.split(&check)?;
        let study = Self::resolved(text, origin, &folder, &header, &table, overrides, &check);
        let named = folder.recorded();
        let study = check.with_misfits(study, &format!("machine {}", header.machine), |file| match file == origin {
            true => Some(text),
            false => {
                let read = named.iter().find(|(name, _)| folder.path(name).display().to_string() == file);
                read.and_then(|(_, bytes)| std::str::from_utf8(bytes).ok())
            }
        })?;
        Ok(Study { files: StudyFiles { text: text.into(), named }, ..study })
    }

    /// Checks the keys `header` that all studies have, and the `table` of the question; returns the study without its files.
    fn resolved(
        text: &str,
        origin: &str,
        folder: &Folder,
        header: &spec::Header,
        table: &question::AskedTable,
        overrides: &Overrides,
        check: &Check,
    ) -> Result<Study> {
        let (machine, machine_text) = resolve::resolve_header(header, folder, overrides, check)?;
        let branch_input = overrides.branch.map_or_else(Inputs::default, |branch| Inputs::of("branch", branch.label()));
        let inputs = Inputs::of_file(origin, text).and(Inputs::of(&header.machine, machine_text)).and(branch_input);
        let inputs = inputs
            .and(overrides.redundancy.map_or_else(Inputs::default, |choice| Inputs::of("redundancy", choice.label())));
        let context = StudyContext {
            machine,
            folder,
            overrides,
            check: check.clone(),
            name: "",
            header,
            is_process_read: Cell::new(false),
            is_uncertainty_read: Cell::new(false),
            uncertainty_of_process: RefCell::default(),
        };
        let (kind, settings) = table(context)?;
        Ok(Study {
            name: resolve::folder_name(folder.root()),
            question: header.question.trim().to_string(),
            inputs: inputs.and(settings),
            kind,
            files: StudyFiles::default(),
        })
    }
}
