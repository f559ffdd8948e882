//! Simulates a toolpath on a machine: without compensation, with each method, and as a written program commands.

use std::{convert::Infallible, ops::Range, sync::OnceLock};

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

pub use super::path_sums::{PathSummary, PathSums, PointResidual};
use crate::{
    compensation::{CompensationStatus, Method, TaskPoint},
    input::error::Result,
    machine::{Configuration, Machine},
    simulation::{
        Machines, Source,
        path_blocks::{TrackedBlock, solve_blocks},
        play::PointPlay,
        tracking::{TrackPoint, join_blocks, last_reached, track_together},
    },
    spatial::Pose,
    statics::Batch,
    toolpath::{PathPoint, Way},
    work::{Event, Work, if_this_shard},
};

/// Number of points solved one after another, each from the one before. Blocks are solved in parallel; their division does not depend on the
/// number of threads, so neither do the results.
pub(crate) const BLOCK: usize = 256;

/// A path to simulate: task points and machines.
#[derive(Debug, Clone, Copy)]
pub struct PathCase<'a> {
    /// The nominal machine, which computes commands.
    pub nominal: &'a Machine,
    /// The actual machine.
    pub actual: &'a Machine,
    /// The machine from whose unloaded equilibrium deflections are measured, if the nominal one is calibrated there.
    pub unloaded: &'a Machine,
    /// Configuration of the nominal machine at the point before; `None` at the beginning of the path.
    pub before: Option<&'a Configuration>,
    /// Task points, in path order.
    pub tasks: &'a [TaskPoint],
    /// Whether play of the drives counts, where they have any: [`PointPlay`].
    pub play: bool,
}

impl<'a> PathCase<'a> {
    /// Creates the case of a whole path on `machines` under `source`, in which play counts.
    pub(crate) fn new(machines: &'a Machines, source: Source, tasks: &'a [TaskPoint]) -> Self {
        let (nominal, actual) = (machines.nominal(source), machines.actual(source));
        Self { nominal, actual, unloaded: machines.unloaded(), before: None, tasks, play: true }
    }
}

/// How a point of a path is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival {
    /// The way there.
    pub way: Way,
    /// The tool in the spindle, if the path says it.
    pub tool: Option<u32>,
}

impl From<&PathPoint> for Arrival {
    fn from(point: &PathPoint) -> Self {
        Self { way: point.way, tool: point.tool }
    }
}

/// Command and equilibrium at one point of a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathPointResult {
    /// How the compensation ended.
    pub status: CompensationStatus,
    /// Whether the machine has an equilibrium at the command; without one, errors and forces have no meaning.
    pub is_settled: bool,
    /// Number of corrections made.
    pub corrections: usize,
    /// Drive positions commanded, mm or rad.
    pub drives: Vec<f64>,
    /// Drive positions by nominal inverse kinematics of the wanted pose, mm or rad; empty where it cannot be reached.
    pub nominal_drives: Vec<f64>,
    /// Commanded pose of P, the modified target; `None` where there is none.
    pub target: Option<Pose>,
    /// Error of the compensated point in equilibrium, O axes, mm.
    pub position_error: Vector3<f64>,
    /// Rotation of the platform from the wanted orientation in equilibrium, rotation vector in O axes, rad.
    pub residual_rotation: Vector3<f64>,
    /// Drive forces in equilibrium, N or N·mm.
    pub drive_forces: Vec<f64>,
    /// Play of the drives, which is in the errors as far as they are pressed to a side; `None` where they have none or it does not count.
    pub play: Option<PointPlay>,
}

impl PathPointResult {
    /// Returns Δρ, commanded less nominal drive positions, mm or rad.
    pub fn delta_rho(&self) -> Vec<f64> {
        self.drives.iter().zip(&self.nominal_drives).map(|(rho, nominal)| rho - nominal).collect()
    }

    /// Returns the motion by the play of drives that are pressed to a side, which is in the error at a given command (O axes, mm).
    pub fn seated(&self) -> Vector3<f64> {
        self.play.as_ref().map_or_else(Vector3::zeros, |play| play.seated_mm)
    }

    /// Returns the position error at a given command without that (O axes, mm); `None` without equilibrium.
    pub fn elastic_error(&self) -> Option<Vector3<f64>> {
        Some(self.solved_error()? - self.seated())
    }

    /// Returns the position error (O axes, mm); `None` without equilibrium.
    pub fn solved_error(&self) -> Option<Vector3<f64>> {
        self.is_settled.then_some(self.position_error)
    }
}

