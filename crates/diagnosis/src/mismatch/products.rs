//! Lengths and products of vectors of readings as they are when white and projected, without making them so.
//!
//! With s a vector of readings, V the covariance of the noise and B the orthonormal white columns that the fit absorbs,
//!
//! ```text
//!   ‖P W s‖² = sᵀ V⁻¹ s - ‖Bᵀ W s‖²,    sᵀ V⁻¹ s = Σ w² s² - ‖Eᵀ s‖²    (a few columns E for each run)
//! ```
//!
//! so that a shape costs one product with each column, and no memory.

use std::ops::Range;

use stiffbench_numeric::lanes::{sums_side_by_side, widest};

use super::noise::RunColumns;
use super::space::{Space, dot};

/// A square that is less than this share of its first term has lost too many digits, and is worked out from the white vector.
const CANCELLED: f64 = 1e-8;

/// What products with the vectors of one space need.
#[derive(Debug)]
pub(super) struct Products<'a> {
    space: &'a Space,
    /// w²: one over the variance of each reading.
    weights: Vec<f64>,
    /// E, one after the other.
    runs: Vec<RunColumns>,
    /// Wᵀ B.
    absorbed: Vec<Vec<f64>>,
    /// Wᵀ times the white residuals, and those themselves.
    residual: Vec<f64>,
    white_residual: &'a [f64],
}

/// A vector of readings in a space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measured {
    /// Its square.
    pub(super) square: f64,
    /// Its product with the residuals.
    pub(super) product: f64,
}

/// Two vectors of readings in a space, the second made orthogonal to the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeasuredPair {
    pub(super) first: Measured,
    pub(super) second: Measured,
}

impl<'a> Products<'a> {
    /// # Arguments
    /// - `white_residual`: the residuals, white and projected.
    pub(super) fn new(space: &'a Space, white_residual: &'a [f64]) -> Self {
        let whitening = &space.whitening;
        let readings = whitening.weights().len();
        let back = |white: &[f64]| {
            let mut out = white[..readings].to_vec();
            whitening.apply_transposed(&mut out);
            out
        };
        Self {
            weights: whitening.weights().iter().map(|w| w * w).collect(),
            runs: whitening.run_columns().collect(),
            absorbed: space.basis().iter().map(|column| back(column)).collect(),
            residual: back(white_residual),
            white_residual,
            space,
        }
    }

    /// Measures a vector of readings, m, which is zero outside a range.
    ///
    /// # Arguments
    /// - `scratch`: memory.
    pub(super) fn measure(
        &self,
        values_m: &[f64],
        range: &Range<usize>,
        scratch: &mut Vec<f64>,
    ) -> Measured {
        scratch.clear();
        let whole = self.shares(values_m, range, scratch);
        let square = whole - dot(scratch, scratch);
        if square < CANCELLED * whole {
            return self.measure_white(values_m, range);
        }
        Measured {
            square,
            product: dot(&values_m[range.clone()], &self.residual[range.clone()]),
        }
    }

    /// Measures two vectors of readings, m.
    pub(super) fn measure_pair(
        &self,
        values_m: [&[f64]; 2],
        scratch: &mut Vec<f64>,
    ) -> MeasuredPair {
        let [first_m, second_m] = values_m;
        let range = 0..first_m.len();
        scratch.clear();
        let wholes = [first_m, second_m].map(|values| self.shares(values, &range, scratch));
        let mut squares = wholes;
        let columns = scratch.len() / 2;
        let (of_first, of_second) = scratch.split_at(columns);
        squares[0] -= dot(of_first, of_first);
        squares[1] -= dot(of_second, of_second);
        let both = triple(&self.weights, first_m, second_m) - dot(of_first, of_second);
        let [first, second] = [first_m, second_m].map(|values| dot(values, &self.residual));
        let square = squares[1] - both * both / squares[0];
        if squares[0] < CANCELLED * wholes[0] || square.is_nan() || square < CANCELLED * wholes[1] {
            return self.measure_white_pair(values_m);
        }
        MeasuredPair {
            first: Measured {
                square: squares[0],
                product: first,
            },
            second: Measured {
                square,
                product: second - both / squares[0] * first,
            },
        }
    }

