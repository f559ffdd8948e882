//! Report of a path study, collected part by part, so that memory does not grow with the path.

pub(crate) mod cutting_force;
mod on_part;
mod pictures;
mod quantities;
mod summary;
mod text;
mod thinned;

pub use on_part::view_axes;
use quantities::DRAWS;
pub(crate) use quantities::{ANGLE, ARC_LENGTH, DISPLACEMENT, displacement_components, drives, points_table};
pub use summary::Summary;
pub(crate) use text::{MOVE_INSIDE, outside_positions, path_cautions};
pub use text::{facts_text, failures_text, headline, text};
pub use thinned::{Curve, MAX_POINTS, drawn_indices};

use serde_json::json;

use crate::{
    answer::{
        Output, Quantity, ReportText, Run, Streams,
        budget::{self, BUDGET, OfVerdict},
        clearance as of_bodies,
        deflected_pose::deflected_pose,
        facts_of, layers,
        machine::described,
        play::play_quantities,
        source_group,
    },
    files::{
        exchange::{KeptRows, Table},
        words::counted,
    },
    input::error::Result,
    machine::Machine,
    page::{Better, Column, Description, Explorer, Fact, PageKind, Section, Shape, TableNote},
    process::RedundancySettings,
    questions::{
        Answered,
        path::{PathPart, PathStudy, PointEffect, Shown, WholePath, clearance, run_in_parts},
        spread_report,
    },
    redundancy::{self, FoundGamma},
    simulation::{Source, clearance::MachineCell},
};
use pictures::Pictures;

impl Answered for PathStudy {
    const PAGE: PageKind =
        PageKind { pointed: Some(Shape::Curve), has_sources: true, draws: Some(DRAWS), ..PageKind::PLAIN };

    /// Computes the study part by part, and makes tables, figures, page and summary.
    fn answer(&self, shown: &Shown, run: &Run<'_>) -> Result<Output> {
        let at_gamma = self.with_gamma(run.work)?;
        let (study, machine) = (at_gamma.as_ref(), &at_gamma.machine);
        // What is wrong with bodies is said before anything is computed.
        let cell = MachineCell::of(machine, study.cell.as_ref())?;
        let empty = points_table(study, &PathPart::empty(machine));
        let ranked_by = [&*DISPLACEMENT.name, &*quantities::RESIDUAL_ERROR.name];
        let (points, sources) = (study.stations.len(), Source::of(machine).len());
        let kept = KeptRows::new(empty.columns(), points, sources, &ranked_by, run.rows);
        let mut table = Streams::new(run, None).with_kept("points", empty, kept, |part| points_table(study, part))?;
        let mut summary = Summary::new(study, *shown);
        let mut pictures = run.figures.then(|| Pictures::new(study, *shown));
        let WholePath { methods, spread, draws } = run_in_parts(study, run.work, |part| {
            summary.add(&part);
            pictures.iter_mut().for_each(|pictures| pictures.add(&part));
            table.write_block(&part)
        })?;
        summary.add_whole(&spread);
        summary.add_clearance(clearance(study, cell.as_deref(), run.work)?);
        let text = text(&summary);
        let deflected = summary.largest_displacement().filter(|_| run.figures).and_then(|(_, point)| {
            let place = format!("{:.1} mm along the path", study.stations[point].arc_length_mm);
            deflected_pose(machine, &study.errors, &study.tasks[point], place)
        });
        let streamed = table.finish()?;
        let note = streamed.1.iter().find_map(|(_, table)| table.note()).unwrap_or_default();
        let page = page(study, shown, &ReportText { place: format!("{}{note}\n", text.place), ..text.clone() });
        let mut output = Output {
            tables: vec![("methods".into(), quantities::methods_table(&methods))],
            streamed,
            figures: pictures.map_or_else(Vec::new, |pictures| pictures.figures()),
            deflected,
            details: format!("{}\n{}", text.details(), text::methods_text(&methods)),
            ..Output::of(
                json!({ "points": study.stations.len() }),
                summary.statuses(),
                summary.json(&methods),
                Description { headline: headline(&summary, &text), ..page },
            )
        };
        if spread.is_some() {
            output.tables.push(("draws".into(), quantities::draws_table(&draws)));
            let caption =
                "One row per draw: the largest distance from the path, as estimated; nothing without equilibrium.";
            output.page.tables.push(TableNote::ranked(DRAWS.file, caption, DRAWS.distances[0]));
        }
        let budget = text::budget(&summary);
        let of_verdict = text::of_verdict(&summary, &budget);
        // As of a program that hits something: what must not be done is no answer.
        output.is_answered = Some(false).filter(|_| summary.hits());
        output.tables.push((BUDGET.into(), of_verdict.table()));
        output.figures.extend(of_verdict.figure().filter(|_| run.figures).map(|own| (BUDGET.into(), own)));
        if let Some(cell) = cell.as_deref().filter(|_| run.figures) {
            output.figures.extend(of_bodies::figure(cell, &study.placement, summary.clearance.as_ref()));
        }
        output.summary[BUDGET] = of_verdict.json();
        if let Some((found, how)) = found_gamma(study) {
            let arc_lengths_mm = study.stations.iter().map(|station| station.arc_length_mm);
            let table = redundancy::report::table(found, arc_lengths_mm);
            match KeptRows::new(table.columns(), table.rows().len(), 1, &[COST], run.rows) {
                None => output.tables.push(("redundancy".into(), table)),
                kept => {
                    let empty = Table::new(table.columns().to_vec(), []);
                    let mut part = Streams::new(run, None).with_kept("redundancy", empty, kept, Table::clone)?;
                    part.write_block(&table)?;
                    let (files, described) = part.finish()?;
                    output.streamed.0.extend(files);
                    output.streamed.1.extend(described);
                }
            }
            output.summary["redundancy"] = redundancy::report::json(found, how);
            output.details += &redundancy::report::text(found, how);
        }
        Ok(output)
    }
}

