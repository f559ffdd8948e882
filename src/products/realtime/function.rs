//! A function to generate: a start by polynomials and a fixed number of Newton steps.

use nalgebra::DMatrix;

use super::{
    domain::Domain,
    exact::{ReferenceSolver, TipState},
};
use crate::{
    input::error::{Error, Result},
    lanes::{Computation, MAX_LANES, Real, record},
    statics::one_step::{self, StepInput},
};

/// Number of drives of machines that code is generated for.
const DRIVES: usize = 3;

/// The function from a tool tip position to the drives, or from the drives to the position.
#[derive(Debug, Clone)]
pub(crate) struct Function {
    /// What the function is given: position or drives.
    pub given: StepInput,
    /// Polynomials of the start state; for given drives, without these.
    pub start: Start,
    /// Operations of one Newton step, from state and input to the next state.
    pub step: Computation,
}

impl Function {
    /// Builds a function whose start is polynomials of these degrees over `range`, fitted to the equilibria `solved`, and whose steps are
    /// `step`. `None` where these equilibria do not determine the polynomials.
    pub fn new(
        kind: StepInput,
        range: &Domain,
        degrees: Degrees,
        solved: &[TipState],
        step: Computation,
    ) -> Option<Self> {
        let inputs: Vec<Vec<f64>> = solved.iter().map(|solved| start_inputs(kind, solved)).collect();
        let given_count = if kind == StepInput::Drives { DRIVES } else { 0 };
        let states: Vec<Vec<f64>> = solved.iter().map(|solved| solved.numbers[given_count..].to_vec()).collect();
        let start = Start::fit(range, degrees, &inputs, &states)?;
        Some(Self { given: kind, start, step })
    }

    /// Records one Newton step of the machine at the equilibria `solved`; an error if it cannot be written without branches.
    pub fn step(exact: &ReferenceSolver, given: StepInput, solved: &[TipState]) -> Result<Computation> {
        let postures: Vec<Vec<f64>> = solved
            .iter()
            .take(MAX_LANES)
            .map(|solved| step_inputs(given, &solved.numbers, &solved.asked.0, &solved.asked.1))
            .collect();
        one_step::step_program(exact.actual(), given, &postures).ok_or_else(|| {
            let problem = "a Newton step cannot be written without branches, as a chain cannot be condensed where the machine stands: \
                           expected chains without idle joints";
            Error::argument("--machine", format!("{}: {problem}", exact.actual().name))
        })
    }

    /// Returns the start state and that after each of `steps` Newton steps, at three coordinates (tip position or drives) under a wrench.
    pub fn states(&self, at: &[f64; 3], wrench: &[f64; 6], steps: usize, values: &mut Vec<f64>) -> Vec<Vec<f64>> {
        let inputs: Vec<f64> = at.iter().chain(wrench).copied().collect();
        let mut state = match self.given {
            StepInput::Tip => Vec::new(),
            StepInput::Drives => at.to_vec(),
        };
        state.extend(self.start.evaluate(&inputs));
        let mut states = vec![state];
        for step in 0..steps {
            let inputs = step_inputs(self.given, &states[step], at, wrench);
            states.push(self.step.evaluate(&inputs, values));
        }
        states
    }

    /// Returns the state after the last of `steps` Newton steps, with arguments as in [`Function::states`].
    pub fn last_state(&self, at: &[f64; 3], wrench: &[f64; 6], steps: usize) -> Vec<f64> {
        self.states(at, wrench, steps, &mut Vec::new()).pop().unwrap_or_default()
    }

    /// Returns the three unknowns of a state: the drives (mm, rad), or the position of the platform (mm).
    pub fn unknowns(&self, state: &[f64]) -> [f64; 3] {
        let first = match self.given {
            StepInput::Tip => 0,
            StepInput::Drives => one_step::origin_index(DRIVES),
        };
        std::array::from_fn(|i| state[first + i])
    }
}

/// Returns the inputs of the start polynomials: three coordinates and the wrench.
fn start_inputs(kind: StepInput, solved: &TipState) -> Vec<f64> {
    let at = match kind {
        StepInput::Tip => solved.asked.0.to_vec(),
        StepInput::Drives => solved.drives.clone(),
    };
    at.into_iter().chain(solved.asked.1).collect()
}

/// Returns the inputs of a Newton step: a state, the position if it is given, and the wrench.
fn step_inputs(kind: StepInput, state: &[f64], at: &[f64; 3], wrench: &[f64; 6]) -> Vec<f64> {
    let position: &[f64] = if kind == StepInput::Tip { at } else { &[] };
    state.iter().chain(position).chain(wrench).copied().collect()
}

