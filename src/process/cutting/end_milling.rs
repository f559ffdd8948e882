//! Mechanistic model of milling with the side of an end mill: a cut of any width, averaged over a turn or at its peak.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::{Arc, CutForce, EdgeLaw, LoadError, feed};
use crate::toolpath::{PathPoint, Turn};

/// How the teeth go through the material at its side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutDirection {
    /// Up milling, conventional: chips begin with no thickness. With a clockwise spindle the material is to the left of the
    /// feed, seen from the spindle.
    Up,
    /// Down milling, climb: chips begin with their full thickness. With a clockwise spindle the material is to the right of
    /// the feed.
    Down,
}

/// Which force of a turn is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OverTurn {
    /// Its mean.
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
/// the feed per tooth counts along the path; a motion without heading (a plunge) is given axial force and torque only.
///
/// Source: Y. Altintas, *Manufacturing Automation*, 2nd ed., Cambridge University Press 2012, chapter 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndMilling {
    /// Force on a tooth.
    pub edge: EdgeLaw,
    /// D, mm.
    pub diameter_mm: f64,
    /// N, number of teeth.
    pub teeth: u32,
    /// a, axial depth of cut, mm.
    pub depth_mm: f64,
    /// b, radial width of the cut, mm; at most D.
    pub width_mm: f64,
    /// On which side the material is. A cut as wide as the cutter has none.
    pub direction: CutDirection,
    /// c, feed per tooth, mm. `None`: from the feed v and spindle speed S of each point, c = v / (S N).
    pub feed_per_tooth_mm: Option<f64>,
    /// Which way the spindle turns, seen from the spindle towards the workpiece.
    pub spindle: Turn,
    /// Mean or peak.
    pub over_turn: OverTurn,
}

impl EndMilling {
    /// Where a tooth is in the material.
    #[must_use]
    pub fn arc(&self) -> Arc {
        let immersion = (1.0 - 2.0 * self.width_mm / self.diameter_mm).clamp(-1.0, 1.0).acos();
        match self.direction {
            CutDirection::Up => Arc { entry: 0.0, exit: immersion },
            CutDirection::Down => Arc { entry: PI - immersion, exit: PI },
        }
    }

    /// Force and torque at feed per tooth `c` in mm: mean or peak, as asked for.
    #[must_use]
    pub fn force(&self, c: f64) -> CutForce {
        match self.over_turn {
            OverTurn::Mean => self.mean(c),
            OverTurn::Peak => self.peak(c),
        }
    }

    /// Mean over a turn at feed per tooth `c` in mm.
    #[must_use]
    pub fn mean(&self, c: f64) -> CutForce {
        let [tangential, radial, axial] = self.arc().integrals(&self.edge, c);
        let along_feed = -tangential.cosine - radial.sine;
        let across = tangential.sine - radial.cosine;
        let share = f64::from(self.teeth) * self.depth_mm / TAU;
        self.turned(Vector3::new(along_feed, across, axial.plain) * share, tangential.plain * share)
    }

    /// With the first tooth at ψ = `angle` rad and `c` in mm, of those teeth that are in the material when the first one is at
    /// `seen`: within an arc without entries and exits these are the same.
    pub(super) fn at_angle(&self, angle: f64, seen: f64, c: f64) -> CutForce {
        let arc = self.arc();
        let pitch = TAU / f64::from(self.teeth);
        let mut force = Vector3::zeros();
        let mut tangential = 0.0;
        for tooth in 0..self.teeth {
            let turns = ((seen + f64::from(tooth) * pitch) / TAU).floor();
            let of = |first: f64| first + f64::from(tooth) * pitch - turns * TAU;
            if !(arc.entry..=arc.exit).contains(&of(seen)) {
                continue;
            }
            let (sin, cos) = of(angle).sin_cos();
            let edge = self.edge.on_edge(c * sin.max(0.0)) * self.depth_mm;
            force += Vector3::new(-edge.x * cos - edge.y * sin, edge.x * sin - edge.y * cos, edge.z);
            tangential += edge.x;
        }
        self.turned(force, tangential)
    }

    /// For the spindle's sense of turning, of the force of a clockwise one and the sum of tangential forces.
    fn turned(&self, force: Vector3<f64>, tangential: f64) -> CutForce {
        let side = match self.spindle {
            Turn::Clockwise => 1.0,
            Turn::CounterClockwise => -1.0,
        };
        CutForce {
            force_N: Vector3::new(force.x, side * force.y, force.z),
            torque_Nmm: side * tangential * self.diameter_mm / 2.0,
        }
    }

    /// c at `point`, mm.
    ///
    /// # Errors
    /// When it follows from the point's feed and spindle speed and one of them is missing.
    pub fn feed_per_tooth(&self, point: &PathPoint) -> Result<f64, LoadError> {
        feed::per_tooth(point, self.feed_per_tooth_mm, self.teeth, "feed_per_tooth_mm")
    }
}
