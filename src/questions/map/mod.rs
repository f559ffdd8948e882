//! Workspace map: tool deflection by each source of error on a grid, corrected drive commands, and the superposition error.

#[cfg(feature = "report")]
pub mod report;
mod resolve;
pub(crate) mod spec;
mod uncertain;

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::uncertain::SpreadSolver;
use crate::{
    compensation::{Compensation, Method, Session, TaskPoint, compensate_batch},
    input::error,
    machine::{Configuration, Machine, Unreachable},
    process::uncertainty::Uncertainty,
    simulation::{
        BySource, Failure, LoadCase, Machines, Source,
        spread::{DeflectionSpread, DrawnMachines},
        status_of,
    },
    spatial::Grid,
    statics::{self, Batch, Outcome, State, tool_compliance},
    work::{Event, Work, compute_overlapped, if_this_shard},
};

/// A checked workspace-map study.
#[derive(Debug, Clone)]
pub struct WorkspaceMapStudy {
    /// Machine, cutting force, tool angles and chain errors.
    pub load_case: LoadCase,
    /// Commanded positions of P, O, mm.
    pub grid: Grid,
    /// What is not known exactly; `None` where all inputs are taken as exact.
    pub uncertainty: Option<Uncertainty>,
}

impl WorkspaceMapStudy {
    /// Returns the tool angle φ of the study nearest to `phi`, rad; `phi` itself if the study has none.
    pub(crate) fn nearest_phi(&self, phi: f64) -> f64 {
        let difference = |candidate: &f64| (candidate - phi).abs();
        self.load_case.phis.iter().copied().min_by(|a, b| difference(a).total_cmp(&difference(b))).unwrap_or(phi)
    }
}

/// Effect of a source of error at a grid point, worst over the tool angle φ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceEffect {
    /// Largest displacement of the tool tip, mm.
    pub deflection_mm: f64,
    /// Displacement of the tool tip of that size, O axes, mm.
    pub deflection_vector_mm: [f64; 3],
    /// φ at which it occurs, degrees; `None` without cutting force.
    pub phi_deg: Option<f64>,
    /// Largest |Δρ| of each drive over φ, compensated less nominal position, mm or rad; or why there is none.
    pub delta_rho: Result<Vec<f64>, Failure>,
    /// Largest residual error of the compensated point over φ with corrected drives, mm.
    pub residual_mm: f64,
    /// Largest |τ| of each drive over φ at the nominal command, N or N·mm.
    pub drive_force: Vec<f64>,
    /// Principal stiffnesses of the tool tip at the worst φ, ascending, N/mm.
    pub principal_stiffness_n_per_mm: [f64; 3],
    /// Sum of the displacements by the single sources less that by all, at the worst φ, O axes, mm; only for all sources.
    pub superposition_error_vector_mm: Option<[f64; 3]>,
    /// Distribution of the deflection; only for all sources, and where inputs are uncertain.
    pub spread: Option<DeflectionSpread>,
}

impl SourceEffect {
    /// Returns the norm of the superposition error, mm; `None` where it is not known, as for single sources.
    pub fn superposition_error_mm(&self) -> Option<f64> {
        self.superposition_error_vector_mm.map(|v| Vector3::from(v).norm())
    }
}

/// Results at one grid point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapPoint {
    /// Commanded position of P, O, mm.
    pub position_mm: [f64; 3],
    /// Effect of each source, or why it could not be computed.
    pub effects: BySource<Result<SourceEffect, Failure>>,
}

impl MapPoint {
    /// Returns "solved" if the effect of `source` and its correction could be computed; else the status of what could not.
    pub fn status(&self, source: Source) -> &str {
        match &self.effects[source] {
            Ok(effect) => status_of(&effect.delta_rho),
            Err(failure) => &failure.status,
        }
    }

    /// Returns the effect of `source`, if it could be computed.
    pub fn effect(&self, source: Source) -> Option<&SourceEffect> {
        self.effects.get(source)?.as_ref().ok()
    }
}

/// Results of a workspace-map study.
#[derive(Debug, Clone, Serialize)]
pub struct WorkspaceMap {
    /// The study.
    #[serde(skip)]
    pub study: WorkspaceMapStudy,
    /// Points in grid order.
    pub points: Vec<MapPoint>,
}

