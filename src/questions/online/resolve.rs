//! Checks an online study as written and makes a study of it.

use std::sync::Arc;

use super::{OnlineStudy, Sensor, spec::OnlineSpec};
use crate::{
    input::{Inputs, check::Check, error::Result},
    process::uncertainty::Draws,
    questions::{
        Question, Resolved, StudyContext, Template,
        path::{resolve::path, spec::PathSpec},
    },
    simulation::within_limits,
    work::Work,
};

/// Most trials: seeds times force errors.
const MAX_TRIALS: usize = 100_000;
/// Fewest seeds where each is a draw: with fewer, probabilities say next to nothing.
const FEWEST_DRAWS: usize = 16;
/// Most cycles of the controller along the path.
const MAX_CYCLES: f64 = 1e8;
/// Force errors if the study gives none.
const FORCE_ERRORS_PERCENT: [f64; 7] = [0.0, 2.0, 5.0, 10.0, 20.0, 30.0, 50.0];

impl Question for OnlineStudy {
    type Spec = OnlineSpec;
    type Shown = ();
    const NAME: &str = "an online study";
    const TEMPLATE: Template = Template {
        name: "online",
        about: "Whether to correct in the controller, by measured forces, or beforehand, by predicted ones",
        files: &[
            ("study.toml", include_str!("template/study.toml")),
            ("process.toml", include_str!("../path/template/process.toml")),
        ],
    };
    const TABLES: &[&str] = &["trials", "bands"];

    /// Checks the study, and reads its path and process.
    fn resolve(spec: &OnlineSpec, context: &StudyContext<'_>) -> Result<Resolved<Self>> {
        context.overrides.refuse_grid(context.name)?;
        let check = &context.check;
        let process = context.process(None, check)?;
        let limits_check = context.process_location(None).key("limits");
        within_limits::check_limits(&process.machine, &process.limits)
            .or_else(|problem| limits_check.misfit(problem, ()))?;
        if process.limits.force_N.is_some() {
            return limits_check.key("force_limit_N").fail(format!("is not assessed by {}", context.name));
        }
        let path_spec = PathSpec {
            circle: spec.circle.clone(),
            line: spec.line.clone(),
            file: spec.file.clone(),
            methods: Some(Vec::new()),
        };
        let (mut path, toolpath, program) = path(&path_spec, &process, context, check)?;
        let tools = toolpath.cutting_tools();
        let (table, cut) = (process.uncertainty.as_ref(), process.cut_by(&tools));
        let (uncertainty, read) = context.uncertainty(table, &path.machine, &path.errors, &cut)?;
        if let Some(force) = uncertainty.as_ref().map(|own| own.force).filter(|force| !force.is_exact()) {
            let key = match force.sharp {
                Some(_) => "force_relative_std",
                None if force.has_components() => "force_component_relative_std",
                None => "wear_force_increase",
            };
            return context
                .uncertainty_location()
                .key("process")
                .key(key)
                .fail("is given by force_errors_percent in an online study: expected none".into());
        }
        path.tracked.uncertainty = uncertainty.map(Arc::new);
        let feed_mm_per_min = check.key("feed_mm_per_min").positive(spec.feed)?;
        let times_s: Vec<f64> = path.stations.iter().map(|at| at.arc_length_mm * 60.0 / feed_mm_per_min).collect();
        let sensor = sensor(spec, check)?;
        let cycles = times_s.last().map_or(0.0, |last| sensor.cycles(*last));
        if cycles > MAX_CYCLES {
            let problem = format!("the path takes {cycles:.0} cycles: expected at most {MAX_CYCLES:.0}");
            return check.key("cycle_ms").fail(problem);
        }
        let known_share = spec.known_chain_errors_percent.unwrap_or(100.0);
        let known_share = share(known_share, 0.0, 200.0, &check.key("known_chain_errors_percent"))?;
        let (force_errors, seeds) = trials(spec, path.uncertainty.is_some(), check)?;
        let stiffness = check.key("cutting_stiffness_N_per_mm").optional_positive(spec.cutting_stiffness)?;
        let inputs = process
            .inputs
            .and(program)
            .and(read)
            .and(Inputs::of("points of the path", path.stations.len().to_string()));
        let study = OnlineStudy {
            times_s,
            feed_mm_per_min,
            sensor,
            softness: share(
                spec.model_compliance_error_percent,
                -90.0,
                900.0,
                &check.key("model_compliance_error_percent"),
            )?,
            known_errors: path.errors.iter().map(|error| error.scale(known_share)).collect(),
            known_share,
            force_errors,
            seeds,
            limits: process.limits,
            cutting_stiffness: stiffness,
            path,
        };
        Ok(Resolved { study, shown: (), inputs })
    }

    /// Returns the number of trials, and one for the path without correction.
    fn items(&self) -> (usize, &'static str) {
        (1 + self.force_errors.len() * self.seeds, "trials")
    }

    /// Returns the number of trials, and one for the path without correction.
    fn pieces(&self) -> usize {
        1 + self.force_errors.len() * self.seeds
    }

    /// Computes all trials and keeps them in `work`.
    fn compute(&self, work: &Work) -> Result<()> {
        super::run(self, work).map(drop)
    }
}

/// Returns the force sensor of the study, checked: times positive or zero, in s; noise and bias not negative, N.
fn sensor(spec: &OnlineSpec, check: &Check) -> Result<Sensor> {
    Ok(Sensor {
        cycle_s: check.key("cycle_ms").positive(spec.cycle_ms.unwrap_or(1.0))? / 1000.0,
        delay_s: check.key("delay_ms").not_negative(spec.delay_ms)? / 1000.0,
        low_pass_Hz: check.key("low_pass_Hz").optional_positive(spec.low_pass)?,
        noise_N: check.key("noise_N").not_negative(spec.noise)?,
        bias_N: check.key("bias_N").not_negative(spec.bias)?,
    })
}

/// Returns the force errors as shares, ascending, and the number of seeds, each a draw where inputs are `uncertain`. `Err` if they are out of range or
/// give too many trials.
fn trials(spec: &OnlineSpec, uncertain: bool, check: &Check) -> Result<(Vec<f64>, usize)> {
    let errors_check = check.key("force_errors_percent");
    let percents = spec.force_errors_percent.as_deref().unwrap_or(&FORCE_ERRORS_PERCENT);
    let errors =
        percents.iter().map(|percent| share(*percent, 0.0, 100.0, &errors_check)).collect::<Result<Vec<f64>>>()?;
    if errors.is_empty() || errors.windows(2).any(|pair| pair[0] >= pair[1]) {
        return errors_check.fail("must be at least one, ascending".into());
    }
    let (usual, [least, draws]) = match uncertain {
        true => (Draws::PER_SCRAMBLE, [FEWEST_DRAWS, Draws::COUNT]),
        false => (20, [1, MAX_TRIALS]),
    };
    let (seeds, most) = (spec.seeds.unwrap_or(usual), draws.min(MAX_TRIALS / errors.len()));
    if seeds < least || seeds > most {
        let of_draws = if uncertain { " with [uncertainty], where each is a machine of its own" } else { "" };
        let problem = format!("must be from {least} to {most}{of_draws}, got {seeds}");
        return check.key("seeds").fail(problem);
    }
    Ok((errors, seeds))
}

/// Returns `percent` as a share; `Err` if it is not from `least` to `most`.
fn share(percent: f64, least: f64, most: f64, check: &Check) -> Result<f64> {
    match (least..=most).contains(&percent) {
        true => Ok(percent / 100.0),
        false => check.fail(format!("must be from {least} to {most}, got {percent:?}")),
    }
}
