//! Sums of residual errors along a path, point by point.

use serde::{Deserialize, Serialize};

use crate::{machine::Machine, simulation::along_path::PathPointResult};

/// Residual error of a command at one point, without the rest of its result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointResidual {
    /// Reason why the command is not as good as requested, if so.
    failure: Option<Box<str>>,
    /// Whether the machine has an equilibrium.
    is_settled: bool,
    /// Number of corrections made.
    corrections: usize,
    /// Squared distance of the compensated point from where it is wanted, mm².
    squared_error: f64,
    /// Residual rotation, rad.
    residual_rotation: f64,
}

impl PointResidual {
    /// Returns the residual error of `answer`, a result on `machine`.
    pub fn of(answer: &PathPointResult, machine: &Machine) -> Self {
        Self {
            failure: (!answer.status.is_success()).then(|| answer.status.reason(machine).into()),
            is_settled: answer.is_settled,
            corrections: answer.corrections,
            squared_error: answer.position_error.norm_squared(),
            residual_rotation: answer.residual_rotation.norm(),
        }
    }
}

/// Residual errors along a path; those over solved points are `None` where there are none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathSummary {
    /// Number of points with a command and an equilibrium.
    pub solved: usize,
    /// Number of all points.
    pub points: usize,
    /// Number of points whose command failed, or is not as good as requested.
    pub failed: usize,
    /// Reason why the first of them failed.
    pub first_failure: Option<Box<str>>,
    /// Largest distance of the compensated point from where it is wanted, over the solved points, mm.
    pub max_mm: Option<f64>,
    /// Root mean square of that distance, mm.
    pub rms_mm: Option<f64>,
    /// Mean number of corrections per point.
    pub mean_corrections: Option<f64>,
    /// Largest residual rotation, rad.
    pub max_residual_rotation: Option<f64>,
}

/// Sums for a [`PathSummary`], to which points are added in path order.
#[derive(Debug, Clone, Default)]
pub struct PathSums {
    solved: usize,
    points: usize,
    failed: usize,
    first_failure: Option<Box<str>>,
    squared_errors: f64,
    largest_squared_error: f64,
    corrections: usize,
    max_residual_rotation: f64,
}

impl PathSums {
    /// Adds a point.
    pub fn add(&mut self, left: &PointResidual) {
        self.points += 1;
        self.failed += usize::from(left.failure.is_some());
        if self.first_failure.is_none() {
            self.first_failure.clone_from(&left.failure);
        }
        if left.is_settled {
            self.solved += 1;
            self.squared_errors += left.squared_error;
            self.largest_squared_error = self.largest_squared_error.max(left.squared_error);
            self.corrections += left.corrections;
            self.max_residual_rotation = self.max_residual_rotation.max(left.residual_rotation);
        }
    }

    /// Returns the summary of the points added.
    pub fn summary(&self) -> PathSummary {
        let known = |value: f64| (self.solved > 0).then_some(value);
        let mean = |sum: f64| sum / self.solved as f64;
        PathSummary {
            solved: self.solved,
            points: self.points,
            failed: self.failed,
            first_failure: self.first_failure.clone(),
            max_mm: known(self.largest_squared_error.sqrt()),
            rms_mm: known(mean(self.squared_errors).sqrt()),
            mean_corrections: known(mean(self.corrections as f64)),
            max_residual_rotation: known(self.max_residual_rotation),
        }
    }
}
