//! CSV tables read back, and their rows that a page shows: the first ones, and the leading ones by each column of a large table.

use std::{
    cmp::Ordering,
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use csv::StringRecord;
use serde::Serialize;

use super::{description::TableNote, packed::script_json};
use crate::{
    files::{exchange::unescape_formula, words::typographic},
    input::{
        error::{Error, Result},
        file,
    },
};

/// Most rows of a table on a page.
const MAX_ROWS: usize = 60;

/// A CSV file with a header. Rows are read from the file each time: a map may have millions.
#[derive(Debug, Clone)]
pub struct Table {
    file: PathBuf,
    /// Names of its columns.
    pub header: Vec<String>,
}

/// Most bytes of a row: more than any table of results has.
const LONGEST_ROW: usize = 16 << 20;

/// A file of which so many bytes may be read before the next row ends.
struct ByRows {
    file: std::fs::File,
    left: usize,
}

impl std::io::Read for ByRows {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.left == 0 {
            return Err(std::io::Error::other(format!("has a row longer than {} MiB", LONGEST_ROW >> 20)));
        }
        let most = buffer.len().min(self.left);
        let read = self.file.read(&mut buffer[..most])?;
        self.left -= read;
        Ok(read)
    }
}

impl Table {
    /// Opens the table in `file` and reads its header; `Err` when it cannot be read.
    pub fn open(file: &Path) -> Result<Self> {
        let mut table = Self { file: file.to_path_buf(), header: Vec::new() };
        let mut reader = table.reader()?;
        let header = reader.headers().map_err(|fault| table.csv_error(&fault))?;
        table.header = header.iter().map(|column| unescape_formula(column).to_string()).collect();
        Ok(table)
    }

    /// Opens the file for reading, by rows of at most [`LONGEST_ROW`] bytes.
    fn reader(&self) -> Result<csv::Reader<ByRows>> {
        Ok(csv::Reader::from_reader(ByRows { file: file::open(&self.file)?, left: LONGEST_ROW }))
    }

    /// Returns the error that the file has a `problem` in the line of `position`, in the column `key`.
    fn error_at(&self, position: Option<&csv::Position>, key: &str, problem: String) -> Error {
        let line = position.map(|at| at.line() as usize);
        Error::Syntax { file: self.file.display().to_string(), line, key: key.into(), problem }
    }

    /// Returns an error of the CSV library with file and line.
    fn csv_error(&self, fault: &csv::Error) -> Error {
        self.error_at(fault.position(), "", fault.to_string())
    }

    /// Calls `visit` with each row, its texts without the mark against formulas; `Err` when a row cannot be read.
    pub(crate) fn each_row(&self, mut visit: impl FnMut(&StringRecord)) -> Result<()> {
        let mut reader = self.reader()?;
        let mut row = StringRecord::new();
        while reader.read_record(&mut row).map_err(|fault| self.csv_error(&fault))? {
            // Removes the mark against formulas. Rows without one, nearly all, are checked as a whole.
            if row.as_slice().contains('\'') && row.iter().any(|cell| cell.starts_with('\'')) {
                let at = row.position().cloned();
                row = row.iter().map(unescape_formula).collect();
                row.set_position(at);
            }
            visit(&row);
            reader.get_mut().left = LONGEST_ROW;
        }
        Ok(())
    }

    /// Returns an upper bound of the number of rows, from the file's size (a separator per column); `Err` when it cannot be read.
    pub(crate) fn most_rows(&self) -> Result<u64> {
        let fault = |source| Error::Read { file: self.file.clone(), source };
        let bytes = file::open(&self.file)?.metadata().map_err(fault)?.len();
        Ok(bytes / self.header.len().max(1) as u64)
    }

    /// Returns the error for a cell of `row` that should hold a number or nothing.
    pub(crate) fn not_a_number(&self, row: &StringRecord, column: usize) -> Error {
        let problem = format!("expected a number or nothing, got {:?}", row.get(column).unwrap_or_default());
        self.error_at(row.position(), &self.header[column], problem)
    }

    /// Returns the index of the column `name`; `Err` when there is none.
    pub fn column(&self, name: &str) -> Result<usize> {
        self.header.iter().position(|column| column == name).ok_or_else(|| Error::Syntax {
            file: self.file.display().to_string(),
            line: Some(1),
            key: String::new(),
            problem: format!("there is no column \"{name}\""),
        })
    }
}

