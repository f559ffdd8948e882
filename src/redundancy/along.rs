//! The loaded tool along a path that has been turned, by exact equilibria, tracked from point to point as every path is.

use nalgebra::Vector3;
use serde::Serialize;

use super::turnable::Turnable;
use crate::{
    compensation::{Method, TaskPoint},
    simulation::{
        Machines, Source,
        along_path::{Commands, PathCase, run},
    },
};

/// What the loaded tool does along a path, where it counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TurnedAlong {
    /// What counts of the distance from the path at each point, mm; `None` where the machine does not settle or cannot be tracked.
    #[serde(skip)]
    pub cost_mm: Vec<Option<f64>>,
    /// The largest, mm; `None` where no point is solved.
    pub worst_mm: Option<f64>,
    /// Mean, mm.
    pub mean_mm: Option<f64>,
    /// Root mean square, mm.
    pub rms_mm: Option<f64>,
    /// Points that count, and those of them that are solved.
    pub points: usize,
    /// See `points`.
    pub solved: usize,
    /// The first point at which the machine does not settle or cannot be tracked, and why.
    pub first_failure: Option<(usize, String)>,
}

/// Leads `machines` along `tasks`, which `path` asks for at the turns that are looked at, uncompensated.
pub(super) fn along(path: &Turnable<'_>, machines: &Machines, tasks: &[TaskPoint]) -> TurnedAlong {
    let answers = run(&PathCase::new(machines, Source::All, tasks), &Commands::Method(Method::None), &|| ());
    let cost = |(k, error): (usize, Option<Vector3<f64>>)| error.map(|error| path.cost(k, &error));
    let failure = answers.iter().position(|answer| !answer.is_settled);
    let first_failure = failure.map(|k| (k, answers[k].status.reason(&machines.nominal)));
    let cost_mm: Vec<Option<f64>> =
        answers.iter().map(crate::simulation::along_path::PathAnswer::settled_error).enumerate().map(cost).collect();
    summed_up(path, cost_mm, first_failure)
}

fn summed_up(path: &Turnable<'_>, cost_mm: Vec<Option<f64>>, first_failure: Option<(usize, String)>) -> TurnedAlong {
    let counted: Vec<Option<f64>> =
        cost_mm.iter().enumerate().filter(|(k, _)| path.counts(*k)).map(|(_, cost)| *cost).collect();
    let solved: Vec<f64> = counted.iter().copied().flatten().collect();
    let mean = |sum: f64| (!solved.is_empty()).then(|| sum / solved.len() as f64);
    TurnedAlong {
        worst_mm: solved.iter().copied().reduce(f64::max),
        mean_mm: mean(solved.iter().sum()),
        rms_mm: mean(solved.iter().map(|cost| cost * cost).sum()).map(f64::sqrt),
        points: counted.len(),
        solved: solved.len(),
        first_failure,
        cost_mm,
    }
}
