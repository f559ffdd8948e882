//! The way of a motion in the workpiece frame.

use nalgebra::Vector3;

use crate::toolpath::model::{Sampling, direction, gcode, robot};

/// The way a motion takes, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// Its end is not known: the path has no point for it.
    Unlocated,
    /// Its start is not known, or how it gets there: the path has only its end.
    Arrival(Vector3<f64>),
    /// Straight from the first to the second.
    Line(Vector3<f64>, Vector3<f64>),
    /// Round, in a plane of G-code, and along its normal.
    Arc(gcode::Arc),
    /// Round, through three points.
    Circle(robot::Arc),
    /// Into a hole and out again.
    Hole(Hole),
}

impl Way {
    /// Position and unit tangent at `t` from 0 to 1; the tangent is zero where there is none.
    pub fn at(&self, t: f64) -> Option<(Vector3<f64>, Vector3<f64>)> {
        match self {
            Way::Unlocated => None,
            Way::Arrival(end) => Some((*end, Vector3::zeros())),
            Way::Line(start, end) => {
                let position = if t < 1.0 { start.lerp(end, t) } else { *end };
                Some((position, direction(end - start)))
            }
            Way::Arc(arc) => Some(arc.at(t)),
            Way::Circle(arc) => Some(arc.at(t)),
            Way::Hole(hole) => Some(hole.at(t)),
        }
    }

    /// Length, mm, of what is known of it.
    pub fn length(&self) -> f64 {
        match self {
            Way::Unlocated | Way::Arrival(_) => 0.0,
            Way::Line(start, end) => (end - start).norm(),
            Way::Arc(arc) => arc.length(),
            Way::Circle(arc) => arc.length(),
            Way::Hole(hole) => hole.length_to(1.0),
        }
    }

    /// Into how many pieces it is split along which the tool turns by `turn_rad`; `None` when into more than a path may have points.
    pub fn pieces(&self, sampling: Sampling, turn_rad: f64) -> Option<usize> {
        let of_arc = |radius: f64, sweep: f64| {
            let of_arc = sampling.arc_pieces(radius, sweep, self.length())?;
            Some(of_arc.max(sampling.turning_pieces(0.0, turn_rad)?))
        };
        match self {
            Way::Unlocated => Some(0),
            Way::Arrival(_) => Some(1),
            Way::Line(..) => sampling.turning_pieces(self.length(), turn_rad),
            Way::Arc(arc) => of_arc(arc.radius(), arc.sweep_rad()),
            Way::Circle(arc) => of_arc(arc.radius(), arc.sweep_rad()),
            Way::Hole(hole) => Some(3 + sampling.line_pieces((hole.bottom - hole.clear).norm())?),
        }
    }
}

/// The way through one hole, mm in the workpiece frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hole {
    pub start: Vector3<f64>,
    /// Over the hole, as high as the tool comes.
    pub over: Vector3<f64>,
    /// At the plane R.
    pub clear: Vector3<f64>,
    pub bottom: Vector3<f64>,
    pub back: Vector3<f64>,
    /// Whether a series of holes begins here.
    pub is_first: bool,
}

impl Hole {
    /// Parameters of the corners of the way.
    const OVER: f64 = 0.125;
    const CLEAR: f64 = 0.25;
    const BOTTOM: f64 = 0.75;

    /// Parameters of its points; the feed into the hole is split into all but three of `pieces`.
    pub fn parameters(pieces: usize) -> impl Iterator<Item = f64> {
        let feeds = pieces.saturating_sub(3).max(1);
        let feed = move |k: usize| Hole::CLEAR + (Hole::BOTTOM - Hole::CLEAR) * (k as f64 / feeds as f64);
        [Hole::OVER, Hole::CLEAR].into_iter().chain((1..=feeds).map(feed)).chain([1.0])
    }

    /// Whether the tool feeds at parameter `t`.
    pub fn feeds_at(t: f64) -> bool {
        t > Hole::CLEAR && t <= Hole::BOTTOM
    }

    /// Position and unit tangent at `t` from 0 to 1.
    pub fn at(&self, t: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (from, to, s) = match t {
            _ if t <= Hole::OVER => (self.start, self.over, t / Hole::OVER),
            _ if t <= Hole::CLEAR => (self.over, self.clear, (t - Hole::OVER) / (Hole::CLEAR - Hole::OVER)),
            _ if t <= Hole::BOTTOM => (self.clear, self.bottom, (t - Hole::CLEAR) / (Hole::BOTTOM - Hole::CLEAR)),
            _ => (self.bottom, self.back, (t - Hole::BOTTOM) / (1.0 - Hole::BOTTOM)),
        };
        (if s < 1.0 { from.lerp(&to, s) } else { to }, direction(to - from))
    }

    /// Length of the way as far as `t`, mm.
    pub fn length_to(&self, t: f64) -> f64 {
        let corners =
            [(0.0, self.start), (Hole::OVER, self.over), (Hole::CLEAR, self.clear), (Hole::BOTTOM, self.bottom)];
        let ways = corners.iter().zip([Hole::OVER, Hole::CLEAR, Hole::BOTTOM, 1.0]);
        let way = |((from, begins), ends): (&(f64, Vector3<f64>), f64)| {
            if t <= *from { 0.0 } else { (self.at(t.min(ends)).0 - begins).norm() }
        };
        ways.map(way).sum()
    }
}
