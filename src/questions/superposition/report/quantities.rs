//! Quantities and tables of a superposition study. `status` and `reason` say why numbers are missing.

use nalgebra::Vector3;

use super::contributions;
use crate::{
    answer::{FoundOr, Quantity, QuantityTable},
    files::{
        exchange::{Cell, Column, Row, Table, cells, numbers, texts},
        words::tidy_degrees,
    },
    page::Better::{Larger, Neither, Smaller},
    questions::superposition::{
        GridPoint, LocationResult, Scaling, SuperpositionStudy,
        ablation::{Ablation, Cause},
        growth::Fit,
        safe::LargestFactor,
        superposition_error::{Followed, Sum, SuperpositionErrors, Worst},
    },
    simulation::{Failure, spread::DeflectionSpread},
};

type OfWorst = Quantity<Worst>;

pub(super) const SUPERPOSITION_ERROR: OfWorst =
    OfWorst::new("superposition_error_mm", "superposition error", Smaller, |worst| Some(worst.superposition_error_mm));
const PHI: OfWorst =
    OfWorst::new("superposition_error_phi_deg", "φ of the largest superposition error", Neither, |worst| {
        Some(tidy_degrees(worst.phi_deg))
    });
/// The displacement by both sources at that φ.
const SIMULTANEOUS: OfWorst =
    OfWorst::new("simultaneous_mm", "displacement by both at that angle", Smaller, |worst| Some(worst.simultaneous_mm));
/// The largest ratio of the two at the same φ.
pub(super) const RATIO: OfWorst =
    OfWorst::new("largest_ratio", "largest superposition error over displacement", Smaller, |worst| worst.ratio);
/// The largest superposition error over the largest displacement.
pub(super) const RELATIVE: OfWorst = OfWorst::in_table("relative_to_largest_displacement", Worst::relative);

pub(super) const LARGEST_LOAD: Quantity<LargestFactor> =
    Quantity::new("largest_load_factor", "largest load factor within tolerance", Larger, LargestFactor::factor);

/// Returns the components of the superposition error along the axes of O.
fn error_components() -> [OfWorst; 3] {
    OfWorst::vector_mm("superposition_error", "superposition error", |worst| Some(worst.superposition_error_vector_mm))
}

/// Returns the quantities of the interactive map, in its order.
pub(super) fn page_quantities() -> Vec<OfWorst> {
    [SUPERPOSITION_ERROR, RATIO, SIMULTANEOUS, PHI].into_iter().chain(error_components()).collect()
}

/// Returns all pairs of sum and point of the platform, in table order.
pub(super) fn sums_and_points() -> impl Iterator<Item = (Sum, Followed)> {
    Sum::ALL.into_iter().flat_map(|sum| Followed::ALL.map(|followed| (sum, followed)))
}

/// Returns the columns of a position of P, mm.
fn position_columns() -> Vec<Column> {
    numbers(["x_mm", "y_mm", "z_mm"])
}

/// Makes a table of `errors`, worst over φ: behind the cells of columns `lead`, a row for each sum and point of the platform.
fn worst_table<'a>(
    lead: Vec<Column>,
    errors: impl IntoIterator<Item = (Row, &'a Result<SuperpositionErrors, Failure>)>,
) -> Table {
    let mut quantities = vec![SUPERPOSITION_ERROR];
    quantities.extend(error_components());
    quantities.extend([
        PHI,
        SIMULTANEOUS,
        OfWorst::in_table("largest_simultaneous_mm", |worst| Some(worst.largest_simultaneous_mm)),
        RATIO,
        OfWorst::in_table("largest_ratio_phi_deg", |worst| worst.ratio_phi_deg.map(tidy_degrees)),
    ]);
    let rows = errors.into_iter().flat_map(|(lead, errors)| {
        sums_and_points().map(move |(sum, followed)| {
            let lead = [&lead[..], &[sum.label().into(), followed.label().into()]].concat();
            (lead, errors.as_ref().and_then(|errors| errors.worst(sum, followed)))
        })
    });
    QuantityTable::new([lead, texts(["sum", "followed"])].concat(), quantities).table(rows)
}

/// Makes the table of superposition errors at grid points, worst over φ.
pub fn map_table(points: &[GridPoint]) -> Table {
    worst_table(position_columns(), points.iter().map(|p| (cells(p.position_mm).collect(), &p.superposition_errors)))
}

type OfSpread = Quantity<DeflectionSpread>;

