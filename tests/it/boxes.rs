//! Boxes that must not meet: whether they overlap, and how far they are apart.

use std::f64::consts::FRAC_PI_4;

use kinetostat::{Pose, nalgebra::Vector3, process::Extent};

fn cube(centre: [f64; 3], side: f64) -> Extent {
    let half = Vector3::repeat(side / 2.0);
    Extent { min: Vector3::from(centre) - half, max: Vector3::from(centre) + half }
}

fn at(x: f64, y: f64, z: f64, yaw_rad: f64) -> Pose {
    tilted([x, y, z], [0.0, 0.0, yaw_rad])
}

fn tilted(origin: [f64; 3], roll_pitch_yaw: [f64; 3]) -> Pose {
    Pose { translation: origin.into(), ..Pose::from_roll_pitch_yaw(roll_pitch_yaw.into()) }
}

#[test]
fn boxes_that_touch_do_not_overlap() {
    let (part, clamp) = (cube([0.0; 3], 2.0), cube([0.0; 3], 2.0));
    assert!(part.overlaps(&at(1.9, 0.0, 0.0, 0.0), &clamp));
    assert!(!part.overlaps(&at(2.0, 0.0, 0.0, 0.0), &clamp));
    assert!(part.overlaps(&at(0.0, 0.0, 1.9, 0.3), &clamp));
    assert!(!part.overlaps(&at(0.0, 0.0, 2.0, 0.3), &clamp));
}

#[test]
fn a_turned_box_reaches_with_its_corner_and_no_farther() {
    let (part, clamp) = (cube([0.0; 3], 2.0), cube([0.0; 3], 2.0));
    let reach = 1.0 + 2f64.sqrt();
    assert!(part.overlaps(&at(reach - 1e-6, 0.0, 0.0, FRAC_PI_4), &clamp));
    assert!(!part.overlaps(&at(reach + 1e-6, 0.0, 0.0, FRAC_PI_4), &clamp));
    // Corner toward corner: only an axis of the turned box separates them.
    let diagonal = (1.0 + reach) / 2f64.sqrt() / 2f64.sqrt() + 0.1;
    assert!(!part.overlaps(&at(diagonal, diagonal, 0.0, FRAC_PI_4), &clamp));
}

#[test]
fn a_tilted_box_reaches_up_with_its_edge() {
    let (part, clamp) = (cube([0.0; 3], 2.0), cube([0.0; 3], 2.0));
    let reach = 1.0 + 2f64.sqrt();
    assert!(part.overlaps(&tilted([0.0, 0.0, reach - 1e-6], [FRAC_PI_4, 0.0, 0.0]), &clamp));
    assert!(!part.overlaps(&tilted([0.0, 0.0, reach + 1e-6], [FRAC_PI_4, 0.0, 0.0]), &clamp));
    // Edge across edge: only their cross product separates them.
    let lying = Extent { min: Vector3::new(-5.0, -1.0, -1.0), max: Vector3::new(5.0, 1.0, 1.0) };
    let standing = Extent { min: Vector3::new(-1.0, -1.0, -5.0), max: Vector3::new(1.0, 1.0, 5.0) };
    let across = Vector3::new(1.0, -1.0, 0.0).normalize();
    let turned = |gap: f64| tilted((across * gap).into(), [FRAC_PI_4, 0.0, FRAC_PI_4]);
    assert!(lying.overlaps(&turned(8f64.sqrt() - 1e-6), &standing));
    assert!(!lying.overlaps(&turned(8f64.sqrt() + 1e-6), &standing));
}

#[test]
fn the_gap_between_boxes_is_known() {
    let (part, clamp) = (cube([0.0; 3], 2.0), cube([0.0; 3], 2.0));
    assert!((part.gap(&at(5.0, 1.0, 0.0, 0.0), &clamp) - 3.0).abs() < 1e-12);
    assert!((part.gap(&at(1.5, 0.5, 0.0, 0.0), &clamp) + 0.5).abs() < 1e-12);
    // Grown by the gap, they touch.
    assert!(!part.overlaps(&at(5.0, 0.0, 0.0, 0.0), &clamp.expanded(3.0)));
    assert!(part.overlaps(&at(5.0, 0.0, 0.0, 0.0), &clamp.expanded(3.001)));
    // A thin plate in the way is met wherever it is, and one beside the way never.
    let plate = Extent { min: Vector3::new(7.0, -9.0, -9.0), max: Vector3::new(7.001, 9.0, 9.0) };
    let way = part.free_travel(&at(0.0, 0.0, 0.0, 0.0), &Vector3::x(), &plate);
    assert!((way - 6.0).abs() < 1e-8, "{way}");
    assert_eq!(part.free_travel(&at(0.0, 0.0, 0.0, 0.0), &-Vector3::x(), &plate), f64::INFINITY);
    assert_eq!(part.free_travel(&at(0.0, 20.0, 0.0, 0.0), &Vector3::x(), &plate), f64::INFINITY);
    let turned = part.free_travel(&at(0.0, 0.0, 0.0, FRAC_PI_4), &Vector3::x(), &plate);
    assert!((turned - (7.0 - 2f64.sqrt())).abs() < 1e-8, "{turned}");
    // Along a box that is touched the way is free.
    assert_eq!(part.free_travel(&at(0.0, 0.0, 2.0, 0.0), &Vector3::x(), &clamp), f64::INFINITY);
}

#[test]
fn the_extent_of_points_is_the_box_around_them() {
    let points = [Vector3::new(1.0, -2.0, 3.0), Vector3::new(-1.0, 5.0, 3.0)];
    let extent = Extent::around(points.into_iter()).unwrap();
    assert_eq!((extent.min, extent.max), (Vector3::new(-1.0, -2.0, 3.0), Vector3::new(1.0, 5.0, 3.0)));
    assert!(Extent::around(std::iter::empty()).is_none());
}
