//! Methods that shift the target without derivatives by it: the linear comparator, which starts Figure 3; eq. (13), without matrices; mirroring.

use nalgebra::Vector6;

use super::{
    outcome::CompensationStatus,
    session::{MethodResult, Progress, Session},
    task_point::TaskPoint,
};
use crate::statics::{aggregate_errors, unloaded_compliance, unloaded_stiffness};

/// Iterates `t₀^(F)′ = t₀^(F) + α (t₀ − f⁻¹(F | t₀^(F)))`, eq. (13), in the controlled coordinates, from the shift `start`.
pub(super) fn iterate(
    session: &mut Session,
    task: &TaskPoint,
    alpha: f64,
    start: Vector6<f64>,
    progress: &mut Progress,
) -> MethodResult {
    let mut shift = start;
    loop {
        let (residual, outcome) = session.simulate_tracked(task, &shift)?;
        if let Some(status) = session.status_if_over(progress, residual.size()) {
            return Ok((status, outcome));
        }
        shift -= residual.error * alpha;
    }
}

/// Mirrors the error of a pass at the wanted path `passes` times, Figure 2: eq. (13) with α = 1, stopped early; without a pass, no compensation.
pub(super) fn mirror(session: &mut Session, task: &TaskPoint, passes: usize, progress: &mut Progress) -> MethodResult {
    let mut shift = Vector6::zeros();
    for _ in 0..passes {
        let (residual, _) = session.simulate_tracked(task, &shift)?;
        progress.history.push(residual.size());
        shift -= residual.error;
    }
    let (residual, outcome) = session.simulate_tracked(task, &shift)?;
    progress.history.push(residual.size());
    Ok((CompensationStatus::Applied, outcome))
}

/// Shift of the target that undoes the linear deflection, `−K_C⁻¹ F` unloaded at t₀; if `aggregated`, chain errors too, eqs. (14), (15).
pub(super) fn linear_shift(
    session: &mut Session,
    task: &TaskPoint,
    aggregated: bool,
) -> Result<Vector6<f64>, CompensationStatus> {
    session.command_pose(&task.pose)?;
    let (nominal, at) = (&session.nominal, &session.command);
    let load = task.load.to_vector();
    let mut twist = match unloaded_stiffness(nominal, at, &mut session.scratch) {
        Some(stiffness) => stiffness.lu().solve(&load).ok_or(CompensationStatus::Singular)?,
        // Rigid in some direction.
        None => unloaded_compliance(nominal, at, &mut session.scratch).ok_or(CompensationStatus::Singular)? * load,
    };
    if aggregated {
        let shift =
            aggregate_errors(nominal, &session.actual, at, &mut session.scratch).ok_or(CompensationStatus::Singular)?;
        twist += shift.to_vector();
    }
    let mut linear = twist.fixed_rows_mut::<3>(0);
    linear -= session.aside;
    Ok(-(task.task_error(nominal, &task.pose).slope * twist))
}

/// Commands the target shifted once by the linear deflection and finds the equilibrium there; `progress` gets its error, mm.
pub(super) fn linear(session: &mut Session, task: &TaskPoint, progress: &mut Progress) -> MethodResult {
    let shift = linear_shift(session, task, false)?;
    let (residual, outcome) = session.simulate_tracked(task, &shift)?;
    progress.history.push(residual.size());
    Ok((CompensationStatus::Applied, outcome))
}
