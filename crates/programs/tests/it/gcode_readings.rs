//! Words that controls read in ways that contradict, and functions that may change where the tool goes.

use kinetostat_programs::{
    Sampling, WriteOptions,
    gcode::{Dialect, GcodeError, GcodeOptions, GcodeProgram},
};
use nalgebra::Vector3;

fn read_as(source: &str, dialect: Option<Dialect>) -> Result<Vec<Vector3<f64>>, GcodeError> {
    let options = GcodeOptions { dialect, ..GcodeOptions::default() };
    let program = GcodeProgram::parse(source, "part.nc", &options).or_else(|refused| {
        match refused.fault.may_vanish_on_expansion() {
            true => GcodeProgram::parse_with_calls(source, "part.nc", &options, &|_| None),
            false => Err(refused),
        }
    })?;
    Ok(program.toolpath(Sampling::new(1.0, 1e6).unwrap())?.positions_mm())
}

/// Returns a program with its cycles written out, and its text.
fn written_out(source: &str) -> (GcodeProgram, String) {
    let program = GcodeProgram::parse_expanded(source, "part.nc", &GcodeOptions::default(), &|_| None).unwrap();
    let text = String::from_utf8(program.source().to_vec()).unwrap();
    (program, text)
}

const KEY: &str = "; expected dialect = \"fanuc\", \"haas\" or \"linuxcnc\" in [gcode] of the process file (--dialect), which says whose it is";

fn contradicts(source: &str, expected: &str) {
    for dialect in [None, Some(Dialect::Iso)] {
        assert_eq!(read_as(source, dialect).unwrap_err().to_string(), format!("part.nc:{expected}{KEY}"));
    }
}

#[test]
fn whose_g10_l20_it_is_must_be_said() {
    let at = Vector3::new;
    for source in [
        "%\nO1\nG21 G90 G17 G54\nG0 X0 Y0 Z5\nG1 X10 F100\nG10 L20 P1 X-250. Y-120. Z-300.\nG1 X20\nM30\n%\n",
        "G21 G90 G17 G54\nO1\n\n(c)\nG0 X0 Y0 Z5 F100\nG10 L20 P1 X-250. Y-120. Z-300.\nG1 X20\nM98 P7\nM30\nO7\nM99\n",
    ] {
        let source = source.replace("O1\n\n(c)\n", "(a)\n(b)\n(c)\n");
        contradicts(
            &source,
            "6:1: `G10`: G10 L20 P1 puts G54.1 P1 at these machine coordinates on Fanuc and Haas, and on LinuxCNC and Grbl gives these \
             coordinates of G54 to where the tool is",
        );
        for dialect in [Dialect::Fanuc, Dialect::Haas] {
            assert_eq!(read_as(&source, Some(dialect)).unwrap().last(), Some(&at(20.0, 0.0, 5.0)));
        }
        let last = *read_as(&source, Some(Dialect::LinuxCnc)).unwrap().last().unwrap();
        assert_eq!(last.yz(), nalgebra::Vector2::new(0.0, 5.0));
        assert!(last.x > 250.0);
    }
    // There it says how G54.1 P1 stands to the others.
    let source =
        "G21 G90\nG10 L2 P1 X-400 Y-250 Z-100\nG10 L20 P3 X-300 Y-240 Z-99.5\nG54 G0 X0 Y0 Z0\nG54.1 P3 X1 Y1 Z1\n";
    assert_eq!(read_as(source, Some(Dialect::Fanuc)).unwrap()[1], at(101.0, 11.0, 1.5));
    let refused = read_as("G91\nG10 L20 P1 X5\n", Some(Dialect::Haas)).unwrap_err().to_string();
    assert!(refused.contains("this G10 is not read") && refused.ends_with("(read as Haas)"), "{refused}");
}

#[test]
fn whose_g43_1_and_round_it_is_must_be_said() {
    let source = "G0 X0 Y0 Z9\nG43.1 Z5\nG1 X1 F9\n";
    contradicts(
        source,
        "2:1: `G43.1`: G43.1 with X, Y or Z moves there on Fanuc, and on LinuxCNC and Grbl sets the length of the tool",
    );
    assert_eq!(read_as(source, Some(Dialect::LinuxCnc)).unwrap()[1], Vector3::new(1.0, 0.0, 9.0));
    let source = "G0 X0 Y0 Z0\n#1=2.345\nG1 X[ROUND[#1]] F9\n";
    contradicts(
        source,
        "3:4: `X[ROUND[#1]] F9`: ROUND in the number of a word rounds to the last decimal of a coordinate on Fanuc and Haas, and on LinuxCNC \
         to a whole number",
    );
    assert_eq!(read_as(source, Some(Dialect::LinuxCnc)).unwrap()[1].x, 2.0);
    // Both say the same of these.
    assert_eq!(
        read_as("G0 X0 Y0 Z0\n#1=[ROUND[2.345]]\nG1 X#1 Y[ROUND[3.]] F9\n", None).unwrap()[1].xy(),
        nalgebra::Vector2::new(2.0, 3.0)
    );
    let source = "G0 X0 Y0 Z0\nG1 X[[-7] MOD 3] F9\n";
    assert!(read_as(source, None).unwrap_err().to_string().contains("expected MOD of no negative number"));
    assert_eq!(read_as(source, Some(Dialect::LinuxCnc)).unwrap()[1].x, 2.0);
}

