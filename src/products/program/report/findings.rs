//! Collects what the report of a program needs from its points, part by part; memory grows with the program only by the few points drawn.

use nalgebra::Vector3;

use super::{
    machined::{Courses, Machined},
    tables::{P95_AFTER, P95_BEFORE},
};
use crate::{
    answer::{ShareWithin, cautions::OutsidePositions, clearance, drive_columns::largest_position, play::PlayCounts},
    compensation::TaskPoint,
    figures::Figure,
    files::exchange::Surface,
    input::error::Result,
    machine::Machine,
    products::program::{ProgramAsWritten, ProgramJob, VerifiedPart},
    questions::{
        path::report::{Curve, cutting_force::ForceCurves, drawn_indices},
        spread_report::SpreadCounts,
    },
    simulation::{
        BySource, Source,
        along_path::{PathPointResult, length_of_point},
        clearance::{ClearanceState, MachineCell, PathClearance},
    },
    work::Work,
};

/// The counted point with the largest error without compensation.
#[derive(Debug, Clone)]
pub(super) struct WorstPoint {
    /// Index of the point.
    pub point: usize,
    /// Size of the error, mm.
    pub size_mm: f64,
    /// Wanted position, and the error there, base axes, mm.
    pub wanted: Vector3<f64>,
    pub error: Vector3<f64>,
    /// Size of the error by each source alone, mm.
    pub by_source: BySource<Option<f64>>,
}

/// A point of the drawn path, base axes, mm.
#[derive(Debug, Clone)]
pub(super) struct DrawnPoint {
    pub wanted: Vector3<f64>,
    /// Errors without compensation and as written; `None` where the machine has no equilibrium.
    pub before: Option<Vector3<f64>>,
    pub after: Option<Vector3<f64>>,
}

/// Errors and forces along a program, collected for its report.
#[derive(Debug)]
pub struct Findings {
    pub(super) worst: Option<WorstPoint>,
    /// Largest error by the cutting force alone over the points that count, mm.
    pub(super) most_by_cutting_mm: f64,
    pub(super) before: ShareWithin,
    pub(super) after: ShareWithin,
    pub(super) lines: WorstLines,
    /// Indices of the points to draw, ascending; `drawn` has those reached so far.
    drawn_indices: Vec<usize>,
    pub(super) drawn: Vec<DrawnPoint>,
    /// Two opposite corners of the box of all wanted positions, base axes, mm.
    pub(super) corners: [Vector3<f64>; 2],
    pub(super) before_curves: BySource<Curve>,
    pub(super) after_curve: Curve,
    /// Error as written where the force is absent, and 95 % quantiles of the error without compensation and as written.
    pub(super) without_force_curve: Curve,
    pub(super) p95_curves: [Curve; 2],
    /// What is counted of the distributions of the error as written, at the points that count.
    pub(super) spread: SpreadCounts,
    /// Play of the drives as written, at the points that count.
    pub(super) play: PlayCounts,
    pub(super) force: ForceCurves,
    /// Points outside the workspace box of the machine.
    pub(super) outside: OutsidePositions,
    /// Largest drive correction as written, of prismatic joints (mm) and of revolute joints (degrees).
    pub(super) corrections: [Option<f64>; 2],
    /// Errors at all points, where stock is cut.
    courses: Option<Courses>,
    /// The surface that is left, once it was computed.
    pub(super) machined: Option<Machined>,
    /// How near bodies come, once it was looked at; `None` where the process names no cell.
    pub(super) clearance: Option<PathClearance>,
}

