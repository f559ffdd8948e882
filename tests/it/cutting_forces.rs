//! Forces of end mills and drills against what their teeth receive one by one, and against what energy asks for.

use std::f64::consts::{PI, TAU};

use kinetostat::{
    process::cutting::{
        CutDirection, CutForce, CuttingLaw, Drilling, DrillingLaw, EdgeForce, EdgeLaw, EndMilling, Kienzle, MeanOrPeak,
        PathLoad, SlotMilling, materials,
    },
    toolpath::{Load, Sampling, Toolpath, TurnDirection},
};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

use crate::support::cases::cases;

const LINEAR: EdgeLaw = EdgeLaw::Linear {
    tangential: EdgeForce { cutting: 767.0, edge: 27.7 },
    radial: EdgeForce { cutting: 169.0, edge: 26.6 },
    axial: EdgeForce { cutting: -222.0, edge: -0.7 },
};

fn milling(edge: EdgeLaw) -> EndMilling {
    EndMilling {
        edge,
        diameter_mm: 10.0,
        teeth: 4,
        depth_mm: 5.0,
        width_mm: 2.5,
        direction: CutDirection::Down,
        feed_per_tooth_mm: None,
        spindle: TurnDirection::Clockwise,
        over_turn: MeanOrPeak::Mean,
    }
}

fn any_milling() -> impl Strategy<Value = EndMilling> {
    let linear = prop::array::uniform6(0.0..1000.0f64).prop_map(|k| EdgeLaw::Linear {
        tangential: EdgeForce { cutting: k[0], edge: k[1] / 20.0 },
        radial: EdgeForce { cutting: k[2], edge: k[3] / 20.0 },
        axial: EdgeForce { cutting: -k[4], edge: -k[5] / 20.0 },
    });
    let kienzle =
        (500.0..3000.0f64, 0.0..0.4f64, 0.0..0.8f64, -0.3..0.3f64).prop_map(|(specific_force, exponent, r, a)| {
            EdgeLaw::Kienzle {
                tangential: Kienzle { specific_force, exponent },
                tangential_share: 1.0,
                radial_ratio: r,
                axial_ratio: a,
            }
        });
    let edge = prop_oneof![linear, kienzle];
    (edge, 1..9u32, 0.02..1.0f64, any::<bool>(), any::<bool>()).prop_map(|(edge, teeth, share, up, clockwise)| {
        EndMilling {
            teeth,
            width_mm: 10.0 * share,
            direction: if up { CutDirection::Up } else { CutDirection::Down },
            spindle: if clockwise { TurnDirection::Clockwise } else { TurnDirection::CounterClockwise },
            ..milling(edge)
        }
    })
}

/// Force on the tool and torque about s of one tooth whose place is `outward` from the axis, in the axes f, n, s: what is
/// in the material is told by how far across the tooth stands, not by an angle.
fn on_tooth(milling: &EndMilling, outward: Vector3<f64>, c: f64) -> (Vector3<f64>, f64) {
    let spindle = match milling.spindle {
        TurnDirection::Clockwise => -Vector3::z(),
        TurnDirection::CounterClockwise => Vector3::z(),
    };
    let motion = spindle.cross(&outward);
    let radius = milling.diameter_mm / 2.0;
    // Chips begin where the tooth moves along the feed at the side: up milling has its material there.
    let beginning = -outward.y * spindle.z * radius;
    let in_material = match milling.direction {
        CutDirection::Up => beginning > radius - milling.width_mm,
        CutDirection::Down => -beginning > radius - milling.width_mm,
    };
    let h = c * outward.x;
    if !in_material || h <= 0.0 {
        return (Vector3::zeros(), 0.0);
    }
    let edge = milling.edge.on_edge(h) * milling.depth_mm;
    let force = -motion * edge.x - outward * edge.y + Vector3::z() * edge.z;
    (force, (radius * outward).cross(&force).z)
}

