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
/// the axes are parted from one another as long as that takes volume off, at least one part in fifty.
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
    if volume_of(&own) < 0.0 {
        return Err(MeshFault::InsideOut);
    }
    let first = Part::new(own).ok_or(MeshFault::Flat)?;
    let least = first.volume / 50.0;
    let with_halves = |part: Part| (part.halved(), part);
    let gain = |(halves, part): &(Option<[Part; 2]>, Part)| {
        halves.as_ref().map_or(f64::NEG_INFINITY, |halves| part.volume - halves[0].volume - halves[1].volume)
    };
    let mut parts = if max_pieces > 1 { vec![with_halves(first)] } else { vec![(None, first)] };
    while parts.len() < max_pieces {
        let most = (0..parts.len()).max_by(|&a, &b| gain(&parts[a]).total_cmp(&gain(&parts[b])));
        let Some(most) = most.filter(|&most| gain(&parts[most]) > least) else { break };
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

/// Planes across each axis at which a part is halved on trial.
const PLANES: usize = 7;

impl Part {
    /// Returns the part of `triangles`; `None` if they lie in a plane.
    fn new(triangles: Triangles) -> Option<Part> {
        let mut corners: Vec<Vector> = triangles.iter().flatten().copied().collect();
        corners.sort_unstable_by(|a, b| a.to_array().map(f64::to_bits).cmp(&b.to_array().map(f64::to_bits)));
        corners.dedup();
        let (hull, faces) = try_convex_hull(&corners).ok()?;
        let volume = volume_of(&faces.iter().map(|face| face.map(|k| hull[k as usize])).collect::<Triangles>());
        (volume > 0.0).then_some(Part { triangles, hull, volume })
    }

    /// Returns the halves, cut across an axis, whose hulls have least volume together; `None` if no cut leaves two.
    fn halved(&self) -> Option<[Part; 2]> {
        let (low, high) =
            self.hull.iter().fold((self.hull[0], self.hull[0]), |(low, high), own| (low.min(*own), high.max(*own)));
        let cuts = (0..3).flat_map(|axis| (1..=PLANES).map(move |k| (axis, k as f64 / (PLANES + 1) as f64)));
        let halves = cuts.filter_map(|(axis, share)| {
            let at = low[axis] + share * (high[axis] - low[axis]);
            Some([Part::new(self.clipped(axis, at, 1.0))?, Part::new(self.clipped(axis, at, -1.0))?])
        });
        halves.min_by(|a, b| (a[0].volume + a[1].volume).total_cmp(&(b[0].volume + b[1].volume)))
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
