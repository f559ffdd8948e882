//! Placements of tilted workpieces, of several features, and by the error left within limits.

use std::path::Path;

use crate::support::{
    arm::ARM,
    placement::{searched, study_in},
};
use kinetostat::{
    compensation::{CompensationSettings, Method, Session, Target, TaskPoint, compensate},
    files::exchange::csv,
    questions::placement::{
        Evaluator, Metric, PlacementStudy, Site,
        report::{candidates_table, figures},
    },
    spatial::{Pose, Wrench},
};
use nalgebra::Vector3;

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

/// Three points on an arm that can tilt its tool, each under its own force in W.
const TILTED: &str = r#"
schema = 3
question = "how tilted?"
machine = "arm.toml"
[[placement.feature]]
name = "slot"
process = "process.toml"
file = "slot.csv"
tolerance_mm = 0.05
[placement.bounds]
roll_deg = [-20.0, 20.0]
pitch_deg = [-10.0, 10.0]
[placement.fixed]
x_mm = 640.0
y_mm = 0.0
z_mm = 400.0
yaw_deg = 30.0
[placement.allowance]
position_mm = 0.0
angle_deg = 0.0
[placement.objective]
weights = { worst_deflection = 1.0 }
[placement.search]
grid = { roll = 5, pitch = 3 }
starts = 2
"#;

const SLOT: [[f64; 6]; 3] =
    [[-20.0, 0.0, 0.0, 80.0, 40.0, 0.0], [0.0, 5.0, -2.0, 90.0, -30.0, 20.0], [20.0, 0.0, 0.0, 60.0, 0.0, -50.0]];

fn tilted_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    // Room for P wherever the tilted tool asks for it.
    let roomy = ARM.replace("min_mm = [500.0, -200.0, 300.0]", "min_mm = [300.0, -400.0, 200.0]");
    write(
        folder.path(),
        "arm.toml",
        &roomy.replace("max_mm = [800.0, 200.0, 500.0]", "max_mm = [1000.0, 400.0, 700.0]"),
    );
    write(folder.path(), "process.toml", "schema = 1\n[force]\nfrom_path = true\n");
    let rows = SLOT.map(|row| row.map(|value| value.to_string()).join(","));
    let header = "x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N";
    write(folder.path(), "slot.csv", &format!("{header}\n{}\n", rows.join("\n")));
    folder
}

#[test]
fn the_tool_of_a_tilted_workpiece_and_its_force_tilt_with_it() {
    let folder = tilted_folder();
    let study = study_in(folder.path(), TILTED).unwrap();
    let machine = &study.machine;
    let (yaw, pitch, roll) = (0.5, -0.1, 0.3);
    let found = Evaluator::new(&study, &[Metric::WorstDeflection])
        .evaluate(&Site([640.0, 0.0, 400.0, yaw, pitch, roll]))
        .unwrap()
        .metrics
        .get(Metric::WorstDeflection)
        .unwrap();
    // The same by hand: the arm is tracked to each point with its tool along z of W.
    let workpiece = Pose {
        translation: Vector3::new(640.0, 0.0, 400.0),
        ..Pose::from_roll_pitch_yaw(Vector3::new(roll, pitch, yaw))
    };
    let unturned = Pose::from_roll_pitch_yaw(Vector3::new(0.0, 0.0, -yaw)).rotation;
    let rotation = workpiece.rotation * unturned * machine.home.pose.rotation;
    let lever = rotation * machine.tool_tip;
    let mut session = Session::new(machine, machine, CompensationSettings::default());
    let errors = SLOT.map(|[x, y, z, fx, fy, fz]| {
        let tip = workpiece.transform(Vector3::new(x, y, z));
        let force = workpiece.rotation * Vector3::new(fx, fy, fz);
        let load = Wrench { force, moment: lever.cross(&force) };
        let task = TaskPoint {
            pose: Pose { rotation, translation: tip - lever },
            load,
            target: Target::ToolTip,
            wanted: None,
            aside: nalgebra::Vector3::zeros(),
            external: None,
            led: None,
            asked: None,
        };
        compensate(&mut session, &task, Method::None).position_error.norm()
    });
    let worst = errors.into_iter().fold(0.0, f64::max);
    assert!(worst > 1e-3 && (found - worst).abs() < 1e-9, "{found} {worst}");
}

