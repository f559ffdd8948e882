//! Machines with weight, springs between points and closed inner loops against independent states; see
//! `tests/reference/README.md`.

use crate::support::{Within, engine::*, reference};
use kinetostat::{
    compensation::{CompensationSettings, Method, Session, Target, TaskPoint, compensate},
    machine::{Configuration, Machine, ZeroState},
    spatial::{Pose, Wrench, rotation_log},
    statics::{Outcome, Scratch, State, Status, equilibrium, unloaded_stiffness},
};
use nalgebra::Vector3;
use serde_json::Value;

/// File of states, their key in it, and the machine.
const STATES: [(&str, &str, &str); 11] = [
    ("machines", "robot", "tests/machines/robot_6r.toml"),
    ("machines", "robot_without_compensator", "tests/machines/robot_6r_plain.toml"),
    ("machines", "hybrid", "tests/machines/hybrid_3ups.toml"),
    ("machines", "fourbar", "tests/machines/fourbar_robot.toml"),
    ("arms", "fanuc_r2000ic", "fanuc_r2000ic"),
    ("arms", "kr270", "kr270"),
    ("arms", "kr500", "kr500"),
    ("arms", "irb7600", "irb7600"),
    ("arms", "hybrid_3ups", "hybrid_3ups"),
    ("arms", "ur10e", "ur10e"),
    ("arms", "ur5e", "ur5e"),
];

struct Case {
    file: &'static str,
    machine: Machine,
    at: Configuration,
    load: Wrench,
    json: Value,
    label: String,
}

fn numbers(json: &Value) -> Vec<f64> {
    match json {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().unwrap()],
    }
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (file, key, name) in STATES {
        let machine = catalogue_machine(name);
        for (number, json) in reference(file)[key].as_array().unwrap().iter().enumerate() {
            let pose = numbers(&json["pose_mm_rotvec"]);
            let mut target = Pose::from_rotation_vector(Vector3::new(pose[3], pose[4], pose[5]));
            target.translation = Vector3::new(pose[0], pose[1], pose[2]);
            let at =
                machine.forward_kinematics(&numbers(&json["rho_nominal"])).unwrap_or_else(|e| panic!("{key}: {e}"));
            let label = format!("{key} {number}");
            Within::Absolute(1e-9).check(&format!("{label}: place"), at.pose.translation.as_slice(), &pose[..3]);
            let turn = rotation_log(&(at.pose.rotation * target.rotation.transpose()));
            assert!(turn.norm() < 1e-11, "{label}: {turn}");
            cases.push(Case {
                load: Wrench::new(numbers(&json["wrench_N_Nmm"]).try_into().unwrap()),
                file: name,
                machine: machine.clone(),
                at,
                json: json.clone(),
                label,
            });
        }
    }
    cases
}

impl Case {
    fn settle(&self, load: &Wrench, scratch: &mut Scratch) -> (State, Outcome) {
        let mut state = State::rigid(&self.machine, &self.at);
        let outcome = equilibrium(&self.machine, &self.at.drives, load, &mut state, scratch, &EXACT);
        assert_eq!(outcome.status, Status::Solved, "{}", self.label);
        (state, outcome)
    }

    fn expect(&self, key: &str, got: &[f64], within: Within) {
        within.check(&format!("{}: {key}", self.label), got, &numbers(&self.json[key]));
    }
}

fn check_equilibrium(case: &Case, scratch: &mut Scratch) {
    let (state, outcome) = case.settle(&case.load, scratch);
    case.expect("platform_mm", state.pose.translation.as_slice(), Within::Absolute(1e-8));
    let turn = rotation_log(&(state.pose.rotation * case.at.pose.rotation.transpose()));
    case.expect("platform_turn_rad", turn.as_slice(), Within::Absolute(1e-10));
    let moved = case.machine.tool_displacement(&case.at.pose, &state.pose);
    case.expect("tool_displacement_mm", moved.as_slice(), Within::Absolute(1e-8));
    let stiffness = outcome.stiffness.unwrap().transpose();
    case.expect("stiffness_loaded", stiffness.as_slice(), Within::Stiffness(1e-6));
    let (rest, _) = case.settle(&Wrench::zero(), scratch);
    let sag = case.machine.tool_displacement(&case.at.pose, &rest.pose);
    case.expect("tool_displacement_without_cutting_mm", sag.as_slice(), Within::Absolute(1e-8));
}

#[test]
fn equilibria_are_met() {
    for case in cases() {
        check_equilibrium(&case, &mut Scratch::new(&case.machine));
    }
}

