//! What the page of a map of turns shows.

use super::{summary::Report, table::ALL, text};
use crate::{
    answer::tool_axis_fact,
    files::words::{counted, typographic},
    page::{
        Better, Column, Description, Explorer, Fact, Group, GroupValue, MachineDescription, Quantity, Section, Shape,
        TableNote, error_facts,
    },
};

/// Title of the view.
const MAP: &str = "Map of turns";

/// Sections, setting, views and tables; first screen, figures and question are added by the run.
pub(super) fn page(report: &Report<'_>) -> Description {
    let caption =
        "One row per place and direction of the tool; of several directions, then one per place for the worst of them.";
    Description {
        setting: setting(report),
        terms: vec![
            Fact::new("Positions", "of the tool tip, from the origin of the machine's base"),
            Fact::new(
                "Turn",
                "of the platform about the tool's axis, right-handed about the direction from the spindle to the tip, counted from \
                 the least turn that brings the tool from home into its direction",
            ),
        ],
        explorers: vec![explorer(report)],
        tables: vec![TableNote::ranked("turns.csv", caption, "best_deflection_mm")],
        sections: vec![
            Section::new("Where does the tool move how far, turned well?", "the map, to slice, turn and click")
                .text(&text::details(report))
                .explorers([MAP])
                .figures(&["slices_best", "turns_"]),
            Section::new("How to turn?", "the best turn, and how much it counts").figures(&[
                "slices_turn",
                "slices_gain",
                "slices_possible",
            ]),
        ],
        ..Description::new("turn_map", MachineDescription::new(&report.study.scene.machine))
    }
}

fn setting(report: &Report<'_>) -> Vec<Fact> {
    let study = report.study;
    let [nx, ny, nz] = study.grid.counts();
    let force = &study.scene.force;
    let forces = format!("{} N radial, {} N tangential, {} N axial", force.radial, force.tangential, force.axial);
    let directions: Vec<String> = (0..study.axes.len()).map(|axis| report.axis_name(axis)).collect();
    let mut facts = vec![
        Fact::new("machine", study.scene.machine.title.clone()),
        Fact::new("cutting force", typographic(&forces)),
        Fact::new("tool axis", tool_axis_fact(&study.scene.machine)),
        Fact::new("directions of the tool", typographic(&format!("{}, from tip to spindle", directions.join(", ")))),
        Fact::new("turns", format!("{} in steps of {}°", study.turns(), study.turn.step_deg)),
        Fact::new(
            "kept from singularities",
            format!("inverse condition number of {} at least", study.turn.min_singularity_distance),
        ),
        Fact::new("directions of the force", format!("{} over a turn; the worst counts", study.scene.phis.len())),
        Fact::new("grid", format!("{nx} × {ny} × {nz}, {}", counted(study.grid.len(), "place"))),
    ];
    facts.extend(study.scene.machine.held_words().map(|words| Fact::new("held", words)));
    facts.extend(error_facts(&study.scene.machine, &study.scene.errors));
    facts
}

fn explorer(report: &Report<'_>) -> Explorer {
    let axes = report.study.axes.len();
    let value = |cell: String, label: String| GroupValue { cells: vec![cell], label };
    let own = (0..axes).map(|axis| value(report.axis_name(axis), format!("along {}", report.axis_name(axis))));
    let all = (axes > 1).then(|| value(ALL.into(), "the worst of all directions".into()));
    let quantity = |column: &str, label: &str, unit: &str, better| Quantity::new([column], label, unit, better);
    Explorer {
        title: MAP.into(),
        table: "turns.csv".into(),
        shape: Shape::Grid,
        coordinates: ["x", "y", "z"].map(|axis| Column::new(format!("{axis}_mm"), axis, "mm")).into(),
        group: Some(Group {
            columns: vec!["direction".into()],
            label: "direction of the tool".into(),
            values: all.into_iter().chain(own).collect(),
        }),
        quantities: vec![
            quantity("best_deflection_mm", "deflection at the best turn", "mm", Better::Smaller),
            quantity("worst_deflection_mm", "deflection at the worst turn", "mm", Better::Smaller),
            quantity("worst_over_best", "worst over best", "", Better::Neither),
            quantity("best_turn_deg", "best turn", "°", Better::Neither),
            quantity("turns_possible", "turns that are possible", "", Better::Larger),
        ],
        marks: Vec::new(),
    }
}
