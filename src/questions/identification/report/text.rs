//! Sentences and first screen of an identification: what was identified, and how well it predicts.

use super::{ERRORS, MACHINE, summary::Report};
use crate::{
    files::words::{counted, join_text, listed_up_to, millimetres, percent},
    machine::Machine,
    page::headline::{Headline, KeyNumber, State, Verdict},
    questions::identification::{
        CauseKind, Coordinate, Estimate, IdentificationStudy, LossSpec, Measurement, NOTEWORTHY, Outlier, Pattern,
        SetScore, Unknown,
    },
    simulation::Failure,
};

/// Returns what the results rest on, such as "24 measurements, 72 readings, 5 unknowns".
fn basis(study: &IdentificationStudy) -> String {
    let readings = counted(study.reading_count(), "reading");
    format!(
        "{}, {readings}, {}",
        counted(study.measurements.len(), "measurement"),
        counted(study.unknowns.len(), "unknown")
    )
}

/// Returns the first screen: how many parameters are identified, cautions, and residual and prediction errors as key numbers.
pub(super) fn headline(report: &Report<'_>) -> Headline {
    let (total, identified) = (report.results.estimates.len(), report.identified().count());
    let are = |count: usize| if count == 1 { "is" } else { "are" };
    let name = report.results.estimates.first().map_or("", |estimate| &*estimate.unknown.name);
    let outcome = match (total - identified, identified) {
        _ if !report.results.fit.is_converged => {
            "The search for the parameters did not end: nothing is identified; the values in parameters.csv are the best found".into()
        }
        _ if report.results.fit.is_beyond_noise => {
            "Nothing is identified: the residual is larger than the noise that was given explains".into()
        }
        _ if report.results.misfit.is_some() => {
            "Nothing is identified: the residual is a large share of what was measured, and no noise is given that explains it".into()
        }
        (0, 1) => format!("The parameter is identified: {}", first_identified(report)),
        (0, _) => format!("All {total} parameters are identified: {}", first_identified(report)),
        (1, 0) => format!("Parameter {name} is not identified: the measurements do not determine its value"),
        (_, 0) => format!("None of {total} parameters is identified: the measurements do not determine their values"),
        (open, _) => format!(
            "{identified} of {total} parameters {} identified: {}; the measurements do not determine {open}",
            are(identified),
            first_identified(report)
        ),
    };
    let predicted = report.results.models[0].predicted_mm.as_ref().ok().copied().flatten();
    let (sentence, details) = match predicted {
        Some(predicted) => {
            let predicted = millimetres(predicted, 3);
            (format!("What was not fitted is predicted to {predicted} RMS."), format!("{outcome}."))
        }
        None => (format!("{identified} of {total} parameters {} identified.", are(total)), format!("{outcome}.")),
    };
    let share = |value: f64| {
        report
            .measured_mm()
            .map_or_else(String::new, |measured| format!("{} of what was measured", percent(value / measured)))
    };
    let results = report.results;
    let is_fitted = results.fit.is_converged && !results.fit.is_beyond_noise && results.misfit.is_none();
    let verdict = match if is_fitted { identified } else { 0 } {
        0 => Verdict::new(State::Bad, "Nothing identified"),
        all if all == total => Verdict::new(State::Good, format!("All {total} parameters identified")),
        some => Verdict::new(State::Partly, format!("{some} of {total} parameters identified")),
    };
    let next = match is_fitted && identified == total {
        true => "compute with the identified machine, machine.toml.",
        false if !is_fitted => "find what the first of these cautions names, and identify again.",
        false => "plan measurements that determine the others: a measurement design does.",
    };
    Headline::new(sentence, basis(report.study))
        .judged(verdict, false)
        .next(next)
        .with_cautions(&details)
        .with_cautions(&cautions(report))
        .with_numbers(report.residual_mm().map(|rms| KeyNumber::new(&millimetres(rms, 3), "residual, RMS", share(rms))))
        .with_numbers(predicted.map(|value| {
            let what = format!("error of what was not fitted, RMS, {} parts", report.study.folds);
            KeyNumber::new(&millimetres(value, 3), what, share(value))
        }))
        .with_numbers(report.leave_one_out_mm().map(|value| {
            KeyNumber::new(&millimetres(value, 3), "error with one measurement left out, RMS", share(value))
        }))
}

/// Returns the first screen where nothing could be computed.
pub(super) fn failed(study: &IdentificationStudy, failure: &Failure) -> Headline {
    Headline::new(format!("Nothing could be identified: {}.", failure.reason.trim_end_matches('.')), basis(study))
        .judged(Verdict::new(State::Bad, "Nothing identified"), false)
}

