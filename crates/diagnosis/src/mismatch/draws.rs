//! Draws of noise along thousands of vectors at once.
//!
//! What a vector of readings gives on noise z is v·(z - B Bᵀ z), B what the fit absorbs. Vectors of one kind span few directions in each
//! cell, so that the noise is told once along those, and each vector is a sum over them. A vector is told only in the cells where it
//! lives. Over all cells most vectors of a kind are nearly sums of a few of them, and only these few are told.
//!
//! Products are taken in single precision: seven digits of numbers that are compared with a limit known to three.

use std::collections::BTreeMap;
use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use stiffbench_numeric::lanes::sums_of_blocks;

use super::directions::{CellBasis, Directions, Source, left_out};
use super::few::Few;
use super::space::{Space, dot};

/// Draws of one block: they share their products.
///
/// As many as fill five registers of sixteen numbers: products of other counts waste lanes.
pub(super) const BLOCK: usize = 80;

/// How far, in lengths of a vector as the fit leaves it, a basis may leave it out, and a sum over a few be from it: a gain of 16 changes by
/// 0.08 at random, a limit not.
pub(super) const LEFT_OUT: f64 = 0.01;

/// Vectors from which few are chosen: those of more are chosen apart, for neighbours in the list are most alike.
const TOGETHER: usize = 160;

/// A vector this much longer before the projection than after it is projected here, where there are digits enough.
const LONG: f64 = 1e3;

/// Vectors of one kind, which share bases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Laws at one joint, by a number of it.
    Joint(usize),
    /// Slips in one run, by a number of it.
    Slip(usize),
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
    directions: Directions,
    blocks: Vec<Block>,
}

/// Noise along directions and along the few vectors of a block; memory of one thread.
#[derive(Debug, Default)]
pub(super) struct Told {
    directions: Vec<[f32; BLOCK]>,
    few: Vec<[f32; BLOCK]>,
}

/// Vectors of one kind that live in the same cells.
struct Group {
    drawn: Vec<Drawn>,
    /// Cells by number, and the basis in each.
    bases: Vec<(usize, CellBasis)>,
}

/// Vectors that are sums over the same directions.
#[derive(Debug)]
struct Block {
    source: Source,
    /// Shares of the directions in the few vectors of which all are sums, one after the other; `None` if all are told themselves.
    few: Option<Vec<f32>>,
    /// Shares of the few or else of the directions, vector by vector.
    shares: Vec<f32>,
    gains: Vec<Gain>,
}

