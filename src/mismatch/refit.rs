//! Baseline and effects fitted together to the readings, in the white space of one noise.

use crate::least_squares::{
    EvaluationFailure, JacobianView, LeastSquaresSettings, Parameter, ParameterSet,
    ResidualFunction, minimise,
};
use crate::physics::{Effect, Law, Place, Sign};

use super::baseline::Baseline;
use super::changes::Frozen;
use super::error::MismatchError;
use super::noise::Whitening;
use super::observations::Observations;
use super::predictor::ReadingPredictor;

/// A model of the readings: values of the baseline's parameters, and effects.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Model {
    pub(super) parameters: Vec<f64>,
    pub(super) effects: Vec<Effect>,
}

/// A model fitted to the readings.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub(super) model: Model,
    /// Weighted squares of the readings and of what was known of the parameters.
    pub(super) squares: f64,
}

/// Which values of a law a fit moves by derivatives; the others, on which readings depend by kinks and steps, are searched.
pub(super) fn is_smooth(law: Law, parameter: usize) -> bool {
    parameter == 0 || matches!(law, Law::JointNonlinearity | Law::GaugePeriodic)
}

/// A reduction of the weighted squares below this decides nothing.
const NEGLIGIBLE: f64 = 1e-3;

/// Readings used by a fit: those where `weight` is not zero (held-out readings have none).
#[derive(Clone, Copy)]
pub(super) struct Refit<'a> {
    pub(super) baseline: &'a dyn Baseline,
    pub(super) observations: &'a Observations,
    pub(super) whitening: &'a Whitening,
    /// Readings that count; all if `None`.
    pub(super) kept: Option<&'a [bool]>,
    /// Bounds of the values of the last effect; those of the sign alone if `None`.
    pub(super) bounds_of_last: Option<&'a [[f64; 2]]>,
    /// The structure whose twists serve until the fit is near its end.
    pub(super) near: Option<Near<'a>>,
}

/// A structure near that of a fit.
#[derive(Clone, Copy)]
pub(super) enum Near<'a> {
    /// A known one.
    Known(&'a Frozen),
    /// The one at the start.
    Start,
}

