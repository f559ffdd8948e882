//! The Pareto front: the best compromises known, each led on to one that cannot be bettered nearby.
//!
//! What sweep and refinements happen to have seen lies near the front, not on it. Compromises spread along what they show
//! are therefore polished: the largest loss, each metric in its range over the front, is made small, so that all metrics
//! get better together. What is not polished is not shown, unless it dominates a place that is.

use rayon::prelude::*;

use super::{
    PlacementStudy,
    evaluate::Evaluator,
    metric::{Metric, Metrics, Objective},
    polish::{Steps, polish},
    refine::{Refinement, Start, refine},
    site::Site,
    sweep::Cell,
};
use crate::{
    input::error::Result,
    work::{Event, Work, this_shard},
};

/// Most compromises that are polished.
const POINTS: usize = 12;
/// Steps of polishing.
const POLISH: Steps = Steps { first: 0.1, last: 4e-3, bases: 10 };
/// What all losses together count beside the largest: a loss that is not the largest is still one.
const SUM: f64 = 1e-2;

/// Number of searches that a front takes.
pub(super) fn searches(study: &PlacementStudy) -> usize {
    let metrics = study.objective.pareto.len();
    if metrics == 0 { 0 } else { metrics + POINTS }
}

/// The best compromises between the metrics of the objective's front.
pub(super) fn front(
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
    let ends: Vec<Refinement> = metrics
        .par_iter()
        .enumerate()
        .filter_map(|(k, metric)| {
            let work = work.part(&format!("end {k}")).shard(k);
            this_shard(end(evaluator, study, *metric, &known, &work)).map(Option::flatten).transpose()
        })
        .collect::<Result<_>>()?;
    work.barrier()?;
    known.extend(ends.iter().flat_map(|end| &end.visited));
    let rough = undominated(&known, metrics);
    let chosen = spread(&rough, metrics);
    for _ in chosen.len()..POINTS.min(searches(study)) {
        work.tell(Event::Computed(1));
    }
    let ranges = ranges(&rough, metrics);
    let polished: Vec<Vec<(Site, Metrics)>> = chosen
        .par_iter()
        .enumerate()
        .map(|(number, &index)| {
            let work = work.part(&format!("compromise {index}")).shard(number);
            let better = better(evaluator, study, &rough[index], &ranges, &work);
            work.tell(Event::Computed(1));
            better
        })
        .collect();
    work.barrier()?;
    let ends: Vec<(Site, Metrics)> = polished.iter().filter_map(|found| found.last().copied()).collect();
    known.extend(polished.into_iter().flatten());
    let best = undominated(&known, metrics);
    let shown = ends.iter().map(|end| *best.iter().find(|other| dominates(&other.1, &end.1, metrics)).unwrap_or(end));
    Ok(undominated(&shown.collect::<Vec<_>>(), metrics))
}

/// The best known place for one metric, refined for it alone.
fn end(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    metric: Metric,
    known: &[(Site, Metrics)],
    work: &Work,
) -> Result<Option<Refinement>> {
    let objective = Objective { weights: vec![(metric, 1.0)], pareto: Vec::new() };
    let values = known.iter().map(|(site, metrics)| (objective.value(metrics), *site));
    let Some((_, start)) = values.min_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(None) };
    Ok(refine(evaluator, study, &objective, &[(Start::Sweep, start)], work)?.pop())
}

fn costs(metrics: &[Metric], values: &Metrics) -> Vec<f64> {
    metrics.iter().map(|metric| values.get(*metric).map_or(f64::INFINITY, |value| metric.cost(value))).collect()
}

/// Range of each metric over `front`; 1 where it has none.
fn ranges(front: &[(Site, Metrics)], metrics: &[Metric]) -> Vec<f64> {
    let all: Vec<Vec<f64>> = front.iter().map(|(_, values)| costs(metrics, values)).collect();
    let range = |k: usize| {
        let (low, high) = all.iter().fold((f64::MAX, f64::MIN), |(low, high), c| (low.min(c[k]), high.max(c[k])));
        if high > low { high - low } else { 1.0 }
    };
    (0..metrics.len()).map(range).collect()
}

/// At most [`POINTS`] places of `front`, in its order: those best in one metric, then always the one farthest from those
/// chosen.
fn spread(front: &[(Site, Metrics)], metrics: &[Metric]) -> Vec<usize> {
    if front.len() <= POINTS {
        return (0..front.len()).collect();
    }
    let ranges = ranges(front, metrics);
    let scaled = |place: &(Site, Metrics)| -> Vec<f64> {
        costs(metrics, &place.1).iter().zip(&ranges).map(|(cost, range)| cost / range).collect()
    };
    let all: Vec<Vec<f64>> = front.iter().map(scaled).collect();
    let distance = |a: usize, b: usize| all[a].iter().zip(&all[b]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let least = |k: usize| (0..all.len()).min_by(|&a, &b| all[a][k].total_cmp(&all[b][k]));
    let mut chosen: Vec<usize> = (0..metrics.len()).filter_map(least).collect();
    chosen.sort_unstable();
    chosen.dedup();
    let mut nearest: Vec<f64> =
        (0..all.len()).map(|i| chosen.iter().map(|&c| distance(i, c)).fold(f64::MAX, f64::min)).collect();
    while chosen.len() < POINTS {
        let Some(next) = (0..all.len()).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]).then(b.cmp(&a))) else {
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

/// `start` and ever better places nearby, the last of them better in all metrics as far as there is such a one.
fn better(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    start: &(Site, Metrics),
    ranges: &[f64],
    work: &Work,
) -> Vec<(Site, Metrics)> {
    let metrics = &study.objective.pareto;
    let from = costs(metrics, &start.1);
    let loss = |values: &Metrics| {
        let losses = costs(metrics, values)
            .into_iter()
            .zip(&from)
            .zip(ranges)
            .map(|((cost, from), range)| (cost - from) / range);
        let losses: Vec<f64> = losses.collect();
        losses.iter().copied().fold(f64::NEG_INFINITY, f64::max) + SUM * losses.iter().sum::<f64>()
    };
    let mut found = vec![*start];
    polish(study, (start.0, 0.0), POLISH, f64::NEG_INFINITY, |site, below| {
        let Some(evaluation) = evaluator.kept_below(work, site, &loss, below) else { return f64::INFINITY };
        let value = loss(&evaluation.metrics);
        if value < below {
            found.push((*site, evaluation.metrics));
        }
        value
    });
    found
}

/// Whether `a` is no worse than `b` in every one of `metrics` and better in one. False where a value is missing.
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

/// The places that no other one dominates, by the first metric; of equal ones the first.
pub fn undominated(places: &[(Site, Metrics)], metrics: &[Metric]) -> Vec<(Site, Metrics)> {
    if metrics.is_empty() {
        return Vec::new();
    }
    let mut sorted: Vec<(Vec<f64>, usize)> =
        places.iter().enumerate().map(|(index, (_, values))| (costs(metrics, values), index)).collect();
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
