//! Rigid poses and finite rotations.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// A coordinate axis of a local frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// First axis.
    X,
    /// Second axis.
    Y,
    /// Third axis.
    Z,
}

impl Axis {
    /// Position of the axis in a 3-vector: 0, 1 or 2.
    #[inline]
    pub const fn index(self) -> usize {
        match self {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        }
    }
}

/// Pose `X_AB` of a frame B in a frame A: `p_A = rotation · p_B + translation`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// `R_AB`, orthonormal.
    pub rotation: Matrix3<f64>,
    /// `p_AB_A` in mm.
    pub translation: Vector3<f64>,
}

impl Pose {
    /// The pose of a frame in itself: no translation, no rotation.
    #[inline]
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), translation: Vector3::zeros() }
    }

    /// The pose of a pure translation, mm.
    #[inline]
    pub fn from_translation(translation: Vector3<f64>) -> Self {
        Self { rotation: Matrix3::identity(), translation }
    }

    /// The pose of a pure rotation given by its rotation vector (axis × angle), rad.
    #[inline]
    pub fn from_rotation_vector(rotation_vector: Vector3<f64>) -> Self {
        Self { rotation: rotation_exp(rotation_vector), translation: Vector3::zeros() }
    }

    /// The pose of a rotation by roll, pitch and yaw (rad) about the fixed x, y and z axes, in this order: `R = Rz(yaw) · Ry(pitch) · Rx(roll)`.
    #[inline]
    pub fn from_roll_pitch_yaw(angles: Vector3<f64>) -> Self {
        let about = |axis: Axis| {
            let mut v = Vector3::zeros();
            v[axis.index()] = angles[axis.index()];
            rotation_exp(v)
        };
        Self { rotation: about(Axis::Z) * about(Axis::Y) * about(Axis::X), translation: Vector3::zeros() }
    }

    /// Returns roll, pitch and yaw of the rotation about the fixed axes, degrees: what [`Pose::from_roll_pitch_yaw`] takes in rad.
    #[inline]
    pub fn roll_pitch_yaw_deg(&self) -> [f64; 3] {
        <[f64; 3]>::from(Rotation3::from_matrix_unchecked(self.rotation).euler_angles()).map(f64::to_degrees)
    }

    /// Pose of frame C in A: `X_AC = X_AB · X_BC`.
    #[inline]
    pub fn compose(&self, b_to_c: &Pose) -> Pose {
        Pose {
            rotation: matrix_product(&self.rotation, &b_to_c.rotation),
            translation: self.translation + matrix_vector(&self.rotation, b_to_c.translation),
        }
    }

    /// Pose of A in B, `X_BA`, from `X_AB`.
    #[inline]
    pub fn inverse(&self) -> Pose {
        let rotation = self.rotation.transpose();
        Pose { rotation, translation: -(rotation * self.translation) }
    }

    /// Position in A of a point given in B, mm.
    #[inline]
    pub fn transform(&self, p_b: Vector3<f64>) -> Vector3<f64> {
        matrix_vector(&self.rotation, p_b) + self.translation
    }

    /// Moves the frame along its local `axis` by `distance` mm: `X · T(axis, distance)`.
    #[inline]
    pub fn translate_along(&mut self, axis: Axis, distance: f64) {
        self.translation += self.rotation.column(axis.index()) * distance;
    }

    /// Rotates the frame about its local `axis` by `angle` rad: `X · R(axis, angle)`.
    #[inline]
    pub fn rotate_about(&mut self, axis: Axis, angle: f64) {
        let (sin, cos) = libm::sincos(angle);
        let (b, c) = ((axis.index() + 1) % 3, (axis.index() + 2) % 3);
        for row in 0..3 {
            let (rb, rc) = (self.rotation[(row, b)], self.rotation[(row, c)]);
            self.rotation[(row, b)] = cos * rb + sin * rc;
            self.rotation[(row, c)] = cos * rc - sin * rb;
        }
    }
}

impl From<Isometry3<f64>> for Pose {
    fn from(pose: Isometry3<f64>) -> Self {
        Self { rotation: *pose.rotation.to_rotation_matrix().matrix(), translation: pose.translation.vector }
    }
}

