//! Derivatives of a loaded pose by the parameters of the machine: `J dx/dp = −∂F/∂p` with the linear system of the solve.
//!
//! `∂F/∂p` are differences of the residual, not of solves: of the second order, from machines a little off in one parameter each
//! ([`Variation`]), which are made once and serve every pose and load. What the engine makes of a number (the matrix of a beam by its
//! section, a frame by its angles) needs no derivative of its own.

use nalgebra::{Vector3, Vector6};

use super::{
    adjoint::{Adjoint, adjoints},
    chain_system::ChainSystem,
    state::{Scratch, State, chain_inputs},
    tool, weight,
};
use crate::{
    input::error::Result,
    lanes::{Frame, Vec3},
    machine::{Machine, Variation},
    spatial::{Wrench, rotation_log},
};

/// Machines varied in one parameter each, from which derivatives by the parameters are taken.
#[derive(Debug, Clone)]
pub struct Sensitivities {
    varied: Vec<VariedParameter>,
}

/// One parameter: the machines varied in it, and storage for their chains.
#[derive(Debug, Clone)]
struct VariedParameter {
    variation: Variation,
    /// Whether each chain differs between the varied machines and the machine: a parameter of one leg leaves the others alone.
    differs: Vec<bool>,
    chains: [Vec<ChainSystem>; 2],
}

/// Effect of a parameter on a loaded machine whose drives stay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// Twist of P per unit of the parameter under the load, mm and rad in the axes of O.
    pub twist: Vector6<f64>,
    /// Change of the tool tip in the platform's axes, mm per unit.
    pub tool_tip: Vector3<f64>,
}

impl Sensitivities {
    /// Sensitivities to the parameters of `machine` called `names`.
    ///
    /// # Errors
    /// Those of [`Machine::variations`].
    pub fn new<N: AsRef<str>>(machine: &Machine, names: &[N]) -> Result<Self> {
        Ok(Self::from_variations(machine, machine.variations(names)?))
    }

    /// Sensitivities to the parameters in which `variations` vary `machine`.
    pub fn from_variations(machine: &Machine, variations: Vec<Variation>) -> Self {
        let varied = variations.into_iter().map(|variation| {
            let differs = |chain: usize| {
                let weighs = |beside: &Machine| beside.gravity != machine.gravity;
                let is_other = |beside: &Machine| beside.chains[chain] != machine.chains[chain];
                variation.machines.iter().any(|beside| weighs(beside) || is_other(beside))
            };
            let differs = (0..machine.chains.len()).map(differs).collect();
            let chains = variation.machines.each_ref().map(ChainSystem::all);
            VariedParameter { variation, differs, chains }
        });
        Self { varied: varied.collect() }
    }

    /// Variations of the machine, one for each parameter, in the order of their names.
    pub fn variations(&self) -> impl Iterator<Item = &Variation> {
        self.varied.iter().map(|varied| &varied.variation)
    }

    /// Derivatives by each parameter, in the order of [`variations`](Self::variations), at the equilibrium `state` of `machine`, the one of
    /// [`new`](Self::new), with the drives at `drives` (mm, rad). `load` gives the dead wrench at P in O axes, N and N·mm, on `machine` and on each varied
    /// machine, as its lever may depend on the tool tip. A residual error of `state` enters the derivatives to first order. With the platform held, the wrench on it changes by `−K_C` times the twist
    /// ([`Outcome::stiffness`](super::Outcome::stiffness)). A workpiece carrier is not part of it. `None` where the platform is free.
    pub fn at(
        &mut self,
        machine: &Machine,
        drives: &[f64],
        state: &State,
        load: &dyn Fn(&Machine) -> Wrench,
        scratch: &mut Scratch,
    ) -> Option<Vec<Sensitivity>> {
        let own_load = load(machine);
        let adjoints = adjoints(machine, drives, state, &own_load, scratch)?;
        let body_to_p = tool::twist_transfer(machine, state.platform(), &own_load);
        let sensitivity_to = |varied: &mut VariedParameter| {
            let weights = varied.variation.weights();
            let (mut body_twist, mut tool_twist, mut tool_tip) = (Vector6::zeros(), Vector6::zeros(), Vector3::zeros());
            for ((varied_machine, chains), weight) in
                varied.variation.machines.iter().zip(&mut varied.chains).zip(weights)
            {
                let varied_load = load(varied_machine);
                let on_body = load_and_weight(varied_machine, state, &varied_load);
                let by_wrench = |adjoint: &Adjoint| adjoint.motion_by_wrench(&on_body);
                body_twist += weight * Vector6::from_iterator(adjoints.iter().map(by_wrench));
                let inputs = chain_inputs(varied_machine, state, drives);
                let systems = chains.iter_mut().zip(&varied_machine.chains).zip(inputs).enumerate();
                for (index, ((system, chain), (chain_state, chain_drives))) in
                    systems.filter(|(index, _)| varied.differs[*index])
                {
                    system.linearise(chain, chain_drives, chain_state, state.platform(), &varied_machine.gravity);
                    let residual = system.right_hand_sides();
                    let by_residual = |adjoint: &Adjoint| adjoint.motion_by_residual(index, system, &residual);
                    body_twist += weight * Vector6::from_iterator(adjoints.iter().map(by_residual));
                }
                tool_twist += weight * tool_motion(varied_machine, state, &varied_load);
                tool_tip += weight * varied_machine.tool_tip;
            }
            Sensitivity { twist: body_to_p * body_twist + tool_twist, tool_tip }
        };
        Some(self.varied.iter_mut().map(sensitivity_to).collect())
    }
}

/// Wrench on the platform's body in `state` by the load and by the body's weight (N, N·mm, O axes).
fn load_and_weight(machine: &Machine, state: &State, load: &Wrench) -> Vector6<f64> {
    let weight: Wrench = weight::wrench(machine, &Frame::splat(state.platform()), Vec3::splat(&machine.gravity)).into();
    tool::load_on_body(machine, state.platform(), load).to_vector() + weight.to_vector()
}

/// Twist of P (mm, rad) from its pose in `state` to its pose with the tool of `machine` under `load`, the platform's body at rest.
fn tool_motion(machine: &Machine, state: &State, load: &Wrench) -> Vector6<f64> {
    if machine.tool_compliance.is_none() {
        return Vector6::zeros();
    }
    let pose = tool::deflected_pose(machine, state.platform(), load);
    let turned = rotation_log(&(pose.rotation * state.pose.rotation.transpose()));
    let moved = pose.translation - state.pose.translation;
    Vector6::new(moved.x, moved.y, moved.z, turned.x, turned.y, turned.z)
}
