//! Equilibrium of the whole machine under a prescribed wrench (eqs. (3) and (7) of the paper), by Newton's iteration on few unknowns;
//! load steps, and whether what they reach is stable, `snap_through` or singular.

use nalgebra::{Matrix6, Matrix6xX, Vector3};

use super::{
    full_system::{self, FullTangent},
    iteration::{Iteration, IterationStatus},
    lane_solver::LaneSolver,
    outcome::{Outcome, Settings, Status, TaskError},
    platform::{self, SquareTask},
    rigid_directions::RigidDirections,
    state::{FreeAtHome, Scratch, State},
    tool, weight,
};
use crate::{
    lanes::Vec3,
    machine::{Configuration, Machine},
    spatial::{Pose, Wrench, larger},
};

/// Equilibrium of `machine` with drives at `drives` (mm, rad) under the dead wrench `load` at P in O axes: `t = f⁻¹(F | t₀)`, eq. (7).
///
/// `state` is where the search starts (for instance [`State::rigid`] or a neighbouring solution) and, if the outcome is any equilibrium, where it
/// ends; otherwise it is left as it was. The full load is tried at once; if that fails, or might have left the branch of the start, load and
/// chain errors are brought on in steps. `drives` has one entry per drive of the machine; `state` and `scratch` belong to `machine`.
pub fn equilibrium(
    machine: &Machine,
    drives: &[f64],
    load: &Wrench,
    state: &mut State,
    scratch: &mut Scratch,
    settings: &Settings,
) -> Outcome {
    let mut newton = Newton::new(machine, drives, load, None, state, scratch, settings);
    let (mut outcome, unstable_at) = match newton.solve() {
        Some(residual) => (newton.outcome(residual, 1), None),
        None => match newton.solve_in_load_steps(state) {
            Ok(SteppedEquilibrium { residual, steps, unstable_at }) => (newton.outcome(residual, steps), unstable_at),
            Err((status, residual)) => (newton.failed_outcome(status, residual), None),
        },
    };
    if let (Some(load_fraction), Status::Solved) = (unstable_at, &outcome.status) {
        outcome = newton.failed_outcome(Status::SnapThrough { load_fraction }, outcome.residual);
    }
    if newton.is_at_singular_place(&outcome.status, state) {
        outcome = newton.failed_outcome(Status::SingularPlace, outcome.residual);
    }
    if outcome.is_equilibrium() {
        scratch.solver.read_state(0, state);
        tool::convert_to_tool_end(machine, load, state, &mut outcome);
    }
    if let Status::Buckled { load_fractions, .. } = &mut outcome.status {
        *load_fractions = buckling_fractions(machine, drives, load, state, scratch, settings);
    }
    outcome
}

/// Returns `[stable, buckled]`, two fractions of `load` (0 to 1) that bracket the loss of stability, at most `BUCKLING_WIDTH` apart unless
/// a solve between them fails; `[0, 0]` if unstable without load; `None` if no unloaded equilibrium can be continued from `state`.
fn buckling_fractions(
    machine: &Machine,
    drives: &[f64],
    load: &Wrench,
    state: &State,
    scratch: &mut Scratch,
    settings: &Settings,
) -> Option<[f64; 2]> {
    let mut is_stable = |fraction: f64| {
        let part = Wrench { force: load.force * fraction, moment: load.moment * fraction };
        let mut newton = Newton::new(machine, drives, &part, None, state, scratch, settings);
        let residual = newton.solve()?;
        Some(newton.outcome(residual, 1).status == Status::Solved)
    };
    if !is_stable(0.0)? {
        return Some([0.0; 2]);
    }
    let [mut stable, mut buckled] = [0.0, 1.0];
    while buckled - stable > BUCKLING_WIDTH {
        let middle = 0.5 * (stable + buckled);
        match is_stable(middle) {
            Some(true) => stable = middle,
            Some(false) => buckled = middle,
            None => break,
        }
    }
    Some([stable, buckled])
}

