//! Sentences and first screen of a map: best and worst deflection over the workspace, and the corrections of the drives.

use super::{
    quantities::{DEFLECTION, P95_DEFLECTION, RESIDUAL_ERROR, SUPERPOSITION_ERROR, SUPERPOSITION_ERROR_SHARE},
    summary::{AtAngle, SourceExtremes, Summary},
};
use crate::{
    answer::{Quantity, ReportText, Tolerance, ValueAt, acting_text, drive_columns::kind_word, force_text},
    files::words::{counted, millimetres, percent},
    machine::{Machine, Motion},
    page::headline::{Extreme, Headline, InTable, KeyNumber, State, Verdict},
    questions::{
        map::{SourceEffect, WorkspaceMapStudy},
        spread_report,
    },
    simulation::{ROUNDING_MM, Source},
};

/// Returns the sentences of the report for `summary`, which holds all points of a map.
pub fn text(summary: &Summary<'_>, not_used: &[&str]) -> ReportText {
    ReportText {
        cautions: cautions_text(summary, not_used),
        place: deflection_text(summary, Source::All)
            + &summary.within.sentence(summary.study.load_case.tolerance_mm, BOX)
            + &spread_text(summary),
        cause: cause_text(summary),
        remedy: corrections_text(summary),
    }
}

/// Returns the cautions of the report: missing corrections, unused process tables, and those of the load case.
fn cautions_text(summary: &Summary<'_>, not_used: &[&str]) -> String {
    let WorkspaceMapStudy { load_case, grid, .. } = summary.study;
    let missing = match summary.uncorrected_rows() {
        0 => String::new(),
        rows => format!("At {} the correction is missing; the deflection is known.\n", counted(rows, "row")),
    };
    missing
        + &spread_report::setups_left_out(summary.study.uncertainty.as_ref(), "the map")
        + &spread_report::cautions(
            summary.study.uncertainty.as_ref(),
            &summary.spread,
            "point",
            next_step(summary).as_deref(),
        )
        + &load_case.cautions(not_used, "grid point", (0..grid.len()).map(|index| grid.position(index)))
}

/// Returns the sentence about the deflection by `source` at the best and at the worst grid point.
fn deflection_text(summary: &Summary<'_>, source: Source) -> String {
    let (sums, cause) = (summary.of(source), source.moves(&summary.study.load_case.machine));
    let Some([least, most]) = sums.of(&DEFLECTION).filter(|_| summary.is_enough(sums.known)) else {
        return format!(
            "{cause}: known at {} of {}, too few to speak of best and worst.\n",
            sums.known,
            counted(summary.study.grid.len(), "grid point")
        );
    };
    let phi = most.at.phi_deg.map_or_else(String::new, |phi| format!(" (tool angle φ = {phi:.0}°)"));
    if most.value <= ROUNDING_MM {
        return String::new();
    }
    let [low, high] = [least, most].map(|found| millimetres(found.value, 3));
    match low == high {
        true => format!("{cause} by {high} everywhere.\n"),
        false => format!(
            "{cause} by {low} at the best place, {}, and by {high} at the worst, {}{phi}.\n",
            least.tip(),
            most.tip()
        ),
    }
}

/// Returns the sentences about the distribution of the deflection; empty where inputs are taken as exact.
fn spread_text(summary: &Summary<'_>) -> String {
    let Some(uncertainty) = &summary.study.uncertainty else { return String::new() };
    let Some([least, most]) = summary.of(Source::All).of(&P95_DEFLECTION) else { return String::new() };
    let mut text = format!(
        "With {} (as uncertain as given), the deflection stays below {} with 95 % probability at the best place, {}, and \
         below {} at the worst, {}.\n",
        spread_report::counted_inputs(uncertainty),
        millimetres(least.value, 3),
        least.tip(),
        millimetres(most.value, 3),
        most.tip()
    );
    if let Some((_, within)) = probably_within(summary) {
        text += &format!("The tool is {within}.\n");
    }
    text + &summary.spread.sentences("point")
}

