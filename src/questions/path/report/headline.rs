//! The first screen of a path study: how far the tool is off, and what compensation leaves.

use super::{
    summary::{OfSource, Summary},
    text::place,
};
use crate::{
    answer::{Said, Tolerance, acting, cautions::Outside},
    files::{
        table::{columns_of, correction_columns, kind_word},
        words::{counted, millimetres, percent},
    },
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    questions::path::{PathStudy, Shown},
    simulation::{ROUNDING_MM, Source},
};

/// The answer at a glance.
pub(super) fn headline(summary: &Summary, study: &PathStudy, shown: &Shown, text: &Said) -> Headline {
    let length = study.stations.last().map_or(0.0, |station| station.arc_length_mm);
    let basis = format!("a path of {length:.1} mm, {}", counted(study.stations.len(), "point"));
    let name = study.machine.short_title();
    let found = summary.of(Source::All).and_then(|all| Some((all, all.displacement.get()?)));
    let Some((all, (worst, k))) = found else {
        let sentence =
            format!("How far the tool of the {name} leaves the path could be computed at none of its points.");
        return Headline::new(sentence, basis).with_cautions(&text.cautions);
    };
    let has_force = study.demands.iter().any(|demand| demand.load != crate::spatial::Wrench::default());
    let under = acting(&study.machine, &study.errors, has_force);
    let off = millimetres(worst, 3);
    let left = all.left.get().map(|(left, _)| left);
    let then = match left {
        Some(left) if left <= ROUNDING_MM => "; compensated, it stays on the path".into(),
        Some(left) => format!("; compensated, by {}", millimetres(left, 4)),
        None => "; no compensation was found at any point".into(),
    };
    let positions = study.demands.iter().map(|demand| demand.pose.translation);
    let verdict = Outside::of(&study.machine, positions).verdict(&study.machine, "this path");
    let place = place(study, shown, k);
    let sentence = format!("{verdict}{under}, the tool of the {name} is off this path by up to {off}, {place}{then}.");
    let against = match (study.tolerance_mm, summary.share_within()) {
        (Some(tolerance), Some(share)) => Tolerance(tolerance).kept(&format!("at {} of the points", percent(share))),
        _ => String::new(),
    };
    let number = KeyNumber::new(&off, "largest distance from the path without compensation", against);
    Headline::new(sentence, basis)
        .with_cautions(&text.cautions)
        .with(number.found(in_points(["displacement_mm".into()], worst)))
        .with_all(left.map(|left| remaining(all, study, left)))
        .with_all(correction(all, study))
}

fn in_points(columns: impl IntoIterator<Item = String>, value: f64) -> InTable {
    InTable::new("points.csv", columns, &[["source", Source::All.label()]], Extreme::Largest, value)
}

/// What compensation leaves.
fn remaining(all: &OfSource, study: &PathStudy, left: f64) -> KeyNumber {
    let against = study.tolerance_mm.map_or_else(String::new, |tolerance| match left <= tolerance {
        true => format!("within the tolerance of {tolerance} mm"),
        false => format!("more than the tolerance of {tolerance} mm"),
    });
    let points = study.stations.len();
    let what = match all.failed {
        0 => "largest distance left by compensation".to_string(),
        failed => {
            format!("largest distance left at the {} of {points} points that could be compensated", points - failed)
        }
    };
    KeyNumber::new(&millimetres(left, 4), what, against).found(in_points(["error_left_mm".into()], left))
}

/// The largest correction, of slides where there are both kinds of drives, and the force it is made under.
fn correction(all: &OfSource, study: &PathStudy) -> Option<KeyNumber> {
    let machine = &study.machine;
    let mut kinds = machine.drive_kinds().filter_map(|kind| {
        let (correction, force) = (all.correction[kind as usize].get()?.0, all.force[kind as usize].get()?.0);
        Some((kind, correction, force))
    });
    let (kind, correction, force) = kinds.next()?;
    let drives = if machine.has_mixed_drives() { kind_word(machine, kind) } else { "drive" };
    let others: String = kinds
        .map(|(kind, correction, _)| format!("; {} {}", kind_word(machine, kind), kind.position_words(correction)))
        .collect();
    let against = format!("drive {}s up to {force:.0} {}{others}", kind.force_word(), kind.shown_force_unit());
    let columns = columns_of(machine, kind, correction_columns(machine));
    let number = KeyNumber::new(&kind.position_words(correction), format!("largest {drives} correction"), against);
    Some(number.found(in_points(columns, correction)))
}
