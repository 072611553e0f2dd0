//! Baseline and effects fitted together to the readings, in the white space of one noise.

use stiffbench_beams::physics::{Effect, FitBy, ParameterSpec};
use stiffbench_numeric::least_squares::{
    CovarianceSettings, EvaluationFailure, JacobianView, LeastSquaresFit, LeastSquaresSettings,
    Parameter, ParameterRole, ParameterSet, ProfileEnd, ProfileSettings, ResidualFunction,
    SigmaMode, covariance, minimise, profile,
};

use super::diagnosis_problem::DiagnosisProblem;
use super::linearised::LinearisedModel;
use super::model::{FittedModel, Model, kinked, moved_values, put_values};
use super::place_scales::PlaceScales;
use super::predictor::ReadingPredictor;
use super::stated::Stated;
use crate::mismatch::baselines::BaselineParameter;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::NoiseCovariance;
use crate::mismatch::observed::Observations;

/// What of a model lies within a rise of the weighted squares.
pub(crate) struct ValueProfile {
    /// Ends of what is stated.
    pub(crate) ends: [ProfileEnd; 2],
    /// Its bounds.
    pub(crate) bounds: [f64; 2],
    /// Models between them.
    pub(crate) inside: Vec<Model>,
}

/// Where the weighted squares of a model are least.
pub(crate) struct LowestPoint {
    set: ParameterSet,
    fit: LeastSquaresFit,
}

impl LowestPoint {
    /// The fit with the value at a place held at a level, and its parameters.
    fn at_level(
        &self,
        problem: &mut FitResiduals<'_, '_, '_>,
        place: usize,
        level: f64,
    ) -> Option<(LeastSquaresFit, ParameterSet)> {
        let start = self.set.with_start(&self.fit.free_values).ok()?;
        let mut parameters = start.parameters().to_vec();
        parameters[place] = Parameter::fixed("level", level);
        let set = ParameterSet::with_any_number_of_free(parameters).ok()?;
        let settings = settings(problem.refit.observations);
        let fit = minimise(problem, &set, &settings).ok()?;
        Some((fit, set))
    }
}

/// How every model is fitted: a reduction of the weighted squares below a thousandth decides nothing; nor does one below a millionth of them in the
/// recording of a part, where a law counts by its share of what is left.
fn settings(observations: &Observations) -> LeastSquaresSettings {
    let refits = LeastSquaresSettings::for_refits();
    LeastSquaresSettings {
        max_evaluations: 40,
        negligible_reduction: 1e-3,
        reduction_tolerance: if observations.is_recording() {
            1e-6
        } else {
            refits.reduction_tolerance
        },
        ..refits
    }
}

/// Readings used by a fit: those where `weight` is not zero (held-out readings have none).
#[derive(Clone, Copy)]
pub(crate) struct WeightedFit<'w, 'a> {
    /// Predicts the readings; its scales bound the values of all effects.
    pub(crate) problem: &'w DiagnosisProblem<'a>,
    /// Its readings, or others that were read in their place.
    pub(crate) observations: &'w Observations,
    pub(crate) whitening: &'w NoiseCovariance,
    /// Narrower bounds of the values of the last effect.
    pub(crate) bounds_of_last: Option<&'w [[f64; 2]]>,
    /// The structure whose twists serve until the fit is near its end.
    pub(crate) warm_start: Option<WarmStart<'w>>,
}

/// A structure near that of a fit.
#[derive(Clone, Copy)]
pub(crate) enum WarmStart<'a> {
    /// A known one.
    Known(&'a LinearisedModel),
    /// The one at the start.
    Start,
}

