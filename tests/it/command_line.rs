//! The program as its user meets it: commands, exit codes, what is printed where, what is written.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use crate::support::{Within, reference};
use kinetostat::{
    Error,
    ending::{Ending, exit_code},
    files::per_second,
    inspect::machine_check,
    machine::{Machine, catalogue},
};
use serde_json::{Value, json};

const STUDY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/01_workspace_map");

fn kinetostat(arguments: &[&str]) -> Output {
    let folder = std::env::temp_dir();
    Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).current_dir(folder).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// What a command that must end with `code` prints.
fn printed(code: i32, arguments: &[&str]) -> String {
    let output = kinetostat(arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
    if code < 2 {
        assert_eq!(stderr(&output), "", "{arguments:?}: a command that ran has nothing to say on stderr");
    }
    stdout(&output)
}

/// Bad input: exit code 2, nothing on stdout, and `message` on stderr.
fn refused(arguments: &[&str], message: &str) {
    let output = kinetostat(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert_eq!(stdout(&output), "", "{arguments:?}: nothing is printed for bad input");
    let found = stderr(&output);
    assert!(found.contains(message), "{arguments:?}\n  expected: {message}\n  found:    {found}");
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn numbers(json: &Value) -> Vec<f64> {
    match json {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().unwrap_or_else(|| panic!("{number} is not a number"))],
    }
}

/// Numbers as one argument.
fn joined(json: &Value) -> String {
    numbers(json).iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

// Help and machines.

#[test]
fn the_help_of_every_command_shows_examples() {
    for command in [
        &["--help"][..],
        &["run", "--help"],
        &["report", "--help"],
        &["point", "--help"],
        &["machines", "--help"],
        &["check", "--help"],
        &["new", "--help"],
        &["export-correction", "--help"],
        &["completions", "--help"],
    ] {
        let help = printed(0, command);
        let examples = help.split_once("Examples:").unwrap_or_else(|| panic!("{command:?} has no examples")).1;
        assert!(examples.contains("\n  kinetostat "), "{command:?}: {examples}");
    }
    let commands = printed(0, &["--help"]);
    for command in ["run", "report", "point", "machines", "check", "new", "export-correction"] {
        assert!(commands.contains(&format!("\n  {command} ")), "{command} is not listed");
    }
}

#[test]
fn shells_complete_every_command() {
    let help = printed(0, &["--help"]);
    let listed = help.split_once("Commands:\n").unwrap().1.split_once("\n\n").unwrap().0;
    let commands: Vec<&str> = listed.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(commands.contains(&"compensate") && commands.contains(&"completions"), "{commands:?}");
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let script = printed(0, &["completions", shell]);
        for word in commands.iter().chain(["chain-errors"].iter()) {
            assert!(script.contains(word), "{shell} does not know {word}");
        }
        assert!(script.contains("viridis") || shell == "powershell", "{shell} knows no values");
    }
    refused(&["completions", "tcsh"], "possible values: bash");
}

#[test]
fn machines_lists_the_catalogue() {
    let list = printed(0, &["machines"]);
    for name in catalogue::names() {
        assert!(list.contains(name), "{list}");
    }
}

#[test]
fn check_says_the_same_of_a_machine_and_of_its_printed_file() {
    let folder = tempfile::tempdir().unwrap();
    for name in catalogue::names() {
        let file = folder.path().join(format!("{name}.toml"));
        fs::write(&file, printed(0, &["machines", "--show", name])).unwrap();
        let findings = printed(0, &["check", name]);
        for expected in [
            "mobility",
            "over-constraint",
            "char. length",
            "round trip",
            "tool stiffness",
            "K_C at home",
            "where the parameters come from",
        ] {
            assert!(findings.contains(expected), "{name}: {expected} is missing in\n{findings}");
        }
        assert_eq!(findings, printed(0, &["check", path(&file)]));
    }
}

#[test]
fn check_warns_of_no_machine_of_the_catalogue_but_of_travel_that_nobody_published() {
    for entry in catalogue::ENTRIES {
        let machine = Machine::from_toml(entry.toml, entry.name).unwrap();
        let grades: Vec<&str> = machine.provenance.iter().map(|told| told.grade.label()).collect();
        // The hybrid is an example of its kind: all numbers are our own.
        let is_example = entry.name == "hybrid_3ups";
        let has_source = grades.contains(&"published") || grades.contains(&"data_sheet");
        assert!(grades.contains(&"assumed") && has_source != is_example, "{}: {grades:?}", entry.name);
        let warnings = machine_check::check(&machine).unwrap().warnings;
        let without_travel = ["orthoglide", "tripteron"].contains(&entry.name);
        assert_eq!(warnings.len(), usize::from(without_travel), "{}: {warnings:?}", entry.name);
        assert!(warnings.iter().all(|warning| warning.contains("no travel is given")), "{warnings:?}");
        let findings = printed(0, &["check", entry.name]);
        for told in &machine.provenance {
            let line = format!("    {:<11} {} (line ", told.grade.label(), told.what);
            assert!(findings.contains(&line) && findings.contains(&told.source), "{line} is missing in\n{findings}");
        }
    }
}

// One point.

/// The point of a reference state, solved by the program.
fn point_of(state: &Value, load: &[&str]) -> Value {
    let (position, assembly) = (joined(&state["position_mm"]), joined(&state["assembly_deg"]));
    let common = ["point", "--machine", "orthoglide", "--position", &position, "--chain-errors", &assembly, "--json"];
    serde_json::from_str(&printed(0, &[&common[..], load].concat())).unwrap()
}

fn milling(state: &Value) -> Vec<String> {
    state["phi_deg"]
        .as_f64()
        .map_or_else(Vec::new, |phi| vec!["--phi".into(), phi.to_string(), "--law".into(), "paper_eq17".into()])
}

#[test]
fn point_prints_the_reference_states_with_their_keys() {
    let states = reference("orthoglide");
    let states = states.as_array().unwrap();
    assert_eq!(states.len(), 12);
    for state in states {
        let load = milling(state);
        let found = point_of(state, &load.iter().map(String::as_str).collect::<Vec<_>>());
        let keys = |object: &Value| object.as_object().unwrap().keys().cloned().collect::<BTreeSet<String>>();
        // The program has one name for errors of chains, whatever they come from.
        let mut state = state.clone();
        let errors = state.as_object_mut().unwrap().remove("assembly_deg").unwrap();
        state["chain_errors_deg"] = errors;
        let mut expected_keys = keys(&state);
        expected_keys.extend(NEW_IN_POINT.map(String::from));
        assert_eq!(keys(&found), expected_keys);
        assert_eq!((&found["status"], &found["compensation_status"]), (&json!("solved"), &json!("solved")));
        assert!(found["reason"].is_null() && found["compensation_reason"].is_null());
        assert!(found["tip_error_after_compensation_norm_mm"].as_f64().unwrap() < 1e-9);
        assert!(found["residual"].as_f64().unwrap() <= 1e-10);
        assert!(found["iterations"].as_u64().is_some());
        for (key, expected) in state.as_object().unwrap() {
            if key == "phi_deg" {
                assert_eq!(found[key].as_f64(), expected.as_f64());
            } else {
                within(key).check(key, &numbers(&found[key]), &numbers(expected));
            }
        }
    }
}

/// Keys of `point --json` that reference states have not.
const NEW_IN_POINT: [&str; 20] = [
    "branch",
    "cautions",
    "clearance",
    "conditioning",
    "schema",
    "drives",
    "status",
    "reason",
    "compensation_status",
    "compensation_reason",
    "tip_error_after_compensation_mm",
    "tip_error_after_compensation_norm_mm",
    "tool_axis",
    "force_tool_frame_N",
    "iterations",
    "zeroed",
    "platform_turn_rad",
    "tool_displacement_by_weight_mm",
    "tool_play_mm",
    "residual",
];

/// The accuracy that `tests/reference/README.md` states.
fn within(key: &str) -> Within {
    match key {
        "stiffness_unloaded" => Within::Stiffness(1e-9),
        "stiffness_loaded" => Within::Stiffness(1e-5),
        "platform_rotvec_rad" | "compensated_rotvec_rad" => Within::Absolute(1e-10),
        "actuator_force_N" | "compensated_actuator_force_N" | "chain_wrench_N_Nmm" => Within::RelativeToLargest(1e-5),
        _ => Within::Absolute(1e-8),
    }
}

#[test]
fn the_same_load_as_a_wrench_gives_the_same_point() {
    let states = reference("orthoglide");
    let loaded = states.as_array().unwrap().iter().filter(|state| !state["phi_deg"].is_null());
    for state in loaded.take(3) {
        let phi = milling(state);
        let by_angle = point_of(state, &phi.iter().map(String::as_str).collect::<Vec<_>>());
        let wrench = joined(&by_angle["wrench_N_Nmm"]);
        let mut by_wrench = point_of(state, &["--wrench", &wrench]);
        assert!(by_wrench["phi_deg"].is_null());
        by_wrench["phi_deg"] = by_angle["phi_deg"].clone();
        assert_eq!(by_angle, by_wrench);
    }
}

#[test]
fn point_reads_well_and_knows_named_points() {
    let by_name = printed(0, &["point", "--machine", "orthoglide", "--at", "Q1", "--phi", "130"]);
    let by_position = ["point", "--machine", "orthoglide", "--position", "126.35,126.35,126.35", "--phi", "130"];
    assert_eq!(by_name, printed(0, &by_position));
    for expected in ["The tool moves by ", "to keep the tool there, command x +", "mrad", "compensated ρ"] {
        assert!(by_name.contains(expected), "{expected} is missing in\n{by_name}");
    }
}

/// Every caution that the text of a point says is in its JSON, and no other.
#[test]
fn cautions_of_a_point_are_said_to_programs_too() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("limited.toml");
    let own = fs::read_to_string("crates/engine/src/machine/catalogue/orthoglide.toml").unwrap();
    let limited = own.replace("prismatic_drive = { ", "prismatic_drive = { force_limit_N = 50.0, ");
    assert_ne!(own, limited);
    fs::write(&file, limited).unwrap();
    let limited = file.to_str().unwrap();
    let outside = ["--position", "135,0,0", "--phi", "0"];
    let cases: [(&str, &[&str], &[&str]); 5] = [
        ("orthoglide", &["--at", "Q0", "--phi", "0"], &[]),
        ("orthoglide", &outside, &["outside the workspace: "]),
        (limited, &["--at", "Q1", "--phi", "0"], &["drive x is beyond its force limit: "]),
        (limited, &outside, &["outside the workspace: ", "drive x is beyond its force limit: "]),
        ("orthoglide", &["--at", "Q0", "--phi", "0", "--chain-errors", "9,0,0"], &["large error: "]),
    ];
    for (machine, asked, expected) in cases {
        let asked = [&["point", "--machine", machine][..], asked].concat();
        let text = printed(0, &asked);
        let found: Value = serde_json::from_str(&printed(0, &[&asked[..], &["--json"]].concat())).unwrap();
        let cautions: Vec<&str> =
            found["cautions"].as_array().unwrap().iter().map(|own| own.as_str().unwrap()).collect();
        for begin in expected {
            assert!(cautions.iter().any(|caution| caution.starts_with(begin)), "{begin}: {cautions:?}");
        }
        assert_eq!(cautions.is_empty(), expected.is_empty(), "{cautions:?}");
        for caution in cautions {
            let said = caution
                .split_once(": ")
                .filter(|(what, _)| !what.starts_with("drive "))
                .map_or(caution, |(_, said)| said);
            assert!(text.contains(said), "{said} is missing in\n{text}");
        }
    }
}

#[test]
fn an_unreachable_point_is_an_answer_with_a_reason() {
    let arguments = ["point", "--machine", "orthoglide", "--position", "400,0,0", "--phi", "0"];
    let text = printed(1, &arguments);
    assert!(
        text.starts_with("unreachable: chain ") && text.contains("cannot close there; continuation from home stops "),
        "{text}"
    );
    let output = kinetostat(&[&arguments[..], &["--json"]].concat());
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("cannot close"), "the reason is beside the object");
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(json["status"], "unreachable");
    assert!(json["reason"].as_str().unwrap().contains("cannot close"), "{json}");
    let solved = printed(0, &["point", "--machine", "orthoglide", "--at", "Q0", "--phi", "0", "--json"]);
    let solved: Value = serde_json::from_str(&solved).unwrap();
    let keys = |json: &Value| json.as_object().unwrap().keys().cloned().collect::<BTreeSet<_>>();
    assert_eq!(keys(&json), keys(&solved), "the same keys whether reached or not");
}

