//! A function as it is generated: a start and a fixed number of Newton steps.

use nalgebra::DMatrix;

use super::{
    domain::Domain,
    exact::{Exact, Solved},
};
use crate::{
    input::error::{Error, Result},
    lanes::{MAX_LANES, Program, Real, record},
    statics::one_step::{self, Given},
};

/// Of machines for which there is such code.
const DRIVES: usize = 3;

/// Drives for a position of the tool tip, or the position for drives.
#[derive(Debug, Clone)]
pub(crate) struct Function {
    /// What is given: the position, or the drives.
    pub given: Given,
    /// Where the steps start. Of a function of the drives, without these.
    pub start: Start,
    /// One step, of the numbers of a state and what is given.
    pub step: Program,
}

impl Function {
    /// One that starts with polynomials of these degrees over `range`, fitted to `solved`, and goes on with `step`.
    pub fn new(given: Given, range: &Domain, degrees: Degrees, solved: &[Solved], step: Program) -> Option<Self> {
        let inputs: Vec<Vec<f64>> = solved.iter().map(|solved| inputs(given, solved)).collect();
        let known = if given == Given::Drives { DRIVES } else { 0 };
        let states: Vec<Vec<f64>> = solved.iter().map(|solved| solved.numbers[known..].to_vec()).collect();
        let start = Start::fitted(range, degrees, &inputs, &states)?;
        Some(Self { given, start, step })
    }

    /// A step of the machine, whose ways `solved` show.
    ///
    /// # Errors
    /// It cannot be written down.
    pub fn step(exact: &Exact, given: Given, solved: &[Solved]) -> Result<Program> {
        let postures: Vec<Vec<f64>> = solved
            .iter()
            .take(MAX_LANES)
            .map(|solved| step_inputs(given, &solved.numbers, &solved.asked.0, &solved.asked.1))
            .collect();
        one_step::step_program(exact.real(), given, &postures).ok_or_else(|| {
            let problem = "a Newton step cannot be written without branches, as a chain cannot be condensed where the machine stands: \
                           expected chains without idle joints";
            Error::argument("--machine", format!("{}: {problem}", exact.real().name))
        })
    }

    /// The states to which `steps` steps lead from the start at three coordinates (a position or the drives) under a wrench: the start, and
    /// the state after each step.
    pub fn path(&self, at: &[f64; 3], wrench: &[f64; 6], steps: usize, values: &mut Vec<f64>) -> Vec<Vec<f64>> {
        let inputs: Vec<f64> = at.iter().chain(wrench).copied().collect();
        let mut state = match self.given {
            Given::Tip => Vec::new(),
            Given::Drives => at.to_vec(),
        };
        state.extend(self.start.at(&inputs));
        let mut states = vec![state];
        for step in 0..steps {
            let inputs = step_inputs(self.given, &states[step], at, wrench);
            states.push(self.step.evaluate(&inputs, values));
        }
        states
    }

    /// The state after the last of the steps.
    pub fn last(&self, at: &[f64; 3], wrench: &[f64; 6], steps: usize) -> Vec<f64> {
        self.path(at, wrench, steps, &mut Vec::new()).pop().unwrap_or_default()
    }

    /// The numbers of a state by which its last step is judged: the drives or the place of the platform, whichever is sought.
    pub fn judged(&self, state: &[f64]) -> [f64; 3] {
        let first = match self.given {
            Given::Tip => 0,
            Given::Drives => one_step::origin(DRIVES),
        };
        std::array::from_fn(|i| state[first + i])
    }
}

/// What the start is given: three coordinates and the wrench.
fn inputs(given: Given, solved: &Solved) -> Vec<f64> {
    let at = match given {
        Given::Tip => solved.asked.0.to_vec(),
        Given::Drives => solved.drives.clone(),
    };
    at.into_iter().chain(solved.asked.1).collect()
}

/// What a step is given: a state, and what is asked.
fn step_inputs(given: Given, state: &[f64], at: &[f64; 3], wrench: &[f64; 6]) -> Vec<f64> {
    let position: &[f64] = if given == Given::Tip { at } else { &[] };
    state.iter().chain(position).chain(wrench).copied().collect()
}

