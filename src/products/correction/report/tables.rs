//! Tables, JSON and LinuxCNC files of a correction table.

use serde_json::{Value, json};

use super::Report;
use crate::{
    files::{
        OutputFile,
        exchange::{Row, Table, cells, numbers, texts},
    },
    input::Inputs,
    machine::{Machine, Motion},
    products::{
        correction::{CorrectionTable, ForceTerms, JointTable, ResidualPoint},
        field::FieldSpread,
    },
};

/// Returns the table with a row per node and a column for each drive and term: `delta_rho_LABEL_mm`, `delta_rho_LABEL_Fx_mm_per_N`,
/// `delta_rho_LABEL_Fx_Fx_mm_per_N2`; degrees for revolute joints.
pub(super) fn correction(machine: &Machine, table: &CorrectionTable) -> Table {
    let mut columns = numbers(["x_mm", "y_mm", "z_mm"]);
    columns.extend(numbers(coefficient_columns(machine, table.terms)));
    let width = table.drives * table.terms.count();
    let motions: Vec<Motion> = motions(machine);
    let row = |(index, node): (usize, &[f64])| -> Row {
        let mut row: Row = cells(<[f64; 3]>::from(table.grid.position(index))).collect();
        row.extend(cells(node.iter().enumerate().map(|(k, value)| motions[k / table.terms.count()].to_shown(*value))));
        row
    };
    Table::new(columns, table.values.chunks(width).enumerate().map(row))
}

/// Returns the column names of the coefficients of a node, drive after drive.
pub(super) fn coefficient_columns(machine: &Machine, terms: ForceTerms) -> Vec<String> {
    let labelled = machine.drive_labels().into_iter().zip(motions(machine));
    let of_drive = |(label, motion): (String, Motion)| {
        let unit = motion.position_unit();
        terms.names_and_powers().iter().map(move |(term, power)| match power {
            0 => format!("delta_rho_{label}_{unit}"),
            1 => format!("delta_rho_{label}_{term}_{unit}_per_N"),
            _ => format!("delta_rho_{label}_{term}_{unit}_per_N2"),
        })
    };
    labelled.flat_map(|labelled_motion| of_drive(labelled_motion).collect::<Vec<_>>()).collect()
}

/// Returns whether each drive is prismatic or revolute, in the order of [`Machine::drives`].
pub(super) fn motions(machine: &Machine) -> Vec<Motion> {
    machine.drives().map(|(_, drive)| drive.motion).collect()
}

/// Returns the residual errors with a row per grid point and correction method.
pub(super) fn residuals(report: &Report<'_>) -> Table {
    let mut columns = numbers(["x_mm", "y_mm", "z_mm"]);
    columns.extend(texts(["correction"]));
    columns.extend(numbers(["error_mm"]));
    let rows = report.residuals.iter().flat_map(|point| {
        point.residual_mm.iter().zip(ResidualPoint::CORRECTION_METHODS).map(|(error, [method, ..])| {
            let mut row: Row = cells(point.position_mm).collect();
            row.extend([method.into(), (*error).into()]);
            row
        })
    });
    let rows: Vec<Row> = rows.collect();
    Table::new(columns, rows)
}

/// Returns the distributions of the error where inputs are uncertain, with a row per check position and correction method.
pub(super) fn field(spread: &FieldSpread) -> Table {
    let mut columns = numbers(["x_mm", "y_mm", "z_mm"]);
    columns.extend(texts(["correction"]));
    columns.extend(numbers(["error_p95_mm", "error_median_mm", "within_tolerance_probability"]));
    let methods = ["none", "table", "per_joint"];
    let rows = spread.points.iter().flat_map(|point| {
        point.ways.iter().zip(methods).map(|(own, method)| {
            let mut row: Row = cells(point.position_mm).collect();
            row.extend([method.into(), own.p95_mm.into(), own.median_mm.into(), own.within_tolerance.into()]);
            row
        })
    });
    Table::new(columns, rows.collect::<Vec<Row>>())
}

/// Version of the JSON file.
const SCHEMA: u32 = 2;

