//! Page and figures of a compensated program.

use nalgebra::Vector3;

use super::{
    Report, feed,
    findings::{DrawnPoint, Findings, WorstPoint},
    passes_table,
    tables::{error_before_column, spread_quantities},
    use_text, words,
    words::{blocks_table, deflected_cut_text, limits_text, residual_text, spread_text, written_text},
};
use crate::{
    answer::{
        DriveQuantities,
        budget::{self, BUDGET, OfVerdict},
        facts_of, layers,
        machine::described,
    },
    figures::{Figure, LineFigure, LineSeries, Look, PlanFigure, PlanShape, amplification::amplification},
    files::words::{counted, join_text, millimetres, or_dash},
    page::{
        Better, Description, Explorer, Fact, Quantity, Section, SmallTable, TableNote,
        headline::{Headline, KeyNumber},
    },
    products::program::ProgramJob,
    questions::{
        path::report::{ANGLE, Curve, along_columns, cutting_force},
        spread_report,
    },
    simulation::Source,
};

/// Returns the page of the program; `tables` are the file names of those of its points and of what the verdict rests on, `rows` is a sentence on which points the first has, if not all.
pub fn page(
    report: &Report<'_>,
    headline: Headline,
    [points, causes]: &[String; 2],
    rows: Option<&str>,
) -> Description {
    let found = |number: KeyNumber| {
        let found = number.found.map(|found| crate::page::headline::InTable { file: points.clone(), ..found });
        KeyNumber { found, ..number }
    };
    let numbers = headline.numbers.into_iter().map(found).collect();
    let caption = "One row per point of the path: error without compensation and as written, command, drives, forces.";
    Description {
        name: report.name.into(),
        question: format!("Does the compensated {} keep the tool on its path?", report.name),
        headline: Headline { numbers, ..headline },
        setting: setting_facts(report.job),
        sections: [
            report.findings.machined.as_ref().map(|machined| machined.section(report)),
            Some(worst_section(report).text(rows.unwrap_or_default())),
            Some(cause_section(report)),
            Some(remedy_section(report)),
            feed::section(report),
            Some(OfVerdict::section().tables([causes])),
            Some(use_section(report)),
            Some(verification_section(report)),
        ]
        .into_iter()
        .flatten()
        .collect(),
        explorers: vec![along_explorer(report.job, points)],
        part: report.findings.machined.as_ref().map(|machined| machined.view(report.job)),
        tables: vec![
            TableNote {
                kept: rows.map(String::from),
                ..TableNote::ranked(points, caption, &error_before_column(Source::All))
            },
            TableNote::new(causes, budget::CAPTION),
        ],
        ..Description::new("compensated_program", described(&report.job.machine))
    }
}

/// Returns the facts about machine and process that the page lists.
fn setting_facts(job: &ProgramJob) -> Vec<Fact> {
    let (machine, process) = (&job.machine, &job.process);
    let mut facts: Vec<Fact> = process.facts().into_iter().map(|(label, text)| Fact::new(label, text)).collect();
    facts.push(Fact::new("compensation holds", process.target.text()));
    let teeth = process.stock.as_ref().and_then(|stock| stock.tooth_passing(&job.path));
    facts.extend(teeth.map(|(text, _)| Fact::new("teeth pass at", text)));
    facts.extend(process.tolerance_mm.map(|tolerance| Fact::new("tolerance", format!("±{tolerance} mm"))));
    facts.push(spread_report::fact(job.uncertainty.as_deref()));
    facts_of(machine, &process.errors, facts)
}

/// Returns a length as text, mm to four decimals.
fn shown(length_mm: f64) -> String {
    millimetres(length_mm, 4)
}

/// Returns the section on the lines with the largest errors.
fn worst_section(report: &Report<'_>) -> Section {
    let lines = report.findings.lines.worst_lines(report.job);
    let rows = lines.iter().map(|line| {
        let place = line.place.strip_prefix("line ").unwrap_or(&line.place);
        vec![place.to_string(), line.text.clone(), shown(line.before_mm), or_dash(line.after_mm, shown)]
    });
    let table = SmallTable {
        caption: format!("The {} in which the tool is off farthest", counted(lines.len(), "line")),
        header: ["line", "program", "before", "after"].map(String::from).into(),
        rows: rows.collect(),
    };
    Section::new("How far is the tool off its path, and where?", "worst lines, error along the program and on the part")
        .text(&spread_text(report))
        .small_tables([table])
        .explorers([ALONG])
        .figures(&["errors", SPREAD, "paths"])
}