/// Computes all points in parallel on the current rayon pool; the results do not depend on the number of threads. `Err` if `work` was
/// stopped or could not be kept, or an uncertain input makes no machine.
pub fn run(study: &WorkspaceMapStudy, work: &Work) -> error::Result<WorkspaceMap> {
    let mut points = Vec::with_capacity(study.grid.len());
    run_in_blocks(study, work, |block| {
        points.extend(block);
        Ok(())
    })?;
    Ok(WorkspaceMap { study: study.clone(), points })
}

/// Largest number of points of a block, which limits what a killed run loses.
const MAX_POINTS: usize = 4096;
/// Largest number of tool angles of all points of a block.
const MAX_ANGLES: usize = 1 << 18;

/// Returns the number of grid points of a block, a multiple of [`Batch::WIDTH`].
fn block_size(study: &WorkspaceMapStudy) -> usize {
    let points = (MAX_ANGLES / study.load_case.phis.len().max(1)).min(MAX_POINTS);
    (points / Batch::WIDTH).max(1) * Batch::WIDTH
}

/// Computes all points and hands them to `take` block by block in grid order, so that memory does not grow with the grid. `Err` as [`run`],
/// and that of `take`.
pub fn run_in_blocks(
    study: &WorkspaceMapStudy,
    work: &Work,
    take: impl FnMut(Vec<MapPoint>) -> error::Result<()> + Send,
) -> error::Result<()> {
    let machines = study.load_case.machines()?;
    let drawn = drawn_machines(study, &machines)?;
    let (total, size) = (study.grid.len(), block_size(study));
    let compute = |start: usize| {
        let work = work.shard(start / size);
        if_this_shard(work.piece(&start, Vec::len, || {
            let indices = start..total.min(start + size);
            run_block(study, &machines, drawn.as_ref(), indices, &work)
        }))
    };
    compute_overlapped((0..total).step_by(size), compute, take)?;
    work.barrier()
}

/// Returns the number of blocks of the map.
pub(super) fn block_count(study: &WorkspaceMapStudy) -> usize {
    study.grid.len().div_ceil(block_size(study))
}

/// Computes the grid points with these indices, in grid order, in parallel on the current rayon pool; indices beyond the grid give none. With uncertain
/// inputs a range that is not between multiples of 8 may differ from the whole map by what its check lets pass. `Err` as [`run`].
pub fn run_range(study: &WorkspaceMapStudy, indices: Range<usize>, work: &Work) -> error::Result<Vec<MapPoint>> {
    let indices = indices.start.min(study.grid.len())..indices.end.min(study.grid.len());
    let machines = study.load_case.machines()?;
    run_block(study, &machines, drawn_machines(study, &machines)?.as_ref(), indices, work)
}

/// Returns the machines that draws of uncertain inputs make of `machines`; `None` where inputs are exact. `Err` if they make no machine.
fn drawn_machines(study: &WorkspaceMapStudy, machines: &Machines) -> error::Result<Option<DrawnMachines>> {
    DrawnMachines::new(study.uncertainty.as_ref(), machines, &study.load_case.errors)
}

/// Computes the grid points with these `indices` in parallel, [`Batch::WIDTH`] solved side by side at a time. `Err` if `work` was stopped.
fn run_block(
    study: &WorkspaceMapStudy,
    machines: &Machines,
    drawn: Option<&DrawnMachines>,
    indices: Range<usize>,
    work: &Work,
) -> error::Result<Vec<MapPoint>> {
    let solver = || GroupSolver {
        study,
        groups: BySource::of(&study.load_case.machine, |source| Group::new(machines, source)),
        spread: drawn.map(|drawn| SpreadSolver::new(study, machines, drawn)),
    };
    let groups = (0..indices.len().div_ceil(Batch::WIDTH))
        .into_par_iter()
        .map_init(solver, |solver, group| {
            work.check()?;
            let first = indices.start + group * Batch::WIDTH;
            let indices = first..indices.end.min(first + Batch::WIDTH);
            solver.solve(&indices.map(|index| study.grid.position(index)).collect::<Vec<_>>(), work)
        })
        .collect::<error::Result<Vec<Vec<MapPoint>>>>()?;
    Ok(groups.into_iter().flatten().collect())
}

/// Sessions of one machine at several points, each commanded twice: without and with compensation.
struct Group {
    plain: SessionGroup,
    corrected: SessionGroup,
}

