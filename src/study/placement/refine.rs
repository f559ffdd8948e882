//! Nelder–Mead from the best places of a sweep: the only user of argmin.
//!
//! Nelder–Mead knows no bounds. Each free coordinate is therefore `x = middle + half range · sin u` with u free: every u
//! is within the bounds, an optimum at a bound is an ordinary one (u = π/2), and no evaluation is spent outside. On a
//! test function with its optimum at a bound this took a third fewer evaluations than an infinite wall. An infeasible
//! place costs infinitely much, which Nelder–Mead steps back from.
//!
//! The spread of a simplex can become small before its place is right; each search is therefore started anew, smaller,
//! around what it found, until that gains less than the tolerance.

use std::sync::{Arc, Mutex};

use argmin::{
    core::{CostFunction, Error, Executor, IterState, KV, State, observers::Observe, observers::ObserverMode},
    solver::neldermead::NelderMead,
};
use rayon::prelude::*;

use super::{
    PlacementStudy,
    evaluate::Evaluator,
    metric::{Metrics, Objective},
    site::{Bounds, Site},
};
use crate::study::{Work, work::Event};

/// One refinement.
#[derive(Debug, Clone, PartialEq)]
pub struct Refinement {
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
    /// Whether the tolerance was met before the iterations were used up.
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
/// Most searches from one start.
const ROUNDS: usize = 4;

/// Refines each of `starts`, in their order.
pub(super) fn refine(
    evaluator: &Evaluator<'_>,
    study: &PlacementStudy,
    objective: &Objective,
    starts: &[Site],
    work: &Work,
) -> Vec<Refinement> {
    starts.par_iter().filter_map(|start| Search { evaluator, study, objective, work }.run(*start)).collect()
}

struct Search<'a> {
    evaluator: &'a Evaluator<'a>,
    study: &'a PlacementStudy,
    objective: &'a Objective,
    work: &'a Work,
}

impl Search<'_> {
    /// `None` if the start cannot be cut at.
    fn run(&self, start: Site) -> Option<Refinement> {
        let free = self.study.bounds.free();
        let settings = &self.study.search;
        let visited = Mutex::new(Vec::new());
        let history = Arc::new(Mutex::new(Vec::new()));
        let cost = Cost { search: self, free: &free, fixed: start, visited: &visited };
        let mut found = (start, cost.value(&start));
        let tolerance = settings.tolerance * found.1.abs().max(SMALLEST);
        let mut size = FIRST_SIZE;
        let mut is_converged = free.is_empty();
        for _ in 0..ROUNDS {
            let left = settings.max_iterations.saturating_sub(entries(&history));
            if is_converged || left == 0 || !found.1.is_finite() {
                break;
            }
            let before = found.1;
            found = cost.descend(found, size, (tolerance, left), &history)?;
            size *= SHRINK;
            is_converged = before - found.1 <= tolerance && entries(&history) < settings.max_iterations;
        }
        let history = history.lock().map(|history| history.clone()).unwrap_or_default();
        let visited = visited.into_inner().unwrap_or_default();
        let metrics = visited.iter().find(|(site, _): &&(Site, Metrics)| *site == found.0)?.1;
        let iterations = history.len();
        Some(Refinement { start, site: found.0, value: found.1, metrics, iterations, is_converged, history, visited })
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
            site.0[i] = (0.5 * (low + high) + 0.5 * (high - low) * u.sin()).clamp(low, high);
        }
        site
    }

    fn variables(&self, site: &Site) -> Vec<f64> {
        let variable = |&i: &usize| {
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
            let mut site = *start;
            let is_inside = site.0[i] + step <= self.bounds().high[i];
            site.0[i] = (site.0[i] + if is_inside { step } else { -step }).max(self.bounds().low[i]);
            simplex.push(self.variables(&site));
        }
        simplex
    }

    /// One search by Nelder–Mead; the better of its start and its end.
    fn descend(
        &self,
        start: (Site, f64),
        size: f64,
        (tolerance, iterations): (f64, usize),
        history: &Arc<Mutex<Vec<f64>>>,
    ) -> Option<(Site, f64)> {
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
        Some(end.filter(|end| end.1 < start.1).unwrap_or(start))
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

fn entries(history: &Mutex<Vec<f64>>) -> usize {
    history.lock().map_or(0, |history| history.len())
}
