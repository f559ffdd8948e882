//! Numbers that write down what is done with them.

use kinetostat_engine::lanes::{MAX_LANES, Real, Traced, record};

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
        assert!((zero * unused).is_zero() && !x.is_zero());
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
