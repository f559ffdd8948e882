//! A machine commanded point after point: nominal inverse kinematics, loaded equilibrium, task error.

use nalgebra::{Matrix3, Vector3, Vector6};

use super::{
    outcome::{Compensation, CompensationStatus},
    task_point::TaskPoint,
    workpiece::Workpiece,
};
use crate::{
    machine::{BatchKinematics, Configuration, Machine, PositionedMachine, Unreachable, ZeroState},
    spatial::{Pose, Wrench, larger, matrix_product, rotation_log},
    statics::{self, Batch, Outcome, Scratch, State, TaskError, equilibrium},
};

/// End of a method: a status and the equilibrium at its command, or the reason why there is none.
pub(super) type MethodResult = Result<(CompensationStatus, Outcome), CompensationStatus>;

/// Tolerance and number of iterations at which a compensation stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensationSettings {
    /// Task error accepted, as a fraction of the characteristic length, at which rotations count; at least 3 times `equilibrium.tolerance`.
    pub tolerance: f64,
    /// Largest number of corrections.
    pub max_iterations: usize,
    /// Settings of each equilibrium.
    pub equilibrium: statics::Settings,
}

/// Ratio of a compensation's tolerance to that of an equilibrium, which smaller corrections would not move: the iteration would not end.
const TASK_TO_EQUILIBRIUM_TOLERANCE: f64 = 3.0;
/// Largest number of corrections unless another is set.
const MAX_CORRECTIONS: usize = 200;

impl CompensationSettings {
    /// Returns settings that solve each equilibrium to `tolerance` (relative to the characteristic length) and accept task errors up to
    /// `TASK_TO_EQUILIBRIUM_TOLERANCE` times that; at most `MAX_CORRECTIONS` corrections.
    pub fn with_equilibrium_tolerance(tolerance: f64) -> Self {
        let equilibrium = statics::Settings { tolerance, ..statics::Settings::default() };
        Self { tolerance: TASK_TO_EQUILIBRIUM_TOLERANCE * tolerance, max_iterations: MAX_CORRECTIONS, equilibrium }
    }

    /// Task error accepted on `machine`, mm.
    pub fn tolerance_mm(&self, machine: &Machine) -> f64 {
        self.tolerance * machine.characteristic_length
    }
}

impl Default for CompensationSettings {
    fn default() -> Self {
        Self::with_equilibrium_tolerance(1e-13)
    }
}

/// The nominal machine, by which commands are computed, the actual one, which is simulated, and the present state of both.
/// Consecutive points start from one another; the results do not depend on it beyond rounding.
#[derive(Debug, Clone)]
pub struct Session {
    /// The nominal machine.
    pub(crate) nominal: PositionedMachine,
    /// The machine with its errors.
    pub(crate) actual: Machine,
    /// Tolerances and numbers of iterations.
    pub settings: CompensationSettings,
    pub(super) scratch: Scratch,
    /// Machine whose equilibrium under weight alone deflections are measured from, if the nominal machine is calibrated so.
    unloaded: Machine,
    unloaded_scratch: Option<Scratch>,
    /// A nominal configuration near the present command; that of the command unless a method has moved `drives`.
    pub(super) command: Configuration,
    /// Drives at the present command.
    pub(super) drives: Vec<f64>,
    /// Equilibrium last reached.
    pub(super) state: State,
    /// The pose last asked for in [`Session::with_wanted_pose`], and the nominal machine's pose of P there under weight alone.
    rest: Option<(Pose, Pose)>,
    /// Where the compensated point should be beside what is wanted otherwise, of the last task, O axes, mm.
    pub(super) aside: Vector3<f64>,
    /// Whether the wanted pose is the nominal machine's equilibrium under its weight and springs.
    is_calibrated_under_weight: bool,
    /// Carrier of the workpiece, if it can move or bend.
    workpiece: Option<Workpiece>,
    seeded: Option<SeededInverse>,
    /// Storage for several sessions at a time.
    pub(super) side_by_side: Option<Box<BatchKinematics>>,
    /// Storage for what is computed as in a batch, of this session alone.
    pub(super) alone: Option<Box<Batch>>,
    /// Storage for equilibria under weight alone of several sessions at a time.
    pub(super) under_weight: Option<Box<Batch>>,
}

