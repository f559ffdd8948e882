//! Sinumerik's programs that compute, branch and call, written out as the motion they make.

use kinetostat_programs::{
    Sampling, Toolpath, WriteOptions,
    gcode::{Calls, Dialect, GcodeError, GcodeOptions, GcodeProgram},
};

/// Files beside the program.
fn beside(name: &str) -> Option<Vec<u8>> {
    let text = match name {
        "L100.SPF" => "%_N_L100_SPF\nG91 X2 ; step\nY1\nG90 M17\n",
        "HOLE.SPF" => {
            "PROC HOLE(REAL DEEP, INT TURNS=2, BOOL BACK) DISPLOF\nDEF REAL AT\nAT=AT-DEEP\nZ=AT F=TURNS\nAT=5\nIF BACK\nZ=AT\nENDIF\nRET\n"
        }
        "CALLER.SPF" => "L100 P2\nL100\nN10 Z1 M17 ; back\n",
        "OPEN.SPF" => "X1\n",
        "SAVED.SPF" => "PROC SAVED SAVE\nX1\nRET\n",
        "ENDED.SPF" => "X1\nM30\n",
        "ENDLESS.SPF" => "ENDLESS\nRET\n",
        "VARIED.SPF" => "PROC VARIED(VAR REAL A)\nRET\n",
        "READS.SPF" => "X=OUTER\nRET\n",
        _ => return None,
    };
    Some(text.into())
}

fn options() -> GcodeOptions {
    GcodeOptions { dialect: Some(Dialect::Sinumerik), ..GcodeOptions::default() }
}

fn expanded(source: &str) -> Result<GcodeProgram, GcodeError> {
    GcodeProgram::parse_expanded(source.as_bytes(), "part.mpf", &options(), &beside)
}

fn path(program: &GcodeProgram) -> Toolpath {
    program.toolpath(Sampling::new(0.1, 2.0).unwrap()).unwrap()
}

/// The lines that `source` is written out in, without its header; without correction they stay as they are.
fn lines(source: &str) -> Vec<String> {
    let program = expanded(source).unwrap_or_else(|error| panic!("{error}"));
    let points = path(&program);
    let same = program.rewrite(&points, &points.positions_mm(), WriteOptions::default()).unwrap();
    assert_eq!(same.bytes(), program.source());
    let text = String::from_utf8(program.source().to_vec()).unwrap();
    text.lines().filter(|line| !line.starts_with("; written out")).map(String::from).collect()
}

/// The lines behind a start at the origin in G17, G90 and G1.
fn moves(source: &str) -> Vec<String> {
    let lines = lines(&format!("G17 G90 G71 G54\nG1 X0 Y0 Z0 F100\n{source}\nM30\n"));
    lines[2..lines.len() - 1].to_vec()
}

fn refusal(source: &str) -> String {
    expanded(&format!("G1 X0 Y0 Z0 F100\n{source}\nM30\n")).expect_err(source).to_string()
}

#[test]
fn expressions_have_the_values_of_the_manual() {
    for (expression, value) in [
        ("2+3*4", "14.0"),
        ("(2+3)*4", "20.0"),
        ("-R1+7", "2.0"),
        ("R[R2]", "5.0"),
        ("R01*2", "10.0"),
        ("3/4", "0.75"),
        ("7 DIV 2", "3.0"),
        ("7 MOD 4", "3.0"),
        ("SIN(30)+COS(60)", "1.0"),
        ("TAN(45)", "1.0"),
        ("ASIN(0.5)", "30.0"),
        ("ACOS(0.5)", "60.0"),
        ("ATAN2(30,-30)", "135.0"),
        ("SQRT(POT(3)+POT(4))", "5.0"),
        ("ABS(-2.5)", "2.5"),
        ("ROUND(2.5)", "3.0"),
        ("TRUNC(-2.7)", "-2.0"),
        ("LN(EXP(2))", "2.0"),
        ("MINVAL(3,2)+MAXVAL(3,2)", "5.0"),
        ("BOUND(1,4,9)", "4.0"),
        ("15EX-1", "1.5"),
        ("1+(R1==5)", "2.0"),
        ("1+((R1>4) AND NOT (R1<>5))", "2.0"),
        ("1/3*3", "1.0"),
        ("1/3", "0.3333333"),
    ] {
        assert_eq!(moves(&format!("R1=5\nR2=1\nX={expression}")), [format!("X={value}")], "{expression}");
    }
}

