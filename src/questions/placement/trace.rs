//! Where the tool goes at a place, point by point.

use nalgebra::Vector3;
use serde::Serialize;

use super::{Best, Entry, Evaluator, PlacementStudy, bounded};
use crate::{
    compensation::Method,
    simulation::along_path::{Commands, PathAnswer, PathCase, run},
};

/// The path of one feature at one place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trace {
    /// Name of the place.
    pub place: String,
    /// Index of the feature.
    pub feature: usize,
    /// Where the point put right should be, O axes, mm.
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
    let demands = evaluator.demands(&entry.site, index);
    let case =
        PathCase { nominal: machine, real: evaluator.real(index), resting: machine, before: None, demands: &demands };
    let errors = |method| {
        let answers = run(&case, &Commands::Method(method), &|| {});
        answers.iter().map(PathAnswer::settled_error).collect::<Vec<_>>()
    };
    let limited =
        job.limits.is_limited().then(|| bounded::errors_left(machine, case.real, &demands, job).ok()).flatten();
    Trace {
        place: entry.name.clone(),
        feature: index,
        wanted: demands.iter().map(|demand| demand.pose.transform(demand.offset(machine))).collect(),
        before: errors(Method::None),
        after: limited.unwrap_or_else(|| errors(Method::Direct)),
        cutting: feature.path.points().iter().map(|point| point.cutting).collect(),
        arc_length_mm: feature.path.points().iter().map(|point| point.arc_length_mm).collect(),
    }
}
