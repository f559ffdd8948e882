//! What the page of a path study shows.

use crate::{
    answer::{Said, source_group},
    files::words::counted,
    machine::Machine,
    page::{
        Better, Column, Description, Explorer, Fact, MachineDescription, Quantity, Section, Shape, TableNote,
        drive_quantities, error_facts, largest_of_drives,
    },
    questions::path::{PathStudy, Shown, report::cutting_force},
    redundancy,
};

/// Sections, setting, views and tables; first screen, figures and question are added by the run.
pub fn page(study: &PathStudy, shown: &Shown, text: &Said) -> Description {
    Description {
        setting: setting(study, shown),
        explorers: vec![along(study), methods()],
        tables: tables(study),
        sections: sections(study, text),
        ..Description::new("path", MachineDescription::new(&study.machine))
    }
}

fn tables(study: &PathStudy) -> Vec<TableNote> {
    let points =
        "One row per point and source of error: displacement without compensation, command and forces with it.";
    let mut tables = vec![
        TableNote::new("methods.csv", "One row per method: corrections it needs and errors it leaves."),
        TableNote::ranked("points.csv", points, "displacement_mm"),
    ];
    if study.turn.is_some() {
        let turns = "One row per point: the turn about the tool's axis, and what it leaves, beside the programmed and the best constant one.";
        tables.push(TableNote::ranked("tool_turn.csv", turns, "cost_mm"));
    }
    tables
}

fn sections(study: &PathStudy, text: &Said) -> Vec<Section> {
    let turn =
        study.turn.as_ref().and_then(|turn| Some(redundancy::report::sentence(turn.found.as_deref()?, turn.how())));
    let turned = turn.map(|sentence| {
        Section::new("How is the tool turned?", "the turn about its axis, which is free")
            .text(&sentence)
            .tables(["tool_turn.csv"])
    });
    let mut sections = vec![
        Section::new("Where is the tool off how far?", "along the path, and on the part")
            .text(&text.place)
            .explorers([ALONG])
            .figures(&["paths", "displacement"]),
        Section::new("Why?", "cutting force, chain errors and weight one by one; the machine bent")
            .text(&text.cause)
            .figures(&["cutting_force", "delta_rho_sources", "machine_bent"]),
        Section::new("What to tell the drives?", "corrections and drive forces along the path; how each method does")
            .text(&text.remedy)
            .explorers([METHODS])
            .figures(&["delta_rho", "drive_"])
            .tables(["methods.csv"]),
    ];
    sections.extend(turned);
    sections
}

/// Titles of the views.
const ALONG: &str = "Along the path";
const METHODS: &str = "Methods of compensation";

fn setting(study: &PathStudy, shown: &Shown) -> Vec<Fact> {
    let length = study.stations.last().map_or(0.0, |station| station.arc_length_mm);
    let kind = if shown.is_circle { "circle" } else { "path" };
    let mut facts = vec![
        Fact::new("machine", study.machine.title.clone()),
        Fact::new("path", format!("{kind} of {length:.1} mm, {}", counted(study.stations.len(), "point"))),
        Fact::new(
            "best and worst",
            "over these points of this path alone, each at the angle of the force that it has there",
        ),
    ];
    facts.extend(study.facts.iter().map(|(label, words)| Fact::new(*label, words.clone())));
    let forces = study.demands.iter().map(|demand| demand.load.force.norm());
    let (low, high) = forces.fold((f64::INFINITY, 0.0f64), |(low, high), force| (low.min(force), high.max(force)));
    if high > 0.0 {
        facts.push(Fact::new("force on the tool", format!("{low:.1} N to {high:.1} N along the path")));
    } else {
        facts.push(Fact::new("force on the tool", "none"));
    }
    if let Some(demand) = study.demands.first() {
        facts.push(Fact::new("compensation holds", demand.target.words()));
    }
    facts.extend(study.turn.as_ref().map(|turn| Fact::new("turn about the tool's axis", turn.redundancy().words())));
    facts.extend(study.machine.held_words().map(|words| Fact::new("held", words)));
    facts.extend(error_facts(&study.machine, &study.errors));
    facts
}

fn along(study: &PathStudy) -> Explorer {
    let machine = &study.machine;
    let mut first =
        vec![Quantity::new(["displacement_mm"], "displacement without compensation", "mm", Better::Smaller)];
    first.extend(largest_of_drives(machine));
    first.push(Quantity::new(["error_left_mm"], "error left by compensation", "mm", Better::Smaller));
    let mut view = points_view(machine, ALONG.into(), "points.csv".into(), first);
    view.quantities.extend(cutting_force::quantities());
    view
}

/// A view of a table of path points: the quantities `first`, then each component of displacement, correction and force.
pub(crate) fn points_view(machine: &Machine, title: String, table: String, first: Vec<Quantity>) -> Explorer {
    let mut quantities = first;
    for axis in ["x", "y", "z"] {
        let column = format!("displacement_{axis}_mm");
        quantities.push(Quantity::new([column], &format!("displacement along {axis}"), "mm", Better::Neither));
    }
    quantities.extend(drive_quantities(machine, Better::Neither));
    quantities.push(Quantity::new([ANGLE[0]], ANGLE[1], "°", Better::Neither));
    Explorer {
        title,
        table,
        shape: Shape::Curve,
        coordinates: along_columns(),
        group: Some(source_group(machine)),
        quantities,
        marks: Vec::new(),
    }
}

/// Column and label of the tool angle.
pub(crate) const ANGLE: [&str; 2] = ["phi_deg", "tool angle φ"];

/// What curves along a path can be seen over.
pub(crate) fn along_columns() -> Vec<Column> {
    vec![Column::new("arc_length_mm", "length along the path", "mm"), Column::new(ANGLE[0], ANGLE[1], "°")]
}

fn methods() -> Explorer {
    Explorer {
        title: METHODS.into(),
        table: "methods.csv".into(),
        shape: Shape::Names,
        coordinates: vec![Column::new("method", "method", "")],
        group: None,
        quantities: vec![
            Quantity::new(["error_max_mm"], "largest error left", "mm", Better::Smaller),
            Quantity::new(["error_rms_mm"], "rms error left", "mm", Better::Smaller),
            Quantity::new(["corrections_mean"], "steps per point", "", Better::Smaller),
            Quantity::new(["leftover_rotation_max_deg"], "leftover rotation", "°", Better::Neither),
        ],
        marks: Vec::new(),
    }
}
