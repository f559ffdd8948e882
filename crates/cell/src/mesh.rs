//! Closed surfaces of triangles as convex pieces that enclose them.

use std::collections::HashMap;

use nalgebra::Point3;
use parry3d_f64::{math::Vector, transformation::try_convex_hull};

use crate::shape::{Shape, vector};

/// Reason why a mesh is no body.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MeshFault {
    /// There are no triangles, or more than [`MAX_TRIANGLES`].
    #[error("has {0} triangles: expected 1 to {MAX_TRIANGLES}")]
    Count(usize),
    /// A vertex is not finite.
    #[error("has a vertex that is not finite")]
    NotFinite,
    /// An edge is not run through once in each direction: its ends, mm.
    #[error(
        "is open at the edge from {0} to {1} mm: expected a closed surface, each edge of two triangles that go round in one sense"
    )]
    Open(Point3<f64>, Point3<f64>),
    /// Its triangles point inwards.
    #[error("is inside out: expected triangles whose corners go round anticlockwise, seen from outside")]
    InsideOut,
    /// It has no volume.
    #[error("has no volume")]
    Flat,
}

/// Most triangles of a mesh.
pub const MAX_TRIANGLES: usize = 2_000_000;

/// Triangles, mm.
type Triangles = Vec<[Vector; 3]>;

/// Returns at most `max_pieces` convex hulls that together enclose the closed mesh of `triangles` (corners, mm): halves by planes across
/// the axes are parted from one another until the hulls have at most a fiftieth more volume than the mesh.
///
/// # Errors
/// The mesh is not closed, inside out, flat, too large, or not finite.
pub fn pieces_of_mesh(triangles: &[[Point3<f64>; 3]], max_pieces: usize) -> Result<Vec<Shape>, MeshFault> {
    if triangles.is_empty() || triangles.len() > MAX_TRIANGLES {
        return Err(MeshFault::Count(triangles.len()));
    }
    if !triangles.iter().flatten().all(|own| own.coords.iter().all(|x| x.is_finite())) {
        return Err(MeshFault::NotFinite);
    }
    check_closed(triangles)?;
    let own: Triangles = triangles.iter().map(|corners| corners.map(|own| vector(&own.coords))).collect();
    let enclosed = volume_of(&own);
    if enclosed < 0.0 {
        return Err(MeshFault::InsideOut);
    }
    let first = Part::new(own).ok_or(MeshFault::Flat)?;
    let whole = first.volume;
    let with_halves = |part: Part| (part.halved(), part);
    let gain = |(halves, part): &(Option<[Part; 2]>, Part)| {
        halves.as_ref().map_or(f64::NEG_INFINITY, |halves| part.volume - halves[0].volume - halves[1].volume)
    };
    let mut parts = if max_pieces > 1 { vec![with_halves(first)] } else { vec![(None, first)] };
    // Halves of a ring take no volume off, and theirs do: where nothing is gained, the largest is halved.
    let gained = |own: &_| if gain(own) > whole / 50.0 { whole + gain(own) } else { own.1.volume };
    while parts.len() < max_pieces && parts.iter().map(|own| own.1.volume).sum::<f64>() > 1.02 * enclosed {
        let open = (0..parts.len()).filter(|&k| parts[k].0.is_some());
        let Some(most) = open.max_by(|&a, &b| gained(&parts[a]).total_cmp(&gained(&parts[b]))) else { break };
        if let Some(halves) = parts[most].0.take() {
            parts.splice(most..=most, halves.map(with_halves));
        }
    }
    let hull =
        |part: Part| Shape::Hull { points_mm: part.hull.iter().map(|own| Point3::new(own.x, own.y, own.z)).collect() };
    Ok(parts.into_iter().map(|(_, part)| hull(part)).collect())
}

/// A part of a mesh and its hull.
struct Part {
    triangles: Triangles,
    hull: Vec<Vector>,
    volume: f64,
}

/// Slabs across each axis between which a part is halved on trial.
const SLABS: usize = 8;
/// Triangles by which a cut is tried, but for the large ones.
const TRIED: usize = 1000;
/// Share of the volume that a cut at an end must take off more than one in the middle.
const EVEN: f64 = 0.01;

impl Part {
    /// Returns the part of `triangles`; `None` if they lie in a plane.
    fn new(triangles: Triangles) -> Option<Part> {
        let (hull, volume) = hull_of(triangles.iter().flatten().copied().collect())?;
        Some(Part { triangles, hull, volume })
    }

    /// Returns the halves, cut across an axis, whose hulls have least volume together, of like ones those of like size; `None` if no cut leaves two.
    fn halved(&self) -> Option<[Part; 2]> {
        let cuts = (0..3).flat_map(|axis| self.cuts(axis));
        let (_, axis, at) = cuts.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some([Part::new(self.clipped(axis, at, 1.0))?, Part::new(self.clipped(axis, at, -1.0))?])
    }

