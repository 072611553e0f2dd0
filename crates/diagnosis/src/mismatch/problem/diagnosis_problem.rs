//! The problem: readings and a baseline, models fitted to them, and the white space in which candidates are compared.

use std::sync::{Arc, OnceLock};

use stiffbench_beams::physics::{Effect, Law};

use super::memo::FitMemo;
use super::model::{Model, State};
use super::place_scales::PlaceScales;
use super::predictor::{IdleSolvers, ReadingPredictor};
use super::refit::{WeightedFit, step_of};
use crate::mismatch::baselines::{Baseline, StructureColumn, prior_sd, start};
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::{
    EstimatedNoise, ForceReading, KnownNoise, NoiseCovariance, RoundedNoise, estimate_noise,
    force_within_steps, positions_of_repeats,
};
use crate::mismatch::observed::Observations;
use crate::search::constants::ALTERNATIONS;
use crate::search::{WhiteSpace, dot, subtract};

/// Relative difference of all standard deviations below which two estimates of a covariance are the same (1): far less than either is known.
/// Numerics.
const SAME_COVARIANCE: f64 = 0.02;

/// What a search is to do; by default with all laws, no known physics, seed 0 and noise from the readings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SearchOptions {
    /// Laws that are left out.
    pub without: Vec<Law>,
    /// Physics that is known to act: no candidate, its values fitted again with every model.
    pub known_effects: Vec<Effect>,
    /// Seed of the limits' draws.
    pub seed: u64,
    /// What is known of the noise before the readings are checked.
    pub noise: KnownNoise,
}

/// What the linear structure makes of the loads, one value a reading.
pub(crate) struct LinearSlopes {
    /// Displacement, m.
    pub(crate) slope_m: Vec<f64>,
    /// Displacement per force along the load, m/N.
    pub(crate) compliance: Vec<f64>,
    /// The same per component of the force along x, y, z of the base, where each was read by itself.
    components: Option<Vec<[f64; 3]>>,
}

impl LinearSlopes {
    /// What an error of the force moves.
    pub(crate) fn force(&self) -> ForceReading<'_> {
        let by_components = self.components.as_deref();
        by_components.map_or(
            ForceReading::AlongLoad(&self.compliance),
            ForceReading::ByComponents,
        )
    }
}

/// The problem: what was observed, and the baseline it is fitted with.
#[derive(Clone)]
pub(crate) struct DiagnosisProblem<'a> {
    pub(crate) baseline: &'a dyn Baseline,
    pub(crate) observations: &'a Observations,
    /// Physics of the model itself: in every model, first among its effects.
    pub(crate) known_effects: Arc<[Effect]>,
    idle: Arc<IdleSolvers<'a>>,
    /// What springs would change about the start: the same for all readings.
    springs: Arc<OnceLock<Arc<[StructureColumn]>>>,
    pub(crate) memo: Arc<FitMemo>,
}

impl<'a> DiagnosisProblem<'a> {
    /// The problem of these observations.
    pub(crate) fn new(baseline: &'a dyn Baseline, observations: &'a Observations) -> Self {
        Self {
            baseline,
            observations,
            known_effects: Arc::default(),
            idle: Arc::default(),
            springs: Arc::default(),
            memo: Arc::default(),
        }
    }

