//! What is refused, and in which words.

use kinetostat::toolpath::{
    NumberFormat, Sampling,
    gcode::{BlockDelete, GcodeOptions, Program},
};
use nalgebra::Vector3;

fn refusal(source: impl Into<Vec<u8>>) -> String {
    let program = Program::parse(source, "part.nc", &GcodeOptions::default());
    program.expect_err("expected a refusal").to_string()
}

/// Refusal of a line that follows two good ones.
fn third(line: &str) -> String {
    refusal(format!("G21 G90 G17 F100\nG0 X0 Y0 Z0\n{line}\n"))
}

#[test]
fn features_that_cannot_be_followed_are_refused_by_name() {
    for (line, expected) in [
        (
            "G41 D1 X5",
            "part.nc:3:1: `G41`: cutter radius compensation is not supported; \
             expected the path of the tool centre with G40",
        ),
        (
            "N5 G81 Z-5 R2 F100",
            "part.nc:3:4: `G81`: canned cycles are not supported; \
             expected the cycle written out as G0 and G1 moves",
        ),
        (
            "G92 X0",
            "part.nc:3:1: `G92`: changing the origin inside a program is not supported; \
             expected work offsets G54 to G59 given as options",
        ),
        (
            "G10 L2 P1 X0",
            "part.nc:3:1: `G10`: changing the origin inside a program is not supported; \
             expected work offsets G54 to G59 given as options",
        ),
        ("G59.1", "part.nc:3:1: `G59.1`: more than six work offsets are not supported; expected G54 to G59"),
        (
            "g68 x0 y0 r30",
            "part.nc:3:1: `g68`: polar, scaled or rotated coordinates are not supported; \
             expected plain coordinates",
        ),
        ("G1 X5 A90", "part.nc:3:7: `A90`: rotary axes are not supported; expected X, Y and Z only"),
        ("G1 X5 W3", "part.nc:3:7: `W3`: secondary axes are not supported; expected X, Y and Z only"),
        (
            "(Größe) G93 G1 X5 F2",
            "part.nc:3:9: `G93`: inverse-time feed is not supported; \
             expected feed in units per minute, G94",
        ),
        (
            "G95",
            "part.nc:3:1: `G95`: feed per revolution is not supported; \
             expected feed in units per minute, G94",
        ),
        (
            "G96 S100",
            "part.nc:3:1: `G96`: constant surface speed is not supported; \
             expected spindle speed in rev/min, G97",
        ),
        ("G33 Z-5 K1", "part.nc:3:1: `G33`: this motion is not supported; expected G0, G1, G2 or G3"),
        (
            "M98 P100",
            "part.nc:3:1: `M98`: subprograms are not supported; \
             expected one program with its calls written out",
        ),
        (
            "G77 X5",
            "part.nc:3:1: `G77`: this G word is not supported; \
             expected a word of a 3-axis mill program",
        ),
        (
            "G1 X5 E2",
            "part.nc:3:7: `E2`: this word is not supported; \
             expected one of D F G H I J K M N O P Q R S T X Y Z",
        ),
        (
            "G2 G53 X5",
            "part.nc:3:4: `G53`: machine coordinates with an arc are not supported; \
             expected G53 with G0 or G1",
        ),
    ] {
        assert_eq!(third(line), expected);
    }
    assert_eq!(
        refusal("O1\nG21\nO2\n"),
        "part.nc:3:1: `O2`: subprograms are not supported; \
         expected one program with its calls written out"
    );
}

