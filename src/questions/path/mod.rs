//! Path study: displacements along a path by each source of error, commands that compensate them, and a comparison of the methods.

#[cfg(not(target_family = "wasm"))]
mod clearance;
#[cfg(feature = "report")]
pub mod report;
pub(crate) mod resolve;
pub(crate) mod spec;
mod turned;

use std::{
    ops::{Deref, Range},
    sync::Arc,
};

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use crate::{
    compensation::{Method, TaskPoint},
    input::error::Result,
    machine::{Configuration, Machine},
    process::{KnownForce, VerdictTable, file::ProcessCell, uncertainty::DrawnForceAt},
    simulation::{
        BySource, Machines, Source, TrackedPath,
        along_path::{
            self, Arrival, PathCase, PathPointResult, PathSummary, PathSums, PointResidual, TrackBlocks, run_pieces,
        },
        play::Reversals,
        spread_along::{self, LargestBoth, SpreadPart, SpreadPath},
    },
    work::{Work, compute_overlapped},
};

pub use crate::simulation::spread_along::{LargestSpread, PathSpread, PointSpread};
#[cfg(not(target_family = "wasm"))]
pub use clearance::clearance;
pub use turned::PathGammaSearch;

/// Where a point of the path lies: length, tool angle and program line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Station {
    /// Length of the path up to here, mm.
    pub arc_length_mm: f64,
    /// Tool angle φ: heading about the tool axis less 90°, degrees in [0, 360); `None` where the path does not move across that axis.
    pub phi_deg: Option<f64>,
    /// Whether the tool cuts on the way to this point.
    pub cutting: bool,
    /// How it is reached.
    #[serde(skip)]
    pub arrival: Arrival,
    /// Program line that leads to this point, from 1; `None` if the path is in no file.
    #[serde(skip)]
    pub line: Option<usize>,
    /// Index of the file of that line: 0 is the program itself, then come [`PathStudy::called_files`].
    #[serde(skip)]
    pub file: usize,
}

/// A checked path study.
#[derive(Debug, Clone)]
pub struct PathStudy {
    /// Its machine, where the workpiece stands, and what is uncertain.
    pub tracked: TrackedPath,
    /// Lengths, tool angles and program lines of the path's points.
    pub stations: Vec<Station>,
    /// Pose and load at each point.
    pub tasks: Vec<TaskPoint>,
    /// What draws change of the force at each point; empty where one factor is for all of it.
    pub(crate) drawn_forces: Vec<DrawnForceAt>,
    /// Largest programmed feed where the tool cuts, mm/s; `None` unless all cuts have one.
    pub fastest_mm_per_s: Option<f64>,
    /// Compensation methods compared.
    pub methods: Vec<Method>,
    /// Whether the path of a file ends at its first point, which is then counted once in the residual errors. Circles count their closing point.
    pub is_closed: bool,
    /// Where the workpiece stands and what is cut: [`Process::facts`](crate::process::Process::facts).
    pub facts: Vec<(&'static str, String)>,
    /// Those facts that are defaults nobody may have meant: [`Process::assumed`](crate::process::Process::assumed).
    pub assumed: Vec<(&'static str, String)>,
    /// How much of the cutting force its laws know.
    pub known_force: KnownForce,
    /// What the verdict is about, and bounds of what is not computed.
    pub verdict: VerdictTable,
    /// The search for γ, the rotation about the tool axis, if there is one; see [`PathStudy::with_gamma`].
    pub gamma_search: Option<PathGammaSearch>,
    /// Names of the files that its program calls.
    pub called_files: Vec<String>,
    /// What stands around the workpiece or moves with it; `None`: bodies are not looked at.
    pub cell: Option<Arc<ProcessCell>>,
}

impl Deref for PathStudy {
    type Target = TrackedPath;

    fn deref(&self) -> &TrackedPath {
        &self.tracked
    }
}

/// Display settings of a path report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shown {
    /// Whether the path is a circle, so that φ increases along it over one revolution.
    pub is_circle: bool,
}

impl PathStudy {
    /// Returns whether the tool cuts at no point of the path.
    pub(crate) fn cuts_nowhere(&self) -> bool {
        self.stations.iter().all(|station| !station.cutting)
    }

