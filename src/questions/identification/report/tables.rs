//! Tables of an identification: estimates, residuals, sets of unknowns, patterns, correlations.

use super::summary::Report;
use crate::{
    answer::status_cells,
    files::exchange::{Cell, Row, Table, cells, counts, numbers, texts},
    process::uncertainty::{COVARIANCE_COLUMNS, DISTRIBUTIONS, MODEL},
    questions::identification::{Coordinate, Unknown, measurements::FORCE},
};

/// Returns a cell with a number, empty if it is infinite.
fn finite_cell(value: f64) -> Cell {
    value.is_finite().then_some(value).into()
}

/// Returns all tables with their file stems; without a report, those that every run writes, without rows.
pub(super) fn tables(report: Option<&Report<'_>>) -> Vec<(String, Table)> {
    let always = [
        ("parameters", parameters_table(report)),
        ("residuals", residuals_table(report)),
        ("models", models_table(report)),
        ("open", combinations_table(report)),
    ];
    let answered = report.map(|report| {
        [
            ("patterns", patterns_table(report)),
            ("correlations", correlations_table(report)),
            ("covariance", covariance_table(report)),
        ]
    });
    always.into_iter().chain(answered.into_iter().flatten()).map(|(name, table)| (name.into(), table)).collect()
}

/// Makes the table of unknowns: a row for each, with estimate, intervals, why it is not identified, and strongest correlation.
fn parameters_table<'a>(report: Option<&'a Report<'a>>) -> Table {
    let columns = [
        texts(["parameter", "unit", "status", "reason"]),
        numbers(["start", "value", "std", "low_95", "high_95", "profile_low_95", "profile_high_95", "half_width"]),
        texts(["most_correlated_with"]),
        numbers(["correlation"]),
    ];
    let all = |report: &'a Report<'a>| {
        report.results.estimates.iter().enumerate().map(move |(k, estimate)| (report, k, estimate))
    };
    let rows = report.into_iter().flat_map(all).map(|(report, k, estimate)| {
        let status = if estimate.open.is_none() { "identified" } else { "not_identified" };
        let mut row: Row =
            vec![estimate.unknown.name.as_str().into(), estimate.unknown.unit.in_files().into(), status.into()];
        row.extend([estimate.open.as_deref().into(), estimate.unknown.start.into(), estimate.value.into()]);
        let fit = &report.results.fit;
        row.push(finite_cell(fit.std(k) * estimate.unknown.slope(fit.x[k]).abs()));
        row.extend(estimate.interval.map(finite_cell));
        row.extend(estimate.profile.map_or([Cell::Missing, Cell::Missing], |ends| ends.map(finite_cell)));
        row.push(finite_cell(estimate.half_width));
        row.push(estimate.correlated.map(|(other, _)| report.study.unknowns[other].name.as_str()).into());
        row.push(estimate.correlated.map(|(_, correlation)| correlation).into());
        row
    });
    Table::new(columns.concat(), rows)
}

/// Makes the table of readings: a row for each, measured, predicted and residuals; mm, rotations in degrees.
fn residuals_table(report: Option<&Report<'_>>) -> Table {
    let columns = [
        counts(["order"]),
        texts(["pose", "reading"]),
        numbers(["x_mm", "y_mm", "z_mm"].into_iter().chain(FORCE)),
        numbers(["measured", "predicted", "residual", "left_out_residual", "std", "weight"]),
    ];
    let readings = report.into_iter().flat_map(|report| {
        let measurements = report.study.measurements.iter().enumerate();
        measurements
            .flat_map(|(order, measurement)| {
                measurement.readings.iter().map(move |reading| (order, measurement, reading))
            })
            .enumerate()
            .map(move |numbered| (report.results, numbered))
    });
    let rows = readings.map(|(results, (i, (order, measurement, reading)))| {
        let (fit, leave_one_out) = (&results.fit, &results.leave_one_out);
        let shown = |value: f64| if reading.quantity.is_rotation() { value.to_degrees() } else { value };
        let mut row: Row = vec![(order + 1).into(), measurement.name.as_str().into(), reading.column.into()];
        row.extend(cells(measurement.at.pose.translation.iter().chain(&measurement.load.force).copied()));
        let values = [reading.value, fit.predicted.values[i], fit.residuals[i], leave_one_out[i], fit.stds[i]];
        row.extend(values.map(|value| finite_cell(shown(value))));
        row.push(fit.weights[i].into());
        row
    });
    Table::new(columns.concat(), rows)
}

