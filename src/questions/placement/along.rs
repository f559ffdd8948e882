//! A place looked at point by point: what a named place is judged by, what happens at each point of its paths, and where the tool goes.

use nalgebra::Vector3;
use serde::Serialize;

use super::{
    Best, Entry, PlacementStudy,
    evaluate::{Evaluation, Evaluator, located},
    metric::Metrics,
    site::Site,
    walk::{Answers, Refusal},
};
use crate::{
    compensation::{Compensation, Method, TaskPoint},
    machine::Machine,
    questions::placement::FeatureJob,
    simulation::{
        Failure,
        along_path::{Commands, PathAnswer, PathCase, run},
    },
};

/// A workpiece at a place.
#[derive(Debug, Clone)]
pub struct Along {
    /// The points of each feature that were looked at, in path order: those at which the tool cuts.
    pub features: Vec<Vec<AlongPoint>>,
    /// What [`Evaluator::examine`] finds there if all points were looked at, or why the workpiece cannot be cut.
    pub outcome: Result<Evaluation, Failure>,
    /// The best that the metrics of the points looked at can still be: they know of no other point.
    pub known: Metrics,
}

/// What happens at one point of a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlongPoint {
    /// Its index in the path.
    pub index: usize,
    /// Where the compensated point should be, O axes, mm.
    pub wanted_mm: Vector3<f64>,
    /// Its error at the nominal command, O axes, mm; `None` where there is no equilibrium.
    pub before_mm: Option<Vector3<f64>>,
    /// Its error after the exact correction; `None` where there is none, or none was sought.
    pub after_mm: Option<Vector3<f64>>,
    /// Drive positions at the nominal command, mm or rad; empty where the machine does not reach the point.
    pub drives: Vec<f64>,
    /// What the exact correction adds to them.
    pub corrections: Option<Vec<f64>>,
    /// Forces of the drives after the exact correction, N or N·mm.
    pub drive_forces: Option<Vec<f64>>,
    /// Why the workpiece cannot be cut here, if it cannot.
    pub failure: Option<Failure>,
}

/// Points of a feature that cannot be cut after which no more are looked at: each takes as long as many that can.
const MOST_REFUSALS: usize = 3;

impl Evaluator {
    /// Looks at every point at which the tool cuts, or at one of every so many (`stride`) and the last; where a few cannot
    /// be cut, at none after them.
    pub fn along(&self, site: &Site, stride: usize) -> Along {
        let whole = stride <= 1;
        let opened = self.open_anywhere(site);
        let mut failure = opened.as_ref().err().cloned();
        let mut partial = opened.unwrap_or_else(|_| self.unopened(site));
        let mut features = Vec::new();
        for (f, (prepared, job)) in self.features.iter().zip(&self.study.features).enumerate() {
            let tasks = self.tasks(site, f);
            let mut walk = self.walk(f);
            let last = prepared.counted.len().saturating_sub(1);
            let looked_at = prepared.counted.iter().enumerate().filter(|(i, _)| whole || i % stride == 0 || *i == last);
            let (mut points, mut refusals) = (Vec::new(), 0);
            for (_, &k) in looked_at {
                let seen = walk.visit(&tasks[k]);
                let seen = seen.map(|seen| self.with_parts(seen, &partial.site, job, (k, &tasks[k]), &walk));
                let refused = match &seen {
                    Ok(seen) => {
                        partial.tallies[f].add(seen, prepared.shares[k], job.feature.tolerance_mm);
                        None
                    }
                    Err(Refusal { failure, .. }) => Some(failure.clone()),
                };
                if let (Some(refused), None) = (&refused, &failure) {
                    failure = Some(
                        self.first_out_of_reach(&partial.site, f, k)
                            .unwrap_or_else(|| located(job, k, refused.clone())),
                    );
                }
                refusals += usize::from(refused.is_some());
                points.push(point(k, &tasks[k], job.machine(), &walk.last, refused));
                if refusals == MOST_REFUSALS {
                    break;
                }
            }
            features.push(points);
        }
        let known = self.outlook(&partial);
        let outcome = match failure {
            Some(failure) => Err(failure),
            None if whole => self.concluded(&partial, site),
            None => Ok(Evaluation {
                metrics: known,
                features: Vec::new(),
                not_corrected: None,
                outside_workspace: self.check_workspace(site).err(),
            }),
        };
        Along { features, outcome, known }
    }

