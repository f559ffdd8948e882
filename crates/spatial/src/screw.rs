//! Twists and wrenches as six-vectors.

use nalgebra::{Matrix3, Vector3, Vector6};
use serde::Serialize;

/// Cross-product matrix of `v`: `skew(a) · b = a × b`.
#[inline]
pub fn skew(v: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// The larger of two numbers; NaN if either is, unlike [`f64::max`], so that a residual cannot hide one.
#[inline]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// Velocity (or small displacement) of a point and the angular velocity (or small rotation), in one set of axes.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Twist {
    /// Velocity of the reference point, mm per unit.
    pub linear: Vector3<f64>,
    /// Angular velocity, rad per unit.
    pub angular: Vector3<f64>,
}

impl Twist {
    /// The twist as one 6-vector (linear, angular).
    #[inline]
    pub fn to_vector(self) -> Vector6<f64> {
        Vector6::new(self.linear.x, self.linear.y, self.linear.z, self.angular.x, self.angular.y, self.angular.z)
    }

    /// The twist of a 6-vector (linear, angular).
    #[inline]
    pub fn from_vector(v: &Vector6<f64>) -> Self {
        Self { linear: v.fixed_rows::<3>(0).into(), angular: v.fixed_rows::<3>(3).into() }
    }

    /// The twist at the point displaced by `offset` mm: `v_Q = v_P + ω × p_PQ`.
    #[inline]
    pub fn shift(self, offset: Vector3<f64>) -> Self {
        Self { linear: self.linear + self.angular.cross(&offset), angular: self.angular }
    }
}

/// Force and moment about a point, in one set of axes. Dual to [`Twist`].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Wrench {
    /// Force in N.
    pub force: Vector3<f64>,
    /// Moment about the reference point in N·mm.
    pub moment: Vector3<f64>,
}

impl Wrench {
    /// The wrench with these components (N, N, N, N·mm, N·mm, N·mm).
    #[inline]
    pub fn new(components: [f64; 6]) -> Self {
        let [fx, fy, fz, mx, my, mz] = components;
        Self { force: Vector3::new(fx, fy, fz), moment: Vector3::new(mx, my, mz) }
    }

    /// The zero wrench: no load.
    #[inline]
    pub fn zero() -> Self {
        Self::default()
    }

    /// The wrench as one 6-vector (force, moment).
    #[inline]
    pub fn to_vector(self) -> Vector6<f64> {
        Vector6::new(self.force.x, self.force.y, self.force.z, self.moment.x, self.moment.y, self.moment.z)
    }

    /// The wrench of a 6-vector (force, moment).
    #[inline]
    pub fn from_vector(v: &Vector6<f64>) -> Self {
        Self { force: v.fixed_rows::<3>(0).into(), moment: v.fixed_rows::<3>(3).into() }
    }

    /// The components in the order force (N), moment (N·mm).
    #[inline]
    pub fn to_array(self) -> [f64; 6] {
        [self.force.x, self.force.y, self.force.z, self.moment.x, self.moment.y, self.moment.z]
    }

    /// The wrench reduced to the point displaced by `offset` mm: `m_Q = m_P − p_PQ × f`.
    #[inline]
    pub fn shift(self, offset: Vector3<f64>) -> Self {
        Self { force: self.force, moment: self.moment - offset.cross(&self.force) }
    }

    /// The wrench with force and moment multiplied by `factor`.
    #[inline]
    pub fn scale(self, factor: f64) -> Self {
        Self { force: self.force * factor, moment: self.moment * factor }
    }

    /// Size of the wrench in N: the larger of the force and of the moment divided by `length` (mm).
    #[inline]
    pub fn norm(self, length: f64) -> f64 {
        larger(self.force.norm(), self.moment.norm() / length)
    }
}
