//! Workpieces on carriers that move and bend: closed forms, machines with the same springs elsewhere, invariance, energy.

use crate::support::command::told;
use crate::support::engine::*;
use kinetostat::{
    compensation::{Compensation, Method, Session, Target, TaskPoint, compensate},
    inspect::machine_check,
    machine::Machine,
    simulation::{Machines, Source, settings},
    spatial::{Pose, Wrench},
    work::Work,
};
use nalgebra::{Matrix3, Vector3};

/// What `check` finds of a machine without bodies in files.
fn check(machine: &Machine) -> machine_check::Findings {
    machine_check::check(machine).unwrap()
}

const KR270: &str = include_str!("../machines/kr270.toml");

/// Three prismatic joints, their stiffness in N/mm.
fn slides(stiffness: f64) -> String {
    format!(
        r#"
schema = 1
name = "slides"
title = "Three prismatic joints"
[platform]
tool_tip_mm = [0.0, 0.0, -50.0]
controls = ["x", "y", "z"]
[home]
position_mm = [100.0, 0.0, 0.0]
[workspace]
min_mm = [-200.0, -200.0, -200.0]
max_mm = [200.0, 200.0, 200.0]
[[chain]]
name = "arm"
elements = [
  {{ prismatic_drive = {{ name = "x", axis = "x", stiffness_N_per_mm = {stiffness:e} }} }},
  {{ prismatic_drive = {{ name = "y", axis = "y", stiffness_N_per_mm = {stiffness:e} }} }},
  {{ prismatic_drive = {{ name = "z", axis = "z", stiffness_N_per_mm = {stiffness:e} }} }},
]
[[mount]]
name = "arm"
chain = "arm"
"#
    )
}

/// The file of a machine with a carrier of these elements.
fn machine_text(machine: &str, base: &str, elements: &str) -> String {
    format!(
        "{machine}\n[[chain]]\nname = \"under\"\nelements = [{elements}]\n\
         [workpiece_carrier]\nname = \"table\"\nchain = \"under\"\n{base}"
    )
}

/// That machine.
fn carried(machine: &str, base: &str, elements: &str) -> Machine {
    machine_from(&machine_text(machine, base, elements))
}

fn session(machine: &Machine) -> Session {
    Session::new(machine, machine, settings())
}

/// A force on the tool tip of a machine that is commanded to `position`.
fn on_tip(machine: &Machine, position: [f64; 3], force: [f64; 3]) -> TaskPoint {
    let pose = machine.pose_at(position.into());
    let lever = pose.rotation * machine.tool_tip;
    let load = Wrench { force: force.into(), moment: Vector3::zeros() }.shift(-lever);
    TaskPoint::new(pose, load, Target::ToolTip)
}

fn answer(machine: &Machine, task: &TaskPoint, method: Method) -> (Compensation, Pose) {
    let mut session = session(machine);
    let answer = compensate(&mut session, task, method);
    assert!(answer.status.is_success(), "{:?}", answer.status);
    let pose = session.state().pose;
    (answer, pose)
}

