//! Finds the smallest grid whose table is within tolerance: grown where interpolation errs most, then reduced along each axis as far as possible.

use super::{
    CorrectionQuestion, CorrectionTable, Corrector, ForceTerms, Worst,
    bound::{axis_forces, worst, worst_at_nodes},
    table::MAX_NODES,
};
use crate::{
    input::error::Result,
    machine::Motion,
    questions::Overrides,
    simulation::{Machines, ROUNDING_MM},
    work::{Event, Stage, Work},
};

/// A table, the largest error with it, and that at its nodes.
pub(super) struct CheckedTable {
    pub table: CorrectionTable,
    pub worst: Worst,
    pub at_nodes_mm: f64,
}

/// Returns the table of `question`, of the size it gives or the smallest within tolerance; an error if that needs more than [`MAX_NODES`] nodes.
pub(super) fn smallest_table(question: &CorrectionQuestion, machines: &Machines, work: &Work) -> Result<CheckedTable> {
    let search = SmallestSearch { question, machines, work, probe: probe(question, machines, work)? };
    let (table, worst) = match question.counts {
        Some(counts) => {
            let table = search.table(counts)?;
            let worst = search.worst(&table, f64::INFINITY)?;
            (table, worst)
        }
        None => search.shrink(search.grow()?)?,
    };
    let at_nodes_mm = worst_at_nodes(question, machines, &Corrector::Table(&table), &table.grid, work)?;
    Ok(CheckedTable { table, worst, at_nodes_mm })
}

/// Search for the smallest grid.
struct SmallestSearch<'a> {
    question: &'a CorrectionQuestion,
    machines: &'a Machines,
    work: &'a Work,
    probe: Probe,
}

impl SmallestSearch<'_> {
    /// Computes the table with `counts` nodes along x, y and z; an error if a node has no correction.
    fn table(&self, counts: [usize; 3]) -> Result<CorrectionTable> {
        self.work.tell(Event::Stage(Stage { of: "nodes", items: counts.iter().product() }));
        CorrectionTable::new(self.question, self.machines, counts, self.probe.terms, self.work)
    }

    /// Returns the largest error found with `table`; the search ends early above `enough` mm.
    fn worst(&self, table: &CorrectionTable, enough: f64) -> Result<Worst> {
        worst(self.question, self.machines, &Corrector::Table(table), &table.grid, enough, self.work)
    }

    /// Returns the table with `counts` nodes and its largest error if that is within tolerance; the inner `Err` is the error found, mm.
    fn table_within(&self, counts: [usize; 3]) -> Result<std::result::Result<(CorrectionTable, Worst), f64>> {
        let table = self.table(counts)?;
        let worst = self.worst(&table, self.question.tolerance_mm)?;
        Ok(if worst.error_mm > self.question.tolerance_mm { Err(worst.error_mm) } else { Ok((table, worst)) })
    }

    /// Grows the grid from an estimate until its table is within tolerance; an error if that takes more than [`MAX_NODES`] nodes.
    fn grow(&self) -> Result<(CorrectionTable, Worst)> {
        let tolerance = self.question.tolerance_mm;
        let floor = self.probe.at_nodes_mm;
        if floor > tolerance {
            return self.unreachable_tolerance(floor);
        }
        let mut counts = self.estimated_counts(1.0, f64::INFINITY);
        loop {
            let error = match self.table_within(counts)? {
                Ok(within) => return Ok(within),
                Err(error) => error,
            };
            // By how much the estimate is too small, and with that the grid that shares the tolerance among the axes.
            let scale = (error - floor).max(ROUNDING_MM) / self.estimate(counts).max(ROUNDING_MM);
            let sized = self.estimated_counts(scale, tolerance - floor);
            let worst = self.worst_axis(counts);
            counts = [0, 1, 2].map(|axis| counts[axis].max(sized[axis]).max(counts[axis] + usize::from(axis == worst)));
            if counts.iter().try_fold(1usize, |all, &n| all.checked_mul(n)).is_none_or(|all| all > MAX_NODES) {
                let nodes: f64 = counts.iter().map(|&n| n as f64).product();
                let share = self.estimate(counts) / libm::pow(nodes, -2.0 / 3.0);
                return self.unreachable_tolerance(floor + scale * share * libm::pow(MAX_NODES as f64, -2.0 / 3.0));
            }
        }
    }

    /// Removes nodes along each axis as long as the table stays within tolerance; returns the last such table and its largest error.
    fn shrink(&self, mut found: (CorrectionTable, Worst)) -> Result<(CorrectionTable, Worst)> {
        let mut axes: Vec<usize> = self.question.axes().collect();
        // First along those where a node takes the most others with it.
        let cost = |found: &(CorrectionTable, Worst), axis: usize| found.0.grid.axes[axis].len();
        axes.sort_by_key(|&axis| cost(&found, axis));
        let mut tight = 0;
        let mut turn = 0;
        while !axes.is_empty() && tight < axes.len() {
            let axis = axes[turn % axes.len()];
            let mut counts = found.0.grid.counts();
            counts[axis] -= 1;
            turn += 1;
            if counts[axis] < 2 {
                tight += 1;
                continue;
            }
            match self.table_within(counts)? {
                Ok(smaller) => {
                    found = smaller;
                    tight = 0;
                    turn -= 1;
                }
                Err(_) => tight += 1,
            }
        }
        Ok(found)
    }

    /// Returns the interpolation error estimated for `counts` nodes, mm.
    fn estimate(&self, counts: [usize; 3]) -> f64 {
        self.question.axes().map(|axis| self.axis_estimate(counts, axis)).sum()
    }

    /// Returns the part of the estimated interpolation error along `axis`, mm.
    fn axis_estimate(&self, counts: [usize; 3], axis: usize) -> f64 {
        let steps = (counts[axis] - 1) as f64;
        self.probe.bends_mm[axis] / (steps * steps)
    }

    /// Returns the axis with the largest estimated interpolation error of a grid with `counts` nodes.
    fn worst_axis(&self, counts: [usize; 3]) -> usize {
        let by_share = |&a: &usize, &b: &usize| {
            self.axis_estimate(counts, a).total_cmp(&self.axis_estimate(counts, b)).then(b.cmp(&a))
        };
        self.question.axes().max_by(by_share).unwrap_or(0)
    }

    /// Returns the fewest nodes whose estimated error times `scale` is `allowed` mm, shared equally among the axes.
    fn estimated_counts(&self, scale: f64, allowed: f64) -> [usize; 3] {
        let axes: Vec<usize> = self.question.axes().collect();
        let each = allowed.max(ROUNDING_MM) / axes.len().max(1) as f64;
        [0, 1, 2].map(|axis| match axes.contains(&axis) {
            true => {
                1 + ((scale * self.probe.bends_mm[axis] / each).sqrt().ceil().min(MAX_NODES as f64) as usize).max(1)
            }
            false => 1,
        })
    }

    /// Returns the error that the tolerance needs too many nodes, where the largest table would leave `reachable` mm.
    fn unreachable_tolerance<T>(&self, reachable: f64) -> Result<T> {
        let problem = format!(
            "no table of at most {MAX_NODES} nodes stays within {} mm for forces up to {} N; {:.2} mm can be reached: expected a larger tolerance, a smaller force or a smaller box",
            self.question.tolerance_mm,
            (self.question.largest_force_N * 10.0).round() / 10.0,
            (reachable * 100.0).ceil() / 100.0
        );
        Overrides::location("tolerance").fail(problem)
    }
}

