//! What the tool does along a program without compensation, and which source is to blame.

use nalgebra::Vector3;

use super::{Pass, ProgramJob};
use crate::{
    compensation::{Demand, Method},
    input::error::Result,
    study::{
        BySource, Machines, Source,
        along_path::{Commands, Left, PathAnswer, PathCase, PathSums, run_in_parts},
    },
};

/// What the tool does at the nominal commands.
#[derive(Debug, Clone)]
pub struct Before {
    /// Displacements from the path, base axes, mm, point by point; `None` where the machine does not settle.
    errors: BySource<Vec<Option<Vector3<f64>>>>,
    /// Summed up, under all sources: the pass of the method `none`.
    pub pass: Pass,
}

impl Before {
    /// Those of `source`.
    pub fn of(&self, source: Source) -> &[Option<Vector3<f64>>] {
        self.errors.get(source).map_or(&[], Vec::as_slice)
    }

    /// The point farthest from the path under all sources, and how far, mm; of those at which the tool cuts, if it does at
    /// any.
    pub fn worst(&self, job: &ProgramJob) -> Option<(usize, f64)> {
        let sizes = self.of(Source::All).iter().enumerate().filter_map(|(k, d)| Some((k, d.as_ref()?.norm())));
        let counts = sizes.filter(|(k, _)| job.counts(*k));
        counts.fold(None, |most, (k, size)| match most {
            Some((_, largest)) if largest >= size => most,
            _ => Some((k, size)),
        })
    }

    /// Share of the points that keep `tolerance_mm`, of those that count and are known.
    pub fn share_within(&self, job: &ProgramJob, tolerance_mm: f64) -> Option<f64> {
        share_within(job, self.of(Source::All), tolerance_mm)
    }
}

/// Share of the points of `job` that count and whose `errors` are known at which these keep `tolerance_mm`.
pub(super) fn share_within(job: &ProgramJob, errors: &[Option<Vector3<f64>>], tolerance_mm: f64) -> Option<f64> {
    let known = errors.iter().enumerate().filter(|(k, _)| job.counts(*k)).filter_map(|(_, error)| error.as_ref());
    let (within, all) =
        known.fold((0, 0), |(within, all), error| (within + usize::from(error.norm() <= tolerance_mm), all + 1));
    (all > 0).then(|| within as f64 / all as f64)
}

impl ProgramJob {
    /// Passes over the program that [`ProgramJob::before`] makes.
    pub fn sources(&self) -> usize {
        Source::of(&self.machine).len()
    }

    /// What the tool does without compensation under each source. `done` is called after each point.
    ///
    /// # Errors
    /// A machine that does not rest under its weight.
    pub fn before(&self, done: &(dyn Fn() + Sync)) -> Result<Before> {
        let machines = Machines::new(&self.machine, &self.process.errors)?;
        let mut sums = PathSums::default();
        let of = |source: Source| {
            let demands: Vec<Demand> = self.demands.iter().map(|demand| source.demand(demand)).collect();
            let case = PathCase {
                nominal: machines.commanding(source),
                real: machines.answering(source),
                resting: machines.resting(),
                before: &[],
                demands: &demands,
            };
            let mut errors = Vec::with_capacity(demands.len());
            let taken = run_in_parts(&case, &Commands::Method(Method::None), done, |answers| {
                if source == Source::All {
                    let counted = answers.iter().enumerate().filter(|(k, _)| self.counts(errors.len() + k));
                    counted.for_each(|(_, answer)| sums.add(&Left::of(answer, &self.machine)));
                }
                errors.extend(answers.iter().map(PathAnswer::settled_error));
                Ok::<(), std::convert::Infallible>(())
            });
            taken.unwrap_or_else(|never| match never {});
            errors
        };
        let errors = BySource::of(&self.machine, of);
        Ok(Before { errors, pass: Pass { name: Method::None.label(), summary: sums.summary() } })
    }
}
