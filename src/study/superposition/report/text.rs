//! The study's answer in sentences.

use crate::{
    report::{
        cautions,
        words::{counted, millimetres, position, typographic},
    },
    study::{
        ROUNDING_MM,
        superposition::{
            LocationResult, Scaled, SuperpositionStudy,
            ablation::Cause,
            departure::{Followed, Sum},
            report::{
                contributions,
                summary::{Measure, Summary},
                words, worst_ablation,
            },
            safe::LargestFactor,
        },
    },
};

fn at([x, y, z]: [f64; 3]) -> String {
    position(x, y, z)
}

fn shown(departure_mm: f64) -> String {
    millimetres(departure_mm, 4, ROUNDING_MM)
}

/// The closing words of a run: how wrong adding is, where and up to which load it is safe, and why it is wrong.
pub fn summary_text(study: &SuperpositionStudy, summary: &Summary, locations: &[LocationResult]) -> String {
    let mut text = format!(
        "{}: {} of {} solved, {}. Departure: displacement by the cutting force alone plus that by chain errors alone, less \
         that by both at once.\n",
        study.machine.title,
        summary.solved,
        counted(study.grid.len(), "grid point"),
        counted(study.phis.len(), "tool angle")
    );
    text += &cautions::not_used(&study.not_used);
    text += &cautions::zeroed(&study.machine);
    text += &cautions::carried(&study.machine);
    text += &cautions::large_errors(&study.machine, &study.errors);
    text += &cautions::outside_workspace(
        &study.machine,
        "grid point",
        (0..study.grid.len()).map(|index| study.grid.position(index)),
    );
    text += &departure_sentences(summary);
    text += &safe_sentences(study, summary);
    for location in locations {
        text += &location_sentences(location);
    }
    text + &main_causes(locations)
}

fn departure_sentences(summary: &Summary) -> String {
    let mut text = String::new();
    for (followed, name) in [(Followed::Tool, "the tool tip"), (Followed::Platform, "the platform point P")] {
        let by = |measure| Sum::ALL.map(|sum| summary.largest(sum, followed, measure));
        let ([Some(most), aggregated], [Some(share), _]) = (by(Measure::Size), by(Measure::Relative)) else { continue };
        text += &format!(
            "Superposition is wrong at {name} by up to {}, at {} (tool angle {:.0}°), and by up to {:.1} % of the \
             largest displacement at the same place, at {}",
            shown(most.value),
            at(most.position_mm),
            most.worst.phi_deg,
            100.0 * share.value,
            at(share.position_mm)
        );
        text += &match aggregated {
            Some(most) => format!(
                "; with linearly aggregated errors, eqs. (14) and (15), by up to {}, at {}.\n",
                shown(most.value),
                at(most.position_mm)
            ),
            None => "; errors cannot be aggregated linearly.\n".into(),
        };
    }
    if let Some(most) = summary.largest(Sum::Superposition, Followed::Tool, Measure::Ratio) {
        text += &format!(
            "Where the two effects nearly cancel at a tool angle, the departure is up to {:.1} % of what remains, at {} \
             (tool angle {:.0}°).\n",
            100.0 * most.value,
            at(most.position_mm),
            most.worst.ratio_phi_deg.unwrap_or_default()
        );
    }
    text
}

fn safe_sentences(study: &SuperpositionStudy, summary: &Summary) -> String {
    let (Some(share), Some([least, most])) = (summary.safe_share(), summary.loads()) else {
        return "Nothing can be said about where superposition is safe: no grid point was solved.\n".into();
    };
    let is_solved = summary.solved == summary.points;
    let (of, there) = if is_solved { ("the box", "") } else { ("the part of the box that was solved", "there ") };
    let mut text = format!(
        "For a tolerance of {} mm at the tool tip superposition is safe in {:.1} % of {of} at the load of the \
         study. It is safe everywhere {there}up to ",
        study.tolerance,
        100.0 * share
    );
    text += &match &least.largest {
        LargestFactor::BelowToLimit(factor) => format!("at least {factor:.2} times that load.\n"),
        _ => format!(
            "{:.2} times that load, as limited by {}, and up to {} times at {}.\n",
            least.factor,
            at(least.position_mm),
            largest_words(&most.largest),
            at(most.position_mm)
        ),
    };
    if summary.ended > 0 {
        text += &format!(
            "At {} the equilibrium ends before the departure reaches the tolerance.\n",
            counted(summary.ended, "point")
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
fn main_causes(locations: &[LocationResult]) -> String {
    let main = |location: &LocationResult| {
        let parts = contributions(worst_ablation(location)?, Followed::Tool)?;
        Cause::ALL.into_iter().max_by(|a, b| parts[*a as usize].total_cmp(&parts[*b as usize]))
    };
    let mut text = String::new();
    for cause in Cause::ALL {
        let here = locations.iter().filter(|location| main(location) == Some(cause));
        let names: Vec<&str> = here.map(|location| location.location.name.as_str()).collect();
        if !names.is_empty() {
            text += &format!("The largest cause at {} is: {}.\n", names.join(", "), words(cause));
        }
    }
    text
}