#[test]
fn roll_and_pitch_are_sought_where_the_machine_can_follow() {
    let folder = tilted_folder();
    let study = study_in(folder.path(), TILTED).unwrap();
    let results = searched(&study);
    let best = results.best.as_ref().unwrap();
    let cells = results.cells.iter().filter_map(|cell| Some(study.objective.value(cell.complete()?)));
    let least = cells.fold(f64::MAX, f64::min);
    // The sweep visits the points of a path in another order: solved to the same tolerance, not to the same bit.
    assert!(best.value <= least * (1.0 + 1e-9), "{} {least}", best.value);
    let brute: Vec<f64> = (0..21 * 21)
        .filter_map(|k| {
            let angle = |index: usize, most: f64| (most * (index as f64 / 10.0 - 1.0)).to_radians();
            let site = Site([640.0, 0.0, 400.0, 30f64.to_radians(), angle(k / 21, 10.0), angle(k % 21, 20.0)]);
            let evaluation = Evaluator::new(&study, &[Metric::WorstDeflection]).evaluate(&site).ok()?;
            evaluation.metrics.get(Metric::WorstDeflection)
        })
        .collect();
    assert_eq!(brute.len(), 21 * 21);
    let least = brute.into_iter().fold(f64::MAX, f64::min);
    assert!(best.value <= least * (1.0 + 1e-4), "{best:?} {least}");
    assert_eq!(Metric::WorstCorrection.value_text(&study.machine, 0.0662), "0.0662°");
    assert_eq!(Metric::WorstDriveForce.value_text(&study.machine, 64278.7), "64.3 N·m");
    let table = String::from_utf8(csv(&candidates_table(&study, &results.entries)).unwrap()).unwrap();
    assert!(table.starts_with("rank,name,found,x_mm,y_mm,z_mm,yaw_deg,pitch_deg,roll_deg,"), "{table}");
}

#[test]
fn a_tilt_that_the_machine_cannot_follow_is_refused() {
    let folder = tilted_folder();
    let only_roll = ARM.replace("\"rotation_x\", \"rotation_y\", \"rotation_z\"", "\"rotation_x\", \"rotation_z\"");
    write(folder.path(), "arm.toml", &only_roll);
    // Of three revolute joints about y its paths need two.
    let tilted = TILTED.replace("[[placement.feature]]", "[locked]\narm_j5 = -40.0\n[[placement.feature]]");
    let level = tilted.replace("yaw_deg = 30.0\n", "");
    let error = study_in(folder.path(), &level).unwrap_err().to_string();
    assert!(error.contains("bounds.pitch_deg") && error.contains("does not control rotation about y"), "{error}");
    // With yaw, roll turns about both axes of the machine.
    let no_pitch = tilted.replace("pitch_deg = [-10.0, 10.0]\n", "").replace(", pitch = 3", "");
    let error = study_in(folder.path(), &no_pitch).unwrap_err().to_string();
    assert!(error.contains("bounds.roll_deg") && error.contains("does not control rotation about y"), "{error}");
    assert!(study_in(folder.path(), &no_pitch.replace("yaw_deg = 30.0\n", "")).is_ok());
}

/// Two grooves on the Orthoglide, the second one cut harder.
const TWO: &str = r#"
schema = 3
question = "where?"
machine = "orthoglide"
[[placement.feature]]
name = "shallow"
process = "shallow.toml"
circle = { centre_mm = [-30.0, 0.0, 0.0], diameter_mm = 40.0, points = 17 }
tolerance_mm = 0.6
[[placement.feature]]
name = "deep"
process = "deep.toml"
circle = { centre_mm = [30.0, 0.0, 0.0], diameter_mm = 20.0, points = 17 }
tolerance_mm = 0.2
[placement.bounds]
x_mm = [-20.0, 70.0]
y_mm = [-40.0, 80.0]
[placement.fixed]
z_mm = 0.0
[placement.allowance]
position_mm = 0.0
angle_deg = 0.0
[placement.objective]
weights = { WEIGHT = 1.0 }
[placement.search]
grid = { x = 3, y = 3 }
starts = 1
max_iterations = 10
[[placement.candidate]]
name = "corner"
origin_mm = [70.0, 80.0, 0.0]
"#;

