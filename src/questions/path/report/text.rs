//! Sentences of a path report: how far the tool leaves the path and where, why, and which commands compensate it.

use kinetostat_budget::Budget;

use super::{
    found_gamma,
    quantities::{DISPLACEMENT, RESIDUAL_ERROR, WITHOUT_FORCE},
    summary::Summary,
};
use crate::{
    answer::{
        Quantity, ReportText, Tolerance, acting_text,
        budget::OfVerdict,
        cautions::{self, OutsidePositions},
        clearance,
        drive_columns::kind_word,
        force_text,
    },
    files::{
        text_table::text_table,
        words::{counted, join_text, millimetres, millimetres_in_table, or_dash},
    },
    machine::Motion,
    page::headline::{Extreme, Headline, InTable, KeyNumber, State, Verdict},
    process::{Basis, KnownForce},
    questions::{
        path::{MethodAlongPath, PathStudy, PointEffect},
        spread_report::{self, Along},
    },
    redundancy,
    simulation::{ROUNDING_MM, Source, TrackedPath, along_path::PathSummary},
    spatial::Wrench,
};

/// Returns the sentences of the report for `summary`, which holds all points.
pub fn text(summary: &Summary<'_>) -> ReportText {
    ReportText {
        cautions: cautions_text(summary),
        place: displacement_text(summary, Source::All)
            + &summary.within.sentence(summary.study.tolerance_mm, OF_PATH)
            + &spread_text(summary),
        cause: cause_text(summary),
        remedy: remedy_text(summary),
    }
}

/// Describes point `k` of the path: program line, length along the path, and φ on a circle.
pub(super) fn point_text(summary: &Summary<'_>, k: usize) -> String {
    let station = &summary.study.stations[k];
    let angle = station.phi_deg.filter(|_| summary.shown.is_circle);
    let angle = angle.map(|phi| format!(" (tool angle φ = {phi:.0}°)")).unwrap_or_default();
    let file = station.file.checked_sub(1).and_then(|file| summary.study.called_files.get(file));
    let file = file.map_or_else(String::new, |file| format!("{file} "));
    let line = station.line.map(|line| format!("{file}line {line}, ")).unwrap_or_default();
    format!("{line}{:.1} mm along the path{angle}", station.arc_length_mm)
}

/// Returns the cautions of the report: failed points, the γ found, and what holds for any result along this path.
fn cautions_text(summary: &Summary<'_>) -> String {
    let study = summary.study;
    let failed = match summary.failed_count() {
        0 => String::new(),
        failed => {
            let points = counted(study.stations.len(), "point");
            format!("{failed} of {points} could not be compensated; the table of points says why.\n")
        }
    };
    let gamma = found_gamma(study).map_or_else(String::new, |(found, how)| redundancy::report::sentence(found, how));
    failed
        + &gamma
        + &play_text(summary)
        + &spread_report::along_cautions(&along(summary), summary.whole.as_ref())
        + &spread_report::cautions(
            study.uncertainty.as_deref(),
            summary.spread_counts(),
            "point",
            spread_report::next_along(summary.whole.as_ref()).as_deref(),
        )
        + &clearance_text(summary)
        + &path_cautions(study)
}

/// Returns what is known of the distances of bodies along the path, in sentences; empty where one hits, which is said first, and without bodies.
fn clearance_text(summary: &Summary<'_>) -> String {
    let own = summary.clearance.as_ref();
    own.map_or_else(String::new, |own| clearance::sentences(own, |k| point_text(summary, k)))
}

/// Returns what the play of the drives does along the path, in sentences; empty without play.
fn play_text(summary: &Summary<'_>) -> String {
    let taken_back = "it is in the distance as programmed, and the compensation takes it back";
    summary.play.sentences(taken_back, |k| point_text(summary, k))
}

/// Returns the sentences about the distribution of the distance from the path; empty where inputs are taken as exact.
fn spread_text(summary: &Summary<'_>) -> String {
    let Some(whole) = &summary.whole else { return String::new() };
    let mut text = spread_report::along_sentences(&along(summary), whole);
    if let Some((off, k)) = summary.largest(Source::All, &WITHOUT_FORCE) {
        text += &format!(
            "Where the force is absent (in air, in a spring pass, with a broken tool), the compensated commands lead the tool off by up to {}, {}.\n",
            millimetres(off, 3),
            point_text(summary, k)
        );
    }
    text + &summary.spread_counts().sentences("point")
}

