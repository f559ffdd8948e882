//! The measurement model: predicted readings of a machine under load, and their derivatives by the unknown parameters.

use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use rayon::prelude::*;

use super::{
    measurements::{AppliedLoad, Measurement, Quantity, Reading},
    unknown::Unknown,
};
use crate::{
    input::error::Result,
    machine::{Machine, Variation},
    simulation::{Failure, Machines},
    spatial::{Pose, Wrench, rotation_exp, rotation_log},
    statics::{Outcome, Scratch, Sensitivities, Sensitivity, Settings, State, equilibrium, lost_motions},
};

/// Solver settings, so tight that derivatives are good to more digits than measurements have.
const SETTINGS: Settings = Settings { tolerance: 1e-12, max_iterations: 20 };

/// Predicted readings, mm and rad, and their derivatives by the coordinates of the unknowns.
#[derive(Debug, Clone)]
pub struct Predicted {
    /// Predicted readings, in the order of the measurements and their readings.
    pub values: DVector<f64>,
    /// Jacobian: a row for each reading, a column for each unknown.
    pub slopes: DMatrix<f64>,
}

/// Returns `machine` with `unknowns` at coordinates `x`; `Err` if these values make no valid machine.
pub fn machine_with(machine: &Machine, unknowns: &[Unknown], x: &DVector<f64>) -> Result<Machine> {
    let values: Vec<(&str, f64)> =
        unknowns.iter().zip(x.iter()).map(|(unknown, &x)| (unknown.name.as_str(), unknown.value(x))).collect();
    machine.with_parameters(&values)
}

/// Predicts the readings of `measurements` with `unknowns` at coordinates `x`, mm and rad, without derivatives; `Err` as of [`predict`].
pub(super) fn predict_values(
    machine: &Machine,
    unknowns: &[Unknown],
    x: &DVector<f64>,
    measurements: &[&Measurement],
) -> std::result::Result<DVector<f64>, (Option<usize>, Failure)> {
    predict(machine, unknowns, x, measurements, &[]).map(|predicted| predicted.values)
}

/// Predicts the readings of `measurements` with `unknowns` at coordinates `x`, and their derivatives by `by`, the first of these.
///
/// # Errors
/// The index of a measurement at which the machine has no equilibrium, and why; or [`None`] and why these values make no machine.
pub(super) fn predict(
    machine: &Machine,
    unknowns: &[Unknown],
    x: &DVector<f64>,
    measurements: &[&Measurement],
    by: &[Unknown],
) -> std::result::Result<Predicted, (Option<usize>, Failure)> {
    let invalid_machine =
        |error: crate::input::error::Error| (None, Failure { status: "no_machine".into(), reason: error.to_string() });
    let model = LoadedModel::new(machine, unknowns, x, by).map_err(invalid_machine)?;
    let each = model.each(measurements).into_iter().enumerate();
    let each = each.map(|(i, prediction)| prediction.map_err(|failure| (Some(i), failure)));
    let rows: Vec<Predicted> = each.collect::<std::result::Result<_, _>>()?;
    let count = rows.iter().map(|prediction| prediction.values.len()).sum();
    let mut all = Predicted { values: DVector::zeros(count), slopes: DMatrix::zeros(count, by.len()) };
    let mut first = 0;
    for prediction in rows {
        let count = prediction.values.len();
        all.values.rows_mut(first, count).copy_from(&prediction.values);
        all.slopes.rows_mut(first, count).copy_from(&prediction.slopes);
        first += count;
    }
    Ok(all)
}

/// A machine with given values of its unknowns, prepared to predict readings under load.
#[derive(Debug, Clone)]
pub struct LoadedModel {
    machine: Machine,
    sensitivities: Sensitivities,
    /// Derivative of half the backlash of each drive by each parameter, mm or rad per unit of the parameter.
    backlash_slopes: Vec<Vec<f64>>,
    /// Derivative of each parameter by its coordinate.
    scales: Vec<f64>,
}

impl LoadedModel {
    /// Prepares predictions of `machine` with `unknowns` at coordinates `x`, with derivatives by `by`, the first of these. `Err` if these
    /// values make no valid machine.
    pub fn new(machine: &Machine, unknowns: &[Unknown], x: &DVector<f64>, by: &[Unknown]) -> Result<Self> {
        let fitted = machine_with(machine, unknowns, x)?;
        let names: Vec<&str> = by.iter().map(|unknown| unknown.name.as_str()).collect();
        let mut variations = fitted.variations(&names)?;
        // What a number does to where the drives were zeroed is a part of what it does.
        for varied in variations.iter_mut().flat_map(|variation| &mut variation.machines) {
            *varied = Machines::actual_as_zeroed(varied)?;
        }
        let machine = Machines::actual_as_zeroed(&fitted)?;
        let sensitivities = Sensitivities::from_variations(&machine, variations);
        let slopes_of = |variation: &Variation| {
            let mut slopes = vec![0.0; machine.drive_count()];
            for (varied, weight) in variation.machines.iter().zip(variation.weights()) {
                let backlashes = varied.drives().map(|(_, drive)| drive.half_backlash);
                slopes.iter_mut().zip(backlashes).for_each(|(slope, backlash)| *slope += weight * backlash);
            }
            slopes
        };
        Ok(Self {
            backlash_slopes: sensitivities.variations().map(slopes_of).collect(),
            scales: by.iter().zip(x.iter()).map(|(unknown, &x)| unknown.slope(x)).collect(),
            sensitivities,
            machine,
        })
    }

