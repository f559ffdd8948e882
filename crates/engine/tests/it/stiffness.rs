//! What stiffnesses and compliances of the platform tell.

use kinetostat_engine::{
    nalgebra::{Matrix6, Vector6},
    statics::{rigid_wrenches, smallest_eigenvalue},
};

#[test]
fn wrenches_that_move_nothing_are_told_one_by_one() {
    // Held at a point 50 mm from P: it cannot move along x there, and not turn about z.
    let motions = [
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 2.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1e-4, 0.0, 0.0],
        [-50e-4, 0.0, 0.0, 0.0, 1e-4, 0.0],
    ];
    let compliance: Matrix6<f64> = motions.map(|m| Vector6::from(m) * Vector6::from(m).transpose()).iter().sum();
    let mut wrenches = rigid_wrenches(&compliance, 100.0);
    wrenches.sort_by(|a, b| a[5].total_cmp(&b[5]));
    let expected = [[1.0, 0.0, 0.0, 0.0, 50.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]].map(Vector6::from);
    assert_eq!(wrenches.len(), 2, "{wrenches:?}");
    for (wrench, expected) in wrenches.iter().zip(expected) {
        assert!((wrench - expected).amax() < 1e-9, "{wrench} {expected}");
    }
}

#[test]
fn a_stiffness_that_is_not_finite_has_no_eigenvalue_instead_of_no_end() {
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(smallest_eigenvalue(&(Matrix6::identity() * bad), 100.0).is_nan());
    }
    assert!((smallest_eigenvalue(&Matrix6::identity(), 1.0) - 1.0).abs() < 1e-15);
}
