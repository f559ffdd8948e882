//! Spread along a path where inputs are uncertain: at each point, and of the largest distance from the whole path.
//!
//! Commands are those of the nominal machine, nominal and compensated, or those of a program as it is written. What is left of the compensation on
//! other machines under other forces is what the program leaves in the shop.

use std::ops::Range;

use nalgebra::Vector3;
#[cfg(feature = "report")]
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    Failure, Machines, ROUNDING_MM, Source,
    along_path::{self, Commands, PathCase, PathPointResult, TrackBlocks, block_pieces},
    path_blocks::{TrackedBlock, solve_blocks},
    spread::{DeflectionSpread, Draw, DrawnMachines, IfMeasured, Sizes, WantedSpread, under_factors},
    tasks::PoseTracker,
    tracking::TrackPoint,
};
use crate::{
    compensation::{Method, TaskPoint},
    input::error::Result,
    machine::Machine,
    process::{
        Placement,
        uncertainty::{Cut, DrawnForceAt, Draws, ForceFactors, Response, Shares, ToolOnWorkpiece, Uncertainty},
    },
    spatial::Pose,
    statics::Batch,
    work::{Event, Work},
};

/// Distributions at a point of a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointSpread {
    /// Distance from the path at the nominal command.
    pub plain: DeflectionSpread,
    /// Distance from the path at the compensated command, which is computed with nominal numbers; `None` where compensation failed.
    pub compensated: Option<DeflectionSpread>,
    /// Probability that the tool is farther from the path at the compensated command than at the nominal one, by more than 0.5 %; `None` where one of the
    /// distributions is by the engine and the other had to be corrected.
    pub worse: Option<f64>,
    /// Distance from the path at the compensated command where the cutting force is absent, with nominal numbers, mm; `None` without equilibrium.
    pub without_force_mm: Option<f64>,
}

/// Distributions of the largest distance from the path over its points: each draw is one machine and one force for the whole path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PathSpread {
    /// At the nominal commands.
    pub plain: LargestSpread,
    /// At the compensated commands, which are computed with nominal numbers; `None` where no point could be compensated.
    pub compensated: Option<LargestSpread>,
    /// Probability that the largest distance is larger at the compensated commands than at the nominal ones, by more than 0.5 %; `None` where points differ.
    pub worse: Option<f64>,
    /// For each drive, machine order, the probability that its correction makes the largest distance larger by more than 0.5 %, all others being corrected: by estimates of 1024
    /// draws. Empty where they are not known, or not asked for.
    pub worse_by_drive: Vec<f64>,
}

impl PathSpread {
    /// Whether compensation more probably makes the largest distance larger than not.
    pub fn is_probably_worse(&self) -> bool {
        self.worse.is_some_and(|worse| worse > 0.5)
    }
}

/// Distribution of the largest distance over some points of the path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LargestSpread {
    /// The distribution; its main cause is that at the point with the largest 95 % quantile.
    pub spread: DeflectionSpread,
    /// Whether draws of the engine along the whole path agree with it, after correction; not where there is no 95 % quantile.
    pub is_confirmed: bool,
    /// Number of points that it covers: those with an equilibrium at the nominal numbers.
    pub points: usize,
    /// What is worth most to measure at the compensated command of the point with the largest 95 % quantile; `None` where no measurement tells, of several paths at
    /// once, and at the nominal commands.
    pub if_measured: Option<IfMeasured>,
    /// What the causes contribute there; `None` as `if_measured`, or without an estimate.
    #[serde(default)]
    pub shares: Option<Shares>,
}

/// Sizes in the draws of the largest distance over points, mm: the first draws, as far as they are known at all of these points.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Largest {
    sizes: Vec<f64>,
    points: usize,
    /// Distribution at the point with the largest 95 % quantile, but for the first failure, which is that at the first point with one.
    worst: DeflectionSpread,
    /// Index of that point in its path.
    worst_point: usize,
    /// Largest distance with the correction of each drive left out, in the first draws; none where it is not known at all points.
    without_drive: Vec<Vec<f64>>,
}

impl Largest {
    /// Returns the largest distance in each draw, mm.
    pub fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// Adds the largest distance over other points.
    pub fn add(&mut self, next: &Largest) {
        match self.points {
            _ if next.points == 0 => return,
            0 => self.sizes.clone_from(&next.sizes),
            _ => self.sizes.truncate(next.sizes.len()),
        }
        if self.points == 0 {
            self.without_drive.clone_from(&next.without_drive);
        } else if next.without_drive.is_empty() {
            self.without_drive.clear();
        }
        for (own, next) in self.without_drive.iter_mut().zip(&next.without_drive) {
            own.iter_mut().zip(next).for_each(|(own, size)| *own = own.max(*size));
        }
        self.points += next.points;
        let first_failure = self.worst.first_failure.take().or_else(|| next.worst.first_failure.clone());
        if next.worst.p95_mm > self.worst.p95_mm {
            self.worst.clone_from(&next.worst);
            self.worst_point = next.worst_point;
        }
        self.worst.first_failure = first_failure;
        self.sizes.iter_mut().zip(&next.sizes).for_each(|(own, size)| *own = own.max(*size));
    }
}

