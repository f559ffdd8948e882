//! The metrics of a placement, on the actual paths with the loaded model and both sources of error.
//!
//! A sweep evaluates paths in levels, from few points to all; `Evaluator::outlook` says after each level the best the
//! metrics can still be.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{
    PlacementStudy,
    metric::{Metric, Metrics},
    site::Site,
    tally::{Corrected, Needs, Seen, Tally},
    walk::{Exact, Refusal, UNMEASURED, Walk, excess},
};
use crate::{
    compensation::TaskPoint,
    input::error::Error,
    machine::{Configuration, Machine},
    process::RedundancyCost,
    questions::placement::FeatureJob,
    simulation::{
        Failure, Machines,
        tasks::{placed, tasks_under},
        within_limits,
    },
    work::Work,
};

/// Evaluates placements of one study; shared by all threads.
#[derive(Debug)]
pub struct Evaluator {
    pub(super) study: PlacementStudy,
    pub(super) needs: Needs,
    check_forces: bool,
    /// Whether the objective asks for the correction within limits, so that there must be one.
    pub(super) asks_bounded: bool,
    /// Whether the exact correction is computed, and whether a place without one is refused. It does not depend on which
    /// metrics are asked for whether the workpiece can be cut at a place.
    exact: Exact,
    pub(super) features: Vec<Prepared>,
    /// Sum of the shares of all features: 1, but for the grain.
    share: f64,
    /// Number of levels.
    pub(super) levels: usize,
    #[cfg(not(target_family = "wasm"))]
    pub(super) turns: super::turned::TurnsFound,
}

/// What of a feature does not depend on where it stands.
#[derive(Debug)]
pub(super) struct Prepared {
    machines: Machines,
    /// Share of each point in the length of all paths, a multiple of [`GRAIN`]; 0 where the tool does not cut.
    pub(super) shares: Vec<f64>,
    /// Sum of the shares.
    pub(super) share: f64,
    /// Whether each point counts: the tool cuts there.
    pub(super) is_counted: Vec<bool>,
    /// Points that count.
    pub(super) counted: Vec<usize>,
    /// Those of them that each level adds, in path order.
    pub(super) levels: Vec<Vec<usize>>,
    /// Most force of each drive, N or N·mm.
    force_limits: Vec<f64>,
}

/// What is known of a placement after some levels.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Partial {
    pub(super) site: Site,
    pub(super) tallies: Vec<Tally>,
    level: usize,
}

/// All metrics of a placement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Of all features together.
    pub metrics: Metrics,
    /// Of each feature.
    pub features: Vec<Metrics>,
    /// Why there is no correction within limits, if one was sought and not found.
    pub not_corrected: Option<String>,
    /// Where the path leaves the machine's workspace box, if it does: the numbers are those of a machine that is tracked
    /// there all the same.
    pub outside_workspace: Option<Failure>,
}

/// Points of the first level, about.
const FIRST_LEVEL: usize = 8;
/// Shares are multiples of this, so that their sums have no rounding, in whatever order and parts they are taken.
const GRAIN: f64 = f64::EPSILON;
/// Factor between the points of a level and of all levels before it.
const REFINEMENT: usize = 4;
/// Larger than any violation of a place that the rigid machine can take.
pub(super) const NOT_RIGID: f64 = 1e6;

impl Evaluator {
    /// For `metrics` of placements of `study`.
    pub fn new(study: &PlacementStudy, metrics: &[Metric]) -> Self {
        let lengths: Vec<Vec<f64>> = study.features.iter().map(lengths).collect();
        let total: f64 = lengths.iter().flatten().sum();
        let features: Vec<Prepared> =
            study.features.iter().zip(&lengths).map(|(job, lengths)| prepare(study, job, lengths, total)).collect();
        let limited = features.iter().flat_map(|feature| &feature.force_limits).any(|limit| limit.is_finite());
        let asks_bounded = study.objective.metrics().iter().any(|metric| metric.is_bounded());
        let check_forces = limited && !asks_bounded;
        let mut needs = Needs::of(metrics);
        let exact_is_needed = !asks_bounded || Needs::of(&study.objective.metrics()).correction;
        let exact = match (exact_is_needed, needs.correction) {
            (true, _) => Exact::Needed,
            (false, true) => Exact::IfPossible,
            (false, false) => Exact::NotAsked,
        };
        needs.bounded &= study.has_limits();
        needs.across &= study.objective.has(Metric::WorstAcrossPath);
        let levels = features.iter().map(|feature| feature.levels.len()).max().unwrap_or(0);
        let share = features.iter().map(|feature| feature.share).sum();
        Self {
            #[cfg(not(target_family = "wasm"))]
            turns: super::turned::TurnsFound::default(),
            study: study.clone(),
            needs,
            check_forces,
            asks_bounded,
            exact,
            features,
            share,
            levels,
        }
    }

