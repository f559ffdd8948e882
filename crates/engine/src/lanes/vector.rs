//! Vectors, frames and finite rotations over [`Real`].

use std::ops::{Add, AddAssign, Sub};

use super::{
    Real, pairs,
    trigonometry::{SMALL_SINE_SQUARED, arc_sine_weight, rotation_weights, sin_cos},
};
use crate::spatial::{self, Axis, Pose, Twist, Wrench};

/// A vector in space.
#[derive(Debug, Clone, Copy)]
pub struct Vec3<R>(pub [R; 3]);

impl<R: Real> Vec3<R> {
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([R::zero(); 3])
    }

    /// The same vector in all lanes.
    #[inline(always)]
    pub fn splat(v: &nalgebra::Vector3<f64>) -> Self {
        Self([R::splat(v.x), R::splat(v.y), R::splat(v.z)])
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    /// The vector times `factor`.
    #[inline(always)]
    pub fn scale(self, factor: R) -> Self {
        let [x, y, z] = self.0;
        Self([x * factor, y * factor, z * factor])
    }

    /// Length.
    #[inline(always)]
    pub fn norm(self) -> R {
        self.dot(self).sqrt()
    }

    /// Takes `yes` where `mask` holds, `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (yes.0, no.0);
        Self([R::select(mask, a, x), R::select(mask, b, y), R::select(mask, c, z)])
    }
}

impl<R: Real> Add for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a + x, b + y, c + z])
    }
}

impl<R: Real> AddAssign for Vec3<R> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<R: Real> Sub for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a - x, b - y, c - z])
    }
}

/// A [`Twist`] (velocity, angular velocity) or a [`Wrench`] (force, moment).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Screw<R> {
    /// Velocity or force.
    pub linear: Vec3<R>,
    /// Angular velocity or moment.
    pub angular: Vec3<R>,
}

impl<R: Real> Screw<R> {
    /// The zero twist or wrench.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { linear: Vec3::zero(), angular: Vec3::zero() }
    }

    /// Entries of the linear part, then of the angular part.
    #[inline(always)]
    pub fn to_array(self) -> [R; 6] {
        let ([a, b, c], [d, e, f]) = (self.linear.0, self.angular.0);
        [a, b, c, d, e, f]
    }

    /// A screw from the entries of its linear part, then of its angular part.
    #[inline(always)]
    pub fn from_array([a, b, c, d, e, f]: [R; 6]) -> Self {
        Self { linear: Vec3([a, b, c]), angular: Vec3([d, e, f]) }
    }

    /// Power of a twist and a wrench.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.linear.dot(other.linear) + self.angular.dot(other.angular)
    }

    /// Size of a wrench: the larger of force and moment over `length`, see [`Wrench::norm`].
    #[inline(always)]
    pub fn wrench_norm(self, length: f64) -> R {
        self.linear.norm().larger(self.angular.norm() / R::splat(length))
    }
}

impl From<Twist> for Screw<f64> {
    fn from(twist: Twist) -> Self {
        Self { linear: Vec3(twist.linear.into()), angular: Vec3(twist.angular.into()) }
    }
}

impl From<Screw<f64>> for Twist {
    fn from(screw: Screw<f64>) -> Self {
        Self { linear: screw.linear.0.into(), angular: screw.angular.0.into() }
    }
}

impl From<Wrench> for Screw<f64> {
    fn from(wrench: Wrench) -> Self {
        Self { linear: Vec3(wrench.force.into()), angular: Vec3(wrench.moment.into()) }
    }
}

impl From<Screw<f64>> for Wrench {
    fn from(screw: Screw<f64>) -> Self {
        Self { force: screw.linear.0.into(), moment: screw.angular.0.into() }
    }
}

/// A [`Pose`], one per lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame<R> {
    /// Axes of the frame: the columns of the rotation matrix.
    pub axes: [Vec3<R>; 3],
    /// Its origin, mm.
    pub origin: Vec3<R>,
}

impl<R: Real> Frame<R> {
    /// The same pose in all lanes.
    #[inline(always)]
    pub fn splat(pose: &Pose) -> Self {
        let mut axes = [Vec3::zero(); 3];
        for (j, axis) in axes.iter_mut().enumerate() {
            for (i, component) in axis.0.iter_mut().enumerate() {
                *component = R::splat(pose.rotation[(i, j)]);
            }
        }
        Self { axes, origin: Vec3::splat(&pose.translation) }
    }

