//! Mobility and over-constraint of the rigid machine.

use nalgebra::DMatrix;

use super::{Configuration, Machine};

/// Counts of the rigid machine at a configuration, from the ranks of its closure equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mobility {
    /// Number of independent motions of the whole mechanism (mobility).
    pub mechanism: usize,
    /// Number of independent twists of the platform.
    pub platform: usize,
    /// Number of closure equations that are implied by the others: internal wrenches a rigid machine could carry.
    pub over_constraint: usize,
    /// Number of motions left when all drives are locked: 0 unless the configuration is singular or a joint is idle.
    pub uncontrolled: usize,
}

/// A singular value below this fraction of the largest counts as zero.
const RANK_TOLERANCE: f64 = 1e-9;

impl Machine {
    /// Mobility at `at`, with joints that have springs counted as free.
    pub fn mobility(&self, at: &Configuration) -> Mobility {
        let jacobian = self.closure_jacobian(at);
        let (equations, unknowns) = jacobian.shape();
        let rank = rank(&jacobian);
        // A platform twist is independent of the others if fixing the platform removes it.
        let joints_only = jacobian.columns(6, unknowns - 6).into_owned();
        let platform = (unknowns - rank) - (unknowns - 6 - self::rank(&joints_only));
        let mut locked = jacobian.clone();
        locked.columns_mut(6, self.drive_count()).fill(0.0);
        let uncontrolled = unknowns - self.drive_count() - self::rank(&locked);
        Mobility { mechanism: unknowns - rank, platform, over_constraint: equations - rank, uncontrolled }
    }
}

fn rank(matrix: &DMatrix<f64>) -> usize {
    let values = matrix.singular_values();
    let largest = values.amax();
    values.iter().filter(|&&value| value > RANK_TOLERANCE * largest).count()
}
