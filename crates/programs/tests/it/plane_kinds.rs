//! Kinds of inclined planes: PLANE EULER, VECTOR, POINTS, RELATIV and AXIAL, CYCLE800 by the solid angle, against matrices that are multiplied here;
//! and places and angles of ten machines that another hand computed.

use std::collections::BTreeMap;

use kinetostat_programs::{
    WriteOptions,
    gcode::{Dialect, GcodeOptions, GcodeProgram, Rotary, RotaryAxis, RotarySide},
};
use nalgebra::Vector3;

use crate::inclined_planes::{chosen, head, mixed, nutating, options, read, refused, table};

/// Rows of a matrix.
type Rows = [[f64; 3]; 3];

/// The turn by `degrees` about the axis `axis` (0 is x).
fn turn(axis: usize, degrees: f64) -> Rows {
    let (sin, cos) = degrees.to_radians().sin_cos();
    match axis {
        0 => [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]],
        1 => [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]],
        _ => [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]],
    }
}

/// The product of turns, each an axis and degrees.
fn turns(all: &[(usize, f64)]) -> Rows {
    all.iter().fold([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], |so_far, &(axis, degrees)| {
        let next = turn(axis, degrees);
        std::array::from_fn(|row| std::array::from_fn(|column| (0..3).map(|k| so_far[row][k] * next[k][column]).sum()))
    })
}

/// Where `at` of a plane about (1, 2, 3) is.
fn placed(plane: &Rows, at: [f64; 3]) -> Vector3<f64> {
    Vector3::from_fn(|row, _| (row + 1) as f64 + (0..3).map(|k| plane[row][k] * at[k]).sum::<f64>())
}

/// A program that goes to (7, 5, 6) of the plane that `lines` incline about the datum (1, 2, 3).
fn program(lines: &str) -> String {
    format!(
        "0 BEGIN PGM P MM\n1 CYCL DEF 7.0 DATUM SHIFT\n2 CYCL DEF 7.1 X+1\n3 CYCL DEF 7.2 Y+2\n4 CYCL DEF 7.3 Z+3\n{lines}\n\
         6 L X+4 Y+5 R0 FMAX\n7 L Z+6 FMAX\n8 L X+7 F99\n9 PLANE RESET STAY\n10 END PGM P MM\n"
    )
}

fn tip(source: &str, rotary: Rotary, dialect: Dialect) -> Vector3<f64> {
    read(source, rotary, dialect).1.points().last().unwrap().position_mm
}

/// Columns by x and a vector on the side of y, made square to each other one after the other.
fn columns(x: [f64; 3], beside: [f64; 3]) -> Rows {
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    let unit = |a: [f64; 3]| a.map(|part| part / dot(a, a).sqrt());
    let x = unit(x);
    let y = unit(std::array::from_fn(|k| beside[k] - x[k] * dot(x, beside)));
    std::array::from_fn(|k| [x[k], y[k], x[(k + 1) % 3] * y[(k + 2) % 3] - x[(k + 2) % 3] * y[(k + 1) % 3]])
}

