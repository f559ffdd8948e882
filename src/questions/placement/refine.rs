//! Refinement by Nelder–Mead from the best places of a sweep and from named ones.
//!
//! Nelder–Mead knows no bounds. Each free coordinate is therefore `x = middle + half range · sin u` with u free: every u is within the
//! bounds, an optimum at a bound is an ordinary one (u = π/2), and no evaluation is spent outside. On a test function with its optimum at a
//! bound this took a third fewer evaluations than an infinite wall. An angle that may make a full turn is its own u and wraps around. An
//! infeasible place has an infinite cost, from which Nelder–Mead steps back.
//!
//! A simplex can become small before its place is right. Each search is therefore restarted, smaller, around its result until that gains
//! less than the tolerance. One that has used up its iterations continues from where it ended. The ends that may be the best place are then
//! polished ([`super::polish`]).

use std::{
    f64::consts::TAU,
    sync::{Arc, Mutex},
};

use argmin::{
    core::{
        CostFunction, Error, Executor, IterState, KV, State, TerminationReason, TerminationStatus, observers::Observe,
        observers::ObserverMode,
    },
    solver::neldermead::NelderMead,
};
use rayon::prelude::*;

use serde::{Deserialize, Serialize};

use super::{
    PlacementStudy,
    evaluate::Evaluator,
    few::Glimpse,
    first_distinct,
    metric::{Metrics, Objective},
    polish::Steps,
    site::{Bounds, Site},
};
use crate::{
    input::error,
    work::{Event, Stage, Work},
};

/// Kind of place that a refinement starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Start {
    /// One of the best places of the sweep.
    Sweep,
    /// The named place of this index.
    Named(usize),
    /// A place found between the grid points of the sweep.
    Between,
}

/// Result of one refinement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Refinement {
    /// Kind of place that it started from.
    pub from: Start,
    /// Place where it started.
    pub start: Site,
    /// Place where it ended.
    pub site: Site,
    /// Objective at its end.
    pub value: f64,
    /// Metrics at its end, those that the objective needs.
    pub metrics: Metrics,
    /// Number of iterations of Nelder–Mead.
    pub iterations: usize,
    /// Number of searches that used up their iterations and continued from where they ended.
    pub continued: usize,
    /// Whether the last search met the tolerance.
    pub is_converged: bool,
    /// Best objective after each iteration.
    pub history: Vec<f64>,
    /// Every place evaluated that can be cut.
    pub visited: Vec<(Site, Metrics)>,
    /// Places at which only some points or corners were looked at, with bounds of their metrics, where a front may need them.
    pub(super) glimpsed: Vec<(Site, Metrics)>,
}

/// Size of the first simplex, as a share of a step of the grid along each coordinate.
const FIRST_SIZE: f64 = 0.5;
/// Factor on the size of the simplex of each restarted search.
const SHRINK: f64 = 0.2;
/// Smallest objective relative to which the tolerance is taken.
const SMALLEST: f64 = 1e-12;
/// Largest number of searches from one start that met the tolerance: polishing gains for less what a third would.
const ROUNDS: usize = 2;
/// Largest number of searches from one start that used up their iterations.
const CONTINUATIONS: usize = 5;
/// Share of the best value within which ends are polished, as the best place is among them.
const CONTENDS: f64 = 0.02;
/// Largest number of ends that are polished.
const POLISHED: usize = 2;
/// Steps of the pattern search that polishes an end.
const POLISH: Steps = Steps { first: 0.1, last: 5e-4, bases: 0 };