impl<'a> WeightedFit<'_, 'a> {
    /// Fits from a start; `None` if the start is no structure.
    pub(crate) fn fit(&self, start: &Model) -> Option<FittedModel> {
        let predictor = &mut self.problem.predictor();
        let in_a_joint = |effect: &Effect| effect.place.joint().is_some();
        let warm_start = self
            .warm_start
            .filter(|_| start.effects.iter().any(in_a_joint));
        let first = warm_start.and_then(|warm_start| {
            match warm_start {
                WarmStart::Known(linearised) => predictor.hold_joints(Some(linearised)),
                WarmStart::Start => predictor
                    .hold_joints_as_at(&start.parameters, &start.effects)
                    .ok()?,
            }
            let first = self.fit_from(predictor, start);
            predictor.hold_joints(None);
            first
        });
        let start = first.as_ref().map_or(start, |first| &first.model);
        self.fit_from(predictor, start)
    }

    fn fit_from(&self, predictor: &mut ReadingPredictor<'a>, start: &Model) -> Option<FittedModel> {
        let mut problem = FitResiduals::new(self, predictor, start);
        let set = self.parameter_set(start, ParameterSpec::is_smooth).ok()?;
        let fit = minimise(&mut problem, &set, &settings(self.observations)).ok()?;
        Some(FittedModel {
            model: start.with_moved(&fit.values),
            squares: fit.sum_of_squares(),
        })
    }

    /// The lowest point about a model, from which profiles go out; every value moves.
    pub(crate) fn lowest(&self, model: &Model) -> Option<LowestPoint> {
        let set = self.parameter_set(model, |one| !one.is_reference()).ok()?;
        let predictor = &mut self.problem.predictor();
        let mut problem = FitResiduals::new(self, predictor, model);
        let fit = minimise(&mut problem, &set, &settings(self.observations)).ok()?;
        Some(LowestPoint { set, fit })
    }

    /// The models at which the weighted squares, all but what is stated refitted, rise by at most `rise` over their least; `None` where it cannot be
    /// followed at all.
    pub(crate) fn profile(
        &self,
        (model, lowest): (&Model, &LowestPoint),
        stated: Stated,
        rise: f64,
    ) -> Option<ValueProfile> {
        let (predictor, scales) = (&mut self.problem.predictor(), self.problem.scales());
        // A three-hundredth of a half-length is less than an interval is read to.
        let follow = ProfileSettings {
            refits: settings(self.observations),
            tolerance: 3e-3,
            max_refits: 20,
        };
        let mut problem = FitResiduals::new(self, predictor, model);
        let place = stated.place(model.parameters.len(), &model.effects);
        let made_of = stated.made_of(&model.effects);
        let (mut set, mut moved_fit) = (&lowest.set, None);
        let of_made;
        if let Some((effect, _)) = made_of {
            let there = model.with_moved(&lowest.fit.values);
            let [low, high] = self.bounds_of(&there.effects[effect], stated);
            let number = stated.of_effect(&there.effects[effect], scales);
            let start = lowest.set.with_start(&lowest.fit.free_values).ok()?;
            let mut parameters = start.parameters().to_vec();
            parameters[place] = Parameter::free("made", number.clamp(low, high), low, high);
            of_made = ParameterSet::new(parameters).ok()?;
            set = &of_made;
            problem.made = Some(stated);
            moved_fit = Some(minimise(&mut problem, set, &settings(self.observations)).ok()?);
        }
        let fit = moved_fit.as_ref().unwrap_or(&lowest.fit);
        let found = profile(&mut problem, set, fit, place, rise, &follow).ok()?;
        let inside = found.inside.iter().map(|all| {
            let mut inside = model.with_moved(all);
            if let Some((effect, _)) = made_of {
                stated.put(&mut inside.effects[effect], scales, all[place]);
            }
            inside
        });
        let mut inside: Vec<Model> = inside.collect();
        if let Stated::Value { effect, value: 0 } = stated
            && let Some(kink) = kinked(&model.effects[effect])
        {
            let beside = self.over_kinks(predictor, (model, lowest), (effect, kink), rise);
            inside.extend(beside.unwrap_or_default());
        }
        let ParameterRole::Free { lower, upper, .. } = set.parameters()[place].role else {
            return None;
        };
        Some(ValueProfile {
            inside,
            ends: [found.lower, found.upper],
            bounds: [lower, upper],
        })
    }

    /// Models within a rise of the weighted squares, where a value of an effect that moves readings by kinks goes over its whole range: a fit by
    /// derivatives stops at a kink. Of each, the size at both ends of what the rise leaves.
    ///
    /// # Arguments
    /// - `kink`: the place of the value.
    fn over_kinks(
        &self,
        predictor: &mut ReadingPredictor<'a>,
        (model, lowest): (&Model, &LowestPoint),
        (effect, kink): (usize, usize),
        rise: f64,
    ) -> Option<Vec<Model>> {
        /// Halvings of the step between a level inside and one outside: ends are read to a sixteenth of the step of the search.
        const HALVINGS: usize = 4;
        let (own, scales) = (&model.effects[effect], self.problem.scales());
        let bounds = scales.bounds(own);
        let shapes = (own.law.search.shapes)(scales.at(&own.place)).into_iter();
        let mut levels: Vec<f64> = shapes.map(|shape| shape.values[kink]).collect();
        levels.extend([own.values[kink], bounds[kink][0], bounds[kink][1]]);
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        let place = |value| {
            let stated = Stated::Value { effect, value };
            stated.place(model.parameters.len(), &model.effects)
        };
        let (size, place) = (place(0), place(kink));
        // What twists do changes little within an interval.
        let held = predictor.hold_joints_as_at(&model.parameters, &model.effects);
        held.ok()?;
        let mut problem = FitResiduals::new(self, predictor, model);
        let mut inside = Vec::new();
        let mut is_inside = |level: f64| {
            let Some((fit, set)) = lowest.at_level(&mut problem, place, level) else {
                return false;
            };
            let left = rise - (fit.sum_of_squares() - lowest.fit.sum_of_squares());
            if left < 0.0 {
                return false;
            }
            let settings = CovarianceSettings::default();
            let known = covariance(&set, &fit, SigmaMode::Known, &settings);
            let u = known
                .ok()
                .and_then(|known| known.estimates[size].standard_error);
            let u = u.unwrap_or(0.0);
            inside.extend([-u, u].map(|u| {
                let mut values = fit.values.clone();
                values[size] = (values[size] + left.sqrt() * u).clamp(bounds[0][0], bounds[0][1]);
                model.with_moved(&values)
            }));
            true
        };
        let are_inside: Vec<bool> = levels.iter().map(|level| is_inside(*level)).collect();
        for (ends, are_inside) in levels.windows(2).zip(are_inside.windows(2)) {
            let [mut within, mut beyond] = match are_inside {
                [true, false] => [ends[0], ends[1]],
                [false, true] => [ends[1], ends[0]],
                _ => continue,
            };
            for _ in 0..HALVINGS {
                let middle = 0.5 * (within + beyond);
                if is_inside(middle) {
                    within = middle;
                } else {
                    beyond = middle;
                }
            }
        }
        predictor.hold_joints(None);
        Some(inside)
    }

    /// Least and largest number that plausible values of an effect make.
    fn bounds_of(&self, effect: &Effect, stated: Stated) -> [f64; 2] {
        let scales = self.problem.scales();
        let bounds = scales.bounds(effect);
        let corners = (0..1_usize << bounds.len()).map(|corner| {
            let moved = bounds.iter().enumerate();
            let moved: Vec<f64> = moved
                .map(|(value, ends)| ends[corner >> value & 1])
                .collect();
            let mut effect = effect.clone();
            put_values(std::slice::from_mut(&mut effect), &moved);
            stated.of_effect(&effect, scales)
        });
        let corners = corners.chain([stated.of_effect(effect, scales)]);
        let corners = corners.filter(|made| made.is_finite());
        corners.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], made| {
            [low.min(made), high.max(made)]
        })
    }

    fn parameter_set(
        &self,
        start: &Model,
        moves: fn(&ParameterSpec) -> bool,
    ) -> Result<ParameterSet, stiffbench_numeric::least_squares::LeastSquaresError> {
        let scales = self.problem.scales();
        let of_baseline = self.parameters().iter().zip(&start.parameters);
        let of_baseline = of_baseline.map(|(parameter, &value)| {
            let (lower, upper) = (parameter.lower, parameter.upper);
            Parameter::free(&parameter.name, value.clamp(lower, upper), lower, upper)
        });
        let last = start.effects.len().wrapping_sub(1);
        let of_effects = start
            .effects
            .iter()
            .enumerate()
            .flat_map(|(place, effect)| {
                let narrower = self.bounds_of_last.filter(|_| place == last);
                let bounds = narrower.map_or_else(|| scales.bounds(effect), <[_]>::to_vec);
                let values = effect.law.parameters.iter().zip(moved_values(effect));
                let parameter = move |((parameter, value), [lower, upper]): (_, [f64; 2])| {
                    let (parameter, value): (&ParameterSpec, f64) = (parameter, value);
                    let name = format!("{place}.{}", parameter.name);
                    // Where loads do not act on a place nothing can be fitted.
                    if moves(parameter) && lower < upper {
                        Parameter::free(name, value.clamp(lower, upper), lower, upper)
                    } else {
                        Parameter::fixed(name, value)
                    }
                };
                let all: Vec<Parameter> = values.zip(bounds).map(parameter).collect();
                all
            });
        ParameterSet::with_any_number_of_free(of_baseline.chain(of_effects).collect())
    }

    /// White residuals of a model, those of the parameters behind them.
    pub(crate) fn residuals(&self, model: &Model) -> Result<Option<Vec<f64>>, MismatchError> {
        let predicted = self.problem.predicted_if_any(model)?;
        Ok(predicted.map(|mut rows| {
            rows.resize(rows.len() + self.parameters().len(), 0.0);
            self.weigh(&model.parameters, &mut rows);
            rows
        }))
    }

    /// Makes white residuals of predicted readings, and puts those of the parameters behind them.
    fn weigh(&self, parameters: &[f64], rows: &mut [f64]) {
        let (readings, of_parameters) = rows.split_at_mut(self.observations.len());
        for (value, displacement) in readings.iter_mut().zip(&self.observations.displacement_m) {
            *value = displacement - *value;
        }
        self.whitening.covariance.whiten(readings);
        let known = self.parameters().iter().zip(parameters);
        for (residual, (parameter, value)) in of_parameters.iter_mut().zip(known) {
            *residual = (parameter.start - value) / parameter.prior_sd;
        }
    }

    fn parameters(&self) -> &'a [BaselineParameter] {
        self.problem.baseline.parameters()
    }
}

