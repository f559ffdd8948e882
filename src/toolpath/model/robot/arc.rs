//! Arcs of circles through three points.

use nalgebra::Vector3;

use crate::{spatial::rotation_exp, toolpath::model::direction};

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
        let arc = Arc { start, centre, axis, sweep_rad: sweep.abs(), via: angle_to(via) / sweep.abs() };
        (arc.radius().is_finite() && arc.radius() <= MOST_RADIUS_MM && arc.sweep_rad > 0.0).then_some(arc)
    }

    /// Returns the radius, mm.
    #[must_use]
    pub fn radius(&self) -> f64 {
        (self.start - self.centre).norm()
    }

    /// Returns the arc length, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.radius() * self.sweep_rad
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
        (self.centre + turned, direction(self.axis.cross(&turned)))
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

/// Sine of the angle between the ways to the middle and to the end below which three points are on a line.
const LEAST_AREA: f64 = 1e-9;
/// A larger circle is a line with rounding in it.
const MOST_RADIUS_MM: f64 = 1e7;