/// Returns the names of the path and its commands for sentences about distributions along it, and why it is not judged, if so.
fn along<'a>(summary: &'a Summary<'_>) -> Along<'a> {
    Along {
        machine: &summary.study.machine,
        path: "this path".into(),
        commands: "compensated",
        missing: "could not be compensated",
        points: summary.study.stations.len(),
        uncertainty: summary.study.uncertainty.as_deref(),
        tolerance_mm: summary.study.tolerance_mm,
        unjudged: match (has_force(summary.study), outside_positions(summary.study).outside() == 0) {
            _ if summary.study.cuts_nowhere() => Some(spread_report::NOTHING_CUT),
            (false, _) => Some(spread_report::NO_FORCE),
            (true, false) => Some(spread_report::OUTSIDE),
            (true, true) => None,
        },
        without_force: summary.largest(Source::All, &WITHOUT_FORCE).map(|(off, k)| (off, point_text(summary, k))),
    }
}

/// Whether a cutting force is given at some point of the path.
fn has_force(study: &PathStudy) -> bool {
    study.tasks.iter().any(|task| task.load != Wrench::default())
}

/// Counts the positions outside the workspace box.
pub(crate) fn outside_positions(study: &PathStudy) -> OutsidePositions {
    OutsidePositions::of(&study.machine, study.positions())
}

/// Returns the cautions for any result along the path of `study`: about the machine, its errors and assumed values.
pub(crate) fn path_cautions(study: &PathStudy) -> String {
    cautions::machine_cautions(&study.machine, &study.errors, "path point", study.positions())
        + &facts_text(&study.assumed)
}

/// Returns the sentence about the largest displacement by `source`, and where; empty below rounding.
fn displacement_text(summary: &Summary<'_>, source: Source) -> String {
    match summary.largest(source, &DISPLACEMENT).filter(|(size, _)| *size > ROUNDING_MM) {
        None => String::new(),
        Some((size, k)) => {
            let cause = source.moves(&summary.study.machine);
            format!("{cause} by up to {}, {}.\n", millimetres(size, 3), point_text(summary, k))
        }
    }
}

/// Words for the share of the path on which the tolerance is met.
pub(super) const OF_PATH: &str = "on … of the path";

/// Returns the sentences about the single sources: their largest displacements, and what each does where all together are worst.
fn cause_text(summary: &Summary<'_>) -> String {
    let parts = Source::parts(&summary.study.machine).iter();
    let mut text: String = parts.clone().map(|source| displacement_text(summary, *source)).collect();
    let peaks: Vec<usize> =
        parts.filter_map(|source| summary.largest(*source, &DISPLACEMENT)).map(|(_, k)| k).collect();
    if peaks.windows(2).any(|pair| pair[0] != pair[1]) {
        text += "These largest values lie at different points: they do not add up to the largest by all sources.\n";
    }
    let shares = summary.single_sources.iter();
    let shares: Vec<String> =
        shares.map(|(source, size)| format!("{} {}", source.text(), millimetres(*size, 3))).collect();
    if let Some((_, k)) = summary.largest_displacement().filter(|_| shares.len() > 1) {
        let words: Vec<&str> = shares.iter().map(String::as_str).collect();
        text += &format!(
            "At the worst point, {}, each alone moves the tool by: {}.\n",
            point_text(summary, k),
            join_text(&words)
        );
    }
    text
}

/// Returns the sentences about the compensation: largest corrections, drive forces and residual error.
fn remedy_text(summary: &Summary<'_>) -> String {
    let machine = &summary.study.machine;
    let largest = |quantity: &Quantity<PointEffect>| summary.largest(Source::All, quantity);
    let sentence = |((kind, correction), (_, force)): (&(Motion, _), &(Motion, _))| {
        let ((correction, k), (force, kf)) = (largest(correction)?, largest(force)?);
        let drives = kind_word(machine, *kind);
        let of_kind = if machine.has_mixed_drives() { format!(" of {drives}") } else { String::new() };
        Some(format!(
            "To keep the tool on its path, correct the {drives} by up to {}, {}. Drive {}s{of_kind} then reach {}, {}.\n",
            kind.position_text(correction),
            point_text(summary, k),
            kind.force_word(),
            kind.force_text(force),
            point_text(summary, kf)
        ))
    };
    let mut text: String = summary.drives.corrections.iter().zip(&summary.drives.forces).filter_map(sentence).collect();
    if let (Some(axes), Some((residual, k))) = (machine.uncontrolled_names(), largest(&RESIDUAL_ERROR)) {
        let (residual, place) = (millimetres(residual, 3), point_text(summary, k));
        text += &format!("The residual error is up to {residual}, {place}: the drives do not control {axes}.\n");
    }
    text
}

