//! The lines of a program in which the tool is off farthest.

use crate::products::program::ProgramJob;

/// Lines of a program that are shown.
pub(super) const LINES: usize = 10;

/// A line of a program.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstLine {
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
