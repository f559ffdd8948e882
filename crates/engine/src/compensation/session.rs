//! A machine being commanded point after point: nominal inverse kinematics, loaded equilibrium, task error.

use nalgebra::{Matrix3, Vector3, Vector6};

use super::{
    outcome::{Compensation, CompensationStatus},
    task_point::TaskPoint,
    workpiece::Workpiece,
};
use crate::{
    machine::{Configuration, Machine, SideBySide, Standing, Unreachable, Zeroed},
    spatial::{Pose, Wrench, product, rotation_log},
    statics::{self, Batch, Outcome, State, TaskError, Workspace, equilibrium},
};

/// How a method ended: with a status and the equilibrium at its command, or with the reason why there is none.
pub(super) type Ending = Result<(CompensationStatus, Outcome), CompensationStatus>;

/// When a compensation stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensationSettings {
    /// Task error accepted, as a fraction of the machine's characteristic length, at which rotations count. At least three
    /// times the tolerance of the equilibria, see [`CompensationSettings::with_equilibria_to`].
    pub tolerance: f64,
    /// Most corrections.
    pub max_iterations: usize,
    /// CompensationSettings of each equilibrium.
    pub equilibrium: statics::Settings,
}

/// A correction of less than the tolerance of an equilibrium does not move it: the iteration would go round in circles.
const EQUILIBRIA: f64 = 3.0;

impl CompensationSettings {
    /// Equilibria to `tolerance` of the characteristic length, and task errors as small as these allow.
    pub fn with_equilibria_to(tolerance: f64) -> Self {
        let equilibrium = statics::Settings { tolerance, ..statics::Settings::default() };
        Self { tolerance: EQUILIBRIA * tolerance, max_iterations: 200, equilibrium }
    }

    /// Task error accepted on `machine`, mm.
    pub fn tolerance_mm(&self, machine: &Machine) -> f64 {
        self.tolerance * machine.characteristic_length
    }
}

impl Default for CompensationSettings {
    fn default() -> Self {
        Self::with_equilibria_to(1e-13)
    }
}

/// The nominal machine, by which commands are computed, the real one, which answers, and where both stand.
///
/// Consecutive points start from one another; the results do not depend on it beyond rounding.
#[derive(Debug, Clone)]
pub struct Session {
    /// The nominal machine.
    pub(crate) nominal: Standing,
    /// The machine with its errors.
    pub real: Machine,
    /// When to stop.
    pub settings: CompensationSettings,
    pub(super) workspace: Workspace,
    /// From whose rest deflections are measured, if the nominal machine is zeroed there.
    unloaded: Machine,
    unloaded_workspace: Option<Workspace>,
    /// A nominal configuration near the present command; its own unless a method has moved `drives`.
    pub(super) command: Configuration,
    /// Drives at the present command.
    pub(super) drives: Vec<f64>,
    /// Equilibrium last reached.
    pub(super) state: State,
    /// The pose last asked to be zeroed at, and where the nominal machine stands then under its weight alone.
    rest: Option<(Pose, Pose)>,
    /// Whether what is wanted is where the nominal machine rests under its weight and springs.
    sags_at_rest: bool,
    /// What carries the workpiece, if it can move or bend.
    workpiece: Option<Workpiece>,
    known: Option<Known>,
    /// Storage for several sessions at a time.
    pub(super) side_by_side: Option<Box<SideBySide>>,
    /// Storage for what is computed as in a batch, of this session alone.
    pub(super) alone: Option<Box<Batch>>,
}

/// What the nominal inverse kinematics gives for `pose`, sought from `from`.
#[derive(Debug, Clone)]
struct Known {
    from: Configuration,
    pose: Pose,
    at: Configuration,
}

impl Known {
    fn serves(&self, from: &Configuration, pose: &Pose) -> bool {
        self.pose == *pose && self.from == *from
    }
}

impl Session {
    /// A session standing at home, unloaded.
    pub fn new(nominal: &Machine, real: &Machine, settings: CompensationSettings) -> Self {
        Self {
            nominal: Standing::new(nominal),
            real: real.clone(),
            settings,
            workspace: Workspace::new(real),
            unloaded: nominal.clone(),
            unloaded_workspace: None,
            command: nominal.home.clone(),
            drives: nominal.home.drives.clone(),
            state: State::rigid(nominal, &nominal.home),
            rest: None,
            sags_at_rest: nominal.zeroed == Zeroed::AtRest && nominal.own_forces().is_some(),
            workpiece: Workpiece::new(nominal, real),
            known: None,
            side_by_side: None,
            alone: None,
        }
    }

