//! How far the sources may be scaled before superposition departs by more than a tolerance.

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
    /// Word used in tables.
    pub fn status(&self) -> &str {
        match self {
            LargestFactor::Reached(_) => "reached",
            LargestFactor::BelowToLimit(_) => "below_to_limit",
            LargestFactor::NoEquilibrium(..) => "no_equilibrium",
            LargestFactor::Unsolved(failure) => &failure.status,
        }
    }

    /// What ended the search, in words; empty where the tolerance did.
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

    /// The factor up to which the superposition error is known to stay within the tolerance.
    pub fn factor(&self) -> Option<f64> {
        match self {
            LargestFactor::Reached(factor)
            | LargestFactor::BelowToLimit(factor)
            | LargestFactor::NoEquilibrium(factor, _) => Some(*factor),
            LargestFactor::Unsolved(_) => None,
        }
    }
}

/// A factor counts as found when the superposition error differs from the tolerance by less than this share of it, or, where the
/// equilibrium ends, when it is known to this share of itself.
const ACCURACY: f64 = 1e-6;
/// Most halvings in search of a factor at which the superposition error is below the tolerance.
const MOST_HALVINGS: usize = 60;
/// Most evaluations within the bracket.
const MOST_STEPS: usize = 80;

/// The upper end of the bracket.
enum Above {
    /// The superposition error less the tolerance, mm; not negative.
    Exceeded(f64),
    Unsolved(Failure),
}

impl From<Result<f64, Failure>> for Above {
    fn from(excess: Result<f64, Failure>) -> Self {
        excess.map_or_else(Above::Unsolved, Above::Exceeded)
    }
}

/// The factor at which `superposition_error` (mm, of a factor) first reaches the tolerance of the study.
///
/// Sought from factor 1, where it is `at_one`, by doubling or halving until the factor lies between one that keeps within
/// the tolerance and one that does not, then by false position (Illinois), or by halving where the upper end has no
/// equilibrium. As superposition errors vanish with their sources, there is a factor below; that the superposition error does not pass the
/// tolerance twice within one doubling is assumed.
pub(super) fn largest(
    study: &SuperpositionStudy,
    at_one: Result<f64, Failure>,
    superposition_error: impl Fn(f64) -> Result<f64, Failure>,
) -> LargestFactor {
    let excess =
        |factor: f64| superposition_error(factor).map(|superposition_error| superposition_error - study.tolerance);
    let mut factor = 1.0;
    let mut found = at_one.map(|superposition_error| superposition_error - study.tolerance);
    if let Ok(below) = found
        && below < 0.0
    {
        let mut low = (factor, below);
        while low.0 < study.largest_factor {
            let next = (2.0 * low.0).min(study.largest_factor);
            match excess(next) {
                Ok(below) if below < 0.0 => low = (next, below),
                above => return within(low, (next, above.into()), study.tolerance, &excess),
            }
        }
        return LargestFactor::BelowToLimit(low.0);
    }
    if let Err(failure) = &found
        && excess(0.0).is_err()
    {
        // The source that is scaled is not what cannot be solved.
        return LargestFactor::Unsolved(failure.clone());
    }
    for _ in 0..MOST_HALVINGS {
        let half = excess(0.5 * factor);
        if let Ok(below) = half
            && below < 0.0
        {
            return within((0.5 * factor, below), (factor, found.into()), study.tolerance, &excess);
        }
        (factor, found) = (0.5 * factor, half);
    }
    match found {
        Ok(_) => LargestFactor::Reached(factor),
        Err(failure) => LargestFactor::Unsolved(failure),
    }
}

/// The factor between `low`, with its (negative) excess, and `high`.
fn within(
    mut low: (f64, f64),
    mut high: (f64, Above),
    tolerance: f64,
    excess: &dyn Fn(f64) -> Result<f64, Failure>,
) -> LargestFactor {
    let mut last_was_low = None;
    for _ in 0..MOST_STEPS {
        let share = match &high.1 {
            Above::Exceeded(above) => -low.1 / (above - low.1),
            Above::Unsolved(_) => 0.5,
        };
        if high.0 - low.0 <= ACCURACY * high.0 {
            break;
        }
        let factor = low.0 + share * (high.0 - low.0);
        let found = excess(factor);
        match found {
            Ok(excess) if excess.abs() <= ACCURACY * tolerance => return LargestFactor::Reached(factor),
            Ok(below) if below < 0.0 => {
                low = (factor, below);
                if let (Above::Exceeded(above), Some(true)) = (&mut high.1, last_was_low) {
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
        Above::Exceeded(_) => LargestFactor::Reached(low.0),
        Above::Unsolved(failure) => LargestFactor::NoEquilibrium(low.0, failure),
    }
}
