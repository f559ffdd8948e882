//! The machined surface against brute force: every move tried at every point.

use kinetostat_removal::{Cutter, Field};
use nalgebra::{Vector2, Vector3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::paths::{block, cut_only};

/// g(d) of a cutter of 10 mm by its corner radius, for itself.
fn lower_surface(radius: f64, corner: f64, distance: f64) -> f64 {
    if distance > radius {
        return f64::INFINITY;
    }
    let into = (distance - radius + corner).max(0.0);
    corner - (corner * corner - into * into).max(0.0).sqrt()
}

/// The lower envelope of a move by its samples and a golden section about the best of them.
fn envelope(radius: f64, corner: f64, from: &Vector3<f64>, to: &Vector3<f64>, p: Vector2<f64>) -> f64 {
    let at = |share: f64| {
        let tip = from + (to - from) * share;
        tip.z + lower_surface(radius, corner, (p - tip.xy()).norm())
    };
    let along = (to - from).xy();
    let squared = along.norm_squared();
    let mut shares = [0.0, 1.0, 0.0, 0.0, 0.0];
    let mut count = 2;
    let mut bounds = (0.0, 1.0);
    if squared > 0.0 {
        // Covered between the crossings with the circle of the radius about p.
        let foot = (p - from.xy()).dot(&along) / squared;
        let aside = (from.xy() + along * foot - p).norm_squared();
        let half = ((radius * radius - aside).max(0.0) / squared).sqrt();
        bounds = ((foot - half).clamp(0.0, 1.0), (foot + half).clamp(0.0, 1.0));
        shares[2..].copy_from_slice(&[foot.clamp(0.0, 1.0), bounds.0 + 1e-9, bounds.1 - 1e-9]);
        count = 5;
    }
    let (mut a, mut b) = bounds;
    for _ in 0..80 {
        let (c, d) = (b - 0.618_033_988_75 * (b - a), a + 0.618_033_988_75 * (b - a));
        if at(c) < at(d) { b = d } else { a = c }
    }
    shares[..count].iter().map(|share| at(*share)).fold(at(0.5 * (a + b)), f64::min)
}

type Legs = Vec<(usize, Vec<Vector3<f64>>)>;

/// Random polylines at few levels, level or sloping, each with one of three cutters.
fn programs() -> impl Strategy<Value = Legs> {
    let point = (-15.0..15.0_f64, -15.0..15.0_f64, prop_oneof![Just(-1.0), Just(-2.0), Just(-3.0), -4.0..-0.5_f64]);
    let path = (0..3_usize, any::<bool>(), prop::collection::vec(point, 2..8)).prop_map(|(cutter, level, points)| {
        let z = points[0].2;
        (cutter, points.iter().map(|p| Vector3::new(p.0, p.1, if level { z } else { p.2 })).collect())
    });
    prop::collection::vec(path, 1..6)
}

const CORNERS: [f64; 3] = [0.0, 1.5, 5.0];

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, rng_seed: RngSeed::Fixed(1), max_shrink_iters: 60, ..ProptestConfig::default() })]

    #[test]
    fn the_surface_is_that_of_all_moves(program in programs(), step in prop_oneof![Just(0.1), Just(0.7), Just(100.0)]) {
        let mut field = Field::new(block(), 0.25).unwrap();
        for (cutter, points) in &program {
            cut_only(&mut field, &Cutter::bull(10.0, CORNERS[*cutter]).unwrap(), points, step);
        }
        let mut wrong = Vec::new();
        let count = 3000_u32;
        let legs: Vec<_> = program.iter().flat_map(|(_, points)| points.windows(2)).collect();
        for number in 0..count {
            let golden = |step: f64| (f64::from(number) * step).fract();
            let mut p = Vector2::new(-20.0 + 40.0 * (f64::from(number) + 0.5) / f64::from(count), -20.0 + 40.0 * golden(0.618_033_988_75));
            if number % 2 == 0 {
                // Near the rim of a move, where walls are.
                let ends = legs[number as usize / 2 % legs.len()];
                let angle = std::f64::consts::TAU * golden(0.754_877_666_25);
                let from_axis = 5.0 + 0.3 * (golden(0.569_840_290_998) - 0.5);
                p = (ends[0] + (ends[1] - ends[0]) * golden(0.137_034)).xy() + from_axis * Vector2::new(angle.cos(), angle.sin());
            }
            if p.amax() > 39.0 {
                continue;
            }
            let of_radius = |radius: f64| program.iter().flat_map(|(cutter, points)| {
                points.windows(2).map(move |ends| envelope(radius, CORNERS[*cutter], &ends[0], &ends[1], p))
            }).fold(f64::INFINITY, f64::min);
            let found = field.surface(p).map_or(f64::INFINITY, |point| point.position.z);
            // What is touched within 1e-6 mm counts as cut.
            let (exact, touched) = (of_radius(5.0), of_radius(5.0 + 1.5e-6));
            if !(found <= exact + 1e-5 && found >= touched - 1e-5) {
                wrong.push((p.x, p.y, found, exact));
            }
        }
        prop_assert!(wrong.is_empty(), "{} of {count}: {:?}", wrong.len(), &wrong[..wrong.len().min(5)]);
    }
}
