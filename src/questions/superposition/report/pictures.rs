//! Figures of a superposition study.

use super::{
    Summary, cause_text, contributions, position_text,
    quantities::{LARGEST_LOAD, RELATIVE, SUPERPOSITION_ERROR},
};
use crate::{
    answer::{GridMap, MapLayer, Tolerance},
    figures::{Figure, Limit, LineFigure, LineSeries, Shading},
    questions::superposition::{
        GridPoint, LocationResult, Scaling, SuperpositionStudy,
        ablation::Cause,
        superposition_error::{Followed, Sum, Worst},
    },
};

/// Returns the empty map of `study`, to which points are added.
pub(super) fn pictures<'a>(study: &'a SuperpositionStudy, slices_z: &[f64]) -> GridMap<'a, GridPoint> {
    GridMap::new(&study.load_case, &study.grid, slices_z, map_layers(study))
}

/// Returns the quantities of the map that are drawn.
fn map_layers(study: &SuperpositionStudy) -> Vec<MapLayer<GridPoint>> {
    let of = |stem, title: &str, label: &str, value: fn(&GridPoint) -> Option<f64>| MapLayer {
        stem,
        title: title.into(),
        label: label.into(),
        setting: study.load_case.worst_text(),
        limit: None,
        of_limit: String::new(),
        shading: Shading::Ordered,
        value: Box::new(value),
    };
    let tolerance = |own| MapLayer {
        limit: Some(Limit::Most(study.tolerance)),
        of_limit: Tolerance(study.tolerance).hatched(),
        ..own
    };
    let load =
        of("safe_load", "Largest load for which adding is safe", "largest load / load of the study [1]", |point| {
            LARGEST_LOAD.value(&point.largest_load)
        });
    let title = "Superposition error with aggregated chain errors, eqs. (14), (15)";
    let share = "superposition error / displacement, both at their largest [%]";
    vec![
        tolerance(of(
            "superposition_tool",
            "Superposition error at the tool tip T",
            "superposition error of the tool tip [mm]",
            |point| SUPERPOSITION_ERROR.value(worst(point, Sum::Superposition, Followed::Tool)?),
        )),
        of(
            "superposition_platform",
            "Superposition error at the platform point P",
            "superposition error of P [mm]",
            |point| SUPERPOSITION_ERROR.value(worst(point, Sum::Superposition, Followed::Platform)?),
        ),
        of("ratio_tool", "Superposition error as a share of the displacement", share, |point| {
            Some(100.0 * RELATIVE.value(worst(point, Sum::Superposition, Followed::Tool)?)?)
        }),
        tolerance(of("aggregation_tool", title, "superposition error of the tool tip [mm]", |point| {
            SUPERPOSITION_ERROR.value(worst(point, Sum::Aggregation, Followed::Tool)?)
        })),
        MapLayer {
            limit: Some(Limit::Least(1.0)),
            of_limit: format!(
                "; hatched: less than the load of the study; superposition error of the tool tip up to {} mm",
                study.tolerance
            ),
            ..load
        },
    ]
}

/// Returns the superposition error of `sum` at `followed` of a grid point, worst over φ; `None` where it was not solved.
fn worst(point: &GridPoint, sum: Sum, followed: Followed) -> Option<&Worst> {
    point.superposition_errors.as_ref().ok()?.worst(sum, followed).ok()
}

/// Draws all figures, with their file stems: slices of the map, and growth and causes at each location.
pub(super) fn figures(
    map: &GridMap<'_, GridPoint>,
    summary: &Summary<'_>,
    locations: &[LocationResult],
) -> Vec<(String, Figure)> {
    let study = summary.study;
    let largest = summary.largest(Sum::Superposition, Followed::Tool, &SUPERPOSITION_ERROR);
    let ends: Vec<_> = largest.map(|extreme| (extreme.value, extreme.position_mm, "largest")).into_iter().collect();
    let answer = map.slices_at(0, "Where the superposition error is largest", &ends, Some(Tolerance(study.tolerance)));
    let mut figures = vec![("answer".to_string(), answer)];
    figures.extend(map.slices());
    for (index, location) in locations.iter().enumerate() {
        let name = &location.location.name;
        let stem_of_name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let stem = |kind: &str| format!("{kind}_{}_{stem_of_name}", index + 1);
        let drawn = [("growth", growth_figure(study, location)), ("ablation", ablation_figure(study, location))];
        figures.extend(drawn.into_iter().filter_map(|(kind, figure)| Some((stem(kind), Figure::Lines(figure?)))));
    }
    figures
}

