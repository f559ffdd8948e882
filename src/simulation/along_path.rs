//! A toolpath on a machine: what happens without compensation, what each method commands and leaves, what a written
//! program does.

use std::{convert::Infallible, ops::Range, sync::OnceLock};

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

pub use super::path_sums::{Left, PathSummary, PathSums};
use crate::{
    compensation::{CompensationStatus, Method, TaskPoint},
    input::error::Result,
    machine::{Configuration, Machine},
    simulation::{
        Machines, Source,
        path_blocks::blocks,
        tracking::{TrackPoint, join, last_of, tracked},
    },
    spatial::Pose,
    statics::Batch,
    work::{Event, Work, this_shard},
};

/// Points that are solved one after another, each from the one before. Blocks are solved in parallel; the division does
/// not depend on the number of threads, so neither do the results.
pub(crate) const BLOCK: usize = 256;

/// A path to be cut: what is wanted at each point, on which machine.
#[derive(Debug, Clone, Copy)]
pub struct PathCase<'a> {
    /// The machine by which commands are computed.
    pub nominal: &'a Machine,
    /// The machine that answers.
    pub real: &'a Machine,
    /// From whose rest deflections are measured, if the nominal machine is zeroed there.
    pub unloaded: &'a Machine,
    /// Where the nominal machine stands at the point before, from which it goes on; `None` at the beginning of the path.
    pub before: Option<&'a Configuration>,
    /// What is wanted at each point, in path order.
    pub tasks: &'a [TaskPoint],
}

impl<'a> PathCase<'a> {
    /// A whole path on `machines`, answered for `source`.
    pub(crate) fn new(machines: &'a Machines, source: Source, tasks: &'a [TaskPoint]) -> Self {
        let (nominal, real) = (machines.nominal(source), machines.actual(source));
        Self { nominal, real, unloaded: machines.unloaded(), before: None, tasks }
    }
}

/// One point of a path, as commanded by a method or a program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathAnswer {
    /// How the compensation ended.
    pub status: CompensationStatus,
    /// Whether the machine settles at the command; without, errors and forces mean nothing.
    pub is_settled: bool,
    /// Corrections made.
    pub corrections: usize,
    /// Drive positions commanded, mm or rad.
    pub drives: Vec<f64>,
    /// Drives of the nominal inverse kinematics of the wanted pose, mm or rad; empty where it cannot be reached.
    pub nominal_drives: Vec<f64>,
    /// Pose of P that is commanded: the modified target; `None` where there is none.
    pub target: Option<Pose>,
    /// Position error of the compensated point at the end, O axes, mm.
    pub position_error: Vector3<f64>,
    /// Rotation of the platform from the wanted orientation at the end, rotation vector in O axes, rad.
    pub residual_rotation: Vector3<f64>,
    /// Forces of the drives at the end, N or N·mm.
    pub drive_forces: Vec<f64>,
}

impl PathAnswer {
    /// Δρ: commanded less nominal drive positions, mm or rad.
    pub fn delta_rho(&self) -> Vec<f64> {
        self.drives.iter().zip(&self.nominal_drives).map(|(rho, nominal)| rho - nominal).collect()
    }

    /// The position error, where the machine settles.
    pub fn settled_error(&self) -> Option<Vector3<f64>> {
        self.is_settled.then_some(self.position_error)
    }
}

