//! The unknowns of the machine's equilibrium, and the storage a solve reuses.

use nalgebra::Vector3;
use serde::Serialize;

use super::{held::Held, lane_solver::LaneSolver};
use crate::{
    lanes::{Frame, Vec3},
    machine::{Chain, Configuration, Machine},
    spatial::{Pose, Wrench},
};

/// Unknowns of one chain.
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
    /// Pose of P in O: of a machine whose tool bends, as the tool's end has it.
    pub pose: Pose,
    /// One per chain.
    pub chains: Vec<ChainState>,
    /// Pose that P would have if the tool were straight: that of the platform's body, where it is another.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<Pose>,
}

impl State {
    /// Pose of the platform's body, on which the chains end: of P, where the tool does not bend.
    pub fn platform(&self) -> &Pose {
        self.body.as_ref().unwrap_or(&self.pose)
    }

    /// The undeflected, unloaded state of a rigid configuration. An equilibrium without load, unless passive joints have
    /// springs that are not at their neutral position there.
    pub fn rigid(machine: &Machine, at: &Configuration) -> Self {
        let chains = machine.chains.iter().zip(&at.passive).map(|(chain, passive)| {
            let mut coordinates = vec![0.0; chain.virtual_count];
            coordinates.extend_from_slice(passive);
            ChainState { coordinates, wrench: Wrench::zero(), loops: vec![Wrench::zero(); chain.route.loop_count()] }
        });
        Self { pose: at.pose, chains: chains.collect(), body: None }
    }
}

/// Storage that a solve reuses. No solve depends on what another has left in it, but for what is known of the machine itself.
#[derive(Debug, Clone)]
pub struct Workspace {
    pub(super) solver: LaneSolver,
    /// Whether chains are condensed where they can be.
    pub(super) condenses: bool,
    /// What a load step holds back of each chain's residual and of the platform's imbalance.
    pub(super) held: Vec<Held>,
    pub(super) held_imbalance: [f64; 6],
    /// What moves without resistance at home, once that was asked.
    pub(super) free_at_home: Option<FreeAtHome>,
}

/// What moves without resistance at home, where nothing has weight.
#[derive(Debug, Clone, Copy)]
pub(super) struct FreeAtHome {
    /// Something within a chain.
    pub idle: bool,
    /// The platform, or nearly so.
    pub platform: bool,
}

impl Workspace {
    /// Storage for solves of `machine`.
    pub fn new(machine: &Machine) -> Self {
        Self {
            solver: LaneSolver::new(machine),
            condenses: true,
            held: vec![Held::default(); machine.chains.len()],
            held_imbalance: [0.0; 6],
            free_at_home: None,
        }
    }

    /// The same for solves that condense no chain: the equations as they stand, pivots by singular values. Some hundred times
    /// slower; to compare with.
    pub fn uncondensed(machine: &Machine) -> Self {
        Self { condenses: false, ..Self::new(machine) }
    }

    /// Fills the systems of all chains of `machine` at `state` under `load`, the drives at `drives`, and condenses them. Whether that is
    /// possible; if not, they are left as filled.
    pub(super) fn linearise(&mut self, machine: &Machine, drives: &[f64], state: &State, load: &Wrench) -> bool {
        self.solver.put(0, drives, state);
        self.solver.loads[0] = *load;
        self.fill(machine, &machine.gravity, 0.0, true) || self.fill(machine, &machine.gravity, 0.0, false)
    }

    /// Fills the systems where the solver stands, a kilogram having the weight `gravity` and `share` of what load steps hold back being
    /// left in place, and `condenses` them; whether they are condensed.
    pub(super) fn fill(&mut self, machine: &Machine, gravity: &Vector3<f64>, share: f64, condenses: bool) -> bool {
        let (held, gravity, condenses) = (&self.held, Vec3::splat(gravity), condenses && self.condenses);
        self.solver.linearise_by(machine, gravity, condenses, |number, system, chain, platform, carried| {
            if share == 0.0 {
                return system.fill(chain, platform, carried);
            }
            held[number].shift_loops(system, share);
            system.fill(chain, &Frame::splat(&held[number].target(&(*platform).into(), share)), carried);
            held[number].release(system, share);
            held[number].shift_loops(system, 0.0);
        });
        self.solver.condensed == 1
    }
}

/// State and drives of each chain.
pub(super) fn chain_inputs<'s>(
    machine: &'s Machine,
    state: &'s State,
    drives: &'s [f64],
) -> impl Iterator<Item = (&'s ChainState, &'s [f64])> {
    let mut rest = drives;
    machine.chains.iter().zip(&state.chains).map(move |(chain, chain_state): (&Chain, _)| {
        let (own, others) = rest.split_at(chain.drives.len());
        rest = others;
        (chain_state, own)
    })
}