    fn concluded(&self, partial: &super::evaluate::Partial, site: &Site) -> Result<Evaluation, Failure> {
        self.check_reach(partial, |f, k| !self.features[f].is_counted[k])?;
        Ok(Evaluation { outside_workspace: self.check_workspace(site).err(), ..self.conclude(partial)? })
    }

    /// The first point of the paths up to point `k` of feature `f` that the rigid machine does not reach.
    fn first_out_of_reach(&self, site: &Site, f: usize, k: usize) -> Option<Failure> {
        self.check_reach(&self.unopened(site), |other, point| other < f || other == f && point <= k).err()
    }
}

fn point(index: usize, task: &TaskPoint, machine: &Machine, answers: &Answers, failure: Option<Failure>) -> AlongPoint {
    let settled = |answer: &Option<Compensation>| answer.clone().filter(|answer| answer.outcome.is_some());
    let plain = settled(&answers.plain);
    let exact = settled(&answers.exact).filter(|exact| exact.status.is_success());
    let error = |answer: &Option<Compensation>| answer.as_ref().map(|answer| answer.position_error);
    let added = |exact: &Compensation, plain: &Compensation| {
        exact.drives.iter().zip(&plain.drives).map(|(exact, plain)| exact - plain).collect()
    };
    AlongPoint {
        index,
        wanted_mm: task.pose.transform(task.offset(machine)),
        before_mm: error(&plain),
        after_mm: error(&exact),
        corrections: exact.as_ref().zip(plain.as_ref()).map(|(exact, plain)| added(exact, plain)),
        drives: plain.map(|plain| plain.drives).unwrap_or_default(),
        drive_forces: exact.map(|exact| exact.drive_forces),
        failure,
    }
}

/// Greatest stride of all that look at no more than `most` points, about.
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
    /// Where the compensated point should be, O axes, mm.
    pub wanted: Vec<Vector3<f64>>,
    /// Its error at the nominal command, O axes, mm; `None` where there is no equilibrium.
    pub before: Vec<Option<Vector3<f64>>>,
    /// Its error after the correction, within limits if there are any.
    pub after: Vec<Option<Vector3<f64>>>,
    /// Whether the tool cuts on the way to each point.
    pub cutting: Vec<bool>,
    /// Length of the path up to each point, mm.
    pub arc_length_mm: Vec<f64>,
}

/// Of every feature, at the entry of the best place and at the poorest entry of which anything can be said.
pub(super) fn traces(
    evaluator: &Evaluator,
    study: &PlacementStudy,
    entries: &[Entry],
    best: Option<&Best>,
) -> Vec<Trace> {
    let examined = entries.iter().filter(|entry| entry.outcome.is_ok());
    let poorest = examined.max_by(|a, b| a.value.total_cmp(&b.value));
    let mut shown: Vec<&Entry> = best.map(|best| &entries[best.entry]).into_iter().chain(poorest).collect();
    shown.dedup_by(|a, b| a.name == b.name);
    let features = 0..study.features.len();
    features.flat_map(|index| shown.iter().map(move |entry| trace(evaluator, study, entry, index))).collect()
}

fn trace(evaluator: &Evaluator, study: &PlacementStudy, entry: &Entry, index: usize) -> Trace {
    let job = &study.features[index];
    let machine = job.machine();
    let feature = &job.feature;
    let tasks = evaluator.tasks(&entry.site, index);
    let case =
        PathCase { nominal: machine, real: evaluator.real(index), unloaded: machine, before: None, tasks: &tasks };
    let errors = |method| {
        let answers = run(&case, &Commands::Method(method), &|| {});
        answers.iter().map(PathAnswer::settled_error).collect::<Vec<_>>()
    };
    let limited = job.limits.is_limited().then(|| evaluator.features[index].errors_left(job, &tasks).ok()).flatten();
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
