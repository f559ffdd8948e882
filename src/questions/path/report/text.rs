//! What a path study says, in sentences: where the tool leaves the path how far, why, and what to command instead.

use super::{
    quantities::{DISPLACEMENT, LEFT},
    summary::Summary,
    turn_found,
};
use crate::{
    answer::{
        Quantity, Said, Tolerance, acting,
        cautions::{self, Outside},
    },
    files::{
        table::kind_word,
        text_table::text_table,
        words::{counted, if_any, listed, millimetres, millimetres_in_table},
    },
    machine::Motion,
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    questions::path::{AtPoint, MethodAlongPath, PathStudy},
    redundancy,
    simulation::{ROUNDING_MM, Source, along_path::PathSummary, program_file::place_in_words},
};

/// What `summary` of all points says.
pub fn text(summary: &Summary<'_>) -> Said {
    Said {
        cautions: cautions(summary),
        place: displacement(summary, Source::All) + &summary.within.sentence(summary.study.tolerance_mm, POINTS),
        cause: cause(summary),
        remedy: remedy(summary),
    }
}

/// A point of the path in words.
pub(super) fn place(summary: &Summary<'_>, k: usize) -> String {
    let station = &summary.study.stations[k];
    let angle = station.phi_deg.filter(|_| summary.shown.is_circle);
    let angle = angle.map(|phi| format!(" (tool angle φ = {phi:.0}°)")).unwrap_or_default();
    let of_file = |line| format!("{}, ", place_in_words(&summary.study.called_files, station.file, line));
    let line = station.line.map(of_file).unwrap_or_default();
    format!("{line}{:.1} mm along the path{angle}", station.arc_length_mm)
}

fn cautions(summary: &Summary<'_>) -> String {
    let study = summary.study;
    let failed = match summary.failed() {
        0 => String::new(),
        failed => {
            let points = counted(study.stations.len(), "point");
            format!("{failed} of {points} could not be compensated; the table of points says why.\n")
        }
    };
    let turned = turn_found(study).map_or_else(String::new, |(found, how)| redundancy::report::sentence(found, how));
    failed + &turned + &cautions_of(study)
}

/// What must be known with any answer along the path of `study`.
pub(crate) fn cautions_of(study: &PathStudy) -> String {
    cautions::of_machine(&study.machine, &study.errors, "path point", study.positions()) + &facts_text(&study.assumed)
}

fn displacement(summary: &Summary<'_>, source: Source) -> String {
    match summary.largest(source, &DISPLACEMENT).filter(|(size, _)| *size > ROUNDING_MM) {
        None => String::new(),
        Some((size, k)) => {
            let cause = source.moves(&summary.study.machine);
            format!("{cause} by up to {}, {}.\n", millimetres(size, 3), place(summary, k))
        }
    }
}

/// Of what the tolerance is met in a share.
pub(super) const POINTS: &str = "at … of the points";

/// The single sources: their largest displacements, and what each does where all together are worst.
fn cause(summary: &Summary<'_>) -> String {
    let parts = Source::parts(&summary.study.machine).iter();
    let mut text: String = parts.clone().map(|source| displacement(summary, *source)).collect();
    let peaks: Vec<usize> =
        parts.filter_map(|source| summary.largest(*source, &DISPLACEMENT)).map(|(_, k)| k).collect();
    if peaks.windows(2).any(|pair| pair[0] != pair[1]) {
        text += "These largest values lie at different points: they do not add up to that of all.\n";
    }
    let blame = summary.blame.iter();
    let blame: Vec<String> =
        blame.map(|(source, size)| format!("{} {}", source.words(), millimetres(*size, 3))).collect();
    if let Some((_, k)) = summary.farthest().filter(|_| blame.len() > 1) {
        let words: Vec<&str> = blame.iter().map(String::as_str).collect();
        text +=
            &format!("At the worst point, {}, each alone moves the tool by: {}.\n", place(summary, k), listed(&words));
    }
    text
}

fn remedy(summary: &Summary<'_>) -> String {
    let machine = &summary.study.machine;
    let largest = |quantity: &Quantity<AtPoint>| summary.largest(Source::All, quantity);
    let of = |((kind, correction), (_, force)): (&(Motion, _), &(Motion, _))| {
        let ((correction, k), (force, kf)) = (largest(correction)?, largest(force)?);
        let drives = kind_word(machine, *kind);
        let own = if machine.has_mixed_drives() { format!(" of {drives}") } else { String::new() };
        Some(format!(
            "To keep the tool on its path, correct the {drives} by up to {}, {}. Drive {}s{own} then reach {force:.0} {}, {}.\n",
            kind.position_words(correction),
            place(summary, k),
            kind.force_word(),
            kind.shown_force_unit(),
            place(summary, kf)
        ))
    };
    let mut text: String = summary.drives.corrections.iter().zip(&summary.drives.forces).filter_map(of).collect();
    if let (Some(axes), Some((left, k))) = (machine.uncontrolled_names(), largest(&LEFT)) {
        let (left, place) = (millimetres(left, 3), place(summary, k));
        text += &format!("The residual error is up to {left}, {place}: the drives do not control {axes}.\n");
    }
    text
}

