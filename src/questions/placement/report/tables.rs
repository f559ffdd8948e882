//! The tables of a placement study.

use crate::{
    files::exchange::{self, Column, Row, Table, counts, numbers, texts},
    questions::placement::{
        COORDINATES, Cell, Entry, Found, Metric, Metrics, PlacementResults, PlacementStudy, Refinement, Site, Start,
        UNITS, Verdict,
    },
};

fn coordinate_columns() -> impl Iterator<Item = String> {
    COORDINATES.iter().zip(UNITS).map(|(name, unit)| format!("{name}_{unit}"))
}

fn coordinates(site: &Site) -> impl Iterator<Item = exchange::Cell> {
    exchange::cells(site.shown())
}

/// A number that can be shown: a place that cannot be used has an objective beyond all numbers.
fn number(value: Option<f64>) -> exchange::Cell {
    value.filter(|value| value.is_finite()).into()
}

fn cells(metrics: &[Metric], values: Option<&Metrics>) -> impl Iterator<Item = exchange::Cell> {
    metrics.iter().map(move |metric| number(values.and_then(|values| values.get(*metric))))
}

fn columns(study: &PlacementStudy, metrics: &[Metric]) -> Vec<Column> {
    numbers(metrics.iter().map(|metric| metric.column(&study.machine)))
}

/// Metrics that can be had for a study: those of corrections within limits only with limits.
fn available(study: &PlacementStudy, entries: &[Entry]) -> Vec<Metric> {
    let evaluated = || entries.iter().filter_map(|entry| entry.outcome.as_ref().ok());
    let mut metrics = Metric::ALL.to_vec();
    metrics.retain(|metric| metric.exists_on(&study.machine) && study.objective.has(*metric));
    if !study.features.iter().any(|job| job.limits.is_limited()) {
        metrics.retain(|metric| !metric.is_bounded());
    }
    metrics.retain(|metric| *metric != Metric::ForceMargin || evaluated().any(|e| e.metrics.get(*metric).is_some()));
    metrics
}

/// Named places, the best of the sweep and those found by refinement, ranked; with all metrics, and the worst deflection
/// of each feature. Places that cannot be cut at come last, with `status` and `reason`; where the path leaves the workspace
/// box (`outside_workspace`) the numbers say what would happen there.
pub fn candidates_table(study: &PlacementStudy, entries: &[Entry]) -> Table {
    let metrics = available(study, entries);
    let mut header = counts(["rank"]);
    header.extend(texts(["name", "found"]));
    header.extend(numbers(coordinate_columns()));
    header.extend(texts(["status", "reason"]));
    header.extend(numbers(["objective"]));
    header.extend(columns(study, &metrics));
    let features = study.features.len();
    if features > 1 {
        header.extend(numbers(study.features.iter().map(|job| format!("worst_deflection_{}_mm", job.feature.name))));
    }
    let turned: Vec<usize> = (0..features).filter(|f| study.features[*f].turn.is_some()).collect();
    header.extend(numbers(turned.iter().map(|f| format!("turn_{}_deg", study.features[*f].feature.name))));
    header.extend(texts(["correction_within_limits"]));
    let row = |(rank, entry): (usize, &Entry)| {
        let mut row: Row = vec![entry.feasible().map(|_| rank + 1).into()];
        row.extend([entry.name.as_str().into(), entry.found.label().into()]);
        row.extend(coordinates(&entry.site));
        match entry.refusal() {
            None => row.extend(["solved".into(), exchange::Cell::Missing]),
            Some(failure) => row.extend([(&*failure.status).into(), failure.reason.as_str().into()]),
        }
        row.push(number(Some(entry.value)));
        let evaluation = entry.outcome.as_ref().ok();
        row.extend(cells(&metrics, evaluation.map(|e| &e.metrics)));
        if features > 1 {
            let worst = |f: usize| evaluation.and_then(|e| e.features[f].get(Metric::WorstDeflection));
            row.extend((0..features).map(|f| number(worst(f))));
        }
        row.extend(turned.iter().map(|f| number(entry.turns[*f].map(f64::to_degrees))));
        row.push(evaluation.and_then(|e| e.not_corrected.clone()).into());
        row
    };
    Table::new(header, entries.iter().enumerate().map(row))
}

