//! Typed tables, as reports make and exporters write them.

/// Version of the columns of all tables. It rises when a column changes its name, unit or meaning, not for a new column.
pub(crate) const SCHEMA: u32 = 3;

/// Endings of column names with their units; a longer ending comes before the shorter ones it ends with.
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

/// Type of the values in a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Real numbers.
    Number,
    /// Whole numbers from 0.
    Count,
    /// Words.
    Text,
}

/// A column of a table. Its name ends with its unit, such as `deflection_mm`, or has it in brackets, as axes of figures do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// The header of the column.
    pub name: String,
    /// Type of its values.
    pub kind: Kind,
}

impl Column {
    /// Returns the unit in its name; `None` for words, counts and dimensionless numbers.
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

/// Returns columns with these names and values of one kind.
fn columns_of_kind<S: Into<String>>(kind: Kind, names: impl IntoIterator<Item = S>) -> Vec<Column> {
    names.into_iter().map(|name| Column { name: name.into(), kind }).collect()
}

/// Returns columns of real numbers with these names.
pub fn numbers<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Vec<Column> {
    columns_of_kind(Kind::Number, names)
}

/// Returns columns of whole numbers with these names.
pub fn counts<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Vec<Column> {
    columns_of_kind(Kind::Count, names)
}

/// Returns columns of words with these names.
pub fn texts<S: Into<String>>(names: impl IntoIterator<Item = S>) -> Vec<Column> {
    columns_of_kind(Kind::Text, names)
}

/// A cell of a table. If it is missing, the columns `status` and `reason` of its row say why.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// No value; an empty text counts as missing, too.
    Missing,
    /// A real number.
    Number(f64),
    /// A whole number.
    Count(usize),
    /// Words.
    Text(String),
}

impl Cell {
    /// Returns the number in the cell; NaN if it is missing or a text.
    pub fn number_or_nan(&self) -> f64 {
        match self {
            Cell::Number(number) => *number,
            Cell::Count(count) => *count as f64,
            Cell::Missing | Cell::Text(_) => f64::NAN,
        }
    }

    /// Returns whether the cell may stand in a column of this kind.
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

/// Converts values to cells.
pub fn cells<T: Into<Cell>>(values: impl IntoIterator<Item = T>) -> impl Iterator<Item = Cell> {
    values.into_iter().map(Into::into)
}

/// A table of typed columns and its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Row>,
    note: Option<String>,
}

impl Table {
    /// Returns a table with these columns and rows.
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
        Self { columns, rows, note: None }
    }

    /// Returns the table with a sentence on which of its rows its file has.
    #[must_use]
    pub(crate) fn with_note(self, note: Option<String>) -> Self {
        Self { note, ..self }
    }

    /// Returns the table without its rows.
    pub(crate) fn without_rows(self) -> Self {
        Self { rows: Vec::new(), ..self }
    }

    /// Returns the sentence on which of its rows its file has; `None` if all.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Adds the rows of a table with the same columns.
    ///
    /// # Panics
    /// Its columns are others, which is a fault of the report that made it.
    pub fn append(&mut self, other: Table) {
        assert_eq!(self.columns, other.columns, "columns of a table");
        self.rows.extend(other.rows);
    }

    /// Returns the columns.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Returns the rows, each with a cell for every column.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Returns the index of the column `name`; `None` if there is none.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }
}
