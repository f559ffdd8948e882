//! The numbers of an interactive view, read from its table.

use std::collections::{HashMap, HashSet};

use csv::StringRecord;

use super::{
    description::{Explorer, GroupValue, Quantity, Shape},
    table::{Table, format_number},
};
use crate::{input::error::Result, simulation::is_solved_status};

/// Most numbers that a page holds; larger tables are thinned.
pub(super) const MAX_NUMBERS: usize = 4_000_000;

/// Numbers of a view at its nodes (grid points, points of a curve, or names), by quantity and group.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// Node coordinates along each axis of a grid, x fastest; along a curve, one list.
    pub axes: Vec<Vec<f64>>,
    /// Names of the nodes, where they have names.
    pub names: Vec<String>,
    /// Values by quantity, then group, then node; NaN where there is none.
    pub values: Vec<Vec<Vec<f64>>>,
    /// Flagged nodes by group, whose numbers are not valid results: index of the node, and index into `notes`.
    pub flags: Vec<Vec<(usize, usize)>>,
    /// Different texts of status and reason.
    pub notes: Vec<String>,
    /// Number of nodes of the whole table along each axis, if some are left out here.
    pub thinned_from: Option<Vec<usize>>,
}

impl Dataset {
    /// Reads the numbers of `explorer` from its table, thinned to about `most` numbers; `Err` when the table cannot be read, lacks a
    /// column, or has a cell that should be a number and is none.
    pub fn read(explorer: &Explorer, table: &Table, most: usize) -> Result<Self> {
        let columns = Columns::new(explorer, table)?;
        let groups = explorer.group.as_ref().map_or(1, |group| group.values.len());
        let most = most / explorer.quantities.len().max(1);
        let Axes { nodes, values: axes, thinned_from } = match explorer.shape {
            Shape::Grid => Nodes::grid(&columns, table, most / groups.max(1))?,
            Shape::Curve | Shape::Names => Nodes::in_order(table, groups, most)?,
        };
        let mut data = Self {
            axes,
            names: Vec::new(),
            values: Vec::new(),
            flags: vec![Vec::new(); groups],
            notes: Vec::new(),
            thinned_from,
        };
        data.fill(explorer, table, &columns, nodes)?;
        Ok(data)
    }

    /// Reads values, names and flags of all rows into the nodes; `Err` for a cell that should be a number and is none.
    fn fill(&mut self, explorer: &Explorer, table: &Table, columns: &Columns, mut nodes: Nodes) -> Result<()> {
        let groups = self.flags.len();
        let count = nodes.count();
        self.values = vec![vec![vec![f64::NAN; count]; groups]; explorer.quantities.len()];
        let mut known_notes: HashMap<String, usize> = HashMap::new();
        let mut coordinates_read: Vec<f64> = Vec::new();
        let mut fault = None;
        table.each_row(|row| {
            if fault.is_none() {
                fault = columns.non_number_column(row, explorer.shape).map(|column| table.not_a_number(row, column));
            }
            let group = columns.group(explorer, row);
            let Some((group, node)) = group.and_then(|group| Some((group, nodes.node_of(columns, row, group)?))) else {
                return;
            };
            if explorer.shape != Shape::Grid && node == coordinates_read.len() {
                let text = row.get(columns.coordinates[0]).unwrap_or_default();
                coordinates_read.push(text.parse().unwrap_or(f64::NAN));
                self.names.push(text.to_string());
            }
            for (quantity, values) in self.values.iter_mut().enumerate() {
                let values = &mut values[group];
                if values.len() <= node {
                    values.resize(node + 1, f64::NAN);
                }
                values[node] = columns.value(quantity, row);
            }
            if let Some(note) = columns.status_note(row) {
                let next = self.notes.len();
                let index = *known_notes.entry(note.clone()).or_insert(next);
                if index == next {
                    self.notes.push(note);
                }
                self.flags[group].push((node, index));
            }
        })?;
        if let Some(fault) = fault {
            return Err(fault);
        }
        match explorer.shape {
            Shape::Grid => self.names.clear(),
            Shape::Curve => {
                self.axes = vec![coordinates_read.clone()];
                self.names.clear();
            }
            Shape::Names => {}
        }
        let count = if explorer.shape == Shape::Grid { count } else { coordinates_read.len() };
        self.values.iter_mut().flatten().for_each(|values| values.resize(count, f64::NAN));
        Ok(())
    }

