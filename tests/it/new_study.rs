//! `kinetostat new`: folders that run as they are.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use crate::support::{machines::machine_path, results::assert_same};

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

/// Machines of which a question cannot be asked, and what is said.
const REFUSED: [(&str, &[&str], &str); 1] = [(
    "redundancy",
    &["orthoglide", "tripteron", "delta_3puu", "delta_3prpar", "rotary_delta", "hybrid_3ups"],
    "rotation about the tool axis is redundant only where the drives control all six coordinates",
)];

/// Options by which a study of a kind is computed quickly.
fn reduced(kind: &str) -> &'static [&'static str] {
    match kind {
        "map" | "placement" | "superposition" | "redundancy" => &["--grid", "2"],
        "path" | "validation" | "online" => &["--points", "7"],
        _ => &[],
    }
}

/// What of a study file makes it quick to compute: fewer directions, points, searches and trials.
const QUICKER: [(&str, &str); 9] = [
    ("phi_step_deg = 30.0", "phi_step_deg = 120.0"),
    ("gamma_step_deg = 15.0", "gamma_step_deg = 60.0"),
    ("points = 37", "points = 5"),
    ("starts = 2", "starts = 1"),
    ("max_iterations = 100", "max_iterations = 3"),
    ("steps = 5", "steps = 2"),
    ("largest_factor = 16.0", "largest_factor = 2.0"),
    ("seeds = 20", "seeds = 1"),
    ("poses = 200", "poses = 20"),
];

/// Writes the study `kind` for `machine` into a new folder of its own, computes it and returns the text of its file.
fn runs_with(kind: &str, machine: &str, reduced: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), &["new", kind, "deep/mine", "--machine", machine]);
    let file = folder.path().join("deep/mine/study.toml");
    let study = fs::read_to_string(&file).unwrap();
    let quicker = QUICKER.iter().fold(study.clone(), |text, (own, quick)| text.replace(own, quick));
    fs::write(file, quicker).unwrap();
    let run = kinetostat(folder.path(), &[&["run", "deep/mine", "--no-figures", "--verbose"], reduced].concat());
    let (said, complained) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    // What a machine does not reach is a result.
    assert!(matches!(run.status.code(), Some(0 | 1)), "{kind} with {machine}: {complained}");
    assert!(!said.contains("NaN"), "{kind} with {machine}: {said}");
    study
}

fn runs_with_the_catalogue(kinds: &[&str]) {
    for kind in kinds {
        for machine in kinetostat::machine::catalogue::names() {
            let refused_here = REFUSED.iter().find(|(own, machines, _)| own == kind && machines.contains(&machine));
            match refused_here {
                Some((.., message)) => {
                    let folder = tempfile::tempdir().unwrap();
                    refused(folder.path(), &["new", kind, "deep/mine", "--machine", machine], message);
                    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{kind} with {machine}");
                }
                None => {
                    let study = runs_with(kind, machine, reduced(kind));
                    assert!(study.contains(&format!("machine = \"{machine}\"\n")), "{study}");
                }
            }
        }
    }
}

#[test]
fn new_maps_run_with_every_machine() {
    runs_with_the_catalogue(&["map", "superposition", "redundancy"]);
}

#[test]
fn new_paths_run_with_every_machine() {
    runs_with_the_catalogue(&["path", "validation", "online"]);
}

#[test]
fn new_placements_run_with_every_machine() {
    runs_with_the_catalogue(&["placement"]);
}

#[test]
fn new_identifications_and_plans_run_with_every_machine() {
    runs_with_the_catalogue(&["identification", "measurements"]);
}

#[test]
fn new_studies_run_with_machine_files() {
    // A planar machine, one with more drives than its task needs, nested chains, and a workpiece on a carrier.
    for (name, grid) in
        [("fivebar", "2,2,1"), ("rrr3", "2,2,1"), ("kr270_rail", "2"), ("nested", "2"), ("kr270_cell", "2")]
    {
        for kind in
            ["map", "superposition", "path", "placement", "online", "validation", "identification", "measurements"]
        {
            // Placements with more drives take long.
            if kind == "placement" && ["kr270_rail", "nested"].contains(&name) {
                continue;
            }
            let is_refused = name == "kr270_cell" && ["superposition", "identification"].contains(&kind);
            if is_refused {
                let folder = tempfile::tempdir().unwrap();
                let message = "has an elastic workpiece carrier (table)";
                refused(folder.path(), &["new", kind, "mine", "--machine", &machine_path(name)], message);
                assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
                continue;
            }
            let options = if reduced(kind).contains(&"--grid") { vec!["--grid", grid] } else { reduced(kind).to_vec() };
            let study = runs_with(kind, &machine_path(name), &options);
            assert!(study.contains(&format!("machine = \"{name}.toml\"\n")), "{study}");
        }
    }
}

