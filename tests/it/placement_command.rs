//! `kinetostat run` of a placement study and `kinetostat compare`, end to end.

use crate::support::command::kinetostat;
use serde_json::Value;

const STUDIES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies");

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_placement_study_leaves_tables_figures_and_a_recommendation() {
    let out = tempfile::tempdir().unwrap();
    let study = format!("{STUDIES}/03_placement_circle");
    let folder = out.path().to_str().unwrap();
    let output = kinetostat(&["run", "--verbose", &study, "--grid", "5,5,3", "--points", "25", "--out", folder]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("origin of the groove") && said.contains("\nBest place: "), "{said}");
    assert!(said.contains("refinements end there"), "{said}");
    assert!(said.contains("Worst deflection at the named places: Q0 "), "{said}");
    assert!(said.contains(": 1 feature, 25 path points; ") && !said.contains("(-"), "{said}");
    let files = ["candidates.csv", "sweep.csv", "refinements.csv", "pareto.csv", "map_worst_deflection.png"];
    for name in files.iter().chain(&["pareto.svg", "path_errors_groove.svg", "paths_groove.png", "manifest.json"]) {
        assert!(out.path().join(name).is_file(), "{name} is missing");
    }
    let summary: Value = serde_json::from_slice(&std::fs::read(out.path().join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["sweep"]["places"], 75);
    assert_eq!(summary["entries"][0]["objective"], summary["best"]["objective"]);
    assert_eq!(summary["flatness"].as_array().unwrap().len(), 6);
}

#[test]
fn places_are_compared_side_by_side() {
    let process = format!("{STUDIES}/04_placement_pocket/process.toml");
    let path = format!("{STUDIES}/04_placement_pocket/pocket.nc");
    let common = ["compare", "--machine", "orthoglide", "--process", &process, "--path", &path];
    let output = kinetostat(&[&common[..], &["--at", "50,0,100,90", "--at", "Q0", "--csv"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    // At Q3, a corner of the workspace box, the path leaves it: the numbers are told, and so is that.
    let output = kinetostat(&[&common[..], &["--at", "Q3", "--at", "50,0,100,90", "--at", "Q0", "--csv"]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    let last = said.lines().last().unwrap();
    assert!(last.starts_with(",Q3,named,") && last.contains(",outside_workspace,"), "{last}");
    assert!(last.contains("is outside the machine's workspace box"), "{last}");
    let names: Vec<&str> = said.lines().skip(1).filter_map(|line| line.split(',').nth(1)).collect();
    // A name with commas is quoted.
    assert_eq!(names, ["Q0", "\"50", "Q3"]);
    let output = kinetostat(&[&common[..], &["--at", "Q0", "--at", "400,0,0"]].concat());
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stdout);
    assert!(said.contains("unreachable") && said.contains("cannot close"), "{said}");
    for (at, message) in [
        ("Q9", "--at: machine orthoglide has no point \"Q9\"; there are: Q0, Q1, Q2, Q3"),
        (
            "1,2,3,4,5",
            "--at: \"1,2,3,4,5\": expected x,y,z in mm, or x,y,z,yaw or x,y,z,yaw,pitch,roll with angles in degrees",
        ),
        ("1,2", "--at: \"1,2\": expected x,y,z in mm, or x,y,z,yaw or x,y,z,yaw,pitch,roll with angles in degrees"),
        (
            "0,0,0,0,5,0",
            "--at: pitch of \"0,0,0,0,5,0\": machine orthoglide does not control rotation about y, so its tool cannot \
             follow a workpiece tilted so: expected 0",
        ),
        (
            "1,2,nan",
            "--at: \"1,2,nan\": expected x,y,z in mm, or x,y,z,yaw or x,y,z,yaw,pitch,roll with angles in degrees",
        ),
    ] {
        let output = kinetostat(&[&common[..], &["--at", at]].concat());
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(text(&output.stderr), format!("error: {message}\n"));
    }
}
