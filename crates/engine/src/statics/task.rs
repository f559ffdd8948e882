//! How far a pose is from what the drives are to achieve.

use nalgebra::{Matrix6, Vector6};
use serde::Serialize;

/// Error of the task coordinates that are put right, at a pose. Rows beyond `count` are zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TaskError {
    /// Number of coordinates put right.
    pub count: usize,
    /// Actual less wanted: mm, and rad for rotations.
    pub error: Vector6<f64>,
    /// Derivative of the error by the twist of P in O axes.
    pub slope: Matrix6<f64>,
    /// What makes each error a length: 1, or the machine's reach in mm for rotations.
    pub lever: Vector6<f64>,
}

impl TaskError {
    /// Length of the error in mm, rotations taken at the machine's reach.
    pub fn size(&self) -> f64 {
        let mut square = 0.0;
        for i in 0..6 {
            let length = self.error[i] * self.lever[i];
            square += length * length;
        }
        square.sqrt()
    }
}
