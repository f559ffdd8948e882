//! Solves the loaded machine at positions of the box: exact corrections, and residual errors without correction, with tables and with exact
//! corrections, worst over forces at each point of a grid.

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::{CorrectionQuestion, CorrectionResult, Corrector, bound::axis_forces};
use crate::{
    compensation::{Compensation, Method, Session, TaskPoint, compensate, simulate_drives},
    input::error::{Error, Result},
    machine::Configuration,
    questions::Overrides,
    simulation::{Machines, Source},
    spatial::{Grid, Pose, Wrench},
    work::{Event, Stage, Work},
};

/// The actual machine under load. Its results do not depend on earlier calls.
pub(super) struct LoadedMachine<'a> {
    question: &'a CorrectionQuestion,
    session: Session,
}

impl<'a> LoadedMachine<'a> {
    /// Creates a session of the machine with all error sources.
    pub fn new(question: &'a CorrectionQuestion, machines: &Machines) -> Self {
        Self { question, session: machines.session(Source::All) }
    }

    /// Returns the configuration of the nominal machine with P at `position` (O, mm); an error if it does not reach that.
    pub fn nominal_at(&self, position: Vector3<f64>) -> Result<Configuration> {
        let machine = &self.question.machine;
        let pose = Pose { rotation: self.question.orientation, translation: machine.controllable_position(position) };
        let reached = machine.inverse_kinematics(&pose).and_then(|at| {
            match machine.has_parasitic_rotation {
                true => machine.check_uncontrolled(pose.translation, &at)?,
                false => machine.check_tracked(&pose, &at)?,
            }
            Ok(at)
        });
        reached.map_err(|unreachable| no_correction(position, None, &unreachable.to_string()))
    }

    /// Returns Δρ of each drive, mm or rad, that compensates the loaded machine under a tool tip force (O axes, N); an error if none does.
    pub fn exact_correction(&mut self, at: &Configuration, force: Vector3<f64>) -> Result<Vec<f64>> {
        let task = self.reset_to(at, force);
        let solution = compensate(&mut self.session, &task, Method::Direct);
        self.check_solved(at, force, &solution)?;
        Ok(solution.drives.iter().zip(&at.drives).map(|(rho, nominal)| rho - nominal).collect())
    }

    /// Returns the residual error in the compensated and controlled coordinates, mm (rotations at the characteristic length), with the drives
    /// corrected by `correction` (mm, rad) under a force on the tool tip (O axes, N); an error without equilibrium.
    pub fn residual_mm(&mut self, at: &Configuration, force: Vector3<f64>, correction: &[f64]) -> Result<f64> {
        let task = self.reset_to(at, force);
        let drives: Vec<f64> = at.drives.iter().zip(correction).map(|(nominal, delta)| nominal + delta).collect();
        let solution = simulate_drives(&mut self.session, &task, &drives);
        self.check_solved(at, force, &solution)?;
        match solution.task_error() {
            error if error.is_finite() => Ok(error),
            _ => Err(no_correction(at.pose.translation, Some(force), "the error of the tool is not a number")),
        }
    }

    /// Resets the session to the rigid machine at `at`, and returns the task point there under `force` (on the tool tip, O axes, N).
    pub fn reset_to(&mut self, at: &Configuration, force: Vector3<f64>) -> TaskPoint {
        let machine = &self.question.machine;
        self.session.set_rigid(at);
        let moment = (at.pose.rotation * machine.tool_tip).cross(&force);
        let target = self.question.target;
        TaskPoint::new(at.pose, Wrench { force, moment }, target)
    }

    /// Returns an error with position, force and reason if `found` is no solution.
    fn check_solved(&self, at: &Configuration, force: Vector3<f64>, found: &Compensation) -> Result<()> {
        match found.status.is_success() {
            true => Ok(()),
            false => Err(no_correction(at.pose.translation, Some(force), &found.status.reason(&self.question.machine))),
        }
    }
}