#[test]
fn a_turntable_yields_by_force_times_lever_squared_over_its_stiffness() {
    // The revolute joint about z at the base, the tool 100 mm from it along x: a force along y turns it.
    let stiffness = 1e7;
    let revolute =
        format!("{{ revolute_drive = {{ name = \"C\", axis = \"z\", stiffness_Nmm_per_rad = {stiffness:e} }} }}");
    let machine = carried(&slides(1e12), "", &revolute);
    for force in [0.01, 100.0] {
        let task = on_tip(&machine, [100.0, 0.0, 0.0], [0.0, force, 0.0]);
        let (plain, _) = answer(&machine, &task, Method::None);
        // The point turns by θ with k θ = F r cos θ.
        let mut turn: f64 = 0.0;
        for _ in 0..60 {
            turn -= (stiffness * turn - force * 100.0 * turn.cos()) / (stiffness + force * 100.0 * turn.sin());
        }
        let expected = Vector3::new(100.0 - 100.0 * turn.cos(), 100.0 * turn.sin(), 0.0);
        let moved = plain.tool_displacement - Vector3::new(0.0, force / 1e12, 0.0);
        assert!((moved - expected).norm() < 1e-9, "{moved} {expected}");
        if force < 1.0 {
            let linear = force * 100.0 * 100.0 / stiffness;
            assert!((moved.y / linear - 1.0).abs() < 1e-4);
        }
        let (corrected, pose) = answer(&machine, &task, Method::Direct);
        assert!(corrected.position_error.norm() < 1e-9);
        // The tool stands at the point of the workpiece that it has pushed away.
        let tip = pose.transform(machine.tool_tip);
        let point = Vector3::new(100.0 * turn.cos(), -100.0 * turn.sin(), -50.0);
        assert!((tip - point).norm() < 1e-9, "{tip} {point}");
    }
}

#[test]
fn a_slide_under_the_workpiece_is_in_series_with_that_of_the_machine() {
    let slide = r#"{ prismatic_drive = { name = "Z", axis = "z", stiffness_N_per_mm = 2e3 } }"#;
    let machine = carried(&slides(5e3), "", slide);
    let task = on_tip(&machine, [80.0, 30.0, -20.0], [0.0, 0.0, -400.0]);
    let (plain, _) = answer(&machine, &task, Method::None);
    assert!((plain.tool_displacement.z + 400.0 / 2e3 + 400.0 / 5e3).abs() < 1e-9, "{}", plain.tool_displacement);
    // The same springs, all before the tool.
    let soft = machine_from(&slides(5e3).replace(
        "name = \"z\", axis = \"z\", stiffness_N_per_mm = 5e3",
        "name = \"z\", axis = \"z\", stiffness_N_per_mm = 5e3, shaft_stiffness_N_per_mm = 2e3",
    ));
    let (alike, _) = answer(&soft, &task, Method::None);
    assert!((alike.tool_displacement - plain.tool_displacement).norm() < 1e-9);
    let (corrected, _) = answer(&machine, &task, Method::Direct);
    let (all_before, _) = answer(&soft, &task, Method::Direct);
    for (a, b) in corrected.drives.iter().zip(&all_before.drives) {
        assert!((a - b).abs() < 1e-9);
    }
    // And the tool has the stiffness of both, wherever it is told.
    let both = 1.0 / (1.0 / 2e3 + 1.0 / 5e3);
    let carried = session(&machine).workpiece_compliance(&task).unwrap();
    assert!((carried - Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 1.0 / 2e3))).amax() < 1e-15, "{carried}");
    let findings = check(&machine);
    for [least, ..] in
        [findings.tool_stiffness, findings.survey.and_then(|s| s.softest).map(|s| s.tool_stiffness_n_per_mm)]
            .map(|found| found.expect("elastic"))
    {
        assert!((least / both - 1.0).abs() < 1e-6, "{least}");
    }
    let least = map_column(&machine_text(&slides(5e3), "", slide), "stiffness_min_N_per_mm");
    assert!(least.iter().all(|least| (least / both - 1.0).abs() < 1e-3), "{least:?}");
}

#[test]
fn the_droop_of_a_carrier_is_seen_from_the_tool() {
    let slide = r#"{ prismatic_drive = { name = "Z", axis = "z", stiffness_N_per_mm = 2e3 } },
        { mass = { kg = 100.0, at_mm = [0.0, 0.0, 0.0] } }"#;
    let droop = check(&carried(&slides(5e3), "", slide)).survey.and_then(|survey| survey.droop).expect("has weight");
    for found in droop.range_mm {
        assert!((found - 100.0 * 9.81 / 2e3).abs() < 1e-6, "{found}");
    }
}

