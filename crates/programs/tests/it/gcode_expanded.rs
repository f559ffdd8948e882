//! Programs with calls, loops, jumps and expressions, written out as the motion they make.

use std::path::Path;

use crate::support::cases::cases;
use crate::support::programs::programs_in;
use kinetostat_programs::{
    Sampling, WriteOptions,
    gcode::{BlockDelete, Fault, GcodeError, GcodeOptions, GcodeProgram, MacroFault},
};
use nalgebra::Vector3;

fn expanded(source: &str) -> Result<GcodeProgram, GcodeError> {
    let beside = |name: &str| match name {
        "O0200" => Some(b"%\nO0200\nG91 X1\nM99\n%\n".to_vec()),
        "step.ngc" => Some(b"o<step> sub\nG91 G1 Y[#1]\no<step> endsub\n".to_vec()),
        "broken" => Some(b"O300\nG1 X#7\nM99\n".to_vec()),
        _ => None,
    };
    GcodeProgram::parse_expanded(source.as_bytes(), "part.nc", &GcodeOptions::default(), &beside)
}

/// The lines that a program is written out in, without its header.
fn lines(source: &str) -> Vec<String> {
    let program = expanded(source).unwrap_or_else(|error| panic!("{error}"));
    let text = String::from_utf8(program.source().to_vec()).unwrap();
    let (header, lines): (Vec<_>, Vec<_>) =
        text.lines().map(String::from).partition(|line| line.starts_with("(written"));
    let counted = format!("(written out by kinetostat: {} lines for {})", lines.len() + 1, source.lines().count());
    assert_eq!(header, [counted]);
    lines
}

fn refusal(source: &str) -> String {
    expanded(source).expect_err("expected a refusal").to_string()
}

#[test]
fn calls_are_written_out_as_often_as_they_are_made() {
    assert_eq!(
        lines(
            "%\nO1\nG0 X0 Y0 Z0\nM98 P100 L2\nM98 P0200\nG90 M97 P50\nM30\nO100 (a step)\nG91 G1 X5 F9 (cut)\nM99\nN50 Y7\nM99\n%\n"
        ),
        ["%", "O1", "G0 X0 Y0 Z0", "G91 G1 X5 F9 (cut)", "G91 G1 X5 F9 (cut)", "G91 X1", "G90", "N50 Y7", "M30", "%"]
    );
}

#[test]
fn loops_and_jumps_of_macros_are_followed() {
    let source = "G0 X0 Y0 Z0\n#100=0 #101=2.5\nWHILE [#100 LT 3] DO 1\nG1 X[#100*#101] F100 (pass)\n#100=[#100+1]\nEND 1\n\
                  IF [#100 EQ 3] GOTO 20\nG1 X99\nN20 IF [#100 GT 5] THEN #101=9\nG1 Y-#101\nM30\n";
    assert_eq!(
        lines(source),
        ["G0 X0 Y0 Z0", "G1 X0.0 F100 (pass)", "G1 X2.5 F100 (pass)", "G1 X5.0 F100 (pass)", "G1 Y-2.5", "M30"]
    );
}

#[test]
fn o_words_are_followed() {
    let source = "o<hole> sub\n  G1 X#1 F[#2]\n  o10 if [#1 GT 5]\n    Z#<_deep>\n  o10 elseif [#1 GT 3]\n    Z-9\n  o10 else\n    Z9\n  \
                  o10 endif\no<hole> endsub [#1*2]\n#<_deep> = -2\nG0 X0 Y0 Z0\no<hole> call [6] [100]\no<hole> call [4] [100]\n\
                  o<hole> call [1] [50]\nX#<_value>\no20 repeat [2]\nG91 Y1\no20 endrepeat\n#5=0\no30 while [#5 LT 9]\n#5=[#5+1]\n\
                  o31 if [#5 EQ 2]\no30 break\no31 endif\nX#5\no30 endwhile\no40 do\n#5=[#5-1]\no40 while [#5 GT 0]\n\
                  o<step> call [0.25]\nM2\n";
    let found = lines(source);
    let code: Vec<&str> = found.iter().map(|line| line.trim()).collect();
    assert_eq!(
        code,
        [
            "G0 X0 Y0 Z0",
            "G1 X6.0 F100.0",
            "Z-2.0",
            "G1 X4.0 F100.0",
            "Z-9",
            "G1 X1.0 F50.0",
            "Z9",
            "X2.0",
            "G91 Y1",
            "G91 Y1",
            "X1.0",
            "G91 G1 Y0.25",
            "M2"
        ]
    );
}

