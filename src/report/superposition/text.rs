//! The study's answer in sentences.

use super::{
    contributions,
    extremes::{largest, load_extremes, size, solved_points},
    words, worst_ablation,
};
use crate::{
    report::{
        words::typographic,
        words::{counted, millimetres, position},
    },
    study::superposition::{
        LocationResult, MapPoint, Scaled, Superposition,
        ablation::Cause,
        departure::{Followed, Sum, Worst},
        growth::ROUNDING_MM,
        safe::LargestFactor,
    },
};

fn at(point: &MapPoint) -> String {
    let [x, y, z] = point.position_mm;
    position(x, y, z)
}

fn shown(departure_mm: f64) -> String {
    millimetres(departure_mm, 4, ROUNDING_MM)
}

/// The closing words of a run: how wrong adding is, where and up to which load it is safe, and why it is wrong.
pub fn summary_text(results: &Superposition) -> String {
    let study = &results.study;
    let mut text = format!(
        "{}: {} of {} solved, {}. Departure: displacement by the cutting force alone plus that by chain errors alone, less \
         that by both at once.\n",
        study.machine.title,
        solved_points(results),
        counted(study.grid.len(), "grid point"),
        counted(study.phis.len(), "tool angle")
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
            "Superposition is wrong at {name} by up to {}, at {} (tool angle {:.0}°), and by up to {:.1} % of the \
             largest displacement at the same place, at {}",
            shown(worst.0),
            at(worst.1),
            worst.2.phi_deg,
            100.0 * share.0,
            at(share.1)
        );
        text += &match aggregated {
            Some(worst) => format!(
                "; with linearly aggregated errors, eqs. (14) and (15), by up to {}, at {}.\n",
                shown(worst.0),
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
    let is_solved = solved_points(results) == results.points.len();
    let (of, there) = if is_solved { ("the box", "") } else { ("the part of the box that was solved", "there ") };
    let mut text = format!(
        "For a tolerance of {tolerance} mm at the tool tip superposition is safe in {:.1} % of {of} at the load of the \
         study. It is safe everywhere {there}up to ",
        100.0 * share
    );
    text += &match &least.1.largest_load {
        LargestFactor::BelowToLimit(factor) => format!("at least {factor:.2} times that load.\n"),
        _ => format!(
            "{:.2} times that load, as limited by {}, and up to {} times at {}.\n",
            least.0,
            at(least.1),
            largest_words(&most.1.largest_load),
            at(most.1)
        ),
    };
    let ended = results.points.iter().filter(|p| matches!(p.largest_load, LargestFactor::NoEquilibrium(..))).count();
    if ended > 0 {
        text += &format!(
            "At {} the equilibrium ends before the departure reaches the tolerance.\n",
            counted(ended, "point")
        );
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
    let mut text = format!("{name}: wrong by {} at worst", shown(tool.departure_mm));
    if tool.simultaneous_mm > ROUNDING_MM {
        text += &format!(
            " ({:.1} % of {})",
            100.0 * tool.departure_mm / tool.simultaneous_mm,
            millimetres(tool.simultaneous_mm, 3, ROUNDING_MM)
        );
    }
    text += &growth_words(location);
    let largest = |scaled: Scaled| largest_words(&location.largest[scaled as usize]);
    text += &format!(
        "; it is safe up to {} × load, {} × errors, {} × both.\n",
        largest(Scaled::Load),
        largest(Scaled::Errors),
        largest(Scaled::Both)
    );
    text + &ablation_sentence(location)
}

/// The powers with which the departure grows, of the sources for which there is one.
fn growth_words(location: &LocationResult) -> String {
    let words = |(scaled, of): (Scaled, &str)| {
        let fit = location.growth[scaled as usize].fit(Sum::Superposition, Followed::Tool)?;
        Some(format!("{:.2} of {of}", fit.slope))
    };
    let scaled = [(Scaled::Load, "the load"), (Scaled::Errors, "the errors"), (Scaled::Both, "both")];
    let powers: Vec<String> = scaled.into_iter().filter_map(words).collect();
    if powers.is_empty() { String::new() } else { format!("; it grows with the power {}", powers.join(", ")) }
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
        let percent = typographic(&format!("{:.1}", if tenths == 0.0 { 0.0 } else { tenths / 10.0 }));
        format!("{}: {percent} %", words(cause))
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