    /// The same session, in which deflections from rest are those from where `machine` rests at the nominal command: one with the same
    /// drives as the nominal machine and other offsets of them.
    #[must_use]
    pub fn from_rest_of(self, machine: &Machine) -> Self {
        Self { unloaded: machine.clone(), ..self }
    }

    /// Tells the session what the inverse kinematics of its nominal machine gives for `pose` if it is sought from `from`: that need
    /// not be computed again.
    pub fn know(&mut self, from: &Configuration, pose: &Pose, at: &Configuration) {
        match &mut self.known {
            Some(known) => {
                known.from.clone_from(from);
                known.pose = *pose;
                known.at.clone_from(at);
            }
            None => self.known = Some(Known { from: from.clone(), pose: *pose, at: at.clone() }),
        }
    }

    /// As [`Session::know`], sought from the present command.
    pub(super) fn know_from_command(&mut self, pose: &Pose, at: Configuration) {
        self.known = Some(Known { from: self.command.clone(), pose: *pose, at });
    }

    /// Whether [`Session::go_to`] seeks `pose`.
    pub(super) fn seeks(&self, pose: &Pose) -> bool {
        self.command.pose != *pose && !self.known.as_ref().is_some_and(|known| known.serves(&self.command, pose))
    }

    /// Moves the external axes to where `task` has them.
    fn move_external(&mut self, task: &TaskPoint) -> Result<(), CompensationStatus> {
        if self.nominal.move_to(task.external).map_err(CompensationStatus::Unreachable)? {
            if let Some(workpiece) = &mut self.workpiece {
                workpiece.stand(&self.nominal);
            }
            self.rest = None;
            self.known = None;
        }
        Ok(())
    }

    /// Task error accepted, mm.
    pub(super) fn tolerance_mm(&self) -> f64 {
        self.settings.tolerance_mm(&self.nominal)
    }

    /// Whether the iteration followed by `progress` is over after a correction that left `error` mm, and how.
    pub(super) fn is_over(&self, progress: &mut Progress, error: f64) -> Option<CompensationStatus> {
        progress.note(error, self.tolerance_mm(), self.settings.max_iterations)
    }

    /// Equilibrium last reached.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The nominal configuration of the present command, where its limits have been looked at.
    pub fn command(&self) -> &Configuration {
        &self.command
    }

    /// `task` with what is wanted: where the nominal machine stands under its weight alone at the command, if it is zeroed
    /// at rest; else the pose that is commanded. Where the workpiece is carried, that pose goes with it as the load moves it.
    ///
    /// Of a task as it was asked; what is wanted is not moved twice.
    ///
    /// # Errors
    /// The pose cannot be commanded, or the machine does not stand there under its weight, or the workpiece's carrier under the
    /// load.
    pub fn zeroed(&mut self, task: &TaskPoint) -> Result<TaskPoint, CompensationStatus> {
        self.move_external(task)?;
        let unmoved = self.zeroed_machine(task)?;
        let Some(workpiece) = &mut self.workpiece else { return Ok(unmoved) };
        let at_rest = task.wanted.is_none() && self.nominal.zeroed == Zeroed::AtRest;
        let moved = workpiece.moved(task, self.nominal.tool_tip, at_rest, &self.settings.equilibrium)?;
        Ok(TaskPoint { wanted: Some(moved.compose(unmoved.wanted())), ..unmoved })
    }

    /// Compliance of the workpiece where the tool touches it under the load of `task`: displacement in O per force, mm/N; zero where
    /// it stands fast.
    ///
    /// # Errors
    /// The workpiece's carrier has no stable equilibrium.
    pub fn workpiece_compliance(&mut self, task: &TaskPoint) -> Result<Matrix3<f64>, CompensationStatus> {
        let Some(workpiece) = &mut self.workpiece else { return Ok(Matrix3::zeros()) };
        workpiece.compliance(task, self.nominal.tool_tip, &self.settings.equilibrium)
    }

    /// As [`Session::zeroed`], as if the workpiece stood fast.
    fn zeroed_machine(&mut self, task: &TaskPoint) -> Result<TaskPoint, CompensationStatus> {
        if task.wanted.is_some() || !self.sags_at_rest {
            return Ok(*task);
        }
        let rest = match self.rest {
            Some((pose, rest)) if pose == task.pose => rest,
            _ => self.rest_at(&task.pose)?,
        };
        self.rest = Some((task.pose, rest));
        Ok(TaskPoint { wanted: Some(rest), ..*task })
    }