/// Returns what to do next, behind the main cause at most points: nothing of it helps where nominally nothing is within tolerance; `None` if only the cause
/// says it.
fn next_step(summary: &Summary<'_>) -> Option<String> {
    if summary.within.get() == Some(0.0) {
        return Some(
            ": but nominally nothing is within tolerance, so a stiffer machine, less force or a compensation comes first."
                .into(),
        );
    }
    summary.advice.as_ref().map(spread_report::worth_most)
}

/// Words for the share of the box in which the tolerance is met.
const BOX: &str = "in … of the box";

/// Returns the sentences about the single sources and the superposition error.
fn cause_text(summary: &Summary<'_>) -> String {
    let parts = Source::parts(&summary.study.load_case.machine);
    let mut text: String = parts.iter().map(|source| deflection_text(summary, *source)).collect();
    let moves = |source: &&Source| {
        let sums = summary.of(**source);
        summary.is_enough(sums.known) && sums.of(&DEFLECTION).is_some_and(|[_, most]| most.value > ROUNDING_MM)
    };
    if parts.iter().filter(moves).count() > 1 {
        text += "The sources are worst at different places and in different directions: these largest values do not \
                 add up to that of all.\n";
    }
    text + &superposition_error_text(summary)
}

/// Returns the sentence about the largest superposition error; empty if it is not known at enough points.
fn superposition_error_text(summary: &Summary<'_>) -> String {
    let extremes = summary.of(Source::All);
    let (true, Some([_, absolute]), Some([_, relative])) =
        (summary.is_enough(extremes.known), extremes.of(&SUPERPOSITION_ERROR), extremes.of(&SUPERPOSITION_ERROR_SHARE))
    else {
        return String::new();
    };
    let meaning = "Superposition error (the effects computed one by one and added, less all at once)";
    if absolute.value <= ROUNDING_MM {
        return format!("{meaning}: none.\n");
    }
    format!(
        "{meaning}: up to {}, {}, and up to {:.1} % of the deflection, {}; each taken at the tool angle of the \
         largest deflection.\n",
        millimetres(absolute.value, 4),
        absolute.tip(),
        100.0 * relative.value,
        relative.tip()
    )
}

/// Returns a sentence about corrections and forces for each kind of drive, and one about the residual error.
fn corrections_text(summary: &Summary<'_>) -> String {
    let (extremes, machine) = (summary.of(Source::All), &summary.study.load_case.machine);
    if !summary.is_enough(extremes.known - extremes.uncorrected) {
        return String::new();
    }
    let kinds = summary.drives.corrections.iter().zip(&summary.drives.forces);
    let sentence = |((kind, correction), (_, force)): (&(_, _), &(_, _))| {
        drives_text(extremes, machine, *kind, [correction, force]).unwrap_or_default()
    };
    kinds.map(sentence).collect::<String>() + &residual_error_text(extremes, machine)
}

/// Returns the sentence about the `correction` and `force` of drives of one kind, worst over φ; `None` if they are not known.
fn drives_text(
    extremes: &SourceExtremes,
    machine: &Machine,
    kind: Motion,
    [correction, force]: [&Quantity<SourceEffect>; 2],
) -> Option<String> {
    let ([least, most], [_, force]) = (extremes.of(correction)?, extremes.of(force)?);
    let drives = kind_word(machine, kind);
    let of_kind = if machine.has_mixed_drives() { format!(" of {drives}") } else { String::new() };
    Some(format!(
        "To keep the tool on its path, correct the {drives} by up to {}, {}; where least is needed, {}, by up to {}. \
         Drive {}s{of_kind} reach {}, {}.\n",
        kind.position_text(most.value),
        most.tip(),
        least.tip(),
        kind.position_text(least.value),
        kind.force_word(),
        kind.force_text(force.value),
        force.tip()
    ))
}

/// Returns the sentence about the largest residual error along axes that the drives do not control; empty if they control all.
fn residual_error_text(extremes: &SourceExtremes, machine: &Machine) -> String {
    let (Some(axes), Some([_, most])) = (machine.uncontrolled_names(), extremes.of(&RESIDUAL_ERROR)) else {
        return String::new();
    };
    let residual = millimetres(most.value, 3);
    format!("The residual error is up to {residual}, {}: the drives do not control {axes}.\n", most.tip())
}

