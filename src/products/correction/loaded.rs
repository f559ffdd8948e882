//! The loaded machine at a position: what must be commanded there under a force, and what a command leaves; what is left over the box without
//! correction, with tables and with exact corrections, worst over forces at each point of a grid.

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::{CorrectionAnswer, CorrectionQuestion, Corrector, bound::axis_forces};
use crate::{
    compensation::{Compensation, Method, Session, TaskPoint, compensate, simulate_drives},
    input::error::{Error, Result},
    machine::Configuration,
    questions::Overrides,
    simulation::{Machines, Source},
    spatial::{Grid, Pose, Wrench},
    statics::State,
    work::{Event, Stage, Work},
};

/// The machine that answers. What it answers depends on nothing that was asked before.
pub(super) struct Loaded<'a> {
    question: &'a CorrectionQuestion,
    session: Session,
}

impl<'a> Loaded<'a> {
    pub fn new(question: &'a CorrectionQuestion, machines: &Machines) -> Self {
        Self { question, session: machines.session(Source::All) }
    }

    /// Where the nominal machine stands with P at `position` (O, mm).
    ///
    /// # Errors
    /// It does not reach it.
    pub fn stand(&self, position: Vector3<f64>) -> Result<Configuration> {
        let machine = &self.question.machine;
        let pose = Pose { rotation: self.question.orientation, translation: machine.as_controlled(position) };
        let reached = machine.inverse_kinematics(&pose).and_then(|at| {
            match machine.turns_with_position {
                true => machine.check_asked(pose.translation, &at)?,
                false => machine.check_tracked(&pose, &at)?,
            }
            Ok(at)
        });
        reached.map_err(|unreachable| hole(position, None, &unreachable.to_string()))
    }

    /// Δρ of each drive by which the tool is where it is wanted under a force on its tip (O axes, N), mm or rad.
    ///
    /// # Errors
    /// There are no such commands.
    pub fn exact(&mut self, at: &Configuration, force: Vector3<f64>) -> Result<Vec<f64>> {
        let task = self.stand_at(at, force);
        let found = compensate(&mut self.session, &task, Method::Direct);
        self.checked(at, force, &found)?;
        Ok(found.drives.iter().zip(&at.drives).map(|(rho, nominal)| rho - nominal).collect())
    }

    /// How far the tool is from where it is wanted with the drives corrected by `correction` (mm, rad) under a force on its tip (O
    /// axes, N), in what is compensated and controlled, mm (rotations at the machine's characteristic length).
    ///
    /// # Errors
    /// The machine does not stand there.
    pub fn residual_mm(&mut self, at: &Configuration, force: Vector3<f64>, correction: &[f64]) -> Result<f64> {
        let task = self.stand_at(at, force);
        let drives: Vec<f64> = at.drives.iter().zip(correction).map(|(nominal, own)| nominal + own).collect();
        let found = simulate_drives(&mut self.session, &task, &drives);
        self.checked(at, force, &found)?;
        match found.task_error() {
            left if left.is_finite() => Ok(left),
            _ => Err(hole(at.pose.translation, Some(force), "the error of the tool is not a number")),
        }
    }

    fn stand_at(&mut self, at: &Configuration, force: Vector3<f64>) -> TaskPoint {
        let machine = &self.question.machine;
        self.session.stand(at, &State::rigid(machine, at));
        let moment = (at.pose.rotation * machine.tool_tip).cross(&force);
        let target = self.question.target;
        TaskPoint { pose: at.pose, load: Wrench { force, moment }, target, wanted: None, external: None }
    }

    fn checked(&self, at: &Configuration, force: Vector3<f64>, found: &Compensation) -> Result<()> {
        match found.status.is_success() {
            true => Ok(()),
            false => Err(hole(at.pose.translation, Some(force), &found.status.reason(&self.question.machine))),
        }
    }
}

