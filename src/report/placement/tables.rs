//! A placement study as CSV (RFC 4180), units in the headers.

use crate::study::placement::{
    COORDINATES, Cell, Entry, Found, Metric, Metrics, PlacementResults, PlacementStudy, Refinement, Site, UNITS,
    Verdict,
};

type Row = Vec<String>;

fn coordinate_columns() -> impl Iterator<Item = String> {
    COORDINATES.iter().zip(UNITS).map(|(name, unit)| format!("{name}_{unit}"))
}

fn coordinates(site: &Site) -> impl Iterator<Item = String> {
    site.shown().into_iter().map(|value| value.to_string())
}

fn number(value: Option<f64>) -> String {
    value.filter(|value| value.is_finite()).map_or_else(String::new, |value| value.to_string())
}

fn cells(metrics: &[Metric], values: Option<&Metrics>) -> impl Iterator<Item = String> {
    metrics.iter().map(move |metric| number(values.and_then(|values| values.get(*metric))))
}

fn csv(header: Row, rows: impl Iterator<Item = Row>) -> csv::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header)?;
    for row in rows {
        writer.write_record(row)?;
    }
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}

fn columns(study: &PlacementStudy, metrics: &[Metric]) -> impl Iterator<Item = String> {
    metrics.iter().map(|metric| metric.column(&study.machine))
}

/// Metrics that can be had for a study: those of corrections within limits only with limits.
fn available(study: &PlacementStudy, entries: &[Entry]) -> Vec<Metric> {
    let evaluated = || entries.iter().filter_map(|entry| entry.outcome.as_ref().ok());
    let mut metrics = Metric::ALL.to_vec();
    if !study.features.iter().any(|job| job.limits.is_limited()) {
        metrics.retain(|metric| !metric.is_bounded());
    }
    metrics.retain(|metric| *metric != Metric::ForceMargin || evaluated().any(|e| e.metrics.get(*metric).is_some()));
    metrics
}

/// Named places, the best of the sweep and those found by refinement, ranked; with all metrics, and the worst deflection
/// of each feature. Places that cannot be cut come last, with `status` and `reason`.
pub fn entries_csv(study: &PlacementStudy, entries: &[Entry]) -> csv::Result<Vec<u8>> {
    let metrics = available(study, entries);
    let mut header: Row = ["rank", "name", "found"].map(String::from).into();
    header.extend(coordinate_columns());
    header.extend(["status", "reason", "objective"].map(String::from));
    header.extend(columns(study, &metrics));
    let features = study.features.len();
    if features > 1 {
        header.extend(study.features.iter().map(|job| format!("worst_deflection_{}_mm", job.feature.name)));
    }
    header.push("correction_within_limits".into());
    let row = |(rank, entry): (usize, &Entry)| {
        let mut row: Row = Vec::new();
        row.push(if entry.outcome.is_ok() { (rank + 1).to_string() } else { String::new() });
        row.extend([entry.name.clone(), entry.found.label().into()]);
        row.extend(coordinates(&entry.site));
        match &entry.outcome {
            Ok(_) => row.extend(["solved".into(), String::new()]),
            Err(failure) => row.extend([failure.status.into(), failure.reason.clone()]),
        }
        row.push(number(Some(entry.value)));
        let evaluation = entry.outcome.as_ref().ok();
        row.extend(cells(&metrics, evaluation.map(|e| &e.metrics)));
        if features > 1 {
            let worst = |f: usize| evaluation.and_then(|e| e.features[f].get(Metric::WorstDeflection));
            row.extend((0..features).map(|f| number(worst(f))));
        }
        row.push(evaluation.and_then(|e| e.not_corrected.clone()).unwrap_or_default());
        row
    };
    csv(header, entries.iter().enumerate().map(row))
}

/// One row per place of the sweep, in grid order. `status` is `solved`, `given_up` (not looked at on all points: the
/// metrics are no better than the numbers shown, which are worse than what was found elsewhere) or why the workpiece cannot be cut there.
pub fn sweep_csv(results: &PlacementResults) -> csv::Result<Vec<u8>> {
    let study = &results.study;
    let metrics = searched(study);
    let mut ranks = vec![String::new(); results.cells.len()];
    for (rank, &index) in results.ranking.iter().enumerate() {
        if results.cells[index].complete().is_some() {
            ranks[index] = (rank + 1).to_string();
        }
    }
    let mut header: Row = coordinate_columns().collect();
    header.extend(["status", "reason", "rank", "objective"].map(String::from));
    header.extend(columns(study, &metrics));
    let row = |(cell, rank): (&Cell, String)| {
        let mut row: Row = coordinates(&cell.site).collect();
        row.push(cell_status(cell).into());
        row.push(match &cell.verdict {
            Verdict::Complete(_) => String::new(),
            Verdict::GivenUp(_) => "cannot be the best place".into(),
            Verdict::Infeasible(failure) => failure.reason.clone(),
        });
        row.push(rank);
        row.push(number(cell.metrics().map(|metrics| study.objective.value(metrics))));
        row.extend(cells(&metrics, cell.metrics()));
        row
    };
    csv(header, results.cells.iter().zip(ranks).map(row))
}

/// Word for what became of a place of the sweep.
pub fn cell_status(cell: &Cell) -> &'static str {
    match &cell.verdict {
        Verdict::Complete(_) => "solved",
        Verdict::GivenUp(_) => "given_up",
        Verdict::Infeasible(failure) => failure.status,
    }
}

/// The metrics a search computes anyway, and those of its objective.
fn searched(study: &PlacementStudy) -> Vec<Metric> {
    let needed = study.objective.metrics();
    let free = [Metric::WorstDeflection, Metric::RmsDeflection, Metric::ShareWithin];
    Metric::ALL.into_iter().filter(|metric| needed.contains(metric) || free.contains(metric)).collect()
}

/// One row per refinement: start, end, value, and how it compares with the best place.
pub fn refinements_csv(results: &PlacementResults) -> csv::Result<Vec<u8>> {
    let mut header: Row = vec!["refinement".into()];
    header.extend(coordinate_columns().map(|name| format!("start_{name}")));
    header.extend(coordinate_columns());
    header.extend(["objective", "iterations", "evaluations", "converged", "agreement"].map(String::from));
    let row = |(index, found): (usize, &Refinement)| {
        let agreement = results.best.as_ref().map_or("", |best| super::summary::agreement_word(best.agreement[index]));
        let mut row: Row = vec![(index + 1).to_string()];
        row.extend(coordinates(&found.start));
        row.extend(coordinates(&found.site));
        row.push(number(Some(found.value)));
        row.extend([found.iterations.to_string(), found.visited.len().to_string(), found.is_converged.to_string()]);
        row.push(agreement.into());
        row
    };
    csv(header, results.refinements.iter().enumerate().map(row))
}

/// The Pareto front, by its first metric.
pub fn front_csv(results: &PlacementResults) -> csv::Result<Vec<u8>> {
    let study = &results.study;
    let metrics = &study.objective.pareto;
    let mut header: Row = coordinate_columns().collect();
    header.extend(columns(study, metrics));
    let row = |(site, values): &(Site, Metrics)| {
        let mut row: Row = coordinates(site).collect();
        row.extend(cells(metrics, Some(values)));
        row
    };
    csv(header, results.front.iter().map(row))
}

/// Whether an entry was found by the search.
pub(super) fn is_found(entry: &Entry) -> bool {
    entry.found != Found::Named
}