/// All teeth with the first of them turned by `angle`.
fn at(milling: &EndMilling, angle: f64, c: f64) -> (Vector3<f64>, f64) {
    let tooth = |k: u32| {
        let angle = angle + TAU * f64::from(k) / f64::from(milling.teeth);
        on_tooth(milling, Vector3::new(angle.cos(), angle.sin(), 0.0), c)
    };
    let sum = |a: (Vector3<f64>, f64), b: (Vector3<f64>, f64)| (a.0 + b.0, a.1 + b.1);
    (0..milling.teeth).map(tooth).fold((Vector3::zeros(), 0.0), sum)
}

/// Angles within a pitch, between one tooth's entry or exit and the next tooth's: near both ends of each such stretch, and in its middle.
fn between_changes(milling: &EndMilling, c: f64) -> Vec<f64> {
    let one = EndMilling { teeth: 1, ..*milling };
    let cuts = |angle: f64| at(&one, angle, c).0 != Vector3::zeros();
    let steps = 2_000;
    let step = TAU / f64::from(steps);
    let pitch = TAU / f64::from(milling.teeth);
    let change = |k: u32| {
        let (mut low, mut high) = (step * f64::from(k), step * f64::from(k + 1));
        let before = cuts(low);
        (before != cuts(high)).then(|| {
            for _ in 0..60 {
                let middle = f64::midpoint(low, high);
                if cuts(middle) == before { low = middle } else { high = middle }
            }
            low.rem_euclid(pitch)
        })
    };
    let mut changes: Vec<f64> = (0..steps).filter_map(change).chain([0.0, pitch]).collect();
    changes.sort_by(f64::total_cmp);
    let within = |pair: &[f64]| [1e-9, 0.5, 1.0 - 1e-9].map(|share| pair[0] + share * (pair[1] - pair[0]));
    changes.windows(2).flat_map(within).collect()
}

/// Mean over a turn of one tooth, times the number of teeth.
fn averaged(milling: &EndMilling, c: f64) -> (Vector3<f64>, f64) {
    let one = EndMilling { teeth: 1, ..*milling };
    let steps = 40_000;
    let angles = (0..steps).map(|k| TAU * (f64::from(k) + 0.5) / f64::from(steps));
    let (force, torque) = angles.fold((Vector3::zeros(), 0.0), |(force, torque), angle| {
        let (more, turning) = at(&one, angle, c);
        (force + more, torque + turning)
    });
    let share = f64::from(milling.teeth) / f64::from(steps);
    (force * share, torque * share)
}