#[test]
fn equilibria_are_met_without_condensation() {
    for case in cases() {
        check_equilibrium(&case, &mut Scratch::uncondensed(&case.machine));
    }
}

#[test]
fn stiffness_without_load_and_weight_is_met() {
    for case in cases().into_iter().filter(|case| case.json.get("stiffness_unloaded").is_some()) {
        let unloaded = unloaded_stiffness(&case.machine, &case.at, &mut Scratch::new(&case.machine)).unwrap();
        case.expect("stiffness_unloaded", unloaded.transpose().as_slice(), Within::Stiffness(1e-8));
    }
}

#[test]
fn compensated_drives_are_met() {
    for case in cases() {
        for method in [Method::Direct, Method::Newton] {
            let mut session = Session::new(&case.machine, &case.machine, CompensationSettings::default());
            session.set_state(&case.at, &State::rigid(&case.machine, &case.at));
            let target = Target::FullPose;
            let done = compensate(
                &mut session,
                &TaskPoint {
                    pose: case.at.pose,
                    load: case.load,
                    target,
                    wanted: Some(case.at.pose),
                    aside: nalgebra::Vector3::zeros(),
                    external: None,
                    led: None,
                    asked: None,
                },
                method,
            );
            assert!(done.status.is_success(), "{}: {:?}", case.label, done.status);
            case.expect("rho_compensated", &done.drives, Within::Absolute(1e-9));
        }
    }
}

/// Numbers of a key, or of its prismatic and revolute joints, as `point --json` gives them for drives (mm, degrees).
fn drive_values(machine: &Machine, json: &Value, key: &str) -> Vec<f64> {
    let of = |suffix: &str, d: usize| json.get(format!("{key}_{suffix}")).and_then(|list| list[d].as_f64());
    (0..machine.drive_count()).map(|d| of("mm", d).or_else(|| of("deg", d).map(f64::to_radians)).unwrap()).collect()
}

#[test]
fn the_command_line_meets_them_by_pose_and_by_joints() {
    // The program measures from where a machine is zeroed, the states from the rigid one.
    for case in cases().into_iter().filter(|case| case.machine.zeroed == ZeroState::Weightless) {
        let joined = |values: &[f64]| values.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(",");
        let joints: Vec<f64> = case
            .at
            .drives
            .iter()
            .zip(case.machine.drives())
            .map(|(rho, (_, drive))| drive.motion.to_shown(*rho))
            .collect();
        let (roll, pitch, yaw) = nalgebra::Rotation3::from_matrix_unchecked(case.at.pose.rotation).euler_angles();
        let mut pose: Vec<f64> = case.at.pose.translation.iter().copied().collect();
        pose.extend([roll, pitch, yaw].map(f64::to_degrees));
        // A wrist that is bent the other way is another branch, to which no pose leads.
        let is_on_branch = case.machine.inverse_kinematics(&case.at.pose).is_ok();
        assert!(is_on_branch || case.file.ends_with("hybrid_3ups.toml"), "{}", case.label);
        for (option, values) in [("--joints", joints), ("--pose", pose)] {
            if option == "--pose" && !is_on_branch {
                continue;
            }
            let (values, wrench) = (joined(&values), joined(&case.load.to_array()));
            let run = std::process::Command::new(env!("CARGO_BIN_EXE_kinetostat"))
                .args(["point", "--json", "--full-pose", "--machine", case.file])
                .args([&format!("{option}={values}"), &format!("--wrench={wrench}")])
                .output()
                .unwrap();
            assert!(run.status.success(), "{} {option}: {}", case.label, String::from_utf8_lossy(&run.stderr));
            let json: Value = serde_json::from_slice(&run.stdout).unwrap();
            let rho = drive_values(&case.machine, &json, "rho_nominal");
            case.expect("rho_nominal", &rho, Within::Absolute(1e-9));
            case.expect("platform_mm", &numbers(&json["platform_mm"]), Within::Absolute(1e-8));
            case.expect("platform_turn_rad", &numbers(&json["platform_turn_rad"]), Within::Absolute(1e-10));
            case.expect("tool_displacement_mm", &numbers(&json["tool_displacement_mm"]), Within::Absolute(1e-8));
            case.expect("stiffness_loaded", &numbers(&json["stiffness_loaded"]), Within::Stiffness(1e-6));
            let sag = numbers(&json["tool_displacement_by_weight_mm"]);
            case.expect("tool_displacement_without_cutting_mm", &sag, Within::Absolute(1e-8));
            let rho = drive_values(&case.machine, &json, "rho_compensated");
            case.expect("rho_compensated", &rho, Within::Absolute(1e-8));
        }
    }
}
