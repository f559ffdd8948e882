//! A placement study's ranked table for the screen, its closing words and a small JSON object.

use serde_json::{Map, Value, json};

use crate::{
    files::{
        text_table::text_table,
        words::{counted, position, signed, typographic},
    },
    questions::placement::{
        Agreement, COORDINATES, End, Entry, Found, Metric, Metrics, PlacementResults, PlacementStudy, Site, UNITS,
        Verdict, is_angle,
        report::advice::{certainty, place},
    },
};

/// A place in words.
pub(super) fn at(site: &Site) -> String {
    let [x, y, z, angles @ ..] = site.shown();
    let turned = COORDINATES[3..].iter().zip(angles).filter(|(_, angle)| *angle != 0.0);
    let turned: Vec<String> = turned.map(|(name, angle)| typographic(&format!("{name} {angle:.1}°"))).collect();
    match turned.as_slice() {
        [] => position(x, y, z),
        turned => format!("{} at {}", position(x, y, z), turned.join(", ")),
    }
}

pub(super) fn agreement_word(agreement: Agreement) -> &'static str {
    match agreement {
        Agreement::Same => "same",
        Agreement::Elsewhere => "same_value_elsewhere",
        Agreement::Worse => "worse",
    }
}

/// Metrics shown side by side on the screen.
const SHOWN: [Metric; 8] = [
    Metric::WorstDeflection,
    Metric::RmsDeflection,
    Metric::WorstCorrection,
    Metric::WorstDriveForce,
    Metric::WorstHingeCorrection,
    Metric::WorstHingeTorque,
    Metric::WorstResidual,
    Metric::ShareWithin,
];

/// The entries side by side, ranked.
pub fn entries_table(study: &PlacementStudy, entries: &[Entry]) -> String {
    let machine = &study.machine;
    let has_limits = study.features.iter().any(|job| job.limits.is_limited());
    let is_shown = |metric: &Metric| metric.exists_on(machine) && (has_limits || !metric.is_bounded());
    let shown: Vec<Metric> = SHOWN.into_iter().filter(is_shown).collect();
    let is_tilted = entries.iter().any(|entry| entry.site.0[4..] != [0.0; 2]);
    let angles = if is_tilted { 3..6 } else { 3..4 };
    let mut header = vec!["place".to_string(), "x, y, z [mm]".into()];
    header.extend(COORDINATES[angles.clone()].iter().map(|name| format!("{name} [°]")));
    header.extend(shown.iter().map(|metric| metric.short_words(machine).into()));
    let mut table = text_table(header, 1);
    for entry in entries {
        let shown_site = entry.site.shown();
        let [x, y, z, ..] = shown_site;
        let mut row = vec![entry.name.clone(), format!("{x:.2}, {y:.2}, {z:.2}")];
        row.extend(shown_site[angles.clone()].iter().map(|angle| format!("{angle:.1}")));
        match &entry.outcome {
            Ok(evaluation) => row.extend(shown.iter().map(|metric| {
                evaluation.metrics.get(*metric).map_or_else(|| "–".into(), |value| metric.shown(machine, value))
            })),
            Err(failure) => row.push(failure.status.replace('_', " ")),
        }
        if entry.outcome.is_ok() && entry.feasible().is_none() {
            row[0] += " (outside)";
        }
        table.add_row(row);
    }
    let reasons =
        entries.iter().filter_map(|entry| Some(format!("{}: {}.\n", entry.name, signed(&entry.refusal()?.reason))));
    format!("{table}\n{}", reasons.collect::<String>())
}

/// What was sought, and how many places were looked at.
pub(super) fn search(results: &PlacementResults) -> String {
    let study = &results.study;
    let [complete, stopped, infeasible] = counts(results);
    let points: usize = study.features.iter().map(|job| job.feature.path.len()).sum();
    format!(
        "{}: {}, {}; objective (minimised): {}.\nSweep of {}: {complete} evaluated on the whole path, {stopped} stopped \
         early because they could not beat the best any more, {infeasible} where the workpiece cannot be cut.\n{}",
        study.machine.title,
        counted(study.features.len(), "feature"),
        counted(points, "path point"),
        study.objective.words(&study.machine),
        counted(results.cells.len(), "place"),
        coarseness(results)
    )
}

/// Everything that is said: what was sought, how it was found, and the recommendation.
pub fn summary_text(results: &PlacementResults) -> String {
    search(results) + &place(results) + &certainty(results)
}

