//! Drilling cycles of Sinumerik and Heidenhain, written out as the moves they make.

use kinetostat_programs::{
    Sampling, WriteOptions,
    gcode::{BlockDelete, Dialect, GcodeError, GcodeOptions, GcodeProgram, LengthUnit},
};
use nalgebra::Vector3;

fn expanded(source: &str) -> Result<GcodeProgram, GcodeError> {
    GcodeProgram::parse_expanded(source, "part", &GcodeOptions::default(), &|_| None)
}

/// The lines of `source` written out; without correction they stay as they are.
fn lines(source: &str) -> Vec<String> {
    let program = expanded(source).unwrap_or_else(|error| panic!("{error}"));
    let path = program.toolpath(Sampling::new(0.05, 1e4).unwrap()).unwrap();
    let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
    assert_eq!(same.bytes(), program.source());
    String::from_utf8(program.source().to_vec()).unwrap().lines().map(String::from).collect()
}

/// Places where the tool turns, mm.
fn corners(source: &str) -> Vec<[f64; 3]> {
    corners_of(&expanded(source).unwrap())
}

fn corners_of(program: &GcodeProgram) -> Vec<[f64; 3]> {
    let path = program.toolpath(Sampling::new(0.05, 1e4).unwrap()).unwrap();
    path.points().iter().filter(|p| p.source.parameter == 1.0).map(|p| p.position_mm.into()).collect()
}

/// Checks that a program written with another correction everywhere turns where the program does, displaced by it.
fn check_corrected(source: &str) {
    let program = expanded(source).unwrap_or_else(|error| panic!("{error}"));
    let path = program.toolpath(Sampling::new(0.05, 1e4).unwrap()).unwrap();
    let by = nalgebra::Vector3::new(0.25, -0.5, 0.125);
    let goals: Vec<_> = path.positions_mm().into_iter().map(|place| place + by).collect();
    let written = program.rewrite(&path, &goals, WriteOptions::default()).unwrap();
    let read = GcodeProgram::parse(written.bytes().to_vec(), "part", &GcodeOptions::default()).unwrap();
    let (before, after) = (corners_of(&program), corners_of(&read));
    assert_eq!(before.len(), after.len());
    for (before, after) in before.iter().zip(&after) {
        let gap = nalgebra::Vector3::from(*after) - nalgebra::Vector3::from(*before) - by;
        assert!(gap.norm() < 2e-4, "{before:?} {after:?}");
    }
}

/// What `cycle` is written out as on Sinumerik, at feed 100 over X10 Y20, behind the blocks before it.
fn sinumerik_moves(cycle: &str) -> Vec<String> {
    let found = lines(&format!("G17 G90 G54 G71\nG0 X10 Y20 Z200\nF100\n{cycle}\nM30\n"));
    found[4..found.len() - 1].to_vec()
}

/// The blocks of one hole of Heidenhain's cycle with these lines, at feed 300.
fn heidenhain_blocks(cycle: &str) -> Vec<String> {
    let source = format!(
        "BEGIN PGM A MM\nTOOL CALL 5 Z S2000\nL X+0 Y+0 Z+50 R0 F300\nCYCL DEF {}\nCYCL CALL\nM30\nEND PGM A MM\n",
        cycle.replace(' ', " ~\n ")
    );
    check_corrected(&source);
    let found = lines(&source);
    found[5..found.len() - 2].iter().map(|line| line.trim().to_owned()).collect()
}

