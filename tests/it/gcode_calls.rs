//! Programs with calls, loops and jumps whose calls stay: what is written of them is run again.

use std::path::Path;

use crate::support::programs::programs_in;
use kinetostat::{
    Folder, Machine, Process,
    input::Inputs,
    process::program_inputs,
    toolpath::{
        Sampling, Toolpath, WriteOptions,
        gcode::{CalledFile, Calls, GcodeOptions, GcodeProgram},
    },
};
use nalgebra::Vector3;

const STEP: &str = "%\nO200 (beside)\nG91 G1 X2 F50\nY1\nG90 M99\n%\n";

fn beside(name: &str) -> Option<Vec<u8>> {
    (name == "O200.nc").then(|| STEP.into())
}

fn read(source: &str) -> GcodeProgram {
    GcodeProgram::parse_with_calls(source, "part.nc", &GcodeOptions::default(), &beside).unwrap()
}

fn path(program: &GcodeProgram) -> Toolpath {
    program.toolpath(Sampling::new(0.1, 2.0).unwrap()).unwrap()
}

/// `source` with its points moved by `by`: what becomes of its calls, and the positions in which its points were written.
fn moved(source: &str, by: impl Fn(usize, Vector3<f64>) -> Vector3<f64>) -> (Calls, Vec<Vector3<f64>>) {
    let program = read(source);
    let path = path(&program);
    let goals: Vec<_> = path.positions_mm().into_iter().enumerate().map(|(k, p)| p + by(k, p)).collect();
    let rewritten = program.rewrite(&path, &goals, WriteOptions::default()).unwrap();
    (program.folded_calls(&rewritten).unwrap(), rewritten.read_back().unwrap().positions_mm())
}

fn stays(calls: Calls) -> (String, Vec<CalledFile>) {
    match calls {
        Calls::Stay { program, beside } => (String::from_utf8(program).unwrap(), beside),
        Calls::WrittenOut(differs) => panic!("{differs}"),
    }
}

fn written_out(calls: Calls) -> String {
    match calls {
        Calls::Stay { program, .. } => panic!("{}", String::from_utf8_lossy(&program)),
        Calls::WrittenOut(differs) => differs.to_string(),
    }
}

/// Every tenth of a millimetre on the way, and the ends of the moves of a program that is run with these files.
fn ends(program: &str, beside: &[CalledFile]) -> Vec<Vector3<f64>> {
    let bytes = |name: &str| beside.iter().find(|file| file.name == name).map(|file| file.bytes.clone());
    let program = GcodeProgram::parse_expanded(program, "part.nc", &GcodeOptions::default(), &bytes).unwrap();
    let path = path(&program);
    path.points().iter().filter(|point| point.source.parameter == 1.0).map(|point| point.position_mm).collect()
}

#[test]
fn without_corrections_the_files_are_the_same() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/programs/tests/gcode_expanded");
    let beside = |name: &str| std::fs::read(folder.join(name)).ok();
    let programs = programs_in("crates/programs/tests/gcode_expanded/expected");
    assert!(programs.len() >= 12, "{} programs", programs.len());
    for (name, _) in programs {
        let source = beside(&name).unwrap();
        let program =
            GcodeProgram::parse_with_calls(source.as_slice(), &name, &GcodeOptions::default(), &beside).unwrap();
        let path = path(&program);
        let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
        let (written, files) = stays(program.folded_calls(&same).unwrap());
        assert_eq!(written, String::from_utf8(source).unwrap(), "{name}");
        for file in files {
            assert_eq!(Some(file.bytes), beside(&file.name), "{name}: {}", file.name);
        }
    }
}

const TWICE: &str = "O1\nG21 G90\nG0 X0 Y0 Z0\nM98 P100 L2\nM98 P200\nG90 G0 X20\nM98 P100\nM30\nO100\nG91 G1 X5 F90 (cut)\nY1\n\
                     G90 M99\n";

#[test]
fn corrections_that_are_the_same_at_each_call_are_written_once() {
    let shift = Vector3::new(0.25, -0.125, 0.5);
    let (calls, _) = moved(TWICE, |_, _| shift);
    let (program, files) = stays(calls);
    assert_eq!(program, TWICE.replace("X0 Y0 Z0", "X0.2500 Y-0.1250 Z0.5000").replace("G0 X20", "G0 X20.2500"));
    assert_eq!(files, [CalledFile { name: "O200.nc".into(), bytes: STEP.into() }]);
    let expected = ends(TWICE, &[CalledFile { name: "O200.nc".into(), bytes: STEP.into() }]);
    for (end, expected) in ends(&program, &files).iter().zip(expected) {
        assert!((end - expected - shift).amax() < 1e-9, "{end} {expected}");
    }
}

