//! Machines as they are drawn, tracked by a point and turned by errors.

use kinetostat_engine::{ChainError, Machine, Pose, machine::Unreachable, nalgebra::Vector3, spatial::rotation_exp};

fn machine(name: &str) -> Machine {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/machines");
    Machine::from_file(&folder.join(format!("{name}.toml"))).unwrap()
}

#[test]
fn what_turns_is_told_from_what_does_not() {
    for name in ["orthoglide", "tripteron"] {
        assert!(!Machine::named_or_file(name).unwrap().has_parasitic_rotation, "{name}");
    }
    for (name, turns) in
        [("tricept", true), ("fivebar", true), ("hexapod", false), ("kr270", false), ("linear_delta", false)]
    {
        assert_eq!(machine(name).has_parasitic_rotation, turns, "{name}");
    }
}

#[test]
fn the_tip_of_a_tilting_tool_stands_where_it_is_wanted() {
    let tricept = machine("tricept");
    let home = tricept.home.pose;
    for way in [Vector3::new(40.0, -25.0, 30.0), Vector3::new(-90.0, 60.0, -50.0)] {
        let asked = Pose { translation: home.translation + way, ..home };
        let at = tricept.track(tricept.tool_tip, &asked, &tricept.home).unwrap();
        let tip = at.pose.transform(tricept.tool_tip);
        assert!((tip - asked.transform(tricept.tool_tip)).norm() < 1e-9, "{tip}");
        // Its tool points away from the centre of the guide's universal joint, O.
        let along = -at.pose.rotation.column(2);
        assert!((along - at.pose.translation.normalize()).norm() < 1e-10);
        assert!((at.pose.translation - asked.translation).norm() > 1.0);
    }
}

#[test]
fn a_platform_that_does_not_turn_stands_where_it_is_asked() {
    let orthoglide = Machine::named_or_file("orthoglide").unwrap();
    let asked = orthoglide.pose_at(Vector3::new(30.0, -40.0, 75.0));
    let at = orthoglide.track(orthoglide.tool_tip, &asked, &orthoglide.home).unwrap();
    assert!((at.pose.translation - asked.translation).norm() < 1e-9);
    let turned = Pose { rotation: rotation_exp(Vector3::new(0.0, 0.01, 0.0)) * asked.rotation, ..asked };
    assert!(matches!(orthoglide.check_tracked(&turned, &at), Err(Unreachable::Turned { .. })));
}

#[test]
fn the_orthoglide_at_home_is_drawn_with_its_bars_and_slides() {
    let machine = Machine::named_or_file("orthoglide").unwrap();
    let skeleton = machine.rigid_skeleton(&machine.home);
    assert_eq!(skeleton.tool_tip_mm, [0.0, 0.0, 100.0]);
    let x = &skeleton.chains[0];
    let slide = &x.joints[0];
    assert!(slide.is_drive && slide.slides && slide.limits.is_none());
    assert!((slide.position_mm[0] + 341.0).abs() < 1e-9 && (slide.value + 341.0).abs() < 1e-9);
    assert_eq!(x.joints.len(), 4, "a parallelogram is one joint: {:?}", x.joints);
    // Short link, bar, short link, bar; then the way to P.
    let [parallelogram, to_platform] = x.links.as_slice() else { panic!("{:?}", x.links) };
    let length = |i: usize| (Vector3::from(parallelogram[i + 1]) - Vector3::from(parallelogram[i])).norm();
    for (i, expected) in [80.0, 310.0, 80.0, 310.0].into_iter().enumerate() {
        assert!((length(i) - expected).abs() < 1e-9, "side {i}: {}", length(i));
    }
    assert!((to_platform[0][0] + 31.0).abs() < 1e-9 && to_platform[1][0].abs() < 1e-9);
}

#[test]
fn a_chain_is_turned_about_its_first_drive_within_a_module_too() {
    let machine = machine("hybrid_3ups");
    let error = ChainError::turn_about_drive_axis(&machine.chains[0], 0.1);
    // The legs stand head down.
    assert!((error.base.angular - Vector3::new(0.0, 0.0, -0.1)).norm() < 1e-12, "{error:?}");
}
