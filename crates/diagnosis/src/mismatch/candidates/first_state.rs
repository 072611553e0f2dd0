//! Physics that is known before the search: part of every model, its values fitted again.

use super::problem_candidates::Candidates;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::KnownNoise;
use crate::mismatch::problem::{SearchOptions, State, kinked};

impl Candidates<'_, '_> {
    /// The model that the search starts from, fitted. Of known effects that bend or jump at some load it is searched where.
    pub(crate) fn first_state(&self, options: &SearchOptions) -> Result<State, MismatchError> {
        let mut state = self.problem.state_of(self.problem.start(), options.noise)?;
        for place in 0..self.problem.known_effects.len() {
            let mut rest = state.fitted.model.clone();
            let effect = rest.effects.remove(place);
            if kinked(&effect).is_none() {
                continue;
            }
            let Some(rest) = self
                .problem
                .alternate(rest, KnownNoise::Given(state.noise))?
            else {
                continue;
            };
            let Some(mut found) = self.with_searched(&rest, &effect)? else {
                continue;
            };
            if found.squares < state.fitted.squares
                && let Some(effect) = found.model.effects.pop()
            {
                found.model.effects.insert(place, effect);
                state = self
                    .problem
                    .alternate(found.model, options.noise)?
                    .unwrap_or(state);
            }
        }
        Ok(state)
    }
}