/// The distribution of the superposition error of the tool tip at a location.
pub(super) const P95_ERROR: OfSpread = Quantity::in_table("superposition_error_p95_mm", |own| own.p95_mm);
pub(super) const MEDIAN_ERROR: OfSpread = Quantity::in_table("superposition_error_median_mm", |own| own.median_mm);
pub(super) const PROBABILITY: OfSpread = Quantity::in_table("within_tolerance_probability", |own| own.within_tolerance);
const SPREAD: [OfSpread; 6] = [
    P95_ERROR,
    MEDIAN_ERROR,
    PROBABILITY,
    Quantity::text("spread_reason", |found| found.ok().and_then(DeflectionSpread::reason).into()),
    Quantity::count("spread_solved_draws", |own| Some(own.solved_draws)),
    Quantity::count("spread_failed_draws", |own| Some(own.failed_draws)),
];

/// Makes the table of superposition errors at locations, worst over φ; where inputs are uncertain, with their distribution at the tool tip.
pub fn locations_table(locations: &[LocationResult]) -> Table {
    let row = |found: &'_ LocationResult| {
        let position = cells(found.location.position.iter().copied());
        std::iter::once(name_cell(found)).chain(position).collect()
    };
    let rows = locations.iter().map(|location| (row(location), &location.superposition_errors));
    let nominal = worst_table([texts(["location"]), position_columns()].concat(), rows);
    if locations.iter().all(|location| location.spread.is_none()) {
        return nominal;
    }
    let none = Failure { status: "".into(), reason: String::new() };
    let spreads = locations.iter().flat_map(|location| {
        sums_and_points().map(|of| location.spread.as_ref().filter(|_| of == (Sum::Superposition, Followed::Tool)))
    });
    let rows = nominal.rows().iter().zip(spreads).map(|(row, spread)| {
        let cell = |quantity: &OfSpread| quantity.cell_of(spread.ok_or(&none));
        row.iter().cloned().chain(SPREAD.iter().map(cell)).collect()
    });
    Table::new([nominal.columns(), &SPREAD.each_ref().map(OfSpread::column)].concat(), rows)
}

/// Returns the cell with the name of a location.
fn name_cell(location: &LocationResult) -> Cell {
    location.location.name.as_str().into()
}

/// Makes a table of largest factors, in a column named by `factor`, behind the cells of `lead`.
fn factor_table<'a>(
    lead: Vec<Column>,
    factor: Quantity<LargestFactor>,
    rows: impl IntoIterator<Item = (Row, &'a LargestFactor)>,
) -> Table {
    let status =
        Quantity::text("status", |largest: FoundOr<'_, LargestFactor>| largest.ok().map(LargestFactor::status).into());
    let reason =
        Quantity::text("reason", |largest: FoundOr<'_, LargestFactor>| largest.ok().map(LargestFactor::reason).into());
    let table = QuantityTable::without_status(lead, vec![status, reason, factor]);
    table.table(rows.into_iter().map(|(lead, largest)| (lead, Ok(largest))))
}

/// Makes the table of grid points: whether superposition is within the tolerance, and up to which factor on the load.
pub fn safe_load_table(study: &SuperpositionStudy, points: &[GridPoint]) -> Table {
    let row = |point: &'_ GridPoint| {
        let is_safe =
            point.superposition_errors.as_ref().ok().map(|errors| errors.superposed_tool_mm() < study.tolerance);
        let word = is_safe.map(|is_safe| if is_safe { "yes" } else { "no" });
        cells(point.position_mm).chain([word.into()]).collect()
    };
    let rows = points.iter().map(|point| (row(point), &point.largest_load));
    factor_table([position_columns(), texts(["within_tolerance"])].concat(), LARGEST_LOAD, rows)
}

/// Returns each location with each way of scaling, and the cells that name them.
fn location_scalings(locations: &[LocationResult]) -> impl Iterator<Item = (Row, &LocationResult, Scaling)> {
    locations.iter().flat_map(|location| {
        Scaling::ALL.map(|scaled| (vec![name_cell(location), scaled.label().into()], location, scaled))
    })
}

/// Makes the table of largest factors on load, chain errors and both with which the tool tip is within the tolerance.
pub fn largest_factors_table(locations: &[LocationResult]) -> Table {
    let rows = location_scalings(locations).map(|(lead, location, scaled)| (lead, &location.largest[scaled as usize]));
    factor_table(texts(["location", "scaled"]), Quantity::in_table("largest_factor", LargestFactor::factor), rows)
}

/// Makes the table of superposition errors with load, chain errors or both multiplied by each factor of the study.
pub fn scaling_table(locations: &[LocationResult]) -> Table {
    let rows = location_scalings(locations).flat_map(|(lead, location, scaled)| {
        let steps = location.growth[scaled as usize].steps.iter();
        steps.map(move |(factor, errors)| ([&lead[..], &[(*factor).into()]].concat(), errors))
    });
    worst_table([texts(["location", "scaled"]), numbers(["factor"])].concat(), rows)
}

/// Makes the table of lines fitted to [`scaling_table`] in logarithmic scales.
pub fn slopes_table(locations: &[LocationResult]) -> Table {
    let no_fit = Failure {
        status: "no_fit".into(),
        reason: "fewer than two superposition errors could be solved and are larger than rounding".into(),
    };
    let fits: Vec<(Row, Option<Fit>)> = location_scalings(locations)
        .flat_map(|(lead, location, scaled)| {
            sums_and_points().map(move |(sum, followed)| {
                let lead = [&lead[..], &[sum.label().into(), followed.label().into()]].concat();
                (lead, location.growth[scaled as usize].fit(sum, followed))
            })
        })
        .collect();
    let quantities = vec![
        Quantity::text("status", |fit: FoundOr<'_, Fit>| match fit {
            Ok(fit) if fit.is_power_law() => "fitted".into(),
            Ok(_) => "not_a_power_law".into(),
            Err(failure) => (&*failure.status).into(),
        }),
        Quantity::text("reason", |fit| match fit {
            Ok(fit) if fit.is_power_law() => Cell::Missing,
            Ok(fit) => format!(
                "superposition errors deviate from the fitted power law by up to a factor of {:.2}",
                fit.worst_ratio
            )
            .into(),
            Err(failure) => failure.reason.as_str().into(),
        }),
        Quantity::in_table("slope", |fit| Some(fit.slope)),
        Quantity::in_table("fitted_superposition_error_at_factor_1_mm", |fit| Some(fit.coefficient_mm)),
        Quantity::count("superposition_errors_fitted", |fit| Some(fit.points)),
        Quantity::in_table("largest_ratio_to_fit", |fit| Some(fit.worst_ratio)),
    ];
    let rows = fits.iter().map(|(lead, fit)| (lead.clone(), fit.as_ref().ok_or(&no_fit)));
    QuantityTable::without_status(texts(["location", "scaled", "sum", "followed"]), quantities).table(rows)
}

