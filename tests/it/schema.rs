//! A study has its process from a file or from the same tables of its own, and refuses what nothing in it takes.

use std::path::Path;

use kinetostat::{
    input::Folder,
    questions::{Overrides, Study},
};

const HEAD: &str = r#"schema = 3
question = "How far?"
machine = "orthoglide"
"#;

const TABLES: &str = r#"
[process.force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
law = "paper_eq17"

[[process.chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0

[process.compensate]
target = "platform_point"
"#;

const MAP: &str = r#"
[workspace_map]
grid = [2, 2, 2]
phi_step_deg = 90.0
slices_z_mm = [0.0]
"#;

const PROCESS: &str = r#"schema = 1

[force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
law = "paper_eq17"

[[chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0

[compensate]
target = "platform_point"
"#;

/// What is computed, in every digit.
fn computed(text: &str, folder: impl Into<Folder>) -> String {
    let study =
        Study::from_toml(text, "study.toml", folder, &Overrides::default()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    format!("{:?}", study.kind)
}

#[test]
fn a_map_takes_its_process_from_a_file_that_a_path_has_as_well() {
    let own = computed(&format!("{HEAD}{TABLES}{MAP}"), Path::new("."));
    let text = format!("{HEAD}process = \"process.toml\"\n{MAP}");
    let files = |process: &str| Folder::in_memory([("process.toml".to_string(), process.as_bytes().to_vec())]);
    assert_eq!(computed(&text, files(PROCESS)), own);
    // What only a path has a use for is said.
    let limited = computed(&text, files(&format!("{PROCESS}[limits]\nmax_correction_mm = 1.0\n")));
    assert!(limited.contains("not_used: [\"limits\"]"), "{limited}");
}

#[test]
fn what_no_part_of_a_study_takes_is_refused() {
    let folder = || Folder::in_memory([("p.toml".to_string(), PROCESS.as_bytes().to_vec())]);
    let validation = |top: &str, own: &str| {
        format!(
            "schema = 3\nquestion = \"?\"\nmachine = \"orthoglide\"\n{top}\n[[validation.variant]]\nname = \"a\"\n{own}\n\
             [[validation.case]]\nname = \"c\"\ncircle = {{ centre_point = \"Q1\", diameter_mm = 50.0, points = 9 }}\n"
        )
    };
    let read = |text: &str| Study::from_toml(text, "study.toml", folder(), &Overrides::default()).map(drop);
    let (top, own) = ("process = \"p.toml\"", "process = \"p.toml\"");
    read(&validation(top, "")).unwrap();
    read(&validation("", own)).unwrap();
    let said = |top: &str, own: &str| read(&validation(top, own)).unwrap_err().to_string();
    assert!(said(top, own).contains("study.toml: process: has no effect"), "{}", said(top, own));
    assert!(said("", "").contains("study.toml: process: missing"), "{}", said("", ""));
    let lost = said("process = \"lost.toml\"", "");
    assert!(lost.contains("process: \"lost.toml\" is not a file in the study's folder"), "{lost}");
}
