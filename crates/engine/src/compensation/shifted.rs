//! Targets shifted without derivatives by the target: the linear comparator, which is the starting value of Figure 3; eq. (13), the scheme
//! without stiffness matrices, and what it contains: mirroring.

use nalgebra::Vector6;

use super::{
    outcome::CompensationStatus,
    session::{Ending, Progress, Session},
    task_point::TaskPoint,
};
use crate::statics::{aggregate_errors, unloaded_compliance, unloaded_stiffness};

/// `t₀^(F)′ = t₀^(F) + α (t₀ − f⁻¹(F | t₀^(F)))`, eq. (13), in the controlled coordinates, from the shift `start`.
pub(super) fn iterate(
    session: &mut Session,
    task: &TaskPoint,
    alpha: f64,
    start: Vector6<f64>,
    progress: &mut Progress,
) -> Ending {
    let mut shift = start;
    loop {
        let (residual, outcome) = session.answer_led(task, &shift)?;
        if let Some(status) = session.is_over(progress, residual.size()) {
            return Ok((status, outcome));
        }
        shift -= residual.error * alpha;
    }
}

/// Figure 2: `passes` times, the error of a pass is mirrored at the wanted path. This is eq. (13) with α = 1, stopped
/// early; without a pass it is no compensation.
pub(super) fn mirror(session: &mut Session, task: &TaskPoint, passes: usize, progress: &mut Progress) -> Ending {
    let mut shift = Vector6::zeros();
    for _ in 0..passes {
        let (residual, _) = session.answer_led(task, &shift)?;
        progress.history.push(residual.size());
        shift -= residual.error;
    }
    let (residual, outcome) = session.answer_led(task, &shift)?;
    progress.history.push(residual.size());
    Ok((CompensationStatus::Applied, outcome))
}

/// Shift of the target that undoes the linear deflection: `−K_C⁻¹ F`, unloaded at t₀; with `aggregated` also
/// the platform shift by chain errors, eqs. (14), (15).
pub(super) fn linear_shift(
    session: &mut Session,
    task: &TaskPoint,
    aggregated: bool,
) -> Result<Vector6<f64>, CompensationStatus> {
    session.go_to(&task.pose)?;
    let (nominal, at) = (&session.nominal, &session.command);
    let load = task.load.to_vector();
    let mut twist = match unloaded_stiffness(nominal, at, &mut session.workspace) {
        Some(stiffness) => stiffness.lu().solve(&load).ok_or(CompensationStatus::Singular)?,
        // Rigid in some direction.
        None => unloaded_compliance(nominal, at, &mut session.workspace).ok_or(CompensationStatus::Singular)? * load,
    };
    if aggregated {
        let shift =
            aggregate_errors(nominal, &session.real, at, &mut session.workspace).ok_or(CompensationStatus::Singular)?;
        twist += shift.to_vector();
    }
    Ok(-(task.task_error(nominal, &task.pose).slope * twist))
}

/// Commands the target shifted once by the linear deflection.
pub(super) fn linear(session: &mut Session, task: &TaskPoint, progress: &mut Progress) -> Ending {
    let shift = linear_shift(session, task, false)?;
    let (residual, outcome) = session.answer_led(task, &shift)?;
    progress.history.push(residual.size());
    Ok((CompensationStatus::Applied, outcome))
}
