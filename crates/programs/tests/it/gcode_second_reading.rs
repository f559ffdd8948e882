//! Random programs, read by the library and by a reader of its own.

use crate::support::cases::cases;
use crate::support::rs274::{self, Step};
use kinetostat_programs::{
    Sampling, WriteOptions,
    gcode::{Calls, GcodeOptions, GcodeProgram},
};
use proptest::prelude::*;

/// What one line or a few lines of a program do, and the numbers in it.
type Part = (u8, [i32; 6]);

fn parts() -> impl Strategy<Value = Vec<Part>> {
    prop::collection::vec((0u8..18, prop::array::uniform6(-20_000i32..20_000)), 3..24)
}

/// Numbers of three decimals.
fn number(value: i32) -> String {
    format!("{:.3}", f64::from(value) / 1000.0)
}

/// A quarter, a half or a full turn that steps from where the tool is: exact in decimals. The axes are those of the plane.
fn arc(turn: u32, n: [i32; 6]) -> String {
    let (plane, [u, v, w], [i, j]) =
        [(17, ['X', 'Y', 'Z'], ['I', 'J']), (18, ['Z', 'X', 'Y'], ['K', 'I']), (19, ['Y', 'Z', 'X'], ['J', 'K'])]
            [n[0].unsigned_abs() as usize % 3];
    let r = if n[1] == 0 { 1000 } else { n[1] };
    // From the centre, the start is at −r along u.
    let up = if turn == 2 { r } else { -r };
    let ends = match n[2].rem_euclid(4) {
        0 => format!("{u}{} {v}{} {i}{} {j}0", number(r), number(up), number(r)),
        1 => format!("{u}{} {i}{}", number(2 * r), number(r)),
        2 => format!("{i}{}", number(r)),
        _ => format!("{u}{} {v}{} R{}", number(r), number(up), number(r.abs())),
    };
    let rise = if n[3] % 2 == 0 { format!(" {w}{}", number(n[3])) } else { String::new() };
    format!("G{plane} G91 G{turn} {ends}{rise}\nG17 G90\n")
}

/// A program whose lines all mean something; with subprograms if `calls`.
fn program(parts: &[Part], calls: bool) -> String {
    let mut text = "G10 L2 P1 X0 Y0 Z0\nG10 L2 P2 X10 Y-5 Z1.5\nG21 G90 G54 F100\nG0 X0 Y0 Z30\n".to_owned();
    let (mut steps, mut shifted, mut local) = (false, false, false);
    for (kind, n) in parts {
        let [a, b, c, d, e, _] = n.map(number);
        let back = if steps { "G91\n" } else { "G90\n" };
        match kind {
            0 => text += &format!("G0 X{a} Y{b} Z{c}\n"),
            1 => text += &format!("g1x{a}(a comment)y{b} F200\n"),
            2 => text += &format!("N7 Z{a} G1\nX{b}\nY{c} ; {d}\n"),
            3 => steps = !steps,
            4 | 5 => text += &(arc(2, *n) + back),
            6 | 7 => text += &(arc(3, *n) + back),
            8 => text += if n[0] % 2 == 0 { "G20\n" } else { "G21\n" },
            9 if !local => {
                shifted = true;
                text += &format!("G92 X{a} Z{c}\n");
            }
            10 if shifted => {
                shifted = false;
                text += "G92.1\n";
            }
            11 if !shifted => {
                local = true;
                text += &format!("G52 X{a} Y{b} Z{c}\n");
            }
            12 if local => {
                local = false;
                text += "G52 X0 Y0 Z0\n";
            }
            13 => text += if n[0] % 2 == 0 { "G54\n" } else { "G55\n" },
            14 => text += &format!("G90 G10 L2 P{} X{a} Z{c}\n{back}", 1 + n[1].rem_euclid(2)),
            15 | 16 => {
                let code = [81, 82, 85, 89][n[0].rem_euclid(4) as usize];
                let dwell = if code == 82 || code == 89 { " P0.5" } else { "" };
                let deep = number(n[5].rem_euclid(9000) + 1);
                text += &match steps {
                    true => format!(
                        "G98 G{code} X{a} Y{b} R-{d1} Z-{deep}{dwell} L{l}\nG80\n",
                        d1 = deep,
                        l = n[1].rem_euclid(3) + 1
                    ),
                    false => format!(
                        "G{g} G{code} X{a} Y{b} R{r} Z-{deep}{dwell}\nX{d}\nG98 Y{e}\nG80\n",
                        g = 98 + n[2].rem_euclid(2),
                        r = number(n[3].rem_euclid(9000))
                    ),
                };
                text += "G0 X1\n";
            }
            17 if calls => text += &format!("M98 P{} L{}\n", 100 + n[0].rem_euclid(2), 1 + n[1].rem_euclid(3)),
            _ => {}
        }
        text += if *kind == 3 && steps {
            "G91\n"
        } else if *kind == 3 {
            "G90\n"
        } else {
            ""
        };
    }
    text += "M30\n";
    if calls {
        text += "O100\nG1 X1.5 Y2\nM98 P101\nM99\nO101\nG0 Z2.5\nG1 Z0.25\nM99\n";
    }
    text
}

