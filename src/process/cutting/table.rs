//! Wrench tables: a cutting load tabulated over the arc length of the path, read from CSV.

use nalgebra::Vector3;

use super::{LoadError, TableError, TableFault};
use crate::{
    input::csv_rows::{self, Row, RowFault, line_number},
    toolpath::{Load, Toolpath},
};

/// The columns, in the order of a row's numbers.
const COLUMNS: [&str; 7] =
    ["arc_length_mm", "force_x_N", "force_y_N", "force_z_N", "moment_x_Nmm", "moment_y_Nmm", "moment_z_Nmm"];

/// How far beyond its ends a table still counts, mm: lengths in a file are rounded. The load there is that of the end.
const ROUNDING_MM: f64 = 1e-3;

/// Force and moment on the tool over the arc length of the path, linear between rows.
///
/// A CSV file with the columns `arc_length_mm`, `force_x_N`, `force_y_N`, `force_z_N`, `moment_x_Nmm`, `moment_y_Nmm`,
/// `moment_z_Nmm` in any order: axes of W, moment about the tool tip. The arc length is that of the path from its first
/// point, [`PathPoint::arc_length_mm`](crate::toolpath::PathPoint::arc_length_mm): moves without cutting count,
/// but only lengths at which the tool cuts need rows. It must increase from row to row.
#[derive(Debug, Clone, PartialEq)]
pub struct WrenchTable {
    /// Arc length, mm, and load of each row: at least two rows, by increasing length.
    rows: Vec<(f64, Load)>,
}

impl WrenchTable {
    /// Reads a table from `source`, the file's bytes; `name` is its name in errors. Fails if a column is unknown, repeated or missing, a row
    /// has the wrong number of values, a value is no finite number, lengths do not increase, or there are fewer than two rows.
    pub fn read(source: &[u8], name: &str) -> Result<WrenchTable, TableError> {
        let rows = parse(source).map_err(|(at, fault)| TableError {
            file: name.to_owned(),
            line: line_number(source, at),
            fault,
        })?;
        Ok(WrenchTable { rows })
    }

    /// Returns the first and last arc length of the table, mm.
    #[must_use]
    pub fn range_mm(&self) -> (f64, f64) {
        let length = |row: Option<&(f64, Load)>| row.map_or(0.0, |row| row.0);
        (length(self.rows.first()), length(self.rows.last()))
    }

    /// Returns the largest force of all rows, N; between rows the force is never larger.
    #[must_use]
    #[allow(non_snake_case, reason = "the unit is N, not n")]
    pub fn largest_force_N(&self) -> f64 {
        self.rows.iter().fold(0.0, |most, (_, load)| most.max(load.force_N.norm()))
    }

    /// Interpolates the load on the tool at `arc_length_mm` along the path. Fails when the table has no rows there.
    pub fn load(&self, arc_length_mm: f64) -> Result<Load, LoadError> {
        self.check_range(arc_length_mm, arc_length_mm)?;
        let after = self.rows.partition_point(|row| row.0 <= arc_length_mm).clamp(1, self.rows.len() - 1);
        let ((from, a), (to, b)) = (self.rows[after - 1], self.rows[after]);
        let t = ((arc_length_mm - from) / (to - from)).clamp(0.0, 1.0);
        Ok(Load { force_N: a.force_N.lerp(&b.force_N, t), moment_Nmm: a.moment_Nmm.lerp(&b.moment_Nmm, t) })
    }

    /// Checks that the table has rows wherever `path` is cutting; fails with both ranges otherwise.
    pub fn check_coverage(&self, path: &Toolpath) -> Result<(), LoadError> {
        let mut cutting = path.points().iter().filter(|point| point.cutting).map(|point| point.arc_length_mm);
        match cutting.next() {
            Some(first) => self.check_range(first, cutting.next_back().unwrap_or(first)),
            None => Ok(()),
        }
    }

    /// Checks that the table covers these arc lengths, mm, to within 1 µm.
    fn check_range(&self, cut_from_mm: f64, cut_to_mm: f64) -> Result<(), LoadError> {
        let (table_from_mm, table_to_mm) = self.range_mm();
        if cut_from_mm >= table_from_mm - ROUNDING_MM && cut_to_mm <= table_to_mm + ROUNDING_MM {
            return Ok(());
        }
        Err(LoadError::TableTooShort { table_from_mm, table_to_mm, cut_from_mm, cut_to_mm })
    }
}

/// Parses the rows of a table: arc length (mm) and load each; a fault comes with its byte in the file.
fn parse(source: &[u8]) -> Result<Vec<(f64, Load)>, (usize, TableFault)> {
    let rows = csv_rows::read(source).map_err(|(at, reason)| (at, RowFault::NotCsv { reason }.into()))?;
    let Some((header, rows)) = rows.split_first() else {
        return Err((0, TableFault::TooFewRows { found: 0 }));
    };
    let order = column_order(header).map_err(|fault| (header.span.start, fault))?;
    let mut table: Vec<(f64, Load)> = Vec::with_capacity(rows.len());
    for row in rows {
        let at = row.span.start;
        let [length, fx, fy, fz, mx, my, mz] = row_numbers(row, &order).map_err(|fault| (at, fault.into()))?;
        if let Some(&(before, _)) = table.last().filter(|last| last.0 >= length) {
            return Err((at, TableFault::Order { found: length, before }));
        }
        table.push((length, Load { force_N: Vector3::new(fx, fy, fz), moment_Nmm: Vector3::new(mx, my, mz) }));
    }
    if table.len() < 2 {
        return Err((source.len(), TableFault::TooFewRows { found: table.len() }));
    }
    Ok(table)
}

/// Returns the index in a row of each of [`COLUMNS`]; fails if the header names other columns.
fn column_order(header: &Row) -> Result<[usize; 7], TableFault> {
    let names: Vec<_> = header.fields.iter().map(|name| String::from_utf8_lossy(name)).collect();
    let positions = COLUMNS.map(|column| names.iter().position(|name| name == column));
    // As many names as columns and each column among them: no other name and none twice.
    if names.len() != COLUMNS.len() || positions.contains(&None) {
        return Err(TableFault::Header { found: names.join(","), expected: COLUMNS.join(",") });
    }
    Ok(positions.map(Option::unwrap_or_default))
}

/// Parses the numbers of a row, in the order of [`COLUMNS`], which stand at the indices `order`.
fn row_numbers(row: &Row, order: &[usize; 7]) -> Result<[f64; 7], RowFault> {
    if row.fields.len() != COLUMNS.len() {
        return Err(RowFault::Width { found: row.fields.len(), expected: COLUMNS.len() });
    }
    let mut numbers = [0.0; 7];
    for (column, (&position, number)) in order.iter().zip(&mut numbers).enumerate() {
        let text = String::from_utf8_lossy(&row.fields[position]);
        let read = text.parse::<f64>().ok().filter(|value| value.abs() <= MOST && (column > 0 || *value >= 0.0));
        *number = read.ok_or_else(|| RowFault::Value {
            column: COLUMNS[column].into(),
            value: text.into_owned(),
            expected: if column == 0 { "a length in mm, from 0 to 1e12" } else { "a number up to 1e12" },
        })?;
    }
    Ok(numbers)
}

/// The largest number accepted: beyond any cut, and far from overflow.
const MOST: f64 = 1e12;
