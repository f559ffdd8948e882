//! Columns and largest values of drives in tables, figures and pages, slides and hinges apart.

use crate::machine::{Drive, Machine, Motion};

/// `drives` of a machine with one kind of drives; "slides" or "hinges" where it has both.
pub(crate) fn kind_word(machine: &Machine, motion: Motion) -> &'static str {
    match (machine.has_mixed_drives(), motion) {
        (false, _) => "drives",
        (true, Motion::Prismatic) => "slides",
        (true, Motion::Revolute) => "hinges",
    }
}

/// A column of drive positions per drive: `WHAT_LABEL_mm` or `_deg`.
pub(crate) fn position_columns<'m>(machine: &'m Machine, what: &'m str) -> impl Iterator<Item = String> + 'm {
    labelled(machine).map(move |(label, motion)| format!("{what}_{label}_{}", motion.position_unit()))
}

/// A column of drive corrections per drive: `delta_rho_LABEL_mm` or `_deg`.
pub(crate) fn correction_columns(machine: &Machine) -> impl Iterator<Item = String> {
    position_columns(machine, "delta_rho")
}

/// A column of drive forces per drive: `drive_force_LABEL_N` or `drive_torque_LABEL_Nmm`.
pub(crate) fn force_columns(machine: &Machine) -> impl Iterator<Item = String> {
    labelled(machine).map(|(label, motion)| format!("drive_{}_{label}_{}", motion.force_word(), motion.force_unit()))
}

/// Those of `columns`, one per drive, that belong to drives of one kind.
pub(crate) fn columns_of<'m>(
    machine: &'m Machine,
    motion: Motion,
    columns: impl Iterator<Item = String> + 'm,
) -> impl Iterator<Item = String> + 'm {
    columns.zip(machine.drives()).filter(move |(_, (_, drive))| drive.motion == motion).map(|(column, _)| column)
}

fn labelled(machine: &Machine) -> impl Iterator<Item = (String, Motion)> {
    machine.drive_labels().into_iter().zip(machine.drives().map(|(_, drive)| drive.motion))
}

/// Index and label of the drives of one kind.
pub(crate) fn drives_of(machine: &Machine, kind: Motion) -> impl Iterator<Item = (usize, String)> {
    let labelled = machine.drive_labels().into_iter().enumerate().zip(machine.drives());
    labelled.filter(move |(_, (_, drive))| drive.motion == kind).map(|(labelled, _)| labelled)
}

/// Drive positions or corrections in the units of tables, mm or degrees, from mm or rad.
pub(crate) fn shown_positions(machine: &Machine, values: &[f64]) -> Vec<f64> {
    let shown = |(value, (_, drive)): (&f64, (usize, &Drive))| drive.motion.shown(*value);
    values.iter().zip(machine.drives()).map(shown).collect()
}

/// Largest size among positions or corrections, given in mm or rad, of the drives of one kind, mm or degrees.
pub(crate) fn largest_position(machine: &Machine, motion: Motion, values: &[f64]) -> f64 {
    let own = values.iter().zip(machine.drives()).filter(|(_, (_, drive))| drive.motion == motion);
    motion.shown(own.fold(0.0, |most, (value, _)| most.max(value.abs())))
}

/// Angles are given in degrees; the way through radians must not show.
pub(crate) fn tidy_degrees(degrees: f64) -> f64 {
    (degrees * 1e9).round() / 1e9
}
