//! Newton converges quadratically; load stepping reaches what a full step does not.

use crate::support::engine::*;
use kinetostat::{
    machine::{Configuration, Machine},
    spatial::Wrench,
    statics::{Scratch, Settings, State, Status, equilibrium},
};
use nalgebra::Vector3;

/// Residual after each iteration of a solve from the rigid state, by asking for ever smaller ones.
fn residual_history(machine: &Machine, at: &Configuration, load: &Wrench) -> Vec<f64> {
    let mut history: Vec<(usize, f64)> = Vec::new();
    for quarter_decades in 0..=56 {
        let tolerance = 10f64.powf(-0.25 * f64::from(quarter_decades));
        let mut state = State::rigid(machine, at);
        let settings = Settings { tolerance, max_iterations: 20 };
        let outcome = equilibrium(machine, &at.drives, load, &mut state, &mut Scratch::new(machine), &settings);
        assert!(outcome.is_equilibrium(), "tolerance {tolerance:e}: {:?}", outcome.status);
        assert_eq!(outcome.load_steps, 1, "tolerance {tolerance:e}");
        if history.last().is_none_or(|last| last.0 < outcome.iterations) {
            history.push((outcome.iterations, outcome.residual));
        }
    }
    history.into_iter().map(|(_, residual)| residual).collect()
}

#[test]
fn newton_converges_quadratically() {
    for (name, position) in [("orthoglide", [126.35, 126.35, -73.65]), ("tripteron", [300.0, 600.0, 700.0])] {
        let nominal = catalogue_machine(name);
        let at = at_position(&nominal, Vector3::from(position));
        let machine = with_assembly_errors(&nominal, [3.0, -3.0, 3.0]);
        let history = residual_history(&machine, &at, &Wrench::new([3000.0, -2000.0, 1000.0, 2e5, 1e5, -1e5]));
        // Pairs in the quadratic range: small enough to be near the solution, large enough to be above rounding.
        let pairs: Vec<[f64; 2]> =
            history.windows(2).map(|w| [w[0], w[1]]).filter(|w| w[0] < 0.3 && w[0] > 1e-7).collect();
        assert!(pairs.len() >= 2, "{name}: {history:?}");
        for [before, after] in pairs {
            assert!(
                after < 100.0 * before * before + 1e-13,
                "{name}: {before:e} is followed by {after:e} in {history:?}"
            );
        }
    }
}

#[test]
fn a_converged_state_is_not_iterated_again() {
    for (name, ..) in CATALOGUE {
        let machine = catalogue_machine(name);
        let load = Wrench::new([100.0, 50.0, -30.0, 1e3, 0.0, 0.0]);
        let mut state = State::rigid(&machine, &machine.home);
        let mut scratch = Scratch::new(&machine);
        let settings = Settings::default();
        let first = equilibrium(&machine, &machine.home.drives, &load, &mut state, &mut scratch, &settings);
        let again = equilibrium(&machine, &machine.home.drives, &load, &mut state, &mut scratch, &settings);
        assert!(
            first.iterations > 0 && again.iterations == 0,
            "{name}: {} then {}",
            first.iterations,
            again.iterations
        );
    }
}

/// The same load in `steps` equal parts, each continued from the one before.
fn warm_started(machine: &Machine, at: &Configuration, load: &Wrench, steps: usize) -> (State, Status) {
    let mut state = State::rigid(machine, at);
    for step in 1..=steps {
        let outcome = resettle(machine, &at.drives, &load.scale(step as f64 / steps as f64), &mut state);
        if !outcome.is_equilibrium() {
            return (state, outcome.status);
        }
    }
    let outcome = resettle(machine, &at.drives, load, &mut state);
    (state, outcome.status)
}

/// Solves at once and in `steps` warm-started parts; the load steps the engine needed.
fn load_steps_to_the_same_state(machine: &Machine, load: &Wrench, steps: usize) -> usize {
    let at = machine.home.clone();
    let (expected, status) = warm_started(machine, &at, load, steps);
    assert_eq!(status, Status::Solved, "{} under {load:?} in {steps} parts", machine.name);
    let (state, outcome) = settle(machine, &at, load);
    assert_eq!(outcome.status, Status::Solved, "{} under {load:?} at once", machine.name);
    let off = motion_between(&expected.pose, &state.pose).amax();
    assert!(
        off < 1e-7,
        "{} under {load:?}: off the finely stepped solution by {off:e} after {} load steps",
        machine.name,
        outcome.load_steps
    );
    outcome.load_steps
}

#[test]
fn load_stepping_reaches_what_a_full_step_does_not() {
    let machine = catalogue_machine("tripteron");
    let steps = [1e5, 4e5, 1e6]
        .map(|f| load_steps_to_the_same_state(&machine, &Wrench::new([f, 0.0, 0.0, 0.0, 0.0, 0.0]), 300));
    assert_eq!(steps[0], 1, "a load the full step can take");
    assert!(steps[1] > 1 && steps[2] > steps[1], "loads that need load steps: {steps:?}");
}

#[test]
fn load_stepping_brings_on_chain_errors_too() {
    for (name, degrees) in [("tripteron", 20.0), ("tripteron", 30.0), ("orthoglide", 45.0), ("orthoglide", 60.0)] {
        let nominal = catalogue_machine(name);
        let errors = |share: f64| [1.0, -1.0, 1.0].map(|sign: f64| turned_chain(sign * share * degrees));
        let mut expected = State::rigid(&nominal, &nominal.home);
        for part in 1..=100 {
            let actual = nominal.with_errors(&errors(f64::from(part) / 100.0));
            let outcome = resettle(&actual, &nominal.home.drives, &Wrench::zero(), &mut expected);
            assert_eq!(outcome.status, Status::Solved, "{name}, {part} % of {degrees}°");
        }
        let (state, outcome) = settle(&nominal.with_errors(&errors(1.0)), &nominal.home, &Wrench::zero());
        assert_eq!(outcome.status, Status::Solved, "{name}, {degrees}° at once");
        assert!(outcome.load_steps > 1, "{name}, {degrees}° was taken in one step");
        let off = motion_between(&expected.pose, &state.pose).amax();
        assert!(off < 1e-8, "{name}, {degrees}°: off the finely stepped solution by {off:e}");
    }
}

#[test]
fn a_failed_solve_leaves_the_state_alone() {
    let machine = catalogue_machine("orthoglide");
    let mut state = State::rigid(&machine, &machine.home);
    let before = state.clone();
    let load = Wrench::new([1e12, -1e12, 1e12, 0.0, 0.0, 0.0]);
    let outcome = resettle(&machine, &machine.home.drives, &load, &mut state);
    let Status::NotConverged { load_fraction } = outcome.status else { panic!("{:?}", outcome.status) };
    assert!((0.0..1.0).contains(&load_fraction), "fraction {load_fraction}");
    assert_eq!(state, before, "state after a failed solve");
}

#[test]
fn a_limit_point_is_not_jumped_over() {
    let machine = catalogue_machine("tripteron");
    let load = Wrench::new([-1e6, -1e6, -1e6, 0.0, 0.0, 0.0]);
    let (_, status) = warm_started(&machine, &machine.home, &load, 300);
    assert!(!status.is_equilibrium(), "small parts of the load stop at the limit point: {status:?}");
    let (_, outcome) = settle(&machine, &machine.home, &load);
    let Status::SnapThrough { load_fraction } = outcome.status else {
        panic!("{:?} beyond the limit point", outcome.status)
    };
    assert!((0.78..0.79).contains(&load_fraction), "carries {load_fraction} of the load");
}
