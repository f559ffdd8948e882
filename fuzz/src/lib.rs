//! What the fuzz targets do with an input. `tests/it/fuzz_corpus.rs` does the same with every saved one.
//!
//! An input is either accepted, and what follows from it is finite or a status with a reason, or refused by a message
//! that names the file. Nothing is written, and no more than one point is computed.

use std::{path::Path, sync::LazyLock};

use kinetostat::{
    compensation::{Compensation, CompensationSettings, Method, Session, TaskPoint, compensate},
    input::error::Error,
    inspect::machine_check,
    machine::Machine,
    process::{CutPath, Process},
    questions::{Overrides, Study, StudyKind, map, path::PathStudy, redundancy_map},
    simulation::tasks::tasks,
    toolpath::{
        Circle, Plane, Sampling, Toolpath, TurnDirection, WriteOptions,
        gcode::{Dialect, GcodeOptions, GcodeProgram},
        polyline::Polyline,
        robot::{Language, RobotOptions, RobotProgram},
    },
    work::Work,
};
use nalgebra::Vector3;

/// Name under which an input is read.
const NAME: &str = "fuzz-input";

/// A machine file; an accepted machine is examined.
pub fn machine_file(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    match Machine::from_toml(text, NAME) {
        Ok(machine) => examine(&machine),
        Err(refusal) => named(&refusal.to_string()),
    }
}

/// A process file for the Orthoglide, with what it names in `folder`; an accepted one is applied to a circle.
pub fn process_file(data: &[u8], folder: &Path) {
    static MACHINE: LazyLock<Machine> = LazyLock::new(|| Machine::named_or_file("orthoglide").expect("built in"));
    static CIRCLE: LazyLock<CutPath> = LazyLock::new(|| circle().into());
    let Ok(text) = std::str::from_utf8(data) else { return };
    match Process::from_toml(text, NAME, folder, &MACHINE) {
        Ok(process) => match tasks(&process, &CIRCLE, NAME) {
            Ok(tasks) => tasks.iter().for_each(finite_task),
            Err(refusal) => named(&refusal.to_string()),
        },
        Err(refusal) => all_named(&refusal),
    }
}

/// A study file with what it names in `folder`; one point of an accepted map or path is computed.
pub fn study_file(data: &[u8], folder: &Path) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    match Study::from_toml(text, NAME, folder, &Overrides::default()) {
        Ok(study) => one_point(study.kind),
        Err(refusal) => all_named(&refusal),
    }
}

/// A polyline; an accepted one is written back as it is, byte for byte, and moved.
pub fn path_csv(data: &[u8]) {
    let polyline = match Polyline::read(data, NAME) {
        Ok(polyline) => polyline,
        Err(refusal) => return named(&refusal.to_string()),
    };
    let path = polyline.toolpath();
    finite_path(path);
    assert!((0..path.len()).all(|row| polyline.line_of(row).is_some()));
    let format = polyline.own_format();
    let same = polyline.rewrite(&path.positions_mm(), format).expect("its own positions");
    assert!(same == data, "rewritten without correction, it is another file");
    let moved = moved(path);
    let Ok(bytes) = polyline.rewrite(&moved, format) else { return beyond_the_end(&moved) };
    let back = Polyline::read(bytes, NAME).expect("a written file reads back");
    near(&back.toolpath().positions_mm(), &moved, 10f64.powi(-i32::from(format.mm_decimals())));
}

/// A program in ISO code.
pub fn gcode(data: &[u8]) {
    program(data, Dialect::Iso);
}

/// A program of Sinumerik.
pub fn sinumerik(data: &[u8]) {
    program(data, Dialect::Sinumerik);
}

/// A program of Heidenhain.
pub fn heidenhain(data: &[u8]) {
    program(data, Dialect::Heidenhain);
}

