//! Nodes of the lattice: at a point, for each turn and each branch, where the drives are and how far the loaded tool is from its
//! path, or why it cannot be there.

use nalgebra::Vector3;
use serde::Serialize;

use super::turnable::{MOST_DRIVES, OnBranch, Turnable};
use crate::{
    compensation::TaskPoint,
    machine::{Configuration, Machine, Unreachable, Zeroed},
    process::RedundancySettings,
    spatial::Wrench,
    statics::{self, Batch, Case, State, Status},
};

/// Why a turn cannot be at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Infeasible {
    /// The machine does not reach there.
    Unreachable,
    /// A drive or joint would be beyond its travel.
    Limits,
    /// It is nearer to a singularity than is allowed.
    Singularity,
    /// The loaded machine does not settle.
    NotStable,
}

impl Infeasible {
    pub(super) const ALL: [Self; 4] = [Self::Unreachable, Self::Limits, Self::Singularity, Self::NotStable];

    /// Word in tables.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Unreachable => "unreachable",
            Self::Limits => "limits",
            Self::Singularity => "singularity",
            Self::NotStable => "not_stable",
        }
    }

    /// In words, of turns on branches.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Unreachable => "out of reach",
            Self::Limits => "beyond the travel of a drive or joint",
            Self::Singularity => "too near a singularity",
            Self::NotStable => "without a stable equilibrium",
        }
    }
}

/// Where the drives are, mm or rad, and what counts of the distance from the path, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing {
    /// Of each drive, mm or rad.
    pub drives: [f64; MOST_DRIVES],
    /// What counts, mm.
    pub cost_mm: f64,
}

/// A node.
pub type Node = std::result::Result<Standing, Infeasible>;

/// How closely equilibria of the lattice are solved.
const SETTINGS: statics::Settings = statics::Settings { tolerance: 1e-9, max_iterations: 12 };

/// What solves nodes, one for each thread.
#[derive(Debug)]
pub(super) struct Solver<'a> {
    path: &'a Turnable<'a>,
    /// For each branch: of the machine that answers, and of the one from whose rest deflections are measured.
    batches: Vec<(Batch, Option<Batch>)>,
}

impl<'a> Solver<'a> {
    pub fn new(path: &'a Turnable<'a>) -> Self {
        let source = crate::simulation::Source::All;
        let batches = path.on_branches.iter().map(|on_branch| {
            let rests = on_branch.machine.zeroed == Zeroed::AtRest && on_branch.machine.own_forces().is_some();
            (on_branch.machines.batch(source), rests.then(|| Batch::new(on_branch.machines.unloaded())))
        });
        Self { path, batches: batches.collect() }
    }

    /// The nodes of point `k` at `turns` (rad) for all branches, turn by turn.
    pub fn layer(&mut self, k: usize, turns: &[f64]) -> Vec<Node> {
        let tasks: Vec<TaskPoint> = turns.iter().map(|turn| self.path.task(k, *turn)).collect();
        let found = postures(self.path, turns, &tasks);
        let count = self.path.on_branches.len();
        let mut nodes = vec![Err(Infeasible::Unreachable); turns.len() * count];
        for (s, own) in found.into_iter().enumerate() {
            for (turn, node) in self.solved(k, s, &tasks, own).into_iter().enumerate() {
                nodes[turn * count + s] = node;
            }
        }
        nodes
    }

    /// The nodes of point `k` at `turns` on branch number `s` alone.
    pub fn nodes_on_branch(&mut self, k: usize, s: usize, turns: &[f64]) -> Vec<Node> {
        let tasks: Vec<TaskPoint> = turns.iter().map(|turn| self.path.task(k, *turn)).collect();
        let mut found = postures(self.path, turns, &tasks);
        self.solved(k, s, &tasks, found.swap_remove(s))
    }

    /// The loaded machine at what was `found` on branch number `s`.
    fn solved(
        &mut self,
        k: usize,
        s: usize,
        tasks: &[TaskPoint],
        found: Vec<Result<Configuration, Infeasible>>,
    ) -> Vec<Node> {
        let on_branch = &self.path.on_branches[s];
        let allowed = |at: Configuration| room(self.path.asked.turn, &on_branch.machine, &at).map(|()| at);
        let found: Vec<_> = found.into_iter().map(|at| at.and_then(allowed)).collect();
        let at: Vec<(&TaskPoint, &Configuration)> =
            tasks.iter().zip(&found).filter_map(|(task, at)| at.as_ref().ok().map(|at| (task, at))).collect();
        let (batch, unloaded) = &mut self.batches[s];
        let loaded = settled(on_branch, batch, at.iter().map(|(task, at)| (task.load, *at)));
        let rest = match unloaded {
            Some(unloaded) => settled(on_branch, unloaded, at.iter().map(|(_, at)| (Wrench::zero(), *at))),
            None => at.iter().map(|(_, at)| Some(State::rigid(&on_branch.machine, at))).collect(),
        };
        let errors = at.iter().zip(loaded).zip(rest).map(|(((task, _), loaded), rest)| {
            let offset = task.offset(&on_branch.machine);
            Some(loaded?.pose.transform(offset) - rest?.pose.transform(offset))
        });
        let mut errors: std::vec::IntoIter<Option<Vector3<f64>>> = errors.collect::<Vec<_>>().into_iter();
        let node = |at: Result<Configuration, Infeasible>| {
            let at = at?;
            let error = errors.next().flatten().ok_or(Infeasible::NotStable)?;
            let mut drives = [0.0; MOST_DRIVES];
            drives.iter_mut().zip(&at.drives).for_each(|(own, rho)| *own = *rho);
            Ok(Standing { drives, cost_mm: self.path.cost(k, &error) })
        };
        found.into_iter().map(node).collect()
    }
}

