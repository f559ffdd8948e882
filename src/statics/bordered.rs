//! Elimination of the leading unknowns of a symmetric bordered matrix.

/// A symmetric matrix of which the upper triangle is kept, row by row.
#[derive(Debug, Clone, Default)]
pub(super) struct Bordered {
    size: usize,
    upper: Vec<f64>,
    /// Diagonal before the stage under way, by which zero pivots are told.
    scales: Vec<f64>,
}

/// A pivot that is zero to rounding or of the wrong sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BadPivot {
    /// Row of the pivot.
    pub row: usize,
}

/// A pivot below this fraction of its diagonal entry before its stage is zero.
const PIVOT_TOLERANCE: f64 = 1e-11;

impl Bordered {
    pub fn new(size: usize) -> Self {
        Self { size, upper: vec![0.0; size * size], scales: Vec::with_capacity(size) }
    }

    pub fn clear(&mut self) {
        self.upper.fill(0.0);
    }

    /// Entry (row, column), row ≤ column.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        debug_assert!(row <= column);
        self.upper[row * self.size + column]
    }

    /// Entry (row, column), row ≤ column.
    pub fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        debug_assert!(row <= column);
        &mut self.upper[row * self.size + column]
    }

    /// Row `row`, from column 0; entries left of the diagonal are unused.
    pub fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.upper[row * self.size..(row + 1) * self.size]
    }

    /// Eliminates rows `rows`, whose pivots must all have the sign `sign`; columns from `end` on are known to be zero in
    /// these rows and are not touched.
    ///
    /// Row `k` is left as `d_k · (1, l_k+1, …)`, so that [`Bordered::back_substitute`] can use it; what remains below is
    /// the Schur complement.
    pub fn eliminate(&mut self, rows: std::ops::Range<usize>, end: usize, sign: f64) -> Result<(), BadPivot> {
        let size = self.size;
        self.scales.clear();
        self.scales.extend(rows.clone().map(|row| self.upper[row * size + row].abs()));
        for (stage, row) in rows.enumerate() {
            let (above, below) = self.upper.split_at_mut((row + 1) * size);
            let pivot_row = &above[row * size..];
            let pivot = pivot_row[row];
            if pivot.is_nan() || pivot * sign <= PIVOT_TOLERANCE * self.scales[stage] {
                return Err(BadPivot { row });
            }
            let inverse = 1.0 / pivot;
            for (offset, target) in below.chunks_exact_mut(size).take(end - row - 1).enumerate() {
                let column = row + 1 + offset;
                let factor = pivot_row[column] * inverse;
                if factor != 0.0 {
                    for (t, p) in target[column..end].iter_mut().zip(&pivot_row[column..end]) {
                        *t -= factor * p;
                    }
                }
            }
        }
        Ok(())
    }

    /// Solves eliminated rows `0..rows` for the leading unknowns, given all later ones: `Σ_j U_kj z_j = 0` in each row.
    pub fn back_substitute(&self, rows: usize, z: &mut [f64]) {
        for row in (0..rows).rev() {
            let coefficients = &self.upper[row * self.size..(row + 1) * self.size];
            let (known, rest) = (&coefficients[row + 1..], &z[row + 1..]);
            let sum: f64 = known.iter().zip(rest).map(|(a, b)| a * b).sum();
            z[row] = -sum / coefficients[row];
        }
    }
}
