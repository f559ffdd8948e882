//! What a machine should have read, and how that changes with the parameters sought.

use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use rayon::prelude::*;

use super::{
    measurements::{Applied, Measurement, Quantity, Reading},
    unknown::Unknown,
};
use crate::{
    input::error::Result,
    machine::{Machine, Variation},
    simulation::{Failure, Machines},
    spatial::{Pose, Wrench, rotation_exp, rotation_log},
    statics::{Outcome, Sensitivities, Sensitivity, Settings, State, Workspace, equilibrium, lost_motions},
};

/// Solved this closely, derivatives are good to more digits than measurements have.
const SETTINGS: Settings = Settings { tolerance: 1e-12, max_iterations: 20 };

/// Predictions of all readings, mm and rad, and their derivatives by the coordinates of the unknowns.
#[derive(Debug, Clone)]
pub struct Predicted {
    /// In the order of the measurements and their readings.
    pub values: DVector<f64>,
    /// A row for each reading, a column for each unknown.
    pub slopes: DMatrix<f64>,
}

/// The machine whose unknowns stand at `x`.
///
/// # Errors
/// It makes no machine.
pub fn machine_at(machine: &Machine, unknowns: &[Unknown], x: &DVector<f64>) -> Result<Machine> {
    let values: Vec<(&str, f64)> =
        unknowns.iter().zip(x.iter()).map(|(unknown, &x)| (unknown.name.as_str(), unknown.value(x))).collect();
    machine.with_parameters(&values)
}

/// What `measurements` should have read, with unknowns at `x`.
///
/// # Errors
/// The number of a measurement at which the machine does not settle, and why; or [`None`] and why there is no such machine.
pub fn predict(
    machine: &Machine,
    unknowns: &[Unknown],
    x: &DVector<f64>,
    measurements: &[&Measurement],
) -> std::result::Result<Predicted, (Option<usize>, Failure)> {
    predict_by(machine, unknowns, x, measurements, unknowns)
}

/// The same without derivatives.
///
/// # Errors
/// Those of [`predict`].
pub fn values_at(
    machine: &Machine,
    unknowns: &[Unknown],
    x: &DVector<f64>,
    measurements: &[&Measurement],
) -> std::result::Result<DVector<f64>, (Option<usize>, Failure)> {
    predict_by(machine, unknowns, x, measurements, &[]).map(|predicted| predicted.values)
}

/// Predictions with derivatives by the first of the unknowns, `by`.
fn predict_by(
    machine: &Machine,
    unknowns: &[Unknown],
    x: &DVector<f64>,
    measurements: &[&Measurement],
    by: &[Unknown],
) -> std::result::Result<Predicted, (Option<usize>, Failure)> {
    let none =
        |error: crate::input::error::Error| (None, Failure { status: "no_machine".into(), reason: error.to_string() });
    let there = LoadedModel::new(machine, unknowns, x, by).map_err(none)?;
    let each = there.each(measurements).into_iter().enumerate();
    let each = each.map(|(i, own)| own.map_err(|failure| (Some(i), failure)));
    let rows: Vec<Predicted> = each.collect::<std::result::Result<_, _>>()?;
    let count = rows.iter().map(|own| own.values.len()).sum();
    let mut all = Predicted { values: DVector::zeros(count), slopes: DMatrix::zeros(count, by.len()) };
    let mut first = 0;
    for own in rows {
        let count = own.values.len();
        all.values.rows_mut(first, count).copy_from(&own.values);
        all.slopes.rows_mut(first, count).copy_from(&own.slopes);
        first += count;
    }
    Ok(all)
}

/// A machine with the numbers that some unknowns give it.
#[derive(Debug, Clone)]
pub struct LoadedModel {
    machine: Machine,
    sensitivities: Sensitivities,
    /// What each parameter does to the backlash of each drive, mm or rad per unit.
    by_backlash: Vec<Vec<f64>>,
    /// Change of each parameter per unit of its coordinate.
    scales: Vec<f64>,
}

impl LoadedModel {
    /// With `unknowns` at `x`, and derivatives by the first of them, `by`.
    ///
    /// # Errors
    /// There is no such machine.
    pub fn new(machine: &Machine, unknowns: &[Unknown], x: &DVector<f64>, by: &[Unknown]) -> Result<Self> {
        let own = machine_at(machine, unknowns, x)?;
        let names: Vec<&str> = by.iter().map(|unknown| unknown.name.as_str()).collect();
        let mut variations = own.variations(&names)?;
        // What a number does to where the drives were zeroed is a part of what it does.
        for beside in variations.iter_mut().flat_map(|variation| &mut variation.machines) {
            *beside = Machines::zeroed_as_used(beside)?;
        }
        let machine = Machines::zeroed_as_used(&own)?;
        let sensitivities = Sensitivities::by(&machine, variations);
        let of = |variation: &Variation| {
            let mut slopes = vec![0.0; machine.drive_count()];
            for (beside, weight) in variation.machines.iter().zip(variation.weights()) {
                let backlashes = beside.drives().map(|(_, drive)| drive.backlash);
                slopes.iter_mut().zip(backlashes).for_each(|(slope, backlash)| *slope += weight * backlash);
            }
            slopes
        };
        Ok(Self {
            by_backlash: sensitivities.variations().map(of).collect(),
            scales: by.iter().zip(x.iter()).map(|(unknown, &x)| unknown.slope(x)).collect(),
            sensitivities,
            machine,
        })
    }

