//! The points of a path at which the lattice has turns: all of them, or as many as are far enough apart to turn by a step between them.

use crate::toolpath::PathPoint;

/// A point of the path at which the lattice has turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Knot {
    /// Index of the point.
    pub point: usize,
    /// How many points that count are nearest to it.
    pub weight: f64,
    /// Steps by which it may be turned from the knot before.
    pub band: usize,
    /// Time from the knot before at the programmed feed, s; infinite over a rapid move or where no feed is given.
    pub seconds: f64,
}

/// Length and time of the way to `point` from the one `before`, mm and s.
pub(super) fn way(before: &PathPoint, point: &PathPoint) -> (f64, f64) {
    let length = (point.arc_length_mm - before.arc_length_mm).max(0.0);
    let seconds = point.feed_mm_per_min.filter(|feed| *feed > 0.0).map_or(f64::INFINITY, |feed| 60.0 * length / feed);
    (length, seconds)
}

/// The knots of the path through `points`. `steps_per_mm`: by how many steps of the lattice it may be turned per length.
pub(super) fn knots(points: &[PathPoint], steps_per_mm: f64, counts: impl Fn(usize) -> bool) -> Vec<Knot> {
    // Rounding must not cost a step.
    let steps = |length: f64| (length * steps_per_mm + 1e-6).floor() as usize;
    let mut knots: Vec<Knot> = Vec::new();
    let (mut length, mut seconds) = (0.0, 0.0);
    for (point, at) in points.iter().enumerate() {
        if let Some(before) = point.checked_sub(1) {
            let (way_mm, way_s) = way(&points[before], at);
            length += way_mm;
            seconds += way_s;
        }
        if point == 0 || steps(length) > 0 || point + 1 == points.len() {
            knots.push(Knot { point, weight: 0.0, band: steps(length), seconds });
            (length, seconds) = (0.0, 0.0);
        }
    }
    let places: Vec<usize> = knots.iter().map(|knot| knot.point).collect();
    for point in (0..points.len()).filter(|point| counts(*point)) {
        let after = places.partition_point(|place| *place < point);
        let before = after.saturating_sub(1);
        let to = |knot: usize| (points[places[knot]].arc_length_mm - points[point].arc_length_mm).abs();
        let nearest = if to(before) <= to(after) { before } else { after };
        knots[nearest].weight += 1.0;
    }
    knots
}
