//! Inclined planes of Fanuc, Heidenhain and Sinumerik: where the tip goes, which angles the control chooses, and what is written.

use kinetostat_programs::{
    Orientation, Sampling, Toolpath, WriteOptions,
    gcode::{Dialect, GcodeOptions, GcodeProgram, Rotary, RotaryAxis, RotarySide},
};
use nalgebra::Vector3;

fn axis(letter: char, about: [f64; 3], turns: RotarySide, travel_deg: Option<[f64; 2]>) -> RotaryAxis {
    let through_mm = Some(Vector3::new(3.0, -7.0, if turns == RotarySide::Tool { 180.0 } else { -50.0 }));
    RotaryAxis { letter, about: Vector3::from(about).normalize(), turns, through_mm, travel_deg }
}

/// A table A-C whose positive angles turn the tool, seen from the part, right-handed.
pub(crate) fn table(travel_of_a: Option<[f64; 2]>) -> Rotary {
    let axes = vec![
        axis('A', [-1.0, 0.0, 0.0], RotarySide::Workpiece, travel_of_a),
        axis('C', [0.0, 0.0, -1.0], RotarySide::Workpiece, None),
    ];
    Rotary { axes, always_of_tip: false }
}

pub(crate) fn head() -> Rotary {
    let axes =
        vec![axis('C', [0.0, 0.0, 1.0], RotarySide::Tool, None), axis('B', [0.0, 1.0, 0.0], RotarySide::Tool, None)];
    Rotary { axes, always_of_tip: false }
}

/// A head B on a table C.
pub(crate) fn mixed() -> Rotary {
    let axes = vec![
        axis('B', [0.0, 1.0, 0.0], RotarySide::Tool, None),
        axis('C', [0.0, 0.0, -1.0], RotarySide::Workpiece, None),
    ];
    Rotary { axes, always_of_tip: false }
}

/// A head whose B is inclined by 45 degrees.
pub(crate) fn nutating() -> Rotary {
    let axes =
        vec![axis('C', [0.0, 0.0, 1.0], RotarySide::Tool, None), axis('B', [0.0, 1.0, 1.0], RotarySide::Tool, None)];
    Rotary { axes, always_of_tip: false }
}

pub(crate) fn options(rotary: Rotary, dialect: Dialect) -> GcodeOptions {
    GcodeOptions { rotary, dialect: Some(dialect), ..GcodeOptions::default() }
}

pub(crate) fn read(source: &str, rotary: Rotary, dialect: Dialect) -> (GcodeProgram, Toolpath) {
    let program = GcodeProgram::parse(source, "part.nc", &options(rotary, dialect)).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    (program, path)
}

pub(crate) fn refused(source: &str, rotary: Rotary, dialect: Dialect) -> String {
    GcodeProgram::parse(source, "part.nc", &options(rotary, dialect)).unwrap_err().to_string()
}

pub(crate) fn chosen(source: &str, rotary: Rotary, dialect: Dialect) -> [f64; 3] {
    let (program, _) = read(source, rotary, dialect);
    program.notes().chosen_angles[0].1
}

