//! Into how many pieces a way is cut, and how a tool turns along it.

use kinetostat_programs::{Orientation, Sampling};
use kinetostat_spatial::{least_turn, rotation_exp};
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;

#[test]
fn values_that_split_nothing_are_refused() {
    assert_eq!(
        Sampling::new(0.0, 1.0).unwrap_err().to_string(),
        "chordal_tolerance_mm = 0: expected a finite number above 0"
    );
    assert_eq!(
        Sampling::new(0.1, f64::NAN).unwrap_err().to_string(),
        "max_segment_mm = NaN: expected a finite number above 0"
    );
}

#[test]
fn arc_chords_stay_within_the_tolerance_and_no_fewer_would_do() {
    let sampling = Sampling::new(0.01, 1e6).unwrap();
    for radius in [0.5, 5.0, 25.0, 1e4] {
        let sweep = 5.0;
        let n = sampling.arc_pieces(radius, sweep, radius * sweep).unwrap();
        let sagitta = |n: usize| radius * (1.0 - (sweep / n as f64 / 2.0).cos());
        assert!(sagitta(n) <= 0.01 * (1.0 + 1e-6), "{radius}: {}", sagitta(n));
        assert!(sagitta(n - 1) > 0.01, "{radius}");
    }
}

#[test]
fn a_multiple_of_the_piece_gains_no_piece_and_too_many_are_refused() {
    let sampling = Sampling::new(0.01, 0.1).unwrap();
    assert_eq!(sampling.line_pieces(0.3), Some(3));
    assert_eq!(sampling.line_pieces(0.0), Some(1));
    assert_eq!(sampling.line_pieces(1e9), None);
    assert_eq!(sampling.line_pieces(f64::NAN), None);
    // A tolerance above the radius still gives four pieces to a circle.
    assert_eq!(Sampling::new(9.0, 1e6).unwrap().arc_pieces(1.0, 6.2, 6.2), Some(4));
}

fn unit() -> impl Strategy<Value = Vector3<f64>> {
    let number = || -1.0..1.0f64;
    (number(), number(), number())
        .prop_map(|(x, y, z)| Vector3::new(x, y, z))
        .prop_filter("too short", |v| v.norm() > 0.1)
        .prop_map(|v| v.normalize())
}

proptest! {
    #![proptest_config(crate::support::cases::cases(128))]

    #[test]
    fn a_tool_turns_evenly_from_one_orientation_to_the_next(a in unit(), b in unit(), c in unit(), t in 0.0..1.0f64) {
        prop_assume!(a.dot(&b) > -0.999);
        let quaternion = |v: Vector3<f64>| Orientation::Platform(UnitQuaternion::from_scaled_axis(v * 1.5));
        let pairs = [(Orientation::ToolAxis(a), Orientation::ToolAxis(b)), (quaternion(a), quaternion(c))];
        for (from, to) in pairs {
            let between = from.towards(&to, t);
            prop_assert!((from.angle_to(&between) - t * from.angle_to(&to)).abs() < 1e-7);
            prop_assert!((between.angle_to(&to) - (1.0 - t) * from.angle_to(&to)).abs() < 1e-7);
        }
    }

    #[test]
    fn the_least_turn_leads_there(a in unit(), b in unit()) {
        prop_assert!((rotation_exp(least_turn(a, b)) * a - b).norm() < 1e-12);
        prop_assert!((rotation_exp(least_turn(a, -a)) * a + a).norm() < 1e-12);
        prop_assert_eq!(least_turn(a, a).norm() < 1e-7, true);
    }
}
