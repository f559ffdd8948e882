//! Rotation about the tool axis, the redundancy angle γ: at which γ the loaded tool stays nearest to its path.
//!
//! A machine that controls all six coordinates, with a tool that rotates, may turn its platform about the tool's axis by any angle γ at
//! each point. Where a lattice of points, turns and branches has nodes, the loaded machine is solved exactly (`nodes`); the cheapest
//! way through it within a band of turns is found by dynamic programming (`lattice`), and turns between its own are found point by
//! point (`refine`). What is said of the result is what the machine does when it is tracked along the turned path (`along`).

mod along;
#[cfg(not(target_family = "wasm"))]
mod at_points;
mod constant;
mod knots;
mod lattice;
mod nodes;
mod refine;
#[cfg(feature = "report")]
pub mod report;
mod turnable;

use std::cmp::Ordering;

use rayon::prelude::*;
use serde::Serialize;

pub use along::TurnedAlong;
#[cfg(not(target_family = "wasm"))]
pub(crate) use at_points::at_points;
pub use lattice::DeadEnd;
pub use nodes::Infeasible;
#[cfg(not(target_family = "wasm"))]
pub(crate) use nodes::Node;
#[cfg(not(target_family = "wasm"))]
pub(crate) use turnable::check;
pub use turnable::{OnBranch, TurnAsked};

use self::{
    knots::{Knot, knots},
    lattice::{Layer, Shape, TIE_MM, Walk},
    nodes::Solver,
    refine::Refined,
    turnable::Turnable,
};
use crate::{
    compensation::TaskPoint,
    input::error::{Error, Result},
    machine::{Branch, Machine},
    process::{GammaChoice, RedundancyObjective},
    simulation::Machines,
    toolpath::Toolpath,
    work::{Event, Stage, Work},
};

#[cfg(not(target_family = "wasm"))]
use crate::{machine::Configuration, process::RedundancySettings, toolpath::PathPoint};

/// What tests hold against all ways: no part of the interface.
#[doc(hidden)]
pub mod internals {
    pub use super::{
        lattice::{Layer, Shape, Walk},
        nodes::Standing,
        turnable::MOST_DRIVES,
    };
}

/// Knots whose nodes are computed together.
const STRIPE: usize = 64;
/// Most nodes of a lattice, all knots together.
const MOST_NODES: usize = 1 << 28;

/// Turns along a path, and what the loaded tool does then.
#[derive(Debug, Clone, Serialize)]
pub struct Turned {
    /// The branch on which the machine stands, of an arm.
    pub branch: Option<Branch>,
    /// The machine on it.
    #[serde(skip)]
    pub machine: Machine,
    /// γ at each point, degrees.
    #[serde(skip)]
    pub turns_deg: Vec<f64>,
    /// Least and largest γ, degrees.
    pub range_deg: [f64; 2],
    /// The path with its platform turned so.
    #[serde(skip)]
    pub path: Toolpath,
    /// What the loaded tool does along it.
    pub along: TurnedAlong,
}

/// What was found on the lattice.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OnLattice {
    /// Index of the point of each knot.
    pub points: Vec<usize>,
    /// γ there, degrees: the turns of the lattice, gone on from one to the next.
    pub turns_deg: Vec<f64>,
    /// The branch, of an arm.
    pub branch: Option<Branch>,
    /// What it comes to over the points that count, mm: root mean square or largest, as the objective says.
    pub value_mm: f64,
}

/// Rotation about the tool axis along a path.
#[derive(Debug, Clone)]
pub struct FoundGamma {
    /// At the orientations that the path gives.
    pub as_programmed: TurnedAlong,
    /// Turned by the same angle everywhere.
    pub best_constant: std::result::Result<Turned, DeadEnd>,
    /// Turned point by point; the constant turn where only that is sought.
    pub best: std::result::Result<Turned, DeadEnd>,
    /// What the lattice came to.
    pub on_lattice: std::result::Result<OnLattice, DeadEnd>,
    /// Branches that are left out since the machine cannot stand on them, and why.
    pub refused: Vec<(Branch, String)>,
    /// Points that count.
    pub counted: Vec<bool>,
}

impl FoundGamma {
    /// The turns that `redundancy` asks for; `None` as programmed.
    #[must_use]
    pub fn chosen(&self, redundancy: GammaChoice) -> Option<&std::result::Result<Turned, DeadEnd>> {
        match redundancy {
            GammaChoice::AsProgrammed => None,
            GammaChoice::BestConstant => Some(&self.best_constant),
            GammaChoice::Best => Some(&self.best),
        }
    }
}

