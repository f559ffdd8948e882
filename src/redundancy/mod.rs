//! Rotation about the tool axis, the redundancy angle γ: at which γ the loaded tool stays nearest to its path.
//!
//! A machine that controls all six coordinates, with a tool that rotates, may rotate its platform about the tool axis by any angle γ at
//! each point. At the nodes of a lattice of points, γ and branches the loaded machine is solved exactly (`nodes`); the cheapest path
//! through it within a band of γ is found by dynamic programming (`lattice`), and γ between those of the lattice are found point by
//! point (`refine`). Reported is what the machine does when it is tracked along the rotated path (`along`).

mod along;
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

pub use along::PathCost;
pub(crate) use at_points::nodes_at_points;
pub use lattice::DeadEnd;
pub use nodes::Infeasible;
pub(crate) use nodes::Node;
pub(crate) use turnable::check;
pub use turnable::{BranchMachine, BranchMachines, GammaProblem};

use self::{
    knots::{Knot, find_knots},
    lattice::{Shape, TIE_MM, Walk},
    nodes::Solver,
    refine::Refinement,
    turnable::RotatablePath,
};
use crate::{
    compensation::TaskPoint,
    input::error::{Error, Result},
    machine::{Branch, Configuration, Machine},
    process::{CutPath, GammaChoice, RedundancyObjective, RedundancySettings},
    simulation::Machines,
    toolpath::PathPoint,
    work::{Event, Stage, Work},
};

/// Items for tests, which compare the lattice with all its paths; not part of the interface.
#[doc(hidden)]
pub mod internals {
    pub use super::{
        knots::Knot,
        lattice::{Shape, Walk},
        nodes::NodeState,
        turnable::MAX_DRIVES,
    };
}

/// Knots whose nodes are computed together.
const STRIPE: usize = 64;
/// Most nodes of a lattice, all knots together.
const MAX_NODES: usize = 1 << 28;

/// A path rotated by γ about the tool axis at each point, and how far the loaded tool is from it.
#[derive(Debug, Clone, Serialize)]
pub struct RotatedPath {
    /// The arm's branch; `None` on a machine without branches.
    pub branch: Option<Branch>,
    /// The nominal machine on this branch.
    #[serde(skip)]
    pub machine: Machine,
    /// γ at each point, degrees.
    #[serde(skip)]
    pub turns_deg: Vec<f64>,
    /// Least and largest γ, degrees.
    pub range_deg: [f64; 2],
    /// The path with its platform orientations rotated.
    #[serde(skip)]
    pub path: CutPath,
    /// How far the loaded tool is from the path.
    pub along: PathCost,
}

/// The best γ at each knot of the lattice, before refinement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LatticePath {
    /// Index of the path point of each knot.
    pub points: Vec<usize>,
    /// γ at each knot, degrees, continued from knot to knot without jumps of a full turn.
    pub turns_deg: Vec<f64>,
    /// The arm's branch; `None` on a machine without branches.
    pub branch: Option<Branch>,
    /// The objective over the counted points, mm: root mean square or largest cost.
    pub value_mm: f64,
}

/// Results of the search for γ along a path: as programmed, the best constant γ and the best γ at each point.
#[derive(Debug, Clone)]
pub struct FoundGamma {
    /// Cost of the path at the programmed orientations.
    pub as_programmed: PathCost,
    /// The path at the best γ that is the same everywhere.
    pub best_constant: std::result::Result<RotatedPath, DeadEnd>,
    /// The path at the best γ of each point; the best constant γ if only that was asked for.
    pub best: std::result::Result<RotatedPath, DeadEnd>,
    /// The solution on the lattice.
    pub on_lattice: std::result::Result<LatticePath, DeadEnd>,
    /// Branches left out because the machine has no home on them, and why.
    pub refused: Vec<(Branch, String)>,
    /// Whether each point counts: the tool cuts there, or nowhere on the path.
    pub counted: Vec<bool>,
    /// Whether no γ keeps P within the machine's workspace box all along, so that those outside were admitted.
    pub leaves_box: bool,
}

