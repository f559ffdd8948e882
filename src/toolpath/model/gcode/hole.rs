//! The way through one hole of a cycle.

use nalgebra::Vector3;

use crate::toolpath::model::path::direction;

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
