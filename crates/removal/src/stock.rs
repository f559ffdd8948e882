//! The stock before any cut.

use nalgebra::{Vector2, Vector3};

use crate::error::{RemovalError, finite, positive};
use crate::mesh::Mesh;
use crate::sweep::norm;

/// The stock before any cut, in the frame of the workpiece, whose z axis is parallel to the tool and leads to the spindle. Lengths in mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Stock {
    pub(crate) shape: Shape,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    /// Between two corners.
    Box { low: Vector3<f64>, high: Vector3<f64> },
    /// About a vertical axis through `centre`, between two heights.
    Cylinder { centre: Vector2<f64>, radius: f64, bottom: f64, top: f64 },
    /// Inside a closed surface of triangles.
    Mesh(Mesh),
}

impl Stock {
    /// Makes a box between two corners. Fails unless `high` is above `low` on each axis.
    pub fn cuboid(low: Vector3<f64>, high: Vector3<f64>) -> Result<Self, RemovalError> {
        finite("lower corner of the stock", &low)?;
        finite("upper corner of the stock", &high)?;
        if (high - low).min() <= 0.0 {
            return Err(RemovalError::EmptyBox { low: low.into(), high: high.into() });
        }
        Ok(Self { shape: Shape::Box { low, high } })
    }

    /// Makes a cylinder along z that stands on the circle about `base`. Fails if diameter or height are not positive.
    pub fn cylinder(base: Vector3<f64>, diameter_mm: f64, height_mm: f64) -> Result<Self, RemovalError> {
        finite("base of the stock", &base)?;
        let radius = positive("diameter of the stock", diameter_mm)? / 2.0;
        let top = base.z + positive("height of the stock", height_mm)?;
        Ok(Self { shape: Shape::Cylinder { centre: base.xy(), radius, bottom: base.z, top } })
    }

    /// Makes the inside of a closed surface of `triangles`, each three numbers of `vertices`. Fails if a number is out of range, a vertex is
    /// not finite, or an edge does not join exactly two triangles of the same sense.
    pub fn mesh(vertices: Vec<Vector3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self, RemovalError> {
        Ok(Self { shape: Shape::Mesh(Mesh::new(vertices, triangles)?) })
    }

    /// Returns the corners of the box about the stock, mm.
    #[must_use]
    pub fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        match &self.shape {
            Shape::Box { low, high } => (*low, *high),
            Shape::Cylinder { centre, radius, bottom, top } => (
                Vector3::new(centre.x - radius, centre.y - radius, *bottom),
                Vector3::new(centre.x + radius, centre.y + radius, *top),
            ),
            Shape::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// Appends the intervals of z in which there is stock over `p`, rising, to `spans`.
    pub(crate) fn spans(&self, p: Vector2<f64>, spans: &mut Vec<[f64; 2]>) {
        match &self.shape {
            Shape::Box { low, high } => {
                if p.x > low.x && p.x < high.x && p.y > low.y && p.y < high.y {
                    spans.push([low.z, high.z]);
                }
            }
            Shape::Cylinder { centre, radius, bottom, top } => {
                if (p - centre).norm_squared() < radius * radius {
                    spans.push([*bottom, *top]);
                }
            }
            Shape::Mesh(mesh) => mesh.spans(p, spans),
        }
    }

    /// Whether the stock is the same over all of a rectangle with the corners `low` and `high`, or nowhere over it; false if not sure.
    pub(crate) fn is_uniform(&self, low: Vector2<f64>, high: Vector2<f64>) -> bool {
        match &self.shape {
            Shape::Box { low: l, high: h } => low.x >= l.x && low.y >= l.y && high.x <= h.x && high.y <= h.y,
            Shape::Cylinder { centre, radius, .. } => {
                let (a, b) = (low - centre, high - centre);
                norm(a.x.abs().max(b.x.abs()), a.y.abs().max(b.y.abs())) < *radius
            }
            Shape::Mesh(mesh) => mesh.is_uniform(low, high),
        }
    }
}
