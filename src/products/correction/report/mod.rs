//! Reports of a correction table: the table for controllers, and its residual errors.

mod page;
mod tables;
mod text;

use std::path::{Path, PathBuf};

use serde_json::json;

use self::{
    page::{figures, page},
    text::headline,
};
use super::{CorrectionQuestion, CorrectionResult, ResidualPoint, answer, residual_grid, residuals};
use crate::{
    answer::{Output, Run, size_text},
    figures::Colours,
    files::{
        Manifest, OutputFile, PreparedFolder,
        exchange::{Format, WrittenRows},
        lock_folder,
    },
    input::{Inputs, error::Result},
    page::{Description, PAGE, PageKind, headline::Headline},
    products::field_report::Field,
    questions::Overrides,
    spatial::Grid,
    work::Work,
};

/// Input of the reports of a correction table.
struct Report<'a> {
    question: &'a CorrectionQuestion,
    answer: &'a CorrectionResult,
    /// Grid on which residual errors are shown.
    grid: &'a Grid,
    residuals: &'a [ResidualPoint],
    /// Formats in which the table is written.
    formats: &'a [CorrectionFormat],
}

impl Report<'_> {
    /// Returns the number of nodes along x, y and z in words.
    fn size(&self) -> String {
        size_text(&self.answer.table.grid)
    }

    /// Returns whether the largest error found is within tolerance.
    fn is_within(&self) -> bool {
        self.answer.with_table.error_mm <= self.question.tolerance_mm
    }

    /// Returns what the table leaves on machines as they may be; `None` where inputs are taken as exact.
    fn field(&self) -> Option<Field<'_>> {
        let (spread, uncertainty) = self.answer.spread.as_ref().zip(self.question.uncertainty.as_ref())?;
        let (machine, corrector) = (&self.question.machine.name, format!("a table of {} points", self.size()));
        let (nominal_mm, tolerance_mm) = (self.answer.with_table.error_mm, Some(self.question.judged_mm));
        Some(Field { spread, uncertainty, machine, corrector, nominal_mm, tolerance_mm })
    }

    /// Returns whether the table is within tolerance with nominal numbers, and not probably worse than none.
    fn is_answered(&self) -> bool {
        self.is_within() && !self.field().is_some_and(|field| field.is_probably_worse())
    }

    /// Returns the largest force on the tool tip, N, rounded for readers.
    fn force(&self) -> f64 {
        (self.question.largest_force_N * 10.0).round() / 10.0
    }

    /// Returns whether the table is written in this format.
    fn has(&self, format: CorrectionFormat) -> bool {
        self.formats.contains(&format)
    }
}

/// A file format of a correction table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CorrectionFormat {
    /// `correction.csv`.
    Csv,
    /// `correction.json`.
    Json,
    /// `joint_LABEL.comp` for each drive.
    Comp,
}

impl CorrectionFormat {
    /// All, in the order of messages.
    pub const ALL: [Self; 3] = [Self::Csv, Self::Json, Self::Comp];

    /// Returns its name on the command line.
    pub fn label(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Json => "json",
            Self::Comp => "comp",
        }
    }
}

/// Options for exporting a correction table.
#[derive(Debug, Clone)]
pub struct CorrectionExport {
    /// Formats; if empty, all that are of use for the machine.
    pub formats: Vec<CorrectionFormat>,
    /// Whether figures are drawn.
    pub figures: bool,
    /// Inputs on which the table depends: command line, machine file and process.
    pub inputs: Inputs,
}

/// Results of an export.
#[derive(Debug, Clone)]
pub struct Exported {
    /// Main sentence, numbers and cautions.
    pub headline: Headline,
    /// Full report in sentences.
    pub details: String,
    /// Whether the largest residual error is within the tolerance with nominal numbers, and the table not probably worse than none.
    pub is_within: bool,
    /// The files, manifest last.
    pub files: Vec<PathBuf>,
}

/// Finds the table of `question` and writes it with its page into the folder `out`, on the current rayon pool.
///
/// # Errors
/// As [`answer`]; a format that has no meaning for the machine; files that cannot be written, or would replace those of others.
pub fn export(question: &CorrectionQuestion, export: &CorrectionExport, out: &Path, work: &Work) -> Result<Exported> {
    let _prepared = PreparedFolder::new(out)?;
    let main = ["correction.csv", "correction.json", "residual.csv", "summary.json", "report.json", PAGE];
    Manifest::check_may_write(out, main.into_iter())?;
    let _lock = lock_folder(out)?;
    let answer = answer(question, work)?;
    let formats = formats(export, &answer)?;
    let grid = residual_grid(question, &answer.table.grid);
    let residuals = residuals(question, &answer, &grid, work)?;
    let report = Report { question, answer: &answer, grid: &grid, residuals: &residuals, formats: &formats };
    let run = Run { out, formats: &[Format::Csv], rows: WrittenRows::default(), figures: export.figures, work };
    let mut output = output(&report, export, &run);
    let files = output.write(&run, PageKind::PLAIN, Colours::default(), &export.inputs)?;
    Ok(Exported { headline: output.page.headline, details: output.details, is_within: report.is_answered(), files })
}

/// Returns the formats asked for, or all that are of use; an error if COMP files are asked for and the machine's drives have none.
fn formats(export: &CorrectionExport, answer: &CorrectionResult) -> Result<Vec<CorrectionFormat>> {
    match &answer.per_joint {
        Err(reason) if export.formats.contains(&CorrectionFormat::Comp) => {
            Overrides::location("format").fail(format!("comp: {reason}"))
        }
        _ if export.formats.is_empty() => {
            let is_of_use =
                |format: &CorrectionFormat| *format != CorrectionFormat::Comp || answer.is_per_joint_of_use();
            Ok(CorrectionFormat::ALL.into_iter().filter(is_of_use).collect())
        }
        _ => Ok(export.formats.clone()),
    }
}

/// Returns all tables, figures and texts of the export, to be written.
fn output(report: &Report<'_>, export: &CorrectionExport, run: &Run<'_>) -> Output {
    let Report { question, answer, .. } = *report;
    let mut tables_written = vec![("residual".to_string(), tables::residuals(report))];
    tables_written.extend(answer.spread.as_ref().map(|spread| ("field".to_string(), tables::field(spread))));
    if report.has(CorrectionFormat::Csv) {
        tables_written.push(("correction".into(), tables::correction(&question.machine, &answer.table)));
    }
    let json = || format!("{:#}\n", tables::correction_json(report, &export.inputs));
    let json = report.has(CorrectionFormat::Json).then(|| OutputFile::new("correction.json", json()));
    let mut files = Vec::from_iter(json);
    if let (Ok((tables, _)), true) = (&answer.per_joint, report.has(CorrectionFormat::Comp)) {
        files.extend(tables.iter().map(tables::comp_file));
    }
    let mut summary = tables::bound_json(report);
    summary["schema"] = json!(1);
    summary["nodes"] = json!(answer.table.grid.counts());
    if let Some(field) = report.field() {
        summary["uncertainty"] = field.json();
    }
    Output {
        is_answered: Some(report.is_answered()),
        tables: tables_written,
        streamed: (files, Vec::new()),
        figures: run.draw_figures(|| figures(report)),
        details: text::details(report),
        ..Output::of(
            json!({ "nodes": answer.table.grid.counts(), "tolerance_mm": question.tolerance_mm }),
            Vec::new(),
            summary,
            Description { headline: headline(report), ..page(report) },
        )
    }
}
