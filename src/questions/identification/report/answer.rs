//! An identification into its folder.

use serde_json::json;

use super::{
    headline, page,
    pictures::figures,
    summary::{Report, json},
    tables, text,
};
use crate::{
    answer::{Output, Run},
    files::{Manifest, OutputFile},
    input::error::Result,
    page::Description,
    questions::{
        Answered,
        identification::{IdentificationStudy, errors_file, machine_file, run},
    },
    simulation::SOLVED,
};

/// Name of the machine file that is left.
pub(super) const MACHINE: &str = "machine.toml";
/// Name of the process file with errors of chains.
pub(super) const ERRORS: &str = "chain_errors.toml";

impl Answered for IdentificationStudy {
    fn answer(&self, (): &(), asked: &Run<'_>) -> Result<Output> {
        let settings =
            json!({ "measurements": self.measurements.len(), "unknowns": self.unknowns.len(), "folds": self.folds });
        let found = match run(self, asked.work)? {
            Ok(found) => found,
            Err(failure) => {
                let headline = headline::failed(self, &failure);
                let page = Description { headline, ..page::without_answer(self) };
                return Ok(Output { tables: tables::none(), ..Output::failed(settings, failure, page) });
            }
        };
        let file = machine_file::write(self, &found);
        let errors = errors_file::write(self, &found)?;
        let mut files: Vec<OutputFile> = file.text.iter().map(|text| OutputFile::new(MACHINE, text.clone())).collect();
        files.extend(errors.iter().map(|(text, _)| OutputFile::new(ERRORS, text.clone())));
        let errors: Vec<String> = errors.map_or_else(Vec::new, |(_, names)| names);
        let report = Report { study: self, found: &found, file: &file, errors: &errors };
        Ok(Output {
            is_answered: Some(found.fit.is_found),
            tables: tables::tables(&report),
            streamed: (files, Vec::new()),
            figures: asked.drawn(|| figures(&report)),
            details: text::details(&report),
            ..Output::of(
                settings,
                Manifest::count(found.models.iter().map(|model| match &model.predicted_mm {
                    Ok(_) => SOLVED,
                    Err(failure) => &*failure.status,
                })),
                json(&report),
                Description { headline: headline::headline(&report), ..page::page(&report) },
            )
        })
    }
}
