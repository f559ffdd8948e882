//! The first screen of an identification: what was identified, and how well it predicts.

use super::{summary::Report, text};
use crate::{
    files::words::{counted, millimetres, percent},
    page::headline::{Headline, KeyNumber},
    questions::identification::IdentificationStudy,
    simulation::Failure,
};

fn basis(study: &IdentificationStudy) -> String {
    let readings = counted(study.reading_count(), "reading");
    format!(
        "{}, {readings}, {}",
        counted(study.measurements.len(), "measurement"),
        counted(study.unknowns.len(), "unknown")
    )
}

/// The answer at a glance.
pub(super) fn headline(report: &Report<'_>) -> Headline {
    let (all, known) = (report.found.found.len(), report.known().count());
    let are = |count: usize| if count == 1 { "is" } else { "are" };
    let told = match (all - known, known) {
        _ if !report.found.fit.is_found => {
            "The search for the numbers did not end: nothing is identified; the values in parameters.csv are the best found".into()
        }
        _ if report.found.fit.is_beyond_noise => {
            "Nothing is identified: more is left of what was measured than the noise that was given explains".into()
        }
        (0, 1) => format!("The number is identified: {}", text::few(report)),
        (0, _) => format!("All {all} numbers are identified: {}", text::few(report)),
        (1, 0) if all == 1 => "The number is not identified: the measurements leave it open".into(),
        (_, 0) => format!("None of {all} numbers is identified: the measurements leave them open"),
        (open, _) => format!(
            "{known} of {all} numbers {} identified: {}; the measurements leave {open} open",
            are(known),
            text::few(report)
        ),
    };
    let predicted = report.found.models[0].predicted_mm.as_ref().ok().copied().flatten();
    let sentence = match predicted {
        Some(predicted) => format!("{told}; what was not fitted is predicted to {} RMS.", millimetres(predicted, 3)),
        None => format!("{told}."),
    };
    let share = |value: f64| {
        report.measured_mm().map_or_else(String::new, |all| format!("{} of what was measured", percent(value / all)))
    };
    Headline::new(sentence, basis(report.study))
        .with_cautions(&text::cautions(report))
        .with_all(
            report
                .left_mm()
                .map(|left| KeyNumber::new(&millimetres(left, 3), "left of what was measured, RMS", share(left))),
        )
        .with_all(predicted.map(|value| {
            let what = format!("error of what was not fitted, RMS, {} parts", report.study.folds);
            KeyNumber::new(&millimetres(value, 3), what, share(value))
        }))
        .with_all(report.left_out_mm().map(|value| {
            KeyNumber::new(&millimetres(value, 3), "error with one measurement left out, RMS", share(value))
        }))
}

/// The first screen where there is no answer.
pub(super) fn failed(study: &IdentificationStudy, failure: &Failure) -> Headline {
    Headline::new(format!("Nothing could be identified: {}.", failure.reason.trim_end_matches('.')), basis(study))
}
