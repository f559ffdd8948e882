//! The numbers of a superposition study and its tables. `status` and `reason` say why numbers are missing.

use nalgebra::Vector3;

use super::contributions;
use crate::{
    answer::{FoundOr, Quantity, TableOf},
    files::{
        exchange::{Cell, Column, Row, Table, cells, numbers, texts},
        table::tidy_degrees,
    },
    page::Better::{Larger, Neither, Smaller},
    questions::superposition::{
        GridPoint, LocationResult, Scaled, SuperpositionStudy,
        ablation::{Ablation, Cause},
        growth::Fit,
        safe::LargestFactor,
        superposition_error::{Followed, Sum, SuperpositionErrors, Worst},
    },
    simulation::Failure,
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

fn error_along() -> [OfWorst; 3] {
    OfWorst::vector_mm("superposition_error", "superposition error", |worst| Some(worst.superposition_error_vector_mm))
}

/// Those of a page, in its order.
pub(super) fn on_page() -> Vec<OfWorst> {
    [SUPERPOSITION_ERROR, RATIO, SIMULTANEOUS, PHI].into_iter().chain(error_along()).collect()
}

/// The sums and the points that are followed, in table order.
pub(super) fn kinds() -> impl Iterator<Item = (Sum, Followed)> {
    Sum::ALL.into_iter().flat_map(|sum| Followed::ALL.map(|followed| (sum, followed)))
}

fn position_columns() -> Vec<Column> {
    numbers(["x_mm", "y_mm", "z_mm"])
}

/// Superposition errors of each kind, worst over φ, behind cells of the columns `lead`.
fn worst_of<'a>(
    lead: Vec<Column>,
    found: impl IntoIterator<Item = (Row, &'a Result<SuperpositionErrors, Failure>)>,
) -> Table {
    let mut quantities = vec![SUPERPOSITION_ERROR];
    quantities.extend(error_along());
    quantities.extend([
        PHI,
        SIMULTANEOUS,
        OfWorst::in_table("largest_simultaneous_mm", |worst| Some(worst.largest_simultaneous_mm)),
        RATIO,
        OfWorst::in_table("largest_ratio_phi_deg", |worst| worst.ratio_phi_deg.map(tidy_degrees)),
    ]);
    let rows = found.into_iter().flat_map(|(lead, found)| {
        kinds().map(move |(sum, followed)| {
            let lead = [&lead[..], &[sum.label().into(), followed.label().into()]].concat();
            (lead, found.as_ref().and_then(|found| found.worst(sum, followed)))
        })
    });
    TableOf::new([lead, texts(["sum", "followed"])].concat(), quantities).table(rows)
}

/// Superposition errors at points of the grid, worst over φ: a row per grid point, sum and followed point.
pub fn map_table(points: &[GridPoint]) -> Table {
    worst_of(position_columns(), points.iter().map(|p| (cells(p.position_mm).collect(), &p.superposition_errors)))
}

/// Superposition errors at the locations, worst over φ: a row per location, sum and followed point.
pub fn locations_table(locations: &[LocationResult]) -> Table {
    let row = |found: &'_ LocationResult| {
        let at = cells(found.location.position.iter().copied());
        std::iter::once(name(found)).chain(at).collect()
    };
    let found = locations.iter().map(|found| (row(found), &found.superposition_errors));
    worst_of([texts(["location"]), position_columns()].concat(), found)
}

fn name(found: &LocationResult) -> Cell {
    found.location.name.as_str().into()
}