/// Largest distances at nominal and at compensated commands.
pub(crate) type LargestBoth = [Largest; 2];

/// Spread at the points of a block.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct SpreadBlock {
    /// `None` where the nominal machine has no equilibrium.
    points: Vec<Option<PointSpread>>,
    largest: LargestBoth,
}

/// What is found at the point with the largest 95 % quantile.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct AtWorst {
    if_measured: Option<IfMeasured>,
    shares: Option<Shares>,
}

/// How a point is commanded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Command {
    Plain,
    Compensated,
}

/// Most points that draws of the engine along a whole path are solved at, next to each value and of one order: a long path has fewer of them, but not fewer than eight.
const MAX_POINTS: usize = 2_000_000;

/// Draws in which corrections are left out one by one.
const DRAWS_BY_DRIVE: usize = 4 * Draws::PER_SCRAMBLE;

/// Most points solved one after another, of which several blocks are solved side by side.
const SHORT_BLOCK: usize = along_path::BLOCK / Batch::WIDTH;

/// Distances from the path at a point where even the nominal machine has an equilibrium.
struct Solved {
    /// Without cutting force, with nominal numbers; `None` without equilibrium.
    unloaded: Option<Vector3<f64>>,
    /// Without load, under the cutting force, and with each component twice that varies by itself, or why one of them is missing.
    responses: std::result::Result<Vec<Response>, Failure>,
}

impl Solved {
    /// Without load and under the cutting force; `None` where one of them is missing.
    fn known(&self) -> Option<&[Response]> {
        self.responses.as_ref().ok().map(|own| &own[..])
    }
}

/// Commands of the points of a block.
struct Commanded {
    /// Commanded poses of P, where there is none that of the task; `None` at the nominal command.
    poses: Option<Vec<Pose>>,
    /// Whether each point has its command.
    is_known: Vec<bool>,
}

impl Commanded {
    /// The commands of `points`.
    fn of(&self, points: Range<usize>) -> Commands<'_> {
        match &self.poses {
            None => Commands::Method(Method::None),
            Some(poses) => Commands::Program(&poses[points]),
        }
    }
}

/// A part of a path with its commands.
pub(crate) struct SpreadPart<'a> {
    /// Index of its first point.
    pub first: usize,
    /// Poses and loads at its points.
    pub tasks: &'a [TaskPoint],
    /// What draws change of the force at each; empty where one factor is for all of it.
    pub forces: &'a [DrawnForceAt],
    /// The nominal machine along it.
    pub track: &'a TrackBlocks<'a>,
    /// Compensated poses of P as a program commands them at each point; those of the nominal machine if `None`.
    pub written: Option<&'a [Pose]>,
}

/// Hands each part of a path to a function, in order.
pub(crate) type EachPart<'a> = dyn Fn(&mut dyn FnMut(&SpreadPart<'_>) -> Result<()>) -> Result<()> + 'a;

/// Returns the parts of the path of these `tasks` with `forces` as in [`SpreadPart`], along which the machine `nominal` is tracked, with the commands that it computes.
pub(crate) fn parts_of<'a>(
    nominal: &'a Machine,
    tasks: &'a [TaskPoint],
    forces: &'a [DrawnForceAt],
) -> Box<EachPart<'a>> {
    Box::new(move |take| {
        let mut before = None;
        along_path::parts(tasks.len()).try_for_each(|points| {
            let (first, tasks, forces) = (points.start, &tasks[points.clone()], forces.get(points).unwrap_or_default());
            let track = TrackBlocks::new(nominal, before.as_ref(), tasks);
            before = track.last().or(before.take());
            take(&SpreadPart { first, tasks, forces, track: &track, written: None })
        })
    })
}

/// Numbers from `first` on the passes of a path at whose points the tool cuts or not: one begins where the tool cuts and did not before.
pub(crate) fn numbers_of_passes(first: u32, cuts: impl Iterator<Item = bool>) -> Vec<u32> {
    let mut all = Vec::with_capacity(cuts.size_hint().0);
    let (mut pass, mut has_cut, mut cut_before) = (first, false, false);
    for cuts in cuts {
        pass += u32::from(cuts && !cut_before && has_cut);
        (has_cut, cut_before) = (has_cut || cuts, cuts);
        all.push(pass);
    }
    all
}

