//! Small systems of linear equations, rows of numbers, and iteration over two sequences side by side.

use super::Real;

/// Solves `matrix · x = right` for several columns `right` by elimination with row pivoting; the solutions replace the columns. Only the leading
/// `size` rows and columns count. Returns the lanes in which the matrix is regular; the others hold no numbers.
#[inline(always)]
pub fn solve<R: Real, const N: usize>(mut matrix: [[R; N]; N], size: usize, right: &mut [[R; N]]) -> u8 {
    let mut regular = R::ALL;
    for k in 0..size {
        for i in k + 1..size {
            let (above, below) = matrix.split_at_mut(i);
            let (pivot_row, row) = (&mut above[k][k..size], &mut below[0][k..size]);
            let swap = row[0].abs().greater(pivot_row[0].abs());
            if R::mask_to_bits(swap) == 0 {
                continue;
            }
            for (a, b) in pairs(pivot_row.iter_mut(), row) {
                swap_where(swap, a, b);
            }
            for column in right.iter_mut() {
                let (above, below) = column.split_at_mut(i);
                swap_where(swap, &mut above[k], &mut below[0]);
            }
        }
        let (above, below) = matrix.split_at_mut(k + 1);
        let pivot_row = &mut above[k];
        regular &= pivot_row[k].abs().lanes_greater(0.0);
        let inverse = R::splat(1.0) / pivot_row[k];
        pivot_row[k] = inverse;
        for (i, row) in below[..size - k - 1].iter_mut().enumerate() {
            let factor = row[k] * inverse;
            subtract(&mut row[k + 1..size], factor, &pivot_row[k + 1..size]);
            for column in right.iter_mut() {
                let value = column[k];
                column[k + 1 + i] -= factor * value;
            }
        }
    }
    for column in right {
        for k in (0..size).rev() {
            let mut rest = column[k];
            for j in k + 1..size {
                rest -= matrix[k][j] * column[j];
            }
            column[k] = rest * matrix[k][k];
        }
    }
    regular
}

/// Scalar product of two equally long rows.
#[inline(always)]
pub(crate) fn dot<R: Real>(a: &[R], b: &[R]) -> R {
    // Four sums, which need not wait for one another.
    let mut sums = [R::zero(); 4];
    let ((a_fours, a_others), (b_fours, b_others)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    for (a, b) in pairs(a_fours, b_fours) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    // A loop of fixed length keeps the sums in registers.
    for i in 0..3 {
        if i < a_others.len() {
            sums[i] += a_others[i] * b_others[i];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Subtracts a multiple of `row` from the first entries of `target`.
#[inline(always)]
pub(crate) fn subtract<R: Real>(target: &mut [R], factor: R, row: &[R]) {
    let target = &mut target[..row.len()];
    for i in 0..row.len() {
        target[i] -= factor * row[i];
    }
}

/// Makes all numbers zero.
#[inline(always)]
pub(crate) fn clear<R: Real>(numbers: &mut [R]) {
    for number in numbers {
        *number = R::zero();
    }
}

/// Copies `from` to the beginning of `to`.
#[inline(always)]
pub(crate) fn copy<R: Real>(to: &mut [R], from: &[R]) {
    for (to, &from) in pairs(&mut to[..from.len()], from) {
        *to = from;
    }
}

/// Exchanges two numbers in the lanes where `swap` holds.
#[inline(always)]
fn swap_where<R: Real>(swap: R::Mask, a: &mut R, b: &mut R) {
    (*a, *b) = (R::select(swap, *b, *a), R::select(swap, *a, *b));
}

/// The items of two sequences side by side, as of [`std::iter::zip`]. That is not marked for inlining throughout, and a call
/// in the midst of vector instructions empties the registers.
#[inline(always)]
pub(crate) fn pairs<A: IntoIterator, B: IntoIterator>(a: A, b: B) -> Pairs<A::IntoIter, B::IntoIter> {
    Pairs(a.into_iter(), b.into_iter())
}

/// Iterator over two sequences side by side, see [`pairs`].
pub(crate) struct Pairs<A, B>(A, B);

impl<A: Iterator, B: Iterator> Iterator for Pairs<A, B> {
    type Item = (A::Item, B::Item);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        Some((self.0.next()?, self.1.next()?))
    }
}