/// Moves one value of an effect as a fit moves it, by a small step, and says by how much.
fn step_on(effect: &mut Effect, value: usize, scales: &PlaceScales) -> f64 {
    let step = step_of(effect, value, scales);
    if step.is_infinite() {
        return step;
    }
    let before = effect.values[value];
    effect.values[value] += step;
    if effect.law.parameters[value].is_ratio() {
        // Without the first value the ratio moves nothing: over an endless step the difference is none.
        return if effect.values[0] == 0.0 {
            f64::INFINITY
        } else {
            step / effect.values[0]
        };
    }
    if value == 0 && before != 0.0 {
        for (parameter, value) in effect.law.parameters.iter().zip(&mut effect.values) {
            if parameter.is_ratio() {
                *value *= (before + step) / before;
            }
        }
    }
    step
}

struct FitResiduals<'r, 'w, 'a> {
    refit: &'r WeightedFit<'w, 'a>,
    /// What is moved in place of the value of an effect that it is in proportion to, if anything.
    made: Option<Stated>,
    predictor: &'r mut ReadingPredictor<'a>,
    effects: Vec<Effect>,
    scratch: Vec<f64>,
    shifted: Vec<f64>,
    gradient: Vec<f64>,
}

impl<'r, 'w, 'a> FitResiduals<'r, 'w, 'a> {
    /// What is moved in place of which value of which effect.
    fn made(&self) -> Option<(Stated, usize, usize)> {
        let stated = self.made?;
        let (effect, value) = stated.made_of(&self.effects)?;
        Some((stated, effect, value))
    }

