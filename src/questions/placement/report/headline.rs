//! The first screen of a placement study: the best place of the workpiece, the gain, and the margin around it.

use kinetostat_budget::Budget;
use nalgebra::Vector3;

use super::{
    largest_force_n,
    quantities::{entry_metric, spread_counts, verdict_counts},
    text::{NO_DEFLECTION, best_entry, direction_text, infeasible_text, position_and_angles, robust_text, site_text},
};
use crate::{
    answer::{ShareWithin, budget::OfVerdict, cautions, clearance},
    files::words::{counted, millimetres, percent, position, typographic, with_minus_signs},
    page::headline::{Extreme, Headline, InTable, KeyNumber, State, Verdict, worst_judged},
    process::{Basis, ForceText, KnownForce, PathReference, file::NOT_CONTROLLED},
    questions::{
        path::report::facts_text,
        placement::{
            COORDINATES, Candidate, End, Entry, Evaluation, FeatureJob, Margin, Metric, Metrics, Origin,
            PlacementResults, PlacementStudy, Site, evaluate, is_angle, site::printed_text,
        },
        spread_report::{self, Along},
    },
    simulation::clearance::PathClearance,
};

/// Returns how many places the search looked at, and at how many of them the workpiece cannot be cut.
fn searched_text(results: &PlacementResults) -> String {
    let [_, pruned, infeasible] = verdict_counts(results);
    let mut searched = counted(results.cells.len(), "place");
    if pruned > 0 {
        searched += &format!(", {pruned} of them ruled out early");
    }
    if infeasible > 0 {
        searched += &format!(", at {infeasible} of them the workpiece cannot be cut");
    }
    searched
}

/// Returns the first screen: one sentence, key numbers and cautions.
pub(super) fn headline(results: &PlacementResults) -> Headline {
    let study = &results.study;
    let mut basis = searched_text(results);
    let Some((entry, evaluation)) = best_entry(results) else {
        let sentences = infeasible_text(results);
        let (first, rest) = sentences.split_once('\n').unwrap_or((&sentences, ""));
        let verdict = Verdict::new(State::Bad, "No place can be cut");
        return Headline::new(first, basis)
            .judged(verdict, false)
            .with_cautions(rest)
            .with_cautions(&cautions_text(study));
    };
    let uncertainty = study.features[0].tracked.uncertainty.as_deref();
    if !study.allowance.is_none() {
        let drawn = if entry.spread.is_some() { ", draws at the worst corner of that" } else { "" };
        basis += &format!(", clamped within {}{drawn}", study.allowance.text());
    }
    basis += &format!(", {}", spread_report::basis(uncertainty));
    let clamp = clamp_sentence(results, entry, evaluation);
    let (sentence, details, numbers): (String, String, Vec<KeyNumber>) = match &entry.spread {
        None => {
            let numbers =
                [uncompensated_number(study, entry, evaluation), compensated_number(study, entry, evaluation)];
            let worst = value_of(study, evaluation, Metric::WorstDeflection);
            let sentence = worst.map_or_else(
                || "Best place found; how far the tool is off is not known.".into(),
                |worst| match value_of(study, evaluation, Metric::WorstResidual) {
                    Some(residual) => format!("Best place: {worst} off at most, {residual} once compensated."),
                    None => format!("Best place: {worst} off at most{}.", gain_text(results, entry, evaluation)),
                },
            );
            // A long name of a place stands below.
            match sentence.split(' ').count() <= MAX_WORDS {
                true => (sentence, String::new(), numbers.into_iter().flatten().collect()),
                false => {
                    let short = sentence.split_inclusive(',').next().unwrap_or_default().trim_end_matches(',');
                    (format!("{short}."), clamp, numbers.into_iter().flatten().collect())
                }
            }
        }
        Some(spread) => {
            let verdict = spread_report::along_verdict(&along(study), &spread.largest);
            let mut numbers = spread_report::along_numbers(&along(study), &spread.largest);
            if study.has_limits() {
                // Limits touch that without compensation, the last, in nothing.
                numbers.drain(..numbers.len() - 1);
                numbers.extend(compensated_number(study, entry, evaluation));
            }
            (spread_report::along_sentence(&along(study), &spread.largest), format!("{verdict} {clamp}"), numbers)
        }
    };
    let spread_cautions = entry.spread.as_ref().map_or_else(String::new, |spread| {
        spread_report::along_cautions(&along(study), Some(&spread.largest))
            + &spread_report::cautions(
                uncertainty,
                &spread_counts(results),
                "place",
                spread_report::next_along(Some(&spread.largest)).as_deref(),
            )
    });
    let (place, angles) = position_and_angles(entry.site.shown());
    let at = if angles.is_empty() { angles } else { format!(" at {angles}") };
    let place =
        KeyNumber::new(&place, format!("{}{at}{}", origin_text(study), gamma_text(study, entry)), room_text(results));
    let mut numbers: Vec<KeyNumber> = [place].into_iter().chain(numbers).chain(margin_number(results)).collect();
    let more: String = numbers.drain(MAX_NUMBERS.min(numbers.len())..).map(|own| number_sentence(&own)).collect();
    Headline::new(sentence, basis)
        .judged(state(results, entry, evaluation), entry.spread.is_none())
        .marked("simulated")
        .next(next_step(results))
        .with_cautions(&force_text(study, |own| &own.unknown))
        .with_cautions(&details)
        .with_cautions(&more)
        .with_cautions(&robust_text(results))
        .with_cautions(&clearance_text(results))
        .with_cautions(&spread_cautions)
        .with_cautions(&force_text(study, |own| &own.of_turn))
        .with_cautions(&cautions_text(study))
        .with_cautions(&not_corrected(evaluation))
        .with_numbers(numbers)
        .where_force_is(known_force(study))
        .resting_on(&budget(results, entry), &judged(study, entry, evaluation))
}

