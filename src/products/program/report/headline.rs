//! The first screen of a compensated program: how far the tool was off, and what the written program leaves.

use super::{Proved, notes::notes_text, tables::before_column};
use crate::{
    answer::{
        ShareWithin, Tolerance,
        cautions::{self, Outside},
    },
    files::{
        table::kind_word,
        words::{counted, millimetres, percent},
    },
    input::error::Result,
    machine::Motion,
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    products::program::{Pass, ProgramJob},
    questions::path::report::facts_text,
    simulation::Source,
};

/// The answer at a glance. `exceeded` says what limits the program as written exceeds.
///
/// # Errors
/// As [`ProgramJob::parts`].
pub fn headline(job: &ProgramJob, proved: &Proved<'_>, rounded_mm: f64, exceeded: &str) -> Result<Headline> {
    let cutting = job.path.points().iter().filter(|point| point.cutting).count();
    let length = job.path.length_mm();
    let basis = format!("{}, {cutting} of them cutting, {length:.1} mm of path", counted(job.path.len(), "point"));
    let verdict = proved.outside.verdict(&job.machine, proved.name);
    let mut headline = Headline::new(verdict + &sentence(job, proved), basis)
        .with_cautions(&worse_as_written(proved.passes, rounded_mm).unwrap_or_default())
        .with_cautions(exceeded)
        .with_cautions(&known(job, proved))
        .with_all(before(job, proved))
        .with_all(after(job, proved))
        .with_all(correction(job, proved));
    headline.unsolved = unsolved_as_written(proved.passes);
    Ok(headline)
}

/// What must be known with the answer.
fn known(job: &ProgramJob, proved: &Proved<'_>) -> String {
    let machine = &job.machine;
    cautions::zeroed(machine)
        + &cautions::carried(machine)
        + &cautions::large_errors(machine, &job.process.errors)
        + &proved.outside.words("point")
        + &facts_text(&job.process.assumed())
        + &notes_text(job, proved.calls)
}

/// Which points are outside the workspace box of the machine.
///
/// # Errors
/// As [`ProgramJob::parts`].
pub fn outside_workspace(job: &ProgramJob) -> Result<Outside> {
    let mut outside = Outside::default();
    for part in job.parts() {
        part?.demands().iter().for_each(|demand| outside.add(&job.machine, demand.pose.translation));
    }
    Ok(outside)
}

fn sentence(job: &ProgramJob, proved: &Proved<'_>) -> String {
    let name = job.machine.short_title();
    let Some(worst) = &proved.findings.worst else {
        return format!(
            "How far the tool of the {name} leaves {} could be computed at none of its points.",
            proved.name
        );
    };
    let along = job.path.points()[worst.point].arc_length_mm;
    let lines = proved.findings.worst_lines(job);
    let line = lines
        .first()
        .map_or_else(String::new, |worst| format!(", worst in {}, {along:.1} mm along the path", worst.place));
    let off = millimetres(worst.size_mm, 3);
    let left = proved.passes.last().and_then(|pass| pass.summary.max_mm);
    let then =
        left.map_or_else(String::new, |left| format!("; the compensated program leaves {}", millimetres(left, 4)));
    format!("Running {}, the tool of the {name} is off by up to {off}{line}{then}.", proved.name)
}

fn in_points(column: String, value: f64) -> InTable {
    InTable::new("points", [column], &[], Extreme::Largest, value)
}

fn against(job: &ProgramJob, within: ShareWithin) -> String {
    let verdict = job.process.tolerance_mm.and_then(|tolerance| Some((tolerance, within.get()?)));
    verdict.map_or_else(String::new, |(tolerance, share)| {
        Tolerance(tolerance).kept(&format!("at {} of the points", percent(share)))
    })
}

fn before(job: &ProgramJob, proved: &Proved<'_>) -> Option<KeyNumber> {
    let worst = proved.findings.worst.as_ref()?.size_mm;
    let shown = millimetres(worst, 3);
    let what = "largest distance from the path without compensation, where the tool cuts";
    let number = KeyNumber::new(&shown, what, against(job, proved.findings.before));
    Some(number.found(in_points(before_column(Source::All), worst)))
}

fn after(job: &ProgramJob, proved: &Proved<'_>) -> Option<KeyNumber> {
    let left = proved.passes.last()?.summary.max_mm?;
    let shown = millimetres(left, 4);
    let what = "largest distance with the compensated program as written, simulated";
    let number = KeyNumber::new(&shown, what, against(job, proved.findings.after));
    Some(number.found(in_points("error_after_mm".into(), left)))
}

/// The largest correction, of slides where there are both kinds of drives, and what limits do.
fn correction(job: &ProgramJob, proved: &Proved<'_>) -> Option<KeyNumber> {
    let machine = &job.machine;
    let of = |kind: Motion| Some((kind, proved.corrections[kind as usize]?));
    let mut kinds = machine.drive_kinds().filter_map(of);
    let (kind, most) = kinds.next()?;
    let drives = if machine.has_mixed_drives() { kind_word(machine, kind) } else { "drive" };
    let mut told: Vec<String> =
        kinds.map(|(kind, most)| format!("{} {}", kind_word(machine, kind), kind.position_words(most))).collect();
    told.extend(proved.bounded.map(|path| match path.summary.prices.len() {
        0 => "no limit binds".to_string(),
        count => format!("{} bind", counted(count, "limit")),
    }));
    Some(KeyNumber::new(&kind.position_words(most), format!("largest {drives} correction"), told.join("; ")))
}

/// What is left where nothing is rounded, mm.
const EXACT_MM: f64 = 1e-6;
/// A program may leave this many times its rounding more than the commands that it was written from.
const ROUNDINGS: f64 = 10.0;

/// What must be said if the program as written leaves more than its commands do and rounding, by `rounded_mm` at most,
/// explains.
pub fn worse_as_written(passes: &[Pass], rounded_mm: f64) -> Option<String> {
    let [.., commanded, written] = passes else { return None };
    let (commanded, written) = (commanded.summary.max_mm?, written.summary.max_mm?);
    let explained = commanded + ROUNDINGS * rounded_mm + EXACT_MM;
    let shown = |length: f64| millimetres(length, 4);
    let sentence = || {
        format!(
            "Do not run the written program: it leaves {}, its commands leave {} and writing them moved none by more than {}.\n",
            shown(written),
            shown(commanded),
            shown(rounded_mm)
        )
    };
    (written > explained).then(sentence)
}

/// Points of the last pass, the program as written, that have no equilibrium or cannot be reached.
pub fn unsolved_as_written(passes: &[Pass]) -> Option<String> {
    let summary = &passes.last()?.summary;
    let lost = summary.points - summary.solved;
    let sentence = format!(
        "{lost} of {} not solved: the written program fails there; the table of points says why.",
        summary.points
    );
    (lost > 0).then_some(sentence)
}
