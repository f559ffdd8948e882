//! Compensation: the drive commands that bring the loaded tool to its target.
//!
//! A [`Session`] holds the nominal machine, by which commands are computed, and the actual one, which is simulated. A [`TaskPoint`] says what
//! is wanted at a point, a [`Method`] how the command is found; every method returns the same [`Compensation`]; [`compensate_batch`] and
//! [`simulate_batch`] serve several sessions at a time. Where the drives are limited, [`compensate_bounded`] corrects a whole path at once.

mod batch;
mod bounded;
mod direct;
mod force_balance;
mod outcome;
mod session;
mod shifted;
mod task_point;
mod workpiece;

use nalgebra::Vector6;
use serde::Serialize;

use crate::spatial::Pose;

pub use batch::{compensate_batch, find_targets, simulate_batch};
pub use bounded::{
    Binding, BoundedError, BoundedPath, BoundedPoint, BoundedSettings, BoundedStatus, BoundedSummary, CorrectedPoint,
    ErrorNorm, Errors, LimitKind, Limits, Price, Side, compensate_bounded,
};
pub use outcome::{Compensation, CompensationStatus};
pub use session::{CompensationSettings, Session};
use session::{MethodResult, Progress};
pub use task_point::{Target, TaskPoint};

/// Method by which a command is found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum Method {
    /// The nominal command: no compensation.
    None,
    /// The target shifted by the linear deflection `−K_C⁻¹ F`.
    Linear,
    /// The error of a pass mirrored at the wanted path, Figure 2, this many times; each pass is simulated.
    Mirror {
        /// Passes that are measured and mirrored.
        passes: usize,
    },
    /// Eq. (13): no matrices, step length α in (0, 1].
    MatrixFree {
        /// Step length.
        alpha: f64,
    },
    /// Eq. (12): stiffness matrix of the start, step length α in (0, 1].
    FixedMatrix {
        /// Step length.
        alpha: f64,
    },
    /// Eqs. (9)–(11): Newton on the target with the exact K_t.p.
    Newton,
    /// Newton on the drives.
    Direct,
    /// Figure 3: linear deflection and aggregated chain errors, eqs. (14), (15), as the starting value of eq. (13).
    Procedure {
        /// Step length.
        alpha: f64,
    },
}

/// Largest number of passes that can be mirrored.
const MAX_PASSES: usize = 100;

impl Method {
    /// All methods with their usual parameters, in the order of tables: comparators first.
    pub const ALL: [Method; 9] = [
        Method::None,
        Method::Linear,
        Method::Mirror { passes: 1 },
        Method::Mirror { passes: 3 },
        Method::MatrixFree { alpha: 1.0 },
        Method::FixedMatrix { alpha: 1.0 },
        Method::Procedure { alpha: 1.0 },
        Method::Newton,
        Method::Direct,
    ];

    /// The method called `name` in a command or file, with step length `alpha` where it has one; `mirror_N` mirrors N passes, 1 to 100. `None` for
    /// other names.
    pub fn named(name: &str, alpha: f64) -> Option<Self> {
        if let Some(passes) = name.strip_prefix("mirror_").and_then(|count| count.parse().ok()) {
            return (1..=MAX_PASSES).contains(&passes).then_some(Method::Mirror { passes });
        }
        let with_alpha = |method| match method {
            Method::MatrixFree { .. } => Method::MatrixFree { alpha },
            Method::FixedMatrix { .. } => Method::FixedMatrix { alpha },
            Method::Procedure { .. } => Method::Procedure { alpha },
            other => other,
        };
        Self::ALL.into_iter().find(|method| method.label() == name).map(with_alpha)
    }

