//! Numbers have one name and a true unit for every machine: prismatic joints in mm and N, revolute joints in degrees and N·mm.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::Value;
use tempfile::TempDir;

const PROCESS: &str = "schema = 1\n[placement]\nreference = \"platform_point\"\norigin_mm = [0.0, 0.0, 0.0]\n\
    [force.path_frame]\nradial_force_N = 200.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\nlaw = \"rotated\"\n";

/// Three prismatic joints and, before the tool, a revolute joint that the tool tip does not need.
const MIXED: &str = r#"schema = 1
name = "gantry"
title = "Three prismatic joints and a revolute joint"
platform = { tool_tip_mm = [0.0, 0.0, -50.0], controls = ["x", "y", "z"] }
home = { position_mm = [100.0, 0.0, 0.0] }
workspace = { min_mm = [0.0, -100.0, -100.0], max_mm = [200.0, 100.0, 100.0] }
material = { steel = { youngs_modulus_N_per_mm2 = 210000.0, shear_modulus_N_per_mm2 = 81000.0 } }
mount = [{ name = "robot", chain = "arm" }]
[[chain]]
name = "arm"
elements = [
  { prismatic_drive = { name = "x", axis = "x", stiffness_N_per_mm = 1e5 } },
  { prismatic_drive = { name = "y", axis = "y", stiffness_N_per_mm = 1e5 } },
  { prismatic_drive = { name = "z", axis = "z", stiffness_N_per_mm = 1e5 } },
  { beam = { length_mm = 100.0, section = { round = { diameter_mm = 40.0 } }, material = "steel" } },
  { revolute_drive = { name = "c", axis = "z", stiffness_Nmm_per_rad = 1e8 } },
]
"#;

fn kinetostat(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).output().unwrap();
    let [said, complained] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(output.status.code().is_some_and(|code| code < 2), "{said}{complained}");
    said
}

/// A machine of `tests/machines`, or the mixed one, in `folder`.
fn machine(folder: &Path, name: &str) -> PathBuf {
    let file = folder.join("machine.toml");
    let foreign = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/machines").join(format!("{name}.toml"));
    fs::write(&file, if name == "gantry" { MIXED.into() } else { fs::read_to_string(foreign).unwrap() }).unwrap();
    file
}

/// Runs a study of `name` with the table `study`; its result folder.
fn run(name: &str, study: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    machine(folder.path(), name);
    // One offset per drive.
    let offsets = if name == "gantry" { "[0.1, 0.0, 0.0, 0.25]" } else { "[0.1, 0.0, 0.0, 0.25, 0.0, 0.0]" };
    let error = format!(
        "[[chain_error]]\nchain = \"robot\"\nturn_about_drive_axis_deg = 0.5\ndrive_offsets_mm_or_deg = {offsets}\n"
    );
    fs::write(folder.path().join("process.toml"), format!("{PROCESS}{error}")).unwrap();
    let text = format!("schema = 3\nquestion = \"?\"\nmachine = \"machine.toml\"\nprocess = \"process.toml\"\n{study}");
    fs::write(folder.path().join("study.toml"), text).unwrap();
    let out = folder.path().join("out");
    kinetostat(&["run", folder.path().to_str().unwrap(), "--out", out.to_str().unwrap()]);
    folder
}

fn json(folder: &TempDir, name: &str) -> Value {
    serde_json::from_slice(&fs::read(folder.path().join("out").join(name)).unwrap()).unwrap()
}

