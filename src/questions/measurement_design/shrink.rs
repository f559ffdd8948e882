//! How far the unknowns are known with more and more measurements, of those that were chosen and of random ones.

use nalgebra::Cholesky;
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use super::choose::{Choice, Criterion};
use crate::questions::identification::half_width;

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
