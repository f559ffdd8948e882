//! Engagement of slots, shoulders, circles, corners and passes against closed forms.

use std::f64::consts::{FRAC_PI_2, PI};

use kinetostat_removal::{Cutter, Engagement, Field, Milling, Slice, Slicing, Spindle, Stock};
use nalgebra::{Vector2, Vector3};

use crate::paths::{Placed, block, circle, cut_only, cut_path};

const CELL: f64 = 0.2;

fn placements() -> impl Iterator<Item = Placed> {
    let turns = [0.0, FRAC_PI_2, 0.3, 1.234, 2.9, -0.01];
    let shifts = [Vector2::new(0.0, 0.0), Vector2::new(0.07, 0.113), Vector2::new(0.1, -0.031)];
    turns.into_iter().flat_map(move |turn| shifts.map(|shift| Placed { turn, shift }))
}

fn flat() -> Cutter {
    Cutter::flat(10.0).unwrap()
}

/// The only arc of each slice, degrees.
#[track_caller]
fn only_arc(engagement: &Engagement) -> (f64, f64) {
    let arcs_of = |slice: &Slice| engagement.arcs[slice.arcs.clone()].to_vec();
    assert!(engagement.slices.iter().all(|slice| slice.arcs.len() == 1), "{engagement:?}");
    let arcs = engagement.slices.iter().flat_map(arcs_of).map(|arc| (arc.from.to_degrees(), arc.to.to_degrees()));
    let arcs: Vec<_> = arcs.collect();
    assert!(!arcs.is_empty());
    for arc in &arcs {
        assert!((arc.0 - arcs[0].0).abs() < 1e-6 && (arc.1 - arcs[0].1).abs() < 1e-6, "{arcs:?}");
    }
    arcs[0]
}

#[track_caller]
fn assert_arc(engagement: &Engagement, from: f64, to: f64, within: f64) {
    let arc = only_arc(engagement);
    assert!((arc.0 - from).abs() < within && (arc.1 - to).abs() < within, "{arc:?}, expected {from} to {to}");
}

#[test]
fn a_slot_engages_half_the_cutter() {
    for placed in placements() {
        let mut field = Field::new(block(), CELL).unwrap();
        let path = [placed.at(-10.0, 0.0, -3.0), placed.at(10.0, 0.0, -3.0)];
        cut_only(&mut field, &flat(), &path[..1], 0.1);
        let mut seen = 0;
        cut_path(&mut field, &flat(), &path, 0.1, &Slicing::default(), |tip, engagement| {
            // Beyond the round start of the slot.
            if (tip.xy() - path[0].xy()).norm() > 6.0 {
                assert_arc(engagement, -90.0, 90.0, 0.01);
                assert!((engagement.depth_mm - 3.0).abs() < 1e-9 && (engagement.width_mm - 10.0).abs() < 1e-5);
                assert!((engagement.chip_ratio - 1.0).abs() < 1e-9);
                assert!((engagement.volume_per_mm - 30.0).abs() < 0.03, "{}", engagement.volume_per_mm);
                assert_eq!(engagement.milling(Spindle::Clockwise), Milling::Both);
                assert_eq!(engagement.slices.len(), 3);
                seen += 1;
            }
        });
        assert!(seen > 100);
    }
}

/// A shoulder of the width b against what an earlier pass left, from a finishing pass of 0.05 mm to nearly a slot.
#[test]
fn a_shoulder_engages_by_its_width() {
    for placed in placements() {
        for width in [0.05, 0.2, 0.5, 1.0, 2.5, 5.0, 7.7, 9.5] {
            for side in [1.0, -1.0] {
                let mut field = Field::new(block(), CELL).unwrap();
                cut_only(&mut field, &flat(), &[placed.at(-15.0, 0.0, -2.0), placed.at(15.0, 0.0, -2.0)], 0.25);
                let path = [placed.at(-10.0, side * width, -2.0), placed.at(-3.0, side * width, -2.0)];
                let arc = (1.0 - 2.0 * width / 10.0_f64).acos().to_degrees();
                let (from, to) = if side > 0.0 { (90.0 - arc, 90.0) } else { (-90.0, -90.0 + arc) };
                let mut seen = 0;
                cut_path(&mut field, &flat(), &path, 0.1, &Slicing::default(), |tip, engagement| {
                    if (tip.xy() - path[0].xy()).norm() > 5.2 {
                        assert_arc(engagement, from, to, 0.01);
                        assert!((engagement.width_mm - width).abs() < 1e-4);
                        let chip = if width < 5.0 { arc.to_radians().sin() } else { 1.0 };
                        assert!((engagement.chip_ratio - chip).abs() < 1e-3);
                        assert!(
                            (engagement.volume_per_mm / (2.0 * width) - 1.0).abs() < 2e-3,
                            "{width} {}",
                            engagement.volume_per_mm
                        );
                        let up = if side > 0.0 { Milling::Up } else { Milling::Down };
                        assert_eq!(engagement.milling(Spindle::Clockwise), up);
                        assert_eq!(engagement.milling(Spindle::CounterClockwise) == Milling::Up, side < 0.0);
                        seen += 1;
                    }
                });
                assert!(seen > 15);
            }
        }
    }
}

