//! Lines and words of G-code programs: where lines end, what is code and what comment, how words are read and edited.

use kinetostat_programs::{
    NumberFormat, Sampling, WriteOptions,
    gcode::{Dialect, Fault, GcodeError, GcodeOptions, GcodeProgram},
};
use nalgebra::Vector3;
use proptest::prelude::*;

use crate::support::cases::cases;

fn parse(source: impl Into<Vec<u8>>, options: &GcodeOptions) -> Result<GcodeProgram, GcodeError> {
    GcodeProgram::parse(source, "part.nc", options)
}

/// Where the moves of a program lead.
fn ends(source: impl Into<Vec<u8>>) -> Result<Vec<[f64; 3]>, GcodeError> {
    let path = parse(source, &GcodeOptions::default())?.toolpath(Sampling::new(1.0, 1e3).unwrap())?;
    Ok(path.positions_mm().into_iter().map(Into::into).collect())
}

/// Where a line leads behind two of which all is known.
fn end(line: &[u8]) -> Result<[f64; 3], GcodeError> {
    let source = [b"G21 G90 G1 F100\nX0 Y0 Z0\n", line].concat();
    Ok(*ends(source)?.last().unwrap())
}

#[test]
fn lines_end_whatever_their_endings() {
    let source = "G21 G90\r\nG0 X0 Y0 Z0\n\rG1 X1 F100\r\r\n\nX2\rX3";
    let program = parse(source, &GcodeOptions::default()).unwrap();
    assert_eq!(program.line_count(), 7);
    let path = program.toolpath(Sampling::default()).unwrap();
    let written = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
    assert_eq!(written.bytes(), source.as_bytes());
    let refused = parse(format!("{source}\rX"), &GcodeOptions::default()).unwrap_err();
    assert_eq!((refused.line, refused.column), (8, 1));
    assert_eq!(parse("", &GcodeOptions::default()).unwrap().line_count(), 0);
}

#[test]
fn comments_marks_and_messages_are_no_words() {
    for line in [
        "/2 G1(Ø6 mm)X1.5 ; für ( alles".as_bytes(),
        b"N5 M117 Ready, 100 %!\nX1.5",
        b"?\nX1.5",
        b"(\xff\xfe) X1.5",
        b"(a (b (c)) ) X1.5",
    ] {
        assert_eq!(end(line).unwrap(), [1.5, 0.0, 0.0], "{}", String::from_utf8_lossy(line));
    }
    let refused = end("/2 G1(Ø6 mm)X1.5.2 ; für".as_bytes()).unwrap_err();
    assert_eq!((refused.column, refused.found.as_str()), (13, "X1.5.2"));
    assert_eq!(end(b"(a (b) X5)").unwrap_err().fault, Fault::NestedComment);
    // Within percent signs, behind a mark of UTF-8, with Fanuc's old mark of a program.
    let within = "\u{feff}% main\n:1000\nG21 G90 G1 X1.5 Y0 Z0 F100\n  % end\nanything";
    assert_eq!(ends(within).unwrap(), [[1.5, 0.0, 0.0]]);
    // Homing leads nobody knows where to, a question nowhere.
    let known = |command: &str| ends(format!("G21 G90 G0 X0 Y0 Z0\n{command}\nG1 X1 F100\n")).unwrap().len();
    assert_eq!([known("$H"), known("?")], [1, 2]);
}

#[test]
fn numbers_of_codes_are_exact() {
    assert!(parse("G90.1\n", &GcodeOptions::default()).is_ok());
    assert_eq!(end(b"G002 X2 I1").unwrap(), [2.0, 0.0, 0.0]);
    for code in ["G1.05", "G-1"] {
        assert_eq!(end(code.as_bytes()).unwrap_err().found, code);
    }
}

#[test]
fn words_are_read_whatever_their_style() {
    for line in ["G1 X.5Y-.25 Z+3.", "N10 g01x0.5y-.25z3", "g 1 X  .5Y -.25 Z +3.0", "G1Z3Y-.250X+0.5"] {
        assert_eq!(end(line.as_bytes()).unwrap(), [0.5, -0.25, 3.0], "{line}");
    }
    assert_eq!(end(b"Z123456.789012").unwrap(), [0.0, 0.0, 123456.789012]);
}

