//! What the person at the machine fills in: the measurements chosen, in the columns that an identification reads.

use nalgebra::Vector3;

use super::summary::Report;
use crate::{
    files::exchange::{Cell, Row, Table, cells, numbers, texts},
    machine::Machine,
    questions::identification::Measurement,
};

/// Columns that say where the drives stand, degrees and mm.
pub(super) fn drive_columns(machine: &Machine) -> Vec<String> {
    let units = machine.drives().map(|(_, drive)| drive.motion.position_unit());
    machine.drive_labels().iter().zip(units).map(|(label, unit)| format!("{label}_{unit}")).collect()
}

/// Where the drives stand, degrees and mm.
pub(super) fn drive_positions<'a>(machine: &'a Machine, own: &'a Measurement) -> impl Iterator<Item = f64> + 'a {
    // What a person types, without the rounding of its way through radians.
    let tidy = |shown: f64| (shown * 1e9).round() / 1e9 + 0.0;
    own.at.drives.iter().zip(machine.drives()).map(move |(position, (_, drive))| tidy(drive.motion.shown(*position)))
}

/// A vector of a measurement, if it has one.
type VectorOf = fn(&Measurement) -> Option<Vector3<f64>>;

/// The sheet: poses, loads, and empty cells for what is read.
pub(super) fn sheet(report: &Report<'_>) -> Table {
    let (study, machine) = (report.study, &report.study.machine);
    let chosen: Vec<&Measurement> = report.plan.chosen.iter().map(|&i| &study.candidates[i]).collect();
    let is_used = |of: &VectorOf| chosen.iter().any(|own| of(own).is_some_and(|vector| vector.norm() > 0.0));
    let vectors: [(&str, &str, VectorOf); 5] = [
        ("force", "N", |own| Some(own.load.force)),
        ("moment", "Nmm", |own| Some(own.load.moment)),
        ("reference_force", "N", |own| Some(own.reference.force)),
        ("reference_moment", "Nmm", |own| Some(own.reference.moment)),
        ("marker", "mm", |own| own.marker),
    ];
    let used: Vec<_> = vectors.into_iter().filter(|(name, _, of)| *name == "force" || is_used(of)).collect();
    let readings = chosen.first().map_or(&[][..], |own| &own.readings);
    let mut columns = [texts(["pose"]), numbers(drive_columns(machine))].concat();
    for (name, unit, _) in &used {
        columns.extend(numbers(["x", "y", "z"].map(|axis| format!("{name}_{axis}_{unit}"))));
    }
    columns.extend(numbers(readings.iter().map(|reading| reading.column)));
    let row = |(number, own): (usize, &&Measurement)| {
        let mut row: Row = vec![Cell::from((number + 1).to_string())];
        row.extend(cells(drive_positions(machine, own)));
        for (_, _, of) in &used {
            row.extend((0..3).map(|axis| Cell::from(of(own).map(|vector| vector[axis]))));
        }
        row.extend(readings.iter().map(|_| Cell::Missing));
        row
    };
    Table::new(columns, chosen.iter().enumerate().map(row).collect::<Vec<Row>>())
}
