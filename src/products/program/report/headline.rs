//! The first screen of a compensated program: how far the tool was off, and what the written program leaves.

use super::{Report, exceeded_text, notes::notes_text, tables::before_column};
use crate::{
    answer::{ShareWithin, Tolerance, cautions},
    files::{
        table::kind_word,
        words::{counted, millimetres, percent},
    },
    machine::Motion,
    page::headline::{Extreme, Headline, InTable, KeyNumber},
    products::program::{ProgramJob, Proved},
    questions::path::report::facts_text,
    simulation::Source,
};

/// The answer at a glance.
pub fn headline(report: &Report<'_>) -> Headline {
    let cutting = report.job.path.points().iter().filter(|point| point.cutting).count();
    let length = report.job.path.length_mm();
    let basis =
        format!("{}, {cutting} of them cutting, {length:.1} mm of path", counted(report.job.path.len(), "point"));
    let verdict = report.findings.outside.verdict(&report.job.machine, report.name);
    let mut headline = Headline::new(verdict + &sentence(report), basis)
        .with_cautions(&report.proved.worse_as_written().unwrap_or_default())
        .with_cautions(
            &report.proved.exceeded.as_deref().map_or_else(String::new, |found| exceeded_text(report.job, found)),
        )
        .with_cautions(&known(report))
        .with_all(before(report))
        .with_all(after(report))
        .with_all(correction(report));
    headline.unsolved = report.proved.unsolved_as_written();
    headline
}

/// What must be known with the answer.
fn known(report: &Report<'_>) -> String {
    let machine = &report.job.machine;
    cautions::zeroed(machine)
        + &cautions::carried(machine)
        + &cautions::large_errors(machine, &report.job.process.errors)
        + &report.findings.outside.words("point")
        + &facts_text(&report.job.process.assumed())
        + &notes_text(report.job, &report.proved.written.calls)
}

fn sentence(report: &Report<'_>) -> String {
    let name = report.job.machine.short_title();
    let Some(worst) = &report.findings.worst else {
        return format!(
            "How far the tool of the {name} leaves {} could be computed at none of its points.",
            report.name
        );
    };
    let along = report.job.path.points()[worst.point].arc_length_mm;
    let lines = report.findings.worst_lines(report.job);
    let line = lines
        .first()
        .map_or_else(String::new, |worst| format!(", worst in {}, {along:.1} mm along the path", worst.place));
    let off = millimetres(worst.size_mm, 3);
    let left = report.proved.passes.last().and_then(|pass| pass.summary.max_mm);
    let then =
        left.map_or_else(String::new, |left| format!("; the compensated program leaves {}", millimetres(left, 4)));
    format!("Running {}, the tool of the {name} is off by up to {off}{line}{then}.", report.name)
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

fn before(report: &Report<'_>) -> Option<KeyNumber> {
    let worst = report.findings.worst.as_ref()?.size_mm;
    let shown = millimetres(worst, 3);
    let what = "largest distance from the path without compensation, where the tool cuts";
    let number = KeyNumber::new(&shown, what, against(report.job, report.findings.before));
    Some(number.found(in_points(before_column(Source::All), worst)))
}

fn after(report: &Report<'_>) -> Option<KeyNumber> {
    let left = report.proved.passes.last()?.summary.max_mm?;
    let shown = millimetres(left, 4);
    let what = "largest distance with the compensated program as written, simulated";
    let number = KeyNumber::new(&shown, what, against(report.job, report.findings.after));
    Some(number.found(in_points("error_after_mm".into(), left)))
}

/// The largest correction, of slides where there are both kinds of drives, and what limits do.
fn correction(report: &Report<'_>) -> Option<KeyNumber> {
    let machine = &report.job.machine;
    let of = |kind: Motion| Some((kind, report.findings.corrections[kind as usize]?));
    let mut kinds = machine.drive_kinds().filter_map(of);
    let (kind, most) = kinds.next()?;
    let drives = if machine.has_mixed_drives() { kind_word(machine, kind) } else { "drive" };
    let mut told: Vec<String> =
        kinds.map(|(kind, most)| format!("{} {}", kind_word(machine, kind), kind.position_words(most))).collect();
    told.extend(report.proved.bounded.as_ref().map(|path| match path.summary.prices.len() {
        0 => "no limit binds".to_string(),
        count => format!("{} bind", counted(count, "limit")),
    }));
    Some(KeyNumber::new(&kind.position_words(most), format!("largest {drives} correction"), told.join("; ")))
}

/// What is left where nothing is rounded, mm.
const EXACT_MM: f64 = 1e-6;
/// A program may leave this many times its rounding more than the commands that it was written from.
const ROUNDINGS: f64 = 10.0;

impl Proved {
    /// What must be said if the program as written leaves more than its commands do and rounding explains.
    pub fn worse_as_written(&self) -> Option<String> {
        let (commanded, written) = (self.commanded_max_mm()?, self.passes.last()?.summary.max_mm?);
        let rounded_mm = self.written.rounded_mm;
        let [leaves, commands, moved] = [written, commanded, rounded_mm].map(|length| millimetres(length, 4));
        (written > commanded + ROUNDINGS * rounded_mm + EXACT_MM).then(|| {
            format!(
                "Do not run the written program: it leaves {leaves}, its commands leave {commands} and writing them moved none by more \
                 than {moved}.\n"
            )
        })
    }

    /// Points of the program as written that have no equilibrium or cannot be reached.
    pub fn unsolved_as_written(&self) -> Option<String> {
        let summary = &self.passes.last()?.summary;
        let lost = summary.points - summary.solved;
        let all = summary.points;
        (lost > 0).then(|| {
            format!("{lost} of {all} not solved: the written program fails there; the table of points says why.")
        })
    }
}
