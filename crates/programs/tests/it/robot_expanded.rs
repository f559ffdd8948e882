//! RAPID modules with several procedures, branches, loops and computed targets: where they lead, and how they are written back.

use kinetostat_programs::{
    NumberFormat, Orientation, Sampling, WriteOptions,
    gcode::Calls,
    robot::{Language, RobotOptions, RobotProgram},
};
use nalgebra::{UnitQuaternion, Vector3};

const REST: &str = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]";

/// A module with the targets p (1, 2, 3) and q (5, 2, 3), the tool's axis down, and these routines.
fn module(routines: &str) -> String {
    format!(
        "MODULE m\n  CONST robtarget p:=[[1,2,3],[0,0,1,0],{REST}];\n  CONST robtarget q:=[[5,2,3],[0,0,1,0],{REST}];\n  \
         CONST num depth:=0.5;\n{routines}ENDMODULE\n"
    )
}

fn expanded(source: &str) -> Result<RobotProgram, String> {
    RobotProgram::parse_expanded(source, "p.mod", Language::Rapid, [], &RobotOptions::default(), true)
        .map_err(|refused| refused.to_string())
}

fn read(routines: &str) -> RobotProgram {
    expanded(&module(routines)).unwrap_or_else(|refused| panic!("{refused}\n{routines}"))
}

/// Ends of the motions of a program, mm.
pub(crate) fn ends(program: &RobotProgram) -> Vec<[f64; 3]> {
    let path = program.toolpath(Sampling::new(1e3, 1e3).unwrap().with_max_turn(9.0).unwrap()).unwrap();
    path.positions_mm().into_iter().map(|p| p.map(|c| (c * 1e6).round() / 1e6 + 0.0).into()).collect()
}

/// What becomes of a program whose point k is moved by `by(k)`.
pub(crate) fn moved(program: &RobotProgram, by: impl Fn(usize) -> f64) -> Calls {
    let path = program.toolpath(Sampling::new(1e3, 1e3).unwrap().with_max_turn(9.0).unwrap()).unwrap();
    let wanted: Vec<_> = path.positions_mm().into_iter().enumerate().map(|(k, p)| p + Vector3::z() * by(k)).collect();
    let written =
        program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(NumberFormat::new(3, 4).unwrap())).unwrap();
    for (back, wanted) in written.read_back().unwrap().positions_mm().iter().zip(&wanted) {
        assert!((back - wanted).norm() < 1.1e-3, "{}", String::from_utf8_lossy(written.bytes()));
    }
    program.folded_calls(&written).unwrap()
}

fn stays(calls: Calls) -> String {
    match calls {
        Calls::Stay { program, beside } => {
            assert!(beside.is_empty());
            String::from_utf8(program).unwrap()
        }
        Calls::WrittenOut(why) => panic!("{why}"),
    }
}

fn written_out(calls: Calls) -> String {
    match calls {
        Calls::WrittenOut(why) => why.to_string(),
        Calls::Stay { program, .. } => panic!("{}", String::from_utf8_lossy(&program)),
    }
}

const TWO: &str = "  PROC main()\n    Path_10; ! face\n    SetDO do1,1;\n    Path_20;\n  ENDPROC\n  PROC Path_10()\n    MoveJ \
                   p,v100,fine,tool0;\n    MoveL q,v100,z1,tool0; ! cut\n  ENDPROC\n  PROC Path_20()\n    MoveL \
                   p,v100,fine,tool0;\n  ENDPROC\n";

#[test]
fn procedures_that_are_called_once_stay_where_they_are() {
    let program = read(TWO);
    assert_eq!(ends(&program), [[1.0, 2.0, 3.0], [5.0, 2.0, 3.0], [1.0, 2.0, 3.0]]);
    assert_eq!((0..3).map(|motion| program.line_of(motion).unwrap()).collect::<Vec<_>>(), [11, 12, 15]);
    assert_eq!(stays(moved(&program, |_| 0.0)), module(TWO));
    let at = |z: f64, x: f64| format!("[[{x},2,{z:.3}],[0,0,1,0],{REST}]");
    let expected = module(TWO)
        .replace("MoveL q", &format!("MoveL {}", at(3.25, 5.0)))
        .replace("MoveL p", &format!("MoveL {}", at(3.5, 1.0)));
    assert_eq!(stays(moved(&program, |k| 0.25 * k as f64)), expected);
}

