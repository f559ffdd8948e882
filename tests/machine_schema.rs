//! The schema of machine files against the files there are. Alone in its binary, so that what reads schemas is compiled quickly and nothing
//! else is made of it.

use std::{
    fs,
    path::{Path, PathBuf},
};

use kinetostat::{
    input::error::Error,
    machine::{Machine, file_schema},
};
use serde_json::Value;

fn schema() -> Value {
    file_schema().into()
}

fn root(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

fn toml_files(folder: &str) -> Vec<(PathBuf, String)> {
    let mut files: Vec<PathBuf> = fs::read_dir(root(folder)).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    files.into_iter().filter_map(|file| fs::read_to_string(&file).ok().map(|text| (file, text))).collect()
}

#[test]
fn machine_files_fit_the_schema() {
    let validator = jsonschema::validator_for(&schema()).unwrap();
    let folders = ["crates/engine/src/machine/catalogue", "tests/machines", "src/cli/templates"];
    let files: Vec<(PathBuf, String)> = folders.iter().flat_map(|folder| toml_files(folder)).collect();
    assert!(files.len() > 18, "{}", files.len());
    for (file, text) in files {
        let file_value: Value = toml::from_str(&text).unwrap();
        let faults: Vec<String> =
            validator.iter_errors(&file_value).map(|fault| format!("{}: {fault}", fault.instance_path())).collect();
        assert!(faults.is_empty(), "{}: {faults:?}", file.display());
        Machine::from_toml(&text, &file.display().to_string()).unwrap_or_else(|e| panic!("{e}"));
    }
}

/// What only the parser finds (a wrong key, a missing one, a wrong type) the schema finds, too.
#[test]
fn files_that_cannot_be_parsed_do_not_fit_the_schema() {
    let validator = jsonschema::validator_for(&schema()).unwrap();
    let mut held = 0;
    for (file, text) in toml_files("tests/bad_input/machines") {
        let name = file.file_name().unwrap().to_str().unwrap();
        let is_of_the_parser = matches!(Machine::from_toml(&text, name), Err(Error::Syntax { .. }));
        let Ok(value) = toml::from_str::<Value>(&text) else { continue };
        if is_of_the_parser {
            held += 1;
            assert!(!validator.is_valid(&value), "{name} fits the schema");
        }
    }
    assert!(held > 20, "{held}");
}
