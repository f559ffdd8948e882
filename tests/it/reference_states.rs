//! The engine against independent nonlinear states; see `tests/reference/README.md`.

use crate::support::{Within, reference};
use kinetostat::{
    compensation::{CompensationSettings, CompensationStatus, Method, Session, Target, TaskPoint, compensate},
    machine::{ChainError, Configuration, Machine},
    spatial::{Wrench, rotation_log},
    statics::{Outcome, Scratch, Settings, Solution, State, Status, equilibrium, unloaded_stiffness},
};
use nalgebra::{Matrix6, Vector3};
use serde_json::Value;

struct Case {
    nominal: Machine,
    actual: Machine,
    at: Configuration,
    load: Wrench,
    json: Value,
}

impl Case {
    fn all(machine: &str) -> Vec<Case> {
        let nominal = Machine::named_or_file(machine).unwrap();
        let cases = reference(machine);
        let cases = cases.as_array().unwrap();
        assert!(!cases.is_empty());
        cases.iter().map(|json| Case::new(&nominal, json)).collect()
    }

    fn new(nominal: &Machine, json: &Value) -> Case {
        let errors: Vec<ChainError> = match json.get("assembly_deg") {
            Some(angles) => {
                let turn = |(chain, angle): (_, f64)| ChainError::turn_about_drive_axis(chain, angle.to_radians());
                nominal.chains.iter().zip(numbers(angles)).map(turn).collect()
            }
            None => Vec::new(),
        };
        let position = Vector3::from_vec(numbers(&json["position_mm"]));
        Case {
            nominal: nominal.clone(),
            actual: nominal.with_errors(&errors),
            at: nominal.inverse_kinematics(&nominal.pose_at(position)).unwrap(),
            load: Wrench::new(numbers(&json["wrench_N_Nmm"]).try_into().unwrap()),
            json: json.clone(),
        }
    }

    fn label(&self) -> String {
        format!("{} at {}, phi {}", self.nominal.name, self.json["position_mm"], self.json["phi_deg"])
    }

    fn solve(&self, scratch: &mut Scratch) -> (State, Outcome) {
        let mut state = State::rigid(&self.nominal, &self.at);
        let settings = Settings { tolerance: 1e-13, ..Settings::default() };
        let outcome = equilibrium(&self.actual, &self.at.drives, &self.load, &mut state, scratch, &settings);
        assert_eq!(outcome.status, Status::Solved, "{}", self.label());
        (state, outcome)
    }

    fn expect(&self, key: &str, got: &[f64], within: Within) {
        within.check(&format!("{}: {key}", self.label()), got, &numbers(&self.json[key]));
    }
}

fn numbers(json: &Value) -> Vec<f64> {
    match json {
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        number => vec![number.as_f64().unwrap()],
    }
}

fn rows(matrix: &Matrix6<f64>) -> Vec<f64> {
    matrix.transpose().iter().copied().collect()
}

/// Machines of the catalogue with independent states.
const MACHINES: [&str; 6] = ["orthoglide", "tripteron", "delta_3puu", "delta_3prpar", "rotary_delta", "hexapod"];

#[test]
fn equilibria_are_met() {
    for machine in MACHINES {
        for case in Case::all(machine) {
            let mut scratch = Scratch::new(&case.actual);
            let (state, outcome) = case.solve(&mut scratch);
            let solution = Solution::new(&case.actual, &case.at.drives, &state, &outcome, &mut scratch);
            let [nominal, force] = match machine {
                "rotary_delta" => ["rho_nominal_rad", "actuator_torque_Nmm"],
                _ => ["rho_nominal_mm", "actuator_force_N"],
            };
            case.expect(nominal, &case.at.drives, Within::Absolute(1e-9));
            case.expect("platform_mm", state.pose.translation.as_slice(), Within::Absolute(1e-8));
            let turn = rotation_log(&state.pose.rotation);
            case.expect("platform_rotvec_rad", turn.as_slice(), Within::Absolute(1e-10));
            case.expect(force, &solution.drive_forces(), Within::RelativeToLargest(1e-5));
            let wrenches: Vec<f64> = solution.chains.iter().flat_map(|chain| chain.wrench.to_array()).collect();
            case.expect("chain_wrench_N_Nmm", &wrenches, Within::RelativeToLargest(1e-5));
        }
    }
}

#[test]
fn tool_displacement_is_met() {
    for case in MACHINES.iter().filter(|name| **name != "tripteron").flat_map(|name| Case::all(name)) {
        let (state, _) = case.solve(&mut Scratch::new(&case.actual));
        let shift = case.nominal.tool_displacement(&case.at.pose, &state.pose);
        case.expect("tool_displacement_mm", shift.as_slice(), Within::Absolute(1e-8));
    }
}

#[test]
fn tripteron_stands_in_the_reference_assembly_mode() {
    for case in Case::all("tripteron") {
        let passive: Vec<f64> = case.at.passive.iter().flatten().copied().collect();
        case.expect("passive_nominal_rad", &passive, Within::Absolute(1e-10));
    }
}

#[test]
fn stiffness_is_met() {
    for machine in MACHINES {
        for case in Case::all(machine) {
            let mut scratch = Scratch::new(&case.nominal);
            let unloaded = unloaded_stiffness(&case.nominal, &case.at, &mut scratch).unwrap();
            case.expect("stiffness_unloaded", &rows(&unloaded), Within::Stiffness(1e-9));
            if case.json.get("stiffness_loaded").is_some() {
                let (_, outcome) = case.solve(&mut scratch);
                case.expect("stiffness_loaded", &rows(&outcome.stiffness.unwrap()), Within::Stiffness(1e-5));
            }
        }
    }
}

#[test]
fn compensated_drives_are_met() {
    for case in Case::all("orthoglide") {
        let mut session = Session::new(&case.nominal, &case.actual, CompensationSettings::default());
        let task = TaskPoint::new(case.at.pose, case.load, Target::ToolTip);
        let done = compensate(&mut session, &task, Method::Direct);
        assert_eq!(done.status, CompensationStatus::Converged, "{}: error {:e} mm", case.label(), done.task_error());
        case.expect("rho_compensated_mm", &done.drives, Within::Absolute(1e-8));
        let change: Vec<f64> = done.drives.iter().zip(&case.at.drives).map(|(a, b)| a - b).collect();
        case.expect("delta_rho_mm", &change, Within::Absolute(1e-8));
        let turn = rotation_log(&session.state().pose.rotation);
        case.expect("compensated_rotvec_rad", turn.as_slice(), Within::Absolute(1e-10));
        case.expect("compensated_actuator_force_N", &done.drive_forces, Within::RelativeToLargest(1e-5));
    }
}
