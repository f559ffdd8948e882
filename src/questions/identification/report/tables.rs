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

/// Returns all tables by name; without a report those that every run has, without rows.
pub(super) fn tables(report: Option<&Report<'_>>) -> Vec<(String, Table)> {
    let always = [
        ("parameters", parameters(report)),
        ("residuals", residuals(report)),
        ("models", models(report)),
        ("open", open(report)),
    ];
    let answered = report.map(|report| {
        [("patterns", patterns(report)), ("correlations", correlations(report)), ("covariance", covariance(report))]
    });
    always.into_iter().chain(answered.into_iter().flatten()).map(|(name, table)| (name.into(), table)).collect()
}

/// Makes the table of unknowns: a row for each, with estimate, intervals, why it is not identified, and strongest correlation.
fn parameters<'a>(report: Option<&'a Report<'a>>) -> Table {
    let columns = [
        texts(["parameter", "unit", "status", "reason"]),
        numbers(["start", "value", "std", "low_95", "high_95", "profile_low_95", "profile_high_95", "half_width"]),
        texts(["most_correlated_with"]),
        numbers(["correlation"]),
    ];
    let all = |report: &'a Report<'a>| report.found.found.iter().enumerate().map(move |(k, own)| (report, k, own));
    let rows = report.into_iter().flat_map(all).map(|(report, k, own)| {
        let status = if own.open.is_none() { "identified" } else { "not_identified" };
        let mut row: Row = vec![own.unknown.name.as_str().into(), own.unknown.unit.in_files().into(), status.into()];
        row.extend([own.open.as_deref().into(), own.unknown.start.into(), own.value.into()]);
        let fit = &report.found.fit;
        row.push(finite_cell(fit.std(k) * own.unknown.slope(fit.x[k]).abs()));
        row.extend(own.interval.map(finite_cell));
        row.extend(own.profile.map_or([Cell::Missing, Cell::Missing], |ends| ends.map(finite_cell)));
        row.push(finite_cell(own.half_width));
        row.push(own.correlated.map(|(other, _)| report.study.unknowns[other].name.as_str()).into());
        row.push(own.correlated.map(|(_, correlation)| correlation).into());
        row
    });
    Table::new(columns.concat(), rows)
}

/// Makes the table of readings: a row for each, measured, predicted and residuals; mm, rotations in degrees.
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
        let (fit, leave_one_out) = (&found.fit, &found.leave_one_out);
        let shown = |value: f64| if reading.quantity.is_rotation() { value.to_degrees() } else { value };
        let mut row: Row = vec![(order + 1).into(), own.name.as_str().into(), reading.column.into()];
        row.extend(cells(own.at.pose.translation.iter().chain(&own.load.force).copied()));
        let values = [reading.value, fit.predicted.values[i], fit.residuals[i], leave_one_out[i], fit.stds[i]];
        row.extend(values.map(|value| finite_cell(shown(value))));
        row.push(fit.weights[i].into());
        row
    });
    Table::new(columns.concat(), rows)
}

/// Makes the table of sets of unknowns: a row for each, with RMS residual fitted and in cross-validation.
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

/// Makes the table of rank correlations of residuals, a row for each.
fn patterns(report: &Report<'_>) -> Table {
    let columns = [texts(["of", "with", "seen", "hint"]), numbers(["rank_correlation", "limit"])].concat();
    let rows = report.found.patterns.iter().map(|own| -> Row {
        let (seen, hint) = if own.is_significant() { ("yes", own.hint) } else { ("no", "") };
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

/// Makes the table of unidentified combinations: a row for each combination and parameter in it.
fn open(report: Option<&Report<'_>>) -> Table {
    let columns = [counts(["combination"]), texts(["parameter"]), numbers(["part", "std"])].concat();
    let combinations =
        report.into_iter().flat_map(|report| report.found.open.iter().enumerate().map(move |own| (report, own)));
    let rows = combinations.flat_map(|(report, (number, open))| {
        open.parts.iter().map(move |(k, part)| -> Row {
            let name = report.study.unknowns[*k].name.as_str();
            vec![(number + 1).into(), name.into(), (*part).into(), finite_cell(open.std)]
        })
    });
    Table::new(columns, rows)
}

/// Makes the table of correlations of the estimates, a row for each pair of unknowns.
fn correlations(report: &Report<'_>) -> Table {
    let unknowns = &report.study.unknowns;
    let pairs = (0..unknowns.len()).flat_map(|a| (a + 1..unknowns.len()).map(move |b| (a, b)));
    let rows = pairs.map(|(a, b)| -> Row {
        let correlation = report.found.fit.correlation(a, b);
        vec![unknowns[a].name.as_str().into(), unknowns[b].name.as_str().into(), correlation.into()]
    });
    Table::new([texts(["parameter", "other"]), numbers(["correlation"])].concat(), rows)
}

/// Makes the table of the covariance of the estimates, as uncertain inputs of other studies read it: a row for each pair of identified unknowns, and one
/// without number for each that is open. Of logarithms where the unknown must stay positive, else in its unit.
fn covariance(report: &Report<'_>) -> Table {
    let (unknowns, fit) = (&report.study.unknowns, &report.found.fit);
    let scale = |own: &Unknown| match own.coordinate {
        Coordinate::Logarithm => 1.0,
        Coordinate::Linear(scale) => scale,
    };
    let is_open = |own: usize| report.found.found[own].open.is_some();
    let pairs = (0..unknowns.len()).flat_map(|a| (a..unknowns.len()).map(move |b| (a, b)));
    let rows = pairs.filter(|(a, b)| a == b || !is_open(*a) && !is_open(*b)).map(|(a, b)| -> Row {
        let (own, other) = (&unknowns[a], &unknowns[b]);
        let distribution = DISTRIBUTIONS[usize::from(own.coordinate != Coordinate::Logarithm)];
        let covariance = (!is_open(a)).then(|| fit.covariance[(a, b)] * scale(own) * scale(other));
        let value = report.found.found[a].value;
        vec![own.name.as_str().into(), other.name.as_str().into(), distribution.into(), value.into(), covariance.into()]
    });
    // What parameters do not explain is a cause of its own.
    let model = report
        .residual_share()
        .map(|share| vec![MODEL.into(), MODEL.into(), DISTRIBUTIONS[1].into(), share.into(), Cell::Missing]);
    let [parameter, other, distribution, value, covariance] = COVARIANCE_COLUMNS;
    Table::new([texts([parameter, other, distribution]), numbers([value, covariance])].concat(), rows.chain(model))
}
