//! The questions: a study file as written ([`spec`]), checked ([`Study`]), run, and its plain results.
//!
//! Each question is a folder: spec, resolve, run and report. What is cut along a toolpath is said in a process file
//! ([`crate::process::file`]).
//!
//! A study is a folder with a `study.toml`; its inputs are named relative to that folder.

pub mod along_path;
pub mod bounded_pass;
pub mod deflected_pose;
mod failure;
pub mod machine_check;
pub mod map;
pub mod path;
pub mod placement;
pub mod point;
pub mod program;
pub(crate) mod resolve;
mod source;
pub mod spec;
pub mod superposition;
pub mod validation;

use std::path::Path;

pub use failure::{Failure, SOLVED, status_of};
use map::WorkspaceMapStudy;
use path::PathStudy;
use placement::PlacementStudy;
pub use resolve::Overrides;
pub use source::Source;
use superposition::SuperpositionStudy;
use validation::ValidationStudy;

use crate::{input::error::Result, work::Inputs};

/// A checked study, ready to run.
#[derive(Debug, Clone)]
pub struct Study {
    /// Name of its folder; results are written under it.
    pub name: String,
    /// The question it answers.
    pub question: String,
    /// What decides its results.
    pub inputs: Inputs,
    /// What to compute.
    pub kind: StudyKind,
}

/// What a study computes.
#[derive(Debug, Clone)]
pub enum StudyKind {
    /// Deflection and required corrections over the workspace.
    WorkspaceMap(WorkspaceMapStudy),
    /// Deflection and required corrections along a path.
    Path(PathStudy),
    /// Where a workpiece should stand.
    Placement(Box<PlacementStudy>),
    /// Quoted numbers beside ours.
    Validation(ValidationStudy),
    /// Whether displacements by single sources may be added.
    Superposition(SuperpositionStudy),
}

impl Study {
    /// Reads and checks the study in `path`: a folder with a `study.toml`, or the file itself.
    ///
    /// # Errors
    /// A file that cannot be read, is not of the expected form, or holds values that make no sense.
    pub fn open(path: &Path, overrides: &Overrides) -> Result<Study> {
        let file = if path.is_dir() { path.join("study.toml") } else { path.to_path_buf() };
        let text = crate::input::toml_file::read(&file)?;
        let folder = file.parent().map(Path::to_path_buf).unwrap_or_default();
        Self::from_toml(&text, &file.display().to_string(), &folder, overrides)
    }

    /// Checks a study given as TOML text. `origin` names it in errors; machine files are sought relative to `folder`.
    ///
    /// # Errors
    /// As [`Study::open`].
    pub fn from_toml(text: &str, origin: &str, folder: &Path, overrides: &Overrides) -> Result<Study> {
        let spec: spec::StudySpec = crate::input::toml_file::parse(text, origin)?;
        resolve::study(&spec, text, origin, folder, overrides)
    }
}

/// Name of the folder a study stands in.
fn folder_name(folder: &Path) -> String {
    let whole = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let named = match whole.file_name() {
        Some(_) => whole.to_path_buf(),
        // Such as `.` and `..`.
        None => whole.canonicalize().unwrap_or_default(),
    };
    named.file_name().map_or_else(|| "study".into(), |name| name.to_string_lossy().into_owned())
}
