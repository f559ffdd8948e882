//! Report of a superposition study; the map is summarised point by point, so that memory does not grow with the grid.

mod pictures;
mod quantities;
mod summary;
mod text;

pub use quantities::{
    ablation_table, largest_factors_table, locations_table, map_table, safe_load_table, scaling_table, slopes_table,
};
pub use summary::Summary;
pub use text::summary_text;

use serde_json::json;

use crate::{
    answer::{Output, Run, Streams, layers, size_text},
    files::{
        StatusCount,
        exchange::{Image, Layer},
        words::position,
    },
    input::error::Result,
    page::{Description, Explorer, Fact, Group, GroupValue, Section, TableNote},
    process::uncertainty::Draws,
    questions::{
        Answered,
        over_workspace::Shown,
        spread_report,
        superposition::{
            GridPoint, LocationResult, SuperpositionStudy,
            ablation::{Ablation, Cause},
            run_locations, run_map,
            superposition_error::{Followed, Sum},
        },
    },
    simulation::{ROUNDING_MM, status_of},
};

impl Answered for SuperpositionStudy {
    /// Runs the study, and makes tables, figures, page and summary.
    fn answer(&self, shown: &Shown, run: &Run<'_>) -> Result<Output> {
        let errors = Layer { table: "map", keys: &["sum", "followed"], vectors: &["superposition_error"] };
        let safe = Layer { table: "safe_load", keys: &[], vectors: &[] };
        let image = Image { grid: self.grid.clone(), layers: vec![errors, safe] };
        let mut streams = Streams::new(run, Some(image))
            .with("map", map_table(&[]), |points: &[GridPoint]| map_table(points))?
            .with("safe_load", safe_load_table(self, &[]), |points| safe_load_table(self, points))?;
        let (mut summary, mut pictures) = (Summary::new(self), pictures::pictures(self, &shown.slices_z));
        run_map(self, run.work, |points| {
            for point in &points {
                summary.add(point);
                pictures.add(point);
            }
            streams.write_block(&points)
        })?;
        let locations = run_locations(self, run.work)?;
        let mut statuses = summary.statuses.clone();
        for location in &locations {
            StatusCount::add(&mut statuses, status_of(&location.superposition_errors));
            StatusCount::add(&mut statuses, status_of(&location.ablation));
        }
        Ok(Output {
            tables: vec![
                ("locations".into(), locations_table(&locations)),
                ("largest_factors".into(), largest_factors_table(&locations)),
                ("scaling".into(), scaling_table(&locations)),
                ("slopes".into(), slopes_table(&locations)),
                ("ablation".into(), ablation_table(&locations)),
            ],
            streamed: streams.finish()?,
            figures: run.draw_figures(|| pictures::figures(&pictures, &summary, &locations)),
            details: summary_text(&summary, &locations),
            ..Output::of(
                json!({
                    "grid": self.grid.counts(),
                    "tool_angles": self.load_case.phis.len(),
                    "tolerance_mm": self.tolerance,
                    "scales": self.scales,
                    "largest_factor": self.largest_factor,
                }),
                statuses,
                summary.json(&locations),
                Description {
                    headline: text::headline(&summary, &locations, &shown.not_used),
                    ..page(&summary, &locations)
                },
            )
        })
    }
}

/// Titles of the interactive views.
const SUPERPOSITION_ERROR: &str = "Superposition error";
const SAFE: &str = "Largest load within tolerance";

/// Returns sections, setting, views and tables of the page; first screen, figures and question are added by the run.
fn page(summary: &Summary<'_>, locations: &[LocationResult]) -> Description {
    let SuperpositionStudy { load_case, grid, locations: study_locations, tolerance, uncertainty, .. } = summary.study;
    let meaning = "sum of the effects less both at once, worst over φ";
    let names: Vec<&str> = study_locations.iter().map(|location| location.name.as_str()).collect();
    let largest = &quantities::SUPERPOSITION_ERROR.name;
    let safe = load_case.view(SAFE, "safe_load.csv", None, layers(&[quantities::LARGEST_LOAD]));
    Description {
        setting: load_case.facts([
            load_case.angles_fact("tool angles"),
            spread_report::fact_of_draws(uncertainty.as_ref(), Draws::PER_SCRAMBLE),
            Fact::new("grid", format!("{} positions of P", size_text(grid))),
            Fact::new("locations", names.join(", ")),
            Fact::new("tolerance", format!("{tolerance} mm")),
        ]),
        sections: sections(summary, locations),
        explorers: vec![superposition_error_view(summary.study), safe],
        tables: vec![
            TableNote::new("largest_factors.csv", "Largest factors on load, errors and both within tolerance."),
            TableNote::new("locations.csv", &format!("Locations: {meaning}.")),
            TableNote::new(
                "slopes.csv",
                "Exponent n of the superposition error: it grows as load and errors to the power n.",
            ),
            TableNote::ranked("map.csv", &format!("Grid points: {meaning}."), largest),
            TableNote::new("safe_load.csv", "Grid points: whether effects may be added, and up to which load."),
            TableNote::new("scaling.csv", "Superposition error at each factor on load, errors and both."),
            TableNote::ranked("ablation.csv", "Causes of the superposition error, at each φ.", &quantities::PART.name),
        ],
        ..load_case.description("superposition", "the platform point P")
    }
}

