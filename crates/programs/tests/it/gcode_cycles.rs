//! Canned cycles: read as the motion they make, and kept as cycles when their holes move.

use crate::support::programs::programs_in;
use kinetostat_programs::{
    NumberFormat, Sampling, Toolpath, WriteOptions,
    gcode::{GcodeOptions, GcodeProgram},
};
use nalgebra::Vector3;

fn programs() -> Vec<(String, Vec<u8>)> {
    let programs = programs_in("tests/gcode_cycles");
    assert_eq!(programs.len(), 6);
    programs
}

fn parse(source: impl Into<Vec<u8>>) -> (GcodeProgram, Toolpath) {
    let program = GcodeProgram::parse(source, "part.nc", &GcodeOptions::default()).unwrap();
    let path = program.toolpath(Sampling::new(0.01, 100.0).unwrap()).unwrap();
    (program, path)
}

fn rewritten(source: &str, correction: impl Fn(Vector3<f64>) -> Vector3<f64>) -> (String, Vec<Vector3<f64>>) {
    let (program, path) = parse(source);
    let goals: Vec<_> = path.positions_mm().into_iter().map(|p| p + correction(p)).collect();
    let written =
        program.rewrite(&path, &goals, WriteOptions::with_decimals(NumberFormat::new(3, 4).unwrap())).unwrap();
    let back = written.read_back().unwrap().positions_mm();
    (String::from_utf8(written.into_bytes()).unwrap(), back)
}

#[test]
fn a_hole_is_the_way_that_its_cycle_makes() {
    let (_, path) = parse("G0 X0 Y0 Z10\nG98 G81 X5 Y6 Z-8 R2 F60\nG99 X9\nG80\nG1 X0\n");
    let points: Vec<_> = path.points().iter().map(|p| (p.position_mm, p.cutting, p.feed_mm_per_min)).collect();
    let at = Vector3::new;
    assert_eq!(
        points,
        [
            (at(0.0, 0.0, 10.0), false, None),
            (at(5.0, 6.0, 10.0), false, None),
            (at(5.0, 6.0, 2.0), false, None),
            (at(5.0, 6.0, -8.0), true, Some(60.0)),
            (at(5.0, 6.0, 10.0), false, None),
            (at(9.0, 6.0, 10.0), false, None),
            (at(9.0, 6.0, 2.0), false, None),
            (at(9.0, 6.0, -8.0), true, Some(60.0)),
            (at(9.0, 6.0, 2.0), false, None),
            (at(0.0, 6.0, 2.0), true, Some(60.0)),
        ]
    );
    let lengths: Vec<f64> = path.points().iter().map(|p| p.arc_length_mm).collect();
    let first = 5f64.hypot(6.0);
    let expected =
        [0.0, 0.0, 8.0, 18.0, 36.0, 40.0, 48.0, 58.0, 68.0, 77.0].map(|l| if l > 0.0 { l + first } else { l });
    for (k, (found, expected)) in lengths.iter().zip(expected).enumerate().filter(|(k, _)| *k != 1) {
        assert!((found - expected).abs() < 1e-12, "{k}: {found} {expected}");
    }
}

#[test]
fn below_the_plane_r_the_tool_first_rises() {
    let (_, path) = parse("G0 X0 Y0 Z-1\nG81 X5 Z-8 R2 F60\n");
    let heights: Vec<f64> = path.points().iter().map(|p| p.position_mm.z).collect();
    assert_eq!(heights, [-1.0, 2.0, 2.0, -8.0, 2.0]);
}

#[test]
fn steps_and_repetitions_are_counted_as_in_incremental_programs() {
    let (_, source) = programs().into_iter().find(|(name, _)| name == "steps.nc").unwrap();
    let (_, path) = parse(source);
    let bottoms: Vec<_> = path.points().iter().filter(|p| p.cutting).map(|p| p.position_mm).collect();
    let expected = [
        [10.0, 2.0, -7.0],
        [20.0, 4.0, -7.0],
        [30.0, 6.0, -7.0],
        [40.0, 8.0, -7.0],
        [40.0, 18.0, -7.0],
        [4.0, 50.0, -3.0],
        [12.0, 55.0, -3.0],
    ];
    assert_eq!(bottoms, expected.map(Vector3::from));
}