/// An arm before a tilting turntable, both with masses, moved as a whole by `by`.
fn cell(by: &Pose) -> Machine {
    let gravity: [f64; 3] = (by.rotation * Vector3::new(0.0, 0.0, -9.81)).into();
    let frame = |pose: &Pose| {
        let [x, y] = [0, 1].map(|i| <[f64; 3]>::from(pose.rotation.column(i).into_owned()));
        let at: [f64; 3] = pose.translation.into();
        format!("{{ position_mm = {at:?}, x_axis = {x:?}, y_axis = {y:?} }}")
    };
    let table = by.compose(&Pose::from_translation(Vector3::new(1500.0, 0.0, 500.0)));
    let home = by.compose(&Pose {
        translation: Vector3::new(1600.0, 0.0, 1000.0),
        ..Pose::from_roll_pitch_yaw(Vector3::new(0.0, std::f64::consts::PI, 0.0))
    });
    let r = home.rotation;
    let angles = [r[(2, 1)].atan2(r[(2, 2)]), (-r[(2, 0)]).clamp(-1.0, 1.0).asin(), r[(1, 0)].atan2(r[(0, 0)])];
    let at: [f64; 3] = home.translation.into();
    let toml = KR270
        .replace("position_mm = [1600.0, 0.0, 1000.0]", &format!("position_mm = {at:?}"))
        .replace("rotation_deg = [0.0, 180.0, 0.0]", &format!("rotation_deg = {:?}", angles.map(f64::to_degrees)))
        .replace("source =", &format!("gravity_m_per_s2 = {gravity:?}\nsource ="));
    let toml = toml.replace("chain = \"arm\"", &format!("chain = \"arm\"\nbase = {}", frame(by)));
    let toml = toml.replace(
        "  { fixed = { translation_mm = [230.0, 0.0, 0.0]",
        "  { mass = { kg = 40.0, at_mm = [100.0, 20.0, 0.0] } },\n  { fixed = { translation_mm = [230.0, 0.0, 0.0]",
    );
    let elements = r#"
  { revolute_drive = { name = "B", axis = "y", stiffness_Nmm_per_rad = 4e8, home_deg = 20.0, travel_deg = [-90.0, 90.0] } },
  { link = { advance_mm = 0.0, stiffness_N_mm_rad = [[1e5,0,0,0,0,0],[0,1e5,0,0,0,0],[0,0,2e5,0,0,0],[0,0,0,1e9,0,0],[0,0,0,0,1e9,0],[0,0,0,0,0,1e9]] } },
  { fixed = { translation_mm = [0.0, 0.0, 150.0] } },
  { mass = { kg = 120.0, at_mm = [60.0, 0.0, 40.0] } },
  { revolute_drive = { name = "C", axis = "z", stiffness_Nmm_per_rad = 3e8 } },
"#;
    carried(&toml, &format!("base = {}", frame(&table)), elements)
}

fn cell_task(machine: &Machine, by: &Pose) -> TaskPoint {
    let pose = by.compose(&Pose {
        translation: Vector3::new(1650.0, 120.0, 1050.0),
        ..Pose::from_roll_pitch_yaw(Vector3::new(0.1, 3.0, 0.2))
    });
    let lever = pose.rotation * machine.tool_tip;
    let force = by.rotation * Vector3::new(700.0, -400.0, 900.0);
    let load = Wrench { force, moment: Vector3::zeros() }.shift(-lever);
    TaskPoint::new(pose, load, Target::FullPose)
}

#[test]
fn a_cell_turned_as_a_whole_answers_alike() {
    let turned = Pose {
        translation: Vector3::new(300.0, -200.0, 100.0),
        ..Pose::from_roll_pitch_yaw(Vector3::new(0.7, -0.3, 1.1))
    };
    let answers = [Pose::identity(), turned].map(|by| {
        let machine = cell(&by);
        let task = cell_task(&machine, &by);
        let (plain, _) = answer(&machine, &task, Method::None);
        let (corrected, _) = answer(&machine, &task, Method::Direct);
        (by.rotation.transpose() * plain.tool_displacement, corrected.drives)
    });
    assert!((answers[0].0 - answers[1].0).norm() < 1e-7, "{} {}", answers[0].0, answers[1].0);
    assert!(answers[0].0.norm() > 0.5);
    for (a, b) in answers[0].1.iter().zip(&answers[1].1) {
        assert!((a - b).abs() < 1e-9);
    }
}

