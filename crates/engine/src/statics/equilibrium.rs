//! Equilibrium of the whole machine under a prescribed wrench, eqs. (3) and (7), as one condensed Newton iteration;
//! load steps, and whether what they reach is stable, `snapped` or singular.

use nalgebra::{Matrix6, Matrix6xX, Vector3, Vector6};

use super::{
    chain_system::ChainSystem,
    full_system,
    iteration::{Iteration, Verdict},
    outcome::{Outcome, Settings, Status, TaskError},
    platform::{self, Square, SquareTask},
    rigid_directions::RigidDirections,
    state::{FreeAtHome, State, Workspace, chain_inputs},
    tool, weight,
};
use crate::{
    lanes::{Frame, Screw, Vec3, rotation_exp},
    machine::{Configuration, Machine},
    spatial::{Pose, Wrench, larger},
};

/// Equilibrium of `machine` with drives at `drives` (mm, rad) under the dead wrench `load` at P in O axes:
/// `t = f⁻¹(F | t₀)`, eq. (7).
///
/// `state` is where the search starts (for instance [`State::rigid`] or a neighbouring solution) and, if the outcome is
/// any equilibrium, where it ends; otherwise it is left as it was. The full load is tried at once; if that fails, or might
/// have left the branch of the start, load and chain errors are brought on in steps.
///
/// `drives` has one entry per drive of the machine; `state` and `workspace` belong to `machine`.
pub fn equilibrium(
    machine: &Machine,
    drives: &[f64],
    load: &Wrench,
    state: &mut State,
    workspace: &mut Workspace,
    settings: &Settings,
) -> Outcome {
    let was = tool::enter(machine, state);
    let mut newton = Newton::new(machine, drives, load, None, state, workspace, settings);
    let solved = newton.solve(state);
    let (mut outcome, lost) = match solved {
        Some(residual) => (newton.finish(state, residual, 1), None),
        None => match newton.load_stepping(state) {
            Ok(Reached { residual, steps, lost }) => (newton.finish(state, residual, steps), lost),
            Err((status, residual)) => (newton.failed(status, residual), None),
        },
    };
    if let (Some(load_fraction), Status::Solved) = (lost, &outcome.status) {
        outcome = newton.failed(Status::Snapped { load_fraction }, outcome.residual);
    }
    if newton.is_at_singular_place(&outcome.status) {
        outcome = newton.failed(Status::SingularPlace, outcome.residual);
    }
    match (outcome.is_equilibrium(), &workspace.start, was) {
        (true, _, Some(_)) => tool::leave(machine, load, state, &mut outcome),
        (false, Some(start), was) => {
            state.clone_from(start);
            if let Some((pose, body)) = was {
                (state.pose, state.body) = (pose, body);
            }
        }
        _ => {}
    }
    outcome
}

/// Equilibrium of `machine` in which the drives stand where the task error vanishes: the drives and the state are found
/// by one Newton iteration, at the cost of an equilibrium.
///
/// `task`, asked once per iteration, gives the task error at a pose of P, in as many coordinates as there are drives. `drives` and `state` are
/// where the search starts, and where it ends; the residual of the outcome includes the task error over the machine's
/// reach. `None` if the iteration fails; `drives` and `state` are then as they were.
pub fn equilibrium_at_task(
    machine: &Machine,
    task: &dyn Fn(&Pose) -> TaskError,
    drives: &mut [f64],
    load: &Wrench,
    state: &mut State,
    workspace: &mut Workspace,
    settings: &Settings,
) -> Option<Outcome> {
    let was = tool::enter(machine, state);
    let task_of_body = |body: &Pose| task(&tool::bend(machine, body, load));
    let task: &dyn Fn(&Pose) -> TaskError = if was.is_some() { &task_of_body } else { task };
    let mut newton = Newton::new(machine, drives, load, Some(task), state, workspace, settings);
    match newton.solve(state) {
        Some(residual) => {
            drives.copy_from_slice(&newton.workspace.drives);
            let mut outcome = newton.finish(state, residual, 1);
            if was.is_some() {
                tool::leave(machine, load, state, &mut outcome);
            }
            Some(outcome)
        }
        None => {
            if let Some(start) = &workspace.start {
                state.clone_from(start);
            }
            if let Some((pose, body)) = was {
                (state.pose, state.body) = (pose, body);
            }
            None
        }
    }
}

