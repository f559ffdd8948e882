//! Convex shapes, each a core and a distance around it.

use nalgebra::{Isometry3, Point3, Vector3};
use parry3d_f64::{math::Vector, shape::SupportMap, transformation::try_convex_hull, utils::point_cloud_support_point};

/// A convex shape in the frame of its body, mm.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// All places within `radius_mm` of a segment: a capsule, and a ball where both ends are one.
    Capsule {
        /// Ends of the segment, mm.
        ends_mm: [Point3<f64>; 2],
        /// Distance around it, mm.
        radius_mm: f64,
    },
    /// A box about the origin of `pose`, along its axes.
    Cuboid {
        /// Where its centre is and how it is turned.
        pose: Isometry3<f64>,
        /// Its lengths, mm.
        size_mm: Vector3<f64>,
    },
    /// A cylinder with flat ends.
    Cylinder {
        /// Centres of its ends, mm.
        ends_mm: [Point3<f64>; 2],
        /// Its radius, mm.
        radius_mm: f64,
    },
    /// The convex hull of points.
    Hull {
        /// The points, mm; those inside are left out.
        points_mm: Vec<Point3<f64>>,
    },
}

/// Reason why a shape is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ShapeFault {
    /// A number is not finite.
    #[error("has a number that is not finite")]
    NotFinite,
    /// A radius or a length is not positive, or the ends of a cylinder are one.
    #[error("has no volume: expected positive lengths")]
    Empty,
    /// The points of a hull lie in a plane or are fewer than four.
    #[error("has its points in a plane: expected four or more that are not")]
    Flat,
}

/// A hull of less volume than this share of the cube over its diagonal is flat.
const FLAT: f64 = 1e-9;

/// A core that GJK knows by its support points.
#[derive(Debug, Clone)]
pub(crate) enum Core {
    Segment([Vector; 2]),
    Cuboid {
        centre: Vector,
        half_axes: [Vector; 3],
    },
    Cylinder {
        centre: Vector,
        half_axis: Vector,
        direction: Vector,
        radius: f64,
    },
    /// Corners, directions across faces, and edges.
    Hull(Vec<Vector>, [Vec<Vector>; 2]),
}

/// A shape as it is computed with.
#[derive(Debug, Clone)]
pub(crate) struct Piece {
    pub core: Core,
    /// Distance around the core, mm.
    pub radius: f64,
    /// A ball around all of it: centre and radius, mm.
    pub ball: (Vector, f64),
}

pub(crate) fn vector(own: &Vector3<f64>) -> Vector {
    Vector::new(own.x, own.y, own.z)
}

impl Core {
    /// Directions of its edges or its axis.
    pub(crate) fn axes(&self) -> Vec<Vector> {
        match self {
            Core::Segment([a, b]) => vec![*b - *a],
            Core::Cuboid { half_axes, .. } => half_axes.to_vec(),
            Core::Cylinder { direction, .. } => vec![*direction],
            Core::Hull(_, [_, edges]) => edges.clone(),
        }
    }

    /// Directions across its flat faces, or along its axis.
    pub(crate) fn sides(&self) -> Vec<Vector> {
        match self {
            Core::Hull(_, [across, _]) => across.clone(),
            _ => self.axes(),
        }
    }
}

impl SupportMap for Core {
    fn local_support_point(&self, direction: Vector) -> Vector {
        match self {
            Core::Segment(ends) => point_cloud_support_point(direction, ends),
            Core::Cuboid { centre, half_axes } => {
                half_axes.iter().fold(*centre, |at, half| at + *half * 1f64.copysign(half.dot(direction)))
            }
            Core::Cylinder { centre, half_axis, direction: axis, radius } => {
                let end = *centre + *half_axis * 1f64.copysign(half_axis.dot(direction));
                let off_axis = |own: Vector| own - *axis * axis.dot(own);
                // Of a direction along the axis only rounding is left, which may point along it, too.
                let across = off_axis(off_axis(direction));
                let length = across.length();
                if length > 1e-12 * direction.length() { end + across * (radius / length) } else { end }
            }
            Core::Hull(points, _) => point_cloud_support_point(direction, points),
        }
    }
}

