//! Axes that turn the tool or the workpiece: where its tip is.

use kinetostat_programs::gcode::{Rotary, RotaryAxis, RotarySide};
use nalgebra::Vector3;
use proptest::prelude::*;

fn axis(letter: char, about: Vector3<f64>, turns: RotarySide, through: Vector3<f64>) -> RotaryAxis {
    RotaryAxis { letter, about, turns, through_mm: Some(through), travel_deg: None }
}

#[test]
fn a_head_swings_its_tool_about_its_pivot_and_a_table_its_part() {
    let pivot = Vector3::new(0.0, 0.0, 150.0);
    let head = Rotary { axes: vec![axis('B', Vector3::y(), RotarySide::Tool, pivot)], always_of_tip: false };
    let angles = [0.0, 30.0, 0.0];
    let (sin, cos) = 30f64.to_radians().sin_cos();
    assert!((head.tool_axis(&angles) - Vector3::new(sin, 0.0, cos)).norm() < 1e-15);
    let tip = head.tip_position(Vector3::new(1.0, 2.0, 3.0), &angles);
    assert!((tip - Vector3::new(1.0 - 150.0 * sin, 2.0, 3.0 + 150.0 * (1.0 - cos))).norm() < 1e-12);
    // A table under the part: the part leans one way, the tool the other way seen from it.
    let centre = Vector3::new(0.0, 0.0, -50.0);
    let table = Rotary { axes: vec![axis('A', Vector3::x(), RotarySide::Workpiece, centre)], always_of_tip: false };
    let angles = [90.0, 0.0, 0.0];
    assert!((table.tool_axis(&angles) - Vector3::y()).norm() < 1e-15);
    assert!(
        (table.tip_position(centre + Vector3::new(4.0, 0.0, 7.0), &angles) - centre - Vector3::new(4.0, 7.0, 0.0))
            .norm()
            < 1e-12
    );
}

proptest! {
    #![proptest_config(crate::support::cases::cases(128))]

    #[test]
    fn where_the_head_is_for_a_tip_brings_the_tip_there(
        a in -120.0..120.0f64, c in -360.0..360.0f64, x in -99.0..99.0f64, y in -99.0..99.0f64, is_table: bool,
    ) {
        let turns = if is_table { RotarySide::Workpiece } else { RotarySide::Tool };
        let axes = vec![
            axis('A', Vector3::x(), RotarySide::Workpiece, Vector3::new(0.0, 3.0, -20.0)),
            axis('C', Vector3::z(), turns, Vector3::new(5.0, -2.0, 0.0)),
        ];
        let rotary = Rotary { axes, always_of_tip: false };
        let (tip, angles) = (Vector3::new(x, y, 7.0), [a, 0.0, c]);
        prop_assert!((rotary.tip_position(rotary.head_position(tip, &angles), &angles) - tip).norm() < 1e-10);
    }
}
