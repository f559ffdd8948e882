//! Identification: which numbers of a machine make it yield as it was measured to, how far they are known, and what was not told.

mod advice;
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

pub use advice::{Advice, Open};
use fit::measured;
pub use fit::{Fit, Noise, Search};
pub use measurements::{Applied, Measurement, Quantity, Reading, WhatFor, read};
use model::values_at;
pub use model::{LoadedModel, Predicted};
pub use patterns::{Pattern, rank_correlation, ranks};
pub use prediction::{Answer, predict};
pub(crate) use resolve::{priors, rows};
pub use scatter::{half_width, most_by_chance};
pub use spec::LossSpec;
pub use unit_factor::UnitFactor;
pub(crate) use unknown::unknowns;
pub use unknown::{Coordinate, Unknown, is_pattern_of};
pub use validate::FarOff;

use self::profile::{End, Profile};
use crate::{
    input::error::Result,
    machine::Machine,
    simulation::Failure,
    work::{Event, Work},
};

/// A checked identification.
#[derive(Debug, Clone)]
pub struct IdentificationStudy {
    /// The machine to begin with.
    pub machine: Machine,
    /// The text of its file.
    pub machine_text: String,
    /// Name of the file of measurements.
    pub data: String,
    /// What was measured.
    pub measurements: Vec<Measurement>,
    /// What is sought.
    pub unknowns: Vec<Unknown>,
    /// What is known beforehand: the unknown, its coordinate and the standard deviation of that.
    pub priors: Vec<(usize, f64, f64)>,
    /// Noise of readings that have none of their own.
    pub noise: Noise,
    /// How far-off readings count.
    pub loss: LossSpec,
    /// Parts that are predicted from the others.
    pub folds: usize,
    /// Whether intervals are sought by the profile of the likelihood as well.
    pub profile: bool,
    /// Other sets of unknowns.
    pub alternatives: Vec<(String, Vec<Unknown>)>,
}

/// An unknown and what was found of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Which unknown.
    pub unknown: Unknown,
    /// The value that fits best, in its unit.
    pub value: f64,
    /// Its 95 % interval; infinite where nothing limits it.
    pub interval: [f64; 2],
    /// Its 95 % interval by the profile of the likelihood, if that was sought and could be found; infinite where nothing limits it.
    pub profile: Option<[f64; 2]>,
    /// Whether that was sought, and is not known: the others could not be fitted anew.
    pub is_profile_unknown: bool,
    /// Half the interval in the coordinate of the unknown: a factor of e, a millimetre or a degree is 1.
    pub half_width: f64,
    /// Why it is not identified; `None` if it is.
    pub open: Option<String>,
    /// The unknown that it is most correlated with, and how.
    pub correlated: Option<(usize, f64)>,
}

/// How well a set of unknowns predicts.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// What it is called.
    pub name: String,
    /// How many unknowns it has.
    pub unknowns: usize,
    /// RMS of the residuals of the lengths it was fitted to, mm.
    pub fitted_mm: Option<f64>,
    /// RMS error of lengths that were predicted from the other parts, mm; or why there is none.
    pub predicted_mm: std::result::Result<Option<f64>, Failure>,
}

/// A machine with the numbers that were identified, and all others as its file has them.
#[derive(Debug, Clone, PartialEq)]
pub struct Mixed {
    /// Those others that were sought with them, by index.
    pub kept: Vec<usize>,
    /// RMS of what it leaves of lengths, mm; or why that is not known.
    pub residual_mm: std::result::Result<Option<f64>, Failure>,
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The fit.
    pub fit: Fit,
    /// Each unknown.
    pub found: Vec<Found>,
    /// Combinations that are open.
    pub open: Vec<Open>,
    /// What would tell most of them, if something is open and a force can.
    pub advice: Option<Advice>,
    /// Residuals without their own measurement, linearised.
    pub left_out: Vec<f64>,
    /// What the residuals correlate with.
    pub patterns: Vec<Pattern>,
    /// Readings that lie far off all others, the farthest first.
    pub far_off: Vec<FarOff>,
    /// The machine with what was identified alone; `None` where all or nothing was.
    pub mixed: Option<Mixed>,
    /// What all stiffnesses are off by, if it looks like a unit.
    pub unit_factor: Option<UnitFactor>,
    /// Sets of unknowns by how well they predict; that of the study first.
    pub models: Vec<Model>,
}

/// The half width from which an unknown is not identified: a factor of e either way, a millimetre, a degree.
const WIDE: f64 = 1.0;

impl IdentificationStudy {
    /// A measurement in words, with its line in the file.
    pub fn place(&self, measurement: usize) -> String {
        let own = &self.measurements[measurement];
        format!("pose {} ({}:{})", own.name, self.data, own.line)
    }

    /// Number of readings.
    pub fn reading_count(&self) -> usize {
        self.measurements.iter().map(|measurement| measurement.readings.len()).sum()
    }

