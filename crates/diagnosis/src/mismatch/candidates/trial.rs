//! Sessions with a known answer, on the poses and forces of a real one: what the error rates of a diagnosis are counted on.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Gamma, StandardNormal};

use stiffbench_beams::physics::{Effect, SignConstraint};

use super::candidate::candidates;
use super::candidate_scores::{best_shapes, score_candidates};
use super::changes::Changes;
use super::problem_candidates::{CandidateMemo, Candidates};
use crate::mismatch::baselines::{Baseline, prior_sd};
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::EstimatedNoise;
use crate::mismatch::observed::{Observations, ReadingNoise};
use crate::mismatch::problem::{DiagnosisProblem, Model, ReadingPredictor, State};
use crate::search::WhiteSpace;
use crate::search::{Batched, dot};

/// Noise of a trial: sizes, and the shape of the reading error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialNoise {
    /// Sizes; the reading error does not contain the gauge's step.
    pub noise: ReadingNoise,
    /// Step of the displacement gauge, m.
    pub displacement_step_m: f64,
    /// Display step of the force gauge, N.
    pub force_step_n: f64,
    /// Whether the reading error is a shifted gamma with the same standard deviation and a skewness of 1.4, not a normal.
    pub skewed: bool,
}

/// Shape of the skewed error: a gamma of shape 2 has skewness √2.
const SKEWED_SHAPE: f64 = 2.0;

/// The truth of a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Parameters of the baseline.
    pub parameters: Vec<f64>,
    /// Effects.
    pub effects: Vec<Effect>,
    /// Noise.
    pub noise: TrialNoise,
}

impl Truth {
    /// The same structure with other effects.
    fn model(&self, effects: &[Effect]) -> Model {
        Model {
            parameters: self.parameters.clone(),
            effects: effects.to_vec(),
        }
    }
}

/// Readings of a truth at the forces of a plan; the same seed gives the same readings.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved.
pub fn simulate(
    baseline: &dyn Baseline,
    plan: &Observations,
    truth: &Truth,
    seed: u64,
) -> Result<Observations, MismatchError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut acting = plan.clone();
    for load in &mut acting.loads {
        load.position_m = None;
        // What acted lies anywhere within the step that was read; without load nothing acts.
        if load.force_n != 0.0 {
            load.force_n += truth.noise.force_step_n * (rng.random::<f64>() - 0.5);
        }
    }
    let mut predictor = ReadingPredictor::new(baseline, &acting, Arc::default());
    let mut displacement_m = vec![0.0; acting.len()];
    predictor.predict(&truth.parameters, &truth.effects, &mut displacement_m)?;
    let mut mechanics_m = vec![0.0; acting.len()];
    predictor.compliance(&truth.parameters, &truth.effects, &mut mechanics_m)?;
    let noise = &truth.noise.noise;
    let mut normal = |sd: f64| -> f64 {
        let z: f64 = StandardNormal.sample(&mut rng);
        sd * z
    };
    let zeros = (0..acting.zero_count()).map(|_| normal(noise.zero_sd_m));
    let zeros: Vec<f64> = zeros.collect();
    let slopes: Vec<f64> = acting
        .runs
        .iter()
        .map(|_| normal(noise.run_slope_sd))
        .collect();
    let mut errors: Vec<f64> = (0..acting.len()).map(|_| normal(1.0)).collect();
    if let Some(gamma) = Gamma::new(SKEWED_SHAPE, 1.0)
        .ok()
        .filter(|_| truth.noise.skewed)
    {
        errors.fill_with(|| {
            let unit: f64 = gamma.sample(&mut rng);
            (unit - SKEWED_SHAPE) / SKEWED_SHAPE.sqrt()
        });
    }
    remember(&mut errors, &acting, noise.correlation);
    for (place, displacement) in displacement_m.iter_mut().enumerate() {
        let reading = &acting.readings[place];
        let linear_m = mechanics_m[place] * acting.loads[place].force_n;
        *displacement += slopes[reading.run] * linear_m
            + zeros[reading.zero as usize]
            + noise
                .own_variance(&acting.cells[acting.runs[reading.run].cell].read, linear_m)
                .sqrt()
                * errors[place];
        let step = truth.noise.displacement_step_m;
        if step > 0.0 {
            *displacement = (*displacement / step).round() * step;
        }
    }
    Ok(plan.with_displacements(displacement_m))
}

/// Makes each error of a run share in the one before it, in place; all keep their standard deviation of one.
fn remember(errors: &mut [f64], observations: &Observations, correlation: f64) {
    if correlation == 0.0 {
        return;
    }
    for run in &observations.runs {
        for reading in run.readings.clone().skip(1) {
            let new = (1.0 - correlation * correlation).sqrt() * errors[reading];
            errors[reading] = correlation * errors[reading - 1] + new;
        }
    }
}