#[test]
fn a_procedure_that_runs_twice_stays_where_its_corrections_are_the_same() {
    let twice = "PROC main()\nPath;\nPath;\nENDPROC\nPROC Path()\nMoveL p,v100,fine,tool0;\nMoveL q,v100,fine,tool0;\nENDPROC\n";
    let program = read(twice);
    assert_eq!(ends(&program).len(), 4);
    assert!(stays(moved(&program, |_| 0.1)).contains("PROC main()\nPath;\nPath;\nENDPROC\n"));
    assert_eq!(
        written_out(moved(&program, |k| 0.1 * k as f64)),
        "line 10 runs several times, each with other corrections"
    );
    let text = String::from_utf8_lossy(program.source()).into_owned();
    assert!(text.contains("MODULE m\n! written out by kinetostat: 12 lines for 13\n"), "{text}");
    assert!(!text.contains("PROC Path") && text.matches("MoveL").count() == 4, "{text}");
}

#[test]
fn loops_branches_and_computed_targets_lead_where_they_should() {
    for (body, wanted) in [
        (
            "FOR i FROM 2 TO 1 DO\nMoveL Offs(p,i,0,-depth),v100,z1,tool0;\nENDFOR",
            vec![[3.0, 2.0, 2.5], [2.0, 2.0, 2.5]],
        ),
        (
            "FOR i FROM 4 TO 0 STEP -2 DO\nMoveL Offs(p,10*i,0,0),v9,z1,tool0;\nENDFOR",
            vec![[41.0, 2.0, 3.0], [21.0, 2.0, 3.0], [1.0, 2.0, 3.0]],
        ),
        // The tool's x is against x of the base here, and its z down.
        ("MoveL RelTool(p,1,0,10),v100,fine,tool0;", vec![[0.0, 2.0, -7.0]]),
        ("MoveL RelTool(p,1,0,0\\Rx:=5\\Rz:=90),v100\\V:=20,fine\\Z:=0.1,tool0\\WObj:=wobj0;", vec![[0.0, 2.0, 3.0]]),
        (
            "VAR num n:=7;\nVAR robtarget t;\nt:=p;\nt.trans.z:=n DIV 2;\nt.trans:=t.trans+[1,1,0];\nWHILE n MOD 2=1 \
             DO\nIncr n;\nMoveL t,v100,z1,tool0;\nENDWHILE\nTEST n\nCASE 1,8:\nMoveL Offs(t,0,n,0),v100,fine,tool0;\nDEFAULT:\nMoveL \
             p,v100,fine,tool0;\nENDTEST",
            vec![[2.0, 3.0, 3.0], [2.0, 11.0, 3.0]],
        ),
        (
            "VAR num n:=0;\nagain:\nMoveL Offs(p,0,Sin(90*n),0),v100,z1,tool0;\nn:=n+1;\nIF n<2 GOTO again;\nIF n=2 AND NOT (n>5) \
             THEN\nMoveL q,v100,z1,tool0;\nELSE\nMoveL p,v100,z1,tool0;\nENDIF",
            vec![[1.0, 2.0, 3.0], [1.0, 3.0, 3.0], [5.0, 2.0, 3.0]],
        ),
        (
            "slot q,2\\depth:=1;\nslot p,1;\nMoveL f(90),v100,fine,tool0;",
            vec![[5.0, 4.0, 2.0], [1.0, 3.0, 3.0], [1.0, 3.0, 3.0]],
        ),
    ] {
        let more = "PROC slot(robtarget start,num length,\\num depth)\nVAR num d:=0;\nIF Present(depth) d:=depth;\nWaitTime length;\nMoveL \
                    Offs(start,0,length,-d),v100,fine,tool0;\nENDPROC\nFUNC robtarget f(num a)\nRETURN Offs(p,0,Sin(a),0);\nENDFUNC\n";
        let more = if body.contains("slot") { more } else { "" };
        let program = read(&format!("PROC main()\n{body}\nENDPROC\n{more}"));
        assert_eq!(ends(&program), wanted, "{body}\n{}", String::from_utf8_lossy(program.source()));
    }
}

