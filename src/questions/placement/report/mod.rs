//! Report of a placement study: tables, figures and page.

mod headline;
mod pictures;
mod quantities;
mod recommended;
mod text;

pub use headline::{cautions_text, force_text, known_force};
pub use pictures::figures;
pub use quantities::{candidates_table, summary_json, sweep_table};
pub use text::{entries_table, summary_text};

use kinetostat_budget::Budget;
use nalgebra::Vector3;
use serde_json::{Value, json};

use self::quantities::{
    available_metrics, cell_status, cell_values, entry_values, front_table, refinements_table, spread_values,
};
use crate::{
    answer::{
        Output, Run,
        budget::{self, BUDGET, OfVerdict},
        layers, locked_fact,
        machine::{described, error_facts},
    },
    files::{
        Manifest,
        words::{counted, typographic},
    },
    input::error::Result,
    page::{Column, Description, Explorer, Fact, Mark, Section, Shape, TableNote},
    process::{Placement, file::NOT_CONTROLLED},
    questions::{
        Answered,
        placement::{
            Best, CLEARANCE_MM, COORDINATES, Entry, FeatureJob, Metric, Origin, PlacementResults, PlacementStudy, Site,
            UNITS, site::unit_suffix,
        },
        spread_report,
    },
    simulation::{external_axes::axes_along, tasks::PoseTracker},
};

impl Answered for PlacementStudy {
    /// Runs the study, and makes tables, figures, page and summary.
    fn answer(&self, (): &(), run: &Run<'_>) -> Result<Output> {
        let results = super::run(self, run.work)?;
        let (search, entries) = (&self.search, &results.entries);
        let mut tables = vec![
            ("candidates".to_string(), candidates_table(self, entries)),
            ("sweep".into(), sweep_table(&results)),
            ("refinements".into(), refinements_table(&results)),
        ];
        if !self.objective.pareto.is_empty() {
            tables.push(("pareto".into(), front_table(&results)));
        }
        let mut budget = Budget::default();
        let of_verdict = headline::of_verdict(&results, &mut budget);
        tables.extend(of_verdict.iter().map(|own| (BUDGET.into(), own.table())));
        let mut summary = summary_json(&results);
        let mut figures = run.draw_figures(|| figures(&results));
        if let Some(own) = &of_verdict {
            summary[BUDGET] = own.json();
            figures.extend(own.figure().filter(|_| run.figures).map(|own| (BUDGET.into(), own)));
        }
        Ok(Output {
            // Places where the workpiece cannot be cut are an answer; that there is no other is a failure.
            is_answered: Some(results.best.is_some()),
            tables,
            figures,
            details: format!("{}\n{}", entries_table(self, entries), summary_text(&results)),
            best_place: results.best.as_ref().map(|best| best_place(&results, best)),
            ..Output::of(
                json!({
                    "grid": self.grid.counts(),
                    "starts": search.starts,
                    "max_iterations": search.max_iterations,
                    "tolerance": search.tolerance,
                    "coarse_to_fine": search.coarse_to_fine,
                }),
                Manifest::count(results.cells.iter().map(cell_status)),
                summary,
                Description { headline: headline::headline(&results), ..page(&results) },
            )
        })
    }
}

/// Returns name, coordinates and objective exactly at the best place as JSON.
fn best_place(results: &PlacementResults, best: &Best) -> Value {
    let entry = &results.entries[best.entry];
    let there = entry.feasible().map_or(best.value, |own| results.study.objective.value(&own.as_placed));
    json!({ "name": entry.name, "place": best.site.shown(), "objective": there })
}

/// Returns the page without first screen, figures and question, which the run adds.
fn page(results: &PlacementResults) -> Description {
    let study = &results.study;
    let mut tables = vec![
        TableNote::new(
            "candidates.csv",
            "Named and found places with all numbers, best first; those that cannot be cut at last, with the reason.",
        ),
        TableNote::new("sweep.csv", "Places of the sweep; where one was stopped early, its numbers are bounds."),
        TableNote::new("refinements.csv", "Refinements: where each started and ended."),
    ];
    if results.best.is_some() {
        tables.push(TableNote::new("budget.csv", budget::CAPTION));
    }
    if !study.objective.pareto.is_empty() {
        tables.push(TableNote::new(
            "pareto.csv",
            "All compromises: places that no other beats in all these numbers, each refined.",
        ));
    }
    Description {
        setting: setting(study),
        terms: vec![Fact::new("Positions", positions_text(study))],
        sections: sections(results),
        explorers: vec![sweep_view(results), places_view(study)],
        tables,
        ..Description::new("placement", described(&study.machine))
    }
}