/// A program; an accepted one is written back as it is, byte for byte, and moved.
fn program(data: &[u8], dialect: Dialect) {
    let options = GcodeOptions { dialect: Some(dialect), ..GcodeOptions::default() };
    let program = match GcodeProgram::parse(data, NAME, &options) {
        Ok(program) => program,
        Err(refusal) => return named(&refusal.to_string()),
    };
    // Coarse: a point takes 168 bytes, and arcs of 1e6 mm are allowed.
    let sampling = Sampling::new(1.0, 1e6).expect("positive");
    let path = match program.toolpath(sampling) {
        Ok(path) => path,
        Err(refusal) => return named(&refusal.to_string()),
    };
    finite_path(&path);
    let format = program.own_format();
    let same =
        program.rewrite(&path, &path.positions_mm(), WriteOptions::with_decimals(format)).expect("its own positions");
    assert!(same.bytes() == data, "rewritten without correction, it is another program");
    let moved = moved(&path);
    let rewritten = match program.rewrite(&path, &moved, WriteOptions::with_decimals(format)) {
        Ok(rewritten) => rewritten,
        // A word that moves with the tool, where its line is split.
        Err(refused) if refused.to_string().contains("an axis that moves with the tool") => {
            return named(&refused.to_string());
        }
        Err(_) => return beyond_the_end(&moved),
    };
    // A program near the end of the range may be moved out of it by rounding or by its work offset.
    let read = rewritten.read_back();
    if let Ok(back) = &read {
        let last_place = 10f64.powi(-i32::from(format.mm_decimals()));
        near(&back.positions_mm(), &moved, last_place.max(25.4 * 10f64.powi(-i32::from(format.inch_decimals()))));
    } else {
        assert!(
            moved.iter().any(|position| position.amax() > 0.9e6),
            "the moved program does not read back: {}",
            read.unwrap_err()
        );
    }
}

/// A program in KRL.
pub fn krl(data: &[u8]) {
    poses(data, Language::Krl);
}

/// A program in RAPID.
pub fn rapid(data: &[u8]) {
    poses(data, Language::Rapid);
}

/// A program in APT.
pub fn apt(data: &[u8]) {
    poses(data, Language::Apt);
}

/// A program of poses; an accepted one is written back as it is, byte for byte, and moved.
fn poses(data: &[u8], language: Language) {
    let program = match RobotProgram::parse(data, NAME, language, None, &RobotOptions::default()) {
        Ok(program) => program,
        Err(refusal) => return named(&refusal.to_string()),
    };
    let sampling = Sampling::new(1.0, 1e6).and_then(|sampling| sampling.with_max_turn(1.0)).expect("positive");
    let path = match program.toolpath(sampling) {
        Ok(path) => path,
        Err(refusal) => return named(&refusal.to_string()),
    };
    finite_path(&path);
    let format = program.own_format();
    let same = program
        .rewrite(&path, &path.positions_mm(), None, WriteOptions::with_decimals(format))
        .expect("its own positions");
    assert!(same.bytes() == data, "rewritten without correction, it is another program");
    let moved = moved(&path);
    let Ok(rewritten) = program.rewrite(&path, &moved, None, WriteOptions::with_decimals(format)) else {
        // The end of a circle that goes to an angle is named, and moved, but not gone to.
        let text = String::from_utf8_lossy(data);
        let mut words = text.split(|c: char| !c.is_ascii_digit() && !matches!(c, '+' | '-' | '.' | 'e' | 'E'));
        let names_end = words.any(|word| word.parse::<f64>().is_ok_and(|value| value.abs() > END_MM));
        if !names_end {
            beyond_the_end(&moved);
        }
        return;
    };
    // A program near the end of the range may be moved out of it by rounding or by its base.
    let read = rewritten.read_back();
    if let Ok(back) = &read {
        let last_place = 10f64.powi(-i32::from(format.mm_decimals()));
        near(&back.positions_mm(), &moved, 2.0 * last_place.max(25.4 * 10f64.powi(-i32::from(format.inch_decimals()))));
    } else {
        assert!(
            moved.iter().any(|position| position.amax() > 0.9e6),
            "the moved program does not read back: {}",
            read.unwrap_err()
        );
    }
}

/// As [`named`], each of several errors of one cause.
fn all_named(refusal: &Error) {
    match refusal {
        Error::Several { errors, .. } => errors.iter().for_each(all_named),
        alone => named(&alone.to_string()),
    }
}

/// A refusal begins with the file it is about, the input or an absolute path.
fn named(message: &str) {
    assert!(message.starts_with(NAME) || message.starts_with('/'), "names no file: {message}");
}

fn examine(machine: &Machine) {
    // A mesh that is not there.
    let Ok(findings) = machine_check::check(machine) else { return };
    assert!(findings.round_trip.0.is_finite() && findings.round_trip.1.is_finite(), "{:?}", findings.round_trip);
    assert!(findings.home_drives.iter().all(|rho| rho.is_finite()));
    let stiffness = findings.stiffness.iter().flat_map(|matrix| matrix.iter()).all(|entry| entry.is_finite());
    let tool = findings.tool_stiffness.iter().flatten().all(|entry| !entry.is_nan());
    let shares = findings.compliance_shares.iter().all(|(_, share)| share.is_finite());
    assert!(stiffness && tool && shares, "{findings:?}");
}