/// Returns what to do next: search farther where the search or the machine ended at the best place, else cut there.
fn next_step(results: &PlacementResults) -> String {
    let towards = |is_meant: fn(&Margin) -> bool| -> Vec<String> {
        results.flatness.iter().filter(|own| is_meant(own)).map(direction_text).collect()
    };
    match (towards(|own| own.is_better_beyond && is_none(own)).as_slice(), towards(is_blocked).as_slice()) {
        ([], []) => "put this placement into the process file, and write the compensated program with it.".into(),
        ([], blocked) => {
            format!("make room towards {}, and search again: nobody clamps so exactly.", blocked.join(", "))
        }
        (bounds, _) => {
            format!("widen the bounds towards {} if the machine allows, and search again.", bounds.join(", "))
        }
    }
}

/// Words of the first sentence, units by themselves.
const MAX_WORDS: usize = 14;

/// Key numbers of the first screen; what is beyond is told behind.
const MAX_NUMBERS: usize = 3;

/// Returns a key number as a sentence.
fn number_sentence(number: &KeyNumber) -> String {
    let against = if number.against.is_empty() { String::new() } else { format!(" ({})", number.against) };
    format!("{}: {}{against}.\n", number.shown(), number.what)
}

/// Returns the verdict on the best place in a few words; one at the bound of the search is not the best for sure.
fn state(results: &PlacementResults, entry: &Entry, evaluation: &Evaluation) -> Verdict {
    let study = &results.study;
    let share = |metric| evaluation.metrics.get(metric);
    let judged = match &entry.spread {
        Some(spread) => spread_report::along_state(&along(study), &spread.largest),
        None if share(Metric::ShareWithin) == Some(1.0) => {
            Verdict::new(State::Good, "Within tolerance without compensation")
        }
        None => match share(Metric::ShareWithinCorrected) {
            Some(1.0) => Verdict::new(State::Good, "Within tolerance once compensated"),
            Some(corrected) => Verdict::of_share(Some(corrected), common_tolerance(study), "the path"),
            // Without limits compensation leaves nothing.
            None if study.has_limits() || share(Metric::WorstCorrection).is_none() => {
                Verdict::of_share(share(Metric::ShareWithin), common_tolerance(study), "the path")
            }
            None => Verdict::new(State::Good, "Within tolerance once compensated"),
        },
    };
    match judged.state {
        State::Good | State::Partly if results.flatness.iter().any(is_at_bound) => {
            Verdict::new(State::Partly, "Best place lies at the search bound")
        }
        State::Good => match results.flatness.iter().find(|own| is_blocked(own)) {
            Some(blocked) => Verdict::new(
                State::Partly,
                format!("Within tolerance, but no room towards {}", direction_text(blocked)),
            ),
            None => judged,
        },
        _ => judged,
    }
}

