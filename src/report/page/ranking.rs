//! The rows of a large table that stand first when it is sorted by any of its columns, either way.

use std::{
    cmp::Ordering,
    collections::{BTreeMap, BTreeSet},
};

use serde::Serialize;

use super::{
    packed::script_json,
    table::{Cell, Table},
};
use crate::input::error::Result;

/// Rows shown of a large table that is sorted.
const MOST_ROWS: usize = 20;

/// What a script needs to sort all rows of a table of which it has few.
#[derive(Debug, PartialEq, Serialize)]
struct Ranking {
    total: usize,
    rows: Vec<Vec<String>>,
    /// By column: indices into `rows`, smallest first and largest first. Empty cells are never first.
    smallest: Vec<Vec<usize>>,
    largest: Vec<Vec<usize>>,
}

/// A cell as it is sorted: numbers before words.
#[derive(Debug, Clone, PartialEq)]
enum Key {
    Number(f64),
    Word(String),
}

impl Key {
    fn of(cell: &str) -> Option<Self> {
        match cell.parse::<f64>() {
            Ok(number) if !number.is_nan() => Some(Key::Number(number)),
            _ if cell.is_empty() => None,
            _ => Some(Key::Word(cell.into())),
        }
    }

    fn order(&self, other: &Self) -> Ordering {
        match (self, other) {
            (Key::Number(a), Key::Number(b)) => a.total_cmp(b),
            (Key::Word(a), Key::Word(b)) => a.cmp(b),
            (Key::Number(_), Key::Word(_)) => Ordering::Less,
            (Key::Word(_), Key::Number(_)) => Ordering::Greater,
        }
    }
}

/// The first rows of one order of one column, as rows are seen.
struct First {
    is_largest: bool,
    kept: Vec<(Key, usize)>,
}

impl First {
    fn see(&mut self, key: &Key, row: usize) {
        let is_late = |last: &(Key, usize)| match self.is_largest {
            true => key.order(&last.0) != Ordering::Greater,
            false => key.order(&last.0) != Ordering::Less,
        };
        if self.kept.len() == MOST_ROWS && self.kept.last().is_some_and(is_late) {
            return;
        }
        let is_before = |own: &(Key, usize)| match self.is_largest {
            true => own.0.order(key) != Ordering::Less,
            false => own.0.order(key) != Ordering::Greater,
        };
        let at = self.kept.partition_point(is_before);
        self.kept.insert(at, (key.clone(), row));
        self.kept.truncate(MOST_ROWS);
    }
}

/// The ranking of `table` as JSON for its script.
///
/// # Errors
/// A row that cannot be read.
pub(super) fn ranking(table: &Table) -> Result<String> {
    let columns = table.header.len();
    let first = |is_largest| move || First { is_largest, kept: Vec::new() };
    let mut smallest: Vec<First> = std::iter::repeat_with(first(false)).take(columns).collect();
    let mut largest: Vec<First> = std::iter::repeat_with(first(true)).take(columns).collect();
    let mut total = 0;
    table.each_row(|row| {
        for (column, cell) in row.iter().enumerate().take(columns) {
            if let Some(key) = Key::of(cell) {
                smallest[column].see(&key, total);
                largest[column].see(&key, total);
            }
        }
        total += 1;
    })?;
    let wanted: BTreeSet<usize> = smallest.iter().chain(&largest).flat_map(|f| &f.kept).map(|(_, row)| *row).collect();
    let places: BTreeMap<usize, usize> = wanted.iter().enumerate().map(|(place, row)| (*row, place)).collect();
    let mut rows = Vec::with_capacity(wanted.len());
    let mut index = 0;
    table.each_row(|row| {
        if wanted.contains(&index) {
            rows.push(row.iter().map(|cell| Cell::new(cell).text).collect());
        }
        index += 1;
    })?;
    let indices = |all: &[First]| all.iter().map(|f| f.kept.iter().map(|(_, row)| places[row]).collect()).collect();
    Ok(script_json(&Ranking { total, smallest: indices(&smallest), largest: indices(&largest), rows }))
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    #[test]
    fn any_column_is_sorted_over_all_rows() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("t.csv");
        let rows: String =
            (0..500).map(|k| format!("{k},{},{}\n", (k * 37) % 500, if k == 400 { "" } else { "x" })).collect();
        std::fs::write(&file, format!("k,v,w\n{rows}")).unwrap();
        let found: Value = serde_json::from_str(&ranking(&Table::open(&file).unwrap()).unwrap()).unwrap();
        assert_eq!(found["total"], 500);
        let column = |order: &str, column: usize| -> Vec<String> {
            let indices = found[order][column].as_array().unwrap().iter();
            indices.map(|i| found["rows"][i.as_u64().unwrap() as usize][column].as_str().unwrap().into()).collect()
        };
        let expected: Vec<String> = (0..MOST_ROWS).map(|k| (499 - k).to_string()).collect();
        assert_eq!(column("largest", 1), expected);
        assert_eq!(column("smallest", 0), (0..MOST_ROWS).map(|k| k.to_string()).collect::<Vec<_>>());
        assert!(column("smallest", 2).iter().all(|cell| cell == "x"));
    }
}
