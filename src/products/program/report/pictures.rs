//! Which pictures a compensated program gives.

use nalgebra::Vector3;

use super::{
    Proved,
    findings::{Drawn, Findings, Worst},
};
use crate::{
    figures::{Figure, LineFigure, LineSeries, Look, PlanFigure, PlanShape, amplification::amplification},
    files::words::{counted, millimetres},
    products::program::ProgramJob,
    questions::path::report::{Curve, cutting_force},
    simulation::Source,
};

/// All pictures by name: the path on the part, errors along it, those by each source, and the cutting force.
pub fn figures(job: &ProgramJob, proved: &Proved<'_>) -> Vec<(String, Figure)> {
    let findings = proved.findings;
    let all = &findings.before_curves[Source::All];
    let mut sources = vec![("all at once".to_string(), all)];
    let alone = findings.before_curves.iter().filter(|(source, _)| *source != Source::All);
    sources.extend(alone.map(|(source, curve)| (format!("{} alone", source.words()), curve)));
    let errors = [("before".into(), all), ("after".into(), &findings.after_curve)];
    let mut figures = vec![
        ("answer".into(), path(job, proved)),
        ("errors".into(), along(job, "Distance from the path before and after", &errors)),
        ("sources".into(), along(job, "What each source does without compensation", &sources)),
    ];
    figures.extend(force(job, proved).map(|figure| ("cutting_force".into(), figure)));
    figures
}

/// Sizes of errors over the length of the path.
fn along(job: &ProgramJob, title: &str, errors: &[(String, &Curve)]) -> Figure {
    let curve = |(label, curve): &(String, &Curve)| LineSeries {
        label: label.clone(),
        points: curve.points(),
        dashed: label.ends_with("alone"),
        band: Vec::new(),
    };
    line_figure(job, title, "distance [mm]", errors.iter().map(curve).collect())
}

/// Components and size of the cutting force, if there is any.
fn force(job: &ProgramJob, proved: &Proved<'_>) -> Option<Figure> {
    let curves = proved.findings.force.labelled();
    let series = curves.iter().map(|(label, curve)| LineSeries {
        label: label.clone(),
        points: curve.points(),
        dashed: label == cutting_force::SIZE,
        band: Vec::new(),
    });
    (!curves.is_empty()).then(|| line_figure(job, cutting_force::TITLE, "force [N]", series.collect()))
}

/// Curves over the length of the path.
fn line_figure(job: &ProgramJob, title: &str, y_label: &str, series: Vec<LineSeries>) -> Figure {
    Figure::Lines(LineFigure {
        title: title.into(),
        subtitle: format!("{}, {}", job.machine.short_title(), counted(job.path.len(), "point")),
        x_label: "length along the path [mm]".into(),
        y_label: y_label.into(),
        series,
        equal_axes: false,
        log_x: false,
        log_y: false,
        closed_note: None,
    })
}

/// The path from above: wanted, as the tool goes without compensation and with the program as written, and the line in which it
/// is off farthest.
fn path(job: &ProgramJob, proved: &Proved<'_>) -> Figure {
    let Findings { worst, corners, drawn, .. } = proved.findings;
    let factor = amplification(corners, worst.as_ref().map_or(0.0, |worst| worst.size_mm));
    let pieces = |look: Look, error: fn(&Drawn) -> Option<Vector3<f64>>| {
        let mut pieces: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
        for point in drawn {
            match error(point) {
                Some(error) => {
                    let at = point.wanted + error * factor;
                    pieces.last_mut().into_iter().for_each(|piece| piece.push((at.x, at.y)));
                }
                None => pieces.push(Vec::new()),
            }
        }
        let shape = move |points| PlanShape { look, points, label: String::new() };
        pieces.into_iter().filter(|piece| !piece.is_empty()).map(shape).collect::<Vec<_>>()
    };
    let mark = |worst: &Worst| {
        let at = worst.wanted + worst.error * factor;
        let point = &job.path.points()[worst.point];
        let line = job.file.place_of(point.source.segment).map_or_else(String::new, |line| format!("{line}, "));
        (at.x, at.y, format!("worst {}\n{line}{:.1} mm along", millimetres(worst.size_mm, 3), point.arc_length_mm))
    };
    Figure::Plan(Box::new(PlanFigure {
        title: "Where the tool goes before and after".into(),
        subtitle: format!("{}, seen along \u{2212}z of the base", job.machine.short_title()),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: String::new(),
        field: None,
        shapes: [
            pieces(Look::Wanted, |_| Some(Vector3::zeros())),
            pieces(Look::Before, |point| point.before),
            pieces(Look::After, |point| point.after),
        ]
        .concat(),
        coloured: Vec::new(),
        marks: worst.iter().map(mark).collect(),
        note: format!("deviations drawn {factor} times as large; those along z do not show here"),
    }))
}
