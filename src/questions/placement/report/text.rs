//! Sentences and small tables of a placement report: the search, the best place and its margins, the comparison with other places.

use super::{
    headline,
    quantities::{available_metrics, verdict_counts},
};
use crate::{
    files::{
        text_table::text_table,
        words::{counted, join_text, millimetres, typographic, with_minus_signs},
    },
    page::SmallTable,
    questions::{
        placement::{
            Agreement, Best, COORDINATES, End, Entry, Evaluation, Margin, Metric, Metrics, Origin, PlaceOutcome,
            PlaceSpread, PlacementResults, PlacementStudy, Refinement, Site, Start,
            site::{in_unit, printed_text, unit_suffix},
        },
        spread_report,
    },
    simulation::{Failure, spread_along::ALIKE},
};

/// Describes a place: position, and angles that are not zero.
pub(super) fn site_text(site: &Site) -> String {
    shown_text(site.shown())
}

/// Describes a place of these coordinates in mm and degrees.
fn shown_text(shown: [f64; 6]) -> String {
    let (position, angles) = position_and_angles(shown);
    if angles.is_empty() { position } else { format!("{position} at {angles}") }
}

/// Describes the position and the angles of a place of these coordinates in mm and degrees; the latter are empty where all are zero.
pub(super) fn position_and_angles([x, y, z, angles @ ..]: [f64; 6]) -> (String, String) {
    let nonzero = COORDINATES[3..].iter().zip(angles).filter(|(_, angle)| *angle != 0.0);
    let nonzero = nonzero.map(|(name, angle)| typographic(&format!("{name} {}°", printed_text(angle))));
    let position = [x, y, z].map(printed_text).join(", ");
    (typographic(&format!("({position}) mm")), nonzero.collect::<Vec<_>>().join(", "))
}

/// Metrics that the table of entries shows.
const SHOWN: [Metric; 8] = [
    Metric::WorstDeflection,
    Metric::RmsDeflection,
    Metric::WorstCorrection,
    Metric::WorstDriveForce,
    Metric::WorstRotaryCorrection,
    Metric::WorstRotaryTorque,
    Metric::WorstResidual,
    Metric::ShareWithin,
];

/// Returns a table of the entries, ranked, and why some cannot be cut.
pub fn entries_table(study: &PlacementStudy, entries: &[Entry]) -> String {
    let machine = &study.machine;
    let shown: Vec<Metric> = available_metrics(study).filter(|metric| SHOWN.contains(metric)).collect();
    let is_tilted = entries.iter().any(|entry| entry.site.0[4..] != [0.0; 2]);
    let angles = if is_tilted { 3..6 } else { 3..4 };
    let mut header = vec!["place".to_string(), "x, y, z [mm]".into()];
    header.extend(COORDINATES[angles.clone()].iter().map(|name| format!("{name} [°]")));
    header.extend(shown.iter().map(|metric| metric.short_text(machine).into()));
    let mut table = text_table(header, 1);
    for entry in entries {
        let shown_site = entry.site.shown();
        let [x, y, z, ..] = shown_site;
        let mut row = vec![entry.name.clone(), [x, y, z].map(printed_text).join(", ")];
        row.extend(shown_site[angles.clone()].iter().copied().map(printed_text));
        match &entry.outcome {
            Ok(evaluation) => row.extend(shown.iter().map(|metric| {
                evaluation.metrics.get(*metric).map_or_else(|| "–".into(), |value| metric.value_text(machine, value))
            })),
            Err(failure) => row.push(failure.status.replace('_', " ")),
        }
        if entry.outcome.is_ok() && entry.feasible().is_none() {
            row[0] += " (outside)";
        }
        table.add_row(row);
    }
    let reasons = entries
        .iter()
        .filter_map(|entry| Some(format!("{}: {}.\n", entry.name, with_minus_signs(&entry.refusal()?.reason))));
    format!("{table}\n{}", reasons.collect::<String>())
}