/// Returns the sections of the page in reading order.
fn sections(results: &PlacementResults) -> Vec<Section> {
    let mut sections = vec![
        Section::new("Why here?", "every place that was tried, and the named ones beside it")
            .text(&text::place_text(results))
            .small_tables(text::compromises_table(results))
            .explorers([SWEEP, PLACES])
            .figures(&["answer", "map_", "pareto"])
            .tables(["candidates.csv"]),
        Section::new("Where on the path is the error largest?", "the error along the path here and at a poor place")
            .figures(&["path_errors", "paths"]),
        Section::new("How sure is the best place?", "how the search found it, and how far the workpiece may be moved")
            .text(&(text::search_text(results) + &text::certainty_text(results))),
    ];
    if let Some(best) = &results.best {
        sections.push(OfVerdict::section().tables(["budget.csv"]));
        let heading = "How to use this place?";
        let section = Section::new(heading, "set this place in the process file, compensate the program, check it")
            .text("This place, for the process file of `kinetostat compensate` and of path studies:");
        sections.push(section.to_copy(placement_table(&best.site) + &gamma_table(&results.entries[best.entry].gammas)));
    }
    sections
}

/// Returns a place as the table `[placement]` of a process file.
fn placement_table(site: &Site) -> String {
    let [x, y, z, angles @ ..] = site.shown();
    let nonzero = COORDINATES[3..].iter().zip(angles).filter(|(_, angle)| *angle != 0.0);
    let nonzero: String = nonzero.map(|(name, angle)| format!("{name}_deg = {angle:?}\n")).collect();
    format!("[placement]\norigin_mm = [{x:?}, {y:?}, {z:?}]\n{nonzero}")
}

/// Returns γ of a place as keys of the table `[redundancy]` of a process file; empty where none was sought, or features have different ones.
fn gamma_table(gammas: &[Option<f64>]) -> String {
    let [Some(gamma), others @ ..] = gammas else { return String::new() };
    let shown = (1e9 * gamma.to_degrees()).round() / 1e9;
    let is_one = others.iter().all(|other| *other == Some(*gamma));
    let keys = || format!("\n[redundancy]\ngamma = \"best_constant\"\nrange_deg = [{shown:?}, {shown:?}]\n");
    if is_one { keys() } else { String::new() }
}

/// Titles of the views.
const SWEEP: &str = "Places of the sweep";
const PLACES: &str = "Named and found places";

/// Formats the point `p`, mm, for the page.
fn point_text(p: Vector3<f64>) -> String {
    typographic(&format!("({}, {}, {})", p.x, p.y, p.z))
}

/// Returns which point and frame the positions on the first screen refer to.
fn positions_text(study: &PlacementStudy) -> String {
    let carrier = study.machine.carrier.as_ref().map_or("the machine's base", |carrier| carrier.name.as_str());
    let of = if headline::platform_offset(study).is_some() { "P at the part's origin" } else { "the part's origin" };
    format!("of {of}, from the origin of {carrier}")
}

/// Returns the facts about machine, objective, bounds, features and obstacles that head the page.
fn setting(study: &PlacementStudy) -> Vec<Fact> {
    let mut facts = vec![
        Fact::new("machine", study.machine.title.clone()),
        Fact::new("objective (minimised)", study.objective.text(&study.machine)),
        Fact::new("best and worst", "over the points of the paths at one place; each place has its own"),
    ];
    for (i, name) in COORDINATES.iter().enumerate() {
        let [low, high] = [study.bounds.low, study.bounds.high].map(|end| Site(end).shown()[i]);
        let unit = unit_suffix(i);
        let value = if low == high { format!("fixed at {low}{unit}") } else { format!("{low} to {high}{unit}") };
        facts.push(Fact::new(*name, typographic(&value)));
    }
    let is_alike = study.features.windows(2).all(|pair| pair[0].tracked.errors == pair[1].tracked.errors);
    for (index, job) in study.features.iter().enumerate() {
        let name = &job.feature.name;
        facts.push(Fact::new(format!("feature {name}"), feature_text(job)));
        let errors = error_facts(&study.machine, &job.tracked.errors);
        match is_alike {
            true if index + 1 == study.features.len() => facts.extend(errors),
            true => {}
            false => facts.extend(errors.into_iter().map(|e| Fact::new(format!("{}, {name}", e.label), e.value))),
        }
    }
    facts.push(spread_report::fact(study.features[0].tracked.uncertainty.as_deref()));
    facts.extend(study.machine.uncontrolled_text().map(|text| Fact::new(NOT_CONTROLLED, text)));
    facts.extend(locked_fact(&study.machine));
    facts.push(Fact::new("P on all paths within", {
        let (low, high) = (point_text(study.machine.workspace.min), point_text(study.machine.workspace.max));
        format!("{low} to {high} mm, the machine's workspace box")
    }));
    if let Some(table) = &study.table {
        let (centre, size) = (table.centre_mm, table.size_mm);
        let mut text = format!("{} mm × {} mm around ({}, {}) mm", size.x, size.y, centre.x, centre.y);
        if table.yaw != 0.0 {
            text += &format!(", turned by {}°", table.yaw.to_degrees());
        }
        let hangs = if table.is_overhead { ", the part under it: the tool points up" } else { "" };
        text += &table.height_mm.map_or_else(String::new, |height| format!(", surface at z = {height} mm{hangs}"));
        facts.push(Fact::new("table", format!("{text}, margin {} mm", table.margin_mm)));
    }
    if !study.forbidden.is_empty() {
        let clearance =
            format!("{} mm on every side (clearance_mm; {CLEARANCE_MM} mm if not given)", study.clearance_mm);
        facts.push(Fact::new("clearance around forbidden boxes", clearance));
    }
    for forbidden in &study.forbidden {
        let (low, high) = (point_text(forbidden.extent.min), point_text(forbidden.extent.max));
        facts.push(Fact::new(format!("forbidden box {}", forbidden.name), format!("{low} to {high} mm")));
    }
    facts
}

