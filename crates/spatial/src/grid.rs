//! A regular grid of positions.

use nalgebra::Vector3;
use serde::Serialize;

/// A regular grid over a box of positions of P, both ends included.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Grid {
    /// Coordinates along x, y and z, mm, ascending.
    pub axes: [Vec<f64>; 3],
}

impl Grid {
    /// Builds the grid over the box from `min` to `max` (mm) with `counts` points per axis, both ends included; a single point lies in the middle.
    #[inline]
    pub fn new(min: Vector3<f64>, max: Vector3<f64>, counts: [usize; 3]) -> Self {
        let axis = |i: usize| match counts[i] {
            1 => vec![0.5 * (min[i] + max[i])],
            n => (0..n)
                .map(|k| if k + 1 == n { max[i] } else { min[i] + (max[i] - min[i]) * k as f64 / (n - 1) as f64 })
                .collect(),
        };
        Self { axes: [axis(0), axis(1), axis(2)] }
    }

    /// Number of points along x, y and z.
    #[inline]
    pub fn counts(&self) -> [usize; 3] {
        [self.axes[0].len(), self.axes[1].len(), self.axes[2].len()]
    }

    /// Number of points of the grid.
    #[inline]
    pub fn len(&self) -> usize {
        self.counts().iter().product()
    }

    /// Whether the grid has no points.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position of point `index`, mm; x runs fastest, then y, then z.
    #[inline]
    pub fn position(&self, index: usize) -> Vector3<f64> {
        let [nx, ny, _] = self.counts();
        Vector3::new(self.axes[0][index % nx], self.axes[1][index / nx % ny], self.axes[2][index / (nx * ny)])
    }

    /// Index of the point with these indices along x, y and z; the inverse of [`Grid::position`].
    #[inline]
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        let [nx, ny, _] = self.counts();
        x + nx * (y + ny * z)
    }

    /// Volume share of the box that is nearest to point `index`: half a cell along each axis at its ends.
    #[inline]
    pub fn cell_share(&self, index: usize) -> f64 {
        let [nx, ny, _] = self.counts();
        let share = |axis: usize, i: usize| {
            let steps = self.axes[axis].len() - 1;
            match i {
                _ if steps == 0 => 1.0,
                i if i == 0 || i == steps => 0.5 / steps as f64,
                _ => 1.0 / steps as f64,
            }
        };
        share(0, index % nx) * share(1, index / nx % ny) * share(2, index / (nx * ny))
    }
}
