//! The damped least-squares step of the closure equations.
//!
//! Passive joints move the rows of their own chain alone. So the normal equations of a chain's rows are formed over its passive
//! joints, the twist of P, its drives and the right-hand side, and its joints eliminated; what is left of all chains, and of the
//! rows of what is commanded, has as many unknowns as P and the drives have coordinates.

use crate::{
    lanes::{Real, copy, dot, pairs, subtract},
    machine::Machine,
};

/// Coordinates of the twist of P.
pub(super) const TWIST: usize = 6;

/// Solver of the step, with its storage: normal equations as lower triangles, whose last row is the right-hand side.
#[derive(Debug, Clone)]
pub(super) struct NormalStep<R> {
    /// Normal equations of each chain: its passive joints, twist of P, its drives.
    chains: Vec<NormalMatrix<R>>,
    /// Sum of these without passive joints: twist of P, drives.
    reduced: NormalMatrix<R>,
    /// Diagonal over twist of P and drives before anything is eliminated.
    diagonal: Vec<R>,
    solution: Vec<R>,
    /// The step: all unknowns of the closure equations.
    step: Vec<R>,
}

/// A square matrix by columns.
#[derive(Debug, Clone)]
struct NormalMatrix<R> {
    size: usize,
    entries: Vec<R>,
}

/// Rows and unknowns of a chain in the closure equations.
pub(super) struct ChainBlock {
    pub rows: std::ops::Range<usize>,
    joint: usize,
    pub joints: usize,
    drive: usize,
    drives: usize,
}

impl ChainBlock {
    /// Number of the chain's unknowns and its right-hand side.
    pub fn size(&self) -> usize {
        self.joints + TWIST + self.drives + 1
    }

    /// Column in the closure equations of the chain's unknown `i`.
    pub fn column(&self, i: usize) -> usize {
        match i.checked_sub(self.joints) {
            None => self.joint + i,
            Some(other) => self.reduced_column(other),
        }
    }

    /// Column of unknown `i` among those that stay when the chain's joints are eliminated: twist of P, then its drives.
    fn reduced_column(&self, i: usize) -> usize {
        i.checked_sub(TWIST).map_or(i, |drive| self.drive + drive)
    }
}

/// Blocks of the chains of `machine`, in order.
pub(super) fn chain_blocks(machine: &Machine) -> impl Iterator<Item = ChainBlock> {
    let (mut row, mut joint, mut drive) = (0, TWIST + machine.drive_count(), TWIST);
    machine.chains.iter().map(move |chain| {
        let (joints, drives) = (chain.passive.len(), chain.drives.len());
        let end = row + 6 * (1 + chain.route.loop_count());
        let block = ChainBlock { rows: row..end, joint, joints, drive, drives };
        (row, joint, drive) = (end, joint + joints, drive + drives);
        block
    })
}

impl<R: Real> NormalMatrix<R> {
    fn new(size: usize) -> Self {
        Self { size, entries: vec![R::zero(); size * size] }
    }

    #[inline(always)]
    fn at(&self, i: usize, j: usize) -> R {
        self.entries[j * self.size + i]
    }

    /// Column `j`, from its first row on.
    #[inline(always)]
    fn column(&self, j: usize) -> &[R] {
        &self.entries[j * self.size..(j + 1) * self.size]
    }
}

impl<R: Real> NormalStep<R> {
    pub fn new(machine: &Machine) -> Self {
        let others = TWIST + machine.drive_count();
        Self {
            chains: chain_blocks(machine).map(|block| NormalMatrix::new(block.size())).collect(),
            reduced: NormalMatrix::new(others + 1),
            diagonal: vec![R::zero(); others],
            solution: Vec::new(),
            step: Vec::new(),
        }
    }

