//! Sentences and first screen of a superposition study: whether effects may be added, and with which error.

use std::cmp::Ordering;

use super::{
    cause_text,
    quantities::{LARGEST_LOAD, P95_ERROR, RATIO, RELATIVE, SUPERPOSITION_ERROR},
    summary::{Summary, spread_counts},
    worst_ablation,
};
use crate::{
    answer::{Tolerance, ValueAt, force_text},
    files::words::{counted, join_text, listed_up_to, millimetres, or_dash, percent, typographic},
    page::headline::{Extreme, Headline, KeyNumber, State, Verdict},
    process::uncertainty::{Draws, P95},
    questions::{
        spread_report,
        superposition::{
            LocationResult, Scaling, SuperpositionStudy,
            ablation::Cause,
            safe::LargestFactor,
            superposition_error::{Followed, Sum, Worst},
        },
    },
    simulation::{ROUNDING_MM, Source, spread::DeflectionSpread},
};

/// Formats a superposition error in mm.
fn millimetre_text(superposition_error_mm: f64) -> String {
    millimetres(superposition_error_mm, 4)
}

/// Returns all sentences of the results.
pub fn summary_text(summary: &Summary<'_>, locations: &[LocationResult]) -> String {
    superposition_error_text(summary) + &safety_text(summary) + &cause_sentences(locations)
}

/// Describes growth, limits and causes of the superposition error at each location, then the main causes.
pub(super) fn cause_sentences(locations: &[LocationResult]) -> String {
    locations.iter().map(location_sentences).collect::<String>() + &main_causes(locations)
}

/// Describes the largest superposition errors of the map.
pub(super) fn superposition_error_text(summary: &Summary<'_>) -> String {
    let mut text = String::new();
    for (followed, name) in [(Followed::Tool, "the tool tip"), (Followed::Platform, "the platform point P")] {
        let by = |quantity| Sum::ALL.map(|sum| summary.largest(sum, followed, quantity));
        let ([Some(largest), aggregated], [Some(share), _]) = (by(&SUPERPOSITION_ERROR), by(&RELATIVE)) else {
            continue;
        };
        text += &format!(
            "Superposition error at {name}: up to {}, with P at {} (tool angle φ = {:.0}°), and up to {:.1} % of the largest displacement at the \
             same place, with P at {}; each the largest over all tool angles",
            millimetre_text(largest.value),
            largest.place(),
            largest.at.phi_deg,
            100.0 * share.value,
            share.place()
        );
        text += &match aggregated {
            Some(largest) => format!(
                ". With linearly aggregated errors, eqs. (14) and (15): up to {}, with P at {}.\n",
                millimetre_text(largest.value),
                largest.place()
            ),
            None => ". Errors cannot be aggregated linearly.\n".into(),
        };
    }
    if let Some(largest) = summary.largest(Sum::Superposition, Followed::Tool, &RATIO) {
        text += &format!(
            "Where the effects nearly cancel at one φ, the superposition error is up to {:.1} % of what remains, with P at {} (tool angle φ = \
             {:.0}°).\n",
            100.0 * largest.value,
            largest.place(),
            largest.at.ratio_phi_deg.unwrap_or_default()
        );
    }
    text
}

/// Describes where and up to which load superposition is within the tolerance.
pub(super) fn safety_text(summary: &Summary<'_>) -> String {
    let (Some(share), Some([least, most])) = (summary.safe_share(), summary.load_factor_extremes()) else {
        return "Nothing can be said about where effects may be added: no grid point was solved.\n".into();
    };
    let is_solved = summary.solved == summary.points;
    let (region, there) = if is_solved { ("the box", "") } else { ("the part of the box that was solved", "there ") };
    let mut text = format!(
        "At the load of the study, the superposition error at the tool tip is within the tolerance of {} mm in {} of {region}. The error stays \
         within the tolerance everywhere {there}up to ",
        summary.study.tolerance,
        percent(share)
    );
    text += &match &least.at {
        LargestFactor::BelowToLimit(factor) => format!("at least {factor:.2} times that load.\n"),
        _ => format!(
            "{:.2} times that load, as limited with P at {}, and up to {} times with P at {}.\n",
            least.value,
            least.place(),
            largest_text(&most.at),
            most.place()
        ),
    };
    if summary.ended > 0 {
        text += &format!(
            "At {} there is no equilibrium any more before the superposition error reaches the tolerance.\n",
            counted(summary.ended, "point")
        );
    }
    text
}

