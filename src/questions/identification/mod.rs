//! Identification: fits parameters of a machine (stiffnesses, backlash, geometry) to measurements under load, with confidence intervals,
//! the parameters that are not identifiable, and how well the fitted machine predicts.

mod advice;
mod cause;
mod fit;
mod measurements;
mod model;
mod patterns;
mod prediction;
mod profile;
#[cfg(feature = "report")]
pub mod report;
mod resolve;
mod scatter;
pub(crate) mod spec;
mod unit_factor;
mod unknown;
mod validate;
#[cfg(feature = "report")]
mod written_files;

use nalgebra::DVector;

pub use advice::{Advice, OpenCombination};
pub use cause::{Cause, CauseKind};
use fit::measured_values;
pub use fit::{Fit, Noise, Search};
pub use measurements::{AppliedLoad, Measurement, Quantity, Reading, RowUse, read};
use model::predict_values;
pub use model::{LoadedModel, Predicted};
pub use patterns::{Pattern, rank_correlation, ranks};
pub use prediction::{Prediction, predict, predict_as_is};
pub(crate) use resolve::{priors, rows};
pub use scatter::{half_width, mean_square_limit};
pub use spec::LossSpec;
pub use unit_factor::UnitFactor;
pub(crate) use unknown::unknowns;
pub use unknown::{Coordinate, Unknown};
pub use validate::Outlier;

use self::profile::{IntervalEnd, Profile};
use crate::{
    input::error::Result,
    machine::Machine,
    simulation::Failure,
    work::{Event, Work},
};

/// A checked identification: a machine, measurements on it under load, and the parameters to fit to them.
#[derive(Debug, Clone)]
pub struct IdentificationStudy {
    /// Machine whose parameters are the start of the fit.
    pub machine: Machine,
    /// Text of the machine file.
    pub machine_text: String,
    /// Name of the measurement file.
    pub data: String,
    /// Rows of that file: pose, load and readings.
    pub measurements: Vec<Measurement>,
    /// Parameters to identify.
    pub unknowns: Vec<Unknown>,
    /// Gaussian priors: index of the unknown, expected coordinate, standard deviation of that coordinate.
    pub priors: Vec<(usize, f64, f64)>,
    /// Noise of readings that have none of their own.
    pub noise: Noise,
    /// Loss function, which says how much outliers count.
    pub loss: LossSpec,
    /// Number of folds in cross-validation.
    pub folds: usize,
    /// Whether intervals are computed from the profile likelihood as well.
    pub profile: bool,
    /// Other sets of unknowns to compare with, by name.
    pub alternatives: Vec<(String, Vec<Unknown>)>,
}

/// Estimate of one parameter: value, 95 % interval, and whether the measurements identify it.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The parameter that was fitted.
    pub unknown: Unknown,
    /// Value of the best fit, in the unit of the parameter.
    pub value: f64,
    /// Ends of the 95 % interval by linearisation, in the unit of the parameter; infinite where nothing limits it.
    pub interval: [f64; 2],
    /// Ends of the 95 % interval by the profile likelihood, infinite where nothing limits it; `None` without.
    pub profile: Option<[f64; 2]>,
    /// Whether the profile likelihood was computed but the interval not found, as the other unknowns could not be refitted.
    pub has_no_profile: bool,
    /// Half the 95 % interval in the coordinate of the unknown: 1 is a factor of e, a millimetre or a degree.
    pub half_width: f64,
    /// Why the parameter is not identified; `None` if it is.
    pub open: Option<String>,
    /// Index of the unknown that it correlates with most, and that correlation.
    pub correlated: Option<(usize, f64)>,
}

