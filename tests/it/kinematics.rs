//! Rigid kinematics: the numerical inverse against closed forms, the round trip, assembly modes, unreachable targets and
//! mobility.

use crate::support::cases::cases;
use crate::support::{arm::ARM, engine::*};
use kinetostat::{
    machine::{Machine, Mobility, Unreachable},
    spatial::Pose,
};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

/// The machine file of a catalogue machine with one piece of text replaced.
fn edited(name: &str, from: &str, to: &str) -> Machine {
    let toml = kinetostat::machine::catalogue::find(name).unwrap().toml;
    assert!(toml.contains(from), "{name} has no {from}");
    machine_from(&toml.replacen(from, to, 1))
}

#[test]
fn home_is_found_without_turns_of_the_search() {
    let axis = "name = \"j1\", axis = \"z\"";
    assert!(ARM.contains(axis));
    let machine = machine_from(&ARM.replace(axis, &format!("{axis}, travel_deg = [-170.0, 170.0]")));
    for ((_, drive), rho) in machine.drives().zip(&machine.home.drives) {
        assert!((rho - drive.home).abs() <= std::f64::consts::PI, "{} at {rho}", drive.name);
    }
    let forward = machine.forward_kinematics(&machine.home.drives).unwrap();
    assert!((forward.pose.translation - machine.home.pose.translation).norm() < 1e-9);
}

/// Rotation of the base of Orthoglide chain `i`: columns e_i, e_(i+1), e_i × e_(i+1).
fn orthoglide_base(i: usize) -> Matrix3<f64> {
    let e = |k: usize| Vector3::ith(k % 3, 1.0);
    Matrix3::from_columns(&[e(i), e(i + 1), e(i).cross(&e(i + 1))])
}

/// ρ, q1, q2, q3 of Orthoglide chain `i` with P at `p`, model.md.
fn orthoglide_closed_form(i: usize, p: Vector3<f64>) -> [f64; 4] {
    const LEG_MM: f64 = 310.0;
    let c = orthoglide_base(i).transpose() * p - Vector3::x() * 31.0;
    let q2 = (c.y / LEG_MM).asin();
    let q1 = (-c.z / (LEG_MM * q2.cos())).asin();
    [c.x - LEG_MM * q1.cos() * q2.cos(), q1, q2, -q1]
}

/// ρ, q1, q2, q3 of Tripteron chain `i` with P at `p`, elbow q2 > 0.
fn tripteron_closed_form(i: usize, p: Vector3<f64>) -> [f64; 4] {
    const LINK_MM: f64 = 750.0;
    let (x, y) = (p[(i + 1) % 3], p[(i + 2) % 3]);
    let distance = x.hypot(y);
    let half = (distance / (2.0 * LINK_MM)).acos();
    let q1 = y.atan2(x) - half;
    [p[i], q1, 2.0 * half, -q1 - 2.0 * half]
}

/// Largest error of drives (mm) and passive joints (rad) over a grid of `n`³ positions in `low..high` of the box.
fn worst_errors(
    machine: &Machine,
    n: usize,
    low: f64,
    high: f64,
    closed_form: fn(usize, Vector3<f64>) -> [f64; 4],
) -> [f64; 2] {
    let mut worst = [0.0f64; 2];
    for index in 0..n * n * n {
        let share = [index / (n * n), index / n % n, index % n].map(|k| k as f64 / (n - 1) as f64);
        let p = position_in_box(machine, low, high, share);
        let at = at_position(machine, p);
        for i in 0..3 {
            let [rho, q @ ..] = closed_form(i, p);
            worst[0] = worst[0].max((at.drives[i] - rho).abs());
            for (got, expected) in at.passive[i].iter().zip(q) {
                worst[1] = worst[1].max((got - expected).abs());
            }
        }
    }
    worst
}

#[test]
fn orthoglide_inverse_kinematics_is_the_closed_form() {
    let [drives, passive] = worst_errors(&catalogue_machine("orthoglide"), 11, 0.0, 1.0, orthoglide_closed_form);
    assert!(drives < 1e-9, "drives off by {drives:e} mm");
    assert!(passive < 1e-11, "passive joints off by {passive:e} rad");
}

#[test]
fn tripteron_inverse_kinematics_is_the_closed_form_with_the_elbow_of_home() {
    let [drives, passive] = worst_errors(&catalogue_machine("tripteron"), 9, 0.02, 1.0, tripteron_closed_form);
    assert!(drives < 1e-9, "drives off by {drives:e} mm");
    assert!(passive < 1e-10, "passive joints off by {passive:e} rad");
}