/// Nominal inverse kinematics `at` for `pose`, searched from `from`.
#[derive(Debug, Clone)]
struct SeededInverse {
    from: Configuration,
    pose: Pose,
    at: Configuration,
}

impl SeededInverse {
    /// Whether the seed is for a search of `pose` from `from`.
    fn is_for(&self, from: &Configuration, pose: &Pose) -> bool {
        self.pose == *pose && self.from == *from
    }
}

impl Session {
    /// A session at home, unloaded.
    pub fn new(nominal: &Machine, actual: &Machine, settings: CompensationSettings) -> Self {
        Self {
            nominal: PositionedMachine::new(nominal),
            actual: actual.clone(),
            settings,
            scratch: Scratch::new(actual),
            unloaded: nominal.clone(),
            unloaded_scratch: None,
            command: nominal.home.clone(),
            drives: nominal.home.drives.clone(),
            state: State::rigid(nominal, &nominal.home),
            rest: None,
            aside: Vector3::zeros(),
            is_calibrated_under_weight: nominal.zeroed == ZeroState::AtRest && nominal.own_load_text().is_some(),
            workpiece: Workpiece::new(nominal, actual),
            seeded: None,
            side_by_side: None,
            alone: None,
            under_weight: None,
        }
    }

    /// This session with deflections measured from where `machine`, the nominal one with other drive offsets, stands under weight alone.
    #[must_use]
    pub fn with_unloaded_machine(self, machine: &Machine) -> Self {
        Self { unloaded: machine.clone(), ..self }
    }

    /// Seeds the session with a known result: nominal inverse kinematics of `pose`, searched from `from`, gives `at`.
    pub fn seed(&mut self, from: &Configuration, pose: &Pose, at: &Configuration) {
        match &mut self.seeded {
            Some(seeded) => {
                seeded.from.clone_from(from);
                seeded.pose = *pose;
                seeded.at.clone_from(at);
            }
            None => self.seeded = Some(SeededInverse { from: from.clone(), pose: *pose, at: at.clone() }),
        }
    }

    /// Seeds the session with `at`, the nominal inverse kinematics of `pose` searched from the present command.
    pub(super) fn seed_from_command(&mut self, pose: &Pose, at: Configuration) {
        match &mut self.seeded {
            Some(seeded) => {
                seeded.from.clone_from(&self.command);
                (seeded.pose, seeded.at) = (*pose, at);
            }
            None => self.seeded = Some(SeededInverse { from: self.command.clone(), pose: *pose, at }),
        }
    }

    /// Whether [`Session::command_pose`] would have to search for `pose`.
    pub(super) fn needs_search(&self, pose: &Pose) -> bool {
        self.command.pose != *pose && self.seeded_for(pose).is_none()
    }

    /// Moves the external axes to where `task` has them; `Err` where the other drives cannot meet the home pose there.
    fn move_external_axes(&mut self, task: &TaskPoint) -> Result<(), CompensationStatus> {
        if self.nominal.move_to(task.external).map_err(CompensationStatus::Unreachable)? {
            if let Some(workpiece) = &mut self.workpiece {
                workpiece.set_home(&self.nominal);
            }
            self.rest = None;
            self.seeded = None;
        }
        Ok(())
    }

    /// Task error accepted, mm.
    pub(super) fn tolerance_mm(&self) -> f64 {
        self.settings.tolerance_mm(&self.nominal)
    }

    /// Appends the `error` (mm) to `progress` as [`Progress::record_error`], whose status is returned; `None` to go on.
    pub(super) fn status_if_over(&self, progress: &mut Progress, error: f64) -> Option<CompensationStatus> {
        progress.record_error(error, self.tolerance_mm(), self.settings.max_iterations)
    }

    /// Equilibrium last reached.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Nominal configuration of the present command, if its limits were checked; else one near it.
    pub fn command(&self) -> &Configuration {
        &self.command
    }

