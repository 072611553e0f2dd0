//! The plain engine: every formula written out with dense matrices. Slow; what the fast one is compared with.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::search::constants::SAMPLES_TOGETHER;
use crate::search::engine::{Moments, NullMaxima, NullShape, NullShapes, PairMoments, ScoreEngine};
use crate::search::null_noise::NullNoise;
use crate::search::vectors::RowVector;

/// Scores by P = V⁻¹ - V⁻¹ X (Xᵀ V⁻¹ X)⁻¹ Xᵀ V⁻¹ as one dense matrix: with s a shape and y the rows, the square is sᵀ P s and the product
/// sᵀ P y.
#[derive(Debug)]
pub(crate) struct Plain {
    rows: usize,
    /// P, for the rows and behind them the priors.
    projector: DMatrix<f64>,
    y: DVector<f64>,
    /// I - X (Xᵀ X)⁻¹ Xᵀ, X the baseline's columns in the white space of the null samples.
    white_projector: DMatrix<f64>,
}

impl Plain {
    /// # Arguments
    /// - `covariance`: V, dense.
    /// - `prior_sd`: of the parameters of the first columns.
    /// - `columns`: of the baseline, X.
    /// - `white_columns`: the same as null samples see them.
    /// - `y`: rows, as many as V has, and behind them one number for each prior.
    pub(crate) fn new(
        covariance: &DMatrix<f64>,
        prior_sd: &[f64],
        columns: &[Vec<f64>],
        white_columns: &[Vec<f64>],
        y: &[f64],
    ) -> Self {
        let rows = covariance.nrows();
        let all = rows + prior_sd.len();
        let mut v = DMatrix::identity(all, all);
        v.view_mut((0, 0), (rows, rows)).copy_from(covariance);
        let x = DMatrix::from_fn(all, columns.len(), |row, column| {
            if row < rows {
                columns[column][row]
            } else if row - rows == column {
                prior_sd[column].recip()
            } else {
                0.0
            }
        });
        let white = DMatrix::from_fn(all, columns.len(), |i, j| white_columns[j][i]);
        Self {
            rows,
            projector: beside(&v, &x),
            y: DVector::from_column_slice(y),
            white_projector: beside(&DMatrix::identity(all, all), &white),
        }
    }

    fn in_rows(&self, shape: &[f64], rows: &Range<usize>) -> DVector<f64> {
        let counts = |row: usize| row < self.rows && rows.contains(&row);
        DVector::from_fn(
            self.y.len(),
            |row, _| {
                if counts(row) { shape[row] } else { 0.0 }
            },
        )
    }

    fn product(&self, a: &DVector<f64>, b: &DVector<f64>) -> f64 {
        a.dot(&(&self.projector * b))
    }

    fn moments_of(&self, shape: &DVector<f64>) -> Moments {
        Moments {
            square: self.product(shape, shape),
            product: self.product(shape, &self.y),
        }
    }
}

/// V⁻¹ - V⁻¹ X (Xᵀ V⁻¹ X)⁻¹ Xᵀ V⁻¹.
fn beside(v: &DMatrix<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
    let inverse = v.clone().try_inverse().expect("V has an inverse");
    if x.ncols() == 0 {
        return inverse;
    }
    let of_x = &inverse * x;
    let normal = (x.transpose() * &of_x).try_inverse();
    &inverse - &of_x * normal.expect("columns are independent") * of_x.transpose()
}

/// Δχ² of a shape on projected noise: the best amplitude within its bounds, or of two vectors the sum of both.
fn delta_chi2(shape: &NullShape, noise: &DVector<f64>) -> f64 {
    let along = |unit: &RowVector| unit.dot(noise.as_slice());
    let z: Vec<f64> = shape.units.iter().map(along).collect();
    if z.len() > 1 {
        return z.iter().map(|z| z * z).sum();
    }
    let [low, high] = shape.multiples.map(|multiple| multiple * shape.length);
    let size = z[0].clamp(low, high);
    size * (2.0 * z[0] - size)
}

impl ScoreEngine for Plain {
    fn moments(&self, shape: &[f64], rows: &Range<usize>, _: &mut Vec<f64>) -> Moments {
        self.moments_of(&self.in_rows(shape, rows))
    }

    fn pair_moments(
        &self,
        shapes: [&[f64]; 2],
        rows: &Range<usize>,
        _: &mut Vec<f64>,
    ) -> PairMoments {
        let [first, second] = shapes.map(|shape| self.in_rows(shape, rows));
        let share = self.product(&first, &second) / self.product(&first, &first);
        PairMoments {
            first: self.moments_of(&first),
            second: self.moments_of(&(second - share * first)),
        }
    }

    fn null_maxima(
        &self,
        groups: Vec<NullShapes<'_>>,
        families: usize,
        _: &[Range<usize>],
        noise: &NullNoise<'_>,
    ) -> NullMaxima {
        let length = self.y.len();
        let shapes: Vec<NullShape> = groups.into_iter().flat_map(|group| group()).collect();
        let mut maxima = vec![Vec::new(); families];
        for block in 0..noise.blocks() {
            let numbers = noise.block(block, length);
            for sample in 0..SAMPLES_TOGETHER {
                let of_row = |row, _| f64::from(numbers[row * SAMPLES_TOGETHER + sample]);
                let projected = &self.white_projector * DVector::from_fn(length, of_row);
                for (family, maxima) in maxima.iter_mut().enumerate() {
                    let own = shapes.iter().filter(|shape| shape.family == family);
                    let scores = own.map(|shape| delta_chi2(shape, &projected));
                    maxima.push(scores.fold(0.0, f64::max));
                }
            }
        }
        maxima
    }
}
