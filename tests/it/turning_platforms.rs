//! Machines whose platform turns with its position: a Tricept-like module and arms with free turns. What a program or a path
//! asks for is where its own point of the platform stands, not P.

use std::{fs, path::Path, process::Command};

use crate::support::engine::machine_from;
use kinetostat::machine::Machine;
use nalgebra::Vector3;
use serde_json::Value;

const TRICEPT: &str = include_str!("../machines/tricept.toml");
const KR270: &str = include_str!("../machines/kr270.toml");
const FORCE: &str = "[force.path_frame]\nlaw = \"rotated\"\nradial_force_N = 200.0\ntangential_force_N = -300.0\n\
                     axial_force_N = -100.0\n";
const PROGRAM: &str = "G21 G90 G17\nG0 X-40 Y10 Z0\nG1 X40 Y10 Z0 F600\nG1 X40 Y-60 Z20\nM30\n";

/// The arm with only these coordinates controlled.
fn arm(controls: &str) -> String {
    let all = r#"controls = ["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]"#;
    assert!(KR270.contains(all));
    KR270.replace(all, &format!("controls = {controls}"))
}

/// Machines, and where W stands in them.
fn machines() -> [(&'static str, String, Vector3<f64>); 3] {
    let beside_the_arm = Vector3::new(1690.0, 0.0, 680.0);
    [
        ("tricept", TRICEPT.into(), Vector3::new(0.0, 0.0, -1150.0)),
        ("arm_xyz", arm(r#"["x", "y", "z"]"#), beside_the_arm),
        ("arm_of_five", arm(r#"["x", "y", "z", "rotation_x", "rotation_y"]"#), beside_the_arm),
    ]
}

fn run(folder: &Path, arguments: &[&str]) -> String {
    let held = spare_drives(&fs::read_to_string(folder.join("machine.toml")).unwrap());
    let output =
        Command::new(env!("CARGO_BIN_EXE_kinetostat")).current_dir(folder).args(arguments).args(held).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    text
}

/// The options that hold the last drives, which the task of a machine does not need, at home.
fn spare_drives(machine: &str) -> Vec<String> {
    let machine = machine_from(machine);
    let spare = machine.drives().count().saturating_sub(machine.controls.len());
    let held = machine.drive_labels().into_iter().zip(&machine.home.drives).rev().take(spare);
    held.flat_map(|(label, home)| ["--lock".to_owned(), format!("{label}={:?}", home.to_degrees())]).collect()
}

fn files(machine: &str, origin: &Vector3<f64>, force: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("machine.toml", machine);
    write("part.nc", PROGRAM);
    let [x, y, z]: [f64; 3] = (*origin).into();
    write("process.toml", &format!("schema = 1\n[placement]\norigin_mm = [{x:.1}, {y:.1}, {z:.1}]\n{force}"));
    folder
}

/// Rows of a table, each by the names of its columns.
struct Rows {
    names: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

impl Rows {
    fn read(file: &Path) -> Self {
        let mut reader = csv::Reader::from_path(file).unwrap();
        let names = reader.headers().unwrap().iter().map(String::from).collect();
        Self { names, rows: reader.records().map(|row| row.unwrap()).collect() }
    }

    fn numbers(&self, row: &csv::StringRecord, columns: &[&str]) -> Vec<f64> {
        let place = |column: &&str| self.names.iter().position(|name| name == column).expect(column);
        columns.iter().map(|column| row[place(column)].parse().expect(column)).collect()
    }

    fn drives(&self, machine: &Machine, row: &csv::StringRecord, which: &str) -> Vec<f64> {
        let labels = machine.drive_labels();
        let values =
            labels.iter().zip(machine.drives()).zip(&machine.home.drives).map(|((label, (_, drive)), home)| {
                let revolute = drive.motion == kinetostat::machine::Motion::Revolute;
                let column = format!("{which}_{label}_{}", if revolute { "deg" } else { "mm" });
                // Those that are held have no column.
                if !self.names.contains(&column) {
                    return *home;
                }
                let value = self.numbers(row, &[&column])[0];
                if revolute { value.to_radians() } else { value }
            });
        values.collect()
    }
}

/// The tool tip in O where the nominal machine stands with its drives there: forward kinematics, nothing of how paths are tracked.
fn tip(machine: &Machine, drives: &[f64]) -> Vector3<f64> {
    machine.forward_kinematics(drives).unwrap().pose.transform(machine.tool_tip)
}

#[test]
fn without_load_a_program_is_written_as_it_was() {
    for (name, toml, origin) in machines() {
        let folder = files(&toml, &origin, "");
        let machine = ["--machine", "machine.toml"];
        let arguments = ["compensate", "part.nc", "--process", "process.toml", "--out", "out.nc"];
        run(folder.path(), &[&arguments[..], &machine].concat());
        assert_eq!(fs::read_to_string(folder.path().join("out.nc")).unwrap(), PROGRAM, "{name}");
    }
}

#[test]
fn commands_put_the_tool_where_the_written_program_says() {
    for (name, toml, origin) in machines() {
        let folder = files(&toml, &origin, FORCE);
        let arguments = ["compensate", "part.nc", "--machine", "machine.toml", "--process", "process.toml"];
        run(folder.path(), &[&arguments[..], &["--out", "out.nc"]].concat());
        let report: Value =
            serde_json::from_slice(&fs::read(folder.path().join("out.nc.report.json")).unwrap()).unwrap();
        let errors: Vec<f64> =
            report["passes"].as_array().unwrap().iter().map(|pass| pass["error_max_mm"].as_f64().unwrap()).collect();
        let (before, exact, written) = (errors[0], errors[errors.len() - 2], errors[errors.len() - 1]);
        assert!(before > 0.005 && exact < 1e-7 && written < 5e-3, "{name}: {errors:?}");
        let machine = machine_from(&toml);
        let table = Rows::read(&folder.path().join("out.nc.points.csv"));
        assert!(table.rows.len() > 100);
        for row in table.rows.iter().step_by(7) {
            for (which, columns) in [
                ("rho_nominal", ["x_mm", "y_mm", "z_mm"]),
                ("rho_compensated", ["commanded_x_mm", "commanded_y_mm", "commanded_z_mm"]),
            ] {
                let wanted = Vector3::from_vec(table.numbers(row, &columns)) + origin;
                let stands = tip(&machine, &table.drives(&machine, row, which));
                assert!((stands - wanted).norm() < 1e-6, "{name}, {which}: {stands} {wanted}");
            }
        }
    }
}

#[test]
fn a_path_study_moves_the_tool_as_point_does() {
    let (_, toml, origin) = machines().into_iter().next().unwrap();
    let folder = files(&toml, &origin, FORCE);
    let study = "schema = 3\nquestion = \"q\"\nmachine = \"machine.toml\"\nprocess = \"process.toml\"\n[path]\nfile = \"part.nc\"\n\
                 methods = [\"none\", \"direct\"]\n";
    fs::write(folder.path().join("study.toml"), study).unwrap();
    run(folder.path(), &["run", "study.toml", "--out", "results", "--no-figures"]);
    let table = Rows::read(&folder.path().join("results/points.csv"));
    let machine = machine_from(&toml);
    let both = table.rows.iter().filter(|row| row.iter().any(|cell| cell == "cutting"));
    let mut seen = 0;
    for row in both.skip(1).step_by(40) {
        let wanted = Vector3::from_vec(table.numbers(row, &["wanted_x_mm", "wanted_y_mm", "wanted_z_mm"]));
        assert!((tip(&machine, &table.drives(&machine, row, "rho_nominal")) - wanted).norm() < 1e-6);
        // The force in O, of a motion along −x: radial to its right (seen from the workpiece, the tool pointing down), and so on.
        let displacement = table.numbers(row, &["displacement_mm"])[0];
        assert!((0.003..0.03).contains(&displacement), "{displacement}");
        seen += 1;
    }
    assert!(seen > 2);
}

#[test]
fn mirroring_corrects_the_tip_and_not_the_platform() {
    for (name, toml, origin) in machines() {
        let folder = files(&toml, &origin, FORCE);
        let arguments = ["compensate", "part.nc", "--machine", "machine.toml", "--process", "process.toml"];
        run(folder.path(), &[&arguments[..], &["--out", "out.nc", "--all-methods"]].concat());
        let report: Value =
            serde_json::from_slice(&fs::read(folder.path().join("out.nc.report.json")).unwrap()).unwrap();
        let left = |commands: &str| {
            let pass = report["passes"].as_array().unwrap().iter().find(|pass| pass["commands"] == commands).unwrap();
            pass["error_max_mm"].as_f64().unwrap()
        };
        // The residual is of second order: the deflection changes little over a deflection.
        assert!(left("mirror") < 0.01 * left("none"), "{name}: {} of {}", left("mirror"), left("none"));
        assert!(left("linear") < 0.03 * left("none"), "{name}: {} of {}", left("linear"), left("none"));
        assert!(left("matrix_free") < 1e-6);
    }
}
