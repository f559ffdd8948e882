//! Ablation: divides the superposition error by its causes.
//!
//! Subtracting what the chain errors do alone leaves the superposition error as the difference between two responses to the same
//! load: that of the nominal machine from where it rests, and that of the actual one from where its errors have put it,
//!
//! `d = c(N, t₀) − c(R, t_a)`, with `c(M, t)` the displacement by `F` of machine `M` whose P rests at `t` without load.
//!
//! Three things differ, and the response is not linear in the load. With the linear response `l(M, t) = C(M, t) F`, `C`
//! the compliance of the unloaded machine at rest, internal forces included:
//!
//! | cause | contribution | what is evaluated |
//! |---|---|---|
//! | [`Point`](Cause::Point) | `l(N, t₀) − l(N, t_a)` | the nominal machine commanded to where the errors put P |
//! | [`Chains`](Cause::Chains) | `l(N, t₀) − l(R′, t₀)` | the actual machine with P commanded back to t₀, freed of internal forces |
//! | [`Preload`](Cause::Preload) | `l(R′, t₀) − l(R, t₀)` | the same with its internal forces: geometric stiffness of the preload |
//! | [`Load`](Cause::Load) | `[c − l](N, t₀) − [c − l](R, t_a)` | loaded against unloaded stiffness: geometric stiffness of the cutting force |
//! | [`Interaction`](Cause::Interaction) | `l(N, t_a) + l(R, t₀) − l(N, t₀) − l(R, t_a)` | what point and machine do together beyond either alone |
//!
//! The five add up to `d` identically. In the sources scaled by `s`, the first three are of order `s²`, the others `s³`.
//!
//! `R′` is `R` in the very shape it has been assembled to, legs turned and bent, platform turned, but without stress: each
//! spring is neutral where it stands. What turning and bending do to the stiffness matrix therefore counts as chains, what
//! the wrenches themselves do, through the Hessians of eqs. (4) and (5), as preload.
//!
//! "P commanded to" means as far as the drives control it: P and, for machines that control rotations, its orientation.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{
    rig::LockedMachine,
    superposition_error::{Case, Displacement},
};
use crate::{
    compensation::{CompensationSettings, Method, Session, Target, TaskPoint, compensate},
    machine::{Machine, Motion, Step},
    simulation::{Failure, Source},
    spatial::{Pose, Twist, Wrench},
    statics::State,
};

/// A cause of the superposition error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Shift of the evaluation point: the stiffness is that of another position.
    Point,
    /// Another stiffness matrix at the same position, because the chains are turned and bent.
    Chains,
    /// Internal forces: geometric stiffness of the assembled, unloaded machine.
    Preload,
    /// Cutting force: geometric stiffness of the load, which differs between the two machines.
    Load,
    /// Interaction of shift and changed machine, beyond the sum of either alone.
    Interaction,
}

impl Cause {
    /// All, in table order.
    pub const ALL: [Cause; 5] = [Cause::Point, Cause::Chains, Cause::Preload, Cause::Load, Cause::Interaction];

    /// Returns the word for the cause in tables.
    pub fn label(self) -> &'static str {
        match self {
            Cause::Point => "point",
            Cause::Chains => "chains",
            Cause::Preload => "preload",
            Cause::Load => "load",
            Cause::Interaction => "interaction",
        }
    }
}

/// The superposition error at one tool angle, divided by cause.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ablation {
    /// Tool angle φ, degrees.
    pub phi_deg: f64,
    /// The superposition error.
    pub superposition_error: Displacement,
    /// Part of each cause, in the order of [`Cause::ALL`].
    pub parts: [Displacement; 5],
}

/// Equilibrium of a machine without load, with its compliance.
struct AtRest {
    state: State,
    drives: Vec<f64>,
    compliance: nalgebra::Matrix6<f64>,
}

impl AtRest {
    /// Solves the equilibrium of `machine` without load, drives at `drives` (mm, rad), from `start`. `Err` if there is none or it is
    /// singular.
    fn solve(machine: &Machine, drives: &[f64], start: State) -> Result<Self, Failure> {
        let mut rig = LockedMachine::at_drives(machine, drives, start);
        let outcome = rig.equilibrium_under(&Wrench::zero())?;
        match outcome.compliance {
            Some(compliance) => Ok(Self { state: rig.state, drives: drives.to_vec(), compliance }),
            None => {
                Err(Failure { status: "singular".into(), reason: "the platform can move without resistance".into() })
            }
        }
    }