/// Where the workpiece stands and what is cut, in sentences.
pub fn facts_text(facts: &[(impl AsRef<str>, String)]) -> String {
    let sentence = |(label, words): &(_, String)| {
        let (first, rest) = AsRef::<str>::as_ref(label).split_at(1);
        format!("{}{rest}: {words}.\n", first.to_uppercase())
    };
    facts.iter().map(sentence).collect()
}

/// The methods side by side.
pub(super) fn methods_text(methods: &[MethodAlongPath]) -> String {
    let mut table = text_table(["method", "steps per point", "largest error", "rms error", "failed"], 1);
    for method in methods {
        let s = &method.summary;
        table.add_row([
            method.method.label(),
            if_any(s.mean_corrections, |mean| format!("{mean:.2}")),
            if_any(s.max_mm, |max| millimetres_in_table(max, 4)),
            if_any(s.rms_mm, |rms| millimetres_in_table(rms, 4)),
            format!("{} of {}", s.failed, s.points),
        ]);
    }
    format!(
        "Methods of compensation: steps each takes per point, and how far the tool then is from the path.\n{table}\n{}",
        failures_text(methods.iter().map(|method| (method.method.label(), &method.summary)))
    )
}

/// Where commands failed: at how many points, and why at the first; nothing for those that did not.
pub fn failures_text<'a>(passes: impl Iterator<Item = (String, &'a PathSummary)>) -> String {
    let sentence = |(name, summary): (String, &PathSummary)| {
        let reason = summary.first_failure.as_ref()?;
        let points = counted(summary.points, "point");
        Some(format!("{name} fails at {} of {points}; the first: {reason}.\n", summary.failed))
    };
    passes.filter_map(sentence).collect()
}

/// The answer at a glance.
pub(super) fn headline(summary: &Summary<'_>, text: &Said) -> Headline {
    let study = summary.study;
    let basis = format!("a path of {:.1} mm, {}", study.length_mm(), counted(study.stations.len(), "point"));
    let name = study.machine.short_title();
    let Some((worst, k)) = summary.farthest() else {
        let sentence =
            format!("How far the tool of the {name} leaves the path could be computed at none of its points.");
        return Headline::new(sentence, basis).with_cautions(&text.cautions);
    };
    let has_force = study.tasks.iter().any(|task| task.load != crate::spatial::Wrench::default());
    let under = acting(&study.machine, &study.errors, has_force);
    let off = millimetres(worst, 3);
    let left = summary.largest(Source::All, &LEFT).map(|(left, _)| left);
    let then = match left {
        Some(left) if left <= ROUNDING_MM => "; compensated, it stays on the path".into(),
        Some(left) => format!("; compensated, by {}", millimetres(left, 4)),
        None => "; no compensation was found at any point".into(),
    };
    let verdict = Outside::of(&study.machine, study.positions()).verdict(&study.machine, "this path");
    let place = place(summary, k);
    let sentence = format!("{verdict}{under}, the tool of the {name} is off this path by up to {off}, {place}{then}.");
    let against = summary.within.words(study.tolerance_mm, POINTS).unwrap_or_default();
    let number = KeyNumber::new(&off, "largest distance from the path without compensation", against);
    Headline::new(sentence, basis)
        .with_cautions(&text.cautions)
        .with(number.found(in_points(&DISPLACEMENT, worst)))
        .with_all(left.map(|left| remaining(summary, left)))
        .with_all(correction(summary))
}

fn in_points(quantity: &Quantity<AtPoint>, value: f64) -> InTable {
    quantity.found_in("points.csv", &[["source", Source::All.label()]], Extreme::Largest, value)
}

/// What compensation leaves.
fn remaining(summary: &Summary<'_>, left: f64) -> KeyNumber {
    let against = summary.study.tolerance_mm.map(|tolerance| Tolerance(tolerance).against(left)).unwrap_or_default();
    let points = summary.study.stations.len();
    let what = match summary.failed() {
        0 => "largest residual error, with compensation".to_string(),
        failed => {
            format!("largest residual error at the {} of {points} points that could be compensated", points - failed)
        }
    };
    KeyNumber::new(&millimetres(left, 4), what, against).found(in_points(&LEFT, left))
}

/// The largest correction, of slides where there are both kinds of drives, and the force it is made under.
fn correction(summary: &Summary<'_>) -> Option<KeyNumber> {
    let machine = &summary.study.machine;
    let largest = |quantity: &Quantity<AtPoint>| Some(summary.largest(Source::All, quantity)?.0);
    let kinds = summary.drives.corrections.iter().zip(&summary.drives.forces);
    let mut kinds = kinds.filter_map(|((kind, own), (_, force))| Some((*kind, own, largest(own)?, largest(force)?)));
    let (kind, quantity, correction, force) = kinds.next()?;
    let drives = if machine.has_mixed_drives() { kind_word(machine, kind) } else { "drive" };
    let others: String = kinds
        .map(|(kind, _, correction, _)| format!("; {} {}", kind_word(machine, kind), kind.position_words(correction)))
        .collect();
    let against = format!("drive {}s up to {force:.0} {}{others}", kind.force_word(), kind.shown_force_unit());
    let number = KeyNumber::new(&kind.position_words(correction), format!("largest {drives} correction"), against);
    Some(number.found(in_points(quantity, correction)))
}
