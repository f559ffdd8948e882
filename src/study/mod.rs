//! The questions: a study file as written ([`spec`]), checked ([`Study`]), run, and its plain results.
//!
//! What is cut along a toolpath is said in a process file ([`process_spec`]), checked as [`Process`].
//!
//! A study is a folder with a `study.toml`; its inputs are named relative to that folder.

pub mod bounded_pass;
pub mod checkpoint;
pub mod deflected_pose;
mod failure;
mod inputs;
pub mod machine_check;
pub mod path;
mod path_resolve;
pub mod path_study;
pub mod placement;
pub mod placement_spec;
pub mod point;
pub mod process;
mod process_resolve;
pub mod process_spec;
pub mod program;
mod resolve;
mod source;
pub mod spec;
pub mod superposition;
pub mod superposition_spec;
mod tilt;
pub mod validation;
pub mod validation_spec;
pub mod work;
pub mod workspace_map;

use std::path::Path;

pub use failure::{Failure, SOLVED, status_of};
pub use inputs::Inputs;
use path_study::PathStudy;
use placement::PlacementStudy;
pub use process::Process;
pub use resolve::Overrides;
pub use source::Source;
use superposition::SuperpositionStudy;
use validation::ValidationStudy;
pub use work::Work;
use workspace_map::WorkspaceMapStudy;

use crate::error::Result;

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
        let text = crate::toml_file::read(&file)?;
        let folder = file.parent().map(Path::to_path_buf).unwrap_or_default();
        Self::from_toml(&text, &file.display().to_string(), &folder, overrides)
    }

    /// Checks a study given as TOML text. `origin` names it in errors; machine files are sought relative to `folder`.
    ///
    /// # Errors
    /// As [`Study::open`].
    pub fn from_toml(text: &str, origin: &str, folder: &Path, overrides: &Overrides) -> Result<Study> {
        let spec: spec::StudySpec = crate::toml_file::parse(text, origin)?;
        resolve::study(&spec, text, origin, folder, overrides)
    }
}

/// The last part of the path that names an input.
fn file_name(origin: &str) -> String {
    Path::new(origin).file_name().map_or_else(|| origin.into(), |name| name.to_string_lossy().into_owned())
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
