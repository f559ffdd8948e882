//! Search for the constant γ, the rotation about the tool axis, that is best for each feature at each place.
//!
//! That γ is the one of a lattice at which the feature can be cut (workspace box, travel of the corrected drives, force limits and all else
//! that a place is judged by) and the objective of the placement is least. What each γ deflects at some points of the path bounds its
//! objective. The γ of the least bound is looked at on, level by level, until that of the least bound is known at all points: no other γ can be
//! better. The result depends on the place alone, so bounds from part of the points stay bounds.

use std::{
    borrow::Cow,
    cmp::Ordering,
    collections::{BTreeSet, HashMap},
    sync::{Mutex, MutexGuard, PoisonError},
};

use serde::{Deserialize, Serialize};

use super::{
    Evaluator, FeatureJob, Site,
    evaluate::{at_path_point, counted_flags, track_feature},
    tally::{PointValues, ResidualTally, Tally},
    walk::ExactMode,
};
use crate::{
    compensation::TaskPoint,
    input::error::Error,
    machine::Configuration,
    process::{CutPath, Placement, RedundancyCost, RedundancySettings},
    redundancy::{
        BranchMachines, GammaProblem, ReachedGamma, first_tasks, infeasible_step, reached_gammas, rotated_by,
    },
    simulation::{
        Failure, Source,
        tasks::tasks_under,
        tracking::{TrackPoint, track_together},
    },
    statics::has_play,
    toolpath::Toolpath,
    work::Work,
};

/// Number of points at which values of γ are compared first.
const TRIED: usize = 24;
/// Number of those beside points that were worst at other places.
const TRIED_BESIDE: usize = 4;
/// Largest difference between objectives that count as the same: the γ nearest to the programmed one is taken.
const SAME: f64 = 1e-9;
/// Share by which a deflection at one of these points may be found smaller along the path.
const ROUNDING: f64 = 1e-6;

/// A place of the workpiece and how it is cut there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Setup {
    /// The place.
    pub site: Site,
    /// γ of each feature, rad; `None` as programmed.
    pub gammas: Vec<Option<f64>>,
}

/// Index of a feature, and the coordinates of its place.
type Key = (usize, [u64; 6]);

/// A γ with which a feature can be cut at a place.
#[derive(Debug, Clone, Copy)]
struct JudgedGamma {
    /// The γ, rad.
    gamma: f64,
    /// Of all points at which the tool cuts.
    tally: Tally,
    /// Objective of the feature alone.
    value: f64,
}

/// Best γ of each feature and place found so far.
#[derive(Debug, Default)]
pub(super) struct GammaCache(Mutex<HashMap<Key, Result<JudgedGamma, Failure>>>);

impl GammaCache {
    /// Returns the γ found so far, to read or write.
    fn found(&self) -> MutexGuard<'_, HashMap<Key, Result<JudgedGamma, Failure>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl FeatureJob {
    /// Checks that the machine can rotate its tool freely, if γ is sought. `Err` says why it cannot.
    pub(super) fn check_gamma_search(&self) -> Result<(), Error> {
        let Some(settings) = self.gamma_search.as_ref().filter(|own| own.is_sought()) else { return Ok(()) };
        let placement = Placement { reference: self.feature.reference, ..Placement::default() };
        rotated_by(self.gamma_problem(settings, &placement), 0.0).map(drop)
    }