#[test]
fn a_load_that_nothing_withstands_is_an_answer_with_a_reason() {
    let arguments = ["point", "--machine", "orthoglide", "--at", "Q0", "--wrench", "1e9,0,0,0,0,0"];
    let text = printed(1, &arguments);
    assert!(text.contains("not_converged") && text.contains("no equilibrium beyond"), "{text}");
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    let json: Value = serde_json::from_str(&printed(1, &[&arguments[..], &["--json"]].concat())).unwrap();
    assert_eq!(json["status"], "not_converged");
    assert!(json["reason"].as_str().unwrap().contains("no equilibrium beyond"), "{json}");
    assert_eq!(json["compensation_status"], "not_tried");
    assert!(json["platform_mm"].is_null() && json["delta_rho_mm"].is_null());
}

fn foreign(name: &str) -> String {
    format!("{}/tests/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn drive_values_of_hinges_have_keys_of_their_own_unit() {
    let machine = foreign("kr270");
    let wrench = ["--wrench", "200,-150,-50,0,0,0"];
    let arguments = [&["point", "--machine", &machine, "--position", "1600,0,1000"][..], &wrench].concat();
    let json: Value = serde_json::from_str(&printed(0, &[&arguments[..], &["--json"]].concat())).unwrap();
    assert_eq!(json["schema"], 3);
    let drives = json["drives"].as_array().unwrap();
    assert_eq!(drives.len(), 6);
    let expected = json!({
        "label": "robot_A1", "chain": "robot", "motion": "revolute", "position_unit": "deg", "force_unit": "Nmm",
    });
    assert_eq!(drives[0], expected);
    for key in ["rho_nominal_deg", "rho_compensated_deg", "delta_rho_deg", "actuator_torque_Nmm"] {
        assert_eq!(numbers(&json[key]).len(), 6, "{key}");
    }
    for key in ["rho_nominal_mm", "rho_compensated_mm", "delta_rho_mm", "actuator_force_N"] {
        assert!(json.get(key).is_none(), "{key} would hold degrees or N·mm");
    }
    let [rho, after, change] =
        ["rho_nominal_deg", "rho_compensated_deg", "delta_rho_deg"].map(|key| numbers(&json[key]));
    for d in 0..6 {
        assert!((after[d] - rho[d] - change[d]).abs() < 1e-9);
    }
    let text = printed(0, &arguments);
    assert!(text.contains("torque before") && text.contains("N·mm") && !text.contains("force before"), "{text}");
    assert!(!text.contains(" deg"), "degrees have one sign\n{text}");
}

/// Three slides and a beam; `end` is put behind the beam.
fn gantry(end: &str) -> String {
    format!(
        r#"schema = 1
name = "gantry"
title = "Three slides and a beam"
platform = {{ tool_tip_mm = [0.0, 0.0, -50.0], controls = ["x", "y", "z"] }}
home = {{ position_mm = [100.0, 0.0, 0.0] }}
workspace = {{ min_mm = [0.0, -100.0, -100.0], max_mm = [200.0, 100.0, 100.0] }}
material = {{ steel = {{ youngs_modulus_N_per_mm2 = 210000.0, shear_modulus_N_per_mm2 = 81000.0 }} }}
mount = [{{ name = "arm", chain = "arm" }}]
[[chain]]
name = "arm"
elements = [
  {{ prismatic_drive = {{ name = "x", axis = "x", stiffness_N_per_mm = 1e5, travel_mm = [-60.0, 60.0] }} }},
  {{ prismatic_drive = {{ name = "y", axis = "y", stiffness_N_per_mm = 1e5 }} }},
  {{ prismatic_drive = {{ name = "z", axis = "z", stiffness_N_per_mm = 1e5 }} }},
  {{ beam = {{ length_mm = 100.0, section = {{ round = {{ diameter_mm = 40.0 }} }}, material = "steel" }} }},
  {end}
]
"#
    )
}

#[test]
fn a_platform_that_turns_freely_is_singular() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("gantry.toml");
    fs::write(&file, gantry(r#"{ revolute_joint = { name = "q", axis = "x" } },"#)).unwrap();
    for wrench in ["0,0,0,0,0,0", "0,1,0,0,0,0", "100,10,1,0,0,0"] {
        let text = printed(1, &["point", "--machine", path(&file), "--position", "50,0,0", "--wrench", wrench]);
        assert!(text.contains("singular") && text.contains("the platform can move without resistance"), "{text}");
    }
    let text = printed(0, &["check", path(&file)]);
    assert!(text.contains("warning: home: motions left with all drives locked: 1 (expected: 0)"), "{text}");
}

#[test]
fn what_a_terminal_would_act_upon_is_written_out() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("gantry.toml");
    fs::write(&file, gantry("").replace("Three slides", "Three\u{202e} slides")).unwrap();
    let text = printed(0, &["check", path(&file)]);
    assert!(text.contains(r"Three\u{202e} slides") && !text.contains('\u{202e}'), "{text}");
    let missing = folder.path().join("no\u{1b}[31m\u{202e}thing.toml");
    let output = kinetostat(&["check", path(&missing)]);
    let said = stderr(&output);
    assert!(said.contains(r"no\u{1b}[31m\u{202e}thing.toml") && !said.contains(['\u{1b}', '\u{202e}']), "{said}");
}

#[test]
fn a_command_beyond_the_travel_is_not_given() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("gantry.toml");
    fs::write(&file, gantry("")).unwrap();
    let at = ["point", "--machine", path(&file), "--position", "159.999,0,0", "--wrench"];
    // 1000 N move the prismatic joint by 0.01 mm: against −x the command would have to lie beyond 60 mm.
    printed(0, &[&at[..], &["1000,0,0,0,0,0"]].concat());
    let text = printed(1, &[&at[..], &["-1000,0,0,0,0,0"]].concat());
    let reason = "not compensated: drive x of chain arm at 60.009 mm, travel -60.000 to 60.000 mm";
    assert!(text.contains(reason), "{text}");
}