/// Whether the unloaded platform, or a chain, could move without resistance at `at`, and not so at home.
pub(crate) fn is_singular_place(machine: &Machine, at: &Configuration, workspace: &mut Workspace) -> bool {
    let (mut state, load, settings) = (State::rigid(machine, at), Wrench::zero(), Settings::default());
    let mut newton = Newton::new(machine, &at.drives, &load, None, &mut state, workspace, &settings);
    newton.is_freer_than_at_home(&state)
}

const MIN_LOAD_STEP: f64 = 1.0 / 4096.0;

/// Where a direction of the platform has lost more of its stiffness than this leaves, the load steps end because the machine
/// snaps through.
const SOFTENED: f64 = 0.3;
/// Where the softest direction is softer than this fraction of the stiffest, no load can be brought on.
const NEARLY_FREE: f64 = 1e-9;

struct Newton<'a> {
    machine: &'a Machine,
    load: &'a Wrench,
    /// What the drives are to achieve; without it they stay where the workspace has them.
    task: Option<&'a dyn Fn(&Pose) -> TaskError>,
    workspace: &'a mut Workspace,
    settings: &'a Settings,
    /// Weight of a kilogram, N.
    gravity: Vector3<f64>,
    /// Share of the starting residual that the present load step leaves in place; 0 for the full load.
    held: f64,
    iterations: usize,
    /// Whether the start is condensed and it and the equilibrium found, if that is condensed, are far from singular.
    is_plainly_stable: bool,
    /// Whether something moves without resistance in the equilibrium found, if only within a chain.
    has_idle_motion: bool,
}

/// How load steps reached the full load.
struct Reached {
    residual: f64,
    steps: usize,
    /// The fraction at which the machine was first found not to be stable on the way.
    lost: Option<f64>,
}

/// Platform balance of the present linearisation.
struct Balance {
    /// Applied wrench less the sum of the chain wrenches, less what the load step holds back.
    imbalance: Vector6<f64>,
    task: Option<TaskError>,
    /// Largest of the closure gaps, forces out of balance and task errors, dimensionless.
    residual: f64,
}

impl<'a> Newton<'a> {
    /// Remembers where the solve starts, and takes up the drives.
    fn new(
        machine: &'a Machine,
        drives: &[f64],
        load: &'a Wrench,
        task: Option<&'a dyn Fn(&Pose) -> TaskError>,
        state: &mut State,
        workspace: &'a mut Workspace,
        settings: &'a Settings,
    ) -> Self {
        debug_assert_eq!(drives.len(), machine.drive_count());
        match &mut workspace.start {
            Some(start) => start.clone_from(state),
            start => *start = Some(state.clone()),
        }
        workspace.drives.clear();
        workspace.drives.extend_from_slice(drives);
        workspace.drive_step.clear();
        workspace.drive_step.resize(drives.len(), 0.0);
        Self {
            machine,
            load,
            task,
            workspace,
            settings,
            gravity: machine.gravity,
            held: 0.0,
            iterations: 0,
            is_plainly_stable: true,
            has_idle_motion: false,
        }
    }