#[test]
fn each_kind_of_plane_is_what_its_manual_says() {
    let spatial = [(2, 20.0), (1, 30.0), (0, 10.0)];
    let of_vectors = columns([0.8, -0.4, -0.08 / 0.92], [0.4, 0.9, -0.2]);
    let normal = of_vectors.map(|row| row[2] * 1.7);
    let vectors =
        format!("BX0.8 BY-0.4 BZ{:.9} NX{:.9} NY{:.9} NZ{:.9}", -0.08 / 0.92, normal[0], normal[1], normal[2]);
    for (lines, plane) in [
        // The block of Heidenhain, iTNC 530 User's Manual DIN/ISO, 6/2010, p. 392: about z, about x turned by it, about z turned by both.
        ("5 PLANE EULER EULPR45 EULNU20 EULROT22 TURN FMAX".to_owned(), turns(&[(2, 45.0), (0, 20.0), (2, 22.0)])),
        // TNC 620 User's Manual, 10/2017, p. 548: the base vector is along x, the normal vector along z, of any length.
        (format!("5 PLANE VECTOR {vectors} MOVE DIST50 F1000"), of_vectors),
        // p. 549: x from the first point to the second, y towards the third.
        (
            "5 PLANE POINTS P1X+0 P1Y+0 P1Z+20 P2X+30 P2Y+31 P2Z+20 P3X+0 P3Y+41 P3Z+32.5 TURN F500 SEQ-".to_owned(),
            columns([30.0, 31.0, 0.0], [0.0, 41.0, 12.5]),
        ),
        // A plane on the side of the part.
        ("5 PLANE VECTOR BX0 BY1 BZ0 NX1 NY0 NZ0 TURN FMAX".to_owned(), columns([0.0, 1.0, 0.0], [0.0, 0.0, 1.0])),
        // About the axes of W where no plane is in force, else about those of the plane, one after the other.
        ("5 PLANE RELATIV SPB-45 TURN FMAX".to_owned(), turn(1, -45.0)),
        (
            "5 PLANE SPATIAL SPA+10 SPB+30 SPC+20 TURN FMAX\n5 PLANE RELATIV SPA-35 STAY\n5 PLANE RELATIV SPC+70 TURN FMAX".to_owned(),
            turns(&[spatial[0], spatial[1], spatial[2], (0, -35.0), (2, 70.0)]),
        ),
        // The same angle back gives the plane before.
        (
            "5 PLANE SPATIAL SPA+10 SPB+30 SPC+20 STAY\n5 PLANE RELATIV SPB-45 TURN FMAX\n5 PLANE RELATIV SPB+45 TURN FMAX"
                .to_owned(),
            turns(&spatial),
        ),
    ] {
        for rotary in [table(None), head(), mixed()] {
            let (found, expected) = (tip(&program(&lines), rotary, Dialect::Heidenhain), placed(&plane, [7.0, 5.0, 6.0]));
            // The vectors have nine decimals.
            assert!((found - expected).norm() < 3e-8, "{lines}: {found} {expected}");
        }
    }
    // The solid angle: about z, then about the new y.
    let swivelled =
        "G90 G17 G710\nCYCLE800(0,\"TC1\",0,64,1,2,3,25,40,,,,,1)\nG0 X4 Y5\nG0 Z6\nG1 X7 F99\nCYCLE800()\nM30\n";
    let expected = placed(&turns(&[(2, 25.0), (1, 40.0)]), [7.0, 5.0, 6.0]);
    assert!((tip(swivelled, nutating(), Dialect::Sinumerik) - expected).norm() < 1e-9);
    // P0 says that the angles of G68.2 are Euler's.
    let [plain, with_p] = ["", " P0"].map(|p| {
        let source = format!("G21 G90\nG68.2{p} X1 Y2 Z3 I45 J20 K22\nG53.1\nG0 X4 Y5\nG0 Z6\nG1 X7 F99\nM30\n");
        tip(&source, head(), Dialect::Fanuc)
    });
    assert!((plain - placed(&turns(&[(2, 45.0), (0, 20.0), (2, 22.0)]), [7.0, 5.0, 6.0])).norm() < 1e-9);
    assert_eq!(plain, with_p);
}

