//! Corrects a program within the limits of its process, and finds where the program as written exceeds them.

use super::{Part, Pass, ProgramCommands, ProgramJob, forces::TightenedForces};
use crate::{
    compensation::{BoundedPath, BoundedPoint, LimitKind},
    input::error::Result,
    simulation::{
        along_path::PathPointResult,
        within_limits::{correct_within_forces, force_limits},
    },
    work::{Event, Work},
};

/// A simulated pass within limits, and the effect of the limits.
#[derive(Debug)]
pub struct BoundedPass {
    /// The pass, simulated point by point.
    pub pass: Pass,
    /// Limits that bind, where they do, and their cost in error.
    pub path: BoundedPath,
    /// Force limits as they were tightened; `None` where inputs are exact or no force is limited.
    pub(super) forces: Option<TightenedForces>,
}

/// A quantity against its limit: where the program as written exceeds it most because its positions are rounded, or a force as it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitExcess {
    /// Which limit.
    pub kind: LimitKind,
    /// Index of the drive, machine order.
    pub drive: usize,
    /// Index of the point.
    pub point: usize,
    /// Absolute value of the limited quantity, mm, rad, N or N·mm.
    pub value: f64,
    /// The limit, in the same unit.
    pub limit: f64,
}

impl LimitExcess {
    /// Returns the quantity as a share of its limit.
    pub(super) fn share(&self) -> f64 {
        self.value / self.limit
    }
}

/// Collects where the program as written exceeds limits of the process or force limits of the machine.
#[derive(Debug)]
pub struct ExcessSearch<'a> {
    job: &'a ProgramJob,
    bounded: &'a BoundedPath,
    /// Force limit of each drive, N or N·mm.
    force_limits: Vec<f64>,
    /// Worst excess of each limit and drive.
    worst: Vec<LimitExcess>,
    /// Drive corrections of the previous point, if it was corrected and solved.
    before: Option<Vec<f64>>,
}

impl<'a> ExcessSearch<'a> {
    /// Starts a search along `job`, whose corrected path `bounded` keeps the limits.
    pub fn new(job: &'a ProgramJob, bounded: &'a BoundedPath) -> Self {
        let force_limits = force_limits(&job.machine, &job.process.limits);
        Self { job, bounded, force_limits, worst: Vec::new(), before: None }
    }

    /// Ends the search and returns the worst excess of each limit and drive.
    pub fn worst(self) -> Vec<LimitExcess> {
        self.worst
    }

    /// Checks the results of the written program at the points from index `first` on, in path order.
    pub fn add(&mut self, first: usize, results: &[PathPointResult]) {
        let limits = &self.job.process.limits;
        let or_inf = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
        for (k, result) in results.iter().enumerate() {
            let point = first + k;
            if self.bounded.points[point].corrected().is_none() || !result.is_settled {
                self.before = None;
                continue;
            }
            let corrections = result.delta_rho();
            for (d, &correction) in corrections.iter().enumerate() {
                self.note(LimitKind::Correction, d, point, correction, or_inf(limits.correction_mm));
                if let Some(before) = self.before.as_ref().map(|before| before[d]) {
                    self.note(LimitKind::Change, d, point, correction - before, or_inf(limits.correction_change_mm));
                }
                self.note(LimitKind::Force, d, point, result.drive_forces[d], self.force_limits[d]);
            }
            self.before = Some(corrections);
        }
    }

    /// Records `value` if it exceeds `limit` by more than any earlier point of this limit and drive.
    fn note(&mut self, kind: LimitKind, drive: usize, point: usize, value: f64, limit: f64) {
        // Values are those of a solver: a limit that is kept to nine digits is kept.
        if value.abs() <= limit * (1.0 + 1e-9) {
            return;
        }
        let excess = LimitExcess { kind, drive, point, value: value.abs(), limit };
        match self.worst.iter_mut().find(|other| (other.kind, other.drive) == (kind, drive)) {
            Some(other) if other.value >= excess.value => {}
            Some(other) => *other = excess,
            None => self.worst.push(excess),
        }
    }
}

impl ProgramJob {
    /// Corrects the whole path within the limits of process and machine, and simulates it; `work` is told of each point, `take` as in
    /// [`ProgramJob::pass`]. Where inputs are uncertain, limits of forces are tightened so that they hold on machines and under forces as they may be.
    ///
    /// # Errors
    /// Too many points to be corrected at once, limits that do not fit the machine, or that exclude one another: named with point, drive and values;
    /// errors of `work`.
    pub fn bounded_pass(
        &self,
        work: &Work,
        take: impl FnMut(&Part<'_>, &[PathPointResult]) -> Result<()>,
    ) -> Result<BoundedPass> {
        let (tasks, limits) = (self.all_tasks()?, &self.process.limits);
        let correct =
            |force: Vec<f64>| correct_within_forces(&self.machine, &self.machines.actual, &tasks, limits, force);
        let path = correct(force_limits(&self.machine, limits))?;
        let (path, forces) = self.tighten_forces(path, &correct, work)?;
        let done = || work.tell(Event::Computed(1));
        let pass = self.pass("bounded", &ProgramCommands::Drives(&self.drives_along(&path)), &done, take)?;
        Ok(BoundedPass { pass, path, forces })
    }

    /// Returns the drive positions at each point of `path`, mm or rad; at a point left out those of home, which its own failure then labels.
    pub(super) fn drives_along(&self, path: &BoundedPath) -> Vec<Vec<f64>> {
        let home = &self.machine.home.drives;
        let drives_of = |point: &BoundedPoint| point.corrected().map_or(home, |corrected| &corrected.drives).clone();
        path.points.iter().map(drives_of).collect()
    }
}
