//! Evaluation of the metrics of a placement on the actual paths, with the loaded model and all sources of error.
//!
//! A sweep evaluates paths in levels, from few points to all; `Evaluator::best_possible` gives after each level the best that metrics can still be.

use std::sync::Arc;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{
    PlacementStudy,
    metric::{Metric, Metrics},
    runs::SpareSolvers,
    site::Site,
    tally::{Needs, PointValues, ResidualTally, Tally},
    turned::Setup,
    uncertain,
    walk::{ExactMode, PathWalk, UNMEASURED, excess},
};
#[cfg(not(target_family = "wasm"))]
use crate::simulation::clearance::MachineCell;
use crate::{
    FOR_PAGES,
    compensation::TaskPoint,
    input::error::Error,
    machine::Configuration,
    process::RedundancyCost,
    questions::placement::FeatureJob,
    redundancy::BranchMachines,
    simulation::{Failure, Machines, along_path::length_of_point, spread::DrawnMachines, within_limits},
    work::Work,
};

/// Evaluator of the placements of one study, shared by all threads.
#[derive(Debug)]
pub struct Evaluator {
    pub(super) study: PlacementStudy,
    pub(super) needs: Needs,
    /// Whether an exact correction beyond the force limits makes a place infeasible.
    pub(super) check_forces: bool,
    /// Whether the objective asks for the correction within limits, so that one must exist.
    pub(super) asks_bounded: bool,
    /// Whether the exact correction is computed and required: by the objective, whatever metrics are asked for.
    pub(super) exact: ExactMode,
    pub(super) features: Vec<PreparedFeature>,
    /// Machines of the draws, for each feature, or why there are none; `None` where the objective does not ask for them.
    pub(super) drawn: std::result::Result<Option<Vec<DrawnMachines>>, String>,
    /// Sum of the shares of all features: 1 up to multiples of [`GRAIN`].
    share: f64,
    /// Number of levels of the feature with most of them.
    pub(super) levels: usize,
    pub(super) gammas: super::turned::GammaCache,
    /// Evaluator of the objective alone, which seeks γ for this one.
    pub(super) seeker: Option<Arc<Self>>,
    /// Bodies of each feature, `None` where its process names no cell.
    #[cfg(not(target_family = "wasm"))]
    pub(super) cells: Vec<Option<Arc<MachineCell>>>,
    /// What refuses every place, if anything does.
    pub(super) refused_everywhere: Option<Failure>,
}

/// Data of a feature that do not depend on its place.
#[derive(Debug)]
pub(super) struct PreparedFeature {
    pub(super) machines: Machines,
    /// Share of each point in the length of all paths, a multiple of [`GRAIN`]; 0 where the tool does not cut.
    pub(super) shares: Vec<f64>,
    /// Sum of the shares.
    pub(super) share: f64,
    /// Whether the tool cuts at each point, so that it counts.
    pub(super) is_counted: Vec<bool>,
    /// Indices of the points that count.
    pub(super) counted: Vec<usize>,
    /// Indices of the points that each level adds, in path order.
    pub(super) levels: Vec<Vec<usize>>,
    /// Force limit of each drive, N or N·mm; infinite where there is none.
    pub(super) force_limits: Vec<f64>,
    pub(super) solvers: SpareSolvers,
    /// Its machine on each branch, where γ is sought; `Err` says why there are none.
    pub(super) branches: std::result::Result<BranchMachines, String>,
}

/// Evaluation of a placement up to some level.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct PartialEvaluation {
    pub(super) setup: Setup,
    pub(super) tallies: Vec<Tally>,
    level: usize,
}

/// Metrics of a placement.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Metrics of all features together, the worst of where the workpiece may be clamped.
    pub metrics: Metrics,
    /// Metrics of each feature, the worst of where the workpiece may be clamped.
    pub features: Vec<Metrics>,
    /// Metrics of all features together with the workpiece exactly at the place.
    pub as_placed: Metrics,
    /// The corner of the allowance at which the worst deflection is; `None`: exactly at the place.
    pub worst_corner: Option<usize>,
    /// Half the widest interval in which open backlash and friction leave the tool, mm, in no metric; `None` where it is not known.
    pub open_backlash_mm: Option<f64>,
    /// Why there is no correction within limits, if one was sought and not found.
    pub not_corrected: Option<String>,
    /// Where the path leaves the machine's workspace box, if it does: the numbers are then those of a machine that is tracked beyond it.
    pub outside_workspace: Option<Failure>,
}

