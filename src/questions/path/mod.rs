//! A path study: what each source of error does along a path, what must be commanded instead, and what each method costs
//! and leaves.

#[cfg(feature = "report")]
pub mod report;
pub(crate) mod resolve;
pub(crate) mod spec;
#[cfg_attr(target_family = "wasm", path = "not_turned.rs")]
mod turned;

use std::ops::Range;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

use crate::{
    compensation::{Method, TaskPoint},
    input::error::Result,
    machine::{ChainError, Configuration, Machine},
    simulation::{
        BySource, Machines, Source,
        along_path::{self, Left, PathAnswer, PathCase, PathSummary, PathSums, TrackBlocks, kept},
    },
    work::{Work, overlapped},
};

pub use turned::PathTurn;

/// A point of the path as tables and figures show it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Station {
    /// Length of the path up to here, mm.
    pub arc_length_mm: f64,
    /// Tool angle φ: heading less a quarter turn, degrees in [0, 360); `None` where the path does not move in the plane.
    pub phi_deg: Option<f64>,
    /// Whether the tool cuts on the way here.
    pub cutting: bool,
    /// Line of the program that leads here, from 1; `None` of a path that is in no file.
    #[serde(skip)]
    pub line: Option<usize>,
    /// The number of the file it is in: 0 is that of the path, then come [`PathStudy::called_files`].
    #[serde(skip)]
    pub file: usize,
}

/// A checked path study.
#[derive(Debug, Clone)]
pub struct PathStudy {
    /// The nominal machine.
    pub machine: Machine,
    /// Errors of each chain of the real machine.
    pub errors: Vec<ChainError>,
    /// The path's points.
    pub stations: Vec<Station>,
    /// What is wanted at each, under load.
    pub tasks: Vec<TaskPoint>,
    /// How far the tool may be from its path, mm, if the process says it.
    pub tolerance_mm: Option<f64>,
    /// Methods compared.
    pub methods: Vec<Method>,
    /// Whether the path is that of a file and its last point is the first once more, so that it is counted only once in what
    /// methods leave. Circles count their closing point.
    pub is_closed: bool,
    /// Where the workpiece stands and what is cut: [`Process::facts`](crate::process::Process::facts).
    pub facts: Vec<(&'static str, String)>,
    /// What of them nobody may have meant: [`Process::assumed`](crate::process::Process::assumed).
    pub assumed: Vec<(&'static str, String)>,
    /// The turn about the tool's axis, if it is sought; see [`PathStudy::turned`].
    pub turn: Option<PathTurn>,
    /// The names of the files that its program calls.
    pub called_files: Vec<String>,
}

/// What pages of a path say of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shown {
    /// Whether the path is a circle, so that φ runs along it once.
    pub is_circle: bool,
}

impl PathStudy {
    /// Length of the path, mm.
    pub fn length_mm(&self) -> f64 {
        self.stations.last().map_or(0.0, |station| station.arc_length_mm)
    }

    /// Positions of P at each point of the path, O axes, mm.
    pub fn positions(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.tasks.iter().map(|task| task.pose.translation)
    }

    /// Where the compensated point should be at each point of the path, O axes, mm.
    pub fn wanted(&self) -> Vec<Vector3<f64>> {
        self.tasks.iter().map(|task| task.pose.transform(task.offset(&self.machine))).collect()
    }
}

/// What a source does at a point of the path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AtPoint {
    /// At the nominal command.
    pub plain: PathAnswer,
    /// At the compensated command, whether it succeeds or not.
    pub answer: PathAnswer,
}

impl AtPoint {
    /// Displacement of the compensated point at the nominal command, O axes, mm; `None` where there is no equilibrium.
    pub fn displacement(&self) -> Option<Vector3<f64>> {
        self.plain.settled_error()
    }

    /// The compensated command, if it succeeds.
    pub fn compensated(&self) -> Option<&PathAnswer> {
        Some(&self.answer).filter(|answer| answer.status.is_success())
    }
}

/// Points of a path that follow one another, and what the sources do there. Points have the indices of the whole path.
#[derive(Debug, Clone, Serialize)]
pub struct PathPart {
    /// The first of them.
    pub first: usize,
    /// What each source does at each.
    pub sources: BySource<Vec<AtPoint>>,
}

impl PathPart {
    /// No points yet, the first of a path of `machine`.
    pub(crate) fn empty(machine: &Machine) -> Self {
        Self { first: 0, sources: BySource::of(machine, |_| Vec::new()) }
    }

    /// Indices of the points.
    pub fn points(&self) -> Range<usize> {
        self.first..self.first + self.sources[Source::All].len()
    }

    /// What a source does at a point.
    pub fn at(&self, source: Source, point: usize) -> &AtPoint {
        &self.sources[source][point - self.first]
    }

    /// As [`AtPoint::displacement`], of a source at a point.
    pub fn displacement(&self, source: Source, point: usize) -> Option<Vector3<f64>> {
        self.at(source, point).displacement()
    }

    /// How far P is commanded from where it should be to put both sources right, O axes, mm.
    pub fn command_shift(&self, study: &PathStudy, point: usize) -> Option<Vector3<f64>> {
        let target = self.at(Source::All, point).compensated()?.target?;
        Some(target.translation - study.tasks[point].pose.translation)
    }
}

/// A method along the path, both sources.
#[derive(Debug, Clone, Serialize)]
pub struct MethodAlongPath {
    /// Which.
    pub method: Method,
    /// What it leaves.
    pub summary: PathSummary,
}