/// Score of a set of unknowns: how well it fits and how well it predicts, to compare it with other sets.
#[derive(Debug, Clone, PartialEq)]
pub struct SetScore {
    /// Name of the set.
    pub name: String,
    /// Number of unknowns in it.
    pub unknowns: usize,
    /// RMS residual of the lengths that it was fitted to, mm.
    pub fitted_mm: Option<f64>,
    /// RMS error in cross-validation of lengths, mm: each predicted by a fit to the other folds; or why there is none.
    pub predicted_mm: std::result::Result<Option<f64>, Failure>,
}

/// The machine in which only the identified parameters have their fitted values, all others those of the machine file.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialMachine {
    /// Indices of the unknowns that are not identified and so keep their values.
    pub unidentified: Vec<usize>,
    /// RMS residual of lengths of this machine, mm; or why it is not known.
    pub residual_mm: std::result::Result<Option<f64>, Failure>,
}

/// Results of an identification.
#[derive(Debug, Clone)]
pub struct Identified {
    /// Least-squares or robust fit to all measurements.
    pub fit: Fit,
    /// Estimate of each unknown, in the order of the study.
    pub estimates: Vec<Estimate>,
    /// Combinations of unknowns that the measurements do not identify.
    pub open: Vec<OpenCombination>,
    /// Further measurement that would identify them best, if there are any and a force on the tool tip can.
    pub advice: Option<Advice>,
    /// Leave-one-out residual of each reading, mm or rad: predicted without its own measurement, linearised.
    pub leave_one_out: Vec<f64>,
    /// Rank correlations of the residuals with order, load, direction and pose.
    pub patterns: Vec<Pattern>,
    /// Readings that are outliers, the farthest first.
    pub outliers: Vec<Outlier>,
    /// The machine with the identified parameters alone; `None` where all or none are identified.
    pub partial: Option<PartialMachine>,
    /// Residual over what was measured, without outliers, where it is too large or has a cause, and no noise is given that would explain it: nothing is identified.
    pub misfit: Option<f64>,
    /// What would explain most of a large residual, if something that is tried does.
    pub cause: Option<Cause>,
    /// Common factor of all stiffnesses, if it looks like a mistaken unit.
    pub unit_factor: Option<UnitFactor>,
    /// Scores of sets of unknowns, that of the study first.
    pub models: Vec<SetScore>,
}

/// Half width of an interval, in coordinates, above which an unknown is not identified: a factor of e either way, a millimetre, a degree.
const WIDE: f64 = 1.0;
/// The same of a length or angle that is sure to be another than in the machine file: as a share of its change, and at most.
const WIDE_CHANGED: [f64; 2] = [0.5, 10.0];
/// Share of what was measured above which a residual is noise only if noise is given that explains it.
const MAX_LEFT: f64 = 1.0 / 3.0;
/// Share of what was measured from which the model lacks something, or the readings scatter.
const NOTEWORTHY: f64 = 0.1;

/// Returns the half width of an interval about coordinate `x` above which `unknown` is not identified. Numbers that are wide each by itself, such
/// as a tool's length beside the place of the base, may be known together: with the old value of one of them the others are wrong.
fn widest(unknown: &Unknown, x: f64) -> f64 {
    let [share, most] = WIDE_CHANGED;
    match unknown.coordinate {
        Coordinate::Logarithm => WIDE,
        Coordinate::Linear(_) => (share * x.abs()).clamp(WIDE, most),
    }
}

impl IdentificationStudy {
    /// Returns "pose NAME (FILE:LINE)" for the measurement with this index, for messages.
    pub fn measurement_text(&self, measurement: usize) -> String {
        let row = &self.measurements[measurement];
        format!("pose {} ({}:{})", row.name, self.data, row.line)
    }

    /// Returns the number of readings of all measurements.
    pub fn reading_count(&self) -> usize {
        self.measurements.iter().map(|measurement| measurement.readings.len()).sum()
    }

    /// Returns the fitting problem for these unknowns and priors.
    fn fitting_problem<'a>(
        &'a self,
        unknowns: &'a [Unknown],
        priors: &'a [(usize, f64, f64)],
        work: &'a Work,
    ) -> Search<'a> {
        Search { machine: &self.machine, unknowns, priors, noise: self.noise, loss: self.loss, work }
    }
}