/// Status of a place at which something is hit.
pub(super) const HIT: &str = "hits";

/// Approximate number of points of the first level.
const FIRST_LEVEL: usize = 8;
/// Unit of which shares are multiples, so that their sums have no rounding in whatever order they are taken.
const GRAIN: f64 = f64::EPSILON;
/// Factor between the points of a level and of all levels before it.
const REFINEMENT: usize = 4;
/// Bodies of a place that is not looked at are at most as far apart, mm.
const FARTHEST_MM: f64 = 1e6;
/// Violation above that of any place which the rigid machine reaches.
pub(super) const NOT_RIGID: f64 = 1e6;

impl Evaluator {
    /// Makes an evaluator that computes `metrics` of placements of `study`.
    pub fn new(study: &PlacementStudy, metrics: &[Metric]) -> Self {
        let lengths: Vec<Vec<f64>> = study.features.iter().map(point_lengths).collect();
        let total: f64 = lengths.iter().flatten().sum();
        let features: Vec<PreparedFeature> =
            study.features.iter().zip(&lengths).map(|(job, lengths)| prepare(study, job, lengths, total)).collect();
        let limited = features.iter().flat_map(|feature| &feature.force_limits).any(|limit| limit.is_finite());
        let asks_bounded = study.objective.metrics().iter().any(|metric| metric.is_bounded());
        let check_forces = limited && !asks_bounded;
        let mut needs = Needs::of(metrics);
        let exact_is_needed = !asks_bounded || Needs::of(&study.objective.metrics()).correction;
        let exact = match (exact_is_needed, needs.correction) {
            (true, _) => ExactMode::Needed,
            (false, true) => ExactMode::IfPossible,
            (false, false) => ExactMode::NotAsked,
        };
        needs.bounded &= study.has_limits();
        needs.clearance &= study.has_cell();
        needs.across &= study.objective.has(Metric::WorstAcrossPath);
        needs.uncertain &= study.objective.has(Metric::P95Deflection);
        // Pages compute with nominal numbers.
        let drawn = {
            let asked = study.features.iter().filter(|_| !FOR_PAGES && needs.uncertain);
            let of_feature = |job: &FeatureJob| job.drawn().map_err(|error| error.to_string());
            asked.map(of_feature).collect()
        };
        let levels = features.iter().map(|feature| feature.levels.len()).max().unwrap_or(0);
        let share = features.iter().map(|feature| feature.share).sum();
        Self {
            gammas: super::turned::GammaCache::default(),
            seeker: None,
            #[cfg(not(target_family = "wasm"))]
            cells: study.features.iter().map(|job| job.bodies.clone()).collect(),
            #[cfg(not(target_family = "wasm"))]
            refused_everywhere: study.features.iter().find_map(super::bodies::hit_everywhere),
            #[cfg(target_family = "wasm")]
            refused_everywhere: None,
            study: study.clone(),
            needs,
            check_forces,
            asks_bounded,
            exact,
            features,
            drawn,
            share,
            levels,
        }
    }

    /// Makes an evaluator of all metrics that takes the γ which `seeker`, of the objective alone, finds: no other metric changes it.
    pub(super) fn of_all(seeker: &Arc<Self>) -> Self {
        Self { seeker: Some(seeker.clone()), ..Self::new(&seeker.study, &Metric::ALL) }
    }

    /// Starts an evaluation at `site`, with no points added. `Err` says why the workpiece must not stand there.
    pub(super) fn begin_evaluation(&self, site: &Site) -> Result<PartialEvaluation, Failure> {
        // Before γ is sought.
        self.check_boxes(site)?;
        self.check_workspace(&self.setup(site))?;
        self.begin_without_workspace_check(site)
    }