/// Draws the superposition error of the tool tip over the factor on the sources; `None` where there are too few.
fn growth_figure(study: &SuperpositionStudy, location: &LocationResult) -> Option<LineFigure> {
    let mut series = Vec::new();
    // Load and errors alone often give the same curve, and so do aggregated errors: dashes over the solid line, and dots over
    // these, leave all of them to be seen.
    for (sum, order) in [
        (Sum::Superposition, [Scaling::Load, Scaling::Errors, Scaling::Both]),
        (Sum::Aggregation, [Scaling::Errors, Scaling::Load, Scaling::Both]),
    ] {
        for scaled in order {
            let growth = &location.growth[scaled as usize];
            let points = growth.above_rounding(sum, Followed::Tool);
            if let Some(fit) = growth.fit(sum, Followed::Tool) {
                let what = match scaled {
                    Scaling::Load => "load",
                    Scaling::Errors => "chain errors",
                    Scaling::Both => "both",
                };
                let kind = if sum == Sum::Aggregation { "linearly aggregated, " } else { "" };
                let slope = match fit.is_power_law() {
                    true => format!("slope {:.2}", fit.slope),
                    false => "not a power law".into(),
                };
                let label = format!("{kind}{what} scaled: {slope}");
                let dashed = sum == Sum::Aggregation || scaled == Scaling::Errors;
                series.push(LineSeries::new(label, points, dashed));
            }
        }
    }
    (!series.is_empty()).then(|| {
        let title = format!("How the superposition error grows at {}", location.location.name);
        let (case, at) = (&study.load_case, position_text(location));
        let (machine, of) = (&case.machine.name, case.worst_text());
        let subtitle = format!("{machine}, {at}, {of}; factor 1: load and errors of the study");
        let labels = ["factor on the scaled sources [1]", "superposition error of the tool tip [mm]"];
        LineFigure { log_x: true, log_y: true, ..LineFigure::new(title, subtitle, labels, series) }
    })
}

/// Repeats the value at φ = 0° at 360°, to close a curve over a turn.
fn closed_over_turn(values: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut values: Vec<(f64, f64)> = values.collect();
    values.extend(values.first().filter(|(phi, _)| *phi == 0.0).map(|(_, value)| (360.0, *value)));
    values
}

/// Draws the contributions to the superposition error of the tool tip over φ; `None` where there are none.
fn ablation_figure(study: &SuperpositionStudy, location: &LocationResult) -> Option<LineFigure> {
    let angles = location.ablation.as_ref().ok()?;
    let ablations: Vec<(f64, f64, [f64; 5])> = angles
        .iter()
        .filter_map(|a| Some((a.phi_deg, a.superposition_error.tool.norm(), contributions(a, Followed::Tool)?)))
        .collect();
    if ablations.is_empty() {
        return None;
    }
    let errors = ablations.iter().map(|(phi, length, _)| (*phi, *length));
    let mut series = vec![LineSeries::new("superposition error", closed_over_turn(errors), false)];
    for (index, cause) in Cause::ALL.into_iter().enumerate() {
        let points = closed_over_turn(ablations.iter().map(|(phi, _, parts)| (*phi, parts[index])));
        series.push(LineSeries::new(cause_text(cause), points, index > 1));
    }
    let title = format!("Causes of the superposition error at {}", location.location.name);
    let subtitle = format!(
        "{}, {}, {}; parts along the superposition error of the tool tip, which at each angle add up to it",
        study.load_case.machine.name,
        position_text(location),
        study.load_case.force_text()
    );
    let labels = ["tool angle φ [°]", "part of the superposition error [mm]"];
    Some(LineFigure::new(title, subtitle, labels, series))
}
