//! The search for laws in a session: forward selection, its rivals, and names taken back where structure is left.

use stiffbench_beams::physics::TestObject;

use super::critical_values::{LawCriticalValues, critical_values};
use super::outlier::is_outlier;
use super::problem_candidates::Candidates;
use super::ranked_candidate::{Ranked, same, weigh};
use super::ranking::CandidateScores;
use crate::mismatch::error::MismatchError;
use crate::mismatch::hold_out::{AllShares, HoldOut, folds_that_ask, misfit_shares};
use crate::mismatch::noise::{KnownNoise, NoiseBasis};
use crate::mismatch::problem::{DiagnosisProblem, SearchOptions, State, key_of};
use crate::mismatch::screen::lacking;
use crate::mismatch::unexplained::{
    Omnibus, Patterns, ResidualPattern, UnexplainedStructure, largest_left, largest_patterns,
    omnibus, unexplained,
};
use crate::search::constants::{MOST_EFFECTS, NULL_SAMPLES, OMNIBUS_LEVEL, STRONG_EVIDENCE};
use crate::search::{
    DrawResiduals, Evidence, ForwardProblem, NullNoise, Selection, forward_selection, rivals,
};

/// Most effects that are searched for in a part (1), whose recording shows more than a session of single readings. Stated.
const MOST_OF_A_PART: usize = 5;

/// Laws of a part with which the search begins again where what it found first leaves more than noise (1). Stated.
const OTHER_STARTS: usize = 4;

/// Weighted squares of a fit, in those of another with the same laws, below which it lies in a deeper valley (1). Numerics.
const CLEARLY_LOWER: f64 = 0.97;

/// The same of repeated readings as a difference (1): less decides nothing. Numerics.
const LOWER: f64 = 2.0;

/// Mean weighted square of the readings from which more is left than scatter of neighbours (1). Stated.
const MORE_THAN_NOISE: f64 = 1.5;

/// Fall of the weighted squares in poses left out above which an effect helps there (1). Stated: none but zero favours neither side.
const HELD_OUT_FALL: f64 = 0.0;

/// A found effect, its rivals in the order of their evidence, itself the first.
#[derive(Debug, Clone)]
pub(crate) struct ResolvedEffect {
    pub(crate) ranked: Vec<Ranked>,
    pub(crate) family_p: f64,
}

/// What a search found.
pub(crate) struct SearchResult {
    pub(crate) before: State,
    pub(crate) after: State,
    pub(crate) resolved: Vec<ResolvedEffect>,
    /// What the baseline leaves to be seen: for maps, limits and rejected candidates.
    pub(crate) first: CandidateScores,
    /// The largest pattern of each stratum that the baseline leaves, with its fall of the squares.
    pub(crate) first_patterns: Vec<(f64, ResidualPattern)>,
    /// Patterns left by the final model, and the fall of the squares by the largest.
    pub(crate) left: UnexplainedStructure,
    /// Whether the final model leaves more than noise does.
    pub(crate) omnibus: Omnibus,
    /// Shares of the misfit that the findings explain.
    pub(crate) shares: AllShares,
}

impl SearchResult {
    /// Whether the final model leaves more than noise does.
    pub(crate) fn is_left(&self) -> bool {
        self.omnibus.p <= OMNIBUS_LEVEL
    }

    /// Whether the final model is another than the first.
    pub(crate) fn changed(&self) -> bool {
        key_of(&self.before) != key_of(&self.after)
    }

    /// What is asked of the model before and the model after.
    pub(crate) fn both<T: Clone, E>(
        &self,
        ask: impl Fn(&State) -> Result<T, E>,
    ) -> Result<[T; 2], E> {
        let before = ask(&self.before)?;
        let after = if self.changed() {
            ask(&self.after)?
        } else {
            before.clone()
        };
        Ok([before, after])
    }

    /// Shares of the misfit that the findings explain.
    fn shares_of(&self, problem: &DiagnosisProblem<'_>) -> Result<AllShares, MismatchError> {
        let found = self.resolved.iter();
        let found: Vec<&[f64]> = found.map(|one| &one.ranked[0].white[..]).collect();
        misfit_shares(problem, [&self.before, &self.after], &found)
    }
}

