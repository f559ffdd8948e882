//! The record of a result: statuses, reasons and manifest.

use std::collections::HashMap;

use serde::Serialize;
use serde_json::Value;

use super::{
    columns::NOTES,
    description::Fact,
    table::{Table, number},
};
use crate::input::error::Result;

/// A status and its rows.
#[derive(Debug, Serialize)]
pub(super) struct StatusView {
    status: String,
    rows: String,
}

/// A status with its reason, and how many rows of a table have it.
#[derive(Debug, Serialize)]
pub(super) struct ReasonView {
    table: String,
    status: String,
    reason: String,
    rows: usize,
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
pub(super) fn count_reasons(file: &str, table: &Table, reasons: &mut Vec<ReasonView>) -> Result<()> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_that_differ_in_numbers_are_one() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("t.csv");
        std::fs::write(&file, "status,reason\nsolved,\nlost,gap 1.5 mm\nlost,gap 20 mm\nbent,x\n").unwrap();
        let mut reasons = Vec::new();
        count_reasons("t.csv", &Table::open(&file).unwrap(), &mut reasons).unwrap();
        let found: Vec<_> = reasons.iter().map(|r| (r.reason.as_str(), r.rows)).collect();
        assert_eq!(found, [("gap 1.5 mm", 2), ("x", 1)]);
        let table = "status,reason,correction_status,correction_reason\nlost,gap,lost,gap\nsolved,,slow,late\n";
        std::fs::write(&file, table).unwrap();
        reasons.clear();
        count_reasons("t.csv", &Table::open(&file).unwrap(), &mut reasons).unwrap();
        let found: Vec<_> = reasons.iter().map(|r| (r.status.as_str(), r.reason.as_str(), r.rows)).collect();
        assert_eq!(found, [("lost", "gap", 1), ("slow", "late", 1)]);
    }
}