/// A path whose spread is wanted.
pub(crate) struct SpreadPath<'a> {
    /// The nominal and actual machines, and those that uncertain inputs make of them.
    pub drawn: &'a DrawnMachines,
    /// Where the workpiece stands.
    pub placement: Placement,
    /// Largest distance that is within tolerance, mm.
    pub tolerance_mm: Option<f64>,
    /// Difference of two distances that means nothing, such as by rounding a written program, mm.
    pub margin_mm: f64,
    /// Draws chosen at random and solved at each point at the compensated commands, as reports of the points say.
    pub audits: usize,
    /// Number of the pass of each point, see [`numbers_of_passes`]; empty of one pass.
    pub passes: &'a [u32],
    /// Whether the point with this index counts in the largest distance.
    pub counts: &'a (dyn Fn(usize) -> bool + Sync),
    /// Whether it is asked what the correction of each drive does.
    pub by_drive: bool,
    /// Whether the compensated commands are computed as well, and each point is checked by itself; a search wants the largest distance alone.
    pub compensates: bool,
}

impl SpreadPath<'_> {
    /// Computes the spread at the points of `part`, as pieces of `work`, pass number `passes - 1` of all that number their pieces together; `None` where
    /// the nominal machine has no equilibrium. Adds their largest distances to `largest`.
    ///
    /// # Errors
    /// Of `work`.
    pub fn solve_part(
        &self,
        part: &SpreadPart<'_>,
        passes: usize,
        work: &Work,
        largest: &mut LargestBoth,
    ) -> Result<Vec<Option<PointSpread>>> {
        let work = work.part("spread").numbered_after(passes - 1);
        let items = |block: &SpreadBlock| block.points.len();
        let blocks = block_pieces(part.tasks.len(), part.first, passes, &work, items, |points, work| {
            let solved = Block::new(self, part, &points, work).spread()?;
            work.tell(Event::Computed(points.len()));
            Ok(solved)
        })?;
        for block in &blocks {
            largest.iter_mut().zip(&block.largest).for_each(|(all, next)| all.add(next));
        }
        Ok(blocks.into_iter().flat_map(|block| block.points).collect())
    }

    /// Returns what is worth most to measure at the point with the index `k` under the compensated command, where the 95 % quantile is `now`, mm, as the engine
    /// finds with each main cause there as if it were measured; and what the causes contribute there.
    fn worth_measuring(&self, each_part: &EachPart<'_>, k: usize, now: f64, work: &Work) -> Result<AtWorst> {
        let (mut all, mut shares) = (Vec::new(), None);
        each_part(&mut |part| {
            let Some(own) = k.checked_sub(part.first).filter(|own| *own < part.tasks.len()) else { return Ok(()) };
            let start = own - own % along_path::BLOCK;
            let block = Block::new(self, part, &(start..(start + along_path::BLOCK).min(part.tasks.len())), work);
            let point = block.only(own - start);
            let commanded = point.commanded(Command::Compensated)?;
            let nominal = point.responses(&commanded)?.into_iter().flatten().next();
            let Some(Ok(responses)) = nominal.map(|solved| solved.responses) else { return Ok(()) };
            shares = Some(self.drawn.shares(&responses, point.cut_at(0)));
            for cause in self.drawn.main_causes(&responses, point.cut_at(0)) {
                let Some((drawn, known)) = self.drawn.measured(cause)? else { continue };
                let path = SpreadPath { drawn: &drawn, audits: 0, ..*self };
                let point = Block { path: &path, tools: point.tools.clone(), ..point };
                let found = point.spreads_at(0, &commanded, 0, &point.responses(&commanded)?)?;
                let then = found.into_iter().flatten().find_map(|(spread, _)| spread.p95_mm);
                all.extend(then.map(|then| IfMeasured {
                    cause: cause.into(),
                    known: known.into(),
                    p95_mm: [now, then],
                }));
            }
            Ok(())
        })?;
        Ok(AtWorst { if_measured: IfMeasured::worth_most(all), shares })
    }

    /// Returns how far the tool is from the path at each of its points in the draw `index` with its `machines`, O axes, mm; `None` where it has no equilibrium.
    ///
    /// # Errors
    /// Of `work` and of the parts of the path.
    #[cfg(feature = "report")]
    pub fn errors_along(
        &self,
        each_part: &EachPart<'_>,
        (index, machines): (usize, &Machines),
        command: Command,
        work: &Work,
    ) -> Result<Vec<std::result::Result<Vector3<f64>, Failure>>> {
        let mut all = Vec::new();
        each_part(&mut |part| {
            let starts: Vec<usize> = (0..part.tasks.len()).step_by(along_path::BLOCK).collect();
            let of = |start: &usize| {
                let points = *start..part.tasks.len().min(start + along_path::BLOCK);
                let block = Block::new(self, part, &points, work);
                let tasks = self.drawn.under_draw(index, block.tasks, block.forces);
                let commanded = block.commanded(command)?;
                block.displacements((index, machines), tasks, &commanded.of(0..points.len()))
            };
            let found = starts.par_iter().map(of).collect::<Result<Vec<_>>>()?;
            all.extend(found.into_iter().flatten());
            Ok(())
        })?;
        Ok(all)
    }

    /// Largest distance from the path over all its points in a draw with its machines, mm, or why there is none.
    fn largest_along(
        &self,
        each_part: &EachPart<'_>,
        draw: (usize, &Machines),
        command: Command,
        work: &Work,
    ) -> Result<std::result::Result<f64, Failure>> {
        let mut largest = Ok(0.0);
        each_part(&mut |part| {
            let items = |_: &std::result::Result<f64, Failure>| 0;
            let blocks = block_pieces(part.tasks.len(), part.first, 1, work, items, |points, work| {
                Block::new(self, part, &points, work).largest(draw, command)
            })?;
            work.barrier()?;
            for block in blocks {
                largest = largest.clone().and_then(|most: f64| block.map(|block| most.max(block)));
            }
            Ok(())
        })?;
        Ok(largest)
    }
}

