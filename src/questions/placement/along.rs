//! Results point by point at one place: for the examination of a named place, and the paths of the tool for figures.

use nalgebra::Vector3;
use serde::Serialize;

use super::{
    Best, Entry, PlacementStudy,
    evaluate::{Evaluation, Evaluator, at_path_point},
    metric::Metrics,
    outcome::EntryEvaluators,
    site::Site,
    tally::Tally,
    walk::{Infeasibility, PathWalk, Solution},
};
use crate::{
    compensation::{Compensation, Method, TaskPoint},
    machine::Machine,
    questions::placement::FeatureJob,
    simulation::{
        Failure, Machines, Source,
        along_path::{Commands, PathCase, PathPointResult, run},
    },
};

/// Results of the points of all paths at one place.
#[derive(Debug, Clone)]
pub struct PlaceResults {
    /// Points of each feature that were solved, in path order: those at which the tool cuts.
    pub features: Vec<Vec<PlacePoint>>,
    /// Result as of [`Evaluator::examine`] if all points were solved, or why the workpiece cannot be cut.
    pub outcome: Result<Evaluation, Failure>,
    /// Best values that the metrics can still have after the points solved.
    pub known: Metrics,
}

/// Result at one point of a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlacePoint {
    /// Its index in the path.
    pub index: usize,
    /// Wanted position of the compensated point, O, mm.
    pub wanted_mm: Vector3<f64>,
    /// Its error at the nominal command, O axes, mm; `None` where there is no equilibrium.
    pub before_mm: Option<Vector3<f64>>,
    /// Its error after the exact correction, O axes, mm; `None` where there is none, or none was sought.
    pub after_mm: Option<Vector3<f64>>,
    /// Drive positions at the nominal command, mm or rad; empty where the machine does not reach the point.
    pub drives: Vec<f64>,
    /// Difference of the drive positions of the exact correction from them, mm or rad.
    pub corrections: Option<Vec<f64>>,
    /// Forces of the drives after the exact correction, N or N·mm.
    pub drive_forces: Option<Vec<f64>>,
    /// Why the workpiece cannot be cut here, if it cannot.
    pub failure: Option<Failure>,
}

/// Number of infeasible points of a feature after which it ends: each takes as long as many feasible ones.
const MAX_REFUSALS: usize = 3;

impl Evaluator {
    /// Solves the points at which the tool cuts, every `stride`-th and the last of a feature; ends a feature at its third infeasible point.
    pub fn solve_points(&self, site: &Site, stride: usize) -> PlaceResults {
        let is_whole = stride <= 1;
        let started = self.begin_without_workspace_check(site);
        let mut failure = started.as_ref().err().cloned();
        let mut partial = started.unwrap_or_else(|_| self.without_points(self.setup(site)));
        let mut features = Vec::new();
        for (f, (prepared, job)) in self.features.iter().zip(&self.study.features).enumerate() {
            let tasks = self.tasks(&partial.setup, f);
            let mut walk = PathWalk::new(self.walk_settings(f));
            let last = prepared.counted.len().saturating_sub(1);
            let visited =
                prepared.counted.iter().enumerate().filter(|(i, _)| is_whole || i % stride == 0 || *i == last);
            let (mut points, mut refusals) = (Vec::new(), 0);
            for (_, &k) in visited {
                let values = walk.visit(&tasks[k]);
                let values = values.map(|values| self.with_across_parts(values, site, job, (k, &tasks[k]), &walk));
                let refusal = match &values {
                    Ok(values) => {
                        partial.tallies[f].add(values, prepared.shares[k], job.feature.tolerance_mm);
                        None
                    }
                    Err(Infeasibility { failure, .. }) => Some(failure.clone()),
                };
                if let (Some(refusal), None) = (&refusal, &failure) {
                    // What the rigid machine does not reach up to here is told first.
                    let unreachable = self.check_reach(&partial.setup, |g, point| g < f || g == f && point <= k).err();
                    failure = unreachable.or_else(|| Some(at_path_point(job, k, refusal.clone())));
                }
                refusals += usize::from(refusal.is_some());
                points.push(place_point(k, &tasks[k], job.machine(), &walk.last, refusal));
                if refusals == MAX_REFUSALS {
                    break;
                }
            }
            features.push(points);
        }
        let known = self.best_possible(&partial);
        let outcome = match failure {
            Some(failure) => Err(failure),
            // What is shown is shown exactly there.
            None if is_whole => {
                let reached = self.check_reach(&partial.setup, |f, k| !self.features[f].is_counted[k]);
                let outside_workspace = self.check_workspace(&partial.setup).err();
                reached.and_then(|()| Ok(Evaluation { outside_workspace, ..self.conclude_placed(&partial)? }))
            }
            None => Ok(Evaluation {
                metrics: known,
                as_placed: known,
                open_backlash_mm: Tally::widest_open_mm(&partial.tallies),
                outside_workspace: self.check_workspace(&partial.setup).err(),
                ..Evaluation::default()
            }),
        };
        PlaceResults { features, outcome, known }
    }