    /// The pose in `lane`.
    pub fn lane(&self, lane: usize) -> Pose {
        Pose {
            rotation: nalgebra::Matrix3::from_fn(|i, j| self.axes[j].0[i].lane(lane)),
            translation: nalgebra::Vector3::from_fn(|i, _| self.origin.0[i].lane(lane)),
        }
    }

    /// The frame `self · transform`, `transform` being known beforehand; its zeros cost nothing.
    #[inline(always)]
    pub fn compose(&self, transform: &Pose) -> Self {
        let mut origin = self.origin;
        for (i, axis) in self.axes.iter().enumerate() {
            let shift = transform.translation[i];
            if shift != 0.0 {
                origin += axis.scale(R::splat(shift));
            }
        }
        let mut axes = [Vec3::zero(); 3];
        for (column, sum) in axes.iter_mut().enumerate() {
            for (i, axis) in self.axes.iter().enumerate() {
                let part = transform.rotation[(i, column)];
                if part != 0.0 {
                    *sum += axis.scale(R::splat(part));
                }
            }
        }
        Self { axes, origin }
    }

    /// Moves the frame along its own `axis`.
    #[inline(always)]
    pub fn translate_along(&mut self, axis: Axis, distance: R) {
        self.origin += self.axes[axis.index()].scale(distance);
    }

    /// Turns the frame about its own `axis`.
    #[inline(always)]
    pub fn rotate_about(&mut self, axis: Axis, angle: R) {
        let (sin, cos) = sin_cos(angle);
        let (b, c) = ((axis.index() + 1) % 3, (axis.index() + 2) % 3);
        let (old_b, old_c) = (self.axes[b], self.axes[c]);
        self.axes[b] = old_b.scale(cos) + old_c.scale(sin);
        self.axes[c] = old_c.scale(cos) - old_b.scale(sin);
    }

    /// The axes turned by the rotation `turn`, without the rounding drift of the result (one step of `R ← R(3I − RᵀR)/2`).
    #[inline(always)]
    pub fn turned_axes(&self, turn: &[Vec3<R>; 3]) -> [Vec3<R>; 3] {
        let [x, y, z] = self.axes;
        let axes = [weighted_sum(turn, x), weighted_sum(turn, y), weighted_sum(turn, z)];
        let (three, half) = (R::splat(3.0), R::splat(0.5));
        let mut turned = axes;
        for (j, axis) in turned.iter_mut().enumerate() {
            let mut weights = Vec3([-axes[0].dot(axes[j]), -axes[1].dot(axes[j]), -axes[2].dot(axes[j])]);
            weights.0[j] += three;
            *axis = weighted_sum(&axes, weights).scale(half);
        }
        turned
    }

    /// Turns a vector from the axes of the frame into those of O.
    #[inline(always)]
    pub fn outward(&self, vector: Vec3<R>) -> Vec3<R> {
        weighted_sum(&self.axes, vector)
    }

    /// Turns a vector from the axes of O into those of the frame.
    #[inline(always)]
    pub fn inward(&self, vector: Vec3<R>) -> Vec3<R> {
        Vec3([self.axes[0].dot(vector), self.axes[1].dot(vector), self.axes[2].dot(vector)])
    }

    /// Position in O of a `point` given in the frame, mm.
    #[inline(always)]
    pub fn transform(&self, point: &nalgebra::Vector3<f64>) -> Vec3<R> {
        self.origin + self.outward(Vec3::splat(point))
    }

    /// Rotation `self · otherᵀ`, as columns.
    #[inline(always)]
    pub fn rotation_from(&self, other: &Self) -> [Vec3<R>; 3] {
        let [[a, b, c], [d, e, f], [g, h, i]] = [other.axes[0].0, other.axes[1].0, other.axes[2].0];
        [
            weighted_sum(&self.axes, Vec3([a, d, g])),
            weighted_sum(&self.axes, Vec3([b, e, h])),
            weighted_sum(&self.axes, Vec3([c, f, i])),
        ]
    }
}

