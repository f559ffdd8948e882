//! Knots: the path points at which the lattice has nodes. All points, or as many as are far enough apart to rotate by a step between them.

use crate::toolpath::PathPoint;

/// A path point at which the lattice has nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Index of the path point.
    pub point: usize,
    /// Number of counted points nearest to it.
    pub weight: f64,
    /// Most steps of γ from the knot before.
    pub band: usize,
    /// Time from the knot before at the programmed feed, s; infinite over a rapid move or where no feed is given.
    pub seconds: f64,
}

/// Length (mm) of the path from `before` to `point`, and its time (s) at the programmed feed: infinite for rapid moves or without feed.
pub(super) fn length_and_time(before: &PathPoint, point: &PathPoint) -> (f64, f64) {
    let length = (point.arc_length_mm - before.arc_length_mm).max(0.0);
    let seconds = point.feed_mm_per_min.filter(|feed| *feed > 0.0).map_or(f64::INFINITY, |feed| 60.0 * length / feed);
    (length, seconds)
}

/// Finds the knots: first and last point, and where γ may change by a step (`steps_per_mm`); points passing `counts` weigh the nearest one.
pub(super) fn find_knots(points: &[PathPoint], steps_per_mm: f64, counts: impl Fn(usize) -> bool) -> Vec<Knot> {
    // Rounding must not cost a step.
    let steps = |length: f64| (length * steps_per_mm + 1e-6).floor() as usize;
    let mut knots: Vec<Knot> = Vec::new();
    let (mut length, mut seconds) = (0.0, 0.0);
    for (point, here) in points.iter().enumerate() {
        if let Some(before) = point.checked_sub(1) {
            let (length_mm, time_s) = length_and_time(&points[before], here);
            length += length_mm;
            seconds += time_s;
        }
        if point == 0 || steps(length) > 0 || point + 1 == points.len() {
            knots.push(Knot { point, weight: 0.0, band: steps(length), seconds });
            (length, seconds) = (0.0, 0.0);
        }
    }
    let knot_points: Vec<usize> = knots.iter().map(|knot| knot.point).collect();
    for point in (0..points.len()).filter(|point| counts(*point)) {
        let after = knot_points.partition_point(|knot_point| *knot_point < point);
        let before = after.saturating_sub(1);
        let distance = |knot: usize| (points[knot_points[knot]].arc_length_mm - points[point].arc_length_mm).abs();
        let nearest = if distance(before) <= distance(after) { before } else { after };
        knots[nearest].weight += 1.0;
    }
    knots
}