impl Candidates<'_, '_> {
    /// Critical values for these observations: from the candidates and patterns against the baseline.
    pub(crate) fn critical_values(
        &self,
        first: &CandidateScores,
        state: &State,
        seed: u64,
    ) -> Result<LawCriticalValues, MismatchError> {
        let slopes = self.problem.slope(&state.fitted.model)?;
        let patterns = Patterns::new(self.problem.observations, &slopes.compliance);
        let rounded = self.problem.rounded(state)?;
        let null_vectors = rounded
            .as_ref()
            .map(|rounded| rounded as &dyn DrawResiduals);
        let residuals = &first.residuals[..self.problem.observations.len()];
        let noise = NullNoise::like(residuals, null_vectors, NULL_SAMPLES, seed);
        self.with_white_shapes(first, state, |searched| {
            critical_values(
                self.problem.observations,
                &first.space,
                searched,
                Some(&patterns),
                &noise,
            )
        })
    }

    /// Searches for what is missing.
    ///
    /// # Arguments
    /// - `known`: critical values computed before for the same robot and plan; computed here if `None`.
    pub(crate) fn search(
        &self,
        options: &SearchOptions,
        known: Option<&LawCriticalValues>,
        depth: Depth,
    ) -> Result<(SearchResult, LawCriticalValues), MismatchError> {
        let before = self.first_state(options)?;
        let first = self.score_laws(&before, &options.without)?;
        let critical = match known {
            Some(critical) => critical.clone(),
            None => self.critical_values(&first, &before, options.seed)?,
        };
        let search = LawSearch {
            candidates: *self,
            options,
            critical: &critical,
            depth,
        };
        // What is too little to decide about is not given names.
        let is_from_fit = before.noise.basis == NoiseBasis::Fit;
        let selection = if lacking(self.problem, is_from_fit).is_empty() {
            forward_selection(&search, &before, &first)?
        } else {
            Selection {
                model: before.clone(),
                p: Vec::new(),
            }
        };
        let mut state = selection.model;
        let resolved = search.rivals_of_each(&state, &selection.p)?;
        if let Some(best) = resolved.first().filter(|_| resolved.len() == 1) {
            // Its own ranking may have found a simpler or better member.
            state = search.with(&best.ranked[0])?.unwrap_or(state);
        }
        for (term, one) in resolved.iter().enumerate().filter(|_| resolved.len() > 1) {
            if !search.is_term(&state, term, &one.ranked[0]) {
                let mut model = one.ranked[0].fitted.model.clone();
                model.effects[search.place_of(term)..].rotate_right(1);
                state = self
                    .problem
                    .alternate(model, options.noise)?
                    .unwrap_or(state);
            }
        }
        let problem = self.problem;
        let first_patterns = largest_patterns(problem, &before, &first.space, &first.residuals)?;
        let of_noise = &critical.unexplained;
        let left = if resolved.is_empty() {
            largest_left(
                problem.observations,
                &first_patterns,
                &first.residuals,
                of_noise,
            )
        } else {
            unexplained(problem, &state, of_noise)?
        };
        let mut found = SearchResult {
            omnibus: omnibus(problem, &state, &left)?,
            before,
            after: state,
            resolved,
            first,
            first_patterns,
            left,
            shares: AllShares::default(),
        };
        found.shares = found.shares_of(problem)?;
        if found.is_left() && search.take_back_stand_ins(&mut found)? {
            found.omnibus = omnibus(problem, &found.after, &found.left)?;
            found.shares = found.shares_of(problem)?;
        }
        search.put_largest_first(&mut found)?;
        Ok((found, critical))
    }
}

/// The search for laws: forward selection among candidates of all laws at all places.
pub(crate) struct LawSearch<'s, 'a> {
    pub(crate) candidates: Candidates<'s, 'a>,
    pub(crate) options: &'s SearchOptions,
    pub(crate) critical: &'s LawCriticalValues,
    depth: Depth,
}

/// What a search tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    /// One law after the other.
    OneByOne,
    /// Of a part also pairs of laws of which neither is believed alone.
    Pairs,
}

impl ForwardProblem for LawSearch<'_, '_> {
    type Model = State;
    type Scores = CandidateScores;
    type Fitted = Ranked;
    type Error = MismatchError;

    fn most_terms(&self) -> usize {
        if self.problem().observations.is_recording() {
            MOST_OF_A_PART
        } else {
            MOST_EFFECTS
        }
    }

