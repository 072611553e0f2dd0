//! Structures without one of their elements: candidates with no size, fitted in full each time.

use rayon::prelude::*;

use crate::physics::{Effect, Law};

use super::candidate::{Candidate, Shape};
use super::error::MismatchError;
use super::rank::Ranked;
use super::refit::{Model, Near, Refit};
use super::screen::{WhiteCandidate, WhiteShape};
use super::space::{Space, dot};
use super::state::{Bench, State};

/// Squared length, in standard errors, below which the readings say nothing of a member: it may as well be loose.
const INVISIBLE: f64 = 1e-6;

impl Bench<'_> {
    /// What loose members would change in readings of the baseline, for the limits; the factors fitted again, exactly.
    pub(super) fn loose_shapes(
        &self,
        state: &State,
        space: &Space,
    ) -> Result<Vec<WhiteCandidate>, MismatchError> {
        let base = Model {
            parameters: state.fitted.model.parameters.clone(),
            effects: Vec::new(),
        };
        let exact = self
            .observations
            .with_displacements(self.predicted(&mut self.predictor(), &base)?);
        self.baseline
            .loose_effects()
            .into_par_iter()
            .map(|effect| {
                let start = Model {
                    parameters: base.parameters.clone(),
                    effects: vec![effect.clone()],
                };
                let mut predictor = self.predictor();
                let refit = Refit {
                    observations: &exact,
                    ..self.refit(&state.whitening)
                };
                let Some(fitted) = refit.fit(&mut predictor, &start, true) else {
                    return Ok(None);
                };
                let difference: Vec<f64> = self
                    .predicted(&mut predictor, &fitted.model)?
                    .iter()
                    .zip(&exact.displacement_m)
                    .map(|(with, without)| with - without)
                    .collect();
                let white = space.projected(&difference);
                let square = dot(&white, &white);
                let shape = Shape {
                    values: Vec::new(),
                    scale: [1.0, 1.0],
                    saturation: 0.0,
                };
                Ok((square > INVISIBLE).then(|| WhiteCandidate {
                    candidate: Candidate::of_shapes(
                        Law::LooseMember,
                        effect.place,
                        vec![shape.clone()],
                        1.0,
                        false,
                    ),
                    shapes: vec![WhiteShape {
                        shape,
                        vectors: vec![white],
                        square,
                        peak_m: difference.iter().fold(0.0, |most, d| d.abs().max(most)),
                    }],
                }))
            })
            .filter_map(Result::transpose)
            .collect()
    }

    /// Structures without one element, fitted.
    pub(super) fn loose_members(
        &self,
        state: &State,
        space: &Space,
    ) -> Result<Vec<Ranked>, MismatchError> {
        let existing = &state.fitted.model.effects;
        let elements: Vec<Effect> = self
            .baseline
            .loose_effects()
            .into_iter()
            .filter(|effect| !existing.contains(effect))
            .collect();
        let fitted: Vec<Option<Ranked>> = elements
            .into_par_iter()
            .map(|effect| {
                let start = Model {
                    parameters: state.fitted.model.parameters.clone(),
                    effects: existing.iter().cloned().chain([effect.clone()]).collect(),
                };
                if self.baseline.variant(&start.effects).is_none() {
                    return Ok(None);
                }
                let mut predictor = self.predictor();
                let refit = Refit {
                    near: Some(Near::Start),
                    ..self.refit(&state.whitening)
                };
                let Some(fitted) = refit.fit(&mut predictor, &start, true) else {
                    return Ok(None);
                };
                let gain = state.fitted.squares - fitted.squares;
                if gain < 0.0 {
                    return Ok(None);
                }
                let place = fitted.model.effects.len() - 1;
                let (white, whole) =
                    self.effect_vector(&mut predictor, &fitted.model, place, space)?;
                if dot(&white, &white) <= INVISIBLE {
                    return Ok(None);
                }
                Ok(Some(Ranked {
                    effect,
                    wide: false,
                    gain,
                    log_bayes: f64::NEG_INFINITY,
                    white,
                    whole,
                    dof: 1e6,
                    fitted,
                }))
            })
            .collect::<Result<_, MismatchError>>()?;
        Ok(fitted.into_iter().flatten().collect())
    }
}
