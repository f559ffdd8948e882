//! Which rows of a long table of path points are kept: points at equal steps, the worst of each step, and the extremes of every column.

use std::{
    io::{Result, Write},
    str::FromStr,
    sync::Arc,
};

use super::{Cell, Column, CsvFile, Kind, Row, Table};

/// Most rows of a table of path points that is written whole; of a longer one as many are kept.
pub const MAX_ROWS: usize = 50_000;

/// Which rows of a table of path points are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WrittenRows {
    /// All up to [`MAX_ROWS`]; of more, those that [`KeptRows`] keeps.
    #[default]
    Bounded,
    /// All.
    All,
}

impl FromStr for WrittenRows {
    type Err = String;

    /// Reads `all`.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "all" => Ok(WrittenRows::All),
            _ => Err("expected all: the points are those of the path".into()),
        }
    }
}

/// Points of a path as `--points` of a run names them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Points {
    /// Rows of all points are written.
    All,
    /// So many points are computed along a circle.
    Count(usize),
}

impl FromStr for Points {
    type Err = String;

    /// Reads a number of points, or `all`.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "all" => Ok(Points::All),
            count => count.parse().map(Points::Count).map_err(|_| "expected a number of points, or all".into()),
        }
    }
}

/// Rows kept of a table that has more than [`MAX_ROWS`]. Its first column numbers the points; the rows of a point follow one another, as many
/// for each point. The choice depends on the rows alone, whatever parts they come in.
pub struct KeptRows {
    rows_per_point: usize,
    /// Rows of the whole table.
    total: usize,
    /// Number of points of a step.
    step: usize,
    /// Columns of numbers.
    numbers: Vec<usize>,
    /// Columns by which a point is the worst of its step, the largest value being the worst.
    ranked_by: Vec<(usize, String)>,
    /// The first and the worst points of each step.
    kept: Vec<Arc<PointRows>>,
    /// The worst point of the current step, by each column of `ranked_by`.
    worst: Vec<Option<(f64, Arc<PointRows>)>>,
    /// The point with the largest absolute value, by row of a point and column of `numbers`.
    largest: Vec<Option<(f64, Arc<PointRows>)>>,
}

/// Rows of a point as CSV.
struct PointRows {
    point: usize,
    csv: Vec<u8>,
}

impl KeptRows {
    /// Starts the choice from a table with `columns` of so many `points` with `rows_per_point` each, in which the largest values of the columns `ranked_by` are the worst.
    /// `None` where all rows are written.
    pub fn new(
        columns: &[Column],
        points: usize,
        rows_per_point: usize,
        ranked_by: &[&str],
        written: WrittenRows,
    ) -> Option<Self> {
        let total = points * rows_per_point;
        if written == WrittenRows::All || total <= MAX_ROWS {
            return None;
        }
        let numbers: Vec<usize> = (0..columns.len()).filter(|i| columns[*i].kind == Kind::Number).collect();
        let position = |name: &str| columns.iter().position(|column| column.name == name);
        let ranked_by: Vec<(usize, String)> =
            ranked_by.iter().filter_map(|name| Some((position(name)?, (*name).to_string()))).collect();
        let extremes = rows_per_point * numbers.len();
        let steps = (MAX_ROWS / rows_per_point).saturating_sub(extremes) / (1 + ranked_by.len());
        Some(Self {
            rows_per_point,
            total,
            step: points.div_ceil(steps.max(1)),
            kept: Vec::new(),
            worst: vec![None; ranked_by.len()],
            largest: vec![None; extremes],
            numbers,
            ranked_by,
        })
    }

    /// Adds the rows of `table`, the next ones. `Err` if a row cannot be formatted.
    pub(super) fn add(&mut self, table: &Table) -> csv::Result<()> {
        table.rows().chunks(self.rows_per_point).try_for_each(|rows| self.add_point(table.columns(), rows))
    }

    /// Adds the rows of the next point: keeps it at the start of a step, as the worst of its step, or as an extreme of a column.
    fn add_point(&mut self, columns: &[Column], rows: &[Row]) -> csv::Result<()> {
        let Some(Cell::Count(point)) = rows.first().and_then(|row| row.first()) else { return Ok(()) };
        let mut encoded: Option<Arc<PointRows>> = None;
        let mut encode = || -> csv::Result<Arc<PointRows>> {
            if let Some(known) = &encoded {
                return Ok(Arc::clone(known));
            }
            let mut file = CsvFile::without_header(Vec::new());
            file.add(&Table::new(columns.to_vec(), rows.to_vec()))?;
            Ok(Arc::clone(encoded.insert(Arc::new(PointRows { point: *point, csv: file.finish()? }))))
        };
        if point.is_multiple_of(self.step) {
            self.kept.extend(self.worst.iter_mut().filter_map(Option::take).map(|(_, worst)| worst));
            self.kept.push(encode()?);
        }
        for ((column, _), worst) in self.ranked_by.iter().zip(&mut self.worst) {
            // Without a number no point is shown to be better.
            let values = rows.iter().map(|row| number(&row[*column]).unwrap_or(f64::INFINITY));
            let value = values.fold(f64::NEG_INFINITY, f64::max);
            if worst.as_ref().is_none_or(|(most, _)| value > *most) {
                *worst = Some((value, encode()?));
            }
        }
        let columns = rows.iter().flat_map(|row| self.numbers.iter().map(|column| &row[*column]));
        for (cell, largest) in columns.zip(&mut self.largest) {
            let Some(size) = number(cell).map(f64::abs) else { continue };
            if largest.as_ref().is_none_or(|(most, _)| size > *most) {
                *largest = Some((size, encode()?));
            }
        }
        Ok(())
    }

    /// Writes the rows kept, in path order, to `out`, and returns which they are of the table called `stem`. `Err` if `out` cannot be written.
    pub(super) fn finish(self, stem: &str, out: &mut impl Write) -> Result<String> {
        let extremes = self.worst.into_iter().chain(self.largest).flatten().map(|(_, rows)| rows);
        let mut kept: Vec<Arc<PointRows>> = self.kept.into_iter().chain(extremes).collect();
        kept.sort_by_key(|rows| rows.point);
        kept.dedup_by_key(|rows| rows.point);
        let worst = self.ranked_by.iter().map(|(_, name)| format!("the largest {name}"));
        let worst = worst.collect::<Vec<_>>().join(" and that with ");
        kept.iter().try_for_each(|rows| out.write_all(&rows.csv))?;
        Ok(format!(
            "{stem}.csv has {} of {} rows: every {} point, from each to the next the one with {worst} (or without a number there), and for \
             each column the one with the largest absolute value. All other results are of all points; --points all writes all rows.",
            kept.len() * self.rows_per_point,
            self.total,
            ordinal(self.step),
        ))
    }
}

/// Returns the real number in a cell; `None` for cells of other kinds.
fn number(cell: &Cell) -> Option<f64> {
    if let Cell::Number(value) = cell { Some(*value) } else { None }
}

/// Returns a number as an ordinal: "2nd".
fn ordinal(number: usize) -> String {
    let ending = match (number % 10, number % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
}
