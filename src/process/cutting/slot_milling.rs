//! Mechanistic model of milling a full slot, averaged over a turn of the spindle.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::{CutForce, EdgeForce, LoadError, feed};
use crate::toolpath::{PathPoint, Turn};

/// Mean force of an end mill cutting a slot as wide as itself.
///
/// With s the direction from the tip to the spindle and `n = s × f` the left of the motion seen from the spindle, a tooth
/// at the angle ψ from n, turning towards the feed direction f, cuts a chip of thickness
/// `h = c sin ψ` for ψ from 0 to π and nothing for the rest of the turn. With a the axial depth of cut it receives
/// `F_t = (K_tc h + K_te) a` against its motion, `F_r = (K_rc h + K_re) a` towards the tool's axis and
/// `F_a = (K_ac h + K_ae) a` towards the spindle. Averaged over a turn and summed over N teeth, the force on the tool is
///
/// ```text
/// F_f = − (N a / 4) K_rc c − (N a / π) K_re
/// F_n = ± (N a / 4) K_tc c ± (N a / π) K_te
/// F_s =   (N a / π) K_ac c + (N a / 2) K_ae
/// ```
///
/// with the upper sign for a spindle that turns clockwise seen from the spindle (M3): the tool is pushed to the left of
/// its motion. The lower sign, a counter-clockwise spindle (M4), is its mirror image.
///
/// Positive axial coefficients push the tool away from the workpiece; a right-hand helix turning clockwise draws the
/// tool into it, so its axial coefficients are negative here. Tooth passing, run-out and the torque about the tool's
/// axis are not part of the mean force. On a ramp the feed per tooth counts along the path. A motion without heading
/// (a plunge) is given the axial force only; cutting with the end teeth is not modelled.
///
/// Source: Y. Altintas, *Manufacturing Automation*, 2nd ed., Cambridge University Press 2012, chapter 2, mean forces of
/// the slotting tests from which cutting coefficients are identified.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlotMilling {
    /// K_tc and K_te: against the tooth's motion.
    pub tangential: EdgeForce,
    /// K_rc and K_re: from the tooth towards the tool's axis.
    pub radial: EdgeForce,
    /// K_ac and K_ae: along the tool's axis, towards the spindle.
    pub axial: EdgeForce,
    /// a, axial depth of cut, mm.
    pub depth_mm: f64,
    /// N, number of teeth.
    pub teeth: u32,
    /// c, feed per tooth, mm. `None`: from the feed v and spindle speed S of each point, c = v / (S N).
    pub feed_per_tooth_mm: Option<f64>,
    /// Which way the spindle turns, seen from the spindle towards the workpiece.
    pub spindle: Turn,
}

impl SlotMilling {
    /// Mean force (F_f, F_n, F_s) in N, s from the tip to the spindle and n = s × f, at feed per tooth `c` in mm.
    #[must_use]
    pub fn mean_force(&self, c: f64) -> Vector3<f64> {
        let edges = f64::from(self.teeth) * self.depth_mm;
        let in_plane = |k: EdgeForce| edges * (k.cutting * c / 4.0 + k.edge / PI);
        let side = match self.spindle {
            Turn::Clockwise => 1.0,
            Turn::CounterClockwise => -1.0,
        };
        let axial = edges * (self.axial.cutting * c / PI + self.axial.edge / 2.0);
        Vector3::new(-in_plane(self.radial), side * in_plane(self.tangential), axial)
    }

    /// c at `point`, mm.
    ///
    /// # Errors
    /// When it follows from the point's feed and spindle speed and one of them is missing.
    pub fn feed_per_tooth(&self, point: &PathPoint) -> Result<f64, LoadError> {
        feed::per_tooth(point, self.feed_per_tooth_mm, self.teeth, "feed_per_tooth_mm")
    }

