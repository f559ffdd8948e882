//! The numbers of a placement study, its tables, and what it says for programs.

use serde_json::{Map, Value, json};

use crate::{
    answer::{Quantity, TableOf, status_cells},
    files::exchange::{self, Column, Row, Table, counts, numbers, texts},
    page::Better::{Larger, Neither, Smaller},
    questions::placement::{
        Agreement, COORDINATES, Cell, End, Entry, FeatureJob, Found, Metric, Metrics, PlacementResults, PlacementStudy,
        Refinement, Room, Site, Start, UNITS, Verdict, site::in_unit,
    },
    simulation::{Failure, SOLVED},
};

/// A number that can be shown: a place that cannot be used has an objective beyond all numbers.
fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

/// The objective of what is had of an `E`.
fn objective<E: 'static>(value: impl Fn(&E) -> Option<f64> + Send + Sync + 'static) -> Quantity<E> {
    Quantity::made("objective".into(), "objective".into(), Smaller, move |own| finite(value(own)?))
}

/// A metric of what is had of an `E`.
fn metric<E: 'static>(study: &PlacementStudy, metric: Metric, metrics: fn(&E) -> Option<&Metrics>) -> Quantity<E> {
    let (name, label) = (metric.column(&study.machine), metric.words(&study.machine).into());
    let better = if metric.larger_is_better() { Larger } else { Smaller };
    Quantity::made(name, label, better, move |own| finite(metrics(own)?.get(metric)?))
}

/// A metric of a named or found place.
pub(super) fn of_entry(study: &PlacementStudy, own: Metric) -> Quantity<Entry> {
    metric(study, own, |entry| entry.outcome.as_ref().ok().map(|evaluation| &evaluation.metrics))
}

/// Metrics that can be had for a study: those of corrections within limits only with limits.
pub(super) fn available(study: &PlacementStudy) -> impl Iterator<Item = Metric> {
    let has_limits = study.has_limits();
    let exists = |metric: &Metric| metric.exists_on(&study.machine) && study.objective.has(*metric);
    Metric::ALL.into_iter().filter(exists).filter(move |metric| has_limits || !metric.is_bounded())
}

/// Objective and `metrics` of named and found places.
pub(super) fn of_entries(study: &PlacementStudy, metrics: impl IntoIterator<Item = Metric>) -> Vec<Quantity<Entry>> {
    let metrics = metrics.into_iter().map(|metric| of_entry(study, metric));
    std::iter::once(objective(|entry: &Entry| Some(entry.value))).chain(metrics).collect()
}

/// Objective of places of the sweep, the metrics that a search computes anyway, and those of its objective.
pub(super) fn of_cells(study: &PlacementStudy) -> Vec<Quantity<Cell>> {
    let asked = study.objective.metrics();
    let free = [Metric::WorstDeflection, Metric::RmsDeflection, Metric::ShareWithin];
    let metrics = Metric::ALL.into_iter().filter(|metric| asked.contains(metric) || free.contains(metric));
    let metrics = metrics.map(|own| metric(study, own, Cell::metrics));
    let sought = study.objective.clone();
    std::iter::once(objective(move |cell: &Cell| Some(sought.value(cell.metrics()?)))).chain(metrics).collect()
}

fn coordinate_columns(lead: &str) -> Vec<Column> {
    numbers(COORDINATES.iter().zip(UNITS).map(|(name, unit)| format!("{lead}{name}_{unit}")))
}

fn coordinates(site: &Site) -> impl Iterator<Item = exchange::Cell> {
    exchange::cells(site.shown())
}

