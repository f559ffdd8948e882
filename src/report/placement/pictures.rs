//! Which pictures a placement study gives.

use nalgebra::Vector3;

use crate::{
    report::{
        amplification::amplification,
        figures::{Figure, LineFigure, LineSeries, Mark2, SliceFigure, SlicePanel},
    },
    study::placement::{Metric, Metrics, PlacementResults, Site, Trace},
};

/// Most panels of a map.
const PANELS: usize = 6;

/// All pictures with their file stems: maps of the objective and its metrics, the Pareto front, and the path at the best
/// and at a poor place.
pub fn figures(results: &PlacementResults) -> Vec<(String, Figure)> {
    let study = &results.study;
    let mut figures: Vec<(String, Figure)> = Vec::new();
    let counts = study.grid.counts();
    if counts[0] > 1 && counts[1] > 1 && !results.ranking.is_empty() {
        if study.objective.weights.len() > 1 {
            let value = |metrics: &Metrics| Some(study.objective.value(metrics)).filter(|value| value.is_finite());
            let drawn = map(results, "objective (weighted sum)", &value);
            figures.push(("map_objective".into(), Figure::Slices(drawn)));
        }
        for metric in Metric::ALL.into_iter().filter(|metric| study.objective.metrics().contains(metric)) {
            let drawn = map(results, &with_unit(results, metric), &|metrics| metrics.get(metric));
            figures.push((format!("map_{}", metric.label()), Figure::Slices(drawn)));
        }
    }
    if results.front.len() > 1 {
        figures.push(("pareto".into(), Figure::Lines(pareto(results))));
    }
    if !results.traces.is_empty() {
        figures.push(("path_errors".into(), Figure::Lines(errors(results))));
    }
    // A line through the points of a path would also show where the tool is lifted.
    for trace in results.traces.iter().filter(|trace| trace.cutting.iter().skip(1).all(|cutting| *cutting)) {
        figures.push((format!("path_{}", stem(&trace.place)), Figure::Lines(path(results, trace))));
    }
    figures
}

