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

/// Steps along a way, as shares of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    done: f64,
    step: f64,
    least: f64,
}

impl Steps {
    /// Steps of a way not begun; none is much shorter than `least`.
    pub fn new(least: f64) -> Self {
        Self { done: 0.0, step: 1.0, least }
    }

    /// Where the next step ends.
    pub fn next_end(&self) -> f64 {
        f64::min(1.0, self.done + self.step)
    }

    /// Takes the step if `is_taken`, doubling the next one, or else halves it; returns whether there is another step to try.
    pub fn advance_or_halve(&mut self, is_taken: bool) -> bool {
        match is_taken {
            true => (self.done, self.step) = (self.next_end(), 2.0 * self.step),
            false if self.step > self.least => self.step *= 0.5,
            false => return false,
        }
        !self.is_complete()
    }

    /// Whether the whole way is done.
    pub fn is_complete(&self) -> bool {
        self.done >= 1.0
    }
}

impl Machine {
    /// Follows commands, searched by `solve`, from s = 0 (met by `start`) to 1 in adaptive steps down to `least_step`; returns its end.
    pub(super) fn follow<'a>(
        &'a self,
        start: &Configuration,
        least_step: f64,
        barriers: Barriers,
        mut solve: impl FnMut(f64, &mut Closure<'a>, &Configuration) -> SearchEnd,
    ) -> SearchEnd {
        let mut closure = Closure::new(self);
        let (mut at, mut steps) = (start.clone(), Steps::new(least_step));
        loop {
            let reached = solve(steps.next_end(), &mut closure, &at);
            let is_taken = reached.solved && !closure.has_passed_singularity(&at, &reached.at, barriers);
            if is_taken {
                at = reached.at;
            }
            if !steps.advance_or_halve(is_taken) {
                return SearchEnd { at, solved: steps.is_complete() };
            }
        }
    }

    /// Concludes a search: the configuration that it reached or, as `Err`, why `command` is not met (the chain that closes worst).
    pub(super) fn conclude(&self, reached: SearchEnd, command: &Command<'_>) -> Result<Configuration, Unreachable> {
        if reached.solved {
            return Ok(reached.at);
        }
        let mut closure = Closure::new(self);
        let (mut nearest, mut gap) = (reached.at, f64::INFINITY);
        for _ in 0..8 {
            nearest = closure.approach(&nearest, command);
            let residual = closure.residual.norm();
            if residual.is_nan() || residual > CLOSER * gap {
                break;
            }
            gap = residual;
        }
        Err(closure.failure_reason(&nearest, command))
    }
}