#[test]
fn the_tip_goes_where_the_inclined_plane_has_it_on_any_machine() {
    // About x by 30 degrees: y' is (0, cos, sin), z' is (0, -sin, cos).
    let source = "G21 G90 G17\nG0 X0 Y0 Z50\nG68.2 X10 Y20 Z5 I0 J30 K0\nG53.1\nG0 X0 Y0\nG0 Z2\nG1 Z-4 F200\nY10\n\
                  G2 X0 Y30 R10\nG81 X5 Y0 Z-3 R1\nG80\nG69\nG0 X0 Y0 Z80\nM30\n";
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let tip = |x: f64, y: f64, z: f64| Vector3::new(10.0 + x, 20.0 + y * cos - z * sin, 5.0 + y * sin + z * cos);
    for rotary in [table(None), head(), mixed(), nutating()] {
        let (program, path) = read(source, rotary, Dialect::Fanuc);
        let at = |line: usize| {
            let point = path.points().iter().rev().find(|point| program.line_of(point.source.segment) == Some(line));
            *point.unwrap_or_else(|| panic!("nothing in line {line}"))
        };
        for (line, expected) in
            [(6, tip(0.0, 0.0, 2.0)), (7, tip(0.0, 0.0, -4.0)), (8, tip(0.0, 10.0, -4.0)), (9, tip(0.0, 30.0, -4.0))]
        {
            assert!((at(line).position_mm - expected).norm() < 1e-9, "{line}: {}", at(line).position_mm);
            let Some(Orientation::ToolAxis(axis)) = at(line).orientation else { panic!("{line}") };
            assert!((axis - Vector3::new(0.0, -sin, cos)).norm() < 1e-9, "{line}: {axis}");
        }
        // Half a circle about (0, 20) of the plane, over its side of negative x.
        assert!((path.length_mm() - path.points().iter().fold(0.0, |_, p| p.arc_length_mm)).abs() < 1e-9);
        let middle = path.points().iter().filter(|point| program.line_of(point.source.segment) == Some(9));
        let on_circle = |p: Vector3<f64>| ((p - tip(0.0, 20.0, -4.0)).norm() - 10.0).abs() < 1e-9;
        assert!(middle.clone().count() > 5 && middle.clone().all(|point| on_circle(point.position_mm)));
        let left = middle.fold(f64::MAX, |least, point| point.position_mm.x.min(least));
        assert!((left - 0.0).abs() < 0.1, "{left}");
        // The hole goes along z of the plane.
        let hole: Vec<Vector3<f64>> = path
            .points()
            .iter()
            .filter(|point| program.line_of(point.source.segment) == Some(10) && point.cutting)
            .map(|point| point.position_mm)
            .collect();
        assert!(hole.iter().any(|at| (at - tip(5.0, 0.0, -3.0)).norm() < 1e-9), "{hole:?}");
        assert!(hole.iter().all(|at| (at - tip(5.0, 0.0, -3.0)).cross(&Vector3::new(0.0, -sin, cos)).norm() < 1e-9));
        // Behind its end the coordinates are those of before.
        assert_eq!(program.notes().unlocated_lines, [5]);
    }
}

#[test]
fn what_is_written_leads_to_the_corrected_places() {
    let source = "G21 G90 G17\nG0 X0 Y0 Z50\nG68.2 X10 Y20 Z5 I20 J30 K-15\nG53.1\nG0 X0 Y0\nG0 Z2\nG1 Z-4 F200\nX10 Y10\n\
                  G2 X20 Y20 R10\nG81 X5 Y0 Z-3 R1\nG80\nG69\nG0 X0 Y0 Z80\nM30\n";
    for rotary in [table(None), head(), mixed(), nutating()] {
        let (program, path) = read(source, rotary.clone(), Dialect::Fanuc);
        let same =
            program.rewrite(&path, &path.positions_mm(), WriteOptions::with_decimals(program.own_format())).unwrap();
        assert_eq!(String::from_utf8_lossy(same.bytes()), source);
        let shift = Vector3::new(0.03, -0.02, 0.05);
        let moved: Vec<Vector3<f64>> = path.positions_mm().iter().map(|at| at + shift).collect();
        let written = program.rewrite(&path, &moved, WriteOptions::with_decimals(program.own_format())).unwrap();
        let text = String::from_utf8_lossy(written.bytes()).into_owned();
        assert!(text.contains("G68.2 X10 Y20 Z5 I20 J30 K-15\nG53.1\nG0 X0 Y0\n"), "{text}");
        let (_, there) = read(&text, rotary, Dialect::Fanuc);
        assert_eq!(there.len(), path.len());
        for (at, expected) in there.points().iter().zip(&moved) {
            // Half a unit of three decimals along each axis.
            assert!((at.position_mm - expected).amax() < 0.001, "{} {expected}\n{text}", at.position_mm);
        }
    }
}

