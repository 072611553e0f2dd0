//! A model of the readings, its values as a fit moves them, and what a search knows of one.

use stiffbench_beams::physics::Effect;

use crate::mismatch::noise::{EstimatedNoise, NoiseCovariance};

/// A model of the readings: values of the baseline's parameters, and effects.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Model {
    pub(crate) parameters: Vec<f64>,
    pub(crate) effects: Vec<Effect>,
}

impl Model {
    /// The same with one more effect, the last.
    pub(crate) fn with(&self, effect: &Effect) -> Self {
        let mut more = self.clone();
        more.effects.push(effect.clone());
        more
    }

    /// The same without an effect.
    pub(crate) fn without(&self, effect: usize) -> Self {
        let mut rest = self.clone();
        rest.effects.remove(effect);
        rest
    }

    /// The same with other values, as a fit moves them.
    pub(crate) fn with_moved(&self, values: &[f64]) -> Self {
        let (parameters, of_effects) = values.split_at(self.parameters.len());
        let mut effects = self.effects.clone();
        put_values(&mut effects, of_effects);
        Self {
            parameters: parameters.to_vec(),
            effects,
        }
    }
}

/// A model fitted to the readings.
#[derive(Debug, Clone)]
pub(crate) struct FittedModel {
    pub(crate) model: Model,
    /// Weighted squares of the readings and of what was known of the parameters.
    pub(crate) squares: f64,
}

/// A fitted model with its noise, as it stands during the search.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) fitted: FittedModel,
    pub(crate) noise: EstimatedNoise,
    pub(crate) whitening: NoiseCovariance,
}

/// The values of an effect as a fit moves them: some as their ratio to the first, for it is that which has bounds.
pub(crate) fn moved_values(effect: &Effect) -> impl Iterator<Item = f64> + '_ {
    let first = effect.values.first().copied().unwrap_or_default();
    let values = effect.law.parameters.iter().zip(&effect.values);
    values.map(move |(parameter, &value)| {
        if parameter.is_ratio() && first != 0.0 {
            value / first
        } else {
            value
        }
    })
}

/// Puts values as a fit moves them into effects.
pub(crate) fn put_values(effects: &mut [Effect], values: &[f64]) {
    let all = effects.iter_mut().flat_map(|effect| &mut effect.values);
    for (target, value) in all.zip(values) {
        *target = *value;
    }
    for effect in effects {
        let Some(first) = effect.values.first().copied() else {
            continue;
        };
        for (parameter, value) in effect.law.parameters.iter().zip(&mut effect.values) {
            if parameter.is_ratio() {
                *value *= first;
            }
        }
    }
}

/// The value of an effect that is searched, not followed by derivatives.
pub(crate) fn kinked(effect: &Effect) -> Option<usize> {
    (1..effect.values.len()).find(|&value| effect.law.parameters[value].is_searched())
}
