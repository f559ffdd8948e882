//! Cutter radius compensation written out as the path of the tool centre: closed forms, distances from the contour, other dialects, refusals.

use std::collections::BTreeMap;

use kinetostat_programs::{
    Sampling,
    gcode::{CutterOf, Dialect, GcodeError, GcodeOptions, GcodeProgram},
};
use proptest::prelude::*;

use crate::support::cases::cases;

fn options(dialect: Dialect, radius: f64) -> GcodeOptions {
    let radii = BTreeMap::from([(CutterOf::Offset(1), radius), (CutterOf::Tool(3), radius)]);
    GcodeOptions { dialect: Some(dialect), cutter_radii_mm: Some(radii), ..GcodeOptions::default() }
}

fn read(source: &str, dialect: Dialect, radius: f64) -> Result<GcodeProgram, GcodeError> {
    GcodeProgram::parse_expanded(source, "part.nc", &options(dialect, radius), &|_| None)
}

/// The lines of `source` with the path of the centre, without the header.
fn written(source: &str, radius: f64) -> Vec<String> {
    let program = read(source, Dialect::Fanuc, radius).unwrap_or_else(|error| panic!("{error}\n{source}"));
    let text = String::from_utf8(program.into_source()).unwrap();
    text.lines().filter(|line| !line.starts_with('(')).map(str::to_owned).collect()
}

fn refused(source: &str) -> String {
    read(source, Dialect::Fanuc, 5.0).map(GcodeProgram::into_source).expect_err("expected a refusal").to_string()
}

/// Points of the motions in the lines of `source` from `first` on up to `last`, every 0.05 mm.
fn points(source: &str, dialect: Dialect, radius: f64, [first, last]: [usize; 2]) -> Vec<[f64; 2]> {
    let program = read(source, dialect, radius).unwrap_or_else(|error| panic!("{error}\n{source}"));
    let sampling = Sampling::new(1e-4, 0.05).unwrap();
    let path = program.toolpath(sampling).unwrap();
    let line = |segment: usize| program.line_of(segment).unwrap_or_default();
    let inside = path.points().iter().filter(|point| (first..=last).contains(&line(point.source.segment)));
    inside.map(|point| [point.position_mm.x, point.position_mm.y]).collect()
}

#[test]
fn the_centre_goes_round_outer_corners_and_into_inner_ones() {
    // A step: outer corner at (40, 0), inner one at (40, 20).
    let source = "G21 G90 G17\nG0 X0 Y-20 Z0\nG42 G1 X0 Y0 D1 F200 (to it)\nX40\nY20\nX60\nG40 G1 X60 Y0\nM30\n";
    assert_eq!(
        written(source, 5.0),
        [
            "G21 G90 G17",
            "G0 X0 Y-20 Z0",
            "G40 G1 X0.0 Y-5.0 F200 (to it)",
            "X40.0 Y-5.0",
            "G3 X45.0 Y0.0 I0.0 J5.0",
            "G1 X45.0 Y15.0",
            "X60.0 Y15.0",
            "G40 G1 X60.0 Y0.0",
            "M30"
        ]
    );
    // On the other side, the corners change their roles.
    let left = written(&source.replace("G42", "G41").replace("Y-20 Z0", "Y20 Z0").replace("X60 Y0", "X60 Y40"), 5.0);
    assert_eq!(left[3..7], ["X35.0 Y5.0", "X35.0 Y20.0", "G2 X40.0 Y25.0 I5.0 J0.0", "G1 X60.0 Y25.0"]);
}

