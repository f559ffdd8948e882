//! What happens with the workpiece at a place.

use serde::{Deserialize, Serialize};

use super::{Explorer, Workpiece, check};
use crate::{
    input::error::{Error, Result},
    machine::Machine,
    questions::placement::{Along, AlongPoint, Metric, Metrics, Site, is_angle, stride},
    simulation::Failure,
    spatial::Pose,
};

/// A place that is asked about.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceAsked {
    /// x, y, z in mm, yaw, pitch and roll in degrees.
    pub place: [f64; 6],
    /// Most points to be looked at, about; all of them if not given.
    pub most: Option<usize>,
}

/// What happens there.
#[derive(Debug, Clone, Serialize)]
pub struct PlaceAnswer {
    /// The place.
    pub place: [f64; 6],
    /// One point of every so many was looked at; 1 where all were.
    pub stride: usize,
    /// Columns of the workpiece's axes in O, and its origin, mm.
    pub workpiece: [[f64; 3]; 4],
    /// The points of each feature.
    pub features: Vec<Vec<PointShown>>,
    /// Why the workpiece cannot be cut here, if it cannot.
    pub failure: Option<Failure>,
    /// Where the path leaves the machine's workspace box, if it does.
    pub outside_workspace: Option<Failure>,
    /// What the place is judged by; where points were left out or cannot be cut, of the others.
    pub metrics: Vec<MetricShown>,
    /// The objective, of all points.
    pub objective: Option<f64>,
}

/// A point as it is shown: mm, degrees, N and N·mm.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs, reason = "as in AlongPoint")]
pub struct PointShown {
    pub index: usize,
    pub wanted: [f64; 3],
    pub before: Option<[f64; 3]>,
    pub after: Option<[f64; 3]>,
    pub drives: Vec<f64>,
    pub corrections: Option<Vec<f64>>,
    pub forces: Option<Vec<f64>>,
    pub failure: Option<Failure>,
}

/// A metric with its value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MetricShown {
    /// Word used in study files.
    pub name: &'static str,
    /// In words.
    pub words: &'static str,
    /// Empty for shares.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
}

impl Explorer {
    /// Looks at the workpiece at a place.
    ///
    /// # Errors
    /// There is no workpiece, or this is no place.
    pub fn place(&self, asked: &PlaceAsked) -> Result<PlaceAnswer> {
        let Workpiece { study, evaluator } = self.workpiece()?;
        let site = site(asked.place)?;
        let stride = asked.most.map_or(1, |most| stride(&study.features, most));
        let Along { features, outcome, known } = evaluator.along(&site, stride);
        let (failure, outside_workspace, metrics) = match &outcome {
            Ok(evaluation) => (None, evaluation.outside_workspace.clone(), evaluation.metrics),
            Err(failure) => (Some(failure.clone()), None, known),
        };
        let is_whole = stride == 1 && failure.is_none();
        let shown = |(points, job): (Vec<AlongPoint>, &crate::questions::placement::FeatureJob)| {
            points.into_iter().map(|point| shown(point, job.machine())).collect()
        };
        Ok(PlaceAnswer {
            place: asked.place,
            stride,
            workpiece: columns(&study.workpiece(&site)),
            features: features.into_iter().zip(&study.features).map(shown).collect(),
            failure,
            outside_workspace,
            metrics: shown_metrics(&metrics, &study.machine),
            objective: is_whole.then(|| study.objective.value(&metrics)).filter(|value| value.is_finite()),
        })
    }

    pub(super) fn workpiece(&self) -> Result<&Workpiece> {
        self.workpiece.as_ref().ok_or_else(|| Error::argument("place", "there is no workpiece in this scene"))
    }
}

/// A place from numbers as they are shown.
pub(super) fn site(shown: [f64; 6]) -> Result<Site> {
    check("place", "six numbers", &shown)?;
    Ok(Site(std::array::from_fn(|i| if is_angle(i) { shown[i].to_radians() } else { shown[i] })))
}

/// Columns of the axes, and the origin.
pub(super) fn columns(pose: &Pose) -> [[f64; 3]; 4] {
    let column = |i: usize| pose.rotation.column(i).into_owned().into();
    [column(0), column(1), column(2), pose.translation.into()]
}

fn shown(point: AlongPoint, machine: &Machine) -> PointShown {
    let positions = |values: Vec<f64>| super::tool::shown(machine, &values);
    PointShown {
        index: point.index,
        wanted: point.wanted_mm.into(),
        before: point.before_mm.map(Into::into),
        after: point.after_mm.map(Into::into),
        drives: positions(point.drives),
        corrections: point.corrections.map(positions),
        forces: point.drive_forces,
        failure: point.failure,
    }
}

fn shown_metrics(metrics: &Metrics, machine: &Machine) -> Vec<MetricShown> {
    let shown = |metric: Metric| {
        let value = metrics.get(metric).filter(|value| value.is_finite())?;
        Some(MetricShown {
            name: metric.label(),
            words: metric.words(machine),
            unit: metric.shown_unit(machine),
            value,
        })
    };
    Metric::ALL.into_iter().filter_map(shown).collect()
}