    /// The same problem with other readings of the same poses.
    pub(crate) fn with_readings<'o>(&self, observations: &'o Observations) -> DiagnosisProblem<'o>
    where
        'a: 'o,
    {
        DiagnosisProblem {
            known_effects: Arc::clone(&self.known_effects),
            springs: Arc::clone(&self.springs),
            ..DiagnosisProblem::new(self.baseline, observations)
        }
    }

    /// The same problem with effects that every model has.
    pub(crate) fn with_known_effects(self, effects: &[Effect]) -> Self {
        Self {
            known_effects: effects.into(),
            ..self
        }
    }

    /// The same problem with the gauge elsewhere: the same readings but for their positions.
    pub(crate) fn with_positions(&self, observations: &'a Observations) -> Self {
        Self {
            observations,
            ..self.clone()
        }
    }

    /// A predictor of readings.
    pub(crate) fn predictor(&self) -> ReadingPredictor<'a> {
        ReadingPredictor::new(self.baseline, self.observations, Arc::clone(&self.idle))
    }

    /// What the loads make of places, by the structure at the start; of one that cannot be solved there only what needs no structure.
    pub(crate) fn scales(&self) -> &PlaceScales {
        self.memo.scales(|| {
            let start = self.start();
            let linearised = self.predictor().linearised(&start.parameters, &[]);
            let mut linearised = linearised.unwrap_or_default();
            let springs = || self.baseline.spring_columns(&start.parameters);
            let springs = || springs().unwrap_or_default().into();
            linearised.columns = Arc::clone(self.springs.get_or_init(springs));
            PlaceScales::new(self.observations, &linearised)
        })
    }

    /// A refit under a whitening.
    pub(crate) fn refit<'w>(&'w self, whitening: &'w NoiseCovariance) -> WeightedFit<'w, 'a> {
        WeightedFit {
            problem: self,
            observations: self.observations,
            whitening,
            bounds_of_last: None,
            warm_start: None,
        }
    }

    /// Fits a model and finds its noise, each from the other, twice round.
    ///
    /// # Arguments
    /// - `known`: the noise, if it is given; else it is found from what the model leaves.
    pub(crate) fn alternate(
        &self,
        start: Model,
        known: KnownNoise,
    ) -> Result<Option<State>, MismatchError> {
        self.memo
            .model(start, known, |start| self.alternate_anew(start, known))
    }

    /// The same where there must be one.
    pub(crate) fn state_of(&self, start: Model, known: KnownNoise) -> Result<State, MismatchError> {
        self.alternate(start, known)?.ok_or(MismatchError::Empty)
    }

    fn alternate_anew(
        &self,
        start: Model,
        known: KnownNoise,
    ) -> Result<Option<State>, MismatchError> {
        let mut model = start;
        let given = known.given().copied();
        let mut found = given;
        let mut state = None;
        for round in 0..ALTERNATIONS {
            if given.is_none() && (round > 0 || found.is_none()) {
                let Some(estimate) = self.noise_of(&model, &known)? else {
                    return Ok(None);
                };
                let is_settled = found.is_some_and(|before| alike(&before, &estimate));
                found = Some(estimate);
                if is_settled {
                    break;
                }
            } else if given.is_some() && round > 0 {
                break;
            }
            let Some(noise) = found else { return Ok(None) };
            let whitening = self.whitening(&model, &noise)?;
            let Some(fitted) = self.refit(&whitening).fit(&model) else {
                return Ok(None);
            };
            model = fitted.model.clone();
            state = Some(State {
                fitted,
                noise,
                whitening,
            });
        }
        Ok(state)
    }

    /// The readings of a recording on the path of what was set, if it was read with errors that show.
    pub(crate) fn readings_on_path(
        &self,
        options: &SearchOptions,
    ) -> Result<Option<Observations>, MismatchError> {
        if !self.observations.is_recording() {
            return Ok(None);
        }
        let model = self.state_of(self.start(), options.noise)?.fitted.model;
        let residual_m = self.raw_residuals(&model)?;
        let compliance = self.slope(&model)?.compliance;
        Ok(self.observations.on_its_path(&residual_m, &compliance))
    }

    /// The noise that a model leaves, by the readings and what is known beforehand.
    pub(crate) fn noise_of(
        &self,
        model: &Model,
        known: &KnownNoise,
    ) -> Result<Option<EstimatedNoise>, MismatchError> {
        let Some(predicted) = self.predicted_if_any(model)? else {
            return Ok(None);
        };
        let residual = self.less(predicted);
        if self.observations.is_recording() {
            return Ok(Some(self.observations.noise_of_neighbours(&residual)));
        }
        let slopes = self.slope(model)?;
        let shows_noise = self.observations.has_repeats() || self.observations.has_long_runs();
        let is_known = shows_noise || known.earlier().is_some();
        let columns = if is_known {
            None
        } else {
            Some(self.columns(model)?)
        };
        let found = estimate_noise(
            self.observations,
            &residual,
            (&slopes.slope_m, slopes.force()),
            self.memo.noise(),
            known.earlier(),
            columns,
        );
        self.memo.keep_noise(found.noise);
        Ok(Some(found))
    }

    /// The whitening of a model's noise.
    pub(crate) fn whitening(
        &self,
        model: &Model,
        noise: &EstimatedNoise,
    ) -> Result<NoiseCovariance, MismatchError> {
        let slopes = self.slope(model)?;
        Ok(NoiseCovariance::new(
            self.observations,
            &noise.noise,
            &slopes.slope_m,
            slopes.force(),
        ))
    }

    /// Prediction and compliances of the linear structure.
    pub(crate) fn slope(&self, model: &Model) -> Result<LinearSlopes, MismatchError> {
        let mut predictor = self.predictor();
        let mut compliance = vec![0.0; self.observations.len()];
        predictor.compliance(&model.parameters, &model.effects, &mut compliance)?;
        // A series has one direction, along which its gauge reads; of loads one by one each component was read by itself.
        let components = if self.observations.has_series() {
            None
        } else {
            Some(predictor.force_components(&model.parameters, &model.effects)?)
        };
        let slope_m = compliance
            .iter()
            .zip(&self.observations.loads)
            .map(|(c, load)| c * load.force_n)
            .collect();
        Ok(LinearSlopes {
            slope_m,
            compliance,
            components,
        })
    }

    /// Derivatives of the readings to every parameter of a model, m: baseline first, then effects by differences.
    pub(crate) fn columns(&self, model: &Model) -> Result<Vec<Vec<f64>>, MismatchError> {
        let n = self.observations.len();
        let mut predictor = self.predictor();
        let mut columns = Vec::new();
        let mut up = vec![0.0; n];
        let mut down = vec![0.0; n];
        // Central differences, in units of the parameters: the structure is solved to ten digits.
        const STEP: f64 = 1e-4;
        for (index, parameter) in self.baseline.parameters().iter().enumerate() {
            let step = STEP * parameter.unit;
            let mut moved = model.parameters.clone();
            moved[index] += step;
            let above = moved[index];
            predictor.predict(&moved, &model.effects, &mut up)?;
            moved[index] -= 2.0 * step;
            let mut width = 2.0 * step;
            // No spring has a compliance below zero: at a rigid joint the difference is to one side.
            if parameter.spring_rad_per_nm.is_some() && moved[index] < 0.0 {
                moved[index] = 0.0;
                width = above;
            }
            predictor.predict(&moved, &model.effects, &mut down)?;
            columns.push(up.iter().zip(&down).map(|(u, d)| (u - d) / width).collect());
        }
        predictor.predict(&model.parameters, &model.effects, &mut down)?;
        let mut effects = model.effects.clone();
        for place in 0..effects.len() {
            for value in 0..effects[place].values.len() {
                if effects[place].law.parameters[value].is_reference() {
                    columns.push(vec![0.0; n]);
                    continue;
                }
                let before = effects[place].values[value];
                let step = step_of(&effects[place], value, self.scales());
                effects[place].values[value] = before + step;
                predictor.predict(&model.parameters, &effects, &mut up)?;
                effects[place].values[value] = before;
                columns.push(up.iter().zip(&down).map(|(u, d)| (u - d) / step).collect());
            }
        }
        Ok(columns)
    }

    /// The same, zero for factors at their bounds: these take nothing more of what is left.
    pub(crate) fn free_columns(&self, model: &Model) -> Result<Vec<Vec<f64>>, MismatchError> {
        let mut columns = self.columns(model)?;
        let factors = self.baseline.parameters().iter().zip(&model.parameters);
        for (column, (parameter, value)) in columns.iter_mut().zip(factors) {
            if parameter.is_at_bound(*value) {
                column.fill(0.0);
            }
        }
        Ok(columns)
    }

    /// The space of a state, and its white residuals.
    pub(crate) fn space(&self, state: &State) -> Result<(WhiteSpace, Vec<f64>), MismatchError> {
        let model = &state.fitted.model;
        let mut columns = self.free_columns(model)?;
        columns.extend(force_within_steps(self.observations, &state.noise.noise));
        let space = WhiteSpace::new(
            state.whitening.covariance.clone(),
            &prior_sd(self.baseline),
            &columns,
        );
        let mut residuals = self
            .refit(&state.whitening)
            .residuals(model)?
            .unwrap_or_default();
        space.project(&mut residuals);
        Ok((space, residuals))
    }

    /// Displacements of a model, m.
    pub(crate) fn predicted(&self, model: &Model) -> Result<Vec<f64>, MismatchError> {
        let predicted = self.predicted_if_any(model)?;
        Ok(predicted.unwrap_or_else(|| vec![0.0; self.observations.len()]))
    }

    /// The same; `None` if there is no such structure.
    pub(crate) fn predicted_if_any(
        &self,
        model: &Model,
    ) -> Result<Option<Vec<f64>>, MismatchError> {
        let mut out = vec![0.0; self.observations.len()];
        let mut predictor = self.predictor();
        let there = predictor.predict(&model.parameters, &model.effects, &mut out)?;
        Ok(there.then_some(out))
    }

    /// Readings minus what was predicted of them, m.
    pub(crate) fn less(&self, mut predicted: Vec<f64>) -> Vec<f64> {
        for (value, measured) in predicted.iter_mut().zip(&self.observations.displacement_m) {
            *value = measured - *value;
        }
        predicted
    }

    /// The model that the search starts from: what is known, and no other effects.
    pub(crate) fn start(&self) -> Model {
        Model {
            parameters: start(self.baseline),
            effects: self.known_effects.to_vec(),
        }
    }

    /// Where the gauge stood at each reading, by the model without effects, m.
    pub(crate) fn positions_at_start(
        &self,
        options: &SearchOptions,
    ) -> Result<Vec<f64>, MismatchError> {
        self.positions(&self.state_of(self.start(), options.noise)?)
    }

    /// Where the gauge stood at each reading, m: a state's effects moved it, but for those of the gauge itself, which are in its readings alone.
    pub(crate) fn positions(&self, state: &State) -> Result<Vec<f64>, MismatchError> {
        let model = &state.fitted.model;
        let residuals = self.raw_residuals(model)?;
        let mut positions = state.whitening.positions(self.observations, &residuals);
        let mut true_gauge = model.clone();
        true_gauge
            .effects
            .retain(|effect| !effect.law.is_gauge_error());
        if true_gauge.effects.len() < model.effects.len() {
            let with_error = self.raw_residuals(&true_gauge)?;
            let both = with_error.iter().zip(&residuals);
            for (position, (with_error, residual)) in positions.iter_mut().zip(both) {
                *position -= with_error - residual;
            }
        }
        Ok(positions_of_repeats(self.observations, positions))
    }

    /// Readings minus a model, m.
    pub(crate) fn raw_residuals(&self, model: &Model) -> Result<Vec<f64>, MismatchError> {
        Ok(self.less(self.predicted(model)?))
    }

    /// How many independent values are as much evidence as what a model leaves of a part; `None` where repeats tell the noise.
    pub(crate) fn independent_values(
        &self,
        state: &State,
        model: &Model,
    ) -> Result<Option<f64>, MismatchError> {
        if !self.observations.is_recording() {
            return Ok(None);
        }
        let left = self.refit(&state.whitening).residuals(model)?;
        let left = left.unwrap_or_default();
        let count = self.observations.len().min(left.len());
        Ok(Some(self.observations.independent_values(&left[..count])))
    }

    /// The noise of a state about its model; `None` if the step of the gauge is not what scatters.
    pub(crate) fn rounded<'s>(
        &'s self,
        state: &'s State,
    ) -> Result<Option<RoundedNoise<'s>>, MismatchError> {
        let predicted = self.predicted(&state.fitted.model)?;
        let whitening = &state.whitening;
        let Some(mut rounded) = RoundedNoise::new(self.observations, whitening, predicted) else {
            return Ok(None);
        };
        // Along the columns of the model the readings fix it to their noise.
        let (space, _) = self.space(state)?;
        let in_metres = |unit: &Vec<f64>| {
            let mut change = unit[..self.observations.len()].to_vec();
            whitening.covariance.unwhiten(&mut change);
            change
        };
        rounded.unknown_m = space.basis().iter().map(in_metres).collect();
        Ok(Some(rounded))
    }

    /// An effect of a model, white and projected, and its squared length before projection.
    pub(crate) fn effect_vector(
        &self,
        model: &Model,
        effect: usize,
        space: &WhiteSpace,
    ) -> Result<(Vec<f64>, f64), MismatchError> {
        let mut white = space.white(&self.effect_m(model, effect)?);
        let whole = dot(&white, &white);
        space.project(&mut white);
        Ok((white, whole))
    }

    /// What an effect of a model changes in the readings, m.
    pub(crate) fn effect_m(&self, model: &Model, effect: usize) -> Result<Vec<f64>, MismatchError> {
        let mut change_m = self.predicted(model)?;
        let rest = self.predicted(&model.without(effect))?;
        subtract(&mut change_m, 1.0, &rest);
        Ok(change_m)
    }
}

/// Whether two noises differ by less than two percent: far less than either is known.
fn alike(a: &EstimatedNoise, b: &EstimatedNoise) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() <= SAME_COVARIANCE * a.max(b);
    close(a.noise.reading_sd_m, b.noise.reading_sd_m)
        && close(a.noise.zero_sd_m, b.noise.zero_sd_m)
        && close(a.noise.run_slope_sd, b.noise.run_slope_sd)
        && close(a.noise.growth_sd, b.noise.growth_sd)
        && (a.noise.correlation - b.noise.correlation).abs() <= SAME_COVARIANCE
        && close(a.noise.gauges.own_slope_sd, b.noise.gauges.own_slope_sd)
        && close(a.noise.gauges.force_sd_n, b.noise.gauges.force_sd_n)
        && (0..3).all(|axis| {
            let ratio = |one: &EstimatedNoise| one.noise.gauges.reading_ratios[axis];
            close(ratio(a), ratio(b))
        })
}
