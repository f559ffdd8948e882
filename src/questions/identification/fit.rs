//! Fits unknown parameters to measurements: Gauss–Newton steps along the identifiable directions, damped where they do not descend.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{
    measurements::{Measurement, Reading},
    model::{Predicted, predict, predict_values},
    scatter,
    spec::LossSpec,
    unknown::Unknown,
};
use crate::{machine::Machine, simulation::Failure, work::Work};

/// Most steps of a fit, and most trials of damping for one step.
const STEPS: usize = 60;
const TRIES: usize = 12;
/// Converged: a step gains less than this share of the cost.
const FOUND: f64 = 1e-10;
/// Share that counts as converged where rounding keeps steps from gaining it.
const NEARLY_FOUND: f64 = 1e-6;
/// Converged: no coordinate would change by more. Without noise, the residual is the rounding of solves.
const LEAST_STEP: f64 = 1e-6;
/// Smallest scatter, mm: less is rounding of the solves.
pub(super) const LEAST_SCATTER_MM: f64 = 1e-8;
/// Smallest information of an identifiable direction, as a share of the largest.
const RANK: f64 = 1e-13;

/// A fitting problem: a machine, its unknowns with priors, noise and loss. Measurements are given to each fit.
#[derive(Clone, Copy)]
pub struct Search<'a> {
    /// Machine whose parameters are the start of the fit.
    pub machine: &'a Machine,
    /// Parameters to fit.
    pub unknowns: &'a [Unknown],
    /// Gaussian priors: index of the unknown, expected coordinate, standard deviation of that coordinate.
    pub priors: &'a [(usize, f64, f64)],
    /// Standard deviations of the readings, or that they are estimated.
    pub noise: Noise,
    /// Loss function, which says how much outliers count.
    pub loss: LossSpec,
    /// The work of which it is a part: where that is stopped, a search ends without an answer.
    pub work: &'a Work,
}

/// Standard deviations of readings that have none of their own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of lengths, mm, if given.
    pub length: Option<f64>,
    /// Standard deviation of rotations, rad, if given.
    pub rotation: Option<f64>,
    /// Whether the noise is estimated from the scatter of the residuals, as no reading has one.
    pub is_estimated: bool,
}

impl Noise {
    /// Returns the standard deviation of a reading, mm or rad; 1 where none is given, as it is estimated.
    pub fn of(&self, reading: &Reading) -> f64 {
        self.given_std(reading).unwrap_or(1.0)
    }

    /// Returns the standard deviation of a reading, mm or rad; `None` if neither the measurement file nor the study gives it.
    pub fn given_std(&self, reading: &Reading) -> Option<f64> {
        reading.std.or(if reading.quantity.is_rotation() { self.rotation } else { self.length })
    }
}

/// A fit of the unknowns to measurements, with the covariance of their coordinates.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Fitted coordinates of the unknowns.
    pub x: DVector<f64>,
    /// Predicted readings and Jacobian at the fit.
    pub predicted: Predicted,
    /// Residuals, measured less predicted, mm and rad.
    pub residuals: DVector<f64>,
    /// Standard deviation of each reading, mm or rad, given or estimated from the scatter.
    pub stds: DVector<f64>,
    /// Weight of each reading by the loss function, 1 for least squares.
    pub weights: DVector<f64>,
    /// Ratio of the scatter of residuals to the given noise; where none is given, the estimated standard deviation, mm.
    pub scale: f64,
    /// Covariance of the coordinates in the identifiable subspace; directions of `null_space` are left out.
    pub covariance: DMatrix<f64>,
    /// Orthonormal basis of the directions of coordinates that are not identifiable.
    pub null_space: Vec<DVector<f64>>,
    /// Factor on the covariance of plain least squares: by a robust loss, by residuals beyond the given noise, and by the design effect.
    pub inflation: f64,
    /// Design effect: variance of the estimates over that by independent readings; above 1 where readings of a pose share an error.
    pub design_effect: f64,
    /// Whether the residual is larger than the given noise makes it once in a hundred times.
    pub is_beyond_noise: bool,
    /// Information matrix `JᵀWJ` of the readings over their standard deviations, with priors.
    pub information: DMatrix<f64>,
    /// Number of steps taken.
    pub steps: usize,
    /// Whether the search converged.
    pub is_converged: bool,
}

