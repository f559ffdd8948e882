//! The study's answer as a JSON object.

use serde_json::{Value, json};

use crate::questions::superposition::{
    LocationResult, Scaled, SuperpositionStudy,
    ablation::Cause,
    departure::{Followed, Sum, Worst},
    report::{
        contributions,
        summary::{Found, Load, Measure, Summary},
        worst_ablation,
    },
};

/// Largest departures over the grid, where superposition is safe, and what was found at each location.
pub fn summary_json(study: &SuperpositionStudy, summary: &Summary, locations: &[LocationResult]) -> Value {
    let mut departures = serde_json::Map::new();
    for sum in Sum::ALL {
        for followed in Followed::ALL {
            let mut entry = serde_json::Map::new();
            for (key, measure) in [
                ("departure_mm", Measure::Size),
                ("relative_to_largest_displacement", Measure::Relative),
                ("ratio_at_same_phi", Measure::Ratio),
            ] {
                if let Some(Found { value, position_mm, worst }) = summary.largest(sum, followed, measure) {
                    let phi = if measure == Measure::Ratio { worst.ratio_phi_deg } else { Some(worst.phi_deg) };
                    entry.insert(key.into(), json!({ "largest": value, "position_mm": position_mm, "phi_deg": phi }));
                }
            }
            departures.insert(format!("{}_{}", sum.label(), followed.label()), entry.into());
        }
    }
    let mut safe = json!({ "tolerance_mm": study.tolerance });
    if let Some(share) = summary.safe_share() {
        safe["share_of_box"] = json!(share);
    }
    if let Some([least, most]) = summary.loads() {
        let place = |load: &Load| json!({ "factor": load.factor, "status": load.largest.status(), "position_mm": load.position_mm });
        safe["largest_load"] = json!({ "everywhere": place(least), "at_best": place(most) });
    }
    json!({
        "schema": 1,
        "grid_points": summary.points,
        "grid_points_solved": summary.solved,
        "departures": departures,
        "safe": safe,
        "locations": locations.iter().map(location_json).collect::<Vec<_>>(),
    })
}

fn location_json(location: &LocationResult) -> Value {
    let mut entry =
        json!({ "name": location.location.name, "position_mm": <[f64; 3]>::from(location.location.position) });
    match &location.departures {
        Ok(departures) => {
            entry["status"] = json!("solved");
            for followed in Followed::ALL {
                entry[followed.label()] = worst_json(&departures.superposition[followed as usize]);
            }
        }
        Err(failure) => {
            entry["status"] = json!(failure.status);
            entry["reason"] = json!(failure.reason);
        }
    }
    let (mut slopes, mut largest) = (serde_json::Map::new(), serde_json::Map::new());
    for scaled in Scaled::ALL {
        if let Some(fit) = location.growth[scaled as usize].fit(Sum::Superposition, Followed::Tool) {
            slopes.insert(scaled.label().into(), json!(fit.slope));
        }
        let found = &location.largest[scaled as usize];
        let mut one = json!({ "status": found.status() });
        if let Some(factor) = found.factor() {
            one["factor"] = json!(factor);
        }
        largest.insert(scaled.label().into(), one);
    }
    entry["slopes"] = slopes.into();
    entry["largest_factors"] = largest.into();
    if let Some((worst, parts)) = worst_ablation(location).and_then(|w| Some((w, contributions(w, Followed::Tool)?))) {
        let whole = worst.departure.tool.norm();
        let shares = Cause::ALL.into_iter().map(|cause| (cause.label(), parts[cause as usize] / whole));
        entry["causes"] = json!({
            "phi_deg": worst.phi_deg,
            "departure_mm": whole,
            "shares": shares.map(|(name, share)| (name.to_string(), json!(share))).collect::<serde_json::Map<_, _>>(),
        });
    }
    entry
}

fn worst_json(worst: &Worst) -> Value {
    let mut entry = json!({
        "departure_mm": worst.departure_mm,
        "departure_vector_mm": worst.departure_vector_mm,
        "phi_deg": worst.phi_deg,
        "simultaneous_mm": worst.simultaneous_mm,
    });
    if let (Some(ratio), Some(phi)) = (worst.ratio, worst.ratio_phi_deg) {
        entry["largest_ratio"] = json!({ "ratio": ratio, "phi_deg": phi });
    }
    entry
}
