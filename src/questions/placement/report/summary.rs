//! What a placement study says, for programs.

use serde_json::{Map, Value, json};

use super::quantities::agreement_word;
use crate::questions::placement::{
    COORDINATES, End, Entry, FeatureJob, Found, Metric, Metrics, PlacementResults, PlacementStudy, Room, Site, UNITS,
    Verdict, site::in_unit,
};

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
        let feature = |(job, metrics): (&FeatureJob, &Metrics)| json!({ "name": job.feature.name, "metrics": metrics_json(study, metrics) });
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
    let room = |room: &Room| {
        let i = room.coordinate;
        let end = match &room.end {
            End::Worse => "objective 5 % worse".to_string(),
            End::Bound => "bound".into(),
            End::Nowhere => "half a turn".into(),
            End::Infeasible(reason) => reason.clone(),
        };
        let sign = if room.direction > 0.0 { "+" } else { "-" };
        json!({ "direction": format!("{sign}{}", COORDINATES[i]), "distance": in_unit(i, room.distance), "unit": UNITS[i], "end": end })
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
