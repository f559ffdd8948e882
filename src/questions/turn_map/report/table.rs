//! The map of turns as a table.

use super::summary::Report;
use crate::{
    files::exchange::{Cell, Column, Row, Table, cells, counts, numbers, texts},
    questions::turn_map::{AtTurn, TurnMapPoint},
    simulation::SOLVED,
};

/// Word of the rows that hold the worst of all directions.
pub(super) const ALL: &str = "all";

/// One row per direction and place, then, of several directions, one per place for all of them: that whose best turn moves the tool most.
pub(super) fn table(report: &Report<'_>) -> Table {
    let own = report.map.points.iter().map(|point| row(report, &report.axis_name(point.axis), point));
    let places = if report.study.axes.len() > 1 { report.study.grid.len() } else { 0 };
    let all = (0..places).map(|place| {
        let failed =
            || (0..report.study.axes.len()).map(|axis| report.point(axis, place)).find(|point| !point.is_solved());
        let worst = report.all_axes(place).map(|found| found.point).or_else(failed);
        row(report, ALL, worst.unwrap_or_else(|| report.point(0, place)))
    });
    Table::new(columns(), own.chain(all).collect::<Vec<Row>>())
}

fn columns() -> Vec<Column> {
    let mut columns = numbers(["x_mm", "y_mm", "z_mm"]);
    columns.extend(texts(["direction"]));
    columns.extend(numbers(["tool_axis_x", "tool_axis_y", "tool_axis_z"]));
    columns.extend(texts(["status", "reason"]));
    columns.extend(numbers(["best_deflection_mm", "best_turn_deg"]));
    columns.extend(texts(["best_branch"]));
    columns.extend(numbers(["best_phi_deg", "worst_deflection_mm", "worst_turn_deg"]));
    columns.extend(texts(["worst_branch"]));
    columns.extend(numbers(["worst_phi_deg", "worst_over_best"]));
    columns.extend(counts(["turns_possible"]));
    columns
}

fn row(report: &Report<'_>, direction: &str, point: &TurnMapPoint) -> Row {
    let mut row: Row = cells(point.position_mm).collect();
    row.push(direction.into());
    row.extend(cells(report.axis(point.axis)));
    match &point.turns {
        Ok(turns) => {
            row.extend([SOLVED.into(), Cell::Missing]);
            row.extend(of_turn(&turns.best));
            row.extend(of_turn(&turns.worst));
            let best = Some(turns.best.deflection_mm).filter(|best| *best > 0.0);
            row.push(best.map(|best| turns.worst.deflection_mm / best).into());
            row.push(turns.possible.into());
        }
        Err(failure) => {
            row.extend([Cell::from(&*failure.status), failure.reason.as_str().into()]);
            row.resize(columns().len() - 1, Cell::Missing);
            row.push(0usize.into());
        }
    }
    row
}

fn of_turn(turn: &AtTurn) -> [Cell; 4] {
    let branch = turn.branch.map_or(Cell::Missing, |branch| branch.label().into());
    // Turns are told to a thousandth of a degree.
    let tidy = |degrees: f64| (degrees * 1e3).round() / 1e3 + 0.0;
    [turn.deflection_mm.into(), tidy(turn.turn_deg).into(), branch, tidy(turn.phi_deg).into()]
}
