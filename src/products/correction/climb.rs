//! From a bad position and force to the worst one nearby, by Nelder–Mead.

use std::sync::{Mutex, PoisonError};

use argmin::{
    core::{CostFunction, Error as SolverError, Executor},
    solver::neldermead::NelderMead,
};
use nalgebra::Vector3;

use super::{bound::Search, cases::Case, loaded::Loaded};
use crate::input::error::{Error, Result};

/// Most iterations.
const ITERATIONS: u64 = 80;
/// First simplex: shares of a cell and of the largest force.
const FIRST: [f64; 2] = [0.2, 0.3];
/// A spread of the errors of a simplex below this share of the largest one is none.
const SPREAD_LEFT: f64 = 1e-4;

/// Nelder–Mead from `start`: the worst case it finds, and how many it looked at.
pub(super) fn climb(
    search: &Search<'_>,
    loaded: &mut Loaded<'_>,
    start: Case,
    error: f64,
) -> Result<(Case, f64, usize)> {
    let count = variables(search).len() + force_variables(search);
    if count == 0 || error == 0.0 {
        return Ok((start, error, 0));
    }
    let climb = Climb {
        search,
        fixed: start.0,
        seen: Mutex::new(Seen { loaded, best: (start, error), fault: None, count: 0 }),
    };
    let first = parameters(search, start);
    let mut simplex = vec![first.clone()];
    for index in 0..count {
        let mut corner = first.clone();
        corner[index] += first_step(search, index, corner[index]);
        simplex.push(corner);
    }
    if let Ok(solver) = NelderMead::new(simplex).with_sd_tolerance(SPREAD_LEFT * error) {
        // Its only errors are those of the cost, which has none; what it has seen stands in `climb`.
        drop(Executor::new(&climb, solver).configure(|state| state.max_iters(ITERATIONS)).run());
    }
    let seen = climb.seen.into_inner().unwrap_or_else(PoisonError::into_inner);
    match seen.fault {
        Some(fault) => Err(fault),
        None => Ok((seen.best.0, seen.best.1, seen.count)),
    }
}

/// Axes along which a position may move.
fn variables(search: &Search<'_>) -> Vec<usize> {
    search.question.axes().collect()
}

fn force_variables(search: &Search<'_>) -> usize {
    if search.question.largest_force_N > 0.0 { 3 } else { 0 }
}

/// Shares of the box and of the largest force.
fn parameters(search: &Search<'_>, (position, force): Case) -> Vec<f64> {
    let [min, max] = search.question.corners;
    let mut all: Vec<f64> = variables(search).into_iter().map(|i| (position[i] - min[i]) / (max[i] - min[i])).collect();
    all.extend((force / search.question.largest_force_N).iter().take(force_variables(search)));
    all
}

fn first_step(search: &Search<'_>, index: usize, from: f64) -> f64 {
    match variables(search).get(index) {
        Some(&axis) => {
            let step = FIRST[0] / (search.cells.axes[axis].len() - 1).max(1) as f64;
            if from + step <= 1.0 { step } else { -step }
        }
        None if from > 0.0 => -FIRST[1],
        None => FIRST[1],
    }
}

/// What parameters stand for; outside the box and beyond the largest force the nearest case inside.
fn case(search: &Search<'_>, parameters: &[f64], fixed: Vector3<f64>) -> Case {
    let [min, max] = search.question.corners;
    let axes = variables(search);
    let mut position = fixed;
    for (&axis, share) in axes.iter().zip(parameters) {
        position[axis] = min[axis] + (max[axis] - min[axis]) * share.clamp(0.0, 1.0);
    }
    let shares = parameters.get(axes.len()..).filter(|shares| shares.len() == 3);
    let force = shares.map_or_else(Vector3::zeros, |shares| Vector3::new(shares[0], shares[1], shares[2]));
    (position, force * (search.question.largest_force_N / force.norm().max(1.0)))
}

/// What a search has seen.
struct Seen<'a, 'q> {
    loaded: &'a mut Loaded<'q>,
    best: (Case, f64),
    fault: Option<Error>,
    count: usize,
}

/// The error as a function of what a search moves.
struct Climb<'a, 'q> {
    search: &'a Search<'a>,
    fixed: Vector3<f64>,
    seen: Mutex<Seen<'a, 'q>>,
}

impl CostFunction for &Climb<'_, '_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, parameters: &Self::Param) -> std::result::Result<f64, SolverError> {
        let case = case(self.search, parameters, self.fixed);
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        seen.count += 1;
        Ok(match self.search.error(seen.loaded, &case) {
            Ok(error) => {
                if error > seen.best.1 {
                    seen.best = (case, error);
                }
                -error
            }
            Err(fault) => {
                seen.fault.get_or_insert(fault);
                f64::INFINITY
            }
        })
    }
}
