//! The force–deflection relation `F = f(t | t₀)`, eqs. (2) and (3).

use nalgebra::{Matrix6, Matrix6xX, Vector6};

use super::{
    outcome::Settings,
    platform::subtract_half_moment,
    state::{Scratch, State},
    tool, weight,
};
use crate::{
    lanes::{Frame, Vec3},
    machine::Machine,
    spatial::{Pose, Wrench, larger},
};

/// Wrench that holds the platform at a pose, and its derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct PlatformForce {
    /// `F = Σ f_i(t | t₀)` at P in O axes, eq. (3).
    pub wrench: Wrench,
    /// `∂F/∂t` = K_C, eq. (6).
    pub stiffness: Matrix6<f64>,
    /// `∂f/∂ρ`: wrench per unit motion of each drive, the platform held, one column per drive.
    pub drive_wrench: Matrix6xX<f64>,
    /// Largest number of iterations a chain needed.
    pub iterations: usize,
}

/// Wrench `F = f(t | t₀)` that holds P at `pose` while the drives are at `drives` (mm, rad).
///
/// Each chain's equilibrium, eq. (1), is solved with its end on `pose`. `state` holds the starting values (for instance the
/// rigid configuration of t₀) and receives the solution. `None` if a chain has no stable equilibrium near the start.
pub fn wrench_at_pose(
    machine: &Machine,
    drives: &[f64],
    pose: &Pose,
    state: &mut State,
    scratch: &mut Scratch,
    settings: &Settings,
) -> Option<PlatformForce> {
    if machine.tool_compliance.is_none() {
        return wrench_on_body(machine, drives, pose, state, scratch, settings);
    }
    // The tool carries what is sought, so it bends by it: Newton's method on the wrench.
    let mut wrench = Wrench::zero();
    let mut last = f64::INFINITY;
    for _ in 0..settings.max_iterations {
        let (body, compliance) = tool::body_and_compliance(machine, pose, &wrench);
        let mut force = wrench_on_body(machine, drives, &body, state, scratch, settings)?;
        let received = tool::load_on_body(machine, &body, &wrench);
        let imbalance = force.wrench.to_vector() - received.to_vector();
        let in_series = (Matrix6::identity() + force.stiffness * compliance).try_inverse()?;
        let change = in_series * imbalance;
        wrench = Wrench::from_vector(&(wrench.to_vector() + change));
        if !wrench.norm(machine.characteristic_length).is_finite() {
            return None;
        }
        let changed = Wrench::from_vector(&change).norm(machine.characteristic_length);
        let is_converged = changed <= settings.tolerance * wrench.norm(machine.characteristic_length).max(1.0);
        // The wrench of a stiff machine is known to rounding of its pose: it is found where it no longer comes nearer.
        let is_rounding = changed >= 0.5 * last
            && is_negligible(&force.stiffness, &imbalance, machine.characteristic_length, settings.tolerance);
        last = changed;
        if is_converged || is_rounding {
            (state.pose, state.body) = (*pose, Some(body));
            force.stiffness = in_series * force.stiffness;
            force.drive_wrench = in_series * force.drive_wrench;
            return Some(PlatformForce { wrench, ..force });
        }
    }
    None
}

/// Whether a displacement below `tolerance` times the characteristic length `scale` (mm) makes up for the `imbalance` (N, N·mm).
fn is_negligible(stiffness: &Matrix6<f64>, imbalance: &Vector6<f64>, scale: f64, tolerance: f64) -> bool {
    let Some(twist) = stiffness.lu().solve(imbalance) else { return false };
    twist.fixed_rows::<3>(0).amax().max(twist.fixed_rows::<3>(3).amax() * scale) <= tolerance * scale
}

/// Wrench that holds the platform's body at `pose`, without bending of the tool; arguments, result and `None` as of [`wrench_at_pose`].
fn wrench_on_body(
    machine: &Machine,
    drives: &[f64],
    pose: &Pose,
    state: &mut State,
    scratch: &mut Scratch,
    settings: &Settings,
) -> Option<PlatformForce> {
    (state.pose, state.body) = (*pose, None);
    let weight: Wrench = weight::wrench(machine, &Frame::splat(pose), Vec3::splat(&machine.gravity)).into();
    let mut force = PlatformForce {
        wrench: Wrench { force: -weight.force, moment: -weight.moment },
        stiffness: weight::stiffness(machine, &pose.rotation, &machine.gravity),
        drive_wrench: Matrix6xX::zeros(drives.len()),
        iterations: 0,
    };
    let mut first_drive = 0;
    for ((system, chain), chain_state) in scratch.solver.systems.iter_mut().zip(&machine.chains).zip(&mut state.chains)
    {
        let own_drives = &drives[first_drive..first_drive + chain.drives.len()];
        let drive_columns = first_drive..first_drive + chain.drives.len();
        first_drive = drive_columns.end;
        let mut iterations = 0;
        let stiffness = loop {
            system.linearise(chain, own_drives, chain_state, pose, &machine.gravity);
            let residual = system.residual(machine.characteristic_length);
            let scale = chain_state.wrench.norm(machine.characteristic_length).max(1.0);
            let error = larger(residual.gap / machine.characteristic_length, residual.force / scale);
            let stiffness = system.condense()?;
            if error <= settings.tolerance {
                break stiffness;
            }
            if iterations == settings.max_iterations || !error.is_finite() {
                return None;
            }
            let held = Vector6::zeros();
            system.substitute(1.0, &held.into(), &[], None);
            system.apply(&held, chain_state);
            iterations += 1;
        };
        for (own, column) in drive_columns.enumerate() {
            force.drive_wrench.set_column(column, &system.drive_wrench(own).into());
        }
        force.iterations = force.iterations.max(iterations);
        force.stiffness += stiffness;
        subtract_half_moment(&mut force.stiffness, chain_state.wrench);
        force.wrench.force += chain_state.wrench.force;
        force.wrench.moment += chain_state.wrench.moment;
    }
    Some(force)
}
