//! Which pictures a superposition study gives.

use super::{contributions, words};
use crate::{
    process::MillingForce,
    report::{
        figures::{Figure, LineFigure, LineSeries, SliceFigure},
        grid_slices::panels,
        words::{counted, typographic},
    },
    study::superposition::{
        LocationResult, MapPoint, Scaled, Superposition, SuperpositionStudy,
        ablation::Cause,
        departure::{Departures, Followed, Sum},
    },
};

/// All pictures with their file stems: slices of departures and of the largest safe load, and of each location how the
/// departure grows and where it comes from.
pub fn figures(results: &Superposition) -> Vec<(String, Figure)> {
    let mut figures: Vec<(String, Figure)> = maps(results).into_iter().map(|(s, f)| (s, Figure::Slices(f))).collect();
    for (index, location) in results.locations.iter().enumerate() {
        let name = &location.location.name;
        let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let stem = |kind: &str| format!("{kind}_{}_{plain}", index + 1);
        let drawn = [("growth", growth(results, location)), ("ablation", ablation(results, location))];
        figures.extend(drawn.into_iter().filter_map(|(kind, figure)| Some((stem(kind), Figure::Lines(figure?)))));
    }
    figures
}

fn force(study: &SuperpositionStudy) -> String {
    let MillingForce { radial, tangential, axial, .. } = study.force;
    typographic(&format!("force {radial} / {tangential} / {axial} N (radial / tangential / axial)"))
}

fn setting(study: &SuperpositionStudy) -> String {
    let [nx, ny, nz] = study.grid.counts();
    format!(
        "{}, worst of {}, {}, grid {nx} × {ny} × {nz}",
        study.machine.name,
        counted(study.phis.len(), "tool angle"),
        force(study)
    )
}

fn maps(results: &Superposition) -> Vec<(String, SliceFigure)> {
    let study = &results.study;
    let slices =
        |stem: &str, title: &str, remark: String, quantity: &str, contour, value: &dyn Fn(&MapPoint) -> Option<f64>| {
            let values: Vec<Option<f64>> = results.points.iter().map(value).collect();
            let figure = SliceFigure {
                title: title.into(),
                subtitle: format!("{}{remark}", setting(study)),
                x_label: "x [mm]".into(),
                y_label: "y [mm]".into(),
                quantity: quantity.into(),
                panels: panels(&study.machine, &study.grid, &study.slices_z, &|node| values[study.grid.index(node)]),
                range: None,
                contour,
            };
            (format!("slices_{stem}"), figure)
        };
    let tolerance = format!("; line: tolerance {} mm", study.tolerance);
    vec![
        slices(
            "departure_tool",
            "How wrong it is to add the effects of cutting force and chain errors",
            tolerance.clone(),
            "departure of the tool tip [mm]",
            Some(study.tolerance),
            &|p| worst(&p.departures, |d| Some(d.superposition[0].departure_mm)),
        ),
        slices(
            "departure_platform",
            "How wrong adding is at the platform point P",
            String::new(),
            "departure of P [mm]",
            None,
            &|p| worst(&p.departures, |d| Some(d.superposition[1].departure_mm)),
        ),
        slices(
            "ratio_tool",
            "How wrong adding is, compared with the displacement itself",
            String::new(),
            "largest departure / largest displacement of the tool tip [%]",
            None,
            &|p| worst(&p.departures, |d| d.superposition[0].relative().map(|ratio| 100.0 * ratio)),
        ),
        slices(
            "aggregation_tool",
            "How wrong it is to add linearly aggregated chain errors, eqs. (14), (15)",
            tolerance,
            "departure of the tool tip [mm]",
            Some(study.tolerance),
            &|p| worst(&p.departures, |d| Some(d.aggregation.as_ref().ok()?[0].departure_mm)),
        ),
        slices(
            "safe_load",
            "Up to which load the effects may be added",
            format!("; line: the load of the study; departure of the tool tip up to {} mm", study.tolerance),
            "largest load / load of the study",
            Some(1.0),
            &|p| p.largest_load.factor(),
        ),
    ]
}

