//! The first screen of a plan: how far the numbers will be known.

use super::{summary::Report, text};
use crate::{
    files::words::{counted, millimetres},
    page::headline::{Headline, KeyNumber},
    questions::measurement_design::MeasurementDesignStudy,
    simulation::Failure,
};

fn basis(study: &MeasurementDesignStudy) -> String {
    let made = match study.measured.len() {
        0 => String::new(),
        count => format!(", {} made before", counted(count, "measurement")),
    };
    format!("{}, {}{made}", counted(study.candidates.len(), "candidate"), counted(study.unknowns.len(), "unknown"))
}

/// The answer at a glance.
pub(super) fn headline(report: &Report<'_>) -> Headline {
    let chosen = counted(report.plan.chosen.len(), "measurement");
    let reached = text::tested_at_a_glance(report).or_else(|| text::reached(report));
    let reached = reached.map_or_else(String::new, |reached| format!(": {reached}"));
    let all = report.study.unknowns.len();
    let sentence = match report.open().len() {
        0 => format!("{chosen} will tell all {}{reached}.", counted(all, "number")),
        open => format!("{chosen} will tell {} of {}{reached}.", all - open, counted(all, "number")),
    };
    let tested = report.reached().and_then(|own| own.tested_mm);
    Headline::new(sentence, basis(report.study))
        .with_cautions(&text::open(report))
        .with_all(report.enough().map(|enough| {
            let what = "measurements are enough for the intervals wanted";
            let against = if enough == 0 { "known so well beforehand" } else { "" };
            KeyNumber::new(&enough.to_string(), what, against)
        }))
        .with_all(tested.map(|error| {
            KeyNumber::new(&millimetres(error, 4), "RMS error of the tool where it is tested", String::new())
        }))
}

/// The first screen where there is no answer.
pub(super) fn failed(study: &MeasurementDesignStudy, failure: &Failure) -> Headline {
    Headline::new(format!("Nothing could be planned: {}.", failure.reason.trim_end_matches('.')), basis(study))
}