fn stem(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

fn with_unit(results: &PlacementResults, metric: Metric) -> String {
    match metric.unit(&results.study.machine) {
        "" => metric.words().into(),
        unit => format!("{} [{}]", metric.words(), unit.replace("_per_", "/").replace('_', " ")),
    }
}

/// Grid positions along one coordinate, at most [`PANELS`], evenly spread, both ends included.
fn spread(count: usize) -> Vec<usize> {
    if count <= PANELS {
        return (0..count).collect();
    }
    (0..PANELS).map(|k| (k * (count - 1) + (PANELS - 1) / 2) / (PANELS - 1)).collect()
}

/// The planes drawn, as positions along z and yaw: all heights at the best place's yaw, or all yaws at the only height.
fn planes(results: &PlacementResults) -> Vec<[usize; 2]> {
    let axes = &results.study.grid.axes;
    let best = results.ranking.first().map_or(Site([0.0; 4]), |&index| results.cells[index].site);
    let nearest = |i: usize| axes[i].iter().position(|value| *value == best.0[i]).unwrap_or(0);
    if axes[2].len() > 1 {
        spread(axes[2].len()).into_iter().map(|z| [z, nearest(3)]).collect()
    } else {
        spread(axes[3].len()).into_iter().map(|yaw| [0, yaw]).collect()
    }
}

fn map(results: &PlacementResults, quantity: &str, value: &dyn Fn(&Metrics) -> Option<f64>) -> SliceFigure {
    let study = &results.study;
    let [xs, ys, zs, yaws] = &study.grid.axes;
    let panel = |&[z, yaw]: &[usize; 2]| {
        let node = |x, y| value(results.cells[study.grid.index([x, y, z, yaw])].metrics()?);
        let height = format!("z = {:.1} mm", zs[z]);
        let turned = format!("yaw {:.0}°", yaws[yaw].to_degrees());
        let title = match (zs.len() > 1, yaws.len() > 1) {
            (true, true) => format!("{height}, {turned}"),
            (false, true) => turned,
            (_, false) => height,
        };
        SlicePanel {
            title: title.replace('-', "\u{2212}"),
            x: xs.clone(),
            y: ys.clone(),
            values: (0..ys.len()).flat_map(|y| (0..xs.len()).map(move |x| (x, y))).map(|(x, y)| node(x, y)).collect(),
            marks: marks(results, zs, z, yaws, yaw),
        }
    };
    SliceFigure {
        title: "Where the workpiece should stand".into(),
        subtitle: format!(
            "{}, origin of the workpiece; hatched: it cannot be cut there; places given up show a bound",
            study.machine.name
        ),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: quantity.into(),
        panels: planes(results).iter().map(panel).collect(),
        range: None,
        contour: None,
    }
}

/// Places farther from the bounds than this share of their range are not shown on a map.
const NEAR: f64 = 0.25;

/// Named places and the best one, on the plane nearest to them.
fn marks(results: &PlacementResults, zs: &[f64], z: usize, yaws: &[f64], yaw: usize) -> Vec<Mark2> {
    let drawn = planes(results);
    let nearest = |values: &[f64], value: f64, allowed: &dyn Fn(usize) -> bool| {
        (0..values.len())
            .filter(|&k| allowed(k))
            .min_by(|&a, &b| (values[a] - value).abs().total_cmp(&(values[b] - value).abs()))
    };
    let is_here = |site: &Site| {
        let at_z = nearest(zs, site.0[2], &|k| drawn.iter().any(|plane| plane[0] == k));
        let at_yaw = nearest(yaws, site.0[3], &|k| drawn.iter().any(|plane| plane[1] == k));
        at_z == Some(z) && at_yaw == Some(yaw)
    };
    let is_near = |site: &Site| {
        let bounds = &results.study.bounds;
        (0..2).all(|i| {
            let margin = NEAR * bounds.range(i);
            (bounds.low[i] - margin..=bounds.high[i] + margin).contains(&site.0[i])
        })
    };
    let named = results.study.candidates.iter().map(|candidate| (candidate.name.clone(), candidate.site));
    let best = results.best.iter().map(|best| ("best".to_string(), best.site));
    named
        .chain(best)
        .filter(|(_, site)| is_here(site) && is_near(site))
        .map(|(label, site)| Mark2 { label, x: site.0[0], y: site.0[1] })
        .collect()
}

/// The front in its first two metrics; the third, if any, divides it into thirds of its range.
fn pareto(results: &PlacementResults) -> LineFigure {
    let study = &results.study;
    let metrics = &study.objective.pareto;
    let value = |values: &Metrics, k: usize| values.get(metrics[k]).unwrap_or(0.0);
    let point = |values: &Metrics| (value(values, 0), value(values, 1));
    let all: Vec<&Metrics> = results.front.iter().map(|(_, values)| values).collect();
    let mut series = Vec::new();
    match metrics.get(2) {
        None => series.push(("best compromises".to_string(), all.iter().map(|v| point(v)).collect::<Vec<_>>())),
        Some(third) => {
            let (low, high) =
                all.iter().map(|v| value(v, 2)).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
            let part =
                |v: &Metrics| (((value(v, 2) - low) / (high - low).max(f64::MIN_POSITIVE)) * 3.0).min(2.0) as usize;
            for k in 0..3 {
                let edge = |k: usize| low + (high - low) * k as f64 / 3.0;
                let label = format!("{}: {:.3} to {:.3}", third.words(), edge(k), edge(k + 1));
                series.push((label, all.iter().filter(|v| part(v) == k).map(|v| point(v)).collect()));
            }
        }
    }
    let named = results.entries.iter().filter(|entry| !super::tables::is_found(entry)).filter_map(|entry| {
        let values = &entry.outcome.as_ref().ok()?.metrics;
        Some((entry.name.clone(), vec![point(values)]))
    });
    series.extend(named);
    LineFigure {
        title: "What one objective costs in the other".into(),
        subtitle: format!("{}, places no other place beats in every respect, and named ones", study.machine.name),
        x_label: with_unit(results, metrics[0]),
        y_label: with_unit(results, metrics[1]),
        series: series.into_iter().map(|(label, points)| LineSeries { label, points, dashed: false }).collect(),
        equal_axes: false,
        log_x: false,
        log_y: false,
        closed_note: None,
    }
}

/// How far the tool is from its path, before and after, at the best and at a poor place.
fn errors(results: &PlacementResults) -> LineFigure {
    let study = &results.study;
    let curve = |trace: &Trace, label: &str, dashed: bool, errors: &[Option<Vector3<f64>>]| {
        let points = errors.iter().enumerate().filter(|(k, _)| trace.cutting[*k]);
        LineSeries {
            label: format!("{}, {label}", trace.place),
            points: points.filter_map(|(k, error)| Some((trace.arc_length_mm[k], (*error)?.norm()))).collect(),
            dashed,
        }
    };
    let both = |trace: &Trace| {
        [
            curve(trace, "without compensation", false, &trace.before),
            curve(trace, "after compensation", true, &trace.after),
        ]
    };
    LineFigure {
        title: "How far the tool is from its path".into(),
        subtitle: format!("{}, {}, where the tool cuts", study.machine.name, study.features[0].feature.name),
        x_label: "path length [mm]".into(),
        y_label: "distance [mm]".into(),
        series: results.traces.iter().flat_map(both).collect(),
        equal_axes: false,
        log_x: false,
        log_y: false,
        closed_note: None,
    }
}

/// The wanted path in the xy-plane, and where the tool goes before and after the correction.
fn path(results: &PlacementResults, trace: &Trace) -> LineFigure {
    let study = &results.study;
    let amplification = amplification(&trace.wanted, shared_error(results));
    let drawn = |label: &str, dashed: bool, error: &dyn Fn(usize) -> Option<Vector3<f64>>| {
        let points = trace.wanted.iter().enumerate().filter(|(k, _)| trace.cutting[*k]).filter_map(|(k, p)| {
            let at = p + error(k)? * amplification;
            Some((at.x, at.y))
        });
        LineSeries { label: label.into(), points: points.collect(), dashed }
    };
    LineFigure {
        title: format!("{} cut at {}", study.features[trace.feature].feature.name, trace.place),
        subtitle: format!("{}, where the tool cuts, seen along −z", study.machine.name),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        series: vec![
            drawn("wanted", false, &|_| Some(Vector3::zeros())),
            drawn("without compensation", false, &|k| trace.before[k]),
            drawn("after compensation", true, &|k| trace.after[k]),
        ],
        equal_axes: true,
        log_x: false,
        log_y: false,
        closed_note: Some(format!("deviations from the wanted path drawn {amplification} times as large")),
    }
}

/// The largest error of all traces, so that they are drawn alike.
fn shared_error(results: &PlacementResults) -> f64 {
    let errors = results.traces.iter().flat_map(|trace| &trace.before).flatten();
    errors.fold(0.0, |most, error| most.max(error.norm()))
}
