//! Cost of a path at given γ: exact equilibria of the loaded machine, tracked from point to point.

use nalgebra::Vector3;
use serde::Serialize;

use super::turnable::RotatablePath;
use crate::{
    compensation::{Method, TaskPoint},
    simulation::{
        Machines, Source,
        along_path::{Commands, PathCase, PathPointResult, run},
    },
};

/// How far the loaded tool is from a path, at the points that count.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathCost {
    /// Distance of the loaded tool from the path at each point as the cost setting measures it, mm; `None` where it is not solved.
    #[serde(skip)]
    pub cost_mm: Vec<Option<f64>>,
    /// Largest cost, mm; `None` if no point is solved.
    pub worst_mm: Option<f64>,
    /// Mean cost, mm.
    pub mean_mm: Option<f64>,
    /// Root mean square cost, mm.
    pub rms_mm: Option<f64>,
    /// Number of points that count.
    pub points: usize,
    /// Number of those that are solved.
    pub solved: usize,
    /// Index of the first unsolved point, and the reason.
    pub first_failure: Option<(usize, String)>,
}

/// Tracks `tasks`, one for each point of `path`, uncompensated, with all sources of error; returns the cost at each point, and
/// statistics over those that count.
pub(super) fn path_cost(path: &RotatablePath<'_>, machines: &Machines, tasks: &[TaskPoint]) -> PathCost {
    let case = PathCase::new(machines, Source::All, tasks);
    let results = run(&case, &Commands::Method(Method::None), &|| ());
    let cost = |(k, error): (usize, Option<Vector3<f64>>)| error.map(|error| path.cost(k, &error));
    let failure = results.iter().position(|result| !result.is_settled);
    let first_failure = failure.map(|k| (k, results[k].status.reason(&machines.nominal)));
    let cost_mm: Vec<Option<f64>> = results.iter().map(PathPointResult::solved_error).enumerate().map(cost).collect();
    let counted: Vec<Option<f64>> =
        cost_mm.iter().enumerate().filter(|(k, _)| path.is_counted(*k)).map(|(_, cost)| *cost).collect();
    let solved: Vec<f64> = counted.iter().copied().flatten().collect();
    let mean = |sum: f64| (!solved.is_empty()).then(|| sum / solved.len() as f64);
    PathCost {
        worst_mm: solved.iter().copied().reduce(f64::max),
        mean_mm: mean(solved.iter().sum()),
        rms_mm: mean(solved.iter().map(|cost| cost * cost).sum()).map(f64::sqrt),
        points: counted.len(),
        solved: solved.len(),
        first_failure,
        cost_mm,
    }
}