/// Formats labelled facts as sentences: where the workpiece stands and what is cut.
pub fn facts_text(facts: &[(impl AsRef<str>, String)]) -> String {
    let sentence = |(label, words): &(_, String)| {
        let (first, rest) = AsRef::<str>::as_ref(label).split_at(1);
        format!("{}{rest}: {words}.\n", first.to_uppercase())
    };
    facts.iter().map(sentence).collect()
}

/// Returns a table that compares the compensation methods, and why they failed where they did.
pub(super) fn methods_text(methods: &[MethodAlongPath]) -> String {
    let mut table = text_table(["method", "steps per point", "largest error", "rms error", "failed"], 1);
    for method in methods {
        let s = &method.summary;
        table.add_row([
            method.method.label(),
            or_dash(s.mean_corrections, |mean| format!("{mean:.2}")),
            or_dash(s.max_mm, |max| millimetres_in_table(max, 4)),
            or_dash(s.rms_mm, |rms| millimetres_in_table(rms, 4)),
            format!("{} of {}", s.failed, s.points),
        ]);
    }
    format!(
        "Methods of compensation: steps each takes per point, and how far the tool then is from the path.\n{table}\n{}",
        failures_text(methods.iter().map(|method| (method.method.label(), &method.summary)))
    )
}

/// Returns a sentence for each pass that failed somewhere: at how many points, and the first reason.
pub fn failures_text<'a>(passes: impl Iterator<Item = (String, &'a PathSummary)>) -> String {
    let sentence = |(name, summary): (String, &PathSummary)| {
        let reason = summary.first_failure.as_ref()?;
        let points = counted(summary.points, "point");
        Some(format!("{name} fails at {} of {points}; the first: {reason}.\n", summary.failed))
    };
    passes.filter_map(sentence).collect()
}

/// Returns the first screen: one sentence, key numbers and cautions; where bodies hit, that first.
pub fn headline(summary: &Summary<'_>, text: &ReportText) -> Headline {
    let own = headline_of_tool(summary, text);
    let hit = summary.clearance.as_ref().and_then(|clearance| {
        let sentence = clearance.hit_text(|k| format!("on the way to {}", point_text(summary, k)))? + ".";
        Some((sentence, clearance::verdict(clearance)?))
    });
    match hit {
        Some((sentence, verdict)) => own.barred(sentence, verdict, clearance::MOVE_AWAY),
        None => own,
    }
}