    /// Returns the search problem for γ along the path of this feature.
    fn gamma_problem<'a>(&'a self, settings: &'a RedundancySettings, placement: &'a Placement) -> GammaProblem<'a> {
        GammaProblem {
            machine: self.machine(),
            errors: &self.tracked.errors,
            placement,
            target: self.target,
            path: &self.feature.path,
            loads: &self.feature.loads,
            settings,
        }
    }

    /// Returns the points at which values of γ are compared first, indices in path order: fewer where the worst are known.
    fn tried_points(&self) -> Vec<usize> {
        let is_counted = counted_flags(self);
        let counted: Vec<usize> = (0..is_counted.len()).filter(|&k| is_counted[k]).collect();
        let worst = self.worst.iter().flatten().copied().filter(|&k| is_counted[k]);
        let count = if self.worst.is_some() { TRIED_BESIDE } else { TRIED }.min(counted.len());
        let even = (0..count).map(|k| counted[k * (counted.len() - 1) / count.saturating_sub(1).max(1)]);
        even.chain(worst).collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// Returns the values of γ that are feasible at these `points` of the path. `Err` if there are none.
    fn reached_gammas(
        &self,
        settings: &RedundancySettings,
        machines: &BranchMachines,
        site: &Site,
        points: &[usize],
    ) -> Result<Vec<ReachedGamma>, Failure> {
        let feature = &self.feature;
        let path = self.path_of(points);
        let loads: Vec<_> = points.iter().map(|k| feature.loads[*k]).collect();
        let placement = site.placement(feature.reference);
        let problem = GammaProblem { path: &path, loads: &loads, ..self.gamma_problem(settings, &placement) };
        match reached_gammas(problem, machines, &Work::default()) {
            Ok(Ok(gammas)) => Ok(gammas),
            Ok(Err(dead_end)) => {
                let infeasible = dead_end.infeasible.map_or("no γ before leads to one there", |h| h.text());
                let [x, y, z]: [f64; 3] = path.points()[dead_end.point].position_mm.into();
                let place = format!("feature {}, at ({x:.2}, {y:.2}, {z:.2}) mm of W", feature.name);
                Err(no_gamma(format!("{place}: no rotation about the tool axis goes on: {infeasible}")))
            }
            Err(error) => Err(no_gamma(error.to_string())),
        }
    }

    /// Returns these `points` of the path, in path order.
    fn path_of(&self, points: &[usize]) -> CutPath {
        Toolpath::assemble(points.iter().map(|k| self.feature.path.points()[*k]).collect()).into()
    }

    /// Returns for each of `reached` whether the path begins on the branch of home there, on which it is then cut. Around a limit or singularity it may
    /// begin on another. `Err` if the machine cannot rotate its tool freely.
    fn begin_at_home(
        &self,
        settings: &RedundancySettings,
        site: &Site,
        reached: &[ReachedGamma],
    ) -> Result<Vec<bool>, Failure> {
        let (machine, placement) = (self.machine(), site.placement(self.feature.reference));
        // As walks along the path do.
        let first = self.tried_points()[0];
        let (path, loads) = (self.path_of(&[first]), &self.feature.loads[first..=first]);
        let problem = GammaProblem { path: &path, loads, ..self.gamma_problem(settings, &placement) };
        let gammas: Vec<f64> = reached.iter().map(|own| own.gamma).collect();
        let tasks = first_tasks(problem, &gammas).map_err(|error| no_gamma(error.to_string()))?;
        let blocks: Vec<&[TaskPoint]> = tasks.iter().map(std::slice::from_ref).collect();
        let home = machine.branch_of(&machine.home);
        let is_at_home = |track: Vec<TrackPoint>| {
            let at = track.into_iter().next().and_then(|point| point.at);
            at.is_some_and(|at| machine.branch_of(&at) == home)
        };
        Ok(track_together(machine, &blocks, |_, _| true).into_iter().map(is_at_home).collect())
    }

    /// Returns the path of the feature at `site`, with the platform rotated by `gamma` about the tool axis, rad.
    fn path_at_gamma(&self, site: &Site, gamma: f64) -> Result<Cow<'_, CutPath>, Failure> {
        let placement = site.placement(self.feature.reference);
        let Some(settings) = &self.gamma_search else { return Ok(Cow::Borrowed(&self.feature.path)) };
        let rotated = rotated_by(self.gamma_problem(settings, &placement), gamma);
        rotated.map(Cow::Owned).map_err(|error| no_gamma(error.to_string()))
    }

    /// Returns pose and load at each point of the feature at `site`, with the platform rotated by `gamma` about the tool axis, rad.
    ///
    /// # Errors
    /// The machine cannot rotate its tool freely.
    pub fn tasks_at_gamma(&self, site: &Site, gamma: f64) -> Result<Vec<TaskPoint>, Failure> {
        let (path, placement) = (self.path_at_gamma(site, gamma)?, site.placement(self.feature.reference));
        Ok(tasks_under(self.machine(), &placement, self.target, &path, &self.feature.loads))
    }
}

