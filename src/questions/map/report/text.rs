//! What a map says, in sentences: where the tool moves how far, why, and what to command instead.

use super::summary::{OfSource, Summary, is_enough};
use crate::{
    answer::{Said, cautions},
    files::{
        table::kind_word,
        words::{counted, millimetres, percent},
    },
    machine::{Machine, Motion},
    questions::map::WorkspaceMapStudy,
    simulation::{ROUNDING_MM, Source},
};

/// What `summary` of all points of `study` says.
pub fn text(summary: &Summary, study: &WorkspaceMapStudy) -> Said {
    Said {
        cautions: cautions(summary, study),
        place: deflection(summary, study, Source::All) + &tolerance(summary, study),
        cause: cause(summary, study),
        remedy: corrections(summary, &study.machine, study.grid.len()),
    }
}

fn cautions(summary: &Summary, study: &WorkspaceMapStudy) -> String {
    let machine = &study.machine;
    let positions = (0..study.grid.len()).map(|index| study.grid.position(index));
    let missing = match summary.uncorrected() {
        0 => String::new(),
        rows => format!("At {} the correction is missing; the deflection is known.\n", counted(rows, "row")),
    };
    missing
        + &cautions::not_used(&study.not_used)
        + &cautions::zeroed(machine)
        + &cautions::carried(machine)
        + &cautions::large_errors(machine, &study.errors)
        + &cautions::outside_workspace(machine, "grid point", positions)
}

/// How far `source` moves the tool at the best and at the worst place.
fn deflection(summary: &Summary, study: &WorkspaceMapStudy, source: Source) -> String {
    let (Some(sums), points) = (summary.of(source), study.grid.len()) else { return String::new() };
    let cause = source.moves(&study.machine);
    let Some([least, most]) = sums.deflection.get().filter(|_| is_enough(sums.known, points)) else {
        return format!(
            "{cause}: known at {} of {}, too few to speak of best and worst.\n",
            sums.known,
            counted(points, "grid point")
        );
    };
    let phi = most.phi_deg.map_or_else(String::new, |phi| format!(" (tool angle φ = {phi:.0}°)"));
    if most.value <= ROUNDING_MM {
        return String::new();
    }
    let [low, high] = [least, most].map(|found| millimetres(found.value, 3));
    match low == high {
        true => format!("{cause} by {high} everywhere.\n"),
        false => format!(
            "{cause} by {low} at the best place, {}, and by {high} at the worst, {}{phi}.\n",
            least.place(),
            most.place()
        ),
    }
}

fn tolerance(summary: &Summary, study: &WorkspaceMapStudy) -> String {
    let (Some(tolerance), Some(share)) = (study.tolerance_mm, summary.share_within()) else { return String::new() };
    format!(
        "The tolerance of {tolerance} mm is kept, without compensation, in {} of the box{}.\n",
        percent(share),
        if summary.is_all_known(study) { "" } else { " as far as it was solved" }
    )
}

/// The single sources, and how wrong it is to add them.
fn cause(summary: &Summary, study: &WorkspaceMapStudy) -> String {
    let parts = Source::parts(&study.machine);
    let mut text: String = parts.iter().map(|source| deflection(summary, study, *source)).collect();
    let moves = |source: &&Source| {
        let known = summary.of(**source).filter(|sums| is_enough(sums.known, study.grid.len()));
        known.and_then(|sums| sums.deflection.get()).is_some_and(|[_, most]| most.value > ROUNDING_MM)
    };
    if parts.iter().filter(moves).count() > 1 {
        text += "The sources are worst at different places and in different directions: these largest values do not \
                 add up to that of all.\n";
    }
    text + &departure(summary, study.grid.len())
}

fn departure(summary: &Summary, points: usize) -> String {
    let Some(both) = summary.of(Source::All).filter(|both| is_enough(both.known, points)) else {
        return String::new();
    };
    let (Some([_, absolute]), Some([_, relative])) = (both.departure.get(), both.departure_over_deflection.get())
    else {
        return String::new();
    };
    if absolute.value <= ROUNDING_MM {
        return "Departure of superposition (the effects computed one by one and added, less all at once): none.\n"
            .into();
    }
    format!(
        "Departure of superposition (the effects computed one by one and added, less all at once): up to {}, at {}, and \
         up to {:.1} % of the deflection, at {}; each taken at the tool angle of the largest deflection.\n",
        millimetres(absolute.value, 4),
        absolute.place(),
        100.0 * relative.value,
        relative.place()
    )
}

/// A sentence for each kind of drive.
fn corrections(summary: &Summary, machine: &Machine, points: usize) -> String {
    let Some(both) = summary.of(Source::All) else { return String::new() };
    if !is_enough(both.known - both.uncorrected, points) {
        return String::new();
    }
    machine.drive_kinds().map(|kind| correction(both, machine, kind)).collect::<String>() + &left(both, machine)
}

fn correction(both: &OfSource, machine: &Machine, kind: Motion) -> String {
    let (Some([least, most]), Some([_, force])) =
        (both.correction[kind as usize].get(), both.force[kind as usize].get())
    else {
        return String::new();
    };
    let drives = kind_word(machine, kind);
    let own = if machine.has_mixed_drives() { format!(" of {drives}") } else { String::new() };
    format!(
        "To keep the tool on its path, correct the {drives} by up to {}, at {}; where least is needed, at {}, by up to {}. \
         Drive {}s{own} reach {:.0} {}, at {}.\n",
        kind.position_words(most.value),
        most.place(),
        least.place(),
        kind.position_words(least.value),
        kind.force_word(),
        force.value,
        kind.shown_force_unit(),
        force.place()
    )
}

/// What no drive can compensate.
fn left(both: &OfSource, machine: &Machine) -> String {
    let (Some(axes), Some([_, most])) = (machine.uncontrolled_names(), both.left.get()) else { return String::new() };
    let left = millimetres(most.value, 3);
    format!("Compensation leaves up to {left}, at {}: the drives do not control {axes}.\n", most.place())
}
