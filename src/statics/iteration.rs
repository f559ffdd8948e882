//! When a Newton iteration is over, and when it is given up.

use super::equilibrium::Settings;

/// A step with a larger rotation than this is not trusted, rad.
const MAX_ROTATION: f64 = 0.5;
/// Rotations after the first step may add up to this fraction of it: more, and the solution may lie on another branch.
const BRANCH: f64 = 0.5;
/// A first rotation below this counts as this, rad: so small a one cannot leave its branch.
const SURE_ROTATION: f64 = 0.02;
/// Residual down to which the iteration may stall on rounding and still count as solved.
const ROUNDING: f64 = 1e-8;

/// Follows the residuals and steps of one iteration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Iteration {
    previous: f64,
    /// Largest rotation of the first step, and the sum of those of later ones, rad.
    first: f64,
    later: f64,
    /// Steps taken.
    pub steps: usize,
}

/// What a residual says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Solved,
    Continue,
    Failed,
}

impl Iteration {
    pub fn new() -> Self {
        Self { previous: f64::INFINITY, first: 0.0, later: 0.0, steps: 0 }
    }

    /// Takes note of the residual before the next step.
    pub fn judge(&mut self, residual: f64, settings: &Settings) -> Verdict {
        let stalled = residual < ROUNDING && residual > 0.5 * self.previous && self.previous < ROUNDING;
        if residual <= settings.tolerance || stalled {
            return Verdict::Solved;
        }
        if !residual.is_finite() || residual > 1e6 * self.previous {
            return Verdict::Failed;
        }
        self.previous = residual;
        Verdict::Continue
    }

    /// Takes note of a step whose largest rotation is `turn` rad; whether it may be taken.
    pub fn accepts(&mut self, turn: f64) -> bool {
        if self.steps == 0 {
            self.first = turn
        } else {
            self.later += turn
        }
        self.steps += 1;
        turn <= MAX_ROTATION && self.later <= BRANCH * self.first.max(SURE_ROTATION)
    }
}
