//! Mechanistic model of milling a full slot, averaged over a turn of the spindle.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::{CutForce, EdgeForce, LoadError, feed};
use crate::toolpath::{PathPoint, TurnDirection};

/// Mean force of an end mill cutting a slot as wide as itself.
///
/// With s the direction from the tip to the spindle and `n = s × f` the left of the motion seen from the spindle, a tooth at the angle ψ from
/// n, turning towards the feed direction f, cuts a chip of thickness `h = c sin ψ` for ψ from 0 to π and nothing for the rest of the turn.
/// With a the axial depth of cut it receives `F_t = (K_tc h + K_te) a` against its motion, `F_r = (K_rc h + K_re) a` towards the tool's axis
/// and `F_a = (K_ac h + K_ae) a` towards the spindle. Averaged over a turn and summed over N teeth, the force on the tool is
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
/// Positive axial coefficients push the tool away from the workpiece; a right-hand helix turning clockwise draws the tool into it, so its axial
/// coefficients are negative here. Tooth passing, run-out and the torque about the tool's axis are not part of the mean force. On a ramp the feed
/// per tooth counts along the path. Cutting with the end teeth is not modelled: a plunge has no force that this law knows, and is given none.
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
    /// The spindle's direction of rotation, seen from the spindle towards the workpiece.
    pub spindle: TurnDirection,
}

impl SlotMilling {
    /// Returns the mean force (F_f, F_n, F_s), N, at feed per tooth `c` (mm): s from the tip to the spindle, n = s × f.
    #[must_use]
    pub fn mean_force(&self, c: f64) -> Vector3<f64> {
        let edges = f64::from(self.teeth) * self.depth_mm;
        let in_plane = |k: EdgeForce| edges * (k.cutting * c / 4.0 + k.edge / PI);
        let side = -self.spindle.sign();
        let axial = edges * (self.axial.cutting * c / PI + self.axial.edge / 2.0);
        Vector3::new(-in_plane(self.radial), side * in_plane(self.tangential), axial)
    }

    /// Returns the feed per tooth c at `point`, mm. Fails when it follows from the point's feed and spindle speed and one of them is missing.
    pub fn feed_per_tooth(&self, point: &PathPoint) -> Result<f64, LoadError> {
        feed::feed_per_tooth_at(point, self.feed_per_tooth_mm, self.teeth, "feed_per_tooth_mm")
    }

    /// Returns the mean force at feed per tooth `c` (mm), without torque.
    pub(super) fn force(&self, c: f64) -> CutForce {
        CutForce { force_N: self.mean_force(c), torque_Nmm: 0.0 }
    }
}
