//! How the superposition error grows with the sources: its exponent as a slope in logarithmic scales.

use serde::{Deserialize, Serialize};

use super::{
    Scaling, SuperpositionStudy,
    superposition_error::{Case, Followed, Sum, SuperpositionErrors},
};
use crate::simulation::{Failure, ROUNDING_MM};

/// Superposition errors at each factor of the study, worst over φ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// Factors, ascending, and superposition errors at each.
    pub steps: Vec<(f64, Result<SuperpositionErrors, Failure>)>,
}

/// A straight line through superposition errors in logarithmic scales: `superposition_error ≈ coefficient · factor^slope`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// Exponent of the factor.
    pub slope: f64,
    /// Superposition error at factor 1, mm.
    pub coefficient_mm: f64,
    /// Number of superposition errors it was fitted to.
    pub points: usize,
    /// Largest ratio between a superposition error and the line, either way, at least 1.
    pub worst_ratio: f64,
}

/// Largest ratio to the line with which superposition errors follow a power of the factor.
const STRAIGHT: f64 = 1.1;

impl Fit {
    /// Whether the fitted superposition errors follow a power of the factor.
    pub fn is_power_law(&self) -> bool {
        self.worst_ratio <= STRAIGHT
    }
}

impl Growth {
    /// Makes the growth at a location that was not solved: `failure` at every factor of the study.
    pub(super) fn unsolved(study: &SuperpositionStudy, failure: &Failure) -> Self {
        Self { steps: study.scales.iter().map(|factor| (*factor, Err(failure.clone()))).collect() }
    }

    /// Returns factor and superposition error, mm, of `sum` at `followed`, where the error is larger than rounding.
    pub fn above_rounding(&self, sum: Sum, followed: Followed) -> Vec<(f64, f64)> {
        let superposition_error = |(factor, errors): &(f64, Result<SuperpositionErrors, Failure>)| {
            let worst = errors.as_ref().ok()?.worst(sum, followed).ok()?;
            (worst.superposition_error_mm > ROUNDING_MM).then_some((*factor, worst.superposition_error_mm))
        };
        self.steps.iter().filter_map(superposition_error).collect()
    }

    /// Fits a line to [`Growth::above_rounding`] in logarithmic scales; `None` with fewer than two superposition errors.
    pub fn fit(&self, sum: Sum, followed: Followed) -> Option<Fit> {
        fit(&self.above_rounding(sum, followed))
    }
}

/// Returns the superposition errors at each factor of the study, by which load, chain errors or both, as `scaled` says, are multiplied.
pub(super) fn measure_growth(case: &Case<'_>, scaled: Scaling) -> Growth {
    let step = |factor: &f64| {
        let (load, errors) = scaled.load_and_error_factors(*factor);
        (*factor, case.superposition_errors(&case.machines_with_errors(errors), load))
    };
    Growth { steps: case.study.scales.iter().map(step).collect() }
}

/// Fits `ln y = ln coefficient + slope · ln x` by least squares to positive pairs with different x; `None` for fewer than two.
pub fn fit(pairs: &[(f64, f64)]) -> Option<Fit> {
    let points = pairs.len();
    if points < 2 {
        return None;
    }
    let logs: Vec<(f64, f64)> = pairs.iter().map(|&(x, y)| (libm::log(x), libm::log(y))).collect();
    let mean = |pick: fn(&(f64, f64)) -> f64| logs.iter().map(pick).sum::<f64>() / points as f64;
    let (middle_x, middle_y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = logs.iter().map(|(x, _)| (x - middle_x).powi(2)).sum();
    let slope = logs.iter().map(|(x, y)| (x - middle_x) * (y - middle_y)).sum::<f64>() / spread;
    let offset = middle_y - slope * middle_x;
    let farthest = logs.iter().map(|(x, y)| (y - offset - slope * x).abs()).fold(0.0, f64::max);
    Some(Fit { slope, coefficient_mm: libm::exp(offset), points, worst_ratio: libm::exp(farthest) })
}
