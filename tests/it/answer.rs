//! What answers are made of: the deflected machine for its drawing, and points in words.

use kinetostat::{
    Machine, MillingForce, Target, TaskPoint,
    answer::{deflected_pose::deflected_pose, point_text::named_point_text},
};
use nalgebra::Vector3;

#[test]
fn the_lines_of_a_loaded_machine_end_where_its_platform_settles() {
    let machine = Machine::named_or_file("orthoglide").unwrap();
    let errors = machine.assembly_errors(&[1.0, -1.0, 1.0]);
    let load = MillingForce::KLIMCHIK_GROOVE.wrench(0.7, &machine.tool());
    let pose = machine.pose_at(machine.points[1].position);
    let deflected =
        deflected_pose(&machine, &errors, &TaskPoint::new(pose, load, Target::ToolTip), "at Q1".into()).unwrap();
    for skeleton in [&deflected.commanded, &deflected.loaded] {
        for chain in &skeleton.chains {
            let end = Vector3::from(*chain.links.last().unwrap().last().unwrap());
            assert!((end - Vector3::from(skeleton.platform_mm)).norm() < 1e-6, "{}: {end}", chain.name);
        }
    }
    let moved = Vector3::from(deflected.loaded.tool_tip_mm) - Vector3::from(deflected.commanded.tool_tip_mm);
    assert!((moved - deflected.tool_displacement_mm).norm() < 1e-9);
    assert!(moved.norm() > 0.5);
}

#[test]
fn points_are_told_by_where_they_lie_in_the_box() {
    let machine = Machine::named_or_file("orthoglide").unwrap();
    let words: Vec<String> = machine.points.iter().map(|p| named_point_text(&machine, p)).collect();
    assert!(words[0].starts_with("Q0: a point within the workspace box"), "{}", words[0]);
    assert!(words[1].starts_with("Q1: the corner of the workspace box at the largest x, y, z"), "{}", words[1]);
    assert!(words[3].contains("at the largest x, y and the smallest z"), "{}", words[3]);
}