/// Corners of what is moved, each once.
fn corners(steps: &[Step]) -> Vec<[f64; 3]> {
    let mut corners = Vec::new();
    for step in steps {
        match step {
            Step::Hole { up, over, clear, bottom, back, stops } => {
                corners.extend([*up, *over, *clear, *bottom]);
                corners.extend(stops.then_some(*clear));
                corners.push(*back);
            }
            _ => corners.push(step.at(1.0)),
        }
    }
    once(corners)
}

fn once(places: impl IntoIterator<Item = [f64; 3]>) -> Vec<[f64; 3]> {
    let mut kept: Vec<[f64; 3]> = Vec::new();
    for place in places {
        if kept.last().is_none_or(|last| (0..3).any(|k| (last[k] - place[k]).abs() > 1e-6)) {
            kept.push(place);
        }
    }
    kept
}

/// Rounding of sums of coordinates, mm.
const ROUNDING_MM: f64 = 1e-9;
/// What nine decimals of an inch leave, a few times over, mm.
const AS_WRITTEN_MM: f64 = 2e-7;

fn is_close(a: [f64; 3], b: [f64; 3], within_mm: f64) -> bool {
    (0..3).all(|k| (a[k] - b[k]).abs() <= within_mm)
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn programs_move_as_a_second_reader_says(parts in parts()) {
        let text = program(&parts, false);
        let steps = rs274::read(&text);
        let program = GcodeProgram::parse(text.as_bytes(), "random.nc", &GcodeOptions::default()).unwrap();
        let path = program.toolpath(Sampling::new(0.05, 1e6).unwrap()).unwrap();
        let mut holes = 0;
        for point in path.points() {
            let step = &steps[point.source.segment];
            let expected = match step {
                Step::Hole { over, clear, bottom, back, .. } => {
                    holes += 1;
                    [*over, *clear, *bottom, *back][(holes - 1) % 4]
                }
                step => step.at(point.source.parameter),
            };
            prop_assert!(is_close(point.position_mm.into(), expected, ROUNDING_MM), "{:?} {expected:?}\n{text}", point.position_mm);
        }
        prop_assert_eq!(path.points().last().map(|point| point.source.segment + 1), Some(steps.len()));
        let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
        prop_assert_eq!(same.bytes(), text.as_bytes());
    }

    #[test]
    fn programs_written_out_move_as_a_second_reader_says(parts in parts()) {
        let text = program(&parts, true);
        let expected = corners(&rs274::read(&text));
        let none = |_: &str| None;
        let program = GcodeProgram::parse_expanded(text.as_bytes(), "random.nc", &GcodeOptions::default(), &none).unwrap();
        let path = program.toolpath(Sampling::new(0.05, 1e6).unwrap()).unwrap();
        let ends = path.points().iter().filter(|point| point.source.parameter == 1.0);
        let ends = once(ends.map(|point| point.position_mm.into()));
        prop_assert_eq!(ends.len(), expected.len(), "{}", text);
        for (end, expected) in ends.iter().zip(expected) {
            prop_assert!(is_close(*end, expected, AS_WRITTEN_MM), "{end:?} {expected:?}\n{text}");
        }
        let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
        prop_assert_eq!(same.bytes(), program.source());
        let with_calls = GcodeProgram::parse_with_calls(text.as_bytes(), "random.nc", &GcodeOptions::default(), &none).unwrap();
        let path = with_calls.toolpath(Sampling::new(0.05, 1e6).unwrap()).unwrap();
        let same = with_calls.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
        let stays = Calls::Stay { program: text.clone().into_bytes(), beside: Vec::new() };
        prop_assert_eq!(with_calls.folded_calls(&same), Some(stays));
        let written_out = String::from_utf8_lossy(program.source()).replace("G80", "");
        prop_assert!(!written_out.contains("G8") && !written_out.contains("M98"), "{}", written_out);
    }
}
