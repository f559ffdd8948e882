//! The closure equations of a machine with what is commanded, and the damped Newton iteration that solves them.

use nalgebra::{DMatrix, DVector};

use super::{
    Configuration, Unreachable,
    equations::{Equations, LaneCommand, RigidState, mm_per_unit, move_platform},
    normal_step::NormalStep,
    search::{MAX_ITERATIONS, MAX_STEP_ROTATION, Search, SearchStatus},
};
use crate::{
    lanes::{Frame, dot},
    machine::{Chain, Machine, Motion, Route},
    spatial::{Pose, larger},
};

/// A chain with a smaller gap is closed as far as a user is concerned, mm.
const CLOSED_MM: f64 = 1e-3;
/// Largest distance from P to a chain's base or to a joint axis in the configuration `start`, mm.
pub(in crate::machine) fn characteristic_length(chains: &[Chain], start: &Configuration) -> f64 {
    let (mut values, mut screws) = (Vec::new(), Vec::new());
    let mut first_drive = 0;
    let mut scale: f64 = 1.0;
    for (chain, passive) in chains.iter().zip(&start.passive) {
        chain.rigid_values(&start.drives[first_drive..], passive, &mut values);
        first_drive += chain.drives.len();
        let end = chain.forward(&values, &mut screws);
        scale = scale.max((end.translation - chain.route.base.translation).norm());
        for screw in &screws {
            scale = scale.max(screw.twist.linear.norm() * screw.twist.angular.norm());
        }
    }
    scale
}

/// Command that closure is solved for: a pose of P or the drives.
pub(in crate::machine) enum Command<'a> {
    /// The controlled task coordinates of this pose.
    Task(&'a Pose),
    /// The drives.
    Drives(&'a [f64]),
}

/// Configuration at which a search stopped.
pub(in crate::machine) struct SearchEnd {
    pub at: Configuration,
    /// Whether `at` solves the equations on the branch of the start.
    pub solved: bool,
}

/// The closure equations of a machine, linearised at a configuration.
pub(in crate::machine) struct Closure<'a> {
    pub machine: &'a Machine,
    equations: Equations<f64>,
    pub jacobian: DMatrix<f64>,
    pub residual: DVector<f64>,
    /// The Jacobian where the last search began.
    pub(super) start_jacobian: DMatrix<f64>,
    normal_step: NormalStep<f64>,
    /// Drives of a redundant machine that stay where they are: index and value, mm or rad; first those that the machine has locked.
    pub locked: Vec<(usize, f64)>,
}

impl<'a> Closure<'a> {
    /// Storage for the equations of `machine`, its locked drives locked.
    pub fn new(machine: &'a Machine) -> Self {
        Self {
            locked: machine.locked.clone(),
            machine,
            equations: Equations::new(machine),
            jacobian: DMatrix::zeros(0, 0),
            residual: DVector::zeros(0),
            start_jacobian: DMatrix::zeros(0, 0),
            normal_step: NormalStep::new(machine, 1),
        }
    }

    /// Computes residual and Jacobian at `at`, see [`Equations`].
    pub fn linearise(&mut self, at: &Configuration, command: &Command<'_>) {
        let platform = Frame::splat(&at.pose);
        let state = RigidState { platform: &platform, drives: &at.drives, passive: &at.passive };
        match command {
            Command::Task(target) => {
                self.equations.linearise(self.machine, &state, &LaneCommand::Task(&Frame::splat(target)));
            }
            Command::Drives(drives) => self.equations.linearise(self.machine, &state, &LaneCommand::Drives(drives)),
        }
        let Equations { rows, unknowns, jacobian, residual, .. } = &self.equations;
        if self.jacobian.shape() != (*rows, *unknowns) {
            self.jacobian = DMatrix::zeros(*rows, *unknowns);
            self.residual = DVector::zeros(*rows);
        }
        self.jacobian.copy_from_slice(jacobian);
        self.residual.copy_from_slice(residual);
    }

    /// Searches for `command` by damped Newton from `start`; unsolved where it leaves the branch of `start`, see [`Search::has_left_branch`].
    pub fn newton(&mut self, start: &Configuration, command: &Command<'_>) -> SearchEnd {
        self.iterate(start, command, true)
    }

    /// Configuration at which damped Newton from `start` stops, on whatever branch and solved or not.
    pub fn approach(&mut self, start: &Configuration, command: &Command<'_>) -> Configuration {
        self.iterate(start, command, false).at
    }

