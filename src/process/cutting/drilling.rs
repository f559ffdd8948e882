//! Thrust and torque of a twist drill.

use nalgebra::Vector3;

use super::{CutForce, Kienzle, LoadError, feed};
use crate::toolpath::{PathPoint, TurnDirection};

/// How far a move of a drill may be from its axis, as the cosine of the angle: 5°.
const ALONG_AXIS: f64 = 0.996_194_698_091_745_5;

/// The law that gives thrust and torque of a twist drill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DrillingLaw {
    /// Two lips that cut by Kienzle's law. With κ half the point angle a lip cuts a chip of thickness `h = f/2 sin κ`, and
    ///
    /// ```text
    /// k_c = k_c1.1 h^(−m_c)     M = k_c f D²/8     F = q k_c f D/2 sin κ
    /// ```
    ///
    /// M is that of both lips at a quarter of the diameter from the axis. q, the thrust as a share of the force of the
    /// lips, is 0.5 in the formula of Sandvik Coromant's technical guide (drilling, feed force), which is called approximate there.
    /// It is a law of the lips, with nothing for the chisel edge, so that it knows a part of them, too: where a hole of the diameter d is
    /// there already, D in the thrust is D − d and D² in the torque D² − d² (drilling out: H. Tschätsch, Applied Machining Technology,
    /// Springer 2009).
    Kienzle {
        /// The force of a lip against its motion.
        lip: Kienzle,
        /// 2 κ, rad.
        point_angle: f64,
        /// q.
        thrust_ratio: f64,
    },
    /// A constant K of the material, from tests with twist drills:
    ///
    /// ```text
    /// F = 570 K D f^0.85 N     M = K D² (0.630 + 16.84 f) / 100 N·m      D in mm, f in mm/rev
    /// ```
    ///
    /// Source: Tungaloy, General Catalogue 2020–2021, technical reference, page L068.
    MaterialConstant(f64),
}

/// A twist drill, in solid material where no stock says otherwise.
///
/// The part pushes the drill back with the thrust F and turns it back with the torque M. Both act on moves that lead along the tool's axis out of
/// the spindle, within 5°: a drill that goes back or aside, also through air, has no load. Chips that clog are not in it; without a stock neither
/// are entry and break-through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drilling {
    /// The law of thrust and torque.
    pub law: DrillingLaw,
    /// D, drill diameter, mm.
    pub diameter_mm: f64,
    /// f, feed per revolution, mm/rev. `None`: from the feed v and spindle speed S of each point, f = v / S.
    pub feed_per_rev_mm: Option<f64>,
    /// The spindle's direction of rotation, seen from the spindle towards the workpiece.
    pub spindle: TurnDirection,
}

impl Drilling {
    /// Returns thrust (N) and torque (N·mm) at the feed `f` in mm/rev, both above 0.
    #[must_use]
    pub fn thrust_and_torque(&self, f: f64) -> (f64, f64) {
        let d = self.diameter_mm;
        match self.law {
            DrillingLaw::Kienzle { lip, point_angle, thrust_ratio } => {
                let sin = libm::sin(point_angle / 2.0);
                let h = f / 2.0 * sin;
                let specific = lip.on_edge(h) / h;
                (thrust_ratio * specific * f * d / 2.0 * sin, specific * f * d * d / 8.0)
            }
            DrillingLaw::MaterialConstant(k) => {
                (570.0 * k * d * libm::pow(f, 0.85), k * d * d * (0.630 + 16.84 * f) / 100.0 * 1000.0)
            }
        }
    }

    /// Returns force and torque on the tool at the feed `f` in mm/rev.
    #[must_use]
    pub fn force(&self, f: f64) -> CutForce {
        let (thrust, torque) = self.thrust_and_torque(f);
        let side = -self.spindle.sign();
        CutForce { force_N: Vector3::new(0.0, 0.0, thrust), torque_Nmm: side * torque }
    }

    /// Returns the law of its lips as two teeth with the feed f/2 each, by which the force of a part of them is known; `None` for a law that does
    /// not tell lips from the chisel edge.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn lips(&self) -> Option<super::EngagedMilling> {
        let DrillingLaw::Kienzle { lip, thrust_ratio, .. } = self.law else { return None };
        let edge = super::EdgeLaw::Kienzle {
            tangential: lip,
            tangential_share: 1.0,
            radial_ratio: thrust_ratio,
            axial_ratio: 0.0,
        };
        Some(super::EngagedMilling { edge, feed_per_tooth_mm: None, spindle: self.spindle })
    }

    /// Returns the feed per revolution f at `point`, mm/rev; fails if it follows from feed and spindle speed and one of them is missing.
    pub fn feed_per_rev(&self, point: &PathPoint) -> Result<f64, LoadError> {
        feed::feed_per_tooth_at(point, self.feed_per_rev_mm, 1, "feed_per_rev_mm")
    }
}

/// Whether a drill that moves along the unit vector `tangent` (axes of the tool, z out of the spindle) drills.
pub(crate) fn is_drilling(tangent: Vector3<f64>) -> bool {
    tangent.z >= ALONG_AXIS
}
