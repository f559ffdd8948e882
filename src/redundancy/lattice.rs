//! The cheapest way through a lattice of turns and branches, knot after knot: dynamic programming. Of a knot that is passed, two
//! bytes for each node are kept.

use serde::Serialize;

use super::{
    nodes::{Infeasible, Node, Standing},
    turnable::MOST_DRIVES,
};
use crate::{
    machine::Machine,
    process::{RedundancySettings, RedundancyObjective},
};

/// Nodes of a knot.
#[derive(Debug, Clone)]
pub struct Layer {
    /// How much its cost counts.
    pub weight: f64,
    /// Steps by which the turn may change from the knot before.
    pub band: usize,
    /// Time from there, s.
    pub seconds: f64,
    /// Turn by turn, the branches of each.
    pub nodes: Vec<Node>,
}

/// What the lattice is like.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// Ways to stand.
    pub branches: usize,
    /// Turns.
    pub turns: usize,
    /// Whether the last turn neighbours the first.
    pub wraps: bool,
    /// Of each drive, what a full turn of it is, rad; `None` of a slide.
    pub full_turns: Vec<Option<f64>>,
    /// Fastest motion of each drive, rad/s; none if empty.
    pub speeds: Vec<f64>,
    /// Turn and branch that are nearest to as programmed; none is preferred without.
    pub programmed: Option<(usize, usize)>,
}

/// Costs that differ by no more are the same, mm: what solving the machine leaves open.
pub const TIE_MM: f64 = 1e-9;

/// A hinge that moves by a larger share of a full turn from one point to the next is not tracked there: it has swung about.
const SWUNG: f64 = 0.25;

impl Shape {
    /// How far and fast drives of `machine` may move: without a lattice.
    #[must_use]
    pub fn of(machine: &Machine, turn: &RedundancySettings) -> Self {
        let speeds = turn.speed_limits_deg_per_s.iter().map(|limit| limit.to_radians()).collect();
        Self { full_turns: machine.full_turns().collect(), speeds, ..Self::default() }
    }

    /// Whether the drives may go from `before` to `after` within `seconds`.
    #[must_use]
    pub fn allows(&self, before: &[f64; MOST_DRIVES], after: &[f64; MOST_DRIVES], seconds: f64) -> bool {
        let way = |k: usize| (after[k] - before[k]).abs();
        let is_tracked = |(k, turn): (usize, &Option<f64>)| turn.is_none_or(|turn| way(k) <= SWUNG * turn);
        self.full_turns.iter().enumerate().all(is_tracked)
            && self.speeds.iter().enumerate().all(|(k, most)| way(k) <= most * seconds)
    }

    /// What a node costs more than one that is as programmed, mm: never more than a tie, together with [`Shape::motion`], beside which it is
    /// little, so that a path begins turned and does not turn on its way.
    fn aside(&self, node: usize) -> f64 {
        let Some((turn, branch)) = self.programmed else { return 0.0 };
        let stands_aside = node % self.branches != branch;
        TIE_MM * (0.05 * self.apart(turn, node / self.branches) + if stands_aside { 0.25 } else { 0.0 })
    }

    /// What it costs more to turn from one turn to another than to stay, mm.
    fn motion(&self, from: usize, to: usize) -> f64 {
        if self.programmed.is_some() { 0.5 * TIE_MM * self.apart(from, to) } else { 0.0 }
    }

    /// How far two turns are apart, as a share of the farthest.
    fn apart(&self, a: usize, b: usize) -> f64 {
        let steps = a.abs_diff(b);
        match self.wraps {
            true => steps.min(self.turns - steps) as f64 / (self.turns / 2).max(1) as f64,
            false => steps as f64 / self.turns.saturating_sub(1).max(1) as f64,
        }
    }

    /// Turns from which `turn` is reached in `steps` steps either way.
    fn near(&self, turn: usize, steps: usize) -> impl Iterator<Item = usize> + use<> {
        let (turns, wraps) = (self.turns, self.wraps);
        let there = move |k: usize| match wraps {
            true => Some((turn + turns - k % turns) % turns),
            false => turn.checked_sub(k),
        };
        let back = move |k: usize| match wraps {
            true => Some((turn + k) % turns),
            false => Some(turn + k).filter(|turn| *turn < turns),
        };
        let is_twice = move |k: usize| k == 0 || (wraps && 2 * k == turns);
        let most = if wraps { steps.min(turns / 2) } else { steps.min(turns - 1) };
        (0..=most).flat_map(move |k| there(k).into_iter().chain(back(k).filter(|_| !is_twice(k))))
    }
}

