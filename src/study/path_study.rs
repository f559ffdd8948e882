//! A path study: what each source of error does along a path, what must be commanded instead, and what each method costs
//! and leaves.

use nalgebra::Vector3;

use super::{
    Source, Work,
    path::{PathAnswer, PathCase, PathSummary, timed},
};
use crate::{
    compensation::{Demand, Method},
    error::Result,
    machine::{ChainError, Machine},
    spatial::Wrench,
};

/// A point of the path as tables and figures show it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Length of the path up to here, mm.
    pub arc_length_mm: f64,
    /// Tool angle φ: heading less a quarter turn, degrees in [0, 360); `None` where the path does not move in the plane.
    pub phi_deg: Option<f64>,
    /// Whether the tool cuts on the way here.
    pub cutting: bool,
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
    pub demands: Vec<Demand>,
    /// Methods compared.
    pub methods: Vec<Method>,
    /// Whether the path is a circle, so that φ runs along it once.
    pub is_circle: bool,
}

/// One source of error along the path.
#[derive(Debug, Clone)]
pub struct SourceAlongPath {
    /// Which.
    pub source: Source,
    /// At the nominal command.
    pub plain: Vec<PathAnswer>,
    /// At the compensated command.
    pub compensated: Vec<PathAnswer>,
}

/// A method along the path, both sources.
#[derive(Debug, Clone)]
pub struct MethodAlongPath {
    /// Which.
    pub method: Method,
    /// What it leaves.
    pub summary: PathSummary,
    /// Points whose command failed, with reasons, or is not as good as asked.
    pub failed: usize,
    /// Time a thread needs per point, s; differs between runs.
    pub seconds_per_point: f64,
}

/// Results of a path study.
#[derive(Debug, Clone)]
pub struct PathResults {
    /// The study.
    pub study: PathStudy,
    /// In the order of [`Source::ALL`].
    pub sources: [SourceAlongPath; 3],
    /// In the order of the study.
    pub methods: Vec<MethodAlongPath>,
}

impl PathResults {
    /// Displacement of the point put right at the nominal command, O axes, mm; `None` where there is no equilibrium.
    pub fn displacement(&self, source: Source, point: usize) -> Option<Vector3<f64>> {
        let plain = &self.sources[source as usize].plain[point].compensation;
        plain.outcome.as_ref().map(|_| plain.position_error)
    }

    /// Where the point put right should be at each point of the path, O axes, mm.
    pub fn wanted(&self) -> Vec<Vector3<f64>> {
        let machine = &self.study.machine;
        self.study.demands.iter().map(|demand| demand.pose.transform(demand.offset(machine))).collect()
    }

    /// The compensated command of a point, if it succeeds.
    pub fn compensated(&self, source: Source, point: usize) -> Option<&PathAnswer> {
        let answer = &self.sources[source as usize].compensated[point];
        answer.compensation.status.is_success().then_some(answer)
    }

    /// How far P is commanded from where it should be to put both sources right, O axes, mm.
    pub fn command_shift(&self, point: usize) -> Option<Vector3<f64>> {
        let target = self.compensated(Source::Both, point)?.target?;
        Some(target.translation - self.study.demands[point].pose.translation)
    }
}

/// Runs the study on the current rayon pool.
///
/// # Errors
/// Of `work`.
pub fn run(study: &PathStudy, work: &Work) -> Result<PathResults> {
    let real = study.machine.with_errors(&study.errors);
    let unloaded: Vec<Demand> = study.demands.iter().map(|d| Demand { load: Wrench::zero(), ..*d }).collect();
    let along = |source: Source| -> Result<SourceAlongPath> {
        let (machine, demands) = match source {
            Source::Cutting => (&study.machine, &study.demands),
            Source::Assembly => (&real, &unloaded),
            Source::Both => (&real, &study.demands),
        };
        let case = PathCase { nominal: &study.machine, real: machine, demands };
        let part = |command: &str| work.part(source.label()).part(command);
        Ok(SourceAlongPath {
            source,
            plain: timed(&case, Method::None, &part("plain"))?.0,
            compensated: timed(&case, Method::Direct, &part("compensated"))?.0,
        })
    };
    let sources = [along(Source::ALL[0])?, along(Source::ALL[1])?, along(Source::ALL[2])?];
    let case = PathCase { nominal: &study.machine, real: &real, demands: &study.demands };
    let methods = study.methods.iter().enumerate().map(|(index, &method)| {
        let (answers, seconds) = timed(&case, method, &work.part(&format!("method {index}")))?;
        Ok(MethodAlongPath {
            method,
            summary: PathSummary::new(&answers),
            failed: answers.iter().filter(|a| !a.compensation.status.is_success()).count(),
            seconds_per_point: seconds / answers.len().max(1) as f64,
        })
    });
    Ok(PathResults { sources, methods: methods.collect::<Result<_>>()?, study: study.clone() })
}

/// Passes over the path that [`run`] makes: each source twice, and each method.
pub fn passes(study: &PathStudy) -> usize {
    2 * Source::ALL.len() + study.methods.len()
}