impl FoundGamma {
    /// The path at the γ of this choice; `None` if the tool stays as programmed.
    #[must_use]
    pub fn result_for(&self, redundancy: GammaChoice) -> Option<&std::result::Result<RotatedPath, DeadEnd>> {
        match redundancy {
            GammaChoice::AsProgrammed => None,
            GammaChoice::BestConstant => Some(&self.best_constant),
            GammaChoice::Best => Some(&self.best),
        }
    }
}

/// Finds the best γ along a path, on the current rayon pool; independent of the number of threads: within the machine's workspace box, or if
/// none keeps the path there, anywhere. `Err` if the machine cannot rotate its tool freely or the lattice is too large, or from `work`.
pub fn search_gamma(problem: GammaProblem<'_>, work: &Work) -> Result<FoundGamma> {
    let path = |keeps_box| {
        RotatablePath::new(problem).map(|mut path| {
            path.keeps_box = keeps_box;
            path
        })
    };
    let found = search_along(path(true)?, work)?;
    match found.result_for(problem.settings.gamma) {
        Some(Err(_)) => Ok(FoundGamma { leaves_box: true, ..search_along(path(false)?, work)? }),
        _ => Ok(found),
    }
}

/// Finds the best γ along `path` as [`search_gamma`] does, within the workspace box only if the path is to keep it.
fn search_along(path: RotatablePath<'_>, work: &Work) -> Result<FoundGamma> {
    let problem = path.problem;
    let lattice = Lattice::new(&path)?;
    let programmed: Vec<TaskPoint> = (0..path.points().len()).map(|point| path.task(point, 0.0)).collect();
    let as_programmed = along::path_cost(&path, &Machines::new(problem.machine, problem.errors)?, &programmed);
    let walk = lattice.walk(problem.settings.objective, f64::INFINITY, work)?;
    let best_constant = match walk.best_constant() {
        Some((gamma, on_branch)) => {
            let gamma = constant::refine(&path, &lattice.shape, on_branch, lattice.gammas[gamma], lattice.step, work)?;
            Ok(rotated_path(&path, on_branch, vec![gamma; path.points().len()]))
        }
        None => Err(walk.dead_end.clone().unwrap_or(DeadEnd { point: 0, infeasible: None })),
    };
    let (on_lattice, best) = if problem.settings.gamma == GammaChoice::Best {
        best_gamma(&path, &lattice, walk, &best_constant, work)?
    } else {
        (lattice.solution(&walk, problem.settings.objective).map(|(_, found)| found), best_constant.clone())
    };
    let counted = (0..path.points().len()).map(|k| path.is_counted(k)).collect();
    let leaves_box = false;
    Ok(FoundGamma { as_programmed, best_constant, best, on_lattice, refused: path.refused, counted, leaves_box })
}

/// A constant γ with which the machine reaches every point of a path, each on its own.
#[derive(Debug, Clone)]
pub struct ReachedGamma {
    /// The γ, rad.
    pub gamma: f64,
    /// Whether it does so on the branch of home, or has no branches.
    pub is_at_home: bool,
    /// Its cost at each point, mm.
    pub costs_mm: Vec<f64>,
}

/// Values of γ on the lattice with which the machine, on a branch as in `machines`, reaches every point of the path, each on its own; on the
/// branch of home where that reaches it; with γ = 0 if it is in range. The inner `Err` is the first point up to which none is left; `Err` if the
/// machine cannot rotate its tool freely, or from `work`.
pub fn reached_gammas(
    problem: GammaProblem<'_>,
    machines: &BranchMachines,
    work: &Work,
) -> Result<std::result::Result<Vec<ReachedGamma>, DeadEnd>> {
    let path = RotatablePath::on(problem, machines)?;
    let [low, high] = problem.settings.range_deg;
    let mut gammas = path.gammas();
    if (low..=high).contains(&0.0) && !gammas.contains(&0.0) {
        gammas.push(0.0);
    }
    let mut solver = Solver::new(&path);
    let home = path.home_branch();
    let (mut found, mut farthest): (Vec<ReachedGamma>, usize) = (Vec::new(), 0);
    // Paths stay on the branch of home where they can, and most γ need no other.
    for branch in home.into_iter().chain((0..path.on_branches.len()).filter(|own| Some(*own) != home)) {
        let is_at_home = Some(branch) == home;
        let untried = gammas.iter().filter(|gamma| !found.iter().any(|known| known.gamma == **gamma));
        let mut open: Vec<ReachedGamma> =
            untried.map(|&gamma| ReachedGamma { gamma, is_at_home, costs_mm: Vec::new() }).collect();
        for k in 0..path.points().len() {
            if open.is_empty() {
                break;
            }
            work.check()?;
            farthest = farthest.max(k);
            let tried: Vec<f64> = open.iter().map(|own| own.gamma).collect();
            let mut nodes = solver.nodes_on_branch(k, branch, &tried).into_iter();
            open.retain_mut(|own| match nodes.next() {
                Some(Ok(node)) => {
                    own.costs_mm.push(node.cost_mm);
                    true
                }
                _ => false,
            });
        }
        found.extend(open);
    }
    if found.is_empty() {
        return Ok(Err(DeadEnd::at(farthest, &solver.layer(farthest, &gammas))));
    }
    Ok(Ok(found))
}

