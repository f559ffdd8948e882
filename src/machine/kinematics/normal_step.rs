//! The damped least-squares step of the closure equations.
//!
//! Passive joints move the rows of their own chain alone. So the normal equations of a chain's rows are formed over its passive
//! joints, the twist of P, its drives and the right-hand side, and its joints eliminated; what is left of all chains, and of the
//! rows of what is commanded, has as many unknowns as P and the drives have coordinates.

use nalgebra::{DMatrix, DVector};

use crate::{
    lanes::{dot, subtract},
    machine::Machine,
};

/// Coordinates of the twist of P.
const TWIST: usize = 6;

/// Storage from step to step: normal equations as lower triangles, whose last row is the right-hand side.
#[derive(Default)]
pub(super) struct NormalStep {
    /// Of each chain: its passive joints, twist of P, its drives.
    chains: Vec<DMatrix<f64>>,
    /// Of all: twist of P, drives.
    left: DMatrix<f64>,
    /// Diagonal over twist of P and drives before anything is eliminated.
    diagonal: Vec<f64>,
    unknowns: Vec<f64>,
}

/// Where the unknowns and rows of a chain are in the closure equations.
struct Place {
    rows: std::ops::Range<usize>,
    joint: usize,
    joints: usize,
    drive: usize,
    drives: usize,
}

impl Place {
    /// Of the unknowns of the chain and its right-hand side.
    fn size(&self) -> usize {
        self.joints + TWIST + self.drives + 1
    }

    /// Column in the closure equations of its unknown `i`.
    fn column(&self, i: usize) -> usize {
        match i.checked_sub(self.joints) {
            None => self.joint + i,
            Some(other) => self.other(other),
        }
    }

    /// Column of what its joints are eliminated for: twist of P and its drives.
    fn other(&self, i: usize) -> usize {
        i.checked_sub(TWIST).map_or(i, |drive| self.drive + drive)
    }
}

/// One per chain of `machine`, in order.
fn places(machine: &Machine) -> impl Iterator<Item = Place> {
    let (mut row, mut joint, mut drive) = (0, TWIST + machine.drive_count(), TWIST);
    machine.chains.iter().map(move |chain| {
        let (joints, drives) = (chain.passive.len(), chain.drives.len());
        let end = row + 6 * (1 + chain.route.loop_count());
        let place = Place { rows: row..end, joint, joints, drive, drives };
        (row, joint, drive) = (end, joint + joints, drive + drives);
        place
    })
}

impl NormalStep {
    /// The `x` with least `|J x + residual|² + damping · d |x|²`, d the largest diagonal entry of `JᵀJ`; the rows of J from
    /// `closures` on are those of what is commanded. `None` where the equations do not say enough.
    pub fn solve(
        &mut self,
        machine: &Machine,
        jacobian: &DMatrix<f64>,
        residual: &DVector<f64>,
        closures: usize,
        damping: f64,
    ) -> Option<DVector<f64>> {
        let others = TWIST + machine.drive_count();
        let column =
            |index: usize| if index < jacobian.ncols() { entries(jacobian, index) } else { residual.as_slice() };
        let right = jacobian.ncols();
        let commanded = |i: usize| &column(if i < others { i } else { right })[closures..];
        form(&mut self.left, others + 1, commanded);
        self.diagonal.clear();
        self.diagonal.extend((0..others).map(|i| self.left[(i, i)]));
        self.chains.resize_with(machine.chains.len(), Default::default);
        let mut largest: f64 = 0.0;
        for (place, normal) in places(machine).zip(&mut self.chains) {
            let last = place.size() - 1;
            form(normal, place.size(), |i| &column(if i < last { place.column(i) } else { right })[place.rows.clone()]);
            largest = (0..place.joints).fold(largest, |largest, i| largest.max(normal[(i, i)]));
            for i in place.joints..last {
                self.diagonal[place.column(i)] += normal[(i, i)];
            }
        }
        let level = damping * self.diagonal.iter().fold(largest, |largest, entry| largest.max(*entry));
        for (place, normal) in places(machine).zip(&mut self.chains) {
            if !eliminate(normal, place.joints, level) {
                return None;
            }
            let (joints, rest) = (place.joints, place.size() - place.joints);
            let target = |i: usize| if i + 1 < rest { place.other(i) } else { others };
            for j in 0..rest {
                for i in j..rest {
                    self.left[(target(i), target(j))] += normal[(joints + i, joints + j)];
                }
            }
        }
        if !eliminate(&mut self.left, others, level) {
            return None;
        }
        let mut step = DVector::zeros(right);
        step.rows_mut(0, others).copy_from_slice(substituted(&self.left, others, &[], &mut self.unknowns));
        for (place, normal) in places(machine).zip(&self.chains) {
            let known: Vec<f64> = (0..TWIST + place.drives).map(|i| step[place.other(i)]).collect();
            let found = substituted(normal, place.joints, &known, &mut self.unknowns);
            step.rows_mut(place.joint, place.joints).copy_from_slice(found);
        }
        Some(step)
    }
}

fn entries(matrix: &DMatrix<f64>, column: usize) -> &[f64] {
    let rows = matrix.nrows();
    &matrix.as_slice()[column * rows..(column + 1) * rows]
}

/// Products of `size` columns with one another.
fn form<'a>(normal: &mut DMatrix<f64>, size: usize, column: impl Fn(usize) -> &'a [f64]) {
    if normal.nrows() != size {
        *normal = DMatrix::zeros(size, size);
    }
    for (j, products) in normal.as_mut_slice().chunks_exact_mut(size).enumerate() {
        let own = column(j);
        for (i, product) in products.iter_mut().enumerate().skip(j) {
            *product = dot(own, column(i));
        }
    }
}

/// Eliminates the first `count` unknowns, `level` added to their diagonal: their columns become those of the Cholesky factor, the
/// others what is left. Whether that was possible.
fn eliminate(normal: &mut DMatrix<f64>, count: usize, level: f64) -> bool {
    let size = normal.nrows();
    for j in 0..size {
        let (earlier, column) = normal.as_mut_slice().split_at_mut(j * size);
        let column = &mut column[j..size];
        if j < count {
            column[0] += level;
        }
        for other in earlier.chunks_exact(size).take(count) {
            subtract(column, other[j], &other[j..]);
        }
        if j < count {
            if column[0].is_nan() || column[0] <= 0.0 {
                return false;
            }
            let inverse = 1.0 / column[0].sqrt();
            column.iter_mut().for_each(|entry| *entry *= inverse);
        }
    }
    true
}

/// The first `count` unknowns, eliminated in `normal`, where those behind them are `known`.
fn substituted<'u>(normal: &DMatrix<f64>, count: usize, known: &[f64], unknowns: &'u mut Vec<f64>) -> &'u [f64] {
    let right = normal.nrows() - 1;
    unknowns.clear();
    unknowns.resize(count, 0.0);
    unknowns.extend_from_slice(known);
    for j in (0..count).rev() {
        let column = entries(normal, j);
        let rest = column[right] + dot(&column[j + 1..right], &unknowns[j + 1..]);
        unknowns[j] = -rest / column[j];
    }
    &unknowns[..count]
}
