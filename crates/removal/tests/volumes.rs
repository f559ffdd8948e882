//! Volumes against exact booleans of manifold3d (`volumes/make.py`): of fields, and of the sum of engagements.

use kinetostat_removal::{Cutter, Field, Slicing, Stock};
use nalgebra::Vector3;
use serde_json::Value;

use crate::paths::{cut_only, cut_path};

const PROGRAMS: &str = include_str!("volumes/programs.json");

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::new(number(&value[0]), number(&value[1]), number(&value[2]))
}

fn stock_of(value: &Value) -> Stock {
    match value["kind"].as_str().unwrap() {
        "box" => Stock::cuboid(vector(&value["low"]), vector(&value["high"])).unwrap(),
        _ => Stock::cylinder(vector(&value["base"]), number(&value["diameter"]), number(&value["height"])).unwrap(),
    }
}

/// A program of the file: its field before any cut, its paths and the volume that it removes.
struct Program {
    field: Field,
    paths: Vec<(Cutter, Vec<Vector3<f64>>)>,
    stock_mm3: f64,
    removed_mm3: f64,
}

fn programs() -> Vec<Program> {
    let programs: Vec<Value> = serde_json::from_str(PROGRAMS).unwrap();
    assert_eq!(programs.len(), 50);
    programs.iter().map(program_of).collect()
}

fn program_of(program: &Value) -> Program {
    let paths: Vec<_> = program["paths"]
        .as_array()
        .unwrap()
        .iter()
        .map(|path| {
            let [diameter, corner] = ["diameter", "corner"].map(|key| number(&path["cutter"][key]));
            let mut points: Vec<_> = path["points"].as_array().unwrap().iter().map(vector).collect();
            // From above the stock, so that all that is removed is cut by a move.
            points.insert(0, Vector3::new(points[0].x, points[0].y, 1.0));
            (Cutter::bull(diameter, corner).unwrap(), points)
        })
        .collect();
    let smallest = paths.iter().map(|path| 2.0 * path.0.radius_mm()).fold(f64::INFINITY, f64::min);
    assert!(number(&program["chord_error"]) < 1e-4);
    Program {
        field: Field::new(stock_of(&program["stock"]), smallest / 40.0).unwrap(),
        paths,
        stock_mm3: number(&program["stock_mm3"]),
        removed_mm3: number(&program["removed_mm3"]),
    }
}

fn assert_volumes(every: usize) {
    let mut worst = 0.0_f64;
    for (at, mut program) in programs().into_iter().enumerate().step_by(every) {
        for (cutter, points) in &program.paths {
            cut_only(&mut program.field, cutter, points, 0.25);
        }
        let volumes = program.field.volumes();
        let error = volumes.removed_mm3 / program.removed_mm3 - 1.0;
        println!("{at}: removed {:.1} mm³, {error:+.1e}", program.removed_mm3);
        assert!((volumes.stock_mm3 / program.stock_mm3 - 1.0).abs() < 1e-4, "{at}");
        worst = worst.max(error.abs());
    }
    println!("worst {worst:.1e}");
    assert!(worst < 2e-4);
}

#[test]
fn random_programs_leave_the_volume_of_exact_booleans() {
    assert_volumes(8);
}

#[test]
#[ignore = "takes a minute; .ci/full runs it"]
fn all_fifty_programs_leave_the_volume_of_exact_booleans() {
    assert_volumes(1);
}

fn assert_engagements_add_up(count: usize) {
    let slicing = Slicing { slice_mm: 0.5, nose_slices: 12, end_rings: 12 };
    let mut worst = 0.0_f64;
    for (at, mut program) in programs().into_iter().enumerate().take(count) {
        let mut engaged = 0.0;
        for (cutter, points) in &program.paths {
            // A plunge meets levels all at once: its middles are to be where they are.
            engaged += cut_path(&mut program.field, cutter, &points[..2], 0.01, &slicing, |_, _| ());
            engaged += cut_path(&mut program.field, cutter, &points[1..], 0.25, &slicing, |_, _| ());
        }
        let error = engaged / program.removed_mm3 - 1.0;
        println!("{at}: removed {:.1} mm³, {error:+.1e}", program.removed_mm3);
        worst = worst.max(error.abs());
    }
    println!("worst {worst:.1e}");
    assert!(worst < 2e-3);
}

#[test]
fn engagements_add_up_to_the_removed_volume() {
    assert_engagements_add_up(3);
}

#[test]
#[ignore = "takes a minute; .ci/full runs it"]
fn engagements_of_all_programs_add_up() {
    assert_engagements_add_up(50);
}
