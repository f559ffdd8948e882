//! A dense matrix factored so that its rank shows: a complete orthogonal decomposition.
//!
//! `A P = Q R` by columns of falling size; of the rows of R that count, `Rᵀ = Z T`. Costs a fraction of singular values, and those
//! of nalgebra are at times wrong for small matrices of less than full rank (its issue 1172).

use nalgebra::{ColPivQR, DMatrix, Dyn};

/// A matrix of any shape that is not empty, ready to be solved with.
pub(crate) struct RankRevealing {
    factors: ColPivQR<f64, Dyn, Dyn>,
    /// Z, as many columns as the rank.
    from_right: DMatrix<f64>,
    /// `Tᵀ`.
    lower: DMatrix<f64>,
}

impl RankRevealing {
    /// Rows of R with a diagonal of less than `tolerance` times the largest are zero.
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

    pub fn rank(&self) -> usize {
        self.lower.nrows()
    }

    /// An orthonormal basis of what the columns span.
    pub fn columns(&self) -> DMatrix<f64> {
        self.factors.q().columns(0, self.rank()).into_owned()
    }

    /// An orthonormal basis of what the rows span, in columns.
    pub fn rows(&self) -> DMatrix<f64> {
        let mut rows = self.from_right.clone();
        self.factors.p().inv_permute_rows(&mut rows);
        rows
    }

    /// An orthonormal basis of the null space, in columns.
    pub fn null_space(&self) -> DMatrix<f64> {
        let (size, rank) = (self.from_right.nrows(), self.rank());
        self.rows().insert_columns(rank, size - rank, 0.0).qr().q().columns(rank, size - rank).into_owned()
    }

    /// Solution of least squares and, among those, of minimal length, for each column of `right`.
    pub fn solve(&self, right: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let mut turned = right.clone();
        self.factors.q_tr_mul(&mut turned);
        let part = self.lower.solve_lower_triangular(&turned.rows(0, self.rank()))?;
        let mut solution = &self.from_right * part;
        self.factors.p().inv_permute_rows(&mut solution);
        Some(solution)
    }
}

/// Rank of any matrix, see [`RankRevealing::new`].
pub(crate) fn rank(matrix: &DMatrix<f64>, tolerance: f64) -> usize {
    rank_of(&matrix.clone().col_piv_qr().r(), tolerance)
}

fn rank_of(upper: &DMatrix<f64>, tolerance: f64) -> usize {
    let diagonal: Vec<f64> = (0..upper.nrows()).map(|i| upper[(i, i)]).collect();
    let largest = diagonal.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    diagonal.iter().take_while(|value| value.abs() > tolerance * largest).count()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
        proptest::collection::vec(-1.0..1.0, rows * columns)
            .prop_map(move |entries| DMatrix::from_vec(rows, columns, entries))
    }

    fn is_orthonormal(basis: &DMatrix<f64>) -> bool {
        (basis.tr_mul(basis) - DMatrix::identity(basis.ncols(), basis.ncols())).iter().all(|rest| rest.abs() < 1e-12)
    }

    proptest! {
        #![proptest_config(crate::cases::cases(128))]

        /// A matrix whose columns are those of `left` mixed, and its rows those of `right`.
        #[test]
        fn a_matrix_of_known_rank_is_taken_apart(
            (left, right, rhs) in (1usize..=9, 1usize..=9, 1usize..=9).prop_flat_map(|(rows, columns, rank)| {
                let rank = rank.min(rows).min(columns);
                (matrix(rows, rank), matrix(rank, columns), matrix(rows, 2))
            })
        ) {
            let grams = (left.tr_mul(&left), &right * right.transpose());
            let is_plain = |gram: &DMatrix<f64>| gram.clone().symmetric_eigenvalues().min() > 1e-3;
            prop_assume!(is_plain(&grams.0) && is_plain(&grams.1));
            let matrix = &left * &right;
            let factored = RankRevealing::new(matrix.clone(), 1e-12);
            prop_assert_eq!((factored.rank(), rank(&matrix, 1e-12)), (left.ncols(), left.ncols()));

            let (columns, rows, null) = (factored.columns(), factored.rows(), factored.null_space());
            prop_assert!(is_orthonormal(&columns) && is_orthonormal(&rows) && is_orthonormal(&null));
            prop_assert_eq!(rows.ncols() + null.ncols(), matrix.ncols());
            prop_assert!((&left - &columns * columns.tr_mul(&left)).iter().all(|rest| rest.abs() < 1e-11));
            prop_assert!((&matrix * &null).iter().all(|rest| rest.abs() < 1e-11));
            prop_assert!(rows.tr_mul(&null).iter().all(|rest| rest.abs() < 1e-11));

            let found = factored.solve(&rhs).expect("no zero on the diagonal");
            let rest = left.tr_mul(&(&matrix * &found - rhs));
            prop_assert!(rest.iter().all(|rest| rest.abs() < 1e-9), "least squares: {rest}");
            let along_null = null.tr_mul(&found);
            prop_assert!(along_null.iter().all(|rest| rest.abs() < 1e-10 * (1.0 + found.amax())), "longer: {along_null}");
        }
    }

    #[test]
    fn a_matrix_of_zeros_has_no_rank_and_moves_nothing() {
        let factored = RankRevealing::new(DMatrix::zeros(3, 3), 1e-12);
        assert_eq!(factored.rank(), 0);
        assert_eq!(factored.solve(&DMatrix::from_element(3, 1, 1.0)), Some(DMatrix::zeros(3, 1)));
        assert!(is_orthonormal(&factored.null_space()));
    }
}
