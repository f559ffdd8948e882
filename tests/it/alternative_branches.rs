//! Inverse kinematics where the straight line from home does not lead to the target: other ways, what they may not do, and
//! what is said when none leads there.

use crate::support::engine::*;
use kinetostat::{
    machine::{Machine, Unreachable},
    spatial::Pose,
};
use nalgebra::Vector3;

const KR270: &str = include_str!("../machines/kr270.toml");
const FIVEBAR: &str = include_str!("../machines/fivebar.toml");

/// The target is met, within travel.
fn assert_met(machine: &Machine, position: Vector3<f64>) -> Vec<f64> {
    let target = machine.pose_at(position);
    let at = machine.inverse_kinematics(&target).unwrap_or_else(|e| panic!("{position:?}: {e}"));
    let back = machine.forward_kinematics_from(&at, &at.drives).unwrap();
    assert!(motion_between(&target, &back.pose).amax() < 1e-8, "{position:?}: {:?}", back.pose);
    for ((_, drive), rho) in machine.drives().zip(&at.drives) {
        let (low, high) = drive.travel.unwrap();
        assert!((low..=high).contains(rho), "{} at {}", drive.name, rho.to_degrees());
    }
    at.drives
}

#[test]
fn an_arm_reaches_behind_itself_by_turning_its_first_drive() {
    let machine = machine_from(KR270);
    let drives = assert_met(&machine, Vector3::new(-1600.0, 0.0, 1000.0));
    assert!((drives[0].to_degrees().abs() - 180.0).abs() < 1e-6, "A1 at {} deg", drives[0].to_degrees());
    // The arm itself stands as at home.
    for (d, (rho, home)) in drives.iter().zip(&machine.home.drives).enumerate().filter(|(d, _)| (1..5).contains(d)) {
        assert!((rho - home).abs() < 1e-6, "drive {d} at {rho}, home {home}");
    }
}

#[test]
fn an_arm_reaches_all_around_itself() {
    let machine = machine_from(KR270);
    for degrees in (0..360).step_by(20) {
        let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
        assert_met(&machine, Vector3::new(1600.0 * cos, 1600.0 * sin, 1000.0));
    }
}

#[test]
fn the_way_home_is_found_first_where_the_straight_line_leads_to_the_target() {
    let machine = machine_from(KR270);
    let target = machine.pose_at(Vector3::new(1705.5, -342.81, 885.67));
    let straight = machine.inverse_kinematics_from(&machine.home, &target).unwrap();
    assert_eq!(machine.inverse_kinematics(&target).unwrap(), straight);
}

#[test]
fn a_hinge_beyond_its_travel_is_taken_a_full_turn_back() {
    let wide = machine_from(KR270);
    // A6 turns with A1 where the tool keeps its direction: here it would stand at about 118 deg.
    let position = Vector3::new(-750.0, 1400.0, 1000.0);
    let free = assert_met(&wide, position);
    let a6 = free[5].to_degrees();
    let (low, high) = (a6 - 400.0, a6 - 10.0);
    let narrow = KR270.replace(
        r#"name = "A6", axis = "x", stiffness_Nmm_per_rad = 4.7e8, home_deg = 0.0, travel_deg = [-350.0, 350.0]"#,
        &format!(
            r#"name = "A6", axis = "x", stiffness_Nmm_per_rad = 4.7e8, home_deg = 0.0, travel_deg = [{low}, {high}]"#
        ),
    );
    assert_ne!(narrow, KR270);
    let turned = assert_met(&machine_from(&narrow), position);
    assert!((turned[5].to_degrees() + 360.0 - a6).abs() < 1e-6, "A6 at {}, free at {a6}", turned[5].to_degrees());
}

#[test]
fn what_was_tried_is_named_where_no_way_leads_to_the_target() {
    let machine = machine_from(KR270);
    // Within the length of all links, but beyond upper arm and forearm.
    let beyond = machine.pose_at(Vector3::new(3000.0, 0.0, 200.0));
    let refused = machine.inverse_kinematics(&beyond).unwrap_err();
    assert!(matches!(refused, Unreachable::NoWay { .. }), "{refused:?}");
    let said = refused.to_string();
    assert!(
        said.contains("alternative solution branches tried: the first revolute joint turned towards the position"),
        "{said}"
    );
    let again = machine.inverse_kinematics(&beyond).unwrap_err();
    assert_eq!(again, refused);
    // Beyond the span nothing is tried, and that is said.
    let far = machine.inverse_kinematics(&machine.pose_at(Vector3::new(9000.0, 0.0, 0.0))).unwrap_err().to_string();
    assert!(far.starts_with("chain robot would have to span") && far.contains("and is at most"), "{far}");
}

