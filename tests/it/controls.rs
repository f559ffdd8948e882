//! What a machine can be asked for: coordinates that its drives do not control are refused with the difference, controls
//! that they cannot have are named, and places outside its workspace box are said to be.

use crate::support::engine::*;
use kinetostat::machine::{Machine, Unreachable};
use nalgebra::Vector3;

const FIVEBAR: &str = include_str!("../machines/fivebar.toml");
const RRR3: &str = include_str!("../machines/rrr3.toml");

#[test]
fn a_planar_machine_refuses_another_height_and_names_it() {
    let machine = machine_from(FIVEBAR);
    machine.inverse_kinematics_at(Vector3::new(20.0, 440.0, 0.0)).unwrap();
    let refused = machine.inverse_kinematics_at(Vector3::new(20.0, 440.0, 50.0)).unwrap_err();
    assert!(matches!(refused, Unreachable::Uncontrolled { .. }), "{refused:?}");
    let expected = "z: asked 50 mm, the machine stays at 0 mm: difference 50 mm; the machine controls x, y";
    assert_eq!(refused.to_string(), expected);
    let found = machine.uncontrolled_difference(Vector3::new(0.0, 450.0, -3.0), machine.home.pose.translation).unwrap();
    assert_eq!((found.axis, found.asked, found.stands), (2, -3.0, 0.0));
    assert_eq!(machine.controllable_position(Vector3::new(1.0, 2.0, 3.0)), Vector3::new(1.0, 2.0, 0.0));
}

#[test]
fn heights_of_a_machine_that_turns_in_its_plane_are_refused_too_and_controlled_ones_never() {
    let machine = machine_from(RRR3);
    assert!(machine.inverse_kinematics_at(Vector3::new(10.0, 20.0, 0.0)).is_ok());
    let refused = machine.inverse_kinematics_at(Vector3::new(10.0, 20.0, -0.5)).unwrap_err().to_string();
    assert!(refused.contains("z: asked -0.5 mm") && refused.contains("machine controls x, y, rotation_z"), "{refused}");
    let orthoglide = catalogue_machine("orthoglide");
    assert_eq!(orthoglide.uncontrolled_difference(Vector3::new(1.0, 2.0, 3.0), Vector3::zeros()), None);
}

#[test]
fn a_place_outside_the_workspace_box_is_said_with_its_coordinate() {
    let machine: Machine = catalogue_machine("orthoglide");
    assert_eq!(machine.outside_workspace(Vector3::new(126.35, -73.65, 0.0)), None, "corners are inside");
    let outside = machine.outside_workspace(Vector3::new(130.0, -90.0, 0.0)).unwrap();
    assert_eq!(outside.axis, 1);
    assert_eq!(outside.to_string(), "y = -90 mm is outside the machine's workspace box, -73.65 to 126.35 mm");
}

/// What `check` says of the machine.
fn warnings(machine: &Machine) -> String {
    kinetostat::inspect::machine_check::check(machine).unwrap().warnings.join("\n")
}