    /// Starts an evaluation at `site` also where the path leaves the workspace box. `Err` says why else the workpiece must not stand there.
    pub(super) fn begin_without_workspace_check(&self, site: &Site) -> Result<PartialEvaluation, Failure> {
        self.check_boxes(site)?;
        let gammas = (0..self.features.len()).map(|f| self.gamma_at(site, f).transpose()).collect::<Result<_, _>>()?;
        self.begin_at(Setup { site: *site, gammas })
    }

    /// Starts an evaluation at `setup`, where boxes are not in the way. `Err` where the rigid machine does not reach a point.
    pub(super) fn begin_at(&self, setup: Setup) -> Result<PartialEvaluation, Failure> {
        // Only inverse kinematics says where a coordinate stands that the drives do not control.
        let machine = &self.study.machine;
        let is_tracked = machine.uncontrolled_axes().next().is_none() && !machine.has_parasitic_rotation;
        if !is_tracked {
            self.check_reach(&setup, |_, _| true)?;
        }
        Ok(self.without_points(setup))
    }

    /// Nothing: pages look at no bodies.
    #[cfg(target_family = "wasm")]
    pub(super) fn check_bodies_along(&self, _: usize, _: &Site, _: &[TaskPoint]) -> Result<Option<f64>, Failure> {
        Ok(None)
    }

    /// Returns an evaluation at `setup` with no points added; does not check whether the workpiece fits there.
    pub(super) fn without_points(&self, setup: Setup) -> PartialEvaluation {
        PartialEvaluation { setup, tallies: vec![Tally::default(); self.features.len()], level: 0 }
    }

    /// Checks that the rigid machine reaches each point (feature, index) for which `asked` holds. `Err` names the first that it does not.
    pub(super) fn check_reach(&self, setup: &Setup, asked: impl Fn(usize, usize) -> bool) -> Result<(), Failure> {
        self.track_features(setup, asked, |_| ())
    }

    /// Moves the rigid machine to the points (feature, index) for which `is_visited` holds; calls `visit` at each. `Err` as
    /// [`track_feature`].
    fn track_features(
        &self,
        setup: &Setup,
        is_visited: impl Fn(usize, usize) -> bool,
        mut visit: impl FnMut(&Configuration),
    ) -> Result<(), Failure> {
        self.study.features.iter().enumerate().try_for_each(|(f, job)| {
            let is_visited = |k| is_visited(f, k);
            track_feature(job, &self.tasks(setup, f), is_visited, |_, at| {
                visit(at);
                Ok(())
            })
        })
    }

    /// Returns how far the workpiece at `site` is from what can be cut, for a search that minimises it: 0 where it can be cut; else by how
    /// much limits are exceeded within its allowance, mm or degrees, plus [`NOT_RIGID`] where boxes, workspace or limits of the rigid machine are,
    /// and twice that where they are exactly there; the least number where what refuses it is a hit, as no load mends that.
    pub(super) fn violation(&self, work: &Work, site: &Site) -> f64 {
        if work.check().is_err() || self.refused_everywhere.is_some() {
            return f64::INFINITY;
        }
        let setups = self.clamped_setups(&self.setup(site));
        let largest = |own: &[Setup], violation: &dyn Fn(&Setup) -> f64| own.iter().map(violation).fold(0.0, f64::max);
        // What is not reached exactly there needs no look at its corners.
        for (offset, setups) in [(2.0 * NOT_RIGID, &setups[..1]), (NOT_RIGID, &setups[1..])] {
            let rigid = largest(setups, &|setup| self.box_violation(setup).max(self.limit_violation(setup)));
            if rigid > 0.0 {
                return offset + rigid.min(NOT_RIGID);
            }
        }
        match self.evaluate_in_work(work, site) {
            Ok(_) => 0.0,
            Err(failure) if failure.status == HIT => f64::MIN_POSITIVE,
            Err(_) => largest(&setups, &|setup| self.loaded_violation(setup)).clamp(f64::MIN_POSITIVE, NOT_RIGID),
        }
    }

