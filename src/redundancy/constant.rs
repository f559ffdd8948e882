//! One turn for the whole path, between those of the lattice.

use rayon::prelude::*;

use super::{
    knots::way,
    lattice::{Shape, TIE_MM},
    nodes::{Node, Solver, Standing},
    turnable::Turnable,
};
use crate::{input::error::Result, process::RedundancyObjective, statics::Batch, work::Work};

/// Rounds in which the turn is narrowed down.
const ROUNDS: usize = 3;
/// Turns looked at in a round.
const TRIED: usize = Batch::WIDTH;
/// Points that one thread takes at a time.
const CHUNK: usize = 64;

/// The best turn within a `step` (rad) of `turn` on branch number `branch`, rad.
///
/// # Errors
/// Of the work.
pub(super) fn refined(
    path: &Turnable<'_>,
    shape: &Shape,
    branch: usize,
    turn: f64,
    step: f64,
    work: &Work,
) -> Result<f64> {
    let [lowest, highest] = path.asked.turn.range_deg.map(f64::to_radians);
    let (mut low, mut high) = (turn - step, turn + step);
    if !shape.wraps {
        (low, high) = (low.max(lowest), high.min(highest));
    }
    let mut best = (turn, cost_of_each(path, shape, branch, &[turn])[0]);
    if turn != 0.0 && (lowest..=highest).contains(&0.0) {
        let as_programmed = cost_of_each(path, shape, branch, &[0.0])[0];
        if as_programmed <= best.1 + TIE_MM {
            (best, low, high) = ((0.0, as_programmed), -step, step);
        }
    }
    for _ in 0..ROUNDS {
        work.check()?;
        let width = (high - low) / (TRIED - 1) as f64;
        let tried: Vec<f64> = (0..TRIED).map(|i| low + width * i as f64).collect();
        for (turn, cost) in tried.iter().zip(cost_of_each(path, shape, branch, &tried)) {
            if cost < best.1 - TIE_MM {
                best = (*turn, cost);
            }
        }
        (low, high) = (low.max(best.0 - width), high.min(best.0 + width));
    }
    Ok(best.0)
}

/// What each of `turns` comes to if it is held all along, mm; infinite where it cannot be.
fn cost_of_each(path: &Turnable<'_>, shape: &Shape, branch: usize, turns: &[f64]) -> Vec<f64> {
    let places: Vec<usize> = (0..path.points().len()).collect();
    let chunks = places.par_chunks(CHUNK).map(|places| {
        let mut solver = Solver::new(path);
        places.iter().map(|k| solver.nodes_on_branch(*k, branch, turns)).collect::<Vec<Vec<Node>>>()
    });
    let layers: Vec<Vec<Node>> = chunks.flatten_iter().collect();
    let objective = path.asked.turn.objective;
    let held = |turn: usize| -> Option<f64> {
        let (mut sum, mut before): (f64, Option<Standing>) = (0.0, None);
        for (k, nodes) in layers.iter().enumerate() {
            let at = nodes[turn].ok()?;
            if let Some(before) = before {
                let (_, seconds) = way(&path.points()[k - 1], &path.points()[k]);
                if !shape.allows(&before.drives, &at.drives, seconds) {
                    return None;
                }
            }
            before = Some(at);
            if path.counts(k) {
                sum = match objective {
                    RedundancyObjective::Rms => sum + at.cost_mm * at.cost_mm,
                    RedundancyObjective::Worst => sum.max(at.cost_mm),
                };
            }
        }
        let counted = (0..layers.len()).filter(|k| path.counts(*k)).count().max(1);
        Some(if objective == RedundancyObjective::Rms { (sum / counted as f64).sqrt() } else { sum })
    };
    (0..turns.len()).map(|turn| held(turn).unwrap_or(f64::INFINITY)).collect()
}
