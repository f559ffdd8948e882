//! The direct method: Newton's iteration on the drives ρ, with the exact sensitivities of the loaded machine.
//!
//! Where the drives control more than is compensated (a six-drive machine whose tool tip is compensated), the rest of the
//! command stays as it was, and the target is shifted instead.

use std::cell::RefCell;

use nalgebra::Vector6;

use super::{
    outcome::CompensationStatus,
    session::{Ending, Progress, Session},
    task_point::TaskPoint,
};
use crate::{
    machine::Unreachable,
    spatial::Pose,
    statics::{self, Outcome, equilibrium_at_task},
};

/// Farther than this share of the machine's characteristic length from the last point, the nominal command is the better start.
const NEAR: f64 = 0.05;

/// Finds drives and equilibrium in one Newton iteration; where that fails, corrects the target between equilibria.
pub(super) fn compensate(session: &mut Session, task: &TaskPoint, progress: &mut Progress) -> Ending {
    if !is_near_last_point(session, task) {
        session.command_pose(&task.pose)?;
        session.solve_stable(task)?;
    }
    let outcome = if determines_drives(session, task) { solve_together(session, task, progress) } else { None };
    accept_or_correct(session, task, outcome, progress)
}

/// Whether the last point, rather than the nominal command, is the better start.
pub(super) fn is_near_last_point(session: &Session, task: &TaskPoint) -> bool {
    let way = task.pose.translation - session.state.pose.translation;
    way.norm() <= NEAR * session.nominal.characteristic_length
}

/// Whether all controlled coordinates are compensated and determine the drives; else some stay as commanded, or drives are redundant.
pub(super) fn determines_drives(session: &Session, task: &TaskPoint) -> bool {
    let nominal = (*session.nominal).clone();
    nominal.redundancy == 0 && task.coordinates(&nominal).count() == nominal.controls.len()
}

/// Accepts the equilibrium `outcome` of one iteration if it is stable, within limits and meets the task; else corrects between equilibria.
pub(super) fn accept_or_correct(
    session: &mut Session,
    task: &TaskPoint,
    outcome: Option<Outcome>,
    progress: &mut Progress,
) -> Ending {
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
    progress.history.clear();
    correct_target(session, task, progress)
}

/// Solves for drives and equilibrium together; `None` if the iteration fails.
fn solve_together(session: &mut Session, task: &TaskPoint, progress: &mut Progress) -> Option<Outcome> {
    let nominal = (*session.nominal).clone();
    let history = RefCell::new(&mut progress.history);
    let residual = |pose: &Pose| {
        let error = task.task_error(&nominal, pose);
        history.borrow_mut().push(error.size());
        error
    };
    equilibrium_at_task(
        &session.real,
        &residual,
        &mut session.drives,
        &task.load,
        &mut session.state,
        &mut session.workspace,
        &session.settings.equilibrium,
    )
}

/// Corrects the target by the sensitivities between equilibria, from the nominal command, until the iteration is over.
fn correct_target(session: &mut Session, task: &TaskPoint, progress: &mut Progress) -> Ending {
    let changes = task.control_changes(&session.nominal);
    let mut shift = Vector6::zeros();
    loop {
        let (residual, outcome) = session.simulate_shifted(task, &shift)?;
        if let Some(status) = session.status_if_over(progress, residual.size()) {
            return Ok((status, outcome));
        }
        let by_shift = session.nominal.drive_motions(&session.command, &changes).ok_or(CompensationStatus::Singular)?;
        let response = residual.slope.rows(0, residual.count) * &outcome.drive_sensitivity * by_shift;
        let correction =
            response.lu().solve(&residual.error.rows(0, residual.count)).ok_or(CompensationStatus::Singular)?;
        for (value, change) in shift.iter_mut().zip(correction.iter()) {
            *value -= change;
        }
    }
}
