//! A plan in sentences, and its first screen: how far the numbers will be known.

use super::summary::Report;
use crate::{
    files::words::{counted, listed, millimetres},
    page::headline::{Headline, KeyNumber},
    questions::{
        identification::report::half_width,
        measurement_design::{MeasurementDesignStudy, Widths},
    },
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
    let reached = tested_at_a_glance(report).or_else(|| reached(report));
    let reached = reached.map_or_else(String::new, |reached| format!(": {reached}"));
    let all = report.study.unknowns.len();
    let sentence = match report.open().len() {
        0 => format!("{chosen} will identify all {}{reached}.", counted(all, "parameter")),
        open => format!("{chosen} will identify {} of {}{reached}.", all - open, counted(all, "parameter")),
    };
    let tested = report.reached().and_then(|own| own.tested_mm);
    Headline::new(sentence, basis(report.study))
        .with_cautions(&open(report))
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

/// What the plan was chosen for, where that is how well the tool is predicted.
fn tested_at_a_glance(report: &Report<'_>) -> Option<String> {
    let error = report.reached()?.tested_mm?;
    let random = report.random().and_then(|random| random.tested_mm);
    let beside = random.map_or_else(String::new, |random| format!("; with random ones, {}", millimetres(random, 4)));
    Some(format!("where it is tested, the tool is predicted to {} RMS{beside}", millimetres(error, 4)))
}

fn widest(report: &Report<'_>, widths: Option<&Widths>) -> Option<(usize, String)> {
    let (unknown, width) = widths?.widest()?;
    Some((unknown, half_width(&report.study.unknowns[unknown], width)))
}

/// How far the least known of the unknowns will be known.
fn reached(report: &Report<'_>) -> Option<String> {
    let (unknown, width) = widest(report, report.reached())?;
    let random = widest(report, report.random());
    let beside = random.map_or_else(String::new, |(_, random)| format!("; with random ones, {random}"));
    Some(format!("the least known, {}, to {width}{beside}", report.name(unknown)))
}

/// What no candidate tells, or not enough.
fn open(report: &Report<'_>) -> String {
    let (mut uninformed, mut wide) = (Vec::new(), Vec::new());
    for k in report.open() {
        if report.plan.most_information[k] == 0.0 { uninformed.push(report.name(k)) } else { wide.push(report.name(k)) }
    }
    let mut said = Vec::new();
    if !uninformed.is_empty() {
        said.push(format!(
            "No candidate measurement identifies {}: other poses, loads or readings are needed.",
            listed(&uninformed)
        ));
    }
    if !wide.is_empty() {
        said.push(format!(
            "{} will still be open: more measurements, larger forces or other readings are needed.",
            listed(&wide)
        ));
    }
    said.join(" ")
}

/// How many are enough.
pub(super) fn target(report: &Report<'_>) -> Option<String> {
    let target = report.study.target?;
    let (chosen, all) = (report.plan.chosen.len(), counted(report.study.unknowns.len(), "unknown"));
    let to = format!("a factor of {:.3}, {target} mm or {target}°", target.exp());
    Some(match report.enough() {
        Some(0) => format!("{all} known within {to} before anything is measured."),
        Some(enough) => format!("The first {enough} of {chosen} are enough to know {all} within {to}."),
        None => format!("{} are not enough to know {all} within {to}.", counted(chosen, "measurement")),
    })
}

/// Each unknown, in a line.
pub(super) fn parameters(report: &Report<'_>) -> Vec<String> {
    let Some(reached) = report.reached() else { return Vec::new() };
    let line = |(k, width): (usize, &f64)| {
        let random = report
            .random()
            .map(|random| format!(" (random: {})", half_width(&report.study.unknowns[k], random.each[k])));
        format!("{}: {}{}", report.name(k), half_width(&report.study.unknowns[k], *width), random.unwrap_or_default())
    };
    reached.each.iter().enumerate().map(line).collect()
}

/// What the tool is predicted to, where rows are tested.
pub(super) fn tested(report: &Report<'_>) -> Option<String> {
    let error = report.reached()?.tested_mm?;
    let random = report.random().and_then(|random| random.tested_mm);
    let beside = random.map_or_else(String::new, |random| format!(", with random ones {}", millimetres(random, 4)));
    Some(format!(
        "Where it is tested, the tool is predicted to {} RMS{beside}, if the model holds.",
        millimetres(error, 4)
    ))
}

/// Everything the answer says.
pub(super) fn details(report: &Report<'_>) -> String {
    let mut lines = parameters(report);
    lines.extend(tested(report));
    lines.extend(target(report));
    let open = open(report);
    if !open.is_empty() {
        lines.push(open);
    }
    lines.push("sheet.csv is for the machine: fill in what is read, and identify.".into());
    lines.join("\n")
}
