//! Null samples along thousands of vectors at once.
//!
//! What a white vector v gives on noise z is v·(z - B Bᵀ z), B the basis of the baseline. Vectors of one group span few directions in each
//! block of rows, so that products with the noise are taken once along those, and each vector is a sum over them. A vector counts only in
//! the blocks where it lives. Over all blocks most vectors of a group are nearly sums of a few of them: the group has a low-rank basis.
//!
//! Products are taken in single precision: seven digits of numbers that are compared with a critical value known to three.

use std::collections::BTreeMap;
use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use stiffbench_numeric::simd::sums_of_blocks;

use super::block_basis::{BlockBasis, Directions, Source, left_out};
use super::low_rank::LowRank;
use crate::search::constants::{LONG, SAMPLES_TOGETHER, VECTORS_TOGETHER};
use crate::search::engine::NullShape;
use crate::search::vectors::dot;
use crate::search::white_space::WhiteSpace;

/// All vectors, ready for noise.
#[derive(Debug)]
pub(super) struct NullTable {
    length: usize,
    families: usize,
    /// The basis of the baseline, column by column.
    absorbed: Vec<f32>,
    directions: Directions,
    parts: Vec<SamplePart>,
}

/// Noise along directions and along the low-rank basis of a part; memory of one thread.
#[derive(Debug, Default)]
pub(super) struct NullScratch {
    directions: Vec<[f32; SAMPLES_TOGETHER]>,
    basis: Vec<[f32; SAMPLES_TOGETHER]>,
}

/// What a block of samples gives.
pub(super) struct BlockMaxima {
    /// Largest Δχ² of each family.
    pub(super) families: Vec<[f32; SAMPLES_TOGETHER]>,
    /// Squared length of the projected noise.
    pub(super) squares: [f32; SAMPLES_TOGETHER],
}

/// Vectors of one group that live in the same blocks.
struct VectorGroup {
    shapes: Vec<NullShape>,
    /// Blocks by number, and the basis in each.
    bases: Vec<(usize, BlockBasis)>,
}

/// Vectors that are sums over the same directions.
#[derive(Debug)]
struct SamplePart {
    source: Source,
    /// Shares of the directions in a low-rank basis, one vector after the other; `None` if the vectors are sums over the directions.
    basis: Option<Vec<f32>>,
    /// Shares of the basis or else of the directions, vector by vector.
    shares: Vec<f32>,
    scores: Vec<VectorScore>,
}

/// What is asked of the product with a vector.
#[derive(Debug, Clone, Copy)]
struct VectorScore {
    family: usize,
    of: Of,
}

#[derive(Debug, Clone, Copy)]
enum Of {
    /// One vector; smallest and largest size.
    Size([f32; 2]),
    /// Vectors with a phase between them.
    FirstOfTwo,
    SecondOfTwo,
}

impl NullTable {
    /// # Arguments
    /// - `blocks`: ranges of rows within which vectors of a group are alike.
    /// - `families`: how many there are.
    pub(super) fn new(
        space: &WhiteSpace,
        blocks: &[Range<usize>],
        families: usize,
        mut shapes: Vec<NullShape>,
    ) -> Self {
        let prepare = |shape: &mut NullShape| {
            for unit in &mut shape.units {
                if dot(unit, unit) > LONG * LONG {
                    space.project(unit);
                }
            }
            lived_in(blocks, &shape.units)
        };
        let living: Vec<Vec<usize>> = shapes.par_iter_mut().map(prepare).collect();
        let mut alike: BTreeMap<(usize, Vec<usize>), Vec<NullShape>> = BTreeMap::new();
        for (shape, lived_in) in shapes.into_iter().zip(living) {
            let group = alike.entry((shape.group, lived_in)).or_default();
            group.push(shape);
        }
        let groups: Vec<VectorGroup> = alike
            .into_par_iter()
            .map(|((_, lived_in), shapes)| VectorGroup::new(&lived_in, shapes, blocks))
            .collect();
        let mut directions = Directions::new(blocks);
        let sources: Vec<Source> = groups
            .iter()
            .map(|group| directions.take_in(&group.bases))
            .collect();
        let parts = groups
            .into_par_iter()
            .zip(sources)
            .flat_map_iter(|(group, source)| group.parts(space, &source))
            .collect();
        let absorbed = space.basis().iter().flatten().map(|x| *x as f32).collect();
        Self {
            length: space.length,
            families,
            absorbed,
            directions,
            parts,
        }
    }

