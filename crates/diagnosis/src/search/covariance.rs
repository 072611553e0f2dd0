//! The covariance of the rows, and the transform that makes them white.

use std::ops::Range;

use nalgebra::DMatrix;

use stiffbench_numeric::simd::{sums_side_by_side, widest};

use super::symmetric_root::symmetric_root;

/// Largest rank within a block.
const MOST_COLUMNS: usize = 64;

/// A covariance V = D^(1/2) R D^(1/2) + U Uᵀ within blocks of rows, and the transform W with Wᵀ W = V⁻¹.
///
/// D is diagonal, U of low rank, and R that of a first-order autoregressive process (Box, Jenkins, Reinsel & Ljung, Time Series Analysis, 5th
/// edition, section 3.2): what a row has in common with the row before it. Its inverse is Fᵀ F with a bidiagonal F.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    blocks: Vec<CovarianceBlock>,
    /// D^(-1/2).
    weights: Vec<f64>,
    /// Correlation of each row's own error with that of the row before it; empty where there is none.
    memory: Vec<f64>,
    /// ln det V.
    log_determinant: f64,
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
    /// - `blocks`: U, at most 64 columns in each block, in the order of the rows.
    #[must_use]
    pub fn new(variances: &[f64], blocks: impl IntoIterator<Item = LowRankBlock>) -> Self {
        Self::with_memory(variances, Vec::new(), blocks)
    }

    /// The same with errors that remember the row before them.
    ///
    /// # Arguments
    /// - `memory`: correlation of each row's own error with that of the row before it, between -1 and 1, zero in the first row of each block;
    ///   empty where there is none.
    #[must_use]
    pub fn with_memory(
        variances: &[f64],
        memory: Vec<f64>,
        blocks: impl IntoIterator<Item = LowRankBlock>,
    ) -> Self {
        let weights: Vec<f64> = variances.iter().map(|v| v.sqrt().recip()).collect();
        let mut log_determinant: f64 = weights.iter().map(|weight| -2.0 * weight.ln()).sum();
        log_determinant += memory.iter().map(|rho| (-rho * rho).ln_1p()).sum::<f64>();
        let of_block = |block| {
            let (block, of_block) = CovarianceBlock::new(block, &weights, &memory);
            log_determinant += of_block;
            block
        };
        let blocks = blocks.into_iter().map(of_block).collect();
        Self {
            blocks,
            weights,
            memory,
            log_determinant,
        }
    }

    /// Rows without correlation, all with one standard deviation above zero.
    #[must_use]
    pub fn equal(rows: usize, standard_deviation: f64) -> Self {
        Self::new(&vec![standard_deviation.powi(2); rows], [])
    }

    /// ln det V.
    #[must_use]
    pub fn log_determinant(&self) -> f64 {
        self.log_determinant
    }

    /// D^(-1/2), one a row.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Ranges of rows that are correlated with no others.
    pub fn block_rows(&self) -> impl Iterator<Item = &Range<usize>> {
        self.blocks.iter().map(|block| &block.rows)
    }

    /// The inverse without what blocks have in common, D^(-1/2) Fᵀ F D^(-1/2): its diagonal, and its entries between each row and the next,
    /// one fewer; those are none without memory.
    #[must_use]
    pub fn inverse_bands(&self) -> [Vec<f64>; 2] {
        let squares = self.weights.iter().map(|weight| weight * weight);
        if self.memory.is_empty() {
            return [squares.collect(), Vec::new()];
        }
        let gain = |rho: &f64| (1.0 - rho * rho).recip();
        let after = self.memory[1..].iter().map(|rho| rho * rho * gain(rho));
        let own = self.memory.iter().map(gain).zip(after.chain([0.0]));
        let diagonal = squares.zip(own).map(|(w, (own, after))| w * (own + after));
        let beside = self.memory[1..].iter().zip(self.weights.windows(2));
        let beside = beside.map(|(rho, w)| -rho * gain(rho) * w[0] * w[1]);
        [diagonal.collect(), beside.collect()]
    }

    /// Columns E with V⁻¹ = D^(-1/2) Fᵀ F D^(-1/2) - E Eᵀ, block by block in the order of the rows.
    #[must_use]
    pub fn inverse_columns(&self) -> Vec<LowRankBlock> {
        let of_block = |block: &CovarianceBlock| {
            let (rows, n) = (block.rows.clone(), block.rows.len());
            let mut columns = block.inverse_columns();
            for column in columns.chunks_mut(n) {
                if !self.memory.is_empty() {
                    innovations_transposed(&self.memory[rows.clone()], column);
                }
                for (value, weight) in column.iter_mut().zip(&self.weights[rows.clone()]) {
                    *value *= weight;
                }
            }
            LowRankBlock { rows, columns }
        };
        self.blocks.iter().map(of_block).collect()
    }

    /// D^(1/2) R D^(1/2) times a vector, in place: the covariance without what blocks have in common.
    pub fn own_part(&self, vector: &mut [f64]) {
        for (value, weight) in vector.iter_mut().zip(&self.weights) {
            *value /= weight;
        }
        if !self.memory.is_empty() {
            // R = F⁻¹ F⁻ᵀ.
            for row in (0..vector.len()).rev() {
                let later = row + 1;
                if later < vector.len() {
                    let rho = self.memory[later];
                    vector[row] += rho * vector[later] / (1.0 - rho * rho).sqrt();
                }
                vector[row] *= (1.0 - self.memory[row].powi(2)).sqrt();
            }
            remembered(&self.memory, vector);
        }
        for (value, weight) in vector.iter_mut().zip(&self.weights) {
            *value /= weight;
        }
    }

    /// W times a vector of rows, in place.
    pub fn whiten(&self, vector: &mut [f64]) {
        for (value, weight) in vector.iter_mut().zip(&self.weights) {
            *value *= weight;
        }
        if !self.memory.is_empty() {
            innovations(&self.memory, vector);
        }
        Self::symmetric(self.blocks.iter(), vector);
    }

    /// W times the part of a vector that lies in `rows`, a union of blocks, in place; the rest is left alone.
    pub fn whiten_part(&self, vector: &mut [f64], rows: &Range<usize>) {
        for (value, weight) in vector[rows.clone()]
            .iter_mut()
            .zip(&self.weights[rows.clone()])
        {
            *value *= weight;
        }
        if !self.memory.is_empty() {
            innovations(&self.memory[rows.clone()], &mut vector[rows.clone()]);
        }
        let first = self
            .blocks
            .partition_point(|block| block.rows.start < rows.start);
        let blocks = self.blocks[first..]
            .iter()
            .take_while(|block| block.rows.end <= rows.end);
        Self::symmetric(blocks, vector);
    }

    /// Wᵀ times a white vector, in place.
    pub fn whiten_transposed(&self, vector: &mut [f64]) {
        Self::symmetric(self.blocks.iter(), vector);
        if !self.memory.is_empty() {
            innovations_transposed(&self.memory, vector);
        }
        for (value, weight) in vector.iter_mut().zip(&self.weights) {
            *value *= weight;
        }
    }

    /// W⁻¹ times a white vector, in place.
    pub fn unwhiten(&self, vector: &mut [f64]) {
        Self::symmetric(self.blocks.iter(), vector);
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
        if !self.memory.is_empty() {
            remembered(&self.memory, vector);
        }
        for (value, weight) in vector.iter_mut().zip(&self.weights) {
            *value /= weight;
        }
    }

    fn symmetric<'b>(blocks: impl Iterator<Item = &'b CovarianceBlock>, vector: &mut [f64]) {
        widest(
            #[inline(always)]
            || {
                for block in blocks {
                    block.symmetric(vector);
                }
            },
        );
    }
}

