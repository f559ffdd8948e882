//! Paths that say how the tool stands: the tool's axis, or the orientation of the whole platform.

use std::fs;

use kinetostat::{
    compensation::TaskPoint,
    machine::Machine,
    process::file::Process,
    simulation::tasks::tasks,
    spatial::rotation_exp,
    toolpath::{Orientation, PathPoint, Sampling, Toolpath, polyline::Polyline},
};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use crate::support::command::told;

const FORCE: &str = "[force.path_frame]\nlaw = \"rotated\"\nradial_force_N = 300.0\ntangential_force_N = -200.0\naxial_force_N = -100.0\n";
const ROWS: &str = "x_mm,y_mm,z_mm\n0,0,0\n20,5,0\n20,30,-4\n";

fn process(machine: &Machine, origin: [f64; 3], roll_pitch: [f64; 2]) -> Process {
    let [roll, pitch] = roll_pitch;
    let text = format!(
        "schema = 1\n[placement]\norigin_mm = {origin:?}\nroll_deg = {roll:?}\npitch_deg = {pitch:?}\n[sampling]\nmax_segment_mm = 5.0\n\
         {FORCE}"
    );
    Process::from_toml(&text, "process.toml", std::path::Path::new("."), machine).unwrap()
}

fn wanted(process: &Process, rows: &str) -> Vec<TaskPoint> {
    let path = Polyline::read(rows, "path.csv").unwrap().sampled(process.sampling).unwrap().into();
    tasks(process, &path, "path.csv").unwrap()
}

/// The rows turned by `turn`, with how the tool stands in these columns.
fn turned(turn: &Rotation3<f64>, columns: &str, orientation: &[f64]) -> String {
    let numbers = orientation.iter().map(|n| format!("{n:.17}")).collect::<Vec<_>>().join(",");
    let row = |row: &str| {
        let [x, y, z]: [f64; 3] = row.split(',').map(|n| n.parse().unwrap()).collect::<Vec<_>>().try_into().unwrap();
        let p = turn * Vector3::new(x, y, z);
        format!("{:.15},{:.15},{:.15},{numbers}\n", p.x, p.y, p.z)
    };
    format!("x_mm,y_mm,z_mm,{columns}\n") + &ROWS.lines().skip(1).map(row).collect::<String>()
}

#[test]
fn a_path_that_turns_its_tool_is_one_on_a_workpiece_that_is_tilted_so() {
    for (name, origin) in [("kr270", [1700.0, 50.0, 600.0]), ("hexapod", [5.0, -10.0, 900.0])] {
        let machine = Machine::named(name).unwrap();
        let home = &machine.home.pose.rotation;
        for roll_pitch in [[12.0, 0.0], [0.0, -9.0], [8.0, 5.0]] {
            let tilted = process(&machine, origin, roll_pitch);
            let level = process(&machine, origin, [0.0, 0.0]);
            let tilt = Rotation3::from_matrix_unchecked(tilted.placement.pose().rotation);
            let expected = wanted(&tilted, ROWS);
            let platform = UnitQuaternion::from_matrix(&tilted.placement.platform_orientation(home));
            let columns = "platform_qw,platform_qx,platform_qy,platform_qz";
            let whole = turned(&tilt, columns, &[platform.w, platform.i, platform.j, platform.k]);
            let axis = tilt * -(home * machine.tool_axes.column(2));
            let by_axis = turned(&tilt, "axis_x,axis_y,axis_z", (axis * 3.0).as_slice());
            for (rows, has_turn) in [(whole, true), (by_axis, roll_pitch.contains(&0.0))] {
                let found = wanted(&level, &rows);
                assert_eq!(found.len(), expected.len());
                for (found, expected) in found.iter().zip(&expected) {
                    let tip = |task: &TaskPoint| task.pose.transform(machine.tool_tip);
                    assert!((tip(found) - tip(expected)).norm() < 1e-9, "{name}");
                    assert!((found.load.force - expected.load.force).norm() < 1e-9);
                    let axis = |task: &TaskPoint| task.pose.rotation * machine.tool_axes.column(2);
                    assert!((axis(found) - axis(expected)).norm() < 1e-12);
                    // Of an axis, the turn about it is the least one from home.
                    if has_turn {
                        assert!((found.pose.rotation - expected.pose.rotation).norm() < 1e-12);
                        assert!((found.load.moment - expected.load.moment).norm() < 1e-8);
                    }
                }
            }
        }
    }
}

