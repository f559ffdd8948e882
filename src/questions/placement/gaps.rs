//! Search for places between the grid points of the sweep where the workpiece fits.
//!
//! The ends of forbidden boxes and of the workspace box are known. Along x, y and z the places at which a face of the workpiece meets one
//! of theirs divide the bounds into intervals; the middle of each interval without a grid point is tried. For a workpiece that is not
//! rotated, or by right angles, this finds every free region, however narrow.
//!
//! Limits of the machine have no such places. Where few grid points can be cut, searches start from those that come nearest, and minimise
//! by how much limits are exceeded.

use rayon::prelude::*;

use serde::{Deserialize, Serialize};

use super::{
    PlacementStudy,
    evaluate::{Evaluator, NOT_RIGID},
    first_distinct,
    polish::{Steps, pattern_search},
    site::Site,
    sweep::{Cell, PlaceOutcome, is_neighbour},
    turned::Setup,
    walk::UNMEASURED,
};
use crate::{
    input::error::Result,
    process::Extent,
    work::{Event, Stage, Work},
};

/// Places found between the grid points of the sweep.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Gaps {
    /// The best places where the workpiece can be cut, best first: as many as may be starts of searches, or all.
    pub sites: Vec<Site>,
    /// Coordinates along which some free region is narrower than a step of the sweep.
    pub coarse: Vec<usize>,
}

/// Largest number of middles of intervals that are evaluated.
const TRIED: usize = 48;
/// Largest number of searches for a place within limits.
const SEARCHES: usize = 12;
/// Searches run where fewer than one in so many grid points can be cut.
const FEW: usize = 4;
/// Steps of a search for a place within limits.
const STEPS: Steps = Steps { first: 1.0, last: 1e-7, bases: 0 };
/// Narrowest interval that is considered, mm.
const NARROWEST: f64 = 1e-6;
/// Largest number of middles of intervals that are checked against the boxes.
const MIDDLES: usize = 50_000;
/// Largest number of grid points that are ranked by their violation.
const RANKED: usize = 1000;

/// Searches for places between the grid points of the sweep where the workpiece fits. `Err` only from `work`.
pub(super) fn find_gaps(evaluator: &Evaluator, study: &PlacementStudy, cells: &[Cell], work: &Work) -> Result<Gaps> {
    let mut found = sites_in_intervals(evaluator, study, cells);
    let feasible = cells.iter().filter(|cell| cell.metrics().is_some()).count();
    if feasible * FEW < cells.len() {
        found.extend(search_within_limits(evaluator, study, cells, work)?);
    }
    let distinct = first_distinct(found, usize::MAX, |a, b| study.is_same_place(a, b));
    if !distinct.is_empty() {
        work.tell(Event::Stage(Stage { of: "places between grid points", items: distinct.len() }));
    }
    let value = |(number, site): (usize, &Site), is_whole: bool| {
        let corners: Vec<usize> = if is_whole { evaluator.corners().collect() } else { Vec::new() };
        let evaluate = |setup: &Setup, corner| evaluator.evaluate_clamped(setup, corner);
        let found = evaluator.evaluate_among_in_work(&work.shard(number), site, &corners, evaluate);
        Some((study.objective.value(&found.ok()?.metrics), *site))
    };
    let placed = |(number, site): (usize, &Site)| {
        let found = value((number, site), false);
        work.tell(Event::Computed(1));
        found
    };
    let by_value = |a: &(f64, Site), b: &(f64, Site)| a.0.total_cmp(&b.0);
    let mut placed: Vec<(f64, Site)> = distinct.par_iter().enumerate().filter_map(placed).collect();
    work.barrier()?;
    placed.sort_by(by_value);
    // Those of which some are starts: within its allowance a place is no better than exactly there.
    let (starts, mut ranked) = (study.search.starts, Vec::<(f64, Site)>::new());
    for (piece, some) in placed.chunks(starts.max(1)).enumerate() {
        if ranked.len() >= starts && ranked[starts - 1].0 <= some[0].0 {
            break;
        }
        let whole = |(number, (_, site)): (usize, &(f64, Site))| value((piece * starts + number, site), true);
        ranked.extend(some.par_iter().enumerate().filter_map(whole).collect::<Vec<_>>());
        work.barrier()?;
        ranked.sort_by(by_value);
    }
    let sites: Vec<Site> = ranked.into_iter().map(|(_, site)| site).collect();
    let all: Vec<Site> = placed.into_iter().map(|(_, site)| site).collect();
    let coarse = study.bounds.free().into_iter().filter(|&i| is_coarse(study, cells, &all, i)).collect();
    Ok(Gaps { sites, coarse })
}

