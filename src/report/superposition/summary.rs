//! The study's answer in sentences and as a JSON object.

use serde_json::{Value, json};

use super::{contributions, words, worst_ablation};
use crate::study::superposition::{
    LocationResult, MapPoint, Scaled, Superposition,
    ablation::Cause,
    departure::{Followed, Sum, Worst},
    safe::LargestFactor,
};

/// The solved grid point at which `value` of the departure of `sum` at `followed` is largest.
fn largest(
    results: &Superposition,
    sum: Sum,
    followed: Followed,
    value: fn(&Worst) -> Option<f64>,
) -> Option<(f64, &MapPoint, &Worst)> {
    let mut found: Option<(f64, &MapPoint, &Worst)> = None;
    for point in &results.points {
        let worst = point.departures.as_ref().ok().and_then(|departures| departures.worst(sum, followed).ok());
        let here = worst.and_then(|worst| Some((value(worst)?, point, worst)));
        if let Some(here) = here
            && found.is_none_or(|found| here.0 > found.0)
        {
            found = Some(here);
        }
    }
    found
}

fn size(worst: &Worst) -> Option<f64> {
    Some(worst.departure_mm)
}

/// Grid points that keep within the tolerance up to the smallest and to the largest factor on the load.
fn load_extremes(results: &Superposition) -> Option<[(f64, &MapPoint); 2]> {
    let mut found: Option<[(f64, &MapPoint); 2]> = None;
    for point in &results.points {
        if let Some(factor) = point.largest_load.factor() {
            let here = (factor, point);
            found = Some(match found {
                None => [here, here],
                Some([least, most]) => {
                    [if factor < least.0 { here } else { least }, if factor > most.0 { here } else { most }]
                }
            });
        }
    }
    found
}

fn at(point: &MapPoint) -> String {
    let [x, y, z] = point.position_mm;
    format!("({x:.1}, {y:.1}, {z:.1}) mm")
}

fn solved_points(results: &Superposition) -> usize {
    results.points.iter().filter(|point| point.departures.is_ok()).count()
}

/// The closing words of a run: how wrong adding is, where and up to which load it is safe, and why it is wrong.
pub fn summary_text(results: &Superposition) -> String {
    let study = &results.study;
    let mut text = format!(
        "{}: {} of {} grid points solved, {} tool angles. Departure: displacement by the cutting force alone plus that by \
         chain errors alone, less that by both at once.\n",
        study.machine.title,
        solved_points(results),
        study.grid.len(),
        study.phis.len()
    );
    text += &departure_sentences(results);
    text += &safe_sentences(results);
    for location in &results.locations {
        text += &location_sentences(location);
    }
    text + &main_causes(results)
}

fn departure_sentences(results: &Superposition) -> String {
    let mut text = String::new();
    for (followed, name) in [(Followed::Tool, "the tool tip"), (Followed::Platform, "the platform point P")] {
        let by = |value: fn(&Worst) -> Option<f64>| Sum::ALL.map(|sum| largest(results, sum, followed, value));
        let ([Some(worst), aggregated], [Some(share), _]) = (by(size), by(Worst::relative)) else { continue };
        text += &format!(
            "Superposition is wrong at {name} by up to {:.4} mm, at {} (tool angle {:.0}°), and by up to {:.1} % of the \
             largest displacement at the same place, at {}",
            worst.0,
            at(worst.1),
            worst.2.phi_deg,
            100.0 * share.0,
            at(share.1)
        );
        text += &match aggregated {
            Some(worst) => format!(
                "; with linearly aggregated errors, eqs. (14) and (15), by up to {:.4} mm, at {}.\n",
                worst.0,
                at(worst.1)
            ),
            None => "; errors cannot be aggregated linearly.\n".into(),
        };
    }
    if let Some((ratio, point, worst)) = largest(results, Sum::Superposition, Followed::Tool, |worst| worst.ratio) {
        text += &format!(
            "Where the two effects nearly cancel at a tool angle, the departure is up to {:.1} % of what remains, at {} \
             (tool angle {:.0}°).\n",
            100.0 * ratio,
            at(point),
            worst.ratio_phi_deg.unwrap_or_default()
        );
    }
    text
}

