//! The symmetric root of the inverse of a matrix that differs from one by a few columns.

use nalgebra::DMatrix;

/// The matrix M that makes I - C M Cᵀ the symmetric root of (I + C Cᵀ)⁻¹.
///
/// # Arguments
/// - `gram`: Cᵀ C.
pub(super) fn symmetric_root(gram: &DMatrix<f64>) -> DMatrix<f64> {
    // (1 - 1/√(1+λ))/λ, whose limit at zero is a half.
    let weight = |value: f64| {
        if value < 1e-12 {
            0.5
        } else {
            (1.0 - (1.0 + value).sqrt().recip()) / value
        }
    };
    let rank = gram.nrows();
    if rank == 2 {
        // A run with a zero of its own: most groups. A turn of the axes makes the matrix diagonal.
        let (a, b, d) = (gram[(0, 0)], gram[(1, 0)], gram[(1, 1)]);
        let (sin, cos) = (0.5 * (2.0 * b).atan2(a - d)).sin_cos();
        let large = 0.5 * (a + d) + (0.5 * (a - d)).hypot(b);
        let small = ((a * d - b * b) / large.max(f64::MIN_POSITIVE)).max(0.0);
        let [of_large, of_small] = [large, small].map(weight);
        let mixed = (of_large - of_small) * sin * cos;
        let inner = [
            of_large * cos * cos + of_small * sin * sin,
            mixed,
            mixed,
            of_large * sin * sin + of_small * cos * cos,
        ];
        return DMatrix::from_row_slice(2, 2, &inner);
    }
    let eigen = gram.clone().symmetric_eigen();
    let mut inner = DMatrix::zeros(rank, rank);
    for (index, &value) in eigen.eigenvalues.iter().enumerate() {
        let vector = eigen.eigenvectors.column(index);
        inner += weight(value.max(0.0)) * vector * vector.transpose();
    }
    inner
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Twice the root is the inverse, for one to four columns of six numbers.
        #[test]
        fn the_root_squared_is_the_inverse(
            values in proptest::collection::vec(-3.0..3.0_f64, 24), rank in 1..=4_usize,
        ) {
            let c = DMatrix::from_column_slice(6, rank, &values[..6 * rank]);
            let inner = symmetric_root(&c.tr_mul(&c));
            let one = DMatrix::<f64>::identity(6, 6);
            let root = &one - &c * inner * c.transpose();
            let whole = &one + &c * c.transpose();
            let error = (&root * &root * &whole - &one).amax();
            // Rounding of a matrix of condition below 250.
            prop_assert!(error < 1e-11, "{error}");
        }
    }

    #[test]
    fn columns_of_zeros_and_equal_columns_are_no_exception() {
        for values in [
            [0.0; 6],
            [1.0, 2.0, 3.0, 1.0, 2.0, 3.0],
            [1.0, 2.0, 3.0, 0.0, 0.0, 0.0],
        ] {
            let c = DMatrix::from_column_slice(3, 2, &values);
            let inner = symmetric_root(&c.tr_mul(&c));
            let one = DMatrix::<f64>::identity(3, 3);
            let root = &one - &c * inner * c.transpose();
            let whole = &one + &c * c.transpose();
            assert!((&root * &root * &whole - &one).amax() < 1e-13);
        }
    }
}
