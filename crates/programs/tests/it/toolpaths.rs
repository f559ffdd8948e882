//! Paths that are generated, and polylines: read, split, written back; and which dialect a program shows.

use kinetostat_programs::{
    Circle, Load, NumberFormat, PathPoint, Plane, Sampling, Toolpath, TurnDirection,
    gcode::{Dialect, GcodeOptions, GcodeProgram},
    polyline::{Polyline, write},
};
use nalgebra::Vector3;

fn direction(along: Vector3<f64>) -> Vector3<f64> {
    along.normalize()
}

fn circle() -> Circle {
    Circle {
        centre_mm: Vector3::new(1.0, 2.0, 3.0),
        diameter_mm: 50.0,
        plane: Plane::Xy,
        turn: TurnDirection::CounterClockwise,
        start_angle_rad: 0.3,
        points: 361,
    }
}

#[test]
fn points_lie_on_the_circle_and_the_path_closes() {
    for plane in [Plane::Xy, Plane::Zx, Plane::Yz] {
        for turn in [TurnDirection::CounterClockwise, TurnDirection::Clockwise] {
            let circle = Circle { plane, turn, ..circle() };
            let path = circle.toolpath().unwrap();
            assert_eq!(path.len(), 361);
            assert_eq!(path.points()[0].position_mm, path.points()[360].position_mm);
            assert!((path.length_mm() - 50.0 * std::f64::consts::PI).abs() < 1e-9);
            let normal = plane.axes()[2];
            for pair in path.points().windows(2) {
                let arm = pair[0].position_mm - circle.centre_mm;
                assert!((arm.norm() - 25.0).abs() < 1e-12 && arm[normal].abs() < 1e-12);
                assert!((pair[0].tangent.norm() - 1.0).abs() < 1e-12);
                assert!(arm.dot(&pair[0].tangent).abs() < 1e-12);
                // The motion goes where the tangent points, and the way round that was asked for.
                assert!((pair[1].position_mm - pair[0].position_mm).dot(&pair[0].tangent) > 0.0);
                let sense = arm.cross(&pair[0].tangent)[normal];
                assert_eq!(sense > 0.0, turn == TurnDirection::CounterClockwise);
            }
        }
    }
}

#[test]
fn a_line_has_both_ends_and_equal_pieces() {
    let (start, end) = (Vector3::new(0.0, 0.0, 1.0), Vector3::new(3.0, 4.0, 1.0));
    let path = Toolpath::line(start, end, Sampling::new(0.01, 2.0).unwrap()).unwrap();
    assert_eq!(path.len(), 4);
    assert_eq!((path.points()[0].position_mm, path.points()[3].position_mm), (start, end));
    assert!(path.points().iter().all(|p| (p.tangent - Vector3::new(0.6, 0.8, 0.0)).norm() < 1e-15));
    assert!((path.length_mm() - 5.0).abs() < 1e-12);
    let path = path.with_feed(600.0).with_spindle(9000.0);
    assert_eq!(path.points()[2].feed_mm_per_min, Some(600.0));
    assert_eq!(path.points()[2].spindle_rev_per_min, Some(9000.0));
}

#[test]
fn wrong_values_are_named() {
    let message = |circle: Circle| circle.toolpath().unwrap_err().to_string();
    assert_eq!(
        message(Circle { diameter_mm: -1.0, ..circle() }),
        "circle: diameter_mm = -1: expected a finite number above 0"
    );
    assert_eq!(message(Circle { points: 3, ..circle() }), "circle: 3 points: expected 4 to 2000000");
    assert_eq!(
        message(Circle { start_angle_rad: f64::INFINITY, ..circle() }),
        "circle: start_angle_rad: expected finite numbers"
    );
    let far = Vector3::new(1e9, 0.0, 0.0);
    assert_eq!(
        Toolpath::line(Vector3::zeros(), far, Sampling::default()).unwrap_err().to_string(),
        "line: 1000000000 mm in pieces of at most 1 mm: expected at most 2000000 points"
    );
}

fn message(source: &str) -> String {
    Polyline::read(source, "path.csv").unwrap_err().to_string()
}