#[test]
fn what_depends_on_the_machine_or_does_not_end_is_refused_with_its_line() {
    let values =
        "depends on the state of the machine; expected variables #1 to #999 and names that the program assigns";
    for (source, expected) in [
        ("G0 X0\nG1 X#5061\n", format!("part.nc:2:4: `X#5061`: {values}")),
        ("#3000=1\n", format!("part.nc:1:1: `#3000=1`: {values}")),
        (
            "G1 X#7\n",
            "part.nc:1:4: `X#7`: a variable without a value; expected one that the program has assigned before".into(),
        ),
        (
            "N1 G0 X0\nGOTO 1\n",
            "part.nc:1:4: `G0 X0`: the program has run 1000000 lines and has not ended; expected one that ends".into(),
        ),
        (
            "O1\nM98 P7\n",
            "part.nc:2:1: `M98 P7`: subprogram 7 is neither in the file nor beside it; expected O7, a file of this name, or 7 in calls_kept of [gcode] if it moves nothing".into(),
        ),
        (
            "O1\nM98 P1\n",
            "part.nc:2:1: `M98 P1`: calls are more than 50 deep; expected subprograms that do not call themselves".into(),
        ),
        (
            "G0 X0\nGOTO 9\n",
            "part.nc:2:1: `GOTO 9`: its other end is not in the program; expected the label, or the word that ends or begins the \
             same loop, branch or subprogram"
                .into(),
        ),
        (
            "O1\nM98 P300\nM30\nO300\nG0 X0 Y0 Z0\nG1 X5 U3\nM99\n",
            "part.nc:6:7: `U3`: secondary axes are not supported; expected X, Y and Z only".into(),
        ),
    ] {
        let found = refusal(source);
        assert_eq!(found, expected, "{source}");
    }
    let plain =
        |source: &str| GcodeProgram::parse(source, "part.nc", &GcodeOptions::default()).unwrap_err().to_string();
    assert!(
        plain("#1=5\n").ends_with(
            "expected plain numbers, or expand in [gcode] of the process file (--expand), which writes it out"
        )
    );
    assert!(
        plain("M98 P1\n").ends_with(
            "expected one program, or expand in [gcode] of the process file (--expand), which writes it out"
        )
    );
}

#[test]
fn lines_are_those_of_the_program_and_what_is_written_is_read_back() {
    let program = expanded("O1\nG21\nG0 X0 Y0 Z0\nM98 P100 L3\nM30\nO100\nG91 G1 X5 F9\nM99\n").unwrap();
    let path = program.toolpath(Sampling::new(1.0, 100.0).unwrap()).unwrap();
    let lines: Vec<_> = (0..4).map(|segment| program.line_of(segment).unwrap()).collect();
    assert_eq!(lines, [3, 7, 7, 7]);
    assert_eq!(program.notes().written_out, Some([8, 8]));
    let goals: Vec<_> = path.positions_mm().iter().map(|p| p + Vector3::new(0.01 * p.x, 0.0, 0.0)).collect();
    let written = program.rewrite(&path, &goals, WriteOptions::default()).unwrap();
    for (back, goal) in written.read_back().unwrap().positions_mm().iter().zip(goals) {
        assert!((back - goal).amax() <= 1e-4);
    }
}