/// Part of the superposition error by one cause, at one φ and point of the platform.
pub(super) struct ErrorPart {
    phi_deg: f64,
    followed: Followed,
    cause: &'static str,
    part: Vector3<f64>,
    /// Ratio of its component along the superposition error to that error.
    share: Option<f64>,
}

pub(super) const PART: Quantity<ErrorPart> = Quantity::in_table("part_mm", |part| Some(part.part.norm()));

/// Makes the table of the superposition error and its parts at each location, φ and point; `share` is along the error, over it.
pub fn ablation_table(locations: &[LocationResult]) -> Table {
    let mut quantities = vec![
        Quantity::in_table("phi_deg", |part: &ErrorPart| Some(tidy_degrees(part.phi_deg))),
        Quantity::text("followed", |part| part.ok().map(|part| part.followed.label()).into()),
        Quantity::text("cause", |part| part.ok().map(|part| part.cause).into()),
    ];
    quantities.extend(Quantity::vector_mm("part", "", |part: &ErrorPart| Some(part.part.into())));
    quantities.extend([PART, Quantity::in_table("share", |part| part.share)]);
    let parts: Vec<(Row, Result<ErrorPart, &Failure>)> = locations
        .iter()
        .flat_map(|location| -> Vec<_> {
            let named = |part| (vec![name_cell(location)], part);
            match &location.ablation {
                Ok(angles) => angles.iter().flat_map(parts_at).map(|part| named(Ok(part))).collect(),
                Err(failure) => vec![named(Err(failure))],
            }
        })
        .collect();
    let rows = parts.iter().map(|(lead, part)| (lead.clone(), part.as_ref().map_err(|failure| *failure)));
    QuantityTable::new(texts(["location"]), quantities).table(rows)
}

/// Returns the superposition error and its parts at one φ, for both points of the platform.
fn parts_at(angle: &Ablation) -> impl Iterator<Item = ErrorPart> {
    Followed::ALL.into_iter().flat_map(|followed| {
        let error = angle.superposition_error.of(followed);
        let shares = contributions(angle, followed).map(|lengths| lengths.map(|length| length / error.norm()));
        let part = |cause, part, share| ErrorPart { phi_deg: angle.phi_deg, followed, cause, part, share };
        let of_cause = |cause: Cause| {
            let k = cause as usize;
            part(cause.label(), angle.parts[k].of(followed), shares.map(|shares| shares[k]))
        };
        let total = part("all", error, shares.map(|_| 1.0));
        std::iter::once(total).chain(Cause::ALL.map(of_cause)).collect::<Vec<_>>()
    })
}