/// A shoulder along the side of the stock itself, axis-parallel as stock is.
#[test]
fn a_shoulder_at_the_side_of_the_stock() {
    for width in [0.05, 0.5, 3.0] {
        let mut field = Field::new(block(), CELL).unwrap();
        let y = -40.0 - 5.0 + width;
        let arc = (1.0 - 2.0 * width / 10.0_f64).acos().to_degrees();
        let path = [Vector3::new(-20.0, y, -4.0), Vector3::new(-5.0, y, -4.0)];
        cut_path(&mut field, &flat(), &path, 0.2, &Slicing::default(), |tip, engagement| {
            if tip.x > -14.0 {
                assert_arc(engagement, 90.0 - arc, 90.0, 0.01);
            }
        });
    }
}

/// A slot that is widened by 0.03 mm: 10.03 mm at any offset of the cells.
#[test]
fn a_slot_widened_by_a_fraction_of_a_cell() {
    let arc = (1.0 - 2.0 * 0.03 / 10.0_f64).acos().to_degrees();
    for offset in [0.0, 0.013, 0.05, 0.099, 0.1, 0.17] {
        let placed = Placed { turn: 0.0, shift: Vector2::new(offset, offset) };
        let mut field = Field::new(block(), CELL).unwrap();
        cut_only(&mut field, &flat(), &[placed.at(-10.0, 0.0, -2.0), placed.at(10.0, 0.0, -2.0)], 0.3);
        let back = [placed.at(9.0, 0.03, -2.0), placed.at(-9.0, 0.03, -2.0)];
        cut_path(&mut field, &flat(), &back, 0.3, &Slicing::default(), |tip, engagement| {
            // Back, the wall is to the right. The round end of the slot apart.
            if tip.x < 3.0 {
                assert_arc(engagement, -90.0, -90.0 + arc, 0.05);
            }
        });
        let length = (back[0] - back[1]).norm();
        let expected = 2.0 * (20.0 * 10.0 + PI * 25.0) + 2.0 * 0.03 * length;
        let volume = field.volumes().removed_mm3;
        // Widened over 18 of 20 mm; at its ends less than 0.03 mm by 1 mm is in doubt.
        assert!((volume - expected).abs() < 1e-4 * expected + 0.06, "{volume} {expected}");
    }
}

/// A circle of path radius R_p in a hole of radius R_h: acos((R_h² − R_p² − r²)/(2 R_p r)) from the wall towards the motion.
#[test]
fn a_circle_in_a_hole() {
    for placed in placements().step_by(5) {
        for (hole, path) in [(12.0, 8.0), (12.0, 7.3), (12.0, 10.0), (6.0, 2.0)] {
            let mut field = Field::new(block(), CELL).unwrap();
            // The hole, cleared by circles of a cutter of another size.
            let small = Cutter::flat(6.0).unwrap();
            for radius in [0.5, 3.0, 5.0, 7.0, 9.0] {
                if radius < hole - 3.0 {
                    cut_only(&mut field, &small, &circle(&placed, [0.0, 0.0], radius, -2.0, 0.0, 700), 9.0);
                }
            }
            cut_only(&mut field, &small, &circle(&placed, [0.0, 0.0], hole - 3.0, -2.0, 0.0, 700), 9.0);
            let expected = ((hole * hole - path * path - 25.0) / (2.0 * path * 5.0_f64)).acos().to_degrees();
            let points = circle(&placed, [0.0, 0.0], path, -2.0, 0.4, 2000);
            let mut seen = 0;
            cut_path(&mut field, &flat(), &points, 9.0, &Slicing::default(), |_, engagement| {
                seen += 1;
                // Away from the first chords, where the cutter comes into the wall.
                if seen > 500 && seen < 1300 {
                    // The wall is to the right of a counter-clockwise circle.
                    assert_arc(engagement, -90.0, -90.0 + expected, 0.15);
                }
            });
        }
    }
}

