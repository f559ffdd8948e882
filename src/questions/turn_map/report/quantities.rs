//! The numbers of a map of turns, its table and its pictures: slices at the heights asked for, of the worst direction where there are
//! several, and the places in 3-D.

use super::summary::Report;
use crate::{
    answer::{Drawn, GridMap, Quantity, TableOf},
    figures::{Figure, Shading},
    files::exchange::{Cell, Kind, Row, Table, cells, numbers, texts},
    machine::Branch,
    page::Better::{Larger, Neither, Smaller},
    questions::turn_map::{TurnMapPoint, Turns},
    simulation::Shown,
};

type Of = Quantity<Turns>;

pub(super) const BEST: Of =
    Of::new("best_deflection_mm", "deflection at the best turn", Smaller, |turns| Some(turns.best.deflection_mm));
const BEST_TURN: Of = Of::new("best_turn_deg", "best turn", Neither, |turns| tidy(turns.best.turn_deg));
const WORST: Of =
    Of::new("worst_deflection_mm", "deflection at the worst turn", Smaller, |turns| Some(turns.worst.deflection_mm));
pub(super) const WORST_OVER_BEST: Of = Of::new("worst_over_best", "worst over best", Neither, |turns| {
    Some(turns.best.deflection_mm).filter(|best| *best > 0.0).map(|best| turns.worst.deflection_mm / best)
});
const POSSIBLE: Of = Of::cell("turns_possible", "turns that are possible", Larger, Kind::Count, |turns| {
    turns.map_or(0, |turns| turns.possible).into()
});

/// Those of a page, in its order.
pub(super) fn on_page() -> [Of; 5] {
    [BEST, WORST, WORST_OVER_BEST, BEST_TURN, POSSIBLE]
}

/// Turns are told to a thousandth of a degree.
fn tidy(degrees: f64) -> Option<f64> {
    Some((degrees * 1e3).round() / 1e3 + 0.0)
}

fn word(branch: Option<Branch>) -> Cell {
    branch.map(|branch| branch.label()).into()
}

/// Word of the rows that hold the worst of all directions.
pub(super) const ALL: &str = "all";

/// One row per direction and place, then, of several directions, one per place for all of them: that whose best turn moves the tool most.
pub(super) fn table(report: &Report<'_>) -> Table {
    let lead = [
        numbers(["x_mm", "y_mm", "z_mm"]),
        texts(["direction"]),
        numbers(["tool_axis_x", "tool_axis_y", "tool_axis_z"]),
    ];
    let quantities = vec![
        BEST,
        BEST_TURN,
        Of::text("best_branch", |turns| turns.map_or(Cell::Missing, |turns| word(turns.best.branch))),
        Of::in_table("best_phi_deg", |turns| tidy(turns.best.phi_deg)),
        WORST,
        Of::in_table("worst_turn_deg", |turns| tidy(turns.worst.turn_deg)),
        Of::text("worst_branch", |turns| turns.map_or(Cell::Missing, |turns| word(turns.worst.branch))),
        Of::in_table("worst_phi_deg", |turns| tidy(turns.worst.phi_deg)),
        WORST_OVER_BEST,
        POSSIBLE,
    ];
    let axes = report.study.axes.len();
    let places = if axes > 1 { report.study.grid.len() } else { 0 };
    let worst = |place: usize| {
        let failed = || (0..axes).map(|axis| report.point(axis, place)).find(|point| !point.is_solved());
        let worst = report.all_axes(place).map(|found| found.point).or_else(failed);
        worst.unwrap_or_else(|| report.point(0, place))
    };
    let row = |direction: String, point: &'_ TurnMapPoint| {
        let mut lead: Row = cells(point.position_mm).collect();
        lead.push(direction.into());
        lead.extend(cells(report.axis(point.axis)));
        lead
    };
    let own = report.map.points.iter().map(|point| (row(report.axis_name(point.axis), point), point.turns.as_ref()));
    let all = (0..places).map(worst).map(|point| (row(ALL.into(), point), point.turns.as_ref()));
    TableOf::new(lead.concat(), quantities).table(own.chain(all))
}

/// All pictures with their file stems.
pub(super) fn figures(report: &Report<'_>, shown: &Shown) -> Vec<(String, Figure)> {
    let study = report.study;
    let tool = match study.axes.len() {
        1 => format!("tool along {}", report.axis_name(0)),
        count => format!("worst of {count} directions of the tool"),
    };
    let drawn = |stem, title: &str, label: String, value: fn(&Turns) -> Option<f64>| Drawn {
        stem,
        title: title.into(),
        label,
        under: format!("{tool}, {}, {} turns", study.scene.force_words(), study.turns()),
        contour: None,
        line: String::new(),
        shading: Shading::Ordered,
        value: Box::new(move |turns: &Option<Turns>| value(turns.as_ref()?)),
    };
    let best = drawn("best", "How far the tool moves, turned well about its axis", BEST.axis_label(), |turns| {
        BEST.value(turns)
    });
    let turn = drawn("turn", "How to turn the tool about its axis", BEST_TURN.axis_label(), |turns| {
        Some(turns.best.turn_deg.rem_euclid(360.0))
    });
    let gain =
        drawn("gain", "How much the turn counts", "deflection at the worst turn over the best".into(), |turns| {
            WORST_OVER_BEST.value(turns)
        });
    let drawn =
        vec![Drawn { contour: study.scene.tolerance_mm, ..best }, Drawn { shading: Shading::Cyclic, ..turn }, gain];
    let mut map = GridMap::new(&study.scene, &study.grid, shown, drawn);
    (map.missing, map.has_points) = ("no turn", false);
    (0..study.grid.len()).for_each(|place| map.add(&report.all_axes(place).map(|found| *found.turns)));
    let slices: Vec<(String, Figure)> = map.slices().collect();
    let answer = ("answer".to_string(), slices[0].1.clone());
    let in_3d = map.in_3d(0, format!("The places, coloured by {}", BEST.label));
    std::iter::once(answer).chain(slices).chain(in_3d.map(|figure| ("turns_in_3d".into(), figure))).collect()
}
