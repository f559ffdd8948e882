//! The first screen of a placement study: the best place of the workpiece, the gain, and the margin around it.

use super::{
    quantities::{of_entry, verdicts},
    text::{NO_DEFLECTION, at, best_entry, nowhere, towards},
};
use crate::{
    answer::{ShareWithin, cautions},
    files::words::{counted, percent, signed, typographic},
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    process::file::NOT_CONTROLLED,
    questions::{
        path::report::facts_text,
        placement::{
            End, Entry, Evaluation, FeatureJob, Found, Metric, PlacementResults, PlacementStudy, Room, is_angle,
        },
    },
};

/// The answer at a glance.
pub(super) fn headline(results: &PlacementResults) -> Headline {
    let study = &results.study;
    let cannot = verdicts(results)[2];
    let mut basis = counted(results.cells.len(), "place");
    if cannot > 0 {
        basis += &format!(", at {cannot} of them the workpiece cannot be cut");
    }
    let Some((entry, evaluation)) = best_entry(results) else {
        let said = nowhere(results);
        let (first, rest) = said.split_once('\n').unwrap_or((&said, ""));
        return Headline::new(first, basis).with_cautions(rest).with_cautions(&known(study));
    };
    Headline::new(sentence(results, entry, evaluation), basis)
        .with_cautions(&known(study))
        .with_cautions(&not_corrected(evaluation))
        .with_all(before(study, entry, evaluation))
        .with_all(after(study, entry, evaluation))
        .with_all(room(results))
}

/// What must be known with the answer.
pub fn known(study: &PlacementStudy) -> String {
    let words = study.machine.uncontrolled_words().map(|words| (NOT_CONTROLLED, words));
    cautions::carried(&study.machine) + &facts_text(words.as_slice())
}

fn not_corrected(evaluation: &Evaluation) -> String {
    let reason = evaluation.not_corrected.as_ref();
    reason.map_or_else(String::new, |reason| format!("There is no correction within the limits: {reason}.\n"))
}

/// What is cut, in a word.
fn part(study: &PlacementStudy) -> &str {
    match study.features.as_slice() {
        [one] => &one.feature.name,
        _ => "workpiece",
    }
}

fn value(study: &PlacementStudy, evaluation: &Evaluation, metric: Metric) -> Option<String> {
    Some(metric.shown(&study.machine, evaluation.metrics.get(metric)?))
}

fn sentence(results: &PlacementResults, entry: &Entry, evaluation: &Evaluation) -> String {
    let study = &results.study;
    let mut text = format!("Clamp the {} at {}{}", part(study), at(&entry.site), turned(study, entry));
    if let Some(worst) = value(study, evaluation, Metric::WorstDeflection) {
        text += &format!(": the tool leaves its path by at most {worst}{}", gained(results, entry, evaluation));
    }
    match (value(study, evaluation, Metric::WorstResidual), value(study, evaluation, Metric::WorstCorrection)) {
        (Some(left), _) => text += &format!(", and {left} after compensation"),
        (None, Some(correction)) => text += &format!("; drive corrections of up to {correction} keep it there"),
        _ => {}
    }
    text + "."
}