    /// Iterates to convergence from `state`; the residual reached, or `None` if the iteration fails.
    fn solve(&mut self, state: &mut State) -> Option<f64> {
        let mut iteration = Iteration::new();
        for _ in 0..=self.settings.max_iterations {
            let balance = self.linearise(state);
            match iteration.judge(balance.residual, self.settings) {
                Verdict::Solved => return Some(balance.residual),
                Verdict::Failed => return None,
                Verdict::Continue => {}
            }
            let twist = self.step(state, &balance)?;
            let turns = self.workspace.chains.iter().map(ChainSystem::largest_rotation);
            let turn = turns.fold(twist.fixed_rows::<3>(3).amax(), larger);
            if !iteration.accepts(turn) {
                return None;
            }
            self.apply(&twist, state);
            self.iterations += 1;
        }
        None
    }

    /// Brings on the load and the chain errors in adaptive steps from the starting state, by holding back a shrinking
    /// share of the starting residual. Err: how it ends, and the last residual.
    fn load_stepping(&mut self, state: &mut State) -> Result<Reached, (Status, f64)> {
        if let Some(start) = &self.workspace.start {
            state.clone_from(start);
        }
        self.held = 0.0;
        let held_imbalance = self.linearise(state).imbalance;
        for (held, chain) in self.workspace.held.iter_mut().zip(&self.workspace.chains) {
            held.remember(chain, &state.pose);
        }
        self.workspace.held_imbalance = held_imbalance;
        let unloaded = self.softest(state);
        if unloaded.is_nearly_free() {
            return Err((Status::SingularPlace, f64::INFINITY));
        }
        let mut lost = None;
        let (mut fraction, mut step, mut steps) = (0.0, 0.5f64, 0);
        let mut last = state.clone();
        let mut residual = f64::INFINITY;
        while fraction < 1.0 {
            let next = f64::min(1.0, fraction + step);
            self.held = 1.0 - next;
            match self.solve(state) {
                Some(reached) => {
                    (fraction, residual) = (next, reached);
                    steps += 1;
                    step *= 2.0;
                    last.clone_from(state);
                    if lost.is_none() && !self.softest(state).is_stable {
                        lost = Some(fraction);
                    }
                }
                None if step > MIN_LOAD_STEP => {
                    state.clone_from(&last);
                    step *= 0.5;
                }
                None => return Err((self.why_stuck(&last, fraction, &unloaded), residual)),
            }
        }
        // The last step is judged as any equilibrium is.
        Ok(Reached { residual, steps, lost: lost.filter(|&fraction| fraction < 1.0) })
    }

    /// Why no load step leads on from the equilibrium `last`.
    fn why_stuck(&mut self, last: &State, fraction: f64, unloaded: &Softest) -> Status {
        self.held = 1.0 - fraction;
        let softest = self.softest(last);
        // A joint that is idle wherever the machine stands is not what ends the way.
        if unloaded.has_idle_motion && (fraction == 0.0 || !softest.has_idle_motion) {
            return Status::SingularPlace;
        }
        match fraction > 0.0 && (!softest.is_stable || softest.has_softened(unloaded)) {
            true => Status::Snapped { load_fraction: fraction },
            false => Status::NotConverged { load_fraction: fraction },
        }
    }

    /// Whether the machine is singular where the solve started, and at home not so. Loads and errors that stiffen it do not
    /// lead away from there.
    fn is_at_singular_place(&mut self, status: &Status) -> bool {
        if matches!(status, Status::Singular | Status::SingularPlace) {
            return false;
        }
        self.held = 0.0;
        if self.has_idle_motion && !self.free_at_home().idle {
            return true;
        }
        if self.is_plainly_stable && *status == Status::Solved {
            return false;
        }
        let start = self.workspace.start.clone();
        start.is_some_and(|start| self.is_freer_than_at_home(&start))
    }

    /// Whether something moves without resistance in a state of the machine without weight, and at home not so. A machine that
    /// weight alone holds is free at home too.
    fn is_freer_than_at_home(&mut self, state: &State) -> bool {
        let softest = self.softest_without_weight(state);
        if softest.is_nearly_free() {
            return !(self.machine.has_weight() && self.free_at_home().platform);
        }
        softest.has_idle_motion && !self.free_at_home().idle
    }