/// A table of the quantities of each of `rows` behind its leading cells.
fn table<'a, E: 'static>(
    lead: Vec<Column>,
    quantities: Vec<Quantity<E>>,
    rows: impl IntoIterator<Item = (Row, &'a E)>,
) -> Table {
    let rows = rows.into_iter().map(|(lead, own)| (lead, Ok(own)));
    TableOf::without_status(lead, quantities).table(rows)
}

/// Named places, the best of the sweep and those found by refinement, ranked; with all metrics, and the worst deflection
/// of each feature. Places that cannot be cut at come last, with `status` and `reason`; where the path leaves the workspace
/// box (`outside_workspace`) the numbers say what would happen there.
pub fn candidates_table(study: &PlacementStudy, entries: &[Entry]) -> Table {
    let mut evaluated = entries.iter().filter_map(|entry| entry.outcome.as_ref().ok());
    let has_margin = evaluated.any(|evaluation| evaluation.metrics.get(Metric::ForceMargin).is_some());
    let metrics = available(study).filter(|metric| has_margin || *metric != Metric::ForceMargin);
    let mut quantities = of_entries(study, metrics);
    let of_feature = |name: String, get: fn(&Entry, usize) -> Option<f64>, f: usize| {
        Quantity::made(name, String::new(), Neither, move |entry: &Entry| finite(get(entry, f)?))
    };
    let named = || study.features.iter().map(|job| (job, &job.feature.name)).enumerate();
    if study.features.len() > 1 {
        let worst = |entry: &Entry, f: usize| entry.outcome.as_ref().ok()?.features[f].get(Metric::WorstDeflection);
        quantities.extend(named().map(|(f, (_, name))| of_feature(format!("worst_deflection_{name}_mm"), worst, f)));
    }
    let turn = |entry: &Entry, f: usize| entry.turns[f].map(f64::to_degrees);
    let turned = named().filter(|(_, (job, _))| job.turn.is_some());
    quantities.extend(turned.map(|(f, (_, name))| of_feature(format!("gamma_{name}_deg"), turn, f)));
    quantities.push(Quantity::text("correction_within_limits", |entry| {
        entry.ok().and_then(|entry| entry.outcome.as_ref().ok()?.not_corrected.clone()).into()
    }));
    let lead = [counts(["rank"]), texts(["name", "found"]), coordinate_columns(""), texts(["status", "reason"])];
    let row = |(rank, entry): (usize, &'_ Entry)| {
        let mut row: Row = vec![entry.feasible().map(|_| rank + 1).into()];
        row.extend([entry.name.as_str().into(), entry.found.label().into()]);
        row.extend(coordinates(&entry.site));
        row.extend(status_cells(entry.refusal().map_or(Ok(()), Err)));
        row
    };
    table(lead.concat(), quantities, entries.iter().enumerate().map(|(rank, entry)| (row((rank, entry)), entry)))
}

/// One row per place of the sweep, in grid order. `status` is `solved`, `pruned` (not looked at on all points: the
/// metrics are no better than the numbers shown, which are worse than what was found elsewhere) or why the workpiece cannot be cut there.
pub fn sweep_table(results: &PlacementResults) -> Table {
    let mut ranks = vec![None; results.cells.len()];
    for (rank, &index) in results.ranking.iter().enumerate() {
        ranks[index] = results.cells[index].complete().map(|_| rank + 1);
    }
    let row = |(cell, rank): (&'_ Cell, Option<usize>)| {
        let reason = match &cell.verdict {
            Verdict::Complete(_) => "",
            Verdict::Pruned(_) => "cannot be the best place",
            Verdict::Infeasible(Failure { reason, .. }) => reason,
        };
        coordinates(&cell.site).chain([cell_status(cell).into(), reason.into(), rank.into()]).collect()
    };
    let lead = [coordinate_columns(""), texts(["status", "reason"]), counts(["rank"])].concat();
    let rows = results.cells.iter().zip(ranks).map(|(cell, rank)| (row((cell, rank)), cell));
    table(lead, of_cells(&results.study), rows)
}

/// Word for what became of a place of the sweep.
pub(super) fn cell_status(cell: &Cell) -> &str {
    match &cell.verdict {
        Verdict::Complete(_) => SOLVED,
        Verdict::Pruned(_) => "pruned",
        Verdict::Infeasible(failure) => &failure.status,
    }
}

fn agreement_word(agreement: Agreement) -> &'static str {
    match agreement {
        Agreement::Same => "same",
        Agreement::Elsewhere => "same_value_elsewhere",
        Agreement::Worse => "worse",
    }
}

/// One row per refinement: start, end, value, and how it compares with the best place.
pub(super) fn refinements_table(results: &PlacementResults) -> Table {
    let columns = [
        counts(["refinement"]),
        texts(["started_from"]),
        coordinate_columns("start_"),
        coordinate_columns(""),
        numbers(["objective"]),
        counts(["iterations", "searches_ended_by_count", "evaluations"]),
        texts(["converged", "agreement"]),
    ];
    let row = |(index, found): (usize, &Refinement)| {
        let agreement = results.best.as_ref().map(|best| agreement_word(best.agreement[index]));
        let mut row: Row = vec![(index + 1).into(), started_from(&results.study, found.from).into()];
        row.extend(coordinates(&found.start).chain(coordinates(&found.site)));
        row.push(finite(found.value).into());
        row.extend([found.iterations.into(), found.continued.into(), found.visited.len().into()]);
        row.extend([found.is_converged.to_string().into(), agreement.into()]);
        row
    };
    Table::new(columns.concat(), results.refinements.iter().enumerate().map(row))
}