/// A tooth enters 1e-7 rad before the one in front of it leaves: no even step hits the instant at which both cut, and there the force is largest.
#[test]
fn the_peak_holds_an_instant_at_which_two_teeth_cut() {
    let edge = EdgeLaw::Linear {
        tangential: EdgeForce { cutting: 0.0, edge: 20.0 },
        radial: EdgeForce::default(),
        axial: EdgeForce { cutting: 0.0, edge: -50.0 },
    };
    let arc = |rad: f64| EndMilling { teeth: 3, width_mm: 5.0 * (1.0 - rad.cos()), ..milling(edge) };
    let [both, one] = [1e-7, -1e-7].map(|more| arc(TAU / 3.0 + more));
    let seen = |milling: &EndMilling, angles: Vec<f64>| {
        angles.into_iter().map(|angle| at(milling, angle, 0.1).0.norm()).fold(0.0, f64::max)
    };
    let peak = |milling: &EndMilling| milling.peak(0.1).force_N.norm();
    // Axial forces add up to twice one tooth's, tangential ones do not.
    assert!(peak(&both) > 1.8 * peak(&one), "{} {}", peak(&both), peak(&one));
    for milling in [both, one] {
        assert!((seen(&milling, between_changes(&milling, 0.1)) / peak(&milling) - 1.0).abs() < 1e-6);
    }
    let even = (0..20_000).map(|k| TAU * f64::from(k) / 20_000.0).collect();
    assert!(seen(&both, even) < 0.6 * peak(&both), "what a property saw that looked at even steps alone");
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn the_mean_is_the_average_over_a_turn(milling in any_milling(), c in 0.01..0.3f64) {
        let (closed, (force, torque)) = (milling.mean(c), averaged(&milling, c));
        // A step more or less in the material is the most that the sum is off.
        let most = milling.edge.on_edge(c).norm() * milling.depth_mm * f64::from(milling.teeth) / 20_000.0;
        prop_assert!((closed.force_N - force).norm() < most, "{closed:?} {force}");
        prop_assert!((closed.torque_Nmm - torque).abs() < most * milling.diameter_mm, "{closed:?} {torque}");
    }

    #[test]
    fn the_peak_is_the_largest_force_of_a_turn(milling in any_milling(), c in 0.01..0.3f64) {
        let peak = milling.peak(c);
        let even = (0..20_000).map(|k| TAU * f64::from(k) / 20_000.0);
        // Two teeth may cut together for less than a step.
        let angles = even.chain(between_changes(&milling, c));
        let largest = angles.map(|angle| at(&milling, angle, c).0.norm()).fold(0.0, f64::max);
        let size = peak.force_N.norm();
        prop_assert!(size >= largest * (1.0 - 1e-9), "{size} {largest}");
        prop_assert!(size <= largest * (1.0 + 2e-3), "{size} {largest}");
        prop_assert!(size >= milling.mean(c).force_N.norm() * (1.0 - 1e-12));
    }

    #[test]
    fn up_and_down_milling_are_mirror_images(milling in any_milling(), c in 0.01..0.3f64) {
        // Teeth that go through the mirrored arc: what the tangential force does along the feed and the radial one across it
        // changes sign, the rest does not.
        let of = |direction, tangential: bool| {
            let edge = match milling.edge {
                EdgeLaw::Linear { tangential: t, radial: r, axial } => {
                    let none = EdgeForce::default();
                    let (t, r) = if tangential { (t, none) } else { (none, r) };
                    EdgeLaw::Linear { tangential: t, radial: r, axial }
                }
                EdgeLaw::Kienzle { tangential: t, .. } => EdgeLaw::Linear {
                    tangential: EdgeForce { cutting: if tangential { t.specific_force } else { 0.0 }, edge: 0.0 },
                    radial: EdgeForce { cutting: if tangential { 0.0 } else { t.specific_force }, edge: 0.0 },
                    axial: EdgeForce::default(),
                },
            };
            EndMilling { direction, edge, ..milling }.mean(c).force_N
        };
        for tangential in [true, false] {
            let (up, down) = (of(CutDirection::Up, tangential), of(CutDirection::Down, tangential));
            let sign = if tangential { 1.0 } else { -1.0 };
            let mirrored = Vector3::new(-sign * down.x, sign * down.y, down.z);
            prop_assert!((up - mirrored).norm() < 1e-9 * (1.0 + up.norm()), "{up} {down}");
        }
    }

    #[test]
    fn the_power_is_that_of_removing_the_material(milling in any_milling(), c in 0.01..0.3f64, rev_per_s in 1.0..400.0f64) {
        let EdgeLaw::Linear { tangential, radial, axial } = milling.edge else { return Ok(()) };
        let without_edge = EdgeForce { edge: 0.0, ..tangential };
        let edge = EdgeLaw::Linear { tangential: without_edge, radial, axial };
        let power = EndMilling { edge, ..milling }.mean(c).torque_Nmm.abs() * TAU * rev_per_s;
        let removed = milling.depth_mm * milling.width_mm * c * f64::from(milling.teeth) * rev_per_s;
        prop_assert!((power - tangential.cutting * removed).abs() <= 1e-9 * power);
    }
}