    /// Returns the number of values in all quantities and groups, missing ones included.
    pub fn number_count(&self) -> usize {
        self.values.iter().flatten().map(Vec::len).sum()
    }

    /// Returns the number of nodes.
    pub fn node_count(&self) -> usize {
        if self.axes.is_empty() { self.names.len() } else { self.axes.iter().map(Vec::len).product() }
    }

    /// Returns the numbers at the nodes that `other` has as well.
    pub fn restricted_to(&self, other: &Self) -> Self {
        let kept_names: Vec<usize> = (0..self.names.len()).filter(|i| other.names.contains(&self.names[*i])).collect();
        let kept: Vec<Vec<usize>> = self
            .axes
            .iter()
            .zip(&other.axes)
            .map(|(own, other)| (0..own.len()).filter(|i| axis_contains(other, own[*i])).collect())
            .collect();
        let nodes: Vec<usize> = if self.axes.is_empty() { kept_names.clone() } else { grid_nodes(&self.axes, &kept) };
        let position: HashMap<usize, usize> = nodes.iter().enumerate().map(|(new, old)| (*old, new)).collect();
        let pick = |values: &Vec<f64>| nodes.iter().map(|node| values[*node]).collect();
        let flags = |flags: &Vec<(usize, usize)>| {
            flags.iter().filter_map(|(node, note)| Some((*position.get(node)?, *note))).collect()
        };
        Self {
            axes: self.axes.iter().zip(&kept).map(|(axis, kept)| kept.iter().map(|i| axis[*i]).collect()).collect(),
            names: kept_names.iter().map(|i| self.names[*i].clone()).collect(),
            values: self.values.iter().map(|groups| groups.iter().map(pick).collect()).collect(),
            flags: self.flags.iter().map(flags).collect(),
            notes: self.notes.clone(),
            thinned_from: self.thinned_from.clone(),
        }
    }

    /// Returns the coordinates of a node; `None` where nodes have names.
    pub fn position(&self, node: usize) -> Option<Vec<f64>> {
        if self.axes.is_empty() {
            return None;
        }
        let mut rest = node;
        let coordinate = |axis: &Vec<f64>| {
            let value = axis[rest % axis.len()];
            rest /= axis.len();
            value
        };
        Some(self.axes.iter().map(coordinate).collect())
    }

    /// Returns the name of a node, or its coordinates with labels and units of `explorer`.
    pub fn node_label(&self, explorer: &Explorer, node: usize) -> String {
        if let Some(name) = self.names.get(node) {
            return name.clone();
        }
        let values = self.position(node).unwrap_or_default();
        let coordinates = explorer.coordinates.iter().zip(values).zip(&self.axes).filter(|(_, axis)| axis.len() > 1);
        let text = coordinates.map(|((of, value), _)| format!("{} {} {}", of.label, format_number(value), of.unit));
        text.collect::<Vec<_>>().join(", ")
    }
}

/// Returns whether an ascending axis contains `value`, but for rounding.
fn axis_contains(axis: &[f64], value: f64) -> bool {
    let rounding = 1e-9 * (1.0 + value.abs());
    let next = axis.partition_point(|other| *other < value - rounding);
    axis.get(next).is_some_and(|other| *other <= value + rounding)
}

