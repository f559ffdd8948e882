//! Corrects a path within the limits of a process and of the machine.

use crate::{
    compensation::{BoundedPath, BoundedSettings, Limits, TaskPoint, compensate_bounded},
    input::error::{Error, Result},
    machine::{Machine, Motion},
    process::file::CorrectionLimits,
    simulation::settings,
};

/// Corrects the path `tasks` within the limits `given` and those of the machine.
///
/// # Errors
/// Limits that do not fit the machine, or that exclude one another: named with point, drive and values.
pub(crate) fn correct_within_limits(
    nominal: &Machine,
    actual: &Machine,
    tasks: &[TaskPoint],
    given: &CorrectionLimits,
) -> Result<BoundedPath> {
    correct_within_forces(nominal, actual, tasks, given, force_limits(nominal, given))
}

/// Returns the force limit of each drive, N or N·mm: the smaller one of process and machine, infinite where there is none.
pub(crate) fn force_limits(machine: &Machine, given: &CorrectionLimits) -> Vec<f64> {
    let or_inf = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
    machine.drives().map(|(_, drive)| or_inf(drive.force_limit).min(or_inf(given.force_N))).collect()
}

/// Corrects as [`correct_within_limits`], but with the limits `force` on drive forces, N or N·mm.
///
/// # Errors
/// As there.
pub(crate) fn correct_within_forces(
    nominal: &Machine,
    actual: &Machine,
    tasks: &[TaskPoint],
    given: &CorrectionLimits,
    force: Vec<f64>,
) -> Result<BoundedPath> {
    let limits = Limits { force: Some(force), ..engine_limits(nominal, tasks, given)? };
    let settings = BoundedSettings { point: settings(), ..BoundedSettings::default() };
    Ok(compensate_bounded(nominal, actual, tasks, &limits, given.objective, &settings, &|_| ())?)
}

/// Checks that limits fit the drives of a machine; the error says why not.
pub(crate) fn check_limits(machine: &Machine, given: &CorrectionLimits) -> std::result::Result<(), String> {
    if given.is_limited() && machine.drives().any(|(_, drive)| drive.motion == Motion::Revolute) {
        return Err(
            "are in mm and N, but a drive of the machine turns; limit it by travel_deg and torque_limit_Nmm".into()
        );
    }
    if given.is_limited() { refuse_locked(machine) } else { Ok(()) }
}

/// Refuses locked drives, since corrections within limits move all drives.
fn refuse_locked(machine: &Machine) -> std::result::Result<(), String> {
    match machine.locked.is_empty() {
        true => Ok(()),
        false => Err("cannot be kept with locked drives: corrections within limits move all drives".into()),
    }
}

/// Returns the limits for each drive, as the engine takes them; an error if they do not fit the machine or the tasks.
fn engine_limits(machine: &Machine, tasks: &[TaskPoint], given: &CorrectionLimits) -> Result<Limits> {
    let fault = |problem: &str| Err(Error::Argument { argument: "limits".into(), problem: problem.into() });
    let checked = check_limits(machine, given).and_then(|()| refuse_locked(machine));
    checked.map_err(|problem| Error::Argument { argument: "limits".into(), problem })?;
    if tasks.iter().any(|task| task.coordinates(machine).count() < machine.controls.len()) {
        return fault("cannot be kept on a machine that controls rotations: a program commands positions only");
    }
    let each = |limit: Option<f64>| limit.map(|limit| vec![limit; machine.drive_count()]);
    Ok(Limits {
        correction: each(given.correction_mm),
        correction_change: each(given.correction_change_mm),
        travel: None,
        force: None,
    })
}