    fn search<'a>(&'a self, unknowns: &'a [Unknown], priors: &'a [(usize, f64, f64)]) -> Search<'a> {
        Search { machine: &self.machine, unknowns, priors, noise: self.noise, loss: self.loss }
    }
}

/// Fits the unknowns and says what was told; on the current rayon pool, with the same result for any number of threads.
///
/// # Errors
/// The work was stopped.
pub fn run(study: &IdentificationStudy, work: &Work) -> Result<std::result::Result<Identified, Failure>> {
    work.check()?;
    let search = study.search(&study.unknowns, &study.priors);
    let all: Vec<&Measurement> = study.measurements.iter().collect();
    let start = DVector::zeros(study.unknowns.len());
    let fit = match search.fit(&all, &start) {
        Ok(fit) => fit,
        Err((at, failure)) => return Ok(Err(of_measurement(study, at, failure))),
    };
    work.tell(Event::Computed(study.measurements.len()));
    let open = advice::open(&fit);
    let advice = match open.is_empty() {
        true => None,
        false => advice::advice(&search, &fit, &study.measurements, work)?,
    };
    let mut models = vec![model(study, "the study", (&search, Some(&fit)), work)?];
    for (name, unknowns) in &study.alternatives {
        models.push(model(study, name, (&study.search(unknowns, &[]), None), work)?);
    }
    let mut found: Vec<Found> = (0..study.unknowns.len()).map(|k| found(study, &fit, k)).collect();
    work.check()?;
    profiles(study, &search, (&fit, &all), &mut found, work)?;
    let mixed = mixed(study, &search, (&fit, &all), &found);
    let unit_factor = unit_factor::unit_factor(study, &fit);
    let left_out = validate::left_one_out(&fit, &study.measurements);
    let patterns = patterns::patterns(&study.machine, &fit, &study.measurements);
    let far_off = validate::far_off(&fit, &study.measurements);
    Ok(Ok(Identified { found, open, advice, left_out, patterns, far_off, models, mixed, unit_factor, fit }))
}

/// The machine that a file with what was identified describes; `None` where all or nothing was.
fn mixed(
    study: &IdentificationStudy,
    search: &Search<'_>,
    (fit, all): (&Fit, &[&Measurement]),
    found: &[Found],
) -> Option<Mixed> {
    let kept: Vec<usize> = (0..found.len()).filter(|&k| found[k].open.is_some()).collect();
    if kept.is_empty() || kept.len() == found.len() {
        return None;
    }
    let x = DVector::from_fn(found.len(), |k, _| if kept.contains(&k) { 0.0 } else { fit.x[k] });
    let there = values_at(search.machine, search.unknowns, &x, all);
    let residual_mm = match there {
        Ok(there) => Ok(validate::rms_mm((measured(all) - there).as_slice(), &study.measurements)),
        Err((at, failure)) => Err(of_measurement(study, at, failure)),
    };
    Some(Mixed { kept, residual_mm })
}

/// Adds the intervals by the profile of the likelihood to what is identified.
fn profiles(
    study: &IdentificationStudy,
    search: &Search<'_>,
    (fit, all): (&Fit, &[&Measurement]),
    found: &mut [Found],
    work: &Work,
) -> Result<()> {
    let quantile = scatter::half_width(free(study, fit));
    let profile = if study.profile { Profile::new(*search, fit, all, quantile) } else { None };
    let Some(profile) = profile else { return Ok(()) };
    let known: Vec<usize> = (0..found.len()).filter(|&k| found[k].open.is_none()).collect();
    for (&k, ends) in known.iter().zip(profile.ends(&known, work)?) {
        let unknown = &study.unknowns[k];
        // Where the profile does not say an end, the linear interval does.
        let value = |side: usize| match ends[side] {
            End::At(x) => unknown.value(x),
            End::Nowhere => [f64::NEG_INFINITY, f64::INFINITY][side],
            End::Unknown => found[k].interval[side],
        };
        let values = [value(0), value(1)];
        let farthest = ends.iter().map(|end| match end {
            End::At(x) => (x - fit.x[k]).abs(),
            End::Nowhere => f64::INFINITY,
            End::Unknown => 0.0,
        });
        if farthest.fold(0.0, f64::max) > WIDE {
            let [low, high] = values;
            found[k].open = Some(match (low.is_finite(), high.is_finite()) {
                (true, true) => format!("it may be from {low:.3e} to {high:.3e} {}", unknown.unit),
                (true, false) => format!("it may be anything from {low:.3e} {} on", unknown.unit),
                (false, true) => format!("it may be anything up to {high:.3e} {}", unknown.unit),
                (false, false) => "it may be anything".into(),
            });
        }
        found[k].is_profile_unknown = ends.contains(&End::Unknown);
        found[k].profile = (!found[k].is_profile_unknown).then_some(values);
    }
    Ok(())
}