    /// Damped Newton from `start`; with `only_on_branch` it ends, unsolved, as soon as it has left the branch of `start`.
    fn iterate(&mut self, start: &Configuration, command: &Command<'_>, only_on_branch: bool) -> SearchEnd {
        let scale = self.machine.characteristic_length;
        let closures = 6 * self.machine.closure_count();
        let mut at = start.clone();
        let mut search = Search::new();
        for iteration in 0..MAX_ITERATIONS {
            self.linearise(&at, command);
            if iteration == 0 {
                self.start_jacobian.clone_from(&self.jacobian);
            }
            let error = self.residual.iter().fold(0.0, |most, entry| larger(most, entry.abs()));
            match search.judge(error, scale) {
                SearchStatus::Failed => return SearchEnd { at, solved: false },
                SearchStatus::Solved => {
                    let is_near = !search.has_left_branch() && self.rotation_change(start, &at) < MAX_STEP_ROTATION;
                    return SearchEnd { at, solved: is_near };
                }
                SearchStatus::Continue => {}
            }
            if only_on_branch && search.has_left_branch() {
                return SearchEnd { at, solved: false };
            }
            let damping = search.update_damping(error);
            let min_norm_step;
            let step = match command {
                Command::Task(_) if self.machine.redundancy > 0 => {
                    min_norm_step = self.min_norm_step(&at);
                    min_norm_step.as_ref().map(|step| step.as_slice())
                }
                _ => {
                    let Equations { jacobian, residual, .. } = &self.equations;
                    let step = self.normal_step.solve(self.machine, jacobian, residual, closures, damping);
                    (step.1 != 0).then_some(step.0)
                }
            };
            let Some(step) = step else { return SearchEnd { at, solved: false } };
            let length = dot(step, step).sqrt();
            if !length.is_finite() {
                return SearchEnd { at, solved: false };
            }
            search.record_step(length);
            advance(self.machine, &mut at, step);
        }
        SearchEnd { at, solved: false }
    }

    /// Moves `at` by a step of the unknowns, mm.
    pub fn advance(&self, at: &mut Configuration, step: &DVector<f64>) {
        advance(self.machine, at, step.as_slice());
    }

    /// Factor from the coordinate of a joint (mm, rad) to a length in mm.
    pub fn mm_per_unit(&self, motion: Motion) -> f64 {
        mm_per_unit(self.machine, motion)
    }

    /// Largest change of a revolute drive or joint between two configurations, rad.
    fn rotation_change(&self, from: &Configuration, to: &Configuration) -> f64 {
        let values =
            |c: &'_ Configuration| -> Vec<f64> { c.drives.iter().chain(c.passive.iter().flatten()).copied().collect() };
        let changes = values(from).into_iter().zip(values(to)).zip(motions(self.machine));
        changes.filter(|(_, motion)| *motion == Motion::Revolute).fold(0.0, |most, ((a, b), _)| most.max((a - b).abs()))
    }

    /// Reason why `command` is not met at `at`, where a search stopped: the chain with the largest gap, or another assembly mode.
    pub(super) fn failure_reason(&mut self, at: &Configuration, command: &Command<'_>) -> Unreachable {
        self.linearise(at, command);
        let gaps = self.machine.closure_names().into_iter().enumerate().map(|(c, name)| {
            let gap = self.residual.rows(6 * c, 6).norm();
            (name, gap)
        });
        match gaps.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((chain, gap_mm)) if gap_mm.is_nan() || gap_mm >= CLOSED_MM => Unreachable::Closure { chain, gap_mm },
            _ => Unreachable::OtherMode,
        }
    }
}

/// Moves `at` by a step of the unknowns, mm.
fn advance(machine: &Machine, at: &mut Configuration, step: &[f64]) {
    at.pose = move_platform(&Frame::splat(&at.pose), step, machine.characteristic_length).into();
    let joints = at.drives.iter_mut().chain(at.passive.iter_mut().flatten());
    for ((value, motion), step) in joints.zip(motions(machine)).zip(&step[6..]) {
        *value += step / mm_per_unit(machine, motion);
    }
}

/// Motion of each drive, then of each passive joint.
pub(super) fn motions(machine: &Machine) -> impl Iterator<Item = Motion> {
    let passive = machine.chains.iter().flat_map(|chain| chain.passive.iter().map(|joint| joint.motion));
    machine.drives().map(|(_, drive)| drive.motion).chain(passive)
}

impl Machine {
    /// Closure Jacobian at `at`: `6m` rows (mm, rad × characteristic length), columns twist of P, drives, passive joints.
    pub fn closure_jacobian(&self, at: &Configuration) -> DMatrix<f64> {
        let mut closure = Closure::new(self);
        closure.linearise(at, &Command::Drives(&at.drives));
        closure.jacobian.rows(0, 6 * self.closure_count()).into_owned()
    }

    /// Number of routes that must end at P or at a frame of another route: chains and their loops.
    pub(super) fn closure_count(&self) -> usize {
        self.chains.iter().map(|chain| 1 + chain.route.loop_count()).sum()
    }

    /// Names of the chains and their loops, in the order of their equations.
    fn closure_names(&self) -> Vec<String> {
        fn add_loop_names(route: &Route, chain: &str, names: &mut Vec<String>) {
            for inner in &route.loops {
                names.push(format!("{chain} ({})", inner.name));
                add_loop_names(&inner.route, chain, names);
            }
        }
        let mut names = Vec::new();
        for chain in &self.chains {
            names.push(chain.name.clone());
            add_loop_names(&chain.route, &chain.name, &mut names);
        }
        names
    }
}
