//! Programs of many styles, read, moved and written back.

use crate::support::programs::programs_in;
use kinetostat_programs::{
    NumberFormat, Rewritten, Sampling, Toolpath, WriteOptions,
    gcode::{ArcCentres, Dialect, GcodeOptions, GcodeProgram, LengthUnit, WorkOffset},
};
use nalgebra::Vector3;

/// Every program in `tests/gcode` and `tests/dialects`, with its name.
fn programs() -> Vec<(String, Vec<u8>)> {
    let folders = ["tests/gcode", "tests/dialects/sinumerik", "tests/dialects/heidenhain"].map(programs_in);
    assert!(folders.iter().all(|programs| programs.len() >= 10));
    folders.concat()
}

fn options() -> GcodeOptions {
    let mut options = GcodeOptions::default();
    for (name, zero) in [
        ("G55", [100.0, -20.0, 3.5]),
        ("G59.1", [80.0, 1.0, 0.0]),
        ("G54.1 P7", [-5.0, 0.0, 0.25]),
        ("G15 H3", [40.0, 0.0, 0.0]),
        ("G505", [7.0, 8.0, -1.0]),
        ("G599", [0.0, 0.5, 0.0]),
        ("G500", [-300.0, -200.0, 9.0]),
        ("preset 1", [0.0, 0.0, 1.0]),
        ("preset 2", [70.0, 0.0, 0.5]),
    ] {
        options.work_offsets_mm.insert(name.parse::<WorkOffset>().unwrap(), Vector3::from(zero));
    }
    options.work_offsets_mm.insert("G56".parse::<WorkOffset>().unwrap(), Vector3::zeros());
    options
}

/// Those whose lines may become several: of the pen's E nobody says how it is shared out (`split_words`).
fn divisible_programs() -> impl Iterator<Item = (String, Vec<u8>)> {
    programs().into_iter().filter(|(name, _)| name != "pen_plotter.gcode")
}

fn sampling() -> Sampling {
    Sampling::new(0.005, 2.0).unwrap()
}

fn parse(name: &str, source: &[u8]) -> (GcodeProgram, Toolpath) {
    // Whose G10 L20 it is does not show.
    let dialect = (name == "offsets_g10.nc").then_some(Dialect::LinuxCnc);
    let program =
        GcodeProgram::parse(source, name, &GcodeOptions { dialect, ..options() }).unwrap_or_else(|e| panic!("{e}"));
    let path = program.toolpath(sampling()).unwrap();
    (program, path)
}