/// Returns the section on the error sources at the worst point.
fn cause_section(report: &Report<'_>) -> Section {
    let mut text = String::new();
    if let Some(worst) = &report.findings.worst {
        let alone = |source: &Source| {
            let size = (*worst.by_source.get(*source)?)?;
            Some(format!("{} {}", source.text(), shown(size)))
        };
        let words: Vec<String> = Source::parts(&report.job.machine).iter().filter_map(alone).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let along = report.job.path.points()[worst.point].arc_length_mm;
        text = format!(
            "At the worst point, {along:.1} mm along the path, each alone moves the tool by: {}.\n",
            join_text(&words)
        );
    }
    Section::new("Why?", "which source causes it").text(&text).figures(&["sources", "cutting_force"])
}

/// Returns the section on drive corrections and binding limits.
fn remedy_section(report: &Report<'_>) -> Section {
    let Report { job, verified, .. } = report;
    Section::new("What do the drives do?", "corrections and forces along the path, limits that bind")
        .text(&limits_text(&job.machine, &job.process.limits, verified))
        .figures(&["corrections"])
}

/// Returns the section on how to use the program.
fn use_section(report: &Report<'_>) -> Section {
    Section::new("How is the program used?", "how to load the program, what to switch off, what a dry run shows")
        .text(&use_text(report))
        .text(&written_text(report.job, report.verified.written.blocks.as_ref()))
        .small_tables(report.verified.written.blocks.as_ref().map(blocks_table))
}

/// Returns the section on the simulated passes.
fn verification_section(report: &Report<'_>) -> Section {
    let (header, rows) = passes_table(&report.verified.passes, false, shown);
    let caption = "Error of the tool's path while it cuts, by drive command".into();
    let table = SmallTable { caption, header: header.into_iter().map(String::from).collect(), rows };
    Section::new("How is the program checked?", "read back and simulated point by point, beside other ways")
        .text("The last row is the program as it was written, read back, rounding included, and simulated.")
        .text(&residual_text(&report.job.machine, report.verified.commanded_max_mm()))
        .text(&deflected_cut_text(report, false))
        .small_tables([table])
}

/// Name of the figure of distributions.
const SPREAD: &str = "spread";
/// Title of the view along the program.
const ALONG: &str = "Along the program";

/// Returns the interactive view of errors, drives and forces along the program.
fn along_explorer(job: &ProgramJob, points: &str) -> Explorer {
    let before = |source: &Source| {
        let text = match source {
            Source::All => "error without compensation".to_string(),
            alone => format!("error by {} alone", alone.text()),
        };
        Quantity::new([error_before_column(*source)], &text, "mm", Better::Smaller)
    };
    let after = Quantity::new(["error_after_mm"], "error as written", "mm", Better::Smaller);
    let mut quantities = vec![before(&Source::All), after];
    quantities.extend(spread_quantities(job).iter().map(crate::answer::Quantity::layer));
    quantities.extend(Source::of(&job.machine).iter().filter(|source| **source != Source::All).map(before));
    // What they are called; their values are in the table.
    let drives = DriveQuantities::<()>::new(&job.machine, Better::Neither, |(), _| None, |(), _| None);
    quantities.extend(layers(drives.largest()));
    quantities.extend(layers(&drives.each));
    quantities.extend(cutting_force::quantities());
    quantities.push(Quantity::new([ANGLE[0]], ANGLE[1], "°", Better::Neither));
    Explorer::curve(ALONG, points, along_columns(), None, quantities)
}

