//! Rows made white, with the columns of the baseline projected out.

use std::ops::Range;

use stiffbench_numeric::simd::{sums_side_by_side, widest};

use super::constants::{ROUNDING, SHORTEST_COLUMN};
use super::covariance::Covariance;
use super::vectors::{dot, norm, push_orthonormal, subtract};

/// The space in which candidates are compared: white, and orthogonal to the columns of the baseline.
///
/// Behind the rows stand as many entries as parameters have a prior: what is known of a parameter beforehand counts as a row.
#[derive(Debug, Clone)]
pub struct WhiteSpace {
    /// Covariance of the rows.
    pub covariance: Covariance,
    /// Orthonormal white columns of the baseline.
    basis: Vec<Vec<f64>>,
    /// Rows and priors.
    pub length: usize,
}

impl WhiteSpace {
    /// The space of a covariance and the columns of a baseline; columns that others contain are left out.
    ///
    /// # Arguments
    /// - `prior_sd`: standard deviations of the parameters of the first columns as known beforehand, in units of the parameters.
    /// - `columns`: derivatives of the rows to the parameters.
    #[must_use]
    pub fn new(covariance: Covariance, prior_sd: &[f64], columns: &[Vec<f64>]) -> Self {
        let rows = covariance.weights().len();
        let mut space = Self {
            covariance,
            basis: Vec::new(),
            length: rows + prior_sd.len(),
        };
        for (index, column) in columns.iter().enumerate() {
            let mut white = space.white(column);
            if let Some(prior_sd) = prior_sd.get(index) {
                white[rows + index] = prior_sd.recip();
            }
            push_orthonormal(&mut space.basis, white, ROUNDING, SHORTEST_COLUMN);
        }
        space
    }

    /// Orthonormal white columns of the baseline.
    #[must_use]
    pub fn basis(&self) -> &[Vec<f64>] {
        &self.basis
    }

    /// A vector of rows made white; the entries of the priors are zero.
    #[must_use]
    pub fn white(&self, rows: &[f64]) -> Vec<f64> {
        let mut white = Vec::with_capacity(self.length);
        white.extend_from_slice(rows);
        self.covariance.whiten(&mut white);
        white.resize(self.length, 0.0);
        white
    }

    /// The same of a vector that counts in a range only, a union of blocks, and is zero elsewhere.
    #[must_use]
    pub fn white_part(&self, rows: &[f64], range: &Range<usize>) -> Vec<f64> {
        let mut white = vec![0.0; self.length];
        white[range.clone()].copy_from_slice(&rows[range.clone()]);
        self.covariance.whiten_part(&mut white, range);
        white
    }

    /// One vector or two of rows as white vectors that are orthonormal when projected, not projected, and the length of the first when
    /// projected; `None` if the baseline, or the first, leaves less than a share of one's length.
    #[must_use]
    pub fn orthonormal(&self, shapes: &[Vec<f64>], least: f64) -> Option<(Vec<Vec<f64>>, f64)> {
        let mut units: Vec<Vec<f64>> = Vec::new();
        let mut projected: Vec<Vec<f64>> = Vec::new();
        let mut length = 0.0;
        for shape in shapes {
            let mut white = self.white(shape);
            let before = norm(&white);
            let mut left = white.clone();
            self.project(&mut left);
            for (unit, other) in units.iter().zip(&projected) {
                let share = dot(other, &left);
                subtract(&mut left, share, other);
                subtract(&mut white, share, unit);
            }
            let after = norm(&left);
            if !(after > least * before && after > 0.0) {
                return None;
            }
            for value in left.iter_mut().chain(&mut white) {
                *value /= after;
            }
            if units.is_empty() {
                length = after;
            }
            projected.push(left);
            units.push(white);
        }
        Some((units, length))
    }

    /// Projects the columns of the baseline out of a white vector, in place.
    pub fn project(&self, white: &mut [f64]) {
        widest(
            #[inline(always)]
            || {
                for column in &self.basis {
                    let product = sums_side_by_side(column, white);
                    for (value, unit) in white.iter_mut().zip(column) {
                        *value -= product * unit;
                    }
                }
            },
        );
    }

    /// Products of a white vector with the columns of the baseline.
    #[must_use]
    pub fn along_basis(&self, white: &[f64]) -> Vec<f64> {
        self.basis.iter().map(|column| dot(column, white)).collect()
    }

    /// A vector of rows made white and projected.
    #[must_use]
    pub fn projected(&self, rows: &[f64]) -> Vec<f64> {
        let mut white = self.white(rows);
        self.project(&mut white);
        white
    }
}
