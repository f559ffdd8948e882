//! What the page of an identification shows.

use super::{summary::Report, text};
use crate::{
    report::page::{Description, Fact, MachineDescription, Section, TableNote},
    study::identification::IdentificationStudy,
};

/// The page without an answer.
pub(super) fn without_answer(study: &IdentificationStudy) -> Description {
    Description {
        setting: setting(study),
        ..Description::new("identification", MachineDescription::new(&study.machine))
    }
}

/// Sections, setting and tables; first screen, figures and question are added by the run.
pub(super) fn page(report: &Report<'_>) -> Description {
    let lines = text::parameters(report);
    let found = Section::new("Which numbers?", "each with its 95 % interval");
    let found = lines.iter().fold(found, |section, line| section.text(line));
    Description {
        terms: vec![
            Fact::new("95 % interval", "linear, from the scatter of the readings or the noise that was given"),
            Fact::new(
                "Not identified",
                "the interval is wider than a factor of e, a millimetre or a degree either way: other values fit as well",
            ),
            Fact::new("Left out", "predicted without its own measurement, by the linear equations of the fit"),
        ],
        sections: vec![
            found.figures(&["answer"]).tables(["parameters.csv", "correlations.csv"]),
            Section::new("What is open?", "and what to measure next").text(&text::open(report)).tables(["open.csv"]),
            Section::new("Does the model hold?", "what is left, and what other unknowns would do")
                .text(&text::models(report))
                .figures(&["predicted", "residuals"])
                .tables(["models.csv", "residuals.csv"]),
        ],
        tables: vec![
            TableNote::new("parameters.csv", "The unknowns: value, interval, and what hinders."),
            TableNote::new("correlations.csv", "Correlations of the unknowns."),
            TableNote::new("open.csv", "Combinations of unknowns that the measurements leave open."),
            TableNote::new("models.csv", "Sets of unknowns by how well they predict."),
            TableNote::ranked("residuals.csv", "Readings: mm, of rotations degrees.", "residual"),
        ],
        ..without_answer(report.study)
    }
}

fn setting(study: &IdentificationStudy) -> Vec<Fact> {
    let noise = match study.noise.length {
        Some(std) => format!("{std} mm"),
        None => "told by the scatter".into(),
    };
    vec![
        Fact::new("machine", study.machine.title.clone()),
        Fact::new("measurements", study.data.clone()),
        Fact::new("noise", noise),
        Fact::new("loss", study.loss.label()),
        Fact::new("parts for prediction", study.folds.to_string()),
    ]
}
