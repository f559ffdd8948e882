//! The damped least-squares step of the closure equations.
//!
//! Passive joints move the rows of their own chain alone. So the normal equations of a chain's rows are formed over its passive
//! joints, the twist of P, its drives and the right-hand side, and its joints eliminated; what is left of all chains, and of the
//! rows of what is commanded, has as many unknowns as P and the drives have coordinates. Several right-hand sides share the work.

use crate::{
    lanes::{Real, copy, dot, pairs, subtract},
    machine::Machine,
};

/// Coordinates of the twist of P.
pub(super) const TWIST: usize = 6;

/// Storage from step to step: normal equations as lower triangles, whose last rows are the right-hand sides.
#[derive(Debug, Clone)]
pub(super) struct NormalStep<R> {
    /// Right-hand sides.
    rights: usize,
    /// Of each chain: its passive joints, twist of P, its drives.
    chains: Vec<NormalMatrix<R>>,
    /// Of all: twist of P, drives.
    reduced: NormalMatrix<R>,
    /// Diagonal over twist of P and drives before anything is eliminated.
    diagonal: Vec<R>,
    solution: Vec<R>,
    /// The steps: all unknowns of the closure equations, for each right-hand side.
    pub(super) steps: Vec<R>,
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
    /// Number of the chain's unknowns and one right-hand side.
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
    /// A zero matrix.
    fn new(size: usize) -> Self {
        Self { size, entries: vec![R::zero(); size * size] }
    }

    /// Entry in row `i` and column `j`.
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
    /// Storage for steps of `machine` with `rights` right-hand sides at a time.
    pub fn new(machine: &Machine, rights: usize) -> Self {
        let others = TWIST + machine.drive_count();
        Self {
            rights,
            chains: chain_blocks(machine).map(|block| NormalMatrix::new(block.size() - 1 + rights)).collect(),
            reduced: NormalMatrix::new(others + rights),
            diagonal: vec![R::zero(); others],
            solution: Vec::new(),
            steps: Vec::new(),
        }
    }

    /// The `x` with least `|J x + residual|² + damping · d |x|²`, d the largest diagonal entry of `JᵀJ`, one behind the other for each of
    /// the `residuals`, in the lanes in which the equations say enough. `jacobian`: J by columns, one per unknown; its rows from
    /// `closures` on are those of what is commanded.
    #[inline(always)]
    pub fn solve(
        &mut self,
        machine: &Machine,
        jacobian: &[R],
        residuals: &[R],
        closures: usize,
        damping: R,
    ) -> (&[R], u8) {
        let (others, rows) = (TWIST + machine.drive_count(), residuals.len() / self.rights);
        let unknowns = jacobian.len() / rows;
        let column = |index: usize| match index.checked_sub(unknowns) {
            None => &jacobian[index * rows..(index + 1) * rows],
            Some(right) => &residuals[right * rows..(right + 1) * rows],
        };
        form_products(
            &mut self.reduced,
            #[inline(always)]
            |i: usize| &column(if i < others { i } else { unknowns + i - others })[closures..],
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
                |i: usize| &column(if i < last { block.column(i) } else { unknowns + i - last })[block.rows.clone()],
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
            let (joints, kept) = (block.joints, TWIST + block.drives);
            let target = |i: usize| if i < kept { block.reduced_column(i) } else { others + i - kept };
            for j in 0..kept + self.rights {
                for i in j..kept + self.rights {
                    let entry = target(j) * self.reduced.size + target(i);
                    self.reduced.entries[entry] += normal.at(joints + i, joints + j);
                }
            }
        }
        good &= eliminate(&mut self.reduced, others, level);
        self.steps.resize(self.rights * unknowns, R::zero());
        self.solution.resize(self.reduced.size.max(unknowns), R::zero());
        for (right, step) in self.steps.chunks_exact_mut(unknowns).enumerate() {
            back_substitute(&self.reduced, others, others, right, &mut self.solution);
            copy(step, &self.solution[..others]);
            for (block, normal) in pairs(chain_blocks(machine), &self.chains) {
                for i in 0..TWIST + block.drives {
                    self.solution[block.joints + i] = step[block.reduced_column(i)];
                }
                back_substitute(normal, block.joints, block.size() - 1, right, &mut self.solution);
                copy(&mut step[block.joint..], &self.solution[..block.joints]);
            }
        }
        (&self.steps, good)
    }
}

/// Fills the lower triangle of `normal` with the products of columns with one another.
#[inline(always)]
fn form_products<'a, R: Real>(normal: &mut NormalMatrix<R>, column: impl Fn(usize) -> &'a [R]) {
    let size = normal.size;
    for j in 0..size {
        let column_j = column(j);
        for i in j..size {
            normal.entries[j * size + i] = dot(column_j, column(i));
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

/// Solves for the `count` unknowns eliminated in `normal`; `solution` has the others, up to `unknowns`. `right`: index of right-hand side.
#[inline(always)]
fn back_substitute<R: Real>(normal: &NormalMatrix<R>, count: usize, unknowns: usize, right: usize, solution: &mut [R]) {
    for j in (0..count).rev() {
        let column = normal.column(j);
        let rest = column[unknowns + right] + dot(&column[j + 1..unknowns], &solution[j + 1..unknowns]);
        solution[j] = -rest / column[j];
    }
}