/// Formats a number with four decimals, or in scientific notation if it is large or small.
fn rounded(value: f64) -> String {
    if value.abs() >= 1e4 || (value != 0.0 && value.abs() < 1e-2) {
        format!("{value:.3e}")
    } else {
        format!("{value:.4}")
    }
}

/// Formats the value of an estimate with its unit, if it has one.
fn with_unit(estimate: &Estimate) -> String {
    format!("{} {}", rounded(estimate.value), estimate.unknown.unit).trim_end().into()
}

/// Formats the value of an estimate with its unit and interval.
fn value_with_interval(estimate: &Estimate) -> String {
    let [low, high] = estimate.interval;
    match low.is_finite() && high.is_finite() {
        true => format!("{} ({} to {})", with_unit(estimate), rounded(low), rounded(high)),
        false => format!("{} (no limit)", with_unit(estimate)),
    }
}

/// Most parameters in one sentence.
const FEW: usize = 3;

/// Formats half an interval, given in the coordinate of the unknown: logarithms in percent or as a factor, others in the unit.
pub(crate) fn width_text(unknown: &Unknown, width: f64) -> String {
    match unknown.coordinate {
        Coordinate::Logarithm if width > 7.0 => "any size".into(),
        Coordinate::Linear(_) if width > ANYTHING => "any size".into(),
        Coordinate::Logarithm if width > 0.5 => format!("within a factor of {:.1}", libm::exp(width)),
        Coordinate::Logarithm => format!("±{}", percent(width)),
        Coordinate::Linear(scale) => format!("±{} {}", rounded(width * scale), unknown.unit).trim_end().into(),
    }
}

/// Half width, in the coordinate of an unknown, from which it may have any value.
pub(crate) const ANYTHING: f64 = 100.0;

/// Formats an estimate: name, value and half its interval.
pub(super) fn brief(estimate: &Estimate) -> String {
    format!("{} {} {}", estimate.unknown.name, with_unit(estimate), width_text(&estimate.unknown, estimate.half_width))
}

/// Lists the first identified parameters, for a part of a sentence.
fn first_identified(report: &Report<'_>) -> String {
    listed_up_to(FEW, report.identified().map(brief))
}

/// Returns a line for each unknown: value and interval, or why it is not identified.
pub(super) fn parameter_text(report: &Report<'_>) -> Vec<String> {
    let line = |estimate: &Estimate| match &estimate.open {
        None => format!("{}: {}", estimate.unknown.name, value_with_interval(estimate)),
        Some(reason) => format!("{}: not identified: {reason}", estimate.unknown.name),
    };
    report.results.estimates.iter().map(line).collect()
}

/// Says which intervals by the profile likelihood differ from the linear ones by more than a tenth of the half width; `None` if none does.
fn profile_differences(report: &Report<'_>) -> Option<String> {
    let differs = |estimate: &&Estimate| {
        let Some(profile) = estimate.profile else { return false };
        let coordinate = |value: f64| estimate.unknown.coordinate_at(value).unwrap_or(f64::INFINITY);
        let shift = |side: usize| (coordinate(profile[side]) - coordinate(estimate.interval[side])).abs();
        // An end that is nowhere makes this no number, which is not less.
        !(shift(0) < 0.1 * estimate.half_width && shift(1) < 0.1 * estimate.half_width)
    };
    let text = |estimate: &Estimate| {
        let end = |end: f64| if end.is_finite() { rounded(end) } else { "no limit".into() };
        let [low, high] = estimate.profile.unwrap_or(estimate.interval).map(end);
        format!("{} ({low} to {high})", estimate.unknown.name)
    };
    let listed: Vec<String> = report.identified().filter(differs).map(text).collect();
    (!listed.is_empty())
        .then(|| format!("By the profile of the likelihood, intervals are others: {}.", listed.join("; ")))
}

/// Describes the significant correlations of the residuals.
pub(super) fn pattern_text(report: &Report<'_>) -> String {
    let text = |pattern: &Pattern| {
        format!(
            "{} correlates with {} (rank correlation {:+.2}), as by {}",
            pattern.of, pattern.with, pattern.correlation, pattern.hint
        )
    };
    let significant: Vec<String> =
        report.results.patterns.iter().filter(|pattern| pattern.is_significant()).map(text).collect();
    match (report.results.patterns.is_empty(), significant.is_empty()) {
        (true, _) => "There are too few measurements to show a pattern in the residuals.".into(),
        (_, true) => {
            "The residuals show no pattern over order, load, direction and pose: no rank correlation is larger than chance makes once in a \
             thousand times."
                .into()
        }
        _ => format!("A pattern in the residuals: {}.", significant.join("; ")),
    }
}