/// What is asked of the product with a vector.
#[derive(Debug, Clone, Copy)]
struct Gain {
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
        let prepare = |drawn: &mut Drawn| {
            for unit in &mut drawn.units {
                if dot(unit, unit) > LONG * LONG {
                    space.project(unit);
                }
            }
            lived_in(cells, &drawn.units)
        };
        let living: Vec<Vec<usize>> = drawn.par_iter_mut().map(prepare).collect();
        let mut alike: BTreeMap<(Kind, Vec<usize>), Vec<Drawn>> = BTreeMap::new();
        for (one, lived_in) in drawn.into_iter().zip(living) {
            alike.entry((one.kind, lived_in)).or_default().push(one);
        }
        let groups: Vec<Group> = alike
            .into_par_iter()
            .map(|((_, lived_in), drawn)| Group::new(&lived_in, drawn, cells))
            .collect();
        let mut directions = Directions::new(cells);
        let sources: Vec<Source> = groups
            .iter()
            .map(|group| directions.take_in(&group.bases))
            .collect();
        let blocks = groups
            .into_par_iter()
            .zip(sources)
            .flat_map_iter(|(group, source)| group.blocks(space, &source))
            .collect();
        let absorbed = space.basis().iter().flatten().map(|x| *x as f32).collect();
        Self {
            length: space.length,
            families,
            absorbed,
            directions,
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
    pub(super) fn largest(&self, noise: &mut [f32], memory: &mut Told) -> Vec<[f32; BLOCK]> {
        let mut largest = vec![[0.0_f32; BLOCK]; self.families];
        self.project(noise);
        let (noise, _) = noise.as_chunks();
        self.directions.tell(noise, &mut memory.directions);
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

/// Readings of a cell from the first to the last that count in vectors.
fn lived_on(cell: &Range<usize>, drawn: &[Drawn]) -> Range<usize> {
    let counts = |reading: &usize| {
        let mut units = drawn.iter().flat_map(|drawn| &drawn.units);
        units.any(|unit| unit[*reading] != 0.0)
    };
    let first = cell.clone().find(counts).unwrap_or(cell.end);
    let last = cell.clone().rfind(counts).unwrap_or(cell.start);
    first..last + 1
}

impl Group {
    fn new(lived_in: &[usize], drawn: Vec<Drawn>, cells: &[Range<usize>]) -> Self {
        let basis = |cell: &usize| match lived_in {
            [_] => CellBasis::of_readings(&lived_on(&cells[*cell], &drawn)),
            _ => CellBasis::new(&cells[*cell], cells.len(), &drawn),
        };
        Self {
            bases: lived_in.iter().map(|cell| (*cell, basis(cell))).collect(),
            drawn,
        }
    }

    fn blocks(&self, space: &Space, source: &Source) -> Vec<Block> {
        let vectors: usize = self.drawn.iter().map(|drawn| drawn.units.len()).sum();
        let each = self.drawn.len().div_ceil(vectors.div_ceil(TOGETHER).max(1));
        let parts = self.drawn.chunks(each);
        parts
            .map(|drawn| Block::new(space, drawn, &self.bases, source.clone()))
            .collect()
    }
}

impl Block {
    fn new(space: &Space, drawn: &[Drawn], bases: &[(usize, CellBasis)], source: Source) -> Self {
        let shares_of = |vector: &Vec<f64>| {
            let mut shares = Vec::new();
            for (_, basis) in bases {
                basis.add_shares(vector, &mut shares);
            }
            shares
        };
        let units = drawn.iter().flat_map(|drawn| &drawn.units);
        let shares: Vec<f64> = units.flat_map(shares_of).collect();
        let absorbed: Vec<f64> = space.basis().iter().flat_map(shares_of).collect();
        let directions = bases.iter().map(|(_, basis)| basis.count()).sum();
        let single = |shares: &[f64]| shares.iter().map(|x| *x as f32).collect::<Vec<f32>>();
        let (few, shares) = match Few::new(directions, &shares, &absorbed) {
            Some(few) => (Some(single(&few.vectors)), single(&few.shares)),
            None => (None, single(&shares)),
        };
        Self {
            source,
            few,
            shares,
            gains: drawn.iter().flat_map(Gain::of).collect(),
        }
    }

    fn add_to(&self, noise: &[[f32; BLOCK]], memory: &mut Told, largest: &mut [[f32; BLOCK]]) {
        let mut told = match &self.source {
            Source::Readings(readings) => &noise[readings.clone()],
            Source::Directions(places) => &memory.directions[places.clone()],
        };
        if told.is_empty() {
            return;
        }
        if let Some(few) = &self.few {
            memory.few.clear();
            sums_of_blocks(told, few, |along| memory.few.push(*along));
            told = &memory.few;
        }
        let mut gains = self.gains.iter();
        let mut squares = [0.0; BLOCK];
        sums_of_blocks(
            told,
            &self.shares,
            #[inline(always)]
            |along| {
                if let Some(gain) = gains.next() {
                    gain.keep_largest(along, &mut squares, &mut largest[gain.family]);
                }
            },
        );
    }
}

impl Gain {
    /// What is asked of the products with the vectors of one [`Drawn`].
    fn of(drawn: &Drawn) -> impl Iterator<Item = Self> {
        let size = || {
            let length = drawn.length as f32;
            Of::Size(drawn.scale.map(|scale| scale as f32 * length))
        };
        let of = match drawn.units.len() {
            1 => vec![size()],
            _ => vec![Of::FirstOfTwo, Of::SecondOfTwo],
        };
        let family = drawn.family;
        of.into_iter().map(move |of| Self { family, of })
    }

    /// Keeps the largest gain of each draw.
    ///
    /// # Arguments
    /// - `along`: the draws along its vector.
    /// - `squares`: of the first of two vectors, for the second.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it is compiled for the instructions of its caller"
    )]
    fn keep_largest(
        &self,
        along: &[f32; BLOCK],
        squares: &mut [f32; BLOCK],
        most: &mut [f32; BLOCK],
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
        let told = |block: &Block| match &block.source {
            Source::Readings(readings) => readings.len(),
            Source::Directions(places) => places.len(),
        };
        let told: usize = table.blocks.iter().map(told).sum();
        assert!(told <= 3 + 3 + 10, "{told} directions");
        let noise: Vec<f64> = (0..n * BLOCK)
            .map(|i| 3.0 * (1.7 * i as f64).sin())
            .collect();
        let by_reading = (0..n).flat_map(|reading| noise.chunks(n).map(move |draw| draw[reading]));
        let mut single: Vec<f32> = by_reading.map(|x| x as f32).collect();
        let found = table.largest(&mut single, &mut Told::default());
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
