//! Which pictures a compensated program gives.

use nalgebra::Vector3;

use super::Proved;
use crate::{
    report::{
        amplification::amplification,
        figures::{Figure, LineFigure, LineSeries, Look, PlanFigure, PlanShape},
        words::{counted, millimetres},
    },
    study::{
        Source,
        path::report::{Curve, cutting_force, drawn},
        program::ProgramJob,
    },
};

/// All pictures by name: the path on the part, errors along it, those by each source, and the cutting force.
pub fn figures(job: &ProgramJob, proved: &Proved<'_>) -> Vec<(String, Figure)> {
    let all = proved.before.of(Source::All);
    let mut sources = vec![("all at once".to_string(), all)];
    let alone = Source::of(&job.machine).iter().filter(|source| **source != Source::All);
    sources.extend(alone.map(|source| (format!("{} alone", source.words()), proved.before.of(*source))));
    let mut figures = vec![
        ("answer".into(), path(job, proved)),
        (
            "errors".into(),
            along(
                job,
                "Distance from the path before and after",
                &[("before".into(), all), ("after".into(), proved.after)],
            ),
        ),
        ("sources".into(), along(job, "What each source does without compensation", &sources)),
    ];
    figures.extend(force(job).map(|figure| ("cutting_force".into(), figure)));
    figures
}

/// Sizes of errors over the length of the path.
fn along(job: &ProgramJob, title: &str, errors: &[(String, &[Option<Vector3<f64>>])]) -> Figure {
    let curve = |(label, errors): &(String, &[Option<Vector3<f64>>])| {
        let mut curve = Curve::new(errors.len());
        for (k, (point, error)) in job.path.points().iter().zip(*errors).enumerate() {
            error.iter().for_each(|error| curve.add(k, point.arc_length_mm, error.norm()));
        }
        LineSeries { label: label.clone(), points: curve.points(), dashed: label.ends_with("alone"), band: Vec::new() }
    };
    line_figure(job, title, "distance [mm]", errors.iter().map(curve).collect())
}

/// Components and size of the cutting force, if there is any.
fn force(job: &ProgramJob) -> Option<Figure> {
    let lengths = job.path.points().iter().map(|point| Some(point.arc_length_mm));
    let curves = cutting_force::curves(lengths.zip(&job.demands));
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
    let wanted: Vec<Vector3<f64>> =
        job.demands.iter().map(|demand| demand.wanted().transform(demand.offset(&job.machine))).collect();
    let worst = proved.before.worst(job);
    let factor = amplification(&wanted, worst.map_or(0.0, |(_, size)| size));
    let shown = drawn(&wanted);
    let before = proved.before.of(Source::All);
    let pieces = |look: Look, errors: Option<&[Option<Vector3<f64>>]>| {
        let mut pieces: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
        for &k in &shown {
            match errors.map_or(Some(Vector3::zeros()), |errors| *errors.get(k)?) {
                Some(error) => {
                    let at = wanted[k] + error * factor;
                    pieces.last_mut().into_iter().for_each(|piece| piece.push((at.x, at.y)));
                }
                None => pieces.push(Vec::new()),
            }
        }
        let shape = move |points| PlanShape { look, points, label: String::new() };
        pieces.into_iter().filter(|piece| !piece.is_empty()).map(shape).collect::<Vec<_>>()
    };
    let mark = |(k, size): (usize, f64)| {
        let at = wanted[k] + before[k]? * factor;
        let point = &job.path.points()[k];
        let line = job.file.line_of(point.source.segment).map_or_else(String::new, |line| format!("line {line}, "));
        Some((at.x, at.y, format!("worst {}\n{line}{:.1} mm along", millimetres(size, 3), point.arc_length_mm)))
    };
    Figure::Plan(Box::new(PlanFigure {
        title: "Where the tool goes before and after".into(),
        subtitle: format!("{}, seen along \u{2212}z of the base", job.machine.short_title()),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: String::new(),
        field: None,
        shapes: [
            pieces(Look::Wanted, None),
            pieces(Look::Before, Some(before)),
            pieces(Look::After, Some(proved.after)),
        ]
        .concat(),
        coloured: Vec::new(),
        marks: worst.and_then(mark).into_iter().collect(),
        note: format!("deviations drawn {factor} times as large; those along z do not show here"),
    }))
}
