//! Checks a design of measurements as written and makes a study of it.

use super::{
    MeasurementDesignStudy,
    candidates::{Region, plan_measurements, poses},
    spec::{CandidateSpec, CriterionSpec, MeasurementDesignSpec},
};
use crate::{
    input::{Inputs, check::Check, error::Result},
    machine::{Branch, Machine},
    questions::{
        Question, Resolved, StudyContext, Template,
        identification::{Measurement, Noise, Reading, RowUse, priors, rows, unknowns},
    },
};

/// Number of random choices if the study gives none.
const DRAWS: usize = 200;
const MAX_DRAWS: usize = 10_000;
const MAX_POSES: usize = 100_000;
const MAX_CANDIDATES: usize = 200_000;
const MAX_CHOSEN: usize = 1000;

impl Question for MeasurementDesignStudy {
    type Spec = MeasurementDesignSpec;
    type Shown = ();
    const NAME: &str = "a plan of measurements";
    const TEMPLATE: Template = Template {
        name: "measurements",
        about: "Which poses and loads to measure next, and how well parameters will be known then",
        files: &[("study.toml", include_str!("template/study.toml"))],
    };
    const TABLES: &[&str] = &["chosen", "widths", "candidates"];

    /// Checks the study, and reads or generates its candidates.
    fn resolve(spec: &MeasurementDesignSpec, context: &StudyContext<'_>) -> Result<Resolved<Self>> {
        context.overrides.refuse_beside_measurements(context.name)?;
        let (check, machine) = (&context.check, &context.machine);
        let unknowns = unknowns(machine, &spec.unknowns, &check.key("unknowns"))?;
        let priors = priors(&spec.prior, &unknowns, &check.key("prior"))?;
        let noise = Noise {
            length: Some(check.key("std_mm").positive(spec.std_mm)?),
            rotation: check.key("std_deg").optional_positive(spec.std_deg)?.map(f64::to_radians),
            is_estimated: false,
        };
        let readings = readings(spec, noise, check)?;
        let mut files = InputFiles { context, inputs: Inputs::default() };
        let candidates = candidates(spec, machine, &readings, &mut files)?;
        let measured = files.read_rows(spec.measured.as_ref(), "measured", RowUse::Readings)?.unwrap_or_default();
        let has_no_std = |row: &Measurement| {
            row.readings.iter().any(|reading| reading.quantity.is_rotation() && reading.std.is_none())
        };
        if noise.rotation.is_none() && measured.iter().any(has_no_std) {
            return check.key("std_deg").fail("missing: rotations were measured, and their standard deviation is not known; give it here or in a column std_deg".into());
        }
        let tested = match (spec.criterion, &spec.tested) {
            (CriterionSpec::AllNumbers, Some(_)) => {
                return check.key("tested").fail("has no effect: expected criterion = \"tested\" beside it".into());
            }
            (CriterionSpec::Tested, None) => {
                return check
                    .key("tested")
                    .fail("missing: expected a file of poses and loads whose prediction counts".into());
            }
            (_, file) => files.read_rows(file.as_ref(), "tested", RowUse::Poses)?.unwrap_or_default(),
        };
        if spec.tested.is_some() && tested.iter().all(|row| row.load == row.reference) {
            let problem = "no row has a load other than its reference load, so that there is nothing to predict".into();
            return check.key("tested").fail(problem);
        }
        let displacements = Reading::planned_displacements();
        let tested = tested.into_iter().map(|row| Measurement { readings: displacements.clone(), ..row }).collect();
        let check_count = check.key("count");
        if !(1..=MAX_CHOSEN.min(candidates.len())).contains(&spec.count) {
            let max_count = MAX_CHOSEN.min(candidates.len());
            return check_count.fail(format!(
                "must be from 1 to {max_count} ({} candidates, at most {MAX_CHOSEN} chosen), got {}",
                candidates.len(),
                spec.count
            ));
        }
        let draws = spec.draws.unwrap_or(DRAWS);
        if draws > MAX_DRAWS {
            return check.key("draws").fail(format!("must be at most {MAX_DRAWS}, got {draws}"));
        }
        let study = MeasurementDesignStudy {
            machine: machine.clone(),
            priors,
            unknowns,
            measured,
            candidates,
            tested,
            noise,
            criterion: spec.criterion,
            count: spec.count,
            target: check.key("target").optional_positive(spec.target)?,
            draws,
        };
        Ok(Resolved { study, shown: (), inputs: files.inputs })
    }

    /// Returns the number of candidate measurements.
    fn items(&self) -> (usize, &'static str) {
        (self.candidates.len(), "candidates")
    }
}

/// Reads the files that a study names, and collects them as its inputs.
struct InputFiles<'a> {
    context: &'a StudyContext<'a>,
    inputs: Inputs,
}

impl InputFiles<'_> {
    /// Reads the rows of `file`, which the study names by `key`, for this purpose; `None` if it names none.
    fn read_rows(&mut self, file: Option<&String>, key: &str, purpose: RowUse) -> Result<Option<Vec<Measurement>>> {
        let Some(file) = file else { return Ok(None) };
        let (rows, inputs) = rows(self.context, file, key, purpose)?;
        self.inputs = std::mem::take(&mut self.inputs).and(inputs);
        Ok(Some(rows))
    }
}