/// Seeks the turns about the tool's axis along a path, on the current rayon pool. What is found does not depend on its threads.
///
/// # Errors
/// A machine that cannot turn its tool freely, a lattice that is too large, and those of `work`.
pub fn seek(asked: TurnAsked<'_>, work: &Work) -> Result<FoundGamma> {
    let path = Turnable::new(asked)?;
    let lattice = Lattice::new(&path)?;
    let as_programmed = along::along(&path, &Machines::new(asked.machine, asked.errors)?, &programmed(&path));
    let walk = lattice.walk(asked.turn.objective, f64::INFINITY, work)?;
    let best_constant = match walk.best_held() {
        Some((turn, on_branch)) => {
            let turn = constant::refined(&path, &lattice.shape, on_branch, lattice.turns[turn], lattice.step, work)?;
            Ok(turned(&path, on_branch, vec![turn; path.points().len()]))
        }
        None => Err(walk.dead_end.clone().unwrap_or(DeadEnd { point: 0, infeasible: None })),
    };
    let (on_lattice, best) = if asked.turn.gamma == GammaChoice::Best {
        best(&path, &lattice, walk, &best_constant, work)?
    } else {
        (lattice.found(&walk, asked.turn.objective).map(|(_, found)| found), best_constant.clone())
    };
    let counted = (0..path.points().len()).map(|k| path.counts(k)).collect();
    Ok(FoundGamma { as_programmed, best_constant, best, on_lattice, refused: path.refused, counted })
}

/// What the cheapest turns of the lattice come to along a path at a place, mm, as the objective says; without refinement. For searches
/// that ask of many places.
///
/// # Errors
/// As [`seek`].
pub fn lattice_cost(asked: TurnAsked<'_>, work: &Work) -> Result<std::result::Result<OnLattice, DeadEnd>> {
    let path = Turnable::new(asked)?;
    let lattice = Lattice::new(&path)?;
    let walk = lattice.walk(asked.turn.objective, f64::INFINITY, work)?;
    Ok(lattice.found(&walk, asked.turn.objective).map(|(_, found)| found))
}

/// The turns of the lattice at which the machine can be at each point of a path at a place, rad, and as programmed if that is within their
/// range: those that leave the loaded tool nearest to the path first. For searches that ask of many places.
///
/// # Errors
/// A machine that cannot turn its tool freely, and those of `work`.
#[cfg(not(target_family = "wasm"))]
pub fn turns_by_cost(asked: TurnAsked<'_>, work: &Work) -> Result<std::result::Result<Vec<f64>, DeadEnd>> {
    let path = Turnable::new(asked)?;
    let [low, high] = asked.turn.range_deg;
    let mut turns = path.turns();
    if (low..=high).contains(&0.0) && !turns.contains(&0.0) {
        turns.push(0.0);
    }
    let mut solver = Solver::new(&path);
    let mut costs = vec![Some(0.0f64); turns.len() * path.on_branches.len()];
    for k in 0..path.points().len() {
        work.check()?;
        let nodes = solver.layer(k, &turns);
        for (cost, node) in costs.iter_mut().zip(&nodes) {
            let so_far = cost.zip(node.ok().map(|at| at.cost_mm));
            *cost = so_far.map(|(so_far, here)| match asked.turn.objective {
                _ if !path.counts(k) => so_far,
                RedundancyObjective::Rms => so_far + here * here,
                RedundancyObjective::Worst => so_far.max(here),
            });
        }
        if costs.iter().all(Option::is_none) {
            return Ok(Err(DeadEnd::of(k, &nodes)));
        }
    }
    let least = |costs: &[Option<f64>]| costs.iter().flatten().copied().reduce(f64::min);
    let of_turns = turns.into_iter().zip(costs.chunks(path.on_branches.len()).map(least));
    let mut found: Vec<(f64, f64)> = of_turns.filter_map(|(turn, cost)| Some((cost?, turn))).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(Ok(found.into_iter().map(|(_, turn)| turn).collect()))
}

/// Why the machine cannot go on to a point at which it stands `here`, from the point `before`: the room that turns leave to the ends of
/// travel and to singularities, and how far and how fast drives move.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn infeasible_turns(
    turn: &RedundancySettings,
    machine: &Machine,
    before: Option<(&PathPoint, &Configuration)>,
    here: (&PathPoint, &Configuration),
) -> Option<&'static str> {
    if let Err(infeasible) = nodes::room(turn, machine, here.1) {
        return Some(infeasible.words());
    }
    let (before, last) = before?;
    let (_, seconds) = knots::way(before, here.0);
    let drives = |at: &Configuration| {
        let mut drives = [0.0; turnable::MOST_DRIVES];
        drives.iter_mut().zip(&at.drives).for_each(|(own, rho)| *own = *rho);
        drives
    };
    let is_tracked = Shape::of(machine, turn).allows(&drives(last), &drives(here.1), seconds);
    (!is_tracked).then_some("reached from the point before only by a swing of a hinge, or faster than the drives move")
}

