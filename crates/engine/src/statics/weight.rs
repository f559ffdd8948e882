//! The weight of what moves with the platform: a wrench at P that turns with it, and the stiffness that comes of that.

use nalgebra::{Matrix3, Matrix6, Vector3};

use super::platform::Square;
use crate::{
    lanes::{Frame, Real, Screw, Vec3},
    machine::Machine,
};

/// Weight of the platform's mass as a wrench at P in O axes (N, N·mm), masses having the weight `gravity` per kg.
#[inline(always)]
pub(super) fn wrench<R: Real>(machine: &Machine, platform: &Frame<R>, gravity: Vec3<R>) -> Screw<R> {
    match &machine.platform_mass {
        None => Screw::zero(),
        Some(mass) => {
            let force = gravity.scale(R::splat(mass.kilograms));
            Screw { linear: force, angular: platform.outward(Vec3::splat(&mass.at)).cross(force) }
        }
    }
}

/// Adds the stiffness by the weight's turning with the platform to `tangent`: `(d·f) I − d fᵀ` in the rotations, `d` from P to the centre.
#[inline(always)]
pub(super) fn add_stiffness<R: Real>(
    machine: &Machine,
    platform: &Frame<R>,
    gravity: Vec3<R>,
    tangent: &mut Square<R>,
) {
    let Some(mass) = &machine.platform_mass else { return };
    let force = gravity.scale(R::splat(mass.kilograms));
    let lever = platform.outward(Vec3::splat(&mass.at));
    let along = lever.dot(force);
    for i in 0..3 {
        for j in 0..3 {
            tangent[3 + i][3 + j] -= lever.0[i] * force.0[j];
        }
        tangent[3 + i][3 + i] += along;
    }
}

/// Stiffness of the platform by the turning of its weight (N, N·mm; mm, rad); `rotation`: `R_OP`, `gravity`: weight of a kilogram in O, N.
pub(super) fn stiffness(machine: &Machine, rotation: &Matrix3<f64>, gravity: &Vector3<f64>) -> Matrix6<f64> {
    let mut tangent = [[0.0; 6]; 6];
    let pose = crate::spatial::Pose { rotation: *rotation, translation: Vector3::zeros() };
    add_stiffness(machine, &Frame::splat(&pose), Vec3::splat(gravity), &mut tangent);
    super::platform::to_matrix(&tangent)
}