    fn other_starts(
        &self,
        start: &State,
        scores: &CandidateScores,
        found: &State,
    ) -> Result<Vec<Ranked>, MismatchError> {
        let observations = self.problem().observations;
        let left = found.fitted.squares / observations.len() as f64;
        let has_pairs = observations.is_recording() && self.depth == Depth::Pairs;
        if !has_pairs || left < MORE_THAN_NOISE {
            return Ok(Vec::new());
        }
        // What two laws leave comes back in every cycle, so that neither alone may be worth believing.
        let terms = &found.fitted.model.effects;
        let is_other = |one: &Ranked| !terms.iter().any(|term| same(term, &one.effect));
        let mut ranked = self.rank(start, scores, f64::NEG_INFINITY)?;
        ranked.sort_by(|a, b| a.fitted.squares.total_cmp(&b.fitted.squares));
        let others = ranked.iter_mut().filter(|one| is_other(one));
        for one in others.take(OTHER_STARTS) {
            self.candidates.leave_out(start, one)?;
        }
        weigh(&mut ranked);
        ranked.retain(is_other);
        ranked.truncate(OTHER_STARTS);
        Ok(ranked)
    }

    fn explains_more(&self, model: &State, other: &State) -> bool {
        model.fitted.squares < other.fitted.squares
    }

    fn fits_better(&self, model: &State, other: &State) -> bool {
        let [own, of_other] = [model, other].map(|state| state.fitted.squares);
        if self.problem().observations.is_recording() {
            own < CLEARLY_LOWER * of_other
        } else {
            own < of_other - LOWER
        }
    }

    fn terms(&self, state: &State) -> usize {
        state.fitted.model.effects.len() - self.place_of(0)
    }

    fn score(&self, state: &State) -> Result<CandidateScores, MismatchError> {
        self.candidates.score_laws(state, &self.options.without)
    }

    fn rescore(
        &self,
        state: &State,
        (before, scores): (&State, &CandidateScores),
        share: f64,
    ) -> Result<CandidateScores, MismatchError> {
        let before = (scores, &before.noise.noise);
        self.candidates
            .rescore_laws(state, before, (self.critical, share))
    }

    fn rank(
        &self,
        state: &State,
        scores: &CandidateScores,
        share: f64,
    ) -> Result<Vec<Ranked>, MismatchError> {
        let without = &self.options.without;
        self.candidates
            .rank(state, scores, without, (self.critical, share))
    }

    fn evidence(&self, ranked: &Ranked) -> Evidence {
        ranked.evidence
    }

    fn p(&self, ranked: &Ranked, delta_chi2: f64) -> f64 {
        self.critical.laws.p(ranked.family(), delta_chi2)
    }

    fn is_same(&self, one: &Ranked, other: &Ranked) -> bool {
        same(&one.effect, &other.effect)
    }

    fn is_term(&self, state: &State, term: usize, ranked: &Ranked) -> bool {
        let own = &state.fitted.model.effects[self.place_of(term)];
        same(own, &ranked.effect)
    }

    fn with(&self, ranked: &Ranked) -> Result<Option<State>, MismatchError> {
        let model = ranked.fitted.model.clone();
        self.problem().alternate(model, self.options.noise)
    }

    fn under_covariance_of(
        &self,
        state: &State,
        other: &State,
    ) -> Result<Option<State>, MismatchError> {
        let model = state.fitted.model.clone();
        self.problem()
            .alternate(model, KnownNoise::Given(other.noise))
    }

    fn without(&self, state: &State, effect: usize) -> Result<State, MismatchError> {
        let rest = state.fitted.model.without(self.place_of(effect));
        self.problem()
            .state_of(rest, KnownNoise::Given(state.noise))
    }

    fn may_be_believed(&self, scores: &CandidateScores, ranked: &Ranked) -> bool {
        let observations = self.problem().observations;
        let space = &scores.space;
        let is_jump = ranked.effect.law.is_of_one_run();
        let is_gradual = is_jump && ranked.against_gradual < -STRONG_EVIDENCE;
        let outlier = || is_outlier(observations, space, &ranked.white, &scores.residuals);
        self.is_sharp(ranked) && !is_gradual && !(is_jump && outlier())
    }

