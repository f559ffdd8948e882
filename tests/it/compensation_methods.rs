//! Every method that compensates finds the same drives; comparators leave what they must.

use kinetostat::{
    compensation::{
        Compensation, CompensationSettings, CompensationStatus, Method, Session, Target, TaskPoint, compensate,
    },
    machine::Machine,
    process::MillingForce,
};
use nalgebra::Vector3;

const POINTS: [[f64; 3]; 5] = [
    [0.0, 0.0, 0.0],
    [126.35, 126.35, 126.35],
    [-73.65, -73.65, -73.65],
    [126.35, 126.35, -73.65],
    [30.0, -40.0, 75.0],
];

fn machines() -> (Machine, Machine) {
    let nominal = Machine::named_or_file("orthoglide").unwrap();
    let errors = nominal.assembly_errors(&[1.0, -1.0, 1.0]);
    let actual = nominal.with_errors(&errors);
    (nominal, actual)
}

fn task(machine: &Machine, position: [f64; 3], phi_deg: f64, target: Target) -> TaskPoint {
    let load = MillingForce::KLIMCHIK_GROOVE.wrench(phi_deg.to_radians(), &machine.tool());
    TaskPoint::new(machine.pose_at(position.into()), load, target)
}

fn solve(nominal: &Machine, actual: &Machine, task: &TaskPoint, method: Method) -> Compensation {
    compensate(&mut Session::new(nominal, actual, CompensationSettings::default()), task, method)
}

fn compensating() -> Vec<Method> {
    vec![
        Method::Direct,
        Method::Newton,
        Method::FixedMatrix { alpha: 1.0 },
        Method::FixedMatrix { alpha: 0.6 },
        Method::MatrixFree { alpha: 1.0 },
        Method::MatrixFree { alpha: 0.6 },
        Method::Procedure { alpha: 1.0 },
    ]
}

#[test]
fn all_methods_meet_at_the_same_drives() {
    let (nominal, actual) = machines();
    for target in [Target::ToolTip, Target::PlatformPoint] {
        for (position, phi) in POINTS.into_iter().zip([0.0, 130.0, 75.0, 210.0, 15.0]) {
            let task = task(&nominal, position, phi, target);
            let reference = solve(&nominal, &actual, &task, Method::Direct);
            for method in compensating() {
                let done = solve(&nominal, &actual, &task, method);
                assert_eq!(
                    done.status,
                    CompensationStatus::Converged,
                    "{method:?} at {position:?}: {:?}",
                    done.history
                );
                assert!(done.task_error() < 1e-9, "{method:?} leaves {} mm", done.task_error());
                for (a, b) in done.drives.iter().zip(&reference.drives) {
                    assert!((a - b).abs() < 1e-9, "{method:?} at {position:?}: {a} differs from {b}");
                }
            }
        }
    }
}

#[test]
fn newton_methods_converge_quadratically() {
    let (nominal, actual) = machines();
    let task = task(&nominal, POINTS[1], 130.0, Target::ToolTip);
    let history = solve(&nominal, &actual, &task, Method::Newton).history;
    assert!(history.len() <= 6, "{history:?}");
    for pair in history.windows(2).filter(|pair| pair[0] < 0.5 && pair[1] > 1e-9) {
        assert!(pair[1] < 2.0 * pair[0] * pair[0], "{history:?}");
    }
}

#[test]
fn comparators_leave_less_than_nothing_done_and_more_than_compensation() {
    let (nominal, actual) = machines();
    for (position, phi) in POINTS.into_iter().zip([0.0, 130.0, 75.0, 210.0, 15.0]) {
        let task = task(&nominal, position, phi, Target::ToolTip);
        let left = |method| {
            let done = solve(&nominal, &actual, &task, method);
            assert_eq!(done.status, CompensationStatus::Applied, "{method:?}");
            done.task_error()
        };
        let none = left(Method::None);
        let mirror = left(Method::Mirror { passes: 1 });
        let twice = left(Method::Mirror { passes: 2 });
        assert!(mirror < 0.2 * none && twice < 0.2 * mirror, "{position:?}: {none} {mirror} {twice}");
        assert!(twice > 1e-9, "{position:?}: mirroring is not exact");
        // Linear shifting knows nothing of chain errors; without them it leaves the nonlinear part.
        let linear =
            compensate(&mut Session::new(&nominal, &nominal, CompensationSettings::default()), &task, Method::Linear);
        let uncompensated =
            compensate(&mut Session::new(&nominal, &nominal, CompensationSettings::default()), &task, Method::None);
        assert!(linear.task_error() < 0.2 * uncompensated.task_error(), "{position:?}");
        assert!(linear.task_error() > 1e-6, "{position:?}");
    }
}