#[test]
fn plane_axial_turns_the_axes_that_it_names_and_its_plane_with_them() {
    for (rotary, words, angles, plane) in [
        (head(), "B-45", [0.0, -45.0, 0.0], turn(1, -45.0)),
        (head(), "B+30 C+0", [0.0, 30.0, 0.0], turn(1, 30.0)),
        // Table A turns the part by 30 about -x: seen from the part, the plane leans by 30 about x.
        (table(None), "A+30", [30.0, 0.0, 0.0], turn(0, 30.0)),
        (mixed(), "B+0", [0.0; 3], turn(0, 0.0)),
    ] {
        let turning = program(&format!("5 PLANE AXIAL {words} TURN FMAX TABLE ROT"));
        assert_eq!(chosen(&turning, rotary.clone(), Dialect::Heidenhain), angles, "{words}");
        let expected = placed(&plane, [7.0, 5.0, 6.0]);
        assert!((tip(&turning, rotary.clone(), Dialect::Heidenhain) - expected).norm() < 1e-9, "{words}");
        // With STAY a line of its own turns them, by numbers or by what PLANE has found.
        for by in [words.to_owned(), format!("{0}+Q{1}", &words[..1], 119 + words.as_bytes()[0] - b'A' + 1)] {
            let staying = program(&format!("5 PLANE AXIAL {words} STAY\n5 L {by} R0 FMAX"));
            let found = tip(&staying, rotary.clone(), Dialect::Heidenhain);
            assert!((found - expected).norm() < 1e-9, "{words} {by}: {found}");
        }
    }
    for (rotary, lines, expected) in [
        (
            head(),
            "5 PLANE AXIAL C+30 TURN FMAX",
            "PLANE AXIAL by one axis at a right angle to the tool, the others at 0",
        ),
        (head(), "5 PLANE AXIAL B+30 C+30 TURN FMAX", "by one axis at a right angle"),
        (head(), "5 L C+30 R0 FMAX\n5 PLANE AXIAL B+30 TURN FMAX", "by one axis at a right angle"),
        (nutating(), "5 PLANE AXIAL B+30 TURN FMAX", "by one axis at a right angle"),
        (head(), "5 PLANE AXIAL A+30 TURN FMAX", "PLANE AXIAL with axes that the machine has"),
        (head(), "5 PLANE AXIAL IB+30 TURN FMAX", "expected its own parameters with numbers"),
        (head(), "5 PLANE AXIAL TURN FMAX", "expected A, B or C"),
        (table(Some([-10.0, 90.0])), "5 PLANE AXIAL A-45 TURN FMAX", "within their travel"),
        (
            table(Some([-10.0, 90.0])),
            "5 PLANE AXIAL A-20 STAY\n5 L A+Q120 R0 FMAX",
            "parameters, variables and expressions",
        ),
    ] {
        let said = refused(&program(lines), rotary, Dialect::Heidenhain);
        assert!(said.contains(expected), "{lines}: {said}");
    }
}

#[test]
fn values_of_parameters_are_put_into_any_kind_of_plane() {
    let lines = "5 Q1 = +20\n5 Q2 = 45\n5 PLANE EULER EULPRQ2 EULNU+Q1 EULROT22 TURN FMAX";
    let source = program(lines);
    let read =
        GcodeProgram::parse_expanded(source, "part.h", &options(head(), Dialect::Heidenhain), &|_| None).unwrap();
    let path = read.toolpath(kinetostat_programs::Sampling::default()).unwrap();
    let expected = placed(&turns(&[(2, 45.0), (0, 20.0), (2, 22.0)]), [7.0, 5.0, 6.0]);
    assert!((path.points().last().unwrap().position_mm - expected).norm() < 1e-9);
}

