//! The Pareto front: places that no other beats in all metrics, each improved until none nearby beats it.
//!
//! Places seen by sweep and refinements lie near the front, not on it. A spread selection of them is therefore polished: the largest loss,
//! each metric relative to its range over the front, is minimised, so that all metrics improve together. Places that are not polished are
//! not shown, unless they dominate one that is.

use rayon::prelude::*;

use super::{
    PlacementStudy,
    evaluate::Evaluator,
    few::Glimpse,
    first_distinct,
    metric::{Metric, Metrics, Objective},
    polish::Steps,
    refine::{Refinement, Start, refine},
    site::Site,
    sweep::{Cell, is_neighbour},
};
use crate::{
    input::error::Result,
    work::{Event, Stage, Work, if_this_shard},
};

/// Largest number of places that are polished.
const POINTS: usize = 12;
/// Steps of polishing.
const POLISH: Steps = Steps { first: 0.1, last: 4e-3, bases: 10 };
/// Weight of the sum of all losses beside the largest loss.
const SUM: f64 = 1e-2;

/// Returns the number of searches that the front takes.
pub(super) fn search_count(study: &PlacementStudy) -> usize {
    let metrics = study.objective.pareto.len();
    if metrics == 0 { 0 } else { metrics * study.search.starts + POINTS }
}

/// Computes the Pareto front of the objective, sorted by its first metric, and polishes places spread over it. `Err` only from `work`.
pub(super) fn pareto_front(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    cells: &[Cell],
    refinements: &[Refinement],
    work: &Work,
) -> Result<Vec<(Site, Metrics)>> {
    let metrics = &study.objective.pareto;
    if !metrics.is_empty() {
        work.tell(Event::Stage(Stage { of: "searches along the front", items: search_count(study) }));
    }
    let found = work.summary("compromises", || compromises(evaluator, study, cells, refinements, work))?;
    let printed = |(number, end): (usize, &(Site, Metrics))| {
        let (site, outcome) = evaluator.examine_printed(&work.part("printed").shard(number), &end.0);
        outcome.map_or(*end, |evaluation| (site, evaluation.metrics))
    };
    let printed = found.par_iter().enumerate().map(printed).collect::<Vec<_>>();
    work.barrier()?;
    Ok(undominated(&printed, metrics))
}

/// Returns the polished places that no known one beats, as they were found. `Err` only from `work`.
fn compromises(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    cells: &[Cell],
    refinements: &[Refinement],
    work: &Work,
) -> Result<Vec<(Site, Metrics)>> {
    let metrics = &study.objective.pareto;
    let mut known: Vec<(Site, Metrics)> =
        cells.iter().filter_map(|cell| Some((cell.site, *cell.complete()?))).collect();
    known.extend(refinements.iter().flat_map(|refinement| &refinement.visited));
    add_glimpsed(evaluator, refinements.iter(), metrics, &mut known, &work.part("glimpsed by searches"))?;
    let seen = undominated(&known, metrics);
    let end = |(k, metric): (usize, &Metric)| {
        let work = work.part(&format!("end {k}")).shard(k);
        if_this_shard(refine_metric(evaluator, study, *metric, &seen, &work)).transpose()
    };
    let ends: Vec<Vec<Refinement>> =
        work.summary("ends", || metrics.par_iter().enumerate().filter_map(end).collect::<Result<_>>())?;
    work.barrier()?;
    known.extend(ends.iter().flatten().flat_map(|end| &end.visited));
    add_glimpsed(evaluator, ends.iter().flatten(), metrics, &mut known, &work.part("glimpsed by ends"))?;
    let rough = undominated(&known, metrics);
    let chosen = spread_selection(&rough, metrics);
    for _ in chosen.len()..POINTS.min(search_count(study)) {
        work.tell(Event::Computed(1));
    }
    let ranges = metric_ranges(&rough, metrics);
    let polished: Vec<Vec<(Site, Metrics)>> = chosen
        .par_iter()
        .enumerate()
        .map(|(number, &index)| {
            let work = work.part(&format!("compromise {index}")).shard(number);
            let better = polish_compromise(evaluator, study, &rough[index], &ranges, &work);
            work.tell(Event::Computed(1));
            better
        })
        .collect();
    work.barrier()?;
    let ends: Vec<(Site, Metrics)> = polished.iter().filter_map(|places| places.last().copied()).collect();
    known.extend(polished.into_iter().flatten());
    let front = undominated(&known, metrics);
    let shown = ends.iter().map(|end| *front.iter().find(|other| dominates(&other.1, &end.1, metrics)).unwrap_or(end));
    Ok(undominated(&shown.collect::<Vec<_>>(), metrics))
}