#[test]
fn arcs_about_a_centre_stay_arcs_in_an_inclined_plane() {
    let source = "BEGIN PGM A MM\nTOOL CALL 1 Z S100 F200\nL X+0 Y+0 Z+50 R0 FMAX\n\
                  PLANE SPATIAL SPA+20 SPB+30 SPC+10 TURN FMAX SEQ+\nL X+0 Y+0 Z+5 FMAX\nL Z-4\nCC X+10 Y+0\n\
                  C X+10 Y+10 DR-\nPLANE RESET STAY\nEND PGM A MM\n";
    for rotary in [table(None), head(), mixed(), nutating()] {
        let (program, path) = read(source, rotary.clone(), Dialect::Heidenhain);
        let moved: Vec<Vector3<f64>> = path.positions_mm().iter().map(|at| at + Vector3::new(0.3, -0.2, 0.5)).collect();
        let written = program.rewrite(&path, &moved, WriteOptions::with_decimals(program.own_format())).unwrap();
        let text = String::from_utf8_lossy(written.bytes()).into_owned();
        assert_eq!(text.lines().count(), source.lines().count(), "{text}");
        let (_, there) = read(&text, rotary, Dialect::Heidenhain);
        for (at, expected) in there.points().iter().zip(&moved) {
            assert!((at.position_mm - expected).amax() < 0.001, "{} {expected}\n{text}", at.position_mm);
        }
    }
}

#[test]
fn each_control_chooses_by_its_rule() {
    let plane =
        |words: &str| format!("0 BEGIN PGM P MM\n1 TOOL CALL 1 Z S100\n2 PLANE SPATIAL {words}\n3 END PGM P MM\n");
    // The table of the iTNC 530 manual for a table A-C, SPA+0 SPB+45 SPC+0.
    for (travel, words, expected) in [
        (None, "SPA+0 SPB+45 SPC+0 TURN FMAX", Ok([45.0, 0.0, 90.0])),
        (None, "SPA+0 SPB+45 SPC+0 TURN FMAX SEQ+", Ok([45.0, 0.0, 90.0])),
        (None, "SPA+0 SPB+45 SPC+0 TURN FMAX SEQ-", Ok([-45.0, 0.0, -90.0])),
        (None, "SPA+0 SPB+45 SPC+0 TURN MB MAX FMAX SEQ- TABLE ROT", Ok([-45.0, 0.0, -90.0])),
        (Some([-90.0, 10.0]), "SPA+0 SPB+45 SPC+0 TURN FMAX", Ok([-45.0, 0.0, -90.0])),
        (Some([-90.0, 10.0]), "SPA+0 SPB+45 SPC+0 TURN FMAX SEQ+", Err(())),
    ] {
        match expected {
            Ok(angles) => assert_eq!(chosen(&plane(words), table(travel), Dialect::Heidenhain), angles, "{words}"),
            Err(()) => {
                let said = refused(&plane(words), table(travel), Dialect::Heidenhain);
                assert!(said.contains("cannot turn the tool along z of the inclined plane"), "{said}");
            }
        }
    }
    // Fanuc: the first axis by the least way, then the second.
    let fanuc = |before: &str| format!("G21 G90\nG0 {before}\nG68.2 X0 Y0 Z0 I90 J45 K-90\nG53.1\nM30\n");
    assert_eq!(chosen(&fanuc("A0 C0"), table(None), Dialect::Fanuc)[0].abs(), 45.0);
    assert_eq!(chosen(&fanuc("A10 C0"), table(None), Dialect::Fanuc), [45.0, 0.0, 90.0]);
    assert_eq!(chosen(&fanuc("A-10 C0"), table(None), Dialect::Fanuc), [-45.0, 0.0, -90.0]);
    assert_eq!(chosen(&fanuc("A0 C200"), table(None), Dialect::Fanuc), [-45.0, 0.0, 270.0]);
    assert_eq!(chosen(&fanuc("A0 C500"), table(Some([0.0, 90.0])), Dialect::Fanuc), [45.0, 0.0, 450.0]);
    // Of one axis each of tool and table the table's.
    assert_eq!(chosen(&fanuc("B0 C10"), mixed(), Dialect::Fanuc), [0.0, 45.0, 0.0]);
    assert_eq!(chosen(&fanuc("B0 C170"), mixed(), Dialect::Fanuc), [0.0, -45.0, 180.0]);
    // Sinumerik: the lower or the higher of the angles of rotary axis 1.
    let sinumerik = |direction: i32| format!("G90 G17\nCYCLE800(0,\"TC1\",0,57,0,0,0,0,45,0,0,0,0,{direction})\nM30\n");
    assert_eq!(chosen(&sinumerik(1), table(None), Dialect::Sinumerik), [45.0, 0.0, 90.0]);
    assert_eq!(chosen(&sinumerik(-1), table(None), Dialect::Sinumerik), [-45.0, 0.0, -90.0]);
    assert_eq!(chosen(&sinumerik(-1), table(Some([-5.0, 110.0])), Dialect::Sinumerik), [45.0, 0.0, 90.0]);
    assert_eq!(chosen(&sinumerik(-1), mixed(), Dialect::Sinumerik), [0.0, -45.0, 180.0]);
}

