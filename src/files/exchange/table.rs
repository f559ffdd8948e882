//! A table as reports make it and exporters write it.

/// Version of the columns of all tables. Raised when a column changes its name, unit or meaning; new columns do not.
pub(crate) const SCHEMA: u32 = 3;

/// Endings of column names and the units they stand for; a longer ending goes before those it ends with.
const UNITS: [(&str, &str); 9] = [
    ("_mm_per_N2", "mm/N²"),
    ("_deg_per_N2", "deg/N²"),
    ("_mm_per_N", "mm/N"),
    ("_deg_per_N", "deg/N"),
    ("_N_per_mm", "N/mm"),
    ("_Nmm", "N·mm"),
    ("_mm", "mm"),
    ("_deg", "deg"),
    ("_N", "N"),
];

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Real numbers.
    Number,
    /// Whole numbers from 0.
    Count,
    /// Words.
    Text,
}

/// A column: its name ends with the unit of its numbers, such as `deflection_mm`, or has it in brackets, as axes of
/// figures do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// The header of the column.
    pub name: String,
    /// What it holds.
    pub kind: Kind,
}

impl Column {
    /// The unit its name ends with; `None` for words, counts and numbers without dimension.
    pub fn unit(&self) -> Option<&str> {
        if self.kind != Kind::Number {
            return None;
        }
        if let Some((_, unit)) = self.name.strip_suffix(']').and_then(|name| name.rsplit_once('[')) {
            return Some(unit);
        }
        UNITS.iter().find(|(ending, _)| self.name.ends_with(ending)).map(|(_, unit)| *unit)
    }
}

fn columns<S: Into<String>>(kind: Kind, names: impl IntoIterator<Item = S>) -> Vec<Column> {
    names.into_iter().map(|name| Column { name: name.into(), kind }).collect()
}

/// Columns of real numbers.
pub fn numbers<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Vec<Column> {
    columns(Kind::Number, names)
}

/// Columns of whole numbers.
pub fn counts<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Vec<Column> {
    columns(Kind::Count, names)
}

/// Columns of words.
pub fn texts<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Vec<Column> {
    columns(Kind::Text, names)
}

/// A cell. The columns `status` and `reason` of its row say why it is missing.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Nothing is known; an empty text is missing, too.
    Missing,
    /// A real number.
    Number(f64),
    /// A whole number.
    Count(usize),
    /// Words.
    Text(String),
}

impl Cell {
    fn fits(&self, kind: Kind) -> bool {
        match self {
            Cell::Missing => true,
            Cell::Number(_) => kind == Kind::Number,
            Cell::Count(_) => kind == Kind::Count,
            Cell::Text(_) => kind == Kind::Text,
        }
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Cell::Number(number)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Cell::Count(count)
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        if text.is_empty() { Cell::Missing } else { Cell::Text(text) }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::from(text.to_string())
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Cell::Missing, Into::into)
    }
}

/// A row of a table.
pub type Row = Vec<Cell>;

/// Numbers as cells.
pub fn cells<T: Into<Cell>>(values: impl IntoIterator<Item = T>) -> impl Iterator<Item = Cell> {
    values.into_iter().map(Into::into)
}

/// A table of typed columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Row>,
}

impl Table {
    /// A table of `rows`.
    ///
    /// # Panics
    /// A row does not fit the columns, which is a fault of the report that made it.
    pub fn new(columns: Vec<Column>, rows: impl IntoIterator<Item = Row>) -> Self {
        let rows: Vec<Row> = rows.into_iter().collect();
        for row in &rows {
            assert_eq!(row.len(), columns.len(), "cells of a row of {columns:?}");
            for (cell, column) in row.iter().zip(&columns) {
                assert!(cell.fits(column.kind), "{cell:?} in column {column:?}");
            }
        }
        Self { columns, rows }
    }

    /// Adds the rows of a table of the same columns.
    ///
    /// # Panics
    /// Its columns are others, which is a fault of the report that made it.
    pub fn append(&mut self, other: Table) {
        assert_eq!(self.columns, other.columns, "columns of a table");
        self.rows.extend(other.rows);
    }

    /// The columns.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The rows, each with a cell per column.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Position of the column `name`.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }
}