/// Evaluates the places that `refinements` glimpsed and that may lie on the front, and adds them to `known`. `Err` only from `work`.
fn add_glimpsed<'a>(
    evaluator: &Evaluator,
    refinements: impl Iterator<Item = &'a Refinement>,
    metrics: &[Metric],
    known: &mut Vec<(Site, Metrics)>,
    work: &Work,
) -> Result<()> {
    let is_known = |(site, _): &(Site, Metrics)| known.iter().any(|(other, _)| other == site);
    let glimpsed = refinements.flat_map(|refinement| &refinement.glimpsed).copied();
    let mut glimpsed: Vec<(Site, Metrics)> = glimpsed.filter(|place| !is_known(place)).collect();
    // A bound hides what it only seems to dominate: until none is left on the front.
    for round in 0.. {
        let mut unknown = undominated(&[&known[..], &glimpsed[..]].concat(), metrics);
        unknown.retain(|place| glimpsed.contains(place));
        if unknown.is_empty() {
            break;
        }
        let work = work.part(&format!("round {round}"));
        let exact = |(number, (site, _)): (usize, &(Site, Metrics))| {
            Some((*site, evaluator.evaluate_in_work(&work.shard(number), site).ok()?.metrics))
        };
        known.extend(unknown.par_iter().enumerate().filter_map(exact).collect::<Vec<_>>());
        work.barrier()?;
        glimpsed.retain(|(site, _)| !unknown.iter().any(|(other, _)| other == site));
    }
    Ok(())
}

/// Refines places of `front` for one metric alone, the best of them first and no two neighbours: the best of all may lie in another region
/// than the best that is known. Places that the sweep gives up are not on the front, so that they change no start. `Err` only from `work`.
fn refine_metric(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    metric: Metric,
    front: &[(Site, Metrics)],
    work: &Work,
) -> Result<Vec<Refinement>> {
    let objective = Objective { weights: vec![(metric, 1.0)], pareto: Vec::new() };
    let mut sorted: Vec<(f64, Site)> = front.iter().map(|(site, metrics)| (objective.value(metrics), *site)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let sorted = sorted.into_iter().map(|(_, site)| (Start::Sweep, site));
    let starts = first_distinct(sorted, study.search.starts, |(_, a), (_, b)| is_neighbour(study, a, b));
    work.tell(Event::Computed(study.search.starts - starts.len()));
    refine(evaluator, study, &objective, &starts, work)
}

/// Returns the cost of each of `metrics`, smaller is better; infinite where a value is missing.
fn metric_costs(metrics: &[Metric], values: &Metrics) -> Vec<f64> {
    metrics.iter().map(|metric| values.get(*metric).map_or(f64::INFINITY, |value| metric.cost(value))).collect()
}

/// Returns the range of each metric over `front`; 1 where it has none.
fn metric_ranges(front: &[(Site, Metrics)], metrics: &[Metric]) -> Vec<f64> {
    let costs: Vec<Vec<f64>> = front.iter().map(|(_, values)| metric_costs(metrics, values)).collect();
    let range = |k: usize| {
        let (low, high) = costs.iter().fold((f64::MAX, f64::MIN), |(low, high), c| (low.min(c[k]), high.max(c[k])));
        if high > low { high - low } else { 1.0 }
    };
    (0..metrics.len()).map(range).collect()
}

/// Returns the indices of at most [`POINTS`] places of `front`: those best in one metric, then always the one farthest from those chosen.
fn spread_selection(front: &[(Site, Metrics)], metrics: &[Metric]) -> Vec<usize> {
    if front.len() <= POINTS {
        return (0..front.len()).collect();
    }
    let ranges = metric_ranges(front, metrics);
    let scaled = |place: &(Site, Metrics)| -> Vec<f64> {
        metric_costs(metrics, &place.1).iter().zip(&ranges).map(|(cost, range)| cost / range).collect()
    };
    let costs: Vec<Vec<f64>> = front.iter().map(scaled).collect();
    let distance = |a: usize, b: usize| costs[a].iter().zip(&costs[b]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let best_in = |k: usize| (0..costs.len()).min_by(|&a, &b| costs[a][k].total_cmp(&costs[b][k]));
    let mut chosen: Vec<usize> = (0..metrics.len()).filter_map(best_in).collect();
    chosen.sort_unstable();
    chosen.dedup();
    let mut nearest: Vec<f64> =
        (0..costs.len()).map(|i| chosen.iter().map(|&c| distance(i, c)).fold(f64::MAX, f64::min)).collect();
    while chosen.len() < POINTS {
        let Some(next) = (0..costs.len()).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]).then(b.cmp(&a))) else {
            break;
        };
        if nearest[next] <= 0.0 {
            break;
        }
        chosen.push(next);
        nearest.iter_mut().enumerate().for_each(|(i, near)| *near = near.min(distance(i, next)));
    }
    chosen.sort_unstable();
    chosen
}