/// The program with `correction` added at every point, and the largest difference, per coordinate, between where the
/// written program goes and where it should.
fn moved(
    program: &GcodeProgram,
    path: &Toolpath,
    format: NumberFormat,
    correction: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> (Rewritten<GcodeProgram>, f64) {
    let goals: Vec<_> = path.positions_mm().into_iter().map(|p| p + correction(p)).collect();
    let written = program.rewrite(path, &goals, WriteOptions::with_decimals(format)).unwrap();
    let back = written.read_back().unwrap_or_else(|e| panic!("{e}\n{}", text(&written)));
    assert_eq!(back.len(), path.len(), "{}\n{}", program.name(), text(&written));
    let off = back.positions_mm().iter().zip(&goals).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
    (written, off)
}

fn text(written: &Rewritten<GcodeProgram>) -> String {
    String::from_utf8_lossy(written.bytes()).into_owned()
}

/// The largest step of the last written decimal in any program, mm: five decimals of an inch, four of a mm.
const LAST_PLACE_MM: f64 = 2.54e-4;

#[test]
fn without_correction_the_bytes_are_the_same() {
    for (name, source) in programs() {
        let (program, path) = parse(&name, &source);
        assert!(path.len() > 5, "{name} has {} points", path.len());
        for format in [NumberFormat::default(), program.own_format(), NumberFormat::new(1, 1).unwrap()] {
            let (written, off) = moved(&program, &path, format, |_| Vector3::zeros());
            assert_eq!(written.bytes(), source, "{name}\n{}", text(&written));
            assert!(off < 1e-9, "{name}: {off}");
        }
    }
}

#[test]
fn a_correction_below_the_last_decimal_changes_nothing() {
    for (name, source) in programs() {
        let (program, path) = parse(&name, &source);
        let (written, _) = moved(&program, &path, NumberFormat::default(), |p| p.map(|c| 4e-5 * c.signum()));
        assert_eq!(written.bytes(), source, "{name}\n{}", text(&written));
    }
}

#[test]
fn a_constant_shift_moves_every_point_by_it() {
    for (name, source) in programs() {
        let (program, path) = parse(&name, &source);
        let shift = Vector3::new(0.0123, -0.2, 0.05);
        let (written, off) = moved(&program, &path, NumberFormat::default(), |_| shift);
        assert!(off <= LAST_PLACE_MM, "{name}: {off}\n{}", text(&written));
        assert_ne!(written.bytes(), source, "{name}");
    }
}

#[test]
fn a_constant_shift_splits_no_block() {
    for (name, source) in programs() {
        let (program, path) = parse(&name, &source);
        let (written, _) = moved(&program, &path, NumberFormat::default(), |_| Vector3::new(0.5, 0.25, -0.125));
        let lines = |bytes: &[u8]| bytes.iter().filter(|b| matches!(b, b'\n' | b'\r')).count();
        assert_eq!(lines(written.bytes()), lines(&source), "{name}\n{}", text(&written));
    }
}

#[test]
fn a_varying_correction_is_met_at_every_point_to_the_last_decimal() {
    let bend =
        |p: Vector3<f64>| Vector3::new((0.11 * p.y).sin(), (0.07 * p.x + 0.3).cos(), (0.05 * (p.x + p.y)).sin()) * 0.3;
    for (name, source) in divisible_programs() {
        let (program, path) = parse(&name, &source);
        for (format, last_place) in [
            (NumberFormat::default(), LAST_PLACE_MM),
            (NumberFormat::new(2, 3).unwrap(), 2.54e-2),
            (NumberFormat::new(7, 7).unwrap(), 2.54e-6),
        ] {
            let (written, off) = moved(&program, &path, format, bend);
            assert!(off <= last_place, "{name}: {off}\n{}", text(&written));
        }
    }
}

#[test]
fn comments_and_lines_without_motion_survive() {
    let bend = |p: Vector3<f64>| Vector3::new(0.0, (0.2 * p.x).sin(), (0.3 * p.y).cos()) * 0.4;
    for (name, source) in divisible_programs() {
        let (program, path) = parse(&name, &source);
        let (written, _) = moved(&program, &path, NumberFormat::default(), bend);
        let mut rest = written.bytes();
        for comment in comments(&source, program.notes().dialect) {
            let at = rest.windows(comment.len()).position(|window| window == comment);
            let at = at.unwrap_or_else(|| panic!("{name}: {:?}", String::from_utf8_lossy(comment)));
            rest = &rest[at + comment.len()..];
        }
        assert_eq!(source.ends_with(b"\n"), written.bytes().ends_with(b"\n"), "{name}");
        let crlf = source.windows(2).any(|pair| pair == b"\r\n");
        for (at, byte) in written.bytes().iter().enumerate().filter(|(_, b)| **b == b'\n') {
            assert_eq!(at > 0 && written.bytes()[at - 1] == b'\r', crlf, "{name} {byte}");
        }
    }
}

/// The comments of a program, in order, with their marks.
fn comments(source: &[u8], dialect: Dialect) -> Vec<&[u8]> {
    let mut comments = Vec::new();
    for line in source.split(|b| matches!(b, b'\r' | b'\n')) {
        let mut at = 0;
        while at < line.len() {
            let length = match line[at] {
                b'"' if dialect == Dialect::Sinumerik => line[at + 1..].iter().position(|b| *b == b'"').unwrap() + 2,
                b'(' if dialect == Dialect::Iso => line[at..].iter().position(|b| *b == b')').unwrap() + 1,
                b';' => line.len() - at,
                _ => 0,
            };
            if length > 0 {
                comments.push(&line[at..at + length]);
            }
            at += length.max(1);
        }
    }
    comments
}

#[test]
fn arc_points_lie_on_their_arcs() {
    let cases: [(&str, [usize; 2], [f64; 2], f64); 3] = [
        ("arcs_xy_g17.nc", [0, 1], [0.0, 0.0], 25.0),
        ("arcs_zx_g18.nc", [2, 0], [0.0, 0.0], 10.0),
        ("arcs_yz_g19.nc", [1, 2], [0.0, 0.0], 8.0),
    ];
    for (name, [a, b], centre, radius) in cases {
        let source = programs().into_iter().find(|(n, _)| n == name).unwrap().1;
        let (_, path) = parse(name, &source);
        let on_arc: Vec<_> = path
            .points()
            .iter()
            .map(|point| (point.position_mm[a] - centre[0], point.position_mm[b] - centre[1]))
            .filter(|(u, v)| (u.hypot(*v) - radius).abs() < 1e-9)
            .collect();
        assert!(on_arc.len() > 20, "{name}: {}", on_arc.len());
        for pair in on_arc.windows(2) {
            let middle = f64::hypot(pair[0].0 + pair[1].0, pair[0].1 + pair[1].1) / 2.0;
            let chord = f64::hypot(pair[0].0 - pair[1].0, pair[0].1 - pair[1].1);
            assert!(radius - middle <= 0.005 + 1e-9 && chord <= 2.0 + 1e-9, "{name}");
        }
    }
}

#[test]
fn tangents_are_unit_and_point_along_the_motion() {
    for (name, source) in programs() {
        let (_, path) = parse(&name, &source);
        let mut length = 0.0;
        for pair in path.points().windows(2) {
            assert!((pair[1].tangent.norm() - 1.0).abs() < 1e-12, "{name}");
            assert!(pair[1].arc_length_mm >= length, "{name}");
            length = pair[1].arc_length_mm;
            let step = pair[1].position_mm - pair[0].position_mm;
            let known = pair[1].arc_length_mm > pair[0].arc_length_mm;
            if known && step.norm() > 1e-9 {
                let step = step.normalize();
                assert!(step.dot(&pair[1].tangent) > 0.9, "{name} {pair:?}");
            }
        }
    }
}

fn rewritten(source: &str, correction: impl Fn(Vector3<f64>) -> Vector3<f64>, sampling: Sampling) -> String {
    let program = GcodeProgram::parse(source, "test.nc", &options()).unwrap();
    let path = program.toolpath(sampling).unwrap();
    let (written, _) = moved(&program, &path, NumberFormat::new(2, 3).unwrap(), correction);
    text(&written)
}

/// Bends so that no piece stays straight.
fn wave(p: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(0.0, 0.0, if (p.x / 5.0).round() % 2.0 == 0.0 { 0.5 } else { -0.5 })
}

#[test]
fn a_split_block_keeps_its_first_line_and_moves_what_acts_at_its_end() {
    let source = "G21 G90\nG0 X0 Y0 Z0\nN7 G01 X15 F200 S900 M3 M9 (cut) ; on\nG2 X20 Y-5 I0 J-5\nX15 Y-10 I-5 J0\n";
    let coarse = Sampling::new(10.0, 5.0).unwrap();
    assert_eq!(
        rewritten(source, wave, coarse),
        "G21 G90\nG0 X0 Y0 Z0.50\nN7 G01 X5.00 Z-0.50 F200 S900 M3 (cut) ; on\nX10.00 Z0.50\nX15 Z-0.50 M9\n\
         G1 X18.54 Y-1.46 Z0.50\nX20 Y-5\nX18.54 Y-8.54\nX15 Y-10 Z-0.50\n"
    );
}

#[test]
fn words_of_a_coordinate_that_is_not_corrected_keep_their_text_when_a_block_is_split() {
    let coarse = Sampling::new(10.0, 5.0).unwrap();
    let bend = |p: Vector3<f64>| Vector3::new(0.0, if (p.x / 5.0).round() % 2.0 == 0.0 { 0.5 } else { -0.5 }, 0.0);
    for (moves, written) in [
        // A height that stays is said once; one that changes is reached by its own word, evenly as before.
        ("G1 X10 Z-1.5 F200", "G1 X5.00 Y-0.50 Z-1.5 F200\nX10 Y0.50"),
        ("g1x10z0.5", "g1x3.33y-0.50z-0.83\nx6.67z-0.17\nx10y0.50z0.5"),
        ("G1 X10 Z-1.535", "G1 X3.33 Y-0.50 Z-1.51\nX6.67 Z-1.52\nX10 Y0.50 Z-1.535"),
        ("G91 G1 X10 Z0", "G91 G1 X5.00 Y-1.00 Z0\nX5.00 Y1.00"),
    ] {
        let source = format!("G21 G90\nG0 X0 Y0 Z-1.5\n{moves}\n");
        let kept = rewritten(&source, bend, coarse);
        assert_eq!(kept, format!("G21 G90\nG0 X0 Y0.50 Z-1.5\n{written}\n"), "{moves}");
    }
}

#[test]
fn parameters_stay_with_the_word_they_belong_to() {
    let coarse = Sampling::new(10.0, 5.0).unwrap();
    for (line, split) in [
        ("G1 X10 F200 M9 P2", "G1 X5.00 Z-0.50 F200\nX10 Z0.50 M9 P2"),
        ("G1 X10 F200 M7 P2", "G1 X5.00 Z-0.50 F200 M7 P2\nX10 Z0.50"),
        ("G64 P0.1 G1 X10 M5", "G64 P0.1 G1 X5.00 Z-0.50\nX10 Z0.50 M5"),
    ] {
        let written = rewritten(&format!("G21 G90\nG0 X0 Y0 Z0\n{line}\n"), wave, coarse);
        assert_eq!(written, format!("G21 G90\nG0 X0 Y0 Z0.50\n{split}\n"));
    }
}

#[test]
fn a_motion_word_comes_back_for_lines_that_rely_on_it() {
    let source = "G21G90\nG00X0Y0Z0\nG02X10Y0I5J0F200\nX20I5J0\n";
    let coarse = Sampling::new(10.0, 100.0).unwrap();
    // The first arc is bent, the second only moved.
    let bend = |p: Vector3<f64>| Vector3::new(0.0, 0.0, if p.x < 9.0 { 0.1 * p.x } else { 1.0 });
    assert_eq!(rewritten(source, bend, coarse), "G21G90\nG00X0Y0Z0\nG01X5.00Y5.00Z0.50F200\nX10Y0Z1.00\nG02X20I5J0\n");
}

#[test]
fn incremental_steps_lead_from_where_rounding_has_led() {
    let source = "G21 G90\nG0 X0 Y0 Z0\nG91\nG1 X1 F100\nX1\nX1\nX1\nX1\nX1\nG90 X10\n";
    let coarse = Sampling::new(10.0, 100.0).unwrap();
    let stretch = |p: Vector3<f64>| Vector3::new(p.x / 300.0 * 1.3, 0.0, 0.0);
    assert_eq!(
        rewritten(source, stretch, coarse),
        "G21 G90\nG0 X0 Y0 Z0\nG91\nG1 X1 F100\nX1.01\nX1\nX1.01\nX1\nX1.01\nG90 X10.04\n"
    );
}

#[test]
fn block_delete_marks_stay_on_every_line_of_their_block() {
    let source = "G21 G90\nG0 X0 Y0 Z0\n /2 G1 X10 F100\n/G28 Z0\n";
    let coarse = Sampling::new(10.0, 5.0).unwrap();
    assert_eq!(
        rewritten(source, wave, coarse),
        "G21 G90\nG0 X0 Y0 Z0.50\n /2 G1 X5.00 Z-0.50 F100\n /2X10 Z0.50\n/G28 Z0\n"
    );
}

#[test]
fn what_comes_before_a_known_place_stays_and_is_named() {
    let (name, source) = programs().into_iter().find(|(name, _)| name == "unknown_start.nc").unwrap();
    let (program, path) = parse(&name, &source);
    assert_eq!(program.notes().unlocated_lines, [4, 5, 6, 11]);
    assert_eq!(path.points()[0].position_mm, Vector3::new(0.0, 0.0, -1.0));
    let (written, _) = moved(&program, &path, NumberFormat::default(), |_| Vector3::new(0.5, 0.0, 0.25));
    let text = text(&written);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[3..8],
        [
            "G1 X12. F300",
            "G91 G1 Y2.",
            "G90 G0 X0. Y0.",
            "G1 X0.5000 Z-0.7500 F100 (now Z as well)",
            "G1 X20.5000 F300"
        ]
    );
    assert_eq!(lines[10..12], ["G0 X5. Y5. (left as it is)", "G0 X5.5000 Z2.2500"]);
}

