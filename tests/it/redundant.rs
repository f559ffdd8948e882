//! Machines whose drives control more than is asked of them: an arm on a rail, an arm whose turn about the tool is free, an
//! arm that is told only where its flange is.

use crate::support::engine::*;
use kinetostat::{
    compensation::{self, BoundedSettings, Limits, Method, Session, Target, TaskPoint, compensate, compensate_bounded},
    machine::{Coordinate, Machine},
    spatial::{Pose, Wrench, rotation_log},
    statics::Status,
};
use nalgebra::{DMatrix, Matrix6, Vector3, Vector6};

const RAIL: &str = include_str!("../machines/kr270_rail.toml");
const KR270: &str = include_str!("../machines/kr270.toml");
const ALL: &str = r#"controls = ["x", "y", "z", "rotation_x", "rotation_y", "rotation_z"]"#;

/// The arm with fewer coordinates to control.
fn arm(controls: &str) -> Machine {
    let toml = KR270.replace(ALL, controls);
    assert_ne!(toml, KR270);
    machine_from(&toml)
}

fn rail() -> Machine {
    machine_from(RAIL)
}

/// The arm on its rail, the arm whose turn about the tool is free, and the arm told only where its flange is.
fn machines() -> [(Machine, usize); 3] {
    let five = arm(r#"controls = ["x", "y", "z", "rotation_x", "rotation_y"]"#);
    [(rail(), 1), (five, 1), (arm(r#"controls = ["x", "y", "z"]"#), 3)]
}

fn places() -> [Vector3<f64>; 3] {
    [Vector3::new(1705.5, -342.81, 885.67), Vector3::new(1401.77, 106.51, 1070.08), Vector3::new(1650.0, 550.0, 750.0)]
}

/// Squared length of the drives' way from home, revolute joints at the reach.
fn way(machine: &Machine, drives: &[f64]) -> f64 {
    let unit = |is_revolute: bool| if is_revolute { machine.characteristic_length } else { 1.0 };
    let terms = machine.drives().zip(drives).zip(&machine.home.drives).map(|(((_, drive), rho), home)| {
        ((rho - home) * unit(drive.motion == kinetostat::machine::Motion::Revolute)).powi(2)
    });
    terms.sum()
}

/// Controlled coordinates of `pose` less those of `target`: mm, and rad times the reach.
fn task_error(machine: &Machine, pose: &Pose, target: &Pose) -> f64 {
    let turn = rotation_log(&(target.rotation.transpose() * pose.rotation));
    let errors = machine.controls.iter().map(|coordinate| match *coordinate {
        Coordinate::Translation(axis) => pose.translation[axis] - target.translation[axis],
        Coordinate::Rotation(axis) => turn[axis] * machine.characteristic_length,
    });
    errors.fold(0.0, |most, error| most.max(error.abs()))
}

#[test]
fn redundancy_is_counted() {
    for (machine, expected) in machines() {
        assert_eq!(machine.redundancy, expected, "{:?}", machine.controls);
    }
    for name in ["orthoglide", "tripteron"] {
        assert_eq!(catalogue_machine(name).redundancy, 0, "{name}");
    }
    assert_eq!(machine_from(KR270).redundancy, 0);
}

#[test]
fn the_drives_stand_as_near_to_home_as_the_task_allows() {
    for (machine, _) in machines() {
        for position in places() {
            let target = machine.pose_at(position);
            let at = machine.inverse_kinematics(&target).unwrap();
            let back = machine.forward_kinematics_from(&at, &at.drives).unwrap();
            assert!(task_error(&machine, &back.pose, &target) < 1e-8, "{:?}", machine.controls);
            let least = way(&machine, &at.drives);
            // Any neighbour that meets the task is farther: each drive in turn is pushed, and the others make up for it.
            for pushed in 0..machine.drive_count() {
                for push in [1e-2, -1e-2] {
                    let mut drives = at.drives.clone();
                    drives[pushed] +=
                        push * if pushed == 0 && drives.len() == 7 { machine.characteristic_length } else { 1.0 };
                    let start = machine.forward_kinematics_from(&at, &drives).unwrap();
                    let mut step = start.clone();
                    for _ in 0..20 {
                        let jacobian = machine.drive_jacobian(&step).unwrap();
                        let turn = rotation_log(&(target.rotation.transpose() * step.pose.rotation));
                        let error = machine.controls.iter().map(|coordinate| match *coordinate {
                            Coordinate::Translation(axis) => step.pose.translation[axis] - target.translation[axis],
                            Coordinate::Rotation(axis) => turn[axis],
                        });
                        let error = nalgebra::DVector::from_iterator(machine.controls.len(), error);
                        let change = jacobian * error;
                        let drives: Vec<f64> = step.drives.iter().zip(change.iter()).map(|(a, b)| a - b).collect();
                        step = machine.forward_kinematics_from(&step, &drives).unwrap();
                    }
                    assert!(task_error(&machine, &step.pose, &target) < 1e-6);
                    assert!(way(&machine, &step.drives) > least * (1.0 - 1e-12), "{:?}", machine.controls);
                }
            }
        }
    }
}

#[test]
fn the_inverse_kinematics_does_not_depend_on_where_it_starts() {
    for (machine, _) in machines() {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let [from, to] = [a, b].map(|i| machine.pose_at(places()[i]));
            let from_home = machine.inverse_kinematics(&to).unwrap();
            let start = machine.inverse_kinematics(&from).unwrap();
            let from_there = machine.inverse_kinematics_from(&start, &to).unwrap();
            for (x, y) in from_home.drives.iter().zip(&from_there.drives) {
                assert!((x - y).abs() < 1e-7, "{:?}: {x} from home, {y} from elsewhere", machine.controls);
            }
        }
    }
}

#[test]
fn a_drive_at_the_end_of_its_travel_stays_there_and_the_others_make_up_for_it() {
    let free = rail();
    let target = free.pose_at(Vector3::new(1600.0, 500.0, 1000.0));
    let rho = free.inverse_kinematics(&target).unwrap().drives[0];
    assert!(rho > 150.0, "{rho}");
    let short = machine_from(&RAIL.replace("travel_mm=[-2000.0,2000.0]", "travel_mm = [-100.0, 100.0]"));
    let at = short.inverse_kinematics(&target).unwrap();
    assert_eq!(at.drives[0], 100.0);
    let back = short.forward_kinematics_from(&at, &at.drives).unwrap();
    assert!(motion_between(&target, &back.pose).amax() < 1e-8);
    // As the arm without a rail, moved by it.
    let arm = machine_from(KR270);
    let without = arm.inverse_kinematics(&arm.pose_at(Vector3::new(1600.0, 400.0, 1000.0))).unwrap();
    for (x, y) in at.drives[1..].iter().zip(&without.drives) {
        assert!((x - y).abs() < 1e-9, "{x}, {y}");
    }
}

/// Compliance J k⁻¹ Jᵀ of the arm on its rail, its Jacobian by finite differences of the rigid machine.
fn compliance(machine: &Machine, drives: &[f64]) -> Matrix6<f64> {
    let at = machine.forward_kinematics(drives).unwrap();
    let mut sum = Matrix6::zeros();
    for (d, (_, drive)) in machine.drives().enumerate() {
        let step = if d == 0 { 1e-2 } else { 1e-6 };
        let [ahead, behind] = [step, -step].map(|step| {
            let mut moved = drives.to_vec();
            moved[d] += step;
            machine.forward_kinematics_from(&at, &moved).unwrap().pose
        });
        let column: Vector6<f64> = motion_between(&behind, &ahead) / (2.0 * step);
        sum += column * column.transpose() / drive.stiffness;
    }
    sum
}

#[test]
fn the_loaded_arm_on_its_rail_gives_way_as_its_compliance_says() {
    let machine = rail();
    for position in places() {
        let at = machine.inverse_kinematics(&machine.pose_at(position)).unwrap();
        let load = Wrench::new([0.1, -0.2, 0.15, 30.0, 20.0, -10.0]);
        let (state, outcome) = settle(&machine, &at, &load);
        assert_eq!(outcome.status, Status::Solved);
        let expected = compliance(&machine, &at.drives) * load.to_vector();
        let found = motion_between(&at.pose, &state.pose);
        assert!((found - expected).norm() < 1e-5 * expected.norm(), "{found:?}\n{expected:?}");
    }
}

#[test]
fn every_method_puts_the_tool_of_a_redundant_machine_right_by_the_same_command() {
    for (machine, _) in machines() {
        let actual = machine.with_errors(&machine.assembly_errors(&[0.05]));
        for target in [Target::ToolTip, Target::PlatformPoint, Target::FullPose] {
            for position in places() {
                let pose = machine.inverse_kinematics(&machine.pose_at(position)).unwrap().pose;
                let load = Wrench::new([800.0, -500.0, 600.0, -1e5, 2e5, 5e4]);
                let task = TaskPoint::new(pose, load, target);
                let settings = compensation::CompensationSettings { tolerance: 5e-12, ..Default::default() };
                let mut reference: Option<Vec<f64>> = None;
                for method in [
                    Method::Direct,
                    Method::Newton,
                    Method::FixedMatrix { alpha: 1.0 },
                    Method::MatrixFree { alpha: 1.0 },
                    Method::Procedure { alpha: 1.0 },
                ] {
                    let mut session = Session::new(&machine, &actual, settings);
                    let done = compensate(&mut session, &task, method);
                    let case = format!("{:?}, {target:?}, {}: {:?}", machine.controls, method.label(), done.status);
                    assert!(
                        done.status.is_success() && done.task_error() < 1e-8 + settings.tolerance_mm(&machine),
                        "{case} {}",
                        done.task_error()
                    );
                    let reference = reference.get_or_insert_with(|| done.drives.clone());
                    for (d, (a, b)) in reference.iter().zip(&done.drives).enumerate() {
                        let unit =
                            if machine.drive_count() == 7 && d == 0 { 1.0 } else { machine.characteristic_length };
                        assert!((a - b).abs() * unit < 1e-6, "{case}: drive {d} at {b}, direct {a}");
                    }
                }
            }
        }
    }
}

#[test]
fn corrections_of_a_redundant_machine_do_not_depend_on_the_path_before() {
    for (machine, _) in machines() {
        let actual = machine.with_errors(&machine.assembly_errors(&[0.05]));
        let task = |x: f64| {
            let pose =
                machine.inverse_kinematics(&machine.pose_at(Vector3::new(1500.0 + x, 200.0, 950.0))).unwrap().pose;
            TaskPoint::new(pose, Wrench::new([500.0, 300.0, -200.0, 0.0, 0.0, 0.0]), Target::ToolTip)
        };
        let settings = compensation::CompensationSettings { tolerance: 1e-12, ..Default::default() };
        let mut session = Session::new(&machine, &actual, settings);
        let along: Vec<Vec<f64>> =
            (0..=10).map(|k| compensate(&mut session, &task(5.0 * f64::from(k)), Method::Direct).drives).collect();
        let alone = compensate(&mut Session::new(&machine, &actual, settings), &task(50.0), Method::Direct);
        assert!(alone.status.is_success());
        for (a, b) in along[10].iter().zip(&alone.drives) {
            assert!((a - b).abs() < 1e-7, "{:?}: {a} along the path, {b} alone", machine.controls);
        }
    }
}

#[test]
fn a_whole_path_of_a_redundant_machine_is_corrected_within_limits() {
    for (machine, _) in machines() {
        let actual = machine.with_errors(&machine.assembly_errors(&[0.02]));
        let tasks: Vec<TaskPoint> = (0..12)
            .map(|k| {
                let pose = machine.pose_at(Vector3::new(1500.0 + 5.0 * f64::from(k), 200.0, 950.0));
                let pose = machine.inverse_kinematics(&pose).unwrap().pose;
                TaskPoint::new(pose, Wrench::new([500.0, 300.0, -200.0, 0.0, 0.0, 0.0]), Target::ToolTip)
            })
            .collect();
        let mut largest = vec![1e-9f64; machine.drive_count()];
        for task in &tasks {
            let mut session = Session::new(&machine, &actual, compensation::CompensationSettings::default());
            let done = compensate(&mut session, task, Method::Direct);
            let nominal = machine.inverse_kinematics(&task.pose).unwrap();
            for (most, (rho, nominal)) in largest.iter_mut().zip(done.drives.iter().zip(&nominal.drives)) {
                *most = most.max((rho - nominal).abs());
            }
        }
        let bound = |share: f64| Limits {
            correction: Some(largest.iter().map(|most| share * most).collect()),
            ..Limits::default()
        };
        let worst = |limits: &Limits| {
            let path = compensate_bounded(
                &machine,
                &actual,
                &tasks,
                limits,
                compensation::ErrorNorm::Rms,
                &BoundedSettings::default(),
                &|_| {},
            )
            .unwrap();
            let most = path.points.iter().map(|point| match point {
                compensation::BoundedPoint::Corrected(point) => point.position_error.norm(),
                other => panic!("{other:?}"),
            });
            most.fold(0.0, f64::max)
        };
        let (wide, narrow) = (worst(&bound(1.1)), worst(&bound(0.2)));
        assert!(wide < 1e-6, "{:?}: {wide} mm left though nothing binds", machine.controls);
        assert!(narrow > 1e-3, "{:?}: {narrow} mm left though the corrections are a fifth", machine.controls);
    }
}

#[test]
fn a_square_machine_has_the_drive_jacobian_of_finite_differences_and_a_redundant_one_the_shortest() {
    let machine = rail();
    let at = machine.inverse_kinematics(&machine.pose_at(places()[0])).unwrap();
    let jacobian = machine.drive_jacobian(&at).unwrap();
    // Forward by finite differences, in mm and rad of the platform's axes.
    let mut forward = DMatrix::zeros(6, 7);
    for d in 0..7 {
        let step = if d == 0 { 1e-2 } else { 1e-6 };
        let [ahead, behind] = [step, -step].map(|step| {
            let mut moved = at.drives.clone();
            moved[d] += step;
            machine.forward_kinematics_from(&at, &moved).unwrap().pose
        });
        let motion = motion_between(&behind, &ahead) / (2.0 * step);
        forward.fixed_view_mut::<3, 1>(0, d).copy_from(&motion.fixed_rows::<3>(0));
        let turn = at.pose.rotation.transpose() * motion.fixed_rows::<3>(3);
        forward.fixed_view_mut::<3, 1>(3, d).copy_from(&turn);
    }
    // Weighted pseudo-inverse: revolute joints in mm at the reach.
    let mut weighted = forward.clone();
    weighted.columns_mut(1, 6).scale_mut(1.0 / machine.characteristic_length);
    let mut expected = weighted.transpose() * (&weighted * weighted.transpose()).try_inverse().unwrap();
    expected.rows_mut(1, 6).scale_mut(1.0 / machine.characteristic_length);
    let scale = expected.amax();
    assert!((&jacobian - &expected).amax() < 1e-6 * scale, "{jacobian}\n{expected}");
}
