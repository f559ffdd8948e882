//! Refinement of γ between the values of the lattice: lowers the cost of each point as far as the γ of its neighbours and the limits allow.

use super::{
    knots::length_and_time,
    lattice::{Shape, TIE_MM},
    nodes::{Node, NodeState, Solver, map_points},
    turnable::RotatablePath,
};
use crate::{
    input::error::Result,
    statics::Batch,
    work::{Event, Stage, Work},
};

/// Most passes over the path.
const SWEEPS: usize = 6;
/// Rounds in which a point's interval of γ is narrowed.
const ROUNDS: usize = 2;
/// Values of γ tried in a round.
const TRIALS: usize = Batch::WIDTH;

/// Path, limits and branch of a refinement.
pub(super) struct Refinement<'a> {
    pub path: &'a RotatablePath<'a>,
    pub shape: &'a Shape,
    /// Number of the branch.
    pub branch: usize,
    /// Most change of γ per length, rad/mm.
    pub rate: f64,
    /// Most change of a point's γ in a sweep, rad.
    pub max_shift: f64,
    pub work: &'a Work,
}

impl Refinement<'_> {
    /// Refines `gammas` (rad, one for each point) sweep by sweep, within the band between points. `Err` if `work` is stopped.
    pub fn refine(&self, mut gammas: Vec<f64>) -> Result<Vec<f64>> {
        let mut nodes: Vec<Node> = map_points(self.path, &(0..gammas.len()).collect::<Vec<_>>(), |solver, k| {
            solver.nodes_on_branch(k, self.branch, &[gammas[k]]).swap_remove(0)
        });
        for _ in 0..SWEEPS {
            let mut is_moved = false;
            self.work.tell(Event::Stage(Stage { of: "points between γ", items: gammas.len() }));
            // Neighbours stay while a point is moved.
            for parity in [0, 1] {
                self.work.check()?;
                let points: Vec<usize> = (parity..gammas.len())
                    .step_by(2)
                    .filter(|k| self.path.is_counted(*k) || nodes[*k].is_err())
                    .collect();
                let moved = map_points(self.path, &points, |solver, k| self.improve(solver, k, &gammas, &nodes));
                self.work.tell(Event::Computed(points.len()));
                for (k, found) in points.into_iter().zip(moved) {
                    if let Some((gamma, at)) = found {
                        (gammas[k], nodes[k]) = (gamma, Ok(at));
                        is_moved = true;
                    }
                }
            }
            if !is_moved {
                break;
            }
        }
        Ok(gammas)
    }

    /// A γ (rad) of path point `k` that costs less than `gammas[k]`, with its state; `None` if there is none within the limits.
    fn improve(&self, solver: &mut Solver<'_>, k: usize, gammas: &[f64], nodes: &[Node]) -> Option<(f64, NodeState)> {
        let points = self.path.points();
        let [lowest, highest] = self.path.problem.settings.range_deg.map(f64::to_radians);
        let (mut low, mut high) = (gammas[k] - self.max_shift, gammas[k] + self.max_shift);
        if !self.shape.is_cyclic {
            (low, high) = (low.max(lowest), high.min(highest));
        }
        let mut neighbours: Vec<(usize, f64)> = Vec::with_capacity(2);
        let sides = [(k.checked_sub(1), k), (Some(k + 1).filter(|next| *next < points.len()), k + 1)];
        for (beside, later) in sides {
            let Some(beside) = beside else { continue };
            let (length, seconds) = length_and_time(&points[later - 1], &points[later]);
            (low, high) = (low.max(gammas[beside] - self.rate * length), high.min(gammas[beside] + self.rate * length));
            neighbours.push((beside, seconds));
        }
        let is_tracked = |at: &NodeState| {
            neighbours.iter().all(|(beside, seconds)| {
                nodes[*beside].as_ref().map_or(true, |other| self.shape.allows(&other.drives, &at.drives, *seconds))
            })
        };
        let mut best = nodes[k].ok().map(|at| (gammas[k], at));
        let mut is_found = false;
        for _ in 0..ROUNDS {
            let width = (high - low) / (TRIALS - 1) as f64;
            if width <= 0.0 {
                break;
            }
            let tried: Vec<f64> = (0..TRIALS).map(|i| low + width * i as f64).collect();
            for (gamma, node) in tried.iter().zip(solver.nodes_on_branch(k, self.branch, &tried)) {
                let Ok(at) = node else { continue };
                if best.is_none_or(|(_, best)| at.cost_mm < best.cost_mm - TIE_MM) && is_tracked(&at) {
                    best = Some((*gamma, at));
                    is_found = true;
                }
            }
            let Some((middle, _)) = best else { break };
            (low, high) = (low.max(middle - width), high.min(middle + width));
        }
        best.filter(|_| is_found)
    }
}
