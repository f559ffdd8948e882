//! The mean force of a slot, from what each tooth receives.

use std::f64::consts::PI;

use kinetostat::{
    nalgebra::Vector3,
    process::cutting::{CuttingLaw, EdgeForce, SlotMilling},
    spatial::frame_about,
    toolpath::{PathPoint, Sampling, Toolpath, TurnDirection},
};

fn milling(spindle: TurnDirection) -> SlotMilling {
    SlotMilling {
        tangential: EdgeForce { cutting: 796.0, edge: 28.0 },
        radial: EdgeForce { cutting: 169.0, edge: 31.0 },
        axial: EdgeForce { cutting: -222.0, edge: -1.5 },
        depth_mm: 1.5,
        teeth: 4,
        feed_per_tooth_mm: None,
        spindle,
    }
}

fn path() -> Toolpath {
    let (start, end) = (Vector3::zeros(), Vector3::new(0.0, 3.0, 0.0));
    Toolpath::line(start, end, Sampling::default()).unwrap()
}

/// Force (f, n, z) on the tool averaged over a turn from what each tooth receives where it stands: nothing of the
/// closed form but the chip thickness, which is the feed of a tooth along the radius.
fn averaged(milling: &SlotMilling, c: f64) -> Vector3<f64> {
    let steps = 200_000;
    // About +z a clockwise spindle turns by a negative angle.
    let sense = if milling.spindle == TurnDirection::Clockwise { -1.0 } else { 1.0 };
    let mut sum = Vector3::zeros();
    for step in 0..steps {
        let angle = 2.0 * PI * (f64::from(step) + 0.5) / f64::from(steps);
        let outward = Vector3::new(angle.cos(), angle.sin(), 0.0);
        let motion = Vector3::z().cross(&outward) * sense;
        let h = c * outward.x;
        if h > 0.0 {
            let on_edge = |k: EdgeForce| (k.cutting * h + k.edge) * milling.depth_mm;
            sum += -motion * on_edge(milling.tangential) - outward * on_edge(milling.radial)
                + Vector3::z() * on_edge(milling.axial);
        }
    }
    sum * f64::from(milling.teeth) / f64::from(steps)
}

#[test]
fn the_mean_force_is_the_average_over_a_turn_either_way_round() {
    for spindle in [TurnDirection::Clockwise, TurnDirection::CounterClockwise] {
        for c in [0.02, 0.1] {
            let milling = milling(spindle);
            let (closed, averaged) = (milling.mean_force(c), averaged(&milling, c));
            assert!((closed - averaged).norm() < 1e-8 * closed.norm(), "{closed} {averaged}");
        }
    }
}

#[test]
fn a_clockwise_spindle_is_pushed_left_and_back() {
    let path = path().with_feed(600.0).with_spindle(3000.0);
    let mut left = 0.0;
    for (spindle, side) in [(TurnDirection::Clockwise, -1.0), (TurnDirection::CounterClockwise, 1.0)] {
        // Tool along −z; along +y, left is −x. 600 mm/min, 3000 rev/min and 4 teeth are 0.05 mm per tooth.
        let force = force(&milling(spindle), &path.points()[1], -Vector3::z());
        assert!(force.x * side > 0.0 && force.y < 0.0 && force.z < 0.0);
        assert!((force.y + 6.0 * (169.0 * 0.05 / 4.0 + 31.0 / PI)).abs() < 1e-12);
        left += force.x;
    }
    assert!(left.abs() < 1e-12);
}

/// Force in W on a tool along `axis`, N.
fn force(milling: &SlotMilling, point: &PathPoint, axis: Vector3<f64>) -> Vector3<f64> {
    let load = CuttingLaw::SlotMilling(*milling).load(point).unwrap();
    load.on_tool(point.tangent, &frame_about(axis)).force_N
}

#[test]
fn from_below_the_workpiece_side_and_axial_forces_are_mirrored() {
    let path = path().with_feed(600.0).with_spindle(3000.0);
    let milling = milling(TurnDirection::Clockwise);
    let above = force(&milling, &path.points()[1], -Vector3::z());
    let below = force(&milling, &path.points()[1], Vector3::z());
    assert_eq!(below, Vector3::new(-above.x, above.y, -above.z));
}

#[test]
fn a_given_feed_per_tooth_holds_everywhere() {
    let milling = SlotMilling { feed_per_tooth_mm: Some(0.05), ..milling(TurnDirection::Clockwise) };
    let with_speeds = path().with_feed(900.0).with_spindle(1000.0);
    assert_eq!(milling.feed_per_tooth(&path().points()[1]), Ok(0.05));
    assert_eq!(milling.feed_per_tooth(&with_speeds.points()[1]), Ok(0.05));
}

#[test]
fn missing_feed_and_spindle_speed_are_named() {
    let message =
        |path: Toolpath| milling(TurnDirection::Clockwise).feed_per_tooth(&path.points()[1]).unwrap_err().to_string();
    assert_eq!(
        message(path().with_spindle(3000.0)),
        "no feed in force on move 1: expected one, or feed_per_tooth_mm in the process"
    );
    assert_eq!(
        message(path().with_feed(600.0)),
        "spindle speed not given on move 1: expected one above 0, or feed_per_tooth_mm in the process"
    );
    assert_eq!(
        message(path().with_feed(600.0).with_spindle(0.0)),
        "spindle speed 0 rev/min on move 1: expected one above 0, or feed_per_tooth_mm in the process"
    );
}
