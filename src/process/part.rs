//! The finished part as its drawing has it: a closed surface of triangles, and how far a place is from it.

use std::sync::Arc;

use nalgebra::Vector3;
use parry3d_f64::{
    math::Vector,
    query::PointQuery,
    shape::{TriMesh, TriMeshFlags},
};

use super::stock::{StockMesh, StockShape};

/// The finished part, in the frame of the workpiece.
#[derive(Debug, Clone)]
pub(super) struct FinishedPart {
    /// Name of its file.
    pub name: String,
    /// Its surface, closed.
    pub mesh: Arc<StockMesh>,
    /// The same, for distances.
    #[cfg_attr(not(feature = "report"), expect(dead_code, reason = "only reports tell of it"))]
    pub surface: Arc<PartSurface>,
}

/// A hair: what a part may stick out of its stock, by rounding and by chords, mm.
const HAIR_MM: f64 = 0.1;

impl FinishedPart {
    /// Creates the part of a closed mesh.
    pub fn new(name: String, mesh: Arc<StockMesh>) -> Self {
        let surface = Arc::new(PartSurface::new(&mesh));
        Self { name, mesh, surface }
    }

    /// Fails unless the part is within its stock.
    pub fn check(&self, stock: &StockShape) -> Result<(), String> {
        let outside = stock.outside();
        let farthest =
            self.mesh.vertices.iter().map(|vertex| (outside(vertex), vertex)).max_by(|a, b| a.0.total_cmp(&b.0));
        match farthest.filter(|own| own.0 > HAIR_MM) {
            Some((by, at)) => Err(format!(
                "it sticks out of the stock by {by:.3} mm at ({:.3}, {:.3}, {:.3}) mm: expected it within, in mm and in the frame of the workpiece",
                at.x, at.y, at.z
            )),
            None => Ok(()),
        }
    }
}

/// How far outside a place is, mm.
type Outside<'a> = Box<dyn Fn(&Vector3<f64>) -> f64 + 'a>;

impl StockShape {
    /// Returns how far outside of the stock a place is, mm; not positive within.
    fn outside(&self) -> Outside<'_> {
        match self {
            StockShape::Box { min, max } => Box::new(move |at| (min - at).sup(&(at - max)).max()),
            StockShape::Cylinder { base, diameter_mm, height_mm } => Box::new(move |at| {
                let from = at - base;
                (from.xy().norm() - 0.5 * diameter_mm).max(-from.z).max(from.z - height_mm)
            }),
            StockShape::Mesh(mesh) => {
                let surface = PartSurface::new(mesh);
                Box::new(move |at| surface.distance_mm(at))
            }
        }
    }
}

/// A closed surface of triangles, ordered so that what is nearest to a place is found at once.
#[derive(Debug)]
pub(super) struct PartSurface(TriMesh);

impl PartSurface {
    /// Creates the surface of a closed mesh, which has triangles.
    pub fn new(mesh: &StockMesh) -> Self {
        let vertices = mesh.vertices.iter().map(|own| Vector::new(own.x, own.y, own.z)).collect();
        let surface = TriMesh::with_flags(vertices, mesh.triangles.clone(), TriMeshFlags::ORIENTED);
        Self(surface.expect("a closed mesh has triangles"))
    }

    /// Returns how far a place is from the nearest point of the surface, mm: positive outside, negative inside.
    pub fn distance_mm(&self, at: &Vector3<f64>) -> f64 {
        let at = Vector::new(at.x, at.y, at.z);
        let nearest = self.0.project_local_point(at, false);
        let distance = (nearest.point - at).length();
        if nearest.is_inside { -distance } else { distance }
    }
}