fn worst<E>(found: &Result<Departures, E>, value: impl Fn(&Departures) -> Option<f64>) -> Option<f64> {
    found.as_ref().ok().and_then(value)
}

/// Departures of the tool tip over the factor on the sources; `None` where there are none.
fn growth(results: &Superposition, location: &LocationResult) -> Option<LineFigure> {
    let mut series = Vec::new();
    // Load and errors alone often give the same curve, and so do aggregated errors: dashes over the solid line, and dots over
    // these, leave all of them to be seen.
    for (sum, order) in [
        (Sum::Superposition, [Scaled::Load, Scaled::Errors, Scaled::Both]),
        (Sum::Aggregation, [Scaled::Errors, Scaled::Load, Scaled::Both]),
    ] {
        for scaled in order {
            let growth = &location.growth[scaled as usize];
            let points = growth.measured(sum, Followed::Tool);
            if let Some(fit) = growth.fit(sum, Followed::Tool) {
                let what = match scaled {
                    Scaled::Load => "load",
                    Scaled::Errors => "chain errors",
                    Scaled::Both => "both",
                };
                let kind = if sum == Sum::Aggregation { "linearly aggregated, " } else { "" };
                let slope = match fit.is_power_law() {
                    true => format!("slope {:.2}", fit.slope),
                    false => "not a power law".into(),
                };
                let label = format!("{kind}{what} scaled: {slope}");
                let dashed = sum == Sum::Aggregation || scaled == Scaled::Errors;
                series.push(LineSeries { label, points, dashed });
            }
        }
    }
    (!series.is_empty()).then(|| LineFigure {
        title: format!("How the error of adding grows at {}", location.location.name),
        subtitle: format!(
            "{}, worst of {}, {}; factor 1: load and errors of the study",
            results.study.machine.name,
            counted(results.study.phis.len(), "tool angle"),
            force(&results.study)
        ),
        x_label: "factor on the scaled sources".into(),
        y_label: "departure of the tool tip [mm]".into(),
        series,
        equal_axes: false,
        log_x: true,
        log_y: true,
        closed_note: None,
    })
}

/// Values over φ, in degrees, up to the full turn, where that of 0° comes again.
fn closed(values: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut values: Vec<(f64, f64)> = values.collect();
    values.extend(values.first().filter(|(phi, _)| *phi == 0.0).map(|(_, value)| (360.0, *value)));
    values
}

/// Contributions to the departure of the tool tip over φ; `None` where there is none.
fn ablation(results: &Superposition, location: &LocationResult) -> Option<LineFigure> {
    let angles = location.ablation.as_ref().ok()?;
    let found: Vec<(f64, f64, [f64; 5])> = angles
        .iter()
        .filter_map(|a| Some((a.phi_deg, a.departure.tool.norm(), contributions(a, Followed::Tool)?)))
        .collect();
    if found.is_empty() {
        return None;
    }
    let all = found.iter().map(|(phi, length, _)| (*phi, *length));
    let mut series = vec![LineSeries { label: "departure".into(), points: closed(all), dashed: false }];
    for (index, cause) in Cause::ALL.into_iter().enumerate() {
        let points = closed(found.iter().map(|(phi, _, parts)| (*phi, parts[index])));
        series.push(LineSeries { label: words(cause).into(), points, dashed: index > 1 });
    }
    Some(LineFigure {
        title: format!("What makes adding wrong at {}", location.location.name),
        subtitle: format!(
            "{}, {}; parts along the departure of the tool tip, adding up to it",
            results.study.machine.name,
            force(&results.study)
        ),
        x_label: "tool angle φ [°]".into(),
        y_label: "part of the departure [mm]".into(),
        series,
        equal_axes: false,
        log_x: false,
        log_y: false,
        closed_note: None,
    })
}
