//! A process with its own tool: the same as a machine file with that tool, whatever is asked.

use std::{fs, path::Path};

use kinetostat::{
    machine::{Machine, catalogue},
    process::Process,
    questions::{Overrides, Study, StudyKind, map, path, placement},
    work::Work,
};

use crate::support::engine::machine_from;

/// Tools of a process, and of the machine file that says the same.
const CUTTER: [&str; 2] = [
    "tip_mm = [0.0, 0.0, 340.0]\ncutter = { diameter_mm = 8.0, stick_out_mm = 60.0, material = \"carbide\" }\n",
    "tool_tip_mm = [0.0, 0.0, 340.0]\ntool_axis = [0.0, 0.0, 1.0]\ntool = { cutter = { diameter_mm = 8.0, stick_out_mm = 60.0, material = \"carbide\" } }\n",
];
const LONG: [&str; 2] = [
    "tip_mm = [0.0, 30.0, 420.0]\naxis = [0.0, 0.0, 2.0]\n",
    "tool_tip_mm = [0.0, 30.0, 420.0]\ntool_axis = [0.0, 0.0, 2.0]\n",
];
const CARBIDE: &str = "youngs_modulus_N_per_mm2 = 600000.0\nshear_modulus_N_per_mm2 = 240000.0\n";
const FORCE: &str = "[force.path_frame]\nradial_force_N = 215.0\ntangential_force_N = -10.0\naxial_force_N = -25.0\n";

/// The KR 270, with `platform` in place of its tool tip.
fn kr270(platform: &str) -> String {
    let text = catalogue::find("kr270").unwrap().toml;
    let given = "tool_tip_mm = [0.0, 0.0, 300.0]\ntool_axis = [0.0, 0.0, 1.0]\n";
    text.replacen(given, platform, 1) + "\n[material.carbide]\n" + CARBIDE
}

fn process(tool: &str) -> String {
    format!("schema = 1\n{FORCE}{tool}")
}

fn with_tool(tool: &str) -> String {
    process(&format!("[tool]\n{tool}[tool.material.carbide]\n{CARBIDE}"))
}

/// A folder with a KR 270 as it is and with the tools, and processes with and without them.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("plain.toml", catalogue::find("kr270").unwrap().toml);
    write("process.toml", &process(""));
    for (name, [own, of_machine]) in [("cutter", CUTTER), ("long", LONG)] {
        write(&format!("kr270_{name}.toml"), &kr270(of_machine));
        write(&format!("{name}.toml"), &with_tool(own));
    }
    folder
}

fn study(folder: &Path, text: &str) -> StudyKind {
    let text = format!("schema = 3\nquestion = \"how far?\"\n{text}");
    Study::from_toml(&text, "study.toml", folder.to_path_buf(), &Overrides::default()).unwrap().kind
}

#[test]
fn a_map_with_the_tool_of_its_process_is_that_of_a_machine_with_it() {
    let folder = folder();
    let points = |machine: &str, process: &str| {
        let text = format!(
            "machine = \"{machine}\"\nprocess = \"{process}\"\n[workspace_map]\ngrid = [2, 2, 2]\nphi_step_deg = 45.0\nslices_z_mm = [900.0]\n"
        );
        let StudyKind::WorkspaceMap(study, _) = study(folder.path(), &text) else { panic!("a map") };
        serde_json::to_string(&map::run(&study, &Work::default()).unwrap().points).unwrap()
    };
    for name in ["cutter", "long"] {
        let own = points("plain.toml", &format!("{name}.toml"));
        assert_eq!(own, points(&format!("kr270_{name}.toml"), "process.toml"), "{name}");
        assert_ne!(own, points("plain.toml", "process.toml"), "{name}");
    }
}

