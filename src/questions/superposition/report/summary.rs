//! What the study says: the map, gathered point by point, and all of it as a JSON object.

use serde_json::{Map, Value, json};

use super::{
    quantities::{RATIO, RELATIVE, SUPERPOSITION_ERROR, kinds},
    worst_ablation,
};
use crate::{
    answer::{Extremes, Found, OfQuantities, Quantity, ShareWithin},
    files::StatusCount,
    questions::superposition::{
        GridPoint, LocationResult, Scaled, SuperpositionStudy,
        ablation::Cause,
        safe::LargestFactor,
        superposition_error::{Followed, Sum, Worst},
    },
    simulation::status_of,
};

/// What the map says, gathered point by point: memory does not grow with the grid.
pub struct Summary<'a> {
    pub(super) study: &'a SuperpositionStudy,
    /// By sum and followed point.
    superposition_errors: [[OfQuantities<Worst, Worst>; 2]; 2],
    /// Up to which factor on the load points keep within the tolerance.
    loads: Extremes<LargestFactor>,
    pub(super) points: usize,
    pub(super) solved: usize,
    /// Points at which the equilibrium ends before the superposition error reaches the tolerance.
    pub(super) ended: usize,
    /// Of the box, where the sum keeps within the tolerance.
    within: ShareWithin,
    /// Rows of the map per status.
    pub(super) statuses: Vec<StatusCount>,
}

impl<'a> Summary<'a> {
    /// Of the map of `study`, none of its points seen.
    pub fn new(study: &'a SuperpositionStudy) -> Self {
        let of_kind = |_| OfQuantities::new([SUPERPOSITION_ERROR, RELATIVE, RATIO]);
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

    /// Takes the next point, in grid order, into account.
    pub fn add(&mut self, point: &GridPoint) {
        StatusCount::add(&mut self.statuses, status_of(&point.superposition_errors));
        if let Ok(superposition_errors) = &point.superposition_errors {
            self.solved += 1;
            // Each grid point stands for the cell around it.
            let is_within = superposition_errors.superposed_tool_mm() < self.study.tolerance;
            self.within.add(self.study.grid.cell_share(self.points), is_within);
            for (sum, followed) in kinds() {
                if let Ok(worst) = superposition_errors.worst(sum, followed) {
                    self.superposition_errors[sum as usize][followed as usize].see(worst, point.position_mm, worst);
                }
            }
        }
        self.ended += usize::from(matches!(point.largest_load, LargestFactor::NoEquilibrium(..)));
        if let Some(factor) = point.largest_load.factor() {
            self.loads.see(factor, point.position_mm, &point.largest_load);
        }
        self.points += 1;
    }

    /// Where `quantity` of the superposition error of `sum` at `followed` is largest.
    pub(super) fn largest(&self, sum: Sum, followed: Followed, quantity: &Quantity<Worst>) -> Option<&Found<Worst>> {
        self.superposition_errors[sum as usize][followed as usize].of(quantity).map(|[_, largest]| largest)
    }

    /// The smallest and the largest factor on the load.
    pub(super) fn loads(&self) -> Option<&[Found<LargestFactor>; 2]> {
        self.loads.get()
    }

    /// Share of the solved part of the box in which superposition keeps within the tolerance; `None` where nothing was
    /// solved.
    pub fn safe_share(&self) -> Option<f64> {
        self.within.get()
    }

    /// Largest superposition errors over the grid, where superposition is safe, and what was found at each location.
    pub fn json(&self, locations: &[LocationResult]) -> Value {
        let largest = |sum, followed, quantity: &Quantity<Worst>, phi: fn(&Worst) -> Option<f64>| {
            let found = self.largest(sum, followed, quantity)?;
            Some(json!({ "largest": found.value, "position_mm": found.position_mm, "phi_deg": phi(&found.at) }))
        };
        let of_kind = |(sum, followed): (Sum, Followed)| {
            let entries = [
                (&*SUPERPOSITION_ERROR.name, largest(sum, followed, &SUPERPOSITION_ERROR, |worst| Some(worst.phi_deg))),
                ("relative_to_largest_displacement", largest(sum, followed, &RELATIVE, |worst| Some(worst.phi_deg))),
                ("ratio_at_same_phi", largest(sum, followed, &RATIO, |worst| worst.ratio_phi_deg)),
            ];
            (format!("{}_{}", sum.label(), followed.label()), object(entries))
        };
        let mut safe = json!({ "tolerance_mm": self.study.tolerance });
        if let Some(share) = self.safe_share() {
            safe["share_of_box"] = json!(share);
        }
        if let Some([least, most]) = self.loads() {
            let place = |Found { value, position_mm, at }: &Found<LargestFactor>| json!({ "factor": value, "status": at.status(), "position_mm": position_mm });
            safe["largest_load"] = json!({ "everywhere": place(least), "at_best": place(most) });
        }
        json!({
            "schema": 1,
            "grid_points": self.points,
            "grid_points_solved": self.solved,
            "superposition_errors": kinds().map(of_kind).collect::<Map<_, _>>(),
            "safe": safe,
            "locations": locations.iter().map(location_json).collect::<Vec<_>>(),
        })
    }
}

/// The entries that there are.
fn object<'a>(entries: impl IntoIterator<Item = (&'a str, Option<Value>)>) -> Value {
    entries.into_iter().filter_map(|(key, value)| Some((key.to_string(), value?))).collect::<Map<_, _>>().into()
}

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
    entry["slopes"] = object(Scaled::ALL.map(|scaled| {
        let fit = location.growth[scaled as usize].fit(Sum::Superposition, Followed::Tool);
        (scaled.label(), fit.map(|fit| json!(fit.slope)))
    }));
    entry["largest_factors"] = object(Scaled::ALL.map(|scaled| {
        let found = &location.largest[scaled as usize];
        let factor = found.factor().map(|factor| json!(factor));
        (scaled.label(), Some(object([("status", Some(json!(found.status()))), ("factor", factor)])))
    }));
    if let Some((worst, parts, whole)) = worst_ablation(location) {
        let shares = Cause::ALL.map(|cause| (cause.label(), Some(json!(parts[cause as usize] / whole))));
        entry["causes"] =
            json!({ "phi_deg": worst.phi_deg, "superposition_error_mm": whole, "shares": object(shares) });
    }
    entry
}

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
