//! The pictures a validation study asks for.

use nalgebra::Vector3;

use crate::{
    figures::{CurvePanel, Figure, LineFigure, LineSeries, PanelCurve, PanelFigure},
    files::table::{drives_of, kind_word, shown_positions},
    machine::{Machine, Motion},
    questions::{
        path::PathResults,
        validation::{FigureKind, Picture, Shown, ValidationResults, report::agreement},
    },
    simulation::Source,
};

/// All pictures with their file stems: the numbers compared, and what the study asks for.
pub fn figures(results: &ValidationResults, shown: &Shown) -> Vec<(String, Figure)> {
    let picture = |picture: &Picture| {
        let path = &results.paths[picture.cases[0]];
        let drawn = match picture.kind {
            FigureKind::Paths => vec![paths(results, picture, path)],
            FigureKind::Superposition => vec![superposition(results, picture, path)],
            FigureKind::Curves => curves(results, picture),
            FigureKind::Sources => sources(results, picture, path),
        };
        picture.file_stems(&results.study.machine).into_iter().zip(drawn)
    };
    let answer = agreement::figure(results).map(|figure| ("answer".to_string(), figure));
    answer.into_iter().chain(shown.pictures.iter().flat_map(picture)).collect()
}

/// Most frames of a picture.
const MOST_FRAMES: usize = 6;
const AXES: [&str; 3] = ["x", "y", "z"];

fn subtitle(results: &ValidationResults, cases: &[usize]) -> String {
    let cases: Vec<&str> = cases.iter().map(|&case| results.study.cases[case].as_str()).collect();
    format!("{}, {}; {}", results.study.machine.short_title(), cases.join(", "), results.study.variants[0].name)
}

/// The wanted path with `error` added at each point.
fn moved(path: &PathResults, label: &str, dashed: bool, error: &dyn Fn(usize) -> Option<Vector3<f64>>) -> LineSeries {
    let at = |(k, point): (usize, Vector3<f64>)| error(k).map(|error| (point.x + error.x, point.y + error.y));
    LineSeries {
        label: label.into(),
        points: path.study.wanted().into_iter().enumerate().filter_map(at).collect(),
        dashed,
        band: Vec::new(),
    }
}

fn plane(results: &ValidationResults, picture: &Picture, series: Vec<LineSeries>) -> Figure {
    Figure::Lines(LineFigure {
        title: picture.title.clone(),
        subtitle: format!("{}, seen along −z", subtitle(results, &picture.cases)),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        series,
        equal_axes: true,
        log_x: false,
        log_y: false,
        closed_note: Some("drawn to scale, errors not amplified".into()),
    })
}

fn paths(results: &ValidationResults, picture: &Picture, path: &PathResults) -> Figure {
    let series = vec![
        moved(path, "1 target trajectory", false, &|_| Some(Vector3::zeros())),
        moved(path, "2 shifted by errors in serial chains", true, &|k| path.whole.displacement(Source::Errors, k)),
        moved(path, "3 shifted by the cutting force", true, &|k| path.whole.displacement(Source::Cutting, k)),
        moved(path, "4 shifted by both", false, &|k| path.whole.displacement(Source::All, k)),
        moved(path, "5 adjusted trajectory", false, &|k| path.whole.command_shift(&path.study, k)),
    ];
    plane(results, picture, series)
}

fn superposition(results: &ValidationResults, picture: &Picture, path: &PathResults) -> Figure {
    let sum = |k| Some(path.whole.displacement(Source::Cutting, k)? + path.whole.displacement(Source::Errors, k)?);
    let series = vec![
        moved(path, "1 target trajectory", false, &|_| Some(Vector3::zeros())),
        moved(path, "2 shifted by errors in serial chains", true, &|k| path.whole.displacement(Source::Errors, k)),
        moved(path, "3 shifted by both: superposition", true, &sum),
        moved(path, "4 shifted by both: simultaneously", false, &|k| path.whole.displacement(Source::All, k)),
    ];
    plane(results, picture, series)
}

/// A curve over the tool angle, broken where there is no value; it ends at the angle at which it begins.
fn over_angle(path: &PathResults, value: &dyn Fn(usize) -> Option<f64>) -> PanelCurve {
    let mut order: Vec<(f64, usize)> =
        path.study.stations.iter().enumerate().filter_map(|(k, station)| Some((station.phi_deg?, k))).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = order.first().map(|&(phi, k)| (phi + 360.0, k));
    let mut pieces = vec![Vec::new()];
    for (phi, k) in order.into_iter().chain(first) {
        match value(k) {
            Some(value) => pieces.last_mut().into_iter().for_each(|piece: &mut Vec<_>| piece.push((phi, value))),
            None => pieces.push(Vec::new()),
        }
    }
    PanelCurve { pieces }
}

