//! Simulation of a path's points: the actual machine's equilibrium at corrected drives, and its exact sensitivities.

use nalgebra::{DMatrix, DVector, Vector3};

use super::super::{
    Method, compensate,
    outcome::CompensationStatus,
    session::{CompensationSettings, Session},
    task_point::TaskPoint,
};
use crate::{
    machine::{Configuration, Machine},
    spatial::rotation_log,
    statics::{State, drive_force_sensitivity, drive_forces},
};

/// A point of the path that takes part in the correction.
#[derive(Debug, Clone)]
pub(super) struct Point {
    pub task: TaskPoint,
    /// Nominal inverse kinematics of the task.
    pub command: Configuration,
    /// Simulation of the nominal command; `None` if there is no equilibrium.
    pub uncorrected: Option<Simulation>,
    /// Simulation of the unbounded correction, if there is one that meets the task.
    pub exact: Option<Simulation>,
}

/// Simulated equilibrium of the actual machine at one point, and its derivatives by the drives.
#[derive(Debug, Clone)]
pub(super) struct Simulation {
    /// Drive positions ρ, mm or rad.
    pub drives: Vec<f64>,
    pub state: State,
    /// Task error e, actual less wanted, mm; rotations at the machine's characteristic length.
    pub error: DVector<f64>,
    /// `∂e/∂ρ`, mm per mm or rad.
    pub error_by_drives: DMatrix<f64>,
    /// Forces of the drives τ, N or N·mm.
    pub forces: Vec<f64>,
    /// `∂τ/∂ρ`; `None` where no force is limited.
    pub forces_by_drives: Option<DMatrix<f64>>,
}

/// Simulator of the points of a path.
pub(super) struct Simulator {
    session: Session,
    with_forces: bool,
}

impl Simulator {
    /// A simulator of `actual`, commanded by `nominal`; computes `∂τ/∂ρ` too if `with_forces`.
    pub fn new(nominal: &Machine, actual: &Machine, settings: CompensationSettings, with_forces: bool) -> Self {
        Self { session: Session::new(nominal, actual, settings), with_forces }
    }

    /// Simulates a task without and with the unbounded correction, near the last one; `Err` if neither has an equilibrium, or no command is there.
    pub fn simulate_point(&mut self, unresolved: &TaskPoint) -> Result<Point, CompensationStatus> {
        let task = &self.session.with_wanted_pose(unresolved)?;
        let exact = compensate(&mut self.session, unresolved, Method::Direct);
        let exact_state = self.session.state.clone();
        self.session.command_pose(&task.pose)?;
        let command = self.session.command.clone();
        let mut point = Point { task: *task, command, uncorrected: None, exact: None };
        let uncorrected = self.simulate(&point, &point.command.drives, &exact_state);
        if exact.status == CompensationStatus::Converged {
            point.exact = self.simulate(&point, &exact.drives, &exact_state).ok();
            self.session.state = exact_state;
            self.session.drives = exact.drives;
        }
        match (uncorrected, &point.exact) {
            (Err(status), None) => return Err(status),
            (uncorrected, _) => point.uncorrected = uncorrected.ok(),
        }
        Ok(point)
    }

    /// Equilibrium of the actual machine at `point` with drives at `drives` (mm, rad), searched from `start`, and its derivatives.
    pub fn simulate(&mut self, point: &Point, drives: &[f64], start: &State) -> Result<Simulation, CompensationStatus> {
        let session = &mut self.session;
        session.set_state(&point.command, start);
        session.drives.copy_from_slice(drives);
        let outcome = session.solve_stable(&point.task)?;
        let residual = session.task_error(&point.task);
        let weigh = |i: usize, value: f64| residual.lever[i] * value;
        let slope = residual.slope.rows(0, residual.count) * &outcome.drive_sensitivity;
        let forces_by_drives = match self.with_forces {
            true => {
                let (twists, scratch) = (&outcome.drive_sensitivity, &mut session.scratch);
                let sensitivity = drive_force_sensitivity(&session.actual, drives, &session.state, twists, scratch);
                Some(sensitivity.ok_or(CompensationStatus::Singular)?)
            }
            false => None,
        };
        Ok(Simulation {
            drives: drives.to_vec(),
            state: session.state.clone(),
            error: DVector::from_fn(residual.count, |i, _| weigh(i, residual.error[i])),
            error_by_drives: DMatrix::from_fn(residual.count, drives.len(), |i, j| weigh(i, slope[(i, j)])),
            forces: drive_forces(&session.actual, &session.state),
            forces_by_drives,
        })
    }
}

impl Point {
    /// The simulation from which a search starts: that of the unbounded correction, else the uncorrected one; `None` if there is neither.
    pub fn best_start(&self) -> Option<&Simulation> {
        self.exact.as_ref().or(self.uncorrected.as_ref())
    }

    /// Corrections Δρ of `drives`: their difference from the nominal command.
    pub fn corrections<'s>(&'s self, drives: &'s [f64]) -> impl Iterator<Item = f64> + 's {
        drives.iter().zip(&self.command.drives).map(|(rho, nominal)| rho - nominal)
    }

    /// Position error of the compensated point (mm) and rotation vector from the wanted orientation (rad) in `state`, O axes.
    pub fn errors(&self, machine: &Machine, state: &State) -> (Vector3<f64>, Vector3<f64>) {
        let (target, offset) = (self.task.wanted(), self.task.offset(machine));
        let turn = rotation_log(&(state.pose.rotation * target.rotation.transpose()));
        (state.pose.transform(offset) - target.transform(offset), turn)
    }
}
