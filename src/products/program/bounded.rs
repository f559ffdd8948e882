//! A program corrected within the limits of its process, and where it exceeds them as it is written.

use super::{Part, Pass, ProgramCommands, ProgramJob};
use crate::{
    compensation::{BoundedPath, BoundedPoint, LimitKind},
    input::error::Result,
    simulation::{along_path::PathAnswer, within_limits::correct},
};

/// A pass within limits, and what the limits do.
#[derive(Debug, Clone)]
pub struct BoundedPass {
    /// The pass, simulated point by point.
    pub pass: Pass,
    /// Which limits bind where and what they cost.
    pub path: BoundedPath,
}

/// A limit that the program as written exceeds because its positions are rounded: where it does so most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exceeded {
    /// Which limit.
    pub kind: LimitKind,
    /// Index of the drive, machine order.
    pub drive: usize,
    /// Index of the point.
    pub point: usize,
    /// Size of what is limited, mm, rad, N or N·mm.
    pub value: f64,
    /// The limit, in the same unit.
    pub limit: f64,
}

/// Where the program as written exceeds limits of the process or force limits of the machine, gathered in path order.
#[derive(Debug)]
pub struct Exceedances<'a> {
    job: &'a ProgramJob,
    bounded: &'a BoundedPath,
    /// The worst point of each limit and drive.
    worst: Vec<Exceeded>,
    /// Corrections of the point before, if it takes part.
    before: Option<Vec<f64>>,
}

impl<'a> Exceedances<'a> {
    /// Of `job`, whose corrections `bounded` keep the limits.
    pub fn new(job: &'a ProgramJob, bounded: &'a BoundedPath) -> Self {
        Self { job, bounded, worst: Vec::new(), before: None }
    }

    /// What was found: the worst point of each limit and drive.
    pub fn worst(self) -> Vec<Exceeded> {
        self.worst
    }

    /// Takes the answers of the written program from point `first` on.
    pub fn add(&mut self, first: usize, answers: &[PathAnswer]) {
        let limits = &self.job.process.limits;
        let or_none = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
        for (k, answer) in answers.iter().enumerate() {
            let point = first + k;
            if self.bounded.points[point].corrected().is_none() || !answer.is_settled {
                self.before = None;
                continue;
            }
            let corrections = answer.delta_rho();
            for (d, (_, drive)) in self.job.machine.drives().enumerate() {
                let (correction, force) = (corrections[d], answer.drive_forces[d]);
                self.note(LimitKind::Correction, d, point, correction, or_none(limits.correction_mm));
                if let Some(before) = self.before.as_ref().map(|before| before[d]) {
                    self.note(LimitKind::Change, d, point, correction - before, or_none(limits.correction_change_mm));
                }
                self.note(LimitKind::Force, d, point, force, or_none(limits.force_N).min(or_none(drive.force_limit)));
            }
            self.before = Some(corrections);
        }
    }

    fn note(&mut self, kind: LimitKind, drive: usize, point: usize, value: f64, limit: f64) {
        // Values are those of a solver: a limit that is kept to nine digits is kept.
        if value.abs() <= limit * (1.0 + 1e-9) {
            return;
        }
        let found = Exceeded { kind, drive, point, value: value.abs(), limit };
        match self.worst.iter_mut().find(|other| (other.kind, other.drive) == (kind, drive)) {
            Some(other) if other.value >= found.value => {}
            Some(other) => *other = found,
            None => self.worst.push(found),
        }
    }
}

impl ProgramJob {
    /// Corrects the whole path within the limits of the process and the machine.
    /// `done` and `take` are those of [`ProgramJob::pass`].
    ///
    /// # Errors
    /// Too many points to be corrected at once, limits that do not fit the machine, or that exclude one another: named with point, drive and values.
    pub fn bounded_pass(
        &self,
        done: &(dyn Fn() + Sync),
        take: impl FnMut(&Part<'_>, &[PathAnswer]) -> Result<()>,
    ) -> Result<BoundedPass> {
        let path = correct(&self.machine, &self.real, &self.all_tasks()?, &self.process.limits)?;
        // Of a point left out those of home, which its own failure then labels.
        let home = &self.machine.home.drives;
        let of = |point: &BoundedPoint| point.corrected().map_or(home, |corrected| &corrected.drives).clone();
        let drives: Vec<Vec<f64>> = path.points.iter().map(of).collect();
        let pass = self.pass("bounded", &ProgramCommands::Drives(&drives), done, take)?;
        Ok(BoundedPass { pass, path })
    }
}