/// Checks the largest distances over `paths`, which are under the same draws, by draws of the engine along all of them.
///
/// # Errors
/// Of `work` and of the parts of the paths.
pub(crate) fn whole(
    paths: &[(&SpreadPath<'_>, &EachPart<'_>)],
    [plain, compensated]: &LargestBoth,
    work: &Work,
) -> Result<Option<PathSpread>> {
    let Some((first, _)) = paths.first() else { return Ok(None) };
    let tolerance_mm =
        first.tolerance_mm.filter(|_| paths.iter().all(|(path, _)| path.tolerance_mm == first.tolerance_mm));
    let of = |largest: &Largest, command: Command, name: &str| -> Result<Option<LargestSpread>> {
        if largest.points == 0 {
            return Ok(None);
        }
        let work = work.part("whole path").part(name);
        let solve = |_, (index, of_first, _): Draw<'_>| {
            let mut most = 0.0f64;
            for (number, (path, each_part)) in paths.iter().enumerate() {
                let work = work.part(&format!("draw {index}")).part(&number.to_string());
                let on = |drawn: &Machines| path.largest_along(each_part, (index, drawn), command, &work);
                let found = match number {
                    0 => on(of_first),
                    _ => path.drawn.on_draw(index, on).unwrap_or_else(|failure| Ok(Err(failure))),
                };
                match found? {
                    Ok(largest) => most = most.max(largest),
                    Err(failure) => return Ok(Err(failure)),
                }
            }
            Ok(Ok(most))
        };
        let most_next = MAX_POINTS.checked_div(largest.points);
        let wanted = WantedSpread {
            drawn: first.drawn,
            tolerance_mm,
            // Each point has its own.
            cut: &|_| Cut::default(),
            solve: &solve,
            checks: true,
            most_next,
            audits: 0,
            seed: &|_| 0,
        };
        let DeflectionSpread { main_cause, main_cause_share, first_failure, .. } = largest.worst.clone();
        let spread = DeflectionSpread { main_cause, main_cause_share, first_failure, ..DeflectionSpread::default() };
        let (spread, agrees) = wanted.check(&largest.sizes, spread)?;
        let is_confirmed = agrees && (spread.solved_draws > 0 || spread.p95_mm.is_some_and(|p95| p95 <= ROUNDING_MM));
        let worst = largest.worst.p95_mm.filter(|now| command == Command::Compensated && *now > ROUNDING_MM);
        let at_worst = match (paths, worst) {
            ([(path, each_part)], Some(now)) => {
                let measured = || path.worth_measuring(each_part, largest.worst_point, now, &work);
                work.part("measured").piece(&0, |_| 0, measured)?
            }
            _ => AtWorst::default(),
        };
        let AtWorst { if_measured, shares } = at_worst;
        Ok(Some(LargestSpread { spread, is_confirmed, points: largest.points, if_measured, shares }))
    };
    let Some(of_plain) = of(plain, Command::Plain, "plain")? else { return Ok(None) };
    let of_compensated = of(compensated, Command::Compensated, "compensated")?;
    let worse =
        (plain.points == compensated.points).then(|| share_larger(&compensated.sizes, &plain.sizes, first.margin_mm));
    let worse_by_drive =
        compensated.without_drive.iter().map(|without| share_larger(&compensated.sizes, without, first.margin_mm));
    let worse_by_drive = worse_by_drive.collect();
    Ok(Some(PathSpread { plain: of_plain, compensated: of_compensated, worse, worse_by_drive }))
}

/// Largest difference at which two distances are alike, as a share: what the estimate is good for.
pub(crate) const ALIKE: f64 = 0.005;

/// Whether `size` is larger than `than`, mm, by more than what is alike and by more than `margin_mm`.
pub(crate) fn is_larger(size: f64, than: f64, margin_mm: f64) -> bool {
    size > than * (1.0 + ALIKE) + margin_mm + ROUNDING_MM
}

/// Share of the draws, as far as both are known, in which `sizes` [is larger](is_larger) than `than`.
pub(crate) fn share_larger(sizes: &[f64], than: &[f64], margin_mm: f64) -> f64 {
    let pairs = || sizes.iter().zip(than);
    let larger = pairs().filter(|(size, than)| is_larger(**size, **than, margin_mm)).count();
    larger as f64 / pairs().count().max(1) as f64
}

