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
    let none =
        |error: crate::input::error::Error| (None, Failure { status: "no_machine".into(), reason: error.to_string() });
    let there = machine_at(machine, unknowns, x).map_err(none)?;
    let names: Vec<&str> = unknowns.iter().map(|unknown| unknown.name.as_str()).collect();
    let sensitivities = Sensitivities::new(&there, &names).map_err(none)?;
    let scales: Vec<f64> = unknowns.iter().zip(x.iter()).map(|(unknown, &x)| unknown.slope(x)).collect();
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

/// What displacements along the axes of O would read under `load` where `own` was measured: derivatives by the coordinates of the
/// unknowns at `x`, 3 rows. `None` where the machine does not settle.
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

    /// Derivatives of the tool tip's displacement at the place of this measurement by the coordinates of the unknowns.
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
        let loaded = self.settled(own, own.load)?;
        let is_relative = readings.iter().any(|reading| !matches!(reading.quantity, Quantity::Position(_)));
        let reference = if is_relative { Some(self.settled(own, own.reference)?) } else { None };
        let count = loaded.by.len();
        let of = |reading: &Reading| {
            let after = self.motion(own, &loaded);
            let before = reference.as_ref().map(|reference| self.motion(own, reference));
            let from = |axis: usize, direction: Vector3<f64>| -> (f64, Vec<f64>) {
                match (&reference, &before) {
                    (Some(reference), Some(before)) => {
                        let value = match reading.quantity {
                            Quantity::Rotation(_) => {
                                rotation_log(&(loaded.pose.rotation * reference.pose.rotation.transpose()))[axis]
                            }
                            _ => direction.dot(&(after.0 - before.0)),
                        };
                        let part = |twist: &Vector6<f64>| match reading.quantity {
                            Quantity::Rotation(_) => twist[3 + axis],
                            _ => direction.dot(&twist.fixed_rows::<3>(0)),
                        };
                        (value, (0..count).map(|k| part(&after.1[k]) - part(&before.1[k])).collect())
                    }
                    _ => (after.0[axis], after.1.iter().map(|twist| twist[axis]).collect()),
                }
            };
            match reading.quantity {
                Quantity::Displacement(direction) => from(0, direction),
                Quantity::Rotation(axis) => from(axis, Vector3::zeros()),
                Quantity::Position(axis) => (after.0[axis], after.1.iter().map(|twist| twist[axis]).collect()),
            }
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
