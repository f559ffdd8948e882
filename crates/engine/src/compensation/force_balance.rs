//! Force balance, eqs. (8), (9), (12): the modified target at which the wrench that holds the platform at the wanted pose is the load.
//!
//! The machine's drives control n ≤ 6 coordinates, so the platform pose t at which `F = f(t | t₀^(F))` is asked for keeps 6 − n free coordinates:
//! motions of the platform that do not move the compensated point. Unknowns are the shift s of the target and those free coordinates u:
//!
//! ```text
//! [K_t.p. | K_C U] (ds, du) = F − f(t(u) | t₀^(F)(s))
//! ```
//!
//! With n = 6 there is no u and this is eq. (9).

use nalgebra::{Matrix6, Vector6};

use super::{
    outcome::CompensationStatus,
    session::{MethodResult, Progress, Session},
    task_point::TaskPoint,
};
use crate::{
    spatial::{Pose, Twist, rotation_exp},
    statics::{PlatformForce, State, unloaded_stiffness, wrench_at_pose},
};

/// Origin of the iteration's matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MatrixKind {
    /// Exact at every iteration, eqs. (9), (10): `K_t.p. = ∂f/∂ρ · ∂ρ/∂t₀`, by the chains' response and nominal inverse kinematics.
    Exact,
    /// `K_t.p. ≈ −K_C` at the start and then kept, steps multiplied by α, eq. (12).
    Fixed {
        /// Step length.
        alpha: f64,
    },
}

/// Compensates by the force balance, then finds the loaded equilibrium at the command so found; `progress` gets the errors, mm.
pub(super) fn iterate(
    session: &mut Session,
    task: &TaskPoint,
    matrix: MatrixKind,
    progress: &mut Progress,
) -> MethodResult {
    let status = balance_load(session, task, matrix, progress)?;
    let (outcome, failure) = match session.stable_near_state(task) {
        Ok(outcome) => (outcome, None),
        Err(reason) => (session.solve_stable(task)?, Some(reason)),
    };
    let error = session.task_error(task).size();
    if let Some(last) = progress.history.last_mut() {
        *last = error;
    }
    match failure {
        // What is balanced may be unstable: a machine that leaves it for elsewhere is not where it is wanted.
        Some(reason) if status == CompensationStatus::Converged && error > session.tolerance_mm() => Err(reason),
        _ => Ok((status, outcome)),
    }
}

/// Shifts the target until the wrench that holds the platform at the wanted pose is the load; returns how the iteration ended.
fn balance_load(
    session: &mut Session,
    task: &TaskPoint,
    matrix: MatrixKind,
    progress: &mut Progress,
) -> Result<CompensationStatus, CompensationStatus> {
    let nominal = (*session.nominal).clone();
    let mut shift = Vector6::zeros();
    let mut pose = start_pose(session, task)?;
    let mut state: Option<State> = None;
    let mut previous: Option<Linearised> = None;
    loop {
        session.command_pose(&task.shifted_pose(&nominal, &shift))?;
        let mut at = state.take().unwrap_or_else(|| State::rigid(&nominal, &session.command));
        let force = wrench_at_pose(
            &session.actual,
            &session.drives,
            &pose,
            &mut at,
            &mut session.scratch,
            &session.settings.equilibrium,
        );
        let Some(force) = force else { return Err(no_force_status(session)) };
        let unbalanced = task.load.to_vector() - force.wrench.to_vector();
        session.state.clone_from(&at);
        state = Some(at);
        let error = point_displacement(session, task, &force, &unbalanced)?;
        if let Some(status) = session.status_if_over(progress, error) {
            return Ok(status);
        }
        let (linear, alpha) = match (matrix, previous) {
            (MatrixKind::Exact, _) => (Linearised::exact(session, task, &force, &pose)?, 1.0),
            (MatrixKind::Fixed { alpha }, Some(linear)) => (linear, alpha),
            (MatrixKind::Fixed { alpha }, None) => (Linearised::unloaded(session, task, &pose)?, alpha),
        };
        previous = Some(linear);
        let step = linear.matrix.lu().solve(&unbalanced).ok_or(CompensationStatus::Singular)? * alpha;
        let count = task.coordinates(&nominal).count();
        for i in 0..count {
            shift[i] += step[i];
        }
        let mut coordinates = Vector6::zeros();
        for i in count..6 {
            coordinates[i] = step[i];
        }
        pose = moved_within_task(task, session, &pose, &(linear.free * coordinates));
    }
}

/// Pose of P in O at which the iteration starts: the wanted one or, where its rotation is free, the one that the nominal machine takes.
fn start_pose(session: &mut Session, task: &TaskPoint) -> Result<Pose, CompensationStatus> {
    if session.nominal.redundancy == 0 {
        return Ok(task.pose);
    }
    session.command_pose(&task.pose)?;
    Ok(moved_within_task(task, session, &session.command.pose, &Vector6::zeros()))
}

