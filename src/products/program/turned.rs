//! A program whose γ, the rotation about the tool axis, is sought before it is compensated.

use crate::{
    input::error::{Error, Result},
    process::file::Process,
    redundancy::{FoundGamma, TurnAsked, seek},
    simulation::{ProgramFile, external_axes::locked_along},
    toolpath::{
        NumberFormat, Toolpath,
        polyline::{self, Polyline},
    },
    work::Work,
};

/// Pieces of a path that is split once more are longer than the longest by at most this share: rounding of written positions.
const ROUNDING: f64 = 1e-6;

/// Seeks γ along `program`, called `name` in errors, as `process` says. Returned are the process, its machine on the branch that was
/// found; the program, which says how the platform stands (a polyline with a row for each point, or the program of a robot with other
/// orientations); and what was found.
///
/// # Errors
/// A format that cannot say how the platform stands, a machine that cannot rotate about its tool, no γ that is possible all along, and
/// those of `work`.
pub(super) fn turned(
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
    let path = process.with_cuts(program.toolpath(process.sampling)?, name)?;
    let machine = locked_along(&process.machine, &path, name)?;
    let loads = process.loads(&path).map_err(|source| fault(source.to_string()))?;
    let asked = TurnAsked {
        machine: &machine,
        errors: &process.errors,
        placement: &process.placement,
        target: process.target,
        path: &path,
        loads: &loads,
        turn: &process.redundancy,
    };
    let found = seek(asked, work)?;
    let turned = match found.chosen(process.redundancy.gamma) {
        Some(Ok(turned)) => turned,
        Some(Err(dead_end)) => {
            return Err(fault(format!("no rotation about the tool axis is possible all along; {}", dead_end.reason())));
        }
        None => return Err(fault("is to stand as programmed".into())),
    };
    let mut process = Process { machine: turned.machine.clone(), ..process.clone() };
    let file = match program {
        #[cfg(not(target_family = "wasm"))]
        ProgramFile::Robot(own) => {
            let orientations: Vec<_> = turned.path.points().iter().filter_map(|point| point.orientation).collect();
            let writing = process.writing(own.own_format())?;
            let rewritten = own.rewrite(&path, &path.positions_mm(), Some(&orientations), writing)?;
            ProgramFile::Robot(Box::new(rewritten.read()?))
        }
        _ => {
            process.sampling = process.sampling.of_points(ROUNDING);
            as_points(&turned.path, program, &mut process, name)?
        }
    };
    Ok((process, file, Some(found)))
}

/// The polyline `program` with a row for each point of `path`, which says how the platform stands there.
fn as_points(path: &Toolpath, program: &ProgramFile, process: &mut Process, name: &str) -> Result<ProgramFile> {
    if let ProgramFile::Polyline(own) = program {
        process.decimals.mm = process.decimals.mm.or(Some(own.own_format().mm_decimals()));
    }
    let format = NumberFormat::new(NumberFormat::MAX_DECIMALS, NumberFormat::MAX_DECIMALS)?;
    let bytes = polyline::write(path, &path.positions_mm(), format)?;
    Ok(ProgramFile::Polyline(Polyline::read(bytes, name)?))
}
