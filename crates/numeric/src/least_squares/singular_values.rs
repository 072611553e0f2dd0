//! A = U S Vᵀ and Uᵀ b of a small dense matrix: everything least squares needs of it.
//!
//! Householder QR of A with b beside it leaves a triangle and Qᵀ b; the singular values are those of the triangle. Both are faer's, in one
//! thread. Memory is kept between uses.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::qr::no_pivoting::factor::{qr_in_place, qr_in_place_scratch};
use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
use faer::{Mat, MatMut, MatRef, Par, Spec};

use crate::simd::{sums_side_by_side, widest};

/// The decomposition and the memory for it; matrices are stored by columns.
#[derive(Debug, Clone, Default)]
pub(super) struct SingularValues {
    rows: usize,
    columns: usize,
    /// A and, as its last column, b.
    matrix: Vec<f64>,
    right_vectors: Vec<f64>,
    values: Vec<f64>,
    projections: Vec<f64>,
}

/// Columns reflected at a time: of a dozen columns each alone is fastest.
const BLOCK: usize = 1;

impl SingularValues {
    /// Sets the shape; what was there before is forgotten.
    pub(super) fn reshape(&mut self, rows: usize, columns: usize) {
        self.rows = rows;
        self.columns = columns;
        self.matrix.resize(rows * (columns + 1), 0.0);
        self.right_vectors.resize(columns * columns, 0.0);
        self.values.resize(columns, 0.0);
        self.projections.resize(columns, 0.0);
    }

    /// Column `j` of A, to be filled before `decompose`.
    pub(super) fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.matrix[j * self.rows..(j + 1) * self.rows]
    }

    /// b, to be filled before `decompose`.
    pub(super) fn right_hand_side_mut(&mut self) -> &mut [f64] {
        self.column_mut(self.columns)
    }

    /// Singular values, the largest first.
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// u_jᵀ b for each singular value; zero where the singular value is zero.
    pub(super) fn projections(&self) -> &[f64] {
        &self.projections
    }

    /// Right singular vector number `j`.
    pub(super) fn right_vector(&self, j: usize) -> &[f64] {
        &self.right_vectors[j * self.columns..(j + 1) * self.columns]
    }

    /// Decomposes the matrix that was filled in; all entries must be finite.
    pub(super) fn decompose(&mut self) {
        let (rows, n) = (self.rows, self.columns);
        let height = rows.min(n);
        self.values.fill(0.0);
        self.projections.fill(0.0);
        if height == 0 {
            return;
        }
        if rows > n {
            self.reduce_to_triangle();
        }
        let reduced = MatRef::from_column_major_slice(&self.matrix, rows, n + 1);
        let below = |i: usize, j: usize| rows > n && i > j;
        let triangle = Mat::from_fn(
            height,
            n,
            |i, j| {
                if below(i, j) { 0.0 } else { reduced[(i, j)] }
            },
        );
        let mut left = Mat::zeros(height, height);
        let mut values = Diag::zeros(height);
        let (full, spec) = (ComputeSvdVectors::Full, Spec::default());
        let mut memory = MemBuffer::new(svd_scratch::<f64>(height, n, full, full, Par::Seq, spec));
        let converged = svd(
            triangle.as_ref(),
            values.as_mut(),
            Some(left.as_mut()),
            Some(MatMut::from_column_major_slice_mut(
                &mut self.right_vectors,
                n,
                n,
            )),
            Par::Seq,
            MemStack::new(&mut memory),
            spec,
        );
        // Without singular values nothing is known of any direction.
        if converged.is_err() {
            return;
        }
        for j in 0..height {
            self.values[j] = values[j];
            if values[j] > 0.0 {
                self.projections[j] = (0..height).map(|i| left[(i, j)] * reduced[(i, n)]).sum();
            }
        }
    }

    /// QR of A with b beside it, in place: above the diagonal R, and Qᵀ b.
    fn reduce_to_triangle(&mut self) {
        let (rows, columns) = (self.rows, self.columns + 1);
        let spec = Spec::default();
        let scratch = qr_in_place_scratch::<f64>(rows, columns, BLOCK, Par::Seq, spec);
        qr_in_place(
            MatMut::from_column_major_slice_mut(&mut self.matrix, rows, columns),
            Mat::zeros(BLOCK, columns).as_mut(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(scratch)),
            spec,
        );
    }
}

/// Sum of products.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    widest(
        #[inline(always)]
        || sums_side_by_side(a, b),
    )
}

/// Euclidean length.
pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decomposed(columns: &[&[f64]], b: &[f64]) -> SingularValues {
        let mut svd = SingularValues::default();
        svd.reshape(b.len(), columns.len());
        for (j, column) in columns.iter().enumerate() {
            svd.column_mut(j).copy_from_slice(column);
        }
        svd.right_hand_side_mut().copy_from_slice(b);
        svd.decompose();
        svd
    }

    #[test]
    fn a_matrix_with_known_singular_values() {
        // Golub and Van Loan's example: A = [1 1; e 0; 0 e] has singular values sqrt(2 + e²) and e.
        let e = 1e-9;
        let svd = decomposed(&[&[1.0, e, 0.0], &[1.0, 0.0, e]], &[2.0, e, e]);
        let mut values = svd.values().to_vec();
        values.sort_by(f64::total_cmp);
        assert!((values[0] / e - 1.0).abs() < 1e-14, "{values:?}");
        assert!((values[1] / 2.0_f64.sqrt() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_zero_column_and_a_wide_matrix_are_no_trouble() {
        let svd = decomposed(&[&[0.0, 0.0], &[3.0, 4.0], &[0.0, 0.0]], &[1.0, 0.0]);
        let mut values = svd.values().to_vec();
        values.sort_by(f64::total_cmp);
        assert_eq!(values, [0.0, 0.0, 5.0]);
    }

    proptest! {
        /// Against the outside implementation in nalgebra.
        #[test]
        fn singular_values_and_solution_agree_with_nalgebra(
            entries in prop::collection::vec(-10.0..10.0_f64, 24),
            b in prop::collection::vec(-10.0..10.0_f64, 8),
        ) {
            let columns: Vec<&[f64]> = entries.chunks(8).collect();
            let svd = decomposed(&columns, &b);
            let matrix = nalgebra::DMatrix::from_column_slice(8, 3, &entries);
            let theirs = matrix.clone().svd(true, true);
            let mut values = svd.values().to_vec();
            values.sort_by(|a, b| b.total_cmp(a));
            for (ours, theirs) in values.iter().zip(theirs.singular_values.iter()) {
                prop_assert!((ours - theirs).abs() < 1e-12 * values[0]);
            }
            prop_assume!(values[2] > 1e-2 * values[0]);
            let solution = theirs.solve(&nalgebra::DVector::from_column_slice(&b), 0.0).unwrap();
            for i in 0..3 {
                let ours: f64 = (0..3).map(|j| svd.right_vector(j)[i] * svd.projections()[j] / svd.values()[j]).sum();
                prop_assert!((ours - solution[i]).abs() < 1e-9, "{ours} {}", solution[i]);
            }
        }
    }
}