/// Makes the table of sets of unknowns: a row for each, with RMS residual fitted and in cross-validation.
fn models_table(report: Option<&Report<'_>>) -> Table {
    let columns = [
        texts(["unknowns_of"]),
        counts(["unknowns"]),
        texts(["status", "reason"]),
        numbers(["fitted_rms_mm", "predicted_rms_mm"]),
    ];
    let rows = report.into_iter().flat_map(|report| &report.results.models).map(|model| {
        let mut row: Row = vec![model.name.as_str().into(), model.unknowns.into()];
        row.extend(status_cells(model.predicted_mm.as_ref()));
        row.extend([model.fitted_mm.into(), model.predicted_mm.as_ref().ok().copied().flatten().into()]);
        row
    });
    Table::new(columns.concat(), rows)
}

/// Makes the table of rank correlations of residuals, a row for each.
fn patterns_table(report: &Report<'_>) -> Table {
    let columns = [texts(["of", "with", "seen", "hint"]), numbers(["rank_correlation", "limit"])].concat();
    let rows = report.results.patterns.iter().map(|pattern| -> Row {
        let (seen, hint) = if pattern.is_significant() { ("yes", pattern.hint) } else { ("no", "") };
        vec![
            pattern.of.into(),
            pattern.with.as_str().into(),
            seen.into(),
            hint.into(),
            pattern.correlation.into(),
            pattern.limit.into(),
        ]
    });
    Table::new(columns, rows)
}

/// Makes the table of unidentified combinations: a row for each combination and parameter in it.
fn combinations_table(report: Option<&Report<'_>>) -> Table {
    let columns = [counts(["combination"]), texts(["parameter"]), numbers(["part", "std"])].concat();
    let combinations =
        report.into_iter().flat_map(|report| report.results.open.iter().enumerate().map(move |own| (report, own)));
    let rows = combinations.flat_map(|(report, (number, open))| {
        open.parts.iter().map(move |(k, part)| -> Row {
            let name = report.study.unknowns[*k].name.as_str();
            vec![(number + 1).into(), name.into(), (*part).into(), finite_cell(open.std)]
        })
    });
    Table::new(columns, rows)
}

/// Makes the table of correlations of the estimates, a row for each pair of unknowns.
fn correlations_table(report: &Report<'_>) -> Table {
    let unknowns = &report.study.unknowns;
    let pairs = (0..unknowns.len()).flat_map(|a| (a + 1..unknowns.len()).map(move |b| (a, b)));
    let rows = pairs.map(|(a, b)| -> Row {
        let correlation = report.results.fit.correlation(a, b);
        vec![unknowns[a].name.as_str().into(), unknowns[b].name.as_str().into(), correlation.into()]
    });
    Table::new([texts(["parameter", "other"]), numbers(["correlation"])].concat(), rows)
}

/// Makes the table of the covariance of estimates, as `[uncertainty]` of other studies reads it: a row for each pair of identified
/// unknowns, and one without number for each not identified; of logarithms where an unknown must stay positive, else in its unit.
fn covariance_table(report: &Report<'_>) -> Table {
    let (unknowns, fit) = (&report.study.unknowns, &report.results.fit);
    let scale = |own: &Unknown| match own.coordinate {
        Coordinate::Logarithm => 1.0,
        Coordinate::Linear(scale) => scale,
    };
    let is_open = |own: usize| report.results.estimates[own].open.is_some();
    let pairs = (0..unknowns.len()).flat_map(|a| (a..unknowns.len()).map(move |b| (a, b)));
    let rows = pairs.filter(|(a, b)| a == b || !is_open(*a) && !is_open(*b)).map(|(a, b)| -> Row {
        let (own, other) = (&unknowns[a], &unknowns[b]);
        let distribution = DISTRIBUTIONS[usize::from(own.coordinate != Coordinate::Logarithm)];
        let covariance = (!is_open(a)).then(|| fit.covariance[(a, b)] * scale(own) * scale(other));
        let value = report.results.estimates[a].value;
        vec![own.name.as_str().into(), other.name.as_str().into(), distribution.into(), value.into(), covariance.into()]
    });
    // What parameters do not explain is a cause of its own.
    let model = report
        .residual_share()
        .map(|share| vec![MODEL.into(), MODEL.into(), DISTRIBUTIONS[1].into(), share.into(), Cell::Missing]);
    let [parameter, other, distribution, value, covariance] = COVARIANCE_COLUMNS;
    Table::new([texts([parameter, other, distribution]), numbers([value, covariance])].concat(), rows.chain(model))
}