/// Whether the best place is at the end of what was searched.
fn is_at_bound(margin: &Margin) -> bool {
    margin.end == End::Bound && is_none(margin)
}

/// Whether the workpiece cannot be cut right beyond the best place: at a travel, a box, the edge of the table.
fn is_blocked(margin: &Margin) -> bool {
    matches!(margin.end, End::Infeasible(_)) && is_none(margin)
}

/// Returns the number that first sentence, key numbers and figure tell of a place: the largest distance from the path, with uncertain inputs what it is
/// within with 95 % probability; `None` where there is none.
pub(super) fn distance_text(study: &PlacementStudy, entry: &Entry) -> Option<String> {
    match &entry.spread {
        Some(spread) => {
            let judged = spread.largest.compensated.as_ref().filter(|_| !study.has_limits());
            let p95 = judged.unwrap_or(&spread.largest.plain).spread.p95_mm?;
            Some(format!("with 95 % within {}", millimetres(p95, 3)))
        }
        None => Some(value_of(study, entry.feasible()?, Metric::WorstDeflection)? + " off at most"),
    }
}

/// Returns how near bodies come at the best place, and what of them is not known, in sentences; empty without bodies.
fn clearance_text(results: &PlacementResults) -> String {
    let of = |(job, own): (&FeatureJob, &Option<(Site, PathClearance)>)| {
        let place = |k: usize| format!("point {k} of {}", job.feature.name);
        own.as_ref().map_or_else(String::new, |(_, own)| clearance::sentences(own, place))
    };
    let mut told: Vec<String> = results.study.features.iter().zip(&results.clearance).map(of).collect();
    told.dedup();
    told.concat()
}

/// Returns the cautions for any placement: the workpiece carrier, an assumed workspace box, and axes that the drives do not control.
pub fn cautions_text(study: &PlacementStudy) -> String {
    let words = study.machine.uncontrolled_text().map(|words| (NOT_CONTROLLED, words));
    cautions::carrier(&study.machine) + &cautions::assumed_workspace(&study.machine) + &facts_text(words.as_slice())
}

/// Returns what the verdict on the best place rests on, with what is judged there; `None` where nothing can be cut.
pub(super) fn of_verdict<'a>(results: &'a PlacementResults, budget: &'a mut Budget) -> Option<OfVerdict<'a>> {
    let (study, (entry, evaluation)) = (&results.study, best_entry(results)?);
    *budget = self::budget(results, entry);
    let worst = worst_judged(budget, &judged(study, entry, evaluation));
    let compensated =
        entry.spread.as_ref().filter(|_| !study.has_limits()).and_then(|own| own.largest.compensated.as_ref());
    let shares = compensated.and_then(|own| own.shares.as_ref());
    Some(OfVerdict { budget, shares, judged_mm: worst.map(|own| own.0), tolerance_mm: worst.map(|own| own.1) })
}