impl Refit<'_> {
    /// Fits from a start; `None` if the start is no structure, or lies where its law turns back.
    pub(super) fn fit(
        &self,
        predictor: &mut ReadingPredictor<'_>,
        start: &Model,
        move_effects: bool,
    ) -> Option<Fitted> {
        let in_a_joint = |effect: &Effect| matches!(effect.place, Place::Joint(_));
        let near = self.near.filter(|_| start.effects.iter().any(in_a_joint));
        let first = near.and_then(|near| {
            match near {
                Near::Known(frozen) => predictor.hold_joints(Some(frozen)),
                Near::Start => predictor
                    .hold_joints_as_at(&start.parameters, &start.effects)
                    .ok()?,
            }
            let first = self.fit_from(predictor, start, move_effects);
            predictor.hold_joints(None);
            first
        });
        let start = first.as_ref().map_or(start, |first| &first.model);
        self.fit_from(predictor, start, move_effects)
    }

    fn fit_from(
        &self,
        predictor: &mut ReadingPredictor<'_>,
        start: &Model,
        move_effects: bool,
    ) -> Option<Fitted> {
        let mut problem = Problem {
            refit: self,
            predictor,
            effects: start.effects.clone(),
            scratch: vec![0.0; self.observations.len()],
            shifted: vec![0.0; self.observations.len()],
            gradient: vec![0.0; self.observations.len() * self.baseline.parameters().len()],
        };
        let set = self.parameter_set(start, move_effects);
        let settings = LeastSquaresSettings {
            max_evaluations: 40,
            negligible_reduction: NEGLIGIBLE,
            ..LeastSquaresSettings::for_refits()
        };
        let fit = minimise(&mut problem, &set.ok()?, &settings).ok()?;
        let parameters = self.baseline.parameters().len();
        let mut effects = start.effects.clone();
        put_values(&mut effects, &fit.values[parameters..]);
        Some(Fitted {
            model: Model {
                parameters: fit.values[..parameters].to_vec(),
                effects,
            },
            squares: fit.sum_of_squares(),
        })
    }

    fn parameter_set(
        &self,
        start: &Model,
        move_effects: bool,
    ) -> Result<ParameterSet, crate::least_squares::LeastSquaresError> {
        let of_baseline = self
            .baseline
            .parameters()
            .iter()
            .zip(&start.parameters)
            .map(|(parameter, &value)| {
                let (lower, upper) = (parameter.lower, parameter.upper);
                Parameter::free(&parameter.name, value.clamp(lower, upper), lower, upper)
            });
        let last = start.effects.len().wrapping_sub(1);
        let of_effects = start
            .effects
            .iter()
            .enumerate()
            .flat_map(|(place, effect)| {
                let bounds = self.bounds_of_last.filter(|_| place == last);
                effect
                    .law
                    .parameters()
                    .iter()
                    .zip(&effect.values)
                    .enumerate()
                    .map(move |(index, (parameter, &value))| {
                        let name = format!("{place}.{}", parameter.name);
                        if !(move_effects && is_smooth(effect.law, index)) {
                            return Parameter::fixed(name, value);
                        }
                        let lower = if parameter.sign == Sign::Positive {
                            0.0
                        } else {
                            f64::NEG_INFINITY
                        };
                        let [lower, upper] = bounds
                            .filter(|_| (effect.law, index) != (Law::JointNonlinearity, 1))
                            .and_then(|bounds| bounds.get(index).copied())
                            .unwrap_or([lower, f64::INFINITY]);
                        Parameter::free(name, value.clamp(lower, upper), lower, upper)
                    })
            });
        ParameterSet::new(of_baseline.chain(of_effects).collect())
    }

    /// White residuals of a model, those of the parameters behind them, and their squares.
    pub(super) fn residuals(
        &self,
        predictor: &mut ReadingPredictor<'_>,
        model: &Model,
    ) -> Result<Option<Vec<f64>>, MismatchError> {
        let mut residuals = vec![0.0; self.observations.len()];
        if !predictor.predict(&model.parameters, &model.effects, &mut residuals)? {
            return Ok(None);
        }
        self.whiten_residuals(&mut residuals);
        self.append_parameters(&model.parameters, &mut residuals);
        Ok(Some(residuals))
    }

    fn whiten_residuals(&self, predicted: &mut [f64]) {
        for (value, displacement) in predicted.iter_mut().zip(&self.observations.displacement_m) {
            *value = displacement - *value;
        }
        self.whiten(predicted);
    }

    /// Whitens a vector of readings in which those held out count nothing.
    fn whiten(&self, values: &mut [f64]) {
        self.drop_held_out(values);
        self.whitening.apply(values);
    }

    fn drop_held_out(&self, values: &mut [f64]) {
        if let Some(kept) = self.kept {
            for (value, kept) in values.iter_mut().zip(kept) {
                if !kept {
                    *value = 0.0;
                }
            }
        }
    }

    fn append_parameters(&self, parameters: &[f64], residuals: &mut Vec<f64>) {
        for (parameter, value) in self.baseline.parameters().iter().zip(parameters) {
            residuals.push((parameter.start - value) / parameter.prior_sd);
        }
    }
}

fn put_values(effects: &mut [Effect], values: &[f64]) {
    let all = effects.iter_mut().flat_map(|effect| &mut effect.values);
    for (target, value) in all.zip(values) {
        *target = *value;
    }
}

struct Problem<'r, 'a, 'p> {
    refit: &'r Refit<'a>,
    predictor: &'r mut ReadingPredictor<'p>,
    effects: Vec<Effect>,
    scratch: Vec<f64>,
    shifted: Vec<f64>,
    gradient: Vec<f64>,
}

/// The structure does not exist with these effects.
#[derive(Debug, thiserror::Error)]
#[error("there is no such structure")]
struct NoStructure;

