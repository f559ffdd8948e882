//! A frame made from one axis.

use nalgebra::{Matrix3, Vector3};

/// Sine of the angle below which an axis counts as parallel to x.
const PARALLEL: f64 = 1e-6;

/// A right-handed frame whose z axis is the unit vector `axis`. Its x axis is the projection of x onto the plane normal to
/// `axis`; of y where `axis` is parallel to x. Columns are the axes; along z it is the identity, to the bit.
#[must_use]
pub fn frame_about(axis: Vector3<f64>) -> Matrix3<f64> {
    let across = |v: Vector3<f64>| v - axis * axis.dot(&v);
    let x = across(Vector3::x()).try_normalize(PARALLEL).unwrap_or_else(|| across(Vector3::y()).normalize());
    Matrix3::from_columns(&[x, axis.cross(&x), axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn along_z_it_is_the_identity_and_elsewhere_a_rotation() {
        assert_eq!(frame_about(Vector3::z()), Matrix3::identity());
        let down = frame_about(-Vector3::z());
        assert_eq!((down * Vector3::x(), down * Vector3::y()), (Vector3::x(), -Vector3::y()));
        let along_x = frame_about(Vector3::x());
        assert_eq!((along_x * Vector3::x(), along_x * Vector3::y()), (Vector3::y(), Vector3::z()));
        for axis in [Vector3::new(0.3, -0.2, 0.5), Vector3::new(1.0, 1e-9, 0.0), Vector3::new(-1.0, 1e-4, 0.0)] {
            let frame = frame_about(axis.normalize());
            assert!((frame.transpose() * frame - Matrix3::identity()).norm() < 1e-12);
            assert!((frame.determinant() - 1.0).abs() < 1e-12);
            assert!((frame * Vector3::z() - axis.normalize()).norm() < 1e-15);
        }
    }
}
