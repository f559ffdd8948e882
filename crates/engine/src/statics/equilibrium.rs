//! Equilibrium of the whole machine under a prescribed wrench, eqs. (3) and (7), as one condensed Newton iteration;
//! load steps, and whether what they reach is stable, `snap_through` or singular.

use nalgebra::{Matrix6, Matrix6xX, Vector3};

use super::{
    full_system::{self, FullTangent},
    iteration::{Iteration, Verdict},
    lane_solver::LaneSolver,
    outcome::{Outcome, Settings, Status, TaskError},
    platform::{self, SquareTask},
    rigid_directions::RigidDirections,
    state::{FreeAtHome, State, Workspace},
    tool, weight,
};
use crate::{
    lanes::Vec3,
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
    let mut newton = Newton::new(machine, drives, load, None, state, workspace, settings);
    let (mut outcome, lost) = match newton.solve() {
        Some(residual) => (newton.finish(residual, 1), None),
        None => match newton.load_stepping(state) {
            Ok(Reached { residual, steps, lost }) => (newton.finish(residual, steps), lost),
            Err((status, residual)) => (newton.failed(status, residual), None),
        },
    };
    if let (Some(load_fraction), Status::Solved) = (lost, &outcome.status) {
        outcome = newton.failed(Status::SnapThrough { load_fraction }, outcome.residual);
    }
    if newton.is_at_singular_place(&outcome.status, state) {
        outcome = newton.failed(Status::SingularPlace, outcome.residual);
    }
    if outcome.is_equilibrium() {
        workspace.solver.store(0, state);
        tool::leave(machine, load, state, &mut outcome);
    }
    outcome
}

/// Equilibrium of `machine` in which the drives stand where the task error vanishes: the drives and the state are found
/// by one Newton iteration, at the cost of an equilibrium.
///
/// `task`, asked once per iteration, gives the task error at a pose of P, in as many coordinates as there are drives. `drives` and `state` are
/// where the search starts, and where it ends; the residual of the outcome includes the task error over the machine's
/// characteristic length. `None` if the iteration fails; `drives` and `state` are then as they were.
pub fn equilibrium_at_task(
    machine: &Machine,
    task: &dyn Fn(&Pose) -> TaskError,
    drives: &mut [f64],
    load: &Wrench,
    state: &mut State,
    workspace: &mut Workspace,
    settings: &Settings,
) -> Option<Outcome> {
    let mut newton = Newton::new(machine, drives, load, Some(task), state, workspace, settings);
    let residual = newton.solve()?;
    let mut outcome = newton.finish(residual, 1);
    drives.copy_from_slice(&workspace.solver.drives);
    workspace.solver.store(0, state);
    tool::leave(machine, load, state, &mut outcome);
    Some(outcome)
}

/// Whether the unloaded platform, or a chain, could move without resistance at `at`, and not so at home.
pub(crate) fn is_singular_place(machine: &Machine, at: &Configuration, workspace: &mut Workspace) -> bool {
    let (state, load, settings) = (State::rigid(machine, at), Wrench::zero(), Settings::default());
    let mut newton = Newton::new(machine, &at.drives, &load, None, &state, workspace, &settings);
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
    /// Where the drives are at first.
    drives: &'a [f64],
    load: &'a Wrench,
    /// What the drives are to achieve; without it they stay.
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
    imbalance: [f64; 6],
    task: Option<TaskError>,
    /// Whether the chains are condensed.
    is_condensed: bool,
    /// Largest of the closure gaps, forces out of balance and task errors, dimensionless.
    residual: f64,
}

