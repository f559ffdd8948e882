//! Adjoint system of an equilibrium: sensitivity of the platform pose to each residual of the machine.
//!
//! At an equilibrium, unknowns z (each chain's dθ, −dF̂, dq, loops included) and the twist dt of the platform obey
//!
//! ```text
//! S z − E dt = −r          S symmetric, E: dt in the closure rows
//! −Eᵀ z + P dt = w         P: weight, deflected tool, −½ [m]×
//! ```
//!
//! With the solution (ζ, τ) of the transposed system for a unit wrench `w = e_j`, residuals r and an imbalance w move the platform by
//! `dt_j = τ·w − ζ·r`: six solutions serve every parameter.

use nalgebra::Vector6;

use super::{
    chain_system::ChainSystem,
    full_system,
    lane_solver::LaneSolver,
    platform,
    state::{Scratch, State},
    tool, weight,
};
use crate::{lanes::solve, machine::Machine, spatial::Wrench};

/// Solution of the transposed system for a unit wrench along or about one axis of O on the platform.
#[derive(Debug, Clone)]
pub(super) struct Adjoint {
    /// ζ of each chain, in the order of the chain's unknowns.
    pub chains: Vec<Vec<f64>>,
    /// τ, the part of the platform.
    pub twist: Vector6<f64>,
}

impl Adjoint {
    /// Motion of the platform (mm or rad) in the direction of the unit wrench, caused by `imbalance` (N, N·mm).
    pub fn motion_by_wrench(&self, imbalance: &Vector6<f64>) -> f64 {
        self.twist.dot(imbalance)
    }

    /// Motion of the platform (mm or rad) in the direction of the unit wrench, caused by the `residual` that chain `number` has in `system`.
    pub fn motion_by_residual(&self, number: usize, system: &ChainSystem, residual: &[f64]) -> f64 {
        let moment = system.closure_moment().0;
        let by_moment: f64 = (0..3).map(|i| moment[i] * self.twist[3 + i]).sum();
        let by_rest: f64 = self.chains[number].iter().zip(residual).map(|(part, rest)| part * rest).sum();
        -by_moment - by_rest
    }
}

/// Solves the transposed system for unit wrenches along, then about the axes of O at the equilibrium `state` of `machine` under `load` with
/// the drives at `drives` (mm, rad). `None` where the platform is free.
pub(super) fn adjoints(
    machine: &Machine,
    drives: &[f64],
    state: &State,
    load: &Wrench,
    scratch: &mut Scratch,
) -> Option<Vec<Adjoint>> {
    if scratch.linearise(machine, drives, state, load)
        && let Some(adjoints) = condensed_adjoints(machine, &mut scratch.solver)
    {
        return Some(adjoints);
    }
    scratch.fill(machine, &machine.gravity, 0.0, false);
    let mut stiffness = platform::to_rows(&weight::stiffness(machine, &state.platform().rotation, &machine.gravity));
    tool::add_stiffness(machine, state.platform(), load, &mut stiffness);
    let adjoints = full_system::adjoints(&scratch.solver.systems, &platform::to_matrix(&stiffness))?;
    let is_finite = |adjoint: &Adjoint| adjoint.twist.iter().all(|entry| entry.is_finite());
    adjoints.iter().all(is_finite).then_some(adjoints)
}

/// Adjoints from condensed chains; `None` where the transposed system is singular.
fn condensed_adjoints(machine: &Machine, solver: &mut LaneSolver) -> Option<Vec<Adjoint>> {
    let LaneSolver { systems: chains, rigid, tangent, .. } = solver;
    let transposed = platform::to_rows(&platform::to_matrix(tangent).transpose());
    if rigid.factorise(chains, &transposed, machine.characteristic_length) == 0 {
        return None;
    }
    let mut adjoints = Vec::with_capacity(6);
    for direction in 0..6 {
        let mut twist = [[0.0; 6]];
        twist[0][direction] = 1.0;
        if solve(transposed, 6, &mut twist) == 0 {
            return None;
        }
        let [mut twist] = twist;
        rigid.correct_response(&mut twist);
        let mut slacks = rigid.slacks();
        let mut unknowns = Vec::with_capacity(chains.len());
        for (system, chain) in chains.iter_mut().zip(&machine.chains) {
            let (chain_slacks, others) = slacks.split_at(system.slack_count());
            system.substitute(0.0, &twist, &vec![0.0; chain.drives.len()], Some(chain_slacks));
            unknowns.push(system.unknowns());
            slacks = others;
        }
        adjoints.push(Adjoint { chains: unknowns, twist: twist.into() });
    }
    Some(adjoints)
}
