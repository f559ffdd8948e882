//! A program corrected within the limits of its process.

use super::{
    path::{Commands, PathAnswer},
    process::{CorrectionLimits, Objective},
    program::{Pass, ProgramJob},
};
use crate::{
    compensation::{self, BoundedPath, BoundedPoint, BoundedSettings, Demand, Limits, compensate_bounded},
    error::{Error, Result},
    machine::{Machine, Motion},
};

/// A pass within limits, and what the limits do.
#[derive(Debug, Clone)]
pub struct BoundedPass {
    /// The pass, simulated point by point.
    pub pass: Pass,
    /// Which limits bind where and what they cost.
    pub path: BoundedPath,
}

impl CorrectionLimits {
    /// Whether any limit is given.
    pub fn is_limited(&self) -> bool {
        self.correction_mm.is_some() || self.correction_change_mm.is_some() || self.force_N.is_some()
    }
}

impl ProgramJob {
    /// Corrects the whole path within the limits of the process and the machine.
    /// `done` and `take` are those of [`ProgramJob::pass`].
    ///
    /// # Errors
    /// Limits that do not fit the machine, or that exclude one another: named with point, drive and values.
    pub fn bounded_pass(
        &self,
        done: &(dyn Fn() + Sync),
        take: impl FnMut(usize, &[PathAnswer]) -> Result<()>,
    ) -> Result<BoundedPass> {
        let path = correct(&self.machine, &self.real, &self.demands, &self.process.limits)?;
        let drives: Vec<Vec<f64>> =
            path.points.iter().zip(&self.demands).map(|(point, _)| self.drives(point)).collect();
        let pass = self.pass("bounded", &Commands::Drives(&drives), done, take)?;
        Ok(BoundedPass { pass, path })
    }

    /// Drives of a corrected point; of a point left out those of home, which its own failure then labels.
    fn drives(&self, point: &BoundedPoint) -> Vec<f64> {
        match point.corrected() {
            Some(corrected) => corrected.drives.clone(),
            None => self.machine.home.drives.clone(),
        }
    }
}

/// Corrects the path `demands` within the limits `given` and those of the machine.
///
/// # Errors
/// As [`ProgramJob::bounded_pass`].
pub(super) fn correct(
    nominal: &Machine,
    real: &Machine,
    demands: &[Demand],
    given: &CorrectionLimits,
) -> Result<BoundedPath> {
    let limits = limits(nominal, demands, given)?;
    let objective = match given.objective {
        Objective::Rms => compensation::Objective::Rms,
        Objective::Worst => compensation::Objective::Worst,
    };
    let settings = BoundedSettings { point: super::path::settings(), ..BoundedSettings::default() };
    Ok(compensate_bounded(nominal, real, demands, &limits, objective, &settings, &|_| ())?)
}

/// Whether limits fit the drives of a machine.
///
/// # Errors
/// They do not, and why.
pub(super) fn check(machine: &Machine, given: &CorrectionLimits) -> std::result::Result<(), String> {
    if given.is_limited() && machine.drives().any(|(_, drive)| drive.motion == Motion::Revolute) {
        return Err(
            "are in mm and N, but a drive of the machine turns; limit it by travel_deg and torque_limit_Nmm".into()
        );
    }
    Ok(())
}

fn limits(machine: &Machine, demands: &[Demand], given: &CorrectionLimits) -> Result<Limits> {
    let fault = |problem: &str| Err(Error::Argument { argument: "limits".into(), problem: problem.into() });
    check(machine, given).map_err(|problem| Error::Argument { argument: "limits".into(), problem })?;
    if demands.iter().any(|demand| demand.coordinates(machine).count() < machine.controls.len()) {
        return fault("cannot be kept on a machine that controls rotations: a program commands positions only");
    }
    let each = |limit: Option<f64>| limit.map(|limit| vec![limit; machine.drive_count()]);
    Ok(Limits {
        correction: each(given.correction_mm),
        correction_change: each(given.correction_change_mm),
        travel: None,
        force: each(given.force_N),
    })
}
