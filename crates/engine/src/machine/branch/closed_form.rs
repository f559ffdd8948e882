//! Joints of a six-axis arm with a spherical wrist on all its branches, in closed form: 1 to 3 from the wrist centre, 4 to 6 from the orientation.

use nalgebra::{Matrix3, Rotation2, Vector2, Vector3};

use super::arm::{Arm, Axis};
use crate::spatial::Pose;

/// A cosine beyond ±1 by no more is one.
const ROUNDING: f64 = 1e-12;
/// A vector shorter than this share of itself across an axis has no direction there.
const NO_DIRECTION: f64 = 1e-9;

impl Arm {
    /// Joints 1 to 6 (rad, −π to π) of each posture that puts P on `target`, two for each set of joints 1 to 3. `free`: joint 4 where the wrist is
    /// straight and only the sum of joints 4 and 6 is determined.
    pub fn solutions(&self, target: &Pose, free: f64) -> Vec<[f64; 6]> {
        let centre = target.compose(&self.zero.inverse()).transform(self.wrist_centre);
        let mut solutions = Vec::with_capacity(8);
        for side in [1.0, -1.0] {
            let Some(first) = self.first_joint(centre, side) else { continue };
            for bend in [1.0, -1.0] {
                let Some([second, third]) = self.shoulder_elbow_joints(centre, first, bend) else { continue };
                let turned =
                    self.axes[0].rotation(first) * self.axes[1].rotation(second) * self.axes[2].rotation(third);
                let wrist_rotation = turned.matrix().transpose() * target.rotation * self.zero.rotation.transpose();
                let wrists = self.wrist_joints(&wrist_rotation, free).into_iter().flatten();
                solutions.extend(wrists.map(|[fourth, fifth, sixth]| [first, second, third, fourth, fifth, sixth]));
            }
        }
        solutions
    }

    /// Joint 1, rad, with the wrist centre in front of axis 1 (`side` = 1) or behind it (−1); `None` out of reach.
    fn first_joint(&self, centre: Vector3<f64>, side: f64) -> Option<f64> {
        let axis = &self.axes[0];
        let beside = axis.direction.cross(&self.ahead);
        let plane = |point: Vector3<f64>| {
            let from = point - axis.point;
            Vector2::new(self.ahead.dot(&from), beside.dot(&from))
        };
        let there = plane(centre);
        // The turn about axis 1 leaves the wrist centre beside the arm's plane by as much as at zero.
        let offset = plane(self.wrist_centre).y;
        let distance = there.norm();
        let squared = distance * distance - offset * offset;
        if squared < -ROUNDING * distance * distance {
            return None;
        }
        Some(wrap_angle(polar_angle(there) - polar_angle(Vector2::new(side * squared.max(0.0).sqrt(), offset))))
    }

    /// Joints 2 and 3, rad, with the elbow bent up (`bend` = 1) or down (−1), joint 1 at `first`; `None` out of reach.
    fn shoulder_elbow_joints(&self, centre: Vector3<f64>, first: f64, bend: f64) -> Option<[f64; 2]> {
        let [base, shoulder, elbow] = [&self.axes[0], &self.axes[1], &self.axes[2]];
        let back = base.rotation(-first) * (centre - base.point) + base.point;
        let (target, upper, fore) =
            (self.in_plane(back - shoulder.point), self.in_plane(self.upper_arm()), self.in_plane(self.forearm()));
        let product = 2.0 * upper.norm() * fore.norm();
        let cosine = (target.norm_squared() - upper.norm_squared() - fore.norm_squared()) / product;
        if cosine.abs() > 1.0 + ROUNDING {
            return None;
        }
        let third = bend * libm::acos(cosine.clamp(-1.0, 1.0)) - polar_angle(fore) + polar_angle(upper);
        let second = polar_angle(target) - polar_angle(upper + Rotation2::new(third) * fore);
        Some([self.sense_across(shoulder) * wrap_angle(second), self.sense_across(elbow) * wrap_angle(third)])
    }

    /// Joints 4 to 6, rad, that turn the hand by `rotation`, in two ways; `None` out of reach. `free`: joint 4 of a straight wrist.
    fn wrist_joints(&self, rotation: &Matrix3<f64>, free: f64) -> [Option<[f64; 3]>; 2] {
        let [fourth, fifth, sixth] = [&self.axes[3], &self.axes[4], &self.axes[5]];
        let (a4, a5, a6) = (fourth.direction, fifth.direction, sixth.direction);
        let target_axis = rotation * a6;
        // a4·(R5 a6) = mean + cosine·cos q5 + sine·sin q5
        let mean = a4.dot(&a5) * a5.dot(&a6);
        let (cosine, sine) = (a4.dot(&a6) - mean, a4.dot(&a5.cross(&a6)));
        let share = (a4.dot(&target_axis) - mean) / libm::hypot(cosine, sine);
        [1.0, -1.0].map(|side| {
            if share.abs() > 1.0 + ROUNDING {
                return None;
            }
            let q5 = wrap_angle(libm::atan2(sine, cosine) + side * libm::acos(share.clamp(-1.0, 1.0)));
            let bent = fifth.rotation(q5) * a6;
            let q4 = angle_about(fourth, bent, target_axis).unwrap_or(free);
            let beside = a6.cross(&least_aligned_axis(a6));
            let last = (fourth.rotation(q4) * fifth.rotation(q5)).inverse() * (rotation * beside);
            Some([q4, q5, angle_about(sixth, beside, last)?])
        })
    }
}

/// Angle about `axis`, rad, that takes `from` to `to`; `None` where they lie along it.
fn angle_about(axis: &Axis, from: Vector3<f64>, to: Vector3<f64>) -> Option<f64> {
    let along = axis.direction;
    let across = |vector: Vector3<f64>| vector - along * along.dot(&vector);
    let (from, to) = (across(from), across(to));
    let is_determined = from.norm().min(to.norm()) > NO_DIRECTION;
    is_determined.then(|| libm::atan2(along.dot(&from.cross(&to)), from.dot(&to)))
}

/// Coordinate axis to which `direction` leans least.
fn least_aligned_axis(direction: Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[direction.iamin()] = 1.0;
    axis
}

/// Angle of `vector` from its first axis, −π to π rad.
fn polar_angle(vector: Vector2<f64>) -> f64 {
    libm::atan2(vector.y, vector.x)
}

/// The angle wrapped to −π to π, rad.
fn wrap_angle(angle: f64) -> f64 {
    libm::atan2(libm::sin(angle), libm::cos(angle))
}
