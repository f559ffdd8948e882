//! A scene to explore: a machine, and a placement study or a map with the files that it names.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::study::{placement_from_path, to_toml};
use crate::{
    FOR_PAGES,
    input::{
        Folder,
        error::{Error, Result},
    },
    machine::{Branch, catalogue},
    questions::{Study, StudyKind},
    toolpath::gcode::Dialect,
};

/// Most bytes of all files together, since a page holds them.
const MAX_BYTES: usize = 2 << 20;

/// A machine to explore, and a workpiece or a map on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name of the machine's file in `files`, also for a built-in machine.
    pub machine: String,
    /// Files by their names in the study, as text; other bytes are replaced.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
    /// A placement study or a map; `None` for a machine alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<String>,
    /// Best place known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best: Option<BestPlace>,
}

/// The best place found by a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BestPlace {
    /// Its name.
    pub name: String,
    /// x, y, z in mm, yaw, pitch and roll in degrees.
    pub place: [f64; 6],
    /// The objective there.
    pub objective: f64,
}

impl Scene {
    /// Creates a scene of a machine alone: a built-in one, or that of the file `name` with the text `toml`.
    pub fn from_machine(name: &str, toml: Option<String>) -> Self {
        let files = toml.map(|text| (name.to_string(), text)).into_iter().chain(built_in_file(name)).collect();
        Self { machine: name.into(), files, study: None, best: None }
    }

    /// Creates a scene of a placement or path study (machine and workpiece) or of a map (machine and process); `None` for other studies.
    ///
    /// # Errors
    /// A path whose workpiece cannot be moved (a line, or one that commands external axes), a program that is not ISO code, or files that are too long together.
    pub fn from_study(study: &Study) -> Result<Option<Self>> {
        let text = match &study.kind {
            StudyKind::Placement(..) => study.files.text.clone(),
            StudyKind::Path(..) => placement_from_path(&study.files)?,
            StudyKind::WorkspaceMap(map, _) => on_branch(&study.files.text, map.load_case.machine.branch)?,
            _ => return Ok(None),
        };
        Self::from_text(&text, &study.files.named).map(Some)
    }

    /// Creates a scene of the study file `text` and the files `named` in it, with the file of the machine if that is built in.
    ///
    /// # Errors
    /// Files that are too long together, a program that is not ISO code, or a text that is no TOML with a machine.
    pub(super) fn from_text(text: &str, named: &BTreeMap<String, Vec<u8>>) -> Result<Self> {
        let size: usize = named.values().map(Vec::len).sum();
        if size > MAX_BYTES {
            let problem = format!("its files have {size} bytes together, of which a page holds at most {MAX_BYTES}");
            return Err(Error::argument("study", problem));
        }
        let is_foreign = |(name, bytes): &(&String, &Vec<u8>)| {
            // Programs of a page were checked when it was written.
            let is_program = !name.ends_with(".csv") && !name.ends_with(".toml");
            is_program && !FOR_PAGES && Dialect::detect(bytes) != Dialect::Iso
        };
        if let Some((name, bytes)) = named.iter().find(is_foreign) {
            let fault = format!("{name} is in the language of {}; pages read ISO code", Dialect::detect(bytes).name());
            return Err(Error::argument("study", fault));
        }
        let file = |(name, bytes): (&String, &Vec<u8>)| (name.clone(), String::from_utf8_lossy(bytes).into_owned());
        let head: Head = crate::input::toml_file::parse(text, super::STUDY)?;
        let mut files: BTreeMap<String, String> = named.iter().map(file).collect();
        files.extend(built_in_file(&head.machine));
        Ok(Self { machine: head.machine, files, study: Some(text.into()), best: None })
    }

    /// Returns the files of the scene as a folder in memory.
    pub(super) fn folder(&self) -> Folder {
        Folder::in_memory(self.files.iter().map(|(name, text)| (name.clone(), text.clone().into_bytes())))
    }
}

/// Returns the study `text` with the `branch` of its machine, which the command line may have chosen.
fn on_branch(text: &str, branch: Option<Branch>) -> Result<String> {
    let Some(branch) = branch else { return Ok(text.into()) };
    let mut study: toml::Table = crate::input::toml_file::parse(text, super::STUDY)?;
    study.insert("branch".into(), branch.label().into());
    to_toml(&study)
}

/// Returns name and text of the file of the built-in machine `name`; `None` if there is none.
fn built_in_file(name: &str) -> Option<(String, String)> {
    catalogue::find(name).map(|entry| (name.to_string(), entry.toml.to_string()))
}

/// Keys of a study file that are read before the rest.
#[derive(Deserialize)]
struct Head {
    machine: String,
}
