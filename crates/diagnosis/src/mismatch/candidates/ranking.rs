//! Candidates in the order of their evidence, given a model that already holds some effects.

use rayon::prelude::*;

use stiffbench_beams::physics::{Effect, JointRotations, Law};

use super::candidate::{Candidate, candidates};
use super::candidate_scores::{BestShape, ScoredCandidate, best_shapes, score_candidates};
use super::changes::Changes;
use super::critical_values::LawCriticalValues;
use super::part_evidence::ScoredFit;
use super::problem_candidates::Candidates;
use super::ranked_candidate::{Ranked, weigh};
use crate::mismatch::error::MismatchError;
use crate::mismatch::hold_out::{HoldOut, unseen_parts};
use crate::mismatch::observed::{Observations, ReadingNoise};
use crate::mismatch::problem::{
    FittedModel, LinearisedModel, Model, State, StateKey, WarmStart, WeightedFit, key_of, kinked,
};
use crate::search::constants::DISTINGUISHABLE;
use crate::search::{Batched, Evidence, ScoreEngine, WhiteSpace};

/// Candidates that are fitted in full at a time (1). By hand (9e2cc84).
const MOST_FITTED: usize = 24;

/// Δχ² behind the best linear one, to which candidates are fitted in full: a Bayes factor of e^13. By hand (750d6b5).
const FITTED_WITHIN: f64 = 26.0;

/// Share of the best Δχ² by which a law of parts may be behind before its shape is fitted (1): a shape halfway between two that are searched shows half
/// of the whole. Numerics.
const FAR_FROM_ITS_BEST: f64 = 0.5;

/// Slips that are fitted in full at a time (1): one of a few micrometres may as well have come a step or two earlier or later. By hand: of
/// 100 slips 0.9 beyond their critical value 81 were rightly named with six, 75 with two.
const MOST_SLIPS_FITTED: usize = 6;

/// Δχ² of an effect from which the shape of its kinked parameters is searched with full fits. By hand (750d6b5).
const WORTH_A_SHAPE_SEARCH: f64 = 30.0;

/// Where candidates are fitted: a state, and its residuals as candidates see them.
struct FitContext<'a> {
    state: &'a State,
    key: StateKey,
    scores: &'a CandidateScores,
    changes: &'a Changes<'a>,
    engine: Batched<'a>,
}

/// All candidates as the residuals of a state see them.
pub(crate) struct CandidateScores {
    /// The candidates with their shapes; loose members, which have none, are not among them.
    pub(crate) seen: Vec<ScoredCandidate>,
    /// The poses and the space in which they were seen.
    pub(crate) linearised: LinearisedModel,
    pub(crate) space: WhiteSpace,
    /// White residuals of the state.
    pub(crate) residuals: Vec<f64>,
}

impl Candidates<'_, '_> {
    /// Every law at every place as a state leaves it to be seen, nothing fitted.
    ///
    /// # Arguments
    /// - `without`: laws left out.
    pub(crate) fn score_laws(
        &self,
        state: &State,
        without: &[Law],
    ) -> Result<CandidateScores, MismatchError> {
        let mut scores = self.empty_scores(state)?;
        let mut list = candidates(self.problem.observations, &scores.linearised, without);
        let baseline = self.problem.baseline;
        let fitted = &state.fitted.model.parameters;
        list.retain(|candidate| !baseline.contains(candidate.law, &candidate.place, fitted));
        let (periods, list): (Vec<Candidate>, Vec<Candidate>) = list
            .into_iter()
            .partition(|candidate| candidate.law.is_gauge_error());
        let work = || Ok::<_, MismatchError>(see(self.problem.observations, state, &scores, list));
        let mut seen = self.memo.seen(&key_of(state), work)?;
        seen.extend(see(self.problem.observations, state, &scores, periods));
        scores.seen = seen;
        Ok(scores)
    }

