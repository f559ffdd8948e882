//! The study's answer as a JSON object.

use serde_json::{Value, json};

use super::{
    contributions,
    extremes::{largest, load_extremes, size, solved_points},
    worst_ablation,
};
use crate::study::superposition::{
    LocationResult, MapPoint, Scaled, Superposition,
    ablation::Cause,
    departure::{Followed, Sum, Worst},
};

/// Largest departures over the grid, where superposition is safe, and what was found at each location.
pub fn summary_json(results: &Superposition) -> Value {
    let mut departures = serde_json::Map::new();
    for sum in Sum::ALL {
        for followed in Followed::ALL {
            let mut entry = serde_json::Map::new();
            for (key, value) in [
                ("departure_mm", size as fn(&Worst) -> Option<f64>),
                ("relative_to_largest_displacement", Worst::relative),
                ("ratio_at_same_phi", |worst: &Worst| worst.ratio),
            ] {
                if let Some((value, point, worst)) = largest(results, sum, followed, value) {
                    let phi = if key == "ratio_at_same_phi" { worst.ratio_phi_deg } else { Some(worst.phi_deg) };
                    entry.insert(
                        key.into(),
                        json!({ "largest": value, "position_mm": point.position_mm, "phi_deg": phi }),
                    );
                }
            }
            departures.insert(format!("{}_{}", sum.label(), followed.label()), entry.into());
        }
    }
    let mut safe = json!({ "tolerance_mm": results.study.tolerance });
    if let Some(share) = results.safe_share() {
        safe["share_of_box"] = json!(share);
    }
    if let Some([least, most]) = load_extremes(results) {
        let place = |(factor, point): (f64, &MapPoint)| json!({ "factor": factor, "status": point.largest_load.status(), "position_mm": point.position_mm });
        safe["largest_load"] = json!({ "everywhere": place(least), "at_best": place(most) });
    }
    json!({
        "schema": 1,
        "grid_points": results.points.len(),
        "grid_points_solved": solved_points(results),
        "departures": departures,
        "safe": safe,
        "locations": results.locations.iter().map(location_json).collect::<Vec<_>>(),
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
