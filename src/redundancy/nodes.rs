//! Nodes of the lattice: at each point, γ and branch the drive positions and the distance of the loaded tool from its path, if any.

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use super::turnable::{BranchMachine, MAX_DRIVES, RotatablePath};
use crate::{
    compensation::TaskPoint,
    machine::{Configuration, Machine, Unreachable, ZeroState},
    process::RedundancySettings,
    simulation::play::{flank_offsets, sides_as_calibrated},
    spatial::Wrench,
    statics::{self, Batch, Case, State, Status, has_play, loaded_flanks},
};

/// Why a γ is infeasible at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Infeasible {
    /// The machine cannot reach the pose.
    Unreachable,
    /// A drive or joint would leave its travel.
    Limits,
    /// The machine would be nearer to a singularity than is allowed.
    Singularity,
    /// The loaded machine has no stable equilibrium that was found.
    NotStable,
    /// P would leave the machine's workspace box.
    Workspace,
}

impl Infeasible {
    pub(super) const ALL: [Self; 5] =
        [Self::Unreachable, Self::Limits, Self::Singularity, Self::NotStable, Self::Workspace];

    /// The value of this reason in tables.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Unreachable => "unreachable",
            Self::Limits => "limits",
            Self::Singularity => "singularity",
            Self::NotStable => "not_stable",
            Self::Workspace => "outside_workspace",
        }
    }

    /// The reason in words, as said of several γ.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Unreachable => "out of reach",
            Self::Limits => "beyond the travel of a drive or joint",
            Self::Singularity => "too near a singularity",
            Self::NotStable => "without a stable equilibrium",
            Self::Workspace => "outside the workspace box",
        }
    }
}

/// Drive positions and cost of a feasible node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeState {
    /// Positions of the drives, mm or rad; 0 beyond the last.
    pub drives: [f64; MAX_DRIVES],
    /// Distance of the loaded tool from the path as the cost setting measures it, mm.
    pub cost_mm: f64,
}

/// A node of the lattice: feasible, or the reason why not.
pub type Node = std::result::Result<NodeState, Infeasible>;

/// Tolerance and iterations of equilibria on the lattice.
const SETTINGS: statics::Settings = statics::Settings { tolerance: 1e-9, max_iterations: 12 };

/// Points that one thread takes at a time.
const CHUNK: usize = 64;

/// Applies `find` to each point index in `points` of `path`, in parallel, and returns the results in order.
pub(super) fn map_points<T: Send>(
    path: &RotatablePath<'_>,
    points: &[usize],
    find: impl Fn(&mut Solver<'_>, usize) -> T + Sync,
) -> Vec<T> {
    let chunks = points.par_chunks(CHUNK).map(|points| {
        let mut solver = Solver::new(path);
        points.iter().map(|k| find(&mut solver, *k)).collect::<Vec<T>>()
    });
    chunks.flatten_iter().collect()
}

/// Solver of nodes, one for each thread.
#[derive(Debug)]
pub(super) struct Solver<'a> {
    path: &'a RotatablePath<'a>,
    /// `None` where nothing was solved so far.
    branches: Vec<Option<SolvedBranch>>,
}

/// What a thread solves on a branch with.
#[derive(Debug)]
struct SolvedBranch {
    /// The actual machine.
    batch: Batch,
    /// The unloaded one where deflections count from its equilibrium.
    unloaded: Option<Batch>,
    /// Sides to which its drives were pressed where it was calibrated, if they have play and that was not where it stands.
    calibrated: Option<Vec<i8>>,
}

impl SolvedBranch {
    /// Makes the solvers of the machine on its branch.
    fn new(BranchMachine { machine, machines, .. }: &BranchMachine) -> Self {
        let source = crate::simulation::Source::All;
        let rests = machine.zeroed == ZeroState::AtRest && machine.own_load_text().is_some();
        let calibrated = || sides_as_calibrated(machine, machines.unloaded(), &machine.home);
        Self {
            batch: machines.batch(source),
            unloaded: rests.then(|| Batch::new(machines.unloaded())),
            calibrated: has_play(machines.actual(source)).then(calibrated),
        }
    }
}

impl<'a> Solver<'a> {
    /// Prepares a solver for the branches of `path`.
    pub fn new(path: &'a RotatablePath<'a>) -> Self {
        Self { path, branches: path.on_branches.iter().map(|_| None).collect() }
    }

