//! Turns between those of the lattice: each point's own cost made small, as far as its neighbours' turns and the limits allow.

use rayon::prelude::*;

use super::{
    knots::way,
    lattice::{Shape, TIE_MM},
    nodes::{Node, Solver, Standing},
    turnable::Turnable,
};
use crate::{
    input::error::Result,
    statics::Batch,
    work::{Event, Stage, Work},
};

/// Passes over the path.
const SWEEPS: usize = 6;
/// Rounds in which a point's turn is narrowed down, each to a fraction of the one before.
const ROUNDS: usize = 2;
/// Turns looked at in a round.
const TRIED: usize = Batch::WIDTH;

/// Points that one thread takes at a time.
const CHUNK: usize = 64;

/// What a path is refined on.
pub(super) struct Refined<'a> {
    pub path: &'a Turnable<'a>,
    pub shape: &'a Shape,
    /// The branch.
    pub branch: usize,
    /// Most change of the turn per length, rad/mm.
    pub rate: f64,
    /// Farthest that a turn is moved in a sweep, rad.
    pub reach: f64,
    pub work: &'a Work,
}

impl Refined<'_> {
    /// `turns` (rad, one for each point) moved to where each point costs less; the change from point to point stays within the band.
    ///
    /// # Errors
    /// Of the work.
    pub fn refined(&self, mut turns: Vec<f64>) -> Result<Vec<f64>> {
        let mut standing: Vec<Node> = self.each(&(0..turns.len()).collect::<Vec<_>>(), |solver, k| {
            solver.nodes_on_branch(k, self.branch, &[turns[k]]).swap_remove(0)
        });
        for _ in 0..SWEEPS {
            let mut is_moved = false;
            self.work.tell(Event::Stage(Stage { of: "points between γ", items: turns.len() }));
            // Neighbours stay while a point is moved.
            for parity in [0, 1] {
                self.work.check()?;
                let places: Vec<usize> = (parity..turns.len())
                    .step_by(2)
                    .filter(|k| self.path.counts(*k) || standing[*k].is_err())
                    .collect();
                let moved = self.each(&places, |solver, k| self.better(solver, k, &turns, &standing));
                self.work.tell(Event::Computed(places.len()));
                for (k, found) in places.into_iter().zip(moved) {
                    if let Some((turn, at)) = found {
                        (turns[k], standing[k]) = (turn, Ok(at));
                        is_moved = true;
                    }
                }
            }
            if !is_moved {
                break;
            }
        }
        Ok(turns)
    }

    /// What `find` has for each of `places`.
    fn each<T: Send>(&self, places: &[usize], find: impl Fn(&mut Solver<'_>, usize) -> T + Sync) -> Vec<T> {
        let chunks = places.par_chunks(CHUNK).map(|places| {
            let mut solver = Solver::new(self.path);
            places.iter().map(|k| find(&mut solver, *k)).collect::<Vec<T>>()
        });
        chunks.flatten_iter().collect()
    }

    /// A turn of point `k` that costs less, and where the machine stands there.
    fn better(&self, solver: &mut Solver<'_>, k: usize, turns: &[f64], standing: &[Node]) -> Option<(f64, Standing)> {
        let points = self.path.points();
        let [lowest, highest] = self.path.asked.turn.range_deg.map(f64::to_radians);
        let (mut low, mut high) = (turns[k] - self.reach, turns[k] + self.reach);
        if !self.shape.wraps {
            (low, high) = (low.max(lowest), high.min(highest));
        }
        let mut ways: Vec<(usize, f64)> = Vec::with_capacity(2);
        let sides = [(k.checked_sub(1), k), (Some(k + 1).filter(|next| *next < points.len()), k + 1)];
        for (beside, later) in sides {
            let Some(beside) = beside else { continue };
            let (length, seconds) = way(&points[later - 1], &points[later]);
            (low, high) = (low.max(turns[beside] - self.rate * length), high.min(turns[beside] + self.rate * length));
            ways.push((beside, seconds));
        }
        let is_tracked = |at: &Standing| {
            ways.iter().all(|(beside, seconds)| {
                standing[*beside].as_ref().map_or(true, |there| self.shape.allows(&there.drives, &at.drives, *seconds))
            })
        };
        let mut best = standing[k].ok().map(|at| (turns[k], at));
        let mut is_found = false;
        for _ in 0..ROUNDS {
            let width = (high - low) / (TRIED - 1) as f64;
            if width <= 0.0 {
                break;
            }
            let tried: Vec<f64> = (0..TRIED).map(|i| low + width * i as f64).collect();
            for (turn, node) in tried.iter().zip(solver.nodes_on_branch(k, self.branch, &tried)) {
                let Ok(at) = node else { continue };
                if best.is_none_or(|(_, best)| at.cost_mm < best.cost_mm - TIE_MM) && is_tracked(&at) {
                    best = Some((*turn, at));
                    is_found = true;
                }
            }
            let Some((middle, _)) = best else { break };
            (low, high) = (low.max(middle - width), high.min(middle + width));
        }
        best.filter(|_| is_found)
    }
}