#[test]
fn a_cut_as_wide_as_the_cutter_is_a_slot() {
    let EdgeLaw::Linear { tangential, radial, axial } = LINEAR else { panic!() };
    for spindle in [TurnDirection::Clockwise, TurnDirection::CounterClockwise] {
        for direction in [CutDirection::Up, CutDirection::Down] {
            let wide = EndMilling { width_mm: 10.0, direction, spindle, ..milling(LINEAR) };
            let (depth_mm, teeth) = (wide.depth_mm, wide.teeth);
            let slot = SlotMilling { tangential, radial, axial, depth_mm, teeth, feed_per_tooth_mm: None, spindle };
            assert!((wide.mean(0.08).force_N - slot.mean_force(0.08)).norm() < 1e-11);
            assert!(wide.mean(0.08).torque_Nmm.abs() > 1000.0);
        }
    }
}

#[test]
fn kienzle_without_exponent_is_linear() {
    let kienzle = EdgeLaw::Kienzle {
        tangential: Kienzle { specific_force: 2000.0, exponent: 0.0 },
        tangential_share: 1.0,
        radial_ratio: 0.25,
        axial_ratio: -0.125,
    };
    let linear = EdgeLaw::Linear {
        tangential: EdgeForce { cutting: 2000.0, edge: 0.0 },
        radial: EdgeForce { cutting: 500.0, edge: 0.0 },
        axial: EdgeForce { cutting: -250.0, edge: 0.0 },
    };
    for width_mm in [0.1, 3.0, 10.0] {
        let of = |edge| EndMilling { width_mm, ..milling(edge) }.mean(0.1);
        let (a, b) = (of(kienzle), of(linear));
        assert!((a.force_N - b.force_N).norm() < 1e-9 * b.force_N.norm(), "{width_mm}");
        assert!((a.torque_Nmm - b.torque_Nmm).abs() < 1e-9 * b.torque_Nmm.abs());
    }
}

#[test]
fn a_single_straight_tooth_peaks_where_its_chip_is_thickest() {
    let edge = EdgeLaw::Linear {
        tangential: EdgeForce { cutting: 800.0, edge: 0.0 },
        radial: EdgeForce::default(),
        axial: EdgeForce::default(),
    };
    // Up to the middle of the cutter the chip is thickest at the exit, beyond it at a quarter of a turn.
    for (width_mm, sin) in [(2.5, (PI / 3.0).sin()), (5.0, 1.0), (8.0, 1.0)] {
        let peak = EndMilling { teeth: 1, width_mm, direction: CutDirection::Up, ..milling(edge) }.peak(0.1);
        assert!((peak.force_N.norm() - 800.0 * 0.1 * sin * 5.0).abs() < 1e-9, "{width_mm}: {}", peak.force_N);
        assert!((peak.torque_Nmm - peak.force_N.norm() * 5.0).abs() < 1e-8);
    }
}

#[test]
fn radial_forces_push_the_tool_out_of_the_material() {
    let edge = EdgeLaw::Linear {
        tangential: EdgeForce::default(),
        radial: EdgeForce { cutting: 300.0, edge: 8.0 },
        axial: EdgeForce::default(),
    };
    // Clockwise: up milling has the material to the left of the feed, n, seen from the spindle; down milling to the right.
    let across = |direction, spindle| EndMilling { direction, spindle, ..milling(edge) }.mean(0.1).force_N.y;
    assert!(across(CutDirection::Up, TurnDirection::Clockwise) < 0.0);
    assert!(across(CutDirection::Down, TurnDirection::Clockwise) > 0.0);
    assert!(across(CutDirection::Up, TurnDirection::CounterClockwise) > 0.0);
    assert!(across(CutDirection::Down, TurnDirection::CounterClockwise) < 0.0);
}

fn line(to: Vector3<f64>) -> Toolpath {
    Toolpath::line(Vector3::zeros(), to, Sampling::default()).unwrap().with_feed(900.0).with_spindle(3000.0)
}

