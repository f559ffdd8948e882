//! Forces live in the frame of the tool, however the machine holds it.

use std::{path::Path, process::Command};

use kinetostat::{
    machine::{Machine, ToolAxisSource},
    process::{ForceLaw, MillingForce, file::Process},
    simulation::tasks::tasks,
};
use nalgebra::Vector3;
use serde_json::Value;

const KR270: &str = include_str!("../machines/kr270.toml");
const FORCE: MillingForce = MillingForce { radial: 200.0, tangential: 30.0, axial: -25.0, law: ForceLaw::Rotated };

/// The arm with the home orientation `rotation_deg` and more keys of the platform.
fn arm(rotation_deg: &str, platform: &str) -> Machine {
    let text = KR270
        .replace("tool_tip_mm = [90.0, 0.0, 320.0]", &format!("tool_tip_mm = [0.0, 0.0, 320.0]\n{platform}"))
        .replace("rotation_deg = [0.0, 180.0, 0.0]", &format!("rotation_deg = {rotation_deg}"));
    Machine::from_toml(&text, "arm.toml").unwrap()
}

fn program(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_kinetostat")).args(arguments).output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn on_a_tool_that_points_down_a_negative_axial_force_points_up_and_into_the_spindle() {
    let machine = arm("[0.0, 180.0, 0.0]", "");
    let wrench = FORCE.wrench(0.3, &machine.tool_at(&machine.home.pose.rotation));
    assert!((wrench.force.z - 25.0).abs() < 1e-9, "{}", wrench.force);
    let lever = machine.home.pose.rotation * machine.tool_tip;
    assert!((wrench.moment - lever.cross(&wrench.force)).norm() < 1e-9);
}

#[test]
fn on_a_horizontal_spindle_no_radial_force_lies_along_the_tool() {
    // z of P along x of O.
    let machine = arm("[0.0, 90.0, 0.0]", "");
    let tool = machine.tool_at(&machine.home.pose.rotation);
    assert!((tool.rotation.column(2) - Vector3::x()).norm() < 1e-9);
    for phi in [0.0, 0.7, 2.0, 4.5] {
        let force = FORCE.wrench(phi, &tool).force;
        assert!((force.x + 25.0).abs() < 1e-6, "{force}");
        assert!((force.yz().norm() - 200f64.hypot(30.0)).abs() < 1e-6, "{force}");
    }
}

#[test]
fn a_given_axis_holds_and_has_any_length() {
    let machine = arm("[0.0, 180.0, 0.0]", "tool_axis = [0.0, 3.0, 4.0]");
    assert_eq!(machine.tool_axis_source, ToolAxisSource::Given);
    assert!((machine.tool_axes.column(2) - Vector3::new(0.0, 0.6, 0.8)).norm() < 1e-15);
    assert!((machine.tool_axes.transpose() * machine.tool_axes - nalgebra::Matrix3::identity()).norm() < 1e-14);
    let warnings = |axis: &str| {
        let machine = arm("[0.0, 180.0, 0.0]", axis);
        kinetostat::inspect::machine_check::check(&machine).unwrap().warnings.join("\n")
    };
    assert!(warnings("tool_axis = [0.0, 0.0, -1.0]").contains("is its sign wrong?"));
    assert!(!warnings("tool_axis = [0.0, 0.0, 1.0]").contains("is its sign wrong?"));
    let text = KR270.replace("controls =", "tool_axis = [0.0, 0.0, 0.0]\ncontrols =");
    let refused = Machine::from_toml(&text, "arm.toml").unwrap_err().to_string();
    assert!(refused.contains("platform.tool_axis") && refused.contains("must not be zero"), "{refused}");
}

#[test]
fn the_first_two_machines_have_the_frame_they_had() {
    for name in ["orthoglide", "tripteron"] {
        let machine = Machine::named_or_file(name).unwrap();
        let tool = machine.tool_at(&machine.home.pose.rotation);
        assert_eq!(machine.tool_axes, nalgebra::Matrix3::identity(), "{name}");
        assert_eq!(
            MillingForce::KLIMCHIK_GROOVE.wrench(0.7, &tool).force,
            MillingForce::KLIMCHIK_GROOVE.force(0.7),
            "{name}"
        );
    }
}

#[test]
fn forces_of_a_process_follow_the_real_tool() {
    // Feed along y of W; the tool down and along x.
    let process = r#"
        schema = 1
        [force.path_frame]
        radial_force_N = 200.0
        tangential_force_N = 30.0
        axial_force_N = -25.0
        law = "rotated"
    "#;
    let path = kinetostat::toolpath::polyline::Polyline::read("x_mm,y_mm,z_mm\n0,0,0\n0,5,0\n", "path.csv");
    let path = path.unwrap().toolpath().clone().into();
    for (rotation, wanted) in [
        ("[0.0, 180.0, 0.0]", Vector3::new(-200.0, 30.0, 25.0)),
        ("[0.0, 90.0, 0.0]", Vector3::new(-25.0, 30.0, -200.0)),
    ] {
        let machine = arm(rotation, "");
        let process = Process::from_toml(process, "process.toml", Path::new("."), &machine).unwrap();
        let tasks = tasks(&process, &path, "path.csv").unwrap();
        assert!((tasks[0].load.force - wanted).norm() < 1e-6, "{rotation}: {}", tasks[0].load.force);
    }
}

#[test]
fn point_and_check_say_which_way_the_tool_points() {
    let file = "tests/machines/kr270.toml";
    let check = program(&["check", file]);
    assert!(check.contains("tool axis          (0.271, 0, 0.963) of the platform"), "{check}");
    assert!(check.contains("(assumed: from P to the tool tip)"), "{check}");
    assert!(check.contains("15.7° from the nearest axis") && check.contains("platform.tool_axis = [0.0, 0.0, 1.0]"));
    let point = ["point", "--machine", "orthoglide", "--at", "Q0", "--phi", "90", "--force", "215,-10,-25"];
    let text = program(&point);
    assert!(text.contains("tool axis                 (0.000, 0.000, 1.000) in base axes"), "{text}");
    assert!(text.contains("eq. (17) rotated          (10.0, 215.0, -25.0) N"), "{text}");
    let json: Value = serde_json::from_str(&program(&[&point[..], &["--json"]].concat())).unwrap();
    assert_eq!(json["tool_axis"], serde_json::json!([0.0, 0.0, 1.0]));
    assert!((json["force_tool_frame_N"][0].as_f64().unwrap() - 10.0).abs() < 1e-12);
}
