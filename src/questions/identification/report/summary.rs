//! JSON summary of an identification, and numbers that several of its reports share.

use serde_json::{Value, json};

use crate::questions::identification::{
    CauseKind, Estimate, IdentificationStudy, Identified, SetScore,
    validate::{residual_share, rms_mm},
    written_files::{self, MachineFile},
};

/// What reports are made of: study, results, and the files written from them.
pub(super) struct Report<'a> {
    pub study: &'a IdentificationStudy,
    pub results: &'a Identified,
    pub file: &'a MachineFile,
    /// Names of the parameters in the file of chain errors.
    pub errors: &'a [String],
}

impl Report<'_> {
    /// Returns the estimates of the identified parameters.
    pub fn identified(&self) -> impl Iterator<Item = &Estimate> {
        self.results.estimates.iter().filter(|estimate| estimate.open.is_none())
    }

    /// Returns the RMS residual over the RMS measured value, of lengths that the load changes; `None` without any.
    pub fn residual_share(&self) -> Option<f64> {
        residual_share(self.results.fit.residuals.as_slice(), &self.study.measurements, &[])
    }

    /// Returns [`residual_share`](Self::residual_share) without the outliers; `None` without other lengths that the load changes.
    pub fn inlier_residual_share(&self) -> Option<f64> {
        residual_share(self.results.fit.residuals.as_slice(), &self.study.measurements, &self.results.outliers)
    }

    /// Describes in a sentence the residual of the machine file if only some parameters were identified; `None` if no file is written.
    pub fn partial_text(&self) -> Option<String> {
        self.file.text.as_ref()?;
        written_files::partial_text(self.study, self.results)
    }

    /// Returns the root mean square of the measured lengths, mm; `None` without any.
    pub fn measured_mm(&self) -> Option<f64> {
        let readings = self.study.measurements.iter().flat_map(|measurement| &measurement.readings);
        let values: Vec<f64> = readings.map(|reading| reading.value).collect();
        rms_mm(&values, &self.study.measurements)
    }

    /// Returns the root mean square of the residuals of lengths, mm; `None` without any.
    pub fn residual_mm(&self) -> Option<f64> {
        rms_mm(self.results.fit.residuals.as_slice(), &self.study.measurements)
    }

    /// Returns the root mean square of the leave-one-out residuals of lengths, mm; `None` where one is predicted by no other.
    pub fn leave_one_out_mm(&self) -> Option<f64> {
        rms_mm(&self.results.leave_one_out, &self.study.measurements).filter(|rms| rms.is_finite())
    }

    /// Returns the other set of unknowns with the least error in cross-validation, if that is 2 % below that of the study's set.
    pub fn better_model(&self) -> Option<&SetScore> {
        let predicted = |model: &SetScore| model.predicted_mm.as_ref().ok().copied().flatten();
        let (of_study, others) = self.results.models.split_first()?;
        let best = others.iter().filter(|model| predicted(model).is_some()).min_by(|a, b| {
            let [a, b] = [a, b].map(|model| predicted(model).unwrap_or(f64::INFINITY));
            a.total_cmp(&b)
        })?;
        (predicted(best)? < 0.98 * predicted(of_study)?).then_some(best)
    }

    /// Returns a combination of unknowns as text, such as `+0.71 a -0.71 b`.
    pub fn combination_text(&self, parts: &[(usize, f64)]) -> String {
        let part = |(k, part): &(usize, f64)| format!("{part:+.2} {}", self.study.unknowns[*k].name);
        let words: Vec<String> = parts.iter().map(part).collect();
        words.join(" ")
    }
}

/// Returns the results as JSON; an infinite end of an interval is null.
pub(super) fn json(report: &Report<'_>) -> Value {
    let Report { study, results, file, .. } = report;
    let parameters = results.estimates.iter().map(|estimate| {
        json!({
            "name": estimate.unknown.name,
            "unit": estimate.unknown.unit,
            "start": estimate.unknown.start,
            "value": estimate.value,
            "low": estimate.interval[0],
            "high": estimate.interval[1],
            "profile_low": estimate.profile.map(|ends| ends[0]),
            "profile_high": estimate.profile.map(|ends| ends[1]),
            "profile_unknown": estimate.has_no_profile,
            "identified": estimate.open.is_none(),
            "reason": estimate.open,
        })
    });
    let models = results.models.iter().map(|model| {
        json!({
            "name": model.name,
            "unknowns": model.unknowns,
            "fitted_mm": model.fitted_mm,
            "predicted_mm": model.predicted_mm.as_ref().ok(),
        })
    });
    json!({
        "schema": 1,
        "converged": results.fit.is_converged,
        "parameters": parameters.collect::<Vec<_>>(),
        "measured_mm": report.measured_mm(),
        "residual_mm": report.residual_mm(),
        "left_one_out_mm": report.leave_one_out_mm(),
        "noise_estimated": study.noise.is_estimated,
        "scatter": results.fit.scale,
        "beyond_noise": results.fit.is_beyond_noise,
        "residual_share": report.residual_share(),
        "misfit": results.misfit.is_some(),
        "explained_by": results.cause.as_ref().map(|cause| {
            let (parameter, value, turn) = match &cause.kind {
                CauseKind::Zero { unknown, value, .. } => (Some(&unknown.name), Some(value), None),
                CauseKind::Turned(turn) => (None, None, Some(turn.map(f64::to_degrees).as_slice().to_vec())),
            };
            json!({
                "parameter": parameter, "value": value, "readings_turned_deg": turn, "residual_mm": cause.residual_mm,
                "residual_share": cause.share,
            })
        }),
        "unit_factor": results.unit_factor.as_ref().map(|common| json!({
            "factor": common.factor, "low": common.interval[0], "high": common.interval[1], "found_is_lower": common.is_lower,
            "unit": common.looks_like.0, "looks_like": common.looks_like.1,
        })),
        "machine_file": results.partial.as_ref().map(|partial| json!({
            "as_before": partial.unidentified.iter().map(|&k| &*study.unknowns[k].name).collect::<Vec<_>>(),
            "residual_mm": partial.residual_mm.as_ref().ok(),
        })),
        "patterns": results.patterns.iter().filter(|pattern| pattern.is_significant()).map(|pattern| json!({
            "of": pattern.of, "with": pattern.with, "rank_correlation": pattern.correlation, "hint": pattern.hint,
        })).collect::<Vec<_>>(),
        "far_off": results.outliers.iter().map(|outlier| json!({
            "pose": study.measurements[outlier.measurement].name, "reading": outlier.column, "by": outlier.by,
        })).collect::<Vec<_>>(),
        "models": models.collect::<Vec<_>>(),
        "next": results.advice.as_ref().map(|advice| json!({
            "pose": study.measurements[advice.measurement].name,
            "force_N": advice.force.as_slice(),
        })),
        "not_in_machine_file": file.left_out,
    })
}
