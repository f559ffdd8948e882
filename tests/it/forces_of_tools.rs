//! Cutting forces of single tools and of features of a program.

use std::path::Path;

use kinetostat::{
    machine::Machine,
    process::{Process, cutting::PathLoad},
    toolpath::{Sampling, Toolpath, gcode::GcodeProgram},
};
use nalgebra::{Matrix3, Vector3};

use crate::support::command::told;

const PROGRAM: &str = "\
G21 G90 G17
T1 M6 (end mill)
S8000 M3 F600
G0 X0 Y0 Z-5
G1 Z2
T2 (waits in the magazine)
G1 X20
(Finish)
G1 Y20
G0 Z-5
M6
G0 X0 Y0
G81 X0 Y0 Z10 R-1 F300
G80
M30
";

const FORCES: &str = "\
[force_of_tool.1.path_frame]
radial_force_N = 100.0
tangential_force_N = 0.0
axial_force_N = -20.0
[force_of_tool.2.drilling]
diameter_mm = 8.0
material_constant = 2.41
feed_per_rev_mm = 0.15
[force_of_feature.Finish.path_frame]
radial_force_N = 30.0
tangential_force_N = 0.0
axial_force_N = -5.0
";

fn process(text: &str) -> Process {
    let machine = Machine::named_or_file("orthoglide").unwrap();
    Process::from_toml(&format!("schema = 1\n{text}"), "process.toml", Path::new(""), &machine).unwrap()
}

fn path(process: &Process, source: &str) -> Toolpath {
    GcodeProgram::parse(source, "part.nc", &process.gcode).unwrap().toolpath(Sampling::default()).unwrap()
}

fn fault(forces: &str, source: &str) -> String {
    let process = process(forces);
    process.loads(&path(&process, source)).unwrap_err().to_string()
}

/// Forces where the tool cuts, N, axes of a tool along z, without those that repeat the one before.
fn forces(forces: &str, source: &str) -> Vec<[f64; 3]> {
    let process = process(forces);
    let path = path(&process, source);
    let loads: Vec<PathLoad> = process.loads(&path).unwrap();
    let cutting = path.points().iter().zip(loads).filter(|(point, _)| point.cutting);
    let force = |tangent: Vector3<f64>, load: PathLoad| load.on_tool(tangent, &Matrix3::identity()).force_N;
    let mut forces: Vec<[f64; 3]> = cutting
        .map(|(point, load)| force(point.tangent, load).map(|f| (f * 10.0).round() / 10.0 + 0.0).into())
        .collect();
    forces.dedup();
    forces
}

#[test]
fn the_tool_in_the_spindle_and_the_feature_decide() {
    let expected = [
        // Plunge: nothing but the axial force.
        [0.0, 0.0, -20.0],
        // Along x to the right, seen from the workpiece. The tool that waits does not cut.
        [0.0, -100.0, -20.0],
        // The feature, along y; no longer behind the tool change.
        [30.0, 0.0, -5.0],
        [0.0, 0.0, 2191.1],
    ];
    let found = forces(FORCES, PROGRAM);
    assert_eq!(found[..3], expected[..3]);
    // The thrust is out of the spindle's way: against the hole, into the spindle or out of it as the law says.
    assert_eq!(found[3..].len(), 1, "{found:?}");
    assert_eq!((found[3][0], found[3][1], found[3][2].abs()), (0.0, 0.0, expected[3][2]));
}

#[test]
fn before_the_first_change_the_last_tool_named_is_in_the_spindle() {
    let source = "G21 G90\nT5\nT1\nG0 X0 Y0 Z0\nG1 X5 F100\nM30\n";
    let force = "[force_of_tool.1.path_frame]\nradial_force_N = 7.0\ntangential_force_N = 0.0\naxial_force_N = 0.0\n";
    assert_eq!(forces(force, source), [[0.0, -7.0, 0.0]]);
}

#[test]
fn other_languages_call_their_tools_too() {
    let force = "[force_of_tool.3.path_frame]\nradial_force_N = 7.0\ntangential_force_N = 0.0\naxial_force_N = 0.0\n";
    for source in [
        "0 BEGIN PGM A MM\n1 TOOL CALL 3 Z S2000\n2 L X+0 Y+0 Z+0 R0 FMAX M3\n3 L X+5 R0 F100\n4 END PGM A MM\n",
        "N10 G90 G71 G17\nN20 T3 D1\nN30 M6\nN40 G0 X0 Y0 Z0\nN50 G1 X=5 F100\nN60 M30\n",
        "N10 G90 G71 G17\nN20 T=3 D1\nN40 G0 X0 Y0 Z0\nN50 G1 X=5 F100\nN60 M30\n",
    ] {
        assert_eq!(forces(force, source), [[0.0, -7.0, 0.0]], "{source}");
    }
}

#[test]
fn others_have_the_force_of_all() {
    let all = "[force.path_frame]\nradial_force_N = 1.0\ntangential_force_N = 0.0\naxial_force_N = 0.0\n";
    let source = PROGRAM.replace("T1 M6", "T9 M6");
    assert_eq!(forces(&format!("{all}{FORCES}"), &source)[1], [0.0, -1.0, 0.0]);
}

#[test]
fn what_has_no_force_is_named() {
    assert_eq!(
        fault(FORCES, &PROGRAM.replace("T1 M6", "T9 M6")),
        "tool 9 cuts on move 2 and has no force: expected [force_of_tool.9], or [force] for all tools without a force of \
         their own"
    );
    assert_eq!(
        fault(FORCES, &PROGRAM.replace("(Finish)", "(Finishing)")),
        "nothing is cut in the feature \"Finish\" of force_of_feature: expected a line of the program with this text"
    );
    let tools = FORCES.split("[force_of_feature").next().unwrap();
    assert_eq!(
        fault(tools, "G21 G90\nG0 X0 Y0 Z0\nG1 X5 F100\nM30\n"),
        "the path does not say which tool cuts, which force_of_tool asks for: expected a program with T, or one force, \
         [force]"
    );
}

#[test]
fn a_program_is_corrected_under_the_forces_of_its_tools() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(folder.path().join("part.nc"), PROGRAM).unwrap();
    std::fs::write(folder.path().join("process.toml"), format!("schema = 1\n{FORCES}")).unwrap();
    let (part, process, out) = (at("part.nc"), at("process.toml"), at("part_c.nc"));
    let arguments = ["compensate", &part, "--machine", "orthoglide", "--process", &process, "--out", &out, "--verbose"];
    let (code, said, errors) = told(&arguments);
    assert_eq!(code, Some(0), "{said}{errors}");
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("its own for tool 1, tool 2, \"Finish\""), "{said}");
    let points = std::fs::read_to_string(folder.path().join("part_c.nc.points.csv")).unwrap();
    let thrust =
        |line: &str| line.split(",").filter_map(|cell| cell.parse::<f64>().ok()).any(|f| (f + 2191.086).abs() < 1e-3);
    assert!(points.lines().any(thrust), "{points}");
}
