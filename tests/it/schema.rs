//! The two schemas of study files say the same, and `kinetostat upgrade` rewrites the first as the second.

use std::{fs, path::Path, process::Command};

use kinetostat::{
    input::Folder,
    study::{
        Overrides, Study,
        upgrade::{Upgraded, upgrade},
    },
};

const MAP: &str = r#"schema = 1 # the first
question = "How far?"
machine = "orthoglide"

# What cuts.
[milling]
radial_force_N = 215.0 # outward
tangential_force_N = -10.0
axial_force_N = -25.0
law = "printed"
# Every tool angle.
phi_step_deg = 90.0

# As built.
[[chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0

[workspace_map]
grid = [2, 2, 2]
# The platform's own point.
compensate = "platform_point"
slices_z_mm = [0.0]
"#;

const PROCESS: &str = r#"schema = 1

[force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0
law = "printed"

[[chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0

[compensate]
target = "platform_point"
"#;

fn upgraded(text: &str) -> String {
    match upgrade(text, "study.toml").unwrap() {
        Upgraded::Study(text) => text,
        Upgraded::Current(why) => panic!("{why}"),
    }
}

/// What is computed, in every digit.
fn computed(text: &str, folder: impl Into<Folder>) -> String {
    let study =
        Study::from_toml(text, "study.toml", folder, &Overrides::default()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    format!("{:?}", study.kind)
}

#[test]
fn an_upgraded_map_is_the_same_study_with_its_comments() {
    let now = upgraded(MAP);
    assert_eq!(computed(MAP, Path::new(".")), computed(&now, Path::new(".")));
    for comment in
        ["# the first", "# What cuts.\n[process.force.path_frame]", "# outward", "# Every tool angle.\nphi_step_deg"]
    {
        assert!(now.contains(comment), "{comment}\n{now}");
    }
    let more = ["# As built.\n[[process.chain_error]]", "# The platform's own point.\ntarget = \"platform_point\""];
    assert!(more.iter().all(|comment| now.contains(comment)), "{now}");
    assert_eq!(upgrade(&now, "study.toml").unwrap(), Upgraded::Current("it is of schema 2"));
    let carriage_returns = upgraded(&MAP.replace('\n', "\r\n"));
    assert_eq!(computed(&carriage_returns, Path::new(".")), computed(MAP, Path::new(".")));
}

#[test]
fn a_map_takes_its_process_from_a_file_that_a_path_has_as_well() {
    let now = upgraded(MAP);
    let (head, rest) = now.split_once("# What cuts.").unwrap();
    let (_, map) = rest.split_once("[workspace_map]").unwrap();
    let text = format!("{head}process = \"process.toml\"\n[workspace_map]{map}");
    let files = |process: &str| Folder::in_memory([("process.toml".to_string(), process.as_bytes().to_vec())]);
    assert_eq!(computed(&text, files(PROCESS)), computed(MAP, Path::new(".")));
    // What only a path has a use for is said.
    let limited = computed(&text, files(&format!("{PROCESS}[limits]\nmax_correction_mm = 1.0\n")));
    assert!(limited.contains("not_used: [\"limits\"]"), "{limited}");
}

#[test]
fn tables_written_in_braces_are_upgraded_too() {
    let text = "schema = 1\nquestion = \"?\"\nmachine = \"orthoglide\"\nmilling = { radial_force_N = 215.0, tangential_force_N = \
                -10.0, axial_force_N = -25.0, phi_step_deg = 90.0 }\nchain_error = [{ chain = \"x\", \
                turn_about_drive_axis_deg = 1.0 }]\nworkspace_map = { grid = [2, 2, 2], slices_z_mm = [0.0], compensate = \
                \"full_pose\" }\n";
    assert_eq!(computed(text, Path::new(".")), computed(&upgraded(text), Path::new(".")));
}

fn kinetostat(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).unwrap())
}

#[test]
fn the_command_rewrites_studies_and_leaves_all_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("study.toml"), MAP).unwrap();
    fs::write(at("process.toml"), PROCESS).unwrap();
    fs::write(at("broken.toml"), "schema = 1\nquestion = \n").unwrap();
    fs::write(at("notes.toml"), "title = \"mine\"\n").unwrap();
    let path = |name: &str| at(name).to_str().unwrap().to_string();
    let (code, said) = kinetostat(&["upgrade", folder.path().to_str().unwrap(), &path("process.toml")]);
    assert!(code == Some(0) && said.contains("study.toml: rewritten in schema 2"), "{said}");
    assert!(said.contains("process.toml: left as it is, process and machine files are of schema 1"), "{said}");
    assert_eq!(fs::read_to_string(at("study.toml")).unwrap(), upgraded(MAP));
    assert_eq!(fs::read_to_string(at("process.toml")).unwrap(), PROCESS);
    let (code, said) = kinetostat(&["upgrade", &path("study.toml")]);
    assert!(code == Some(0) && said.contains("left as it is, it is of schema 2"), "{said}");
    // One that cannot be read keeps the others as they are.
    fs::write(at("study.toml"), MAP).unwrap();
    for (name, expected) in
        [("broken.toml", "broken.toml"), ("notes.toml", "is neither a study nor"), ("none.toml", "none.toml")]
    {
        let (code, said) = kinetostat(&["upgrade", &path("study.toml"), &path(name)]);
        assert!(code == Some(2) && said.contains(expected), "{name}: {said}");
        assert_eq!(fs::read_to_string(at("study.toml")).unwrap(), MAP, "{name}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
}