/// Where a search ended, as in [`Fit`]; `scale` is the factor on standard deviations of readings.
struct SearchResult {
    x: DVector<f64>,
    predicted: Predicted,
    scale: f64,
    steps: usize,
    is_converged: bool,
}

/// Returns the values of all readings of `measurements` in order, mm and rad.
pub(super) fn measured_values(measurements: &[&Measurement]) -> DVector<f64> {
    let values: Vec<f64> = measurements.iter().flat_map(|m| m.readings.iter().map(|reading| reading.value)).collect();
    DVector::from_vec(values)
}

impl Search<'_> {
    /// Fits the unknowns to `measurements` from coordinates `start`; at the limit of its search an unknown stops.
    ///
    /// # Errors
    /// At `start`, no equilibrium at a measurement (its index in `measurements`, and why), or no valid machine (`None`, and why).
    pub fn fit(
        &self,
        measurements: &[&Measurement],
        start: &DVector<f64>,
    ) -> std::result::Result<Fit, (Option<usize>, Failure)> {
        let noise_stds = DVector::from_iterator(
            measurements.iter().map(|m| m.readings.len()).sum(),
            measurements.iter().flat_map(|m| m.readings.iter().map(|reading| self.noise.of(reading))),
        );
        let values = measured_values(measurements);
        let mut x = start.clone();
        let mut predicted = predict(self.machine, self.unknowns, &x, measurements, self.unknowns)?;
        let mut scale = self.noise_scale(&((&values - &predicted.values).component_div(&noise_stds)));
        let (mut steps, mut is_converged, mut damping) = (0, false, 1e-6);
        while steps < STEPS && self.work.check().is_ok() {
            let r = (&values - &predicted.values).component_div(&noise_stds) / scale;
            let (mut information, mut gradient) = self.normal_equations(&predicted, &r, &noise_stds, scale, &x);
            // At the end of where it is sought, an unknown that would go farther stays.
            let mut fixed = vec![false; x.len()];
            let (mut eigen, mut full_step);
            loop {
                eigen = SymmetricEigen::new(information.clone());
                full_step = damped_step(&eigen, &gradient, 0.0);
                let goes_out = |k: &usize| {
                    let is_outward = full_step[*k] * x[*k] > 0.0 || gradient[*k] * x[*k] > 0.0;
                    !fixed[*k] && self.unknowns[*k].is_at_limit(x[*k]) && is_outward
                };
                let next: Vec<usize> = (0..x.len()).filter(goes_out).collect();
                if next.is_empty() {
                    break;
                }
                for k in next {
                    fixed[k] = true;
                    information.row_mut(k).fill(0.0);
                    information.column_mut(k).fill(0.0);
                    gradient[k] = 0.0;
                }
            }
            let cost = self.cost(&r, &x);
            let gain = full_step.dot(&gradient);
            if gain <= FOUND * (1.0 + cost) || full_step.amax() <= LEAST_STEP {
                is_converged = true;
                break;
            }
            let mut better = None;
            for _ in 0..TRIES {
                let mut step = damped_step(&eigen, &gradient, damping);
                let steps = step.iter().zip(self.unknowns).map(|(step, unknown)| step.abs() / unknown.longest_step());
                step /= steps.fold(1.0, f64::max);
                let next = self.within_limits(&x + step);
                let trial = predict_values(self.machine, self.unknowns, &next, measurements).ok();
                let is_better = trial.is_some_and(|trial| {
                    let r = (&values - trial).component_div(&noise_stds) / scale;
                    self.cost(&r, &next) <= cost
                });
                if is_better {
                    let trial = predict(self.machine, self.unknowns, &next, measurements, self.unknowns);
                    better = trial.ok().map(|trial| (next, trial));
                    break;
                }
                damping = (damping * 10.0).max(1e-9);
            }
            let Some((next, trial)) = better else {
                // Only rounding keeps the search from the place where nothing is left to gain.
                is_converged = gain <= NEARLY_FOUND * (1.0 + cost);
                break;
            };
            (x, predicted) = (next, trial);
            damping = (damping * 0.1).max(1e-12);
            steps += 1;
            // The scatter is that of the values found so far.
            scale = self.noise_scale(&((&values - &predicted.values).component_div(&noise_stds)));
        }
        Ok(self.fit_at(SearchResult { x, predicted, scale, steps, is_converged }, measurements, &noise_stds))
    }

    /// Clamps coordinates `x` to the limits of the search.
    pub(super) fn within_limits(&self, mut x: DVector<f64>) -> DVector<f64> {
        x.iter_mut().zip(self.unknowns).for_each(|(x, u)| *x = x.clamp(-u.search_limit(), u.search_limit()));
        x
    }

    /// Returns the factor on standard deviations of readings: the scatter of residuals `r` where it is estimated, mm; 1 where noise is
    /// given.
    fn noise_scale(&self, r: &DVector<f64>) -> f64 {
        match self.noise.is_estimated {
            true => self.loss.scale(r, self.unknowns.len()).max(LEAST_SCATTER_MM),
            false => 1.0,
        }
    }

    /// Returns the cost to minimise: loss of the residuals `r` (in standard deviations) and of the priors at coordinates `x`.
    fn cost(&self, r: &DVector<f64>, x: &DVector<f64>) -> f64 {
        let prior: f64 = self.priors.iter().map(|&(k, mean, std)| 0.5 * ((x[k] - mean) / std).powi(2)).sum();
        r.iter().map(|&r| self.loss.cost(r)).sum::<f64>() + prior
    }

    /// Returns information matrix and descent gradient at coordinates `x`, with priors; `r` are residuals over `noise_stds` times `scale`.
    fn normal_equations(
        &self,
        predicted: &Predicted,
        r: &DVector<f64>,
        noise_stds: &DVector<f64>,
        scale: f64,
        x: &DVector<f64>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let weights = r.map(|r| self.loss.weight(r));
        let mut slopes = predicted.slopes.clone();
        for (mut row, std) in slopes.row_iter_mut().zip(noise_stds.iter()) {
            row /= std * scale;
        }
        let mut weighted = slopes.clone();
        for (mut row, weight) in weighted.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        let (mut information, mut gradient) = (slopes.transpose() * &weighted, weighted.transpose() * r);
        for &(k, expected, std) in self.priors {
            information[(k, k)] += 1.0 / (std * std);
            gradient[k] += (expected - x[k]) / (std * std);
        }
        (information, gradient)
    }

    /// Returns the fit where a search ended: residuals of `measurements`, covariance, null space, noise test.
    fn fit_at(&self, end: SearchResult, measurements: &[&Measurement], noise_stds: &DVector<f64>) -> Fit {
        let SearchResult { x, predicted, scale, steps, is_converged } = end;
        let residuals = measured_values(measurements) - &predicted.values;
        let r = residuals.component_div(noise_stds) / scale;
        let weights = r.map(|r| self.loss.weight(r));
        // Covariances of M-estimators are those of squares, inflated.
        let least_squares = Search { loss: LossSpec::Squares, ..*self };
        let (information, _) = least_squares.normal_equations(&predicted, &r, noise_stds, scale, &x);
        let eigen = SymmetricEigen::new(information.clone());
        let largest = eigen.eigenvalues.amax();
        let count = self.unknowns.len();
        let is_identifiable = |value: f64| value > RANK * largest && value > 0.0;
        let identifiable_count = eigen.eigenvalues.iter().filter(|value| is_identifiable(**value)).count();
        let degrees_of_freedom = (residuals.len() + self.priors.len()).saturating_sub(identifiable_count);
        let of_priors: f64 = self.priors.iter().map(|&(k, expected, std)| ((x[k] - expected) / std).powi(2)).sum();
        let squares: f64 = r.iter().zip(weights.iter()).map(|(r, weight)| weight * r * r).sum::<f64>() + of_priors;
        let mean_square = squares / degrees_of_freedom.max(1) as f64;
        let is_noise_given = !self.noise.is_estimated;
        // Robust losses take the spread of what is left into account by themselves.
        let inflation = match self.loss {
            LossSpec::Squares if is_noise_given => mean_square.max(1.0),
            loss => loss.inflation(&r, self.unknowns.len()),
        };
        let (mut covariance, mut null_space) = (DMatrix::zeros(count, count), Vec::new());
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            match is_identifiable(*value) {
                true => covariance += vector * vector.transpose() * (inflation / value),
                false => null_space.push(vector.into_owned()),
            }
        }
        let mut fit = Fit {
            stds: noise_stds * if self.noise.is_estimated { scale } else { 1.0 },
            scale: if is_noise_given { mean_square.sqrt() } else { scale },
            is_beyond_noise: is_noise_given && mean_square > scatter::mean_square_limit(degrees_of_freedom),
            x,
            predicted,
            residuals,
            weights,
            covariance,
            inflation,
            design_effect: 1.0,
            null_space,
            information,
            steps,
            is_converged,
        };
        // Noise that is given, and explains the residuals, is of each reading by itself.
        if !is_noise_given || mean_square > 1.0 {
            fit.design_effect = fit.design_effect(measurements, mean_square);
            fit.covariance *= fit.design_effect;
            fit.inflation *= fit.design_effect;
        }
        fit
    }
}

