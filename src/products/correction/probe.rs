//! What is known of a correction before its table: how it bends along each axis, and what terms in the force it needs.

use super::{CorrectionQuestion, CorrectionTable, Corrector, ForceTerms, bound::worst_at_nodes, cases::axis_forces};
use crate::{
    input::error::Result,
    machine::Motion,
    simulation::Machines,
    spatial::Grid,
    work::{Event, Stage, Work},
};

/// Nodes along each axis that are looked at.
const NODES: usize = 5;
/// Terms are enough if they leave at most this share of the tolerance at the nodes.
const ENOUGH: f64 = 0.5;

/// What the probe found.
pub(super) struct Probe {
    /// Terms in the force.
    pub terms: ForceTerms,
    /// What they leave at nodes, mm.
    pub at_nodes_mm: f64,
    /// An interpolation between n nodes along an axis errs by about this over `(n − 1)²`, mm.
    pub bends_mm: [f64; 3],
}

/// Looks at a coarse grid over the box of `question`.
///
/// # Errors
/// A node without correction. Of `work`.
pub(super) fn probe(question: &CorrectionQuestion, machines: &Machines, work: &Work) -> Result<Probe> {
    let mut counts = [1; 3];
    question.axes().for_each(|axis| counts[axis] = NODES);
    work.tell(Event::Stage(Stage { of: "nodes", items: counts.iter().product() }));
    let most = if question.largest_force_N > 0.0 { ForceTerms::Quadratic } else { ForceTerms::Constant };
    let table = CorrectionTable::new(question, machines, counts, most, work)?;
    let mut ends = [1; 3];
    question.axes().for_each(|axis| ends[axis] = 3);
    let [min, max] = question.corners;
    let nodes = Grid::new(min, max, ends);
    let left = |table: &CorrectionTable| worst_at_nodes(question, machines, &Corrector::Table(table), &nodes, work);
    let linear = table.without_quadratic_terms();
    let linear_left = left(&linear)?;
    let (terms, at_nodes_mm) = match linear_left <= ENOUGH * question.tolerance_mm {
        true => (linear.terms, linear_left),
        false => (most, left(&table)?),
    };
    Ok(Probe { terms, at_nodes_mm, bends_mm: [0, 1, 2].map(|axis| bend(question, &table, axis)) })
}

/// Largest second difference along an axis as an error of interpolation, hinges at the machine's reach.
fn bend(question: &CorrectionQuestion, table: &CorrectionTable, axis: usize) -> f64 {
    let (grid, machine) = (&table.grid, &question.machine);
    let steps = grid.axes[axis].len() - 1;
    let stride = grid.index([0, 1, 2].map(|other| usize::from(other == axis && steps > 0)));
    let weights = machine.drives().map(|(_, drive)| if drive.motion == Motion::Revolute { machine.reach } else { 1.0 });
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