impl Group {
    /// Makes the sessions of the machine of `source` for [`Batch::WIDTH`] points.
    fn new(machines: &Machines, source: Source) -> Self {
        let plain = SessionGroup::new(machines, source);
        Self { corrected: plain.clone(), plain }
    }
}

/// Sessions of one machine, solved side by side.
#[derive(Clone)]
struct SessionGroup {
    sessions: Vec<Session>,
    batch: Batch,
}

impl SessionGroup {
    /// Makes [`Batch::WIDTH`] sessions of the machine of `source`.
    fn new(machines: &Machines, source: Source) -> Self {
        Self { sessions: vec![machines.session(source); Batch::WIDTH], batch: machines.batch(source) }
    }

    /// Sets each session to the configuration at its index in `at`, undeflected.
    fn set_rigid(&mut self, at: &[&Configuration]) {
        for (session, at) in self.sessions.iter_mut().zip(at) {
            session.set_rigid(at);
        }
    }

    /// Solves the tasks of the sessions with these `indices` by `method`, side by side; failures name the tool angle `phi` (rad).
    fn command(
        &mut self,
        machine: &Machine,
        phi: Option<f64>,
        method: Method,
        indices: &[usize],
        task: impl Fn(usize) -> TaskPoint,
    ) -> Vec<Result<Compensation, Failure>> {
        let tasks: Vec<TaskPoint> = indices.iter().map(|&i| task(i)).collect();
        let chosen = self.sessions.iter_mut().enumerate().filter(|(i, _)| indices.contains(i));
        let mut sessions: Vec<&mut Session> = chosen.map(|(_, session)| session).collect();
        let results = compensate_batch(&mut sessions, &tasks, method, &mut self.batch);
        results.into_iter().map(|result| success_or_failure(machine, phi, result)).collect()
    }
}

/// Displacements of the tool over φ at one point, and the effect of the source.
struct PhiSweep {
    /// Tool displacement at each φ, mm.
    displacements: Vec<Vector3<f64>>,
    effect: SourceEffect,
}

/// Solver of neighbouring grid points side by side; the result of one point, but for its spread, does not depend on the others.
struct GroupSolver<'a> {
    study: &'a WorkspaceMapStudy,
    /// Sessions of the machine that each source acts on.
    groups: BySource<Group>,
    /// Sessions of machines off the nominal one, where inputs are uncertain.
    spread: Option<SpreadSolver<'a>>,
}

impl GroupSolver<'_> {
    /// Computes the grid points at `positions` (P, O, mm) and reports progress to `work`; `Err` if that is stopped.
    fn solve(&mut self, positions: &[Vector3<f64>], work: &Work) -> error::Result<Vec<MapPoint>> {
        let machine = &self.study.load_case.machine;
        let reached: Vec<_> = positions.iter().map(|position| machine.inverse_kinematics_at(*position)).collect();
        let configurations: Vec<&Configuration> = reached.iter().flatten().collect();
        let phis: Vec<Option<f64>> = self.study.load_case.phis.iter().copied().map(Some).collect();
        let mut sweeps = BySource::of(machine, |source| {
            let group = &mut self.groups[source];
            group.plain.set_rigid(&configurations);
            let loads = if source.has_cutting_force() { &phis[..] } else { &[None] };
            sweep_phi(self.study, source, group, &configurations, loads).into_iter()
        });
        let spreads = self.spread.as_mut().map(|solver| {
            let nominal = sweeps[Source::All].as_slice().iter().map(|sweep| Some(&*sweep.as_ref().ok()?.displacements));
            solver.solve(&configurations, nominal, work)
        });
        let mut spreads = spreads.transpose()?.unwrap_or_default().into_iter();
        let mut effects = configurations.iter().map(|_| {
            let no_load = || Err(Failure { status: "not_converged".into(), reason: "there is no load".into() });
            let by_source = BySource::of(machine, |source| sweeps[source].next().unwrap_or_else(no_load));
            let superposition_error = superposition_error(machine, &by_source);
            let mut spread = spreads.next().flatten();
            by_source.map(|source, sweep: Result<PhiSweep, Failure>| {
                let mut effect = sweep?.effect;
                if source == Source::All {
                    effect.superposition_error_vector_mm = superposition_error;
                    effect.spread = spread.take();
                }
                Ok(effect)
            })
        });
        let point = |(position, reached): (&Vector3<f64>, &Result<Configuration, Unreachable>)| {
            let effects = match reached {
                Ok(_) => effects.next(),
                Err(unreachable) => Some(BySource::of(machine, |_| Err(Failure::from(unreachable.clone())))),
            };
            if effects.as_ref().is_some_and(|effects| effects.iter().any(|(_, effect)| effect.is_err())) {
                work.tell(Event::Unsolved(1));
            }
            work.tell(Event::Computed(1));
            effects.map(|effects| MapPoint { position_mm: (*position).into(), effects })
        };
        Ok(positions.iter().zip(&reached).filter_map(point).collect())
    }
}

