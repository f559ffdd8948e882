//! The linear comparator, and the starting value of Figure 3.

use nalgebra::Vector6;

use super::{
    demand::Demand,
    outcome::CompensationStatus,
    session::{Ending, Progress, Session},
};
use crate::statics::{aggregate_errors, unloaded_compliance, unloaded_stiffness};

/// Shift of the target that undoes the linear deflection: `−K_C⁻¹ F`, unloaded at t₀; with `aggregated` also
/// the platform shift by chain errors, eqs. (14), (15).
pub(super) fn shift(
    session: &mut Session,
    demand: &Demand,
    aggregated: bool,
) -> Result<Vector6<f64>, CompensationStatus> {
    session.go_to(&demand.pose)?;
    let (nominal, at) = (&session.nominal, &session.command);
    let load = demand.load.to_vector();
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
    Ok(-(demand.task_error(nominal, &demand.pose).slope * twist))
}

/// Commands the target shifted once by the linear deflection.
pub(super) fn compensate(session: &mut Session, demand: &Demand, progress: &mut Progress) -> Ending {
    let shift = shift(session, demand, false)?;
    let (task, outcome) = session.answer_led(demand, &shift)?;
    progress.history.push(task.size());
    Ok((CompensationStatus::Applied, outcome))
}
