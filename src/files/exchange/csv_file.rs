//! Tables as CSV, and the description of their columns.
//!
//! CSV (RFC 4180) has no place for a version, and a comment line or an extra header would break readers. Version, units and
//! types of all tables of a folder therefore stand beside them in `csv-metadata.json`, the file in which the W3C
//! recommendation "Metadata Vocabulary for Tabular Data" (2015, section 5.2) has programs look for the description of the
//! CSV files of a folder. Units and versions are terms of schema.org, whose prefix that recommendation predefines.

use std::{borrow::Cow, io::Write};

use serde_json::{Value, json};

use super::table::{Cell, Kind, SCHEMA, Table};

/// Name of the file that describes the CSV files of a folder.
pub(crate) const DESCRIPTION: &str = "csv-metadata.json";

/// A table as CSV, written part by part: one header line, numbers in the shortest form that reads back to the same value,
/// empty cells where values are missing. Texts that a spreadsheet would take for a formula have a `'` before them.
pub struct CsvFile<W: Write> {
    writer: csv::Writer<W>,
    has_header: bool,
}

impl<W: Write> CsvFile<W> {
    /// Creates an empty file that writes to `out`.
    pub fn new(out: W) -> Self {
        Self { writer: csv::Writer::from_writer(out), has_header: false }
    }

    /// Creates an empty file that writes rows alone, without a header, to `out`.
    pub(super) fn without_header(out: W) -> Self {
        Self { has_header: true, ..Self::new(out) }
    }

    /// Adds the rows of `table`, after the header with the first part; all parts have the same columns. `Err` when they cannot be
    /// written.
    pub fn add(&mut self, table: &Table) -> csv::Result<()> {
        if !std::mem::replace(&mut self.has_header, true) {
            self.writer.write_record(table.columns().iter().map(|column| escape_formula(&column.name).into_owned()))?;
        }
        let mut digits = Vec::new();
        for row in table.rows() {
            for cell in row {
                digits.clear();
                match cell {
                    Cell::Missing => self.writer.write_field("")?,
                    Cell::Number(number) => {
                        write_number(*number, &mut digits)?;
                        self.writer.write_field(&digits)?;
                    }
                    Cell::Count(count) => {
                        write!(digits, "{count}")?;
                        self.writer.write_field(&digits)?;
                    }
                    Cell::Text(text) => self.writer.write_field(escape_formula(text).as_bytes())?,
                }
            }
            self.writer.write_record(None::<&[u8]>)?;
        }
        Ok(())
    }

    /// Returns the output after everything is written to it; `Err` when that fails.
    pub fn finish(self) -> csv::Result<W> {
        self.writer.into_inner().map_err(|e| csv::Error::from(e.into_error()))
    }
}

/// Sizes of numbers that are written without an exponent.
const PLAIN: std::ops::Range<f64> = 1e-30..1e21;

/// Writes a number in the shortest form that reads back to the same value, with an exponent where it would have dozens of zeros.
fn write_number(number: f64, out: &mut Vec<u8>) -> std::io::Result<()> {
    match number == 0.0 || !number.is_finite() || PLAIN.contains(&number.abs()) {
        true => write!(out, "{number}"),
        false => write!(out, "{number:e}"),
    }
}

/// Returns whether a spreadsheet would take a text for a formula.
fn is_formula(text: &str) -> bool {
    text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n'])
}

/// Returns a text as a cell that no spreadsheet takes for a formula: with a `'` before it if need be, as spreadsheets mark texts. Numbers
/// are not texts.
fn escape_formula(text: &str) -> Cow<'_, str> {
    if is_formula(text.trim_start_matches('\'')) { format!("'{text}").into() } else { text.into() }
}

/// Returns the text of a cell written by [`CsvFile`], without the `'` that marks it as no formula.
pub fn unescape_formula(cell: &str) -> &str {
    if is_formula(cell.trim_start_matches('\'')) { cell.strip_prefix('\'').unwrap_or(cell) } else { cell }
}

/// Returns the whole table as the bytes of a CSV file.
pub fn csv(table: &Table) -> csv::Result<Vec<u8>> {
    let mut file = CsvFile::new(Vec::new());
    file.add(table)?;
    file.finish()
}

/// Returns the description of tables in CSV files, given with their file names, as JSON.
pub fn description<'a>(tables: impl IntoIterator<Item = (&'a str, &'a Table)>) -> Value {
    let tables: Vec<Value> = tables.into_iter().map(|(file, table)| describe_table(file, table)).collect();
    json!({ "@context": "http://www.w3.org/ns/csvw", "schema:version": SCHEMA.to_string(), "tables": tables })
}

/// Returns the columns of one table as JSON: name, type, unit and meaning of each.
fn describe_table(file: &str, table: &Table) -> Value {
    let columns = table.columns().iter().map(|column| {
        let datatype = match column.kind {
            Kind::Number => "double",
            Kind::Count => "nonNegativeInteger",
            Kind::Text => "string",
        };
        let mut description = json!({ "titles": column.name, "datatype": datatype });
        if let Some(unit) = column.unit() {
            description["schema:unitText"] = json!(unit);
        }
        if let Some(meaning) = column_meaning(&column.name) {
            description["dc:description"] = json!(meaning);
        }
        description
    });
    let mut description = json!({ "url": file, "tableSchema": { "columns": columns.collect::<Vec<_>>() } });
    if let Some(note) = table.note() {
        description["dc:description"] = json!(note);
    }
    description
}

/// Returns the meaning of a column whose name has no unit to explain it; `None` for other columns.
fn column_meaning(column: &str) -> Option<&'static str> {
    Some(match column {
        "status" => "whether the numbers of the row are known; where they are not, why",
        "reason" => "the status in words, with numbers; empty where the row is solved",
        "correction_status" => {
            "whether the drive corrections (delta_rho) of the row are known; the deflection may be without them"
        }
        "correction_reason" => "the correction status in words, with numbers; empty where the correction is known",
        _ => return None,
    })
}