#[test]
fn a_file_with_every_column_is_read_in_any_order() {
    let source = "cutting,z_mm, y_mm ,x_mm,feed_mm_per_min,spindle_rev_per_min,\
        force_x_N,force_y_N,force_z_N,moment_x_Nmm,moment_y_Nmm,moment_z_Nmm\r\n\
        0,3,2,1,100,9000,10,11,12,13,14,15\r\n\r\n1,3,2,4.25,100,9000,10,11,12,13,14,15";
    let polyline = Polyline::read(source, "path.csv").unwrap();
    let points = polyline.toolpath().points();
    assert_eq!(points[0].position_mm, Vector3::new(1.0, 2.0, 3.0));
    assert_eq!([0, 1, 2].map(|segment| polyline.line_of(segment)), [Some(2), Some(4), None]);
    assert_eq!(points.iter().map(|p| p.cutting).collect::<Vec<_>>(), [false, true]);
    assert_eq!(points[1].tangent, Vector3::x());
    assert_eq!(points[1].arc_length_mm, 3.25);
    assert_eq!(points[1].feed_mm_per_min, Some(100.0));
    assert_eq!(points[1].spindle_rev_per_min, Some(9000.0));
    let load = points[1].load.unwrap();
    assert_eq!(load.force_N, Vector3::new(10.0, 11.0, 12.0));
    assert_eq!(load.moment_Nmm, Vector3::new(13.0, 14.0, 15.0));
}

#[test]
fn a_path_begins_along_its_first_move_whichever_way_that_leads() {
    for (x, y, z) in [(-1.0, -1.0, -1.0), (-1.0, -0.1, -0.0), (1.0, 0.0, -1.0), (-0.5, 2.0, 0.0)] {
        let along = Vector3::new(x, y, z);
        let end = along * 2.0 + Vector3::new(0.0, 0.05, 0.05);
        let rows = [Vector3::zeros(), along, end].map(|row| format!("{:?},{:?},{:?}\n", row.x, row.y, row.z)).concat();
        let polyline = Polyline::read(format!("x_mm,y_mm,z_mm\n{rows}"), "path.csv").unwrap();
        let first = polyline.toolpath().points()[0].tangent;
        assert!((first - along.normalize()).norm() < 1e-12, "{along} {first}");
    }
}

#[test]
fn tangents_halve_the_turns_of_curves_and_survive_repeated_points() {
    let source = "x_mm,y_mm,z_mm\n0,0,0\n1,0,0\n1,0,0\n2,0.1,0\n2,1,0\n2,0,0\n";
    let polyline = Polyline::read(source, "path.csv").unwrap();
    let tangents: Vec<_> = polyline.toolpath().points().iter().map(|p| p.tangent).collect();
    let up = direction(Vector3::new(1.0, 0.1, 0.0));
    let half = direction(Vector3::x() + up);
    assert_eq!(tangents, [Vector3::x(), Vector3::x(), half, up, Vector3::y(), -Vector3::y()]);
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    assert_eq!(message(""), "path.csv:1: no points; expected a header and at least one row");
    assert_eq!(message("x_mm,y_mm,z_mm\n"), "path.csv:2: no points; expected a header and at least one row");
    assert_eq!(
        message("x_mm,y_mm,z\n1,2,3\n"),
        "path.csv:1: unknown column `z`; expected x_mm, y_mm, z_mm and any of feed_mm_per_min, \
         spindle_rev_per_min, force_x_N, force_y_N, force_z_N, moment_x_Nmm, moment_y_Nmm, \
         moment_z_Nmm, axis_x, axis_y, axis_z, platform_qw, platform_qx, platform_qy, platform_qz, cutting, \
         external_DRIVE_mm or external_DRIVE_deg"
    );
    assert_eq!(message("x_mm,y_mm,x_mm\n1,2,3\n"), "path.csv:1: second column `x_mm`; expected one");
    assert_eq!(message("x_mm,y_mm\n1,2\n"), "path.csv:1: no column `z_mm`; expected it in every file");
    assert_eq!(
        message("x_mm,y_mm,z_mm,force_y_N\n1,2,3,4\n"),
        "path.csv:1: no column `force_x_N`; expected it with its companions"
    );
    assert_eq!(
        message("x_mm,y_mm,z_mm\r\n\r\n1,2,3\r\n1,2\r\n"),
        "path.csv:4: 2 values; expected 3, as many as columns in the header"
    );
    assert_eq!(
        message("x_mm,y_mm,z_mm\n1,2,3\n1,2;5,3\n"),
        "path.csv:3: y_mm = `2;5`; expected a coordinate in mm, up to 1e6"
    );
    assert_eq!(message("x_mm,y_mm,z_mm,cutting\n1,2,3,yes\n"), "path.csv:2: cutting = `yes`; expected 0 or 1");
    assert_eq!(
        message("x_mm,y_mm,z_mm,feed_mm_per_min\n1,2,3,-5\n"),
        "path.csv:2: feed_mm_per_min = `-5`; expected a feed in mm/min, from 0 to 1e9"
    );
    assert_eq!(
        message("x_mm,y_mm,z_mm\n1,NaN,3\n"),
        "path.csv:2: y_mm = `NaN`; expected a coordinate in mm, up to 1e6"
    );
}