#[test]
fn a_plane_across_the_axis_of_the_table_leaves_it_where_it_is() {
    for rotary in [table(None), head(), mixed()] {
        let angles = chosen("G21 G90\nG0 C25\nG68.2 X0 Y0 Z0 I40 J0 K0\nG53.1\nM30\n", rotary, Dialect::Fanuc);
        assert_eq!(angles, [0.0, 0.0, 25.0]);
    }
}

#[test]
fn planes_of_heidenhain_and_sinumerik_are_those_of_fanuc() {
    let tip = |source: &str, dialect| {
        let (_, path) = read(source, head(), dialect);
        path.points().last().unwrap().position_mm
    };
    // Rz(20) Ry(30) Rx(10), and the same as turns about z, the new x and the new z, worked out from its third column and row.
    let (sx, cx) = 10f64.to_radians().sin_cos();
    let (sy, cy) = 30f64.to_radians().sin_cos();
    let (sz, cz) = 20f64.to_radians().sin_cos();
    let z = Vector3::new(cz * sy * cx + sz * sx, sz * sy * cx - cz * sx, cy * cx);
    let (i, j) = (z.x.atan2(-z.y).to_degrees(), z.z.acos().to_degrees());
    let k = (-sy).atan2(cy * sx).to_degrees();
    let fanuc = format!("G21 G90\nG68.2 X1 Y2 Z3 I{i:.12} J{j:.12} K{k:.12}\nG53.1\nG0 X4 Y5\nG0 Z6\nG1 X7 F99\nM30\n");
    let heidenhain = "0 BEGIN PGM P MM\n1 CYCL DEF 7.0 DATUM SHIFT\n2 CYCL DEF 7.1 X+1\n3 CYCL DEF 7.2 Y+2\n4 CYCL DEF 7.3 Z+3\n\
                      5 PLANE SPATIAL SPA+10 SPB+30 SPC+20 TURN FMAX\n6 L X+4 Y+5 R0 FMAX\n7 L Z+6 FMAX\n8 L X+7 F99\n\
                      9 PLANE RESET STAY\n10 END PGM P MM\n";
    // About x by A, about the new y by B, about the new z by C; here about y alone.
    let sinumerik =
        "G90 G17 G710\nCYCLE800(0,\"TC1\",0,57,1,2,3,0,30,0,4,5,0,1)\nG0 X0 Y0\nG0 Z6\nG1 X3 F99\nCYCLE800()\nM30\n";
    let expected = Vector3::new(1.0, 2.0, 3.0)
        + Vector3::new(cz * cy, sz * cy, -sy) * 7.0
        + Vector3::new(cz * sy * sx - sz * cx, sz * sy * sx + cz * cx, cy * sx) * 5.0
        + z * 6.0;
    assert!((tip(&fanuc, Dialect::Fanuc) - expected).norm() < 1e-9, "{}", tip(&fanuc, Dialect::Fanuc));
    assert!((tip(heidenhain, Dialect::Heidenhain) - expected).norm() < 1e-9);
    let about_y = Vector3::new(1.0 + cy * 7.0 + sy * 6.0, 7.0, 3.0 - sy * 7.0 + cy * 6.0);
    assert!((tip(sinumerik, Dialect::Sinumerik) - about_y).norm() < 1e-9);
    // In another order the angles stand in that order: 90 about y, then 30 about the new x.
    let in_order = "G90 G17 G710\nCYCLE800(0,\"TC1\",0,54,0,0,0,90,30,0,0,0,0,1)\nG0 X0 Y0\nG0 Z6\nG1 X3 Y2 F99\nCYCLE800()\nM30\n";
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let at = Vector3::new(2.0 * sin + 6.0 * cos, 2.0 * cos - 6.0 * sin, -3.0);
    assert!((tip(in_order, Dialect::Sinumerik) - at).norm() < 1e-9, "{}", tip(in_order, Dialect::Sinumerik));
}

