//! `--format` and `--colours`: what other programs read, and the colours of maps.

use std::{
    collections::BTreeSet,
    fs::{self, File},
    io::Write,
    path::Path,
};

use crate::support::command::kinetostat;
use kinetostat::{
    Grid,
    files::exchange::{self, Cell, Image, Layer, Row, Table, counts, numbers, texts},
};
use nalgebra::Vector3;
use parquet::{
    file::{
        metadata::KeyValue,
        reader::{FileReader, SerializedFileReader},
    },
    record::Field,
};
use serde_json::Value;
use vtkio::model::{Attribute, DataSet, Extent, IOBuffer, Piece, Vtk};

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
            (&"http://www.w3.org/ns/csvw".into(), &"3".into())
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
        ("all/superposition_error_vector_mm", Some("mm")),
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

fn read_back(cell: &Field) -> Cell {
    match cell {
        Field::Null => Cell::Missing,
        Field::Double(number) => Cell::Number(*number),
        Field::Long(count) => Cell::Count(usize::try_from(*count).unwrap()),
        Field::Str(text) => Cell::Text(text.clone()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_number_has_an_exponent_instead_of_dozens_of_zeros() {
    let numbers_in = [1e-217, -3.5e300, 0.0, 1e-13, 1234.5, 123_456_789_012_345_680.0, 1e21];
    let table = Table::new(numbers(["x_mm"]), numbers_in.map(|number| vec![Cell::Number(number)]));
    let text = String::from_utf8(exchange::csv(&table).unwrap()).unwrap();
    let expected = "x_mm\n1e-217\n-3.5e300\n0\n0.0000000000001\n1234.5\n123456789012345680\n1e21\n";
    assert_eq!(text, expected);
    let read_back = text.lines().skip(1).map(|line| line.parse().unwrap());
    assert_eq!(read_back.collect::<Vec<f64>>(), numbers_in);
}

#[test]
fn a_table_as_parquet_is_read_back_as_it_was() {
    let columns = [counts(["point"]), numbers(["x_mm", "ratio"]), texts(["reason"])].concat();
    let row = |k: usize| {
        let x = (!k.is_multiple_of(3)).then_some(0.1 * k as f64 - 7e-300);
        vec![k.into(), x.into(), Cell::Missing, if k == 4 { "unstable: μ < 0" } else { "" }.into()]
    };
    let table = Table::new(columns, (0..1000).map(row));
    let bytes = exchange::parquet(&table).unwrap();
    assert_eq!(bytes, exchange::parquet(&table).unwrap());
    let mut file = tempfile::tempfile().unwrap();
    file.write_all(&bytes).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let rows = reader.get_row_iter(None).unwrap();
    let rows = rows.map(|row| row.unwrap().get_column_iter().map(|(_, cell)| read_back(cell)).collect::<Vec<_>>());
    assert_eq!(table, Table::new(table.columns().to_vec(), rows));
    let file = reader.metadata().file_metadata();
    let names: Vec<&str> = file.schema().get_fields().iter().map(|field| field.name()).collect();
    assert_eq!(names, ["point", "x_mm", "ratio", "reason"]);
    let pair = |key: &str, value: &str| KeyValue::new(key.into(), value.to_string());
    assert_eq!(file.key_value_metadata().unwrap(), &[pair("kinetostat.schema", "3"), pair("unit.x_mm", "mm")]);
}

const LAYER: Layer = Layer { table: "map", keys: &["source"], vectors: &["deflection"] };

/// A map on 3 × 2 × 1 points with two sources; the second point is out of reach.
fn map(status: &str) -> (Image, Vec<(String, Table)>) {
    let grid = Grid::new(Vector3::new(-73.65, 0.0, 5.0), Vector3::new(26.35, 10.0, 15.0), [3, 2, 1]);
    let quantities =
        ["deflection_mm", "deflection_x_mm", "deflection_y_mm", "deflection_z_mm", "superposition_error_mm"];
    let columns =
        [numbers(["x_mm", "y_mm", "z_mm"]), texts(["source", "status", "reason"]), numbers(quantities)].concat();
    let row = |index: usize, source: &str| {
        let mut row: Row = grid.position(index).iter().map(|v| Cell::from(*v)).collect();
        row.push(source.into());
        if index == 1 {
            row.extend([status.into(), "too far".into()]);
            row.resize(11, Cell::Missing);
            return row;
        }
        row.extend(["solved".into(), Cell::Missing]);
        row.extend([1.0 / 3.0, 0.1, 0.2, 0.3].map(|v| Cell::from(v * index as f64)));
        row.push((source == "both").then_some(0.25).into());
        row
    };
    let rows: Vec<Row> = (0..6).flat_map(|index| ["cutting", "both"].map(|source| row(index, source))).collect();
    (Image { grid, layers: vec![LAYER] }, vec![("map".into(), Table::new(columns, rows))])
}

#[test]
fn an_image_is_read_back_as_it_was() {
    let (image, tables) = map("unreachable");
    let (bytes, description) = image.vti(&tables).unwrap();
    assert_eq!(bytes, image.vti(&tables).unwrap().0);
    let read = Vtk::parse_xml(bytes.as_slice()).unwrap();
    let DataSet::ImageData { extent, origin, spacing, pieces, .. } = read.data else { panic!("image data") };
    assert_eq!(extent, Extent::Ranges([0..=2, 0..=1, 0..=0]));
    assert_eq!((origin, spacing), ([-73.65, 0.0, 10.0], [50.0, 10.0, 1.0]));
    let [Piece::Inline(piece)] = pieces.as_slice() else { panic!("one piece") };
    let array = |name: &str| {
        let arrays = piece.data.point.iter().filter_map(|attribute| match attribute {
            Attribute::DataArray(array) => Some(array),
            Attribute::Field { .. } => None,
        });
        arrays.into_iter().find(|array| array.name == name).map(|array| array.data.clone())
    };
    assert_eq!(array("both/status"), Some(IOBuffer::I32(vec![0, 1, 0, 0, 0, 0])));
    let Some(IOBuffer::F64(lengths)) = array("both/deflection_mm") else { panic!("an array of numbers") };
    let is_expected = |(index, length): (usize, &f64)| match index {
        1 => length.is_nan(),
        _ => *length == 1.0 / 3.0 * index as f64,
    };
    assert!(lengths.len() == 6 && lengths.iter().enumerate().all(is_expected), "{lengths:?}");
    let Some(IOBuffer::F64(vectors)) = array("cutting/deflection_vector_mm") else { panic!("an array of vectors") };
    assert_eq!(vectors[15..], [0.5, 1.0, 1.5]);
    assert_eq!(array("cutting/superposition_error_mm"), None, "an array without any number");
    let named: Vec<&str> =
        description["arrays"].as_array().unwrap().iter().map(|array| array["name"].as_str().unwrap()).collect();
    assert_eq!((named[0], named[named.len() - 1]), ("cutting/deflection_mm", "position_mm"));
    assert_eq!(description["status"]["unreachable"], 1);
}

#[test]
fn an_unknown_status_and_a_table_of_another_grid_are_faults() {
    let (image, tables) = map("tired");
    let fault = image.vti(&tables).unwrap_err().to_string();
    assert!(fault.contains("tired"), "{fault}");
    let (mut image, tables) = map("unreachable");
    image.grid.axes[2] = (0..7).map(f64::from).collect();
    let fault = image.vti(&tables).unwrap_err().to_string();
    assert_eq!(fault, "map: 12 rows for 42 points");
}
