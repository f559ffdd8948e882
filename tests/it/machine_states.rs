//! Machines with weight, springs between points and closed inner loops against independent states; see
//! `tests/reference/README.md`.

use crate::support::{Within, engine::*, reference};
use kinetostat::{
    compensation::{CompensationSettings, Demand, Method, Session, Target, compensate},
    machine::{Configuration, Machine},
    spatial::{Pose, Wrench, rotation_log},
    statics::{Outcome, State, Status, Workspace, equilibrium},
};
use nalgebra::Vector3;
use serde_json::Value;

const FILES: [(&str, &str); 4] = [
    ("robot", "robot_6r"),
    ("robot_without_compensator", "robot_6r_plain"),
    ("hybrid", "hybrid_3ups"),
    ("fourbar", "fourbar_robot"),
];

struct Case {
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
    let states = reference("machines");
    let mut cases = Vec::new();
    for (key, file) in FILES {
        let machine = Machine::from_file(format!("tests/machines/{file}.toml").as_ref()).unwrap();
        for (number, json) in states[key].as_array().unwrap().iter().enumerate() {
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
    fn settle(&self, load: &Wrench, workspace: &mut Workspace) -> (State, Outcome) {
        let mut state = State::rigid(&self.machine, &self.at);
        let outcome = equilibrium(&self.machine, &self.at.drives, load, &mut state, workspace, &EXACT);
        assert_eq!(outcome.status, Status::Solved, "{}", self.label);
        (state, outcome)
    }

    fn expect(&self, key: &str, got: &[f64], within: Within) {
        within.check(&format!("{}: {key}", self.label), got, &numbers(&self.json[key]));
    }
}

fn check_equilibrium(case: &Case, workspace: &mut Workspace) {
    let (state, outcome) = case.settle(&case.load, workspace);
    case.expect("platform_mm", state.pose.translation.as_slice(), Within::Absolute(1e-8));
    let turn = rotation_log(&(state.pose.rotation * case.at.pose.rotation.transpose()));
    case.expect("platform_turn_rad", turn.as_slice(), Within::Absolute(1e-10));
    let moved = case.machine.tool_displacement(&case.at.pose, &state.pose);
    case.expect("tool_displacement_mm", moved.as_slice(), Within::Absolute(1e-8));
    let stiffness = outcome.stiffness.unwrap().transpose();
    case.expect("stiffness_loaded", stiffness.as_slice(), Within::Stiffness(1e-6));
    let (rest, _) = case.settle(&Wrench::zero(), workspace);
    let sag = case.machine.tool_displacement(&case.at.pose, &rest.pose);
    case.expect("tool_displacement_without_cutting_mm", sag.as_slice(), Within::Absolute(1e-8));
}

#[test]
fn equilibria_are_met() {
    for case in cases() {
        check_equilibrium(&case, &mut Workspace::new(&case.machine));
    }
}

#[test]
fn equilibria_are_met_without_condensation() {
    for case in cases() {
        check_equilibrium(&case, &mut Workspace::uncondensed(&case.machine));
    }
}

#[test]
fn compensated_drives_are_met() {
    for case in cases() {
        for method in [Method::Direct, Method::Newton] {
            let mut session = Session::new(&case.machine, &case.machine, CompensationSettings::default());
            session.stand(&case.at, &State::rigid(&case.machine, &case.at));
            let target = Target::FullPose;
            let done =
                compensate(&mut session, &Demand { pose: case.at.pose, load: case.load, target, wanted: None }, method);
            assert!(done.status.is_success(), "{}: {:?}", case.label, done.status);
            case.expect("rho_compensated", &done.drives, Within::Absolute(1e-9));
        }
    }
}