#[test]
fn rel_tool_turns_about_x_then_the_new_y_then_the_new_z() {
    let program = read("PROC main()\nMoveL RelTool(p,0,0,0\\Rx:=10\\Ry:=20\\Rz:=30),v100,fine,tool0;\nENDPROC\n");
    let path = program.toolpath(Sampling::default()).unwrap();
    let Some(Orientation::Platform(found)) = path.points()[0].orientation else { panic!("no orientation") };
    let about = |axis, degrees: f64| UnitQuaternion::from_axis_angle(&axis, degrees.to_radians());
    let flipped = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(0.0, 0.0, 1.0, 0.0));
    let wanted =
        flipped * about(Vector3::x_axis(), 10.0) * about(Vector3::y_axis(), 20.0) * about(Vector3::z_axis(), 30.0);
    assert!(found.angle_to(&wanted) < 1e-8);
}

/// Motions that would be lost, or of which it is not known whether they happen: in functions, behind a one-line IF, in what is not in the program.
#[test]
fn motions_out_of_sight_are_refused() {
    let refused = |routines: &str| {
        let text = module(routines);
        let plain = RobotProgram::parse(text.clone(), "p.mod", Language::Rapid, [], &RobotOptions::default());
        (plain.map(drop).unwrap_err().to_string(), expanded(&text).map(drop).unwrap_err())
    };
    let moves = "    MoveL p,v100,fine,tool0;\n";
    let go = format!("  FUNC num go()\n{moves}    RETURN 1;\n  ENDFUNC\n");
    for use_of in ["n:=go();", "IF go()=1 n:=2;", "TPWrite \"\"\\Num:=go();"] {
        let (plain, told) = refused(&format!("  VAR num n;\n{go}  PROC main()\n{moves}    {use_of}\n  ENDPROC\n"));
        for message in [plain, told] {
            assert!(message.contains("motions in functions are not followed"), "{use_of}: {message}");
        }
    }
    for (statement, expected) in [
        ("IF di1=1 PDispSet pd;", "displaced programs are not followed"),
        ("IF di1=1 AND NOT (n>2) EOffsSet off;", "displaced programs are not followed"),
        ("IF names{2}=\"a\" OtherProc 3;", "calls OTHERPROC"),
        ("n:=Elsewhere();", "calls ELSEWHERE"),
        ("IF Elsewhere(1) n:=2;", "calls ELSEWHERE"),
        ("WHILE Elsewhere() DO\n    ENDWHILE", "calls ELSEWHERE"),
        ("IF di1=1 MoveL q,v100,fine,tool0;", "in IF of line 7"),
    ] {
        let (plain, _) = refused(&format!("  PROC main()\n{moves}    {statement}\n  ENDPROC\n"));
        assert!(plain.contains(expected), "{statement}: {plain}");
    }
    // What stands where it is easily missed.
    for (routines, expected) in [
        (
            format!("  PROC main() Path_1;\n{moves}  ENDPROC\n  PROC Path_1()\n{moves}  ENDPROC\n"),
            "nothing behind it on its line",
        ),
        (
            format!("  PROC main()\n{moves}    TEST 1 CASE 1: MoveL q,v100,fine,tool0;\n    ENDTEST\n  ENDPROC\n"),
            "nothing behind it on its line",
        ),
        (
            format!("  PROC main()\n{moves}    IF n=0x1F MoveL q,v100,fine,tool0;\n  ENDPROC\n"),
            "expected IF condition statement",
        ),
    ] {
        let (plain, told) = refused(&routines);
        assert!(plain.contains(expected) && told.contains(expected), "{routines}: {plain} {told}");
    }
    let given = format!(
        "  VAR robtarget r:=[[1,2,3],[0,0,1,0],{REST}];\n  PROC main()\n    chg r;\n    MoveL r,v100,fine,tool0;\n  ENDPROC\n  \
         PROC chg(VAR robtarget t)\n    t.trans.x:=300;\n  ENDPROC\n"
    );
    assert!(refused(&given).0.contains("R is computed in line 7"), "{}", refused(&given).0);
    // Quotation marks in strings, and numbers that begin with a point.
    let quoted = format!(
        "  VAR string s;\n  PROC main()\n{moves}    IF s=\"a\"\"b\" SetDO do1,1;\n    IF .5<n WaitTime (1+1)*2;\n  ENDPROC\n"
    );
    assert_eq!(ends(&read(&quoted)), [[1.0, 2.0, 3.0]]);
    // What is asked of the controller moves nothing.
    let asks = "    IF di1=1 SetDO do1,1;\n    IF n>0 n:=Abs(n)+Distance(p.trans,q.trans);\n";
    assert_eq!(ends(&read(&format!("  VAR num n;\n  PROC main()\n{moves}{asks}  ENDPROC\n"))), [[1.0, 2.0, 3.0]]);
    let changed = "  PROC main()\n    IF di1=1 r.trans.x:=7;\n    MoveL r,v100,fine,tool0;\n  ENDPROC\n";
    let target = format!("  VAR robtarget r:=[[1,2,3],[0,0,1,0],{REST}];\n");
    let (plain, told) = refused(&(target + changed));
    assert!(plain.contains("R is computed in line 7"), "{plain}");
    assert!(told.contains("the value of R is not known"), "{told}");
}

