//! The conditioning of an arm from its axes, and from its closure equations.

use kinetostat_engine::{Machine, nalgebra::Vector3, spatial::rotation_exp};

#[test]
fn the_axes_of_an_arm_tell_what_its_closure_does() {
    let assert_alike = |machine: &Machine, drives: &[f64]| {
        let at = machine.forward_kinematics(drives).unwrap();
        let of_closure = machine.conditioning(&at);
        let rounding = 1e-9 * of_closure.max(1e-3);
        let is_conditioned = |least: f64| machine.is_conditioned(&at, least);
        assert!(is_conditioned(of_closure - rounding), "{}: less than {of_closure}", machine.name);
        assert!(!is_conditioned(of_closure + rounding), "{}: more than {of_closure}", machine.name);
    };
    for name in ["fanuc_r2000ic", "kr270"] {
        let machine = Machine::named(name).unwrap();
        for seed in 0..20 {
            let beside = |(k, home): (usize, &f64)| home + 0.4 * ((seed * 7 + k * 3) as f64).sin();
            let drives: Vec<f64> = machine.home.drives.iter().enumerate().map(beside).collect();
            assert_alike(&machine, &drives);
        }
    }
    // Not an arm.
    let orthoglide = Machine::named("orthoglide").unwrap();
    assert_alike(&orthoglide, &orthoglide.home.drives);
    assert!(orthoglide.is_conditioned(&orthoglide.home, 0.1));
}

/// The axes follow from the drives alone, the closure from the pose of the platform too: a pose that is none, turned and stretched
/// along one axis, tells which of the two was asked.
#[test]
fn arms_are_judged_by_their_axes() {
    for name in ["fanuc_r2000ic", "kr270"] {
        let machine = Machine::named(name).unwrap();
        let beside = |(k, home): (usize, &f64)| home + 0.2 * (k as f64 + 1.0).sin();
        let drives: Vec<f64> = machine.home.drives.iter().enumerate().map(beside).collect();
        let at = machine.forward_kinematics(&drives).unwrap();
        let mut displaced = at.clone();
        displaced.pose.rotation = rotation_exp(Vector3::new(0.3, -0.2, 0.4)) * displaced.pose.rotation;
        displaced.pose.rotation.column_mut(0).scale_mut(3.0);
        displaced.pose.translation += Vector3::new(0.1, -0.2, 0.15) * machine.characteristic_length;
        let (true_one, of_closure) = (machine.conditioning(&at), machine.conditioning(&displaced));
        assert!((true_one - of_closure).abs() > 1e-3 * true_one, "{name}: {true_one} and {of_closure}");
        assert!(machine.is_conditioned(&displaced, true_one * (1.0 - 1e-6)), "{name}: less than {true_one}");
        assert!(!machine.is_conditioned(&displaced, true_one * (1.0 + 1e-6)), "{name}: more than {true_one}");
    }
}