/// Why the machine cannot stand at the point `here` or cannot move there from the point `before`: margins to travel limits and singularities,
/// a swing of a revolute joint, or speed limits; `None` if it can.
pub(crate) fn infeasible_step(
    settings: &RedundancySettings,
    machine: &Machine,
    before: Option<(&PathPoint, &Configuration)>,
    here: (&PathPoint, &Configuration),
) -> Option<&'static str> {
    if let Err(infeasible) = nodes::check_margins(settings, machine, here.1) {
        return Some(infeasible.text());
    }
    let (before, last) = before?;
    let (_, seconds) = knots::length_and_time(before, here.0);
    let drives = |at: &Configuration| {
        let mut drives = [0.0; turnable::MAX_DRIVES];
        drives.iter_mut().zip(&at.drives).for_each(|(drive, rho)| *drive = *rho);
        drives
    };
    let is_tracked = Shape::with_limits_of(machine, settings).allows(&drives(last), &drives(here.1), seconds);
    (!is_tracked)
        .then_some("reached from the point before only by a swing of a revolute joint, or faster than the drives move")
}

/// The path of `problem` with all its platform orientations rotated by `gamma` (rad) about the tool axis. `Err` if the machine cannot do so.
pub fn rotated_by(problem: GammaProblem<'_>, gamma: f64) -> Result<CutPath> {
    let path = RotatablePath::on(problem, &BranchMachines::default())?;
    Ok(path.rotated(&vec![gamma; path.points().len()]))
}

/// Pose and load at the first point of the path of `problem`, rotated by each of `gammas` (rad) about the tool axis. `Err` if the machine cannot do so.
pub(crate) fn first_tasks(problem: GammaProblem<'_>, gammas: &[f64]) -> Result<Vec<TaskPoint>> {
    let path = RotatablePath::on(problem, &BranchMachines::default())?;
    Ok(gammas.iter().map(|gamma| path.task(0, *gamma)).collect())
}

