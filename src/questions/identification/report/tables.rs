//! The tables of an identification.

use super::summary::Report;
use crate::{
    answer::status_cells,
    files::exchange::{Cell, Row, Table, cells, counts, numbers, texts},
    questions::identification::measurements::FORCE,
};

fn finite(value: f64) -> Cell {
    value.is_finite().then_some(value).into()
}

/// All tables by name; those that there are without an answer, without rows, where there is none.
pub(super) fn tables(report: Option<&Report<'_>>) -> Vec<(String, Table)> {
    let always = [
        ("parameters", parameters(report)),
        ("residuals", residuals(report)),
        ("models", models(report)),
        ("open", open(report)),
    ];
    let answered = report.map(|report| [("patterns", patterns(report)), ("correlations", correlations(report))]);
    always.into_iter().chain(answered.into_iter().flatten()).map(|(name, table)| (name.into(), table)).collect()
}

fn parameters(report: Option<&Report<'_>>) -> Table {
    let columns = [
        texts(["parameter", "unit", "status", "reason"]),
        numbers(["start", "value", "low_95", "high_95", "profile_low_95", "profile_high_95", "half_width"]),
        texts(["most_correlated_with"]),
        numbers(["correlation"]),
    ];
    let rows = report.into_iter().flat_map(|report| &report.found.found).map(|own| {
        let status = if own.open.is_none() { "identified" } else { "not_identified" };
        let mut row: Row = vec![own.unknown.name.as_str().into(), own.unknown.unit.in_files().into(), status.into()];
        row.extend([own.open.as_deref().into(), own.unknown.start.into(), own.value.into()]);
        row.extend(own.interval.map(finite));
        row.extend(own.profile.map_or([Cell::Missing, Cell::Missing], |ends| ends.map(finite)));
        row.push(finite(own.half_width));
        let other = own.correlated.zip(report);
        row.push(other.map(|((other, _), report)| report.study.unknowns[other].name.as_str()).into());
        row.push(own.correlated.map(|(_, correlation)| correlation).into());
        row
    });
    Table::new(columns.concat(), rows)
}

/// One row per reading; mm, of rotations degrees.
fn residuals(report: Option<&Report<'_>>) -> Table {
    let columns = [
        counts(["order"]),
        texts(["pose", "reading"]),
        numbers(["x_mm", "y_mm", "z_mm"].into_iter().chain(FORCE)),
        numbers(["measured", "predicted", "residual", "left_out_residual", "std", "weight"]),
    ];
    let readings = report.into_iter().flat_map(|report| {
        let measurements = report.study.measurements.iter().enumerate();
        measurements
            .flat_map(|(order, own)| own.readings.iter().map(move |reading| (order, own, reading)))
            .enumerate()
            .map(move |found| (report.found, found))
    });
    let rows = readings.map(|(found, (i, (order, own, reading)))| {
        let (fit, left_out) = (&found.fit, &found.left_out);
        let shown = |value: f64| if reading.quantity.is_rotation() { value.to_degrees() } else { value };
        let mut row: Row = vec![(order + 1).into(), own.name.as_str().into(), reading.column.into()];
        row.extend(cells(own.at.pose.translation.iter().chain(&own.load.force).copied()));
        let values = [reading.value, fit.predicted.values[i], fit.residuals[i], left_out[i], fit.stds[i]];
        row.extend(values.map(|value| finite(shown(value))));
        row.push(fit.weights[i].into());
        row
    });
    Table::new(columns.concat(), rows)
}

fn models(report: Option<&Report<'_>>) -> Table {
    let columns = [
        texts(["unknowns_of"]),
        counts(["unknowns"]),
        texts(["status", "reason"]),
        numbers(["fitted_rms_mm", "predicted_rms_mm"]),
    ];
    let rows = report.into_iter().flat_map(|report| &report.found.models).map(|model| {
        let mut row: Row = vec![model.name.as_str().into(), model.unknowns.into()];
        row.extend(status_cells(model.predicted_mm.as_ref()));
        row.extend([model.fitted_mm.into(), model.predicted_mm.as_ref().ok().copied().flatten().into()]);
        row
    });
    Table::new(columns.concat(), rows)
}

/// One row per rank correlation of residuals.
fn patterns(report: &Report<'_>) -> Table {
    let columns = [texts(["of", "with", "seen", "hint"]), numbers(["rank_correlation", "limit"])].concat();
    let rows = report.found.patterns.iter().map(|own| -> Row {
        let (seen, hint) = if own.is_seen() { ("yes", own.hint) } else { ("no", "") };
        vec![
            own.of.into(),
            own.with.as_str().into(),
            seen.into(),
            hint.into(),
            own.correlation.into(),
            own.limit.into(),
        ]
    });
    Table::new(columns, rows)
}

/// One row per combination that is open and parameter in it.
fn open(report: Option<&Report<'_>>) -> Table {
    let columns = [counts(["combination"]), texts(["parameter"]), numbers(["part", "std"])].concat();
    let combinations =
        report.into_iter().flat_map(|report| report.found.open.iter().enumerate().map(move |own| (report, own)));
    let rows = combinations.flat_map(|(report, (number, open))| {
        open.parts.iter().map(move |(k, part)| -> Row {
            let name = report.study.unknowns[*k].name.as_str();
            vec![(number + 1).into(), name.into(), (*part).into(), finite(open.std)]
        })
    });
    Table::new(columns, rows)
}

/// One row per pair of unknowns.
fn correlations(report: &Report<'_>) -> Table {
    let unknowns = &report.study.unknowns;
    let pairs = (0..unknowns.len()).flat_map(|a| (a + 1..unknowns.len()).map(move |b| (a, b)));
    let rows = pairs.map(|(a, b)| -> Row {
        let correlation = report.found.fit.correlation(a, b);
        vec![unknowns[a].name.as_str().into(), unknowns[b].name.as_str().into(), correlation.into()]
    });
    Table::new([texts(["parameter", "other"]), numbers(["correlation"])].concat(), rows)
}
