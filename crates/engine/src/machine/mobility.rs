//! Mobility and over-constraint of the rigid machine.

use nalgebra::DMatrix;
use serde::Serialize;

use super::{Configuration, Coordinate, Machine};
use crate::spatial::{RankRevealing, rank};

/// Counts of the rigid machine at a configuration, from the ranks of its closure equations.
#[derive(Default, Debug, Clone, Copy, PartialEq, Eq, Serialize)]
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

/// A pivot below this fraction of the largest counts as zero.
const RANK_TOLERANCE: f64 = 1e-9;

impl Machine {
    /// Mobility at `at`, with joints that have springs counted as free.
    pub fn mobility(&self, at: &Configuration) -> Mobility {
        let jacobian = self.closure_jacobian(at);
        let (equations, unknowns) = jacobian.shape();
        let rank_of = |matrix: &DMatrix<f64>| rank(matrix, RANK_TOLERANCE);
        let rank = rank_of(&jacobian);
        // A platform twist is independent of the others if fixing the platform removes it.
        let joints_only = jacobian.columns(6, unknowns - 6).into_owned();
        let platform = (unknowns - rank) - (unknowns - 6 - rank_of(&joints_only));
        let mut locked = jacobian.clone();
        locked.columns_mut(6, self.drive_count()).fill(0.0);
        let uncontrolled = unknowns - self.drive_count() - rank_of(&locked);
        Mobility { mechanism: unknowns - rank, platform, over_constraint: equations - rank, uncontrolled }
    }
}

impl Machine {
    /// Coordinates of the platform that the drives can control independently of each other at `at`: translations first.
    pub fn controllable_axes(&self, at: &Configuration) -> Vec<Coordinate> {
        let all = (0..3).map(Coordinate::Translation).chain((0..3).map(Coordinate::Rotation));
        let motions = self.platform_motions(at);
        let mut chosen: Vec<Coordinate> = Vec::new();
        for coordinate in all {
            chosen.push(coordinate);
            if self.independent_count(&chosen, &motions, at) < chosen.len() {
                chosen.pop();
            }
        }
        chosen
    }

    /// Number of controlled coordinates that the drives can control independently of each other at `at`.
    pub fn controlled_count(&self, at: &Configuration) -> usize {
        self.independent_count(&self.controls, &self.platform_motions(at), at)
    }

    /// Largest rotation of the platform that the drives do not control, as a share of a motion of the whole mechanism at `at`.
    pub(super) fn uncontrolled_turn(&self, at: &Configuration) -> f64 {
        let motions = self.platform_motions(at);
        let uncontrolled = (0..3).filter(|&axis| !self.controls.contains(&Coordinate::Rotation(axis)));
        let turn = |axis: usize| (at.pose.rotation.column(axis).transpose() * motions.rows(3, 3)).amax();
        if motions.ncols() == 0 { 0.0 } else { uncontrolled.map(turn).fold(0.0, f64::max) }
    }

    /// Twists of P that the chains allow, drives free: 6 × motions, O axes, mm and rad × characteristic length; dependent where a joint is idle.
    fn platform_motions(&self, at: &Configuration) -> DMatrix<f64> {
        RankRevealing::new(self.closure_jacobian(at), RANK_TOLERANCE).null_space().rows(0, 6).into_owned()
    }

    /// Number of `coordinates` that the platform `motions` change independently of each other.
    fn independent_count(&self, coordinates: &[Coordinate], motions: &DMatrix<f64>, at: &Configuration) -> usize {
        let row = |coordinate: &Coordinate| match *coordinate {
            Coordinate::Translation(axis) => motions.row(axis).into_owned(),
            Coordinate::Rotation(axis) => at.pose.rotation.column(axis).transpose() * motions.rows(3, 3),
        };
        let rows: Vec<_> = coordinates.iter().map(row).collect();
        if rows.is_empty() || motions.ncols() == 0 {
            return 0;
        }
        let values = DMatrix::from_rows(&rows).singular_values();
        values.iter().filter(|&&value| value > MOVES).count()
    }
}

/// A coordinate that moves by less than this share of a motion of the whole mechanism is held.
pub(super) const MOVES: f64 = 1e-7;