    /// Solves path point `k` at each of `gammas` (rad) on all branches: nodes γ by γ, the branches of each.
    pub fn layer(&mut self, k: usize, gammas: &[f64]) -> Vec<Node> {
        let tasks: Vec<TaskPoint> = gammas.iter().map(|gamma| self.path.task(k, *gamma)).collect();
        let found = postures(self.path, gammas, &tasks);
        let count = self.path.on_branches.len();
        let mut nodes = vec![Err(Infeasible::Unreachable); gammas.len() * count];
        for (branch, configurations) in found.into_iter().enumerate() {
            for (gamma, node) in self.solve_on_branch(k, branch, &tasks, configurations).into_iter().enumerate() {
                nodes[gamma * count + branch] = node;
            }
        }
        nodes
    }

    /// Solves path point `k` on the branch with index `branch`: a node for each of `gammas` (rad).
    pub fn nodes_on_branch(&mut self, k: usize, branch: usize, gammas: &[f64]) -> Vec<Node> {
        let tasks: Vec<TaskPoint> = gammas.iter().map(|gamma| self.path.task(k, *gamma)).collect();
        let mut found = postures(self.path, gammas, &tasks);
        self.solve_on_branch(k, branch, &tasks, found.swap_remove(branch))
    }

    /// Loads the machine at configurations `found` for `tasks` on branch index `branch`: nodes with the tool's distance from point `k`.
    fn solve_on_branch(
        &mut self,
        k: usize,
        branch: usize,
        tasks: &[TaskPoint],
        found: Vec<Result<Configuration, Infeasible>>,
    ) -> Vec<Node> {
        let on_branch = &self.path.on_branches[branch];
        let check = |(at, task): (Result<Configuration, Infeasible>, &TaskPoint)| {
            let at = at?;
            if self.path.keeps_box && self.path.is_outside(task) {
                return Err(Infeasible::Workspace);
            }
            check_margins(self.path.problem.settings, &on_branch.machine, &at).map(|()| at)
        };
        let found: Vec<_> = found.into_iter().zip(tasks).map(check).collect();
        let at: Vec<(&TaskPoint, &Configuration)> =
            tasks.iter().zip(&found).filter_map(|(task, at)| at.as_ref().ok().map(|at| (task, at))).collect();
        let SolvedBranch { batch, unloaded, calibrated } =
            self.branches[branch].get_or_insert_with(|| SolvedBranch::new(on_branch));
        let commands: Vec<Vec<f64>> = at.iter().map(|(_, at)| at.drives.clone()).collect();
        let mut loaded =
            stable_equilibria(on_branch, batch, at.iter().map(|(task, at)| (task.load, *at)), commands.clone());
        let rest = match unloaded {
            Some(unloaded) => {
                stable_equilibria(on_branch, unloaded, at.iter().map(|(_, at)| (Wrench::zero(), *at)), commands.clone())
            }
            None => at.iter().map(|(_, at)| Some(State::rigid(&on_branch.machine, at))).collect(),
        };
        if let Some(calibrated) = calibrated {
            // On the sides of the equilibrium without play: the cost of the whole path, in the end, follows changes of sides.
            let machine = on_branch.machines.actual(crate::simulation::Source::All);
            let seated = |((state, rest), mut command): ((&Option<State>, &Option<State>), Vec<f64>)| {
                let state = state.as_ref()?;
                let at_rest = || rest.as_ref().map(|rest| loaded_flanks(on_branch.machines.unloaded(), rest));
                let calibrated = if unloaded.is_some() { at_rest()? } else { calibrated.clone() };
                let offsets = flank_offsets(machine, &loaded_flanks(machine, state), &calibrated)?;
                command.iter_mut().zip(offsets).for_each(|(drive, offset)| *drive += offset);
                Some(command)
            };
            let with_play: Vec<Option<Vec<f64>>> = loaded.iter().zip(&rest).zip(commands.clone()).map(seated).collect();
            let commands = with_play.into_iter().zip(commands).map(|(own, plain)| own.unwrap_or(plain)).collect();
            loaded = stable_equilibria(on_branch, batch, at.iter().map(|(task, at)| (task.load, *at)), commands);
        }
        let errors = at.iter().zip(loaded).zip(rest).map(|(((task, _), loaded), rest)| {
            let offset = task.offset(&on_branch.machine);
            Some(loaded?.pose.transform(offset) - rest?.pose.transform(offset))
        });
        let mut errors: std::vec::IntoIter<Option<Vector3<f64>>> = errors.collect::<Vec<_>>().into_iter();
        let node = |at: Result<Configuration, Infeasible>| {
            let at = at?;
            let error = errors.next().flatten().ok_or(Infeasible::NotStable)?;
            let mut drives = [0.0; MAX_DRIVES];
            drives.iter_mut().zip(&at.drives).for_each(|(drive, rho)| *drive = *rho);
            Ok(NodeState { drives, cost_mm: self.path.cost(k, &error) })
        };
        found.into_iter().map(node).collect()
    }
}