#[test]
fn angles_that_plane_has_found_turn_the_tool_as_it_would() {
    let program = |turn: &str, move_to: &str| {
        format!(
            "0 BEGIN PGM P MM\n1 Q1 = +30\n2 L X+0 Y+0 Z+50 R0 FMAX\n3 PLANE SPATIAL SPA+10 SPB+Q1 SPC+20 {turn}\n{move_to}5 L X+4 Y+5 R0 FMAX\n\
             6 L Z+6 FMAX\n7 L X+7 F99\n8 PLANE RESET STAY\n9 END PGM P MM\n"
        )
    };
    let read = |source: &str| {
        let read =
            GcodeProgram::parse_expanded(source, "part.h", &options(table(None), Dialect::Heidenhain), &|_| None);
        let program = read.unwrap_or_else(|error| panic!("{error}"));
        let path = program.toolpath(Sampling::default()).unwrap();
        (program.notes().chosen_angles[0].1, path.points().last().unwrap().position_mm)
    };
    for rule in ["SEQ+", "SEQ-", ""] {
        let turned = read(&program(&format!("TURN FMAX {rule}"), ""));
        for lines in ["4 L A+Q120 C+Q122 R0 FMAX\n", "4 L C+Q122 R0 FMAX\n4 L A+Q120 R0 FMAX\n"] {
            assert_eq!(read(&program(&format!("STAY {rule}"), lines)), turned, "{rule}{lines}");
        }
    }
    // Of one axis alone, the tool does not stand along the plane; before PLANE nothing is found.
    for (turn, lines, expected) in [
        ("STAY", "4 L A+Q120 R0 FMAX\n", "beside z of the inclined plane"),
        ("TURN FMAX\n3 PLANE RESET STAY", "4 L A+Q120 C+Q122 R0 FMAX\n", "parameters, variables and expressions"),
    ] {
        let source = program(turn, lines);
        let said =
            GcodeProgram::parse_expanded(source, "part.h", &options(table(None), Dialect::Heidenhain), &|_| None);
        let said = said.map(GcodeProgram::into_source).expect_err("expected a refusal").to_string();
        assert!(said.contains(expected), "{lines}: {said}");
    }
}