/// Length of the last effect of a truth in standard errors: white with the true noise, the baseline projected out.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved.
pub fn standard_errors(
    baseline: &dyn Baseline,
    plan: &Observations,
    truth: &Truth,
) -> Result<f64, MismatchError> {
    standard_errors_with(baseline, plan, truth, &prior_sd(baseline))
}

/// The same by the readings alone, whatever was known of the parameters beforehand: of an effect that a free parameter imitates nothing is
/// left but rounding.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved.
pub fn standard_errors_of_readings(
    baseline: &dyn Baseline,
    plan: &Observations,
    truth: &Truth,
) -> Result<f64, MismatchError> {
    standard_errors_with(baseline, plan, truth, &[])
}

/// # Arguments
/// - `prior_sd`: what was known of the parameters beforehand.
fn standard_errors_with(
    baseline: &dyn Baseline,
    plan: &Observations,
    truth: &Truth,
    prior_sd: &[f64],
) -> Result<f64, MismatchError> {
    let Some(last) = truth.effects.len().checked_sub(1) else {
        return Ok(0.0);
    };
    TrueSpace::new(baseline, plan, truth, &[], prior_sd)?.length(&truth.effects, last)
}

/// What a rival leaves of the last effect of a truth, in standard errors: how far apart the two are.
///
/// The rival has its best size, which physics may forbid to be below zero, and its own shape or the best of those that are searched; a
/// loose member has the size it has. The baseline and the other effects are projected out.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved.
pub fn standard_errors_between(
    baseline: &dyn Baseline,
    plan: &Observations,
    truth: &Truth,
    rival: &Effect,
) -> Result<f64, MismatchError> {
    let Some(last) = truth.effects.len().checked_sub(1) else {
        return Ok(0.0);
    };
    let others = &truth.effects[..last];
    let space = TrueSpace::new(baseline, plan, truth, others, &prior_sd(baseline))?;
    let mut with_rival = others.to_vec();
    with_rival.push(rival.clone());
    let own = space.vector(&truth.effects, last)?;
    let other = space.vector(&with_rival, last)?;
    let (square, product) = (dot(&own, &own), dot(&own, &other));
    if rival.values.is_empty() {
        return Ok((square - 2.0 * product + dot(&other, &other))
            .max(0.0)
            .sqrt());
    }
    let nearest = space.nearest_shape(others, rival, &own)?;
    let positive = rival
        .law
        .parameters
        .first()
        .is_none_or(|parameter| parameter.sign != SignConstraint::Either);
    let left = if product == 0.0 || (positive && product < 0.0) {
        square
    } else {
        square - product * product / dot(&other, &other)
    };
    Ok(left.max(0.0).sqrt().min(nearest))
}

/// What a rival leaves of the exact readings of a truth in the place of its last effect, in standard errors: the rival, the other effects and the
/// baseline fitted to them in full, under the true noise.
///
/// The rival is fitted from the best of the shapes that are searched and from its own values, within what is plausible; the better of both
/// counts. What the model of the truth itself leaves, fitted alike, is no distance.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved.
pub fn standard_errors_after_fit(
    baseline: &dyn Baseline,
    plan: &Observations,
    truth: &Truth,
    rival: &Effect,
) -> Result<f64, MismatchError> {
    let Some((_, others)) = truth.effects.split_last() else {
        return Ok(0.0);
    };
    let planned = DiagnosisProblem::new(baseline, plan);
    let predicted = |effects: &[Effect]| planned.predicted(&truth.model(effects));
    let exact = plan.with_displacements(predicted(&truth.effects)?);
    let mut on_robot = truth.effects.clone();
    on_robot.retain(|effect| !effect.law.is_gauge_error());
    let exact = exact.with_positions(&predicted(&on_robot)?);

    let problem = DiagnosisProblem::new(baseline, &exact);
    let noise = known_noise(truth);
    let whitening = problem.whitening(&truth.model(&[]), &noise)?;
    let fit = |effects: &[Effect]| problem.refit(&whitening).fit(&truth.model(effects));
    let with_rival: Vec<Effect> = others.iter().chain([rival]).cloned().collect();
    let (own, rest) = (fit(&truth.effects), fit(others));
    let from_its_values = fit(&with_rival).map(|fitted| fitted.squares);
    let (Some(own), Some(rest)) = (own, rest) else {
        return Err(MismatchError::Empty);
    };
    let alone = rest.squares;
    let state = State {
        fitted: rest,
        noise,
        whitening: whitening.clone(),
    };
    let memo = CandidateMemo::default();
    let searched = Candidates::new(&problem, &memo).with_searched(&state, rival)?;
    let searched = searched.map(|fitted| fitted.squares);
    let found = [from_its_values, searched].into_iter().flatten();
    // A law that has a size may have none.
    let none = (!rival.values.is_empty()).then_some(alone);
    let least = found.chain(none).fold(f64::INFINITY, f64::min);
    Ok((least - own.squares).max(0.0).sqrt())
}

