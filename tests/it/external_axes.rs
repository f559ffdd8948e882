//! Drives that a path commands beside the tool: a rail before an arm, a turntable under the part.

use crate::support::command::told;
use crate::support::engine::*;
use kinetostat::{
    compensation::{Method, Session, Target, TaskPoint, compensate},
    machine::Machine,
    simulation::settings,
    spatial::Wrench,
};
use nalgebra::Vector3;

const CELL: &str = include_str!("../machines/kr270_cell.toml");

const STUDY: &str = "schema = 3\nquestion = \"How far?\"\nmachine = \"cell.toml\"\n\
    [process.force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n";

/// A folder with the cell, a study and a path.
fn folder(study: &str, path: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("study.toml", study), ("cell.toml", CELL), ("path.csv", path)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn run(study: &str, path: &str) -> (Option<i32>, String, tempfile::TempDir) {
    let folder = folder(&format!("{STUDY}{study}"), path);
    let out = folder.path().join("out");
    let (code, text, said) =
        told(&["run", folder.path().to_str().unwrap(), "--out", out.to_str().unwrap(), "--no-figures"]);
    (code, text + &said, folder)
}

/// Rows of `points.csv` of the direct method and all sources, each by column.
fn points(folder: &tempfile::TempDir) -> Vec<std::collections::HashMap<String, String>> {
    let mut reader = csv::Reader::from_path(folder.path().join("out/points.csv")).unwrap();
    let rows: Vec<std::collections::HashMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    let of_all: Vec<_> = rows.iter().filter(|row| row["source"] == "all").cloned().collect();
    if of_all.is_empty() { rows } else { of_all }
}

fn number(row: &std::collections::HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} = {}", row[column]))
}

const PATH: &str = "[path]\nfile = \"path.csv\"\nmethods = [\"none\", \"direct\"]\n";

#[test]
fn a_machine_moved_by_its_path_answers_as_one_that_was_set_up_there() {
    let machine = machine_from(CELL);
    let held = |machine: &Machine, rail: f64, table: f64| {
        machine.with_locked_drives(&[("rail", rail), ("table", table)]).unwrap()
    };
    let along = held(&machine, 0.0, 0.0);
    let mut session = Session::new(&along, &along, settings());
    for (rail, table) in [(0.0, 0.0), (30.0, 5.0), (400.0, 90.0), (-500.0, -120.0), (0.0, 0.0)] {
        let there = held(&machine, rail, table);
        let pose = there.pose_at(Vector3::new(1650.0, 40.0, 780.0));
        let load = Wrench { force: Vector3::new(300.0, -500.0, 200.0), moment: Vector3::zeros() };
        let task = TaskPoint::new(pose, load, Target::ToolTip);
        let external = Some(there.external_axes());
        for method in [Method::None, Method::Newton, Method::Direct] {
            let mut fixed = Session::new(&there, &there, settings());
            let expected = compensate(&mut fixed, &task, method);
            assert!(expected.status.is_success(), "{:?}", expected.status);
            let found = compensate(&mut session, &TaskPoint { external, ..task }, method);
            assert_eq!(found.status, expected.status);
            let apart = (found.tool_displacement - expected.tool_displacement).norm();
            assert!(apart < 1e-9, "{rail} {table} {method:?}: {apart}");
            for (a, b) in found.drives.iter().zip(&expected.drives) {
                assert!((a - b).abs() < 1e-7, "{rail} {table} {method:?}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_part_that_turns_under_the_tool_is_cut_where_it_has_turned_to() {
    // A circle about the table's axis: the table turns and the tool stays.
    let mut path = String::from("x_mm,y_mm,z_mm,external_table_deg,external_rail_mm\n");
    for k in 0..=12 {
        let angle = f64::from(k) * 2.5;
        let (sin, cos) = angle.to_radians().sin_cos();
        path += &format!("{},{},60,{angle},{}\n", 80.0 * cos, -80.0 * sin, 10.0 * f64::from(k));
    }
    let (code, said, folder) = run(PATH, &path);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
            .contains("Locked or external axes: robot_rail moved within 0 to 120 mm by the path, table moved within 0 to 30° by the path."),
        "{said}"
    );
    let rows = points(&folder);
    assert!(rows.len() > 13, "{}", rows.len());
    for row in &rows {
        // Between rows, the table turns evenly and the path is straight: a chord.
        let off = (number(row, "wanted_x_mm") - 1680.0).hypot(number(row, "wanted_y_mm"));
        assert!(off < 0.03, "{row:?}");
        assert!((number(row, "wanted_z_mm") - 680.0).abs() < 1e-9);
        assert_eq!(row["status"], "converged");
        let (rail, table) = (number(row, "rho_nominal_robot_rail_mm"), number(row, "rho_carrier_table_deg"));
        assert!((rail - table * 4.0).abs() < 1e-9 && (0.0..=30.0).contains(&table), "{rail} {table}");
        assert!((number(row, "rho_compensated_robot_rail_mm") - rail).abs() < 1e-12, "the rail is not corrected");
        assert!(number(row, "residual_error_mm") < 1e-6);
    }
    assert!((number(&rows[rows.len() - 1], "rho_carrier_table_deg") - 30.0).abs() < 1e-12);
}

#[test]
fn a_program_keeps_its_axes_and_leaves_nothing() {
    let path = "x_mm,y_mm,z_mm,external_rail_mm,external_table_deg\n0,0,60,0,0\n40,0,60,200, 10\n40,30,60,200,30\n";
    let folder = folder(STUDY, path);
    let file = |name: &str| folder.path().join(name).display().to_string();
    let compensated = |force: f64, out: &str| {
        let process = format!(
            "schema = 1\n[force.path_frame]\nradial_force_N = {force}\ntangential_force_N = -10.0\naxial_force_N = -25.0\n"
        );
        let none =
            "schema = 1\n[force.path_frame]\nradial_force_N = 0.0\ntangential_force_N = 0.0\naxial_force_N = 0.0\n"
                .to_string();
        std::fs::write(file("process.toml"), if force == 0.0 { none } else { process }).unwrap();
        let (program, cell, process, out) = (file("path.csv"), file("cell.toml"), file("process.toml"), file(out));
        let (code, text, said) =
            told(&["compensate", &program, "--machine", &cell, "--process", &process, "--out", &out]);
        assert_eq!(code, Some(0), "{text}{said}");
        (text, std::fs::read_to_string(&out).unwrap())
    };
    assert_eq!(compensated(0.0, "same.csv").1, path);
    let (said, program) = compensated(400.0, "out.csv");
    assert!(said.contains("robot_rail moved within 0 to 200 mm by the path"), "{said}");
    let mut lines = program.lines();
    assert_eq!(lines.next(), path.lines().next());
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|value| value.trim().parse().unwrap()).collect()).collect();
    assert_eq!(rows.last().unwrap()[3..], [200.0, 30.0]);
    // Rows that were added lie where the axes are on the way there.
    for row in rows.iter().filter(|row| row[3] < 200.0) {
        assert!((row[0] - row[3] / 5.0).abs() < 0.5 && (row[4] - row[3] / 20.0).abs() < 1e-9, "{row:?}");
    }
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(file("out.csv.report.json")).unwrap()).unwrap();
    let text = report.to_string();
    assert!(text.contains("max_mm"), "{text}");
}