/// The best γ at each point: on the lattice, and refined, or the constant γ if that is as good. `Err` if `work` is stopped.
fn best_gamma(
    path: &RotatablePath<'_>,
    lattice: &Lattice<'_>,
    walk: Walk,
    constant: &std::result::Result<RotatedPath, DeadEnd>,
    work: &Work,
) -> Result<(std::result::Result<LatticePath, DeadEnd>, std::result::Result<RotatedPath, DeadEnd>)> {
    let objective = path.problem.settings.objective;
    let (walk, of_lattice) = match (objective, walk.cheapest()) {
        (RedundancyObjective::Worst, Some((largest, ..))) => {
            (lattice.walk(RedundancyObjective::Rms, largest, work)?, Some(largest))
        }
        _ => (walk, None),
    };
    let (on_branch, mut found) = match lattice.solution(&walk, RedundancyObjective::Rms) {
        Ok(found) => found,
        Err(dead_end) => return Ok((Err(dead_end.clone()), Err(dead_end))),
    };
    found.value_mm = of_lattice.unwrap_or(found.value_mm);
    let refined = Refinement {
        path,
        shape: &lattice.shape,
        branch: on_branch,
        rate: path.problem.settings.max_step_deg_per_mm.to_radians(),
        max_shift: lattice.step,
        work,
    };
    let gammas = refined.refine(lattice.interpolated(&found))?;
    let best = rotated_path(path, on_branch, gammas);
    let value = |rotated: &RotatedPath| match objective {
        RedundancyObjective::Rms => rotated.along.rms_mm,
        RedundancyObjective::Worst => rotated.along.worst_mm,
    };
    // Between the knots nothing kept γ from leading out of the box.
    let outside = |rotated: &RotatedPath| path.outside_count(|k| rotated.turns_deg[k].to_radians());
    let unsolved = |rotated: &RotatedPath| rotated.along.points - rotated.along.solved + outside(rotated);
    // A change of γ on the way must be worth more than a tie.
    let is_as_good = |constant: &&RotatedPath| match unsolved(constant).cmp(&unsolved(&best)) {
        Ordering::Equal => value(constant).zip(value(&best)).is_none_or(|(a, b)| a <= b + TIE_MM),
        other => other == Ordering::Less,
    };
    let best = constant.as_ref().ok().filter(is_as_good).cloned().unwrap_or(best);
    Ok((Ok(found), Ok(best)))
}

/// The path rotated by `gammas` (rad, one for each point), and its cost on the branch with index `on_branch`.
fn rotated_path(path: &RotatablePath<'_>, on_branch: usize, gammas: Vec<f64>) -> RotatedPath {
    let BranchMachine { branch, machine, machines } = &path.on_branches[on_branch];
    let tasks: Vec<TaskPoint> = gammas.iter().enumerate().map(|(k, gamma)| path.task(k, *gamma)).collect();
    let turns_deg: Vec<f64> = gammas.iter().map(|gamma| gamma.to_degrees()).collect();
    let end = |of: fn(f64, f64) -> f64| turns_deg.iter().copied().reduce(of).unwrap_or_default();
    RotatedPath {
        branch: *branch,
        machine: machine.clone(),
        range_deg: [end(f64::min), end(f64::max)],
        turns_deg,
        path: path.rotated(&gammas),
        along: along::path_cost(path, machines, &tasks),
    }
}

/// Values of γ, branches and knots at which a path is solved.
struct Lattice<'a> {
    path: &'a RotatablePath<'a>,
    /// Values of γ, rad.
    gammas: Vec<f64>,
    /// Between neighbouring values, rad.
    step: f64,
    shape: Shape,
    knots: Vec<Knot>,
}

impl<'a> Lattice<'a> {
    /// Lays the lattice over `path`. `Err` if it would have more than [`MAX_NODES`] nodes.
    fn new(path: &'a RotatablePath<'a>) -> Result<Self> {
        let (gammas, settings) = (path.gammas(), path.problem.settings);
        let [low, high] = settings.range_deg.map(f64::to_radians);
        // Of a single γ there is no step.
        let steps = gammas.len() - usize::from(!path.is_cyclic());
        let step = if steps == 0 { settings.step_deg.to_radians() } else { (high - low) / steps as f64 };
        let knots = find_knots(path.points(), settings.max_step_deg_per_mm.to_radians() / step, |k| path.is_counted(k));
        let of_drives = Shape::with_limits_of(path.problem.machine, settings);
        let least = (0..gammas.len()).min_by(|a, b| gammas[*a].abs().total_cmp(&gammas[*b].abs())).unwrap_or_default();
        let home = path.problem.machine.branch_of(&path.problem.machine.home);
        let on_branch = path.on_branches.iter().position(|on_branch| on_branch.branch == home).unwrap_or_default();
        let (branches, is_cyclic, programmed) = (path.on_branches.len(), path.is_cyclic(), Some((least, on_branch)));
        let shape = Shape { branches, gammas: gammas.len(), is_cyclic, programmed, ..of_drives };
        let nodes = knots.len().saturating_mul(shape.gammas * shape.branches);
        if nodes > MAX_NODES {
            let problem = format!(
                "the lattice of {} points, {} values of γ and {} branches has {nodes} nodes: expected at most {MAX_NODES}; a larger \
                 redundancy.step_deg or a part of the path has fewer",
                knots.len(),
                shape.gammas,
                shape.branches
            );
            return Err(Error::Argument { argument: "redundancy".into(), problem });
        }
        Ok(Self { path, gammas, step, shape, knots })
    }

