//! The workspace map: on a grid over the workspace, how far the tool moves under the cutting force, with and without
//! chain errors, what must be commanded instead, and how far superposition departs from the simultaneous model.

#[cfg(feature = "report")]
pub mod report;
mod resolve;
pub(crate) mod spec;

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{
    compensation::{Compensation, Method, Session, TaskPoint, compensate_batch},
    input::error,
    machine::{Configuration, Machine, Unreachable},
    simulation::{BySource, Failure, Machines, Scene, Source, status_of},
    spatial::Grid,
    statics::{self, Batch, Outcome, State, tool_compliance},
    work::{Event, Work, overlapped, this_shard},
};

/// A checked workspace-map study.
#[derive(Debug, Clone)]
pub struct WorkspaceMapStudy {
    /// Of what machine, under what.
    pub scene: Scene,
    /// Where.
    pub grid: Grid,
}

impl WorkspaceMapStudy {
    /// The tool angle of the study nearest to `phi`; rad.
    pub(crate) fn nearest_phi(&self, phi: f64) -> f64 {
        let off = |own: &f64| (own - phi).abs();
        self.scene.phis.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(phi)
    }
}

/// What a source does at a grid point, worst over φ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SourceEffect {
    /// Largest displacement of the tool tip, mm.
    pub deflection_mm: f64,
    /// The displacement itself, O axes, mm.
    pub deflection_vector_mm: [f64; 3],
    /// φ at which it occurs, degrees; `None` without cutting force.
    pub phi_deg: Option<f64>,
    /// Largest |Δρ| of each drive over φ: compensated less nominal drive position, mm or rad; or why there is none.
    pub delta_rho: Result<Vec<f64>, Failure>,
    /// Largest distance of the compensated point from where it is wanted, with the drives corrected, mm: what they cannot
    /// compensate.
    pub residual_mm: f64,
    /// Largest |τ| of each drive over φ at the nominal command, N or N·mm.
    pub drive_force: Vec<f64>,
    /// Principal stiffnesses of the tool tip at the worst φ, ascending, N/mm.
    pub principal_stiffness_n_per_mm: [f64; 3],
    /// Superposition less simultaneous tool displacement at the worst φ, O axes, mm; only for both sources.
    pub superposition_error_vector_mm: Option<[f64; 3]>,
}

impl SourceEffect {
    /// Norm of the superposition error, mm.
    pub fn superposition_error_mm(&self) -> Option<f64> {
        self.superposition_error_vector_mm.map(|v| Vector3::from(v).norm())
    }
}

/// One grid point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MapPoint {
    /// Commanded position of P, mm.
    pub position_mm: [f64; 3],
    /// Effect of each source.
    pub effects: BySource<Result<SourceEffect, Failure>>,
}

impl MapPoint {
    /// Whether the effect of `source` and its correction could be computed; else the status of what could not.
    pub fn status(&self, source: Source) -> &str {
        match &self.effects[source] {
            Ok(effect) => status_of(&effect.delta_rho),
            Err(failure) => &failure.status,
        }
    }