/// Returns the sections of the page: the map, the largest load, and the causes.
fn sections(summary: &Summary<'_>, locations: &[LocationResult]) -> Vec<Section> {
    let meaning = "Superposition error: the displacement by each effect alone, added, less that by all at once.";
    let at = |location: &LocationResult| format!("{} at {}", location.location.name, position_text(location));
    let points = locations.iter().map(at).collect::<Vec<_>>().join(", ");
    vec![
        Section::new("How large is the superposition error?", "the map, at the tool tip and at the platform point")
            .text(meaning)
            .text(&text::superposition_error_text(summary))
            .explorers([SUPERPOSITION_ERROR])
            .figures(&["slices_superposition", "slices_ratio", "slices_aggregation"]),
        Section::new("Up to which load?", "where effects may be added, and by how much the load may grow")
            .text(&text::safety_text(summary))
            .explorers([SAFE])
            .figures(&["slices_safe", "growth_"])
            .tables(["largest_factors.csv"]),
        Section::new("Why?", "causes of the superposition error")
            .text(&format!("Looked at closely: {points}."))
            .text(&text::cause_sentences(locations))
            .figures(&["ablation"])
            .tables(["locations.csv", "slopes.csv"]),
    ]
}

/// Returns the interactive view of the map.
fn superposition_error_view(study: &SuperpositionStudy) -> Explorer {
    let value = |(sum, followed): (Sum, Followed)| GroupValue {
        cells: vec![sum.label().into(), followed.label().into()],
        label: format!(
            "{}, {}",
            if sum == Sum::Superposition { "superposition" } else { "eqs. (14), (15)" },
            if followed == Followed::Tool { "tool tip" } else { "platform point" }
        ),
    };
    let group = Group {
        columns: vec!["sum".into(), "followed".into()],
        label: "sum and point followed".into(),
        values: quantities::sums_and_points().map(value).collect(),
    };
    study.load_case.view(SUPERPOSITION_ERROR, "map.csv", Some(group), layers(&quantities::page_quantities()))
}

/// Formats the position of a location.
fn position_text(location: &LocationResult) -> String {
    let [x, y, z]: [f64; 3] = location.location.position.into();
    position(x, y, z)
}

/// Returns the name of a cause for sentences.
fn cause_text(cause: Cause) -> &'static str {
    match cause {
        Cause::Point => "shift of the evaluation point",
        Cause::Chains => "chains turned and bent (another stiffness matrix)",
        Cause::Preload => "internal forces (geometric stiffness)",
        Cause::Load => "cutting force (geometric stiffness)",
        Cause::Interaction => "interaction of point and machine",
    }
}

/// Returns the angle with the largest superposition error of the tool tip, the contribution of each cause, mm, and the error, mm; `None` where that
/// is zero or could not be computed.
fn worst_ablation(location: &LocationResult) -> Option<(&Ablation, [f64; 5], f64)> {
    let size = |ablation: &Ablation| ablation.superposition_error.tool.norm();
    let ablations = location.ablation.as_ref().ok()?.iter();
    let worst = ablations.reduce(|worst, other| if size(worst) >= size(other) { worst } else { other })?;
    Some((worst, contributions(worst, Followed::Tool)?, size(worst)))
}

/// Returns the component of each part along the superposition error, mm, which add up to its length; `None` where it is zero.
fn contributions(ablation: &Ablation, followed: Followed) -> Option<[f64; 5]> {
    let superposition_error = ablation.superposition_error.of(followed);
    let direction = superposition_error.try_normalize(ROUNDING_MM)?;
    Some(ablation.parts.map(|part| part.of(followed).dot(&direction)))
}