    /// Largest Δχ² of each family in each sample.
    ///
    /// # Arguments
    /// - `noise`: white noise, [`SAMPLES_TOGETHER`] samples of each row, one row after the other; overwritten.
    pub(super) fn maxima(&self, noise: &mut [f32], scratch: &mut NullScratch) -> BlockMaxima {
        self.project(noise);
        let (noise, _) = noise.as_chunks();
        let mut squares = [0.0_f32; SAMPLES_TOGETHER];
        for row in noise {
            for (square, value) in squares.iter_mut().zip(row) {
                *square += value * value;
            }
        }
        let mut families = vec![[0.0_f32; SAMPLES_TOGETHER]; self.families];
        self.directions.products(noise, &mut scratch.directions);
        for part in &self.parts {
            part.add_to(noise, scratch, &mut families);
        }
        BlockMaxima { families, squares }
    }

    fn project(&self, noise: &mut [f32]) {
        let columns = self.absorbed.len() / self.length;
        let basis = MatRef::from_column_major_slice(&self.absorbed, self.length, columns);
        let mut shares = vec![0.0; columns * SAMPLES_TOGETHER];
        let mut shares =
            MatMut::from_column_major_slice_mut(&mut shares, SAMPLES_TOGETHER, columns);
        let mut noise = MatMut::from_column_major_slice_mut(noise, SAMPLES_TOGETHER, self.length);
        let (all, shares) = (noise.as_ref(), &mut shares);
        matmul(shares.as_mut(), Accum::Replace, all, basis, 1.0, Par::Seq);
        let (shares, back) = (shares.as_ref(), basis.transpose());
        matmul(noise.as_mut(), Accum::Add, shares, back, -1.0, Par::Seq);
    }
}

/// The blocks in which vectors have rows that count.
fn lived_in(blocks: &[Range<usize>], units: &[Vec<f64>]) -> Vec<usize> {
    let left_out = left_out(blocks.len());
    let lives = |block: &Range<usize>| {
        let mut parts = units.iter().map(|unit| &unit[block.clone()]);
        parts.any(|part| dot(part, part) > left_out)
    };
    (0..blocks.len())
        .filter(|&block| lives(&blocks[block]))
        .collect()
}

/// Rows of a block from the first to the last that count in vectors.
fn lived_on(block: &Range<usize>, shapes: &[NullShape]) -> Range<usize> {
    let counts = |row: &usize| {
        let mut units = shapes.iter().flat_map(|shape| &shape.units);
        units.any(|unit| unit[*row] != 0.0)
    };
    let first = block.clone().find(counts).unwrap_or(block.end);
    let last = block.clone().rfind(counts).unwrap_or(block.start);
    first..last + 1
}

impl VectorGroup {
    fn new(lived_in: &[usize], shapes: Vec<NullShape>, blocks: &[Range<usize>]) -> Self {
        let basis = |block: &usize| match lived_in {
            [_] => BlockBasis::of_rows(&lived_on(&blocks[*block], &shapes)),
            _ => BlockBasis::new(&blocks[*block], blocks.len(), &shapes),
        };
        Self {
            bases: lived_in
                .iter()
                .map(|block| (*block, basis(block)))
                .collect(),
            shapes,
        }
    }

    fn parts(&self, space: &WhiteSpace, source: &Source) -> Vec<SamplePart> {
        let vectors: usize = self.shapes.iter().map(|shape| shape.units.len()).sum();
        let each = self
            .shapes
            .len()
            .div_ceil(vectors.div_ceil(VECTORS_TOGETHER).max(1));
        let parts = self.shapes.chunks(each);
        parts
            .map(|shapes| SamplePart::new(space, shapes, &self.bases, source.clone()))
            .collect()
    }
}