/// Programs to write out, each with what is expected of it in a folder beside; others are called by them.
#[test]
fn programs_are_written_out_as_expected() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gcode_expanded");
    let beside = |name: &str| std::fs::read(folder.join(name)).ok();
    let update = std::env::var_os("UPDATE_GOLDEN").is_some();
    let expected = programs_in("tests/gcode_expanded/expected");
    assert!(expected.len() >= 12, "{} programs", expected.len());
    for (name, expected) in expected {
        let source = std::fs::read(folder.join(&name)).unwrap();
        let program = GcodeProgram::parse_expanded(source, &name, &GcodeOptions::default(), &beside).unwrap();
        if update {
            std::fs::write(folder.join("expected").join(&name), program.source()).unwrap();
        } else {
            assert_eq!(String::from_utf8_lossy(program.source()), String::from_utf8_lossy(&expected), "{name}");
        }
        let path = program.toolpath(Sampling::new(0.05, 2.0).unwrap()).unwrap();
        let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
        assert_eq!(same.bytes(), program.source(), "{name}");
        // The same program, when it is read as it was written out.
        let again = GcodeProgram::parse(program.source(), &name, &GcodeOptions::default()).unwrap();
        let positions = again.toolpath(Sampling::new(0.05, 2.0).unwrap()).unwrap().positions_mm();
        assert_eq!(positions, path.positions_mm(), "{name}");
        let goals: Vec<_> = path.positions_mm().iter().map(|p| p + Vector3::new(0.02, 0.01 * p.x.sin(), 0.1)).collect();
        let written = program.rewrite(&path, &goals, WriteOptions::default()).unwrap();
        for ((back, goal), point) in written.read_back().unwrap().positions_mm().iter().zip(goals).zip(path.points()) {
            let is_way_to_hole = program.is_hole(point.source.segment) && point.source.parameter != 0.75;
            assert!(is_way_to_hole || (back - goal).amax() <= 2.6e-4, "{name}: {back} {goal}");
        }
    }
}

#[test]
fn cycles_written_out_go_where_cycles_go() {
    for (name, source) in programs_in("tests/gcode_cycles") {
        let corners = |program: GcodeProgram| -> Vec<Vector3<f64>> {
            let path = program.toolpath(Sampling::new(0.05, 1e4).unwrap()).unwrap();
            let mut corners: Vec<Vector3<f64>> = Vec::new();
            for point in path.points().iter().filter(|point| point.cutting) {
                if corners.last().is_none_or(|last| (last - point.position_mm).amax() > 1e-6) {
                    corners.push(point.position_mm);
                }
            }
            corners
        };
        let options = GcodeOptions::default();
        let bottoms = corners(GcodeProgram::parse(source.clone(), &name, &options).unwrap());
        let moves = corners(GcodeProgram::parse_expanded(source, &name, &options, &|_| None).unwrap());
        let mut moves = moves.iter();
        for bottom in bottoms {
            assert!(moves.any(|place| (place - bottom).amax() < 1e-7), "{name}: {bottom}");
        }
    }
}

#[test]
fn pecks_come_back_as_far_as_their_cycle_says() {
    assert_eq!(
        lines("G21 G90 G0 X0 Y0 Z9\nG99 G83 X5 Z-5 R1 Q2.5 P250 F60 M8\nG98 G73 X7 Q4. M9\nG80\nM2\n"),
        [
            "G21 G90 G0 X0 Y0 Z9",
            "G99 G0 X5 F60 M8",
            "G0 Z1.0",
            "G1 Z-1.5",
            "G0 Z1.0",
            "G0 Z-1.246",
            "G1 Z-4.0",
            "G0 Z1.0",
            "G0 Z-3.746",
            "G1 Z-5.0",
            "G4 P250",
            "G0 Z1.0",
            "G98 G0 X7",
            "G1 Z-3.0",
            "G0 Z-2.746",
            "G1 Z-5.0",
            "G0 Z9.0 M9",
            "G80",
            "M2"
        ]
    );
}

