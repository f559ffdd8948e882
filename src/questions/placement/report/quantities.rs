//! Quantities and tables of a placement study, and its summary as JSON.

use serde_json::{Map, Value, json};

use crate::{
    answer::{Quantity, QuantityTable, status_cells},
    files::exchange::{self, Column, Row, Table, counts, numbers, texts},
    page::Better::{Larger, Neither, Smaller},
    questions::{
        placement::{
            Agreement, COORDINATES, Cell, End, Entry, FeatureJob, Margin, Metric, Metrics, Origin, PlaceOutcome,
            PlacementResults, PlacementStudy, Refinement, Site, Start, UNITS, site::in_unit,
        },
        spread_report::{self, SpreadCounts},
    },
    simulation::{Failure, SOLVED},
};

/// Returns `value` if it is finite; an infeasible place has an infinite objective.
fn if_finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

/// Makes the quantity of the objective, which `value` reads from an `E`; no value where that is `None` or not finite.
fn objective_from<E: 'static>(value: impl Fn(&E) -> Option<f64> + Send + Sync + 'static) -> Quantity<E> {
    Quantity::computed("objective".into(), "objective".into(), Smaller, move |row| if_finite(value(row)?))
}

/// Makes the quantity of a metric, which `metrics` reads from an `E`; no value where that is `None`, or the metric is missing or not finite.
fn metric_from<E: 'static>(study: &PlacementStudy, metric: Metric, metrics: fn(&E) -> Option<&Metrics>) -> Quantity<E> {
    let (name, label) = (metric.column(&study.machine), metric.text(&study.machine).into());
    let better = if metric.larger_is_better() { Larger } else { Smaller };
    Quantity::computed(name, label, better, move |row| if_finite(metrics(row)?.get(metric)?))
}

/// Makes the quantity of a metric of named and found places.
pub(super) fn entry_metric(study: &PlacementStudy, metric: Metric) -> Quantity<Entry> {
    metric_from(study, metric, |entry| entry.outcome.as_ref().ok().map(|evaluation| &evaluation.metrics))
}

/// Returns the metrics that the study can have: those of the correction within limits only if a feature has limits.
pub(super) fn available_metrics(study: &PlacementStudy) -> impl Iterator<Item = Metric> {
    let has_limits = study.has_limits();
    let exists = |metric: &Metric| metric.exists_on(&study.machine) && study.objective.has(*metric);
    let has_cell = study.has_cell();
    let asked = Metric::ALL.into_iter().filter(exists).filter(move |metric| has_limits || !metric.is_bounded());
    asked.filter(move |metric| has_cell || *metric != Metric::LeastClearance)
}

/// Makes the quantities of named and found places: objective and `metrics`.
pub(super) fn entry_values(study: &PlacementStudy, metrics: impl IntoIterator<Item = Metric>) -> Vec<Quantity<Entry>> {
    let metrics = metrics.into_iter().map(|metric| entry_metric(study, metric));
    std::iter::once(objective_from(|entry: &Entry| Some(entry.value))).chain(metrics).collect()
}

/// Makes the quantities of the sweep: objective, the metrics that a search computes anyway, and those of the objective.
pub(super) fn cell_values(study: &PlacementStudy) -> Vec<Quantity<Cell>> {
    let needed = study.objective.metrics();
    let free = [Metric::WorstDeflection, Metric::RmsDeflection, Metric::ShareWithin];
    let metrics = Metric::ALL.into_iter().filter(|metric| needed.contains(metric) || free.contains(metric));
    let metrics = metrics.map(|metric| metric_from(study, metric, Cell::metrics));
    let objective = study.objective.clone();
    std::iter::once(objective_from(move |cell: &Cell| Some(objective.value(cell.metrics()?)))).chain(metrics).collect()
}

