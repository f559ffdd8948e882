//! The first screen of a map: how far the tool moves at best and at worst, and what the drives need.

use super::summary::{Found, OfSource, Summary, is_enough};
use crate::{
    answer::{Said, source_words::acting},
    files::{
        table::{columns_of, correction_columns, kind_word},
        words::{counted, millimetres, percent},
    },
    machine::Motion,
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    questions::map::WorkspaceMapStudy,
    simulation::{ROUNDING_MM, Source},
};

/// The answer at a glance.
pub(super) fn headline(summary: &Summary, study: &WorkspaceMapStudy, text: &Said) -> Headline {
    let points = counted(study.grid.len(), "place");
    let basis = format!("{points}, {}", counted(study.phis.len(), "tool angle"));
    let all = summary.of(Source::All).filter(|all| is_enough(all.known, study.grid.len()));
    let Some((all, [least, most])) = all.and_then(|all| Some((all, all.deflection.get()?))) else {
        let known = summary.of(Source::All).map_or(0, |all| all.known);
        let sentence = match known {
            0 => format!(
                "How far the tool of the {} moves could be computed at none of the {points}.",
                study.machine.short_title()
            ),
            _ => {
                format!("How far the tool moves is known at only {known} of {points}: too few to say where it is best.")
            }
        };
        return Headline::new(sentence, basis).with_cautions(&text.cautions);
    };
    let under = acting(&study.machine, &study.errors, !study.force.is_zero());
    let [low, high] = [least, most].map(|found| millimetres(found.value, 3));
    let name = study.machine.short_title();
    let sentence = match low == high {
        true => format!("{under}, the tool of the {name} moves by {high} everywhere."),
        false => format!(
            "{under}, the tool of the {name} moves by {low} at best and {high} at worst; {} near {}.",
            kept(summary, study).unwrap_or_else(|| "cut".into()),
            least.place()
        ),
    };
    Headline::new(sentence, basis)
        .with_cautions(&text.cautions)
        .with(worst(summary, study, (least, most), &high))
        .with_all((low != high).then(|| best(study, least, &low)))
        .with_all(correction(all, study))
}

/// Where the tolerance is kept, if there is one, up to the place that is best.
fn kept(summary: &Summary, study: &WorkspaceMapStudy) -> Option<String> {
    let tolerance = study.tolerance_mm?;
    let share = summary.share_within()?;
    Some(match share {
        0.0 => format!("{tolerance} mm is kept nowhere, least missed"),
        1.0 => format!("{tolerance} mm is kept everywhere, best"),
        share => format!("{tolerance} mm is kept in {} of the box,", percent(share)),
    })
}

fn in_map(columns: impl IntoIterator<Item = String>, extreme: Extreme, value: f64) -> InTable {
    InTable::new("map.csv", columns, &[["source", Source::All.label()]], extreme, value)
}

fn worst(summary: &Summary, study: &WorkspaceMapStudy, (least, most): (Found, Found), high: &str) -> KeyNumber {
    let against = match (study.tolerance_mm, summary.share_within()) {
        (Some(tolerance), Some(share)) => {
            let kept = match share {
                0.0 => "kept nowhere".into(),
                1.0 => "kept everywhere".into(),
                share => format!("kept in {} of the box", percent(share)),
            };
            format!("tolerance {tolerance} mm: {kept}")
        }
        _ if least.value > ROUNDING_MM => format!("{:.1} times the smallest", most.value / least.value),
        _ => String::new(),
    };
    KeyNumber::new(high, format!("largest tool deflection, at {}", most.place()), against).found(in_map(
        ["deflection_mm".into()],
        Extreme::Largest,
        most.value,
    ))
}

fn best(study: &WorkspaceMapStudy, least: Found, low: &str) -> KeyNumber {
    let against = study.tolerance_mm.map_or_else(String::new, |tolerance| match least.value <= tolerance {
        true => format!("within the tolerance of {tolerance} mm"),
        false => format!("{:.1} times the tolerance of {tolerance} mm", least.value / tolerance),
    });
    KeyNumber::new(low, format!("smallest, at {}", least.place()), against).found(in_map(
        ["deflection_mm".into()],
        Extreme::Smallest,
        least.value,
    ))
}

/// The largest correction, of slides where there are both kinds of drives.
fn correction(all: &OfSource, study: &WorkspaceMapStudy) -> Option<KeyNumber> {
    let machine = &study.machine;
    let of = |kind: Motion| Some((kind, all.correction[kind as usize].get()?));
    let mut kinds = machine.drive_kinds().filter_map(of);
    let (kind, [least, most]) = kinds.next()?;
    let drives = if machine.has_mixed_drives() { kind_word(machine, kind) } else { "drive" };
    let others: String = kinds
        .map(|(other, [_, most])| format!("; {} {}", kind_word(machine, other), other.position_words(most.value)))
        .collect();
    let against = format!("{} where least is needed{others}", kind.position_words(least.value));
    let columns = columns_of(machine, kind, correction_columns(machine));
    Some(
        KeyNumber::new(
            &kind.position_words(most.value),
            format!("largest {drives} correction that keeps the tool on its path"),
            against,
        )
        .found(in_map(columns, Extreme::Largest, most.value)),
    )
}