/// Returns the ranges of the inputs: those of the domain, with the range of the drives in `solved`, widened by [`ROOM`], if they are given.
pub(super) fn input_range(kind: StepInput, domain: &Domain, solved: &[TipState]) -> Domain {
    let mut range = *domain;
    for i in 0..if kind == StepInput::Drives { 3 } else { 0 } {
        let all = || solved.iter().map(|solved| solved.drives[i]);
        let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        let margin = ROOM * (most - least);
        (range.low[i], range.high[i]) = (least - margin, most + margin);
    }
    range
}

/// Margin beyond the drive positions that were sampled, as a share of their range.
const ROOM: f64 = 0.01;

/// Total degree of the Chebyshev products, and of those multiplied by a wrench component; `None` without the latter.
pub type Degrees = (usize, Option<usize>);

/// Polynomials of the start state: sums over products of Chebyshev polynomials of three coordinates (tool tip position or drives), and over
/// such products times a component of the wrench.
#[derive(Debug, Clone)]
pub struct Start {
    /// Operations that evaluate the basis terms from three coordinates and the wrench.
    pub basis: Computation,
    /// Coefficients of each basis term, one for each number of the state.
    pub coefficients: Vec<Vec<f64>>,
}

/// Returns all exponents of three coordinates with a sum of at most `degree`.
fn exponents(degree: usize) -> Vec<[usize; 3]> {
    let mut all = Vec::new();
    for sum in 0..=degree {
        for i in (0..=sum).rev() {
            all.extend((0..=sum - i).rev().map(|j| [i, j, sum - i - j]));
        }
    }
    all
}

/// Returns the Chebyshev polynomials T₀ … T_n, n = `degree`, at `x`.
fn chebyshev<R: Real>(x: R, degree: usize) -> Vec<R> {
    let mut all = vec![R::splat(1.0), x];
    for n in 2..=degree {
        all.push((x + x) * all[n - 1] - all[n - 2]);
    }
    all
}

/// Returns the basis terms at `inputs`, three coordinates and the wrench.
fn terms<R: Real>(inputs: &[R], range: &Domain, degrees: Degrees) -> Vec<R> {
    let highest = degrees.0.max(degrees.1.unwrap_or(0));
    let along: Vec<Vec<R>> = (0..3)
        .map(|i| {
            let (middle, half) = (0.5 * (range.low[i] + range.high[i]), 0.5 * (range.high[i] - range.low[i]));
            chebyshev((inputs[i] - R::splat(middle)) * R::splat(1.0 / half), highest)
        })
        .collect();
    let product = |[i, j, k]: [usize; 3]| along[0][i] * along[1][j] * along[2][k];
    let mut all: Vec<R> = exponents(degrees.0).into_iter().map(product).collect();
    let Some(degree) = degrees.1 else { return all };
    for (component, &largest) in range.wrench.iter().enumerate().filter(|(_, largest)| **largest > 0.0) {
        let share = inputs[3 + component] * R::splat(1.0 / largest);
        all.extend(exponents(degree).into_iter().map(|exponents| share * product(exponents)));
    }
    all
}

impl Start {
    /// Fits the polynomials over `range` (coordinates and wrench) to `states` at `inputs` (three coordinates and the wrench) by least
    /// squares; `None` where these do not determine them.
    pub fn fit(range: &Domain, degrees: Degrees, inputs: &[Vec<f64>], states: &[Vec<f64>]) -> Option<Self> {
        let sampled: Vec<Vec<f64>> = inputs.iter().cycle().take(MAX_LANES).cloned().collect();
        let basis = record(&sampled, |inputs| Some(terms(inputs, range, degrees)))?;
        let mut values = Vec::new();
        let rows: Vec<Vec<f64>> = inputs.iter().map(|inputs| basis.evaluate(inputs, &mut values)).collect();
        let (count, numbers) = (basis.outputs.len(), states.first()?.len());
        if rows.len() < count {
            return None;
        }
        let matrix = DMatrix::from_fn(rows.len(), count, |i, j| rows[i][j]);
        let targets = DMatrix::from_fn(rows.len(), numbers, |i, j| states[i][j]);
        let (q, r) = matrix.qr().unpack();
        let solution = r.solve_upper_triangular(&(q.transpose() * targets))?;
        let coefficients = (0..count).map(|term| (0..numbers).map(|n| solution[(term, n)]).collect()).collect();
        Some(Self { basis, coefficients })
    }

    /// Returns the start state at `inputs`.
    pub fn evaluate(&self, inputs: &[f64]) -> Vec<f64> {
        let terms = self.basis.evaluate(inputs, &mut Vec::new());
        let mut state = vec![0.0; self.coefficients.first().map_or(0, Vec::len)];
        for (row, term) in self.coefficients.iter().zip(terms) {
            for (number, coefficient) in state.iter_mut().zip(row) {
                *number += coefficient * term;
            }
        }
        state
    }

    /// Returns the number of operations of one evaluation.
    pub fn operation_count(&self) -> usize {
        2 * self.coefficients.iter().map(Vec::len).sum::<usize>() + self.basis.operation_count()
    }
}
