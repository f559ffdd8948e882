//! `kinetostat new`: folders that run as they are.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

fn kinetostat(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).current_dir(folder).output().unwrap()
}

/// What a command that must end with 0 prints.
fn printed(folder: &Path, arguments: &[&str]) -> String {
    let output = kinetostat(folder, arguments);
    let complained = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {complained}");
    String::from_utf8(output.stdout).unwrap()
}

fn refused(folder: &Path, arguments: &[&str], message: &str) {
    let output = kinetostat(folder, arguments);
    let complained = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert!(output.stdout.is_empty() && complained.contains(message), "{arguments:?}: {complained}");
}

/// Makes a study and runs it by the command that `new` prints, reduced.
fn runs(kind: &str, reduced: &[&str], table: &str) {
    let folder = tempfile::tempdir().unwrap();
    let said = printed(folder.path(), &["new", kind, "questions/first_try"]);
    let command = said.lines().last().unwrap().trim();
    assert_eq!(command, "kinetostat run questions/first_try");
    let readme = fs::read_to_string(folder.path().join("questions/first_try/README.md")).unwrap();
    assert!(readme.starts_with("# first_try\n") && readme.contains(command) && !readme.contains('{'), "{readme}");
    let study = fs::read_to_string(folder.path().join("questions/first_try/study.toml")).unwrap();
    let answer = printed(folder.path(), &[&["run", "questions/first_try"], reduced].concat());
    let question = study.lines().find_map(|line| line.strip_prefix("question = ")).unwrap().trim_matches('"');
    assert!(answer.starts_with(question), "{answer}");
    let table = fs::read_to_string(folder.path().join("results/first_try").join(table)).unwrap();
    assert!(table.lines().count() > 1 && !table.contains("NaN"), "{table}");
}

#[test]
fn a_new_map_runs() {
    runs("map", &["--grid", "2"], "map.csv");
}

#[test]
fn a_new_placement_runs() {
    runs("placement", &["--grid", "2"], "candidates.csv");
}

#[test]
fn a_new_superposition_runs() {
    runs("superposition", &["--grid", "2"], "map.csv");
}

#[test]
fn a_new_path_runs() {
    runs("path", &["--points", "13"], "points.csv");
}

#[test]
fn a_new_validation_runs() {
    runs("validation", &["--points", "13"], "summary.csv");
}

#[test]
fn a_new_identification_runs() {
    runs("identification", &["--no-figures"], "parameters.csv");
}

#[test]
fn a_new_plan_of_measurements_runs() {
    runs("measurements", &["--no-figures"], "sheet.csv");
}

#[test]
fn what_exists_is_kept_and_names_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), &["new", "map", "mine"]);
    let study = folder.path().join("mine/study.toml");
    fs::write(&study, "changed").unwrap();
    refused(
        folder.path(),
        &["new", "path", "mine"],
        "mine: exists already and was left as it is: expected the name of a new folder",
    );
    assert_eq!(fs::read_to_string(study).unwrap(), "changed");
    assert!(!folder.path().join("mine/process.toml").exists());
    for name in ["..", "a b", "mine ", "höhe", "a/.b"] {
        refused(folder.path(), &["new", "map", name], "does not name a study: expected a last part of letters");
    }
    refused(folder.path(), &["new", "map", "--", "-x"], "does not name a study");
    for name in ["con", "con.", "mine.", "a/NUL", "Com7.v2", "lpt0"] {
        let message = format!("NAME: \"{name}\" cannot be the name of a folder on Windows");
        refused(folder.path(), &["new", "map", name], &message);
    }
    refused(folder.path(), &["new", "dream", "mine2"], "map, path, placement, superposition, validation");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    for name in ["console", "com10", "a.con"] {
        printed(folder.path(), &["new", "map", name]);
    }
}

#[test]
fn commented_tables_of_the_templates_can_be_used_as_they_are() {
    let machine = kinetostat::machine::Machine::named_or_file("orthoglide").unwrap();
    for kind in ["path", "placement", "validation"] {
        let folder = tempfile::tempdir().unwrap();
        printed(folder.path(), &["new", kind, "mine"]);
        let text = fs::read_to_string(folder.path().join("mine/process.toml")).unwrap();
        let uncommented: String = text
            .lines()
            .map(|line| match line.strip_prefix("# ") {
                Some(rest) if rest.starts_with('[') || rest.contains(" = ") && !rest.contains("with ") => rest,
                _ => line,
            })
            .map(|line| format!("{line}\n"))
            .collect();
        for table in ["[cutting]", "[compensate]", "[limits]", "[gcode]"] {
            assert!(uncommented.lines().any(|line| line == table), "{kind}: {table}");
        }
        let process =
            kinetostat::process::file::Process::from_toml(&uncommented, "process.toml", folder.path(), &machine);
        let process = process.unwrap_or_else(|error| panic!("{kind}: {error}\n{uncommented}"));
        assert_eq!(process.limits.force_N, Some(400.0));
        assert_eq!(process.cutting_rule.below_z_mm, Some(0.5));
    }
}

#[test]
fn a_placement_study_compares_the_place_of_its_process_file() {
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), &["new", "placement", "mine"]);
    let process = folder.path().join("mine/process.toml");
    let text = fs::read_to_string(&process).unwrap();
    fs::write(&process, text.replace("# origin_mm = [0.0, 0.0, 60.0]", "origin_mm = [10.0, 0.0, 60.0]")).unwrap();
    printed(folder.path(), &["run", "mine", "--grid", "2", "--no-figures"]);
    let table = fs::read_to_string(folder.path().join("results/mine/candidates.csv")).unwrap();
    assert!(table.contains("as in the process file"), "{table}");
}