fn panels(
    results: &ValidationResults,
    picture: &Picture,
    (what, y_label): (&str, String),
    names: Vec<(String, bool)>,
    panels: Vec<CurvePanel>,
) -> Figure {
    Figure::Panels(PanelFigure {
        title: format!("{}: {what}", picture.title),
        subtitle: subtitle(results, &picture.cases),
        x_label: "tool angle φ [°]".into(),
        y_label,
        curves: names,
        panels,
        equal_axes: false,
        note: String::new(),
    })
}

fn drive_correction(path: &PathResults, source: Source, k: usize, drive: usize) -> Option<f64> {
    let deltas = path.whole.at(source, k).compensated()?.delta_rho();
    shown_positions(&path.study.machine, &deltas).get(drive).copied()
}

fn curves(results: &ValidationResults, picture: &Picture) -> Vec<Figure> {
    let machine = &results.study.machine;
    let drives = |kind| -> Vec<(usize, String)> { drives_of(machine, kind).collect() };
    let names = |kind| drives(kind).into_iter().map(|(_, label)| (format!("drive {label}"), false)).collect();
    let axes: Vec<(String, bool)> = AXES.map(|axis| (format!("Δ{axis}"), false)).into();
    let frames = |curves: &dyn Fn(&PathResults) -> Vec<PanelCurve>| {
        let frame = |&case: &usize| CurvePanel {
            title: results.study.cases[case].clone(),
            curves: curves(&results.paths[case]),
        };
        picture.cases.iter().map(frame).collect()
    };
    let corrections = |kind| {
        let frames = frames(&|path| {
            let curve = |(drive, _)| over_angle(path, &|k| drive_correction(path, Source::All, k, drive));
            drives(kind).into_iter().map(curve).collect()
        });
        let y_label = format!("Δρ [{}]", kind.shown_position_unit());
        panels(results, picture, (&correction_words(machine, kind), y_label), names(kind), frames)
    };
    let displacements = frames(&|path| {
        let curve = |axis: usize| over_angle(path, &|k| path.whole.displacement(Source::All, k).map(|d| d[axis]));
        (0..3).map(curve).collect()
    });
    let forces = |kind| {
        let frames = frames(&|path| {
            let force = |k, drive: usize| path.whole.at(Source::All, k).compensated()?.drive_forces.get(drive).copied();
            drives(kind).into_iter().map(|(drive, _)| over_angle(path, &|k| force(k, drive))).collect()
        });
        let what = format!("drive {}s", kind.force_word());
        panels(results, picture, (&what, format!("τ [{}]", kind.shown_force_unit())), names(kind), frames)
    };
    let moved = panels(results, picture, ("displacement that is compensated", "Δt [mm]".into()), axes, displacements);
    machine.drive_kinds().map(corrections).chain([moved]).chain(machine.drive_kinds().map(forces)).collect()
}

/// Heading of corrections of the drives of one kind.
fn correction_words(machine: &Machine, kind: Motion) -> String {
    match machine.has_mixed_drives() {
        false => "drive corrections".into(),
        true => format!("corrections of {}", kind_word(machine, kind)),
    }
}

fn source_words(source: Source) -> &'static str {
    match source {
        Source::Errors => "errors in serial chains",
        other => other.words(),
    }
}

fn sources(results: &ValidationResults, picture: &Picture, path: &PathResults) -> Vec<Figure> {
    let machine = &results.study.machine;
    let names: Vec<(String, bool)> =
        Source::of(machine).iter().map(|source| (source_words(*source).to_string(), *source != Source::All)).collect();
    let by_source = |title: String, value: &dyn Fn(Source, usize) -> Option<f64>| CurvePanel {
        title,
        curves: Source::of(machine).iter().map(|source| over_angle(path, &|k| value(*source, k))).collect(),
    };
    let corrections = |kind| {
        let frames = drives_of(machine, kind).take(MOST_FRAMES).map(|(drive, label)| {
            by_source(format!("drive {label}"), &|source, k| drive_correction(path, source, k, drive))
        });
        let what = format!("{} by source", correction_words(machine, kind));
        let y_label = format!("Δρ [{}]", kind.shown_position_unit());
        panels(results, picture, (&what, y_label), names.clone(), frames.collect())
    };
    let displacements = AXES.iter().enumerate().map(|(axis, name)| {
        by_source(format!("Δ{name}"), &|source, k| path.whole.displacement(source, k).map(|d| d[axis]))
    });
    let (what, frames) = ("displacement by source", displacements.collect());
    let moved = panels(results, picture, (what, "Δt [mm]".into()), names.clone(), frames);
    machine.drive_kinds().map(corrections).chain([moved]).collect()
}
