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

/// Unit of drive positions and corrections in tables and figures: mm, °, or both where a machine has slides and hinges.
pub fn position_unit(machine: &Machine) -> &'static str {
    unit(machine, ["mm", "°", "mm or °"])
}

/// Unit of drive forces: N, N·mm, or both where a machine has slides and hinges.
pub fn force_unit(machine: &Machine) -> &'static str {
    unit(machine, ["N", "N·mm", "N or N·mm"])
}

fn unit(machine: &Machine, [slides, hinges, both]: [&'static str; 3]) -> &'static str {
    let all = |motion| machine.drives().all(|(_, drive)| drive.motion == motion);
    match (all(Motion::Prismatic), all(Motion::Revolute)) {
        (true, _) => slides,
        (_, true) => hinges,
        _ => both,
    }
}

/// Largest size among drive positions or corrections given in mm or rad, in [`position_unit`].
pub fn largest_position(machine: &Machine, values: &[f64]) -> f64 {
    shown_positions(machine, values).iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// Angles are given in degrees; the way through radians must not show.
pub fn tidy_degrees(degrees: f64) -> f64 {
    (degrees * 1e9).round() / 1e9
}
