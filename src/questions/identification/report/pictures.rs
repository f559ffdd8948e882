//! Figures of an identification: parameters with their intervals, measured against predicted, and residuals.

use nalgebra::Vector3;

use super::{summary::Report, text};
use crate::{
    figures::{Figure, LineFigure, LineSeries},
    questions::identification::{Estimate, Measurement},
};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Most parameters in the figure of their intervals.
const MOST: usize = 12;

/// Returns all figures with their file stems, without those that have nothing to draw.
pub(super) fn figures(report: &Report<'_>) -> Vec<(String, Figure)> {
    let in_order = ["Residuals of the fit, in the order of measuring", "number of the measurement"];
    let against_load = ["Residuals of the fit against the load", "size of the force [N]"];
    let all = [
        ("answer", parameter_bars(report)),
        ("predicted", predicted_over_measured(report)),
        ("residuals", plot_over(report, in_order, |order, _| (order + 1) as f64)),
        ("residuals_over_load", plot_over(report, against_load, |_, row| force(row).norm())),
        ("residuals_over_direction", over_direction(report)),
        ("residuals_over_pose", over_pose(report)),
    ];
    let drawn = all.into_iter().filter(|(_, figure)| !figure.series.is_empty());
    drawn.map(|(stem, figure)| (stem.to_string(), Figure::Lines(figure))).collect()
}

/// Draws the interval of each parameter as a bar, by its change from the machine file.
fn parameter_bars(report: &Report<'_>) -> LineFigure {
    let finite = report.results.estimates.iter().enumerate().filter(|(_, estimate)| estimate.half_width.is_finite());
    let bar = |(k, estimate): (usize, &Estimate)| {
        let (x, y) = (report.results.fit.x[k], (k + 1) as f64);
        let points = vec![(x - estimate.half_width, y), (x, y), (x + estimate.half_width, y)];
        let label = match estimate.open {
            None => text::brief(estimate),
            Some(_) => format!("{}: not identified", estimate.unknown.name),
        };
        LineSeries::new(format!("{} {label}", k + 1), points, false)
    };
    let bars = finite.take(MOST).map(bar).collect();
    let labels = ["change from the machine file [ln of the factor; mm; °]", "number of the unknown"];
    let note = match report.results.estimates.len() {
        all if all > MOST => Some(format!("at most {MOST} of {all} unknowns are drawn; bars are 95 % intervals")),
        _ => Some("bars are 95 % intervals; unknowns without one are not drawn".to_string()),
    };
    LineFigure { closed_note: note, ..line_figure(report, "What was found, against the machine file", labels, bars) }
}

/// Measured lengths along one axis, or by gauges.
struct Lengths {
    name: String,
    /// Index of the measurement, measured length and residual, mm.
    points: Vec<(usize, f64, f64)>,
}

/// Returns the measured lengths and their residuals, grouped by axis or gauge.
fn lengths(report: &Report<'_>) -> Vec<Lengths> {
    let mut all: Vec<Lengths> = Vec::new();
    let rows = report.study.measurements.iter().enumerate();
    let readings = rows.flat_map(|(order, row)| row.readings.iter().map(move |reading| (order, reading)));
    for ((order, reading), residual) in readings.zip(&report.results.fit.residuals) {
        if reading.quantity.is_rotation() {
            continue;
        }
        let axis = AXES.iter().find(|axis| reading.column.ends_with(&format!("_{axis}_mm")));
        let name = axis.map_or("gauge".to_string(), |axis| format!("along {axis}"));
        let point = (order, reading.value, *residual);
        match all.iter_mut().find(|other| other.name == name) {
            Some(group) => group.points.push(point),
            None => all.push(Lengths { name, points: vec![point] }),
        }
    }
    all
}

/// Makes a line figure with the common subtitle: machine, number of measurements, loss.
fn line_figure(report: &Report<'_>, title: &str, labels: [&str; 2], series: Vec<LineSeries>) -> LineFigure {
    let (machine, count) = (&report.study.machine.name, report.study.measurements.len());
    let subtitle = format!("{machine}, {count} measurements, loss: {}", report.study.loss.label());
    LineFigure::new(title, subtitle, labels, series)
}

/// Draws predicted against measured lengths.
fn predicted_over_measured(report: &Report<'_>) -> LineFigure {
    let series_of = |Lengths { name, mut points }| {
        points.sort_by(|(_, a, _), (_, b, _)| a.total_cmp(b));
        let predicted = points.into_iter().map(|(_, measured, residual)| (measured, measured - residual));
        LineSeries::new(name, predicted.collect(), false)
    };
    let lengths = lengths(report);
    let values = || lengths.iter().flat_map(|group| group.points.iter().map(|&(_, measured, _)| measured));
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let diagonal = (low < high).then(|| LineSeries::new("as measured", vec![(low, low), (high, high)], false));
    let series = diagonal.into_iter().chain(lengths.into_iter().map(series_of)).collect();
    line_figure(report, "Predicted against measured", ["measured [mm]", "predicted [mm]"], series)
}

const LEFT: &str = "measured − predicted [mm]";

/// Draws the residuals of lengths over `value` of each measurement and its index, ascending; `label` is that of the abscissa.
fn plot_over(report: &Report<'_>, [title, label]: [&str; 2], value: impl Fn(usize, &Measurement) -> f64) -> LineFigure {
    let series_of = |Lengths { name, points }| {
        let abscissa = |order: usize| value(order, &report.study.measurements[order]);
        let mut points: Vec<(f64, f64)> =
            points.into_iter().map(|(order, _, residual)| (abscissa(order), residual)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        LineSeries::new(name, points, false)
    };
    let series = lengths(report).into_iter().map(series_of).collect();
    line_figure(report, title, [label, LEFT], series)
}

/// Returns the force on the tool tip less that of the reference load, axes of O, N.
fn force(row: &Measurement) -> Vector3<f64> {
    row.load.force - row.reference.force
}

/// Draws the residuals over the direction of the force in the x–y plane of O.
fn over_direction(report: &Report<'_>) -> LineFigure {
    let angle = |_, row: &Measurement| libm::atan2(force(row).y, force(row).x).to_degrees();
    let title = "Residuals of the fit against the direction of the force";
    plot_over(report, [title, "direction in the x–y plane of O, from x to y [°]"], angle)
}

/// Draws the size of the residual over the position of each drive, as a share of the range in which it was measured.
fn over_pose(report: &Report<'_>) -> LineFigure {
    let measurements = &report.study.measurements;
    let mut squares = vec![0.0; measurements.len()];
    for group in lengths(report) {
        group.points.iter().for_each(|&(order, _, residual)| squares[order] += residual * residual);
    }
    let series_of = |(k, label): (usize, String)| {
        let positions = || measurements.iter().map(|measurement| measurement.at.drives[k]);
        let (low, high) = (positions().fold(f64::INFINITY, f64::min), positions().fold(f64::NEG_INFINITY, f64::max));
        if high - low <= 0.0 {
            return LineSeries::new(label, Vec::new(), false);
        }
        let shares = positions().map(|position| (position - low) / (high - low));
        let mut points: Vec<(f64, f64)> = shares.zip(squares.iter().map(|squares| squares.sqrt())).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        LineSeries::new(label, points, false)
    };
    let all = report.study.machine.drive_labels().into_iter().enumerate().map(series_of);
    let all = all.filter(|series| !series.points.is_empty()).collect();
    let labels = ["position of the drive, of the range in which it was measured", "size of the residual [mm]"];
    line_figure(report, "Residuals of the fit against the pose", labels, all)
}
