//! How the tool stands at a point of a path.

use nalgebra::{UnitQuaternion, Vector3};

use crate::spatial::rotation_exp;

/// How the tool stands, in the axes of the workpiece frame W.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Orientation {
    /// Direction of its axis, a unit vector from its tip to the spindle. The turn about it is free.
    ToolAxis(Vector3<f64>),
    /// Orientation of the platform, or of the flange of an arm: `R_WP`.
    Platform(UnitQuaternion<f64>),
}

/// How far from its orientation the tool may stand within a written motion where orientations are corrected, rad.
pub(crate) const WRITTEN_RAD: f64 = 1e-4;

/// Sine of the angle below which two axes are parallel.
const PARALLEL: f64 = 1e-12;

impl Orientation {
    /// The angle by which the tool is turned from here to `other`, rad; 0 where one is an axis and the other is not.
    #[must_use]
    pub fn angle_to(&self, other: &Self) -> f64 {
        match (self, other) {
            (Orientation::ToolAxis(a), Orientation::ToolAxis(b)) => a.cross(b).norm().atan2(a.dot(b)),
            (Orientation::Platform(a), Orientation::Platform(b)) => a.angle_to(b),
            _ => 0.0,
        }
    }

    /// The orientation at the share `t` of the least turn from here to `other`; `other` where one is an axis and the other is not.
    #[must_use]
    pub fn towards(&self, other: &Self, t: f64) -> Self {
        match (self, other) {
            (Orientation::ToolAxis(a), Orientation::ToolAxis(b)) => {
                let turn = least_turn(*a, *b) * t;
                Orientation::ToolAxis((rotation_exp(turn) * a).normalize())
            }
            (Orientation::Platform(a), Orientation::Platform(b)) => Orientation::Platform(a.rotation_to(b).powf(t) * a),
            _ => *other,
        }
    }
}

/// The rotation vector (rad) of the least turn that takes the unit vector `a` to `b`; where they are opposite, about any axis
/// across them.
pub fn least_turn(a: Vector3<f64>, b: Vector3<f64>) -> Vector3<f64> {
    let across = a.cross(&b);
    let angle = across.norm().atan2(a.dot(&b));
    let axis = across.try_normalize(PARALLEL).or_else(|| {
        let other = if a.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() };
        a.cross(&other).try_normalize(PARALLEL)
    });
    axis.map_or_else(Vector3::zeros, |axis| axis * angle)
}
