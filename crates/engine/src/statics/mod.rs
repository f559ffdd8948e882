//! Static equilibrium of the loaded machine, its stiffness and sensitivities.
//!
//! Each chain obeys `∂U/∂θ − J_θᵀF = 0`, `∂U/∂q − J_qᵀF = 0`, `g(ρ; θ, q) = t` (eq. 1, written as a residual with the current stiffness); the
//! platform obeys `Σ F_i = F_ext` (eq. 3). One Newton iteration solves them all: the chains are condensed to 6×6 blocks (eqs. 4–6 with the
//! wrench-weighted Hessians), the platform twist follows, and the chain unknowns are back-substituted.
//!
//! - [`Solver`]: loaded states of one machine, a call each
//! - [`equilibrium()`]: `t = f⁻¹(F | t₀)`, eq. (7), the whole machine under a prescribed wrench
//! - [`equilibrium_at_task`]: the same with the drives found so that a task is met, for compensation
//! - [`Batch`]: the same for many independent cases, several at a time
//! - [`wrench_at_pose`]: `F = f(t | t₀)`, eqs. (2), (3), the wrench that holds the platform at a pose
//! - [`unloaded_stiffness`], [`Outcome::stiffness`]: eqs. (4)–(6)
//! - [`aggregate_errors`]: eqs. (14), (15), the linear comparator
//! - [`drive_forces`], [`drive_force_sensitivity`]: what the drives carry, and how it changes when they move
//! - [`Sensitivities`]: how a pose changes with the machine's parameters
//! - [`Solution`]: everything a solved state tells, in physical terms

mod adjoint;
mod aggregation;
mod batch;
mod bordered;
mod chain_system;
mod drive_force;
mod energy;
mod equilibrium;
mod force_deflection;
mod full_system;
mod held;
mod iteration;
mod lane_solver;
mod outcome;
mod platform;
mod play;
mod rigid_directions;
mod sensitivity;
mod solution;
mod solver;
mod state;
mod stiffness;
mod tool;
mod transmission;
mod weight;

pub use crate::lanes::Level;
pub use aggregation::aggregate_errors;
pub use batch::{Batch, Case, sought_in_batches};
pub use drive_force::{drive_force_sensitivity, drive_forces};
pub use energy::{deformation_energies, elastic_energy, spring_energies, weight_energy};
pub(crate) use equilibrium::is_singular_place;
pub use equilibrium::{equilibrium, equilibrium_at_task};
pub use force_deflection::{PlatformForce, wrench_at_pose};
pub use lane_solver::{LaneSolver, one_step};
pub use outcome::{Outcome, Settings, Status, TaskError};
pub use play::{flank_commands, has_play, loaded_flanks, lost_motions, open_play, tool_play};
pub use sensitivity::{Sensitivities, Sensitivity};
pub use solution::{ChainSolution, Solution};
pub use solver::Solver;
pub use state::{ChainState, Scratch, State};
pub use stiffness::{
    chain_stiffnesses, largest_compliance, principal_stiffnesses, rigid_wrenches, smallest_eigenvalue, tool_compliance,
    unloaded_compliance, unloaded_stiffness,
};