#[test]
fn words_beside_a_call_come_before_it() {
    assert_eq!(
        lines("G0 X0 Y0 Z0\nG91 X7 M98 P100 L2 (go)\nM30\nO100\nY1\nZ2 M99\n")[1..],
        ["G91 X7 (go)", "Y1", "Z2", "Y1", "Z2", "M30"]
    );
}

#[test]
fn any_text_is_written_out_or_refused() {
    use proptest::prelude::*;
    let mut runner = proptest::test_runner::TestRunner::new(cases(512));
    let text = "(o1 (if|sub|while|endwhile|endsub|call|repeat|endrepeat)|#[1-4]=|\\[|\\]|[GXMPNLO#][0-9]{0,3}|[+*/<>-]|M98 P1|M99|EQ|GOTO 1|\n| ){0,40}";
    runner
        .run(&text, |source| {
            let none = |_: &str| None;
            let options = GcodeOptions { block_delete: BlockDelete::Run, ..GcodeOptions::default() };
            if let Ok(program) = GcodeProgram::parse_expanded(source.as_bytes(), "any.nc", &options, &none) {
                prop_assert!(!program.source().is_empty());
            }
            Ok(())
        })
        .unwrap();
}

/// Where X stands that is given as `text`, with `#1` 3 and `#<_WIDTH>` 2.5.
fn value(text: &str) -> Result<f64, Fault> {
    let program = expanded(&format!("#1=3\n#<_WIDTH>=2.5\n#2={text}\nG0 X#2 Y0 Z0\n")).map_err(|error| error.fault)?;
    let path = program.toolpath(Sampling::default()).unwrap();
    Ok(path.points().last().unwrap().position_mm.x)
}

#[test]
fn expressions_are_worth_what_controls_say() {
    for (text, expected) in [
        ("-5.", -5.0),
        ("[1+2*3]", 7.0),
        ("[2**3*2]", 16.0),
        ("-[#1 - #<_WIDTH>]", -0.5),
        ("[SIN[30]+COS[60]]", 1.0),
        ("ATAN[1]/[-1]", 135.0),
        ("[7 MOD 4]", 3.0),
        ("[FIX[2.9] + FUP[2.1] + ROUND[2.5]]", 8.0),
        ("[#1 GT 2 AND #1 LE 3]", 1.0),
        ("[#7 EQ #0]", 1.0),
        ("[#1 NE #0]", 1.0),
        ("EXISTS[#<_WIDTH>]", 1.0),
    ] {
        assert!((value(text).unwrap() - expected).abs() < 1e-12, "{text}");
    }
}

#[test]
fn expressions_without_a_value_are_refused() {
    assert_eq!(value("[#7+1]"), Err(Fault::Macro(MacroFault::NoValue)));
    assert_eq!(value("[1/0]"), Err(Fault::Macro(MacroFault::NotFinite)));
    assert_eq!(value("[1+2"), Err(Fault::Macro(MacroFault::Expression { expected: "]" })));
    assert_eq!(value("#5061"), Err(Fault::Macro(MacroFault::MachineState)));
    assert!(value(&"[".repeat(100_000)).is_err());
    assert!(value(&"-".repeat(100_000)).is_err());
}

/// What macros compute has eight digits, and what is corrected the decimals that the file has, not those of computed numbers.
#[test]
fn decimals_are_those_of_the_file_and_not_of_what_macros_compute() {
    let source = "G21 G90 F100\n#1=10.\nG0 X0 Y0 Z5.\nG1 X[#1*COS[33.]] Y[#1*100.*SIN[33.]]\nG1 X5.25 Y5.\n";
    let program = GcodeProgram::parse_expanded(source, "part.nc", &GcodeOptions::default(), &|_| None).unwrap();
    let text = String::from_utf8(program.source().to_vec()).unwrap();
    assert!(text.contains("G1 X8.3867057 Y544.63904\n"), "{text}");
    assert_eq!((program.own_format().mm_decimals(), program.own_format().inch_decimals()), (3, 4));
    let fine = source.replace("X5.25", "X5.25000");
    let program = GcodeProgram::parse_expanded(fine, "part.nc", &GcodeOptions::default(), &|_| None).unwrap();
    assert_eq!(program.own_format().mm_decimals(), 5);
}

