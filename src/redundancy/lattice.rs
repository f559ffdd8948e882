//! The cheapest path through a lattice of γ and branches by dynamic programming, knot after knot. Each passed node keeps two bytes.

use serde::Serialize;

use super::{
    knots::Knot,
    nodes::{Infeasible, Node, NodeState},
    turnable::MAX_DRIVES,
};
use crate::{
    machine::Machine,
    process::{RedundancyObjective, RedundancySettings},
};

/// Size of the lattice and limits of its steps.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// Number of branches.
    pub branches: usize,
    /// Number of values of γ.
    pub gammas: usize,
    /// Whether the last γ neighbours the first.
    pub is_cyclic: bool,
    /// Full turn of each drive, rad; `None` for a linear drive.
    pub full_turns: Vec<Option<f64>>,
    /// Speed limit of each drive, rad/s; no limits if empty.
    pub speeds: Vec<f64>,
    /// Indices of the γ and the branch nearest to the programmed ones, which win ties; `None` prefers none.
    pub programmed: Option<(usize, usize)>,
}

/// Costs that differ by less are equal, mm: the tolerance of the solver.
pub const TIE_MM: f64 = 1e-9;

/// A revolute joint that moves by a larger share of a full turn between two knots has swung about and is not tracked.
const SWUNG: f64 = 0.25;

impl Shape {
    /// Step limits of `machine` (full turns and speed limits of its drives), with the numbers of branches and γ still 0.
    #[must_use]
    pub fn with_limits_of(machine: &Machine, settings: &RedundancySettings) -> Self {
        let speeds = settings.speed_limits_deg_per_s.iter().map(|limit| limit.to_radians()).collect();
        Self { full_turns: machine.full_turns().collect(), speeds, ..Self::default() }
    }

    /// Whether the drives may move from `before` to `after` (mm or rad) within `seconds`.
    #[must_use]
    pub fn allows(&self, before: &[f64; MAX_DRIVES], after: &[f64; MAX_DRIVES], seconds: f64) -> bool {
        let distance = |k: usize| (after[k] - before[k]).abs();
        let is_tracked = |(k, full): (usize, &Option<f64>)| full.is_none_or(|full| distance(k) <= SWUNG * full);
        self.full_turns.iter().enumerate().all(is_tracked)
            && self.speeds.iter().enumerate().all(|(k, most)| distance(k) <= most * seconds)
    }

    /// Cost (mm) of a node off the programmed γ or branch: less than a tie, small beside [`Shape::step_penalty`], so that γ rather stays.
    fn tie_penalty(&self, node: usize) -> f64 {
        let Some((gamma, branch)) = self.programmed else { return 0.0 };
        let is_other_branch = node % self.branches != branch;
        TIE_MM * (0.05 * self.distance(gamma, node / self.branches) + if is_other_branch { 0.25 } else { 0.0 })
    }

    /// Cost (mm) added to a change from γ index `from` to `to`; 0 without a programmed γ.
    fn step_penalty(&self, from: usize, to: usize) -> f64 {
        if self.programmed.is_some() { 0.5 * TIE_MM * self.distance(from, to) } else { 0.0 }
    }

    /// Steps between the γ indices `a` and `b`, the shorter way if γ wraps, as a share (0 to 1) of the largest distance.
    fn distance(&self, a: usize, b: usize) -> f64 {
        let steps = a.abs_diff(b);
        match self.is_cyclic {
            true => steps.min(self.gammas - steps) as f64 / (self.gammas / 2).max(1) as f64,
            false => steps as f64 / self.gammas.saturating_sub(1).max(1) as f64,
        }
    }

    /// Indices of the values of γ at most `steps` steps from index `gamma`, each once, nearest first.
    fn neighbours(&self, gamma: usize, steps: usize) -> impl Iterator<Item = usize> + use<> {
        let (gammas, is_cyclic) = (self.gammas, self.is_cyclic);
        let down = move |k: usize| match is_cyclic {
            true => Some((gamma + gammas - k % gammas) % gammas),
            false => gamma.checked_sub(k),
        };
        let up = move |k: usize| match is_cyclic {
            true => Some((gamma + k) % gammas),
            false => Some(gamma + k).filter(|gamma| *gamma < gammas),
        };
        let is_twice = move |k: usize| k == 0 || (is_cyclic && 2 * k == gammas);
        let most = if is_cyclic { steps.min(gammas / 2) } else { steps.min(gammas - 1) };
        (0..=most).flat_map(move |k| down(k).into_iter().chain(up(k).filter(|_| !is_twice(k))))
    }
}

/// The point at which the path through the lattice ends, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeadEnd {
    /// Index of the path point.
    pub point: usize,
    /// Most frequent reason there; `None` if some γ are feasible, but none continues from the point before within band and speed limits.
    pub infeasible: Option<Infeasible>,
}

