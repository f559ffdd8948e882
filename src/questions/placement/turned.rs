//! The turn about the tool's axis at a place: where the process of a feature seeks it, every place is judged at the constant turn that is
//! best there.
//!
//! The turn is that of a lattice at which the feature can be cut (workspace box, travel of the corrected drives, force limits and all else
//! that a place is judged by) and the objective of the placement is least. Turns are tried in the order of what they leave at some points
//! of the path; one whose best possible objective is no less than what another has is given up. It is a function of the place alone, so
//! bounds on part of the points stay bounds.

use std::{
    collections::HashMap,
    sync::{Mutex, PoisonError},
};

use super::{
    Evaluator, FeatureJob, Site,
    evaluate::{located, track},
    tally::{Corrected, Tally},
};
use crate::{
    compensation::TaskPoint,
    input::error::Error,
    machine::Configuration,
    process::{Placement, RedundancySettings},
    redundancy::{TurnAsked, infeasible_turns, turned_by, turns_by_cost},
    simulation::{Failure, tasks::tasks_under},
    toolpath::{PathPoint, Toolpath},
    work::Work,
};

/// Points at which turns are tried.
const TRIED: usize = 24;
/// Objectives that differ by no more are the same: the turn nearest to as programmed is taken.
const SAME: f64 = 1e-9;

/// A place of a feature: its index and the coordinates.
type Key = (usize, [u64; 6]);

/// Turns found so far, rad.
#[derive(Debug, Default)]
pub(super) struct TurnsFound(Mutex<HashMap<Key, Result<f64, Failure>>>);

impl FeatureJob {
    /// Whether the machine can turn its tool freely, if a turn is sought.
    ///
    /// # Errors
    /// Why it cannot.
    pub(super) fn check_turn(&self) -> Result<(), Error> {
        let Some(turn) = &self.turn else { return Ok(()) };
        let placement = Placement { reference: self.feature.reference, ..Placement::default() };
        turned_by(self.asked(turn, &placement), 0.0).map(drop)
    }

    fn asked<'a>(&'a self, turn: &'a RedundancySettings, placement: &'a Placement) -> TurnAsked<'a> {
        TurnAsked {
            machine: self.machine(),
            errors: &self.errors,
            placement,
            target: self.target,
            path: &self.feature.path,
            loads: &self.feature.loads,
            turn,
        }
    }

    /// Turns of this feature at `site`, rad, that points of its path allow, evenly chosen among those at which the tool cuts: those
    /// that leave the loaded tool nearest to them first.
    fn turns(&self, turn: &RedundancySettings, site: &Site) -> Result<Vec<f64>, Failure> {
        let feature = &self.feature;
        let points = feature.path.points();
        let cuts = |point: &PathPoint| point.cutting;
        let counted: Vec<usize> = match points.iter().any(cuts) {
            true => (0..points.len()).filter(|k| cuts(&points[*k])).collect(),
            false => (0..points.len()).collect(),
        };
        let tried = TRIED.min(counted.len());
        let chosen: Vec<usize> =
            (0..tried).map(|k| counted[k * (counted.len() - 1) / tried.saturating_sub(1).max(1)]).collect();
        let path = Toolpath::assemble(chosen.iter().map(|k| points[*k]).collect());
        let loads: Vec<_> = chosen.iter().map(|k| feature.loads[*k]).collect();
        let placement = site.placement(feature.reference);
        let asked = TurnAsked { path: &path, loads: &loads, ..self.asked(turn, &placement) };
        match turns_by_cost(asked, &Work::default()) {
            Ok(Ok(turns)) => Ok(turns),
            Ok(Err(dead_end)) => {
                let infeasible = dead_end.infeasible.map_or("the γ before it lead to none there", |h| h.words());
                let [x, y, z]: [f64; 3] = path.points()[dead_end.point].position_mm.into();
                let place = format!("feature {}, at ({x:.2}, {y:.2}, {z:.2}) mm of W", feature.name);
                Err(no_turn(format!("{place}: no rotation about the tool axis goes on: {infeasible}")))
            }
            Err(error) => Err(no_turn(error.to_string())),
        }
    }

    /// What is wanted at each point of the feature at `site`, the platform turned by `turn`, rad.
    ///
    /// # Errors
    /// Why it cannot be turned.
    pub(super) fn tasks_turned(&self, site: &Site, turn: f64) -> Result<Vec<TaskPoint>, Failure> {
        let feature = &self.feature;
        let placement = site.placement(feature.reference);
        let path = match &self.turn {
            Some(asked) => {
                &turned_by(self.asked(asked, &placement), turn).map_err(|error| no_turn(error.to_string()))?
            }
            None => &feature.path,
        };
        Ok(tasks_under(self.machine(), &placement, self.target, path, &feature.loads))
    }
}

fn no_turn(reason: String) -> Failure {
    Failure { status: "no_turn".into(), reason }
}

