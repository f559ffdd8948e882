//! What of linear algebra a library lacks: matrices of any rank, and small systems in lanes.

use kinetostat_engine::{
    lanes::solve,
    nalgebra::{ComplexField, DMatrix, RealField},
    spatial::{RankRevealing, rank},
};
use proptest::prelude::*;

fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    proptest::collection::vec(-1.0..1.0, rows * columns)
        .prop_map(move |entries| DMatrix::from_vec(rows, columns, entries))
}

/// A processor with fused multiply-add rounds a product and a sum at once, if it is let.
#[test]
fn products_and_functions_are_the_same_on_every_processor() {
    let [left, right] = [0.7, 1.3].map(|step| DMatrix::from_fn(24, 24, |i, j| libm::sin(step * (24 * i + j) as f64)));
    let sums = DMatrix::from_fn(24, 24, |i, j| (0..24).fold(0.0, |sum, k| sum + left[(i, k)] * right[(k, j)]));
    assert_eq!(&left * &right, sums);
    for x in (1..2000).map(|step| 1e-3 * f64::from(step)) {
        let of_nalgebra =
            [ComplexField::sin(x), ComplexField::hypot(x, 0.7), RealField::atan2(x, 0.7), ComplexField::powf(x, 0.7)];
        assert_eq!(of_nalgebra, [libm::sin(x), libm::hypot(x, 0.7), libm::atan2(x, 0.7), libm::pow(x, 0.7)], "{x}");
    }
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

        let (columns, rows, null) = (factored.column_space(), factored.row_space(), factored.null_space());
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

#[test]
fn rows_are_exchanged_where_pivots_ask_for_it() {
    let mut right = [[5.0, 3.0, 4.0, f64::NAN], [1.0, 0.0, 0.0, f64::NAN]];
    let matrix = [[0.0, 2.0, 1.0, 9.0], [1.0, 0.0, 1.0, 9.0], [1.0, 1.0, 1.0, 9.0], [9.0; 4]];
    assert_eq!(solve(matrix, 3, &mut right), 1);
    assert_eq!(right[0][..3], [0.0, 1.0, 3.0]);
    assert_eq!(right[1][..3], [-1.0, 0.0, 1.0]);
}

#[test]
fn a_singular_matrix_is_told() {
    assert_eq!(solve([[1.0, 2.0], [2.0, 4.0]], 2, &mut [[1.0, 1.0]]), 0);
}
