//! Figures of a placement study: maps of the sweep, the Pareto front, and the paths at the best and at a poor place.

use nalgebra::Vector3;

use crate::{
    answer::thinned_indices,
    figures::{
        CurvePanel, Figure, LineFigure, LineSeries, PanelCurve, PanelFigure, PlaneMark, Shading, SliceFigure,
        SlicePanel, amplification::amplification,
    },
    files::{file_stem, words::typographic},
    questions::placement::{COORDINATES, Metric, Metrics, Origin, PlacementResults, Site, Trace, report::recommended},
};

/// Largest number of panels of a map.
const PANELS: usize = 6;

/// Words for a place without a value.
pub(super) const IMPOSSIBLE: &str = "cannot be cut there";

/// Returns all figures with their file stems: recommended place, maps of the sweep, Pareto front, and paths.
pub fn figures(results: &PlacementResults) -> Vec<(String, Figure)> {
    let study = &results.study;
    let answer = recommended::plan_figure(results).map(|figure| ("answer".to_string(), figure));
    let in_space = recommended::pose_figure(results).map(|figure| ("answer_3d".to_string(), figure));
    let nearest = recommended::clearance_figure(results);
    let mut figures: Vec<(String, Figure)> = answer.into_iter().chain(in_space).chain(nearest).collect();
    let counts = study.grid.counts();
    if counts[0] > 1 && counts[1] > 1 && !results.ranking.is_empty() {
        if study.objective.weights.len() > 1 {
            let value = |metrics: &Metrics| Some(study.objective.value(metrics)).filter(|value| value.is_finite());
            let drawn = map(results, "objective (weighted sum)", "objective", &value);
            figures.push(("map_objective".into(), Figure::Slices(drawn)));
        }
        for metric in Metric::ALL.into_iter().filter(|metric| study.objective.metrics().contains(metric)) {
            let drawn =
                map(results, &with_unit(results, metric), metric.text(&study.machine), &|metrics| metrics.get(metric));
            figures.push((format!("map_{}", metric.label()), Figure::Slices(drawn)));
        }
    }
    if results.front.len() > 1 {
        figures.push(("pareto".into(), Figure::Lines(pareto_figure(results))));
    }
    for (index, job) in study.features.iter().enumerate() {
        if traces_of(results, index).next().is_some() {
            let name = file_stem(&job.feature.name);
            figures.push((format!("path_errors_{name}"), Figure::Panels(path_errors_figure(results, index))));
            figures.push((format!("paths_{name}"), Figure::Panels(paths_figure(results, index))));
        }
    }
    figures
}

/// Returns the name of a metric with its unit in brackets.
pub(super) fn with_unit(results: &PlacementResults, metric: Metric) -> String {
    match metric.shown_unit(&results.study.machine) {
        "" => metric.text(&results.study.machine).into(),
        unit => format!("{} [{unit}]", metric.text(&results.study.machine)),
    }
}

/// Returns at most [`PANELS`] positions along a coordinate of the grid, evenly spread, both ends and `included` included.
fn panel_positions(count: usize, included: usize) -> Vec<usize> {
    let mut positions = thinned_indices(count, PANELS);
    if let [_, between @ .., _] = &mut positions[..]
        && let Some(nearest) = between.iter_mut().min_by_key(|k| k.abs_diff(included))
        && (1..count - 1).contains(&included)
    {
        *nearest = included;
    }
    positions
}

/// Returns the grid positions nearest to the best place; the first ones where there is none.
pub(super) fn best_grid_position(results: &PlacementResults) -> [usize; 6] {
    let (axes, bounds) = (&results.study.grid.axes, &results.study.bounds);
    let swept = results.ranking.first().map(|&index| results.cells[index].site);
    let Some(best) = results.best.as_ref().map(|best| best.site).or(swept) else { return [0; 6] };
    std::array::from_fn(|i| {
        let gap = |k: &usize| bounds.distance(i, axes[i][*k], best.0[i]);
        (0..axes[i].len()).min_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or(0)
    })
}

/// Returns the metrics that are drawn in a cell of the sweep: of that around the best place the metrics there, as its grid point may be impossible;
/// `None` where the workpiece cannot be cut.
pub(super) fn metrics_at(results: &PlacementResults, position: [usize; 6]) -> Option<&Metrics> {
    let best = results.best.as_ref().filter(|_| position == best_grid_position(results));
    match best.and_then(|best| results.entries[best.entry].feasible()) {
        Some(evaluation) => Some(&evaluation.metrics),
        None => results.cells[results.study.grid.index(position)].metrics(),
    }
}

/// Returns the coordinate in which the planes drawn differ: the first besides x and y that the sweep varies.
fn panel_coordinate(results: &PlacementResults) -> usize {
    (2..COORDINATES.len()).find(|&i| results.study.grid.axes[i].len() > 1).unwrap_or(2)
}

/// Returns the planes drawn, as grid positions: that of the best place and others along one coordinate.
fn planes(results: &PlacementResults) -> Vec<[usize; 6]> {
    let mut base = best_grid_position(results);
    (base[0], base[1]) = (0, 0);
    let across = panel_coordinate(results);
    let plane = |k| {
        let mut plane = base;
        plane[across] = k;
        plane
    };
    panel_positions(results.study.grid.axes[across].len(), base[across]).into_iter().map(plane).collect()
}

