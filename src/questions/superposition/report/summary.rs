//! Summary of a superposition study: the map, point by point, and all results as JSON.

use serde_json::{Map, Value, json};

use super::{
    quantities::{MEDIAN_ERROR, P95_ERROR, PROBABILITY, RATIO, RELATIVE, SUPERPOSITION_ERROR, sums_and_points},
    worst_ablation,
};
use crate::{
    answer::{Extremes, Quantity, QuantityExtremes, ShareWithin, ValueAt},
    files::StatusCount,
    process::uncertainty::Draws,
    questions::{
        spread_report::{self, SpreadCounts},
        superposition::{
            GridPoint, LocationResult, Scaling, SuperpositionStudy,
            ablation::Cause,
            safe::LargestFactor,
            superposition_error::{Followed, Sum, Worst},
        },
    },
    simulation::status_of,
};

/// Statistics of the map, updated point by point: memory does not grow with the grid.
pub struct Summary<'a> {
    pub(super) study: &'a SuperpositionStudy,
    /// Extremes of superposition errors by sum and point of the platform.
    superposition_errors: [[QuantityExtremes<Worst, Worst>; 2]; 2],
    /// Smallest and largest factor on the load within tolerance.
    loads: Extremes<LargestFactor>,
    pub(super) points: usize,
    pub(super) solved: usize,
    /// Number of points at which the equilibrium ends before the superposition error reaches the tolerance.
    pub(super) ended: usize,
    /// Share of the box in which superposition is within the tolerance.
    within: ShareWithin,
    /// Number of rows of the map by status.
    pub(super) statuses: Vec<StatusCount>,
}

impl<'a> Summary<'a> {
    /// Starts the summary of the map of `study`, without points.
    pub fn new(study: &'a SuperpositionStudy) -> Self {
        let of_kind = |_| QuantityExtremes::new([SUPERPOSITION_ERROR, RELATIVE, RATIO]);
        Self {
            study,
            superposition_errors: Sum::ALL.map(|_| Followed::ALL.map(of_kind)),
            loads: Extremes::default(),
            points: 0,
            solved: 0,
            ended: 0,
            within: ShareWithin::default(),
            statuses: Vec::new(),
        }
    }

    /// Adds the next grid point to the summary, in grid order.
    pub fn add(&mut self, point: &GridPoint) {
        StatusCount::add(&mut self.statuses, status_of(&point.superposition_errors));
        if let Ok(superposition_errors) = &point.superposition_errors {
            self.solved += 1;
            // Each grid point stands for the cell around it.
            let is_within = superposition_errors.superposed_tool_mm() < self.study.tolerance;
            self.within.add(self.study.grid.cell_share(self.points), is_within);
            for (sum, followed) in sums_and_points() {
                if let Ok(worst) = superposition_errors.worst(sum, followed) {
                    self.superposition_errors[sum as usize][followed as usize].add(worst, point.position_mm, worst);
                }
            }
        }
        self.ended += usize::from(matches!(point.largest_load, LargestFactor::NoEquilibrium(..)));
        if let Some(factor) = point.largest_load.factor() {
            self.loads.add(factor, point.position_mm, &point.largest_load);
        }
        self.points += 1;
    }

    /// Returns the largest `quantity` of the superposition error of `sum` at `followed`, and where it is; `None` where no point has one.
    pub(super) fn largest(&self, sum: Sum, followed: Followed, quantity: &Quantity<Worst>) -> Option<&ValueAt<Worst>> {
        self.superposition_errors[sum as usize][followed as usize].of(quantity).map(|[_, largest]| largest)
    }

    /// Returns the smallest and the largest factor on the load up to which superposition is within tolerance, and where they are; `None` where no
    /// point is solved.
    pub(super) fn load_factor_extremes(&self) -> Option<&[ValueAt<LargestFactor>; 2]> {
        self.loads.get()
    }

    /// Returns the share of the solved part of the box in which superposition is within the tolerance; `None` where none was solved.
    pub fn safe_share(&self) -> Option<f64> {
        self.within.get()
    }

