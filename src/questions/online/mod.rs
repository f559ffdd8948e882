//! Online study: correction in the controller by measured forces, against offline correction by predicted forces; Figures 1a and 1b of the paper.
//!
//! Both compute their commands by the same model, which may be too soft and may know only part of the chain errors. The force in
//! the cut is the predicted one times `1 + p z`, with p the force error and z normal over seeds. Off-line, the commands are those for the
//! predicted force. On-line, they are those for what the [`Sensor`] reads; torques about the tool tip are taken as known. Both keep
//! the limits of the process on corrections. The force is assumed not to depend on the correction; the [`LoopGain`] tells whether
//! that is allowed.
//!
//! Where inputs are uncertain, each seed cuts on a machine of its own, the draw with its number, whatever the force error; the model stays as it is.

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
    process::{file::CorrectionLimits, uncertainty::ToolOnWorkpiece},
    questions::path::PathStudy,
    simulation::{
        Machines, Source, TrackedPath,
        along_path::{Commands, PathCase, PathPointResult, PathSummary, PathSums, PointResidual, run as along_path},
        settings,
        spread::DrawnMachines,
        spread_along::tools_on_workpiece,
    },
    spatial::Wrench,
    statics::tool_compliance,
    work::{Event, Work, if_this_shard},
};

/// A checked online study: a path, and how the controller measures forces and corrects.
#[derive(Debug, Clone)]
pub struct OnlineStudy {
    /// Path with predicted forces, machine and chain errors.
    pub path: PathStudy,
    /// Time at each point of the path, s.
    pub times_s: Vec<f64>,
    /// Feed, mm/min.
    pub feed_mm_per_min: f64,
    /// Force sensor and its way into the controller.
    pub sensor: Sensor,
    /// δ: relative error of the compliance of the controller's model, positive if it bends too much.
    pub softness: f64,
    /// Chain errors in the controller's model.
    pub known_errors: Vec<ChainError>,
    /// Ratio of these to the actual chain errors.
    pub known_share: f64,
    /// p: standard deviations of the relative error of the predicted force, ascending.
    pub force_errors: Vec<f64>,
    /// Number of random seeds for each force error.
    pub seeds: usize,
    /// Limits on corrections of the drives.
    pub limits: CorrectionLimits,
    /// Change of the cutting force with the depth of cut, N/mm, if given.
    pub cutting_stiffness: Option<f64>,
}

/// Residual distance of the tool from its path, over the points at which it cuts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// Largest distance, mm; `None` where no point is solved.
    pub max_mm: Option<f64>,
    /// Root mean square distance, mm; `None` where no point is solved.
    pub rms_mm: Option<f64>,
    /// Number of points with a command and an equilibrium.
    pub solved: usize,
    /// Number of points at which the tool cuts.
    pub points: usize,
}

/// Residuals of both ways to correct, for one random seed and force error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// p: standard deviation of the relative error of the predicted force.
    pub force_error: f64,
    /// Random seed, from 0.
    pub seed: usize,
    /// Ratio of the force in the cut to the predicted one.
    pub force_factor: f64,
    /// Residual with commands for the predicted force.
    pub offline: Residual,
    /// Residual with commands for the measured force.
    pub online: Residual,
}

/// Results of an online study.
#[derive(Debug, Clone, Serialize)]
pub struct OnlineResults {
    /// Residual without correction, under the predicted force.
    pub plain: Residual,
    /// All trials, by force error, then seed.
    pub trials: Vec<Trial>,
    /// Stability of the loop through the cutting force; `None` where the machine is rigid or has no equilibrium.
    pub loop_gain: Option<LoopGain>,
}

