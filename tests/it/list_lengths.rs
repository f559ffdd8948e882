//! Lists of the wrong length: every list of numbers in every file of this repository, and every key that takes one, is
//! refused when an item is added or taken away, with file, line, key and both counts.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use kinetostat::{
    machine::Machine,
    process::Process,
    questions::{Overrides, Study, TEMPLATES},
};
use toml::{Table, Value};

/// Keys whose lists may have any length.
const ANY_LENGTH: [&str; 6] =
    ["slices_z_mm", "drive_offsets_mm_or_deg", "force_errors_percent", "tool_axes", "unknowns", "forces_N"];

/// Files that hold, all together, every key with a list of fixed length; the studies and machines of the repository
/// come on top.
const LINK_AND_AXES: &str = r#"
schema = 1
name = "gantry"
title = "gantry"
source = "test"
[platform]
tool_tip_mm = [0, 0, 0]
controls = ["x"]
[home]
position_mm = [0, 0, 0]
rotation_deg = [0, 0, 0]
[workspace]
min_mm = [0, 0, 0]
max_mm = [1, 1, 1]
[[point]]
name = "Q0"
position_mm = [0, 0, 0]
[[chain]]
name = "c"
[[chain.elements]]
fixed = { translation_mm = [0, 0, 0], rotation_deg = [0, 0, 0] }
[[chain.elements]]
prismatic_drive = { name = "a", axis = "x", stiffness_N_per_mm = 1, travel_mm = [0, 1] }
[[chain.elements]]
revolute_drive = { name = "b", axis = "x", stiffness_Nmm_per_rad = 1, travel_deg = [0, 1] }
[[chain.elements]]
prismatic_joint = { name = "c", axis = "x", limits_mm = [0, 1] }
[[chain.elements]]
revolute_joint = { name = "d", axis = "x", limits_deg = [0, 1] }
[[chain.elements]]
parallelogram = { name = "e", length_mm = 1, width_mm = 1, bar_section = { round = { diameter_mm = 1 } }, material = "m", limits_deg = [0, 1] }
[[chain.elements]]
link = { advance_mm = 1, stiffness_N_mm_rad = [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0],[0,0,0,0,0,1]] }
[[chain.elements]]
link = { advance_mm = 1, compliance_mm_rad_N = [[1,0,0,0,0,0],[0,1,0,0,0,0],[0,0,1,0,0,0],[0,0,0,1,0,0],[0,0,0,0,1,0],[0,0,0,0,0,1]] }
[[mount]]
name = "m"
chain = "c"
base = { position_mm = [0, 0, 0], rotation_deg = [0, 0, 0] }
platform = { position_mm = [0, 0, 0], x_axis = [1, 0, 0], y_axis = [0, 1, 0] }
"#;
const OFFSETS_AND_ERRORS: &str = r#"
schema = 1
placement = { origin_mm = [0, 0, 0] }
gcode = { g54_mm = [0, 0, 0], g55_mm = [0, 0, 0], g56_mm = [0, 0, 0], g57_mm = [0, 0, 0], g58_mm = [0, 0, 0], g59_mm = [0, 0, 0] }
[[chain_error]]
chain = "x"
base_translation_mm = [0, 0, 0]
base_rotation_deg = [0, 0, 0]
end_translation_mm = [0, 0, 0]
end_rotation_deg = [0, 0, 0]
"#;
const STUDIES: [&str; 4] = [
    r#"
schema = 3
question = "?"
machine = "orthoglide"
[workspace_map]
grid = [2, 2, 2]
min_mm = [0, 0, 0]
max_mm = [1, 1, 1]
slices_z_mm = [0]
"#,
    r#"
schema = 3
question = "?"
machine = "orthoglide"
process = "process.toml"
[path]
line = { start_mm = [0, 0, 0], end_mm = [1, 0, 0] }
"#,
    r#"
schema = 3
question = "?"
machine = "orthoglide"
[[placement.feature]]
name = "circle"
process = "process.toml"
circle = { centre_mm = [0, 0, 0], diameter_mm = 50, points = 9 }
tolerance_mm = 0.1
[placement]
workpiece = { min_mm = [0, 0, 0], max_mm = [1, 1, 1] }
forbidden = [{ name = "clamp", min_mm = [0, 0, 0], max_mm = [1, 1, 1] }]
bounds = { x_mm = [0, 1], y_mm = [0, 1], z_mm = [0, 1], yaw_deg = [0, 1], pitch_deg = [0, 1], roll_deg = [0, 1] }
objective = { weights = { max_deflection_mm = 1 } }
search = { grid = { x = 2 } }
candidate = [{ origin_mm = [0, 0, 0] }]
"#,
    r#"
schema = 3
question = "?"
machine = "orthoglide"
[superposition]
grid = [2, 2, 2]
min_mm = [0, 0, 0]
max_mm = [1, 1, 1]
slices_z_mm = [0]
tolerance_mm = 0.1
location = [{ position_mm = [0, 0, 0] }]
"#,
];