#[test]
fn what_is_written_in_a_plane_of_any_kind_leads_to_the_corrected_places() {
    for lines in [
        "5 PLANE VECTOR BX0.8 BY0.6 BZ0 NX-0.3 NY0.4 NZ0.9 TURN FMAX",
        "5 PLANE POINTS P1X+0 P1Y+0 P1Z+20 P2X+30 P2Y+31 P2Z+20 P3X+0 P3Y+41 P3Z+32.5 TURN F500",
        "5 PLANE SPATIAL SPA+10 SPB+30 SPC+20 TURN FMAX\n5 PLANE RELATIV SPA-35 TURN FMAX",
        "5 PLANE AXIAL B+30 TURN FMAX",
    ] {
        let source = program(lines);
        let (program, path) = read(&source, head(), Dialect::Heidenhain);
        let same =
            program.rewrite(&path, &path.positions_mm(), WriteOptions::with_decimals(program.own_format())).unwrap();
        assert_eq!(String::from_utf8_lossy(same.bytes()), source);
        let moved: Vec<Vector3<f64>> =
            path.positions_mm().iter().map(|at| at + Vector3::new(0.03, -0.02, 0.05)).collect();
        let written = program.rewrite(&path, &moved, WriteOptions::with_decimals(program.own_format())).unwrap();
        let text = String::from_utf8_lossy(written.bytes()).into_owned();
        assert!(text.contains(lines), "{text}");
        let (_, there) = read(&text, head(), Dialect::Heidenhain);
        let (last, expected) = (there.points().last().unwrap().position_mm, moved.last().unwrap());
        assert!((last - expected).amax() < 0.001, "{last} {expected}\n{text}");
    }
}

#[test]
fn planes_whose_definition_is_not_certain_are_refused_by_line() {
    for (words, expected) in [
        // The signs of its angles are in figures alone.
        (
            "PROJECTED PROPR+24 PROMIN+24 ROT+30 TURN FMAX",
            "expected PLANE SPATIAL, EULER, VECTOR, POINTS, RELATIV, AXIAL or RESET",
        ),
        // The numbers of the manual's own example are at no right angle.
        ("VECTOR BX0.8 BY-0.4 BZ-0.42 NX0.2 NY0.2 NZ0.92 TURN FMAX", "BX, BY and BZ at a right angle to NX, NY and NZ"),
        ("VECTOR BX0 BY0 BZ0 NX0.2 NY0.2 NZ0.92 TURN FMAX", "BX, BY and BZ at a right angle to NX, NY and NZ"),
        ("VECTOR BX1 BY0 BZ0 NX0 NY0 TURN FMAX", "BX, BY and BZ at a right angle to NX, NY and NZ"),
        ("POINTS P1X+0 P1Y+0 P1Z+0 P2X+1 P2Y+1 P2Z+1 P3X+3 P3Y+3 P3Z+3 TURN FMAX", "three points on no line"),
        ("POINTS P1X+0 P1Y+0 P1Z+0 P2X+0 P2Y+0 P2Z+0 P3X+3 P3Y+3 P3Z+3 TURN FMAX", "three points on no line"),
        ("EULER EULPR45 EULNU20 TURN FMAX", "expected EULPR, EULNU and EULROT"),
        ("EULER EULPR45 EULNU20 EULROT22 EULNU20 TURN FMAX", "a second one in the block"),
        ("RELATIV SPA+10 SPB+10 TURN FMAX", "expected one of SPA, SPB and SPC"),
        ("RELATIV SPB+10", "expected TURN, MOVE or STAY"),
        ("EULER SPA+10 SPB+0 SPC+0 TURN FMAX", "expected its own parameters with numbers"),
    ] {
        let said = refused(&program(&format!("5 PLANE {words}")), head(), Dialect::Heidenhain);
        assert!(said.contains(expected), "{words}: {said}");
    }
    for p in ["P1 Q123", "P2 Q1", "P3 Q1", "P4"] {
        let said = refused(&format!("G21 G90\nG68.2 {p} X0 Y0 Z0 I10 J0 K0\nM30\n"), head(), Dialect::Fanuc);
        assert!(said.contains("expected G68.2 X Y Z I J K in G90, with no other parameters"), "{p}: {said}");
    }
    for arguments in [
        "0,\"TC1\",0,128,0,0,0,10,20,0,0,0,0,1",
        "0,\"TC1\",0,192,0,0,0,10,20,0,0,0,0,1",
        "0,\"TC1\",0,64,0,0,0,10,20,5,0,0,0,1",
    ] {
        let said = refused(&format!("G90\nCYCLE800({arguments})\nM30\n"), head(), Dialect::Sinumerik);
        assert!(said.contains("expected _MODE axis by axis, such as 57, or 64"), "{arguments}: {said}");
    }
}