/// How each point of a path gets its command.
#[derive(Debug, Clone, Copy)]
pub enum Commands<'a> {
    /// By a compensation method.
    Method(Method),
    /// From a program: the pose of P commanded at each point.
    Program(&'a [Pose]),
    /// Drive positions at each point, mm or rad.
    Drives(&'a [Vec<f64>]),
}

/// Points computed together, whose results are then given away: as many blocks as keep the threads busy.
pub(crate) const PART: usize = 16 * BLOCK;

/// The path of `length` points in parts of [`PART`].
pub(crate) fn parts(length: usize) -> impl Iterator<Item = Range<usize>> {
    (0..length).step_by(PART).map(move |start| start..length.min(start + PART))
}

/// Commands every point of the path and lets the machine settle, and gives the answers to `take` in the order of the
/// path, part by part. `done` is called after each point.
///
/// # Errors
/// Of `take`.
pub fn run_in_parts<E>(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    done: &(dyn Fn() + Sync),
    mut take: impl FnMut(Vec<PathAnswer>) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    let mut before = case.before.cloned();
    for part in parts(case.tasks.len()) {
        let first = part.start / BLOCK;
        let track = lead(case.nominal, before.as_ref(), &case.tasks[part], |_, _| true);
        before = last_of_blocks(&track).cloned().or(before);
        take(side_by_side(case, commands, first, &track, done))?;
    }
    Ok(())
}

/// `nominal` tracked along the blocks of `tasks`, behind the point at which it stands as in `before`. A block ends early where `goes_on`, told
/// the index of its first point and the points so far, says no.
pub(crate) fn lead(
    nominal: &Machine,
    before: Option<&Configuration>,
    tasks: &[TaskPoint],
    goes_on: impl Fn(usize, &[TrackPoint]) -> bool + Sync,
) -> Vec<Vec<TrackPoint>> {
    let starts: Vec<usize> = (0..tasks.len()).step_by(BLOCK).collect();
    let groups = starts.par_chunks(together(starts.len()));
    let mut track: Vec<Vec<TrackPoint>> = groups
        .flat_map_iter(|starts| {
            let blocks: Vec<&[TaskPoint]> = starts.iter().map(|&start| block(tasks, start)).collect();
            tracked(nominal, &blocks, |k, points| goes_on(starts[k], points))
        })
        .collect();
    join(nominal, before, tasks.chunks(BLOCK).zip(&mut track));
    track
}

/// Where the machine stands at the last point of `tracked` to which it can be tracked.
pub(crate) fn last_of_blocks(track: &[Vec<TrackPoint>]) -> Option<&Configuration> {
    track.iter().rev().find_map(|points| last_of(points))
}

fn block(tasks: &[TaskPoint], start: usize) -> &[TaskPoint] {
    &tasks[start..tasks.len().min(start + BLOCK)]
}

/// Of so many blocks, how many at a time are worth it: which are solved together makes no difference to what is found.
pub(crate) fn together(blocks: usize) -> usize {
    blocks.div_ceil(rayon::current_num_threads()).clamp(1, Batch::WIDTH)
}

/// As [`run`], of a machine that was tracked along the same poses before.
pub(crate) fn run_tracked(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    track: &[Vec<TrackPoint>],
    done: &(dyn Fn() + Sync),
) -> Vec<PathAnswer> {
    side_by_side(case, commands, 0, track, done)
}

/// The blocks of the path from `first` on, along which the machine is tracked as `tracked` says.
fn side_by_side(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    first: usize,
    track: &[Vec<TrackPoint>],
    done: &(dyn Fn() + Sync),
) -> Vec<PathAnswer> {
    let done = || {
        done();
        Ok::<(), Infallible>(())
    };
    let together = together(track.len());
    let groups = track.par_chunks(together).enumerate().map(|(group, track)| {
        let answers = blocks(case, commands, first + group * together, track, &done);
        answers.unwrap_or_else(|never| match never {})
    });
    groups.flatten_iter().flatten().collect()
}

/// As [`run_in_parts`], all answers at once.
pub fn run(case: &PathCase<'_>, commands: &Commands<'_>, done: &(dyn Fn() + Sync)) -> Vec<PathAnswer> {
    let mut answers = Vec::with_capacity(case.tasks.len());
    let taken = run_in_parts(case, commands, done, |part| {
        answers.extend(part);
        Ok::<(), Infallible>(())
    });
    taken.unwrap_or_else(|never| match never {});
    answers
}

/// Where the nominal machine is tracked along points of a path: of a machine whose hinges count their turns found for all at once, of others block
/// by block, as each is asked for.
#[derive(Debug)]
pub(crate) struct TrackBlocks<'a> {
    nominal: &'a Machine,
    tasks: &'a [TaskPoint],
    blocks: Vec<OnceLock<Vec<TrackPoint>>>,
}

impl<'a> TrackBlocks<'a> {
    /// Along `tasks`, behind the point at which `nominal` stands as in `before`.
    pub fn new(nominal: &'a Machine, before: Option<&Configuration>, tasks: &'a [TaskPoint]) -> Self {
        let blocks = match nominal.may_change_posture() {
            true => lead(nominal, before, tasks, |_, _| true).into_iter().map(OnceLock::from).collect(),
            false => tasks.chunks(BLOCK).map(|_| OnceLock::new()).collect(),
        };
        Self { nominal, tasks, blocks }
    }

    /// Where it stands at the last point, from which the next goes on.
    pub fn last(&self) -> Option<Configuration> {
        self.blocks.iter().rev().filter_map(OnceLock::get).find_map(|points| last_of(points)).cloned()
    }

    fn block(&self, start: usize) -> &Vec<TrackPoint> {
        let found = || tracked(self.nominal, &[block(self.tasks, start)], |_, _| true).swap_remove(0);
        self.blocks[start / BLOCK].get_or_init(found)
    }
}

/// Pieces of `work` along the part of the path that begins at `first`, along which the machine is `tracked`: what `keep` takes of the answers of a
/// method, but for those that another part of the work computes. The pieces of `passes` along the path are numbered together.
///
/// # Errors
/// Of `work`.
pub(crate) fn kept<T: Serialize + DeserializeOwned + Send>(
    case: &PathCase<'_>,
    track: &TrackBlocks<'_>,
    (first, passes): (usize, usize),
    method: Method,
    work: &Work,
    keep: impl Fn(PathAnswer) -> T + Sync,
) -> Result<Vec<T>> {
    let blocks = (0..case.tasks.len()).into_par_iter().step_by(BLOCK).filter_map(|start| {
        let work = work.shard((first + start) / BLOCK * passes);
        let compute = || {
            let done = || {
                work.tell(Event::Computed(1));
                work.check()
            };
            let track = std::slice::from_ref(track.block(start));
            let answers = blocks(case, &Commands::Method(method), start / BLOCK, track, &done)?.concat();
            let unsolved = answers.iter().filter(|answer| !answer.is_settled).count();
            if unsolved > 0 {
                work.tell(Event::Unsolved(unsolved));
            }
            Ok(answers.into_iter().map(&keep).collect())
        };
        this_shard(work.piece(&(first + start), Vec::len, compute)).transpose()
    });
    Ok(blocks.collect::<Result<Vec<Vec<T>>>>()?.into_iter().flatten().collect())
}
