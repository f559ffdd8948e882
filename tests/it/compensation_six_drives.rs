//! A machine whose drives control all six coordinates: position alone, or the full pose, may be put right.

use crate::support::{
    arm::ARM,
    engine::machine_from,
    machines::{some_errors, some_load},
};
use kinetostat::{
    compensation::{
        Compensation, CompensationSettings, CompensationStatus, Method, Session, Target, TaskPoint, compensate,
        compensate_batch,
    },
    machine::{ChainError, Machine, catalogue},
    spatial::{Pose, Twist, Wrench, rotation_log},
    statics::{Batch, Level},
};
use nalgebra::Vector3;

fn machines() -> (Machine, Machine) {
    let nominal = machine_from(ARM);
    let end = Twist { linear: Vector3::new(0.3, -0.2, 0.1), angular: Vector3::new(2e-3, 1e-3, -1e-3) };
    let error = ChainError { end, drive_offsets: vec![1e-3, -5e-4], ..ChainError::default() };
    let actual = nominal.with_errors(&[error]);
    (nominal, actual)
}

fn task(machine: &Machine, target: Target) -> TaskPoint {
    let turned = Pose::from_rotation_vector(Vector3::new(0.1, -0.05, 0.2));
    let rotation = machine.home.pose.rotation * turned.rotation;
    let pose = Pose { rotation, translation: machine.home.pose.translation + Vector3::new(-60.0, 80.0, 30.0) };
    TaskPoint::new(pose, Wrench::new([300.0, -200.0, -400.0, 2e4, 1e4, -5e3]), target)
}

fn solve(method: Method, target: Target) -> (Compensation, Pose, Pose) {
    let (nominal, actual) = machines();
    let task = task(&nominal, target);
    let mut session = Session::new(&nominal, &actual, CompensationSettings::default());
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

/// Built-in machines with six drives, and those with chain errors.
fn six_drives() -> impl Iterator<Item = (Machine, Machine)> {
    let machines = catalogue::names().map(|name| Machine::named(name).unwrap());
    machines.filter(|machine| machine.controls.len() == 6).map(|nominal| {
        let actual = nominal.with_errors(&some_errors(&nominal, 2));
        (nominal, actual)
    })
}

/// Nine tasks around a place beside home under loads of so many newtons, their platforms turned otherwise at each.
fn tasks(machine: &Machine, newtons: f64, target: Target) -> Vec<TaskPoint> {
    let home = machine.home.pose;
    let task = |seed: usize| {
        let share = |i: usize| 2.0 * (0.37 + 0.618_034 * (seed * 7 + i) as f64).fract() - 1.0;
        let vector = |first: usize| Vector3::from_fn(|i, _| share(first + i));
        let turned = Pose::from_rotation_vector(vector(0) * 0.1);
        let translation = home.translation + vector(3) * 40.0 - Vector3::new(30.0, 20.0, 50.0);
        let pose = Pose { rotation: home.rotation * turned.rotation, translation };
        TaskPoint::new(pose, some_load(machine, newtons, seed), target)
    };
    (0..9).map(task).collect()
}

/// Newton on the target goes from equilibrium to equilibrium and knows nothing of an iteration of drives and command.
#[test]
fn tool_tips_are_met_with_the_drives_of_another_method_and_the_rotation_commanded() {
    for (nominal, actual) in six_drives() {
        let session = Session::new(&nominal, &actual, CompensationSettings::default());
        let mut batch = Batch::new(&actual);
        let mut together = vec![session.clone(); 9];
        for newtons in [200.0, 2000.0] {
            let tasks = tasks(&nominal, newtons, Target::ToolTip);
            let mut sessions: Vec<&mut Session> = together.iter_mut().collect();
            let found = compensate_batch(&mut sessions, &tasks, Method::Direct, &mut batch);
            for (task, own) in tasks.iter().zip(&found) {
                assert_eq!(own.status, CompensationStatus::Converged, "{}", nominal.name);
                // An error for each step of one iteration: no equilibria one after another.
                assert_eq!(own.history.len(), own.outcome.as_ref().unwrap().iterations + 1, "{}", nominal.name);
                let other = compensate(&mut session.clone(), task, Method::Newton);
                assert_eq!(other.status, CompensationStatus::Converged, "{}", nominal.name);
                for (a, b) in own.drives.iter().zip(&other.drives) {
                    assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{}: {a} differs from {b}", nominal.name);
                }
                let mut at = session.clone();
                at.set_state(&nominal.inverse_kinematics(&task.pose).unwrap(), session.state());
                let command = nominal.forward_kinematics_from(at.command(), &own.drives).unwrap();
                let turned = rotation_log(&(task.pose.rotation.transpose() * command.pose.rotation)).norm();
                assert!(turned < 1e-11, "{}: the command is turned by {turned:e} rad", nominal.name);
            }
        }
    }
}

/// At every level of the processor and alone the same bits, also from where the last task ended.
#[test]
fn tool_tips_have_the_bits_that_each_has_alone() {
    for (nominal, actual) in six_drives() {
        let session = Session::new(&nominal, &actual, CompensationSettings::default());
        let (mut alone, mut ended) = (vec![session.clone(); 9], Vec::new());
        let rounds = [300.0, 600.0].map(|newtons| tasks(&nominal, newtons, Target::ToolTip));
        for tasks in &rounds {
            let pairs = alone.iter_mut().zip(tasks);
            ended.push(pairs.map(|(own, task)| compensate(own, task, Method::Direct)).collect::<Vec<_>>());
        }
        for level in Level::available() {
            let (mut together, mut batch) = (vec![session.clone(); 9], Batch::at_level(&actual, level));
            for (tasks, expected) in rounds.iter().zip(&ended) {
                let mut sessions: Vec<&mut Session> = together.iter_mut().collect();
                let found = compensate_batch(&mut sessions, tasks, Method::Direct, &mut batch);
                assert_eq!(&found, expected, "{}, {level:?}", nominal.name);
            }
        }
    }
}
