//! Arcs of G-code: how far they turn, which way, and which are refused.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use kinetostat_programs::{
    NumberFormat, Sampling, Toolpath, WriteOptions,
    gcode::{ArcFault, Fault, GcodeOptions, GcodeProgram},
    robot::{Language, RobotOptions, RobotProgram},
};
use nalgebra::Vector3;

/// The path of `words` from X10 on.
fn arc(words: &str) -> Result<Toolpath, Fault> {
    let source = format!("G0 X10 Y0 Z0\n{words}\n");
    let program = GcodeProgram::parse(source, "arc.nc", &GcodeOptions::default()).map_err(|error| error.fault)?;
    Ok(program.toolpath(Sampling::new(0.01, 1.0).unwrap()).unwrap())
}

fn length(path: &Toolpath) -> f64 {
    path.points().last().unwrap().arc_length_mm
}

/// 1 to the left and −1 to the right, as it turns.
fn sense(path: &Toolpath) -> f64 {
    let [.., before, last] = path.points() else { panic!("{path:?}") };
    before.tangent.cross(&last.tangent).z.signum()
}

#[test]
fn quarter_full_and_three_quarter_turns() {
    let quarter = arc("G3 X0 Y10 I-10 J0").unwrap();
    assert!((length(&quarter) - 10.0 * FRAC_PI_2).abs() < 1e-13 && sense(&quarter) == 1.0);
    let rest = arc("G2 X0 Y10 I-10 J0").unwrap();
    assert!((length(&rest) - 15.0 * PI).abs() < 1e-13 && sense(&rest) == -1.0);
    for (word, sign) in [("G2", -1.0), ("G3", 1.0)] {
        let full = arc(&format!("{word} X10 Y0 Z3 I-10 J0")).unwrap();
        assert_eq!(sense(&full), sign);
        assert!((length(&full) - (10.0 * TAU).hypot(3.0)).abs() < 1e-12);
    }
}

#[test]
fn radius_form_takes_the_short_arc_or_the_long_one() {
    for (words, sweep) in [
        ("G3 X0 Y10 R10", FRAC_PI_2),
        ("G3 X0 Y10 R-10", 1.5 * PI),
        ("G2 X0 Y10 R10", -FRAC_PI_2),
        ("G2 X0 Y10 R-10", -1.5 * PI),
    ] {
        let path = arc(words).unwrap();
        let turned = sense(&path) * length(&path) / 10.0;
        assert!((turned - sweep).abs() < 1e-12, "{words}: {turned}");
    }
    // A chord a little over two radii is a semicircle.
    let half = arc("G2 X-10 Y0 R9.998").unwrap();
    assert!((length(&half) / 10.0 - PI).abs() < 1e-12 && sense(&half) == -1.0);
}

#[test]
fn arcs_that_cannot_be_are_refused() {
    let refusal = |words: &str| match arc(words).unwrap_err() {
        Fault::Arc(fault) => fault,
        other => panic!("{words}: {other}"),
    };
    assert_eq!(refusal("G2 X0 Y10 I0 J0"), ArcFault::NoRadius);
    assert_eq!(refusal("G2 X10 Y0 R5"), ArcFault::NoChord);
    assert!(matches!(refusal("G90.1 G2 X0 Y9 I0 J0"), ArcFault::Radii { .. }));
    assert!(matches!(refusal("G2 X-10 Y0 R9"), ArcFault::TooShort { .. }));
}

#[test]
fn tangent_is_the_derivative_of_position() {
    let source = "G0 X0 Y1 Z5\nG18 G90.1 G2 X5 Y4 Z0.003 I0 K0\n";
    let program = GcodeProgram::parse(source, "helix.nc", &GcodeOptions::default()).unwrap();
    let path = program.toolpath(Sampling::new(0.01, 1e-3).unwrap()).unwrap();
    let of_helix = &path.points()[1..];
    assert!(of_helix.len() > 5000);
    for points in of_helix.windows(3) {
        let [before, at, after] = points else { unreachable!() };
        let numeric = (after.position_mm - before.position_mm).normalize();
        assert!((numeric - at.tangent).norm() < 1e-8, "{at:?}");
    }
}

/// The program of a circle in KRL from X1 Y0 Z5, in frames that are those of the workpiece.
fn circ(words: &str) -> Result<RobotProgram, String> {
    let source = format!("DEF c ( )\nLIN {{X 1,Y 0,Z 5,A 0,B 0,C 0}}\nCIRC {words}\nEND\n");
    RobotProgram::parse(source, "c.src", Language::Krl, None, &RobotOptions::default())
        .map_err(|error| error.to_string())
}