/// Returns the results of `each` for the indices below `places`, in order, computed on the current rayon pool with a machine per thread; or
/// the first error of `each` in that order, or of `work`.
pub(super) fn map_places<T: Send>(
    question: &CorrectionQuestion,
    machines: &Machines,
    places: usize,
    work: &Work,
    each: impl Fn(&mut LoadedMachine<'_>, usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let solve_place = |loaded: &mut LoadedMachine<'_>, place: usize| {
        work.check()?;
        let result = each(loaded, place)?;
        work.tell(Event::Computed(1));
        Ok(result)
    };
    let all: Vec<Result<T>> =
        (0..places).into_par_iter().map_init(|| LoadedMachine::new(question, machines), solve_place).collect();
    all.into_iter().collect()
}

/// Returns the error that P at `position` (O, mm) has no correction under `force` (N; `None`: under any), and so there is no table.
fn no_correction(position: Vector3<f64>, force: Option<Vector3<f64>>, reason: &str) -> Error {
    // What is nothing has no sign.
    let shown = |v: Vector3<f64>| v.map(|value| (value * 1e3).round() / 1e3 + 0.0);
    let under = force.filter(|force| *force != Vector3::zeros()).map(shown);
    let under = under.map_or_else(String::new, |f| format!(" under a force of ({:.0}, {:.0}, {:.0}) N", f.x, f.y, f.z));
    let [x, y, z]: [f64; 3] = shown(position).into();
    let problem = format!(
        "there is no correction for P at ({x:.3}, {y:.3}, {z:.3}) mm{under}: {reason}; a table has no holes: expected a smaller box"
    );
    Error::Value { file: Overrides::ORIGIN.into(), line: None, key: "box".into(), problem }
}

/// Most points of the residual grid along an axis.
const MOST: usize = 9;

/// Residual errors at a position of P.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualPoint {
    /// P in O, mm.
    pub position_mm: [f64; 3],
    /// Residual error, mm, worst over no force and the largest one along each axis, by [`ResidualPoint::CORRECTION_METHODS`].
    pub residual_mm: Vec<f64>,
}

impl ResidualPoint {
    /// Correction methods: word in tables, label, and title of the map; the last only where there is a table for each drive.
    pub const CORRECTION_METHODS: [[&str; 3]; 4] = [
        ["none", "without correction", "Error without correction"],
        ["table", "with the table", "Residual error with the table"],
        ["exact", "with exact corrections", "Residual error with exact corrections"],
        ["per_joint", "with a table for each joint", "Residual error where each joint has a table of its own"],
    ];
}

/// Returns the grid on which residual errors are shown: nodes of the table and middles of its cells, as far as there are not too many.
pub fn residual_grid(question: &CorrectionQuestion, nodes: &Grid) -> Grid {
    let [min, max] = question.corners;
    Grid::new(min, max, nodes.counts().map(|count| (2 * count - 1).min(MOST)))
}

/// Returns the residual errors at the points of `grid`, in its order, computed on the current rayon pool.
///
/// # Errors
/// A position that the machine does not reach, or without equilibrium there; errors of `work`.
pub fn residuals(
    question: &CorrectionQuestion,
    answer: &CorrectionResult,
    grid: &Grid,
    work: &Work,
) -> Result<Vec<ResidualPoint>> {
    let machines = Machines::new(&question.machine, &question.errors)?;
    work.tell(Event::Stage(Stage { of: "points of the map", items: grid.len() }));
    map_places(question, &machines, grid.len(), work, |loaded, index| {
        let position = grid.position(index);
        let at = loaded.nominal_at(position)?;
        let worst_with = |loaded: &mut LoadedMachine<'_>, corrector: Corrector<'_>| {
            worst_residual(loaded, &at, question, |_, force| Ok(corrector.correction(&at, position, force)))
        };
        let mut residual_mm = vec![
            worst_with(loaded, Corrector::Nothing)?,
            worst_with(loaded, Corrector::Table(&answer.table))?,
            worst_residual(loaded, &at, question, |loaded, force| loaded.exact_correction(&at, force))?,
        ];
        if let Ok((tables, _)) = &answer.per_joint {
            residual_mm.push(worst_with(loaded, Corrector::PerJoint(tables))?);
        }
        Ok(ResidualPoint { position_mm: position.into(), residual_mm })
    })
}

/// Returns the largest residual error over the forces, mm; `correction` gives Δρ of each drive, mm or rad, for each force (N).
fn worst_residual(
    loaded: &mut LoadedMachine<'_>,
    at: &Configuration,
    question: &CorrectionQuestion,
    correction: impl Fn(&mut LoadedMachine<'_>, Vector3<f64>) -> Result<Vec<f64>>,
) -> Result<f64> {
    axis_forces(question.largest_force_N).into_iter().try_fold(0.0, |most: f64, force| {
        let correction = correction(loaded, force)?;
        Ok(most.max(loaded.residual_mm(at, force, &correction)?))
    })
}
