//! Solution of an equilibrium in physical terms: wrenches, deflections, drive forces, stiffness, stability.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use serde::Serialize;

use super::{
    drive_force::chain_drive_forces,
    outcome::{Outcome, Status},
    play::tool_play,
    state::{Scratch, State},
    stiffness::{chain_stiffnesses, principal_stiffnesses, tool_compliance},
};
use crate::{
    machine::Machine,
    spatial::{Pose, Wrench},
};

/// Wrenches, deflections and drive forces of one chain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainSolution {
    /// Wrench the chain receives from the platform, at P in O axes.
    pub wrench: Wrench,
    /// The part of `wrench` that balances itself among the chains: what is left after the stiffness-weighted share
    /// `K_i K_C⁻¹ F` of the applied wrench. `None` where a chain has no 6×6 stiffness.
    pub internal_wrench: Option<Wrench>,
    /// Virtual joint deflections θ, mm and rad, from base to platform.
    pub deflections: Vec<f64>,
    /// Passive joint coordinates q, mm and rad.
    pub passive: Vec<f64>,
    /// Forces τ = k_act θ_a of the chain's drives, N or N·mm, see [`drive_forces`](super::drive_forces).
    pub drive_forces: Vec<f64>,
}

/// A solved machine state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Solution {
    /// How the solve ended.
    pub status: Status,
    /// Newton iterations.
    pub iterations: usize,
    /// Residual, see [`super::Settings::tolerance`].
    pub residual: f64,
    /// Pose of P in O.
    pub pose: Pose,
    /// Solution of each chain, in machine order.
    pub chains: Vec<ChainSolution>,
    /// Loaded stiffness K_C of eq. (6), at P in O axes (N, N·mm; mm, rad).
    pub stiffness: Option<Matrix6<f64>>,
    /// Its inverse: twist of P per applied wrench.
    pub compliance: Option<Matrix6<f64>>,
    /// Half the interval in which backlash and friction of the drives let the tool tip stand, along the axes of O, mm; `None` without any.
    pub tool_play: Option<Vector3<f64>>,
    /// Smallest eigenvalue in N/mm of the condensed tangent, rotations weighted by the machine's characteristic length; negative where the
    /// machine is unstable. See [`Outcome::least_stiffness`]; not a stiffness of the tool tip, which is [`Solution::tool_stiffnesses`].
    pub stability: Option<f64>,
}

impl Solution {
    /// Describes `state`, which solves `machine` with drives at `drives`, as `outcome` reports.
    pub fn new(machine: &Machine, drives: &[f64], state: &State, outcome: &Outcome, scratch: &mut Scratch) -> Self {
        let stiffnesses = chain_stiffnesses(machine, drives, state, scratch);
        let total: Option<Matrix6<f64>> = stiffnesses.iter().copied().sum();
        let carried: Vector6<f64> = state.chains.iter().map(|chain_state| chain_state.wrench.to_vector()).sum();
        let twist = total.and_then(|total| total.lu().solve(&carried));
        let chains =
            machine.chains.iter().zip(&state.chains).zip(stiffnesses).map(|((chain, chain_state), stiffness)| {
                let share = stiffness.zip(twist).map(|(stiffness, twist)| stiffness * twist);
                ChainSolution {
                    wrench: chain_state.wrench,
                    internal_wrench: share.map(|share| Wrench::from_vector(&(chain_state.wrench.to_vector() - share))),
                    deflections: chain_state.coordinates[..chain.virtual_count].to_vec(),
                    passive: chain_state.coordinates[chain.virtual_count..].to_vec(),
                    drive_forces: chain_drive_forces(chain, &chain_state.coordinates).collect(),
                }
            });
        Self {
            status: outcome.status.clone(),
            iterations: outcome.iterations,
            residual: outcome.residual,
            pose: state.pose,
            chains: chains.collect(),
            stiffness: outcome.stiffness,
            compliance: outcome.compliance,
            tool_play: tool_play(machine, &state.pose, &outcome.drive_sensitivity),
            stability: outcome.least_stiffness(machine.characteristic_length),
        }
    }

    /// Principal stiffnesses of the tool tip, ascending, N/mm: the inverse eigenvalues of its compliance and that of the workpiece (`carried`:
    /// displacement in O per force where the tool touches it, mm/N; zero where it is fixed). `None` where the platform is free or not solved.
    pub fn tool_stiffnesses(&self, machine: &Machine, carried: &Matrix3<f64>) -> Option<[f64; 3]> {
        let lever = self.pose.rotation * machine.tool_tip;
        self.compliance.map(|compliance| principal_stiffnesses(&(tool_compliance(&compliance, lever) + carried)))
    }

    /// Forces of all drives in machine order, N or N·mm.
    pub fn drive_forces(&self) -> Vec<f64> {
        self.chains.iter().flat_map(|chain| chain.drive_forces.iter().copied()).collect()
    }
}
