//! What differs in the machine, process and study files of results, key by key.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::folder::ResultFolder;
use crate::{
    files::{
        Recorded,
        words::{counted, listed},
    },
    input::error::{Error, Result},
};

/// Most changes that are named on the first screen.
const MOST_NAMED: usize = 3;
/// Longest value shown, characters.
const LONGEST: usize = 160;

/// Keys that differ.
#[derive(Debug, Serialize)]
pub(super) struct Changes {
    /// One row for each, with the value of every result.
    rows: Vec<Change>,
    /// Number of keys that do not differ.
    same: usize,
    /// In a sentence.
    pub sentence: String,
}

#[derive(Debug, Serialize)]
struct Change {
    part: String,
    key: String,
    values: Vec<String>,
}

/// What differs between `folders`.
///
/// # Errors
/// A manifest whose inputs are not of the expected form.
pub(super) fn changes(folders: &[ResultFolder], letters: &[char]) -> Result<Changes> {
    let all = folders.iter().map(recorded).collect::<Result<Vec<_>>>()?;
    let hashes: BTreeSet<&str> = folders.iter().filter_map(|f| f.manifest["input_sha256"].as_str()).collect();
    let without: Vec<String> =
        letters.iter().zip(&all).filter(|(_, keys)| keys.is_empty()).map(|(letter, _)| letter.to_string()).collect();
    if !without.is_empty() {
        let known = if hashes.len() == 1 { "Their inputs are the same, by their hash" } else { "Their inputs differ" };
        let sentence = format!(
            "{known}; what differs key by key is not known, as {} {} computed by a version that did not record it: run \
             the study again.",
            without.join(" and "),
            if without.len() == 1 { "was" } else { "were" }
        );
        return Ok(Changes { rows: Vec::new(), same: 0, sentence });
    }
    let keys: BTreeSet<&(String, String)> = all.iter().flat_map(BTreeMap::keys).collect();
    let mut rows = Vec::new();
    let mut same = 0;
    for at in keys {
        let found: Vec<Option<&String>> = all.iter().map(|own| own.get(at)).collect();
        let (part, key) = at;
        if found.iter().all(|value| *value == found[0]) {
            same += 1;
        } else if (part.as_str(), key.as_str()) != ("study", "question") {
            let values = found.iter().map(|value| value.map_or_else(|| "–".into(), |text| shortened(text))).collect();
            rows.push(Change { part: part.clone(), key: key.clone(), values });
        }
    }
    let sentence = sentence(&rows, hashes.len() > 1);
    Ok(Changes { rows, same, sentence })
}

fn sentence(rows: &[Change], is_other_text: bool) -> String {
    let name = |row: &Change| match row.key.as_str() {
        "" => format!("{}: {}", row.part, row.values.join(" against ")),
        key => format!("{} {key}: {}", row.part, row.values.join(" against ")),
    };
    if rows.is_empty() {
        let what = if is_other_text { "; only comments or the order of their lines differ" } else { "" };
        return format!("Machine, process and study hold the same values{what}.");
    }
    if rows.len() <= MOST_NAMED {
        return format!("What differs: {}.", rows.iter().map(name).collect::<Vec<_>>().join("; "));
    }
    let mut parts: Vec<(&str, usize)> = Vec::new();
    for row in rows {
        match parts.iter_mut().find(|(part, _)| *part == row.part) {
            Some((_, count)) => *count += 1,
            None => parts.push((&row.part, 1)),
        }
    }
    let parts: Vec<String> =
        parts.iter().map(|(part, count)| format!("{} of the {part}", counted(*count, "value"))).collect();
    format!("They differ in {}, listed under Why.", listed(&parts.iter().map(String::as_str).collect::<Vec<_>>()))
}

/// The keys of a result with their values; none of one that has recorded none.
///
/// # Errors
/// As [`changes`].
pub(super) fn recorded(folder: &ResultFolder) -> Result<BTreeMap<(String, String), String>> {
    let Some(inputs) = folder.manifest.get("inputs") else { return Ok(BTreeMap::new()) };
    let inputs: Vec<Recorded> = Deserialize::deserialize(inputs).map_err(|fault: serde_json::Error| Error::Value {
        file: folder.path.join("manifest.json").display().to_string(),
        key: "inputs".into(),
        problem: fault.to_string(),
    })?;
    Ok(Recorded::by_part(&inputs))
}

/// The tolerance of the study of `folder` or of its process, mm: the smallest, if there are several.
pub(super) fn tolerance_mm(folder: &ResultFolder) -> Result<Option<f64>> {
    let keys = recorded(folder)?;
    let own = keys.iter().filter(|((part, key), _)| {
        ["study", "process"].contains(&part.as_str()) && key.rsplit('.').next() == Some("tolerance_mm")
    });
    Ok(own.filter_map(|(_, value)| value.parse::<f64>().ok()).reduce(f64::min))
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