#[test]
fn a_path_with_the_tool_of_its_process_is_that_of_a_machine_with_it() {
    let folder = folder();
    let displacements = |machine: &str, process: &str| {
        let text = format!(
            "machine = \"{machine}\"\nprocess = \"{process}\"\n[path]\nline = {{ start_mm = [1700.0, -50.0, 600.0], end_mm = [1700.0, 50.0, 600.0] }}\nmethods = []\n"
        );
        let StudyKind::Path(study, _) = study(folder.path(), &text) else { panic!("a path") };
        let has_fact = study.facts.iter().any(|(label, words)| *label == "tool" && words.contains("tip at"));
        let results = path::run(&study, &Work::default()).unwrap();
        (serde_json::to_string(&results.whole).unwrap(), has_fact)
    };
    for name in ["cutter", "long"] {
        let (own, has_fact) = displacements("plain.toml", &format!("{name}.toml"));
        assert!(has_fact, "{name}: the tool is told");
        assert_eq!(own, displacements(&format!("kr270_{name}.toml"), "process.toml").0, "{name}");
    }
}

#[test]
fn features_are_each_cut_with_their_own_tool() {
    let folder = folder();
    let evaluated = |machine: &str, processes: &[&str]| {
        let mut text = format!(
            "machine = \"{machine}\"\n[placement.bounds]\nx_mm = [1600.0, 1800.0]\n[placement.fixed]\ny_mm = 0.0\nz_mm = 600.0\nyaw_deg = 0.0\n[placement.objective]\nweights = {{ worst_deflection = 1.0 }}\n[placement.search]\ngrid = {{ x = 2 }}\nstarts = 1\n"
        );
        for (i, process) in processes.iter().enumerate() {
            text += &format!(
                "[[placement.feature]]\nname = \"f{i}\"\nprocess = \"{process}\"\ntolerance_mm = 0.1\ncircle = {{ diameter_mm = 40.0, centre_mm = [0.0, 0.0, 0.0], points = 12 }}\n"
            );
        }
        let StudyKind::Placement(study, _) = study(folder.path(), &text) else { panic!("a placement") };
        let site = placement::Site([1700.0, 0.0, 600.0, 0.0, 0.0, 0.0]);
        let found = placement::Evaluator::new(&study, &[placement::Metric::WorstDeflection]).evaluate(&site).unwrap();
        found.features.iter().map(|feature| format!("{feature:?}")).collect::<Vec<_>>()
    };
    let together = evaluated("plain.toml", &["cutter.toml", "long.toml"]);
    assert_ne!(together[0], together[1]);
    assert_eq!(together[0], evaluated("kr270_cutter.toml", &["process.toml", "process.toml"])[0]);
    assert_eq!(together[1], evaluated("kr270_long.toml", &["process.toml", "process.toml"])[1]);
}

#[test]
fn wrong_tools_are_refused_by_their_own_keys() {
    let machine = machine_from(catalogue::find("kr270").unwrap().toml);
    let bent = machine_from(&kr270(CUTTER[1]));
    let refused = |machine: &Machine, tool: &str| {
        let text = process(&format!("[tool]\n{tool}"));
        Process::from_toml(&text, "p.toml", Path::new(""), machine).unwrap_err().to_string()
    };
    let cases = [
        (
            "cutter = { diameter_mm = -8.0, stick_out_mm = 60.0, material = \"s\" }",
            "p.toml: tool.cutter.diameter_mm: must be greater than 0, got -8",
        ),
        ("axis = [0.0, 0.0, 0.0]", "p.toml: tool.axis: "),
        ("tip_mm = [0.0, nan, 0.0]", "p.toml: tool.tip_mm"),
        ("tip = [0.0, 0.0, 0.0]", "p.toml:7: tool.tip: unknown key"),
    ];
    for (tool, expected) in cases {
        let found = refused(&machine, tool);
        assert!(found.starts_with(expected), "{tool}: {found}");
    }
    let elsewhere = "p.toml: tool: the machine file's tool is elastic, and the process has another tool: give the cutter or compliance_mm_rad_N of that tool as well";
    assert_eq!(refused(&bent, "tip_mm = [0.0, 0.0, 100.0]"), elsewhere);
    let twice = refused(&bent, &format!("[tool.material.carbide]\n{CARBIDE}"));
    assert_eq!(twice, "p.toml: tool.material.carbide: is a material of the machine file: choose another name");
}
