//! Unknowns that fit measurements best: Gauss–Newton steps, damped where they do not lead down, along the directions that the
//! measurements tell.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{
    measurements::{Measurement, Reading},
    model::{Predicted, predict, values_at},
    scatter,
    spec::LossSpec,
    unknown::Unknown,
};
use crate::{machine::Machine, simulation::Failure};

/// Steps of the search, and how often their damping is raised for one.
const STEPS: usize = 60;
const TRIES: usize = 12;
/// The search is over where no larger share of the cost is to be gained.
const FOUND: f64 = 1e-10;
/// The same where rounding keeps the search from gaining it.
const NEARLY_FOUND: f64 = 1e-6;
/// Or where no unknown would change by more, in noticeable changes: without noise, the residual is the rounding of solves.
const LEAST_STEP: f64 = 1e-6;
/// Less scatter is rounding of the solves.
pub(super) const LEAST_SCATTER_MM: f64 = 1e-8;
/// A direction whose information is less than this share of the largest is not told at all.
const RANK: f64 = 1e-13;

/// A search: from which machine, for what, by which measurements.
#[derive(Debug, Clone, Copy)]
pub struct Search<'a> {
    /// The machine to begin with.
    pub machine: &'a Machine,
    /// What is sought.
    pub unknowns: &'a [Unknown],
    /// What is known beforehand: the unknown, its coordinate and the standard deviation of that.
    pub priors: &'a [(usize, f64, f64)],
    /// Standard deviation of lengths (mm) and rotations (rad); `None` where the scatter is to tell it.
    pub noise: Noise,
    /// How far-off readings count.
    pub loss: LossSpec,
}

/// Standard deviations of readings that do not have their own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// mm.
    pub length: Option<f64>,
    /// rad.
    pub rotation: Option<f64>,
    /// Whether the scatter of the readings is to tell it: no reading has one.
    pub is_estimated: bool,
}

impl Noise {
    /// Standard deviation of a reading; 1 where the scatter tells it.
    pub fn of(&self, reading: &Reading) -> f64 {
        self.given(reading).unwrap_or(1.0)
    }

    /// Standard deviation of a reading, if the file or the study gives it.
    pub fn given(&self, reading: &Reading) -> Option<f64> {
        reading.std.or(if reading.quantity.is_rotation() { self.rotation } else { self.length })
    }
}

/// What fits best.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Coordinates of the unknowns.
    pub x: DVector<f64>,
    /// Predictions there.
    pub predicted: Predicted,
    /// Measured less predicted, mm and rad.
    pub residuals: DVector<f64>,
    /// Standard deviation of each reading, mm or rad, as given or as the scatter tells it.
    pub stds: DVector<f64>,
    /// How much each reading counts.
    pub weights: DVector<f64>,
    /// Scatter over what was given; where that was not given, the standard deviation itself.
    pub scale: f64,
    /// Covariance of the coordinates; infinite along what is not told, which `null_space` says.
    pub covariance: DMatrix<f64>,
    /// Directions of coordinates that are not told at all, unit vectors.
    pub null_space: Vec<DVector<f64>>,
    /// By how much robust losses, and what is left beyond the noise that was given, make the covariance larger than that of squares.
    pub inflation: f64,
    /// Whether the residual is more than the noise that was given makes once in a hundred times.
    pub is_beyond_noise: bool,
    /// Information `JᵀWJ` of the readings in standard deviations, with priors.
    pub information: DMatrix<f64>,
    /// Steps taken.
    pub steps: usize,
    /// Whether the search ended where no step is left.
    pub is_found: bool,
}

/// Readings of `measurements` in order.
pub(super) fn measured(measurements: &[&Measurement]) -> DVector<f64> {
    let values: Vec<f64> = measurements.iter().flat_map(|m| m.readings.iter().map(|reading| reading.value)).collect();
    DVector::from_vec(values)
}

