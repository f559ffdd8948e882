//! Newton on the drives ρ themselves, with the exact sensitivities of the loaded machine.

use super::{
    demand::Demand,
    outcome::Status,
    session::{Ending, Progress, Session},
};
use crate::statics::{self, Outcome, equilibrium_at_task};

/// Farther than this share of the machine's reach from the last point, the nominal command is the better start.
const NEAR: f64 = 0.05;

/// Drives and equilibrium in one Newton iteration; where that fails, drives corrected between equilibria.
pub(super) fn compensate(session: &mut Session<'_>, demand: &Demand, progress: &mut Progress) -> Ending {
    let way = demand.pose.translation - session.state.pose.translation;
    if way.norm() > NEAR * session.nominal.reach {
        session.go_to(&demand.pose)?;
        session.settle(demand)?;
    }
    match in_one_iteration(session, demand, progress) {
        Some(outcome) => Ok((Status::Converged, outcome)),
        None => between_equilibria(session, demand, progress),
    }
}

/// `None` if the iteration fails or ends in an unstable equilibrium.
fn in_one_iteration(session: &mut Session<'_>, demand: &Demand, progress: &mut Progress) -> Option<Outcome> {
    let nominal = session.nominal;
    let before = session.task_error(demand).size(nominal);
    let outcome = equilibrium_at_task(
        session.real,
        &|pose| demand.task_error(nominal, pose),
        &mut session.drives,
        &demand.load,
        &mut session.state,
        &mut session.workspace,
        &session.settings.equilibrium,
    )?;
    let error = session.task_error(demand).size(nominal);
    if outcome.status != statics::Status::Solved || error > session.settings.tolerance_mm {
        return None;
    }
    progress.history.extend([before, error]);
    Some(outcome)
}

/// From the nominal command: equilibrium, then drives moved by the sensitivity, and so on.
fn between_equilibria(session: &mut Session<'_>, demand: &Demand, progress: &mut Progress) -> Ending {
    session.go_to(&demand.pose)?;
    loop {
        let outcome = session.settle(demand)?;
        let task = session.task_error(demand);
        if let Some(status) = progress.note(task.size(session.nominal), &session.settings) {
            return Ok((status, outcome));
        }
        let response = task.slope.rows(0, task.count) * &outcome.drive_sensitivity;
        let inverse = response.pseudo_inverse(f64::EPSILON).map_err(|_| Status::Singular)?;
        let correction = inverse * task.error.rows(0, task.count);
        for (rho, change) in session.drives.iter_mut().zip(correction.iter()) {
            *rho -= change;
        }
    }
}
