//! The first screen of a superposition study: whether the effects may be added, and what that costs.

use super::{
    summary::{Found, Measure, Summary},
    text::{known, largest_words},
};
use crate::{
    files::words::{counted, listed, millimetres, percent, position},
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    questions::superposition::{
        SuperpositionStudy,
        departure::{Followed, Sum},
        safe::LargestFactor,
    },
    simulation::Source,
};

/// The answer at a glance.
pub(super) fn headline(study: &SuperpositionStudy, summary: &Summary) -> Headline {
    let places = counted(summary.points, "place");
    let basis = format!("{places}, {}", counted(study.scene.phis.len(), "tool angle"));
    let most = summary.largest(Sum::Superposition, Followed::Tool, Measure::Size);
    let (Some(most), Some(share)) = (most, summary.safe_share()) else {
        let sentence = format!("Nothing can be said about adding effects: none of the {places} was solved.");
        return Headline::new(sentence, basis).with_cautions(&known(study));
    };
    let parts: Vec<&str> = Source::parts(&study.scene.machine).iter().map(|source| source.words()).collect();
    let effects = listed(&parts);
    let wrong = millimetres(most.value, 4);
    let relative = most.worst.relative().map_or_else(String::new, |r| format!(" ({:.1} %)", 100.0 * r));
    let tolerance = study.tolerance;
    let verdict = match share {
        1.0 => format!(
            "The effects of {effects} may be added: wrong by at most {wrong}{relative}, within the tolerance of \
             {tolerance} mm."
        ),
        0.0 => format!(
            "The effects of {effects} may not be added: nowhere is the tolerance of {tolerance} mm kept, and adding is \
             wrong by up to {wrong}{relative}."
        ),
        share => format!(
            "The effects of {effects} may be added in {} of the box; elsewhere adding is wrong by up to {wrong}{relative}, \
             more than the tolerance of {tolerance} mm.",
            percent(share)
        ),
    };
    Headline::new(verdict, basis)
        .with_cautions(&known(study))
        .with(departure(study, most, &wrong))
        .with_all(load(summary))
}

fn departure(study: &SuperpositionStudy, most: &Found, wrong: &str) -> KeyNumber {
    let [x, y, z] = most.position_mm;
    let what = format!("largest departure of the sum, at the tool tip, at {}", position(x, y, z));
    let times = most.value / study.tolerance;
    let against = match times <= 1.0 {
        true => format!("within the tolerance of {} mm", study.tolerance),
        false => format!("{times:.1} times the tolerance of {} mm", study.tolerance),
    };
    let rows = [["sum", "superposition"], ["followed", "tool"]];
    KeyNumber::new(wrong, what, against).found(InTable::new(
        "map.csv",
        ["departure_mm"],
        &rows,
        Extreme::Largest,
        most.value,
    ))
}

/// How much the load may grow with the tolerance kept everywhere.
fn load(summary: &Summary) -> Option<KeyNumber> {
    let [least, most] = summary.loads()?;
    let [x, y, z] = least.position_mm;
    let what = match least.largest {
        LargestFactor::BelowToLimit(_) => {
            "of the load of the study keeps the tolerance everywhere, at least".to_string()
        }
        _ => format!("of the load of the study keeps the tolerance everywhere; the limit is at {}", position(x, y, z)),
    };
    let against = format!("up to {} × where it is best", largest_words(&most.largest));
    let found = InTable::new("safe_load.csv", ["largest_load_factor"], &[], Extreme::Smallest, least.factor);
    Some(KeyNumber::new(&format!("{:.2} ×", least.factor), what, against).found(found))
}