/// Sum of `columns`, each times its component of `weights`: the product of matrix and vector.
#[inline(always)]
fn weighted_sum<R: Real>(columns: &[Vec3<R>; 3], weights: Vec3<R>) -> Vec3<R> {
    columns[0].scale(weights.0[0]) + columns[1].scale(weights.0[1]) + columns[2].scale(weights.0[2])
}

impl From<Frame<f64>> for Pose {
    fn from(frame: Frame<f64>) -> Self {
        frame.lane(0)
    }
}

/// Rotation, as columns, of a rotation vector in rad; see [`spatial::rotation_exp`].
#[inline(always)]
pub fn rotation_exp<R: Real>(vector: Vec3<R>) -> [Vec3<R>; 3] {
    const LARGEST: f64 = std::f64::consts::FRAC_PI_4 * std::f64::consts::FRAC_PI_4;
    let square = vector.dot(vector);
    if square.lanes_greater(LARGEST) != 0 {
        return rotation_exp_by_lane(vector);
    }
    // I + a [w]× + b (w wᵀ − w² I)
    let (a, b) = rotation_weights(square);
    let [x, y, z] = vector.scale(a).0;
    let diagonal = R::splat(1.0) - b * square;
    let mut columns = [Vec3([diagonal, z, -y]), Vec3([-z, diagonal, x]), Vec3([y, -x, diagonal])];
    for (column, component) in pairs(columns.iter_mut(), vector.0) {
        *column += vector.scale(b * component);
    }
    columns
}

/// Computes [`rotation_exp`] lane by lane, where an angle is too large for the polynomials.
#[cold]
fn rotation_exp_by_lane<R: Real>(vector: Vec3<R>) -> [Vec3<R>; 3] {
    let mut columns = [Vec3::<R>::zero(); 3];
    for lane in 0..R::LANES {
        let lane_vector = Vec3(vector.0.map(|component| component.lane(lane)));
        let rotation = if R::LANES == 1 { library_rotation_exp(lane_vector) } else { rotation_exp(lane_vector) };
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            columns[j].0[i].set_lane(lane, rotation[j].0[i]);
        }
    }
    columns
}

/// Computes [`spatial::rotation_exp`] of a rotation vector in rad; returns the columns of the matrix.
fn library_rotation_exp(vector: Vec3<f64>) -> [Vec3<f64>; 3] {
    let rotation = spatial::rotation_exp(vector.0.into());
    std::array::from_fn(|j| Vec3(rotation.column(j).into_owned().into()))
}

/// Rotation vector in rad of a rotation given by its columns; see [`spatial::rotation_log`].
#[inline(always)]
pub fn rotation_log<R: Real>(columns: [Vec3<R>; 3]) -> Vec3<R> {
    let [x, y, z] = [columns[0].0, columns[1].0, columns[2].0];
    let half = R::splat(0.5);
    let axial = Vec3([(y[2] - z[1]) * half, (z[0] - x[2]) * half, (x[1] - y[0]) * half]);
    let square = axial.dot(axial);
    let trace = x[0] + y[1] + z[2];
    let is_large = square.lanes_greater(SMALL_SINE_SQUARED) | R::mask_to_bits(R::splat(1.0).greater(trace));
    if is_large != 0 { rotation_log_by_lane(columns) } else { axial.scale(arc_sine_weight(square)) }
}

/// Computes [`rotation_log`] lane by lane, where an angle is too large for the polynomial.
#[cold]
fn rotation_log_by_lane<R: Real>(columns: [Vec3<R>; 3]) -> Vec3<R> {
    let mut vector = Vec3::<R>::zero();
    for lane in 0..R::LANES {
        let lane_columns = columns.map(|column| Vec3(column.0.map(|component| component.lane(lane))));
        let log = if R::LANES == 1 { library_rotation_log(lane_columns) } else { rotation_log(lane_columns) };
        for (component, value) in pairs(&mut vector.0, log.0) {
            component.set_lane(lane, value);
        }
    }
    vector
}

/// Computes [`spatial::rotation_log`], rad, of a rotation given by its columns.
fn library_rotation_log(columns: [Vec3<f64>; 3]) -> Vec3<f64> {
    let rotation = nalgebra::Matrix3::from_fn(|i, j| columns[j].0[i]);
    Vec3(spatial::rotation_log(&rotation).into())
}
