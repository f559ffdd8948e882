//! Golden tables of the workspace map on its coarsest grid: a change of any number by more than `TOLERANCE` is either a
//! fault or a decision. After a decision: `UPDATE_GOLDEN=1 cargo test --test golden_map`.

use std::{fs, path::Path};

use kinetostat::{
    report::workspace_map::csv,
    study::{Overrides, Study, StudyKind, workspace_map},
};

/// Largest relative difference of a number from the golden one: what the convergence tolerance of the map's equilibria
/// leaves open when rounding differs between machines.
const TOLERANCE: f64 = 1e-7;
/// Numbers below this fraction of the largest of their column are rounding; they are held to the largest instead.
const ROUNDING: f64 = 1e-6;

/// The map of study `name` at grid 2 × 2 × 2, as its table.
fn table(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(name);
    let study = Study::open(&folder, &Overrides { grid: Some([2, 2, 2]), ..Overrides::default() }).unwrap();
    let StudyKind::WorkspaceMap(map) = &study.kind else { panic!("a workspace map") };
    String::from_utf8(csv(&workspace_map::run(map, &|| {})).unwrap()).unwrap()
}

fn cells(table: &str) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(table.as_bytes());
    reader.records().map(|record| record.unwrap().iter().map(String::from).collect()).collect()
}

/// The largest number of each column.
fn scales(golden: &[Vec<String>]) -> Vec<f64> {
    let largest = |column: usize| {
        let numbers = golden.iter().filter_map(|row| row[column].parse::<f64>().ok());
        numbers.fold(0.0f64, |most, number| most.max(number.abs()))
    };
    (0..golden[0].len()).map(largest).collect()
}

fn agree(found: &str, golden: &str, scale: f64) -> bool {
    match (found.parse::<f64>(), golden.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= TOLERANCE * b.abs().max(ROUNDING * scale),
        _ => found == golden,
    }
}

fn compare(name: &str, found: &str, golden: &str) {
    let (found, golden) = (cells(found), cells(golden));
    assert_eq!(found[0], golden[0], "{name}: columns");
    assert_eq!(found.len(), golden.len(), "{name}: number of rows");
    let (columns, scales) = (&golden[0], scales(&golden));
    let mut wrong = Vec::new();
    for (row, (found, golden)) in found.iter().zip(&golden).enumerate().skip(1) {
        for (column, ((a, b), scale)) in found.iter().zip(golden).zip(&scales).enumerate() {
            if !agree(a, b, *scale) {
                wrong.push(format!("row {row}, {}: {a}, golden {b}", columns[column]));
            }
        }
    }
    assert!(wrong.is_empty(), "{name}: {} cells differ, the first: {}", wrong.len(), wrong[0]);
}

#[test]
fn workspace_map_is_the_golden_one() {
    let name = "01_workspace_map";
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.csv"));
    let found = table(name);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(&file, &found).unwrap();
    }
    let golden = fs::read_to_string(&file).unwrap_or_else(|e| {
        panic!("golden table {} is missing: {e}; UPDATE_GOLDEN=1 cargo test --test golden_map makes it", file.display())
    });
    compare(name, &found, &golden);
}

#[test]
fn a_changed_number_or_word_is_found() {
    assert!(agree("1.00000005", "1", 1.0) && !agree("1.0000002", "1", 1.0));
    assert!(agree("1e-17", "0", 1.0) && !agree("1e-12", "0", 1.0));
    assert!(agree("solved", "solved", 0.0) && !agree("", "1", 1.0) && !agree("solved", "unstable", 0.0));
}
