//! What an identification says, for programs, and numbers that several reports take.

use nalgebra::DVector;
use serde_json::{Value, json};

use crate::questions::identification::{
    FarOff, Found, IdentificationStudy, Identified, Measurement, Model, Reading,
    validate::rms_mm,
    written_files::{self, MachineFile},
};

/// What was asked and found.
pub(super) struct Report<'a> {
    pub study: &'a IdentificationStudy,
    pub found: &'a Identified,
    pub file: &'a MachineFile,
    /// Names of what stands in the file of errors of chains.
    pub errors: &'a [String],
}

impl Report<'_> {
    /// Unknowns that were identified.
    pub fn known(&self) -> impl Iterator<Item = &Found> {
        self.found.found.iter().filter(|own| own.open.is_none())
    }

    /// RMS of the residuals over that of what was measured, of lengths that the load changes; `None` without any.
    pub fn left_share(&self) -> Option<f64> {
        left_share(&self.found.fit.residuals, &self.study.measurements, &[])
    }

    /// The same without the readings that are far off all others.
    pub fn left_share_of_others(&self) -> Option<f64> {
        left_share(&self.found.fit.residuals, &self.study.measurements, &self.found.far_off)
    }

    /// What a machine file with some of the numbers costs, in a sentence.
    pub fn mixed_words(&self) -> Option<String> {
        self.file.text.as_ref()?;
        written_files::mixed_words(self.study, self.found)
    }

    /// Root of the mean square of the lengths read, mm.
    pub fn measured_mm(&self) -> Option<f64> {
        let readings = self.study.measurements.iter().flat_map(|own| &own.readings);
        let values: Vec<f64> = readings.map(|reading| reading.value).collect();
        rms_mm(&values, &self.study.measurements)
    }

    /// The same of what is left.
    pub fn residual_mm(&self) -> Option<f64> {
        rms_mm(self.found.fit.residuals.as_slice(), &self.study.measurements)
    }

    /// The same as predicted without its own measurement; `None` where one is predicted by no other.
    pub fn left_out_mm(&self) -> Option<f64> {
        rms_mm(&self.found.left_out, &self.study.measurements).filter(|all| all.is_finite())
    }

    /// Of the other sets of unknowns, that which predicts best, if better than that of the study.
    pub fn better(&self) -> Option<&Model> {
        let predicted = |model: &Model| model.predicted_mm.as_ref().ok().copied().flatten();
        let (own, others) = self.found.models.split_first()?;
        let best = others.iter().filter(|model| predicted(model).is_some()).min_by(|a, b| {
            let [a, b] = [a, b].map(|model| predicted(model).unwrap_or(f64::INFINITY));
            a.total_cmp(&b)
        })?;
        (predicted(best)? < 0.98 * predicted(own)?).then_some(best)
    }

    /// A combination of unknowns in words.
    pub fn words(&self, parts: &[(usize, f64)]) -> String {
        let part = |(k, part): &(usize, f64)| format!("{part:+.2} {}", self.study.unknowns[*k].name);
        let words: Vec<String> = parts.iter().map(part).collect();
        words.join(" ")
    }
}

/// RMS of `residuals` over that of what was measured, of lengths that the load changes and that are not among `far_off`; `None` without any.
pub(in super::super) fn left_share(
    residuals: &DVector<f64>,
    measurements: &[Measurement],
    far_off: &[FarOff],
) -> Option<f64> {
    let readings = measurements.iter().enumerate().flat_map(|(m, own)| own.readings.iter().map(move |r| (m, r)));
    let is_far =
        |m: usize, reading: &Reading| far_off.iter().any(|far| (far.measurement, far.column) == (m, reading.column));
    let lengths = readings
        .zip(residuals)
        .filter(|((m, reading), _)| reading.is_change() && !reading.quantity.is_rotation() && !is_far(*m, reading));
    let (left, all) =
        lengths.fold((0.0, 0.0), |(left, all), ((_, reading), r)| (left + r * r, all + reading.value * reading.value));
    (all > 0.0).then(|| (left / all).sqrt())
}

/// The answer for programs; an end that is nowhere is null.
pub(super) fn json(report: &Report<'_>) -> Value {
    let Report { study, found, file, .. } = report;
    let parameters = found.found.iter().map(|own| {
        json!({
            "name": own.unknown.name,
            "unit": own.unknown.unit,
            "start": own.unknown.start,
            "value": own.value,
            "low": own.interval[0],
            "high": own.interval[1],
            "profile_low": own.profile.map(|ends| ends[0]),
            "profile_high": own.profile.map(|ends| ends[1]),
            "profile_unknown": own.is_profile_unknown,
            "identified": own.open.is_none(),
            "reason": own.open,
        })
    });
    let models = found.models.iter().map(|model| {
        json!({
            "name": model.name,
            "unknowns": model.unknowns,
            "fitted_mm": model.fitted_mm,
            "predicted_mm": model.predicted_mm.as_ref().ok(),
        })
    });
    json!({
        "schema": 1,
        "converged": found.fit.is_found,
        "parameters": parameters.collect::<Vec<_>>(),
        "measured_mm": report.measured_mm(),
        "residual_mm": report.residual_mm(),
        "left_one_out_mm": report.left_out_mm(),
        "noise_estimated": study.noise.is_estimated,
        "scatter": found.fit.scale,
        "beyond_noise": found.fit.is_beyond_noise,
        "residual_share": report.left_share(),
        "unit_factor": found.unit_factor.as_ref().map(|own| json!({
            "factor": own.factor, "low": own.interval[0], "high": own.interval[1], "found_is_lower": own.is_lower,
            "unit": own.looks_like.0, "looks_like": own.looks_like.1,
        })),
        "machine_file": found.mixed.as_ref().map(|mixed| json!({
            "as_before": mixed.kept.iter().map(|&k| &*study.unknowns[k].name).collect::<Vec<_>>(),
            "residual_mm": mixed.residual_mm.as_ref().ok(),
        })),
        "patterns": found.patterns.iter().filter(|own| own.is_seen()).map(|own| json!({
            "of": own.of, "with": own.with, "rank_correlation": own.correlation, "hint": own.hint,
        })).collect::<Vec<_>>(),
        "far_off": found.far_off.iter().map(|own| json!({
            "pose": study.measurements[own.measurement].name, "reading": own.column, "by": own.by,
        })).collect::<Vec<_>>(),
        "models": models.collect::<Vec<_>>(),
        "next": found.advice.as_ref().map(|advice| json!({
            "pose": study.measurements[advice.measurement].name,
            "force_N": advice.force.as_slice(),
        })),
        "not_in_machine_file": file.left_out,
    })
}
