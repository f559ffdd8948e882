//! Intervals by the profile likelihood: how far an unknown can be moved, all others refitted, until the residual grows by more than chance
//! explains. They hold where the model is far from linear in an unknown, and linear intervals do not.

use nalgebra::DVector;
use rayon::prelude::*;

use super::{
    fit::{Fit, LEAST_SCATTER_MM, Noise, Search, measured_values},
    measurements::Measurement,
    model::{machine_with, predict_values},
    spec::LossSpec,
    unknown::Unknown,
};
use crate::{
    input::error::{Error, Result},
    simulation::Failure,
    work::Work,
};

/// Accuracy of an end of the interval, as a share of its distance from the best fit.
const NEAR_ENOUGH: f64 = 0.02;
/// Most values of the unknown at which the others are refitted, for each end.
const PLACES: usize = 8;
/// Most linear half widths from the best fit at which an end is searched.
const FARTHER: f64 = 20.0;

/// One end of a profile-likelihood interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum IntervalEnd {
    /// At this coordinate of the unknown.
    At(f64),
    /// Nowhere: the residual does not grow enough on that side.
    Unbounded,
    /// Not known: the other unknowns could not be refitted where it may be.
    NotFound,
}

/// Growth of the residual from the best fit to another value of an unknown, in standard deviations.
#[derive(Debug, Clone, Copy)]
enum Growth {
    /// The growth itself.
    By(f64),
    /// An upper bound: the refit of the other unknowns did not converge.
    AtMost(f64),
}

/// Profile likelihood of each unknown around a fit.
pub struct Profile<'a> {
    search: Search<'a>,
    fit: &'a Fit,
    measurements: &'a [&'a Measurement],
    /// Half width of a 95 % interval in standard deviations.
    quantile: f64,
}