/// Fits the unknowns, computes intervals and checks the model, on the current rayon pool; results do not depend on the number of threads.
/// `Err` if the work was stopped; the inner `Err` says at which measurement the machine has no equilibrium, and why.
pub fn run(study: &IdentificationStudy, work: &Work) -> Result<std::result::Result<Identified, Failure>> {
    work.check()?;
    let search = study.fitting_problem(&study.unknowns, &study.priors, work);
    let measurements: Vec<&Measurement> = study.measurements.iter().collect();
    let start = DVector::zeros(study.unknowns.len());
    let fit = match search.fit(&measurements, &start) {
        Ok(fit) => fit,
        Err((at, failure)) => return Ok(Err(failure_at(study, at, failure))),
    };
    work.check()?;
    work.tell(Event::Computed(study.measurements.len()));
    let outliers = validate::outliers(&fit, &study.measurements);
    let share = validate::residual_share(fit.residuals.as_slice(), &study.measurements, &outliers);
    let is_large = fit.is_beyond_noise || share.is_some_and(|share| share > NOTEWORTHY);
    let cause = if is_large { cause::find(study, &fit, work)? } else { None };
    // What has a cause is no noise.
    let misfit = share.filter(|share| study.noise.is_estimated && (*share > MAX_LEFT || cause.is_some()));
    let open = advice::open_combinations(&fit);
    let advice = match open.is_empty() {
        true => None,
        false => advice::advise(&search, &fit, &study.measurements, work)?,
    };
    let mut models = vec![score_model(study, "the study", &search, Some(&fit), work)?];
    for (name, unknowns) in &study.alternatives {
        models.push(score_model(study, name, &study.fitting_problem(unknowns, &[], work), None, work)?);
    }
    let mut estimates: Vec<Estimate> = (0..study.unknowns.len()).map(|k| estimate(study, &fit, misfit, k)).collect();
    work.check()?;
    add_profile_intervals(study, &search, &fit, &measurements, &mut estimates, work)?;
    let partial = partial_machine(study, &search, &fit, &measurements, &estimates);
    let unit_factor = unit_factor::unit_factor(study, &fit);
    let leave_one_out = validate::leave_one_out(&fit, &study.measurements);
    let patterns = patterns::patterns(&study.machine, &fit, &study.measurements);
    work.check()?;
    let found = Identified {
        estimates,
        open,
        advice,
        leave_one_out,
        patterns,
        outliers,
        models,
        partial,
        misfit,
        cause,
        unit_factor,
        fit,
    };
    Ok(Ok(found))
}

/// Returns the residual of the machine in which only the identified parameters have fitted values; `None` where all or none are identified.
fn partial_machine(
    study: &IdentificationStudy,
    search: &Search<'_>,
    fit: &Fit,
    measurements: &[&Measurement],
    estimates: &[Estimate],
) -> Option<PartialMachine> {
    let unidentified: Vec<usize> = (0..estimates.len()).filter(|&k| estimates[k].open.is_some()).collect();
    if unidentified.is_empty() || unidentified.len() == estimates.len() {
        return None;
    }
    let x = DVector::from_fn(estimates.len(), |k, _| if unidentified.contains(&k) { 0.0 } else { fit.x[k] });
    let read = predict_values(search.machine, search.unknowns, &x, measurements);
    let residual_mm = match read {
        Ok(read) => Ok(validate::rms_mm((measured_values(measurements) - read).as_slice(), &study.measurements)),
        Err((at, failure)) => Err(failure_at(study, at, failure)),
    };
    Some(PartialMachine { unidentified, residual_mm })
}