    /// Returns by how much the rigid machine exceeds its limits on the path, mm or degrees.
    fn limit_violation(&self, setup: &Setup) -> f64 {
        let mut largest: f64 = 0.0;
        for (f, job) in self.study.features.iter().enumerate() {
            let machine = job.machine();
            let mut near = machine.home.clone();
            for task in self.tasks(setup, f) {
                let reached = machine.unlimited_inverse_kinematics_from(&near, &task.pose);
                match reached.or_else(|_| machine.unlimited_inverse_kinematics_from(&machine.home, &task.pose)) {
                    Ok(at) => {
                        largest = largest.max(machine.limit_excess(&at));
                        near = at;
                    }
                    Err(unreachable) => largest = largest.max(excess(&unreachable)),
                }
            }
        }
        largest
    }

    /// Returns by how much the loaded or corrected machine exceeds its limits on the path: mm, degrees or share of a force limit.
    fn loaded_violation(&self, setup: &Setup) -> f64 {
        let mut largest: f64 = 0.0;
        for f in 0..self.features.len() {
            let tasks = self.tasks(setup, f);
            self.visit_runs(self.walk_settings(f), f, &tasks, &self.features[f].counted, &mut None, |_, _, found| {
                largest = found.map_or_else(|refusal| largest.max(refusal.excess), |_| largest);
                largest < UNMEASURED
            });
            if largest >= UNMEASURED {
                return largest;
            }
        }
        largest
    }

    /// Adds the points of the next level. `Err` names the first point of the path out of reach, or else what cannot be solved.
    pub(super) fn advance(&self, partial: &mut PartialEvaluation) -> Result<(), Failure> {
        let visited = self.add_level(partial);
        visited.or_else(|failure| self.check_reach(&partial.setup, |_, _| true).and(Err(failure)))
    }

    /// Adds the points of the next level, and stops at the first that cannot be solved.
    fn add_level(&self, partial: &mut PartialEvaluation) -> Result<(), Failure> {
        let level = partial.level;
        partial.level += 1;
        self.add_points(partial, |prepared| prepared.levels.get(level).map_or(&[], Vec::as_slice), &mut None)
    }

    /// Solves the points that `points` selects of each feature, and adds them to `partial`; appends positions within limits to `shares`.
    fn add_points(
        &self,
        partial: &mut PartialEvaluation,
        points: impl Fn(&PreparedFeature) -> &[usize],
        shares: &mut Option<Vec<f64>>,
    ) -> Result<(), Failure> {
        for (f, (prepared, job)) in self.features.iter().zip(&self.study.features).enumerate() {
            let points = points(prepared);
            let is_whole = shares.is_none() && partial.level == 0 && points.len() == prepared.counted.len();
            if let Some(known) = is_whole.then(|| self.judged_tally(&partial.setup, f)).flatten() {
                partial.tallies[f] = known;
                continue;
            }
            let tasks = self.tasks(&partial.setup, f);
            let solved = self.solve_points_of((&partial.setup.site, f), &tasks, points, shares);
            let solved = solved.map_err(|(_, failure)| failure)?;
            for (values, &k) in solved.iter().zip(points) {
                partial.tallies[f].add(values, prepared.shares[k], job.feature.tolerance_mm);
            }
        }
        Ok(())
    }

    /// Returns `values` of point `k`, with the parts of its deflection across the direction of motion if they are needed.
    pub(super) fn with_across_parts(
        &self,
        values: PointValues,
        site: &Site,
        job: &FeatureJob,
        (k, task): (usize, &TaskPoint),
        walk: &PathWalk<'_>,
    ) -> PointValues {
        let Some(found) = walk.last.uncompensated.as_ref().filter(|_| self.needs.across) else { return values };
        let machine = job.machine();
        let workpiece = match task.external {
            Some(axes) => *site.placement(job.feature.reference).place(&machine.with_carrier_axes(&axes)).workpiece(),
            None => self.study.workpiece_pose(site),
        };
        let along = workpiece.rotation * job.feature.path.points()[k].tangent;
        let axis = task.pose.rotation * machine.tool_axes.column(2);
        let part = |part: RedundancyCost| part.deviation(&found.position_error, along, axis);
        PointValues { across: [part(RedundancyCost::AcrossPath), part(RedundancyCost::AcrossSurface)], ..values }
    }

