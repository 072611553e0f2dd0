//! Physics that is known before the search: part of every model, its values fitted again.

use stiffbench_beams::physics::Effect;

use super::diagnosis::KnownEffect;
use super::error::MismatchError;
use super::known_noise::KnownNoise;
use super::model::kinked;
use super::problem::DiagnosisProblem;
use super::search::SearchOptions;
use super::state::State;
use super::stated_values::EstimatedValue;

impl DiagnosisProblem<'_> {
    /// The model that the search starts from, fitted. Of known effects that bend or jump at some load it is searched where.
    pub(super) fn first_state(&self, options: &SearchOptions) -> Result<State, MismatchError> {
        let mut state = self.state_of(self.start(), options.noise)?;
        for place in 0..self.known_effects.len() {
            let mut rest = state.fitted.model.clone();
            let effect = rest.effects.remove(place);
            if kinked(&effect).is_none() {
                continue;
            }
            let Some(rest) = self.alternate(rest, KnownNoise::Given(state.noise))? else {
                continue;
            };
            let Some(mut found) = self.with_searched(&rest, &effect)? else {
                continue;
            };
            if found.squares < state.fitted.squares
                && let Some(effect) = found.model.effects.pop()
            {
                found.model.effects.insert(place, effect);
                state = self.alternate(found.model, options.noise)?.unwrap_or(state);
            }
        }
        Ok(state)
    }

    /// What became of the physics that was known beforehand.
    ///
    /// # Arguments
    /// - What is stated of it without and with what was found, one effect after the other.
    pub(super) fn known_effects(
        &self,
        [mut before, mut after]: [&[EstimatedValue]; 2],
    ) -> Vec<KnownEffect> {
        let known = self.known_effects.iter();
        let effect = |given: &Effect| {
            let values = given.values.len();
            let own = |all: &mut &[EstimatedValue]| {
                let own;
                (own, *all) = all.split_at(values);
                own.to_vec()
            };
            KnownEffect {
                given: given.clone(),
                before: own(&mut before),
                after: own(&mut after),
            }
        };
        known.map(effect).collect()
    }
}