impl ResidualFunction for Problem<'_, '_, '_> {
    fn residual_count(&self) -> usize {
        self.scratch.len() + self.refit.baseline.parameters().len()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        let count = self.refit.baseline.parameters().len();
        let (of_baseline, of_effects) = parameters.split_at(count);
        put_values(&mut self.effects, of_effects);
        if self.turns_back() {
            return Err(EvaluationFailure::of_model(NoStructure));
        }
        let n = self.scratch.len();
        let there = self
            .predictor
            .predict(of_baseline, &self.effects, &mut self.scratch)
            .map_err(EvaluationFailure::of_model)?;
        if !there {
            return Err(EvaluationFailure::of_model(NoStructure));
        }
        residuals[..n].copy_from_slice(&self.scratch);
        self.refit.whiten_residuals(&mut residuals[..n]);
        let known = self.refit.baseline.parameters();
        for ((residual, parameter), value) in residuals[n..].iter_mut().zip(known).zip(of_baseline)
        {
            *residual = (parameter.start - value) / parameter.prior_sd;
        }
        if let Some(jacobian) = jacobian {
            self.baseline_columns(of_baseline, jacobian)?;
            self.effect_columns(of_baseline, count, jacobian)?;
        }
        Ok(())
    }
}

impl Problem<'_, '_, '_> {
    /// Whether the quadratic term of the last effect has left its bounds, which are those of its ratio to the linear one.
    fn turns_back(&self) -> bool {
        let (Some(bounds), Some(effect)) = (self.refit.bounds_of_last, self.effects.last()) else {
            return false;
        };
        effect.law == Law::JointNonlinearity && {
            let [lower, upper] = bounds[1];
            effect.values[1] < lower * effect.values[0]
                || effect.values[1] > upper * effect.values[0]
        }
    }

    fn baseline_columns(
        &mut self,
        of_baseline: &[f64],
        jacobian: &mut JacobianView<'_>,
    ) -> Result<(), EvaluationFailure> {
        let n = self.scratch.len();
        self.predictor
            .gradient(of_baseline, &self.effects, &mut self.gradient)
            .map_err(EvaluationFailure::of_model)?;
        let known = self.refit.baseline.parameters();
        for (index, (column, parameter)) in self.gradient.chunks_mut(n).zip(known).enumerate() {
            self.refit.whiten(column);
            if let Some(out) = jacobian.column_mut(index) {
                for (target, value) in out.iter_mut().zip(column.iter()) {
                    *target = -value;
                }
                out[n + index] = -parameter.prior_sd.recip();
            }
        }
        Ok(())
    }

    /// Differences: the readings are cheap once the structure is solved.
    fn effect_columns(
        &mut self,
        of_baseline: &[f64],
        count: usize,
        jacobian: &mut JacobianView<'_>,
    ) -> Result<(), EvaluationFailure> {
        let mut parameter = count;
        for effect in 0..self.effects.len() {
            for value in 0..self.effects[effect].values.len() {
                if let Some(out) = jacobian.column_mut(parameter) {
                    let before = self.effects[effect].values[value];
                    let step = step_of(&self.effects[effect], value);
                    self.effects[effect].values[value] = before + step;
                    self.predictor
                        .predict(of_baseline, &self.effects, &mut self.shifted)
                        .map_err(EvaluationFailure::of_model)?;
                    self.effects[effect].values[value] = before;
                    for (shifted, value) in self.shifted.iter_mut().zip(&self.scratch) {
                        *shifted = (*shifted - value) / step;
                    }
                    self.refit.whiten(&mut self.shifted);
                    for (target, value) in out.iter_mut().zip(&self.shifted) {
                        *target = -value;
                    }
                }
                parameter += 1;
            }
        }
        Ok(())
    }
}

/// Step of a difference: a thousandth of the value; from zero, a size at which the effect can be told from rounding.
pub(super) fn step_of(effect: &Effect, value: usize) -> f64 {
    let now = effect.values[value];
    match (effect.law, value) {
        // A phase is near its value everywhere.
        (Law::GaugePeriodic, 2) => 1e-4,
        // A period is known to a share of itself; the sine turns with the displacement over it.
        (Law::GaugePeriodic, 1) => 1e-6 * now,
        // From q = 0 the step is a share of the linear term.
        (Law::JointNonlinearity, 1) => 1e-3 * now.abs().max(1e-3 * effect.values[0]),
        _ if now == 0.0 => 1e-9,
        _ => 1e-3 * now,
    }
}