/// Makes the quantities of how sure named and found places are; none where inputs are taken as exact.
pub(super) fn spread_values(study: &PlacementStudy) -> Vec<Quantity<Entry>> {
    let p95 = "95 % quantile of the worst deflection";
    let residual = "95 % quantile of the largest distance with compensation";
    let within = "probability that all is within tolerance with compensation";
    let all = [
        Quantity::new("worst_deflection_p95_mm", p95, Smaller, |entry: &Entry| {
            entry.spread.as_ref()?.largest.plain.spread.p95_mm
        }),
        Quantity::new("compensated_p95_mm", residual, Smaller, |entry: &Entry| {
            entry.spread.as_ref()?.largest.compensated.as_ref()?.spread.p95_mm
        }),
        Quantity::new("compensated_within_tolerance_probability", within, Larger, |entry: &Entry| {
            entry.spread.as_ref()?.largest.compensated.as_ref()?.spread.within_tolerance
        }),
        Quantity::new("best_probability", "probability of being the best", Larger, |entry: &Entry| {
            Some(entry.spread.as_ref()?.best)
        }),
    ];
    let judged = all.into_iter().filter(|own| !study.has_limits() || !own.name.starts_with("compensated"));
    if study.features[0].tracked.uncertainty.is_some() { judged.collect() } else { Vec::new() }
}

/// Returns the columns of the coordinates, their names after `lead`.
fn coordinate_columns(lead: &str) -> Vec<Column> {
    numbers(COORDINATES.iter().zip(UNITS).map(|(name, unit)| format!("{lead}{name}_{unit}")))
}

/// Returns the cells of the coordinates.
fn coordinate_cells(site: &Site) -> impl Iterator<Item = exchange::Cell> {
    exchange::cells(site.shown())
}

/// Makes a table of the quantities of each of `rows` behind its leading cells.
fn table_of<'a, E: 'static>(
    lead: Vec<Column>,
    quantities: Vec<Quantity<E>>,
    rows: impl IntoIterator<Item = (Row, &'a E)>,
) -> Table {
    let rows = rows.into_iter().map(|(lead, row)| (lead, Ok(row)));
    QuantityTable::without_status(lead, quantities).table(rows)
}

/// Makes the table of named and found places, ranked, with all metrics and the worst deflection of each feature. Those that cannot be cut
/// come last, with `status` and `reason`; beyond the workspace box (`outside_workspace`) the numbers say what would happen there.
pub fn candidates_table(study: &PlacementStudy, entries: &[Entry]) -> Table {
    let mut evaluated = entries.iter().filter_map(|entry| entry.outcome.as_ref().ok());
    let has_margin = evaluated.any(|evaluation| evaluation.metrics.get(Metric::ForceMargin).is_some());
    let metrics = available_metrics(study).filter(|metric| has_margin || *metric != Metric::ForceMargin);
    let mut quantities = entry_values(study, metrics);
    let of_feature = |name: String, get: fn(&Entry, usize) -> Option<f64>, f: usize| {
        Quantity::computed(name, String::new(), Neither, move |entry: &Entry| if_finite(get(entry, f)?))
    };
    let named = || study.features.iter().map(|job| (job, &job.feature.name)).enumerate();
    if study.features.len() > 1 {
        let worst = |entry: &Entry, f: usize| entry.outcome.as_ref().ok()?.features[f].get(Metric::WorstDeflection);
        quantities.extend(named().map(|(f, (_, name))| of_feature(format!("worst_deflection_{name}_mm"), worst, f)));
    }
    let gamma = |entry: &Entry, f: usize| entry.gammas[f].map(f64::to_degrees);
    let with_gamma = named().filter(|(_, (job, _))| job.gamma_search.is_some());
    quantities.extend(with_gamma.map(|(f, (_, name))| of_feature(format!("gamma_{name}_deg"), gamma, f)));
    quantities.extend(spread_values(study));
    quantities.push(Quantity::text("correction_within_limits", |entry| {
        entry.ok().and_then(|entry| entry.outcome.as_ref().ok()?.not_corrected.clone()).into()
    }));
    let lead = [counts(["rank"]), texts(["name", "found"]), coordinate_columns(""), texts(["status", "reason"])];
    let row = |(rank, entry): (usize, &'_ Entry)| {
        let mut row: Row = vec![entry.feasible().map(|_| rank + 1).into()];
        row.extend([entry.name.as_str().into(), entry.found.label().into()]);
        row.extend(coordinate_cells(&entry.site));
        row.extend(status_cells(entry.refusal().map_or(Ok(()), Err)));
        row
    };
    table_of(lead.concat(), quantities, entries.iter().enumerate().map(|(rank, entry)| (row((rank, entry)), entry)))
}

/// Makes the table of the sweep, one row per place in grid order: `solved`, `pruned` (its numbers are bounds), or why it cannot be cut.
pub fn sweep_table(results: &PlacementResults) -> Table {
    let mut ranks = vec![None; results.cells.len()];
    for (rank, &index) in results.ranking.iter().enumerate() {
        ranks[index] = results.cells[index].complete().map(|_| rank + 1);
    }
    let row = |(cell, rank): (&'_ Cell, Option<usize>)| {
        let reason = match &cell.verdict {
            PlaceOutcome::Complete(_) => "",
            PlaceOutcome::Pruned(_) => "cannot be the best place",
            PlaceOutcome::Infeasible(Failure { reason, .. }) => reason,
        };
        coordinate_cells(&cell.site).chain([cell_status(cell).into(), reason.into(), rank.into()]).collect()
    };
    let lead = [coordinate_columns(""), texts(["status", "reason"]), counts(["rank"])].concat();
    let rows = results.cells.iter().zip(ranks).map(|(cell, rank)| (row((cell, rank)), cell));
    table_of(lead, cell_values(&results.study), rows)
}

/// Returns the status word of a cell of the sweep.
pub(super) fn cell_status(cell: &Cell) -> &str {
    match &cell.verdict {
        PlaceOutcome::Complete(_) => SOLVED,
        PlaceOutcome::Pruned(_) => "pruned",
        PlaceOutcome::Infeasible(failure) => &failure.status,
    }
}

/// Returns the word of an agreement in tables.
fn agreement_word(agreement: Agreement) -> &'static str {
    match agreement {
        Agreement::Same => "same",
        Agreement::Elsewhere => "same_value_elsewhere",
        Agreement::Worse => "worse",
    }
}

