//! A toolpath on a machine: what happens without compensation, what each method commands and leaves, what a written
//! program does.

use std::{convert::Infallible, ops::Range};

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::{
    compensation::{CompensationStatus, Demand, Method, Session, compensate, simulate, simulate_drives},
    input::error::Result,
    machine::Machine,
    spatial::Pose,
    study::{led_along::LedAlong, settings},
    work::{Event, Work},
};

/// Points that are solved one after another, each from the one before. Blocks are solved in parallel; the division does
/// not depend on the number of threads, so neither do the results.
pub(super) const BLOCK: usize = 256;

/// A path to be cut: what is wanted at each point, on which machine.
#[derive(Debug, Clone, Copy)]
pub struct PathCase<'a> {
    /// The machine by which commands are computed.
    pub nominal: &'a Machine,
    /// The machine that answers.
    pub real: &'a Machine,
    /// From whose rest deflections are measured, if the nominal machine is zeroed there.
    pub resting: &'a Machine,
    /// What is wanted at the points before, in path order; where the machine stands there decides in which posture it begins. Empty
    /// at the beginning of the path.
    pub before: &'a [Demand],
    /// What is wanted at each point, in path order.
    pub demands: &'a [Demand],
}

/// One point of a path, as commanded by a method or a program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathAnswer {
    /// How the compensation ended.
    pub status: CompensationStatus,
    /// Whether the machine settles at the command; without, errors and forces mean nothing.
    pub is_settled: bool,
    /// Corrections made.
    pub corrections: usize,
    /// Drive positions commanded, mm or rad.
    pub drives: Vec<f64>,
    /// Drives of the nominal inverse kinematics of the wanted pose, mm or rad; empty where it cannot be reached.
    pub nominal_drives: Vec<f64>,
    /// Pose of P that is commanded: the modified target; `None` where there is none.
    pub target: Option<Pose>,
    /// Position error of the point put right at the end, O axes, mm.
    pub position_error: Vector3<f64>,
    /// Rotation of the platform from the wanted orientation at the end, rotation vector in O axes, rad.
    pub leftover_rotation: Vector3<f64>,
    /// Forces of the drives at the end, N or N·mm.
    pub drive_forces: Vec<f64>,
}

impl PathAnswer {
    /// Δρ: commanded less nominal drive positions, mm or rad.
    pub fn delta_rho(&self) -> Vec<f64> {
        self.drives.iter().zip(&self.nominal_drives).map(|(rho, nominal)| rho - nominal).collect()
    }

    /// The position error, where the machine settles.
    pub fn settled_error(&self) -> Option<Vector3<f64>> {
        self.is_settled.then_some(self.position_error)
    }
}

/// What a command leaves at one point: all that is kept where only sums are wanted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Left {
    /// Why the command does not do what was asked of the method, if it does not.
    failure: Option<Box<str>>,
    /// Whether the machine settles.
    is_settled: bool,
    corrections: usize,
    /// Square of the distance of the point put right from where it is wanted, mm².
    squared_error: f64,
    /// rad.
    leftover_rotation: f64,
}

impl Left {
    /// What `answer` of `machine` leaves.
    pub fn of(answer: &PathAnswer, machine: &Machine) -> Self {
        Self {
            failure: (!answer.status.is_success()).then(|| answer.status.reason(machine).into()),
            is_settled: answer.is_settled,
            corrections: answer.corrections,
            squared_error: answer.position_error.norm_squared(),
            leftover_rotation: answer.leftover_rotation.norm(),
        }
    }
}

/// Errors along a path. What is taken over solved points is `None` where there are none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathSummary {
    /// Points with a command and an equilibrium.
    pub solved: usize,
    /// All points.
    pub points: usize,
    /// Points whose command failed, or is not as good as asked.
    pub failed: usize,
    /// Why the first of them failed.
    pub first_failure: Option<Box<str>>,
    /// Largest distance of the point put right from where it is wanted, over the solved points, mm.
    pub max_mm: Option<f64>,
    /// Root mean square of that distance, mm.
    pub rms_mm: Option<f64>,
    /// Corrections per point, mean.
    pub mean_corrections: Option<f64>,
    /// Largest rotation left over, rad.
    pub max_leftover_rotation: Option<f64>,
}

/// Sums from which a [`PathSummary`] is made, point after point in the order of the path.
#[derive(Debug, Clone, Default)]
pub struct PathSums {
    solved: usize,
    points: usize,
    failed: usize,
    first_failure: Option<Box<str>>,
    squared_errors: f64,
    largest_squared_error: f64,
    corrections: usize,
    max_leftover_rotation: f64,
}

impl PathSums {
    /// Adds a point.
    pub fn add(&mut self, left: &Left) {
        self.points += 1;
        self.failed += usize::from(left.failure.is_some());
        if self.first_failure.is_none() {
            self.first_failure.clone_from(&left.failure);
        }
        if left.is_settled {
            self.solved += 1;
            self.squared_errors += left.squared_error;
            self.largest_squared_error = self.largest_squared_error.max(left.squared_error);
            self.corrections += left.corrections;
            self.max_leftover_rotation = self.max_leftover_rotation.max(left.leftover_rotation);
        }
    }

