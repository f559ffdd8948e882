//! The first screen of a placement study: the best place of the workpiece, the gain, and the margin around it.

use super::{
    largest_force_n,
    quantities::{entry_metric, spread_counts, verdict_counts},
    text::{NO_DEFLECTION, best_entry, direction_words, infeasible_text, robust_text, site_words},
};
use crate::{
    answer::{ShareWithin, cautions},
    files::words::{counted, percent, typographic, with_minus_signs},
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    process::file::NOT_CONTROLLED,
    questions::{
        path::report::facts_text,
        placement::{
            End, Entry, Evaluation, FeatureJob, Margin, Metric, Origin, PlacementResults, PlacementStudy, evaluate,
            is_angle,
        },
        spread_report::{self, Along},
    },
};

/// Returns the first screen: one sentence, key numbers and cautions.
pub(super) fn headline(results: &PlacementResults) -> Headline {
    let study = &results.study;
    let cannot = verdict_counts(results)[2];
    let mut basis = counted(results.cells.len(), "place");
    if cannot > 0 {
        basis += &format!(", at {cannot} of them the workpiece cannot be cut");
    }
    let Some((entry, evaluation)) = best_entry(results) else {
        let said = infeasible_text(results);
        let (first, rest) = said.split_once('\n').unwrap_or((&said, ""));
        return Headline::new(first, basis).with_cautions(rest).with_cautions(&cautions_text(study));
    };
    let uncertainty = study.features[0].uncertainty.as_deref();
    basis += &format!(", {}", spread_report::basis(uncertainty));
    let clamp = sentence(results, entry, evaluation);
    let (sentence, numbers): (String, Vec<KeyNumber>) = match &entry.spread {
        None => {
            let numbers =
                [uncompensated_number(study, entry, evaluation), compensated_number(study, entry, evaluation)];
            (clamp, numbers.into_iter().flatten().collect())
        }
        Some(spread) => {
            let verdict = spread_report::along_verdict(&along(study), &spread.largest);
            let mut numbers = spread_report::along_numbers(&along(study), &spread.largest);
            if study.has_limits() {
                // Limits touch that without compensation, the last, in nothing.
                numbers.drain(..numbers.len() - 1);
                numbers.extend(compensated_number(study, entry, evaluation));
            }
            (format!("{verdict} {clamp}"), numbers)
        }
    };
    let spread_cautions = entry.spread.as_ref().map_or_else(String::new, |spread| {
        spread_report::along_cautions(&along(study), Some(&spread.largest))
            + &spread_report::cautions(uncertainty, &spread_counts(results), "place")
    });
    Headline::new(sentence, basis)
        .with_cautions(&robust_text(results))
        .with_cautions(&spread_cautions)
        .with_cautions(&cautions_text(study))
        .with_cautions(&not_corrected(evaluation))
        .with_numbers(numbers)
        .with_numbers(margin_number(results))
}

/// Returns the cautions for any placement: the workpiece carrier, an assumed workspace box, and axes that the drives do not control.
pub fn cautions_text(study: &PlacementStudy) -> String {
    let words = study.machine.uncontrolled_words().map(|words| (NOT_CONTROLLED, words));
    cautions::carrier(&study.machine) + &cautions::assumed_workspace(&study.machine) + &facts_text(words.as_slice())
}

/// Returns the caution that there is no correction within the limits; empty if there is one.
fn not_corrected(evaluation: &Evaluation) -> String {
    let reason = evaluation.not_corrected.as_ref();
    reason.map_or_else(String::new, |reason| format!("There is no correction within the limits: {reason}.\n"))
}

/// Returns how sentences about the distribution along the paths name them.
pub(super) fn along(study: &PlacementStudy) -> Along<'_> {
    let points = study.features.iter().map(|job| evaluate::counted_flags(job).into_iter().filter(|own| *own).count());
    Along {
        machine: &study.machine.name,
        path: format!("the {}", part(study)),
        // The distribution is of the exact correction.
        commands: if study.has_limits() { "compensated without the limits given" } else { "compensated" },
        missing: "could not be compensated",
        points: points.sum(),
        tolerance_mm: common_tolerance(study),
        unjudged: match common_tolerance(study) {
            _ if study.features.iter().all(cuts_nowhere) => Some(spread_report::NOTHING_CUT),
            _ if study.features.iter().all(|job| largest_force_n(job) == 0.0) => Some(spread_report::NO_FORCE),
            _ if study.has_limits() => Some("The limits given are in no distribution"),
            None => Some("The features have different tolerances"),
            Some(_) => None,
        },
    }
}

