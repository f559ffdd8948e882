//! One location: the loaded equilibrium at the nominal command, and the compensated one.

#[cfg(feature = "report")]
pub mod report;

use nalgebra::{Matrix6, Vector3};
use serde::Serialize;

use crate::{
    compensation::{CompensationStatus, Method, Target, TaskPoint, compensate},
    machine::{Branch, ChainError, Clearance, Configuration, Machine, Unreachable},
    process::MillingForce,
    simulation::{Failure, Machines, Source, sources::TO_ROUNDING},
    spatial::{Pose, Wrench},
    statics::{Solution, State, Workspace, equilibrium, unloaded_stiffness},
};

/// The load at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PointLoad {
    /// The milling force at tool angle φ in rad, on the tool tip.
    Milling(MillingForce, f64),
    /// A wrench at P in O axes.
    Wrench(Wrench),
}

impl PointLoad {
    /// The wrench at P of a tool whose frame T is `tool`, seen from P in O axes.
    pub fn wrench(&self, tool: &Pose) -> Wrench {
        match *self {
            PointLoad::Milling(force, phi) => force.wrench(phi, tool),
            PointLoad::Wrench(wrench) => wrench,
        }
    }
}

/// What the nominal machine is commanded to.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// A position of P in O, mm, oriented as at home.
    Position(Vector3<f64>),
    /// A pose of P in O.
    Pose(Pose),
    /// Positions of the drives, mm or rad.
    Drives(Vec<f64>),
}

impl Place {
    /// The position of P that is asked for, mm, if one is.
    pub fn position(&self) -> Option<Vector3<f64>> {
        match self {
            Place::Position(position) => Some(*position),
            Place::Pose(pose) => Some(pose.translation),
            Place::Drives(_) => None,
        }
    }

    fn command(&self, machine: &Machine) -> Result<Configuration, Unreachable> {
        match self {
            Place::Position(position) => machine.command(*position),
            Place::Pose(pose) => {
                let at = machine.inverse_kinematics(pose)?;
                machine.check_asked(pose.translation, &at)?;
                machine.check_orientation(&pose.rotation, &at)?;
                Ok(at)
            }
            Place::Drives(drives) => {
                let at = machine.forward_kinematics(drives)?;
                machine.check_limits(&at)?;
                Ok(at)
            }
        }
    }
}

/// What is asked.
#[derive(Debug, Clone)]
pub struct PointQuestion {
    /// The nominal machine, by which the position is commanded.
    pub machine: Machine,
    /// It and those that answer.
    pub machines: Machines,
    /// Errors of each chain of the real machine; missing entries are zero.
    pub errors: Vec<ChainError>,
    /// What is commanded.
    pub place: Place,
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
    /// Distance to singularity there, see [`Machine::conditioning`].
    pub conditioning: f64,
    /// The branch on which an arm stands there, and how far it is from the singularities between its branches.
    pub branch: Option<(Branch, Clearance)>,
    /// The pose of P from which displacements are measured: where the machine is zeroed; the reason if it does not stand there.
    pub zero: Result<Pose, Failure>,
    /// Displacement of the tool tip by weight and springs of the nominal machine, against the rigid model, mm; `None` without any.
    pub by_weight: Option<Result<Vector3<f64>, Failure>>,
    /// Unloaded stiffness of the nominal machine; `None` where a chain has no 6×6 stiffness.
    pub stiffness_unloaded: Option<Matrix6<f64>>,
    /// Equilibrium at the nominal command; the status says whether it is one.
    pub loaded: Solution,
    /// Principal stiffnesses of the tool tip against the workpiece there, ascending, N/mm; `None` where the platform is free or there is
    /// no equilibrium.
    pub tool_stiffness: Option<[f64; 3]>,
    /// Equilibrium at the compensated command, or why there is none.
    pub compensated: Result<Commanded, Failure>,
}

impl PointAnswer {
    /// What compensation adds to the drive positions, mm or rad.
    pub fn change(&self) -> Option<Vec<f64>> {
        let compensated = self.compensated.as_ref().ok()?;
        Some(compensated.drives.iter().zip(&self.nominal.drives).map(|(after, before)| after - before).collect())
    }

    /// What was wanted at the commanded pose.
    pub fn task(&self) -> TaskPoint {
        let (pose, target) = (self.nominal.pose, self.question.target);
        TaskPoint { pose, load: self.wrench, target, wanted: None, external: None }
    }
}

/// Solves one location.
///
/// # Errors
/// [`Unreachable`] if the nominal machine cannot go there.
pub fn solve(question: &PointQuestion) -> Result<PointAnswer, Unreachable> {
    let machine = &question.machine;
    let nominal = question.place.command(machine)?;
    // Drives to spare stay as near as they can to where they are asked for.
    let machines = &match question.place {
        Place::Drives(_) if machine.redundancy > 0 => question.machines.at_home_at(&nominal),
        _ => question.machines.clone(),
    };
    let real = &machines.real;
    let tool = machine.tool_at(&nominal.pose.rotation);
    let wrench = question.load.wrench(&tool);
    let mut workspace = Workspace::new(real);
    let mut state = State::rigid(machine, &nominal);
    let outcome = equilibrium(real, &nominal.drives, &wrench, &mut state, &mut workspace, &TO_ROUNDING);
    let loaded = Solution::new(real, &nominal.drives, &state, &outcome, &mut workspace);
    let task = TaskPoint { pose: nominal.pose, load: wrench, target: question.target, wanted: None, external: None };
    let failed = |status: CompensationStatus| Failure { status: status.label().into(), reason: status.reason(machine) };
    let mut asked = machines.session(Source::All);
    let zeroed = asked.zeroed(&task);
    let carried = asked.workpiece_compliance(&task).ok();
    let compensated = if outcome.is_equilibrium() {
        let mut session = machines.session(Source::All);
        session.stand(&nominal, &state);
        let done = compensate(&mut session, &task, Method::Direct);
        match &done.outcome {
            Some(outcome) if done.status.is_success() => {
                let solution = Solution::new(real, &done.drives, session.state(), outcome, &mut workspace);
                Ok(Commanded { drives: done.drives, solution })
            }
            _ => Err(failed(done.status)),
        }
    } else {
        Err(Failure { status: "not_tried".into(), reason: "there is no equilibrium to start from".into() })
    };
    Ok(PointAnswer {
        zero: zeroed.map(|task| *task.wanted()).map_err(failed),
        by_weight: machine.own_forces().is_some().then(|| {
            let mut session = machines.session(Source::Weight);
            session.stand(&nominal, &State::rigid(machine, &nominal));
            let sunk = compensate(&mut session, &Source::Weight.task(&task), Method::None);
            if sunk.status.is_success() { Ok(sunk.tool_displacement) } else { Err(failed(sunk.status)) }
        }),
        stiffness_unloaded: unloaded_stiffness(machine, &nominal, &mut workspace),
        conditioning: machine.conditioning(&nominal),
        branch: machine.branch_of(&nominal).zip(machine.clearance(&nominal)),
        question: question.clone(),
        wrench,
        tool,
        nominal,
        tool_stiffness: carried.and_then(|carried| loaded.tool_stiffnesses(real, &carried)),
        loaded,
        compensated,
    })
}
