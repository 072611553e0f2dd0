//! The covariance of the rows, and the transform that makes them white.

use std::ops::Range;

use nalgebra::DMatrix;

use stiffbench_numeric::simd::{sums_side_by_side, widest};

use super::serial_correlation::{RowErrors, SerialFilter};
use super::symmetric_root::symmetric_root;
use super::vectors::{RowVector, divide, multiply};

/// Rank within a block up to which products need no memory of their own.
const FEW_COLUMNS: usize = 64;

/// A covariance V = D^(1/2) R D^(1/2) + U Uᵀ within blocks of rows, and the transform W with Wᵀ W = V⁻¹.
///
/// D is diagonal, U of low rank, and R holds what rows have in common with the rows before them: R⁻¹ = Fᵀ F (`SerialFilter`).
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    blocks: Vec<CovarianceBlock>,
    /// D^(-1/2).
    weights: Vec<f64>,
    /// F.
    serial: SerialFilter,
}

/// Rows that are correlated with each other and with no others.
#[derive(Debug, Clone, PartialEq)]
pub struct LowRankBlock {
    /// The rows.
    pub rows: Range<usize>,
    /// Columns, each as long as the block, one after the other.
    pub columns: Vec<f64>,
}

/// A block and its part of the transform.
#[derive(Debug, Clone, PartialEq)]
struct CovarianceBlock {
    rows: Range<usize>,
    /// Columns of F D^(-1/2) U, one after the other.
    columns: Vec<f64>,
    /// The same times the matrix that makes (I - columns · this) the symmetric root of (I + columns columnsᵀ)⁻¹.
    weighted: Vec<f64>,
    rank: usize,
}

impl Covariance {
    /// # Arguments
    /// - `variances`: D, above zero.
    /// - `blocks`: U, in the order of the rows.
    #[must_use]
    pub fn new(variances: &[f64], blocks: impl IntoIterator<Item = LowRankBlock>) -> Self {
        Self::with_errors(variances, &RowErrors::Correlated(Vec::new()), blocks)
    }

    /// The same with errors that rows have in common with those before them.
    ///
    /// # Arguments
    /// - `errors`: R; a series begins with each block.
    #[must_use]
    pub fn with_errors(
        variances: &[f64],
        errors: &RowErrors,
        blocks: impl IntoIterator<Item = LowRankBlock>,
    ) -> Self {
        let weights: Vec<f64> = variances.iter().map(|v| v.sqrt().recip()).collect();
        let serial = SerialFilter::new(errors);
        let white = blocks
            .into_iter()
            .map(|block| block.white(&weights, &serial));
        Self {
            blocks: white.map(CovarianceBlock::of_white).collect(),
            weights,
            serial,
        }
    }

    /// Rows without correlation, all with one standard deviation above zero.
    #[must_use]
    pub fn equal(rows: usize, standard_deviation: f64) -> Self {
        Self::new(&vec![standard_deviation.powi(2); rows], [])
    }

    /// The same for rows of which some weigh nothing: as if they had an infinite variance.
    #[must_use]
    pub fn without(&self, left_out: &[bool]) -> Self {
        let drop = |rows: &Range<usize>, values: &mut [f64]| {
            for (value, left_out) in values.iter_mut().zip(&left_out[rows.clone()]) {
                *value = if *left_out { 0.0 } else { *value };
            }
        };
        let of_block = |block: &CovarianceBlock| {
            let (rows, mut columns) = (block.rows.clone(), block.columns.clone());
            for column in columns.chunks_mut(rows.len()) {
                self.serial.remembered(&rows, column);
                drop(&rows, column);
                self.serial.innovations(&rows, column);
            }
            CovarianceBlock::of_white(LowRankBlock { rows, columns })
        };
        let mut weights = self.weights.clone();
        drop(&(0..weights.len()), &mut weights);
        Self {
            blocks: self.blocks.iter().map(of_block).collect(),
            weights,
            serial: self.serial.clone(),
        }
    }

    /// D^(-1/2), one a row.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Length of some rows by their own errors alone: what errors that rows share take nothing of.
    pub(crate) fn own_length(&self, rows: &[f64], range: &Range<usize>) -> f64 {
        let both = rows[range.clone()].iter().zip(&self.weights[range.clone()]);
        both.map(|(row, weight)| (row * weight).powi(2))
            .sum::<f64>()
            .sqrt()
    }

    /// Ranges of rows that are correlated with no others.
    pub fn block_rows(&self) -> impl Iterator<Item = &Range<usize>> {
        self.blocks.iter().map(|block| &block.rows)
    }

    /// Whether no row remembers the row before it.
    #[must_use]
    pub fn is_without_correlation(&self) -> bool {
        self.serial.is_identity()
    }

