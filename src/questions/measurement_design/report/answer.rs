//! A plan of measurements into its folder.

use std::{io::ErrorKind, path::Path};

use serde_json::json;

use super::{
    headline, page,
    pictures::figures,
    summary::{Report, json},
    tables, text,
};
use crate::{
    answer::{Output, Run},
    files::Manifest,
    input::{
        csv_rows,
        error::{Error, Result},
    },
    page::Description,
    questions::{
        Answered,
        identification::Reading,
        measurement_design::{MeasurementDesignStudy, run},
    },
    simulation::SOLVED,
};

/// What the person at the machine fills in.
const SHEET: &str = "sheet.csv";

/// Refuses to write over a sheet in which somebody has filled in what was read, or that cannot be understood.
fn refuse_to_lose_readings(sheet: &Path) -> Result<()> {
    let bytes = match std::fs::read(sheet) {
        Err(fault) if fault.kind() == ErrorKind::NotFound => return Ok(()),
        read => read.map_err(|source| Error::Read { file: sheet.to_path_buf(), source })?,
    };
    let refuse = |what: String| {
        let problem = format!(
            "{what}, and a new plan would write over it: move it to where the identification reads it, or choose another folder"
        );
        Err(Error::Argument { argument: sheet.display().to_string(), problem })
    };
    let rows = csv_rows::read(&bytes).unwrap_or_default();
    let Some((header, rows)) =
        rows.split_first().filter(|(header, _)| header.fields.iter().any(|name| name == b"pose"))
    else {
        return refuse("is no sheet as it was written".into());
    };
    let columns: Vec<Reading> = Reading::all_to_come();
    let is_reading = |i: usize| {
        let is = |name: &[u8]| name.starts_with(b"gauge") || columns.iter().any(|own| own.column.as_bytes() == name);
        header.fields.get(i).is_some_and(is)
    };
    let is_filled =
        |row: &csv_rows::Row| row.fields.iter().enumerate().any(|(i, cell)| is_reading(i) && !cell.is_empty());
    match rows.iter().find(|row| is_filled(row)) {
        None => Ok(()),
        Some(row) => refuse(format!("has readings from line {} on", csv_rows::line_number(&bytes, row.span.start))),
    }
}

impl Answered for MeasurementDesignStudy {
    fn answer(&self, (): &(), asked: &Run<'_>) -> Result<Output> {
        refuse_to_lose_readings(&asked.out.join(SHEET))?;
        let settings = json!({
            "candidates": self.candidates.len(), "unknowns": self.unknowns.len(), "count": self.count, "draws": self.draws
        });
        let plan = match run(self, asked.work)? {
            Ok(plan) => plan,
            Err(failure) => {
                let headline = headline::failed(self, &failure);
                let page = Description { headline, ..page::without_answer(self) };
                return Ok(Output { tables: tables::none(self), ..Output::failed(settings, failure, page) });
            }
        };
        let report = Report { study: self, plan: &plan };
        let failed = plan.failures.iter().map(|(_, failure)| &*failure.status);
        let solved = std::iter::repeat_n(SOLVED, self.candidates.len() - plan.failures.len());
        Ok(Output {
            is_answered: Some(!plan.chosen.is_empty()),
            tables: tables::tables(&report),
            figures: asked.drawn(|| figures(&report)),
            details: text::details(&report),
            ..Output::of(
                settings,
                Manifest::count(solved.chain(failed)),
                json(&report),
                Description { headline: headline::headline(&report), ..page::page(&report) },
            )
        })
    }
}