/// Returns the largest cutting force on the tool along a feature, N.
fn largest_force_n(job: &FeatureJob) -> f64 {
    let (machine, feature) = (job.machine(), &job.feature);
    let (unplaced, external) = (Placement::default(), axes_along(machine, feature.path.external_axes()));
    let mut track = PoseTracker::new(machine, &unplaced);
    let forces = feature.path.points().iter().zip(&feature.loads).map(|(point, load)| {
        let placed = track.placed(external(point));
        let posed = point.orientation.map_or(*placed, |orientation| placed.with_tool_orientation(&orientation));
        load.on_tool(point.tangent, posed.tool_axes()).force_N.norm()
    });
    forces.fold(0.0, f64::max)
}

/// Describes a feature: points, largest force, tolerance, compensation and limits.
fn feature_text(job: &FeatureJob) -> String {
    let (feature, limits, largest_force) = (&job.feature, &job.limits, largest_force_n(job));
    let mut text = format!(
        "{}, force on the tool up to {largest_force:.1} N, tolerance {} mm, compensation holds: {}, cutting: {}",
        counted(feature.path.len(), "point"),
        feature.tolerance_mm,
        job.target.text(),
        job.cuts.text()
    );
    for (limit, what, unit) in [
        (limits.correction_mm, "corrections", "mm"),
        (limits.correction_change_mm, "change of a correction from point to point", "mm"),
        (limits.force_N, "drive forces", "N"),
    ] {
        if let Some(limit) = limit {
            text += &format!(", {what} at most {limit} {unit}");
        }
    }
    text
}

/// Returns the view of the sweep.
fn sweep_view(results: &PlacementResults) -> Explorer {
    let study = &results.study;
    let column =
        |i: usize| Column::new(format!("{}_{}", COORDINATES[i], UNITS[i]), COORDINATES[i], unit_suffix(i).trim_start());
    Explorer {
        title: SWEEP.into(),
        table: "sweep.csv".into(),
        shape: Shape::Grid,
        coordinates: view_axes(study).into_iter().map(column).collect(),
        group: None,
        quantities: layers(&cell_values(study)),
        marks: place_marks(results),
    }
}

/// Returns the coordinates of the view: x, y, z and the first angle that the sweep varies, else yaw.
fn view_axes(study: &PlacementStudy) -> [usize; 4] {
    let angle = (3..COORDINATES.len()).find(|&i| study.grid.axes[i].len() > 1);
    [0, 1, 2, angle.unwrap_or(3)]
}

/// Returns the marks of the named places and the best one, if they lie within the bounds.
fn place_marks(results: &PlacementResults) -> Vec<Mark> {
    let bounds = &results.study.bounds;
    let best = results.best.as_ref().map(|best| best.entry);
    let is_shown = |(index, entry): &(usize, &Entry)| {
        (Some(*index) == best || entry.found == Origin::Named) && bounds.inside(&entry.site).is_some()
    };
    let shown = results.entries.iter().enumerate().filter(is_shown);
    let position = |entry: &Entry| self::view_axes(&results.study).into_iter().map(|i| entry.site.shown()[i]).collect();
    shown.map(|(_, entry)| Mark { label: entry.name.clone(), position: position(entry) }).collect()
}

/// Returns the view that compares named and found places.
fn places_view(study: &PlacementStudy) -> Explorer {
    let metrics = available_metrics(study).filter(|metric| *metric != Metric::ForceMargin);
    Explorer {
        title: PLACES.into(),
        table: "candidates.csv".into(),
        shape: Shape::Names,
        coordinates: vec![Column::new("name", "place", "")],
        group: None,
        quantities: layers(&[entry_values(study, metrics), spread_values(study)].concat()),
        marks: Vec::new(),
    }
}