    /// Returns the length of the path, mm; 0 without points.
    pub fn length_mm(&self) -> f64 {
        self.stations.last().map_or(0.0, |station| station.arc_length_mm)
    }

    /// Returns the wanted position of P at each point of the path, O, mm.
    pub fn positions(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.tasks.iter().map(|task| task.pose.translation)
    }

    /// Returns the number of the pass of each point.
    fn passes(&self) -> Vec<u32> {
        spread_along::numbers_of_passes(0, self.stations.iter().map(|own| own.cutting))
    }

    /// Returns the part of the path with the indices `points`, along which `track` holds the configurations of the nominal machine.
    fn spread_part<'a>(&'a self, points: Range<usize>, track: &'a TrackBlocks<'a>) -> SpreadPart<'a> {
        let forces = self.drawn_forces.get(points.clone()).unwrap_or_default();
        SpreadPart { first: points.start, tasks: &self.tasks[points.clone()], forces, track, written: None }
    }

    /// Returns the wanted position of the compensated point at each point of the path, O, mm.
    pub fn wanted_positions(&self) -> Vec<Vector3<f64>> {
        self.tasks.iter().map(|task| task.pose.transform(task.offset(&self.machine))).collect()
    }
}

/// Effect of a source of error at a point of the path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PointEffect {
    /// At the nominal command.
    pub plain: PathPointResult,
    /// At the compensated command, whether it succeeds or not.
    pub answer: PathPointResult,
    /// Distributions of both distances; only for all sources, and where inputs are uncertain.
    pub spread: Option<PointSpread>,
}

impl PointEffect {
    /// Returns the displacement of the compensated point at the nominal command, O axes, mm; `None` where there is no equilibrium.
    pub fn displacement(&self) -> Option<Vector3<f64>> {
        self.plain.solved_error()
    }

    /// Returns the result at the compensated command, if it succeeded.
    pub fn compensated(&self) -> Option<&PathPointResult> {
        Some(&self.answer).filter(|answer| answer.status.is_success())
    }
}

/// Effects of the sources at consecutive points of a path. Points keep their indices in the whole path.
#[derive(Debug, Clone, Serialize)]
pub struct PathPart {
    /// Index of the first point.
    pub first: usize,
    /// Effect of each source at each point.
    pub sources: BySource<Vec<PointEffect>>,
}

impl PathPart {
    /// Makes a part without points, at the start of a path of `machine`.
    pub(crate) fn empty(machine: &Machine) -> Self {
        Self { first: 0, sources: BySource::of(machine, |_| Vec::new()) }
    }

    /// Sets the distributions of the distance at the points, in their order, `None` where there is none.
    fn set_spread(&mut self, spreads: Vec<Option<PointSpread>>) {
        self.sources[Source::All].iter_mut().zip(spreads).for_each(|(effect, spread)| effect.spread = spread);
    }

    /// Sets where drives change their side by all sources; `reversals` of the path before.
    fn note_reversals(&mut self, reversals: &mut Reversals) {
        self.sources[Source::All].iter_mut().for_each(|effect| reversals.note(effect.answer.play.as_mut()));
    }

    /// Returns the indices of its points.
    pub fn points(&self) -> Range<usize> {
        self.first..self.first + self.sources[Source::All].len()
    }

    /// Returns the effect of `source` at the point with the index `point` in the whole path; panics outside the part.
    pub fn at(&self, source: Source, point: usize) -> &PointEffect {
        &self.sources[source][point - self.first]
    }

    /// Returns the displacement by `source` at a point (index in the whole path), O axes, mm; `None` where there is no equilibrium.
    pub fn displacement(&self, source: Source, point: usize) -> Option<Vector3<f64>> {
        self.at(source, point).displacement()
    }

    /// Returns the shift of the commanded position of P that compensates all sources at `point` (index in the whole path), O axes, mm;
    /// `None` if that failed.
    pub fn command_shift(&self, study: &PathStudy, point: usize) -> Option<Vector3<f64>> {
        let target = self.at(Source::All, point).compensated()?.target?;
        Some(target.translation - study.tasks[point].pose.translation)
    }
}

