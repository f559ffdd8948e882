//! Drilling cycles of Sinumerik and Heidenhain, written out as the moves they make.

use kinetostat::toolpath::{
    NumberFormat, Sampling,
    gcode::{Dialect, GcodeError, GcodeOptions, Program},
};

fn expanded(source: &str) -> Result<Program, GcodeError> {
    Program::parse_expanded(source, "part", &GcodeOptions::default(), &|_| None)
}

/// The lines of `source` written out; without correction they stay as they are.
fn lines(source: &str) -> Vec<String> {
    let program = expanded(source).unwrap_or_else(|error| panic!("{error}"));
    let path = program.toolpath(Sampling::new(0.05, 1e4).unwrap()).unwrap();
    let same = program.rewrite(&path, &path.positions_mm(), NumberFormat::default()).unwrap();
    assert_eq!(same.bytes(), program.source());
    String::from_utf8(program.source().to_vec()).unwrap().lines().map(String::from).collect()
}

/// Places where the tool turns, mm.
fn corners(source: &str) -> Vec<[f64; 3]> {
    let program = expanded(source).unwrap();
    let path = program.toolpath(Sampling::new(0.05, 1e4).unwrap()).unwrap();
    path.points().iter().filter(|p| p.source.parameter == 1.0).map(|p| p.position_mm.into()).collect()
}

#[test]
fn sinumerik_drills_where_it_stands_and_behind_each_block() {
    let source = "%_N_PART_MPF\n; drilling=\nN10 G17 G90 G54 G71\nN20 G0 X10 Y20 Z50\nN30 CYCLE82(30,5,2,-10,,0.5) ; one\nN40 G1 X15 F100\n\
                  N50 MCALL CYCLE81(30,5,2,,12)\nX25 Y5\n  IX=3\nY=IC(5)\nMCALL\nX0\nM30\n";
    let source = source.replace("  IX=3\n", "F80\n");
    assert_eq!(
        lines(&source),
        [
            "%_N_PART_MPF",
            "; drilling=",
            "; written out by kinetostat: 24 lines for 13",
            "N10 G17 G90 G54 G71",
            "N20 G0 X10 Y20 Z50",
            "; one",
            "G0 Z=AC(7)",
            "G1 Z=AC(-10)",
            "G4 F0.5",
            "G0 Z=AC(30)",
            "N40 G1 X15 F100",
            "X25 Y5",
            "G0 Z=AC(7)",
            "G1 Z=AC(-7)",
            "G0 Z=AC(30)",
            "G1",
            "F80",
            "Y=IC(5)",
            "G0 Z=AC(7)",
            "G1 Z=AC(-7)",
            "G0 Z=AC(30)",
            "G1",
            "X0",
            "M30",
        ]
    );
    let bottoms: Vec<_> = corners(&source).into_iter().filter(|place| place[2] < 0.0).collect();
    assert_eq!(bottoms, [[10.0, 20.0, -10.0], [25.0, 5.0, -7.0], [25.0, 10.0, -7.0]]);
}

#[test]
fn sinumerik_drills_on_a_circle() {
    let source = "DEF REAL TOP=5\nG17 G90 G54 G71\nG0 X10 Y20 Z50\nF100\nMCALL CYCLE81(TOP+25,TOP,2,,12)\nHOLES2(10,20,5,90,0,4)\nMCALL\nM30\n";
    let bottoms: Vec<_> = corners(source).into_iter().filter(|place| place[2] < 0.0).collect();
    for (found, expected) in bottoms.iter().zip([[10.0, 25.0], [5.0, 20.0], [10.0, 15.0], [15.0, 20.0]]) {
        assert!(
            (found[0] - expected[0]).abs() + (found[1] - expected[1]).abs() < 1e-6 && found[2] == -7.0,
            "{found:?}"
        );
    }
    assert_eq!(bottoms.len(), 4);
    for pattern in ["HOLES2(10,20,5,90,0,0)", "HOLES2(10,20,5,90)", "HOLES1(10,20,0,5,5,3)"] {
        assert!(expanded(&source.replace("HOLES2(10,20,5,90,0,4)", pattern)).is_err(), "{pattern}");
    }
    let polar = source.replace("HOLES2(10,20,5,90,0,4)", "G0 AP=90 RP=5\nAP=180");
    let bottoms: Vec<_> = corners(&polar).into_iter().filter(|place| place[2] < 0.0).collect();
    assert!(bottoms.len() == 2 && (bottoms[1][0] + 5.0).abs() < 1e-6, "{bottoms:?}");
    for other in ["B30", "G111 X5 Y5", "ROT Z30"] {
        assert!(expanded(&source.replace("HOLES2(10,20,5,90,0,4)", other)).is_err(), "{other}");
    }
    assert!(expanded("G17 G90 G71\nG0 X=1 Y0 Z9\nHOLES2(10,20,5,90,0,4)\nM30\n").is_err());
}