/// Returns the table as JSON: axes, units, values, inputs and residual errors.
pub(super) fn correction_json(report: &Report<'_>, inputs: &Inputs) -> Value {
    let (question, table) = (report.question, &report.answer.table);
    let (machine, terms) = (&question.machine, table.terms.names_and_powers());
    let motions = motions(machine);
    let drives = machine.drive_labels().into_iter().zip(&motions).map(|(label, motion)| {
        let unit = motion.position_unit();
        let units = terms.iter().map(|(_, power)| match power {
            0 => unit.to_string(),
            1 => format!("{unit}/N"),
            _ => format!("{unit}/N^2"),
        });
        json!({ "label": label, "unit": unit, "units_of_terms": units.collect::<Vec<_>>() })
    });
    let values: Vec<f64> =
        table.values.iter().enumerate().map(|(k, v)| motions[k / terms.len() % motions.len()].to_shown(*v)).collect();
    let axes = ["x", "y", "z"].into_iter().zip(&table.grid.axes);
    let mut all = json!({
        "schema": SCHEMA,
        "program": env!("CARGO_PKG_NAME"),
        "version": env!("CARGO_PKG_VERSION"),
        "machine": machine.name,
        "inputs": inputs.texts().map(|(name, _)| name).collect::<Vec<_>>(),
        "inputs_sha256": inputs.sha256(),
        "meaning": "delta_rho of a drive = sum over terms of coefficient(position of P) * term(force); coefficients are linear along \
                    each axis between nodes. P and the force on the tool tip are in the axes of the base; delta_rho is added to the \
                    drive position of the rigid machine.",
        "axes": axes.map(|(name, nodes)| json!({ "name": name, "unit": "mm", "nodes": nodes })).collect::<Vec<_>>(),
        "largest_force_N": question.largest_force_N,
        "terms": terms.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
        "drives": drives.collect::<Vec<_>>(),
        "order": "nodes one after another, x fastest, then y, then z; of a node its drives one after another; of a drive its terms",
        "columns": coefficient_columns(machine, table.terms),
        "values": values,
        "bound": bound_json(report),
    });
    if let Some(field) = report.field() {
        all["uncertainty"] = field.json();
    }
    all
}

/// Returns tolerance and largest errors as JSON.
pub(super) fn bound_json(report: &Report<'_>) -> Value {
    let answer = report.answer;
    json!({
        "tolerance_mm": report.question.tolerance_mm,
        "is_within_tolerance": report.is_within(),
        "worst_with_table": answer.with_table,
        "worst_at_nodes_mm": answer.at_nodes_mm,
        "worst_without": answer.without,
        "worst_per_joint": answer.per_joint.as_ref().ok().map(|(_, worst)| worst),
    })
}

/// Returns the file name of a drive's table.
fn comp_name(table: &JointTable) -> String {
    format!("joint_{}.comp", table.drive)
}

/// Returns the table of a drive, mm, as LinuxCNC reads it: a `COMP_FILE` of type 1.
///
/// A line each of nominal position and the trims for both directions, ascending, at most 256, and nothing else: LinuxCNC stops at the first
/// line that is none. It adds the trim to the position of the motor, linearly between lines and constant beyond them (LinuxCNC,
/// src/emc/motion: usrmotintf.cc, command.c, control.c; `COMP_FILE_TYPE` in its "INI Configuration").
pub(super) fn comp_file(table: &JointTable) -> OutputFile {
    let line = |(position, correction): (&f64, &f64)| format!("{position:.6} {correction:.6} {correction:.6}\n");
    let lines: String = table.positions_mm.iter().zip(&table.corrections_mm).map(line).collect();
    OutputFile::new(comp_name(table), lines)
}

/// Returns the lines of LinuxCNC's INI file for these drives, in their order.
pub(super) fn comp_ini(tables: &[JointTable]) -> String {
    let joint = |(index, table): (usize, &JointTable)| {
        format!("[JOINT_{index}]\nCOMP_FILE = {}\nCOMP_FILE_TYPE = 1\n", comp_name(table))
    };
    tables.iter().enumerate().map(joint).collect::<Vec<_>>().join("\n")
}
