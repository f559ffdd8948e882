//! Machine files: the schema that editors check them by, the ones to begin with, and the page that explains them.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::support::command::{kinetostat, printed};
use kinetostat::{
    inspect::machine_check,
    machine::{Machine, catalogue, file_schema},
};
use serde_json::Value;

fn root(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

/// Holds `expected` against a file of the repository, or writes it there.
fn is_current(file: &str, expected: &str) {
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(root(file), expected).unwrap();
    }
    let found = fs::read_to_string(root(file)).unwrap_or_default();
    let same = "UPDATE_GOLDEN=1 cargo test --all-features --test it machine_files:: renews it";
    assert!(found == expected, "{file} is not current: {same}");
}

// The schema.

fn schema() -> Value {
    file_schema().into()
}

#[test]
fn the_schema_is_the_committed_one() {
    let text = printed(&["machines", "--schema"]);
    assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), schema());
    is_current("docs/machine.schema.json", &text);
}

#[test]
fn every_key_is_explained_in_the_schema() {
    fn look(at: &Value, path: &str) {
        for (key, property) in at["properties"].as_object().into_iter().flatten() {
            let described = property["description"].as_str().is_some_and(|text| text.ends_with(['.', '`']));
            assert!(described, "{path}.{key} has no description: {property}");
        }
        for (i, way) in at["oneOf"].as_array().into_iter().flatten().enumerate() {
            assert!(way["description"].is_string(), "{path} {i} has no description: {way}");
        }
    }
    let schema = schema();
    look(&schema, "machine");
    for (name, definition) in schema["definitions"].as_object().unwrap() {
        look(definition, name);
    }
}

// Files to begin with.