impl CovarianceBlock {
    /// The block and its part of ln det V.
    fn new(block: LowRankBlock, weights: &[f64], memory: &[f64]) -> (Self, f64) {
        let LowRankBlock { rows, mut columns } = block;
        let n = rows.len();
        for column in columns.chunks_mut(n) {
            for (value, weight) in column.iter_mut().zip(&weights[rows.clone()]) {
                *value *= weight;
            }
            if !memory.is_empty() {
                innovations(&memory[rows.clone()], column);
            }
        }
        let rank = columns.len() / n;
        let (inner, log_determinant) = symmetric_root(&gram(&columns, n));
        let mut weighted = vec![0.0; rank * n];
        for i in 0..rank {
            for j in 0..rank {
                let share = inner[(j, i)];
                for row in 0..n {
                    weighted[i * n + row] += columns[j * n + row] * share;
                }
            }
        }
        debug_assert!(rank <= MOST_COLUMNS);
        let block = Self {
            rows,
            columns,
            weighted,
            rank,
        };
        (block, log_determinant)
    }

    /// The symmetric root of (I + columns columnsᵀ)⁻¹ times its part of a vector, in place.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it is compiled for the instructions of its caller"
    )]
    fn symmetric(&self, vector: &mut [f64]) {
        let part = &mut vector[self.rows.clone()];
        let n = part.len();
        let mut products = [0.0; MOST_COLUMNS];
        for (product, column) in products.iter_mut().zip(self.columns.chunks(n)) {
            *product = sums_side_by_side(column, part);
        }
        for (product, column) in products.iter().zip(self.weighted.chunks(n)) {
            for (value, w) in part.iter_mut().zip(column) {
                *value -= w * product;
            }
        }
    }

    /// C L⁻ᵀ with C = F D^(-1/2) U and I + Cᵀ C = L Lᵀ: (I + C Cᵀ)⁻¹ = I - C L⁻ᵀ L⁻¹ Cᵀ.
    fn inverse_columns(&self) -> Vec<f64> {
        let n = self.rows.len();
        let gram = gram(&self.columns, n) + DMatrix::identity(self.rank, self.rank);
        let lower = gram.cholesky().map(nalgebra::Cholesky::unpack);
        let mut out = self.columns.clone();
        for i in 0..self.rank {
            let (before, rest) = out.split_at_mut(i * n);
            let column = &mut rest[..n];
            // Without a factor, which only numbers that are not finite can lack, the result is not finite either.
            let entry = |j: usize| lower.as_ref().map_or(f64::NAN, |lower| lower[(i, j)]);
            for (j, earlier) in before.chunks(n).enumerate() {
                for (value, other) in column.iter_mut().zip(earlier) {
                    *value -= entry(j) * other;
                }
            }
            for value in column {
                *value /= entry(i);
            }
        }
        out
    }
}

