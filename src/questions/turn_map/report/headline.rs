//! The first screen of a map of turns: how far the tool moves at the best turns, and what a badly chosen one costs.

use super::{
    summary::{Found, Report},
    text,
};
use crate::{
    files::words::{counted, millimetres, percent, position},
    page::headline::{Extreme, Headline, InTable, KeyNumber},
};

/// The answer at a glance.
pub(super) fn headline(report: &Report<'_>) -> Headline {
    let study = report.study;
    let basis = format!(
        "{}, {} of the tool, {}, {} of the force",
        counted(study.grid.len(), "place"),
        counted(study.axes.len(), "direction"),
        counted(study.turns(), "turn"),
        counted(study.scene.phis.len(), "direction"),
    );
    Headline::new(sentence(report), basis)
        .with_cautions(&text::cautions(report))
        .with_all(
            report
                .most()
                .map(|most| at_best_turn(report, &most, "largest deflection at the best turn", Extreme::Largest)),
        )
        .with_all(report.least().map(|least| at_best_turn(report, &least, "smallest", Extreme::Smallest)))
        .with_all(report.widest().map(|widest| gain(report, &widest)))
}

fn sentence(report: &Report<'_>) -> String {
    let name = report.study.scene.machine.short_title();
    let (Some(least), Some(most)) = (report.least(), report.most()) else {
        return format!("The {name} has no turn about its tool at any of the places and directions.");
    };
    let kept = match (report.study.scene.tolerance_mm, report.share_within()) {
        (Some(tolerance), Some(share)) => format!(" {tolerance} mm is kept in {} of the places.", percent(share)),
        _ => String::new(),
    };
    let gain = report
        .widest()
        .map_or_else(String::new, |widest| format!(" Turned badly it moves up to {:.1} times as far.", widest.gain()));
    format!(
        "Turned well about its tool, the {name} is moved by {} at best and {} at worst.{gain}{kept}",
        millimetres(least.best.deflection_mm, 3),
        millimetres(most.best.deflection_mm, 3),
    )
}

fn place(report: &Report<'_>, found: &Found<'_>) -> String {
    let [x, y, z] = found.point.position_mm;
    let at = position(x, y, z);
    match report.study.axes.len() {
        1 => at,
        _ => format!("{at} with the tool along {}", report.axis_name(found.point.axis)),
    }
}

fn of_direction(report: &Report<'_>, found: &Found<'_>, column: &str, extreme: Extreme, value: f64) -> InTable {
    let direction = report.axis_name(found.point.axis);
    InTable::new("turns.csv", [column.to_string()], &[["direction", &direction]], extreme, value)
}

fn turned(found: &Found<'_>) -> String {
    let branch = found.best.branch.map_or_else(String::new, |branch| format!(", {}", branch.label()));
    format!("turn {:.0}°{branch}", found.best.turn_deg)
}

fn at_best_turn(report: &Report<'_>, found: &Found<'_>, what: &str, extreme: Extreme) -> KeyNumber {
    let value = found.best.deflection_mm;
    let what = format!("{what}, at {}", place(report, found));
    let number = KeyNumber::new(&millimetres(value, 3), what, turned(found));
    number.found(of_direction(report, found, "best_deflection_mm", extreme, value))
}

fn gain(report: &Report<'_>, found: &Found<'_>) -> KeyNumber {
    let against = format!(
        "{} at {:.0}° against {} at {:.0}°",
        millimetres(found.worst.deflection_mm, 3),
        found.worst.turn_deg,
        millimetres(found.best.deflection_mm, 3),
        found.best.turn_deg
    );
    let what = format!("times as far at the worst turn as at the best, at {}", place(report, found));
    KeyNumber::new(&format!("{:.2}", found.gain()), what, against).found(of_direction(
        report,
        found,
        "worst_over_best",
        Extreme::Largest,
        found.gain(),
    ))
}
