//! What the page of a superposition study shows.

use crate::{
    answer::tool_axis_fact,
    files::words::{position, typographic},
    page::{
        Better, Column, Description, Explorer, Fact, Group, GroupValue, MachineDescription, Mark, Quantity, Section,
        Shape, TableNote, error_facts,
    },
    questions::superposition::{
        LocationResult, SuperpositionStudy,
        report::{Summary, text},
    },
};

/// Sections, setting, views and tables; first screen, figures and question are added by the run.
pub fn page(study: &SuperpositionStudy, summary: &Summary, locations: &[LocationResult]) -> Description {
    let departures = "departure of the sum from both at once, worst over the tool angle";
    Description {
        setting: setting(study),
        terms: vec![Fact::new("Positions", "of the platform point P, from the origin of the machine's base")],
        sections: sections(study, summary, locations),
        explorers: vec![departure_map(study), safe_map(study)],
        tables: vec![
            TableNote::new("largest_factors.csv", "Largest factors on load, errors and both that keep the tolerance."),
            TableNote::new("locations.csv", &format!("Locations: {departures}.")),
            TableNote::new("slopes.csv", "Exponents with which the departure grows."),
            TableNote::ranked("map.csv", &format!("Grid points: {departures}."), "departure_mm"),
            TableNote::new("safe_load.csv", "Grid points: whether adding keeps the tolerance, and up to which load."),
            TableNote::new("scaling.csv", "Departure at each factor on load, errors and both."),
            TableNote::ranked("ablation.csv", "What makes the departure, at each tool angle.", "part_mm"),
        ],
        ..Description::new("superposition", MachineDescription::new(&study.scene.machine))
    }
}

fn sections(study: &SuperpositionStudy, summary: &Summary, locations: &[LocationResult]) -> Vec<Section> {
    let meaning = "Departure of superposition: the displacement by each effect alone, added, less that by all at once.";
    let place = |location: &LocationResult| {
        let [x, y, z]: [f64; 3] = location.location.position.into();
        format!("{} at {}", location.location.name, position(x, y, z))
    };
    let points = locations.iter().map(place).collect::<Vec<_>>().join(", ");
    vec![
        Section::new("Where is adding wrong by how much?", "the map, at the tool tip and at the platform point")
            .text(meaning)
            .text(&text::departures(summary))
            .explorers([DEPARTURE])
            .figures(&["slices_departure", "slices_ratio", "slices_aggregation"]),
        Section::new("Up to which load?", "where adding keeps the tolerance, and by how much load may grow")
            .text(&text::safety(study, summary))
            .explorers([SAFE])
            .figures(&["slices_safe", "growth_"])
            .tables(["largest_factors.csv"]),
        Section::new("Why?", "what the departure is made of")
            .text(&format!("Looked at closely: {points}."))
            .text(&text::causes(locations))
            .figures(&["ablation"])
            .tables(["locations.csv", "slopes.csv"]),
    ]
}

/// Titles of the views.
const DEPARTURE: &str = "Departure of superposition";
const SAFE: &str = "Largest load that keeps the tolerance";

fn setting(study: &SuperpositionStudy) -> Vec<Fact> {
    let [nx, ny, nz] = study.grid.counts();
    let force = &study.scene.force;
    let forces = format!("{} N radial, {} N tangential, {} N axial", force.radial, force.tangential, force.axial);
    let locations: Vec<&str> = study.locations.iter().map(|location| location.name.as_str()).collect();
    let mut facts = vec![
        Fact::new("machine", study.scene.machine.title.clone()),
        Fact::new("cutting force", typographic(&forces)),
        Fact::new("tool axis", tool_axis_fact(&study.scene.machine)),
        Fact::new("tool angles", format!("{} over a turn; the worst counts", study.scene.phis.len())),
        Fact::new("grid", format!("{nx} × {ny} × {nz} positions of P")),
        Fact::new("locations", locations.join(", ")),
        Fact::new("tolerance", format!("{} mm", study.tolerance)),
    ];
    facts.extend(error_facts(&study.scene.machine, &study.scene.errors));
    facts
}

fn grid(study: &SuperpositionStudy, title: &str, table: &str) -> Explorer {
    let mark = |point: &crate::machine::NamedPoint| Mark {
        label: point.name.clone(),
        position: point.position.iter().copied().collect(),
    };
    Explorer {
        title: title.into(),
        table: table.into(),
        shape: Shape::Grid,
        coordinates: ["x", "y", "z"].map(|axis| Column::new(format!("{axis}_mm"), axis, "mm")).into(),
        group: None,
        quantities: Vec::new(),
        marks: study.scene.machine.points.iter().map(mark).collect(),
    }
}

fn departure_map(study: &SuperpositionStudy) -> Explorer {
    let value = |sum: &str, followed: &str, label: &str| GroupValue {
        cells: vec![sum.into(), followed.into()],
        label: label.into(),
    };
    let group = Group {
        columns: vec!["sum".into(), "followed".into()],
        label: "sum and point followed".into(),
        values: vec![
            value("superposition", "tool", "superposition, tool tip"),
            value("superposition", "platform", "superposition, platform point"),
            value("aggregation", "tool", "eqs. (14), (15), tool tip"),
            value("aggregation", "platform", "eqs. (14), (15), platform point"),
        ],
    };
    let mut quantities = vec![
        Quantity::new(["departure_mm"], "departure", "mm", Better::Smaller),
        Quantity::new(["largest_ratio"], "largest departure over displacement", "", Better::Smaller),
        Quantity::new(["simultaneous_mm"], "displacement by both at that angle", "mm", Better::Smaller),
        Quantity::new(["departure_phi_deg"], "tool angle of the largest departure", "°", Better::Neither),
    ];
    for axis in ["x", "y", "z"] {
        let column = format!("departure_{axis}_mm");
        quantities.push(Quantity::new([column], &format!("departure along {axis}"), "mm", Better::Neither));
    }
    Explorer { group: Some(group), quantities, ..grid(study, DEPARTURE, "map.csv") }
}

fn safe_map(study: &SuperpositionStudy) -> Explorer {
    let factor =
        Quantity::new(["largest_load_factor"], "largest load factor that keeps the tolerance", "", Better::Larger);
    Explorer { quantities: vec![factor], ..grid(study, SAFE, "safe_load.csv") }
}