/// Returns the sentences about the search: study, objective, and number of places evaluated.
pub(super) fn search_text(results: &PlacementResults) -> String {
    let study = &results.study;
    let [complete, pruned, infeasible] = verdict_counts(results);
    let points: usize = study.features.iter().map(|job| job.feature.path.len()).sum();
    format!(
        "{}: {}, {}; objective (minimised): {}.\nSweep of {}: {complete} evaluated on the whole path, {pruned} stopped \
         early because they could not beat the best any more, {infeasible} where the workpiece cannot be cut.\n{}",
        study.machine.name,
        counted(study.features.len(), "feature"),
        counted(points, "path point"),
        study.objective.text(&study.machine),
        counted(results.cells.len(), "place"),
        coarseness_text(results)
    )
}

/// Returns all sentences of the report.
pub fn summary_text(results: &PlacementResults) -> String {
    search_text(results) + &place_text(results) + &certainty_text(results)
}

/// Returns the sentences about places that the sweep is too coarse for.
fn coarseness_text(results: &PlacementResults) -> String {
    let gaps = &results.gaps;
    let mut text = String::new();
    if !gaps.sites.is_empty() {
        text += &format!("Between its places the workpiece fits at {} more, the best looked for.\n", gaps.sites.len());
    }
    if !gaps.coarse.is_empty() {
        let study = &results.study;
        let step = |&i: &usize| {
            format!("{} ({:.1}{})", COORDINATES[i], in_unit(i, study.grid.step(i, &study.bounds)), unit_suffix(i))
        };
        let steps: Vec<String> = gaps.coarse.iter().map(step).collect();
        text += &format!(
            "The sweep is coarser than the regions that it found: its steps along {} are wider than some of them. More such regions may \
             lie between; a finer [placement.search] grid would show it.\n",
            steps.join(", ")
        );
    }
    text
}

/// Returns the sentences about the recommended place and its comparison with the others, or why there is none.
pub(super) fn place_text(results: &PlacementResults) -> String {
    match &results.best {
        Some(best) => best_place_text(results, best) + &comparison_text(results),
        None => infeasible_text(results),
    }
}

/// Returns the sentences about how sure the numbers of the place are, how it was found, and its margins.
pub(super) fn certainty_text(results: &PlacementResults) -> String {
    let Some(best) = &results.best else { return String::new() };
    spread_text(results) + &how_found_text(results, best) + &margins_text(results)
}

/// Returns the sentences about the distributions at the recommended place; empty where inputs are taken as exact.
fn spread_text(results: &PlacementResults) -> String {
    let spread = best_entry(results).and_then(|(entry, _)| entry.spread.as_ref());
    let Some(spread) = spread else { return String::new() };
    spread_report::along_sentences(&headline::along(&results.study), &spread.largest) + &unconfirmed_text(results)
}

/// Returns the sentence about estimates that draws of the engine along the whole paths do not confirm; empty where they confirm all.
fn unconfirmed_text(results: &PlacementResults) -> String {
    let is_open = |own: &PlaceSpread| {
        let all = [Some(&own.largest.plain), own.largest.compensated.as_ref()];
        all.into_iter().flatten().any(|own| !own.is_confirmed)
    };
    let is_open = |entry: &&Entry| entry.spread.as_ref().is_some_and(is_open);
    let open: Vec<&str> = results.entries.iter().filter(is_open).map(|entry| entry.name.as_str()).collect();
    match open[..] {
        [] => "The engine, solved along all paths at each place in draws next to the 95 % quantile, confirms the estimates.\n".into(),
        _ => format!("Estimates that draws of the engine along all paths do not confirm: {}.\n", join_text(&open)),
    }
}

/// Probability of being worse than another place from which on the two are told apart.
const TOLD_APART: f64 = 0.95;

