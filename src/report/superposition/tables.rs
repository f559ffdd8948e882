//! A superposition study as CSV (RFC 4180), units in the headers. Cells without a number are empty, with the reason in
//! `status` and `reason`.

use super::contributions;
use crate::{
    report::table::tidy_degrees,
    study::{
        superposition::{
            LocationResult, Scaled, Superposition,
            ablation::Cause,
            departure::{Departures, Followed, Sum, Worst},
            safe::LargestFactor,
        },
        workspace_map::Failure,
    },
};

type Row = Vec<String>;

const POSITION: [&str; 3] = ["x_mm", "y_mm", "z_mm"];

/// Which departure a row shows, and its numbers: the largest over φ, the displacement by both sources at that φ and the
/// largest over φ, and the largest ratio of the two at the same φ.
const DEPARTURE: [&str; 13] = [
    "sum",
    "followed",
    "status",
    "reason",
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

fn csv(header: &[&str], rows: impl Iterator<Item = Row>) -> csv::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header)?;
    for row in rows {
        writer.write_record(row)?;
    }
    writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn numbers(values: [f64; 3]) -> Row {
    values.iter().map(f64::to_string).collect()
}

fn solved(worst: &Worst) -> Row {
    let mut row = vec!["solved".into(), String::new(), worst.departure_mm.to_string()];
    row.extend(numbers(worst.departure_vector_mm));
    row.push(tidy_degrees(worst.phi_deg).to_string());
    row.push(worst.simultaneous_mm.to_string());
    row.push(worst.largest_simultaneous_mm.to_string());
    row.push(number(worst.ratio));
    row.push(number(worst.ratio_phi_deg.map(tidy_degrees)));
    row
}

fn failed(failure: &Failure, cells: usize) -> Row {
    let mut row = vec![failure.status.to_string(), failure.reason.clone()];
    row.resize(2 + cells, String::new());
    row
}

/// Rows of the columns [`DEPARTURE`], each behind `lead`.
fn departure_rows<'a>(lead: Row, departures: &'a Result<Departures, Failure>) -> impl Iterator<Item = Row> + use<'a> {
    let kinds = Sum::ALL.into_iter().flat_map(|sum| Followed::ALL.map(|followed| (sum, followed)));
    kinds.map(move |(sum, followed)| {
        let worst = departures.as_ref().and_then(|departures| departures.worst(sum, followed));
        let mut row = lead.clone();
        row.extend([sum.label().to_string(), followed.label().to_string()]);
        row.extend(worst.map_or_else(|failure| failed(failure, DEPARTURE.len() - 4), solved));
        row
    })
}

/// Departures on the grid, worst over φ: a row per grid point, sum and followed point.
pub fn map_csv(results: &Superposition) -> csv::Result<Vec<u8>> {
    let rows = results.points.iter().flat_map(|p| departure_rows(numbers(p.position_mm), &p.departures));
    csv(&[&POSITION[..], &DEPARTURE].concat(), rows)
}

/// Departures at the locations, worst over φ: a row per location, sum and followed point.
pub fn locations_csv(results: &Superposition) -> csv::Result<Vec<u8>> {
    let rows = results.locations.iter().flat_map(|l| {
        let mut lead = vec![l.location.name.clone()];
        lead.extend(numbers(l.location.position.into()));
        departure_rows(lead, &l.departures)
    });
    csv(&[&["location"][..], &POSITION, &DEPARTURE].concat(), rows)
}

fn largest_cells(largest: &LargestFactor) -> Row {
    vec![largest.status().into(), largest.reason(), number(largest.factor())]
}

/// Whether superposition keeps within the tolerance at each grid point, and up to which factor on the load it does.
pub fn safe_load_csv(results: &Superposition) -> csv::Result<Vec<u8>> {
    let rows = results.points.iter().map(|point| {
        let mut row = numbers(point.position_mm);
        row.push(match &point.departures {
            Ok(departures) if departures.superposed_tool_mm() < results.study.tolerance => "yes".into(),
            Ok(_) => "no".into(),
            Err(_) => String::new(),
        });
        row.extend(largest_cells(&point.largest_load));
        row
    });
    csv(&[&POSITION[..], &["within_tolerance", "status", "reason", "largest_load_factor"]].concat(), rows)
}

