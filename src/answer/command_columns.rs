//! Table columns of commands: pose of P and drive positions, without and with compensation.

use crate::{
    answer::drive_columns::{position_columns, shown_positions},
    compensation::TaskPoint,
    files::exchange::{Cell, Row, cells},
    machine::Machine,
    simulation::along_path::PathPointResult,
    spatial::{Pose, rotation_log},
};

/// Returns the columns of a pose of P in O, called `what`: position in mm, and rotation vector in degrees.
pub fn pose_columns(what: &str) -> [String; 6] {
    let axes = ["x", "y", "z"];
    std::array::from_fn(|i| match i {
        0..3 => format!("{what}_platform_{}_mm", axes[i]),
        _ => format!("{what}_platform_rotation_{}_deg", axes[i - 3]),
    })
}

/// Returns the cells of [`pose_columns`]; empty without a pose.
pub fn pose_cells(pose: Option<&Pose>) -> Row {
    let Some(pose) = pose else { return vec![Cell::Missing; 6] };
    let turn = rotation_log(&pose.rotation).map(f64::to_degrees);
    cells(pose.translation.iter().chain(&turn).copied()).collect()
}

/// Returns the columns of drive positions: of the target pose by nominal inverse kinematics, as compensated, and of the workpiece carrier.
pub fn drive_columns(machine: &Machine) -> impl Iterator<Item = String> {
    let positions = ["rho_nominal", "rho_compensated"].into_iter().flat_map(|what| position_columns(machine, what));
    positions.chain(machine.carrier.iter().flat_map(|carrier| position_columns(carrier, "rho_carrier")))
}

/// Returns the cells of [`drive_columns`] at a task point (mm, degrees); those of the command are empty without `with_command`.
pub fn drive_cells(machine: &Machine, task: &TaskPoint, result: &PathPointResult, with_command: bool) -> Row {
    let count = machine.drive_count();
    let mut row: Row = cells(shown_positions(machine, &result.nominal_drives)).collect();
    row.resize(count, Cell::Missing);
    if with_command {
        row.extend(cells(shown_positions(machine, &result.drives)));
    }
    row.resize(2 * count, Cell::Missing);
    let at_axes = task.external.map_or_else(|| machine.clone(), |axes| machine.with_carrier_axes(&axes));
    row.extend(at_axes.carrier.iter().flat_map(|carrier| cells(shown_positions(carrier, &carrier.home.drives))));
    row
}
