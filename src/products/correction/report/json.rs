//! The table as one JSON file that says itself what it holds.

use serde_json::{Value, json};

use super::{
    Report,
    tables::{coefficient_columns, motions},
};
use crate::{input::Inputs, products::correction::Worst};

/// Version of the file.
const SCHEMA: u32 = 1;

/// Axes, units, values, what they were made from and what they leave.
pub(super) fn correction(report: &Report<'_>, inputs: &Inputs) -> Value {
    let (question, table) = (report.question, &report.answer.table);
    let (machine, terms) = (&question.machine, table.terms.names());
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
        table.values.iter().enumerate().map(|(k, v)| motions[k / terms.len() % motions.len()].shown(*v)).collect();
    let axes = ["x", "y", "z"].into_iter().zip(&table.grid.axes);
    json!({
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
        "order": "node after node, x fastest, then y, then z; in each drive after drive; in each term after term",
        "columns": coefficient_columns(machine, table.terms),
        "values": values,
        "bound": bound(report),
    })
}

/// What is left, for programs.
pub(super) fn bound(report: &Report<'_>) -> Value {
    let answer = report.answer;
    let worst = |worst: &Worst| {
        json!({
            "error_mm": worst.error_mm,
            "position_mm": worst.position_mm,
            "force_N": worst.force_N,
            "looked_at": worst.looked_at,
        })
    };
    json!({
        "tolerance_mm": report.question.tolerance_mm,
        "is_kept": report.is_kept(),
        "worst_with_table": worst(&answer.with_table),
        "worst_at_nodes_mm": answer.at_nodes_mm,
        "worst_without": worst(&answer.without),
        "worst_per_joint": answer.per_joint.as_ref().ok().map(|(_, found)| worst(found)),
    })
}