/// Width of the interval in which the fraction of the load is found at which a chain buckles.
const BUCKLING_WIDTH: f64 = 1.0 / 128.0;

/// Equilibrium of `machine` with the drives where the task error vanishes: one Newton iteration, at the cost of an equilibrium, finds both.
/// `task`, asked once per iteration, gives the task error at a pose of P, in as many coordinates as there are drives. `drives` and `state` are
/// where the search starts, and where it ends; the residual of the outcome includes the task error over the machine's
/// characteristic length. `None` if the iteration fails; `drives` and `state` are then as they were.
pub fn equilibrium_at_task(
    machine: &Machine,
    task: &dyn Fn(&Pose) -> TaskError,
    drives: &mut [f64],
    load: &Wrench,
    state: &mut State,
    scratch: &mut Scratch,
    settings: &Settings,
) -> Option<Outcome> {
    let mut newton = Newton::new(machine, drives, load, Some(task), state, scratch, settings);
    let residual = newton.solve()?;
    let mut outcome = newton.outcome(residual, 1);
    drives.copy_from_slice(&scratch.solver.drives);
    scratch.solver.read_state(0, state);
    tool::convert_to_tool_end(machine, load, state, &mut outcome);
    Some(outcome)
}

/// Whether the unloaded platform or a chain can move without resistance at `at`, though not at home.
pub(crate) fn is_singular_place(machine: &Machine, at: &Configuration, scratch: &mut Scratch) -> bool {
    let (state, load, settings) = (State::rigid(machine, at), Wrench::zero(), Settings::default());
    let mut newton = Newton::new(machine, &at.drives, &load, None, &state, scratch, &settings);
    newton.is_freer_than_at_home(&state)
}

/// Smallest load step, as a fraction of the load.
const MIN_LOAD_STEP: f64 = 1.0 / 4096.0;

/// Load steps end by snap-through where a direction of the platform keeps less than this fraction of its unloaded stiffness.
const SOFTENED: f64 = 0.3;
/// A softest direction below this fraction of the stiffest cannot bear a load.
const NEARLY_FREE: f64 = 1e-9;

/// The Newton iteration of one equilibrium, load steps included.
struct Newton<'a> {
    machine: &'a Machine,
    /// Drive positions at the start, mm or rad.
    drives: &'a [f64],
    load: &'a Wrench,
    /// Task error that the drives are to bring to zero; `None`: the drives stay.
    task: Option<&'a dyn Fn(&Pose) -> TaskError>,
    scratch: &'a mut Scratch,
    settings: &'a Settings,
    /// Weight of a kilogram in O axes, N.
    gravity: Vector3<f64>,
    /// Share of the starting residual that the present load step holds back; 0 for the full load.
    held_share: f64,
    iterations: usize,
    /// Whether the start is condensed and far from singular, and so is the equilibrium found if it is condensed.
    is_plainly_stable: bool,
    /// Whether something, if only within a chain, moves without resistance in the equilibrium found.
    has_idle_motion: bool,
}

/// The equilibrium under full load that load steps reached.
struct SteppedEquilibrium {
    residual: f64,
    steps: usize,
    /// Load fraction at which the machine was first found not stable; `None` if it was stable all the way.
    unstable_at: Option<f64>,
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
    /// Prepares the iteration from the state `start`; `load`: dead wrench at P in O axes (N, N·mm); with a `task` the drives move.
    fn new(
        machine: &'a Machine,
        drives: &'a [f64],
        load: &'a Wrench,
        task: Option<&'a dyn Fn(&Pose) -> TaskError>,
        start: &State,
        scratch: &'a mut Scratch,
        settings: &'a Settings,
    ) -> Self {
        debug_assert_eq!(drives.len(), machine.drive_count());
        scratch.solver.set_state(0, drives, start);
        scratch.solver.loads[0] = *load;
        Self {
            machine,
            drives,
            load,
            task,
            scratch,
            settings,
            gravity: machine.gravity,
            held_share: 0.0,
            iterations: 0,
            is_plainly_stable: true,
            has_idle_motion: false,
        }
    }