/// A table as a page shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TableView {
    /// Its file.
    pub file: String,
    /// Address of the file.
    pub href: String,
    /// What its rows are.
    pub caption: String,
    /// Column whose largest values are shown, if rows are left out.
    pub ranked_by: Option<String>,
    /// Number of rows in the file.
    pub total: usize,
    /// Names of its columns.
    pub columns: Vec<String>,
    /// Whether all shown cells of a column are numbers or empty, by column.
    pub numeric: Vec<bool>,
    /// The rows shown.
    pub rows: Vec<Vec<Cell>>,
    /// Data with which a script sorts all rows, as JSON; empty where all rows are here.
    pub ranking: String,
}

/// A cell of a table on a page.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Cell {
    /// Text shown.
    pub text: String,
    /// Text in the file, by which it is sorted.
    pub sort: String,
}

impl TableView {
    /// Reads the rows of `table` to be shown, as `note` says, with the file's address `href`; `Err` when it cannot be read or ranked.
    pub fn new(table: &Table, note: &TableNote, href: String) -> Result<Self> {
        let ranked_by = match &note.largest_first {
            Some(column) => Some(table.column(column)?),
            None => None,
        };
        let mut ranks: Vec<(f64, usize)> = Vec::new();
        let mut total = 0;
        let shorten = |ranks: &mut Vec<(f64, usize)>| {
            if ranked_by.is_some() {
                ranks.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            }
            ranks.truncate(MAX_ROWS);
        };
        let mut leading = LeadingRowsByColumn::of(table.header.len());
        table.each_row(|row| {
            leading.add(row);
            let value = ranked_by.and_then(|column| row.get(column)?.parse().ok()).unwrap_or(f64::NEG_INFINITY);
            ranks.push((value, total));
            total += 1;
            // A map may have more rows than memory.
            if ranks.len() == 100 * MAX_ROWS {
                shorten(&mut ranks);
            }
        })?;
        if total > MAX_ROWS {
            shorten(&mut ranks);
        }
        let mut chosen: Vec<(usize, Vec<Cell>)> = Vec::new();
        let shown_rows: BTreeSet<usize> = ranks.iter().map(|(_, index)| *index).collect();
        let mut ranked = (total > MAX_ROWS).then(|| RankingBuilder::new(leading));
        let mut index = 0;
        table.each_row(|row| {
            if shown_rows.contains(&index) {
                chosen.push((index, row.iter().map(Cell::new).collect()));
            }
            ranked.iter_mut().for_each(|ranked| ranked.take(index, row));
            index += 1;
        })?;
        let rows: Vec<Vec<Cell>> = ranks
            .iter()
            .filter_map(|(_, index)| chosen.iter().find(|(at, _)| at == index).map(|(_, row)| row.clone()))
            .collect();
        let is_numeric = |column: usize| {
            let cells = rows.iter().map(|row| &row[column].sort);
            cells.clone().any(|cell| !cell.is_empty())
                && cells.into_iter().all(|cell| cell.is_empty() || cell.parse::<f64>().is_ok())
        };
        Ok(Self {
            ranking: ranked.map_or_else(String::new, |ranked| ranked.json(total)),
            file: note.file.clone(),
            href,
            caption: note.kept.iter().fold(note.caption.clone(), |caption, kept| caption + " " + kept),
            ranked_by: note.largest_first.clone().filter(|_| total > MAX_ROWS),
            total,
            numeric: (0..table.header.len()).map(is_numeric).collect(),
            columns: table.header.clone(),
            rows,
        })
    }
}

impl Cell {
    /// Returns the cell of a page for a text of the file: numbers are rounded.
    pub fn new(text: &str) -> Self {
        let shown = match text.parse::<f64>() {
            Ok(value) if value != 0.0 && value.abs() < ROUNDING => "≈ 0".into(),
            Ok(value) => format_number(value),
            Err(_) => text.to_string(),
        };
        Self { text: shown, sort: text.to_string() }
    }
}

/// Size below which numbers of tables count as rounding, whatever their unit.
const ROUNDING: f64 = 1e-12;

/// Formats a number with five significant digits, whole numbers in full, and a true minus sign; a dash if it is not finite.
pub fn format_number(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == value.trunc() && value.abs() < 1e9 {
        return typographic(&format!("{value:.0}").replace("-0", "0"));
    }
    let exponent = libm::log10(value.abs()).floor();
    let text = if (-4.0..9.0).contains(&exponent) {
        format!("{value:.*}", (4.0 - exponent).max(0.0) as usize)
    } else {
        format!("{value:.3e}")
    };
    typographic(&text)
}

/// Most rows shown of a large table that is sorted.
const MAX_SORTED: usize = 20;

