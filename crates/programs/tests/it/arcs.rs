//! Arcs of G-code: how far they turn, which way, and which are refused.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use kinetostat_programs::{
    Plane, Sampling, Toolpath,
    gcode::{ArcFault, Fault, GcodeOptions, GcodeProgram},
    internals::{Arc, centre_through},
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

#[test]
fn a_circle_passes_its_three_points_and_goes_on_as_asked() {
    let points = [Vector3::new(1.0, 0.0, 5.0), Vector3::new(0.0, 1.0, 5.0), Vector3::new(0.0, -1.0, 5.0)];
    let arc = Arc::through(points, None).unwrap();
    assert!((arc.sweep_rad() - 1.5 * PI).abs() < 1e-12 && (arc.radius() - 1.0).abs() < 1e-12);
    for (t, point) in [(0.0, points[0]), (arc.via, points[1]), (1.0, points[2])] {
        assert!((arc.at(t).0 - point).norm() < 1e-12);
        assert!((arc.nearest(&point, t) - t).abs() < 1e-12);
    }
    let back = Arc::through(points, Some(-FRAC_PI_2)).unwrap();
    assert!((back.at(1.0).0 - points[2]).norm() < 1e-12, "{:?}", back.at(1.0));
    let twice = Arc::through(points, Some(4.0 * PI)).unwrap();
    assert!((twice.at(1.0).0 - points[0]).norm() < 1e-12);
    assert!((twice.nearest(&points[1], 0.6) - 0.625).abs() < 1e-12);
    assert_eq!(Arc::through([points[0], points[0], points[1]], None), None);
    let [x, y] = [Vector3::x(), Vector3::x() * 2.0];
    assert_eq!(Arc::through([Vector3::zeros(), x, y], None), None);
}

fn circle(angle: f64) -> Vector3<f64> {
    Vector3::new(3.0 + 5.0 * angle.cos(), 7.0, -2.0 + 5.0 * angle.sin())
}

#[test]
fn points_of_a_circle_have_its_centre() {
    for ends in [[0.1, 0.6], [0.2, 4.0], [1.0, 7.2], [0.0, std::f64::consts::TAU]] {
        let between = (1..9).map(|k| circle(ends[0] + (ends[1] - ends[0]) * f64::from(k) / 9.0));
        let centre = centre_through(Plane::Zx, &circle(ends[0]), &circle(ends[1]), between).unwrap();
        assert!((centre[0] + 2.0).abs() < 1e-9 && (centre[1] - 3.0).abs() < 1e-9, "{ends:?} {centre:?}");
    }
}

#[test]
fn points_of_a_line_have_none() {
    let at = |t: f64| Vector3::new(t, 2.0 * t, 0.0);
    assert_eq!(centre_through(Plane::Xy, &at(0.0), &at(1.0), [at(0.3), at(0.5)].into_iter()), None);
    assert_eq!(centre_through(Plane::Xy, &at(0.0), &at(0.0), [at(0.3), at(0.5)].into_iter()), None);
}
