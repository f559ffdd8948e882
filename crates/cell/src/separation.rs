//! Signed distance of two convex pieces, with a bound that does not come from the search for it.

use parry3d_f64::{
    math::{Pose, Vector},
    query::{
        epa::EPA,
        gjk::{self, CsoPoint, GJKResult, VoronoiSimplex},
    },
    shape::SupportMap,
};

use crate::shape::Piece;

/// Distance of two pieces in the frame of the first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gap {
    /// At most the distance, mm; where they overlap, minus a depth that is at least the true one.
    pub lower: f64,
    /// At least the distance, mm, as far as they do not overlap.
    pub upper: f64,
    /// Points on the two pieces that are so far apart.
    pub points: [Vector; 2],
}

impl Gap {
    /// Returns whether both bounds tell the distance.
    fn is_told(&self) -> bool {
        self.upper - self.lower < DOUBTFUL_MM
    }
}

/// Storage for searches.
#[derive(Default)]
pub(crate) struct Search {
    simplex: VoronoiSimplex,
    epa: EPA,
    /// Searches done.
    pub count: usize,
}

/// Distance of cores that counts as touching, mm.
const TOUCHING_MM: f64 = 1e-9;
/// Difference of bounds from which a search is done again from another direction, mm.
const DOUBTFUL_MM: f64 = 1e-4;
/// A bound that is better by less is left, mm.
const FINER_MM: f64 = 1e-6;
/// Directions across sides of which those next to them are tried.
const IMPROVED: usize = 6;

impl Search {
    /// Returns the gap between `a` and `b`, whose frame is `pos12` in that of `a`.
    pub fn gap(&mut self, a: &Piece, b: &Piece, pos12: &Pose) -> Gap {
        self.count += 1;
        let rounding = a.radius + b.radius;
        let between = *pos12 * b.ball.0 - a.ball.0;
        let starts = [between, Vector::X, Vector::Y, Vector::Z];
        let mut best: Option<(Gap, Vector)> = None;
        for start in starts {
            let Some(direction) = start.try_normalize() else { continue };
            self.simplex.reset(CsoPoint::from_shapes(pos12, &a.core, &b.core, direction));
            let found = gjk::closest_points(pos12, &a.core, &b.core, f64::MAX, true, &mut self.simplex);
            let core = match found {
                GJKResult::ClosestPoints(on_a, on_b, normal) if (on_b - on_a).length() > TOUCHING_MM => {
                    let apart = on_b - on_a;
                    let normal = apart.try_normalize().unwrap_or(normal);
                    let lower = along(a, b, pos12, normal);
                    Some((lower, apart.length(), [on_a, on_b], normal))
                }
                _ => self.overlap(a, b, pos12),
            };
            let Some((lower, upper, [on_a, on_b], normal)) = core else { continue };
            let gap = Gap {
                lower: lower - rounding,
                upper: upper - rounding,
                points: [on_a + normal * a.radius, on_b - normal * b.radius],
            };
            if best.is_none_or(|known| gap.lower > known.0.lower) {
                best = Some((gap, normal));
            }
            if gap.is_told() {
                break;
            }
        }
        if let Some((best, _)) = best.filter(|(own, _)| own.lower + rounding >= 0.0 && own.is_told()) {
            return best;
        }
        // Where faces are aligned but for rounding, a search may end at a side that is not the nearest, or fail.
        let spread = (0..DIRECTIONS).filter(|_| best.is_none()).map(spread_direction);
        let found = climbed(a, b, pos12, sides(a, b, pos12).into_iter().chain(spread), best.map(|own| own.1));
        match best {
            Some((best, _)) if found.lower <= best.lower + FINER_MM => best,
            Some((best, _)) => Gap { upper: best.upper.max(found.lower), ..found },
            None => found,
        }
    }

    /// Returns the overlap of two cores that touch: minus the depth, twice, the points and the normal; `None` where the search fails.
    fn overlap(&mut self, a: &Piece, b: &Piece, pos12: &Pose) -> Option<(f64, f64, [Vector; 2], Vector)> {
        let (on_a, on_b, normal) = self.epa.closest_points(pos12, &a.core, &b.core, &self.simplex)?;
        let normal = normal.try_normalize()?;
        let lower = along(a, b, pos12, normal);
        let upper = (on_b - on_a).dot(normal).min(0.0);
        Some((lower, upper.max(lower), [on_a, on_b], normal))
    }
}

