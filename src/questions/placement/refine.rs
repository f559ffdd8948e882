//! Nelder–Mead from the best places of a sweep and from named ones.
//!
//! Nelder–Mead knows no bounds. Each free coordinate is therefore `x = middle + half range · sin u` with u free: every u
//! is within the bounds, an optimum at a bound is an ordinary one (u = π/2), and no evaluation is spent outside. On a
//! test function with its optimum at a bound this took a third fewer evaluations than an infinite wall. An angle that may
//! make a full turn is its own u and goes round. An infeasible place costs infinitely much, which Nelder–Mead steps back
//! from.
//!
//! The spread of a simplex can become small before its place is right; each search is therefore started anew, smaller,
//! around what it found, until that gains less than the tolerance. One that has used up its iterations goes on from where
//! it ended. The ends that may be the best place are then polished ([`super::polish`]).

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

use serde::Serialize;

use super::{
    PlacementStudy,
    evaluate::Evaluator,
    metric::{Metrics, Objective},
    polish::{Steps, polish},
    site::{Bounds, Site},
};
use crate::{
    input::error,
    work::{Event, Work},
};

/// What kind of place a refinement starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Start {
    /// One of the best places of the sweep.
    Sweep,
    /// The named place of this index.
    Named(usize),
    /// A place between those of the sweep, found because the workpiece fits in few of them.
    Between,
}

/// One refinement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refinement {
    /// What it started from.
    pub from: Start,
    /// Where it started.
    pub start: Site,
    /// Where it ended.
    pub site: Site,
    /// Objective there.
    pub value: f64,
    /// Metrics there, those that the objective needs.
    pub metrics: Metrics,
    /// Iterations of Nelder–Mead.
    pub iterations: usize,
    /// Searches by Nelder–Mead that used up their iterations and went on from there.
    pub continued: usize,
    /// Whether the tolerance was met in the end.
    pub is_converged: bool,
    /// Best value after each iteration.
    pub history: Vec<f64>,
    /// Every place it evaluated and could be cut at.
    pub visited: Vec<(Site, Metrics)>,
}

/// First simplex: this share of a step of the grid along each coordinate.
const FIRST_SIZE: f64 = 0.5;
/// A search that is started anew is smaller by this factor.
const SHRINK: f64 = 0.2;
/// Objectives below this are as good as zero.
const SMALLEST: f64 = 1e-12;
/// Most searches from one start that met the tolerance, and most that used up their iterations. What a third one of the
/// former gains, polishing gains for less.
const ROUNDS: usize = 2;
const CONTINUATIONS: usize = 5;
/// Ends within this share of the best value are polished: among them is the best place.
const CONTENDS: f64 = 0.02;
/// Most ends that are polished.
const POLISHED: usize = 2;
/// Steps of polishing.
const POLISH: Steps = Steps { first: 0.1, last: 5e-4, bases: 0 };

/// Refines each of `starts`, in their order, and polishes the best ends.
///
/// # Errors
/// Of `work`.
pub(super) fn refine(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    objective: &Objective,
    starts: &[(Start, Site)],
    work: &Work,
) -> error::Result<Vec<Refinement>> {
    let run = |(number, (from, start)): (usize, &(Start, Site))| {
        let search = Search { evaluator, study, objective, work: &work.shard(number) };
        let refinement = search.run(*from, *start);
        search.tell(Event::Computed(1));
        refinement
    };
    let mut refinements: Vec<Refinement> = starts.par_iter().enumerate().filter_map(run).collect();
    work.barrier()?;
    // The ends of a front are polished with the rest of it.
    let is_sought = *objective == study.objective;
    let contenders = if is_sought { contenders(study, &refinements) } else { Vec::new() };
    refinements.par_iter_mut().enumerate().for_each(|(index, found)| {
        if let Some(rank) = contenders.iter().position(|contender| *contender == index) {
            Search { evaluator, study, objective, work: &work.shard(rank) }.polish(found);
        }
    });
    work.barrier()?;
    Ok(refinements)
}

