//! Unknowns of the machine's equilibrium, and the storage that solves reuse.

use nalgebra::Vector3;
use serde::Serialize;

use super::{held::StartResidual, lane_solver::LaneSolver};
use crate::{
    lanes::{Frame, Vec3},
    machine::{Chain, Configuration, Machine},
    spatial::{Pose, Wrench},
};

/// State of one chain: its coordinates and the wrenches that it and its loops receive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainState {
    /// Virtual coordinates θ (mm, rad), then passive coordinates q.
    pub coordinates: Vec<f64>,
    /// Wrench F_i that the chain receives from the platform (and carries to the base), at P in O axes.
    pub wrench: Wrench,
    /// Wrench that each loop of the chain receives where it ends, in the axes of the frame where it starts; each loop before those within it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub loops: Vec<Wrench>,
}

/// A machine state: pose of P in O and the unknowns of each chain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct State {
    /// Pose of P in O; of a machine whose tool bends, at the end of the tool.
    pub pose: Pose,
    /// State of each chain, in machine order.
    pub chains: Vec<ChainState>,
    /// Pose of the platform's body, which P would have if the tool were straight; `None` where that is `pose`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<Pose>,
}

impl State {
    /// Pose in O of the platform's body, on which the chains end; that of P where the tool does not bend.
    pub fn platform(&self) -> &Pose {
        self.body.as_ref().unwrap_or(&self.pose)
    }

    /// The undeflected, unloaded state of a rigid configuration. An equilibrium without load, unless passive joints have
    /// springs that are not at their neutral position there.
    pub fn rigid(machine: &Machine, at: &Configuration) -> Self {
        let chains = machine.chains.iter().zip(&at.passive).map(|(chain, passive)| ChainState {
            coordinates: vec![0.0; chain.virtual_count + passive.len()],
            wrench: Wrench::zero(),
            loops: vec![Wrench::zero(); chain.route.loop_count()],
        });
        let mut state = Self { pose: at.pose, chains: chains.collect(), body: None };
        state.set_rigid(at);
        state
    }

    /// Makes this the undeflected, unloaded state of the rigid configuration `at` of the same machine, without allocating.
    pub fn set_rigid(&mut self, at: &Configuration) {
        (self.pose, self.body) = (at.pose, None);
        for (chain, passive) in self.chains.iter_mut().zip(&at.passive) {
            let virtual_count = chain.coordinates.len() - passive.len();
            chain.coordinates[..virtual_count].fill(0.0);
            chain.coordinates[virtual_count..].copy_from_slice(passive);
            chain.wrench = Wrench::zero();
            chain.loops.fill(Wrench::zero());
        }
    }
}

/// Storage that a solve reuses. No solve depends on what another has left in it, but for what is known of the machine itself.
#[derive(Debug, Clone)]
pub struct Scratch {
    pub(super) solver: LaneSolver,
    /// Whether chains are condensed where they can be.
    pub(super) condenses: bool,
    /// Residual of each chain, and imbalance of the platform, at the start of load stepping.
    pub(super) start_residuals: Vec<StartResidual>,
    pub(super) start_imbalance: [f64; 6],
    /// Motions without resistance at home, once computed.
    pub(super) free_at_home: Option<FreeAtHome>,
}

/// Motions without resistance at home, weight left out.
#[derive(Debug, Clone, Copy)]
pub(super) struct FreeAtHome {
    /// Whether something within a chain moves so.
    pub idle: bool,
    /// Whether the platform moves so, or nearly so.
    pub platform: bool,
}

impl Scratch {
    /// Storage for solves of `machine`.
    pub fn new(machine: &Machine) -> Self {
        Self {
            solver: LaneSolver::new(machine),
            condenses: true,
            start_residuals: vec![StartResidual::default(); machine.chains.len()],
            start_imbalance: [0.0; 6],
            free_at_home: None,
        }
    }

    /// Storage for solves that condense no chain but factorise all equations so that the rank shows. Some hundred times slower; to compare with.
    pub fn uncondensed(machine: &Machine) -> Self {
        Self { condenses: false, ..Self::new(machine) }
    }

    /// Fills the systems of all chains in `state` under `load`, drives at `drives` (mm, rad); returns whether it could also condense them.
    pub(super) fn linearise(&mut self, machine: &Machine, drives: &[f64], state: &State, load: &Wrench) -> bool {
        self.solver.set_state(0, drives, state);
        self.solver.loads[0] = *load;
        self.fill(machine, &machine.gravity, 0.0, true) || self.fill(machine, &machine.gravity, 0.0, false)
    }

    /// Fills the systems at the present state of the solver, `share` of the residuals at the start of load stepping held back, and
    /// `condenses` them; returns whether they are condensed. `gravity`: weight of a kilogram, N.
    pub(super) fn fill(&mut self, machine: &Machine, gravity: &Vector3<f64>, share: f64, condenses: bool) -> bool {
        let (start, gravity, condenses) = (&self.start_residuals, Vec3::splat(gravity), condenses && self.condenses);
        self.solver.linearise_with(machine, gravity, condenses, |number, system, chain, platform, input| {
            if share == 0.0 {
                return system.fill(chain, platform, input);
            }
            start[number].shift_loop_ends(system, share);
            system.fill(chain, &Frame::splat(&start[number].target(&(*platform).into(), share)), input);
            start[number].subtract_share(system, share);
            start[number].shift_loop_ends(system, 0.0);
        });
        self.solver.condensed == 1
    }
}

/// State and drive positions of each chain, in machine order.
pub(super) fn chain_inputs<'s>(
    machine: &'s Machine,
    state: &'s State,
    drives: &'s [f64],
) -> impl Iterator<Item = (&'s ChainState, &'s [f64])> {
    let mut rest = drives;
    machine.chains.iter().zip(&state.chains).map(move |(chain, chain_state): (&Chain, _)| {
        let (chain_drives, others) = rest.split_at(chain.drives.len());
        rest = others;
        (chain_state, chain_drives)
    })
}
