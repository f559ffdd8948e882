//! Convergence of a Newton iteration: when it is solved, and when it has failed.

use super::outcome::Settings;

/// A step with a larger rotation than this is not trusted, rad.
const MAX_ROTATION: f64 = 0.5;
/// Each step may turn by this fraction of the one before. Newton's iteration contracts so where one equilibrium leads to
/// the other without a singular one between them (Kantorovich); slower, the solution may lie on another branch.
const CONTRACTION: f64 = 0.25;
/// A rotation below this counts as this, rad: so small a one cannot leave its branch.
const SURE_ROTATION: f64 = 1e-5;
/// Residual down to which the iteration may stall on rounding and still count as solved.
const ROUNDING: f64 = 1e-8;

/// Residual and step of a Newton iteration, by which its convergence is judged.
#[derive(Debug, Clone, Copy)]
pub(super) struct Iteration {
    previous: f64,
    /// Largest rotation of the last step, rad.
    turn: f64,
    /// Steps taken.
    pub steps: usize,
}

/// IterationStatus on an iteration by its residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum IterationStatus {
    Solved,
    Continue,
    Failed,
}

impl Iteration {
    /// An iteration before its first residual.
    pub fn new() -> Self {
        Self { previous: f64::INFINITY, turn: f64::INFINITY, steps: 0 }
    }

    /// Judges the residual before the next step (dimensionless) and records it.
    pub fn judge(&mut self, residual: f64, settings: &Settings) -> IterationStatus {
        let stalled = residual < ROUNDING && residual > 0.5 * self.previous && self.previous < ROUNDING;
        if residual <= settings.tolerance || stalled {
            return IterationStatus::Solved;
        }
        if !residual.is_finite() || residual > 1e6 * self.previous {
            return IterationStatus::Failed;
        }
        self.previous = residual;
        IterationStatus::Continue
    }

    /// Records a step whose largest rotation is `turn` rad; returns whether it is small enough to be taken.
    pub fn accept_step(&mut self, turn: f64) -> bool {
        let contracts = turn <= CONTRACTION * self.turn.max(SURE_ROTATION);
        self.turn = turn;
        self.steps += 1;
        turn <= MAX_ROTATION && contracts
    }
}