    /// What each of `measurements` should have read, or why that is not known; on the current rayon pool.
    pub fn each(&self, measurements: &[&Measurement]) -> Vec<std::result::Result<Predicted, Failure>> {
        let storage = || (self.sensitivities.clone(), Workspace::new(&self.machine));
        let of = |(sensitivities, workspace): &mut (Sensitivities, Workspace), own: &&Measurement| {
            let mut solver = Solver { model: self, sensitivities, workspace };
            let rows = solver.readings(own)?;
            let values = DVector::from_iterator(rows.len(), rows.iter().map(|(value, _)| *value));
            let slopes = DMatrix::from_fn(rows.len(), self.scales.len(), |i, j| rows[i].1[j] * self.scales[j]);
            Ok(Predicted { values, slopes })
        };
        measurements.par_iter().map_init(storage, of).collect()
    }
}

struct Solver<'a> {
    model: &'a LoadedModel,
    sensitivities: &'a mut Sensitivities,
    workspace: &'a mut Workspace,
}

/// A loaded pose and what the parameters do to it.
struct Settled {
    pose: Pose,
    by: Vec<Sensitivity>,
}

impl Solver<'_> {
    /// Each reading with its derivatives by the parameters, per unit of those.
    fn readings(&mut self, own: &Measurement) -> std::result::Result<Vec<(f64, Vec<f64>)>, Failure> {
        let (reference, loaded) = (self.settled(own, own.reference)?, self.settled(own, own.load)?);
        let (before, after) = (self.motion(own, &reference), self.motion(own, &loaded));
        let turned = rotation_log(&(loaded.pose.rotation * reference.pose.rotation.transpose()));
        let change = |k: usize| after.1[k] - before.1[k];
        let parameters = 0..after.1.len();
        let of = |reading: &Reading| match reading.quantity {
            Quantity::Displacement(along) => {
                let slope = |k: usize| along.dot(&change(k).fixed_rows::<3>(0));
                (along.dot(&(after.0 - before.0)), parameters.clone().map(slope).collect())
            }
            // Rotations are small, so that they add up.
            Quantity::Rotation(axis) => (turned[axis], parameters.clone().map(|k| change(k)[3 + axis]).collect()),
            Quantity::Position(axis) => (after.0[axis], after.1.iter().map(|twist| twist[axis]).collect()),
        };
        Ok(own.readings.iter().map(of).collect())
    }

    /// Where the marker is, and its motion by each parameter, displacement and rotation.
    fn motion(&self, own: &Measurement, settled: &Settled) -> (Vector3<f64>, Vec<Vector6<f64>>) {
        let marker = own.marker.unwrap_or(self.model.machine.tool_tip);
        let lever = settled.pose.rotation * marker;
        let by = settled.by.iter().map(|sensitivity| {
            let mut twist = sensitivity.twist;
            let mut moved = twist.fixed_rows::<3>(0) + twist.fixed_rows::<3>(3).cross(&lever);
            if own.marker.is_none() {
                moved += settled.pose.rotation * sensitivity.tool_tip;
            }
            twist.fixed_rows_mut::<3>(0).copy_from(&moved);
            twist
        });
        (settled.pose.transform(marker), by.collect())
    }

    fn settled(&mut self, own: &Measurement, load: Applied) -> std::result::Result<Settled, Failure> {
        let turned = own.at.pose.rotation;
        let at_p = |machine: &Machine| Wrench {
            force: load.force,
            moment: load.moment + (turned * machine.tool_tip).cross(&load.force),
        };
        let machine = &self.model.machine;
        let mut state = State::rigid(machine, &own.at);
        let drives = &own.at.drives;
        let outcome = equilibrium(machine, drives, &at_p(machine), &mut state, self.workspace, &SETTINGS);
        let status = &outcome.status;
        if status.label() != crate::simulation::SOLVED {
            return Err(Failure { status: status.label().into(), reason: status.reason(machine) });
        }
        let Some(mut by) = self.sensitivities.at(machine, drives, &state, &at_p, self.workspace) else {
            let reason = "the platform can move without resistance".into();
            return Err(Failure { status: "singular".into(), reason });
        };
        let mut pose = state.pose;
        if let Some(motions) = self.lost_motions(&state, &outcome) {
            let lost: Vector6<f64> =
                motions.iter().zip(machine.drives()).map(|(motion, (_, drive))| motion * drive.backlash).sum();
            let (linear, angular): (Vector3<f64>, Vector3<f64>) =
                (lost.fixed_rows::<3>(0).into(), lost.fixed_rows::<3>(3).into());
            pose = Pose { rotation: rotation_exp(angular) * pose.rotation, translation: pose.translation + linear };
            for (own, slopes) in by.iter_mut().zip(&self.model.by_backlash) {
                own.twist += motions.iter().zip(slopes).map(|(motion, slope)| motion * *slope).sum::<Vector6<f64>>();
            }
        }
        Ok(Settled { pose, by })
    }

    /// Of each drive; `None` where none has backlash.
    fn lost_motions(&self, state: &State, outcome: &Outcome) -> Option<Vec<Vector6<f64>>> {
        let machine = &self.model.machine;
        let has_any = machine.drives().any(|(_, drive)| drive.backlash > 0.0);
        has_any.then(|| lost_motions(machine, state, &outcome.drive_sensitivity)).flatten()
    }
}
