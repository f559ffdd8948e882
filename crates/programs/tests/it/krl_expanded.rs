//! KRL programs with several routines, branches, loops and computed points: where they lead, and how they are written back.

use crate::robot_expanded::{ends, moved};
use kinetostat_programs::{
    Orientation, Sampling,
    gcode::Calls,
    robot::{Language, RobotOptions, RobotProgram, rotation_of_abc},
};
use nalgebra::{UnitQuaternion, Vector3};

/// Refusal of functions.
const FUNCTIONS: &str = "functions that may do more than compute are not followed; expected their names in calls_kept of [robot_program], if they do not";

/// A `.dat` with points P at (1, 2, 3) and Q at (5, 2, 3), an array of points, and numbers.
const DATA: &str = "DEFDAT p\nDECL E6POS P={X 1,Y 2,Z 3,A 0,B 0,C 180,S 2,T 35,E1 0,E2 0,E3 0,E4 0,E5 0,E6 0}\nDECL E6POS \
                    Q={X 5,Y 2,Z 3,A 0,B 0,C 180}\nDECL POS R[2]\nR[1]={X 7,Y 0,Z 0,A 0,B 0,C 180}\nR[2]={X 8,Y 0,Z 0,A 0,B 0,C \
                    180}\nINT N=4\nDECL GLOBAL REAL SHARED=1.5\nDECL POS MOVED={X 1,Y 1,Z 1,A 0,B 0,C 180}\nENDDAT\n";

fn expanded(source: &str) -> Result<RobotProgram, String> {
    let data = [("p.dat".to_owned(), DATA.as_bytes().to_vec())];
    let options = RobotOptions::default();
    RobotProgram::parse_expanded(source, "p.src", Language::Krl, data, &options, true)
        .map_err(|refused| refused.to_string())
}

/// Reads a program whose first routine is `body`, with `more` routines behind it.
fn read(body: &str, more: &str) -> RobotProgram {
    let source = format!("DEF p( )\n{body}\nEND\n{more}");
    expanded(&source).unwrap_or_else(|refused| panic!("{refused}\n{source}"))
}

fn text(program: &RobotProgram) -> String {
    String::from_utf8_lossy(program.source()).into_owned()
}

/// A start at (0, 0, 0).
const GO: &str = "PTP {X 0,Y 0,Z 0,A 0,B 0,C 180}\n";

