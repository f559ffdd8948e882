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
    match upgrade(text, "study.toml", Folder::in_memory([])).unwrap() {
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
    assert_eq!(upgrade(&now, "study.toml", Folder::in_memory([])).unwrap(), Upgraded::Current("it is of schema 2"));
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
        [("broken.toml", "broken.toml"), ("notes.toml", "notes.toml:1: "), ("none.toml", "none.toml")]
    {
        let (code, said) = kinetostat(&["upgrade", &path("study.toml"), &path(name)]);
        assert!(code == Some(2) && said.contains(expected), "{name}: {said}");
        assert_eq!(fs::read_to_string(at("study.toml")).unwrap(), MAP, "{name}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
}

const PATH: &str = r#"schema = 1
question = "?"
machine = "orthoglide"

[path]
process = "process.toml"
circle = { centre_point = "Q1", diameter_mm = 50.0, points = 9 }
"#;

#[test]
fn what_would_not_be_run_is_not_rewritten() {
    let folder = || Folder::in_memory([("process.toml".to_string(), PROCESS.as_bytes().to_vec())]);
    let Upgraded::Study(text) = upgrade(PATH, "study.toml", folder()).unwrap() else { panic!("a study") };
    assert!(text.contains("machine = \"orthoglide\"\nprocess = \"process.toml\"\n"), "{text}");
    let errors = "\n[[chain_error]]\nchain = \"x\"\nturn_about_drive_axis_deg = 1.0\n";
    for (text, expected) in [
        (format!("{PATH}{errors}"), "chain_error: belongs in the process file of a path study"),
        (
            MAP.replace("[workspace_map]", "[workspace_map]\nphi_step_deg = 45.0"),
            "workspace_map.phi_step_deg: belongs in",
        ),
        (MAP.replace("chain = \"x\"", "chain = \"w\""), "chain_error[0].chain: no chain is called"),
        (MAP.replace("schema = 1", "schema = 1.0"), "study.toml:1: schema: invalid type"),
        (MAP.replace("machine =", "question = \"?\"\nmachine ="), "study.toml:3: key `question` is given twice"),
    ] {
        let error = upgrade(&text, "study.toml", folder()).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

#[test]
fn what_no_part_of_a_study_takes_is_refused() {
    let folder = || Folder::in_memory([("p.toml".to_string(), PROCESS.as_bytes().to_vec())]);
    let validation = |top: &str, own: &str| {
        format!(
            "schema = 2\nquestion = \"?\"\nmachine = \"orthoglide\"\n{top}\n[[validation.variant]]\nname = \"a\"\n{own}\n\
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

#[cfg(unix)]
#[test]
fn a_rewritten_file_keeps_its_mode_and_its_line_ends() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("study.toml");
    let run = || kinetostat(&["upgrade", file.to_str().unwrap()]);
    fs::write(&file, format!("\u{feff}{}", MAP.replace('\n', "\r\n"))).unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o400)).unwrap();
    let (code, said) = run();
    assert!(code == Some(2) && said.contains("study.toml: cannot be written: is read-only"), "{said}");
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
    fs::hard_link(&file, folder.path().join("other.toml")).unwrap();
    let (code, said) = run();
    assert!(code == Some(2) && said.contains("has other names"), "{said}");
    fs::remove_file(folder.path().join("other.toml")).unwrap();
    assert_eq!(run().0, Some(0));
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.starts_with('\u{feff}') && text.matches('\n').count() == text.matches("\r\n").count(), "{text:?}");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
}