#[test]
fn moves_are_split_as_those_of_a_program() {
    let source = "x_mm,y_mm,z_mm,force_x_N,force_y_N,force_z_N,cutting\n\
                  0,0,9,0,0,0,0\n0,0,0,0,0,0,0\n20,0,0,10,0,4,1\n20,5,0,10,20,4,1\n";
    let polyline = Polyline::read(source, "path.csv").unwrap();
    let path = polyline.sampled(Sampling::new(0.01, 1.0).unwrap()).unwrap();
    assert_eq!(path.len(), 1 + 1 + 20 + 5);
    let points = path.points();
    assert!(points.windows(2).all(|pair| !pair[1].cutting || pair[1].arc_length_mm - pair[0].arc_length_mm < 1.001));
    assert!((points[6].position_mm - Vector3::new(5.0, 0.0, 0.0)).norm() < 1e-12);
    assert!((points[6].load.unwrap().force_N - Vector3::new(2.5, 0.0, 1.0)).norm() < 1e-12);
    assert_eq!(points[6].tangent, Vector3::x());
    assert_eq!((points[6].source.segment, polyline.line_of(points[6].source.segment)), (2, Some(4)));
    // Points of the file stay what they are.
    assert_eq!(points[21], polyline.toolpath().points()[2]);
    let program = "G0 X0 Y0 Z9\nG0 Z0\nG1 X20 F100\nG1 Y5\n";
    let program = GcodeProgram::parse(program, "p.nc", &GcodeOptions::default()).unwrap();
    let same = program.toolpath(Sampling::new(0.01, 1.0).unwrap()).unwrap();
    let apart = |(a, b): (&Vector3<f64>, &Vector3<f64>)| (a - b).norm();
    assert_eq!(same.len(), path.len());
    assert!(same.positions_mm().iter().zip(&path.positions_mm()).map(apart).all(|apart| apart < 1e-12));
}

#[test]
fn too_many_points_are_refused_with_their_line() {
    let polyline = Polyline::read("x_mm,y_mm,z_mm\n0,0,0\n100,0,0\n", "path.csv").unwrap();
    let refused = polyline.sampled(Sampling::new(1e-3, 1e-5).unwrap()).unwrap_err().to_string();
    assert!(refused.starts_with("path.csv:3: "), "{refused}");
}

#[test]
fn a_closed_path_has_the_same_directions_whichever_corner_is_first() {
    let corners = ["0,0,0", "10,0,0", "10,6,0", "0,6,0"];
    let directions = |first: usize| {
        let rows: Vec<&str> = (0..=4).map(|k| corners[(first + k) % 4]).collect();
        let source = format!("x_mm,y_mm,z_mm\n{}\n", rows.join("\n"));
        let path = Polyline::read(source, "path.csv").unwrap().sampled(Sampling::default()).unwrap();
        let (start, end) = (path.points()[0], path.points()[path.len() - 1]);
        assert_eq!(start.tangent, end.tangent);
        let mut all: Vec<[i64; 5]> = path.points()[1..]
            .iter()
            .map(|p| [p.position_mm.x, p.position_mm.y, p.position_mm.z, p.tangent.x, p.tangent.y])
            .map(|values| values.map(|value| (value * 1e9).round() as i64))
            .collect();
        all.sort_unstable();
        all
    };
    for first in 1..4 {
        assert_eq!(directions(first), directions(0));
    }
}

