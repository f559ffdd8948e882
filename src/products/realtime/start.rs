//! Where a fixed number of Newton steps starts: all numbers of a state as polynomials of what is asked.
//!
//! Each is a sum over products of Chebyshev polynomials of three coordinates (positions of the tool tip or of the drives), and over such
//! products times a component of the wrench.

use nalgebra::DMatrix;

use crate::lanes::{Program, Real, record};

/// Total degrees of the products: by themselves, and times a component of the wrench; `None` without the latter.
pub(super) type Degrees = (usize, Option<usize>);

/// Polynomials of one domain.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    /// What they are sums of: of three coordinates and the wrench.
    pub basis: Program,
    /// Of each term, its coefficient in each number.
    pub coefficients: Vec<Vec<f64>>,
}

/// What coordinates and wrenches are between.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    pub low: [f64; 3],
    pub high: [f64; 3],
    pub wrench: [f64; 6],
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
fn terms<R: Real>(inputs: &[R], range: &Range, degrees: Degrees) -> Vec<R> {
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
    /// The polynomials that are nearest to `states` at `inputs` (three coordinates and the wrench), by least squares; `None` where these do
    /// not determine them.
    pub fn fitted(range: &Range, degrees: Degrees, inputs: &[Vec<f64>], states: &[Vec<f64>]) -> Option<Self> {
        let shown: Vec<Vec<f64>> = inputs.iter().cycle().take(crate::lanes::MAX_LANES).cloned().collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::products::realtime::domain::towards_faces;

    #[test]
    fn a_polynomial_of_the_degrees_is_met() {
        let range = Range { low: [1.0, -2.0, 0.0], high: [3.0, 2.0, 0.5], wrench: [10.0, 10.0, 10.0, 0.0, 0.0, 0.0] };
        let state = |x: &[f64]| vec![x[0] * x[1] * x[2] - 2.0, x[2] * x[4] + x[0] * x[0] * x[1]];
        let inputs: Vec<Vec<f64>> = (0..100)
            .map(|index| {
                let place = towards_faces(index);
                let at = |i: usize| 0.5 * (range.low[i] + range.high[i] + place[i] * (range.high[i] - range.low[i]));
                (0..3).map(at).chain((0..6).map(|i| place[3 + i] * range.wrench[i])).collect()
            })
            .collect();
        let states: Vec<Vec<f64>> = inputs.iter().map(|inputs| state(inputs)).collect();
        let start = Start::fitted(&range, (3, Some(1)), &inputs, &states).unwrap();
        assert_eq!(start.coefficients.len(), 20 + 3 * 4);
        let inputs = [1.7, 0.3, 0.2, 4.0, -6.0, 1.0, 0.0, 0.0, 0.0];
        for (found, expected) in start.at(&inputs).into_iter().zip(state(&inputs)) {
            assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
        }
        assert!(Start::fitted(&range, (7, None), &vec![inputs.to_vec(); 20], &vec![vec![1.0]; 20]).is_none());
    }
}