    /// Task point with its wanted pose: where the nominal machine is under its weight alone at the command, if it is calibrated so, else
    /// the commanded pose. A carried workpiece moves that pose with it, as the load moves it.
    /// The task must be as it was asked: what is wanted is not moved twice.
    ///
    /// # Errors
    /// The pose cannot be commanded, or the machine does not stand there under its weight, or the workpiece's carrier under the load.
    pub fn with_wanted_pose(&mut self, task: &TaskPoint) -> Result<TaskPoint, CompensationStatus> {
        self.move_external_axes(task)?;
        let mut ready = self.wanted_by_machine(task)?;
        if let Some(workpiece) = &mut self.workpiece {
            let at_rest = task.wanted.is_none() && self.nominal.zeroed == ZeroState::AtRest;
            let moved = workpiece.displacement(task, self.nominal.tool_tip, at_rest, &self.settings.equilibrium)?;
            ready.wanted = Some(moved.compose(ready.wanted()));
        }
        self.aside = ready.aside;
        if ready.aside != Vector3::zeros() {
            let wanted = ready.wanted();
            ready.wanted = Some(Pose { translation: wanted.translation + ready.aside, ..*wanted });
            ready.aside = Vector3::zeros();
        }
        Ok(ready)
    }

    /// Compliance of the workpiece where the tool touches it under the load of `task`: displacement in O per force, mm/N; zero if it is fixed.
    ///
    /// # Errors
    /// The workpiece's carrier has no stable equilibrium.
    pub fn workpiece_compliance(&mut self, task: &TaskPoint) -> Result<Matrix3<f64>, CompensationStatus> {
        let Some(workpiece) = &mut self.workpiece else { return Ok(Matrix3::zeros()) };
        workpiece.compliance(task, self.nominal.tool_tip, &self.settings.equilibrium)
    }

    /// The task with the wanted pose of a fixed workpiece: where the nominal machine stands under its weight alone, if it is calibrated so.
    fn wanted_by_machine(&mut self, task: &TaskPoint) -> Result<TaskPoint, CompensationStatus> {
        if task.wanted.is_some() || !self.is_calibrated_under_weight {
            return Ok(*task);
        }
        let rest = match self.rest {
            Some((pose, rest)) if pose == task.pose => rest,
            _ => self.pose_under_weight(&task.pose)?,
        };
        self.rest = Some((task.pose, rest));
        Ok(TaskPoint { wanted: Some(rest), ..*task })
    }

    /// Pose of P in O of the nominal machine under its weight alone, commanded to `pose`; `Err` if unreachable or not stable.
    fn pose_under_weight(&mut self, pose: &Pose) -> Result<Pose, CompensationStatus> {
        let at = match self.seeded_for(pose) {
            Some(at) => at.clone(),
            None => match self.nominal.inverse_kinematics_from(&self.command, pose) {
                Ok(at) => {
                    // The command that follows is sought from here, too.
                    self.seed_from_command(pose, at.clone());
                    at
                }
                Err(_) => self.nominal.inverse_kinematics(pose).map_err(CompensationStatus::Unreachable)?,
            },
        };
        let scratch = self.unloaded_scratch.get_or_insert_with(|| Scratch::new(&self.unloaded));
        let (mut state, settings) = (State::rigid(&self.nominal, &at), &self.settings.equilibrium);
        let outcome = equilibrium(&self.unloaded, &at.drives, &Wrench::zero(), &mut state, scratch, settings);
        Self::require_stable(outcome)?;
        Ok(state.pose)
    }

    /// Whether [`Session::with_wanted_pose`] would have to solve where the nominal machine stands under its weight at the pose of `task`.
    pub(super) fn needs_rest(&self, task: &TaskPoint) -> bool {
        let is_known = self.rest.is_some_and(|(pose, _)| pose == task.pose);
        self.is_calibrated_under_weight && task.wanted.is_none() && !is_known
    }

    /// Configuration from which it would; `None` if it need not, or inverse kinematics is not seeded.
    pub(super) fn pending_rest(&self, task: &TaskPoint) -> Option<&Configuration> {
        if self.needs_rest(task) { self.seeded_for(&task.pose) } else { None }
    }

