//! The manifest of a result folder: what the results were computed from, and which files belong to them.

use std::{ffi::OsStr, path::Path};

use serde::Serialize;

use super::{Foreign, Recorded, check_may_replace};
use crate::{
    input::{Inputs, error::Result, file},
    simulation::is_result_status,
};

/// Longest file that can be a record, in bytes.
const LONGEST: u64 = 16 << 20;

/// Returns the JSON in `file` if it is a record that this program wrote of other files; otherwise `None`.
pub(crate) fn read_record(file: &Path) -> Option<serde_json::Value> {
    let record: serde_json::Value = serde_json::from_slice(&file::read_bounded(file, LONGEST).ok()?).ok()?;
    (record["program"] == env!("CARGO_PKG_NAME")).then_some(record)
}

/// A status and its number of table rows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct StatusCount {
    /// Status.
    pub status: String,
    /// Number of rows.
    pub rows: usize,
}

impl StatusCount {
    /// Returns whether rows with this status are valid results.
    pub fn is_solved(&self) -> bool {
        is_result_status(&self.status)
    }

    /// Returns a sentence on rows that are not solved, such as "445 of 1029 not solved: 300 slow, 145 unreachable."; `None` if all are.
    pub fn unsolved(counts: &[StatusCount]) -> Option<String> {
        let total = |counts: &[&StatusCount]| counts.iter().map(|count| count.rows).sum::<usize>();
        let mut unsolved: Vec<&StatusCount> = counts.iter().filter(|count| !count.is_solved()).collect();
        if unsolved.is_empty() {
            return None;
        }
        unsolved.sort_by_key(|count| std::cmp::Reverse(count.rows));
        let text = unsolved.iter().map(|count| format!("{} {}", count.rows, count.status.replace('_', " ")));
        let all = total(&counts.iter().collect::<Vec<_>>());
        Some(format!("{} of {all} not solved: {}.", total(&unsolved), text.collect::<Vec<_>>().join(", ")))
    }

    /// Counts one more row with `status` in `counts`.
    pub fn add(counts: &mut Vec<StatusCount>, status: &str) {
        match counts.iter_mut().find(|count| count.status == status) {
            Some(count) => count.rows += 1,
            None => counts.push(StatusCount { status: status.into(), rows: 1 }),
        }
    }
}

/// Contents of `manifest.json`, the provenance of a result folder. It follows from the input alone: no time, no computer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Manifest {
    /// Program name.
    pub program: &'static str,
    /// Program version.
    pub version: &'static str,
    /// Study name.
    pub study: String,
    /// SHA-256 of everything that decides the results: study file, machine file, command-line options.
    pub input_sha256: String,
    /// The inputs with their values, key by key.
    pub inputs: Vec<Recorded>,
    /// Seed of random draws; no draw is made where it is null.
    pub seed: Option<u64>,
    /// Settings in effect.
    pub settings: serde_json::Value,
    /// Number of rows by status.
    pub statuses: Vec<StatusCount>,
    /// Files written, without this one. A later run in the same folder removes those it does not write itself.
    pub files: Vec<String>,
    /// Whether files are being moved into place: some may still be of the run before. Left out once all are in place.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub publishing: bool,
}

impl Manifest {
    /// Returns the manifest of `study` made from `inputs`, with its settings, rows by status, and files.
    pub(crate) fn new(
        study: &str,
        inputs: &Inputs,
        settings: serde_json::Value,
        statuses: Vec<StatusCount>,
        files: Vec<String>,
    ) -> Self {
        Self {
            program: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            study: study.into(),
            input_sha256: inputs.sha256(),
            inputs: Recorded::of(inputs),
            seed: None,
            settings,
            statuses,
            files,
            publishing: false,
        }
    }

    /// Name of the manifest's file.
    pub const FILE: &str = "manifest.json";

    /// Returns the files of the previous run in `folder`, by its manifest; empty if there is none.
    pub fn previous_files(folder: &Path) -> Vec<String> {
        Self::recorded_files(folder).unwrap_or_default()
    }

    /// Returns the files of the previous run in `folder`; `None` if there is no manifest that this program wrote.
    fn recorded_files(folder: &Path) -> Option<Vec<String>> {
        let manifest = read_record(&folder.join(Self::FILE))?;
        let files = manifest["files"].as_array().into_iter().flatten().filter_map(serde_json::Value::as_str);
        // Only names: never a file elsewhere.
        Some(files.filter(|name| Path::new(name).file_name() == Some(OsStr::new(name))).map(String::from).collect())
    }

    /// Checks that files of these `names` in `folder` replace neither files that no previous run wrote nor inputs of this command;
    /// otherwise `Err` names the file that would be lost.
    pub fn check_may_write<'a>(folder: &Path, names: impl Iterator<Item = &'a str>) -> Result<()> {
        let found = Self::recorded_files(folder);
        check_may_replace(&folder.join(Self::FILE), Foreign::Kept, || found.is_some())?;
        let former = found.unwrap_or_default();
        former.iter().try_for_each(|name| check_may_replace(&folder.join(name), Foreign::Kept, || true))?;
        for name in names {
            check_may_replace(&folder.join(name), Foreign::Kept, || former.iter().any(|own| own == name))?;
        }
        Ok(())
    }

    /// Returns whether a manifest as read says that some files of its folder may be of the run before.
    pub(crate) fn is_publishing(manifest: &serde_json::Value) -> bool {
        manifest["publishing"] == true
    }

    /// Counts the rows of each status, in order of first appearance.
    pub fn count<'a>(statuses: impl Iterator<Item = &'a str>) -> Vec<StatusCount> {
        let mut counts = Vec::new();
        statuses.for_each(|status| StatusCount::add(&mut counts, status));
        counts
    }

    /// Returns the contents of `manifest.json`.
    pub(crate) fn to_json(&self) -> String {
        // A struct of strings and numbers always serialises.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
