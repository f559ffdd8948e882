//! Heidenhain's programs that compute, branch and call, written out as the motion they make.

use kinetostat_programs::{
    Sampling, WriteOptions,
    gcode::{Calls, Dialect, GcodeError, GcodeOptions, GcodeProgram},
};

fn beside(name: &str) -> Option<Vec<u8>> {
    let text = match name {
        "Step.h" => "0 BEGIN PGM Step MM\n1 L IX+Q1\n2 QL1 = 3\n3 L Y+QL1\n4 END PGM Step MM\n",
        "100.nc" => "BEGIN PGM 100 MM\nLBL 1\nL IY+1\nCALL LBL 1 REP 1\nEND PGM 100 MM\n",
        "INCHES.H" => "BEGIN PGM I INCH\nEND PGM I INCH\n",
        "STOPS.H" => "BEGIN PGM S MM\nM30\nEND PGM S MM\n",
        _ => return None,
    };
    Some(text.into())
}

fn expanded(blocks: &str) -> Result<GcodeProgram, GcodeError> {
    let source = format!(
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000 F100\nL X+0 Y+0 Z+0 R0 FMAX\n{blocks}\nM30\nLBL 50\nL IZ-1\nLBL 0\nEND PGM A MM\n"
    );
    GcodeProgram::parse_expanded(source, "a.h", &GcodeOptions::default(), &beside)
}

/// What `blocks` are written out as, behind a start at the origin.
fn moves(blocks: &str) -> Vec<String> {
    let program = expanded(blocks).unwrap_or_else(|error| panic!("{error}"));
    let path = program.toolpath(Sampling::new(0.1, 2.0).unwrap()).unwrap();
    let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
    assert_eq!(same.bytes(), program.source());
    let lines: Vec<_> = String::from_utf8(program.source().to_vec()).unwrap().lines().map(String::from).collect();
    assert_eq!(lines[lines.len() - 2..], ["M30", "END PGM A MM"]);
    lines[4..lines.len() - 2].to_vec()
}

#[test]
fn formulas_have_the_values_of_the_manual() {
    for (formula, value) in [
        ("Q1 = 2 + 3 * 4", "+14.0"),
        ("Q1 = ( 2 + 3 ) * 4", "+20.0"),
        ("Q1 = SIN 30", "+0.5"),
        ("Q2 = 60\nQ1 = COS Q2 + 1", "+1.5"),
        ("Q1 = SQRT 25 - SQ 2", "+1.0"),
        ("Q1 = ATAN ( 1 / 1 )", "+45.0"),
        ("Q1 = 2 ^ 3", "+8.0"),
        ("Q1 = 400 % 360", "+40.0"),
        ("Q1 = INT 4,7 + FRAC 2.5", "+4.5"),
        ("Q1 = NEG ABS -3", "-3.0"),
        ("Q1 = SGN -7", "-1.0"),
        ("Q1 = LOG 100 + LN EXP 1", "+3.0"),
        ("Q1 = PI", "+3.1415927"),
        ("FN 0: Q1 = +60", "+60.0"),
        ("FN1 : Q1 = -2 + -5", "-7.0"),
        ("FN 2: Q1 = +10 - +5", "+5.0"),
        ("FN 3: Q1 = +3 * +3", "+9.0"),
        ("Q2 = 8\nFN 4: Q1 = +4 DIV +Q2", "+0.5"),
        ("FN 5: Q1 = SQRT 4", "+2.0"),
        ("Q5 = 30\nFN 6: Q1 = SIN -Q5", "-0.5"),
        ("FN 7: Q1 = COS 60", "+0.5"),
        ("FN 8: Q1 = +3 LEN +4", "+5.0"),
        ("FN 13: Q1 = +1 ANG -1", "+135.0"),
    ] {
        assert_eq!(moves(&format!("{formula}\nL X+Q1")), [format!("L X{value}")], "{formula}");
    }
}