#[test]
fn a_unit_that_is_not_said_is_noted() {
    let unit = |source: &str, options: &GcodeOptions| {
        GcodeProgram::parse(source, "part.nc", options).unwrap().notes().assumed_unit
    };
    let millimetre = Some((LengthUnit::Millimetre, 2));
    assert_eq!(unit("M3\nG0 X0 Y0 Z0\n", &GcodeOptions::default()), millimetre);
    assert_eq!(unit("G21\nG0 X0 Y0 Z0\n", &GcodeOptions::default()), None);
    let given = GcodeOptions { unit: Some(LengthUnit::Inch), ..GcodeOptions::default() };
    assert_eq!(unit("M3\nG0 X0 Y0 Z0\n", &given), None);
}

#[test]
fn a_zero_said_of_a_corrected_place_moves_with_the_correction() {
    let source = "G21 G90\nG0 X0 Y0 Z0\nG1 X10 F9\nG92 X0 Y5\nX10\nG92.1\nX5\n";
    let coarse = Sampling::new(10.0, 100.0).unwrap();
    assert_eq!(
        rewritten(source, |p| Vector3::new(0.01 * p.x, 0.0, 0.0), coarse),
        "G21 G90\nG0 X0 Y0 Z0\nG1 X10.10 F9\nG92 X0.10 Y5\nX10.20\nG92.1\nX5.05\n"
    );
}

