//! Arcs of circles through three points.

use nalgebra::Vector3;

use crate::{spatial::rotation_exp, toolpath::model::direction};

/// An arc of a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arc {
    start: Vector3<f64>,
    centre: Vector3<f64>,
    /// Axis it turns about, a unit vector.
    axis: Vector3<f64>,
    /// Angle it turns by, rad.
    sweep_rad: f64,
    /// How far along it the point lies that it was led through, from 0 to 1.
    pub via: f64,
}

impl Arc {
    /// From `start` by `via` to `end`, or as far as `sweep_rad` says, mm; `None` where the three are on no circle.
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
            let angle = from.cross(&to).dot(&axis).atan2(from.dot(&to));
            if angle > 0.0 { angle } else { angle + std::f64::consts::TAU }
        };
        let sweep = sweep_rad.unwrap_or_else(|| angle_to(end));
        let axis = axis * sweep.signum();
        let arc = Arc { start, centre, axis, sweep_rad: sweep.abs(), via: angle_to(via) / sweep.abs() };
        (arc.radius().is_finite() && arc.radius() <= MOST_RADIUS_MM && arc.sweep_rad > 0.0).then_some(arc)
    }

    pub fn radius(&self) -> f64 {
        (self.start - self.centre).norm()
    }

    /// Length, mm.
    pub fn length(&self) -> f64 {
        self.radius() * self.sweep_rad
    }

    pub fn sweep_rad(&self) -> f64 {
        self.sweep_rad
    }

    /// Position and unit tangent at `t` from 0 to 1.
    pub fn at(&self, t: f64) -> (Vector3<f64>, Vector3<f64>) {
        let turned = rotation_exp(self.axis * (self.sweep_rad * t)) * (self.start - self.centre);
        (self.centre + turned, direction(self.axis.cross(&turned)))
    }

    /// Where it passes nearest to `goal`, from 0 to 1, next to `guess`.
    pub fn nearest(&self, goal: &Vector3<f64>, guess: f64) -> f64 {
        let (from, to) = (self.start - self.centre, goal - self.centre);
        let angle = from.cross(&to).dot(&self.axis).atan2(from.dot(&to));
        // Of the angles that differ by turns, the one next to the guess.
        let turns = ((guess * self.sweep_rad - angle) / std::f64::consts::TAU).round();
        ((angle + turns * std::f64::consts::TAU) / self.sweep_rad).clamp(0.0, 1.0)
    }
}

/// Sine of the angle between the ways to the middle and to the end below which three points are on a line.
const LEAST_AREA: f64 = 1e-9;
/// A larger circle is a line with rounding in it.
const MOST_RADIUS_MM: f64 = 1e7;

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    #[test]
    fn a_circle_passes_its_three_points_and_goes_on_as_asked() {
        let points = [Vector3::new(1.0, 0.0, 5.0), Vector3::new(0.0, 1.0, 5.0), Vector3::new(0.0, -1.0, 5.0)];
        let arc = Arc::through(points, None).unwrap();
        assert!((arc.sweep_rad() - 1.5 * PI).abs() < 1e-12 && (arc.radius() - 1.0).abs() < 1e-12);
        for (t, point) in [(0.0, points[0]), (arc.via, points[1]), (1.0, points[2])] {
            assert!((arc.at(t).0 - point).norm() < 1e-12);
            assert!((arc.nearest(&point, t) - t).abs() < 1e-12);
        }
        let back = Arc::through(points, Some(-FRAC_PI_2)).unwrap();
        assert!((back.at(1.0).0 - points[2]).norm() < 1e-12, "{:?}", back.at(1.0));
        let twice = Arc::through(points, Some(4.0 * PI)).unwrap();
        assert!((twice.at(1.0).0 - points[0]).norm() < 1e-12);
        assert!((twice.nearest(&points[1], 0.6) - 0.625).abs() < 1e-12);
        assert_eq!(Arc::through([points[0], points[0], points[1]], None), None);
        let [x, y] = [Vector3::x(), Vector3::x() * 2.0];
        assert_eq!(Arc::through([Vector3::zeros(), x, y], None), None);
    }
}
