//! What the report of a program says of its points, gathered part by part: memory does not grow with the program, but for the few
//! points at which it is drawn.

use nalgebra::Vector3;

use crate::{
    answer::{ShareWithin, cautions::Outside},
    compensation::TaskPoint,
    files::table::largest_position,
    input::error::Result,
    machine::Machine,
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
    /// Points outside the workspace box of the machine.
    pub(super) outside: Outside,
    /// Largest correction of a drive of each kind, mm and degrees, as written.
    pub(super) corrections: [Option<f64>; 2],
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
            wanted.extend(part?.tasks().iter().map(|task| wanted_by(job, task)));
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
            outside: outside_workspace(job)?,
            corrections: [None; 2],
        })
    }

    /// Takes the next part.
    pub fn add(&mut self, job: &ProgramJob, proved: &ProvedPart<'_>) {
        let part = proved.part;
        proved.written.iter().filter(|answer| answer.is_settled).for_each(|answer| self.see(&job.machine, answer));
        for (i, ((k, point), task)) in part.range().zip(part.points).zip(part.tasks()).enumerate() {
            let (before, after) = (proved.before[Source::All][i], PathAnswer::settled_error(&proved.written[i]));
            let along = point.arc_length_mm;
            for (source, curve) in self.before_curves.iter_mut() {
                proved.before[source][i].iter().for_each(|error| curve.add(k, along, error.norm()));
            }
            after.iter().for_each(|error| self.after_curve.add(k, along, error.norm()));
            self.force.add(Some(along), task);
            if self.shown.get(self.drawn.len()) == Some(&k) {
                self.drawn.push(Drawn { wanted: wanted_by(job, task), before, after });
            }
            if !job.counts(k) {
                continue;
            }
            let tolerance_mm = job.process.tolerance_mm.unwrap_or(f64::INFINITY);
            self.after.add(1.0, after.map(|error| error.norm() <= tolerance_mm));
            self.before.add(1.0, before.map(|error| error.norm() <= tolerance_mm));
            let by_cutting = proved.before[Source::Cutting][i].map_or(0.0, |error| error.norm());
            self.most_by_cutting_mm = self.most_by_cutting_mm.max(by_cutting);
            let Some(error) = before else { continue };
            let size_mm = error.norm();
            self.lines.add(job, point.source.segment, size_mm, after.map(|error| error.norm()));
            if self.worst.as_ref().is_none_or(|worst| worst.size_mm < size_mm) {
                let by_source = BySource::of(&job.machine, |source| Some(proved.before[source][i]?.norm()));
                self.worst = Some(Worst { point: k, size_mm, wanted: wanted_by(job, task), error, by_source });
            }
        }
    }

    /// The largest correction of each kind of drive, in the units of tables.
    fn see(&mut self, machine: &Machine, answer: &PathAnswer) {
        for kind in machine.drive_kinds() {
            let here = largest_position(machine, kind, &answer.delta_rho());
            let most = &mut self.corrections[kind as usize];
            *most = Some(most.map_or(here, |most| most.max(here)));
        }
    }
}

/// Where the compensated point should be, base axes, mm.
fn wanted_by(job: &ProgramJob, task: &TaskPoint) -> Vector3<f64> {
    task.wanted().transform(task.offset(&job.machine))
}

/// Which points are outside the workspace box of the machine.
///
/// # Errors
/// As [`ProgramJob::parts`].
pub fn outside_workspace(job: &ProgramJob) -> Result<Outside> {
    let mut outside = Outside::default();
    for part in job.parts() {
        part?.tasks().iter().for_each(|task| outside.add(&job.machine, task.pose.translation));
    }
    Ok(outside)
}

/// Lines of a program that are shown.
pub(super) const LINES: usize = 10;

/// A line of a program.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WorstLine {
    /// Which: "line 7", or "O100.nc line 7" of a file that the program calls.
    pub place: String,
    /// What stands there.
    pub text: String,
    /// Largest distance from the path in its move without compensation, mm.
    pub before_mm: f64,
    /// The same as written; `None` where the machine settles at none of its points.
    pub after_mm: Option<f64>,
}

/// The moves with the largest errors, gathered point by point.
#[derive(Debug, Default)]
pub(super) struct WorstLines {
    /// Worst first.
    worst: Vec<Move>,
    under_way: Option<Move>,
}

#[derive(Debug, Clone, Copy)]
struct Move {
    segment: usize,
    before_mm: f64,
    after_mm: Option<f64>,
}

impl WorstLines {
    /// Takes the next point of the path, of the move `segment`: its distances from the path.
    pub fn add(&mut self, job: &ProgramJob, segment: usize, before_mm: f64, after_mm: Option<f64>) {
        match &mut self.under_way {
            Some(own) if own.segment == segment => {
                own.before_mm = own.before_mm.max(before_mm);
                own.after_mm = own.after_mm.into_iter().chain(after_mm).reduce(f64::max);
            }
            _ => {
                self.worst = self.with_under_way(job);
                self.under_way = Some(Move { segment, before_mm, after_mm });
            }
        }
    }

    /// The moves before and the one under way; of two alike, the earlier is the worse.
    fn with_under_way(&self, job: &ProgramJob) -> Vec<Move> {
        let mut worst = self.worst.clone();
        let is_known = |own: &Move| job.file.line_of(own.segment).is_some();
        if let Some(own) = self.under_way.filter(is_known) {
            worst.insert(worst.partition_point(|other| other.before_mm >= own.before_mm), own);
            worst.truncate(LINES);
        }
        worst
    }

    /// The lines, worst first.
    pub fn told(&self, job: &ProgramJob) -> Vec<WorstLine> {
        let told = |Move { segment, before_mm, after_mm }| {
            Some(WorstLine {
                place: job.file.place_of(segment)?,
                text: job.file.text_of(segment)?,
                before_mm,
                after_mm,
            })
        };
        self.with_under_way(job).into_iter().filter_map(told).collect()
    }
}