/// Returns the sum of the displacements by single sources less that by all, at its worst φ, O axes, mm; `None` where one is missing.
fn superposition_error(machine: &Machine, sweeps: &BySource<Result<PhiSweep, Failure>>) -> Option<[f64; 3]> {
    let displacements_by = |source: Source| Some(&sweeps.get(source)?.as_ref().ok()?.displacements);
    let all = displacements_by(Source::All)?;
    let worst = index_of_largest(all);
    let mut superposed = Vector3::zeros();
    for part in Source::parts(machine) {
        let displacements = displacements_by(*part)?;
        superposed += displacements[if part.has_cutting_force() { worst } else { 0 }];
    }
    Some((superposed - all[worst]).into())
}

/// Solves each of `configurations` over `phis` (rad), without and with compensation, each angle from the one before; one result for each.
fn sweep_phi(
    study: &WorkspaceMapStudy,
    source: Source,
    group: &mut Group,
    configurations: &[&Configuration],
    phis: &[Option<f64>],
) -> Vec<Result<PhiSweep, Failure>> {
    let machine = &study.load_case.machine;
    let mut tallies: Vec<Result<Tally, Failure>> =
        configurations.iter().map(|_| Ok(Tally::new(machine, phis.len()))).collect();
    let task_at = |phi: Option<f64>, i: usize| source.task(&study.load_case.task_point(configurations[i].pose, phi));
    for (index, &phi) in phis.iter().enumerate() {
        let task = |i: usize| task_at(phi, i);
        let indices = select(&tallies, |_| true);
        let plain = group.plain.command(machine, phi, Method::None, &indices, task);
        for (i, result) in indices.into_iter().zip(plain) {
            let state = group.plain.sessions[i].state();
            if index == 0 && result.is_ok() {
                group.corrected.sessions[i].set_state(configurations[i], state);
            }
            match (result, &mut tallies[i]) {
                (Ok(plain), Ok(tally)) => {
                    tally.add(machine, phi, plain, state);
                }
                (Err(failure), tally) => *tally = Err(failure),
                (Ok(_), Err(_)) => {}
            }
        }
        let to_correct = select(&tallies, |tally| tally.delta_rho.is_ok());
        let corrected = group.corrected.command(machine, phi, Method::Direct, &to_correct, task);
        for (i, result) in to_correct.into_iter().zip(corrected) {
            if let Ok(tally) = &mut tallies[i] {
                tally.add_correction(configurations[i], result);
            }
        }
    }
    let conclude = |(i, tally): (usize, Result<Tally, Failure>)| {
        let tally = tally?;
        let phi = tally.worst.as_ref().and_then(|worst| worst.phi);
        match group.plain.sessions[i].workpiece_compliance(&task_at(phi, i)) {
            Ok(carrier_compliance) => tally.conclude(&carrier_compliance),
            Err(status) => Err(Failure::of(&status, machine)),
        }
    };
    tallies.into_iter().enumerate().map(conclude).collect()
}

/// Returns the indices of the points that have no failure so far and whose tally `is_wanted`.
fn select(tallies: &[Result<Tally, Failure>], is_wanted: impl Fn(&Tally) -> bool) -> Vec<usize> {
    (0..tallies.len()).filter(|&i| tallies[i].as_ref().is_ok_and(&is_wanted)).collect()
}

/// Returns `result` if the command succeeded; else its failure, which names the tool angle `phi` (rad), if there is one.
fn success_or_failure(machine: &Machine, phi: Option<f64>, result: Compensation) -> Result<Compensation, Failure> {
    if result.status.is_success() {
        return Ok(result);
    }
    let angle = phi.map_or_else(String::new, |phi| format!(" (tool angle {:.1}°)", phi.to_degrees()));
    Err(Failure { status: result.status.label().into(), reason: result.status.reason(machine) + &angle })
}

