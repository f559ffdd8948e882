//! The tables of a superposition study. `status` and `reason` say why numbers are missing.

use crate::{
    files::{
        exchange::{Cell, Column, Row, Table, cells, counts, numbers, texts},
        table::tidy_degrees,
    },
    questions::superposition::{
        DeparturePoint, LocationResult, Scaled, SuperpositionStudy,
        ablation::Cause,
        departure::{Departures, Followed, Sum, Worst},
        report::contributions,
        safe::LargestFactor,
    },
    simulation::Failure,
};

/// Which departure a row shows, and its numbers: the largest over φ, the displacement by both sources at that φ and the
/// largest over φ, and the largest ratio of the two at the same φ.
fn departure_columns() -> Vec<Column> {
    let quantities = [
        "departure_mm",
        "departure_x_mm",
        "departure_y_mm",
        "departure_z_mm",
        "departure_phi_deg",
        "simultaneous_mm",
        "largest_simultaneous_mm",
        "largest_ratio",
        "largest_ratio_phi_deg",
    ];
    [texts(["sum", "followed", "status", "reason"]), numbers(quantities)].concat()
}

fn position_columns() -> Vec<Column> {
    numbers(["x_mm", "y_mm", "z_mm"])
}

fn solved(worst: &Worst) -> Row {
    let mut row = vec!["solved".into(), Cell::Missing, worst.departure_mm.into()];
    row.extend(cells(worst.departure_vector_mm));
    row.push(tidy_degrees(worst.phi_deg).into());
    row.push(worst.simultaneous_mm.into());
    row.push(worst.largest_simultaneous_mm.into());
    row.push(worst.ratio.into());
    row.push(worst.ratio_phi_deg.map(tidy_degrees).into());
    row
}

fn failed(failure: &Failure, cells: usize) -> Row {
    let mut row = vec![(&*failure.status).into(), failure.reason.as_str().into()];
    row.resize(2 + cells, Cell::Missing);
    row
}

/// Rows of [`departure_columns`], each behind `lead`.
fn departure_rows<'a>(lead: Row, departures: &'a Result<Departures, Failure>) -> impl Iterator<Item = Row> + use<'a> {
    let kinds = Sum::ALL.into_iter().flat_map(|sum| Followed::ALL.map(|followed| (sum, followed)));
    kinds.map(move |(sum, followed)| {
        let worst = departures.as_ref().and_then(|departures| departures.worst(sum, followed));
        let mut row = lead.clone();
        row.extend([sum.label().into(), followed.label().into()]);
        row.extend(worst.map_or_else(|failure| failed(failure, departure_columns().len() - 4), solved));
        row
    })
}

/// Departures at points of the grid, worst over φ: a row per grid point, sum and followed point.
pub fn map_table(points: &[DeparturePoint]) -> Table {
    let rows = points.iter().flat_map(|p| departure_rows(cells(p.position_mm).collect(), &p.departures));
    Table::new([position_columns(), departure_columns()].concat(), rows)
}

/// Departures at the locations, worst over φ: a row per location, sum and followed point.
pub fn locations_table(locations: &[LocationResult]) -> Table {
    let rows = locations.iter().flat_map(|l| {
        let mut lead: Row = vec![l.location.name.as_str().into()];
        lead.extend(cells(l.location.position.iter().copied()));
        departure_rows(lead, &l.departures)
    });
    Table::new([texts(["location"]), position_columns(), departure_columns()].concat(), rows)
}

fn largest_cells(largest: &LargestFactor) -> Row {
    vec![largest.status().into(), largest.reason().into(), largest.factor().into()]
}

/// Whether superposition keeps within the tolerance at each of these grid points, and up to which factor on the load it does.
pub fn safe_load_table(study: &SuperpositionStudy, points: &[DeparturePoint]) -> Table {
    let rows = points.iter().map(|point| {
        let mut row: Row = cells(point.position_mm).collect();
        row.push(match &point.departures {
            Ok(departures) if departures.superposed_tool_mm() < study.tolerance => "yes".into(),
            Ok(_) => "no".into(),
            Err(_) => Cell::Missing,
        });
        row.extend(largest_cells(&point.largest_load));
        row
    });
    let found = [texts(["within_tolerance", "status", "reason"]), numbers(["largest_load_factor"])].concat();
    Table::new([position_columns(), found].concat(), rows)
}

/// A row per location and way of scaling, with each of `cells`.
fn by_scaling(
    locations: &[LocationResult],
    cells: impl Fn(&LocationResult, Scaled) -> Vec<Row>,
) -> impl Iterator<Item = Row> {
    locations.iter().flat_map(move |location| {
        let rows = Scaled::ALL.map(|scaled| {
            let lead: [Cell; 2] = [location.location.name.as_str().into(), scaled.label().into()];
            cells(location, scaled).into_iter().map(move |cells| [&lead[..], &cells].concat())
        });
        rows.into_iter().flatten().collect::<Vec<_>>()
    })
}