/// The path of `asked` with its platform turned by `turn`, rad, all along.
///
/// # Errors
/// A machine that cannot turn its tool freely.
#[cfg(not(target_family = "wasm"))]
pub fn turned_by(asked: TurnAsked<'_>, turn: f64) -> Result<Toolpath> {
    let path = Turnable::new(asked)?;
    Ok(path.turned(&vec![turn; path.points().len()]))
}

/// What the path asks for as it is.
fn programmed(path: &Turnable<'_>) -> Vec<TaskPoint> {
    (0..path.points().len()).map(|k| path.task(k, 0.0)).collect()
}

/// The cheapest turns of the lattice, refined; never worse than the constant one.
fn best(
    path: &Turnable<'_>,
    lattice: &Lattice<'_>,
    walk: Walk,
    constant: &std::result::Result<Turned, DeadEnd>,
    work: &Work,
) -> Result<(std::result::Result<OnLattice, DeadEnd>, std::result::Result<Turned, DeadEnd>)> {
    let objective = path.asked.turn.objective;
    let (walk, of_lattice) = match (objective, walk.cheapest()) {
        (RedundancyObjective::Worst, Some((largest, ..))) => {
            (lattice.walk(RedundancyObjective::Rms, largest, work)?, Some(largest))
        }
        _ => (walk, None),
    };
    let (on_branch, mut found) = match lattice.found(&walk, RedundancyObjective::Rms) {
        Ok(found) => found,
        Err(dead_end) => return Ok((Err(dead_end.clone()), Err(dead_end))),
    };
    found.value_mm = of_lattice.unwrap_or(found.value_mm);
    let refined = Refined {
        path,
        shape: &lattice.shape,
        branch: on_branch,
        rate: path.asked.turn.max_step_deg_per_mm.to_radians(),
        reach: lattice.step,
        work,
    };
    let turns = refined.refined(lattice.between(&found))?;
    let best = turned(path, on_branch, turns);
    let value = |turned: &Turned| match objective {
        RedundancyObjective::Rms => turned.along.rms_mm,
        RedundancyObjective::Worst => turned.along.worst_mm,
    };
    let unsolved = |turned: &Turned| turned.along.points - turned.along.solved;
    // To turn on the way must be worth more than a tie.
    let is_as_good = |constant: &&Turned| match unsolved(constant).cmp(&unsolved(&best)) {
        Ordering::Equal => value(constant).zip(value(&best)).is_none_or(|(held, turned)| held <= turned + TIE_MM),
        other => other == Ordering::Less,
    };
    let best = constant.as_ref().ok().filter(is_as_good).cloned().unwrap_or(best);
    Ok((Ok(found), Ok(best)))
}

/// The path turned by `turns` (rad), and what the machine does along it on branch number `on_branch`.
fn turned(path: &Turnable<'_>, on_branch: usize, turns: Vec<f64>) -> Turned {
    let OnBranch { branch, machine, machines } = &path.on_branches[on_branch];
    let tasks: Vec<TaskPoint> = turns.iter().enumerate().map(|(k, turn)| path.task(k, *turn)).collect();
    let turns_deg: Vec<f64> = turns.iter().map(|turn| turn.to_degrees()).collect();
    let end = |of: fn(f64, f64) -> f64| turns_deg.iter().copied().reduce(of).unwrap_or_default();
    Turned {
        branch: *branch,
        machine: machine.clone(),
        range_deg: [end(f64::min), end(f64::max)],
        turns_deg,
        path: path.turned(&turns),
        along: along::along(path, machines, &tasks),
    }
}

/// The lattice of a path.
struct Lattice<'a> {
    path: &'a Turnable<'a>,
    /// rad.
    turns: Vec<f64>,
    /// Between neighbouring turns, rad.
    step: f64,
    shape: Shape,
    knots: Vec<Knot>,
}

