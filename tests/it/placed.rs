//! Where the platform stands for a point of a placed workpiece, and the wrench on it.

use std::f64::consts::FRAC_PI_2;

use kinetostat::{
    MillingForce, Pose,
    nalgebra::{Matrix3, Vector3},
    process::{PathReference, Placement},
    toolpath::Load,
};

const TIP: Vector3<f64> = Vector3::new(3.0, -2.0, 100.0);

fn placement(reference: PathReference) -> Placement {
    Placement {
        origin_mm: Vector3::new(10.0, 20.0, 30.0),
        roll_pitch_yaw: Vector3::new(0.0, 0.0, FRAC_PI_2),
        reference,
    }
}

#[test]
fn the_tool_tip_stands_on_the_path_and_the_platform_a_tool_away() {
    let at = Vector3::new(1.0, 2.0, 3.0);
    // x of W is y of O, y of W is −x of O.
    let wanted = Vector3::new(10.0 - 2.0, 20.0 + 1.0, 30.0 + 3.0);
    let orientation = Pose::from_roll_pitch_yaw(Vector3::new(0.2, -0.1, 0.5)).rotation;
    let pose =
        placement(PathReference::ToolTip).on_machine(&orientation, &Pose::from_translation(TIP)).platform_pose(at);
    assert!((pose.transform(TIP) - wanted).norm() < 1e-12);
    let pose = placement(PathReference::PlatformPoint)
        .on_machine(&orientation, &Pose::from_translation(TIP))
        .platform_pose(at);
    assert!((pose.translation - wanted).norm() < 1e-12);
    assert_eq!(pose.rotation, orientation);
}

#[test]
fn the_platform_tilts_with_the_workpiece_and_does_not_follow_its_yaw() {
    let home = Pose::from_roll_pitch_yaw(Vector3::new(0.0, 0.0, 0.5)).rotation;
    for (roll, pitch, yaw) in [(0.0, 0.0, 1.1), (0.3, 0.0, 0.0), (0.3, -0.2, 0.0), (-0.1, 0.4, 2.0)] {
        let placement = Placement { roll_pitch_yaw: Vector3::new(roll, pitch, yaw), ..Placement::default() };
        let orientation = placement.platform_orientation(&home);
        // The axis of the tool is z of P and z of W.
        assert!((orientation.column(2) - placement.pose().rotation.column(2)).norm() < 1e-12);
        if (roll, pitch) == (0.0, 0.0) {
            assert_eq!(orientation, home);
        }
        if yaw == 0.0 {
            assert!((orientation - placement.pose().rotation * home).norm() < 1e-12);
        }
    }
}

#[test]
fn where_the_platform_is_turned_its_point_stands_on_the_path_too() {
    let orientation = Pose::from_roll_pitch_yaw(Vector3::new(0.2, -0.1, 0.5)).rotation;
    for reference in [PathReference::ToolTip, PathReference::PlatformPoint] {
        for roll_pitch_yaw in [Vector3::new(0.0, 0.0, FRAC_PI_2), Vector3::new(0.2, 0.3, -0.4)] {
            let placement = Placement { roll_pitch_yaw, ..placement(reference) };
            let at = Vector3::new(-7.0, 0.25, 12.0);
            let turned = Pose::from_roll_pitch_yaw(Vector3::new(-0.3, 0.1, 0.7)).rotation * orientation;
            let placed =
                placement.on_machine(&orientation, &Pose::from_translation(TIP)).with_platform_rotation(&turned);
            let pose = placed.platform_pose(at);
            assert_eq!(pose.rotation, turned);
            let stands = pose.transform(placed.reference());
            assert!((placement.pose().inverse().transform(stands) - at).norm() < 1e-12);
            assert!((placement.pose().rotation * placed.tool_axes().column(2) - turned.column(2)).norm() < 1e-12);
        }
    }
}

#[test]
fn the_wrench_is_that_of_eq_16_and_turns_with_the_workpiece() {
    let (force, tool) = (MillingForce::KLIMCHIK_GROOVE, Pose::from_translation(Vector3::new(0.0, 0.0, 100.0)));
    let load = Load { force_N: force.force(0.7), moment_Nmm: Vector3::zeros() };
    let unturned = Placement::default().on_machine(&Matrix3::identity(), &tool).wrench(&load);
    assert!((unturned.to_vector() - force.wrench(0.7, &tool).to_vector()).norm() < 1e-12);
    let load = Load { moment_Nmm: Vector3::new(5.0, 6.0, 7.0), ..load };
    let turned = placement(PathReference::ToolTip).on_machine(&Matrix3::identity(), &tool).wrench(&load);
    let f = Vector3::new(-load.force_N.y, load.force_N.x, load.force_N.z);
    assert!((turned.force - f).norm() < 1e-12);
    let moment = Vector3::new(-6.0 - 100.0 * f.y, 5.0 + 100.0 * f.x, 7.0);
    assert!((turned.moment - moment).norm() < 1e-11);
}