/// A template with its examples: the lines on which a # has no blank behind it.
fn with_examples(template: &str) -> String {
    let line = |line: &str| {
        let code = line.trim_start();
        match code.strip_prefix('#') {
            Some(rest) if !rest.is_empty() && !rest.starts_with([' ', ':']) => line.replacen('#', "", 1),
            _ => line.to_string(),
        }
    };
    template.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn templates_are_machines_with_and_without_their_examples() {
    for kind in ["serial", "parallel"] {
        let text = printed(&["machines", "--new", kind]);
        assert!(text.starts_with("#:schema machine.schema.json\n"), "{text}");
        let examples = with_examples(&text);
        for part in ["mass = {", "{ mass =", "{ frame =", "{ spring =", "{ module =", "zeroed =", "gravity_m_per_s2"] {
            assert!(text.contains(part) && examples.contains(part), "{kind}: {part}");
        }
        for text in [text, examples] {
            let machine = Machine::from_toml(&text, kind).unwrap_or_else(|e| panic!("{e}\n{text}"));
            let warnings = machine_check::check(&machine).unwrap().warnings;
            assert!(warnings.is_empty(), "{kind}: {warnings:?}\n{text}");
        }
    }
}

#[test]
fn a_template_is_written_where_nothing_is_and_checked_by_the_next_command() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("my_robot.toml");
    let file = file.to_str().unwrap();
    let said = printed(&["machines", "--new", "serial", "--out", file]);
    assert!(said.ends_with(&format!("kinetostat check {file}\n")), "{said}");
    assert!(printed(&["check", file]).ends_with("no warnings\n"));
    assert_eq!(fs::read_to_string(file).unwrap(), printed(&["machines", "--new", "serial"]));
    let again = kinetostat(&["machines", "--new", "parallel", "--out", file]);
    let complaint = String::from_utf8(again.stderr).unwrap();
    assert!(
        again.status.code() == Some(2) && complaint.contains("exists already and was left as it is"),
        "{complaint}"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");
    let unknown = kinetostat(&["machines", "--new", "hybrid"]);
    let complaint = String::from_utf8(unknown.stderr).unwrap();
    assert!(unknown.status.code() == Some(2) && complaint.contains("serial, parallel"), "{complaint}");
}

#[test]
fn shown_files_name_the_schema_beside_them() {
    for name in catalogue::names() {
        assert!(printed(&["machines", "--show", name]).starts_with("#:schema machine.schema.json\n# "), "{name}");
    }
}

// The page.

/// What a value of this schema is, in few words.
fn kind_of(schema: &Value) -> String {
    if let Some(reference) = reference(schema) {
        return match definition_name(reference) {
            "Stiffness" => "number or \"unknown\"".into(),
            "Axis" => "\"x\", \"y\" or \"z\"".into(),
            name => format!("[{name}](#{})", name.to_lowercase()),
        };
    }
    let types: Vec<&str> = match &schema["type"] {
        Value::Array(types) => types.iter().filter_map(Value::as_str).filter(|kind| *kind != "null").collect(),
        kind => kind.as_str().into_iter().collect(),
    };
    match types.first().copied() {
        Some("array") => {
            let items = kind_of(&schema["items"]);
            match schema["maxItems"].as_u64() {
                Some(count) => format!("{count} × {items}"),
                None => format!("list of {items}"),
            }
        }
        Some("object") => format!("table of {} by name", kind_of(&schema["additionalProperties"])),
        Some("integer") => "whole number".into(),
        Some("string") => "text".into(),
        Some(kind) => kind.into(),
        None => panic!("{schema}"),
    }
}

fn reference(schema: &Value) -> Option<&str> {
    let ways = ["allOf", "anyOf"].into_iter().filter_map(|way| schema[way].as_array()).flatten();
    let inner = ways.filter_map(|way| way["$ref"].as_str());
    schema["$ref"].as_str().into_iter().chain(inner).next()
}

fn definition_name(reference: &str) -> &str {
    reference.trim_start_matches("#/definitions/").trim_end_matches("Spec")
}

/// Endings of keys, longest first, and the units they are.
const UNITS: [(&str, &str); 13] = [
    ("_mm_rad_N", "mm, rad, N"),
    ("_N_mm_rad", "N, mm, rad"),
    ("_Nmm_per_rad", "N·mm/rad"),
    ("_N_per_mm2", "N/mm²"),
    ("_N_per_mm", "N/mm"),
    ("_m_per_s2", "m/s²"),
    ("_Nmm", "N·mm"),
    ("_mm2", "mm²"),
    ("_mm", "mm"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_N", "N"),
    ("kg", "kg"),
];

/// The keys of a table: which, what, unit, whether it must be given, meaning.
fn keys(definition: &Value) -> String {
    let mut rows = "| key | value | unit | if not given | meaning |\n|---|---|---|---|---|\n".to_string();
    let required: Vec<&str> =
        definition["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let mut row = |key: &str, schema: &Value, is_required: bool| {
        let unit = UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map_or("", |(_, unit)| unit);
        let said = schema["description"].as_str().unwrap_or_default().replace('\n', " ").replace('|', "\\|");
        let (meaning, missing) = match said.strip_suffix(" if not given.").and_then(|said| said.rsplit_once("; ")) {
            Some((meaning, missing)) => (format!("{meaning}."), missing.to_string()),
            None if is_required => (said, "refused".into()),
            None => panic!("{key}: does not say what is taken if it is not given: {said}"),
        };
        rows += &format!("| `{key}` | {} | {unit} | {missing} | {meaning} |\n", kind_of(schema));
    };
    for (key, schema) in definition["properties"].as_object().into_iter().flatten() {
        row(key, schema, required.contains(&key.as_str()));
    }
    rows
}

/// Keys of which a table has one: which, what, meaning.
fn one_of(definition: &Value) -> String {
    let ways = definition["oneOf"].as_array().into_iter().flatten();
    let row = |way: &Value| {
        let (key, schema) = way["properties"].as_object()?.iter().next()?;
        Some(format!("| `{key}` | {} | {} |\n", kind_of(schema), way["description"].as_str()?))
    };
    ways.filter_map(row).fold("| key | value | meaning |\n|---|---|---|\n".into(), |rows, row| rows + &row)
}

/// Words that a key may have as value, with their meaning.
fn text(definition: &Value) -> String {
    let ways = definition["oneOf"].as_array().into_iter().flatten();
    let word = |way: &Value| {
        let (word, meaning) = (way["const"].as_str().or(way["enum"][0].as_str())?, way["description"].as_str()?);
        Some(format!("| `\"{word}\"` | {meaning} |\n"))
    };
    ways.filter_map(word).fold("| word | meaning |\n|---|---|\n".into(), |rows, row| rows + &row)
}

const BEGIN: &str = "<!-- keys of ";

#[test]
fn the_page_explains_every_key() {
    let schema = schema();
    let definitions = schema["definitions"].as_object().unwrap();
    let page = fs::read_to_string(root("docs/machine_format.md")).unwrap_or_default();
    let mut explained: Vec<String> = Vec::new();
    let mut parts = page.split(BEGIN);
    let mut current = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (name, rest) = part.split_once(" -->").expect("the end of a mark");
        let (_, rest) = rest.split_once("<!-- end -->").unwrap_or_else(|| panic!("no end of the keys of {name}"));
        let definition = match name {
            "Machine" => &schema,
            _ => definitions.get(&format!("{name}Spec")).or(definitions.get(name)).unwrap_or_else(|| panic!("{name}?")),
        };
        let table = match (&definition["properties"], &definition["oneOf"][0]["properties"]) {
            (Value::Object(_), _) => keys(definition),
            (_, Value::Object(_)) => one_of(definition),
            _ => text(definition),
        };
        explained.push(name.into());
        current += &format!("{BEGIN}{name} -->\n{table}<!-- end -->{rest}");
    }
    assert!(explained.contains(&"Machine".to_string()), "the page does not explain the file itself");
    for name in definitions.keys() {
        let name = name.trim_end_matches("Spec");
        let is_plain = ["Stiffness", "Axis"].contains(&name);
        assert!(is_plain || explained.iter().any(|other| other == name), "the page does not explain {name}");
    }
    is_current("docs/machine_format.md", &current);
    for link in current.split("](").skip(1) {
        let target = link.split(')').next().unwrap();
        if let Some(anchor) = target.strip_prefix('#') {
            let is_heading =
                |line: &str| line.starts_with('#') && line.trim_start_matches('#').trim().to_lowercase() == anchor;
            assert!(current.lines().any(is_heading), "no heading for #{anchor}");
        } else if !target.starts_with("https://") {
            assert!(root("docs").join(target).exists(), "no file {target}");
        }
    }
}