fn safe_sentences(results: &Superposition) -> String {
    let tolerance = results.study.tolerance;
    let (Some(share), Some([least, most])) = (results.safe_share(), load_extremes(results)) else {
        return "Nothing can be said about where superposition is safe: no grid point was solved.\n".into();
    };
    let at_least = |point: &MapPoint| match point.largest_load {
        LargestFactor::Reached(_) => "",
        _ => "at least ",
    };
    let mut text = format!(
        "For a tolerance of {tolerance} mm at the tool tip superposition is safe in {:.1} % of the box at the load of the \
         study. It is safe everywhere up to {}{:.2} times that load, as limited by {}, and up to {}{:.2} times at {}.\n",
        100.0 * share,
        at_least(least.1),
        least.0,
        at(least.1),
        at_least(most.1),
        most.0,
        at(most.1)
    );
    let ended = results.points.iter().filter(|p| matches!(p.largest_load, LargestFactor::NoEquilibrium(..))).count();
    if ended > 0 {
        text += &format!("At {ended} points the equilibrium ends before the departure reaches the tolerance.\n");
    }
    text
}

fn location_sentences(location: &LocationResult) -> String {
    let name = &location.location.name;
    let departures = match &location.departures {
        Ok(departures) => departures,
        Err(failure) => return format!("{name}: {}: {}.\n", failure.status, failure.reason),
    };
    let tool = &departures.superposition[Followed::Tool as usize];
    let mut text = format!("{name}: wrong by {:.4} mm at worst", tool.departure_mm);
    if tool.simultaneous_mm > 0.0 {
        text +=
            &format!(" ({:.1} % of {:.3} mm)", 100.0 * tool.departure_mm / tool.simultaneous_mm, tool.simultaneous_mm);
    }
    let slope = |scaled: Scaled| {
        let fit = location.growth[scaled as usize].fit(Sum::Superposition, Followed::Tool);
        fit.map_or_else(|| "(none)".into(), |fit| format!("{:.2}", fit.slope))
    };
    text += &format!(
        "; it grows with the power {} of the load, {} of the errors, {} of both",
        slope(Scaled::Load),
        slope(Scaled::Errors),
        slope(Scaled::Both)
    );
    let largest = |scaled: Scaled| largest_words(&location.largest[scaled as usize]);
    text += &format!(
        "; it is safe up to {} × load, {} × errors, {} × both.\n",
        largest(Scaled::Load),
        largest(Scaled::Errors),
        largest(Scaled::Both)
    );
    text + &ablation_sentence(location)
}

fn largest_words(largest: &LargestFactor) -> String {
    match largest {
        LargestFactor::Reached(factor) => format!("{factor:.2}"),
        LargestFactor::BelowToLimit(factor) => format!("at least {factor:.2}"),
        LargestFactor::NoEquilibrium(factor, failure) => format!("{factor:.2} (then {})", failure.status),
        LargestFactor::Unsolved(failure) => format!("none ({})", failure.status),
    }
}

fn ablation_sentence(location: &LocationResult) -> String {
    if let Err(failure) = &location.ablation {
        return format!("  Its causes cannot be told apart: {}: {}.\n", failure.status, failure.reason);
    }
    let Some((worst, parts)) = worst_ablation(location).and_then(|w| Some((w, contributions(w, Followed::Tool)?)))
    else {
        return String::new();
    };
    let whole = worst.departure.tool.norm();
    let share = |cause: Cause| {
        let tenths = (1000.0 * parts[cause as usize] / whole).round();
        // No negative zero.
        format!("{}: {:.1} %", words(cause), if tenths == 0.0 { 0.0 } else { tenths / 10.0 })
    };
    format!("  Where it comes from at tool angle {:.0}°: {}.\n", worst.phi_deg, Cause::ALL.map(share).join(", "))
}

/// Which cause makes the largest part, by location.
fn main_causes(results: &Superposition) -> String {
    let main = |location: &LocationResult| {
        let parts = contributions(worst_ablation(location)?, Followed::Tool)?;
        Cause::ALL.into_iter().max_by(|a, b| parts[*a as usize].total_cmp(&parts[*b as usize]))
    };
    let mut text = String::new();
    for cause in Cause::ALL {
        let here = results.locations.iter().filter(|location| main(location) == Some(cause));
        let names: Vec<&str> = here.map(|location| location.location.name.as_str()).collect();
        if !names.is_empty() {
            text += &format!("The largest cause at {} is: {}.\n", names.join(", "), words(cause));
        }
    }
    text
}

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
