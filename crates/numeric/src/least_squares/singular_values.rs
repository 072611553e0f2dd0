//! A = U S Vᵀ and Uᵀ b of a small dense matrix: everything least squares needs of it.
//!
//! Householder QR reduces A to its triangle, one-sided Jacobi rotations make the columns of the triangle orthogonal. Jacobi
//! keeps the small singular values of a matrix with scaled columns to full relative accuracy (Demmel and Veselić, SIAM J. Matrix
//! Anal. Appl. 13 (1992) 1204), and those are the ones that decide standard errors. Memory is kept between uses.

use crate::lanes::{sums_side_by_side, widest};

/// The decomposition and the memory for it; matrices are stored by columns.
#[derive(Debug, Clone, Default)]
pub(super) struct SingularValues {
    rows: usize,
    columns: usize,
    /// Rows that are left after QR.
    height: usize,
    /// The matrix; after `decompose` its columns are U_j s_j.
    matrix: Vec<f64>,
    right_hand_side: Vec<f64>,
    right_vectors: Vec<f64>,
    values: Vec<f64>,
    projections: Vec<f64>,
}

/// Rotations stop when no pair of columns has a cosine above this many machine epsilons.
const COSINE_EPSILONS: f64 = 8.0;

/// Jacobi converges quadratically; ten sweeps are already rare.
const MAX_SWEEPS: usize = 60;

impl SingularValues {
    /// Sets the shape; what was there before is forgotten.
    pub(super) fn reshape(&mut self, rows: usize, columns: usize) {
        self.rows = rows;
        self.columns = columns;
        self.height = rows.min(columns);
        self.matrix.resize(rows * columns, 0.0);
        self.right_hand_side.resize(rows, 0.0);
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
        &mut self.right_hand_side
    }

    /// Singular values, in no particular order.
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
        if self.rows > self.columns {
            self.reduce_to_triangle();
        }
        self.orthogonalise_columns();
        for j in 0..self.columns {
            let column = &self.matrix[j * self.rows..][..self.height];
            let value = norm(column);
            self.values[j] = value;
            self.projections[j] = if value == 0.0 {
                0.0
            } else {
                dot(column, &self.right_hand_side[..self.height]) / value
            };
        }
    }

    /// Householder reflections; b is reflected along.
    ///
    /// # Source
    /// Golub and Van Loan, Matrix Computations, 4th edition, algorithms 5.1.1 and 5.2.1.
    fn reduce_to_triangle(&mut self) {
        let rows = self.rows;
        for k in 0..self.columns {
            let (done, rest) = self.matrix.split_at_mut((k + 1) * rows);
            let mirror = &mut done[k * rows + k..];
            let length = norm(mirror);
            if length == 0.0 {
                continue;
            }
            let diagonal = -length.copysign(mirror[0]);
            mirror[0] -= diagonal;
            // Half the squared length of the mirror vector.
            let half = -diagonal * mirror[0];
            for column in rest.chunks_exact_mut(rows) {
                reflect(mirror, half, &mut column[k..]);
            }
            reflect(mirror, half, &mut self.right_hand_side[k..]);
            mirror.fill(0.0);
            mirror[0] = diagonal;
        }
    }

    /// One-sided Jacobi: rotates pairs of columns, and V with them, until all are orthogonal.
    ///
    /// # Source
    /// Golub and Van Loan, section 8.6.3.
    fn orthogonalise_columns(&mut self) {
        let (n, rows, height) = (self.columns, self.rows, self.height);
        self.right_vectors.fill(0.0);
        for j in 0..n {
            self.right_vectors[j * n + j] = 1.0;
        }
        for _ in 0..MAX_SWEEPS {
            let mut rotated = false;
            for q in 1..n {
                for p in 0..q {
                    let (left, right) = self.matrix.split_at_mut(q * rows);
                    let (a, b) = (&mut left[p * rows..][..height], &mut right[..height]);
                    let short = sums_side_by_side;
                    let (aa, bb, ab) = (short(a, a), short(b, b), short(a, b));
                    if ab.abs() <= COSINE_EPSILONS * f64::EPSILON * (aa * bb).sqrt() {
                        continue;
                    }
                    rotated = true;
                    let zeta = (bb - aa) / (2.0 * ab);
                    let tangent = 1.0_f64.copysign(zeta) / (zeta.abs() + zeta.hypot(1.0));
                    let cosine = 1.0 / tangent.hypot(1.0);
                    let sine = cosine * tangent;
                    rotate(a, b, cosine, sine);
                    let (left, right) = self.right_vectors.split_at_mut(q * n);
                    rotate(&mut left[p * n..][..n], &mut right[..n], cosine, sine);
                }
            }
            if !rotated {
                break;
            }
        }
    }
}

fn reflect(mirror: &[f64], half: f64, vector: &mut [f64]) {
    widest(
        #[inline(always)]
        || {
            let factor = sums_side_by_side(mirror, vector) / half;
            for (v, m) in vector.iter_mut().zip(mirror) {
                *v -= factor * m;
            }
        },
    );
}

fn rotate(a: &mut [f64], b: &mut [f64], cosine: f64, sine: f64) {
    for (a, b) in a.iter_mut().zip(b) {
        (*a, *b) = (cosine * *a - sine * *b, sine * *a + cosine * *b);
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