impl Piece {
    /// Makes the piece of a shape.
    ///
    /// # Errors
    /// The shape has no volume or a number that is not finite.
    pub fn new(shape: &Shape) -> Result<Piece, ShapeFault> {
        let positive = |size: f64| match size {
            _ if !size.is_finite() => Err(ShapeFault::NotFinite),
            _ if size > 0.0 => Ok(size),
            _ => Err(ShapeFault::Empty),
        };
        let finite = |points: &[Point3<f64>]| match points.iter().all(|own| own.coords.iter().all(|x| x.is_finite())) {
            true => Ok(()),
            false => Err(ShapeFault::NotFinite),
        };
        Ok(match shape {
            Shape::Capsule { ends_mm: [a, b], radius_mm } => {
                finite(&[*a, *b])?;
                let radius = positive(*radius_mm)?;
                let ball = (vector(&nalgebra::center(a, b).coords), 0.5 * (a - b).norm() + radius);
                Piece { core: Core::Segment([vector(&a.coords), vector(&b.coords)]), radius, ball }
            }
            Shape::Cuboid { pose, size_mm } => {
                finite(&[pose.translation.vector.into()])?;
                let mut half_axes = [Vector::ZERO; 3];
                for axis in 0..3 {
                    let half = Vector3::ith(axis, 0.5 * positive(size_mm[axis])?);
                    half_axes[axis] = vector(&(pose.rotation * half));
                }
                let centre = vector(&pose.translation.vector);
                Piece { core: Core::Cuboid { centre, half_axes }, radius: 0.0, ball: (centre, 0.5 * size_mm.norm()) }
            }
            Shape::Cylinder { ends_mm: [a, b], radius_mm } => {
                finite(&[*a, *b])?;
                let radius = positive(*radius_mm)?;
                let length = positive((b - a).norm())?;
                let half_axis = vector(&(0.5 * (b - a)));
                let centre = vector(&nalgebra::center(a, b).coords);
                let direction = half_axis / (0.5 * length);
                let ball = (centre, (0.25 * length * length + radius * radius).sqrt());
                Piece { core: Core::Cylinder { centre, half_axis, direction, radius }, radius: 0.0, ball }
            }
            Shape::Hull { points_mm } => {
                finite(points_mm)?;
                let points: Vec<Vector> = points_mm.iter().map(|own| vector(&own.coords)).collect();
                Piece::of_hull(&points)?
            }
        })
    }

    /// Makes the piece of the hull of `points`.
    pub fn of_hull(points: &[Vector]) -> Result<Piece, ShapeFault> {
        if points.len() < 4 {
            return Err(ShapeFault::Flat);
        }
        let (hull, faces) = try_convex_hull(points).map_err(|_| ShapeFault::Flat)?;
        let (low, high) = hull.iter().fold((hull[0], hull[0]), |(low, high), own| (low.min(*own), high.max(*own)));
        // About a corner of it, so that rounding adds no volume of its own.
        let corner = |face: &[u32; 3]| face.map(|k| hull[k as usize] - hull[0]);
        let volume: f64 = faces.iter().map(corner).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
        if volume <= FLAT * (high - low).length().powi(3) {
            return Err(ShapeFault::Flat);
        }
        let centre = 0.5 * (low + high);
        let radius = hull.iter().fold(0.0, |most: f64, own| most.max((*own - centre).length()));
        let across = faces.iter().map(|face| {
            let [a, b, c] = face.map(|k| hull[k as usize]);
            (b - a).cross(c - a)
        });
        let sides = faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        // Each is that of two faces, once either way.
        let edges = sides.filter(|[from, to]| from < to).map(|[from, to]| hull[to as usize] - hull[from as usize]);
        let sides = [across.collect(), edges.collect()];
        Ok(Piece { core: Core::Hull(hull, sides), radius: 0.0, ball: (centre, radius) })
    }
}