    /// The mean force at feed per tooth `c` in mm, without torque.
    pub(super) fn force(&self, c: f64) -> CutForce {
        CutForce { force_N: self.mean_force(c), torque_Nmm: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        process::cutting::CuttingLaw,
        spatial::frame_about,
        toolpath::{Sampling, Toolpath},
    };

    fn milling(spindle: Turn) -> SlotMilling {
        SlotMilling {
            tangential: EdgeForce { cutting: 796.0, edge: 28.0 },
            radial: EdgeForce { cutting: 169.0, edge: 31.0 },
            axial: EdgeForce { cutting: -222.0, edge: -1.5 },
            depth_mm: 1.5,
            teeth: 4,
            feed_per_tooth_mm: None,
            spindle,
        }
    }

    fn path() -> Toolpath {
        let (start, end) = (Vector3::zeros(), Vector3::new(0.0, 3.0, 0.0));
        Toolpath::line(start, end, Sampling::default()).unwrap()
    }

    /// Force (f, n, z) on the tool averaged over a turn from what each tooth receives where it stands: nothing of the
    /// closed form but the chip thickness, which is the feed of a tooth along the radius.
    fn averaged(milling: &SlotMilling, c: f64) -> Vector3<f64> {
        let steps = 200_000;
        // About +z a clockwise spindle turns by a negative angle.
        let sense = if milling.spindle == Turn::Clockwise { -1.0 } else { 1.0 };
        let mut sum = Vector3::zeros();
        for step in 0..steps {
            let angle = 2.0 * PI * (f64::from(step) + 0.5) / f64::from(steps);
            let outward = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let motion = Vector3::z().cross(&outward) * sense;
            let h = c * outward.x;
            if h > 0.0 {
                let on_edge = |k: EdgeForce| (k.cutting * h + k.edge) * milling.depth_mm;
                sum += -motion * on_edge(milling.tangential) - outward * on_edge(milling.radial)
                    + Vector3::z() * on_edge(milling.axial);
            }
        }
        sum * f64::from(milling.teeth) / f64::from(steps)
    }

    #[test]
    fn the_mean_force_is_the_average_over_a_turn_either_way_round() {
        for spindle in [Turn::Clockwise, Turn::CounterClockwise] {
            for c in [0.02, 0.1] {
                let milling = milling(spindle);
                let (closed, averaged) = (milling.mean_force(c), averaged(&milling, c));
                assert!((closed - averaged).norm() < 1e-8 * closed.norm(), "{closed} {averaged}");
            }
        }
    }

    #[test]
    fn a_clockwise_spindle_is_pushed_left_and_back() {
        let path = path().with_feed(600.0).with_spindle(3000.0);
        let mut left = 0.0;
        for (spindle, side) in [(Turn::Clockwise, -1.0), (Turn::CounterClockwise, 1.0)] {
            // Tool along −z; along +y, left is −x. 600 mm/min, 3000 rev/min and 4 teeth are 0.05 mm per tooth.
            let force = force(&milling(spindle), &path.points()[1], -Vector3::z());
            assert!(force.x * side > 0.0 && force.y < 0.0 && force.z < 0.0);
            assert!((force.y + 6.0 * (169.0 * 0.05 / 4.0 + 31.0 / PI)).abs() < 1e-12);
            left += force.x;
        }
        assert!(left.abs() < 1e-12);
    }

    /// Force in W on a tool along `axis`, N.
    fn force(milling: &SlotMilling, point: &PathPoint, axis: Vector3<f64>) -> Vector3<f64> {
        let load = CuttingLaw::SlotMilling(*milling).load(point).unwrap();
        load.on_tool(point.tangent, &frame_about(axis)).force_N
    }

    #[test]
    fn from_below_the_workpiece_side_and_axial_forces_are_mirrored() {
        let path = path().with_feed(600.0).with_spindle(3000.0);
        let milling = milling(Turn::Clockwise);
        let above = force(&milling, &path.points()[1], -Vector3::z());
        let below = force(&milling, &path.points()[1], Vector3::z());
        assert_eq!(below, Vector3::new(-above.x, above.y, -above.z));
    }

    #[test]
    fn a_given_feed_per_tooth_holds_everywhere() {
        let milling = SlotMilling { feed_per_tooth_mm: Some(0.05), ..milling(Turn::Clockwise) };
        let with_speeds = path().with_feed(900.0).with_spindle(1000.0);
        assert_eq!(milling.feed_per_tooth(&path().points()[1]), Ok(0.05));
        assert_eq!(milling.feed_per_tooth(&with_speeds.points()[1]), Ok(0.05));
    }

    #[test]
    fn missing_feed_and_spindle_speed_are_named() {
        let message =
            |path: Toolpath| milling(Turn::Clockwise).feed_per_tooth(&path.points()[1]).unwrap_err().to_string();
        assert_eq!(
            message(path().with_spindle(3000.0)),
            "no feed in force on move 1: expected one, or feed_per_tooth_mm in the process"
        );
        assert_eq!(
            message(path().with_feed(600.0)),
            "spindle speed not given on move 1: expected one above 0, or feed_per_tooth_mm in the process"
        );
        assert_eq!(
            message(path().with_feed(600.0).with_spindle(0.0)),
            "spindle speed 0 rev/min on move 1: expected one above 0, or feed_per_tooth_mm in the process"
        );
    }
}