/// Positions of the tool in X and Y at the ends of the moves of a program in plain coordinates, to 1e-6 mm.
fn ends(source: &str) -> Vec<[f64; 2]> {
    let program = expanded(source).unwrap_or_else(|error| panic!("{error}"));
    let path = program.toolpath(Sampling::new(1e4, 1e4).unwrap().with_max_turn(4.0).unwrap()).unwrap();
    let points = path.points();
    let is_last = |k: &usize| points.get(k + 1).is_none_or(|next| next.source.segment != points[*k].source.segment);
    let round = |c: f64| (c * 1e6).round() / 1e6 + 0.0;
    (0..points.len()).filter(is_last).map(|k| [points[k].position_mm.x, points[k].position_mm.y].map(round)).collect()
}

#[test]
fn rotated_coordinates_are_written_plain() {
    // A quarter turn about (10, 5): (10 + a, 5 + b) becomes (10 − b, 5 + a).
    let source = "G21 G90 G54 G0 X0 Y0 Z0\nG68 X10 Y5 R90\nG1 X20 Y5 F100\nX20 Y8\nG3 X17 Y11 I-3 J0\nG91 G1 X2\nG90 G69\nG1 X0 Y0\nM30\n";
    assert_eq!(ends(source), [[0.0, 0.0], [10.0, 15.0], [7.0, 15.0], [4.0, 12.0], [4.0, 14.0], [0.0, 0.0]]);
    assert_eq!(
        lines(source)[2..6],
        ["G1 X10.0 Y15.0 F100", "X7.0 Y15.0", "G3 X4.0 Y12.0 I0.0 J-3.0", "G91 G1 X0.0 Y2.0"]
    );
    // Holes of a cycle, whose Z and R stay; by calls, each time by another angle.
    let source = "G0 X0 Y0 Z5\n#1=0\nWHILE [#1 LT 3] DO1\nG68 X0 Y0 R[#1*90]\nG81 X10 Y0 Z-2 R1 F50\nG80 G69\n#1=#1+1\nEND1\nM30\n";
    let found = lines(&source.replace("G81", "G1").replace("R1 F50", "F50"));
    assert!(
        found.contains(&"G1 X0.0 Y10.0 Z-2 F50".to_owned()) && found.contains(&"G1 X-10.0 Y0.0 Z-2 F50".to_owned()),
        "{found:?}"
    );
    assert!(ends(source).contains(&[-10.0, 0.0]));
}

#[test]
fn polar_coordinates_are_written_plain() {
    let source = "G17 G90 G16\nG0 X100 Y0 Z5\nG1 Y90 F100\nX50\nG91 Y90\nG90 G15\nG1 X0 Y0\nM30\n";
    assert_eq!(ends(source), [[100.0, 0.0], [0.0, 100.0], [0.0, 50.0], [-50.0, 0.0], [0.0, 0.0]]);
    assert!(refusal("G0 X0 Y0 Z0\nG16\nG1 Y30 F9\n").contains("leads to a place that depends on the control here"));
    assert!(
        refusal("G0 X0 Y0 Z0\nG16\nG1 X9 Y30 F9\nG91 X5\n")
            .contains("not followed while coordinates are rotated or polar")
    );
}

