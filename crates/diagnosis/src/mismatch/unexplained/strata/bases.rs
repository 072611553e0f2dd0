//! Nested spaces of readings: columns that live in one cell each, and few that run through all cells.
//!
//! A stratum of the decomposition is what one fit explains beyond another. Almost all columns (zeros, slopes, levels of load) belong to
//! one cell, and whitening does not mix cells: they are made orthonormal cell by cell. The factors and the clock run through all cells;
//! they are few.

use rayon::prelude::*;

use super::contrasts::{Basis, Stage};
use crate::mismatch::noise::NoiseCovariance;
use crate::mismatch::observed::Observations;
use crate::search::{RowVector, dot, norm, push_orthonormal, push_orthonormal_rows, subtract};

/// Columns of one cell, each with the readings between the first and the last that it is not zero in.
pub(super) type CellColumns = Vec<RowVector>;

/// Columns that run through all cells.
pub(super) type WholeColumns = Vec<Vec<f64>>;

/// Orthonormal columns of each cell, stage by stage.
#[derive(Debug, Clone)]
pub(super) struct LocalBasis {
    basis: Basis,
    cells: Vec<StratumBasis>,
}

#[derive(Debug, Clone)]
struct StratumBasis {
    columns: CellColumns,
    /// Number of columns up to each stage.
    ends: Vec<usize>,
}

impl LocalBasis {
    /// Makes the columns of all stages white and orthonormal, each stage to those before it.
    ///
    /// # Arguments
    /// - `columns`: those of a stage in a cell, m.
    pub(super) fn new(
        observations: &Observations,
        whitening: &NoiseCovariance,
        basis: Basis,
        columns: &(dyn Fn(Stage, usize) -> CellColumns + Sync),
    ) -> Self {
        let cells = (0..observations.cells.len())
            .into_par_iter()
            .map(|cell| {
                let mut own = StratumBasis {
                    columns: Vec::new(),
                    ends: Vec::new(),
                };
                for &stage in basis.stages() {
                    for column in columns(stage, cell) {
                        let white = whitening.covariance.whiten_vector(&column);
                        push_orthonormal_rows(&mut own.columns, white, stage.least());
                    }
                    own.ends.push(own.columns.len());
                }
                own
            })
            .collect();
        Self { basis, cells }
    }

    /// Takes out of a white vector the columns of each cell up to its stage.
    fn take_out(&self, stages: &[usize], vector: &mut [f64]) {
        for (cell, &stage) in self.cells.iter().zip(stages) {
            for column in &cell.columns[..cell.ends[stage]] {
                remove(&mut vector[column.rows()], &column.values);
            }
        }
    }

    /// For each cell the squares of a white vector along its columns up to each stage.
    pub(super) fn squares_along(&self, white: &[f64]) -> Vec<Vec<f64>> {
        let of_cell = |cell: &StratumBasis| {
            let mut sum = 0.0;
            let mut first = 0;
            let up_to = cell.ends.iter().map(|&end| {
                let columns = cell.columns[first..end].iter();
                sum += columns.map(|unit| unit.dot(white).powi(2)).sum::<f64>();
                first = end;
                sum
            });
            up_to.collect()
        };
        self.cells.iter().map(of_cell).collect()
    }

    fn rank(&self, stages: &[usize]) -> usize {
        let ranks = self.cells.iter().zip(stages);
        ranks.map(|(cell, &stage)| cell.ends[stage]).sum()
    }
}

/// A column that runs through all cells.
#[derive(Debug, Clone)]
pub(super) struct GlobalColumn {
    /// White.
    pub(super) white: Vec<f64>,
    /// Share of its length below which it counts as spanned.
    pub(super) least_share: f64,
    /// White length below which it counts as spanned.
    pub(super) least: f64,
}

/// The space of local columns up to a stage (which may differ between cells) and of global columns.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// That of the local columns.
    pub(super) basis: Basis,
    stages: Vec<usize>,
    /// Global columns, orthonormal to each other and to the local ones.
    extra: Vec<Vec<f64>>,
    pub(super) rank: usize,
}

impl Fit {
    /// # Arguments
    /// - `stages`: of each cell.
    pub(super) fn new(
        basis: &LocalBasis,
        stages: impl Iterator<Item = Stage>,
        globals: &[&GlobalColumn],
    ) -> Self {
        let stages: Vec<usize> = stages.map(|stage| basis.basis.before(stage)).collect();
        let mut fit = Self {
            basis: basis.basis,
            rank: basis.rank(&stages),
            stages,
            extra: Vec::new(),
        };
        for column in globals {
            fit.extra
                .extend(fit.beyond(basis, std::slice::from_ref(column)));
        }
        fit.rank += fit.extra.len();
        fit
    }

    /// Orthonormal columns that other global columns add to this space.
    pub(super) fn beyond(&self, basis: &LocalBasis, columns: &[GlobalColumn]) -> WholeColumns {
        let mut all = self.extra.clone();
        for column in columns {
            let whole = norm(&column.white);
            let mut white = column.white.clone();
            basis.take_out(&self.stages, &mut white);
            basis.take_out(&self.stages, &mut white);
            let least = column.least.max(column.least_share * whole);
            push_orthonormal(&mut all, white, 0.0, least);
        }
        all.split_off(self.extra.len())
    }

    /// What a white vector has outside this space.
    pub(super) fn left(&self, basis: &LocalBasis, white: &[f64]) -> Vec<f64> {
        let mut left = white.to_vec();
        basis.take_out(&self.stages, &mut left);
        for column in &self.extra {
            remove(&mut left, column);
        }
        left
    }

    /// Squares of a white vector within this space.
    ///
    /// # Arguments
    /// - `local`: its squares along the local columns.
    pub(super) fn squares_within(&self, local: &[Vec<f64>], white: &[f64]) -> f64 {
        let local = local.iter().zip(&self.stages);
        let extra = self.extra.iter().map(|unit| dot(unit, white).powi(2));
        local.map(|(cell, &stage)| cell[stage]).chain(extra).sum()
    }

    /// For each reading, the share of its own error that this space leaves: the diagonal of I - P.
    pub(super) fn leverage_left(&self, basis: &LocalBasis, readings: usize) -> Vec<f64> {
        let mut out = vec![1.0; readings];
        for (cell, &stage) in basis.cells.iter().zip(&self.stages) {
            for column in &cell.columns[..cell.ends[stage]] {
                for (value, c) in out[column.rows()].iter_mut().zip(&column.values) {
                    *value -= c * c;
                }
            }
        }
        for column in &self.extra {
            for (value, c) in out.iter_mut().zip(column) {
                *value -= c * c;
            }
        }
        out
    }
}

fn remove(vector: &mut [f64], unit: &[f64]) {
    let product = dot(unit, vector);
    if product != 0.0 {
        subtract(vector, product, unit);
    }
}
