//! Every outcome is labelled: no NaN without a status, no panic, no equilibrium that is none.

use crate::support::cases::cases;
use crate::support::engine::*;
use kinetostat::{
    machine::Machine,
    spatial::{Pose, Wrench},
    statics::{Scratch, State, Status, wrench_at_pose},
};
use nalgebra::Vector3;
use proptest::prelude::*;

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

fn is_finite(state: &State) -> bool {
    let pose = state.pose.translation.iter().chain(state.pose.rotation.iter());
    let chains = state.chains.iter().flat_map(|c| c.coordinates.iter().copied().chain(c.wrench.to_array()));
    pose.copied().chain(chains).all(f64::is_finite)
}

#[test]
fn a_load_that_is_no_number_is_not_solved() {
    for (name, ..) in CATALOGUE {
        let machine = catalogue_machine(name);
        for (component, bad) in (0..6).flat_map(|i| BAD.map(|bad| (i, bad))) {
            let mut load = [10.0; 6];
            load[component] = bad;
            let (state, outcome) = settle(&machine, &machine.home, &Wrench::new(load));
            assert!(!outcome.is_equilibrium(), "{name}: load {load:?} ends {:?}", outcome.status);
            assert!(is_finite(&state), "{name}: load {load:?} leaves {state:?}");
        }
    }
}

#[test]
fn drives_that_are_no_numbers_are_not_solved() {
    for (name, ..) in CATALOGUE {
        let machine = catalogue_machine(name);
        for (drive, bad) in (0..3).flat_map(|i| BAD.map(|bad| (i, bad))) {
            let mut drives = machine.home.drives.clone();
            drives[drive] = bad;
            let mut state = State::rigid(&machine, &machine.home);
            let outcome = resettle(&machine, &drives, &Wrench::zero(), &mut state);
            assert!(!outcome.is_equilibrium(), "{name}: drives {drives:?} end {:?}", outcome.status);
            assert!(is_finite(&state), "{name}: drives {drives:?} leave {state:?}");
        }
    }
}

#[test]
fn a_target_that_is_no_number_is_not_reached() {
    for (name, ..) in CATALOGUE {
        let machine = catalogue_machine(name);
        for bad in BAD {
            let target = machine.pose_at(Vector3::new(0.0, bad, 0.0));
            assert!(machine.inverse_kinematics(&target).is_err(), "{name}: reached y = {bad}");
            assert!(machine.forward_kinematics(&[0.0, bad, 0.0]).is_err(), "{name}: drive at {bad}");
        }
    }
}

#[test]
fn a_wrench_is_not_found_for_a_pose_that_is_no_number() {
    let machine = catalogue_machine("orthoglide");
    for bad in BAD {
        let mut state = State::rigid(&machine, &machine.home);
        let pose = Pose::from_translation(Vector3::new(bad, 0.0, 0.0));
        let mut scratch = Scratch::new(&machine);
        let force = wrench_at_pose(&machine, &machine.home.drives, &pose, &mut state, &mut scratch, &EXACT);
        assert!(force.is_none(), "x = {bad}: {force:?}");
    }
}

fn balances(machine: &Machine, state: &State, load: &Wrench) -> bool {
    let sum: nalgebra::Vector6<f64> = state.chains.iter().map(|c| c.wrench.to_vector()).sum();
    let largest = state
        .chains
        .iter()
        .map(|c| c.wrench.norm(machine.characteristic_length))
        .fold(load.norm(machine.characteristic_length), f64::max);
    Wrench::from_vector(&(sum - load.to_vector())).norm(machine.characteristic_length) < 1e-7 * largest.max(1.0)
}

proptest! {
    #![proptest_config(cases(6))]

    #[test]
    fn absurd_loads_and_errors_end_with_a_label(
        parts in prop::array::uniform6(-1.0..1.0f64), decades in 2.0..12.0f64, degrees in prop::array::uniform3(-180.0..180.0f64),
    ) {
        for (name, ..) in CATALOGUE {
            let nominal = catalogue_machine(name);
            let machine = with_assembly_errors(&nominal, degrees);
            let load = wrench_from(10f64.powf(decades), 10f64.powf(decades), parts);
            let (state, outcome) = settle(&machine, &nominal.home, &load);
            prop_assert!(is_finite(&state), "{name}: {:?} with {state:?}", outcome.status);
            match outcome.status {
                Status::NotConverged { load_fraction } | Status::SnapThrough { load_fraction } => {
                    prop_assert!((0.0..1.0).contains(&load_fraction), "{name}: fraction {load_fraction}");
                }
                Status::SingularPlace => {}
                ref status => prop_assert!(balances(&machine, &state, &load), "{name}: {status:?} but Σ wrenches is not the load"),
            }
            if outcome.status == Status::Solved {
                let stiffness = outcome.stiffness.unwrap();
                prop_assert!(((stiffness + stiffness.transpose()) * 0.5).cholesky().is_some(), "{name}: solved, not definite");
            }
        }
    }
}
