//! What a controller adds to the drives of the rigid machine.

use nalgebra::Vector3;

use super::{CorrectionTable, JointTable};
use crate::machine::Configuration;

/// A way to correct.
#[derive(Debug, Clone, Copy)]
pub enum Corrector<'a> {
    /// Nothing is added.
    Nothing,
    /// A table over positions and forces.
    Table(&'a CorrectionTable),
    /// A table for each drive over its own position.
    PerJoint(&'a [JointTable]),
}

impl Corrector<'_> {
    /// Δρ of each drive where the nominal machine stands `at` a `position` of P (O, mm) under a force on the tool tip (O axes, N), mm
    /// or rad.
    pub fn correction(&self, at: &Configuration, position: Vector3<f64>, force: Vector3<f64>) -> Vec<f64> {
        match self {
            Corrector::Nothing => vec![0.0; at.drives.len()],
            Corrector::Table(table) => table.correction(position, force),
            Corrector::PerJoint(tables) => {
                tables.iter().zip(&at.drives).map(|(table, rho)| table.correction(*rho)).collect()
            }
        }
    }
}