#[test]
fn values_stand_where_expressions_were() {
    assert_eq!(
        moves("R1=5 R2=3 ; two\nN20 G3 X=R1 Y=IC(R2) CR=R1+1 F=R1*10 ; arc"),
        ["; two", "N20 G3 X=5.0 Y=IC(3.0) CR=6.0 F=50.0 ; arc"].map(String::from)[1..]
    );
    assert_eq!(
        moves("DEF REAL DEEP=2.5, WIDE\nG1X=DEEP Y=-WIDE S1=DEEP*100 M3 (X=Q) MSG(\"R1=5\")"),
        ["G1X=2.5 Y=0.0 S1=250.0 M3 (X=Q) MSG(\"R1=5\")"]
    );
    assert_eq!(moves("DEF INT N=2.6, A[3]\nDEF BOOL YES=TRUE\nA[N-1]=1.4\nX=A[2]+N+YES"), ["X=5.0"]);
    assert_eq!(moves("X1.5EX1"), ["X15.0"]);
}

#[test]
fn branches_and_loops_run() {
    assert_eq!(
        moves("FOR R1=1 TO 3\nX=R1\nENDFOR\nWHILE R2A<0\nENDWHILE\n".replace("WHILE R2A<0\nENDWHILE\n", "").trim()),
        ["X=1.0", "X=2.0", "X=3.0"]
    );
    assert_eq!(moves("FOR R1=2 TO 1\nX=R1\nENDFOR\nX9"), ["X9"]);
    assert_eq!(moves("R1=0\nWHILE R1<2\nR1=R1+1\nIF R1==2\nY=R1\nELSE\nX=R1\nENDIF\nENDWHILE"), ["X=1.0", "Y=2.0"]);
    assert_eq!(moves("R1=0\nREPEAT\nR1=R1+1\nX=R1\nUNTIL R1>=2"), ["X=1.0", "X=2.0"]);
    assert_eq!(moves("R1=0\nLOOP\nR1=R1+1\nIF R1>2 GOTOF OUT\nX=R1\nENDLOOP\nOUT: Y1"), ["X=1.0", "X=2.0", "OUT: Y1"]);
    let jumps = "R1=1\nGOTO N40\nBACK: X9\nGOTOF N50\nN40 IF R1==2 GOTOF NONE IF R1==1 GOTOB BACK\nNONE: X7\nN50 Y1";
    assert_eq!(moves(jumps), ["BACK: X9", "N50 Y1"]);
    assert_eq!(moves("GOTOC NOWHERE\nX1"), ["X1"]);
    let nested = "IF 1==2\nFOR R1=1 TO 2\nIF 1==1\nX1\nENDIF\nENDFOR\nELSE\nX2\nENDIF";
    assert_eq!(moves(nested), ["X2"]);
}