#[test]
fn a_place_that_some_controls_go_to_and_others_keep_is_not_known_behind_it() {
    // Mach goes home with G28.1, Fanuc to a floating place with G30.1: what follows stays as it is until all is given again.
    for word in ["G28.1", "G30.1"] {
        let source = format!("G21 G90 F99\nG0 X0 Y0 Z5\n{word}\nG1 X5\nG0 X1 Y1 Z1\nG1 X2\n");
        assert_eq!(read_as(&source, None).unwrap().len(), 3);
        assert_eq!(read_as(&source, Some(Dialect::LinuxCnc)).unwrap().len(), 4);
    }
}

#[test]
fn g92_1_ends_g52_as_well_and_of_fanuc_axis_by_axis() {
    let x = |source: &str| read_as(source, None).unwrap().last().unwrap().x;
    assert_eq!(x("G21 G90\nG0 X0 Y0 Z0\nG52 X10\nX5\nG92.1\nX5 Y1\n"), 5.0);
    assert_eq!(x("G21 G90\nG0 X0 Y0 Z0\nG92 X10 Y10\nG92.1 Y0\nX11 Y1\n"), 1.0);
    assert!(read_as("G0 X0 Y0 Z0\nG52 X10\nG92.2\nX5\n", None).unwrap_err().to_string().contains("G52 and G92"));
}

#[test]
fn functions_that_may_change_where_the_tool_goes_are_refused_by_name() {
    let (iso, linuxcnc, fanuc, haas) = (None, Some(Dialect::LinuxCnc), Some(Dialect::Fanuc), Some(Dialect::Haas));
    for (lines, reason, refusing, kept) in [
        (vec!["M21", "M22", "M23"], "mirrors axes on some controls", vec![iso, linuxcnc, fanuc], vec![haas]),
        (
            vec!["M128", "M129", "M428", "M429", "M430"],
            "tool-tip programming (X, Y and Z of the tip)",
            vec![iso, linuxcnc],
            vec![fanuc, haas],
        ),
        (
            vec!["M206 X5", "M218 T1 X5", "M290 Z0.1"],
            "moves the zero or the tool (Marlin)",
            vec![iso, linuxcnc],
            vec![],
        ),
        (vec!["M47"], "runs the program from its first line again", vec![iso, linuxcnc], vec![fanuc, haas]),
        (vec!["M46 Q1 P10", "M96 P10", "M96 P10 Q4"], "goes on elsewhere", vec![iso, linuxcnc, fanuc, haas], vec![]),
        (vec!["M109 P501"], "asks for the value of a variable", vec![iso, fanuc, haas], vec![]),
    ] {
        for line in lines {
            let source = format!("G21 G90 F99\nG0 X0 Y0 Z5\n{line}\nG1 X5\n");
            for dialect in &refusing {
                let refused = read_as(&source, *dialect).unwrap_err().to_string();
                let name = line.split(' ').next().unwrap();
                assert!(
                    refused.starts_with(&format!("part.nc:3:1: `{name}`: ")) && refused.contains(reason),
                    "{refused}"
                );
            }
            for dialect in &kept {
                assert_eq!(read_as(&source, *dialect).unwrap().last(), Some(&Vector3::new(5.0, 0.0, 5.0)));
            }
        }
    }
    // Turns of LinuxCNC's arcs, which a function beside them does not take.
    assert!(read_as("G0 X0 Y0 Z0\nG2 X0 Y0 I5 P2 M8 F9\n", None).unwrap_err().to_string().contains("`P2`"));
    // Machines heat, and say what they do, as before.
    assert!(read_as("M109 S200\nM104 S210\nM106 P1 S255\nG0 X0 Y0 Z0\nM8\nM46\nG1 X1 F9\nM221 S95\n", None).is_ok());
}