#[test]
fn a_stiffness_a_thousand_times_too_small_is_a_warning_in_a_design_mounted_three_times() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("soft.toml");
    let tripteron = printed(0, &["machines", "--show", "tripteron"]);
    fs::write(&file, tripteron.replace("stiffness_N_per_mm = 1000.0", "stiffness_N_per_mm = 1.0")).unwrap();
    let text = printed(0, &["check", path(&file)]);
    assert!(text.contains("warning: x, y, z rail: makes 99.98"), "{text}");
}

/// A revolute drive whose axis passes through the tool tip of [`gantry`].
const SPINDLE_HINGE: &str = r#"{ revolute_drive = { name = "c", axis = "z", stiffness_Nmm_per_rad = 1e8 } },"#;

#[test]
fn a_drive_that_cannot_move_the_tool_tip_for_its_place_is_no_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("gantry.toml");
    fs::write(&file, gantry(SPINDLE_HINGE)).unwrap();
    let text = printed(0, &["check", path(&file)]);
    assert!(text.contains("arm c ") && !text.contains("1000 times too large"), "{text}");
}

#[test]
fn hinges_are_summed_up_in_their_own_units() {
    let folder = tempfile::tempdir().unwrap();
    let study = write_study(folder.path(), "gantry.toml", 50.0, 60.0);
    fs::write(study.join("gantry.toml"), gantry(SPINDLE_HINGE)).unwrap();
    let (_, text) = run(path(&study), folder.path(), "1", 0);
    assert!(!text.contains(" or "), "one unit for one number\n{text}");
    for kind in ["correct the prismatic joints by up to ", "correct the revolute joints by up to 0.0000°, tool tip at "]
    {
        assert!(text.contains(kind), "{text}");
    }
    assert!(
        text.contains("Drive forces of prismatic joints reach")
            && text.contains("Drive torques of revolute joints reach"),
        "{text}"
    );
}

