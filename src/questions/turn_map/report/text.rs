//! What a map of turns says, in sentences and a small table.

use super::summary::Report;
use crate::{
    answer::cautions,
    files::{
        text_table::text_table,
        words::{if_any, millimetres_in_table},
    },
    questions::turn_map::TurnMapPoint,
};

/// What must be known with the answer.
pub(super) fn cautions(report: &Report<'_>) -> String {
    let study = report.study;
    let tip = study.scene.machine.home.pose.rotation * study.scene.machine.tool_tip;
    let positions = (0..study.grid.len()).map(|place| study.grid.position(place) - tip);
    cautions::not_used(&study.scene.not_used)
        + &cautions::zeroed(&study.scene.machine)
        + &cautions::large_errors(&study.scene.machine, &study.scene.errors)
        + &cautions::outside_workspace(&study.scene.machine, "place", positions)
}

/// A row for each direction of the tool.
pub(super) fn details(report: &Report<'_>) -> String {
    let mut table = text_table(["tool along", "solved", "least", "most", "worst turn", "turns"], 1);
    let places = report.study.grid.len();
    for (axis, points) in report.map.points.chunks(places).enumerate() {
        let turns: Vec<_> = points.iter().filter_map(|point: &TurnMapPoint| point.turns.as_ref().ok()).collect();
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
