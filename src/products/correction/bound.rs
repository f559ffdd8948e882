//! Searches the largest distance of the tool from where it is wanted, over all positions of a box and all forces up to the largest one.
//!
//! The loaded machine itself is asked, in three steps that are the same each time: on a lattice of half the cells of the table, where the
//! error of linear interpolation is largest, without force and with the largest one along each axis; at the points of a Halton
//! sequence (J. H. Halton, Numerische Mathematik 2, 1960) over position and force; and by Nelder–Mead from the worst of these, each in
//! another cell. What is found is no proof, but the largest of a great many values.

use std::sync::{Mutex, PoisonError};

use argmin::{
    core::{CostFunction, Error as SolverError, Executor},
    solver::neldermead::NelderMead,
};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::{
    CorrectionQuestion, Corrector,
    loaded::{LoadedMachine, map_places},
};
use crate::{
    input::error::{Error, Result},
    simulation::Machines,
    spatial::{Grid, radical_inverse},
    work::{Event, Stage, Work},
};

/// The largest error found, and where.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[allow(non_snake_case, reason = "the unit is N, not n")]
pub struct Worst {
    /// Distance of the tool from where it is wanted, mm.
    pub error_mm: f64,
    /// P in O, mm.
    pub position_mm: [f64; 3],
    /// Force on the tool tip in O axes, N.
    pub force_N: [f64; 3],
    /// Number of positions and forces visited.
    pub looked_at: usize,
}

/// Number of points of the Halton sequence.
const SPREAD: usize = 2048;
/// Number of Nelder–Mead searches.
const STARTS: usize = 16;

/// Returns the largest residual error found with `corrector`, and where, on the current rayon pool; `cells` is the grid whose cells are
/// searched. An error above `enough` mm on the lattice ends the search.
///
/// # Errors
/// A position that the machine does not reach, or without equilibrium there; errors of `work`.
pub fn worst(
    question: &CorrectionQuestion,
    machines: &Machines,
    corrector: &Corrector<'_>,
    cells: &Grid,
    enough: f64,
    work: &Work,
) -> Result<Worst> {
    let search = Search { question, machines, corrector, cells };
    let mut cases = lattice_cases(question, cells);
    work.tell(Event::Stage(Stage { of: "points off the grid", items: cases.len() + SPREAD }));
    let mut errors = search.errors(&cases, work)?;
    let ends_here = errors.iter().any(|error| *error > enough);
    if !ends_here {
        let samples: Vec<Case> = (1..=SPREAD).map(|index| halton_case(question, index)).collect();
        errors.extend(search.errors(&samples, work)?);
        cases.extend(samples);
    }
    let mut looked_at = cases.len();
    let mut ranked: Vec<usize> = (0..looked_at).collect();
    ranked.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]).then(a.cmp(&b)));
    let starts = if ends_here { Vec::new() } else { search.separate_starts(&cases, &ranked) };
    let ends = starts.par_iter().map_init(
        || LoadedMachine::new(question, machines),
        |loaded, &start| {
            work.check()?;
            climb(&search, loaded, cases[start], errors[start])
        },
    );
    for (case, error, count) in ends.collect::<Result<Vec<_>>>()? {
        looked_at += count;
        cases.push(case);
        errors.push(error);
    }
    let largest = (0..cases.len()).max_by(|&a, &b| errors[a].total_cmp(&errors[b]).then(b.cmp(&a))).unwrap_or(0);
    let (position, force) = cases[largest];
    Ok(Worst { error_mm: errors[largest], position_mm: position.into(), force_N: force.into(), looked_at })
}

/// Returns the largest residual error at the nodes themselves, mm, under forces of two sizes along and between the axes.
pub(super) fn worst_at_nodes(
    question: &CorrectionQuestion,
    machines: &Machines,
    corrector: &Corrector<'_>,
    nodes: &Grid,
    work: &Work,
) -> Result<f64> {
    let search = Search { question, machines, corrector, cells: nodes };
    let cases = at_positions(nodes, &force_directions(question.largest_force_N));
    Ok(search.errors(&cases, work)?.into_iter().fold(0.0, f64::max))
}

/// Input of the search: a way to correct, and the cells to search.
struct Search<'a> {
    question: &'a CorrectionQuestion,
    machines: &'a Machines,
    corrector: &'a Corrector<'a>,
    cells: &'a Grid,
}