    /// Solves the equilibrium of `machine` without load, commanded so that P is at `pose`, as far as the drives control it; else `Err`.
    fn at_commanded_pose(case: &Case<'_>, machine: &Machine, pose: &Pose) -> Result<Self, Failure> {
        // Without a tool, the full pose of the tool tip is that of P.
        let without_tool = |machine: &Machine| {
            let mut machine = machine.clone();
            machine.tool_tip = Vector3::zeros();
            machine
        };
        let (nominal, actual) = (without_tool(&case.study.load_case.machine), without_tool(machine));
        let mut session = Session::new(&nominal, &actual, CompensationSettings::default());
        session.set_rigid(&case.at);
        let task = TaskPoint { wanted: Some(*pose), ..TaskPoint::new(*pose, Wrench::zero(), Target::FullPose) };
        let done = compensate(&mut session, &task, Method::Direct);
        if !done.status.is_success() {
            let reason =
                format!("P cannot be commanded to its place for the ablation: {}", done.status.reason(&nominal));
            return Err(Failure { status: done.status.label().into(), reason });
        }
        Self::solve(machine, &done.drives, session.state().clone())
    }

    /// Returns the displacement of tool tip and P by `load`, a wrench at P in O axes, to first order.
    fn displacement_under(&self, machine: &Machine, load: &Wrench) -> Displacement {
        let twist = Twist::from_vector(&(self.compliance * load.to_vector()));
        Displacement::by_twist(machine, twist, &self.state.pose)
    }
}

/// Returns `machine` in the shape it has `at_rest` but free of internal forces, and its state: every spring is neutral there.
fn without_internal_forces(machine: &Machine, at_rest: &AtRest) -> (Machine, State) {
    let (mut freed, mut state) = (machine.clone(), at_rest.state.clone());
    for (chain, chain_state) in freed.chains.iter_mut().zip(&mut state.chains) {
        chain_state.wrench = Wrench::zero();
        let (deflections, passive) = chain_state.coordinates.split_at_mut(chain.virtual_count);
        let bent = |step: &Step| match *step {
            Step::Move { motion, axis, coordinate, sign } if coordinate < deflections.len() => {
                let mut shift = Pose::identity();
                match motion {
                    Motion::Prismatic => shift.translate_along(axis, sign * deflections[coordinate]),
                    Motion::Revolute => shift.rotate_about(axis, sign * deflections[coordinate]),
                }
                vec![Step::Fixed(shift), *step]
            }
            _ => vec![*step],
        };
        chain.route.for_each(&mut |route| route.steps = route.steps.iter().flat_map(bent).collect());
        deflections.fill(0.0);
        for (joint, q) in chain.passive.iter_mut().zip(passive) {
            joint.neutral = *q;
        }
    }
    (freed, state)
}

/// Divides the superposition error by cause, at each φ of the study; `Err` where a machine cannot be solved, or weight is a source.
pub(super) fn ablate(case: &Case<'_>) -> Result<Vec<Ablation>, Failure> {
    let nominal = &case.study.load_case.machine;
    if Source::parts(nominal).contains(&Source::Weight) {
        let reason =
            "can be separated only for machines that are zeroed at rest under their weight (zeroed = \"at_rest\")";
        return Err(Failure { status: "not_tried".into(), reason: reason.into() });
    }
    let displacements = case.displacements(case.machines, 1.0)?;
    let actual = case.machines.actual.clone();
    let rigid = || State::rigid(nominal, &case.at);
    let nominal_here = AtRest::solve(nominal, &case.at.drives, rigid())?;
    let real_there = AtRest::solve(&actual, &case.at.drives, rigid())?;
    let nominal_there = AtRest::at_commanded_pose(case, nominal, &real_there.state.pose)?;
    let real_here = AtRest::at_commanded_pose(case, &actual, &case.rest)?;
    let (freed_machine, start) = without_internal_forces(&actual, &real_here);
    let freed_here = AtRest::solve(&freed_machine, &real_here.drives, start)?;

    let superposition_errors = displacements.errors_over_phi(displacements.assembly);
    let loads = case.cutting_wrenches(1.0);
    let solved = displacements.cutting.iter().zip(&displacements.both).zip(superposition_errors);
    let parts = solved.zip(loads.iter().zip(&case.study.load_case.phis)).map(
        |(((cutting, both), superposition_error), (load, phi))| {
            let [here, there, freed_here, real_here, real_there] =
                [&nominal_here, &nominal_there, &freed_here, &real_here, &real_there]
                    .map(|m| m.displacement_under(nominal, load));
            let real_cutting = *both - displacements.assembly;
            let parts = [
                here - there,
                here - freed_here,
                freed_here - real_here,
                (*cutting - here) - (real_cutting - real_there),
                there + real_here - here - real_there,
            ];
            Ablation { phi_deg: phi.to_degrees(), superposition_error, parts }
        },
    );
    Ok(parts.collect())
}
