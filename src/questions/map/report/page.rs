//! What the page of a workspace map shows.

use crate::{
    answer::{Said, source_group::source_group},
    files::words::{counted, typographic},
    inspect::machine_check::report::tool_axis_fact,
    page::{
        Better, Column, Description, Explorer, Fact, MachineDescription, Mark, Quantity, Section, Shape, TableNote,
        WORST_ANGLE, drive_quantities, error_facts, largest_of_drives,
    },
    process::ForceLaw,
    questions::map::WorkspaceMapStudy,
};

/// Sections, setting, views and tables; first screen, figures and question are added by the run.
pub fn page(study: &WorkspaceMapStudy, text: &Said) -> Description {
    let caption = "One row per grid point and source of error, worst over the tool angle.";
    Description {
        setting: setting(study),
        terms: vec![Fact::new("Positions", "of the platform point P, from the origin of the machine's base")],
        explorers: vec![explorer(study)],
        tables: vec![TableNote::ranked("map.csv", caption, "deflection_mm")],
        sections: sections(text),
        ..Description::new("workspace_map", MachineDescription::new(&study.machine))
    }
}

fn sections(text: &Said) -> Vec<Section> {
    vec![
        Section::new("Where does the tool move how far?", "the map, to slice, turn and click")
            .text(&text.place)
            .explorers([MAP])
            .figures(&["slices_deflection_all", "workspace_"]),
        Section::new("Why?", "cutting force, chain errors and weight one by one; stiffness; what adding them misses")
            .text(&text.cause)
            .figures(&["slices_deflection", "slices_stiffness", "slices_departure", "machine_bent"]),
        Section::new("What to tell the drives?", "the corrections that keep the tool on its path")
            .text(&text.remedy)
            .figures(&["slices_delta_rho"]),
    ]
}

/// Title of the view of the map.
const MAP: &str = "Workspace map";

fn setting(study: &WorkspaceMapStudy) -> Vec<Fact> {
    let [nx, ny, nz] = study.grid.counts();
    let span = |axis: usize| {
        let values = &study.grid.axes[axis];
        // The way to the middle of a box leaves rounding that must not show.
        let shown = |value: f64| (value * 1e9).round() / 1e9;
        let words = match values.as_slice() {
            [one] => format!("{} mm", shown(*one)),
            several => format!("{} to {} mm", shown(several[0]), shown(several[several.len() - 1])),
        };
        typographic(&words)
    };
    let force = &study.force;
    let law = match force.law {
        ForceLaw::Printed => "eq. (17) as printed",
        ForceLaw::Rotated => "eq. (17) as a rotation",
    };
    let forces = format!("{} N radial, {} N tangential, {} N axial", force.radial, force.tangential, force.axial);
    let mut facts = vec![
        Fact::new("machine", study.machine.title.clone()),
        Fact::new("cutting force", format!("{}; {law}", typographic(&forces))),
        Fact::new("tool axis", tool_axis_fact(&study.machine)),
        Fact::new("tool angles", format!("{} over a turn; the worst counts", study.phis.len())),
        Fact::new("grid", format!("{nx} × {ny} × {nz} positions of P, x {}, y {}, z {}", span(0), span(1), span(2))),
        Fact::new(
            "best and worst",
            format!(
                "over these {} and {}; between grid points, and on a path that bears another force, they are others",
                counted(study.grid.len(), "grid point"),
                counted(study.phis.len(), "tool angle")
            ),
        ),
        Fact::new("compensation holds", study.target.words()),
    ];
    facts.extend(study.machine.held_words().map(|words| Fact::new("held", words)));
    facts.extend(error_facts(&study.machine, &study.errors));
    facts
}

fn explorer(study: &WorkspaceMapStudy) -> Explorer {
    let machine = &study.machine;
    use Better::{Larger, Neither, Smaller};
    let mut quantities = vec![Quantity::new(["deflection_mm"], "worst tool deflection", "mm", Smaller)];
    quantities.extend(largest_of_drives(machine));
    quantities.extend([
        Quantity::new(["stiffness_min_N_per_mm"], "smallest principal stiffness", "N/mm", Larger),
        Quantity::new(["stiffness_mid_N_per_mm"], "middle principal stiffness", "N/mm", Larger),
        Quantity::new(["stiffness_max_N_per_mm"], "largest principal stiffness", "N/mm", Larger),
        Quantity::new(["departure_mm"], "departure of superposition", "mm", Smaller),
        Quantity::new(["departure_over_deflection"], "departure over deflection", "", Smaller),
        Quantity::new(["deflection_phi_deg"], WORST_ANGLE, "°", Neither),
    ]);
    for axis in ["x", "y", "z"] {
        let column = format!("deflection_{axis}_mm");
        quantities.push(Quantity::new([column], &format!("deflection along {axis}"), "mm", Neither));
    }
    quantities.extend(drive_quantities(machine, Smaller));
    Explorer {
        title: MAP.into(),
        table: "map.csv".into(),
        shape: Shape::Grid,
        coordinates: ["x", "y", "z"].map(|axis| Column::new(format!("{axis}_mm"), axis, "mm")).into(),
        group: Some(source_group(machine)),
        quantities,
        marks: machine
            .points
            .iter()
            .map(|point| Mark { label: point.name.clone(), position: point.position.iter().copied().collect() })
            .collect(),
    }
}