/// Describes the results at a location: superposition error, growth, largest factors, causes.
fn location_sentences(location: &LocationResult) -> String {
    let name = &location.location.name;
    let superposition_errors = match &location.superposition_errors {
        Ok(superposition_errors) => superposition_errors,
        Err(failure) => return format!("{name}: {}: {}.\n", failure.status, failure.reason),
    };
    let tool = &superposition_errors.superposition[Followed::Tool as usize];
    let mut text = format!("{name}: superposition error up to {}", millimetre_text(tool.superposition_error_mm));
    if tool.simultaneous_mm > ROUNDING_MM {
        text += &format!(
            " ({:.1} % of {})",
            100.0 * tool.superposition_error_mm / tool.simultaneous_mm,
            millimetres(tool.simultaneous_mm, 3)
        );
    }
    text += &growth_text(location);
    let largest = |scaled: Scaling| largest_text(&location.largest[scaled as usize]);
    text += &format!(
        "; within tolerance up to {} × load, {} × errors, {} × both.\n",
        largest(Scaling::Load),
        largest(Scaling::Errors),
        largest(Scaling::Both)
    );
    text + &location.spread.as_ref().map_or_else(String::new, spread_sentence) + &ablation_sentence(location)
}

/// Describes the distribution at a location.
fn spread_sentence(spread: &DeflectionSpread) -> String {
    let quantile = |quantile| or_dash(quantile, millimetre_text);
    let failed = match spread.failed_draws {
        0 => String::new(),
        failed => format!(", no equilibrium in {failed} of {}", counted(spread.solved_draws, "draw")),
    };
    format!(
        "  With uncertain inputs: median {}, 95 % quantile {}{failed}; within tolerance with {} probability.\n",
        quantile(spread.median_mm),
        quantile(spread.p95_mm),
        probability(spread)
    )
}

/// Formats the probability that the superposition error is within tolerance: that none of the draws, or all, are does not make it impossible or certain.
fn probability(spread: &DeflectionSpread) -> String {
    match spread.within_tolerance.unwrap_or_default() {
        0.0 => "less than 1 %".into(),
        1.0 => "more than 99 %".into(),
        share => percent(share),
    }
}

/// Returns the locations with a distribution, the least probably within tolerance first.
fn by_probability(locations: &[LocationResult]) -> Vec<(&str, &DeflectionSpread)> {
    let mut known: Vec<_> =
        locations.iter().filter_map(|own| Some((&*own.location.name, own.spread.as_ref()?))).collect();
    known.sort_by(|(_, a), (_, b)| a.within_tolerance.partial_cmp(&b.within_tolerance).unwrap_or(Ordering::Equal));
    known
}

/// Locations whose probability the first screen names.
const MAX_NAMED: usize = 4;

/// Returns the verdict by the distributions at the locations; empty where inputs are taken as exact.
fn probable_verdict(summary: &Summary<'_>, locations: &[LocationResult]) -> String {
    if summary.study.uncertainty.is_none() {
        return String::new();
    }
    let (known, tolerance) = (by_probability(locations), summary.study.tolerance);
    let Some((_, word)) = probable_word(summary, locations) else {
        return "The probability is known at no location, as none was solved. ".into();
    };
    let at = |(index, (name, spread)): (usize, &(&str, &DeflectionSpread))| {
        format!("{}{} at {name}", probability(spread), if index == 0 { " probability" } else { "" })
    };
    let unsolved = match locations.len() - known.len() {
        0 => String::new(),
        unsolved => format!("; not known at {unsolved} of {}", counted(locations.len(), "location")),
    };
    let all = listed_up_to(MAX_NAMED, known.iter().enumerate().map(at));
    let condition = spread_report::condition(summary.study.uncertainty.as_ref());
    format!("{word}{condition}: the superposition error is within {tolerance} mm with {all}{unsolved}. ")
}

/// Returns whether effects may be added, also in a few words, by the distributions at locations; `None` without any.
fn probable_word(summary: &Summary<'_>, locations: &[LocationResult]) -> Option<(State, &'static str)> {
    summary.study.uncertainty.as_ref()?;
    let known = by_probability(locations);
    let share = |(_, spread): &(&str, &DeflectionSpread)| spread.within_tolerance.unwrap_or_default();
    Some(match (known.first().map(share)?, known.last().map(share)?) {
        (least, _) if least >= P95 && known.len() == locations.len() => (State::Good, "Effects may be added"),
        (_, most) if most < 1.0 - P95 => (State::Bad, "Effects may not be added"),
        (_, most) if most >= P95 => (State::Partly, "Effects may not be added at every location"),
        _ => (State::Partly, "Uncertain whether effects may be added"),
    })
}

/// Returns what the distributions at locations are and what they rest on; empty where inputs are taken as exact.
fn spread_cautions(summary: &Summary<'_>, locations: &[LocationResult]) -> String {
    let Some(uncertainty) = &summary.study.uncertainty else { return String::new() };
    format!(
        "With {}: at each location the superposition error of the tool tip is solved in {}. The map, largest factors, growth and causes are nominal.\n\
         What the model leaves out does not count here: it is a share of what the force does, and says nothing of the difference between two sums.\n{}",
        spread_report::counted_inputs(uncertainty),
        counted(Draws::PER_SCRAMBLE, "draw"),
        spread_report::cautions(Some(uncertainty), &spread_counts(locations), "location", None)
    ) + &spread_report::setups_left_out(Some(uncertainty), "the superposition error")
}

