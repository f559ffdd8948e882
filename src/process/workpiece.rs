//! A workpiece: its features, the room it takes, and the boxes it must stay out of.
//!
//! Boxes and features are placed together: where a path gives the positions of the platform point instead of the tool
//! tip, so do the boxes.

use nalgebra::{Matrix3, Vector3};

use super::{PathReference, cutting::PathLoad};
use crate::{spatial::Pose, toolpath::Toolpath};

/// An axis-aligned box, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Lower corner.
    pub min: Vector3<f64>,
    /// Upper corner.
    pub max: Vector3<f64>,
}

/// Something to be cut, in the workpiece frame W.
#[derive(Debug, Clone, PartialEq)]
pub struct Feature {
    /// Its name.
    pub name: String,
    /// The path.
    pub path: Toolpath,
    /// The cutting force at each of its points.
    pub loads: Vec<PathLoad>,
    /// Whose positions the path gives.
    pub reference: PathReference,
    /// How far the tool may be from its path, mm.
    pub tolerance_mm: f64,
}

/// A box in the base frame O that the workpiece must stay out of, such as a clamp.
#[derive(Debug, Clone, PartialEq)]
pub struct ForbiddenBox {
    /// Its name.
    pub name: String,
    /// The box.
    pub extent: Extent,
}

/// Boxes nearer than this touch but do not overlap, mm.
const TOUCH_MM: f64 = 1e-9;
/// Sine of the angle below which two edges are parallel.
const PARALLEL: f64 = 1e-9;

impl Extent {
    /// The smallest box around `points`; `None` if there are none.
    pub fn of(points: impl Iterator<Item = Vector3<f64>>) -> Option<Self> {
        points.map(|p| Self { min: p, max: p }).reduce(Self::union)
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// The box that reaches `by` (mm) farther on every side.
    #[must_use]
    pub fn grown(&self, by: f64) -> Self {
        Self { min: self.min.add_scalar(-by), max: self.max.add_scalar(by) }
    }

    /// How far `point` is outside along the axis where it is farthest outside, mm; negative inside.
    pub fn excess(&self, point: &Vector3<f64>) -> f64 {
        (self.min - point).sup(&(point - self.max)).max()
    }

    /// Whether this box, with `workpiece`, `X_OW` (its axes are those of W), and the box `other` of O have more than
    /// their surface in common.
    #[must_use]
    pub fn overlaps(&self, workpiece: &Pose, other: &Extent) -> bool {
        self.gap(workpiece, other) < -TOUCH_MM
    }

    /// How far this box, with `workpiece`, `X_OW`, may be moved along the unit vector `way` of O before it overlaps the
    /// box `other` of O, mm; infinite if it never does.
    pub fn way_to(&self, workpiece: &Pose, way: &Vector3<f64>, other: &Extent) -> f64 {
        let (own, theirs) = (self.corners().map(|corner| workpiece.transform(corner)), other.corners());
        // The boxes overlap while the projections on all axes do.
        let (mut begin, mut end) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in axes(&workpiece.rotation) {
            let (a, b) = (shadow(&own, &axis), shadow(&theirs, &axis));
            let (first, last) = (b.0 - a.1, b.1 - a.0);
            let speed = axis.dot(way);
            match speed.abs() > PARALLEL {
                true => {
                    let (one, other) = (first / speed, last / speed);
                    begin = begin.max(one.min(other));
                    end = end.min(one.max(other));
                }
                false if first < -TOUCH_MM && last > TOUCH_MM => {}
                false => return f64::INFINITY,
            }
        }
        if begin + TOUCH_MM < end && end > TOUCH_MM { begin.max(0.0) } else { f64::INFINITY }
    }

    /// The widest gap that an axis of this box, with `workpiece`, `X_OW` (its axes are those of W), an axis of the box
    /// `other` of O, or a cross product of two shows between them, mm: no more than their distance, and above 0 if and
    /// only if they are apart. Less than 0: how far one must at least be moved out of the other.
    pub fn gap(&self, workpiece: &Pose, other: &Extent) -> f64 {
        let (own, theirs) = (self.corners().map(|corner| workpiece.transform(corner)), other.corners());
        axes(&workpiece.rotation)
            .map(|axis| between(shadow(&own, &axis), shadow(&theirs, &axis)))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Its corners.
    pub fn corners(&self) -> [Vector3<f64>; 8] {
        let end = |bit: usize| if bit == 0 { &self.min } else { &self.max };
        std::array::from_fn(|k| Vector3::new(end(k & 1).x, end(k & 2).y, end(k & 4).z))
    }
}

/// Axes one of which separates a box with these axes from one with those of O if the boxes are apart: the axes of both and
/// their cross products.
fn axes(a: &Matrix3<f64>) -> impl Iterator<Item = Vector3<f64>> + use<> {
    let (a, b) = (*a, Matrix3::identity());
    let crossed = (0..9).map(move |k| a.column(k / 3).cross(&b.column(k % 3)));
    let own = (0..3).flat_map(move |k| [a.column(k).into_owned(), b.column(k).into_owned()]);
    // Edges that are parallel have no cross product, and need none.
    own.chain(crossed).filter(|axis| axis.norm() > PARALLEL).map(|axis| axis.normalize())
}

/// Smallest and largest coordinate of `points` along `axis`.
fn shadow(points: &[Vector3<f64>], axis: &Vector3<f64>) -> (f64, f64) {
    points.iter().map(|p| p.dot(axis)).fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
}

fn between(a: (f64, f64), b: (f64, f64)) -> f64 {
    f64::max(b.0 - a.1, a.0 - b.1)
}