/// The Pareto front, by its first metric.
pub(super) fn front_table(results: &PlacementResults) -> Table {
    let study = &results.study;
    let of = |own: &Metric| metric(study, *own, |(_, values): &(Site, Metrics)| Some(values));
    let rows = results.front.iter().map(|place| (coordinates(&place.0).collect(), place));
    table(coordinate_columns(""), study.objective.pareto.iter().map(of).collect(), rows)
}

fn started_from(study: &PlacementStudy, start: Start) -> &str {
    match start {
        Start::Sweep => "sweep",
        Start::Between => "between places of the sweep",
        Start::Named(index) => study.candidates.get(index).map_or("", |candidate| &candidate.name),
    }
}

/// Places evaluated on all points, given up, and infeasible.
pub(super) fn verdicts(results: &PlacementResults) -> [usize; 3] {
    let mut counts = [0; 3];
    for cell in &results.cells {
        counts[match cell.verdict {
            Verdict::Complete(_) => 0,
            Verdict::Pruned(_) => 1,
            Verdict::Infeasible(_) => 2,
        }] += 1;
    }
    counts
}

fn site_json(site: &Site) -> Value {
    let coordinates = COORDINATES.iter().zip(UNITS).zip(site.shown());
    coordinates.map(|((name, unit), value)| (format!("{name}_{unit}"), json!(value))).collect::<Map<_, _>>().into()
}

fn metrics_json(study: &PlacementStudy, metrics: &Metrics) -> Value {
    let given = Metric::ALL.into_iter().filter_map(|metric| {
        let value = metrics.get(metric).filter(|value| value.is_finite())?;
        Some((metric.column(&study.machine), json!(value)))
    });
    Value::Object(given.collect::<Map<_, _>>())
}

fn entry_json(study: &PlacementStudy, entry: &Entry) -> Value {
    let mut object = json!({ "name": entry.name, "found": entry.found.label(), "place": site_json(&entry.site) });
    if let Ok(evaluation) = &entry.outcome {
        object["objective"] = json!(entry.value);
        object["metrics"] = metrics_json(study, &evaluation.metrics);
        let feature = |(job, metrics): (&FeatureJob, &Metrics)| json!({ "name": job.feature.name, "metrics": metrics_json(study, metrics) });
        object["features"] = study.features.iter().zip(&evaluation.features).map(feature).collect();
    }
    if let Some(failure) = entry.refusal() {
        object["infeasible"] = json!({ "status": failure.status, "reason": failure.reason });
    }
    object
}

/// Best place, how it was found, how flat it is, and all entries.
pub fn summary_json(results: &PlacementResults) -> Value {
    let study = &results.study;
    let [complete, pruned, infeasible] = verdicts(results);
    let best = results.best.as_ref().map(|best| {
        json!({
            "place": site_json(&best.site),
            "objective": best.value,
            "name": results.entries[best.entry].name,
            "found_by_refinement": if let Found::Refinement(index) = best.found { Some(index + 1) } else { None },
            "agreement": best.agreement.iter().map(|a| agreement_word(*a)).collect::<Vec<_>>(),
        })
    });
    let room = |room: &Room| {
        let i = room.coordinate;
        let end = match &room.end {
            End::Worse => "objective 5 % worse".to_string(),
            End::Bound => "bound".into(),
            End::Nowhere => "half a turn".into(),
            End::Infeasible(reason) => reason.clone(),
        };
        let sign = if room.direction > 0.0 { "+" } else { "-" };
        json!({ "direction": format!("{sign}{}", COORDINATES[i]), "distance": in_unit(i, room.distance), "unit": UNITS[i], "end": end })
    };
    json!({
        "schema": 3,
        "objective": study.objective.words(&study.machine),
        "sweep": {
            "places": results.cells.len(),
            "evaluated": complete,
            "pruned": pruned,
            "infeasible": infeasible,
            "places_between": results.gaps.sites.len(),
            "too_coarse_along": results.gaps.coarse.iter().map(|&i| COORDINATES[i]).collect::<Vec<_>>(),
        },
        "best": best,
        "flatness": results.flatness.iter().map(room).collect::<Vec<_>>(),
        "entries": results.entries.iter().map(|entry| entry_json(study, entry)).collect::<Vec<_>>(),
        "pareto_front": results.front.len(),
    })
}