    /// Returns the best that the metrics can be once all points are added; exact after the last, but for corrections within limits.
    pub(super) fn best_possible(&self, partial: &PartialEvaluation) -> Metrics {
        let all = partial.tallies.iter().fold(Tally::default(), |sum, tally| sum.merged(tally));
        self.best_possible_of(&all, self.share)
    }

    /// Returns the best values that the metrics of a `tally` can still have, of paths that make up `share` of the length of all.
    pub(super) fn best_possible_of(&self, tally: &Tally, share: f64) -> Metrics {
        let mut metrics = tally.metrics(&self.needs, share);
        if self.needs.clearance {
            metrics.set(Metric::LeastClearance, FARTHEST_MM);
        }
        if self.needs.bounded {
            ResidualTally::perfect().write_into(&mut metrics);
        }
        if !FOR_PAGES && self.needs.uncertain {
            let mut uncertain = self.study.features.iter().flat_map(|job| &job.tracked.uncertainty);
            let is_bounded = uncertain.all(|own| own.has_nominal_medians());
            let nominal = metrics.get(Metric::WorstDeflection).filter(|_| is_bounded);
            metrics.set(Metric::P95Deflection, nominal.unwrap_or(0.0));
            metrics.set(Metric::WithinProbability, 1.0);
        }
        metrics
    }

    /// Evaluates the remaining levels and points, and the correction within limits where it is needed. `Err` as [`Evaluator::advance`].
    pub(super) fn complete(&self, mut partial: PartialEvaluation) -> Result<Evaluation, Failure> {
        while partial.level < self.levels {
            self.advance(&mut partial)?;
        }
        self.check_reach(&partial.setup, |f, k| !self.features[f].is_counted[k])?;
        self.conclude(&partial)
    }

    /// Returns the evaluation once all points are added, of the place with its allowance. `Err` where something is hit, or the objective asks for a
    /// correction within limits and there is none.
    fn conclude(&self, partial: &PartialEvaluation) -> Result<Evaluation, Failure> {
        let at_corner = |corner| self.evaluate_clamped(&partial.setup, Some(corner));
        self.with_corners(self.conclude_placed(partial)?, self.corners(), at_corner)
    }

    /// Returns the evaluation once all points are added, with the workpiece exactly at the place. `Err` as [`Evaluator::conclude`].
    pub(super) fn conclude_placed(&self, partial: &PartialEvaluation) -> Result<Evaluation, Failure> {
        // Last of what can refuse a place, as it takes the longest.
        let of_feature = |f: usize| self.check_bodies_along(f, &partial.setup.site, &self.tasks(&partial.setup, f));
        let clearances = (0..self.features.len()).map(of_feature).collect::<Result<Vec<Option<f64>>, Failure>>()?;
        let least_clearance = clearances.into_iter().try_fold(f64::INFINITY, |least, own| Some(least.min(own?)));
        let metrics_of = |(tally, prepared): (&Tally, &PreparedFeature)| tally.metrics(&self.needs, prepared.share);
        let mut evaluation = Evaluation {
            metrics: self.best_possible(partial).with_clearance(least_clearance),
            features: partial.tallies.iter().zip(&self.features).map(metrics_of).collect(),
            open_backlash_mm: Tally::widest_open_mm(&partial.tallies),
            ..Evaluation::default()
        };
        if self.needs.bounded {
            self.correct_within_limits(partial, &mut evaluation);
        }
        if !FOR_PAGES && self.needs.uncertain {
            uncertain::write_metrics(self, &partial.setup, self.levels, &mut evaluation.metrics)?;
        }
        evaluation.as_placed = evaluation.metrics;
        match evaluation.not_corrected {
            Some(reason) if self.asks_bounded => Err(Failure { status: "limits".into(), reason }),
            _ => Ok(evaluation),
        }
    }

    /// Returns the metrics at `site`, from all points in path order; `Err` says why the workpiece cannot be cut there.
    pub fn evaluate(&self, site: &Site) -> Result<Evaluation, Failure> {
        self.conclude(&self.all_points(self.begin_evaluation(site)?, &mut None)?)
    }