/// Load on a tool that points along −z of W, on the way to `to`.
fn load(law: &CuttingLaw, to: Vector3<f64>) -> Load {
    let axes = Matrix3::from_columns(&[Vector3::x(), -Vector3::y(), -Vector3::z()]);
    let path = line(to);
    law.load(&path.points()[1]).unwrap().on_tool(path.points()[1].tangent, &axes)
}

#[test]
fn the_torque_of_a_cut_is_against_the_spindle_and_comes_with_the_force() {
    // Seen from above, from the spindle, clockwise is a turn about −z: the part turns the tool about +z.
    let load = load(&CuttingLaw::EndMilling(milling(LINEAR)), Vector3::new(9.0, 0.0, 0.0));
    let c = 900.0 / 3000.0 / 4.0;
    let mean: CutForce = milling(LINEAR).mean(c);
    assert!(mean.torque_Nmm > 0.0);
    assert!((load.moment_Nmm - Vector3::new(0.0, 0.0, mean.torque_Nmm)).norm() < 1e-12);
    assert!((load.force_N - mean.force_N).norm() < 1e-12, "feed along x, spindle along z: f, n, s are x, y, z");
}

fn drilling(law: DrillingLaw) -> Drilling {
    Drilling { law, diameter_mm: 8.0, feed_per_rev_mm: None, spindle: TurnDirection::Clockwise }
}

#[test]
fn thrust_and_torque_of_a_drill_are_those_of_its_lips() {
    // With m_c = 0: M = k f D²/8 and F = q k f D/2 sin κ; the power is k_c times the volume removed.
    let lip = Kienzle { specific_force: 2000.0, exponent: 0.0 };
    let law = DrillingLaw::Kienzle { lip, point_angle: PI / 1.5, thrust_ratio: 0.5 };
    let (thrust, torque) = drilling(law).thrust_and_torque(0.2);
    assert!((torque - 2000.0 * 0.2 * 64.0 / 8.0).abs() < 1e-9);
    assert!((thrust - 0.5 * 2000.0 * 0.2 * 4.0 * (PI / 3.0).sin()).abs() < 1e-9);
    assert!((torque * TAU - 2000.0 * PI * 16.0 * 0.2).abs() < 1e-9, "a turn removes π D²/4 f");
    // Thinner chips cost more.
    let lip = Kienzle { specific_force: 2000.0, exponent: 0.25 };
    let law = DrillingLaw::Kienzle { lip, point_angle: PI, thrust_ratio: 0.5 };
    let more = drilling(law).thrust_and_torque(0.2).1 / torque;
    assert!((more - 0.1f64.powf(-0.25)).abs() < 1e-12);
}

#[test]
fn a_material_constant_gives_the_makers_formulas() {
    let (thrust, torque) = drilling(DrillingLaw::MaterialConstant(2.41)).thrust_and_torque(0.2);
    assert!((thrust - 570.0 * 2.41 * 8.0 * 0.2f64.powf(0.85)).abs() < 1e-9);
    assert!((torque - 1000.0 * 2.41 * 64.0 * (0.630 + 16.84 * 0.2) / 100.0).abs() < 1e-9);
}

#[test]
fn a_drill_is_loaded_only_on_its_way_into_the_part() {
    let law = CuttingLaw::Drilling(drilling(DrillingLaw::MaterialConstant(2.41)));
    let down = load(&law, Vector3::new(0.0, 0.0, -9.0));
    let (thrust, torque) = drilling(DrillingLaw::MaterialConstant(2.41)).thrust_and_torque(0.3);
    assert!((down.force_N - Vector3::new(0.0, 0.0, thrust)).norm() < 1e-9);
    assert!((down.moment_Nmm - Vector3::new(0.0, 0.0, torque)).norm() < 1e-9);
    for aside in [Vector3::new(0.0, 0.0, 9.0), Vector3::new(9.0, 0.0, 0.0), Vector3::new(2.0, 0.0, -9.0)] {
        let load = load(&law, aside);
        assert_eq!((load.force_N, load.moment_Nmm), (Vector3::zeros(), Vector3::zeros()), "{aside}");
    }
    // Half a degree aside is still a hole.
    assert!(load(&law, Vector3::new(0.08, 0.0, -9.0)).force_N.z > 1.0);
}