    /// Word used in tables and commands.
    pub fn label(self) -> String {
        match self {
            Method::None => "none".into(),
            Method::Linear => "linear".into(),
            Method::Mirror { passes: 1 } => "mirror".into(),
            Method::Mirror { passes } => format!("mirror_{passes}"),
            Method::MatrixFree { .. } => "matrix_free".into(),
            Method::FixedMatrix { .. } => "fixed_matrix".into(),
            Method::Procedure { .. } => "procedure".into(),
            Method::Newton => "newton".into(),
            Method::Direct => "direct".into(),
        }
    }

    /// Whether the method has a step length α.
    pub fn has_step_length(self) -> bool {
        self.step_length().is_some()
    }

    /// Step length of the methods that have one; `None` for others.
    fn step_length(self) -> Option<f64> {
        match self {
            Method::MatrixFree { alpha } | Method::FixedMatrix { alpha } | Method::Procedure { alpha } => Some(alpha),
            _ => None,
        }
    }
}

/// Finds the command for `task` by `method`, from the present state of `session`, which is left at the compensated equilibrium.
pub fn compensate(session: &mut Session, task: &TaskPoint, method: Method) -> Compensation {
    run_with_wanted(session, task, |session, task| {
        let mut progress = Progress::new();
        let ending = run_method(session, task, method, &mut progress);
        (ending, progress.history)
    })
}

/// Resolves the wanted pose of `task` and concludes with the ending and errors (mm) that `solve` returns; refuses the task without one.
fn run_with_wanted(
    session: &mut Session,
    task: &TaskPoint,
    solve: impl FnOnce(&mut Session, &TaskPoint) -> (MethodResult, Vec<f64>),
) -> Compensation {
    match session.with_wanted_pose(task) {
        Ok(task) => {
            let (ending, history) = solve(session, &task);
            session.conclude(&task, ending, history)
        }
        Err(status) => session.refused(task, status),
    }
}

/// Commands the pose `target` of P in O instead of that of `task` and finds the equilibrium under its load, as a finished program does.
pub fn simulate(session: &mut Session, task: &TaskPoint, target: &Pose) -> Compensation {
    run_with_wanted(session, task, |session, task| {
        let ending =
            session.command_pose(target).and_then(|()| Ok((CompensationStatus::Applied, session.solve_stable(task)?)));
        (ending, vec![session.task_error(task).size()])
    })
}

/// Commands `drives` (mm or rad, machine order) without checking any limit and finds the equilibrium under the load of `task`.
pub fn simulate_drives(session: &mut Session, task: &TaskPoint, drives: &[f64]) -> Compensation {
    run_with_wanted(session, task, |session, task| {
        let ending = session.command_pose(&task.pose).and_then(|()| {
            session.drives.copy_from_slice(drives);
            Ok((CompensationStatus::Applied, session.solve_stable(task)?))
        });
        (ending, vec![session.task_error(task).size()])
    })
}

/// Runs `method` on `task`, whose wanted pose is known; refuses a step length outside (0, 1].
fn run_method(session: &mut Session, task: &TaskPoint, method: Method, progress: &mut Progress) -> MethodResult {
    if let Some(alpha) = method.step_length().filter(|alpha| !(*alpha > 0.0 && *alpha <= 1.0)) {
        return Err(CompensationStatus::BadStepLength { alpha });
    }
    match method {
        Method::None => shifted::mirror(session, task, 0, progress),
        Method::Linear => shifted::linear(session, task, progress),
        Method::Mirror { passes } => shifted::mirror(session, task, passes, progress),
        Method::MatrixFree { alpha } => shifted::iterate(session, task, alpha, Vector6::zeros(), progress),
        Method::FixedMatrix { alpha } => {
            force_balance::iterate(session, task, force_balance::MatrixKind::Fixed { alpha }, progress)
        }
        Method::Newton => force_balance::iterate(session, task, force_balance::MatrixKind::Exact, progress),
        Method::Direct => direct::compensate(session, task, progress),
        Method::Procedure { alpha } => {
            let start = shifted::linear_shift(session, task, true)?;
            shifted::iterate(session, task, alpha, start, progress)
        }
    }
}
