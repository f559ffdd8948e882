//! The tables of a plan.

use super::{
    sheet::{drive_columns, drive_positions, sheet},
    summary::Report,
};
use crate::{
    files::exchange::{Cell, Column, Row, Table, cells, counts, numbers, texts},
    questions::{identification::report::ANYTHING, measurement_design::MeasurementDesignStudy},
    simulation::SOLVED,
};

/// All tables without rows, where there is no answer.
pub(super) fn none(study: &MeasurementDesignStudy) -> Vec<(String, Table)> {
    let all =
        [("chosen", chosen_columns(study)), ("widths", width_columns()), ("candidates", candidate_columns(study))];
    all.into_iter().map(|(name, columns)| (name.into(), Table::new(columns, Vec::new()))).collect()
}

/// All tables by name.
pub(super) fn tables(report: &Report<'_>) -> Vec<(String, Table)> {
    vec![
        ("chosen".into(), chosen(report)),
        ("sheet".into(), sheet(report)),
        ("widths".into(), widths(report)),
        ("candidates".into(), candidates(report)),
    ]
}

fn place_columns(study: &MeasurementDesignStudy) -> Vec<Column> {
    let drives = numbers(drive_columns(&study.machine));
    let rest = numbers(["tool_x_mm", "tool_y_mm", "tool_z_mm", "force_x_N", "force_y_N", "force_z_N"]);
    [drives, rest].concat()
}

fn place(study: &MeasurementDesignStudy, candidate: usize) -> Row {
    let own = &study.candidates[candidate];
    let tip = own.at.pose.transform(study.machine.tool_tip);
    let drives = drive_positions(&study.machine, own);
    cells(drives.chain(tip.iter().copied()).chain(own.load.force.iter().copied())).collect()
}

fn chosen_columns(study: &MeasurementDesignStudy) -> Vec<Column> {
    let mut columns = counts(["order", "candidate"]);
    columns.extend(place_columns(study));
    columns.extend(numbers(["widest_half_width"]));
    columns.extend(texts(["widest_parameter"]));
    columns
}

/// One row per measurement, that which tells most first, with what is known when it is made.
fn chosen(report: &Report<'_>) -> Table {
    let row = |(k, &candidate): (usize, &usize)| {
        let mut row: Row = vec![(k + 1).into(), (candidate + 1).into()];
        row.extend(place(report.study, candidate));
        match report.plan.widths.get(k + 1).and_then(|own| own.widest()) {
            Some((unknown, width)) => row.extend([wide(width), report.name(unknown).into()]),
            None => row.extend([Cell::Missing, Cell::Missing]),
        }
        row
    };
    Table::new(chosen_columns(report.study), report.plan.chosen.iter().enumerate().map(row).collect::<Vec<Row>>())
}

/// No number where it may be anything.
fn wide(width: f64) -> Cell {
    (width <= ANYTHING).then_some(width).into()
}

fn width_columns() -> Vec<Column> {
    let mut columns = counts(["measurements"]);
    columns.extend(texts(["parameter", "in"]));
    columns.extend(numbers(["half_width", "random_half_width"]));
    columns
}

/// One row per number of measurements and unknown; mean errors of the tool for tested rows at the end of each.
fn widths(report: &Report<'_>) -> Table {
    let mut rows: Vec<Row> = Vec::new();
    for (count, own) in report.plan.widths.iter().enumerate() {
        let random = report.plan.random.get(count);
        for (k, width) in own.each.iter().enumerate() {
            let unknown = &report.study.unknowns[k];
            let other = random.map(|random| random.each[k]);
            rows.push(vec![
                count.into(),
                unknown.name.as_str().into(),
                unknown.coordinate_unit().into(),
                wide(*width),
                other.map_or(Cell::Missing, wide),
            ]);
        }
        if let Some(error) = own.tested_mm {
            let other = random.and_then(|random| random.tested_mm);
            rows.push(vec![count.into(), "tool_at_tested_rows_rms".into(), "mm".into(), error.into(), other.into()]);
        }
    }
    Table::new(width_columns(), rows)
}

fn candidate_columns(study: &MeasurementDesignStudy) -> Vec<Column> {
    let mut columns = counts(["candidate"]);
    columns.extend(texts(["pose", "status", "reason"]));
    columns.extend(counts(["order"]));
    columns.extend(place_columns(study));
    columns
}

/// One row per candidate; `order` where it was chosen.
fn candidates(report: &Report<'_>) -> Table {
    let (study, plan) = (report.study, report.plan);
    let mut failures = plan.failures.iter().peekable();
    let row = |i: usize| {
        let failure = failures.next_if(|(at, _)| *at == i).map(|(_, failure)| failure);
        let (status, reason) = failure.map_or((SOLVED, ""), |failure| (&*failure.status, failure.reason.as_str()));
        let order = plan.chosen.iter().position(|&own| own == i).map(|k| k + 1);
        let mut row: Row = vec![(i + 1).into(), study.candidates[i].name.as_str().into(), status.into(), reason.into()];
        row.push(order.into());
        row.extend(place(study, i));
        row
    };
    Table::new(candidate_columns(study), (0..study.candidates.len()).map(row).collect::<Vec<Row>>())
}