fn share() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(0.0..1.0f64)
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn forward_undoes_inverse_kinematics(s in share()) {
        for (name, low, high) in CATALOGUE {
            let machine = catalogue_machine(name);
            let p = position_in_box(&machine, low, high, s);
            let at = at_position(&machine, p);
            let back = machine.forward_kinematics(&at.drives).map_err(|e| TestCaseError::fail(format!("{name}: {e}")))?;
            let motion = motion_between(&machine.pose_at(p), &back.pose);
            prop_assert!(motion.fixed_rows::<3>(0).amax() < 1e-8, "{name} at {p:?}: round trip off by {motion:?}");
            prop_assert!(motion.fixed_rows::<3>(3).amax() < 1e-10, "{name} at {p:?}: round trip turns by {motion:?}");
        }
    }

    #[test]
    fn inverse_kinematics_does_not_depend_on_where_it_starts(a in share(), b in share()) {
        for (name, low, high) in CATALOGUE {
            let machine = catalogue_machine(name);
            let [a, b] = [a, b].map(|s| position_in_box(&machine, low, high, s));
            let from_home = at_position(&machine, b);
            let from_a = machine.inverse_kinematics_from(&at_position(&machine, a), &machine.pose_at(b));
            let from_a = from_a.map_err(|e| TestCaseError::fail(format!("{name}: {e}")))?;
            for (x, y) in from_home.passive.iter().flatten().zip(from_a.passive.iter().flatten()) {
                prop_assert!((x - y).abs() < 1e-10, "{name}: passive joint at {y}, from home {x}");
            }
        }
    }

    #[test]
    fn far_targets_are_refused_with_the_way_that_is_left(direction in prop::array::uniform3(-1.0..1.0f64), far in 0.302..4.0f64) {
        // From 2 reaches on, each power of ten as often.
        let far = 10f64.powf(far);
        for (name, ..) in CATALOGUE {
            let machine = catalogue_machine(name);
            let direction = Vector3::from(direction);
            prop_assume!(direction.norm() > 0.1);
            let target = machine.pose_at(direction.normalize() * machine.characteristic_length * far);
            match machine.inverse_kinematics(&target) {
                Err(Unreachable::TooFar { short_mm, .. }) => {
                    if far > 50.0 {
                        prop_assert!(short_mm.is_finite() && short_mm > 0.5 * far * machine.characteristic_length, "{name}: {short_mm}");
                        continue;
                    }
                    // So much nearer to home, on the same line, the way is long enough. Its steps are not halved without end.
                    let home = machine.home.pose.translation;
                    let way = target.translation - home;
                    let margin = 1e-2 * machine.characteristic_length + way.norm() / 4096.0;
                    let share = 1.0 - (short_mm + margin) / way.norm();
                    let nearer = machine.inverse_kinematics(&machine.pose_at(home + way * share.max(0.0)));
                    prop_assert!(!matches!(nearer, Err(Unreachable::TooFar { .. })), "{name}, {short_mm}: {nearer:?}");
                }
                Err(Unreachable::BeyondSpan { away_mm, span_mm, .. }) => {
                    prop_assert!(away_mm > span_mm && away_mm > 0.5 * far * machine.characteristic_length, "{away_mm}, {span_mm}");
                }
                // Long rails lead a tripteron a little farther than twice its reach, with the elbows of home. Forward kinematics does not say
                // so: it goes straight, where a leg may be folded.
                Ok(there) if far < 5.0 && name == "tripteron" => {
                    for (i, (drive, passive)) in there.drives.iter().zip(&there.passive).enumerate() {
                        let [rho, q @ ..] = tripteron_closed_form(i, target.translation);
                        prop_assert!((drive - rho).abs() < 1e-6, "leg {i}, {far}: {drive} {rho}");
                        for (got, wanted) in passive.iter().zip(q) {
                            let apart = (got - wanted).sin().hypot(1.0 - (got - wanted).cos());
                            prop_assert!(apart < 1e-8, "leg {i}, {far}: {passive:?} {q:?}");
                        }
                    }
                }
                other => prop_assert!(false, "{name}, {far} reaches away: {other:?}"),
            }
        }
    }
}

#[test]
fn a_target_beyond_the_legs_names_a_chain_and_how_far_before_it_the_way_ends() {
    let machine = catalogue_machine("orthoglide");
    for far in [330.0, 400.0, 700.0, 5000.0] {
        let refused = machine.inverse_kinematics(&machine.pose_at(Vector3::new(far, 0.0, 0.0))).unwrap_err();
        // The y and z legs (310 mm) must bridge the way across.
        let Unreachable::TooFar { chain, short_mm } = &refused else { panic!("{refused}") };
        assert!(chain == "y" || chain == "z", "{refused}");
        assert!((0.0..0.5).contains(&(short_mm - (far - 310.0))), "{refused}");
    }
}