proptest! {
    #![proptest_config(cases(256))]

    /// A blank behind a letter takes the line the long way, words alone the short one.
    #[test]
    fn a_blank_behind_a_letter_changes_nothing(
        words in prop::collection::vec("[XYZxyzIGO][+-]?[0-9]{0,3}[.]?[0-9]{0,3}", 1..6),
        gaps in prop::collection::vec("[ ]{0,2}", 6),
        parted in 0..6usize,
    ) {
        let line = |blank_at: Option<usize>| {
            let blank = |k| if blank_at == Some(k) { " " } else { "" };
            let text = |(k, word): (usize, &String)| format!("{}{}{}{}", gaps[k], &word[..1], blank(k), &word[1..]);
            // Of several faults, another may be named first.
            end(words.iter().enumerate().map(text).collect::<String>().as_bytes()).ok()
        };
        prop_assert_eq!(line(None), line(Some(parted % words.len())));
    }
}

#[test]
fn words_are_added_in_the_style_of_the_line() {
    let shifted = |line: &str, by: Vector3<f64>| {
        let program = parse(format!("G21 G90\nG0 X0 Y0 Z0\n{line}\n"), &GcodeOptions::default()).unwrap();
        let path = program.toolpath(Sampling::new(10.0, 5.0).unwrap()).unwrap();
        let goals: Vec<_> =
            path.positions_mm().into_iter().map(|p| p + if p == Vector3::zeros() { p } else { by }).collect();
        let written =
            program.rewrite(&path, &goals, WriteOptions::with_decimals(NumberFormat::new(1, 3).unwrap())).unwrap();
        String::from_utf8(written.into_bytes()).unwrap().lines().nth(2).unwrap().to_owned()
    };
    let by_y = |line: &str| shifted(line, Vector3::new(0.0, 2.0, 0.0));
    assert_eq!(by_y("G1 X1 Z3  (c)"), "G1 X1 Y2.0 Z3  (c)");
    assert_eq!(shifted("g01y3f5", Vector3::new(2.0, 0.0, 0.0)), "g01x2.0y3f5");
    let full = Vector3::new(0.0, 0.0, 0.5);
    assert_eq!(shifted("N1 G3 (c) I5 J0 F9 ", full), "N1 G1 X1.9 Y-3.9 Z0.5 (c) F9 ");
    assert_eq!(shifted("\tG02X10 I5 F9", full), "\tG01X1.5 Y3.5 Z0.5 F9");
}

#[test]
fn the_longest_text_begins_a_feature_and_no_part_of_a_word_does() {
    let features = ["pocket 1", "Pocket 1 finish", "N20"].map(String::from).to_vec();
    let of = |features: &[String], line: &str| {
        let options =
            GcodeOptions { features: features.to_vec(), dialect: Some(Dialect::Iso), ..GcodeOptions::default() };
        let program = parse(format!("G21 G90 G1 F100\n{line}\nX9 Y0 Z0\n"), &options).unwrap();
        program.toolpath(Sampling::default()).unwrap().points().last().unwrap().feature
    };
    for (line, feature) in [
        ("(POCKET 1)", Some(0)),
        ("; pocket 1 FINISH, 3 mm", Some(1)),
        ("(POCKET 12)", None),
        ("N200 G0 X1", None),
        ("N20G0X1", None),
        ("N20 G0 X1", Some(2)),
    ] {
        assert_eq!(of(&features, line), feature, "{line}");
    }
    assert_eq!(of(&[String::new()], "G0"), None);
}

#[test]
fn letters_of_macro_calls_are_those_of_the_control() {
    let numbers = [1, 2, 3, 7, 8, 9, 11, 4, 5, 6, 13, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26];
    for (letter, number) in "ABCDEFHIJKMQRSTUVWXYZ".chars().zip(numbers) {
        let called = |letter: char| {
            let source =
                format!("%\nO1\nG21 G90 G1 F100\nX0 Y0 Z0\nG65 P2 {letter}7.\nM30\nO2\nG1 X#{number}\nM99\n%\n");
            let options = GcodeOptions { dialect: Some(Dialect::Iso), ..GcodeOptions::default() };
            let program = GcodeProgram::parse_expanded(source, "part.nc", &options, &|_| None).unwrap();
            program.toolpath(Sampling::default()).unwrap().positions_mm().last().unwrap().x
        };
        assert_eq!(called(letter), 7.0, "{letter}");
    }
}
