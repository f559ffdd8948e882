//! What is refused of Sinumerik's and Heidenhain's programs, and in which words.

use kinetostat_programs::gcode::{Dialect, GcodeOptions, GcodeProgram};

const PARAMETER: &str = "parameters, variables and expressions are not followed; expected plain numbers";
const FLOW: &str = "jumps, loops, branches and repeats are not followed; expected the blocks in the order they run";
const CALL: &str = "calls a subprogram, or is a word that is not read; expected one program without calls";
const CYCLE: &str = "cycles are not followed; expected the cycle written out as moves";
const MOTION: &str = "this motion is not followed; expected straight lines, and arcs by centre or radius";
const CORNER: &str =
    "roundings and chamfers that the control inserts are not followed; expected them as arcs and lines";
const FRAME: &str = "rotated, scaled, mirrored and polar coordinates are not followed; expected plain coordinates";
const INCLINES: &str = "inclines the plane, and no rotary axes are known; expected a machine with drives A, B or C, or [[gcode.rotary]] in the process file";
const KINEMATICS: &str =
    "transformations of the control (tool centre point, tilted plane, cylinder) are not followed; expected them off";
const CUTTER: &str = "cutter radius compensation is not followed as the control makes it; expected the path of the tool centre with R0, or cutter_compensation = \"off\" in [gcode] of the process file, which writes it";
const M_FUNCTION: &str = "this M function changes where the tool goes or how fast; expected a program without it";
const UNKNOWN: &str =
    "not a statement that is read; expected one that begins as L, C, CR, CC, TOOL CALL, CYCL DEF or M do";

fn refusal(source: &str, dialect: Option<Dialect>) -> String {
    let options = GcodeOptions { dialect, ..GcodeOptions::default() };
    GcodeProgram::parse(source, "part", &options).expect_err(source).to_string()
}

/// Refusal of a line that follows two good ones.
fn sinumerik(line: &str) -> String {
    refusal(&format!("G710 G90 G17 F=100\nG0 X0 Y0 Z0\n{line}\n"), None)
}

/// Refusal of a block that follows three good ones.
fn heidenhain(block: &str) -> String {
    refusal(&format!("BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+10 Y+0 Z+0 FMAX\n{block}\nEND PGM A MM\n"), None)
}