    /// The start of an evaluation at `site`: no point is looked at.
    ///
    /// # Errors
    /// The workpiece must not stand there.
    pub(super) fn open(&self, site: &Site) -> Result<Partial, Failure> {
        self.check_workspace(site)?;
        self.open_anywhere(site)
    }

    /// The same, whether or not the path stays within the machine's workspace box.
    pub(super) fn open_anywhere(&self, site: &Site) -> Result<Partial, Failure> {
        self.check_boxes(site)?;
        #[cfg(not(target_family = "wasm"))]
        for f in 0..self.features.len() {
            self.turn_at(site, f).transpose()?;
        }
        let partial = self.unopened(site);
        // Only inverse kinematics says where a coordinate stands that the drives do not control.
        let machine = &self.study.machine;
        let is_tracked = machine.uncontrolled_axes().next().is_none() && !machine.turns_with_position;
        if !is_tracked {
            self.check_reach(&partial, |_, _| true)?;
        }
        Ok(partial)
    }

    /// An evaluation at `site` of which nothing is known, not even whether the workpiece fits there.
    pub(super) fn unopened(&self, site: &Site) -> Partial {
        Partial { site: *site, tallies: vec![Tally::default(); self.features.len()], level: 0 }
    }

    /// What is wanted at each point of a feature. Made anew whenever it is needed: a sweep has too many places to keep it.
    pub(super) fn tasks(&self, site: &Site, f: usize) -> Vec<TaskPoint> {
        #[cfg(not(target_family = "wasm"))]
        if let Some(turned) = self.tasks_at_best_turn(site, f) {
            return turned;
        }
        let job = &self.study.features[f];
        let feature = &job.feature;
        let placement = site.placement(feature.reference);
        tasks_under(job.machine(), &placement, job.target, &feature.path, &feature.loads)
    }

    /// The rigid machine reaches every point for which `asked` (feature, point) is true.
    ///
    /// # Errors
    /// The first point it does not reach, and why.
    pub(super) fn check_reach(&self, partial: &Partial, asked: impl Fn(usize, usize) -> bool) -> Result<(), Failure> {
        self.reach(partial, asked, |_| ())
    }

    /// The same; `note` is told where the machine stands at each of the points.
    fn reach(
        &self,
        partial: &Partial,
        asked: impl Fn(usize, usize) -> bool,
        mut note: impl FnMut(&Configuration),
    ) -> Result<(), Failure> {
        self.study.features.iter().enumerate().try_for_each(|(f, job)| {
            let asked = |k| asked(f, k);
            track(job, &self.tasks(&partial.site, f), asked, |_, at| {
                note(at);
                Ok(())
            })
        })
    }

    /// How far the workpiece at `site` is from what can be cut, for a search that makes it small: 0 where it can be cut;
    /// where boxes, workspace and the limits of the rigid machine are kept it is less than where they are not, by which
    /// they are exceeded, mm or degrees.
    pub(super) fn violation(&self, work: &Work, site: &Site) -> f64 {
        if work.check().is_err() {
            return f64::INFINITY;
        }
        let rigid = self.box_violation(site).max(self.limit_violation(site));
        if rigid > 0.0 {
            return NOT_RIGID + rigid;
        }
        match self.kept(work, site) {
            Ok(_) => 0.0,
            Err(_) => self.loaded_violation(site).clamp(f64::MIN_POSITIVE, NOT_RIGID),
        }
    }