    /// Solves all nodes and finds the cheapest path to each, without nodes above `ceiling_mm`. `Err` if `work` is stopped.
    fn walk(&self, objective: RedundancyObjective, ceiling_mm: f64, work: &Work) -> Result<Walk> {
        let mut walk = Walk::new(self.shape.clone(), objective, ceiling_mm);
        work.tell(Event::Stage(Stage { of: "points at all γ", items: self.knots.len() }));
        for knots in self.knots.chunks(STRIPE) {
            work.check()?;
            let find = |solver: &mut Solver<'_>, knot: &Knot| solver.layer(knot.point, &self.gammas);
            let nodes: Vec<Vec<Node>> = knots.par_iter().map_init(|| Solver::new(self.path), find).collect();
            for (knot, nodes) in knots.iter().zip(nodes) {
                walk.step(knot, nodes);
            }
            work.tell(Event::Computed(knots.len()));
        }
        if self.path.keeps_box && self.knots.len() < self.path.points().len() {
            for (costs, gamma) in walk.costs.chunks_mut(self.shape.branches).zip(&self.gammas) {
                if self.path.outside_count(|_| *gamma) > 0 {
                    costs.fill(None);
                }
            }
        }
        Ok(walk)
    }

    /// The cheapest path that `walk` found: the index of its branch, and γ at each knot; `Err` with the dead end if there is none.
    fn solution(
        &self,
        walk: &Walk,
        objective: RedundancyObjective,
    ) -> std::result::Result<(usize, LatticePath), DeadEnd> {
        let dead_end = || walk.dead_end.clone().unwrap_or(DeadEnd { point: 0, infeasible: None });
        let (value, indices, on_branch) = walk.cheapest().ok_or_else(dead_end)?;
        let counted: f64 = self.knots.iter().map(|knot| knot.weight).sum();
        let value_mm = match objective {
            RedundancyObjective::Rms => (value / counted.max(1.0)).sqrt(),
            RedundancyObjective::Worst => value,
        };
        let mut turns_deg: Vec<f64> = Vec::with_capacity(indices.len());
        for (k, index) in indices.iter().enumerate() {
            let steps = k.checked_sub(1).map_or(0, |before| self.steps_between(indices[before], *index));
            let before = turns_deg.last().copied().unwrap_or_else(|| self.gammas[*index].to_degrees());
            turns_deg.push(before + steps as f64 * self.step.to_degrees());
        }
        let points = self.knots.iter().map(|knot| knot.point).collect();
        Ok((on_branch, LatticePath { points, turns_deg, branch: self.path.on_branches[on_branch].branch, value_mm }))
    }

    /// Signed steps from the γ index `from` to `to`, the shorter way round if γ wraps.
    fn steps_between(&self, from: usize, to: usize) -> isize {
        let (apart, gammas) = (to as isize - from as isize, self.shape.gammas as isize);
        match self.shape.is_cyclic {
            true if 2 * apart > gammas => apart - gammas,
            true if 2 * apart < -gammas => apart + gammas,
            _ => apart,
        }
    }

    /// γ at each path point, rad, linear in arc length between the knots of `found`.
    fn interpolated(&self, found: &LatticePath) -> Vec<f64> {
        let points = self.path.points();
        let mut gammas = Vec::with_capacity(points.len());
        for (k, point) in points.iter().enumerate() {
            let after = found.points.partition_point(|knot| *knot < k);
            let before = after.saturating_sub(1);
            let arc_length = |knot: usize| points[found.points[knot]].arc_length_mm;
            let length = arc_length(after) - arc_length(before);
            let share = if length > 0.0 { (point.arc_length_mm - arc_length(before)) / length } else { 1.0 };
            let gamma = found.turns_deg[before] + share * (found.turns_deg[after] - found.turns_deg[before]);
            gammas.push(gamma.to_radians());
        }
        gammas
    }
}