impl Search<'_> {
    /// Fits `measurements` from `start`.
    ///
    /// # Errors
    /// Where the search begins, the machine does not settle at a measurement (its number, and why).
    pub fn fit(
        &self,
        measurements: &[&Measurement],
        start: &DVector<f64>,
    ) -> std::result::Result<Fit, (Option<usize>, Failure)> {
        let given = DVector::from_iterator(
            measurements.iter().map(|m| m.readings.len()).sum(),
            measurements.iter().flat_map(|m| m.readings.iter().map(|reading| self.noise.of(reading))),
        );
        let values = measured(measurements);
        let mut x = start.clone();
        let mut predicted = predict(self.machine, self.unknowns, &x, measurements)?;
        let mut scale = self.scale(&((&values - &predicted.values).component_div(&given)));
        let (mut steps, mut is_found, mut damping) = (0, false, 1e-6);
        while steps < STEPS {
            let r = (&values - &predicted.values).component_div(&given) / scale;
            let (mut information, mut gradient) = self.normal(&predicted, &r, &given, scale, &x);
            // At the end of where it is sought, an unknown that would go farther stays.
            let mut held = vec![false; x.len()];
            let (mut told, mut whole);
            loop {
                told = SymmetricEigen::new(information.clone());
                whole = damped_step(&told, &gradient, 0.0);
                let goes_out = |k: &usize| {
                    let is_outward = whole[*k] * x[*k] > 0.0 || gradient[*k] * x[*k] > 0.0;
                    !held[*k] && self.unknowns[*k].is_at_end(x[*k]) && is_outward
                };
                let next: Vec<usize> = (0..x.len()).filter(goes_out).collect();
                if next.is_empty() {
                    break;
                }
                for k in next {
                    held[k] = true;
                    information.row_mut(k).fill(0.0);
                    information.column_mut(k).fill(0.0);
                    gradient[k] = 0.0;
                }
            }
            let cost = self.cost(&r, &x);
            let gain = whole.dot(&gradient);
            if gain <= FOUND * (1.0 + cost) || whole.amax() <= LEAST_STEP {
                is_found = true;
                break;
            }
            let mut better = None;
            for _ in 0..TRIES {
                let mut step = damped_step(&told, &gradient, damping);
                let steps = step.iter().zip(self.unknowns).map(|(step, own)| step.abs() / own.longest_step());
                step /= steps.fold(1.0, f64::max);
                let next = self.within(&x + step);
                let there = values_at(self.machine, self.unknowns, &next, measurements).ok();
                let is_better = there.is_some_and(|there| {
                    let r = (&values - there).component_div(&given) / scale;
                    self.cost(&r, &next) <= cost
                });
                if is_better {
                    better = predict(self.machine, self.unknowns, &next, measurements).ok().map(|there| (next, there));
                    break;
                }
                damping = (damping * 10.0).max(1e-9);
            }
            let Some((next, there)) = better else {
                // Only rounding keeps the search from the place where nothing is left to gain.
                is_found = gain <= NEARLY_FOUND * (1.0 + cost);
                break;
            };
            (x, predicted) = (next, there);
            damping = (damping * 0.1).max(1e-12);
            steps += 1;
            // The scatter is that of the values found so far.
            scale = self.scale(&((&values - &predicted.values).component_div(&given)));
        }
        Ok(self.described(x, predicted, &values, &given, scale, (steps, is_found)))
    }

    /// `x`, no unknown farther from its start than it is sought.
    pub(super) fn within(&self, mut x: DVector<f64>) -> DVector<f64> {
        x.iter_mut().zip(self.unknowns).for_each(|(x, own)| *x = x.clamp(-own.farthest(), own.farthest()));
        x
    }

    fn scale(&self, r: &DVector<f64>) -> f64 {
        match self.noise.is_estimated {
            true => self.loss.scale(r, self.unknowns.len()).max(LEAST_SCATTER_MM),
            false => 1.0,
        }
    }

    fn cost(&self, r: &DVector<f64>, x: &DVector<f64>) -> f64 {
        let known: f64 = self.priors.iter().map(|&(k, at, std)| 0.5 * ((x[k] - at) / std).powi(2)).sum();
        r.iter().map(|&r| self.loss.cost(r)).sum::<f64>() + known
    }

    /// Information and downward gradient; `r` over `scale`.
    fn normal(
        &self,
        predicted: &Predicted,
        r: &DVector<f64>,
        given: &DVector<f64>,
        scale: f64,
        x: &DVector<f64>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let weights = r.map(|r| self.loss.weight(r));
        let mut slopes = predicted.slopes.clone();
        for (mut row, std) in slopes.row_iter_mut().zip(given.iter()) {
            row /= std * scale;
        }
        let mut weighted = slopes.clone();
        for (mut row, weight) in weighted.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        let (mut information, mut gradient) = (slopes.transpose() * &weighted, weighted.transpose() * r);
        for &(k, at, std) in self.priors {
            information[(k, k)] += 1.0 / (std * std);
            gradient[k] += (at - x[k]) / (std * std);
        }
        (information, gradient)
    }

    fn described(
        &self,
        x: DVector<f64>,
        predicted: Predicted,
        values: &DVector<f64>,
        given: &DVector<f64>,
        scale: f64,
        (steps, is_found): (usize, bool),
    ) -> Fit {
        let residuals = values - &predicted.values;
        let r = residuals.component_div(given) / scale;
        let weights = r.map(|r| self.loss.weight(r));
        // Covariances of M-estimators are those of squares, inflated.
        let plain = Search { loss: LossSpec::Squares, ..*self };
        let (information, _) = plain.normal(&predicted, &r, given, scale, &x);
        let told = SymmetricEigen::new(information.clone());
        let most = told.eigenvalues.amax();
        let count = self.unknowns.len();
        let is_identifiable = |value: f64| value > RANK * most && value > 0.0;
        let identifiable_count = told.eigenvalues.iter().filter(|value| is_identifiable(**value)).count();
        let free = (values.len() + self.priors.len()).saturating_sub(identifiable_count);
        let of_priors: f64 = self.priors.iter().map(|&(k, at, std)| ((x[k] - at) / std).powi(2)).sum();
        let squares: f64 = r.iter().zip(weights.iter()).map(|(r, weight)| weight * r * r).sum::<f64>() + of_priors;
        let mean_square = squares / free.max(1) as f64;
        let is_given = !self.noise.is_estimated;
        // Robust losses take the spread of what is left into account by themselves.
        let inflation = match self.loss {
            LossSpec::Squares if is_given => mean_square.max(1.0),
            loss => loss.inflation(&r, self.unknowns.len()),
        };
        let (mut covariance, mut null_space) = (DMatrix::zeros(count, count), Vec::new());
        for (value, vector) in told.eigenvalues.iter().zip(told.eigenvectors.column_iter()) {
            match is_identifiable(*value) {
                true => covariance += vector * vector.transpose() * (inflation / value),
                false => null_space.push(vector.into_owned()),
            }
        }
        Fit {
            stds: given * if self.noise.is_estimated { scale } else { 1.0 },
            scale: if is_given { mean_square.sqrt() } else { scale },
            is_beyond_noise: is_given && mean_square > scatter::most_by_chance(free),
            x,
            predicted,
            residuals,
            weights,
            covariance,
            inflation,
            null_space,
            information,
            steps,
            is_found,
        }
    }
}