/// The leading rows of a table by each column, for a script that sorts all rows.
#[derive(Debug, PartialEq, Serialize)]
struct Ranking {
    total: usize,
    rows: Vec<Vec<String>>,
    /// Indices into `rows` by column, smallest and largest values first. Empty cells never lead.
    smallest: Vec<Vec<usize>>,
    largest: Vec<Vec<usize>>,
}

/// Sorting key of a cell: numbers before words.
#[derive(Debug, Clone, PartialEq)]
enum Key {
    Number(f64),
    Word(String),
}

impl Key {
    /// Returns the key of a cell; `None` if it is empty.
    fn of(cell: &str) -> Option<Self> {
        match cell.parse::<f64>() {
            Ok(number) if !number.is_nan() => Some(Key::Number(number)),
            _ if cell.is_empty() => None,
            _ => Some(Key::Word(cell.into())),
        }
    }

    /// Compares two keys: numbers by size, words by letters.
    fn compare(&self, other: &Self) -> Ordering {
        match (self, other) {
            (Key::Number(a), Key::Number(b)) => a.total_cmp(b),
            (Key::Word(a), Key::Word(b)) => a.cmp(b),
            (Key::Number(_), Key::Word(_)) => Ordering::Less,
            (Key::Word(_), Key::Number(_)) => Ordering::Greater,
        }
    }
}

/// The leading rows of one column in one direction, among the rows read so far.
struct LeadingRows {
    is_largest: bool,
    kept: Vec<(Key, usize)>,
}

impl LeadingRows {
    /// Inserts the row if it belongs to the leading ones.
    fn add(&mut self, key: &Key, row: usize) {
        let is_before = |(kept, _): &(Key, usize)| match self.is_largest {
            true => kept.compare(key) != Ordering::Less,
            false => kept.compare(key) != Ordering::Greater,
        };
        if self.kept.len() == MAX_SORTED && self.kept.last().is_some_and(is_before) {
            return;
        }
        let at = self.kept.partition_point(is_before);
        self.kept.insert(at, (key.clone(), row));
        self.kept.truncate(MAX_SORTED);
    }
}

/// The leading rows of each column in both directions, among the rows read so far.
struct LeadingRowsByColumn {
    smallest: Vec<LeadingRows>,
    largest: Vec<LeadingRows>,
    seen: usize,
}

impl LeadingRowsByColumn {
    /// Returns an empty list for each column of a table.
    pub fn of(columns: usize) -> Self {
        let first = |is_largest| move || LeadingRows { is_largest, kept: Vec::new() };
        let of_columns = |is_largest| std::iter::repeat_with(first(is_largest)).take(columns).collect();
        Self { smallest: of_columns(false), largest: of_columns(true), seen: 0 }
    }

    /// Adds the next row.
    pub fn add(&mut self, row: &StringRecord) {
        for (cell, (smallest, largest)) in row.iter().zip(self.smallest.iter_mut().zip(&mut self.largest)) {
            if let Some(key) = Key::of(cell) {
                smallest.add(&key, self.seen);
                largest.add(&key, self.seen);
            }
        }
        self.seen += 1;
    }
}

/// The indices of all leading rows, while their cells are collected.
struct RankingBuilder {
    first: LeadingRowsByColumn,
    wanted: BTreeSet<usize>,
    rows: Vec<Vec<String>>,
}

impl RankingBuilder {
    /// Starts to collect, after all rows of the table have been added to `first`.
    pub fn new(first: LeadingRowsByColumn) -> Self {
        let kept = first.smallest.iter().chain(&first.largest).flat_map(|first| &first.kept);
        Self { wanted: kept.map(|(_, row)| *row).collect(), rows: Vec::new(), first }
    }

    /// Adds the cells of a row if it is a leading one; rows come in the order of their indices.
    pub fn take(&mut self, index: usize, row: &StringRecord) {
        if self.wanted.contains(&index) {
            self.rows.push(row.iter().map(|cell| Cell::new(cell).text).collect());
        }
    }

    /// Returns the ranking of a table of `total` rows as JSON for its script.
    pub fn json(self, total: usize) -> String {
        let places: BTreeMap<usize, usize> = self.wanted.iter().enumerate().map(|(place, row)| (*row, place)).collect();
        let of_column = |first: &LeadingRows| first.kept.iter().map(|(_, row)| places[row]).collect();
        let indices = |all: &[LeadingRows]| all.iter().map(of_column).collect();
        let LeadingRowsByColumn { smallest, largest, .. } = &self.first;
        script_json(&Ranking { total, smallest: indices(smallest), largest: indices(largest), rows: self.rows })
    }
}
