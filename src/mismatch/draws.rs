//! Draws of noise along thousands of vectors at once.
//!
//! What a vector of readings gives on noise z is v·(z - B Bᵀ z), B what the fit absorbs. Before projection vectors of one kind, as are
//! those of all laws at one joint, differ little within a cell: there they span a few tens of directions, whatever their number. The noise
//! is therefore told once along a basis of each cell, and each vector is a sum over those. A vector is told only in the cells where it
//! lives. Over all cells most vectors of a kind are nearly sums of a few of them, and only these few are told.
//!
//! Products are taken in single precision: seven digits of numbers that are compared with a limit known to three.

use std::collections::BTreeMap;
use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use crate::lanes::widest;

use super::few::Few;
use super::space::{Space, dot};

/// Draws of one block: they share their products.
///
/// As many as fill five registers of sixteen numbers: products of other counts waste lanes.
pub(super) const BLOCK: usize = 80;

/// Vectors whose products are taken before their gains are looked at: as many as stay in the cache.
const COLUMNS: usize = 512;

/// How far, in lengths of a vector as the fit leaves it, a basis may leave it out, and a sum over a few be from it: a gain of 16 changes by
/// 0.08 at random, a limit not.
pub(super) const LEFT_OUT: f64 = 0.01;

/// A vector this much longer before the projection than after it is projected here, where there are digits enough.
const LONG: f64 = 1e3;

/// Directions in one cell from which on the readings themselves are as good a basis.
const MOST_DIRECTIONS: usize = 64;

/// Vectors of one kind, which share bases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Laws at one joint, by a number of it.
    Joint(usize),
    /// Slips.
    Slip,
    /// Periods of gauges.
    Period,
    /// All other laws.
    Law,
    /// Patterns without a law in the same readings, by a number of these.
    Pattern(usize),
}

/// What noise gives along one or two vectors, and for whom it counts.
#[derive(Debug)]
pub(super) struct Drawn {
    pub(super) kind: Kind,
    /// Its family.
    pub(super) family: usize,
    /// White vectors, before or after projection; of unit length after it, and orthogonal if they are two.
    pub(super) units: Vec<Vec<f64>>,
    /// Length of the first as it stands for the scale.
    pub(super) length: f64,
    /// Smallest and largest multiple of it.
    pub(super) scale: [f64; 2],
}

/// All vectors, ready for draws.
#[derive(Debug)]
pub(super) struct DrawTable {
    length: usize,
    families: usize,
    /// What the fit absorbs, column by column.
    absorbed: Vec<f32>,
    blocks: Vec<Block>,
}

/// Memory of one thread for products with noise, [`BLOCK`] draws one after the other.
#[derive(Debug, Default)]
pub(super) struct Products {
    along_directions: Vec<f32>,
    along_few: Vec<f32>,
    along_vectors: Vec<f32>,
}

/// A matrix of [`BLOCK`] rows in memory that grows as needed; what is in it is left from before.
fn columns_in(memory: &mut Vec<f32>, count: usize) -> MatMut<'_, f32> {
    if memory.len() < count * BLOCK {
        memory.resize(count * BLOCK, 0.0);
    }
    MatMut::from_column_major_slice_mut(&mut memory[..count * BLOCK], BLOCK, count)
}

/// Vectors that are told along the same bases.
#[derive(Debug)]
struct Block {
    cells: Vec<CellBasis>,
    /// Directions of all its cells.
    directions: usize,
    /// Shares of the directions in the few vectors of which all are sums, one after the other; `None` if all are told themselves.
    few: Option<Vec<f32>>,
    /// Shares of the few or else of the directions, vector by vector.
    shares: Vec<f32>,
    gains: Vec<Gain>,
}

/// A basis for the readings of a cell.
#[derive(Debug)]
struct CellBasis {
    readings: Range<usize>,
    /// Orthonormal columns; `None` where it is the readings themselves.
    basis: Option<Vec<Vec<f64>>>,
    /// The same, one after the other.
    told: Vec<f32>,
    directions: usize,
}

/// What is asked of a product, or of two.
#[derive(Debug, Clone, Copy)]
struct Gain {
    family: usize,
    is_pair: bool,
    length: f32,
    scale: [f32; 2],
}

