//! Validation of a fit: leave-one-out residuals, k-fold cross-validation, and outliers, such as slips of the pen or a marker that moved.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{
    fit::{Fit, Search},
    measurements::{Measurement, Quantity, Reading},
    model::predict_values,
    scatter::PER_MEDIAN,
};
use crate::{input::error::Result, simulation::Failure, work::Work};

/// A reading is predicted by the others only if one less its leverage is at least this.
const OWN: f64 = 1e-6;

/// Returns the leave-one-out residual of each reading, mm and rad, `(1 − H)⁻¹ r` block by block; infinite where no other measurement determines it.
pub fn leave_one_out(fit: &Fit, measurements: &[Measurement]) -> Vec<f64> {
    let mut residuals = Vec::with_capacity(fit.residuals.len());
    let mut first = 0;
    for measurement in measurements {
        let count = measurement.readings.len();
        let hat = fit.hat_matrix(first, count);
        let scaled = DVector::from_fn(count, |i, _| {
            fit.residuals[first + i] * fit.weights[first + i].sqrt() / fit.stds[first + i]
        });
        // Where the others tell nothing of it, it predicts itself: the smallest part that is not its own is none.
        let complement = DMatrix::identity(count, count) - hat;
        let is_identifiable = SymmetricEigen::new(complement.clone()).eigenvalues.min() > OWN;
        let left_out = if is_identifiable { complement.lu().solve(&scaled) } else { None };
        for i in 0..count {
            let unscale = fit.stds[first + i] / fit.weights[first + i].sqrt().max(1e-9);
            residuals.push(left_out.as_ref().map_or(f64::INFINITY, |left_out| left_out[i] * unscale));
        }
        first += count;
    }
    residuals
}

/// Returns the residuals of all readings in k-fold cross-validation, mm and rad, by fits to the other folds from coordinates `start`; rows of
/// one pose are in one fold. `Err` if the work was stopped; the inner one if a fit or prediction failed.
pub fn k_fold_residuals(
    search: &Search<'_>,
    start: &DVector<f64>,
    measurements: &[Measurement],
    folds: usize,
    work: &Work,
) -> Result<std::result::Result<Vec<f64>, Failure>> {
    let mut residuals: Vec<Vec<f64>> = vec![Vec::new(); measurements.len()];
    for fold in 0..folds {
        work.check()?;
        let (inside, outside): (Vec<usize>, Vec<usize>) =
            (0..measurements.len()).partition(|i| measurements[*i].pose % folds == fold);
        let [tested, training] =
            [&inside, &outside].map(|own| own.iter().map(|&i| &measurements[i]).collect::<Vec<_>>());
        let refit = search.fit(&training, start);
        let prediction = refit.and_then(|fit| predict_values(search.machine, search.unknowns, &fit.x, &tested));
        let predicted = match prediction {
            Ok(predicted) => predicted,
            Err((_, failure)) => return Ok(Err(failure)),
        };
        let mut first = 0;
        for &i in &inside {
            let readings = &measurements[i].readings;
            let errors = readings.iter().enumerate().map(|(k, reading)| reading.value - predicted[first + k]);
            residuals[i] = errors.collect();
            first += readings.len();
        }
    }
    Ok(Ok(residuals.concat()))
}

/// Returns the root mean square of those `residuals` that are lengths, mm; `None` where none is.
pub fn rms_mm(residuals: &[f64], measurements: &[Measurement]) -> Option<f64> {
    let quantities = measurements.iter().flat_map(|m| m.readings.iter().map(|reading| reading.quantity));
    let of_lengths = quantities.zip(residuals).filter(|(quantity, _)| !Quantity::is_rotation(*quantity));
    let (sum, count) = of_lengths.fold((0.0, 0usize), |(sum, count), (_, r)| (sum + r * r, count + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// Returns the RMS of `residuals` over that of the values, of lengths that the load changes, without `outliers`; `None` without any.
pub fn residual_share(residuals: &[f64], measurements: &[Measurement], outliers: &[Outlier]) -> Option<f64> {
    let readings = measurements.iter().enumerate().flat_map(|(m, own)| own.readings.iter().map(move |r| (m, r)));
    let is_far =
        |m: usize, reading: &Reading| outliers.iter().any(|far| (far.measurement, far.column) == (m, reading.column));
    let lengths = readings
        .zip(residuals)
        .filter(|((m, reading), _)| reading.is_change() && !reading.quantity.is_rotation() && !is_far(*m, reading));
    let (left, all) =
        lengths.fold((0.0, 0.0), |(left, all), ((_, reading), r)| (left + r * r, all + reading.value * reading.value));
    (all > 0.0).then(|| (left / all).sqrt())
}

/// A reading whose residual is far larger than those of the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlier {
    /// Index of its measurement.
    pub measurement: usize,
    /// Column of the reading.
    pub column: &'static str,
    /// Residual, measured less predicted, mm; for rotations degrees.
    pub by: f64,
}

/// Residuals over the typical one from which a reading is an outlier: normal noise has one in two million.
const FAR: f64 = 5.0;
/// Fewest readings of which a typical residual is known.
const FEWEST: usize = 8;
/// Largest residual that is rounding of the solves, mm or rad.
const ROUNDING: f64 = 1e-7;

/// Returns the readings that are outliers, the farthest first: residuals, corrected for leverage, of over [`FAR`] typical ones.
pub fn outliers(fit: &Fit, measurements: &[Measurement]) -> Vec<Outlier> {
    // A reading that tells an unknown alone leaves nothing.
    let size = |i: usize| {
        let others = 1.0 - fit.hat_matrix(i, 1)[(0, 0)] / fit.weights[i].max(f64::MIN_POSITIVE);
        (others > OWN).then(|| (fit.residuals[i] / fit.stds[i]).abs() / others.sqrt())
    };
    let all: Vec<Option<f64>> = (0..fit.residuals.len()).map(size).collect();
    let mut sizes: Vec<f64> = all.iter().flatten().copied().collect();
    if sizes.len() < FEWEST {
        return Vec::new();
    }
    sizes.sort_by(f64::total_cmp);
    let typical = PER_MEDIAN * sizes[sizes.len() / 2];
    let readings = measurements.iter().enumerate().flat_map(|(m, own)| own.readings.iter().map(move |r| (m, r)));
    let outlier = |(i, (measurement, reading)): (usize, (usize, &Reading))| {
        let (residual, size) = (fit.residuals[i], all[i]?);
        let by = if reading.quantity.is_rotation() { residual.to_degrees() } else { residual };
        let is_far = size > FAR * typical && residual.abs() > ROUNDING;
        is_far.then_some((size, Outlier { measurement, column: reading.column, by }))
    };
    let mut far: Vec<(f64, Outlier)> = readings.enumerate().filter_map(outlier).collect();
    far.sort_by(|a, b| b.0.total_cmp(&a.0));
    far.into_iter().map(|(_, own)| own).collect()
}