/// Returns what the verdict rests on: of several features, what is known worst.
fn budget(results: &PlacementResults, entry: &Entry) -> Budget {
    let PlacementResults { study, clearance, .. } = results;
    let of = |job: &FeatureJob| {
        let known = job.force_text.known;
        let force = (largest_force_n(job) > 0.0 || known != KnownForce::Everywhere).then_some(known);
        let (machine, errors) = (job.machine(), &job.tracked.errors[..]);
        let uncertainty = job.tracked.uncertainty.as_deref().filter(|_| entry.spread.is_some());
        // The correction within limits does not know it.
        let open_backlash_mm = entry.feasible().filter(|_| !study.has_limits()).and_then(|own| own.open_backlash_mm);
        let fastest_mm_per_s = job.feature.path.largest_cutting_feed_mm_per_min().map(|own| own / 60.0);
        Basis { machine, errors, uncertainty, force, open_backlash_mm, fastest_mm_per_s, is_written: false }
            .budget(&job.verdict)
    };
    let of_bodies = |(budget, own): (Budget, &Option<(Site, PathClearance)>)| {
        clearance::in_budget(budget, own.as_ref().map(|own| &own.1))
    };
    let all = study.features.iter().map(of).zip(clearance.iter().chain(std::iter::repeat(&None))).map(of_bodies);
    all.reduce(Budget::worse).unwrap_or_default()
}

/// Returns the distances from the path by which a place is judged, mm, with their tolerances: of all features together where inputs are uncertain, else of each.
fn judged(study: &PlacementStudy, entry: &Entry, evaluation: &Evaluation) -> Vec<(Option<f64>, Option<f64>)> {
    if let Some(spread) = &entry.spread {
        let compensated = spread.largest.compensated.as_ref().filter(|_| !study.has_limits());
        let least = study.features.iter().map(|job| job.feature.tolerance_mm).reduce(f64::min);
        return vec![(compensated.unwrap_or(&spread.largest.plain).spread.p95_mm, least)];
    }
    if study.has_limits() {
        let left = [Metric::WorstResidual, Metric::WorstDeflection].map(|own| evaluation.metrics.get(own));
        let least = study.features.iter().map(|job| job.feature.tolerance_mm).reduce(f64::min);
        return vec![(left[0].or(left[1]), least)];
    }
    let is_exact = study.machine.uncontrolled_text().is_none();
    let of = |(job, metrics): (&FeatureJob, &Metrics)| {
        // Without limits compensation leaves nothing.
        let left = match is_exact && evaluation.metrics.get(Metric::WorstCorrection).is_some() {
            true => Some(0.0),
            false => metrics.get(Metric::WorstDeflection),
        };
        (left, Some(job.feature.tolerance_mm))
    };
    study.features.iter().zip(&evaluation.features).map(of).collect()
}

/// Returns how much of the force is known on the feature of which least is.
pub fn known_force(study: &PlacementStudy) -> KnownForce {
    study.features.iter().map(|job| job.force_text.known).max().unwrap_or_default()
}

/// Returns what is to be known of the force on each feature, with its name if there are several.
pub fn force_text(study: &PlacementStudy, of: impl Fn(&ForceText) -> &String) -> String {
    let several = study.features.len() > 1;
    let named = |job: &FeatureJob| match of(&job.force_text) {
        text if several && !text.is_empty() => format!("{}: {text}", job.feature.name),
        text => text.clone(),
    };
    study.features.iter().map(named).collect()
}

/// Returns the caution that there is no correction within the limits, and why; empty if there is one or none was sought.
fn not_corrected(evaluation: &Evaluation) -> String {
    let reason = evaluation.not_corrected.as_ref();
    reason.map_or_else(String::new, |reason| format!("There is no correction within the limits: {reason}.\n"))
}

