//! Directions in which vectors lie within a cell of readings, and noise along them.
//!
//! Before projection vectors of one kind, as are those of all laws at one joint, differ little within a cell: there they span a few
//! directions, whatever their number. Of each cell the directions of all kinds are told together, while its noise is in the fastest
//! memory.

use std::ops::Range;

use stiffbench_numeric::lanes::sums_of_blocks;

use super::draws::{BLOCK, Drawn, LEFT_OUT};
use super::space::dot;

/// Directions in one cell from which on the readings themselves are as good a basis.
const MOST_DIRECTIONS: usize = 64;

/// A basis for the readings of a cell.
#[derive(Debug)]
pub(super) struct CellBasis {
    readings: Range<usize>,
    /// Orthonormal columns; `None` where it is the readings themselves.
    columns: Option<Vec<Vec<f64>>>,
}

/// All that is told of noise.
#[derive(Debug)]
pub(super) struct Directions {
    cells: Vec<Cell>,
    count: usize,
}

/// All that is told of the noise of a cell.
#[derive(Debug)]
struct Cell {
    readings: Range<usize>,
    /// Columns of all bases, one after the other.
    columns: Vec<f32>,
    /// Where each of them stands among the directions.
    places: Vec<usize>,
    /// Where the readings themselves stand.
    copies: Vec<usize>,
}

/// Where the noise stands of which vectors are sums.
#[derive(Debug, Clone)]
pub(super) enum Source {
    Readings(Range<usize>),
    Directions(Range<usize>),
}

/// Square of what a basis of one cell out of several may leave out of a vector.
pub(super) fn left_out(cells: usize) -> f64 {
    LEFT_OUT * LEFT_OUT / cells as f64
}

impl CellBasis {
    pub(super) fn of_readings(readings: &Range<usize>) -> Self {
        Self {
            readings: readings.clone(),
            columns: None,
        }
    }

    /// A basis of what vectors are in a cell.
    ///
    /// # Arguments
    /// - `cells`: how many there are.
    pub(super) fn new(readings: &Range<usize>, cells: usize, drawn: &[Drawn]) -> Self {
        let most = MOST_DIRECTIONS.min(readings.len() / 2);
        let left_out = left_out(cells);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut shares = Vec::new();
        for unit in drawn.iter().flat_map(|drawn| &drawn.units) {
            let part = &unit[readings.clone()];
            shares.clear();
            shares.extend(columns.iter().map(|column| dot(column, part)));
            if dot(part, part) - dot(&shares, &shares) <= left_out {
                continue;
            }
            if columns.len() == most {
                return Self::of_readings(readings);
            }
            let mut rest = part.to_vec();
            // Twice, so that what is left is orthogonal to the last digit.
            for _ in 0..2 {
                for column in &columns {
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
            columns.push(rest);
        }
        Self {
            readings: readings.clone(),
            columns: Some(columns),
        }
    }

    /// How many directions it has.
    pub(super) fn count(&self) -> usize {
        let columns = self.columns.as_ref();
        columns.map_or(self.readings.len(), Vec::len)
    }

    /// Shares of the directions in a vector, appended.
    pub(super) fn add_shares(&self, unit: &[f64], out: &mut Vec<f64>) {
        let part = &unit[self.readings.clone()];
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
    /// - `cells`: readings of each.
    pub(super) fn new(cells: &[Range<usize>]) -> Self {
        let cell = |readings: &Range<usize>| Cell {
            readings: readings.clone(),
            columns: Vec::new(),
            places: Vec::new(),
            copies: Vec::new(),
        };
        Self {
            cells: cells.iter().map(cell).collect(),
            count: 0,
        }
    }

    /// Takes in the bases of vectors that live in some cells.
    ///
    /// # Arguments
    /// - `bases`: cells by number, and the basis in each.
    ///
    /// # Returns
    /// Where their noise will stand, in the order of the bases.
    pub(super) fn take_in(&mut self, bases: &[(usize, CellBasis)]) -> Source {
        if let [(_, basis)] = bases
            && basis.columns.is_none()
        {
            return Source::Readings(basis.readings.clone());
        }
        let first = self.count;
        for (cell, basis) in bases {
            let cell = &mut self.cells[*cell];
            let places = self.count..self.count + basis.count();
            self.count = places.end;
            match &basis.columns {
                None => cell.copies.push(places.start),
                Some(columns) => {
                    let single = columns.iter().flatten().map(|x| *x as f32);
                    cell.columns.extend(single);
                    cell.places.extend(places);
                }
            }
        }
        Source::Directions(first..self.count)
    }

    /// Noise along all of them.
    pub(super) fn tell(&self, noise: &[[f32; BLOCK]], out: &mut Vec<[f32; BLOCK]>) {
        out.resize(self.count, [0.0; BLOCK]);
        for cell in &self.cells {
            let noise = &noise[cell.readings.clone()];
            for &first in &cell.copies {
                out[first..first + noise.len()].copy_from_slice(noise);
            }
            if cell.columns.is_empty() {
                continue;
            }
            let mut places = cell.places.iter();
            sums_of_blocks(noise, &cell.columns, |along| {
                if let Some(&place) = places.next() {
                    out[place] = *along;
                }
            });
        }
    }
}
