//! An online study: correction in the controller by measured forces, compared with offline correction by predicted forces; Figure 1a of
//! the paper against its Figure 1b.
//!
//! Both compute their commands by the same model, which may be too soft and may know only part of the chain errors. The force in
//! the cut is the predicted one times `1 + p z`, with p the force error and z normal over seeds. Off-line, the commands are those for the
//! predicted force. On-line, they are those for what the [`Sensor`] reads; torques about the tool tip are taken as known. Both keep
//! the limits of the process on corrections. The force is the same whatever the correction does; whether it is allowed to say so
//! tells the [`LoopGain`].

mod loop_gain;
#[cfg(feature = "report")]
mod report;
mod resolve;
mod seeds;
mod sensor;
mod spec;

pub use loop_gain::LoopGain;
pub use seeds::{Band, BreakEven};
pub use sensor::Sensor;

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{
    compensation::{Method, Session, TaskPoint, compensate},
    input::error::{Error, Result},
    machine::ChainError,
    process::file::CorrectionLimits,
    questions::path::PathStudy,
    simulation::{
        Machines, Source,
        along_path::{Commands, Left, PathAnswer, PathCase, PathSummary, PathSums, run as along_path},
        settings,
    },
    spatial::Wrench,
    statics::tool_compliance,
    work::{Event, Work, this_shard},
};

/// A checked online study.
#[derive(Debug, Clone)]
pub struct OnlineStudy {
    /// The path with its predicted forces, the machine and its chain errors.
    pub path: PathStudy,
    /// When the tool is at each point of it, s.
    pub times_s: Vec<f64>,
    /// Feed, mm/min.
    pub feed_mm_per_min: f64,
    /// What the controller knows of the force.
    pub sensor: Sensor,
    /// δ: by how much the model bends too much.
    pub too_soft: f64,
    /// Chain errors that the model knows.
    pub known_errors: Vec<ChainError>,
    /// Their share of the real ones.
    pub known_share: f64,
    /// p: standard deviations of the relative error of the predicted force, ascending.
    pub force_errors: Vec<f64>,
    /// Seeds.
    pub seeds: usize,
    /// Limits of corrections.
    pub limits: CorrectionLimits,
    /// Cutting stiffness, N/mm, if it is given.
    pub cutting_stiffness: Option<f64>,
}

/// How far the tool stays from its path, over the points at which it cuts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// mm; `None` where no point is solved.
    pub max_mm: Option<f64>,
    /// Root mean square, mm.
    pub rms_mm: Option<f64>,
    /// Points with a command and an equilibrium.
    pub solved: usize,
    /// All points at which the tool cuts.
    pub points: usize,
}

/// One seed at one force error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// p.
    pub force_error: f64,
    /// From 0.
    pub seed: usize,
    /// The force in the cut over the predicted one.
    pub force_factor: f64,
    /// By the predicted force.
    pub offline: Residual,
    /// By the measured force.
    pub online: Residual,
}

/// Results of an online study.
#[derive(Debug, Clone, Serialize)]
pub struct OnlineResults {
    /// Without correction, under the predicted force.
    pub plain: Residual,
    /// By force error, then seed.
    pub trials: Vec<Trial>,
    /// How the loop through the cutting force stands; `None` where the machine is rigid or has no equilibrium.
    pub loop_gain: Option<LoopGain>,
}

/// Runs the study on the current rayon pool.
///
/// # Errors
/// Of `work`; a machine that does not rest under its weight.
pub fn run(study: &OnlineStudy, work: &Work) -> Result<OnlineResults> {
    let machines = Machines::new(&study.path.machine, &study.path.errors)?;
    let model = Machines::new(&study.path.machine, &study.known_errors)?;
    let cut = Cut { study, machines: &machines, model: &model };
    let plain = || {
        let answers = cut.answers(&machines, &study.path.tasks, &Commands::Method(Method::None));
        work.tell(Event::Computed(1));
        Ok(cut.residual(&answers))
    };
    let plain = this_shard(work.shard(0).piece(&"plain", |_| 1, plain))?;
    let offline = cut.commands(&study.path.tasks);
    let trials: Vec<(f64, usize)> =
        study.force_errors.iter().flat_map(|error| (0..study.seeds).map(|seed| (*error, seed))).collect();
    let trial = |(number, &(force_error, seed)): (usize, &(f64, usize))| {
        let work = work.part("trials").after(1).shard(number);
        let compute = || {
            let trial = cut.trial(force_error, seed, &offline);
            work.tell(Event::Computed(1));
            Ok(trial)
        };
        this_shard(work.piece(&(force_error.to_bits(), seed), |_| 1, compute)).transpose()
    };
    let trials = trials.par_iter().enumerate().filter_map(trial).collect::<Result<Vec<Trial>>>()?;
    work.barrier()?;
    let plain = plain.ok_or(Error::OtherShard)?;
    Ok(OnlineResults { plain, trials, loop_gain: cut.loop_gain() })
}

/// The machine in the cut and the model in the controller.
struct Cut<'a> {
    study: &'a OnlineStudy,
    machines: &'a Machines,
    model: &'a Machines,
}

