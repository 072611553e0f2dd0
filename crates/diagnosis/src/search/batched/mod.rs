//! The fast engine: moments of shapes without making them white, and null samples over low-rank bases.
//!
//! With s a shape, V the covariance of the rows and B the orthonormal white columns of the baseline,
//!
//! ```text
//!   ‖P W s‖² = sᵀ V⁻¹ s - ‖Bᵀ W s‖²,    sᵀ V⁻¹ s = sᵀ K s - ‖Eᵀ s‖²    (a few columns E for each block)
//! ```
//!
//! so that a shape costs one product with each column, and no memory; where no row remembers the row before it, K is diagonal.

mod block_basis;
mod low_rank;
mod null_table;

use std::ops::Range;

use rayon::prelude::*;

use stiffbench_numeric::simd::{sums_side_by_side, widest};

use super::constants::{CANCELLED, SAMPLES_TOGETHER};
use super::covariance::LowRankBlock;
use super::engine::{Moments, NullMaxima, NullShapes, PairMoments, ScoreEngine};
use super::null_noise::NullNoise;
use super::vectors::dot;
use super::white_space::WhiteSpace;
use null_table::{NullScratch, NullTable};

/// Scores by products with a few columns of each block of rows.
#[derive(Debug)]
pub struct Batched<'a> {
    space: &'a WhiteSpace,
    /// K, the inverse of the covariance without what blocks have in common, where it is diagonal.
    weights: Vec<f64>,
    /// E, one after the other.
    blocks: Vec<LowRankBlock>,
    /// Wᵀ B.
    absorbed: Vec<Vec<f64>>,
    /// Wᵀ times the white residual, and that itself.
    residual: Vec<f64>,
    white_residual: &'a [f64],
}

impl<'a> Batched<'a> {
    /// # Arguments
    /// - `white_residual`: the residuals, white and projected.
    #[must_use]
    pub fn new(space: &'a WhiteSpace, white_residual: &'a [f64]) -> Self {
        let covariance = &space.covariance;
        let rows = covariance.weights().len();
        let back = |white: &[f64]| {
            let mut out = white[..rows].to_vec();
            covariance.whiten_transposed(&mut out);
            out
        };
        Self {
            weights: covariance.weights().iter().map(|w| w * w).collect(),
            blocks: covariance.inverse_columns(),
            absorbed: space.basis().iter().map(|column| back(column)).collect(),
            residual: back(white_residual),
            white_residual,
            space,
        }
    }

    /// Products with the columns, appended; and sᵀ K s.
    fn shares(&self, whole: &[f64], range: &Range<usize>, out: &mut Vec<f64>) -> f64 {
        widest(
            #[inline(always)]
            || self.shares_in_lanes(whole, range, out),
        )
    }

    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it is compiled for the instructions of its caller"
    )]
    fn shares_in_lanes(&self, whole: &[f64], range: &Range<usize>, out: &mut Vec<f64>) -> f64 {
        let values = &whole[range.clone()];
        let first = self
            .blocks
            .partition_point(|block| block.rows.end <= range.start);
        let blocks = self.blocks[first..]
            .iter()
            .take_while(|block| block.rows.start < range.end);
        for block in blocks {
            let part = &whole[block.rows.clone()];
            for column in block.columns.chunks_exact(part.len()) {
                out.push(short_dot(column, part));
            }
        }
        for column in &self.absorbed {
            out.push(sums_side_by_side(&column[range.clone()], values));
        }
        self.own_product([whole, whole], range)
    }

    /// sᵀ K t of vectors that are zero outside a range.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it is compiled for the instructions of its caller"
    )]
    fn own_product(&self, [s, t]: [&[f64]; 2], range: &Range<usize>) -> f64 {
        let covariance = &self.space.covariance;
        if covariance.is_without_correlation() {
            let weights = &self.weights[range.clone()];
            triple(weights, &s[range.clone()], &t[range.clone()])
        } else {
            covariance.own_product([s, t], range)
        }
    }

    /// White and projected.
    fn projected(&self, shape: &[f64], rows: &Range<usize>) -> Vec<f64> {
        let mut whole = vec![0.0; self.weights.len()];
        whole[rows.clone()].copy_from_slice(&shape[rows.clone()]);
        self.space.projected(&whole)
    }
}

impl ScoreEngine for Batched<'_> {
    fn moments(&self, shape: &[f64], rows: &Range<usize>, scratch: &mut Vec<f64>) -> Moments {
        scratch.clear();
        let whole = self.shares(shape, rows, scratch);
        let square = whole - dot(scratch, scratch);
        if square < CANCELLED * whole {
            return Moments::of_white(&self.projected(shape, rows), self.white_residual);
        }
        Moments {
            square,
            product: dot(&shape[rows.clone()], &self.residual[rows.clone()]),
        }
    }

    fn pair_moments(
        &self,
        shapes: [&[f64]; 2],
        rows: &Range<usize>,
        scratch: &mut Vec<f64>,
    ) -> PairMoments {
        scratch.clear();
        let wholes = shapes.map(|shape| self.shares(shape, rows, scratch));
        let mut squares = wholes;
        let columns = scratch.len() / 2;
        let (of_first, of_second) = scratch.split_at(columns);
        squares[0] -= dot(of_first, of_first);
        squares[1] -= dot(of_second, of_second);
        let both = self.own_product(shapes, rows) - dot(of_first, of_second);
        let residual = &self.residual[rows.clone()];
        let [first, second] = shapes.map(|shape| dot(&shape[rows.clone()], residual));
        let square = squares[1] - both * both / squares[0];
        if squares[0] < CANCELLED * wholes[0] || square.is_nan() || square < CANCELLED * wholes[1] {
            let [first, second] = shapes.map(|shape| self.projected(shape, rows));
            return PairMoments::of_white(&first, &second, self.white_residual, CANCELLED);
        }
        PairMoments {
            first: Moments {
                square: squares[0],
                product: first,
            },
            second: Moments {
                square,
                product: second - both / squares[0] * first,
            },
        }
    }

    fn null_maxima(
        &self,
        groups: Vec<NullShapes<'_>>,
        families: usize,
        blocks: &[Range<usize>],
        noise: &NullNoise<'_>,
    ) -> NullMaxima {
        let table = NullTable::new(self.space, blocks, families, groups);
        let maxima: Vec<Vec<[f32; SAMPLES_TOGETHER]>> = (0..noise.blocks())
            .into_par_iter()
            .map_init(NullScratch::default, |scratch, block| {
                table.maxima(&mut noise.block(block, self.space.length), scratch)
            })
            .collect();
        let of_family = |family: usize| {
            let blocks = maxima.iter();
            let all = blocks.flat_map(|block: &Vec<_>| block[family].map(f64::from));
            all.collect()
        };
        (0..families).map(of_family).collect()
    }
}

/// Scalar product of as many numbers as a block has, four sums side by side.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "it is compiled for the instructions of its caller"
)]
fn short_dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a, b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = a.remainder().iter().zip(b.remainder());
    let rest: f64 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for lane in 0..4 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Σ a b c, eight sums side by side.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "it is compiled for the instructions of its caller"
)]
fn triple(a: &[f64], b: &[f64], c: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let whole = a.len() - a.len() % 8;
    let chunks = a
        .chunks_exact(8)
        .zip(b.chunks_exact(8))
        .zip(c.chunks_exact(8));
    for ((a, b), c) in chunks {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane] * c[lane];
        }
    }
    let rest = (whole..a.len()).map(|place| a[place] * b[place] * c[place]);
    sums.iter().sum::<f64>() + rest.sum::<f64>()
}