/// Every key with a list of fixed length.
const KEYS: [&str; 39] = [
    "base_rotation_deg",
    "base_translation_mm",
    "centre_mm",
    "compliance_mm_rad_N",
    "end_mm",
    "end_rotation_deg",
    "end_translation_mm",
    "g54_mm",
    "g55_mm",
    "g56_mm",
    "g57_mm",
    "g58_mm",
    "g59_mm",
    "grid",
    "limits_deg",
    "limits_mm",
    "max_mm",
    "min_mm",
    "origin_mm",
    "pitch_deg",
    "position_mm",
    "roll_deg",
    "rotation_deg",
    "start_mm",
    "stiffness_N_mm_rad",
    "tool_tip_mm",
    "translation_mm",
    "travel_deg",
    "travel_mm",
    "x_axis",
    "x_mm",
    "y_axis",
    "y_mm",
    "yaw_deg",
    "z_mm",
    // Rows of the two matrices.
    "compliance_mm_rad_N[0]",
    "compliance_mm_rad_N[5]",
    "stiffness_N_mm_rad[0]",
    "stiffness_N_mm_rad[5]",
];

fn open(text: &str) -> Result<(), String> {
    let table: Table = text.parse().unwrap();
    let opened = if table.contains_key("platform") {
        Machine::from_toml(text, "file.toml").map(drop)
    } else if table.contains_key("question") {
        Study::from_toml(text, "file.toml", Path::new("/nowhere"), &Overrides::default()).map(drop)
    } else {
        let machine = Machine::named_or_file("orthoglide").unwrap();
        Process::from_toml(text, "file.toml", Path::new("/nowhere"), &machine).map(drop)
    };
    opened.map_err(|error| error.to_string())
}

/// Where the lists of fixed length are: keys and indices from the top.
fn lists(value: &Value, at: &[String], found: &mut Vec<Vec<String>>) {
    let below = |step: String| [at, &[step]].concat();
    match value {
        Value::Table(table) => table.iter().for_each(|(key, value)| lists(value, &below(key.clone()), found)),
        Value::Array(items) => {
            let is_fixed = items.iter().all(|item| !item.is_table() && !item.is_str());
            if is_fixed && !at.last().is_some_and(|key| ANY_LENGTH.contains(&key.as_str())) {
                found.push(at.to_vec());
            }
            items.iter().enumerate().for_each(|(i, item)| lists(item, &below(i.to_string()), found));
        }
        _ => {}
    }
}

fn list<'a>(mut value: &'a mut Value, at: &[String]) -> &'a mut Vec<Value> {
    for step in at {
        value = match value {
            Value::Array(items) => &mut items[step.parse::<usize>().unwrap()],
            table => &mut table[step.as_str()],
        };
    }
    value.as_array_mut().unwrap()
}