/// Returns the names of the paths and their commands for sentences about distributions along them, and why they are not judged, if so.
pub(super) fn along(study: &PlacementStudy) -> Along<'_> {
    let points = study.features.iter().map(|job| evaluate::counted_flags(job).into_iter().filter(|flag| *flag).count());
    Along {
        machine: &study.machine,
        path: format!("the {}", part(study)),
        // The distribution is of the exact correction.
        commands: if study.has_limits() { "compensated without the limits given" } else { "compensated" },
        missing: "could not be compensated",
        points: points.sum(),
        uncertainty: study.features[0].tracked.uncertainty.as_deref(),
        tolerance_mm: common_tolerance(study),
        unjudged: match common_tolerance(study) {
            _ if study.features.iter().all(cuts_nowhere) => Some(spread_report::NOTHING_CUT),
            _ if study.features.iter().all(|job| largest_force_n(job) == 0.0) => Some(spread_report::NO_FORCE),
            _ if study.has_limits() => Some("The limits given are in no distribution"),
            None => Some("The features have different tolerances"),
            Some(_) => None,
        },
        without_force: None,
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

/// Formats the value of `metric` with its unit; `None` where it was not computed or does not exist.
fn value_of(study: &PlacementStudy, evaluation: &Evaluation, metric: Metric) -> Option<String> {
    Some(metric.value_text(&study.machine, evaluation.metrics.get(metric)?))
}

/// Returns the sentence of the first screen: where to clamp, and unless a verdict by the distribution says it, how far the tool leaves its path.
fn clamp_sentence(results: &PlacementResults, entry: &Entry, evaluation: &Evaluation) -> String {
    let study = &results.study;
    let how = if platform_offset(study).is_some() { "with P at" } else { "with its origin at" };
    let (site, gamma) = (site_text(&entry.site), gamma_text(study, entry));
    let mut text = format!("Clamp the {} {how} {site}{gamma}", part(study));
    if entry.spread.is_some() {
        return text + ".";
    }
    if let Some(worst) = value_of(study, evaluation, Metric::WorstDeflection) {
        let gain = gain_text(results, entry, evaluation);
        let is_programmed = |named: &Candidate| !named.at_best_gamma && gain.ends_with(&named.name);
        let has_note = study.seeks_gamma() && study.candidates.iter().any(is_programmed);
        let note = if has_note { " (as programmed)" } else { "" };
        text += &format!(": the tool leaves its path by at most {worst}{gain}{note}");
    }
    match (value_of(study, evaluation, Metric::WorstResidual), value_of(study, evaluation, Metric::WorstCorrection)) {
        (Some(residual), _) => text += &format!(", and {residual} after compensation"),
        (None, Some(correction)) => text += &format!("; drive corrections of up to {correction} keep it there"),
        _ => {}
    }
    text + "."
}

/// Returns the tool tip from P at home, O axes, mm, where paths give positions of P and not of the tip; `None` where they do, or it is at P.
pub(super) fn platform_offset(study: &PlacementStudy) -> Option<Vector3<f64>> {
    let is_of_platform = study.features[0].feature.reference == PathReference::PlatformPoint;
    Some(study.machine.home.pose.rotation * study.machine.tool_tip).filter(|tip| is_of_platform && tip.norm() > 0.0)
}

/// Describes whose position a place is: that of the part's origin, or of P there.
fn origin_text(study: &PlacementStudy) -> String {
    match platform_offset(study) {
        None => format!("where to clamp the origin of the {}", part(study)),
        Some(tip) => {
            let tip = position(tip.x, tip.y, tip.z);
            format!("where P is at the origin of the {}, which is at the tool tip: {tip} from P", part(study))
        }
    }
}

/// Describes the γ of each feature at a place; empty where none is sought.
fn gamma_text(study: &PlacementStudy, entry: &Entry) -> String {
    let gamma = |(job, gamma): (&FeatureJob, &Option<f64>)| {
        let degrees = printed_text((1e9 * gamma.as_ref()?.to_degrees()).round() / 1e9);
        Some((job.feature.name.clone(), typographic(&format!("{}°", degrees.trim_end_matches(".0")))))
    };
    let gammas: Vec<(String, String)> = study.features.iter().zip(&entry.gammas).filter_map(gamma).collect();
    match gammas.as_slice() {
        [] => String::new(),
        [(_, gamma)] => format!(", the arm rotated about its tool by γ = {gamma}"),
        several => {
            let each: Vec<String> = several.iter().map(|(name, gamma)| format!("{gamma} in {name}")).collect();
            format!(", the arm rotated about its tool by γ = {}", each.join(", "))
        }
    }
}

/// Describes how much smaller the worst deflection is than at the first other named place that can be cut.
fn gain_text(results: &PlacementResults, entry: &Entry, evaluation: &Evaluation) -> String {
    let study = &results.study;
    let worst = |evaluation: &Evaluation| evaluation.metrics.get(Metric::WorstDeflection);
    let named = study.candidates.iter().filter_map(|candidate| {
        let named_entry =
            results.entries.iter().find(|other| other.name == candidate.name && other.found == Origin::Named)?;
        Some((&named_entry.name, worst(named_entry.feasible()?)?)).filter(|_| named_entry.name != entry.name)
    });
    let (Some((name, at_named)), Some(at_entry)) = (named.into_iter().next(), worst(evaluation)) else {
        return String::new();
    };
    match 1.0 - at_entry / at_named {
        _ if at_named <= NO_DEFLECTION => String::new(),
        gain if gain >= 0.005 => format!(", {:.0} % less than {name}", 100.0 * gain),
        gain if gain <= -0.005 => format!(", {:.0} % more than {name}", -100.0 * gain),
        _ => format!(", no less than {name}"),
    }
}

/// Returns the tolerance that all features have, mm; `None` if they differ.
fn common_tolerance(study: &PlacementStudy) -> Option<f64> {
    let mut tolerances = study.features.iter().map(|job| job.feature.tolerance_mm);
    let first = tolerances.next()?;
    tolerances.all(|other| other == first).then_some(first)
}

/// Describes on which `share` of the path the tolerances are met, where the tool is `worst_mm` off at its worst.
fn tolerance_text(study: &PlacementStudy, share: Option<f64>, worst_mm: Option<f64>) -> String {
    match (share, common_tolerance(study)) {
        (None, _) => String::new(),
        (Some(share), tolerance @ Some(_)) => ShareWithin::of_all(share)
            .against(tolerance, worst_mm.unwrap_or_default(), "on … of the path")
            .unwrap_or_default(),
        (Some(share), None) => format!("within the tolerances of the features on {} of the path", percent(share)),
    }
}

/// Returns the reference to the `value` of a metric of `entry` in `candidates.csv`.
fn in_candidates_table(study: &PlacementStudy, entry: &Entry, metric: Metric, value: f64) -> InTable {
    let rows = [["name", entry.name.as_str()]];
    entry_metric(study, metric).found_in("candidates.csv", &rows, Extreme::Largest, value)
}

/// Returns the key number of the worst deflection without compensation; `None` if it was not computed.
fn uncompensated_number(study: &PlacementStudy, entry: &Entry, evaluation: &Evaluation) -> Option<KeyNumber> {
    let metric = Metric::WorstDeflection;
    let against = tolerance_text(study, evaluation.metrics.get(Metric::ShareWithin), evaluation.metrics.get(metric));
    let number = KeyNumber::new(
        &value_of(study, evaluation, metric)?,
        "largest distance of the tool from its path, without compensation",
        against,
    );
    let value = evaluation.metrics.get(metric)?;
    Some(number.held_to(common_tolerance(study), value).found(in_candidates_table(study, entry, metric, value)))
}

/// Returns the key number of the worst residual error within limits; without limits, of the largest correction; `None` if neither was computed.
fn compensated_number(study: &PlacementStudy, entry: &Entry, evaluation: &Evaluation) -> Option<KeyNumber> {
    let words_of = |metric| value_of(study, evaluation, metric);
    let metric = match evaluation.metrics.get(Metric::WorstResidual) {
        Some(_) => Metric::WorstResidual,
        None => Metric::WorstCorrection,
    };
    let (what, against) = match metric {
        Metric::WorstResidual => (
            "largest distance after compensation within the limits given".to_string(),
            tolerance_text(study, evaluation.metrics.get(Metric::ShareWithinCorrected), evaluation.metrics.get(metric)),
        ),
        _ => {
            let force = words_of(Metric::WorstDriveForce).map(|force| format!("drives carry up to {force}"));
            ("largest drive correction that keeps the tool on its path".into(), force.unwrap_or_default())
        }
    };
    let (number, value) = (KeyNumber::new(&words_of(metric)?, what, against), evaluation.metrics.get(metric)?);
    let tolerance = common_tolerance(study).filter(|_| metric == Metric::WorstResidual);
    Some(number.held_to(tolerance, value).found(in_candidates_table(study, entry, metric, value)))
}

/// Margins below this are shown as none, mm.
const NO_ROOM_MM: f64 = 0.1;
/// Margins of angles below this are shown as none, degrees: no less than what places are rounded to.
const NO_ROOM_DEG: f64 = 0.1;

/// Whether a margin is shown as none.
fn is_none(margin: &Margin) -> bool {
    match is_angle(margin.coordinate) {
        true => margin.distance < NO_ROOM_DEG.to_radians(),
        false => margin.distance < NO_ROOM_MM,
    }
}

/// Returns a margin, mm or degrees, in tenths, as what is said can be done.
pub(super) fn rounded_down(margin: f64) -> f64 {
    (10.0 * margin + 1e-9).floor() / 10.0
}

/// Returns how far from the best place the workpiece may be clamped along each coordinate that is sought, rounded down; empty where none is.
fn room_text(results: &PlacementResults) -> String {
    let way = |i: usize, sign: f64| results.flatness.iter().find(|own| own.coordinate == i && own.direction == sign);
    let range = |i: usize| {
        let (before, behind) = (way(i, -1.0)?, way(i, 1.0)?);
        if before.end == End::Nowhere {
            return Some(format!("any {}", COORDINATES[i]));
        }
        let [low, high] = [before, behind].map(|own| match is_angle(i) {
            true => rounded_down(own.distance.to_degrees()),
            false => rounded_down(own.distance),
        });
        let signed = |sign: &str, by: f64| if by == 0.0 { "0".into() } else { format!("{sign}{by}") };
        let range =
            if low == high { format!("±{low}") } else { format!("{} … {}", signed("−", low), signed("+", high)) };
        Some(format!("{} {range}{}", COORDINATES[i], if is_angle(i) { "°" } else { " mm" }))
    };
    let ranges: Vec<String> = results.study.bounds.free().into_iter().filter_map(range).collect();
    if ranges.is_empty() { String::new() } else { format!("room, each alone: {}", ranges.join(", ")) }
}

/// Returns the key number of the smallest margin of the best place along x, y or z, and of directions without any; `None` without such margins.
fn margin_number(results: &PlacementResults) -> Option<KeyNumber> {
    let (blocked, free): (Vec<&Margin>, Vec<&Margin>) = results.flatness.iter().partition(|margin| is_none(margin));
    let none: Vec<String> =
        blocked.iter().map(|margin| format!("none towards {}: {}", direction_text(margin), end_text(margin))).collect();
    let free = free.into_iter().filter(|margin| !is_angle(margin.coordinate));
    let Some(smallest) = free.min_by(|a, b| a.distance.total_cmp(&b.distance)) else {
        let is_blocked = blocked.iter().any(|margin| !is_angle(margin.coordinate));
        return is_blocked
            .then(|| KeyNumber::new("0.0 mm", "margin: the part fits there alone".to_owned(), none.join("; ")));
    };
    // What is said can be done.
    let distance = (10.0 * smallest.distance).floor() / 10.0;
    let least = if none.is_empty() { "least margin" } else { "least margin elsewhere" };
    let what = match &smallest.end {
        End::Worse => format!("{least} ({}), before the objective is 5 % worse", direction_text(smallest)),
        _ => format!("{least} ({}), then {}", direction_text(smallest), end_text(smallest)),
    };
    Some(KeyNumber::new(&format!("{distance:.1} mm"), what, none.join("; ")))
}

/// Describes why a margin ends.
fn end_text(margin: &Margin) -> String {
    match &margin.end {
        End::Worse => "the objective gets worse at once".into(),
        End::Bound => "the bound of the search".into(),
        End::Infeasible(reason) => with_minus_signs(reason),
        End::Nowhere => "nothing ends the margin".into(),
    }
}
