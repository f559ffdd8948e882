//! What a controller adds to the drives of the rigid machine.

use nalgebra::Vector3;
use serde::Serialize;

use super::{CorrectionQuestion, CorrectionTable, loaded::Loaded, table::between};
use crate::{
    input::error::Result,
    machine::{Configuration, Coordinate, Machine, Motion},
    simulation::Machines,
};

/// A way to correct.
#[derive(Debug, Clone, Copy)]
pub enum Corrector<'a> {
    /// Nothing is added.
    Nothing,
    /// A table over positions and forces.
    Table(&'a CorrectionTable),
    /// A table for each drive over its own position.
    PerJoint(&'a [JointTable]),
}

impl Corrector<'_> {
    /// Δρ of each drive where the nominal machine stands `at` a `position` of P (O, mm) under a force on the tool tip (O axes, N), mm
    /// or rad.
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

/// Most entries of a table for a drive: those that LinuxCNC reads of a `COMP_FILE`.
pub const MOST_ENTRIES: usize = 256;

/// Entries of a table for a drive.
const ENTRIES: usize = 65;
/// Positions along each axis from which the tables are made.
const SAMPLES: [usize; 2] = [129, 9];
/// A drive belongs to an axis if it moves with that axis by this share of what it moves with all of them.
const OWN_SHARE: f64 = 0.9;

/// Corrections of a drive over its own position, as controls have for errors of screws: all that a control can take which knows neither the
/// other drives nor the force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointTable {
    /// Its label.
    pub drive: String,
    /// Nominal positions, ascending, mm.
    pub positions_mm: Vec<f64>,
    /// Δρ there, mm.
    pub corrections_mm: Vec<f64>,
}

impl JointTable {
    /// Δρ at a nominal position, mm: linear between entries, that of the nearest entry beyond them.
    pub fn correction(&self, position_mm: f64) -> f64 {
        let (sides, share) = between(&self.positions_mm, position_mm);
        let [low, high] = sides.map(|entry| self.corrections_mm[entry]);
        low + share * (high - low)
    }
}

/// The axis of O to which each drive belongs: slides that move, at home, with one axis and hardly with the others.
///
/// # Errors
/// Why there are no such axes.
fn own_axes(machine: &Machine) -> std::result::Result<Vec<usize>, String> {
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

/// The tables that leave each drive as near as can be to the correction of `table` without force: in the middle between the smallest
/// and the largest at all positions of the box where the drive stands there. Why there are none, if so.
///
/// # Errors
/// A position of the box that the machine does not reach.
pub(super) fn tables(
    question: &CorrectionQuestion,
    machines: &Machines,
    table: &CorrectionTable,
) -> Result<std::result::Result<Vec<JointTable>, String>> {
    let axes = match own_axes(&question.machine) {
        Ok(axes) => axes,
        Err(reason) => return Ok(Err(reason)),
    };
    let loaded = Loaded::new(question, machines);
    let labels = question.machine.drive_labels();
    let mut tables = Vec::new();
    for (drive, (axis, label)) in axes.into_iter().zip(labels).enumerate() {
        let samples = question.grid(|other| SAMPLES[usize::from(other != axis)]);
        let found = (0..samples.len()).map(|index| {
            let position = samples.position(index);
            let nominal = loaded.stand(position)?.drives[drive];
            Ok((nominal, table.correction(position, Vector3::zeros())[drive]))
        });
        tables.push(middle(label, &found.collect::<Result<Vec<_>>>()?));
    }
    Ok(Ok(tables))
}

/// The table in the middle between the smallest and the largest of the corrections found about each entry.
fn middle(drive: String, found: &[(f64, f64)]) -> JointTable {
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
