//! Report of a design of measurements; refuses to overwrite a sheet that has readings.

mod summary;
mod tables;
mod text;

use std::{io::ErrorKind, path::Path};

use serde_json::json;

use self::{
    summary::Report,
    tables::{sheet, tables},
};
use crate::{
    answer::{Output, Run, machine::described},
    files::{Manifest, exchange::Cell},
    input::{
        csv_rows,
        error::{Error, Result},
    },
    page::{Better, Column, Description, Explorer, Fact, Group, Quantity, Section, SmallTable, TableNote},
    questions::{
        Answered,
        identification::Reading,
        measurement_design::{CriterionSpec, MeasurementDesignStudy, run},
    },
    simulation::SOLVED,
};

/// Name of the measurement sheet that the person at the machine fills in.
const SHEET: &str = "sheet.csv";

/// Refuses to overwrite a measurement sheet with readings in it, or a file that is no such sheet.
fn refuse_to_lose_readings(sheet: &Path) -> Result<()> {
    let bytes = match std::fs::read(sheet) {
        Err(fault) if fault.kind() == ErrorKind::NotFound => return Ok(()),
        read => read.map_err(|source| Error::Read { file: sheet.to_path_buf(), source })?,
    };
    let refuse = |what: String| {
        let problem = format!(
            "{what}, and a new plan would write over this file: move the file to where the identification reads it, or choose another folder"
        );
        Err(Error::Argument { argument: sheet.display().to_string(), problem })
    };
    let rows = csv_rows::read(&bytes).unwrap_or_default();
    let Some((header, rows)) =
        rows.split_first().filter(|(header, _)| header.fields.iter().any(|name| name == b"pose"))
    else {
        return refuse("is no measurement sheet of this program".into());
    };
    let columns: Vec<Reading> = Reading::all_planned();
    let is_reading = |i: usize| {
        let names_reading =
            |name: &[u8]| name.starts_with(b"gauge") || columns.iter().any(|reading| reading.column.as_bytes() == name);
        header.fields.get(i).is_some_and(names_reading)
    };
    let is_filled =
        |row: &csv_rows::Row| row.fields.iter().enumerate().any(|(i, cell)| is_reading(i) && !cell.is_empty());
    match rows.iter().find(|row| is_filled(row)) {
        None => Ok(()),
        Some(row) => refuse(format!("has readings from line {} on", row.line)),
    }
}

impl Answered for MeasurementDesignStudy {
    /// Runs the study, and makes tables, figures, page and summary.
    fn answer(&self, (): &(), asked: &Run<'_>) -> Result<Output> {
        refuse_to_lose_readings(&asked.out.join(SHEET))?;
        let settings = json!({
            "candidates": self.candidates.len(), "unknowns": self.unknowns.len(), "count": self.count, "draws": self.draws
        });
        let plan = match run(self, asked.work)? {
            Ok(plan) => plan,
            Err(failure) => {
                let headline = text::failed(self, &failure);
                let page = Description { headline, ..without_answer(self) };
                return Ok(Output { tables: tables(self, None), ..Output::failed(settings, failure, page) });
            }
        };
        let report = Report { study: self, plan: &plan };
        let failed = plan.failures.iter().map(|(_, failure)| &*failure.status);
        let solved = std::iter::repeat_n(SOLVED, self.candidates.len() - plan.failures.len());
        Ok(Output {
            is_answered: Some(!plan.chosen.is_empty()),
            tables: tables(self, Some(&plan)),
            figures: asked.draw_figures(|| summary::figures(&report)),
            details: text::details(&report),
            ..Output::of(
                settings,
                Manifest::count(solved.chain(failed)),
                summary::json(&report),
                Description { headline: text::headline(&report), ..page(&report) },
            )
        })
    }
}

/// Returns the page of a study without results: its name, machine and settings.
fn without_answer(study: &MeasurementDesignStudy) -> Description {
    Description { setting: setting(study), ..Description::new("measurement_design", described(&study.machine)) }
}