/// Where a way through the lattice ends, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeadEnd {
    /// Index of the point.
    pub point: usize,
    /// What hinders most turns there; `None` if there are some, but none that is reached from the point before within the band of
    /// turns and the speeds of the drives.
    pub infeasible: Option<Infeasible>,
}

impl DeadEnd {
    /// Word in tables.
    #[must_use]
    pub fn label(&self) -> &'static str {
        self.infeasible.map_or("no_continuous_path", Infeasible::label)
    }

    /// In words.
    #[must_use]
    pub fn reason(&self) -> String {
        let why = match self.infeasible {
            Some(Infeasible::Unreachable) => "no rotation γ can be reached",
            Some(Infeasible::Limits) => "the travel of the drives allows no γ",
            Some(Infeasible::Singularity) => "all γ are nearer to a singularity than is allowed",
            Some(Infeasible::NotStable) => "no stable equilibrium of the loaded machine was found at any γ",
            None => "no γ continues from the point before within max_step_deg_per_mm and the speeds of the drives",
        };
        format!("point {}: {why}", self.point)
    }

    pub(super) fn of(point: usize, nodes: &[Node]) -> Self {
        let count = |infeasible: Infeasible| nodes.iter().filter(|node| **node == Err(infeasible)).count();
        let most = Infeasible::ALL.into_iter().rev().max_by_key(|infeasible| count(*infeasible));
        Self { point, infeasible: most.filter(|_| nodes.iter().all(Result::is_err)) }
    }
}

/// What holding one turn on one branch comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// Sum of squares of what counts, mm².
    pub squares: f64,
    /// Of how many points.
    pub weight: f64,
    /// The largest, mm.
    pub worst: f64,
}

/// What a motion in air is weighed by, mm: about what tools leave their paths by where they cut.
const AIR_MM: f64 = 1.0;

/// No node before.
const NONE: u16 = u16::MAX;

/// A walk through the lattice.
#[derive(Debug)]
pub struct Walk {
    shape: Shape,
    objective: RedundancyObjective,
    /// No node may cost more.
    ceiling_mm: f64,
    /// The cheapest way to each node of the last knot: mm or mm², as the objective says.
    value: Vec<f64>,
    before: Vec<Node>,
    /// Of each knot but the first, the turn before each node.
    back: Vec<u16>,
    /// What holding each turn comes to; `None` where it cannot be held.
    pub held: Vec<Option<Held>>,
    /// The first knot that no way leads to.
    pub dead_end: Option<DeadEnd>,
}

impl Walk {
    /// A walk that has passed nothing. `worst` objectives are solved twice: first for the least largest cost, then with that as
    /// `ceiling_mm` for the least sum of squares.
    #[must_use]
    pub fn new(shape: Shape, objective: RedundancyObjective, ceiling_mm: f64) -> Self {
        let held = vec![Some(Held { squares: 0.0, weight: 0.0, worst: 0.0 }); shape.turns * shape.branches];
        let (value, before, back) = (Vec::new(), Vec::new(), Vec::new());
        Self { shape, objective, ceiling_mm, value, before, back, held, dead_end: None }
    }

    /// Goes on to the knot at `point`.
    pub fn step(&mut self, point: usize, layer: Layer) {
        let Layer { weight, band, seconds, nodes } = layer;
        let counted = |standing: &Standing| if weight > 0.0 { standing.cost_mm } else { 0.0 };
        let is_first = self.before.is_empty();
        let own: Vec<Option<&Standing>> =
            nodes.iter().map(|node| node.as_ref().ok().filter(|at| counted(at) <= self.ceiling_mm)).collect();
        self.hold(&nodes, weight, seconds, is_first);
        let (mut value, mut back) = (vec![f64::INFINITY; nodes.len()], vec![NONE; nodes.len()]);
        for (node, at) in own.iter().enumerate() {
            let Some(at) = at else { continue };
            // From as programmed to the first turn, as motion is: what has no effect is not turned back for.
            let aside = if is_first { self.shape.aside(node) } else { 0.0 };
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
                if is_first { Some((with(0.0, 0.0), NONE)) } else { self.reach(node, at, band, seconds, with) };
            let Some((cost, from)) = reached else { continue };
            (value[node], back[node]) = (cost, from);
        }
        if self.dead_end.is_none() && value.iter().all(|value| value.is_infinite()) {
            self.dead_end = Some(DeadEnd::of(point, &nodes));
        }
        if !is_first {
            self.back.extend(back);
        }
        (self.value, self.before) = (value, nodes);
    }

