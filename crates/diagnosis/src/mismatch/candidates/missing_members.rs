//! Structures without one of their elements: candidates with no size, fitted in full each time.

use rayon::prelude::*;

use stiffbench_beams::physics::{Effect, Law, PlaceScale, Shape};

use super::candidate::Candidate;
use super::candidate_scores::{WhiteCandidate, WhiteShape};
use super::changes::MissingMemberChange;
use super::problem_candidates::Candidates;
use super::ranked_candidate::Ranked;
use super::ranking::CandidateScores;
use crate::mismatch::error::MismatchError;
use crate::mismatch::problem::{Model, State, WarmStart, WeightedFit, key_of};
use crate::search::WhiteSpace;
use crate::search::{Evidence, RowVector, dot, largest, subtract};

/// Linear Δχ² of a member's absence, as a share of the squared length of what it changes, below which no fit makes it positive: halfway from
/// what a structure with the member leaves (-1) to what explains nothing (0). By hand (65f5168).
const HOPELESS: f64 = -0.5;

/// Squared length, in standard errors, below which the readings carry no information on a member: it may as well be loose. Numerics.
const INVISIBLE_MEMBER: f64 = 1e-6;

impl Candidates<'_, '_> {
    /// What loose members would change in readings of the baseline, for the limits; the factors fitted again, exactly.
    pub(crate) fn missing_member_shapes(
        &self,
        state: &State,
        space: &WhiteSpace,
    ) -> Result<Vec<WhiteCandidate>, MismatchError> {
        let shaped = |change: &MissingMemberChange| {
            let change_m = change.change_m.as_ref()?;
            let white = space.projected(change_m);
            let square = dot(&white, &white);
            let shape = Shape {
                values: Vec::new(),
                scale: [1.0, 1.0],
                saturation: 0.0,
                held: None,
            };
            (square > INVISIBLE_MEMBER).then(|| WhiteCandidate {
                candidate: Candidate {
                    law: change.effect.law,
                    place: change.effect.place.clone(),
                    shapes: vec![shape.clone()],
                    scale: PlaceScale::default(),
                    wide: false,
                },
                shapes: vec![WhiteShape {
                    shape,
                    vectors: vec![RowVector::from(white)],
                    square,
                    peak_m: largest(change_m),
                }],
            })
        };
        Ok(self
            .missing_member_changes(state)?
            .iter()
            .filter_map(shaped)
            .collect())
    }

    /// What each loose member would change, about the first state that was asked for: where it stands matters little.
    fn missing_member_changes(
        &self,
        state: &State,
    ) -> Result<&[MissingMemberChange], MismatchError> {
        self.memo.missing_member_changes(|| {
            let base = Model {
                parameters: state.fitted.model.parameters.clone(),
                effects: Vec::new(),
            };
            let exact = self.problem.predicted(&base)?;
            let exact = self.problem.observations.with_displacements(exact);
            let change = |effect: Effect| {
                let start = base.with(&effect);
                let refit = WeightedFit {
                    observations: &exact,
                    ..self.problem.refit(&state.whitening)
                };
                let fitted = refit.fit(&start);
                let change_m = fitted
                    .map(|fitted| {
                        let mut with = self.problem.predicted(&fitted.model)?;
                        subtract(&mut with, 1.0, &exact.displacement_m);
                        Ok::<_, MismatchError>(with)
                    })
                    .transpose()?;
                Ok(MissingMemberChange { effect, change_m })
            };
            let effects = self.problem.baseline.other_structures().into_par_iter();
            effects.with_max_len(1).map(change).collect()
        })
    }

    /// Structures without one element, fitted.
    ///
    /// # Arguments
    /// - `worth`: whether the linear fall of the squares is worth a fit.
    pub(crate) fn missing_members(
        &self,
        state: &State,
        view: &CandidateScores,
        worth: impl Fn(Law, f64) -> bool,
    ) -> Result<Vec<Ranked>, MismatchError> {
        let existing = &state.fitted.model.effects;
        let key = key_of(state);
        let is_promising = |change: &&MissingMemberChange| {
            let Some(change_m) = &change.change_m else {
                return worth(change.effect.law, f64::INFINITY);
            };
            let white = view.space.projected(change_m);
            let square = dot(&white, &white);
            let delta_chi2 = 2.0 * dot(&white, &view.residuals) - square;
            // Of a state that misses more than the element ever moved the line through another state says little.
            let is_hopeless = square > state.fitted.squares && delta_chi2 <= HOPELESS * square;
            worth(change.effect.law, delta_chi2) && !is_hopeless
        };
        let effects: Vec<&Effect> = self
            .missing_member_changes(state)?
            .iter()
            .filter(|change| !existing.contains(&change.effect))
            .filter(is_promising)
            .map(|change| &change.effect)
            .collect();
        let fitted: Vec<Option<Ranked>> = effects
            .into_par_iter()
            .map(|effect| {
                let fit = || self.missing_member(state, &view.space, effect);
                self.memo.fitted(&key, effect, fit)
            })
            .collect::<Result<_, MismatchError>>()?;
        Ok(fitted.into_iter().flatten().collect())
    }

    /// The structure of a state without one element more, fitted.
    fn missing_member(
        &self,
        state: &State,
        space: &WhiteSpace,
        effect: &Effect,
    ) -> Result<Option<Ranked>, MismatchError> {
        let start = state.fitted.model.with(effect);
        if self.problem.baseline.variant(&start.effects).is_none() {
            return Ok(None);
        }
        let refit = WeightedFit {
            warm_start: Some(WarmStart::Start),
            ..self.problem.refit(&state.whitening)
        };
        let Some(fitted) = refit.fit(&start) else {
            return Ok(None);
        };
        let delta_chi2 = state.fitted.squares - fitted.squares;
        if delta_chi2 < 0.0 {
            return Ok(None);
        }
        let place = fitted.model.effects.len() - 1;
        let (white, whole) = self.problem.effect_vector(&fitted.model, place, space)?;
        if dot(&white, &white) <= INVISIBLE_MEMBER {
            return Ok(None);
        }
        Ok(Some(Ranked {
            effect: effect.clone(),
            wide: false,
            evidence: Evidence {
                delta_chi2,
                // It has no shape that a fit could move.
                linear_delta_chi2: delta_chi2,
                amplitudes: 1.0,
                parameters: effect.values.len(),
                dof: 1e6,
                critical_value: f64::INFINITY,
                log_prior: effect.law.log_prior(&effect.values),
            },
            white,
            whole,
            against_gradual: f64::INFINITY,
            of_a_part: None,
            fitted,
        }))
    }
}