impl Cut<'_> {
    fn trial(&self, force_error: f64, seed: usize, offline: &[Vec<f64>]) -> Trial {
        let study = self.study;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed as u64);
        let chance: f64 = StandardNormal.sample(&mut random);
        // A force that changes its sign is no error of prediction.
        let force_factor = (1.0 + force_error * chance).max(0.0);
        let tasks: Vec<TaskPoint> = study.path.tasks.iter().map(|task| times(task, force_factor)).collect();
        let forces: Vec<Vector3<f64>> = tasks.iter().map(|task| task.load.force).collect();
        let measured = study.sensor.measured(&study.times_s, &forces, &mut random);
        let read: Vec<TaskPoint> = tasks.iter().zip(measured).map(|(task, force)| self.read(task, force)).collect();
        let residual =
            |drives: &[Vec<f64>]| self.residual(&self.answers(self.machines, &tasks, &Commands::Drives(drives)));
        Trial { force_error, seed, force_factor, offline: residual(offline), online: residual(&self.commands(&read)) }
    }

    /// `task` with the force that was measured, and the moment of that at P.
    fn read(&self, task: &TaskPoint, force: Vector3<f64>) -> TaskPoint {
        let lever = task.pose.rotation * self.study.path.machine.tool_tip;
        let Wrench { force: real, moment } = task.load;
        TaskPoint { load: Wrench { force, moment: moment + lever.cross(&(force - real)) }, ..*task }
    }

    /// Drives that the model commands for `tasks`, within the limits; those of the rigid machine where it finds none.
    fn commands(&self, tasks: &[TaskPoint]) -> Vec<Vec<f64>> {
        let softened: Vec<TaskPoint> = tasks.iter().map(|task| times(task, 1.0 + self.study.too_soft)).collect();
        let answers = self.answers(self.model, &softened, &Commands::Method(Method::Direct));
        let limits = &self.study.limits;
        let mut before: Option<Vec<f64>> = None;
        let command = |answer: &PathAnswer| {
            if answer.nominal_drives.is_empty() {
                before = None;
                return self.study.path.machine.home.drives.clone();
            }
            let wanted = match answer.status.is_success() {
                true => answer.delta_rho(),
                false => vec![0.0; answer.nominal_drives.len()],
            };
            let correction = limited(&wanted, before.as_deref(), limits);
            let drives = answer.nominal_drives.iter().zip(&correction).map(|(rho, own)| rho + own).collect();
            before = Some(correction);
            drives
        };
        answers.iter().map(command).collect()
    }

    fn answers(&self, machines: &Machines, tasks: &[TaskPoint], commands: &Commands<'_>) -> Vec<PathAnswer> {
        along_path(&PathCase::new(machines, Source::All, tasks), commands, &|| ())
    }

    fn residual(&self, answers: &[PathAnswer]) -> Residual {
        let stations = &self.study.path.stations;
        let cuts_nowhere = !stations.iter().any(|station| station.cutting);
        let counted = answers.iter().zip(stations).filter(|(_, station)| station.cutting || cuts_nowhere);
        let mut sums = PathSums::default();
        counted.for_each(|(answer, _)| sums.add(&Left::of(answer, &self.study.path.machine)));
        let PathSummary { max_mm, rms_mm, solved, points, .. } = sums.summary();
        Residual { max_mm, rms_mm, solved, points }
    }

    /// From the largest compliance of the tool in the cut.
    fn loop_gain(&self) -> Option<LoopGain> {
        let machines = self.machines;
        let mut session = Session::new(machines.nominal(Source::All), machines.actual(Source::All), settings())
            .from_rest_of(machines.unloaded());
        let compliance = |task: &TaskPoint| {
            let outcome = compensate(&mut session, task, Method::Direct).outcome?;
            let offset = task.pose.rotation * task.offset(&self.study.path.machine);
            let of_tool = tool_compliance(&outcome.compliance?, offset);
            Some(((of_tool + of_tool.transpose()) * 0.5).symmetric_eigenvalues().max())
        };
        let largest = self.study.path.tasks.iter().filter_map(compliance).fold(0.0, f64::max);
        (largest > 0.0).then(|| LoopGain::new(largest, self.study.too_soft, self.study.cutting_stiffness))
    }
}

/// `task` under `factor` times its load.
fn times(task: &TaskPoint, factor: f64) -> TaskPoint {
    let Wrench { force, moment } = task.load;
    TaskPoint { load: Wrench { force: force * factor, moment: moment * factor }, ..*task }
}

/// The correction nearest to `wanted`, drive by drive, that keeps the limits after the one `before`.
fn limited(wanted: &[f64], before: Option<&[f64]>, limits: &CorrectionLimits) -> Vec<f64> {
    let most = limits.correction_mm.unwrap_or(f64::INFINITY);
    let change = limits.correction_change_mm.unwrap_or(f64::INFINITY);
    let own = |(drive, wanted): (usize, &f64)| {
        let sized = wanted.clamp(-most, most);
        before.map_or(sized, |before| sized.clamp(before[drive] - change, before[drive] + change))
    };
    wanted.iter().enumerate().map(own).collect()
}
