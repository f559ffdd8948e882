//! Golden tables and figures: a change of any number by more than a tolerance, or of any byte, is either a fault or a
//! decision. After a decision: `UPDATE_GOLDEN=1 cargo test` with the name of the test.
#![allow(dead_code)]

use std::{fs, path::Path};

/// Numbers below this fraction of the largest of their column are rounding; they are held to the largest instead.
const ROUNDING: f64 = 1e-6;

/// Fails unless `found` is the golden table `name`, numbers to `tolerance` (relative).
pub fn check(name: &str, found: &str, tolerance: f64) {
    compare(name, found, &golden(&format!("{name}.csv"), found), tolerance);
}

/// Fails unless `found` is the golden file `name`, byte for byte.
pub fn same(name: &str, found: &str) {
    let golden = golden(name, found);
    let differs = found.lines().zip(golden.lines()).position(|(a, b)| a != b);
    assert!(found == golden, "{name} differs from the golden one, first in line {:?}", differs.map(|line| line + 1));
}

/// The golden file `name`, which becomes `found` if goldens are to be updated.
fn golden(name: &str, found: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(&file, found).unwrap();
    }
    fs::read_to_string(&file)
        .unwrap_or_else(|e| panic!("golden {} is missing: {e}; UPDATE_GOLDEN=1 and this test make it", file.display()))
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

/// Whether two cells are the same word, or numbers that differ by no more than the tolerance.
pub fn agree(found: &str, golden: &str, scale: f64, tolerance: f64) -> bool {
    match (found.parse::<f64>(), golden.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= tolerance * b.abs().max(ROUNDING * scale),
        _ => found == golden,
    }
}

fn compare(name: &str, found: &str, golden: &str, tolerance: f64) {
    let (found, golden) = (cells(found), cells(golden));
    assert_eq!(found[0], golden[0], "{name}: columns");
    assert_eq!(found.len(), golden.len(), "{name}: number of rows");
    let (columns, scales) = (&golden[0], scales(&golden));
    let mut wrong = Vec::new();
    for (row, (found, golden)) in found.iter().zip(&golden).enumerate().skip(1) {
        for (column, ((a, b), scale)) in found.iter().zip(golden).zip(&scales).enumerate() {
            if !agree(a, b, *scale, tolerance) {
                wrong.push(format!("row {row}, {}: {a}, golden {b}", columns[column]));
            }
        }
    }
    assert!(wrong.is_empty(), "{name}: {} cells differ, the first: {}", wrong.len(), wrong[0]);
}
