//! Reports of a correction table: the table for controllers, and what it leaves.

mod answer;
mod comp_file;
mod headline;
mod json;
mod page;
mod pictures;
mod tables;
mod text;

pub use answer::{CorrectionExport, CorrectionFormat, Exported, export};

use super::{CorrectionAnswer, CorrectionQuestion, ResidualPoint};
use crate::spatial::Grid;

/// Everything that is told.
struct Report<'a> {
    question: &'a CorrectionQuestion,
    answer: &'a CorrectionAnswer,
    /// Where residuals are shown.
    grid: &'a Grid,
    residuals: &'a [ResidualPoint],
    /// Formats in which the table is written.
    formats: &'a [CorrectionFormat],
}

impl Report<'_> {
    /// Nodes along x, y and z, as readers see them.
    fn size(&self) -> String {
        self.answer.table.grid.counts().map(|count| count.to_string()).join(" × ")
    }

    /// Whether the worst that was found keeps the tolerance.
    fn is_kept(&self) -> bool {
        self.answer.with_table.error_mm <= self.question.tolerance_mm
    }

    /// Largest force on the tool tip, N, as readers see it.
    fn force(&self) -> f64 {
        (self.question.largest_force_N * 10.0).round() / 10.0
    }

    fn has(&self, format: CorrectionFormat) -> bool {
        self.formats.contains(&format)
    }
}