/// Cost and residual errors of a compensation method along the path, all sources acting.
#[derive(Debug, Clone, Serialize)]
pub struct MethodAlongPath {
    /// The compensation method.
    pub method: Method,
    /// Its residual errors and costs.
    pub summary: PathSummary,
}

/// What holds for the whole path.
#[derive(Debug, Clone, Serialize)]
pub struct WholePath {
    /// The methods, in the order of the study.
    pub methods: Vec<MethodAlongPath>,
    /// Distribution of the largest distance from the path; `None` where inputs are taken as exact, or the machine is at none of its points.
    pub spread: Option<PathSpread>,
    /// Estimates of the largest distance in each draw without and with compensation, mm, infinite without equilibrium: those of the first draws, as far
    /// as they are known at all points.
    pub draws: [Vec<f64>; 2],
}

/// Results of a path study, held in memory at once.
#[derive(Debug, Clone, Serialize)]
pub struct PathResults {
    /// The study, with γ applied if it was sought.
    #[serde(skip)]
    pub study: PathStudy,
    /// Effects of the sources at all points.
    pub whole: PathPart,
    /// The methods, in the order of the study.
    pub methods: Vec<MethodAlongPath>,
    /// As in [`WholePath`].
    pub spread: Option<PathSpread>,
}

/// Runs the study on the current rayon pool, after the search for γ if there is one. `Err` as [`PathStudy::with_gamma`].
pub fn run(study: &PathStudy, work: &Work) -> Result<PathResults> {
    let at_gamma = study.with_gamma(work)?;
    let study = at_gamma.as_ref();
    let mut whole = PathPart::empty(&study.machine);
    let WholePath { methods, spread, .. } = run_in_parts(study, work, |part| {
        part.sources.map(|source, next| whole.sources[source].extend(next));
        Ok(())
    })?;
    Ok(PathResults { whole, methods, spread, study: study.clone() })
}

/// Runs a study returned by [`PathStudy::with_gamma`]; hands its points to `take` part by part, and returns what holds for all of them.
/// `Err` if `work` was stopped or could not be kept, and that of `take`.
pub fn run_in_parts(
    study: &PathStudy,
    work: &Work,
    take: impl FnMut(PathPart) -> Result<()> + Send,
) -> Result<WholePath> {
    let machines = study.machines()?;
    let (drawn, passes) = (study.drawn(&machines)?, study.passes());
    let spread_path = drawn.as_ref().map(|drawn| SpreadPath { passes: &passes, ..study.spread(drawn) });
    let mut largest = LargestBoth::default();
    let mut methods = vec![PathSums::default(); study.methods.len()];
    let (mut before, mut reversals): (Option<Configuration>, _) = (None, Reversals::default());
    let compute = |points: Range<usize>| {
        let track = TrackBlocks::new(&machines.nominal, before.as_ref(), &study.tasks[points.clone()]);
        before = track.last().or(before.take());
        let (mut part, residuals) = compute_part(study, &machines, &track, points.clone(), work)?;
        part.note_reversals(&mut reversals);
        if let Some(spread_path) = &spread_path {
            let own = study.spread_part(points, &track);
            part.set_spread(spread_path.solve_part(&own, pass_count(study), work, &mut largest)?);
        }
        let counted_before = usize::from(study.is_closed && part.first == 0);
        for (sums, residuals) in methods.iter_mut().zip(residuals) {
            residuals.iter().skip(counted_before).for_each(|residuals| sums.add(residuals));
        }
        Ok(Some(part))
    };
    compute_overlapped(along_path::parts(study.tasks.len()), compute, take)?;
    work.barrier()?;
    let of_method = |(&method, sums): (&Method, PathSums)| MethodAlongPath { method, summary: sums.summary() };
    let methods = study.methods.iter().zip(methods).map(of_method).collect();
    let each_part = spread_along::parts_of(&machines.nominal, &study.tasks, &study.drawn_forces);
    let whole =
        spread_path.as_ref().map(|path| spread_along::whole(&[(path, &*each_part)], &largest, work)).transpose()?;
    let draws = largest.each_ref().map(|own| own.sizes().to_vec());
    Ok(WholePath { methods, spread: whole.flatten(), draws })
}

/// What each method leaves at points.
type ResidualsByMethod = Vec<Vec<PointResidual>>;

