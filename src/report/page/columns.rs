//! Where the numbers of an explorer stand in the rows of its table.

use csv::StringRecord;

use super::{description::Explorer, table::Table};
use crate::error::Result;

/// Rows with these statuses are answers; others are marked.
const GOOD: [&str; 2] = ["solved", "converged"];

/// Where the cells of a row are.
pub(super) struct Columns {
    pub coordinates: Vec<usize>,
    pub group: Option<usize>,
    quantities: Vec<Vec<usize>>,
    status: Option<usize>,
    reason: Option<usize>,
}

impl Columns {
    pub fn new(explorer: &Explorer, table: &Table) -> Result<Self> {
        let column = |name: &String| table.column(name);
        let find = |name: &str| table.header.iter().position(|column| column == name);
        Ok(Self {
            coordinates: explorer.coordinates.iter().map(|c| column(&c.column)).collect::<Result<_>>()?,
            group: explorer.group.as_ref().map(|group| column(&group.column)).transpose()?,
            quantities: explorer
                .quantities
                .iter()
                .map(|quantity| quantity.columns.iter().map(column).collect())
                .collect::<Result<_>>()?,
            status: find("status"),
            reason: find("reason"),
        })
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

    /// Status and reason of a row that is no plain answer.
    pub fn note(&self, row: &StringRecord) -> Option<String> {
        let status = row.get(self.status?).filter(|status| !GOOD.contains(status))?.replace('_', " ");
        match self.reason.and_then(|reason| row.get(reason)).filter(|reason| !reason.is_empty()) {
            Some(reason) => Some(format!("{status}: {reason}")),
            None => Some(status),
        }
    }
}
