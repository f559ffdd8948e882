//! Reports of a map of turns.

mod headline;
mod quantities;
mod summary;

use serde_json::json;

use crate::{
    answer::{Output, Run, layers, size_words},
    files::{
        Manifest,
        words::{counted, typographic},
    },
    input::error::Result,
    page::{Description, Explorer, Fact, Group, GroupValue, Section, TableNote},
    questions::{
        Answered,
        turn_map::{TurnMapPoint, TurnMapStudy, run},
    },
    simulation::Shown,
};
use headline::{details, headline};
use summary::Report;

impl Answered for TurnMapStudy {
    fn answer(&self, shown: &Shown, asked: &Run<'_>) -> Result<Output> {
        let map = run(self, asked.work)?;
        let report = Report { study: self, map: &map };
        Ok(Output {
            tables: vec![("turns".into(), quantities::table(&report))],
            figures: asked.drawn(|| quantities::figures(&report, shown)),
            details: details(&report),
            ..Output::of(
                json!({
                    "grid": self.grid.counts(),
                    "directions": self.axes.len(),
                    "turns": self.turns(),
                    "tool_angles": self.scene.phis.len(),
                }),
                Manifest::count(map.points.iter().map(TurnMapPoint::status)),
                report.json(),
                Description { headline: headline(&report), ..page(&report) },
            )
        })
    }
}

/// Title of the view.
const MAP: &str = "Map of turns";

/// Sections, setting, views and tables; first screen, figures and question are added by the run.
fn page(report: &Report<'_>) -> Description {
    let caption =
        "One row per place and direction of the tool; of several directions, then one per place for the worst of them.";
    let mut description = report.study.scene.description("turn_map", "the tool tip");
    description.terms.push(Fact::new(
        "Turn",
        "of the platform about the tool's axis, right-handed about the direction from the spindle to the tip, counted from \
         the least turn that brings the tool from home into its direction",
    ));
    Description {
        setting: setting(report),
        explorers: vec![explorer(report)],
        tables: vec![TableNote::ranked("turns.csv", caption, &quantities::BEST.name)],
        sections: vec![
            Section::new("Where does the tool move how far, turned well?", "the map, to slice, turn and click")
                .text(&details(report))
                .explorers([MAP])
                .figures(&["slices_best", "turns_"]),
            Section::new("How to turn?", "the best turn, and how much it counts").figures(&[
                "slices_turn",
                "slices_gain",
                "slices_possible",
            ]),
        ],
        ..description
    }
}

fn setting(report: &Report<'_>) -> Vec<Fact> {
    let TurnMapStudy { scene, grid, axes, turn } = report.study;
    let directions: Vec<String> = (0..axes.len()).map(|axis| report.axis_name(axis)).collect();
    scene.facts([
        Fact::new("directions of the tool", typographic(&format!("{}, from tip to spindle", directions.join(", ")))),
        Fact::new("turns", format!("{} in steps of {}°", report.study.turns(), turn.step_deg)),
        Fact::new(
            "kept from singularities",
            format!("inverse condition number of {} at least", turn.min_singularity_distance),
        ),
        scene.angles_fact("directions of the force"),
        Fact::new("grid", format!("{}, {}", size_words(grid), counted(grid.len(), "place"))),
    ])
}

fn explorer(report: &Report<'_>) -> Explorer {
    let axes = report.study.axes.len();
    let value = |cell: String, label: String| GroupValue { cells: vec![cell], label };
    let own = (0..axes).map(|axis| value(report.axis_name(axis), format!("along {}", report.axis_name(axis))));
    let all = (axes > 1).then(|| value(quantities::ALL.into(), "the worst of all directions".into()));
    let group = Group {
        columns: vec!["direction".into()],
        label: "direction of the tool".into(),
        values: all.into_iter().chain(own).collect(),
    };
    let layers = layers(&quantities::on_page());
    Explorer { marks: Vec::new(), ..report.study.scene.view(MAP, "turns.csv", Some(group), layers) }
}