    /// Product of two vectors with the inverse without what blocks have in common, aᵀ D^(-1/2) Fᵀ F D^(-1/2) b; zero outside a range.
    #[must_use]
    pub fn own_product(&self, vectors: [&[f64]; 2], range: &Range<usize>) -> f64 {
        self.serial.product(vectors, &self.weights, range)
    }

    /// Columns E with V⁻¹ = D^(-1/2) Fᵀ F D^(-1/2) - E Eᵀ, block by block in the order of the rows.
    #[must_use]
    pub fn inverse_columns(&self) -> Vec<LowRankBlock> {
        let of_block = |block: &CovarianceBlock| {
            let (rows, columns) = (block.rows.clone(), block.columns.clone());
            let white = LowRankBlock { rows, columns };
            inverse_block(white, &self.weights, &self.serial).0
        };
        self.blocks.iter().map(of_block).collect()
    }

    /// D^(1/2) R D^(1/2) times a vector, in place: the covariance without what blocks have in common.
    pub fn own_part(&self, vector: &mut [f64]) {
        divide(vector, &self.weights);
        // R = F⁻¹ F⁻ᵀ.
        let all = 0..vector.len();
        self.serial.remembered_transposed(&all, vector);
        self.serial.remembered(&all, vector);
        divide(vector, &self.weights);
    }

    /// W times a vector of rows, in place.
    pub fn whiten(&self, vector: &mut [f64]) {
        multiply(vector, &self.weights);
        self.serial.innovations(&(0..vector.len()), vector);
        Self::symmetric(self.blocks.iter(), 0, vector);
    }

    /// W times a vector that is zero outside some rows, in place.
    ///
    /// # Arguments
    /// - `rows`: a union of blocks.
    /// - `values`: one for each of them.
    pub fn whiten_rows(&self, rows: &Range<usize>, values: &mut [f64]) {
        self.whiten_own(rows, values);
        let first = self
            .blocks
            .partition_point(|block| block.rows.start < rows.start);
        let blocks = self.blocks[first..]
            .iter()
            .take_while(|block| block.rows.end <= rows.end);
        Self::symmetric(blocks, rows.start, values);
    }

    /// W times a vector of some rows: it has all rows of the blocks that these lie in.
    #[must_use]
    pub fn whiten_vector(&self, vector: &RowVector) -> RowVector {
        let rows = vector.rows();
        let first = self
            .blocks
            .partition_point(|block| block.rows.end <= rows.start);
        let behind = self
            .blocks
            .partition_point(|block| block.rows.start < rows.end);
        let blocks = self.blocks.get(first..behind).unwrap_or_default();
        let start = blocks.first().map_or(rows.start, |block| block.rows.start);
        let end = blocks.last().map_or(rows.end, |block| block.rows.end);
        let rows = start.min(rows.start)..end.max(rows.end);
        let mut values = vector.part(&rows).into_owned();
        self.whiten_rows(&rows, &mut values);
        RowVector {
            first: rows.start,
            values,
        }
    }

    /// F D^(-1/2) times some rows, in place: white, but for what blocks have in common.
    ///
    /// # Arguments
    /// - `rows`: whole series.
    /// - `values`: one for each of them.
    pub fn whiten_own(&self, rows: &Range<usize>, values: &mut [f64]) {
        multiply(values, &self.weights[rows.clone()]);
        self.serial.innovations(rows, values);
    }

    /// Wᵀ times a white vector, in place.
    pub fn whiten_transposed(&self, vector: &mut [f64]) {
        Self::symmetric(self.blocks.iter(), 0, vector);
        let all = 0..vector.len();
        self.serial.innovations_transposed(&all, vector);
        multiply(vector, &self.weights);
    }

    /// W⁻¹ times a white vector, in place.
    pub fn unwhiten(&self, vector: &mut [f64]) {
        Self::symmetric(self.blocks.iter(), 0, vector);
        // (I + C Cᵀ)^(1/2) = (I + C Cᵀ) (I + C Cᵀ)^(-1/2)
        for block in &self.blocks {
            let part = &mut vector[block.rows.clone()];
            let products: Vec<f64> = block
                .columns
                .chunks(part.len())
                .map(|column| column.iter().zip(part.iter()).map(|(c, x)| c * x).sum())
                .collect();
            for (product, column) in products.iter().zip(block.columns.chunks(part.len())) {
                for (value, c) in part.iter_mut().zip(column) {
                    *value += c * product;
                }
            }
        }
        let all = 0..vector.len();
        self.serial.remembered(&all, vector);
        divide(vector, &self.weights);
    }

    /// The part that blocks have in common, in values of rows from `first` on.
    fn symmetric<'b>(
        blocks: impl Iterator<Item = &'b CovarianceBlock>,
        first: usize,
        values: &mut [f64],
    ) {
        widest(
            #[inline(always)]
            || {
                for block in blocks {
                    let rows = block.rows.start - first..block.rows.end - first;
                    block.symmetric(&mut values[rows]);
                }
            },
        );
    }
}