#[test]
fn arcs_keep_their_centres_and_lines_their_words() {
    let source = "G90\nG0 X-30 Y0 Z5\nG41 D1\nG0 X0 Y0\nG1 Z-3 F50 (down)\nM8\nG1 Y20 F300\nG2 X20 Y40 I20 J0\nG1 X40 Y40\nG40\nZ10\nG0 X40 Y60\nM30\n";
    assert_eq!(
        written(source, 4.0),
        [
            "G90",
            "G0 X-30 Y0 Z5",
            "G40",
            "G0 X-4.0 Y0.0",
            "G1 Z-3 F50 (down)",
            "M8",
            "G1 X-4.0 Y20.0 F300",
            "G2 X20.0 Y44.0 I24.0 J0.0",
            "G1 X40.0 Y44.0",
            "G40",
            "Z10",
            "G0 X40.0 Y60.0",
            "M30"
        ]
    );
    // By radius, in steps and in inches it is the same.
    let expected = points(source, Dialect::Fanuc, 4.0, [4, 12]);
    let steps = source.replace("G1 Y20 F300", "G91 G1 Y20 F300").replace("G2 X20 Y40 I20 J0", "G2 X20 Y20 R20");
    let steps = steps.replace("G1 X40 Y40", "G1 X20").replace("G40\n", "G90 G40\n");
    assert_eq!(points(&steps, Dialect::Fanuc, 4.0, [4, 12]).len(), expected.len(), "{steps}");
    for (a, b) in points(&steps, Dialect::Fanuc, 4.0, [4, 12]).iter().zip(&expected) {
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6, "{a:?} {b:?}");
    }
}

#[test]
fn a_hole_is_milled_from_its_middle_by_arcs_that_lead_to_it() {
    let source = "G90 G17\nG0 X0 Y0 Z5\nG1 Z-2 F100\nG41 D1 X10 Y-10 F200\nG3 X20 Y0 I0 J10\nX20 Y0 I-20 J0\nX10 Y10 I-10 J0\nG40 G1 X0 Y0\nG0 Z5\nM30\n";
    let expected = [
        "G40 X10.0 Y-5.0 F200",
        "G3 X15.0 Y0.0 I0.0 J5.0",
        "X15.0 Y0.0 I-15.0 J0.0",
        "X10.0 Y5.0 I-5.0 J0.0",
        "G40 G1 X0.0 Y0.0",
    ];
    assert_eq!(written(source, 5.0)[3..8], expected);
    // A rectangle whose first and last block lead beyond its corner.
    let source = "G90\nG0 X-20 Y-20 Z0\nG41 D1 G1 X0 Y-15 F200\nY40\nX60\nY0\nX-15\nG40 Y-20\nM30\n";
    let expected = ["X-5.0 Y40.0", "G2 X0.0 Y45.0 I5.0 J0.0", "G1 X60.0 Y45.0"];
    assert_eq!(written(source, 5.0)[3..6], expected);
}

#[test]
fn modes_that_change_at_a_corner_do_not_move_its_arc() {
    let begin = "G21 G90 G17 G40\nG0 X-50 Y-20 Z5\nG41 D1 G1 X-30 Y-5 F100\nX10\n";
    let steps = written(&format!("{begin}G91 Y-20\nG90 G40 G1 X50 Y-50\nM30\n"), 5.0);
    assert_eq!(steps[4..6], ["G2 X15.0 Y-5.0 I0.0 J-5.0", "G91 G1 X0.0 Y-20.0"]);
    let back = written(&format!("{begin}G91\nX10\nG90 Y-40\nG40 G1 X50 Y-50\nM30\n"), 5.0);
    assert_eq!(back[6..8], ["G2 X5.0 Y-5.0 I0.0 J-5.0", "G90 G1 X25.0 Y-40.0"]);
}

#[test]
fn an_arc_that_becomes_the_shorter_one_gets_the_sign_of_that() {
    let source = "0 BEGIN PGM A MM\n1 TOOL CALL 3 Z S2000\n2 L X-60 Y-20 Z+5 R0 FMAX\n3 L X-40 Y+0 RL F100\n4 L X-9.8481\n\
                  5 CR X+9.8481 Y+0 R-10 DR-\n6 L X+40\n7 L X+60 Y+30 R0\n8 END PGM A MM\n";
    let program = read(source, Dialect::Heidenhain, 4.0).unwrap_or_else(|error| panic!("{error}"));
    let text = String::from_utf8(program.into_source()).unwrap();
    assert!(text.contains("R+14.0") || text.contains("R+13.99"), "{text}");
}

