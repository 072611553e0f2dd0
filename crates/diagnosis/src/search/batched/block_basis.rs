//! Directions in which vectors lie within a block of rows, and noise along them.
//!
//! Before projection vectors of one group differ little within a block: there they span a few directions, whatever their number. Products
//! of a block's noise with the directions of several groups are taken together, while that noise is in the fastest memory.

use std::ops::Range;

use stiffbench_numeric::simd::sums_of_blocks;

use crate::search::constants::{LEFT_OUT, SAMPLES_TOGETHER};
use crate::search::engine::NullShape;
use crate::search::vectors::{dot, push_orthonormal};

/// Directions in one block of rows from which on the rows themselves are as good a basis (1). Numerics.
const MOST_DIRECTIONS: usize = 64;

/// A basis for the rows of a block.
#[derive(Debug)]
pub(super) struct BlockBasis {
    rows: Range<usize>,
    /// Orthonormal columns; `None` where it is the rows themselves.
    columns: Option<Vec<Vec<f64>>>,
}

/// Directions of some groups.
#[derive(Debug)]
pub(super) struct Directions {
    blocks: Vec<BasisBlock>,
    count: usize,
}

/// Directions of these groups in one block.
#[derive(Debug)]
struct BasisBlock {
    rows: Range<usize>,
    /// Columns of all bases, one after the other.
    columns: Vec<f32>,
    /// Where each of them stands among the directions.
    places: Vec<usize>,
    /// Where the rows themselves stand.
    copies: Vec<usize>,
}

/// Where the noise stands of which vectors are sums.
#[derive(Debug, Clone)]
pub(super) enum Source {
    Rows(Range<usize>),
    Directions(Range<usize>),
}

/// Square of what a basis of one block out of several may leave out of a vector.
pub(super) fn left_out(blocks: usize) -> f64 {
    LEFT_OUT * LEFT_OUT / blocks as f64
}

impl BlockBasis {
    pub(super) fn of_rows(rows: &Range<usize>) -> Self {
        Self {
            rows: rows.clone(),
            columns: None,
        }
    }

    /// A basis of what vectors are in a block.
    ///
    /// # Arguments
    /// - `blocks`: how many there are.
    pub(super) fn new(rows: &Range<usize>, blocks: usize, shapes: &[NullShape]) -> Self {
        let most = MOST_DIRECTIONS.min(rows.len() / 2);
        let left_out = left_out(blocks);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut shares = Vec::new();
        for unit in shapes.iter().flat_map(|shape| &shape.units) {
            let part = unit.part(rows);
            shares.clear();
            shares.extend(columns.iter().map(|column| dot(column, &part)));
            if dot(&part, &part) - dot(&shares, &shares) <= left_out {
                continue;
            }
            if columns.len() == most {
                return Self::of_rows(rows);
            }
            push_orthonormal(&mut columns, part.into_owned(), 0.0, 0.0);
        }
        Self {
            rows: rows.clone(),
            columns: Some(columns),
        }
    }

    /// The same bases; as one where they are the rows themselves, and these fill most of their range: then the noise needs no copy.
    pub(super) fn together(bases: Vec<(usize, Self)>) -> Vec<(usize, Self)> {
        let ends = bases.first().zip(bases.last());
        let Some(((block, first), (_, last))) = ends else {
            return bases;
        };
        let (block, range) = (*block, first.rows.start..last.rows.end);
        let rows: usize = bases.iter().map(|(_, basis)| basis.rows.len()).sum();
        let are_rows = bases.iter().all(|(_, basis)| basis.columns.is_none());
        if are_rows && 2 * rows > range.len() {
            return vec![(block, Self::of_rows(&range))];
        }
        bases
    }

    /// Its rows.
    pub(super) fn rows(&self) -> &Range<usize> {
        &self.rows
    }

    /// How many directions it has.
    pub(super) fn count(&self) -> usize {
        let columns = self.columns.as_ref();
        columns.map_or(self.rows.len(), Vec::len)
    }

    /// Shares of the directions in a vector, appended.
    ///
    /// # Arguments
    /// - `part`: what the vector is in its rows.
    pub(super) fn add_shares(&self, part: &[f64], out: &mut Vec<f64>) {
        match &self.columns {
            None => out.extend_from_slice(part),
            Some(columns) => out.extend(columns.iter().map(|column| dot(column, part))),
        }
    }
}

impl Directions {
    /// None yet.
    ///
    /// # Arguments
    /// - `blocks`: rows of each.
    pub(super) fn new(blocks: &[Range<usize>]) -> Self {
        let block = |rows: &Range<usize>| BasisBlock {
            rows: rows.clone(),
            columns: Vec::new(),
            places: Vec::new(),
            copies: Vec::new(),
        };
        Self {
            blocks: blocks.iter().map(block).collect(),
            count: 0,
        }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Takes in the bases of vectors that live in some blocks.
    ///
    /// # Arguments
    /// - `bases`: blocks by number, and the basis in each.
    ///
    /// # Returns
    /// Where their noise will stand, in the order of the bases.
    pub(super) fn take_in(&mut self, bases: &[(usize, BlockBasis)]) -> Source {
        if let [(_, basis)] = bases
            && basis.columns.is_none()
        {
            return Source::Rows(basis.rows.clone());
        }
        let first = self.count;
        for (block, basis) in bases {
            let block = &mut self.blocks[*block];
            let places = self.count..self.count + basis.count();
            self.count = places.end;
            match &basis.columns {
                None => block.copies.push(places.start),
                Some(columns) => {
                    let single = columns.iter().flatten().map(|x| *x as f32);
                    block.columns.extend(single);
                    block.places.extend(places);
                }
            }
        }
        Source::Directions(first..self.count)
    }

    /// Noise along all of them.
    pub(super) fn products(
        &self,
        noise: &[[f32; SAMPLES_TOGETHER]],
        out: &mut Vec<[f32; SAMPLES_TOGETHER]>,
    ) {
        out.resize(self.count, [0.0; SAMPLES_TOGETHER]);
        for block in &self.blocks {
            let noise = &noise[block.rows.clone()];
            for &first in &block.copies {
                out[first..first + noise.len()].copy_from_slice(noise);
            }
            if block.columns.is_empty() {
                continue;
            }
            let mut places = block.places.iter();
            sums_of_blocks(noise, &block.columns, |along| {
                if let Some(&place) = places.next() {
                    out[place] = *along;
                }
            });
        }
    }
}