#[test]
fn without_correction_the_bytes_are_the_same() {
    for (name, source) in programs() {
        let (program, path) = parse(source.clone());
        for format in [NumberFormat::default(), program.own_format()] {
            let written = program.rewrite(&path, &path.positions_mm(), WriteOptions::with_decimals(format)).unwrap();
            assert_eq!(written.bytes(), source, "{name}\n{}", String::from_utf8_lossy(written.bytes()));
            assert_eq!(written.read_back().unwrap().positions_mm(), path.positions_mm(), "{name}");
        }
    }
}

#[test]
fn bottoms_are_met_and_cycles_stay() {
    let bend = |p: Vector3<f64>| Vector3::new((0.1 * p.y).sin(), (0.2 * p.x).cos(), (p.x + p.z).sin()) * 0.3;
    for (name, source) in programs() {
        let source = String::from_utf8(source).unwrap();
        let (_, path) = parse(source.clone());
        let (text, back) = rewritten(&source, bend);
        assert_eq!(back.len(), path.len(), "{name}\n{text}");
        for (k, point) in path.points().iter().enumerate().filter(|(_, p)| p.cutting) {
            let goal = point.position_mm + bend(point.position_mm);
            assert!((back[k] - goal).amax() <= 0.0026, "{name} {k}: {} {goal}\n{text}", back[k]);
        }
        let cycles = |text: &str| text.to_uppercase().matches("G8").count() + text.matches("G7").count();
        assert_eq!(cycles(&text), cycles(&source), "{name}\n{text}");
    }
}

#[test]
fn words_of_a_hole_are_changed_where_they_stand_and_added_where_they_do_not() {
    let source = "G0 X0 Y0 Z10\nN7 G81 X5. Y6. Z-8. R2. F60 (first)\nX9.\nG80\n";
    let sinks = |p: Vector3<f64>| Vector3::new(0.0, 0.0, -0.01 * p.x);
    let (text, _) = rewritten(source, sinks);
    assert_eq!(text, "G0 X0 Y0 Z10\nN7 G81 X5. Y6. Z-8.050 R1.950 F60 (first)\nX9. Z-8.090 R1.910\nG80\n");
}

#[test]
fn repetitions_become_lines_where_their_corrections_differ() {
    let source = "G0 X0 Y0 Z10\nG91 G81 X5 Z-8 R-8 F60 L3\nG80\n";
    let (kept, _) = rewritten(source, |_| Vector3::new(0.0, 0.0, 0.25));
    assert_eq!(kept, "G0 X0 Y0 Z10.250\nG91 G81 X5 Z-8 R-8 F60 L3\nG80\n");
    let (text, _) = rewritten(source, |p| Vector3::new(0.01 * p.x, 0.0, 0.0));
    assert_eq!(text, "G0 X0 Y0 Z10\nG91 G81 X5.050 Z-8 R-8 F60\nX5.050\nX5.050\nG80\n");
}

#[test]
fn cycles_that_are_not_understood_are_refused() {
    let third = |line: &str| {
        let source = format!("G21 G90 G17 F100\nG0 X0 Y0 Z5\n{line}\n");
        GcodeProgram::parse(source, "part.nc", &GcodeOptions::default()).unwrap_err().to_string()
    };
    for (line, expected) in [
        (
            "N5 G87 Z-5 R2",
            "3:4: `G87`: this canned cycle is not supported; expected the cycle written out as G0 and G1 moves",
        ),
        ("G81 X5 Z-5", "3:1: `G81`: cycle G81 without R; expected R and Z on this line or one before it"),
        ("G83 X5 R2", "3:1: `G83`: cycle G83 without Z; expected R and Z on this line or one before it"),
        (
            "G18 G81 X5 R2 Z-5",
            "3:5: `G81`: cycles are read in G17 only; expected the cycle written out as G0 and G1 moves",
        ),
        (
            "G91 G99 G81 X5 R-2 Z-5\nX5",
            "4:1: `X5`: a second hole in G91 and G99 has another R on other controls; expected G90 or G98",
        ),
        ("G81 X5 R2 Z-5 L20000", "3:15: `L20000`: expected at most 10000 repetitions"),
    ] {
        assert_eq!(third(line), format!("part.nc:{expected}"));
    }
}
