//! Ways to correct the drives of the rigid machine on a controller.

use nalgebra::Vector3;
use serde::Serialize;

use super::{CorrectionQuestion, CorrectionTable, loaded::LoadedMachine, table::bracket};
use crate::{
    input::error::Result,
    machine::{Configuration, Coordinate, Machine, Motion},
    simulation::Machines,
};

/// A way to correct the drives.
#[derive(Debug, Clone, Copy)]
pub enum Corrector<'a> {
    /// No correction.
    Nothing,
    /// A table over positions and forces.
    Table(&'a CorrectionTable),
    /// A table of each drive over its own position.
    PerJoint(&'a [JointTable]),
}

impl Corrector<'_> {
    /// Returns Δρ of each drive, mm or rad, with P at `position` (O, mm; `at`: nominal machine there) under a tool tip force (O axes, N).
    pub fn correction(&self, at: &Configuration, position: Vector3<f64>, force: Vector3<f64>) -> Vec<f64> {
        match self {
            Corrector::Nothing => vec![0.0; at.drives.len()],
            Corrector::Table(table) => table.correction(position, force),
            Corrector::PerJoint(tables) => {
                tables.iter().zip(&at.drives).map(|(table, rho)| table.correction(*rho)).collect()
            }
        }
    }
}

/// Number of entries of a table of a single drive; LinuxCNC reads at most 256 from a `COMP_FILE`.
const ENTRIES: usize = 65;
/// Positions sampled for these tables, along the drive's own axis and along the others.
const SAMPLES: [usize; 2] = [129, 9];
/// Smallest share of a drive's motion along one axis by which it belongs to that axis.
const OWN_SHARE: f64 = 0.9;

/// Corrections of a drive over its own position, as controls have for screw errors; they regard neither the other drives nor the force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointTable {
    /// Label of the drive.
    pub drive: String,
    /// Nominal drive positions, ascending, mm.
    pub positions_mm: Vec<f64>,
    /// Δρ at these positions, mm.
    pub corrections_mm: Vec<f64>,
}

impl JointTable {
    /// Returns Δρ at a nominal position, mm: linear between entries, constant beyond them.
    pub fn correction(&self, position_mm: f64) -> f64 {
        let (sides, share) = bracket(&self.positions_mm, position_mm);
        let [low, high] = sides.map(|entry| self.corrections_mm[entry]);
        low + share * (high - low)
    }
}

/// Returns for each drive the axis of O (0 to 2) that it moves at home; `Err` with the reason if one is no prismatic joint or moves several axes.
fn drive_axes(machine: &Machine) -> std::result::Result<Vec<usize>, String> {
    let fail = |reason: &str| Err(format!("a table for each drive over its own position would mean nothing: {reason}"));
    if machine.drives().any(|(_, drive)| drive.motion == Motion::Revolute) {
        return fail("not all drives are prismatic joints");
    }
    let translations: Vec<usize> = machine
        .controls
        .iter()
        .filter_map(|control| if let Coordinate::Translation(axis) = control { Some(*axis) } else { None })
        .collect();
    if translations.len() != machine.controls.len() || translations.len() != machine.drive_count() {
        return fail("the drives do not move one axis of the base each");
    }
    let Some(jacobian) = machine.drive_jacobian(&machine.home) else { return fail("home is singular") };
    let mut axes = Vec::new();
    for row in jacobian.row_iter() {
        let largest = row.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        match largest {
            Some((column, share)) if share.abs() >= OWN_SHARE * row.norm() && !axes.contains(&translations[column]) => {
                axes.push(translations[column]);
            }
            _ => return fail("at home a drive moves with several axes of the base, or two with the same"),
        }
    }
    Ok(axes)
}

/// Returns the table of each drive: the middle between its smallest and largest correction of `table` without force, over all positions of
/// the box with the drive there; the inner `Err` says why no such tables exist.
pub(super) fn joint_tables(
    question: &CorrectionQuestion,
    machines: &Machines,
    table: &CorrectionTable,
) -> Result<std::result::Result<Vec<JointTable>, String>> {
    let axes = match drive_axes(&question.machine) {
        Ok(axes) => axes,
        Err(reason) => return Ok(Err(reason)),
    };
    let loaded = LoadedMachine::new(question, machines);
    let labels = question.machine.drive_labels();
    let mut tables = Vec::new();
    for (drive, (axis, label)) in axes.into_iter().zip(labels).enumerate() {
        let samples = question.grid(|other| SAMPLES[usize::from(other != axis)]);
        let samples_of_drive = (0..samples.len()).map(|index| {
            let position = samples.position(index);
            let nominal = loaded.nominal_at(position)?.drives[drive];
            Ok((nominal, table.correction(position, Vector3::zeros())[drive]))
        });
        tables.push(middle_table(label, &samples_of_drive.collect::<Result<Vec<_>>>()?));
    }
    Ok(Ok(tables))
}

/// Returns the table of `drive` from samples (position, correction): at each entry, the middle of the corrections sampled near it.
fn middle_table(drive: String, samples: &[(f64, f64)]) -> JointTable {
    let widen = |range: [f64; 2], value: f64| [range[0].min(value), range[1].max(value)];
    let [low, high] = samples.iter().map(|sample| sample.0).fold([f64::INFINITY, f64::NEG_INFINITY], widen);
    if low >= high {
        let [least, most] = samples.iter().map(|sample| sample.1).fold([f64::INFINITY, f64::NEG_INFINITY], widen);
        return JointTable { drive, positions_mm: vec![low], corrections_mm: vec![0.5 * (least + most)] };
    }
    let step = (high - low) / (ENTRIES - 1) as f64;
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; ENTRIES];
    for (position, correction) in samples {
        let entry = (((position - low) / step).round() as usize).min(ENTRIES - 1);
        ranges[entry] = widen(ranges[entry], *correction);
    }
    let filled = ranges.iter().enumerate().filter(|(_, range)| range[0] <= range[1]);
    let (positions_mm, corrections_mm) =
        filled.map(|(entry, range)| (low + step * entry as f64, 0.5 * (range[0] + range[1]))).unzip();
    JointTable { drive, positions_mm, corrections_mm }
}
