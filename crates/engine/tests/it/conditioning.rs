//! The conditioning of an arm from its axes, and from its closure equations.

use kinetostat_engine::Machine;

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
