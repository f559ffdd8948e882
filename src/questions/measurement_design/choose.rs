//! Which measurements tell most: one after another, then in exchange for others as long as that tells more (Fedorov 1972); and how far the
//! unknowns are known with more and more of them, and of random ones.

use nalgebra::{Cholesky, DMatrix, Dyn};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use crate::{input::error::Result, questions::identification::half_width, work::Work};

/// Exchanges end after so many rounds over what was chosen.
const ROUNDS: usize = 20;
/// An exchange must tell more by this much, in the criterion's own measure.
const LEAST_GAIN: f64 = 1e-9;

/// What is made large; both measures grow by the logarithm of what they measure.
#[derive(Debug, Clone)]
pub enum Criterion {
    /// `ln det` of the information.
    AllNumbers,
    /// Less `ln` of the mean square error of predictions, `tr(T M⁻¹)` with this matrix T.
    Tested(DMatrix<f64>),
}

/// Rows of candidates, in standard deviations, and what is known without them.
#[derive(Debug, Clone)]
pub struct Choice<'a> {
    /// A row for each reading, a column for each unknown.
    pub candidates: &'a [DMatrix<f64>],
    /// Information that there is already; positive definite.
    pub known: DMatrix<f64>,
    /// What is made large.
    pub criterion: Criterion,
}

fn information(rows: &DMatrix<f64>) -> DMatrix<f64> {
    rows.transpose() * rows
}

impl Choice<'_> {
    /// The information of what is known and of these candidates.
    pub fn information(&self, chosen: &[usize]) -> DMatrix<f64> {
        chosen.iter().fold(self.known.clone(), |sum, &i| sum + information(&self.candidates[i]))
    }

    /// The measure of this information; `None` where it is not positive definite.
    pub fn measure(&self, information: &DMatrix<f64>) -> Option<f64> {
        let factors = Cholesky::new(information.clone())?;
        Some(match &self.criterion {
            Criterion::AllNumbers => 2.0 * factors.l().diagonal().map(f64::ln).sum(),
            Criterion::Tested(tested) => -factors.solve(tested).trace().ln(),
        })
    }

    /// What each candidate adds to the measure, those of `taken` nothing.
    pub fn gains(&self, information: &DMatrix<f64>, taken: &[usize]) -> Vec<f64> {
        let Some(factors) = Cholesky::new(information.clone()) else { return vec![0.0; self.candidates.len()] };
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

    /// With `M⁻¹` by `factors`: `det(M + AᵀA) = det M det(1 + A M⁻¹ Aᵀ)`, and its inverse by Woodbury's formula.
    fn gain(&self, factors: &Cholesky<f64, Dyn>, total: f64, rows: &DMatrix<f64>) -> Option<f64> {
        let spread = factors.solve(&rows.transpose());
        let inner = Cholesky::new(DMatrix::identity(rows.nrows(), rows.nrows()) + rows * &spread)?;
        Some(match &self.criterion {
            Criterion::AllNumbers => 2.0 * inner.l().diagonal().map(f64::ln).sum(),
            Criterion::Tested(tested) => {
                let less = inner.solve(&(spread.transpose() * tested * &spread)).trace();
                -(1.0 - less / total).max(f64::MIN_POSITIVE).ln()
            }
        })
    }

    /// The candidate that tells most beside those of `taken`; the first of equals.
    fn best(&self, information: &DMatrix<f64>, taken: &[usize]) -> Option<(usize, f64)> {
        let gains = self.gains(information, taken).into_iter().enumerate();
        gains.filter(|(_, gain)| gain.is_finite()).fold(None, |best: Option<(usize, f64)>, (i, gain)| match best {
            Some((_, most)) if gain <= most => best,
            _ => Some((i, gain)),
        })
    }

    /// Up to `count` different candidates, each telling most beside those before it.
    ///
    /// # Errors
    /// The work was stopped.
    pub fn chosen(&self, count: usize, work: &Work) -> Result<Vec<usize>> {
        let mut chosen = Vec::new();
        let mut information = self.known.clone();
        while chosen.len() < count {
            work.check()?;
            let Some((next, _)) = self.best(&information, &chosen) else { break };
            information += self::information(&self.candidates[next]);
            chosen.push(next);
        }
        self.exchange(&mut chosen, work)?;
        self.ordered(chosen, work)
    }

    fn exchange(&self, chosen: &mut [usize], work: &Work) -> Result<()> {
        for _ in 0..ROUNDS {
            let mut has_changed = false;
            for place in 0..chosen.len() {
                work.check()?;
                let others: Vec<usize> = (0..chosen.len()).filter(|&k| k != place).map(|k| chosen[k]).collect();
                let without = self.information(&others);
                let own = self.gains(&without, &others)[chosen[place]];
                let Some((next, gain)) = self.best(&without, chosen) else { continue };
                if gain > own + LEAST_GAIN {
                    chosen[place] = next;
                    has_changed = true;
                }
            }
            if !has_changed {
                break;
            }
        }
        Ok(())
    }

    /// So that each tells most of those that are left.
    fn ordered(&self, mut left: Vec<usize>, work: &Work) -> Result<Vec<usize>> {
        left.sort_unstable();
        let mut ordered = Vec::with_capacity(left.len());
        let mut information = self.known.clone();
        while !left.is_empty() {
            work.check()?;
            let gains = self.gains(&information, &[]);
            let most = (0..left.len()).fold(0, |best, k| if gains[left[k]] > gains[left[best]] { k } else { best });
            let next = left.remove(most);
            information += self::information(&self.candidates[next]);
            ordered.push(next);
        }
        Ok(ordered)
    }
}