/// Returns the sentences about the place that is the best by its 95 % quantile, and those not told apart from it; empty where inputs are exact.
pub(super) fn robust_text(results: &PlacementResults) -> String {
    let Some((recommended, _)) = best_entry(results) else { return String::new() };
    let with_spread = results.entries.iter().filter_map(|entry| Some((entry, entry.spread.as_ref()?)));
    let with_spread: Vec<(&Entry, &PlaceSpread)> = with_spread.collect();
    let p95 = |spread: &PlaceSpread| spread.largest.plain.spread.p95_mm;
    let words =
        |spread: &PlaceSpread| p95(spread).map_or_else(|| "an unknown distance".into(), |own| millimetres(own, 3));
    let inside = || with_spread.iter().filter(|(entry, _)| results.study.bounds.inside(&entry.site).is_some());
    let order = |spread: &PlaceSpread| p95(spread).unwrap_or(f64::INFINITY);
    let robust = inside().min_by(|a, b| order(a.1).total_cmp(&order(b.1)));
    let (Some((robust, at_robust)), Some(own)) = (robust, &recommended.spread) else { return String::new() };
    // What the estimate is good for.
    let is_as_good =
        |own: Option<f64>, least: Option<f64>| own.zip(least).is_some_and(|(own, least)| own <= (1.0 + ALIKE) * least);
    if p95(at_robust).is_none() {
        return "No place within the bounds has a 95 % quantile: too many draws have no equilibrium.\n".into();
    }
    let alike_best = is_as_good(p95(own), p95(at_robust));
    let mut text = match alike_best {
        true => format!(
            "By what is not exceeded with 95 % probability without compensation, {}, no place within the bounds is better",
            words(own)
        ),
        false => format!(
            "By what is not exceeded with 95 % probability without compensation {} is better, with {} for {} here",
            robust.name,
            words(at_robust),
            words(own)
        ),
    };
    text += &format!(
        "; the place recommended is the best of {} with {} probability",
        counted(with_spread.len(), "place"),
        spread_report::probability(own.best)
    );
    let most = with_spread.iter().max_by(|a, b| a.1.best.total_cmp(&b.1.best)).filter(|(_, most)| most.best > own.best);
    text += &most.map_or_else(String::new, |(entry, most)| {
        format!(", {} with {}", entry.name, spread_report::probability(most.best))
    });
    text += ".\n";
    let left = |spread: &PlaceSpread| spread.largest.compensated.as_ref().and_then(|own| own.spread.p95_mm);
    let least_left =
        inside().filter_map(|(entry, spread)| Some((entry, left(spread)?))).min_by(|a, b| a.1.total_cmp(&b.1));
    if let (Some((entry, least)), Some(here)) = (least_left, left(own))
        && !is_as_good(Some(here), Some(least))
        && !results.study.has_limits()
    {
        let lengths = [least, here].map(|length| millimetres(length, 3));
        text += &format!("With compensation {} is better, with {} for {} here.\n", entry.name, lengths[0], lengths[1]);
    }
    let is_alike = |spread: &PlaceSpread| p95(spread).is_some() && spread.worse_than_robust < TOLD_APART;
    let is_it = |entry: &Entry| entry.name == robust.name || (alike_best && entry.name == recommended.name);
    let alike = inside().filter(|(entry, spread)| !is_it(entry) && is_alike(spread));
    let alike: Vec<&str> = alike.map(|(entry, _)| entry.name.as_str()).collect();
    if !alike.is_empty() {
        text += &format!(
            "Not to be told apart from {}, as they are worse by more than 0.5 % with less than 95 % probability: {}.\n",
            if alike_best { "the place recommended" } else { &robust.name },
            join_text(&alike)
        );
    }
    text
}

