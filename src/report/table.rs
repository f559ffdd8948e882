//! Columns that tables of drives share.

use crate::machine::{Drive, Machine, Motion};

/// A column of drive corrections per drive: `delta_rho_LABEL_mm` or `_deg`.
pub fn correction_columns(machine: &Machine) -> impl Iterator<Item = String> {
    labelled(machine).map(|(label, motion)| match motion {
        Motion::Prismatic => format!("delta_rho_{label}_mm"),
        Motion::Revolute => format!("delta_rho_{label}_deg"),
    })
}

/// A column of drive forces per drive: `drive_force_LABEL_N` or `drive_torque_LABEL_Nmm`.
pub fn force_columns(machine: &Machine) -> impl Iterator<Item = String> {
    labelled(machine).map(|(label, motion)| match motion {
        Motion::Prismatic => format!("drive_force_{label}_N"),
        Motion::Revolute => format!("drive_torque_{label}_Nmm"),
    })
}

fn labelled(machine: &Machine) -> impl Iterator<Item = (String, Motion)> {
    machine.drive_labels().into_iter().zip(machine.drives().map(|(_, drive)| drive.motion))
}

/// Drive positions or corrections in the units of tables, mm or degrees, from mm or rad.
pub fn shown_positions(machine: &Machine, values: &[f64]) -> Vec<f64> {
    let shown = |(value, (_, drive)): (&f64, (usize, &Drive))| match drive.motion {
        Motion::Prismatic => *value,
        Motion::Revolute => value.to_degrees(),
    };
    values.iter().zip(machine.drives()).map(shown).collect()
}