    /// Evaluates `site` as [`Evaluator::evaluate`] does, the worst of the place and these `corners` of its allowance alone, as a piece of `work`, each
    /// as `evaluate` finds it: exactly there, or at a corner. Stopped work returns a failure.
    pub(super) fn evaluate_among_in_work(
        &self,
        work: &Work,
        site: &Site,
        corners: &[usize],
        evaluate: impl Fn(&Setup, Option<usize>) -> Result<Evaluation, Failure>,
    ) -> Result<Evaluation, Failure> {
        let among = || {
            let setup = self.begin_evaluation(site)?.setup;
            let evaluate = |corner| evaluate(&setup, corner);
            self.with_corners(evaluate(None)?, corners.iter().copied(), |corner| evaluate(Some(corner)))
        };
        work.part("corners").piece(&(site.0, corners), |_| 0, || Ok(among())).unwrap_or_else(stopped_failure)
    }

    /// Evaluates `setup` without allowance; returns also where each limited drive, joint and force lies at each point, −1 and 1 at its limits.
    pub(super) fn evaluate_with_shares(&self, setup: &Setup) -> Result<(Evaluation, Vec<f64>), Failure> {
        let mut shares = Some(Vec::new());
        let partial = self.all_points(self.begin_setup(setup)?, &mut shares)?;
        Ok((self.conclude_placed(&partial)?, shares.unwrap_or_default()))
    }

    /// Adds all points to what was begun as `partial`, and appends to `shares`, unless `None`, where drives, joints and forces lie, ±1 at limits.
    pub(super) fn all_points(
        &self,
        mut partial: PartialEvaluation,
        shares: &mut Option<Vec<f64>>,
    ) -> Result<PartialEvaluation, Failure> {
        // Where the tool cuts, the loaded machine shows what it reaches.
        let is_not_cut = |f: usize, k: usize| !self.features[f].is_counted[k];
        self.track_features(&partial.setup, is_not_cut, |at| {
            if let Some(shares) = shares {
                self.study.machine.limit_fractions(at, shares);
            }
        })?;
        self.add_points(&mut partial, |prepared| &prepared.counted, shares)?;
        Ok(partial)
    }

    /// Evaluates `site` as [`Evaluator::evaluate`] does, as a piece of `work`; stopped work returns a failure.
    pub(super) fn evaluate_in_work(&self, work: &Work, site: &Site) -> Result<Evaluation, Failure> {
        let corners: Vec<usize> = self.corners().collect();
        self.evaluate_among_in_work(work, site, &corners, |setup, corner| self.evaluate_clamped(setup, corner))
    }

    /// Evaluates the levels of `partial`, with the workpiece exactly at its place; `None` where it cannot be cut, or once the best possible
    /// metrics are no better than wanted, as `is_enough` says.
    pub(super) fn evaluate_levels_below(
        &self,
        mut partial: PartialEvaluation,
        is_enough: impl Fn(&Metrics) -> bool,
    ) -> Option<Evaluation> {
        while partial.level < self.levels {
            self.add_level(&mut partial).ok()?;
            let best = self.best_possible(&partial);
            if is_enough(&best) {
                return None;
            }
            // A few points tell most places apart, at a part of the price.
            if !FOR_PAGES && self.needs.uncertain && partial.level == 1 && self.levels > 1 {
                let mut of_few = best;
                uncertain::write_metrics(self, &partial.setup, partial.level, &mut of_few).ok()?;
                if is_enough(&of_few) {
                    return None;
                }
            }
        }
        self.check_reach(&partial.setup, |f, k| !self.features[f].is_counted[k]).ok()?;
        let evaluation = self.conclude_placed(&partial).ok()?;
        if is_enough(&evaluation.metrics) { None } else { Some(evaluation) }
    }

    /// Examines `site` as [`Evaluator::examine`] does, as a piece of `work`; stopped work returns a failure.
    pub(super) fn examine_in_work(&self, work: &Work, site: &Site) -> Result<Evaluation, Failure> {
        work.part("examine").piece(&site.0, |_| 0, || Ok(self.examine(site))).unwrap_or_else(stopped_failure)
    }