/// Ends that may be, or be next to, the best place: no two of them the same.
fn contenders(study: &PlacementStudy, refinements: &[Refinement]) -> Vec<usize> {
    let mut sorted: Vec<usize> = (0..refinements.len()).collect();
    sorted.sort_by(|&a, &b| refinements[a].value.total_cmp(&refinements[b].value).then(a.cmp(&b)));
    let Some(best) = sorted.first().map(|&index| refinements[index].value) else { return sorted };
    let mut contenders: Vec<usize> = Vec::new();
    for index in sorted {
        let is_near = refinements[index].value - best <= CONTENDS * best.abs();
        let is_same = |&other: &usize| study.is_same_place(&refinements[other].site, &refinements[index].site);
        if is_near && contenders.len() < POLISHED && !contenders.iter().any(is_same) {
            contenders.push(index);
        }
    }
    contenders
}

struct Search<'a> {
    evaluator: &'a Evaluator,
    study: &'a PlacementStudy,
    objective: &'a Objective,
    work: &'a Work,
}

impl Search<'_> {
    /// `None` if the start cannot be cut at.
    fn run(&self, from: Start, start: Site) -> Option<Refinement> {
        let free = self.study.bounds.free();
        let settings = &self.study.search;
        let visited = Mutex::new(Vec::new());
        let history = Arc::new(Mutex::new(Vec::new()));
        let cost = Cost { search: self, free: &free, fixed: start, visited: &visited };
        let mut found = (start, cost.value(&start));
        let tolerance = settings.tolerance * found.1.abs().max(SMALLEST);
        let (mut size, mut rounds, mut continued) = (FIRST_SIZE, 0, 0);
        let mut is_converged = free.is_empty();
        while !is_converged && found.1.is_finite() && rounds < ROUNDS && continued < CONTINUATIONS {
            let before = found.1;
            let is_ended_by_count;
            (found, is_ended_by_count) = cost.descend(found, size, (tolerance, settings.max_iterations), &history)?;
            if is_ended_by_count {
                continued += 1;
                continue;
            }
            rounds += 1;
            size *= SHRINK;
            is_converged = before - found.1 <= tolerance;
        }
        // So many searches that met the tolerance are enough, whatever the last one gained.
        is_converged |= rounds == ROUNDS;
        let history = history.lock().map(|history| history.clone()).unwrap_or_default();
        let visited = visited.into_inner().unwrap_or_default();
        let metrics = visited.iter().find(|(site, _): &&(Site, Metrics)| *site == found.0)?.1;
        let iterations = history.len();
        let (site, value) = found;
        Some(Refinement { from, start, site, value, metrics, iterations, continued, is_converged, history, visited })
    }

    fn polish(&self, refinement: &mut Refinement) {
        let start = (refinement.site, refinement.value);
        let mut best = None;
        let (site, value) = polish(self.study, start, POLISH, f64::NEG_INFINITY, |site, below| {
            let evaluation =
                self.evaluator.kept_below(self.work, site, &|metrics| self.objective.value(metrics), below);
            let Some(metrics) = evaluation.map(|evaluation| evaluation.metrics) else { return f64::INFINITY };
            let value = self.objective.value(&metrics);
            if value < below {
                best = Some(metrics);
                refinement.visited.push((*site, metrics));
                self.tell(Event::Best(value));
            }
            value
        });
        (refinement.site, refinement.value) = (site, value);
        refinement.metrics = best.unwrap_or(refinement.metrics);
    }

    /// Tells of a search for the study's own objective.
    fn tell(&self, event: Event) {
        if *self.objective == self.study.objective || matches!(event, Event::Computed(_)) {
            self.work.tell(event);
        }
    }
}

/// The objective as a function of the free variables u.
struct Cost<'a> {
    search: &'a Search<'a>,
    free: &'a [usize],
    fixed: Site,
    visited: &'a Mutex<Vec<(Site, Metrics)>>,
}