#[test]
fn what_is_not_certain_of_an_inclined_plane_is_refused() {
    let fanuc = |lines: &str| refused(&format!("G21 G90\nG0 X0 Y0 Z50\n{lines}\nM30\n"), table(None), Dialect::Fanuc);
    let plane = "G68.2 X0 Y0 Z0 I0 J30 K0";
    for (lines, expected) in [
        (format!("{plane}\nG0 X1 Y1 Z1"), "stands 30.000 degrees beside z of the inclined plane; expected before it"),
        ("G53.1".into(), "where there is none; expected G68.2 before"),
        (format!("{plane}\nG53.1 X1"), "`G53.1`: coordinate on a line with G53.1"),
        (format!("{plane}\nG53.1 P1"), "`P1`: parameter that belongs to no word"),
        (format!("{plane} P1"), "expected G68.2 X Y Z I J K in G90, with no other parameters"),
        (format!("G91\n{plane}"), "expected G68.2 X Y Z I J K in G90, with no other parameters"),
        (format!("{plane}\n{plane}"), "not followed in an inclined plane"),
        (format!("{plane}\nG53.1\nG55"), "`G55`: not followed in an inclined plane"),
        (format!("{plane}\nG53.1\nG52 X3"), "`G52`: not followed in an inclined plane"),
        (format!("{plane}\nG53.1\nG43.4 H1"), "`G43.4`: not followed in an inclined plane"),
        (format!("G43.4 H1\n{plane}"), "not followed in an inclined plane"),
        (format!("{plane}\nG53.1\nG0 X1 Y1 Z1\nG1 X2 C20 F9"), "moves and turns the tool in an inclined plane"),
        (format!("G52 X3\n{plane}"), "about a zero that G52, G92 or TRANS has shifted"),
        (format!("G28 A0 C0\n{plane}\nG53.1"), "the position of A is not known"),
    ] {
        let said = fanuc(&lines);
        assert!(said.contains(expected), "{lines}: {said}");
    }
    // Angles that the program gives itself need no rule of a control.
    let own = format!("G21 G90\nG0 X0 Y0 Z50\nG0 A30 C0\n{plane}\nG0 X1 Y1 Z1\nG1 X2 F9\nM30\n");
    assert!(GcodeProgram::parse(own, "part.nc", &options(table(None), Dialect::Fanuc)).is_ok());
    // Deselecting the swivel data may retract: what follows comes from nowhere known.
    let (program, _) = read(
        "G90 G710\nG0 X0 Y0 Z0\nCYCLE800(1,\"0\",0,57,0,0,0,0,0,0,0,0,0,1)\nG1 X5 F9\nM30\n",
        head(),
        Dialect::Sinumerik,
    );
    assert_eq!(program.notes().unlocated_lines, [4]);
    let said = refused(&format!("G21 G90\n{plane}\n"), Rotary::default(), Dialect::Fanuc);
    assert!(said.contains("no rotary axes are known; expected a machine with drives A, B or C"), "{said}");
    for dialect in [Dialect::Haas, Dialect::LinuxCnc] {
        let said = refused(&format!("G21 G90\n{plane}\n"), table(None), dialect);
        assert!(said.contains("polar, scaled or rotated coordinates are not supported"), "{said}");
    }
    let sinumerik =
        |arguments: &str| refused(&format!("G90\nCYCLE800({arguments})\nM30\n"), table(None), Dialect::Sinumerik);
    for (arguments, expected) in [
        ("0,\"TC1\",1,57,0,0,0,0,45,0,0,0,0,1", "expected a new plane, _ST 0 or 10"),
        ("0,\"TC1\",0,192,0,0,0,0,45,0,0,0,0,1", "expected _MODE axis by axis"),
        ("0,\"TC1\",0,57,0,0,0,0,R1,0,0,0,0,1", "expected plain numbers"),
        ("0,\"TC1\",0,57,0,0,0,0,45,0,0,0,0,2", "expected _DIR -1, 0 or 1"),
    ] {
        let said = sinumerik(arguments);
        assert!(said.contains(expected), "{arguments}: {said}");
    }
    let heidenhain = |words: &str| {
        refused(&format!("0 BEGIN PGM P MM\n1 PLANE {words}\n2 END PGM P MM\n"), table(None), Dialect::Heidenhain)
    };
    for (words, expected) in [
        ("SPATIAL SPA+0 SPB+45 TURN FMAX", "expected SPA, SPB and SPC"),
        ("SPATIAL SPA+0 SPB+45 SPC+0", "expected TURN, MOVE or STAY"),
        (
            "SPATIAL SPA+0 SPB+0 SPC+30 TURN FMAX TABLE ROT",
            "no TABLE ROT where z of the plane is the axis of the table",
        ),
        ("SPATIAL SPA+0 SPB+45 SPC+0 TURN FMAX TABLE", "expected its own parameters with numbers"),
        ("SPATIAL SPA+Q1 SPB+45 SPC+0 TURN FMAX", "parameters, variables and expressions"),
    ] {
        let said = heidenhain(words);
        assert!(said.contains(expected), "{words}: {said}");
    }
}
