//! Numbers side by side, with the bits that each has alone, and numbers that write down what is done with them.

use kinetostat_engine::{
    lanes::{Lanewise, Level, MAX_LANES, Real, Traced, Vec3, record, rotation_exp, rotation_log, sin_cos, solve},
    nalgebra::Vector3,
    spatial,
};
use proptest::prelude::*;

fn postures(of: impl Fn(f64) -> Vec<f64>) -> Vec<Vec<f64>> {
    (0..MAX_LANES).map(|lane| of(lane as f64)).collect()
}

#[test]
fn what_has_no_effect_is_left_out() {
    let program = record(&postures(|lane| vec![lane, 2.0 + lane]), |inputs| {
        let (x, y) = (inputs[0], inputs[1]);
        let (zero, one) = (Traced::zero(), Traced::splat(1.0));
        let unused = x / y;
        let product = (x + zero) * y * one;
        let same = y * (x - zero);
        let minus = zero - (-x) * y;
        assert!((zero * unused).all_zero() && !x.all_zero());
        Some(vec![product + same, minus])
    });
    let program = program.unwrap();
    assert_eq!(program.operation_count(), 2);
    assert_eq!(program.evaluate(&[3.0, 5.0], &mut Vec::new()), [30.0, 15.0]);
}

#[test]
fn what_is_computed_posture_by_posture_cannot_be_recorded() {
    let program = record(&postures(|lane| vec![lane]), |inputs| {
        let mut number = inputs[0];
        number.set_lane(0, 1.0);
        Some(vec![number])
    });
    assert_eq!(program, None);
}

#[test]
fn a_number_that_is_none_is_the_larger() {
    assert!(f64::is_nan(f64::NAN.larger(1.0)) && f64::is_nan(1.0.larger(f64::NAN)));
    assert_eq!((2.0.larger(1.0), 1.0.larger(2.0)), (2.0, 2.0));
}

#[test]
fn sine_and_cosine_serve_all_angles_if_the_postures_have_large_ones() {
    let angles = postures(|lane| vec![0.4 * lane - 1.3]);
    let program = record(&angles, |inputs| {
        let (sin, cos) = sin_cos(inputs[0]);
        Some(vec![sin, cos])
    });
    let program = program.unwrap();
    for i in -40..40 {
        let angle = 0.1 * f64::from(i) + 0.03;
        assert_eq!(program.evaluate(&[angle], &mut Vec::new()), <[f64; 2]>::from(sin_cos(angle)));
    }
}

#[test]
fn rows_are_exchanged_where_some_posture_asks_for_it() {
    let matrices = postures(|lane| vec![lane - 3.5, 2.0, 1.0, -1.0]);
    let program = record(&matrices, |m| {
        let mut right = [[Traced::splat(1.0), Traced::splat(2.0)]];
        let regular = solve([[m[0], m[1]], [m[2], m[3]]], 2, &mut right);
        (regular == u8::MAX).then(|| right[0].to_vec())
    });
    let program = program.unwrap();
    for first in [0.0, 0.5, -7.0, 1.5] {
        let mut right = [[1.0, 2.0]];
        assert_eq!(solve([[first, 2.0], [1.0, -1.0]], 2, &mut right), 1);
        assert_eq!(program.evaluate(&[first, 2.0, 1.0, -1.0], &mut Vec::new()), right[0]);
    }
}

fn assert_near_library(x: f64) {
    let (sin, cos) = sin_cos(x);
    assert!((sin - x.sin()).abs() <= 2e-16, "sin {x}: {sin} is not {}", x.sin());
    assert!((cos - x.cos()).abs() <= 2e-16, "cos {x}: {cos} is not {}", x.cos());
}

proptest! {
    #![proptest_config(crate::cases::cases(256))]

    #[test]
    fn sine_and_cosine_are_the_librarys(x in -7.0..7.0f64, far in -2e5..2e5f64) {
        assert_near_library(x);
        assert_near_library(far);
    }
}

#[test]
fn quarters_meet() {
    for quarter in -9..=9 {
        let middle = f64::from(quarter) * std::f64::consts::FRAC_PI_2;
        for x in [-1.0, -1e-9, 0.0, 1e-9, 1.0].map(|d| middle + d * std::f64::consts::FRAC_PI_4) {
            assert_near_library(x);
            assert_near_library(x.next_up());
            assert_near_library(x.next_down());
        }
    }
    assert_eq!(sin_cos(0.0), (0.0, 1.0));
    assert!(sin_cos(f64::NAN).0.is_nan() && sin_cos(f64::INFINITY).1.is_nan());
}

/// Angles from tiny to beyond what a joint can have.
fn angles() -> impl Strategy<Value = [f64; MAX_LANES]> {
    prop::array::uniform8(prop_oneof![-1e-9..1e-9f64, -0.7..0.7f64, -4.0..4.0f64, -1e6..1e6f64])
}

fn packed<R: Real>(values: &[f64]) -> R {
    let mut number = R::zero();
    for (lane, &value) in values.iter().enumerate().take(R::LANES) {
        number.set_lane(lane, value);
    }
    number
}

/// A turn of size `angle` about an oblique axis.
fn turn<R: Real>(angle: R) -> Vec3<R> {
    Vec3([angle * R::splat(0.6), angle * R::splat(-0.48), angle * R::splat(0.64)])
}

/// Whatever the neighbouring lanes hold, a lane of so many gets the bits of `f64`.
struct Check<'a>(&'a [f64; MAX_LANES], usize);

impl Lanewise for Check<'_> {
    type Output = ();

    fn run_with<R: Real>(self) {
        let Self(values, lanes) = self;
        assert_eq!(R::LANES, lanes);
        R::vectorized(|| {
            let x: R = packed(values);
            let (sin, cos) = sin_cos(x);
            let rotation = rotation_exp(turn(x));
            let log = rotation_log(rotation);
            for (lane, &value) in values.iter().enumerate().take(R::LANES) {
                assert_eq!((sin.lane(lane), cos.lane(lane)), sin_cos(value));
                let alone = rotation_exp(turn(value));
                for (column, alone) in rotation.iter().zip(&alone) {
                    assert_eq!(column.0.map(|entry| entry.lane(lane)), alone.0);
                }
                assert_eq!(log.0.map(|entry| entry.lane(lane)), rotation_log(alone).0);
                assert_eq!(R::mask_to_bits(x.sqrt().is_nan()) >> lane & 1 == 1, value < 0.0);
            }
        });
    }
}

proptest! {
    #![proptest_config(crate::cases::cases(128))]

    #[test]
    fn lanes_have_the_bits_of_a_single_number(values in angles()) {
        for level in Level::available() {
            let lanes = match level {
                Level::One => 1,
                Level::Four => 4,
                Level::Eight => 8,
            };
            level.run(Check(&values, lanes));
        }
    }

    #[test]
    fn rotations_are_those_of_poses(angle in -3.0..3.0f64, small in -0.1..0.1f64) {
        for angle in [angle, small, 0.0] {
            let vector = Vector3::from(turn(angle).0);
            let expected = spatial::rotation_exp(vector);
            let columns = rotation_exp(turn(angle));
            for (column, expected) in columns.iter().zip(expected.column_iter()) {
                prop_assert!((Vector3::from(column.0) - expected).norm() < 1e-15);
            }
            let log = Vector3::from(rotation_log(columns).0);
            prop_assert!((log - vector).norm() < 1e-14);
        }
    }
}
