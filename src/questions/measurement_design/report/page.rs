//! What the page of a plan shows.

use super::{sheet::sheet, summary::Report, text};
use crate::{
    files::exchange::Cell,
    page::{
        Better, Column, Description, Explorer, Fact, Group, GroupValue, MachineDescription, Quantity, Section, Shape,
        SmallTable, TableNote,
    },
    questions::{
        identification::Unknown,
        measurement_design::{CriterionSpec, MeasurementDesignStudy},
    },
};

/// The page without an answer.
pub(super) fn without_answer(study: &MeasurementDesignStudy) -> Description {
    Description {
        setting: setting(study),
        ..Description::new("measurement_design", MachineDescription::new(&study.machine))
    }
}

/// Sections, setting and tables; first screen, figures and question are added by the run.
pub(super) fn page(report: &Report<'_>) -> Description {
    let lines = text::parameters(report).into_iter().chain(text::tested(report)).chain(text::target(report));
    let known = Section::new("How far will the numbers be known?", "half 95 % intervals, if the model holds");
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
            Section::new("What to measure", "that which tells most first; print this, and fill in what is read")
                .small_tables([printed(report)])
                .tables(["sheet.csv", "chosen.csv"]),
            known.explorers([WIDTHS]).figures(&["answer"]).tables(["widths.csv"]),
            Section::new("What was there to choose from?", "every candidate, with its order where it was chosen")
                .tables(["candidates.csv"]),
        ],
        explorers: vec![widths(report.study)],
        tables: vec![
            TableNote::new("chosen.csv", "The measurements, that which tells most first."),
            TableNote::new("sheet.csv", "The same to be filled in, in the columns of an identification."),
            TableNote::new("widths.csv", "Half intervals with more and more measurements."),
            TableNote::new("candidates.csv", "Everything there was to choose from."),
        ],
        ..without_answer(report.study)
    }
}

/// Title of the view of the intervals.
const WIDTHS: &str = "Half intervals by the number of measurements";

fn widths(study: &MeasurementDesignStudy) -> Explorer {
    let value = |unknown: &Unknown| GroupValue { cells: vec![unknown.name.clone()], label: unknown.name.clone() };
    let quantity = |column: &str, label: &str| Quantity::new([column], label, "", Better::Smaller);
    Explorer {
        title: WIDTHS.into(),
        table: "widths.csv".into(),
        shape: Shape::Curve,
        coordinates: vec![Column::new("measurements", "measurements", "")],
        group: Some(Group {
            columns: vec!["parameter".into()],
            label: "number".into(),
            values: study.unknowns.iter().map(value).collect(),
        }),
        quantities: vec![
            quantity("half_width", "half interval, chosen"),
            quantity("random_half_width", "half interval, random (median)"),
        ],
        marks: Vec::new(),
    }
}

/// The sheet, for printing.
fn printed(report: &Report<'_>) -> SmallTable {
    let sheet = sheet(report);
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
