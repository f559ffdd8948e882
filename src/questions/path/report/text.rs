//! What a path study says, in sentences: where the tool leaves the path how far, why, and what to command instead.

use super::{summary::Summary, summary::facts_text};
use crate::{
    answer::{Said, Tolerance, cautions},
    files::{
        table::kind_word,
        words::{counted, listed, millimetres, percent},
    },
    machine::Motion,
    questions::path::{PathStudy, Shown},
    redundancy,
    simulation::{ROUNDING_MM, Source, program_file::place_in_words},
};

/// What `summary` of all points of `study` says.
pub fn text(summary: &Summary, study: &PathStudy, shown: &Shown) -> Said {
    Said {
        cautions: cautions(summary, study),
        place: displacement(summary, study, shown, Source::All) + &tolerance(summary, study),
        cause: cause(summary, study, shown),
        remedy: remedy(summary, study, shown),
    }
}

/// A point of the path in words.
pub(super) fn place(study: &PathStudy, shown: &Shown, k: usize) -> String {
    let station = &study.stations[k];
    let angle = station.phi_deg.filter(|_| shown.is_circle);
    let angle = angle.map_or_else(String::new, |phi| format!(" (tool angle φ = {phi:.0}°)"));
    let line = station
        .line
        .map_or_else(String::new, |line| format!("{}, ", place_in_words(&study.called_files, station.file, line)));
    format!("{line}{:.1} mm along the path{angle}", station.arc_length_mm)
}

fn cautions(summary: &Summary, study: &PathStudy) -> String {
    let positions = study.demands.iter().map(|demand| demand.pose.translation);
    let failed = match summary.of(Source::All).map_or(0, |all| all.failed) {
        0 => String::new(),
        failed => {
            let points = counted(study.stations.len(), "point");
            format!("{failed} of {points} could not be compensated; the table of points says why.\n")
        }
    };
    failed
        + &turned(study)
        + &cautions::zeroed(&study.machine)
        + &cautions::carried(&study.machine)
        + &cautions::large_errors(&study.machine, &study.errors)
        + &cautions::outside_workspace(&study.machine, "path point", positions)
        + &facts_text(&study.assumed)
}

/// What was found of the turn about the tool's axis, if it was sought.
fn turned(study: &PathStudy) -> String {
    let found = study.turn.as_ref().and_then(|turn| Some((turn, turn.found.as_deref()?)));
    found.map_or_else(String::new, |(turn, found)| redundancy::report::sentence(found, turn.how()))
}

fn displacement(summary: &Summary, study: &PathStudy, shown: &Shown, source: Source) -> String {
    let Some((size, k)) = summary.of(source).and_then(|sums| sums.displacement.get()) else { return String::new() };
    if size <= ROUNDING_MM {
        return String::new();
    }
    let cause = source.moves(&study.machine);
    format!("{cause} by up to {}, {}.\n", millimetres(size, 3), place(study, shown, k))
}

fn tolerance(summary: &Summary, study: &PathStudy) -> String {
    let (Some(tolerance), Some(share)) = (study.tolerance_mm, summary.share_within()) else { return String::new() };
    Tolerance(tolerance).kept_without_compensation(&format!("at {} of the points", percent(share)))
}

/// The single sources: their largest displacements, and what each does where all together are worst.
fn cause(summary: &Summary, study: &PathStudy, shown: &Shown) -> String {
    let parts = Source::parts(&study.machine);
    let mut text: String = parts.iter().map(|source| displacement(summary, study, shown, *source)).collect();
    let peaks: Vec<usize> =
        parts.iter().filter_map(|source| Some(summary.of(*source)?.displacement.get()?.1)).collect();
    if peaks.windows(2).any(|pair| pair[0] != pair[1]) {
        text += "These largest values lie at different points: they do not add up to that of all.\n";
    }
    let blame = summary.blame().iter();
    let blame: Vec<String> =
        blame.map(|(source, size)| format!("{} {}", source.words(), millimetres(*size, 3))).collect();
    if let Some((_, k)) = summary.of(Source::All).and_then(|all| all.displacement.get()).filter(|_| blame.len() > 1) {
        let words: Vec<&str> = blame.iter().map(String::as_str).collect();
        text += &format!(
            "At the worst point, {}, each alone moves the tool by: {}.\n",
            place(study, shown, k),
            listed(&words)
        );
    }
    text
}

fn remedy(summary: &Summary, study: &PathStudy, shown: &Shown) -> String {
    let machine = &study.machine;
    let Some(both) = summary.of(Source::All) else { return String::new() };
    let place = |k| place(study, shown, k);
    let of = |kind: Motion| {
        let (correction, k) = both.correction[kind as usize].get()?;
        let (force, kf) = both.force[kind as usize].get()?;
        let drives = kind_word(machine, kind);
        let own = if machine.has_mixed_drives() { format!(" of {drives}") } else { String::new() };
        Some(format!(
            "To keep the tool on its path, correct the {drives} by up to {}, {}. Drive {}s{own} then reach {force:.0} {}, {}.\n",
            kind.position_words(correction),
            place(k),
            kind.force_word(),
            kind.shown_force_unit(),
            place(kf)
        ))
    };
    let mut text: String = machine.drive_kinds().filter_map(of).collect();
    if let (Some(axes), Some((left, k))) = (machine.uncontrolled_names(), both.left.get()) {
        let left = millimetres(left, 3);
        text += &format!("Compensation leaves up to {left}, {}: the drives do not control {axes}.\n", place(k));
    }
    text
}
