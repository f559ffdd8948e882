//! What a plan says, for programs and as a picture, and numbers that several reports take.

use serde_json::{Value, json};

use crate::{
    figures::{Figure, LineFigure, LineSeries},
    questions::{
        identification::report::ANYTHING,
        measurement_design::{MeasurementDesignStudy, Plan, Widths},
    },
};

/// What was asked and found.
pub(super) struct Report<'a> {
    pub study: &'a MeasurementDesignStudy,
    pub plan: &'a Plan,
}

/// An interval is not worth the name from here on: a factor of e, a millimetre or a degree either way.
const WIDE: f64 = 1.0;

impl Report<'_> {
    /// How far the unknowns will be known with all that were chosen.
    pub fn reached(&self) -> Option<&Widths> {
        self.plan.widths.last()
    }

    /// The same of as many random ones.
    pub fn random(&self) -> Option<&Widths> {
        self.plan.random.last()
    }

    /// Unknowns that will not be known.
    pub fn open(&self) -> Vec<usize> {
        let each = self.reached().map_or(&[][..], |own| &own.each);
        (0..each.len()).filter(|&k| each[k] > WIDE).collect()
    }

    /// The fewest measurements with which all are known as well as is wanted, if that is said and reached.
    pub fn enough(&self) -> Option<usize> {
        let target = self.study.target?;
        self.plan.widths.iter().position(|own| own.widest().is_some_and(|(_, width)| width <= target))
    }

    pub fn name(&self, unknown: usize) -> &str {
        &self.study.unknowns[unknown].name
    }
}

/// The answer for programs.
pub(super) fn json(report: &Report<'_>) -> Value {
    let of = |widths: Option<&Widths>| {
        widths.map(|own| {
            let each: Vec<Option<f64>> = own.each.iter().map(|&width| (width <= ANYTHING).then_some(width)).collect();
            json!({ "half_widths": each, "tested_rms_mm": own.tested_mm })
        })
    };
    let Report { study, plan } = report;
    json!({
        "schema": 1,
        "candidates": study.candidates.len(),
        "chosen": plan.chosen.iter().map(|&i| i + 1).collect::<Vec<_>>(),
        "parameters": study.unknowns.iter().map(|unknown| &unknown.name).collect::<Vec<_>>(),
        "with_chosen": of(report.reached()),
        "with_random_median": of(report.random()),
        "enough_for_target": report.enough(),
    })
}

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
        series.push(LineSeries::new(report.name(k), drawn(&report.plan.widths, &|own| own.each[k]), false));
    }
    series.push(LineSeries::new("widest, random measurements (median)", drawn(&report.plan.random, &widest), true));
    series.retain(|series| !series.points.is_empty());
    figure(report, series)
}

/// Wider ones say nothing.
const DRAWN: f64 = 10.0;

fn figure(report: &Report<'_>, series: Vec<LineSeries>) -> LineFigure {
    let study = report.study;
    let note = format!("intervals wider than {DRAWN} are not drawn");
    LineFigure {
        title: "How well the parameters will be known".into(),
        subtitle: format!("{}, {} candidates", study.machine.short_title(), study.candidates.len()),
        x_label: "number of measurements".into(),
        y_label: "half 95 % interval [ln, mm, °]".into(),
        series,
        log_y: true,
        closed_note: Some(note),
        ..LineFigure::default()
    }
}
