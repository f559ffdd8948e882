//! Verifies a written program by simulating it, beside no compensation (each error source alone) and other methods.

use std::ops::Range;

use nalgebra::Vector3;

use super::{CompensateOptions, Part, Pass, ProgramAsWritten, ProgramJob, commanded_poses};
use crate::{
    compensation::{Method, TaskPoint},
    input::error::{Error, Result},
    process::cutting::PathLoad,
    simulation::{
        BySource, Source,
        along_path::{self, Commands, PathPointResult, PathSums, TrackBlocks, run_tracked},
        play::Reversals,
        spread_along::{self, LargestBoth, PathSpread, PointSpread, SpreadPart, SpreadPath},
        tasks::PoseTracker,
    },
    spatial::Wrench,
    toolpath::Load,
    work::{Event, Work, compute_overlapped},
};

/// Consecutive points of a program, with simulated results before and after compensation.
#[derive(Debug)]
pub struct VerifiedPart<'a> {
    /// The points.
    pub part: Part<'a>,
    /// Error at each point without compensation by source, base axes, mm; `None` without equilibrium; empty for a source not simulated alone.
    pub before: BySource<Vec<Option<Vector3<f64>>>>,
    /// Rotation of the tool at each point without compensation, rotation vectors in base axes, rad; without meaning where there is no equilibrium.
    pub rotations_before: Vec<Vector3<f64>>,
    /// Results of the program as written.
    pub written: Vec<PathPointResult>,
    /// Error of the program as written where the cutting force is absent, base axes, mm; `None` without equilibrium.
    pub without_force: Vec<Option<Vector3<f64>>>,
    /// Distributions of the error at each point, without compensation and as written; empty where inputs are taken as exact.
    pub spread: Vec<Option<PointSpread>>,
}

/// What the program as written does if the cutting force is absent (in air, in a spring pass, with a broken tool), over the points that count and
/// at which a force is expected.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WithoutForce {
    /// Point farthest from the path, and its distance, mm; `None` where no force is expected anywhere.
    pub most: Option<(usize, f64)>,
    /// Number of points at which the machine then has no equilibrium.
    pub unknown: usize,
}

/// What a verification found.
#[derive(Debug)]
pub struct Verification {
    /// No compensation, the compared methods, and last the program as written.
    pub passes: Vec<Pass>,
    /// The program as written where the cutting force is absent.
    pub without_force: WithoutForce,
    /// Distributions of the largest error over the points that count; `None` where inputs are taken as exact.
    pub spread: Option<PathSpread>,
}