#[test]
fn the_tool_and_the_offset_in_force_give_the_radius() {
    let radii = BTreeMap::from([
        (CutterOf::Offset(1), 5.0),
        (CutterOf::Offset(2), 2.0),
        (CutterOf::Tool(3), 4.0),
        (CutterOf::Tool(5), 3.0),
    ]);
    let at = |source: &str, dialect: Dialect| {
        let options =
            GcodeOptions { dialect: Some(dialect), cutter_radii_mm: Some(radii.clone()), ..GcodeOptions::default() };
        let read = GcodeProgram::parse_expanded(source, "part.nc", &options, &|_| None);
        let used = |program: GcodeProgram| program.notes().cutter_radii_mm.values().copied().collect::<Vec<f64>>();
        read.map(used).map_err(|error| error.to_string())
    };
    let iso = |words: &str| format!("G90 G17\n{words}\nG1 X30\nG40 G0 X50 Y50\nM30\n");
    let conversational = |call: &str| {
        format!(
            "0 BEGIN PGM A MM\n{call}\n3 L X-30 Y+0 Z+0 R0 FMAX\n4 L X+0 RL F9\n5 L X+30\n6 L Y+50 R0\n7 END PGM A MM\n"
        )
    };
    for (source, dialect, expected) in [
        (iso("D2\nG41\nD1 G1 X0 Y0 F9"), Dialect::Fanuc, 5.0),
        (iso("T3 M6\nG41 D0 G1 X0 Y0 F9"), Dialect::Fanuc, 0.0),
        (iso("T3 M6\nG41 G1 X0 Y0 F9"), Dialect::Haas, 4.0),
        (iso("T3 M6\nG41.1 D6 G1 X0 Y0 F9\nX10\nG40 X20 Y9\nG41 X25 Y0"), Dialect::LinuxCnc, 4.0),
        (iso("T3 M6\nG96 D1 S9\nG41 G1 X0 Y0 F9"), Dialect::LinuxCnc, 4.0),
        (iso("T3 D1 M6\nG41 G1 X0 Y0 F9"), Dialect::Sinumerik, 4.0),
        (iso("T=\"MILL\" D1 M6\nT5 M6\nG41 G1 X0 Y0 F9"), Dialect::Sinumerik, 3.0),
        (iso("G54 G90 G0 G41 D1 X0 Y0"), Dialect::Fanuc, 5.0),
        (conversational("1 TOOL CALL 5 Z S1\n2 TOOL CALL Z S2"), Dialect::Heidenhain, 3.0),
        (conversational("1 TOOL CALL 5 Z S1 DL+0 DR+0,0"), Dialect::Heidenhain, 3.0),
    ] {
        assert_eq!(at(&source, dialect), Ok(vec![expected]), "{source}");
    }
    for (source, dialect, expected) in [
        (iso("T3 M6\nG41 D13 G1 X0 Y0 F9"), Dialect::Fanuc, "expected the radius of D13"),
        (iso("D1\nG41 G1 X0 Y0 F9\nX10 D2"), Dialect::Fanuc, "changes cutter radius compensation"),
        (iso("G10 L12 P1 R6.0\nG41 D1 G1 X0 Y0 F9"), Dialect::Fanuc, "sets a radius of a tool"),
        (iso("G41 D1 D2 G1 X0 Y0 F9"), Dialect::Fanuc, "changes cutter radius compensation"),
        (iso("G18\nG41 D1 G1 X0 Z0 F9"), Dialect::Fanuc, "stands in cutter radius compensation"),
        (iso("G41 D1 G1 X0 Y0 F9\nZ-5\nG40 G1 X9 Y9"), Dialect::Fanuc, "leads to no contour"),
        (iso("T3 D1 M6\nT=\"MILL\" M6\nG41 G1 X0 Y0 F9"), Dialect::Sinumerik, "radius that is not known"),
        (iso("T1=5 M6\nG41 G1 X0 Y0 F9"), Dialect::Sinumerik, "radius that is not known"),
        (iso("T3 D1 M6\nD0\nG41 G1 X0 Y0 F9"), Dialect::Sinumerik, "expected D1"),
        (iso("T3 D2 M6\nG41 G1 X0 Y0 F9"), Dialect::Sinumerik, "expected D1"),
        (iso("T3 D1 M6\nG41 G1 X0 Y0 F9\nX10 D2"), Dialect::Sinumerik, "changes cutter radius compensation"),
        (conversational("1 TOOL CALL 5 Z S1\n2 TOOL CALL \"MILL\" Z S2"), Dialect::Heidenhain, "not known"),
        (conversational("1 TOOL  CALL 3 Z DR+0.1"), Dialect::Heidenhain, "DR in its call"),
        (conversational("1 TOOL CALL 3 Z DR+0.1\n2 TOOL CALL Z S3000"), Dialect::Heidenhain, "DR in its call"),
        (conversational("1 TOOL DEF 3 L+0 R+6\n2 TOOL CALL 3 Z"), Dialect::Heidenhain, "sets a radius of a tool"),
        (conversational("1 TOOL DEF 3 L0 R6\n2 TOOL CALL 3 Z"), Dialect::Heidenhain, "sets a radius of a tool"),
    ] {
        let error = at(&source, dialect).expect_err(&source);
        assert!(error.contains(expected), "{source}: {error}");
    }
}

