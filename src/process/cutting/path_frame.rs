//! A cutting force that is constant in the frame of the path.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::{heading, share_across};
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
    /// Radial, tangential and axial force with the law that turns them.
    pub force: MillingForce,
}

impl PathFrame {
    /// Force on the tool moving along the unit vector `tangent`, N; both in axes of the tool.
    #[must_use]
    pub fn force(&self, tangent: Vector3<f64>) -> Vector3<f64> {
        let full = Self::tool_angle(tangent).map_or_else(Vector3::zeros, |phi| self.force.force(phi));
        let share = share_across(tangent);
        Vector3::new(full.x * share, full.y * share, self.force.axial)
    }

    /// φ in rad for a motion along the unit vector `tangent` (axes of the tool), from −3π/2 to π/2; `None` without heading.
    #[must_use]
    pub fn tool_angle(tangent: Vector3<f64>) -> Option<f64> {
        heading(tangent).map(|f| f.y.atan2(f.x) - FRAC_PI_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        process::ForceLaw,
        toolpath::{Circle, Plane, Turn},
    };

    fn circle(turn: Turn) -> Circle {
        Circle {
            centre_mm: Vector3::new(4.0, -5.0, 6.0),
            diameter_mm: 50.0,
            plane: Plane::Xy,
            turn,
            start_angle_rad: 0.2,
            points: 73,
        }
    }

    #[test]
    fn on_a_counter_clockwise_circle_the_tool_angle_is_the_polar_angle() {
        for law in [ForceLaw::Printed, ForceLaw::Rotated] {
            let frame = PathFrame { force: MillingForce { law, ..MillingForce::PAPER } };
            let circle = circle(Turn::CounterClockwise);
            for point in circle.toolpath().unwrap().points() {
                let arm = point.position_mm - circle.centre_mm;
                let polar = arm.y.atan2(arm.x);
                let phi = PathFrame::tool_angle(point.tangent).unwrap();
                assert!((phi - polar).sin().abs() < 1e-12 && (phi - polar).cos() > 0.0);
                assert!((frame.force(point.tangent) - frame.force.force(polar)).norm() < 1e-10);
            }
        }
    }

    #[test]
    fn the_rotated_law_pushes_right_of_and_along_the_motion() {
        let force = MillingForce { radial: 7.0, tangential: 3.0, axial: -2.0, law: ForceLaw::Rotated };
        for turn in [Turn::CounterClockwise, Turn::Clockwise] {
            for point in circle(turn).toolpath().unwrap().points() {
                let right = point.tangent.cross(&Vector3::z());
                let wanted = right * 7.0 + point.tangent * 3.0 - Vector3::z() * 2.0;
                assert!((PathFrame { force }.force(point.tangent) - wanted).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn a_ramp_has_the_heading_of_its_projection_and_a_plunge_none() {
        let ramp = Vector3::new(0.6, 0.0, -0.8);
        assert!((PathFrame::tool_angle(ramp).unwrap() + FRAC_PI_2).abs() < 1e-15);
        let frame = PathFrame { force: MillingForce::PAPER };
        for tangent in [-Vector3::z(), Vector3::z(), Vector3::new(1e-9, 0.0, -1.0), Vector3::zeros()] {
            assert_eq!(PathFrame::tool_angle(tangent), None);
            assert_eq!(frame.force(tangent), Vector3::new(0.0, 0.0, -25.0));
        }
    }
}