/// One row per place of the sweep, in grid order. `status` is `solved`, `given_up` (not looked at on all points: the
/// metrics are no better than the numbers shown, which are worse than what was found elsewhere) or why the workpiece cannot be cut there.
pub fn sweep_table(results: &PlacementResults) -> Table {
    let study = &results.study;
    let metrics = searched(study);
    let mut ranks = vec![None; results.cells.len()];
    for (rank, &index) in results.ranking.iter().enumerate() {
        if results.cells[index].complete().is_some() {
            ranks[index] = Some(rank + 1);
        }
    }
    let mut header = numbers(coordinate_columns());
    header.extend(texts(["status", "reason"]));
    header.extend(counts(["rank"]));
    header.extend(numbers(["objective"]));
    header.extend(columns(study, &metrics));
    let row = |(cell, rank): (&Cell, Option<usize>)| {
        let mut row: Row = coordinates(&cell.site).collect();
        row.push(cell_status(cell).into());
        row.push(match &cell.verdict {
            Verdict::Complete(_) => exchange::Cell::Missing,
            Verdict::GivenUp(_) => "cannot be the best place".into(),
            Verdict::Infeasible(failure) => failure.reason.as_str().into(),
        });
        row.push(rank.into());
        row.push(number(cell.metrics().map(|metrics| study.objective.value(metrics))));
        row.extend(cells(&metrics, cell.metrics()));
        row
    };
    Table::new(header, results.cells.iter().zip(ranks).map(row))
}

/// Word for what became of a place of the sweep.
pub(crate) fn cell_status(cell: &Cell) -> &str {
    match &cell.verdict {
        Verdict::Complete(_) => "solved",
        Verdict::GivenUp(_) => "given_up",
        Verdict::Infeasible(failure) => &failure.status,
    }
}

/// The metrics a search computes anyway, and those of its objective.
fn searched(study: &PlacementStudy) -> Vec<Metric> {
    let needed = study.objective.metrics();
    let free = [Metric::WorstDeflection, Metric::RmsDeflection, Metric::ShareWithin];
    Metric::ALL.into_iter().filter(|metric| needed.contains(metric) || free.contains(metric)).collect()
}

/// One row per refinement: start, end, value, and how it compares with the best place.
pub(crate) fn refinements_table(results: &PlacementResults) -> Table {
    let mut header = counts(["refinement"]);
    header.extend(texts(["started_from"]));
    header.extend(numbers(coordinate_columns().map(|name| format!("start_{name}"))));
    header.extend(numbers(coordinate_columns()));
    header.extend(numbers(["objective"]));
    header.extend(counts(["iterations", "searches_ended_by_count", "evaluations"]));
    header.extend(texts(["converged", "agreement"]));
    let row = |(index, found): (usize, &Refinement)| {
        let agreement = results
            .best
            .as_ref()
            .map_or("", |best| crate::questions::placement::report::summary::agreement_word(best.agreement[index]));
        let mut row: Row = vec![(index + 1).into(), started_from(&results.study, found.from).into()];
        row.extend(coordinates(&found.start));
        row.extend(coordinates(&found.site));
        row.push(number(Some(found.value)));
        row.extend([found.iterations.into(), found.continued.into(), found.visited.len().into()]);
        row.push(found.is_converged.to_string().into());
        row.push(agreement.into());
        row
    };
    Table::new(header, results.refinements.iter().enumerate().map(row))
}

/// The Pareto front, by its first metric.
pub(crate) fn front_table(results: &PlacementResults) -> Table {
    let study = &results.study;
    let metrics = &study.objective.pareto;
    let mut header = numbers(coordinate_columns());
    header.extend(columns(study, metrics));
    let row = |(site, values): &(Site, Metrics)| {
        let mut row: Row = coordinates(site).collect();
        row.extend(cells(metrics, Some(values)));
        row
    };
    Table::new(header, results.front.iter().map(row))
}

fn started_from(study: &PlacementStudy, start: Start) -> &str {
    match start {
        Start::Sweep => "sweep",
        Start::Between => "between places of the sweep",
        Start::Named(index) => study.candidates.get(index).map_or("", |candidate| &candidate.name),
    }
}

/// Whether an entry was found by the search.
pub(super) fn is_found(entry: &Entry) -> bool {
    entry.found != Found::Named
}