#[test]
fn tangents_that_a_post_has_rounded_are_none_the_worse() {
    // Rounded to three decimals, the line and the arc meet at 2e-5 rad and the radii of the arc differ.
    let source = "G21 G90 G17 G40\nG0 X-20 Y-20 Z5\nG41 D1 G1 X0 Y0 F100\nX35.138\nX61.856 Y-5.258\n\
                  G3 X82.819 Y-0.264 I5.011 J25.465\nG1 X90 Y5\nG40 X50 Y50\nM30\n";
    let lines = written(source, 5.0);
    assert!(lines.iter().any(|line| line.starts_with("G3 ")), "{lines:?}");
    // Small outer fillets, whose radii at both ends differ by rounding, so that the corner before them is a slight inner one.
    for i in ["0.0005", "0.002", "0.003"] {
        let source = format!(
            "G90 G17\nG0 X0 Y20 Z0\nG41 D1 G1 X0 Y0 F200\nX30\nG2 X30.5 Y-0.5 I{i} J-0.5\nG1 Y-40\nG40 X60\nM30\n"
        );
        for point in points(&source, Dialect::Fanuc, 5.0, [4, 6]) {
            // The exact fillet has its centre at (30, -0.5).
            let away = match point {
                [x, _] if x <= 30.0 => point[1],
                [_, y] if y <= -0.5 => point[0] - 30.5,
                [x, y] => (x - 30.0).hypot(y + 0.5) - 0.5,
            };
            assert!((away - 5.0).abs() < 0.012, "{i}: {point:?} {away}");
        }
    }
    let boss = "G90 G17\nG0 X36.151 Y-111.753 Z0\nG41 D1 G1 X35.296 Y-100.786 F200\nX5.885 Y-103.079\n\
                G2 X5.348 Y-102.619 I-0.039 J0.498\nG1 X2.317 Y-63.737\nG40 G1 X-30\nM30\n";
    assert!(written(boss, 5.0).iter().any(|line| line.starts_with("G2 ")));
}

#[test]
fn a_radius_of_nothing_leaves_the_lines_as_they_are() {
    let source = "G90\nG0 X-30 Y0 Z5\nG41 D1 G1 X0 Y0. F100\nY20.00\nG2 X20 Y40 R20\nG40 G1 X+40 Y40\nM30\n";
    let lines = written(source, 0.0);
    assert_eq!(lines.join("\n") + "\n", source.replace("G41 D1", "G40"));
}

