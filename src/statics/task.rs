//! How far a pose is from what the drives are to achieve.

use nalgebra::{Matrix6, Vector6};

use crate::{
    machine::{Coordinate, Machine},
    spatial::larger,
};

/// Error of the controlled task coordinates at a pose. Rows beyond `count` are zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TaskError {
    /// Number of controlled coordinates.
    pub count: usize,
    /// Actual less wanted: mm, and rad for rotations.
    pub error: Vector6<f64>,
    /// Derivative of the error by the twist of P in O axes.
    pub slope: Matrix6<f64>,
}

impl TaskError {
    /// Largest error in mm, rotations taken at `reach` mm.
    pub fn size(&self, machine: &Machine) -> f64 {
        let sizes = machine.controls.iter().zip(self.error.iter()).map(|(coordinate, error)| match coordinate {
            Coordinate::Translation(_) => error.abs(),
            Coordinate::Rotation(_) => error.abs() * machine.reach,
        });
        sizes.fold(0.0, larger)
    }

    /// Euclidean length of the translational error, mm.
    pub fn distance(&self, machine: &Machine) -> f64 {
        let translations = machine.controls.iter().zip(self.error.iter());
        let squares = translations.filter(|(c, _)| matches!(c, Coordinate::Translation(_))).map(|(_, e)| e * e);
        squares.sum::<f64>().sqrt()
    }
}
