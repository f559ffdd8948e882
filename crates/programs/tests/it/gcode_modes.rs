//! Modes that M70 and M73 keep and M72 or the end of a subprogram restores.

use kinetostat_programs::{
    Sampling, Toolpath, WriteOptions,
    gcode::{Calls, Dialect, GcodeError, GcodeOptions, GcodeProgram},
};
use nalgebra::Vector3;
use proptest::prelude::*;

use crate::support::cases::cases;
use crate::support::rs274;

fn path(program: &GcodeProgram) -> Toolpath {
    program.toolpath(Sampling::new(0.05, 1e6).unwrap()).unwrap()
}

fn of_linuxcnc() -> GcodeOptions {
    GcodeOptions { dialect: Some(Dialect::LinuxCnc), ..GcodeOptions::default() }
}

fn ends(source: &str) -> Vec<[f64; 3]> {
    let program =
        GcodeProgram::parse(source, "part.nc", &GcodeOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    path(&program).points().iter().map(|point| point.position_mm.into()).collect()
}

fn with_calls(source: &str, options: &GcodeOptions) -> Result<GcodeProgram, GcodeError> {
    GcodeProgram::parse_with_calls(source, "part.nc", options, &|_| None)
}

#[test]
fn m72_restores_what_m70_kept_but_the_motion() {
    let source = "G21 G90 G17 F100\nG0 X0 Y0 Z0\nG1 X10\nM70\nG91 G20 G18 G93\nG1 X1 F2\nM72\nX20\nG0\nM70\nG91\nG1 X1\nM72\nY10\nM2\n";
    let program = GcodeProgram::parse(source, "part.nc", &GcodeOptions::default()).unwrap();
    let at =
        [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [35.4, 0.0, 0.0], [20.0, 0.0, 0.0], [21.0, 0.0, 0.0], [21.0, 10.0, 0.0]];
    assert_eq!(ends(source), at);
    let path = path(&program);
    let feeds: Vec<_> = path.points().iter().map(|point| point.feed_mm_per_min.map(f64::round)).collect();
    assert_eq!(feeds, [None, Some(100.0), Some(51.0), Some(100.0), Some(100.0), Some(100.0)]);
    // The control reads the words that stay as they are in the same way.
    let moved: Vec<_> = path.positions_mm().iter().map(|p| p + Vector3::new(0.25, 0.5, 0.01 * p.x)).collect();
    let back = program.rewrite(&path, &moved, WriteOptions::default()).unwrap().read_back().unwrap();
    assert!(back.positions_mm().iter().zip(&moved).all(|(a, b)| (a - b).amax() < 2e-3));
}

#[test]
fn m72_goes_back_to_the_work_offset_and_m71_forgets() {
    let options = GcodeOptions {
        work_offsets_mm: [("G55".parse().unwrap(), Vector3::new(100.0, 0.0, 0.0))].into(),
        ..GcodeOptions::default()
    };
    let program = GcodeProgram::parse("G0 X0 Y0 Z0\nM70\nG55 X0\nM72\nX1\n", "part.nc", &options).unwrap();
    let x: Vec<f64> = path(&program).points().iter().map(|point| point.position_mm.x).collect();
    assert_eq!(x, [0.0, 100.0, 1.0]);
    let refused = |source: &str| GcodeProgram::parse(source, "part.nc", &options).unwrap_err().to_string();
    for source in ["G0 X0 Y0 Z0\nM72\n", "M70\nM71\nM72\n"] {
        assert!(refused(source).ends_with(
            "`M72`: restores modes where none are kept; expected M70 or M73 before it, in the same program or subprogram"
        ));
    }
    // LinuxCNC makes no motion of a line with M72.
    assert_eq!(
        refused("M70\nM72 G1 X7\n"),
        "part.nc:2:5: `G1`: on a line with M72, which keeps or restores modes; expected M72 on a line of its own"
    );
    assert!(refused("M70 F100\n").contains("on a line with M70"));
    assert_eq!(ends("G0 X5 Y0 Z0\nM70 G91\nX1\nM72\nX1\n").last(), Some(&[1.0, 0.0, 0.0]));
    // They are functions of the machine elsewhere.
    for dialect in [Dialect::Fanuc, Dialect::Haas] {
        let options = GcodeOptions { dialect: Some(dialect), ..GcodeOptions::default() };
        let program = GcodeProgram::parse("G0 X5 Y0 Z0\nM70\nG91\nX1\nM72\nX1\n", "part.nc", &options).unwrap();
        assert_eq!(path(&program).points().last().unwrap().position_mm.x, 7.0);
    }
}

#[test]
fn m73_restores_at_the_end_of_its_subprogram_and_what_is_written_out_says_it_in_words() {
    let source = "o100 sub\nM73\nG91 G20\nG1 X1 F10\nM5\no100 endsub\nG21 G90 G17 F100 M3 S900 M8\nG0 X0 Y0 Z0\nG1 X1\no100 call\nG1 X20\n\
                  G1 Y10\nM2\n";
    let program = GcodeProgram::parse_expanded(source, "part.nc", &GcodeOptions::default(), &|_| None).unwrap();
    let text = String::from_utf8(program.source().to_vec()).unwrap();
    let (_, lines) = text.split_once('\n').unwrap();
    assert_eq!(
        lines,
        "G21 G90 G17 F100 M3 S900 M8\nG0 X0 Y0 Z0\nG1 X1\nG91 G20\nG1 X1 F10\nM5\nG21\nG90 M3 F100\nG1 X20\nG1 Y10\nM2\n"
    );
    let x: Vec<f64> = path(&program).points().iter().map(|point| point.position_mm.x).collect();
    assert_eq!(x, [0.0, 1.0, 26.4, 20.0, 20.0]);
    // Calls stay, and with them the words of the subprogram.
    let program = with_calls(source, &GcodeOptions::default()).unwrap();
    let path = path(&program);
    let moved: Vec<_> = path.positions_mm().iter().map(|p| p + Vector3::new(0.0, 0.0, 0.25)).collect();
    let Some(Calls::Stay { program: written, .. }) =
        program.folded_calls(&program.rewrite(&path, &moved, WriteOptions::default()).unwrap())
    else {
        panic!()
    };
    let written = String::from_utf8(written).unwrap();
    assert!(written.starts_with("o100 sub\nM73\nG91 G20\nG1 X1") && written.contains("o100 endsub\n"), "{written}");
}

/// G43.1 sets lengths beside or without G43; a length is written in the unit that is in force again.
#[test]
fn lengths_of_tools_that_g43_1_has_set_are_restored() {
    let written = |begin: &str, within: &str| {
        let source = format!(
            "o100 sub\nM73\n{within}\nG1 X1\no100 endsub\nG21 G90 F100\n{begin}\nG0 X0 Y0 Z0\no100 call\nG1 X20\nM2\n"
        );
        let program = GcodeProgram::parse_expanded(source.as_str(), "part.nc", &of_linuxcnc(), &|_| None).unwrap();
        let text = String::from_utf8(program.source().to_vec()).unwrap();
        let (_, behind) = text.split_once("G1 X1\n").unwrap();
        behind.strip_suffix("G1 X20\nM2\n").unwrap().to_owned()
    };
    assert_eq!(written("G43.1 Z3", "G49"), "G49\nG43.1 Z3\n");
    assert_eq!(written("G43 H1", "G43.1 X2 Z3"), "G43 H1\n");
    assert_eq!(written("G43 H1\nG43.1 X2\nG43.1 Z3", "G43.1 Z4"), "G43 H1\nG43.1 X2 Z3\n");
    assert_eq!(written("G20\nG43.1 Z1\nG21", "G20 G49"), "G21\nG49 F100\nG43.1 Z25.4\n");
    assert_eq!(written("G43.1 Z3", "G91"), "G90\n");
}

/// As rs274 of LinuxCNC says of it.
#[test]
fn m70_behind_m73_says_to_what_the_end_restores_and_m71_that_it_does_not() {
    let last = |body: &str| {
        let source = format!("o100 sub\n{body}\no100 endsub\nG21 G90 F100\nG0 X0 Y0 Z0\no100 call\nG1 X1\nG1 X1\nM2\n");
        let program = with_calls(&source, &GcodeOptions::default()).unwrap();
        path(&program).points().last().unwrap().position_mm.x
    };
    assert_eq!(last("M73\nG91"), 1.0);
    assert_eq!(last("M73\nG91\nM70\nG90"), 2.0);
    assert_eq!(last("M73\nM70 G91"), 1.0);
    assert_eq!(last("M73\nG91\nM71"), 2.0);
    assert_eq!(last("M73\nM71\nM70\nG91"), 1.0);
    assert_eq!(last("M70\nG91"), 2.0);
}

#[test]
fn whose_m73_it_is_in_a_numbered_subprogram_must_be_said() {
    let source = "G21 G90 F100\nG0 X0 Y0 Z0\nM98 P100\nG1 X20\nM30\nO100\nM73\nG91\nG1 X1\nM99\n";
    let refused = with_calls(source, &GcodeOptions::default()).unwrap_err().to_string();
    assert_eq!(
        refused,
        "part.nc:7:1: `M73`: M73 in a subprogram restores modes at its end on LinuxCNC, and is a function of the machine on Fanuc and Haas; \
         expected dialect = \"fanuc\", \"haas\" or \"linuxcnc\" in [gcode] of the process file (--dialect), which says whose it is"
    );
    for (dialect, x) in [(Dialect::LinuxCnc, 20.0), (Dialect::Haas, 21.0), (Dialect::Fanuc, 21.0)] {
        let program = with_calls(source, &GcodeOptions { dialect: Some(dialect), ..GcodeOptions::default() }).unwrap();
        assert_eq!(path(&program).points().last().unwrap().position_mm.x, x);
    }
}

/// The lines of a program or subprogram in which M72 stands only where something is kept.
fn body(depth: usize) -> impl Strategy<Value = String> {
    let line = prop_oneof![
        4 => (0u8..3, -9i32..9, -9i32..9).prop_map(|(_, x, y)| format!("G1 X{:.2} Y{:.2} F80", f64::from(x) / 4.0, f64::from(y) / 4.0)),
        5 => prop::sample::select(vec!["G90", "G91", "G20", "G21", "G17", "G18", "G54", "G55", "G90 G21", "G91 G20 G55"]).prop_map(str::to_owned),
        1 => (1i32..5).prop_map(|r| format!("G17 G2 X{r} Y0 R{}", 300 + r)),
        2 => prop::sample::select(vec!["M70", "M73", "M70 G91"]).prop_map(str::to_owned),
        1 => Just("M71".to_owned()),
        3 => Just("M72".to_owned()),
        2 => (1u32..3).prop_map(move |times| if depth < 2 { format!("M98 P{} L{times}", 100 * (depth + 1)) } else { "G1 Y1 F80".to_owned() }),
    ];
    prop::collection::vec(line, 3..12).prop_map(|lines| {
        let mut kept = false;
        let mut text = String::new();
        for line in lines {
            kept = (kept || line.starts_with("M70") || line == "M73") && line != "M71";
            if line != "M72" || kept {
                text += &(line + "\n");
            }
        }
        text
    })
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn modes_are_kept_and_restored_as_a_second_reader_says(main in body(0), one in body(1), two in body(2)) {
        let text = format!(
            "G21 G90 G17\nG10 L2 P1 X0 Y0 Z0\nG10 L2 P2 X7 Y-3 Z0\nG0 X0 Y0 Z0\n{main}G1 Z1\nM30\nO100\n{one}M99\nO200\n{two}M99\n"
        );
        let steps: Vec<[f64; 3]> = rs274::read(&text).iter().map(|step| step.at(1.0)).collect();
        prop_assume!(steps.iter().flatten().all(|at| at.abs() < 1e5));
        let none = |_: &str| None;
        let all = GcodeProgram::parse_expanded(text.as_bytes(), "random.nc", &of_linuxcnc(), &none);
        // Arcs by radius may not reach from where modes lead.
        prop_assume!(!matches!(&all, Err(fault) if fault.to_string().contains("cannot reach") || fault.to_string().contains("no definite")));
        for program in [all, with_calls(&text, &of_linuxcnc())] {
            let program = program.map_err(|fault| TestCaseError::fail(format!("{fault}\n{text}")))?;
            let path = path(&program);
            let found: Vec<_> = path.points().iter().filter(|point| point.source.parameter == 1.0).collect();
            prop_assert_eq!(found.len(), steps.len(), "{}", text);
            for (found, step) in found.iter().zip(&steps) {
                let off = found.position_mm - Vector3::from(*step);
                prop_assert!(off.amax() < 1e-9, "{:?} {step:?}\n{text}", found.position_mm);
            }
            let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
            if let Some(calls) = program.folded_calls(&same) {
                prop_assert_eq!(calls, Calls::Stay { program: text.clone().into_bytes(), beside: Vec::new() });
            }
        }
    }
}