fn orthoglide_with(controls: &str) -> Machine {
    let toml = kinetostat::machine::catalogue::find("orthoglide").unwrap().toml;
    let changed = toml.replace(r#"controls = ["x", "y", "z"]"#, controls);
    assert_ne!(changed, toml);
    machine_from(&changed)
}

#[test]
fn controls_that_the_drives_cannot_have_are_named_with_those_they_can() {
    let rotations = warnings(&orthoglide_with(r#"controls = ["rotation_x", "rotation_y", "rotation_z"]"#));
    let expected =
        "platform.controls: of rotation_x, rotation_y, rotation_z the drives can control only 0 independently";
    assert!(rotations.contains(expected) && rotations.contains("they control x, y, z"), "{rotations}");
    let two = warnings(&orthoglide_with(r#"controls = ["x", "y"]"#));
    assert!(two.contains("platform.controls: z could be controlled, too"), "{two}");
    for machine in [catalogue_machine("orthoglide"), machine_from(FIVEBAR), machine_from(RRR3)] {
        let said = warnings(&machine);
        assert!(!said.contains("platform.controls"), "{said}");
    }
    assert_eq!(machine_from(RRR3).controllable_axes(&machine_from(RRR3).home).len(), 3);
}

#[test]
fn a_translation_left_free_is_refused_where_it_is_asked_for_elsewhere_than_it_goes() {
    let machine = orthoglide_with(r#"controls = ["x", "y"]"#);
    assert_eq!(machine.redundancy, 1);
    let refused = machine.inverse_kinematics_at(Vector3::new(30.0, 20.0, 50.0)).unwrap_err().to_string();
    assert!(
        refused.starts_with("z: asked 50 mm, the machine stays at ") && refused.ends_with("machine controls x, y"),
        "{refused}"
    );
}

#[test]
fn drives_without_travel_are_named() {
    let said = warnings(&catalogue_machine("orthoglide"));
    assert!(said.contains("drives x, y, z: no travel is given"), "{said}");
    let kr270 = machine_from(include_str!("../machines/kr270.toml"));
    assert!(!warnings(&kr270).contains("travel"), "{}", warnings(&kr270));
}

#[test]
fn the_reach_is_that_of_the_assembled_machine() {
    // The same machine, whose home is sought from far away and from where it is found.
    let rough = machine_from(FIVEBAR);
    let [left, right] = [rough.home.drives[0], rough.home.drives[1]].map(f64::to_degrees);
    let [knee, other, tip] =
        [rough.home.passive[0][0], rough.home.passive[1][0], rough.home.passive[1][1]].map(f64::to_degrees);
    let exact = FIVEBAR
        .replace("home_deg = 130.0", &format!("home_deg = {left:?}"))
        .replace("home_deg = 50.0", &format!("home_deg = {right:?}"))
        .replace("home_deg = -80.0", &format!("home_deg = {knee:?}"))
        .replace("home_deg = 80.0", &format!("home_deg = {other:?}"))
        .replace("home_deg = -100.0", &format!("home_deg = {tip:?}"));
    let exact = machine_from(&exact);
    assert!(
        (exact.characteristic_length - rough.characteristic_length).abs() < 1e-9,
        "{} {}",
        exact.characteristic_length,
        rough.characteristic_length
    );
    // From P to the farthest revolute joint: a motor, 100 mm aside.
    assert!((rough.characteristic_length - 100f64.hypot(450.0)).abs() < 1e-6, "{}", rough.characteristic_length);
}

/// What a command prints, and its exit code.
fn kinetostat(arguments: &[&str]) -> (Option<i32>, String) {
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).output().unwrap();
    let text = [run.stdout, run.stderr].concat();
    (run.status.code(), String::from_utf8(text).unwrap())
}

#[test]
fn the_first_screen_says_what_may_not_be_meant() {
    let fivebar = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/machines/fivebar.toml");
    let (code, text) = kinetostat(&["point", "--machine", fivebar, "--position", "20,440,50"]);
    assert!(code == Some(1) && text.contains("z: asked 50 mm, the machine stays at 0 mm"), "{text}");
    let (code, text) = kinetostat(&["point", "-m", "orthoglide", "--position", "0,0,-90", "--chain-errors", "12,0,0"]);
    assert!(code == Some(0) && text.contains("outside the workspace     z = -90 mm is outside"), "{text}");
    assert!(text.contains("large error               Chain x is turned by 12.0\u{b0}"), "{text}");
    let (code, text) = kinetostat(&["point", "-m", "orthoglide", "--at", "Q0", "--chain-errors", "45,0,0"]);
    assert!(code == Some(2) && text.contains("--chain-errors: must be at most 30 deg either way"), "{text}");
    let (_, text) = kinetostat(&["point", "-m", "orthoglide", "--at", "Q0", "--chain-errors", "1,-1,1"]);
    assert!(!text.contains("outside the workspace") && !text.contains("large error"), "{text}");
}

#[test]
fn check_says_that_a_machine_is_redundant_and_how_its_freedom_is_used() {
    let rail = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/machines/kr270_rail.toml");
    let (code, text) = kinetostat(&["check", rail]);
    assert_eq!(code, Some(0), "{text}");
    let expected = "redundant          by 1: 7 drives for 6 controlled coordinates; the drives stand as near to home";
    assert!(text.contains(expected), "{text}");
    let (_, text) = kinetostat(&["check", "orthoglide"]);
    assert!(!text.contains("redundant"), "{text}");
}