    /// Iterates to convergence from the present state of the solver; returns the residual reached, or `None` if the iteration fails.
    fn solve(&mut self) -> Option<f64> {
        let mut iteration = Iteration::new();
        for _ in 0..=self.settings.max_iterations {
            let balance = self.linearise();
            match iteration.judge(balance.residual, self.settings) {
                IterationStatus::Solved => return Some(balance.residual),
                IterationStatus::Failed => return None,
                IterationStatus::Continue => {}
            }
            let twist = self.step(&balance)?;
            if !iteration.accept_step(self.scratch.solver.largest_rotation(&twist)) {
                return None;
            }
            self.scratch.solver.apply(self.machine, twist, 1);
            self.iterations += 1;
        }
        None
    }

    /// Brings on load and chain errors in adaptive steps from `start`, holding back part of its residual. `Err`: final status and last residual.
    fn solve_in_load_steps(&mut self, start: &State) -> Result<SteppedEquilibrium, (Status, f64)> {
        self.held_share = 0.0;
        self.scratch.solver.set_state(0, self.drives, start);
        let start_imbalance = self.linearise().imbalance;
        self.fill_uncondensed();
        let Scratch { solver, start_residuals, .. } = &mut *self.scratch;
        for (start, system) in start_residuals.iter_mut().zip(&solver.systems) {
            start.record(system, &solver.platform.into());
        }
        self.scratch.start_imbalance = start_imbalance;
        let unloaded = self.softest_direction(start);
        if unloaded.is_nearly_free() {
            return Err((Status::SingularPlace, f64::INFINITY));
        }
        let mut unstable_at = None;
        let (mut fraction, mut step, mut steps) = (0.0, 0.5f64, 0);
        let mut last = start.clone();
        let mut residual = f64::INFINITY;
        while fraction < 1.0 {
            let next = f64::min(1.0, fraction + step);
            self.held_share = 1.0 - next;
            match self.solve() {
                Some(reached) => {
                    (fraction, residual) = (next, reached);
                    steps += 1;
                    step *= 2.0;
                    self.scratch.solver.read_state(0, &mut last);
                    if unstable_at.is_none() && !self.softest_direction(&last).is_stable {
                        unstable_at = Some(fraction);
                    }
                }
                None if step > MIN_LOAD_STEP => {
                    self.scratch.solver.set_state(0, self.drives, &last);
                    step *= 0.5;
                }
                None => return Err((self.failure_status(&last, fraction, &unloaded), residual)),
            }
        }
        // The last step is judged as any equilibrium is.
        Ok(SteppedEquilibrium { residual, steps, unstable_at: unstable_at.filter(|&fraction| fraction < 1.0) })
    }

    /// Status where load steps end at the equilibrium `last`, under `fraction` of the load: snap-through, singular or not converged.
    fn failure_status(&mut self, last: &State, fraction: f64, unloaded: &Softest) -> Status {
        self.held_share = 1.0 - fraction;
        let softest = self.softest_direction(last);
        // A joint that is idle wherever the machine stands is not what ends the way.
        if unloaded.has_idle_motion && (fraction == 0.0 || !softest.has_idle_motion) {
            return Status::SingularPlace;
        }
        match fraction > 0.0 && (!softest.is_stable || softest.has_softened(unloaded)) {
            true => Status::SnapThrough { load_fraction: fraction },
            false => Status::NotConverged { load_fraction: fraction },
        }
    }