    /// Returns the planes across `axis` on trial: the volume of the hulls of both halves, more away from the middle, the axis, and where.
    fn cuts(&self, axis: usize) -> Vec<(f64, usize, f64)> {
        let ends = self.hull.iter().map(|own| own[axis]);
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let plane = |k: usize| low + k as f64 / SLABS as f64 * (high - low);
        let slab = |own: Vector| (((own[axis] - low) / (high - low) * SLABS as f64) as usize).min(SLABS - 1);
        let mut slabs: Vec<Vec<Vector>> = vec![Vec::new(); SLABS];
        // Of many, the large ones and some of the others: a trial need not be exact.
        let area = |[a, b, c]: &[Vector; 3]| (*b - *a).cross(*c - *a).length();
        let large = self.triangles.iter().map(area).sum::<f64>() / TRIED as f64;
        let stride = self.triangles.len() / TRIED + 1;
        let tried = self.triangles.iter().enumerate();
        for (_, corners) in tried.filter(|(k, own)| k % stride == 0 || area(own) >= large) {
            for (a, b) in (0..3).map(|k| (corners[k], corners[(k + 1) % 3])) {
                let (from, to) = (slab(a), slab(b));
                slabs[from].push(a);
                for k in from.min(to)..from.max(to) {
                    let crossing = a + (b - a) * ((plane(k + 1) - a[axis]) / (b[axis] - a[axis]));
                    slabs[k].push(crossing);
                    slabs[k + 1].push(crossing);
                }
            }
        }
        // The hull of hulls is that of their points, of which there are few.
        let hulls: Vec<Vec<Vector>> =
            slabs.into_iter().map(|own| hull_of(own.clone()).map_or(own, |own| own.0)).collect();
        let cut = |k: usize| {
            let volume = hull_of(hulls[..k].concat())?.1 + hull_of(hulls[k..].concat())?.1;
            let uneven = EVEN * self.volume * (k as f64 / SLABS as f64 - 0.5).abs();
            Some((volume + uneven, axis, plane(k)))
        };
        (1..SLABS).filter_map(cut).collect()
    }

    /// Returns what of the triangles lies on the side `sign` of the plane. With the mesh closed, what closes it there lies in the hull of that.
    fn clipped(&self, axis: usize, at: f64, sign: f64) -> Triangles {
        let mut kept = Vec::new();
        for corners in &self.triangles {
            let beyond = corners.map(|own| sign * (own[axis] - at));
            if beyond.iter().all(|own| *own >= 0.0) {
                kept.push(*corners);
                continue;
            }
            let mut polygon: Vec<Vector> = Vec::with_capacity(4);
            for k in 0..3 {
                let (here, next) = (k, (k + 1) % 3);
                if beyond[here] >= 0.0 {
                    polygon.push(corners[here]);
                }
                if (beyond[here] < 0.0) != (beyond[next] < 0.0) {
                    let share = beyond[here] / (beyond[here] - beyond[next]);
                    polygon.push(corners[here] + (corners[next] - corners[here]) * share);
                }
            }
            kept.extend((2..polygon.len()).map(|k| [polygon[0], polygon[k - 1], polygon[k]]));
        }
        kept
    }
}

/// Returns the corners of the hull of points and its volume, mm³; `None` if they lie in a plane.
fn hull_of(mut points: Vec<Vector>) -> Option<(Vec<Vector>, f64)> {
    points.sort_unstable_by(|a, b| a.to_array().map(f64::to_bits).cmp(&b.to_array().map(f64::to_bits)));
    points.dedup();
    let (hull, faces) = try_convex_hull(&points).ok()?;
    let volume = volume_of(&faces.iter().map(|face| face.map(|k| hull[k as usize])).collect::<Triangles>());
    (volume > 0.0).then_some((hull, volume))
}

/// Returns the volume that triangles enclose, mm³; negative where they point inwards.
fn volume_of(triangles: &[[Vector; 3]]) -> f64 {
    triangles.iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum()
}

/// Fails unless each edge is run through once in each direction.
fn check_closed(triangles: &[[Point3<f64>; 3]]) -> Result<(), MeshFault> {
    let key = |own: &Point3<f64>| [own.x, own.y, own.z].map(|x| (x + 0.0).to_bits());
    let mut edges: HashMap<[[u64; 3]; 2], i64> = HashMap::with_capacity(2 * triangles.len());
    for corners in triangles {
        for k in 0..3 {
            let [a, b] = [key(&corners[k]), key(&corners[(k + 1) % 3])];
            if a < b { *edges.entry([a, b]).or_default() += 1 } else { *edges.entry([b, a]).or_default() -= 1 }
        }
    }
    let open = edges.iter().filter(|(_, count)| **count != 0).map(|(edge, _)| *edge).min();
    open.map_or(Ok(()), |edge| {
        let [from, to] = edge.map(|own| Point3::from(own.map(f64::from_bits)));
        Err(MeshFault::Open(from, to))
    })
}
