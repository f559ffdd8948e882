//! The lines of a program in which the tool is off farthest.

use std::collections::BTreeMap;

use super::Proved;
use crate::study::{Source, program::ProgramJob};

/// A line of a program.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstLine {
    /// Its number, from 1.
    pub line: usize,
    /// What stands there.
    pub text: String,
    /// Largest distance from the path in its move without compensation, mm.
    pub before_mm: f64,
    /// The same as written; `None` where the machine settles at none of its points.
    pub after_mm: Option<f64>,
}

/// The `count` lines of `job` with the largest errors, worst first.
pub fn worst_lines(job: &ProgramJob, proved: &Proved<'_>, count: usize) -> Vec<WorstLine> {
    let mut moves: BTreeMap<usize, (f64, Option<f64>)> = BTreeMap::new();
    for (k, point) in job.path.points().iter().enumerate().filter(|(k, _)| job.counts(*k)) {
        let Some(Some(before)) = proved.before.of(Source::All).get(k) else { continue };
        let (most, after) = moves.entry(point.source.segment).or_default();
        *most = most.max(before.norm());
        if let Some(Some(left)) = proved.after.get(k) {
            *after = Some(after.unwrap_or(0.0).max(left.norm()));
        }
    }
    let mut worst: Vec<(usize, (f64, Option<f64>))> = moves.into_iter().collect();
    worst.sort_by(|a, b| b.1.0.total_cmp(&a.1.0).then(a.0.cmp(&b.0)));
    let told = |(segment, (before_mm, after_mm))| {
        Some(WorstLine { line: job.file.line_of(segment)?, text: job.file.text_of(segment)?, before_mm, after_mm })
    };
    worst.into_iter().filter_map(told).take(count).collect()
}