#[test]
fn the_work_of_a_small_load_is_the_energy_of_machine_and_carrier() {
    // Of springs alone, 2 U = F · d: twice the energy is the sum over both.
    let machine = cell(&Pose::identity()).weightless();
    let task = cell_task(&machine, &Pose::identity());
    let task = TaskPoint { load: task.load.scale(1e-3), ..task };
    let (both, _) = answer(&machine, &task, Method::None);
    let mut alone = machine.clone();
    alone.carrier = None;
    let (own, _) = answer(&alone, &task, Method::None);
    let by_carrier = both.tool_displacement - own.tool_displacement;
    let energies = |force: Vector3<f64>, d: Vector3<f64>| 0.5 * force.dot(&d);
    let carrier = machine.carrier.as_ref().unwrap();
    // The carrier's own energy under the opposite load, at the point that the tool touches.
    let tip = task.pose.transform(machine.tool_tip);
    let mut touched = carrier.clone();
    let place = carrier.home.pose.inverse().transform(tip);
    touched.chains[0].route.attachment.translation = place;
    let mut at = touched.home.clone();
    at.pose.translation = tip;
    let load = Wrench { force: -task.load.force, moment: Vector3::zeros() };
    let (state, _) = settle(&touched, &at, &load);
    let rigid = kinetostat::statics::State::rigid(&touched, &at);
    let energy: f64 =
        kinetostat::statics::deformation_energies(&touched, &at.drives, &rigid, &state).iter().map(|(_, u)| u).sum();
    assert!((energies(task.load.force, by_carrier) / energy - 1.0).abs() < 1e-5);
}

#[test]
fn weight_of_the_carrier_is_zeroed_with_that_of_the_machine() {
    let machine = cell(&Pose::identity());
    let task = TaskPoint { load: Wrench::zero(), ..cell_task(&machine, &Pose::identity()) };
    let (still, _) = answer(&machine, &task, Method::None);
    assert!(still.tool_displacement.norm() < 1e-8, "{}", still.tool_displacement);
    // Against the rigid model, the table sinks away from the tool.
    let machines = Machines::new(&machine, &[]).unwrap();
    let mut alone = machine.clone();
    alone.carrier = None;
    let sunk = |machines: &Machines| {
        compensate(&mut machines.session(Source::Weight), &Source::Weight.task(&task), Method::None)
    };
    let (with, without) = (sunk(&machines), sunk(&Machines::new(&alone, &[]).unwrap()));
    assert!((with.tool_displacement - without.tool_displacement).norm() > 1e-3);
}

#[test]
fn a_carrier_moves_where_it_is_held() {
    let machine = cell(&Pose::identity());
    let held = machine.with_locked_drives(&[("C", 90.0), ("table_B", 0.0)]).unwrap();
    let pose = held.carrier.as_ref().unwrap().home.pose;
    assert!((pose.translation - Vector3::new(1500.0, 0.0, 650.0)).norm() < 1e-9);
    assert!((pose.rotation.column(0) - Vector3::y()).norm() < 1e-12);
    assert_eq!(held.home, machine.home);
    let shown: Vec<(String, f64)> = held.locked_drives().into_iter().map(|(label, value, _)| (label, value)).collect();
    assert_eq!(shown, [("table_B".to_string(), 0.0), ("table_C".to_string(), 90.0)]);
    // Numbers set afterwards leave it there.
    let other = held.with_parameters(&[("under.C.stiffness", 1e9)]).unwrap();
    assert_eq!(other.carrier.as_ref().unwrap().home.drives, held.carrier.as_ref().unwrap().home.drives);
    let refused = machine.with_locked_drives(&[("table_B", 120.0)]).unwrap_err().to_string();
    assert_eq!(refused, "table_B: must be within its travel of -90 to 90 deg, got 120");
}

