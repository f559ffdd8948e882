//! How the superposition error grows with the sources: its exponent as a slope in logarithmic scales.

use serde::{Deserialize, Serialize};

use super::{
    Scaled, SuperpositionStudy,
    superposition_error::{Case, Followed, Sum, SuperpositionErrors},
};
use crate::simulation::{Failure, ROUNDING_MM};

/// Superposition errors at each factor of the study, worst over φ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// Factor and superposition errors, ascending.
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
    /// Largest ratio between a superposition error and the line, either way; 1 where all lie on it.
    pub worst_ratio: f64,
}

/// Superposition errors that lie off the fitted line by more than this ratio do not follow a power of the factor.
const STRAIGHT: f64 = 1.1;

impl Fit {
    /// Whether the superposition errors follow a power of the factor.
    pub fn is_power_law(&self) -> bool {
        self.worst_ratio <= STRAIGHT
    }
}

impl Growth {
    /// The same failure at every factor.
    pub(super) fn unsolved(study: &SuperpositionStudy, failure: &Failure) -> Self {
        Self { steps: study.scales.iter().map(|factor| (*factor, Err(failure.clone()))).collect() }
    }

    /// Factors and superposition errors of `sum` at `followed` that are larger than rounding.
    pub fn measured(&self, sum: Sum, followed: Followed) -> Vec<(f64, f64)> {
        let superposition_error = |(factor, found): &(f64, Result<SuperpositionErrors, Failure>)| {
            let worst = found.as_ref().ok()?.worst(sum, followed).ok()?;
            (worst.superposition_error_mm > ROUNDING_MM).then_some((*factor, worst.superposition_error_mm))
        };
        self.steps.iter().filter_map(superposition_error).collect()
    }

    /// The line through [`Growth::measured`]; `None` with fewer than two superposition errors.
    pub fn fit(&self, sum: Sum, followed: Followed) -> Option<Fit> {
        fit(&self.measured(sum, followed))
    }
}

pub(super) fn measure(case: &Case<'_>, scaled: Scaled) -> Growth {
    let step = |factor: &f64| {
        let (load, errors) = scaled.factors(*factor);
        (*factor, case.superposition_errors(&case.real(errors), load))
    };
    Growth { steps: case.study.scales.iter().map(step).collect() }
}

/// Least squares of `ln y = ln coefficient + slope · ln x` over positive pairs with different x; `None` for fewer than two.
pub fn fit(pairs: &[(f64, f64)]) -> Option<Fit> {
    let points = pairs.len();
    if points < 2 {
        return None;
    }
    let logs: Vec<(f64, f64)> = pairs.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |pick: fn(&(f64, f64)) -> f64| logs.iter().map(pick).sum::<f64>() / points as f64;
    let (middle_x, middle_y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = logs.iter().map(|(x, _)| (x - middle_x).powi(2)).sum();
    let slope = logs.iter().map(|(x, y)| (x - middle_x) * (y - middle_y)).sum::<f64>() / spread;
    let offset = middle_y - slope * middle_x;
    let farthest = logs.iter().map(|(x, y)| (y - offset - slope * x).abs()).fold(0.0, f64::max);
    Some(Fit { slope, coefficient_mm: offset.exp(), points, worst_ratio: farthest.exp() })
}
