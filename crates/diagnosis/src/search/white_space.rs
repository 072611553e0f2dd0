//! Rows made white, with the columns of the baseline projected out.

use std::ops::Range;

use stiffbench_numeric::simd::{sums_side_by_side, widest};

use super::constants::{CANCELLED, ROUNDING};
use super::covariance::Covariance;
use super::vectors::{RowVector, dot, push_orthonormal, subtract};

/// White length, standard errors, from which a column of the baseline counts: shorter ones no fit can use. Numerics.
const SHORTEST_COLUMN: f64 = 1e-6;

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

    /// The same of a vector that is zero outside a range, a union of blocks.
    ///
    /// # Arguments
    /// - `rows`: read inside the range alone.
    #[must_use]
    pub fn white_part(&self, rows: &[f64], range: &Range<usize>) -> RowVector {
        let mut values = rows[range.clone()].to_vec();
        self.covariance.whiten_rows(range, &mut values);
        RowVector {
            first: range.start,
            values,
        }
    }

    /// One white vector or two of the same rows, made orthonormal when projected, not projected, and the length of the first when projected; `None` if the
    /// baseline, or the first, leaves less than a share of one's length.
    ///
    #[must_use]
    pub fn orthonormal(
        &self,
        white: impl IntoIterator<Item = RowVector>,
        least: f64,
    ) -> Option<(Vec<RowVector>, f64)> {
        // Each with its products with the baseline: what that leaves of a vector is written out only where these cancel.
        let mut units: Vec<(RowVector, Vec<f64>)> = Vec::new();
        let mut length = 0.0;
        for mut white in white {
            let before = dot(&white.values, &white.values);
            let mut absorbed = self.along_basis(&white);
            for (unit, of_unit) in &units {
                let share = unit.dot_part(&white) - dot(of_unit, &absorbed);
                subtract(&mut white.values, share, &unit.values);
                subtract(&mut absorbed, share, of_unit);
            }
            let mut after = dot(&white.values, &white.values) - dot(&absorbed, &absorbed);
            if after <= CANCELLED * before {
                let mut left = white.whole(self.length);
                self.project(&mut left);
                after = dot(&left, &left);
            }
            if !(after > least * least * before && after > 0.0) {
                return None;
            }
            let after = after.sqrt();
            for value in white.values.iter_mut().chain(&mut absorbed) {
                *value /= after;
            }
            if units.is_empty() {
                length = after;
            }
            units.push((white, absorbed));
        }
        Some((units.into_iter().map(|(unit, _)| unit).collect(), length))
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
    pub fn along_basis(&self, white: &RowVector) -> Vec<f64> {
        self.basis.iter().map(|column| white.dot(column)).collect()
    }

    /// A vector of rows made white and projected.
    #[must_use]
    pub fn projected(&self, rows: &[f64]) -> Vec<f64> {
        let mut white = self.white(rows);
        self.project(&mut white);
        white
    }
}