#[test]
fn text_that_is_no_word_is_refused() {
    for (line, expected) in [
        ("#100=5", "part.nc:3:1: `#100=5`: variables and expressions are not supported; expected plain numbers"),
        (
            "G1 X[1+2]",
            "part.nc:3:4: `X[1+2]`: variables and expressions are not supported; \
             expected plain numbers",
        ),
        ("G1 X5 (open", "part.nc:3:7: `(open`: comment is not closed; expected `)` on the same line"),
        ("G1 X Y5", "part.nc:3:4: `X`: not a word; expected a letter followed by a number, such as X10.5"),
        ("G1 X+-5.0", "part.nc:3:4: `X+-5.0`: not a word; expected a letter followed by a number, such as X10.5"),
        (
            "G1 X5*36",
            "part.nc:3:4: `X5*36`: line checksums are not supported; \
             expected the line without `*` and the number after it",
        ),
        (
            "G1 X5€",
            "part.nc:3:4: `X5€`: unexpected character; \
             expected words such as X10.5, or a comment in ( ) or after ;",
        ),
        (
            "G1 X0.1234567890123456789",
            "part.nc:3:7: `1234567890123456789`: number has 19 digits in a row; expected at most 17",
        ),
    ] {
        assert_eq!(third(line), expected);
    }
}

#[test]
fn words_that_do_not_go_together_are_refused() {
    for (line, expected) in [
        ("G1 X5 X6", "part.nc:3:7: `X6`: second X word on the line; expected one"),
        ("G0 G1 X5", "part.nc:3:4: `G1`: contradicts G0 on the same line; expected one of them"),
        ("G20 G21", "part.nc:3:5: `G21`: contradicts G20 on the same line; expected one of them"),
        (
            "G4 X2",
            "part.nc:3:4: `X2`: coordinate on a line with G4, which is no motion to it; \
             expected it on a line of its own",
        ),
        ("G1 X5 I2", "part.nc:3:7: `I2`: arc word on a line that is no arc; expected G2 or G3 in force"),
        (
            "G1 X5 P2",
            "part.nc:3:7: `P2`: parameter that belongs to no word; \
             expected G4, G64 or an M word on the line",
        ),
        (
            "G80 X5",
            "part.nc:3:5: `X5`: coordinate without a motion; \
             expected G0, G1, G2 or G3 on this line or before it",
        ),
        ("M3.5", "part.nc:3:1: `M3.5`: expected a whole number after M"),
        ("F-5", "part.nc:3:1: `F-5`: expected a feed of 0 to 1e9 per minute"),
        ("S-5", "part.nc:3:1: `S-5`: expected a spindle speed of 0 to 1e9 rev/min"),
        ("G1 X2000000", "part.nc:3:4: `X2000000`: coordinate beyond 1000000 mm; expected a position on the machine"),
        (
            "G55 G0 X5",
            "part.nc:3:1: `G55`: its work offset is not known; \
             expected an offset for G55 among the options",
        ),
    ] {
        assert_eq!(third(line), expected);
    }
    assert_eq!(
        refusal("G0 X0 Y0 Z0\nM30\nG0 X5\n%\n"),
        "part.nc:3:1: `G0`: after the end of the program in line 2; expected only comments and %"
    );
}

#[test]
fn arcs_that_are_none_are_refused() {
    for (line, expected) in [
        ("G2 X5 Y5", "part.nc:3:1: `G2`: arc without a centre; expected I and J in G17, or R"),
        ("G18 G2 X5 Z5 J5", "part.nc:3:14: `J5`: centre word outside the selected plane; expected I and K in G18"),
        ("G2 X5 Y5 I5 R5", "part.nc:3:13: `R5`: arc with a radius and a centre; expected one of them"),
        (
            "G90.1 G2 X5 Y5 I5",
            "part.nc:3:7: `G2`: absolute centre (G90.1) with one coordinate; \
             expected both I and J in G17",
        ),
        (
            "G2 X10 Y0.5 I5",
            "part.nc:3:1: `G2`: arc starts 5.0000 mm and ends 5.0249 mm from its centre; \
             expected equal radii to 0.005 mm or 0.1 %",
        ),
        ("G3 X5 Y0 I0 J0", "part.nc:3:1: `G3`: arc of radius zero; expected a centre away from the start"),
        (
            "G3 X10 R4",
            "part.nc:3:1: `G3`: radius 4.0000 mm cannot reach an end 10.0000 mm away; \
             expected at least half the distance",
        ),
        (
            "G3 R4",
            "part.nc:3:1: `G3`: radius form with its end at its start has no definite centre; \
             expected a full circle by its centre",
        ),
    ] {
        assert_eq!(third(line), expected);
    }
}