/// To LinuxCNC no motion is in force behind G80, and it refuses a place then; to the others the motion before the cycles is.
#[test]
fn g80_gives_back_the_motion_before_the_cycles() {
    let source = "G21 G90 F100\nG0 X0 Y0 Z5\nG1 X1\nG81 X2 Y2 Z-1 R1\nX3\nG80\nX5 Y5\nM30\n";
    for dialect in [None, Some(Dialect::Iso), Some(Dialect::Fanuc), Some(Dialect::Haas)] {
        let options = GcodeOptions { dialect, ..GcodeOptions::default() };
        let program = GcodeProgram::parse(source, "part.nc", &options).unwrap();
        let path = program.toolpath(Sampling::new(1.0, 1e6).unwrap()).unwrap();
        let last = path.points().last().unwrap();
        assert_eq!(last.position_mm, Vector3::new(5.0, 5.0, 5.0), "{dialect:?}");
        assert!(last.cutting, "{dialect:?}: the feed motion before the cycle is in force again");
        // What nothing corrects keeps its bytes, with G80 before the place and beside it.
        for source in [source.to_string(), source.replace("G80\nX5", "G80X5")] {
            let program = GcodeProgram::parse(source.as_str(), "part.nc", &options).unwrap();
            let path = program.toolpath(Sampling::new(1.0, 1e6).unwrap()).unwrap();
            let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
            assert_eq!(same.bytes(), source.as_bytes());
        }
    }
    let refused = read_as(source, Some(Dialect::LinuxCnc)).unwrap_err().to_string();
    assert!(refused.starts_with("part.nc:7:1: `X5`: coordinate without a motion"), "{refused}");
    // Beside a cycle, controls differ.
    for line in ["G81 X12 Y2 Z-5 R2 G80", "G80 G81 X12 Y2 Z-5 R2"] {
        let refused = read_as(&format!("G21 G90 F100\nG0 X0 Y0 Z9\n{line}\n"), None).unwrap_err().to_string();
        assert!(refused.starts_with("part.nc:3:"), "{refused}");
    }
    // Written out, the moves of the cycle set another motion, so that the line says its own.
    let (program, text) = written_out(source);
    assert!(text.contains("G80\nG1 X5 Y5\n"), "{text}");
    for (behind, written) in [("G53 Z50", "\nG53 G1 Z50\n"), ("A9", "\nG1 A9\n")] {
        let (_, text) = written_out(&source.replace("X5 Y5", behind));
        assert!(text.contains(written), "{text}");
    }
    let path = program.toolpath(Sampling::new(1.0, 1e6).unwrap()).unwrap();
    assert!(path.points().last().unwrap().cutting);
}

/// Where the height is not known, a hole ends where it begins, which is not to drill nothing.
#[test]
fn holes_at_unknown_heights_stay() {
    let source = "G21 G90 F100\nG0 X5 Y5 Z12\nG53 Z50\nG81 Z-5 R2\nG81 L0\nX9\nG80\nM30\n";
    let (program, text) = written_out(source);
    assert!(text.contains("\nG81 Z-5 R2\nG81 L0\nX9\nG80\n"), "{text}");
    assert_eq!(program.notes().unlocated_lines, [4, 6]);
}

/// What posts write that says nothing of where the tool goes, and numbers as they come.
#[test]
fn words_of_posts_that_move_nothing_are_read() {
    for line in ["G61.1 ,K80", "G61.1,K5 (corners)", "G05.1 Q1 R5", "G69.1", "G5.1 Q0"] {
        let source = format!("G21 G90 F100\nG0 X0 Y0 Z5\n{line}\nG1 X4\n");
        let path = read_as(&source, None).unwrap_or_else(|error| panic!("{line}: {error}"));
        assert_eq!(path.last(), Some(&Vector3::new(4.0, 0.0, 5.0)), "{line}");
    }
    for line in ["G1 X5 ,K80", "G61.1 ,R5", "G61 ,K80"] {
        let refused = read_as(&format!("G21 G90 F100\nG0 X0 Y0 Z5\n{line}\n"), None).unwrap_err().to_string();
        assert!(refused.contains("corners that the control rounds or bevels"), "{line}: {refused}");
    }
    let path = read_as("G21 G90 F100\nG0 X0 Y0 Z5\nG1 X1.123456789012345678901234567890\n", None).unwrap();
    assert_eq!(path.last(), Some(&Vector3::new(1.123_456_789_012_345_7, 0.0, 5.0)));
}

/// As rs274 has it: 0.0005 inch in programs in inches, 0.005 mm in others.
#[test]
fn radii_of_arcs_in_inches_may_differ_as_inches_round() {
    let end = |off: f64| format!("G2 X0.1 Y{} I0.1 J0", 0.1 + off);
    let read = |unit: &str, off: f64| read_as(&format!("{unit} G90 F10\nG0 X0 Y0 Z0\n{}\n", end(off)), None);
    assert!(read("G20", 0.0004).is_ok());
    let refused = read("G20", 0.0006).unwrap_err().to_string();
    assert!(refused.ends_with("expected equal radii to 0.0127 mm or 0.1 %"), "{refused}");
    assert!(read("G21", 0.004).is_ok());
    assert!(read("G21", 0.006).unwrap_err().to_string().ends_with("expected equal radii to 0.005 mm or 0.1 %"));
}
