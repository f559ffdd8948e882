//! The correction and what it leaves as tables.

use super::Report;
use crate::{
    files::exchange::{Row, Table, cells, numbers, texts},
    machine::{Machine, Motion},
    products::correction::{CorrectionTable, ForceTerms, ResidualPoint},
};

/// One row per node, a column for each drive and term: `delta_rho_LABEL_mm`, `delta_rho_LABEL_Fx_mm_per_N`,
/// `delta_rho_LABEL_Fx_Fx_mm_per_N2`; degrees for hinges.
pub(super) fn correction(machine: &Machine, table: &CorrectionTable) -> Table {
    let mut columns = numbers(["x_mm", "y_mm", "z_mm"]);
    columns.extend(numbers(coefficient_columns(machine, table.terms)));
    let width = table.drives * table.terms.count();
    let motions: Vec<Motion> = motions(machine);
    let row = |(index, own): (usize, &[f64])| -> Row {
        let mut row: Row = cells(<[f64; 3]>::from(table.grid.position(index))).collect();
        row.extend(cells(own.iter().enumerate().map(|(k, value)| motions[k / table.terms.count()].shown(*value))));
        row
    };
    Table::new(columns, table.values.chunks(width).enumerate().map(row))
}

/// Names of the coefficients of a node, drive after drive.
pub(super) fn coefficient_columns(machine: &Machine, terms: ForceTerms) -> Vec<String> {
    let labelled = machine.drive_labels().into_iter().zip(motions(machine));
    let of_drive = |(label, motion): (String, Motion)| {
        let unit = motion.position_unit();
        terms.names().iter().map(move |(term, power)| match power {
            0 => format!("delta_rho_{label}_{unit}"),
            1 => format!("delta_rho_{label}_{term}_{unit}_per_N"),
            _ => format!("delta_rho_{label}_{term}_{unit}_per_N2"),
        })
    };
    labelled.flat_map(|own| of_drive(own).collect::<Vec<_>>()).collect()
}

/// The kind of each drive.
pub(super) fn motions(machine: &Machine) -> Vec<Motion> {
    machine.drives().map(|(_, drive)| drive.motion).collect()
}

/// One row per point of the map and way to correct.
pub(super) fn residuals(report: &Report<'_>) -> Table {
    let mut columns = numbers(["x_mm", "y_mm", "z_mm"]);
    columns.extend(texts(["correction"]));
    columns.extend(numbers(["error_mm"]));
    let rows = report.residuals.iter().flat_map(|point| {
        point.left_mm.iter().zip(ResidualPoint::WAYS).map(|(left, way)| {
            let mut row: Row = cells(point.position_mm).collect();
            row.extend([way.into(), (*left).into()]);
            row
        })
    });
    let rows: Vec<Row> = rows.collect();
    Table::new(columns, rows)
}