    /// Of a jump in a robot's run it is enough that a gradual change is not clearly likelier; of a part nothing is repeated.
    fn is_sharp(&self, ranked: &Ranked) -> bool {
        self.problem().observations.object == TestObject::Robot
            || ranked.against_gradual >= STRONG_EVIDENCE
    }

    /// An effect that passed by chance mostly fits the poses it was found in and fails in the one left out; a true one whose parameters the
    /// other poses determine helps there too. Of what is in one pose by its name the cells of that pose are left out instead.
    fn is_confirmed(
        &self,
        state: &State,
        next: &State,
        ranked: &Ranked,
    ) -> Result<bool, MismatchError> {
        let problem = self.problem();
        let observations = problem.observations;
        if observations.is_recording() {
            // What speaks for it is counted in parts that were left out.
            return Ok(true);
        }
        let place = &ranked.effect.place;
        let Some(folds) = folds_that_ask(observations, place, &ranked.white) else {
            return Ok(true);
        };
        let hold_out = HoldOut::new(problem, next);
        Ok(hold_out.fall(&state.fitted.model, &folds)? > HELD_OUT_FALL)
    }
}

impl<'s, 'a> LawSearch<'s, 'a> {
    pub(crate) fn problem(&self) -> &'s DiagnosisProblem<'a> {
        self.candidates.problem
    }

    /// Where among the effects of a model a term stands: behind the known ones.
    fn place_of(&self, term: usize) -> usize {
        self.problem().known_effects.len() + term
    }

    /// Puts what explains most of the misfit first, whatever was found first. Of equal whole percents, as they are printed, the order stays: it is
    /// that of the evidence.
    fn put_largest_first(&self, found: &mut SearchResult) -> Result<(), MismatchError> {
        let percent = |place: &usize| {
            let shares = &found.shares.each[*place];
            let share = shares.share_of_misfit.or(shares.share_unseen);
            (100.0 * share.unwrap_or(0.0)).round()
        };
        let mut order: Vec<usize> = (0..found.resolved.len()).collect();
        order.sort_by(|a, b| percent(b).total_cmp(&percent(a)));
        if order.is_sorted() {
            return Ok(());
        }
        let problem = self.problem();
        let mut model = found.after.fitted.model.clone();
        let own = model.effects.split_off(self.place_of(0));
        (model.effects).extend(order.iter().map(|&place| own[place].clone()));
        found.after = problem.state_of(model, KnownNoise::Given(found.after.noise))?;
        let resolved = order.iter().map(|&place| found.resolved[place].clone());
        found.resolved = resolved.collect();
        found.shares = found.shares_of(problem)?;
        Ok(())
    }

    /// For each effect of a state the candidates that could stand in its place.
    ///
    /// # Arguments
    /// - `p`: chance of each effect on noise alone when it was found.
    pub(crate) fn rivals_of_each(
        &self,
        state: &State,
        p: &[f64],
    ) -> Result<Vec<ResolvedEffect>, MismatchError> {
        (0..self.terms(state))
            .map(|effect| {
                let mut ranked = rivals(self, state, effect)?;
                let any_sharp = ranked.iter().any(|one| self.is_sharp(one));
                ranked.retain(|one| !any_sharp || self.is_sharp(one));
                let own = ranked.iter().find(|one| self.is_term(state, effect, one));
                let beside_others = own.filter(|_| self.terms(state) > 1).map(|own| {
                    let judged = self.evidence(own).judged(false);
                    self.p(own, judged)
                });
                simplest_first(&mut ranked);
                // What two explain together may show little of each before the other is there.
                let when_found = p.get(effect).copied().unwrap_or(1.0);
                Ok(ResolvedEffect {
                    ranked,
                    family_p: when_found.min(beside_others.unwrap_or(1.0)),
                })
            })
            .collect()
    }
}

/// Puts a simpler law before the one that contains it, if the data do not exclude it.
fn simplest_first(ranked: &mut [Ranked]) {
    let Some(best) = ranked.first() else { return };
    let (law, place, top) = (
        best.effect.law,
        best.effect.place.clone(),
        best.evidence.log_bayes(),
    );
    let simpler = ranked.iter().position(|other| {
        law.contains(other.effect.law)
            && other.effect.place == place
            && other.evidence.log_bayes() > top - STRONG_EVIDENCE
    });
    if let Some(simpler) = simpler {
        ranked[..=simpler].rotate_right(1);
    }
}