/// F times rows of standard deviation one, in place: what each does not share with the row before it, of standard deviation one.
fn innovations(memory: &[f64], rows: &mut [f64]) {
    let mut before = 0.0;
    for (value, rho) in rows.iter_mut().zip(memory) {
        let own = *value;
        *value = (own - rho * before) / (1.0 - rho * rho).sqrt();
        before = own;
    }
}

/// Fᵀ times rows, in place.
fn innovations_transposed(memory: &[f64], rows: &mut [f64]) {
    for row in 0..rows.len() {
        let gain = |row: usize| (1.0 - memory[row].powi(2)).sqrt().recip();
        let later = row + 1;
        let after = if later < rows.len() {
            memory[later] * gain(later) * rows[later]
        } else {
            0.0
        };
        rows[row] = gain(row) * rows[row] - after;
    }
}

/// F⁻¹ times rows, in place.
fn remembered(memory: &[f64], rows: &mut [f64]) {
    let mut before = 0.0;
    for (value, rho) in rows.iter_mut().zip(memory) {
        *value = rho * before + (1.0 - rho * rho).sqrt() * *value;
        before = *value;
    }
}

/// Products of columns of `n` numbers with each other.
fn gram(columns: &[f64], n: usize) -> DMatrix<f64> {
    let rank = columns.len() / n;
    let column = |index: usize| &columns[index * n..(index + 1) * n];
    DMatrix::from_fn(rank, rank, |i, j| {
        column(i).iter().zip(column(j)).map(|(a, b)| a * b).sum()
    })
}