#[test]
fn corners_of_lines_are_written_as_moves() {
    let square = |corner: &str| format!("G0 X0 Y0 Z0\nG1 X20{corner} F100\nY20\nX5 Y5\nM30\n");
    assert_eq!(ends(&square(",C3")), [[0.0, 0.0], [17.0, 0.0], [20.0, 3.0], [20.0, 20.0], [5.0, 5.0]]);
    assert_eq!(ends(&square(" ,R4.")), [[0.0, 0.0], [16.0, 0.0], [20.0, 4.0], [20.0, 20.0], [5.0, 5.0]]);
    assert_eq!(lines(&square(",R4"))[1..4], ["G1 X16.0 Y0.0 F100", "G3 X20.0 Y4.0 R4.0", "G1 X20.0 Y20.0"]);
    // A corner behind a corner; one to the right.
    let found = ends("G0 X0 Y0 Z0\nG1 X20 ,C3 F9\nY20 ,R2\nX40\nM30\n");
    assert_eq!(found, [[0.0, 0.0], [17.0, 0.0], [20.0, 3.0], [20.0, 18.0], [22.0, 20.0], [40.0, 20.0]]);
    let place = "are followed between two straight lines of G17 and G90 that are long enough";
    for source in [
        "G0 X0 Y0 Z0\nG1 X20 ,R25 F9\nY20\n",
        "G0 X0 Y0 Z0\nG1 X20 ,R5 F9\nG2 X30 Y10 I10 J0\n",
        "G0 X0 Y0 Z0\nG1 X20 ,R5 F9\nM8\nY20\n",
        "G0 X0 Y0 Z0\nG1 X20 ,R5 F9\nX30\n",
        "G0 X0 Y0 Z0\nG0 X20 ,R5\nG1 Y20 F9\n",
        "G0 X0 Y0 Z0\nG91 G1 X20 ,R5 F9\nY20\n",
        "G0 X0 Y0 Z0\nG1 X20 Z-1 ,C5 F9\nY20\n",
        "G0 X0 Y0 Z0\nG1 X20 ,C5 F9\nM30\n",
        "G0 X0 Y0 Z0\nG1 X20 ,C F9\nY20\n",
    ] {
        let refused = refusal(source);
        assert!(refused.contains(place), "{source}: {refused}");
    }
}

#[test]
fn rotations_that_depend_on_the_control_are_refused() {
    let begin = "G0 X0 Y0 Z0\nG68 X0 Y0 R30\n";
    for (source, problem) in [
        ("G0 X0 Y0 Z0\nG68 R30\nG1 X5 Y5 F9\n", "rotates by what the line does not say"),
        ("G0 X0 Y0 Z0\nG68 X0 Y0\nG1 X5 Y5 F9\n", "rotates by what the line does not say"),
        ("G0 X0 Y0 Z0\nG18\nG68 X0 Y0 R5\nG1 X5 Y5 F9\n", "rotates by what the line does not say"),
        (&format!("{begin}G1 X5 F9\n"), "leads to a place that depends on the control here"),
        (&format!("{begin}G91 G1 X5 Y5 F9\n"), "leads to a place that depends on the control here"),
        (&format!("{begin}G69\nG1 X5 F9\n"), "leads to a place that depends on the control here"),
        (&format!("{begin}G55 G1 X5 Y5 F9\n"), "not followed while coordinates are rotated or polar"),
        (&format!("{begin}G1 X5 Y5 F9\nG28 Z0\n"), "not followed while coordinates are rotated or polar"),
        (&format!("{begin}G68 X0 Y0 R9\n"), "not followed while coordinates are rotated or polar"),
        (
            &format!("G90.1\n{begin}G1 X5 Y5 F9\nG2 X7 Y7 I7 J5\n"),
            "not followed while coordinates are rotated or polar",
        ),
        ("G0 X0 Y0 Z0\nG51 X0 Y0 P2\n", "polar, scaled or rotated coordinates are not supported"),
    ] {
        let refused = refusal(source);
        assert!(refused.contains(problem), "{source}: {refused}");
    }
    let options = GcodeOptions { dialect: Some(kinetostat_programs::gcode::Dialect::LinuxCnc), ..Default::default() };
    let refused =
        GcodeProgram::parse_expanded(format!("{begin}G1 X5 Y5 F9\n").into_bytes(), "part.nc", &options, &|_| None);
    assert!(refused.unwrap_err().to_string().contains("polar, scaled or rotated coordinates"));
}

