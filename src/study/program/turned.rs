//! A program whose free turn about the tool's axis is sought before it is compensated.

use super::load_fault;
use crate::{
    input::error::{Error, Result},
    process::file::Process,
    study::{
        ProgramFile,
        external_axes::held_along,
        free_turn::{FreeTurn, TurnAsked, seek},
    },
    toolpath::{
        NumberFormat,
        polyline::{self, Polyline},
    },
    work::Work,
};

/// A program as it is turned: what is compensated, and what was found.
#[derive(Debug)]
pub struct TurnedProgram {
    /// The process, its machine on the branch that was found.
    pub process: Process,
    /// The program: a polyline with a row for each point, which says how the platform stands there.
    pub file: ProgramFile,
    /// What was found.
    pub found: FreeTurn,
}

/// Pieces of a path that is split once more are longer than the longest by at most this share: rounding of written positions.
const ROUNDING: f64 = 1e-6;

/// Seeks the turn about the tool's axis along `program`, called `name` in errors, as `process` says.
///
/// # Errors
/// A format that cannot say how the platform stands, a machine that cannot turn its tool freely, no turn that goes all along, and those
/// of `work`.
pub fn turned(process: &Process, program: &ProgramFile, name: &str, work: &Work) -> Result<TurnedProgram> {
    let fault = |problem: String| Error::Argument { argument: name.into(), problem };
    let ProgramFile::Polyline(own) = program else {
        let problem = "its turns about the tool's axis cannot be written: expected a polyline (.csv), whose rows can say how the \
                       platform stands, or --redundancy as_programmed";
        return Err(fault(problem.into()));
    };
    let path = process.with_cuts(program.toolpath(process.sampling)?, name)?;
    let machine = held_along(&process.machine, &path, name)?;
    let loads = process.loads(&path).map_err(|source| load_fault(name, &source))?;
    let asked = TurnAsked {
        machine: &machine,
        errors: &process.errors,
        placement: &process.placement,
        target: process.target,
        path: &path,
        loads: &loads,
        turn: &process.tool_turn,
    };
    let found = seek(asked, work)?;
    let turned = match found.chosen(process.tool_turn.redundancy) {
        Some(Ok(turned)) => turned,
        Some(Err(dead_end)) => {
            return Err(fault(format!("no turn about the tool's axis goes all along; {}", dead_end.reason())));
        }
        None => return Err(fault("is to stand as programmed".into())),
    };
    let format = NumberFormat::new(NumberFormat::MAX_DECIMALS, NumberFormat::MAX_DECIMALS)?;
    let bytes = polyline::write(&turned.path, &turned.path.positions_mm(), format)?;
    let file = ProgramFile::Polyline(Polyline::read(bytes, name)?);
    let mut process = Process { machine: turned.machine.clone(), ..process.clone() };
    process.sampling = process.sampling.of_points(ROUNDING);
    process.decimals.mm = process.decimals.mm.or(Some(own.own_format().mm_decimals()));
    Ok(TurnedProgram { process, file, found })
}
