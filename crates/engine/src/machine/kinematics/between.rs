//! A quick test, in lanes, that no singularity lies between two near configurations.
//!
//! With J and J' the linearised problem at both, its determinant has the same sign at both where that of `JᵀJ'` is positive: where
//! elimination finds positive pivots only. Passive joints are eliminated chain by chain, as [`super::normal_step`] does.

use super::{
    equations::task_entry,
    normal_step::{ChainBlock, TWIST, chain_blocks},
};
use crate::{
    lanes::{Frame, Real, clear, copy, dot, pairs, subtract},
    machine::Machine,
};

/// A pivot below this share of the largest diagonal entry is not plainly positive.
const PLAIN: f64 = 1e-12;

/// The test that no singularity lies between two configurations, with its storage.
#[derive(Debug, Clone)]
pub(super) struct SingularityCheck<R> {
    /// Product of both Jacobians for each chain: its passive joints, twist of P, its drives.
    chains: Vec<SquareMatrix<R>>,
    /// Sum of these without passive joints: twist of P, drives.
    reduced: SquareMatrix<R>,
    with_command: SquareMatrix<R>,
    least: R,
}

/// The linearised problem at both configurations.
#[derive(Clone, Copy)]
pub(super) struct StepEnds<'a, R> {
    /// Jacobians by columns.
    pub jacobians: [&'a [R]; 2],
    /// Number of their rows.
    pub rows: usize,
    pub platforms: [&'a Frame<R>; 2],
}

/// A square matrix by rows.
#[derive(Debug, Clone)]
struct SquareMatrix<R> {
    size: usize,
    entries: Vec<R>,
}

impl<R: Real> SquareMatrix<R> {
    /// A zero matrix.
    fn new(size: usize) -> Self {
        Self { size, entries: vec![R::zero(); size * size] }
    }

    /// Entry in row `i` and column `j`.
    #[inline(always)]
    fn at(&mut self, i: usize, j: usize) -> &mut R {
        &mut self.entries[i * self.size + j]
    }

    /// Eliminates the first `count` unknowns; returns the lanes in which all pivots are greater than `least`.
    #[inline(always)]
    fn eliminate(&mut self, count: usize, least: R) -> u8 {
        let (size, mut good) = (self.size, R::ALL);
        for k in 0..count {
            let (above, below) = self.entries.split_at_mut((k + 1) * size);
            let pivot_row = &above[k * size + k..];
            good &= R::mask_to_bits(pivot_row[0].greater(least));
            let inverse = R::splat(1.0) / pivot_row[0];
            for row in below.chunks_exact_mut(size) {
                let factor = row[k] * inverse;
                subtract(&mut row[k + 1..], factor, &pivot_row[1..]);
            }
        }
        good
    }
}

impl<R: Real> SingularityCheck<R> {
    /// Storage for checks of `machine`.
    pub fn new(machine: &Machine) -> Self {
        let others = TWIST + machine.drive_count();
        Self {
            chains: chain_blocks(machine).map(|block| SquareMatrix::new(block.size() - 1)).collect(),
            reduced: SquareMatrix::new(others),
            with_command: SquareMatrix::new(others),
            least: R::zero(),
        }
    }

    /// Lanes in which surely no singularity lies between `ends`: with the drives commanded if `by_drives`, and with the task if `by_task`.
    #[inline(always)]
    pub fn regular_lanes(&mut self, machine: &Machine, ends: &StepEnds<'_, R>, by_drives: bool, by_task: bool) -> u8 {
        let mut good = self.eliminate_joints(machine, ends);
        if by_drives {
            copy(&mut self.with_command.entries, &self.reduced.entries);
            for drive in TWIST..self.reduced.size {
                *self.with_command.at(drive, drive) += R::splat(1.0);
            }
            good &= self.with_command.eliminate(self.reduced.size, self.least);
        }
        if by_task {
            copy(&mut self.with_command.entries, &self.reduced.entries);
            for coordinate in &machine.controls {
                for i in 0..TWIST {
                    let from = task_entry(*coordinate, ends.platforms[0], i);
                    for j in 0..TWIST {
                        *self.with_command.at(i, j) += from * task_entry(*coordinate, ends.platforms[1], j);
                    }
                }
            }
            good &= self.with_command.eliminate(self.reduced.size, self.least);
        }
        good
    }

    /// Multiplies both Jacobians and eliminates the passive joints; returns the lanes in which all pivots are positive.
    #[inline(always)]
    fn eliminate_joints(&mut self, machine: &Machine, ends: &StepEnds<'_, R>) -> u8 {
        let [from, to] = ends.jacobians;
        // What commands add is 1 at most.
        let mut largest = R::splat(1.0);
        for (block, square) in pairs(chain_blocks(machine), &mut self.chains) {
            for i in 0..square.size {
                for j in 0..square.size {
                    *square.at(i, j) = dot(chain_col(from, ends.rows, &block, i), chain_col(to, ends.rows, &block, j));
                }
                largest = largest.larger(*square.at(i, i));
            }
        }
        self.least = R::splat(PLAIN) * largest;
        clear(&mut self.reduced.entries);
        let mut good = R::ALL;
        for (block, square) in pairs(chain_blocks(machine), &mut self.chains) {
            good &= square.eliminate(block.joints, self.least);
            for i in block.joints..square.size {
                for j in block.joints..square.size {
                    let (row, column) = (block.column(i), block.column(j));
                    *self.reduced.at(row, column) += *square.at(i, j);
                }
            }
        }
        good
    }
}

/// Rows of a chain in the column of its unknown `i`.
#[inline(always)]
fn chain_col<'a, R>(jacobian: &'a [R], rows: usize, block: &ChainBlock, i: usize) -> &'a [R] {
    &jacobian[block.column(i) * rows..][block.rows.clone()]
}