#[test]
fn numbers_of_the_carrier_are_parameters() {
    let machine = cell(&Pose::identity());
    let names: Vec<String> = machine.parameters().into_iter().map(|parameter| parameter.name).collect();
    for name in ["under.C.stiffness", "under.mass_1.kg", "table.base.position.x", "under.link_1.stiffness.x_x"] {
        assert!(names.iter().any(|other| other == name), "{name}: {names:?}");
    }
    let task = cell_task(&machine, &Pose::identity());
    let softer = machine.with_parameters(&[("under.B.stiffness", 1e8)]).unwrap();
    let (before, _) = answer(&machine, &task, Method::None);
    let (after, _) = answer(&softer, &task, Method::None);
    assert!(after.tool_displacement.norm() > before.tool_displacement.norm());
}

// A robot on a rail before a turntable, held and free.

const CELL: &str = include_str!("../machines/kr270_cell.toml");

#[test]
fn a_rail_that_is_held_is_commanded_and_not_free() {
    let cell = machine_from(CELL);
    let pose = cell.pose_at(Vector3::new(1650.0, 250.0, 950.0));
    let free = cell.inverse_kinematics(&pose).unwrap();
    for (value, name) in [(400.0, "rail"), (-300.0, "robot_rail")] {
        let held = cell.with_locked_drives(&[(name, value)]).unwrap();
        assert_eq!(held.home.drives[0], value);
        assert!((held.home.pose.translation - cell.home.pose.translation - Vector3::y() * value).norm() < 1e-9);
        let at = held.inverse_kinematics(&pose).unwrap();
        assert_eq!(at.drives[0], value);
        assert!((free.drives[0] - value).abs() > 10.0);
        let back = cell.forward_kinematics_from(&at, &at.drives).unwrap();
        assert!((back.pose.translation - pose.translation).norm() < 1e-9);
        assert!((back.pose.rotation - pose.rotation).norm() < 1e-10);
        // Every method commands it there.
        let task = on_tip(&held, [1650.0, 250.0, 950.0], [300.0, -200.0, 500.0]);
        for method in [Method::Direct, Method::Newton, Method::MatrixFree { alpha: 1.0 }] {
            let (answer, _) = answer(&held, &task, method);
            assert!((answer.drives[0] - value).abs() < 1e-9, "{method:?}: {}", answer.drives[0]);
            assert!(answer.position_error.norm() < 1e-7, "{method:?}");
        }
    }
}

#[test]
fn an_arm_with_its_rail_held_bends_as_one_that_is_bolted_there_and_has_the_rails_spring() {
    let rail = "{ prismatic_drive = { name = \"rail\", axis = \"y\", stiffness_N_per_mm = 1e5, travel_mm=[-2000.0,2000.0] } },";
    assert!(CELL.contains(rail));
    let held = machine_from(CELL).with_locked_drives(&[("rail", 400.0)]).unwrap();
    let spring = "{ fixed = { translation_mm = [0.0, 400.0, 0.0] } }, { link = { advance_mm = 0.0, \
                  compliance_mm_rad_N = [[1e-15, 0, 0, 0, 0, 0], [0, 1e-5, 0, 0, 0, 0], [0, 0, 1e-15, 0, 0, 0], \
                  [0, 0, 0, 1e-18, 0, 0], [0, 0, 0, 0, 1e-18, 0], [0, 0, 0, 0, 0, 1e-18]] } },";
    let bolted = CELL
        .replace(rail, spring)
        .replace("position_mm = [1600.0, 0.0, 1000.0]\n#", "position_mm = [1600.0, 400.0, 1000.0]\n#");
    let bolted = machine_from(&bolted);
    let task = on_tip(&held, [1650.0, 250.0, 950.0], [300.0, -200.0, 500.0]);
    let (a, _) = answer(&held, &task, Method::None);
    let (b, _) = answer(&bolted, &task, Method::None);
    assert!(
        (a.tool_displacement - b.tool_displacement).norm() < 1e-6,
        "{} {}",
        a.tool_displacement,
        b.tool_displacement
    );
}