/// Checks the margins to travel limits and singularities that `settings` demand of a configuration.
pub(super) fn check_margins(
    settings: &RedundancySettings,
    machine: &Machine,
    at: &Configuration,
) -> Result<(), Infeasible> {
    match settings.travel_margin > 0.0 && machine.limit_margin(at) < settings.travel_margin {
        true => Err(Infeasible::Limits),
        false if machine.is_conditioned(at, settings.min_singularity_distance) => Ok(()),
        false => Err(Infeasible::Singularity),
    }
}

/// Stable equilibria under constant wrenches at P (N, N·mm), started from rigid configurations, with drives at `commands`, mm or rad; `None` where there is none.
fn stable_equilibria<'b>(
    on_branch: &BranchMachine,
    batch: &mut Batch,
    cases: impl Iterator<Item = (Wrench, &'b Configuration)>,
    mut drives: Vec<Vec<f64>>,
) -> Vec<Option<State>> {
    let (loads, at): (Vec<Wrench>, Vec<&Configuration>) = cases.unzip();
    let mut states: Vec<State> = at.iter().map(|at| State::rigid(&on_branch.machine, at)).collect();
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

/// Configurations of the machine: for each branch, one at each of `tasks`, whose γ (rad) are `gammas`.
fn postures(
    path: &RotatablePath<'_>,
    gammas: &[f64],
    tasks: &[TaskPoint],
) -> Vec<Vec<Result<Configuration, Infeasible>>> {
    match &path.on_branches[..] {
        [only] if only.branch.is_none() => vec![track(only, gammas, tasks)],
        on_branches => {
            let mut found: Vec<Vec<_>> = vec![vec![Err(Infeasible::Unreachable); tasks.len()]; on_branches.len()];
            for (gamma, task) in tasks.iter().enumerate() {
                for (branch, mut drives) in path.problem.machine.postures_in_closed_form(&task.pose) {
                    let index = on_branches.iter().position(|on_branch| on_branch.branch == Some(branch));
                    if let Some(index) = index {
                        let at = on_branches[index].machine.posture_within_travel(&mut drives, &path.full_turns);
                        found[index][gamma] = at.ok_or(Infeasible::Limits);
                    }
                }
            }
            found
        }
    }
}

/// Configurations of a machine without branches at `tasks`, continued from the γ nearest to 0 up and down as far as each γ can be reached.
fn track(on_branch: &BranchMachine, gammas: &[f64], tasks: &[TaskPoint]) -> Vec<Result<Configuration, Infeasible>> {
    let least = (0..gammas.len()).min_by(|a, b| gammas[*a].abs().total_cmp(&gammas[*b].abs())).unwrap_or_default();
    let mut found = vec![Err(Infeasible::Unreachable); tasks.len()];
    let (up, down): (Vec<usize>, Vec<usize>) = ((least..tasks.len()).collect(), (0..least).rev().collect());
    track_from(on_branch, tasks, None, &up, &mut found);
    let near = found.get(least).and_then(|at| at.as_ref().ok().cloned());
    track_from(on_branch, tasks, near, &down, &mut found);
    found
}

/// Writes into `found` the configurations at `tasks[order]`, each continued from the one before: from `near` at first, or from home.
fn track_from(
    on_branch: &BranchMachine,
    tasks: &[TaskPoint],
    mut near: Option<Configuration>,
    order: &[usize],
    found: &mut [Result<Configuration, Infeasible>],
) {
    let machine = &on_branch.machine;
    for (done, task) in order.iter().enumerate() {
        let pose = &tasks[*task].pose;
        let at = match &near {
            Some(near) => machine.inverse_kinematics_from(near, pose),
            None => machine.inverse_kinematics(pose),
        };
        match at {
            Ok(at) => {
                near = Some(at.clone());
                found[*task] = Ok(at);
            }
            Err(unreachable) => {
                let infeasible = match unreachable {
                    Unreachable::Travel { .. } | Unreachable::JointLimit { .. } => Infeasible::Limits,
                    _ => Infeasible::Unreachable,
                };
                // One after another only from where the machine stands.
                let beyond = if near.is_some() { &order[done..] } else { &order[done..=done] };
                beyond.iter().for_each(|task| found[*task] = Err(infeasible));
                if near.is_some() {
                    return;
                }
            }
        }
    }
}
