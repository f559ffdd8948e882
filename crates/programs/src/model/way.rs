//! The geometry of a motion in the workpiece frame: line, arc, circle, spline or drilled hole.

use nalgebra::Vector3;

use crate::model::{Sampling, direction, gcode, robot};

/// The geometry of a motion: the curve along which the tool moves, mm, workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MotionGeometry {
    /// The end is unknown: the path has no point for the motion.
    Unlocated,
    /// Only the end is known: the path has one point for the motion.
    Arrival(Vector3<f64>),
    /// Straight from the first to the second.
    Line(Vector3<f64>, Vector3<f64>),
    /// On a curve of which only the ends are known, taken as straight: the path has one point for the motion, its end.
    Spline { start: Vector3<f64>, end: Vector3<f64>, tangent: Vector3<f64> },
    /// Circular or helical arc in a plane of G-code.
    Arc(gcode::Arc),
    /// Circular arc through three points.
    Circle(robot::Arc),
    /// Into a hole and out again.
    Hole(Hole),
}

impl MotionGeometry {
    /// Returns the position (mm in W) and the unit tangent (zero if unknown) at the share `t` (0 to 1); `None` if the end is unknown.
    pub fn at(&self, t: f64) -> Option<(Vector3<f64>, Vector3<f64>)> {
        match self {
            MotionGeometry::Unlocated => None,
            MotionGeometry::Arrival(end) => Some((*end, Vector3::zeros())),
            MotionGeometry::Line(start, end) => {
                let position = if t < 1.0 { start.lerp(end, t) } else { *end };
                Some((position, direction(end - start)))
            }
            MotionGeometry::Spline { start, end, tangent } => {
                Some((if t < 1.0 { start.lerp(end, t) } else { *end }, *tangent))
            }
            MotionGeometry::Arc(arc) => Some(arc.at(t)),
            MotionGeometry::Circle(arc) => Some(arc.at(t)),
            MotionGeometry::Hole(hole) => Some(hole.at(t)),
        }
    }

    /// Returns the length, mm; 0 if the start or the end is unknown.
    pub fn length(&self) -> f64 {
        match self {
            MotionGeometry::Unlocated | MotionGeometry::Arrival(_) => 0.0,
            MotionGeometry::Line(start, end) | MotionGeometry::Spline { start, end, .. } => (end - start).norm(),
            MotionGeometry::Arc(arc) => arc.length(),
            MotionGeometry::Circle(arc) => arc.length(),
            MotionGeometry::Hole(hole) => hole.length_to(1.0),
        }
    }

    /// Returns into how many path pieces the motion is split, along which the tool turns by `turn_rad`; `None` for more than 20 million.
    pub fn pieces(&self, sampling: Sampling, turn_rad: f64) -> Option<usize> {
        let arc_pieces = |radius: f64, sweep: f64| {
            let pieces = sampling.arc_pieces(radius, sweep, self.length())?;
            Some(pieces.max(sampling.turning_pieces(0.0, turn_rad)?))
        };
        match self {
            MotionGeometry::Unlocated => Some(0),
            MotionGeometry::Arrival(_) | MotionGeometry::Spline { .. } => Some(1),
            MotionGeometry::Line(..) => sampling.turning_pieces(self.length(), turn_rad),
            MotionGeometry::Arc(arc) => arc_pieces(arc.radius(), arc.sweep_rad()),
            MotionGeometry::Circle(arc) => arc_pieces(arc.radius(), arc.sweep_rad()),
            MotionGeometry::Hole(hole) => Some(3 + sampling.line_pieces((hole.bottom - hole.clear).norm())?),
        }
    }
}

/// The path of the tool through one drilled hole: over it, to plane R, to the bottom and back; mm, workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hole {
    pub start: Vector3<f64>,
    /// Over the hole, at the greatest height of the tool.
    pub over: Vector3<f64>,
    /// At the plane R.
    pub clear: Vector3<f64>,
    pub bottom: Vector3<f64>,
    pub back: Vector3<f64>,
    /// Whether this is the first hole of a series.
    pub is_first: bool,
}

impl Hole {
    /// Parameters of the corners of the way.
    const OVER: f64 = 0.125;
    const CLEAR: f64 = 0.25;
    const BOTTOM: f64 = 0.75;

    /// Iterates over the parameters (0 to 1) of the hole's path points; the feed motion is split into all but three of `pieces`.
    pub fn parameters(pieces: usize) -> impl Iterator<Item = f64> {
        let feeds = pieces.saturating_sub(3).max(1);
        let feed = move |k: usize| Hole::CLEAR + (Hole::BOTTOM - Hole::CLEAR) * (k as f64 / feeds as f64);
        [Hole::OVER, Hole::CLEAR].into_iter().chain((1..=feeds).map(feed)).chain([1.0])
    }

    /// Whether the tool moves at feed rate at the parameter `t` (0 to 1) of a hole.
    pub fn is_feeding_at(t: f64) -> bool {
        t > Hole::CLEAR && t <= Hole::BOTTOM
    }

    /// Returns the position, mm, and the unit tangent at the parameter `t` from 0 to 1.
    pub fn at(&self, t: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (from, to, s) = match t {
            _ if t <= Hole::OVER => (self.start, self.over, t / Hole::OVER),
            _ if t <= Hole::CLEAR => (self.over, self.clear, (t - Hole::OVER) / (Hole::CLEAR - Hole::OVER)),
            _ if t <= Hole::BOTTOM => (self.clear, self.bottom, (t - Hole::CLEAR) / (Hole::BOTTOM - Hole::CLEAR)),
            _ => (self.bottom, self.back, (t - Hole::BOTTOM) / (1.0 - Hole::BOTTOM)),
        };
        (if s < 1.0 { from.lerp(&to, s) } else { to }, direction(to - from))
    }

    /// Returns the length of the tool's path up to the parameter `t`, mm.
    pub fn length_to(&self, t: f64) -> f64 {
        let corners =
            [(0.0, self.start), (Hole::OVER, self.over), (Hole::CLEAR, self.clear), (Hole::BOTTOM, self.bottom)];
        let sections = corners.iter().zip([Hole::OVER, Hole::CLEAR, Hole::BOTTOM, 1.0]);
        let length = |((from, begins), ends): (&(f64, Vector3<f64>), f64)| {
            if t <= *from { 0.0 } else { (self.at(t.min(ends)).0 - begins).norm() }
        };
        sections.map(length).sum()
    }
}
