//! What a result folder was made from.

use std::{ffi::OsStr, path::Path};

use serde::Serialize;

use super::{Foreign, Recorded, may_replace};
use crate::{
    input::{Inputs, error::Result, file},
    simulation::is_answer,
};

/// A longer file is no record, bytes.
const LONGEST: u64 = 16 << 20;

/// What stands in `file`, if it is a record that this program wrote of other files.
pub(crate) fn record_in(file: &Path) -> Option<serde_json::Value> {
    let record: serde_json::Value = serde_json::from_slice(&file::bounded(file, LONGEST).ok()?).ok()?;
    (record["program"] == env!("CARGO_PKG_NAME")).then_some(record)
}

/// Number of table rows with one status.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct StatusCount {
    /// Status.
    pub status: String,
    /// Rows.
    pub rows: usize,
}

impl StatusCount {
    /// Whether these rows are what was asked for.
    pub fn is_solved(&self) -> bool {
        is_answer(&self.status)
    }

    /// What an answer that rests on part of the rows begins with, such as "445 of 1029 not solved: 300 slow, 145
    /// unreachable."; `None` where all are solved.
    pub fn unsolved(counts: &[StatusCount]) -> Option<String> {
        let rows = |counts: &[&StatusCount]| counts.iter().map(|count| count.rows).sum::<usize>();
        let mut unsolved: Vec<&StatusCount> = counts.iter().filter(|count| !count.is_solved()).collect();
        if unsolved.is_empty() {
            return None;
        }
        unsolved.sort_by_key(|count| std::cmp::Reverse(count.rows));
        let words = unsolved.iter().map(|count| format!("{} {}", count.rows, count.status.replace('_', " ")));
        let all = rows(&counts.iter().collect::<Vec<_>>());
        Some(format!("{} of {all} not solved: {}.", rows(&unsolved), words.collect::<Vec<_>>().join(", ")))
    }

    /// Counts one more row with `status`.
    pub fn add(counts: &mut Vec<StatusCount>, status: &str) {
        match counts.iter_mut().find(|count| count.status == status) {
            Some(count) => count.rows += 1,
            None => counts.push(StatusCount { status: status.into(), rows: 1 }),
        }
    }
}

/// Provenance of a result folder. Everything follows from the input: a folder is the same whenever and wherever it is made.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Manifest {
    /// Program name.
    pub program: &'static str,
    /// Program version.
    pub version: &'static str,
    /// Study name.
    pub study: String,
    /// SHA-256 of everything that decides the results: study file, machine file, command-line changes.
    pub input_sha256: String,
    /// The same, key by key.
    pub inputs: Vec<Recorded>,
    /// Seed of random draws; no draw is made where it is null.
    pub seed: Option<u64>,
    /// Settings in effect.
    pub settings: serde_json::Value,
    /// Rows per status.
    pub statuses: Vec<StatusCount>,
    /// Files written, but for this one. A later run in the same folder removes those it does not write itself.
    pub files: Vec<String>,
    /// Whether files are being put in place: until the last one is, some are of the run before. Left out where they all are.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub publishing: bool,
}

impl Manifest {
    /// Of `study`, made from `inputs`: its settings, how many rows ended how, and its files.
    pub(crate) fn new(
        study: &str,
        inputs: &Inputs,
        (settings, statuses): (serde_json::Value, Vec<StatusCount>),
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

    /// Name of its file.
    pub const FILE: &str = "manifest.json";

    /// The files that the run before left in `folder`, by its manifest; none if there is none.
    pub fn files_in(folder: &Path) -> Vec<String> {
        Self::found_in(folder).unwrap_or_default()
    }

    /// As [`Manifest::files_in`]; nothing if there is no manifest that this program wrote.
    fn found_in(folder: &Path) -> Option<Vec<String>> {
        let manifest = record_in(&folder.join(Self::FILE))?;
        let files = manifest["files"].as_array().into_iter().flatten().filter_map(serde_json::Value::as_str);
        // Only names: never a file elsewhere.
        Some(files.filter(|name| Path::new(name).file_name() == Some(OsStr::new(name))).map(String::from).collect())
    }

    /// Refuses to write files of these `names` into `folder` where they, or the manifest, would replace what no run before
    /// wrote there, or what this one reads.
    ///
    /// # Errors
    /// Names the file that would be lost.
    pub fn may_write<'a>(folder: &Path, names: impl Iterator<Item = &'a str>) -> Result<()> {
        let found = Self::found_in(folder);
        may_replace(&folder.join(Self::FILE), Foreign::Kept, || found.is_some())?;
        let former = found.unwrap_or_default();
        former.iter().try_for_each(|name| may_replace(&folder.join(name), Foreign::Kept, || true))?;
        for name in names {
            may_replace(&folder.join(name), Foreign::Kept, || former.iter().any(|own| own == name))?;
        }
        Ok(())
    }

    /// Whether a manifest as read says that some files of its folder are of the run before.
    pub(crate) fn is_publishing(manifest: &serde_json::Value) -> bool {
        manifest["publishing"] == true
    }

    /// Rows per status, in order of first appearance.
    pub fn count<'a>(statuses: impl Iterator<Item = &'a str>) -> Vec<StatusCount> {
        let mut counts = Vec::new();
        statuses.for_each(|status| StatusCount::add(&mut counts, status));
        counts
    }

    /// As a JSON file.
    pub(crate) fn to_json(&self) -> String {
        // A struct of strings and numbers always serialises.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
