//! What is explored: a machine, and the study of a workpiece's place with the files that it names.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::study::{placement_of_path, written};
use crate::{
    input::{
        Folder,
        error::{Error, Result},
    },
    machine::{Branch, catalogue},
    questions::{Study, StudyKind},
    toolpath::gcode::Dialect,
};

/// Most bytes of all files together: a page holds them.
const MOST_BYTES: usize = 2 << 20;

/// A machine, and a workpiece on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// One of the files, also where it is a built-in machine.
    pub machine: String,
    /// Files by the names that the study has for them; those that are no text with their other bytes replaced.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
    /// A placement study or a map; without one there is a machine alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<String>,
    /// The best place known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub best: Option<BestPlace>,
}

/// The best place that a study has found.
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
    /// A machine alone: a built-in one, or else that of the file `name`, whose text is `toml`.
    pub fn of_machine(name: &str, toml: Option<String>) -> Self {
        let files = toml.map(|text| (name.to_string(), text)).into_iter().chain(built_in(name)).collect();
        Self { machine: name.into(), files, study: None, best: None }
    }

    /// The machine and the workpiece of a study of a place or a path, the machine and the process of a map; `None` of other studies.
    ///
    /// # Errors
    /// A path whose workpiece cannot be put elsewhere (a line, or one that commands external axes), or files too long to be
    /// taken along.
    pub fn of_study(study: &Study) -> Result<Option<Self>> {
        let text = match &study.kind {
            StudyKind::Placement(..) => study.files.text.clone(),
            StudyKind::Path(..) => placement_of_path(&study.files)?,
            StudyKind::WorkspaceMap(map, _) => on_branch(&study.files.text, map.scene.machine.branch)?,
            #[cfg_attr(target_family = "wasm", allow(unreachable_patterns, reason = "pages have no others"))]
            _ => return Ok(None),
        };
        Self::of_text(&text, &study.files.named).map(Some)
    }

    pub(super) fn of_text(text: &str, named: &BTreeMap<String, Vec<u8>>) -> Result<Self> {
        let bytes: usize = named.values().map(Vec::len).sum();
        if bytes > MOST_BYTES {
            let problem = format!("its files have {bytes} bytes together, of which a page holds at most {MOST_BYTES}");
            return Err(Error::argument("study", problem));
        }
        let foreign = |(name, bytes): &(&String, &Vec<u8>)| {
            // What a page has was looked at before.
            let is_program = !name.ends_with(".csv") && !name.ends_with(".toml");
            is_program && !cfg!(target_family = "wasm") && Dialect::of(bytes) != Dialect::Iso
        };
        if let Some((name, bytes)) = named.iter().find(foreign) {
            let problem = format!("{name} is in the language of {}; pages read ISO code", Dialect::of(bytes).name());
            return Err(Error::argument("study", problem));
        }
        let file = |(name, bytes): (&String, &Vec<u8>)| (name.clone(), String::from_utf8_lossy(bytes).into_owned());
        let head: Head = crate::input::toml_file::parse(text, super::STUDY)?;
        let mut files: BTreeMap<String, String> = named.iter().map(file).collect();
        files.extend(built_in(&head.machine));
        Ok(Self { machine: head.machine, files, study: Some(text.into()), best: None })
    }

    pub(super) fn folder(&self) -> Folder {
        Folder::in_memory(self.files.iter().map(|(name, text)| (name.clone(), text.clone().into_bytes())))
    }
}

/// The study `text` with the branch on which its machine stands, which the command line may have chosen.
fn on_branch(text: &str, branch: Option<Branch>) -> Result<String> {
    let Some(branch) = branch else { return Ok(text.into()) };
    let mut study: toml::Table = crate::input::toml_file::parse(text, super::STUDY)?;
    study.insert("branch".into(), branch.label().into());
    written(&study)
}

/// The file of a built-in machine.
fn built_in(name: &str) -> Option<(String, String)> {
    catalogue::find(name).map(|entry| (name.to_string(), entry.toml.to_string()))
}

/// What is asked of a study file before it is read.
#[derive(Deserialize)]
struct Head {
    machine: String,
}
