//! Proves a written program by simulating it, beside no compensation (each error source alone) and other methods.

use nalgebra::Vector3;

use super::{Asked, Part, Pass, ProgramAsWritten, ProgramCommands, ProgramJob};
use crate::{
    compensation::Method,
    input::error::{Error, Result},
    process::cutting::PathLoad,
    simulation::{
        BySource, Machines, Source,
        along_path::{Commands, PathPointResult, PathSums, run_tracked},
        tasks::PoseTracker,
    },
    spatial::Wrench,
    toolpath::Load,
};

/// Consecutive points of a program, with simulated results before and after compensation.
#[derive(Debug)]
pub struct ProvedPart<'a> {
    /// The points.
    pub part: &'a Part<'a>,
    /// Error at each point without compensation by source, base axes, mm; `None` without equilibrium; empty for a source not simulated alone.
    pub before: &'a BySource<Vec<Option<Vector3<f64>>>>,
    /// Results of the program as written.
    pub written: &'a [PathPointResult],
}

impl ProgramJob {
    /// Simulates the program without compensation, by the other methods `asked` for, and as `written` under `name`; returns these passes in
    /// this order. `take` gets each part in order, and `done` is called after each point of each pass.
    ///
    /// # Errors
    /// Errors of `take`, a machine without equilibrium under its weight, or a cutting force that its law does not give.
    pub fn prove(
        &self,
        (name, written): (String, &ProgramAsWritten),
        asked: &Asked,
        done: &(dyn Fn() + Sync),
        mut take: impl FnMut(&ProvedPart<'_>) -> Result<()>,
    ) -> Result<Vec<Pass>> {
        let machines = Machines::new(&self.machine, &self.process.errors)?;
        let methods: Vec<Method> = [Method::None].into_iter().chain(asked.compared.iter().copied()).collect();
        let (mut sums, mut as_written) = (vec![PathSums::default(); methods.len()], PathSums::default());
        let (mut written_tracked, mut law, mut tracked_before) = (self.tracker(), CuttingLawCheck::new(self), None);
        for part in self.parts() {
            let part = part?;
            law.check(&part)?;
            let case = part.case([&self.machine, &self.real, &self.machine]);
            let track = self.track(&part, &mut tracked_before);
            let before = BySource::of(&self.machine, |source| {
                if source != Source::All && !asked.sources_apart {
                    return Vec::new();
                }
                let alone = part.with_tasks(|task| source.task(task));
                let case = alone.case([machines.nominal(source), machines.actual(source), machines.unloaded()]);
                let answers = run_tracked(&case, &Commands::Method(Method::None), &track, done);
                if source == Source::All {
                    self.sum_up(&mut sums[0], part.first, &answers);
                }
                answers.iter().map(PathPointResult::solved_error).collect()
            });
            for (method, sums) in methods.iter().zip(&mut sums).skip(1) {
                let answers = run_tracked(&case, &Commands::Method(*method), &track, done);
                self.sum_up(sums, part.first, &answers);
            }
            let commands = ProgramCommands::CommandedPath(&written.sent);
            let answers = self.part_results(&part, &mut written_tracked, &commands, &|commands| {
                run_tracked(&case, commands, &track, done)
            });
            self.sum_up(&mut as_written, part.first, &answers);
            take(&ProvedPart { part: &part, before: &before, written: &answers })?;
        }
        sums.push(as_written);
        let names = methods.iter().map(|method| method.label()).chain([name]);
        Ok(names.zip(&sums).map(|(name, sums)| Pass { name, summary: sums.summary() }).collect())
    }
}

/// Checks the loads of task points against the cutting-force law, since commands and proof use the same task points.
pub struct CuttingLawCheck<'a> {
    job: &'a ProgramJob,
    track: PoseTracker<'a>,
    /// Move of the point before, arc length up to it (mm), and its six load components (N, N·mm).
    before: Option<(usize, f64, [f64; 6])>,
    /// Arc length and load at the ends of recent moves.
    ends: Vec<(f64, [f64; 6])>,
}

/// How far a load component may lie outside the law's range, as a share of the largest component: rounding.
const ROUNDING: f64 = 1e-9;

impl<'a> CuttingLawCheck<'a> {
    /// Starts a check at the beginning of `job`.
    pub fn new(job: &'a ProgramJob) -> Self {
        Self { job, track: job.tracker(), before: None, ends: Vec::new() }
    }

    /// Checks that along each axis of W the loads of `part` lie between those of the law there and at the ends of moves within the blending length.
    ///
    /// # Errors
    /// A load lies outside.
    pub fn check(&mut self, part: &Part<'_>) -> Result<()> {
        for (point, task) in part.points.iter().zip(part.tasks()) {
            let law =
                self.job.process.load(point).map_err(|fault| Error::argument(&self.job.name, fault.to_string()))?;
            let there = self.track.placed(task.external).with_platform_rotation(&task.pose.rotation);
            let (segment, at) = (point.source.segment, point.arc_length_mm);
            let own = components(&law.on_tool(point.tangent, there.tool_axes()));
            if !point.cutting || matches!(law, PathLoad::Workpiece(_)) {
                (self.before, _) = (None, self.ends.clear());
            }
            self.ends.extend(self.before.filter(|before| before.0 != segment).map(|(_, at, load)| (at, load)));
            self.ends.retain(|end| end.0 > at - self.job.process.corner_mm);
            let found = components(&there.load(&task.load));
            let of_axis = |axis: usize| self.ends.iter().map(move |end| end.1[axis]).chain([own[axis]]);
            let most =
                self.ends.iter().flat_map(|end| end.1).chain(own).fold(0.0, |most: f64, load| most.max(load.abs()));
            let is_between = |axis: usize| {
                let (low, high) = of_axis(axis)
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), load| (low.min(load), high.max(load)));
                found[axis] >= low - ROUNDING * most && found[axis] <= high + ROUNDING * most
            };
            if !(0..6).all(is_between) {
                let problem = format!(
                    "the cutting force of move {} at {at} mm of the path is not between those of its law: {found:?}, the law gives {own:?} (N, \
                     N·mm, axes of the workpiece). This is a fault of kinetostat, not of its input",
                    segment + 1
                );
                return Err(Error::argument(&self.job.name, problem));
            }
            self.before = (point.cutting && !matches!(law, PathLoad::Workpiece(_))).then_some((segment, at, own));
        }
        Ok(())
    }
}

/// Returns force and moment about the tip as six components, N and N·mm.
fn components(load: &Load) -> [f64; 6] {
    Wrench { force: load.force_N, moment: load.moment_Nmm }.to_array()
}