/// Returns the sentences that the workpiece can be cut at no place, with a reason of each kind and of how many places it is.
pub(super) fn infeasible_text(results: &PlacementResults) -> String {
    let mut kinds: Vec<(&Site, &Failure, usize)> = Vec::new();
    for cell in &results.cells {
        let PlaceOutcome::Infeasible(failure) = &cell.verdict else { continue };
        match kinds.iter_mut().find(|(_, own, _)| own.status == failure.status) {
            Some((_, _, count)) => *count += 1,
            None => kinds.push((&cell.site, failure, 1)),
        }
    }
    kinds.sort_by_key(|(_, _, count)| std::cmp::Reverse(*count));
    let elsewhere: Vec<&str> =
        results.entries.iter().filter(|entry| entry.feasible().is_some()).map(|entry| entry.name.as_str()).collect();
    let mut text = match verdict_counts(results) {
        [.., 0] => "There is no place to judge.\n".into(),
        [.., n] => format!("The workpiece can be cut at none of the {n} places within the bounds that were tried.\n"),
    };
    for (site, Failure { reason, .. }, count) in kinds {
        // Which of them is told is an example; the tables have it in full.
        let near = shown_text(site.shown().map(|value| (10.0 * value).round() / 10.0));
        text += &format!("At {count} of them, such as {near}: {reason}.\n");
    }
    if !elsewhere.is_empty() {
        text += &format!("Outside the bounds the workpiece can be cut: {}.\n", elsewhere.join(", "));
    }
    text
}

/// Returns the recommended entry with its evaluation; `None` if the workpiece can be cut nowhere.
pub(super) fn best_entry(results: &PlacementResults) -> Option<(&Entry, &Evaluation)> {
    let entry = results.entries.get(results.best.as_ref()?.entry)?;
    Some((entry, entry.feasible()?))
}