/// An inside corner of 90° at the radial width w: acos(1 − w/r) before it; at the corner the arc begins there and reaches 90° on.
#[test]
fn an_inside_corner() {
    for placed in placements() {
        for width in [0.5, 1.0, 3.0] {
            let mut field = Field::new(block(), CELL).unwrap();
            let rough = [placed.at(-15.0, 0.0, -2.0), placed.at(0.0, 0.0, -2.0), placed.at(0.0, 15.0, -2.0)];
            cut_only(&mut field, &flat(), &rough, 0.2);
            let w = width;
            let alpha = (1.0 - w / 5.0_f64).acos().to_degrees();
            let finish = [placed.at(-12.0, -w, -2.0), placed.at(w, -w, -2.0)];
            let mut last = (0.0, 0.0);
            cut_path(&mut field, &flat(), &finish, 0.02, &Slicing::default(), |tip, engagement| {
                if (tip - finish[0]).norm() > 6.0 {
                    last = only_arc(engagement);
                    if (finish[1] - tip).norm() > 5.0 + 2.0 * w {
                        assert_arc(engagement, -90.0, -90.0 + alpha, 0.01);
                    }
                }
            });
            // Just before the corner: from the wall at the right to the wall ahead, acos from the front to the left.
            assert!((last.0 + 90.0).abs() < 0.01 && (last.1 - alpha).abs() < 0.5, "{last:?} {alpha}");
        }
    }
}

#[test]
fn a_spring_pass_is_air() {
    for placed in placements() {
        let pocket = [
            placed.at(-6.0, -5.0, -2.0),
            placed.at(7.0, -5.0, -2.0),
            placed.at(7.0, 4.0, -2.0),
            placed.at(-6.0, 4.0, -2.0),
            placed.at(-6.0, -5.0, -2.0),
        ];
        let mut field = Field::new(block(), CELL).unwrap();
        for offset in [6.0, 3.0] {
            let inner =
                pocket.map(|p| placed.at(0.5, -0.5, -2.0) + (p - placed.at(0.5, -0.5, -2.0)) * ((6.5 - offset) / 6.5));
            cut_only(&mut field, &flat(), &inner, 0.1);
        }
        cut_only(&mut field, &flat(), &pocket, 0.1);
        // The same again, and backwards in other steps, and a level above.
        let air = |_: &Vector3<f64>, engagement: &Engagement| assert!(engagement.is_air(), "{engagement:?}");
        let mut backwards = pocket;
        backwards.reverse();
        let above = pocket.map(|p| p + Vector3::new(0.0, 0.0, 0.7));
        for path in [pocket, backwards, above] {
            assert_eq!(cut_path(&mut field, &flat(), &path, 0.13, &Slicing::default(), air), 0.0);
        }
        let circle = circle(&placed, [0.0, 0.0], 2.0, -4.0, 0.0, 300);
        cut_only(&mut field, &flat(), &circle, 1.0);
        assert_eq!(cut_path(&mut field, &flat(), &circle, 1.0, &Slicing::default(), air), 0.0);
    }
}

/// A path from outside to a shoulder is air until the cutter's circle meets the stock.
#[test]
fn a_lead_in_is_air_until_contact() {
    for shift in [0.0, 0.03, 0.09] {
        let mut field = Field::new(block(), CELL).unwrap();
        let path = [Vector3::new(-50.0, 10.0 + shift, -1.0), Vector3::new(-41.0, 10.0 + shift, -1.0)];
        cut_path(&mut field, &flat(), &path, 0.05, &Slicing::default(), |tip, engagement| {
            // Contact is at x = −45, head-on: an arc wider than 5° from 0.005 mm on.
            if tip.x < -45.0 {
                assert!(engagement.is_air());
            } else {
                let half = (((-40.0 - tip.x) / 5.0).min(1.0)).acos().to_degrees();
                assert_arc(engagement, -half, half, 0.01);
            }
        });
    }
}

