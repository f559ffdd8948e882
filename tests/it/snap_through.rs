//! What is solved is reached from the unloaded machine without passing a singular equilibrium.

use std::path::Path;

use kinetostat::{
    compensation::{self, Method, Session, Target, TaskPoint, compensate},
    machine::Machine,
    spatial::Wrench,
    statics::{Batch, Case, Outcome, Scratch, Settings, State, Status, equilibrium},
};
use nalgebra::Vector3;

fn fivebar() -> Machine {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/machines/fivebar.toml");
    Machine::from_toml(&std::fs::read_to_string(file).unwrap(), "fivebar.toml").unwrap()
}

/// The machine commanded to `position` under `load`, alone and as one of a batch, which must be the same.
fn settled(machine: &Machine, position: [f64; 3], load: Wrench) -> (State, Outcome) {
    let at = machine.inverse_kinematics(&machine.pose_at(Vector3::from(position))).unwrap();
    let (mut state, mut scratch) = (State::rigid(machine, &at), Scratch::new(machine));
    let (mut drives, mut in_lane) = (at.drives.clone(), state.clone());
    let outcome = equilibrium(machine, &at.drives, &load, &mut state, &mut scratch, &Settings::default());
    let mut case = [Case { drives: &mut drives, load, state: &mut in_lane, task: None }];
    let batched = Batch::new(machine).equilibria(&mut case, &Settings::default());
    assert_eq!(format!("{batched:?}"), format!("[{outcome:?}]"));
    assert_eq!(in_lane, state);
    (state, outcome)
}

/// Shares of this load up to 6.8 % are carried 5 mm beside the singular place; the rest was `not_converged`, and all of it
/// `solved` on the other side.
const LOAD: [f64; 6] = [500.0, -300.0, 400.0, 1e5, -5e4, 8e4];

#[test]
fn a_load_that_pushes_through_the_singular_place_snaps_at_the_same_force_whatever_its_size() {
    let machine = fivebar();
    for share in [0.01, 0.03, 0.05, 0.06, 0.067] {
        let (state, outcome) = settled(&machine, [0.0, 5.0, 0.0], Wrench::new(LOAD).scale(share));
        assert_eq!(outcome.status, Status::Solved, "{share} of the load");
        assert!(state.pose.translation.y > 0.0, "{share} of the load: {}", state.pose.translation.y);
    }
    let mut carried = Vec::new();
    for share in [0.07, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.9, 1.0, 1.3] {
        let (_, outcome) = settled(&machine, [0.0, 5.0, 0.0], Wrench::new(LOAD).scale(share));
        let Status::SnapThrough { load_fraction } = outcome.status else { panic!("{share}: {:?}", outcome.status) };
        assert!(outcome.status.reason(&machine).contains("loses its stability at"));
        carried.push(load_fraction * share);
    }
    // To the finest load step.
    assert!(carried.iter().all(|carried| (0.0673..0.0687).contains(carried)), "{carried:?}");
}

#[test]
fn a_singular_place_is_called_so_with_and_without_load() {
    let machine = fivebar();
    for force in [[0.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0], [3.0, -4.0, 5.0]] {
        let [x, y, z] = force;
        let (_, outcome) = settled(&machine, [0.0; 3], Wrench::new([x, y, z, 0.0, 0.0, 0.0]));
        assert_eq!(outcome.status.label(), "singular", "{force:?}: {:?}", outcome.status);
    }
}

#[test]
fn chain_errors_do_not_lead_away_from_a_singular_place() {
    let nominal = fivebar();
    for degrees in [[0.1, 0.0], [0.0, 0.1], [-0.05, 0.2]] {
        let actual = nominal.with_errors(&nominal.assembly_errors(&degrees));
        for force in [0.0, 10.0] {
            let status = |y: f64| {
                let mut session = Session::new(&nominal, &actual, compensation::CompensationSettings::default());
                let pose = nominal.pose_at(Vector3::new(0.0, y, 0.0));
                let load = Wrench::new([force, -force, 0.5 * force, 0.0, 0.0, 0.0]);
                let task = TaskPoint::new(pose, load, Target::ToolTip);
                compensate(&mut session, &task, Method::None).status.label().to_string()
            };
            assert_eq!(
                (status(0.0).as_str(), status(20.0).as_str()),
                ("singular", "applied"),
                "{degrees:?}, {force} N"
            );
        }
    }
}

#[test]
fn legs_folded_onto_themselves_are_a_singular_place_under_any_load() {
    let machine = Machine::named_or_file("tripteron").unwrap();
    let loads = [
        [0.0; 6],
        [10.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1000.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 1000.0],
    ];
    for z in [100.0, 500.0] {
        for load in loads {
            let (_, outcome) = settled(&machine, [0.0, 0.0, z], Wrench::new(load));
            assert_eq!(outcome.status, Status::SingularPlace, "z = {z}, {load:?}");
            assert!(outcome.status.reason(&machine).starts_with("the place is singular"));
        }
    }
}

#[test]
fn a_hopeless_load_is_given_up_soon() {
    let machine = Machine::named_or_file("orthoglide").unwrap();
    for force in [2e4, 2e5, 2e6, 2e9] {
        for direction in [[1.0, 0.0, 0.0], [-1.0, 0.3, 0.1], [0.5, -0.5, -1.0]] {
            let [x, y, z] = direction.map(|part| part * force);
            let (_, outcome) = settled(&machine, [50.0, 20.0, 10.0], Wrench::new([x, y, z, 0.0, 0.0, 0.0]));
            assert!(outcome.iterations <= 150, "{force} N: {} iterations, {:?}", outcome.iterations, outcome.status);
        }
    }
}