    fn softest_without_weight(&mut self, state: &State) -> Softest {
        let gravity = std::mem::replace(&mut self.gravity, Vector3::zeros());
        let softest = self.softest(state);
        self.gravity = gravity;
        softest
    }

    fn free_at_home(&mut self) -> FreeAtHome {
        if let Some(free) = self.workspace.free_at_home {
            return free;
        }
        let home = State::rigid(self.machine, &self.machine.home);
        self.workspace.drives.clone_from(&self.machine.home.drives);
        let softest = self.softest_without_weight(&home);
        let free = FreeAtHome { idle: softest.has_idle_motion, platform: softest.is_nearly_free() };
        self.workspace.free_at_home = Some(free);
        free
    }

    /// The platform's softest direction at an equilibrium, part of the load held back.
    fn softest(&mut self, state: &State) -> Softest {
        self.linearise(state);
        let reach = self.machine.reach;
        match self.condense(state) {
            Some(tangent) => {
                let rigid = &mut self.workspace.rigid;
                let matrix = platform::matrix(&tangent);
                let is_stable = platform_status(&matrix, reach) == Status::Solved;
                if rigid.is_empty() {
                    return Softest::of_stiffness(&matrix, reach, is_stable);
                }
                let compliance = single(platform::compliance(rigid, tangent)).map(|rows| platform::matrix(&rows));
                Softest::of_compliance(compliance.as_ref(), reach, is_stable, rigid)
            }
            None => {
                self.linearise(state);
                let weight = self.platform_stiffness(state);
                let Workspace { chains, rigid, .. } = &mut *self.workspace;
                let full = full_system::tangent(&self.machine.chains, chains, &weight);
                let (compliance, is_stable) = (full.compliance.as_ref(), full.status == Status::Solved);
                let softest = Softest::of_compliance(compliance, reach, is_stable, rigid);
                Softest { has_idle_motion: full.has_idle_motion, ..softest }
            }
        }
    }

    fn failed(&self, status: Status, residual: f64) -> Outcome {
        Outcome {
            status,
            iterations: self.iterations,
            residual,
            load_steps: 0,
            stiffness: None,
            compliance: None,
            drive_sensitivity: Matrix6xX::zeros(self.machine.drive_count()),
        }
    }

    /// Fills all chain systems at `state`.
    fn linearise(&mut self, state: &State) -> Balance {
        let reach = self.machine.reach;
        let norm = |wrench: &Wrench| Screw::from(*wrench).wrench_norm(reach);
        let weight: Wrench =
            weight::wrench(self.machine, &Frame::splat(&state.pose), Vec3::splat(&self.gravity)).into();
        let load = tool::load_on_body(self.machine, &state.pose, self.load);
        let mut imbalance = load.to_vector() + weight.to_vector();
        let mut largest_wrench = norm(self.load).max(1.0);
        let (mut gap, mut force): (f64, f64) = (0.0, 0.0);
        let Workspace { chains, held, drives, .. } = &mut *self.workspace;
        let inputs = chain_inputs(self.machine, state, drives);
        for (((system, held), chain), (chain_state, drives)) in
            chains.iter_mut().zip(held).zip(&self.machine.chains).zip(inputs)
        {
            if self.held > 0.0 {
                held.shift_loops(system, self.held);
                system.linearise(chain, drives, chain_state, &held.target(&state.pose, self.held), &self.gravity);
                held.release(system, self.held);
                held.shift_loops(system, 0.0);
            } else {
                system.linearise(chain, drives, chain_state, &state.pose, &self.gravity);
            }
            let residual = system.residual(reach);
            gap = larger(gap, residual.gap);
            force = larger(force, residual.force);
            largest_wrench = largest_wrench.max(norm(&chain_state.wrench));
            imbalance -= chain_state.wrench.to_vector();
        }
        if self.held > 0.0 {
            imbalance -= self.workspace.held_imbalance * self.held;
        }
        force = larger(force, norm(&Wrench::from_vector(&imbalance)));
        let task = self.task.map(|task| task(&state.pose));
        let task_error = task.as_ref().map_or(0.0, |task| task.size() / reach);
        Balance { imbalance, task, residual: larger(task_error, larger(gap / reach, force / largest_wrench)) }
    }

