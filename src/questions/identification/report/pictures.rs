//! Pictures of an identification: the numbers with their intervals, what was measured against what is predicted, and what is left.

use nalgebra::Vector3;

use super::{summary::Report, text};
use crate::{
    figures::{Figure, LineFigure, LineSeries},
    questions::identification::{Found, Measurement},
};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Most numbers in the picture of them.
const MOST: usize = 12;

/// All pictures with their file stems; one without anything to draw is left out.
pub(super) fn figures(report: &Report<'_>) -> Vec<(String, Figure)> {
    let all = [
        ("answer", numbers(report)),
        ("predicted", predicted(report)),
        ("residuals", residuals(report)),
        ("residuals_over_load", over_load(report)),
        ("residuals_over_direction", over_direction(report)),
        ("residuals_over_pose", over_pose(report)),
    ];
    let drawn = all.into_iter().filter(|(_, figure)| !figure.series.is_empty());
    drawn.map(|(stem, figure)| (stem.to_string(), Figure::Lines(figure))).collect()
}

/// The interval of each number as a bar, by its change from the machine file.
fn numbers(report: &Report<'_>) -> LineFigure {
    let finite = report.found.found.iter().enumerate().filter(|(_, own)| own.half_width.is_finite());
    let bar = |(k, own): (usize, &Found)| {
        let (x, y) = (report.found.fit.x[k], (k + 1) as f64);
        let points = vec![(x - own.half_width, y), (x, y), (x + own.half_width, y)];
        let said = if own.open.is_none() { text::about(own) } else { format!("{}: not identified", own.unknown.name) };
        LineSeries::new(format!("{} {said}", k + 1), points, false)
    };
    let bars = finite.take(MOST).map(bar).collect();
    let labels = ["change from the machine file [ln of the factor; mm; °]", "number of the unknown"];
    let note = match report.found.found.len() {
        all if all > MOST => Some(format!("at most {MOST} of {all} unknowns are drawn; bars are 95 % intervals")),
        _ => Some("bars are 95 % intervals; unknowns without one are not drawn".to_string()),
    };
    LineFigure { closed_note: note, ..figure(report, "What was found, against the machine file", labels, bars) }
}

fn subtitle(report: &Report<'_>) -> String {
    let study = report.study;
    format!("{}, {} measurements, loss: {}", study.machine.short_title(), study.measurements.len(), study.loss.label())
}

/// Lengths that were read along an axis or by a gauge.
struct Lengths {
    name: String,
    /// Number of the measurement from 0, measured, residual.
    points: Vec<(usize, f64, f64)>,
}

fn lengths(report: &Report<'_>) -> Vec<Lengths> {
    let mut all: Vec<Lengths> = Vec::new();
    let mut i = 0;
    for (order, own) in report.study.measurements.iter().enumerate() {
        for reading in &own.readings {
            let residual = report.found.fit.residuals[i];
            i += 1;
            if reading.quantity.is_rotation() {
                continue;
            }
            let axis = AXES.iter().find(|axis| reading.column.ends_with(&format!("_{axis}_mm")));
            let name = axis.map_or("gauge".to_string(), |axis| format!("along {axis}"));
            let point = (order, reading.value, residual);
            match all.iter_mut().find(|other| other.name == name) {
                Some(own) => own.points.push(point),
                None => all.push(Lengths { name, points: vec![point] }),
            }
        }
    }
    all
}

fn figure(report: &Report<'_>, title: &str, labels: [&str; 2], series: Vec<LineSeries>) -> LineFigure {
    LineFigure {
        title: title.into(),
        subtitle: subtitle(report),
        x_label: labels[0].into(),
        y_label: labels[1].into(),
        series,
        ..LineFigure::default()
    }
}

fn predicted(report: &Report<'_>) -> LineFigure {
    let of = |Lengths { name, mut points }| {
        points.sort_by(|a, b| a.1.total_cmp(&b.1));
        LineSeries::new(
            name,
            points.into_iter().map(|(_, measured, residual)| (measured, measured - residual)).collect(),
            false,
        )
    };
    let lengths = lengths(report);
    let values = || lengths.iter().flat_map(|own| own.points.iter().map(|point| point.1));
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let perfect = (low < high).then(|| LineSeries::new("as measured", vec![(low, low), (high, high)], false));
    let all = perfect.into_iter().chain(lengths.into_iter().map(of)).collect();
    figure(report, "Predicted against measured", ["measured [mm]", "predicted [mm]"], all)
}

const LEFT: &str = "measured − predicted [mm]";

/// What is left of lengths over something of the measurements, in its order.
fn over(report: &Report<'_>, [title, label]: [&str; 2], value: impl Fn(usize, &Measurement) -> f64) -> LineFigure {
    let of = |Lengths { name, points }| {
        let at = |order: usize| value(order, &report.study.measurements[order]);
        let mut points: Vec<(f64, f64)> = points.into_iter().map(|(order, _, left)| (at(order), left)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        LineSeries::new(name, points, false)
    };
    let all = lengths(report).into_iter().map(of).collect();
    figure(report, title, [label, LEFT], all)
}

fn residuals(report: &Report<'_>) -> LineFigure {
    over(report, ["Residuals of the fit, in the order of measuring", "number of the measurement"], |order, _| {
        (order + 1) as f64
    })
}

fn force(own: &Measurement) -> Vector3<f64> {
    own.load.force - own.reference.force
}

fn over_load(report: &Report<'_>) -> LineFigure {
    over(report, ["Residuals of the fit against the load", "size of the force [N]"], |_, own| force(own).norm())
}

fn over_direction(report: &Report<'_>) -> LineFigure {
    let angle = |_, own: &Measurement| force(own).y.atan2(force(own).x).to_degrees();
    over(
        report,
        ["Residuals of the fit against the direction of the force", "direction in the x–y plane of O, from x to y [°]"],
        angle,
    )
}

/// The size of what is left over where each drive stood, of the range in which it was measured.
fn over_pose(report: &Report<'_>) -> LineFigure {
    let measurements = &report.study.measurements;
    let mut squares = vec![0.0; measurements.len()];
    for own in lengths(report) {
        own.points.iter().for_each(|&(order, _, left)| squares[order] += left * left);
    }
    let of = |(k, label): (usize, String)| {
        let positions = || measurements.iter().map(|own| own.at.drives[k]);
        let (low, high) = (positions().fold(f64::INFINITY, f64::min), positions().fold(f64::NEG_INFINITY, f64::max));
        if high - low <= 0.0 {
            return LineSeries::new(label, Vec::new(), false);
        }
        let shares = positions().map(|position| (position - low) / (high - low));
        let mut points: Vec<(f64, f64)> = shares.zip(squares.iter().map(|squares| squares.sqrt())).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        LineSeries::new(label, points, false)
    };
    let all = report.study.machine.drive_labels().into_iter().enumerate().map(of);
    let all = all.filter(|series| !series.points.is_empty()).collect();
    let labels = ["position of the drive, of the range in which it was measured", "size of the residual [mm]"];
    figure(report, "Residuals of the fit against the pose", labels, all)
}
