//! A family of commands followed from a known configuration in steps short enough to stay on its assembly mode.

use super::{
    Configuration, Unreachable,
    closure::{Closure, Command, SearchEnd},
    singularity::Barriers,
};
use crate::machine::Machine;

/// The shortest step, as a share of the whole way.
pub(super) const MIN_STEP: f64 = 1.0 / 1024.0;

/// A search for the nearest configuration goes on as long as each part of it leaves less than this share of the gap.
const CLOSER: f64 = 0.99;

impl Machine {
    /// Follows a one-parameter family of commands from s = 0 (solved by `start`) to s = 1 with adaptive steps, down to `least_step`.
    pub(super) fn follow<'a>(
        &'a self,
        start: &Configuration,
        least_step: f64,
        barriers: Barriers,
        mut solve: impl FnMut(f64, &mut Closure<'a>, &Configuration) -> SearchEnd,
    ) -> SearchEnd {
        let mut closure = Closure::new(self);
        let (mut at, mut s, mut step) = (start.clone(), 0.0, 1.0f64);
        while s < 1.0 {
            let next = f64::min(1.0, s + step);
            let reached = solve(next, &mut closure, &at);
            if reached.solved && !closure.has_passed_singularity(&at, &reached.at, barriers) {
                at = reached.at;
                s = next;
                step *= 2.0;
            } else if step > least_step {
                step *= 0.5;
            } else {
                return SearchEnd { at, solved: false };
            }
        }
        SearchEnd { at, solved: true }
    }

    /// Configuration that a search reached, or why `command` is not met: the chain that closes worst where the search for it stops.
    pub(super) fn result_of(&self, reached: SearchEnd, command: &Command<'_>) -> Result<Configuration, Unreachable> {
        if reached.solved {
            return Ok(reached.at);
        }
        let mut closure = Closure::new(self);
        let (mut nearest, mut gap) = (reached.at, f64::INFINITY);
        for _ in 0..8 {
            nearest = closure.approach(&nearest, command);
            let left = closure.residual.norm();
            if left.is_nan() || left > CLOSER * gap {
                break;
            }
            gap = left;
        }
        Err(closure.why_not(&nearest, command))
    }
}