#[test]
fn a_home_that_the_chains_do_not_hold_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("gantry.toml");
    let turned = gantry("").replace("[100.0, 0.0, 0.0] }", "[100.0, 0.0, 0.0], rotation_deg = [0.0, 90.0, 0.0] }");
    fs::write(&file, turned).unwrap();
    let text = printed(0, &["check", path(&file)]);
    let warning =
        "the chains hold the platform at (100.000, 0.000, 0.000) mm, which is 0.000 mm and 90.000° from the home";
    assert!(text.contains(warning), "{text}");
    fs::write(&file, gantry("")).unwrap();
    assert!(!printed(0, &["check", path(&file)]).contains("the chains hold the platform at"));
}

// Mistakes.

#[test]
fn mistakes_on_the_command_line_are_refused() {
    let point = ["point", "--machine", "orthoglide"];
    let at = |more: &[&'static str]| [&point[..], &["--at", "Q0"], more].concat();
    let cases: Vec<(Vec<&str>, &str)> = vec![
        (vec![], "Usage: kinetostat <COMMAND>"),
        (vec!["mill"], "unrecognized subcommand 'mill'"),
        (point.to_vec(), "<--position <POSITION>|--at <AT>|--pose <X,Y,Z,ROLL,PITCH,YAW>|--joints <J1,J2,…>>"),
        (
            [&point[..], &["--at", "Q9"]].concat(),
            "--at: machine orthoglide has no point \"Q9\"; there are: Q0, Q1, Q2, Q3",
        ),
        ([&point[..], &["--position", "1,2"]].concat(), "expected 3 numbers separated by commas, got 2"),
        ([&point[..], &["--position", "1,2,far"]].concat(), "\"far\" is not a number"),
        ([&point[..], &["--position", "1,2,nan"]].concat(), "\"nan\" is not between -1e18 and 1e18"),
        (at(&["--position", "1,2,3"]), "cannot be used with"),
        (at(&["--wrench", "1,2,3"]), "expected 6 numbers separated by commas, got 3"),
        (at(&["--wrench", "1e308,0,0,0,0,0"]), "\"1e308\" is not between -1e18 and 1e18"),
        (at(&["--wrench", "1,2,3,4,5,6", "--phi", "0"]), "cannot be used with"),
        (at(&["--phi", "nan"]), "\"nan\" is not between"),
        (at(&["--phi", "0", "--law", "sideways"]), "[possible values: paper_eq17, rotated]"),
        (at(&["--law", "rotated"]), "--phi <PHI>"),
        (at(&["--force", "1,2,3", "--wrench", "1,2,3,4,5,6"]), "cannot be used with"),
        (at(&["--chain-errors", "1,2"]), "--chain-errors: expected 3 angles, one per chain of orthoglide, got 2"),
        (
            vec!["machines", "--show", "delta"],
            "--show: no built-in machine \"delta\"; there are: orthoglide, tripteron, delta_3puu, delta_3prpar, rotary_delta, hexapod, fanuc_r2000ic, kr270, kr500, irb7600, ur10e, ur5e, hybrid_3ups",
        ),
        (vec!["check", "delta"], "machine: no built-in machine \"delta\" and no file of this name"),
        (vec!["check", "nowhere.toml"], "nowhere.toml: cannot be read: "),
        (vec!["check", env!("CARGO_BIN_EXE_kinetostat")], "kinetostat: cannot be read: "),
        (vec!["check", env!("CARGO_MANIFEST_DIR")], "cannot be read: "),
        (vec!["run", "nowhere"], "nowhere: cannot be read: "),
        (vec!["run", env!("CARGO_MANIFEST_DIR")], "study.toml: cannot be read: "),
    ];
    for (arguments, message) in cases {
        refused(&arguments, message);
    }
}

#[test]
fn mistakes_in_a_run_are_found_before_anything_is_computed_or_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let broken = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bad_input/studies/grid_zero.toml");
    let run = |study, more: &[&'static str]| [&["run", study, "--out", path(&out)], more].concat();
    refused(&run(broken, &[]), "grid_zero.toml: workspace_map.grid: must be at least 1 along each axis");
    refused(&run(STUDY, &["--grid", "0"]), "--grid: must be at least 1 along each axis");
    refused(&run(STUDY, &["--grid", "1000"]), "at most 100000000 in all, got [1000, 1000, 1000]");
    refused(&run(STUDY, &["--grid", "3,3"]), "expected one count or three, got 2");
    let too_large = "--format: an image has at most 2000000 points, the grid of 01_workspace_map 2000100";
    refused(&run(STUDY, &["--grid", "20001,10,10", "--format", "csv,vti"]), too_large);
    refused(&run(STUDY, &["--grid", "many"]), "\"many\" is not a count");
    refused(&run(STUDY, &["--grid", "-1"]), "\"-1\" is not a count");
    refused(&run(STUDY, &["--threads", "0"]), "0 is not in 1..");
    refused(&run(STUDY, &["--points", "9"]), "--points: a workspace map has no points along a path, but a grid");
    let groove = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/02_groove_50mm");
    refused(&run(groove, &["--grid", "3"]), "--grid: a path study has no grid, but points along a path");
    assert!(!out.exists(), "bad input leaves no folder behind");

    fs::write(&out, "not a folder").unwrap();
    refused(&run(STUDY, &["--grid", "2"]), "out: cannot be written: ");
    assert_eq!(fs::read_to_string(&out).unwrap(), "not a folder");
}

/// What a command with its stdout going to `file` says on stderr, and its exit code.
#[cfg(target_os = "linux")]
fn printing_to(file: std::process::Stdio, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).stdout(file).output().unwrap();
    (output.status.code(), stderr(&output))
}

