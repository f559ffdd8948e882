//! Predictions of an identified machine at other poses and loads: readings with their 95 % intervals.

use nalgebra::DVector;

use super::{
    IdentificationStudy, Identified, degrees_of_freedom,
    fit::Fit,
    measurements::{Measurement, Reading},
    model::{LoadedModel, Predicted},
    scatter,
};
use crate::{input::error::Result, machine::Machine, simulation::Failure};

/// A predicted reading with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Column of the reading in measurement files.
    pub column: &'static str,
    /// Predicted value, mm or rad.
    pub value: f64,
    /// Half its 95 % interval, mm or rad; infinite where it depends on unidentifiable directions, or no reading of its kind was fitted.
    pub half_width: f64,
    /// Standard deviations that make the interval, mm or rad: by the covariance of the parameters; by residuals beyond the given noise, or
    /// all of them where it is estimated; by the given noise of the reading.
    pub stds: [f64; 3],
    /// Measured value, mm or rad, if the file has it.
    pub measured: Option<f64>,
}

/// Predicts the readings of each pose and load with 95 % intervals: those that its row has, else displacements of the tool tip. The inner
/// `Err` says why a pose has no equilibrium; the outer, why the fitted parameters make no valid machine.
pub fn predict(
    study: &IdentificationStudy,
    results: &Identified,
    poses: &[Measurement],
) -> Result<Vec<std::result::Result<Vec<Prediction>, Failure>>> {
    let fit = &results.fit;
    let model = LoadedModel::new(&study.machine, &study.unknowns, &fit.x, &study.unknowns)?;
    let quantile = scatter::half_width(degrees_of_freedom(study, fit));
    let scatters = [false, true].map(|is_rotation| residual_stds(study, fit, is_rotation));
    let interval = |predicted: &Predicted, i: usize, reading: &Reading| {
        let slopes: DVector<f64> = predicted.slopes.row(i).transpose();
        let by_numbers = slopes.dot(&(&fit.covariance * &slopes)).max(0.0).sqrt();
        let least = UNIDENTIFIABLE * slopes.amax();
        let is_unidentifiable = fit.null_space.iter().any(|direction| direction.dot(&slopes).abs() > least);
        let [misfit, noise] = scatters[usize::from(reading.quantity.is_rotation())];
        let noise = study.noise.given_std(reading).unwrap_or(if study.noise.is_estimated { 0.0 } else { noise });
        let stds = [if is_unidentifiable { f64::INFINITY } else { by_numbers }, misfit, noise];
        (quantile * stds.iter().map(|std| std * std).sum::<f64>().sqrt(), stds)
    };
    Ok(predictions(&model, poses, interval))
}

/// Predicts the readings of each pose and load with the parameters of `machine`, with infinite intervals, as their accuracy is unknown. The
/// inner `Err` says why a pose has no equilibrium; the outer, why `machine` makes no valid model.
pub fn predict_as_is(
    machine: &Machine,
    poses: &[Measurement],
) -> Result<Vec<std::result::Result<Vec<Prediction>, Failure>>> {
    let model = LoadedModel::new(machine, &[], &DVector::zeros(0), &[])?;
    Ok(predictions(&model, poses, |_, _, _| (f64::INFINITY, [f64::INFINITY; 3])))
}

/// Predicts the readings of each pose by `model`, displacements of the tool tip where it has none; `interval` returns half the 95 %
/// interval of a reading and the standard deviations in it.
fn predictions(
    model: &LoadedModel,
    poses: &[Measurement],
    interval: impl Fn(&Predicted, usize, &Reading) -> (f64, [f64; 3]),
) -> Vec<std::result::Result<Vec<Prediction>, Failure>> {
    let with_readings = |pose: &Measurement| match pose.readings.is_empty() {
        true => Measurement { readings: Reading::planned_displacements(), ..pose.clone() },
        false => pose.clone(),
    };
    let planned: Vec<Measurement> = poses.iter().map(with_readings).collect();
    let of_pose = |predicted: Predicted, plan: &Measurement, pose: &Measurement| {
        let each = plan.readings.iter().enumerate().map(|(i, reading)| {
            let (half_width, stds) = interval(&predicted, i, reading);
            let measured = pose.readings.get(i).map(|reading| reading.value);
            Prediction { column: reading.column, value: predicted.values[i], half_width, stds, measured }
        });
        each.collect()
    };
    let predicted = model.each(&planned.iter().collect::<Vec<_>>()).into_iter().zip(planned.iter().zip(poses));
    predicted.map(|(predicted, (plan, pose))| predicted.map(|predicted| of_pose(predicted, plan, pose))).collect()
}

/// Largest change along the null space, over the largest change by any unknown, of a reading that does not depend on it.
const UNIDENTIFIABLE: f64 = 1e-6;

/// Returns what the model leaves of the fitted rotations, or lengths, beyond the given noise, and their noise: standard deviations, mm or
/// rad; infinite where none was fitted.
fn residual_stds(study: &IdentificationStudy, fit: &Fit, is_rotation: bool) -> [f64; 2] {
    let readings = study.measurements.iter().flat_map(|measurement| &measurement.readings).zip(&fit.stds);
    let of_kind = readings.filter(|(reading, _)| reading.quantity.is_rotation() == is_rotation);
    let squares: Vec<f64> = of_kind.map(|(_, std)| std * std).collect();
    if squares.is_empty() {
        return [f64::INFINITY; 2];
    }
    let noise = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    // A fit follows what readings of a pose share more than it follows independent ones.
    let (count, unknowns) = ((study.reading_count() + study.priors.len()) as f64, fit.x.len() as f64);
    let wider = (count - unknowns).max(1.0) / (count - fit.design_effect * unknowns).max(1.0);
    let share = if study.noise.is_estimated { wider } else { (fit.scale * fit.scale * wider - 1.0).max(0.0) };
    [noise * share.sqrt(), noise]
}
