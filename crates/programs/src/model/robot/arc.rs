//! Arcs of circles through three points.

use nalgebra::Vector3;

use crate::model::{
    direction,
    gcode::{ArcFault, LengthUnit, SAME_POINT_MM, check_radii},
};
use kinetostat_spatial::rotation_exp;

/// An arc of a circle in space, mm, in the frame of the points that define it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    start: Vector3<f64>,
    centre: Vector3<f64>,
    /// Normal of the circle, about which the arc turns right-handed, a unit vector.
    axis: Vector3<f64>,
    /// Angle of the arc, rad, positive.
    sweep_rad: f64,
    /// Where the defining intermediate point lies along the arc: 0 at its start, 1 at its end.
    pub via: f64,
    /// What is added evenly along the arc: the rise of a helix, and the rounding of a programmed centre.
    drift: Vector3<f64>,
}

impl Arc {
    /// Creates the arc from `start` through `via` to `end` (mm), or over the angle `sweep_rad`; `None` if the points define no circle.
    #[must_use]
    pub fn through([start, via, end]: [Vector3<f64>; 3], sweep_rad: Option<f64>) -> Option<Arc> {
        let (a, b) = (via - start, end - start);
        let across = a.cross(&b);
        let axis = across.try_normalize(LEAST_AREA * (a.norm() * b.norm()).max(f64::MIN_POSITIVE))?;
        let centre = start
            + (across.cross(&a) * b.norm_squared() + b.cross(&across) * a.norm_squared())
                / (2.0 * across.norm_squared());
        let from = start - centre;
        let angle_to = |to: Vector3<f64>| {
            let to = to - centre;
            let angle = libm::atan2(from.cross(&to).dot(&axis), from.dot(&to));
            if angle > 0.0 { angle } else { angle + std::f64::consts::TAU }
        };
        let sweep = sweep_rad.unwrap_or_else(|| angle_to(end));
        let axis = axis * sweep.signum();
        let arc = Arc {
            start,
            centre,
            axis,
            sweep_rad: sweep.abs(),
            via: angle_to(via) / sweep.abs(),
            drift: Vector3::zeros(),
        };
        (arc.radius().is_finite() && arc.radius() <= MAX_RADIUS_MM && arc.sweep_rad > 0.0).then_some(arc)
    }

    /// Creates the arc from `start` to `end` about `centre` (mm), right-handed about the unit vector `axis`, with the rise of `end` along
    /// it; a full turn if both are at the same place across the axis.
    ///
    /// # Errors
    /// Radii at both ends, and `radius_mm` if it is given, that differ by more than rounding.
    pub fn about(
        [start, end, centre]: [Vector3<f64>; 3],
        axis: Vector3<f64>,
        radius_mm: Option<f64>,
    ) -> Result<Arc, ArcFault> {
        let across = |point: Vector3<f64>| {
            let arm = point - centre;
            arm - axis * arm.dot(&axis)
        };
        let (from, to) = (across(start), across(end));
        check_radii([from.norm(), to.norm()], LengthUnit::Millimetre)?;
        check_radii([from.norm(), radius_mm.unwrap_or(from.norm())], LengthUnit::Millimetre)?;
        let angle = libm::atan2(from.cross(&to).dot(&axis), from.dot(&to));
        let is_full = (to - from).norm() < SAME_POINT_MM;
        let sweep_rad =
            if !is_full && angle > 0.0 { angle } else { (if is_full { 0.0 } else { angle }) + std::f64::consts::TAU };
        let centre = start - from;
        let drift = end - (centre + rotation_exp(axis * sweep_rad) * from);
        Ok(Arc { start, centre, axis, sweep_rad, via: 0.5, drift })
    }

    /// Returns the centre, mm, at the height of the start.
    pub fn centre(&self) -> Vector3<f64> {
        self.centre
    }

    /// Whether the arc is no full turn and its circle, not a tangent of it, goes on to `point` (mm) to within `tolerance_mm`, so far that a
    /// line to there is another way.
    pub fn goes_on_to(&self, point: &Vector3<f64>, tolerance_mm: f64) -> bool {
        let arm = point - self.centre - self.drift;
        let step = point - self.at(1.0).0;
        let off = f64::max(arm.dot(&self.axis).abs(), (arm.norm() - self.radius()).abs());
        let off_tangent = step.norm_squared() / (2.0 * self.radius());
        // Points between on an arc are about as far apart as its first is from its start.
        let is_like_first = self.sweep_rad <= 2.0 * step.norm() / self.radius();
        let is_another = off_tangent > 4.0 * SAME_WAY_MM && is_like_first;
        is_another && self.sweep_rad < std::f64::consts::TAU && off <= tolerance_mm.min(ON_TANGENT * off_tangent)
    }

    /// Returns the radius, mm.
    #[must_use]
    pub fn radius(&self) -> f64 {
        (self.start - self.centre).norm()
    }

    /// Returns the arc length, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        libm::hypot(self.radius() * self.sweep_rad, self.drift.dot(&self.axis))
    }

    /// Returns the angle of the arc, rad, positive.
    #[must_use]
    pub fn sweep_rad(&self) -> f64 {
        self.sweep_rad
    }

    /// Returns the position (mm) and the unit tangent at the share `t` (0 to 1) of the arc, in the frame of its points.
    #[must_use]
    pub fn at(&self, t: f64) -> (Vector3<f64>, Vector3<f64>) {
        let turned = rotation_exp(self.axis * (self.sweep_rad * t)) * (self.start - self.centre);
        let along = self.axis.cross(&turned) + self.drift / self.sweep_rad;
        (self.centre + turned + self.drift * t, direction(along))
    }

    /// Returns the share of the arc, from 0 to 1, at which it passes nearest to `goal` (mm); of angles a full turn apart, the one next to `guess`.
    #[must_use]
    pub fn nearest(&self, goal: &Vector3<f64>, guess: f64) -> f64 {
        let (from, to) = (self.start - self.centre, goal - self.centre);
        let angle = libm::atan2(from.cross(&to).dot(&self.axis), from.dot(&to));
        // Of the angles that differ by turns, the one next to the guess.
        let turns = ((guess * self.sweep_rad - angle) / std::f64::consts::TAU).round();
        ((angle + turns * std::f64::consts::TAU) / self.sweep_rad).clamp(0.0, 1.0)
    }
}

/// An arc and its chord that are nearer to one another are the same way, mm.
const SAME_WAY_MM: f64 = 5e-3;
/// A point that lies nearer to a circle than this share of how far a tangent to there leaves it is on the circle.
const ON_TANGENT: f64 = 0.2;
/// Sine of the angle between the ways to the middle and to the end below which three points are on a line.
const LEAST_AREA: f64 = 1e-9;
/// A larger circle is a line with rounding in it.
const MAX_RADIUS_MM: f64 = 1e7;
