//! How well measurements are predicted that a fit has not seen: one left out at a time, and in parts.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{
    far_off::FarOff,
    fit::{Fit, Search},
    measurements::{Measurement, Quantity, Reading},
    model::values_at,
};
use crate::{input::error::Result, simulation::Failure, work::Work};

/// A reading of which less than this is told by others is not predicted without its own measurement.
pub(super) const OWN: f64 = 1e-6;

/// RMS of residuals, of all readings and of each measurement's.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// Residual of each reading, mm and rad, as predicted by a fit without its measurement.
    pub residuals: Vec<f64>,
}

/// Residuals of each measurement as predicted by the others: by the linear equations of the fit, `(1 − H)⁻¹ r` block by block.
pub fn left_one_out(fit: &Fit, measurements: &[Measurement]) -> Errors {
    let mut residuals = Vec::with_capacity(fit.residuals.len());
    let mut first = 0;
    for measurement in measurements {
        let count = measurement.readings.len();
        let hat = fit.hat(first, count);
        let scaled = DVector::from_fn(count, |i, _| {
            fit.residuals[first + i] * fit.weights[first + i].sqrt() / fit.stds[first + i]
        });
        // Where the others tell nothing of it, it predicts itself: the smallest part that is not its own is none.
        let others = DMatrix::identity(count, count) - hat;
        let is_told = SymmetricEigen::new(others.clone()).eigenvalues.min() > OWN;
        let left = if is_told { others.lu().solve(&scaled) } else { None };
        for i in 0..count {
            let back = fit.stds[first + i] / fit.weights[first + i].sqrt().max(1e-9);
            residuals.push(left.as_ref().map_or(f64::INFINITY, |left| left[i] * back));
        }
        first += count;
    }
    Errors { residuals }
}

/// Residuals of each measurement as predicted by a fit to the other parts: every `folds`-th measurement makes a part.
///
/// # Errors
/// The work was stopped.
pub fn in_parts(
    search: &Search<'_>,
    start: &DVector<f64>,
    measurements: &[Measurement],
    folds: usize,
    work: &Work,
) -> Result<std::result::Result<Errors, Failure>> {
    let mut residuals: Vec<Vec<f64>> = vec![Vec::new(); measurements.len()];
    for fold in 0..folds {
        work.check()?;
        let is_out = |i: &usize| i % folds == fold;
        let kept: Vec<&Measurement> =
            (0..measurements.len()).filter(|i| !is_out(i)).map(|i| &measurements[i]).collect();
        let out: Vec<usize> = (0..measurements.len()).filter(is_out).collect();
        let asked: Vec<&Measurement> = out.iter().map(|&i| &measurements[i]).collect();
        let found = search.fit(&kept, start);
        let there = found.and_then(|fit| values_at(search.machine, search.unknowns, &fit.x, &asked));
        let predicted = match there {
            Ok(predicted) => predicted,
            Err((_, failure)) => return Ok(Err(failure)),
        };
        let mut first = 0;
        for &i in &out {
            let readings = &measurements[i].readings;
            let own = readings.iter().enumerate().map(|(k, reading)| reading.value - predicted[first + k]);
            residuals[i] = own.collect();
            first += readings.len();
        }
    }
    Ok(Ok(Errors { residuals: residuals.concat() }))
}

/// Root of the mean square of those `residuals` that are lengths, mm; `None` where none is.
pub fn rms_mm(residuals: &[f64], measurements: &[Measurement]) -> Option<f64> {
    let quantities = measurements.iter().flat_map(|m| m.readings.iter().map(|reading| reading.quantity));
    let of_lengths = quantities.zip(residuals).filter(|(quantity, _)| !Quantity::is_rotation(*quantity));
    let (sum, count) = of_lengths.fold((0.0, 0usize), |(sum, count), (_, r)| (sum + r * r, count + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// RMS of `residuals` over that of what was measured, of lengths that the load changes and that are not among `far_off`; `None` without any.
#[cfg_attr(not(feature = "report"), allow(dead_code, reason = "only reports say it"))]
pub fn left_share(residuals: &DVector<f64>, measurements: &[Measurement], far_off: &[FarOff]) -> Option<f64> {
    let readings = measurements.iter().enumerate().flat_map(|(m, own)| own.readings.iter().map(move |r| (m, r)));
    let is_far =
        |m: usize, reading: &Reading| far_off.iter().any(|far| (far.measurement, far.column) == (m, reading.column));
    let lengths = readings
        .zip(residuals)
        .filter(|((m, reading), _)| reading.is_change() && !reading.quantity.is_rotation() && !is_far(*m, reading));
    let (left, all) =
        lengths.fold((0.0, 0.0), |(left, all), ((_, reading), r)| (left + r * r, all + reading.value * reading.value));
    (all > 0.0).then(|| (left / all).sqrt())
}