    /// Evaluates `site` also where the path leaves the workspace box, there without allowance; reach first, so that `Err` names the first point
    /// without.
    pub fn examine(&self, site: &Site) -> Result<Evaluation, Failure> {
        let mut partial = self.begin_without_workspace_check(site)?;
        self.check_reach(&partial.setup, |_, _| true)?;
        self.add_points(&mut partial, |prepared| &prepared.counted, &mut None)?;
        match self.check_workspace(&partial.setup) {
            Ok(()) => self.conclude(&partial),
            Err(outside) => Ok(Evaluation { outside_workspace: Some(outside), ..self.conclude_placed(&partial)? }),
        }
    }

    /// Returns the place nearest to `site` as it is printed at which the workpiece can be cut, with what [`Evaluator::examine`] says of it; `site`
    /// itself where there is none.
    pub(super) fn examine_printed(&self, work: &Work, site: &Site) -> (Site, Result<Evaluation, Failure>) {
        let examined = |site: Site| (site, self.examine_in_work(work, &site));
        let can_be_cut =
            |outcome: &Result<Evaluation, Failure>| outcome.as_ref().is_ok_and(|own| own.outside_workspace.is_none());
        let mut printed = self.study.bounds.printed(site).into_iter().map(examined);
        printed.find(|(_, outcome)| can_be_cut(outcome)).unwrap_or_else(|| examined(*site))
    }

    /// Computes the correction within limits of each feature; writes its metrics, or the first reason why there is none, into `evaluation`.
    fn correct_within_limits(&self, partial: &PartialEvaluation, evaluation: &mut Evaluation) {
        let mut total = ResidualTally::default();
        for (f, (prepared, job)) in self.features.iter().zip(&self.study.features).enumerate() {
            match prepared.limited_residuals(job, &self.tasks(&partial.setup, f)) {
                Ok(corrected) => {
                    corrected.normalised(prepared.share).write_into(&mut evaluation.features[f]);
                    total = total.merged(&corrected);
                }
                Err(reason) => {
                    evaluation.not_corrected.get_or_insert(reason);
                }
            }
        }
        match evaluation.not_corrected {
            None => total.normalised(self.share).write_into(&mut evaluation.metrics),
            Some(_) => ResidualTally::remove_from(&mut evaluation.metrics),
        }
    }
}

impl PreparedFeature {
    /// Returns the tally of the residual errors after correcting the path within the feature's limits. `Err` if a point has no correction.
    pub(super) fn limited_residuals(&self, job: &FeatureJob, tasks: &[TaskPoint]) -> Result<ResidualTally, String> {
        let located = |reason: String| format!("feature {}: {reason}", job.feature.name);
        let errors = self.residuals(job, tasks).map_err(located)?;
        let mut tally = ResidualTally::default();
        for (k, (error, share)) in errors.iter().zip(&self.shares).enumerate().filter(|(_, (_, share))| **share > 0.0) {
            let no_correction = || located(format!("point {k} has no correction within the limits"));
            tally.add(error.ok_or_else(no_correction)?.norm(), *share, job.feature.tolerance_mm);
        }
        Ok(tally)
    }

    /// Returns the position error after the correction within limits at each point, O axes, mm; `None` at points left out.
    pub(super) fn residuals(&self, job: &FeatureJob, tasks: &[TaskPoint]) -> Result<Vec<Option<Vector3<f64>>>, String> {
        let path = within_limits::correct_within_limits(job.machine(), &self.machines.actual, tasks, &job.limits);
        let points = path.map_err(|error| error.to_string())?.points;
        Ok(points.iter().map(|point| point.corrected().map(|point| point.position_error)).collect())
    }
}