/// Describes the unidentified parameter combinations and the force that would identify them best; without any, which intervals are too wide.
pub(super) fn unidentified_text(report: &Report<'_>) -> String {
    if report.results.open.is_empty() {
        let open: Vec<&Estimate> = report.results.estimates.iter().filter(|estimate| estimate.open.is_some()).collect();
        let names: Vec<&str> = open.iter().map(|estimate| &*estimate.unknown.name).collect();
        let farther = if open.iter().all(|estimate| estimate.profile.is_some()) { " near the best fit" } else { "" };
        return match names[..] {
            [] => "All parameter combinations are identifiable.".into(),
            _ => format!(
                "The measurements constrain every parameter combination{farther}, but these intervals are too wide: {}.",
                join_text(&names)
            ),
        };
    }
    let combinations: Vec<String> =
        report.results.open.iter().map(|open| report.combination_text(&open.parts)).collect();
    let next = match &report.results.advice {
        Some(advice) => {
            let along = ["x", "y", "z"][advice.force.iamax()];
            let size = rounded(advice.force.norm());
            let pose = &report.study.measurements[advice.measurement].name;
            let std_words = |std: f64| if std.is_finite() { format!("{std:.2}") } else { "infinite".into() };
            format!(
                " A force of {size} N along {along} at pose {pose} would improve the least known combination most: its standard deviation \
                 would fall from {} to {}.",
                std_words(advice.std[0]),
                std_words(advice.std[1])
            )
        }
        None => " No force on the tool tip at these poses would identify these parameters.".into(),
    };
    format!("Not identified, the least known first: {}.{next}", combinations.join("; "))
}

/// Compares the sets of unknowns: RMS residual fitted and in cross-validation.
pub(super) fn model_text(report: &Report<'_>) -> String {
    let lines: Vec<String> = report
        .results
        .models
        .iter()
        .map(|model| {
            let shown = |value: Option<f64>| value.map_or_else(|| "none".into(), |value| millimetres(value, 4));
            let predicted = match &model.predicted_mm {
                Ok(value) => shown(*value),
                Err(failure) => failure.reason.clone(),
            };
            let unknowns = counted(model.unknowns, "unknown");
            format!("{} ({unknowns}): fitted {}, predicted {predicted}", model.name, shown(model.fitted_mm))
        })
        .collect();
    match report.study.folds {
        0 | 1 => format!("RMS of the residuals: {}.", lines.join("; ")),
        folds => format!("RMS of the residuals in {folds} parts: {}.", lines.join("; ")),
    }
}

/// Largest share of the measured lengths that the residual of a model which follows them may have.
const FOLLOWED: f64 = 0.7;
/// Share of the given noise below which residuals of [`MANY`] more readings than unknowns are too small: chance has it once in a thousand.
const TOO_QUIET: f64 = 0.25;
const MANY: usize = 8;
/// Most outliers that are named.
const NAMED: usize = 3;

/// Describes the outliers; `None` without any.
fn outlier_text(report: &Report<'_>) -> Option<String> {
    let far = &report.results.outliers;
    let said = |one: &Outlier| {
        let unit = if one.column.ends_with("deg") { "°" } else { "mm" };
        format!("{} of {} by {:.3} {unit}", one.column, report.study.measurement_text(one.measurement), one.by)
    };
    let what = counted(far.len(), "reading");
    let are = if far.len() == 1 { "is an outlier" } else { "are outliers" };
    let advice = match report.study.loss {
        LossSpec::Squares => "; check these measurements, or give outliers less weight (loss = \"cauchy\")",
        LossSpec::Huber | LossSpec::Cauchy => "",
    };
    (!far.is_empty()).then(|| format!("{what} {are}: {}{advice}.", listed_up_to(NAMED, far.iter().map(said))))
}

/// Names the parameters that fit best at the limit of the search; `None` without any.
fn parameters_at_limit(report: &Report<'_>) -> Option<String> {
    let (fit, unknowns) = (&report.results.fit, &report.study.unknowns);
    let names: Vec<&str> =
        (0..unknowns.len()).filter(|&k| unknowns[k].is_at_limit(fit.x[k])).map(|k| &*unknowns[k].name).collect();
    let which = match names[..] {
        [] => return None,
        [one] => format!("{one} fits"),
        [one, ..] => format!("{one} and {} more fit", names.len() - 1),
    };
    Some(format!(
        "{which} best as far from the machine file as numbers are sought: are loads and readings in the units of their columns?"
    ))
}