/// The space that is white under the true noise of a truth, with the baseline and some of its effects projected out.
struct TrueSpace<'a> {
    problem: DiagnosisProblem<'a>,
    truth: &'a Truth,
    space: WhiteSpace,
}

impl<'a> TrueSpace<'a> {
    fn new(
        baseline: &'a dyn Baseline,
        plan: &'a Observations,
        truth: &'a Truth,
        beside: &[Effect],
        prior_sd: &[f64],
    ) -> Result<Self, MismatchError> {
        let problem = DiagnosisProblem::new(baseline, plan);
        let whitening = problem.whitening(&truth.model(&[]), &known_noise(truth))?;
        let columns = problem.columns(&truth.model(beside))?;
        let space = WhiteSpace::new(whitening.covariance, prior_sd, &columns);
        Ok(Self {
            problem,
            truth,
            space,
        })
    }

    /// An effect beside others, white and projected.
    fn vector(&self, effects: &[Effect], effect: usize) -> Result<Vec<f64>, MismatchError> {
        let model = self.truth.model(effects);
        let (white, _) = self.problem.effect_vector(&model, effect, &self.space)?;
        Ok(white)
    }

    /// What the best shape of a rival leaves of an effect, standard errors.
    fn nearest_shape(
        &self,
        beside: &[Effect],
        rival: &Effect,
        own: &[f64],
    ) -> Result<f64, MismatchError> {
        let observations = self.problem.observations;
        let linearised = (self.problem.predictor()).linearised(&self.truth.parameters, beside)?;
        let mut list = candidates(observations, &linearised, &[]);
        list.retain(|one| one.law == rival.law && one.place == rival.place);
        let engine = Batched::new(&self.space, own);
        let seen = Changes::new(observations, &linearised, beside)
            .map_or_else(Vec::new, |changes| {
                score_candidates(&changes, &engine, list)
            });
        let delta_chi2s = best_shapes(&seen).into_iter().flatten();
        let delta_chi2 = delta_chi2s
            .map(|screened| screened.best.delta_chi2)
            .fold(0.0, f64::max);
        Ok((dot(own, own) - delta_chi2).max(0.0).sqrt())
    }

    /// Its length, standard errors.
    fn length(&self, effects: &[Effect], effect: usize) -> Result<f64, MismatchError> {
        let white = self.vector(effects, effect)?;
        Ok(dot(&white, &white).sqrt())
    }
}

/// The noise of a truth, the step of its gauge included.
fn known_noise(truth: &Truth) -> EstimatedNoise {
    let step = truth.noise.displacement_step_m;
    EstimatedNoise::known(ReadingNoise {
        reading_sd_m: (truth.noise.noise.reading_sd_m.powi(2) + step * step / 12.0).sqrt(),
        ..truth.noise.noise
    })
}

/// Scales the last effect of a truth to a length in standard errors; `None` if no size reaches it.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved.
pub fn scale_to(
    baseline: &dyn Baseline,
    plan: &Observations,
    truth: &Truth,
    wanted: f64,
) -> Result<Option<Truth>, MismatchError> {
    let Some(last) = truth.effects.len().checked_sub(1) else {
        return Ok(None);
    };
    let space = TrueSpace::new(baseline, plan, truth, &[], &prior_sd(baseline))?;
    let length = |factor: f64| space.length(&scaled(truth, factor).effects, last);
    let (mut low, mut high) = (0.0, 1.0);
    let mut grown = 0;
    while length(high)? < wanted {
        low = high;
        high *= 4.0;
        grown += 1;
        if grown > 24 {
            return Ok(None);
        }
    }
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if length(middle)? < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(Some(scaled(truth, high)))
}

/// A truth whose last effect is a multiple of itself.
fn scaled(truth: &Truth, factor: f64) -> Truth {
    let mut scaled = truth.clone();
    if let Some(effect) = scaled.effects.last_mut() {
        for (place, value) in effect.values.iter_mut().enumerate() {
            // The quadratic term grows with the linear one; all else is shape.
            if place == 0 || effect.law.parameters[place].is_ratio() {
                *value *= factor;
            }
        }
    }
    scaled
}