#[test]
fn parameters_stand_for_any_number() {
    assert_eq!(
        moves("Q1 = 2.5\nQ2 = -300\nL X-Q1 IY+Q1 Z Q2 R0 F AUTO M8 ; Q1"),
        ["L X-2.5 IY+2.5 Z -300.0 R0 F AUTO M8 ; Q1"]
    );
    assert_eq!(
        moves("Q3 = 450\nL X+5 FQ3\nCYCL DEF 7.0 DATUM\nCYCL DEF 7.1 X+Q3\nCYCL DEF 9.0 DWELL\nCYCL DEF 9.1 DWELL Q3"),
        ["L X+5 F450", "CYCL DEF 7.0 DATUM", "CYCL DEF 7.1 X+450.0", "CYCL DEF 9.0 DWELL", "CYCL DEF 9.1 DWELL 450"]
    );
    assert_eq!(moves("Q1=5\nTOOL CALL Q1 Z S Q1\nL X+10\nRND RQ1\nL X+10 Y+10").len(), 5);
    // Those of a cycle are set too.
    let cycle = moves(
        "Q5 = 3\nCYCL DEF 200 DRILLING ~\n Q200=2 ~\n Q201=-Q5 ~\n Q206=60 ~\n Q202=9 ~\n Q203=+0 ;TOP\nL X+Q200 FMAX M99",
    );
    assert_eq!(cycle[1..5], ["L X+2.0 FMAX", "L Z+2 R0 FMAX", "L Z-3 R0 F60", "L Z+2 R0 FMAX"]);
    let in_a_line = moves(
        "Q5 = 3\nCYCL DEF 201 REAMING Q200=2 Q201=-Q5 Q206=60 Q208=MAX Q203=+0 ;Q7=\nL X+Q200 FMAX M99\nCYCL DEF 247 DATUM SETTING Q339=+1",
    );
    assert_eq!(in_a_line[1..4], ["L X+2.0 FMAX", "L Z+2 R0 FMAX", "L Z-3 R0 F60"]);
    assert_eq!(in_a_line[4..], ["L Z+2 R0 FMAX", "L F AUTO", "CYCL DEF 247 DATUM SETTING Q339=+1"]);
}

#[test]
fn labels_are_called_repeated_and_jumped_to() {
    assert_eq!(moves("CALL LBL 50\nL X+5\nCALL LBL 50"), ["L IZ-1", "L X+5", "L IZ-1"]);
    assert_eq!(moves("LBL 1\nL IX+1\nLBL 2\nL IY+1\nCALL LBL 2 REP 1\nCALL LBL 1 REP 2/2").len(), 9);
    assert_eq!(moves("LBL \"Turn\"\nL IX+1\nCALL LBL \"Turn\" REP1/1"), ["L IX+1", "L IX+1"]);
    let jumps = "Q1 = 1\nLBL 1\nQ1 = Q1 + 1\nL X+Q1\nFN 12: IF +Q1 LT +3 GOTO LBL 1\nFN 9: IF +Q1 EQU +3 GOTO LBL 7\nL X+99\nLBL 7\nFN 10: IF +Q1 NE +3 GOTO LBL 1\nFN 11: IF +Q1 GT +3 GOTO LBL 1";
    assert_eq!(moves(jumps), ["L X+2.0", "L X+3.0"]);
}

#[test]
fn programs_beside_are_called() {
    assert_eq!(moves("Q1 = 4\nCALL PGM TNC:\\parts\\Step.h"), ["1 L IX+4.0", "3 L Y+3.0"]);
    assert_eq!(moves("CALL PGM100"), ["L IY+1", "L IY+1"]);
}