impl LowRankBlock {
    /// F D^(-1/2) times its columns.
    pub(super) fn white(mut self, weights: &[f64], serial: &SerialFilter) -> Self {
        for column in self.columns.chunks_mut(self.rows.len()) {
            multiply(column, &weights[self.rows.clone()]);
            serial.innovations(&self.rows, column);
        }
        self
    }
}

impl CovarianceBlock {
    /// # Arguments
    /// - `white`: F D^(-1/2) U.
    fn of_white(white: LowRankBlock) -> Self {
        let LowRankBlock { rows, columns } = white;
        let n = rows.len();
        let rank = columns.len() / n;
        let inner = symmetric_root(&gram(&columns, n));
        let mut weighted = vec![0.0; rank * n];
        for i in 0..rank {
            for j in 0..rank {
                let share = inner[(j, i)];
                for row in 0..n {
                    weighted[i * n + row] += columns[j * n + row] * share;
                }
            }
        }
        Self {
            rows,
            columns,
            weighted,
            rank,
        }
    }

    /// The symmetric root of (I + columns columnsᵀ)⁻¹ times its part of a vector, in place.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it is compiled for the instructions of its caller"
    )]
    fn symmetric(&self, part: &mut [f64]) {
        let n = part.len();
        let (mut few, mut many) = ([0.0; FEW_COLUMNS], Vec::new());
        let products = if self.rank <= FEW_COLUMNS {
            &mut few[..self.rank]
        } else {
            many.resize(self.rank, 0.0);
            &mut many[..]
        };
        for (product, column) in products.iter_mut().zip(self.columns.chunks(n)) {
            *product = sums_side_by_side(column, part);
        }
        for (product, column) in products.iter().zip(self.weighted.chunks(n)) {
            for (value, w) in part.iter_mut().zip(column) {
                *value -= w * product;
            }
        }
    }
}

/// D^(-1/2) Fᵀ C L⁻ᵀ with I + Cᵀ C = L Lᵀ, so that (I + C Cᵀ)⁻¹ = I - C L⁻ᵀ L⁻¹ Cᵀ, and ln det (I + C Cᵀ).
///
/// # Arguments
/// - `white`: C.
pub(super) fn inverse_block(
    white: LowRankBlock,
    weights: &[f64],
    serial: &SerialFilter,
) -> (LowRankBlock, f64) {
    let LowRankBlock { rows, mut columns } = white;
    let n = rows.len();
    let mut gram = gram(&columns, n);
    let rank = gram.nrows();
    for i in 0..rank {
        gram[(i, i)] += 1.0;
    }
    let lower = gram.cholesky().map(nalgebra::Cholesky::unpack);
    // Without a factor, which only numbers that are not finite can lack, the result is not finite either.
    let entry = |i: usize, j: usize| lower.as_ref().map_or(f64::NAN, |lower| lower[(i, j)]);
    for i in 0..rank {
        let (before, rest) = columns.split_at_mut(i * n);
        let column = &mut rest[..n];
        for (j, earlier) in before.chunks(n).enumerate() {
            let share = entry(i, j);
            if share == 0.0 {
                continue;
            }
            for (value, other) in column.iter_mut().zip(earlier) {
                *value -= share * other;
            }
        }
        for value in column {
            *value /= entry(i, i);
        }
    }
    let log_determinant = (0..rank).map(|i| 2.0 * entry(i, i).ln()).sum();
    for column in columns.chunks_mut(n) {
        serial.innovations_transposed(&rows, column);
        multiply(column, &weights[rows.clone()]);
    }
    (LowRankBlock { rows, columns }, log_determinant)
}

/// Products of columns of `n` numbers with each other. In large blocks most columns are zero in most rows.
fn gram(columns: &[f64], n: usize) -> DMatrix<f64> {
    let rank = columns.len() / n;
    let column = |index: usize| &columns[index * n..(index + 1) * n];
    let rows: Vec<Range<usize>> = (0..rank).map(|index| not_zero(column(index))).collect();
    DMatrix::from_fn(rank, rank, |i, j| {
        let both = rows[i].start.max(rows[j].start)..rows[i].end.min(rows[j].end);
        let [a, b] = [i, j].map(|index| column(index).get(both.clone()).unwrap_or_default());
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    })
}

/// From the first number that is not zero to the last.
fn not_zero(column: &[f64]) -> Range<usize> {
    let first = column.iter().position(|value| *value != 0.0);
    let last = column.iter().rposition(|value| *value != 0.0);
    first
        .zip(last)
        .map_or(0..0, |(first, last)| first..last + 1)
}