/// How the arm is turned about its tool there, where that is sought.
fn turned(study: &PlacementStudy, entry: &Entry) -> String {
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

/// How much less that is than at the first named place that can be cut at.
fn gained(results: &PlacementResults, entry: &Entry, evaluation: &Evaluation) -> String {
    let study = &results.study;
    let worst = |evaluation: &Evaluation| evaluation.metrics.get(Metric::WorstDeflection);
    let named = study.candidates.iter().filter_map(|candidate| {
        let found = results.entries.iter().find(|other| other.name == candidate.name && other.found == Found::Named)?;
        Some((&found.name, worst(found.feasible()?)?)).filter(|_| found.name != entry.name)
    });
    let (Some((name, there)), Some(here)) = (named.into_iter().next(), worst(evaluation)) else { return String::new() };
    match 1.0 - here / there {
        _ if there <= NO_DEFLECTION => String::new(),
        gain if gain >= 0.005 => format!(", {:.0} % less than {name}", 100.0 * gain),
        gain if gain <= -0.005 => format!(", {:.0} % more than {name}", -100.0 * gain),
        _ => format!(", as {name}"),
    }
}

/// The tolerance that is asked for, if all features have one.
fn tolerance(study: &PlacementStudy) -> Option<f64> {
    let mut all = study.features.iter().map(|job| job.feature.tolerance_mm);
    let first = all.next()?;
    all.all(|other| other == first).then_some(first)
}

fn met(study: &PlacementStudy, share: Option<f64>) -> String {
    match (share, tolerance(study)) {
        (None, _) => String::new(),
        (Some(share), tolerance @ Some(_)) => {
            ShareWithin::of_all(share).words(tolerance, "on … of the path").unwrap_or_default()
        }
        (Some(share), None) => format!("within the tolerances of the features on {} of the path", percent(share)),
    }
}

fn in_candidates(study: &PlacementStudy, entry: &Entry, metric: Metric, value: f64) -> InTable {
    let rows = [["name", entry.name.as_str()]];
    of_entry(study, metric).found_in("candidates.csv", &rows, Extreme::Largest, value)
}

fn before(study: &PlacementStudy, entry: &Entry, evaluation: &Evaluation) -> Option<KeyNumber> {
    let metric = Metric::WorstDeflection;
    let against = met(study, evaluation.metrics.get(Metric::ShareWithin));
    let number = KeyNumber::new(
        &value(study, evaluation, metric)?,
        "largest distance of the tool from its path, without compensation",
        against,
    );
    Some(number.found(in_candidates(study, entry, metric, evaluation.metrics.get(metric)?)))
}

/// What the correction within limits leaves; without limits, the correction.
fn after(study: &PlacementStudy, entry: &Entry, evaluation: &Evaluation) -> Option<KeyNumber> {
    let of = |metric| value(study, evaluation, metric);
    let metric = match evaluation.metrics.get(Metric::WorstResidual) {
        Some(_) => Metric::WorstResidual,
        None => Metric::WorstCorrection,
    };
    let (what, against) = match metric {
        Metric::WorstResidual => (
            "largest distance after compensation within the limits given".to_string(),
            met(study, evaluation.metrics.get(Metric::ShareWithinCorrected)),
        ),
        _ => {
            let force = of(Metric::WorstDriveForce).map(|force| format!("drives carry up to {force}"));
            ("largest drive correction that keeps the tool on its path".into(), force.unwrap_or_default())
        }
    };
    let number = KeyNumber::new(&of(metric)?, what, against);
    Some(number.found(in_candidates(study, entry, metric, evaluation.metrics.get(metric)?)))
}

/// Room below this is none, mm: none of what is shown.
const NO_ROOM_MM: f64 = 0.1;
/// The same of angles, degrees.
const NO_ROOM_DEG: f64 = 0.05;

/// How far the workpiece may be moved before that matters, where that is least, and where it may not be moved at all.
fn room(results: &PlacementResults) -> Option<KeyNumber> {
    let is_none = |room: &&Room| match is_angle(room.coordinate) {
        true => room.distance < NO_ROOM_DEG.to_radians(),
        false => room.distance < NO_ROOM_MM,
    };
    let (blocked, free): (Vec<&Room>, Vec<&Room>) = results.flatness.iter().partition(is_none);
    let none: Vec<String> =
        blocked.iter().map(|room| format!("none towards {}: {}", towards(room), end(room))).collect();
    let free = free.into_iter().filter(|room| !is_angle(room.coordinate));
    let Some(least) = free.min_by(|a, b| a.distance.total_cmp(&b.distance)) else {
        let is_blocked = blocked.iter().any(|room| !is_angle(room.coordinate));
        return is_blocked
            .then(|| KeyNumber::new("0.0 mm", "margin: the part fits there alone".to_owned(), none.join("; ")));
    };
    // What is said can be done.
    let distance = (10.0 * least.distance).floor() / 10.0;
    let what = match &least.end {
        End::Worse => format!("least margin ({}), before the objective is 5 % worse", towards(least)),
        _ => format!("least margin ({}), then {}", towards(least), end(least)),
    };
    Some(KeyNumber::new(&format!("{distance:.1} mm"), what, none.join("; ")))
}

fn end(room: &Room) -> String {
    match &room.end {
        End::Worse => "it gets worse at once".into(),
        End::Bound => "the bound of the search".into(),
        End::Infeasible(reason) => signed(reason),
        End::Nowhere => "nothing ends it".into(),
    }
}
