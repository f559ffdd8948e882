//! Moving or rotating machine, load and workpiece together moves or rotates the results and changes nothing else.

use crate::support::{
    cases::cases,
    engine::*,
    machines::{HUNG, machine_file, places, some_errors, some_load},
};
use kinetostat::{
    machine::{Configuration, Machine},
    spatial::{Pose, Wrench},
    statics::{Scratch, State, Status, aggregate_errors},
};
use nalgebra::{Matrix6, Vector3};
use proptest::prelude::*;

/// The machine, and what its weight points to, carried to the pose `x_mo` of its old base frame in the new one.
fn carried(machine: &Machine, x_mo: &Pose) -> Machine {
    let mut machine = machine.clone();
    for chain in &mut machine.chains {
        chain.route.base = x_mo.compose(&chain.route.base);
        for spring in &mut chain.route.point_springs {
            for anchor in [&mut spring.from, &mut spring.to].into_iter().filter(|anchor| anchor.frame.is_none()) {
                anchor.at = x_mo.transform(anchor.at);
            }
        }
    }
    machine.gravity = x_mo.rotation * machine.gravity;
    machine.home.pose = x_mo.compose(&machine.home.pose);
    machine
}

fn rotated(x_mo: &Pose, wrench: &Wrench) -> Wrench {
    Wrench { force: x_mo.rotation * wrench.force, moment: x_mo.rotation * wrench.moment }
}

fn rotation_6(x_mo: &Pose) -> Matrix6<f64> {
    let mut r = Matrix6::zeros();
    r.fixed_view_mut::<3, 3>(0, 0).copy_from(&x_mo.rotation);
    r.fixed_view_mut::<3, 3>(3, 3).copy_from(&x_mo.rotation);
    r
}

fn carried_configuration(at: &Configuration, x_mo: &Pose) -> Configuration {
    Configuration { pose: x_mo.compose(&at.pose), ..at.clone() }
}

fn pose_difference(a: &Pose, b: &Pose, reach: f64) -> f64 {
    let motion = motion_between(a, b);
    motion.fixed_rows::<3>(0).amax().max(motion.fixed_rows::<3>(3).amax() * reach)
}

fn pose() -> impl Strategy<Value = Pose> {
    (prop::array::uniform3(-3.0..3.0f64), prop::array::uniform3(-500.0..500.0f64)).prop_map(|(turn, shift)| {
        let mut pose = Pose::from_rotation_vector(Vector3::from(turn));
        pose.translation = Vector3::from(shift);
        pose
    })
}

fn share() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(0.0..1.0f64)
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn equilibria_are_carried_along(x_mo in pose(), s in share(), p in prop::array::uniform6(-1.0..1.0f64)) {
        for (name, low, high) in CATALOGUE {
            let nominal = catalogue_machine(name);
            let at = at_position(&nominal, position_in_box(&nominal, low, high, s));
            let machine = with_assembly_errors(&nominal, [1.0, -1.0, 0.5]);
            let load = wrench_from(400.0, 3e4, p);
            let (here, outcome) = settle(&machine, &at, &load);
            let (there, moved) = settle(&carried(&machine, &x_mo), &carried_configuration(&at, &x_mo), &rotated(&x_mo, &load));
            prop_assert_eq!(&outcome.status, &Status::Solved);
            prop_assert_eq!(outcome.status, moved.status);
            let off = pose_difference(&x_mo.compose(&here.pose), &there.pose, machine.characteristic_length);
            prop_assert!(off < 1e-9, "{name}: pose off by {off:e} mm");
            let r = rotation_6(&x_mo);
            let off = stiffness_difference(&(r.transpose() * moved.stiffness.unwrap() * r), &outcome.stiffness.unwrap());
            prop_assert!(off < 1e-8, "{name}: stiffness off by {off:e}");
            for (a, b) in here.chains.iter().zip(&there.chains) {
                let largest = a.wrench.norm(machine.characteristic_length).max(1.0);
                let off = Wrench::from_vector(&(rotated(&x_mo, &a.wrench).to_vector() - b.wrench.to_vector()));
                prop_assert!(off.norm(machine.characteristic_length) < 1e-7 * largest, "{name}: chain wrench off by {off:?}");
                let off = a.coordinates.iter().zip(&b.coordinates).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
                prop_assert!(off < 1e-9, "{name}: chain coordinates off by {off:e}");
            }
        }
    }

    #[test]
    fn inverse_kinematics_is_carried_along(x_mo in pose(), s in share()) {
        for (name, low, high) in CATALOGUE {
            let machine = catalogue_machine(name);
            let at = at_position(&machine, position_in_box(&machine, low, high, s));
            let there = carried(&machine, &x_mo).inverse_kinematics(&x_mo.compose(&at.pose));
            let there = there.map_err(|e| TestCaseError::fail(format!("{name}: {e}")))?;
            for (a, b) in at.drives.iter().zip(&there.drives) {
                prop_assert!((a - b).abs() < 1e-8, "{name}: drive at {b}, was {a}");
            }
        }
    }

    #[test]
    fn aggregated_errors_are_carried_along(x_mo in pose(), s in share()) {
        for (name, low, high) in CATALOGUE {
            let nominal = catalogue_machine(name);
            let actual = with_assembly_errors(&nominal, [1.0, -1.0, 0.5]);
            let at = at_position(&nominal, position_in_box(&nominal, low, high, s));
            let here = aggregate_errors(&nominal, &actual, &at, &mut Scratch::new(&nominal)).unwrap().to_vector();
            let (nominal, actual) = (carried(&nominal, &x_mo), carried(&actual, &x_mo));
            let at = carried_configuration(&at, &x_mo);
            let there = aggregate_errors(&nominal, &actual, &at, &mut Scratch::new(&nominal)).unwrap().to_vector();
            let off = (rotation_6(&x_mo) * here - there).amax();
            prop_assert!(off < 1e-9, "{name}: aggregate off by {off:e}");
        }
    }
}