/// Number of probe nodes along each axis.
const NODES: usize = 5;
/// Share of the tolerance that terms in the force may leave at the nodes.
const ENOUGH: f64 = 0.5;

/// Findings on a coarse grid, from which the size of the table is estimated.
pub(super) struct Probe {
    /// Terms in the force that are needed.
    pub terms: ForceTerms,
    /// Largest error that these terms leave at nodes, mm.
    pub at_nodes_mm: f64,
    /// Interpolation error along each axis between n nodes, times `(n − 1)²`, mm.
    pub bends_mm: [f64; 3],
}

/// Probes a coarse grid over the box of `question` for the terms needed and the interpolation error; an error if a node has no correction.
pub(super) fn probe(question: &CorrectionQuestion, machines: &Machines, work: &Work) -> Result<Probe> {
    let counts = question.grid(|_| NODES).counts();
    work.tell(Event::Stage(Stage { of: "nodes", items: counts.iter().product() }));
    let most = if question.largest_force_N > 0.0 { ForceTerms::Quadratic } else { ForceTerms::Constant };
    let table = CorrectionTable::new(question, machines, counts, most, work)?;
    let nodes = question.grid(|_| 3);
    let error_of = |table: &CorrectionTable| worst_at_nodes(question, machines, &Corrector::Table(table), &nodes, work);
    let linear = table.without_quadratic_terms();
    let linear_left = error_of(&linear)?;
    let (terms, at_nodes_mm) = match linear_left <= ENOUGH * question.tolerance_mm {
        true => (linear.terms, linear_left),
        false => (most, error_of(&table)?),
    };
    Ok(Probe { terms, at_nodes_mm, bends_mm: [0, 1, 2].map(|axis| max_curvature(question, &table, axis)) })
}

/// Returns (n − 1)² times the interpolation error along `axis` between n nodes, mm, revolute joints at the machine's characteristic length.
fn max_curvature(question: &CorrectionQuestion, table: &CorrectionTable, axis: usize) -> f64 {
    let (grid, machine) = (&table.grid, &question.machine);
    let steps = grid.axes[axis].len() - 1;
    let stride = grid.index([0, 1, 2].map(|other| usize::from(other == axis && steps > 0)));
    let length = machine.characteristic_length;
    let weights = machine.drives().map(|(_, drive)| if drive.motion == Motion::Revolute { length } else { 1.0 });
    let weights: Vec<f64> = weights.collect();
    let mut largest = 0.0f64;
    for force in axis_forces(question.largest_force_N) {
        let corrections: Vec<Vec<f64>> =
            (0..grid.len()).map(|node| table.correction(grid.position(node), force)).collect();
        for node in 0..grid.len() {
            let place = grid.position(node)[axis];
            if steps < 2 || place == grid.axes[axis][0] || place == grid.axes[axis][steps] {
                continue;
            }
            let [before, here, after] = [node - stride, node, node + stride].map(|node| &corrections[node]);
            let second = (0..weights.len()).map(|d| weights[d] * (before[d] - 2.0 * here[d] + after[d]));
            largest = largest.max(second.map(|difference| difference * difference).sum::<f64>().sqrt());
        }
    }
    // h² f″ / 8 with f″ = difference / (L / steps)² and h = L / (n − 1).
    largest * (steps * steps) as f64 / 8.0
}
