//! The picture of a plan: how the intervals shrink with the number of measurements.

use super::summary::Report;
use crate::{
    figures::{Figure, LineFigure, LineSeries},
    questions::measurement_design::Widths,
};

/// Most unknowns that are drawn, the least known first.
const MOST: usize = 8;

/// All pictures with their file stems.
pub(super) fn figures(report: &Report<'_>) -> Vec<(String, Figure)> {
    let all = [("answer", shrink(report))];
    let drawn = all.into_iter().filter(|(_, figure)| !figure.series.is_empty());
    drawn.map(|(stem, figure)| (stem.to_string(), Figure::Lines(figure))).collect()
}

/// Half intervals over the number of measurements; from the first with which all are known at all.
fn shrink(report: &Report<'_>) -> LineFigure {
    let Some(reached) = report.reached() else { return figure(report, Vec::new()) };
    let mut order: Vec<usize> = (0..reached.each.len()).collect();
    order.sort_by(|&a, &b| reached.each[b].total_cmp(&reached.each[a]));
    let drawn = |all: &[Widths], of: &dyn Fn(&Widths) -> f64| -> Vec<(f64, f64)> {
        let points = all.iter().enumerate().map(|(count, own)| (count as f64, of(own)));
        points.filter(|(_, width)| (1e-90..=DRAWN).contains(width)).collect()
    };
    let widest = |own: &Widths| own.widest().map_or(f64::INFINITY, |(_, width)| width);
    let mut series: Vec<LineSeries> = Vec::new();
    for &k in order.iter().take(MOST) {
        series.push(line(report.name(k).into(), drawn(&report.plan.widths, &|own| own.each[k]), false));
    }
    series.push(line("widest, random measurements (median)".into(), drawn(&report.plan.random, &widest), true));
    series.retain(|series| !series.points.is_empty());
    figure(report, series)
}

/// Wider ones say nothing.
const DRAWN: f64 = 10.0;

fn line(label: String, points: Vec<(f64, f64)>, dashed: bool) -> LineSeries {
    LineSeries { label, points, dashed, band: Vec::new() }
}

fn figure(report: &Report<'_>, series: Vec<LineSeries>) -> LineFigure {
    let study = report.study;
    let note = format!("intervals wider than {DRAWN} are not drawn");
    LineFigure {
        title: "How far the numbers will be known".into(),
        subtitle: format!("{}, {} candidates", study.machine.short_title(), study.candidates.len()),
        x_label: "number of measurements".into(),
        y_label: "half 95 % interval [ln, mm, °]".into(),
        series,
        log_y: true,
        closed_note: Some(note),
        ..LineFigure::default()
    }
}