/// Describes with which power of each source the superposition error grows, where that is known.
fn growth_text(location: &LocationResult) -> String {
    let text = |(scaled, name): (Scaling, &str)| {
        let fit = location.growth[scaled as usize].fit(Sum::Superposition, Followed::Tool)?;
        Some(format!("{name}^{:.2}", fit.slope))
    };
    let scaled = [(Scaling::Load, "load"), (Scaling::Errors, "errors"), (Scaling::Both, "both")];
    let powers: Vec<String> = scaled.into_iter().filter_map(text).collect();
    if powers.is_empty() { String::new() } else { format!("; the error grows as {}", powers.join(", ")) }
}

/// Formats a largest factor, with what ended the search for it: tolerance, limit of the study, or equilibrium.
fn largest_text(largest: &LargestFactor) -> String {
    match largest {
        LargestFactor::Reached(factor) => format!("{factor:.2}"),
        LargestFactor::BelowToLimit(factor) => format!("at least {factor:.2}"),
        LargestFactor::NoEquilibrium(factor, failure) => format!("{factor:.2} (then {})", failure.status),
        LargestFactor::Unsolved(failure) => format!("none ({})", failure.status),
    }
}

/// Describes the contribution of each cause at the worst tool angle of a location.
fn ablation_sentence(location: &LocationResult) -> String {
    if let Err(failure) = &location.ablation {
        return format!("  The causes cannot be separated: {}: {}.\n", failure.status, failure.reason);
    }
    let Some((worst, parts, error)) = worst_ablation(location) else { return String::new() };
    let share = |cause: Cause| {
        let tenths = (1000.0 * parts[cause as usize] / error).round();
        // No negative zero.
        let percent = typographic(&format!("{:.1}", if tenths == 0.0 { 0.0 } else { tenths / 10.0 }));
        format!("{}: {percent} %", cause_text(cause))
    };
    format!("  Where the error comes from at tool angle {:.0}°: {}.\n", worst.phi_deg, Cause::ALL.map(share).join(", "))
}

/// Names the locations at which each cause contributes most.
fn main_causes(locations: &[LocationResult]) -> String {
    let main_cause = |location: &LocationResult| {
        let (_, parts, _) = worst_ablation(location)?;
        Cause::ALL.into_iter().max_by(|a, b| parts[*a as usize].total_cmp(&parts[*b as usize]))
    };
    let mut text = String::new();
    for cause in Cause::ALL {
        let where_main = locations.iter().filter(|location| main_cause(location) == Some(cause));
        let names: Vec<&str> = where_main.map(|location| location.location.name.as_str()).collect();
        if !names.is_empty() {
            text += &format!("The largest cause at {} is: {}.\n", names.join(", "), cause_text(cause));
        }
    }
    text
}

/// Returns the first screen: main sentence, cautions and key numbers.
pub(super) fn headline(summary: &Summary<'_>, locations: &[LocationResult], not_used: &[&str]) -> Headline {
    let SuperpositionStudy { load_case, grid, tolerance, uncertainty, .. } = summary.study;
    let places = counted(summary.points, "grid point");
    let inputs =
        uncertainty.as_ref().map_or_else(|| spread_report::basis(None), |_| counted(Draws::PER_SCRAMBLE, "draw"));
    let angles = counted(load_case.phis.len(), "tool angle");
    let basis = format!("{places}, {angles}, {}, {inputs}", force_text("", load_case.force.size()));
    let probable = probable_verdict(summary, locations);
    let cautions = spread_cautions(summary, locations)
        + &load_case.cautions(not_used, "grid point", (0..grid.len()).map(|index| grid.position(index)));
    let most = summary.largest(Sum::Superposition, Followed::Tool, &SUPERPOSITION_ERROR);
    let (Some(most), Some(share)) = (most, summary.safe_share()) else {
        let sentence = format!("{probable}Nothing can be said about adding effects: none of the {places} was solved.");
        let verdict = Verdict::new(State::Bad, "Nothing could be computed");
        return Headline::new(sentence, basis).judged(verdict, false).with_cautions(&cautions);
    };
    let parts: Vec<&str> = Source::parts(&load_case.machine).iter().map(|source| source.text()).collect();
    let effects = join_text(&parts);
    let wrong = millimetres(most.value, 4);
    let relative = most.at.relative().map_or_else(String::new, |r| format!(" ({:.1} %)", 100.0 * r));
    let verdict = match share {
        1.0 => format!(
            "may be added: the superposition error is at most {wrong}{relative}, within the tolerance of {tolerance} mm."
        ),
        0.0 => format!(
            "may not be added: the superposition error is out of tolerance ({tolerance} mm) everywhere, up to {wrong}{relative}."
        ),
        share => format!(
            "may be added in {} of the box; elsewhere the superposition error is up to {wrong}{relative}, more than the tolerance of \
             {tolerance} mm.",
            percent(share)
        ),
    };
    let nominally = if uncertainty.is_some() { "nominal " } else { "" };
    let of_deflection =
        most.at.relative().map_or_else(String::new, |r| format!(", {:.1} % of the deflection", 100.0 * r));
    let details = match probable.is_empty() {
        true => String::new(),
        false => format!("{probable}Nominally, the effects of {effects} {verdict}"),
    };
    let sentence = match share {
        1.0 => format!("Superposition error: at most {wrong}{of_deflection}, everywhere."),
        _ => format!("Superposition error: up to {wrong}{of_deflection}."),
    };
    let next = match share {
        1.0 => "add the effects, or compute them at once: within tolerance it is the same.",
        _ => "compute the effects at once where adding is out of tolerance.",
    };
    Headline::new(sentence, basis)
        .judged(state(summary, locations, share), uncertainty.is_none())
        .next(next)
        .with_cautions(&details)
        .with_cautions(&cautions)
        .with_numbers(p95_key_number(locations))
        .with(error_key_number(Tolerance(*tolerance), most, &wrong, nominally))
        .with_numbers(load_key_number(summary, locations, nominally))
}

