//! A program of several parts: its points answer as if all of it were held at once, to the last bit.

use kinetostat::{
    compensation::{Method, Session, TaskPoint, simulate},
    input::Folder,
    machine::Machine,
    process::file::Process,
    products::program::{CompensateOptions, CorrectedPath, ProgramCommands, ProgramJob},
    simulation::{
        Source,
        along_path::{Commands, PathCase, PathPointResult, run},
        settings,
    },
    spatial::Wrench,
    toolpath::{ProgramFile, WriteOptions},
    work::Work,
};
use nalgebra::Vector3;

const PROCESS: &str = r#"
schema = 1

[placement]
reference = "platform_point"

[force.path_frame]
radial_force_N = 215.0
tangential_force_N = -10.0
axial_force_N = -25.0

[[chain_error]]
chain = "x"
turn_about_drive_axis_deg = 1.0
"#;

/// A wave of so many short lines.
fn wave(lines: usize) -> String {
    let line = |k: usize| {
        let x = k as f64 * 0.01;
        format!("G1 X{x:.3} Y{:.3} Z{:.3}\n", 5.0 * (x / 7.0).sin(), (x / 3.0).cos())
    };
    (1..=lines).fold("G21 G90\nG0 X0 Y0 Z1\nF600\n".to_string(), |program, k| program + &line(k))
}

fn parsed(source: String, name: &str, process: &Process) -> ProgramFile {
    let folder = Folder::in_memory([(name.into(), source.into_bytes())]);
    process.program_in_folder(&folder, name).unwrap()
}

fn job(lines: usize) -> ProgramJob {
    let machine = Machine::named("orthoglide").unwrap();
    let process = Process::from_toml(PROCESS, "process", Folder::in_memory([]), &machine).unwrap();
    let program = parsed(wave(lines), "wave.nc", &process);
    ProgramJob::new(process, program, "wave.nc", &Work::default()).unwrap()
}

/// More than one part of 4096 points, the last block not full.
const LINES: usize = 4200;

