//! Load cases as a least-squares problem.

use stiffbench_beams::physics::PlaceScale;
use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, Robot, RobotError};
use stiffbench_numeric::least_squares::{
    EvaluationFailure, JacobianView, LeastSquaresSettings, ResidualFunction,
};

use crate::fit::FitParameters;
use crate::parameters::{FitRole, ParameterChoice};

use super::compliances::ComplianceSolver;
use super::error::LoadCaseFitError;
use super::posed::PosedLoadCases;
use super::prediction::{PredictedRows, predict_rows};

/// A spring that moves the end by less than this share of what one of its kind does bears no load: the rest is rounding of angles.
const UNLOADED: f64 = 1e-7;

/// Difference to a linear model, as a share of the largest displacement, below which a model is linear: rounding of stiff links is far below.
const NOT_LINEAR: f64 = 1e-6;

/// A robot with values to begin at, and the load cases that it was measured under.
#[derive(Debug, Clone, Copy)]
pub struct LoadCaseModel<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Its mechanism.
    pub mechanism: &'a Mechanism,
    /// Values of the parameters; springs without one are rigid.
    pub start: &'a FittingFactors,
    /// The load cases.
    pub posed: &'a PosedLoadCases,
}

/// Residuals of all components: predicted less measured, each times its weight.
#[derive(Debug)]
pub(super) struct LoadCaseProblem<'a> {
    model: LoadCaseModel<'a>,
    solver: ComplianceSolver<'a>,
    parameters: FitParameters,
    measured: Vec<f64>,
    /// One a row; zero of a row that takes no part.
    weights: Vec<f64>,
    /// Where the model is linear in the coordinates: rows and columns at all coordinates zero.
    linear: Option<PredictedRows>,
}

impl LoadCaseModel<'_> {
    /// What the model predicts of every component with the values of the start, m and rad, in the order of [`PosedLoadCases::rows`].
    ///
    /// # Errors
    /// [`LoadCaseFitError`] for a pose that cannot be reached, or a structure that carries nothing.
    pub fn predicted(&self) -> Result<Vec<f64>, LoadCaseFitError> {
        let (robot, mechanism) = (self.robot, self.mechanism);
        let mut solver = ComplianceSolver::new(robot, mechanism, &[], self.start)?;
        Ok(predict_rows(&mut solver, self.posed, self.start, false)?.values)
    }

    /// What was measured, in the order of the rows.
    pub(super) fn measured(&self) -> Vec<f64> {
        self.posed.rows().map(|(_, read)| read.value).collect()
    }

    /// The coordinates of a fit: springs in units of the compliance that would give by itself all that was measured; and the free springs on
    /// which no load acts, which are kept.
    ///
    /// # Errors
    /// [`LoadCaseFitError`] for a pose, structure, tie or bounds that cannot be.
    pub(super) fn parameters(
        &self,
        choice: &ParameterChoice,
    ) -> Result<(FitParameters, Vec<ModelParameter>), LoadCaseFitError> {
        let list = choice.parameters();
        let springs: Vec<ModelParameter> =
            list.into_iter().filter(|one| !one.is_factor()).collect();
        let (robot, mechanism) = (self.robot, self.mechanism);
        let mut solver = ComplianceSolver::new(robot, mechanism, &springs, self.start)?;
        let rows = predict_rows(&mut solver, self.posed, self.start, true)?;
        let length = |vector: &[f64]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        let measured = length(&self.measured());
        let lengths: Vec<f64> = rows.columns.iter().map(|column| length(column)).collect();
        let column = |parameter: &ModelParameter| {
            let place = springs.iter().position(|spring| spring == parameter);
            place.map_or(0.0, |place| lengths[place])
        };
        let scale = |parameter: &ModelParameter| {
            let column = column(parameter);
            PlaceScale {
                compliance: if column > 0.0 { measured / column } else { 0.0 },
                ..PlaceScale::default()
            }
        };
        let mut choice = choice.clone();
        let mut unloaded = Vec::new();
        for spring in &springs {
            let alike = springs.iter().zip(&lengths);
            let alike = alike.filter(|(other, _)| other.unit() == spring.unit());
            let longest = alike.map(|(_, length)| *length).fold(0.0, f64::max);
            let mut members = choice.members.iter();
            let is_free = members.any(|m| m.parameter == *spring && m.role == FitRole::Free);
            if is_free && column(spring) <= UNLOADED * longest {
                choice.set(spring, FitRole::Fixed);
                unloaded.push(spring.clone());
            }
        }
        let parameters = FitParameters::with_scales(self.start, &choice, &scale)?;
        Ok((parameters, unloaded))
    }
}

impl<'a> LoadCaseProblem<'a> {
    /// # Errors
    /// [`LoadCaseFitError`] for a pose that cannot be reached or a structure that carries nothing.
    pub(super) fn new(
        model: LoadCaseModel<'a>,
        parameters: &FitParameters,
        weights: Vec<f64>,
    ) -> Result<Self, LoadCaseFitError> {
        let list = parameters.parameters();
        let (robot, mechanism) = (model.robot, model.mechanism);
        let mut solver = ComplianceSolver::new(robot, mechanism, list, model.start)?;
        let factors_move = list
            .iter()
            .enumerate()
            .any(|(place, one)| one.is_factor() && parameters.moves(place));
        let linear = if factors_move {
            None
        } else {
            linear_rows(&mut solver, model.posed, parameters)?
        };
        Ok(Self {
            measured: model.measured(),
            parameters: parameters.clone(),
            model,
            solver,
            weights,
            linear,
        })
    }

