//! The record of results: statuses, reasons and manifest of one, and the differences between the inputs of several, key by key.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{
    dataset::NOTES,
    description::Fact,
    folder::ResultFolder,
    sentences::three_digits,
    table::{Table, format_number},
};
use crate::{
    files::{Recorded, words::with_unit},
    input::{check::Check, error::Result},
};

/// A status and the number of its rows, as text.
#[derive(Debug, Serialize)]
pub(super) struct StatusView {
    status: String,
    rows: String,
}

/// A status with its reason, and how many rows of a table have it.
#[derive(Debug, Serialize)]
pub struct ReasonView {
    /// Name of the table's file.
    pub table: String,
    /// The status, in words.
    pub status: String,
    /// The reason, of the first such row.
    pub reason: String,
    /// Number of rows.
    pub rows: usize,
}

/// Returns the statuses in a manifest with their numbers of rows.
pub(super) fn status_rows(manifest: &Value) -> Vec<StatusView> {
    let list = manifest.get("statuses").and_then(Value::as_array);
    let word =
        |value: Option<&Value>| value.map_or_else(String::new, |v| v.as_str().map_or(v.to_string(), String::from));
    let status = |entry: &Value| word(entry.get("status")).replace('_', " ");
    list.into_iter()
        .flatten()
        .map(|entry| StatusView { status: status(entry), rows: word(entry.get("rows")) })
        .collect()
}

/// Adds the reasons in a table, most frequent first; those that differ only in numbers count as one. `Err` when a row cannot be read.
pub fn count_reasons(file: &str, table: &Table, reasons: &mut Vec<ReasonView>) -> Result<()> {
    let position = |name: &str| table.header.iter().position(|column| column == name);
    let columns: Vec<[usize; 2]> =
        NOTES.iter().filter_map(|[status, reason]| Some([position(status)?, position(reason)?])).collect();
    let mut known: HashMap<(String, String), usize> = HashMap::new();
    let mut counted_reasons: Vec<ReasonView> = Vec::new();
    table.each_row(|row| {
        let status_and_reason = |&[status, reason]: &[usize; 2]| {
            Some((row.get(status)?, row.get(reason).filter(|reason| !reason.is_empty())?))
        };
        let Some((status, reason)) = columns.iter().find_map(status_and_reason) else { return };
        let key = (status.to_string(), without_numbers(reason));
        let index = *known.entry(key).or_insert_with(|| {
            counted_reasons.push(ReasonView {
                table: file.into(),
                status: status.replace('_', " "),
                reason: reason.into(),
                rows: 0,
            });
            counted_reasons.len() - 1
        });
        counted_reasons[index].rows += 1;
    })?;
    counted_reasons.sort_by_key(|reason| std::cmp::Reverse(reason.rows));
    reasons.extend(counted_reasons);
    Ok(())
}

/// Returns a text without digits, points and minus signs.
fn without_numbers(text: &str) -> String {
    text.chars().filter(|c| !c.is_ascii_digit() && !".-".contains(*c)).collect()
}

/// Returns the entries of a manifest as labels and values, without lists.
pub(super) fn manifest_facts(manifest: &Value) -> Vec<Fact> {
    let Some(entries) = manifest.as_object() else { return Vec::new() };
    let mut facts = Vec::new();
    for (key, value) in entries {
        match value {
            Value::Object(inner) => {
                facts.extend(inner.iter().map(|(name, value)| Fact::new(name.replace('_', " "), value_text(value))));
            }
            Value::Array(_) => {}
            _ => facts.push(Fact::new(key.replace('_', " "), value_text(value))),
        }
    }
    facts
}

/// Returns a JSON value in words.
fn value_text(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(text) => text.clone(),
        Value::Number(n) => n.as_f64().map_or_else(|| n.to_string(), format_number),
        Value::Array(items) => items.iter().map(value_text).collect::<Vec<_>>().join(" × "),
        other => other.to_string(),
    }
}

/// Most changes that the first screen names one by one.
const MAX_NAMED: usize = 5;
/// Longest value shown, in characters.
const LONGEST: usize = 160;

/// Differences between the inputs of several results.
#[derive(Debug, Serialize)]
pub(super) struct Changes {
    rows: Vec<Change>,
    /// Number of keys with the same value in all results.
    same: usize,
    pub sentence: String,
    /// What differs most, in words of the machine: other elements first, then numbers by their ratio.
    first: Vec<String>,
}

/// A key that differs, with its value in each result.
#[derive(Debug, Serialize)]
struct Change {
    part: String,
    key: String,
    values: Vec<String>,
}