#[test]
fn heidenhain_drills_in_pecks_where_it_is_called() {
    let source = "0 BEGIN PGM A MM\n1 TOOL CALL 5 Z S2000 F300\n2 L X+0 Y+0 Z+50 R0 FMAX M3\n3 CYCL DEF 200 DRILLING ~\n  Q200=2 ;SET-UP CLEARANCE ~\n\
                  \x20 Q201=-7,5 ;DEPTH ~\n  Q206=150 ;FEED ~\n  Q202=5 ;PLUNGING ~\n  Q210=0 ;DWELL AT TOP ~\n  Q203=+1 ;SURFACE ~\n  Q204=20 ;2ND ~\n\
                  \x20 Q211=0.2 ;DWELL AT DEPTH\n4 CYCL CALL M8\n5 L X+10 FMAX M99\n6 L Y+5 F AUTO\n7 M30\n8 END PGM A MM\n";
    let hole = |first: u32| {
        [
            "L Z+3 R0 FMAX",
            "L Z-4 R0 F150",
            "L Z+3 R0 FMAX",
            "L Z-2 R0 FMAX",
            "L Z-6.5 R0 F150",
            "CYCL DEF 9.0 DWELL TIME",
            "CYCL DEF 9.1 DWELL 0.2",
            "L Z+21 R0 FMAX",
            "L F AUTO",
        ]
        .iter()
        .zip(first..)
        .map(|(text, number)| format!("{number} {text}"))
        .collect::<Vec<_>>()
    };
    let expected: Vec<String> = [
        vec![
            "0 BEGIN PGM A MM".to_owned(),
            "1 ; written out by kinetostat: 27 lines for 17".into(),
            "2 TOOL CALL 5 Z S2000 F300".into(),
            "3 L X+0 Y+0 Z+50 R0 FMAX M3".into(),
            "4 ; CYCL DEF 200, written out where it is called".into(),
            "5 M8".into(),
        ],
        hole(6),
        vec!["15 L X+10 FMAX".into()],
        hole(16),
        vec!["25 L Y+5 F AUTO".into(), "26 M30".into(), "27 END PGM A MM".into()],
    ]
    .concat();
    assert_eq!(lines(source)[2..], expected[2..]);
    let bottoms: Vec<_> = corners(source).into_iter().filter(|place| place[2] < -6.0).collect();
    assert_eq!(bottoms, [[0.0, 0.0, -6.5], [10.0, 0.0, -6.5]]);
}

#[test]
fn reaming_comes_back_with_its_feed() {
    let source = "BEGIN PGM A MM\nTOOL CALL 5 Z S2000\nL X+0 Y+0 Z+50 R0 F500\nCYCL DEF 201 REAMING\nQ200=2 ;A\nQ201=-8\nQ206=60\nQ211=0\nQ208=250\nQ203=+0\n\
                  Q204=0\nL X+4 FMAX M99\nEND PGM A MM\n";
    let found = lines(source);
    let moves: Vec<&str> = found.iter().map(|line| line.trim()).collect();
    assert_eq!(
        moves[5..],
        ["L X+4 FMAX", "L Z+2 R0 FMAX", "L Z-8 R0 F60", "L Z+2 R0 F250", "L F500", "END PGM A MM"],
        "{moves:?}"
    );
}

#[test]
fn cycles_that_are_not_known_for_certain_are_refused() {
    let sinumerik = |cycle: &str| format!("G17 G90 G71\nG0 X=1 Y0 Z9\n{cycle}\nX5\nM30\n");
    for cycle in [
        "CYCLE83(30,5,2,-10)",
        "CYCLE81(30,5,2,-10,,0,10,1,12)",
        "CYCLE81(R1,5,2,-10)",
        "CYCLE82(30,5,2,-10,,-3)",
        "CYCLE81(30,5,2)",
        "CYCLE81(3,5,2,-10)",
        "MCALL HOLES1(0,0,0,5,5,3)",
        "MCALL CYCLE81(30,5,2,-10)\nG74 X1=0",
        "G18\nCYCLE81(30,5,2,-10)",
    ] {
        let error = expanded(&sinumerik(cycle)).unwrap_err();
        assert_eq!(error.dialect, Dialect::Sinumerik);
        let reason = if cycle.contains("R1") { "a variable without a value" } else { "cycles are not followed" };
        assert!(error.to_string().contains(reason), "{cycle}: {error}");
    }
    let heidenhain = |q: &str, call: &str| {
        format!("BEGIN PGM A MM\nTOOL CALL 5 Z\nL X+0 Y+0 Z+50 FMAX\nCYCL DEF 200 X ~\n{q}\n{call}\nEND PGM A MM\n")
    };
    let all = "Q200=2 ~\nQ201=-8 ~\nQ206=60 ~\nQ202=9 ~\nQ203=+0";
    assert!(expanded(&heidenhain(all, "CYCL CALL")).is_ok());
    for (q, call) in [
        (all.replace("-8", "8"), "CYCL CALL"),
        (all.replace("Q202=9", "Q202=0"), "CYCL CALL"),
        (all.replace("Q206=60", "Q206=+Q1"), "CYCL CALL"),
        (all.replace("Q206=60 ~\n", ""), "CYCL CALL"),
        (format!("{all} ~\nQ395=1"), "CYCL CALL"),
        (all.to_owned(), "CYCL CALL PAT FMAX"),
        (all.to_owned(), "L X+5 FMAX M89"),
    ] {
        let error = expanded(&heidenhain(&q, call)).unwrap_err();
        let reason = if q.contains("+Q1") { "a variable without a value" } else { "cycles are not followed" };
        assert!(error.to_string().contains(reason), "{q} {call}: {error}");
    }
}
