//! Sinumerik's and Heidenhain's programs: where they lead, and how they are written.

use crate::support::programs::programs_in;
use kinetostat_programs::{
    NumberFormat, Sampling, Toolpath, WriteOptions,
    gcode::{Dialect, GcodeOptions, GcodeProgram},
};
use nalgebra::Vector3;

fn parse(source: &str) -> (GcodeProgram, Toolpath) {
    let program = GcodeProgram::parse(source, "part", &GcodeOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let path = program.toolpath(Sampling::new(10.0, 5.0).unwrap()).unwrap();
    (program, path)
}

fn ends(source: &str) -> Vec<Vector3<f64>> {
    let (_, path) = parse(source);
    path.points().iter().filter(|point| point.source.parameter == 1.0).map(|point| point.position_mm).collect()
}

fn rewritten(source: &str, correction: impl Fn(Vector3<f64>) -> Vector3<f64>) -> String {
    let (program, path) = parse(source);
    let goals: Vec<_> = path.positions_mm().into_iter().map(|p| p + correction(p)).collect();
    let written =
        program.rewrite(&path, &goals, WriteOptions::with_decimals(NumberFormat::new(2, 3).unwrap())).unwrap();
    let back = written.read_back().unwrap_or_else(|e| panic!("{e}\n{}", String::from_utf8_lossy(written.bytes())));
    for (here, goal) in back.positions_mm().iter().zip(&goals) {
        assert!((here - goal).amax() <= 0.0151, "{here:?} {goal:?}\n{}", String::from_utf8_lossy(written.bytes()));
    }
    String::from_utf8(written.into_bytes()).unwrap()
}

/// Bends so that no piece stays straight.
fn wave(p: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(0.0, 0.0, if (p.x / 5.0).round() % 2.0 == 0.0 { 0.5 } else { -0.5 })
}

const BEGIN: &str = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000 F80\n2 L X+0 Y+0 Z+0 R0 FMAX\n";

#[test]
fn every_program_shows_its_dialect() {
    for (folder, dialect) in [
        ("tests/gcode", Dialect::Iso),
        ("tests/gcode_cycles", Dialect::Iso),
        ("tests/dialects/heidenhain", Dialect::Heidenhain),
        ("tests/dialects/sinumerik", Dialect::Sinumerik),
    ] {
        for (name, source) in programs_in(folder) {
            assert_eq!(Dialect::detect(&source), dialect, "{name}");
        }
    }
}

#[test]
fn heidenhains_moves_lead_where_they_say() {
    let at = Vector3::new;
    let source = "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+10 Y-5,5 Z+2 FMAX\nL IX+5 Z-1 F100\nCC IX+0 IY+10\n\
                  C IX+10 IY+10 DR+\nCR X+25 Y-15.5 R+10 DR-\nCYCL DEF 7.0\nCYCL DEF 7.1 X+100\nCYCL DEF 7.3 IZ-3\nL X+0\n\
                  CYCL DEF 7.0\nCYCL DEF 7.3 IZ-3\nL Z+0\n";
    assert_eq!(
        ends(source),
        [
            at(10.0, -5.5, 2.0),
            at(15.0, -5.5, -1.0),
            at(25.0, 4.5, -1.0),
            at(25.0, -15.5, -1.0),
            at(100.0, -15.5, -1.0),
            at(100.0, -15.5, -6.0)
        ]
    );
    let (_, path) = parse(source);
    let on_first_arc = path.points().iter().filter(|point| point.source.segment == 2);
    for point in on_first_arc {
        assert!(((point.position_mm - at(15.0, 4.5, -1.0)).norm() - 10.0).abs() < 1e-9, "{point:?}");
    }
}

#[test]
fn a_preset_ends_the_datum_shift() {
    let mut options = GcodeOptions::default();
    for (name, x) in [("preset 1", 100.0), ("preset 2", 200.0)] {
        options.work_offsets_mm.insert(name.parse().unwrap(), Vector3::new(x, 0.0, 0.0));
    }
    let source = "BEGIN PGM A MM\nCYCL DEF 247 DATUM SETTING ~\n  Q339=+1 ;NUMBER\nL X+1 Y+0 Z+0 FMAX\nCYCL DEF 7.0\n\
                  CYCL DEF 7.1 X+10\nL X+1\nCYCL DEF 247 Q339=+2\nL X+1\n";
    let path =
        GcodeProgram::parse(source, "part.h", &options).unwrap().toolpath(Sampling::new(10.0, 500.0).unwrap()).unwrap();
    let xs: Vec<f64> = path.points().iter().map(|point| point.position_mm.x).collect();
    assert_eq!(xs, [101.0, 111.0, 201.0]);
}

#[test]
fn feeds_of_heidenhain_are_those_of_the_block_the_tool_or_none() {
    let feeds = |source: &str| -> Vec<Option<f64>> {
        let (_, path) = parse(source);
        let mut feeds: Vec<_> =
            path.points().iter().map(|point| (point.source.segment, point.feed_mm_per_min)).collect();
        feeds.dedup();
        feeds.into_iter().map(|(_, feed)| feed).collect()
    };
    assert_eq!(
        feeds(&format!(
            "{BEGIN}L X+1\nL X+2 F200\nL X+3 FMAX\nL X+4\nL X+5 F AUTO\nTOOL CALL 2 Z S1 F70\nL X+6 FAUTO\n"
        )),
        [None, Some(80.0), Some(200.0), None, Some(200.0), Some(80.0), Some(70.0)]
    );
    assert_eq!(
        feeds("BEGIN PGM A INCH\nL X+0 Y+0 Z+0 FMAX\nL X+1 F100\nL X+2 F AUTO\n"),
        [None, Some(254.0), None],
        "tenths of an inch a minute; no feed of the tool is said"
    );
    assert_eq!(feeds(&format!("{BEGIN}L X+1 F0.1 M136\nL X+2 F50 M137\n")), [None, Some(100.0), Some(50.0)]);
}

#[test]
fn units_of_sinumerik_are_those_of_coordinates_or_of_all() {
    let feed = |source: &str| parse(source).1.points().last().unwrap().feed_mm_per_min;
    let at = Vector3::new;
    for (unit, x, fed) in [("G71", 2.0, 100.0), ("G70", 50.8, 100.0), ("G710", 2.0, 100.0), ("G700", 50.8, 2540.0)] {
        let source = format!("{unit} G0 X=0 Y0 Z0\nG1 X2 F100\n");
        assert_eq!((*ends(&source).last().unwrap(), feed(&source)), (at(x, 0.0, 0.0), Some(fed)), "{unit}");
    }
}

#[test]
fn translations_of_sinumerik_replace_one_another_or_add_up() {
    let at = Vector3::new;
    assert_eq!(
        ends("G0 X0 Y0 Z0\nTRANS X10 Y5\nX0 Y0\nATRANS X2 Z1\nX0 Y0 Z0\nTRANS Y=1\nX0 Y0 Z0\nTRANS\nX0 Y0\n"),
        [at(0.0, 0.0, 0.0), at(10.0, 5.0, 0.0), at(12.0, 5.0, 1.0), at(0.0, 1.0, 0.0), at(0.0, 0.0, 0.0)]
    );
}

#[test]
fn a_split_block_of_heidenhain_is_blocks_with_numbers_of_their_own() {
    let source = format!(
        "{BEGIN}3 L X+15 R0 F200 M3 M9 ; cut\n4 CC X+15 Y-5\n5 C X+20 Y-5 DR- M8\n9 L Y-10 FMAX\n10 END PGM A MM\n"
    );
    assert_eq!(
        rewritten(&source, wave),
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000 F80\n2 L X+0 Y+0 Z+0.50 R0 FMAX\n\
         3 L X+5.00 Z-0.50 R0 F200 M3 ; cut\n4 L X+10.00 Z+0.50\n5 L X+15 Z-0.50 M9\n6 CC X+15 Y-5\n\
         7 L X+18.54 Y-1.46 Z+0.50 M8\n8 L X+20 Y-5\n12 L Y-10 FMAX\n13 END PGM A MM\n"
    );
    // Numbers behind a mark, in comments and with zeros; those that were the same before stay so where no block is split.
    let source = format!("{BEGIN}3 L X+15 Z+0\n / 6 L X+15\n;7\n07 M30\n");
    assert_eq!(
        rewritten(&source, wave),
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000 F80\n2 L X+0 Y+0 Z+0.50 R0 FMAX\n\
         3 L X+5.00 Z-0.50\n4 L X+10.00 Z+0.50\n5 L X+15 Z-0.50\n / 8 L X+15\n;7\n9 M30\n"
    );
    let source = format!("{BEGIN}5 L X+15 F99\n5 L Z+3\n5 M30\n");
    assert_eq!(rewritten(&source, |_| Vector3::zeros()), source);
    // Blocks without numbers stay so, and commas are kept.
    assert_eq!(
        rewritten("BEGIN PGM A MM\r\nL X0,0 Y0,0 Z0,0 FMAX\r\nL IX10,0 F50", wave),
        "BEGIN PGM A MM\r\nL X0,0 Y0,0 Z0,50 FMAX\r\nL IX5,00 Z-0,50 F50\r\nL X10,0 Z0,50"
    );
}

#[test]
fn a_centre_moves_with_the_arc_about_it() {
    let source = format!(
        "{BEGIN}3 L X+10 F100\n4 CC X+0 Y+0\n5 C X+0 Y+10 DR+\n6 C X-10 Y+0 DR+\n7 CC IX+10 IY+0\n8 C X+10 Y+0 DR+\n"
    );
    assert_eq!(
        rewritten(&source, |_| Vector3::new(0.25, -0.5, 0.0)),
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000 F80\n2 L X+0.25 Y-0.50 Z+0 R0 FMAX\n3 L X+10.25 F100\n4 CC X+0.25 Y-0.50\n\
         5 C X+0.25 Y+9.50 DR+\n6 C X-9.75 Y-0.50 DR+\n7 CC IX+10 IY+0\n8 C X+10.25 Y-0.50 DR+\n"
    );
    // The second arc about it is moved otherwise than the first.
    let turned = rewritten(&source, |p| Vector3::new(0.0, if p.x < -0.1 && p.y > 0.1 { 0.3 } else { 0.0 }, 0.0));
    assert!(turned.contains("4 CC X+0 Y+0\n5 C X+0 Y+10 DR+\n6 L X-3.83 Y+9.54\n7 L X-7.07 Y+7.37\n8 L X-9.24 Y+4.13\n9 L X-10 Y+0\n10 CC IX+10"), "{turned}");
}

#[test]
fn a_split_block_of_sinumerik_offset_keeps_direction_of_writing() {
    assert_eq!(
        rewritten(
            "G710 G90\nG0 X=0 Y=0 Z=0\nN7 G01 X=15 F=200 M3 M9 ; cut\nX=IC(10) Y=AC(0)\nG2 X30 Y-5 CR=5\nG1 X=35 Y=0\n",
            wave
        ),
        "G710 G90\nG0 X=0 Y=0 Z=0.50\nN7 G01 X=5.00 Z=-0.50 F=200 M3 ; cut\nX=10.00 Z=0.50\nX=15 Z=-0.50 M9\n\
         X=IC(5.00) Y=AC(0) Z=0.50\nX=25.00 Z=-0.50\nG1 X28.54 Y-1.46 Z0.50\nX30 Y-5\nG1 X=32.50 Y=-2.50 Z=-0.50\nX=35 Y=0\n"
    );
}

#[test]
fn centres_and_steps_of_sinumerik_keep_their_brackets() {
    assert_eq!(
        rewritten(
            "G710 G90\nG0 X=10 Y=0 Z=0\nG3 X0 Y10 I=AC(0) J=AC( 0 )\nG1 X=IC(5) Y=IC( -2 )\nG3 X5 Y18 I=0 J=IC(5)\n",
            |p| Vector3::new(0.25 + 0.001 * p.x, -0.5, 0.0) - Vector3::new(0.001 * p.x, 0.0, 0.0)
        ),
        "G710 G90\nG0 X=10.25 Y=-0.50 Z=0\nG3 X0.25 Y9.50 I=AC(0.25) J=AC( -0.50 )\nG1 X=IC(5) Y=IC( -2 )\n\
         G3 X5.25 Y17.50 I=0 J=IC(5)\n"
    );
}