/// How far the unknowns are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Widths {
    /// Half the 95 % interval of each, in its coordinate.
    pub each: Vec<f64>,
    /// RMS error of the tool where it is predicted for the tested rows, by the intervals alone, mm.
    pub tested_mm: Option<f64>,
}

impl Widths {
    /// The unknown that is known least, and half its interval.
    pub fn widest(&self) -> Option<(usize, f64)> {
        self.each.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

fn known(choice: &Choice<'_>, chosen: &[usize]) -> Option<Widths> {
    let covariance = Cholesky::new(choice.information(chosen))?.inverse();
    let each = covariance.diagonal().iter().map(|variance| half_width(None) * variance.sqrt()).collect();
    let tested_mm = match &choice.criterion {
        Criterion::AllNumbers => None,
        Criterion::Tested(tested) => Some((tested * &covariance).trace().max(0.0).sqrt()),
    };
    Some(Widths { each, tested_mm })
}

/// With the first 0, 1, 2, … of `chosen`.
pub fn widths(choice: &Choice<'_>, chosen: &[usize]) -> Vec<Widths> {
    (0..=chosen.len()).filter_map(|count| known(choice, &chosen[..count])).collect()
}

/// With 0 to `count` random candidates: the median of each over `draws`, from seeds that are always the same.
pub(super) fn random(choice: &Choice<'_>, count: usize, draws: usize) -> Vec<Widths> {
    let draw = |seed: u64| {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut all: Vec<usize> = (0..choice.candidates.len()).collect();
        for k in 0..count {
            all.swap(k, random.random_range(k..choice.candidates.len()));
        }
        widths(choice, &all[..count])
    };
    let drawn: Vec<Vec<Widths>> = (0..draws as u64).into_par_iter().map(draw).collect();
    let unknowns = choice.known.nrows();
    let at = |count: usize| {
        let of = |value: &dyn Fn(&Widths) -> f64| {
            let mut values: Vec<f64> = drawn.iter().filter_map(|all| all.get(count)).map(value).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(f64::INFINITY)
        };
        let is_tested = matches!(choice.criterion, Criterion::Tested(_));
        Widths {
            each: (0..unknowns).map(|k| of(&|own| own.each[k])).collect(),
            tested_mm: is_tested.then(|| of(&|own| own.tested_mm.unwrap_or(f64::INFINITY))),
        }
    };
    if draws == 0 { Vec::new() } else { (0..=count).map(at).collect() }
}