/// Returns the first screen as far as the tool goes.
fn headline_of_tool(summary: &Summary<'_>, text: &ReportText) -> Headline {
    let study = summary.study;
    let basis = format!(
        "a path of {:.1} mm, {}, {}, {}",
        study.length_mm(),
        counted(study.stations.len(), "point"),
        force_text("up to ", study.tasks.iter().map(|task| task.load.force.norm()).fold(0.0, f64::max)),
        spread_report::basis(study.uncertainty.as_deref())
    );
    let name = &study.machine.name;
    let Some((worst, k)) = summary.largest_displacement() else {
        let sentence = format!("How far the tool of {name} leaves the path could be computed at none of its points.");
        let verdict = Verdict::new(State::Bad, "Nothing could be computed");
        return Headline::new(sentence, basis).judged(verdict, false).with_cautions(&text.cautions);
    };
    let positions = outside_positions(study);
    let verdict = positions.verdict(&study.machine, "this path");
    let cannot_be_run = positions.sentence(&study.machine);
    let next = next_step(&positions, summary);
    if let Some(([short, sure], numbers)) = spread_headline(summary) {
        return Headline::new(cannot_be_run.unwrap_or(short), basis)
            .judged(state(&positions, summary), false)
            .marked("simulated")
            .next(next)
            .with_cautions(&(verdict + &sure))
            .with_cautions(&text.cautions)
            .with_numbers(numbers)
            .where_force_is(study.known_force)
            .resting_on(&budget(summary), &[(judged_mm(summary), study.tolerance_mm)]);
    }
    let acting = acting_text(&study.machine, &study.errors, has_force(study)).to_lowercase();
    let off = millimetres(worst, 3);
    let residual = summary.largest(Source::All, &RESIDUAL_ERROR).map(|(residual, _)| residual);
    let then = match residual {
        Some(residual) if residual <= ROUNDING_MM => "compensated, it stays on the path".into(),
        Some(residual) => format!("compensated, by {}", millimetres(residual, 4)),
        None => "no compensation was found".into(),
    };
    let is_barred = cannot_be_run.is_some();
    let sentence = cannot_be_run.unwrap_or_else(|| format!("Tool off by up to {off}; {then}."));
    let against = summary.within.against(study.tolerance_mm, worst, OF_PATH).unwrap_or_default();
    let what = format!("largest distance from the path {acting}, without compensation, {}", point_text(summary, k));
    let number = KeyNumber::new(&off, what, against);
    Headline::new(sentence, basis)
        .judged(state(&positions, summary), true)
        .marked("simulated")
        .next(next)
        .with_cautions(&verdict)
        .with_cautions(&text.cautions)
        .with(number.held_to(study.tolerance_mm, worst).found(in_points_table(&DISPLACEMENT, worst)))
        .with_numbers(residual.map(|residual| {
            let number = residual_number(summary, residual);
            // Nothing is good on a path that cannot be run.
            if is_barred { KeyNumber { state: None, ..number } } else { number }
        }))
        .with_numbers(correction_number(summary))
        .where_force_is(study.known_force)
        .resting_on(&budget(summary), &[(judged_mm(summary), study.tolerance_mm)])
}

/// What to do next where positions are outside the workspace box.
pub(crate) const MOVE_INSIDE: &str = "move the workpiece into the workspace box: a placement study finds where.";

/// Returns what to do next.
fn next_step(positions: &OutsidePositions, summary: &Summary<'_>) -> &'static str {
    match (positions.outside(), summary.failed_count()) {
        (1.., _) => MOVE_INSIDE,
        (0, 1..) => "see in points.csv why points fail, and place the workpiece where none does.",
        (0, 0) => "write the compensated program of this path with kinetostat compensate.",
    }
}

/// Returns what the verdict rests on.
pub(super) fn budget(summary: &Summary<'_>) -> Budget {
    let study = summary.study;
    let force = (has_force(study) || study.known_force != KnownForce::Everywhere).then_some(study.known_force);
    let (TrackedPath { machine, errors, .. }, verdict) = (&study.tracked, &study.verdict);
    let uncertainty = study.uncertainty.as_deref().filter(|_| summary.whole.is_some());
    let open_backlash_mm = summary.play.open_mm();
    let fastest_mm_per_s = study.fastest_mm_per_s;
    let basis = Basis { machine, errors, uncertainty, force, open_backlash_mm, fastest_mm_per_s, is_written: false };
    clearance::in_budget(basis.budget(verdict), summary.clearance.as_ref())
}

/// Returns what the verdict rests on, with what is judged.
pub(super) fn of_verdict<'a>(summary: &'a Summary<'_>, budget: &'a Budget) -> OfVerdict<'a> {
    let compensated = summary.whole.as_ref().and_then(|own| own.compensated.as_ref());
    OfVerdict {
        budget,
        shares: compensated.and_then(|own| own.shares.as_ref()),
        judged_mm: judged_mm(summary),
        tolerance_mm: summary.study.tolerance_mm,
    }
}

/// Returns the distance from the path by which it is judged, mm, compensated where that is known: what is not exceeded with 95 % probability, or with
/// nominal inputs the largest; `None` where more than 5 % of the draws, or with nominal inputs all points, have no equilibrium.
fn judged_mm(summary: &Summary<'_>) -> Option<f64> {
    match &summary.whole {
        Some(whole) => whole.compensated.as_ref().unwrap_or(&whole.plain).spread.p95_mm,
        None => summary.largest(Source::All, &RESIDUAL_ERROR).or(summary.largest_displacement()).map(|found| found.0),
    }
}