/// A γ at which a feature may be cut at a place, and what is known of it so far.
#[derive(Debug)]
struct Candidate {
    /// The γ, rad.
    gamma: f64,
    /// Pose and load at each point, once they are asked for.
    tasks: Vec<TaskPoint>,
    /// Of the levels that are solved.
    tally: Tally,
    /// Their number.
    levels: usize,
    /// What the objective is at least.
    bound: f64,
}

/// What a step of the search for γ found: a tighter bound, that it leads P out of the workspace box, or what all points tell, once all is checked.
enum Step {
    Bounded,
    Outside,
    Judged(Box<JudgedGamma>),
}

/// Returns the failure that no γ is possible, for this `reason`.
fn no_gamma(reason: String) -> Failure {
    Failure { status: "no_turn".into(), reason }
}

impl Evaluator {
    /// Returns `site` with the best γ of each feature there; as programmed where none is sought or possible.
    pub(super) fn setup(&self, site: &Site) -> Setup {
        Setup { site: *site, gammas: (0..self.features.len()).map(|f| self.gamma_at(site, f)?.ok()).collect() }
    }

    /// Returns pose and load at each point of feature `f` at `setup`; not kept, as a sweep has too many places.
    pub(super) fn tasks(&self, setup: &Setup, f: usize) -> Vec<TaskPoint> {
        let job = &self.study.features[f];
        let placement = setup.site.placement(job.feature.reference);
        tasks_under(job.machine(), &placement, job.target, &self.path_at(setup, f), &job.feature.loads)
    }

