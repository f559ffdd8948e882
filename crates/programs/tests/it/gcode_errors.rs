//! What is refused, and in which words.

use crate::support::programs::programs_in;
use kinetostat_programs::{
    NumberFormat, Sampling, WriteOptions,
    gcode::{BlockDelete, Dialect, Fault, GcodeError, GcodeOptions, GcodeProgram},
};
use nalgebra::Vector3;

fn refusal(source: impl Into<Vec<u8>>) -> String {
    let program = GcodeProgram::parse(source, "part.nc", &GcodeOptions::default());
    program.expect_err("expected a refusal").to_string()
}

#[test]
fn every_program_to_refuse_is_refused_in_the_words_that_it_begins_with() {
    let programs = programs_in("tests/gcode_refused");
    assert!(programs.len() >= 50, "{} programs", programs.len());
    for (name, source) in programs {
        let first = String::from_utf8(source.clone()).unwrap().lines().next().unwrap().to_owned();
        let expected = first.strip_prefix("; ").unwrap();
        let options = GcodeOptions::default();
        let (expected, read) = match expected.strip_prefix("--expand ") {
            Some(expected) => (expected, GcodeProgram::parse_expanded(source, &name, &options, &|_| None)),
            None => (expected, GcodeProgram::parse(source, &name, &options)),
        };
        assert_eq!(read.expect_err(&name).to_string(), expected);
    }
}

/// Refusal of a line that follows two good ones.
fn third(line: &str) -> String {
    refusal(format!("G21 G90 G17 F100\nG0 X0 Y0 Z0\n{line}\n"))
}

/// Zeros that say nothing of a point, and numbers of words that are no lengths.
#[test]
fn leading_zeros_that_mean_nothing_are_read() {
    for line in
        ["G4 X01", "G04 P02", "N0010 G01 X00 Y000 F0100", "G1 X0.085 Y-00.5", "T01 M06", "S0800 M03", "G43 H01 Z5"]
    {
        GcodeProgram::parse(format!("G21 G90 G17 F100\nG0 X0 Y0 Z0\n{line}\n"), "part.nc", &GcodeOptions::default())
            .unwrap();
    }
}

/// Heidenhain's DIN/ISO looks like ISO code, in which M91 and G54 mean other things.
#[test]
fn din_iso_is_told_by_its_first_block() {
    for first in ["%PROG G71", "% 123 G71 *", "%4711 G70"] {
        let told = refusal(format!("{first}\nN10 G00 G40 G90 Z+250 X0 Y0\nN20 G54 X+30 Y+50\n"));
        assert!(told.contains("a program of Heidenhain's DIN/ISO"), "{first}: {told}");
    }
    for first in ["%", "%123", "% (PART G71)"] {
        let source = format!("{first}\nG21 G90\nG0 X0 Y0 Z5\nG1 Z0 F100\n");
        assert!(GcodeProgram::parse(source, "part.nc", &GcodeOptions::default()).is_ok(), "{first}");
    }
}

