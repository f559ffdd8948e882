//! A plan of measurements into its folder.

use std::path::Path;

use serde_json::json;

use super::{
    headline, page,
    pictures::figures,
    summary::{Report, json},
    tables, text,
};
use crate::{
    input::{
        csv_rows,
        error::{Error, Result},
    },
    report::{Manifest, Output, Run, page::Description},
    study::{
        SOLVED,
        measurement_design::{MeasurementDesignStudy, run},
    },
};

/// What the person at the machine fills in.
const SHEET: &str = "sheet.csv";

/// Refuses to write over a sheet in which somebody has filled in what was read.
fn refuse_to_lose_readings(study: &MeasurementDesignStudy, sheet: &Path) -> Result<()> {
    let Ok(bytes) = std::fs::read(sheet) else { return Ok(()) };
    let Ok(rows) = csv_rows::read(&bytes) else { return Ok(()) };
    let Some((header, rows)) = rows.split_first() else { return Ok(()) };
    let columns = study.candidates.first().map_or(&[][..], |own| &own.readings);
    let is_reading =
        |i: usize| header.fields.get(i).is_some_and(|name| columns.iter().any(|own| own.column.as_bytes() == name));
    let is_filled =
        |row: &csv_rows::Row| row.fields.iter().enumerate().any(|(i, cell)| is_reading(i) && !cell.is_empty());
    match rows.iter().find(|row| is_filled(row)) {
        None => Ok(()),
        Some(row) => Err(Error::Argument {
            argument: sheet.display().to_string(),
            problem: format!(
                "has readings from line {} on, which a new plan would write over: move it to where the identification reads it, or \
                 choose another folder",
                csv_rows::line_number(&bytes, row.span.start)
            ),
        }),
    }
}

/// Chooses the measurements and makes what is left.
///
/// # Errors
/// Of the work.
pub fn answer(study: &MeasurementDesignStudy, asked: &Run<'_>) -> Result<Output> {
    refuse_to_lose_readings(study, &asked.out.join(SHEET))?;
    let settings = json!({
        "candidates": study.candidates.len(), "unknowns": study.unknowns.len(), "count": study.count, "draws": study.draws
    });
    let plan = match run(study, asked.work)? {
        Ok(plan) => plan,
        Err(failure) => {
            let headline = headline::failed(study, &failure);
            return Ok(Output {
                settings,
                statuses: Manifest::count([&*failure.status].into_iter()),
                is_answered: Some(false),
                tables: tables::none(study),
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
    let report = Report { study, plan: &plan };
    let failed = plan.failures.iter().map(|(_, failure)| &*failure.status);
    let solved = std::iter::repeat_n(SOLVED, study.candidates.len() - plan.failures.len());
    Ok(Output {
        settings,
        statuses: Manifest::count(solved.chain(failed)),
        is_answered: Some(!plan.chosen.is_empty()),
        tables: tables::tables(&report),
        streamed: Default::default(),
        summary: json(&report),
        figures: asked.drawn(|| figures(&report)),
        page: Description { headline: headline::headline(&report), ..page::page(&report) },
        bent: None,
        details: text::details(&report),
        best_place: None,
    })
}