    /// Products with the columns, appended; and Σ w² s².
    fn shares(&self, values_m: &[f64], range: &Range<usize>, out: &mut Vec<f64>) -> f64 {
        widest(
            #[inline(always)]
            || self.shares_in_lanes(values_m, range, out),
        )
    }

    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it is compiled for the instructions of its caller"
    )]
    fn shares_in_lanes(&self, values_m: &[f64], range: &Range<usize>, out: &mut Vec<f64>) -> f64 {
        let values = &values_m[range.clone()];
        let first = self
            .runs
            .partition_point(|run| run.readings.end <= range.start);
        let runs = self.runs[first..]
            .iter()
            .take_while(|run| run.readings.start < range.end);
        for run in runs {
            let part = &values_m[run.readings.clone()];
            for column in run.columns.chunks_exact(part.len()) {
                out.push(short_dot(column, part));
            }
        }
        for column in &self.absorbed {
            out.push(sums_side_by_side(&column[range.clone()], values));
        }
        triple(&self.weights[range.clone()], values, values)
    }

    fn measure_white(&self, values_m: &[f64], range: &Range<usize>) -> Measured {
        let mut whole = vec![0.0; self.weights.len()];
        whole[range.clone()].copy_from_slice(&values_m[range.clone()]);
        self.of_white(&self.space.projected(&whole))
    }

    fn measure_white_pair(&self, values_m: [&[f64]; 2]) -> MeasuredPair {
        let [first, mut second] = values_m.map(|values| self.space.projected(values));
        let [own, whole] = [&first, &second].map(|white| dot(white, white));
        let share = dot(&first, &second) / own.max(f64::MIN_POSITIVE);
        for (value, other) in second.iter_mut().zip(&first) {
            *value -= share * other;
        }
        let mut rest = self.of_white(&second);
        if rest.square < CANCELLED * whole {
            // The second says nothing that the first does not.
            rest.product = 0.0;
        }
        MeasuredPair {
            first: self.of_white(&first),
            second: rest,
        }
    }

    fn of_white(&self, white: &[f64]) -> Measured {
        Measured {
            square: dot(white, white),
            product: dot(white, self.white_residual),
        }
    }
}

/// Scalar product of as many numbers as a run has, four sums side by side.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::changes::tests::{observations, space};

    #[test]
    fn products_are_those_of_the_white_vectors() {
        let observations = observations();
        let n = observations.len();
        let space = space(&observations);
        let wave = |turn: f64| -> Vec<f64> {
            (0..n)
                .map(|i| 1e-5 * (turn * (i as f64 + 0.3)).sin())
                .collect()
        };
        let residual = space.projected(&wave(2.1));
        let products = Products::new(&space, &residual);
        let mut scratch = Vec::new();
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-10 * (1.0 + b.abs()), "{a} {b}");
        let (first, second) = (wave(0.7), wave(1.3));
        let whites = [&first, &second].map(|values| space.projected(values));
        let found = products.measure(&first, &(0..n), &mut scratch);
        near(found.square, dot(&whites[0], &whites[0]));
        near(found.product, dot(&whites[0], &residual));
        // The second cell alone.
        let mut part = first.clone();
        part[..10].fill(0.0);
        let white = space.projected(&part);
        let found = products.measure(&first, &(10..n), &mut scratch);
        near(found.square, dot(&white, &white));
        near(found.product, dot(&white, &residual));
        let share = dot(&whites[0], &whites[1]) / dot(&whites[0], &whites[0]);
        let pair = products.measure_pair([&first, &second], &mut scratch);
        near(pair.first.square, dot(&whites[0], &whites[0]));
        near(
            pair.second.square,
            dot(&whites[1], &whites[1]) - share * dot(&whites[0], &whites[1]),
        );
        near(
            pair.second.product,
            dot(&whites[1], &residual) - share * dot(&whites[0], &residual),
        );
        // A pair that is close to one vector, and one that the fit nearly absorbs, which is left to the white vectors.
        let nearly: Vec<f64> = first
            .iter()
            .zip(&second)
            .map(|(a, b)| a + 0.03 * b)
            .collect();
        let absorbed: Vec<f64> = observations.loads.iter().map(|l| l.force_n).collect();
        let close: Vec<f64> = absorbed.iter().zip(&first).map(|(a, b)| a + b).collect();
        for [one, other] in [[&first, &nearly], [&close, &second]] {
            let [one_white, mut rest] = [one, other].map(|values| space.projected(values));
            let share = dot(&one_white, &rest) / dot(&one_white, &one_white);
            for (value, own) in rest.iter_mut().zip(&one_white) {
                *value -= share * own;
            }
            let pair = products.measure_pair([one, other], &mut scratch);
            let gain = |product: f64, square: f64| product * product / square;
            near(pair.first.square, dot(&one_white, &one_white));
            let found = gain(pair.second.product, pair.second.square);
            let expected = gain(dot(&rest, &residual), dot(&rest, &rest));
            // Of a square that is a millionth of its terms ten digits are left.
            assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
        }
        // What the fit absorbs wholly is left to the last digit of the white vector.
        let found = products.measure(&absorbed, &(0..n), &mut scratch);
        let white = space.projected(&absorbed);
        assert_eq!(found.square, dot(&white, &white));
    }
}
