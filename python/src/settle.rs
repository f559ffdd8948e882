//! Many independent cases: commanded with or without compensation, settled under their loads, several at a time on each processor.
//! Each case begins at its own rigid configuration, so no result depends on other cases or on the number of threads.

use std::{
    borrow::Cow,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
};

use kinetostat::{
    Compensation, Error, Machine, Method, Result, Session, Source, Target, TaskPoint,
    compensation::{CompensationStatus, compensate_batch},
    machine::BatchKinematics,
    simulation::Machines,
    statics::Batch,
};
use rayon::prelude::*;

use crate::poses::{Asked, Commands, commands_in_lanes, write_pose};

/// Words of statuses by their numbers.
pub const STATUSES: [&str; 15] = [
    "solved",
    "converged",
    "applied",
    "slow",
    "diverged",
    "bad_step_length",
    "unreachable",
    "changes_posture",
    "unstable",
    "buckled",
    "singular",
    "not_converged",
    "snap_through",
    "uncontrollable",
    "rigid",
];

/// How cases are commanded, and what is wanted of them.
#[derive(Debug, Clone, Copy)]
pub struct Commanded {
    /// How commands are found.
    pub method: Method,
    /// What is compensated.
    pub target: Target,
    /// Whether stiffnesses are wanted.
    pub stiffness: bool,
    /// Whether the poses are wanted that command the drives.
    pub command: bool,
    /// Whether wrenches act at the tool tip, where the nominal machine has it, and not at P.
    pub at_tip: bool,
}

impl Commanded {
    /// Without compensation.
    pub fn uncompensated(stiffness: bool, at_tip: bool) -> Self {
        Self { method: Method::None, target: Target::ToolTip, stiffness, command: false, at_tip }
    }
}

/// What came of cases: a row each, NaN where there is no answer.
#[derive(Debug)]
pub struct Settled {
    /// Drive positions commanded, mm or rad.
    pub drives: Vec<f64>,
    /// Drive positions of the nominal inverse kinematics, mm or rad; NaN where it has none.
    pub nominal_drives: Vec<f64>,
    /// Forces of the drives, N or N·mm.
    pub drive_forces: Vec<f64>,
    /// Pose of P in equilibrium, homogeneous.
    pub pose: Vec<f64>,
    /// Pose of P that commands the drives, homogeneous; empty unless wanted.
    pub command: Vec<f64>,
    /// From where the tool tip is wanted to where it is, O, mm.
    pub deflection: Vec<f64>,
    /// The same of the compensated point.
    pub error: Vec<f64>,
    /// Rotation vector from the wanted orientation, O, rad.
    pub rotation: Vec<f64>,
    /// Stiffness of P under the load, rows of 6; empty unless wanted.
    pub stiffness: Vec<f64>,
    /// Its inverse, likewise.
    pub compliance: Vec<f64>,
    /// Corrections made.
    pub corrections: Vec<u32>,
    /// Numbers of [`STATUSES`].
    pub status: Vec<u8>,
    /// Cases without an answer, and why, in order.
    pub reasons: Vec<(usize, String)>,
}

/// A row of [`Settled`].
struct Row<'a> {
    drives: &'a mut [f64],
    nominal_drives: &'a mut [f64],
    drive_forces: &'a mut [f64],
    pose: &'a mut [f64],
    command: Option<&'a mut [f64]>,
    deflection: &'a mut [f64],
    error: &'a mut [f64],
    rotation: &'a mut [f64],
    stiffness: Option<[&'a mut [f64]; 2]>,
    corrections: &'a mut u32,
    status: &'a mut u8,
}

impl Settled {
    fn new(cases: usize, drives: usize, commanded: &Commanded) -> Self {
        let column = |width: usize| vec![f64::NAN; cases * width];
        let stiffness = if commanded.stiffness { 36 } else { 0 };
        Self {
            drives: column(drives),
            nominal_drives: column(drives),
            drive_forces: column(drives),
            pose: column(16),
            command: column(if commanded.command { 16 } else { 0 }),
            deflection: column(3),
            error: column(3),
            rotation: column(3),
            stiffness: column(stiffness),
            compliance: column(stiffness),
            corrections: vec![0; cases],
            status: vec![0; cases],
            reasons: Vec::new(),
        }
    }

