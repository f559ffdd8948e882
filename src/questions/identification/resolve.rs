//! Checks an identification as written and makes a study of it.

use super::{
    IdentificationStudy,
    fit::Noise,
    measurements::{self, Measurement, Reading, RowUse},
    spec::{IdentificationSpec, PriorSpec},
    unknown::{Unknown, unknowns},
};
use crate::{
    input::{Inputs, check::Check, error::Result},
    machine::catalogue,
    questions::{Question, Resolved, StudyContext, Template},
};

/// Number of folds in cross-validation if the study gives none.
const FOLDS: usize = 5;
/// Most unknowns for which profiles are computed unless the study asks for them: each takes some fits of all others.
const PROFILED: usize = 20;

impl Question for IdentificationStudy {
    type Spec = IdentificationSpec;
    type Shown = ();
    const NAME: &str = "an identification";
    const TEMPLATE: Template = Template {
        name: "identification",
        about: "Which stiffnesses and other parameters a machine has, by measurements under load",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("measurements.csv", include_str!("template/measurements.csv")),
        ],
    };
    const TABLES: &[&str] = &["parameters", "residuals", "models", "open"];

    /// Checks the study and reads its measurements.
    fn resolve(spec: &IdentificationSpec, context: &StudyContext<'_>) -> Result<Resolved<Self>> {
        context.overrides.refuse_beside_measurements(context.name)?;
        let (check, machine) = (&context.check, &context.machine);
        context.refuse_carrier("measurements at the tool cannot identify")?;
        let (measured, inputs) = rows(context, &spec.data, "data", RowUse::Readings)?;
        let found = unknowns(machine, &spec.unknowns, &check.key("unknowns"))?;
        let priors = priors(&spec.prior, &found, &check.key("prior"))?;
        let alternatives = alternatives(spec, context)?;
        if measured.iter().all(|row| row.load == row.reference && row.readings.iter().all(Reading::is_change)) {
            let problem = format!(
                "{}: no measurement has a load other than its reference load, so that nothing moved",
                context.folder.path(&spec.data).display()
            );
            return check.key("data").fail(problem);
        }
        let noise = noise(spec, &measured, check)?;
        let readings: usize = measured.iter().map(|measurement| measurement.readings.len()).sum();
        let poses = measured.iter().map(|row| row.pose + 1).max().unwrap_or(0);
        let folds = spec.folds.unwrap_or(FOLDS.min(poses));
        if spec.folds.is_some() && !(2..=poses).contains(&folds) {
            let problem = match poses {
                1 => "has no effect: there is one pose, which no other predicts".into(),
                _ => format!("must be from 2 to {poses}, the number of poses, got {folds}"),
            };
            return check.key("folds").fail(problem);
        }
        if noise.is_estimated && readings + spec.prior.len() <= found.len() {
            let problem = format!(
                "names {} parameters, but there are {readings} readings: with no std_mm there must be more readings than unknowns",
                found.len()
            );
            return check.key("unknowns").fail(problem);
        }
        let machine_text = match catalogue::find(&context.header.machine) {
            Some(entry) => entry.toml.to_string(),
            None => context.folder.text(&context.header.machine)?,
        };
        let study = IdentificationStudy {
            machine: machine.clone(),
            machine_text,
            data: spec.data.clone(),
            priors,
            profile: spec.profile.unwrap_or(found.len() <= PROFILED),
            alternatives,
            unknowns: found,
            measurements: measured,
            noise,
            loss: spec.loss,
            folds,
        };
        Ok(Resolved { study, shown: (), inputs })
    }

    /// Returns the number of measurements.
    fn items(&self) -> (usize, &'static str) {
        (self.measurements.len(), "measurements")
    }
}

/// Reads the measurement rows of `file` in the study's folder, named by `key`; `Err` if it is missing or has a fault.
pub fn rows(context: &StudyContext<'_>, file: &str, key: &str, purpose: RowUse) -> Result<(Vec<Measurement>, Inputs)> {
    let path = context.folder.path(file).display().to_string();
    if !context.folder.has_file(file) {
        let problem = format!("\"{file}\" is not a file in the study's folder: there is no {path}");
        return context.check.key(key).fail(problem);
    }
    let bytes = context.folder.bytes(file)?;
    let rows = context.check.or_misfit(measurements::read(&bytes, &path, &context.machine, purpose), Vec::new())?;
    Ok((rows, Inputs::of(file, String::from_utf8_lossy(&bytes).into_owned())))
}