/// Largest factor on load, chain errors and both up to which the tool tip's departure keeps within the tolerance.
pub fn largest_factors_table(locations: &[LocationResult]) -> Table {
    let rows = by_scaling(locations, |location, scaled| vec![largest_cells(&location.largest[scaled as usize])]);
    let columns = [texts(["location", "scaled", "status", "reason"]), numbers(["largest_factor"])].concat();
    Table::new(columns, rows)
}

/// Departures with load, chain errors or both multiplied by each factor of the study.
pub fn scaling_table(locations: &[LocationResult]) -> Table {
    let rows = by_scaling(locations, |location, scaled| {
        let steps = &location.growth[scaled as usize].steps;
        steps.iter().flat_map(|(factor, found)| departure_rows(vec![(*factor).into()], found)).collect()
    });
    Table::new([texts(["location", "scaled"]), numbers(["factor"]), departure_columns()].concat(), rows)
}

/// Straight lines through the departures of [`scaling_table`] in logarithmic scales.
pub fn slopes_table(locations: &[LocationResult]) -> Table {
    let rows = by_scaling(locations, |location, scaled| {
        let kinds = Sum::ALL.into_iter().flat_map(|sum| Followed::ALL.map(|followed| (sum, followed)));
        let row = |(sum, followed): (Sum, Followed)| {
            let mut row: Row = vec![sum.label().into(), followed.label().into()];
            row.extend(match location.growth[scaled as usize].fit(sum, followed) {
                Some(fit) => {
                    let (word, reason) = match fit.is_power_law() {
                        true => ("fitted", String::new()),
                        false => {
                            let ratio = fit.worst_ratio;
                            ("not_a_power_law", format!("departures lie up to {ratio:.2} times off the line"))
                        }
                    };
                    vec![
                        word.into(),
                        reason.into(),
                        fit.slope.into(),
                        fit.coefficient_mm.into(),
                        fit.points.into(),
                        fit.worst_ratio.into(),
                    ]
                }
                None => failed(&no_fit(), 4),
            });
            row
        };
        kinds.map(row).collect()
    });
    let mut columns = texts(["location", "scaled", "sum", "followed", "status", "reason"]);
    columns.extend(numbers(["slope", "fitted_departure_at_factor_1_mm"]));
    columns.extend(counts(["departures_fitted"]));
    columns.extend(numbers(["largest_ratio_to_fit"]));
    Table::new(columns, rows)
}

fn no_fit() -> Failure {
    Failure {
        status: "no_fit".into(),
        reason: "fewer than two departures could be solved and are larger than rounding".into(),
    }
}

/// The departure and its parts at each location, φ and followed point. `share` is the part's component along the
/// departure, over the departure.
pub fn ablation_table(locations: &[LocationResult]) -> Table {
    let mut columns = texts(["location", "status", "reason"]);
    columns.extend(numbers(["phi_deg"]));
    columns.extend(texts(["followed", "cause"]));
    columns.extend(numbers(["part_x_mm", "part_y_mm", "part_z_mm", "part_mm", "share"]));
    let width = columns.len();
    let rows = locations.iter().flat_map(|location| {
        let name = location.location.name.as_str();
        match &location.ablation {
            Ok(angles) => angles.iter().flat_map(|angle| ablation_rows(name, angle)).collect(),
            Err(failure) => vec![[vec![name.into()], failed(failure, width - 3)].concat()],
        }
    });
    let rows: Vec<Row> = rows.collect();
    Table::new(columns, rows)
}

fn ablation_rows(name: &str, angle: &crate::questions::superposition::ablation::Ablation) -> Vec<Row> {
    let lead: [Cell; 4] = [name.into(), "solved".into(), Cell::Missing, tidy_degrees(angle.phi_deg).into()];
    let of_point = |followed: Followed| {
        let whole = angle.departure.of(followed);
        let shares = contributions(angle, followed).map(|lengths| lengths.map(|length| length / whole.norm()));
        let row = |cause: &str, part: nalgebra::Vector3<f64>, share: Option<f64>| {
            let mut row = lead.to_vec();
            row.extend([followed.label().into(), cause.into()]);
            row.extend(cells(part.iter().copied()));
            row.extend([part.norm().into(), share.into()]);
            row
        };
        let mut rows = vec![row("all", whole, shares.map(|_| 1.0))];
        for (index, cause) in Cause::ALL.iter().enumerate() {
            rows.push(row(cause.label(), angle.parts[index].of(followed), shares.map(|shares| shares[index])));
        }
        rows
    };
    Followed::ALL.into_iter().flat_map(of_point).collect()
}
