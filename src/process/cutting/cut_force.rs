//! Force and torque of a cut in the directions of feed and tool.

use nalgebra::Vector3;

use super::{heading, lateral_share};
use crate::process::{ForceLaw, MillingForce};

/// Force on the tool at its tip and torque about its axis, in the directions of feed and tool: f along the feed, s from
/// the tip to the spindle, n = s × f.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct CutForce {
    /// Force components (F_f, F_n, F_s), N.
    pub force_N: Vector3<f64>,
    /// Torque on the tool about s, N·mm: above 0 against a spindle that turns clockwise seen from the spindle.
    pub torque_Nmm: f64,
}

impl CutForce {
    /// Returns force (N) and moment about the tip (N·mm) on a tool that moves along the unit vector `tangent`; all in axes of the tool, whose z
    /// points away from the spindle. A motion along the tool, as of a drill, has only axial force and torque, and one near that a share of the lateral force.
    pub(super) fn on_tool(&self, tangent: Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let spindle = -Vector3::z();
        let axial = spindle * self.force_N.z;
        let force = match heading(tangent) {
            Some(f) => (f * self.force_N.x + spindle.cross(&f) * self.force_N.y) * lateral_share(tangent) + axial,
            None => axial,
        };
        (force, spindle * self.torque_Nmm)
    }
}

impl From<CutForce> for MillingForce {
    /// Converts the force of a cut: its radial component is across the feed (F_n), the tangential one along it (F_f), so that φ is a quarter turn
    /// before the direction of the feed.
    fn from(cut: CutForce) -> Self {
        let [along, across, to_spindle] = cut.force_N.into();
        Self { radial: across, tangential: along, axial: -to_spindle, law: ForceLaw::Rotated }
    }
}
