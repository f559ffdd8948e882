//! `--format` and `--colours`: what other programs read, and the colours of maps.

use std::{
    collections::BTreeSet,
    fs::{self, File},
    path::Path,
};

use crate::support::command::kinetostat;
use parquet::{
    file::reader::{FileReader, SerializedFileReader},
    record::Field,
};
use serde_json::Value;

const STUDIES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies");

/// Runs a study into `folder`; what it prints.
fn run(study: &str, folder: &Path, more: &[&str]) -> String {
    let study = format!("{STUDIES}/{study}");
    let output = kinetostat(&[&["run", &study, "--out", folder.to_str().unwrap()], more].concat());
    let [said, complained] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert_eq!(output.status.code(), Some(0), "{said}{complained}");
    said
}

fn names(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn json(file: &Path) -> Value {
    serde_json::from_slice(&fs::read(file).unwrap()).unwrap()
}

/// Header and cells of a CSV file.
fn csv_cells(file: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(file).unwrap();
    reader.records().map(|row| row.unwrap().iter().map(String::from).collect()).collect()
}

/// Header and cells of a Parquet file, written as in CSV.
fn parquet_cells(file: &Path) -> Vec<Vec<String>> {
    let reader = SerializedFileReader::new(File::open(file).unwrap()).unwrap();
    let fields = reader.metadata().file_metadata().schema().get_fields().to_vec();
    let mut rows = vec![fields.iter().map(|field| field.name().to_string()).collect()];
    for row in reader.get_row_iter(None).unwrap() {
        let cell = |cell: &Field| match cell {
            Field::Null => String::new(),
            Field::Double(number) => number.to_string(),
            Field::Long(count) => count.to_string(),
            Field::Str(text) => text.clone(),
            other => panic!("{other:?}"),
        };
        rows.push(row.unwrap().get_column_iter().map(|(_, field)| cell(field)).collect());
    }
    rows
}

#[test]
fn all_formats_hold_the_same_tables() {
    let studies: [(&str, &[&str]); 5] = [
        ("01_workspace_map", &["--grid", "2"]),
        ("02_groove_50mm", &["--points", "13"]),
        ("03_placement_circle", &["--grid", "2", "--points", "13"]),
        ("05_superposition", &["--grid", "2"]),
        ("06_paper", &["--points", "13"]),
    ];
    for (study, size) in studies {
        let folder = tempfile::tempdir().unwrap();
        run(study, folder.path(), &[size, &["--format", "csv,parquet", "--no-figures"]].concat());
        let described = json(&folder.path().join("csv-metadata.json"));
        assert_eq!(
            (&described["@context"], &described["schema:version"]),
            (&"http://www.w3.org/ns/csvw".into(), &"2".into())
        );
        let tables = described["tables"].as_array().unwrap();
        let written: BTreeSet<String> =
            names(folder.path()).into_iter().filter(|name| name.ends_with(".csv")).collect();
        assert_eq!(tables.iter().map(|t| t["url"].as_str().unwrap().to_string()).collect::<BTreeSet<_>>(), written);
        for table in tables {
            let file = folder.path().join(table["url"].as_str().unwrap());
            let cells = csv_cells(&file);
            let titles =
                table["tableSchema"]["columns"].as_array().unwrap().iter().map(|c| c["titles"].as_str().unwrap());
            assert!(titles.eq(cells[0].iter()), "{}", file.display());
            assert_eq!(parquet_cells(&file.with_extension("parquet")), cells, "{}", file.display());
        }
    }
}

#[test]
fn only_the_formats_asked_for_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("01_workspace_map", folder.path(), &["--grid", "2", "--no-figures", "--format", "parquet,vti"]);
    assert!(!said.contains("No .vti"), "{said}");
    let always = ["summary.json", "manifest.json"];
    let expected = ["map.parquet", "map.vti", "map.vti.json"].into_iter().chain(always).map(String::from).collect();
    assert_eq!(names(folder.path()), expected);
    let described = json(&folder.path().join("map.vti.json"));
    let quantities: Vec<(&str, Option<&str>)> = described["arrays"]
        .as_array()
        .unwrap()
        .iter()
        .map(|array| (array["name"].as_str().unwrap(), array["unit"].as_str()))
        .collect();
    for expected in [
        ("all/status", None),
        ("cutting/deflection_mm", Some("mm")),
        ("all/departure_vector_mm", Some("mm")),
        ("cutting/stiffness_min_N_per_mm", Some("N/mm")),
    ] {
        assert!(quantities.contains(&expected), "{expected:?} is not in {quantities:?}");
    }
    let other = tempfile::tempdir().unwrap();
    let said = run("02_groove_50mm", other.path(), &["--points", "13", "--no-figures", "--format", "csv,vti"]);
    assert!(said.contains("No .vti: this kind of study has no map over the workspace."), "{said}");
    assert!(names(other.path()).iter().all(|name| !name.contains("vti")));
}

