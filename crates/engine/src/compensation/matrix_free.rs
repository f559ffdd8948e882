//! Eq. (13), the scheme without stiffness matrices, and what it contains: mirroring.

use nalgebra::Vector6;

use super::{
    demand::Demand,
    outcome::CompensationStatus,
    session::{Ending, Progress, Session},
};

/// `t₀^(F)′ = t₀^(F) + α (t₀ − f⁻¹(F | t₀^(F)))`, eq. (13), in the controlled coordinates, from the shift `start`.
pub(super) fn iterate(
    session: &mut Session,
    demand: &Demand,
    alpha: f64,
    start: Vector6<f64>,
    progress: &mut Progress,
) -> Ending {
    let mut shift = start;
    loop {
        let (task, outcome) = session.answer_led(demand, &shift)?;
        if let Some(status) = session.is_over(progress, task.size()) {
            return Ok((status, outcome));
        }
        shift -= task.error * alpha;
    }
}

/// Figure 2: `passes` times, the error of a pass is mirrored at the wanted path. This is eq. (13) with α = 1, stopped
/// early; without a pass it is no compensation.
pub(super) fn mirror(session: &mut Session, demand: &Demand, passes: usize, progress: &mut Progress) -> Ending {
    let mut shift = Vector6::zeros();
    for _ in 0..passes {
        let (task, _) = session.answer_led(demand, &shift)?;
        progress.history.push(task.size());
        shift -= task.error;
    }
    let (task, outcome) = session.answer_led(demand, &shift)?;
    progress.history.push(task.size());
    Ok((CompensationStatus::Applied, outcome))
}