#[test]
fn the_way_left_to_places_beyond_an_arm_grows_with_them_and_what_was_tried_is_said() {
    let arm = machine_from(include_str!("../machines/kr270.toml"));
    let refused = |x: f64| arm.inverse_kinematics(&arm.pose_at(Vector3::new(x, 0.0, 1000.0))).unwrap_err();
    let ends = [2700.0, 2750.0, 2800.0].map(|x| {
        let refused = refused(x);
        let Unreachable::NoWay { straight, tried } = &refused else { panic!("{refused}") };
        assert!(!tried.is_empty(), "{refused}");
        let Unreachable::TooFar { short_mm, .. } = **straight else { panic!("{refused}") };
        x - short_mm
    });
    // All on one line from home, which ends where it ends.
    assert!(ends.iter().all(|end| (end - ends[0]).abs() < 0.5), "{ends:?}");
    // Beyond the length of the arm nothing need be tried.
    let beyond = [5000.0, 9000.0].map(|x| match refused(x) {
        Unreachable::BeyondSpan { away_mm, span_mm, .. } => away_mm - span_mm,
        other => panic!("{other}"),
    });
    assert!(beyond[0] > 0.0 && (beyond[1] - beyond[0] - 4000.0).abs() < 200.0, "{beyond:?}");
}

#[test]
fn a_target_beyond_the_travel_names_the_drive() {
    let machine = edited("orthoglide", "home_mm = -341.0", "home_mm = -341.0, travel_mm = [-400.0, -300.0]");
    let refused = machine.inverse_kinematics(&machine.pose_at(Vector3::new(0.0, 100.0, 0.0))).unwrap_err();
    let rho = 100.0 - 31.0 - 310.0;
    let expected = format!("drive rail of chain y at {rho:.3} mm, travel -400.000 to -300.000 mm");
    assert_eq!(refused.to_string(), expected);
}

#[test]
fn a_target_beyond_a_joint_limit_names_the_joint_in_degrees() {
    let machine =
        edited("orthoglide", r#"name = "q1", axis = "y""#, r#"name = "q1", axis = "y", limits_deg = [-15.0, 15.0]"#);
    let refused = machine.inverse_kinematics(&machine.pose_at(Vector3::new(0.0, 0.0, 100.0))).unwrap_err();
    let q1 = (-100.0f64 / 310.0).asin().to_degrees();
    let expected = format!("joint q1 of chain x at {q1:.3} deg, limits -15.000 to 15.000 deg");
    assert_eq!(refused.to_string(), expected);
}

#[test]
fn limits_hold_at_home_too() {
    let toml = kinetostat::machine::catalogue::find("orthoglide").unwrap().toml;
    let narrow = toml.replace("home_mm = -341.0", "home_mm = -341.0, travel_mm = [0.0, 1.0]");
    let refused = Machine::from_toml(&narrow, "narrow").unwrap_err().to_string();
    assert!(refused.contains("drive rail of chain x at -341.000 mm, travel 0.000 to 1.000 mm"), "{refused}");
}

#[test]
fn the_platform_of_a_translational_machine_cannot_be_commanded_to_turn() {
    for (name, ..) in CATALOGUE {
        let machine = catalogue_machine(name);
        let mut tilted = machine.home.pose;
        tilted.rotate_about(kinetostat::spatial::Axis::X, 0.1);
        // Rotations are not controlled: the position is met, the orientation is the machine's own.
        let at = machine.inverse_kinematics(&tilted).unwrap();
        assert!(motion_between(&machine.home.pose, &at.pose).amax() < 1e-8, "{name}: {:?}", at.pose);
    }
}

#[test]
fn forward_kinematics_refuses_drives_whose_chains_cannot_close() {
    let machine = catalogue_machine("orthoglide");
    let refused = machine.forward_kinematics(&[-1000.0, 1000.0, 1000.0]).unwrap_err();
    assert!(matches!(refused, Unreachable::Closure { gap_mm, .. } if gap_mm.is_finite()), "{refused}");
}

#[test]
fn mobility_of_the_catalogue() {
    let expect = |name: &str, expected: Mobility| {
        let machine = catalogue_machine(name);
        for share in [0.3, 0.55, 0.8] {
            let at = at_position(&machine, position_in_box(&machine, 0.0, 1.0, [share, 0.5, 0.4]));
            assert_eq!(machine.mobility(&at), expected, "{name}");
        }
    };
    expect("orthoglide", Mobility { mechanism: 3, platform: 3, over_constraint: 3, uncontrolled: 0 });
    expect("tripteron", Mobility { mechanism: 3, platform: 3, over_constraint: 3, uncontrolled: 0 });
}

#[test]
fn a_pose_reached_in_one_go_is_exactly_the_commanded_one() {
    let machine = catalogue_machine("orthoglide");
    let target: Pose = machine.pose_at(Vector3::new(126.35, -73.65, 20.0));
    let at = machine.inverse_kinematics(&target).unwrap();
    assert!(motion_between(&target, &at.pose).amax() < 1e-10, "{:?}", at.pose);
}