/// Source of the command at each point of a path.
#[derive(Debug, Clone, Copy)]
pub enum Commands<'a> {
    /// A compensation method.
    Method(Method),
    /// A program: the commanded pose of P at each point.
    Program(&'a [Pose]),
    /// Given drive positions at each point, mm or rad.
    Drives(&'a [Vec<f64>]),
}

/// Number of points computed together before their results are passed on: enough blocks to keep the threads busy.
pub(crate) const PART: usize = 16 * BLOCK;

/// Returns the parts of a path of `length` points, each of [`PART`].
pub(crate) fn parts(length: usize) -> impl Iterator<Item = Range<usize>> {
    (0..length).step_by(PART).map(move |start| start..length.min(start + PART))
}

/// Simulates every point of the path; `take` gets the results part by part in path order, and `done` is called after each point.
///
/// # Errors
/// Of `take`.
pub fn run_in_parts<E>(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    done: &(dyn Fn() + Sync),
    mut take: impl FnMut(Vec<PathPointResult>) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    let mut before = case.before.cloned();
    for part in parts(case.tasks.len()) {
        let first = part.start / BLOCK;
        let track = track_blocks(case.nominal, before.as_ref(), &case.tasks[part], |_, _| true);
        before = last_configuration(&track).cloned().or(before);
        take(solve_grouped(case, commands, first, &track, done))?;
    }
    Ok(())
}

/// Tracks `nominal` along the blocks of `tasks`, beginning at the configuration `before`. A block ends early where `goes_on` returns false
/// for the index of its first point and its points so far.
pub(crate) fn track_blocks(
    nominal: &Machine,
    before: Option<&Configuration>,
    tasks: &[TaskPoint],
    goes_on: impl Fn(usize, &[TrackPoint]) -> bool + Sync,
) -> Vec<Vec<TrackPoint>> {
    let starts: Vec<usize> = (0..tasks.len()).step_by(BLOCK).collect();
    let groups = starts.par_chunks(group_size(starts.len()));
    let mut track: Vec<Vec<TrackPoint>> = groups
        .flat_map_iter(|starts| {
            let blocks: Vec<&[TaskPoint]> = starts.iter().map(|&start| block_tasks(tasks, start)).collect();
            track_together(nominal, &blocks, |k, points| goes_on(starts[k], points))
        })
        .collect();
    join_blocks(nominal, before, tasks.chunks(BLOCK).zip(&mut track));
    track
}

/// Returns the configuration at the last point of `track` that is reached; `None` if none is.
pub(crate) fn last_configuration(track: &[Vec<TrackPoint>]) -> Option<&Configuration> {
    track.iter().rev().find_map(|points| last_reached(points))
}

/// Returns the task points of the block that begins at `start`.
fn block_tasks(tasks: &[TaskPoint], start: usize) -> &[TaskPoint] {
    &tasks[start..tasks.len().min(start + BLOCK)]
}

/// Returns how many of `blocks` blocks to solve together; it makes no difference to the results.
pub(crate) fn group_size(blocks: usize) -> usize {
    blocks.div_ceil(rayon::current_num_threads()).clamp(1, Batch::WIDTH)
}

/// Simulates the path like [`run`], with the machine already tracked along it.
pub(crate) fn run_tracked(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    track: &[Vec<TrackPoint>],
    done: &(dyn Fn() + Sync),
) -> Vec<PathPointResult> {
    solve_grouped(case, commands, 0, track, done)
}

/// Solves the blocks of the path from number `first` on in parallel, with the machine tracked as in `track`.
fn solve_grouped(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    first: usize,
    track: &[Vec<TrackPoint>],
    done: &(dyn Fn() + Sync),
) -> Vec<PathPointResult> {
    let done = || {
        done();
        Ok::<(), Infallible>(())
    };
    let together = group_size(track.len());
    let groups = track.par_chunks(together).enumerate().map(|(group, track)| {
        let first = first + group * together;
        let blocks: Vec<TrackedBlock<'_>> =
            track.iter().enumerate().map(|(k, track)| ((first + k) * BLOCK, &track[..])).collect();
        let answers = solve_blocks(case, commands, &blocks, &done);
        answers.unwrap_or_else(|never| match never {})
    });
    groups.flatten_iter().flatten().collect()
}

/// Simulates the path like [`run_in_parts`], and returns all results at once.
pub fn run(case: &PathCase<'_>, commands: &Commands<'_>, done: &(dyn Fn() + Sync)) -> Vec<PathPointResult> {
    let mut answers = Vec::with_capacity(case.tasks.len());
    let taken = run_in_parts(case, commands, done, |part| {
        answers.extend(part);
        Ok::<(), Infallible>(())
    });
    taken.unwrap_or_else(|never| match never {});
    answers
}

/// Tracked points of the nominal machine along a path: found for all blocks at once if its revolute joints count turns, otherwise block by block when needed.
#[derive(Debug)]
pub(crate) struct TrackBlocks<'a> {
    nominal: &'a Machine,
    tasks: &'a [TaskPoint],
    blocks: Vec<OnceLock<Vec<TrackPoint>>>,
}

