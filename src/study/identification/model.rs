//! What a machine should have read, and how that changes with the parameters sought.

use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use rayon::prelude::*;

use super::{
    measurements::{Applied, Measurement, Quantity, Reading},
    unknown::Unknown,
};
use crate::{
    input::error::Result,
    machine::Machine,
    spatial::{Pose, Wrench, rotation_log},
    statics::{Sensitivities, Sensitivity, Settings, State, Workspace, equilibrium},
    study::Failure,
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
    let there = machine_at(machine, unknowns, x).map_err(none)?;
    let names: Vec<&str> = by.iter().map(|unknown| unknown.name.as_str()).collect();
    let sensitivities = Sensitivities::new(&there, &names).map_err(none)?;
    let scales: Vec<f64> = by.iter().zip(x.iter()).map(|(unknown, &x)| unknown.slope(x)).collect();
    let storage = || (sensitivities.clone(), Workspace::new(&there));
    let of = |(sensitivities, workspace): &mut (Sensitivities, Workspace), (i, own): (usize, &&Measurement)| {
        let mut solver = Solver { machine: &there, sensitivities, workspace };
        solver.readings(own, &own.readings).map_err(|failure| (Some(i), failure))
    };
    let rows: Vec<Vec<(f64, Vec<f64>)>> =
        measurements.par_iter().enumerate().map_init(storage, of).collect::<std::result::Result<_, _>>()?;
    Ok(gathered(rows.into_iter().flatten().collect(), &scales))
}

fn gathered(rows: Vec<(f64, Vec<f64>)>, scales: &[f64]) -> Predicted {
    let values = DVector::from_iterator(rows.len(), rows.iter().map(|(value, _)| *value));
    let slopes = DMatrix::from_fn(rows.len(), scales.len(), |i, j| rows[i].1[j] * scales[j]);
    Predicted { values, slopes }
}

/// Measurements that could be made at the places of others.
pub struct Candidates<'a> {
    there: Machine,
    sensitivities: Sensitivities,
    workspace: Workspace,
    scales: Vec<f64>,
    measurements: &'a [Measurement],
}

impl<'a> Candidates<'a> {
    /// At the unknowns' coordinates `x`.
    ///
    /// # Errors
    /// There is no such machine.
    pub fn new(
        machine: &Machine,
        unknowns: &[Unknown],
        x: &DVector<f64>,
        measurements: &'a [Measurement],
    ) -> Result<Self> {
        let there = machine_at(machine, unknowns, x)?;
        let names: Vec<&str> = unknowns.iter().map(|unknown| unknown.name.as_str()).collect();
        Ok(Self {
            sensitivities: Sensitivities::new(&there, &names)?,
            workspace: Workspace::new(&there),
            scales: unknowns.iter().zip(x.iter()).map(|(unknown, &x)| unknown.slope(x)).collect(),
            there,
            measurements,
        })
    }

    /// Derivatives of the tool tip's displacement by `load` at the place of this measurement, along the axes of O (rows), by the
    /// coordinates of the unknowns; `None` where the machine does not settle.
    pub fn slopes(&mut self, measurement: usize, load: Applied) -> Option<DMatrix<f64>> {
        let own = &self.measurements[measurement];
        let nothing = Applied { force: Vector3::zeros(), moment: Vector3::zeros() };
        let asked = Measurement { load, reference: nothing, marker: None, readings: Vec::new(), ..own.clone() };
        let reading = |axis: usize| Reading {
            column: "",
            quantity: Quantity::Displacement(Vector3::from_fn(|i, _| if i == axis { 1.0 } else { 0.0 })),
            value: 0.0,
            std: None,
        };
        let Self { there, sensitivities, workspace, .. } = self;
        let mut solver = Solver { machine: there, sensitivities, workspace };
        let rows = solver.readings(&asked, &[reading(0), reading(1), reading(2)]).ok()?;
        Some(gathered(rows, &self.scales).slopes)
    }
}

struct Solver<'a> {
    machine: &'a Machine,
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
    fn readings(
        &mut self,
        own: &Measurement,
        readings: &[Reading],
    ) -> std::result::Result<Vec<(f64, Vec<f64>)>, Failure> {
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
        Ok(readings.iter().map(of).collect())
    }

    /// Where the marker is, and its motion by each parameter, displacement and rotation.
    fn motion(&self, own: &Measurement, settled: &Settled) -> (Vector3<f64>, Vec<Vector6<f64>>) {
        let marker = own.marker.unwrap_or(self.machine.tool_tip);
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
        let mut state = State::rigid(self.machine, &own.at);
        let drives = &own.at.drives;
        let outcome = equilibrium(self.machine, drives, &at_p(self.machine), &mut state, self.workspace, &SETTINGS);
        let status = &outcome.status;
        if status.label() != crate::study::SOLVED {
            return Err(Failure { status: status.label().into(), reason: status.reason(self.machine) });
        }
        match self.sensitivities.at(self.machine, drives, &state, &at_p, self.workspace) {
            Some(by) => Ok(Settled { pose: state.pose, by }),
            None => {
                Err(Failure { status: "singular".into(), reason: "the platform can move without resistance".into() })
            }
        }
    }
}