impl ProgramJob {
    /// Simulates the program without compensation, by the other methods `asked` for, and as `written` under `name`, with the cutting force and
    /// without, and on the machines and under the forces that uncertain inputs make. `take` gets each part in order, and `work` is told of each point
    /// of each pass.
    ///
    /// # Errors
    /// Errors of `take` and of `work`, a machine without equilibrium under its weight, a cutting force that its law does not give, or more than
    /// `unloaded_gouge_mm` off the path without it.
    pub fn verify(
        &self,
        name: String,
        written: &ProgramAsWritten,
        asked: &CompensateOptions,
        work: &Work,
        mut take: impl FnMut(&VerifiedPart<'_>) -> Result<()> + Send,
    ) -> Result<Verification> {
        let methods: Vec<Method> = [Method::None].into_iter().chain(asked.compared.iter().copied()).collect();
        let (mut sums, mut as_written) = (vec![PathSums::default(); methods.len()], PathSums::default());
        let (mut law, mut absent) = (CuttingLawCheck::new(self), WithoutForce::default());
        let (mut written_tracked, mut tracked_before) = (self.tracker(), None);
        let done = &|| work.tell(Event::Computed(1));
        let (drawn, passes, counts) = (self.drawn(&self.machines)?, self.passes(), |k: usize| self.is_counted(k));
        let (passes, counts, margin_mm) = (&passes[..], &counts, written.rounded_mm);
        let uncertain = drawn.as_ref().map(|drawn| SpreadPath { margin_mm, passes, counts, ..self.spread(drawn) });
        let (mut largest, mut reversals) = (LargestBoth::default(), Reversals::default());
        let mut parts = self.parts();
        let prove_part = |_: Range<usize>| {
            let Some(part) = parts.next().transpose()? else { return Ok(None) };
            law.check(&part)?;
            let case = part.case([&self.machine, &self.machines.actual, &self.machine]);
            let track = self.track(&part, &mut tracked_before);
            let mut rotations_before = Vec::new();
            let before = BySource::of(&self.machine, |source| {
                if source != Source::All && !asked.sources_apart {
                    return Vec::new();
                }
                let alone = part.with_tasks(|task| source.task(task));
                let machines = &self.machines;
                let case = alone.case([machines.nominal(source), machines.actual(source), machines.unloaded()]);
                let answers = run_tracked(&case, &Commands::Method(Method::None), &track, done);
                if source == Source::All {
                    self.sum_up(&mut sums[0], part.first, &answers);
                    rotations_before = answers.iter().map(|answer| answer.residual_rotation).collect();
                }
                answers.iter().map(PathPointResult::solved_error).collect()
            });
            for (method, sums) in methods.iter().zip(&mut sums).skip(1) {
                let answers = run_tracked(&case, &Commands::Method(*method), &track, done);
                self.sum_up(sums, part.first, &answers);
            }
            let poses = commanded_poses(&part, &mut written_tracked, &written.sent);
            let commands = Commands::Program(&poses);
            let mut answers = run_tracked(&case, &commands, &track, done);
            answers.iter_mut().for_each(|answer| reversals.note(answer.play.as_mut()));
            self.sum_up(&mut as_written, part.first, &answers);
            let unloaded = part.with_tasks(TaskPoint::without_force);
            let case = unloaded.case([&self.machine, &self.machines.actual, &self.machine]);
            let without_force = run_tracked(&case, &commands, &track, done);
            let without_force: Vec<_> = without_force.iter().map(PathPointResult::solved_error).collect();
            self.add_without_force(&mut absent, &part, &without_force);
            self.check_gouge(absent)?;
            let mut spread = Vec::new();
            if let Some(uncertain) = &uncertain {
                let track = TrackBlocks::of(&self.machine, part.tasks(), track.into_owned());
                let own = part.to_spread(&track, &poses);
                spread = uncertain.solve_part(&own, 1, work, &mut largest)?;
            }
            Ok(Some(VerifiedPart { part, before, rotations_before, written: answers, without_force, spread }))
        };
        compute_overlapped(along_path::parts(self.path.len()), prove_part, |verified| take(&verified))?;
        sums.push(as_written);
        let names = methods.iter().map(|method| method.label()).chain([name]);
        let passes = names.zip(&sums).map(|(name, sums)| Pass { name, summary: sums.summary() }).collect();
        let each_part = |take: &mut dyn FnMut(&SpreadPart<'_>) -> Result<()>| self.each_part(written, take);
        let largest_along = |path| spread_along::whole(&[(path, &each_part)], &largest, work);
        let spread = uncertain.as_ref().map(largest_along).transpose()?;
        Ok(Verification { passes, without_force: absent, spread: spread.flatten() })
    }

    /// Hands each part of the program with the poses that it commands as `written` to `take`, in order.
    pub(super) fn each_part(
        &self,
        written: &ProgramAsWritten,
        take: &mut dyn FnMut(&SpreadPart<'_>) -> Result<()>,
    ) -> Result<()> {
        let (mut before, mut tracked) = (None, self.tracker());
        for part in self.parts() {
            let part = part?;
            let track = self.track(&part, &mut before).into_owned();
            let track = TrackBlocks::of(&self.machine, part.tasks(), track);
            let poses = commanded_poses(&part, &mut tracked, &written.sent);
            take(&part.to_spread(&track, &poses))?;
        }
        Ok(())
    }

    /// Adds the part's `errors` where the force is absent (base axes, mm; `None` without equilibrium) to the largest one found.
    fn add_without_force(&self, absent: &mut WithoutForce, part: &Part<'_>, errors: &[Option<Vector3<f64>>]) {
        for ((point, task), error) in part.range().zip(part.tasks()).zip(errors) {
            if !self.is_counted(point) || task.load == Wrench::zero() {
                continue;
            }
            match error.map(|error| error.norm()) {
                None => absent.unknown += 1,
                Some(size) if absent.most.is_none_or(|(_, most)| size > most) => absent.most = Some((point, size)),
                Some(_) => {}
            }
        }
    }

    /// Refuses a program that leaves its path by more than its limit where the cutting force is absent, or of which that is not known.
    fn check_gouge(&self, absent: WithoutForce) -> Result<()> {
        let Some(limit) = self.process.limits.unloaded_gouge_mm else { return Ok(()) };
        let allows = format!("limits.unloaded_gouge_mm allows {limit} mm");
        let problem = match absent {
            WithoutForce { unknown: 1.., .. } => format!(
                "where the cutting force is absent, the machine has no equilibrium at {} points of the program as written: {allows}",
                absent.unknown
            ),
            WithoutForce { most: Some((point, size)), .. } if size > limit => format!(
                "where the cutting force is absent (in air, in a spring pass, with a broken tool), the program as written would leave its path by \
                 {size:.4} mm, {}: {allows}",
                self.place_text(point)
            ),
            _ => return Ok(()),
        };
        Err(Error::argument(&self.name, problem))
    }

    /// Describes point number `point` of the path: its line and the length up to it, such as "line 7, 12.5 mm along the path".
    pub(super) fn place_text(&self, point: usize) -> String {
        let path_point = &self.path.points()[point];
        let line = self.file.line_name(path_point.source.segment).map_or_else(String::new, |line| format!("{line}, "));
        format!("{line}{:.1} mm along the path", path_point.arc_length_mm)
    }
}

/// Checks the loads of task points against the cutting-force law, since commands and verification use the same task points.
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