/// Polishes `start`; returns it and ever better places nearby, of which the last is better in all metrics where such a one exists.
fn polish_compromise(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    start: &(Site, Metrics),
    ranges: &[f64],
    work: &Work,
) -> Vec<(Site, Metrics)> {
    let metrics = &study.objective.pareto;
    let start_costs = metric_costs(metrics, &start.1);
    let loss = |values: &Metrics| {
        let losses = metric_costs(metrics, values)
            .into_iter()
            .zip(&start_costs)
            .zip(ranges)
            .map(|((cost, start_costs), range)| (cost - start_costs) / range);
        let losses: Vec<f64> = losses.collect();
        losses.iter().copied().fold(f64::NEG_INFINITY, f64::max) + SUM * losses.iter().sum::<f64>()
    };
    let mut places = vec![*start];
    let mut glimpse = Glimpse::new(evaluator, work, &start.0, &loss);
    glimpse.polish((study, work), (start.0, 0.0), (POLISH, study.search.tolerance), |site, _, metrics| {
        places.push((site, metrics));
    });
    places
}

/// Returns whether `a` is no worse than `b` in every one of `metrics` and better in one; false where a value is missing.
pub fn dominates(a: &Metrics, b: &Metrics, metrics: &[Metric]) -> bool {
    let mut is_better = false;
    for metric in metrics {
        let (Some(a), Some(b)) = (a.get(*metric), b.get(*metric)) else { return false };
        match metric.cost(a).total_cmp(&metric.cost(b)) {
            std::cmp::Ordering::Greater => return false,
            std::cmp::Ordering::Less => is_better = true,
            std::cmp::Ordering::Equal => {}
        }
    }
    is_better
}

/// Returns the places that no other one dominates, sorted by the first metric; of equal ones the first.
pub fn undominated(places: &[(Site, Metrics)], metrics: &[Metric]) -> Vec<(Site, Metrics)> {
    if metrics.is_empty() {
        return Vec::new();
    }
    let mut sorted: Vec<(Vec<f64>, usize)> =
        places.iter().enumerate().map(|(index, (_, values))| (metric_costs(metrics, values), index)).collect();
    sorted.retain(|(costs, _)| costs.iter().all(|cost| cost.is_finite()));
    sorted.sort_by(|(a, i), (b, j)| {
        let by_cost = a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
        by_cost.unwrap_or(i.cmp(j))
    });
    // Sorted like this, a place can only be dominated by, or equal to, one before it.
    let mut front: Vec<(Vec<f64>, usize)> = Vec::new();
    for (costs, index) in sorted {
        let covered = |other: &(Vec<f64>, usize)| other.0.iter().zip(&costs).all(|(a, b)| a <= b);
        if !front.iter().any(covered) {
            front.push((costs, index));
        }
    }
    front.into_iter().map(|(_, index)| places[index]).collect()
}
