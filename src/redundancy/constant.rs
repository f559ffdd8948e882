//! The best constant γ of a whole path, between the values of the lattice.

use super::{
    knots::length_and_time,
    lattice::{Shape, TIE_MM},
    nodes::{Node, NodeState, map_points},
    turnable::RotatablePath,
};
use crate::{input::error::Result, process::RedundancyObjective, statics::Batch, work::Work};

/// Rounds in which the interval of γ is narrowed.
const ROUNDS: usize = 3;
/// Values of γ tried in a round.
const TRIALS: usize = Batch::WIDTH;

/// Returns the best constant γ (rad) within one `step` (rad) of `gamma` on the branch with index `branch`. `Err` if `work` is stopped.
pub(super) fn refine(
    path: &RotatablePath<'_>,
    shape: &Shape,
    branch: usize,
    gamma: f64,
    step: f64,
    work: &Work,
) -> Result<f64> {
    let [lowest, highest] = path.problem.settings.range_deg.map(f64::to_radians);
    let (mut low, mut high) = (gamma - step, gamma + step);
    if !shape.is_cyclic {
        (low, high) = (low.max(lowest), high.min(highest));
    }
    let mut best = (gamma, constant_costs(path, shape, branch, &[gamma])[0]);
    if gamma != 0.0 && (lowest..=highest).contains(&0.0) {
        let as_programmed = constant_costs(path, shape, branch, &[0.0])[0];
        if as_programmed <= best.1 + TIE_MM {
            (best, low, high) = ((0.0, as_programmed), -step, step);
        }
    }
    for _ in 0..ROUNDS {
        work.check()?;
        let width = (high - low) / (TRIALS - 1) as f64;
        let tried: Vec<f64> = (0..TRIALS).map(|i| low + width * i as f64).collect();
        for (gamma, cost) in tried.iter().zip(constant_costs(path, shape, branch, &tried)) {
            if cost < best.1 - TIE_MM {
                best = (*gamma, cost);
            }
        }
        (low, high) = (low.max(best.0 - width), high.min(best.0 + width));
    }
    Ok(best.0)
}

/// Objective (mm) of the path at each of `gammas` (rad) as constant γ, on branch index `branch`; infinite where it is infeasible.
fn constant_costs(path: &RotatablePath<'_>, shape: &Shape, branch: usize, gammas: &[f64]) -> Vec<f64> {
    let points: Vec<usize> = (0..path.points().len()).collect();
    let layers: Vec<Vec<Node>> = map_points(path, &points, |solver, k| solver.nodes_on_branch(k, branch, gammas));
    let objective = path.problem.settings.objective;
    let cost = |gamma: usize| -> Option<f64> {
        let (mut sum, mut before): (f64, Option<NodeState>) = (0.0, None);
        for (k, nodes) in layers.iter().enumerate() {
            let state = nodes[gamma].ok()?;
            if let Some(before) = before {
                let (_, seconds) = length_and_time(&path.points()[k - 1], &path.points()[k]);
                if !shape.allows(&before.drives, &state.drives, seconds) {
                    return None;
                }
            }
            before = Some(state);
            if path.is_counted(k) {
                sum = match objective {
                    RedundancyObjective::Rms => sum + state.cost_mm * state.cost_mm,
                    RedundancyObjective::Worst => sum.max(state.cost_mm),
                };
            }
        }
        let counted = (0..layers.len()).filter(|k| path.is_counted(*k)).count().max(1);
        Some(if objective == RedundancyObjective::Rms { (sum / counted as f64).sqrt() } else { sum })
    };
    (0..gammas.len()).map(|gamma| cost(gamma).unwrap_or(f64::INFINITY)).collect()
}