#[test]
#[cfg(target_os = "linux")]
fn a_reader_that_goes_away_is_no_fault_but_a_full_disk_is() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let run = ["run", STUDY, "--grid", "1", "--no-figures", "--out", path(&out)];
    for arguments in
        [&["machines"][..], &["check", "orthoglide"], &["point", "--machine", "orthoglide", "--at", "Q0"], &run]
    {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        assert_eq!(printing_to(writer.into(), arguments), (Some(0), String::new()), "{arguments:?}");
        let full = fs::File::create("/dev/full").unwrap();
        let (code, message) = printing_to(full.into(), arguments);
        assert_eq!(code, Some(2), "{arguments:?}");
        assert!(message.starts_with("error: standard output: cannot be written: "), "{arguments:?}: {message}");
    }
    assert!(out.join("map.csv").exists());
}

// A study.

const FIGURES: [&str; 11] = [
    "answer",
    "answer_portrait",
    "slices_deflection_cutting",
    "slices_deflection_all",
    "slices_delta_rho_all",
    "slices_superposition_all",
    "slices_stiffness_min_cutting",
    "slices_worst_angle_all",
    "workspace_deflection_all",
    "machine_at_home",
    "machine_deflected",
];

fn file_names(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// A table as its header and its rows, all of the header's length.
fn table(folder: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    // The reader refuses rows of another length.
    let mut reader = csv::Reader::from_path(folder.join("map.csv")).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(String::from).collect();
    let rows = reader.records().map(|row| row.unwrap().iter().map(String::from).collect()).collect();
    (header, rows)
}

/// Columns without numbers.
const WORDS: [&str; 5] = ["source", "status", "reason", "correction_status", "correction_reason"];

/// A row is solved and full of finite numbers, or has a status with a reason and no numbers; its correction likewise.
fn check_row(header: &[String], row: &[String]) {
    let column = |name: &str| header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column {name}"));
    let (source, status, reason) = (&row[column("source")], &row[column("status")], &row[column("reason")]);
    assert!(["cutting", "geometry", "all"].contains(&source.as_str()), "{row:?}");
    assert_eq!(status == "solved", reason.is_empty(), "{row:?}");
    assert!(!status.is_empty(), "{row:?}");
    let (correction_status, reason) = (&row[column("correction_status")], &row[column("correction_reason")]);
    assert_eq!(correction_status == "solved", reason.is_empty(), "{row:?}");
    for (name, cell) in header.iter().zip(row) {
        let is_word = WORDS.contains(&name.as_str());
        let is_position = ["x_mm", "y_mm", "z_mm"].contains(&name.as_str());
        let is_superposition_error = name.starts_with("superposition_error") && source != "all";
        let is_angle = name == "deflection_phi_deg" && source == "geometry";
        if is_word {
            continue;
        }
        let status = if name.starts_with("delta_rho") { correction_status } else { status };
        let is_empty = !is_position && (status != "solved" || is_superposition_error || is_angle);
        assert_eq!(cell.is_empty(), is_empty, "{name} of {row:?}");
        if !cell.is_empty() {
            assert!(cell.parse::<f64>().unwrap().is_finite(), "{name} of {row:?}");
        }
    }
}

/// Every column of numbers says its unit, but for the ratio.
fn check_units(header: &[String]) {
    let units = ["_mm", "_deg", "_N", "_Nmm", "_N_per_mm"];
    for name in header.iter().filter(|name| !WORDS.contains(&name.as_str())) {
        assert!(
            units.iter().any(|unit| name.ends_with(unit)) || name == "superposition_error_over_deflection",
            "{name}: no unit"
        );
    }
}

fn check_json(file: &Path) -> Value {
    fn no_null_numbers(value: &Value, key: &str) {
        match value {
            // A number that is not finite is written as null.
            Value::Null => assert!(["phi_deg", "seed"].contains(&key), "{key} is null"),
            Value::Array(items) => items.iter().for_each(|item| no_null_numbers(item, key)),
            Value::Object(items) => items.iter().for_each(|(key, item)| no_null_numbers(item, key)),
            _ => {}
        }
    }
    let json = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
    no_null_numbers(&json, "");
    json
}

fn check_figures(folder: &Path) {
    for name in FIGURES {
        let svg = fs::read_to_string(folder.join(format!("{name}.svg"))).unwrap();
        assert!(svg.contains("<svg") && svg.trim_end().ends_with("</svg>"), "{name}.svg");
        assert!(!svg.contains("<text") && svg.contains("<use href="), "{name}.svg");
        assert!(!svg.contains("NaN") && !svg.contains("\"inf"), "{name}.svg");
        let png = image::open(folder.join(format!("{name}.png"))).unwrap().to_rgb8();
        assert!(png.width() >= 800 && png.height() >= 400, "{name}.png");
        let first = *png.get_pixel(0, 0);
        assert!(png.pixels().any(|pixel| *pixel != first), "{name}.png is empty");
    }
}

fn expected_files() -> BTreeSet<String> {
    let figures = FIGURES.iter().flat_map(|name| [format!("{name}.svg"), format!("{name}.png")]);
    figures
        .chain(
            ["map.csv", "csv-metadata.json", "summary.json", "manifest.json", "report.json", "report.html"]
                .map(String::from),
        )
        .collect()
}

/// Runs `study` at grid 3 with `threads` threads; the folder written and what was printed.
fn run(study: &str, folder: &Path, threads: &str, code: i32) -> (PathBuf, String) {
    let out = folder.join(format!("results_{threads}"));
    let text = printed(code, &["run", study, "--verbose", "--grid", "3", "--out", path(&out), "--threads", threads]);
    (out, text)
}

#[test]
fn the_first_study_writes_complete_results_the_same_for_any_thread_count() {
    let folder = tempfile::tempdir().unwrap();
    let (one, text) = run(STUDY, folder.path(), "1", 0);
    let (two, _) = run(STUDY, folder.path(), "2", 0);
    assert_eq!(file_names(&one), expected_files());
    for name in expected_files().iter().filter(|name| *name != "manifest.json") {
        assert!(
            fs::read(one.join(name)).unwrap() == fs::read(two.join(name)).unwrap(),
            "{name} depends on the threads"
        );
    }

    let (header, rows) = table(&one);
    assert_eq!(rows.len(), 3 * 27);
    check_units(&header);
    rows.iter().for_each(|row| check_row(&header, row));
    check_figures(&one);
    let summary = check_json(&one.join("summary.json"));
    assert_eq!(summary["rows_solved"], 81);
    let manifest = check_json(&one.join("manifest.json"));
    assert_eq!(manifest["statuses"][0]["rows"], 81);

    for expected in ["The cutting force alone moves the tool by ", "correct the drives by up to ", "map.csv"] {
        assert!(text.contains(expected), "{expected} is missing in\n{text}");
    }
    assert!(!text.contains('\r') && !text.contains('\u{1b}') && !text.contains("left"), "progress in a pipe:\n{text}");
}

#[cfg(feature = "parquet")]
#[test]
fn a_run_removes_what_the_one_before_it_left_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results");
    printed(0, &["run", STUDY, "--grid", "2", "--out", path(&out)]);
    fs::write(out.join("notes.txt"), "mine").unwrap();
    printed(0, &["run", STUDY, "--grid", "1", "--out", path(&out), "--no-figures", "--format", "parquet"]);
    assert_eq!(
        file_names(&out),
        ["manifest.json", "map.parquet", "notes.txt", "summary.json"].map(String::from).into()
    );
}

