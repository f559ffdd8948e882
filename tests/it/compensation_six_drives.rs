//! A machine whose drives control all six coordinates: position alone, or the full pose, may be put right.

use crate::support::{arm::ARM, engine::machine_from};
use kinetostat::{
    compensation::{
        Compensation, CompensationSettings, CompensationStatus, Method, Session, Target, TaskPoint, compensate,
    },
    machine::{ChainError, Machine},
    spatial::{Pose, Twist, Wrench, rotation_log},
};
use nalgebra::Vector3;

fn machines() -> (Machine, Machine) {
    let nominal = machine_from(ARM);
    let end = Twist { linear: Vector3::new(0.3, -0.2, 0.1), angular: Vector3::new(2e-3, 1e-3, -1e-3) };
    let error = ChainError { end, drive_offsets: vec![1e-3, -5e-4], ..ChainError::default() };
    let real = nominal.with_errors(&[error]);
    (nominal, real)
}

fn task(machine: &Machine, target: Target) -> TaskPoint {
    let turned = Pose::from_rotation_vector(Vector3::new(0.1, -0.05, 0.2));
    let rotation = machine.home.pose.rotation * turned.rotation;
    let pose = Pose { rotation, translation: machine.home.pose.translation + Vector3::new(-60.0, 80.0, 30.0) };
    TaskPoint { pose, load: Wrench::new([300.0, -200.0, -400.0, 2e4, 1e4, -5e3]), target, wanted: None, external: None }
}

fn solve(method: Method, target: Target) -> (Compensation, Pose, Pose) {
    let (nominal, real) = machines();
    let task = task(&nominal, target);
    let mut session = Session::new(&nominal, &real, CompensationSettings::default());
    let done = compensate(&mut session, &task, method);
    assert_eq!(done.status, CompensationStatus::Converged, "{method:?}, {target:?}: {:?}", done.history);
    let commanded = session.target().unwrap();
    (done, commanded, session.state().pose)
}

const METHODS: [Method; 4] =
    [Method::Direct, Method::Newton, Method::MatrixFree { alpha: 1.0 }, Method::FixedMatrix { alpha: 1.0 }];

#[test]
fn all_methods_meet_for_every_target() {
    for target in [Target::ToolTip, Target::PlatformPoint, Target::FullPose] {
        let (reference, ..) = solve(Method::Direct, target);
        for method in METHODS {
            let (done, ..) = solve(method, target);
            for (a, b) in done.drives.iter().zip(&reference.drives) {
                assert!((a - b).abs() < 1e-11, "{method:?}, {target:?}: {a} differs from {b} rad");
            }
        }
    }
}

#[test]
fn full_pose_leaves_nothing() {
    let (done, _, pose) = solve(Method::Direct, Target::FullPose);
    let wanted = task(&machines().0, Target::FullPose).pose;
    assert!(done.residual_rotation.norm() < 1e-12);
    assert!((pose.translation - wanted.translation).norm() < 1e-9);
}

#[test]
fn tool_tip_alone_leaves_the_rotation_and_commands_the_wanted_orientation() {
    let (done, commanded, _) = solve(Method::Direct, Target::ToolTip);
    let wanted = task(&machines().0, Target::ToolTip).pose;
    assert!(done.position_error.norm() < 1e-9);
    assert!(done.residual_rotation.norm() > 1e-4);
    assert!(rotation_log(&(commanded.rotation * wanted.rotation.transpose())).norm() < 1e-12);
}

#[test]
fn the_linear_correction_of_the_full_pose_leaves_what_is_not_linear() {
    let (nominal, _) = machines();
    let task = task(&nominal, Target::FullPose);
    let error = |method| {
        let mut session = Session::new(&nominal, &nominal, CompensationSettings::default());
        let done = compensate(&mut session, &task, method);
        (done.position_error.norm(), done.residual_rotation.norm())
    };
    let (plain, linear) = (error(Method::None), error(Method::Linear));
    assert!(linear.0 < 0.01 * plain.0 && linear.1 < 0.01 * plain.1, "{plain:?}, {linear:?}");
}