/// Extremes over the loads of one point and source, so far.
struct Tally {
    /// Tool displacement under each load, O axes, mm.
    displacements: Vec<Vector3<f64>>,
    /// Largest |Δρ| of each drive, mm or rad, or why a correction is missing.
    delta_rho: Result<Vec<f64>, Failure>,
    /// Largest residual error, mm.
    residual_mm: f64,
    /// Largest |τ| of each drive at the nominal command, N or N·mm.
    drive_force: Vec<f64>,
    worst: Option<Worst>,
}

/// The load with the largest displacement so far.
struct Worst {
    displacement: Vector3<f64>,
    phi: Option<f64>,
    outcome: Option<Outcome>,
    /// Vector from P to the displaced tool tip, O axes, mm.
    lever: Vector3<f64>,
}

impl Tally {
    /// Makes an empty tally for `loads` loads.
    fn new(machine: &Machine, loads: usize) -> Self {
        let zeros = vec![0.0; machine.drive_count()];
        Self {
            displacements: Vec::with_capacity(loads),
            delta_rho: Ok(zeros.clone()),
            residual_mm: 0.0,
            drive_force: zeros,
            worst: None,
        }
    }

    /// Adds one load at tool angle `phi` (rad): its result `uncompensated`, which ended in `state`.
    fn add(&mut self, machine: &Machine, phi: Option<f64>, uncompensated: Compensation, state: &State) {
        for (largest, force) in self.drive_force.iter_mut().zip(&uncompensated.drive_forces) {
            *largest = largest.max(force.abs());
        }
        let displacement = uncompensated.tool_displacement;
        if self.worst.as_ref().is_none_or(|worst| displacement.norm() > worst.displacement.norm()) {
            let lever = state.pose.rotation * machine.tool_tip;
            self.worst = Some(Worst { displacement, phi, outcome: uncompensated.outcome, lever });
        }
        self.displacements.push(displacement);
    }

    /// Adds the correction of one load at the configuration `at`, or the reason why there is none.
    fn add_correction(&mut self, at: &Configuration, corrected: Result<Compensation, Failure>) {
        match (&mut self.delta_rho, corrected) {
            (Ok(largest), Ok(corrected)) => {
                for ((most, rho), nominal) in largest.iter_mut().zip(&corrected.drives).zip(&at.drives) {
                    *most = most.max((rho - nominal).abs());
                }
                self.residual_mm = self.residual_mm.max(corrected.position_error.norm());
            }
            (delta_rho, Err(failure)) => *delta_rho = Err(failure),
            (Err(_), Ok(_)) => {}
        }
    }

    /// Returns displacements and effect of the source; `carrier_compliance` is that of the workpiece under the worst load, mm/N.
    fn conclude(self, carrier_compliance: &Matrix3<f64>) -> Result<PhiSweep, Failure> {
        let Some(worst) = self.worst else {
            return Err(Failure { status: "not_converged".into(), reason: "there is no load".into() });
        };
        let effect = SourceEffect {
            deflection_mm: worst.displacement.norm(),
            deflection_vector_mm: worst.displacement.into(),
            phi_deg: worst.phi.map(f64::to_degrees),
            delta_rho: self.delta_rho,
            residual_mm: self.residual_mm,
            drive_force: self.drive_force,
            principal_stiffness_n_per_mm: tool_stiffnesses(worst.outcome.as_ref(), worst.lever, carrier_compliance),
            superposition_error_vector_mm: None,
            spread: None,
        };
        Ok(PhiSweep { displacements: self.displacements, effect })
    }
}

/// Returns the index of the longest displacement, the first of equal ones; 0 if there are none.
fn index_of_largest(displacements: &[Vector3<f64>]) -> usize {
    let mut largest = 0;
    for (index, displacement) in displacements.iter().enumerate() {
        if displacement.norm() > displacements[largest].norm() {
            largest = index;
        }
    }
    largest
}

/// Returns the principal stiffnesses of tool tip against workpiece, ascending, N/mm, 0 where it is free; `lever` is from P to the tip, O,
/// mm.
fn tool_stiffnesses(outcome: Option<&Outcome>, lever: Vector3<f64>, carrier_compliance: &Matrix3<f64>) -> [f64; 3] {
    let Some(compliance) = outcome.and_then(|outcome| outcome.compliance) else { return [0.0; 3] };
    statics::principal_stiffnesses(&(tool_compliance(&compliance, lever) + carrier_compliance))
}