    /// Its rows, one after another.
    fn rows(&mut self, drives: usize) -> impl Iterator<Item = Row<'_>> + Send {
        let (mut command, mut stiffness) = (self.command.chunks_mut(16), self.stiffness.chunks_mut(36));
        let mut compliance = self.compliance.chunks_mut(36);
        let mut of_drives = [&mut self.drives, &mut self.nominal_drives, &mut self.drive_forces]
            .map(|column| column.chunks_mut(drives.max(1)));
        let mut of_poses = self.pose.chunks_mut(16);
        let mut of_vectors =
            [&mut self.deflection, &mut self.error, &mut self.rotation].map(|column| column.chunks_mut(3));
        let (mut corrections, mut status) = (self.corrections.iter_mut(), self.status.iter_mut());
        std::iter::from_fn(move || {
            let [own, nominal_drives, drive_forces] = &mut of_drives;
            let [deflection, error, rotation] = &mut of_vectors;
            Some(Row {
                drives: own.next()?,
                nominal_drives: nominal_drives.next()?,
                drive_forces: drive_forces.next()?,
                pose: of_poses.next()?,
                command: command.next(),
                deflection: deflection.next()?,
                error: error.next()?,
                rotation: rotation.next()?,
                stiffness: stiffness
                    .next()
                    .zip(compliance.next())
                    .map(|(stiffness, compliance)| [stiffness, compliance]),
                corrections: corrections.next()?,
                status: status.next()?,
            })
        })
    }
}

/// Commands the nominal machine of `machines` to all cases, or to `given` configurations, and lets the actual one settle, on the threads of
/// the present pool.
///
/// # Errors
/// [`Error::Stopped`] once `stop` is set.
pub fn settle(
    machines: &Machines,
    asked: &Asked,
    given: Option<Commands>,
    commanded: Commanded,
    stop: &AtomicBool,
) -> Result<Settled> {
    let machine = &machines.nominal;
    let drives = machine.drive_count();
    let mut settled = Settled::new(asked.len(), drives, &commanded);
    let reasons = Mutex::new(Vec::new());
    let commands = given.or_else(|| asked.commands(machine));
    let mut rows = settled.rows(drives);
    let groups = std::iter::from_fn(|| {
        Some(rows.by_ref().take(Batch::WIDTH).collect::<Vec<_>>()).filter(|group| !group.is_empty())
    });
    let (mut groups, width) = (groups.enumerate(), asked.len().min(Batch::WIDTH));
    let begin = || Group::new(machines, commanded, width);
    let settle = |group: &mut Group<'_>, (number, rows): (usize, Vec<Row<'_>>)| {
        if stop.load(Ordering::Relaxed) {
            return Err(Error::Stopped);
        }
        let found = group.settle(asked, number * Batch::WIDTH, rows, commands.as_ref());
        if !found.is_empty() {
            reasons.lock().unwrap_or_else(PoisonError::into_inner).extend(found);
        }
        Ok(())
    };
    match asked.len() > Batch::WIDTH {
        true => groups.par_bridge().try_for_each_init(begin, settle)?,
        // A single group is not worth waking other threads.
        false => groups.try_for_each(|rows| settle(&mut begin(), rows))?,
    }
    drop(rows);
    settled.reasons = reasons.into_inner().unwrap_or_else(PoisonError::into_inner);
    settled.reasons.sort_unstable_by_key(|(case, _)| *case);
    Ok(settled)
}

/// One machine at several places.
struct Group<'a> {
    machine: &'a Machine,
    commanded: Commanded,
    /// Kept once places are commanded here.
    kinematics: Option<BatchKinematics>,
    sessions: Vec<Session>,
    batch: Batch,
}

impl<'a> Group<'a> {
    /// For at most `width` cases at a time.
    fn new(machines: &'a Machines, commanded: Commanded, width: usize) -> Self {
        let sessions = vec![machines.session(Source::All); width];
        let batch = Batch::new(machines.actual(Source::All));
        Self { machine: &machines.nominal, commanded, kinematics: None, sessions, batch }
    }

