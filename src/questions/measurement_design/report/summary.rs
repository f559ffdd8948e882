//! JSON summary and figure of a design of measurements, and numbers that several of its reports share.

use serde_json::{Value, json};

use crate::{
    figures::{Figure, LineFigure, LineSeries},
    questions::{
        identification::report::ANYTHING,
        measurement_design::{HalfWidths, MeasurementDesignStudy, Plan},
    },
};

/// What reports are made of: study and plan.
pub(super) struct Report<'a> {
    pub study: &'a MeasurementDesignStudy,
    pub plan: &'a Plan,
}

/// Half width above which an unknown is not identified: a factor of e, a millimetre or a degree either way.
const WIDE: f64 = 1.0;

impl Report<'_> {
    /// Returns the half widths with all chosen measurements; `None` where the information matrix is not positive definite.
    pub fn final_widths(&self) -> Option<&HalfWidths> {
        self.plan.widths.last()
    }

    /// Returns the half widths with as many random measurements; `None` if none were drawn.
    pub fn random_widths(&self) -> Option<&HalfWidths> {
        self.plan.random.last()
    }

    /// Returns the indices of the unknowns whose interval will be too wide.
    pub fn unidentified(&self) -> Vec<usize> {
        let each = self.final_widths().map_or(&[][..], |widths| &widths.each);
        (0..each.len()).filter(|&k| each[k] > WIDE).collect()
    }

    /// Returns the fewest measurements with which all intervals reach the target; `None` without a target, or if it is not reached.
    pub fn sufficient_count(&self) -> Option<usize> {
        let target = self.study.target?;
        self.plan.widths.iter().position(|widths| widths.widest().is_some_and(|(_, width)| width <= target))
    }

    /// Returns the name of an unknown.
    pub fn name(&self, unknown: usize) -> &str {
        &self.study.unknowns[unknown].name
    }
}

/// Returns the results as JSON.
pub(super) fn json(report: &Report<'_>) -> Value {
    let widths_json = |widths: Option<&HalfWidths>| {
        widths.map(|widths| {
            let each: Vec<Option<f64>> =
                widths.each.iter().map(|&width| (width <= ANYTHING).then_some(width)).collect();
            json!({ "half_widths": each, "tested_rms_mm": widths.tested_mm })
        })
    };
    let Report { study, plan } = report;
    json!({
        "schema": 1,
        "candidates": study.candidates.len(),
        "chosen": plan.chosen.iter().map(|&i| i + 1).collect::<Vec<_>>(),
        "parameters": study.unknowns.iter().map(|unknown| &unknown.name).collect::<Vec<_>>(),
        "with_chosen": widths_json(report.final_widths()),
        "with_random_median": widths_json(report.random_widths()),
        "enough_for_target": report.sufficient_count(),
    })
}

/// Most unknowns that are drawn, those with the widest intervals first.
const MOST: usize = 8;

/// Returns all figures with their file stems, without those that have nothing to draw.
pub(super) fn figures(report: &Report<'_>) -> Vec<(String, Figure)> {
    let named = [("answer", widths_figure(report))];
    let drawn = named.into_iter().filter(|(_, figure)| !figure.series.is_empty());
    drawn.map(|(stem, figure)| (stem.to_string(), Figure::Lines(figure))).collect()
}

/// Draws half intervals over the number of measurements, as far as they are narrow enough to draw.
fn widths_figure(report: &Report<'_>) -> LineFigure {
    let Some(reached) = report.final_widths() else { return interval_figure(report, Vec::new()) };
    let mut order: Vec<usize> = (0..reached.each.len()).collect();
    order.sort_by(|&a, &b| reached.each[b].total_cmp(&reached.each[a]));
    let drawn = |widths_by_count: &[HalfWidths], width_of: &dyn Fn(&HalfWidths) -> f64| -> Vec<(f64, f64)> {
        let points = widths_by_count.iter().enumerate().map(|(count, widths)| (count as f64, width_of(widths)));
        points.filter(|(_, width)| (1e-90..=DRAWN).contains(width)).collect()
    };
    let widest = |widths: &HalfWidths| widths.widest().map_or(f64::INFINITY, |(_, width)| width);
    let mut series: Vec<LineSeries> = Vec::new();
    for &k in order.iter().take(MOST) {
        series.push(LineSeries::new(report.name(k), drawn(&report.plan.widths, &|widths| widths.each[k]), false));
    }
    series.push(LineSeries::new("widest, random measurements (median)", drawn(&report.plan.random, &widest), true));
    series.retain(|series| !series.points.is_empty());
    interval_figure(report, series)
}

/// Widest half interval that is drawn.
const DRAWN: f64 = 10.0;

/// Makes the figure of half the 95 % intervals over the number of measurements, a line for each of `series`.
fn interval_figure(report: &Report<'_>, series: Vec<LineSeries>) -> LineFigure {
    let study = report.study;
    let subtitle = format!("{}, {} candidates", study.machine.name, study.candidates.len());
    let labels = ["number of measurements", "half 95 % interval [ln, mm, °]"];
    LineFigure {
        log_y: true,
        closed_note: Some(format!("intervals wider than {DRAWN} are not drawn")),
        ..LineFigure::new("How well the parameters will be known", subtitle, labels, series)
    }
}
