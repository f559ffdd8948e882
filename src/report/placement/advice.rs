//! The recommendation in plain sentences.

use super::{summary::at, tables::is_found};
use crate::{
    report::{words::counted, words::typographic},
    study::placement::{
        Agreement, Best, COORDINATES, End, Entry, Evaluation, Metric, PlacementResults, Room, is_angle,
    },
};

/// Where to put the workpiece, what that brings and how much room there is.
pub fn recommendation(results: &PlacementResults) -> String {
    let Some(best) = &results.best else { return nowhere(results) };
    let mut text = headline(results, best);
    text += &comparison(results);
    text += &found(results, best);
    text += &room(results);
    text
}

/// Why the workpiece cannot be cut.
fn nowhere(results: &PlacementResults) -> String {
    let cell = results.cells.iter().find_map(|cell| match &cell.verdict {
        crate::study::placement::Verdict::Infeasible(failure) => Some((at(&cell.site), &failure.reason)),
        _ => None,
    });
    match cell {
        Some((place, reason)) => {
            format!("The workpiece can be cut at none of the places. The first, {place}: {reason}.\n")
        }
        None => "There is no place to judge.\n".into(),
    }
}

fn best_entry(results: &PlacementResults) -> Option<(&Entry, &Evaluation)> {
    let found = results.entries.iter().filter(|entry| is_found(entry));
    found.filter_map(|entry| Some((entry, entry.outcome.as_ref().ok()?))).next()
}

fn headline(results: &PlacementResults, best: &Best) -> String {
    let machine = &results.study.machine;
    let mut text = format!("Put the workpiece at {}.", at(&best.site));
    let Some((_, evaluation)) = best_entry(results) else { return text + "\n" };
    let value = |metric: Metric| Some(metric.shown(machine, evaluation.metrics.get(metric)?));
    if let (Some(worst), Some(rms)) = (value(Metric::WorstDeflection), value(Metric::RmsDeflection)) {
        text += &format!(" Without compensation the tool leaves its path by up to {worst} there (rms {rms})");
        let within = value(Metric::ShareWithin).unwrap_or_default();
        text += &format!("; {within} of the path is within tolerance.");
    }
    if let (Some(correction), Some(force)) = (value(Metric::WorstCorrection), value(Metric::WorstDriveForce)) {
        let hinges = value(Metric::WorstHingeCorrection).zip(value(Metric::WorstHingeTorque));
        text += &match hinges {
            None => format!(
                " To keep it on the path, drives must be corrected by up to {correction} and carry up to {force}."
            ),
            Some((turn, torque)) => format!(
                " To keep it on the path, slides must be corrected by up to {correction} and carry up to {force}, \
                 hinges by up to {turn} and {torque}."
            ),
        };
    }
    if let (Some(left), Some(within)) = (value(Metric::WorstResidual), value(Metric::ShareWithinCorrected)) {
        text +=
            &format!(" Within the limits given, {left} of error remain, with {within} of the path within tolerance.");
    }
    if let Some(reason) = &evaluation.not_corrected {
        text += &format!(" There is no correction within the limits given: {reason}.");
    }
    text + "\n"
}

/// How much better that is than the named places.
fn comparison(results: &PlacementResults) -> String {
    let Some((_, best)) = best_entry(results) else { return String::new() };
    let worst = |evaluation: &Evaluation| evaluation.metrics.get(Metric::WorstDeflection);
    let Some(at_best) = worst(best) else { return String::new() };
    let named = results.entries.iter().filter(|entry| !is_found(entry));
    let compared: Vec<String> = named
        .map(|entry| match &entry.outcome {
            Ok(evaluation) => {
                let there = worst(evaluation).unwrap_or(at_best);
                let more = typographic(&format!("{:+.0}", 100.0 * (there / at_best - 1.0)));
                format!("{} {there:.3} mm ({more} %)", entry.name)
            }
            Err(failure) => format!("{} cannot be cut at ({})", entry.name, failure.status.replace('_', " ")),
        })
        .collect();
    match compared.as_slice() {
        [] => String::new(),
        places => format!("Worst deflection at the named places: {}.\n{}", places.join(", "), better(results)),
    }
}

/// Named places that are better than all that were found: they lie outside the bounds, or the search ended early.
fn better(results: &PlacementResults) -> String {
    let Some((found, _)) = best_entry(results) else { return String::new() };
    let ahead = results.entries.iter().filter(|entry| entry.value < found.value);
    let names: Vec<&str> = ahead.map(|entry| entry.name.as_str()).collect();
    match names.as_slice() {
        [] => String::new(),
        names => format!("By the objective better than any place found within the bounds: {}.\n", names.join(", ")),
    }
}

fn found(results: &PlacementResults, best: &Best) -> String {
    let count = |agreement| best.agreement.iter().filter(|a| **a == agreement).count();
    let (same, elsewhere) = (count(Agreement::Same), count(Agreement::Elsewhere));
    let total = best.agreement.len();
    let gain = results.ranking.first().and_then(|&index| results.cells[index].complete()).map(|metrics| {
        let swept = results.study.objective.value(metrics);
        100.0 * (swept - best.value) / swept.abs().max(f64::MIN_POSITIVE)
    });
    let mut text = match best.refinement {
        Some(index) => {
            let refinement = &results.refinements[index];
            let start = results.ranking.iter().position(|&cell| results.cells[cell].site == refinement.start);
            format!(
                "Refinement {} of {total} found it, from place {} of the sweep, {:.2} % better than the best of the \
                 sweep, in {}",
                index + 1,
                start.map_or(0, |rank| rank + 1),
                gain.unwrap_or(0.0),
                counted(refinement.iterations, "iteration"),
            ) + if refinement.is_converged { "" } else { " (not converged)" }
        }
        None => "It is the best place of the sweep; no refinement improved on it".into(),
    };
    let end = if same == 1 { "ends" } else { "end" };
    text += &format!("; {same} of {} {end} there", counted(total, "refinement"));
    if elsewhere > 0 {
        text +=
            &format!(", {elsewhere} elsewhere with the same value (there are several such places, or one flat one)");
    }
    text + ".\n"
}

/// How far the workpiece may be moved.
fn room(results: &PlacementResults) -> String {
    let way = |room: &Room| {
        let i = room.coordinate;
        let sign = if room.direction > 0.0 { "+" } else { "\u{2212}" };
        let (distance, unit) = if is_angle(i) { (room.distance.to_degrees(), "°") } else { (room.distance, " mm") };
        let end = match &room.end {
            End::Worse => "",
            End::Bound => " (its bound)",
            End::Infeasible(_) => " (then it cannot be cut)",
        };
        format!("{sign}{} {distance:.1}{unit}{end}", COORDINATES[i])
    };
    match results.flatness.as_slice() {
        [] => String::new(),
        ways => {
            let ways: Vec<String> = ways.iter().map(way).collect();
            format!("Moved from there, the objective is 5 % worse after {}.\n", ways.join(", "))
        }
    }
}