    /// The same again under another noise, of those candidates only that may reach a share of their limits.
    ///
    /// # Arguments
    /// - `before`: the view under the noise of the state before.
    pub(crate) fn rescore_laws(
        &self,
        state: &State,
        (before, noise_before): (&CandidateScores, &ReadingNoise),
        (critical, least): (&LawCriticalValues, f64),
    ) -> Result<CandidateScores, MismatchError> {
        // A fall of the squares grows about as the inverse of the variances: by no more than that of them falls which falls most.
        let growth = noise_before.largest_variance_ratio(&state.noise.noise);
        let screened = best_shapes(&before.seen);
        let list = before.seen.iter().zip(screened).filter(|(seen, screened)| {
            let limit = critical.laws.of(seen.candidate.family());
            screened.is_some_and(|screened| growth * screened.best.delta_chi2 >= least * limit)
        });
        let list = list.map(|(seen, _)| seen.candidate.clone()).collect();
        let mut scores = self.empty_scores(state)?;
        scores.seen = see(self.problem.observations, state, &scores, list);
        Ok(scores)
    }

    /// A view of no candidate.
    fn empty_scores(&self, state: &State) -> Result<CandidateScores, MismatchError> {
        let (space, residuals) = self.problem.space(state)?;
        let model = &state.fitted.model;
        let mut linearised =
            (self.problem.predictor()).linearised(&model.parameters, &model.effects)?;
        // About the first state that asks: where it stands matters little to what is worth a fit.
        let columns = || {
            let springs = self.problem.baseline.spring_columns(&model.parameters)?;
            let entries = self.problem.baseline.file_columns(&model.parameters)?;
            Ok::<_, MismatchError>([springs, entries].concat())
        };
        linearised.columns = self.memo.structure_columns(columns)?;
        Ok(CandidateScores {
            seen: Vec::new(),
            linearised,
            space,
            residuals,
        })
    }

    /// Fits what a view shows and weighs the evidence: the best first.
    ///
    /// # Arguments
    /// - `without`: laws left out.
    /// - `least`: share of its limit below which the linear fall of the squares of a candidate is of no interest; minus infinity to fit all.
    pub(crate) fn rank(
        &self,
        state: &State,
        scores: &CandidateScores,
        without: &[Law],
        (critical, least): (&LawCriticalValues, f64),
    ) -> Result<Vec<Ranked>, MismatchError> {
        let effects = &state.fitted.model.effects;
        let enough =
            |law, wide, delta_chi2: f64| delta_chi2 >= least * critical.laws.of((law, wide));
        let mut selected = select(&scores.seen, &best_shapes(&scores.seen), effects);
        selected.retain(|&(place, screened)| {
            let Candidate { law, wide, .. } = scores.seen[place].candidate;
            enough(law, wide, screened.best.delta_chi2)
        });
        let mut ranked = self.fit_selected(state, scores, &selected)?;
        let worth = |law, delta_chi2| !without.contains(&law) && enough(law, false, delta_chi2);
        ranked.extend(self.missing_members(state, scores, worth)?);
        weigh(&mut ranked);
        for ranked in &mut ranked {
            ranked.evidence.critical_value = critical.laws.of(ranked.family());
        }
        sort(&mut ranked);
        self.leave_out_of_best(state, &mut ranked)?;
        Ok(ranked)
    }

    /// Asks of laws of a part how they predict readings that were left out: the best first, until no other comes near by what it shows in the readings
    /// that it was fitted to, which is the most that it can show.
    fn leave_out_of_best(&self, state: &State, ranked: &mut [Ranked]) -> Result<(), MismatchError> {
        loop {
            // A jump may be no more than one bad reading: nothing is measured against it.
            let known = ranked
                .iter()
                .filter(|one| !one.may_fall() && !one.effect.law.is_of_one_run());
            let best = known.map(Ranked::log_bayes).fold(0.0, f64::max);
            let comes_near =
                |one: &Ranked| one.may_fall() && one.evidence.log_bayes() > best - DISTINGUISHABLE;
            let Some(next) = ranked.iter().position(comes_near) else {
                return Ok(());
            };
            self.leave_out(state, &mut ranked[next])?;
            weigh(ranked);
            sort(ranked);
        }
    }

