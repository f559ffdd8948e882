//! Optimal design: chooses the most informative measurements, one after another, then by exchange (Fedorov 1972), and compares random ones.

use nalgebra::{Cholesky, DMatrix, Dyn};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use crate::{input::error::Result, questions::identification::half_width, work::Work};

/// Most rounds of exchange over the chosen candidates.
const ROUNDS: usize = 20;
/// Smallest gain of the criterion for which candidates are exchanged.
const LEAST_GAIN: f64 = 1e-9;

/// Design criterion, which is maximised.
#[derive(Debug, Clone)]
pub enum Criterion {
    /// `ln det` of the information matrix M (D-optimality).
    AllNumbers,
    /// Minus `ln` of the mean square prediction error, `tr(T M⁻¹)` with this matrix T.
    Tested(DMatrix<f64>),
}

/// A design problem: candidates, information known without them, and criterion.
#[derive(Debug, Clone)]
pub struct DesignProblem<'a> {
    /// Jacobian of each candidate over standard deviations: a row for each reading, a column for each unknown.
    pub candidates: &'a [DMatrix<f64>],
    /// Information matrix known without candidates; positive definite.
    pub known: DMatrix<f64>,
    /// Criterion to maximise.
    pub criterion: Criterion,
}

/// Returns the information matrix `JᵀJ` of readings with these Jacobian rows over their standard deviations.
fn information(rows: &DMatrix<f64>) -> DMatrix<f64> {
    rows.transpose() * rows
}

impl DesignProblem<'_> {
    /// Returns the information matrix of what is known beforehand and of the chosen candidates (indices).
    pub fn information(&self, chosen: &[usize]) -> DMatrix<f64> {
        chosen.iter().fold(self.known.clone(), |sum, &i| sum + information(&self.candidates[i]))
    }

    /// Returns by how much each candidate raises the criterion from this information matrix; minus infinity for those in `taken` (indices).
    pub fn gains(&self, information: &DMatrix<f64>, taken: &[usize]) -> Vec<f64> {
        let Some(factors) = Cholesky::new(information.clone()) else {
            return vec![f64::NEG_INFINITY; self.candidates.len()];
        };
        let total = match &self.criterion {
            Criterion::AllNumbers => 0.0,
            Criterion::Tested(tested) => factors.solve(tested).trace(),
        };
        let gain = |(i, rows): (usize, &DMatrix<f64>)| match taken.contains(&i) {
            true => f64::NEG_INFINITY,
            false => self.gain(&factors, total, rows).unwrap_or(f64::NEG_INFINITY),
        };
        self.candidates.par_iter().enumerate().map(gain).collect()
    }

    /// Returns the gain by a candidate's `rows`, with `M⁻¹` by `factors`: `det(M + AᵀA) = det M det(1 + A M⁻¹ Aᵀ)`, `tr` by Woodbury's formula;
    /// `None` where numerically `1 + A M⁻¹ Aᵀ` is not positive definite.
    fn gain(&self, factors: &Cholesky<f64, Dyn>, total: f64, rows: &DMatrix<f64>) -> Option<f64> {
        let spread = factors.solve(&rows.transpose());
        let inner = Cholesky::new(DMatrix::identity(rows.nrows(), rows.nrows()) + rows * &spread)?;
        Some(match &self.criterion {
            Criterion::AllNumbers => 2.0 * inner.l().diagonal().map(libm::log).sum(),
            Criterion::Tested(tested) => {
                let less = inner.solve(&(spread.transpose() * tested * &spread)).trace();
                -libm::log((1.0 - less / total).max(f64::MIN_POSITIVE))
            }
        })
    }

    /// Returns the candidate with the largest gain that is not in `taken`, and its gain; the first of equals. `None` if none is left.
    fn best_candidate(&self, information: &DMatrix<f64>, taken: &[usize]) -> Option<(usize, f64)> {
        let gains = self.gains(information, taken).into_iter().enumerate();
        gains.filter(|(_, gain)| gain.is_finite()).fold(None, |best: Option<(usize, f64)>, (i, gain)| match best {
            Some((_, largest)) if gain <= largest => best,
            _ => Some((i, gain)),
        })
    }

    /// Returns the indices of up to `count` different candidates, the most informative first; `Err` if the work was stopped.
    pub fn choose(&self, count: usize, work: &Work) -> Result<Vec<usize>> {
        let mut chosen = Vec::new();
        let mut information = self.known.clone();
        while chosen.len() < count {
            work.check()?;
            let Some((next, _)) = self.best_candidate(&information, &chosen) else { break };
            information += self::information(&self.candidates[next]);
            chosen.push(next);
        }
        self.exchange(&mut chosen, work)?;
        self.ordered_by_gain(chosen, work)
    }

    /// Exchanges chosen candidates for others while the criterion grows, at most [`ROUNDS`] rounds; `Err` if the work was stopped.
    fn exchange(&self, chosen: &mut [usize], work: &Work) -> Result<()> {
        for _ in 0..ROUNDS {
            let mut has_changed = false;
            for position in 0..chosen.len() {
                work.check()?;
                let others: Vec<usize> = (0..chosen.len()).filter(|&k| k != position).map(|k| chosen[k]).collect();
                let without = self.information(&others);
                let current_gain = self.gains(&without, &others)[chosen[position]];
                let Some((next, gain)) = self.best_candidate(&without, chosen) else { continue };
                if gain > current_gain + LEAST_GAIN {
                    chosen[position] = next;
                    has_changed = true;
                }
            }
            if !has_changed {
                break;
            }
        }
        Ok(())
    }

    /// Orders candidates (indices) so that each has the largest gain after those before it; `Err` if the work was stopped.
    fn ordered_by_gain(&self, mut left: Vec<usize>, work: &Work) -> Result<Vec<usize>> {
        left.sort_unstable();
        let mut ordered_by_gain = Vec::with_capacity(left.len());
        let mut information = self.known.clone();
        while !left.is_empty() {
            work.check()?;
            let gains = self.gains(&information, &[]);
            let largest = (0..left.len()).fold(0, |best, k| if gains[left[k]] > gains[left[best]] { k } else { best });
            let next = left.remove(largest);
            information += self::information(&self.candidates[next]);
            ordered_by_gain.push(next);
        }
        Ok(ordered_by_gain)
    }
}