    /// The effect of `source`, if it could be computed.
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

/// Computes all points, in parallel on the current rayon pool; the result does not depend on the number of threads.
///
/// # Errors
/// Of `work`.
pub fn run(study: &WorkspaceMapStudy, work: &Work) -> error::Result<WorkspaceMap> {
    let mut points = Vec::with_capacity(study.grid.len());
    run_in_blocks(study, work, |block| {
        points.extend(block);
        Ok(())
    })?;
    Ok(WorkspaceMap { study: study.clone(), points })
}

/// Most points of a block, and most tool angles of all its points: what a run that is killed loses.
const MOST_POINTS: usize = 4096;
const MOST_ANGLES: usize = 1 << 18;

/// Points of a block: a multiple of those solved side by side.
fn block_size(study: &WorkspaceMapStudy) -> usize {
    let points = (MOST_ANGLES / study.scene.phis.len().max(1)).min(MOST_POINTS);
    (points / Batch::WIDTH).max(1) * Batch::WIDTH
}

/// As [`run`], but gives the points to `take` block by block, in grid order, so that memory does not grow with the grid. The
/// next block is computed meanwhile.
///
/// # Errors
/// Of `work` and of `take`.
pub fn run_in_blocks(
    study: &WorkspaceMapStudy,
    work: &Work,
    take: impl FnMut(Vec<MapPoint>) -> error::Result<()> + Send,
) -> error::Result<()> {
    let machines = study.scene.machines()?;
    let (total, size) = (study.grid.len(), block_size(study));
    let compute = |start: usize| {
        let work = work.shard(start / size);
        this_shard(work.piece(&start, Vec::len, || block(study, &machines, start..total.min(start + size), &work)))
    };
    overlapped((0..total).step_by(size), compute, take)?;
    work.barrier()
}

/// Number of blocks.
pub(super) fn blocks(study: &WorkspaceMapStudy) -> usize {
    study.grid.len().div_ceil(block_size(study))
}

/// Computes the grid points with these indices, in grid order, in parallel on the current rayon pool; indices beyond the grid
/// give no points.
///
/// # Errors
/// Of `work`.
pub fn run_range(study: &WorkspaceMapStudy, indices: Range<usize>, work: &Work) -> error::Result<Vec<MapPoint>> {
    let indices = indices.start.min(study.grid.len())..indices.end.min(study.grid.len());
    block(study, &study.scene.machines()?, indices, work)
}

fn block(
    study: &WorkspaceMapStudy,
    machines: &Machines,
    indices: Range<usize>,
    work: &Work,
) -> error::Result<Vec<MapPoint>> {
    let groups = (0..indices.len().div_ceil(Batch::WIDTH))
        .into_par_iter()
        .map_init(
            || GroupSolver { study, groups: BySource::of(&study.scene.machine, |source| Group::new(machines, source)) },
            |solver, group| {
                work.check()?;
                let first = indices.start + group * Batch::WIDTH;
                let indices = first..indices.end.min(first + Batch::WIDTH);
                Ok(solver.solve(&indices.map(|index| study.grid.position(index)).collect::<Vec<_>>(), work))
            },
        )
        .collect::<error::Result<Vec<Vec<MapPoint>>>>()?;
    Ok(groups.into_iter().flatten().collect())
}

/// One machine at several points, commanded twice: without and with compensation.
struct Group {
    plain: Vec<Session>,
    corrected: Vec<Session>,
    plain_batch: Batch,
    corrected_batch: Batch,
}

impl Group {
    fn new(machines: &Machines, source: Source) -> Self {
        let (session, batch) = (machines.session(source), machines.batch(source));
        Self {
            plain: vec![session.clone(); Batch::WIDTH],
            corrected: vec![session; Batch::WIDTH],
            plain_batch: batch.clone(),
            corrected_batch: batch,
        }
    }
}

/// Tool displacements over φ and their effect, of one source.
struct Turn {
    /// Tool displacement at each φ, mm.
    displacements: Vec<Vector3<f64>>,
    effect: SourceEffect,
}

/// Solves neighbouring points of the grid side by side; what comes out for one does not depend on the others.
struct GroupSolver<'a> {
    study: &'a WorkspaceMapStudy,
    /// The machines that answer for the sources.
    groups: BySource<Group>,
}

