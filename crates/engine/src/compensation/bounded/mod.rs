//! Bounded compensation: corrections of a whole path within limits.
//!
//! Limits on the drives can make exact compensation impossible in places. What is then best is a question about the whole path: a correction that
//! may only change so much from point to point must be prepared before the point that needs it. With the task error `e_k(ρ_k)` of the loaded
//! nonlinear machine at each point and corrections `Δρ_k = ρ_k − ρ_k⁰` from the nominal inverse kinematics,
//!
//! ```text
//! min  √(Σ ‖e_k‖² / N)   or   max ‖e_k‖
//! |Δρ_k| ≤ correction          |Δρ_k − Δρ_{k−1}| ≤ correction_change
//! ρ_k within travel            |τ_k(ρ_k)| ≤ force
//! ```
//!
//! is solved as a sequence of sparse convex programs (a quadratic one for the root mean square, a second-order cone program for the worst),
//! linearised with the exact sensitivities `∂e/∂ρ`, `∂τ/∂ρ` at the equilibria of the last iterate, until the nonlinear errors stop improving.
//! Where no limit binds the unbounded corrections are returned as [`Method::Direct`](super::Method::Direct) finds them. Where the drives control
//! more than is compensated, the rest is free: the drives move as little as serves the errors.
//!
//! The least root mean square may cost the worst point more than all corrections would gain it. It then is sought once more
//! under `‖e_k‖ ≤ max ‖e_k(ρ_k⁰)‖`, from no correction, unless that is outside the limits.

mod error;
mod limits;
mod outcome;
mod path;
mod program;
mod search;

use super::{outcome::CompensationStatus, session::CompensationSettings, task_point::TaskPoint};
use serde::{Deserialize, Serialize};

use crate::machine::Machine;

pub use error::BoundedError;
use limits::Bounds;
pub use limits::{LimitKind, Limits, Side};
pub use outcome::{Binding, BoundedPath, BoundedPoint, BoundedStatus, BoundedSummary, CorrectedPoint, Errors, Price};
use path::{Point, Simulator};
use search::{Search, SearchResult};

/// Measure of the errors along a path that is made as small as the limits allow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorNorm {
    /// The root mean square of the task errors.
    #[default]
    Rms,
    /// The largest task error; of all corrections with the same largest error (to some 10⁻⁵ of it), those of least root mean square.
    Worst,
}

/// Tolerances and number of iterations of the search for bounded corrections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundedSettings {
    /// Settings of the unbounded correction and of each equilibrium.
    pub point: CompensationSettings,
    /// Most linearisations of the path.
    pub max_iterations: usize,
    /// Accepted excess of a force in the nonlinear simulation, as a share of its limit.
    pub force_tolerance: f64,
}

impl Default for BoundedSettings {
    fn default() -> Self {
        Self { point: CompensationSettings::default(), max_iterations: 30, force_tolerance: 1e-6 }
    }
}

/// Corrects the path `tasks` (in order) within `limits` so that `objective` is smallest, with commands by `nominal` and simulation by `actual`.
///
/// Limits on correction, travel and change are kept to rounding, limits on forces to
/// [`BoundedSettings::force_tolerance`] in the nonlinear simulation. Points that cannot be reached or have no equilibrium
/// are left out and labelled. `progress` is called with the number of points done in the present pass over the path.
/// The travel of `nominal` limits the corrected drives, not the nominal command: a point outside may be corrected into it.
///
/// # Errors
/// Limits that make no sense or exclude one another, named with point, drive and values; a failure of the convex solver.
pub fn compensate_bounded(
    nominal: &Machine,
    actual: &Machine,
    tasks: &[TaskPoint],
    limits: &Limits,
    objective: ErrorNorm,
    settings: &BoundedSettings,
    progress: &dyn Fn(usize),
) -> Result<BoundedPath, BoundedError> {
    Bounds::new(limits, nominal, Vec::new(), &[])?;
    let with_forces = limits.has_force_limits(nominal);
    let unlimited = without_travel(nominal);
    let mut simulator = Simulator::new(&unlimited, actual, settings.point, with_forces);
    let mut reasons: Vec<Option<CompensationStatus>> = Vec::with_capacity(tasks.len());
    let (mut points, mut index) = (Vec::new(), Vec::new());
    for (k, task) in tasks.iter().enumerate() {
        match simulator.simulate_point(task) {
            Ok(point) => {
                points.push(point);
                index.push(k);
                reasons.push(None);
            }
            Err(status) => reasons.push(Some(status)),
        }
        progress(k + 1);
    }
    let commands: Vec<&[f64]> = points.iter().map(|point| point.command.drives.as_slice()).collect();
    let bounds = Bounds::new(limits, nominal, index, &commands)?;
    let (points, bounds, simulator) = (&points[..], &bounds, &mut simulator);
    let mut search =
        Search { points, limits, bounds, machine: nominal, simulator, objective, largest: None, settings, progress };
    let mut best = search.run()?;
    // The least root mean square may leave more at the worst point than there was.
    if let Some(largest) = largest_uncorrected(points)
        && best.iterate.errors.worst > largest
        && let Some(below) = search.run_below(largest)?
    {
        best = below;
    }
    Ok(conclude(nominal, points, bounds, best, objective, reasons))
}