impl Search<'_> {
    /// Returns the residual error of the tool in each case, mm, in their order.
    fn errors(&self, cases: &[Case], work: &Work) -> Result<Vec<f64>> {
        map_places(self.question, self.machines, cases.len(), work, |loaded, index| self.error(loaded, &cases[index]))
    }

    /// Returns the residual error of the tool in a case, mm.
    fn error(&self, loaded: &mut LoadedMachine<'_>, (position, force): &Case) -> Result<f64> {
        let nominal = loaded.nominal_at(*position)?;
        loaded.residual_mm(&nominal, *force, &self.corrector.correction(&nominal, *position, *force))
    }

    /// Returns the indices of at most [`STARTS`] cases, the first in the order `ranked` of which no two lie in the same cell.
    fn separate_starts(&self, cases: &[Case], ranked: &[usize]) -> Vec<usize> {
        let cell = |index: usize| {
            let (position, _) = cases[index];
            [0, 1, 2].map(|axis| self.cells.axes[axis].partition_point(|node| *node <= position[axis]))
        };
        let mut starts: Vec<usize> = Vec::new();
        for &index in ranked {
            if starts.len() == STARTS {
                break;
            }
            if !starts.iter().any(|&other| cell(other) == cell(index)) {
                starts.push(index);
            }
        }
        starts
    }
}

/// Most iterations of a Nelder–Mead search.
const ITERATIONS: u64 = 80;
/// Size of the first simplex, as shares of a cell and of the largest force.
const FIRST: [f64; 2] = [0.2, 0.3];
/// Spread of the errors of a simplex at which the search ends, as a share of the largest.
const SPREAD_LEFT: f64 = 1e-4;

/// Searches by Nelder–Mead from `start`, of `error` mm; returns the worst case, its error in mm, and the number of cases visited.
fn climb(search: &Search<'_>, loaded: &mut LoadedMachine<'_>, start: Case, error: f64) -> Result<(Case, f64, usize)> {
    let count = search.question.axes().count() + force_variables(search);
    if count == 0 || error == 0.0 {
        return Ok((start, error, 0));
    }
    let climb = Climb {
        search,
        fixed: start.0,
        state: Mutex::new(ClimbState { loaded, best: (start, error), fault: None, count: 0 }),
    };
    let first = case_parameters(search, start);
    let mut simplex = vec![first.clone()];
    for index in 0..count {
        let mut corner = first.clone();
        corner[index] += first_step(search, index, corner[index]);
        simplex.push(corner);
    }
    if let Ok(solver) = NelderMead::new(simplex).with_sd_tolerance(SPREAD_LEFT * error) {
        // Its only errors are those of the cost, which has none; what it has state stands in `climb`.
        drop(Executor::new(&climb, solver).configure(|state| state.max_iters(ITERATIONS)).run());
    }
    let state = climb.state.into_inner().unwrap_or_else(PoisonError::into_inner);
    match state.fault {
        Some(fault) => Err(fault),
        None => Ok((state.best.0, state.best.1, state.count)),
    }
}

/// Returns the number of force components that are varied: 3, or 0 without force.
fn force_variables(search: &Search<'_>) -> usize {
    if search.question.largest_force_N > 0.0 { 3 } else { 0 }
}

/// Returns a case as shares: of the box along each of its axes, then of the largest force (none without force).
fn case_parameters(search: &Search<'_>, (position, force): Case) -> Vec<f64> {
    let [min, max] = search.question.corners;
    let mut all: Vec<f64> = search.question.axes().map(|i| (position[i] - min[i]) / (max[i] - min[i])).collect();
    all.extend((force / search.question.largest_force_N).iter().take(force_variables(search)));
    all
}

/// Returns the first step of parameter number `index` away from its value `from`.
fn first_step(search: &Search<'_>, index: usize, from: f64) -> f64 {
    match search.question.axes().nth(index) {
        Some(axis) => {
            let step = FIRST[0] / (search.cells.axes[axis].len() - 1).max(1) as f64;
            if from + step <= 1.0 { step } else { -step }
        }
        None if from > 0.0 => -FIRST[1],
        None => FIRST[1],
    }
}

