//! Solves one location: the loaded equilibrium at the nominal command, and at the compensated one.

#[cfg(feature = "report")]
pub mod report;

use nalgebra::{Matrix6, Vector3};
use serde::Serialize;

use crate::{
    compensation::{CompensationStatus, Method, Target, TaskPoint, compensate},
    machine::{Branch, ChainError, Clearance, Configuration, Machine, PostureChange, Unreachable},
    process::MillingForce,
    simulation::{Failure, Machines, Source, sources::TO_ROUNDING},
    spatial::{Pose, Wrench},
    statics::{Scratch, Solution, State, equilibrium, unloaded_stiffness},
};

/// The load at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PointLoad {
    /// A milling force at tool angle φ in rad, on the tool tip.
    Milling(MillingForce, f64),
    /// A milling force as above, and its torque about the tool's axis, N·mm, above 0 against a spindle that turns clockwise.
    Cut(MillingForce, f64, f64),
    /// A wrench at P in O axes.
    Wrench(Wrench),
}

impl PointLoad {
    /// Returns the wrench at P (O axes, N and N·mm); `tool` is the tool frame T seen from P in O axes.
    pub fn wrench(&self, tool: &Pose) -> Wrench {
        match *self {
            PointLoad::Milling(force, phi) => force.wrench(phi, tool),
            PointLoad::Cut(force, phi, torque) => {
                let own = force.wrench(phi, tool);
                // About the direction from the tip to the spindle, against z of the tool.
                Wrench { moment: own.moment - tool.rotation * Vector3::z() * torque, ..own }
            }
            PointLoad::Wrench(wrench) => wrench,
        }
    }
}

/// A command to the nominal machine.
#[derive(Debug, Clone, PartialEq)]
pub enum NominalCommand {
    /// A position of P in O, mm, oriented as at home.
    Position(Vector3<f64>),
    /// A pose of P in O.
    Pose(Pose),
    /// Positions of the drives, mm or rad.
    Drives(Vec<f64>),
}

impl NominalCommand {
    /// Returns the commanded position of P, mm; `None` for drive positions.
    pub fn position(&self) -> Option<Vector3<f64>> {
        match self {
            NominalCommand::Position(position) => Some(*position),
            NominalCommand::Pose(pose) => Some(pose.translation),
            NominalCommand::Drives(_) => None,
        }
    }

    /// Returns the configuration of the nominal machine at this command, or why the machine cannot go there.
    pub(crate) fn command(&self, machine: &Machine) -> Result<Configuration, Unreachable> {
        match self {
            NominalCommand::Position(position) => machine.inverse_kinematics_at(*position),
            NominalCommand::Pose(pose) => {
                let at = machine.inverse_kinematics(pose)?;
                machine.check_uncontrolled(pose.translation, &at)?;
                machine.check_orientation(&pose.rotation, &at)?;
                Ok(at)
            }
            NominalCommand::Drives(drives) => {
                let at = machine.forward_kinematics(drives)?;
                machine.check_limits(&at)?;
                Ok(at)
            }
        }
    }
}

/// A location with machine, command and load.
#[derive(Debug, Clone)]
pub struct PointQuestion {
    /// The nominal machine, which computes commands.
    pub machine: Machine,
    /// The nominal and the actual machines.
    pub machines: Machines,
    /// Chain errors of the actual machine; missing entries are zero.
    pub errors: Vec<ChainError>,
    /// The command.
    pub place: NominalCommand,
    /// The load.
    pub load: PointLoad,
    /// What is compensated: P, tool tip or full pose.
    pub target: Target,
}

/// A compensated command and the equilibrium there.
#[derive(Debug, Clone, Serialize)]
pub struct CompensatedState {
    /// Drive positions, mm or rad.
    pub drives: Vec<f64>,
    /// The equilibrium.
    pub solution: Solution,
}

/// Equilibria and stiffnesses at a location.
#[derive(Debug, Clone, Serialize)]
pub struct PointResult {
    /// The question.
    #[serde(skip)]
    pub question: PointQuestion,
    /// The wrench at P.
    pub wrench: Wrench,
    /// The tool frame T at the commanded pose, seen from P in O axes.
    pub tool: Pose,
    /// Configuration of the nominal machine at the command.
    pub nominal: Configuration,
    /// Distance to singularity there, see [`Machine::conditioning`].
    pub conditioning: f64,
    /// Branch of an arm, and its distance from the singularities between branches.
    pub branch: Option<(Branch, Clearance)>,
    /// Pose of P from which displacements are measured: where the machine is calibrated; or why it has no equilibrium there.
    pub zero: Result<Pose, Failure>,
    /// Displacement of the tool tip by weight and springs of the nominal machine, against the rigid model, O axes, mm; `None` without any.
    pub by_weight: Option<Result<Vector3<f64>, Failure>>,
    /// Unloaded stiffness of the nominal machine; `None` where a chain has no 6×6 stiffness.
    pub stiffness_unloaded: Option<Matrix6<f64>>,
    /// Equilibrium at the nominal command; the status says whether it is one.
    pub loaded: Solution,
    /// Principal stiffnesses of the tool tip against the workpiece there, ascending, N/mm; `None` if the platform is free or not in
    /// equilibrium.
    pub tool_stiffness: Option<[f64; 3]>,
    /// Equilibrium at the compensated command, or why there is none.
    pub compensated: Result<CompensatedState, Failure>,
}