/// What `each` finds at so many `places`, in their order, on the current rayon pool.
///
/// # Errors
/// Of `each`, the first in the order of the places whichever thread was first, and of `work`.
pub(super) fn at_each<T: Send>(
    question: &CorrectionQuestion,
    machines: &Machines,
    places: usize,
    work: &Work,
    each: impl Fn(&mut Loaded<'_>, usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let found = |loaded: &mut Loaded<'_>, place: usize| {
        work.check()?;
        let found = each(loaded, place)?;
        work.tell(Event::Computed(1));
        Ok(found)
    };
    let all: Vec<Result<T>> = (0..places).into_par_iter().map_init(|| Loaded::new(question, machines), found).collect();
    all.into_iter().collect()
}

/// A position without which there is no table.
fn hole(position: Vector3<f64>, force: Option<Vector3<f64>>, reason: &str) -> Error {
    // What is nothing has no sign.
    let shown = |v: Vector3<f64>| v.map(|value| (value * 1e3).round() / 1e3 + 0.0);
    let under = force.filter(|force| *force != Vector3::zeros()).map(shown);
    let under = under.map_or_else(String::new, |f| format!(" under a force of ({:.0}, {:.0}, {:.0}) N", f.x, f.y, f.z));
    let [x, y, z]: [f64; 3] = shown(position).into();
    let problem = format!(
        "there is no correction for P at ({x:.3}, {y:.3}, {z:.3}) mm{under}: {reason}; a table has no holes: expected a smaller box"
    );
    Error::Value { file: Overrides::ORIGIN.into(), key: "box".into(), problem }
}

/// Most points along an axis.
const MOST: usize = 9;

/// What is left at a position of P.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualPoint {
    /// P in O, mm.
    pub position_mm: [f64; 3],
    /// Distance of the tool from where it is wanted, worst over no force and the largest one along each axis, mm: by
    /// [`ResidualPoint::WAYS`].
    pub residual_mm: Vec<f64>,
}

impl ResidualPoint {
    /// Words of tables for the ways to correct, the last only where there is a table for each drive.
    pub const WAYS: [&str; 4] = ["none", "table", "exact", "per_joint"];
}

/// The grid that shows what is left: nodes of the table and the middles of its cells, as far as there are not too many.
pub fn residual_grid(question: &CorrectionQuestion, nodes: &Grid) -> Grid {
    let [min, max] = question.corners;
    Grid::new(min, max, nodes.counts().map(|count| (2 * count - 1).min(MOST)))
}

/// What is left at the points of `grid`, in its order, on the current rayon pool.
///
/// # Errors
/// A position that the machine does not reach, or at which it does not stand. Of `work`.
pub fn residuals(
    question: &CorrectionQuestion,
    answer: &CorrectionAnswer,
    grid: &Grid,
    work: &Work,
) -> Result<Vec<ResidualPoint>> {
    let machines = Machines::new(&question.machine, &question.errors)?;
    work.tell(Event::Stage(Stage { of: "points of the map", items: grid.len() }));
    at_each(question, &machines, grid.len(), work, |loaded, index| {
        let position = grid.position(index);
        let at = loaded.stand(position)?;
        let by = |loaded: &mut Loaded<'_>, corrector: Corrector<'_>| {
            worst(loaded, &at, question, |_, force| Ok(corrector.correction(&at, position, force)))
        };
        let mut residual_mm = vec![
            by(loaded, Corrector::Nothing)?,
            by(loaded, Corrector::Table(&answer.table))?,
            worst(loaded, &at, question, |loaded, force| loaded.exact(&at, force))?,
        ];
        if let Ok((tables, _)) = &answer.per_joint {
            residual_mm.push(by(loaded, Corrector::PerJoint(tables))?);
        }
        Ok(ResidualPoint { position_mm: position.into(), residual_mm })
    })
}

/// The worst over the forces with the drives corrected as `correction` says of each.
fn worst(
    loaded: &mut Loaded<'_>,
    at: &Configuration,
    question: &CorrectionQuestion,
    correction: impl Fn(&mut Loaded<'_>, Vector3<f64>) -> Result<Vec<f64>>,
) -> Result<f64> {
    axis_forces(question.largest_force_N).into_iter().try_fold(0.0, |most: f64, force| {
        let correction = correction(loaded, force)?;
        Ok(most.max(loaded.residual_mm(at, force, &correction)?))
    })
}
