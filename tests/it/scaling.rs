//! Scaling load and chain errors by s: what the linear model and the superposition of sources leave out is O(s²).

use crate::support::engine::*;
use kinetostat::{
    machine::{ChainError, Configuration, Machine},
    spatial::Wrench,
    statics::{Scratch, Status, aggregate_errors, unloaded_stiffness},
};
use nalgebra::{Vector3, Vector6};

/// A machine in a configuration with both sources at full scale.
struct Sources {
    nominal: Machine,
    at: Configuration,
    load: Wrench,
    errors: Vec<ChainError>,
}

impl Sources {
    fn all() -> Vec<Self> {
        let place = |name, [x, y, z]: [f64; 3], degrees: [f64; 3], parts| {
            let nominal = catalogue_machine(name);
            let at = at_position(&nominal, Vector3::new(x, y, z));
            let errors = degrees.map(assembly_error).to_vec();
            Self { nominal, at, load: wrench_from(300.0, 2e4, parts), errors }
        };
        vec![
            place("orthoglide", [0.0, 0.0, 0.0], [1.0, -1.0, 1.0], [0.7, -0.4, 0.3, 1.0, 0.2, -0.5]),
            place("orthoglide", [126.35, 126.35, 126.35], [1.0, -1.0, 1.0], [-0.6, 0.8, -0.1, -0.8, -0.6, 0.3]),
            place("tripteron", [400.0, 650.0, 550.0], [0.3, 0.2, -0.4], [1.0, -2.0, 1.5, 3.0, -2.0, 1.0]),
        ]
    }

    /// Motion of P by the load and the errors at the given scales.
    fn motion(&self, load_scale: f64, error_scale: f64) -> Vector6<f64> {
        let errors: Vec<ChainError> = self.errors.iter().map(|error| error.scale(error_scale)).collect();
        let actual = self.nominal.with_errors(&errors);
        let (state, outcome) = settle(&actual, &self.at, &self.load.scale(load_scale));
        assert_eq!(outcome.status, Status::Solved, "{} at scales {load_scale}, {error_scale}", self.nominal.name);
        motion_between(&self.at.pose, &state.pose)
    }

    /// K_C⁻¹F plus the aggregated chain errors, eqs. (14), (15).
    fn linear_motion(&self, scale: f64) -> Vector6<f64> {
        let mut scratch = Scratch::new(&self.nominal);
        let stiffness = unloaded_stiffness(&self.nominal, &self.at, &mut scratch).unwrap();
        let by_load = stiffness.lu().solve(&self.load.to_vector()).unwrap();
        // The aggregate itself is taken at a scale at which its own curvature does not show.
        let tiny = 1e-6;
        let errors: Vec<ChainError> = self.errors.iter().map(|error| error.scale(tiny)).collect();
        let actual = self.nominal.with_errors(&errors);
        let by_errors = aggregate_errors(&self.nominal, &actual, &self.at, &mut scratch).unwrap().to_vector() / tiny;
        (by_load + by_errors) * scale
    }

    fn superposition_error(&self, scale: f64) -> Vector6<f64> {
        self.motion(scale, 0.0) + self.motion(0.0, scale) - self.motion(scale, scale)
    }

    fn length(&self, motion: &Vector6<f64>) -> f64 {
        motion.fixed_rows::<3>(0).norm() + motion.fixed_rows::<3>(3).norm() * self.nominal.characteristic_length
    }
}

const SCALES: [f64; 4] = [0.2, 0.1, 0.05, 0.025];

fn expect_slope_two(what: &str, name: &str, lengths: [f64; 4]) {
    for pair in 1..4 {
        let slope = (lengths[pair - 1] / lengths[pair]).log2();
        assert!(
            (slope - 2.0).abs() < 0.08,
            "{name}: {what} falls with slope {slope} between scales {} and {}: {lengths:?}",
            SCALES[pair - 1],
            SCALES[pair]
        );
    }
}

#[test]
fn nonlinear_minus_linear_is_of_second_order() {
    for sources in Sources::all() {
        let gap = |s| sources.length(&(sources.motion(s, s) - sources.linear_motion(s)));
        expect_slope_two("nonlinear − linear", &sources.nominal.name, SCALES.map(gap));
    }
}

#[test]
fn superposition_superposition_error_is_of_second_order() {
    for sources in Sources::all() {
        let gap = |s| sources.length(&sources.superposition_error(s));
        expect_slope_two("superposition superposition error", &sources.nominal.name, SCALES.map(gap));
    }
}

#[test]
fn superposition_superposition_error_needs_both_sources() {
    for sources in Sources::all() {
        let nothing = sources.length(&sources.motion(0.0, 0.0));
        assert!(nothing < 1e-9, "{}: without sources P moves by {nothing:e} mm", sources.nominal.name);
    }
}

#[test]
fn aggregation_of_a_common_base_shift_moves_the_platform_by_it() {
    let nominal = catalogue_machine("orthoglide");
    let shift = Vector3::new(0.3, -0.2, 0.1);
    let errors: Vec<ChainError> = nominal
        .chains
        .iter()
        .map(|chain| {
            let mut error = ChainError::default();
            error.base.linear = chain.route.base.rotation.transpose() * shift;
            error
        })
        .collect();
    let actual = nominal.with_errors(&errors);
    let moved = aggregate_errors(&nominal, &actual, &nominal.home, &mut Scratch::new(&nominal)).unwrap();
    assert!((moved.linear - shift).norm() < 1e-12 && moved.angular.norm() < 1e-14, "{moved:?}");
}