/// Computes the effects of the sources at the points with these indices, in parallel on the current rayon pool. Each point is solved from
/// the one before: a range that does not begin at a multiple of 256 may differ by rounding from the whole path. `Err` if `work` was stopped
/// or could not be kept.
pub fn run_range(study: &PathStudy, points: Range<usize>, work: &Work) -> Result<PathPart> {
    let points = points.start.min(study.tasks.len())..points.end.min(study.tasks.len());
    let machines = study.machines()?;
    let passed = TrackBlocks::new(&machines.nominal, None, &study.tasks[..points.start]);
    let track = TrackBlocks::new(&machines.nominal, passed.last().as_ref(), &study.tasks[points.clone()]);
    let mut part = compute_sources(study, &machines, &track, points.clone(), work)?;
    part.note_reversals(&mut Reversals::default());
    if let Some(drawn) = study.drawn(&machines)? {
        let spread_path = SpreadPath { passes: &study.passes(), ..study.spread(&drawn) };
        let (own, mut largest) = (study.spread_part(points, &track), LargestBoth::default());
        part.set_spread(spread_path.solve_part(&own, pass_count(study), work, &mut largest)?);
    }
    work.barrier()?;
    Ok(part)
}

/// Computes the effects of the sources and the residual errors of the methods at a range of points.
fn compute_part(
    study: &PathStudy,
    machines: &Machines,
    track: &TrackBlocks<'_>,
    points: Range<usize>,
    work: &Work,
) -> Result<(PathPart, ResidualsByMethod)> {
    let first = points.start;
    let case = PathCase::new(machines, Source::All, &study.tasks[points.clone()]);
    let residuals = |(index, &method): (usize, &Method)| {
        let work = work.part(&format!("method {index}")).numbered_after(source_passes(study) + index);
        run_pieces(&case, track, first, pass_count(study), method, &work, |answer| {
            PointResidual::of(&answer, &study.machine)
        })
    };
    let (part, residuals) = rayon::join(
        || compute_sources(study, machines, track, points, work),
        || study.methods.par_iter().enumerate().map(residuals).collect::<Result<ResidualsByMethod>>(),
    );
    Ok((part?, residuals?))
}

/// Computes the effects of the sources at a range of points, solved from `track`, each at the nominal and at the compensated command.
fn compute_sources(
    study: &PathStudy,
    machines: &Machines,
    track: &TrackBlocks<'_>,
    points: Range<usize>,
    work: &Work,
) -> Result<PathPart> {
    let first = points.start;
    let along = |(number, &source): (usize, &Source)| -> Result<Vec<PointEffect>> {
        let tasks: Vec<TaskPoint> = study.tasks[points.clone()].iter().map(|task| source.task(task)).collect();
        let case = PathCase::new(machines, source, &tasks);
        let pass = |method, number: usize, command: &str| -> Result<Vec<PathPointResult>> {
            let work = work.part(source.label()).part(command).numbered_after(number);
            run_pieces(&case, track, first, pass_count(study), method, &work, |result| result)
        };
        let (plain, compensated) = rayon::join(
            || pass(Method::None, 2 * number, "plain"),
            || pass(Method::Direct, 2 * number + 1, "compensated"),
        );
        let effect = |(plain, answer)| PointEffect { plain, answer, spread: None };
        Ok(plain?.into_iter().zip(compensated?).map(effect).collect())
    };
    let effects: Vec<Result<Vec<PointEffect>>> = Source::of(&study.machine).par_iter().enumerate().map(along).collect();
    Ok(PathPart { first, sources: BySource::from_results(effects)? })
}

/// Returns how often [`run`] solves the path: twice for each source, once for each method, and once for uncertain inputs, if there are any.
pub fn pass_count(study: &PathStudy) -> usize {
    source_passes(study) + study.methods.len() + usize::from(study.uncertainty.is_some())
}

/// Returns how often the path is solved for the sources: without and with compensation each.
fn source_passes(study: &PathStudy) -> usize {
    2 * Source::of(&study.machine).len()
}

/// Returns the number of blocks of all passes.
pub(super) fn block_count(study: &PathStudy) -> usize {
    study.tasks.len().div_ceil(along_path::BLOCK) * pass_count(study)
}
