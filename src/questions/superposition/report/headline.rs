//! The first screen of a superposition study: whether the effects may be added, and what that costs.

use super::{
    quantities::{DEPARTURE, LARGEST_LOAD},
    summary::Summary,
    text::largest_words,
};
use crate::{
    answer::{Found, Tolerance},
    files::words::{counted, listed, millimetres, percent},
    page::headline::{Extreme, Headline, KeyNumber},
    questions::superposition::{
        SuperpositionStudy,
        departure::{Followed, Sum, Worst},
        safe::LargestFactor,
    },
    simulation::Source,
};

/// The answer at a glance.
pub(super) fn headline(summary: &Summary<'_>) -> Headline {
    let SuperpositionStudy { scene, grid, tolerance, .. } = summary.study;
    let places = counted(summary.points, "place");
    let basis = format!("{places}, {}", counted(scene.phis.len(), "tool angle"));
    let cautions = scene.cautions("grid point", (0..grid.len()).map(|index| grid.position(index)));
    let most = summary.largest(Sum::Superposition, Followed::Tool, &DEPARTURE);
    let (Some(most), Some(share)) = (most, summary.safe_share()) else {
        let sentence = format!("Nothing can be said about adding effects: none of the {places} was solved.");
        return Headline::new(sentence, basis).with_cautions(&cautions);
    };
    let parts: Vec<&str> = Source::parts(&scene.machine).iter().map(|source| source.words()).collect();
    let effects = listed(&parts);
    let wrong = millimetres(most.value, 4);
    let relative = most.at.relative().map_or_else(String::new, |r| format!(" ({:.1} %)", 100.0 * r));
    let verdict = match share {
        1.0 => format!("may be added: wrong by at most {wrong}{relative}, within the tolerance of {tolerance} mm."),
        0.0 => format!(
            "may not be added: nowhere is the tolerance of {tolerance} mm kept, and adding is wrong by up to {wrong}{relative}."
        ),
        share => format!(
            "may be added in {} of the box; elsewhere adding is wrong by up to {wrong}{relative}, more than the tolerance of \
             {tolerance} mm.",
            percent(share)
        ),
    };
    Headline::new(format!("The effects of {effects} {verdict}"), basis)
        .with_cautions(&cautions)
        .with(departure(Tolerance(*tolerance), most, &wrong))
        .with_all(load(summary))
}

fn departure(tolerance: Tolerance, most: &Found<Worst>, wrong: &str) -> KeyNumber {
    let what = format!("largest departure of the sum, at the tool tip, at {}", most.place());
    let rows = [["sum", Sum::Superposition.label()], ["followed", Followed::Tool.label()]];
    let found = DEPARTURE.found_in("map.csv", &rows, Extreme::Largest, most.value);
    KeyNumber::new(wrong, what, tolerance.against(most.value)).found(found)
}

/// How much the load may grow with the tolerance kept everywhere.
fn load(summary: &Summary<'_>) -> Option<KeyNumber> {
    let [least, most] = summary.loads()?;
    let end = match least.at {
        LargestFactor::BelowToLimit(_) => ", at least".to_string(),
        _ => format!("; the limit is at {}", least.place()),
    };
    let what = format!("of the load of the study keeps the tolerance everywhere{end}");
    let against = format!("up to {} × where it is best", largest_words(&most.at));
    let found = LARGEST_LOAD.found_in("safe_load.csv", &[], Extreme::Smallest, least.value);
    Some(KeyNumber::new(&format!("{:.2} ×", least.value), what, against).found(found))
}
