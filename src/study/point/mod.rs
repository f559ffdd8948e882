//! One location: the loaded equilibrium at the nominal command, and the compensated one.

#[cfg(feature = "report")]
pub mod report;

use nalgebra::{Matrix6, Vector3};
use serde::Serialize;

use crate::{
    compensation::{Demand, Method, Target, compensate},
    machine::{ChainError, Configuration, Machine, Unreachable},
    process::MillingForce,
    spatial::{Pose, Wrench},
    statics::{Outcome, Solution, State, Workspace, equilibrium, unloaded_stiffness},
    study::{Failure, Machines, Source, sources::TO_ROUNDING},
};

/// The load at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PointLoad {
    /// The milling force at tool angle φ in rad, on the tool tip.
    Milling(MillingForce, f64),
    /// A wrench at P in O axes.
    Wrench(Wrench),
}

/// What is asked.
#[derive(Debug, Clone)]
pub struct PointQuestion {
    /// The nominal machine, by which the position is commanded.
    pub machine: Machine,
    /// Errors of each chain of the real machine; missing entries are zero.
    pub errors: Vec<ChainError>,
    /// Commanded position of P, mm.
    pub position: Vector3<f64>,
    /// The load.
    pub load: PointLoad,
    /// What compensation puts right.
    pub target: Target,
}

/// A solved state with the drive positions it belongs to.
#[derive(Debug, Clone, Serialize)]
pub struct Commanded {
    /// Drive positions, mm or rad.
    pub drives: Vec<f64>,
    /// The state.
    pub solution: Solution,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct PointAnswer {
    /// The question.
    #[serde(skip)]
    pub question: PointQuestion,
    /// The wrench at P.
    pub wrench: Wrench,
    /// The tool frame T at the commanded pose, seen from P in O axes.
    pub tool: Pose,
    /// Nominal inverse kinematics.
    pub nominal: Configuration,
    /// Unloaded stiffness of the nominal machine; `None` where a chain has no 6×6 stiffness.
    pub stiffness_unloaded: Option<Matrix6<f64>>,
    /// Equilibrium at the nominal command; the status says whether it is one.
    pub loaded: Solution,
    /// Equilibrium at the compensated command, or why there is none.
    pub compensated: Result<Commanded, Failure>,
}

/// Solves one location.
///
/// # Errors
/// [`Unreachable`] if the nominal machine cannot go there.
pub fn solve(question: &PointQuestion) -> Result<PointAnswer, Unreachable> {
    let machine = &question.machine;
    let machines = Machines::new(machine, &question.errors);
    let real = &machines.real;
    let nominal = machine.command(question.position)?;
    let tool = machine.tool_at(&nominal.pose.rotation);
    let wrench = match question.load {
        PointLoad::Milling(force, phi) => force.wrench(phi, &tool),
        PointLoad::Wrench(wrench) => wrench,
    };
    let mut workspace = Workspace::new(real);
    let mut state = State::rigid(machine, &nominal);
    let outcome = equilibrium(real, &nominal.drives, &wrench, &mut state, &mut workspace, &TO_ROUNDING);
    let describe = |drives: &[f64], state: &State, outcome: &Outcome, workspace: &mut Workspace| {
        Solution::new(real, drives, &wrench, state, outcome, workspace)
    };
    let loaded = describe(&nominal.drives, &state, &outcome, &mut workspace);
    let compensated = if outcome.is_equilibrium() {
        let mut session = machines.session(Source::Both);
        session.stand(&nominal, &state);
        let demand = Demand { pose: nominal.pose, load: wrench, target: question.target };
        let done = compensate(&mut session, &demand, Method::Direct);
        match &done.outcome {
            Some(outcome) if done.status.is_success() => {
                let solution = describe(&done.drives, session.state(), outcome, &mut workspace);
                Ok(Commanded { drives: done.drives, solution })
            }
            _ => Err(Failure { status: done.status.label().into(), reason: done.status.reason(machine) }),
        }
    } else {
        Err(Failure { status: "not_tried".into(), reason: "there is no equilibrium to start from".into() })
    };
    Ok(PointAnswer {
        stiffness_unloaded: unloaded_stiffness(machine, &nominal, &mut workspace),
        question: question.clone(),
        wrench,
        tool,
        nominal,
        loaded,
        compensated,
    })
}
