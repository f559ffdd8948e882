//! What the page of a correction table shows.

use super::{CorrectionFormat, Report, comp_file, text};
use crate::{
    files::words::typographic,
    page::{
        Better, Column, Description, Explorer, Fact, Group, GroupValue, MachineDescription, Mark, Quantity, Section,
        Shape, TableNote, error_facts,
    },
    products::correction::ResidualPoint,
};

/// Sections, setting, views and tables; first screen and figures are added.
pub(super) fn page(report: &Report<'_>) -> Description {
    let question = report.question;
    let has_table = report.has(CorrectionFormat::Csv);
    let caption = "One row per node: the coefficients of each drive.";
    let mut tables = vec![TableNote::ranked(
        "residual.csv",
        "One row per point and way to correct, worst over no force and the largest one along each axis.",
        "error_mm",
    )];
    tables.extend(has_table.then(|| TableNote::new("correction.csv", caption)));
    Description {
        name: format!("Correction table of the {}", question.machine.short_title()),
        question: "What must a controller add to the drives so that the loaded tool stays where it is wanted?".into(),
        setting: setting(report),
        terms: vec![
            Fact::new("Positions", "of the platform point P, from the origin of the machine's base"),
            Fact::new("Error", "distance of the loaded tool from where it is wanted, as far as the drives control it"),
        ],
        explorers: vec![explorer(report)],
        tables,
        sections: sections(report),
        ..Description::new("correction", MachineDescription::new(&question.machine))
    }
}

/// Title of the view of what is left.
const MAP: &str = "What is left";

fn sections(report: &Report<'_>) -> Vec<Section> {
    let mut table =
        Section::new("How is the table used?", "positions, forces, interpolation").text(&text::how_to_use(report));
    if report.has(CorrectionFormat::Csv) {
        table = table.tables(["correction.csv"]);
    }
    let mut joints = Section::new("And with a table for each joint alone?", "what controls have for errors of screws")
        .text(&text::per_joint(report));
    if let Ok((tables, _)) = &report.answer.per_joint {
        joints = joints.figures(&["slices_error_per_joint"]);
        if report.has(CorrectionFormat::Comp) {
            joints = joints.to_copy(comp_file::ini(tables));
        }
    }
    vec![
        Section::new("What is left where?", "without correction, with the table, with exact corrections")
            .text(&text::what_is_left(report))
            .explorers([MAP])
            .figures(&["slices_error_none", "slices_error_table", "slices_error_exact"])
            .tables(["residual.csv"]),
        table,
        joints,
    ]
}

fn setting(report: &Report<'_>) -> Vec<Fact> {
    let question = report.question;
    let [min, max] = question.corners;
    let span = |axis: usize| {
        let name = ["x", "y", "z"][axis];
        match min[axis] < max[axis] {
            true => format!("{name} {} to {}", shown(min[axis]), shown(max[axis])),
            false => format!("{name} {}", shown(min[axis])),
        }
    };
    let mut facts = vec![
        Fact::new("machine", question.machine.title.clone()),
        Fact::new("box", typographic(&format!("{} mm, positions of P", [0, 1, 2].map(span).join(", ")))),
        Fact::new("forces", format!("up to {} N on the tool tip, in any direction", report.force())),
        Fact::new("tolerance", format!("{} mm", question.tolerance_mm)),
        Fact::new("table", format!("{} nodes", report.size())),
        Fact::new("compensation holds", question.target.words()),
    ];
    facts.extend(question.machine.held_words().map(|words| Fact::new("held", words)));
    facts.extend(error_facts(&question.machine, &question.errors));
    facts
}

/// Without the rounding of how it was computed.
fn shown(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn explorer(report: &Report<'_>) -> Explorer {
    let labels = ["without correction", "with the table", "with exact corrections", "with a table for each joint"];
    let ways = report.residuals.first().map_or(0, |point| point.left_mm.len());
    let value = |way: usize| GroupValue { cells: vec![ResidualPoint::WAYS[way].into()], label: labels[way].into() };
    let marks = report.question.machine.points.iter();
    Explorer {
        title: MAP.into(),
        table: "residual.csv".into(),
        shape: Shape::Grid,
        coordinates: ["x", "y", "z"].map(|axis| Column::new(format!("{axis}_mm"), axis, "mm")).into(),
        group: Some(Group {
            columns: vec!["correction".into()],
            label: "correction".into(),
            values: (0..ways).map(value).collect(),
        }),
        quantities: vec![Quantity::new(["error_mm"], "largest error of the tool", "mm", Better::Smaller)],
        marks: marks.map(|p| Mark { label: p.name.clone(), position: p.position.iter().copied().collect() }).collect(),
    }
}