impl Findings {
    /// Creates empty findings for `job`.
    ///
    /// # Errors
    /// As [`ProgramJob::parts`].
    pub fn new(job: &ProgramJob) -> Result<Self> {
        let count = job.path.len();
        let mut wanted = Vec::with_capacity(count);
        for part in job.parts() {
            wanted.extend(part?.tasks().iter().map(|task| wanted_mm(job, task)));
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
            drawn_indices: drawn_indices(&wanted),
            drawn: Vec::new(),
            before_curves: BySource::of(&job.machine, |_| Curve::new(count)),
            after_curve: Curve::new(count),
            without_force_curve: Curve::new(count),
            p95_curves: [Curve::new(count), Curve::new(count)],
            spread: SpreadCounts::default(),
            play: PlayCounts::default(),
            force: ForceCurves::new(count),
            outside: outside_workspace(job)?,
            corrections: [None; 2],
            courses: Courses::new(job),
            machined: None,
            clearance: None,
        })
    }

    /// Computes the surface that is left, where the program as `written`, called `name`, cuts stock; all points were added.
    ///
    /// # Errors
    /// A field of removal too large; of `work`.
    pub fn find_machined(
        &mut self,
        job: &ProgramJob,
        written: &ProgramAsWritten,
        name: &str,
        work: &Work,
    ) -> Result<()> {
        if let Some(courses) = self.courses.take() {
            self.machined = courses.surface(job, written, name, work)?;
        }
        Ok(())
    }

    /// Looks at how near bodies come along the program.
    ///
    /// # Errors
    /// As [`ProgramJob::clearance`].
    pub fn find_clearance(&mut self, job: &ProgramJob, cell: Option<&MachineCell>, work: &Work) -> Result<()> {
        // Where tool and workpiece press on one another is about where the machine gives way most.
        let moved_mm = self.worst.as_ref().map_or(0.0, |worst| worst.size_mm);
        self.clearance = job.clearance(cell, work)?.map(|own| own.moved_by(moved_mm));
        Ok(())
    }

    /// Draws the machine where bodies come nearest; `None` where nothing was looked at.
    #[must_use]
    pub fn clearance_figure(&self, job: &ProgramJob, cell: &MachineCell) -> Option<(String, Figure)> {
        clearance::figure(cell, &job.placement, self.clearance.as_ref())
    }

    /// Returns whether bodies hit along the program.
    #[must_use]
    pub fn hits(&self) -> bool {
        self.clearance.as_ref().is_some_and(|own| own.state == ClearanceState::Hit)
    }

    /// Returns the machined surface in the form for other programs; `None` if no stock is cut.
    pub fn part(&self, job: &ProgramJob) -> Option<Surface> {
        self.machined.as_ref().map(|machined| machined.exported(job))
    }

    /// Adds the points of the next verified part.
    pub fn add(&mut self, job: &ProgramJob, verified: &VerifiedPart<'_>) {
        let part = &verified.part;
        self.courses.iter_mut().for_each(|courses| courses.add(verified));
        verified
            .written
            .iter()
            .filter(|answer| answer.is_settled)
            .for_each(|answer| self.include(&job.machine, answer));
        for (i, ((k, point), task)) in part.range().zip(part.points).zip(part.tasks()).enumerate() {
            let (before, after) =
                (verified.before[Source::All][i], PathPointResult::solved_error(&verified.written[i]));
            let along = point.arc_length_mm;
            for (source, curve) in self.before_curves.iter_mut() {
                verified.before[source][i].iter().for_each(|error| curve.add(k, along, error.norm()));
            }
            after.iter().for_each(|error| self.after_curve.add(k, along, error.norm()));
            verified.without_force[i].iter().for_each(|error| self.without_force_curve.add(k, along, error.norm()));
            let spread = verified.spread.get(i).and_then(Option::as_ref);
            for (curve, quantity) in self.p95_curves.iter_mut().zip([P95_BEFORE, P95_AFTER]) {
                spread.and_then(|at| quantity.value(at)).iter().for_each(|p95| curve.add(k, along, *p95));
            }
            self.force.add(Some(along), task);
            if self.drawn_indices.get(self.drawn.len()) == Some(&k) {
                self.drawn.push(DrawnPoint { wanted: wanted_mm(job, task), before, after });
            }
            if !job.is_counted(k) {
                continue;
            }
            spread.and_then(|at| at.compensated.as_ref()).iter().for_each(|distribution| self.spread.add(distribution));
            self.play.add(k, verified.written[i].play.as_ref(), None);
            let tolerance_mm = job.process.tolerance_mm.unwrap_or(f64::INFINITY);
            let points = job.path.points();
            let length = length_of_point(k, points.len(), |k| points[k].arc_length_mm, |k| job.is_counted(k));
            self.after.add(length, after.map(|error| error.norm() <= tolerance_mm));
            self.before.add(length, before.map(|error| error.norm() <= tolerance_mm));
            let by_cutting = verified.before[Source::Cutting][i].map_or(0.0, |error| error.norm());
            self.most_by_cutting_mm = self.most_by_cutting_mm.max(by_cutting);
            let Some(error) = before else { continue };
            let size_mm = error.norm();
            self.lines.add(job, point.source.segment, size_mm, after.map(|error| error.norm()));
            if self.worst.as_ref().is_none_or(|worst| worst.size_mm < size_mm) {
                let by_source = BySource::of(&job.machine, |source| Some(verified.before[source][i]?.norm()));
                self.worst = Some(WorstPoint { point: k, size_mm, wanted: wanted_mm(job, task), error, by_source });
            }
        }
    }

    /// Updates the largest correction of each kind of drive (mm, degrees) by those of one point.
    fn include(&mut self, machine: &Machine, result: &PathPointResult) {
        for kind in machine.drive_kinds() {
            let here = largest_position(machine, kind, &result.delta_rho());
            let most = &mut self.corrections[kind as usize];
            *most = Some(most.map_or(here, |most| most.max(here)));
        }
    }
}