/// Returns the γ found along the path and the settings of its search; `None` if it was not sought.
fn found_gamma(study: &PathStudy) -> Option<(&FoundGamma, &RedundancySettings)> {
    let search = study.gamma_search.as_ref()?;
    Some((search.found.as_deref()?, search.settings()))
}

/// Returns the page without first screen, figures and question, which the run adds.
fn page(study: &PathStudy, shown: &Shown, text: &ReportText) -> Description {
    let points = "One row per point and source of error: displacement without compensation, command and forces with compensation.";
    let mut tables = vec![
        TableNote::new("methods.csv", "One row per method: corrections it needs and errors it leaves."),
        TableNote::ranked("points.csv", points, &DISPLACEMENT.name),
        TableNote::new("budget.csv", budget::CAPTION),
    ];
    if study.gamma_search.is_some() {
        let gammas = "One row per point: the rotation γ about the tool axis and its cost, beside the programmed and the best constant one.";
        tables.push(TableNote::ranked("redundancy.csv", gammas, COST));
    }
    Description {
        setting: setting(study, shown),
        explorers: vec![path_view(study), methods_view()],
        tables,
        sections: sections(study, text),
        ..Description::new("path", described(&study.machine))
    }
}

/// Returns the sections of the page in reading order.
fn sections(study: &PathStudy, text: &ReportText) -> Vec<Section> {
    let mut sections = vec![
        Section::new("How far is the tool off its path, and where?", "along the path, and on the part")
            .text(&text.place)
            .explorers([ALONG])
            .figures(&["spread", "paths", "displacement"]),
        Section::new("Why?", "cutting force, chain errors and weight one by one; the machine deflected")
            .text(&text.cause)
            .figures(&["cutting_force", "delta_rho_sources", "machine_deflected"]),
        Section::new("Which drive commands compensate the deflection?", "corrections, drive forces, and each method")
            .text(&text.remedy)
            .explorers([METHODS])
            .figures(&["delta_rho", "drive_"])
            .tables(["methods.csv"]),
        OfVerdict::section().tables(["budget.csv"]),
    ];
    sections.extend(found_gamma(study).map(|(found, how)| {
        Section::new("Which γ?", "the rotation about the tool axis, which is redundant")
            .text(&redundancy::report::sentence(found, how))
            .tables(["redundancy.csv"])
    }));
    sections
}

