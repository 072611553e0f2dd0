//! A low-rank basis: a few of many vectors, of which all are sums.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use stiffbench_numeric::simd::widest;

use crate::search::constants::LEFT_OUT;

/// A basis of vectors, and all of them as sums over it.
pub(super) struct LowRank {
    /// The basis, one vector after the other.
    pub(super) basis: Vec<f64>,
    /// Shares of the basis, vector by vector.
    pub(super) shares: Vec<f64>,
}

impl LowRank {
    /// Chooses those vectors that leave least of the others, until nothing is left that counts.
    ///
    /// # Arguments
    /// - `vectors`, `absorbed`: vectors, and what is projected out of them, one after the other.
    ///
    /// # Returns
    /// `None` where they are so many that sums over them are no less work.
    ///
    /// # Source
    /// Cholesky's factor of the matrix of products, the largest that is left first: Golub and Van Loan, Matrix Computations, 4th edition,
    /// section 4.2.8.
    pub(super) fn new(directions: usize, vectors: &[f64], absorbed: &[f64]) -> Option<Self> {
        let count = vectors.len() / directions.max(1);
        let products = products(directions, vectors, absorbed);
        let of = |vector: usize| &products[vector * count..][..count];
        let most = directions * count / (directions + count).max(1);
        let mut left: Vec<f64> = (0..count).map(|vector| of(vector)[vector]).collect();
        let mut chosen: Vec<usize> = Vec::new();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        loop {
            let largest = (0..count).max_by(|&a, &b| left[a].total_cmp(&left[b]))?;
            if left[largest] <= LEFT_OUT * LEFT_OUT {
                break;
            }
            if chosen.len() == most {
                return None;
            }
            let mut row = of(largest).to_vec();
            for earlier in &rows {
                let share = earlier[largest];
                for (value, other) in row.iter_mut().zip(earlier) {
                    *value -= share * other;
                }
            }
            let length = left[largest].sqrt();
            for (value, left) in row.iter_mut().zip(&mut left) {
                *value /= length;
                *left -= *value * *value;
            }
            chosen.push(largest);
            rows.push(row);
        }
        if chosen.is_empty() {
            return None;
        }
        let shares = sums(count, &chosen, &rows);
        let of_basis = chosen
            .iter()
            .flat_map(|&vector| &vectors[vector * directions..][..directions]);
        Some(Self {
            basis: of_basis.copied().collect(),
            shares,
        })
    }
}

/// Shares of the chosen in each vector, from rows of the factor.
fn sums(count: usize, chosen: &[usize], rows: &[Vec<f64>]) -> Vec<f64> {
    // Columns of the triangle of the chosen themselves: contiguous, for they are read once for each vector.
    let columns: Vec<Vec<f64>> = chosen
        .iter()
        .enumerate()
        .map(|(place, &vector)| rows[..=place].iter().map(|row| row[vector]).collect())
        .collect();
    let mut out = Vec::with_capacity(count * chosen.len());
    for vector in 0..count {
        let first = out.len();
        out.extend(rows.iter().map(|row| row[vector]));
        solve_upper(&columns, &mut out[first..]);
    }
    out
}

/// Solves an upper triangle, given by columns, in place.
fn solve_upper(columns: &[Vec<f64>], shares: &mut [f64]) {
    widest(
        #[inline(always)]
        || {
            for (place, column) in columns.iter().enumerate().rev() {
                let (before, rest) = shares.split_at_mut(place);
                rest[0] /= column[place];
                for (share, entry) in before.iter_mut().zip(column) {
                    *share -= rest[0] * entry;
                }
            }
        },
    );
}

/// Products of vectors with each other when projected.
fn products(directions: usize, vectors: &[f64], absorbed: &[f64]) -> Vec<f64> {
    let (count, columns) = (
        vectors.len() / directions.max(1),
        absorbed.len() / directions.max(1),
    );
    let vectors = MatRef::from_column_major_slice(vectors, directions, count);
    let absorbed = MatRef::from_column_major_slice(absorbed, directions, columns);
    let mut shares = vec![0.0; columns * count];
    let mut shares = MatMut::from_column_major_slice_mut(&mut shares, columns, count);
    let mut out = vec![0.0; count * count];
    let mut products = MatMut::from_column_major_slice_mut(&mut out, count, count);
    let replace = Accum::Replace;
    matmul(
        shares.as_mut(),
        replace,
        absorbed.transpose(),
        vectors,
        1.0,
        Par::Seq,
    );
    matmul(
        products.as_mut(),
        replace,
        vectors.transpose(),
        vectors,
        1.0,
        Par::Seq,
    );
    let shares = shares.as_ref();
    matmul(
        products,
        Accum::Add,
        shares.transpose(),
        shares,
        -1.0,
        Par::Seq,
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_sums_of_the_basis_they_span() {
        // Forty vectors of three waves in thirty directions, one direction projected out.
        let wave = |k: usize, i: usize| (0.7 * (k * i + k) as f64).sin();
        let vector = |v: usize| {
            (0..30).map(move |i| {
                let shares = [1.0, 0.1 * v as f64, (0.3 * v as f64).cos()];
                shares
                    .iter()
                    .zip(1..)
                    .map(|(s, k)| s * wave(k, i))
                    .sum::<f64>()
            })
        };
        let vectors: Vec<f64> = (0..40).flat_map(vector).collect();
        let mut absorbed = vec![0.0; 30];
        absorbed[4] = 1.0;
        let low_rank = LowRank::new(30, &vectors, &absorbed).unwrap();
        let count = low_rank.basis.len() / 30;
        assert_eq!(count, 3);
        for (vector, shares) in vectors.chunks(30).zip(low_rank.shares.chunks(count)) {
            for i in (0..30).filter(|i| *i != 4) {
                let terms = low_rank.basis.chunks(30).zip(shares);
                let sum: f64 = terms.map(|(vector, share)| share * vector[i]).sum();
                assert!(
                    (sum - vector[i]).abs() < LEFT_OUT,
                    "{i}: {sum} {}",
                    vector[i]
                );
            }
        }
        // Vectors that span all there is are their own basis.
        let all: Vec<f64> = (0..900).map(|i| f64::from(u8::from(i % 31 == 0))).collect();
        assert!(LowRank::new(30, &all, &absorbed[..0]).is_none());
    }
}