#[test]
fn a_missing_feed_names_the_key_of_its_law() {
    let path = Toolpath::line(Vector3::zeros(), -Vector3::z(), Sampling::default()).unwrap();
    let law = CuttingLaw::Drilling(drilling(DrillingLaw::MaterialConstant(1.0)));
    let message = law.load(&path.points()[1]).unwrap_err().to_string();
    assert_eq!(message, "no feed in force on move 1: expected one, or feed_per_rev_mm in the process");
    let given = Drilling { feed_per_rev_mm: Some(0.1), ..drilling(DrillingLaw::MaterialConstant(1.0)) };
    let given = CuttingLaw::Drilling(given).load(&path.points()[1]).unwrap();
    assert!(matches!(given, PathLoad::Drilling(_)));
}

#[test]
fn the_forces_of_the_guides_examples() {
    // docs/your_force.md: a cut with the side of an end mill, and a hole.
    let near = |found: f64, quoted: f64, digit: f64| assert!((found - quoted).abs() < digit, "{found} {quoted}");
    let down = milling(EdgeLaw::Linear {
        tangential: EdgeForce { cutting: 767.01, edge: 27.7 },
        radial: EdgeForce { cutting: 168.8, edge: 26.6 },
        axial: EdgeForce { cutting: -222.0, edge: -0.7 },
    });
    let up = EndMilling { direction: CutDirection::Up, ..down };
    let (mean, peak) = (down.mean(0.075), down.peak(0.075).force_N);
    for (i, quoted) in [90.31, 188.76, -28.83].into_iter().enumerate() {
        near(mean.force_N[i], quoted, 0.006);
    }
    near(mean.torque_Nmm, 919.0, 0.6);
    near(up.mean(0.075).force_N.x, -199.74, 0.006);
    near(up.mean(0.075).force_N.y, 11.88, 0.006);
    for (i, quoted) in [31.14, 429.58, -75.60].into_iter().enumerate() {
        near(peak[i], quoted, 0.006);
    }
    let (thrust, torque) = drilling(DrillingLaw::MaterialConstant(2.41)).thrust_and_torque(0.15);
    near(thrust, 2191.1, 0.06);
    near(torque, 4870.0, 6.0);
    let lip = Kienzle { specific_force: 2500.0, exponent: 0.26 };
    let law = DrillingLaw::Kienzle { lip, point_angle: 118f64.to_radians(), thrust_ratio: 0.5 };
    let (thrust, torque) = drilling(law).thrust_and_torque(0.15);
    near(thrust, 1312.2, 0.06);
    near(torque, 6120.0, 6.0);
}

#[test]
fn the_guide_has_every_material_with_its_numbers() {
    let guide = include_str!("../../docs/your_force.md");
    let all = materials::all().unwrap();
    assert!(all.len() >= 10);
    for material in all {
        let numbers = match material.coefficients {
            materials::Coefficients::Milling { tangential: t, radial: r, axial: a } => {
                [t, r, a].map(|k| format!("{}, {}", k.cutting, k.edge)).join(" | ")
            }
            materials::Coefficients::Kienzle(law) => format!("{} | {}", law.specific_force, law.exponent),
            materials::Coefficients::Drilling(k) => format!("{k}"),
        };
        let row = format!("| `\"{}\"` | {} |", material.name, numbers.replace('-', "−"));
        assert!(guide.contains(&row), "{row}");
        assert!(!material.source.is_empty());
    }
}