/// Returns the verdict in a few words: by the distributions at locations, else by the `share` of the box within tolerance.
fn state(summary: &Summary<'_>, locations: &[LocationResult], share: f64) -> Verdict {
    if let Some((state, text)) = probable_word(summary, locations) {
        return Verdict::new(state, text);
    }
    match share {
        1.0 => Verdict::new(State::Good, "Effects may be added"),
        0.0 => Verdict::new(State::Bad, "Effects may not be added"),
        share => Verdict::new(State::Partly, format!("Effects add up in {} of the box", percent(share))),
    }
}

/// Returns the largest 95 % quantile of the superposition error at a location; `None` where there is none.
fn p95_key_number(locations: &[LocationResult]) -> Option<KeyNumber> {
    let known = by_probability(locations).into_iter().filter_map(|(name, spread)| Some((spread.p95_mm?, name, spread)));
    let (p95, name, spread) = known.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let what = format!("largest superposition error not exceeded with 95 % probability, at the tool tip, at {name}");
    let against = format!("within tolerance with {} probability", probability(spread));
    let reference = P95_ERROR.found_in("locations.csv", &[], Extreme::Largest, p95);
    Some(KeyNumber::new(&millimetre_text(p95), what, against).found(reference))
}

/// Returns the largest superposition error, written as `wrong`, as a key number, compared with the tolerance.
fn error_key_number(tolerance: Tolerance, largest: &ValueAt<Worst>, wrong: &str, nominally: &str) -> KeyNumber {
    let what = format!("largest {nominally}superposition error, at the tool tip, with P at {}", largest.place());
    let rows = [["sum", Sum::Superposition.label()], ["followed", Followed::Tool.label()]];
    let reference = SUPERPOSITION_ERROR.found_in("map.csv", &rows, Extreme::Largest, largest.value);
    KeyNumber::new(wrong, what, tolerance.against(largest.value))
        .held_to(Some(tolerance.0), largest.value)
        .found(reference)
}

/// Returns the largest load within tolerance in the whole box as a key number; `None` where no point is solved.
fn load_key_number(summary: &Summary<'_>, locations: &[LocationResult], nominally: &str) -> Option<KeyNumber> {
    let [least, most] = summary.load_factor_extremes()?;
    let end = match least.at {
        LargestFactor::BelowToLimit(_) => "; at least so much".to_string(),
        _ => format!("; the limit is with P at {}", least.place()),
    };
    let fails = |(name, spread): &&(&str, &DeflectionSpread)| {
        (spread.within_tolerance.unwrap_or_default() < P95)
            .then(|| format!("; at {name} not even that of the study on 95 of 100 machines"))
    };
    let may_mislead = least.value >= 1.0 && summary.study.uncertainty.is_some();
    let not_so = by_probability(locations).first().as_ref().filter(|_| may_mislead).and_then(fails).unwrap_or_default();
    let what = format!(
        "of the load of the study, up to which the {nominally}superposition error is within tolerance in the whole box{end}{not_so}"
    );
    let against = format!("up to {} × where it is best", largest_text(&most.at));
    let reference = LARGEST_LOAD.found_in("safe_load.csv", &[], Extreme::Smallest, least.value);
    Some(KeyNumber::new(&format!("{:.2} ×", least.value), what, against).found(reference))
}
