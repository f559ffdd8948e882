//! The map as a table.

use crate::{
    files::{
        exchange::{Cell, Column, Row, Table, cells, numbers, texts},
        table::{correction_columns, force_columns, shown_positions, tidy_degrees},
    },
    machine::Machine,
    questions::map::{MapPoint, SourceEffect},
    simulation::{Failure, SOLVED},
};

/// One row per point and source; `status` and `reason` say why numbers are missing, `correction_status` and
/// `correction_reason` why those of the drive corrections are.
pub fn table(machine: &Machine, points: &[MapPoint]) -> Table {
    let columns = columns(machine);
    let width = columns.len();
    let rows = points.iter().flat_map(|point| {
        point.effects.iter().map(|(source, effect)| {
            let mut row: Row = cells(point.position_mm).collect();
            row.push(source.label().into());
            match effect {
                Ok(effect) => solved_cells(machine, effect, &mut row),
                Err(failure) => failed_cells(failure, width, &mut row),
            }
            row
        })
    });
    let rows: Vec<Row> = rows.collect();
    Table::new(columns, rows)
}

/// Drive columns carry the drive's label and unit.
fn columns(machine: &Machine) -> Vec<Column> {
    let quantities = [
        "deflection_mm",
        "deflection_x_mm",
        "deflection_y_mm",
        "deflection_z_mm",
        "deflection_phi_deg",
        "stiffness_min_N_per_mm",
        "stiffness_mid_N_per_mm",
        "stiffness_max_N_per_mm",
        "departure_mm",
        "departure_x_mm",
        "departure_y_mm",
        "departure_z_mm",
        "departure_over_deflection",
    ];
    let mut columns = numbers(["x_mm", "y_mm", "z_mm"]);
    columns.extend(texts(["source", "status", "reason", "correction_status", "correction_reason"]));
    columns.extend(numbers(quantities));
    columns.extend(numbers(correction_columns(machine).chain(force_columns(machine))));
    if leaves_something(machine) {
        columns.extend(numbers(["error_left_mm"]));
    }
    columns
}

fn solved_cells(machine: &Machine, effect: &SourceEffect, row: &mut Row) {
    row.extend([SOLVED.into(), Cell::Missing]);
    row.extend(match &effect.delta_rho {
        Ok(_) => [SOLVED.into(), Cell::Missing],
        Err(failure) => words(failure),
    });
    row.push(effect.deflection_mm.into());
    row.extend(cells(effect.deflection_vector_mm));
    row.push(effect.phi_deg.map(tidy_degrees).into());
    row.extend(cells(effect.principal_stiffness_n_per_mm));
    row.push(effect.departure_mm().into());
    row.extend((0..3).map(|i| effect.departure_vector_mm.map(|v| v[i]).into()));
    row.push(effect.departure_mm().filter(|_| effect.deflection_mm > 0.0).map(|d| d / effect.deflection_mm).into());
    match &effect.delta_rho {
        Ok(delta_rho) => row.extend(cells(shown_positions(machine, delta_rho))),
        Err(_) => row.resize(row.len() + machine.drive_count(), Cell::Missing),
    }
    row.extend(cells(effect.drive_force.iter().copied()));
    if leaves_something(machine) {
        row.push(effect.delta_rho.as_ref().ok().map(|_| effect.left_mm).into());
    }
}

/// Whether the drives cannot put all of the error right.
fn leaves_something(machine: &Machine) -> bool {
    machine.uncontrolled_axes().next().is_some()
}

fn failed_cells(failure: &Failure, width: usize, row: &mut Row) {
    // What has no equilibrium to start from is not corrected either.
    row.extend([words(failure), words(failure)].into_iter().flatten());
    row.resize(width, Cell::Missing);
}

fn words(failure: &Failure) -> [Cell; 2] {
    [(&*failure.status).into(), failure.reason.as_str().into()]
}