/// Returns the wanted position of the compensated point, base axes, mm.
fn wanted_mm(job: &ProgramJob, task: &TaskPoint) -> Vector3<f64> {
    task.wanted().transform(task.offset(&job.machine))
}

/// Returns which points of `job` are outside the workspace box of the machine.
///
/// # Errors
/// As [`ProgramJob::parts`].
pub fn outside_workspace(job: &ProgramJob) -> Result<OutsidePositions> {
    let mut outside = OutsidePositions::default();
    for part in job.parts() {
        part?.tasks().iter().for_each(|task| outside.add(&job.machine, task.pose.translation));
    }
    Ok(outside)
}

/// Most lines of a program that are shown.
pub(super) const LINES: usize = 10;

/// A line of a program with the largest errors of its move.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WorstLine {
    /// Line in words: "line 7", or "O100.nc line 7" of a file that the program calls.
    pub place: String,
    /// Text of the line.
    pub text: String,
    /// Largest error in its move without compensation, mm.
    pub before_mm: f64,
    /// Largest error as written, mm; `None` where the machine has an equilibrium at none of its points.
    pub after_mm: Option<f64>,
}

/// Collects the moves with the largest errors, point by point.
#[derive(Debug, Default)]
pub(super) struct WorstLines {
    /// Worst first.
    worst: Vec<Move>,
    current_move: Option<Move>,
}

/// A move of the program and its largest errors, mm.
#[derive(Debug, Clone, Copy)]
struct Move {
    segment: usize,
    before_mm: f64,
    after_mm: Option<f64>,
}

impl WorstLines {
    /// Adds the next counted point, in move number `segment`, with its errors in mm.
    pub fn add(&mut self, job: &ProgramJob, segment: usize, before_mm: f64, after_mm: Option<f64>) {
        match &mut self.current_move {
            Some(current) if current.segment == segment => {
                current.before_mm = current.before_mm.max(before_mm);
                current.after_mm = current.after_mm.into_iter().chain(after_mm).reduce(f64::max);
            }
            _ => {
                self.worst = self.with_current(job);
                self.current_move = Some(Move { segment, before_mm, after_mm });
            }
        }
    }

    /// Returns the worst moves including the current one; of two equal ones, the earlier comes first.
    fn with_current(&self, job: &ProgramJob) -> Vec<Move> {
        let mut worst = self.worst.clone();
        let is_known = |candidate: &Move| job.file.line_of(candidate.segment).is_some();
        if let Some(candidate) = self.current_move.filter(is_known) {
            worst.insert(worst.partition_point(|other| other.before_mm >= candidate.before_mm), candidate);
            worst.truncate(LINES);
        }
        worst
    }

    /// Returns the lines with the largest errors, worst first.
    pub fn worst_lines(&self, job: &ProgramJob) -> Vec<WorstLine> {
        let worst_line = |Move { segment, before_mm, after_mm }| {
            Some(WorstLine {
                place: job.file.line_name(segment)?,
                text: job.file.line_text(segment)?,
                before_mm,
                after_mm,
            })
        };
        self.with_current(job).into_iter().filter_map(worst_line).collect()
    }
}