impl Cost<'_> {
    fn bounds(&self) -> &Bounds {
        &self.search.study.bounds
    }

    fn site(&self, u: &[f64]) -> Site {
        let mut site = self.fixed;
        for (&i, u) in self.free.iter().zip(u) {
            let (low, high) = (self.bounds().low[i], self.bounds().high[i]);
            site.0[i] = match self.bounds().is_full_turn(i) {
                true => low + (u - low).rem_euclid(TAU),
                false => (0.5 * (low + high) + 0.5 * (high - low) * u.sin()).clamp(low, high),
            };
        }
        site
    }

    fn variables(&self, site: &Site) -> Vec<f64> {
        let variable = |&i: &usize| {
            if self.bounds().is_full_turn(i) {
                return site.0[i];
            }
            let (low, range) = (self.bounds().low[i], self.bounds().range(i));
            (2.0 * (site.0[i] - low) / range - 1.0).clamp(-1.0, 1.0).asin()
        };
        self.free.iter().map(variable).collect()
    }

    fn value(&self, site: &Site) -> f64 {
        match self.search.evaluator.kept(self.search.work, site) {
            Ok(evaluation) => {
                if let Ok(mut visited) = self.visited.lock() {
                    visited.push((*site, evaluation.metrics));
                }
                self.search.objective.value(&evaluation.metrics)
            }
            Err(_) => f64::INFINITY,
        }
    }

    /// The start and, along each free coordinate, a place `size` steps of the grid away, inward at a bound.
    fn simplex(&self, start: &Site, size: f64) -> Vec<Vec<f64>> {
        let mut simplex = vec![self.variables(start)];
        for &i in self.free {
            let step = size * self.search.study.grid.step(i, self.bounds());
            let is_inside = self.bounds().is_full_turn(i) || start.0[i] + step <= self.bounds().high[i];
            let mut variables = self.variables(&self.bounds().moved(start, i, if is_inside { step } else { -step }));
            if let Some(turned) = self.free.iter().position(|&other| other == i && self.bounds().is_full_turn(i)) {
                // Not the way round: a simplex has no seam.
                variables[turned] = start.0[i] + step;
            }
            simplex.push(variables);
        }
        simplex
    }

    /// One search by Nelder–Mead; the better of its start and its end, and whether it used up its iterations.
    fn descend(
        &self,
        start: (Site, f64),
        size: f64,
        (tolerance, iterations): (f64, usize),
        history: &Arc<Mutex<Vec<f64>>>,
    ) -> Option<((Site, f64), bool)> {
        let solver = NelderMead::new(self.simplex(&start.0, size)).with_sd_tolerance(tolerance);
        let is_told = *self.search.objective == self.search.study.objective;
        let observer =
            Progress { history: Arc::clone(history), best: start.1, work: self.search.work.clone(), is_told };
        let result = Executor::new(self, solver.ok()?)
            .configure(|state| state.max_iters(iterations as u64))
            .add_observer(observer, ObserverMode::Always)
            .run()
            .ok()?;
        let state = result.state();
        let end = state.get_best_param().map(|u| (self.site(u), state.get_best_cost()));
        let is_ended_by_count =
            matches!(state.get_termination_status(), TerminationStatus::Terminated(TerminationReason::MaxItersReached));
        Some((end.filter(|end| end.1 < start.1).unwrap_or(start), is_ended_by_count))
    }
}

impl CostFunction for &Cost<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, u: &Self::Param) -> Result<f64, Error> {
        Ok(self.value(&self.site(u)))
    }
}

/// Takes note of each iteration's best value and tells who watches.
struct Progress {
    history: Arc<Mutex<Vec<f64>>>,
    /// Best value so far, the searches before included.
    best: f64,
    work: Work,
    /// Whether the best value is one of the study's objective.
    is_told: bool,
}

impl Observe<IterState<Vec<f64>, (), (), (), (), f64>> for Progress {
    fn observe_iter(&mut self, state: &IterState<Vec<f64>, (), (), (), (), f64>, _: &KV) -> Result<(), Error> {
        self.best = self.best.min(state.get_best_cost());
        if let Ok(mut history) = self.history.lock() {
            history.push(self.best);
        }
        // Not the cost, whose errors the solver unwraps; to it stopped work looks infeasible everywhere.
        self.work.check()?;
        if self.is_told {
            self.work.tell(Event::Best(self.best));
        }
        Ok(())
    }
}
