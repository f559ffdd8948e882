//! The rows of a large table that stand first when it is sorted by any of its columns, either way.

use std::{
    cmp::Ordering,
    collections::{BTreeMap, BTreeSet},
};

use csv::StringRecord;
use serde::Serialize;

use super::{packed::script_json, table::Cell};

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

/// The first rows of both orders of each column, as rows are seen.
pub(super) struct FirstRows {
    smallest: Vec<First>,
    largest: Vec<First>,
    seen: usize,
}

impl FirstRows {
    /// Of a table with so many columns, no row seen.
    pub fn of(columns: usize) -> Self {
        let first = |is_largest| move || First { is_largest, kept: Vec::new() };
        let of_columns = |is_largest| std::iter::repeat_with(first(is_largest)).take(columns).collect();
        Self { smallest: of_columns(false), largest: of_columns(true), seen: 0 }
    }

    /// Takes note of the next row.
    pub fn see(&mut self, row: &StringRecord) {
        for (cell, (smallest, largest)) in row.iter().zip(self.smallest.iter_mut().zip(&mut self.largest)) {
            if let Some(key) = Key::of(cell) {
                smallest.see(&key, self.seen);
                largest.see(&key, self.seen);
            }
        }
        self.seen += 1;
    }
}

/// The first rows, their cells being gathered.
pub(super) struct Ranked {
    first: FirstRows,
    wanted: BTreeSet<usize>,
    rows: Vec<Vec<String>>,
}

impl Ranked {
    /// Of a table of which all rows were seen.
    pub fn new(first: FirstRows) -> Self {
        let kept = first.smallest.iter().chain(&first.largest).flat_map(|first| &first.kept);
        Self { wanted: kept.map(|(_, row)| *row).collect(), rows: Vec::new(), first }
    }

    /// Takes the row with this index, which are given in order.
    pub fn take(&mut self, index: usize, row: &StringRecord) {
        if self.wanted.contains(&index) {
            self.rows.push(row.iter().map(|cell| Cell::new(cell).text).collect());
        }
    }

    /// The ranking of the table, of so many rows, as JSON for its script.
    pub fn json(self, total: usize) -> String {
        let places: BTreeMap<usize, usize> = self.wanted.iter().enumerate().map(|(place, row)| (*row, place)).collect();
        let of_column = |first: &First| first.kept.iter().map(|(_, row)| places[row]).collect();
        let indices = |all: &[First]| all.iter().map(of_column).collect();
        let FirstRows { smallest, largest, .. } = &self.first;
        script_json(&Ranking { total, smallest: indices(smallest), largest: indices(largest), rows: self.rows })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::{
        super::{
            description::TableNote,
            table::{Table, TableView},
        },
        *,
    };

    #[test]
    fn any_column_is_sorted_over_all_rows() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("t.csv");
        let rows: String =
            (0..500).map(|k| format!("{k},{},{}\n", (k * 37) % 500, if k == 400 { "" } else { "x" })).collect();
        std::fs::write(&file, format!("k,v,w\n{rows}")).unwrap();
        let note = TableNote::ranked("t.csv", "", "v");
        let view = TableView::new(&Table::open(&file).unwrap(), &note, "t.csv".into()).unwrap();
        let found: Value = serde_json::from_str(&view.ranking).unwrap();
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