#[test]
fn parts_answer_as_the_whole_does() {
    let job = job(LINES);
    let mut tasks = Vec::new();
    for part in job.parts() {
        let part = part.unwrap();
        assert_eq!((part.first, part.points.len()), (tasks.len(), part.tasks().len()));
        tasks.extend_from_slice(part.tasks());
    }
    assert_eq!(tasks.len(), job.path.len());
    assert!(tasks.len() > 4096);
    let case = PathCase {
        nominal: &job.machine,
        actual: &job.machines.actual,
        unloaded: &job.machine,
        before: None,
        tasks: &tasks,
        play: true,
    };
    let nothing_to_tell = || ();
    let mut corrected = CorrectedPath::new(&job);
    let mut answers: Vec<PathPointResult> = Vec::new();
    let own = job.pass_by(Method::Direct, &nothing_to_tell, |part, found| {
        corrected.add(&job, part, found);
        answers.extend_from_slice(found);
        Ok(())
    });
    assert_eq!(own.unwrap().summary.solved, job.path.len() - 1);
    assert!(answers == run(&case, &Commands::Method(Method::Direct), &nothing_to_tell));

    // What is tracked once for all passes of a part is what each would have been tracked to.
    let written = job.write(&corrected).unwrap();
    let (mut before, mut as_written, mut without_force) = (Vec::new(), Vec::new(), Vec::new());
    let asked = CompensateOptions {
        compared: vec![Method::Linear],
        sources_apart: true,
        ..CompensateOptions::by(Method::Direct)
    };
    let verification = job
        .verify("as written".into(), &written, &asked, &Work::default(), |verified| {
            before.extend_from_slice(&verified.before[Source::All]);
            as_written.extend_from_slice(&verified.written);
            without_force.extend_from_slice(&verified.without_force);
            Ok(())
        })
        .unwrap();
    let alone = run(&case, &Commands::Method(Method::None), &nothing_to_tell);
    assert!(before.iter().eq(&alone.iter().map(PathPointResult::solved_error).collect::<Vec<_>>()));
    let mut read_back = Vec::new();
    let pass = job.pass("as written", &ProgramCommands::CommandedPath(&written.sent), &nothing_to_tell, |_, found| {
        read_back.extend_from_slice(found);
        Ok(())
    });
    assert!(as_written == read_back);
    // Point by point, of a session that begins anew at each: where the written program leads the unloaded machine.
    let off = |k: usize| {
        let mut session = Session::new(&job.machine, &job.machines.actual, settings());
        let task = TaskPoint { load: Wrench::zero(), ..tasks[k] };
        simulate(&mut session, &task, as_written[k].target.as_ref().unwrap()).position_error
    };
    for k in (0..job.path.len()).step_by(97) {
        let (found, expected) = (without_force[k].unwrap(), off(k));
        assert!((found - expected).norm() < 1e-8, "{k}: {found} instead of {expected}");
    }
    let (_, most) = verification.without_force.most.unwrap();
    let largest = (0..job.path.len()).filter(|k| job.is_counted(*k) && tasks[*k].load != Wrench::zero());
    let largest = largest.map(|k| without_force[k].unwrap().norm()).fold(0.0, f64::max);
    assert!(most == largest && largest > 0.2 && verification.without_force.unknown == 0, "{most}: {largest}");
    let [_, by_linear, verified] = &verification.passes[..] else { panic!("{verification:?}") };
    assert_eq!(verified.summary, pass.unwrap().summary);
    let linear = job.pass_by(Method::Linear, &nothing_to_tell, |_, _| Ok(())).unwrap();
    assert_eq!(by_linear.summary, linear.summary);
    let rounding = verified.summary.max_mm.unwrap();
    assert!(rounding < 2e-3, "{rounding}");
}

#[test]
fn a_program_is_held_as_its_bytes() {
    let program = wave(LINES);
    let ProgramFile::Gcode(read) = job(LINES).file else { panic!("no G-code") };
    assert_eq!(read.motion_count(), LINES + 1);
    assert_eq!((read.line_of(0), read.line_of(LINES)), (Some(2), Some(LINES + 3)));
    let path = read.toolpath(Default::default()).unwrap();
    let writing = WriteOptions::with_decimals(read.own_format());
    let same = read.rewrite(&path, &path.positions_mm(), writing).unwrap();
    assert_eq!(same.bytes(), program.as_bytes());
    let raised: Vec<Vector3<f64>> = path.positions_mm().iter().map(|p| p + Vector3::z()).collect();
    let back = read.rewrite(&path, &raised, writing).unwrap().read_back().unwrap().positions_mm();
    assert_eq!(back.len(), raised.len());
    assert!(back.iter().zip(&raised).all(|(back, raised)| (back - raised).norm() < 1e-3));
}

#[test]
fn a_program_too_long_to_be_corrected_at_once_is_refused() {
    // Each of the lines is split into pieces of 0.1 mm.
    let source = "G21 G90\nG0 X0 Y0 Z0\n".to_string() + &"G1 X50\nG1 X0\n".repeat(250);
    let machine = Machine::named("orthoglide").unwrap();
    let text = format!("{PROCESS}\n[sampling]\nmax_segment_mm = 0.1\n");
    let process = Process::from_toml(&text, "process", Folder::in_memory([]), &machine).unwrap();
    let program = parsed(source, "long.nc", &process);
    let job = ProgramJob::new(process, program, "long.nc", &Work::default()).unwrap();
    assert_eq!(job.path.len(), 250_001);
    let refused = job.bounded_pass(&Work::default(), |_, _| Ok(())).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "--method: bounded corrects the whole path at once: 250001 points, expected at most 200000; a coarser [sampling] or \
         a part of the program has fewer"
    );
}