#[test]
fn sections_are_repeated() {
    assert_eq!(
        moves("AA: X=IC(1)\nY=IC(1)\nREPEAT AA P=2\nZ1"),
        ["AA: X=IC(1)", "Y=IC(1)", "AA: X=IC(1)", "Y=IC(1)", "AA: X=IC(1)", "Y=IC(1)", "Z1"]
    );
    assert_eq!(
        moves("AA: X=IC(1)\nBB: Y=IC(1)\nZ1\nREPEAT AA BB\nZ2"),
        ["AA: X=IC(1)", "BB: Y=IC(1)", "Z1", "AA: X=IC(1)", "BB: Y=IC(1)", "Z2"]
    );
    assert_eq!(
        moves("AA: X=IC(1)\nY1\nENDLABEL:\nZ1\nREPEAT AA\nZ2"),
        ["AA: X=IC(1)", "Y1", "ENDLABEL:", "Z1", "AA: X=IC(1)", "Y1", "ENDLABEL:", "Z2"]
    );
    assert_eq!(moves("AA: X=IC(1)\nZ1\nREPEATB AA P=2\nZ2"), ["AA: X=IC(1)", "Z1", "AA: X=IC(1)", "AA: X=IC(1)", "Z2"]);
    // One within another.
    assert_eq!(moves("AA: X=IC(1)\nBB: Y=IC(1)\nREPEAT BB\nREPEAT AA\nZ2").len(), 7);
}

#[test]
fn subprograms_are_run() {
    let step = ["G91 X2 ; step", "Y1", "G90 "];
    assert_eq!(moves("L100"), step);
    assert_eq!(moves("N10 L100 P2 ; twice"), [step, step].concat());
    assert_eq!(moves("R1=2\nL100 P=R1"), [step, step].concat());
    assert_eq!(moves("CALL \"L100\""), step);
    assert_eq!(moves("CALLER"), [&[step, step, step].concat()[..], &["N10 Z1  ; back"]].concat());
    assert_eq!(moves("HOLE(2.5)"), ["Z=-2.5 F=2.0"]);
    assert_eq!(
        moves("DEF REAL D=1\nHOLE(D,,TRUE) P2\nX=D"),
        ["Z=-1.0 F=2.0", "Z=5.0", "Z=-1.0 F=2.0", "Z=5.0", "X=1.0"]
    );
    assert_eq!(moves("HOLE(1,3.6)"), ["Z=-1.0 F=4.0"]);
    let in_one_file =
        "%_N_A_MPF\nG1 X0 Y0 Z0 F100\nL5\nPART P2\nM30\n%_N_L5_SPF\nX1\nM17\n%_N_PART_SPF\nY=IC(1)\nRET\n";
    assert_eq!(lines(in_one_file), ["%_N_A_MPF", "G1 X0 Y0 Z0 F100", "X1", "Y=IC(1)", "Y=IC(1)", "M30"]);
    for (source, why) in [
        ("L7", "subprogram L7 is neither in the file nor beside it; expected the file L7.SPF"),
        (
            "FACE_MILL(1,2)",
            "subprogram FACE_MILL is neither in the file nor beside it; expected the file FACE_MILL.SPF",
        ),
        ("L100(1)", "expected as many arguments as PROC has"),
        ("L100 P1.5", "expected P as a whole number"),
        ("OPEN", "the subprogram ends here without M99, endsub, M17, RET or LBL 0"),
        ("SAVED", "expected PROC without SAVE and the like"),
        ("ENDED", "expected M17 or RET at the end of a subprogram"),
        ("ENDLESS", "calls are more than 50 deep"),
        ("VARIED(R1)", "a variable without a value"),
        ("R1=1\nVARIED(R1)", "expected REAL, INT or BOOL"),
        ("DEF REAL OUTER=1\nREADS", "a variable without a value"),
        ("MCALL L100", "cycles are not followed"),
        ("EXTCALL(\"L100\")", "subprogram EXTCALL is neither"),
        ("PCALL L100", "calls a subprogram"),
    ] {
        let found = refusal(source);
        assert!(found.contains(why), "{source}: {found}");
    }
}

#[test]
fn calls_stay_where_they_can() {
    let program =
        GcodeProgram::parse_with_calls("G1 X0 Y0 Z0 F9\nL100\nX50\nL100\nM30\n", "part.mpf", &options(), &beside)
            .unwrap();
    let points = path(&program);
    let goals: Vec<_> = points.positions_mm().into_iter().map(|p| p + nalgebra::Vector3::new(0.0, 0.0, 0.5)).collect();
    let rewritten = program.rewrite(&points, &goals, WriteOptions::default()).unwrap();
    match program.folded_calls(&rewritten).unwrap() {
        Calls::Stay { program, beside } => {
            assert!(String::from_utf8_lossy(&program).contains("\nL100\nX50"));
            assert_eq!(beside.len(), 1);
        }
        Calls::WrittenOut(why) => assert_eq!(why.to_string(), "x"),
    }
}