/// Lines that are refused: column and words that are named, and why.
const NOT_FOLLOWED_OF_SINUMERIK: [(&str, &str, &str); 60] = [
    ("R1=5", "1: `R1=5`", PARAMETER),
    ("G1 X=R1", "4: `X=R1`", PARAMETER),
    ("G1 X=5*2", "4: `X=5*2`", PARAMETER),
    ("G1 X=IC(R2)", "4: `X=IC(R2)`", PARAMETER),
    ("G1 X1.5EX-3", "4: `X1.5EX-3`", PARAMETER),
    ("$P_UIFR[1]=CTRANS(X,5)", "1: `$P_UIFR[1]=CTRANS(X,5)`", PARAMETER),
    ("DEF REAL LENGTH", "1: `DEF`", PARAMETER),
    ("DEPTH=5", "1: `DEPTH=5`", PARAMETER),
    ("N30 IF R1>5 GOTOF END", "5: `IF`", FLOW),
    ("GOTOB START", "1: `GOTOB`", FLOW),
    ("FOR R1=1 TO 5", "1: `FOR`", FLOW),
    ("REPEAT START P=3", "1: `REPEAT`", FLOW),
    ("L100", "1: `L100`", CALL),
    ("POCKET_ROUGH", "1: `POCKET_ROUGH`", CYCLE),
    ("ROUGHING(5, 2)", "1: `ROUGHING(5,`", CALL),
    ("CALL \"PART\"", "1: `CALL`", CALL),
    ("E_HEAD(1,2)", "1: `E_HEAD(1,2)`", CALL),
    ("CYCLE81(11,6,5,-50)", "1: `CYCLE81(11,6,5,-50)`", CYCLE),
    ("MCALL CYCLE83(50,0,2,-25)", "1: `MCALL`", CYCLE),
    ("HOLES1(0,0,0,5,10,3)", "1: `HOLES1(0,0,0,5,10,3)`", CYCLE),
    ("POCKET3(5,0,1,-10)", "1: `POCKET3(5,0,1,-10)`", CYCLE),
    ("CIP X5 Y5 I1=2 J1=3", "1: `CIP`", MOTION),
    ("G3 X5 I1=2", "7: `I1=2`", MOTION),
    ("CT X5 Y5", "1: `CT`", MOTION),
    ("BSPLINE X5 Y5", "1: `BSPLINE`", MOTION),
    ("G2 X5 Y5 AR=90", "10: `AR=90`", MOTION),
    ("G2 X5 Y5 I5 J0 TURN=2", "16: `TURN=2`", MOTION),
    ("G33 Z-5 K1", "1: `G33`", MOTION),
    ("G147 X5", "1: `G147`", MOTION),
    ("G1 X5 RND=2", "7: `RND=2`", CORNER),
    ("G1 X5 CHF=1", "7: `CHF=1`", CORNER),
    ("ROT RPL=30", "1: `ROT`", FRAME),
    ("AROT Z30", "1: `AROT`", FRAME),
    ("SCALE X2 Y2", "1: `SCALE`", FRAME),
    ("MIRROR X0", "1: `MIRROR`", FRAME),
    ("G58 X5", "1: `G58`", FRAME),
    ("G111 X5 Y5", "1: `G111`", FRAME),
    ("G1 AP=30 RP=5", "4: `AP=30`", FRAME),
    ("ORIWKS", "1: `ORIWKS`", KINEMATICS),
    ("TRACYL", "1: `TRACYL`", KINEMATICS),
    ("TRANSMIT", "1: `TRANSMIT`", KINEMATICS),
    ("TRACYL(40)", "1: `TRACYL(40)`", KINEMATICS),
    ("G1 X5 A3=0 B3=0 C3=1", "7: `A3=0`", KINEMATICS),
    (
        "G41 X5",
        "1: `G41`",
        "cutter radius compensation is not followed as the control makes it; expected the path of the tool centre with G40, or cutter_compensation = \"off\" in [gcode] of the process file, which writes it",
    ),
    ("G1 X1=5", "4: `X1=5`", "a coordinate of the machine; expected it with G74 or G75"),
    ("G1 X= Y5", "4: `X=`", PARAMETER),
    ("G1 Y5 X=", "7: `X=`", "expected a number after it"),
    ("MSG(\"open", "4: `(\"open`", "not closed; expected ) on the same line"),
    ("T=\"MILL", "3: `\"MILL`", "not closed; expected \" on the same line"),
    ("G92 X0", "1: `G92`", "this G word is not supported; expected a word of a 3-axis mill program"),
    ("G1 X5 U3", "7: `U3`", "secondary axes are not supported; expected X, Y and Z only"),
    (
        "G4 X5",
        "4: `X5`",
        "coordinate on a line with G4, which is no motion; expected the coordinate on a line of its own",
    ),
    (
        "TRANS C30",
        "7: `C30`",
        "turns C, which stood at 0; expected rotary axes that keep one value, or [[gcode.rotary]] in the process file, which says what C turns",
    ),
    (
        "G1 X5 C30\nC40",
        "",
        "turns C, which stood at 30; expected rotary axes that keep one value, or [[gcode.rotary]] in the process file, which says what C turns",
    ),
    ("G1 X5 X=6", "7: `X=6`", "second X word on the line; expected one"),
    ("G1 X5 I2", "7: `I2`", "arc word on a line that is no arc; expected G2 or G3 in force"),
    ("G2 X10 I=AC(5) J5", "1: `G2`", "one centre word from the start and one from the zero; expected both of one kind"),
    (
        "G505 G1 X5",
        "6: `G1`",
        "how G505 stands to the work offset before it is not known; expected its zero in [gcode] of the process file",
    ),
    ("TRANS ATRANS X5", "7: `ATRANS`", "contradicts TRANS on the same line; expected one of them"),
    ("G1 X5 #", "7: `#`", "unexpected character; expected words such as X10.5, or a comment in ( ) or after ;"),
];

#[test]
fn what_sinumerik_has_and_is_not_followed_is_named() {
    for (line, found, why) in NOT_FOLLOWED_OF_SINUMERIK {
        let message = sinumerik(line);
        let (line_number, found) = if found.is_empty() { (4, "1: `C40`") } else { (3, found) };
        assert_eq!(message, format!("part:{line_number}:{found}: {why} (read as Sinumerik)"), "{line}");
    }
    assert_eq!(
        refusal("%_N_A_MPF\nG0 X0 Y0 Z0\n%_N_B_SPF\nG0 X5\n", None),
        "part:4:4: `X5`: a motion after the end of the program in line 3; expected none (read as Sinumerik)"
    );
}