/// Says at how many poses a drive is beyond its travel in the machine file; `place` names the pose with an index. `None` if nowhere.
pub(super) fn beyond_travel(
    machine: &Machine,
    poses: &[Measurement],
    place: impl Fn(usize) -> String,
) -> Option<String> {
    let beyond = |i: usize| Some((i, machine.drive_beyond_travel(&poses[i].at.drives)?.1));
    let all: Vec<_> = (0..poses.len()).filter_map(beyond).collect();
    let (first, fault) = all.first()?;
    Some(format!("{} beyond the travel in the machine file: {}: {fault}.", counted(all.len(), "pose"), place(*first)))
}

/// Says what would explain a large residual; `None` where nothing that is tried does.
fn cause_text(report: &Report<'_>) -> Option<String> {
    let cause = report.results.cause.as_ref()?;
    let left = match (cause.share, cause.residual_mm) {
        (Some(share), _) => format!("{} of what was measured", percent(share)),
        (None, Some(residual)) => format!("{} RMS", millimetres(residual, 4)),
        (None, None) => "far less".into(),
    };
    Some(match &cause.kind {
        CauseKind::Zero { unknown, value, is_at_limit } => {
            let (name, value, unit) = (&unknown.name, rounded(*value), unknown.unit);
            let more = if *is_at_limit { " or beyond" } else { "" };
            format!(
                "A zero of a drive that is off explains it: with {name} at {value} {unit}{more}, {left} would be left. Is the drive's \
                 column as a pendant shows it? Else take {name} as an unknown."
            )
        }
        CauseKind::Turned(turn) => {
            let [x, y, z]: [f64; 3] = turn.try_normalize(0.0).unwrap_or_default().into();
            let angle = turn.norm().to_degrees();
            format!(
                "Other axes explain it: with all readings turned back by {angle:.2}° about ({x:.3}, {y:.3}, {z:.3}) of O, {left} would be \
                 left. Are readings along the axes of O, and not of the tracker's frame?"
            )
        }
    })
}

/// Describes the most important problem with the residual, and what may cause it; `None` if it is small enough.
pub(super) fn misfit_caution(report: &Report<'_>) -> Option<String> {
    let cause = cause_text(report);
    let text = misfit_text(report, cause.is_some())?;
    Some([Some(text), cause].into_iter().flatten().collect::<Vec<_>>().join(" "))
}

/// Describes the most important problem with the residual, and what to try unless something explains it; `None` if it is small enough.
fn misfit_text(report: &Report<'_>, is_explained: bool) -> Option<String> {
    const TRY: &str = " Try as unknowns: play of the drives, bearings that tilt across the joints' axes (an arm's elbow first), elastic links.";
    let (fit, share) = (&report.results.fit, report.residual_share().unwrap_or(0.0));
    let text = percent(share);
    let tries = if is_explained { "" } else { TRY };
    const NOTHING: &str = "no noise is given that explains so much, so that nothing is identified; where readings do scatter so, say it by std_mm";
    let inliers = report.inlier_residual_share().unwrap_or(share);
    let far = if share > NOTEWORTHY && inliers < 0.5 * share { outlier_text(report) } else { None };
    if let Some(far) = far {
        let far = format!("The residual is {text} of what was measured, {} without {far}", percent(inliers));
        if fit.is_beyond_noise {
            return Some(format!(
                "{far} The residual is {:.1} times the noise that was given, which chance makes less than once in a hundred times: nothing is identified.",
                fit.scale
            ));
        }
        return Some(match report.study.noise.is_estimated {
            _ if report.results.misfit.is_some() => format!("{far} Of the rest, {NOTHING}.{tries}"),
            true => format!("{far} Intervals are as wide as if all readings scattered so."),
            false => far,
        });
    }
    if share > FOLLOWED {
        let nothing =
            if report.results.misfit.is_some() || fit.is_beyond_noise { " Nothing is identified." } else { "" };
        return Some(format!(
            "The residual is nearly as large as what was measured ({text}): are the units, signs and axes of loads and readings those of \
             their columns?{nothing}"
        ));
    }
    if fit.is_beyond_noise {
        return Some(format!(
            "The residual is {:.1} times the noise that was given, which chance makes less than once in a hundred times: the model lacks \
             something, and nothing is identified.{tries}",
            fit.scale
        ));
    }
    if report.results.misfit.is_some() {
        return Some(format!("The residual is {text} of what was measured: {NOTHING}.{tries}"));
    }
    if report.study.noise.is_estimated && share > NOTEWORTHY {
        return Some(format!(
            "The residual is {text} of what was measured: the model lacks something, or readings scatter so; intervals are as wide as if \
             they did.{tries}"
        ));
    }
    if !report.study.noise.is_estimated && fit.scale < TOO_QUIET && report.study.reading_count() >= fit.x.len() + MANY {
        return Some(format!(
            "The residual is only {} times the noise that was given: are std_mm and std_deg in these units? Intervals are as wide as that \
             noise makes them.",
            rounded(fit.scale)
        ));
    }
    let is_widened = report.study.loss == LossSpec::Squares && !report.study.noise.is_estimated && fit.scale > 1.5;
    is_widened
        .then(|| format!("The residual is {:.1} times the noise that was given; intervals are wider by it.", fit.scale))
}