#[test]
fn moves_along_which_the_tool_turns_are_split_by_their_turn() {
    let rows = "x_mm,y_mm,z_mm,axis_x,axis_y,axis_z\n0,0,0,0,0,1\n1,0,0,0,1,1\n1,0,0,0,0,2\n";
    let polyline = Polyline::read(rows, "path.csv").unwrap();
    let sampling = Sampling::default().with_max_turn(5f64.to_radians()).unwrap();
    let path = polyline.sampled(sampling).unwrap();
    assert_eq!(path.len(), 1 + 9 + 9);
    let axes: Vec<Orientation> = path.points().iter().filter_map(|point| point.orientation).collect();
    assert!(axes.windows(2).all(|pair| (pair[0].angle_to(&pair[1]).to_degrees() - 5.0).abs() < 1e-9));
    assert!(Polyline::read(rows, "path.csv").unwrap().sampled(Sampling::default()).unwrap().len() == 1 + 23 + 23);
}

#[test]
fn an_orientation_that_is_none_is_refused_with_its_line() {
    let message = |rows: &str| Polyline::read(rows, "path.csv").unwrap_err().to_string();
    assert_eq!(
        message("x_mm,y_mm,z_mm,axis_x,axis_y,axis_z\n0,0,0,0,0,1\n0,0,0,0,0,0\n"),
        "path.csv:3: axis_x, axis_y, axis_z are all 0; expected a direction"
    );
    assert_eq!(
        message("x_mm,y_mm,z_mm,platform_qw,platform_qx,platform_qy,platform_qz\n0,0,0,0.5,0.5,0.5,0.6\n"),
        "path.csv:2: platform_qw, platform_qx, platform_qy, platform_qz have length 1.0535653752852738; expected 1"
    );
    assert_eq!(
        message("x_mm,y_mm,z_mm,axis_x,axis_y\n0,0,0,0,0\n"),
        "path.csv:1: no column `axis_z`; expected it with its companions"
    );
}

#[test]
fn a_machine_that_cannot_turn_its_tool_so_refuses_the_path() {
    let refused = |machine: &str, columns: &str, values: &str| {
        let machine = Machine::named(machine).unwrap();
        let process = process(&machine, [0.0; 3], [0.0, 0.0]);
        let path = Polyline::read(format!("x_mm,y_mm,z_mm,{columns}\n0,0,0,{values}\n"), "path.csv").unwrap();
        process.mark_cutting(path.toolpath().clone(), "path.csv").map_err(|error| error.to_string())
    };
    let home = Machine::named("orthoglide").unwrap();
    let axis = -(home.home.pose.rotation * home.tool_axes.column(2));
    let own = format!("{},{},{}", axis.x, axis.y, axis.z);
    assert!(refused("orthoglide", "axis_x,axis_y,axis_z", &own).is_ok());
    assert_eq!(
        refused("orthoglide", "axis_x,axis_y,axis_z", &format!("{},{},{}", axis.x, axis.y + 0.1, axis.z)).unwrap_err(),
        "path.csv: move 1 turns the tool by 5.711 degrees from where it stands at home, and machine orthoglide controls no rotation: \
         expected a path whose tool keeps its direction"
    );
    // A machine with five drives leads the axis; the turn about it is not its to choose.
    let columns = "platform_qw,platform_qx,platform_qy,platform_qz";
    let hybrid = Machine::named("hybrid_3ups").unwrap();
    let axis = rotation_exp(Vector3::new(0.1, 0.05, 0.0)) * -(hybrid.home.pose.rotation * hybrid.tool_axes.column(2));
    assert!(refused("hybrid_3ups", "axis_x,axis_y,axis_z", &format!("{},{},{}", axis.x, axis.y, axis.z)).is_ok());
    let turned = UnitQuaternion::from_euler_angles(0.0, 0.0, 0.2);
    let about_axis = refused("hybrid_3ups", columns, &format!("{},{},{},{}", turned.w, turned.i, turned.j, turned.k));
    assert_eq!(
        about_axis.unwrap_err(),
        "path.csv: move 1 turns the platform by 11.459 degrees from where it stands at home in a way that machine hybrid_3ups does not \
         control: its drives control rotation_x, rotation_y"
    );
}