#[test]
fn offsets_of_the_program_place_its_parts() {
    let ends = |name: &str| {
        let source = programs().into_iter().find(|(n, _)| n == name).unwrap().1;
        parse(name, &source)
            .1
            .points()
            .iter()
            .filter(|p| p.source.parameter == 1.0)
            .map(|p| p.position_mm)
            .collect::<Vec<_>>()
    };
    let at = Vector3::new;
    assert_eq!(
        ends("offsets_g10.nc")[4..],
        [
            at(100.0, 10.0, 5.0),
            at(100.0, 10.0, -0.5),
            at(120.0, 13.0, -0.5),
            at(128.0, 13.0, -0.5),
            at(128.0, 13.0, 5.5)
        ]
    );
    assert_eq!(
        ends("origin_g92.nc"),
        [
            at(10.0, 10.0, 4.0),
            at(10.0, 10.0, -1.0),
            at(20.0, 10.0, -1.0),
            at(20.0, 30.0, -1.0),
            at(35.0, 30.0, -1.0),
            at(35.0, 42.0, -1.0),
            at(35.0, 42.0, 5.0)
        ]
    );
    assert_eq!(ends("local_g52.nc")[1..4], [at(40.0, -10.0, 5.0), at(40.0, -10.0, -1.0), at(50.0, -7.0, -1.0)]);
}