/// Between what the coordinates of a function of `given` are, with room for rounding of the drives.
pub(super) fn range(given: Given, domain: &Domain, solved: &[Solved]) -> Domain {
    let mut range = *domain;
    for i in 0..if given == Given::Drives { 3 } else { 0 } {
        let all = || solved.iter().map(|solved| solved.drives[i]);
        let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        let room = ROOM * (most - least);
        (range.low[i], range.high[i]) = (least - room, most + room);
    }
    range
}

/// How far drives may be outside of those that were sampled, as a share of their range.
const ROOM: f64 = 0.01;

/// Total degrees of the products: by themselves, and times a component of the wrench; `None` without the latter.
pub type Degrees = (usize, Option<usize>);

/// Where a fixed number of Newton steps starts: all numbers of a state as polynomials of what is asked, of one domain. Each is a sum over
/// products of Chebyshev polynomials of three coordinates (positions of the tool tip or of the drives), and over such products times a
/// component of the wrench.
#[derive(Debug, Clone)]
pub struct Start {
    /// What they are sums of: of three coordinates and the wrench.
    pub basis: Program,
    /// Of each term, its coefficient in each number.
    pub coefficients: Vec<Vec<f64>>,
}

/// Exponents of three coordinates with a sum of at most `degree`.
fn exponents(degree: usize) -> Vec<[usize; 3]> {
    let mut all = Vec::new();
    for sum in 0..=degree {
        for i in (0..=sum).rev() {
            all.extend((0..=sum - i).rev().map(|j| [i, j, sum - i - j]));
        }
    }
    all
}

/// T₀ … of `degree` at `x`.
fn chebyshev<R: Real>(x: R, degree: usize) -> Vec<R> {
    let mut all = vec![R::splat(1.0), x];
    for n in 2..=degree {
        all.push((x + x) * all[n - 1] - all[n - 2]);
    }
    all
}

/// The terms at `inputs`: three coordinates and the wrench.
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
    /// The polynomials over `range` (of coordinates and wrenches) that are nearest to `states` at `inputs` (three coordinates and the wrench),
    /// by least squares; `None` where these do not determine them.
    pub fn fitted(range: &Domain, degrees: Degrees, inputs: &[Vec<f64>], states: &[Vec<f64>]) -> Option<Self> {
        let shown: Vec<Vec<f64>> = inputs.iter().cycle().take(MAX_LANES).cloned().collect();
        let basis = record(&shown, |inputs| Some(terms(inputs, range, degrees)))?;
        let mut values = Vec::new();
        let rows: Vec<Vec<f64>> = inputs.iter().map(|inputs| basis.evaluate(inputs, &mut values)).collect();
        let (count, numbers) = (basis.outputs.len(), states.first()?.len());
        if rows.len() < count {
            return None;
        }
        let matrix = DMatrix::from_fn(rows.len(), count, |i, j| rows[i][j]);
        let right = DMatrix::from_fn(rows.len(), numbers, |i, j| states[i][j]);
        let (q, r) = matrix.qr().unpack();
        let solution = r.solve_upper_triangular(&(q.transpose() * right))?;
        let coefficients = (0..count).map(|term| (0..numbers).map(|n| solution[(term, n)]).collect()).collect();
        Some(Self { basis, coefficients })
    }

    /// The numbers at `inputs`.
    pub fn at(&self, inputs: &[f64]) -> Vec<f64> {
        let terms = self.basis.evaluate(inputs, &mut Vec::new());
        let mut state = vec![0.0; self.coefficients.first().map_or(0, Vec::len)];
        for (row, term) in self.coefficients.iter().zip(terms) {
            for (number, coefficient) in state.iter_mut().zip(row) {
                *number += coefficient * term;
            }
        }
        state
    }

    /// How many multiplications and additions they take, besides their terms.
    pub fn operation_count(&self) -> usize {
        2 * self.coefficients.iter().map(Vec::len).sum::<usize>() + self.basis.operation_count()
    }
}