#[test]
fn a_circle_passes_its_three_points_and_goes_on_as_asked() {
    let points = [Vector3::new(1.0, 0.0, 5.0), Vector3::new(0.0, 1.0, 5.0), Vector3::new(0.0, -1.0, 5.0)];
    let quarters = Sampling::new(10.0, FRAC_PI_2 * 1.000_001).unwrap();
    let path = |words: &str| circ(words).unwrap().toolpath(quarters).unwrap();
    let is_at = |path: &Toolpath, point: usize, wanted: Vector3<f64>| {
        (path.points()[point].position_mm - wanted).norm() < 1e-12
    };
    let through = "{X 0,Y 1,Z 5},{X 0,Y -1,Z 5}";
    let three = path(through);
    assert!(three.len() == 4 && (three.length_mm() - 1.5 * PI).abs() < 1e-12, "{}", three.length_mm());
    assert!(is_at(&three, 0, points[0]) && is_at(&three, 1, points[1]) && is_at(&three, 3, points[2]));
    let back = path(&format!("{through},CA -90"));
    assert!(back.len() == 2 && is_at(&back, 1, points[2]) && (back.length_mm() - FRAC_PI_2).abs() < 1e-12);
    let twice = path(&format!("{through},CA 720"));
    assert!(twice.len() == 9 && is_at(&twice, 8, points[0]) && (twice.length_mm() - 2.0 * TAU).abs() < 1e-12);
    assert!(is_at(&twice, 1, points[1]) && is_at(&twice, 5, points[1]));
    for words in ["{X 1,Y 0,Z 5},{X 0,Y 1,Z 5}", "{X 2,Y 0,Z 5},{X 3,Y 0,Z 5}"] {
        assert!(circ(words).unwrap_err().contains("start, middle and end are on no circle"), "{words}");
    }
}

/// A circle of two turns through points that move along it: each is found where the circle passes it, in its own turn.
#[test]
fn a_circle_of_two_turns_is_followed_turn_by_turn() {
    let program = circ("{X 0,Y 1,Z 5},{X 0,Y -1,Z 5},CA 720").unwrap();
    let path = program.toolpath(Sampling::new(1e-3, 0.2).unwrap()).unwrap();
    let angle = |s: f64| s + 0.05 * (s / 2.0).sin();
    let goal = |s: f64| Vector3::new(angle(s).cos(), angle(s).sin(), 5.0);
    let goals: Vec<Vector3<f64>> = path.points().iter().map(|point| goal(point.arc_length_mm)).collect();
    let writing = WriteOptions { tolerance_mm: 1e-6, ..WriteOptions::with_decimals(NumberFormat::new(6, 6).unwrap()) };
    let written = program.rewrite(&path, &goals, None, writing).unwrap();
    let text = String::from_utf8_lossy(written.bytes()).into_owned();
    assert!(text.matches("CIRC").count() == 1 && text.lines().count() == 4, "{text}");
    let back = written.read_back().unwrap();
    for (own, point) in back.points().iter().zip(path.points()) {
        let s = point.arc_length_mm;
        assert!((own.position_mm - goal(s)).norm() < 1e-6, "{s}: {}", own.position_mm);
        assert!((own.arc_length_mm - angle(s)).abs() < 1e-6, "{s}: {}", own.arc_length_mm);
    }
}

/// Returns the blocks of an arc in G18 whose points are moved to those at `goal` of their angle, rad, written with nine decimals.
fn moved_arc(angles: [f64; 2], goal: impl Fn(f64) -> Vector3<f64>) -> String {
    // In G18 angles turn from z to x.
    let at = |angle: f64| Vector3::new(5.0 * angle.sin(), 7.0, 5.0 * angle.cos());
    let [start, end] = angles.map(at);
    let source = format!(
        "G21 G90 G18\nG0 X{:.12} Y7. Z{:.12}\nG3 X{:.12} Z{:.12} I{:.12} K{:.12} F100\n",
        start.x, start.z, end.x, end.z, -start.x, -start.z
    );
    let program = GcodeProgram::parse(source, "arc.nc", &GcodeOptions::default()).unwrap();
    let path = program.toolpath(Sampling::new(0.01, 0.003).unwrap()).unwrap();
    let goals: Vec<Vector3<f64>> = path.points().iter().map(|p| goal(p.position_mm.x.atan2(p.position_mm.z))).collect();
    let nine = WriteOptions { tolerance_mm: 1e-6, ..WriteOptions::with_decimals(NumberFormat::new(9, 9).unwrap()) };
    String::from_utf8(program.rewrite(&path, &goals, nine).unwrap().into_bytes()).unwrap()
}

/// Of a circle of another radius about another centre.
#[test]
fn points_of_a_circle_have_its_centre() {
    let circle = |angle: f64| Vector3::new(-0.02 + 5.01 * angle.sin(), 7.0, 0.03 + 5.01 * angle.cos());
    for angles in [[0.1, 0.6], [0.2, 4.0], [1.0, 7.2], [0.0, TAU]] {
        let text = moved_arc(angles, circle);
        let arcs: Vec<&str> = text.lines().filter(|line| line.contains('I')).collect();
        let [arc] = arcs[..] else { panic!("{text}") };
        let number =
            |letter: char| arc.split(letter).nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
        let start = circle(angles[0]);
        let [x, z] = [start.x + number('I'), start.z + number('K')];
        assert!((x + 0.02).abs() < 1e-7 && (z - 0.03).abs() < 1e-7 && arc.starts_with("G3"), "{text}");
        assert_eq!(text.lines().count(), 3, "{text}");
    }
}

#[test]
fn points_of_a_line_have_none() {
    let text = moved_arc([0.1, 1.4], |angle| Vector3::new(4.0 * angle, 7.0, 5.0 - 3.0 * angle));
    let blocks: Vec<&str> = text.lines().skip(2).collect();
    assert!(matches!(blocks[..], [line] if line.starts_with("G1") && !line.contains('I')), "{text}");
}