    /// By how much the rigid machine does not reach the path within its limits, mm or degrees.
    fn limit_violation(&self, site: &Site) -> f64 {
        let mut most: f64 = 0.0;
        for (f, job) in self.study.features.iter().enumerate() {
            let machine = job.machine();
            let mut near = machine.home.clone();
            for task in self.tasks(site, f) {
                let reached = machine.unlimited_inverse_kinematics_from(&near, &task.pose);
                match reached.or_else(|_| machine.unlimited_inverse_kinematics_from(&machine.home, &task.pose)) {
                    Ok(at) => {
                        most = most.max(machine.limit_excess(&at));
                        near = at;
                    }
                    Err(unreachable) => most = most.max(excess(&unreachable)),
                }
            }
        }
        most
    }

    /// By how much the corrected machine exceeds its limits on the path.
    fn loaded_violation(&self, site: &Site) -> f64 {
        let mut most: f64 = 0.0;
        for f in 0..self.features.len() {
            let mut walk = self.walk(f);
            let tasks = self.tasks(site, f);
            for &k in &self.features[f].counted {
                most = walk.visit(&tasks[k]).map_or_else(|refusal| most.max(refusal.excess), |_| most);
                if most >= UNMEASURED {
                    return most;
                }
            }
        }
        most
    }