/// Blocks that are refused: column and words that are named, and why.
const NOT_FOLLOWED_OF_HEIDENHAIN: [(&str, &str, &str); 63] = [
    ("L X+Q1 R0 F100", "3: `X+Q1`", PARAMETER),
    ("12 L X+5 FQ50", "10: `FQ50`", PARAMETER),
    ("Q1 = 5", "1: `Q1 = 5`", PARAMETER),
    ("FN 0: Q5 = +10", "1: `FN 0: Q5 = +10`", PARAMETER),
    ("FN 18: SYSREAD Q1 = ID270", "1: `FN 18: SYSREAD Q1 = ID270`", PARAMETER),
    ("FN 9: IF +Q1 EQU +Q2 GOTO LBL 5", "1: `FN 9: IF +Q1 EQU +Q2 GOTO LBL 5`", FLOW),
    ("FN 12: IF +Q1 LT +Q2 GOTO LBL 5", "1: `FN 12: IF +Q1 LT +Q2 GOTO LBL 5`", FLOW),
    ("CALL LBL 5 REP 3", "1: `CALL LBL 5 REP 3`", FLOW),
    ("CALL PGM 100.H", "1: `CALL PGM 100.H`", CALL),
    ("SEL PGM \"A\"", "1: `SEL PGM \"A\"`", CALL),
    ("CYCL DEF 12.0 PGM CALL", "1: `CYCL DEF 12.0 PGM CALL`", CALL),
    ("CYCL DEF 200 DRILLING ~", "1: `CYCL DEF 200 DRILLING ~`", CYCLE),
    ("CYCL CALL M3", "1: `CYCL CALL M3`", CYCLE),
    ("PATTERN DEF POS1 (X+5 Y+5 Z+0)", "1: `PATTERN DEF POS1 (X+5 Y+5 Z+0)`", CYCLE),
    ("TCH PROBE 400", "1: `TCH PROBE 400`", CYCLE),
    ("L X+5 FMAX M99", "12: `M99`", CYCLE),
    ("L X+5 FMAX M89", "12: `M89`", CYCLE),
    ("CT X+5 Y+5", "1: `CT X+5 Y+5`", MOTION),
    ("APPR LT X+5 Y+5 LEN10", "1: `APPR LT X+5 Y+5 LEN10`", MOTION),
    ("DEP CT CCA180 R+8", "1: `DEP CT CCA180 R+8`", MOTION),
    ("FL X+5 AN+30", "1: `FL X+5 AN+30`", MOTION),
    ("FPOL X+0 Y+0", "1: `FPOL X+0 Y+0`", MOTION),
    ("RND R5", "1: `RND R5`", CORNER),
    ("CHF 2", "1: `CHF 2`", CORNER),
    ("CYCL DEF 8.0 MIRROR IMAGE", "1: `CYCL DEF 8.0 MIRROR IMAGE`", FRAME),
    ("CYCL DEF 10.1 ROT+30", "1: `CYCL DEF 10.1 ROT+30`", FRAME),
    ("CYCL DEF 11.1 SCL 0.5", "1: `CYCL DEF 11.1 SCL 0.5`", FRAME),
    ("CYCL DEF 7.1 C+30", "14: `C+30`", FRAME),
    ("LP PR+40 PA+30", "1: `LP PR+40 PA+30`", FRAME),
    ("CP IPA+720 IZ-5 DR+", "1: `CP IPA+720 IZ-5 DR+`", FRAME),
    ("CC PR+5 PA+30", "4: `PR+5`", FRAME),
    ("CYCL DEF 19.1 A+0 B+10 C+0", "1: `CYCL DEF 19.1 A+0 B+10 C+0`", KINEMATICS),
    ("PLANE SPATIAL SPA+0 SPB+45 SPC+0 STAY", "1: `PLANE SPATIAL`", INCLINES),
    ("PLANE RESET TURN", "1: `PLANE RESET`", INCLINES),
    ("FUNCTION TCPM F TCP AXIS POS", "1: `FUNCTION TCPM F TCP AXIS POS`", KINEMATICS),
    ("LN X+5 Y+5 Z+0 NX+0 NY+0 NZ+1", "1: `LN X+5 Y+5 Z+0 NX+0 NY+0 NZ+1`", KINEMATICS),
    ("M114", "1: `M114`", KINEMATICS),
    ("M98", "1: `M98`", M_FUNCTION),
    ("L X+5 M118 X1", "7: `M118`", M_FUNCTION),
    ("CYCL DEF 7.1 #5", "1: `CYCL DEF 7.1 #5`", "datum tables are not read; expected CYCL DEF 7 with X, Y or Z"),
    (
        "CYCL DEF 7.0 DATUM SHIFT ~",
        "1: `CYCL DEF 7.0 DATUM SHIFT ~`",
        "a datum shift whose axes stand behind ~ is not read; expected CYCL DEF 7.1 and further blocks with X, Y or Z",
    ),
    (
        "CYCL DEF 247 DATUM SETTING",
        "1: `CYCL DEF 247 DATUM SETTING`",
        "which preset the cycle sets is not said; expected Q339 with its number in the block",
    ),
    ("L X+5 RL F100", "7: `RL`", CUTTER),
    ("L X+5 R+ F100", "7: `R+`", CUTTER),
    ("L X R0", "3: `X`", "expected a number after it"),
    ("C X+5 Y+5 DR+", "1: `C`", "arc without a centre; expected CC with its coordinates before it"),
    ("C X+5 Y+5", "1: `C`", "an arc without its direction; expected DR+ or DR-"),
    ("C X+5 Y+5 DR", "11: `DR`", "an arc without its direction; expected DR+ or DR-"),
    ("C X+5 Y+5 DR+ DR-", "15: `DR-`", "a second one in the block; expected one"),
    ("C DR+", "1: `C`", "an arc without its end; expected X, Y or Z"),
    ("CR X+5 Y+5 DR+", "1: `CR`", "an arc without a radius; expected R with a number, or CC and C"),
    (
        "CR X+30 Y+0 R+5 DR+",
        "1: `CR`",
        "radius 5.0000 mm cannot reach an end 20.0000 mm away; expected at least half the distance",
    ),
    ("CR X+20 R+5 DR+ FMAX", "17: `FMAX`", "a rapid arc; expected a feed"),
    (
        "CC X+5",
        "1: `CC`",
        "expected both coordinates of the plane that TOOL CALL chooses by the axis of the tool, or none",
    ),
    ("L X+5 ~", "1: `L X+5 ~`", "a block that continues in the next line (`~`); expected the whole block in one line"),
    ("X+5 R0 FMAX", "1: `X+5 R0 FMAX`", UNKNOWN),
    ("G1 X5", "1: `G1 X5`", UNKNOWN),
    ("L X+5 K3", "7: `K3`", UNKNOWN),
    ("L X+5 /", "7: `/`", UNKNOWN),
    ("L X+5 U+3", "7: `U+3`", "secondary axes are not supported; expected X, Y and Z only"),
    ("L X+5 IX+3", "7: `IX+3`", "second X word on the line; expected one"),
    ("L X+5 M3.5", "7: `M3.5`", "expected a whole number after M"),
    (
        "CYCL DEF 247 DATUM SETTING Q339=+3\nL X+5\nCYCL DEF 247 Q339=+4\nL X+6",
        "1: `L`",
        "how preset 3 stands to the work offset before it is not known; expected its zero in [gcode] of the process file",
    ),
];

