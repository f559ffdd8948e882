//! Linear aggregation of chain errors, eqs. (14) and (15): the comparator to the nonlinear model.

use nalgebra::{Matrix6, Vector6};

use crate::{
    machine::{Configuration, Machine, MoveScrew},
    spatial::{Pose, Twist, rotation_log},
    statics::{State, Workspace, chain_stiffnesses},
};

/// Shift ε_i of each chain's end that chain errors cause in the configuration `at` with all joints held: the difference
/// between the ends of the `real` and of the `nominal` machine's chains, at P in O axes (mm, rad).
fn end_shifts(nominal: &Machine, real: &Machine, at: &Configuration) -> Vec<Twist> {
    let mut first_drive = 0;
    let mut screws: Vec<MoveScrew> = Vec::new();
    let mut shifts = Vec::new();
    for ((ideal, actual), passive) in nominal.chains.iter().zip(&real.chains).zip(&at.passive) {
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

/// Platform displacement by assembling non-perfect chains, to first order: `Δt_ε = (Σ K_i)⁻¹ Σ K_i ε_i`, eq. (15), with
/// unloaded chain stiffnesses at `at`. A twist of P in O axes (mm, rad).
///
/// Chain `i` then works about the target shifted by `Δt_ε − ε_i`, eq. (14). `None` where a chain has no 6×6 stiffness or
/// the machine is singular.
pub fn aggregate_errors(
    nominal: &Machine,
    real: &Machine,
    at: &Configuration,
    workspace: &mut Workspace,
) -> Option<Twist> {
    let stiffnesses = chain_stiffnesses(nominal, &at.drives, &State::rigid(nominal, at), workspace);
    let mut sum = Matrix6::zeros();
    let mut forced = Vector6::zeros();
    for (stiffness, shift) in stiffnesses.into_iter().zip(end_shifts(nominal, real, at)) {
        let stiffness = stiffness?;
        sum += stiffness;
        forced += stiffness * shift.to_vector();
    }
    Some(Twist::from_vector(&sum.lu().solve(&forced)?))
}