impl From<Pose> for Isometry3<f64> {
    fn from(pose: Pose) -> Self {
        let rotation = Rotation3::from_matrix_unchecked(pose.rotation);
        Self::from_parts(pose.translation.into(), UnitQuaternion::from_rotation_matrix(&rotation))
    }
}

/// Product `matrix · v`, computed as nalgebra does, but inlined.
#[inline]
pub fn matrix_vector(matrix: &Matrix3<f64>, v: Vector3<f64>) -> Vector3<f64> {
    let row = |i: usize| matrix[(i, 0)] * v.x + matrix[(i, 1)] * v.y + matrix[(i, 2)] * v.z;
    Vector3::new(row(0), row(1), row(2))
}

/// Product `a · b`, computed as nalgebra does, but inlined.
#[inline]
pub fn matrix_product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    let entry = |i: usize, j: usize| a[(i, 0)] * b[(0, j)] + a[(i, 1)] * b[(1, j)] + a[(i, 2)] * b[(2, j)];
    let row = |i: usize| (entry(i, 0), entry(i, 1), entry(i, 2));
    let ((a, b, c), (d, e, f), (g, h, i)) = (row(0), row(1), row(2));
    Matrix3::new(a, b, c, d, e, f, g, h, i)
}

/// Rotation matrix of a rotation vector in rad (Rodrigues' formula, exact to rounding for any length).
#[inline]
pub fn rotation_exp(rotation_vector: Vector3<f64>) -> Matrix3<f64> {
    let w = super::skew(rotation_vector);
    let angle = rotation_vector.norm();
    let half_sinc = if angle < 1e-8 { 0.5 } else { libm::sin(0.5 * angle) / angle };
    let sinc = if angle < 1e-8 { 1.0 } else { libm::sin(angle) / angle };
    Matrix3::identity() + w * sinc + matrix_product(&w, &w) * (2.0 * half_sinc * half_sinc)
}

/// Rotation vector in rad, of length at most π, of a rotation matrix. Inverse of [`rotation_exp`].
#[inline]
pub fn rotation_log(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let r = rotation;
    let axial = 0.5 * Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]);
    let (sin, cos) = (axial.norm(), 0.5 * (r.trace() - 1.0));
    if cos > -0.99 {
        let scale = if sin < 1e-8 { 1.0 } else { libm::atan2(sin, cos) / sin };
        return axial * scale;
    }
    // Near half a turn the axial part vanishes: the axis is the largest column of R + Rᵀ + (1 − tr R)·I = 2(1 − cos)·aaᵀ.
    let symmetric = r + r.transpose() + Matrix3::identity() * (1.0 - r.trace());
    let column = (0..3).max_by(|&a, &b| symmetric[(a, a)].total_cmp(&symmetric[(b, b)])).unwrap_or(0);
    let axis = symmetric.column(column).normalize();
    let sign = if axis.dot(&axial) < 0.0 { -1.0 } else { 1.0 };
    axis * (sign * libm::atan2(sin, cos))
}

/// Rotation vector in rad of the least rotation from the unit vector `a` to `b`; if they are opposite, about any perpendicular axis.
pub fn least_turn(a: Vector3<f64>, b: Vector3<f64>) -> Vector3<f64> {
    let across = a.cross(&b);
    let angle = libm::atan2(across.norm(), a.dot(&b));
    let axis = across.try_normalize(PARALLEL).or_else(|| {
        let other = if a.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() };
        a.cross(&other).try_normalize(PARALLEL)
    });
    axis.map_or_else(Vector3::zeros, |axis| axis * angle)
}

/// Sine of the angle below which two axes are parallel.
const PARALLEL: f64 = 1e-12;

/// Sine of the angle below which an axis counts as parallel to x.
pub const PARALLEL_TO_X: f64 = 1e-6;

/// Axes, as columns, of a right-handed frame whose z axis is the unit vector `axis`. Its x axis is the projection of x onto the plane normal to
/// `axis`; of y where `axis` is parallel to x. For z it is the identity, to the bit.
#[must_use]
#[inline]
pub fn frame_about(axis: Vector3<f64>) -> Matrix3<f64> {
    let across = |v: Vector3<f64>| v - axis * axis.dot(&v);
    let x = across(Vector3::x()).try_normalize(PARALLEL_TO_X).unwrap_or_else(|| across(Vector3::y()).normalize());
    Matrix3::from_columns(&[x, axis.cross(&x), axis])
}
