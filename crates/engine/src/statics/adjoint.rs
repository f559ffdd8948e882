//! The transposed linear system of an equilibrium: what each residual of the machine does to the pose of its platform.
//!
//! At an equilibrium, unknowns z (each chain's dθ, −dF̂, dq, loops included) and the twist dt of the platform obey
//!
//! ```text
//! S z − E dt = −r          S symmetric, E: dt in the closure rows
//! −Eᵀ z + P dt = w         P: weight, bent tool, −½ [m]×
//! ```
//!
//! With the answer (ζ, τ) of the transposed system to a unit wrench `w = e_j`, residuals r and an imbalance w move the platform by
//! `dt_j = τ·w − ζ·r`: six answers serve every parameter.

use nalgebra::Vector6;

use super::{
    chain_system::ChainSystem,
    full_system,
    lane_solver::LaneSolver,
    platform,
    state::{State, Workspace},
    tool, weight,
};
use crate::{lanes::solve, machine::Machine, spatial::Wrench};

/// Answer of the transposed system to a unit wrench on the platform.
#[derive(Debug, Clone)]
pub(super) struct Adjoint {
    /// ζ of each chain, in the order of its unknowns.
    pub chains: Vec<Vec<f64>>,
    /// τ.
    pub twist: Vector6<f64>,
}

impl Adjoint {
    /// Motion of the platform along its direction by `imbalance`, N and N·mm.
    pub fn by_imbalance(&self, imbalance: &Vector6<f64>) -> f64 {
        self.twist.dot(imbalance)
    }

    /// The same by the residual of the chain of this number, as `system` has been filled with it.
    pub fn by_residual(&self, number: usize, system: &ChainSystem, residual: &[f64]) -> f64 {
        let moment = system.closure_moment().0;
        let by_moment: f64 = (0..3).map(|i| moment[i] * self.twist[3 + i]).sum();
        let by_rest: f64 = self.chains[number].iter().zip(residual).map(|(part, rest)| part * rest).sum();
        -by_moment - by_rest
    }
}

/// Answers for the six directions of the platform's body (along, then about the axes of O) at the equilibrium `state` of `machine`
/// under `load`; `None` where the platform is free.
pub(super) fn adjoints(
    machine: &Machine,
    drives: &[f64],
    state: &State,
    load: &Wrench,
    workspace: &mut Workspace,
) -> Option<Vec<Adjoint>> {
    if workspace.linearise(machine, drives, state, load)
        && let Some(adjoints) = condensed(machine, &mut workspace.solver)
    {
        return Some(adjoints);
    }
    workspace.fill(machine, &machine.gravity, 0.0, false);
    let mut own = platform::rows(&weight::stiffness(machine, &state.platform().rotation, &machine.gravity));
    tool::add_stiffness(machine, state.platform(), load, &mut own);
    let adjoints = full_system::transposed(&workspace.solver.systems, &platform::matrix(&own))?;
    let is_finite = |adjoint: &Adjoint| adjoint.twist.iter().all(|entry| entry.is_finite());
    adjoints.iter().all(is_finite).then_some(adjoints)
}

/// The same of condensed chains; `None` where the transposed system is not regular.
fn condensed(machine: &Machine, solver: &mut LaneSolver) -> Option<Vec<Adjoint>> {
    let LaneSolver { systems: chains, rigid, tangent, .. } = solver;
    let transposed = platform::rows(&platform::matrix(tangent).transpose());
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
            let (own, others) = slacks.split_at(system.slack_count());
            system.substitute(0.0, &twist, &vec![0.0; chain.drives.len()], Some(own));
            unknowns.push(system.unknowns());
            slacks = others;
        }
        adjoints.push(Adjoint { chains: unknowns, twist: twist.into() });
    }
    Some(adjoints)
}
