//! `kinetostat run` of a superposition study, end to end.

use std::{collections::BTreeSet, fs, path::Path};

use crate::support::command::kinetostat;
use serde_json::Value;

const STUDY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/05_superposition");

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn run(study: &str, folder: &Path, more: &[&str], code: i32) -> String {
    let output = kinetostat(&[&["run", "--verbose", study, "--out", folder.to_str().unwrap()], more].concat());
    assert_eq!(output.status.code(), Some(code), "{}{}", text(&output.stdout), text(&output.stderr));
    text(&output.stdout)
}

fn names(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// Cells of a table by column name.
fn column(folder: &Path, table: &str, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_path(folder.join(table)).unwrap();
    let index = reader.headers().unwrap().iter().position(|h| h == name).unwrap_or_else(|| panic!("{table}: {name}"));
    reader.records().map(|row| row.unwrap()[index].to_string()).collect()
}

#[test]
fn a_superposition_study_leaves_tables_figures_and_an_answer_the_same_for_any_thread_count() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = ["one", "two"].map(|name| folder.path().join(name));
    let said = run(STUDY, &one, &["--grid", "3", "--threads", "1"], 0);
    run(STUDY, &two, &["--grid", "3", "--threads", "2"], 0);
    let tables = ["map", "safe_load", "locations", "largest_factors", "scaling", "slopes", "ablation"];
    let maps = ["superposition_tool", "superposition_platform", "ratio_tool", "aggregation_tool", "safe_load"];
    let places = ["1_Q0", "2_Q1", "3_Q2", "4_Q3"];
    let mut expected: BTreeSet<String> = tables.map(|table| format!("{table}.csv")).into();
    expected
        .extend(["csv-metadata.json", "summary.json", "manifest.json", "report.json", "report.html"].map(String::from));
    expected.extend(places.iter().flat_map(|p| [format!("growth_{p}_data.csv"), format!("ablation_{p}_data.csv")]));
    let stems = maps.iter().map(|map| format!("slices_{map}"));
    let stems = stems.chain(places.iter().flat_map(|p| [format!("growth_{p}"), format!("ablation_{p}")]));
    let stems = stems.chain(["machine_at_home", "answer", "answer_portrait"].map(String::from));
    expected.extend(stems.flat_map(|stem| [format!("{stem}.svg"), format!("{stem}.png")]));
    assert_eq!(names(&one), expected);
    for name in expected.iter().filter(|name| *name != "manifest.json") {
        let [a, b] = [&one, &two].map(|folder| fs::read(folder.join(name)).unwrap());
        assert!(a == b, "{name} depends on the threads");
        if name.ends_with(".svg") {
            assert!(!text(&a).contains("NaN"), "{name}");
        }
    }
    for (table, rows) in tables.iter().zip([4 * 27, 27, 16, 12, 336, 48, 4 * 36 * 12]) {
        assert_eq!(column(&one, &format!("{table}.csv"), "status").len(), rows, "{table}");
    }
    for said_of in [
        "Superposition error at the tool tip: up to 0.0260 mm",
        "is within the tolerance of ",
        "Q3: superposition error up to ",
    ] {
        assert!(said.contains(said_of), "{said_of} is missing in\n{said}");
    }
    let summary: Value = serde_json::from_slice(&fs::read(one.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["grid_points_solved"], 27);
    let shares = summary["locations"][1]["causes"]["shares"].as_object().unwrap();
    let whole: f64 = shares.values().map(|share| share.as_f64().unwrap()).sum();
    assert!((whole - 1.0).abs() < 1e-9, "{shares:?}");
}

#[test]
fn a_study_partly_out_of_reach_says_so_and_without_figures_writes_tables_only() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    fs::create_dir_all(&study).unwrap();
    let written = fs::read_to_string(Path::new(STUDY).join("study.toml")).unwrap();
    let far = written.replace("{ point = \"Q3\" }", "{ name = \"beyond the rails\", position_mm = [900.0, 0.0, 0.0] }");
    let far = far.replace("slices_z_mm", "min_mm = [-400.0, 0.0, -150.0]\nmax_mm = [400.0, 0.0, 150.0]\nslices_z_mm");
    assert_ne!(far, written);
    fs::write(study.join("study.toml"), far).unwrap();
    let out = folder.path().join("out");
    let said = run(study.to_str().unwrap(), &out, &["--grid", "3,1,1", "--no-figures"], 1);
    assert!(said.contains("not solved: ") && said.contains("unreachable. What follows rests on the rest."), "{said}");
    assert!(said.contains("beyond the rails: unreachable: "), "{said}");
    assert!(names(&out).iter().all(|name| ["csv", "json", "html"].iter().any(|end| name.ends_with(end))));
    for (table, name) in
        [("map.csv", "superposition_error_mm"), ("scaling.csv", "superposition_error_mm"), ("ablation.csv", "part_mm")]
    {
        for ((status, reason), cell) in
            column(&out, table, "status").iter().zip(column(&out, table, "reason")).zip(column(&out, table, name))
        {
            assert_eq!(status == "solved", reason.is_empty(), "{table}: {status} {reason}");
            assert_eq!(status == "solved", cell.parse::<f64>().is_ok_and(f64::is_finite), "{table}: {status} {cell}");
        }
    }
}

#[test]
fn without_chain_errors_nothing_is_wrong_and_one_is_singular() {
    let folder = tempfile::tempdir().unwrap();
    let written = fs::read_to_string(Path::new(STUDY).join("study.toml")).unwrap();
    let (head, _) = written.split_once("[[process.chain_error]]").unwrap();
    let (_, tail) = written.split_once("[superposition]").unwrap();
    let plain = format!("{head}[superposition]{tail}").replace("phi_step_deg = 10.0", "phi_step_deg = 360.0");
    fs::write(folder.path().join("study.toml"), plain).unwrap();
    let out = folder.path().join("out");
    let said = run(folder.path().to_str().unwrap(), &out, &["--grid", "1", "--no-figures"], 0);
    let said_in_lines = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        said_in_lines.contains("Computed from 1 grid point, 1 tool angle, a cutting force of 217 N, inputs taken as exact, all points solved"),
        "{said}"
    );
    assert!(said.contains("\nQ1: superposition error up to 0 mm"), "{said}");
    assert!(!said.contains("none)") && !said.contains("0.000"), "{said}");
}

#[test]
fn points_along_a_path_are_refused() {
    let output = kinetostat(&["run", STUDY, "--points", "9"]);
    assert_eq!(output.status.code(), Some(2));
    let message = "error: --points: a superposition study has no points along a path, but a grid\n";
    assert_eq!(text(&output.stderr), message);
}