/// Returns the differences between the inputs of `folders`, which `letters` name, key by key; without rows if one does not record its keys.
/// `Err` when a manifest does not record them in the expected form.
pub(super) fn input_changes(folders: &[ResultFolder], letters: &[char]) -> Result<Changes> {
    let keys_by_folder = folders.iter().map(recorded_keys).collect::<Result<Vec<_>>>()?;
    let hashes: BTreeSet<Option<&str>> = folders.iter().map(|f| f.manifest["input_sha256"].as_str()).collect();
    let hash_count = hashes.iter().flatten().count();
    let recorded = letters.iter().zip(&keys_by_folder);
    let unrecorded: Vec<String> =
        recorded.filter(|(_, keys)| keys.is_empty()).map(|(letter, _)| letter.to_string()).collect();
    if !unrecorded.is_empty() {
        let known = match hash_count {
            1 if !hashes.contains(&None) => "Their inputs are the same, by their hash",
            0 | 1 => "Their inputs may differ",
            _ => "Their inputs differ",
        };
        let sentence = format!(
            "{known}; what differs key by key is not known, as {} {} computed by a version that did not record keys: \
             run the study again.",
            unrecorded.join(" and "),
            if unrecorded.len() == 1 { "was" } else { "were" }
        );
        return Ok(Changes { rows: Vec::new(), same: 0, sentence, first: Vec::new() });
    }
    let keys: BTreeSet<&(String, String)> = keys_by_folder.iter().flat_map(BTreeMap::keys).collect();
    let (mut rows, mut unchanged) = (Vec::new(), 0);
    for part_and_key in keys {
        let found: Vec<Option<&String>> = keys_by_folder.iter().map(|keys| keys.get(part_and_key)).collect();
        let (part, key) = part_and_key;
        if found.iter().all(|value| *value == found[0]) {
            unchanged += 1;
        } else if (part.as_str(), key.as_str()) != ("study", "question") {
            let values = found.iter().map(|value| value.map_or_else(|| ABSENT.into(), |text| shorten(text))).collect();
            rows.push(Change { part: part.clone(), key: key.clone(), values });
        }
    }
    // What was computed with comes before its names and sources.
    rows.sort_by_key(Change::is_only_said);
    let (sentence, first) = change_text(&rows, hash_count > 1, letters);
    Ok(Changes { rows, same: unchanged, sentence, first })
}

/// The value of a key that a result does not have.
const ABSENT: &str = "–";

impl Change {
    /// Whether nothing is computed from the key: a name, where a number comes from, or which file was taken.
    fn is_only_said(&self) -> bool {
        let of_machine =
            || ["name", "title", "source"].contains(&self.key.as_str()) || self.key.starts_with("provenance.");
        let of_study = || ["machine", "process", "name"].contains(&self.key.as_str());
        (self.part == "machine" && of_machine()) || (self.part == "study" && of_study())
    }

    /// Returns chain and element of a machine to which the key belongs, and of which kind that is; `None` for other keys.
    fn element(&self) -> Option<(&str, &str, &str)> {
        let (chain, rest) = self.key.strip_prefix("chain.")?.split_once(".elements.")?;
        let mut words = rest.split('.');
        Some((chain, words.next()?, words.next()?)).filter(|_| self.part == "machine")
    }

    /// Returns by which factor the largest of the numbers is larger than the smallest; `None` where one is no number, infinite where one is 0 or of the other sign.
    fn ratio(&self) -> Option<f64> {
        let numbers: Vec<f64> = self.values.iter().map(|value| value.parse().ok()).collect::<Option<_>>()?;
        let [low, high] = [f64::min, f64::max].map(|end| numbers.iter().copied().reduce(end).unwrap_or(f64::NAN));
        Some(if low > 0.0 {
            high / low
        } else if high < 0.0 {
            low / high
        } else {
            f64::INFINITY
        })
    }

    /// Returns key and values in words: "stiffness of J6: 79.6 kN·m/rad in A, 210 kN·m/rad in B, 2.64 times as much".
    fn text(&self, letters: &[char]) -> String {
        let mut segments = self.key.rsplit('.');
        let last = segments.next().unwrap_or_default();
        let owner = self.element().map(|(_, element, _)| element).or_else(|| segments.next()).unwrap_or_default();
        let unit = KEY_UNITS.iter().find(|(ending, ..)| last.ends_with(ending));
        let name = unit.map_or(last, |(ending, ..)| last.trim_end_matches(ending)).replace('_', " ");
        // As few digits as tell them apart.
        let rounded: BTreeSet<String> =
            self.values.iter().filter_map(|text| Some(three_digits(text.parse().ok()?))).collect();
        let distinct: BTreeSet<&String> = self.values.iter().collect();
        let digits =
            |number: f64| if rounded.len() < distinct.len() { format_number(number) } else { three_digits(number) };
        let value = |text: &String| match (unit, text.parse::<f64>()) {
            (Some((_, shown, factor)), Ok(number)) => with_unit(&digits(number * factor), shown),
            _ => text.clone(),
        };
        let values: Vec<String> =
            self.values.iter().zip(letters).map(|(own, letter)| format!("{} in {letter}", value(own))).collect();
        let of = if owner.is_empty() { self.part.replace('_', " ") } else { owner.replace('_', " ") };
        let is_ratio =
            self.values.len() == 2 && self.ratio().is_some_and(|ratio| (1.05..f64::INFINITY).contains(&ratio));
        let numbers = self.values.iter().map(|text| text.parse().ok()).collect::<Option<Vec<f64>>>();
        let times = match numbers.as_deref() {
            Some([a, b]) if is_ratio => format!(", {:.2} times as much", b / a),
            _ => String::new(),
        };
        let what = if name.is_empty() { of } else { format!("{name} of {of}") };
        format!("{what}: {}{}", values.join(", "), times)
    }
}

