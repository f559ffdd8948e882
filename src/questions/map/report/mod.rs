//! Report of a workspace map, collected block by block, so that memory does not grow with the grid.

mod advice;
mod pictures;
mod quantities;
mod summary;
mod text;

pub use quantities::table;
pub use summary::Summary;
pub use text::text;

use serde_json::json;

use crate::{
    answer::{Output, ReportText, Run, Streams, layers, size_text, source_group},
    files::{
        exchange::{Image, Layer},
        words::{counted, position, typographic},
    },
    input::error::Result,
    machine::Machine,
    page::{Description, Fact, PageKind, Section, Shape, TableNote},
    process::ForceLaw,
    questions::{
        Answered,
        map::{MapPoint, WorkspaceMapStudy, run_in_blocks},
        over_workspace::Shown,
        spread_report,
    },
    simulation::Source,
};

impl Answered for WorkspaceMapStudy {
    const PAGE: PageKind = PageKind {
        pointed: Some(Shape::Grid),
        has_sources: true,
        has_point_command: true,
        interactive: ("Try another force", "pull the tool, change a number: computed in this page"),
        draws: None,
    };

    /// Computes the map block by block, and makes table, figures, page and summary.
    fn answer(&self, shown: &Shown, run: &Run<'_>) -> Result<Output> {
        let image = Image {
            grid: self.grid.clone(),
            layers: vec![Layer { table: "map", keys: &["source"], vectors: &["deflection", "superposition_error"] }],
        };
        let of_block = |points: &[MapPoint]| table(self, points);
        let mut streams = Streams::new(run, Some(image)).with("map", table(self, &[]), of_block)?;
        let (mut summary, mut pictures) = (Summary::new(self), pictures::pictures(self, &shown.slices_z));
        run_in_blocks(self, run.work, |points| {
            for point in &points {
                summary.add(point);
                pictures.add(point);
            }
            streams.write_block(&points)
        })?;
        if let Some([_, worst]) = summary.of(Source::All).of(&quantities::P95_DEFLECTION) {
            summary.advice = advice::advise(self, worst, summary.spread.causes(), run.work)?;
        }
        let text = text(&summary, &shown.not_used);
        Ok(Output {
            streamed: streams.finish()?,
            figures: run.draw_figures(|| pictures::figures(&pictures, &summary)),
            deflected: run.figures.then(|| pictures::worst_deflected_pose(self)).flatten(),
            details: text.details(),
            ..Output::of(
                json!({ "grid": self.grid.counts(), "tool_angles": self.load_case.phis.len() }),
                summary.statuses.clone(),
                summary.json(),
                Description { headline: text::headline(&summary, &text), ..page(&summary, &text) },
            )
        })
    }
}

/// Title of the view of the map.
const MAP: &str = "Workspace map";

/// Returns the page without first screen, figures and question, which the run adds.
fn page(summary: &Summary<'_>, text: &ReportText) -> Description {
    let load_case = &summary.study.load_case;
    let caption = "One row per grid point and source of error, worst over the tool angle.";
    let layers = layers(&quantities::page_quantities(summary.study, &summary.drives));
    Description {
        setting: setting(summary.study),
        explorers: vec![load_case.view(MAP, "map.csv", Some(source_group(&load_case.machine)), layers)],
        tables: vec![TableNote::ranked("map.csv", caption, &quantities::DEFLECTION.name)],
        sections: vec![
            Section::new("How far does the tool move, and where?", "the map, to slice, turn and click")
                .text(&text.place)
                .explorers([MAP])
                .figures(&["slices_deflection_p95", "slices_deflection_all", "workspace_"]),
            Section::new(
                "Why?",
                "cutting force, chain errors and weight one by one; stiffness; what adding them misses",
            )
            .text(&text.cause)
            .figures(&[
                "slices_deflection",
                "slices_stiffness",
                "slices_superposition",
                "machine_deflected",
            ]),
            Section::new("Which drive commands compensate the deflection?", "drive corrections over the workspace")
                .text(&text.remedy)
                .figures(&["slices_delta_rho"]),
        ],
        ..load_case.description("workspace_map", &positions_text(&load_case.machine))
    }
}

/// Describes whose positions those of the map are, and where the tool tip is then.
fn positions_text(machine: &Machine) -> String {
    let tip = machine.home.pose.rotation * machine.tool_tip;
    match tip.norm() > 0.0 {
        true => format!("the platform point P, from which the tool tip is at {}", position(tip.x, tip.y, tip.z)),
        false => "the platform point P, which is the tool tip".into(),
    }
}

/// Returns the facts about machine, force, tool angles and grid that head the page.
fn setting(WorkspaceMapStudy { load_case, grid, uncertainty }: &WorkspaceMapStudy) -> Vec<Fact> {
    let span = |axis: usize| {
        let values = &grid.axes[axis];
        // The way to the middle of a box leaves rounding that must not show.
        let shown = |value: f64| (value * 1e9).round() / 1e9;
        let text = match values.as_slice() {
            [one] => format!("{} mm", shown(*one)),
            several => format!("{} to {} mm", shown(several[0]), shown(several[several.len() - 1])),
        };
        typographic(&text)
    };
    let over = format!(
        "over these {} and {}; between grid points, and on a path with another force, values differ",
        counted(grid.len(), "grid point"),
        counted(load_case.phis.len(), "tool angle")
    );
    let mut facts = load_case.facts([
        load_case.angles_fact("tool angles"),
        Fact::new("grid", format!("{} positions of P, x {}, y {}, z {}", size_text(grid), span(0), span(1), span(2))),
        Fact::new("best and worst", over),
        Fact::new("compensation holds", load_case.target.text()),
        spread_report::fact(uncertainty.as_ref()),
    ]);
    facts[1].value += match load_case.force.law {
        ForceLaw::PaperEq17 => "; eq. (17) as printed",
        ForceLaw::Rotated => "; eq. (17) as a rotation",
    };
    facts
}