impl GroupSolver<'_> {
    fn solve(&mut self, positions: &[Vector3<f64>], work: &Work) -> Vec<MapPoint> {
        let machine = &self.study.scene.machine;
        let reached: Vec<_> = positions.iter().map(|position| machine.command(*position)).collect();
        let configurations: Vec<&Configuration> = reached.iter().flatten().collect();
        let phis: Vec<Option<f64>> = self.study.scene.phis.iter().copied().map(Some).collect();
        let mut turns = BySource::of(machine, |source| {
            let group = &mut self.groups[source];
            for (session, at) in group.plain.iter_mut().zip(&configurations) {
                session.stand(at, &State::rigid(machine, at));
            }
            let loads = if source.has_cutting_force() { &phis[..] } else { &[None] };
            turn(self.study, source, group, &configurations, loads).into_iter()
        });
        let mut effects = configurations.iter().map(|_| {
            let nothing = || Err(Failure { status: "not_converged".into(), reason: "there is no load".into() });
            let own = BySource::of(machine, |source| turns[source].next().unwrap_or_else(nothing));
            let superposition_error = superposition_error(machine, &own);
            own.map(|source, turn: Result<Turn, Failure>| {
                let mut effect = turn?.effect;
                effect.superposition_error_vector_mm = superposition_error.filter(|_| source == Source::All);
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
        positions.iter().zip(&reached).filter_map(point).collect()
    }
}

/// Superposition less displacement by all sources at once, where that is largest; `None` where a source has no answer.
fn superposition_error(machine: &Machine, turns: &BySource<Result<Turn, Failure>>) -> Option<[f64; 3]> {
    let of = |source: Source| Some(&turns.get(source)?.as_ref().ok()?.displacements);
    let all = of(Source::All)?;
    let worst = index_of_largest(all);
    let mut superposed = Vector3::zeros();
    for part in Source::parts(machine) {
        let displacements = of(*part)?;
        superposed += displacements[if part.has_cutting_force() { worst } else { 0 }];
    }
    Some((superposed - all[worst]).into())
}

/// Equilibria without and with compensation for each load (a φ, or none), each started from the one before, at each of
/// `configurations`.
fn turn(
    study: &WorkspaceMapStudy,
    source: Source,
    group: &mut Group,
    configurations: &[&Configuration],
    phis: &[Option<f64>],
) -> Vec<Result<Turn, Failure>> {
    let machine = &study.scene.machine;
    let mut tallies: Vec<Result<Tally, Failure>> =
        configurations.iter().map(|_| Ok(Tally::new(machine, phis.len()))).collect();
    let task_at = |phi: Option<f64>, i: usize| source.task(&study.scene.task(configurations[i].pose, phi));
    for (index, &phi) in phis.iter().enumerate() {
        let task = |i: usize| task_at(phi, i);
        let command = |sessions: &mut [Session], batch: &mut Batch, method, places: &[usize]| {
            let answers = command(sessions, batch, method, places, task);
            let judged = answers.into_iter().map(|answer| judged(machine, phi, answer));
            places.iter().copied().zip(judged).collect::<Vec<_>>()
        };
        let plain = command(&mut group.plain, &mut group.plain_batch, Method::None, &places(&tallies, |_| true));
        for (i, answer) in plain {
            if index == 0 && answer.is_ok() {
                group.corrected[i].stand(configurations[i], group.plain[i].state());
            }
            match (answer, &mut tallies[i]) {
                (Ok(plain), Ok(tally)) => {
                    tally.note(machine, phi, plain, group.plain[i].state());
                }
                (Err(failure), tally) => *tally = Err(failure),
                (Ok(_), Err(_)) => {}
            }
        }
        let to_correct = places(&tallies, |tally| tally.delta_rho.is_ok());
        for (i, answer) in command(&mut group.corrected, &mut group.corrected_batch, Method::Direct, &to_correct) {
            if let Ok(tally) = &mut tallies[i] {
                tally.note_correction(configurations[i], answer);
            }
        }
    }
    let conclude = |(i, tally): (usize, Result<Tally, Failure>)| {
        let tally = tally?;
        let phi = tally.worst.as_ref().and_then(|worst| worst.phi);
        match group.plain[i].workpiece_compliance(&task_at(phi, i)) {
            Ok(carried) => tally.conclude(&carried),
            Err(status) => Err(Failure { status: status.label().into(), reason: status.reason(machine) }),
        }
    };
    tallies.into_iter().enumerate().map(conclude).collect()
}

/// Indices of the points without failure so far whose tally `is_wanted`.
fn places(tallies: &[Result<Tally, Failure>], is_wanted: impl Fn(&Tally) -> bool) -> Vec<usize> {
    (0..tallies.len()).filter(|&i| tallies[i].as_ref().is_ok_and(&is_wanted)).collect()
}

/// Commands the points with the indices `places`.
fn command(
    sessions: &mut [Session],
    batch: &mut Batch,
    method: Method,
    places: &[usize],
    task: impl Fn(usize) -> TaskPoint,
) -> Vec<Compensation> {
    let tasks: Vec<TaskPoint> = places.iter().map(|&i| task(i)).collect();
    let chosen = sessions.iter_mut().enumerate().filter(|(i, _)| places.contains(i));
    let mut sessions: Vec<&mut Session> = chosen.map(|(_, session)| session).collect();
    compensate_batch(&mut sessions, &tasks, method, batch)
}

/// The answer, if it is what was asked for; else why it is not.
fn judged(machine: &Machine, phi: Option<f64>, answer: Compensation) -> Result<Compensation, Failure> {
    if answer.status.is_success() {
        return Ok(answer);
    }
    let at = phi.map_or_else(String::new, |phi| format!(" (tool angle {:.1}°)", phi.to_degrees()));
    Err(Failure { status: answer.status.label().into(), reason: answer.status.reason(machine) + &at })
}

/// What the loads of one point and source came to so far.
struct Tally {
    displacements: Vec<Vector3<f64>>,
    delta_rho: Result<Vec<f64>, Failure>,
    /// mm.
    left: f64,
    drive_force: Vec<f64>,
    worst: Option<Worst>,
}

/// The load with the largest displacement so far.
struct Worst {
    displacement: Vector3<f64>,
    phi: Option<f64>,
    outcome: Option<Outcome>,
    /// From P to the displaced tool tip, O axes, mm.
    lever: Vector3<f64>,
}

impl Tally {
    fn new(machine: &Machine, loads: usize) -> Self {
        let zeros = vec![0.0; machine.drive_count()];
        Self {
            displacements: Vec::with_capacity(loads),
            delta_rho: Ok(zeros.clone()),
            left: 0.0,
            drive_force: zeros,
            worst: None,
        }
    }

    /// Takes note of one load: the answer `plain` without compensation, which ended in `state`.
    fn note(&mut self, machine: &Machine, phi: Option<f64>, plain: Compensation, state: &State) {
        for (most, force) in self.drive_force.iter_mut().zip(&plain.drive_forces) {
            *most = most.max(force.abs());
        }
        let displacement = plain.tool_displacement;
        if self.worst.as_ref().is_none_or(|worst| displacement.norm() > worst.displacement.norm()) {
            let lever = state.pose.rotation * machine.tool_tip;
            self.worst = Some(Worst { displacement, phi, outcome: plain.outcome, lever });
        }
        self.displacements.push(displacement);
    }

    /// Takes note of the correction of one load at `at`, or of why there is none.
    fn note_correction(&mut self, at: &Configuration, corrected: Result<Compensation, Failure>) {
        match (&mut self.delta_rho, corrected) {
            (Ok(largest), Ok(corrected)) => {
                for ((most, rho), nominal) in largest.iter_mut().zip(&corrected.drives).zip(&at.drives) {
                    *most = most.max((rho - nominal).abs());
                }
                self.left = self.left.max(corrected.position_error.norm());
            }
            (delta_rho, Err(failure)) => *delta_rho = Err(failure),
            (Err(_), Ok(_)) => {}
        }
    }

    /// `carried`: compliance of the workpiece under the load with the largest displacement, mm/N.
    fn conclude(self, carried: &Matrix3<f64>) -> Result<Turn, Failure> {
        let Some(worst) = self.worst else {
            return Err(Failure { status: "not_converged".into(), reason: "there is no load".into() });
        };
        let effect = SourceEffect {
            deflection_mm: worst.displacement.norm(),
            deflection_vector_mm: worst.displacement.into(),
            phi_deg: worst.phi.map(f64::to_degrees),
            delta_rho: self.delta_rho,
            residual_mm: self.left,
            drive_force: self.drive_force,
            principal_stiffness_n_per_mm: tool_stiffnesses(worst.outcome.as_ref(), worst.lever, carried),
            superposition_error_vector_mm: None,
        };
        Ok(Turn { displacements: self.displacements, effect })
    }
}

fn index_of_largest(displacements: &[Vector3<f64>]) -> usize {
    let mut largest = 0;
    for (index, displacement) in displacements.iter().enumerate() {
        if displacement.norm() > displacements[largest].norm() {
            largest = index;
        }
    }
    largest
}

/// Inverse eigenvalues of the compliance between tool tip and workpiece, ascending, N/mm; 0 where the tip is free.
fn tool_stiffnesses(outcome: Option<&Outcome>, lever: Vector3<f64>, carried: &Matrix3<f64>) -> [f64; 3] {
    let Some(compliance) = outcome.and_then(|outcome| outcome.compliance) else { return [0.0; 3] };
    statics::principal_stiffnesses(&(tool_compliance(&compliance, lever) + carried))
}
