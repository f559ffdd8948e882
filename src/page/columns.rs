//! Where the numbers of an explorer stand in the rows of its table.

use csv::StringRecord;

use super::{
    description::{Explorer, GroupValue, Shape},
    table::Table,
};
use crate::{input::error::Result, simulation::is_found};

/// Where the cells of a row are.
pub(super) struct Columns {
    pub coordinates: Vec<usize>,
    group: Vec<usize>,
    quantities: Vec<Vec<usize>>,
    /// Columns of a status and its reason: of the row, and of its correction.
    notes: Vec<[usize; 2]>,
}

/// Columns that say whether a row is an answer, in full and in part, and why not.
pub(super) const NOTES: [[&str; 2]; 2] = [["status", "reason"], ["correction_status", "correction_reason"]];

impl Columns {
    pub fn new(explorer: &Explorer, table: &Table) -> Result<Self> {
        let column = |name: &String| table.column(name);
        let find = |name: &str| table.header.iter().position(|column| column == name);
        Ok(Self {
            coordinates: explorer.coordinates.iter().map(|c| column(&c.column)).collect::<Result<_>>()?,
            group: explorer.group.iter().flat_map(|group| &group.columns).map(column).collect::<Result<_>>()?,
            quantities: explorer
                .quantities
                .iter()
                .map(|quantity| quantity.columns.iter().map(column).collect())
                .collect::<Result<_>>()?,
            notes: NOTES.iter().filter_map(|[status, reason]| Some([find(status)?, find(reason)?])).collect(),
        })
    }

    /// Index of the row's group among those of `explorer`; 0 where it has none.
    pub fn group(&self, explorer: &Explorer, row: &StringRecord) -> Option<usize> {
        let Some(group) = &explorer.group else { return Some(0) };
        let is_own =
            |value: &GroupValue| self.group.iter().zip(&value.cells).all(|(c, cell)| row.get(*c) == Some(cell));
        group.values.iter().position(is_own)
    }

    /// The number of a quantity in a row; NaN where there is none.
    pub fn value(&self, quantity: usize, row: &StringRecord) -> f64 {
        let cell = |column: &usize| row.get(*column).and_then(|cell| cell.parse::<f64>().ok()).unwrap_or(f64::NAN);
        match self.quantities[quantity].as_slice() {
            [one] => cell(one),
            several => several
                .iter()
                .map(|column| cell(column).abs())
                .fold(0.0, |most, value| if value.is_nan() || most.is_nan() { f64::NAN } else { most.max(value) }),
        }
    }

    /// A column of `row` that should hold a number, or nothing, and does not.
    pub fn no_number(&self, row: &StringRecord, shape: Shape) -> Option<usize> {
        let is_wrong = |column: usize| {
            let cell = row.get(column).unwrap_or_default();
            !cell.is_empty() && !cell.parse::<f64>().is_ok_and(|number| !number.is_nan())
        };
        let coordinates = if shape == Shape::Grid { self.coordinates.as_slice() } else { &[] };
        self.quantities.iter().flatten().chain(coordinates).copied().find(|column| is_wrong(*column))
    }

    /// Status and reason of a row that is no plain answer, or whose correction is none.
    pub fn note(&self, row: &StringRecord) -> Option<String> {
        self.notes.iter().enumerate().find_map(|(index, &[status, reason])| {
            let status = row.get(status).filter(|status| !is_found(status))?.replace('_', " ");
            let what = if index == 0 { "" } else { "no correction, " };
            match row.get(reason).filter(|reason| !reason.is_empty()) {
                Some(reason) => Some(format!("{what}{status}: {reason}")),
                None => Some(format!("{what}{status}")),
            }
        })
    }
}