/// A block of the path on the nominal machine.
struct Block<'a> {
    path: &'a SpreadPath<'a>,
    /// Index of its first point.
    first: usize,
    tasks: &'a [TaskPoint],
    forces: &'a [DrawnForceAt],
    track: &'a [TrackPoint],
    /// As in [`SpreadPart`].
    written: Option<&'a [Pose]>,
    /// Where the tool is at each point; empty where nothing of the setup is uncertain.
    tools: Vec<ToolOnWorkpiece>,
    work: &'a Work,
}

/// Returns where the tool of the `nominal` machine is on the workpiece at each of `tasks`; nothing where no error of the setup is `uncertain`.
pub(crate) fn tools_on_workpiece(
    nominal: &Machine,
    placement: &Placement,
    uncertain: &Uncertainty,
    tasks: &[TaskPoint],
) -> Vec<ToolOnWorkpiece> {
    if uncertain.setups().next().is_none() {
        return Vec::new();
    }
    let mut tracker = PoseTracker::new(nominal, placement);
    let tool = |task: &TaskPoint| {
        let placed = tracker.placed(task.external);
        let position_mm = task.wanted().transform(placed.reference()) - placed.workpiece().translation;
        ToolOnWorkpiece { axis: task.pose.rotation * nominal.tool_axes.column(2), position_mm, pass: 0 }
    };
    tasks.iter().map(tool).collect()
}

impl<'a> Block<'a> {
    /// The block of the `points` of `part`.
    fn new(path: &'a SpreadPath<'a>, part: &'a SpreadPart<'a>, points: &Range<usize>, work: &'a Work) -> Self {
        let (tasks, track) = (&part.tasks[points.clone()], part.track.block(points.start));
        let written = part.written.map(|poses| &poses[points.clone()]);
        let forces = part.forces.get(points.clone()).unwrap_or_default();
        let mut tools =
            tools_on_workpiece(&path.drawn.machines.nominal, &path.placement, &path.drawn.uncertainty, tasks);
        for (tool, pass) in tools.iter_mut().zip(path.passes.get(part.first + points.start..).unwrap_or_default()) {
            tool.pass = *pass as usize;
        }
        Self { path, first: part.first + points.start, tasks, forces, track, written, tools, work }
    }

    /// Its point `k` alone.
    fn only(&self, k: usize) -> Self {
        let written = self.written.map(|poses| &poses[k..=k]);
        let tools = self.tools.get(k).copied().into_iter().collect();
        let forces = self.forces.get(k..=k).unwrap_or_default();
        Self {
            first: self.first + k,
            tasks: &self.tasks[k..=k],
            forces,
            track: &self.track[k..=k],
            written,
            tools,
            ..*self
        }
    }

    /// Whether point `k` counts in the largest distance.
    fn counts(&self, k: usize) -> bool {
        (self.path.counts)(self.first + k)
    }

    /// What draws change of the force at point `k`.
    fn force_at(&self, k: usize) -> DrawnForceAt {
        self.forces.get(k).copied().unwrap_or_default()
    }

    /// Who cuts at point `k`.
    fn cut_at(&self, k: usize) -> Cut {
        Cut { tool: self.force_at(k).tool, pass: self.tools.get(k).map_or(0, |own| own.pass) }
    }

    /// By how much the tool itself bends more at point `k` under `factor` times the cutting force than its commands are aside for (O axes, mm).
    fn more_bend(&self, k: usize, factor: f64) -> Vector3<f64> {
        (1.0 - factor) * self.tasks[k].aside
    }

    /// Solves `commands` with `machines` under the cutting force times `factor`.
    fn solve(&self, machines: &Machines, factor: f64, commands: &Commands<'_>) -> Result<Vec<PathPointResult>> {
        self.solve_under(machines, ForceFactors::of_all(factor), commands)
    }

    /// Solves `commands` with `machines` under the cutting force with these factors.
    fn solve_under(
        &self,
        machines: &Machines,
        factors: ForceFactors,
        commands: &Commands<'_>,
    ) -> Result<Vec<PathPointResult>> {
        let under = |(k, task)| under_factors(task, &factors, &self.force_at(k));
        self.solve_tasks(machines, self.tasks.iter().enumerate().map(under).collect(), commands)
    }

    /// Solves `commands` with `machines` for `tasks` in place of its own.
    fn solve_tasks(
        &self,
        machines: &Machines,
        tasks: Vec<TaskPoint>,
        commands: &Commands<'_>,
    ) -> Result<Vec<PathPointResult>> {
        let case = PathCase::new(machines, Source::All, &tasks);
        let points = self.track.len().div_ceil(Batch::WIDTH).clamp(1, SHORT_BLOCK);
        let block = |(k, track)| (k * points, track);
        let blocks: Vec<TrackedBlock<'_>> = self.track.chunks(points).enumerate().map(block).collect();
        Ok(solve_blocks(&case, commands, &blocks, &|| self.work.check())?.concat())
    }