/// What the sweep is too coarse for.
fn coarseness(results: &PlacementResults) -> String {
    let gaps = &results.gaps;
    let mut text = String::new();
    if !gaps.sites.is_empty() {
        text += &format!("Between its places the workpiece fits at {} more that were looked for.\n", gaps.sites.len());
    }
    if !gaps.coarse.is_empty() {
        let study = &results.study;
        let step = |&i: &usize| {
            let (step, unit) = (study.grid.step(i, &study.bounds), if is_angle(i) { "°" } else { " mm" });
            format!("{} ({:.1}{unit})", COORDINATES[i], if is_angle(i) { step.to_degrees() } else { step })
        };
        let steps: Vec<String> = gaps.coarse.iter().map(step).collect();
        text += &format!(
            "The sweep is coarser than the room that it found: its steps along {} are wider than some of it. More such \
             room may lie between; a finer [placement.search] grid would show it.\n",
            steps.join(", ")
        );
    }
    text
}

/// Places evaluated on all points, given up, and infeasible.
pub(super) fn counts(results: &PlacementResults) -> [usize; 3] {
    let mut counts = [0; 3];
    for cell in &results.cells {
        counts[match cell.verdict {
            Verdict::Complete(_) => 0,
            Verdict::GivenUp(_) => 1,
            Verdict::Infeasible(_) => 2,
        }] += 1;
    }
    counts
}

fn site_json(site: &Site) -> Value {
    let coordinates = COORDINATES.iter().zip(UNITS).zip(site.shown());
    coordinates.map(|((name, unit), value)| (format!("{name}_{unit}"), json!(value))).collect::<Map<_, _>>().into()
}

fn metrics_json(study: &PlacementStudy, metrics: &Metrics) -> Value {
    let given = Metric::ALL.into_iter().filter_map(|metric| {
        let value = metrics.get(metric).filter(|value| value.is_finite())?;
        Some((metric.column(&study.machine), json!(value)))
    });
    Value::Object(given.collect::<Map<_, _>>())
}

fn entry_json(study: &PlacementStudy, entry: &Entry) -> Value {
    let mut object = json!({ "name": entry.name, "found": entry.found.label(), "place": site_json(&entry.site) });
    if let Ok(evaluation) = &entry.outcome {
        object["objective"] = json!(entry.value);
        object["metrics"] = metrics_json(study, &evaluation.metrics);
        let feature = |(job, metrics): (&crate::questions::placement::FeatureJob, &Metrics)| json!({ "name": job.feature.name, "metrics": metrics_json(study, metrics) });
        object["features"] = study.features.iter().zip(&evaluation.features).map(feature).collect();
    }
    if let Some(failure) = entry.refusal() {
        object["infeasible"] = json!({ "status": failure.status, "reason": failure.reason });
    }
    object
}

/// Best place, how it was found, how flat it is, and all entries.
pub fn summary_json(results: &PlacementResults) -> Value {
    let study = &results.study;
    let [complete, given_up, infeasible] = counts(results);
    let best = results.best.as_ref().map(|best| {
        json!({
            "place": site_json(&best.site),
            "objective": best.value,
            "name": results.entries[best.entry].name,
            "found_by_refinement": if let Found::Refinement(index) = best.found { Some(index + 1) } else { None },
            "agreement": best.agreement.iter().map(|a| agreement_word(*a)).collect::<Vec<_>>(),
        })
    });
    let room = |room: &crate::questions::placement::Room| {
        let i = room.coordinate;
        let distance = if is_angle(i) { room.distance.to_degrees() } else { room.distance };
        let end = match &room.end {
            End::Worse => "objective 5 % worse".to_string(),
            End::Bound => "bound".into(),
            End::Nowhere => "half a turn".into(),
            End::Infeasible(reason) => reason.clone(),
        };
        let sign = if room.direction > 0.0 { "+" } else { "-" };
        json!({ "direction": format!("{sign}{}", COORDINATES[i]), "distance": distance, "unit": UNITS[i], "end": end })
    };
    json!({
        "schema": 2,
        "objective": study.objective.words(&study.machine),
        "sweep": {
            "places": results.cells.len(),
            "evaluated": complete,
            "given_up": given_up,
            "infeasible": infeasible,
            "places_between": results.gaps.sites.len(),
            "too_coarse_along": results.gaps.coarse.iter().map(|&i| COORDINATES[i]).collect::<Vec<_>>(),
        },
        "best": best,
        "flatness": results.flatness.iter().map(room).collect::<Vec<_>>(),
        "entries": results.entries.iter().map(|entry| entry_json(study, entry)).collect::<Vec<_>>(),
        "pareto_front": results.front.len(),
    })
}