impl<'a> Lattice<'a> {
    fn new(path: &'a Turnable<'a>) -> Result<Self> {
        let (turns, turn) = (path.turns(), path.asked.turn);
        let [low, high] = turn.range_deg.map(f64::to_radians);
        let step = (high - low) / (turns.len() - usize::from(!path.wraps())) as f64;
        let knots = knots(path.points(), turn.max_step_deg_per_mm.to_radians() / step, |k| path.counts(k));
        let of_drives = Shape::of(path.asked.machine, turn);
        let nearest = (0..turns.len()).min_by(|a, b| turns[*a].abs().total_cmp(&turns[*b].abs())).unwrap_or_default();
        let own = path.asked.machine.branch_of(&path.asked.machine.home);
        let on_branch = path.on_branches.iter().position(|on_branch| on_branch.branch == own).unwrap_or_default();
        let (branches, wraps, programmed) = (path.on_branches.len(), path.wraps(), Some((nearest, on_branch)));
        let shape = Shape { branches, turns: turns.len(), wraps, programmed, ..of_drives };
        let nodes = knots.len().saturating_mul(shape.turns * shape.branches);
        if nodes > MOST_NODES {
            let problem = format!(
                "the lattice of {} points, {} values of γ and {} branches has {nodes} nodes: expected at most {MOST_NODES}; a larger \
                 redundancy.step_deg or a part of the path has fewer",
                knots.len(),
                shape.turns,
                shape.branches
            );
            return Err(Error::Argument { argument: "redundancy".into(), problem });
        }
        Ok(Self { path, turns, step, shape, knots })
    }

    /// Walks through all knots.
    fn walk(&self, objective: RedundancyObjective, ceiling_mm: f64, work: &Work) -> Result<Walk> {
        let mut walk = Walk::new(self.shape.clone(), objective, ceiling_mm);
        work.tell(Event::Stage(Stage { of: "points at all γ", items: self.knots.len() }));
        for knots in self.knots.chunks(STRIPE) {
            work.check()?;
            let layers = knots.par_iter().map_init(
                || Solver::new(self.path),
                |solver, knot| Layer {
                    weight: knot.weight,
                    band: knot.band,
                    seconds: knot.seconds,
                    nodes: solver.layer(knot.point, &self.turns),
                },
            );
            let layers: Vec<Layer> = layers.collect();
            for (knot, layer) in knots.iter().zip(layers) {
                walk.step(knot.point, layer);
            }
            work.tell(Event::Computed(knots.len()));
        }
        Ok(walk)
    }

    /// What `walk` has found: the branch, and the turns at the knots.
    fn found(&self, walk: &Walk, objective: RedundancyObjective) -> std::result::Result<(usize, OnLattice), DeadEnd> {
        let dead_end = || walk.dead_end.clone().unwrap_or(DeadEnd { point: 0, infeasible: None });
        let (value, places, on_branch) = walk.cheapest().ok_or_else(dead_end)?;
        let counted: f64 = self.knots.iter().map(|knot| knot.weight).sum();
        let value_mm = match objective {
            RedundancyObjective::Rms => (value / counted.max(1.0)).sqrt(),
            RedundancyObjective::Worst => value,
        };
        let mut turns_deg: Vec<f64> = Vec::with_capacity(places.len());
        for (k, place) in places.iter().enumerate() {
            let steps = k.checked_sub(1).map_or(0, |before| self.steps(places[before], *place));
            let before = turns_deg.last().copied().unwrap_or_else(|| self.turns[*place].to_degrees());
            turns_deg.push(before + steps as f64 * self.step.to_degrees());
        }
        let points = self.knots.iter().map(|knot| knot.point).collect();
        Ok((on_branch, OnLattice { points, turns_deg, branch: self.path.on_branches[on_branch].branch, value_mm }))
    }

    /// Steps from one turn of the lattice to another, the shorter way round.
    fn steps(&self, from: usize, to: usize) -> isize {
        let (apart, turns) = (to as isize - from as isize, self.shape.turns as isize);
        match self.shape.wraps {
            true if 2 * apart > turns => apart - turns,
            true if 2 * apart < -turns => apart + turns,
            _ => apart,
        }
    }

    /// γ at each point, rad: between knots in proportion to the length of the path.
    fn between(&self, found: &OnLattice) -> Vec<f64> {
        let points = self.path.points();
        let mut turns = Vec::with_capacity(points.len());
        for (k, point) in points.iter().enumerate() {
            let after = found.points.partition_point(|knot| *knot < k);
            let before = after.saturating_sub(1);
            let place = |knot: usize| points[found.points[knot]].arc_length_mm;
            let length = place(after) - place(before);
            let share = if length > 0.0 { (point.arc_length_mm - place(before)) / length } else { 1.0 };
            let turn = found.turns_deg[before] + share * (found.turns_deg[after] - found.turns_deg[before]);
            turns.push(turn.to_radians());
        }
        turns
    }
}
