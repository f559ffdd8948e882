//! State of a Newton search of the closure equations: when it ends, how its steps are damped, and whether it is on the branch of its start.

/// Largest closure error accepted, as a fraction of the machine's characteristic length.
const CLOSURE_TOLERANCE: f64 = 1e-14;
/// Closure error down to which the iteration may stall on rounding and still count as solved.
pub(in crate::machine) const CLOSURE_ROUNDING: f64 = 1e-12;
pub(super) const MAX_ITERATIONS: usize = 12;
/// A solution is on the branch of the start if all later steps together are no longer than this share of the first.
const NEAR: f64 = 0.5;
/// Largest change of a rotation within one continuation step, rad.
pub(super) const MAX_STEP_ROTATION: f64 = 0.5;

/// State of a Newton search: damping, least error and lengths of its steps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search {
    iteration: usize,
    damping: f64,
    /// Least error so far, mm.
    best: f64,
    /// Length of the first step, and of all later ones.
    first_step: f64,
    later_steps: f64,
}

/// Whether a search goes on, has failed or has found a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SearchStatus {
    Continue,
    Failed,
    Solved,
}

impl Search {
    /// A search before its first step.
    pub fn new() -> Self {
        Self { iteration: 0, damping: 1e-12, best: f64::INFINITY, first_step: 0.0, later_steps: 0.0 }
    }

    /// Whether its later steps are too long for a solution near the first-order prediction, on the branch of the start.
    pub fn has_left_branch(&self) -> bool {
        self.iteration > 1 && self.later_steps > NEAR * self.first_step
    }

    /// Judges the search by its largest residual `error`, mm or NaN; `scale` is the characteristic length, mm.
    pub fn judge(&self, error: f64, scale: f64) -> SearchStatus {
        let stalled = error < CLOSURE_ROUNDING * scale && error > 0.3 * self.best;
        match error {
            error if !error.is_finite() => SearchStatus::Failed,
            error if error < CLOSURE_TOLERANCE * scale || stalled => SearchStatus::Solved,
            _ => SearchStatus::Continue,
        }
    }

    /// Returns the damping of the next step: more where `error`, mm, has grown, less where it has fallen.
    pub fn update_damping(&mut self, error: f64) -> f64 {
        let grows = error >= self.best;
        self.damping = if grows { (self.damping * 100.0).max(1e-6) } else { (self.damping * 0.1f64).max(1e-14) };
        self.best = self.best.min(error);
        self.damping
    }

    /// Counts an iteration with a step of this length (all unknowns as mm). The first step is what later ones are held against.
    pub fn record_step(&mut self, length: f64) {
        match self.iteration {
            0 => self.first_step = length,
            _ => self.later_steps += length,
        }
        self.iteration += 1;
    }
}