impl<'a> Profile<'a> {
    /// Prepares profiles around `fit`; `None` for losses other than squares, which are no likelihoods, and without noise.
    pub fn new(search: Search<'a>, fit: &'a Fit, measurements: &'a [&'a Measurement], quantile: f64) -> Option<Self> {
        let is_noisy = !search.noise.is_estimated || fit.scale > LEAST_SCATTER_MM;
        let is_likelihood = search.loss == LossSpec::Squares && quantile.is_finite() && is_noisy;
        is_likelihood.then_some(Self { search, fit, measurements, quantile })
    }

    /// Returns lower and upper end of the profile-likelihood interval of each of `unknowns` (by index), on the current rayon pool; `Err` if
    /// the work was stopped.
    pub fn interval_ends(&self, unknowns: &[usize], work: &Work) -> Result<Vec<[IntervalEnd; 2]>> {
        let ends_of = |&k: &usize| {
            let ends = [-1.0, 1.0].map(|side| self.find_end(k, side));
            work.check()?;
            Ok(ends)
        };
        unknowns.par_iter().map(ends_of).collect()
    }

    /// Finds the end of the interval of unknown `k` on one side (−1 or 1): where the growth of the residual reaches the quantile.
    fn find_end(&self, k: usize, side: f64) -> IntervalEnd {
        let width = self.quantile * self.fit.std(k);
        let (mut inside, mut outside) = (0.0, None::<(f64, f64)>);
        let (mut rise_inside, mut is_unknown) = (0.0, false);
        let mut distance = width;
        for _ in 0..PLACES {
            let x = self.fit.x[k] + side * distance;
            if self.search.unknowns[k].is_at_limit(x) || distance > FARTHER * width {
                return IntervalEnd::Unbounded;
            }
            // Where the machine does not settle any more, nothing fits.
            let (rise, is_known) = match self.residual_growth(k, x).unwrap_or(Growth::By(f64::INFINITY)) {
                Growth::By(rise) => (rise, true),
                // No more than what is within the interval is within.
                Growth::AtMost(rise) if rise < self.quantile => (rise, true),
                Growth::AtMost(_) => (f64::INFINITY, false),
            };
            if (rise - self.quantile).abs() < NEAR_ENOUGH * self.quantile {
                return IntervalEnd::At(self.fit.x[k] + side * distance * self.quantile / rise);
            }
            if rise < self.quantile {
                (inside, rise_inside) = (distance, rise)
            } else {
                (outside, is_unknown) = (Some((distance, rise)), !is_known)
            }
            distance = match outside {
                None => inside * (self.quantile / rise_inside.max(0.25 * self.quantile)).min(4.0),
                Some((out, rise)) if rise.is_finite() => {
                    inside + (out - inside) * (self.quantile - rise_inside) / (rise - rise_inside)
                }
                Some((out, _)) => 0.5 * (inside + out),
            };
        }
        match outside {
            None => IntervalEnd::Unbounded,
            Some(_) if is_unknown => IntervalEnd::NotFound,
            Some(_) => IntervalEnd::At(self.fit.x[k] + side * distance),
        }
    }

    /// Refits the others with unknown `k` at coordinate `x`; returns the root of the growth of the sum of squares, in standard deviations.
    fn residual_growth(&self, k: usize, x: f64) -> std::result::Result<Growth, Failure> {
        let Search { machine, unknowns, priors, noise, .. } = self.search;
        let fixed = [unknowns[k].clone()];
        let invalid_machine = |error: Error| Failure { status: "no_machine".into(), reason: error.to_string() };
        let machine = machine_with(machine, &fixed, &DVector::from_element(1, x)).map_err(invalid_machine)?;
        let others: Vec<usize> = (0..unknowns.len()).filter(|&other| other != k).collect();
        let free: Vec<Unknown> = others.iter().map(|&other| unknowns[other].clone()).collect();
        let free_index = |other: usize| others.iter().position(|&index| index == other);
        let free_priors: Vec<(usize, f64, f64)> =
            priors.iter().filter_map(|&(other, at, std)| Some((free_index(other)?, at, std))).collect();
        // The noise is that of the fit: a likelihood of where it has been estimated.
        let length = if noise.is_estimated { Some(self.fit.scale) } else { noise.length };
        let noise = Noise { length, is_estimated: false, ..noise };
        let search = Search { machine: &machine, unknowns: &free, priors: &free_priors, noise, ..self.search };
        let towards = self.fit.covariance.column(k) * ((x - self.fit.x[k]) / self.fit.covariance[(k, k)]);
        // One that fits best at the end of where it is sought stays there: how it moves with the others is not linear.
        let moved = |other: usize| if unknowns[other].is_at_limit(self.fit.x[other]) { 0.0 } else { towards[other] };
        let start = others.iter().map(|&other| self.fit.x[other] + moved(other));
        let start = search.within_limits(DVector::from_iterator(free.len(), start));
        let (x_free, residuals, is_converged) = match free.is_empty() {
            false => {
                let refit = search.fit(self.measurements, &start).map_err(|(_, failure)| failure)?;
                (refit.x, refit.residuals, refit.is_converged)
            }
            true => {
                let there =
                    predict_values(&machine, &free, &start, self.measurements).map_err(|(_, failure)| failure)?;
                (start, measured_values(self.measurements) - there, true)
            }
        };
        let squares = |residuals: &DVector<f64>| residuals.component_div(&self.fit.stds).norm_squared();
        let prior_squares = |values: &dyn Fn(usize) -> f64| -> f64 {
            priors.iter().map(|&(other, at, std)| ((values(other) - at) / std).powi(2)).sum()
        };
        let there = |other: usize| free_index(other).map_or(x, |index| x_free[index]);
        let rise = squares(&residuals) + prior_squares(&there)
            - squares(&self.fit.residuals)
            - prior_squares(&|other| self.fit.x[other]);
        // As intervals are, widened by what is left beyond the noise that was given.
        let rise = (rise.max(0.0) / self.fit.inflation).sqrt();
        Ok(if is_converged { Growth::By(rise) } else { Growth::AtMost(rise) })
    }
}
