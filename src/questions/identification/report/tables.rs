//! The tables of an identification.

use super::summary::Report;
use crate::{
    files::exchange::{Cell, Column, Row, Table, cells, counts, numbers, texts},
    simulation::SOLVED,
};

fn finite(value: f64) -> Cell {
    value.is_finite().then_some(value).into()
}

/// All tables without rows, where there is no answer.
pub(super) fn none() -> Vec<(String, Table)> {
    let all = [
        ("parameters", parameter_columns()),
        ("residuals", residual_columns()),
        ("models", model_columns()),
        ("open", open_columns()),
    ];
    all.into_iter().map(|(name, columns)| (name.into(), Table::new(columns, Vec::new()))).collect()
}

/// All tables by name.
pub(super) fn tables(report: &Report<'_>) -> Vec<(String, Table)> {
    vec![
        ("parameters".into(), parameters(report)),
        ("residuals".into(), residuals(report)),
        ("models".into(), models(report)),
        ("open".into(), open(report)),
        ("patterns".into(), patterns(report)),
        ("correlations".into(), correlations(report)),
    ]
}

fn parameter_columns() -> Vec<Column> {
    let mut columns = texts(["parameter", "unit", "status", "reason"]);
    columns.extend(numbers(["start", "value", "low_95", "high_95", "profile_low_95", "profile_high_95", "half_width"]));
    columns.extend(texts(["most_correlated_with"]));
    columns.extend(numbers(["correlation"]));
    columns
}

fn parameters(report: &Report<'_>) -> Table {
    let rows = report.found.found.iter().map(|own| {
        let status = if own.open.is_none() { "identified" } else { "not_identified" };
        let reason = own.open.as_deref().map_or(Cell::Missing, Cell::from);
        let mut row: Row =
            vec![own.unknown.name.as_str().into(), own.unknown.unit.in_files().into(), status.into(), reason];
        row.extend([own.unknown.start.into(), own.value.into()]);
        row.extend(own.interval.map(finite));
        row.extend(own.profile.map_or([Cell::Missing, Cell::Missing], |ends| ends.map(finite)));
        row.push(finite(own.half_width));
        match own.correlated {
            Some((other, correlation)) => {
                row.extend([report.study.unknowns[other].name.as_str().into(), Cell::from(correlation)]);
            }
            None => row.extend([Cell::Missing, Cell::Missing]),
        }
        row
    });
    Table::new(parameter_columns(), rows.collect::<Vec<Row>>())
}

fn residual_columns() -> Vec<Column> {
    let mut columns = counts(["order"]);
    columns.extend(texts(["pose", "reading"]));
    columns.extend(numbers(["x_mm", "y_mm", "z_mm", "force_x_N", "force_y_N", "force_z_N"]));
    columns.extend(numbers(["measured", "predicted", "residual", "left_out_residual", "std", "weight"]));
    columns
}

/// One row per reading; mm, of rotations degrees.
fn residuals(report: &Report<'_>) -> Table {
    let fit = &report.found.fit;
    let mut rows: Vec<Row> = Vec::new();
    for (order, own) in report.study.measurements.iter().enumerate() {
        for reading in &own.readings {
            let i = rows.len();
            let shown = |value: f64| if reading.quantity.is_rotation() { value.to_degrees() } else { value };
            let mut row: Row = vec![(order + 1).into(), own.name.as_str().into(), reading.column.into()];
            row.extend(cells(own.at.pose.translation.iter().copied()));
            row.extend(cells(own.load.force.iter().copied()));
            let values = [
                reading.value,
                fit.predicted.values[i],
                fit.residuals[i],
                report.found.left_out.residuals[i],
                fit.stds[i],
            ];
            row.extend(values.map(|value| finite(shown(value))));
            row.push(fit.weights[i].into());
            rows.push(row);
        }
    }
    Table::new(residual_columns(), rows)
}

fn model_columns() -> Vec<Column> {
    let mut columns = texts(["unknowns_of"]);
    columns.extend(counts(["unknowns"]));
    columns.extend(texts(["status", "reason"]));
    columns.extend(numbers(["fitted_rms_mm", "predicted_rms_mm"]));
    columns
}

fn models(report: &Report<'_>) -> Table {
    let rows = report.found.models.iter().map(|model| {
        let mut row: Row = vec![model.name.as_str().into(), model.unknowns.into()];
        match &model.predicted_mm {
            Ok(predicted) => row.extend([SOLVED.into(), Cell::Missing, model.fitted_mm.into(), (*predicted).into()]),
            Err(failure) => {
                row.extend([
                    Cell::from(&*failure.status),
                    failure.reason.as_str().into(),
                    model.fitted_mm.into(),
                    Cell::Missing,
                ]);
            }
        }
        row
    });
    Table::new(model_columns(), rows.collect::<Vec<Row>>())
}

/// One row per rank correlation of residuals.
fn patterns(report: &Report<'_>) -> Table {
    let columns = [texts(["of", "with", "seen", "hint"]), numbers(["rank_correlation", "limit"])].concat();
    let rows = report.found.patterns.iter().map(|own| -> Row {
        let (seen, hint) = if own.is_seen() { ("yes", own.hint.into()) } else { ("no", Cell::Missing) };
        vec![own.of.into(), own.with.as_str().into(), seen.into(), hint, own.correlation.into(), own.limit.into()]
    });
    Table::new(columns, rows.collect::<Vec<Row>>())
}

fn open_columns() -> Vec<Column> {
    let mut columns = counts(["combination"]);
    columns.extend(texts(["parameter"]));
    columns.extend(numbers(["part", "std"]));
    columns
}

/// One row per combination that is open and parameter in it.
fn open(report: &Report<'_>) -> Table {
    let rows = report.found.open.iter().enumerate().flat_map(|(number, open)| {
        open.parts.iter().map(move |(k, part)| -> Row {
            let name = report.study.unknowns[*k].name.as_str();
            vec![(number + 1).into(), name.into(), (*part).into(), finite(open.std)]
        })
    });
    Table::new(open_columns(), rows.collect::<Vec<Row>>())
}

/// One row per pair of unknowns.
fn correlations(report: &Report<'_>) -> Table {
    let unknowns = &report.study.unknowns;
    let pairs = (0..unknowns.len()).flat_map(|a| (a + 1..unknowns.len()).map(move |b| (a, b)));
    let rows = pairs.map(|(a, b)| -> Row {
        let correlation = report.found.fit.correlation(a, b);
        vec![unknowns[a].name.as_str().into(), unknowns[b].name.as_str().into(), correlation.into()]
    });
    let columns = [texts(["parameter", "other"]), numbers(["correlation"])].concat();
    Table::new(columns, rows.collect::<Vec<Row>>())
}