#[test]
fn studies_that_would_share_a_result_folder_are_refused() {
    refused(&["run", STUDY, STUDY, "--grid", "1"], "two studies are called \"01_workspace_map\"");
}

#[test]
fn results_replace_older_ones_and_tables_can_be_had_alone() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/results");
    for grid in ["2", "1"] {
        printed(0, &["run", STUDY, "--grid", grid, "--out", path(&out), "--no-figures"]);
    }
    let expected = ["csv-metadata.json", "manifest.json", "map.csv", "report.html", "report.json", "summary.json"];
    assert_eq!(file_names(&out), expected.map(String::from).into());
    assert_eq!(table(&out).1.len(), 3);
}

/// A study of `machine` over the box from `min` to `max` on each axis, in a folder of its own.
fn write_study(folder: &Path, machine: &str, min: f64, max: f64) -> PathBuf {
    let study = folder.join("study");
    fs::create_dir_all(&study).unwrap();
    let text = format!(
        r#"schema = 3
question = "Where can the machine go?"
machine = "{machine}"
process.force.path_frame = {{ radial_force_N = 215.0, tangential_force_N = -10.0, axial_force_N = -25.0 }}
workspace_map = {{ grid = [2, 2, 2], phi_step_deg = 90.0, min_mm = [{min}, {min}, {min}], max_mm = [{max}, {max}, {max}], slices_z_mm = [{}] }}
"#,
        0.5 * (min + max)
    );
    fs::write(study.join("study.toml"), text).unwrap();
    study
}

