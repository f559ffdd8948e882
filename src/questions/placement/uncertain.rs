//! How sure the ranking is where inputs are uncertain: distributions at named and found places, in the same draws at all of them.

use rayon::prelude::*;
use serde::Serialize;

use super::{
    FeatureJob, PlacementStudy,
    evaluate::Evaluator,
    metric::{Metric, Metrics},
    outcome::{Entry, EntryEvaluators},
    turned::Setup,
};
use crate::{
    FOR_PAGES,
    compensation::TaskPoint,
    input::error::Result,
    process::uncertainty::{DrawnForceAt, P95, quantile},
    simulation::{
        Failure, ROUNDING_MM,
        spread::{DrawnMachines, share_within},
        spread_along::{
            ALIKE, EachPart, LargestBoth, PathSpread, SpreadPart, SpreadPath, numbers_of_passes, parts_of,
            share_larger, whole,
        },
        tasks::drawn_forces_at,
    },
    work::{Event, Stage, Work, if_this_shard},
};

/// How sure the numbers of a place are, at the corner of its allowance where the worst deflection is, and its rank among all that can be cut.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlaceSpread {
    /// Distributions of the largest distance from the paths of all features, without and with compensation.
    pub largest: PathSpread,
    /// Probability that no other place has a smaller one without compensation; places within 0.5 % of one another share it.
    pub best: f64,
    /// Probability that it is larger here by more than 0.5 %, without compensation, than at the place within the bounds with the smallest 95 % quantile.
    pub worse_than_robust: f64,
}

/// Adds to each of `entries` that can be cut how sure it is. Does nothing where inputs are taken as exact.
///
/// # Errors
/// Of `work`.
pub(super) fn add_spread(
    evaluators: &EntryEvaluators,
    study: &PlacementStudy,
    entries: &mut [Entry],
    work: &Work,
) -> Result<()> {
    // Pages compute with nominal numbers.
    if FOR_PAGES {
        return Ok(());
    }
    let drawn = study.features.iter().map(FeatureJob::drawn);
    let Some(drawn) = drawn.collect::<Result<Option<Vec<_>>>>()? else { return Ok(()) };
    let can_be_cut: Vec<usize> = (0..entries.len()).filter(|own| entries[*own].feasible().is_some()).collect();
    let points: usize = study.features.iter().map(|job| job.feature.path.len()).sum();
    work.tell(Event::Stage(Stage { of: "points of uncertain places", items: can_be_cut.len() * points }));
    let found = can_be_cut.par_iter().enumerate().filter_map(|(number, own)| {
        let work = work.shard(number).part("uncertain").part(&number.to_string());
        let Entry { name, found, site, .. } = &entries[*own];
        let evaluator = evaluators.of(name, *found);
        let worst = entries[*own].feasible().and_then(|own| own.worst_corner);
        let setup = evaluator.clamped_setups(&evaluator.setup(site)).swap_remove(worst.map_or(0, |corner| 1 + corner));
        if_this_shard(spread_at(evaluator, &drawn, &setup, &work)).transpose()
    });
    let found: Vec<Option<(PathSpread, LargestBoth)>> = found.collect::<Result<_>>()?;
    work.barrier()?;
    let known: Vec<(usize, (PathSpread, LargestBoth))> =
        can_be_cut.into_iter().zip(found).filter_map(|(own, found)| Some((own, found?))).collect();
    // Without a 95 % quantile a place is not the best, however it is where it stands.
    let p95: Vec<f64> = known.iter().map(|(_, own)| own.0.plain.spread.p95_mm.unwrap_or(f64::INFINITY)).collect();
    let is_inside = |place: &usize| study.bounds.inside(&entries[known[*place].0].site).is_some();
    let robust = (0..known.len()).filter(is_inside).min_by(|a, b| p95[*a].total_cmp(&p95[*b]));
    let sizes: Vec<&[f64]> = known.iter().map(|(_, (_, [plain, _]))| plain.sizes()).collect();
    let judged: Vec<usize> = (0..known.len()).filter(|place| p95[*place].is_finite()).collect();
    let mut best = vec![0.0; known.len()];
    let shares = shares_best(&judged.iter().map(|place| sizes[*place]).collect::<Vec<_>>());
    judged.iter().zip(shares).for_each(|(place, share)| best[*place] = share);
    let spread = |place: usize| PlaceSpread {
        largest: known[place].1.0.clone(),
        best: best[place],
        worse_than_robust: robust.map_or(0.0, |robust| share_larger(sizes[place], sizes[robust], 0.0)),
    };
    for (place, (own, _)) in known.iter().enumerate() {
        entries[*own].spread = Some(spread(place));
    }
    Ok(())
}

