//! Evaluates the workpiece at a place.

use serde::{Deserialize, Serialize};

use super::{Explorer, Workpiece, check_numbers, effect::lines_under};
use crate::{
    input::error::{Error, Result},
    machine::Machine,
    questions::placement::{Metric, Metrics, PlacePoint, PlaceResults, Site, is_angle, stride},
    simulation::{Failure, Source},
    spatial::{Pose, Skeleton},
};

/// A place of the workpiece to evaluate.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceRequest {
    /// x, y, z in mm, yaw, pitch and roll in degrees.
    pub place: [f64; 6],
    /// About the largest number of points to evaluate; all points if not given.
    pub most: Option<usize>,
    /// Feature and point at which the machine is wanted; if not given, where the error is the largest.
    pub shown: Option<[usize; 2]>,
}

/// Errors, metrics and feasibility of the workpiece at a place.
#[derive(Debug, Clone, Serialize)]
pub struct PlaceResult {
    /// The place.
    pub place: [f64; 6],
    /// Every how many points one was evaluated; 1 for all.
    pub stride: usize,
    /// Columns of the workpiece's axes in O, and its origin, mm.
    pub workpiece: [[f64; 3]; 4],
    /// Evaluated points of each feature.
    pub features: Vec<Vec<PointShown>>,
    /// Reason why the place is infeasible, if it is.
    pub failure: Option<Failure>,
    /// Where the path leaves the machine's workspace box, if it does.
    pub outside_workspace: Option<Failure>,
    /// Metrics with the workpiece exactly there, over the evaluated and feasible points only.
    pub metrics: Vec<MetricShown>,
    /// Objective with the workpiece exactly there, over all points; `None` if points were left out or the place is infeasible.
    pub objective: Option<f64>,
    /// The machine at one point; `None` if it has no equilibrium there.
    pub machine: Option<MachineAt>,
}

/// The machine at a point of a path, under its load there.
#[derive(Debug, Clone, Serialize)]
pub struct MachineAt {
    /// Feature and point.
    pub point: [usize; 2],
    /// Displacement of the tool tip, O axes, mm.
    pub displacement: [f64; 3],
    /// From which displacements are measured: as commanded, or in equilibrium under its weight and springs.
    pub commanded: Skeleton,
    /// In equilibrium.
    pub loaded: Skeleton,
}

/// A point of a path in the units that pages show: mm, degrees, N and N·mm.
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
    /// Its word in study files.
    pub name: &'static str,
    /// In words.
    pub words: &'static str,
    /// Unit; empty for shares.
    pub unit: &'static str,
    /// Value in that unit.
    pub value: f64,
}

impl Explorer {
    /// Evaluates the workpiece at a place.
    ///
    /// # Errors
    /// There is no workpiece, or the place has an invalid number.
    pub fn place(&self, request: &PlaceRequest) -> Result<PlaceResult> {
        let Workpiece { study, evaluator } = self.workpiece()?;
        let site = site_from_shown(request.place)?;
        let stride = request.most.map_or(1, |most| stride(&study.features, most));
        let PlaceResults { features, outcome, known } = evaluator.solve_points(&site, stride);
        let (failure, outside_workspace, metrics) = match &outcome {
            Ok(evaluation) => (None, evaluation.outside_workspace.clone(), evaluation.metrics),
            Err(failure) => (Some(failure.clone()), None, known),
        };
        let is_complete = stride == 1 && failure.is_none();
        let errors = features.iter().enumerate().flat_map(|(f, points)| {
            points.iter().filter_map(move |point| Some(([f, point.index], point.before_mm?.norm_squared())))
        });
        let worst = errors.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(point, _)| point);
        let machine = request.shown.or(worst).and_then(|point| {
            let (machines, task) = evaluator.task_at(&site, point[0], point[1])?;
            let lines = lines_under(machines, Source::All, &task).ok()?;
            let displacement = lines.tool_displacement_mm.into();
            Some(MachineAt { point, displacement, commanded: lines.commanded, loaded: lines.loaded })
        });
        let shown = |(points, job): (Vec<PlacePoint>, &crate::questions::placement::FeatureJob)| {
            points.into_iter().map(|point| shown_point(point, job.machine())).collect()
        };
        Ok(PlaceResult {
            place: request.place,
            stride,
            workpiece: columns(&study.workpiece_pose(&site)),
            features: features.into_iter().zip(&study.features).map(shown).collect(),
            failure,
            outside_workspace,
            metrics: shown_metrics(&metrics, &study.machine),
            objective: is_complete.then(|| study.objective.value(&metrics)).filter(|value| value.is_finite()),
            machine,
        })
    }

    /// Returns the workpiece of the scene, or an error if there is none.
    pub(super) fn workpiece(&self) -> Result<&Workpiece> {
        self.workpiece.as_ref().ok_or_else(|| Error::argument("place", "there is no workpiece in this scene"))
    }
}

/// Returns the site of a place given in mm and degrees; an error for an invalid number.
pub(super) fn site_from_shown(shown: [f64; 6]) -> Result<Site> {
    check_numbers("place", "six numbers", &shown)?;
    Ok(Site(std::array::from_fn(|i| if is_angle(i) { shown[i].to_radians() } else { shown[i] })))
}

/// Returns the columns of a pose's rotation, and its origin, mm.
pub(super) fn columns(pose: &Pose) -> [[f64; 3]; 4] {
    let column = |i: usize| pose.rotation.column(i).into_owned().into();
    [column(0), column(1), column(2), pose.translation.into()]
}

/// Returns a point of a path in the units that pages show.
fn shown_point(point: PlacePoint, machine: &Machine) -> PointShown {
    let positions = |values: Vec<f64>| super::tool::shown_values(machine, &values);
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

/// Returns all finite metrics in the units that pages show.
fn shown_metrics(metrics: &Metrics, machine: &Machine) -> Vec<MetricShown> {
    let shown = |metric: Metric| {
        let value = metrics.get(metric).filter(|value| value.is_finite())?;
        Some(MetricShown { name: metric.label(), words: metric.text(machine), unit: metric.shown_unit(machine), value })
    };
    Metric::ALL.into_iter().filter_map(shown).collect()
}