#[test]
fn blocks_that_are_written_out_have_rising_numbers() {
    let source = "($Message(\"settings\"))\n0 BEGIN PGM A MM\n1 TOOL CALL 1 Z\n2 L X+0 Y+0 Z+0 FMAX\n3 LBL 1\n4 L IX+1 F50\n5 CALL LBL 1 REP 2\n6 END PGM A MM\n";
    let program = GcodeProgram::parse_expanded(source, "a.h", &GcodeOptions::default(), &beside).unwrap();
    assert_eq!(program.notes().dialect, Dialect::Heidenhain);
    let text = String::from_utf8(program.source().to_vec()).unwrap();
    let numbers: Vec<u32> = text.lines().filter_map(|line| line.split(' ').next()?.parse().ok()).collect();
    assert!(numbers.len() == 7 && numbers.windows(2).all(|pair| pair[0] < pair[1]), "{text}");
}

#[test]
fn labels_stay_where_they_can() {
    let source = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z\n2 L X+0 Y+0 Z+0 FMAX\n3 CALL LBL 1\n4 L X+20 Y+10 F50\n5 M30\n6 LBL 1\n7 L X+9 F50\n8 LBL 0\n9 END PGM A MM\n";
    let program = GcodeProgram::parse_with_calls(source, "a.h", &GcodeOptions::default(), &beside).unwrap();
    let path = program.toolpath(Sampling::new(0.1, 200.0).unwrap()).unwrap();
    let folded = |by: f64, bend: f64| {
        let mut goals: Vec<_> =
            path.positions_mm().into_iter().map(|p| p + nalgebra::Vector3::new(0.0, by, 0.0)).collect();
        let middle = goals.len() - 1;
        goals[middle].z += bend;
        let rewritten = program.rewrite(&path, &goals, WriteOptions::default()).unwrap();
        match program.folded_calls(&rewritten).unwrap() {
            Calls::Stay { program, .. } => String::from_utf8(program).unwrap(),
            Calls::WrittenOut(why) => panic!("{why}"),
        }
    };
    assert_eq!(folded(0.0, 0.0), source);
    assert_eq!(folded(0.0, 0.25), source.replace("4 L X+20 Y+10 F50", "4 L X+20 Y+10 Z+0.2500 F50"),);
    let lifted = folded(0.5, 0.0);
    assert!(lifted.contains("\n3 CALL LBL 1\n4 L X+20 Y+10.5000 F50\n"), "{lifted}");
}

#[test]
fn what_is_not_known_is_refused() {
    for (blocks, why) in [
        ("L X+Q1", "a variable without a value"),
        ("Q1 = Q108 + 1", "a variable without a value"),
        ("Q1 = SGN 0", "expected SGN of a number other than 0"),
        ("Q1 = 1 / 0", "its value is no number"),
        ("Q1 = 5 X", "expected the end of the block"),
        ("QS1 = \"A\"", "parameters, variables and expressions are not followed"),
        ("FN 18: SYSREAD Q1 = ID270 NR1 IDX1", "depends on the state of the machine"),
        ("FN 14: ERROR=1000", "parameters, variables and expressions are not followed"),
        ("FN 9: IF +1 EQU +1 GOTO LBL 99", "its other end is not in the program"),
        (
            "FN 9: IF +0.1 EQU +0.10000000000001 GOTO LBL 50",
            "expected numbers that are equal, or differ by more than rounding",
        ),
        ("CALL LBL 99", "its other end is not in the program"),
        ("LBL 1\nCALL LBL 1", "calls are more than 50 deep"),
        ("LBL 1\nL IX+1\nCALL LBL 1 REP 0.5", "expected REP and a whole number"),
        ("CALL PGM NONE", "subprogram NONE is neither in the file nor beside it; expected a file of this name"),
        ("CALL PGM INCHES", "expected the unit of the program that calls"),
        ("CALL PGM STOPS", "expected no M2 or M30 in a program that is called"),
        ("SEL PGM \"A\"", "calls a subprogram"),
        ("PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY", "no rotary axes are known"),
        ("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+35", "rotated, scaled, mirrored"),
        ("CYCL END", "cycles are not followed"),
    ] {
        let found = expanded(blocks).expect_err(blocks).to_string();
        assert!(found.contains(why) && found.ends_with("(read as Heidenhain)"), "{blocks}: {found}");
    }
}