impl Evaluator {
    /// What is wanted at each point of feature `f` at `site`, turned as is best there; `None` if no turn is sought or possible.
    pub(super) fn tasks_at_best_turn(&self, site: &Site, f: usize) -> Option<Vec<TaskPoint>> {
        let turn = self.turn_at(site, f)?.ok()?;
        self.study.features[f].tasks_turned(site, turn).ok()
    }

    /// The turn of feature `f` at `site`, rad: the constant one at which it can be cut there and the objective, of this feature alone, is
    /// least. Where there is none, the best of those that leave the workspace box. `None` if none is sought.
    ///
    /// # Errors
    /// Why it can be cut at no turn.
    pub fn turn_at(&self, site: &Site, f: usize) -> Option<Result<f64, Failure>> {
        let job = &self.study.features[f];
        let turn = job.turn.as_ref()?;
        let key = (f, site.0.map(f64::to_bits));
        let known = self.turns.0.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
        if known.is_some() {
            return known;
        }
        let found = job.turns(turn, site).and_then(|turns| self.best_of(&turns, site, f));
        self.turns.0.lock().unwrap_or_else(PoisonError::into_inner).insert(key, found.clone());
        Some(found)
    }

    fn best_of(&self, turns: &[f64], site: &Site, f: usize) -> Result<f64, Failure> {
        let job = &self.study.features[f];
        let tasks = |turn: &f64| job.tasks_turned(site, *turn).map(|tasks| (*turn, tasks));
        let all: Vec<(f64, Vec<TaskPoint>)> = turns.iter().map(tasks).collect::<Result<_, _>>()?;
        let (within, outside): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|(_, tasks)| self.check_within(f, tasks).is_ok());
        let mut refused = None;
        for turns in [within, outside] {
            let mut best: Option<(f64, f64)> = None;
            for (turn, tasks) in turns {
                match self.value_turned(site, f, &tasks, best.map_or(f64::INFINITY, |(value, _)| value + SAME)) {
                    Ok(Some(value)) => {
                        let is_better = best.is_none_or(|(least, of)| match (value - least).abs() <= SAME {
                            true => turn.abs() < of.abs(),
                            false => value < least,
                        });
                        best = if is_better { Some((value, turn)) } else { best };
                    }
                    Ok(None) => {}
                    Err(failure) => refused = refused.or(Some((turn, failure))),
                }
            }
            if let Some((_, turn)) = best {
                return Ok(turn);
            }
        }
        let (turn, Failure { status, reason }) = refused.unwrap_or_else(|| (0.0, no_turn("there is no γ".into())));
        let reason = format!("{reason} (at γ = {:.0}°; at no other γ can it be cut either)", turn.to_degrees());
        Err(Failure { status, reason })
    }

    /// The objective of feature `f` alone at `site`; `None` if it is not less than `below`.
    ///
    /// # Errors
    /// Why it cannot be cut there.
    fn value_turned(&self, site: &Site, f: usize, tasks: &[TaskPoint], below: f64) -> Result<Option<f64>, Failure> {
        let (prepared, job) = (&self.features[f], &self.study.features[f]);
        let (points, objective) = (job.feature.path.points(), &self.study.objective);
        let mut tally = Tally::default();
        for level in &prepared.levels {
            let mut walk = self.walk(f);
            for &k in level {
                let seen = self.seen(site, job, (k, &tasks[k]), &mut walk)?;
                tally.add(&seen, prepared.shares[k], job.feature.tolerance_mm);
                if below.is_finite() && objective.value(&self.at_best(&tally, prepared.share)) >= below {
                    return Ok(None);
                }
            }
        }
        let mut before: Option<(usize, Configuration)> = None;
        track(
            job,
            tasks,
            |_| true,
            |k, at| {
                let from = before.as_ref().map(|(last, from)| (&points[*last], from));
                let infeasible =
                    job.turn.as_ref().and_then(|turn| infeasible_turns(turn, job.machine(), from, (&points[k], at)));
                before = Some((k, at.clone()));
                infeasible.map_or(Ok(()), |why| Err(located(job, k, no_turn(why.into()))))
            },
        )?;
        // As a place is judged: in the order of the path.
        let (mut walk, mut tally) = (self.walk(f), Tally::default());
        for &k in &prepared.counted {
            let seen = self.seen(site, job, (k, &tasks[k]), &mut walk)?;
            tally.add(&seen, prepared.shares[k], job.feature.tolerance_mm);
        }
        let mut metrics = self.at_best(&tally, prepared.share);
        if self.needs.bounded {
            match prepared.corrected(job, tasks) {
                Ok(corrected) => corrected.normalised(prepared.share).enter(&mut metrics),
                Err(reason) if self.asks_bounded => return Err(Failure { status: "limits".into(), reason }),
                Err(_) => Corrected::forget(&mut metrics),
            }
        }
        let value = objective.value(&metrics);
        Ok((below == f64::INFINITY || value < below).then_some(value))
    }
}