#[test]
fn a_machine_file_is_copied_into_the_study_under_a_free_name() {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(machine_path("hexapod")).unwrap();
    for (given, called) in [("machines/mine.toml", "mine.toml"), ("machines/Process.toml", "machine.toml")] {
        let given_path = folder.path().join(given);
        fs::create_dir_all(given_path.parent().unwrap()).unwrap();
        fs::write(&given_path, &text).unwrap();
        let name = called.replace(".toml", "_study");
        printed(folder.path(), &["new", "path", &name, "-m", given]);
        fs::remove_file(given_path).unwrap();
        assert_eq!(fs::read_to_string(folder.path().join(&name).join(called)).unwrap(), text);
        printed(folder.path(), &["run", &name, "--points", "5", "--no-figures"]);
    }
    refused(folder.path(), &["new", "map", "other", "--machine", "nowhere.toml"], "nowhere.toml: cannot be read");
    assert!(!folder.path().join("other").exists());
}

#[test]
fn what_a_new_study_says_is_of_its_machine() {
    let folder = tempfile::tempdir().unwrap();
    let written = |kind: &str, machine: &str, file: &str| {
        let name = format!("{kind}_of_{machine}");
        printed(folder.path(), &["new", kind, &name, "--machine", machine]);
        fs::read_to_string(folder.path().join(name).join(file)).unwrap()
    };
    let map = written("map", "hexapod", "study.toml");
    for part in [
        "# chain = \"leg1\"\n# drive_offsets_mm_or_deg = [0.5]\n",
        "chain = \"leg3\"",
        "slices_z_mm = [720.0, 800.0, 880.0]",
        "# min_mm = [-50.0, -50.0, 750.0]",
    ] {
        assert!(map.contains(part), "{part}: {map}");
    }
    let superposition = written("superposition", "kr270", "study.toml");
    assert!(superposition.contains("{ point = \"side\" }"), "{superposition}");
    let plan = written("measurements", "kr500", "study.toml");
    assert!(
        plan.contains("unknowns = [\"arm.J*.stiffness\"]") || plan.contains("unknowns = [\"arm.A*.stiffness\"]"),
        "{plan}"
    );
    let measured = written("identification", "orthoglide", "measurements.csv");
    assert!(measured.starts_with("pose,x_mm,y_mm,z_mm,force_x_N,") && measured.lines().count() == 17, "{measured}");
}

/// What `kinetostat run` says of a study whose machine was changed.
fn said_of(folder: &Path, file: &str, changes: &[(&str, &str)]) -> String {
    let path = folder.join(file);
    let mut text = fs::read_to_string(&path).unwrap();
    for (old, new) in changes {
        assert!(text.contains(old), "{old}: {text}");
        text = text.replace(old, new);
    }
    fs::write(path, text).unwrap();
    let output = kinetostat(folder, &["run", "mine"]);
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8(output.stderr).unwrap()
}

/// The line of `file` on which `text` begins, from 1.
fn line_of(folder: &Path, file: &str, text: &str) -> usize {
    let whole = fs::read_to_string(folder.join(file)).unwrap();
    1 + whole.lines().position(|line| line.starts_with(text)).unwrap_or_else(|| panic!("{text}: {whole}"))
}