    /// Returns the results as JSON: largest superposition errors, safe share and load, and each location.
    pub fn json(&self, locations: &[LocationResult]) -> Value {
        let largest = |sum, followed, quantity: &Quantity<Worst>, phi: fn(&Worst) -> Option<f64>| {
            let extreme = self.largest(sum, followed, quantity)?;
            Some(json!({ "largest": extreme.value, "position_mm": extreme.position_mm, "phi_deg": phi(&extreme.at) }))
        };
        let of_kind = |(sum, followed): (Sum, Followed)| {
            let entries = [
                (&*SUPERPOSITION_ERROR.name, largest(sum, followed, &SUPERPOSITION_ERROR, |worst| Some(worst.phi_deg))),
                ("relative_to_largest_displacement", largest(sum, followed, &RELATIVE, |worst| Some(worst.phi_deg))),
                ("ratio_at_same_phi", largest(sum, followed, &RATIO, |worst| worst.ratio_phi_deg)),
            ];
            (format!("{}_{}", sum.label(), followed.label()), json_object(entries))
        };
        let mut safe = json!({ "tolerance_mm": self.study.tolerance });
        if let Some(share) = self.safe_share() {
            safe["share_of_box"] = json!(share);
        }
        if let Some([least, most]) = self.load_factor_extremes() {
            let place = |ValueAt { value, position_mm, at }: &ValueAt<LargestFactor>| json!({ "factor": value, "status": at.status(), "position_mm": position_mm });
            safe["largest_load"] = json!({ "everywhere": place(least), "at_best": place(most) });
        }
        let mut summary = json!({
            "schema": 1,
            "grid_points": self.points,
            "grid_points_solved": self.solved,
            "superposition_errors": sums_and_points().map(of_kind).collect::<Map<_, _>>(),
            "safe": safe,
            "locations": locations.iter().map(location_json).collect::<Vec<_>>(),
        });
        if let Some(uncertainty) = &self.study.uncertainty {
            summary["uncertainty"] = spread_report::json(uncertainty, &spread_counts(locations));
            summary["uncertainty"]["draws"] = json!(Draws::PER_SCRAMBLE);
        }
        summary
    }
}

/// Counts the distributions at locations.
pub(super) fn spread_counts(locations: &[LocationResult]) -> SpreadCounts {
    let mut counts = SpreadCounts::default();
    locations.iter().filter_map(|location| location.spread.as_ref()).for_each(|spread| counts.add(spread));
    counts
}

/// Returns a JSON object of the entries that have a value.
fn json_object<'a>(entries: impl IntoIterator<Item = (&'a str, Option<Value>)>) -> Value {
    entries.into_iter().filter_map(|(key, value)| Some((key.to_string(), value?))).collect::<Map<_, _>>().into()
}

/// Returns the results at a location as JSON.
fn location_json(location: &LocationResult) -> Value {
    let mut entry =
        json!({ "name": location.location.name, "position_mm": <[f64; 3]>::from(location.location.position) });
    entry["status"] = status_of(&location.superposition_errors).into();
    match &location.superposition_errors {
        Ok(superposition_errors) => {
            for followed in Followed::ALL {
                entry[followed.label()] = worst_json(&superposition_errors.superposition[followed as usize]);
            }
        }
        Err(failure) => entry["reason"] = json!(failure.reason),
    }
    if let Some(spread) = &location.spread {
        for quantity in [P95_ERROR, MEDIAN_ERROR, PROBABILITY] {
            entry[&*quantity.name] = json!(quantity.value(spread));
        }
        entry["failed_draws_share"] = json!(spread.failed_share);
    }
    entry["slopes"] = json_object(Scaling::ALL.map(|scaled| {
        let fit = location.growth[scaled as usize].fit(Sum::Superposition, Followed::Tool);
        (scaled.label(), fit.map(|fit| json!(fit.slope)))
    }));
    entry["largest_factors"] = json_object(Scaling::ALL.map(|scaled| {
        let factor_found = &location.largest[scaled as usize];
        let factor = factor_found.factor().map(|factor| json!(factor));
        (scaled.label(), Some(json_object([("status", Some(json!(factor_found.status()))), ("factor", factor)])))
    }));
    if let Some((worst, parts, error)) = worst_ablation(location) {
        let shares = Cause::ALL.map(|cause| (cause.label(), Some(json!(parts[cause as usize] / error))));
        entry["causes"] =
            json!({ "phi_deg": worst.phi_deg, "superposition_error_mm": error, "shares": json_object(shares) });
    }
    entry
}

/// Returns a worst superposition error as JSON.
fn worst_json(worst: &Worst) -> Value {
    let mut entry = json!({
        "superposition_error_mm": worst.superposition_error_mm,
        "superposition_error_vector_mm": worst.superposition_error_vector_mm,
        "phi_deg": worst.phi_deg,
        "simultaneous_mm": worst.simultaneous_mm,
    });
    if let (Some(ratio), Some(phi)) = (worst.ratio, worst.ratio_phi_deg) {
        entry["largest_ratio"] = json!({ "ratio": ratio, "phi_deg": phi });
    }
    entry
}
