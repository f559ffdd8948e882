//! Which node of a grid, curve or list a row belongs to.

use std::collections::{BTreeSet, HashMap};

use csv::StringRecord;

use super::{columns::Columns, table::Table};
use crate::input::error::Result;

/// How rows find their nodes.
pub(super) enum Nodes {
    /// By coordinates: for each axis the position of a value's bits.
    Grid(Vec<HashMap<u64, usize>>),
    /// By order in each group: rows seen so far, of which every so-many-th is a node.
    InOrder { seen: Vec<usize>, stride: usize },
}

impl Nodes {
    /// Nodes of a grid, thinned so that at most `most` remain.
    pub fn grid(columns: &Columns, table: &Table, most: usize) -> Result<Axes> {
        let mut axes: Vec<BTreeSet<OrderedBits>> = vec![BTreeSet::new(); columns.coordinates.len()];
        table.each_row(|row| {
            for (axis, column) in axes.iter_mut().zip(&columns.coordinates) {
                if let Some(value) = row.get(*column).and_then(|cell| cell.parse::<f64>().ok()) {
                    axis.insert(OrderedBits(value));
                }
            }
        })?;
        let all: Vec<Vec<f64>> = axes.into_iter().map(|axis| axis.into_iter().map(|v| v.0).collect()).collect();
        let kept = thinned(&all, most);
        let thinned_from = (kept != all).then(|| all.iter().map(Vec::len).collect());
        let positions = |axis: &Vec<f64>| axis.iter().enumerate().map(|(i, value)| (value.to_bits(), i)).collect();
        Ok(Axes { nodes: Self::Grid(kept.iter().map(positions).collect()), values: kept, thinned_from })
    }

    /// Rows in order, thinned so that about `most` remain in all groups together.
    pub(crate) fn in_order(table: &Table, groups: usize, most: usize) -> Result<Axes> {
        let mut rows = 0usize;
        if table.most_rows()? > most as u64 {
            table.each_row(|_| rows += 1)?;
        }
        let stride = rows.div_ceil(most.max(1)).max(1);
        let thinned_from = (stride > 1).then(|| vec![rows / groups.max(1)]);
        Ok(Axes { nodes: Self::InOrder { seen: vec![0; groups], stride }, values: Vec::new(), thinned_from })
    }

    /// Number of nodes; 0 where it shows only as rows are read.
    pub fn count(&self) -> usize {
        match self {
            Self::Grid(axes) => axes.iter().map(HashMap::len).product(),
            Self::InOrder { .. } => 0,
        }
    }

    /// The node of a row, if it has one.
    pub fn of(&mut self, columns: &Columns, row: &StringRecord, group: usize) -> Option<usize> {
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

/// Nodes, and where they lie.
pub(super) struct Axes {
    pub nodes: Nodes,
    /// Coordinates along each axis of a grid.
    pub values: Vec<Vec<f64>>,
    /// Nodes of the table along each axis, if some are left out.
    pub thinned_from: Option<Vec<usize>>,
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
    use super::*;

    #[test]
    fn a_large_grid_is_thinned_with_its_ends_kept() {
        let axis: Vec<f64> = (0..101).map(f64::from).collect();
        let axes = thinned(&[axis.clone(), axis.clone(), vec![5.0]], 500);
        assert_eq!((axes[0].len(), axes[1].len(), axes[2].len()), (22, 22, 1));
        for axis in &axes[..2] {
            assert_eq!((axis[0], axis[axis.len() - 1]), (0.0, 100.0));
            assert!(axis.windows(2).all(|pair| pair[0] < pair[1]));
        }
        let whole = [axis];
        assert_eq!(thinned(&whole, 101), whole);
    }
}