/// Describes a plane: its height, and the angles that the sweep varies.
fn plane_title(results: &PlacementResults, plane: &[usize; 6]) -> String {
    let axes = &results.study.grid.axes;
    let angles = || (3..COORDINATES.len()).filter(|&i| axes[i].len() > 1);
    let mut parts: Vec<String> =
        angles().map(|i| format!("{} {:.0}°", COORDINATES[i], axes[i][plane[i]].to_degrees())).collect();
    if axes[2].len() > 1 || parts.is_empty() {
        parts.insert(0, format!("z = {:.1} mm", axes[2][plane[2]]));
    }
    typographic(&parts.join(", "))
}

/// Draws the map over the places of the sweep of what `value` reads from metrics (`None`: as impossible); `words` name it, `quantity` labels the colours.
fn map(
    results: &PlacementResults,
    quantity: &str,
    words: &str,
    value: &dyn Fn(&Metrics) -> Option<f64>,
) -> SliceFigure {
    let study = &results.study;
    let [xs, ys, ..] = &study.grid.axes;
    let panel = |plane: &[usize; 6]| {
        let node = |x, y| {
            let [_, _, rest @ ..] = *plane;
            let [z, yaw, pitch, roll] = rest;
            value(metrics_at(results, [x, y, z, yaw, pitch, roll])?)
        };
        SlicePanel {
            title: plane_title(results, plane),
            x: xs.clone(),
            y: ys.clone(),
            values: (0..ys.len()).flat_map(|y| (0..xs.len()).map(move |x| (x, y))).map(|(x, y)| node(x, y)).collect(),
            marks: place_marks(results, plane),
        }
    };
    SliceFigure {
        title: format!("Where the part may stand: {words}"),
        subtitle: format!("{}, by the part's origin; places stopped early show a bound", study.machine.name),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: quantity.into(),
        panels: planes(results).iter().map(panel).collect(),
        range: None,
        limit: None,
        shading: Shading::Ordered,
        remark: String::new(),
        missing: IMPOSSIBLE.into(),
    }
}

/// Largest distance from the bounds, as a share of their range, at which places are drawn.
const NEAR: f64 = 0.25;

/// Returns whether a place lies within the bounds in x and y, or close to them.
pub(super) fn is_near(results: &PlacementResults, site: &Site) -> bool {
    let bounds = &results.study.bounds;
    (0..2).all(|i| {
        let margin = NEAR * bounds.range(i);
        (bounds.low[i] - margin..=bounds.high[i] + margin).contains(&site.0[i])
    })
}

/// Returns the named places and the best one if `plane` is the nearest to them.
fn place_marks(results: &PlacementResults, plane: &[usize; 6]) -> Vec<PlaneMark> {
    let across = panel_coordinate(results);
    let values = &results.study.grid.axes[across];
    let is_here = |site: &Site| {
        let gap = |plane: &[usize; 6]| results.study.bounds.distance(across, values[plane[across]], site.0[across]);
        planes(results).into_iter().min_by(|a, b| gap(a).total_cmp(&gap(b))) == Some(*plane)
    };
    let named = results.study.candidates.iter().map(|candidate| (candidate.name.clone(), candidate.site));
    let best = results.best.iter().map(|best| ("best".to_string(), best.site));
    named
        .chain(best)
        .filter(|(_, site)| is_here(site) && is_near(results, site))
        .map(|(label, site)| PlaneMark { label, x: site.0[0], y: site.0[1] })
        .collect()
}

/// Draws the front in its first two metrics; the third, if any, divides it into thirds of its range.
fn pareto_figure(results: &PlacementResults) -> LineFigure {
    let study = &results.study;
    let metrics = &study.objective.pareto;
    let value = |values: &Metrics, k: usize| values.get(metrics[k]).unwrap_or(0.0);
    let point = |values: &Metrics| (value(values, 0), value(values, 1));
    let front: Vec<&Metrics> = results.front.iter().map(|(_, values)| values).collect();
    let mut series = Vec::new();
    match metrics.get(2) {
        None => series.push(("best compromises".to_string(), front.iter().map(|v| point(v)).collect::<Vec<_>>())),
        Some(third) => {
            let (low, high) =
                front.iter().map(|v| value(v, 2)).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
            let part =
                |v: &Metrics| (((value(v, 2) - low) / (high - low).max(f64::MIN_POSITIVE)) * 3.0).min(2.0) as usize;
            for k in 0..3 {
                let edge = |k: usize| low + (high - low) * k as f64 / 3.0;
                let label = format!("{}: {:.3} to {:.3}", third.text(&results.study.machine), edge(k), edge(k + 1));
                series.push((label, front.iter().filter(|v| part(v) == k).map(|v| point(v)).collect()));
            }
        }
    }
    let named = results.entries.iter().filter(|entry| entry.found == Origin::Named).filter_map(|entry| {
        let values = &entry.outcome.as_ref().ok()?.metrics;
        Some((entry.name.clone(), vec![point(values)]))
    });
    series.extend(named);
    LineFigure {
        title: "What one objective costs in the other".into(),
        subtitle: format!("{}, places no other place beats in every respect, and named ones", study.machine.name),
        x_label: with_unit(results, metrics[0]),
        y_label: with_unit(results, metrics[1]),
        series: series.into_iter().map(|(label, points)| LineSeries::new(label, points, false)).collect(),
        ..LineFigure::default()
    }
}