    /// Asks of one law of a part how it predicts readings that were left out.
    pub(crate) fn leave_out(
        &self,
        state: &State,
        ranked: &mut Ranked,
    ) -> Result<(), MismatchError> {
        let Some(part) = ranked.of_a_part.as_mut().filter(|part| !part.left_out) else {
            return Ok(());
        };
        let key = key_of(state);
        let squares = |model: &Model| {
            self.memo.left_out(&key, model, || {
                let folds = unseen_parts(self.problem.observations);
                HoldOut::new(self.problem, state).squares(model, &folds)
            })
        };
        let fall = (squares(&state.fitted.model)? / squares(&ranked.fitted.model)?).ln();
        part.fall = part.fall.min(fall);
        part.left_out = true;
        Ok(())
    }

    /// Fits candidates of a view.
    ///
    /// # Arguments
    /// - `selected`: their places, and their best shapes.
    fn fit_selected(
        &self,
        state: &State,
        scores: &CandidateScores,
        selected: &[(usize, BestShape)],
    ) -> Result<Vec<Ranked>, MismatchError> {
        let effects = &state.fitted.model.effects;
        let Some(changes) = &Changes::new(self.problem.observations, &scores.linearised, effects)
        else {
            return Ok(Vec::new());
        };
        let context = FitContext {
            state,
            key: key_of(state),
            scores,
            changes,
            engine: Batched::new(&scores.space, &scores.residuals),
        };
        let fitted: Vec<Option<Ranked>> = selected
            .par_iter()
            .map(|&(place, screened)| self.fit_candidate(&context, &scores.seen[place], screened))
            .collect::<Result<_, _>>()?;
        Ok(fitted.into_iter().flatten().collect())
    }

    /// A state with one more effect, whose law and place are known and whose values are searched; `None` if nothing can be fitted there.
    pub(crate) fn with_searched(
        &self,
        rest: &State,
        effect: &Effect,
    ) -> Result<Option<FittedModel>, MismatchError> {
        let mut others: Vec<Law> = Law::ALL.to_vec();
        others.retain(|law| *law != effect.law);
        let scores = self.score_laws(rest, &others)?;
        let shapes = best_shapes(&scores.seen).into_iter().enumerate();
        let selected: Vec<(usize, BestShape)> = shapes
            .filter(|(place, _)| scores.seen[*place].candidate.place == effect.place)
            .filter_map(|(place, shape)| Some((place, shape?)))
            .collect();
        let fitted = self.fit_selected(rest, &scores, &selected)?;
        let fitted = fitted.into_iter().map(|ranked| ranked.fitted);
        Ok(fitted.min_by(|a, b| a.squares.total_cmp(&b.squares)))
    }

    /// Fits one candidate in full.
    fn fit_candidate(
        &self,
        context: &FitContext<'_>,
        seen: &ScoredCandidate,
        screened: BestShape,
    ) -> Result<Option<Ranked>, MismatchError> {
        let shape = &seen.shapes[screened.shape];
        let mut effect = shape.effect(&seen.candidate, screened.best.multiple);
        let bounds = &seen.candidate.bounds_near(&shape.shape);
        context.polish(bounds, &mut effect);
        self.memo.fitted(&context.key, &effect, || {
            let scored = (&seen.candidate, screened.best.delta_chi2);
            let fitted = self.fit_from(context, bounds, &effect);
            fitted.map_or(Ok(None), |fitted| self.ranked(context, scored, fitted))
        })
    }

    /// Fits a candidate from an effect.
    fn fit_from(
        &self,
        context: &FitContext<'_>,
        bounds: &[[f64; 2]],
        effect: &Effect,
    ) -> Option<FittedModel> {
        let state = context.state;
        let start = state.fitted.model.with(effect);
        let refit = WeightedFit {
            bounds_of_last: Some(bounds),
            ..self.problem.refit(&state.whitening)
        };
        let first = WeightedFit {
            warm_start: Some(WarmStart::Known(context.changes.linearised())),
            ..refit
        };
        let mut fitted = first.fit(&start)?;
        // A shape that matters is searched with full fits.
        if state.fitted.squares - fitted.squares > WORTH_A_SHAPE_SEARCH {
            fitted = search_shape(&refit, bounds, fitted);
        }
        Some(fitted)
    }