    pub(super) fn walk(&self, f: usize) -> Walk<'_> {
        let prepared = &self.features[f];
        let limits = &prepared.force_limits;
        Walk::new(&prepared.machines, self.needs, limits, self.check_forces, self.exact)
    }

    /// Adds the points of the next level.
    ///
    /// # Errors
    /// Which point is out of reach, the first of the path, or else what cannot be solved at which point.
    pub(super) fn advance(&self, partial: &mut Partial) -> Result<(), Failure> {
        let visited = self.add_level(partial);
        visited.or_else(|failure| self.check_reach(partial, |_, _| true).and(Err(failure)))
    }

    fn add_level(&self, partial: &mut Partial) -> Result<(), Failure> {
        let level = partial.level;
        partial.level += 1;
        self.visit(partial, |prepared| prepared.levels.get(level).map_or(&[], Vec::as_slice), &mut None)
    }

    /// Adds the points that `points` names, each solved from the one before, and where they stand within limits to
    /// `shares`.
    fn visit(
        &self,
        partial: &mut Partial,
        points: impl Fn(&Prepared) -> &[usize],
        shares: &mut Option<Vec<f64>>,
    ) -> Result<(), Failure> {
        for (f, (prepared, job)) in self.features.iter().zip(&self.study.features).enumerate() {
            let mut walk = self.walk(f);
            walk.shares = shares.take();
            let tasks = self.tasks(&partial.site, f);
            for &k in points(prepared) {
                let seen = self.seen(&partial.site, job, (k, &tasks[k]), &mut walk)?;
                partial.tallies[f].add(&seen, prepared.shares[k], job.feature.tolerance_mm);
            }
            *shares = walk.shares.take();
        }
        Ok(())
    }

    /// What point `k` of a feature shows.
    ///
    /// # Errors
    /// Why it cannot be cut.
    pub(super) fn seen(
        &self,
        site: &Site,
        job: &FeatureJob,
        (k, task): (usize, &TaskPoint),
        walk: &mut Walk<'_>,
    ) -> Result<Seen, Failure> {
        let seen = walk.visit(task).map_err(|Refusal { failure, .. }| located(job, k, failure))?;
        Ok(self.with_parts(seen, site, job, (k, task), walk))
    }

    /// `seen` at point `k` of a feature with the parts of its deflection across the direction of motion, if they are asked for.
    pub(super) fn with_parts(
        &self,
        seen: Seen,
        site: &Site,
        job: &FeatureJob,
        (k, task): (usize, &TaskPoint),
        walk: &Walk<'_>,
    ) -> Seen {
        let Some(plain) = walk.last.plain.as_ref().filter(|_| self.needs.across) else { return seen };
        let machine = job.machine();
        let workpiece = match task.external {
            Some(axes) => *placed(&machine.carried(&axes), &site.placement(job.feature.reference)).workpiece(),
            None => self.study.workpiece(site),
        };
        let along = workpiece.rotation * job.feature.path.points()[k].tangent;
        let axis = task.pose.rotation * machine.tool_axes.column(2);
        let part = |part: RedundancyCost| part.of(&plain.position_error, along, axis);
        Seen { across: [part(RedundancyCost::AcrossPath), part(RedundancyCost::AcrossSurface)], ..seen }
    }

    /// The best the metrics can still be: no worse than their values, and their values once all levels are done (but
    /// for those of the correction within limits).
    pub(super) fn outlook(&self, partial: &Partial) -> Metrics {
        let all = partial.tallies.iter().fold(Tally::default(), |sum, tally| sum.merged(tally));
        self.at_best(&all, self.share)
    }

    /// The best the metrics of a `tally` can still be, of paths that make up `share` of the length of all.
    pub(super) fn at_best(&self, tally: &Tally, share: f64) -> Metrics {
        let mut metrics = tally.metrics(&self.needs, share);
        if self.needs.bounded {
            Corrected::perfect().enter(&mut metrics);
        }
        metrics
    }

    /// The rest of the levels and of the points, and the correction within limits where it is needed.
    ///
    /// # Errors
    /// As [`Evaluator::advance`].
    pub(super) fn complete(&self, mut partial: Partial) -> Result<Evaluation, Failure> {
        while partial.level < self.levels {
            self.advance(&mut partial)?;
        }
        self.check_reach(&partial, |f, k| !self.features[f].is_counted[k])?;
        self.conclude(&partial)
    }

    pub(super) fn conclude(&self, partial: &Partial) -> Result<Evaluation, Failure> {
        let metrics = self.outlook(partial);
        let own = |(tally, prepared): (&Tally, &Prepared)| tally.metrics(&self.needs, prepared.share);
        let features = partial.tallies.iter().zip(&self.features).map(own).collect();
        let mut evaluation = Evaluation { metrics, features, not_corrected: None, outside_workspace: None };
        if self.needs.bounded {
            self.correct_within_limits(partial, &mut evaluation);
        }
        match evaluation.not_corrected {
            Some(reason) if self.asks_bounded => Err(Failure { status: "limits".into(), reason }),
            _ => Ok(evaluation),
        }
    }

    /// The metrics at `site`, all points in path order.
    ///
    /// # Errors
    /// Why the workpiece cannot be cut there.
    pub fn evaluate(&self, site: &Site) -> Result<Evaluation, Failure> {
        self.evaluate_noting(site, &mut None)
    }

    /// The same, and where each limited drive, joint and force stands at each point: −1 at the lower limit, 1 at the upper.
    pub(super) fn evaluate_within(&self, site: &Site) -> Result<(Evaluation, Vec<f64>), Failure> {
        let mut shares = Some(Vec::new());
        let evaluation = self.evaluate_noting(site, &mut shares)?;
        Ok((evaluation, shares.unwrap_or_default()))
    }

    fn evaluate_noting(&self, site: &Site, shares: &mut Option<Vec<f64>>) -> Result<Evaluation, Failure> {
        let mut partial = self.open(site)?;
        // Where the tool cuts, the loaded machine shows what it reaches.
        let is_not_cut = |f: usize, k: usize| !self.features[f].is_counted[k];
        self.reach(&partial, is_not_cut, |at| {
            if let Some(shares) = shares {
                self.study.machine.limit_shares(at, shares);
            }
        })?;
        self.visit(&mut partial, |prepared| &prepared.counted, shares)?;
        self.conclude(&partial)
    }

    /// As [`Evaluator::evaluate`], as a piece of `work`; stopped work cannot be cut anywhere.
    pub(super) fn kept(&self, work: &Work, site: &Site) -> Result<Evaluation, Failure> {
        work.part("evaluate").piece(&site.0, |_| 0, || Ok(self.evaluate(site))).unwrap_or_else(stopped)
    }

    /// As [`Evaluator::evaluate`], as a piece of `work`; `None` where the workpiece cannot be cut, and as soon as `value`
    /// of the best that the metrics can still be is not less than `below`.
    pub(super) fn kept_below(
        &self,
        work: &Work,
        site: &Site,
        value: &dyn Fn(&Metrics) -> f64,
        below: f64,
    ) -> Option<Evaluation> {
        let compute = || Ok(self.evaluate_below(site, value, below));
        work.part("below").piece(&(site.0, below), |_| 0, compute).ok().flatten()
    }

    fn evaluate_below(&self, site: &Site, value: &dyn Fn(&Metrics) -> f64, below: f64) -> Option<Evaluation> {
        let mut partial = self.open(site).ok()?;
        while partial.level < self.levels {
            self.add_level(&mut partial).ok()?;
            if value(&self.outlook(&partial)) >= below {
                return None;
            }
        }
        self.check_reach(&partial, |f, k| !self.features[f].is_counted[k]).ok()?;
        self.conclude(&partial).ok()
    }

    /// As [`Evaluator::examine`], as a piece of `work`; stopped work cannot be cut anywhere.
    pub(super) fn examine_kept(&self, work: &Work, site: &Site) -> Result<Evaluation, Failure> {
        work.part("examine").piece(&site.0, |_| 0, || Ok(self.examine(site))).unwrap_or_else(stopped)
    }

    /// As [`Evaluator::evaluate`], but looks first whether all points are in reach, so that the first one that is not is
    /// named, and goes on where the path leaves the workspace box, to say what would happen.
    ///
    /// # Errors
    /// Why the workpiece cannot be cut there.
    pub fn examine(&self, site: &Site) -> Result<Evaluation, Failure> {
        let mut partial = self.open_anywhere(site)?;
        self.check_reach(&partial, |_, _| true)?;
        self.visit(&mut partial, |prepared| &prepared.counted, &mut None)?;
        Ok(Evaluation { outside_workspace: self.check_workspace(site).err(), ..self.conclude(&partial)? })
    }

    fn correct_within_limits(&self, partial: &Partial, evaluation: &mut Evaluation) {
        let mut all = Corrected::default();
        for (f, (prepared, job)) in self.features.iter().zip(&self.study.features).enumerate() {
            match prepared.corrected(job, &self.tasks(&partial.site, f)) {
                Ok(corrected) => {
                    corrected.normalised(prepared.share).enter(&mut evaluation.features[f]);
                    all = all.merged(&corrected);
                }
                Err(reason) => {
                    evaluation.not_corrected.get_or_insert(reason);
                }
            }
        }
        match evaluation.not_corrected {
            None => all.normalised(self.share).enter(&mut evaluation.metrics),
            Some(_) => Corrected::forget(&mut evaluation.metrics),
        }
    }

    /// The turn of each feature about the tool's axis at `site`, rad; `None` where none is sought or possible.
    pub(super) fn turns_of(&self, site: &Site) -> Vec<Option<f64>> {
        #[cfg(not(target_family = "wasm"))]
        return (0..self.features.len()).map(|f| self.turn_at(site, f)?.ok()).collect();
        #[cfg(target_family = "wasm")]
        vec![None; self.features.len()]
    }

    /// The real machine of feature `f`.
    pub fn real(&self, f: usize) -> &Machine {
        &self.features[f].machines.real
    }
}

