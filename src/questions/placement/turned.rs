//! Search for the constant γ, the rotation about the tool axis, that is best for each feature at each place.
//!
//! That γ is the one of a lattice at which the feature can be cut (workspace box, travel of the corrected drives, force limits and all else
//! that a place is judged by) and the objective of the placement is least. Values of γ are tried in the order of the residual errors at
//! some points of the path; one whose best possible objective is no less than the best so far is pruned. The result depends on the place
//! alone, so bounds from part of the points stay bounds.

use std::{
    borrow::Cow,
    collections::HashMap,
    sync::{Mutex, PoisonError},
};

use super::{
    Evaluator, FeatureJob, Site,
    evaluate::{at_path_point, track_feature},
    tally::{ResidualTally, Tally},
};
use crate::{
    compensation::TaskPoint,
    input::error::Error,
    machine::Configuration,
    process::{CutPath, Placement, RedundancySettings},
    redundancy::{BranchMachines, GammaProblem, gammas_by_cost, infeasible_step, rotated_by},
    simulation::{Failure, tasks::tasks_under},
    toolpath::{PathPoint, Toolpath},
    work::Work,
};

/// Number of points at which values of γ are compared first.
const TRIED: usize = 24;
/// Largest difference between objectives that count as the same: the γ nearest to the programmed one is taken.
const SAME: f64 = 1e-9;

/// Index of a feature, and the coordinates of its place.
type Key = (usize, [u64; 6]);

/// Best γ of each feature and place found so far, rad.
#[derive(Debug, Default)]
pub(super) struct GammaCache(Mutex<HashMap<Key, Result<f64, Failure>>>);

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

    /// Returns the values of γ, rad, feasible at [`TRIED`] points of the path, the smallest residual error first. `Err` if there are none.
    fn feasible_gammas(
        &self,
        settings: &RedundancySettings,
        machines: &BranchMachines,
        site: &Site,
    ) -> Result<Vec<f64>, Failure> {
        let feature = &self.feature;
        let points = feature.path.points();
        let cuts = |point: &PathPoint| point.cutting;
        let counted: Vec<usize> = match points.iter().any(cuts) {
            true => (0..points.len()).filter(|k| cuts(&points[*k])).collect(),
            false => (0..points.len()).collect(),
        };
        let count = TRIED.min(counted.len());
        let chosen: Vec<usize> =
            (0..count).map(|k| counted[k * (counted.len() - 1) / count.saturating_sub(1).max(1)]).collect();
        let path = Toolpath::assemble(chosen.iter().map(|k| points[*k]).collect()).into();
        let loads: Vec<_> = chosen.iter().map(|k| feature.loads[*k]).collect();
        let placement = site.placement(feature.reference);
        let problem = GammaProblem { path: &path, loads: &loads, ..self.gamma_problem(settings, &placement) };
        match gammas_by_cost(problem, machines, &Work::default()) {
            // As γ is printed.
            Ok(Ok(gammas)) => Ok(gammas
                .into_iter()
                .map(|gamma| {
                    let rounded = (10.0 * gamma.to_degrees()).round() / 10.0;
                    let [low, high] = settings.range_deg;
                    if (low..=high).contains(&rounded) { rounded.to_radians() } else { gamma }
                })
                .collect()),
            Ok(Err(dead_end)) => {
                let infeasible = dead_end.infeasible.map_or("no γ before leads to one there", |h| h.text());
                let [x, y, z]: [f64; 3] = path.points()[dead_end.point].position_mm.into();
                let place = format!("feature {}, at ({x:.2}, {y:.2}, {z:.2}) mm of W", feature.name);
                Err(no_gamma(format!("{place}: no rotation about the tool axis goes on: {infeasible}")))
            }
            Err(error) => Err(no_gamma(error.to_string())),
        }
    }

    /// Returns the path of the feature at `site`, with the platform rotated by `gamma` about the tool axis, rad.
    fn path_at_gamma(&self, site: &Site, gamma: f64) -> Result<Cow<'_, CutPath>, Failure> {
        let placement = site.placement(self.feature.reference);
        let Some(settings) = &self.gamma_search else { return Ok(Cow::Borrowed(&self.feature.path)) };
        let rotated = rotated_by(self.gamma_problem(settings, &placement), gamma);
        rotated.map(Cow::Owned).map_err(|error| no_gamma(error.to_string()))
    }

    /// Returns pose and load at each point of the feature at `site`, with the platform rotated by `gamma` about the tool axis, rad.
    pub(super) fn tasks_at_gamma(&self, site: &Site, gamma: f64) -> Result<Vec<TaskPoint>, Failure> {
        let (path, placement) = (self.path_at_gamma(site, gamma)?, site.placement(self.feature.reference));
        Ok(tasks_under(self.machine(), &placement, self.target, &path, &self.feature.loads))
    }
}