    /// Poses of P that are commanded, O: none of its own for the plain path; of a written program those read back from it; else those that compensate with
    /// nominal inputs, solved as the study does. Where there is no such command, the pose of the task, not known. `Err` where the work is stopped.
    fn commanded(&self, command: Command) -> Result<Commanded> {
        let is_known = vec![true; self.tasks.len()];
        match (command, self.written) {
            (Command::Plain, _) => return Ok(Commanded { poses: None, is_known }),
            (Command::Compensated, Some(poses)) => return Ok(Commanded { poses: Some(poses.to_vec()), is_known }),
            (Command::Compensated, None) => {}
        }
        let tasks: Vec<TaskPoint> = self.tasks.iter().map(|task| Source::All.task(task)).collect();
        let case = PathCase::new(&self.path.drawn.machines, Source::All, &tasks);
        let commands = Commands::Method(Method::Direct);
        let answers = solve_blocks(&case, &commands, &[(0, self.track)], &|| self.work.check())?.concat();
        let targets = answers.into_iter().map(|answer| answer.target.filter(|_| answer.status.is_success()));
        let with_poses = targets.zip(self.tasks).map(|(target, task)| (target.unwrap_or(task.pose), target.is_some()));
        let (poses, is_known) = with_poses.unzip();
        Ok(Commanded { poses: Some(poses), is_known })
    }

    /// Distances from the path at each point, with nominal numbers and with each parameter alone at its ends; `None` where there is no command, or
    /// even the nominal machine has no equilibrium.
    fn responses(&self, commanded: &Commanded) -> Result<Vec<Option<Solved>>> {
        let drawn = self.path.drawn;
        let commands = commanded.of(0..self.tasks.len());
        let response = |nominal: Vector3<f64>| Response { nominal, ends: vec![[None; 2]; drawn.ends.len()] };
        let twice = drawn.uncertainty.force.varied_components().map(|(own, _)| {
            let mut factors = ForceFactors::of_all(1.0);
            factors.components[own] = 1.0;
            factors
        });
        let loads: Vec<ForceFactors> = [0.0, 1.0].map(ForceFactors::of_all).into_iter().chain(twice).collect();
        let solved = |load: &ForceFactors| self.solve_under(&self.path.drawn.machines, *load, &commands);
        let all = loads.iter().map(solved).collect::<Result<Vec<_>>>()?;
        let [unloaded, loaded, twice @ ..] = &all[..] else { return Ok(Vec::new()) };
        // Play is no part of what grows with the force; all draws are taken to stand on the sides of the nominal machine.
        let seated: Vec<Vector3<f64>> = loaded.iter().map(PathPointResult::seated).collect();
        let begin = |(k, ((unloaded, loaded), is_known)): (usize, ((&PathPointResult, &PathPointResult), &bool))| {
            let response = |elastic| self.with_setup(k, response(elastic + seated[k]));
            let loaded = loaded.elastic_error().filter(|_| *is_known)?;
            let unbent = self.more_bend(k, 0.0);
            let free = unloaded.elastic_error().map(|error| error + unbent);
            let free = free.ok_or_else(|| self.failure(unloaded, "without cutting force"));
            let twice = twice.iter().map(|all| {
                let text = "with a component of the cutting force twice as large";
                all[k].elastic_error().ok_or_else(|| self.failure(&all[k], text))
            });
            let errors = [free, Ok(loaded)].into_iter().chain(twice);
            let responses = errors.map(|error| error.map(response)).collect();
            Some(Solved { unloaded: unloaded.solved_error().map(|error| error + unbent), responses })
        };
        let mut points: Vec<Option<Solved>> =
            unloaded.iter().zip(loaded).zip(&commanded.is_known).enumerate().map(begin).collect();
        for (own, ends) in drawn.ends.iter().enumerate() {
            for (end, machines) in ends.iter().enumerate() {
                let Some(machines) = machines else { continue };
                for (load, factors) in loads.iter().enumerate() {
                    let answers = self.solve_under(machines, *factors, &commands)?;
                    for (k, (point, answer)) in points.iter_mut().zip(answers).enumerate() {
                        let Some(Solved { responses, .. }) = point else { continue };
                        match (answer.elastic_error(), responses.as_mut()) {
                            (Some(error), Ok(responses)) => {
                                let error = error + seated[k] + self.more_bend(k, factors.all);
                                responses[load].ends[own][end] = Some(error);
                            }
                            (None, Ok(_)) => {
                                *responses = Err(self.failure(&answer, &drawn.uncertainty.end_text(own, end)))
                            }
                            (_, Err(_)) => {}
                        }
                    }
                }
            }
        }
        Ok(points)
    }

