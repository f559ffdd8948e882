//! What must not change: order of cuts, turning and shifting a case, cutting more.

use kinetostat_removal::{Cutter, Engagement, Field, Slicing, Stock};
use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::paths::{Placed, block, cut_only};

/// Legs within 12 mm of the middle, at one of few levels or sloping.
fn legs() -> impl Strategy<Value = Vec<[[f64; 3]; 2]>> {
    let level = || prop_oneof![Just(-1.0), Just(-2.0), Just(-3.5), -4.0..-0.3_f64];
    let leg = (-12.0..12.0_f64, -12.0..12.0_f64, level(), -12.0..12.0_f64, -12.0..12.0_f64, level(), any::<bool>());
    prop::collection::vec(
        leg.prop_map(|(x0, y0, z0, x1, y1, z1, is_level)| [[x0, y0, z0], [x1, y1, if is_level { z0 } else { z1 }]]),
        1..6,
    )
}

fn cutters() -> impl Strategy<Value = Cutter> {
    prop_oneof![
        3 => Just(Cutter::flat(10.0).unwrap()),
        1 => Just(Cutter::ball(8.0).unwrap()),
        1 => Just(Cutter::bull(10.0, 2.0).unwrap()),
        1 => Just(Cutter::drill(8.0, 118.0).unwrap()),
    ]
}

fn field_of(legs: &[[[f64; 3]; 2]], cutter: &Cutter, placed: &Placed) -> Field {
    let mut field = Field::new(block(), 0.23).unwrap();
    for leg in legs {
        cut_only(&mut field, cutter, &leg.map(|[x, y, z]| placed.at(x, y, z)), 0.5);
    }
    field
}

fn height(field: &Field, p: Vector2<f64>) -> f64 {
    field.surface(p).map_or(f64::INFINITY, |point| point.position.z)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 10, failure_persistence: None, rng_seed: RngSeed::Fixed(1), max_shrink_iters: 60, ..ProptestConfig::default() })]

    #[test]
    fn turning_and_shifting_a_case_changes_nothing(
        legs in legs(), cutter in cutters(), turn in prop_oneof![Just(std::f64::consts::FRAC_PI_2), -3.2..3.2_f64],
        shift in [-0.5..0.5_f64, -0.5..0.5_f64], tip in [-8.0..8.0_f64, -8.0..8.0_f64, -5.0..-0.5_f64], heading in -3.2..3.2_f64,
        slope in prop_oneof![2 => Just(0.0), 1 => -0.6..0.6_f64],
    ) {
        let original = Placed { turn: 0.0, shift: Vector2::zeros() };
        let moved = Placed { turn, shift: Vector2::from(shift) };
        // Contact of a nose is known to a slice, and slices begin where cells say.
        let slicing = Slicing { nose_slices: 32, ..Slicing::default() };
        let mut found = [original, moved].map(|placed| {
            let field = field_of(&legs, &cutter, &placed);
            let origin = placed.at(0.0, 0.0, 0.0);
            let along = placed.at(heading.cos(), heading.sin(), slope) - origin;
            let mut engagement = Engagement::default();
            field.engage(&cutter, &placed.at(tip[0], tip[1], tip[2]), &along, &slicing, &mut engagement).unwrap();
            engagement
        });
        let [a, b] = &mut found;
        prop_assert!((a.depth_mm - b.depth_mm).abs() < 0.4, "{} {}", a.depth_mm, b.depth_mm);
        prop_assert!((a.end_area_mm2 - b.end_area_mm2).abs() < 0.01 * (1.0 + a.end_area_mm2));
        prop_assert!((a.volume_per_mm - b.volume_per_mm).abs() < 0.02 * (1.0 + a.volume_per_mm), "{} {}", a.volume_per_mm, b.volume_per_mm);
        prop_assert!((a.width_mm - b.width_mm).abs() < 0.3, "{} {}", a.width_mm, b.width_mm);
        if cutter == Cutter::flat(10.0).unwrap() {
            prop_assert!((a.depth_mm - b.depth_mm).abs() < 1e-6);
            prop_assert!((a.volume_per_mm - b.volume_per_mm).abs() < 1e-3 * (1.0 + a.volume_per_mm));
            prop_assert_eq!(a.slices.len(), b.slices.len());
            for (a, b) in a.arcs.iter().zip(&b.arcs) {
                prop_assert!((a.from - b.from).abs() < 1e-4 && (a.to - b.to).abs() < 1e-4, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn the_order_of_cuts_does_not_matter_and_more_cuts_remove_more(legs in legs(), more in legs(), cutter in cutters()) {
        let placed = Placed { turn: 0.0, shift: Vector2::zeros() };
        let before = field_of(&legs, &cutter, &placed);
        let all: Vec<_> = legs.iter().chain(&more).copied().collect();
        let forwards = field_of(&all, &cutter, &placed);
        let reversed: Vec<_> = all.iter().rev().copied().collect();
        let backwards = field_of(&reversed, &cutter, &placed);
        for number in 0..1000_u32 {
            let p = Vector2::new(
                -18.0 + 36.0 * (f64::from(number) + 0.5) / 1000.0,
                -18.0 + 36.0 * (f64::from(number) * 0.618_033_988_749_894_8).fract(),
            );
            prop_assert!(height(&forwards, p) <= height(&before, p) + 1e-9);
            let (a, b) = (height(&forwards, p), height(&backwards, p));
            prop_assert!(a == b || (a - b).abs() < 1e-6, "{p:?} {a} {b}");
        }
        prop_assert!(forwards.volumes().removed_mm3 >= before.volumes().removed_mm3 - 1e-6);
    }

    /// Whatever is given, there is an answer or an error.
    #[test]
    fn any_numbers_have_an_answer(
        numbers in prop::collection::vec(prop_oneof![4 => -30.0..30.0_f64, 1 => Just(0.0), 1 => prop::num::f64::ANY], 12),
        cutter in cutters(),
    ) {
        let at = |first: usize| Vector3::new(numbers[first], numbers[first + 1], numbers[first + 2]);
        let mut field = Field::new(block(), 0.5).unwrap();
        let _ = field.cut(&cutter, &at(0), &at(3), 0);
        let mut engagement = Engagement::default();
        if field.engage(&cutter, &at(6), &at(9), &Slicing::default(), &mut engagement).is_ok() {
            prop_assert!(engagement.volume_per_mm.is_finite() && engagement.volume_per_mm >= 0.0);
        }
        let _ = field.surface(at(6).xy());
        let _ = Field::new(Stock::cuboid(Vector3::zeros(), Vector3::repeat(10.0)).unwrap(), numbers[0].abs().max(0.05));
    }
}