/// Half widths of the 95 % intervals that measurements give.
#[derive(Debug, Clone, PartialEq)]
pub struct HalfWidths {
    /// Half the 95 % interval of each unknown, in its coordinate.
    pub each: Vec<f64>,
    /// RMS error of the tool predicted for the tested rows, by the intervals alone, mm; `None` with another criterion.
    pub tested_mm: Option<f64>,
}

impl HalfWidths {
    /// Returns the index of the unknown with the widest interval, and its half width; `None` without unknowns.
    pub fn widest(&self) -> Option<(usize, f64)> {
        self.each.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Returns the half widths with the chosen candidates (indices); `None` where the information matrix is not positive definite.
fn widths_with(problem: &DesignProblem<'_>, chosen: &[usize]) -> Option<HalfWidths> {
    let covariance = Cholesky::new(problem.information(chosen))?.inverse();
    let each = covariance.diagonal().iter().map(|variance| half_width(None) * variance.sqrt()).collect();
    let tested_mm = match &problem.criterion {
        Criterion::AllNumbers => None,
        Criterion::Tested(tested) => Some((tested * &covariance).trace().max(0.0).sqrt()),
    };
    Some(HalfWidths { each, tested_mm })
}

/// Returns the half widths with the first 0, 1, 2, … of the chosen candidates (indices), up to all.
pub fn widths(problem: &DesignProblem<'_>, chosen: &[usize]) -> Vec<HalfWidths> {
    (0..=chosen.len()).map_while(|count| widths_with(problem, &chosen[..count])).collect()
}

/// Returns the half widths with 0 to `count` random candidates: the median of each over `draws`, from fixed seeds; none without draws.
pub(super) fn random_widths(problem: &DesignProblem<'_>, count: usize, draws: usize) -> Vec<HalfWidths> {
    let draw = |seed: u64| {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut order: Vec<usize> = (0..problem.candidates.len()).collect();
        for k in 0..count {
            order.swap(k, random.random_range(k..problem.candidates.len()));
        }
        widths(problem, &order[..count])
    };
    let drawn: Vec<Vec<HalfWidths>> = (0..draws as u64).into_par_iter().map(draw).collect();
    let unknowns = problem.known.nrows();
    let medians_at = |count: usize| {
        let median_of = |value: &dyn Fn(&HalfWidths) -> f64| {
            let mut values: Vec<f64> = drawn.iter().filter_map(|order| order.get(count)).map(value).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(f64::INFINITY)
        };
        let is_tested = matches!(problem.criterion, Criterion::Tested(_));
        HalfWidths {
            each: (0..unknowns).map(|k| median_of(&|widths_drawn| widths_drawn.each[k])).collect(),
            tested_mm: is_tested.then(|| median_of(&|widths_drawn| widths_drawn.tested_mm.unwrap_or(f64::INFINITY))),
        }
    };
    if draws == 0 { Vec::new() } else { (0..=count).map(medians_at).collect() }
}