/// A row per location and way of scaling, with each of `cells`.
fn by_scaling(
    results: &Superposition,
    cells: impl Fn(&LocationResult, Scaled) -> Vec<Row>,
) -> impl Iterator<Item = Row> {
    results.locations.iter().flat_map(move |location| {
        let rows = Scaled::ALL.map(|scaled| {
            let lead = [location.location.name.clone(), scaled.label().to_string()];
            cells(location, scaled).into_iter().map(move |cells| [&lead[..], &cells].concat())
        });
        rows.into_iter().flatten().collect::<Vec<_>>()
    })
}

/// Largest factor on load, chain errors and both up to which the tool tip's departure keeps within the tolerance.
pub fn largest_factors_csv(results: &Superposition) -> csv::Result<Vec<u8>> {
    let rows = by_scaling(results, |location, scaled| vec![largest_cells(&location.largest[scaled as usize])]);
    csv(&["location", "scaled", "status", "reason", "largest_factor"], rows)
}

/// Departures with load, chain errors or both multiplied by each factor of the study.
pub fn scaling_csv(results: &Superposition) -> csv::Result<Vec<u8>> {
    let rows = by_scaling(results, |location, scaled| {
        let steps = &location.growth[scaled as usize].steps;
        steps.iter().flat_map(|(factor, found)| departure_rows(vec![factor.to_string()], found)).collect()
    });
    csv(&[&["location", "scaled", "factor"][..], &DEPARTURE].concat(), rows)
}

/// Straight lines through the departures of [`scaling_csv`] in logarithmic scales.
pub fn slopes_csv(results: &Superposition) -> csv::Result<Vec<u8>> {
    let rows = by_scaling(results, |location, scaled| {
        let kinds = Sum::ALL.into_iter().flat_map(|sum| Followed::ALL.map(|followed| (sum, followed)));
        let row = |(sum, followed): (Sum, Followed)| {
            let mut row = vec![sum.label().to_string(), followed.label().to_string()];
            row.extend(match location.growth[scaled as usize].fit(sum, followed) {
                Some(fit) => {
                    let (word, reason) = match fit.is_power_law() {
                        true => ("fitted", String::new()),
                        false => {
                            let ratio = fit.worst_ratio;
                            ("not_a_power_law", format!("departures lie up to {ratio:.2} times off the line"))
                        }
                    };
                    let values = [fit.slope, fit.coefficient_mm, fit.points as f64, fit.worst_ratio];
                    [word.to_string(), reason].into_iter().chain(values.map(|v| v.to_string())).collect()
                }
                None => failed(&no_fit(), 4),
            });
            row
        };
        kinds.map(row).collect()
    });
    let header = [
        "location",
        "scaled",
        "sum",
        "followed",
        "status",
        "reason",
        "slope",
        "fitted_departure_at_factor_1_mm",
        "departures_fitted",
        "largest_ratio_to_fit",
    ];
    csv(&header, rows)
}

fn no_fit() -> Failure {
    Failure {
        status: "no_fit",
        reason: "fewer than two departures could be solved and are larger than rounding".into(),
    }
}

/// The departure and its parts at each location, φ and followed point. `share` is the part's component along the
/// departure, over the departure.
pub fn ablation_csv(results: &Superposition) -> csv::Result<Vec<u8>> {
    let header = [
        "location",
        "status",
        "reason",
        "phi_deg",
        "followed",
        "cause",
        "part_x_mm",
        "part_y_mm",
        "part_z_mm",
        "part_mm",
        "share",
    ];
    let rows = results.locations.iter().flat_map(|location| {
        let name = location.location.name.clone();
        match &location.ablation {
            Ok(angles) => angles.iter().flat_map(|angle| ablation_rows(&name, angle)).collect(),
            Err(failure) => vec![[vec![name], failed(failure, header.len() - 3)].concat()],
        }
    });
    csv(&header, rows)
}

fn ablation_rows(name: &str, angle: &crate::study::superposition::ablation::Ablation) -> Vec<Row> {
    let lead = [name.into(), "solved".into(), String::new(), tidy_degrees(angle.phi_deg).to_string()];
    let of_point = |followed: Followed| {
        let whole = angle.departure.of(followed);
        let shares = contributions(angle, followed).map(|lengths| lengths.map(|length| length / whole.norm()));
        let row = |cause: &str, part: nalgebra::Vector3<f64>, share: Option<f64>| {
            let mut row = lead.to_vec();
            row.extend([followed.label().to_string(), cause.to_string()]);
            row.extend(numbers(part.into()));
            row.extend([part.norm().to_string(), number(share)]);
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