    /// Answers to cases that follow one another, of which the first at `first`; `commands` are where the machine stands, if that was
    /// computed before. Those without an answer, and why.
    fn settle(
        &mut self,
        asked: &Asked,
        first: usize,
        rows: Vec<Row<'_>>,
        commands: Option<&Commands>,
    ) -> Vec<(usize, String)> {
        let mut reasons = Vec::new();
        let mut reached = Vec::with_capacity(rows.len());
        let cases = first..first + rows.len();
        let own: Vec<_> = match commands {
            Some(found) => cases.map(|case| found.of(case).as_ref().map(Cow::Borrowed).map_err(Clone::clone)).collect(),
            None => {
                let places: Vec<_> = cases.map(|case| asked.place(case)).collect();
                let kinematics = self.kinematics.get_or_insert_with(|| BatchKinematics::new(self.machine));
                let found = commands_in_lanes(self.machine, kinematics, &places);
                found.into_iter().map(|at| at.map(Cow::Owned)).collect()
            }
        };
        for ((case, row), own) in (first..).zip(rows).zip(own) {
            match own {
                Ok(at) => {
                    row.nominal_drives.copy_from_slice(&at.drives);
                    reached.push((case, row, at));
                }
                Err(unreachable) => {
                    let status = CompensationStatus::Unreachable(unreachable);
                    *row.status = number_of(&status, self.commanded.method);
                    reasons.push((case, status.reason(self.machine)));
                }
            }
        }
        let mut tasks = Vec::with_capacity(reached.len());
        for (session, (case, _, at)) in self.sessions.iter_mut().zip(&reached) {
            session.set_rigid(at);
            let (pose, mut load, target) = (at.pose, asked.load(*case), self.commanded.target);
            if self.commanded.at_tip {
                load.moment += (pose.rotation * self.machine.tool_tip).cross(&load.force);
            }
            tasks.push(TaskPoint::new(pose, load, target));
        }
        let mut sessions: Vec<&mut Session> = self.sessions.iter_mut().take(reached.len()).collect();
        let answers = compensate_batch(&mut sessions, &tasks, self.commanded.method, &mut self.batch);
        for ((session, answer), (case, mut row, _)) in sessions.into_iter().zip(answers).zip(reached) {
            *row.status = number_of(&answer.status, self.commanded.method);
            match answer.status.is_success() {
                true => row.fill(session, answer),
                false => reasons.push((case, answer.status.reason(self.machine))),
            }
        }
        reasons
    }
}

impl Row<'_> {
    fn fill(&mut self, session: &mut Session, answer: Compensation) {
        self.drives.copy_from_slice(&answer.drives);
        self.drive_forces.copy_from_slice(&answer.drive_forces);
        self.deflection.copy_from_slice(answer.tool_displacement.as_slice());
        self.error.copy_from_slice(answer.position_error.as_slice());
        self.rotation.copy_from_slice(answer.residual_rotation.as_slice());
        *self.corrections = u32::try_from(answer.iterations()).unwrap_or(u32::MAX);
        write_pose(&session.state().pose, self.pose);
        // A command whose chains do not close has no pose; its drives are what counts.
        if let Some(command) = &mut self.command
            && let Ok(pose) = session.target()
        {
            write_pose(&pose, command);
        }
        if let (Some([stiffness, compliance]), Some(outcome)) = (&mut self.stiffness, answer.outcome) {
            for (column, matrix) in [(stiffness, outcome.stiffness), (compliance, outcome.compliance)] {
                if let Some(matrix) = matrix {
                    column.copy_from_slice(matrix.transpose().as_slice());
                }
            }
        }
    }
}

/// The number of `status` among [`STATUSES`]; without a correction, success is called as of an equilibrium.
fn number_of(status: &CompensationStatus, method: Method) -> u8 {
    let label = match status {
        CompensationStatus::Applied if method == Method::None => STATUSES[0],
        other => other.label(),
    };
    let number = STATUSES.iter().position(|own| *own == label);
    u8::try_from(number.unwrap_or(STATUSES.len())).unwrap_or(u8::MAX)
}