#[test]
fn a_path_with_a_turning_tool_is_compensated_and_written_with_its_orientations() {
    for (machine, origin) in
        [("kr270", [1700.0, 0.0, 560.0]), ("hexapod", [0.0, 0.0, 900.0]), ("hybrid_3ups", [0.0; 3])]
    {
        let built_in = Machine::named(machine).unwrap();
        let home = built_in.home.pose;
        let origin = if machine == "hybrid_3ups" { home.transform(built_in.tool_tip).into() } else { origin };
        let axis = |turn: Vector3<f64>| rotation_exp(turn) * -(home.rotation * built_in.tool_axes.column(2));
        let mut rows = String::from("x_mm,y_mm,z_mm,axis_x,axis_y,axis_z\r\n");
        for (k, turn) in [[0.0, 0.0, 0.0], [0.05, 0.02, 0.0], [0.1, -0.05, 0.0]].into_iter().enumerate() {
            let a = axis(turn.into());
            rows += &format!("{}, 2.50,0,{:.6},{:.6},{:.6}\r\n", 10 * k, a.x, a.y, a.z);
        }
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name).display().to_string();
        fs::write(place("path.csv"), &rows).unwrap();
        let table = format!("schema = 1\n[placement]\norigin_mm = {:?}\n", origin);
        fs::write(place("free.toml"), &table).unwrap();
        fs::write(place("cut.toml"), table + FORCE).unwrap();
        let compensate = |process: &str, out: &str| {
            let arguments = ["compensate", &place("path.csv"), "--machine", machine, "--process", &place(process)];
            told(&[&arguments[..], &["--out", &place(out), "--quiet"]].concat())
        };
        let (code, text, said) = compensate("free.toml", "same.csv");
        assert_eq!(code, Some(0), "{machine}: {text}{said}");
        assert_eq!(fs::read_to_string(place("same.csv")).unwrap(), rows, "{machine}");
        let (code, text, said) = compensate("cut.toml", "out.csv");
        assert_eq!(code, Some(0), "{machine}: {text}{said}");
        let written = Polyline::read(fs::read(place("out.csv")).unwrap(), "out.csv").unwrap();
        let last = |path: &Toolpath| -> PathPoint { *path.points().last().unwrap() };
        let (own, new) = (last(Polyline::read(rows.clone(), "path.csv").unwrap().toolpath()), last(written.toolpath()));
        assert_eq!(own.orientation, new.orientation);
        assert!((own.position_mm - new.position_mm).norm() > 1e-3, "{machine}");
        let report = fs::read_to_string(place("out.csv.report.json")).unwrap();
        let report: serde_json::Value = serde_json::from_str(&report).unwrap();
        let left = |pass: usize| report["passes"][pass]["error_max_mm"].as_f64().unwrap();
        let last = report["passes"].as_array().unwrap().len() - 1;
        assert!(left(0) > 1e-3 && left(last) < 2e-3, "{machine}: {} {}", left(0), left(last));
    }
}
