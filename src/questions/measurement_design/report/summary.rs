//! What a plan says, for programs, and numbers that several reports take.

use serde_json::{Value, json};

use crate::questions::{
    identification::report::ANYTHING,
    measurement_design::{MeasurementDesignStudy, Plan, Widths},
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