/// A step down along the identifiable directions.
fn damped_step(told: &SymmetricEigen<f64, nalgebra::Dyn>, gradient: &DVector<f64>, damping: f64) -> DVector<f64> {
    let most = told.eigenvalues.amax();
    let mut step = DVector::zeros(gradient.len());
    for (value, vector) in told.eigenvalues.iter().zip(told.eigenvectors.column_iter()) {
        if *value > RANK * most && *value > 0.0 {
            step += vector * (vector.dot(gradient) / (value + damping * most));
        }
    }
    step
}

impl Fit {
    /// Slopes of some readings over their standard deviations, with their weights.
    pub(super) fn weighted_slopes(&self, first: usize, count: usize) -> DMatrix<f64> {
        let mut slopes = self.predicted.slopes.rows(first, count).into_owned();
        for (i, mut row) in slopes.row_iter_mut().enumerate() {
            row *= self.weights[first + i].sqrt() / self.stds[first + i];
        }
        slopes
    }

    /// Leverage of some readings on their own predictions, as a matrix.
    pub(super) fn hat(&self, first: usize, count: usize) -> DMatrix<f64> {
        let own = self.weighted_slopes(first, count);
        &own * &self.covariance * own.transpose() / self.inflation
    }

    /// How an unknown enters the directions that are not told: 0 where not at all.
    pub fn null_space_part(&self, unknown: usize) -> f64 {
        self.null_space.iter().map(|direction| direction[unknown] * direction[unknown]).sum::<f64>().sqrt()
    }

    /// Standard deviation of a coordinate; infinite where it is not told.
    pub fn std(&self, unknown: usize) -> f64 {
        if self.null_space_part(unknown) > 1e-3 { f64::INFINITY } else { self.covariance[(unknown, unknown)].sqrt() }
    }

    /// Correlation of two coordinates; `None` where one is not told.
    pub fn correlation(&self, a: usize, b: usize) -> Option<f64> {
        let size = self.std(a) * self.std(b);
        (size.is_finite() && size > 0.0).then(|| (self.covariance[(a, b)] / size).clamp(-1.0, 1.0))
    }
}
