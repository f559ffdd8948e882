//! Sentences and first screen of a measurement-design report: how well the parameters will be known.

use super::summary::Report;
use crate::{
    files::words::{counted, join_text, millimetres},
    page::headline::{Headline, KeyNumber, State, Verdict},
    questions::{
        identification::report::width_text,
        measurement_design::{HalfWidths, MeasurementDesignStudy},
    },
    simulation::Failure,
};

/// Returns what the results rest on: numbers of candidates, unknowns and measurements made already.
fn basis_text(study: &MeasurementDesignStudy) -> String {
    let made = match study.measured.len() {
        0 => String::new(),
        count => format!(", {} made before", counted(count, "measurement")),
    };
    format!("{}, {}{made}", counted(study.candidates.len(), "candidate"), counted(study.unknowns.len(), "unknown"))
}

/// Returns the first screen: main sentence, cautions and key numbers.
pub(super) fn headline(report: &Report<'_>) -> Headline {
    let chosen = counted(report.plan.chosen.len(), "measurement");
    let reached = tested_text(report).or_else(|| widest_text(report));
    let reached = reached.map_or_else(String::new, |reached| format!(": {reached}"));
    let total = report.study.unknowns.len();
    let will = match report.unidentified().len() {
        0 => format!("{chosen} will identify all {}", counted(total, "parameter")),
        open => format!("{chosen} will identify {} of {}", total - open, counted(total, "parameter")),
    };
    let details = if reached.is_empty() { String::new() } else { format!("{will}{reached}.") };
    let tested = report.final_widths().and_then(|widths| widths.tested_mm);
    let verdict = match report.unidentified().len() {
        0 => Verdict::new(State::Good, "All parameters will be identified"),
        open => Verdict::new(State::Partly, format!("{open} of {total} parameters stay unknown")),
    };
    Headline::new(will + ".", basis_text(report.study))
        .judged(verdict, false)
        .next("make the measurements of sheet.csv, and identify the machine with them.")
        .with_cautions(&details)
        .with_cautions(&open_text(report))
        .with_numbers(report.sufficient_count().map(|enough| {
            let what = "measurements are enough for the intervals wanted";
            let against = if enough == 0 { "known so well beforehand" } else { "" };
            KeyNumber::new(&enough.to_string(), what, against)
        }))
        .with_numbers(tested.map(|error| {
            KeyNumber::new(&millimetres(error, 4), "RMS error of the tool where it is tested", String::new())
        }))
}

/// Returns the first screen where nothing could be computed.
pub(super) fn failed(study: &MeasurementDesignStudy, failure: &Failure) -> Headline {
    Headline::new(format!("Nothing could be planned: {}.", failure.reason.trim_end_matches('.')), basis_text(study))
        .judged(Verdict::new(State::Bad, "Nothing could be planned"), false)
}

/// Says how well the tool will be predicted where it is tested, if that is the criterion.
fn tested_text(report: &Report<'_>) -> Option<String> {
    let error = report.final_widths()?.tested_mm?;
    let random = report.random_widths().and_then(|random| random.tested_mm);
    let beside = random.map_or_else(String::new, |random| format!("; with random ones, {}", millimetres(random, 4)));
    Some(format!("where it is tested, the tool is predicted to {} RMS{beside}", millimetres(error, 4)))
}

/// Returns the unknown with the widest interval, and its half width in words; `None` without `widths` or unknowns.
fn widest_in_text(report: &Report<'_>, widths: Option<&HalfWidths>) -> Option<(usize, String)> {
    let (unknown, width) = widths?.widest()?;
    Some((unknown, width_text(&report.study.unknowns[unknown], width)))
}

/// Says how well the least known unknown will be known; `None` without unknowns or half widths.
fn widest_text(report: &Report<'_>) -> Option<String> {
    let (unknown, width) = widest_in_text(report, report.final_widths())?;
    let random = widest_in_text(report, report.random_widths());
    let beside = random.map_or_else(String::new, |(_, random)| format!("; with random ones, {random}"));
    Some(format!("the least known, {}, to {width}{beside}", report.name(unknown)))
}

/// Names the unknowns that no candidate identifies, or not well enough.
fn open_text(report: &Report<'_>) -> String {
    let (mut uninformed, mut wide) = (Vec::new(), Vec::new());
    for k in report.unidentified() {
        if report.plan.most_information[k] == 0.0 { uninformed.push(report.name(k)) } else { wide.push(report.name(k)) }
    }
    let mut sentences = Vec::new();
    if !uninformed.is_empty() {
        sentences.push(format!(
            "No candidate measurement identifies {}: other poses, loads or readings are needed.",
            join_text(&uninformed)
        ));
    }
    if !wide.is_empty() {
        sentences.push(format!(
            "{} will still be open: more measurements, larger forces or other readings are needed.",
            join_text(&wide)
        ));
    }
    sentences.join(" ")
}

/// Says how many measurements are sufficient for the target; `None` without one.
pub(super) fn target_sentence(report: &Report<'_>) -> Option<String> {
    let target = report.study.target?;
    let (chosen, unknowns) = (report.plan.chosen.len(), counted(report.study.unknowns.len(), "unknown"));
    let accuracy = format!("a factor of {:.3}, {target} mm or {target}°", libm::exp(target));
    Some(match report.sufficient_count() {
        Some(0) => format!("{unknowns} known within {accuracy} before anything is measured."),
        Some(enough) => format!("The first {enough} of {chosen} are enough to know {unknowns} within {accuracy}."),
        None => format!("{} are not enough to know {unknowns} within {accuracy}.", counted(chosen, "measurement")),
    })
}

/// Returns a line for each unknown with its half width.
pub(super) fn parameter_lines(report: &Report<'_>) -> Vec<String> {
    let Some(reached) = report.final_widths() else { return Vec::new() };
    let line = |(k, width): (usize, &f64)| {
        let random = report
            .random_widths()
            .map(|random| format!(" (random: {})", width_text(&report.study.unknowns[k], random.each[k])));
        format!("{}: {}{}", report.name(k), width_text(&report.study.unknowns[k], *width), random.unwrap_or_default())
    };
    reached.each.iter().enumerate().map(line).collect()
}

/// Says, in a sentence of its own, how well the tool will be predicted where it is tested; `None` with another criterion.
pub(super) fn tested_sentence(report: &Report<'_>) -> Option<String> {
    let error = report.final_widths()?.tested_mm?;
    let random = report.random_widths().and_then(|random| random.tested_mm);
    let beside = random.map_or_else(String::new, |random| format!(", with random ones {}", millimetres(random, 4)));
    Some(format!(
        "Where it is tested, the tool is predicted to {} RMS{beside}, if the model holds.",
        millimetres(error, 4)
    ))
}

/// Returns all sentences of the results.
pub(super) fn details(report: &Report<'_>) -> String {
    let mut lines = parameter_lines(report);
    lines.extend(tested_sentence(report));
    lines.extend(target_sentence(report));
    let open = open_text(report);
    if !open.is_empty() {
        lines.push(open);
    }
    lines.push("Take sheet.csv to the machine, write the readings into it, and identify.".into());
    lines.join("\n")
}
