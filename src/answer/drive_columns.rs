//! Columns of drives in tables, and largest values of prismatic and revolute joints.

use crate::machine::{Drive, Machine, Motion};

/// Returns "drives" for a machine with one kind of drives; else "prismatic joints" or "revolute joints".
pub(crate) fn kind_word(machine: &Machine, motion: Motion) -> &'static str {
    match (machine.has_mixed_drives(), motion) {
        (false, _) => "drives",
        (true, Motion::Prismatic) => "prismatic joints",
        (true, Motion::Revolute) => "revolute joints",
    }
}

/// Yields a column name of drive positions for each drive: `WHAT_LABEL_mm` or `_deg`.
pub(crate) fn position_columns<'m>(machine: &'m Machine, what: &'m str) -> impl Iterator<Item = String> + 'm {
    each_drive(machine).map(move |(label, motion)| format!("{what}_{label}_{}", motion.position_unit()))
}

/// Yields a column name of drive positions in measurement files for each drive: `LABEL_mm` or `LABEL_deg`.
pub(crate) fn measured_drive_columns(machine: &Machine) -> impl Iterator<Item = String> {
    each_drive(machine).map(|(label, motion)| format!("{label}_{}", motion.position_unit()))
}

/// Yields a column name of drive corrections for each drive: `delta_rho_LABEL_mm` or `_deg`.
pub(crate) fn correction_columns(machine: &Machine) -> impl Iterator<Item = String> {
    position_columns(machine, "delta_rho")
}

/// Yields a column name of drive forces for each drive: `drive_force_LABEL_N` or `drive_torque_LABEL_Nmm`.
pub(crate) fn force_columns(machine: &Machine) -> impl Iterator<Item = String> {
    each_drive(machine).map(|(label, motion)| format!("drive_{}_{label}_{}", motion.force_word(), motion.force_unit()))
}

/// Yields label and kind of each drive, in machine order.
fn each_drive(machine: &Machine) -> impl Iterator<Item = (String, Motion)> {
    machine.drive_labels().into_iter().zip(machine.drives().map(|(_, drive)| drive.motion))
}

/// Yields index and label of each drive of one kind.
pub(crate) fn drives_of_kind(machine: &Machine, kind: Motion) -> impl Iterator<Item = (usize, String)> {
    let drives = machine.drive_labels().into_iter().enumerate().zip(machine.drives());
    drives.filter(move |(_, (_, drive))| drive.motion == kind).map(|(label, _)| label)
}

/// Converts drive positions or corrections from mm or rad to the units of tables, mm or degrees.
pub(crate) fn shown_positions(machine: &Machine, values: &[f64]) -> Vec<f64> {
    let shown = |(value, (_, drive)): (&f64, (usize, &Drive))| drive.motion.to_shown(*value);
    values.iter().zip(machine.drives()).map(shown).collect()
}

/// Returns the largest absolute position or correction of the drives of one kind, from mm or rad to mm or degrees.
pub(crate) fn largest_position(machine: &Machine, motion: Motion, values: &[f64]) -> f64 {
    let of_kind = values.iter().zip(machine.drives()).filter(|(_, (_, drive))| drive.motion == motion);
    motion.to_shown(of_kind.fold(0.0, |most, (value, _)| most.max(value.abs())))
}