/// Adds profile-likelihood intervals to the identified parameters; one whose interval is too wide becomes not identified.
fn add_profile_intervals(
    study: &IdentificationStudy,
    search: &Search<'_>,
    fit: &Fit,
    measurements: &[&Measurement],
    estimates: &mut [Estimate],
    work: &Work,
) -> Result<()> {
    let quantile = scatter::half_width(degrees_of_freedom(study, fit));
    let profile = if study.profile { Profile::new(*search, fit, measurements, quantile) } else { None };
    let Some(profile) = profile else { return Ok(()) };
    let identified: Vec<usize> = (0..estimates.len()).filter(|&k| estimates[k].open.is_none()).collect();
    for (&k, ends) in identified.iter().zip(profile.interval_ends(&identified, work)?) {
        let unknown = &study.unknowns[k];
        // Where the profile does not say an end, the linear interval does.
        let value = |side: usize| match ends[side] {
            IntervalEnd::At(x) => unknown.value(x),
            IntervalEnd::Unbounded => [f64::NEG_INFINITY, f64::INFINITY][side],
            IntervalEnd::NotFound => estimates[k].interval[side],
        };
        let values = [value(0), value(1)];
        let farthest = ends.iter().map(|end| match end {
            IntervalEnd::At(x) => (x - fit.x[k]).abs(),
            IntervalEnd::Unbounded => f64::INFINITY,
            IntervalEnd::NotFound => 0.0,
        });
        if farthest.fold(0.0, f64::max) > widest(unknown, fit.x[k]) {
            let [low, high] = values;
            estimates[k].open = Some(match (low.is_finite(), high.is_finite()) {
                (true, true) => format!("the value may be from {low:.3e} to {high:.3e} {}", unknown.unit),
                (true, false) => format!("the value may be anything from {low:.3e} {} on", unknown.unit),
                (false, true) => format!("the value may be anything up to {high:.3e} {}", unknown.unit),
                (false, false) => "the value may be anything".into(),
            });
        }
        estimates[k].has_no_profile = ends.contains(&IntervalEnd::NotFound);
        estimates[k].profile = (!estimates[k].has_no_profile).then_some(values);
    }
    Ok(())
}

/// Returns the number of independent readings and priors less that of unknowns; `None` where the noise is given, not estimated.
fn degrees_of_freedom(study: &IdentificationStudy, fit: &Fit) -> Option<usize> {
    let count = study.reading_count() + study.priors.len();
    let independent = (count as f64 / fit.design_effect) as usize;
    study.noise.is_estimated.then(|| independent.saturating_sub(fit.x.len()).max(usize::from(count > fit.x.len())))
}

/// Returns `failure` with the name, file and line of the measurement with index `at` before its reason.
fn failure_at(study: &IdentificationStudy, at: Option<usize>, failure: Failure) -> Failure {
    let place = at.map_or_else(String::new, |at| format!("{}: ", study.measurement_text(at)));
    Failure { reason: format!("{place}{}", failure.reason), ..failure }
}

/// Scores the unknowns of `search`: by `fit`, or by a new fit without one, and in cross-validation; `Err` if the work was stopped.
fn score_model(
    study: &IdentificationStudy,
    name: &str,
    search: &Search<'_>,
    fit: Option<&Fit>,
    work: &Work,
) -> Result<SetScore> {
    let measurements: Vec<&Measurement> = study.measurements.iter().collect();
    let start = DVector::zeros(search.unknowns.len());
    let refit = if fit.is_some() { None } else { search.fit(&measurements, &start).ok() };
    let fit = fit.or(refit.as_ref());
    let rms = |residuals: &[f64]| validate::rms_mm(residuals, &study.measurements);
    let predicted_mm = match study.folds {
        // Nothing is left that could predict the only measurement.
        0 | 1 => Ok(None),
        folds => {
            let parts = validate::k_fold_residuals(search, &start, &study.measurements, folds, work)?;
            work.check()?;
            parts.map(|errors| rms(&errors))
        }
    };
    Ok(SetScore {
        name: name.into(),
        unknowns: search.unknowns.len(),
        fitted_mm: fit.and_then(|fit| rms(fit.residuals.as_slice())),
        predicted_mm,
    })
}

