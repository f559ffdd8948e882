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
    /// Returns Δρ of each drive, mm or rad, where the nominal machine stands `at` a `position` of P (O, mm) under a tool tip force (O axes, N).
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

/// Most entries of a table of a single drive: those that LinuxCNC reads from a `COMP_FILE`.
pub const MOST_ENTRIES: usize = 256;

/// Number of entries of a table of a single drive.
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

/// Returns the axis of O of each drive, a slide that at home moves with one axis and hardly with the others; or why there are no such axes.
fn drive_axes(machine: &Machine) -> std::result::Result<Vec<usize>, String> {
    let no = |reason: &str| Err(format!("a table for each drive over its own position would mean nothing: {reason}"));
    if machine.drives().any(|(_, drive)| drive.motion == Motion::Revolute) {
        return no("not all drives are slides");
    }
    let translations: Vec<usize> = machine
        .controls
        .iter()
        .filter_map(|own| if let Coordinate::Translation(axis) = own { Some(*axis) } else { None })
        .collect();
    if translations.len() != machine.controls.len() || translations.len() != machine.drive_count() {
        return no("the drives do not move one axis of the base each");
    }
    let Some(jacobian) = machine.drive_jacobian(&machine.home) else { return no("home is singular") };
    let mut axes = Vec::new();
    for row in jacobian.row_iter() {
        let own = row.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        match own {
            Some((column, share)) if share.abs() >= OWN_SHARE * row.norm() && !axes.contains(&translations[column]) => {
                axes.push(translations[column]);
            }
            _ => return no("at home a drive moves with several axes of the base, or two with the same"),
        }
    }
    Ok(axes)
}

/// Returns the table of each drive: the middle between its smallest and largest correction of `table` without force, over all positions of
/// the box with the drive there; the inner error says why there are none.
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
        let found = (0..samples.len()).map(|index| {
            let position = samples.position(index);
            let nominal = loaded.nominal_at(position)?.drives[drive];
            Ok((nominal, table.correction(position, Vector3::zeros())[drive]))
        });
        tables.push(middle_table(label, &found.collect::<Result<Vec<_>>>()?));
    }
    Ok(Ok(tables))
}

/// Returns the table of `drive` with the middle between the smallest and the largest correction found near each entry.
fn middle_table(drive: String, found: &[(f64, f64)]) -> JointTable {
    let ends = |ends: [f64; 2], value: f64| [ends[0].min(value), ends[1].max(value)];
    let [low, high] = found.iter().map(|own| own.0).fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    if low >= high {
        let [least, most] = found.iter().map(|own| own.1).fold([f64::INFINITY, f64::NEG_INFINITY], ends);
        return JointTable { drive, positions_mm: vec![low], corrections_mm: vec![0.5 * (least + most)] };
    }
    let step = (high - low) / (ENTRIES - 1) as f64;
    let mut about = vec![[f64::INFINITY, f64::NEG_INFINITY]; ENTRIES];
    for (position, correction) in found {
        let entry = (((position - low) / step).round() as usize).min(ENTRIES - 1);
        about[entry] = ends(about[entry], *correction);
    }
    let seen = about.iter().enumerate().filter(|(_, ends)| ends[0] <= ends[1]);
    let (positions_mm, corrections_mm) =
        seen.map(|(entry, ends)| (low + step * entry as f64, 0.5 * (ends[0] + ends[1]))).unzip();
    JointTable { drive, positions_mm, corrections_mm }
}
