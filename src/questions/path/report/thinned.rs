//! Curves and polylines with few points for the figures of a long path: peaks and corners are kept.

use std::{cmp::Ordering, collections::BinaryHeap};

use nalgebra::Vector3;

/// Most points of a curve.
pub const MAX_POINTS: usize = 4000;

/// Returns how many of the `points` of a path make one step of a curve, of which the smallest and the largest value are drawn.
pub fn points_per_step(points: usize) -> usize {
    if points <= MAX_POINTS { 1 } else { points.div_ceil(MAX_POINTS / 2) }
}

/// A curve along a path, collected point by point; a long one keeps the smallest and largest value of each step.
#[derive(Debug, Clone)]
pub struct Curve {
    step: usize,
    points: Vec<(f64, f64)>,
    /// The current step: its index, and its smallest and its largest value.
    current_step: Option<(usize, [CurvePoint; 2])>,
}

/// A value of a curve at a point of the path.
#[derive(Debug, Clone, Copy)]
struct CurvePoint {
    point: usize,
    x: f64,
    y: f64,
}

impl Curve {
    /// Makes an empty curve for a path of `points` points.
    pub fn new(points: usize) -> Self {
        Self { step: points_per_step(points), points: Vec::new(), current_step: None }
    }

    /// Adds the value `y` at the point with index `point`, drawn at `x`.
    pub fn add(&mut self, point: usize, x: f64, y: f64) {
        let value = CurvePoint { point, x, y };
        match &mut self.current_step {
            Some((step, [least, most])) if *step == point / self.step => {
                if y < least.y {
                    *least = value;
                }
                if y > most.y {
                    *most = value;
                }
            }
            _ => {
                self.end_step();
                self.current_step = Some((point / self.step, [value; 2]));
            }
        }
    }

    /// Moves the extremes of the current step, in path order, to the points drawn.
    fn end_step(&mut self) {
        let Some((_, mut ends)) = self.current_step.take() else { return };
        ends.sort_by_key(|value| value.point);
        let [first, last] = ends;
        self.points.push((first.x, first.y));
        if last.point != first.point {
            self.points.push((last.x, last.y));
        }
    }

    /// Returns the points drawn, in path order.
    pub fn points(&self) -> Vec<(f64, f64)> {
        let mut ended = self.clone();
        ended.end_step();
        ended.points
    }
}

/// Returns the indices of the points at which a path through `positions` is drawn: all, or at most [`MAX_POINTS`], one half evenly spread,
/// the other the sharpest corners, with their neighbours where the shape does not need more corners.
pub fn drawn_indices(positions: &[Vector3<f64>]) -> Vec<usize> {
    let count = positions.len();
    if count <= MAX_POINTS {
        return (0..count).collect();
    }
    let half = MAX_POINTS / 2;
    let mut drawn: Vec<usize> = (0..half).map(|k| k * (count - 1) / (half - 1)).collect();
    let corners = corners(positions, half);
    let few = half / 3;
    match corners.get(few).is_some_and(|(_, distance)| *distance > VISIBLE_SHARE * box_diagonal(positions)) {
        true => drawn.extend(corners.iter().map(|(corner, _)| corner)),
        false => drawn.extend(corners.iter().take(few).flat_map(|(corner, _)| corner - 1..=corner + 1)),
    }
    drawn.sort_unstable();
    drawn.dedup();
    drawn
}

/// Smallest deviation that is visible in a figure, as a share of the path's extent.
const VISIBLE_SHARE: f64 = 2e-3;

/// Returns the diagonal of the box around `positions`, in their unit.
fn box_diagonal(positions: &[Vector3<f64>]) -> f64 {
    let empty_box = [Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN)];
    let [low, high] = positions.iter().fold(empty_box, |[low, high], at| [low.inf(at), high.sup(at)]);
    (high - low).norm()
}

/// A stretch of the path between two drawn points, with its point farthest from the chord between them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stretch {
    first: usize,
    last: usize,
    farthest: usize,
    distance: f64,
}

impl Eq for Stretch {}

impl PartialOrd for Stretch {
    /// Compares as [`Ord`] does; never `None`.
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Stretch {
    /// Compares by distance; of equal distances the earlier stretch is the larger.
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(other.first.cmp(&self.first))
    }
}

impl Stretch {
    /// Finds the point between `first` and `last` that is farthest from the chord.
    fn new(positions: &[Vector3<f64>], first: usize, last: usize) -> Self {
        let (start, chord) = (positions[first], positions[last] - positions[first]);
        let length = chord.norm();
        let direction = if length > 0.0 { chord / length } else { Vector3::zeros() };
        let mut stretch = Self { first, last, farthest: first, distance: 0.0 };
        for (point, position) in positions.iter().enumerate().take(last).skip(first + 1) {
            let from_start = position - start;
            let nearest = direction * from_start.dot(&direction).clamp(0.0, length);
            let distance = (from_start - nearest).norm();
            if distance > stretch.distance {
                (stretch.farthest, stretch.distance) = (point, distance);
            }
        }
        stretch
    }
}

/// Returns at most `most` corners with their distance from the polyline through those before (Ramer, Douglas and Peucker).
fn corners(positions: &[Vector3<f64>], most: usize) -> Vec<(usize, f64)> {
    let mut stretches = BinaryHeap::from([Stretch::new(positions, 0, positions.len() - 1)]);
    let mut corners = Vec::new();
    while corners.len() < most {
        let Some(Stretch { first, last, farthest, distance }) = stretches.pop() else { break };
        if distance == 0.0 {
            break;
        }
        corners.push((farthest, distance));
        stretches.push(Stretch::new(positions, first, farthest));
        stretches.push(Stretch::new(positions, farthest, last));
    }
    corners
}