/// With the tool up before the arm no posture is within travel: which limit stands against which, from the triangle of upper arm and forearm.
#[test]
fn limits_of_all_postures_are_named_where_an_arm_has_none_within_travel() {
    let machine = Machine::named("kr270").unwrap();
    let pose = Pose { rotation: nalgebra::Matrix3::identity(), translation: Vector3::new(1700.0, 0.0, 600.0) };
    let refused = machine.inverse_kinematics(&pose).unwrap_err().to_string();
    // From axis 2 to the wrist centre, mm; angles down from the horizontal, as A2, A3 and A5 count.
    let (ahead, down) = (1700.0 - 350.0, 675.0 - (600.0 - 240.0));
    let (upper, fore, reach) = (1150.0, f64::hypot(1200.0, 41.0), f64::hypot(ahead, down));
    let at_shoulder = ((upper * upper + reach * reach - fore * fore) / (2.0 * upper * reach)).acos();
    let a2 = [-at_shoulder, at_shoulder].map(|bend| f64::atan2(down, ahead) + bend);
    let forearm = f64::atan2(down - upper * a2[0].sin(), ahead - upper * a2[0].cos()) - f64::atan2(41.0, 1200.0);
    let a5 = -90.0 - forearm.to_degrees();
    for words in [
        format!("drive A5 of chain arm at {a5:.3} deg, travel -120.000 to 120.000 deg (front-up-flip)"),
        format!(
            "drive A2 of chain arm at {:.3} deg, travel -195.000 to 40.000 deg (front-down-noflip, front-down-flip)",
            a2[1].to_degrees()
        ),
    ] {
        assert!(refused.contains(&words), "{words}: {refused}");
    }
    assert!(!refused.contains("working or assembly mode"), "{refused}");
}

/// Signs of the turns from crank to coupler of both chains of the five-bar, and from coupler to coupler. They change only at
/// singularities.
fn assembly_mode(position: Vector3<f64>, drives: &[f64]) -> [bool; 3] {
    let crank = |base: f64, rho: f64| Vector3::new(300.0 * rho.cos(), 300.0 * rho.sin(), 0.0) + Vector3::x() * base;
    let (left, right) = (crank(-100.0, drives[0]), crank(100.0, drives[1]));
    let (to_left, to_right) = (position - left, position - right);
    let turn = |a: Vector3<f64>, b: Vector3<f64>| a.cross(&b).z > 0.0;
    [turn(left + Vector3::x() * 100.0, to_left), turn(right - Vector3::x() * 100.0, to_right), turn(to_left, to_right)]
}

#[test]
fn a_parallel_machine_is_led_around_what_is_in_the_way_but_never_to_another_assembly_mode() {
    let machine = machine_from(FIVEBAR);
    let home = assembly_mode(machine.home.pose.translation, &machine.home.drives);
    // The straight line down leads between the drives, where the chains do not close.
    let below = Vector3::new(0.0, -450.0, 0.0);
    assert!(machine.inverse_kinematics_from(&machine.home, &machine.pose_at(below)).is_err());
    let at = machine.inverse_kinematics_at(below).unwrap();
    assert_eq!(assembly_mode(below, &at.drives), home);
    // Here the cranks that home has would have to cross the couplers.
    let refused = machine.inverse_kinematics_at(Vector3::new(0.0, -60.0, 0.0)).unwrap_err().to_string();
    assert!(refused.contains("only on another working or assembly mode"), "{refused}");
    assert!(refused.contains("alternative solution branches tried: detours"), "{refused}");
}

#[test]
fn a_path_does_not_lead_through_a_leg_folded_onto_its_base() {
    let machine = machine_from(include_str!("../machines/rrr3.toml"));
    let at = |x: f64| machine.pose_at(Vector3::new(x, 0.0, 0.0));
    let mut near = machine.inverse_kinematics(&at(200.0)).unwrap();
    let mut farthest: f64 = 200.0;
    for x in 201..=290 {
        if let Ok(reached) = machine.inverse_kinematics_from(&near, &at(f64::from(x))) {
            (near, farthest) = (reached, f64::from(x));
        }
    }
    // The leg is folded at 260; from home nothing beyond is reached either.
    assert!((255.0..=260.0).contains(&farthest), "{farthest}");
    assert!(machine.inverse_kinematics(&at(270.0)).is_err());
}

#[test]
fn what_the_drives_reach_is_never_called_beyond_the_span_of_a_chain() {
    for name in kinetostat::machine::catalogue::names() {
        let machine = Machine::named(name).unwrap();
        let travels: Vec<(f64, f64)> = machine.drives().filter_map(|(_, drive)| drive.travel).collect();
        if travels.len() < machine.drive_count() {
            continue;
        }
        let mut reached = 0;
        for share in [-0.4, -0.1, -0.01, 0.01, 0.1, 0.4] {
            for moved in 0..machine.drive_count() {
                let mut drives = machine.home.drives.clone();
                drives[moved] += share * (travels[moved].1 - travels[moved].0);
                let Ok(at) = machine.forward_kinematics(&drives) else { continue };
                reached += 1;
                let again = machine.inverse_kinematics_from(&at, &at.pose);
                assert!(!matches!(again, Err(Unreachable::BeyondSpan { .. })), "{name} at {drives:?}: {again:?}");
            }
        }
        assert!(reached > 0, "{name}");
    }
}