/// Returns whether along coordinate `i` a cell, or one of `sites`, lies between two infeasible neighbours: a region narrower than a step.
fn is_coarse(study: &PlacementStudy, cells: &[Cell], sites: &[Site], i: usize) -> bool {
    let grid = &study.grid;
    let axis = &grid.axes[i];
    if axis.len() < 2 {
        return false;
    }
    let stride: usize = grid.axes[..i].iter().map(Vec::len).product();
    let position = |index: usize| index / stride % axis.len();
    let is_infeasible = |index: usize| matches!(cells[index].verdict, PlaceOutcome::Infeasible(_));
    let is_isolated = |index: usize| {
        let (before, after) = (position(index) > 0, position(index) + 1 < axis.len());
        !is_infeasible(index) && before && after && is_infeasible(index - stride) && is_infeasible(index + stride)
    };
    let nearest = |site: &Site| {
        let position = |k: usize| {
            let distance = |value: f64| study.bounds.distance(k, value, site.0[k]);
            let axis = grid.axes[k].iter().enumerate();
            axis.min_by(|a, b| distance(*a.1).total_cmp(&distance(*b.1))).map_or(0, |(position, _)| position)
        };
        std::array::from_fn(position)
    };
    let is_in_gap = |site: &Site| {
        let mut positions: [usize; 6] = nearest(site);
        let Some(next) = axis.iter().position(|value| *value > site.0[i]).filter(|next| *next > 0) else {
            return false;
        };
        [next - 1, next].into_iter().all(|position| {
            positions[i] = position;
            is_infeasible(grid.index(positions))
        })
    };
    (0..cells.len()).any(is_isolated) || sites.iter().any(is_in_gap)
}

/// Returns middles of intervals, for each orientation of the sweep, that hold no grid point and that boxes and table allow.
fn sites_in_intervals(evaluator: &Evaluator, study: &PlacementStudy, cells: &[Cell]) -> Vec<Site> {
    // Without a place that cannot be cut at there is nothing to miss.
    if cells.iter().all(|cell| cell.metrics().is_some()) {
        return Vec::new();
    }
    let [_, _, _, yaws, pitches, rolls] = &study.grid.axes;
    let mut sites = Vec::new();
    for (&yaw, (&pitch, &roll)) in
        yaws.iter().flat_map(|yaw| pitches.iter().flat_map(move |p| rolls.iter().map(move |r| (yaw, (p, r)))))
    {
        let turned = Site([0.0, 0.0, 0.0, yaw, pitch, roll]);
        let middles: [Vec<(f64, bool)>; 3] = std::array::from_fn(|axis| midpoints(evaluator, study, &turned, axis));
        for &(z, z_is_new) in &middles[2] {
            for &(y, y_is_new) in &middles[1] {
                for &(x, x_is_new) in &middles[0] {
                    if x_is_new || y_is_new || z_is_new {
                        sites.push(Site([x, y, z, yaw, pitch, roll]));
                    }
                }
            }
        }
    }
    let sites = evenly_thinned(sites, MIDDLES);
    // Where γ is sought, only an evaluation says whether the workspace holds the path.
    let keeps_workspace =
        |site: &Site| study.seeks_gamma() || evaluator.check_workspace(&evaluator.setup(site)).is_ok();
    let fits = |site: &Site| evaluator.check_boxes(site).is_ok() && keeps_workspace(site);
    let fitting: Vec<Site> = sites.into_par_iter().filter(fits).collect();
    evenly_thinned(fitting, TRIED)
}