#[test]
fn programs_show_their_dialect() {
    for (source, dialect) in [
        ("0 BEGIN PGM A MM\n", Dialect::Heidenhain),
        ("; post\n  begin pgm 12 INCH\r\n", Dialect::Heidenhain),
        ("%_N_A_MPF\nG0 X1\n", Dialect::Sinumerik),
        ("G1 X=10\n", Dialect::Sinumerik),
        ("N10 G2 X1 Y1 CR = 5\n", Dialect::Sinumerik),
        ("N10 G54 G710\n", Dialect::Sinumerik),
        ("N10 G17 G71 G90\n", Dialect::Sinumerik),
        ("N10 S1=900 M1=3\n", Dialect::Sinumerik),
        ("N10 MSG(\"roughing\")\n", Dialect::Sinumerik),
        ("TRAORI\n", Dialect::Sinumerik),
        ("CYCLE83(50,0,2,-25)\n", Dialect::Sinumerik),
        ("G0 X1 (X=5)\n; MSG(\"x\")\n", Dialect::Iso),
        ("#1=5\n#<depth>=2\nIF [#1 GT 2] GOTO 5\n", Dialect::Iso),
        ("(MSG, hello)\n$J=G91 X1\n", Dialect::Iso),
        ("G1 X1*36\nN5 G28 Z0\n%\n", Dialect::Iso),
        ("__ X_\n", Dialect::Iso),
        ("", Dialect::Iso),
    ] {
        assert_eq!(Dialect::detect(source.as_bytes()), dialect, "{source}");
    }
}

#[test]
fn only_moved_coordinates_change() {
    let source = "\u{feff}z_mm,x_mm, y_mm,feed_mm_per_min\r\n5, 1.50 ,2,1e2\r\n\r\n5,\"3\",4,0200\r\n6,3,4,200";
    let polyline = Polyline::read(source, "path.csv").unwrap();
    let nominal = polyline.toolpath().positions_mm();
    let format = polyline.own_format();
    assert_eq!(format.mm_decimals(), 3);
    assert_eq!(polyline.rewrite(&nominal, format).unwrap(), source.as_bytes());
    let mut moved = nominal;
    moved[0].x += 0.0126;
    moved[0].z += 0.0004;
    moved[1].y -= 4.0001;
    let written = String::from_utf8(polyline.rewrite(&moved, format).unwrap()).unwrap();
    assert_eq!(
        written,
        "\u{feff}z_mm,x_mm, y_mm,feed_mm_per_min\r\n5, 1.513 ,2,1e2\r\n\r\n5,3,0.000,0200\r\n6,3,4,200"
    );
}

#[test]
fn points_between_rows_become_rows_where_the_correction_bends() {
    let source = "x_mm,y_mm,z_mm,feed_mm_per_min,force_x_N,force_y_N,force_z_N,cutting\r\n\
                  0,0,5,900,0,0,0,0\r\n0,0,0, 0300,0,0,0,1\r\n3,0,0,200 ,6,0,0,1\r\n3,2,0,200,6,0,0,1\r\n";
    let polyline = Polyline::read(source, "path.csv").unwrap();
    let path = polyline.sampled(Sampling::default()).unwrap();
    let (nominal, format) = (path.positions_mm(), polyline.own_format());
    assert_eq!(polyline.rewrite_sampled(&path, &nominal, format).unwrap().into_bytes(), source.as_bytes());
    let mut bent = nominal;
    for point in &mut bent[6..9] {
        // Along the second cut only.
        point.y += 0.1 * (point.x - 3.0) * point.x;
    }
    let written = polyline.rewrite_sampled(&path, &bent, format).unwrap();
    let back = written.read_back().unwrap().positions_mm();
    assert_eq!(back.len(), path.len());
    assert!(back.iter().zip(&bent).all(|(a, b)| (a - b).amax() <= 1.001e-3));
    assert_eq!(
        String::from_utf8(written.into_bytes()).unwrap(),
        "x_mm,y_mm,z_mm,feed_mm_per_min,force_x_N,force_y_N,force_z_N,cutting\r\n\
         0,0,5,900,0,0,0,0\r\n0,0,0, 0300,0,0,0,1\r\n\
         1.000,-0.200,0.000,200 ,2,0,0,1\r\n2.000,-0.200,0.000,200 ,4,0,0,1\r\n3,0,0,200 ,6,0,0,1\r\n\
         3,2,0,200,6,0,0,1\r\n"
    );
}

