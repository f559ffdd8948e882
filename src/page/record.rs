//! The record of results: statuses, reasons and manifest of one, and what differs in the machine, process and study files of
//! several, key by key.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{
    dataset::NOTES,
    description::Fact,
    folder::ResultFolder,
    table::{Table, number},
};
use crate::{
    files::{
        Recorded,
        words::{counted, listed},
    },
    input::error::{Error, Result},
};

/// A status and its rows.
#[derive(Debug, Serialize)]
pub(super) struct StatusView {
    status: String,
    rows: String,
}

/// A status with its reason, and how many rows of a table have it.
#[derive(Debug, Serialize)]
pub struct ReasonView {
    /// The table.
    pub table: String,
    /// The status, in words.
    pub status: String,
    /// The reason, of the first such row.
    pub reason: String,
    /// How many rows.
    pub rows: usize,
}

/// Rows per status.
pub(super) fn statuses(manifest: &Value) -> Vec<StatusView> {
    let list = manifest.get("statuses").and_then(Value::as_array);
    let word =
        |value: Option<&Value>| value.map_or_else(String::new, |v| v.as_str().map_or(v.to_string(), String::from));
    list.into_iter()
        .flatten()
        .map(|entry| StatusView { status: word(entry.get("status")).replace('_', " "), rows: word(entry.get("rows")) })
        .collect()
}

/// Adds the reasons that a table gives with its statuses, most frequent first; rows that differ in the numbers of their reason only count as one.
///
/// # Errors
/// A row that cannot be read.
pub fn count_reasons(file: &str, table: &Table, reasons: &mut Vec<ReasonView>) -> Result<()> {
    let place = |name: &str| table.header.iter().position(|column| column == name);
    let columns: Vec<[usize; 2]> =
        NOTES.iter().filter_map(|[status, reason]| Some([place(status)?, place(reason)?])).collect();
    let mut known: HashMap<(String, String), usize> = HashMap::new();
    let mut found: Vec<ReasonView> = Vec::new();
    table.each_row(|row| {
        let reasoned = |&[status, reason]: &[usize; 2]| {
            Some((row.get(status)?, row.get(reason).filter(|reason| !reason.is_empty())?))
        };
        let Some((status, reason)) = columns.iter().find_map(reasoned) else { return };
        let key = (status.to_string(), without_numbers(reason));
        let index = *known.entry(key).or_insert_with(|| {
            found.push(ReasonView {
                table: file.into(),
                status: status.replace('_', " "),
                reason: reason.into(),
                rows: 0,
            });
            found.len() - 1
        });
        found[index].rows += 1;
    })?;
    found.sort_by_key(|reason| std::cmp::Reverse(reason.rows));
    reasons.extend(found);
    Ok(())
}

fn without_numbers(text: &str) -> String {
    text.chars().filter(|c| !c.is_ascii_digit() && !".-".contains(*c)).collect()
}

/// The manifest as lines.
pub(super) fn facts(manifest: &Value) -> Vec<Fact> {
    let Some(entries) = manifest.as_object() else { return Vec::new() };
    let mut facts = Vec::new();
    for (key, value) in entries {
        match value {
            Value::Object(inner) => {
                facts.extend(inner.iter().map(|(name, value)| Fact::new(name.replace('_', " "), words(value))));
            }
            Value::Array(_) => {}
            _ => facts.push(Fact::new(key.replace('_', " "), words(value))),
        }
    }
    facts
}

fn words(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(text) => text.clone(),
        Value::Number(n) => n.as_f64().map_or_else(|| n.to_string(), number),
        Value::Array(items) => items.iter().map(words).collect::<Vec<_>>().join(" × "),
        other => other.to_string(),
    }
}

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
