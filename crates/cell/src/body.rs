//! Bodies, and how far they are apart in one state.

use nalgebra::{Isometry3, Point3};
use parry3d_f64::{
    math::{Pose, Rotation, Vector},
    shape::SupportMap,
};

use crate::{
    separation::Search,
    shape::{Piece, Shape, ShapeFault},
};

/// How well a body is known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum BodyGrade {
    /// Measured or drawn: its distances count.
    Given,
    /// Assumed, and certain to enclose the real one: it may reject a state, and its distances are lower bounds.
    Enclosing,
    /// Assumed: it may reject a state and never clears one, and its distances are none.
    #[default]
    Assumed,
}

impl BodyGrade {
    /// Returns whether a distance from the body is one, or a lower bound of one.
    #[must_use]
    pub fn clears(self) -> bool {
        self != BodyGrade::Assumed
    }
}

/// A body: convex shapes, fixed to a frame.
#[derive(Debug, Clone)]
pub struct Body {
    /// Its name, in answers.
    pub name: String,
    /// Index of its frame.
    pub frame: usize,
    /// How well it is known.
    pub grade: BodyGrade,
    pub(crate) pieces: Vec<Piece>,
    /// A ball around all of it in its frame.
    pub(crate) ball: (Vector, f64),
}

/// Reason why a body is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum BodyFault {
    /// It has no shapes.
    #[error("has no shapes: expected one or more")]
    NoShape,
    /// Its shape with this number, from 1, is none.
    #[error("shape {0} {1}")]
    Shape(usize, ShapeFault),
}

/// Directions of the points of an outline, from pole to pole and around.
const HEIGHTS: usize = 8;
const AZIMUTHS: usize = 24;

impl Body {
    /// Creates a body of `shapes` in frame `frame`.
    ///
    /// # Errors
    /// There are no shapes, or one has no volume.
    pub fn new(name: impl Into<String>, frame: usize, grade: BodyGrade, shapes: &[Shape]) -> Result<Body, BodyFault> {
        let pieces: Result<Vec<Piece>, BodyFault> = shapes
            .iter()
            .enumerate()
            .map(|(k, own)| Piece::new(own).map_err(|fault| BodyFault::Shape(k + 1, fault)))
            .collect();
        let pieces = pieces?;
        let Some(first) = pieces.first() else { return Err(BodyFault::NoShape) };
        let (mut low, mut high) = (first.ball.0, first.ball.0);
        for piece in &pieces {
            let (centre, radius) = piece.ball;
            (low, high) = (low.min(centre - Vector::splat(radius)), high.max(centre + Vector::splat(radius)));
        }
        let centre = 0.5 * (low + high);
        let radius = pieces.iter().fold(0.0, |most: f64, own| most.max((own.ball.0 - centre).length() + own.ball.1));
        Ok(Body { name: name.into(), frame, grade, pieces, ball: (centre, radius) })
    }

    /// Returns, for drawings, points of the surface of each of its shapes, with its frame at `at`: the farthest in evenly spread directions.
    #[must_use]
    pub fn outlines(&self, at: &Isometry3<f64>) -> Vec<Vec<Point3<f64>>> {
        let turn = |k: usize, of: usize| (k as f64 + 0.5) / of as f64 * std::f64::consts::TAU;
        let direction = |k: usize| {
            let (height, azimuth) = (libm::cos(0.5 * turn(k / AZIMUTHS, HEIGHTS)), turn(k % AZIMUTHS, AZIMUTHS));
            let across = (1.0 - height * height).sqrt();
            Vector::new(across * libm::cos(azimuth), across * libm::sin(azimuth), height)
        };
        let farthest = |piece: &Piece| {
            let point =
                |k: usize| at * point(piece.core.local_support_point(direction(k)) + direction(k) * piece.radius);
            let mut points: Vec<Point3<f64>> = (0..HEIGHTS * AZIMUTHS).map(point).collect();
            points.dedup();
            points
        };
        self.pieces.iter().map(farthest).collect()
    }

    /// Returns centre and radius of a ball around it, in its frame, mm.
    #[must_use]
    pub fn ball(&self) -> (Point3<f64>, f64) {
        (point(self.ball.0), self.ball.1)
    }
}

/// Distance of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Separation {
    /// Indices of the bodies.
    pub pair: [usize; 2],
    /// At most their distance, mm; where they overlap, minus a depth that is at least the true one.
    pub distance_mm: f64,
    /// A point of each that are so far apart, in the frame of the poses, mm.
    pub points_mm: [Point3<f64>; 2],
}