    /// One Newton step from the present linearisation; the twist of P. Chain steps are left in the chain systems.
    fn step(&mut self, state: &State, balance: &Balance) -> Option<Vector6<f64>> {
        match self.condense(state) {
            Some(tangent) => {
                if self.iterations == 0 {
                    self.is_plainly_stable = platform::plainly_definite(&tangent, self.machine.reach) == 1;
                }
                let right = platform::right_hand_side(&self.workspace.chains, &balance.imbalance.into());
                let twist = match &balance.task {
                    None => {
                        let Workspace { chains, rigid, .. } = &mut *self.workspace;
                        single(platform::step(chains, rigid, tangent, right))
                    }
                    Some(task) => self.step_to_task(tangent, right, task),
                }?;
                let Workspace { chains, rigid, drive_step, .. } = &mut *self.workspace;
                let (mut drive_step, mut slacks) = (drive_step.as_slice(), rigid.slacks());
                for (system, chain) in chains.iter_mut().zip(&self.machine.chains) {
                    let (own, others) = drive_step.split_at(chain.drives.len());
                    let (own_slacks, other_slacks) = slacks.split_at(system.slack_count());
                    system.substitute(1.0, &twist, own, Some(own_slacks));
                    (drive_step, slacks) = (others, other_slacks);
                }
                Some(twist.into())
            }
            None if balance.task.is_some() => None,
            None => {
                self.is_plainly_stable &= self.iterations > 0;
                self.linearise(state);
                let weight = self.platform_stiffness(state);
                full_system::step(&mut self.workspace.chains, &weight, &balance.imbalance)
            }
        }
    }

    /// The step in which the drives move as well; `None` where they are not as many as the coordinates put right.
    fn step_to_task(&mut self, tangent: Square<f64>, right: [f64; 6], task: &TaskError) -> Option<[f64; 6]> {
        let Workspace { chains, rigid, drive_step, drive_wrenches: wrenches, .. } = &mut *self.workspace;
        let task = SquareTask::new(task, drive_step.len())?;
        platform::drive_wrenches(chains, wrenches);
        single(platform::step_to_task(chains, rigid, tangent, right, wrenches, &task, drive_step))
    }

    /// The platform's own stiffness, by its weight and the load that a bent tool carries aside.
    fn platform_stiffness(&self, state: &State) -> Matrix6<f64> {
        let mut own = platform::rows(&weight::stiffness(self.machine, &state.pose.rotation, &self.gravity));
        tool::add_stiffness(self.machine, &state.pose, self.load, &mut own);
        platform::matrix(&own)
    }

    /// Condenses the chains; the platform's tangent, or `None` if a chain cannot be condensed.
    fn condense(&mut self, state: &State) -> Option<Square<f64>> {
        let tangent = self.workspace.condense(self.machine, &state.pose, &self.gravity, Some(self.load))?;
        let Workspace { chains, rigid, .. } = &mut *self.workspace;
        (rigid.factorise(chains, &tangent, self.machine.reach) == 1).then_some(tangent)
    }

