//! Blocks that are written as the fewest arcs and lines within a tolerance.

use kinetostat_programs::{
    NumberFormat, Sampling, WriteOptions,
    gcode::{GcodeOptions, GcodeProgram},
};
use nalgebra::Vector3;

const TOLERANCE_MM: f64 = 0.002;

fn writing() -> WriteOptions {
    WriteOptions { tolerance_mm: TOLERANCE_MM, ..WriteOptions::with_decimals(NumberFormat::new(3, 5).unwrap()) }
}

/// `source` with `correction` added at every point, its motions alone; what was written passes every point within the tolerance.
fn written(source: &str, writing: WriteOptions, correction: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<String> {
    let program = GcodeProgram::parse(source, "test.nc", &GcodeOptions::default()).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    let goals: Vec<_> = path.positions_mm().into_iter().map(|p| p + correction(p)).collect();
    let written = program.rewrite(&path, &goals, writing).unwrap();
    let text = String::from_utf8(written.bytes().to_vec()).unwrap();
    for (back, goal) in written.read_back().unwrap().positions_mm().iter().zip(&goals) {
        assert!((back - goal).norm() <= writing.tolerance_mm, "{back} {goal}\n{text}");
    }
    text.lines().skip(1).map(String::from).collect()
}

#[test]
fn a_scaled_and_shifted_arc_is_one_arc_in_every_form() {
    let grown = |p: Vector3<f64>| p * 0.01 + Vector3::new(0.3, -0.2, 0.1);
    for (source, arc) in [
        ("G90\nG0 X20 Y0 Z0\nG3 X-20 Y0 I-20 J0 F100", "G3 X-19.900 Y-0.200 I-20.200 J0.000 F100"),
        ("G90\nG0 X20 Y0 Z0\nG2 X-20 Y0 I-20 F100", "G2 X-19.900 Y-0.200 I-20.200 J0.000 F100"),
        ("G90\nG0 X20 Y0 Z0\nG3 X0 Y20 R20", "G3 X0.300 Y20 R20.200"),
        ("G90\nG0 X20 Y0 Z0\nG3 X0 Y-20 R-20", "G3 X0.300 Y-20.400 R-20.200"),
        ("G90 G90.1\nG0 X20 Y0 Z0\nG3 X-20 Y0 I0 J0", "G3 X-19.900 Y-0.200 I0.300 J-0.200"),
        ("G90\nG0 X20 Y0 Z0\nG91 G3 X-40 I-20 J0", "G91 G3 X-40.400 I-20.200 J0.000"),
        ("G90 G18\nG0 X0 Y0 Z20\nG3 X20 Z0 K-20", "G3 X20.500 Z0.100 I0.000 K-20.200"),
        ("G90 G19\nG0 X0 Y20 Z0\ng02y-20z0j-20k0", "g02y-20.400z0.100j-20.200k0.000"),
        ("G90\nG0 X20 Y0 Z0\nG3 I-20 F100", "G3 X20.500 I-20.200 J0.000 F100"),
    ] {
        let lines = written(source, writing(), grown);
        assert_eq!((lines.len(), lines[1].as_str()), (2, arc), "{source}");
    }
}

#[test]
fn a_flat_arc_that_must_rise_is_helical_or_lines() {
    let source = "G90\nG0 X20 Y0 Z0\nG3 X0 Y20 I-20 J0 F100\nX-20 Y0 I0 J-20";
    let rise = |p: Vector3<f64>| Vector3::new(0.0, 0.0, 0.4 * p.y.atan2(p.x).max(0.0));
    let lines = written(source, writing(), rise);
    assert_eq!(
        lines[1..],
        ["G3 X0 Y20 Z0.628 I-20.000 J0.000 F100", "X-20 Y0 Z1.257 I0.000 J-20.000"].map(String::from)
    );
    let lines = written(source, WriteOptions { helical_arcs: false, ..writing() }, rise);
    assert!(lines.len() > 20 && lines.iter().all(|line| !line.contains('I') && !line.contains("G3")), "{lines:?}");
}

#[test]
fn a_line_that_bends_is_as_few_lines_as_its_curvature_asks_for() {
    // A chord of length h stands a h² / 4 off the parabola a x².
    let bend = 1e-4;
    let lines = written("G90\nG0 X0 Y0 Z0\nG1 X200 F100", writing(), |p| Vector3::new(0.0, bend * p.x * p.x, 0.0));
    let fewest = 200.0 / (4.0 * TOLERANCE_MM / bend).sqrt();
    let count = (lines.len() - 1) as f64;
    assert!(count >= fewest.floor() && count <= 1.25 * fewest + 1.0, "{count} {fewest}");
}

#[test]
fn lines_lead_on_where_corrections_stretch_the_way_unevenly() {
    // Nothing bends: the way along the line is another, the line is the same.
    let source = "G90\nG0 X0 Y0 Z0\nG1 X80 Y60 F100";
    let along = |p: Vector3<f64>| Vector3::new(0.8, 0.6, 0.0) * 0.3 * (p.x / 10.0).sin().powi(2);
    assert_eq!(written(source, writing(), along).len(), 2);
    let exact = written(source, WriteOptions { tolerance_mm: 0.0011, ..writing() }, along);
    assert_eq!(exact.len(), 2);
}

#[test]
fn an_arc_becomes_a_line_where_no_arc_passes_and_the_next_one_is_an_arc_again() {
    let source = "G90\nG0 X20 Y0 Z0\nG3 X0 Y20 I-20 J0 F100\nX-20 Y0 I0 J-20";
    let onto_chord = |p: Vector3<f64>| Vector3::new(0.0, if p.x > 0.0 { 20.0 - p.x - p.y } else { 0.0 }, 0.0);
    let lines = written(source, writing(), onto_chord);
    assert_eq!(lines[1..], ["G1 X0 Y20 F100", "G3 X-20 Y0 I0 J-20"].map(String::from));
}

#[test]
fn a_tolerance_that_is_none_is_refused() {
    let program = GcodeProgram::parse("G0 X0 Y0 Z0\n", "test.nc", &GcodeOptions::default()).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    for tolerance_mm in [-0.1, f64::NAN, f64::INFINITY] {
        let refused =
            program.rewrite(&path, &path.positions_mm(), WriteOptions { tolerance_mm, ..writing() }).unwrap_err();
        let expected = format!("write tolerance {tolerance_mm} mm: expected a finite number, 0 or more");
        assert_eq!(refused.to_string(), expected);
    }
}