/// Runs the study on the current rayon pool. `Err` if `work` was stopped, could not be kept, or another shard computes a trial; or if the
/// machine has no equilibrium under its weight.
pub fn run(study: &OnlineStudy, work: &Work) -> Result<OnlineResults> {
    let machines = study.path.machines()?;
    let model = Machines::new(&study.path.machine, &study.known_errors)?;
    let drawn = study.path.drawn(&machines)?;
    let TrackedPath { machine, placement, .. } = &study.path.tracked;
    let on_workpiece =
        |drawn: &DrawnMachines| tools_on_workpiece(machine, placement, &drawn.uncertainty, &study.path.tasks);
    let tools = drawn.as_ref().map_or_else(Vec::new, on_workpiece);
    let cut = CutSimulation { study, machines: &machines, model: &model, drawn: drawn.as_ref(), tools };
    let uncorrected = || {
        let results = cut.simulate(&machines, &study.path.tasks, &Commands::Method(Method::None));
        work.tell(Event::Computed(1));
        Ok(cut.residual(&results))
    };
    let uncorrected = if_this_shard(work.shard(0).piece(&"plain", |_| 1, uncorrected))?;
    let offline = cut.commands(&study.path.tasks);
    let trials: Vec<(f64, usize)> =
        study.force_errors.iter().flat_map(|error| (0..study.seeds).map(|seed| (*error, seed))).collect();
    let trial = |(number, &(force_error, seed)): (usize, &(f64, usize))| {
        let work = work.part("trials").numbered_after(1).shard(number);
        let compute = || {
            let trial = cut.trial(force_error, seed, &offline);
            work.tell(Event::Computed(1));
            Ok(trial)
        };
        if_this_shard(work.piece(&(force_error.to_bits(), seed), |_| 1, compute)).transpose()
    };
    let trials = trials.par_iter().enumerate().filter_map(trial).collect::<Result<Vec<Trial>>>()?;
    work.barrier()?;
    let uncorrected = uncorrected.ok_or(Error::OtherShard)?;
    Ok(OnlineResults { plain: uncorrected, trials, loop_gain: cut.loop_gain() })
}

/// Simulates the actual machine in the cut, and the controller's model of it.
struct CutSimulation<'a> {
    study: &'a OnlineStudy,
    machines: &'a Machines,
    model: &'a Machines,
    drawn: Option<&'a DrawnMachines>,
    /// Where the tool is at each point; empty where nothing of the setup is uncertain.
    tools: Vec<ToolOnWorkpiece>,
}