/// Returns how far the core of `b` lies beyond that of `a` along `normal`, of length 1: no more than their distance, whatever the normal.
fn along(a: &Piece, b: &Piece, pos12: &Pose, normal: Vector) -> f64 {
    b.core.support_point(pos12, -normal).dot(normal) - a.core.local_support_point(normal).dot(normal)
}

/// Returns the directions across the faces of both cores and along their axes, and across two of their axes, both ways.
fn sides(a: &Piece, b: &Piece, pos12: &Pose) -> Vec<Vector> {
    let turned = |own: Vec<Vector>| own.into_iter().map(|own| pos12.rotation * own).collect::<Vec<_>>();
    let (axes, beside) = (a.core.axes(), turned(b.core.axes()));
    // Of two hulls there are too many.
    let is_few = axes.len().min(beside.len()) <= 3;
    let across = axes.iter().filter(|_| is_few).flat_map(|axis| beside.iter().map(|other| axis.cross(*other)));
    let all = a.core.sides().into_iter().chain(turned(b.core.sides())).chain(across);
    all.filter_map(|own| own.try_normalize()).flat_map(|own| [own, -own]).collect()
}

/// Directions that are tried where a search fails.
const DIRECTIONS: usize = 400;
/// Turn from one of them to the next, which spreads them evenly, rad.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
/// Smallest step of a direction, rad.
const SMALLEST_STEP: f64 = 1e-7;

/// Returns one of [`DIRECTIONS`] that are spread over the sphere.
fn spread_direction(k: usize) -> Vector {
    let z = 1.0 - (2 * k + 1) as f64 / DIRECTIONS as f64;
    let turn = k as f64 * GOLDEN_ANGLE;
    let across = (1.0 - z * z).sqrt();
    Vector::new(across * libm::cos(turn), across * libm::sin(turn), z)
}

/// Returns a gap of which only the lower bound is known: the largest along the best of `directions` and `other`, and those next to them.
fn climbed(a: &Piece, b: &Piece, pos12: &Pose, directions: impl Iterator<Item = Vector>, other: Option<Vector>) -> Gap {
    let bound = |own: Vector| (along(a, b, pos12, own), own);
    let mut best: Vec<(f64, Vector)> = directions.map(bound).collect();
    best.sort_by(|one, other| other.0.total_cmp(&one.0));
    best.truncate(IMPROVED);
    best.extend(other.map(bound));
    // Across the axis of a round core the bound has a ridge, along which no fixed pair of directions leads.
    let axes = [a.core.axes(), b.core.axes().into_iter().map(|own| pos12.rotation * own).collect()];
    let ridges: Vec<Vector> = axes.into_iter().filter(|own| own.len() == 1).flatten().collect();
    let improved = best.into_iter().map(|own| improved(a, b, pos12, &ridges, own));
    let (lower, normal) = improved.max_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or(bound(Vector::X));
    let on_a = a.core.local_support_point(normal);
    let rounding = a.radius + b.radius;
    let points = [on_a + normal * a.radius, on_a + normal * (lower - b.radius)];
    Gap { lower: lower - rounding, upper: f64::INFINITY, points }
}

/// Returns a bound and its direction that no direction next to it betters by more than [`FINER_MM`], from one such.
fn improved(
    a: &Piece,
    b: &Piece,
    pos12: &Pose,
    ridges: &[Vector],
    (mut lower, mut normal): (f64, Vector),
) -> (f64, Vector) {
    let mut step = 0.1;
    while step > SMALLEST_STEP {
        let (u, v) = normal.any_orthonormal_pair();
        let along_ridges = ridges.iter().filter_map(|axis| axis.cross(normal).try_normalize());
        let sides = [u, v].into_iter().chain(along_ridges).flat_map(|side| [side, -side]);
        let tried = sides.map(|side| (normal + side * step).normalize());
        match tried.map(|own| (along(a, b, pos12, own), own)).max_by(|one, other| one.0.total_cmp(&other.0)) {
            Some((higher, own)) if higher > lower + FINER_MM => (lower, normal) = (higher, own),
            _ => step *= 0.5,
        }
    }
    (lower, normal)
}