#[test]
fn all_dialects_lead_the_centre_along_the_same_path() {
    let iso = "G90\nG0 X-30 Y-10 Z5\nT3 M6\nG0 X-30 Y-10 Z0\nG41 G1 X0 Y0 F300\nY20\nG2 X20 Y40 I20 J0\nG1 X40\nY0\nX20\nG40 G1 X20 Y-30\nM30\n";
    let sinumerik = iso.replace("G41", "G41 D1").replace("I20 J0", "CR=20").replace("Y20\n", "Y=AC(20)\n");
    let heidenhain = "0 BEGIN PGM a MM\n1 L X-30 Y-10 Z+5 R0 FMAX\n2 TOOL CALL 3 Z S1000\n3 L X-30 Y-10 Z+0 R0 FMAX\n4 L X+0 Y+0 RL F300\n\
                      5 L Y+20\n6 CR X+20 Y+40 R+20 DR-\n7 L X+40\n8 L Y+0\n9 L X+20\n10 L X+20 Y-30 R0\n11 L Z+50 R0 FMAX\n12 END PGM a MM\n";
    let polar = heidenhain.replace("6 CR X+20 Y+40 R+20 DR-", "6 CC X+20 Y+20\n6 C X+20 Y+40 DR-");
    let expected = points(iso, Dialect::Fanuc, 4.0, [5, 11]);
    assert!(expected.len() > 2000);
    for (source, dialect, lines) in [
        (iso.to_owned(), Dialect::LinuxCnc, [5, 11]),
        (iso.to_owned(), Dialect::Haas, [5, 11]),
        (sinumerik, Dialect::Sinumerik, [5, 11]),
        (heidenhain.to_owned(), Dialect::Heidenhain, [5, 11]),
        (polar, Dialect::Heidenhain, [5, 12]),
    ] {
        let found = points(&source, dialect, 4.0, lines);
        assert_eq!(found.len(), expected.len(), "{dialect:?}");
        for (a, b) in found.iter().zip(&expected) {
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6, "{dialect:?}: {a:?} {b:?}");
        }
    }
}

#[test]
fn where_the_cutter_has_no_room_the_line_is_named() {
    let begin = "G90\nG0 X0 Y-20 Z0\n";
    for (source, expected) in [
        (
            "G42 G1 X0 Y0 F200\nX40\nG40 Y-20\n",
            "part.nc:3:5: `G1`: cutter radius compensation with a radius that is not known",
        ),
        ("G42 D7 G1 X0 Y0 F200\nX40\nG40 Y-20\n", "expected the radius of D7 in cutter_radius_mm of [gcode]"),
        ("G42 D1 G1 X0 Y0 F200\nX40\nX42 Y-1\nY-40\nG40 X0\n", "part.nc:5"),
        ("G42 D1 G1 X0 Y0 F200\nX40\nG2 X44 Y0 R2\nG1 X80\nG40 Y20\n", "does not fit beside this block"),
        ("G42 D1 G1 X0 Y0 F200\nX40\nY-8\nX0\nG40 Y-30\n", "does not fit beside this block"),
        ("G42 D1 G1 X0 Y0 F200\nX40\nY-30\nX20\nX35 Y-15\nG40 G0 Z9\n", "cut into the contour of line"),
        ("G42 D1 G1 X0 Y0 F200\nX40\nX10\nG40 Y-30\n", "turns back in cutter radius compensation"),
        ("G42 D1 G1 X0 Y0 F200\nX40\nG41 Y10\nG40 Y-30\n", "changes cutter radius compensation in force"),
        ("G42 D1 G1 X0 Y0 F200\nX40\nG54 X50\nG40 Y-30\n", "stands in cutter radius compensation"),
        ("G42 D1 G1 X0 Y0 F200\nX40\nM6\nX50\nG40 Y-30\n", "stands in cutter radius compensation"),
        ("G42 D1 G2 X10 Y-10 R10 F200\nG1 X40\nG40 Y-30\n", "begins or ends cutter radius compensation on an arc"),
        ("G42 D1 G1 X0 Y0 F200\nX40\nG40\nG92 X0\nG0 Y-30\n", "stands in cutter radius compensation"),
        // The way to a closed contour from its other side, and across another block.
        ("G1 X20 Y30 F100\nG42 D1 X20 Y0\nX40\nY40\nX0\nY0\nX20\nG40 Y-30\n", "cut into the contour of line 5"),
        ("G1 X-9 Y90 F100\nG42 D1 X20 Y0\nX40\nY40\nX0\nY0\nX20\nG40 Y-30\n", "cut into the contour of line 7"),
    ] {
        let error = refused(&format!("{begin}{source}M30\n"));
        assert!(error.contains(expected), "{source}: {error}");
    }
    let off = GcodeProgram::parse_expanded("G90\nG41 D1 G1 X1 Y1 F9\n", "part.nc", &GcodeOptions::default(), &|_| None);
    let error = off.map(GcodeProgram::into_source).expect_err("without radii").to_string();
    assert!(error.starts_with("part.nc:2:1: `G41`: ") && error.contains("cutter_compensation = \"off\""), "{error}");
    let delta =
        "0 BEGIN PGM a MM\n1 TOOL CALL 3 Z S1000 DR+0.1\n2 L X+0 Y+0 Z+0 R0 FMAX\n3 L X+9 Y+0 RL F9\n4 END PGM a MM\n";
    let error = read(delta, Dialect::Heidenhain, 5.0).map(GcodeProgram::into_source).expect_err("oversize").to_string();
    assert!(error.contains("part.nc:4") && error.contains("DR in its call"), "{error}");
}

