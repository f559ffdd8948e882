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
