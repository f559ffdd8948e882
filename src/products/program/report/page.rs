//! What the page of a compensated program shows.

use super::{
    Proved,
    blocks::{blocks_table, written_text},
    bounded_text, left_text,
    tables::before_column,
    use_text,
};
use crate::{
    files::words::{counted, if_any, listed, millimetres},
    page::{
        Better, Description, Explorer, Fact, MachineDescription, Quantity, Section, Shape, SmallTable, TableNote,
        drive_quantities, error_facts,
        headline::{Headline, KeyNumber},
        largest_of_drives,
    },
    products::program::ProgramJob,
    questions::path::report::{ANGLE, along_columns, cutting_force},
    simulation::Source,
};

/// The page of the program; `points` is the file name of its table of points, `commands` the words for each pass.
pub fn page(job: &ProgramJob, proved: &Proved<'_>, headline: Headline, points: &str) -> Description {
    let found = |number: KeyNumber| {
        let found = number.found.map(|found| crate::page::headline::InTable { file: points.into(), ..found });
        KeyNumber { found, ..number }
    };
    let numbers = headline.numbers.into_iter().map(found).collect();
    let caption = "One row per point of the path: error without compensation and as written, command, drives, forces.";
    Description {
        name: proved.name.into(),
        question: format!("Does the compensated {} keep the tool on its path?", proved.name),
        headline: Headline { numbers, ..headline },
        setting: setting(job),
        sections: vec![
            worst(job, proved),
            cause(job, proved),
            remedy(job, proved),
            to_use(job, proved),
            proof(job, proved),
        ],
        explorers: vec![along(job, points)],
        tables: vec![TableNote::ranked(points, caption, &before_column(Source::All))],
        ..Description::new("compensated_program", MachineDescription::new(&job.machine))
    }
}

fn setting(job: &ProgramJob) -> Vec<Fact> {
    let mut facts = vec![Fact::new("machine", job.machine.title.clone())];
    facts.extend(job.process.facts().into_iter().map(|(label, words)| Fact::new(label, words)));
    facts.push(Fact::new("compensation holds", job.process.target.words()));
    facts.extend(job.process.tolerance_mm.map(|tolerance| Fact::new("tolerance", format!("{tolerance} mm"))));
    facts.extend(job.machine.held_words().map(|words| Fact::new("held", words)));
    facts.extend(error_facts(&job.machine, &job.process.errors));
    facts
}

fn shown(length_mm: f64) -> String {
    millimetres(length_mm, 4)
}

fn worst(job: &ProgramJob, proved: &Proved<'_>) -> Section {
    let lines = proved.findings.worst_lines(job);
    let rows = lines.iter().map(|line| {
        let place = line.place.strip_prefix("line ").unwrap_or(&line.place);
        vec![place.to_string(), line.text.clone(), shown(line.before_mm), if_any(line.after_mm, shown)]
    });
    let table = SmallTable {
        caption: format!("The {} in which the tool is off farthest", counted(lines.len(), "line")),
        header: ["line", "program", "before", "after"].map(String::from).into(),
        rows: rows.collect(),
    };
    Section::new("Where is the tool off how far?", "the worst lines, the error along the program and on the part")
        .small_tables([table])
        .explorers([ALONG])
        .figures(&["errors", "paths"])
}

fn cause(job: &ProgramJob, proved: &Proved<'_>) -> Section {
    let mut text = String::new();
    if let Some(worst) = &proved.findings.worst {
        let alone = |source: &Source| {
            let size = (*worst.by_source.get(*source)?)?;
            Some(format!("{} {}", source.words(), shown(size)))
        };
        let words: Vec<String> = Source::parts(&job.machine).iter().filter_map(alone).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let along = job.path.points()[worst.point].arc_length_mm;
        text = format!(
            "At the worst point, {along:.1} mm along the path, each alone moves the tool by: {}.\n",
            listed(&words)
        );
    }
    Section::new("Why?", "which source is to blame").text(&text).figures(&["sources", "cutting_force"])
}

fn remedy(job: &ProgramJob, proved: &Proved<'_>) -> Section {
    let text = match proved.bounded {
        Some(bounded) => bounded_text(&job.machine, bounded),
        None if job.process.limits.is_limited() => {
            "The limits of the process were not looked at: --method bounded keeps them.\n".into()
        }
        None => String::new(),
    };
    Section::new("What do the drives do?", "corrections and forces along the path, limits that bind")
        .text(&text)
        .figures(&["corrections"])
}

fn to_use(job: &ProgramJob, proved: &Proved<'_>) -> Section {
    Section::new("How is it used?", "what the program is, how to load it, what to switch off, what a dry run shows")
        .text(&use_text(job, proved))
        .text(&written_text(job, proved.blocks))
        .small_tables(proved.blocks.map(blocks_table))
}

fn proof(job: &ProgramJob, proved: &Proved<'_>) -> Section {
    let row = |pass: &super::Pass| {
        let s = &pass.summary;
        vec![
            pass.name.clone(),
            if_any(s.max_mm, shown),
            if_any(s.rms_mm, shown),
            format!("{} of {}", s.solved, s.points),
        ]
    };
    let table = SmallTable {
        caption: "Distance of the tool from its path, where it cuts, by what is commanded".into(),
        header: ["commands", "largest", "rms", "points solved"].map(String::from).into(),
        rows: proved.passes.iter().map(row).collect(),
    };
    let own = proved.passes.iter().rev().nth(1).and_then(|own| own.summary.max_mm);
    Section::new("How is it proved?", "the written program, read back and simulated point by point, beside other ways")
        .text("The last row is the program as it was written, read back, rounding included, and simulated.")
        .text(&left_text(&job.machine, own))
        .small_tables([table])
}

/// Title of the view.
const ALONG: &str = "Along the program";

fn along(job: &ProgramJob, points: &str) -> Explorer {
    let before = |source: &Source| {
        let words = match source {
            Source::All => "error without compensation".to_string(),
            alone => format!("error by {} alone", alone.words()),
        };
        Quantity::new([before_column(*source)], &words, "mm", Better::Smaller)
    };
    let after = Quantity::new(["error_after_mm"], "error as written", "mm", Better::Smaller);
    let mut quantities = vec![before(&Source::All), after];
    quantities.extend(Source::of(&job.machine).iter().filter(|source| **source != Source::All).map(before));
    quantities.extend(largest_of_drives(&job.machine));
    quantities.extend(drive_quantities(&job.machine, Better::Neither));
    quantities.extend(cutting_force::quantities());
    quantities.push(Quantity::new([ANGLE[0]], ANGLE[1], "°", Better::Neither));
    Explorer {
        title: ALONG.into(),
        table: points.into(),
        shape: Shape::Curve,
        coordinates: along_columns(),
        group: None,
        quantities,
        marks: Vec::new(),
    }
}