/// Endings of keys that name units; the unit that is shown, and by what a number is multiplied for it.
const KEY_UNITS: [(&str, &str, f64); 7] = [
    ("_Nmm_per_rad", "kN·m/rad", 1e-6),
    ("_N_per_mm", "N/mm", 1.0),
    ("_Nmm", "N·mm", 1.0),
    ("_mm", "mm", 1.0),
    ("_deg", "°", 1.0),
    ("_kg", "kg", 1.0),
    ("_N", "N", 1.0),
];

/// Returns a sentence on the changes, and what differs most; `is_other_text` says whether the input files differ as texts.
fn change_text(rows: &[Change], is_other_text: bool, letters: &[char]) -> (String, Vec<String>) {
    if rows.is_empty() {
        let what = if is_other_text { "; only comments or the order of their lines differ" } else { "" };
        return (format!("Machine, process and study hold the same values{what}."), Vec::new());
    }
    let computed: Vec<&Change> = rows.iter().filter(|row| !row.is_only_said()).collect();
    if computed.is_empty() {
        return ("Only names and sources of the inputs differ.".into(), Vec::new());
    }
    // An element of another kind has other keys throughout: that is one difference.
    let mut kinds: BTreeMap<(&str, &str), Vec<BTreeSet<&str>>> = BTreeMap::new();
    for row in &computed {
        let Some((chain, element, kind)) = row.element() else { continue };
        let own = kinds.entry((chain, element)).or_insert_with(|| vec![BTreeSet::new(); letters.len()]);
        for (own, value) in own.iter_mut().zip(&row.values) {
            own.extend((value != ABSENT).then_some(kind));
        }
    }
    kinds.retain(|_, own| own.iter().any(|other| *other != own[0]));
    let is_other =
        |row: &Change| row.element().is_some_and(|(chain, element, _)| kinds.contains_key(&(chain, element)));
    let of_kind = |((chain, element), own): (&(&str, &str), &Vec<BTreeSet<&str>>)| {
        let what = |(kinds, letter): (&BTreeSet<&str>, &char)| {
            let named: Vec<String> = kinds.iter().map(|kind| kind.replace('_', " ")).collect();
            format!("{} in {letter}", if named.is_empty() { "not".into() } else { named.join(" and ") })
        };
        let all: Vec<String> = own.iter().zip(letters).map(what).collect();
        format!("{element} of {chain}: {}", all.join(", "))
    };
    // What one does not have, or has in other words, before numbers.
    let size = |row: &Change| match row.ratio() {
        _ if row.values.iter().any(|value| value == ABSENT) => f64::INFINITY,
        None => f64::MAX,
        Some(ratio) => ratio.min(f64::MAX / 2.0),
    };
    let mut numbers: Vec<&&Change> = computed.iter().filter(|row| !is_other(row)).collect();
    numbers.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let all: Vec<String> = kinds.iter().map(of_kind).chain(numbers.into_iter().map(|row| row.text(letters))).collect();
    let sentence = match all.len().saturating_sub(MAX_NAMED) {
        0 => "What differs in the inputs:".into(),
        more => format!("What differs in the inputs, with {more} more under Why:"),
    };
    (sentence, all.into_iter().take(MAX_NAMED).collect())
}

/// Returns the values of a result's inputs by part and key; empty if none are recorded, `Err` if they have not the expected form.
pub(super) fn recorded_keys(folder: &ResultFolder) -> Result<BTreeMap<(String, String), String>> {
    let Some(inputs) = folder.manifest.get("inputs") else { return Ok(BTreeMap::new()) };
    let check = Check::new(&folder.path.join("manifest.json").display().to_string()).key("inputs");
    let inputs: serde_json::Result<Vec<Recorded>> = Deserialize::deserialize(inputs);
    let inputs = inputs.or_else(|fault| check.fail(fault.to_string()))?;
    Ok(Recorded::by_part(&inputs))
}

/// Returns the smallest tolerance of the study of `folder` or of its process, mm; `None` if there is none.
pub(super) fn tolerance_mm(folder: &ResultFolder) -> Result<Option<f64>> {
    let keys = recorded_keys(folder)?;
    let of = |((part, key), value): (&(String, String), &String)| {
        let share = match key.rsplit('.').next() {
            Some("tolerance_mm") => 1.0,
            Some("tolerance_zone_mm") => 0.5,
            _ => return None,
        };
        let is_told = ["study", "process"].contains(&part.as_str());
        Some(share * value.parse::<f64>().ok().filter(|_| is_told)?)
    };
    Ok(keys.iter().filter_map(of).reduce(f64::min))
}

/// Returns a text cut to the longest length shown.
fn shorten(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}
