//! Seeks γ, the rotation about the tool axis, along a program before it is compensated.

use crate::{
    input::error::{Error, Result},
    process::{CutPath, cutting::PathLoad, file::Process},
    products::program::part::arm_posture,
    redundancy::{FoundGamma, GammaProblem, RotatedPath, search_gamma},
    simulation::{along_path::track_blocks, external_axes::locked_along, tasks::tasks_under, tracking::TrackPoint},
    toolpath::{
        NumberFormat, ProgramFile, Toolpath,
        polyline::{self, Polyline},
    },
    work::Work,
};

/// Relative tolerance for the length of path pieces when the path is split again: rounding of written positions.
const ROUNDING: f64 = 1e-6;

/// Seeks γ along `program`, called `name` in errors, as `process` asks. Returns the process with its machine on the branch found, the program
/// with the orientations found (a polyline with a row per point, or the robot program), and what was found.
///
/// # Errors
/// A format without orientations, a machine that cannot rotate about its tool, no γ possible along the whole path, and those of `work`.
pub(super) fn with_best_gamma(
    process: &Process,
    program: &ProgramFile,
    name: &str,
    work: &Work,
) -> Result<(Process, ProgramFile, Option<FoundGamma>)> {
    let fault = |problem: String| Error::argument(name, problem);
    if matches!(program, ProgramFile::Gcode(_)) {
        let problem = "its rotations about the tool axis cannot be written: expected a polyline (.csv) or a program of a robot, which can \
                       say how the platform stands, or \"as_programmed\" as the redundancy";
        return Err(fault(problem.into()));
    }
    let path = process.mark_cutting(program.toolpath(process.sampling)?, name)?;
    let machine = locked_along(process, &path, Some(program), name)?;
    let loads = process.loads(&path).map_err(|source| fault(source.to_string()))?;
    let problem = GammaProblem {
        machine: &machine,
        errors: &process.errors,
        placement: &process.placement,
        target: process.target,
        path: &path,
        loads: &loads,
        settings: &process.redundancy,
    };
    let found = search_gamma(problem, work)?;
    let turned = match found.result_for(process.redundancy.gamma) {
        Some(Ok(turned)) => turned,
        Some(Err(dead_end)) => {
            return Err(fault(format!("no rotation about the tool axis is possible all along; {}", dead_end.reason())));
        }
        None => return Err(fault("is to stand as programmed".into())),
    };
    let mut process = Process { machine: turned.machine.clone(), ..process.clone() };
    let file = match program {
        ProgramFile::Robot(robot_program) => {
            let orientations: Vec<_> = turned.path.points().iter().filter_map(|point| point.orientation).collect();
            let writing = process.write_options(robot_program.own_format())?;
            let path = with_postures_of(path, turned, &process, &loads, program);
            let rewritten = robot_program.rewrite(&path, &path.positions_mm(), Some(&orientations), writing)?;
            ProgramFile::Robot(Box::new(rewritten.read()?))
        }
        _ => {
            process.sampling = process.sampling.for_sampled_points(ROUNDING);
            as_polyline(&turned.path, program, &mut process, name)?
        }
    };
    Ok((process, file, Some(found)))
}

/// Returns `path` with how the arm stands along it at the γ of `turned`, under `loads`, where `program` says how it stands.
fn with_postures_of(
    path: CutPath,
    turned: &RotatedPath,
    process: &Process,
    loads: &[PathLoad],
    program: &ProgramFile,
) -> CutPath {
    if !program.says_postures() {
        return path;
    }
    let tasks = tasks_under(&turned.machine, &process.placement, process.target, &turned.path, loads);
    let track = track_blocks(&turned.machine, None, &tasks, |_, _| true);
    let posture = |point: &TrackPoint| arm_posture(&turned.machine, &point.at.as_ref()?.drives);
    path.map(|path| path.with_postures(track.iter().flatten().map(posture).collect()))
}

/// Returns a polyline with one row for each point of `path`, including the orientation of the tool.
fn as_polyline(path: &Toolpath, program: &ProgramFile, process: &mut Process, name: &str) -> Result<ProgramFile> {
    if let ProgramFile::Polyline(own) = program {
        process.decimals.mm = process.decimals.mm.or(Some(own.own_format().mm_decimals()));
    }
    let format = NumberFormat::new(NumberFormat::MAX_DECIMALS, NumberFormat::MAX_DECIMALS)?;
    let bytes = polyline::write(path, &path.positions_mm(), format)?;
    Ok(ProgramFile::Polyline(Box::new(Polyline::read(bytes, name)?)))
}