/// Statuses and reasons of a run that is only partly solved, its results checked.
fn partly_solved(folder: &Path, study: &Path) -> (Vec<(String, String)>, String) {
    let (out, text) = run(path(study), folder, "2", 1);
    assert_eq!(file_names(&out), expected_files());
    let (header, rows) = table(&out);
    assert_eq!(rows.len(), 3 * 27);
    rows.iter().for_each(|row| check_row(&header, row));
    check_figures(&out);
    check_json(&out.join("summary.json"));
    (rows.into_iter().map(|row| (row[4].clone(), row[5].clone())).collect(), text)
}

#[test]
fn a_box_beyond_the_machine_gives_unreachable_rows_with_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let study = write_study(folder.path(), "orthoglide", -400.0, 400.0);
    let (statuses, text) = partly_solved(folder.path(), &study);
    let unreachable = statuses.iter().filter(|(status, _)| status == "unreachable").collect::<Vec<_>>();
    assert!(unreachable.len() > 40 && unreachable.len() < 81, "{}", unreachable.len());
    assert!(
        unreachable.iter().all(|(_, reason)| reason.contains("cannot close there; continuation from home stops ")),
        "{unreachable:?}"
    );
    // First in the answer on the screen, on the page, and in the summary.
    let first = format!("{n} of 81 not solved: {n} unreachable.", n = unreachable.len());
    assert!(text.find(&first).unwrap() < text.find("How far the tool moves is known").unwrap(), "{text}");
    let read = |name: &str| -> Value {
        serde_json::from_str(&fs::read_to_string(folder.path().join("results_2").join(name)).unwrap()).unwrap()
    };
    assert_eq!(read("report.json")["headline"]["unsolved"], first.as_str());
    let summary = read("summary.json");
    assert_eq!((&summary["rows"], &summary["rows_unsolved"]["unreachable"]), (&81.into(), &unreachable.len().into()));
}

#[test]
fn a_hopeless_map_says_so_while_it_runs() {
    let folder = tempfile::tempdir().unwrap();
    let study = write_study(folder.path(), "orthoglide", 1000.0, 1200.0);
    let out = folder.path().join("out");
    let arguments = ["run", path(&study), "--grid", "4", "--no-figures", "--restart", "--out", path(&out)];
    let said = stderr(&kinetostat(&arguments));
    let (_, counts) = said.split_once(": ").unwrap();
    assert!(counts.contains(" of the first ") && counts.ends_with("points not solved; going on\n"), "{said}");
    let said = stderr(&kinetostat(&[&arguments[..], &["--progress", "json"]].concat()));
    let events: Vec<Value> = said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(events.iter().filter(|event| event["event"] == "warning").count(), 1, "{said}");
    let last = events.iter().rfind(|event| event["event"] == "progress").unwrap();
    assert_eq!((&last["done"], &last["not_solved"]), (&64.into(), &64.into()), "{said}");
    assert!(stderr(&kinetostat(&[&arguments[..], &["--quiet"]].concat())).is_empty());
}

#[test]
fn a_box_where_nothing_is_reached_is_still_reported() {
    let folder = tempfile::tempdir().unwrap();
    let study = write_study(folder.path(), "orthoglide", 600.0, 900.0);
    let (statuses, text) = partly_solved(folder.path(), &study);
    assert!(statuses.iter().all(|(status, _)| status == "unreachable"));
    assert!(text.contains("81 of 81 not solved: 81 unreachable.") && text.contains("at none of"), "{text}");
}