/// Returns the case of `parameters` (see [`case_parameters`]), moved into box and largest force; `fixed` gives the other coordinates.
fn case_at(search: &Search<'_>, parameters: &[f64], fixed: Vector3<f64>) -> Case {
    let [min, max] = search.question.corners;
    let (axes, mut position) = (search.question.axes().count(), fixed);
    for (axis, share) in search.question.axes().zip(parameters) {
        position[axis] = min[axis] + (max[axis] - min[axis]) * share.clamp(0.0, 1.0);
    }
    let shares = parameters.get(axes..).filter(|shares| shares.len() == 3);
    let force = shares.map_or_else(Vector3::zeros, |shares| Vector3::new(shares[0], shares[1], shares[2]));
    (position, force * (search.question.largest_force_N / force.norm().max(1.0)))
}

/// Storage and progress of a Nelder–Mead search.
struct ClimbState<'a, 'q> {
    loaded: &'a mut LoadedMachine<'q>,
    best: (Case, f64),
    fault: Option<Error>,
    count: usize,
}

/// The negative error as a cost function of the parameters.
struct Climb<'a, 'q> {
    search: &'a Search<'a>,
    fixed: Vector3<f64>,
    state: Mutex<ClimbState<'a, 'q>>,
}

impl CostFunction for &Climb<'_, '_> {
    type Param = Vec<f64>;
    type Output = f64;

    /// Returns the negative error of a case, since the solver minimises, and notes the worst case.
    fn cost(&self, parameters: &Self::Param) -> std::result::Result<f64, SolverError> {
        let case = case_at(self.search, parameters, self.fixed);
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.count += 1;
        Ok(match self.search.error(state.loaded, &case) {
            Ok(error) => {
                if error > state.best.1 {
                    state.best = (case, error);
                }
                -error
            }
            Err(fault) => {
                state.fault.get_or_insert(fault);
                f64::INFINITY
            }
        })
    }
}

/// A position of P (O, mm) and a force on the tool tip (O axes, N).
type Case = (Vector3<f64>, Vector3<f64>);

/// Returns corners and middles of cells, faces and edges, each under no force and the largest one along each axis.
fn lattice_cases(question: &CorrectionQuestion, cells: &Grid) -> Vec<Case> {
    let [min, max] = question.corners;
    let grid = Grid::new(min, max, cells.counts().map(|count| 2 * count - 1));
    at_positions(&grid, &axis_forces(question.largest_force_N))
}

/// Returns each of the `forces` at each point of a grid.
fn at_positions(grid: &Grid, forces: &[Vector3<f64>]) -> Vec<Case> {
    (0..grid.len()).flat_map(|index| forces.iter().map(move |force| (grid.position(index), *force))).collect()
}

/// Returns forces of the size `largest` along and between the axes, and about half of it, N.
pub(super) fn force_directions(largest: f64) -> Vec<Vector3<f64>> {
    if largest == 0.0 {
        return vec![Vector3::zeros()];
    }
    let sides = Grid::new(-Vector3::repeat(1.0), Vector3::repeat(1.0), [3; 3]);
    let directions = (0..sides.len()).filter_map(|index| sides.position(index).try_normalize(0.0));
    directions.flat_map(|direction| [direction * largest, direction * (0.55 * largest)]).collect()
}

/// Returns case number `index` of the Halton sequence over position, direction and size of the force.
fn halton_case(question: &CorrectionQuestion, index: usize) -> Case {
    let [min, max] = question.corners;
    let share = |base| radical_inverse(index, base);
    let position = min + (max - min).component_mul(&Vector3::new(share(2), share(3), share(5)));
    let (height, angle, size) = (2.0 * share(7) - 1.0, std::f64::consts::TAU * share(11), libm::cbrt(share(13)));
    let across = (1.0 - height * height).max(0.0).sqrt();
    let direction = Vector3::new(across * libm::cos(angle), across * libm::sin(angle), height);
    (position, direction * (size * question.largest_force_N))
}

/// Returns no force, and forces of the size `largest` along each axis in both directions, N.
pub(super) fn axis_forces(largest: f64) -> Vec<Vector3<f64>> {
    let mut forces = vec![Vector3::zeros()];
    if largest > 0.0 {
        forces.extend((0..3).flat_map(|axis| [largest, -largest].map(|size| Vector3::ith(axis, size))));
    }
    forces
}