impl PointResult {
    /// Returns the drive corrections Δρ of the compensation, mm or rad; `None` if there is none.
    pub fn corrections(&self) -> Option<Vec<f64>> {
        let compensated = self.compensated.as_ref().ok()?;
        Some(compensated.drives.iter().zip(&self.nominal.drives).map(|(after, before)| after - before).collect())
    }

    /// Returns the task point at the commanded pose.
    pub fn task(&self) -> TaskPoint {
        let (pose, target) = (self.nominal.pose, self.question.target);
        TaskPoint::new(pose, self.wrench, target)
    }
}

/// Solves one location: its loaded equilibrium at the nominal command and at the compensated one.
///
/// # Errors
/// [`Unreachable`] if the nominal machine cannot go there.
pub fn solve(question: &PointQuestion) -> Result<PointResult, Unreachable> {
    let machine = &question.machine;
    let nominal = question.place.command(machine)?;
    // Drives to spare stay as near as they can to where they are asked for.
    let machines = &match question.place {
        NominalCommand::Drives(_) if machine.redundancy > 0 => question.machines.with_home_at(&nominal),
        _ => question.machines.clone(),
    };
    let actual = &machines.actual;
    let tool = machine.tool_at(&nominal.pose.rotation);
    let wrench = question.load.wrench(&tool);
    let mut scratch = Scratch::new(actual);
    let mut state = State::rigid(machine, &nominal);
    let outcome = equilibrium(actual, &nominal.drives, &wrench, &mut state, &mut scratch, &TO_ROUNDING);
    let loaded = Solution::new(actual, &nominal.drives, &state, &outcome, &mut scratch);
    let task = TaskPoint::new(nominal.pose, wrench, question.target);
    let failed = |status: CompensationStatus| Failure::of(&status, machine);
    let mut session_at_rest = machines.session(Source::All);
    // It rests as it is commanded, not in the way of home: drives may be given on another branch.
    session_at_rest.set_rigid(&nominal);
    let task_at_zero = session_at_rest.with_wanted_pose(&task);
    let carrier = session_at_rest.workpiece_compliance(&task).ok();
    let compensated = if outcome.is_equilibrium() {
        let mut session = machines.session(Source::All);
        session.set_state(&nominal, &state);
        let solved = compensate(&mut session, &task, Method::Direct);
        match &solved.outcome {
            Some(outcome) if solved.status.is_success() => {
                let corrected = Configuration { drives: solved.drives, ..nominal.clone() };
                match machine.posture_change(&nominal, &corrected, false) {
                    // From a singular place the iteration may end where the joints stand another way.
                    Some(change @ PostureChange::Jump { .. }) => Err(Failure {
                        status: "changes_posture".into(),
                        reason: format!("{change} to keep the tool there"),
                    }),
                    _ => {
                        let drives = corrected.drives;
                        let solution = Solution::new(actual, &drives, session.state(), outcome, &mut scratch);
                        Ok(CompensatedState { drives, solution })
                    }
                }
            }
            _ => Err(failed(solved.status)),
        }
    } else {
        Err(Failure { status: "not_tried".into(), reason: "there is no equilibrium to start from".into() })
    };
    Ok(PointResult {
        zero: task_at_zero.map(|task| *task.wanted()).map_err(failed),
        by_weight: machine.own_load_text().is_some().then(|| {
            let mut session = machines.session(Source::Weight);
            session.set_rigid(&nominal);
            let by_weight = compensate(&mut session, &Source::Weight.task(&task), Method::None);
            if by_weight.status.is_success() { Ok(by_weight.tool_displacement) } else { Err(failed(by_weight.status)) }
        }),
        stiffness_unloaded: unloaded_stiffness(machine, &nominal, &mut scratch),
        conditioning: machine.conditioning(&nominal),
        branch: machine.branch_of(&nominal).zip(machine.clearance(&nominal)),
        question: question.clone(),
        wrench,
        tool,
        nominal,
        tool_stiffness: carrier.and_then(|carrier| loaded.tool_stiffnesses(actual, &carrier)),
        loaded,
        compensated,
    })
}