/// Makes the table of refinements, one row each: start, end, objective, and how it compares with the best place.
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
    let row = |(index, refinement): (usize, &Refinement)| {
        let agreement = results.best.as_ref().map(|best| agreement_word(best.agreement[index]));
        let mut row: Row = vec![(index + 1).into(), start_label(&results.study, refinement.from).into()];
        row.extend(coordinate_cells(&refinement.start).chain(coordinate_cells(&refinement.site)));
        row.push(if_finite(refinement.value).into());
        row.extend([refinement.iterations.into(), refinement.continued.into(), refinement.visited.len().into()]);
        row.extend([refinement.is_converged.to_string().into(), agreement.into()]);
        row
    };
    Table::new(columns.concat(), results.refinements.iter().enumerate().map(row))
}

/// Makes the table of the Pareto front, sorted by its first metric.
pub(super) fn front_table(results: &PlacementResults) -> Table {
    let study = &results.study;
    let quantity_of = |metric: &Metric| metric_from(study, *metric, |(_, values): &(Site, Metrics)| Some(values));
    let rows = results.front.iter().map(|place| (coordinate_cells(&place.0).collect(), place));
    table_of(coordinate_columns(""), study.objective.pareto.iter().map(quantity_of).collect(), rows)
}

/// Describes the start of a refinement for tables.
fn start_label(study: &PlacementStudy, start: Start) -> &str {
    match start {
        Start::Sweep => "sweep",
        Start::Between => "between places of the sweep",
        Start::Named(index) => study.candidates.get(index).map_or("", |candidate| &candidate.name),
    }
}

/// Returns how many places of the sweep were evaluated on all points, pruned, and infeasible.
pub(super) fn verdict_counts(results: &PlacementResults) -> [usize; 3] {
    let mut counts = [0; 3];
    for cell in &results.cells {
        counts[match cell.verdict {
            PlaceOutcome::Complete(_) => 0,
            PlaceOutcome::Pruned(_) => 1,
            PlaceOutcome::Infeasible(_) => 2,
        }] += 1;
    }
    counts
}

