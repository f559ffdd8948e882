//! Paths made from numbers: a line and a circle.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use thiserror::Error;

use crate::model::{PathPoint, Plane, PointSource, Sampling, Toolpath, TurnDirection, Way, direction};

/// The parameters of a closed circular path: its last point is its first.
///
/// Point k of n, k = 0 … n − 1, lies at the angle φ_k = φ_0 ± 2π k / (n − 1) from the plane's first axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// Centre in the workpiece frame, mm.
    pub centre_mm: Vector3<f64>,
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// The plane it lies in.
    pub plane: Plane,
    /// The direction of rotation, seen from the tip of the plane's normal.
    pub turn: TurnDirection,
    /// φ_0, the angle of the first point, rad.
    pub start_angle_rad: f64,
    /// n, the number of points, the closing one included; at least 4.
    pub points: usize,
}

/// Why a line or circle cannot be generated.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum GenerateError {
    /// The diameter is not a length.
    #[error("circle: diameter_mm = {0}: expected a finite number above 0")]
    Diameter(f64),
    /// A centre or end is not a position, or the start angle not an angle.
    #[error("{what}: expected finite numbers")]
    NotFinite {
        /// Name of the value.
        what: &'static str,
    },
    /// Too few or too many points.
    #[error("{what}: {points} points: expected {least} to {most}", most = Sampling::MAX_POINTS)]
    Points {
        /// Name of the generator.
        what: &'static str,
        /// Number of points requested.
        points: usize,
        /// The fewest that make sense.
        least: usize,
    },
    /// A line with more pieces than a path may have points.
    #[error("line: {length_mm} mm in pieces of at most {max_segment_mm} mm: expected at most {most} points",
            most = Sampling::MAX_POINTS)]
    LineTooFine {
        /// Length of the line, mm.
        length_mm: f64,
        /// The longest piece asked for, mm.
        max_segment_mm: f64,
    },
}

impl Circle {
    /// Generates the circle as a path whose every point is cutting, without feed or spindle speed.
    ///
    /// The points lie on the circle; [`PointSource::parameter`] is k / (n − 1). Fails when the diameter is not above 0, a number is not
    /// finite, or there are fewer than 4 points or more than [`Sampling::MAX_POINTS`].
    pub fn toolpath(&self) -> Result<Toolpath, GenerateError> {
        self.check()?;
        let sign = self.turn.sign();
        let [first, second, _] = self.plane.axes();
        let radius_mm = self.diameter_mm / 2.0;
        let last = self.points - 1;
        let points = (0..=last).map(|k| {
            let parameter = k as f64 / last as f64;
            // The closing point takes the angle of the first, so that it is the same point to the last bit.
            let turned = if k == last { 0.0 } else { sign * TAU * parameter };
            let (sin, cos) = libm::sincos(self.start_angle_rad + turned);
            let mut position_mm = self.centre_mm;
            position_mm[first] += radius_mm * cos;
            position_mm[second] += radius_mm * sin;
            let mut tangent = Vector3::zeros();
            tangent[first] = -sign * sin;
            tangent[second] = sign * cos;
            cutting_point(position_mm, tangent, TAU * radius_mm * parameter, parameter)
        });
        Ok(Toolpath::assemble(points.collect()))
    }

    /// Checks diameter, centre, start angle and number of points.
    fn check(&self) -> Result<(), GenerateError> {
        if !(self.diameter_mm.is_finite() && self.diameter_mm > 0.0) {
            return Err(GenerateError::Diameter(self.diameter_mm));
        }
        if !self.centre_mm.iter().all(|c| c.is_finite()) {
            return Err(GenerateError::NotFinite { what: "circle: centre_mm" });
        }
        if !self.start_angle_rad.is_finite() {
            return Err(GenerateError::NotFinite { what: "circle: start_angle_rad" });
        }
        if !(4..=Sampling::MAX_POINTS).contains(&self.points) {
            return Err(GenerateError::Points { what: "circle", points: self.points, least: 4 });
        }
        Ok(())
    }
}

impl Toolpath {
    /// Generates the straight cutting path from `start_mm` to `end_mm` (W), both included, in equal pieces no longer than `sampling`
    /// allows, without feed or spindle speed. Fails when a position is not finite, or there are more than [`Sampling::MAX_POINTS`] points.
    pub fn line(start_mm: Vector3<f64>, end_mm: Vector3<f64>, sampling: Sampling) -> Result<Toolpath, GenerateError> {
        for (what, position) in [("line: start_mm", start_mm), ("line: end_mm", end_mm)] {
            if !position.iter().all(|c| c.is_finite()) {
                return Err(GenerateError::NotFinite { what });
            }
        }
        let length_mm = (end_mm - start_mm).norm();
        let pieces = sampling
            .line_pieces(length_mm)
            .filter(|&pieces| pieces < Sampling::MAX_POINTS)
            .ok_or(GenerateError::LineTooFine { length_mm, max_segment_mm: sampling.max_segment_mm() })?;
        let tangent = direction(end_mm - start_mm);
        let points = (0..=pieces).map(|k| {
            let parameter = k as f64 / pieces as f64;
            let position_mm = if k == pieces { end_mm } else { start_mm.lerp(&end_mm, parameter) };
            cutting_point(position_mm, tangent, length_mm * parameter, parameter)
        });
        Ok(Toolpath::assemble(points.collect()))
    }
}

/// Creates a cutting point at `position_mm` (W) without orientation, feed, speed, tool or load; `parameter` from 0 to 1.
pub fn cutting_point(
    position_mm: Vector3<f64>,
    tangent: Vector3<f64>,
    arc_length_mm: f64,
    parameter: f64,
) -> PathPoint {
    PathPoint {
        position_mm,
        orientation: None,
        tangent,
        arc_length_mm,
        cutting: true,
        feed_mm_per_min: None,
        spindle_rev_per_min: None,
        tool: None,
        feature: None,
        load: None,
        external: Default::default(),
        source: PointSource { segment: 0, parameter },
        arm: None,
        way: Way::Followed,
    }
}
