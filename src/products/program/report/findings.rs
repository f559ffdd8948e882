//! What the report of a program says of its points, gathered part by part: memory does not grow with the program, but for the few
//! points at which it is drawn.

use nalgebra::Vector3;

use super::{WorstLine, lines::WorstLines};
use crate::{
    answer::ShareWithin,
    compensation::Demand,
    input::error::Result,
    products::program::{ProgramJob, ProvedPart},
    questions::path::report::{Curve, cutting_force::ForceCurves, drawn},
    simulation::{BySource, Source, along_path::PathAnswer},
};

/// The point farthest from the path without compensation, of those that count.
#[derive(Debug, Clone)]
pub(super) struct Worst {
    /// Its index.
    pub point: usize,
    /// How far, mm.
    pub size_mm: f64,
    /// Where it should be and its displacement, base axes, mm.
    pub wanted: Vector3<f64>,
    pub error: Vector3<f64>,
    /// How far each source moves the tool there, mm.
    pub by_source: BySource<Option<f64>>,
}

/// A point at which the path is drawn, base axes, mm.
#[derive(Debug, Clone)]
pub(super) struct Drawn {
    pub wanted: Vector3<f64>,
    /// Displacements without compensation and as written; `None` where the machine does not settle.
    pub before: Option<Vector3<f64>>,
    pub after: Option<Vector3<f64>>,
}

/// What is gathered.
#[derive(Debug)]
pub struct Findings {
    pub(super) worst: Option<Worst>,
    /// How far the cutting force alone moves the tool at most, where it counts, mm.
    pub(super) most_by_cutting_mm: f64,
    pub(super) before: ShareWithin,
    pub(super) after: ShareWithin,
    pub(super) lines: WorstLines,
    /// Indices of the points at which the path is drawn, ascending, and those seen.
    shown: Vec<usize>,
    pub(super) drawn: Vec<Drawn>,
    /// Two opposite corners of the box of all wanted positions.
    pub(super) corners: [Vector3<f64>; 2],
    pub(super) before_curves: BySource<Curve>,
    pub(super) after_curve: Curve,
    pub(super) force: ForceCurves,
}

impl Findings {
    /// For `job`, none of its points seen.
    ///
    /// # Errors
    /// As [`ProgramJob::parts`].
    pub fn new(job: &ProgramJob) -> Result<Self> {
        let count = job.path.len();
        let mut wanted = Vec::with_capacity(count);
        for part in job.parts() {
            wanted.extend(part?.demands().iter().map(|demand| wanted_by(job, demand)));
        }
        let corner = |start: f64, pick: fn(f64, f64) -> f64| {
            wanted.iter().fold(Vector3::repeat(start), |corner, at| corner.zip_map(at, pick))
        };
        Ok(Self {
            worst: None,
            most_by_cutting_mm: 0.0,
            before: ShareWithin::default(),
            after: ShareWithin::default(),
            lines: WorstLines::default(),
            corners: [corner(f64::MAX, f64::min), corner(f64::MIN, f64::max)],
            shown: drawn(&wanted),
            drawn: Vec::new(),
            before_curves: BySource::of(&job.machine, |_| Curve::new(count)),
            after_curve: Curve::new(count),
            force: ForceCurves::new(count),
        })
    }

    /// Takes the next part.
    pub fn add(&mut self, job: &ProgramJob, proved: &ProvedPart<'_>) {
        let part = proved.part;
        for (i, ((k, point), demand)) in part.range().zip(part.points).zip(part.demands()).enumerate() {
            let (before, after) = (proved.before[Source::All][i], PathAnswer::settled_error(&proved.written[i]));
            let along = point.arc_length_mm;
            for (source, curve) in self.before_curves.iter_mut() {
                proved.before[source][i].iter().for_each(|error| curve.add(k, along, error.norm()));
            }
            after.iter().for_each(|error| self.after_curve.add(k, along, error.norm()));
            self.force.add(Some(along), demand);
            if self.shown.get(self.drawn.len()) == Some(&k) {
                self.drawn.push(Drawn { wanted: wanted_by(job, demand), before, after });
            }
            if !job.counts(k) {
                continue;
            }
            let tolerance_mm = job.process.tolerance_mm.unwrap_or(f64::INFINITY);
            after.iter().for_each(|error| self.after.add(1.0, error.norm() <= tolerance_mm));
            let by_cutting = proved.before[Source::Cutting][i].map_or(0.0, |error| error.norm());
            self.most_by_cutting_mm = self.most_by_cutting_mm.max(by_cutting);
            let Some(error) = before else { continue };
            let size_mm = error.norm();
            self.before.add(1.0, size_mm <= tolerance_mm);
            self.lines.add(job, point.source.segment, size_mm, after.map(|error| error.norm()));
            if self.worst.as_ref().is_none_or(|worst| worst.size_mm < size_mm) {
                let by_source = BySource::of(&job.machine, |source| Some(proved.before[source][i]?.norm()));
                self.worst = Some(Worst { point: k, size_mm, wanted: wanted_by(job, demand), error, by_source });
            }
        }
    }

    /// The lines in which the tool is off farthest, worst first.
    pub fn worst_lines(&self, job: &ProgramJob) -> Vec<WorstLine> {
        self.lines.told(job)
    }
}

/// Where the point put right should be, base axes, mm.
fn wanted_by(job: &ProgramJob, demand: &Demand) -> Vector3<f64> {
    demand.wanted().transform(demand.offset(&job.machine))
}
