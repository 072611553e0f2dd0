//! Readings made white, with everything that the fit can absorb projected out.

use std::ops::Range;

use stiffbench_numeric::lanes::{sums_side_by_side, widest};

use super::baseline::BaselineParameter;
use super::noise::Whitening;
use super::observations::Observations;

/// The space in which candidates are compared: white, and orthogonal to the parameters already in the model.
///
/// Behind the readings stand as many entries as the baseline has parameters: what is known of them beforehand counts as a reading.
#[derive(Debug, Clone)]
pub(super) struct Space {
    pub(super) whitening: Whitening,
    /// Orthonormal columns that the fit can absorb.
    basis: Vec<Vec<f64>>,
    pub(super) length: usize,
}

/// A column counts as absorbed if its white length is more than this: below, the fit cannot use it.
const SHORTEST: f64 = 1e-6;

impl Space {
    /// The space of a whitening and the columns of a model.
    ///
    /// # Arguments
    /// - `columns`: derivatives of the readings to the parameters of the model, m, those of the baseline first.
    pub(super) fn new(
        observations: &Observations,
        whitening: Whitening,
        parameters: &[BaselineParameter],
        columns: &[Vec<f64>],
    ) -> Self {
        let readings = observations.len();
        let mut space = Self {
            whitening,
            basis: Vec::new(),
            length: readings + parameters.len(),
        };
        for (index, column) in columns.iter().enumerate() {
            let mut white = space.white(column);
            if let Some(parameter) = parameters.get(index) {
                white[readings + index] = parameter.prior_sd.recip();
            }
            let before = norm(&white);
            space.project(&mut white);
            space.project(&mut white);
            let after = norm(&white);
            if after > SHORTEST && after > 1e-9 * before {
                for x in &mut white {
                    *x /= after;
                }
                space.basis.push(white);
            }
        }
        space
    }

    /// Orthonormal columns that the fit can absorb.
    pub(super) fn basis(&self) -> &[Vec<f64>] {
        &self.basis
    }

    /// A vector of readings, m, made white; the entries of the parameters are zero.
    pub(super) fn white(&self, readings_m: &[f64]) -> Vec<f64> {
        let mut white = Vec::with_capacity(self.length);
        white.extend_from_slice(readings_m);
        self.whitening.apply(&mut white);
        white.resize(self.length, 0.0);
        white
    }

    /// The same of a vector that counts in a range only, a union of cells, and is zero elsewhere.
    pub(super) fn white_part(&self, readings_m: &[f64], range: &Range<usize>) -> Vec<f64> {
        let mut white = vec![0.0; self.length];
        white[range.clone()].copy_from_slice(&readings_m[range.clone()]);
        self.whitening.apply_range(&mut white, range);
        white
    }

    /// Takes out what the fit can absorb.
    pub(super) fn project(&self, white: &mut [f64]) {
        widest(
            #[inline(always)]
            || {
                for column in &self.basis {
                    let product = sums_side_by_side(column, white);
                    for (value, unit) in white.iter_mut().zip(column) {
                        *value -= product * unit;
                    }
                }
            },
        );
    }

    /// Products of a white vector with what the fit can absorb.
    pub(super) fn absorbed(&self, white: &[f64]) -> Vec<f64> {
        self.basis.iter().map(|column| dot(column, white)).collect()
    }

    /// A vector of readings made white and projected.
    pub(super) fn projected(&self, readings_m: &[f64]) -> Vec<f64> {
        let mut white = self.white(readings_m);
        self.project(&mut white);
        white
    }
}

/// Scalar product.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    widest(
        #[inline(always)]
        || sums_side_by_side(a, b),
    )
}

/// Euclidean length.
pub(super) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