#[test]
fn loops_branches_and_computed_points_lead_where_they_should() {
    for (body, more, wanted) in [
        (
            "INT i\nPOS w\nw=P\nFOR i=0 TO 4 STEP 2\nw.Y=10+i*2\nLIN w C_DIS\nENDFOR",
            "",
            vec![[1.0, 10.0, 3.0], [1.0, 14.0, 3.0], [1.0, 18.0, 3.0]],
        ),
        (
            "INT i\nFOR i=2 TO 1\nLIN Q\nENDFOR\nfor I=2 to 1 step -1\nlin r[i]\nendfor",
            "",
            vec![[8.0, 0.0, 0.0], [7.0, 0.0, 0.0]],
        ),
        // Quotients of INT are whole, towards 0; those of REAL are not.
        ("INT a\nREAL b\nPOS w\na=-7\nb=7\nw=P\nw.X=a/2\nw.Y=b/2\nw.Z=a/2.0\nLIN w", "", vec![[-3.0, 3.5, -3.5]]),
        ("INT a\nBOOL b\nPOS w\na='B110'\nb=a==6\nIF b THEN\nw=Q\nLIN w\nENDIF", "", vec![[5.0, 2.0, 3.0]]),
        ("INT a\nPOS w\na=15.6\nw=P\nw.X=a+1/2\nLIN w", "", vec![[16.0, 2.0, 3.0]]),
        (
            "INT c\nc=0\nWHILE (c<3) AND NOT (c==2)\nc=c+1\nLIN_REL {X 1}\nENDWHILE\nREPEAT\nLIN_REL {Y 1}\nc=c+1\nUNTIL c>=4\nLOOP\nc=c-1\nIF \
             c<3 THEN\nEXIT\nENDIF\nLIN_REL {Z 1}\nENDLOOP",
            "",
            vec![[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [2.0, 2.0, 0.0], [2.0, 2.0, 1.0]],
        ),
        (
            "INT s\nBOOL deep\ns=3\ndeep=FALSE\nSWITCH s\n; which\nCASE 1\nLIN P\nCASE 2,3\nLIN Q\nDEFAULT\nLIN R[1]\nENDSWITCH\nIF deep \
             EXOR (s==2) THEN\nLIN P\nELSE\nLIN R[2]\nENDIF\nSWITCH s\nCASE 1\nLIN P\nENDSWITCH",
            "",
            vec![[5.0, 2.0, 3.0], [8.0, 0.0, 0.0]],
        ),
        (
            "INT n1\nn1=0\nagain:\nLIN_REL {X 1}\nn1=n1+1\nIF n1<2 THEN\nGOTO again\nENDIF",
            "",
            vec![[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        ),
        ("POS w\nw=P\nw.X=3.5+SIN(30)+SQRT(16)-ABS(-1)+ATAN2(1,1)/45+N\nLIN w", "", vec![[12.0, 2.0, 3.0]]),
        // C 180 turns y and z about.
        ("LIN P:{X 1,Y 2,Z 3,A 0,B 0,C 0}", "", vec![[2.0, 0.0, 0.0]]),
    ] {
        // Declarations come first.
        let is_declared = |line: &&str| ["INT ", "REAL ", "BOOL ", "POS "].iter().any(|kind| line.starts_with(kind));
        let (declared, rest): (Vec<_>, Vec<_>) = body.lines().partition(is_declared);
        let program = read(&format!("{}\n{GO}{}", declared.join("\n"), rest.join("\n")), more);
        assert_eq!(ends(&program)[1..], wanted, "{body}\n{}", text(&program));
    }
    let base = "BAS(#BASE,0)\nPTP {X 0,Y 0,Z 0,A 0,B 0,C 180}\n$BASE=$NULLFRAME:{X 100,Y 0,Z 0,A 90,B 0,C 0}\nLIN {X 0,Y 0,Z 0}\nLIN {X 1}";
    assert_eq!(ends(&read(base, "")), [[0.0; 3], [100.0, 0.0, 0.0], [100.0, 1.0, 0.0]]);
}

#[test]
fn routines_take_and_change_their_arguments() {
    let more = "DEF slot(length:IN,at:OUT)\nREAL length\nPOS at\nPOS own\nown=at\nown.Y=own.Y+length/2\nLIN own\nat.X=at.X+own.Y\nWAIT SEC \
                length*0.5\n$OUT[3]=TRUE ; lamp\nENDIF_\nEND\n";
    let more = more.replace("ENDIF_\n", "");
    let program = read(&format!("POS w\n{GO}w=P\nslot(3,w)\n; again\nslot ( 1 , w )\nLIN w"), &more);
    assert_eq!(ends(&program)[1..], [[1.0, 3.5, 3.0], [4.5, 2.5, 3.0], [7.0, 2.0, 3.0]], "{}", text(&program));
    let text = text(&program);
    assert!(
        text.contains(
            "LIN {X 1,Y 3.5,Z 3,A 0,B 0,C 180,S 2,T 35}\nW.X=W.X+3.5\nWAIT SEC 3.0*0.5\n$OUT[3]=TRUE ; lamp\n; again\n"
        ),
        "{text}"
    );
    assert!(!text.contains("slot") && text.starts_with("DEF p( )\n; written out by kinetostat: "), "{text}");
}

#[test]
fn what_moves_nothing_stays_as_it_stands() {
    let body = format!(
        "INT i\nINI\n$VEL.CP=0.05\nIF $IN[1]==TRUE THEN\n  $OUT[1]=TRUE ; lamp\nENDIF\nLOOP\nIF $IN[2] THEN\nEXIT\nENDIF\nENDLOOP\n{GO}FOR i=1 \
         TO 2\n  ;FOLD cut\n  $OUT[i]=FALSE\n  LIN_REL {{X 5}} ; step\n  ;ENDFOLD\nENDFOR\nWAIT SEC 0.5"
    );
    let program = read(&body, "");
    let text = text(&program);
    assert!(text.contains("IF $IN[1]==TRUE THEN\n  $OUT[1]=TRUE ; lamp\nENDIF\nLOOP\nIF $IN[2]"), "{text}");
    let step = |i: i32| format!("  ;FOLD cut\n  $OUT[{i}]=FALSE\n  LIN_REL {{X 5}} ; step\n  ;ENDFOLD\n");
    assert!(text.contains(&format!("{}{}WAIT SEC 0.5\nEND\n", step(1), step(2))), "{text}");
    // Without a correction the program is as it was posted.
    let Calls::Stay { program: same, .. } = moved(&program, |_| 0.0) else { panic!("written out") };
    assert_eq!(String::from_utf8(same).unwrap(), format!("DEF p( )\n{body}\nEND\n"));
}

#[test]
fn routines_stay_where_their_corrections_are_the_same() {
    let more = "DEF Path( )\nLIN P\nLIN Q C_DIS ; cut\nEND\n";
    let program = read(&format!("{GO}Path( )\nPath( )"), more);
    assert_eq!(ends(&program).len(), 5);
    assert_eq!((0..5).map(|motion| program.line_of(motion).unwrap()).collect::<Vec<_>>(), [2, 7, 8, 7, 8]);
    let Calls::Stay { program: kept, .. } = moved(&program, |k| if k == 0 { 0.0 } else { 0.1 }) else { panic!() };
    let kept = String::from_utf8(kept).unwrap();
    assert!(
        kept.contains("Path( )\nPath( )\nEND\nDEF Path( )\nLIN {X 1,Y 2,Z 3.100,") && kept.contains(" C_DIS ; cut\n"),
        "{kept}"
    );
    let Calls::WrittenOut(why) = moved(&program, |k| 0.1 * k as f64) else { panic!() };
    assert_eq!(why.to_string(), "line 7 runs several times, each with other corrections");
}

#[test]
fn the_geometric_operator_turns_about_z_then_the_new_y_then_the_new_x() {
    let program = read(&format!("{GO}LIN {{X 0,Y 0,Z 0,A 90,B 0,C 0}}:{{X 1,Y 0,Z 0,A 10,B 20,C 30}}"), "");
    let path = program.toolpath(Sampling::new(1e3, 1e3).unwrap().with_max_turn(9.0).unwrap()).unwrap();
    let Some(Orientation::Platform(found)) = path.points()[1].orientation else { panic!("no orientation") };
    let about = |axis, degrees: f64| UnitQuaternion::from_axis_angle(&axis, degrees.to_radians());
    let wanted = about(Vector3::z_axis(), 100.0) * about(Vector3::y_axis(), 20.0) * about(Vector3::x_axis(), 30.0);
    assert!(found.angle_to(&wanted) < 1e-8 && found.angle_to(&rotation_of_abc([100.0, 20.0, 30.0])) < 1e-8);
    assert_eq!(ends(&program)[1], [0.0, 1.0, 0.0]);
}

#[test]
fn programs_are_read_as_controllers_write_them() {
    let source = "&ACCESS RVP\r\n&REL 3\r\n&PARAM EDITMASK = *\r\nDEF p( ) ; Täsch\u{fc}tz\r\nDECL INT I, Count\r\nini\r\n\r\nPtp {X 0,Y 0,Z 0,A 0,B \
                  0,C 180}\r\n  For i = 1 To 2 ; zweimal für alle\r\n    count = I\r\n\tLin_Rel {X 1} C_DIS\r\n  EndFor\r\nEnd\r\n";
    let program = expanded(source).unwrap();
    assert_eq!(ends(&program)[1..], [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let written = text(&program);
    assert!(written.starts_with(
        "&ACCESS RVP\r\n&REL 3\r\n&PARAM EDITMASK = *\r\nDEF p( ) ; Täsch\u{fc}tz\r\n; written out by kinetostat"
    ));
    assert!(
        written.contains("    count = 1\r\n\tLin_Rel {X 1} C_DIS\r\n    count = 2\r\n") && written.ends_with("End\r\n"),
        "{written}"
    );
    assert_eq!(written.matches('\n').count(), written.matches("\r\n").count());
}

#[test]
fn programs_that_cannot_be_followed_are_refused_by_line_and_statement() {
    let unknown = |name: &str| {
        format!("the value of {name} is not known; expected numbers and truths that the program itself gives")
    };
    for (body, message) in [
        ("IF $IN[1] THEN\nLIN P\nENDIF", format!("`IF $IN[1] THEN`: {}", unknown("$IN"))),
        ("WHILE $FLAG[2]==FALSE\nLIN P\nENDWHILE", format!("`WHILE $FLAG[2]==FALSE`: {}", unknown("$FLAG"))),
        ("IF SHARED>1 THEN\nLIN P\nENDIF", format!("`IF SHARED>1 THEN`: {}", unknown("SHARED"))),
        // What is not declared here may be changed by others, and a `.dat` keeps what the last run has left.
        ("jog=FALSE\nIF jog THEN\nLIN P\nENDIF", format!("`IF jog THEN`: {}", unknown("JOG"))),
        ("SHARED=2\nIF SHARED>1 THEN\nLIN P\nENDIF", format!("`IF SHARED>1 THEN`: {}", unknown("SHARED"))),
        ("BAS(#BASE,$IN_W)\nFOR I=1 TO 2\nLIN P\nENDFOR", "`BAS(#BASE,$IN_W)`: expected the number of the tool or base".to_owned()),
        ("N=N+1\nIF N>2 THEN\nLIN P\nENDIF", format!("`IF N>2 THEN`: {}", unknown("N"))),
        ("LIN MOVED\nMOVED.X=5", "`LIN MOVED`: expected a point all of whose numbers are known".to_owned()),
        ("LOOP\nLIN P\nENDLOOP", "`LIN P`: the program has run 1000000 statements and has not ended; expected one that ends".to_owned()),
        ("FOR I=1 TO 3 STEP 0\nLIN P\nENDFOR", "`FOR I=1 TO 3 STEP 0`: expected FOR i=a TO b, or STEP c behind it, where c is not 0".to_owned()),
        (
            "FOR I=1 TO 3\nLIN P\nI=I+1\nENDFOR",
            "`I=I+1`: parameters that a procedure changes for its caller, and counters that are assigned, are not followed; expected data of the \
             module"
                .to_owned(),
        ),
        ("FOR I=1 TO 2\nLIN P\nENDFOR\nIF I==2 THEN\nLIN P\nENDIF", format!("`IF I==2 THEN`: {}", unknown("I"))),
        ("FOR I=1 TO 3\nLIN P", "`FOR I=1 TO 3`: expected the end of the branch or loop".to_owned()),
        ("LIN P\nENDIF", "`ENDIF`: expected the beginning of the branch or loop".to_owned()),
        ("IF 1<2 AND 2<3 THEN\nLIN P\nENDIF", "`IF 1<2 AND 2<3 THEN`: expected a condition that is TRUE or FALSE".to_owned()),
        ("K=1/0\nIF K==0 THEN\nLIN P\nENDIF", format!("`IF K==0 THEN`: {}", unknown("K"))),
        ("IF 1.0/3==0.33333333 THEN\nLIN P\nENDIF", "`IF 1.0/3==0.33333333 THEN`: expected numbers that are equal, or differ by more than \
                                                    rounding".to_owned()),
        (
            "other(1)\nFOR I=1 TO 2\nLIN P\nENDFOR",
            "`other(1)`: calls OTHER, which may move the tool; expected the program in one routine, or OTHER in robot_program.calls_kept if it does \
             not"
                .to_owned(),
        ),
        ("again( )", "`again( )`: calls more than 16 deep are not followed; expected routines that do not call themselves".to_owned()),
        ("two(1)", "`two(1)`: expected an argument for each parameter".to_owned()),
        ("LIN P : Q : {X 1}", "`LIN P : Q : {X 1}`: expected a frame or point with X, Y, Z, A, B and C".to_owned()),
        ("K=half(1)+side(2)\nLIN P", format!("`K=half(1)+side(2)`: {FUNCTIONS}")),
        ("WAIT FOR half(1)>0\nLIN P", format!("`WAIT FOR half(1)>0`: {FUNCTIONS}")),
        ("$OUT[1]=$IN[1] AND ready()\nLIN P", format!("`$OUT[1]=$IN[1] AND ready()`: {FUNCTIONS}")),
        ("two(half(1),2)\nLIN P", format!("`two(half(1),2)`: {FUNCTIONS}")),
        ("STRUC st INT a,b\nLIN P", "`STRUC st INT a,b`: records of the program (STRUC) are not followed; expected numbers, positions and frames".to_owned()),
        (
            "hides( )",
            "`N2=1`: data whose names are those of other data in the first routine are not followed; expected names that mean one datum".to_owned(),
        ),
        ("EXIT\nLIN P", "`DEF p( )`: expected EXIT in a loop alone".to_owned()),
        ("GOTO nowhere\nLIN P", "`DEF p( )`: jumps into branches and loops are not followed; expected a label outside".to_owned()),
    ] {
        let more = "DEF again( )\nLIN P\nagain( )\nEND\nDEF two(a:IN,b:IN)\nLIN Q\nEND\nDEF hides( )\nN2=1\nLIN Q\nEND\nDEFFCT REAL \
                    half(v:IN)\nREAL v\nRETURN v/2\nENDFCT\nDEFFCT REAL side(v:IN)\nREAL v\n$OUT[1]=TRUE\nRETURN v\nENDFCT\n";
        let calls = ["again", "two", "hides"].map(|name| if body.contains(name) { "" } else { name });
        // What no routine calls must not move.
        let more = calls.iter().filter(|name| !name.is_empty()).fold(more.to_owned(), |more, name| {
            let start = more.find(&format!("DEF {name}")).unwrap();
            let end = start + more[start..].find("END\n").unwrap() + 4;
            format!("{}{}", &more[..start], &more[end..])
        });
        let source = format!("DEF p( )\nINT I,K,N2\nPTP {{X 0,Y 0,Z 0,A 0,B 0,C 180}}\n{body}\nEND\n{more}");
        let refused = expanded(&source).map(|program| text(&program)).expect_err(body);
        let place = refused.find('`').unwrap();
        assert_eq!(refused[place..], message, "{refused}\n{source}");
        let statement = &message[1..1 + message[1..].find('`').unwrap()];
        let line: usize = refused["p.src:".len()..place - 2].parse().unwrap();
        assert_eq!(source.lines().nth(line - 1).unwrap(), statement, "{refused}");
    }
    let uncalled = expanded("DEF p( )\nLIN P\nEND\nDEF q( )\nLIN Q\nEND\n").unwrap_err();
    assert!(uncalled.starts_with("p.src:4: `DEF q( )`: has motions and is not called"), "{uncalled}");
    let twice = expanded("DEF p( )\nLIN P\nq( )\nEND\nDEF q( )\nLIN Q\nEND\nDEF Q( )\nEND\n").unwrap_err();
    assert!(twice.starts_with("p.src:8: `DEF Q( )`: expected each routine once"), "{twice}");
}

#[test]
fn any_program_is_followed_or_refused() {
    let source = format!(
        "&ACCESS RVP\nDEF p( )\nDECL INT I,J[3]\nPOS W\n{GO}FOR I=1 TO 2 STEP 1\nW=P:{{X 1,Y 0,Z 0,A 0,B 0,C 0}}\nJ[I]='B110'\nsub(W,J[])\nENDFOR\nEND\nDEF \
         sub(a:OUT,b[]:OUT)\nPOS a\nINT b[]\nb[2]=b[1]+1\na.X=a.X-b[2]\nLIN a C_DIS\nSWITCH b[2]\nCASE 7\nCIRC {{X 0,Y 9,Z 3}},Q,CA 9*10\nENDSWITCH\nEND\n"
    );
    let program = expanded(&source).unwrap();
    assert_eq!(ends(&program)[1], [-5.0, 2.0, 3.0]);
    for cut in (0..source.len()).filter(|cut| source.is_char_boundary(*cut)) {
        let _ = expanded(&source[..cut]);
        let _ = expanded(&format!("{}{}", &source[..cut], &source[cut + 1..]));
    }
    let deep = format!("DEF p()\nIF {}1{}==1 THEN\nLIN P\nENDIF\nEND\n", "(".repeat(5000), ")".repeat(5000));
    assert!(
        expanded(&deep)
            .unwrap_err()
            .contains("5000 levels of brackets, signs, branches and data in one another; expected at most 64")
    );
    let long = format!("DEF p()\nINT I,K\n{GO}FOR I=1 TO 1000000\nK=K+I\nLIN_REL {{X 0}}\nENDFOR\nEND\n");
    assert!(expanded(&long).unwrap_err().contains("has run 1000000 statements and has not ended"));
}
