//! Machines of the catalogue: golden maps, and numbers that others report of them.

use std::fs;

use crate::support::{
    engine::{at_position, catalogue_machine},
    golden::check,
};
use kinetostat::{
    files::exchange::csv,
    machine::catalogue,
    questions::{
        Overrides, Study, StudyKind,
        map::{self, report::table},
    },
    statics::{Scratch, unloaded_compliance},
    work::Work,
};
use nalgebra::Vector3;

/// What the convergence tolerance of the equilibria leaves open when rounding differs between machines.
const MAP_TOLERANCE: f64 = 1e-7;

/// The corners of the workspace under a light cut.
const STUDY: &str = r#"
schema = 3
question = "Is this machine the one it was?"
machine = "NAME"

[process.force.path_frame]
radial_force_N = 20.0
tangential_force_N = -5.0
axial_force_N = -10.0
law = "rotated"

[process.compensate]
target = "tool_tip"

[[process.chain_error]]
chain = "CHAIN"
base_translation_mm = [0.1, -0.2, 0.3]

[workspace_map]
grid = [2, 2, 2]
slices_z_mm = [HEIGHT]
phi_step_deg = 45.0
"#;

#[test]
fn maps_are_the_golden_ones() {
    // Studies 01 to 06 hold the Orthoglide, and independent states the tripteron.
    for entry in catalogue::ENTRIES.iter().filter(|entry| !["orthoglide", "tripteron"].contains(&entry.name)) {
        let folder = tempfile::tempdir().unwrap();
        let machine = catalogue_machine(entry.name);
        let height = format!("{:?}", machine.workspace.min.z);
        let text =
            STUDY.replace("NAME", entry.name).replace("CHAIN", &machine.chains[0].name).replace("HEIGHT", &height);
        fs::write(folder.path().join("study.toml"), text).unwrap();
        let study = Study::open(folder.path(), &Overrides::default()).unwrap_or_else(|e| panic!("{e}"));
        let StudyKind::WorkspaceMap(map, _) = study.kind else { panic!("a workspace map") };
        let table = table(&map, &map::run(&map, &Work::default()).unwrap().points);
        let text = String::from_utf8(csv(&table).unwrap()).unwrap();
        assert!(!text.contains("unreachable") && !text.contains("buckled"), "{}:\n{text}", entry.name);
        check(&format!("catalogue_{}", entry.name), &text, MAP_TOLERANCE);
    }
}

/// Compliances of arXiv 0904.0052 at Q0, Q1, Q2, quoted second-hand: mm/N, then rad/(N·mm).
const QUOTED: [(&str, [f64; 3], [f64; 3]); 2] = [
    ("delta_3puu", [2.78e-4, 10.9e-4, 71.3e-4], [20.9e-7, 24.1e-7, 25.8e-7]),
    ("delta_3prpar", [2.78e-4, 9.86e-4, 21.2e-4], [1.94e-7, 2.06e-7, 2.65e-7]),
];
/// How far the identified machines are from them at most.
const LEFT: f64 = 0.046;

#[test]
fn linear_deltas_have_the_compliances_quoted() {
    for (name, translation, rotation) in QUOTED {
        let machine = catalogue_machine(name);
        for (i, place) in ["Q0", "Q1", "Q2"].iter().enumerate() {
            let at = at_position(&machine, machine.point(place).unwrap().position);
            let compliance = unloaded_compliance(&machine, &at, &mut Scratch::new(&machine)).unwrap();
            let diagonal = compliance.diagonal();
            for (offset, quoted) in [(0, translation[i]), (3, rotation[i])] {
                let along = Vector3::from_fn(|k, _| diagonal[offset + k]);
                // The three axes are alike on the diagonal of the workspace.
                assert!(along.amax() - along.amin() < 1e-7 * along.amax(), "{name} at {place}: {along:?}");
                let ratio = along[0] / quoted;
                println!("{name} {place}: {:.4e}, quoted {quoted:e}, ratio {ratio:.3}", along[0]);
                assert!((ratio - 1.0).abs() < LEFT, "{name} at {place}: {}, quoted {quoted}", along[0]);
            }
        }
    }
}
