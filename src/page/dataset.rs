//! The numbers of an explorer, from its table.

use std::collections::HashMap;

use super::{
    columns::Columns,
    description::{Explorer, Shape},
    nodes::{Axes, Nodes},
    table::Table,
};
use crate::input::error::Result;

/// Most numbers that a page holds; a larger grid is thinned.
pub(super) const MOST_NUMBERS: usize = 4_000_000;

/// Numbers over nodes, by quantity and group.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dataset {
    /// Node coordinates along each axis of a grid, x fastest; along a curve, one list.
    pub axes: Vec<Vec<f64>>,
    /// Names of the nodes, where they have names.
    pub names: Vec<String>,
    /// Values by quantity, then group, then node; NaN where there is none.
    pub values: Vec<Vec<Vec<f64>>>,
    /// Nodes that are no plain answer: index and index into `notes`, by group.
    pub flags: Vec<Vec<(usize, usize)>>,
    /// Status and reason.
    pub notes: Vec<String>,
    /// Nodes of the table along each axis if not all are here.
    pub thinned_from: Option<Vec<usize>>,
}

impl Dataset {
    /// Reads the numbers of `explorer`, a grid thinned to about `most` numbers.
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

    fn fill(&mut self, explorer: &Explorer, table: &Table, columns: &Columns, mut nodes: Nodes) -> Result<()> {
        let groups = self.flags.len();
        let count = nodes.count();
        self.values = vec![vec![vec![f64::NAN; count]; groups]; explorer.quantities.len()];
        let mut known_notes: HashMap<String, usize> = HashMap::new();
        let mut line: Vec<f64> = Vec::new();
        let mut fault = None;
        table.each_row(|row| {
            if fault.is_none() {
                fault = columns.no_number(row, explorer.shape).map(|column| table.no_number(row, column));
            }
            let group = columns.group(explorer, row);
            let Some((group, node)) = group.and_then(|group| Some((group, nodes.of(columns, row, group)?))) else {
                return;
            };
            if explorer.shape != Shape::Grid && node == line.len() {
                let text = row.get(columns.coordinates[0]).unwrap_or_default();
                line.push(text.parse().unwrap_or(f64::NAN));
                self.names.push(text.to_string());
            }
            for (quantity, values) in self.values.iter_mut().enumerate() {
                let values = &mut values[group];
                if values.len() <= node {
                    values.resize(node + 1, f64::NAN);
                }
                values[node] = columns.value(quantity, row);
            }
            if let Some(note) = columns.note(row) {
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
                self.axes = vec![line.clone()];
                self.names.clear();
            }
            Shape::Names => {}
        }
        let count = if explorer.shape == Shape::Grid { count } else { line.len() };
        self.values.iter_mut().flatten().for_each(|values| values.resize(count, f64::NAN));
        Ok(())
    }

    /// All numbers, missing ones included.
    pub(crate) fn number_count(&self) -> usize {
        self.values.iter().flatten().map(Vec::len).sum()
    }

    /// Number of nodes.
    pub(crate) fn node_count(&self) -> usize {
        if self.axes.is_empty() { self.names.len() } else { self.axes.iter().map(Vec::len).product() }
    }

    /// The part at the nodes that `other` has as well.
    pub(crate) fn at_nodes_of(&self, other: &Self) -> Self {
        let kept_names: Vec<usize> = (0..self.names.len()).filter(|i| other.names.contains(&self.names[*i])).collect();
        let kept: Vec<Vec<usize>> = self
            .axes
            .iter()
            .zip(&other.axes)
            .map(|(own, other)| (0..own.len()).filter(|i| contains(other, own[*i])).collect())
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

    /// Coordinates of a node; `None` where nodes have names.
    pub(crate) fn position(&self, node: usize) -> Option<Vec<f64>> {
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

    /// The node's place in words, coordinates as in `explorer`.
    pub fn place(&self, explorer: &Explorer, node: usize) -> String {
        if let Some(name) = self.names.get(node) {
            return name.clone();
        }
        let mut rest = node;
        let mut parts = Vec::new();
        for (axis, coordinate) in self.axes.iter().zip(&explorer.coordinates) {
            let value = axis[rest % axis.len()];
            rest /= axis.len();
            if axis.len() > 1 {
                parts.push(format!("{} {} {}", coordinate.label, super::table::number(value), coordinate.unit));
            }
        }
        parts.join(", ")
    }
}

/// Whether an ascending axis has `value`, but for rounding.
fn contains(axis: &[f64], value: f64) -> bool {
    let rounding = 1e-9 * (1.0 + value.abs());
    let next = axis.partition_point(|other| *other < value - rounding);
    axis.get(next).is_some_and(|other| *other <= value + rounding)
}

/// Indices of the nodes at these positions along the axes, x fastest.
fn grid_nodes(axes: &[Vec<f64>], kept: &[Vec<usize>]) -> Vec<usize> {
    let mut nodes = vec![0];
    for (axis, kept) in axes.iter().zip(kept).rev() {
        nodes = nodes.iter().flat_map(|node| kept.iter().map(move |i| node * axis.len() + i)).collect();
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::{
        super::description::{Better, Column, Group, GroupValue, Quantity},
        *,
    };

    fn explorer(shape: Shape) -> Explorer {
        let coordinates = match shape {
            Shape::Grid => vec![Column::new("x", "x", "mm"), Column::new("y", "y", "mm")],
            Shape::Curve | Shape::Names => vec![Column::new("x", "x", "mm")],
        };
        let value = |value: &str| GroupValue { cells: vec![value.into()], label: value.into() };
        Explorer {
            title: "test".into(),
            table: "t.csv".into(),
            shape,
            coordinates,
            group: Some(Group { columns: vec!["g".into()], label: "g".into(), values: vec![value("b"), value("a")] }),
            quantities: vec![Quantity::new(["v", "w"], "largest", "mm", Better::Smaller)],
            marks: Vec::new(),
        }
    }

    const TABLE: &str =
        "x,y,g,status,reason,v,w\n0,0,a,solved,,1,-2\n0,0,b,solved,,3,1\n1,0,a,lost,far,,\n1,0,b,solved,,5,-6\n";

    fn read(shape: Shape, most: usize) -> Dataset {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("t.csv");
        std::fs::write(&file, TABLE).unwrap();
        Dataset::read(&explorer(shape), &Table::open(&file).unwrap(), most).unwrap()
    }

    #[test]
    fn rows_find_their_nodes_and_groups() {
        let data = read(Shape::Grid, 1000);
        assert_eq!(data.axes, [vec![0.0, 1.0], vec![0.0]]);
        assert_eq!(data.values[0][0], [3.0, 6.0]);
        assert_eq!(data.values[0][1][0], 2.0);
        assert!(data.values[0][1][1].is_nan());
        assert_eq!((data.flags[1].as_slice(), data.notes.as_slice()), (&[(1, 0)][..], &["lost: far".to_string()][..]));
        assert_eq!(read(Shape::Curve, 1000).axes, [vec![0.0, 1.0]]);
        assert_eq!(read(Shape::Names, 1000).names, ["0", "1"]);
    }

    #[test]
    fn only_nodes_of_both_are_in_common() {
        for shape in [Shape::Grid, Shape::Curve, Shape::Names] {
            let all = read(shape, 1000);
            let mut other = all.clone();
            other.axes.first_mut().into_iter().for_each(|axis| axis[0] = 7.0);
            other.names.first_mut().into_iter().for_each(|name| *name = "other".into());
            other.axes.first_mut().into_iter().for_each(|axis| axis.sort_by(f64::total_cmp));
            let part = all.at_nodes_of(&other);
            assert_eq!(part.node_count(), 1, "{shape:?}");
            assert_eq!(part.values[0][0], [6.0], "{shape:?}");
            assert_eq!(part.flags[1], [(0, 0)], "{shape:?}");
            other.axes.first_mut().into_iter().for_each(|axis| axis.truncate(0));
            other.names.clear();
            assert_eq!(all.at_nodes_of(&other).node_count(), 0, "{shape:?}");
        }
    }
}