/// Moves the rigid machine from home to the points for which `is_visited` holds, each from the one before, and calls `visit` with index and
/// configuration. `Err` names the first that it does not reach, or is that of `visit`.
pub(super) fn track_feature(
    job: &FeatureJob,
    tasks: &[TaskPoint],
    is_visited: impl Fn(usize) -> bool,
    mut visit: impl FnMut(usize, &Configuration) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let machine = job.machine();
    let mut near = machine.home.clone();
    for (k, task) in tasks.iter().enumerate().filter(|(k, _)| is_visited(*k)) {
        let reached = machine.inverse_kinematics_from(&near, &task.pose);
        near = reached
            .or_else(|_| machine.inverse_kinematics(&task.pose))
            .and_then(|at| machine.check_tracked(&task.pose, &at).map(|()| at))
            .map_err(|unreachable| at_path_point(job, k, Failure::from(unreachable)))?;
        visit(k, &near)?;
    }
    Ok(())
}

/// Returns, as an evaluation, the failure that its work was stopped by `error`.
fn stopped_failure(error: Error) -> Result<Evaluation, Failure> {
    Err(Failure { status: "stopped".into(), reason: error.to_string() })
}

/// Returns `failure` with the feature and the point of its path added to the reason.
pub(super) fn at_path_point(job: &FeatureJob, point: usize, failure: Failure) -> Failure {
    let [x, y, z]: [f64; 3] = job.feature.path.points()[point].position_mm.into();
    let place = format!("feature {}, point {point} at ({x:.2}, {y:.2}, {z:.2}) mm of W", job.feature.name);
    Failure { reason: format!("{place}: {}", failure.reason), ..failure }
}

/// Returns the length of path that each point stands for, mm: half the way to its neighbours; 0 where the tool does not cut.
fn point_lengths(job: &FeatureJob) -> Vec<f64> {
    let points = job.feature.path.points();
    let is_counted = counted_flags(job);
    let length = |k: usize| length_of_point(k, points.len(), |k| points[k].arc_length_mm, |k| is_counted[k]);
    (0..points.len()).map(|k| if is_counted[k] { length(k) } else { 0.0 }).collect()
}

/// Computes what of a feature does not depend on its place; `lengths` are those that its points stand for, `total` that of all paths, mm.
fn prepare(study: &PlacementStudy, job: &FeatureJob, lengths: &[f64], total: f64) -> PreparedFeature {
    let shares: Vec<f64> = lengths.iter().map(|length| (length / total / GRAIN).round() * GRAIN).collect();
    let is_counted = counted_flags(job);
    let counted: Vec<usize> = (0..shares.len()).filter(|&k| is_counted[k]).collect();
    PreparedFeature {
        machines: job.machines.clone(),
        share: shares.iter().sum(),
        shares,
        levels: levels(&counted),
        is_counted,
        counted,
        force_limits: within_limits::force_limits(&study.machine, &job.limits),
        solvers: SpareSolvers::default(),
        branches: match &job.gamma_search {
            Some(own) if own.is_sought() => {
                BranchMachines::new(job.machine(), &job.tracked.errors).map_err(|error| error.to_string())
            }
            _ => Ok(BranchMachines::default()),
        },
    }
}

/// Returns for each point whether the tool cuts there; true everywhere on a path that never cuts.
pub(super) fn counted_flags(job: &FeatureJob) -> Vec<bool> {
    let points = job.feature.path.points();
    let never_cuts = points.iter().all(|point| !point.cutting);
    points.iter().map(|point| point.cutting || never_cuts).collect()
}

/// Divides indices of points into levels, coarse to fine: each adds every n-th that no level before has, n falling by `REFINEMENT`.
pub fn levels(points: &[usize]) -> Vec<Vec<usize>> {
    let mut stride = 1;
    while points.len() / (stride * REFINEMENT) >= FIRST_LEVEL {
        stride *= REFINEMENT;
    }
    let mut levels = Vec::new();
    let mut coarser: Option<usize> = None;
    loop {
        let is_new = |k: &usize| k.is_multiple_of(stride) && !coarser.is_some_and(|coarser| k.is_multiple_of(coarser));
        levels.push((0..points.len()).filter(is_new).map(|k| points[k]).collect());
        if stride == 1 {
            return levels;
        }
        coarser = Some(stride);
        stride /= REFINEMENT;
    }
}
