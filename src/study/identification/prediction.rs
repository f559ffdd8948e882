//! What an identification says of poses that it has not seen: readings with their intervals.

use nalgebra::{DMatrix, DVector};

use super::{
    IdentificationStudy, Identified,
    fit::Noise,
    free,
    measurements::{Measurement, Reading},
    model::{LoadedModel, Predicted},
    quantile,
};
use crate::{input::error::Result, study::Failure};

/// A reading as it is predicted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Its column in files of measurements.
    pub column: &'static str,
    /// mm or rad.
    pub value: f64,
    /// Half its 95 % interval, mm or rad; infinite where it depends on what was not told.
    pub half_width: f64,
    /// Standard deviations that make it, mm or rad: by what is known of the numbers (their covariance); by what the model leaves beyond the
    /// noise of readings, in which that is where the scatter tells it; by the noise of the reading that was given.
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
    let untold = DMatrix::from_fn(fit.x.len(), fit.untold.len(), |i, j| fit.untold[j][i]);
    let quantile = quantile::half_width(free(study, fit));
    let of = |(predicted, (own, pose)): (Predicted, (&&Measurement, &Measurement))| {
        let each = own.readings.iter().enumerate().map(|(i, reading)| {
            let slopes: DVector<f64> = predicted.slopes.row(i).transpose();
            let by_numbers = slopes.dot(&(&fit.covariance * &slopes)).max(0.0).sqrt();
            let is_untold = (untold.transpose() * &slopes).amax() > UNTOLD * slopes.amax();
            let [misfit, noise] = of_reading(study.noise, fit.scale, reading);
            let stds = [if is_untold { f64::INFINITY } else { by_numbers }, misfit, noise];
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
const UNTOLD: f64 = 1e-6;

fn readings(pose: &Measurement) -> Vec<Reading> {
    if pose.readings.is_empty() { Reading::displacements_to_come() } else { pose.readings.clone() }
}

/// Standard deviations of a reading by the misfit and by its noise.
fn of_reading(noise: Noise, scale: f64, reading: &Reading) -> [f64; 2] {
    match noise.is_estimated {
        true => [scale, 0.0],
        false => [noise.of(reading) * (scale * scale - 1.0).max(0.0).sqrt(), noise.of(reading)],
    }
}
