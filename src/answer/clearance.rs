//! Sentences about how near bodies come along a path.

use kinetostat_budget::{Budget, Cause, Entry, Mark};

use super::machine::described;
use crate::{
    figures::{Figure, PoseFigure, Surroundings},
    files::words::{capitalised, counted, join_text, millimetres},
    page::headline::{State, Verdict},
    process::Placement,
    simulation::clearance::{ClearanceState, MachineCell, NearestBodies, PathClearance, TOUCHING_MM},
};

/// What to do next where bodies hit.
pub const MOVE_AWAY: &str =
    "move workpiece, clamps or approach until nothing is hit, and compute again: do not run the path.";

/// Returns `budget` with what is known of bodies, which it then asks about.
#[must_use]
pub fn in_budget(mut budget: Budget, clearance: Option<&PathClearance>) -> Budget {
    let Some(clearance) = clearance else { return budget };
    budget.set(match clearance.state {
        ClearanceState::Clear => Entry::counted(Cause::Bodies, Mark::Full, "apart all along the path"),
        ClearanceState::Hit => Entry::counted(Cause::Bodies, Mark::Full, "something is hit"),
        ClearanceState::Unknown if !clearance.assumed.is_empty() => Entry::unknown(Cause::Bodies, "shapes are assumed"),
        ClearanceState::Unknown => Entry::unknown(Cause::Bodies, "not all could be looked at"),
    });
    let scope = budget.scope().map(|own| {
        let mut own = own.to_vec();
        own.extend(Some(Cause::Bodies).filter(|bodies| !own.contains(bodies)));
        own
    });
    budget.within(scope)
}

/// File stem of the figure of where bodies come nearest.
pub const CLEARANCE: &str = "clearance";

/// Returns the words for the two bodies that come nearest, such as "wrist and left clamp 12.3 mm apart"; `None` where nothing was looked at.
#[must_use]
pub fn nearest_words(clearance: &PathClearance) -> Option<String> {
    let nearest = clearance.nearest.as_ref()?;
    let NearestBodies { names: [a, b], distance_mm, is_assumed, .. } = nearest;
    // What is said is so: no more than its bound, which of hits may be that of others.
    let least_mm = clearance.at_least_mm.filter(|_| clearance.state != ClearanceState::Hit);
    let known_mm = least_mm.map_or(*distance_mm, |least| least.min(*distance_mm));
    Some(match known_mm {
        depth if depth < -TOUCHING_MM => nearest.overlap_text(depth),
        depth if depth <= TOUCHING_MM => format!("{a} and {b} touch"),
        _ if *is_assumed => format!("{a} and {b} nearest"),
        apart => format!("{a} and {b} {:.1}\u{a0}mm apart", (10.0 * apart).floor() / 10.0),
    })
}

/// Draws the machine, its bodies and those around it where they come nearest with the workpiece at `placement`; `None` where nothing was looked at.
#[must_use]
pub fn figure(
    cell: &MachineCell,
    placement: &Placement,
    clearance: Option<&PathClearance>,
) -> Option<(String, Figure)> {
    let clearance = clearance?;
    let (nearest, words) = (clearance.nearest.as_ref()?, nearest_words(clearance)?);
    let open = match (clearance.assumed.is_empty(), clearance.not_looked_at.is_empty()) {
        (true, true) => None,
        (false, _) => Some("shapes are assumed: that nothing comes nearer is not known"),
        _ => Some("not all ways are looked at"),
    };
    let described = described(cell.machine());
    let figure = PoseFigure {
        title: format!("Where bodies come nearest: {words}"),
        subtitle: match nearest.point {
            Some(_) => format!("{}, as programmed", described.name),
            None => format!("{} at home: the workpiece stands in what it is put on", described.name),
        },
        pose: cell.machine().rigid_skeleton(&nearest.at),
        displaced: None,
        rails: described.rails,
        workspace: described.workspace_mm,
        surroundings: Surroundings {
            bodies: cell.outlines(&nearest.at, placement),
            nearest: Some((nearest.points_mm, words)),
            ..Surroundings::default()
        },
        note: open.map(Into::into),
    };
    Some((CLEARANCE.into(), Figure::Pose(Box::new(figure))))
}

/// Returns the verdict where bodies hit; `None` where none was found to.
#[must_use]
pub fn verdict(clearance: &PathClearance) -> Option<Verdict> {
    let nearest = clearance.nearest.as_ref().filter(|_| clearance.state == ClearanceState::Hit)?;
    let [a, b] = &nearest.names;
    let hits = if nearest.distance_mm <= TOUCHING_MM { "hits" } else { "comes too near to" };
    Some(Verdict::new(State::Bad, format!("{a} {hits} {b}")))
}

/// Returns what is known of the distances of bodies where none hits, and what is not, in sentences.
#[must_use]
pub fn sentences(clearance: &PathClearance, place: impl Fn(usize) -> String) -> String {
    let mut text = distance_sentence(clearance, place);
    if !clearance.assumed.is_empty() && clearance.state != ClearanceState::Hit {
        let names: Vec<&str> = clearance.assumed.iter().map(String::as_str).collect();
        let (shape, is) = if names.len() == 1 { ("shape", "is") } else { ("shapes", "are") };
        text += &format!("That nothing is hit is not known: the {shape} of {} {is} assumed.\n", join_text(&names));
    }
    if clearance.state == ClearanceState::Unknown
        && clearance.at_least_mm.is_some_and(|least| least - clearance.moved_mm < clearance.wanted_mm)
    {
        let moved = millimetres(clearance.moved_mm, 2);
        text += &format!("Deflection moves the tool by up to {moved}, which may be more than they are apart.\n");
    }
    if !clearance.not_looked_at.is_empty() {
        text += &format!("Not looked at for hits: {}.\n", clearance.not_looked_at.join("; "));
    }
    text
}

/// Returns the sentence on the least distance; empty where bodies hit, or nothing was looked at.
fn distance_sentence(clearance: &PathClearance, place: impl Fn(usize) -> String) -> String {
    let PathClearance { state, at_least_mm: Some(least), nearest: Some(nearest), effort: [pairs, ..], .. } = clearance
    else {
        return String::new();
    };
    if *state == ClearanceState::Hit {
        return String::new();
    }
    let NearestBodies { names: [a, b], is_assumed, point, .. } = nearest;
    let (pairs, place) = (counted(*pairs, "pair"), point.map_or_else(String::new, place));
    let told = match is_assumed {
        true => format!("of {pairs} of bodies none hits"),
        // What is said is so.
        false => format!("bodies stay at least {:.1} mm apart, of {pairs}", (10.0 * least).floor() / 10.0),
    };
    let told = match clearance.not_looked_at.is_empty() {
        true => capitalised(&told),
        false => format!("Where they were looked at, {told}"),
    };
    format!(
        "{told}; {a} and {b} come nearest, on the way to {place}. Ways to the path and back from it are not looked at.\n"
    )
}