    /// Returns the path of feature `f` at `setup`.
    pub(super) fn path_at(&self, setup: &Setup, f: usize) -> Cow<'_, CutPath> {
        let job = &self.study.features[f];
        let found = setup.gammas[f].and_then(|gamma| job.path_at_gamma(&setup.site, gamma).ok());
        found.unwrap_or(Cow::Borrowed(&job.feature.path))
    }

    /// Returns the best constant γ of feature `f` at `site`, rad, within the workspace box if possible; `None` if none is sought. The inner
    /// `Err` says why it can be cut at no γ.
    pub fn gamma_at(&self, site: &Site, f: usize) -> Option<Result<f64, Failure>> {
        if let Some(seeker) = &self.seeker {
            return seeker.gamma_at(site, f);
        }
        let job = &self.study.features[f];
        let settings = job.gamma_search.as_ref().filter(|own| own.is_sought())?;
        let key = (f, site.0.map(f64::to_bits));
        let known = self.gammas.found().get(&key).cloned();
        if let Some(known) = known {
            return Some(known.map(|own| own.gamma));
        }
        let found = self.candidates(settings, site, f).and_then(|candidates| self.best_gamma(candidates, site, f));
        self.gammas.found().insert(key, found.clone());
        Some(found.map(|own| own.gamma))
    }

    /// Returns the tally of all points of feature `f` at `setup` at which the tool cuts, if the search for its γ computed it.
    pub(super) fn judged_tally(&self, setup: &Setup, f: usize) -> Option<Tally> {
        let gamma = setup.gammas[f]?;
        match self.gammas.found().get(&(f, setup.site.0.map(f64::to_bits)))? {
            Ok(judged) if judged.gamma == gamma => Some(judged.tally),
            _ => None,
        }
    }

    /// Returns the values of γ of feature `f` to try at `site`. `Err` if there are none.
    fn candidates(&self, settings: &RedundancySettings, site: &Site, f: usize) -> Result<Vec<Candidate>, Failure> {
        let (prepared, job) = (&self.features[f], &self.study.features[f]);
        let machines = prepared.branches.as_ref().map_err(|problem| no_gamma(problem.clone()))?;
        let points = job.tried_points();
        // With play, sides may be others along the path.
        let tells = settings.cost == RedundancyCost::Deflection && !has_play(prepared.machines.actual(Source::All));
        let candidate = |(reached, begins_at_home): (ReachedGamma, bool)| {
            // As it is printed.
            let rounded = (10.0 * reached.gamma.to_degrees()).round() / 10.0;
            let [low, high] = settings.range_deg;
            let gamma = if (low..=high).contains(&rounded) { rounded.to_radians() } else { reached.gamma };
            let mut tally = Tally::default();
            for (&k, cost_mm) in points.iter().zip(&reached.costs_mm) {
                let values = PointValues { deflection: cost_mm * (1.0 - ROUNDING), ..PointValues::default() };
                tally.add(&values, prepared.shares[k], job.feature.tolerance_mm);
            }
            let is_known = tells && reached.is_at_home && begins_at_home && gamma == reached.gamma;
            let bound = if is_known { self.least_value(&tally, f) } else { f64::NEG_INFINITY };
            Candidate { gamma, tasks: Vec::new(), tally: Tally::default(), levels: 0, bound }
        };
        let reached = job.reached_gammas(settings, machines, site, &points)?;
        let begin_at_home =
            if tells { job.begin_at_home(settings, site, &reached)? } else { vec![false; reached.len()] };
        Ok(reached.into_iter().zip(begin_at_home).map(candidate).collect())
    }

    /// Returns what the objective of feature `f` alone is at least, as a `tally` of some of its points tells.
    fn least_value(&self, tally: &Tally, f: usize) -> f64 {
        let (objective, metrics) = (&self.study.objective, self.best_possible_of(tally, self.features[f].share));
        match objective.metrics().iter().all(|metric| metrics.get(*metric).is_some()) {
            true => objective.value(&metrics),
            false => f64::NEG_INFINITY,
        }
    }

    /// Returns which of the `open` values of γ, rad, has the least objective, first of those that keep the workspace box. `Err` if it can be cut at
    /// none.
    fn best_gamma(&self, mut open: Vec<Candidate>, site: &Site, f: usize) -> Result<JudgedGamma, Failure> {
        let mut outside = Vec::new();
        let mut failed = None;
        for keeps_box in [true, false] {
            let mut best: Option<JudgedGamma> = None;
            // Of equal bounds the smallest γ.
            let key = |own: &Candidate| [own.bound, own.gamma.abs(), own.gamma];
            let by_key = |a: &Candidate, b: &Candidate| key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal);
            while let Some(next) = (0..open.len()).min_by(|&a, &b| by_key(&open[a], &open[b])) {
                if best.is_some_and(|least| open[next].bound >= least.value + SAME) {
                    break;
                }
                let mut candidate = open.swap_remove(next);
                match self.step_candidate(&mut candidate, site, f, keeps_box) {
                    Ok(Step::Bounded) => open.push(candidate),
                    Ok(Step::Outside) => outside.push(candidate),
                    Ok(Step::Judged(own)) => {
                        let is_better = best.is_none_or(|least| match (own.value - least.value).abs() <= SAME {
                            true => own.gamma.abs() < least.gamma.abs(),
                            false => own.value < least.value,
                        });
                        if is_better {
                            best = Some(*own);
                        }
                    }
                    Err(failure) => failed = failed.or(Some((candidate.gamma, failure))),
                }
            }
            if let Some(best) = best {
                return Ok(best);
            }
            open = std::mem::take(&mut outside);
        }
        let Some((gamma, Failure { status, reason })) = failed else { return Err(no_gamma("there is no γ".into())) };
        let reason = format!("{reason} (at γ = {:.0}°; at no other γ can it be cut either)", gamma.to_degrees());
        Err(Failure { status, reason })
    }

    /// Solves the next level of a candidate, or judges it once all are solved. `Err` says why feature `f` cannot be cut so.
    fn step_candidate(&self, own: &mut Candidate, site: &Site, f: usize, keeps_box: bool) -> Result<Step, Failure> {
        let (prepared, job) = (&self.features[f], &self.study.features[f]);
        if own.tasks.is_empty() {
            own.tasks = job.tasks_at_gamma(site, own.gamma)?;
            if keeps_box && self.check_feature_workspace(f, &own.tasks).is_err() {
                return Ok(Step::Outside);
            }
        }
        let Some(level) = prepared.levels.get(own.levels) else {
            // The only level is all points in the order of the path.
            let is_known = prepared.levels.len() == 1 && self.exact == ExactMode::NotAsked;
            let (tally, value) = self.judge((site, f), &own.tasks, is_known.then_some(own.tally))?;
            return Ok(Step::Judged(Box::new(JudgedGamma { gamma: own.gamma, tally, value })));
        };
        let solved = self.solve_plain_points_of((site, f), &own.tasks, level).map_err(|(_, failure)| failure)?;
        for (values, &k) in solved.iter().zip(level) {
            own.tally.add(values, prepared.shares[k], job.feature.tolerance_mm);
        }
        own.levels += 1;
        own.bound = own.bound.max(self.least_value(&own.tally, f));
        Ok(Step::Bounded)
    }

    /// Returns the tally of a feature `at` a place, unless it is `known`, and the objective of it alone, as a place is judged. `Err` says why it cannot be cut.
    fn judge(&self, at: (&Site, usize), tasks: &[TaskPoint], known: Option<Tally>) -> Result<(Tally, f64), Failure> {
        let ((site, f), prepared, job) = (at, &self.features[at.1], &self.study.features[at.1]);
        let points = job.feature.path.points();
        let mut before: Option<(usize, Configuration)> = None;
        track_feature(
            job,
            tasks,
            |_| true,
            |k, at| {
                let from = before.as_ref().map(|(last, from)| (&points[*last], from));
                let infeasible = job
                    .gamma_search
                    .as_ref()
                    .and_then(|settings| infeasible_step(settings, job.machine(), from, (&points[k], at)));
                // Between few points there are others.
                before = job.worst.is_none().then(|| (k, at.clone()));
                infeasible.map_or(Ok(()), |why| Err(at_path_point(job, k, no_gamma(why.into()))))
            },
        )?;
        let least_clearance = self.check_bodies_along(f, site, tasks)?;
        let in_path_order = || {
            let solved = self.solve_points_of((site, f), tasks, &prepared.counted, &mut None);
            let mut tally = Tally::default();
            for (values, &k) in solved.map_err(|(_, failure)| failure)?.iter().zip(&prepared.counted) {
                tally.add(values, prepared.shares[k], job.feature.tolerance_mm);
            }
            Ok::<Tally, Failure>(tally)
        };
        let tally = known.map_or_else(in_path_order, Ok)?;
        let mut metrics = self.best_possible_of(&tally, prepared.share).with_clearance(least_clearance);
        if self.needs.bounded {
            match prepared.limited_residuals(job, tasks) {
                Ok(corrected) => corrected.normalised(prepared.share).write_into(&mut metrics),
                Err(reason) if self.asks_bounded => return Err(Failure { status: "limits".into(), reason }),
                Err(_) => ResidualTally::remove_from(&mut metrics),
            }
        }
        Ok((tally, self.study.objective.value(&metrics)))
    }
}