#[test]
fn subprograms_alone_are_read_from_where_they_are_called() {
    let source = "O5001\nG1 X20 F100\nG91 Y5\nM99 (back)\n%\n";
    let start = Some(Vector3::new(1.0, 2.0, 3.0));
    let options = GcodeOptions { start_mm: start, ..Default::default() };
    let program = GcodeProgram::parse(source, "5001.nc", &options).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    assert_eq!(path.points()[path.len() - 1].position_mm, Vector3::new(20.0, 7.0, 3.0));
    let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::with_decimals(program.own_format())).unwrap();
    assert_eq!(same.bytes(), source.as_bytes());
    let refused = GcodeProgram::parse_expanded(source, "5001.nc", &GcodeOptions::default(), &|_| None).unwrap_err();
    assert!(refused.to_string().contains("expected M2 or M30, or start_mm in [gcode]"), "{refused}");
    // With calls of its own, it is run to its end.
    let source = "O1\nM98 P100\nM99\nO100\nG91 G1 X1 F9\nM99\n";
    let program = GcodeProgram::parse_with_calls(source, "1.nc", &options, &|_| None).unwrap();
    assert_eq!(program.toolpath(Sampling::default()).unwrap().points()[0].position_mm, Vector3::new(2.0, 2.0, 3.0));
    assert!(GcodeProgram::parse("G1 X5 F9\nM99 P10\n", "1.nc", &options).is_err());
    // Behind its end nothing moves.
    assert!(GcodeProgram::parse("G1 X5 F9\nM99\nX6\n", "1.nc", &options).unwrap_err().to_string().contains("end"));
}

#[test]
fn calls_that_move_nothing_stay_as_they_are() {
    let source = "G0 X0 Y0 Z0\nG65 P9810 X100. Y5. (probe)\nM98 P9000 L2\nG1 X5 F9\nM30\n";
    let options = GcodeOptions { calls_kept: vec![9810, 9000], ..Default::default() };
    let program = GcodeProgram::parse(source, "part.nc", &options).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    assert_eq!(path.points()[path.len() - 1].position_mm, Vector3::new(5.0, 0.0, 0.0));
    assert_eq!(
        program
            .rewrite(&path, &path.positions_mm(), WriteOptions::with_decimals(program.own_format()))
            .unwrap()
            .bytes(),
        source.as_bytes()
    );
    let written_out = GcodeProgram::parse_expanded(source, "part.nc", &options, &|_| None).unwrap();
    assert!(String::from_utf8_lossy(written_out.source()).contains("G65 P9810 X100. Y5. (probe)\nM98 P9000 L2\n"));
    let refused = refusal(source);
    assert!(
        refused.contains("subprogram 9810 is neither in the file nor beside it")
            && refused.contains("or 9810 in calls_kept of [gcode]"),
        "{refused}"
    );
    // One that moves beside the call is no line that moves nothing.
    assert!(GcodeProgram::parse("G0 X0 Y0 Z0\nG1 X5 F9 M98 P9000\n", "part.nc", &options).is_err());
}

#[test]
fn programs_of_okuma_are_refused_by_their_name() {
    for first in ["$FLANGE.MIN%", " $A1.ssb% "] {
        let source = format!("{first}\n(PART)\nLEN=20\nG0 X0 Y0 Z0\nG1 XLEN F9\n");
        let refused = GcodeProgram::parse(source, "flange.nc", &GcodeOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("a program of Okuma's OSP control"), "{refused}");
    }
    // Grbl's settings begin with the same sign.
    assert!(GcodeProgram::parse("$H\nG0 X0 Y0 Z0\n", "grbl.nc", &GcodeOptions::default()).is_ok());
}

#[test]
fn comments_in_comments_are_refused_by_what_they_are() {
    let refused = refusal("G0 X0 Y0 Z0\nG1 X5 F9 (a (b) c)\n");
    assert!(refused.contains("comment within a comment"), "{refused}");
    assert!(expanded("G0 X0 Y0 Z0\nG1 X5 F9 (a (b))\n").is_ok());
}