#[test]
fn what_heidenhain_has_and_is_not_followed_is_named() {
    for (block, found, why) in NOT_FOLLOWED_OF_HEIDENHAIN {
        let message = heidenhain(block);
        let line = if why.contains("preset 3") { 5 } else { 4 };
        assert_eq!(message, format!("part:{line}:{found}: {why} (read as Heidenhain)"), "{block}");
    }
    assert_eq!(
        refusal("0 BEGIN PGM A\n", None),
        "part:1:3: `BEGIN PGM A`: names no unit; expected MM or INCH at its end (read as Heidenhain)"
    );
    assert_eq!(
        refusal("BEGIN PGM A MM\nL X+0 Y+0 Z+0\nEND PGM A MM\nL X+5\n", None),
        "part:4:3: `X+5`: a motion after the end of the program in line 3; expected none (read as Heidenhain)"
    );
    assert_eq!(
        heidenhain("L C+0 FMAX\nL C+90"),
        "part:5:3: `C+90`: turns C, which stood at 0; expected rotary axes that keep one value, or [[gcode.rotary]] in the process file, which says what C turns (read as Heidenhain)"
    );
}

#[test]
fn a_dialect_that_is_asked_for_is_not_told_by_the_text() {
    assert_eq!(
        refusal("G0 X0 Y0 Z0\n", Some(Dialect::Heidenhain)),
        format!("part:1:1: `G0 X0 Y0 Z0`: {UNKNOWN} (read as Heidenhain)")
    );
    assert_eq!(
        refusal("BEGIN PGM A MM\n", Some(Dialect::Sinumerik)),
        format!("part:1:1: `BEGIN`: {CALL} (read as Sinumerik)")
    );
    assert_eq!(
        refusal("G2 X5 R3\n", Some(Dialect::Sinumerik)),
        format!("part:1:7: `R3`: {PARAMETER} (read as Sinumerik)")
    );
    assert!(refusal("BEGIN PGM A MM\n", Some(Dialect::Iso)).starts_with("part:1:1: `BEGIN`: not ISO code"));
}
