//! Which pictures a path study gives.

use nalgebra::Vector3;

use crate::{
    machine::Motion,
    report::{
        amplification::amplification,
        figures::{Figure, LineFigure, LineSeries},
        table::{force_unit, position_unit},
        words::counted,
    },
    study::{
        Source,
        path_study::{PathResults, Station},
    },
};

/// All pictures with their file stems.
pub fn figures(results: &PathResults) -> Vec<(String, Figure)> {
    let labels = results.study.machine.drive_labels();
    let mut figures = vec![
        ("displacement".to_string(), displacement(results)),
        ("delta_rho".to_string(), corrections(results)),
        ("drive_force".to_string(), forces(results)),
        ("paths".to_string(), paths(results)),
    ];
    for (drive, label) in labels.iter().enumerate() {
        figures.push((format!("delta_rho_sources_{label}"), correction_by_source(results, drive, label)));
    }
    figures
}

fn source_words(source: Source) -> &'static str {
    match source {
        Source::Cutting => "cutting force",
        Source::Assembly => "chain errors",
        Source::Both => "both at once",
    }
}

fn along(results: &PathResults, station: &Station) -> Option<f64> {
    if results.study.is_circle { station.phi_deg } else { Some(station.arc_length_mm) }
}

fn along_label(results: &PathResults) -> String {
    if results.study.is_circle { "tool angle φ [°]".into() } else { "path length [mm]".into() }
}

/// A curve over the path; points without a value are left out.
fn curve(
    results: &PathResults,
    label: impl Into<String>,
    dashed: bool,
    value: impl Fn(usize) -> Option<f64>,
) -> LineSeries {
    let stations = results.study.stations.iter().enumerate();
    let mut points: Vec<(f64, f64)> =
        stations.filter_map(|(k, station)| Some((along(results, station)?, value(k)?))).collect();
    if results.study.is_circle {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        // One turn: the curve ends at the angle at which it begins.
        points.extend(points.first().map(|&(phi, value)| (phi + 360.0, value)));
    }
    LineSeries { label: label.into(), points, dashed }
}

fn line_figure(results: &PathResults, title: &str, y_label: String, series: Vec<LineSeries>) -> Figure {
    let study = &results.study;
    Figure::Lines(LineFigure {
        title: title.into(),
        subtitle: format!("{}, {}", study.machine.name, counted(study.stations.len(), "point")),
        x_label: along_label(results),
        y_label,
        series,
        equal_axes: false,
        log_x: false,
        log_y: false,
        closed_note: None,
    })
}

fn displacement(results: &PathResults) -> Figure {
    let mut series: Vec<LineSeries> = Source::ALL
        .map(|source| {
            let size = |k| results.displacement(source, k).map(|d| d.norm());
            curve(results, source_words(source), source != Source::Both, size)
        })
        .into();
    let superposed = |k| {
        let sum = results.displacement(Source::Cutting, k)? + results.displacement(Source::Assembly, k)?;
        Some(sum.norm())
    };
    series.push(curve(results, "sum of the two", true, superposed));
    line_figure(results, "How far the tool leaves its path without compensation", "|Δt| [mm]".into(), series)
}

fn correction(results: &PathResults, source: Source, k: usize, drive: usize) -> Option<f64> {
    let delta = *results.compensated(source, k)?.delta_rho().get(drive)?;
    let motion = results.study.machine.drives().nth(drive).map(|(_, drive)| drive.motion)?;
    Some(if motion == Motion::Revolute { delta.to_degrees() } else { delta })
}

fn corrections(results: &PathResults) -> Figure {
    let labels = results.study.machine.drive_labels();
    let series = labels.iter().enumerate().map(|(drive, label)| {
        curve(results, format!("drive {label}"), false, |k| correction(results, Source::Both, k, drive))
    });
    let y_label = format!("Δρ [{}]", position_unit(&results.study.machine));
    line_figure(results, "What the drives must be told instead", y_label, series.collect())
}

fn forces(results: &PathResults) -> Figure {
    let labels = results.study.machine.drive_labels();
    let series = labels.iter().enumerate().map(|(drive, label)| {
        let force = |k| results.compensated(Source::Both, k)?.compensation.drive_forces.get(drive).copied();
        curve(results, format!("drive {label}"), false, force)
    });
    let y_label = format!("τ [{}]", force_unit(&results.study.machine));
    line_figure(results, "Drive forces along the compensated path", y_label, series.collect())
}

fn correction_by_source(results: &PathResults, drive: usize, label: &str) -> Figure {
    let series = Source::ALL.map(|source| {
        let delta = |k| correction(results, source, k, drive);
        curve(results, source_words(source), source != Source::Both, delta)
    });
    let title = format!("Which source asks drive {label} for what");
    line_figure(results, &title, format!("Δρ {label} [{}]", position_unit(&results.study.machine)), series.into())
}

/// The path in the xy-plane: wanted, as the tool goes without compensation, as it is commanded and as it goes then.
fn paths(results: &PathResults) -> Figure {
    let study = &results.study;
    let wanted = results.wanted();
    let displacements = (0..wanted.len()).filter_map(|k| results.displacement(Source::Both, k));
    let amplification = amplification(&wanted, displacements.fold(0.0f64, |most, d| most.max(d.norm())));
    let drawn = |label: &str, dashed: bool, error: &dyn Fn(usize) -> Option<Vector3<f64>>| {
        let points = wanted.iter().enumerate().filter_map(|(k, p)| {
            let at = p + error(k)? * amplification;
            Some((at.x, at.y))
        });
        LineSeries { label: label.into(), points: points.collect(), dashed }
    };
    let left = |k: usize| Some(results.compensated(Source::Both, k)?.compensation.position_error);
    let series = vec![
        drawn("wanted", false, &|_| Some(Vector3::zeros())),
        drawn("moved by chain errors", true, &|k| results.displacement(Source::Assembly, k)),
        drawn("moved by the cutting force", true, &|k| results.displacement(Source::Cutting, k)),
        drawn("moved by both", false, &|k| results.displacement(Source::Both, k)),
        drawn("commanded instead", false, &|k| results.command_shift(k)),
        drawn("after compensation", true, &left),
    ];
    Figure::Lines(LineFigure {
        title: "Paths before and after compensation".into(),
        subtitle: format!("{}, seen along −z", study.machine.name),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        series,
        equal_axes: true,
        log_x: false,
        log_y: false,
        closed_note: Some(format!("deviations from the wanted path drawn {amplification} times as large")),
    })
}