    /// The parameters.
    pub(super) fn parameters(&self) -> &FitParameters {
        &self.parameters
    }

    /// Whether every prediction is linear in the coordinates.
    pub(super) fn is_linear(&self) -> bool {
        self.linear.is_some()
    }

    /// Gives every row another weight.
    pub(super) fn set_weights(&mut self, weights: Vec<f64>) {
        self.weights = weights;
    }

    /// The weight of every row.
    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// When a fit has converged: of a model that is linear where double precision ends; else a compliance keeps about nine digits, so that
    /// a share of 1e-10 of ‖r‖² is the least that shows.
    pub(super) fn settings(&self) -> LeastSquaresSettings {
        if self.is_linear() {
            LeastSquaresSettings::default()
        } else {
            LeastSquaresSettings::for_refits()
        }
    }

    /// Predictions at a point of the coordinates.
    ///
    /// # Errors
    /// [`RobotError`].
    pub(super) fn predictions(&mut self, point: &[f64]) -> Result<Vec<f64>, RobotError> {
        if let Some(linear) = &self.linear {
            return Ok(linear.at(point));
        }
        Ok(self.rows(point, false)?.values)
    }

    /// The same of one named pose.
    ///
    /// # Errors
    /// [`RobotError`].
    pub(super) fn predictions_of(
        &mut self,
        point: &[f64],
        label: usize,
    ) -> Result<Vec<f64>, RobotError> {
        let all = self.predictions(point)?;
        let rows = self.model.posed.rows().zip(all);
        let own = rows.filter(|((case, _), _)| case.label == label);
        Ok(own.map(|(_, predicted)| predicted).collect())
    }

    fn rows(&mut self, point: &[f64], derivatives: bool) -> Result<PredictedRows, RobotError> {
        let factors = self.parameters.values(point);
        predict_rows(&mut self.solver, self.model.posed, &factors, derivatives)
    }
}

/// Rows at all coordinates zero, and columns; `None` if the model is not linear in the springs, as with those in a closed loop.
fn linear_rows(
    solver: &mut ComplianceSolver<'_>,
    posed: &PosedLoadCases,
    parameters: &FitParameters,
) -> Result<Option<PredictedRows>, RobotError> {
    let mut point = vec![0.0; parameters.parameters().len()];
    let mut rows = predict_rows(solver, posed, &parameters.values(&point), true)?;
    for (place, column) in rows.columns.iter_mut().enumerate() {
        let slope = parameters.slope(place);
        for value in column {
            *value *= slope;
        }
    }
    // Far from there, all springs at once: whatever is not linear shows.
    for (place, coordinate) in point.iter_mut().enumerate() {
        *coordinate = if parameters.moves(place) { 1.0 } else { 0.0 };
    }
    let exact = predict_rows(solver, posed, &parameters.values(&point), false)?.values;
    let linear = rows.at(&point);
    let size = exact
        .iter()
        .fold(0.0_f64, |size, value| size.max(value.abs()));
    let mut pairs = exact.iter().zip(&linear);
    let is_linear = pairs.all(|(a, b)| (a - b).abs() <= NOT_LINEAR * size);
    Ok(is_linear.then_some(rows))
}

impl ResidualFunction for LoadCaseProblem<'_> {
    fn residual_count(&self) -> usize {
        self.measured.len()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        let solved;
        let (rows, scaled) = if let Some(linear) = &self.linear {
            residuals.copy_from_slice(&linear.at(parameters));
            (linear, true)
        } else {
            let rows = self.rows(parameters, jacobian.is_some());
            solved = rows.map_err(EvaluationFailure::of_model)?;
            residuals.copy_from_slice(&solved.values);
            (&solved, false)
        };
        let weighed = residuals.iter_mut().zip(&self.measured).zip(&self.weights);
        for ((residual, measured), weight) in weighed {
            *residual = (*residual - measured) * weight;
        }
        let Some(jacobian) = jacobian else {
            return Ok(());
        };
        for (place, derivatives) in rows.columns.iter().enumerate() {
            let slope = if scaled {
                1.0
            } else {
                self.parameters.slope(place)
            };
            if let Some(column) = jacobian.column_mut(place) {
                let entries = column.iter_mut().zip(derivatives).zip(&self.weights);
                for ((entry, derivative), weight) in entries {
                    *entry = derivative * slope * weight;
                }
            }
        }
        Ok(())
    }

    fn label(&self, residual: usize) -> String {
        let posed = self.model.posed;
        posed.rows().nth(residual).map_or_else(
            || format!("residual {residual}"),
            |(case, read)| format!("pose {}, {}", posed.labels[case.label], read.name()),
        )
    }
}
