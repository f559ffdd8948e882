//! Forces of the drives, and how they change when drives move.

use nalgebra::{DMatrix, Matrix6xX, Vector6};

use super::{
    full_system,
    lane_solver::LaneSolver,
    platform,
    state::{Scratch, State},
    weight,
};
use crate::{
    machine::{Chain, Machine},
    spatial::Wrench,
};

/// Forces that all drives carry, in machine order, `τ = k_act θ_a`, N or N·mm: positive where the load pushes the drive the way its shown position
/// grows. That of a drive that shows several joints is the force of its own joint.
pub fn drive_forces(machine: &Machine, state: &State) -> Vec<f64> {
    let chains = machine.chains.iter().zip(&state.chains);
    chains.flat_map(|(chain, state)| chain_drive_forces(chain, &state.coordinates)).collect()
}

/// Forces of the drives of one chain at its `coordinates` (mm, rad), N or N·mm, signed as by [`drive_forces`].
pub(super) fn chain_drive_forces<'a>(chain: &'a Chain, coordinates: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    let each = chain.drives.iter().enumerate();
    each.map(|(i, drive)| chain.shown_sign(i) * drive.stiffness * coordinates[drive.coordinate])
}

/// `∂τ/∂ρ` under constant load: change of the drives' forces (rows, machine order) per unit motion of each drive (columns), N or N·mm per mm or
/// rad. `τ` as [`drive_forces`] has it. Back-substitution into the condensed chains, from the platform twists `∂t/∂ρ`, gives the motion of
/// the joints `∂(ρ + θ_a)/∂ρ`, and so `∂θ_a/∂ρ`. `state` must be an equilibrium of `machine` with the drives at `drives` (mm, rad), and
/// `twists` its [`Outcome::drive_sensitivity`](super::Outcome::drive_sensitivity). `None` where the platform is not held.
pub fn drive_force_sensitivity(
    machine: &Machine,
    drives: &[f64],
    state: &State,
    twists: &Matrix6xX<f64>,
    scratch: &mut Scratch,
) -> Option<DMatrix<f64>> {
    let mut deflections = match condensed_deflections(machine, drives, state, twists, scratch) {
        Some(deflections) => deflections,
        None => {
            let weight = weight::stiffness(machine, &state.platform().rotation, &machine.gravity);
            full_system::tangent(&machine.chains, &scratch.solver.systems, &weight).joint_deflection?
        }
    };
    let own = machine.chains.iter().flat_map(|chain| (0..chain.drives.len()).map(move |drive| (chain, drive)));
    for (i, (chain, drive)) in own.enumerate() {
        deflections.row_mut(i).scale_mut(chain.shown_sign(drive) * chain.drives[drive].stiffness);
    }
    Some(deflections)
}

/// Deflection of each actuated joint (rows) per unit motion of each drive (columns), `∂θ_a/∂ρ`; `None` if a chain cannot be condensed.
fn condensed_deflections(
    machine: &Machine,
    drives: &[f64],
    state: &State,
    twists: &Matrix6xX<f64>,
    scratch: &mut Scratch,
) -> Option<DMatrix<f64>> {
    if !scratch.linearise(machine, drives, state, &Wrench::zero()) {
        return None;
    }
    let LaneSolver { systems: chains, rigid, drive_wrenches, tangent, .. } = &mut scratch.solver;
    if !rigid.is_empty() {
        platform::drive_wrenches(chains, drive_wrenches);
        rigid.drive_twists(chains, tangent, drive_wrenches);
    }
    let mut deflections = DMatrix::zeros(drives.len(), drives.len());
    let mut drive_motion = Vec::new();
    let (mut first, mut first_slack) = (0, 0);
    for (system, chain) in chains.iter_mut().zip(&machine.chains) {
        let own_count = chain.drives.len();
        for (column, twist) in twists.column_iter().enumerate() {
            drive_motion.clear();
            drive_motion.extend((first..first + own_count).map(|drive| if drive == column { 1.0 } else { 0.0 }));
            let slacks = &rigid.drive_slacks(column)[first_slack..][..system.slack_count()];
            system.substitute(0.0, &Vector6::from(twist).into(), &drive_motion, Some(slacks));
            for (own, drive) in chain.drives.iter().enumerate() {
                let by_drive = match column.checked_sub(first) {
                    Some(moved) if moved < own_count => chain.joint_per_drive(own, moved),
                    _ => 0.0,
                };
                deflections[(first + own, column)] = system.coordinate_step(drive.coordinate) - by_drive;
            }
        }
        first += own_count;
        first_slack += system.slack_count();
    }
    Some(deflections)
}