/// Largest factors on what is called so, behind cells of the columns `lead`.
fn largest_factors<'a>(
    lead: Vec<Column>,
    factor: Quantity<LargestFactor>,
    rows: impl IntoIterator<Item = (Row, &'a LargestFactor)>,
) -> Table {
    let status =
        Quantity::text("status", |largest: FoundOr<'_, LargestFactor>| largest.ok().map(LargestFactor::status).into());
    let reason =
        Quantity::text("reason", |largest: FoundOr<'_, LargestFactor>| largest.ok().map(LargestFactor::reason).into());
    let table = TableOf::without_status(lead, vec![status, reason, factor]);
    table.table(rows.into_iter().map(|(lead, largest)| (lead, Ok(largest))))
}

/// Whether superposition keeps within the tolerance at each of these grid points, and up to which factor on the load it does.
pub fn safe_load_table(study: &SuperpositionStudy, points: &[GridPoint]) -> Table {
    let row = |point: &'_ GridPoint| {
        let is_safe =
            point.superposition_errors.as_ref().ok().map(|found| found.superposed_tool_mm() < study.tolerance);
        let word = is_safe.map(|is_safe| if is_safe { "yes" } else { "no" });
        cells(point.position_mm).chain([word.into()]).collect()
    };
    let rows = points.iter().map(|point| (row(point), &point.largest_load));
    largest_factors([position_columns(), texts(["within_tolerance"])].concat(), LARGEST_LOAD, rows)
}

/// Each location and way of scaling, with their cells.
fn scaled(locations: &[LocationResult]) -> impl Iterator<Item = (Row, &LocationResult, Scaled)> {
    locations
        .iter()
        .flat_map(|found| Scaled::ALL.map(|scaled| (vec![name(found), scaled.label().into()], found, scaled)))
}

/// Largest factor on load, chain errors and both up to which the tool tip's superposition error keeps within the tolerance.
pub fn largest_factors_table(locations: &[LocationResult]) -> Table {
    let rows = scaled(locations).map(|(lead, found, scaled)| (lead, &found.largest[scaled as usize]));
    largest_factors(texts(["location", "scaled"]), Quantity::in_table("largest_factor", LargestFactor::factor), rows)
}

/// Superposition errors with load, chain errors or both multiplied by each factor of the study.
pub fn scaling_table(locations: &[LocationResult]) -> Table {
    let rows = scaled(locations).flat_map(|(lead, found, scaled)| {
        let steps = found.growth[scaled as usize].steps.iter();
        steps.map(move |(factor, found)| ([&lead[..], &[(*factor).into()]].concat(), found))
    });
    worst_of([texts(["location", "scaled"]), numbers(["factor"])].concat(), rows)
}

/// Straight lines through the superposition errors of [`scaling_table`] in logarithmic scales.
pub fn slopes_table(locations: &[LocationResult]) -> Table {
    let no_fit = Failure {
        status: "no_fit".into(),
        reason: "fewer than two superposition errors could be solved and are larger than rounding".into(),
    };
    let fits: Vec<(Row, Option<Fit>)> = scaled(locations)
        .flat_map(|(lead, found, scaled)| {
            kinds().map(move |(sum, followed)| {
                let lead = [&lead[..], &[sum.label().into(), followed.label().into()]].concat();
                (lead, found.growth[scaled as usize].fit(sum, followed))
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
    TableOf::without_status(texts(["location", "scaled", "sum", "followed"]), quantities).table(rows)
}

/// A part of the superposition error at a φ and a followed point.
pub(super) struct Part {
    phi_deg: f64,
    followed: Followed,
    cause: &'static str,
    part: Vector3<f64>,
    /// Its component along the superposition error, over the superposition error.
    share: Option<f64>,
}

pub(super) const PART: Quantity<Part> = Quantity::in_table("part_mm", |part| Some(part.part.norm()));

/// The superposition error and its parts at each location, φ and followed point. `share` is the part's component along the
/// superposition error, over the superposition error.
pub fn ablation_table(locations: &[LocationResult]) -> Table {
    let mut quantities = vec![
        Quantity::in_table("phi_deg", |part: &Part| Some(tidy_degrees(part.phi_deg))),
        Quantity::text("followed", |part| part.ok().map(|part| part.followed.label()).into()),
        Quantity::text("cause", |part| part.ok().map(|part| part.cause).into()),
    ];
    quantities.extend(Quantity::vector_mm("part", "", |part: &Part| Some(part.part.into())));
    quantities.extend([PART, Quantity::in_table("share", |part| part.share)]);
    let parts: Vec<(Row, Result<Part, &Failure>)> = locations
        .iter()
        .flat_map(|found| -> Vec<_> {
            let named = |part| (vec![name(found)], part);
            match &found.ablation {
                Ok(angles) => angles.iter().flat_map(parts_at).map(|part| named(Ok(part))).collect(),
                Err(failure) => vec![named(Err(failure))],
            }
        })
        .collect();
    let rows = parts.iter().map(|(lead, part)| (lead.clone(), part.as_ref().map_err(|failure| *failure)));
    TableOf::new(texts(["location"]), quantities).table(rows)
}

/// The superposition error and its parts at an angle.
fn parts_at(angle: &Ablation) -> impl Iterator<Item = Part> {
    Followed::ALL.into_iter().flat_map(|followed| {
        let whole = angle.superposition_error.of(followed);
        let shares = contributions(angle, followed).map(|lengths| lengths.map(|length| length / whole.norm()));
        let part = |cause, part, share| Part { phi_deg: angle.phi_deg, followed, cause, part, share };
        let of_cause = |cause: Cause| {
            let k = cause as usize;
            part(cause.label(), angle.parts[k].of(followed), shares.map(|shares| shares[k]))
        };
        let all = part("all", whole, shares.map(|_| 1.0));
        std::iter::once(all).chain(Cause::ALL.map(of_cause)).collect::<Vec<_>>()
    })
}