/// Writes the metrics of the distribution without compensation at `setup`, as estimated, over the points of the levels before `level`, into `metrics`. `Err`
/// says why there is none.
pub(super) fn write_metrics(
    evaluator: &Evaluator,
    setup: &Setup,
    level: usize,
    metrics: &mut Metrics,
) -> std::result::Result<(), Failure> {
    let none = |reason: String| Failure { status: "no_equilibrium".into(), reason };
    let drawn = evaluator.drawn.as_ref().map_err(|problem| none(problem.clone()))?.iter().flatten();
    let (jobs, mut largest) = (&evaluator.study.features, LargestBoth::default());
    let all_passes = passes(evaluator);
    for (f, (job, drawn)) in jobs.iter().zip(drawn).enumerate() {
        let mut points: Vec<usize> = evaluator.features[f].levels.iter().take(level).flatten().copied().collect();
        points.sort_unstable();
        let all = evaluator.tasks(setup, f);
        let tasks: Vec<TaskPoint> = points.iter().map(|k| all[*k]).collect();
        let of_all = drawn_forces(evaluator, drawn, setup, f);
        let forces: Vec<DrawnForceAt> = points.iter().filter_map(|k| of_all.get(*k)).copied().collect();
        let passes: Vec<u32> = points.iter().map(|k| all_passes[f][*k]).collect();
        let path = SpreadPath { passes: &passes, compensates: false, ..job.spread(&setup.site, drawn) };
        let mut add = |part: &SpreadPart<'_>| path.solve_part(part, 1, &Work::default(), &mut largest).map(drop);
        parts_of(job.machine(), &tasks, &forces)(&mut add).map_err(|error| none(error.to_string()))?;
    }
    let sizes = largest[0].sizes();
    // Infinite where too many draws have no equilibrium: such a place is the worst of all.
    metrics.set(Metric::P95Deflection, quantile(&mut sizes.to_vec(), P95));
    metrics.set(Metric::WithinProbability, share_within(sizes, jobs[0].feature.tolerance_mm));
    Ok(())
}

/// Returns the numbers of the passes of all features, one after another.
fn passes(evaluator: &Evaluator) -> Vec<Vec<u32>> {
    let mut next = 0;
    let of = |job: &FeatureJob| {
        let own = numbers_of_passes(next, job.feature.path.points().iter().map(|own| own.cutting));
        next = own.last().map_or(next, |last| last + 1);
        own
    };
    evaluator.study.features.iter().map(of).collect()
}

/// Returns what draws change of the force at each point of feature `f` at `setup`.
fn drawn_forces(evaluator: &Evaluator, drawn: &DrawnMachines, setup: &Setup, f: usize) -> Vec<DrawnForceAt> {
    let job = &evaluator.study.features[f];
    let placement = setup.site.placement(job.feature.reference);
    let path = evaluator.path_at(setup, f);
    drawn_forces_at(&drawn.uncertainty, job.machine(), &placement, &path, job.components.as_ref())
}

/// Returns the distributions at `setup`, and the largest distances in the draws; `None` where they are of no point.
fn spread_at(
    evaluator: &Evaluator,
    drawn: &[DrawnMachines],
    setup: &Setup,
    work: &Work,
) -> Result<Option<(PathSpread, LargestBoth)>> {
    let jobs = &evaluator.study.features;
    let tasks: Vec<Vec<TaskPoint>> = (0..jobs.len()).map(|f| evaluator.tasks(setup, f)).collect();
    let counts: Vec<_> = evaluator.features.iter().map(|own| |k: usize| own.is_counted[k]).collect();
    let all_passes = passes(evaluator);
    let path =
        |f: usize| SpreadPath { passes: &all_passes[f], counts: &counts[f], ..jobs[f].spread(&setup.site, &drawn[f]) };
    let paths: Vec<SpreadPath<'_>> = (0..jobs.len()).map(path).collect();
    let forces: Vec<_> = drawn.iter().enumerate().map(|(f, drawn)| drawn_forces(evaluator, drawn, setup, f)).collect();
    let with_forces = jobs.iter().zip(tasks.iter().zip(&forces));
    let each_part: Vec<_> = with_forces.map(|(job, (tasks, forces))| parts_of(job.machine(), tasks, forces)).collect();
    let mut largest = LargestBoth::default();
    for (f, (path, each_part)) in paths.iter().zip(&each_part).enumerate() {
        let work = work.part(&format!("feature {f}"));
        each_part(&mut |part| path.solve_part(part, 1, &work, &mut largest).map(drop))?;
    }
    let each_part = each_part.iter().map(|own| &**own as &EachPart<'_>);
    let found = whole(&paths.iter().zip(each_part).collect::<Vec<_>>(), &largest, work)?;
    Ok(found.map(|found| (found, largest)))
}

/// Returns for each place the share of the draws in which its size is the smallest of all; places that are alike share a draw.
fn shares_best(sizes: &[&[f64]]) -> Vec<f64> {
    let draws = sizes.iter().map(|own| own.len()).min().unwrap_or(0);
    let mut shares = vec![0.0; sizes.len()];
    for draw in 0..draws {
        let least = sizes.iter().map(|own| own[draw]).fold(f64::INFINITY, f64::min);
        let is_least = |own: &&[f64]| own[draw] <= least * (1.0 + ALIKE) + ROUNDING_MM;
        let winners = sizes.iter().filter(|own| is_least(own)).count();
        for (share, own) in shares.iter_mut().zip(sizes) {
            *share += if is_least(own) { 1.0 / (winners * draws) as f64 } else { 0.0 };
        }
    }
    shares
}