/// Returns the Levenberg–Marquardt step in the identifiable directions; `damping` is a share of the largest eigenvalue of `eigen`.
fn damped_step(eigen: &SymmetricEigen<f64, nalgebra::Dyn>, gradient: &DVector<f64>, damping: f64) -> DVector<f64> {
    let largest = eigen.eigenvalues.amax();
    let mut step = DVector::zeros(gradient.len());
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > RANK * largest && *value > 0.0 {
            step += vector * (vector.dot(gradient) / (value + damping * largest));
        }
    }
    step
}

impl Fit {
    /// Returns the variance of the estimates over that by independent readings of this `mean_square`, at least 1: readings of
    /// a pose share what the model lacks. The squares of the gradients of poses, in the metric of the covariance, say it.
    fn design_effect(&self, measurements: &[&Measurement], mean_square: f64) -> f64 {
        let (inverse, count) = (&self.covariance / self.inflation, self.x.len());
        let residuals = self.residuals.component_div(&self.stds).component_mul(&self.weights.map(f64::sqrt));
        let (mut sums, mut first) = (BTreeMap::new(), 0);
        for row in measurements {
            let slopes = self.weighted_slopes(first, row.readings.len());
            let none = || (DVector::zeros(count), DMatrix::zeros(count, count));
            let (gradient, information) = sums.entry(row.pose).or_insert_with(none);
            *gradient += slopes.transpose() * residuals.rows(first, row.readings.len());
            *information += slopes.transpose() * slopes;
            first += row.readings.len();
        }
        let (found, expected) = sums.values().fold((0.0, 0.0), |(found, expected), (gradient, information)| {
            let hat = &inverse * information;
            (found + gradient.dot(&(&inverse * gradient)), expected + hat.trace() - (&hat * &hat).trace())
        });
        // One pose says nothing of others.
        let is_known = sums.len() > 1 && expected > 1e-9 && mean_square > 0.0;
        let most = (residuals.len() as f64 / (count + 1) as f64).max(1.0);
        if is_known { (found / expected / mean_square).clamp(1.0, most) } else { 1.0 }
    }