/// Estimates unknown `k` from the fit: value, linear 95 % interval, strongest correlation.
fn estimate(study: &IdentificationStudy, fit: &Fit, misfit: Option<f64>, k: usize) -> Estimate {
    let (unknown, x) = (&study.unknowns[k], fit.x[k]);
    let half_width = scatter::half_width(degrees_of_freedom(study, fit)) * fit.std(k);
    let ends = [x - half_width, x + half_width].map(|x| unknown.value(x));
    let others = (0..fit.x.len()).filter(|&other| other != k);
    let correlated = others.filter_map(|other| Some((other, fit.correlation(k, other)?)));
    Estimate {
        unknown: unknown.clone(),
        value: unknown.value(x),
        interval: ends,
        profile: None,
        has_no_profile: false,
        half_width,
        open: why_not_identified(study, fit, misfit, k, half_width),
        correlated: correlated.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())),
    }
}

/// Returns why unknown `k` is not identified; `None` if it is.
fn why_not_identified(
    study: &IdentificationStudy,
    fit: &Fit,
    misfit: Option<f64>,
    k: usize,
    half_width: f64,
) -> Option<String> {
    let (unknown, x) = (&study.unknowns[k], fit.x[k]);
    if unknown.is_at_limit(x) {
        return Some(match unknown.coordinate {
            Coordinate::Logarithm if x > 0.0 => {
                "the larger the value, the better the fit, up to a thousand times the machine file's or more".into()
            }
            Coordinate::Logarithm => {
                "the smaller the value, the better the fit, down to a thousandth of the machine file's or less".into()
            }
            Coordinate::Linear(scale) => {
                format!("the best fit is {:?} {} or more from the machine file's value", scale * x.abs(), unknown.unit)
            }
        });
    }
    if !fit.is_converged {
        return Some("the search did not end".into());
    }
    if fit.is_beyond_noise {
        return Some(format!(
            "the residual is {:.1} times the noise that was given, more than chance explains",
            fit.scale
        ));
    }
    if let Some(share) = misfit {
        let percent = 100.0 * share;
        return Some(format!(
            "the residual is {percent:.0} % of what was measured, and no noise is given that explains it"
        ));
    }
    // One that is identifiable, and would go farther, holds the others where they do not fit best.
    let quantile = scatter::half_width(degrees_of_freedom(study, fit));
    let is_stuck = |j: &usize| study.unknowns[*j].is_at_limit(fit.x[*j]) && quantile * fit.std(*j) <= WIDE;
    if let Some(stuck) = (0..fit.x.len()).find(is_stuck) {
        return Some(format!("the fit would be better with {} outside its search range", study.unknowns[stuck].name));
    }
    if half_width <= widest(unknown, x) {
        return None;
    }
    let effect = fit.predicted.slopes.column(k).amax();
    if effect == 0.0 {
        return Some("no reading depends on this parameter".into());
    }
    if !half_width.is_finite() {
        let together = (0..fit.x.len()).filter(|&other| other != k && fit.null_space_part(other) > 0.1);
        let names: Vec<&str> = together.map(|other| study.unknowns[other].name.as_str()).collect();
        return Some(match names.is_empty() {
            true => "the readings hardly depend on this parameter".into(),
            false => format!("only a combination with {} is identifiable", names.join(", ")),
        });
    }
    Some(match study.unknowns[k].coordinate {
        Coordinate::Logarithm if half_width > 7.0 => "the value may be of any size from here on".into(),
        Coordinate::Logarithm => format!("the value may be {:.1} times smaller or larger", libm::exp(half_width)),
        Coordinate::Linear(scale) => {
            format!("the value may be {:.3} {} less or more", half_width * scale, study.unknowns[k].unit)
        }
    })
}