    /// Whether the machine is singular at `start`, where the solve began, though not at home; that loads or errors stiffen it does not count.
    fn is_at_singular_place(&mut self, status: &Status, start: &State) -> bool {
        if matches!(status, Status::Singular | Status::SingularPlace)
            || (self.is_plainly_stable && !self.has_idle_motion && *status == Status::Solved)
        {
            return false;
        }
        self.held_share = 0.0;
        let mut end = start.clone();
        self.scratch.solver.read_state(0, &mut end);
        let is_singular = (self.has_idle_motion && !self.free_at_home().idle)
            || !(self.is_plainly_stable && *status == Status::Solved) && self.is_freer_than_at_home(start);
        self.scratch.solver.set_state(0, self.drives, &end);
        is_singular
    }

    /// Whether something moves without resistance in `state`, weight left out, but not at home; without weight a free platform counts.
    fn is_freer_than_at_home(&mut self, state: &State) -> bool {
        let softest = self.softest_without_weight(state);
        if softest.is_nearly_free() {
            return !(self.machine.has_weight() && self.free_at_home().platform);
        }
        softest.has_idle_motion && !self.free_at_home().idle
    }

    /// Softest direction of the platform in `state`, weight left out.
    fn softest_without_weight(&mut self, state: &State) -> Softest {
        let gravity = std::mem::replace(&mut self.gravity, Vector3::zeros());
        let softest = self.softest_direction(state);
        self.gravity = gravity;
        softest
    }

    /// Whether the platform or a chain moves without resistance at home, weight left out; computed once per workspace.
    fn free_at_home(&mut self) -> FreeAtHome {
        if let Some(free) = self.scratch.free_at_home {
            return free;
        }
        let home = &self.machine.home;
        let drives = std::mem::replace(&mut self.drives, &home.drives);
        let softest = self.softest_without_weight(&State::rigid(self.machine, home));
        self.drives = drives;
        let free = FreeAtHome { idle: softest.has_idle_motion, platform: softest.is_nearly_free() };
        self.scratch.free_at_home = Some(free);
        free
    }

    /// Softest direction of the platform in `state`, the present share of the load held back.
    fn softest_direction(&mut self, state: &State) -> Softest {
        self.scratch.solver.set_state(0, self.drives, state);
        let scale = self.machine.characteristic_length;
        if self.linearise().is_condensed {
            let LaneSolver { rigid, tangent, .. } = &mut self.scratch.solver;
            let matrix = platform::to_matrix(tangent);
            let is_stable = platform_status(&matrix, scale) == Status::Solved;
            if rigid.is_empty() {
                return Softest::by_stiffness(&matrix, scale, is_stable);
            }
            let (compliance, regular) = platform::compliance(rigid, *tangent);
            let compliance = (regular == 1).then(|| platform::to_matrix(&compliance));
            return Softest::by_compliance(compliance.as_ref(), scale, is_stable, rigid);
        }
        let full = self.full_tangent();
        let is_stable = full.status == Status::Solved;
        let softest = Softest::by_compliance(full.compliance.as_ref(), scale, is_stable, &self.scratch.solver.rigid);
        Softest { has_idle_motion: full.has_idle_motion, ..softest }
    }