#[test]
fn an_unknown_format_or_colour_is_refused_with_the_known_ones() {
    for (option, known) in [("--format", "csv, parquet, vti"), ("--colours", "viridis, cividis, grey")] {
        let output = kinetostat(&["run", STUDIES, option, "jet"]);
        let complained = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{complained}");
        assert!(complained.contains("jet") && complained.contains(known), "{complained}");
    }
}

#[test]
fn colours_change_maps_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let files = |colours: &str| {
        let out = folder.path().join(colours);
        run("01_workspace_map", &out, &["--grid", "2", "--colours", colours]);
        names(&out).into_iter().map(|name| (fs::read(out.join(&name)).unwrap(), name)).collect::<Vec<_>>()
    };
    let [viridis, cividis, grey] = ["viridis", "cividis", "grey"].map(files);
    for ((first, second), third) in viridis.iter().zip(&cividis).zip(&grey) {
        let is_same = first == second && second == third;
        let (bytes, name) = first;
        if name.starts_with("machine_") {
            assert!(is_same || name.ends_with(".png"), "{name}");
        } else if name.starts_with("slices_worst_angle") {
            // Angles have a cyclic scale of their own.
            assert!(is_same || name.ends_with(".png"), "{name}");
        } else if name.ends_with(".svg") {
            assert!(first != second && second != third && first != third, "{name}");
            assert!(!bytes.is_empty());
        } else if !name.ends_with(".png") && !matches!(name.as_str(), "manifest.json" | "report.html" | "report.json") {
            assert!(is_same, "{name}");
        }
    }
}

#[test]
fn the_points_of_curves_stand_beside_their_figure() {
    let folder = tempfile::tempdir().unwrap();
    run("02_groove_50mm", folder.path(), &["--points", "13"]);
    let points = csv_cells(&folder.path().join("points.csv"));
    let column = |name: &str| points[0].iter().position(|header| header == name).unwrap();
    let (source, displacement) = (column("source"), column("displacement_mm"));
    let of_both: Vec<&str> =
        points.iter().filter(|row| row[source] == "all").map(|row| row[displacement].as_str()).collect();
    let drawn = csv_cells(&folder.path().join("displacement_data.csv"));
    assert!(drawn[0][2].starts_with("tool angle φ [") && drawn[0][3].ends_with(" [mm]"), "{:?}", drawn[0]);
    // The curve of both sources runs by angle and ends where it begins.
    let curve: Vec<&[String]> = drawn.iter().filter(|row| row[0] == "all at once").map(Vec::as_slice).collect();
    assert_eq!(curve.len(), of_both.len() + 1);
    assert!(curve.iter().all(|row| of_both.contains(&row[3].as_str())), "{curve:?}");
    assert_eq!(curve[0][3], curve[of_both.len()][3]);
    let paths = csv_cells(&folder.path().join("paths_data.csv"));
    assert!(paths[1..].iter().all(|row| row[4].contains("times as large")), "{:?}", paths[1]);
}