/// Returns the failure that no γ is possible, for this `reason`.
fn no_gamma(reason: String) -> Failure {
    Failure { status: "no_turn".into(), reason }
}

impl Evaluator {
    /// Returns pose and load at each point of feature `f` at `site` at the best γ; `None` if none is sought or possible.
    pub(super) fn tasks_at_best_gamma(&self, site: &Site, f: usize) -> Option<Vec<TaskPoint>> {
        let gamma = self.gamma_at(site, f)?.ok()?;
        self.study.features[f].tasks_at_gamma(site, gamma).ok()
    }

    /// Returns the path of feature `f` at `site` at the best γ; as programmed if none is sought or possible.
    pub(super) fn path_at_best_gamma(&self, site: &Site, f: usize) -> Cow<'_, CutPath> {
        let job = &self.study.features[f];
        let found = self.gamma_at(site, f).and_then(|gamma| job.path_at_gamma(site, gamma.ok()?).ok());
        found.unwrap_or(Cow::Borrowed(&job.feature.path))
    }

    /// Returns the best constant γ of feature `f` at `site`, rad, within the workspace box if possible; `None` if none is sought. The inner
    /// `Err` says why it can be cut at no γ.
    pub fn gamma_at(&self, site: &Site, f: usize) -> Option<Result<f64, Failure>> {
        let job = &self.study.features[f];
        let settings = job.gamma_search.as_ref().filter(|own| own.is_sought())?;
        let key = (f, site.0.map(f64::to_bits));
        let known = self.gammas.0.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if known.is_some() {
            return known;
        }
        let gammas = self.feasible_gammas(settings, site, f);
        let found = gammas.and_then(|gammas| self.best_gamma(&gammas, site, f));
        self.gammas.0.lock().unwrap_or_else(PoisonError::into_inner).insert(key, found.clone());
        Some(found)
    }

    /// Returns the values of γ of feature `f` at `site` to try, rad, as [`FeatureJob::feasible_gammas`].
    fn feasible_gammas(&self, settings: &RedundancySettings, site: &Site, f: usize) -> Result<Vec<f64>, Failure> {
        let machines = self.features[f].branches.as_ref().map_err(|problem| no_gamma(problem.clone()))?;
        self.study.features[f].feasible_gammas(settings, machines, site)
    }

    /// Returns whether the objective of the study may be less than `below` at `site`: false where it is not at any γ, with the workpiece exactly
    /// there, which only bounds find faster than the best γ.
    pub(super) fn may_be_below(&self, site: &Site, below: f64) -> bool {
        // The objective of all features is not known from that of each.
        let ([job], true) = (&self.study.features[..], below.is_finite()) else { return true };
        let Some(settings) = job.gamma_search.as_ref().filter(|own| own.is_sought()) else { return true };
        let Ok(gammas) = self.feasible_gammas(settings, site, 0) else { return false };
        gammas.iter().any(|gamma| {
            let Ok(tasks) = job.tasks_at_gamma(site, *gamma) else { return false };
            let is_within = self.check_feature_workspace(0, &tasks).is_ok();
            is_within && matches!(self.value_at_gamma(site, 0, &tasks, below), Ok(Some(_)))
        })
    }

    /// Returns which of `gammas`, rad, has the least objective, first of those that keep the workspace box. `Err` if it can be cut at none.
    fn best_gamma(&self, gammas: &[f64], site: &Site, f: usize) -> Result<f64, Failure> {
        let job = &self.study.features[f];
        let tasks = |gamma: &f64| job.tasks_at_gamma(site, *gamma).map(|tasks| (*gamma, tasks));
        let candidates: Vec<(f64, Vec<TaskPoint>)> = gammas.iter().map(tasks).collect::<Result<_, _>>()?;
        let (within, outside): (Vec<_>, Vec<_>) =
            candidates.into_iter().partition(|(_, tasks)| self.check_feature_workspace(f, tasks).is_ok());
        let mut failed = None;
        for gammas in [within, outside] {
            let mut best: Option<(f64, f64)> = None;
            for (gamma, tasks) in gammas {
                match self.value_at_gamma(site, f, &tasks, best.map_or(f64::INFINITY, |(value, _)| value + SAME)) {
                    Ok(Some(value)) => {
                        let is_better = best.is_none_or(|(least, least_gamma)| match (value - least).abs() <= SAME {
                            true => gamma.abs() < least_gamma.abs(),
                            false => value < least,
                        });
                        best = if is_better { Some((value, gamma)) } else { best };
                    }
                    Ok(None) => {}
                    Err(failure) => failed = failed.or(Some((gamma, failure))),
                }
            }
            if let Some((_, gamma)) = best {
                return Ok(gamma);
            }
        }
        let (gamma, Failure { status, reason }) = failed.unwrap_or_else(|| (0.0, no_gamma("there is no γ".into())));
        let reason = format!("{reason} (at γ = {:.0}°; at no other γ can it be cut either)", gamma.to_degrees());
        Err(Failure { status, reason })
    }

    /// Returns the objective of feature `f` alone at `site`; `None` if it is not less than `below`. `Err` says why it cannot be cut.
    fn value_at_gamma(&self, site: &Site, f: usize, tasks: &[TaskPoint], below: f64) -> Result<Option<f64>, Failure> {
        let (prepared, job) = (&self.features[f], &self.study.features[f]);
        let (points, objective) = (job.feature.path.points(), &self.study.objective);
        let mut tally = Tally::default();
        for level in &prepared.levels {
            let mut walk = self.start_walk(f);
            for &k in level {
                let values = self.solve_point(site, job, (k, &tasks[k]), &mut walk)?;
                tally.add(&values, prepared.shares[k], job.feature.tolerance_mm);
                if below.is_finite() && objective.value(&self.best_possible_of(&tally, prepared.share)) >= below {
                    return Ok(None);
                }
            }
        }
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
                before = Some((k, at.clone()));
                infeasible.map_or(Ok(()), |why| Err(at_path_point(job, k, no_gamma(why.into()))))
            },
        )?;
        self.check_bodies_along(f, site, tasks)?;
        // As a place is judged: in the order of the path.
        let (mut walk, mut tally) = (self.start_walk(f), Tally::default());
        for &k in &prepared.counted {
            let values = self.solve_point(site, job, (k, &tasks[k]), &mut walk)?;
            tally.add(&values, prepared.shares[k], job.feature.tolerance_mm);
        }
        let mut metrics = self.best_possible_of(&tally, prepared.share);
        if self.needs.bounded {
            match prepared.limited_residuals(job, tasks) {
                Ok(corrected) => corrected.normalised(prepared.share).write_into(&mut metrics),
                Err(reason) if self.asks_bounded => return Err(Failure { status: "limits".into(), reason }),
                Err(_) => ResidualTally::remove_from(&mut metrics),
            }
        }
        let value = objective.value(&metrics);
        Ok((below == f64::INFINITY || value < below).then_some(value))
    }
}