    /// Where the nominal machine stands under its weight alone when it is commanded to `pose`.
    fn rest_at(&mut self, pose: &Pose) -> Result<Pose, CompensationStatus> {
        let near = self.nominal.inverse_kinematics_from(&self.command, pose);
        let at = near.or_else(|_| self.nominal.inverse_kinematics(pose)).map_err(CompensationStatus::Unreachable)?;
        let workspace = self.unloaded_workspace.get_or_insert_with(|| Workspace::new(&self.unloaded));
        let (mut state, settings) = (State::rigid(&self.nominal, &at), &self.settings.equilibrium);
        let outcome = equilibrium(&self.unloaded, &at.drives, &Wrench::zero(), &mut state, workspace, settings);
        Self::stable(outcome)?;
        Ok(state.pose)
    }

    /// Puts the session at a nominal configuration and a state of the real machine.
    pub fn stand(&mut self, command: &Configuration, state: &State) {
        self.command.clone_from(command);
        self.drives.clone_from(&command.drives);
        self.state.clone_from(state);
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

    /// From where [`Session::target`] seeks, and for which drives, if it does.
    pub(super) fn target_sought(&self) -> Option<(&Configuration, &[f64])> {
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

    /// Commands the nominal machine to `pose`.
    pub(super) fn go_to(&mut self, pose: &Pose) -> Result<(), CompensationStatus> {
        let known = self.known.as_ref().filter(|known| known.serves(&self.command, pose));
        if self.command.pose != *pose
            && let Some(known) = known
        {
            self.command.clone_from(&known.at);
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

    /// By how much `drives` differ from the present ones at most, as a share of the characteristic length, at which rotations count.
    pub(super) fn differs_by(&self, drives: &[f64]) -> f64 {
        let scale = self.nominal.characteristic_length;
        let units = self.nominal.drives().map(|(_, drive)| drive.motion.of(1.0, scale) / scale);
        let differences =
            self.drives.iter().zip(drives).zip(units).map(|((own, other), unit)| (own - other).abs() * unit);
        differences.fold(0.0, f64::max)
    }

    /// Loaded equilibrium at the present drives, sought from the present state and then from the nominal one.
    pub(super) fn settle(&mut self, task: &TaskPoint) -> Result<Outcome, CompensationStatus> {
        let outcome = self.equilibrium(task);
        self.accept_or_settle_anew(task, outcome)
    }

    /// Takes an equilibrium from where the session stood; if it is not stable, one from the rigid configuration.
    pub(super) fn accept_or_settle_anew(
        &mut self,
        task: &TaskPoint,
        outcome: Outcome,
    ) -> Result<Outcome, CompensationStatus> {
        let outcome = Self::stable(outcome).or_else(|status| {
            let rigid = State::rigid(&self.nominal, &self.command);
            if self.state == rigid {
                return Err(status);
            }
            self.state = rigid;
            self.settle_from_present_state(task)
        });
        match self.is_at_singular_place(&outcome) {
            true => Err(CompensationStatus::NoEquilibrium(statics::Status::SingularPlace)),
            false => outcome,
        }
    }

    /// Whether the nominal machine is singular at the present command. Where loads or errors alone hold the real one there, on
    /// which side of the singularity it stands is chance.
    fn is_at_singular_place(&mut self, outcome: &Result<Outcome, CompensationStatus>) -> bool {
        let is_plain = outcome.as_ref().is_ok_and(|outcome| !outcome.is_soft(&self.nominal));
        if is_plain || self.command.drives != self.drives {
            return false;
        }
        let workspace = self.unloaded_workspace.get_or_insert_with(|| Workspace::new(&self.unloaded));
        statics::is_singular_place(&self.nominal, &self.command, workspace)
    }

    /// Loaded equilibrium at the present drives, near the present state.
    pub(super) fn settle_from_present_state(&mut self, task: &TaskPoint) -> Result<Outcome, CompensationStatus> {
        Self::stable(self.equilibrium(task))
    }

    fn stable(outcome: Outcome) -> Result<Outcome, CompensationStatus> {
        match outcome.status {
            statics::Status::Solved => Ok(outcome),
            status => Err(CompensationStatus::NoEquilibrium(status)),
        }
    }

    fn equilibrium(&mut self, task: &TaskPoint) -> Outcome {
        let settings = &self.settings.equilibrium;
        equilibrium(&self.real, &self.drives, &task.load, &mut self.state, &mut self.workspace, settings)
    }

    /// Task error at the present equilibrium.
    pub(super) fn task_error(&self, task: &TaskPoint) -> TaskError {
        task.task_error(&self.nominal, &self.state.pose)
    }

    /// Commands the target shifted by `shift`, lets the machine settle, and says how far it is from what is wanted.
    pub(super) fn answer(
        &mut self,
        task: &TaskPoint,
        shift: &Vector6<f64>,
    ) -> Result<(TaskError, Outcome), CompensationStatus> {
        let found = self.go_to(&task.shifted(&self.nominal, shift)).map(|()| self.equilibrium(task));
        self.answered(task, shift, found)
    }

    /// As [`Session::answer`], where a platform that turns with its position is tracked so that it is the compensated point which is
    /// shifted, and not P.
    pub(super) fn answer_led(
        &mut self,
        task: &TaskPoint,
        shift: &Vector6<f64>,
    ) -> Result<(TaskError, Outcome), CompensationStatus> {
        if !self.nominal.turns_with_position {
            return self.answer(task, shift);
        }
        let target = task.shifted(&self.nominal, shift);
        let led = self.nominal.lead(task.offset(&self.nominal), &target, &self.command);
        let found = led.map_err(CompensationStatus::Unreachable).map(|at| {
            self.drives.clone_from(&at.drives);
            self.command = at;
            self.equilibrium(task)
        });
        self.answered(task, shift, found)
    }

    /// How far the machine is from what is wanted with its target shifted by `shift`, from the equilibrium there, or why it cannot go
    /// there.
    pub(super) fn answered(
        &mut self,
        task: &TaskPoint,
        shift: &Vector6<f64>,
        found: Result<Outcome, CompensationStatus>,
    ) -> Result<(TaskError, Outcome), CompensationStatus> {
        let is_far = shift.norm() > self.nominal.characteristic_length;
        let outcome = found.map_err(|status| if is_far { CompensationStatus::Diverged } else { status })?;
        let outcome = self.accept_or_settle_anew(task, outcome)?;
        Ok((self.task_error(task), outcome))
    }

    /// Goes to the nominal command, the machine undeflected.
    pub(super) fn begin_again(&mut self, task: &TaskPoint) -> Result<(), CompensationStatus> {
        self.go_to(&task.pose)?;
        self.state = State::rigid(&self.nominal, &self.command);
        Ok(())
    }

    /// The result where `task` is not even asked of the machine: it cannot be met.
    pub fn refuse(&self, task: &TaskPoint, reason: CompensationStatus) -> Compensation {
        self.conclude(task, Err(reason), Vec::new())
    }

    /// The result at the present command and equilibrium.
    pub(super) fn conclude(&self, task: &TaskPoint, ending: Ending, history: Vec<f64>) -> Compensation {
        let offset = task.offset(&self.nominal);
        let (status, outcome) = match ending {
            Ok((status, outcome)) => (status, Some(outcome)),
            Err(status) => (status, None),
        };
        let shown = |v: Vector3<f64>| if outcome.is_some() { v } else { Vector3::zeros() };
        Compensation {
            drives: self.drives.clone(),
            history,
            tool_displacement: shown(self.nominal.tool_displacement(task.wanted(), &self.state.pose)),
            position_error: shown(self.state.pose.transform(offset) - task.wanted().transform(offset)),
            residual_rotation: shown(rotation_log(&product(
                &self.state.pose.rotation,
                &task.wanted().rotation.transpose(),
            ))),
            drive_forces: statics::drive_forces(&self.real, &self.state),
            status,
            outcome,
        }
    }
}

/// Follows the errors of an iteration and says when it is over.
#[derive(Debug, Clone)]
pub(super) struct Progress {
    /// Errors so far, mm.
    pub history: Vec<f64>,
    growths: usize,
}

/// An error this many times the first one is divergence.
const BLOW_UP: f64 = 100.0;
/// So many growths in a row are divergence.
const GROWTHS: usize = 4;

impl Progress {
    pub fn new() -> Self {
        Self { history: Vec::new(), growths: 0 }
    }

    /// Takes note of the error after a correction; the status if the iteration is over.
    fn note(&mut self, error: f64, tolerance_mm: f64, max_iterations: usize) -> Option<CompensationStatus> {
        let grown = self.history.last().is_some_and(|last| error > *last);
        self.growths = if grown { self.growths + 1 } else { 0 };
        self.history.push(error);
        if error <= tolerance_mm {
            return Some(CompensationStatus::Converged);
        }
        let first = self.history[0];
        if !error.is_finite() || error > BLOW_UP * first || self.growths >= GROWTHS {
            return Some(CompensationStatus::Diverged);
        }
        if self.history.len() > max_iterations { Some(CompensationStatus::Slow) } else { None }
    }
}