/// Spare procedures, which main does not lead to, are told and stay.
#[test]
fn procedures_that_nothing_calls_stay_as_they_are() {
    let spare = "  PROC Path_30()\n    MoveL Offs(p,9,9,9),v100,fine,tool0;\n    Unknown;\n  ENDPROC\n";
    let text = module(&format!("{TWO}{spare}"));
    let program = expanded(&text).unwrap();
    assert_eq!(ends(&program), [[1.0, 2.0, 3.0], [5.0, 2.0, 3.0], [1.0, 2.0, 3.0]]);
    assert_eq!(program.notes().uncalled, ["PATH_30"]);
    assert_eq!(stays(moved(&program, |_| 0.0)), text);
    let written = stays(moved(&program, |k| 0.1 * k as f64));
    assert!(written.contains(spare), "{written}");
    let plain = module(&format!("  PROC main()\n    MoveL p,v100,fine,tool0;\n  ENDPROC\n{spare}"));
    let program = RobotProgram::parse(plain, "p.mod", Language::Rapid, [], &RobotOptions::default()).unwrap();
    assert_eq!((program.notes().uncalled.len(), ends(&program)), (1, vec![[1.0, 2.0, 3.0]]));
    // A datum of its own is not that of others, which another module may have by this name.
    let own = spare.replace(
        "    MoveL",
        "    CONST robtarget q:=[[7,7,7],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n    MoveL",
    );
    let elsewhere = module(&format!("  PROC main()\n    MoveL q,v100,fine,tool0;\n  ENDPROC\n{own}"));
    let refused = RobotProgram::parse(elsewhere, "p.mod", Language::Rapid, [], &RobotOptions::default()).unwrap_err();
    assert!(refused.to_string().contains("MoveL q,v100,fine,tool0"), "{refused}");
    // One that spare ones name stays with them, and an empty main leads to all.
    let names_it = format!("{}  PROC tst()\n    Path_10;\n  ENDPROC\n", TWO.replace("SetDO do1,1;", "Path_10;"));
    let program = expanded(&module(&names_it)).unwrap();
    let path = program.toolpath(Sampling::new(1e3, 1e3).unwrap().with_max_turn(9.0).unwrap()).unwrap();
    let wanted: Vec<_> =
        path.positions_mm().into_iter().enumerate().map(|(k, p)| p + Vector3::z() * 0.1 * k as f64).collect();
    let written =
        program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(NumberFormat::new(3, 4).unwrap())).unwrap();
    let out = String::from_utf8_lossy(written.bytes()).into_owned();
    assert!(out.contains("PROC Path_10()") && out.contains("PROC tst()"), "{out}");
    let empty = module("  PROC main()\n  ENDPROC\n  PROC Path_10()\n    MoveL p,v100,fine,tool0;\n  ENDPROC\n");
    let program = RobotProgram::parse(empty, "p.mod", Language::Rapid, [], &RobotOptions::default()).unwrap();
    assert_eq!(ends(&program), [[1.0, 2.0, 3.0]]);
    // Without a main, or with computed names, any may run.
    for other in [
        spare.replace("Path_30", "a") + &spare.replace("Path_30", "b"),
        format!("{TWO}{spare}").replace("Path_10; ! face", "%\"Path_\"%;"),
    ] {
        assert!(expanded(&module(&other)).is_err(), "{other}");
    }
}

