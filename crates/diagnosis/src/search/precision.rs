//! The inverse of a covariance, for likelihoods: without the transform that makes rows white.

use std::ops::Range;

use stiffbench_numeric::simd::{sums_side_by_side, widest};

use super::covariance::{LowRankBlock, inverse_block};
use super::serial_correlation::{RowErrors, SerialFilter};

/// V⁻¹ = K - E Eᵀ of a covariance V (`Covariance`): K = D^(-1/2) Fᵀ F D^(-1/2) mixes rows of one series, E is of low rank within blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct Precision {
    /// D^(-1/2).
    weights: Vec<f64>,
    /// F.
    serial: SerialFilter,
    /// E.
    blocks: Vec<LowRankBlock>,
    /// ln det V.
    log_determinant: f64,
}

impl Precision {
    /// # Arguments
    /// - `variances`, `errors`, `blocks`: those of the covariance; the blocks hold all rows.
    #[must_use]
    pub fn new(
        variances: &[f64],
        errors: &RowErrors,
        blocks: impl IntoIterator<Item = LowRankBlock>,
    ) -> Self {
        let weights: Vec<f64> = variances.iter().map(|v| v.sqrt().recip()).collect();
        let serial = SerialFilter::new(errors);
        let mut log_determinant = serial.log_determinant;
        log_determinant += variances.iter().map(|v| v.ln()).sum::<f64>();
        let of_block = |block: LowRankBlock| {
            let white = block.white(&weights, &serial);
            let (block, of_block) = inverse_block(white, &weights, &serial);
            log_determinant += of_block;
            block
        };
        let blocks = blocks.into_iter().map(of_block).collect();
        Self {
            weights,
            serial,
            blocks,
            log_determinant,
        }
    }

    /// ln det V.
    #[must_use]
    pub fn log_determinant(&self) -> f64 {
        self.log_determinant
    }

    /// Adds Xᵀ V⁻¹ X over some rows to a matrix, below and on its diagonal.
    ///
    /// # Arguments
    /// - `rows`: a union of blocks.
    /// - `columns`: X.
    /// - `sums`: row by row, as wide as X.
    pub fn add_products(&self, rows: &Range<usize>, columns: &SparseRows<'_>, sums: &mut [f64]) {
        let size = columns.count();
        let first = self
            .blocks
            .partition_point(|block| block.rows.start < rows.start);
        let blocks = self.blocks[first..]
            .iter()
            .take_while(|block| block.rows.end <= rows.end);
        // Xᵀ E, a row for each column of X.
        let mut common = vec![Vec::new(); size];
        for block in blocks {
            let of_block = block.rows.start - rows.start..block.rows.end - rows.start;
            if self.serial.is_identity() {
                for (row, weight) in of_block.clone().zip(&self.weights[block.rows.clone()]) {
                    columns.for_each(row, |i, left| {
                        let left = weight * weight * left;
                        columns.for_each(row, |j, right| sums[i * size + j] += left * right);
                    });
                }
            } else {
                self.add_products_in_series(block, (&of_block, columns), sums);
            }
            for column in block.columns.chunks(of_block.len()) {
                for products in &mut common {
                    products.push(0.0);
                }
                let place = common.first().map_or(0, |products| products.len() - 1);
                let rows = of_block.clone().zip(column);
                for (row, value) in rows.filter(|(_, value)| **value != 0.0) {
                    columns.for_each(row, |i, x| common[i][place] += value * x);
                }
            }
        }
        widest(
            #[inline(always)]
            || {
                for (i, left) in common.iter().enumerate() {
                    for (sum, right) in sums[i * size..=i * size + i].iter_mut().zip(&common) {
                        *sum -= sums_side_by_side(left, right);
                    }
                }
            },
        );
    }

    /// The part of K where rows remember those before them.
    fn add_products_in_series(
        &self,
        block: &LowRankBlock,
        (of_block, columns): (&Range<usize>, &SparseRows<'_>),
        sums: &mut [f64],
    ) {
        let size = columns.count();
        let weights = &self.weights[block.rows.clone()];
        let white = |column: &&[f64]| {
            let weighted = column[of_block.clone()].iter().zip(weights);
            let mut white: Vec<f64> = weighted.map(|(value, weight)| value * weight).collect();
            self.serial.innovations(&block.rows, &mut white);
            white
        };
        let further: Vec<Vec<f64>> = columns.further.iter().map(white).collect();
        for (i, left) in (columns.one_columns..).zip(&further) {
            for (j, right) in (columns.one_columns..=i).zip(&further) {
                sums[i * size + j] += left.iter().zip(right).map(|(a, b)| a * b).sum::<f64>();
            }
        }
        let Some(ones) = columns.ones.get(of_block.clone()) else {
            return;
        };
        self.serial
            .for_each_row(&block.rows, |row, places, entries| {
                for (behind, (&place, entry)) in places.iter().zip(entries).enumerate() {
                    let (one, left) = (ones[place], entry * weights[place]);
                    for (i, white) in (columns.one_columns..).zip(&further) {
                        sums[i * size + one] += white[row] * left;
                    }
                    for (&before, entry) in places[..behind].iter().zip(entries) {
                        let (i, j) = (one.max(ones[before]), one.min(ones[before]));
                        let both = left * entry * weights[before];
                        sums[i * size + j] += if i == j { 2.0 * both } else { both };
                    }
                    sums[one * size + one] += left * left;
                }
            });
    }
}

/// Rows of a matrix: each has a one in one of the first columns, if there are such columns, and what further columns have there.
pub struct SparseRows<'a> {
    /// For each row the column that has a one there; empty without such columns.
    pub ones: &'a [usize],
    /// How many such columns there are.
    pub one_columns: usize,
    /// Further columns.
    pub further: &'a [&'a [f64]],
}

impl SparseRows<'_> {
    /// Number of columns.
    #[must_use]
    pub fn count(&self) -> usize {
        self.one_columns + self.further.len()
    }

    #[inline]
    fn for_each(&self, row: usize, mut action: impl FnMut(usize, f64)) {
        if let Some(one) = self.ones.get(row) {
            action(*one, 1.0);
        }
        for (place, column) in self.further.iter().enumerate() {
            action(self.one_columns + place, column[row]);
        }
    }
}
