//! Columns of commands: where P and its drives are commanded to be, without and with compensation.

use crate::{
    compensation::TaskPoint,
    files::{
        exchange::{Cell, Row, cells},
        table::{position_columns, shown_positions},
    },
    machine::Machine,
    simulation::along_path::PathAnswer,
    spatial::{Pose, rotation_log},
};

/// Columns of a pose of P in O: position in mm and rotation vector in degrees, whose direction is the axis and whose length
/// the angle of the turn from O to P axes.
pub fn pose_columns(what: &str) -> [String; 6] {
    let axes = ["x", "y", "z"];
    std::array::from_fn(|i| match i {
        0..3 => format!("{what}_platform_{}_mm", axes[i]),
        _ => format!("{what}_platform_rotation_{}_deg", axes[i - 3]),
    })
}

/// The cells of [`pose_columns`]; without a pose they are missing.
pub fn pose_cells(pose: Option<&Pose>) -> Row {
    let Some(pose) = pose else { return vec![Cell::Missing; 6] };
    let turn = rotation_log(&pose.rotation).map(f64::to_degrees);
    cells(pose.translation.iter().chain(&turn).copied()).collect()
}

/// Columns of drive positions: by the nominal inverse kinematics of the wanted pose, and as commanded instead; then those of the
/// workpiece carrier, where they stand.
pub fn drive_columns(machine: &Machine) -> impl Iterator<Item = String> {
    let own = ["rho_nominal", "rho_compensated"].into_iter().flat_map(|what| position_columns(machine, what));
    own.chain(machine.carrier.iter().flat_map(|carrier| position_columns(carrier, "rho_carrier")))
}

/// The cells of [`drive_columns`]; those of the command only with `with_command`.
pub fn drive_cells(machine: &Machine, task: &TaskPoint, answer: &PathAnswer, with_command: bool) -> Row {
    let count = machine.drive_count();
    let mut row: Row = cells(shown_positions(machine, &answer.nominal_drives)).collect();
    row.resize(count, Cell::Missing);
    if with_command {
        row.extend(cells(shown_positions(machine, &answer.drives)));
    }
    row.resize(2 * count, Cell::Missing);
    let there = task.external.map_or_else(|| machine.clone(), |axes| machine.carried(&axes));
    row.extend(there.carrier.iter().flat_map(|carrier| cells(shown_positions(carrier, &carrier.home.drives))));
    row
}