    /// A fitted candidate, not yet weighed.
    fn ranked(
        &self,
        context: &FitContext<'_>,
        (candidate, linear_delta_chi2): (&Candidate, f64),
        fitted: FittedModel,
    ) -> Result<Option<Ranked>, MismatchError> {
        let state = context.state;
        let Some(effect) = fitted.model.effects.last().cloned() else {
            return Ok(None);
        };
        let last = fitted.model.effects.len() - 1;
        let (vector, whole) =
            self.problem
                .effect_vector(&fitted.model, last, &context.scores.space)?;
        let mut scratch = Vec::new();
        let shares =
            state
                .whitening
                .variance_shares(self.problem.observations, &vector, &mut scratch);
        let scored = ScoredFit {
            fitted: &fitted,
            linear_delta_chi2,
            white: &vector,
            dof: state.noise.degrees_of_freedom(shares),
        };
        let seen = (&context.scores.space, &context.scores.residuals[..]);
        let (of_a_part, against_gradual) = scored.part_evidence(self.problem, state, seen)?;
        Ok(Some(Ranked {
            wide: candidate.wide,
            evidence: Evidence {
                delta_chi2: state.fitted.squares - fitted.squares,
                linear_delta_chi2,
                // On noise alone Δχ² grows by the sizes, of which a law with a phase has two.
                amplitudes: if effect.law.search.phase.is_some() {
                    2.0
                } else {
                    1.0
                },
                parameters: effect.fitted_values(),
                dof: scored.dof,
                critical_value: f64::INFINITY,
                log_prior: effect.law.log_prior(&effect.values),
            },
            against_gradual,
            of_a_part,
            white: vector,
            whole,
            fitted,
            effect,
        }))
    }
}

impl FitContext<'_> {
    /// Moves the values that readings depend on by kinks to where the linear fall of the squares is largest.
    fn polish(&self, bounds: &[[f64; 2]], effect: &mut Effect) {
        let Some(value) = kinked(effect) else { return };
        let mut change_m = vec![0.0; self.changes.readings()];
        let (mut joint_rotations, mut scratch) = (JointRotations::default(), Vec::new());
        let path = self.changes.path(&effect.place);
        let mut gain_of = |effect: &Effect| -> f64 {
            let Some(range) =
                self.changes
                    .of(effect, path.as_ref(), &mut joint_rotations, &mut change_m)
            else {
                return f64::NEG_INFINITY;
            };
            let moments = self.engine.moments(&change_m, &range, &mut scratch);
            if moments.square == 0.0 {
                return f64::NEG_INFINITY;
            }
            moments.best_within([0.5, 2.0]).delta_chi2
        };
        let mut best = gain_of(effect);
        let left = self.state.fitted.squares;
        let [lower, upper] = bounds[value];
        search_by_ratios(1.25, |factor| {
            let mut trial = effect.clone();
            trial.values[value] = (trial.values[value] * factor).clamp(lower, upper);
            let delta_chi2 = gain_of(&trial);
            let rise = best - delta_chi2;
            let share = rise / (left - best).max(f64::MIN_POSITIVE);
            if rise < 0.0 {
                best = delta_chi2;
                *effect = trial;
            }
            share
        });
    }
}

/// Share of the least squares by which both neighbours of a value may be above it where it counts as found (1): a quarter of it may still be gained,
/// which in a thousand readings decides nothing. Numerics.
const AS_LOW: f64 = 1e-3;

/// Rounds in which a value is searched: so many find one that is known to a ten-thousandth. Numerics.
const ROUNDS: usize = 24;

/// Tries factors by which a value may be better, a ratio and its inverse, and smaller ones where neither helps.
///
/// # Arguments
/// - `ratio`: the first, above 1.
/// - `rise`: by which share of the least squares so far a factor leaves more; one that leaves less, a negative share, is taken.
fn search_by_ratios(mut ratio: f64, mut rise: impl FnMut(f64) -> f64) {
    for _ in 0..ROUNDS {
        let up = rise(ratio);
        if up < 0.0 {
            continue;
        }
        let down = rise(1.0 / ratio);
        if down < 0.0 {
            continue;
        }
        if up.max(down) < AS_LOW {
            break;
        }
        ratio = ratio.sqrt();
    }
}