/// How many readings more there are than unknowns, where they tell the noise.
fn free(study: &IdentificationStudy, fit: &Fit) -> Option<usize> {
    study.noise.is_estimated.then(|| (study.reading_count() + study.priors.len()).saturating_sub(fit.x.len()))
}

fn of_measurement(study: &IdentificationStudy, at: Option<usize>, failure: Failure) -> Failure {
    let place = at.map_or_else(String::new, |at| format!("{}: ", study.place(at)));
    Failure { reason: format!("{place}{}", failure.reason), ..failure }
}

fn model(
    study: &IdentificationStudy,
    name: &str,
    (search, fit): (&Search<'_>, Option<&Fit>),
    work: &Work,
) -> Result<Model> {
    let all: Vec<&Measurement> = study.measurements.iter().collect();
    let start = DVector::zeros(search.unknowns.len());
    let own = if fit.is_some() { None } else { search.fit(&all, &start).ok() };
    let fit = fit.or(own.as_ref());
    let rms = |residuals: &[f64]| validate::rms_mm(residuals, &study.measurements);
    let predicted_mm = match study.folds {
        // Nothing is left that could predict the only measurement.
        0 | 1 => Ok(None),
        folds => {
            let parts = validate::in_parts(search, &start, &study.measurements, folds, work)?;
            parts.map(|errors| rms(&errors))
        }
    };
    Ok(Model {
        name: name.into(),
        unknowns: search.unknowns.len(),
        fitted_mm: fit.and_then(|fit| rms(fit.residuals.as_slice())),
        predicted_mm,
    })
}

fn found(study: &IdentificationStudy, fit: &Fit, k: usize) -> Found {
    let (unknown, x) = (&study.unknowns[k], fit.x[k]);
    let half_width = scatter::half_width(free(study, fit)) * fit.std(k);
    let ends = [x - half_width, x + half_width].map(|x| unknown.value(x));
    let others = (0..fit.x.len()).filter(|&other| other != k);
    let correlated = others.filter_map(|other| Some((other, fit.correlation(k, other)?)));
    Found {
        unknown: unknown.clone(),
        value: unknown.value(x),
        interval: ends,
        profile: None,
        is_profile_unknown: false,
        half_width,
        open: why_open(study, fit, k, half_width),
        correlated: correlated.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())),
    }
}

/// Why an unknown is not identified.
fn why_open(study: &IdentificationStudy, fit: &Fit, k: usize, half_width: f64) -> Option<String> {
    let (unknown, x) = (&study.unknowns[k], fit.x[k]);
    if unknown.is_at_end(x) {
        return Some(match unknown.coordinate {
            Coordinate::Logarithm if x > 0.0 => {
                "the larger the better it fits, a thousand times what the machine file says or more".into()
            }
            Coordinate::Logarithm => {
                "the smaller the better it fits, a thousandth of what the machine file says or less".into()
            }
            Coordinate::Linear(scale) => {
                format!("it fits best {:?} {} or more from what the machine file says", scale * x.abs(), unknown.unit)
            }
        });
    }
    if !fit.is_found {
        return Some("the search did not end".into());
    }
    if fit.is_beyond_noise {
        return Some(format!(
            "the residual is {:.1} times the noise that was given, more than chance explains",
            fit.scale
        ));
    }
    // One that is identifiable, and would go farther, holds the others where they do not fit best.
    let quantile = scatter::half_width(free(study, fit));
    let is_stuck = |own: &usize| study.unknowns[*own].is_at_end(fit.x[*own]) && quantile * fit.std(*own) <= WIDE;
    if let Some(stuck) = (0..fit.x.len()).find(is_stuck) {
        return Some(format!("{} would fit better where it is not sought", study.unknowns[stuck].name));
    }
    if half_width <= WIDE {
        return None;
    }
    let effect = fit.predicted.slopes.column(k).amax();
    if effect == 0.0 {
        return Some("nothing that was measured depends on it".into());
    }
    if !half_width.is_finite() {
        let together = (0..fit.x.len()).filter(|&other| other != k && fit.null_space_part(other) > 0.1);
        let names: Vec<&str> = together.map(|other| study.unknowns[other].name.as_str()).collect();
        return Some(match names.is_empty() {
            true => "what was measured hardly depends on it".into(),
            false => format!("only a combination with {} is identifiable", names.join(", ")),
        });
    }
    Some(match study.unknowns[k].coordinate {
        Coordinate::Logarithm if half_width > 7.0 => "it may be any size from here on".into(),
        Coordinate::Logarithm => format!("it may be {:.1} times smaller or larger", half_width.exp()),
        Coordinate::Linear(scale) => {
            format!("it may be {:.3} {} less or more", half_width * scale, study.unknowns[k].unit)
        }
    })
}
