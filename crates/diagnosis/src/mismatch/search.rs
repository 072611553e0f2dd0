//! The decision: forward steps with swaps, each believed only beyond its calibrated limit.

use stiffbench_beams::physics::Law;

use super::critical_values::{CriticalValues, critical_values};
use super::error::MismatchError;
use super::known_noise::KnownNoise;
use super::memory::key_of;
use super::outlier::is_outlier;
use super::patterns::{Pattern, autocorrelation_p, largest_patterns, patterns};
use super::rank::View;
use super::ranked::{Ranked, same};
use super::refit::Model;
use super::rounded::RoundedNoise;
use super::state::{Bench, State};
use crate::search::WhiteSpace;
use crate::search::constants::{
    BEYOND_PATTERNS, HELD_OUT_FALL, MOST_EFFECTS, NULL_SAMPLES, ONE_POSE, STRONG_EVIDENCE,
    SWAP_GAIN, UNEXPLAINED_LEVEL, WORTH_A_FIT, WORTH_A_LOOK,
};
use crate::search::{DrawResiduals, NullNoise};

/// What a search is to do.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOptions {
    /// Laws that are left out.
    pub without: Vec<Law>,
    /// Seed of the limits' draws.
    pub seed: u64,
    /// What is known of the noise before the readings are looked at.
    pub noise: KnownNoise,
}

impl Default for SearchOptions {
    /// All laws, seed 0, noise from the readings.
    fn default() -> Self {
        Self {
            without: Vec::new(),
            seed: 0,
            noise: KnownNoise::Nothing,
        }
    }
}

/// A found effect, its rivals in the order of their evidence, itself the first.
#[derive(Debug, Clone)]
pub(super) struct Chosen {
    pub(super) ranked: Vec<Ranked>,
    pub(super) family_p: f64,
}

/// What a search found.
pub(super) struct Found {
    pub(super) before: State,
    pub(super) after: State,
    pub(super) chosen: Vec<Chosen>,
    /// What the baseline leaves to be seen: for maps, limits and rejected candidates.
    pub(super) first: View,
    /// The largest pattern of each stratum that the baseline leaves, with its gain.
    pub(super) first_patterns: Vec<(f64, Pattern)>,
    /// Patterns left by the final model, and the gain of the largest.
    pub(super) left: LeftOver,
}

impl Found {
    /// Whether the final model is another than the first.
    pub(super) fn changed(&self) -> bool {
        key_of(&self.before) != key_of(&self.after)
    }
}

/// The largest pattern that a model leaves.
#[derive(Debug, Clone)]
pub(super) struct LeftOver {
    pub(super) pattern: Option<Pattern>,
    pub(super) gain: f64,
    pub(super) p: f64,
}