#[test]
fn mirroring_once_is_one_step_of_the_matrix_free_scheme() {
    let (nominal, actual) = machines();
    let task = task(&nominal, POINTS[3], 40.0, Target::ToolTip);
    let history = solve(&nominal, &actual, &task, Method::MatrixFree { alpha: 1.0 }).history;
    let mirrored = solve(&nominal, &actual, &task, Method::Mirror { passes: 1 }).history;
    assert!((history[1] - mirrored[1]).abs() < 1e-9);
}

#[test]
fn platform_point_compensation_leaves_the_tool_displaced() {
    let (nominal, actual) = machines();
    let task = task(&nominal, POINTS[1], 130.0, Target::PlatformPoint);
    let mut session = Session::new(&nominal, &actual, CompensationSettings::default());
    let done = compensate(&mut session, &task, Method::Direct);
    assert!(done.position_error.norm() < 1e-9);
    let tool = nominal.tool_displacement(&task.pose, &session.state().pose);
    let lever = nominal.tool_tip;
    let rotation = kinetostat::spatial::rotation_exp(done.residual_rotation);
    assert!((tool - (rotation * lever - lever)).norm() < 1e-9);
    assert!(tool.norm() > 0.1, "{tool}");
}

#[test]
fn every_bad_end_has_its_status() {
    let (nominal, actual) = machines();
    let near = task(&nominal, POINTS[0], 0.0, Target::ToolTip);
    for alpha in [0.0, -0.5, 1.5, f64::NAN] {
        for method in [Method::MatrixFree { alpha }, Method::FixedMatrix { alpha }, Method::Procedure { alpha }] {
            let done = solve(&nominal, &actual, &near, method);
            assert_eq!(done.status.label(), "bad_step_length");
            assert!(done.status.reason(&nominal).contains("(0, 1]"));
            assert!(done.outcome.is_none());
        }
    }
    let slow = solve(&nominal, &actual, &near, Method::MatrixFree { alpha: 1e-3 });
    assert_eq!(slow.status, CompensationStatus::Slow);
    assert!(slow.history.windows(2).all(|pair| pair[1] < pair[0]), "still converging");
    let far = TaskPoint { pose: nominal.pose_at(Vector3::new(600.0, 0.0, 0.0)), ..near };
    for method in Method::ALL {
        let done = solve(&nominal, &actual, &far, method);
        assert_eq!(done.status.label(), "unreachable", "{method:?}");
    }
    let crushed = TaskPoint { load: near.load.scale(1e6), ..near };
    for method in Method::ALL {
        let done = solve(&nominal, &actual, &crushed, method);
        assert!(!done.status.is_success(), "{method:?}: {:?}", done.status);
        assert!(!done.status.reason(&nominal).is_empty());
    }
}

#[test]
fn consecutive_points_may_start_from_one_another() {
    let (nominal, actual) = machines();
    for method in [Method::Direct, Method::Newton, Method::MatrixFree { alpha: 1.0 }] {
        let mut session = Session::new(&nominal, &actual, CompensationSettings::default());
        for i in 0..24 {
            let phi = 15.0 * f64::from(i);
            let (sin, cos) = phi.to_radians().sin_cos();
            let task = task(&nominal, [80.0 + 25.0 * cos, 80.0 + 25.0 * sin, 60.0], phi, Target::ToolTip);
            let warm = compensate(&mut session, &task, method);
            let cold = solve(&nominal, &actual, &task, method);
            for (a, b) in warm.drives.iter().zip(&cold.drives) {
                assert!((a - b).abs() < 1e-9, "{method:?} point {i}");
            }
            let target = session.target().unwrap();
            let back = nominal.inverse_kinematics(&target).unwrap();
            for (a, b) in back.drives.iter().zip(&warm.drives) {
                assert!((a - b).abs() < 1e-9, "{method:?} point {i}: the target commands the drives");
            }
        }
    }
}