/// As messages have it: `a.b[2]`.
fn key(at: &[String]) -> String {
    at.iter().fold(String::new(), |key, step| match step.parse::<usize>() {
        Ok(index) => format!("{key}[{index}]"),
        Err(_) if key.is_empty() => step.clone(),
        Err(_) => format!("{key}.{step}"),
    })
}

/// Refused, with file, line, key and counts.
fn refused(changed: &Value, at: &[String], found: usize, expected: usize) {
    let message = open(&toml::to_string(changed).unwrap()).expect_err(&format!("{} of {found} items", key(at)));
    let line = message.strip_prefix("file.toml:").and_then(|rest| rest.split_once(':')).map(|(line, _)| line);
    assert!(line.is_some_and(|line| line.parse::<usize>().is_ok()), "{message}");
    assert!(message.contains(&format!(": {}: has {found} item", key(at))), "{}: {message}", key(at));
    assert!(message.contains(&format!(", expected {expected}")), "{message}");
}

/// Changes each list of a file in turn.
fn check(text: &str, seen: &mut BTreeSet<String>) {
    let whole = Value::Table(text.parse().unwrap());
    let mut places = Vec::new();
    lists(&whole, &[], &mut places);
    for at in places {
        let mut changed = whole.clone();
        let length = list(&mut changed, &at).len();
        for extra in [Value::Integer(0), Value::Float(f64::NAN), Value::String("x".into())] {
            list(&mut changed, &at).push(extra);
            refused(&changed, &at, length + 1, length);
            list(&mut changed, &at).pop();
        }
        list(&mut changed, &at).pop();
        refused(&changed, &at, length - 1, length);
        let name = at.iter().rposition(|step| step.parse::<usize>().is_err()).unwrap();
        seen.insert(key(&at[name..]));
    }
}

/// The TOML files of a folder and those below it.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "toml") {
            found.push(path);
        }
    }
}

#[test]
fn a_list_of_another_length_is_refused_whatever_the_file_and_the_key() {
    let mut seen = BTreeSet::new();
    for text in [LINK_AND_AXES, OFFSETS_AND_ERRORS].into_iter().chain(STUDIES) {
        check(text, &mut seen);
    }
    let missing: Vec<&str> = KEYS.into_iter().filter(|key| !seen.contains(*key)).collect();
    assert!(missing.is_empty(), "not tried: {missing:?}");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    for folder in ["crates/engine/src/machine/catalogue", "src/products", "studies", "tests/machines", "fuzz/inputs"] {
        files(&root.join(folder), &mut paths);
    }
    assert!(paths.len() > 20, "{paths:?}");
    for path in paths {
        check(&fs::read_to_string(path).unwrap(), &mut seen);
    }
    for template in TEMPLATES {
        for (_, text) in template.filled(None).unwrap().iter().filter(|(name, _)| name.ends_with(".toml")) {
            check(text, &mut seen);
        }
    }
}

#[test]
fn decimal_commas_are_pointed_out() {
    let text = LINK_AND_AXES.replace("tool_tip_mm = [0, 0, 0]", "tool_tip_mm = [0,0, 0,0, 100,0]");
    let message = open(&text).unwrap_err();
    let expected =
        "file.toml:7: platform.tool_tip_mm: has 6 items, expected 3; decimals are written with a point: 0.5, not 0,5";
    assert_eq!(message, expected);
}

#[test]
fn a_list_is_no_table() {
    let text = LINK_AND_AXES
        .replace("[workspace]\nmin_mm = [0, 0, 0]\nmax_mm = [1, 1, 1]\n", "")
        .replace("schema = 1", "schema = 1\nworkspace = [[0, 0, 0], [1, 1, 1], [2, 2, 2]]");
    let message = open(&text).unwrap_err();
    assert_eq!(message, "file.toml:3: workspace: invalid type: sequence, expected a table");
}
