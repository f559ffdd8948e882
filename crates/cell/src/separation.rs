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

impl Search {
    /// Returns the gap between `a` and `b`, whose frame is `pos12` in that of `a`.
    pub fn gap(&mut self, a: &Piece, b: &Piece, pos12: &Pose) -> Gap {
        self.count += 1;
        let rounding = a.radius + b.radius;
        let between = *pos12 * b.ball.0 - a.ball.0;
        let starts = [between, Vector::X, Vector::Y, Vector::Z];
        let mut best: Option<Gap> = None;
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
            if best.is_none_or(|known| gap.lower > known.lower) {
                best = Some(gap);
            }
            if gap.upper - gap.lower < DOUBTFUL_MM {
                break;
            }
        }
        best.unwrap_or_else(|| sampled(a, b, pos12))
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

/// Directions that are tried where a search fails.
const DIRECTIONS: usize = 400;
/// Turn from one of them to the next, which spreads them evenly, rad.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
/// Smallest step of a direction, rad.
const SMALLEST_STEP: f64 = 1e-7;

/// Returns a gap of which only the lower bound is known: the largest of those along directions spread over the sphere.
fn sampled(a: &Piece, b: &Piece, pos12: &Pose) -> Gap {
    let mut best = (f64::NEG_INFINITY, Vector::X);
    for k in 0..DIRECTIONS {
        let z = 1.0 - (2 * k + 1) as f64 / DIRECTIONS as f64;
        let turn = k as f64 * GOLDEN_ANGLE;
        let across = (1.0 - z * z).sqrt();
        let normal = Vector::new(across * libm::cos(turn), across * libm::sin(turn), z);
        let lower = along(a, b, pos12, normal);
        if lower > best.0 {
            best = (lower, normal);
        }
    }
    let (mut lower, mut normal) = best;
    let mut step = 0.1;
    while step > SMALLEST_STEP {
        let (u, v) = normal.any_orthonormal_pair();
        let tried = [u, -u, v, -v].map(|side| (normal + side * step).normalize());
        let next = tried.map(|own| (along(a, b, pos12, own), own));
        match next.into_iter().max_by(|one, other| one.0.total_cmp(&other.0)) {
            Some((higher, own)) if higher > lower => (lower, normal) = (higher, own),
            _ => step *= 0.5,
        }
    }
    let on_a = a.core.local_support_point(normal);
    let rounding = a.radius + b.radius;
    let points = [on_a + normal * a.radius, on_a + normal * (lower - b.radius)];
    Gap { lower: lower - rounding, upper: f64::INFINITY, points }
}