/// Refines each of `starts`, in their order, and polishes the best ends. `Err` only from `work`.
pub(super) fn refine(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    objective: &Objective,
    starts: &[(Start, Site)],
    work: &Work,
) -> error::Result<Vec<Refinement>> {
    let run = |(number, (from, start)): (usize, &(Start, Site))| {
        let search = RefinementSearch { evaluator, study, objective, work: &work.shard(number) };
        let refinement = search.run(*from, *start);
        search.tell(Event::Computed(1));
        refinement
    };
    work.summary("refinements", || {
        let mut refinements: Vec<Refinement> =
            work.summary("searches", || Ok(starts.par_iter().enumerate().filter_map(run).collect()))?;
        work.barrier()?;
        // The ends of a front are polished with the rest of it.
        let is_sought = *objective == study.objective;
        let contenders = if is_sought { contenders(study, &refinements) } else { Vec::new() };
        if is_sought {
            work.tell(Event::Stage(Stage { of: "best ends polished", items: contenders.len() }));
        }
        refinements.par_iter_mut().enumerate().for_each(|(index, found)| {
            if let Some(rank) = contenders.iter().position(|contender| *contender == index) {
                RefinementSearch { evaluator, study, objective, work: &work.shard(rank) }.polish(found);
                work.tell(Event::Computed(1));
            }
        });
        work.barrier()?;
        Ok(refinements)
    })
}

/// Returns the indices of the refinements that may end at or next to the best place, at most [`POLISHED`], no two at the same place.
fn contenders(study: &PlacementStudy, refinements: &[Refinement]) -> Vec<usize> {
    let mut sorted: Vec<usize> = (0..refinements.len()).collect();
    sorted.sort_by(|&a, &b| refinements[a].value.total_cmp(&refinements[b].value).then(a.cmp(&b)));
    let Some(best) = sorted.first().map(|&index| refinements[index].value) else { return sorted };
    sorted.retain(|&index| refinements[index].value - best <= CONTENDS * best.abs());
    first_distinct(sorted, POLISHED, |&a, &b| study.is_same_place(&refinements[a].site, &refinements[b].site))
}

/// One search, for one objective.
struct RefinementSearch<'a> {
    evaluator: &'a Evaluator,
    study: &'a PlacementStudy,
    objective: &'a Objective,
    work: &'a Work,
}

impl RefinementSearch<'_> {
    /// Refines the place `start`, found as `from` says, by Nelder–Mead searches, restarted while they gain; `None` if it cannot be cut.
    fn run(&self, from: Start, start: Site) -> Option<Refinement> {
        let free = self.study.bounds.free();
        let settings = &self.study.search;
        let value_of = |metrics: &Metrics| self.objective.value(metrics);
        let visited = Mutex::new(Vec::new());
        let history = Arc::new(Mutex::new(Vec::new()));
        let glimpsed = Mutex::new(Vec::new());
        let mut cost = Cost {
            search: self,
            free: &free,
            fixed: start,
            glimpse: Glimpse::new(self.evaluator, self.work, &start, &value_of),
            visited: &visited,
            glimpsed: &glimpsed,
        };
        let mut best = (start, cost.record_value(&start));
        let tolerance = settings.tolerance * best.1.abs().max(SMALLEST);
        let (mut size, mut rounds, mut continued) = (FIRST_SIZE, 0, 0);
        let mut is_converged = free.is_empty();
        while !is_converged && best.1.is_finite() && rounds < ROUNDS && continued < CONTINUATIONS {
            let before = best.1;
            let known = history.lock().map_or(0, |history| history.len());
            let (end, is_ended_by_count) = cost.descend(best, size, tolerance, settings.max_iterations, &history)?;
            let is_exact = cost.settle(end, &mut best, tolerance);
            if let Ok(mut history) = history.lock() {
                history[known..].iter_mut().for_each(|value| *value = value.max(best.1));
            }
            self.tell(Event::Best(best.1));
            if !is_exact {
                continue;
            }
            if is_ended_by_count {
                continued += 1;
                continue;
            }
            rounds += 1;
            size *= SHRINK;
            is_converged = before - best.1 <= tolerance;
        }
        // So many searches that met the tolerance are enough, whatever the last one gained.
        is_converged |= rounds == ROUNDS;
        let history = history.lock().map(|history| history.clone()).unwrap_or_default();
        let visited = visited.into_inner().unwrap_or_default();
        let metrics = visited.iter().find(|(site, _): &&(Site, Metrics)| *site == best.0)?.1;
        let iterations = history.len();
        let (site, value) = best;
        let glimpsed = glimpsed.into_inner().unwrap_or_default();
        Some(Refinement {
            from,
            start,
            site,
            value,
            metrics,
            iterations,
            continued,
            is_converged,
            history,
            visited,
            glimpsed,
        })
    }

    /// Improves the end of `refinement` by pattern searches, and records the better places at which they end.
    fn polish(&self, refinement: &mut Refinement) {
        let value_of = |metrics: &Metrics| self.objective.value(metrics);
        let tolerance = self.study.search.tolerance * refinement.value.abs().max(SMALLEST);
        let start = (refinement.site, refinement.value);
        let mut glimpse = Glimpse::new(self.evaluator, self.work, &start.0, &value_of);
        glimpse.polish((self.study, self.work), start, (POLISH, tolerance), |site, value, metrics| {
            (refinement.site, refinement.value, refinement.metrics) = (site, value, metrics);
            refinement.visited.push((site, metrics));
            self.tell(Event::Best(value));
        });
    }

    /// Reports `event` to `work`; best values only if they are of the study's own objective.
    fn tell(&self, event: Event) {
        if *self.objective == self.study.objective || matches!(event, Event::Computed(_)) {
            self.work.tell(event);
        }
    }
}