#[test]
fn sinumerik_taps_by_its_cycle_which_is_moved() {
    let source = "G17 G90 G54 G71\nTRANS X5 Z1\nG1 X10 Y20 Z50 F100\nMCALL CYCLE84(3,0,3,-30.875,,,3,,1.25,0,500,500)\nX20\nX30 Y25\n\
                  MCALL\nN9 CYCLE840( 10 , 0,2,, 12,,4,3,1,,1) ; one\nN10 CYCLE84(3,3,,-9)\nG91 X10\nG90 Y5\nM30\n";
    check_corrected(source);
    assert_eq!(
        lines(source)[4..],
        [
            "X20",
            "CYCLE84(3,3,,-30.875,,,3,,1.25,0,500,500)",
            "X30 Y25",
            "CYCLE84(3,3,,-30.875,,,3,,1.25,0,500,500)",
            "; one",
            "CYCLE840(10,2,,-12,,,4,3,1,,1)",
            "N10 CYCLE84(3,3,,-9)",
            "G91 X10",
            "G90 Y5",
            "M30",
        ]
    );
    // As it is for one hole, it stays.
    let as_written = "G17 G90 G54 G71\nG0 X10 Y20 Z50\nF100\nCYCLE84(3,3,,-9,,,3,,1.25,0,500)\nM30";
    assert_eq!(lines(as_written)[1..].join("\n"), as_written);
    let path = expanded(as_written).unwrap().toolpath(Sampling::new(0.05, 1e4).unwrap()).unwrap();
    let feeds: Vec<_> = path.points().iter().map(|point| point.feed_mm_per_min).collect();
    assert!(feeds.contains(&Some(625.0)), "{feeds:?}");
    // Of CYCLE840 the tenth value is another one.
    let other = as_written.replace("CYCLE84(3,3,,-9,,,3,,1.25,0,500)", "CYCLE840(3,3,,-9,,,4,3,20,,1.25)");
    let path = expanded(&other).unwrap().toolpath(Sampling::new(0.05, 1e4).unwrap()).unwrap();
    let feeds: Vec<_> = path.points().iter().map(|point| point.feed_mm_per_min).collect();
    assert!(feeds.contains(&None) && !feeds.contains(&Some(25.0)), "{feeds:?}");
    // A tap is corrected where the height before it is not known, too.
    check_corrected(
        "G17 G90 G71 G54\nG0 X10 Y10 F100\nCYCLE84(10,0,2,-20)\nG0 SUPA Z0\nX5 Y5\nCYCLE84(10,0,2,-20)\nM30\n",
    );
    // The move over the corrected place leaves G0 in force; what goes to coordinates of the machine behind it was a feed.
    let feeds_away =
        "G17 G90 G54 G71\nG0 X10 Y20 Z50\nG1 Z20 F100\nCYCLE84(23,0,3,-9,,,3,,1.25,0,500)\nG4 F1\nSUPA Z100\nM30";
    let program = expanded(feeds_away).unwrap();
    let path = program.toolpath(Sampling::new(0.05, 1e4).unwrap()).unwrap();
    for (shift, written) in [(0.0, "\nSUPA Z100\n"), (0.1, "\nSUPA G1 Z100\n")] {
        let off = |at: Vector3<f64>| if at.z < 10.0 { at + Vector3::new(shift, 0.0, 0.0) } else { at };
        let wanted: Vec<_> = path.positions_mm().into_iter().map(off).collect();
        let rewritten = program.rewrite(&path, &wanted, WriteOptions::default()).unwrap();
        let text = String::from_utf8(rewritten.bytes().to_vec()).unwrap();
        assert!(text.contains(written), "{text}");
    }
    let alone = GcodeProgram::parse("G17 G71\nG0 X1 Y1\nCYCLE84(10,0,2,-20)\nM30\n", "part", &GcodeOptions::default());
    assert!(alone.unwrap_err().fault.may_vanish_on_expansion());
    for (cycle, expected) in [
        ("X20 CYCLE84(10,2,,-20)", "expected a block of its own"),
        ("CYCLE84(10,2,,-20) X20", "expected numbers in brackets"),
        ("IF 1==1 CYCLE84(10,2,,-20)\nENDIF", "expected the end of the block"),
        ("/MCALL CYCLE84(10,2,,-20)", "expected MCALL without /"),
        ("CYCLE84(1,0,2,-5)", "RTP not below RFP + SDIS"),
        ("CYCLE84(9,0,2,-5,,,3,,1,0,100,100,2)", "_AXN of 0 or 3"),
        ("CYCLE84(9,0,2,-5,,,3,,1,0,100,100,3,0,0,0,0,0,\"M5\")", "numbers in brackets"),
        ("G18\nCYCLE84(9,0,2,-5)", "G17"),
    ] {
        let error = expanded(&format!("G17 G90 G54 G71\nG0 X1 Y2 Z3 F9\n{cycle}\nM30\n")).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
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
    for pattern in ["HOLES2(10,20,5,90,0,0)", "HOLES2(10,20,5,90)"] {
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

/// Strokes by hand: 15, then each 5 shorter but not below 5 (DAM), so -10, -20, -25, -30, -35 below RFP 5. The feed begins again 0.6 mm above the
/// last depth, a fiftieth of the depth from 30 mm on, 7 mm at most.
#[test]
fn deep_holes_are_drilled_in_strokes() {
    assert_eq!(
        sinumerik_moves("CYCLE83(30,5,2,-35,,,15,5,0.2,0.3,0.5,1)"),
        [
            "G0 Z=AC(7)",
            "G1 Z=AC(-10) F=50",
            "G4 F0.2",
            "G0 Z=AC(7) F=100",
            "G4 F0.3",
            "G0 Z=AC(-9.4)",
            "G1 Z=AC(-20)",
            "G4 F0.2",
            "G0 Z=AC(7)",
            "G4 F0.3",
            "G0 Z=AC(-19.4)",
            "G1 Z=AC(-25)",
            "G4 F0.2",
            "G0 Z=AC(7)",
            "G4 F0.3",
            "G0 Z=AC(-24.4)",
            "G1 Z=AC(-30)",
            "G4 F0.2",
            "G0 Z=AC(7)",
            "G4 F0.3",
            "G0 Z=AC(-29.3)",
            "G1 Z=AC(-35)",
            "G4 F0.2",
            "G0 Z=AC(30)",
        ]
    );
    // 145 mm in 50, 30, 20, 20 and the rest in two halves; up by 1 mm to break chips.
    assert_eq!(
        sinumerik_moves("CYCLE83(155,150,1,5,,100,,20,0,0,1,0)"),
        [
            "G0 Z=AC(151)",
            "G1 Z=AC(100)",
            "G1 Z=AC(101)",
            "G1 Z=AC(70)",
            "G1 Z=AC(71)",
            "G1 Z=AC(50)",
            "G1 Z=AC(51)",
            "G1 Z=AC(30)",
            "G1 Z=AC(31)",
            "G1 Z=AC(17.5)",
            "G1 Z=AC(18.5)",
            "G1 Z=AC(5)",
            "G0 Z=AC(155)",
        ]
    );
    let bottoms = |cycle: &str| -> Vec<String> {
        let moves = sinumerik_moves(cycle);
        moves.iter().filter_map(|line| line.strip_prefix("G1 Z=AC(")).map(|z| z.replace(')', "")).collect()
    };
    // Without DAM: 3, 3, and 4 in halves; 2 and 2 of 4; one stroke where the first is the whole.
    assert_eq!(bottoms("CYCLE83(30,0,2,-10,,-3,,0,0,0,1,1)"), ["-3", "-6", "-8", "-10"]);
    assert_eq!(bottoms("CYCLE83(30,0,2,-4,,,2,0,0,0,1,1)"), ["-2", "-4"]);
    assert_eq!(bottoms("CYCLE83(30,0,2,,4,,9,0,0,0,1,0)"), ["-4"]);
    // _AXN, _MDEP, _VRT, _DTD, _DIS1, and the modes of later versions.
    assert_eq!(
        sinumerik_moves("CYCLE83(30,0,2,-4,,,2,0,0.1,0,1,0,3,1,0.25,0.5,0,0,1,0)")[1..],
        ["G1 Z=AC(-2)", "G4 F0.1", "G1 Z=AC(-1.75)", "G1 Z=AC(-4)", "G4 F0.5", "G0 Z=AC(30)"]
    );
    assert_eq!(
        sinumerik_moves("CYCLE83(30,0,2,-4,,,2,0,0,0,1,1,,,,,1.5)")[1..],
        ["G1 Z=AC(-2)", "G0 Z=AC(2)", "G0 Z=AC(-0.5)", "G1 Z=AC(-4)", "G0 Z=AC(30)"]
    );
    let inches = lines("G17 G90 G70\nG0 X1 Y2 Z3\nCYCLE83(1,0,0.1,-1,,,0.5,0,0,0,1,0)\nM30\n");
    assert_eq!(inches[5..7], ["G1 Z=AC(-0.4606299)", "G1 Z=AC(-1)"]);
    let of_process = GcodeOptions { unit: Some(LengthUnit::Inch), ..GcodeOptions::default() };
    let program = GcodeProgram::parse_expanded(
        "G17 G90\nG0 X1 Y2 Z=3\nCYCLE83(1,0,0.1,-1,,,0.5,0,0,0,1,0)\nM30\n",
        "part",
        &of_process,
        &|_| None,
    );
    assert!(String::from_utf8_lossy(program.unwrap().source()).contains("\nG1 Z=AC(-0.4606299)\n"));
    check_corrected(
        "G17 G90 G54 G71\nG0 X10 Y20 Z50\nF100\nMCALL CYCLE83(30,5,2,-35,,,15,5,0.2,0.3,0.5,1)\nX20\nHOLES1(20,20,30,0,10,3)\nMCALL\nM30\n",
    );
}

#[test]
fn depths_are_those_that_count() {
    // Of two the one below RFP counts, but 0 is as left out; values of later versions may say the same.
    for (cycle, bottom) in [
        ("CYCLE81(30,5,2,-10,0)", "-10"),
        ("CYCLE81(30,5,2,-10,12)", "-7"),
        ("CYCLE82(30,5,2,-10,,0,0,1,12)", "-10"),
        ("CYCLE82(30,5,2,,12,0,0,1,11)", "-7"),
        ("CYCLE81(30,5,2,-10,,0,0,0,0)", "-10"),
    ] {
        assert_eq!(sinumerik_moves(cycle)[1], format!("G1 Z=AC({bottom})"), "{cycle}");
    }
}

#[test]
fn boring_comes_back_with_its_feed() {
    assert_eq!(
        sinumerik_moves("CYCLE85(30,5,2,-10,,0.5,80,300)"),
        ["G0 Z=AC(7)", "G1 Z=AC(-10) F=80", "G4 F0.5", "G1 Z=AC(7) F=300", "G0 Z=AC(30) F=100"]
    );
    assert_eq!(sinumerik_moves("CYCLE89(30,5,2,-10)"), ["G0 Z=AC(7)", "G1 Z=AC(-10)", "G1 Z=AC(7)", "G0 Z=AC(30)"]);
}

#[test]
fn sinumerik_drills_in_a_row() {
    let holes = |before: &str, row: &str| {
        let source = format!("G17 G90 G54 G71\n{before}\nF100\nMCALL CYCLE81(30,5,2,-10)\n{row}\nMCALL\nM30\n");
        expanded(&source).map(|program| {
            let bottoms = corners_of(&program).into_iter().filter(|place| place[2] < 0.0);
            bottoms.map(|[x, y, _]| [x, y].map(|number| (number * 1e6).round() / 1e6)).collect::<Vec<_>>()
        })
    };
    // The first is FDIS from the point, the others DBH from each other, along STA1.
    let row = [[30.0, 30.0], [50.0, 30.0], [70.0, 30.0]];
    assert_eq!(holes("G0 X20 Y30 Z50", "HOLES1(20,30,0,10,20,3)").unwrap(), row);
    assert_eq!(holes("G0 X20 Y30 Z50", "HOLES1(20,30,,10,20,3,0,,,,1)").unwrap(), row);
    assert_eq!(holes("G0 X0 Y0 Z50\nX=IC(9)", "HOLES1(10,20,90,0,5,2)").unwrap(), [[10.0, 20.0], [10.0, 25.0]]);
    let sin = 10.0 * 30f64.to_radians().sin();
    let found = holes("G0 X0 Y0 Z50", "HOLES1(0,0,30,0,10,2)").unwrap();
    assert!((found[1][1] - sin).abs() < 1e-6, "{found:?}");
    // Where the control may begin at the last.
    for before in ["G0 X90 Y30 Z50", "G0 Z50", "G0 X20 Y30 Z50\nG55"] {
        let error = holes(before, "HOLES1(20,30,0,10,20,3)").unwrap_err().to_string();
        assert!(error.contains("nearer to its first hole than to its last"), "{error}");
    }
}

/// Pecks by hand: 8, 6, 4, and the rest, as Q212 takes 2 from each; after one break of the chip (Q213) the tool leaves the hole.
#[test]
fn universal_drilling_breaks_chips_and_clears_them() {
    let cycle = "203 Q200=2 Q201=-20 Q206=150 Q202=8 Q210=0.1 Q203=+1 Q204=20 Q212=2 Q213=1 Q205=3 Q211=0.2 Q208=500 Q256=0.5 Q395=0";
    let found = heidenhain_blocks(cycle);
    assert_eq!(
        found,
        [
            "L Z+3 R0 FMAX",
            "L Z-7 R0 F150",
            "L Z-6.5 R0 F500",
            "L Z-13 R0 F150",
            "L Z+3 R0 F500",
            "CYCL DEF 9.0 DWELL TIME",
            "CYCL DEF 9.1 DWELL 0.1",
            "L Z-11 R0 FMAX",
            "L Z-17 R0 F150",
            "L Z-16.5 R0 F500",
            "L Z-19 R0 F150",
            "CYCL DEF 9.0 DWELL TIME",
            "CYCL DEF 9.1 DWELL 0.2",
            "L Z+3 R0 F500",
            "L Z+21 R0 FMAX",
            "L F300",
        ]
    );
    // Q208=MAX is rapid, 0 the feed of Q206; pecks of 5 without decrement.
    let plain = |q208: &str| {
        heidenhain_blocks(&format!("203 Q200=2 Q201=-9 Q206=150 Q202=5 Q203=0 Q204=0 Q212=0 Q213=0 Q208={q208}"))
    };
    let rapid = [
        "L Z+2 R0 FMAX",
        "L Z-5 R0 F150",
        "L Z+2 R0 FMAX",
        "L Z-3 R0 FMAX",
        "L Z-9 R0 F150",
        "L Z+2 R0 FMAX",
        "L F300",
    ];
    assert_eq!(plain("MAX"), rapid);
    assert_eq!((&*plain("0")[2], &*plain("0")[5]), ("L Z+2 R0 F150", "L Z+2 R0 F150"));
}

/// By hand: out of the hole every 8 mm (Q202), the chip broken every 3 mm of it (Q257), and back down to 0.5 mm above (Q258, Q259).
#[test]
fn universal_pecking_breaks_chips_within_pecks() {
    let cycle = "205 Q200=2 Q201=-20 Q206=100 Q202=8 Q203=+0 Q204=50 Q212=0 Q205=3 Q258=0.5 Q259=0.5 Q257=3 Q256=0.2 Q211=0 Q379=0 Q253=750 Q208=900";
    assert_eq!(
        heidenhain_blocks(cycle),
        [
            "L Z+2 R0 FMAX",
            "L Z-3 R0 F100",
            "L Z-2.8 R0 F900",
            "L Z-6 R0 F100",
            "L Z-5.8 R0 F900",
            "L Z-8 R0 F100",
            "L Z+2 R0 FMAX",
            "L Z-7.5 R0 FMAX",
            "L Z-11 R0 F100",
            "L Z-10.8 R0 F900",
            "L Z-14 R0 F100",
            "L Z-13.8 R0 F900",
            "L Z-16 R0 F100",
            "L Z+2 R0 FMAX",
            "L Z-15.5 R0 FMAX",
            "L Z-19 R0 F100",
            "L Z-18.8 R0 F900",
            "L Z-20 R0 F100",
            "L Z+2 R0 F900",
            "L Z+50 R0 FMAX",
            "L F300",
        ]
    );
}

#[test]
fn centering_goes_to_its_depth() {
    let cycle = "240 Q200=2 Q343=0 Q201=-1.5 Q344=-8 Q206=100 Q211=0.1 Q203=+0 Q204=20";
    assert_eq!(
        heidenhain_blocks(cycle),
        [
            "L Z+2 R0 FMAX",
            "L Z-1.5 R0 F100",
            "CYCL DEF 9.0 DWELL TIME",
            "CYCL DEF 9.1 DWELL 0.1",
            "L Z+20 R0 FMAX",
            "L F300"
        ]
    );
}

#[test]
fn the_line_that_cannot_be_drilled_is_named() {
    let sinumerik = |cycle: &str| {
        let source =
            format!("G17 G90 G71\nG0 X1 Y0 Z90\nMCALL CYCLE81(30,5,2,-10)\nX5\nMCALL\nN60 {cycle} ; this\nX=6\nM30\n");
        expanded(&source).expect_err(cycle).to_string()
    };
    for (cycle, why) in [
        ("CYCLE81(30,5,2,8)", "expected a depth below RFP"),
        ("CYCLE81(30,5,2,,0)", "expected a depth below RFP"),
        ("CYCLE81(30,5,2)", "expected a depth below RFP"),
        ("CYCLE81(,5,2,-10)", "expected RTP"),
        ("CYCLE81(6,5,2,-10)", "expected RTP not below RFP + SDIS"),
        ("CYCLE82(30,5,2,-10,,-3)", "expected dwell in seconds"),
        ("CYCLE82(30,5,2,-10,,0,10,1,12)", "expected values of the older form"),
        ("CYCLE82(30,5,2,-10,,0,0,1,11)", "expected an _AMODE of the depth"),
        ("CYCLE82(30,5,2,-10,,3,0,1,22)", "expected an _AMODE of the depth"),
        ("CYCLE83(30,5,2,-10)", "expected a first depth below RFP: FDEP absolute, or FDPR"),
        ("CYCLE83(30,5,2,-10,,9)", "expected a first depth below RFP"),
        ("CYCLE83(30,5,2,-10,,,3,-0.8)", "expected DAM as a length"),
        ("CYCLE83(30,5,2,-10,,,3,0,0,0,90,1)", "expected FRF from 0.001 to 1"),
        ("CYCLE83(30,5,2,-10,,,3,0,0,0,0.5,1)", "expected a feed before it"),
        ("CYCLE83(30,5,2,-10,,,3,0,0,0,1,2)", "expected VARI of 0 or 1"),
        ("CYCLE83(30,5,2,-10,,,3,0,0,0,1,1,1)", "_AXN of 0 or 3"),
        ("CYCLE83(30,5,2,-10,,,3,0,0,0,1,1,0,0,0,0,0,0,1,11211111)", "expected values of the older form"),
        ("CYCLE83(30,5,2,-10,,,0.0001,0,0,0,1,1)", "expected no more than 10000 pecks"),
        ("CYCLE85(30,5,2,-10,,,80)", "expected FFR and RFF"),
        ("CYCLE81(30,5,2,\"A\")", "expected numbers in brackets"),
        ("HOLES1(0,0,0,5,10,3)", "expected MCALL with a drilling cycle before it"),
        ("HOLES2(0,0,0,5,10,3)", "expected a radius"),
        ("HOLES2(0,0,10,5,90,5)", "expected a radius, and holes that are not more than once around"),
        ("HOLES2(0,0,10,5,0,2.5)", "expected 1 to 10000 holes"),
        ("HOLES2(0,0,10,5,0)", "expected a point and a number of holes"),
        ("G18\nCYCLE81(30,5,2,-10)", "expected G17"),
    ] {
        let error = sinumerik(cycle);
        let line = 6 + cycle.matches('\n').count();
        assert!(error.starts_with(&format!("part:{line}:")) && error.contains(why), "{cycle}: {error}");
        assert!(!error.contains("this`"), "{error}");
    }
    let moved = "G17 G90 G71\nG0 X1 Y0 Z90\nMCALL CYCLE81(30,5,2,-10)\nX=5\nG74 X1=0\nMCALL\nM30\n";
    let error = expanded(moved).unwrap_err().to_string();
    assert!(error.starts_with("part:5:1: `G74 X1=0`") && error.contains("expected MCALL alone before it"), "{error}");
    let heidenhain = |cycle: &str| {
        let source = format!(
            "0 BEGIN PGM A MM\n1 TOOL CALL 5 Z\n2 L X+0 Y+0 Z+50 FMAX\n3 CYCL DEF 200 A ~\nQ200=2 ~\nQ201=-8 ~\nQ206=60 ~\nQ202=9 ~\nQ203=+0\n4 CYCL CALL\n\
             5 CYCL DEF {cycle}\n6 L X+9 FMAX M99\n7 END PGM A MM\n"
        );
        expanded(&source).expect_err(cycle).to_string()
    };
    let universal = "203 Q200=2 Q201=-8 Q206=60 Q202=4 Q203=0 Q204=9 Q212=0 Q213=0 Q208=0";
    let pecking = "205 Q200=2 Q201=-8 Q206=60 Q202=4 Q203=0 Q204=9 Q258=0.5 Q259=0.5 Q379=0";
    for (cycle, why) in [
        (universal.replace("-8", "8"), "expected a depth Q201 below 0"),
        (universal.replace("Q213=0", "Q213=2"), "Q256 above 0 to break chips"),
        (universal.replace("Q212=0", "Q212=1"), "Q205 above 0"),
        (universal.replace("Q204=9", "Q395=1"), "expected a depth of the tool's tip"),
        (universal.replace("Q206=60", "Q206=FAUTO"), "expected numbers"),
        (universal.replace("Q206=60", "Q206=MAX"), "expected numbers"),
        (universal.replace("Q206=60 ", ""), "expected Q200, Q201"),
        (universal.replace("Q204=9", "Q999=9"), "expected only the parameters of this cycle"),
        (pecking.replace("Q379=0", "Q379=5"), "Q379"),
        (pecking.replace("Q259=0.5", "Q259=1"), "Q259 the same"),
        (pecking.replace("Q202=4", "Q202=0.0005"), "expected no more than 10000 pecks"),
        ("240 Q200=2 Q201=-8 Q206=60 Q203=0 Q343=1".into(), "Q343"),
        ("207 Q200=2 Q201=-8 Q239=1 Q203=0".into(), "expected tapping in a program of its own"),
        ("206 Q200=2 Q201=-8 Q206=1 Q203=0".into(), "expected tapping in a program of its own"),
        ("208 Q200=2 Q201=-8 Q206=1 Q203=0".into(), "cycles are not followed"),
    ] {
        let error = heidenhain(&cycle);
        assert!(error.starts_with("part:11:3: `CYCL DEF") && error.contains(why), "{cycle}: {error}");
    }
    let error = heidenhain("7.0\nCYCL CALL PAT FMAX");
    assert!(error.starts_with("part:12:") && error.contains("cycles are not followed"), "{error}");
    let across = "BEGIN PGM A MM\nTOOL CALL 5 Z\nL X+0 Y+0 Z+50 FMAX\nCYCL DEF 201 Q200=2 Q201=-8 Q206=60 Q203=0\nTOOL CALL 6 Y\nCYCL CALL\nEND PGM A MM\n";
    let error = expanded(across).unwrap_err().to_string();
    assert!(error.starts_with("part:6:1: `CYCL CALL`") && error.contains("expected a tool along Z"), "{error}");
}

#[test]
fn lines_that_are_skipped_drill_nothing() {
    let source = "G17 G90 G54 G71\nG0 X10 Y20 Z50\nF100\nMCALL CYCLE81(30,5,2,-10)\nX=15\n/MCALL CYCLE81(30,5,2,-20)\nX20\nMCALL\n/CYCLE81(30,5,2,-30)\nM30\n";
    let options = GcodeOptions { block_delete: BlockDelete::Skip, ..GcodeOptions::default() };
    let program = GcodeProgram::parse_expanded(source, "part", &options, &|_| None).unwrap();
    let bottoms: Vec<_> = corners_of(&program).into_iter().filter(|place| place[2] < 0.0).collect();
    assert_eq!(bottoms, [[15.0, 20.0, -10.0], [20.0, 20.0, -10.0]]);
    // Where they are not skipped, what is written out would be drilled by a control that skips them.
    assert!(expanded(source).unwrap_err().to_string().contains("part:6:2: `MCALL CYCLE81(30,5,2,-20)`"));
    let direct = source.replace("/MCALL", "MCALL");
    assert_eq!(corners(&direct).into_iter().filter(|place| place[2] == -20.0 || place[2] == -30.0).count(), 2);
}

#[test]
fn cycles_that_are_not_known_for_certain_are_refused() {
    for (cycle, why) in [
        ("CYCLE81(R1,5,2,-10)", "a variable without a value"),
        ("MCALL HOLES1(0,0,0,5,5,3)", "cycles are not followed"),
        ("CYCLE86(30,5,2,-10,,0,3,0,0,0,0)", "cycles are not followed"),
    ] {
        let error = expanded(&format!("G17 G90 G71\nG0 X=1 Y0 Z9\n{cycle}\nX5\nM30\n")).unwrap_err();
        assert_eq!(error.dialect, Dialect::Sinumerik);
        assert!(error.to_string().contains(why), "{cycle}: {error}");
    }
    let heidenhain = |q: &str, call: &str| {
        format!("BEGIN PGM A MM\nTOOL CALL 5 Z\nL X+0 Y+0 Z+50 FMAX\nCYCL DEF 200 X ~\n{q}\n{call}\nEND PGM A MM\n")
    };
    let all = "Q200=2 ~\nQ201=-8 ~\nQ206=60 ~\nQ202=9 ~\nQ203=+0";
    assert!(expanded(&heidenhain(all, "CYCL CALL")).is_ok());
    for (q, call, why) in [
        (all.replace("Q202=9", "Q202=0"), "CYCL CALL", "expected Q202 above 0"),
        (all.replace("Q206=60", "Q206=+Q1"), "CYCL CALL", "a variable without a value"),
        (all.to_owned(), "CYCL CALL PAT FMAX", "cycles are not followed"),
        (all.to_owned(), "L X+5 FMAX M89", "cycles are not followed"),
    ] {
        let error = expanded(&heidenhain(&q, call)).unwrap_err();
        assert!(error.to_string().contains(why), "{q} {call}: {error}");
    }
}

/// Heidenhain's control takes Q parameters that have changed since CYCL DEF; what acts at the end of a block acts behind the hole; headings are for people.
#[test]
fn what_changes_between_cycl_def_and_its_call_is_refused() {
    let program = |between: &str| {
        format!(
            "BEGIN PGM A MM\nTOOL CALL 5 Z S2000 F500\nL X+0 Y+0 Z+50 R0 F300\nCYCL DEF 201 REAM ~\n Q200=2 ~\n Q201=-8 ~\n Q206=60 ~\n Q203=+0\n\
             {between}\nM30\nEND PGM A MM\n"
        )
    };
    for (between, why) in [
        ("FN 0: Q201 = -15\nL X+20 FMAX M99", "expected CYCL DEF once more where its Q parameters have changed"),
        ("L X+1 FMAX\nQ203 = +5\nCYCL CALL", "expected CYCL DEF once more where its Q parameters have changed"),
        (
            "CYCL DEF 201 ~\nQ200=2 ~\nQ201=-8 ~\nQ206=60 ~\nQ203=+0 ~\nQ208=MAX\nL X+1 FMAX\nQ208 = 100\nCYCL CALL",
            "expected CYCL DEF once more where its Q parameters have changed",
        ),
        ("CYCL CALL M5", "in a block of their own"),
        ("L X+30 FMAX M9 M99", "in a block of their own"),
    ] {
        let error = expanded(&program(between)).expect_err(between).to_string();
        assert!(error.contains(why), "{between}: {error}");
    }
    // Others change nothing, and a cycle that is defined again has the new ones.
    let again = "L X+1 FMAX\nQ1 = 7\nQ203 = +5\nCYCL DEF 201 REAM Q200=2 Q201=-8 Q206=60 Q203=+Q203\nCYCL CALL M3";
    assert!(lines(&program(again)).iter().any(|line| line == "L Z-3 R0 F60"), "{:?}", lines(&program(again)));
    let headed = lines(&program("* - M99 DRILL ALL F100\nL X+20 FMAX M99"));
    assert!(headed.contains(&"* - M99 DRILL ALL F100".to_owned()), "{headed:?}");
    assert_eq!(headed.iter().filter(|line| line.starts_with("L Z-8 ")).count(), 1, "{headed:?}");
    for (before, back) in [
        ("L X+1 F AUTO", "L F AUTO"),
        ("L X+1 F 250", "L F250"),
        ("L X+1 FMAX", "L F300"),
        ("* - ROUGHING F100", "L F300"),
        ("L X+1 M128 F1500", "L F300"),
    ] {
        let found = lines(&program(&format!("{before}\nCYCL CALL")));
        assert_eq!(found[found.len() - 3].trim(), back, "{before}: {found:?}");
    }
}

/// What is in force before a cycle must be known, to be so behind it.
#[test]
fn sinumerik_drills_where_it_is_known_how_it_goes_on() {
    for (source, line) in [
        (
            "G17 G90 G71\nG0 X10 Y20 Z50 F500\nCIP X40 Y20 I1=25 J1=35\nCYCLE81(30,5,2,-10)\nX50 Y20 I1=45 J1=25\nM30\n",
            4,
        ),
        ("G17 G90 G71\nF100\nX10 Y=10 Z30\nCYCLE81(30,5,2,-10)\nX20\nM30\n", 4),
    ] {
        let error = expanded(source).unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("part:{line}:")) && error.contains("which is in force again behind it"),
            "{error}"
        );
    }
}
