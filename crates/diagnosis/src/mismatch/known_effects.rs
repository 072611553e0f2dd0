//! Physics that is known before the search: part of every model, its values fitted again.

use super::diagnosis::{EstimatedValue, KnownEffect};
use super::error::MismatchError;
use super::known_noise::KnownNoise;
use super::problem::DiagnosisProblem;
use super::ranking::kinked;
use super::search::{SearchOptions, SearchResult};
use super::state::State;

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
    pub(super) fn known_effects(
        &self,
        found: &SearchResult,
    ) -> Result<Vec<KnownEffect>, MismatchError> {
        if self.known_effects.is_empty() {
            return Ok(Vec::new());
        }
        let parameters = self.baseline.parameters().len();
        let values = |state: &State| -> Result<Vec<Vec<EstimatedValue>>, MismatchError> {
            let model = &state.fitted.model;
            let mut uncertainties = self.covariance(state, model)?.into_iter().skip(parameters);
            let known = &model.effects[..self.known_effects.len()];
            Ok(known
                .iter()
                .map(|effect| {
                    let own = effect.values.iter().zip(uncertainties.by_ref());
                    own.map(|(&value, (u, dof))| EstimatedValue::of_covariance(value, (u, dof)))
                        .collect()
                })
                .collect())
        };
        let (before, after) = (values(&found.before)?, values(&found.after)?);
        let both = before.into_iter().zip(after);
        Ok(self
            .known_effects
            .iter()
            .zip(both)
            .map(|(given, (before, after))| KnownEffect {
                given: given.clone(),
                before,
                after,
            })
            .collect())
    }
}
