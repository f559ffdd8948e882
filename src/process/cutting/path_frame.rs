//! A cutting force that is constant in the frame of the path.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::{heading, lateral_share};
use crate::process::MillingForce;

/// Constant radial, tangential and axial force, eq. (17), with the tool angle φ taken from the path:
///
/// ```text
/// φ = heading − 90°
/// ```
///
/// where the heading is the angle of the motion in the plane normal to the tool, from the projection of the x axis of W,
/// about the tool's axis. By the rotated law F_r > 0 then pushes the tool to the right of its motion seen from the workpiece
/// (to the left seen from the spindle), F_t > 0 along its motion and F_z > 0 out of the spindle: milling mostly pushes it
/// back, F_z < 0. On a circle run counter-clockwise about the tool's axis φ is the polar angle of the point, and the radial
/// direction is the outward normal. The printed law is no rotation: its force depends on how the path lies to the axes of W.
///
/// A motion without heading (a plunge) has only the axial force, one near it a share of the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathFrame {
    /// Radial, tangential and axial force, and the law that resolves them.
    pub force: MillingForce,
}

impl PathFrame {
    /// Returns the force on the tool moving along the unit vector `tangent`, N; both in axes of the tool.
    #[must_use]
    pub fn force(&self, tangent: Vector3<f64>) -> Vector3<f64> {
        let full = Self::tool_angle(tangent).map_or_else(Vector3::zeros, |phi| self.force.force(phi));
        let share = lateral_share(tangent);
        Vector3::new(full.x * share, full.y * share, self.force.axial)
    }

    /// Returns the immersion direction φ, rad, from −3π/2 to π/2, for a motion along the unit vector `tangent` (axes of the
    /// tool); `None` without heading.
    #[must_use]
    pub fn tool_angle(tangent: Vector3<f64>) -> Option<f64> {
        heading(tangent).map(|f| libm::atan2(f.y, f.x) - FRAC_PI_2)
    }
}
