//! Columns and quantities of drives in tables, figures and pages, and largest values of prismatic and revolute joints.

use crate::{
    machine::{Drive, Machine, Motion},
    page::{Better, Quantity},
};

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

/// Yields those of `columns`, of which there is one for each drive in order, whose drive is of the kind `motion`.
pub(crate) fn columns_of_kind<'m>(
    machine: &'m Machine,
    motion: Motion,
    columns: impl Iterator<Item = String> + 'm,
) -> impl Iterator<Item = String> + 'm {
    columns.zip(machine.drives()).filter(move |(_, (_, drive))| drive.motion == motion).map(|(column, _)| column)
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

/// Returns the quantities "largest correction" and "largest force" over the drives, apart for prismatic and revolute joints if there are both.
pub(crate) fn largest_drive_quantities(machine: &Machine) -> Vec<Quantity> {
    let name = |kind, what: &str| match machine.has_mixed_drives() {
        false => format!("largest drive {what}"),
        true => format!("largest {what} of {}", kind_word(machine, kind)),
    };
    let corrections = machine.drive_kinds().map(|kind| {
        let columns = columns_of_kind(machine, kind, correction_columns(machine));
        let text = format!("{} |Δρ|", name(kind, "correction"));
        Quantity::new(columns, &text, kind.shown_position_unit(), Better::Smaller)
    });
    let forces = machine.drive_kinds().map(|kind| {
        let columns = columns_of_kind(machine, kind, force_columns(machine));
        let text = format!("{} |τ|", name(kind, kind.force_word()));
        Quantity::new(columns, &text, kind.shown_force_unit(), Better::Smaller)
    });
    corrections.chain(forces).collect()
}

/// Returns the quantities correction and force of each drive, with `better` as their direction.
pub(crate) fn drive_quantities(machine: &Machine, better: Better) -> Vec<Quantity> {
    let labels = machine.drive_labels();
    let drives: Vec<(&String, &Drive)> = labels.iter().zip(machine.drives().map(|(_, drive)| drive)).collect();
    let corrections = correction_columns(machine).zip(&drives).map(|(column, (label, drive))| {
        Quantity::new([column], &format!("correction of drive {label}"), drive.motion.shown_position_unit(), better)
    });
    let forces = force_columns(machine).zip(&drives).map(|(column, (label, drive))| {
        let text = format!("{} of drive {label}", drive.motion.force_word());
        Quantity::new([column], &text, drive.motion.shown_force_unit(), better)
    });
    corrections.chain(forces).collect()
}
