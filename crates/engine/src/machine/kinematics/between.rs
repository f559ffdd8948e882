//! Whether it is plain, in lanes, that no singularity lies between two near configurations.
//!
//! With J and J' the linearised problem at both, its determinant has the same sign at both where that of `JᵀJ'` is positive: where
//! elimination finds positive pivots only. Passive joints are eliminated chain by chain, as [`super::normal_step`] does.

use super::{
    equations::task_entry,
    normal_step::{Place, TWIST, places},
};
use crate::{
    lanes::{Frame, Real, clear, copy, dot, pairs, subtract},
    machine::Machine,
};

/// A pivot below this share of the largest diagonal entry is not plainly positive.
const PLAIN: f64 = 1e-12;

/// Storage from question to question.
#[derive(Debug, Clone)]
pub(super) struct Between<R> {
    /// Of each chain: its passive joints, twist of P, its drives.
    chains: Vec<Square<R>>,
    /// Of all: twist of P, drives.
    left: Square<R>,
    commanded: Square<R>,
    least: R,
}

/// The linearised problem at both ends of a way.
#[derive(Clone, Copy)]
pub(super) struct Ends<'a, R> {
    /// Jacobians by columns.
    pub jacobians: [&'a [R]; 2],
    /// Their rows.
    pub rows: usize,
    pub platforms: [&'a Frame<R>; 2],
}

/// A square matrix by rows.
#[derive(Debug, Clone)]
struct Square<R> {
    size: usize,
    entries: Vec<R>,
}

impl<R: Real> Square<R> {
    fn new(size: usize) -> Self {
        Self { size, entries: vec![R::zero(); size * size] }
    }

    #[inline(always)]
    fn at(&mut self, i: usize, j: usize) -> &mut R {
        &mut self.entries[i * self.size + j]
    }

    /// Eliminates the first `count` unknowns; the lanes in which all pivots are greater than `least`.
    #[inline(always)]
    fn eliminate(&mut self, count: usize, least: R) -> u8 {
        let (size, mut good) = (self.size, R::ALL);
        for k in 0..count {
            let (above, below) = self.entries.split_at_mut((k + 1) * size);
            let pivot_row = &above[k * size + k..];
            good &= R::bits(pivot_row[0].greater(least));
            let inverse = R::splat(1.0) / pivot_row[0];
            for row in below.chunks_exact_mut(size) {
                let factor = row[k] * inverse;
                subtract(&mut row[k + 1..], factor, &pivot_row[1..]);
            }
        }
        good
    }
}

impl<R: Real> Between<R> {
    pub fn new(machine: &Machine) -> Self {
        let others = TWIST + machine.drive_count();
        Self {
            chains: places(machine).map(|place| Square::new(place.size() - 1)).collect(),
            left: Square::new(others),
            commanded: Square::new(others),
            least: R::zero(),
        }
    }

    /// The lanes in which plainly no singularity is between `ends`, as far as is asked for: with the drives commanded, with the task
    /// commanded.
    #[inline(always)]
    pub fn is_plain(&mut self, machine: &Machine, ends: &Ends<'_, R>, by_drives: bool, by_task: bool) -> u8 {
        let mut good = self.take_closures(machine, ends);
        if by_drives {
            copy(&mut self.commanded.entries, &self.left.entries);
            for drive in TWIST..self.left.size {
                *self.commanded.at(drive, drive) += R::splat(1.0);
            }
            good &= self.commanded.eliminate(self.left.size, self.least);
        }
        if by_task {
            copy(&mut self.commanded.entries, &self.left.entries);
            for coordinate in &machine.controls {
                for i in 0..TWIST {
                    let from = task_entry(*coordinate, ends.platforms[0], i);
                    for j in 0..TWIST {
                        *self.commanded.at(i, j) += from * task_entry(*coordinate, ends.platforms[1], j);
                    }
                }
            }
            good &= self.commanded.eliminate(self.left.size, self.least);
        }
        good
    }

    /// Eliminates the passive joints.
    #[inline(always)]
    fn take_closures(&mut self, machine: &Machine, ends: &Ends<'_, R>) -> u8 {
        let [from, to] = ends.jacobians;
        // What commands add is 1 at most.
        let mut largest = R::splat(1.0);
        for (place, square) in pairs(places(machine), &mut self.chains) {
            for i in 0..square.size {
                for j in 0..square.size {
                    *square.at(i, j) = dot(own(from, ends.rows, &place, i), own(to, ends.rows, &place, j));
                }
                largest = largest.larger(*square.at(i, i));
            }
        }
        self.least = R::splat(PLAIN) * largest;
        clear(&mut self.left.entries);
        let mut good = R::ALL;
        for (place, square) in pairs(places(machine), &mut self.chains) {
            good &= square.eliminate(place.joints, self.least);
            for i in place.joints..square.size {
                for j in place.joints..square.size {
                    let (row, column) = (place.column(i), place.column(j));
                    *self.left.at(row, column) += *square.at(i, j);
                }
            }
        }
        good
    }
}

/// Rows of a chain in the column of its unknown `i`.
#[inline(always)]
fn own<'a, R>(jacobian: &'a [R], rows: usize, place: &Place, i: usize) -> &'a [R] {
    &jacobian[place.column(i) * rows..][place.rows.clone()]
}