/// Whether the tool cuts at no point of the feature.
fn cuts_nowhere(job: &FeatureJob) -> bool {
    job.feature.path.points().iter().all(|point| !point.cutting)
}

/// Returns the name of the only feature, or "workpiece".
fn part(study: &PlacementStudy) -> &str {
    match study.features.as_slice() {
        [one] => &one.feature.name,
        _ => "workpiece",
    }
}

/// Returns the value of a metric with its unit, if it exists.
fn value_of(study: &PlacementStudy, evaluation: &Evaluation, metric: Metric) -> Option<String> {
    Some(metric.value_words(&study.machine, evaluation.metrics.get(metric)?))
}

/// Returns the sentence of the first screen: where to clamp, and unless a verdict by the distribution says it, how far the tool leaves its path.
fn sentence(results: &PlacementResults, entry: &Entry, evaluation: &Evaluation) -> String {
    let study = &results.study;
    let mut text = format!("Clamp the {} at {}{}", part(study), site_words(&entry.site), gamma_words(study, entry));
    if entry.spread.is_some() {
        return text + ".";
    }
    if let Some(worst) = value_of(study, evaluation, Metric::WorstDeflection) {
        text += &format!(": the tool leaves its path by at most {worst}{}", gain_words(results, entry, evaluation));
    }
    match (value_of(study, evaluation, Metric::WorstResidual), value_of(study, evaluation, Metric::WorstCorrection)) {
        (Some(left), _) => text += &format!(", and {left} after compensation"),
        (None, Some(correction)) => text += &format!("; drive corrections of up to {correction} keep it there"),
        _ => {}
    }
    text + "."
}

/// Describes the γ of each feature at a place; empty where none is sought.
fn gamma_words(study: &PlacementStudy, entry: &Entry) -> String {
    let turn = |(job, turn): (&FeatureJob, &Option<f64>)| {
        let degrees = turn.as_ref()?.to_degrees();
        Some((job.feature.name.clone(), typographic(&format!("{degrees:.0}°"))))
    };
    let turns: Vec<(String, String)> = study.features.iter().zip(&entry.turns).filter_map(turn).collect();
    match turns.as_slice() {
        [] => String::new(),
        [(_, turn)] => format!(", the arm rotated about its tool by γ = {turn}"),
        several => {
            let each: Vec<String> = several.iter().map(|(name, turn)| format!("{turn} in {name}")).collect();
            format!(", the arm rotated about its tool by γ = {}", each.join(", "))
        }
    }
}

/// Describes how much smaller the worst deflection is than at the first other named place that can be cut.
fn gain_words(results: &PlacementResults, entry: &Entry, evaluation: &Evaluation) -> String {
    let study = &results.study;
    let worst = |evaluation: &Evaluation| evaluation.metrics.get(Metric::WorstDeflection);
    let named = study.candidates.iter().filter_map(|candidate| {
        let found =
            results.entries.iter().find(|other| other.name == candidate.name && other.found == Origin::Named)?;
        Some((&found.name, worst(found.feasible()?)?)).filter(|_| found.name != entry.name)
    });
    let (Some((name, there)), Some(here)) = (named.into_iter().next(), worst(evaluation)) else { return String::new() };
    let how = if study.seeks_gamma() { " (as programmed)" } else { "" };
    match 1.0 - here / there {
        _ if there <= NO_DEFLECTION => String::new(),
        gain if gain >= 0.005 => format!(", {:.0} % less than {name}{how}", 100.0 * gain),
        gain if gain <= -0.005 => format!(", {:.0} % more than {name}{how}", -100.0 * gain),
        _ => format!(", as {name}{how}"),
    }
}

/// Returns the tolerance in mm if all features have the same.
fn common_tolerance(study: &PlacementStudy) -> Option<f64> {
    let mut all = study.features.iter().map(|job| job.feature.tolerance_mm);
    let first = all.next()?;
    all.all(|other| other == first).then_some(first)
}