/// Column of the distance from the path at the best γ, whose largest values are the worst.
const COST: &str = "cost_mm";
/// Titles of the views.
const ALONG: &str = "Along the path";
const METHODS: &str = "Methods of compensation";

/// Returns the facts about machine, path, process and force that head the page; `shown` says whether the path is a circle.
fn setting(study: &PathStudy, shown: &Shown) -> Vec<Fact> {
    let kind = if shown.is_circle { "circle" } else { "path" };
    let points = counted(study.stations.len(), "point");
    let extremes = "over these points of this path alone, each at the angle of the force that it has there";
    let mut facts = vec![
        Fact::new("path", format!("{kind} of {:.1} mm, {points}", study.length_mm())),
        Fact::new("best and worst", extremes),
    ];
    facts.extend(study.facts.iter().map(|(label, text)| Fact::new(*label, text.clone())));
    let forces = study.tasks.iter().map(|task| task.load.force.norm());
    let (low, high) = forces.fold((f64::INFINITY, 0.0f64), |(low, high), force| (low.min(force), high.max(force)));
    let force = if high > 0.0 { format!("{low:.1} N to {high:.1} N along the path") } else { "none".into() };
    facts.push(Fact::new("force on the tool", force));
    facts.extend(study.tasks.first().map(|task| Fact::new("compensation holds", task.target.text())));
    facts.extend(
        study.gamma_search.as_ref().map(|search| Fact::new("rotation about the tool axis", search.choice().text())),
    );
    facts.push(spread_report::fact(study.uncertainty.as_deref()));
    facts_of(&study.machine, &study.errors, facts)
}

/// Returns the view of the table of points: largest quantities first, then components and the cutting force.
fn path_view(study: &PathStudy) -> Explorer {
    let machine = &study.machine;
    let mut first = vec![DISPLACEMENT];
    first.extend(quantities::drives(machine).largest().cloned());
    first.push(quantities::RESIDUAL_ERROR);
    first.splice(1..1, quantities::spread_quantities(study));
    let mut view = points_view(machine, ALONG.into(), "points.csv".into(), first);
    view.quantities.extend(cutting_force::quantities());
    view.quantities.extend(play_quantities(machine));
    view
}

/// Returns a view of a table of path points: the quantities `first`, then each component of displacement, correction and force.
pub(crate) fn points_view(
    machine: &Machine,
    title: String,
    table: String,
    first: Vec<Quantity<PointEffect>>,
) -> Explorer {
    let (displacement, drives) = (quantities::displacement_components(), quantities::drives(machine).each);
    let mut quantities = layers(first.iter().chain(&displacement).chain(&drives));
    quantities.push(crate::page::Quantity::new([ANGLE[0]], ANGLE[1], "°", Better::Neither));
    Explorer::curve(title, table, along_columns(), Some(source_group(machine)), quantities)
}

/// Returns the columns over which curves along a path are drawn: length and tool angle φ.
pub(crate) fn along_columns() -> Vec<Column> {
    vec![Column::new(ARC_LENGTH[0], ARC_LENGTH[1], "mm"), Column::new(ANGLE[0], ANGLE[1], "°")]
}

/// Returns the view of the table of methods.
fn methods_view() -> Explorer {
    Explorer {
        title: METHODS.into(),
        table: "methods.csv".into(),
        shape: Shape::Names,
        coordinates: vec![Column::new("method", "method", "")],
        group: None,
        quantities: layers(&quantities::METHOD_QUANTITIES),
        marks: Vec::new(),
    }
}
