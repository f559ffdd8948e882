//! What a correction within limits leaves of a feature's errors.

use nalgebra::Vector3;

use super::{
    FeatureJob,
    metric::{Metric, Metrics},
};
use crate::{compensation::Demand, machine::Machine, simulation::within_limits};

/// Sums and extremes of the errors left.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Corrected {
    worst: f64,
    /// Σ share · error².
    squares: f64,
    /// Share of the path within tolerance.
    within: f64,
}

impl Corrected {
    /// Nothing is left: the best there can be.
    pub fn perfect() -> Self {
        Self { within: 1.0, ..Self::default() }
    }

    /// Both together.
    pub fn merged(&self, other: &Self) -> Self {
        Self {
            worst: self.worst.max(other.worst),
            squares: self.squares + other.squares,
            within: self.within + other.within,
        }
    }

    /// Of paths that make up `share` of the length of all.
    pub fn normalised(&self, share: f64) -> Self {
        Self { worst: self.worst, squares: self.squares / share, within: self.within / share }
    }

    /// Writes the metrics.
    pub fn enter(&self, metrics: &mut Metrics) {
        metrics.set(Metric::WorstResidual, self.worst);
        metrics.set(Metric::RmsResidual, self.squares.sqrt());
        metrics.set(Metric::ShareWithinCorrected, self.within);
    }

    /// Removes the metrics.
    pub fn forget(metrics: &mut Metrics) {
        for metric in Metric::ALL.into_iter().filter(|metric| metric.is_bounded()) {
            metrics.clear(metric);
        }
    }
}

/// Corrects a feature's path within its limits. `shares`: each point's share in the length of all paths.
///
/// # Errors
/// Why there is no such correction.
pub(super) fn correct(
    nominal: &Machine,
    real: &Machine,
    demands: &[Demand],
    job: &FeatureJob,
    shares: &[f64],
) -> Result<Corrected, String> {
    let errors = errors_left(nominal, real, demands, job)?;
    let mut left = Corrected::default();
    for (k, (error, share)) in errors.iter().zip(shares).enumerate().filter(|(_, (_, share))| **share > 0.0) {
        let Some(error) = error else {
            return Err(format!("point {k} has no correction within the limits"));
        };
        let error = error.norm();
        left.worst = left.worst.max(error);
        left.squares += share * error * error;
        if error <= job.feature.tolerance_mm {
            left.within += share;
        }
    }
    Ok(left)
}

/// Position error that the correction within limits leaves at each point, O axes, mm; `None` at points left out.
///
/// # Errors
/// Why there is no such correction.
pub(super) fn errors_left(
    nominal: &Machine,
    real: &Machine,
    demands: &[Demand],
    job: &FeatureJob,
) -> Result<Vec<Option<Vector3<f64>>>, String> {
    let path = within_limits::correct(nominal, real, demands, &job.limits).map_err(|error| error.to_string())?;
    Ok(path.points.iter().map(|point| point.corrected().map(|point| point.position_error)).collect())
}