#[test]
fn a_changed_machine_is_told_every_key_that_no_longer_fits() {
    let changed = [("machine = \"orthoglide\"", "machine = \"kr270\"\nbranch = \"front-up-noflip\"")];
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), &["new", "superposition", "mine"]);
    let said = said_of(folder.path(), "mine/study.toml", &changed);
    let line = |text: &str| line_of(folder.path(), "mine/study.toml", text);
    assert!(said.starts_with("error: 4 values do not fit machine kr270:\n"), "{said}");
    for part in [
        format!(
            "\n  mine/study.toml:{}: process.chain_error[0].chain: no chain is called \"x\"; there are: arm\n",
            line("chain = \"x\"")
        ),
        format!(
            "\n  mine/study.toml:{}: process.chain_error[1].chain: no chain is called \"y\"; there are: arm\n",
            line("chain = \"y\"")
        ),
        format!(
            "\n  mine/study.toml:{}: superposition.slices_z_mm: must be within the map's box, z 600 to 1100 mm, got -50, 25, 100\n",
            line("slices_z_mm")
        ),
        format!(
            "\n  mine/study.toml:{}: superposition.location[0].point: the machine has no point \"Q1\"; there are: centre, near, far, side\n",
            line("location")
        ),
    ] {
        assert!(said.contains(&part), "{part}{said}");
    }
    // In two files, with a branch, locked drives and limits of prismatic joints.
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), &["new", "placement", "mine", "--machine", "kr270"]);
    fs::write(
        folder.path().join("mine/process.toml"),
        fs::read_to_string(folder.path().join("mine/process.toml"))
            .unwrap()
            .replace("# [[chain_error]]", "[[chain_error]]")
            .replace("# chain = ", "chain = ")
            .replace("# drive_offsets_mm_or_deg = ", "drive_offsets_mm_or_deg = ")
            + "[redundancy]\nspeed_limits_deg_per_s = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]\n",
    )
    .unwrap();
    let changes = [
        (
            "machine = \"kr270\"",
            "machine = \"tripteron\"\nbranch = \"front-up-noflip\"\nlocked = { A1 = 0.0, rail = 3.0 }",
        ),
        ("z_mm = ", "roll_deg = 10.0\nz_mm = "),
    ];
    let said = said_of(folder.path(), "mine/study.toml", &changes);
    for part in [
        "mine/study.toml:6: branch: ",
        "mine/study.toml:7: locked.A1: no drive is called so; there are: x, y, z",
        "mine/study.toml:7: locked.rail: several drives are called so: expected x, y or another label",
        ": chain_error[0].chain: no chain is called \"arm\"; there are: x, y, z",
        ": redundancy.speed_limits_deg_per_s: machine tripteron has drives that are no revolute joints",
        ": placement.fixed.roll_deg: machine tripteron does not control rotation about x",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(
        said.contains("mine/process.toml:") && said.starts_with("error: 6 values do not fit machine tripteron:"),
        "{said}"
    );
    // Names of parameters and columns of measurements.
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), &["new", "identification", "mine"]);
    let said = said_of(folder.path(), "mine/study.toml", &[("\"fanuc_r2000ic\"", "\"hexapod\"")]);
    for part in [
        "mine/measurements.csv:1: J1_deg, J2_deg, J3_deg, J4_deg, J5_deg, J6_deg: unknown columns; expected any of leg1_mm, leg2_mm",
        ": identification.unknowns[0]: ",
        ": identification.alternative[0].unknowns[2]: ",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(said.starts_with("error: 5 values do not fit machine hexapod:"), "{said}");
}

#[test]
fn one_key_that_does_not_fit_is_named_alone_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), &["new", "path", "mine"]);
    let said = said_of(folder.path(), "mine/study.toml", &[("centre_point = \"Q0\"", "centre_point = \"Q9\"")]);
    let line = line_of(folder.path(), "mine/study.toml", "circle");
    assert_eq!(
        said,
        format!(
            "error: mine/study.toml:{line}: path.circle.centre_point: the machine has no point \"Q9\"; there are: Q0, Q1, Q2, Q3\n"
        )
    );
}

#[test]
fn the_program_has_the_examples_byte_for_byte() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    let mut folders: Vec<_> = fs::read_dir(&root).unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.sort();
    let examples: Vec<&str> = kinetostat::run::EXAMPLES.iter().map(|example| example.name).collect();
    assert_eq!(
        examples,
        folders.iter().map(|folder| folder.file_name().unwrap().to_str().unwrap()).collect::<Vec<_>>()
    );
    let target = tempfile::tempdir().unwrap();
    for (folder, name) in folders.iter().zip(examples) {
        let out = target.path().join(name);
        if !out.exists() {
            printed(target.path(), &["new", "--example", name]);
        }
        assert_same(&out, folder, name);
    }
}

#[test]
fn an_example_is_written_with_what_it_reads_and_runs() {
    let folder = tempfile::tempdir().unwrap();
    let said = printed(folder.path(), &["new", "--example", "01"]);
    assert!(said.ends_with("Next:\n  kinetostat run 01_workspace_map\n"), "{said}");
    printed(folder.path(), &["run", "01_workspace_map", "--grid", "2", "--no-figures"]);
    let said = printed(folder.path(), &["new", "--example", "08_three_architectures_3puu", "--out", "deep/puu"]);
    assert!(said.contains("deep/08_three_architectures/process.toml"), "{said}");
    printed(folder.path(), &["run", "deep/puu", "--grid", "2", "--no-figures"]);
    refused(folder.path(), &["new", "--example", "01"], "01_workspace_map: exists already");
    refused(
        folder.path(),
        &["new", "--example", "99"],
        "no example is called \"99\"; there are: 01_workspace_map, 02_groove_50mm",
    );
    refused(
        folder.path(),
        &["new", "--example", "07_robot_arm_"],
        "expected one of 07_robot_arm_fitted, 07_robot_arm_path",
    );
    refused(folder.path(), &["new", "--example", "01", "map"], "cannot be used with");
    refused(folder.path(), &["new"], "--example");
}

#[test]
fn a_study_that_is_not_there_says_where_examples_are() {
    let folder = tempfile::tempdir().unwrap();
    let message = "studies/02_groove_50mm: cannot be read: there is no such study, neither a folder with study.toml nor a file; example \
                   studies are not installed with the program: kinetostat new --example 02_groove_50mm writes one";
    refused(folder.path(), &["run", "studies/02_groove_50mm"], message);
    refused(
        folder.path(),
        &["run", "nothing", "--part", "1/2"],
        "kinetostat new --example 01_workspace_map writes one",
    );
}
