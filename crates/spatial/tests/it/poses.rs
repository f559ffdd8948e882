//! Closed forms and invariants of poses, screws and frames.

use kinetostat_spatial::{Axis, Pose, Twist, Wrench, frame_about, rotation_exp, rotation_log};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

proptest! {
    #![proptest_config(crate::cases::cases(128))]

    #[test]
    fn log_inverts_exp(x in -1.0..1.0f64, y in -1.0..1.0f64, z in -1.0..1.0f64, angle in 0.0..3.1f64) {
        let v = Vector3::new(x, y, z);
        prop_assume!(v.norm() > 1e-3);
        let v = v.normalize() * angle;
        prop_assert!((rotation_log(&rotation_exp(v)) - v).norm() < 1e-12);
    }

    #[test]
    fn elementary_rotation_is_exp(angle in -7.0..7.0f64) {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let mut pose = Pose::identity();
            pose.rotate_about(axis, angle);
            let mut v = Vector3::zeros();
            v[axis.index()] = angle;
            prop_assert!((pose.rotation - rotation_exp(v)).norm() < 1e-14);
        }
    }
}

#[test]
fn tiny_and_half_turns() {
    for length in [0.0, 1e-300, 1e-12, 1e-9, 3.1, std::f64::consts::PI - 1e-9] {
        let v = Vector3::new(2.0, -1.0, 0.5).normalize() * length;
        assert!((rotation_log(&rotation_exp(v)) - v).norm() < 1e-9 * length.max(1e-9), "length {length}");
    }
}

#[test]
fn inverse_and_composition() {
    let mut a = Pose::from_roll_pitch_yaw(Vector3::new(0.3, -0.2, 1.0));
    a.translation = Vector3::new(1.0, 2.0, 3.0);
    let e = a.compose(&a.inverse());
    assert!((e.rotation - Matrix3::identity()).norm() < 1e-15 && e.translation.norm() < 1e-15);
}

#[test]
fn power_does_not_depend_on_the_reference_point() {
    let twist = Twist { linear: Vector3::new(1.0, -2.0, 0.5), angular: Vector3::new(0.1, 0.2, -0.3) };
    let wrench = Wrench::new([10.0, -3.0, 7.0, 100.0, 50.0, -20.0]);
    let offset = Vector3::new(5.0, 6.0, -7.0);
    let here = wrench.to_vector().dot(&twist.to_vector());
    let there = wrench.shift(offset).to_vector().dot(&twist.shift(offset).to_vector());
    assert!((here - there).abs() < 1e-12);
}

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