    /// Outcome of a solve that ended with `status`, without stiffness and sensitivities.
    fn failed_outcome(&self, status: Status, residual: f64) -> Outcome {
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

    /// Linearises at the present state of the solver, condenses the chains if that is possible, and returns the balance of the platform.
    fn linearise(&mut self) -> Balance {
        let is_condensed = self.scratch.fill(self.machine, &self.gravity, self.held_share, true);
        let Scratch { solver, start_imbalance, .. } = &*self.scratch;
        let (body, scale) = (solver.platform.into(), self.machine.characteristic_length);
        let load = tool::load_on_body(self.machine, &body, self.load).to_array();
        let mut imbalance = solver.imbalance(self.machine, Vec3::splat(&self.gravity), load);
        if self.held_share > 0.0 {
            for (entry, held) in imbalance.iter_mut().zip(start_imbalance) {
                *entry -= held * self.held_share;
            }
        }
        let task = self.task.map(|task| task(&tool::deflected_pose(self.machine, &body, self.load)));
        let task_error = task.as_ref().map_or(0.0, |task| task.size() / scale);
        let residual = larger(task_error, solver.residual(scale, load, imbalance));
        Balance { imbalance, task, is_condensed, residual }
    }

    /// Fills the systems of all chains at the present state and leaves them uncondensed, for the system of all unknowns.
    fn fill_uncondensed(&mut self) {
        self.scratch.fill(self.machine, &self.gravity, self.held_share, false);
    }

    /// Computes a Newton step from `balance`: returns the twist of P (mm, rad), if there is one; chains keep theirs in their systems.
    fn step(&mut self, balance: &Balance) -> Option<[f64; 6]> {
        if !balance.is_condensed {
            if balance.task.is_some() {
                return None;
            }
            self.is_plainly_stable &= self.iterations > 0;
            self.fill_uncondensed();
            let stiffness = self.platform_stiffness();
            let systems = &mut self.scratch.solver.systems;
            return full_system::step(systems, &stiffness, &balance.imbalance.into()).map(Into::into);
        }
        let solver = &mut self.scratch.solver;
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

    /// Stiffness of the platform itself at P, by its weight and by the load that a deflected tool carries aside (N, N·mm; mm, rad).
    fn platform_stiffness(&self) -> Matrix6<f64> {
        let body: Pose = self.scratch.solver.platform.into();
        let mut stiffness = platform::to_rows(&weight::stiffness(self.machine, &body.rotation, &self.gravity));
        tool::add_stiffness(self.machine, &body, self.load, &mut stiffness);
        platform::to_matrix(&stiffness)
    }

    /// Tangent of the system of all unknowns, filled anew at the present state of the solver.
    fn full_tangent(&mut self) -> FullTangent {
        self.fill_uncondensed();
        let stiffness = self.platform_stiffness();
        full_system::tangent(&self.machine.chains, &self.scratch.solver.systems, &stiffness)
    }

    /// Outcome of the equilibrium just linearised, with its tangent and stability.
    fn outcome(&mut self, residual: f64, load_steps: usize) -> Outcome {
        let scale = self.machine.characteristic_length;
        if self.scratch.solver.condensed == 1 {
            let solver = &mut self.scratch.solver;
            // Most by far need no eigenvalues.
            let is_definite = platform::plainly_definite(&solver.tangent, scale) == 1;
            self.is_plainly_stable &= is_definite;
            let stiffness = platform::to_matrix(&solver.tangent);
            let status = if is_definite { Status::Solved } else { platform_status(&stiffness, scale) };
            let (compliance, regular) = solver.compliance();
            if status == Status::Singular || regular == 0 {
                return Outcome { load_steps, stiffness: Some(stiffness), ..self.failed_outcome(status, residual) };
            }
            let outcome = solver.outcome(self.machine, 0, &compliance, status, self.iterations, residual);
            return Outcome { load_steps, ..outcome };
        }
        let full = self.full_tangent();
        self.has_idle_motion = full.has_idle_motion;
        let rigid = &self.scratch.solver.rigid;
        if full.compliance.is_some_and(|compliance| is_free(&compliance, scale, rigid)) {
            return Outcome { load_steps, ..self.failed_outcome(Status::Singular, residual) };
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
    /// Stiffness of the softest direction, and of the stiffest that is not rigid, N/mm; NaN where there is none.
    value: f64,
    largest: f64,
    /// Symmetric stiffness in all directions, N/mm; `None` where the platform is free or rigid in some direction.
    stiffness: Option<Matrix6<f64>>,
    is_stable: bool,
    /// Whether a chain can move without resistance while the platform stays.
    has_idle_motion: bool,
}

impl Softest {
    /// Softest direction by the stiffness at P, rotations taken at `scale` mm.
    fn by_stiffness(stiffness: &Matrix6<f64>, scale: f64, is_stable: bool) -> Self {
        let stiffness = scaled_symmetric(stiffness, scale);
        let values = stiffness.map(|stiffness| stiffness.symmetric_eigenvalues());
        let (value, largest) = values.map_or((f64::NAN, f64::NAN), |values| (values.min(), values.amax()));
        Self { value, largest, stiffness, is_stable, has_idle_motion: false }
    }

    /// Softest direction by the compliance at P, rotations at `scale` mm; `None`: free platform. Rigid ones yield as the slacks of `rigid`.
    fn by_compliance(compliance: Option<&Matrix6<f64>>, scale: f64, is_stable: bool, rigid: &RigidDirections) -> Self {
        let (mut value, mut largest, mut stiffness) = (0.0, 1.0, None);
        if let Some(compliance) = compliance.and_then(|compliance| scaled_symmetric(compliance, 1.0 / scale)) {
            let values = compliance.symmetric_eigenvalues();
            let (least, most) = (values.min(), values.max());
            let is_rigid = least <= rigid.nearly_rigid_compliance().max(RIGID * most);
            value = if most > 0.0 { 1.0 / most } else { f64::MAX };
            largest = 1.0 / if is_rigid { rigid.slack_compliance() } else { least };
            stiffness = if is_rigid { None } else { compliance.try_inverse() };
        }
        Self { value, largest, stiffness, is_stable, has_idle_motion: false }
    }

    /// Whether the softest direction has next to no stiffness, compared with the stiffest direction.
    fn is_nearly_free(&self) -> bool {
        self.value.abs() <= NEARLY_FREE * self.largest
    }

    /// Whether a direction keeps less than [`SOFTENED`] of the stiffness it had in `before`.
    fn has_softened(&self, before: &Self) -> bool {
        let factor = before.stiffness.and_then(|stiffness| stiffness.cholesky());
        let (Some(factor), Some(stiffness)) = (factor, self.stiffness) else {
            return self.value < SOFTENED * before.value;
        };
        let scaled = factor.l().solve_lower_triangular(&stiffness);
        let shares = scaled.and_then(|scaled| factor.l().solve_lower_triangular(&scaled.transpose()));
        shares.is_some_and(|shares| shares.symmetric_eigenvalues().min() < SOFTENED)
    }
}

/// Symmetric part of a stiffness in N/mm, rotations taken at `scale` mm (of a compliance: 1/`scale`); `None` where an entry is not finite.
fn scaled_symmetric(stiffness: &Matrix6<f64>, scale: f64) -> Option<Matrix6<f64>> {
    let mut scaled = (stiffness + stiffness.transpose()) * 0.5;
    for i in 3..6 {
        scaled.row_mut(i).unscale_mut(scale);
        scaled.column_mut(i).unscale_mut(scale);
    }
    scaled.iter().all(|entry| entry.is_finite()).then_some(scaled)
}

/// Whether only rounding holds a platform of this compliance in some direction. A rigid direction counts as the slack springs of `rigid`.
fn is_free(compliance: &Matrix6<f64>, scale: f64, rigid: &RigidDirections) -> bool {
    scaled_symmetric(compliance, 1.0 / scale).is_some_and(|compliance| {
        let values = compliance.symmetric_eigenvalues().abs();
        let is_rigid = values.min() <= rigid.nearly_rigid_compliance().max(RIGID * values.max());
        let stiffest = if is_rigid { rigid.slack_compliance() } else { values.min() };
        stiffest <= FREE * values.max()
    })
}

/// Stability of the platform by its tangent stiffness: solved, unstable or singular; `scale` in mm makes rotations comparable.
fn platform_status(tangent: &Matrix6<f64>, scale: f64) -> Status {
    let Some(values) = scaled_symmetric(tangent, scale).map(|scaled| scaled.symmetric_eigenvalues()) else {
        return Status::Singular;
    };
    match values.min() {
        smallest if smallest.abs() <= FREE * values.amax() => Status::Singular,
        smallest if smallest < 0.0 => Status::Unstable,
        _ => Status::Solved,
    }
}