impl DrawTable {
    /// # Arguments
    /// - `cells`: readings of each cell.
    /// - `families`: how many there are.
    pub(super) fn new(
        space: &Space,
        cells: &[Range<usize>],
        families: usize,
        mut drawn: Vec<Drawn>,
    ) -> Self {
        for unit in drawn.iter_mut().flat_map(|drawn| &mut drawn.units) {
            if dot(unit, unit) > LONG * LONG {
                space.project(unit);
            }
        }
        let mut places: BTreeMap<(Kind, Vec<usize>), Vec<Drawn>> = BTreeMap::new();
        for one in drawn {
            let place = (one.kind, lived_in(cells, &one.units));
            places.entry(place).or_default().push(one);
        }
        let blocks = places
            .into_par_iter()
            .map(|((_, lived_in), drawn)| {
                let basis = |cell: &usize| match lived_in[..] {
                    [_] => CellBasis::of_readings(&cells[*cell]),
                    _ => CellBasis::new(&cells[*cell], cells.len(), &drawn),
                };
                Block::new(space, &drawn, lived_in.iter().map(basis).collect())
            })
            .collect();
        let absorbed = space.basis().iter().flatten().map(|x| *x as f32).collect();
        Self {
            length: space.length,
            families,
            absorbed,
            blocks,
        }
    }

    /// Length of a vector of noise.
    pub(super) fn length(&self) -> usize {
        self.length
    }

    /// Largest gain of each family in each draw.
    ///
    /// # Arguments
    /// - `noise`: white noise, [`BLOCK`] draws of each reading, one reading after the other; overwritten.
    pub(super) fn largest(&self, noise: &mut [f32], memory: &mut Products) -> Vec<[f32; BLOCK]> {
        let mut largest = vec![[0.0_f32; BLOCK]; self.families];
        self.project(noise);
        let noise = MatRef::from_column_major_slice(&*noise, BLOCK, self.length);
        for block in &self.blocks {
            block.add_to(noise, memory, &mut largest);
        }
        largest
    }

    fn project(&self, noise: &mut [f32]) {
        let columns = self.absorbed.len() / self.length;
        let basis = MatRef::from_column_major_slice(&self.absorbed, self.length, columns);
        let mut shares = vec![0.0; columns * BLOCK];
        let mut shares = MatMut::from_column_major_slice_mut(&mut shares, BLOCK, columns);
        let mut noise = MatMut::from_column_major_slice_mut(noise, BLOCK, self.length);
        let (all, shares) = (noise.as_ref(), &mut shares);
        matmul(shares.as_mut(), Accum::Replace, all, basis, 1.0, Par::Seq);
        let (shares, back) = (shares.as_ref(), basis.transpose());
        matmul(noise.as_mut(), Accum::Add, shares, back, -1.0, Par::Seq);
    }
}

/// The cells in which vectors have readings that count.
fn lived_in(cells: &[Range<usize>], units: &[Vec<f64>]) -> Vec<usize> {
    let left_out = left_out(cells.len());
    let lives = |cell: &Range<usize>| {
        let mut parts = units.iter().map(|unit| &unit[cell.clone()]);
        parts.any(|part| dot(part, part) > left_out)
    };
    (0..cells.len())
        .filter(|&cell| lives(&cells[cell]))
        .collect()
}

/// Square of what a basis of one cell out of several may leave out of a vector.
fn left_out(cells: usize) -> f64 {
    LEFT_OUT * LEFT_OUT / cells as f64
}

impl CellBasis {
    fn of_readings(readings: &Range<usize>) -> Self {
        Self {
            directions: readings.len(),
            readings: readings.clone(),
            basis: None,
            told: Vec::new(),
        }
    }

    /// A basis of what vectors are in a cell.
    fn new(readings: &Range<usize>, cells: usize, drawn: &[Drawn]) -> Self {
        let most = MOST_DIRECTIONS.min(readings.len() / 2);
        let left_out = left_out(cells);
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let mut shares = Vec::new();
        for unit in drawn.iter().flat_map(|drawn| &drawn.units) {
            let part = &unit[readings.clone()];
            shares.clear();
            shares.extend(basis.iter().map(|column| dot(column, part)));
            if dot(part, part) - dot(&shares, &shares) <= left_out {
                continue;
            }
            if basis.len() == most {
                return Self::of_readings(readings);
            }
            let mut rest = part.to_vec();
            // Twice, so that what is left is orthogonal to the last digit.
            for _ in 0..2 {
                for column in &basis {
                    let share = dot(column, &rest);
                    for (value, unit) in rest.iter_mut().zip(column) {
                        *value -= share * unit;
                    }
                }
            }
            let length = dot(&rest, &rest).sqrt();
            for value in &mut rest {
                *value /= length;
            }
            basis.push(rest);
        }
        Self {
            readings: readings.clone(),
            directions: basis.len(),
            told: basis.iter().flatten().map(|x| *x as f32).collect(),
            basis: Some(basis),
        }
    }