impl CutSimulation<'_> {
    /// Computes one trial: draws errors of force and sensor; residuals with the `offline` drive commands and with commands for measured
    /// forces.
    fn trial(&self, force_error: f64, seed: usize, offline: &[Vec<f64>]) -> Trial {
        let study = self.study;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed as u64);
        let deviation: f64 = StandardNormal.sample(&mut random);
        // A force that changes its sign is no error of prediction.
        let force_factor = (1.0 + force_error * deviation).max(0.0);
        let tasks: Vec<TaskPoint> = study.path.tasks.iter().map(|task| scale_load(task, force_factor)).collect();
        let forces: Vec<Vector3<f64>> = tasks.iter().map(|task| task.load.force).collect();
        let measured = study.sensor.measured(&study.times_s, &forces, &mut random);
        let read: Vec<TaskPoint> = tasks.iter().zip(measured).map(|(task, force)| self.measured(task, force)).collect();
        let residual = |drives: &[Vec<f64>]| self.residual(&self.on_actual_machine(seed, &tasks, drives));
        Trial { force_error, seed, force_factor, offline: residual(offline), online: residual(&self.commands(&read)) }
    }

    /// Simulates the actual machine with these drive positions: that of the draw `seed` where inputs are uncertain, no point being settled if there is none.
    fn on_actual_machine(&self, seed: usize, tasks: &[TaskPoint], drives: &[Vec<f64>]) -> Vec<PathPointResult> {
        let on = |machines: &Machines, tasks: &[TaskPoint]| self.simulate(machines, tasks, &Commands::Drives(drives));
        let Some(drawn) = self.drawn else { return on(self.machines, tasks) };
        let actual = drawn.on_draw(seed, |machines| {
            let mut loaded = on(machines, tasks);
            let unloaded: Vec<TaskPoint> = tasks.iter().map(|task| scale_load(task, 0.0)).collect();
            let free = drawn.has_model_error().then(|| on(machines, &unloaded));
            for (k, point) in loaded.iter_mut().enumerate() {
                let free = free.as_ref().map(|free| &free[k]);
                // What the model leaves out is known where both are.
                point.is_settled &= free.is_none_or(|free| free.is_settled);
                let error = drawn.actual_displacement(seed, free.map(|free| free.position_error), point.position_error);
                let moved = |tool| drawn.uncertainty.setup_displacement(seed, tool);
                point.position_error = error + self.tools.get(k).map_or_else(Vector3::zeros, moved);
            }
            loaded
        });
        actual.unwrap_or_else(|_| {
            let mut lost = on(self.machines, tasks);
            lost.iter_mut().for_each(|point| point.is_settled = false);
            lost
        })
    }

    /// Returns `task` with the measured `force` in place of the actual one, applied at the tool tip, and the moment about P that follows.
    fn measured(&self, task: &TaskPoint, force: Vector3<f64>) -> TaskPoint {
        let lever = task.pose.rotation * self.study.path.machine.tool_tip;
        let Wrench { force: actual, moment } = task.load;
        TaskPoint { load: Wrench { force, moment: moment + lever.cross(&(force - actual)) }, ..*task }
    }

    /// Returns the drive positions that the model commands for `tasks`, corrected within the limits; rigid ones where it has no solution.
    fn commands(&self, tasks: &[TaskPoint]) -> Vec<Vec<f64>> {
        let softened: Vec<TaskPoint> = tasks.iter().map(|task| scale_load(task, 1.0 + self.study.softness)).collect();
        let results = self.simulate(self.model, &softened, &Commands::Method(Method::Direct));
        let limits = &self.study.limits;
        let mut before: Option<Vec<f64>> = None;
        let command = |result: &PathPointResult| {
            if result.nominal_drives.is_empty() {
                before = None;
                return self.study.path.machine.home.drives.clone();
            }
            let full_correction = match result.status.is_success() {
                true => result.delta_rho(),
                false => vec![0.0; result.nominal_drives.len()],
            };
            let correction = limited_correction(&full_correction, before.as_deref(), limits);
            let drives = result.nominal_drives.iter().zip(&correction).map(|(rho, delta)| rho + delta).collect();
            before = Some(correction);
            drives
        };
        results.iter().map(command).collect()
    }

    /// Simulates `machines` along the path with these tasks and commands, all sources of error acting.
    fn simulate(&self, machines: &Machines, tasks: &[TaskPoint], commands: &Commands<'_>) -> Vec<PathPointResult> {
        let case = PathCase { play: false, ..PathCase::new(machines, Source::All, tasks) };
        along_path(&case, commands, &|| ())
    }

    /// Returns the residual distance over the points at which the tool cuts; over all points where it cuts nowhere.
    fn residual(&self, results: &[PathPointResult]) -> Residual {
        let stations = &self.study.path.stations;
        let cuts_nowhere = self.study.path.cuts_nowhere();
        let counted = results.iter().zip(stations).filter(|(_, station)| station.cutting || cuts_nowhere);
        let mut sums = PathSums::default();
        counted.for_each(|(result, _)| sums.add(&PointResidual::of(result, &self.study.path.machine)));
        let PathSummary { max_mm, rms_mm, solved, points, .. } = sums.summary();
        Residual { max_mm, rms_mm, solved, points }
    }

    /// Returns the loop gain at the largest compliance of the tool along the path; `None` where the machine is rigid or has no equilibrium.
    fn loop_gain(&self) -> Option<LoopGain> {
        let machines = self.machines;
        let mut session = Session::new(machines.nominal(Source::All), machines.actual(Source::All), settings())
            .with_unloaded_machine(machines.unloaded());
        let compliance = |task: &TaskPoint| {
            let outcome = compensate(&mut session, task, Method::Direct).outcome?;
            let offset = task.pose.rotation * task.offset(&self.study.path.machine);
            let of_tool = tool_compliance(&outcome.compliance?, offset);
            Some(((of_tool + of_tool.transpose()) * 0.5).symmetric_eigenvalues().max())
        };
        let largest = self.study.path.tasks.iter().filter_map(compliance).fold(0.0, f64::max);
        (largest > 0.0).then(|| LoopGain::new(largest, self.study.softness, self.study.cutting_stiffness))
    }
}

/// Returns `task` with force and moment times `factor`.
fn scale_load(task: &TaskPoint, factor: f64) -> TaskPoint {
    let Wrench { force, moment } = task.load;
    TaskPoint { load: Wrench { force: force * factor, moment: moment * factor }, ..*task }
}

/// Clamps `correction` (Δρ of each drive, mm or rad) to the limits on its size and on its change since the one `before`, if there is one.
fn limited_correction(correction: &[f64], before: Option<&[f64]>, limits: &CorrectionLimits) -> Vec<f64> {
    let largest = limits.correction_mm.unwrap_or(f64::INFINITY);
    let change = limits.correction_change_mm.unwrap_or(f64::INFINITY);
    let clamped = |(drive, delta): (usize, &f64)| {
        let sized = delta.clamp(-largest, largest);
        before.map_or(sized, |before| sized.clamp(before[drive] - change, before[drive] + change))
    };
    correction.iter().enumerate().map(clamped).collect()
}