/// Returns sections, setting and tables of the page; first screen, figures and question are added by the run.
fn page(report: &Report<'_>) -> Description {
    let lines = text::parameter_lines(report)
        .into_iter()
        .chain(text::tested_sentence(report))
        .chain(text::target_sentence(report));
    let known = Section::new("How well will the parameters be known?", "half 95 % intervals, if the model holds");
    let known = lines.fold(known, |section, line| section.text(&line));
    Description {
        terms: vec![
            Fact::new(
                "Half interval",
                "half the 95 % interval that the noise of the readings leaves, linear, at the numbers of the machine file",
            ),
            Fact::new("Random", "as many candidates drawn by chance: the median over all draws"),
        ],
        sections: vec![
            Section::new("What to measure", "most informative measurement first; write the readings into the sheet")
                .small_tables([sheet_for_print(report)])
                .tables(["sheet.csv", "chosen.csv"]),
            known.explorers([WIDTHS]).figures(&["answer"]).tables(["widths.csv"]),
            Section::new("Which candidates were there?", "every candidate measurement, with its rank if chosen")
                .tables(["candidates.csv"]),
        ],
        explorers: vec![widths_view(report.study)],
        tables: vec![
            TableNote::new("chosen.csv", "The measurements, the most informative first."),
            TableNote::new("sheet.csv", "The same to be filled in, in the columns of an identification."),
            TableNote::new("widths.csv", "Half intervals with more and more measurements."),
            TableNote::new("candidates.csv", "All candidate measurements."),
        ],
        ..without_answer(report.study)
    }
}

/// Title of the interactive view of half intervals.
const WIDTHS: &str = "Half intervals by the number of measurements";

/// Returns the interactive view of half intervals by the number of measurements.
fn widths_view(study: &MeasurementDesignStudy) -> Explorer {
    let names = study.unknowns.iter().map(|unknown| (&unknown.name, &unknown.name));
    let group = Group::by_column("parameter", "number", names);
    let quantity = |column: &str, label: &str| Quantity::new([column], label, "", Better::Smaller);
    let quantities = vec![
        quantity("half_width", "half interval, chosen"),
        quantity("random_half_width", "half interval, random (median)"),
    ];
    let over = vec![Column::new("measurements", "measurements", "")];
    Explorer::curve(WIDTHS, "widths.csv", over, Some(group), quantities)
}

/// Returns the measurement sheet as a small table on the page, rounded for printing.
fn sheet_for_print(report: &Report<'_>) -> SmallTable {
    let sheet = sheet(report.study, report.plan);
    let shown = |cell: &Cell| match cell {
        Cell::Missing => String::new(),
        Cell::Number(number) if number.fract() != 0.0 => format!("{number:.3}"),
        Cell::Number(number) => number.to_string(),
        Cell::Count(count) => count.to_string(),
        Cell::Text(text) => text.clone(),
    };
    SmallTable {
        caption: "Measurements (sheet.csv has all digits)".into(),
        header: sheet.columns().iter().map(|column| column.name.clone()).collect(),
        rows: sheet.rows().iter().map(|row| row.iter().map(shown).collect()).collect(),
    }
}

/// Returns the facts about the study that the page lists.
fn setting(study: &MeasurementDesignStudy) -> Vec<Fact> {
    let criterion = match study.criterion {
        CriterionSpec::AllNumbers => "the region in which all numbers may be (D-optimal)".to_string(),
        CriterionSpec::Tested => format!("the error of the tool at {} tested rows", study.tested.len()),
    };
    let noise = study.noise.length.map_or_else(String::new, |std| format!("{std} mm"));
    vec![
        Fact::new("machine", study.machine.title.clone()),
        Fact::new("candidates", study.candidates.len().to_string()),
        Fact::new("made before", study.measured.len().to_string()),
        Fact::new("noise", noise),
        Fact::new("made small", criterion),
    ]
}
