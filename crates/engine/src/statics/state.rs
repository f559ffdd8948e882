//! The unknowns of the machine's equilibrium, and the storage a solve reuses.

use serde::Serialize;

use super::{
    chain_system::ChainSystem,
    held::Held,
    platform::{self, Square},
    rigid_directions::RigidDirections,
    tool, weight,
};
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

/// Storage that a solve reuses. Holds no information between solves but of the machine itself.
#[derive(Debug, Clone)]
pub struct Workspace {
    pub(super) chains: Vec<ChainSystem>,
    pub(super) rigid: RigidDirections,
    /// Whether chains are condensed where they can be.
    pub(super) condenses: bool,
    /// Drives of the present iteration, and their last step.
    pub(super) drives: Vec<f64>,
    pub(super) drive_step: Vec<f64>,
    /// Wrench on the platform per unit motion of each drive.
    pub(super) drive_wrenches: Vec<[f64; 6]>,
    /// What a load step holds back of each chain's residual and of the platform's imbalance.
    pub(super) held: Vec<Held>,
    pub(super) held_imbalance: nalgebra::Vector6<f64>,
    /// State from which a failed solve is started again.
    pub(super) start: Option<State>,
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
        let chains = ChainSystem::all(machine);
        Self {
            rigid: RigidDirections::new(&chains),
            condenses: true,
            chains,
            drives: Vec::new(),
            drive_step: Vec::new(),
            drive_wrenches: Vec::with_capacity(machine.drive_count()),
            held: vec![Held::default(); machine.chains.len()],
            held_imbalance: nalgebra::Vector6::zeros(),
            start: None,
            free_at_home: None,
        }
    }

    /// The same for solves that condense no chain: the equations as they stand, pivots by singular values. Some hundred times
    /// slower; to compare with.
    pub fn uncondensed(machine: &Machine) -> Self {
        Self { condenses: false, ..Self::new(machine) }
    }

    /// Fills the systems of all chains of `machine` at `state`, the drives at `drives`, under its weight.
    pub(super) fn linearise(&mut self, machine: &Machine, drives: &[f64], state: &State) {
        let inputs = chain_inputs(machine, state, drives);
        for ((system, chain), (chain_state, own)) in self.chains.iter_mut().zip(&machine.chains).zip(inputs) {
            system.linearise(chain, own, chain_state, state.platform(), &machine.gravity);
        }
    }

    /// Condenses the chains; the tangent of the platform at `platform`, with what its weight by `gravity` and, if a `load` is given, a
    /// bent tool take of it. `None` if a chain cannot be condensed.
    pub(super) fn condense(
        &mut self,
        machine: &Machine,
        platform: &Pose,
        gravity: &nalgebra::Vector3<f64>,
        load: Option<&Wrench>,
    ) -> Option<Square<f64>> {
        if !self.condenses || self.chains.iter_mut().any(|system| system.eliminate() == 0) {
            return None;
        }
        let mut tangent = platform::tangent(&self.chains);
        weight::add_stiffness(machine, &Frame::splat(platform), Vec3::splat(gravity), &mut tangent);
        if let Some(load) = load {
            tool::add_stiffness(machine, platform, load, &mut tangent);
        }
        Some(tangent)
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
