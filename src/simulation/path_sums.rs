//! What commands leave along a path, summed up point after point.

use serde::{Deserialize, Serialize};

use crate::{machine::Machine, simulation::along_path::PathAnswer};

/// What a command leaves at one point: all that is kept where only sums are wanted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Left {
    /// Why the command does not do what was asked of the method, if it does not.
    failure: Option<Box<str>>,
    /// Whether the machine settles.
    is_settled: bool,
    corrections: usize,
    /// Square of the distance of the compensated point from where it is wanted, mm².
    squared_error: f64,
    /// rad.
    residual_rotation: f64,
}

impl Left {
    /// What `answer` of `machine` leaves.
    pub fn of(answer: &PathAnswer, machine: &Machine) -> Self {
        Self {
            failure: (!answer.status.is_success()).then(|| answer.status.reason(machine).into()),
            is_settled: answer.is_settled,
            corrections: answer.corrections,
            squared_error: answer.position_error.norm_squared(),
            residual_rotation: answer.residual_rotation.norm(),
        }
    }
}

/// Errors along a path. What is taken over solved points is `None` where there are none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathSummary {
    /// Points with a command and an equilibrium.
    pub solved: usize,
    /// All points.
    pub points: usize,
    /// Points whose command failed, or is not as good as asked.
    pub failed: usize,
    /// Why the first of them failed.
    pub first_failure: Option<Box<str>>,
    /// Largest distance of the compensated point from where it is wanted, over the solved points, mm.
    pub max_mm: Option<f64>,
    /// Root mean square of that distance, mm.
    pub rms_mm: Option<f64>,
    /// Corrections per point, mean.
    pub mean_corrections: Option<f64>,
    /// Largest rotation left over, rad.
    pub max_residual_rotation: Option<f64>,
}

/// Sums from which a [`PathSummary`] is made, point after point in the order of the path.
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
    pub fn add(&mut self, left: &Left) {
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

    /// What they come to.
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