impl<'a> Newton<'a> {
    /// Takes up where the solve starts.
    fn new(
        machine: &'a Machine,
        drives: &'a [f64],
        load: &'a Wrench,
        task: Option<&'a dyn Fn(&Pose) -> TaskError>,
        start: &State,
        workspace: &'a mut Workspace,
        settings: &'a Settings,
    ) -> Self {
        debug_assert_eq!(drives.len(), machine.drive_count());
        workspace.solver.put(0, drives, start);
        workspace.solver.loads[0] = *load;
        Self {
            machine,
            drives,
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

    /// Iterates to convergence from where the solver stands; the residual reached, or `None` if the iteration fails.
    fn solve(&mut self) -> Option<f64> {
        let mut iteration = Iteration::new();
        for _ in 0..=self.settings.max_iterations {
            let balance = self.linearise();
            match iteration.judge(balance.residual, self.settings) {
                Verdict::Solved => return Some(balance.residual),
                Verdict::Failed => return None,
                Verdict::Continue => {}
            }
            let twist = self.step(&balance)?;
            if !iteration.accepts(self.workspace.solver.largest_turn(&twist)) {
                return None;
            }
            self.workspace.solver.apply(self.machine, twist, 1);
            self.iterations += 1;
        }
        None
    }

    /// Brings on the load and the chain errors in adaptive steps from `start`, by holding back a shrinking share of the starting
    /// residual. Err: how it ends, and the last residual.
    fn load_stepping(&mut self, start: &State) -> Result<Reached, (Status, f64)> {
        self.held = 0.0;
        self.workspace.solver.put(0, self.drives, start);
        let held_imbalance = self.linearise().imbalance;
        self.fill();
        let Workspace { solver, held, .. } = &mut *self.workspace;
        for (held, system) in held.iter_mut().zip(&solver.systems) {
            held.remember(system, &solver.platform.into());
        }
        self.workspace.held_imbalance = held_imbalance;
        let unloaded = self.softest(start);
        if unloaded.is_nearly_free() {
            return Err((Status::SingularPlace, f64::INFINITY));
        }
        let mut lost = None;
        let (mut fraction, mut step, mut steps) = (0.0, 0.5f64, 0);
        let mut last = start.clone();
        let mut residual = f64::INFINITY;
        while fraction < 1.0 {
            let next = f64::min(1.0, fraction + step);
            self.held = 1.0 - next;
            match self.solve() {
                Some(reached) => {
                    (fraction, residual) = (next, reached);
                    steps += 1;
                    step *= 2.0;
                    self.workspace.solver.store(0, &mut last);
                    if lost.is_none() && !self.softest(&last).is_stable {
                        lost = Some(fraction);
                    }
                }
                None if step > MIN_LOAD_STEP => {
                    self.workspace.solver.put(0, self.drives, &last);
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
            true => Status::SnapThrough { load_fraction: fraction },
            false => Status::NotConverged { load_fraction: fraction },
        }
    }

    /// Whether the machine is singular at `start`, where the solve began, and at home not so. Loads and errors that stiffen it do not
    /// lead away from there.
    fn is_at_singular_place(&mut self, status: &Status, start: &State) -> bool {
        if matches!(status, Status::Singular | Status::SingularPlace)
            || (self.is_plainly_stable && !self.has_idle_motion && *status == Status::Solved)
        {
            return false;
        }
        self.held = 0.0;
        let mut end = start.clone();
        self.workspace.solver.store(0, &mut end);
        let is_singular = (self.has_idle_motion && !self.free_at_home().idle)
            || !(self.is_plainly_stable && *status == Status::Solved) && self.is_freer_than_at_home(start);
        self.workspace.solver.put(0, self.drives, &end);
        is_singular
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
        let home = &self.machine.home;
        let drives = std::mem::replace(&mut self.drives, &home.drives);
        let softest = self.softest_without_weight(&State::rigid(self.machine, home));
        self.drives = drives;
        let free = FreeAtHome { idle: softest.has_idle_motion, platform: softest.is_nearly_free() };
        self.workspace.free_at_home = Some(free);
        free
    }

    /// The platform's softest direction at an equilibrium, part of the load held back.
    fn softest(&mut self, state: &State) -> Softest {
        self.workspace.solver.put(0, self.drives, state);
        let scale = self.machine.characteristic_length;
        if self.linearise().is_condensed {
            let LaneSolver { rigid, tangent, .. } = &mut self.workspace.solver;
            let matrix = platform::matrix(tangent);
            let is_stable = platform_status(&matrix, scale) == Status::Solved;
            if rigid.is_empty() {
                return Softest::of_stiffness(&matrix, scale, is_stable);
            }
            let (compliance, regular) = platform::compliance(rigid, *tangent);
            let compliance = (regular == 1).then(|| platform::matrix(&compliance));
            return Softest::of_compliance(compliance.as_ref(), scale, is_stable, rigid);
        }
        let full = self.full_tangent();
        let is_stable = full.status == Status::Solved;
        let softest = Softest::of_compliance(full.compliance.as_ref(), scale, is_stable, &self.workspace.solver.rigid);
        Softest { has_idle_motion: full.has_idle_motion, ..softest }
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

    /// Fills the systems of all chains where the solver stands, and condenses them if that is possible.
    fn linearise(&mut self) -> Balance {
        let is_condensed = self.workspace.fill(self.machine, &self.gravity, self.held, true);
        let Workspace { solver, held_imbalance, .. } = &*self.workspace;
        let (body, scale) = (solver.platform.into(), self.machine.characteristic_length);
        let load = tool::load_on_body(self.machine, &body, self.load).to_array();
        let mut imbalance = solver.imbalance(self.machine, Vec3::splat(&self.gravity), load);
        if self.held > 0.0 {
            for (entry, held) in imbalance.iter_mut().zip(held_imbalance) {
                *entry -= held * self.held;
            }
        }
        let task = self.task.map(|task| task(&tool::bend(self.machine, &body, self.load)));
        let task_error = task.as_ref().map_or(0.0, |task| task.size() / scale);
        let residual = larger(task_error, solver.residual(scale, load, imbalance));
        Balance { imbalance, task, is_condensed, residual }
    }

    /// Fills the systems anew and leaves them uncondensed, for the system of all unknowns.
    fn fill(&mut self) {
        self.workspace.fill(self.machine, &self.gravity, self.held, false);
    }

    /// One Newton step from the present linearisation; the twist of P. Chain steps are left in the chain systems.
    fn step(&mut self, balance: &Balance) -> Option<[f64; 6]> {
        if !balance.is_condensed {
            if balance.task.is_some() {
                return None;
            }
            self.is_plainly_stable &= self.iterations > 0;
            self.fill();
            let stiffness = self.platform_stiffness();
            let systems = &mut self.workspace.solver.systems;
            return full_system::step(systems, &stiffness, &balance.imbalance.into()).map(Into::into);
        }
        let solver = &mut self.workspace.solver;
        if self.iterations == 0 {
            self.is_plainly_stable =
                platform::plainly_definite(&solver.tangent, self.machine.characteristic_length) == 1;
        }
        let task = match &balance.task {
            // Where the drives are not as many as the task coordinates, there is no step.
            Some(task) => Some(SquareTask::new(task, self.drives.len())?),
            None => None,
        };
        let (twist, regular) = solver.step(balance.imbalance, task.as_ref());
        (regular == 1).then_some(twist)
    }

    /// The platform's own stiffness, by its weight and the load that a bent tool carries aside.
    fn platform_stiffness(&self) -> Matrix6<f64> {
        let body: Pose = self.workspace.solver.platform.into();
        let mut own = platform::rows(&weight::stiffness(self.machine, &body.rotation, &self.gravity));
        tool::add_stiffness(self.machine, &body, self.load, &mut own);
        platform::matrix(&own)
    }

    /// Tangent of the system of all unknowns, filled anew.
    fn full_tangent(&mut self) -> FullTangent {
        self.fill();
        let stiffness = self.platform_stiffness();
        full_system::tangent(&self.machine.chains, &self.workspace.solver.systems, &stiffness)
    }

    /// Tangent and stability at the equilibrium just linearised.
    fn finish(&mut self, residual: f64, load_steps: usize) -> Outcome {
        let scale = self.machine.characteristic_length;
        if self.workspace.solver.condensed == 1 {
            let solver = &mut self.workspace.solver;
            // Most by far need no eigenvalues.
            let is_definite = platform::plainly_definite(&solver.tangent, scale) == 1;
            self.is_plainly_stable &= is_definite;
            let stiffness = platform::matrix(&solver.tangent);
            let status = if is_definite { Status::Solved } else { platform_status(&stiffness, scale) };
            let (compliance, regular) = solver.compliance();
            if status == Status::Singular || regular == 0 {
                return Outcome { load_steps, stiffness: Some(stiffness), ..self.failed(status, residual) };
            }
            let outcome = solver.outcome(self.machine, 0, &compliance, status, self.iterations, residual);
            return Outcome { load_steps, ..outcome };
        }
        let full = self.full_tangent();
        self.has_idle_motion = full.has_idle_motion;
        let rigid = &self.workspace.solver.rigid;
        if full.compliance.is_some_and(|compliance| is_free(&compliance, scale, rigid)) {
            return Outcome { load_steps, ..self.failed(Status::Singular, residual) };
        }
        let stiffness =
            full.compliance.as_ref().and_then(|compliance| full_system::invert_if_regular(compliance, scale));
        let FullTangent { status, compliance, drive_sensitivity, .. } = full;
        Outcome { status, iterations: self.iterations, residual, load_steps, stiffness, compliance, drive_sensitivity }
    }
}

/// A smallest eigenvalue below this fraction of the largest is zero: at a singular place, inverse kinematics leaves as much.
const FREE: f64 = 1e-11;

/// A compliance below this fraction of the largest is that of a rigid direction.
const RIGID: f64 = 1e-12;

/// The softest direction of the platform, rotations taken at the machine's characteristic length.
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
    fn of_stiffness(stiffness: &Matrix6<f64>, scale: f64, is_stable: bool) -> Self {
        let stiffness = at_length(stiffness, scale);
        let values = stiffness.map(|stiffness| stiffness.symmetric_eigenvalues());
        let (value, largest) = values.map_or((f64::NAN, f64::NAN), |values| (values.min(), values.amax()));
        Self { value, largest, stiffness, is_stable, has_idle_motion: false }
    }

    /// From the compliance at P; `None` for a free platform. Rotations are taken at `scale`, mm; a slack yields as drives do.
    fn of_compliance(compliance: Option<&Matrix6<f64>>, scale: f64, is_stable: bool, rigid: &RigidDirections) -> Self {
        let (mut value, mut largest, mut stiffness) = (0.0, 1.0, None);
        if let Some(compliance) = compliance.and_then(|compliance| at_length(compliance, 1.0 / scale)) {
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

/// The symmetric part of a stiffness in N/mm, rotations taken at `scale` mm (of a compliance: 1/`scale`); `None` where an
/// entry is not finite, with which eigenvalue iterations do not end.
fn at_length(stiffness: &Matrix6<f64>, scale: f64) -> Option<Matrix6<f64>> {
    let mut scaled = (stiffness + stiffness.transpose()) * 0.5;
    for i in 3..6 {
        scaled.row_mut(i).unscale_mut(scale);
        scaled.column_mut(i).unscale_mut(scale);
    }
    scaled.iter().all(|entry| entry.is_finite()).then_some(scaled)
}

/// Whether a compliance is that of a platform which only rounding holds in some direction; a slack yields as drives do.
fn is_free(compliance: &Matrix6<f64>, scale: f64, rigid: &RigidDirections) -> bool {
    at_length(compliance, 1.0 / scale).is_some_and(|compliance| {
        let values = compliance.symmetric_eigenvalues().abs();
        let is_rigid = values.min() <= rigid.nearly_rigid().max(RIGID * values.max());
        let stiffest = if is_rigid { rigid.slack_compliance() } else { values.min() };
        stiffest <= FREE * values.max()
    })
}

/// Stability of the platform from its tangent stiffness; `scale` in mm makes rotations comparable.
fn platform_status(tangent: &Matrix6<f64>, scale: f64) -> Status {
    let Some(values) = at_length(tangent, scale).map(|scaled| scaled.symmetric_eigenvalues()) else {
        return Status::Singular;
    };
    match values.min() {
        smallest if smallest.abs() <= FREE * values.amax() => Status::Singular,
        smallest if smallest < 0.0 => Status::Unstable,
        _ => Status::Solved,
    }
}