#[test]
fn positions_must_fit_the_path() {
    let polyline = Polyline::read("x_mm,y_mm,z_mm\n1,2,3\n", "path.csv").unwrap();
    let refused =
        |positions: &[Vector3<f64>]| polyline.rewrite(positions, NumberFormat::default()).unwrap_err().to_string();
    assert_eq!(refused(&[]), "0 corrected positions for a path of 1 points: expected one for each point");
    assert_eq!(
        refused(&[Vector3::new(f64::NAN, 0.0, 0.0)]),
        "corrected position 0 is (NaN, 0, 0) mm: expected finite numbers up to 1000000"
    );
}

#[test]
fn a_generated_path_is_read_back_as_it_was() {
    let circle = Circle {
        centre_mm: Vector3::new(1.0, 2.0, 3.0),
        diameter_mm: 8.0,
        plane: Plane::Yz,
        turn: TurnDirection::Clockwise,
        start_angle_rad: 0.0,
        points: 9,
    };
    let path = circle.toolpath().unwrap().with_feed(300.5).with_spindle(8000.0);
    let load = Load { force_N: Vector3::new(1.25, -2.0, 3.0), moment_Nmm: Vector3::zeros() };
    let loaded = path.points().iter().map(|point| PathPoint { load: Some(load), ..*point });
    let path = Toolpath::assemble(loaded.collect());
    let bytes = write(&path, &path.positions_mm(), NumberFormat::new(9, 9).unwrap()).unwrap();
    let back = Polyline::read(bytes, "circle.csv").unwrap();
    for (a, b) in path.points().iter().zip(back.toolpath().points()) {
        assert!((a.position_mm - b.position_mm).amax() <= 0.5e-9 * 1.001);
        assert_eq!((a.feed_mm_per_min, a.load, a.cutting), (b.feed_mm_per_min, b.load, b.cutting));
    }
}

#[test]
fn zero_has_no_sign_and_small_numbers_no_exponent() {
    let path = Polyline::read("x_mm,y_mm,z_mm\n1,2,3\n", "path.csv").unwrap().toolpath().clone();
    let written = |decimals: u8, x: f64, y: f64| {
        let format = NumberFormat::new(decimals, 4).unwrap();
        String::from_utf8(write(&path, &[Vector3::new(x, y, 0.0)], format).unwrap()).unwrap()
    };
    assert_eq!(written(4, -0.00001, -12.34567), "x_mm,y_mm,z_mm\n0.0000,-12.3457,0.0000\n");
    assert_eq!(written(3, -0.0, -0.00051), "x_mm,y_mm,z_mm\n0.000,-0.001,0.000\n");
    assert_eq!(written(9, 1e-7, -1e-10), "x_mm,y_mm,z_mm\n0.000000100,0.000000000,0.000000000\n");
}

#[test]
fn decimals_are_counted_and_kept_in_range() {
    let decimals = |x: &str| {
        let read = Polyline::read(format!("x_mm,y_mm,z_mm\n{x},2,3\n"), "path.csv").unwrap();
        read.own_format().mm_decimals()
    };
    assert_eq!(["-12.34050", "-12.340", "7.", "7", "7.12345678901"].map(decimals), [5, 3, 3, 3, 9]);
    assert_eq!(NumberFormat::of_source(0, 20), NumberFormat::new(3, 9).unwrap());
}
