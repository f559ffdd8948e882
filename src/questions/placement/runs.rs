//! Points of a path solved side by side: the path is cut into runs, each solved point after point, as many at a time as lanes hold.
//!
//! Where runs begin depends on the points alone, so the numbers of a place do, too, whatever thread computes them after what.

use std::sync::{Mutex, PoisonError};

use super::{
    evaluate::{Evaluator, at_path_point},
    site::Site,
    tally::PointValues,
    walk::{ExactMode, Infeasibility, PathWalk, WalkSettings, WalkSolvers, visit_together},
};
use crate::{
    compensation::TaskPoint,
    machine::{Configuration, Machine},
    simulation::{
        Failure,
        tracking::{TrackPoint, join_blocks, track_together_from},
    },
    statics::Batch,
};

/// Solvers of a feature that no thread is using.
#[derive(Debug, Default)]
pub(super) struct SpareSolvers(Mutex<Vec<WalkSolvers>>);

impl SpareSolvers {
    /// Calls `use_solvers` with solvers that no other thread uses; `make` makes them where none are left.
    fn with<T>(&self, make: impl FnOnce() -> WalkSolvers, use_solvers: impl FnOnce(&mut WalkSolvers) -> T) -> T {
        let spare = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = spare().pop();
        let mut solvers = taken.unwrap_or_else(make);
        let used = use_solvers(&mut solvers);
        spare().push(solvers);
        used
    }
}

impl Evaluator {
    /// Returns the numbers at `points` (indices in path order) of the path of feature `f`, whose poses and loads at `site` are `tasks`; appends
    /// positions within limits to `shares`. `Err` has the first point that cannot be cut.
    pub(super) fn solve_points_of(
        &self,
        place: (&Site, usize),
        tasks: &[TaskPoint],
        points: &[usize],
        shares: &mut Option<Vec<f64>>,
    ) -> Result<Vec<PointValues>, (usize, Failure)> {
        self.solve_points_with(self.walk_settings(place.1), place, tasks, points, shares)
    }

    /// Returns the numbers at `points` as [`Evaluator::solve_points_of`], without corrections where no metric needs them: a point that only they
    /// tell cannot be cut is none of the `Err`, which has the index of the first.
    pub(super) fn solve_plain_points_of(
        &self,
        place: (&Site, usize),
        tasks: &[TaskPoint],
        points: &[usize],
    ) -> Result<Vec<PointValues>, (usize, Failure)> {
        let settings = self.walk_settings(place.1);
        let exact = if self.needs.correction { settings.exact } else { ExactMode::NotAsked };
        self.solve_points_with(WalkSettings { exact, ..settings }, place, tasks, points, &mut None)
    }

    /// Returns the numbers at `points` as `settings` ask. `Err` has the first that cannot be cut.
    fn solve_points_with(
        &self,
        settings: WalkSettings<'_>,
        (site, f): (&Site, usize),
        tasks: &[TaskPoint],
        points: &[usize],
        shares: &mut Option<Vec<f64>>,
    ) -> Result<Vec<PointValues>, (usize, Failure)> {
        let job = &self.study.features[f];
        let mut values = vec![PointValues::default(); points.len()];
        let mut refused = None;
        self.visit_runs(settings, f, tasks, points, shares, |(number, k), walk, found| match found {
            Ok(found) => {
                values[number] = self.with_across_parts(found, site, job, (k, &tasks[k]), walk);
                true
            }
            Err(Infeasibility { failure, .. }) => {
                refused = Some((k, at_path_point(job, k, failure)));
                false
            }
        });
        refused.map_or(Ok(values), Err)
    }