/// Whether a machine stands as far from the ends of travel and from singularities as turns must leave it.
pub(super) fn room(turn: &RedundancySettings, machine: &Machine, at: &Configuration) -> Result<(), Infeasible> {
    match turn.travel_margin > 0.0 && machine.limit_room(at) < turn.travel_margin {
        true => Err(Infeasible::Limits),
        false if machine.is_conditioned(at, turn.min_singularity_distance) => Ok(()),
        false => Err(Infeasible::Singularity),
    }
}

/// Stable equilibria under dead wrenches at P, from rigid configurations.
fn settled<'b>(
    on_branch: &OnBranch,
    batch: &mut Batch,
    cases: impl Iterator<Item = (Wrench, &'b Configuration)>,
) -> Vec<Option<State>> {
    let (loads, at): (Vec<Wrench>, Vec<&Configuration>) = cases.unzip();
    let mut states: Vec<State> = at.iter().map(|at| State::rigid(&on_branch.machine, at)).collect();
    let mut drives: Vec<Vec<f64>> = at.iter().map(|at| at.drives.clone()).collect();
    let mut cases: Vec<Case<'_>> = loads
        .iter()
        .zip(&mut states)
        .zip(&mut drives)
        .map(|((load, state), drives)| Case { drives, load: *load, state, task: None })
        .collect();
    let outcomes = batch.equilibria(&mut cases, &SETTINGS);
    let stable = states.into_iter().zip(outcomes);
    stable.map(|(state, outcome)| (outcome.status == Status::Solved).then_some(state)).collect()
}

/// Where the machine stands at each task, for each branch.
fn postures(path: &Turnable<'_>, turns: &[f64], tasks: &[TaskPoint]) -> Vec<Vec<Result<Configuration, Infeasible>>> {
    match path.on_branches.as_slice() {
        [only] if only.branch.is_none() => vec![track(only, turns, tasks)],
        on_branches => {
            let mut found: Vec<Vec<_>> = vec![vec![Err(Infeasible::Unreachable); tasks.len()]; on_branches.len()];
            for (turn, task) in tasks.iter().enumerate() {
                for (branch, mut drives) in path.asked.machine.postures_in_closed_form(&task.pose) {
                    let own = on_branches.iter().position(|on_branch| on_branch.branch == Some(branch));
                    if let Some(s) = own {
                        let at = on_branches[s].machine.posture_within_travel(&mut drives, &path.full_turns);
                        found[s][turn] = at.ok_or(Infeasible::Limits);
                    }
                }
            }
            found
        }
    }
}

/// A machine without branches: the least turn is gone to from home, and from there one after another as far as they lead. Beyond a turn
/// that cannot be reached there are none.
fn track(on_branch: &OnBranch, turns: &[f64], tasks: &[TaskPoint]) -> Vec<Result<Configuration, Infeasible>> {
    let least = (0..turns.len()).min_by(|a, b| turns[*a].abs().total_cmp(&turns[*b].abs())).unwrap_or_default();
    let mut found = vec![Err(Infeasible::Unreachable); tasks.len()];
    let (up, down): (Vec<usize>, Vec<usize>) = ((least..tasks.len()).collect(), (0..least).rev().collect());
    found_along(on_branch, tasks, None, &up, &mut found);
    let near = found.get(least).and_then(|at| at.as_ref().ok().cloned());
    found_along(on_branch, tasks, near, &down, &mut found);
    found
}

/// The tasks at `places`, each gone to from the one before, `near` at first; from home where there is none.
fn found_along(
    on_branch: &OnBranch,
    tasks: &[TaskPoint],
    mut near: Option<Configuration>,
    places: &[usize],
    found: &mut [Result<Configuration, Infeasible>],
) {
    let machine = &on_branch.machine;
    for (done, place) in places.iter().enumerate() {
        let pose = &tasks[*place].pose;
        let at = match &near {
            Some(near) => machine.inverse_kinematics_from(near, pose),
            None => machine.inverse_kinematics(pose),
        };
        match at {
            Ok(at) => {
                near = Some(at.clone());
                found[*place] = Ok(at);
            }
            Err(unreachable) => {
                let infeasible = match unreachable {
                    Unreachable::Travel { .. } | Unreachable::JointLimit { .. } => Infeasible::Limits,
                    _ => Infeasible::Unreachable,
                };
                // One after another only from where the machine stands.
                let beyond = if near.is_some() { &places[done..] } else { &places[done..=done] };
                beyond.iter().for_each(|place| found[*place] = Err(infeasible));
                if near.is_some() {
                    return;
                }
            }
        }
    }
}