/// Describes the common factor of stiffnesses that looks like a mistaken unit, if there is one.
pub(super) fn unit_factor_text(report: &Report<'_>) -> Option<String> {
    let common = report.results.unit_factor.as_ref()?;
    let [low, high] = common.interval;
    let than = if common.is_lower { "lower" } else { "higher" };
    let (unit, text) = common.looks_like;
    Some(format!(
        "Stiffnesses are {} ({} to {}) times {than} than the machine file's, each of them {} to {} times: that looks like {text} ({unit}), in \
         loads, readings or the file.",
        rounded(common.factor),
        rounded(low),
        rounded(high),
        rounded(common.each[0]),
        rounded(common.each[1])
    ))
}

/// Names the parameters whose interval by the profile likelihood could not be found; `None` if there are none.
fn unknown_profile_text(report: &Report<'_>) -> Option<String> {
    let all: Vec<&str> = report
        .identified()
        .filter(|estimate| estimate.has_no_profile)
        .map(|estimate| &*estimate.unknown.name)
        .collect();
    (!all.is_empty()).then(|| {
        format!("The profile of the likelihood is unknown of {}: the other parameters could not be fitted anew; intervals are linear.", join_text(&all))
    })
}

/// Returns the cautions that a reader must know before the results, a line each.
fn cautions(report: &Report<'_>) -> String {
    let mut lines: Vec<String> = misfit_caution(report).into_iter().collect();
    lines.extend(unit_factor_text(report));
    if report.results.fit.is_beyond_noise {
        // A wrong unit leaves more than any play.
        lines.reverse();
    }
    lines.extend(report.partial_text());
    lines.extend(parameters_at_limit(report));
    lines.extend(outlier_text(report).filter(|outliers| lines.iter().all(|line| !line.contains(outliers))));
    let study = report.study;
    lines.extend(beyond_travel(&study.machine, &study.measurements, |i| study.measurement_text(i)));
    if let Some(better) = report.better_model() {
        let predicted =
            |model: &SetScore| millimetres(model.predicted_mm.as_ref().ok().copied().flatten().unwrap_or_default(), 3);
        lines.push(format!(
            "The unknowns of \"{}\" predict better: {} instead of {} RMS.",
            better.name,
            predicted(better),
            predicted(&report.results.models[0])
        ));
    }
    lines.extend(profile_differences(report));
    lines.extend(unknown_profile_text(report));
    if report.results.patterns.iter().any(Pattern::is_significant) {
        lines.push(pattern_text(report));
    }
    if report.study.loss != LossSpec::Squares {
        let out = report.results.fit.weights.iter().filter(|&&weight| weight < 0.5).count();
        if out > 0 {
            lines.push(format!("{} of less than half the usual weight.", counted(out, "reading")));
        }
    }
    lines.join("\n")
}

/// Returns all sentences of the results, and what was written into files.
pub(super) fn details(report: &Report<'_>) -> String {
    let mut file = match (&report.file.text, report.file.left_out.is_empty()) {
        (None, _) => {
            let nothing = if report.identified().next().is_none() {
                "no unknown is identifiable"
            } else {
                "none of the identified parameters has a key in a machine file"
            };
            format!("{MACHINE} was not written: {}.", report.file.problem.as_deref().unwrap_or(nothing))
        }
        (Some(_), true) => format!("{MACHINE} has what was identified."),
        (Some(_), false) => {
            format!("{MACHINE} has what was identified but {}.", report.file.left_out.join(", "))
        }
    };
    if let Some(partial) = report.partial_text() {
        file += &format!(" {partial}");
    }
    if !report.errors.is_empty() {
        file += &format!(" {ERRORS}, a process file, has {}.", report.errors.join(", "));
    }
    [parameter_text(report).join("\n"), unidentified_text(report), model_text(report), pattern_text(report), file]
        .join("\n")
}