/// Returns the traces of a feature, the best place first.
fn traces_of(results: &PlacementResults, feature: usize) -> impl Iterator<Item = &Trace> {
    results.traces.iter().filter(move |trace| trace.feature == feature)
}

/// Versions of a path that are drawn.
#[derive(Debug, Clone, Copy)]
pub(super) enum PathVersion {
    /// The wanted path.
    Wanted,
    /// The path without compensation.
    Before,
    /// The path after compensation.
    After,
}

impl PathVersion {
    pub(super) const ALL: [PathVersion; 3] = [PathVersion::Wanted, PathVersion::Before, PathVersion::After];

    /// Returns the deviation from the wanted position at point `k`, O axes, mm; `None` where it is not known.
    pub(super) fn error(self, trace: &Trace, k: usize) -> Option<Vector3<f64>> {
        match self {
            PathVersion::Wanted => Some(Vector3::zeros()),
            PathVersion::Before => trace.before[k],
            PathVersion::After => trace.after[k],
        }
    }
}

/// Returns the values at the points where the tool cuts, in pieces that end where it does not cut or a value is missing (`None`).
pub(super) fn cutting_pieces<T: Copy>(trace: &Trace, value: impl Fn(usize) -> Option<T>) -> Vec<Vec<T>> {
    let mut pieces: Vec<Vec<T>> = Vec::new();
    let mut last = None;
    for (k, at) in (0..trace.cutting.len()).filter_map(|k| Some((k, value(k)?))) {
        // Without cutting on the way here, the point starts a piece if the tool cuts from it on.
        let starts = !trace.cutting[k] && trace.cutting.get(k + 1) == Some(&true);
        if starts || (trace.cutting[k] && last != Some(k.wrapping_sub(1))) {
            pieces.push(Vec::new());
        }
        if starts || trace.cutting[k] {
            pieces.last_mut().into_iter().for_each(|piece| piece.push(at));
            last = Some(k);
        }
    }
    pieces
}

/// Draws the error along the path, before and after compensation, at the best and at a poor place.
fn path_errors_figure(results: &PlacementResults, feature: usize) -> PanelFigure {
    let study = &results.study;
    let panel = |trace: &Trace| {
        let curve = |errors: &[Option<Vector3<f64>>]| PanelCurve {
            pieces: cutting_pieces(trace, |k| Some((trace.arc_length_mm[k], errors[k]?.norm()))),
        };
        CurvePanel { title: trace.place.clone(), curves: vec![curve(&trace.before), curve(&trace.after)] }
    };
    PanelFigure {
        title: format!("How far the tool is from its path: {}", study.features[feature].feature.name),
        subtitle: format!("{}, where the tool cuts, at the best and at a poor place", study.machine.name),
        x_label: "path length [mm]".into(),
        y_label: "distance [mm]".into(),
        curves: vec![("without compensation".into(), false), ("after compensation".into(), true)],
        panels: traces_of(results, feature).map(panel).collect(),
        equal_axes: false,
        note: String::new(),
    }
}

/// Draws the wanted path in the xy-plane, and the path before and after compensation, at the best and at a poor place.
fn paths_figure(results: &PlacementResults, feature: usize) -> PanelFigure {
    let study = &results.study;
    let wanted = traces_of(results, feature).next().map_or(&[][..], |trace| &trace.wanted);
    let amplification = amplification(wanted, largest_error(results));
    let panel = |trace: &Trace| {
        let at = |k: usize, error: Vector3<f64>| trace.wanted[k] + error * amplification;
        let drawn = |version: PathVersion| PanelCurve {
            pieces: cutting_pieces(trace, |k| version.error(trace, k).map(|error| at(k, error)).map(|at| (at.x, at.y))),
        };
        CurvePanel { title: trace.place.clone(), curves: PathVersion::ALL.map(drawn).into() }
    };
    PanelFigure {
        title: format!("Predicted path: {}", study.features[feature].feature.name),
        subtitle: format!(
            "{}, where the tool cuts, seen along −z, at the best and at a poor place",
            study.machine.name
        ),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        curves: vec![
            ("wanted".into(), false),
            ("without compensation".into(), false),
            ("after compensation".into(), true),
        ],
        panels: traces_of(results, feature).map(panel).collect(),
        equal_axes: true,
        note: format!("deviations from the wanted path drawn {amplification} times as large"),
    }
}

/// Returns the largest error of all traces, mm, so that all are magnified alike.
fn largest_error(results: &PlacementResults) -> f64 {
    let errors = results.traces.iter().flat_map(|trace| &trace.before).flatten();
    errors.fold(0.0, |largest, error| largest.max(error.norm()))
}