    /// Returns the machines of feature `f`, and what is asked of them at its point `k`; `None` where there is no such point.
    pub(crate) fn task_at(&self, site: &Site, f: usize, k: usize) -> Option<(&Machines, TaskPoint)> {
        let machines = &self.features.get(f)?.machines;
        Some((machines, *self.tasks(&self.setup(site), f).get(k)?))
    }
}

/// Returns the result at the point with this `index` of its path, from the `solution` there without and with correction.
fn place_point(
    index: usize,
    task: &TaskPoint,
    machine: &Machine,
    solution: &Solution,
    failure: Option<Failure>,
) -> PlacePoint {
    let with_equilibrium = |result: &Option<Compensation>| result.clone().filter(|result| result.outcome.is_some());
    let plain = with_equilibrium(&solution.uncompensated);
    let exact = with_equilibrium(&solution.exact).filter(|exact| exact.status.is_success());
    let error = |result: &Option<Compensation>| result.as_ref().map(|result| result.position_error);
    let correction = |exact: &Compensation, plain: &Compensation| {
        exact.drives.iter().zip(&plain.drives).map(|(exact, plain)| exact - plain).collect()
    };
    PlacePoint {
        index,
        wanted_mm: task.pose.transform(task.offset(machine)),
        before_mm: error(&plain),
        after_mm: error(&exact),
        corrections: exact.as_ref().zip(plain.as_ref()).map(|(exact, plain)| correction(exact, plain)),
        drives: plain.map(|plain| plain.drives).unwrap_or_default(),
        drive_forces: exact.map(|exact| exact.drive_forces),
        failure,
    }
}

/// Returns the stride at which about `most` points of all features together are solved.
pub(crate) fn stride(features: &[FeatureJob], most: usize) -> usize {
    let points: usize = features.iter().map(|job| job.feature.path.len()).sum();
    points.div_ceil(most.max(1)).max(1)
}

/// The path of one feature at one place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trace {
    /// Name of the place.
    pub place: String,
    /// Index of the feature.
    pub feature: usize,
    /// Wanted positions of the compensated point, O, mm.
    pub wanted: Vec<Vector3<f64>>,
    /// Its errors at the nominal command, O axes, mm; `None` where there is no equilibrium.
    pub before: Vec<Option<Vector3<f64>>>,
    /// Its errors after the correction, O axes, mm; within limits if there are any.
    pub after: Vec<Option<Vector3<f64>>>,
    /// Whether the tool cuts on the way to each point.
    pub cutting: Vec<bool>,
    /// Length of the path up to each point, mm.
    pub arc_length_mm: Vec<f64>,
}

/// Returns the paths of every feature at the best and the poorest place evaluated, by the evaluators of named and of found places.
pub(super) fn traces(
    evaluators: &EntryEvaluators,
    study: &PlacementStudy,
    entries: &[Entry],
    best: Option<&Best>,
) -> Vec<Trace> {
    let evaluated = entries.iter().filter(|entry| entry.outcome.is_ok());
    let poorest = evaluated.max_by(|a, b| a.value.total_cmp(&b.value));
    let mut shown: Vec<&Entry> = best.map(|best| &entries[best.entry]).into_iter().chain(poorest).collect();
    shown.dedup_by(|a, b| a.name == b.name);
    let features = 0..study.features.len();
    let pairs = features.flat_map(|index| shown.iter().map(move |entry| (index, *entry)));
    pairs.map(|(index, entry)| feature_trace(evaluators.of(&entry.name, entry.found), study, entry, index)).collect()
}

/// Returns the path of the feature with this `index` at the place of `entry`, with its errors before and after correction.
fn feature_trace(evaluator: &Evaluator, study: &PlacementStudy, entry: &Entry, index: usize) -> Trace {
    let job = &study.features[index];
    let machine = job.machine();
    let feature = &job.feature;
    let tasks = evaluator.tasks(&evaluator.setup(&entry.site), index);
    let case = PathCase::new(&evaluator.features[index].machines, Source::All, &tasks);
    let errors = |method| {
        let results = run(&case, &Commands::Method(method), &|| {});
        results.iter().map(PathPointResult::solved_error).collect::<Vec<_>>()
    };
    let limited = job.limits.is_limited().then(|| evaluator.features[index].residuals(job, &tasks).ok()).flatten();
    Trace {
        place: entry.name.clone(),
        feature: index,
        wanted: tasks.iter().map(|task| task.pose.transform(task.offset(machine))).collect(),
        before: errors(Method::None),
        after: limited.unwrap_or_else(|| errors(Method::Direct)),
        cutting: feature.path.points().iter().map(|point| point.cutting).collect(),
        arc_length_mm: feature.path.points().iter().map(|point| point.arc_length_mm).collect(),
    }
}