/// Returns the readings planned at each candidate, checked; displacements of the tool tip if the study names none.
fn readings(spec: &MeasurementDesignSpec, noise: Noise, check: &Check) -> Result<Vec<Reading>> {
    let check = check.key("reads");
    let plannable = Reading::all_planned();
    let names = || plannable.iter().map(|reading| reading.column).collect::<Vec<_>>().join(", ");
    let Some(columns) = &spec.reads else {
        return Ok(Reading::planned_displacements());
    };
    let mut readings: Vec<Reading> = Vec::new();
    for (i, column) in columns.iter().enumerate() {
        let check = check.item(i);
        let Some(reading) = plannable.iter().find(|reading| reading.column == column) else {
            return check.fail(format!("must be any of {}, got \"{column}\"", names()));
        };
        if readings.iter().any(|other| other.column == column) {
            return check.fail(format!("\"{column}\" is named twice"));
        }
        if reading.quantity.is_rotation() && noise.rotation.is_none() {
            return check.root().key("std_deg").fail(format!("missing: {column} is to be read"));
        }
        readings.push(reading.clone());
    }
    if readings.is_empty() {
        return check.fail(format!("must name at least one of {}", names()));
    }
    Ok(readings)
}

/// Returns the candidates: rows of a file, or poses spread over a region.
fn candidates(
    spec: &MeasurementDesignSpec,
    machine: &Machine,
    readings: &[Reading],
    files: &mut InputFiles<'_>,
) -> Result<Vec<Measurement>> {
    let check = files.context.check.clone();
    match (&spec.candidates, &spec.candidate) {
        (Some(_), None) => {
            let rows = files.read_rows(spec.candidates.as_ref(), "candidates", RowUse::Poses)?.unwrap_or_default();
            Ok(rows.into_iter().map(|row| Measurement { readings: readings.to_vec(), ..row }).collect())
        }
        (None, Some(spec)) => generate(spec, machine, readings, &check.key("candidate")),
        _ => check.key("candidates").fail("give either a file of candidates, or [measurement_design.candidate]".into()),
    }
}

/// Returns candidates at poses spread over a region, each under each force.
fn generate(spec: &CandidateSpec, machine: &Machine, readings: &[Reading], check: &Check) -> Result<Vec<Measurement>> {
    if !(1..=MAX_POSES).contains(&spec.poses) {
        return check.key("poses").fail(format!("must be from 1 to {MAX_POSES}, got {}", spec.poses));
    }
    let mut forces = Vec::with_capacity(spec.forces.len());
    for (i, force) in spec.forces.iter().enumerate() {
        forces.push(check.key("forces_N").item(i).finite(*force)?);
    }
    if forces.is_empty() {
        return check.key("forces_N").fail("must have at least one force, got none".into());
    }
    if spec.poses * forces.len() > MAX_CANDIDATES {
        let problem = format!(
            "{} poses under {} forces are {} candidates: expected at most {MAX_CANDIDATES}",
            spec.poses,
            forces.len(),
            spec.poses * forces.len()
        );
        return check.key("forces_N").fail(problem);
    }
    let tip = match (spec.min_mm, spec.max_mm) {
        (Some(min), Some(max)) => Some(check.corners(min, max)?),
        (None, None) => None,
        (Some(_), None) => return check.missing("max_mm"),
        (None, Some(_)) => return check.missing("min_mm"),
    };
    let mut forbidden = Vec::new();
    for (i, forbidden_box) in spec.forbidden.iter().enumerate() {
        let check = check.key("forbidden").item(i);
        check.key("name").readable(&forbidden_box.name)?;
        forbidden.push(check.corners(forbidden_box.min_mm, forbidden_box.max_mm)?);
    }
    let region = Region { tip, forbidden, branches: branches(spec, machine, check)? };
    let reached = poses(machine, &region, spec.poses);
    if reached.len() < spec.poses {
        let problem = format!(
            "{} of {} poses were found that the machine reaches, in the box, outside forbidden ones{}: expected a larger region, \
             or fewer poses",
            reached.len(),
            spec.poses,
            if region.branches.is_empty() { "" } else { ", on these branches" }
        );
        check.key("poses").misfit(problem, ())?;
    }
    Ok(plan_measurements(&reached, &forces, readings))
}

/// Returns the allowed branches of inverse kinematics, or none for any. `Err` if one is misspelt or the machine has none.
fn branches(spec: &CandidateSpec, machine: &Machine, check: &Check) -> Result<Vec<Branch>> {
    let check = check.key("branches");
    let mut branches = Vec::new();
    for (i, word) in spec.branches.iter().enumerate() {
        match word.parse::<Branch>() {
            Ok(branch) => branches.push(branch),
            Err(problem) => return check.item(i).fail(problem.to_string()),
        }
    }
    if !branches.is_empty() && machine.branch_of(&machine.home).is_none() {
        let problem = format!("machine {} has no branches: it is no arm with a spherical wrist", machine.name);
        return check.misfit(problem, Vec::new());
    }
    Ok(branches)
}