/// A wall thinner than a cell between two slots is met head-on and found.
#[test]
fn a_thin_wall_is_found() {
    for placed in placements() {
        for thickness in [0.06, 0.1, 0.3] {
            let mut field = Field::new(block(), CELL).unwrap();
            let half = 5.0 + thickness / 2.0;
            for y in [-half, half] {
                cut_only(&mut field, &flat(), &[placed.at(-15.0, y, -2.0), placed.at(15.0, y, -2.0)], 0.2);
            }
            for (angle, y) in [(0.0, 0.0), (0.0, 2.0), (0.7, -1.0)] {
                let mut engagement = Engagement::default();
                let tip = placed.at(0.0, y, -2.0);
                let along = placed.at(f64::cos(angle), f64::sin(angle), 0.0) - placed.at(0.0, 0.0, 0.0);
                field.engage(&flat(), &tip, &along, &Slicing::default(), &mut engagement).unwrap();
                let angle_of = |wall: f64| ((wall - y) / 5.0).asin().to_degrees() - angle.to_degrees();
                assert_arc(&engagement, angle_of(-thickness / 2.0), angle_of(thickness / 2.0), 0.01);
            }
        }
    }
}

/// Levels at the same wall, each cut with the same radial width, and a pass at full depth that leaves them behind.
#[test]
fn levels_at_the_same_wall() {
    for placed in placements() {
        let mut field = Field::new(block(), CELL).unwrap();
        for level in 1..=3 {
            let z = -1.5 * f64::from(level);
            cut_only(&mut field, &flat(), &[placed.at(-15.0, 0.0, z), placed.at(15.0, 0.0, z)], 0.2);
        }
        // Offsets of the upper levels: 0.3 mm and 0.1 mm were taken off the wall already.
        for (z, offset) in [(-1.5, 0.3), (-3.0, 0.1)] {
            cut_only(&mut field, &flat(), &[placed.at(-15.0, offset, z), placed.at(15.0, offset, z)], 0.2);
        }
        let path = [placed.at(-10.0, 0.4, -4.5), placed.at(0.0, 0.4, -4.5)];
        let slicing = Slicing { slice_mm: 0.5, ..Slicing::default() };
        let arc = |width: f64| 90.0 - (1.0 - 2.0 * width / 10.0_f64).acos().to_degrees();
        let mut seen = 0;
        let volume = cut_path(&mut field, &flat(), &path, 0.1, &slicing, |tip, engagement| {
            if (tip - path[0]).norm() < 6.0 {
                return;
            }
            seen += 1;
            assert_eq!(engagement.slices.len(), 9);
            for slice in &engagement.slices {
                // The lowest 1.5 mm have the full width.
                let width = if slice.top_mm < 1.6 {
                    0.4
                } else if slice.top_mm < 3.1 {
                    0.3
                } else {
                    0.1
                };
                let [found] = &engagement.arcs[slice.arcs.clone()] else { panic!("{engagement:?}") };
                assert!((found.from.to_degrees() - arc(width)).abs() < 0.01, "{found:?} {width}");
            }
            assert!((engagement.volume_per_mm / (1.5 * 0.8) - 1.0).abs() < 0.01, "{}", engagement.volume_per_mm);
        });
        assert!(seen > 30 && volume > 11.0);
    }
}

/// A ramp in a full slot: its front is as deep as its tip, and its end cuts on all of its area.
#[test]
fn a_ramp_cuts_with_side_and_end() {
    for placed in placements() {
        for slope in [0.02, 0.1, 0.5_f64] {
            let mut field = Field::new(block(), CELL).unwrap();
            let path = [placed.at(-10.0, 0.0, 0.0), placed.at(10.0, 0.0, -20.0 * slope)];
            let cosine = 1.0 / slope.hypot(1.0);
            cut_path(&mut field, &flat(), &path, 0.1, &Slicing::default(), |tip, engagement| {
                if (tip - path[0]).norm() < 11.0 {
                    return;
                }
                let depth = -tip.z;
                assert!((engagement.depth_mm - depth).abs() < 1e-6);
                assert!((engagement.end_area_mm2 - 25.0 * PI).abs() < 1e-6, "{}", engagement.end_area_mm2);
                let expected = cosine * (10.0 * depth + 25.0 * PI * slope);
                assert!(
                    (engagement.volume_per_mm / expected - 1.0).abs() < 2e-3,
                    "{} {expected}",
                    engagement.volume_per_mm
                );
            });
        }
    }
}

