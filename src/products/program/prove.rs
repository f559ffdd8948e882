//! What a written program does, beside no compensation, whose sources are told apart, and other methods.

use nalgebra::Vector3;

use super::{Asked, Part, Pass, ProgramCommands, ProgramJob, Written};
use crate::{
    compensation::Method,
    input::error::{Error, Result},
    process::cutting::PathLoad,
    simulation::{
        BySource, Machines, Source,
        along_path::{Commands, PathAnswer, PathSums, run_tracked},
        tasks::Tracked,
    },
    spatial::Wrench,
    toolpath::Load,
};

/// Points of a program that follow one another, and what the tool does there.
#[derive(Debug)]
pub struct ProvedPart<'a> {
    /// The points.
    pub part: &'a Part<'a>,
    /// Displacements from the path without compensation under each source, base axes, mm; `None` where the machine does not settle. Empty
    /// for a source that is not told apart.
    pub before: &'a BySource<Vec<Option<Vector3<f64>>>>,
    /// The program as written.
    pub written: &'a [PathAnswer],
}

impl ProgramJob {
    /// What the program does without compensation, by the other methods `asked` for, in their order, and as `written` under `name`. All of this
    /// is computed part by part, as the machine is tracked along a part but once; `take` gets them in order. `done` is called after each point of each pass.
    ///
    /// # Errors
    /// Of `take`, a machine that does not rest under its weight, or a cutting force that its law does not give.
    pub fn prove(
        &self,
        (name, written): (String, &Written),
        asked: &Asked,
        done: &(dyn Fn() + Sync),
        mut take: impl FnMut(&ProvedPart<'_>) -> Result<()>,
    ) -> Result<Vec<Pass>> {
        let machines = Machines::new(&self.machine, &self.process.errors)?;
        let methods: Vec<Method> = [Method::None].into_iter().chain(asked.compared.iter().copied()).collect();
        let (mut sums, mut as_written) = (vec![PathSums::default(); methods.len()], PathSums::default());
        let (mut written_tracked, mut law, mut tracked_before) = (self.track(), LawBehind::new(self), None);
        for part in self.parts() {
            let part = part?;
            law.holds(&part)?;
            let case = part.case([&self.machine, &self.real, &self.machine]);
            let track = self.tracking(&part, &mut tracked_before);
            let before = BySource::of(&self.machine, |source| {
                if source != Source::All && !asked.sources_apart {
                    return Vec::new();
                }
                let alone = part.asked(|task| source.task(task));
                let case = alone.case([machines.nominal(source), machines.actual(source), machines.unloaded()]);
                let answers = run_tracked(&case, &Commands::Method(Method::None), &track, done);
                if source == Source::All {
                    self.sum_up(&mut sums[0], part.first, &answers);
                }
                answers.iter().map(PathAnswer::settled_error).collect()
            });
            for (method, sums) in methods.iter().zip(&mut sums).skip(1) {
                let answers = run_tracked(&case, &Commands::Method(*method), &track, done);
                self.sum_up(sums, part.first, &answers);
            }
            let commands = ProgramCommands::Sent(&written.sent);
            let answers = self.answers(&part, &mut written_tracked, &commands, &|commands| {
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

/// What the law of the cutting force gives at the ends of moves behind a point. Commands and proof take the force from the same tasks, so
/// the proof holds it against the law itself.
pub struct LawBehind<'a> {
    job: &'a ProgramJob,
    track: Tracked<'a>,
    /// The move of the point before, the length of the path up to it, and the six components there, N and N·mm.
    before: Option<(usize, f64, [f64; 6])>,
    ends: Vec<(f64, [f64; 6])>,
}

/// How far a component may be beyond those of the law, as a share of the largest: rounding.
const ROUNDING: f64 = 1e-9;

impl<'a> LawBehind<'a> {
    /// Of `job`, none of whose points are seen.
    pub fn new(job: &'a ProgramJob) -> Self {
        Self { job, track: job.track(), before: None, ends: Vec::new() }
    }

    /// Checks that on each axis of W the load at the points of the next `part` is between those of the law there and at the ends of moves
    /// less than the length of corners behind.
    ///
    /// # Errors
    /// It is not.
    pub fn holds(&mut self, part: &Part<'_>) -> Result<()> {
        for (point, task) in part.points.iter().zip(part.tasks()) {
            let law =
                self.job.process.load(point).map_err(|fault| Error::argument(&self.job.name, fault.to_string()))?;
            let there = self.track.placed(task.external).turned(&task.pose.rotation);
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

/// Force and moment about the tip.
fn components(load: &Load) -> [f64; 6] {
    Wrench { force: load.force_N, moment: load.moment_Nmm }.to_array()
}