#[test]
fn features_that_cannot_be_followed_are_refused_by_name() {
    for (line, expected) in [
        (
            "G41 D1 X5",
            "part.nc:3:1: `G41`: cutter radius compensation is not followed as the control makes it; expected the path of \
             the tool centre with G40, or cutter_compensation = \"off\" in [gcode] of the process file, which writes it",
        ),
        (
            "g68 x0 y0 r30",
            "part.nc:3:1: `g68`: polar, scaled or rotated coordinates are not supported; \
             expected plain coordinates",
        ),
        (
            "G43.5 H1",
            "part.nc:3:1: `G43.5`: tool axes as vectors (G43.5) are not supported; expected angles of rotary axes with G43.4",
        ),
        (
            "G10 L50",
            "part.nc:3:1: `G10`: this G10 is not read; expected L2 or L20 with P and coordinates in G90, or data of tools",
        ),
        ("G5 X1 Y1 I0 J3 P0 Q-3", "part.nc:3:4: `X1`: this motion is not supported; expected G0, G1, G2 or G3"),
        ("G54.1", "part.nc:3:1: `G54.1`: names no work offset; expected P1 to P300 on the line"),
        ("G1 X5 W3", "part.nc:3:7: `W3`: secondary axes are not supported; expected X, Y and Z only"),
        ("G33 Z-5 K1", "part.nc:3:1: `G33`: this motion is not supported; expected G0, G1, G2 or G3"),
        (
            "G1 X-0000085 Y5",
            "part.nc:3:4: `X-0000085`: coordinate with leading zeros and no decimal point, which some controls put in by counting digits; \
             expected a decimal point, such as X0.085",
        ),
        (
            "G2 X5 Y5 R010",
            "part.nc:3:10: `R010`: coordinate with leading zeros and no decimal point, which some controls put in by counting digits; \
             expected a decimal point, such as X0.085",
        ),
        (
            "M98 P100",
            "part.nc:3:1: `M98`: subprograms are not read; expected one program, or expand in [gcode] of the process file (--expand), which writes it out",
        ),
        (
            "G77 X5",
            "part.nc:3:1: `G77`: this G word is not supported; \
             expected a word of a 3-axis mill program",
        ),
        (
            "G2 G53 X5",
            "part.nc:3:4: `G53`: machine coordinates with an arc are not supported; \
             expected G53 with G0 or G1",
        ),
    ] {
        assert_eq!(third(line), expected);
    }
    for m in ["M97 P1", "M99", "M198 P1"] {
        let name = m.split(' ').next().unwrap();
        let expected = "subprograms are not read; expected one program, or expand in [gcode] of the process file (--expand), which writes it out";
        assert_eq!(third(m), format!("part.nc:3:1: `{name}`: {expected}"));
    }
    assert_eq!(
        refusal("O1\nG21\nO2\n"),
        "part.nc:3:1: `O2`: subprograms are not read; expected one program, or expand in [gcode] of the process file (--expand), which writes it out"
    );
}

/// Where such a move ends is not in the program, in any dialect of ISO; one that computes with it is refused for the move as well.
#[test]
fn moves_that_a_touch_ends_are_refused_by_what_they_are() {
    let touch = "goes on until something is touched, so that the program does not say where it ends; expected G0 or G1 to a position, and what \
                 measures in a program of its own";
    for dialect in Dialect::ALL.into_iter().filter(|dialect| dialect.is_iso()) {
        let options = GcodeOptions { dialect: Some(dialect), ..GcodeOptions::default() };
        let suffix = if dialect == Dialect::Iso { String::new() } else { format!(" (read as {})", dialect.name()) };
        for line in
            ["G31 Z-10 F50", "g31 z-10 p1", "G91 G31 Z-10", "G31.2 X5", "G36 X5", "G37 Z-5", "G38.2 Z-10", "G38.5 Z10"]
        {
            let source = format!("G21 G90 G17 F100\nG0 X0 Y0 Z5\n{line}\nG1 X5\n#100=#5063\n");
            let plain = source.replace("#100=#5063\n", "");
            let word = line.split(' ').find(|word| word.to_uppercase().starts_with("G3")).unwrap();
            let column = 1 + line.find(word).unwrap();
            let refused = GcodeProgram::parse(plain, "part.nc", &options).unwrap_err();
            assert_eq!(refused.to_string(), format!("part.nc:3:{column}: `{word}`: {touch}{suffix}"));
            assert!(!refused.fault.may_vanish_on_expansion());
            for read in [GcodeProgram::parse_expanded, GcodeProgram::parse_with_calls] {
                let refused = read(source.clone(), "part.nc", &options, &|_| None).unwrap_err();
                assert_eq!(refused.to_string(), format!("part.nc:3:1: `{line}`: {touch}{suffix}"));
            }
        }
        // Other words near these: no skip, and no move.
        for line in ["G35 X5", "G38 X5", "G33 Z-5 K1"] {
            let refused = GcodeProgram::parse(format!("G0 X0 Y0 Z5\n{line}\n"), "part.nc", &options).unwrap_err();
            assert!(!refused.to_string().contains("touched"), "{refused}");
        }
    }
    // One that is not run ends nothing.
    let source = "G0 X0 Y0 Z5\nGOTO 20\nG31 Z-10 F50\nN20 G1 X5 F100 (G31)\nM30\n";
    let program = GcodeProgram::parse_expanded(source, "part.nc", &GcodeOptions::default(), &|_| None).unwrap();
    assert!(String::from_utf8_lossy(program.source()).ends_with("G0 X0 Y0 Z5\nN20 G1 X5 F100 (G31)\nM30\n"));
}

