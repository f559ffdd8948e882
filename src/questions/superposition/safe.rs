//! How far the sources may be scaled until the superposition error exceeds a tolerance.

use serde::{Deserialize, Serialize};

use super::SuperpositionStudy;
use crate::simulation::Failure;

/// The largest factor on a source for which the superposition error stays within the tolerance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum LargestFactor {
    /// The superposition error reaches the tolerance at this factor.
    Reached(f64),
    /// The superposition error stays below the tolerance up to this factor, the largest tried.
    BelowToLimit(f64),
    /// The superposition error stays below the tolerance up to this factor, beyond which the machine has no stable equilibrium.
    NoEquilibrium(f64, Failure),
    /// The location cannot be solved, not even without what is scaled.
    Unsolved(Failure),
}

impl LargestFactor {
    /// Returns the word in tables for what ended the search of the largest factor.
    pub fn status(&self) -> &str {
        match self {
            LargestFactor::Reached(_) => "reached",
            LargestFactor::BelowToLimit(_) => "below_to_limit",
            LargestFactor::NoEquilibrium(..) => "no_equilibrium",
            LargestFactor::Unsolved(failure) => &failure.status,
        }
    }

    /// Returns what ended the search of the largest factor, as a sentence; empty where the tolerance did.
    pub fn reason(&self) -> String {
        match self {
            LargestFactor::Reached(_) => String::new(),
            LargestFactor::BelowToLimit(factor) => {
                format!("the superposition error stays below the tolerance up to factor {factor}, the largest tried")
            }
            LargestFactor::NoEquilibrium(_, failure) => format!("{} beyond it: {}", failure.status, failure.reason),
            LargestFactor::Unsolved(failure) => failure.reason.clone(),
        }
    }

    /// Returns the factor up to which the superposition error stays within the tolerance; `None` where it cannot be solved.
    pub fn factor(&self) -> Option<f64> {
        match self {
            LargestFactor::Reached(factor)
            | LargestFactor::BelowToLimit(factor)
            | LargestFactor::NoEquilibrium(factor, _) => Some(*factor),
            LargestFactor::Unsolved(_) => None,
        }
    }
}

/// Accuracy of a factor: superposition error over tolerance, or, where equilibrium ends, the factor itself, to this share.
const ACCURACY: f64 = 1e-6;
/// Most halvings in search of a factor with a superposition error below the tolerance.
const MAX_HALVINGS: usize = 60;
/// Most evaluations between the two ends of the bracket.
const MAX_STEPS: usize = 80;

/// Upper end of the bracket in which the largest factor lies.
enum UpperEnd {
    /// Superposition error less the tolerance, mm; not negative.
    Exceeded(f64),
    Unsolved(Failure),
}

impl From<Result<f64, Failure>> for UpperEnd {
    /// Returns the end of the bracket where the error exceeds the tolerance by `excess`, mm, or there is no equilibrium.
    fn from(excess: Result<f64, Failure>) -> Self {
        excess.map_or_else(UpperEnd::Unsolved, UpperEnd::Exceeded)
    }
}

/// Finds the factor at which `superposition_error` (mm, as a function of it) first reaches the tolerance of the study.
///
/// It doubles or halves from factor 1, where the error is `at_one`, until the factor is bracketed, then uses false position (Illinois), or
/// halves where the upper end has no equilibrium. It assumes that the error does not pass the tolerance twice within one doubling.
pub(super) fn largest_factor(
    study: &SuperpositionStudy,
    at_one: Result<f64, Failure>,
    superposition_error: impl Fn(f64) -> Result<f64, Failure>,
) -> LargestFactor {
    let excess =
        |factor: f64| superposition_error(factor).map(|superposition_error| superposition_error - study.tolerance);
    let mut factor = 1.0;
    let mut current = at_one.map(|superposition_error| superposition_error - study.tolerance);
    if let Ok(below) = current
        && below < 0.0
    {
        let mut low = (factor, below);
        while low.0 < study.largest_factor {
            let next = (2.0 * low.0).min(study.largest_factor);
            match excess(next) {
                Ok(below) if below < 0.0 => low = (next, below),
                above => return factor_between(low, (next, above.into()), study.tolerance, &excess),
            }
        }
        return LargestFactor::BelowToLimit(low.0);
    }
    if let Err(failure) = &current
        && excess(0.0).is_err()
    {
        // The source that is scaled is not what cannot be solved.
        return LargestFactor::Unsolved(failure.clone());
    }
    for _ in 0..MAX_HALVINGS {
        let half = excess(0.5 * factor);
        if let Ok(below) = half
            && below < 0.0
        {
            return factor_between((0.5 * factor, below), (factor, current.into()), study.tolerance, &excess);
        }
        (factor, current) = (0.5 * factor, half);
    }
    match current {
        Ok(_) => LargestFactor::Reached(factor),
        Err(failure) => LargestFactor::Unsolved(failure),
    }
}

/// Finds the factor of `excess` 0 (error less `tolerance`, mm) between `low` and `high`: factor and excess, that of `low` negative.
fn factor_between(
    mut low: (f64, f64),
    mut high: (f64, UpperEnd),
    tolerance: f64,
    excess: &dyn Fn(f64) -> Result<f64, Failure>,
) -> LargestFactor {
    let mut last_was_low = None;
    for _ in 0..MAX_STEPS {
        let share = match &high.1 {
            UpperEnd::Exceeded(above) => -low.1 / (above - low.1),
            UpperEnd::Unsolved(_) => 0.5,
        };
        if high.0 - low.0 <= ACCURACY * high.0 {
            break;
        }
        let factor = low.0 + share * (high.0 - low.0);
        let excess_there = excess(factor);
        match excess_there {
            Ok(excess) if excess.abs() <= ACCURACY * tolerance => return LargestFactor::Reached(factor),
            Ok(below) if below < 0.0 => {
                low = (factor, below);
                if let (UpperEnd::Exceeded(above), Some(true)) = (&mut high.1, last_was_low) {
                    *above *= 0.5;
                }
                last_was_low = Some(true);
            }
            other => {
                high = (factor, other.into());
                if last_was_low == Some(false) {
                    low.1 *= 0.5;
                }
                last_was_low = Some(false);
            }
        }
    }
    match high.1 {
        UpperEnd::Exceeded(_) => LargestFactor::Reached(low.0),
        UpperEnd::Unsolved(failure) => LargestFactor::NoEquilibrium(low.0, failure),
    }
}
