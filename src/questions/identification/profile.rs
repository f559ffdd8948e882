//! Intervals by the profile of the likelihood: how far an unknown can be moved, all others fitted anew, until what is left grows by
//! more than chance explains. Where the machine is far from linear in an unknown, they are right and the linear ones are not.

use nalgebra::DVector;
use rayon::prelude::*;

use super::{
    fit::{Fit, LEAST_SCATTER_MM, Noise, Search, measured},
    measurements::Measurement,
    model::{machine_at, values_at},
    spec::LossSpec,
    unknown::Unknown,
};
use crate::{
    input::error::{Error, Result},
    simulation::Failure,
    work::Work,
};

/// An end is found to this share of its distance.
const NEAR_ENOUGH: f64 = 0.02;
/// Places at which the others are fitted anew, for each end.
const PLACES: usize = 8;
/// An end is sought no farther than so many linear half widths.
const FARTHER: f64 = 20.0;

/// Where an interval ends on one side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// Here, in the coordinate of its unknown.
    At(f64),
    /// What is left does not grow enough on that side.
    Nowhere,
    /// The others could not be fitted where it may end.
    Unknown,
}

/// By how much what is left grows, in standard deviations.
#[derive(Debug, Clone, Copy)]
enum Rise {
    By(f64),
    /// The others are not fitted as well as they can be.
    AtMost(f64),
}

/// The profile of each unknown's likelihood, to be asked where it has risen.
pub struct Profile<'a> {
    search: Search<'a>,
    fit: &'a Fit,
    measurements: &'a [&'a Measurement],
    /// Half widths of intervals in standard deviations.
    quantile: f64,
}

impl<'a> Profile<'a> {
    /// Around `fit`; `None` for losses other than squares, which are no likelihoods, and where nothing is left.
    pub fn new(search: Search<'a>, fit: &'a Fit, measurements: &'a [&'a Measurement], quantile: f64) -> Option<Self> {
        let is_noisy = !search.noise.is_estimated || fit.scale > LEAST_SCATTER_MM;
        let is_likelihood = search.loss == LossSpec::Squares && quantile.is_finite() && is_noisy;
        is_likelihood.then_some(Self { search, fit, measurements, quantile })
    }

    /// Both ends for each of `unknowns` (by index), on the current rayon pool.
    ///
    /// # Errors
    /// The work was stopped.
    pub fn ends(&self, unknowns: &[usize], work: &Work) -> Result<Vec<[End; 2]>> {
        let of = |&k: &usize| {
            work.check()?;
            Ok([-1.0, 1.0].map(|side| self.end(k, side)))
        };
        unknowns.par_iter().map(of).collect()
    }

    /// The end on one side: where the root of the rise, in standard deviations, is the quantile.
    fn end(&self, k: usize, side: f64) -> End {
        let width = self.quantile * self.fit.std(k);
        let (mut inside, mut outside) = (0.0, None::<(f64, f64)>);
        let (mut rise_inside, mut is_unknown) = (0.0, false);
        let mut at = width;
        for _ in 0..PLACES {
            let x = self.fit.x[k] + side * at;
            if self.search.unknowns[k].is_at_end(x) || at > FARTHER * width {
                return End::Nowhere;
            }
            // Where the machine does not settle any more, nothing fits.
            let (rise, is_known) = match self.rise(k, x).unwrap_or(Rise::By(f64::INFINITY)) {
                Rise::By(rise) => (rise, true),
                // No more than what is within the interval is within.
                Rise::AtMost(rise) if rise < self.quantile => (rise, true),
                Rise::AtMost(_) => (f64::INFINITY, false),
            };
            if (rise - self.quantile).abs() < NEAR_ENOUGH * self.quantile {
                return End::At(self.fit.x[k] + side * at * self.quantile / rise);
            }
            if rise < self.quantile {
                (inside, rise_inside) = (at, rise)
            } else {
                (outside, is_unknown) = (Some((at, rise)), !is_known)
            }
            at = match outside {
                None => inside * (self.quantile / rise_inside.max(0.25 * self.quantile)).min(4.0),
                Some((out, rise)) if rise.is_finite() => {
                    inside + (out - inside) * (self.quantile - rise_inside) / (rise - rise_inside)
                }
                Some((out, _)) => 0.5 * (inside + out),
            };
        }
        match outside {
            None => End::Nowhere,
            Some(_) if is_unknown => End::Unknown,
            Some(_) => End::At(self.fit.x[k] + side * at),
        }
    }

    /// The root of twice the rise of what is left, the others fitted anew with unknown `k` at `x`.
    fn rise(&self, k: usize, x: f64) -> std::result::Result<Rise, Failure> {
        let Search { machine, unknowns, priors, noise, .. } = self.search;
        let fixed = [unknowns[k].clone()];
        let none = |error: Error| Failure { status: "no_machine".into(), reason: error.to_string() };
        let machine = machine_at(machine, &fixed, &DVector::from_element(1, x)).map_err(none)?;
        let others: Vec<usize> = (0..unknowns.len()).filter(|&other| other != k).collect();
        let kept: Vec<Unknown> = others.iter().map(|&other| unknowns[other].clone()).collect();
        let place = |other: usize| others.iter().position(|&own| own == other);
        let their_priors: Vec<(usize, f64, f64)> =
            priors.iter().filter_map(|&(other, at, std)| Some((place(other)?, at, std))).collect();
        // The noise is that of the fit: a likelihood of where it has been estimated.
        let length = if noise.is_estimated { Some(self.fit.scale) } else { noise.length };
        let noise = Noise { length, is_estimated: false, ..noise };
        let search = Search { machine: &machine, unknowns: &kept, priors: &their_priors, noise, ..self.search };
        let towards = self.fit.covariance.column(k) * ((x - self.fit.x[k]) / self.fit.covariance[(k, k)]);
        // One that fits best at the end of where it is sought stays there: how it moves with the others is not linear.
        let moved = |other: usize| if unknowns[other].is_at_end(self.fit.x[other]) { 0.0 } else { towards[other] };
        let start = others.iter().map(|&other| self.fit.x[other] + moved(other));
        let start = search.within(DVector::from_iterator(kept.len(), start));
        let (x_found, residuals, is_found) = match kept.is_empty() {
            false => {
                let found = search.fit(self.measurements, &start).map_err(|(_, failure)| failure)?;
                (found.x, found.residuals, found.is_found)
            }
            true => {
                let there = values_at(&machine, &kept, &start, self.measurements).map_err(|(_, failure)| failure)?;
                (start, measured(self.measurements) - there, true)
            }
        };
        let squares = |residuals: &DVector<f64>| residuals.component_div(&self.fit.stds).norm_squared();
        let of_priors = |values: &dyn Fn(usize) -> f64| -> f64 {
            priors.iter().map(|&(other, at, std)| ((values(other) - at) / std).powi(2)).sum()
        };
        let there = |other: usize| place(other).map_or(x, |own| x_found[own]);
        let rise = squares(&residuals) + of_priors(&there)
            - squares(&self.fit.residuals)
            - of_priors(&|other| self.fit.x[other]);
        // As intervals are, widened by what is left beyond the noise that was given.
        let rise = (rise.max(0.0) / self.fit.inflation).sqrt();
        Ok(if is_found { Rise::By(rise) } else { Rise::AtMost(rise) })
    }
}