    fn apply(&mut self, twist: &Vector6<f64>, state: &mut State) {
        for (drive, step) in self.workspace.drives.iter_mut().zip(&self.workspace.drive_step) {
            *drive += step;
        }
        let mut drive_step = self.workspace.drive_step.as_slice();
        let systems = self.workspace.chains.iter().zip(&self.machine.chains);
        for ((system, chain), chain_state) in systems.zip(&mut state.chains) {
            system.apply(twist, chain_state);
            // The chain's step is that of the joint, ρ + θ_a; ρ has taken its part of it.
            let (own, others) = drive_step.split_at(chain.drives.len());
            for (joint, drive) in chain.drives.iter().enumerate() {
                for (moved, step) in own.iter().enumerate() {
                    chain_state.coordinates[drive.coordinate] -= chain.joint_per_drive(joint, moved) * step;
                }
            }
            drive_step = others;
        }
        let step = Screw::from_array((*twist).into());
        let frame = Frame::splat(&state.pose);
        state.pose =
            Frame { axes: frame.turned(&rotation_exp(step.angular)), origin: frame.origin + step.linear }.into();
    }

    /// Tangent and stability at the equilibrium just linearised.
    fn finish(&mut self, state: &State, residual: f64, load_steps: usize) -> Outcome {
        let mut outcome = Outcome { load_steps, ..self.failed(Status::Solved, residual) };
        let reach = self.machine.reach;
        match self.condense(state) {
            Some(tangent) => {
                // Most by far need no eigenvalues.
                let is_definite = platform::plainly_definite(&tangent, reach) == 1;
                self.is_plainly_stable &= is_definite;
                let stiffness = platform::matrix(&tangent);
                outcome.status = if is_definite { Status::Solved } else { platform_status(&stiffness, reach) };
                outcome.stiffness = Some(stiffness);
                let Workspace { chains, rigid, drive_wrenches: twists, .. } = &mut *self.workspace;
                if outcome.status != Status::Singular
                    && let Some(compliance) = single(platform::compliance(rigid, tangent))
                {
                    outcome.compliance = Some(platform::matrix(&compliance));
                    if !rigid.is_empty() {
                        outcome.stiffness = platform::stiffness(&compliance, reach, rigid.slack_compliance())
                            .as_ref()
                            .map(platform::matrix);
                    }
                    platform::drive_twists(chains, rigid, &tangent, &compliance, twists);
                    for (twist, mut column) in twists.iter().zip(outcome.drive_sensitivity.column_iter_mut()) {
                        column.copy_from_slice(twist);
                    }
                }
            }
            None => {
                self.linearise(state);
                let weight = self.platform_stiffness(state);
                let full = full_system::tangent(&self.machine.chains, &self.workspace.chains, &weight);
                outcome.status = full.status;
                self.has_idle_motion = full.has_idle_motion;
                let rigid = &self.workspace.rigid;
                if full.compliance.is_some_and(|compliance| is_free(&compliance, reach, rigid)) {
                    outcome.status = Status::Singular;
                    return outcome;
                }
                outcome.stiffness = full
                    .compliance
                    .as_ref()
                    .and_then(|compliance| full_system::invert_if_regular(compliance, self.machine.reach));
                outcome.compliance = full.compliance;
                outcome.drive_sensitivity = full.drive_sensitivity;
            }
        }
        outcome
    }
}

/// What is computed in one lane, if it could be.
fn single<T>((value, good): (T, u8)) -> Option<T> {
    (good == 1).then_some(value)
}

/// A smallest eigenvalue below this fraction of the largest is zero: at a singular place, inverse kinematics leaves as much.
const FREE: f64 = 1e-11;

/// A compliance below this fraction of the largest is that of a rigid direction.
const RIGID: f64 = 1e-12;

/// The softest direction of the platform, rotations taken at the machine's reach.
#[derive(Debug, Clone, Copy)]
struct Softest {
    /// Its stiffness, and that of the stiffest direction that is not rigid, N/mm; NaN where there is none.
    value: f64,
    largest: f64,
    /// All of it, symmetric, N/mm; `None` where the platform is free or rigid in some direction.
    stiffness: Option<Matrix6<f64>>,
    is_stable: bool,
    /// Whether a chain can move without resistance while the platform stands.
    has_idle_motion: bool,
}