impl SamplePart {
    fn new(
        space: &WhiteSpace,
        shapes: &[NullShape],
        bases: &[(usize, BlockBasis)],
        source: Source,
    ) -> Self {
        let shares_of = |vector: &Vec<f64>| {
            let mut shares = Vec::new();
            for (_, basis) in bases {
                basis.add_shares(vector, &mut shares);
            }
            shares
        };
        let units = shapes.iter().flat_map(|shape| &shape.units);
        let shares: Vec<f64> = units.flat_map(shares_of).collect();
        let absorbed: Vec<f64> = space.basis().iter().flat_map(shares_of).collect();
        let directions = bases.iter().map(|(_, basis)| basis.count()).sum();
        let single = |shares: &[f64]| shares.iter().map(|x| *x as f32).collect::<Vec<f32>>();
        let (basis, shares) = match LowRank::new(directions, &shares, &absorbed) {
            Some(low_rank) => (Some(single(&low_rank.basis)), single(&low_rank.shares)),
            None => (None, single(&shares)),
        };
        Self {
            source,
            basis,
            shares,
            scores: shapes.iter().flat_map(VectorScore::of).collect(),
        }
    }

    fn add_to(
        &self,
        noise: &[[f32; SAMPLES_TOGETHER]],
        scratch: &mut NullScratch,
        largest: &mut [[f32; SAMPLES_TOGETHER]],
    ) {
        let mut along = match &self.source {
            Source::Rows(rows) => &noise[rows.clone()],
            Source::Directions(places) => &scratch.directions[places.clone()],
        };
        if along.is_empty() {
            return;
        }
        if let Some(basis) = &self.basis {
            scratch.basis.clear();
            sums_of_blocks(along, basis, |sums| scratch.basis.push(*sums));
            along = &scratch.basis;
        }
        let mut scores = self.scores.iter();
        let mut squares = [0.0; SAMPLES_TOGETHER];
        sums_of_blocks(
            along,
            &self.shares,
            #[inline(always)]
            |along| {
                if let Some(score) = scores.next() {
                    score.keep_largest(along, &mut squares, &mut largest[score.family]);
                }
            },
        );
    }
}

impl VectorScore {
    /// What is asked of the products with the vectors of one [`NullShape`].
    fn of(shape: &NullShape) -> impl Iterator<Item = Self> {
        let size = || {
            let length = shape.length as f32;
            Of::Size(shape.multiples.map(|scale| scale as f32 * length))
        };
        let of = match shape.units.len() {
            1 => vec![size()],
            _ => vec![Of::FirstOfTwo, Of::SecondOfTwo],
        };
        let family = shape.family;
        of.into_iter().map(move |of| Self { family, of })
    }

    /// Keeps the largest Δχ² of each sample.
    ///
    /// # Arguments
    /// - `along`: the samples along its vector.
    /// - `squares`: of the first of two vectors, for the second.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it is compiled for the instructions of its caller"
    )]
    fn keep_largest(
        &self,
        along: &[f32; SAMPLES_TOGETHER],
        squares: &mut [f32; SAMPLES_TOGETHER],
        most: &mut [f32; SAMPLES_TOGETHER],
    ) {
        // Plain comparisons, which are one instruction each: no product lacks a number.
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let smaller = |a: f32, b: f32| if a < b { a } else { b };
        match self.of {
            Of::Size([lowest, highest]) => {
                for (most, z) in most.iter_mut().zip(along) {
                    let size = smaller(larger(*z, lowest), highest);
                    *most = larger(size * (2.0 * z - size), *most);
                }
            }
            Of::FirstOfTwo => *squares = along.map(|z| z * z),
            Of::SecondOfTwo => {
                for ((most, z), square) in most.iter_mut().zip(along).zip(squares) {
                    *most = larger(*square + z * z, *most);
                }
            }
        }
    }
}