/// Describes on which `share` of the path the tolerances are met.
fn tolerance_words(study: &PlacementStudy, share: Option<f64>) -> String {
    match (share, common_tolerance(study)) {
        (None, _) => String::new(),
        (Some(share), tolerance @ Some(_)) => {
            ShareWithin::of_all(share).words(tolerance, "on … of the path").unwrap_or_default()
        }
        (Some(share), None) => format!("within the tolerances of the features on {} of the path", percent(share)),
    }
}

/// Returns where in `candidates.csv` the `value` of a metric of `entry` stands.
fn in_candidates_table(study: &PlacementStudy, entry: &Entry, metric: Metric, value: f64) -> InTable {
    let rows = [["name", entry.name.as_str()]];
    entry_metric(study, metric).found_in("candidates.csv", &rows, Extreme::Largest, value)
}

/// Returns the key number of the worst deflection without compensation.
fn uncompensated_number(study: &PlacementStudy, entry: &Entry, evaluation: &Evaluation) -> Option<KeyNumber> {
    let metric = Metric::WorstDeflection;
    let against = tolerance_words(study, evaluation.metrics.get(Metric::ShareWithin));
    let number = KeyNumber::new(
        &value_of(study, evaluation, metric)?,
        "largest distance of the tool from its path, without compensation",
        against,
    );
    Some(number.found(in_candidates_table(study, entry, metric, evaluation.metrics.get(metric)?)))
}

/// Returns the key number of the worst residual error within limits; without limits, of the largest correction.
fn compensated_number(study: &PlacementStudy, entry: &Entry, evaluation: &Evaluation) -> Option<KeyNumber> {
    let of = |metric| value_of(study, evaluation, metric);
    let metric = match evaluation.metrics.get(Metric::WorstResidual) {
        Some(_) => Metric::WorstResidual,
        None => Metric::WorstCorrection,
    };
    let (what, against) = match metric {
        Metric::WorstResidual => (
            "largest distance after compensation within the limits given".to_string(),
            tolerance_words(study, evaluation.metrics.get(Metric::ShareWithinCorrected)),
        ),
        _ => {
            let force = of(Metric::WorstDriveForce).map(|force| format!("drives carry up to {force}"));
            ("largest drive correction that keeps the tool on its path".into(), force.unwrap_or_default())
        }
    };
    let number = KeyNumber::new(&of(metric)?, what, against);
    Some(number.found(in_candidates_table(study, entry, metric, evaluation.metrics.get(metric)?)))
}

/// Margins below this are shown as none, mm.
const NO_ROOM_MM: f64 = 0.1;
/// Margins of angles below this are shown as none, degrees.
const NO_ROOM_DEG: f64 = 0.05;

/// Returns the key number of the smallest margin of the best place, and of directions without any.
fn margin_number(results: &PlacementResults) -> Option<KeyNumber> {
    let is_none = |room: &&Margin| match is_angle(room.coordinate) {
        true => room.distance < NO_ROOM_DEG.to_radians(),
        false => room.distance < NO_ROOM_MM,
    };
    let (blocked, free): (Vec<&Margin>, Vec<&Margin>) = results.flatness.iter().partition(is_none);
    let none: Vec<String> =
        blocked.iter().map(|room| format!("none towards {}: {}", direction_words(room), end_words(room))).collect();
    let free = free.into_iter().filter(|room| !is_angle(room.coordinate));
    let Some(least) = free.min_by(|a, b| a.distance.total_cmp(&b.distance)) else {
        let is_blocked = blocked.iter().any(|room| !is_angle(room.coordinate));
        return is_blocked
            .then(|| KeyNumber::new("0.0 mm", "margin: the part fits there alone".to_owned(), none.join("; ")));
    };
    // What is said can be done.
    let distance = (10.0 * least.distance).floor() / 10.0;
    let what = match &least.end {
        End::Worse => format!("least margin ({}), before the objective is 5 % worse", direction_words(least)),
        _ => format!("least margin ({}), then {}", direction_words(least), end_words(least)),
    };
    Some(KeyNumber::new(&format!("{distance:.1} mm"), what, none.join("; ")))
}

/// Describes why a margin ends.
fn end_words(room: &Margin) -> String {
    match &room.end {
        End::Worse => "the objective gets worse at once".into(),
        End::Bound => "the bound of the search".into(),
        End::Infeasible(reason) => with_minus_signs(reason),
        End::Nowhere => "nothing ends the margin".into(),
    }
}