impl DeadEnd {
    /// The value of this reason in tables.
    #[must_use]
    pub fn label(&self) -> &'static str {
        self.infeasible.map_or("no_continuous_path", Infeasible::label)
    }

    /// The point and the reason in words.
    #[must_use]
    pub fn reason(&self) -> String {
        let why = match self.infeasible {
            Some(Infeasible::Unreachable) => "no rotation γ can be reached",
            Some(Infeasible::Limits) => "the travel of the drives allows no γ",
            Some(Infeasible::Singularity) => "all γ are nearer to a singularity than is allowed",
            Some(Infeasible::Workspace) => "all γ lead P out of the workspace box",
            Some(Infeasible::NotStable) => "no stable equilibrium of the loaded machine was found at any γ",
            None => "no γ continues from the point before within max_step_deg_per_mm and the speeds of the drives",
        };
        format!("point {}: {why}", self.point)
    }

    /// The dead end at path point `point`: all `nodes` are infeasible, mostly for its reason, or none is connected to the point before.
    pub(super) fn at(point: usize, nodes: &[Node]) -> Self {
        let count = |infeasible: Infeasible| nodes.iter().filter(|node| **node == Err(infeasible)).count();
        let most = Infeasible::ALL.into_iter().rev().max_by_key(|infeasible| count(*infeasible));
        Self { point, infeasible: most.filter(|_| nodes.iter().all(Result::is_err)) }
    }
}

/// Cost of one constant γ on one branch so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantCost {
    /// Weighted sum of squared costs, mm².
    pub squares: f64,
    /// Sum of the weights.
    pub weight: f64,
    /// Largest counted cost, mm.
    pub worst: f64,
}

/// Cost that weighs motion between cuts, mm: about the deviation of tools that cut.
const AIR_MM: f64 = 1.0;

/// Marks a node without predecessor.
const NONE: u16 = u16::MAX;

/// Dynamic programming over the lattice, as far as the last knot.
#[derive(Debug)]
pub struct Walk {
    shape: Shape,
    objective: RedundancyObjective,
    /// Nodes that cost more are left out, mm.
    ceiling_mm: f64,
    /// Cost of the cheapest path to each node of the last knot, mm or mm² as the objective says.
    value: Vec<f64>,
    last_nodes: Vec<Node>,
    /// Index of the best γ before, for each node of all knots but the first.
    back: Vec<u16>,
    /// Cost of each constant γ on each branch; `None` where it is infeasible.
    pub costs: Vec<Option<ConstantCost>>,
    /// The first knot that no path reaches.
    pub dead_end: Option<DeadEnd>,
}

impl Walk {
    /// Starts before the first knot; nodes that cost more than `ceiling_mm` are left out.
    #[must_use]
    pub fn new(shape: Shape, objective: RedundancyObjective, ceiling_mm: f64) -> Self {
        let costs = vec![Some(ConstantCost { squares: 0.0, weight: 0.0, worst: 0.0 }); shape.gammas * shape.branches];
        let (value, last_nodes, back) = (Vec::new(), Vec::new(), Vec::new());
        Self { shape, objective, ceiling_mm, value, last_nodes, back, costs, dead_end: None }
    }

    /// Adds `knot`: extends the cheapest paths and constant costs to its `nodes`, γ by γ, the branches of each; may set `dead_end`.
    pub fn step(&mut self, knot: &Knot, nodes: Vec<Node>) {
        let Knot { point, weight, band, seconds } = *knot;
        let counted = |state: &NodeState| if weight > 0.0 { state.cost_mm } else { 0.0 };
        let is_first = self.last_nodes.is_empty();
        let within_ceiling: Vec<Option<&NodeState>> =
            nodes.iter().map(|node| node.as_ref().ok().filter(|state| counted(state) <= self.ceiling_mm)).collect();
        self.update_constant(&nodes, weight, seconds, is_first);
        let (mut value, mut back) = (vec![f64::INFINITY; nodes.len()], vec![NONE; nodes.len()]);
        for (node, at) in within_ceiling.iter().enumerate() {
            let Some(at) = at else { continue };
            // The first γ is charged once, like a step: a γ without effect is not turned back.
            let aside = if is_first { self.shape.tie_penalty(node) } else { 0.0 };
            let with = |so_far: f64, more: f64| {
                let cost = at.cost_mm + aside + more;
                match self.objective {
                    RedundancyObjective::Rms if weight > 0.0 => so_far + weight * cost * cost,
                    // Where nothing is cut, motion alone, wherever it is.
                    RedundancyObjective::Rms => so_far + (aside + more) * AIR_MM,
                    RedundancyObjective::Worst if weight > 0.0 => so_far.max(cost),
                    RedundancyObjective::Worst => so_far,
                }
            };
            let reached =
                if is_first { Some((with(0.0, 0.0), NONE)) } else { self.cheapest_step(node, at, band, seconds, with) };
            let Some((cost, from)) = reached else { continue };
            (value[node], back[node]) = (cost, from);
        }
        if self.dead_end.is_none() && value.iter().all(|value| value.is_infinite()) {
            self.dead_end = Some(DeadEnd::at(point, &nodes));
        }
        if !is_first {
            self.back.extend(back);
        }
        (self.value, self.last_nodes) = (value, nodes);
    }