/// Returns the indices of the grid nodes at the positions `kept` along each axis, x fastest.
fn grid_nodes(axes: &[Vec<f64>], kept: &[Vec<usize>]) -> Vec<usize> {
    let mut nodes = vec![0];
    for (axis, kept) in axes.iter().zip(kept).rev() {
        nodes = nodes.iter().flat_map(|node| kept.iter().map(move |i| node * axis.len() + i)).collect();
    }
    nodes
}

/// Assigns nodes to the rows of a table.
pub(super) enum Nodes {
    /// By coordinates: maps the bits of a value to its position, for each axis.
    Grid(Vec<HashMap<u64, usize>>),
    /// By order in each group: number of rows read so far, of which every `stride`-th is a node.
    InOrder { seen: Vec<usize>, stride: usize },
}

impl Nodes {
    /// Returns the nodes of a grid, thinned so that at most `most` remain.
    pub fn grid(columns: &Columns, table: &Table, most: usize) -> Result<Axes> {
        let mut axes: Vec<HashSet<u64>> = vec![HashSet::new(); columns.coordinates.len()];
        table.each_row(|row| {
            for (axis, column) in axes.iter_mut().zip(&columns.coordinates) {
                axis.extend(row.get(*column).and_then(coordinate).map(f64::to_bits));
            }
        })?;
        let mut all: Vec<Vec<f64>> =
            axes.into_iter().map(|axis| axis.into_iter().map(f64::from_bits).collect()).collect();
        all.iter_mut().for_each(|axis| axis.sort_by(f64::total_cmp));
        let kept = thin_axes(&all, most);
        let thinned_from = (kept != all).then(|| all.iter().map(Vec::len).collect());
        let positions = |axis: &Vec<f64>| axis.iter().enumerate().map(|(i, value)| (value.to_bits(), i)).collect();
        Ok(Axes { nodes: Self::Grid(kept.iter().map(positions).collect()), values: kept, thinned_from })
    }

    /// Returns the rows in order as nodes, thinned so that about `most` remain in all groups together.
    pub(crate) fn in_order(table: &Table, groups: usize, most: usize) -> Result<Axes> {
        let mut rows = 0usize;
        if table.most_rows()? > most as u64 {
            table.each_row(|_| rows += 1)?;
        }
        let stride = rows.div_ceil(most.max(1)).max(1);
        let thinned_from = (stride > 1).then(|| vec![rows / groups.max(1)]);
        Ok(Axes { nodes: Self::InOrder { seen: vec![0; groups], stride }, values: Vec::new(), thinned_from })
    }

    /// Returns the number of nodes; 0 where it is known only after reading the rows.
    pub fn count(&self) -> usize {
        match self {
            Self::Grid(axes) => axes.iter().map(HashMap::len).product(),
            Self::InOrder { .. } => 0,
        }
    }

    /// Returns the node of the next row of a group; `None` if the row belongs to no node.
    pub fn node_of(&mut self, columns: &Columns, row: &StringRecord, group: usize) -> Option<usize> {
        match self {
            Self::Grid(axes) => {
                let mut node = 0;
                for (axis, column) in axes.iter().zip(&columns.coordinates).rev() {
                    node = node * axis.len() + axis.get(&coordinate(row.get(*column)?)?.to_bits())?;
                }
                Some(node)
            }
            Self::InOrder { seen, stride } => {
                let row = seen[group];
                seen[group] += 1;
                row.is_multiple_of(*stride).then_some(row / *stride)
            }
        }
    }
}

/// Returns the coordinate in a cell, −0 as 0; `None` if it is no number.
fn coordinate(cell: &str) -> Option<f64> {
    cell.parse().ok().map(|value: f64| value + 0.0)
}

/// The nodes of a table, and their coordinates.
pub(super) struct Axes {
    pub nodes: Nodes,
    pub values: Vec<Vec<f64>>,
    /// Number of nodes of the table along each axis, if some are left out.
    pub thinned_from: Option<Vec<usize>>,
}

