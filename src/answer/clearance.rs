//! Sentences about how near bodies come along a path.

use crate::{
    files::words::{counted, join_text},
    page::headline::{State, Verdict},
    simulation::clearance::{ClearanceState, NearestBodies, PathClearance},
};

/// What to do next where bodies hit.
pub const MOVE_AWAY: &str =
    "move workpiece, clamps or approach until nothing is hit, and compute again: do not run the path.";

/// Returns the verdict where bodies hit; `None` where none was found to.
#[must_use]
pub fn verdict(clearance: &PathClearance) -> Option<Verdict> {
    let nearest = clearance.nearest.as_ref().filter(|_| clearance.state() == ClearanceState::Hit)?;
    let [a, b] = &nearest.names;
    let hits = if nearest.distance_mm <= 0.0 { "hits" } else { "comes too near to" };
    Some(Verdict::new(State::Bad, format!("{a} {hits} {b}")))
}

/// Returns the first sentence where bodies hit; `place` describes a point of the path. `None` where none was found to.
#[must_use]
pub fn first_sentence(clearance: &PathClearance, place: impl Fn(usize) -> String) -> Option<String> {
    let nearest = clearance.nearest.as_ref().filter(|_| clearance.state() == ClearanceState::Hit)?;
    let NearestBodies { names: [a, b], distance_mm, is_assumed, point, .. } = nearest;
    let assumed = if *is_assumed { ", as far as their assumed shapes say" } else { "" };
    let place = place(*point);
    Some(match *distance_mm {
        depth if depth <= 0.0 => {
            format!("{a} and {b} overlap by up to {:.1} mm on the way to {place}{assumed}.", -depth)
        }
        distance => format!(
            "{a} and {b} come within {distance:.1} mm of each other on the way to {place}, and {} mm are wanted{assumed}.",
            clearance.wanted_mm
        ),
    })
}

/// Returns what is known of the distances of bodies where none hits, and what is not, in sentences.
#[must_use]
pub fn sentences(clearance: &PathClearance, place: impl Fn(usize) -> String) -> String {
    let PathClearance { at_least_mm, nearest, assumed, not_looked_at, effort: [pairs, ..], .. } = clearance;
    let mut text = match (clearance.state(), at_least_mm, nearest) {
        (ClearanceState::Hit, ..) => String::new(),
        (_, Some(least), Some(NearestBodies { names: [a, b], is_assumed, point, .. })) => {
            let pairs = counted(*pairs, "pair");
            let place = place(*point);
            match is_assumed {
                true => format!("Of {pairs} of bodies none hits, {a} and {b} come nearest, on the way to {place}.\n"),
                false => format!(
                    "Bodies stay at least {least:.1} mm apart: of {pairs}, {a} and {b} come nearest, on the way to {place}.\n"
                ),
            }
        }
        _ => "No pair of bodies could be looked at.\n".into(),
    };
    if !assumed.is_empty() {
        let names: Vec<&str> = assumed.iter().map(String::as_str).collect();
        let (shape, is) = if names.len() == 1 { ("shape", "is") } else { ("shapes", "are") };
        text += &format!("That nothing is hit is not known: the {shape} of {} {is} assumed.\n", join_text(&names));
    }
    if !not_looked_at.is_empty() {
        text += &format!("Bodies were not looked at on {}.\n", not_looked_at.join("; nor on "));
    }
    text
}