    /// Shares of the directions in a vector, appended.
    fn add_shares(&self, unit: &[f64], out: &mut Vec<f64>) {
        let part = &unit[self.readings.clone()];
        match &self.basis {
            None => out.extend_from_slice(part),
            Some(basis) => out.extend(basis.iter().map(|column| dot(column, part))),
        }
    }

    /// Noise along the directions, draw by draw.
    fn tell(&self, noise: MatRef<'_, f32>, mut out: MatMut<'_, f32>) {
        let part = noise.subcols(self.readings.start, self.readings.len());
        if self.basis.is_none() {
            out.copy_from(part);
            return;
        }
        let (readings, directions) = (self.readings.len(), self.directions);
        let basis = MatRef::from_column_major_slice(&self.told, readings, directions);
        matmul(out, Accum::Replace, part, basis, 1.0, Par::Seq);
    }
}

impl Block {
    fn new(space: &Space, drawn: &[Drawn], cells: Vec<CellBasis>) -> Self {
        let shares_of = |vector: &Vec<f64>| {
            let mut shares = Vec::new();
            for cell in &cells {
                cell.add_shares(vector, &mut shares);
            }
            shares
        };
        let units = drawn.iter().flat_map(|drawn| &drawn.units);
        let shares: Vec<f64> = units.flat_map(shares_of).collect();
        let absorbed: Vec<f64> = space.basis().iter().flat_map(shares_of).collect();
        let directions = cells.iter().map(|cell| cell.directions).sum();
        let single = |shares: &[f64]| shares.iter().map(|x| *x as f32).collect::<Vec<f32>>();
        let (few, shares) = match Few::new(directions, &shares, &absorbed) {
            Some(few) => (Some(single(&few.vectors)), single(&few.shares)),
            None => (None, single(&shares)),
        };
        Self {
            directions,
            cells,
            few,
            shares,
            gains: drawn
                .iter()
                .map(|drawn| Gain {
                    family: drawn.family,
                    is_pair: drawn.units.len() > 1,
                    length: drawn.length as f32,
                    scale: drawn.scale.map(|scale| scale as f32),
                })
                .collect(),
        }
    }

    fn add_to(&self, noise: MatRef<'_, f32>, memory: &mut Products, largest: &mut [[f32; BLOCK]]) {
        if self.directions == 0 {
            return;
        }
        let mut along_directions = columns_in(&mut memory.along_directions, self.directions);
        let mut first = 0;
        for cell in &self.cells {
            let out = along_directions.as_mut();
            cell.tell(noise, out.subcols_mut(first, cell.directions));
            first += cell.directions;
        }
        let mut along_few;
        let mut told = along_directions.as_ref();
        if let Some(few) = &self.few {
            let count = few.len() / self.directions;
            let few = MatRef::from_column_major_slice(few, self.directions, count);
            along_few = columns_in(&mut memory.along_few, count);
            matmul(along_few.as_mut(), Accum::Replace, told, few, 1.0, Par::Seq);
            told = along_few.as_ref();
        }
        let mut shares = &self.shares[..];
        for gains in self.batches() {
            let columns = gains.iter().map(Gain::columns).sum();
            let (own, others) = shares.split_at(columns * told.ncols());
            let own = MatRef::from_column_major_slice(own, told.ncols(), columns);
            let mut products = columns_in(&mut memory.along_vectors, columns);
            matmul(products.as_mut(), Accum::Replace, told, own, 1.0, Par::Seq);
            keep_largest(gains, &memory.along_vectors[..columns * BLOCK], largest);
            shares = others;
        }
    }

    /// Its gains, as many at a time as have at most [`COLUMNS`] products.
    fn batches(&self) -> impl Iterator<Item = &[Gain]> {
        let mut columns = 0;
        self.gains.chunk_by(move |gain, next| {
            columns += gain.columns();
            let fits = columns + next.columns() <= COLUMNS;
            if !fits {
                columns = 0;
            }
            fits
        })
    }
}