    /// The `response` at point `k` with what the setup does, which no machine says.
    fn with_setup(&self, k: usize, mut response: Response) -> Response {
        let (drawn, Some(tool)) = (self.path.drawn, self.tools.get(k)) else { return response };
        for (own, ends) in response.ends.iter_mut().enumerate() {
            let direction = drawn.uncertainty.setup_direction(own, tool);
            let at = |end: usize| direction.map(|way| response.nominal + drawn.end_coordinates[own][end] * way);
            *ends = [at(0), at(1)];
        }
        response
    }

    /// Why there is no equilibrium in `answer`; `words` say with which machine, empty of a draw.
    fn failure(&self, answer: &PathPointResult, words: &str) -> Failure {
        Failure::of(&answer.status, &self.path.drawn.machines.nominal).on(words)
    }

    /// Distance from the path at point `k` in a draw, mm.
    fn size_at(&self, k: usize, commanded: &Commanded, draw: Draw<'_>) -> Result<std::result::Result<f64, Failure>> {
        let none = Failure { status: "not_converged".into(), reason: "there is no point".into() };
        let (index, machines, factors) = draw;
        let at = self.only(k);
        let tasks = vec![under_factors(&self.tasks[k], &factors, &self.force_at(k))];
        let found = at.sizes((index, machines), tasks, &commanded.of(k..k + 1))?;
        Ok(found.into_iter().next().unwrap_or(Err(none)))
    }

    /// Distances from the path at each point in the draw `index` on its machines and with these `tasks`, under its force, mm, or why there is none.
    fn sizes(
        &self,
        draw: (usize, &Machines),
        tasks: Vec<TaskPoint>,
        commands: &Commands<'_>,
    ) -> Result<Vec<std::result::Result<f64, Failure>>> {
        let all = self.displacements(draw, tasks, commands)?;
        Ok(all.into_iter().map(|own| own.map(|own| own.norm())).collect())
    }

    /// As [`Self::sizes`], the displacements from the path, O axes.
    fn displacements(
        &self,
        (index, machines): (usize, &Machines),
        tasks: Vec<TaskPoint>,
        commands: &Commands<'_>,
    ) -> Result<Vec<std::result::Result<Vector3<f64>, Failure>>> {
        let loaded = self.solve_tasks(machines, tasks, commands)?;
        let free = if self.path.drawn.has_model_error() { self.solve(machines, 0.0, commands)? } else { Vec::new() };
        let error = |answer: &PathPointResult| answer.elastic_error().ok_or_else(|| self.failure(answer, ""));
        let displacement = |(k, answer): (usize, &PathPointResult)| {
            let factor = self.path.drawn.uncertainty.draws.factors(self.force_at(k).tool, index).all;
            let free = free.get(k).map(error).transpose()?.map(|free| free + self.more_bend(k, 0.0));
            let loaded = error(answer)? + self.more_bend(k, factor);
            let moved = |tool| self.path.drawn.uncertainty.setup_displacement(index, tool);
            let moved = self.tools.get(k).map_or_else(Vector3::zeros, moved);
            Ok(self.path.drawn.actual_displacement(index, free, loaded) + answer.seated() + moved)
        };
        Ok(loaded.iter().enumerate().map(displacement).collect())
    }

    /// Distributions at `points` from `first` on, with their sizes in the draws, and `audits` draws chosen at random at each.
    fn spreads_at(
        &self,
        first: usize,
        commanded: &Commanded,
        audits: usize,
        points: &[Option<Solved>],
    ) -> Result<Vec<Option<(DeflectionSpread, Sizes)>>> {
        let solve = |k, draw: Draw<'_>| self.size_at(first + k, commanded, draw);
        let SpreadPath { drawn, tolerance_mm, .. } = *self.path;
        let seed = |k| (self.first + first + k) as u64;
        let (checks, most_next) = (self.path.compensates, None);
        let cut = |k| self.cut_at(first + k);
        let wanted =
            WantedSpread { drawn, tolerance_mm, cut: &cut, solve: &solve, checks, most_next, audits, seed: &seed };
        wanted.spreads(&points.iter().map(|point| point.as_ref().map(Solved::known)).collect::<Vec<_>>())
    }

    /// Returns for each drive by how much the tool is moved at each point where the correction of that drive alone is left out, with nominal numbers, mm (O axes); `None` where
    /// there is no equilibrium.
    fn without_drives(&self, commanded: &Commanded) -> Result<Vec<Vec<Option<Vector3<f64>>>>> {
        let all = self.solve(&self.path.drawn.machines, 1.0, &commanded.of(0..self.tasks.len()))?;
        let without = |drive: usize| {
            let drives = |own: &PathPointResult| {
                let mut drives = own.drives.clone();
                if let (Some(of_drive), Some(nominal)) = (drives.get_mut(drive), own.nominal_drives.get(drive)) {
                    *of_drive = *nominal;
                }
                drives
            };
            let drives: Vec<Vec<f64>> = all.iter().map(drives).collect();
            let found = self.solve(&self.path.drawn.machines, 1.0, &Commands::Drives(&drives))?;
            let moved =
                |(own, with): (&PathPointResult, &PathPointResult)| Some(own.solved_error()? - with.solved_error()?);
            Ok(found.iter().zip(&all).map(moved).collect())
        };
        (0..self.path.drawn.machines.nominal.drives().count()).map(without).collect()
    }

