//! Report of an identification: its page, tables, figures and files.

mod pictures;
pub mod predicted;
mod summary;
mod tables;
mod text;

pub(crate) use text::{ANYTHING, width_text};

use serde_json::json;

use self::summary::Report;
use crate::{
    answer::{Output, Run, machine::described},
    files::{Manifest, OutputFile},
    input::error::Result,
    page::{Better, Column, Description, Explorer, Fact, Group, Quantity, Section, TableNote},
    questions::{
        Answered,
        identification::{
            IdentificationStudy, run,
            written_files::{write_errors, write_machine},
        },
    },
    simulation::SOLVED,
};

/// Name of the machine file that is written.
pub(super) const MACHINE: &str = "machine.toml";
/// Name of the process file with chain errors.
pub(super) const ERRORS: &str = "chain_errors.toml";

impl Answered for IdentificationStudy {
    /// Runs the study, and makes tables, figures, page and summary.
    fn answer(&self, (): &(), asked: &Run<'_>) -> Result<Output> {
        let settings =
            json!({ "measurements": self.measurements.len(), "unknowns": self.unknowns.len(), "folds": self.folds });
        let results = match run(self, asked.work)? {
            Ok(results) => results,
            Err(failure) => {
                let headline = text::failed(self, &failure);
                let page = Description { headline, ..without_answer(self) };
                return Ok(Output { tables: tables::tables(None), ..Output::failed(settings, failure, page) });
            }
        };
        let file = write_machine(self, &results);
        let errors = write_errors(self, &results)?;
        let mut files: Vec<OutputFile> = file.text.iter().map(|text| OutputFile::new(MACHINE, text.clone())).collect();
        files.extend(errors.iter().map(|(text, _)| OutputFile::new(ERRORS, text.clone())));
        let errors: Vec<String> = errors.map_or_else(Vec::new, |(_, names)| names);
        let report = Report { study: self, results: &results, file: &file, errors: &errors };
        Ok(Output {
            is_answered: Some(results.fit.is_converged),
            tables: tables::tables(Some(&report)),
            streamed: (files, Vec::new()),
            figures: asked.draw_figures(|| pictures::figures(&report)),
            details: text::details(&report),
            ..Output::of(
                settings,
                Manifest::count(results.models.iter().map(|model| match &model.predicted_mm {
                    Ok(_) => SOLVED,
                    Err(failure) => &*failure.status,
                })),
                summary::json(&report),
                Description { headline: text::headline(&report), ..page(&report) },
            )
        })
    }
}

/// Returns the page of a study without results: its name, machine and settings.
fn without_answer(study: &IdentificationStudy) -> Description {
    Description { setting: setting(study), ..Description::new("identification", described(&study.machine)) }
}

/// Returns sections, setting and tables of the page; first screen, figures and question are added by the run.
fn page(report: &Report<'_>) -> Description {
    let lines = text::parameter_text(report);
    let parameters = Section::new("Which numbers?", "each with its 95 % interval");
    let has_lengths =
        report.study.measurements.iter().flat_map(|row| &row.readings).any(|reading| !reading.quantity.is_rotation());
    let parameters = lines.iter().fold(parameters, |section, line| section.text(line));
    Description {
        terms: vec![
            Fact::new("95 % interval", "linear, from the scatter of the readings or the noise that was given"),
            Fact::new(
                "Not identified",
                "the interval is wider than a factor of e, a millimetre or a degree, or half the change of a length or angle, either way: other values fit as well",
            ),
            Fact::new(
                "Profile",
                "the interval within which the other parameters can be fitted anew with the residual growing no more than chance explains",
            ),
            Fact::new("Left out", "predicted without its own measurement, by the linear equations of the fit"),
        ],
        sections: vec![
            parameters.figures(&["answer"]).tables(["parameters.csv", "correlations.csv"]),
            Section::new("What stays unknown?", "what to measure next")
                .text(&text::unidentified_text(report))
                .tables(["open.csv"]),
            Section::new("Does the model hold?", "residuals, and what other unknowns would do")
                .text(&text::model_text(report))
                .text(&text::pattern_text(report))
                .explorers(has_lengths.then_some(RESIDUALS))
                .figures(&["predicted", "residuals"])
                .tables(["models.csv", "residuals.csv", "patterns.csv"]),
        ],
        explorers: has_lengths.then(|| residuals_view(report.study)).into_iter().collect(),
        tables: vec![
            TableNote::new("parameters.csv", "The unknowns: value, interval, and what hinders."),
            TableNote::new("correlations.csv", "Correlations of the unknowns."),
            TableNote::new(
                "covariance.csv",
                "Covariance of the identified unknowns, for [uncertainty] of other studies.",
            ),
            TableNote::new("open.csv", "Combinations of unknowns that the measurements leave open."),
            TableNote::new("patterns.csv", "Rank correlations of the residuals with order, load, direction and pose."),
            TableNote::new("models.csv", "Sets of unknowns by how well they predict."),
            TableNote::ranked("residuals.csv", "Readings: mm, of rotations degrees.", "residual"),
        ],
        ..without_answer(report.study)
    }
}

/// Title of the interactive view of residuals.
const RESIDUALS: &str = "Residuals of lengths, in the order of measuring";

/// Returns the interactive view of the residual of each measured length.
fn residuals_view(study: &IdentificationStudy) -> Explorer {
    let mut columns: Vec<&str> = Vec::new();
    let readings = study.measurements.iter().flat_map(|measurement| &measurement.readings);
    for reading in readings.filter(|reading| !reading.quantity.is_rotation()) {
        if !columns.contains(&reading.column) {
            columns.push(reading.column);
        }
    }
    let group = Group::by_column("reading", "what was read", columns.into_iter().map(|column| (column, column)));
    let quantity = |column: &str, label: &str| Quantity::new([column], label, "mm", Better::Neither);
    let quantities = vec![
        quantity("residual", "measured less predicted"),
        quantity("left_out_residual", "the same, predicted without its own measurement"),
        quantity("measured", "measured"),
        quantity("predicted", "predicted"),
    ];
    let over = vec![Column::new("order", "measurement", "")];
    Explorer::curve(RESIDUALS, "residuals.csv", over, Some(group), quantities)
}

/// Returns the facts about the study that the page lists.
fn setting(study: &IdentificationStudy) -> Vec<Fact> {
    let noise = match study.noise.length {
        Some(std) => format!("{std} mm"),
        None if study.noise.is_estimated => "estimated from the scatter".into(),
        None => "as the file of measurements says".into(),
    };
    vec![
        Fact::new("machine", study.machine.title.clone()),
        Fact::new("measurements", study.data.clone()),
        Fact::new("noise", noise),
        Fact::new("loss", study.loss.label()),
        Fact::new("parts for prediction", study.folds.to_string()),
    ]
}