#[test]
fn travel_limits_are_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let study = write_study(folder.path(), "gantry.toml", -50.0, 150.0);
    fs::write(study.join("gantry.toml"), gantry("")).unwrap();
    let (statuses, _) = partly_solved(folder.path(), &study);
    // x of the drive is 100 mm less than x of P: of −50, 50 and 150 mm the travel of ±60 mm covers the last two.
    let (beyond, solved): (Vec<_>, Vec<_>) = statuses.iter().partition(|(status, _)| status == "unreachable");
    assert_eq!((beyond.len(), solved.len()), (27, 54));
    let reason = "drive x of chain arm at -150.000 mm, travel -60.000 to 60.000 mm";
    assert!(beyond.iter().all(|(_, found)| found == reason), "{:?}", beyond[0]);
}

#[test]
fn faults_of_the_program_have_an_exit_code_of_their_own() {
    let code = |ended: fn() -> Result<Ending, Error>| exit_code(ended, |_| ());
    assert_eq!(code(|| Ok(Ending::Complete)), 0);
    assert_eq!(code(|| Ok(Ending::SomeUnsolved)), 1);
    assert_eq!(code(|| Err(Error::argument("--out", "is wrong"))), 2);
    assert_eq!(code(|| Err(Error::Figure { name: "map".into(), problem: "is wrong".into() })), 3);
    assert_eq!(code(|| panic!("a fault for a test")), 3);
}

#[test]
fn rates_have_two_digits() {
    let shown = [0.0, 0.123, 9.87, 12.6, 11_019.0, 1_234_567.0].map(per_second);
    let expected = ["0.0", "0.1", "9.9", "13", "11,000", "1,200,000"].map(|rate| format!("{rate} per second"));
    assert_eq!(shown, expected);
}

/// What is asked for in JSON is JSON, also where the words, the file or the machine are wrong.
#[test]
fn json_is_json_at_every_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let unknown = folder.path().join("unknown.toml");
    let text = catalogue::find("ur10e").unwrap().toml;
    let line = text.lines().find(|line| line.contains("stiffness_Nmm_per_rad = ")).unwrap();
    let (before, after) = line.split_once("stiffness_Nmm_per_rad = ").unwrap();
    let number = after.split([',', ' ', '}']).next().unwrap();
    let open = format!("{before}stiffness_Nmm_per_rad = \"unknown\"{}", &after[number.len()..]);
    fs::write(&unknown, text.replacen(line, &open, 1)).unwrap();
    let home = ["--machine", "orthoglide", "--position", "0,0,0", "--wrench", "1,0,0,0,0,0", "--json"];
    let far = ["--machine", "orthoglide", "--position", "900,0,0", "--wrench", "1,0,0,0,0,0", "--json"];
    for (code, arguments, key) in [
        (0, [&["point"][..], &home].concat(), "wrench_N_Nmm"),
        (1, [&["point"][..], &far].concat(), "error"),
        (2, vec!["point", "--machine", "nothing", "--at", "Q0", "--json"], "error"),
        (2, vec!["point", "--json"], "error"),
        (2, vec!["point", "--machine", "orthoglide", "--at", "nowhere", "--json"], "error"),
        (0, vec!["check", "orthoglide", "--json"], "findings"),
        (2, vec!["check", path(&unknown), "--json"], "error"),
        (2, vec!["check", "nothing", "--json"], "error"),
        (0, vec!["machines", "orthoglide", "--parameters", "--json"], "parameters"),
        (2, vec!["machines", "nothing", "--parameters", "--json"], "error"),
    ] {
        let output = kinetostat(&arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
        let answer: Value = serde_json::from_str(&stdout(&output)).unwrap_or_else(|e| panic!("{arguments:?}: {e}"));
        assert!(!answer[key].is_null() || code == 1, "{arguments:?}: {answer}");
        assert!(code != 0 || answer["error"].is_null(), "{arguments:?}: {answer}");
    }
    // Of a machine that does not yield its geometry is told beside the error.
    let known: Value = serde_json::from_str(&stdout(&kinetostat(&["check", path(&unknown), "--json"]))).unwrap();
    assert!(
        known["findings"]["reached"].as_array().unwrap().len() > 8 && known["findings"]["tool_stiffness"].is_null(),
        "{known}"
    );
}

/// With `--progress json` each line on standard error is a JSON object, also of an error or of wrong words.
#[test]
fn every_line_of_progress_is_json() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for (code, arguments) in [
        (0, vec!["run", STUDY, "--grid", "3", "--no-figures", "--out", path(&out), "--progress", "json"]),
        (2, vec!["run", "/no/study", "--out", path(&out), "--progress", "json"]),
        (2, vec!["run", "--progress=json"]),
        (2, vec!["run", STUDY, "--threads", "none", "--progress", "json"]),
        (2, vec!["compensate", "none.nc", "-m", "orthoglide", "-p", "none.toml", "-o", "x.nc", "--progress", "json"]),
    ] {
        let output = kinetostat(&arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
        let lines: Vec<Value> = stderr(&output)
            .lines()
            .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{arguments:?}: {line}: {e}")))
            .collect();
        assert!(!lines.is_empty() && lines.iter().all(|line| line["event"].is_string()), "{lines:?}");
        assert!(code == 0 || lines.iter().any(|line| line["event"] == "error" && line["message"].is_string()));
    }
}