/// Returns the verdict on the path as compensated, in a few words.
fn state(positions: &OutsidePositions, summary: &Summary<'_>) -> Verdict {
    let study = summary.study;
    let points = study.stations.len();
    let left = summary.largest(Source::All, &RESIDUAL_ERROR).map(|(left, _)| left);
    if positions.outside() > 0 {
        return positions.state(&study.machine);
    }
    match (&summary.whole, summary.failed_count(), study.tolerance_mm, left) {
        (Some(whole), ..) => spread_report::along_state(&along(summary), whole),
        _ if study.cuts_nowhere() => Verdict::new(State::Bad, "No motion counts as cutting"),
        (None, failed @ 1.., ..) => Verdict::new(State::Bad, format!("{failed} of {points} points not compensated")),
        (None, 0, None, _) => Verdict::new(State::Open, "No tolerance given"),
        (None, 0, Some(_), _) if summary.within.get() == Some(1.0) => {
            Verdict::new(State::Good, "Within tolerance without compensation")
        }
        (None, 0, Some(tolerance), Some(left)) if left <= tolerance => {
            Verdict::new(State::Good, "Within tolerance once compensated")
        }
        (None, 0, Some(_), _) => Verdict::new(State::Bad, "Out of tolerance, also compensated"),
    }
}

/// Returns the first sentence and the verdict by the distribution of the largest distance after compensation, and its key numbers; `None` where inputs are taken as exact.
fn spread_headline(summary: &Summary<'_>) -> Option<([String; 2], Vec<KeyNumber>)> {
    let whole = summary.whole.as_ref()?;
    let (along, mut numbers) = (along(summary), spread_report::along_numbers(&along(summary), whole));
    numbers.extend(along.without_force_number(|off| in_points_table(&WITHOUT_FORCE, off)));
    Some(([spread_report::along_sentence(&along, whole), spread_report::along_verdict(&along, whole)], numbers))
}

/// Returns the reference to the largest `value` of `quantity` by all sources in `points.csv`.
fn in_points_table(quantity: &Quantity<PointEffect>, value: f64) -> InTable {
    quantity.found_in("points.csv", &[["source", Source::All.label()]], Extreme::Largest, value)
}

/// Returns the key number of `mm`, the largest residual error after compensation, mm.
fn residual_number(summary: &Summary<'_>, mm: f64) -> KeyNumber {
    let against = summary.study.tolerance_mm.map(|tolerance| Tolerance(tolerance).against(mm)).unwrap_or_default();
    let points = summary.study.stations.len();
    let what = match summary.failed_count() {
        0 => "largest residual error, with compensation".to_string(),
        failed => {
            format!("largest residual error at the {} of {points} points that could be compensated", points - failed)
        }
    };
    KeyNumber::new(&millimetres(mm, 4), what, against)
        .held_to(summary.study.tolerance_mm, mm)
        .found(in_points_table(&RESIDUAL_ERROR, mm))
}

/// Returns the key number of the largest drive correction, of prismatic joints where the machine has prismatic and revolute joints, with the drive
/// force; `None` where no point has one.
fn correction_number(summary: &Summary<'_>) -> Option<KeyNumber> {
    let machine = &summary.study.machine;
    let largest = |quantity: &Quantity<PointEffect>| Some(summary.largest(Source::All, quantity)?.0);
    let kinds = summary.drives.corrections.iter().zip(&summary.drives.forces);
    let mut kinds = kinds.filter_map(|((kind, own), (_, force))| Some((*kind, own, largest(own)?, largest(force)?)));
    let (kind, quantity, correction, force) = kinds.next()?;
    let drives = if machine.has_mixed_drives() { kind_word(machine, kind) } else { "drive" };
    let others: String = kinds
        .map(|(kind, _, correction, _)| format!("; {} {}", kind_word(machine, kind), kind.position_text(correction)))
        .collect();
    let against = format!("drive {}s up to {}{others}", kind.force_word(), kind.force_text(force));
    let number = KeyNumber::new(&kind.position_text(correction), format!("largest {drives} correction"), against);
    Some(number.found(in_points_table(quantity, correction)))
}
