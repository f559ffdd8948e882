//! How well measurements are predicted that a fit has not seen, one left out at a time and in parts, and which readings lie far off all
//! others: slips of the pen, or a marker that moved.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{
    fit::{Fit, Search},
    measurements::{Measurement, Quantity},
    model::values_at,
    scatter::PER_MEDIAN,
};
use crate::{input::error::Result, simulation::Failure, work::Work};

/// A reading of which the others determine less than this is not predicted without its own measurement.
const OWN: f64 = 1e-6;

/// Residual of each reading, mm and rad, as predicted without its measurement: by the linear equations of the fit, `(1 − H)⁻¹ r` block by block.
pub fn left_one_out(fit: &Fit, measurements: &[Measurement]) -> Vec<f64> {
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
        let is_identifiable = SymmetricEigen::new(others.clone()).eigenvalues.min() > OWN;
        let left = if is_identifiable { others.lu().solve(&scaled) } else { None };
        for i in 0..count {
            let back = fit.stds[first + i] / fit.weights[first + i].sqrt().max(1e-9);
            residuals.push(left.as_ref().map_or(f64::INFINITY, |left| left[i] * back));
        }
        first += count;
    }
    residuals
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
) -> Result<std::result::Result<Vec<f64>, Failure>> {
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
    Ok(Ok(residuals.concat()))
}

/// Root of the mean square of those `residuals` that are lengths, mm; `None` where none is.
pub fn rms_mm(residuals: &[f64], measurements: &[Measurement]) -> Option<f64> {
    let quantities = measurements.iter().flat_map(|m| m.readings.iter().map(|reading| reading.quantity));
    let of_lengths = quantities.zip(residuals).filter(|(quantity, _)| !Quantity::is_rotation(*quantity));
    let (sum, count) = of_lengths.fold((0.0, 0usize), |(sum, count), (_, r)| (sum + r * r, count + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// A reading that lies far off.
#[derive(Debug, Clone, PartialEq)]
pub struct FarOff {
    /// Which measurement.
    pub measurement: usize,
    /// Which of its readings.
    pub column: &'static str,
    /// Measured less predicted, mm; of rotations degrees.
    pub by: f64,
}

/// So many times the typical residual: normal noise leaves one in two million.
const FAR: f64 = 5.0;
/// Fewer readings that others tell do not say what is typical.
const FEWEST: usize = 8;
/// The residual is rounding of the solves, if it is less, mm and rad.
const ROUNDING: f64 = 1e-7;

/// Readings far off, the farthest first. What is typical is the median, which those that are far off do not move.
pub fn far_off(fit: &Fit, measurements: &[Measurement]) -> Vec<FarOff> {
    // A reading that tells an unknown alone leaves nothing.
    let size = |i: usize| {
        let others = 1.0 - fit.hat(i, 1)[(0, 0)] / fit.weights[i].max(f64::MIN_POSITIVE);
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
    let mut far: Vec<(f64, FarOff)> = Vec::new();
    for (i, (measurement, reading)) in readings.enumerate() {
        let (residual, Some(size)) = (fit.residuals[i], all[i]) else { continue };
        if size > FAR * typical && residual.abs() > ROUNDING {
            let by = if reading.quantity.is_rotation() { residual.to_degrees() } else { residual };
            far.push((size, FarOff { measurement, column: reading.column, by }));
        }
    }
    far.sort_by(|a, b| b.0.total_cmp(&a.0));
    far.into_iter().map(|(_, own)| own).collect()
}