fn cell_file() -> String {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/machines/kr270_cell.toml").display().to_string()
}

#[test]
fn a_point_is_solved_with_the_rail_and_the_table_held() {
    let load =
        ["--position", "1600,100,900", "--wrench", "500,300,-400,0,0,0", "--lock", "rail=400", "--lock", "table=30"];
    let file = cell_file();
    let mut arguments = vec!["point", "--machine", &file];
    arguments.extend(load);
    let (code, text, said) = told(&arguments);
    assert_eq!(code, Some(0), "{said}");
    for line in [
        "Deflections are of the tool from the workpiece: its carrier table bears the opposite load and bends as well.",
        "Locked or external axes: robot_rail at 400 mm, table at 30°.",
    ] {
        assert!(text.contains(line), "{text}");
    }
    arguments.push("--json");
    let (_, text, _) = told(&arguments);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["locked"], serde_json::json!({ "robot_rail": 400.0, "table": 30.0 }));
    assert_eq!(json["rho_nominal_mm"][0], 400.0);
    assert!((json["rho_compensated_mm"][0].as_f64().unwrap() - 400.0).abs() < 1e-9);
    assert!(json["tip_error_after_compensation_norm_mm"].as_f64().unwrap() < 1e-8);
    let (code, _, said) = told(&["point", "--machine", &file, "--at", "Q0", "--lock", "rial=3"]);
    assert!(code == Some(2) && said.contains("--lock: rial: no drive is called so; there are: robot_rail"), "{said}");
    let elsewhere = ["point", "--machine", &file, "--joints", "10,0,20,20,0,50,0", "--lock", "rail=3"];
    let (code, _, said) = told(&elsewhere);
    assert!(
        code == Some(2) && said.contains("--joints: drive robot_rail is locked at 3.000 mm, got 10.000 mm"),
        "{said}"
    );
    let (code, text, said) = told(&["check", &file]);
    assert_eq!(code, Some(0), "{said}");
    assert!(text.contains("workpiece carrier  table, 1 drive (0.0000°), W at (1600, 0, 620) mm of the base"), "{text}");
    for share in ["table C", "table plate"] {
        assert!(text.contains(share), "{text}");
    }
}

/// A study of the cell, run; its folder with the results.
fn run(table: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let study = format!(
        "schema = 3\nquestion = \"How far?\"\nmachine = \"cell.toml\"\n[locked]\nrail = 100.0\ntable = 40.0\n\
         [process.force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n{table}"
    );
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    std::fs::copy(cell_file(), folder.path().join("cell.toml")).unwrap();
    let out = folder.path().join("out");
    let (code, text, said) =
        told(&["run", folder.path().to_str().unwrap(), "--out", out.to_str().unwrap(), "--threads", "1"]);
    assert_eq!(code, Some(0), "{text}{said}");
    let unwrapped = (text + &said).split_whitespace().collect::<Vec<_>>().join(" ");
    (folder, unwrapped)
}

