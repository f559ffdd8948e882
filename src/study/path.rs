//! A toolpath on a machine: what happens without compensation, what each method commands and leaves, what a written
//! program does.

use std::{convert::Infallible, time::Instant};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::work::{Event, Work};
use crate::{
    compensation::{Compensation, Demand, Method, Session, Settings, compensate, simulate, simulate_drives},
    error::Result,
    machine::Machine,
    spatial::Pose,
};

/// Points that are solved one after another, each from the one before. Blocks are solved in parallel; the division does
/// not depend on the number of threads, so neither do the results.
const BLOCK: usize = 256;

/// A path to be cut: what is wanted at each point, on which machine.
#[derive(Debug, Clone, Copy)]
pub struct PathCase<'a> {
    /// The machine by which commands are computed.
    pub nominal: &'a Machine,
    /// The machine that answers.
    pub real: &'a Machine,
    /// What is wanted at each point, in path order.
    pub demands: &'a [Demand],
}

/// One point of a path, as commanded by a method or a program.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PathAnswer {
    /// The command and what it leads to.
    pub compensation: Compensation,
    /// Drives of the nominal inverse kinematics of the wanted pose, mm or rad; empty where it cannot be reached.
    pub nominal_drives: Vec<f64>,
    /// Pose of P that is commanded: the modified target; `None` where there is none.
    pub target: Option<Pose>,
}

impl PathAnswer {
    /// Δρ: commanded less nominal drive positions, mm or rad.
    pub fn delta_rho(&self) -> Vec<f64> {
        self.compensation.drives.iter().zip(&self.nominal_drives).map(|(rho, nominal)| rho - nominal).collect()
    }
}

/// Errors along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathSummary {
    /// Points with a command and an equilibrium.
    pub solved: usize,
    /// All points.
    pub points: usize,
    /// Largest distance of the point put right from where it is wanted, over the solved points, mm.
    pub max_mm: f64,
    /// Root mean square of that distance, mm.
    pub rms_mm: f64,
    /// Corrections per point, mean.
    pub mean_corrections: f64,
    /// Largest rotation left over, rad.
    pub max_leftover_rotation: f64,
}

impl PathSummary {
    /// Sums up `answers`.
    pub fn new(answers: &[PathAnswer]) -> Self {
        let solved = || answers.iter().map(|a| &a.compensation).filter(|c| c.outcome.is_some());
        let count = solved().count();
        let per_point = |sum: f64| if count > 0 { sum / count as f64 } else { 0.0 };
        Self {
            solved: count,
            points: answers.len(),
            max_mm: solved().map(|c| c.position_error.norm()).fold(0.0, f64::max),
            rms_mm: per_point(solved().map(|c| c.position_error.norm_squared()).sum()).sqrt(),
            mean_corrections: per_point(solved().map(|c| c.iterations() as f64).sum()),
            max_leftover_rotation: solved().map(|c| c.leftover_rotation.norm()).fold(0.0, f64::max),
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

/// Settings with which paths are compensated: to 3e-12 of the machine's reach, 1e-9 mm on the Orthoglide.
pub fn settings() -> Settings {
    Settings::with_equilibria_to(1e-12)
}

/// Commands every point of the path and lets the machine settle. `done` is called after each point.
pub fn run(case: &PathCase<'_>, commands: &Commands<'_>, done: &(dyn Fn() + Sync)) -> Vec<PathAnswer> {
    let starts = (0..case.demands.len()).into_par_iter().step_by(BLOCK);
    let done = || {
        done();
        Ok::<(), Infallible>(())
    };
    let blocks = starts.map(|start| block(case, commands, start, &done).unwrap_or_else(|never| match never {}));
    blocks.flatten_iter().collect()
}

/// As [`run`] with a method, in pieces of `work`, with the time in s that threads spent on it, all together; threads
/// without work do not count.
///
/// # Errors
/// Of `work`.
pub fn timed(case: &PathCase<'_>, method: Method, work: &Work) -> Result<(Vec<PathAnswer>, f64)> {
    let blocks = (0..case.demands.len()).into_par_iter().step_by(BLOCK).map(|start| {
        let compute = || {
            let started = Instant::now();
            let done = || {
                work.tell(Event::Computed(1));
                work.check()
            };
            let answers = block(case, &Commands::Method(method), start, &done)?;
            Ok((answers, started.elapsed().as_secs_f64()))
        };
        work.piece(&start, |(answers, _)| answers.len(), compute)
    });
    let blocks = blocks.collect::<Result<Vec<(Vec<PathAnswer>, f64)>>>()?;
    let seconds = blocks.iter().map(|(_, seconds)| seconds).sum();
    Ok((blocks.into_iter().flat_map(|(answers, _)| answers).collect(), seconds))
}

/// The points from `start` on that are solved one after another. `done` is called after each and may end the block.
fn block<E>(
    case: &PathCase<'_>,
    commands: &Commands<'_>,
    start: usize,
    done: &(dyn Fn() -> std::result::Result<(), E> + Sync),
) -> std::result::Result<Vec<PathAnswer>, E> {
    let mut session = Session::new(case.nominal, case.real, settings());
    let mut near = case.nominal.home.clone();
    let answer = |(i, demand): (usize, &Demand)| {
        let nominal = case
            .nominal
            .inverse_kinematics_from(&near, &demand.pose)
            .or_else(|_| case.nominal.inverse_kinematics(&demand.pose));
        let asked = nominal.as_ref().map_or(Ok(()), |at| case.nominal.check_asked(demand.pose.translation, at));
        let compensation = match (asked, commands) {
            (Err(unreachable), _) => session.refuse(demand, unreachable),
            (Ok(()), Commands::Method(method)) => compensate(&mut session, demand, *method),
            (Ok(()), Commands::Program(poses)) => simulate(&mut session, demand, &poses[i]),
            (Ok(()), Commands::Drives(drives)) => simulate_drives(&mut session, demand, &drives[i]),
        };
        let nominal_drives = nominal.as_ref().map(|at| at.drives.clone()).unwrap_or_default();
        if let Ok(at) = nominal {
            near = at;
        }
        let target = compensation.outcome.as_ref().and_then(|_| session.target().ok());
        done()?;
        Ok(PathAnswer { compensation, nominal_drives, target })
    };
    case.demands.iter().enumerate().skip(start).take(BLOCK).map(answer).collect()
}
