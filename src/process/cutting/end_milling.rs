//! Mechanistic model of milling with the side of an end mill: a cut of any width, averaged over a turn or at its peak.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::{CutForce, EdgeLaw, EngagementArc, LoadError, feed};
use crate::toolpath::{PathPoint, TurnDirection};

/// The direction in which the teeth pass through the material: up or down milling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutDirection {
    /// Up milling, conventional: chips begin with no thickness. With a clockwise spindle the material is to the left of the
    /// feed, seen from the spindle.
    Up,
    /// Down milling, climb: chips begin with their full thickness. With a clockwise spindle the material is to the right of the feed.
    Down,
}

/// Which force within a revolution to compute: mean or peak.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MeanOrPeak {
    /// The mean over a revolution.
    #[default]
    Mean,
    /// The force at the instant at which it is largest.
    Peak,
}

/// Force of an end mill that cuts with its side.
///
/// With s the direction from the tip to the spindle, f the feed and `n = s × f` the left of the motion seen from the spindle, a
/// tooth at the angle ψ from n, turning towards f, cuts a chip of thickness `h = c sin ψ` while it is in the material:
///
/// ```text
/// up milling     ψ from 0 to acos(1 − 2 b/D)           D cutter diameter, b radial width of the cut
/// down milling   ψ from π − acos(1 − 2 b/D) to π
/// ```
///
/// It receives F_t against its motion, F_r towards the tool's axis and F_a towards the spindle ([`EdgeLaw`], times the axial
/// depth a). On the tool that is
///
/// ```text
/// F_f = Σ (− F_t cos ψ − F_r sin ψ)      F_n = ± Σ (F_t sin ψ − F_r cos ψ)
/// F_s = Σ F_a                            M_s = ± Σ F_t D/2
/// ```
///
/// over the teeth in the material, with the upper sign for a spindle that turns clockwise seen from the spindle (M3). The mean
/// is N/2π times the integral over ψ; with linear coefficients it has a closed form, with Kienzle's law all but ∫ sin^p ψ dψ
/// has. A cut as wide as the cutter is [`SlotMilling`](super::SlotMilling), with its torque. The helix does not change the mean;
/// the peak is that of straight teeth, which bounds that of a helix.
///
/// Not in it: run-out, cutting with the end teeth, the depth at which the force acts (it acts at the tip). On a ramp
/// the feed per tooth counts along the path; a plunge has no force that this law knows, and is given none.
///
/// Source: Y. Altintas, *Manufacturing Automation*, 2nd ed., Cambridge University Press 2012, chapter 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndMilling {
    /// The law of the force on a tooth.
    pub edge: EdgeLaw,
    /// D, cutter diameter, mm.
    pub diameter_mm: f64,
    /// N, number of teeth.
    pub teeth: u32,
    /// a, axial depth of cut, mm.
    pub depth_mm: f64,
    /// b, radial width of the cut, mm; at most D.
    pub width_mm: f64,
    /// Up or down milling; without effect for a cut as wide as the cutter.
    pub direction: CutDirection,
    /// c, feed per tooth, mm. `None`: from the feed v and spindle speed S of each point, c = v / (S N).
    pub feed_per_tooth_mm: Option<f64>,
    /// The spindle's direction of rotation, seen from the spindle towards the workpiece.
    pub spindle: TurnDirection,
    /// Whether to compute the mean or the peak force of a revolution.
    pub over_turn: MeanOrPeak,
}

impl EndMilling {
    /// Returns the engagement arc: the angles between which a tooth cuts.
    #[must_use]
    pub fn arc(&self) -> EngagementArc {
        let immersion = libm::acos((1.0 - 2.0 * self.width_mm / self.diameter_mm).clamp(-1.0, 1.0));
        match self.direction {
            CutDirection::Up => EngagementArc { entry: 0.0, exit: immersion },
            CutDirection::Down => EngagementArc { entry: PI - immersion, exit: PI },
        }
    }

    /// Returns force and torque at feed per tooth `c` (mm): mean or peak, as [`EndMilling::over_turn`] says.
    #[must_use]
    pub fn force(&self, c: f64) -> CutForce {
        match self.over_turn {
            MeanOrPeak::Mean => self.mean(c),
            MeanOrPeak::Peak => self.peak(c),
        }
    }

    /// Returns the mean force and torque over a revolution at feed per tooth `c` (mm).
    #[must_use]
    pub fn mean(&self, c: f64) -> CutForce {
        let [tangential, radial, axial] = self.arc().integrals(&self.edge, c);
        let along_feed = -tangential.cosine - radial.sine;
        let across = tangential.sine - radial.cosine;
        let share = f64::from(self.teeth) * self.depth_mm / TAU;
        self.for_spindle_direction(Vector3::new(along_feed, across, axial.plain) * share, tangential.plain * share)
    }

    /// Returns force and torque with the first tooth at ψ = `angle` (rad), at feed per tooth `c` (mm). Engaged are the teeth that cut with
    /// the first tooth at `engaged_at` (rad), so that the ends of an interval without entries and exits count with its inside.
    pub(super) fn at_angle(&self, angle: f64, engaged_at: f64, c: f64) -> CutForce {
        let arc = self.arc();
        let pitch = TAU / f64::from(self.teeth);
        let mut force = Vector3::zeros();
        let mut tangential = 0.0;
        for tooth in 0..self.teeth {
            let turns = ((engaged_at + f64::from(tooth) * pitch) / TAU).floor();
            let tooth_angle = |first: f64| first + f64::from(tooth) * pitch - turns * TAU;
            if !(arc.entry..=arc.exit).contains(&tooth_angle(engaged_at)) {
                continue;
            }
            let (sin, cos) = libm::sincos(tooth_angle(angle));
            let edge = self.edge.on_edge(c * sin.max(0.0)) * self.depth_mm;
            force += Vector3::new(-edge.x * cos - edge.y * sin, edge.x * sin - edge.y * cos, edge.z);
            tangential += edge.x;
        }
        self.for_spindle_direction(force, tangential)
    }

    /// Converts the force of a clockwise spindle (N) and the sum of tangential forces (N) to force and torque for the actual direction.
    fn for_spindle_direction(&self, force: Vector3<f64>, tangential: f64) -> CutForce {
        let side = -self.spindle.sign();
        CutForce {
            force_N: Vector3::new(force.x, side * force.y, force.z),
            torque_Nmm: side * tangential * self.diameter_mm / 2.0,
        }
    }

    /// Returns the feed per tooth c at `point`, mm. Fails when it follows from the point's feed and spindle speed and one of them is missing.
    pub fn feed_per_tooth(&self, point: &PathPoint) -> Result<f64, LoadError> {
        feed::feed_per_tooth_at(point, self.feed_per_tooth_mm, self.teeth, "feed_per_tooth_mm")
    }
}