impl Prepared {
    /// What the correction of the feature's path within its limits leaves.
    ///
    /// # Errors
    /// Why there is no such correction.
    pub(super) fn corrected(&self, job: &FeatureJob, tasks: &[TaskPoint]) -> Result<Corrected, String> {
        let located = |reason: String| format!("feature {}: {reason}", job.feature.name);
        let errors = self.errors_left(job, tasks).map_err(located)?;
        let mut left = Corrected::default();
        for (k, (error, share)) in errors.iter().zip(&self.shares).enumerate().filter(|(_, (_, share))| **share > 0.0) {
            let none = || located(format!("point {k} has no correction within the limits"));
            left.add(error.ok_or_else(none)?.norm(), *share, job.feature.tolerance_mm);
        }
        Ok(left)
    }

    /// Position error that the correction within limits leaves at each point, O axes, mm; `None` at points left out.
    ///
    /// # Errors
    /// Why there is no such correction.
    pub(super) fn errors_left(
        &self,
        job: &FeatureJob,
        tasks: &[TaskPoint],
    ) -> Result<Vec<Option<Vector3<f64>>>, String> {
        let path = within_limits::correct(job.machine(), &self.machines.real, tasks, &job.limits);
        let points = path.map_err(|error| error.to_string())?.points;
        Ok(points.iter().map(|point| point.corrected().map(|point| point.position_error)).collect())
    }
}