/// Returns the axes with evenly chosen values, both ends kept, so that at most `most` nodes remain.
pub fn thin_axes(axes: &[Vec<f64>], most: usize) -> Vec<Vec<f64>> {
    let mut counts: Vec<usize> = axes.iter().map(Vec::len).collect();
    while counts.iter().product::<usize>() > most.max(1) {
        let Some(longest) = counts.iter_mut().max().filter(|count| **count > 2) else { break };
        *longest -= 1;
    }
    let thin = |(axis, count): (&Vec<f64>, usize)| -> Vec<f64> {
        match count {
            0 | 1 => axis.clone(),
            n => (0..n).map(|k| axis[(k * (axis.len() - 1) + (n - 1) / 2) / (n - 1)]).collect(),
        }
    };
    axes.iter().zip(counts).map(thin).collect()
}

/// Positions in a row of the columns that a view needs.
pub(super) struct Columns {
    pub coordinates: Vec<usize>,
    group: Vec<usize>,
    quantities: Vec<Vec<usize>>,
    /// Columns of a status and its reason: of the row, and of its correction.
    notes: Vec<[usize; 2]>,
}

/// Names of the columns that say whether a row is a valid result, and its correction, and why not.
pub(super) const NOTES: [[&str; 2]; 2] = [["status", "reason"], ["correction_status", "correction_reason"]];

impl Columns {
    /// Finds the columns of `explorer` in `table`; `Err` if one is missing.
    pub fn new(explorer: &Explorer, table: &Table) -> Result<Self> {
        let column = |name: &String| table.column(name);
        let all_columns = |quantity: &Quantity| quantity.columns.iter().map(column).collect();
        let find = |name: &str| table.header.iter().position(|column| column == name);
        Ok(Self {
            coordinates: explorer.coordinates.iter().map(|c| column(&c.column)).collect::<Result<_>>()?,
            group: explorer.group.iter().flat_map(|group| &group.columns).map(column).collect::<Result<_>>()?,
            quantities: explorer.quantities.iter().map(all_columns).collect::<Result<_>>()?,
            notes: NOTES.iter().filter_map(|[status, reason]| Some([find(status)?, find(reason)?])).collect(),
        })
    }

    /// Returns the index of the row's group in `explorer`; 0 without groups, `None` if it belongs to none of them.
    pub fn group(&self, explorer: &Explorer, row: &StringRecord) -> Option<usize> {
        let Some(group) = &explorer.group else { return Some(0) };
        let has_cells =
            |value: &GroupValue| self.group.iter().zip(&value.cells).all(|(c, cell)| row.get(*c) == Some(cell));
        group.values.iter().position(has_cells)
    }

    /// Returns the value of a quantity in a row, of several columns the largest size; NaN where there is none.
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

    /// Returns the first column of `row` that should hold a number or nothing, and holds something else; `None` if all are right.
    pub fn non_number_column(&self, row: &StringRecord, shape: Shape) -> Option<usize> {
        let is_wrong = |column: usize| {
            let cell = row.get(column).unwrap_or_default();
            !cell.is_empty() && !cell.parse::<f64>().is_ok_and(|number| !number.is_nan())
        };
        let coordinates = if shape == Shape::Grid { self.coordinates.as_slice() } else { &[] };
        self.quantities.iter().flatten().chain(coordinates).copied().find(|column| is_wrong(*column))
    }

    /// Returns status and reason of a row that is not a valid result or has no valid correction; otherwise `None`.
    pub fn status_note(&self, row: &StringRecord) -> Option<String> {
        self.notes.iter().enumerate().find_map(|(index, &[status, reason])| {
            let status = row.get(status).filter(|status| !is_solved_status(status))?.replace('_', " ");
            let what = if index == 0 { "" } else { "no correction, " };
            match row.get(reason).filter(|reason| !reason.is_empty()) {
                Some(reason) => Some(format!("{what}{status}: {reason}")),
                None => Some(format!("{what}{status}")),
            }
        })
    }
}
