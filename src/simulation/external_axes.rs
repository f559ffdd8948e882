//! External axes that a path commands, on the machine.

#[cfg(not(target_family = "wasm"))]
use crate::toolpath::robot::RobotProgram;
use crate::{
    compensation::Target,
    input::error::{Error, Result},
    machine::{ExternalAxes, Machine},
    process::file::{Process, ProcessCell},
    toolpath::{PathPoint, ProgramFile, Toolpath},
};

/// How far rounding may put a position beyond its travel, as a share of it, and the resolution of the travel in messages.
const ROUNDING: f64 = 1e-9;

/// Positions of an axis nearer to each other are the same, mm or degrees.
#[cfg(not(target_family = "wasm"))]
const SAME_POSITION: f64 = 1e-3;

/// Returns the machine of `process` with the drives locked that `path` of `program`, called `origin` in errors, commands beside the tool, at the
/// positions of its first point, and at home those that nothing commands, see [`Machine::with_resting_drives`].
///
/// # Errors
/// A column that names no drive, has another unit, names a drive that the study locks or the task needs, or has positions beyond the travel; drives
/// of which nothing says which the path moves; an axis of a robot that has no name and stands elsewhere than the drive that would be it.
pub(crate) fn locked_along(
    process: &Process,
    path: &Toolpath,
    program: Option<&ProgramFile>,
    origin: &str,
) -> Result<Machine> {
    let commanded = commanded_along(&process.machine, path, origin)?;
    let is_oriented = path.is_oriented() || process.target == Target::FullPose;
    let machine = commanded.with_resting_drives(is_oriented).map_err(|why| Error::argument(origin, why.to_string()))?;
    #[cfg(not(target_family = "wasm"))]
    if let Some(ProgramFile::Robot(program)) = program {
        check_unnamed_axes(&machine, program, origin)?;
    }
    Ok(machine)
}

/// Returns `process` with drives locked that `path` of `program`, called `origin` in errors, commands beside the tool, and those that nothing commands at home;
/// its cell has the first tool of `path` among its bodies.
///
/// # Errors
/// A column that names no drive that may be locked so; drives of which nothing says which the path moves.
pub fn with_drives_left(
    process: Process,
    path: &Toolpath,
    program: Option<&ProgramFile>,
    origin: &str,
) -> Result<Process> {
    let process = Process { machine: locked_along(&process, path, program, origin)?, ..process };
    #[cfg(not(target_family = "wasm"))]
    let process = Process { cell: ProcessCell::along(&process, path), ..process };
    Ok(process)
}

/// Checks that axes of a robot program without a name stand where the drives do that nothing commands. An axis at 0 may be none.
#[cfg(not(target_family = "wasm"))]
fn check_unnamed_axes(machine: &Machine, program: &RobotProgram, origin: &str) -> Result<()> {
    let resting: Vec<(String, f64)> = machine.resting_drives().collect();
    let is_told = |value: f64| resting.iter().any(|(_, position)| (position - value).abs() <= SAME_POSITION);
    let other = program.notes().unnamed_axes.iter().find(|(_, value)| *value != 0.0 && !is_told(*value));
    match other.filter(|_| !resting.is_empty()) {
        None => Ok(()),
        Some((axis, value)) => {
            let drives: Vec<String> =
                resting.iter().map(|(label, position)| format!("{label} at {position}")).collect();
            let problem = format!(
                "external axis {axis} stands at {value}, and nothing says which drive of machine {} it is, which has {} as at home: expected \
                 its name in robot_program.external_axes",
                machine.name,
                drives.join(", ")
            );
            Err(Error::argument(origin, problem))
        }
    }
}