impl Gain {
    /// Products that it is made of.
    fn columns(&self) -> usize {
        1 + usize::from(self.is_pair)
    }
}

fn keep_largest(gains: &[Gain], products: &[f32], largest: &mut [[f32; BLOCK]]) {
    widest(
        #[inline(always)]
        || keep_largest_in_lanes(gains, products, largest),
    );
}

#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "it is compiled for the instructions of its caller"
)]
fn keep_largest_in_lanes(gains: &[Gain], products: &[f32], largest: &mut [[f32; BLOCK]]) {
    // Plain comparisons, which are one instruction each: no product is without a number.
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    let smaller = |a: f32, b: f32| if a < b { a } else { b };
    let (mut products, _) = products.as_chunks::<BLOCK>();
    for gains in gains.chunk_by(|a, b| (a.family, a.is_pair) == (b.family, b.is_pair)) {
        let mut most = largest[gains[0].family];
        if gains[0].is_pair {
            let (own, others) = products.split_at(2 * gains.len());
            for [first, second] in own.as_chunks().0 {
                for (most, (z, other)) in most.iter_mut().zip(first.iter().zip(second)) {
                    *most = larger(z * z + other * other, *most);
                }
            }
            products = others;
        } else {
            let (own, others) = products.split_at(gains.len());
            for (gain, products) in gains.iter().zip(own) {
                let [lowest, highest] = gain.scale.map(|scale| scale * gain.length);
                for (most, z) in most.iter_mut().zip(products) {
                    let size = smaller(larger(*z, lowest), highest);
                    *most = larger(size * (2.0 * z - size), *most);
                }
            }
            products = others;
        }
        largest[gains[0].family] = most;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::changes::tests::{observations, space};

    #[test]
    fn gains_are_those_of_the_projected_vectors() {
        let observations = observations();
        let n = observations.len();
        let space = space(&observations);
        // Many vectors that span three directions in each cell, and one in the second cell alone.
        let wave = |number: usize, from: usize| -> Vec<f64> {
            let shares = [1.0, 0.3 * number as f64, 0.7 - 0.1 * number as f64];
            let value = |i: usize| {
                (1..4)
                    .zip(shares)
                    .map(move |(k, s)| s * (f64::from(k) * i as f64).sin())
            };
            let mut values: Vec<f64> = (0..n).map(|i| 1e-6 * value(i).sum::<f64>()).collect();
            values[..from].fill(0.0);
            values
        };
        let vectors: Vec<Vec<f64>> = (0..9).map(|k| wave(k, 0)).chain([wave(3, 10)]).collect();
        let units = vectors.iter().map(|values| {
            let left = space.projected(values);
            let length = dot(&left, &left).sqrt();
            let scale = |vector: Vec<f64>| vector.iter().map(|x| x / length).collect::<Vec<f64>>();
            (scale(space.white(values)), scale(left))
        });
        let (units, projected): (Vec<_>, Vec<_>) = units.unzip();
        let drawn = units.into_iter().enumerate().map(|(family, unit)| Drawn {
            kind: Kind::Law,
            family,
            units: vec![unit],
            length: 2.0,
            scale: [0.0, 1.0],
        });
        let cells = [0..10, 10..20];
        let table = DrawTable::new(&space, &cells, projected.len(), drawn.collect());
        let told: usize = table.blocks.iter().map(|block| block.directions).sum();
        assert!(told <= 3 + 3 + 10, "{told} directions");
        let noise: Vec<f64> = (0..n * BLOCK)
            .map(|i| 3.0 * (1.7 * i as f64).sin())
            .collect();
        let by_reading = (0..n).flat_map(|reading| noise.chunks(n).map(move |draw| draw[reading]));
        let mut single: Vec<f32> = by_reading.map(|x| x as f32).collect();
        let found = table.largest(&mut single, &mut Products::default());
        for (family, unit) in projected.iter().enumerate() {
            for (draw, noise) in noise.chunks(n).enumerate() {
                let z = dot(unit, noise);
                let size = z.clamp(0.0, 2.0);
                let expected = size * (2.0 * z - size);
                let error = (f64::from(found[family][draw]) - expected).abs();
                // A hundredth of a standard deviation, and noise of three of them.
                assert!(
                    error < 2.0 * 2.0 * 3.0 * 4.0 * LEFT_OUT,
                    "{family} {draw}: {error}"
                );
            }
        }
    }
}