    fn new(
        refit: &'r WeightedFit<'w, 'a>,
        predictor: &'r mut ReadingPredictor<'a>,
        start: &Model,
    ) -> Self {
        let (rows, parameters) = (refit.observations.len(), refit.parameters().len());
        Self {
            refit,
            made: None,
            predictor,
            effects: start.effects.clone(),
            scratch: vec![0.0; rows],
            shifted: vec![0.0; rows],
            gradient: vec![0.0; rows * parameters],
        }
    }
}

/// The structure does not exist with these effects.
#[derive(Debug, thiserror::Error)]
#[error("there is no such structure")]
struct NoStructure;

impl ResidualFunction for FitResiduals<'_, '_, '_> {
    fn residual_count(&self) -> usize {
        self.scratch.len() + self.refit.parameters().len()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        let count = self.refit.parameters().len();
        let (of_baseline, of_effects) = parameters.split_at(count);
        put_values(&mut self.effects, of_effects);
        if let Some((stated, effect, _)) = self.made() {
            let number = parameters[stated.place(count, &self.effects)];
            let scales = self.refit.problem.scales();
            let of_one = stated.put(&mut self.effects[effect], scales, number);
            if !of_one.is_normal() {
                return Err(EvaluationFailure::of_model(NoStructure));
            }
        }
        let there = self
            .predictor
            .predict(of_baseline, &self.effects, &mut self.scratch)
            .map_err(EvaluationFailure::of_model)?;
        if !there {
            return Err(EvaluationFailure::of_model(NoStructure));
        }
        residuals[..self.scratch.len()].copy_from_slice(&self.scratch);
        self.refit.weigh(of_baseline, residuals);
        if let Some(jacobian) = jacobian {
            self.baseline_columns(of_baseline, jacobian)?;
            self.effect_columns(of_baseline, count, jacobian)?;
        }
        Ok(())
    }
}