/// The objective as a function of the free variables u.
struct Cost<'a> {
    search: &'a RefinementSearch<'a>,
    free: &'a [usize],
    fixed: Site,
    /// What a descent looks at, to which what its end asks for is added.
    glimpse: Glimpse<'a>,
    visited: &'a Mutex<Vec<(Site, Metrics)>>,
    glimpsed: &'a Mutex<Vec<(Site, Metrics)>>,
}

impl Cost<'_> {
    /// Returns the bounds of the coordinates.
    fn bounds(&self) -> &Bounds {
        &self.search.study.bounds
    }

    /// Returns the place with the free variables `u`: an angle that may make a full turn, else `middle + half range · sin u`.
    fn site_at(&self, u: &[f64]) -> Site {
        let mut site = self.fixed;
        for (&i, u) in self.free.iter().zip(u) {
            let (low, high) = (self.bounds().low[i], self.bounds().high[i]);
            site.0[i] = match self.bounds().is_full_turn(i) {
                true => low + (u - low).rem_euclid(TAU),
                false => (0.5 * (low + high) + 0.5 * (high - low) * libm::sin(*u)).clamp(low, high),
            };
        }
        site
    }

    /// Returns the free variables u of a place, the inverse of [`Cost::site_at`].
    fn variables_at(&self, site: &Site) -> Vec<f64> {
        let variable = |&i: &usize| {
            if self.bounds().is_full_turn(i) {
                return site.0[i];
            }
            let (low, range) = (self.bounds().low[i], self.bounds().range(i));
            libm::asin((2.0 * (site.0[i] - low) / range - 1.0).clamp(-1.0, 1.0))
        };
        self.free.iter().map(variable).collect()
    }

    /// Returns the objective at a place within its whole allowance, and records the place; infinite where it cannot be cut.
    fn record_value(&self, site: &Site) -> f64 {
        match self.glimpse.evaluate(self.search.work, site) {
            Ok(evaluation) => {
                if let Ok(mut visited) = self.visited.lock() {
                    visited.push((*site, evaluation.metrics));
                }
                self.search.objective.value(&evaluation.metrics)
            }
            Err(_) => f64::INFINITY,
        }
    }

    /// Returns the objective at a place as far as the points and corners tell that are looked at; infinite where it cannot be cut.
    fn descent_value(&self, site: &Site) -> f64 {
        if self.glimpse.is_whole() {
            return self.record_value(site);
        }
        let Some(metrics) = self.glimpse.metrics(self.search.work, site) else { return f64::INFINITY };
        if !self.search.study.objective.pareto.is_empty()
            && let Ok(mut glimpsed) = self.glimpsed.lock()
        {
            glimpsed.push((*site, metrics));
        }
        self.search.objective.value(&metrics)
    }

    /// Takes the end of a descent for `best` if it is better at all points within its whole allowance; returns whether the descent saw its
    /// objective. Else what makes it worse is looked at from now on, too: each descent minimises a lower bound that becomes exact where it ends.
    fn settle(&mut self, end: (Site, f64), best: &mut (Site, f64), tolerance: f64) -> bool {
        if self.glimpse.is_whole() {
            *best = end;
            return true;
        }
        let value = if end.0 == best.0 { best.1 } else { self.record_value(&end.0) };
        if value < best.1 {
            *best = (end.0, value);
        }
        self.glimpse.settle(self.search.work, &end.0, end.1, value, tolerance)
    }

    /// Returns the start and, along each free coordinate, a place `size` steps of the grid away, inward at a bound, as variables u.
    fn simplex(&self, start: &Site, size: f64) -> Vec<Vec<f64>> {
        let mut simplex = vec![self.variables_at(start)];
        for &i in self.free {
            let step = size * self.search.study.grid.step(i, self.bounds());
            let is_inside = self.bounds().is_full_turn(i) || start.0[i] + step <= self.bounds().high[i];
            let mut variables = self.variables_at(&self.bounds().moved(start, i, if is_inside { step } else { -step }));
            if let Some(full_turn) = self.free.iter().position(|&other| other == i && self.bounds().is_full_turn(i)) {
                // Not the way round: a simplex has no seam.
                variables[full_turn] = start.0[i] + step;
            }
            simplex.push(variables);
        }
        simplex
    }

    /// Runs one Nelder–Mead search; returns the better of its start and its end, whether iterations were used up; `None` if it fails or is stopped.
    fn descend(
        &self,
        start: (Site, f64),
        size: f64,
        tolerance: f64,
        iterations: usize,
        history: &Arc<Mutex<Vec<f64>>>,
    ) -> Option<((Site, f64), bool)> {
        let solver = NelderMead::new(self.simplex(&start.0, size)).with_sd_tolerance(tolerance);
        // Only where all is looked at, else it is a bound.
        let is_reported = self.glimpse.is_whole() && *self.search.objective == self.search.study.objective;
        let observer =
            Progress { history: Arc::clone(history), best: start.1, work: self.search.work.clone(), is_reported };
        let result = Executor::new(self, solver.ok()?)
            .configure(|state| state.max_iters(iterations as u64))
            .add_observer(observer, ObserverMode::Always)
            .run()
            .ok()?;
        let state = result.state();
        let end = state.get_best_param().map(|u| (self.site_at(u), state.get_best_cost()));
        let is_ended_by_count =
            matches!(state.get_termination_status(), TerminationStatus::Terminated(TerminationReason::MaxItersReached));
        Some((end.filter(|end| end.1 < start.1).unwrap_or(start), is_ended_by_count))
    }
}

impl CostFunction for &Cost<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    /// Returns the objective at the variables `u`.
    fn cost(&self, u: &Self::Param) -> Result<f64, Error> {
        Ok(self.descent_value(&self.site_at(u)))
    }
}

/// Observer that records the best value after each iteration and reports it.
struct Progress {
    history: Arc<Mutex<Vec<f64>>>,
    /// Best value so far, including the searches before.
    best: f64,
    work: Work,
    /// Whether the value belongs to the study's objective and is reported.
    is_reported: bool,
}

impl Observe<IterState<Vec<f64>, (), (), (), (), f64>> for Progress {
    /// Records the best value of an iteration. `Err` if the work was stopped.
    fn observe_iter(&mut self, state: &IterState<Vec<f64>, (), (), (), (), f64>, _: &KV) -> Result<(), Error> {
        self.best = self.best.min(state.get_best_cost());
        if let Ok(mut history) = self.history.lock() {
            history.push(self.best);
        }
        // Not the cost, whose errors the solver unwraps; to it stopped work looks infeasible everywhere.
        self.work.check()?;
        if self.is_reported {
            self.work.tell(Event::Best(self.best));
        }
        Ok(())
    }
}