/// Leads the rigid machine to the points of a feature for which `asked` is true, each from the one before; `note` is told where it stands.
///
/// # Errors
/// The first point it does not reach, and why; those of `note`.
pub(super) fn track(
    job: &FeatureJob,
    tasks: &[TaskPoint],
    asked: impl Fn(usize) -> bool,
    mut note: impl FnMut(usize, &Configuration) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let machine = job.machine();
    let mut near = machine.home.clone();
    for (k, task) in tasks.iter().enumerate().filter(|(k, _)| asked(*k)) {
        let reached = machine.inverse_kinematics_from(&near, &task.pose);
        near = reached
            .or_else(|_| machine.inverse_kinematics(&task.pose))
            .and_then(|at| machine.check_tracked(&task.pose, &at).map(|()| at))
            .map_err(|unreachable| located(job, k, Failure::from(unreachable)))?;
        note(k, &near)?;
    }
    Ok(())
}

fn stopped(error: Error) -> Result<Evaluation, Failure> {
    Err(Failure { status: "stopped".into(), reason: error.to_string() })
}

pub(super) fn located(job: &FeatureJob, point: usize, failure: Failure) -> Failure {
    let [x, y, z]: [f64; 3] = job.feature.path.points()[point].position_mm.into();
    let place = format!("feature {}, point {point} at ({x:.2}, {y:.2}, {z:.2}) mm of W", job.feature.name);
    Failure { reason: format!("{place}: {}", failure.reason), ..failure }
}

/// Length of path that each point stands for, mm: half the way to its neighbours. 0 where the tool does not cut, unless
/// it never does.
fn lengths(job: &FeatureJob) -> Vec<f64> {
    let points = job.feature.path.points();
    let is_counted = is_counted(job);
    let counts = |k: usize| is_counted[k];
    let at = |k: usize| points[k].arc_length_mm;
    let length = |k: usize| {
        let before = if k > 0 && counts(k) { at(k) - at(k - 1) } else { 0.0 };
        let after = if k + 1 < points.len() && counts(k + 1) { at(k + 1) - at(k) } else { 0.0 };
        if counts(k) { 0.5 * (before + after) } else { 0.0 }
    };
    let lengths: Vec<f64> = (0..points.len()).map(length).collect();
    if lengths.iter().sum::<f64>() > 0.0 {
        return lengths;
    }
    (0..points.len()).map(|k| if counts(k) { 1.0 } else { 0.0 }).collect()
}

fn prepare(study: &PlacementStudy, job: &FeatureJob, lengths: &[f64], total: f64) -> Prepared {
    let shares: Vec<f64> = lengths.iter().map(|length| (length / total / GRAIN).round() * GRAIN).collect();
    let is_counted = is_counted(job);
    let counted: Vec<usize> = (0..shares.len()).filter(|&k| is_counted[k]).collect();
    let own_limit = job.limits.force_N.unwrap_or(f64::INFINITY);
    let limit = |drive: &crate::machine::Drive| drive.force_limit.unwrap_or(f64::INFINITY).min(own_limit);
    Prepared {
        machines: job.machines.clone(),
        share: shares.iter().sum(),
        shares,
        levels: levels(&counted),
        is_counted,
        counted,
        force_limits: study.machine.drives().map(|(_, drive)| limit(drive)).collect(),
    }
}

/// Points at which the tool cuts; all points of a path that never does.
fn is_counted(job: &FeatureJob) -> Vec<bool> {
    let points = job.feature.path.points();
    let never_cuts = points.iter().all(|point| !point.cutting);
    points.iter().map(|point| point.cutting || never_cuts).collect()
}

/// `points` divided into levels: every so-many-th first, then those between.
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
