//! What a picture shows of a long path: not every point, but no peak is lost and no corner is cut.

use std::{cmp::Ordering, collections::BinaryHeap};

use nalgebra::Vector3;

/// Most points of a curve.
pub const MOST_POINTS: usize = 4000;

/// How many points of a path of `points` are one step of its curves: each gives its smallest and its largest value.
pub fn step(points: usize) -> usize {
    if points <= MOST_POINTS { 1 } else { points.div_ceil(MOST_POINTS / 2) }
}

/// A curve along a path, gathered point by point.
#[derive(Debug, Clone)]
pub struct Curve {
    step: usize,
    points: Vec<(f64, f64)>,
    /// Of the step under way: its number, and its smallest and its largest value with the point they belong to.
    under_way: Option<(usize, [Value; 2])>,
}

#[derive(Debug, Clone, Copy)]
struct Value {
    point: usize,
    x: f64,
    y: f64,
}

impl Curve {
    /// Along a path of `points`.
    pub fn new(points: usize) -> Self {
        Self { step: step(points), points: Vec::new(), under_way: None }
    }

    /// Takes the next point that has a value.
    pub fn add(&mut self, point: usize, x: f64, y: f64) {
        let value = Value { point, x, y };
        match &mut self.under_way {
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
                self.under_way = Some((point / self.step, [value; 2]));
            }
        }
    }

    fn end_step(&mut self) {
        let Some((_, mut ends)) = self.under_way.take() else { return };
        ends.sort_by_key(|value| value.point);
        let [first, last] = ends;
        self.points.push((first.x, first.y));
        if last.point != first.point {
            self.points.push((last.x, last.y));
        }
    }

    /// The points drawn, in the order of the path.
    pub fn points(&self) -> Vec<(f64, f64)> {
        let mut ended = self.clone();
        ended.end_step();
        ended.points
    }
}

/// Indices of the points at which a path through `positions` is drawn: all, or at most [`MOST_POINTS`], of which one half
/// is evenly spread, so that what is added to the path is seen everywhere, and the other half its sharpest corners with the
/// points beside them, as the cutting force changes there; or, where these do not show its shape, three times as many without.
pub fn drawn(positions: &[Vector3<f64>]) -> Vec<usize> {
    let count = positions.len();
    if count <= MOST_POINTS {
        return (0..count).collect();
    }
    let half = MOST_POINTS / 2;
    let mut drawn: Vec<usize> = (0..half).map(|k| k * (count - 1) / (half - 1)).collect();
    let corners = corners(positions, half);
    let few = half / 3;
    match corners.get(few).is_some_and(|(_, distance)| *distance > SEEN * extent(positions)) {
        true => drawn.extend(corners.iter().map(|(corner, _)| corner)),
        false => drawn.extend(corners.iter().take(few).flat_map(|(corner, _)| corner - 1..=corner + 1)),
    }
    drawn.sort_unstable();
    drawn.dedup();
    drawn
}

/// What is smaller than this share of the path's extent is not seen in its picture.
const SEEN: f64 = 2e-3;

/// Diagonal of the box around `positions`.
fn extent(positions: &[Vector3<f64>]) -> f64 {
    let nothing = [Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN)];
    let [low, high] = positions.iter().fold(nothing, |[low, high], at| [low.inf(at), high.sup(at)]);
    (high - low).norm()
}

/// A stretch of the path between two drawn points, and where it stands farthest off the straight line between them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stretch {
    first: usize,
    last: usize,
    farthest: usize,
    distance: f64,
}

impl Eq for Stretch {}

impl PartialOrd for Stretch {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Stretch {
    /// By distance; of two alike the earlier one is the larger.
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(other.first.cmp(&self.first))
    }
}

impl Stretch {
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

/// At most `most` points, each the one at which the path stands farthest off the lines through those before it
/// (Ramer, Douglas and Peucker), and how far that is, the farthest about first.
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
