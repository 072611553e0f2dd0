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
use crate::search::constants::{LONG, SAMPLES_TOGETHER};
use crate::search::engine::{NullShape, NullShapes};
use crate::search::vectors::{RowVector, dot};
use crate::search::white_space::WhiteSpace;

/// Directions from which on others are taken apart (1): noise along them stays in a fast memory. Numerics.
const DIRECTIONS_TOGETHER: usize = 8192;

/// Vectors from which a low-rank basis is chosen (1); those of more are chosen apart, for neighbours in the list are most alike. Numerics.
const VECTORS_TOGETHER: usize = 160;

/// All vectors, ready for noise.
#[derive(Debug)]
pub(super) struct NullTable {
    length: usize,
    families: usize,
    /// The basis of the baseline, column by column.
    absorbed: Vec<f32>,
    groups: Vec<GroupsTogether>,
}

/// Groups whose directions are taken together.
#[derive(Debug)]
struct GroupsTogether {
    directions: Directions,
    parts: Vec<(Source, Vec<SamplePart>)>,
}

/// Noise along directions and along the low-rank basis of a part; memory of one thread.
#[derive(Debug, Default)]
pub(super) struct NullScratch {
    directions: Vec<[f32; SAMPLES_TOGETHER]>,
    basis: Vec<[f32; SAMPLES_TOGETHER]>,
}

/// Vectors of one group that live in the same blocks.
struct VectorGroup {
    /// Blocks by number, and the basis in each.
    bases: Vec<(usize, BlockBasis)>,
    parts: Vec<SamplePart>,
}