#[test]
fn a_plunge_cuts_with_its_end() {
    for placed in placements() {
        let mut field = Field::new(block(), CELL).unwrap();
        let path = [placed.at(0.0, 0.0, 5.0), placed.at(0.0, 0.0, -5.0)];
        let volume = cut_path(&mut field, &flat(), &path, 0.5, &Slicing::default(), |tip, engagement| {
            assert_eq!(engagement.is_air(), tip.z >= 0.0);
            assert!(engagement.is_air() || (engagement.end_area_mm2 / (25.0 * PI) - 1.0).abs() < 1e-9);
            assert!(engagement.slices.is_empty());
        });
        assert!((volume / (125.0 * PI) - 1.0).abs() < 1e-9);
        // A drill of 118° through its whole point, and what is left of it.
        let mut field = Field::new(block(), CELL).unwrap();
        let drill = Cutter::drill(8.0, 118.0).unwrap();
        let height = 4.0 / 59.0_f64.to_radians().tan();
        let path = [placed.at(0.0, 0.0, 0.0), placed.at(0.0, 0.0, -9.0)];
        let expected = 16.0 * PI * (9.0 - height * 2.0 / 3.0);
        let volume = cut_path(&mut field, &drill, &path, 0.1, &Slicing::default(), |_, _| ());
        assert!((volume / expected - 1.0).abs() < 5e-3, "{volume} {expected}");
        let removed = field.volumes().removed_mm3;
        assert!((removed / expected - 1.0).abs() < 1e-3, "{removed} {expected}");
    }
}

/// A ball-nose cutter on a plane in rows: scallops of height r − √(r² − s²/4), and the arcs of a full ball slot before.
#[test]
fn ball_nose_rows_leave_scallops() {
    let ball = Cutter::ball(10.0).unwrap();
    for placed in placements() {
        let mut field = Field::new(block(), CELL).unwrap();
        let (step, depth) = (1.3, 1.0);
        for row in -3..=3 {
            let y = step * f64::from(row);
            let path = [placed.at(-8.0, y, -depth), placed.at(8.0, y, -depth)];
            cut_path(&mut field, &ball, &path, 0.4, &Slicing::default(), |tip, engagement| {
                if (tip - path[0]).norm() > 8.0 {
                    assert!((engagement.depth_mm - depth).abs() < 0.02, "{}", engagement.depth_mm);
                    if row == -3 {
                        for slice in &engagement.slices {
                            assert_eq!(slice.arcs.len(), 1);
                        }
                        // The circular segment of the slot's section.
                        let half = (1.0 - depth / 5.0_f64).acos();
                        let area = 25.0 * (half - half.sin() * half.cos());
                        assert!(
                            (engagement.volume_per_mm / area - 1.0).abs() < 0.01,
                            "{} {area}",
                            engagement.volume_per_mm
                        );
                        assert!(
                            (engagement.width_mm / (10.0 * half.sin()) - 1.0).abs() < 0.07,
                            "{}",
                            engagement.width_mm
                        );
                    }
                }
            });
        }
        let scallop = 5.0 - (25.0 - step * step / 4.0).sqrt();
        for row in -2..=2 {
            let top = placed.at(1.234, step * (f64::from(row) + 0.5), 0.0);
            let bottom = placed.at(1.234, step * f64::from(row), 0.0);
            let height = |p: &Vector3<f64>| field.surface(p.xy()).unwrap().position.z + depth;
            assert!((height(&top) - scallop).abs() < 1e-9 && height(&bottom).abs() < 1e-9);
        }
    }
}

#[test]
fn stock_has_a_bottom() {
    // Through the bottom of a plate of 3 mm: slices below it are not in material.
    let plate = Stock::cuboid(Vector3::new(-30.0, -30.0, -3.0), Vector3::new(30.0, 30.0, 0.0)).unwrap();
    let mut field = Field::new(plate, CELL).unwrap();
    let path = [Vector3::new(-40.0, 0.0, -5.0), Vector3::new(10.0, 0.0, -5.0)];
    let volume = cut_path(&mut field, &flat(), &path, 0.5, &Slicing::default(), |tip, engagement| {
        if tip.x > 0.0 {
            assert!((engagement.volume_per_mm - 30.0).abs() < 0.03);
            assert_eq!(engagement.slices.len(), 3);
            assert!((engagement.slices[0].bottom_mm - 2.0).abs() < 1e-9);
        }
    });
    let expected = 3.0 * (40.0 * 10.0 + 12.5 * PI);
    assert!((volume / expected - 1.0).abs() < 2e-3, "{volume} {expected}");
    assert!((field.volumes().removed_mm3 / expected - 1.0).abs() < 2e-4);
}
