//! The circle through the two ends of an arc that passes nearest to points between them.

use nalgebra::{Matrix2, Vector2, Vector3};

use crate::model::Plane;

/// A circle of a larger radius, mm, is a line.
const LARGEST_RADIUS_MM: f64 = 1e5;

/// Fits a circle through `start` and `end` to the points `between`; returns its centre in the order of the plane's two axes, mm.
///
/// A centre c on the bisector of the chord, c = m + h ν (m its middle, ν its unit normal), has from p the power
/// |p − m|² − (chord/2)² − 2 h (p − m)·ν, zero on the circle: h by least squares. Where start and end are the same point s, the
/// power is |p − s|² − 2 (p − s)·(c − s), and c by least squares. `None` where no circle is determined.
pub fn centre_through(
    plane: Plane,
    start: &Vector3<f64>,
    end: &Vector3<f64>,
    between: impl Iterator<Item = Vector3<f64>>,
) -> Option<[f64; 2]> {
    let [first, second, _] = plane.axes();
    let flat = |p: &Vector3<f64>| Vector2::new(p[first], p[second]);
    let (start, end) = (flat(start), flat(end));
    let chord = end - start;
    let centre = match chord.try_normalize(0.0) {
        Some(along) => {
            let middle = (start + end) / 2.0;
            let normal = Vector2::new(-along.y, along.x);
            let (mut above, mut below) = (0.0, 0.0);
            for p in between {
                let from_middle = flat(&p) - middle;
                let height = from_middle.dot(&normal);
                above += (from_middle.norm_squared() - chord.norm_squared() / 4.0) * height;
                below += 2.0 * height * height;
            }
            middle + normal * (above / below)
        }
        None => {
            let (mut matrix, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for p in between {
                let from_start = flat(&p) - start;
                matrix += from_start * from_start.transpose() * 2.0;
                right += from_start * from_start.norm_squared();
            }
            start + matrix.try_inverse()? * right
        }
    };
    ((centre - start).norm() < LARGEST_RADIUS_MM).then_some(centre.into())
}
