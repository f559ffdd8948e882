//! The numbers of an explorer, from its table.

use std::collections::{BTreeSet, HashMap};

use csv::StringRecord;

use super::{
    description::{Explorer, Shape},
    table::Table,
};
use crate::error::Result;

/// Most numbers that a page holds; a larger grid is thinned.
pub(super) const MOST_NUMBERS: usize = 4_000_000;

/// Rows with these statuses are answers; others are marked.
const GOOD: [&str; 2] = ["solved", "converged"];

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

/// Where the cells of a row are.
struct Columns {
    coordinates: Vec<usize>,
    group: Option<usize>,
    quantities: Vec<Vec<usize>>,
    status: Option<usize>,
    reason: Option<usize>,
}

impl Columns {
    fn new(explorer: &Explorer, table: &Table) -> Result<Self> {
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

    fn value(&self, quantity: usize, row: &StringRecord) -> f64 {
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
    fn note(&self, row: &StringRecord) -> Option<String> {
        let status = row.get(self.status?).filter(|status| !GOOD.contains(status))?.replace('_', " ");
        match self.reason.and_then(|reason| row.get(reason)).filter(|reason| !reason.is_empty()) {
            Some(reason) => Some(format!("{status}: {reason}")),
            None => Some(status),
        }
    }
}

impl Dataset {
    /// Reads the numbers of `explorer`, a grid thinned to about `most` numbers.
    pub fn read(explorer: &Explorer, table: &Table, most: usize) -> Result<Self> {
        let columns = Columns::new(explorer, table)?;
        let groups = explorer.group.as_ref().map_or(1, |group| group.values.len());
        let mut data = Self {
            axes: Vec::new(),
            names: Vec::new(),
            values: Vec::new(),
            flags: vec![Vec::new(); groups],
            notes: Vec::new(),
            thinned_from: None,
        };
        let nodes = match explorer.shape {
            Shape::Grid => Nodes::grid(&columns, table, most / (groups * explorer.quantities.len()).max(1), &mut data)?,
            Shape::Curve | Shape::Names => {
                Nodes::in_order(table, groups, most / explorer.quantities.len().max(1), &mut data)?
            }
        };
        data.fill(explorer, table, &columns, nodes)?;
        Ok(data)
    }

    fn fill(&mut self, explorer: &Explorer, table: &Table, columns: &Columns, mut nodes: Nodes) -> Result<()> {
        let groups = self.flags.len();
        let of_group: HashMap<&str, usize> = explorer
            .group
            .iter()
            .flat_map(|group| &group.values)
            .enumerate()
            .map(|(i, v)| (v.value.as_str(), i))
            .collect();
        let count = nodes.count();
        self.values = vec![vec![vec![f64::NAN; count]; groups]; explorer.quantities.len()];
        let mut known_notes: HashMap<String, usize> = HashMap::new();
        let mut line: Vec<f64> = Vec::new();
        table.each_row(|row| {
            let group = match columns.group {
                None => Some(0),
                Some(column) => row.get(column).and_then(|value| of_group.get(value)).copied(),
            };
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
    pub fn number_count(&self) -> usize {
        self.values.iter().flatten().map(Vec::len).sum()
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        if self.names.is_empty() { self.axes.iter().map(Vec::len).product() } else { self.names.len() }
    }

    /// The part at the nodes that `other` has as well.
    pub fn at_nodes_of(&self, other: &Self) -> Self {
        let kept_names: Vec<usize> = (0..self.names.len()).filter(|i| other.names.contains(&self.names[*i])).collect();
        let kept: Vec<Vec<usize>> = self
            .axes
            .iter()
            .zip(&other.axes)
            .map(|(own, other)| (0..own.len()).filter(|i| contains(other, own[*i])).collect())
            .collect();
        let nodes: Vec<usize> = if self.names.is_empty() { grid_nodes(&self.axes, &kept) } else { kept_names.clone() };
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

/// How rows find their nodes.
enum Nodes {
    /// By coordinates: for each axis the position of a value's bits.
    Grid(Vec<HashMap<u64, usize>>),
    /// By order in each group: rows seen so far, of which every so-many-th is a node.
    InOrder { seen: Vec<usize>, stride: usize },
}

impl Nodes {
    fn grid(columns: &Columns, table: &Table, most: usize, data: &mut Dataset) -> Result<Self> {
        let mut axes: Vec<BTreeSet<OrderedBits>> = vec![BTreeSet::new(); columns.coordinates.len()];
        table.each_row(|row| {
            for (axis, column) in axes.iter_mut().zip(&columns.coordinates) {
                if let Some(value) = row.get(*column).and_then(|cell| cell.parse::<f64>().ok()) {
                    axis.insert(OrderedBits(value));
                }
            }
        })?;
        let all: Vec<Vec<f64>> = axes.into_iter().map(|axis| axis.into_iter().map(|v| v.0).collect()).collect();
        data.axes = thinned(&all, most);
        if data.axes != all {
            data.thinned_from = Some(all.iter().map(Vec::len).collect());
        }
        let positions = |axis: &Vec<f64>| axis.iter().enumerate().map(|(i, value)| (value.to_bits(), i)).collect();
        Ok(Self::Grid(data.axes.iter().map(positions).collect()))
    }

    fn in_order(table: &Table, groups: usize, most: usize, data: &mut Dataset) -> Result<Self> {
        let mut rows = 0usize;
        table.each_row(|_| rows += 1)?;
        let stride = rows.div_ceil(most.max(1)).max(1);
        if stride > 1 {
            data.thinned_from = Some(vec![rows / groups.max(1)]);
        }
        Ok(Self::InOrder { seen: vec![0; groups], stride })
    }

    fn count(&self) -> usize {
        match self {
            Self::Grid(axes) => axes.iter().map(HashMap::len).product(),
            Self::InOrder { .. } => 0,
        }
    }

    fn of(&mut self, columns: &Columns, row: &StringRecord, group: usize) -> Option<usize> {
        match self {
            Self::Grid(axes) => {
                let mut node = 0;
                for (axis, column) in axes.iter().zip(&columns.coordinates).rev() {
                    let value: f64 = row.get(*column)?.parse().ok()?;
                    node = node * axis.len() + axis.get(&value.to_bits())?;
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

/// Numbers in order of size.
#[derive(Clone, Copy, PartialEq)]
struct OrderedBits(f64);

impl Eq for OrderedBits {}

impl PartialOrd for OrderedBits {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for OrderedBits {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// The axes with so many values left out that at most `most` nodes remain, both ends kept.
fn thinned(axes: &[Vec<f64>], most: usize) -> Vec<Vec<f64>> {
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
        let value = |value: &str| GroupValue { value: value.into(), label: value.into() };
        Explorer {
            title: "test".into(),
            table: "t.csv".into(),
            shape,
            coordinates,
            group: Some(Group { column: "g".into(), label: "g".into(), values: vec![value("b"), value("a")] }),
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
    fn a_large_grid_is_thinned_with_its_ends_kept() {
        let axis: Vec<f64> = (0..101).map(f64::from).collect();
        let axes = thinned(&[axis.clone(), axis.clone(), vec![5.0]], 500);
        assert_eq!((axes[0].len(), axes[1].len(), axes[2].len()), (22, 22, 1));
        for axis in &axes[..2] {
            assert_eq!((axis[0], axis[axis.len() - 1]), (0.0, 100.0));
            assert!(axis.windows(2).all(|pair| pair[0] < pair[1]));
        }
        assert_eq!(thinned(&[axis.clone()], 101), [axis]);
    }
}
