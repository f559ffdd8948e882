//! Elimination of the leading unknowns of a symmetric bordered matrix.

use crate::lanes::{Real, clear, dot, subtract};

/// A symmetric matrix, stored as its upper triangle, row by row.
#[derive(Debug, Clone)]
pub(super) struct Bordered<R> {
    size: usize,
    upper: Vec<R>,
    /// Smallest pivots that the elimination under way accepts, by the diagonal before it.
    least_pivots: Vec<R>,
}

/// A pivot below this fraction of its diagonal entry before its stage is zero.
const PIVOT_TOLERANCE: f64 = 1e-11;

impl<R: Real> Bordered<R> {
    /// A zero matrix of `size` rows.
    pub fn new(size: usize) -> Self {
        Self { size, upper: vec![R::zero(); size * (size + 1) / 2], least_pivots: Vec::with_capacity(size) }
    }

    /// Makes all entries zero.
    #[inline(always)]
    pub fn clear(&mut self) {
        clear(&mut self.upper);
    }

    /// Number of rows.
    #[inline(always)]
    pub fn size(&self) -> usize {
        self.size
    }

    /// Index of entry (row, 0) in the storage, which only serves to find those right of the diagonal.
    #[inline(always)]
    fn row_start(&self, row: usize) -> usize {
        row * self.size - row * (row + 1) / 2
    }

    /// Entry (row, column), row ≤ column.
    #[inline(always)]
    pub fn get(&self, row: usize, column: usize) -> R {
        debug_assert!(row <= column);
        self.upper[self.row_start(row) + column]
    }

    /// Mutable entry (row, column), row ≤ column.
    #[inline(always)]
    pub fn at(&mut self, row: usize, column: usize) -> &mut R {
        debug_assert!(row <= column);
        let start = self.row_start(row);
        &mut self.upper[start + column]
    }

    /// Eliminates `rows`, whose pivots must have the sign `sign` and exceed `least` in size. Returns the lanes in which they do; the others hold
    /// no numbers. From column `end` on these rows must be zero; they are not touched there. Row `k` is left as `d_k · (1, l_k+1, …)` with
    /// `−1/d_k` in place of the first `d_k`, so that [`Bordered::back_substitute`] can use it; what remains below is the Schur complement.
    #[inline(always)]
    pub fn eliminate(&mut self, rows: std::ops::Range<usize>, end: usize, sign: f64, least: f64) -> u8 {
        self.least_pivots.clear();
        for row in rows.clone() {
            let diagonal = self.get(row, row).abs();
            self.least_pivots.push(R::splat(PIVOT_TOLERANCE) * diagonal + R::splat(least));
        }
        let mut good = R::ALL;
        // Two pivot rows at a time, so that what is below is read and written half as often.
        for (pair, row) in rows.clone().step_by(2).enumerate() {
            let size = self.size - row;
            let first = self.row_start(row) + row;
            let (upper, below) = self.upper[first..].split_at_mut(size);
            let a = invert_pivot(upper, sign, self.least_pivots[2 * pair], &mut good);
            let a_row = &upper[1..end - row];
            if row + 1 == rows.end {
                subtract_pivot_rows(below, size - 1, [(a, a_row), (a, &[])]);
                break;
            }
            let (lower, below) = below.split_at_mut(size - 1);
            subtract(lower, a_row[0] * a, a_row);
            let b = invert_pivot(lower, sign, self.least_pivots[2 * pair + 1], &mut good);
            if good == 0 {
                break;
            }
            subtract_pivot_rows(below, size - 2, [(a, &a_row[1..]), (b, &lower[1..end - row - 1])]);
        }
        good
    }

    /// Eliminates one row by its positive pivot; the unknown stays where the pivot is within ±`idle`. Returns the lanes where either is so.
    #[inline(always)]
    pub fn eliminate_or_leave(&mut self, row: usize, idle: R) -> u8 {
        let size = self.size - row;
        let first = self.row_start(row) + row;
        let (upper, below) = self.upper[first..].split_at_mut(size);
        let is_stiff = upper[0].greater(idle);
        let is_negative = (-upper[0]).greater(idle);
        let inverse = R::select(is_stiff, R::splat(1.0) / upper[0], R::zero());
        let good = R::ALL & !R::mask_to_bits(is_negative) & !R::mask_to_bits(upper[0].is_nan());
        upper[0] = -inverse;
        subtract_pivot_rows(below, size - 1, [(inverse, &upper[1..]), (inverse, &[])]);
        good
    }

    /// Solves the eliminated rows `0..rows` for the leading entries of `z`, its later ones known: `Σ_j U_kj z_j = 0` in each row.
    #[inline(always)]
    pub fn back_substitute(&self, rows: usize, z: &mut [R]) {
        for row in (0..rows).rev() {
            let start = self.row_start(row);
            let (coefficients, known) = (&self.upper[start + row + 1..start + self.size], &z[row + 1..]);
            z[row] = dot(coefficients, known) * self.upper[start + row];
        }
    }
}

/// Replaces the leading entry of `row` by `−1/pivot` and returns `1/pivot`; clears lanes of `good` where `sign` · pivot is not above `least`.
#[inline(always)]
fn invert_pivot<R: Real>(row: &mut [R], sign: f64, least: R, good: &mut u8) -> R {
    *good &= R::mask_to_bits((row[0] * R::splat(sign)).greater(least));
    let inverse = R::splat(1.0) / row[0];
    row[0] = -inverse;
    inverse
}

/// Subtracts two pivot rows, each given by its inverse pivot and its entries behind the pivots, from the rows of the
/// triangle `below`, the first of which has `length` entries. The second may be empty.
#[inline(always)]
fn subtract_pivot_rows<R: Real>(below: &mut [R], mut length: usize, [(a, mut a_row), (b, mut b_row)]: [(R, &[R]); 2]) {
    let mut below = below;
    while let Some(&a_first) = a_row.first() {
        let (target, others) = below.split_at_mut(length);
        let target = &mut target[..a_row.len()];
        // Entries that are zero in all lanes are so by the structure of the chain.
        let uses_a = !a_first.all_zero();
        match b_row.first() {
            Some(&b_first) if !b_first.all_zero() => {
                let b_factor = b_first * b;
                if uses_a {
                    subtract_both(target, a_first * a, a_row, b_factor, b_row);
                } else {
                    subtract(target, b_factor, b_row);
                }
            }
            _ if uses_a => subtract(target, a_first * a, a_row),
            _ => {}
        }
        (below, length, a_row) = (others, length - 1, &a_row[1..]);
        b_row = b_row.get(1..).unwrap_or_default();
    }
}

/// Subtracts `a` times `a_row` and `b` times `b_row` from `target`.
#[inline(always)]
fn subtract_both<R: Real>(target: &mut [R], a: R, a_row: &[R], b: R, b_row: &[R]) {
    let (target, b_row) = (&mut target[..a_row.len()], &b_row[..a_row.len()]);
    for i in 0..a_row.len() {
        target[i] = target[i] - a * a_row[i] - b * b_row[i];
    }
}