/// Numbers of a map of a machine, from its cutting force.
fn map_column(machine: &str, name: &str) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    let study = "schema = 3\nquestion = \"How far?\"\nmachine = \"machine.toml\"\n[process.force.path_frame]\n\
                 radial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n\
                 [workspace_map]\ngrid = [2, 2, 2]\nslices_z_mm = [0.0]\nphi_step_deg = 90.0\n";
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    std::fs::write(folder.path().join("machine.toml"), machine).unwrap();
    let out = folder.path().join("out");
    let (code, text, said) =
        told(&["run", folder.path().to_str().unwrap(), "--out", out.to_str().unwrap(), "--no-figures"]);
    assert_eq!(code, Some(0), "{text}{said}");
    let numbers = column(&folder, "map.csv", "source").into_iter().zip(column(&folder, "map.csv", name));
    numbers.filter(|(source, _)| source == "cutting").map(|(_, number)| number.parse().unwrap()).collect()
}

fn column(folder: &tempfile::TempDir, table: &str, name: &str) -> Vec<String> {
    fn find(folder: &std::path::Path, name: &str) -> Option<std::path::PathBuf> {
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).find_map(|path| match path.is_dir() {
            true => find(&path, name),
            false => path.file_name().is_some_and(|own| own == name).then_some(path),
        })
    }
    let file = find(&folder.path().join("out"), table).unwrap_or_else(|| panic!("no {table}"));
    let text = std::fs::read_to_string(file).unwrap();
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<&str> = rows.next().unwrap().split(',').collect();
    let at = columns.iter().position(|column| *column == name).unwrap_or_else(|| panic!("{name}: {columns:?}"));
    rows.map(|row| row.split(',').nth(at).unwrap().to_string()).collect()
}

#[test]
fn a_path_on_the_turned_table_is_cut_with_the_rail_held() {
    let (folder, said) = run(
        "[path]\ncircle = { centre_mm = [60.0, 0.0, 60.0], diameter_mm = 50.0, points = 9 }\nmethods = [\"none\", \"direct\"]\n",
    );
    for words in ["Locked or external axes: robot_rail at 100 mm, table at 40°.", "origin at (0, 0, 0) mm of the table"]
    {
        assert!(said.contains(words), "{said}");
    }
    let table = column(&folder, "points.csv", "rho_carrier_table_deg");
    assert!(!table.is_empty() && table.iter().all(|value| value.parse::<f64>().unwrap() == 40.0), "{table:?}");
    let rail = column(&folder, "points.csv", "rho_nominal_robot_rail_mm");
    assert!(rail.iter().all(|value| value.parse::<f64>().unwrap() == 100.0), "{rail:?}");
}

#[test]
fn a_map_is_of_the_tool_from_the_table() {
    let (_folder, said) = run("[workspace_map]\ngrid = [2, 2, 2]\nslices_z_mm = [1000.0]\nphi_step_deg = 90.0\n");
    assert!(said.contains("its carrier table bears the opposite load"), "{said}");
}

#[test]
fn a_place_on_the_table_is_sought() {
    let (_folder, said) = run(
        "[[placement.feature]]\nname = \"groove\"\ncircle = { centre_mm = [0.0, 0.0, 60.0], diameter_mm = 50.0, points = 9 }\n\
         tolerance_mm = 0.5\n[placement.bounds]\nx_mm = [-50.0, 50.0]\ny_mm = [-50.0, 50.0]\n[placement.fixed]\nz_mm = 0.0\n\
         [placement.objective]\nweights = { worst_deflection = 1.0 }\n[placement.search]\ngrid = { x = 2, y = 2 }\nstarts = 1\n\
         max_iterations = 5\n",
    );
    assert!(said.contains("Locked or external axes: robot_rail at 100 mm, table at 40°."), "{said}");
}