    /// Predicts the readings of each measurement and their derivatives by coordinates, or says why it cannot; on the current rayon pool.
    pub fn each(&self, measurements: &[&Measurement]) -> Vec<std::result::Result<Predicted, Failure>> {
        let storage = || (self.sensitivities.clone(), Scratch::new(&self.machine));
        let predict_one = |(sensitivities, scratch): &mut (Sensitivities, Scratch), measurement: &&Measurement| {
            let mut solver = Solver { model: self, sensitivities, scratch };
            let rows = solver.readings(measurement)?;
            let values = DVector::from_iterator(rows.len(), rows.iter().map(|(value, _)| *value));
            let slopes = DMatrix::from_fn(rows.len(), self.scales.len(), |i, j| rows[i].1[j] * self.scales[j]);
            Ok(Predicted { values, slopes })
        };
        measurements.par_iter().map_init(storage, predict_one).collect()
    }
}

/// A model with the storage of one thread.
struct Solver<'a> {
    model: &'a LoadedModel,
    sensitivities: &'a mut Sensitivities,
    scratch: &'a mut Scratch,
}

/// Pose of P in O under load, and its derivatives by the parameters.
struct LoadedPose {
    pose: Pose,
    by: Vec<Sensitivity>,
}

impl Solver<'_> {
    /// Predicts each reading of a measurement, mm or rad, with its derivatives per unit of each parameter.
    fn readings(&mut self, row: &Measurement) -> std::result::Result<Vec<(f64, Vec<f64>)>, Failure> {
        let (reference, loaded) = (self.loaded_pose(row, row.reference)?, self.loaded_pose(row, row.load)?);
        let (before, after) = (self.marker_motion(row, &reference), self.marker_motion(row, &loaded));
        let angles = rotation_log(&(loaded.pose.rotation * reference.pose.rotation.transpose()));
        let change = |k: usize| after.1[k] - before.1[k];
        let parameters = 0..after.1.len();
        let reading_of = |reading: &Reading| match reading.quantity {
            Quantity::Displacement(along) => {
                let slope = |k: usize| along.dot(&change(k).fixed_rows::<3>(0));
                (along.dot(&(after.0 - before.0)), parameters.clone().map(slope).collect())
            }
            // Rotations are small, so that they add up.
            Quantity::Rotation(axis) => (angles[axis], parameters.clone().map(|k| change(k)[3 + axis]).collect()),
            Quantity::Position(axis) => (after.0[axis], after.1.iter().map(|twist| twist[axis]).collect()),
        };
        Ok(row.readings.iter().map(reading_of).collect())
    }

    /// Returns the position of the marker in O, mm, and for each parameter the twist (mm, rad, O axes) by which it moves per unit.
    fn marker_motion(&self, own: &Measurement, loaded_pose: &LoadedPose) -> (Vector3<f64>, Vec<Vector6<f64>>) {
        let marker = own.marker.unwrap_or(self.model.machine.tool_tip);
        let lever = loaded_pose.pose.rotation * marker;
        let by = loaded_pose.by.iter().map(|sensitivity| {
            let mut twist = sensitivity.twist;
            let mut moved = twist.fixed_rows::<3>(0) + twist.fixed_rows::<3>(3).cross(&lever);
            if own.marker.is_none() {
                moved += loaded_pose.pose.rotation * sensitivity.tool_tip;
            }
            twist.fixed_rows_mut::<3>(0).copy_from(&moved);
            twist
        });
        (loaded_pose.pose.transform(marker), by.collect())
    }

    /// Solves the pose of P under `load` with lost motion, and its derivatives by the parameters; `Err` if there is no stable equilibrium.
    fn loaded_pose(&mut self, row: &Measurement, load: AppliedLoad) -> std::result::Result<LoadedPose, Failure> {
        let unloaded_rotation = row.at.pose.rotation;
        let at_p = |machine: &Machine| Wrench {
            force: load.force,
            moment: load.moment + (unloaded_rotation * machine.tool_tip).cross(&load.force),
        };
        let machine = &self.model.machine;
        let mut state = State::rigid(machine, &row.at);
        let drives = &row.at.drives;
        let outcome = equilibrium(machine, drives, &at_p(machine), &mut state, self.scratch, &SETTINGS);
        let status = &outcome.status;
        if status.label() != crate::simulation::SOLVED {
            return Err(Failure { status: status.label().into(), reason: status.reason(machine) });
        }
        let Some(mut by) = self.sensitivities.at(machine, drives, &state, &at_p, self.scratch) else {
            let reason = "the platform can move without resistance".into();
            return Err(Failure { status: "singular".into(), reason });
        };
        let mut pose = state.pose;
        if let Some(motions) = self.lost_motions(&state, &outcome) {
            let lost: Vector6<f64> =
                motions.iter().zip(machine.drives()).map(|(motion, (_, drive))| motion * drive.half_backlash).sum();
            let (linear, angular): (Vector3<f64>, Vector3<f64>) =
                (lost.fixed_rows::<3>(0).into(), lost.fixed_rows::<3>(3).into());
            pose = Pose { rotation: rotation_exp(angular) * pose.rotation, translation: pose.translation + linear };
            for (row, slopes) in by.iter_mut().zip(&self.model.backlash_slopes) {
                row.twist += motions.iter().zip(slopes).map(|(motion, slope)| motion * *slope).sum::<Vector6<f64>>();
            }
        }
        Ok(LoadedPose { pose, by })
    }

    /// Returns the twist of P (mm, rad, O axes) per unit of half each drive's backlash, under load; `None` where no drive has backlash.
    fn lost_motions(&self, state: &State, outcome: &Outcome) -> Option<Vec<Vector6<f64>>> {
        let machine = &self.model.machine;
        let has_any = machine.drives().any(|(_, drive)| drive.half_backlash > 0.0);
        has_any.then(|| lost_motions(machine, state, &outcome.drive_sensitivity)).flatten()
    }
}