#[test]
fn feed_by_time_is_shared_among_the_lines_of_a_block() {
    let source = "G21 G90\nG0 X0 Y0 Z0\nG93 G1 X15 F2.5\n";
    let program = GcodeProgram::parse(source, "part.nc", &options()).unwrap();
    let path = program.toolpath(Sampling::new(10.0, 5.0).unwrap()).unwrap();
    assert_eq!(path.points()[1].feed_mm_per_min, Some(37.5));
    assert_eq!(
        rewritten(source, wave, Sampling::new(10.0, 5.0).unwrap()),
        "G21 G90\nG0 X0 Y0 Z0.50\nG93 G1 X5.00 Z-0.50 F7.5\nX10.00 Z0.50 F7.5\nX15 Z-0.50 F7.5\n"
    );
}

#[test]
fn feed_by_turn_needs_the_turns() {
    let path = parse("a.nc", b"G0 X0 Y0 Z0\nG95 S500 G1 X5 F0.5\nG96 S80 X6\n").1;
    assert_eq!(path.points()[1].feed_mm_per_min, Some(250.0));
    assert_eq!(path.points().last().unwrap().feed_mm_per_min, None);
    assert_eq!(path.points().last().unwrap().spindle_rev_per_min, None);
}

#[test]
fn centres_can_be_absolute_from_the_start() {
    let options = GcodeOptions { arc_centres: ArcCentres::Absolute, ..GcodeOptions::default() };
    let program = GcodeProgram::parse("G0 X10 Y0 Z0\nG3 X0 Y10 I0 J0 F9\n", "part.nc", &options).unwrap();
    let path = program.toolpath(sampling()).unwrap();
    assert!(path.points().iter().all(|p| (p.position_mm.norm() - 10.0).abs() < 1e-9));
}