    /// The machine that stands under its weight alone where deflections are measured from.
    pub(super) fn unloaded(&self) -> &Machine {
        &self.unloaded
    }

    /// Tells where the nominal machine stands under its weight alone, commanded to `pose`.
    pub(super) fn set_rest(&mut self, pose: Pose, rest: Pose) {
        self.rest = Some((pose, rest));
    }

    /// The nominal inverse kinematics of `pose` searched from the present command, if it is seeded.
    fn seeded_for(&self, pose: &Pose) -> Option<&Configuration> {
        self.seeded.as_ref().filter(|seeded| seeded.is_for(&self.command, pose)).map(|seeded| &seeded.at)
    }

    /// Sets the nominal configuration and the state of the actual machine.
    pub fn set_state(&mut self, command: &Configuration, state: &State) {
        self.command.clone_from(command);
        self.drives.clone_from(&command.drives);
        self.state.clone_from(state);
    }

    /// Commands the nominal configuration `command`, with the actual machine undeflected there.
    pub fn set_rigid(&mut self, command: &Configuration) {
        self.command.clone_from(command);
        self.drives.clone_from(&command.drives);
        self.state.set_rigid(command);
    }

    /// Begins anew at the nominal configuration `command`, the actual machine undeflected: what comes does not depend on what was before.
    pub fn restart(&mut self, command: &Configuration) {
        self.set_rigid(command);
        (self.rest, self.seeded) = (None, None);
    }

    /// The pose that commands the present drives: the modified target `t₀^(F)`, by nominal forward kinematics.
    ///
    /// # Errors
    /// The nominal chains do not close with these drives.
    pub fn target(&mut self) -> Result<Pose, Unreachable> {
        if self.command.drives != self.drives {
            self.command = self.nominal.forward_kinematics_from(&self.command, &self.drives)?;
        }
        Ok(self.command.pose)
    }

    /// Configuration from which [`Session::target`] would search, and the drives for which; `None` if it need not.
    pub(super) fn pending_target(&self) -> Option<(&Configuration, &[f64])> {
        (self.command.drives != self.drives).then_some((&self.command, self.drives.as_slice()))
    }

    /// Checks travel and joint limits of the nominal machine at the present drives.
    pub(super) fn check_limits(&mut self) -> Result<(), Unreachable> {
        if !self.nominal.has_limits() {
            return Ok(());
        }
        self.target()?;
        self.nominal.check_limits(&self.command)
    }

    /// Commands `pose` of P in O: sets command and drives by nominal inverse kinematics from the present command; `Err` if unreachable.
    pub(super) fn command_pose(&mut self, pose: &Pose) -> Result<(), CompensationStatus> {
        if self.command.pose != *pose
            && let Some(seeded) = self.seeded.as_ref().filter(|seeded| seeded.is_for(&self.command, pose))
        {
            self.command.clone_from(&seeded.at);
        } else if self.command.pose != *pose {
            let near = self.nominal.inverse_kinematics_from(&self.command, pose);
            self.command = match near {
                Ok(configuration) => configuration,
                // The way from the last command may leave the workspace where the way from home does not.
                Err(_) => self.nominal.inverse_kinematics(pose).map_err(CompensationStatus::Unreachable)?,
            };
        }
        self.drives.clone_from(&self.command.drives);
        Ok(())
    }

    /// Largest difference of `drives` from the present ones, as a share of the characteristic length; rotations count at that length.
    pub(super) fn drive_difference(&self, drives: &[f64]) -> f64 {
        let scale = self.nominal.characteristic_length;
        let units = self.nominal.drives().map(|(_, drive)| drive.motion.choose(1.0, scale) / scale);
        let differences =
            self.drives.iter().zip(drives).zip(units).map(|((present, other), unit)| (present - other).abs() * unit);
        differences.fold(0.0, larger)
    }

    /// Loaded equilibrium at the present drives, sought from the present state and then from the nominal one.
    pub(super) fn solve_stable(&mut self, task: &TaskPoint) -> Result<Outcome, CompensationStatus> {
        let outcome = self.solve_near_state(task);
        self.accept_or_solve_anew(task, outcome)
    }

