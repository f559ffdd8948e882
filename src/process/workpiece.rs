//! A workpiece: its features, its bounding box, and the boxes that it must stay out of.
//!
//! Boxes and features are placed together: where a path gives the positions of the platform point instead of the tool tip, so do the boxes.

use nalgebra::{Matrix3, Vector3};

use super::{PathReference, cutting::PathLoad};
use crate::{process::CutPath, spatial::Pose};

/// An axis-aligned box, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Lower corner.
    pub min: Vector3<f64>,
    /// Upper corner.
    pub max: Vector3<f64>,
}

/// A feature to be cut: its path in the workpiece frame W, cutting forces and tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Feature {
    /// The feature's name.
    pub name: String,
    /// The path in W.
    pub path: CutPath,
    /// The cutting force at each point of the path.
    pub loads: Vec<PathLoad>,
    /// The point whose positions the path gives.
    pub reference: PathReference,
    /// How far the tool may be from its path, mm.
    pub tolerance_mm: f64,
}

/// A box in the base frame O that the workpiece must stay out of, such as a clamp.
#[derive(Debug, Clone, PartialEq)]
pub struct ForbiddenBox {
    /// The box's name.
    pub name: String,
    /// The box in O.
    pub extent: Extent,
}

/// Boxes nearer than this touch but do not overlap, mm.
const TOUCH_MM: f64 = 1e-9;
/// Sine of the angle below which two edges are parallel.
const PARALLEL: f64 = 1e-9;

impl Extent {
    /// Returns the smallest box around `points`; `None` if there are none.
    pub fn around(points: impl Iterator<Item = Vector3<f64>>) -> Option<Self> {
        points.map(|p| Self { min: p, max: p }).reduce(Self::union)
    }

    /// Returns the smallest box around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// Returns the box enlarged by `by` (mm) on every side.
    #[must_use]
    pub fn expanded(&self, by: f64) -> Self {
        Self { min: self.min.add_scalar(-by), max: self.max.add_scalar(by) }
    }

    /// Whether this box, with `workpiece`, `X_OW` (its axes are those of W), and the box `other` of O have more than their surface in common.
    #[must_use]
    pub fn overlaps(&self, workpiece: &Pose, other: &Extent) -> bool {
        self.gap(workpiece, other) < -TOUCH_MM
    }

    /// Returns how far this box, placed by `workpiece` (`X_OW`), can move along the unit vector `direction` of O before it overlaps the box
    /// `other` of O, mm; infinite if it never does.
    pub fn free_travel(&self, workpiece: &Pose, direction: &Vector3<f64>, other: &Extent) -> f64 {
        let (corners, other_corners) = (self.corners().map(|corner| workpiece.transform(corner)), other.corners());
        // The boxes overlap while the projections on all axes do.
        let (mut start, mut end) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in separating_axes(&workpiece.rotation) {
            let (a, b) = (projection(&corners, &axis), projection(&other_corners, &axis));
            let (first, last) = (b.0 - a.1, b.1 - a.0);
            let speed = axis.dot(direction);
            match speed.abs() > PARALLEL {
                true => {
                    let (one, other) = (first / speed, last / speed);
                    start = start.max(one.min(other));
                    end = end.min(one.max(other));
                }
                false if first < -TOUCH_MM && last > TOUCH_MM => {}
                false => return f64::INFINITY,
            }
        }
        if start + TOUCH_MM < end && end > TOUCH_MM { start.max(0.0) } else { f64::INFINITY }
    }

    /// Returns the widest gap, mm, between this box, placed by `workpiece` (`X_OW`), and the box `other` of O along their axes and the
    /// cross products of these. Above 0 if and only if they are apart, and at most their distance; below 0, minus the least distance to
    /// move one out of the other.
    pub fn gap(&self, workpiece: &Pose, other: &Extent) -> f64 {
        let (corners, other_corners) = (self.corners().map(|corner| workpiece.transform(corner)), other.corners());
        separating_axes(&workpiece.rotation)
            .map(|axis| [projection(&corners, &axis), projection(&other_corners, &axis)])
            .map(|[own, other]| f64::max(other.0 - own.1, own.0 - other.1))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the eight corners, mm.
    pub fn corners(&self) -> [Vector3<f64>; 8] {
        let end = |bit: usize| if bit == 0 { &self.min } else { &self.max };
        std::array::from_fn(|k| Vector3::new(end(k & 1).x, end(k & 2).y, end(k & 4).z))
    }
}

/// Returns unit vectors of which one separates a box with the axes `a` (columns, in O) from one with those of O if they are apart: the axes
/// of both and their cross products (separating axis theorem).
fn separating_axes(a: &Matrix3<f64>) -> impl Iterator<Item = Vector3<f64>> + use<> {
    let (a, b) = (*a, Matrix3::identity());
    let crossed = (0..9).map(move |k| a.column(k / 3).cross(&b.column(k % 3)));
    let axes = (0..3).flat_map(move |k| [a.column(k).into_owned(), b.column(k).into_owned()]);
    // Edges that are parallel have no cross product, and need none.
    axes.chain(crossed).filter(|axis| axis.norm() > PARALLEL).map(|axis| axis.normalize())
}

/// Returns the smallest and largest coordinate of `points` along `axis`, mm.
fn projection(points: &[Vector3<f64>], axis: &Vector3<f64>) -> (f64, f64) {
    points.iter().map(|p| p.dot(axis)).fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
}