    /// Returns the `x` with least `|J x + residual|² + damping · d |x|²`, d the largest diagonal entry of `JᵀJ`, and the lanes in which the
    /// equations say enough. `jacobian`: J by columns; its rows from `closures` on are those of what is commanded.
    #[inline(always)]
    pub fn solve(
        &mut self,
        machine: &Machine,
        jacobian: &[R],
        residual: &[R],
        closures: usize,
        damping: R,
    ) -> (&[R], u8) {
        let (others, rows) = (TWIST + machine.drive_count(), residual.len());
        let right = jacobian.len() / rows;
        let column = |index: usize| if index < right { &jacobian[index * rows..(index + 1) * rows] } else { residual };
        form_products(
            &mut self.reduced,
            #[inline(always)]
            |i: usize| &column(if i < others { i } else { right })[closures..],
        );
        for i in 0..others {
            self.diagonal[i] = self.reduced.at(i, i);
        }
        let mut largest = R::zero();
        for (block, normal) in pairs(chain_blocks(machine), &mut self.chains) {
            let last = block.size() - 1;
            form_products(
                normal,
                #[inline(always)]
                |i: usize| &column(if i < last { block.column(i) } else { right })[block.rows.clone()],
            );
            for i in 0..block.joints {
                largest = largest.larger(normal.at(i, i));
            }
            for i in block.joints..last {
                self.diagonal[block.column(i)] += normal.at(i, i);
            }
        }
        for &entry in &self.diagonal {
            largest = largest.larger(entry);
        }
        let level = damping * largest;
        let mut good = R::ALL;
        for (block, normal) in pairs(chain_blocks(machine), &mut self.chains) {
            good &= eliminate(normal, block.joints, level);
            let (joints, rest) = (block.joints, block.size() - block.joints);
            let target = |i: usize| if i + 1 < rest { block.reduced_column(i) } else { others };
            for j in 0..rest {
                for i in j..rest {
                    self.reduced.entries[target(j) * (others + 1) + target(i)] += normal.at(joints + i, joints + j);
                }
            }
        }
        good &= eliminate(&mut self.reduced, others, level);
        self.step.resize(right, R::zero());
        self.solution.resize(self.reduced.size.max(right), R::zero());
        back_substitute(&self.reduced, others, &mut self.solution);
        copy(&mut self.step, &self.solution[..others]);
        for (block, normal) in pairs(chain_blocks(machine), &self.chains) {
            for i in 0..TWIST + block.drives {
                self.solution[block.joints + i] = self.step[block.reduced_column(i)];
            }
            back_substitute(normal, block.joints, &mut self.solution);
            copy(&mut self.step[block.joint..], &self.solution[..block.joints]);
        }
        (&self.step, good)
    }
}

/// Fills the lower triangle of `normal` with the products of columns with one another.
#[inline(always)]
fn form_products<'a, R: Real>(normal: &mut NormalMatrix<R>, column: impl Fn(usize) -> &'a [R]) {
    let size = normal.size;
    for j in 0..size {
        let own = column(j);
        for i in j..size {
            normal.entries[j * size + i] = dot(own, column(i));
        }
    }
}

/// Eliminates the first `count` unknowns, `level` added to their diagonal: their columns become those of the Cholesky factor, the others what is
/// left. Returns the lanes in which that is possible; the others hold no numbers.
#[inline(always)]
fn eliminate<R: Real>(normal: &mut NormalMatrix<R>, count: usize, level: R) -> u8 {
    let size = normal.size;
    let mut good = R::ALL;
    for j in 0..size {
        let (earlier, column) = normal.entries.split_at_mut(j * size);
        let column = &mut column[j..size];
        if j < count {
            column[0] += level;
        }
        for k in 0..count.min(j) {
            let other = &earlier[k * size..(k + 1) * size];
            subtract(column, other[j], &other[j..]);
        }
        if j < count {
            good &= column[0].lanes_greater(0.0);
            let inverse = R::splat(1.0) / column[0].sqrt();
            for entry in column {
                *entry = *entry * inverse;
            }
        }
    }
    good
}

/// Computes the first `count` entries of `solution`, eliminated in `normal`, from those behind them.
#[inline(always)]
fn back_substitute<R: Real>(normal: &NormalMatrix<R>, count: usize, solution: &mut [R]) {
    let right = normal.size - 1;
    for j in (0..count).rev() {
        let column = normal.column(j);
        let rest = column[right] + dot(&column[j + 1..right], &solution[j + 1..right]);
        solution[j] = -rest / column[j];
    }
}