impl FitResiduals<'_, '_, '_> {
    fn baseline_columns(
        &mut self,
        of_baseline: &[f64],
        jacobian: &mut JacobianView<'_>,
    ) -> Result<(), EvaluationFailure> {
        let n = self.scratch.len();
        self.predictor
            .gradient(of_baseline, &self.effects, &mut self.gradient)
            .map_err(EvaluationFailure::of_model)?;
        let known = self.refit.parameters();
        for (index, (column, parameter)) in self.gradient.chunks_mut(n).zip(known).enumerate() {
            self.refit.whitening.covariance.whiten(column);
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
            let made = self.made().filter(|(_, of, _)| *of == effect);
            for value in 0..self.effects[effect].values.len() {
                if let Some(out) = jacobian.column_mut(parameter) {
                    let own = &mut self.effects[effect];
                    let (before, scales) = (own.values.clone(), self.refit.problem.scales());
                    let number = made.map_or(0.0, |(stated, ..)| stated.of_effect(own, scales));
                    let mut step = step_on(own, value, scales);
                    match made {
                        Some((stated, _, moved)) if moved == value => {
                            step = stated.of_effect(own, scales) - number;
                        }
                        Some((stated, ..)) => {
                            stated.put(own, scales, number);
                        }
                        None => {}
                    }
                    self.predictor
                        .predict(of_baseline, &self.effects, &mut self.shifted)
                        .map_err(EvaluationFailure::of_model)?;
                    // A step of the first value may have taken others along.
                    self.effects[effect].values = before;
                    for (shifted, value) in self.shifted.iter_mut().zip(&self.scratch) {
                        *shifted = (*shifted - value) / step;
                    }
                    self.refit.whitening.covariance.whiten(&mut self.shifted);
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

/// Step of a difference: a share of the value; from zero, a size at which the effect can be distinguished from rounding.
pub(crate) fn step_of(effect: &Effect, value: usize, scales: &PlaceScales) -> f64 {
    /// Step from zero, as a share of the largest plausible value.
    const FROM_ZERO: f64 = 1e-6;
    /// Share by which a ratio is moved.
    const SHARE: f64 = 1e-3;
    /// Share by which a value that is searched is moved: a moment or a time moves readings by kinks, and a twentieth averages over them.
    const OVER_KINKS: f64 = 0.05;
    let now = effect.values[value];
    let range = || {
        let plausible = effect.law.parameters[value].plausible;
        (plausible.bounds)(scales.at(&effect.place), &effect.values)
    };
    match effect.law.parameters[value].fit {
        FitBy::FixedStep { step } => step,
        FitBy::ShareOfRange { share } => {
            let [low, high] = range();
            share * (high - low)
        }
        // From zero the step is a share of the first value.
        FitBy::RatioToFirst => SHARE * now.abs().max(SHARE * effect.values[0]),
        FitBy::Derivative { .. } if now == 0.0 => FROM_ZERO * range()[1],
        FitBy::Derivative { relative_step } => relative_step * now,
        FitBy::Search => OVER_KINKS * now.abs().max(1e-12),
        // Over an endless step the difference is none.
        FitBy::Reference => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_beams::physics::{Place, laws};

    fn nonlinear(values: [f64; 2]) -> Effect {
        Effect {
            law: laws::JOINT_NONLINEARITY,
            place: Place::Joint("A3".into()),
            values: values.to_vec(),
        }
    }

    #[test]
    fn a_fit_moves_the_ratio_of_the_quadratic_term() {
        let mut effects = [nonlinear([2e-6, -6e-7])];
        let moved: Vec<f64> = moved_values(&effects[0]).collect();
        assert!((moved[0] - 2e-6).abs() < 1e-18 && (moved[1] + 0.3).abs() < 1e-12);
        put_values(&mut effects, &[4e-6, -0.25]);
        assert_eq!(effects[0].values, [4e-6, -1e-6]);
        // The linear term takes the quadratic one along, the ratio stays.
        let step = step_on(&mut effects[0], 0, &PlaceScales::default());
        let moved: Vec<f64> = moved_values(&effects[0]).collect();
        assert!((moved[0] - 4e-6 - step).abs() < 1e-18 && (moved[1] + 0.25).abs() < 1e-12);
        let step = step_on(&mut effects[0], 1, &PlaceScales::default());
        let then: Vec<f64> = moved_values(&effects[0]).collect();
        assert!((then[1] - moved[1] - step).abs() < 1e-12 && then[0] == moved[0]);
    }

    #[test]
    fn without_a_linear_term_the_ratio_has_no_derivative() {
        let mut effect = nonlinear([0.0, 0.0]);
        assert!(step_on(&mut effect, 1, &PlaceScales::default()).is_infinite());
    }
}
