//! The best compromises, thinned to those that differ.

use crate::{
    page::SmallTable,
    questions::placement::{COORDINATES, Metrics, PlacementResults, Site, is_angle},
};

/// A compromise is shown if one of its numbers differs by this share of its size from that of the one shown before.
const DIFFERENT: f64 = 0.02;

/// The compromises that differ, with the coordinates that do; `None` where there are not two.
pub(super) fn compromises(results: &PlacementResults) -> Option<SmallTable> {
    let study = &results.study;
    let metrics = &study.objective.pareto;
    let differs = |a: &Metrics, b: &Metrics| {
        metrics.iter().any(|metric| match (a.get(*metric), b.get(*metric)) {
            (Some(a), Some(b)) => (a - b).abs() > DIFFERENT * a.abs().max(b.abs()),
            _ => true,
        })
    };
    let mut shown: Vec<&(Site, Metrics)> = Vec::new();
    for place in &results.front {
        if shown.last().is_none_or(|last| differs(&last.1, &place.1)) {
            shown.push(place);
        }
    }
    if shown.len() < 2 {
        return None;
    }
    let text = |site: &Site, i: usize| {
        let value = site.shown()[i];
        crate::files::words::typographic(&if is_angle(i) { format!("{value:.0}°") } else { format!("{value:.1} mm") })
    };
    let varies = |i: &usize| shown.iter().any(|(site, _)| text(site, *i) != text(&shown[0].0, *i));
    let free: Vec<usize> = (0..COORDINATES.len()).filter(varies).collect();
    let header = free.iter().map(|&i| COORDINATES[i].to_string());
    let header = header.chain(metrics.iter().map(|metric| metric.words(&study.machine).to_string())).collect();
    let row = |(site, values): &&(Site, Metrics)| {
        let places = free.iter().map(|&i| text(site, i));
        let numbers = metrics.iter().map(|metric| {
            values.get(*metric).map_or_else(|| "–".to_string(), |value| metric.shown(&study.machine, value))
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