/// Returns `machine` with the drives locked that `path` commands beside the tool, as [`locked_along`] does.
fn commanded_along(machine: &Machine, path: &Toolpath, origin: &str) -> Result<Machine> {
    let Some(first) = path.points().first().filter(|_| !path.external_axes().is_empty()) else {
        return Ok(machine.clone());
    };
    let mut positions = Vec::new();
    for (column, value) in path.external_axes().iter().zip(first.external) {
        let drive =
            machine.drive_label(drive_label_in(column)).map_err(|why| fault(origin, column, format!("names {why}")))?;
        if machine.locked_drive_labels().any(|told| told == drive) {
            return Err(fault(
                origin,
                column,
                "is locked by [locked] or --lock, and the path commands it as well: expected one of the two".into(),
            ));
        }
        positions.push((drive, value));
    }
    // A head is commanded, and how the tool stands is no task then.
    let rotary = if path.is_oriented() { Vec::new() } else { machine.rotary_drives().drives };
    let is_of_head = |label: &String| rotary.iter().any(|drive| !drive.carries && drive.label == *label);
    let locked = match positions.iter().any(|(label, _)| is_of_head(label)) {
        true => machine.with_commanded_drives(&positions),
        false => machine.with_locked_drives(&positions),
    };
    let mut locked = locked.map_err(|why| fault(origin, "external axes", why.to_string()))?;
    if locked.external_axis_count() > ExternalAxes::MOST {
        let problem = format!(
            "{} external axes, locked or commanded by the path: expected at most {}",
            locked.external_axis_count(),
            ExternalAxes::MOST
        );
        return Err(fault(origin, "external axes", problem));
    }
    let mut moved = Vec::new();
    for (k, column) in path.external_axes().iter().enumerate() {
        let values = || path.points().iter().map(|point| point.external[k]);
        moved.push((
            positions[k].0.clone(),
            [values().fold(f64::INFINITY, f64::min), values().fold(-f64::INFINITY, f64::max)],
        ));
        let Some((_, axis)) = locked.external_axis(&positions[k].0) else { continue };
        let unit = axis.motion.position_unit();
        if !column.ends_with(&format!("_{unit}")) {
            return Err(fault(
                origin,
                column,
                format!("is a position in {unit}: expected external_{}_{unit}", drive_label_in(column)),
            ));
        }
        let Some((low, high)) = axis.travel else { continue };
        let (low, high) = (axis.motion.to_shown(low), axis.motion.to_shown(high));
        let slack = ROUNDING * low.abs().max(high.abs());
        let is_beyond = |point: &&PathPoint| point.external[k] < low - slack || point.external[k] > high + slack;
        if let Some(point) = path.points().iter().find(is_beyond) {
            let [low, high] = [low, high].map(|end| (end / ROUNDING).round() * ROUNDING);
            let problem = format!(
                "is {} at move {}: expected its travel of {low} to {high} {unit}",
                point.external[k],
                point.source.segment + 1
            );
            return Err(fault(origin, column, problem));
        }
    }
    locked.record_path_axes(moved);
    Ok(locked)
}

/// Returns a function from a point of a path to the positions of the machine's external axes, the columns `names` of the path; `None` if it has none.
pub(crate) fn axes_along(machine: &Machine, names: &[String]) -> impl Fn(&PathPoint) -> Option<ExternalAxes> + use<> {
    let axis = |column: &String| {
        let label = machine.drive_label(drive_label_in(column)).ok()?;
        machine.external_axis(&label).map(|(index, drive)| (index, drive.motion))
    };
    let axes: Vec<_> = names.iter().map(axis).collect();
    let at_home = machine.external_axes();
    move |point| {
        let mut here = at_home;
        for (axis, value) in axes.iter().zip(point.external) {
            let (index, motion) = (*axis)?;
            here.set(index, motion.from_shown(value));
        }
        (!axes.is_empty()).then_some(here)
    }
}

/// Returns the drive label in the name of a column of an external axis.
fn drive_label_in(column: &str) -> &str {
    let name = column.strip_prefix("external_").unwrap_or(column);
    name.rsplit_once('_').map_or(name, |(drive, _)| drive)
}

/// Returns the error of a path with its name, the faulty part and the problem.
fn fault(origin: &str, what: &str, problem: String) -> Error {
    Error::Argument { argument: origin.into(), problem: format!("{what} {problem}") }
}