impl Softest {
    fn of_stiffness(stiffness: &Matrix6<f64>, reach: f64, is_stable: bool) -> Self {
        let stiffness = at_reach(stiffness, reach);
        let values = stiffness.map(|stiffness| stiffness.symmetric_eigenvalues());
        let (value, largest) = values.map_or((f64::NAN, f64::NAN), |values| (values.min(), values.amax()));
        Self { value, largest, stiffness, is_stable, has_idle_motion: false }
    }

    /// Of a platform with `compliance`; a free one has none. A slack yields as drives do.
    fn of_compliance(compliance: Option<&Matrix6<f64>>, reach: f64, is_stable: bool, rigid: &RigidDirections) -> Self {
        let (mut value, mut largest, mut stiffness) = (0.0, 1.0, None);
        if let Some(compliance) = compliance.and_then(|compliance| at_reach(compliance, 1.0 / reach)) {
            let values = compliance.symmetric_eigenvalues();
            let (least, most) = (values.min(), values.max());
            let is_rigid = least <= rigid.nearly_rigid().max(RIGID * most);
            value = if most > 0.0 { 1.0 / most } else { f64::MAX };
            largest = 1.0 / if is_rigid { rigid.slack_compliance() } else { least };
            stiffness = if is_rigid { None } else { compliance.try_inverse() };
        }
        Self { value, largest, stiffness, is_stable, has_idle_motion: false }
    }

    /// Whether it resists next to nothing.
    fn is_nearly_free(&self) -> bool {
        self.value.abs() <= NEARLY_FREE * self.largest
    }

    /// Whether a direction has lost nearly all the stiffness it had: of all directions, the one that has lost most.
    fn has_softened(&self, before: &Self) -> bool {
        let factor = before.stiffness.and_then(|stiffness| stiffness.cholesky());
        let (Some(factor), Some(stiffness)) = (factor, self.stiffness) else {
            return self.value < SOFTENED * before.value;
        };
        let left = factor.l().solve_lower_triangular(&stiffness);
        let shares = left.and_then(|left| factor.l().solve_lower_triangular(&left.transpose()));
        shares.is_some_and(|shares| shares.symmetric_eigenvalues().min() < SOFTENED)
    }
}

/// The symmetric part of a stiffness in N/mm, rotations taken at `reach` mm (of a compliance: 1/`reach`); `None` where an
/// entry is not finite, with which eigenvalue iterations do not end.
fn at_reach(stiffness: &Matrix6<f64>, reach: f64) -> Option<Matrix6<f64>> {
    let mut scaled = (stiffness + stiffness.transpose()) * 0.5;
    for i in 3..6 {
        scaled.row_mut(i).unscale_mut(reach);
        scaled.column_mut(i).unscale_mut(reach);
    }
    scaled.iter().all(|entry| entry.is_finite()).then_some(scaled)
}

/// Whether a compliance is that of a platform which only rounding holds in some direction; a slack yields as drives do.
fn is_free(compliance: &Matrix6<f64>, reach: f64, rigid: &RigidDirections) -> bool {
    at_reach(compliance, 1.0 / reach).is_some_and(|compliance| {
        let values = compliance.symmetric_eigenvalues().abs();
        let is_rigid = values.min() <= rigid.nearly_rigid().max(RIGID * values.max());
        let stiffest = if is_rigid { rigid.slack_compliance() } else { values.min() };
        stiffest <= FREE * values.max()
    })
}

/// Stability of the platform from its tangent stiffness; `reach` in mm makes rotations comparable.
fn platform_status(tangent: &Matrix6<f64>, reach: f64) -> Status {
    let Some(values) = at_reach(tangent, reach).map(|scaled| scaled.symmetric_eigenvalues()) else {
        return Status::Singular;
    };
    match values.min() {
        smallest if smallest.abs() <= FREE * values.amax() => Status::Singular,
        smallest if smallest < 0.0 => Status::Unstable,
        _ => Status::Solved,
    }
}
