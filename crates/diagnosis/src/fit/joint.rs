//! Least squares on ln K of all chosen cells at once, and on the compliances along other axes than that of the load.
//!
//! The coordinates are those of [`FitParameters`]; a residual is ln K predicted less measured, whitened with
//! the full covariance of the measured ln K, whose calibration parts are common to all cells.

use nalgebra::{Cholesky, DMatrix, Dyn};

use stiffbench_beams::robot::{FittingFactors, RobotError};
use stiffbench_numeric::least_squares::{
    EvaluationFailure, JacobianView, LeastSquaresError, LeastSquaresFit, LeastSquaresSettings,
    ParameterSet, ResidualFunction, minimise,
};
use stiffbench_numeric::statistics::root_mean_square;
use stiffbench_units_and_text::test_point::Cell;

use super::cell_model::CellModel;
use super::error::FitError;
use super::measured::MeasuredStiffness;
use super::parameters::FitParameters;
use super::problem::FitProblem;
use super::shares::Shares;
use super::weighed_problem::WeighedProblem;

/// Least uncertainty of ln K that weights are made of. No bench comes near it; readings without scatter, from a simulation, would
/// otherwise be weighed beyond the nine digits of a solved structure, and no step of the fit could be told from another.
const LEAST_LN_UNCERTAINTY: f64 = 1e-5;

/// The problem of one joint fit.
#[derive(Debug)]
pub(super) struct JointProblem<'a> {
    model: CellModel<'a>,
    parameters: FitParameters,
    /// ln K of the cells, then compliances along other axes than that of the load over their unit.
    measured: Vec<f64>,
    /// Number of cells with a ln K.
    along: usize,
    /// Unit of the compliances, m/N.
    unit_m_per_n: f64,
    /// Covariance of what was measured; `None` if nothing is known of its uncertainty.
    covariance: Option<DMatrix<f64>>,
    whitening: CellWhitening,
    /// Root of how many times each whitened residual counts.
    root_counts: Vec<f64>,
    /// Stiffness of the cells, N/m, then compliances, m/N.
    values: Vec<f64>,
    shares: Vec<Shares>,
}

/// Turns differences of ln K into residuals of unit variance, and those of rows that are left out into nothing.
#[derive(Debug, Clone)]
struct CellWhitening {
    /// The rows that take part.
    kept: Vec<usize>,
    /// L⁻¹ of their covariance L Lᵀ, lower triangle row by row; `None` where nothing is known of the uncertainties: differences as they are.
    inverse: Option<Vec<f64>>,
}

impl<'a> JointProblem<'a> {
    /// # Errors
    /// Those of [`CellModel::new`].
    pub(super) fn new(
        problem: &FitProblem<'a>,
        parameters: &FitParameters,
    ) -> Result<Self, RobotError> {
        let measured = problem.measured;
        let compliances = measured.across.iter().map(|one| one.compliance_m_per_n);
        let unit_m_per_n = root_mean_square(compliances.clone()).filter(|unit| *unit > 0.0);
        let unit_m_per_n = unit_m_per_n.unwrap_or(1.0);
        let along = measured.cells.iter().map(|one| one.stiffness_n_per_m.ln());
        let across = compliances.map(|compliance| compliance / unit_m_per_n);
        let count = measured.values();
        let covariance = covariance_of(measured, unit_m_per_n);
        Ok(Self {
            model: problem.measured_model(parameters.parameters())?,
            parameters: parameters.clone(),
            measured: along.chain(across).collect(),
            along: measured.cells.len(),
            unit_m_per_n,
            whitening: CellWhitening::of(covariance.as_ref(), (0..count).collect()),
            covariance,
            root_counts: vec![1.0; count],
            values: vec![0.0; count],
            shares: vec![Vec::new(); count],
        })
    }

    /// Values of the parameters at a point of the coordinates.
    pub(super) fn factors(&self, point: &[f64]) -> FittingFactors {
        self.parameters.values(point)
    }

    /// The minimum from the start of `set`.
    ///
    /// # Errors
    /// [`LeastSquaresError`] if there is nothing to fit or the start has no value.
    pub(super) fn minimise(
        &mut self,
        set: &ParameterSet,
    ) -> Result<LeastSquaresFit, LeastSquaresError> {
        let settings = self.settings();
        minimise(self, set, &settings)
    }

    /// Replaces the measured ln K, keeping cells and weights: for resampling.
    pub(super) fn set_measured(&mut self, ln_stiffness: &[f64]) {
        self.measured[..self.along].copy_from_slice(ln_stiffness);
    }

    /// Counts each cell so many times: for resampled cells.
    pub(super) fn count_cells(&mut self, times: &[u32]) {
        let counts = times.iter().map(|&times| f64::from(times).sqrt());
        self.root_counts = counts.collect();
    }

    /// Differences of ln K as residuals of unit variance, each as often as it counts.
    fn weigh(&self, vector: &mut [f64]) {
        self.whitening.apply(vector);
        for (entry, root) in vector.iter_mut().zip(&self.root_counts) {
            *entry *= root;
        }
    }
}