#[test]
fn moves_from_nowhere_known_are_refused() {
    assert_eq!(
        refusal("G21 G90\nG0 Z5\nG1 X10 F100\n"),
        "part.nc:3:1: `G1`: starts at an unknown X, Y; \
         expected a G0 to a position in X, Y and Z before it, or a given start"
    );
    assert_eq!(
        third("G28 Z0\nG1 X5"),
        "part.nc:4:1: `G1`: starts at an unknown Z after line 3; \
         expected a G0 to a position in X, Y and Z before it, or a given start"
    );
    assert_eq!(
        refusal("G91 G0 X5\n"),
        "part.nc:1:5: `G0`: starts at an unknown X, Y, Z; \
         expected a G0 to a position in X, Y and Z before it, or a given start"
    );
}

#[test]
fn a_given_start_and_unit_are_used() {
    let options = GcodeOptions {
        unit: kinetostat::toolpath::gcode::LengthUnit::Inch,
        start_mm: Some(Vector3::new(0.0, 0.0, 25.4)),
        ..GcodeOptions::default()
    };
    let program = Program::parse("G1 X2 F10\n", "part.nc", &options).unwrap();
    let path = program.toolpath(Sampling::new(0.1, 100.0).unwrap()).unwrap();
    assert_eq!(path.len(), 1);
    assert_eq!(path.points()[0].position_mm, Vector3::new(50.8, 0.0, 25.4));
    assert_eq!(path.points()[0].feed_mm_per_min, Some(254.0));
    assert!((path.length_mm() - 50.8).abs() < 1e-12);
}

#[test]
fn delete_lines_are_skipped_when_asked() {
    let source = "G0 X0 Y0 Z0\n/G81 #5 anything\n/G1 X5 F1\nG0 X7\n";
    let options = GcodeOptions { block_delete: BlockDelete::Skip, ..GcodeOptions::default() };
    let program = Program::parse(source, "part.nc", &options).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    assert_eq!(path.len(), 2);
    let goals: Vec<_> = path.positions_mm().iter().map(|p| p.add_scalar(0.25)).collect();
    let written = program.rewrite(&path, &goals, NumberFormat::new(2, 4).unwrap()).unwrap();
    assert_eq!(
        std::str::from_utf8(written.bytes()).unwrap(),
        "G0 X0.25 Y0.25 Z0.25\n/G81 #5 anything\n/G1 X5 F1\nG0 X7.25\n"
    );
}

#[test]
fn a_path_too_fine_or_from_elsewhere_is_refused() {
    let options = GcodeOptions::default();
    let program = Program::parse("G0 X0 Y0 Z0\nG1 X9 F1\n", "part.nc", &options).unwrap();
    let too_fine = program.toolpath(Sampling::new(1.0, 1e-6).unwrap()).unwrap_err();
    assert_eq!(
        too_fine.to_string(),
        "part.nc:2:1: `G1`: path of more than 2000000 points; \
         expected a coarser sampling or a shorter program"
    );
    let other = Program::parse("G0 X0 Y0 Z0\nG1 X8 F1\n", "other.nc", &options).unwrap();
    let path = other.toolpath(Sampling::default()).unwrap();
    let refused = program.rewrite(&path, &path.positions_mm(), NumberFormat::default()).unwrap_err();
    assert_eq!(refused.to_string(), "the path does not belong to program part.nc: expected a path sampled from it");
    let own = program.toolpath(Sampling::default()).unwrap();
    let refused = program.rewrite(&own, &own.positions_mm()[1..], NumberFormat::default()).unwrap_err();
    assert_eq!(refused.to_string(), "9 corrected positions for a path of 10 points: expected one for each point");
    let mut wild = own.positions_mm();
    wild[3].y = f64::INFINITY;
    let refused = program.rewrite(&own, &wild, NumberFormat::default()).unwrap_err();
    assert_eq!(refused.to_string(), "corrected position 3 is (3, inf, 0) mm: expected finite numbers up to 1000000");
}
