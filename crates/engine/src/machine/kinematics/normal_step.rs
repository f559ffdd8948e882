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

/// Storage from step to step: normal equations as lower triangles, whose last row is the right-hand side.
#[derive(Debug, Clone)]
pub(super) struct NormalStep<R> {
    /// Of each chain: its passive joints, twist of P, its drives.
    chains: Vec<Normal<R>>,
    /// Of all: twist of P, drives.
    left: Normal<R>,
    /// Diagonal over twist of P and drives before anything is eliminated.
    diagonal: Vec<R>,
    known: Vec<R>,
    /// The step: all unknowns of the closure equations.
    step: Vec<R>,
}

/// A square matrix by columns.
#[derive(Debug, Clone)]
struct Normal<R> {
    size: usize,
    entries: Vec<R>,
}

/// Where the unknowns and rows of a chain are in the closure equations.
pub(super) struct Place {
    pub rows: std::ops::Range<usize>,
    joint: usize,
    pub joints: usize,
    drive: usize,
    drives: usize,
}

impl Place {
    /// Of the unknowns of the chain and its right-hand side.
    pub fn size(&self) -> usize {
        self.joints + TWIST + self.drives + 1
    }

    /// Column in the closure equations of its unknown `i`.
    pub fn column(&self, i: usize) -> usize {
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
pub(super) fn places(machine: &Machine) -> impl Iterator<Item = Place> {
    let (mut row, mut joint, mut drive) = (0, TWIST + machine.drive_count(), TWIST);
    machine.chains.iter().map(move |chain| {
        let (joints, drives) = (chain.passive.len(), chain.drives.len());
        let end = row + 6 * (1 + chain.route.loop_count());
        let place = Place { rows: row..end, joint, joints, drive, drives };
        (row, joint, drive) = (end, joint + joints, drive + drives);
        place
    })
}

impl<R: Real> Normal<R> {
    fn new(size: usize) -> Self {
        Self { size, entries: vec![R::zero(); size * size] }
    }

    #[inline(always)]
    fn at(&self, i: usize, j: usize) -> R {
        self.entries[j * self.size + i]
    }

    /// Column `j`.
    #[inline(always)]
    fn column(&self, j: usize) -> &[R] {
        &self.entries[j * self.size..(j + 1) * self.size]
    }
}

impl<R: Real> NormalStep<R> {
    pub fn new(machine: &Machine) -> Self {
        let others = TWIST + machine.drive_count();
        Self {
            chains: places(machine).map(|place| Normal::new(place.size())).collect(),
            left: Normal::new(others + 1),
            diagonal: vec![R::zero(); others],
            known: Vec::new(),
            step: Vec::new(),
        }
    }

    /// The `x` with least `|J x + residual|² + damping · d |x|²`, d the largest diagonal entry of `JᵀJ`, in the lanes in which the
    /// equations say enough. `jacobian`: J by columns, as many as `step` gets entries; its rows from `closures` on are those of what
    /// is commanded.
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
        form(
            &mut self.left,
            #[inline(always)]
            |i: usize| &column(if i < others { i } else { right })[closures..],
        );
        for i in 0..others {
            self.diagonal[i] = self.left.at(i, i);
        }
        let mut largest = R::zero();
        for (place, normal) in pairs(places(machine), &mut self.chains) {
            let last = place.size() - 1;
            form(
                normal,
                #[inline(always)]
                |i: usize| &column(if i < last { place.column(i) } else { right })[place.rows.clone()],
            );
            for i in 0..place.joints {
                largest = largest.larger(normal.at(i, i));
            }
            for i in place.joints..last {
                self.diagonal[place.column(i)] += normal.at(i, i);
            }
        }
        for &entry in &self.diagonal {
            largest = largest.larger(entry);
        }
        let level = damping * largest;
        let mut good = R::ALL;
        for (place, normal) in pairs(places(machine), &mut self.chains) {
            good &= eliminate(normal, place.joints, level);
            let (joints, rest) = (place.joints, place.size() - place.joints);
            let target = |i: usize| if i + 1 < rest { place.other(i) } else { others };
            for j in 0..rest {
                for i in j..rest {
                    self.left.entries[target(j) * (others + 1) + target(i)] += normal.at(joints + i, joints + j);
                }
            }
        }
        good &= eliminate(&mut self.left, others, level);
        self.step.resize(right, R::zero());
        self.known.resize(self.left.size.max(right), R::zero());
        substitute(&self.left, others, &mut self.known);
        copy(&mut self.step, &self.known[..others]);
        for (place, normal) in pairs(places(machine), &self.chains) {
            for i in 0..TWIST + place.drives {
                self.known[place.joints + i] = self.step[place.other(i)];
            }
            substitute(normal, place.joints, &mut self.known);
            copy(&mut self.step[place.joint..], &self.known[..place.joints]);
        }
        (&self.step, good)
    }
}

/// Products of columns with one another.
#[inline(always)]
fn form<'a, R: Real>(normal: &mut Normal<R>, column: impl Fn(usize) -> &'a [R]) {
    let size = normal.size;
    for j in 0..size {
        let own = column(j);
        for i in j..size {
            normal.entries[j * size + i] = dot(own, column(i));
        }
    }
}

/// Eliminates the first `count` unknowns, `level` added to their diagonal: their columns become those of the Cholesky factor, the
/// others what is left. The lanes in which that is possible; the others hold no numbers.
#[inline(always)]
fn eliminate<R: Real>(normal: &mut Normal<R>, count: usize, level: R) -> u8 {
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

/// Puts the first `count` unknowns, eliminated in `normal`, before those that are `known` behind them.
#[inline(always)]
fn substitute<R: Real>(normal: &Normal<R>, count: usize, known: &mut [R]) {
    let right = normal.size - 1;
    for j in (0..count).rev() {
        let column = normal.column(j);
        let rest = column[right] + dot(&column[j + 1..right], &known[j + 1..right]);
        known[j] = -rest / column[j];
    }
}