/// Results of a path study, all at once.
#[derive(Debug, Clone, Serialize)]
pub struct PathResults {
    /// The study.
    #[serde(skip)]
    pub study: PathStudy,
    /// All points.
    pub whole: PathPart,
    /// In the order of the study.
    pub methods: Vec<MethodAlongPath>,
}

/// Runs the study on the current rayon pool; the path is turned first, if that is sought.
///
/// # Errors
/// As [`PathStudy::turned`].
pub fn run(study: &PathStudy, work: &Work) -> Result<PathResults> {
    let turned = study.turned(work)?;
    let study = turned.as_ref();
    let mut whole = PathPart::empty(&study.machine);
    let methods = run_in_parts(study, work, |part| {
        part.sources.map(|source, next| whole.sources[source].extend(next));
        Ok(())
    })?;
    Ok(PathResults { whole, methods, study: study.clone() })
}

/// As [`run`] of a study that has been [turned](PathStudy::turned), but gives the points to `take` part by part, in the order of the path, so that memory does not grow with it.
/// The next part is computed meanwhile. What the methods leave, in the order of the study.
///
/// # Errors
/// Of `work` and of `take`.
pub fn run_in_parts(
    study: &PathStudy,
    work: &Work,
    take: impl FnMut(PathPart) -> Result<()> + Send,
) -> Result<Vec<MethodAlongPath>> {
    let machines = Machines::new(&study.machine, &study.errors)?;
    let mut methods = vec![PathSums::default(); study.methods.len()];
    let mut before: Option<Configuration> = None;
    let compute = |points: Range<usize>| {
        let track = TrackBlocks::new(&machines.nominal, before.as_ref(), &study.tasks[points.clone()]);
        before = track.last().or(before.take());
        let (next, left) = part(study, &machines, &track, points, work)?;
        let counted_before = usize::from(study.is_closed && next.first == 0);
        for (sums, left) in methods.iter_mut().zip(left) {
            left.iter().skip(counted_before).for_each(|left| sums.add(left));
        }
        Ok(Some(next))
    };
    overlapped(along_path::parts(study.tasks.len()), compute, take)?;
    work.barrier()?;
    let along = |(&method, sums): (&Method, PathSums)| MethodAlongPath { method, summary: sums.summary() };
    Ok(study.methods.iter().zip(methods).map(along).collect())
}

/// What each method leaves at points.
type LeftByMethods = Vec<Vec<Left>>;

/// What the sources do at the points with these indices, in parallel on the current rayon pool. Each is solved from the one
/// before: a range that does not begin at a multiple of 256 may differ by rounding from the same points of the whole path.
///
/// # Errors
/// Of `work`.
pub fn run_range(study: &PathStudy, points: Range<usize>, work: &Work) -> Result<PathPart> {
    let points = points.start.min(study.tasks.len())..points.end.min(study.tasks.len());
    let machines = Machines::new(&study.machine, &study.errors)?;
    let passed = TrackBlocks::new(&machines.nominal, None, &study.tasks[..points.start]);
    let track = TrackBlocks::new(&machines.nominal, passed.last().as_ref(), &study.tasks[points.clone()]);
    let part = sources(study, &machines, &track, points, work)?;
    work.barrier()?;
    Ok(part)
}

fn part(
    study: &PathStudy,
    machines: &Machines,
    track: &TrackBlocks<'_>,
    points: Range<usize>,
    work: &Work,
) -> Result<(PathPart, LeftByMethods)> {
    let first = points.start;
    let case = PathCase::new(machines, Source::All, &study.tasks[points.clone()]);
    let left = |(index, &method): (usize, &Method)| {
        let work = work.part(&format!("method {index}")).after(passes_of_sources(study) + index);
        kept(&case, track, (first, passes(study)), method, &work, |answer| Left::of(&answer, &study.machine))
    };
    let (part, left) = rayon::join(
        || sources(study, machines, track, points, work),
        || study.methods.par_iter().enumerate().map(left).collect::<Result<LeftByMethods>>(),
    );
    Ok((part?, left?))
}

fn sources(
    study: &PathStudy,
    machines: &Machines,
    track: &TrackBlocks<'_>,
    points: Range<usize>,
    work: &Work,
) -> Result<PathPart> {
    let first = points.start;
    let along = |(number, &source): (usize, &Source)| -> Result<Vec<AtPoint>> {
        let tasks: Vec<TaskPoint> = study.tasks[points.clone()].iter().map(|task| source.task(task)).collect();
        let case = PathCase::new(machines, source, &tasks);
        let pass = |method, number: usize, command: &str| -> Result<Vec<PathAnswer>> {
            let work = work.part(source.label()).part(command).after(number);
            kept(&case, track, (first, passes(study)), method, &work, |answer| answer)
        };
        let (plain, compensated) = rayon::join(
            || pass(Method::None, 2 * number, "plain"),
            || pass(Method::Direct, 2 * number + 1, "compensated"),
        );
        Ok(plain?.into_iter().zip(compensated?).map(|(plain, answer)| AtPoint { plain, answer }).collect())
    };
    let answers: Vec<Result<Vec<AtPoint>>> = Source::of(&study.machine).par_iter().enumerate().map(along).collect();
    Ok(PathPart { first, sources: BySource::answered(answers)? })
}

/// Passes over the path that [`run`] makes: each source twice, and each method.
pub fn passes(study: &PathStudy) -> usize {
    passes_of_sources(study) + study.methods.len()
}

fn passes_of_sources(study: &PathStudy) -> usize {
    2 * Source::of(&study.machine).len()
}

/// Blocks of all passes.
pub(super) fn blocks(study: &PathStudy) -> usize {
    study.tasks.len().div_ceil(along_path::BLOCK) * passes(study)
}
