//! Inputs of a run, recorded key by key: machine, process and study file flattened, so that two results can be compared.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use toml::Value;

use crate::input::{Inputs, to_hex};

/// Most keys recorded of one file: a larger one is identified by its hash alone.
const MAX_KEYS: usize = 4000;
/// Longest text recorded of an input that is no file, such as the size of a grid, in bytes.
const LONGEST_TEXT: usize = 200;
/// Name of the table of a study that may hold the same keys as a process file.
const PROCESS: &str = "process";

/// One input of a run, with its values key by key.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recorded {
    /// Role of the input in the run: `study`, `machine`, `process`, or its name.
    pub part: String,
    /// File name, or the name of a command-line setting.
    pub name: String,
    /// SHA-256 of its text, hexadecimal.
    pub sha256: String,
    /// Values as TOML by key, such as `chain.leg.foot.length_mm`; empty for a file without keys (a path).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub keys: BTreeMap<String, String>,
}

impl Recorded {
    /// Records the inputs of a study: its file first, its machine second, then processes, paths and command-line settings.
    pub fn of(inputs: &Inputs) -> Vec<Recorded> {
        let mut all: Vec<Recorded> = Vec::new();
        for (index, (name, text)) in inputs.texts().enumerate() {
            let table = text.parse::<toml::Table>().ok().filter(|_| index < 2 || name.ends_with(".toml"));
            let part = match (index, &table) {
                (0, _) => "study",
                (1, _) => "machine",
                (_, Some(_)) if all.iter().all(|other| other.part != PROCESS) => PROCESS,
                _ => name,
            };
            let mut keys = BTreeMap::new();
            match table {
                Some(table) => flatten("", &Value::Table(table), &mut keys),
                None if text.len() <= LONGEST_TEXT && !text.trim().contains('\n') => {
                    keys.insert(String::new(), text.trim().to_string());
                }
                None => {}
            }
            if keys.len() > MAX_KEYS {
                keys.clear();
            }
            all.push(Recorded { part: part.into(), name: name.into(), sha256: to_hex(&Sha256::digest(text)), keys });
        }
        all
    }

    /// Returns the values by part and key; a process inside the study counts as a process file.
    pub fn by_part(all: &[Recorded]) -> BTreeMap<(String, String), String> {
        let mut keys = BTreeMap::new();
        for input in all {
            for (key, value) in &input.keys {
                let process_key = key.strip_prefix(PROCESS).and_then(|rest| rest.strip_prefix('.'));
                let entry = match process_key.filter(|_| input.part == "study") {
                    Some(own) => (PROCESS.to_string(), own.to_string()),
                    None => (input.part.clone(), key.clone()),
                };
                keys.insert(entry, value.clone());
            }
            if input.keys.is_empty() {
                let value = format!("{} (SHA-256 {})", input.name, &input.sha256[..input.sha256.len().min(12)]);
                keys.insert((input.part.clone(), String::new()), value);
            }
        }
        keys
    }
}

/// Adds all values below the key `at` to `keys`. A table in a list is identified by its name, or by its number without one.
fn flatten(at: &str, value: &Value, keys: &mut BTreeMap<String, String>) {
    let key_below = |key: &str| if at.is_empty() { key.to_string() } else { format!("{at}.{key}") };
    match value {
        Value::Table(table) if !table.is_empty() => {
            table.iter().for_each(|(key, inner)| flatten(&key_below(key), inner, keys));
        }
        Value::Array(items) if items.iter().any(Value::is_table) => {
            let names: Vec<Option<&str>> = items.iter().map(name_of).collect();
            for (index, item) in items.iter().enumerate() {
                let is_unique = |name: &&str| names.iter().filter(|other| **other == Some(*name)).count() == 1;
                let number = (index + 1).to_string();
                flatten(&key_below(names[index].filter(is_unique).unwrap_or(&number)), item, keys);
            }
        }
        plain => {
            let text = plain.as_str().map_or_else(|| plain.to_string(), |text| text.trim().to_string());
            keys.insert(at.into(), text);
        }
    }
}

/// Returns the name of a table in a list, also where its only key holds the name: `{ beam = { name = "foot", … } }`; `None` without one.
fn name_of(item: &Value) -> Option<&str> {
    let table = item.as_table()?;
    let direct = ["name", "chain", "what"].iter().find_map(|key| table.get(*key)?.as_str());
    let only = table.values().next().filter(|_| table.len() == 1);
    direct.or_else(|| only?.get("name")?.as_str())
}
