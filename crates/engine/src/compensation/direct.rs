//! The direct method: Newton's iteration on the drives ρ, with the exact sensitivities of the loaded machine.
//!
//! Where the drives control more than is compensated (a six-drive machine whose tool tip is compensated), the rest of the
//! command stays as it was: drives, equilibrium and the nominal machine, whose command moves, are found in one iteration; where
//! that fails, the target is shifted between equilibria.

use std::cell::RefCell;

use nalgebra::{DMatrix, Vector6};

use super::{
    batch,
    outcome::CompensationStatus,
    session::{MethodResult, Progress, Session},
    task_point::TaskPoint,
};
use crate::{
    machine::Unreachable,
    spatial::Pose,
    statics::{self, Outcome, TaskError, equilibrium_at_task},
};

/// Farther than this share of the machine's characteristic length from the last point, the nominal command is the better start.
const NEAR: f64 = 0.05;

/// Finds drives and equilibrium in one Newton iteration; where that fails, corrects the target between equilibria.
pub(super) fn compensate(session: &mut Session, task: &TaskPoint, progress: &mut Progress) -> MethodResult {
    if !determines_drives(session, task) {
        return batch::solve_alone(session, task, progress, batch::solve_partial);
    }
    if !is_near_last_point(session, task) {
        session.command_pose(&task.pose)?;
        session.solve_stable(task)?;
    }
    let outcome = solve_together(session, task, progress);
    accept_or_correct(session, task, outcome, progress)
}

/// Whether the task is so near the last equilibrium that a search should start there, and not at the nominal command.
pub(super) fn is_near_last_point(session: &Session, task: &TaskPoint) -> bool {
    let way = task.pose.translation - session.state.pose.translation;
    way.norm() <= NEAR * session.nominal.characteristic_length
}

/// Whether all controlled coordinates are compensated and determine the drives; else some stay as commanded, or drives are redundant.
pub(super) fn determines_drives(session: &Session, task: &TaskPoint) -> bool {
    let nominal = (*session.nominal).clone();
    nominal.redundancy == 0 && task.coordinates(&nominal).count() == nominal.controls.len()
}

/// Whether the machine has one drive for each controlled coordinate, locked ones included.
pub(super) fn has_drive_per_control(session: &Session) -> bool {
    session.nominal.redundancy == 0 && session.nominal.drive_count() == session.nominal.controls.len()
}

/// Accepts `outcome` if it is stable, meets the task and keeps the limits; `Err` beyond a limit; else corrects the target.
pub(super) fn accept_or_correct(
    session: &mut Session,
    task: &TaskPoint,
    outcome: Option<Outcome>,
    progress: &mut Progress,
) -> MethodResult {
    let is_met = |outcome: &Outcome| {
        outcome.status == statics::Status::Solved && session.task_error(task).size() <= session.tolerance_mm()
    };
    if let Some(outcome) = outcome.filter(is_met) {
        // The iteration moves the drives freely: past their travel, and even to where the nominal chains do not close.
        match session.check_limits() {
            Ok(()) => return Ok((CompensationStatus::Converged, outcome)),
            Err(Unreachable::Closure { .. } | Unreachable::OtherMode) => session.reset_to_nominal(task)?,
            Err(limit) => return Err(CompensationStatus::Unreachable(limit)),
        }
    }
    batch::solve_alone(session, task, progress, batch::correct_targets)
}

/// Solves for drives and equilibrium together, from their present values; `None` if the iteration fails. `progress` gets its errors, mm.
fn solve_together(session: &mut Session, task: &TaskPoint, progress: &mut Progress) -> Option<Outcome> {
    let nominal = (*session.nominal).clone();
    let history = RefCell::new(&mut progress.history);
    let residual = |pose: &Pose| {
        let error = task.task_error(&nominal, pose);
        history.borrow_mut().push(error.size());
        error
    };
    equilibrium_at_task(
        &session.actual,
        &residual,
        &mut session.drives,
        &task.load,
        &mut session.state,
        &mut session.scratch,
        &session.settings.equilibrium,
    )
}

/// Shift of the target of a task, as corrected so far.
pub(super) struct TargetShift {
    /// Of each compensated coordinate, mm or rad.
    pub shift: Vector6<f64>,
    changes: DMatrix<f64>,
}

impl TargetShift {
    /// The zero shift of the target of `task`.
    pub(super) fn new(session: &Session, task: &TaskPoint) -> Self {
        Self { shift: Vector6::zeros(), changes: task.control_changes(&session.nominal) }
    }

    /// Corrects the shift by the `residual` at the equilibrium `outcome`; returns the status where the iteration is over instead.
    ///
    /// # Errors
    /// [`CompensationStatus::Singular`]: the compensated coordinates do not follow the drives.
    pub(super) fn correct(
        &mut self,
        session: &Session,
        residual: &TaskError,
        outcome: &Outcome,
        progress: &mut Progress,
    ) -> Result<Option<CompensationStatus>, CompensationStatus> {
        if let Some(status) = session.status_if_over(progress, residual.size()) {
            return Ok(Some(status));
        }
        let by_shift = session.nominal.drive_motions(&session.command, &self.changes);
        let response = residual.slope.rows(0, residual.count)
            * &outcome.drive_sensitivity
            * by_shift.ok_or(CompensationStatus::Singular)?;
        let correction = response.lu().solve(&residual.error.rows(0, residual.count));
        for (value, change) in self.shift.iter_mut().zip(correction.ok_or(CompensationStatus::Singular)?.iter()) {
            *value -= change;
        }
        Ok(None)
    }
}