/// Vectors that are sums over the same directions.
#[derive(Debug)]
struct SamplePart {
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
        groups: Vec<NullShapes<'_>>,
    ) -> Self {
        let groups: Vec<Vec<VectorGroup>> = groups
            .into_par_iter()
            .with_max_len(1)
            .map(|shapes| VectorGroup::of(space, blocks, shapes()))
            .collect();
        let mut together: Vec<GroupsTogether> = Vec::new();
        for group in groups.into_iter().flatten() {
            let is_full = |one: &GroupsTogether| one.directions.count() >= DIRECTIONS_TOGETHER;
            if together.last().is_none_or(is_full) {
                together.push(GroupsTogether {
                    directions: Directions::new(blocks),
                    parts: Vec::new(),
                });
            }
            if let Some(last) = together.last_mut() {
                let source = last.directions.take_in(&group.bases);
                last.parts.push((source, group.parts));
            }
        }
        let absorbed = space.basis().iter().flatten().map(|x| *x as f32).collect();
        Self {
            length: space.length,
            families,
            absorbed,
            groups: together,
        }
    }

    /// Largest Δχ² of each family in each sample.
    ///
    /// # Arguments
    /// - `noise`: white noise, [`SAMPLES_TOGETHER`] samples of each row, one row after the other; overwritten.
    pub(super) fn maxima(
        &self,
        noise: &mut [f32],
        scratch: &mut NullScratch,
    ) -> Vec<[f32; SAMPLES_TOGETHER]> {
        self.project(noise);
        let (noise, _) = noise.as_chunks();
        let mut families = vec![[0.0_f32; SAMPLES_TOGETHER]; self.families];
        for together in &self.groups {
            together.directions.products(noise, &mut scratch.directions);
            for (source, parts) in &together.parts {
                for part in parts {
                    part.add_to(source, noise, scratch, &mut families);
                }
            }
        }
        families
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
fn lived_in(blocks: &[Range<usize>], units: &[RowVector]) -> Vec<usize> {
    let left_out = left_out(blocks.len());
    let lives = |block: &Range<usize>| {
        let reaches = |unit: &&RowVector| {
            let rows = unit.rows();
            rows.start < block.end && block.start < rows.end
        };
        let mut parts = units.iter().filter(reaches).map(|unit| unit.part(block));
        parts.any(|part| dot(&part, &part) > left_out)
    };
    let first = units.iter().map(|unit| unit.first).min().unwrap_or(0);
    let end = units.iter().map(|unit| unit.rows().end).max().unwrap_or(0);
    let from = blocks.partition_point(|block| block.end <= first);
    let to = blocks.partition_point(|block| block.start < end);
    (from..to).filter(|&block| lives(&blocks[block])).collect()
}

/// Rows of a block from the first to the last that count in vectors.
fn lived_on(block: &Range<usize>, shapes: &[NullShape]) -> Range<usize> {
    let units = || shapes.iter().flat_map(|shape| &shape.units);
    let count = |value: &f64| *value != 0.0;
    let first = |unit: &RowVector| Some(unit.first + unit.values.iter().position(count)?);
    let last = |unit: &RowVector| Some(unit.first + unit.values.iter().rposition(count)?);
    let first = units().filter_map(first).min().unwrap_or(block.start);
    let end = units()
        .filter_map(last)
        .max()
        .map_or(block.end, |last| last + 1);
    first.max(block.start)..end.min(block.end)
}

impl VectorGroup {
    /// The shapes of one group, by the blocks in which they live.
    fn of(space: &WhiteSpace, blocks: &[Range<usize>], shapes: Vec<NullShape>) -> Vec<Self> {
        let mut alike: BTreeMap<Vec<usize>, Vec<NullShape>> = BTreeMap::new();
        for mut shape in shapes {
            for unit in &mut shape.units {
                if dot(&unit.values, &unit.values) > LONG * LONG {
                    let mut whole = unit.whole(space.length);
                    space.project(&mut whole);
                    *unit = RowVector::from(whole);
                }
            }
            let lived_in = lived_in(blocks, &shape.units);
            alike.entry(lived_in).or_default().push(shape);
        }
        let alike = alike.into_iter();
        alike
            .map(|(lived_in, shapes)| Self::new(space, blocks, &lived_in, &shapes))
            .collect()
    }

    fn new(
        space: &WhiteSpace,
        blocks: &[Range<usize>],
        lived_in: &[usize],
        shapes: &[NullShape],
    ) -> Self {
        let basis = |block: &usize| match lived_in {
            [_] => BlockBasis::of_rows(&lived_on(&blocks[*block], shapes)),
            _ => BlockBasis::new(&blocks[*block], blocks.len(), shapes),
        };
        let bases = lived_in.iter().map(|block| (*block, basis(block)));
        let bases = BlockBasis::together(bases.collect());
        let vectors: usize = shapes.iter().map(|shape| shape.units.len()).sum();
        let each = shapes
            .len()
            .div_ceil(vectors.div_ceil(VECTORS_TOGETHER).max(1));
        let parts = shapes.chunks(each);
        Self {
            parts: parts
                .map(|shapes| SamplePart::new(space, shapes, &bases))
                .collect(),
            bases,
        }
    }
}

impl SamplePart {
    fn new(space: &WhiteSpace, shapes: &[NullShape], bases: &[(usize, BlockBasis)]) -> Self {
        let mut shares = Vec::new();
        for unit in shapes.iter().flat_map(|shape| &shape.units) {
            for (_, basis) in bases {
                basis.add_shares(&unit.part(basis.rows()), &mut shares);
            }
        }
        let mut absorbed = Vec::new();
        for column in space.basis() {
            for (_, basis) in bases {
                basis.add_shares(&column[basis.rows().clone()], &mut absorbed);
            }
        }
        let directions = bases.iter().map(|(_, basis)| basis.count()).sum();
        let single = |shares: &[f64]| shares.iter().map(|x| *x as f32).collect::<Vec<f32>>();
        let (basis, shares) = match LowRank::new(directions, &shares, &absorbed) {
            Some(low_rank) => (Some(single(&low_rank.basis)), single(&low_rank.shares)),
            None => (None, single(&shares)),
        };
        Self {
            basis,
            shares,
            scores: shapes.iter().flat_map(VectorScore::of).collect(),
        }
    }

    fn add_to(
        &self,
        source: &Source,
        noise: &[[f32; SAMPLES_TOGETHER]],
        scratch: &mut NullScratch,
        largest: &mut [[f32; SAMPLES_TOGETHER]],
    ) {
        let mut along = match source {
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
