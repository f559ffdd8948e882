//! The orientation of the tool at a point of a path: its axis alone, or that of the platform.

use nalgebra::{UnitQuaternion, Vector3};

use kinetostat_spatial::{least_turn, rotation_exp};

/// The orientation of the tool in the workpiece frame W: its axis alone, or that of the platform or flange.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Orientation {
    /// Direction of the tool axis, a unit vector from its tip to the spindle. The rotation about it is free.
    ToolAxis(Vector3<f64>),
    /// Orientation of the platform, or of the flange of an arm: `R_WP`.
    Platform(UnitQuaternion<f64>),
}

/// Tolerance of the tool orientation within a written motion where orientations are corrected, rad.
pub(crate) const WRITTEN_RAD: f64 = 1e-4;

impl Orientation {
    /// Returns the angle between this orientation and `other`, rad; 0 if one is a tool axis and the other is not.
    #[must_use]
    pub fn angle_to(&self, other: &Self) -> f64 {
        match (self, other) {
            (Orientation::ToolAxis(a), Orientation::ToolAxis(b)) => libm::atan2(a.cross(b).norm(), a.dot(b)),
            (Orientation::Platform(a), Orientation::Platform(b)) => a.angle_to(b),
            _ => 0.0,
        }
    }

    /// Interpolates along the least rotation to `other`, at the share `t` (0 to 1); returns `other` if only one of them is a tool axis.
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