    /// Cost of the cheapest path to `node` with state `at`, and the index of γ before it. `with(cost, penalty)` adds this node to a path.
    fn cheapest_step(
        &self,
        node: usize,
        at: &NodeState,
        band: usize,
        seconds: f64,
        with: impl Fn(f64, f64) -> f64,
    ) -> Option<(f64, u16)> {
        let (gamma, branch) = (node / self.shape.branches, node % self.shape.branches);
        let mut cheapest: Option<(f64, u16)> = None;
        for from in self.shape.neighbours(gamma, band) {
            let before = from * self.shape.branches + branch;
            let so_far = self.value[before];
            if so_far.is_finite()
                && let value = with(so_far, self.shape.step_penalty(from, gamma))
                && cheapest.is_none_or(|(least, _)| value < least)
                && let Ok(previous) = &self.last_nodes[before]
                && self.shape.allows(&previous.drives, &at.drives, seconds)
            {
                cheapest = Some((value, from as u16));
            }
        }
        cheapest
    }

    /// Adds a knot with `nodes` to the cost of each constant γ; one that is infeasible there or cannot be tracked becomes `None`.
    fn update_constant(&mut self, nodes: &[Node], weight: f64, seconds: f64, is_first: bool) {
        for (k, (cost, node)) in self.costs.iter_mut().zip(nodes).enumerate() {
            let is_tracked = |at: &NodeState| match self.last_nodes.get(k) {
                Some(Ok(before)) => self.shape.allows(&before.drives, &at.drives, seconds),
                _ => is_first,
            };
            *cost = match (*cost, node) {
                (Some(cost), Ok(at)) if is_tracked(at) => Some(ConstantCost {
                    squares: cost.squares + weight * at.cost_mm * at.cost_mm,
                    weight: cost.weight + weight,
                    worst: if weight > 0.0 { cost.worst.max(at.cost_mm) } else { cost.worst },
                }),
                _ => None,
            };
        }
    }

    /// The cheapest path: cost (mm or mm², as the objective says), index of γ at each knot, and index of the branch; `None` at a dead end.
    #[must_use]
    pub fn cheapest(&self) -> Option<(f64, Vec<usize>, usize)> {
        let nodes = self.value.len();
        let (mut node, value) = least(self.value.iter().copied())?;
        let branch = node % self.shape.branches;
        let mut gammas = vec![node / self.shape.branches];
        for layer in self.back.chunks_exact(nodes).rev() {
            let from = layer[node] as usize;
            gammas.push(from);
            node = from * self.shape.branches + branch;
        }
        gammas.reverse();
        Some((value, gammas, branch))
    }

    /// Indices of the best constant γ and its branch; within a tie the nearest to as programmed. `None` if none is feasible.
    #[must_use]
    pub fn best_constant(&self) -> Option<(usize, usize)> {
        let costs = || self.costs.iter().enumerate().filter_map(|(node, cost)| Some((node, (*cost)?)));
        let most = match self.objective {
            RedundancyObjective::Rms => f64::INFINITY,
            RedundancyObjective::Worst => costs().map(|(_, cost)| cost.worst).fold(f64::INFINITY, f64::min) + TIE_MM,
        };
        let rms = |cost: &ConstantCost| (cost.squares / cost.weight.max(1.0)).sqrt();
        let within = || costs().filter(|(_, cost)| cost.worst <= most).map(|(node, cost)| (node, rms(&cost)));
        let least = within().map(|(_, rms)| rms).fold(f64::INFINITY, f64::min);
        let tied = within().filter(|(_, rms)| *rms <= least + TIE_MM).map(|(node, _)| node);
        let node = tied.reduce(|a, b| if self.shape.tie_penalty(b) < self.shape.tie_penalty(a) { b } else { a })?;
        Some((node / self.shape.branches, node % self.shape.branches))
    }
}

/// Index and value of the least finite value, the first of equal ones; `None` if none is finite.
fn least(values: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    values.enumerate().filter(|(_, value)| value.is_finite()).reduce(|a, b| if b.1 < a.1 { b } else { a })
}