#[test]
fn the_lines_of_subprograms_are_corrected_where_they_stand() {
    // At one place, as often as it is called; the subprogram beside as well.
    let source = "O1\nG21 G90\nG0 X0 Y0 Z0\nM98 P100 L2\nM98 P200\nX0 Y0\nM98 P100\nM30\nO100\nG90 G0 X0 Y0\nG1 X5 F90 (cut)\nX10 Y5 M99\n";
    let bow = |_: usize, p: Vector3<f64>| Vector3::new(0.0, 0.01 * p.x, 0.02 * p.y);
    let (calls, back) = moved(source, bow);
    let (program, files) = stays(calls);
    assert!(
        program.ends_with("O100\nG90 G0 X0 Y0 Z0.0000\nG1 X5 Y0.0500 Z0.0000 F90 (cut)\nX10 Y5.1000 Z0.1000\nM99\n"),
        "{program}"
    );
    assert_eq!(
        String::from_utf8_lossy(&files[0].bytes),
        STEP.replace("X2 ", "X2 Y0.0200 ").replace("Y1\n", "Y1 Z0.0200\n")
    );
    let sent = ends(&program, &files);
    assert!(back.len() > sent.len() && sent.iter().all(|end| back.iter().any(|p| (p - end).amax() < 1e-9)));
}

#[test]
fn other_corrections_from_call_to_call_write_the_program_out() {
    let tilt = |_: usize, p: Vector3<f64>| Vector3::new(0.0, 0.0, 1e-4 * p.x * p.x);
    let (calls, _) = moved(TWICE, tilt);
    assert_eq!(written_out(calls), "line 10 runs several times, each with other corrections");
    let beside_twice = "O1\nG21 G90\nG0 X0 Y0 Z0\nM98 P200\nG0 X20\nM98 P200\nM30\n";
    assert_eq!(
        written_out(moved(beside_twice, tilt).0),
        "O200.nc line 3 runs several times, each with other corrections"
    );
    let computed = "#1=5\nG21 G90 G0 X0 Y0 Z0\nG1 X#1 F90\nM30\n";
    assert_eq!(
        written_out(moved(computed, |_, _| Vector3::new(1.0, 0.0, 0.0)).0),
        "line 3 is computed, and cannot be both that and corrected"
    );
    assert_eq!(stays(moved(computed, |_, _| Vector3::new(0.0, 1.0, 0.0)).0).0, computed.replace("Y0", "Y1.0000"));
}

#[test]
fn corrections_that_differ_by_less_than_can_be_written_are_made_the_same() {
    let source = "O1\nG21 G90\nG0 X0 Y0 Z0\nM98 P100 L3\nM30\nO100\nG90 G1 X5 F90\nX0\nM99\n";
    let points = path(&read(source)).len();
    let drift =
        |most: f64| move |k: usize, _| Vector3::new(0.0, 0.01042, 0.0) + Vector3::y() * most * k as f64 / points as f64;
    let (program, _) = stays(moved(source, drift(0.00008)).0);
    assert!(program.ends_with("O100\nG90 G1 X5 Y0.0105 Z0.0000 F90\nX0 Y0.0105 Z0.0000\nM99\n"), "{program}");
    assert!(program.contains("X0 Y0.0104 Z0"), "{program}");
    written_out(moved(source, drift(0.005)).0);
}

#[test]
fn what_was_to_be_written_out_is() {
    let options = GcodeOptions::default();
    let program = GcodeProgram::parse_expanded(TWICE, "part.nc", &options, &beside).unwrap();
    let path = path(&program);
    let same = program.rewrite(&path, &path.positions_mm(), WriteOptions::default()).unwrap();
    assert_eq!(program.folded_calls(&same), None);
}

#[test]
fn what_a_program_calls_counts_as_an_input() {
    let orthoglide = Machine::named("orthoglide").unwrap();
    let process = Process::from_toml("schema = 1", "process.toml", Path::new("."), &orthoglide).unwrap();
    let inputs = |sub: &str| {
        let files = [("part.nc", "O1\nG0 X0 Y0 Z0\nM98 P100\nM30\n"), ("O100.nc", sub)];
        let folder = Folder::in_memory(files.map(|(name, text)| (name.into(), text.into())));
        program_inputs(&process.program_in_folder(&folder, "part.nc").unwrap(), "part.nc")
    };
    let texts = |inputs: &Inputs| inputs.texts().map(|(_, text)| text.to_owned()).collect::<Vec<_>>();
    let (five, six) = (inputs("O100\nG1 X5\nM99\n"), inputs("O100\nG1 X6\nM99\n"));
    assert_eq!(texts(&five)[0], "O1\nG0 X0 Y0 Z0\nM98 P100\nM30\n");
    assert!(texts(&five)[1].ends_with("G0 X0 Y0 Z0\nG1 X5\nM30\n"), "{:?}", texts(&five));
    assert_eq!(texts(&five)[0], texts(&six)[0]);
    assert_ne!(five, six);
}
