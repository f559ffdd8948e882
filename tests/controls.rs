//! What a machine can be asked for: coordinates that its drives do not control are refused with the difference, controls
//! that they cannot have are named, and places outside its workspace box are said to be.

mod support;

use kinetostat::machine::{Machine, Unreachable};
use nalgebra::Vector3;
use support::engine::*;

const FIVEBAR: &str = include_str!("machines/fivebar.toml");
const RRR3: &str = include_str!("machines/rrr3.toml");

#[test]
fn a_planar_machine_refuses_another_height_and_names_it() {
    let machine = machine_from(FIVEBAR);
    machine.command(Vector3::new(20.0, 440.0, 0.0)).unwrap();
    let refused = machine.command(Vector3::new(20.0, 440.0, 50.0)).unwrap_err();
    assert!(matches!(refused, Unreachable::Uncontrolled { .. }), "{refused:?}");
    let expected = "z: asked 50 mm, the machine stays at 0 mm: difference 50 mm; it controls x, y";
    assert_eq!(refused.to_string(), expected);
    let found = machine.uncontrolled_difference(Vector3::new(0.0, 450.0, -3.0), machine.home.pose.translation).unwrap();
    assert_eq!((found.axis, found.asked, found.stands), (2, -3.0, 0.0));
    assert_eq!(machine.as_controlled(Vector3::new(1.0, 2.0, 3.0)), Vector3::new(1.0, 2.0, 0.0));
}

#[test]
fn heights_of_a_machine_that_turns_in_its_plane_are_refused_too_and_controlled_ones_never() {
    let machine = machine_from(RRR3);
    assert!(machine.command(Vector3::new(10.0, 20.0, 0.0)).is_ok());
    let refused = machine.command(Vector3::new(10.0, 20.0, -0.5)).unwrap_err().to_string();
    assert!(refused.contains("z: asked -0.5 mm") && refused.contains("it controls x, y, rotation_z"), "{refused}");
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