#[test]
fn what_is_computed_is_run_again_or_written_out() {
    let moved = |source: &str, by: f64| {
        let program = GcodeProgram::parse_with_calls(source, "part.mpf", &options(), &beside).unwrap();
        let points = path(&program);
        let goals: Vec<_> =
            points.positions_mm().into_iter().map(|p| p + nalgebra::Vector3::new(by * p.x, 0.0, 0.0)).collect();
        let rewritten = program.rewrite(&points, &goals, WriteOptions::default()).unwrap();
        program.folded_calls(&rewritten).unwrap()
    };
    let source = "G1 X0 Y0 Z0 F100\nFOR R1=1 TO 2\nY=IC(5)\nENDFOR\nX10\nM30\n";
    match moved(source, 0.01) {
        Calls::Stay { program, .. } => {
            assert_eq!(String::from_utf8(program).unwrap(), source.replace("X10", "X10.1000"))
        }
        Calls::WrittenOut(why) => panic!("{why}"),
    }
    let Calls::WrittenOut(why) = moved(
        &source
            .replace("X10", "X=R1+10")
            .replace("R1=1 TO", "R2=1 TO")
            .replace("FOR", "R1=1\nFOR")
            .replace("ENDR1=1\nFOR", "ENDFOR"),
        0.01,
    ) else {
        panic!()
    };
    assert_eq!(why.to_string(), "line 6 is computed, and cannot be both that and corrected");
}

#[test]
fn what_is_not_known_is_refused() {
    for (source, why) in [
        ("X=R1", "a variable without a value"),
        ("X=DEPTH", "a variable without a value"),
        ("DEPTH=5", "parameters, variables and expressions are not followed"),
        ("X=$AA_IM[X]", "not an expression that can be evaluated"),
        ("$P_UIFR[1]=5", "parameters, variables and expressions are not followed"),
        ("R1=5 R2=R1", "expected a block of its own for a value that the same block assigns"),
        ("R1=1/0", "its value is no number"),
        ("IF 1==2 AND 2==1 GOTOF AA\nAA: X1", "expected AND, OR and XOR of comparisons"),
        ("IF 1==1 AND 0==0 GOTOF AA\nAA: X1", "expected brackets that say what comes first"),
        ("R1=0.1+0.2\nWHILE R1<0.3\nENDWHILE", "expected numbers that are equal, or differ by more than rounding"),
        ("G1 EXX0", "calls a subprogram, or is a word that is not read"),
        ("GOTOF NOWHERE", "its other end is not in the program"),
        ("IF 1==2\nX1", "its other end is not in the program"),
        ("AA: X1\nGOTOB AA", "has run 1000000 lines"),
        ("FOR R1=1 TO R2\nENDFOR", "a variable without a value"),
        ("R2=3\nFOR R1=1 TO R2\nR2=4\nENDFOR", "expected a last value that the loop does not change"),
        ("FOR R1=1 TO 2\nENDFOR\nX=R1", "a variable without a value"),
        ("DEF STRING[5] NAME", "expected REAL, INT or BOOL"),
        ("X=1 MOD -2", "expected MOD of no negative number"),
        ("REPEAT AA", "its other end is not in the program"),
        ("CASE(R1) OF 1 GOTOF A", "jumps, loops, branches and repeats are not followed"),
    ] {
        let found = refusal(source);
        assert!(found.contains(why) && found.ends_with("(read as Sinumerik)"), "{source}: {found}");
    }
    assert_eq!(
        refusal("N10 G1 X=R7+1"),
        "part.mpf:2:8: `X=R7+1`: a variable without a value; expected one that the program has assigned before (read as Sinumerik)"
    );
}