    /// Accepts `outcome` if it is stable and the platform is near its command, else solves from the rigid configuration; `Err` if singular.
    pub(super) fn accept_or_solve_anew(
        &mut self,
        task: &TaskPoint,
        outcome: Outcome,
    ) -> Result<Outcome, CompensationStatus> {
        let mut outcome = Self::require_stable(outcome);
        if outcome.is_err() || self.is_assembled_otherwise() {
            let rigid = State::rigid(&self.nominal, &self.command);
            if self.state != rigid {
                self.state = rigid;
                outcome = self.stable_near_state(task);
            }
        }
        match self.is_at_singular_place(&outcome) {
            true => Err(CompensationStatus::NoEquilibrium(statics::Status::SingularPlace)),
            false => outcome,
        }
    }

    /// Whether the platform is so far from its command that no load brings it there: drives that moved far at once may leave the chains
    /// closed another way, where the machine is in equilibrium as well.
    fn is_assembled_otherwise(&self) -> bool {
        let way = self.state.pose.translation - self.command.pose.translation;
        let is_at_command = self.command.drives == self.drives;
        is_at_command && self.nominal.chains.len() > 1 && way.norm() > self.nominal.characteristic_length
    }

    /// Whether the nominal machine is singular at the present command: only loads and errors then hold the actual one, on either side.
    fn is_at_singular_place(&mut self, outcome: &Result<Outcome, CompensationStatus>) -> bool {
        let is_plain = outcome.as_ref().is_ok_and(|outcome| !outcome.is_soft(&self.nominal));
        if is_plain || self.command.drives != self.drives {
            return false;
        }
        let scratch = self.unloaded_scratch.get_or_insert_with(|| Scratch::new(&self.unloaded));
        statics::is_singular_place(&self.nominal, &self.command, scratch)
    }

    /// Loaded equilibrium at the present drives, searched from the present state only; `Err` has the status if it is not stable.
    pub(super) fn stable_near_state(&mut self, task: &TaskPoint) -> Result<Outcome, CompensationStatus> {
        Self::require_stable(self.solve_near_state(task))
    }

    /// The outcome if it is a stable equilibrium, else its status.
    fn require_stable(outcome: Outcome) -> Result<Outcome, CompensationStatus> {
        match outcome.status {
            statics::Status::Solved => Ok(outcome),
            status => Err(CompensationStatus::NoEquilibrium(status)),
        }
    }

    /// Loaded equilibrium at the present drives, of any status, searched from the present state, which becomes it or, without one, stays.
    fn solve_near_state(&mut self, task: &TaskPoint) -> Outcome {
        let settings = &self.settings.equilibrium;
        equilibrium(&self.actual, &self.drives, &task.load, &mut self.state, &mut self.scratch, settings)
    }

    /// Task error at the present equilibrium.
    pub(super) fn task_error(&self, task: &TaskPoint) -> TaskError {
        task.task_error(&self.nominal, &self.state.pose)
    }

    /// Commands the target shifted by `shift` and finds the equilibrium; returns its task error and outcome.
    pub(super) fn simulate_shifted(
        &mut self,
        task: &TaskPoint,
        shift: &Vector6<f64>,
    ) -> Result<(TaskError, Outcome), CompensationStatus> {
        let solved = self.command_pose(&task.shifted_pose(&self.nominal, shift)).map(|()| self.solve_near_state(task));
        self.accept_shifted(task, shift, solved)
    }

    /// Does as [`Session::simulate_shifted`], but tracks a platform with parasitic rotation so that the compensated point is shifted, not P.
    pub(super) fn simulate_tracked(
        &mut self,
        task: &TaskPoint,
        shift: &Vector6<f64>,
    ) -> Result<(TaskError, Outcome), CompensationStatus> {
        if !self.nominal.has_parasitic_rotation {
            return self.simulate_shifted(task, shift);
        }
        let target = task.shifted_pose(&self.nominal, shift);
        let tracked = self.nominal.track(task.offset(&self.nominal), &target, &self.command);
        let solved = tracked.map_err(CompensationStatus::Unreachable).map(|at| {
            self.drives.clone_from(&at.drives);
            self.command = at;
            self.solve_near_state(task)
        });
        self.accept_shifted(task, shift, solved)
    }