/// Returns the noise of the readings. `Err` unless lengths all have a standard deviation or all are estimated, and rotations all have one.
fn noise(spec: &IdentificationSpec, measured: &[Measurement], check: &Check) -> Result<Noise> {
    for (key, std) in [("std_mm", spec.std_mm), ("std_deg", spec.std_deg)] {
        std.map(|std| measurements::checked_std(std, &check.key(key))).transpose()?;
    }
    let (length, rotation) = (spec.std_mm, spec.std_deg.map(f64::to_radians));
    let readings = || measured.iter().flat_map(|measurement| &measurement.readings);
    let lacks = |is_rotation: bool| {
        readings().any(|reading| reading.quantity.is_rotation() == is_rotation && reading.std.is_none())
    };
    let has_std = readings().any(|reading| reading.std.is_some());
    let has_rotations = readings().any(|reading| reading.quantity.is_rotation());
    let is_estimated = lacks(false) && length.is_none();
    if is_estimated && (has_rotations || has_std || rotation.is_some()) {
        let because = match (has_rotations, has_std) {
            (true, _) => "rotations were measured",
            (_, true) => "other readings have one",
            _ => "std_deg is given",
        };
        return check
            .key("std_mm")
            .fail(format!("missing: {because}, so that lengths need theirs to weigh against them"));
    }
    if lacks(true) && rotation.is_none() {
        return check.key("std_deg").fail("missing: rotations were measured, and their standard deviation is not known; give it here or in a column std_deg".into());
    }
    Ok(Noise { length, rotation, is_estimated })
}

/// Smallest standard deviation of a prior, in the coordinate of its unknown.
const TIGHTEST: f64 = 1e-6;

/// Returns the priors of `unknowns`, checked: index, coordinate and its standard deviation; `Err` if unknown, named twice or out of range.
pub fn priors(specs: &[PriorSpec], unknowns: &[Unknown], check: &Check) -> Result<Vec<(usize, f64, f64)>> {
    let mut priors: Vec<(usize, f64, f64)> = Vec::new();
    for (i, PriorSpec { parameter, value, std }) in specs.iter().enumerate() {
        let check = check.item(i);
        let Some(k) = unknowns.iter().position(|unknown| unknown.name == *parameter) else {
            check.key("parameter").misfit(format!("\"{parameter}\" is none of the unknowns"), ())?;
            continue;
        };
        if priors.iter().any(|(other, ..)| *other == k) {
            return check.key("parameter").fail(format!("\"{parameter}\" has a prior already"));
        }
        let std = check.key("std").positive(*std)?;
        let value = check.key("value").finite_scalar(value.unwrap_or(unknowns[k].start))?;
        let Some(x) = unknowns[k].coordinate_at(value) else {
            return check.key("value").fail(format!("must be greater than 0, got {value}"));
        };
        let tightest = TIGHTEST * unknowns[k].slope(x).abs();
        if std < tightest {
            let problem =
                format!("must be at least {tightest:?}, got {std:?}; leave out of unknowns what is known so well");
            return check.key("std").fail(problem);
        }
        priors.push((k, x, std / unknowns[k].slope(x).abs()));
    }
    Ok(priors)
}

/// Returns the other sets of unknowns with their names, checked.
fn alternatives(spec: &IdentificationSpec, context: &StudyContext<'_>) -> Result<Vec<(String, Vec<Unknown>)>> {
    let mut all: Vec<(String, Vec<Unknown>)> = Vec::new();
    for (i, other) in spec.alternative.iter().enumerate() {
        let check = context.check.key("alternative").item(i);
        check.key("name").readable(&other.name)?;
        check.key("name").unique(&other.name, all.iter().map(|(name, _)| name.as_str()))?;
        all.push((other.name.clone(), unknowns(&context.machine, &other.unknowns, &check.key("unknowns"))?));
    }
    Ok(all)
}