/// Every view of the page, and every column as described, says the unit that the names of its columns end with.
fn check_page(folder: &TempDir) {
    let ending = |unit: &str| match unit {
        "°" => "_deg",
        "N·mm" => "_Nmm",
        "N/mm" => "_N_per_mm",
        "mm" => "_mm",
        "N" => "_N",
        "" => "",
        other => panic!("unit {other}"),
    };
    let mut seen = 0;
    for explorer in json(folder, "report.json")["explorers"].as_array().unwrap() {
        for quantity in explorer["quantities"].as_array().unwrap() {
            for column in quantity["columns"].as_array().unwrap() {
                let unit = quantity["unit"].as_str().unwrap();
                assert!(column.as_str().unwrap().ends_with(ending(unit)), "{quantity}");
                seen += 1;
            }
        }
    }
    assert!(seen > 10);
    for table in json(folder, "csv-metadata.json")["tables"].as_array().unwrap() {
        for column in table["tableSchema"]["columns"].as_array().unwrap() {
            let (name, unit) = (column["titles"].as_str().unwrap(), column["schema:unitText"].as_str());
            let drive = ["delta_rho_", "rho_nominal_", "rho_compensated_", "drive_force_", "drive_torque_"];
            if drive.iter().any(|begin| name.starts_with(begin)) {
                assert!(unit.is_some_and(|unit| ["mm", "deg", "N", "N·mm"].contains(&unit)), "{column}");
            }
        }
    }
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

const LINE: &str = "[path]\nmethods = [\"none\"]\n";
const SLIDES: [&str; 2] = ["delta_rho_max_mm", "drive_force_max_N"];
const HINGES: [&str; 2] = ["delta_rho_max_deg", "drive_torque_max_Nmm"];

#[test]
fn a_path_of_an_arm_is_in_degrees_and_newton_millimetres() {
    let folder =
        run("kr270", &format!("{LINE}line = {{ start_mm = [1600.0, 0.0, 1000.0], end_mm = [1605.0, 0.0, 1000.0] }}\n"));
    let summary = json(&folder, "summary.json");
    let both = &summary["sources"]["all"];
    assert_eq!(summary["schema"], 2);
    assert!(HINGES.iter().all(|key| both[key]["value"].as_f64().is_some_and(|value| value > 0.0)), "{both}");
    assert!(SLIDES.iter().all(|key| !keys(both).contains(key)), "{both}");
    check_page(&folder);
    let out = folder.path().join("out");
    let header = |name: &str| fs::read_to_string(out.join(name)).unwrap().lines().next().unwrap().to_string();
    assert!(header("delta_rho_data.csv").contains("Δρ [°]"), "{}", header("delta_rho_data.csv"));
    assert!(header("drive_torque_data.csv").contains("τ [N·mm]"), "{}", header("drive_torque_data.csv"));
    assert!(!out.join("drive_force.svg").exists());

    let mut table = csv::Reader::from_path(out.join("points.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    for row in table.records().map(Result::unwrap) {
        let number = |name: &str| {
            let column = header.iter().position(|column| column == name);
            row[column.unwrap_or_else(|| panic!("{name} in {header:?}"))].parse::<f64>().unwrap()
        };
        for axis in 1..=6 {
            let [nominal, after, change] = ["rho_nominal", "rho_compensated", "delta_rho"]
                .map(|what| number(&format!("{what}_robot_A{axis}_deg")));
            assert!((after - nominal - change).abs() < 1e-9, "{row:?}");
            assert!(number(&format!("drive_torque_robot_A{axis}_Nmm")).is_finite());
        }
        assert!((18.0..20.0).contains(&number("rho_nominal_robot_A2_deg")), "{row:?}");
        for what in ["nominal", "commanded"] {
            // The tool hangs down: half a turn about y.
            let turn = ["x", "y", "z"].map(|axis| number(&format!("{what}_platform_rotation_{axis}_deg")));
            assert!((turn.iter().map(|part| part * part).sum::<f64>().sqrt() - 180.0).abs() < 0.5, "{turn:?}");
        }
        let [nominal, commanded] = ["nominal", "commanded"].map(|what| number(&format!("{what}_platform_x_mm")));
        assert!(commanded != nominal && (commanded - nominal).abs() < 10.0, "{row:?}");
    }
}

#[test]
fn slides_and_hinges_of_one_machine_are_told_apart() {
    let line = "line = { start_mm = [100.0, 0.0, 0.0], end_mm = [105.0, 0.0, 0.0] }\n";
    let folder = run("gantry", &format!("{LINE}{line}"));
    let summary = json(&folder, "summary.json");
    let both = &summary["sources"]["all"];
    assert!(SLIDES.iter().chain(&HINGES).all(|key| both[key]["value"].is_f64()), "{both}");
    check_page(&folder);
    let setting = json(&folder, "report.json")["setting"].to_string();
    assert!(setting.contains("drive zeros off by 0.1 mm, 0 mm, 0 mm, 0.25°"), "{setting}");
    let out = folder.path().join("out");
    for stem in ["delta_rho_prismatic", "delta_rho_revolute", "drive_force", "drive_torque"] {
        assert!(out.join(format!("{stem}.svg")).is_file(), "{stem}");
    }

    let folder = run("gantry", "[workspace_map]\ngrid = [2, 2, 2]\nphi_step_deg = 90.0\nslices_z_mm = [0.0]\n");
    let summary = json(&folder, "summary.json");
    let both = keys(&summary["sources"]["all"]);
    for key in ["delta_rho_largest_drive_mm", "delta_rho_largest_drive_deg", "drive_force_largest_drive_N"] {
        assert!(both.contains(&key), "{both:?}");
    }
    check_page(&folder);
    let labels: Vec<String> = json(&folder, "report.json")["explorers"][0]["quantities"]
        .as_array()
        .unwrap()
        .iter()
        .map(|quantity| format!("{} [{}]", quantity["label"].as_str().unwrap(), quantity["unit"].as_str().unwrap()))
        .collect();
    for label in [
        "largest correction of prismatic joints |Δρ| [mm]",
        "largest torque of revolute joints |τ| [N·mm]",
        "torque of drive robot_c [N·mm]",
    ] {
        assert!(labels.iter().any(|own| own == label), "{label} in {labels:?}");
    }
}

#[test]
fn a_point_of_a_machine_with_slides_and_hinges_has_a_list_of_each() {
    let folder = tempfile::tempdir().unwrap();
    let file = machine(folder.path(), "gantry");
    let arguments = ["point", "--machine", file.to_str().unwrap(), "--position", "100,0,0", "--wrench", "90,0,0,0,0,0"];
    let found: Value = serde_json::from_str(&kinetostat(&[&arguments[..], &["--json"]].concat())).unwrap();
    let kinds: Vec<&str> =
        found["drives"].as_array().unwrap().iter().map(|drive| drive["motion"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["prismatic", "prismatic", "prismatic", "revolute"]);
    for [slides, revolute] in [
        ["rho_nominal_mm", "rho_nominal_deg"],
        ["delta_rho_mm", "delta_rho_deg"],
        ["actuator_force_N", "actuator_torque_Nmm"],
        ["compensated_actuator_force_N", "compensated_actuator_torque_Nmm"],
    ] {
        let is_null = |key: &str| -> Vec<bool> {
            found[key].as_array().unwrap_or_else(|| panic!("{key}")).iter().map(Value::is_null).collect()
        };
        assert_eq!(is_null(slides), [false, false, false, true], "{slides}");
        assert_eq!(is_null(revolute), [true, true, true, false], "{revolute}");
    }
    let text = kinetostat(&arguments);
    assert!(text.contains("force or torque before"), "{text}");
}

#[test]
fn placements_judge_slides_and_hinges_apart() {
    let folder = tempfile::tempdir().unwrap();
    let file = machine(folder.path(), "gantry");
    fs::write(folder.path().join("process.toml"), PROCESS).unwrap();
    fs::write(folder.path().join("path.csv"), "x_mm,y_mm,z_mm\n0,0,0\n5,0,0\n5,5,0\n").unwrap();
    let [process, path] = ["process.toml", "path.csv"].map(|name| folder.path().join(name));
    let arguments = ["--process", process.to_str().unwrap(), "--path", path.to_str().unwrap(), "--at", "100,0,0"];
    let csv = kinetostat(&[&["compare", "--machine", file.to_str().unwrap(), "--csv"], &arguments[..]].concat());
    let header: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    for column in
        ["worst_correction_mm", "worst_drive_force_N", "worst_rotary_correction_deg", "worst_rotary_torque_Nmm"]
    {
        let index = header.iter().position(|name| *name == column);
        let index = index.unwrap_or_else(|| panic!("{column} in {header:?}"));
        assert!(csv.lines().nth(1).unwrap().split(',').nth(index).unwrap().parse::<f64>().is_ok(), "{csv}");
    }
    let own = kinetostat(&[&["compare", "--machine", "orthoglide", "--csv"], &arguments[..]].concat());
    assert!(!own.contains("worst_rotary"), "{own}");
}