/// Returns all figures by name: the path on the part, errors along it, those by each source, and the cutting force.
pub fn figures(report: &Report<'_>) -> Vec<(String, Figure)> {
    let findings = report.findings;
    let all = &findings.before_curves[Source::All];
    let mut sources = vec![("all at once".to_string(), all)];
    let alone = findings.before_curves.iter().filter(|(source, _)| *source != Source::All);
    sources.extend(alone.map(|(source, curve)| (format!("{} alone", source.text()), curve)));
    let errors = [("before".into(), all), ("after".into(), &findings.after_curve)];
    let force = findings.force.labelled_curves();
    let distances = |title: &str, errors: &[(String, &Curve)]| curve_figure(report.job, title, "distance [mm]", errors);
    let machined = findings.machined.iter().flat_map(|machined| machined.figures(report.job));
    let mut figures: Vec<(String, Figure)> = machined.collect();
    // The part is what is wanted, where it is known.
    let path = if figures.is_empty() { "answer" } else { "paths" };
    figures.extend([
        (path.into(), path_figure(report)),
        ("errors".into(), distances("Distance from the path before and after", &errors)),
        ("sources".into(), distances("What each source does without compensation", &sources)),
    ]);
    if report.job.uncertainty.is_some() {
        let [before_p95, after_p95] = &findings.p95_curves;
        let curves = [
            ("before, 95 % below".into(), before_p95),
            ("after, 95 % below".into(), after_p95),
            ("after, nominal".into(), &findings.after_curve),
            ("after, no cutting force".into(), &findings.without_force_curve),
        ];
        figures.push((SPREAD.into(), distances("Distance from the path where inputs are uncertain", &curves)));
    }
    let title = "Feed along the path";
    figures
        .extend(feed::figure(report.job, |own| curve_figure(report.job, title, "share of the programmed feed", own)));
    if !force.is_empty() {
        figures.push(("cutting_force".into(), curve_figure(report.job, cutting_force::TITLE, "force [N]", &force)));
    }
    let budget = words::budget(report);
    figures.extend(words::of_verdict(report, &budget).figure().map(|own| (BUDGET.into(), own)));
    // Of a program of which nothing is solved, or whose ends alone are known.
    let is_empty = |figure: &Figure| matches!(figure, Figure::Lines(lines) if lines.series.iter().all(|series| series.points.is_empty()));
    figures.retain(|(_, figure)| !is_empty(figure));
    figures
}

/// Returns curves over the arc length of the path: those of a single source, and the size of a force, are dashed.
fn curve_figure(job: &ProgramJob, title: &str, y_label: &str, curves: &[(String, &Curve)]) -> Figure {
    let is_dashed = |label: &str| label.ends_with("alone") || label == cutting_force::SIZE;
    let series = curves.iter().map(|(label, curve)| LineSeries::new(label, curve.points(), is_dashed(label)));
    let subtitle = format!("{}, {}", job.machine.name, counted(job.path.len(), "point"));
    Figure::Lines(LineFigure::new(title, subtitle, ["length along the path [mm]", y_label], series.collect()))
}

/// Returns the path seen from above: wanted, without compensation and as written, with the worst point marked.
fn path_figure(report: &Report<'_>) -> Figure {
    let Findings { worst, corners, drawn, .. } = report.findings;
    let factor = amplification(corners, worst.as_ref().map_or(0.0, |worst| worst.size_mm));
    let pieces = |look: Look, error: fn(&DrawnPoint) -> Option<Vector3<f64>>| {
        let mut pieces: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
        for point in drawn {
            match error(point) {
                Some(error) => {
                    let at = point.wanted + error * factor;
                    pieces.last_mut().into_iter().for_each(|piece| piece.push((at.x, at.y)));
                }
                None => pieces.push(Vec::new()),
            }
        }
        let shape = move |points| PlanShape { look, points, label: String::new() };
        pieces.into_iter().filter(|piece| !piece.is_empty()).map(shape).collect::<Vec<_>>()
    };
    let mark = |worst: &WorstPoint| {
        let at = worst.wanted + worst.error * factor;
        let point = &report.job.path.points()[worst.point];
        let line = report.job.file.line_name(point.source.segment).map_or_else(String::new, |line| format!("{line}, "));
        (at.x, at.y, format!("worst {}\n{line}{:.1} mm along", millimetres(worst.size_mm, 3), point.arc_length_mm))
    };
    Figure::Plan(Box::new(PlanFigure {
        title: format!("The tool's path before and after, ×{factor}, z not shown"),
        subtitle: format!("{}, seen along \u{2212}z of the base", report.job.machine.name),
        x_label: "x [mm]".into(),
        y_label: "y [mm]".into(),
        quantity: String::new(),
        field: None,
        shapes: [
            pieces(Look::TargetPath, |_| Some(Vector3::zeros())),
            pieces(Look::Before, |point| point.before),
            pieces(Look::After, |point| point.after),
        ]
        .concat(),
        coloured: Vec::new(),
        marks: worst.iter().map(mark).collect(),
        note: String::new(),
    }))
}