    /// What they come to.
    pub fn summary(&self) -> PathSummary {
        let known = |value: f64| (self.solved > 0).then_some(value);
        let mean = |sum: f64| sum / self.solved as f64;
        PathSummary {
            solved: self.solved,
            points: self.points,
            failed: self.failed,
            first_failure: self.first_failure.clone(),
            max_mm: known(self.largest_squared_error.sqrt()),
            rms_mm: known(mean(self.squared_errors).sqrt()),
            mean_corrections: known(mean(self.corrections as f64)),
            max_leftover_rotation: known(self.max_leftover_rotation),
        }
    }
}

/// How each point of a path gets its command.
#[derive(Debug, Clone, Copy)]
pub enum Commands<'a> {
    /// By a compensation method.
    Method(Method),
    /// From a program: the pose of P commanded at each point.
    Program(&'a [Pose]),
    /// Drive positions at each point, mm or rad.
    Drives(&'a [Vec<f64>]),
}

/// Points computed together, whose results are then given away: as many blocks as keep the threads busy.
pub(super) const PART: usize = 16 * BLOCK;

/// The path of `length` points in parts of [`PART`].
pub(super) fn parts(length: usize) -> impl Iterator<Item = Range<usize>> {
    (0..length).step_by(PART).map(move |start| start..length.min(start + PART))
}

/// Commands every point of the path and lets the machine settle, and gives the answers to `take` in the order of the
/// path, part by part. `done` is called after each point.
///
/// # Errors
/// Of `take`.
pub fn run_in_parts<E>(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    done: &(dyn Fn() + Sync),
    mut take: impl FnMut(Vec<PathAnswer>) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    let done = || {
        done();
        Ok::<(), Infallible>(())
    };
    for part in parts(case.demands.len()) {
        let blocks = part.into_par_iter().step_by(BLOCK);
        let blocks = blocks.map(|start| block(case, commands, start, &done).unwrap_or_else(|never| match never {}));
        take(blocks.flatten_iter().collect())?;
    }
    Ok(())
}

/// As [`run_in_parts`], all answers at once.
pub fn run(case: &PathCase<'_>, commands: &Commands<'_>, done: &(dyn Fn() + Sync)) -> Vec<PathAnswer> {
    let mut answers = Vec::with_capacity(case.demands.len());
    let taken = run_in_parts(case, commands, done, |part| {
        answers.extend(part);
        Ok::<(), Infallible>(())
    });
    taken.unwrap_or_else(|never| match never {});
    answers
}

/// Pieces of `work` along the part of the path that begins at `first`: what `keep` takes of the answers of a method.
///
/// # Errors
/// Of `work`.
pub(super) fn kept<T: Serialize + DeserializeOwned + Send>(
    case: &PathCase<'_>,
    first: usize,
    method: Method,
    work: &Work,
    keep: impl Fn(PathAnswer) -> T + Sync,
) -> Result<Vec<T>> {
    let blocks = (0..case.demands.len()).into_par_iter().step_by(BLOCK).map(|start| {
        let compute = || {
            let done = || {
                work.tell(Event::Computed(1));
                work.check()
            };
            let answers = block(case, &Commands::Method(method), start, &done)?;
            let unsolved = answers.iter().filter(|answer| !answer.is_settled).count();
            if unsolved > 0 {
                work.tell(Event::Unsolved(unsolved));
            }
            Ok(answers.into_iter().map(&keep).collect())
        };
        work.piece(&(first + start), Vec::len, compute)
    });
    Ok(blocks.collect::<Result<Vec<Vec<T>>>>()?.into_iter().flatten().collect())
}

/// The points from `start` on that are solved one after another. `done` is called after each and may end the block.
fn block<E>(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    start: usize,
    done: &(dyn Fn() -> std::result::Result<(), E> + Sync),
) -> std::result::Result<Vec<PathAnswer>, E> {
    let mut session = Session::new(case.nominal, case.real, settings()).from_rest_of(case.resting);
    // What decides the posture in which the block begins.
    let passed = match start {
        0 => &case.before[case.before.len().saturating_sub(BLOCK)..],
        start => &case.demands[start - BLOCK..start],
    };
    let mut led = LedAlong::after(case.nominal, passed);
    let answer = |(i, demand): (usize, &Demand)| {
        let (nominal, asked) = led.step(demand);
        let found = match (asked, commands) {
            (Err(reason), _) => session.refuse(demand, reason),
            (Ok(()), Commands::Method(method)) => compensate(&mut session, demand, *method),
            (Ok(()), Commands::Program(poses)) => {
                let simulated = simulate(&mut session, demand, &poses[i]);
                // The controller leads the same point of the platform.
                match case.nominal.check_led(&poses[i], session.command()) {
                    Err(unreachable) if simulated.outcome.is_some() => {
                        session.refuse(demand, CompensationStatus::Unreachable(unreachable))
                    }
                    _ => simulated,
                }
            }
            (Ok(()), Commands::Drives(drives)) => simulate_drives(&mut session, demand, &drives[i]),
        };
        let nominal_drives = nominal.map(|at| at.drives).unwrap_or_default();
        done()?;
        Ok(PathAnswer {
            is_settled: found.outcome.is_some(),
            corrections: found.iterations(),
            target: found.outcome.as_ref().and_then(|_| session.target().ok()),
            status: found.status,
            drives: found.drives,
            nominal_drives,
            position_error: found.position_error,
            leftover_rotation: found.leftover_rotation,
            drive_forces: found.drive_forces,
        })
    };
    case.demands.iter().enumerate().skip(start).take(BLOCK).map(answer).collect()
}