#[test]
fn a_program_on_the_turned_table_is_compensated_in_its_own_frame() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(file("part.csv"), "x_mm,y_mm,z_mm\n0,0,60\n40,0,60\n40,30,60\n").unwrap();
    let process =
        "schema = 1\n[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n";
    std::fs::write(file("process.toml"), process).unwrap();
    let cell = cell_file();
    let compensated = |table: &str, out: &str| {
        let (part, process, out) = (file("part.csv"), file("process.toml"), file(out));
        let hold = format!("table={table}");
        let arguments = [
            "compensate",
            &part,
            "--machine",
            &cell,
            "--process",
            &process,
            "--lock",
            "rail=50",
            "--lock",
            &hold,
            "--out",
            &out,
        ];
        let (code, text, said) = told(&arguments);
        assert_eq!(code, Some(0), "{text}{said}");
        assert!(text.contains(&format!("Locked or external axes: robot_rail at 50 mm, table at {table}°.")), "{text}");
        let report: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(format!("{out}.report.json")).unwrap()).unwrap();
        assert!(report["workpiece"].as_str().unwrap().contains("mm of the table"), "{report}");
        let program = std::fs::read_to_string(&out).unwrap();
        let points: Vec<Vec<f64>> = program
            .lines()
            .skip(1)
            .map(|row| row.split(',').take(3).map(|value| value.parse().unwrap()).collect())
            .collect();
        points
    };
    for table in ["0", "90"] {
        let points = compensated(table, &format!("out_{table}.csv"));
        for (point, wanted) in
            [&points[0], &points[points.len() - 1]].into_iter().zip([[0.0, 0.0, 60.0], [40.0, 30.0, 60.0]])
        {
            let way = Vector3::new(point[0] - wanted[0], point[1] - wanted[1], point[2] - wanted[2]).norm();
            assert!(way > 0.01 && way < 1.0, "{table}: {point:?}");
        }
    }
}

/// A slide before three others along x: slides alone, one of them to spare.
fn slides_on_a_rail() -> Machine {
    let toml = slides(5e3).replace(
        "elements = [",
        "elements = [\n  { prismatic_drive = { name = \"rail\", axis = \"x\", stiffness_N_per_mm = 4e3 } },",
    );
    machine_from(&toml)
}

#[test]
fn corrections_within_limits_do_not_move_what_is_held() {
    use kinetostat::process::Process;
    let process = |machine: &Machine| {
        let toml = "schema = 1\n[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\n\
                    axial_force_N = -25.0\n[limits]\nmax_correction_mm = 1.0\n";
        let process = Process::from_toml(toml, "process.toml", std::path::PathBuf::new(), machine).unwrap();
        let text = b"x_mm,y_mm,z_mm\n0,0,0\n10,0,0\n".to_vec();
        let polyline = kinetostat::toolpath::polyline::Polyline::read(text, "path.csv").unwrap();
        let file = kinetostat::ProgramFile::Polyline(Box::new(polyline));
        kinetostat::products::program::ProgramJob::new(process, file, "path.csv", &Work::default()).unwrap()
    };
    let machine = slides_on_a_rail();
    assert!(process(&machine_from(&slides(5e3))).bounded_pass(&Work::default(), |_, _| Ok(())).is_ok());
    let held = machine.with_locked_drives(&[("rail", 20.0)]).unwrap();
    let refused = process(&held).bounded_pass(&Work::default(), |_, _| Ok(())).map(|_| ()).unwrap_err().to_string();
    assert_eq!(refused, "limits: cannot be kept with locked drives: corrections within limits move all drives");
}

#[test]
fn a_carrier_that_topples_is_a_status_with_its_name() {
    let revolute = r#"{ revolute_drive = { name = "B", axis = "y", stiffness_Nmm_per_rad = 1e3 } }"#;
    let machine = carried(&slides(1e12), "", revolute);
    let task = on_tip(&machine, [0.0, 0.0, 150.0], [0.0, 0.0, 1000.0]);
    let answer = compensate(&mut session(&machine), &task, Method::Direct);
    assert!(!answer.status.is_success());
    assert!(
        answer.status.reason(&machine).starts_with("workpiece carrier table: "),
        "{}",
        answer.status.reason(&machine)
    );
    let upward = on_tip(&machine, [0.0, 0.0, 150.0], [0.0, 0.0, -1000.0]);
    assert!(compensate(&mut session(&machine), &upward, Method::Direct).status.is_success());
}