/// Returns the sentences about deflections, corrections and residual errors at the recommended place.
fn best_place_text(results: &PlacementResults, best: &Best) -> String {
    let machine = &results.study.machine;
    let allowance = &results.study.allowance;
    let within = match allowance.is_none() {
        true => String::new(),
        false => format!(", wherever it is clamped within {}", allowance.text()),
    };
    let mut text = format!("At the recommended place, {}{within}:", site_text(&best.site));
    let Some((_, evaluation)) = best_entry(results) else { return text + "\n" };
    let value = |metric: Metric| Some(metric.value_text(machine, evaluation.metrics.get(metric)?));
    if let (Some(worst), Some(rms)) = (value(Metric::WorstDeflection), value(Metric::RmsDeflection)) {
        text += &format!(" without compensation the tool leaves its path by up to {worst} (rms {rms})");
        let within = value(Metric::ShareWithin).unwrap_or_default();
        text += &format!("; on {within} of the path that is within tolerance.");
        let placed = evaluation
            .as_placed
            .get(Metric::WorstDeflection)
            .map(|own| Metric::WorstDeflection.value_text(machine, own));
        if let Some(placed) = placed.filter(|placed| *placed != worst) {
            text += &format!(" With the workpiece exactly there it is {placed} at most.");
        }
    }
    if let (Some(correction), Some(force)) = (value(Metric::WorstCorrection), value(Metric::WorstDriveForce)) {
        let revolute = value(Metric::WorstRotaryCorrection).zip(value(Metric::WorstRotaryTorque));
        text += &match revolute {
            None => format!(
                " To keep the tool there, correct the drives by up to {correction}; the drives then carry up to {force}."
            ),
            Some((turn, torque)) => format!(
                " To keep the tool there, correct the prismatic joints by up to {correction} and the revolute joints by up to {turn}; the \
                 drives then carry up to {force} and {torque}."
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

/// Deflections below this count as none, so that no ratio to them is given, mm.
pub(super) const NO_DEFLECTION: f64 = 1e-6;

/// Returns the sentences that compare the worst deflection at the other named places.
fn comparison_text(results: &PlacementResults) -> String {
    let Some((recommended, best)) = best_entry(results) else { return String::new() };
    let worst = |evaluation: &Evaluation| evaluation.metrics.get(Metric::WorstDeflection);
    let Some(at_best) = worst(best) else { return String::new() };
    let named = results.entries.iter().filter(|entry| entry.found == Origin::Named && entry.name != recommended.name);
    let compared: Vec<String> = named
        .map(|entry| match &entry.outcome {
            Ok(evaluation) => {
                let deflection = worst(evaluation).unwrap_or(at_best);
                let mut notes = Vec::new();
                if at_best > NO_DEFLECTION {
                    notes.push(typographic(&format!("{:+.0} %", 100.0 * (deflection / at_best - 1.0))));
                }
                if evaluation.outside_workspace.is_some() {
                    notes.push("outside the machine's workspace box".into());
                }
                if notes.is_empty() {
                    format!("{} {deflection:.3} mm", entry.name)
                } else {
                    format!("{} {deflection:.3} mm ({})", entry.name, notes.join(", "))
                }
            }
            Err(failure) => format!("{} cannot be cut at ({})", entry.name, failure.status.replace('_', " ")),
        })
        .collect();
    match compared.as_slice() {
        [] => String::new(),
        places => {
            let note = if results.study.seeks_gamma() { ", as programmed" } else { "" };
            format!("Worst deflection at the named places{note}: {}.\n{}", places.join(", "), better_text(results))
        }
    }
}

/// Returns the sentence about places with a better objective, and why they are not recommended.
fn better_text(results: &PlacementResults) -> String {
    let Some((recommended, _)) = best_entry(results) else { return String::new() };
    let ahead = |entry: &&Entry| entry.value < recommended.value && entry.outcome.is_ok();
    let reason = |entry: &Entry| match entry.feasible() {
        Some(_) => format!("{} (outside the bounds)", entry.name),
        None => format!("{} (outside the machine's workspace box)", entry.name),
    };
    let places: Vec<String> = results.entries.iter().filter(ahead).map(reason).collect();
    match places.as_slice() {
        [] => String::new(),
        places => format!("Better by the objective, but not possible: {}.\n", places.join(", ")),
    }
}

/// Returns the sentence about how the best place was found, and how the refinements agree.
fn how_found_text(results: &PlacementResults, best: &Best) -> String {
    let count = |agreement| best.agreement.iter().filter(|a| **a == agreement).count();
    let (same, elsewhere) = (count(Agreement::Same), count(Agreement::Elsewhere));
    let total = best.agreement.len();
    let mut text = match best.found {
        Origin::Refinement(index) => {
            let refinement = &results.refinements[index];
            format!(
                "Refinement {} of {total} found the place, from {}{}, in {}",
                index + 1,
                start_text(results, refinement),
                gain_text(results, best),
                counted(refinement.iterations, "iteration"),
            ) + &convergence_text(refinement)
        }
        Origin::Named => {
            format!("The best place is the named one {}; no refinement beats it", results.entries[best.entry].name)
        }
        Origin::Sweep => "The best place is that of the sweep; no refinement beats it".into(),
    };
    let end = if same == 1 { "ends" } else { "end" };
    text += &format!("; {same} of {} {end} there", counted(total, "refinement"));
    if elsewhere > 0 {
        text +=
            &format!(", {elsewhere} elsewhere with the same value (there are several such places, or one flat one)");
    }
    text + ".\n"
}

/// Describes where a refinement started.
fn start_text(results: &PlacementResults, refinement: &Refinement) -> String {
    match refinement.from {
        Start::Sweep => {
            let rank = results.ranking.iter().position(|&cell| results.cells[cell].site == refinement.start);
            format!("place {} of the sweep", rank.map_or(0, |rank| rank + 1))
        }
        Start::Between => format!("{}, between the places of the sweep", site_text(&refinement.start)),
        Start::Named(index) => format!("the named place {}", results.study.candidates[index].name),
    }
}

/// Describes how much better the best place is than the best of the sweep; no better where both are zero.
fn gain_text(results: &PlacementResults, best: &Best) -> String {
    let study = &results.study;
    let swept = results.ranking.first().and_then(|&index| results.cells[index].complete());
    let Some(swept) = swept.map(|metrics| study.objective.value(metrics)) else { return String::new() };
    match study.is_zero(swept - best.value) || study.is_zero(swept) {
        true => ", no better than the best of the sweep".into(),
        false => format!(", {:.2} % better than the best of the sweep", 100.0 * (swept - best.value) / swept.abs()),
    }
}

/// Describes whether a refinement converged and how often it used up its iterations.
fn convergence_text(refinement: &Refinement) -> String {
    let continued = match refinement.continued {
        0 => String::new(),
        1 => "once the search went on after max_iterations".into(),
        count => format!("{count} times the search went on after max_iterations"),
    };
    match (refinement.is_converged, continued.is_empty()) {
        (true, true) => String::new(),
        (true, false) => format!(" ({continued})"),
        (false, true) => " (not converged)".into(),
        (false, false) => format!(" (not converged: {continued}; a larger max_iterations may find a better place)"),
    }
}

/// Returns the direction of a margin: "+x".
pub(super) fn direction_text(margin: &Margin) -> String {
    let sign = if margin.direction > 0.0 { "+" } else { "\u{2212}" };
    format!("{sign}{}", COORDINATES[margin.coordinate])
}

/// Returns the sentence about the margins of the best place.
fn margins_text(results: &PlacementResults) -> String {
    let words_of = |margin: &Margin| {
        let i = margin.coordinate;
        // What is said can be done.
        let distance = (10.0 * in_unit(i, margin.distance) + 1e-6).floor() / 10.0;
        let end = match &margin.end {
            End::Worse => "",
            End::Bound => " (its bound)",
            End::Nowhere => " (any angle)",
            End::Infeasible(_) => " (then the workpiece cannot be cut)",
        };
        format!("{} {distance:.1}{}{end}", direction_text(margin), unit_suffix(i))
    };
    match results.flatness.as_slice() {
        [] => String::new(),
        margins => {
            let margins: Vec<String> = margins.iter().map(words_of).collect();
            format!("Moved from there, the objective is 5 % worse after {}.\n", margins.join(", "))
        }
    }
}

/// Smallest relative difference of one metric from which a compromise is shown beside the one before.
const DIFFERENT: f64 = 0.02;

/// Returns a table of the compromises that differ, with the coordinates that vary; `None` where there are fewer than two.
pub(super) fn compromises_table(results: &PlacementResults) -> Option<SmallTable> {
    let study = &results.study;
    let metrics = &study.objective.pareto;
    let differs = |a: &Metrics, b: &Metrics| {
        metrics.iter().any(|metric| match (a.get(*metric), b.get(*metric)) {
            (Some(a), Some(b)) => (a - b).abs() > DIFFERENT * a.abs().max(b.abs()),
            _ => true,
        })
    };
    let mut shown: Vec<&(Site, Metrics)> = results.front.iter().collect();
    shown.dedup_by(|next, last| !differs(&last.1, &next.1));
    if shown.len() < 2 {
        return None;
    }
    let text = |site: &Site, i: usize| typographic(&format!("{}{}", printed_text(site.shown()[i]), unit_suffix(i)));
    let varies = |i: &usize| shown.iter().any(|(site, _)| text(site, *i) != text(&shown[0].0, *i));
    let free: Vec<usize> = (0..COORDINATES.len()).filter(varies).collect();
    let header = free.iter().map(|&i| COORDINATES[i].to_string());
    let header = header.chain(metrics.iter().map(|metric| metric.text(&study.machine).to_string())).collect();
    let row = |(site, values): &&(Site, Metrics)| {
        let places = free.iter().map(|&i| text(site, i));
        let numbers = metrics.iter().map(|metric| {
            values.get(*metric).map_or_else(|| "–".to_string(), |value| metric.value_text(&study.machine, value))
        });
        places.chain(numbers).collect()
    };
    let caption = format!(
        "Compromises: no place is better in all of these; {} of {} shown, those that differ by {:.0} % in one of them",
        shown.len(),
        results.front.len(),
        100.0 * DIFFERENT
    );
    Some(SmallTable { caption, header, rows: shown.iter().map(row).collect() })
}
