//! Linear aggregation of chain errors, eqs. (14) and (15): the comparator to the nonlinear model.

use nalgebra::{Matrix6, Vector6};

use super::state::chain_inputs;
use crate::{
    machine::{Configuration, Machine, MoveScrew},
    spatial::{Pose, Twist, rotation_log},
    statics::{Scratch, State, chain_stiffnesses},
};

/// Shift ε_i of each chain's end that chain errors cause in the configuration `at` with all joints held: the difference
/// between the ends of the `actual` and of the `nominal` machine's chains, at P in O axes (mm, rad).
fn end_shifts(nominal: &Machine, actual: &Machine, at: &Configuration) -> Vec<Twist> {
    let mut first_drive = 0;
    let mut screws: Vec<MoveScrew> = Vec::new();
    let mut shifts = Vec::new();
    for ((ideal, actual), passive) in nominal.chains.iter().zip(&actual.chains).zip(&at.passive) {
        let mut values = Vec::new();
        ideal.rigid_values(&at.drives[first_drive..], passive, &mut values);
        first_drive += ideal.drives.len();
        let from: Pose = ideal.forward(&values, &mut screws);
        let to: Pose = actual.forward(&values, &mut screws);
        shifts.push(Twist {
            linear: to.translation - from.translation,
            angular: rotation_log(&(to.rotation * from.rotation.transpose())),
        });
    }
    shifts
}

/// Wrench (N, N·mm, at P in O axes) that holds the end of each chain with loops at `at`, to first order; `None` without loops or stiffness.
fn held_wrenches(machine: &Machine, at: &Configuration, scratch: &mut Scratch) -> Vec<Option<Vector6<f64>>> {
    let state = State::rigid(machine, at);
    let inputs = chain_inputs(machine, &state, &at.drives);
    let systems = scratch.solver.systems.iter_mut().zip(&machine.chains).zip(inputs);
    let wrenches = systems.map(|((system, chain), (chain_state, drives))| {
        if chain.route.loops.is_empty() {
            return None;
        }
        system.linearise(chain, drives, chain_state, &at.pose, &machine.gravity);
        system.condense()?;
        Some(Vector6::from(system.held_wrench()))
    });
    wrenches.collect()
}

/// Platform displacement by assembling non-perfect chains, to first order: `Δt_ε = (Σ K_i)⁻¹ Σ K_i ε_i`, eq. (15), with
/// unloaded chain stiffnesses at `at`. A twist of P in O axes (mm, rad).
/// Chain `i` then works about the target shifted by `Δt_ε − ε_i`, eq. (14). Errors within the loops of a chain shift its end with its joints
/// free: `K_i ε_i` is then what they change of the wrench that holds it. `None` where a chain has no 6×6 stiffness or the machine is singular.
pub fn aggregate_errors(
    nominal: &Machine,
    actual: &Machine,
    at: &Configuration,
    scratch: &mut Scratch,
) -> Option<Twist> {
    let (nominal, actual) = (&nominal.weightless(), &actual.weightless());
    let before = held_wrenches(nominal, at, scratch);
    let after = held_wrenches(actual, at, scratch);
    let stiffnesses = chain_stiffnesses(nominal, &at.drives, &State::rigid(nominal, at), scratch);
    let mut sum = Matrix6::zeros();
    let mut forced = Vector6::zeros();
    for (i, (stiffness, shift)) in stiffnesses.into_iter().zip(end_shifts(nominal, actual, at)).enumerate() {
        let stiffness = stiffness?;
        sum += stiffness;
        forced += match nominal.chains[i].route.loops.is_empty() {
            true => stiffness * shift.to_vector(),
            false => before[i]? - after[i]?,
        };
    }
    Some(Twist::from_vector(&sum.lu().solve(&forced)?))
}