/// The machines of `tests/five_axis_poses/axes.csv`.
fn machines() -> BTreeMap<&'static str, Rotary> {
    let mut machines = BTreeMap::<_, Rotary>::new();
    for line in include_str!("../five_axis_poses/axes.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |at: usize| cells[at].parse::<f64>().unwrap();
        machines.entry(cells[0]).or_default().axes.push(RotaryAxis {
            letter: cells[1].chars().next().unwrap(),
            about: Vector3::new(number(3), number(4), number(5)).normalize(),
            turns: if cells[2] == "tool" { RotarySide::Tool } else { RotarySide::Workpiece },
            through_mm: Some(Vector3::new(number(6), number(7), number(8))),
            travel_deg: Some([number(9), number(10)]),
        });
    }
    machines
}

/// `tests/oracles/five_axis.py --poses` computes them by Rodrigues' rotations of one axis after the other; its kinematics are held against LinuxCNC's.
#[test]
fn ten_machines_stand_where_a_second_implementation_has_them_and_find_its_angles() {
    let machines = machines();
    assert_eq!(machines.len(), 10);
    let (mut found, mut beyond) = (0, 0);
    for line in include_str!("../five_axis_poses/poses.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let vector = |at: usize| Vector3::from_fn(|k, _| cells[at + k].parse::<f64>().unwrap());
        let (rotary, angles) = (&machines[cells[0]], vector(1).into());
        assert!((rotary.tip_position(vector(4), &angles) - vector(7)).norm() < 2e-9, "{line}");
        assert!((rotary.head_position(vector(7), &angles) - vector(4)).norm() < 2e-9, "{line}");
        assert!((rotary.tool_axis(&angles) - vector(10)).norm() < 2e-9, "{line}");
        let from: String = rotary
            .axes
            .iter()
            .map(|axis| format!("{0}{1} ", axis.letter, angles[usize::from(axis.letter as u8 - b'A')]))
            .collect();
        let (rule, [first, second, third]) = (cells[13], [14, 15, 16].map(|at| cells[at]));
        let (source, dialect) = match rule {
            "G53.1" => (
                format!("G21 G90\nG0 {from}\nG68.2 X0 Y0 Z0 I{first} J{second} K{third}\nG53.1\nM30\n"),
                Dialect::Fanuc,
            ),
            "_DIR 1" | "_DIR -1" => (
                format!(
                    "G90\nG0 {from}\nCYCLE800(0,\"TC1\",0,27,0,0,0,{third},{second},{first},0,0,0,{})\nM30\n",
                    &rule[5..]
                ),
                Dialect::Sinumerik,
            ),
            _ => (
                format!(
                    "0 BEGIN PGM P MM\n1 L {from} R0 FMAX\n2 PLANE SPATIAL SPA{first} SPB{second} SPC{third} TURN FMAX {rule}\n3 END PGM P MM\n"
                ),
                Dialect::Heidenhain,
            ),
        };
        let options = GcodeOptions { rotary: rotary.clone(), dialect: Some(dialect), ..GcodeOptions::default() };
        match (GcodeProgram::parse(source, "part.nc", &options), cells[17].is_empty()) {
            (Ok(program), false) => {
                let own = Vector3::from(program.notes().chosen_angles[0].1);
                assert!((own - vector(17)).amax() < 2e-6, "{line}: {own}");
                found += 1;
            }
            (Err(said), true) => {
                assert!(
                    said.to_string().contains("cannot turn the tool along z of the inclined plane"),
                    "{line}: {said}"
                );
                beyond += 1;
            }
            (Ok(program), true) => panic!("{line}: {:?}", program.notes().chosen_angles),
            (Err(said), false) => panic!("{line}: {said}"),
        }
    }
    assert!(found > 250 && beyond > 10, "{found} {beyond}");
}