    /// Task error and outcome of the equilibrium `solved` with the target shifted by `shift`; a failure after a long shift is `Diverged`.
    pub(super) fn accept_shifted(
        &mut self,
        task: &TaskPoint,
        shift: &Vector6<f64>,
        solved: Result<Outcome, CompensationStatus>,
    ) -> Result<(TaskError, Outcome), CompensationStatus> {
        let is_far = shift.norm() > self.nominal.characteristic_length;
        let outcome = solved.map_err(|status| if is_far { CompensationStatus::Diverged } else { status })?;
        let outcome = self.accept_or_solve_anew(task, outcome)?;
        Ok((self.task_error(task), outcome))
    }

    /// Returns to the nominal command of `task`, the machine undeflected.
    pub(super) fn reset_to_nominal(&mut self, task: &TaskPoint) -> Result<(), CompensationStatus> {
        self.command_pose(&task.pose)?;
        self.state.set_rigid(&self.command);
        Ok(())
    }

    /// Result of a task not solved for `reason`: present drives and drive forces, zero errors, empty history, no `outcome`.
    pub fn refused(&self, task: &TaskPoint, reason: CompensationStatus) -> Compensation {
        self.conclude(task, Err(reason), Vec::new())
    }

    /// Result of `task` at the present drives and equilibrium, of the status in `ending`; `history`: lengths of its task errors, mm.
    pub(super) fn conclude(&self, task: &TaskPoint, ending: MethodResult, history: Vec<f64>) -> Compensation {
        let offset = task.offset(&self.nominal);
        let (status, outcome) =
            ending.map_or_else(|status| (status, None), |(status, outcome)| (status, Some(outcome)));
        let shown = |v: Vector3<f64>| if outcome.is_some() { v } else { Vector3::zeros() };
        Compensation {
            drives: self.drives.clone(),
            history,
            tool_displacement: shown(self.nominal.tool_displacement(task.wanted(), &self.state.pose)),
            position_error: shown(self.state.pose.transform(offset) - task.wanted().transform(offset)),
            residual_rotation: shown(rotation_log(&matrix_product(
                &self.state.pose.rotation,
                &task.wanted().rotation.transpose(),
            ))),
            drive_forces: statics::drive_forces(&self.actual, &self.state),
            status,
            outcome,
        }
    }
}

/// Errors of an iteration, by which it is over.
#[derive(Debug, Clone)]
pub(super) struct Progress {
    /// Errors so far, mm.
    pub history: Vec<f64>,
    /// Number of growths in a row.
    successive_growths: usize,
}

/// An error of more than this many times the first one is divergence.
const DIVERGENCE_RATIO: f64 = 100.0;
/// Number of growths in a row that are divergence.
const MAX_SUCCESSIVE_GROWTHS: usize = 4;

impl Progress {
    /// An iteration before its first error.
    pub fn new() -> Self {
        Self { history: Vec::new(), successive_growths: 0 }
    }

    /// Appends the error (mm; first that of the nominal command, then one per correction). Returns `Converged`, `Diverged` (not finite, over 100
    /// times the first, or growing 4 times in a row) or `Slow` (not converged after `max_iterations` corrections); `None` to go on.
    fn record_error(&mut self, error: f64, tolerance_mm: f64, max_iterations: usize) -> Option<CompensationStatus> {
        let grown = self.history.last().is_some_and(|last| error > *last);
        self.successive_growths = if grown { self.successive_growths + 1 } else { 0 };
        self.history.push(error);
        if error <= tolerance_mm {
            return Some(CompensationStatus::Converged);
        }
        let first = self.history[0];
        if !error.is_finite() || error > DIVERGENCE_RATIO * first || self.successive_growths >= MAX_SUCCESSIVE_GROWTHS {
            return Some(CompensationStatus::Diverged);
        }
        if self.history.len() > max_iterations { Some(CompensationStatus::Slow) } else { None }
    }
}