impl ResidualFunction for JointProblem<'_> {
    fn residual_count(&self) -> usize {
        self.measured.len()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        let factors = self.factors(parameters);
        let shares = jacobian.is_some().then_some(&mut self.shares[..]);
        self.model
            .evaluate(&factors, &mut self.values, shares)
            .map_err(EvaluationFailure::of_model)?;
        let rows = self.values.iter().zip(&self.measured).enumerate();
        for (residual, (row, (value, measured))) in residuals.iter_mut().zip(rows) {
            let scaled = if row < self.along {
                value.ln()
            } else {
                value / self.unit_m_per_n
            };
            *residual = scaled - measured;
        }
        self.weigh(residuals);
        if let Some(jacobian) = jacobian {
            for parameter in 0..self.parameters.parameters().len() {
                if let Some(column) = jacobian.column_mut(parameter) {
                    let slope = self.parameters.slope(parameter);
                    for (row, (entry, shares)) in column.iter_mut().zip(&self.shares).enumerate() {
                        let unit = if row < self.along {
                            1.0
                        } else {
                            self.unit_m_per_n
                        };
                        *entry = shares[parameter] * slope / unit;
                    }
                    self.weigh(column);
                }
            }
        }
        Ok(())
    }

    fn label(&self, residual: usize) -> String {
        let cell = self.model.cell(residual);
        cell.map_or_else(|| format!("residual {residual}"), Cell::to_string)
    }
}

impl WeighedProblem for JointProblem<'_> {
    fn parameters(&self) -> &FitParameters {
        &self.parameters
    }

    /// A compliance keeps about nine digits in the worst mechanism (3e-10 against OpenSees); with weights of 1/0.002, or scatter of a few
    /// percent and none, that hides reductions of ‖r‖² below some 1e-8 of it, and a fit asked for less would wander. A share of 1e-6, or 1e-6
    /// in units of the variance, is a step of a thousandth of a standard error; 1e-16 without weights stands for ln K itself to eight digits.
    fn settings(&self) -> LeastSquaresSettings {
        LeastSquaresSettings {
            max_evaluations: 200,
            reduction_tolerance: 1e-6,
            negligible_reduction: if self.covariance.is_some() {
                1e-6
            } else {
                1e-16
            },
            step_tolerance: 1e-9,
            ..LeastSquaresSettings::default()
        }
    }

    fn leave_out(&mut self, is_left_out: &dyn Fn(usize) -> bool) {
        let kept = (0..self.measured.len()).filter(|row| !is_left_out(*row));
        self.whitening = CellWhitening::of(self.covariance.as_ref(), kept.collect());
    }

    /// Stiffness of the cells, N/m, then compliances, m/N.
    fn predict(&mut self, point: &[f64]) -> Result<Vec<f64>, FitError> {
        let mut values = vec![0.0; self.measured.len()];
        self.model
            .evaluate(&self.factors(point), &mut values, None)?;
        Ok(values)
    }
}

/// Covariance of ln K, and of compliances in their unit; `None` if nothing is known of the uncertainties.
fn covariance_of(measured: &MeasuredStiffness, unit_m_per_n: f64) -> Option<DMatrix<f64>> {
    let own = measured.own_covariance()?;
    let along = measured.cells.iter().map(|cell| {
        let parts = cell.ln_uncertainty.unwrap_or_default();
        (
            1.0,
            [parts.force_calibration, parts.displacement_calibration],
        )
    });
    let across = measured.across.iter().map(|one| {
        let calibration = one.calibration_m_per_n.map(|effect| effect / unit_m_per_n);
        (unit_m_per_n, calibration)
    });
    let rows: Vec<(f64, [f64; 2])> = along.chain(across).collect();
    Some(DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
        let ((unit, [a, b]), (other, [c, d])) = (rows[i], rows[j]);
        let least = if i == j { LEAST_LN_UNCERTAINTY } else { 0.0 };
        own[(i, j)] / (unit * other) + least * least + a * c + b * d
    }))
}

impl CellWhitening {
    /// # Arguments
    /// - `covariance`: of all rows; `None` if nothing is known of the uncertainties.
    fn of(covariance: Option<&DMatrix<f64>>, kept: Vec<usize>) -> Self {
        let inverse = covariance.and_then(|covariance| {
            let own = covariance.select_rows(&kept).select_columns(&kept);
            // Uncertainties that are no numbers weigh nothing against one another.
            let factor: Cholesky<f64, Dyn> = own.cholesky()?;
            let identity = DMatrix::identity(kept.len(), kept.len());
            let inverse = factor.l_dirty().solve_lower_triangular(&identity)?;
            let lower = (0..kept.len()).flat_map(|i| (0..=i).map(move |j| (i, j)));
            Some(lower.map(|at| inverse[at]).collect())
        });
        Self { kept, inverse }
    }

    /// Makes differences white in place.
    fn apply(&self, vector: &mut [f64]) {
        let own: Vec<f64> = self.kept.iter().map(|row| vector[*row]).collect();
        vector.fill(0.0);
        for (i, &row) in self.kept.iter().enumerate() {
            vector[row] = self.inverse.as_ref().map_or(own[i], |inverse| {
                let weights = &inverse[i * (i + 1) / 2..][..=i];
                weights.iter().zip(&own).map(|(a, b)| a * b).sum()
            });
        }
    }
}