/// The largest error without correction, mm; `None` if a point has no equilibrium there.
fn largest_uncorrected(points: &[Point]) -> Option<f64> {
    let errors = points.iter().map(|point| point.uncorrected.as_ref().map(|result| result.error.norm()));
    errors.collect::<Option<Vec<f64>>>().map(|errors| errors.into_iter().fold(0.0, f64::max))
}

/// The machine with unlimited travel of its drives; a redundant machine stays as it is, since travel decides where its drives stand.
fn without_travel(machine: &Machine) -> Machine {
    let mut unlimited = machine.clone();
    if machine.redundancy > 0 {
        return unlimited;
    }
    for drive in unlimited.chains.iter_mut().flat_map(|chain| &mut chain.drives) {
        drive.travel = None;
    }
    unlimited
}

/// Result for all tasks in order: points that take part as in `best`, and those left out for their `reasons` (`None`: takes part).
fn conclude(
    machine: &Machine,
    points: &[Point],
    bounds: &Bounds,
    best: SearchResult,
    objective: ErrorNorm,
    reasons: Vec<Option<CompensationStatus>>,
) -> BoundedPath {
    let corrected = corrected_points(machine, points, bounds, &best, objective);
    let before = points.iter().filter_map(|point| point.uncorrected.as_ref().map(|result| result.error.norm()));
    let summary = BoundedSummary {
        status: if points.is_empty() { BoundedStatus::Empty } else { best.status },
        before: Errors::from_lengths(before),
        after: best.iterate.errors,
        iterations: best.iterations,
        convex_iterations: best.convex_iterations,
        is_accurate: best.is_accurate,
        force_excess: best.iterate.excess,
        prices: prices(&corrected),
    };
    let mut corrected = corrected.into_iter();
    let label = |reason: Option<CompensationStatus>| match reason {
        Some(status) => Some(BoundedPoint::LeftOut(status)),
        None => corrected.next().map(BoundedPoint::Corrected),
    };
    BoundedPath { points: reasons.into_iter().filter_map(label).collect(), summary }
}

/// Results at the points that take part, with the limits that bind there.
fn corrected_points(
    machine: &Machine,
    points: &[Point],
    bounds: &Bounds,
    best: &SearchResult,
    objective: ErrorNorm,
) -> Vec<CorrectedPoint> {
    let iterate = &best.iterate;
    let corrections = iterate.corrections.chunks_exact(bounds.drive_count());
    let corrected = points.iter().zip(&iterate.results).zip(corrections).map(|((point, result), correction)| {
        let (position_error, residual_rotation) = point.errors(machine, &result.state);
        CorrectedPoint {
            drives: result.drives.clone(),
            correction: correction.to_vec(),
            error: result.error.norm(),
            position_error,
            residual_rotation,
            drive_forces: result.forces.clone(),
            binding: Vec::new(),
        }
    });
    let mut corrected: Vec<CorrectedPoint> = corrected.collect();
    // From mm² of half the sum of squares to mm of its root mean square.
    let per_multiplier = match objective {
        ErrorNorm::Rms if iterate.errors.rms > 0.0 => 1.0 / (points.len() as f64 * iterate.errors.rms),
        ErrorNorm::Rms => 0.0,
        ErrorNorm::Worst => 1.0,
    };
    for multiplier in &best.binding {
        let limit = multiplier.limit;
        if bounds.is_binding(&limit, &iterate.corrections, &iterate.results[limit.point].forces) {
            let price = per_multiplier * multiplier.value;
            let binding = Binding { drive: limit.drive, kind: limit.kind, side: limit.side, price };
            corrected[limit.point].binding.push(binding);
        }
    }
    corrected
}

/// Shadow prices summed along the path, for each kind of limit and drive, in that order.
fn prices(points: &[CorrectedPoint]) -> Vec<Price> {
    let mut sums = std::collections::BTreeMap::new();
    for binding in points.iter().flat_map(|point| &point.binding) {
        let (price, points) = sums.entry((binding.kind, binding.drive)).or_insert((0.0, 0));
        *price += binding.price;
        *points += 1;
    }
    sums.into_iter().map(|((kind, drive), (price, points))| Price { drive, kind, price, points }).collect()
}
