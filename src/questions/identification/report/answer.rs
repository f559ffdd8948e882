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
    questions::identification::{IdentificationStudy, errors_file, machine_file, run},
    simulation::SOLVED,
};

/// Name of the machine file that is left.
pub(super) const MACHINE: &str = "machine.toml";
/// Name of the process file with errors of chains.
pub(super) const ERRORS: &str = "chain_errors.toml";

/// Fits the unknowns and makes what is left.
///
/// # Errors
/// Of the work.
pub fn answer(study: &IdentificationStudy, asked: &Run<'_>) -> Result<Output> {
    let settings =
        json!({ "measurements": study.measurements.len(), "unknowns": study.unknowns.len(), "folds": study.folds });
    let found = match run(study, asked.work)? {
        Ok(found) => found,
        Err(failure) => {
            let headline = headline::failed(study, &failure);
            return Ok(Output {
                settings,
                statuses: Manifest::count([&*failure.status].into_iter()),
                is_answered: Some(false),
                tables: tables::none(),
                streamed: Default::default(),
                summary: json!({ "schema": 1, "status": failure.status, "reason": failure.reason }),
                figures: Vec::new(),
                page: Description { headline, ..page::without_answer(study) },
                bent: None,
                details: failure.reason,
                best_place: None,
            });
        }
    };
    let file = machine_file::write(study, &found);
    let errors = errors_file::write(study, &found)?;
    let mut files: Vec<OutputFile> = file.text.iter().map(|text| OutputFile::new(MACHINE, text.clone())).collect();
    files.extend(errors.iter().map(|(text, _)| OutputFile::new(ERRORS, text.clone())));
    let errors: Vec<String> = errors.map_or_else(Vec::new, |(_, names)| names);
    let report = Report { study, found: &found, file: &file, errors: &errors };
    Ok(Output {
        settings,
        statuses: Manifest::count(found.models.iter().map(|model| match &model.predicted_mm {
            Ok(_) => SOLVED,
            Err(failure) => &*failure.status,
        })),
        is_answered: Some(found.fit.is_found),
        tables: tables::tables(&report),
        streamed: (files, Vec::new()),
        summary: json(&report),
        figures: asked.drawn(|| figures(&report)),
        page: Description { headline: headline::headline(&report), ..page::page(&report) },
        bent: None,
        details: text::details(&report),
        best_place: None,
    })
}