    /// Returns Jacobian rows of `count` readings from `first` on, over their standard deviations and times the root of their weights.
    pub(super) fn weighted_slopes(&self, first: usize, count: usize) -> DMatrix<f64> {
        let mut slopes = self.predicted.slopes.rows(first, count).into_owned();
        for (i, mut row) in slopes.row_iter_mut().enumerate() {
            row *= self.weights[first + i].sqrt() / self.stds[first + i];
        }
        slopes
    }

    /// Returns the block of the hat matrix (leverages) of `count` readings from `first` on.
    pub(super) fn hat_matrix(&self, first: usize, count: usize) -> DMatrix<f64> {
        let slopes = self.weighted_slopes(first, count);
        &slopes * &self.covariance * slopes.transpose() / self.inflation
    }

    /// Returns the length of the projection of the unknown (by index) onto the null space: 0 if it is identifiable, at most 1.
    pub fn null_space_part(&self, unknown: usize) -> f64 {
        self.null_space.iter().map(|direction| direction[unknown] * direction[unknown]).sum::<f64>().sqrt()
    }

    /// Returns the standard deviation of the coordinate of the unknown (by index); infinite where it is not identifiable.
    pub fn std(&self, unknown: usize) -> f64 {
        if self.null_space_part(unknown) > 1e-3 { f64::INFINITY } else { self.covariance[(unknown, unknown)].sqrt() }
    }

    /// Returns the correlation of the coordinates of unknowns `a` and `b` (by index), −1 to 1; `None` where one is not identifiable.
    pub fn correlation(&self, a: usize, b: usize) -> Option<f64> {
        let size = self.std(a) * self.std(b);
        (size.is_finite() && size > 0.0).then(|| (self.covariance[(a, b)] / size).clamp(-1.0, 1.0))
    }
}