    /// Solves `points` (indices in path order) of `tasks`, the path of feature `f`, as `settings` ask in runs side by side, and calls `take` with the number of each
    /// point and its index, the walk that solved it and what it found. Where `take` returns false, its run and those behind end. Appends positions
    /// within limits to `shares`, in path order.
    pub(super) fn visit_runs(
        &self,
        settings: WalkSettings<'_>,
        f: usize,
        tasks: &[TaskPoint],
        points: &[usize],
        shares: &mut Option<Vec<f64>>,
        mut take: impl FnMut((usize, usize), &PathWalk<'_>, Result<PointValues, Infeasibility>) -> bool,
    ) {
        let nominal = self.study.features[f].machine();
        let length = points.len().div_ceil(Batch::WIDTH).max(1);
        let runs: Vec<&[usize]> = points.chunks(length).collect();
        let starts = run_starts(nominal, tasks, &runs);
        let found: Vec<&Configuration> = starts.iter().map(|start| start.as_ref().unwrap_or(&nominal.home)).collect();
        let solvers = || WalkSolvers::new(settings.machines, settings.needs);
        self.features[f].solvers.with(solvers, |solvers| {
            solvers.with_walks(settings, &found, |walks, mut batches| {
                for (number, walk) in walks.iter_mut().enumerate() {
                    walk.shares = shares.is_some().then(Vec::new);
                    walk.first = starts[0].clone().filter(|_| number > 0);
                }
                let mut open = runs.len();
                for step in 0..length {
                    let going: Vec<usize> = (0..open).filter(|&run| step < runs[run].len()).collect();
                    let own: Vec<TaskPoint> = going.iter().map(|&run| tasks[runs[run][step]]).collect();
                    let moving = walks.iter_mut().enumerate().filter(|(run, _)| going.contains(run));
                    let mut moving: Vec<&mut PathWalk<'_>> = moving.map(|(_, walk)| walk).collect();
                    let solved = visit_together(&mut moving, &own, batches.as_deref_mut());
                    for ((&run, walk), solved) in going.iter().zip(moving).zip(solved) {
                        let point = (run * length + step, runs[run][step]);
                        if run < open && !take(point, walk, solved) {
                            open = run;
                        }
                    }
                }
                if let Some(shares) = shares {
                    walks.iter_mut().for_each(|walk| shares.append(walk.shares.get_or_insert_default()));
                }
            });
        });
    }

    /// Returns what walks along the path of feature `f` compute and refuse.
    pub(super) fn walk_settings(&self, f: usize) -> WalkSettings<'_> {
        let prepared = &self.features[f];
        WalkSettings {
            machines: &prepared.machines,
            needs: self.needs,
            force_limits: &prepared.force_limits,
            check_forces: self.check_forces,
            exact: self.exact,
        }
    }
}

/// Returns the configuration of `nominal` at the first point of each of `runs` of `tasks`, led along the path from home; `None` where it is not reached, or
/// stands on external axes.
fn run_starts(nominal: &Machine, tasks: &[TaskPoint], runs: &[&[usize]]) -> Vec<Option<Configuration>> {
    // Where joints turn, only the way there says at which turn.
    let needs_way = nominal.may_change_posture();
    let tracked = |run: &&[usize]| -> Vec<TaskPoint> {
        let last = if needs_way { run.len() } else { 1 };
        run[..last].iter().map(|&k| tasks[k]).collect()
    };
    let blocks: Vec<Vec<TaskPoint>> = runs.iter().map(tracked).collect();
    let blocks: Vec<&[TaskPoint]> = blocks.iter().map(Vec::as_slice).collect();
    let first = tasks.get(runs.first().map_or(0, |run| run[0])).filter(|task| needs_way && task.external.is_none());
    // The way from home may lead around, which one run is enough to find.
    let first = first.and_then(|task| nominal.inverse_kinematics(&task.pose).ok());
    let begin = first.as_ref().unwrap_or(&nominal.home);
    // Nothing leads on from a point out of reach, which refuses the path.
    let is_reached = |_: usize, points: &[TrackPoint]| points.last().is_some_and(|point| point.at.is_some());
    let mut track: Vec<Vec<TrackPoint>> = track_together_from(begin, nominal, &blocks, is_reached);
    join_blocks(nominal, None, blocks.iter().copied().zip(&mut track));
    let start = |(points, tasks): (Vec<TrackPoint>, &&[TaskPoint])| {
        points.into_iter().next()?.at.filter(|_| tasks[0].external.is_none())
    };
    track.into_iter().zip(&blocks).map(start).collect()
}