/// Returns a place as JSON, its coordinates in mm and degrees.
fn site_json(site: &Site) -> Value {
    let coordinates = COORDINATES.iter().zip(UNITS).zip(site.shown());
    coordinates.map(|((name, unit), value)| (format!("{name}_{unit}"), json!(value))).collect::<Map<_, _>>().into()
}

/// Returns the metrics that exist as JSON.
fn metrics_json(study: &PlacementStudy, metrics: &Metrics) -> Value {
    let existing = Metric::ALL.into_iter().filter_map(|metric| {
        let value = metrics.get(metric).filter(|value| value.is_finite())?;
        Some((metric.column(&study.machine), json!(value)))
    });
    Value::Object(existing.collect::<Map<_, _>>())
}

/// Returns a named or found place with its metrics, or why it is infeasible, as JSON.
fn entry_json(study: &PlacementStudy, entry: &Entry) -> Value {
    let mut object = json!({ "name": entry.name, "found": entry.found.label(), "place": site_json(&entry.site) });
    if let Ok(evaluation) = &entry.outcome {
        object["objective"] = json!(entry.value);
        object["metrics"] = metrics_json(study, &evaluation.metrics);
        let feature = |(job, metrics): (&FeatureJob, &Metrics)| json!({ "name": job.feature.name, "metrics": metrics_json(study, metrics) });
        object["features"] = study.features.iter().zip(&evaluation.features).map(feature).collect();
    }
    if let Some(spread) = &entry.spread {
        object["spread"] = json!(spread);
    }
    if let Some(failure) = entry.refusal() {
        object["infeasible"] = json!({ "status": failure.status, "reason": failure.reason });
    }
    object
}

/// Returns the summary as JSON: best place, how it was found, its margins, and all entries.
pub fn summary_json(results: &PlacementResults) -> Value {
    let study = &results.study;
    let [complete, pruned, infeasible] = verdict_counts(results);
    let best = results.best.as_ref().map(|best| {
        json!({
            "place": site_json(&best.site),
            "objective": best.value,
            "name": results.entries[best.entry].name,
            "found_by_refinement": if let Origin::Refinement(index) = best.found { Some(index + 1) } else { None },
            "agreement": best.agreement.iter().map(|a| agreement_word(*a)).collect::<Vec<_>>(),
        })
    });
    let margin_json = |margin: &Margin| {
        let i = margin.coordinate;
        let end = match &margin.end {
            End::Worse => "objective 5 % worse".to_string(),
            End::Bound => "bound".into(),
            End::Nowhere => "half a turn".into(),
            End::Infeasible(reason) => reason.clone(),
        };
        let sign = if margin.direction > 0.0 { "+" } else { "-" };
        json!({ "direction": format!("{sign}{}", COORDINATES[i]), "distance": in_unit(i, margin.distance), "unit": UNITS[i], "end": end })
    };
    let mut summary = json!({
        "schema": 3,
        "objective": study.objective.text(&study.machine),
        "sweep": {
            "places": results.cells.len(),
            "evaluated": complete,
            "pruned": pruned,
            "infeasible": infeasible,
            "places_between": results.gaps.sites.len(),
            "too_coarse_along": results.gaps.coarse.iter().map(|&i| COORDINATES[i]).collect::<Vec<_>>(),
        },
        "best": best,
        "flatness": results.flatness.iter().map(margin_json).collect::<Vec<_>>(),
        "entries": results.entries.iter().map(|entry| entry_json(study, entry)).collect::<Vec<_>>(),
        "pareto_front": results.front.len(),
    });
    if let Some(uncertainty) = &study.features[0].tracked.uncertainty {
        summary["uncertainty"] = spread_report::json(uncertainty, &spread_counts(results));
    }
    summary
}

/// Counts the distributions at all places.
pub(super) fn spread_counts(results: &PlacementResults) -> SpreadCounts {
    let mut counts = SpreadCounts::default();
    let spreads = results.entries.iter().filter_map(|entry| entry.spread.as_ref());
    spreads.for_each(|spread| counts.add(&spread.largest.compensated.as_ref().unwrap_or(&spread.largest.plain).spread));
    counts
}