/// Bodies, and the pairs of them that are to be apart.
#[derive(Debug, Clone)]
pub struct Cell {
    pub(crate) bodies: Vec<Body>,
    pub(crate) pairs: Vec<[usize; 2]>,
}

impl Cell {
    /// Creates a cell of `bodies`. Pairs on one frame are none; `may_touch` says, by indices, which others are not looked at.
    #[must_use]
    pub fn new(bodies: Vec<Body>, may_touch: impl Fn(usize, usize) -> bool) -> Cell {
        let count = bodies.len();
        let all = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
        let pairs = all.filter(|&[a, b]| bodies[a].frame != bodies[b].frame && !may_touch(a, b)).collect();
        Cell { bodies, pairs }
    }

    /// Returns the bodies.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the pairs that are looked at, by indices of bodies.
    #[must_use]
    pub fn pairs(&self) -> &[[usize; 2]] {
        &self.pairs
    }

    /// Returns the distance of each pair, in the order of [`pairs`](Self::pairs), with the frames at `poses`.
    #[must_use]
    pub fn separations(&self, poses: &[Isometry3<f64>]) -> Vec<Separation> {
        let poses: Vec<Pose> = poses.iter().map(pose).collect();
        let mut search = Search::default();
        self.pairs.iter().map(|pair| self.separation(*pair, &poses, f64::INFINITY, &mut search)).collect()
    }

    /// Returns the pair that is nearest, or overlaps most, with the frames at `poses`; `None` without pairs.
    #[must_use]
    pub fn nearest(&self, poses: &[Isometry3<f64>]) -> Option<Separation> {
        self.nearest_of(poses, |_| true)
    }

    /// Returns as [`nearest`](Self::nearest), of the pairs that `is_asked` for.
    #[must_use]
    pub fn nearest_of(&self, poses: &[Isometry3<f64>], is_asked: impl Fn([usize; 2]) -> bool) -> Option<Separation> {
        let poses: Vec<Pose> = poses.iter().map(pose).collect();
        let mut search = Search::default();
        let mut best: Option<Separation> = None;
        for pair in self.pairs.iter().filter(|pair| is_asked(**pair)) {
            let below = best.map_or(f64::INFINITY, |known| known.distance_mm);
            let own = self.separation(*pair, &poses, below, &mut search);
            if own.distance_mm < below {
                best = Some(own);
            }
        }
        best
    }

    /// Returns the distance of a pair; where it is certain to be `below` or more, a lower bound that is not less.
    pub(crate) fn separation(&self, pair: [usize; 2], poses: &[Pose], below: f64, search: &mut Search) -> Separation {
        let [a, b] = pair.map(|index| &self.bodies[index]);
        let [on_a, on_b] = [poses[a.frame], poses[b.frame]];
        let between = on_a.inverse() * on_b;
        let mut best = balls_apart(a.ball, b.ball, &between);
        let mut found = None;
        if best.0 < below {
            let mut least = f64::INFINITY;
            for one in &a.pieces {
                for other in &b.pieces {
                    if balls_apart(one.ball, other.ball, &between).0 < least.min(below) {
                        let gap = search.gap(one, other, &between);
                        if gap.lower < least {
                            (least, found) = (gap.lower, Some(gap.points));
                        }
                    }
                }
            }
            if let Some(points) = found {
                best = (least, points);
            } else {
                best.0 = best.0.max(below);
            }
        }
        Separation { pair, distance_mm: best.0, points_mm: best.1.map(|own| point(on_a * own)) }
    }
}

/// Returns a lower bound of the distance of what is in two balls, and points of the balls that are so far apart, in the frame of the first.
fn balls_apart(a: (Vector, f64), b: (Vector, f64), between: &Pose) -> (f64, [Vector; 2]) {
    let centre = *between * b.0;
    let apart = centre - a.0;
    let length = apart.length();
    let normal = apart.try_normalize().unwrap_or(Vector::X);
    (length - a.1 - b.1, [a.0 + normal * a.1, centre - normal * b.1])
}

/// Returns a pose as parry has it.
pub(crate) fn pose(own: &Isometry3<f64>) -> Pose {
    let q = own.rotation.quaternion();
    Pose {
        rotation: Rotation::from_xyzw(q.i, q.j, q.k, q.w),
        translation: crate::shape::vector(&own.translation.vector),
    }
}

fn point(own: Vector) -> Point3<f64> {
    Point3::new(own.x, own.y, own.z)
}