fn two(weight: &str) -> PlacementStudy {
    let folder = tempfile::tempdir().unwrap();
    let force = |force: f64| {
        format!(
            "schema = 1\n[placement]\nreference = \"platform_point\"\n[force.path_frame]\nradial_force_N = {force}\n\
             tangential_force_N = -10.0\naxial_force_N = -25.0\nlaw = \"rotated\"\n[limits]\nmax_correction_mm = 0.3\n"
        )
    };
    write(folder.path(), "shallow.toml", &force(100.0));
    write(folder.path(), "deep.toml", &force(250.0));
    study_in(folder.path(), &TWO.replace("WEIGHT", weight)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn several_features_are_judged_together_and_shown_one_by_one() {
    let study = two("worst_deflection");
    let results = searched(&study);
    let best = results.entries.iter().find(|entry| entry.outcome.is_ok()).unwrap();
    let evaluation = best.outcome.as_ref().unwrap();
    let worst = |metrics: &kinetostat::questions::placement::Metrics| metrics.get(Metric::WorstDeflection).unwrap();
    let [shallow, deep] = [0, 1].map(|f| worst(&evaluation.features[f]));
    assert!(deep > 1.5 * shallow, "{shallow} {deep}");
    assert_eq!(worst(&evaluation.metrics), shallow.max(deep));
    let table = String::from_utf8(csv(&candidates_table(&study, &results.entries)).unwrap()).unwrap();
    assert!(table.lines().next().unwrap().contains("worst_deflection_shallow_mm,worst_deflection_deep_mm"), "{table}");
    let shown: Vec<(String, usize)> = results.traces.iter().map(|trace| (trace.place.clone(), trace.feature)).collect();
    assert_eq!(shown.iter().map(|(_, feature)| *feature).collect::<Vec<_>>(), [0, 0, 1, 1]);
    assert_eq!((&shown[0].0, &shown[1].0), (&best.name, &"corner".to_string()));
    let names: Vec<String> = figures(&results).into_iter().map(|(name, _)| name).collect();
    for name in ["paths_shallow", "paths_deep", "path_errors_shallow", "path_errors_deep"] {
        assert!(names.iter().any(|n| n == name), "{name} not among {names:?}");
    }
    // Each trace is of its own feature at its own place.
    for trace in &results.traces {
        let entry = results.entries.iter().find(|entry| entry.name == trace.place).unwrap();
        let metrics = &entry.outcome.as_ref().unwrap().features[trace.feature];
        let largest = trace.before.iter().flatten().map(|error| error.norm()).fold(0.0, f64::max);
        assert!((largest - worst(metrics)).abs() < 1e-6, "{} {}", trace.place, trace.feature);
    }
}

#[test]
fn the_residual_error_within_limits_can_be_made_small() {
    let study = two("worst_residual");
    let results = searched(&study);
    let best = results.best.as_ref().unwrap();
    let of_cells: Vec<f64> =
        results.cells.iter().filter_map(|cell| cell.complete()?.get(Metric::WorstResidual)).collect();
    assert!(!of_cells.is_empty());
    let least = of_cells.iter().copied().fold(f64::MAX, f64::min);
    assert!(best.value <= least, "{best:?} {of_cells:?}");
    assert!(least > 0.0, "the limits bind nowhere");
    let entry = results.entries.iter().find(|entry| entry.name == "corner").unwrap();
    let metrics = &entry.outcome.as_ref().unwrap().metrics;
    assert!(metrics.get(Metric::WorstResidual).unwrap() < metrics.get(Metric::WorstDeflection).unwrap());
}