/// Moves the value that readings depend on by kinks to where the squares are smallest, with full fits.
fn search_shape(
    refit: &WeightedFit<'_, '_>,
    bounds: &[[f64; 2]],
    start: FittedModel,
) -> FittedModel {
    let last = start.model.effects.len() - 1;
    let Some(value) = kinked(&start.model.effects[last]) else {
        return start;
    };
    let mut best = start;
    let [lower, upper] = bounds[value];
    search_by_ratios(1.2, |factor| {
        let mut trial = best.model.clone();
        let moved = &mut trial.effects[last].values[value];
        *moved = (*moved * factor).clamp(lower, upper);
        let Some(fitted) = refit.fit(&trial) else {
            return f64::INFINITY;
        };
        let share = fitted.squares / best.squares.max(f64::MIN_POSITIVE) - 1.0;
        if share < 0.0 {
            best = fitted;
        }
        share
    });
    best
}

/// Candidates to fit in full: the best, and those near enough to be its rivals, or that contain it, wherever the shapes that were scored lie; of
/// slips only the best ones.
fn select(
    seen: &[ScoredCandidate],
    screened: &[Option<BestShape>],
    existing: &[Effect],
) -> Vec<(usize, BestShape)> {
    let there = |candidate: &Candidate| {
        let mut existing = existing.iter();
        existing.any(|effect| effect.law == candidate.law && effect.place == candidate.place)
    };
    let mut all: Vec<(usize, BestShape)> = screened
        .iter()
        .enumerate()
        .filter_map(|(place, screened)| Some((place, (*screened)?)))
        .filter(|(place, _)| !there(&seen[*place].candidate))
        .collect();
    all.sort_by(|a, b| {
        b.1.best
            .delta_chi2
            .total_cmp(&a.1.best.delta_chi2)
            .then(a.0.cmp(&b.0))
    });
    let Some((first, best)) = all
        .first()
        .map(|(place, best)| (*place, best.best.delta_chi2))
    else {
        return all;
    };
    let first = &seen[first].candidate;
    let mut slips = 0;
    all.retain(|(place, _)| {
        let slip = seen[*place].candidate.law.is_of_one_run();
        slips += usize::from(slip);
        !slip || slips <= MOST_SLIPS_FITTED
    });
    all.retain(|(place, screened)| {
        let candidate = &seen[*place].candidate;
        let of_a_part = candidate.law.history().is_some();
        let contains_best = candidate.law.contains(first.law) && candidate.place == first.place;
        let within = if of_a_part {
            FAR_FROM_ITS_BEST * best
        } else {
            0.0
        };
        contains_best || screened.best.delta_chi2 > best - within.max(FITTED_WITHIN)
    });
    all.truncate(MOST_FITTED);
    all
}

/// The largest evidence first.
fn sort(ranked: &mut [Ranked]) {
    ranked.sort_by(|a, b| b.evidence.log_bayes().total_cmp(&a.evidence.log_bayes()));
}

/// Candidates compared with the residuals of a view.
pub(crate) fn see(
    observations: &Observations,
    state: &State,
    scores: &CandidateScores,
    list: Vec<Candidate>,
) -> Vec<ScoredCandidate> {
    let effects = &state.fitted.model.effects;
    let changes = Changes::new(observations, &scores.linearised, effects);
    let engine = Batched::new(&scores.space, &scores.residuals);
    changes.map_or_else(Vec::new, |changes| {
        score_candidates(&changes, &engine, list)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares that a value leaves: 900, and one more a standard error from the best value.
    fn found(start: f64, best: f64, standard_error: f64) -> f64 {
        let squares = |value: f64| 900.0 + ((value - best) / standard_error).powi(2);
        let mut value = start;
        search_by_ratios(1.2, |factor| {
            let share = squares(factor * value) / squares(value) - 1.0;
            if share < 0.0 {
                value *= factor;
            }
            share
        });
        value
    }

    #[test]
    fn a_value_is_searched_to_less_than_its_standard_error() {
        for (best, standard_error) in [(1.3, 0.1), (0.77, 1e-2), (1.05, 1e-3), (1.0071, 1e-4)] {
            let value = found(1.0, best, standard_error);
            assert!(
                (value - best).abs() < 0.6 * standard_error,
                "{value} {best}"
            );
        }
    }
}