/// A contour of lines and arcs from the origin along x, each bent or curved by an angle.
fn contour() -> impl Strategy<Value = String> {
    let element = (any::<bool>(), 8.0..30.0f64, -80.0..80.0f64, 12.0..40.0f64);
    prop::collection::vec(element, 1..6).prop_map(|elements| {
        let (mut at, mut heading) = ([0.0f64, 0.0f64], 0.0f64);
        let mut text = "G90 G17\nG0 X-20 Y0 Z0\nG1 X-15 Y12 F100\nG41 D1 X0 Y0\n".to_owned();
        for (is_arc, length, angle, radius) in elements {
            if is_arc {
                let sweep = (length / radius).copysign(angle);
                let side = 1f64.copysign(angle);
                let centre = [at[0] - side * radius * heading.sin(), at[1] + side * radius * heading.cos()];
                let arm = [at[0] - centre[0], at[1] - centre[1]];
                let (sin, cos) = sweep.sin_cos();
                let to = [centre[0] + arm[0] * cos - arm[1] * sin, centre[1] + arm[0] * sin + arm[1] * cos];
                let code = if side > 0.0 { 3 } else { 2 };
                text += &format!("G{code} X{:.7} Y{:.7} I{:.7} J{:.7}\n", to[0], to[1], -arm[0], -arm[1]);
                (at, heading) = (to, heading + sweep);
            } else {
                at = [at[0] + length * heading.cos(), at[1] + length * heading.sin()];
                text += &format!("G1 X{:.7} Y{:.7}\n", at[0], at[1]);
            }
            heading += (angle / 2.0).to_radians();
        }
        let away = [at[0] + 30.0 * heading.cos(), at[1] + 30.0 * heading.sin()];
        text + &format!("G40 G0 X{:.7} Y{:.7}\nM30\n", away[0], away[1])
    })
}

proptest! {
    #![proptest_config(cases(24))]

    /// Each point of the centre is at the radius from a block of the contour, and no nearer to any: found by trying all points of both. The first and the
    /// last block of an open contour, which lead to the part and away, hold for the points beside them alone.
    #[test]
    fn the_centre_keeps_its_distance_from_the_contour(text in contour(), radius in 2.0..9.0f64, left in any::<bool>()) {
        let text = if left { text } else { text.replace("G41", "G42").replace("X-15 Y12", "X-15 Y-12") };
        let last = text.lines().count() - 2;
        prop_assume!(read(&text, Dialect::Fanuc, radius).is_ok());
        let blocks: Vec<Vec<[f64; 2]>> = (5..=last).map(|line| points(&text, Dialect::Fanuc, 0.0, [line, line])).collect();
        let start = [[0.0, 0.0]];
        for (own, line) in (5..=last).enumerate() {
            for centre in points(&text, Dialect::Fanuc, radius, [line, line]) {
                let away = |p: &[f64; 2]| (p[0] - centre[0]).hypot(p[1] - centre[1]);
                let least = |points: &mut dyn Iterator<Item = &[f64; 2]>| points.map(away).fold(f64::INFINITY, f64::min);
                let nearest = least(&mut start.iter().chain(blocks.iter().flatten()));
                let is_held = |other: &usize| *other == own || (1..blocks.len() - 1).contains(other);
                let held = least(&mut (0..blocks.len()).filter(is_held).flat_map(|other| &blocks[other]));
                prop_assert!(nearest < radius + 4e-4 && held > radius - 4e-4, "{nearest}, {held} for {radius} at {centre:?}\n{text}");
            }
        }
    }
}
