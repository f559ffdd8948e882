//! The first screen of a map: how far the tool moves at best and at worst, and what the drives need.

use super::{
    quantities::DEFLECTION,
    summary::{AtAngle, OfSource, Summary},
};
use crate::{
    answer::{Found, Quantity, Said, Tolerance, acting},
    files::{
        table::kind_word,
        words::{counted, millimetres, percent},
    },
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    questions::map::SourceEffect,
    simulation::{ROUNDING_MM, Source},
};

/// The answer at a glance.
pub(super) fn headline(summary: &Summary<'_>, text: &Said) -> Headline {
    let (scene, all) = (&summary.study.scene, summary.of(Source::All));
    let name = scene.machine.short_title();
    let points = counted(summary.study.grid.len(), "place");
    let basis = format!("{points}, {}", counted(scene.phis.len(), "tool angle"));
    let Some([least, most]) = all.of(&DEFLECTION).filter(|_| summary.is_enough(all.known)) else {
        let sentence = match all.known {
            0 => format!("How far the tool of the {name} moves could be computed at none of the {points}."),
            known => {
                format!("How far the tool moves is known at only {known} of {points}: too few to say where it is best.")
            }
        };
        return Headline::new(sentence, basis).with_cautions(&text.cautions);
    };
    let under = acting(&scene.machine, &scene.errors, !scene.force.is_zero());
    let [low, high] = [least, most].map(|found| millimetres(found.value, 3));
    let sentence = match low == high {
        true => format!("{under}, the tool of the {name} moves by {high} everywhere."),
        false => format!(
            "{under}, the tool of the {name} moves by {low} at best and {high} at worst; {} near {}.",
            kept(summary).unwrap_or_else(|| "cut".into()),
            least.place()
        ),
    };
    let best = || {
        let against = scene.tolerance_mm.map(|tolerance| Tolerance(tolerance).against(least.value)).unwrap_or_default();
        let what = format!("smallest, at {}", least.place());
        KeyNumber::new(&low, what, against).found(in_map(&DEFLECTION, Extreme::Smallest, least.value))
    };
    Headline::new(sentence, basis)
        .with_cautions(&text.cautions)
        .with(worst(summary, [least, most], &high))
        .with_all((low != high).then(best))
        .with_all(correction(all, summary))
}

/// Where the tolerance is kept, if there is one, up to the place that is best.
fn kept(summary: &Summary<'_>) -> Option<String> {
    let tolerance = summary.study.scene.tolerance_mm?;
    Some(match summary.within.get()? {
        0.0 => format!("{tolerance} mm is kept nowhere, least missed"),
        1.0 => format!("{tolerance} mm is kept everywhere, best"),
        share => format!("{tolerance} mm is kept in {} of the box,", percent(share)),
    })
}

fn in_map(quantity: &Quantity<SourceEffect>, extreme: Extreme, value: f64) -> InTable {
    quantity.found_in("map.csv", &[["source", Source::All.label()]], extreme, value)
}

fn worst(summary: &Summary<'_>, [least, most]: [&Found<AtAngle>; 2], high: &str) -> KeyNumber {
    let against = match (summary.study.scene.tolerance_mm, summary.within.get()) {
        (Some(tolerance), Some(share)) => Tolerance(tolerance).kept(&match share {
            0.0 => "nowhere".into(),
            1.0 => "everywhere".into(),
            share => format!("in {} of the box", percent(share)),
        }),
        _ if least.value > ROUNDING_MM => format!("{:.1} times the smallest", most.value / least.value),
        _ => String::new(),
    };
    let what = format!("largest tool deflection, at {}", most.place());
    KeyNumber::new(high, what, against).found(in_map(&DEFLECTION, Extreme::Largest, most.value))
}

/// The largest correction, of slides where there are both kinds of drives.
fn correction(all: &OfSource, summary: &Summary<'_>) -> Option<KeyNumber> {
    let machine = &summary.study.scene.machine;
    let mut kinds = summary.drives.corrections.iter().filter_map(|(kind, own)| Some((*kind, own, all.of(own)?)));
    let (kind, quantity, [least, most]) = kinds.next()?;
    let drives = if machine.has_mixed_drives() { kind_word(machine, kind) } else { "drive" };
    let others: String = kinds
        .map(|(other, _, [_, most])| format!("; {} {}", kind_word(machine, other), other.position_words(most.value)))
        .collect();
    let against = format!("{} where least is needed{others}", kind.position_words(least.value));
    let what = format!("largest {drives} correction that keeps the tool on its path");
    let number = KeyNumber::new(&kind.position_words(most.value), what, against);
    Some(number.found(in_map(quantity, Extreme::Largest, most.value)))
}
