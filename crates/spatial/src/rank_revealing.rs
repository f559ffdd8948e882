//! A dense matrix factored so that its rank shows: a complete orthogonal decomposition.
//!
//! `A P = Q R` by columns of falling size; of the rows of R that count, `Rᵀ = Z T`. Costs a fraction of singular values, and those
//! of nalgebra are at times wrong for small matrices of less than full rank (its issue 1172).

use nalgebra::{ColPivQR, DMatrix, Dyn};

/// Complete orthogonal decomposition of a matrix of any shape that is not empty.
pub struct RankRevealing {
    factors: ColPivQR<f64, Dyn, Dyn>,
    /// Z, as many columns as the rank.
    from_right: DMatrix<f64>,
    /// `Tᵀ`.
    lower: DMatrix<f64>,
}

impl RankRevealing {
    /// Factors `matrix`; rows of R whose diagonal entry is at most `tolerance` times the largest count as zero.
    pub fn new(matrix: DMatrix<f64>, tolerance: f64) -> Self {
        let columns = matrix.ncols();
        let factors = matrix.col_piv_qr();
        let upper = factors.r();
        let (from_right, lower) = match rank_of(&upper, tolerance) {
            0 => (DMatrix::zeros(columns, 0), DMatrix::zeros(0, 0)),
            rank => {
                let from_right = upper.rows(0, rank).transpose().qr();
                (from_right.q(), from_right.unpack_r().transpose())
            }
        };
        Self { factors, from_right, lower }
    }

    /// Numerical rank of the matrix.
    pub fn rank(&self) -> usize {
        self.lower.nrows()
    }

    /// An orthonormal basis of the column space, as columns.
    pub fn column_space(&self) -> DMatrix<f64> {
        self.factors.q().columns(0, self.rank()).into_owned()
    }

    /// An orthonormal basis of the row space, as columns.
    pub fn row_space(&self) -> DMatrix<f64> {
        let mut rows = self.from_right.clone();
        self.factors.p().inv_permute_rows(&mut rows);
        rows
    }

    /// An orthonormal basis of the null space, as columns.
    pub fn null_space(&self) -> DMatrix<f64> {
        let (size, rank) = (self.from_right.nrows(), self.rank());
        self.row_space().insert_columns(rank, size - rank, 0.0).qr().q().columns(rank, size - rank).into_owned()
    }

    /// Least-squares solution of minimal length for each column of `right`; `None` if the triangular factor is singular.
    pub fn solve(&self, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let mut turned = right.clone();
        self.factors.q_tr_mul(&mut turned);
        let part = self.lower.solve_lower_triangular(&turned.rows(0, self.rank()))?;
        let mut solution = &self.from_right * part;
        self.factors.p().inv_permute_rows(&mut solution);
        Some(solution)
    }
}

/// Numerical rank of `matrix`, with the `tolerance` of [`RankRevealing::new`].
pub fn rank(matrix: &DMatrix<f64>, tolerance: f64) -> usize {
    rank_of(&matrix.clone().col_piv_qr().r(), tolerance)
}

/// Number of leading diagonal entries of `upper` that exceed `tolerance` times the largest.
fn rank_of(upper: &DMatrix<f64>, tolerance: f64) -> usize {
    let diagonal: Vec<f64> = (0..upper.nrows()).map(|i| upper[(i, i)]).collect();
    let largest = diagonal.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    diagonal.iter().take_while(|value| value.abs() > tolerance * largest).count()
}