#[test]
fn axes_that_cannot_be_commanded_are_refused_by_name() {
    let refused = |columns: &str, values: [&str; 2], table: &str| {
        let path = format!("x_mm,y_mm,z_mm,{columns}\n0,0,60,{}\n10,0,60,{}\n", values[0], values[1]);
        let (code, said, folder) = run(&format!("{table}{PATH}"), &path);
        assert_eq!(code, Some(2), "{said}");
        assert!(!folder.path().join("out").exists());
        let place = folder.path().join("path.csv").display().to_string();
        said.replace(&place, "path.csv").trim().to_string()
    };
    assert_eq!(
        refused("external_tabel_deg", ["0", "10"], ""),
        "error: path.csv: external_tabel_deg names tabel: no drive is called so; there are: robot_rail, robot_A1, robot_A2, robot_A3, \
         robot_A4, robot_A5, robot_A6, table"
    );
    assert_eq!(
        refused("external_table_mm", ["0", "10"], ""),
        "error: path.csv: external_table_mm is a position in deg: expected external_table_deg"
    );
    assert_eq!(
        refused("external_table_deg", ["0", "400"], ""),
        "error: path.csv: external_table_deg is 400 at move 2: expected its travel of -360 to 360 deg"
    );
    assert_eq!(
        refused("external_table_deg", ["0", "40"], "[locked]\ntable = 3.0\n"),
        "error: path.csv: external_table_deg is locked by [locked] or --lock, and the path commands it as well: expected one of the two"
    );
    let needed = refused("external_rail_mm,external_A2_deg", ["0,20", "0,21"], "");
    assert!(needed.contains("path.csv: external axes") && needed.contains("1 more than its task needs"), "{needed}");
    let many = "external_a_mm,external_b_mm,external_c_mm,external_d_mm,external_e_mm,external_f_mm,external_g_mm";
    assert_eq!(
        refused(many, ["0,0,0,0,0,0,0", "0,0,0,0,0,0,0"], ""),
        "error: path.csv:1: 7 external axes; expected at most 6"
    );
    assert_eq!(
        refused("external_table_deg", ["0", "far"], ""),
        "error: path.csv:3: external_table_deg = `far`; expected a position of a drive in mm or degrees, up to 1e6"
    );
}

#[test]
fn a_placement_refuses_a_path_that_moves_the_table() {
    let placement = "[[placement.feature]]\nname = \"edge\"\nfile = \"path.csv\"\ntolerance_mm = 0.5\n\
         [placement.bounds]\nx_mm = [-50.0, 50.0]\ny_mm = [-50.0, 50.0]\n[placement.fixed]\nz_mm = 0.0\n\
         [placement.objective]\nweights = { worst_deflection = 1.0 }\n\
         [placement.search]\ngrid = { x = 2, y = 2 }\nstarts = 1\nmax_iterations = 5\n";
    let (code, said, _folder) = run(placement, "x_mm,y_mm,z_mm,external_table_deg\n0,0,60,0\n10,0,60,5\n");
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("path.csv: commands external_table_deg: a place is sought for one position of such a drive, expected [locked] instead"),
        "{said}"
    );
}
