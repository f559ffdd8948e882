//! Which pictures a compensated program gives.

use nalgebra::Vector3;

use super::Proved;
use crate::{
    report::{
        amplification::amplification,
        figures::{Figure, LineFigure, LineSeries},
        words::counted,
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
        LineSeries { label: label.clone(), points: curve.points(), dashed: label.ends_with("alone") }
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

/// The path from above: wanted, as the tool goes without compensation and with the program as written.
fn path(job: &ProgramJob, proved: &Proved<'_>) -> Figure {
    let wanted: Vec<Vector3<f64>> =
        job.demands.iter().map(|demand| demand.wanted().transform(demand.offset(&job.machine))).collect();
    let largest = proved.before.worst(job).map_or(0.0, |(_, worst)| worst);
    let factor = amplification(&wanted, largest);
    let shown = drawn(&wanted);
    let series = |label: &str, dashed: bool, errors: Option<&[Option<Vector3<f64>>]>| {
        let at = |&k: &usize| {
            let error = errors.map_or(Some(Vector3::zeros()), |errors| *errors.get(k)?)?;
            let at = wanted[k] + error * factor;
            Some((at.x, at.y))
        };
        LineSeries { label: label.into(), points: shown.iter().filter_map(at).collect(), dashed }
    };
    Figure::Lines(LineFigure {
        title: "Where the tool goes before and after".into(),
        subtitle: format!("{}, seen along \u{2212}z of the base", job.machine.short_title()),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        series: vec![
            series("wanted", false, None),
            series("before", false, Some(proved.before.of(Source::All))),
            series("after", true, Some(proved.after)),
        ],
        equal_axes: true,
        log_x: false,
        log_y: false,
        closed_note: Some(format!("deviations drawn {factor} times as large")),
    })
}
