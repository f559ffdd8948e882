//! The first screen of a path study: how far the tool is off, and what compensation leaves.

use super::{
    quantities::{DISPLACEMENT, LEFT},
    summary::Summary,
    text::{kept, place},
};
use crate::{
    answer::{Quantity, Said, Tolerance, acting, cautions::Outside},
    files::{
        table::kind_word,
        words::{counted, millimetres},
    },
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    questions::path::AtPoint,
    simulation::{ROUNDING_MM, Source},
};

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
    let has_force = study.demands.iter().any(|demand| demand.load != crate::spatial::Wrench::default());
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
    let against = kept(summary).map(|(tolerance, part)| tolerance.kept(&part)).unwrap_or_default();
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
        0 => "largest distance left by compensation".to_string(),
        failed => {
            format!("largest distance left at the {} of {points} points that could be compensated", points - failed)
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
