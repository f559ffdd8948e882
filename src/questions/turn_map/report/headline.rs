//! What a map of turns says: on the first screen how far the tool moves at the best turns and what a badly chosen one costs, and a row
//! for each direction.

use super::{
    quantities::{BEST, WORST_OVER_BEST},
    summary::{Found, Report},
};
use crate::{
    answer::Quantity,
    files::{
        text_table::text_table,
        words::{counted, if_any, millimetres, millimetres_in_table, percent, position},
    },
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    questions::turn_map::{TurnMapStudy, Turns},
};

/// The answer at a glance.
pub(super) fn headline(report: &Report<'_>) -> Headline {
    let TurnMapStudy { scene, grid, axes, .. } = report.study;
    let basis = format!(
        "{}, {} of the tool, {}, {} of the force",
        counted(grid.len(), "place"),
        counted(axes.len(), "direction"),
        counted(report.study.turns(), "turn"),
        counted(scene.phis.len(), "direction"),
    );
    let tip = scene.machine.home.pose.rotation * scene.machine.tool_tip;
    let positions = (0..grid.len()).map(|place| grid.position(place) - tip);
    let at_best = |(found, what, extreme): (Option<Found<'_>>, &str, Extreme)| {
        found.map(|found| at_best_turn(report, &found, what, extreme))
    };
    let ends = [
        (report.most(), "largest deflection at the best turn", Extreme::Largest),
        (report.least(), "smallest", Extreme::Smallest),
    ];
    Headline::new(sentence(report), basis)
        .with_cautions(&scene.cautions("place", positions))
        .with_all(ends.into_iter().filter_map(at_best))
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
        millimetres(least.best(), 3),
        millimetres(most.best(), 3),
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

fn in_table(report: &Report<'_>, found: &Found<'_>, quantity: &Quantity<Turns>, extreme: Extreme) -> InTable {
    let value = quantity.value(found.turns).unwrap_or_default();
    quantity.found_in("turns.csv", &[["direction", &report.axis_name(found.point.axis)]], extreme, value)
}

fn at_best_turn(report: &Report<'_>, found: &Found<'_>, what: &str, extreme: Extreme) -> KeyNumber {
    let best = &found.turns.best;
    let branch = best.branch.map_or_else(String::new, |branch| format!(", {}", branch.label()));
    let against = format!("turn {:.0}°{branch}", best.turn_deg);
    let what = format!("{what}, at {}", place(report, found));
    KeyNumber::new(&millimetres(best.deflection_mm, 3), what, against).found(in_table(report, found, &BEST, extreme))
}

fn gain(report: &Report<'_>, found: &Found<'_>) -> KeyNumber {
    let [worst, best] = [&found.turns.worst, &found.turns.best]
        .map(|turn| format!("{} at {:.0}°", millimetres(turn.deflection_mm, 3), turn.turn_deg));
    let what = format!("times as far at the worst turn as at the best, at {}", place(report, found));
    let number = KeyNumber::new(&format!("{:.2}", found.gain()), what, format!("{worst} against {best}"));
    number.found(in_table(report, found, &WORST_OVER_BEST, Extreme::Largest))
}

/// A row for each direction of the tool.
pub(super) fn details(report: &Report<'_>) -> String {
    let mut table = text_table(["tool along", "solved", "least", "most", "worst turn", "turns"], 1);
    let places = report.study.grid.len();
    for (axis, points) in report.map.points.chunks(places).enumerate() {
        let turns: Vec<&Turns> = points.iter().filter_map(|point| point.turns.as_ref().ok()).collect();
        let best = |of: fn(f64, f64) -> f64| turns.iter().map(|turns| turns.best.deflection_mm).reduce(of);
        let worst = turns.iter().map(|turns| turns.worst.deflection_mm).reduce(f64::max);
        let possible = turns.iter().map(|turns| turns.possible as f64).sum::<f64>() / turns.len().max(1) as f64;
        let shown = |value: Option<f64>| if_any(value, |value| millimetres_in_table(value, 3));
        table.add_row([
            report.axis_name(axis),
            format!("{} of {places}", turns.len()),
            shown(best(f64::min)),
            shown(best(f64::max)),
            shown(worst),
            format!("{possible:.0} of {}", report.study.turns()),
        ]);
    }
    format!(
        "Deflection of the tool at the best turn of each place (least, most), at the worst turn of any, and turns that are possible on \
         some branch:\n{table}\n"
    )
}