/// Returns at most `most` of `sites`, evenly spread.
fn evenly_thinned(sites: Vec<Site>, most: usize) -> Vec<Site> {
    let stride = sites.len().div_ceil(most).max(1);
    sites.into_iter().step_by(stride).collect()
}

/// Returns the middles of the intervals along `axis` for a workpiece with this `orientation`, mm, and whether each holds no grid point.
fn midpoints(evaluator: &Evaluator, study: &PlacementStudy, orientation: &Site, axis: usize) -> Vec<(f64, bool)> {
    let (low, high) = (study.bounds.low[axis], study.bounds.high[axis]);
    if high <= low {
        return vec![(low, false)];
    }
    let pose = study.workpiece_pose(orientation);
    let extent_along = |extent: &Extent| {
        let along = extent.corners().map(|corner| pose.transform(corner)[axis]);
        along.into_iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
    };
    let (own_low, own_high) = extent_along(&study.extent);
    let mut ends = vec![low, high];
    for forbidden in &study.forbidden {
        let grown = forbidden.extent.expanded(study.clearance_mm);
        ends.extend([grown.min[axis] - own_high, grown.max[axis] - own_low]);
    }
    if let Some(table) = study.table.as_ref().filter(|_| axis < 2) {
        let along = table.corners().map(|corner| corner[axis]);
        let (first, last) = along.into_iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        ends.extend([first + table.margin_mm - own_low, last - table.margin_mm - own_high]);
    }
    let workspace = &study.machine.workspace;
    let setup = Setup { site: *orientation, gammas: vec![None; study.features.len()] };
    for f in 0..study.features.len() {
        let along = evaluator.tasks(&setup, f).into_iter().map(|task| task.pose.translation[axis]);
        let (path_low, path_high) = along.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        ends.extend([workspace.min[axis] - path_low, workspace.max[axis] - path_high]);
    }
    ends.retain(|end| (low..=high).contains(end));
    ends.sort_by(f64::total_cmp);
    let intervals = ends.windows(2).filter(|pair| pair[1] - pair[0] > NARROWEST);
    let is_new = |pair: &[f64]| !study.grid.axes[axis].iter().any(|value| (pair[0]..=pair[1]).contains(value));
    intervals.map(|pair| (0.5 * (pair[0] + pair[1]), is_new(pair))).collect()
}

/// Searches from infeasible grid points, the least violation first, for feasible places; returns those found. `Err` only from `work`.
fn search_within_limits(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    cells: &[Cell],
    work: &Work,
) -> Result<Vec<Site>> {
    let cannot: Vec<Site> = cells.iter().filter(|cell| cell.metrics().is_none()).map(|cell| cell.site).collect();
    let violation = |(number, site): (usize, &Site)| (evaluator.violation(&work.shard(number), site), *site);
    let mut ranked: Vec<(f64, Site)> = evenly_thinned(cannot, RANKED).par_iter().enumerate().map(violation).collect();
    work.barrier()?;
    // Nothing leads away from where the loaded machine has no equilibrium.
    ranked.retain(|(violation, _)| violation.is_finite() && !(UNMEASURED..NOT_RIGID).contains(violation));
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let starts = first_distinct(ranked, SEARCHES, |a, b| is_neighbour(study, &a.1, &b.1));
    if !starts.is_empty() {
        work.tell(Event::Stage(Stage { of: "searches for room", items: starts.len() }));
    }
    let search = |(number, &(violation, site)): (usize, &(f64, Site))| {
        let work = work.shard(number);
        let (end, remaining) =
            pattern_search(study, (site, violation), STEPS, 0.0, |site, _| evaluator.violation(&work, site));
        work.tell(Event::Computed(1));
        (remaining == 0.0).then_some(end)
    };
    let found = starts.par_iter().enumerate().filter_map(search).collect();
    work.barrier()?;
    Ok(found)
}