impl<'a> TrackBlocks<'a> {
    /// Prepares tracking along `tasks`, beginning at the configuration `before`.
    pub fn new(nominal: &'a Machine, before: Option<&Configuration>, tasks: &'a [TaskPoint]) -> Self {
        let blocks = match nominal.may_change_posture() {
            true => return Self::of(nominal, tasks, track_blocks(nominal, before, tasks, |_, _| true)),
            false => tasks.chunks(BLOCK).map(|_| OnceLock::new()).collect(),
        };
        Self { nominal, tasks, blocks }
    }

    /// Makes those of `tasks` from the tracked points of each of its blocks.
    pub fn of(nominal: &'a Machine, tasks: &'a [TaskPoint], blocks: Vec<Vec<TrackPoint>>) -> Self {
        Self { nominal, tasks, blocks: blocks.into_iter().map(OnceLock::from).collect() }
    }

    /// Returns the configuration at the last point that is reached, from which the next part goes on; `None` if none of those tracked so far is.
    pub fn last(&self) -> Option<Configuration> {
        self.blocks.iter().rev().filter_map(OnceLock::get).find_map(|points| last_reached(points)).cloned()
    }

    /// Returns the tracked points of the block that begins at `start`.
    pub fn block(&self, start: usize) -> &[TrackPoint] {
        let found = || track_together(self.nominal, &[block_tasks(self.tasks, start)], |_, _| true).swap_remove(0);
        self.blocks[start / BLOCK].get_or_init(found)
    }
}

/// Computes the results of a method along the part of the path that begins at `first`, as pieces of `work`, and returns what `keep` makes of
/// them; pieces of other shards are left out. All `passes` along the path number their pieces together.
///
/// # Errors
/// Of `work`.
pub(crate) fn run_pieces<T: Serialize + DeserializeOwned + Send>(
    case: &PathCase<'_>,
    track: &TrackBlocks<'_>,
    first: usize,
    passes: usize,
    method: Method,
    work: &Work,
    keep: impl Fn(PathPointResult) -> T + Sync,
) -> Result<Vec<T>> {
    let compute = |block: Range<usize>, work: &Work| {
        let done = || {
            work.tell(Event::Computed(1));
            work.check()
        };
        let tracked = (block.start, track.block(block.start));
        let answers = solve_blocks(case, &Commands::Method(method), &[tracked], &done)?.concat();
        let unsolved = answers.iter().filter(|answer| !answer.is_settled).count();
        if unsolved > 0 {
            work.tell(Event::Unsolved(unsolved));
        }
        Ok(answers.into_iter().map(&keep).collect())
    };
    Ok(block_pieces(case.tasks.len(), first, passes, work, Vec::len, compute)?.into_iter().flatten().collect())
}

/// Computes the blocks of `count` points from `first` on as pieces of `work`, in parallel, and returns them in order; pieces of other shards are
/// left out. `compute` gets the indices of a block's points, counted from `first`; `items` says how many points a piece has.
///
/// # Errors
/// Of `work` and of `compute`.
pub(crate) fn block_pieces<T: Serialize + DeserializeOwned + Send>(
    count: usize,
    first: usize,
    passes: usize,
    work: &Work,
    items: impl Fn(&T) -> usize + Sync,
    compute: impl Fn(Range<usize>, &Work) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let blocks = (0..count).into_par_iter().step_by(BLOCK).filter_map(|start| {
        let work = work.shard((first + start) / BLOCK * passes);
        let block = start..count.min(start + BLOCK);
        if_this_shard(work.piece(&(first + start), &items, || compute(block, &work))).transpose()
    });
    blocks.collect()
}

/// Returns the length of path, mm, that point `k` of `count` stands for in shares, with the lengths `along` up to each and which of them count: half the way
/// to its neighbours that do. It is above 0, so that points without a way between them count alike.
pub(crate) fn length_of_point(
    k: usize,
    count: usize,
    along: impl Fn(usize) -> f64,
    counts: impl Fn(usize) -> bool,
) -> f64 {
    let before = if k > 0 { along(k) - along(k - 1) } else { 0.0 };
    let after = if k + 1 < count && counts(k + 1) { along(k + 1) - along(k) } else { 0.0 };
    (0.5 * (before + after)).max(f64::MIN_POSITIVE)
}