#[test]
fn text_that_is_no_word_is_refused() {
    for (line, expected) in [
        (
            "#100=5",
            "part.nc:3:1: `#100=5`: variables and expressions are not read; expected plain numbers, or expand in [gcode] of the process file (--expand), which writes it out",
        ),
        (
            "G1 X[1+2]",
            "part.nc:3:4: `X[1+2]`: variables and expressions are not read; expected plain numbers, or expand in [gcode] of the process file (--expand), which writes it out",
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
            "G1 X0.12345678901234567890123456789012345678901234567890123456789012345",
            "part.nc:3:7: `12345678901234567890123456789012345678901234567890123456789012345`: number has 65 digits in a row; \
             expected at most 64",
        ),
    ] {
        assert_eq!(third(line), expected);
    }
}

#[test]
fn words_that_do_not_go_together_are_refused() {
    for (line, expected) in [
        ("G1 X5 X6", "part.nc:3:7: `X6`: second X word on the line; expected one"),
        (
            "T01 T02 M06",
            "part.nc:3:5: `T02`: second tool on the line, beside T1: which of them is in the spindle decides the force; expected one T; \
             put the tool to be fetched next on a line of its own after M6",
        ),
        ("G0 G1 X5", "part.nc:3:4: `G1`: contradicts G0 on the same line; expected one of them"),
        ("G20 G21", "part.nc:3:5: `G21`: contradicts G20 on the same line; expected one of them"),
        (
            "G4 Y2",
            "part.nc:3:4: `Y2`: coordinate on a line with G4, which is no motion; \
             expected the coordinate on a line of its own",
        ),
        ("G1 X5 I2", "part.nc:3:7: `I2`: arc word on a line that is no arc; expected G2 or G3 in force"),
        (
            "G1 X5 P2",
            "part.nc:3:7: `P2`: parameter that belongs to no word; \
             expected the G or M word on the line",
        ),
        ("M3.5", "part.nc:3:1: `M3.5`: expected a whole number after M"),
        ("F-5", "part.nc:3:1: `F-5`: expected a feed of 0 to 1e9"),
        ("S-5", "part.nc:3:1: `S-5`: expected a spindle speed of 0 to 1e9"),
        ("G1 X2000000", "part.nc:3:4: `X2000000`: coordinate beyond 1000000 mm; expected a position on the machine"),
    ] {
        assert_eq!(third(line), expected);
    }
    assert_eq!(
        refusal("G0 X0 Y0 Z0\nM30\nG0 X5\n%\n"),
        "part.nc:3:4: `X5`: a motion after the end of the program in line 2; expected none"
    );
    assert_eq!(
        refusal("%\nG0 X0 Y0 Z0\n%\nnotes of the shift (M6\nG1 Z5\n"),
        "part.nc:5:4: `Z5`: a motion after the end of the program in line 3; expected none"
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
fn origins_that_are_not_known_are_refused() {
    let unknown = "how G55 stands to the work offset before it is not known; expected its zero in [gcode] of the process \
                   file, or G10 L2 for both";
    assert_eq!(third("G55 G0 X5"), format!("part.nc:3:5: `G0`: {unknown}"));
    assert_eq!(third("G55\nX5"), format!("part.nc:4:1: `X5`: {unknown}"));
    assert_eq!(third("G10 L2 P2 X1 Y1 Z1\nG55 X5"), format!("part.nc:4:5: `X5`: {unknown}"));
    // A given zero is that of G54 as it was.
    assert_eq!(third("G10 L2 P1 X1 Y1 Z1\nX5"), format!("part.nc:4:1: `X5`: {}", unknown.replace("G55", "G54")));
    assert_eq!(
        third("G28 Z0\nG92 Z1"),
        "part.nc:4:1: `G92`: sets the origin where Z is not known after line 3; expected a move to a position before it, \
         or start_mm in [gcode]"
    );
    assert_eq!(
        third("G92 X5\nG52 X1"),
        "part.nc:4:1: `G52`: G52 and G92 in force together mean different things to different controls; expected one of them"
    );
    assert_eq!(
        refusal("G92 X0 Y0 Z0\nG1 X5\nG92.1\nX6\n"),
        format!("part.nc:4:1: `X6`: {}", unknown.replace("G55", "G54"))
    );
}

#[test]
fn rotary_axes_may_be_named_but_not_turned() {
    assert!(
        GcodeProgram::parse(
            "G0 X0 Y0 Z0 A0. C-90\nG1 X5 A0 C-90.0 F9\nG91 A0 X1\n",
            "part.nc",
            &GcodeOptions::default()
        )
        .is_ok()
    );
    assert_eq!(
        third("A0. X1\nX2 A90"),
        "part.nc:4:4: `A90`: turns A, which stood at 0; expected rotary axes that keep one value, or [[gcode.rotary]] in the process file, which says what A turns"
    );
    assert_eq!(
        third("G91 B5"),
        "part.nc:3:5: `B5`: turns B, which stood at 0; expected rotary axes that keep one value, or [[gcode.rotary]] in the process file, which says what B turns"
    );
}

#[test]
fn other_languages_are_named() {
    let other = "not ISO code but another language, such as Sinumerik's or Heidenhain's; expected words such as X10.5, or \
                 --dialect, which says what it is";
    let options = GcodeOptions { dialect: Some(Dialect::Iso), ..GcodeOptions::default() };
    for (line, found) in [
        ("N5 TRAORI", "4: `TRAORI`"),
        ("MSG(\"x\")", "1: `MSG`"),
        ("G1 X=10", "4: `X=10`"),
        ("T=\"D10\"", "1: `T=\"D10\"`"),
    ] {
        let source = format!("G21 G90 G17 F100\nG0 X0 Y0 Z0\n{line}\n");
        let refusal = GcodeProgram::parse(source, "part.nc", &options).unwrap_err().to_string();
        assert_eq!(refusal, format!("part.nc:3:{found}: {other}"));
    }
}

#[test]
fn a_given_start_and_unit_are_used() {
    let options = GcodeOptions {
        unit: Some(kinetostat_programs::gcode::LengthUnit::Inch),
        start_mm: Some(Vector3::new(0.0, 0.0, 25.4)),
        ..GcodeOptions::default()
    };
    let program = GcodeProgram::parse("G1 X2 F10\n", "part.nc", &options).unwrap();
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
    let program = GcodeProgram::parse(source, "part.nc", &options).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    assert_eq!(path.len(), 2);
    let goals: Vec<_> = path.positions_mm().iter().map(|p| p.add_scalar(0.25)).collect();
    let written =
        program.rewrite(&path, &goals, WriteOptions::with_decimals(NumberFormat::new(2, 4).unwrap())).unwrap();
    assert_eq!(
        std::str::from_utf8(written.bytes()).unwrap(),
        "G0 X0.25 Y0.25 Z0.25\n/G81 #5 anything\n/G1 X5 F1\nG0 X7.25\n"
    );
}

#[test]
fn a_path_too_fine_or_from_elsewhere_is_refused() {
    let options = GcodeOptions::default();
    let program = GcodeProgram::parse("G0 X0 Y0 Z0\nG1 X9 F1\n", "part.nc", &options).unwrap();
    let too_fine = program.toolpath(Sampling::new(1.0, 1e-6).unwrap()).unwrap_err();
    assert_eq!(
        too_fine.to_string(),
        "part.nc:2:1: `G1`: path of more than 2000000 points; \
         expected a coarser sampling or a shorter program"
    );
    let other = GcodeProgram::parse("G0 X0 Y0 Z0\nG1 X8 F1\n", "other.nc", &options).unwrap();
    let path = other.toolpath(Sampling::default()).unwrap();
    let refused = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap_err();
    assert_eq!(refused.to_string(), "the path does not belong to program part.nc: expected a path sampled from it");
    let own = program.toolpath(Sampling::default()).unwrap();
    let refused = program.rewrite(&own, &own.positions_mm()[1..], WriteOptions::default()).unwrap_err();
    assert_eq!(refused.to_string(), "9 corrected positions for a path of 10 points: expected one for each point");
    let mut wild = own.positions_mm();
    wild[3].y = f64::INFINITY;
    let refused = program.rewrite(&own, &wild, WriteOptions::default()).unwrap_err();
    assert_eq!(refused.to_string(), "corrected position 3 is (3, inf, 0) mm: expected finite numbers up to 1000000");
}

/// What is wrong with a line of ISO code.
fn fault(line: &str) -> GcodeError {
    let options = GcodeOptions { dialect: Some(Dialect::Iso), ..GcodeOptions::default() };
    GcodeProgram::parse(line, "part.nc", &options).unwrap_err()
}

#[test]
fn other_languages_are_told_apart() {
    assert_eq!(fault("N10 TRAORI").fault, Fault::Language);
    assert_eq!(fault("MSG").fault, Fault::Language);
    assert_eq!(fault("O100 sub").fault, Fault::Variable);
    assert_eq!(fault("GOTO 100").fault, Fault::Variable);
}

#[test]
fn what_is_no_word_is_refused_where_it_stands() {
    for (line, found) in
        [("G1 X Y5", 3..4), ("G1 XY5", 3..6), ("G1 X+-1.0 Y1", 3..9), ("5", 0..1), ("G1 X--1", 3..7), ("X1.2.3", 0..6)]
    {
        let refused = fault(line);
        assert_eq!(refused.fault, Fault::NotAWord, "{line}");
        assert_eq!((refused.column, refused.found.as_str()), (1 + found.start, &line[found]), "{line}");
    }
    for (line, found) in [("G1 X1.5E-05 Y10", 3..11), ("G1 Y2 x1e5", 6..10), ("X 3.E2", 2..6)] {
        let refused = fault(line);
        assert_eq!(refused.fault, Fault::Exponent, "{line}");
        assert_eq!((refused.column, refused.found.as_str()), (1 + found.start, &line[found]), "{line}");
    }
    assert!(GcodeProgram::parse("G21 G90 F100\nG1 X1.5 E-.5\n", "part.nc", &GcodeOptions::default()).is_ok());
    let long = format!("X{}.9", "7".repeat(69));
    let refused = fault(&long);
    assert_eq!(refused.fault, Fault::TooManyDigits { digits: 69 });
    assert_eq!((refused.column, refused.found.as_str()), (2, &long[1..70]));
}

#[test]
fn decimals_outside_the_range_are_refused() {
    assert_eq!(NumberFormat::new(0, 5).unwrap_err().to_string(), "0 decimals for coordinates in mm: expected 1 to 9");
    assert_eq!(
        NumberFormat::new(4, 12).unwrap_err().to_string(),
        "12 decimals for coordinates in inch: expected 1 to 9"
    );
}