fn one_point(kind: StudyKind) {
    match kind {
        StudyKind::WorkspaceMap(mut map, _) => {
            map.grid.axes.iter_mut().for_each(|axis| axis.truncate(1));
            map.load_case.phis.truncate(1);
            for (_, effect) in map::run(&map, &Work::default()).expect("nothing stops it").points[0].effects.iter() {
                match effect {
                    Ok(effect) => {
                        let numbers = effect.delta_rho.iter().flatten().chain(&effect.drive_force);
                        let all = numbers.chain([&effect.deflection_mm]).all(|number| number.is_finite());
                        assert!(all && effect.principal_stiffness_n_per_mm.iter().all(|k| !k.is_nan()), "{effect:?}");
                    }
                    Err(failure) => assert!(!failure.reason.is_empty()),
                }
            }
        }
        StudyKind::Online(study, ()) => first_point(&study.path),
        StudyKind::RedundancyMap(mut map, _) => {
            map.grid.axes.iter_mut().for_each(|axis| axis.truncate(1));
            map.load_case.phis.truncate(1);
            map.axes.truncate(1);
            map.settings.step_deg = map.settings.step_deg.max(90.0);
            if let Ok(found) = redundancy_map::run(&map, &Work::default()) {
                let finite = |gammas: &redundancy_map::GammaExtremes| {
                    gammas.best.deflection_mm.is_finite() && gammas.worst.deflection_mm.is_finite()
                };
                assert!(found.points[0].gammas.as_ref().map_or_else(|failure| !failure.reason.is_empty(), finite));
            }
        }
        StudyKind::Path(path, _) => first_point(&path),
        // The others have no single point that is quickly computed.
        _ => {}
    }
}

fn first_point(path: &PathStudy) {
    path.tasks.iter().for_each(finite_task);
    let actual = path.machine.with_errors(&path.errors);
    let mut session = Session::new(&path.machine, &actual, CompensationSettings::default());
    if let Some(task) = path.tasks.first() {
        finite_answer(&compensate(&mut session, task, Method::Direct), &path.machine);
    }
}

fn finite_answer(done: &Compensation, machine: &Machine) {
    if !done.status.is_success() {
        return assert!(!done.status.reason(machine).is_empty());
    }
    let mut numbers = done.drives.iter().chain(&done.drive_forces).chain(done.position_error.iter());
    assert!(numbers.all(|number| number.is_finite()) && done.task_error().is_finite(), "{done:?}");
}

fn finite_task(task: &TaskPoint) {
    let mut numbers = task.pose.translation.iter().chain(task.load.force.iter()).chain(task.load.moment.iter());
    assert!(numbers.all(|number| number.is_finite()), "{task:?}");
}

fn finite_path(path: &Toolpath) {
    for point in path.points() {
        let vectors = [point.position_mm, point.tangent];
        let load = point.load.iter().flat_map(|load| [load.force_N, load.moment_Nmm]);
        let scalars = [point.feed_mm_per_min, point.spindle_rev_per_min].into_iter().flatten();
        assert!(vectors.into_iter().chain(load).all(|v| v.iter().all(|c| c.is_finite())), "{point:?}");
        assert!(scalars.chain([point.arc_length_mm]).all(f64::is_finite), "{point:?}");
    }
}

/// The points of `path`, each with another correction of up to 1 mm.
fn moved(path: &Toolpath) -> Vec<Vector3<f64>> {
    let shift = |k: usize| Vector3::new((k as f64).sin(), (2.0 * k as f64).cos(), 0.3);
    path.positions_mm().into_iter().enumerate().map(|(k, position)| position + shift(k)).collect()
}

/// From here on coordinates may end: what is written lies beyond positions by a deviation of sampling, 1 mm, and a move.
const END_MM: f64 = 1e6 - 3.0;

/// Positions are refused only where coordinates end.
fn beyond_the_end(positions: &[Vector3<f64>]) {
    assert!(positions.iter().any(|position| position.amax() > END_MM), "positions refused for no reason");
}

fn near(found: &[Vector3<f64>], wanted: &[Vector3<f64>], last_place: f64) {
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.iter().zip(wanted) {
        // 1e6 mm are known to 1e-10.
        let off = (found - wanted).amax();
        assert!(off <= 1.5 * last_place + 1e-9, "{found:?} instead of {wanted:?}, last place {last_place}");
    }
}

fn circle() -> Toolpath {
    let circle = Circle {
        centre_mm: Vector3::zeros(),
        diameter_mm: 50.0,
        plane: Plane::Xy,
        turn: TurnDirection::CounterClockwise,
        start_angle_rad: 0.0,
        points: 9,
    };
    circle.toolpath().expect("a circle")
}