/// Returns the first screen: one sentence, key numbers and cautions.
pub(super) fn headline(summary: &Summary<'_>, text: &ReportText) -> Headline {
    let (case, all) = (&summary.study.load_case, summary.of(Source::All));
    let name = &case.machine.name;
    let points = counted(summary.study.grid.len(), "grid point");
    let inputs = spread_report::basis(summary.study.uncertainty.as_ref());
    let angles = counted(case.phis.len(), "tool angle");
    let basis = format!("{points}, {angles}, {}, {inputs}", force_text("", case.force.size()));
    let Some([least, most]) = all.of(&DEFLECTION).filter(|_| summary.is_enough(all.known)) else {
        let sentence = match all.known {
            0 => format!("How far the tool of {name} moves could be computed at none of the {points}."),
            known => {
                format!("How far the tool moves is known at only {known} of {points}: too few to say where it is best.")
            }
        };
        let verdict = Verdict::new(State::Bad, "Too little could be computed");
        return Headline::new(sentence, basis).judged(verdict, false).with_cautions(&text.cautions);
    };
    let acting = acting_text(&case.machine, &case.errors, !case.force.is_zero());
    // Where distributions were computed, the tolerance is judged by them.
    let judged = if summary.within_p95.get().is_some() { summary.within_p95 } else { summary.within };
    let verdict_of_share = Verdict::of_deflection(judged.get(), case.tolerance_mm);
    let [low, high] = [least, most].map(|found| millimetres(found.value, 3));
    let spread = all.of(&P95_DEFLECTION);
    let sure = spread.map_or_else(String::new, |[least, most]| {
        format!(
            "{acting}, the tool of {name} moves with 95 % probability, at each place by itself, by at most {} at the best place, {}, and by at most {} at \
             the worst{} (nominally {low} and {high}).",
            millimetres(least.value, 3),
            least.tip(),
            millimetres(most.value, 3),
            if summary.spread.unknown > 0 { " of those where that can be said" } else { "" }
        )
    });
    let sentence = match spread {
        Some(ends) => {
            let [least, most] = ends.map(|own| millimetres(own.value, 3));
            format!("Tool deflection with 95 %: {least} at best, {most} at worst.")
        }
        None if low == high => format!("Tool deflection: {high} everywhere."),
        None => format!("Tool deflection: {low} at best, {high} at worst."),
    };
    let clamp = spread.as_ref().map_or(least, |ends| &ends[0]).tip();
    let best = || {
        let against = case.tolerance_mm.map(|tolerance| Tolerance(tolerance).against(least.value)).unwrap_or_default();
        let what = format!("smallest, {}", least.tip());
        KeyNumber::new(&low, what, against).held_to(case.tolerance_mm, least.value).found(in_map_table(
            &DEFLECTION,
            Extreme::Smallest,
            least.value,
        ))
    };
    let next = match 2 * all.known < summary.study.grid.len() {
        true => "see in map.csv why points fail, and make the box smaller.".into(),
        false => {
            let tolerance = if case.tolerance_mm.is_none() { "give tolerance_mm in the process, " } else { "" };
            format!("{tolerance}place the part near the {clamp}, and compute its path there.")
        }
    };
    Headline::new(sentence, basis)
        .judged(verdict_of_share, summary.study.uncertainty.is_none())
        .next(next)
        .with_cautions(&(verdict(summary) + &sure))
        .with_cautions(&text.cautions)
        .with_numbers(spread.map(|ends| p95_number(ends).held_to(case.tolerance_mm, ends[1].value)))
        .with(worst_number(summary, [least, most], &high))
        .with_numbers((low != high && spread.is_none()).then(best))
        .with_numbers(correction_number(all, summary))
}

