//! What of a model is stated: a parameter, a value of an effect, or a number made of its values.

use stiffbench_beams::physics::{Effect, values_of};

use super::model::{Model, moved_values, put_values};
use super::place_scales::PlaceScales;

/// What of a model is stated.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Stated {
    /// A parameter of the baseline, on the scale on which it is fitted.
    Parameter(usize),
    /// A value of an effect.
    Value { effect: usize, value: usize },
    /// The number that the law of an effect makes of its values.
    Combination { effect: usize },
}

impl Stated {
    /// All that is stated of an effect of a model.
    pub(crate) fn of_an_effect(model: &Model, effect: usize) -> impl Iterator<Item = Self> {
        let values =
            (0..model.effects[effect].values.len()).map(move |value| Self::Value { effect, value });
        let combination = model.effects[effect]
            .law
            .combination
            .map(|_| Self::Combination { effect });
        values.chain(combination)
    }

    /// It, of a model.
    pub(crate) fn of(self, model: &Model, scales: &PlaceScales) -> f64 {
        match self {
            Self::Parameter(parameter) => model.parameters[parameter],
            Self::Value { effect, .. } | Self::Combination { effect } => {
                self.of_effect(&model.effects[effect], scales)
            }
        }
    }

    /// It, of an effect.
    pub(crate) fn of_effect(self, effect: &Effect, scales: &PlaceScales) -> f64 {
        match self {
            Self::Value { value, .. } => effect.values[value],
            Self::Parameter(_) | Self::Combination { .. } => {
                let made = effect.law.combination.map(|combination| {
                    (combination.of)(&values_of(&effect.values), scales.at(&effect.place))
                });
                made.unwrap_or(f64::NAN)
            }
        }
    }

    /// The effect and the value of it that this is in proportion to, where a fit moves that value and not what is stated.
    pub(crate) fn made_of(self, effects: &[Effect]) -> Option<(usize, usize)> {
        match self {
            Self::Value { effect, value } => {
                let is_ratio = effects[effect].law.parameters[value].is_ratio();
                is_ratio.then_some((effect, value))
            }
            Self::Combination { effect } => Some((effect, 0)),
            Self::Parameter(_) => None,
        }
    }

    /// Its place among all values that a fit moves, or that of the value that it is made of.
    pub(crate) fn place(self, parameters: usize, effects: &[Effect]) -> usize {
        let (effect, value) = match self {
            Self::Parameter(parameter) => return parameter,
            Self::Value { effect, value } => (effect, value),
            Self::Combination { effect } => (effect, 0),
        };
        let before = effects[..effect].iter().map(|effect| effect.values.len());
        parameters + before.sum::<usize>() + value
    }

    /// Gives an effect the value that makes this number of it, and says how much of it a value of one makes.
    pub(crate) fn put(self, effect: &mut Effect, scales: &PlaceScales, number: f64) -> f64 {
        let value = match self {
            Self::Value { value, .. } => value,
            Self::Parameter(_) | Self::Combination { .. } => 0,
        };
        let mut moved: Vec<f64> = moved_values(effect).collect();
        let mut put = |to: f64| {
            moved[value] = to;
            put_values(std::slice::from_mut(effect), &moved);
            self.of_effect(effect, scales)
        };
        let of_one = put(1.0);
        put(number / of_one);
        of_one
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_beams::physics::{Place, laws};

    #[test]
    fn a_number_made_of_values_is_held_while_others_move() {
        let scales = PlaceScales::default();
        let mut effect = Effect {
            law: laws::JOINT_NONLINEARITY,
            place: Place::Joint("A3".into()),
            values: vec![2e-6, -6e-7],
        };
        effect.values[0] = 3e-6;
        let quadratic = Stated::Value {
            effect: 0,
            value: 1,
        };
        let of_one = quadratic.put(&mut effect, &scales, -6e-7);
        assert!((effect.values[1] + 6e-7).abs() < 1e-20 && effect.values[0] == 3e-6);
        assert!((of_one - 3e-6).abs() < 1e-18);
    }
}