    /// The cheapest way to a node at which the machine stands as in `at`, and the turn that it comes from; `with`: what a way comes to with
    /// the node, from what it came to before and what the motion costs.
    fn reach(
        &self,
        node: usize,
        at: &Standing,
        band: usize,
        seconds: f64,
        with: impl Fn(f64, f64) -> f64,
    ) -> Option<(f64, u16)> {
        let (turn, branch) = (node / self.shape.branches, node % self.shape.branches);
        let mut cheapest: Option<(f64, u16)> = None;
        for from in self.shape.near(turn, band) {
            let before = from * self.shape.branches + branch;
            let so_far = self.value[before];
            if so_far.is_finite()
                && let value = with(so_far, self.shape.motion(from, turn))
                && cheapest.is_none_or(|(least, _)| value < least)
                && let Ok(standing) = &self.before[before]
                && self.shape.allows(&standing.drives, &at.drives, seconds)
            {
                cheapest = Some((value, from as u16));
            }
        }
        cheapest
    }

    fn hold(&mut self, nodes: &[Node], weight: f64, seconds: f64, is_first: bool) {
        for (k, (held, node)) in self.held.iter_mut().zip(nodes).enumerate() {
            let is_tracked = |at: &Standing| match self.before.get(k) {
                Some(Ok(before)) => self.shape.allows(&before.drives, &at.drives, seconds),
                _ => is_first,
            };
            *held = match (*held, node) {
                (Some(held), Ok(at)) if is_tracked(at) => Some(Held {
                    squares: held.squares + weight * at.cost_mm * at.cost_mm,
                    weight: held.weight + weight,
                    worst: if weight > 0.0 { held.worst.max(at.cost_mm) } else { held.worst },
                }),
                _ => None,
            };
        }
    }

    /// The cheapest way: what it comes to, the turn at each knot, and the branch.
    #[must_use]
    pub fn cheapest(&self) -> Option<(f64, Vec<usize>, usize)> {
        let nodes = self.value.len();
        let (mut node, value) = least(self.value.iter().copied())?;
        let branch = node % self.shape.branches;
        let mut turns = vec![node / self.shape.branches];
        for layer in self.back.chunks_exact(nodes).rev() {
            let from = layer[node] as usize;
            turns.push(from);
            node = from * self.shape.branches + branch;
        }
        turns.reverse();
        Some((value, turns, branch))
    }

    /// The turn and branch that are best held all along; of those that are so within a tie, the nearest to as programmed.
    #[must_use]
    pub fn best_held(&self) -> Option<(usize, usize)> {
        let held = || self.held.iter().enumerate().filter_map(|(node, held)| Some((node, (*held)?)));
        let most = match self.objective {
            RedundancyObjective::Rms => f64::INFINITY,
            RedundancyObjective::Worst => held().map(|(_, held)| held.worst).fold(f64::INFINITY, f64::min) + TIE_MM,
        };
        let rms = |held: &Held| (held.squares / held.weight.max(1.0)).sqrt();
        let within = || held().filter(|(_, held)| held.worst <= most).map(|(node, held)| (node, rms(&held)));
        let least = within().map(|(_, rms)| rms).fold(f64::INFINITY, f64::min);
        let tied = within().filter(|(_, rms)| *rms <= least + TIE_MM).map(|(node, _)| node);
        let node = tied.reduce(|a, b| if self.shape.aside(b) < self.shape.aside(a) { b } else { a })?;
        Some((node / self.shape.branches, node % self.shape.branches))
    }
}

/// The first of the least finite values.
fn least(values: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    values.enumerate().filter(|(_, value)| value.is_finite()).reduce(|a, b| if b.1 < a.1 { b } else { a })
}