    /// Sizes at point `k` in the first draws with the correction of each drive left out, which moves the tool by `shifts`; none where it is not known.
    fn sizes_without_drives(&self, k: usize, solved: &Solved, shifts: &[Vec<Option<Vector3<f64>>>]) -> Vec<Vec<f64>> {
        let (drawn, Ok(responses)) = (self.path.drawn, &solved.responses) else { return Vec::new() };
        let surrogate = drawn.surrogate(responses, self.cut_at(k));
        let sizes = |shifts: &Vec<Option<Vector3<f64>>>| {
            Some(surrogate.shifted(shifts[k]?).largest_displacements(&drawn.uncertainty.draws, DRAWS_BY_DRIVE))
        };
        shifts.iter().map(sizes).collect::<Option<_>>().unwrap_or_default()
    }

    /// Distributions at the points, and the largest distances over them.
    fn spread(&self) -> Result<SpreadBlock> {
        let with = if self.path.compensates { Command::Compensated } else { Command::Plain };
        let [plain, compensated] = [self.commanded(Command::Plain)?, self.commanded(with)?];
        let all_plain = self.responses(&plain)?;
        let mut all_compensated = match self.path.compensates {
            true => self.responses(&compensated)?,
            false => self.tasks.iter().map(|_| None).collect(),
        };
        // Without the one the other is not told.
        for (with, own) in all_compensated.iter_mut().zip(&all_plain) {
            if own.is_none() {
                *with = None;
            }
        }
        let without = if self.path.by_drive { self.without_drives(&compensated)? } else { Vec::new() };
        let mut largest = LargestBoth::default();
        let mut points = Vec::with_capacity(all_plain.len());
        for (group, (at_plain, at_compensated)) in
            all_plain.chunks(Batch::WIDTH).zip(all_compensated.chunks(Batch::WIDTH)).enumerate()
        {
            let first = group * Batch::WIDTH;
            let of_plain = self.spreads_at(first, &plain, 0, at_plain)?;
            let of_compensated = self.spreads_at(first, &compensated, self.path.audits, at_compensated)?;
            for (k, (own, with)) in (first..).zip(of_plain.into_iter().zip(of_compensated)) {
                let Some((own, sizes)) = own else {
                    points.push(None);
                    continue;
                };
                let worst_point = self.first + k;
                let mut point = PointSpread { plain: own, compensated: None, worse: None, without_force_mm: None };
                if let Some((own, left)) = with {
                    let is_off = |spread: &DeflectionSpread, sizes: &Sizes| spread.is_corrected && !sizes.is_by_engine;
                    let are_comparable = left.is_by_engine == sizes.is_by_engine
                        || !(is_off(&own, &left) || is_off(&point.plain, &sizes));
                    point.worse = are_comparable.then(|| share_larger(&left.mm, &sizes.mm, self.path.margin_mm));
                    let unloaded = all_compensated[k].as_ref().and_then(|solved| solved.unloaded);
                    point.without_force_mm = unloaded.map(|error| error.norm());
                    if self.counts(k) {
                        let solved = all_compensated[k].as_ref().filter(|_| !left.is_by_engine);
                        let without_drive =
                            solved.map_or_else(Vec::new, |solved| self.sizes_without_drives(k, solved, &without));
                        let (sizes, worst) = (left.mm, own.clone());
                        largest[1].add(&Largest { sizes, points: 1, worst, worst_point, without_drive });
                    }
                    point.compensated = Some(own);
                }
                if self.counts(k) {
                    let (sizes, worst, without_drive) = (sizes.mm, point.plain.clone(), Vec::new());
                    largest[0].add(&Largest { sizes, points: 1, worst, worst_point, without_drive });
                }
                points.push(Some(point));
            }
        }
        Ok(SpreadBlock { points, largest })
    }

    /// Largest distance from the path in a draw, over the points that the nominal machine has under the same command, mm, or why there is none.
    fn largest(&self, draw: (usize, &Machines), command: Command) -> Result<std::result::Result<f64, Failure>> {
        let commanded = self.commanded(command)?;
        let commands = commanded.of(0..self.tasks.len());
        let nominal = self.solve(&self.path.drawn.machines, 1.0, &commands)?;
        let mut largest = 0.0f64;
        let tasks = self.path.drawn.under_draw(draw.0, self.tasks, self.forces);
        for (k, (nominal, size)) in nominal.iter().zip(self.sizes(draw, tasks, &commands)?).enumerate() {
            if !nominal.is_settled || !commanded.is_known[k] || !self.counts(k) {
                continue;
            }
            match size {
                Ok(size) => largest = largest.max(size),
                Err(failure) => return Ok(Err(failure)),
            }
        }
        Ok(Ok(largest))
    }
}