#[test]
fn what_moves_nothing_stays_as_it_stands() {
    let body = "PROC main()\n  VAR num n:=0;\n  IF di1=1 THEN\n    SetDO do1,1; ! lamp\n  ENDIF\n  lamp;\n  FOR i FROM 1 TO 2 DO\n    TPWrite \
                \"pass i\"\\Num:=i;\n    MoveL p,v100,fine,tool0;\n  ENDFOR\nENDPROC\nPROC lamp()\n  WaitDI di1,1;\nENDPROC\n";
    let program = read(body);
    let text = String::from_utf8_lossy(program.source()).into_owned();
    assert!(text.contains("  IF di1=1 THEN\n    SetDO do1,1; ! lamp\n  ENDIF\n  lamp;\n"), "{text}");
    assert!(
        text.contains("TPWrite \"pass i\"\\Num:=2;") && text.contains("PROC lamp()\n  WaitDI di1,1;\nENDPROC"),
        "{text}"
    );
    assert_eq!(stays(moved(&program, |_| 0.0)), module(body));
}

#[test]
fn modules_that_cannot_be_followed_are_refused_by_line_and_statement() {
    let go = "MoveL p,v100,fine,tool0;";
    for (body, message) in [
        (
            format!("IF di1=1 THEN\n{go}\nENDIF"),
            "p.mod:6: `IF di1=1 THEN`: the value of DI1 is not known; expected numbers and truths that the program itself gives",
        ),
        (
            format!("WHILE TRUE DO\n{go}\nENDWHILE"),
            "p.mod:7: `MoveL p,v100,fine,tool0;`: the program has run 1000000 statements and has not ended; expected one that ends",
        ),
        (
            format!("IF reg1=0.1*3 OR 0.3=0.1*3 {go}"),
            "p.mod:6: `IF reg1=0.1*3 OR 0.3=0.1*3 MoveL p,v100,fine,tool0;`: the value of REG1 is not known; expected numbers and truths that \
             the program itself gives",
        ),
        (
            format!("IF 0.3=0.1*3 {go}"),
            "p.mod:6: `IF 0.3=0.1*3 MoveL p,v100,fine,tool0;`: expected numbers that are equal, or differ by more than rounding",
        ),
        (
            format!("IF NOT 1=2 {go}"),
            "p.mod:6: `IF NOT 1=2 MoveL p,v100,fine,tool0;`: expected brackets that say what comes first",
        ),
        (
            format!("FOR i FROM 0 TO 1 STEP 0.1 DO\n{go}\nENDFOR"),
            "p.mod:6: `FOR i FROM 0 TO 1 STEP 0.1 DO`: counters that are no whole numbers are not followed; expected FOR with whole numbers",
        ),
        (
            format!("FOR i FROM 0 TO 1 DO\n{go}"),
            "p.mod:6: `FOR i FROM 0 TO 1 DO`: expected the end of the branch or loop",
        ),
        (
            "MoveL RelTool(p,1,0,0\\Rw:=5),v100,fine,tool0;".into(),
            "p.mod:6: `MoveL RelTool(p,1,0,0\\Rw:=5),v100,fine,tool0;`: options of this function are not followed; expected the function \
             without them",
        ),
        (
            "MoveL CRobT(),v100,fine,tool0;".into(),
            "p.mod:6: `MoveL CRobT(),v100,fine,tool0;`: the value of CROBT is not known; expected numbers and truths that the program itself \
             gives",
        ),
        (
            "VAR num n:=1;\nstore n;\nMoveL Offs(p,n,0,0),v100,fine,tool0;\nENDPROC\nPROC store(INOUT num k)\nk:=5;"
                .into(),
            "p.mod:8: `MoveL Offs(p,n,0,0),v100,fine,tool0;`: the value of N is not known; expected numbers and truths that the program \
             itself gives",
        ),
        (
            "VAR num n:=1;\nstore n;\nENDPROC\nPROC store(INOUT num k)\nMoveL p,v100,fine,tool0;\nk:=5;".into(),
            "p.mod:11: `k:=5;`: parameters that a procedure changes for its caller, and counters that are assigned, are not followed; expected \
             data of the module",
        ),
        (
            format!("{go}\n%\"Path\"+\"1\"%;"),
            "p.mod:7: `%\"Path\"+\"1\"%;`: calls of procedures whose names are computed are not followed; expected the name itself",
        ),
        (
            format!("{go}\nPDispOn p,tool0;"),
            "p.mod:7: `PDispOn p,tool0;`: displaced programs are not followed; expected targets where they are",
        ),
        (
            format!("{go}\nother;\nENDPROC\nPROC other()\n{go}\nERROR\nRETRY;"),
            "p.mod:7: `other;`: procedures with motions that handle errors (ERROR, UNDO) are not followed; expected the handler in the \
             procedure that is called first",
        ),
    ] {
        assert_eq!(expanded(&module(&format!("PROC main()\n{body}\nENDPROC\n"))).unwrap_err(), message);
    }
    // Without a main, either may be what runs.
    assert_eq!(
        expanded(&module(&format!("PROC one()\n{go}\nENDPROC\nPROC other()\n{go}\nENDPROC\n"))).unwrap_err(),
        "p.mod:8: `PROC other()`: has motions and is not called; expected all motions in the routine of line 5, or in those that it calls"
    );
}

#[test]
fn any_module_is_followed_or_refused() {
    let source = module(TWO);
    for cut in 0..source.len() {
        let _ = expanded(&source[..cut]);
        let _ = expanded(&format!("{}{}", &source[..cut], &source[cut + 1..]));
    }
    let deep = format!("PROC main()\nIF {}1{}=1 MoveL p,v1,fine,tool0;\nENDPROC\n", "(".repeat(5000), ")".repeat(5000));
    assert!(
        expanded(&module(&deep))
            .unwrap_err()
            .contains("5000 levels of brackets, signs, branches and data in one another; expected at most 64")
    );
    let own =
        "PROC main()\nMoveL p,v1,fine,tool0;\nagain;\nENDPROC\nPROC again()\nMoveL p,v1,fine,tool0;\nagain;\nENDPROC\n";
    assert!(expanded(&module(own)).unwrap_err().contains("calls more than 16 deep are not followed"));
    let straight = RobotProgram::parse(module(TWO), "p.mod", Language::Rapid, None, &RobotOptions::default());
    assert!(straight.is_err_and(|refused| refused.fault.may_vanish_on_expansion()));
}