/// Status for a pose at which no wrench holds the platform: rigid, or no equilibrium.
fn no_force_status(session: &mut Session) -> CompensationStatus {
    match unloaded_stiffness(&session.nominal, &session.command, &mut session.scratch) {
        None => CompensationStatus::Rigid,
        Some(_) => CompensationStatus::NoEquilibrium(crate::statics::Status::NotConverged { load_fraction: 0.0 }),
    }
}

/// Displacement of the compensated point, mm, that the `unbalanced` wrench (N, N·mm) would cause: the remaining task error.
fn point_displacement(
    session: &Session,
    task: &TaskPoint,
    force: &PlatformForce,
    unbalanced: &Vector6<f64>,
) -> Result<f64, CompensationStatus> {
    let twist = force.stiffness.lu().solve(unbalanced).ok_or(CompensationStatus::Singular)?;
    let mut residual = session.task_error(task);
    residual.error = residual.slope * twist;
    Ok(residual.size())
}

/// Twists of P that do not change the controlled coordinates, in columns n..6; the first n are zero.
fn free_motions(task: &TaskPoint, session: &Session, pose: &Pose) -> Matrix6<f64> {
    let residual = task.task_error(&session.nominal, pose);
    let mut slope = residual.slope;
    // Rotations at the machine's characteristic length, so that the null space is well scaled.
    slope.fixed_columns_mut::<3>(3).scale_mut(1.0 / session.nominal.characteristic_length);
    let eigen = (slope.transpose() * slope).symmetric_eigen();
    let mut order: Vec<usize> = (0..6).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let mut free = Matrix6::zeros();
    for (column, &least) in order.iter().enumerate().skip(residual.count) {
        let mut twist: Vector6<f64> = eigen.eigenvectors.column(least).into();
        twist.fixed_rows_mut::<3>(3).scale_mut(1.0 / session.nominal.characteristic_length);
        free.set_column(column, &twist);
    }
    free
}

/// Moves `pose` by `twist` (mm, rad in O axes), then back to the wanted controlled coordinates, which a finite twist leaves.
fn moved_within_task(task: &TaskPoint, session: &Session, pose: &Pose, twist: &Vector6<f64>) -> Pose {
    let apply = |pose: &Pose, twist: &Vector6<f64>| {
        let Twist { linear, angular } = Twist::from_vector(twist);
        Pose { rotation: rotation_exp(angular) * pose.rotation, translation: pose.translation + linear }
    };
    let mut moved = apply(pose, twist);
    for _ in 0..3 {
        let residual = task.task_error(&session.nominal, &moved);
        let rows = residual.slope.rows(0, residual.count).into_owned();
        let error = residual.error.rows(0, residual.count).into_owned();
        // Rows of a task slope are independent, so this always has a solution.
        let Ok(inverse) = rows.pseudo_inverse(1e-14) else { return moved };
        let back: Vector6<f64> = Vector6::from_iterator((inverse * error).iter().map(|v| -v));
        moved = apply(&moved, &back);
    }
    moved
}

/// Matrix of a step, and the free motions U that its last columns stand for. They belong together, as the basis of U is arbitrary.
#[derive(Clone, Copy)]
struct Linearised {
    matrix: Matrix6<f64>,
    free: Matrix6<f64>,
}

impl Linearised {
    /// The exact matrix `[K_t.p. | K_C U]` with the platform held at `pose` by `force`; `Err` where the drives cannot shift the target.
    fn exact(
        session: &Session,
        task: &TaskPoint,
        force: &PlatformForce,
        pose: &Pose,
    ) -> Result<Self, CompensationStatus> {
        let free = free_motions(task, session, pose);
        let changes = task.control_changes(&session.nominal);
        let by_shift = session.nominal.drive_motions(&session.command, &changes).ok_or(CompensationStatus::Singular)?;
        let target_stiffness = &force.drive_wrench * by_shift;
        let mut matrix = force.stiffness * free;
        for (column, wrench) in target_stiffness.column_iter().enumerate() {
            matrix.set_column(column, &wrench);
        }
        Ok(Self { matrix, free })
    }

    /// The matrix `[−K_C T | K_C U]`, T the twists of the commanded frame and K_C the unloaded stiffness of the nominal machine.
    fn unloaded(session: &mut Session, task: &TaskPoint, pose: &Pose) -> Result<Self, CompensationStatus> {
        let free = free_motions(task, session, pose);
        let stiffness = unloaded_stiffness(&session.nominal, &session.command, &mut session.scratch)
            .ok_or(CompensationStatus::Rigid)?;
        Ok(Self { matrix: stiffness * (free - task.shift_twists(&session.nominal)), free })
    }
}
