//! What an identification says of poses that it has not seen: readings with their intervals.

use nalgebra::{DMatrix, DVector};

use super::{
    IdentificationStudy, Identified,
    fit::{Fit, Noise},
    free,
    measurements::{Measurement, Reading},
    model::{LoadedModel, Predicted},
    scatter,
};
use crate::{input::error::Result, simulation::Failure};

/// A reading as it is predicted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Its column in files of measurements.
    pub column: &'static str,
    /// mm or rad.
    pub value: f64,
    /// Half its 95 % interval, mm or rad; infinite where it depends on what was not told, or nothing of its kind was fitted.
    pub half_width: f64,
    /// Standard deviations that make it, mm or rad: by what is known of the numbers (their covariance); by what the model leaves of readings
    /// of its kind beyond their noise, in which that is where the scatter tells it; by the noise of the reading that was given.
    pub stds: [f64; 3],
    /// What was read, mm or rad, if the file says so.
    pub measured: Option<f64>,
}

/// What should be read at each of `poses`: the readings that it has, displacements of the tool tip where it has none.
///
/// # Errors
/// With the numbers found there is no machine.
pub fn predict(
    study: &IdentificationStudy,
    found: &Identified,
    poses: &[Measurement],
) -> Result<Vec<std::result::Result<Vec<Answer>, Failure>>> {
    let fit = &found.fit;
    let asked: Vec<Measurement> =
        poses.iter().map(|own| Measurement { readings: readings(own), ..own.clone() }).collect();
    let asked: Vec<&Measurement> = asked.iter().collect();
    let model = LoadedModel::new(&study.machine, &study.unknowns, &fit.x, &study.unknowns)?;
    let null_space = DMatrix::from_fn(fit.x.len(), fit.null_space.len(), |i, j| fit.null_space[j][i]);
    let quantile = scatter::half_width(free(study, fit));
    let left = [false, true].map(|is_rotation| Left::of(study, fit, is_rotation));
    let of = |(predicted, (own, pose)): (Predicted, (&&Measurement, &Measurement))| {
        let each = own.readings.iter().enumerate().map(|(i, reading)| {
            let slopes: DVector<f64> = predicted.slopes.row(i).transpose();
            let by_numbers = slopes.dot(&(&fit.covariance * &slopes)).max(0.0).sqrt();
            let is_unidentifiable = (null_space.transpose() * &slopes).amax() > UNIDENTIFIABLE * slopes.amax();
            let [misfit, noise] = left[usize::from(reading.quantity.is_rotation())].of_reading(study.noise, reading);
            let stds = [if is_unidentifiable { f64::INFINITY } else { by_numbers }, misfit, noise];
            let half_width = quantile * stds.iter().map(|std| std * std).sum::<f64>().sqrt();
            let measured = pose.readings.get(i).map(|reading| reading.value);
            Answer { column: reading.column, value: predicted.values[i], half_width, stds, measured }
        });
        each.collect()
    };
    let predicted = model.each(&asked).into_iter().zip(asked.iter().zip(poses));
    Ok(predicted.map(|(predicted, own)| predicted.map(|predicted| of((predicted, own)))).collect())
}

/// A reading that changes by less along what was not told, over what it changes by most, does not depend on it.
const UNIDENTIFIABLE: f64 = 1e-6;

fn readings(pose: &Measurement) -> Vec<Reading> {
    if pose.readings.is_empty() { Reading::displacements_to_come() } else { pose.readings.clone() }
}

/// What the fit leaves of lengths, or of rotations.
struct Left {
    /// Beyond the noise of readings, mm or rad; infinite where none were fitted.
    misfit: f64,
    /// Noise of those that were fitted, mm or rad.
    noise: f64,
}

impl Left {
    fn of(study: &IdentificationStudy, fit: &Fit, is_rotation: bool) -> Self {
        let readings = study.measurements.iter().flat_map(|own| &own.readings).zip(&fit.stds);
        let squares: Vec<f64> = readings
            .filter(|(reading, _)| reading.quantity.is_rotation() == is_rotation)
            .map(|(_, std)| std * std)
            .collect();
        if squares.is_empty() {
            return Self { misfit: f64::INFINITY, noise: f64::INFINITY };
        }
        let noise = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        let share = if study.noise.is_estimated { 1.0 } else { (fit.scale * fit.scale - 1.0).max(0.0).sqrt() };
        Self { misfit: noise * share, noise }
    }

    /// Standard deviations of a reading by the misfit and by its noise.
    fn of_reading(&self, noise: Noise, reading: &Reading) -> [f64; 2] {
        let other = if noise.is_estimated { 0.0 } else { noise.given(reading).unwrap_or(self.noise) };
        [self.misfit, reading.std.unwrap_or(other)]
    }
}