impl Bench<'_> {
    /// The model without effects.
    pub(super) fn start(&self) -> Model {
        Model {
            parameters: self
                .baseline
                .parameters()
                .iter()
                .map(|parameter| parameter.start)
                .collect(),
            effects: Vec::new(),
        }
    }

    /// Where the gauge stood at each reading, by the model without effects, m.
    pub(super) fn positions_at_start(
        &self,
        options: &SearchOptions,
    ) -> Result<Vec<f64>, MismatchError> {
        let state = self
            .settle(self.start(), options.noise)?
            .ok_or(MismatchError::Empty)?;
        self.positions(&state)
    }

    /// Where the gauge stood at each reading, m: a state's effects moved it, but for those of the gauge itself.
    pub(super) fn positions(&self, state: &State) -> Result<Vec<f64>, MismatchError> {
        let mut model = state.fitted.model.clone();
        model.effects.retain(|effect| !effect.law.is_gauge_error());
        let residuals = self.raw_residuals(&model)?;
        Ok(state.whitening.positions(self.observations, &residuals))
    }

    /// CriticalValues for these observations: from the candidates and patterns against the baseline.
    pub(super) fn critical_values(
        &self,
        first: &View,
        state: &State,
        seed: u64,
    ) -> Result<CriticalValues, MismatchError> {
        let (_, compliance) = self.slope(&mut self.predictor(), &state.fitted.model)?;
        let patterns = patterns(self.observations, &compliance, &first.space);
        let white = self.white_shapes(first, state)?;
        let predicted = self.predicted(&mut self.predictor(), &state.fitted.model)?;
        let rounded = RoundedNoise::new(self.observations, &state.whitening, predicted);
        let drawn = rounded
            .as_ref()
            .map(|rounded| rounded as &dyn DrawResiduals);
        let residuals = &first.residuals[..self.observations.len()];
        let noise = NullNoise::like(residuals, drawn, NULL_SAMPLES, seed);
        let space = &first.space;
        Ok(critical_values(
            self.observations,
            space,
            white,
            patterns,
            &noise,
        ))
    }

    /// The largest pattern of each stratum that a state leaves, and its gain.
    fn largest_patterns(
        &self,
        state: &State,
        space: &WhiteSpace,
        residuals: &[f64],
    ) -> Result<Vec<(f64, Pattern)>, MismatchError> {
        let (_, compliance) = self.slope(&mut self.predictor(), &state.fitted.model)?;
        let observations = self.observations;
        Ok(largest_patterns(
            observations,
            &compliance,
            space,
            residuals,
        ))
    }

    /// Searches for what is missing.
    ///
    /// # Arguments
    /// - `known`: limits worked out before for the same robot and plan; worked out here if `None`.
    pub(super) fn search(
        &self,
        options: &SearchOptions,
        known: Option<&CriticalValues>,
    ) -> Result<(Found, CriticalValues), MismatchError> {
        let before = self
            .settle(self.start(), options.noise)?
            .ok_or(MismatchError::Empty)?;
        let first = self.look(&before, &options.without)?;
        let limits = match known {
            Some(limits) => limits.clone(),
            None => self.critical_values(&first, &before, options.seed)?,
        };
        let mut state = before.clone();
        let mut families: Vec<f64> = Vec::new();
        // What is too little to decide about is not given names.
        let enough = self.lacking().is_empty();
        for step in (0..MOST_EFFECTS).take_while(|_| enough) {
            let view = if step == 0 {
                None
            } else {
                Some(self.look(&state, &options.without)?)
            };
            let view = view.as_ref().unwrap_or(&first);
            let Some((next, p, asked)) = self.accept(&state, view, options, &limits)? else {
                break;
            };
            // Swaps come first: one effect found alone may stand for two, and only the two predict a pose left out.
            let next = if step == 0 {
                next
            } else {
                self.swap(next, options, &limits)?
            };
            // Each further name is one more chance to be wrong: it is told apart from no further name as from another.
            if step > 0 && self.weakest(&next, options, &limits)? <= STRONG_EVIDENCE {
                break;
            }
            if asked && self.held_out_fall(&next, &state.fitted.model)? <= HELD_OUT_FALL {
                break;
            }
            state = next;
            families.push(p);
        }
        let chosen = self.rivals(&state, options, &limits, &families)?;
        if let Some(best) = chosen.first().filter(|_| chosen.len() == 1) {
            // Its own ranking may have found a simpler or better member.
            let model = best.ranked[0].fitted.model.clone();
            if let Some(settled) = self.settle(model, options.noise)? {
                state = settled;
            }
        }
        let first_patterns = self.largest_patterns(&before, &first.space, &first.residuals)?;
        let left = if chosen.is_empty() {
            self.largest_left(&first_patterns, &first.residuals, &limits)
        } else {
            self.left_over(&state, &limits)?
        };
        let mut found = Found {
            before,
            after: state,
            chosen,
            first,
            first_patterns,
            left,
        };
        self.drop_stand_ins(&mut found, options, &limits)?;
        Ok((found, limits))
    }

    /// Takes back, where structure is left that no law explains, what explains less than the largest pattern that is left, or not clearly more
    /// than a pattern without a law would in its stead: it stands for the unknown cause as well as it can, and its name says nothing.
    fn drop_stand_ins(
        &self,
        found: &mut Found,
        options: &SearchOptions,
        limits: &CriticalValues,
    ) -> Result<(), MismatchError> {
        if found.left.p > UNEXPLAINED_LEVEL {
            return Ok(());
        }
        let mut kept: Vec<bool> = Vec::new();
        for (place, chosen) in found.chosen.iter().enumerate() {
            let rest = self.without(&found.after, place)?;
            let instead = self.left_over(&rest, limits)?.gain + BEYOND_PATTERNS;
            let needed = found.left.gain.max(instead);
            kept.push(chosen.ranked.iter().any(|best| best.gain > needed));
        }
        if kept.iter().all(|kept| *kept) {
            return Ok(());
        }
        let mut keep = kept.iter();
        let mut model = found.after.fitted.model.clone();
        model.effects.retain(|_| *keep.next().unwrap_or(&true));
        let Some(state) = self.settle(model, options.noise)? else {
            return Ok(());
        };
        let families: Vec<f64> = found
            .chosen
            .iter()
            .zip(&kept)
            .filter(|(_, kept)| **kept)
            .map(|(chosen, _)| chosen.family_p)
            .collect();
        found.chosen = self.rivals(&state, options, limits, &families)?;
        found.left = self.left_over(&state, limits)?;
        found.after = state;
        Ok(())
    }

    /// The best candidate, if it passes its limit under the noise that it leaves; with its chance on noise alone, and whether poses left
    /// out have a say in it.
    fn accept(
        &self,
        state: &State,
        view: &View,
        options: &SearchOptions,
        limits: &CriticalValues,
    ) -> Result<Option<(State, f64, bool)>, MismatchError> {
        let limit = |ranked: &Ranked| limits.laws.of(ranked.family());
        let worth = |ranked: &Ranked| ranked.gain > WORTH_A_LOOK * limit(ranked);
        let promising = (limits, WORTH_A_FIT * WORTH_A_LOOK);
        let ranked = self.rank(state, view, &options.without, promising)?;
        let Some(mut best) = ranked.into_iter().find(worth) else {
            return Ok(None);
        };
        let rest = &state.fitted.model;
        // The same comparison under the noise that the best candidate leaves, until the one that passes is the one that left it.
        for round in 1..=MOST_EFFECTS {
            let Some(settled) = self.settle(best.fitted.model.clone(), options.noise)? else {
                return Ok(None);
            };
            let Some(baseline) = self.settle(rest.clone(), KnownNoise::Given(settled.noise))?
            else {
                return Ok(None);
            };
            let before = (view, &state.noise.noise);
            let promising = (limits, WORTH_A_FIT);
            let view = self.look_again(&baseline, before, promising)?;
            let again = self.rank(&baseline, &view, &options.without, promising)?;
            let alone = rest.effects.is_empty();
            let passes = |ranked: &Ranked| {
                ranked.judged_gain(alone) > limit(ranked)
                    && !(ranked.effect.law.is_of_one_run()
                        && is_outlier(self.observations, &ranked.white, &view.residuals))
            };
            let Some(passing) = again.into_iter().find(passes) else {
                return Ok(None);
            };
            // Two candidates that pass under each other's noise would take turns: the last to pass is taken, the swaps decide.
            if same(&passing.effect, &best.effect) || round == MOST_EFFECTS {
                let p = limits.laws.p(passing.family(), passing.judged_gain(alone));
                let Some(next) = self.settle(passing.fitted.model.clone(), options.noise)? else {
                    return Ok(None);
                };
                let asked = !self.rests_on_one_pose(&passing.white);
                return Ok(Some((next, p, asked)));
            }
            best = passing;
        }
        Ok(None)
    }

    /// Whether one pose carries most of an effect, or there is one pose only, so that leaving it out asks nothing.
    fn rests_on_one_pose(&self, white: &[f64]) -> bool {
        let mut squares = vec![0.0; self.observations.poses.len()];
        for cell in &self.observations.cells {
            let part = &white[cell.readings.clone()];
            squares[cell.pose] += part.iter().map(|x| x * x).sum::<f64>();
        }
        let whole: f64 = squares.iter().sum();
        let most = squares.iter().copied().fold(0.0, f64::max);
        most > ONE_POSE * whole || whole == 0.0
    }

    /// Replaces effects one at a time by whatever explains more in their stead.
    fn swap(
        &self,
        state: State,
        options: &SearchOptions,
        limits: &CriticalValues,
    ) -> Result<State, MismatchError> {
        let mut state = state;
        for _ in 0..MOST_EFFECTS {
            let mut improved = false;
            for place in 0..state.fitted.model.effects.len() {
                let ranking = self.rank_without(&state, place, options, limits)?;
                let Some(best) = ranking.first() else {
                    continue;
                };
                let now = &state.fitted.model.effects[place];
                let same = best.effect.law == now.law && best.effect.place == now.place;
                let own = ranking
                    .iter()
                    .find(|r| r.effect.law == now.law && r.effect.place == now.place);
                let better = own.is_none_or(|own| best.log_bayes > own.log_bayes + SWAP_GAIN);
                if !same
                    && better
                    && let Some(next) = self.settle(best.fitted.model.clone(), options.noise)?
                {
                    state = next;
                    improved = true;
                }
            }
            if !improved {
                break;
            }
        }
        Ok(state)
    }

    /// Log Bayes factor of that effect of a state which the readings need least, beside the others.
    fn weakest(
        &self,
        state: &State,
        options: &SearchOptions,
        limits: &CriticalValues,
    ) -> Result<f64, MismatchError> {
        let mut weakest = f64::INFINITY;
        for (place, effect) in state.fitted.model.effects.iter().enumerate() {
            let ranking = self.rank_without(state, place, options, limits)?;
            let mut ranked = ranking.iter();
            let own = ranked.find(|ranked| same(&ranked.effect, effect));
            weakest = weakest.min(own.map_or(f64::NEG_INFINITY, |own| own.log_bayes));
        }
        Ok(weakest)
    }

    /// Ranking of all candidates in the place of one effect, the others kept, under the noise of the state.
    fn rank_without(
        &self,
        state: &State,
        place: usize,
        options: &SearchOptions,
        limits: &CriticalValues,
    ) -> Result<Vec<Ranked>, MismatchError> {
        let rest = self.without(state, place)?;
        let view = self.look(&rest, &options.without)?;
        self.rank(&rest, &view, &options.without, (limits, f64::NEG_INFINITY))
    }

    /// A state without one of its effects, under the same noise.
    fn without(&self, state: &State, place: usize) -> Result<State, MismatchError> {
        let mut rest = state.fitted.model.clone();
        rest.effects.remove(place);
        self.settle(rest, KnownNoise::Given(state.noise))?
            .ok_or(MismatchError::Empty)
    }

    /// For each effect of a state the candidates that could stand in its place.
    fn rivals(
        &self,
        state: &State,
        options: &SearchOptions,
        limits: &CriticalValues,
        families: &[f64],
    ) -> Result<Vec<Chosen>, MismatchError> {
        (0..state.fitted.model.effects.len())
            .map(|place| {
                let mut ranked = self.rank_without(state, place, options, limits)?;
                simplest_first(&mut ranked);
                Ok(Chosen {
                    ranked,
                    family_p: families.get(place).copied().unwrap_or(1.0),
                })
            })
            .collect()
    }

    /// The largest pattern that a state leaves.
    fn left_over(&self, state: &State, limits: &CriticalValues) -> Result<LeftOver, MismatchError> {
        let (space, residuals) = self.space(state)?;
        let patterns = self.largest_patterns(state, &space, &residuals)?;
        Ok(self.largest_left(&patterns, &residuals, limits))
    }

    /// The largest of some patterns that are left in white residuals.
    fn largest_left(
        &self,
        patterns: &[(f64, Pattern)],
        residuals: &[f64],
        limits: &CriticalValues,
    ) -> LeftOver {
        // Of equal ones the first.
        let best = patterns.iter().rev().max_by(|a, b| a.0.total_cmp(&b.0));
        let gain = best.map_or(0.0, |(gain, _)| *gain);
        let mut p = limits.unexplained.p(gain);
        let mut pattern = best.map(|(_, pattern)| pattern.clone());
        if let Some(rhythm) = autocorrelation_p(self.observations, residuals) {
            // Two tests share the level.
            if rhythm < p {
                pattern = pattern.map(Pattern::of_the_rest);
            }
            p = (2.0 * p.min(rhythm)).min(1.0);
        }
        LeftOver { pattern, gain, p }
    }
}

/// Puts a simpler law before the one that contains it, if the data do not exclude it.
fn simplest_first(ranked: &mut [Ranked]) {
    let Some(best) = ranked.first() else { return };
    let (law, place, top) = (best.effect.law, best.effect.place.clone(), best.log_bayes);
    let simpler = ranked.iter().position(|other| {
        law.contains(other.effect.law)
            && other.effect.place == place
            && other.log_bayes > top - STRONG_EVIDENCE
    });
    if let Some(simpler) = simpler {
        ranked[..=simpler].rotate_right(1);
    }
}