#[test]
fn a_rigid_state_of_the_carried_machine_is_unloaded() {
    let mut x_mo = Pose::from_roll_pitch_yaw(Vector3::new(0.4, -1.0, 2.0));
    x_mo.translation = Vector3::new(100.0, -30.0, 7.0);
    for (name, ..) in CATALOGUE {
        let machine = carried(&catalogue_machine(name), &x_mo);
        let mut state = State::rigid(&machine, &machine.home);
        let outcome = resettle(&machine, &machine.home.drives, &Wrench::zero(), &mut state);
        assert_eq!((outcome.status, outcome.iterations), (Status::Solved, 0), "{name}");
    }
}

#[test]
fn equilibria_with_weight_springs_and_modules_are_carried_along() {
    let mut x_mo = Pose::from_roll_pitch_yaw(Vector3::new(0.4, -1.0, 2.0));
    x_mo.translation = Vector3::new(100.0, -300.0, 70.0);
    for name in HUNG {
        let nominal = machine_file(name);
        for (seed, at) in places(&nominal, 4).into_iter().enumerate() {
            let machine = nominal.with_errors(&some_errors(&nominal, seed));
            let load = some_load(&machine, 1000.0, seed);
            let (here, outcome) = settle(&machine, &at, &load);
            let (there, moved) =
                settle(&carried(&machine, &x_mo), &carried_configuration(&at, &x_mo), &rotated(&x_mo, &load));
            assert_eq!((&outcome.status, &moved.status), (&Status::Solved, &Status::Solved), "{name}");
            let off = pose_difference(&x_mo.compose(&here.pose), &there.pose, machine.characteristic_length);
            assert!(off < 1e-8, "{name}: pose off by {off:e} mm");
            let r = rotation_6(&x_mo);
            let off =
                stiffness_difference(&(r.transpose() * moved.stiffness.unwrap() * r), &outcome.stiffness.unwrap());
            assert!(off < 1e-8, "{name}: stiffness off by {off:e}");
            let off = (r.transpose() * &moved.drive_sensitivity - &outcome.drive_sensitivity).amax();
            assert!(off < 1e-8 * outcome.drive_sensitivity.amax(), "{name}: drive sensitivity off by {off:e}");
            for (a, b) in here.chains.iter().zip(&there.chains) {
                // Wrenches of loops are in the axes of a frame of the machine.
                let pairs = a.loops.iter().zip(&b.loops).map(|(a, b)| (*a, *b));
                for (a, b) in pairs.chain([(rotated(&x_mo, &a.wrench), b.wrench)]) {
                    let off = Wrench::from_vector(&(a.to_vector() - b.to_vector())).norm(machine.characteristic_length);
                    assert!(
                        off < 1e-7 * a.norm(machine.characteristic_length).max(1e3),
                        "{name}: wrench off by {off:e} N"
                    );
                }
                let off = a.coordinates.iter().zip(&b.coordinates).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
                assert!(off < 1e-8, "{name}: chain coordinates off by {off:e}");
            }
        }
    }
}