/// Returns the start of a sentence: whether the tolerance is met with 95 % probability; empty without tolerance, or where inputs are exact.
fn verdict(summary: &Summary<'_>) -> String {
    let Some((share, within)) = probably_within(summary) else { return String::new() };
    let word = match share {
        1.0 => "Within tolerance",
        0.0 => "Out of tolerance",
        _ => "Partly within tolerance",
    };
    let nominally =
        summary.within.get().map_or_else(String::new, |share| format!(" (nominally in {} of the box)", percent(share)));
    let falls = match summary.spread.most_failing.0 {
        0.0 => String::new(),
        share => {
            format!("; the machine has no equilibrium in some draws, {} of them at the worst place", percent(share))
        }
    };
    format!("{word}{}: {within}{nominally}{falls}. ", spread_report::condition(summary.study.uncertainty.as_ref()))
}

/// Returns the share of the box within tolerance with 95 % probability, also in words; `None` without tolerance or uncertain inputs.
fn probably_within(summary: &Summary<'_>) -> Option<(f64, String)> {
    let (share, tolerance) = (summary.within_p95.get()?, summary.study.load_case.tolerance_mm?);
    // Not to be within with 95 % probability is not to be out of tolerance with it.
    let text = match share {
        0.0 => format!("nowhere within tolerance ({tolerance} mm)"),
        _ => summary.within_p95.text(Some(tolerance), BOX)?,
    };
    Some((share, text + " with 95 % probability"))
}

/// Returns the key number of the largest 95 % quantile.
fn p95_number([least, most]: &[ValueAt<AtAngle>; 2]) -> KeyNumber {
    let what = format!("largest deflection not exceeded with 95 % probability, {}", most.tip());
    let against = format!("{} where it is the smallest", millimetres(least.value, 3));
    KeyNumber::new(&millimetres(most.value, 3), what, against).found(in_map_table(
        &P95_DEFLECTION,
        Extreme::Largest,
        most.value,
    ))
}

/// Returns the reference to the extreme `value` of `quantity` by all sources in `map.csv`.
fn in_map_table(quantity: &Quantity<SourceEffect>, extreme: Extreme, value: f64) -> InTable {
    quantity.found_in("map.csv", &[["source", Source::All.label()]], extreme, value)
}

/// Returns the key number of the largest deflection, against the tolerance or the smallest deflection.
fn worst_number(summary: &Summary<'_>, [least, most]: [&ValueAt<AtAngle>; 2], high: &str) -> KeyNumber {
    let against = match summary.within.against(summary.study.load_case.tolerance_mm, most.value, BOX) {
        Some(met) => met,
        None if least.value > ROUNDING_MM => format!("{:.1} times the smallest", most.value / least.value),
        None => String::new(),
    };
    let nominal = if summary.study.uncertainty.is_some() { "nominal " } else { "" };
    let case = &summary.study.load_case;
    let acting = acting_text(&case.machine, &case.errors, !case.force.is_zero()).to_lowercase();
    let what = format!("largest {nominal}tool deflection {acting}, {}", most.tip());
    let found = in_map_table(&DEFLECTION, Extreme::Largest, most.value);
    KeyNumber::new(high, what, against).held_to(case.tolerance_mm, most.value).found(found)
}

/// Returns the key number of the largest drive correction, of prismatic joints where the machine has prismatic and revolute joints; `None` where no
/// point has one.
fn correction_number(all: &SourceExtremes, summary: &Summary<'_>) -> Option<KeyNumber> {
    let machine = &summary.study.load_case.machine;
    let mut kinds = summary.drives.corrections.iter().filter_map(|(kind, own)| Some((*kind, own, all.of(own)?)));
    let (kind, quantity, [least, most]) = kinds.next()?;
    let drives = if machine.has_mixed_drives() { kind_word(machine, kind) } else { "drive" };
    let others: String = kinds
        .map(|(other, _, [_, most])| format!("; {} {}", kind_word(machine, other), other.position_text(most.value)))
        .collect();
    let against = format!("{} where least is needed{others}", kind.position_text(least.value));
    let what = format!("largest {drives} correction that keeps the tool on its path");
    let number = KeyNumber::new(&kind.position_text(most.value), what, against);
    Some(number.found(in_map_table(quantity, Extreme::Largest, most.value)))
}
