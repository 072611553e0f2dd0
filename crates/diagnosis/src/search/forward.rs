//! Forward selection with swaps, each step believed only beyond its critical value.

use super::constants::{MOST_EFFECTS, STRONG_EVIDENCE, WORTH_A_FIT};
use super::evidence::{log_bayes, under_known_covariance};

/// Share of its critical value that the best candidate needs under the covariance of the model without it, to be checked under its own.
///
/// Under the first an effect that differs between repeats hides part of itself. By hand (cba106e).
const WORTH_A_LOOK: f64 = 0.7;

/// Log Bayes factor by which another candidate must explain more to take the place of an effect. By hand (750d6b5).
const SWAP_GAIN: f64 = 0.5;

/// What speaks for a fitted candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Fall of the weighted squares against the model without it.
    pub delta_chi2: f64,
    /// The same of the best shape that was scored, all else linear: what the critical values are of.
    pub linear_delta_chi2: f64,
    /// Along how many amplitudes it grows on noise alone: 1, or 2 of a candidate with a phase.
    pub amplitudes: f64,
    /// Parameters that were fitted.
    pub parameters: usize,
    /// Degrees of freedom of the variance of its amplitude.
    pub dof: f64,
    /// Critical value of its family.
    pub critical_value: f64,
    /// Logarithm of the prior density of its values, relative to the likeliest ones.
    pub log_prior: f64,
}

impl Evidence {
    /// The Δχ² that must exceed the critical value, as if the covariance were known.
    ///
    /// # Arguments
    /// - `alone`: whether no other term stands beside it. Then it is the score of a shape that the critical values are of: a fit moves the
    ///   shape to where noise suits it best, and passes a quarter more often. Beside other terms the score takes some of their values for
    ///   fixed, and the fit counts.
    #[must_use]
    pub fn judged(&self, alone: bool) -> f64 {
        let delta_chi2 = if alone {
            self.delta_chi2.min(self.linear_delta_chi2)
        } else {
            self.delta_chi2
        };
        under_known_covariance(delta_chi2, self.amplitudes, self.dof)
    }

    /// Logarithm of the Bayes factor against the model without it.
    #[must_use]
    pub fn log_bayes(&self) -> f64 {
        log_bayes(self.delta_chi2, self.critical_value, self.parameters) + self.log_prior
    }
}

/// A problem to whose model terms can be added one at a time.
///
/// A model holds its terms, their parameters and the covariance of the rows that these leave.
pub trait ForwardProblem {
    /// A fitted model with its covariance.
    type Model: Clone;
    /// Candidates scored against a model.
    type Scores;
    /// A candidate fitted beside the terms of a model.
    type Fitted;
    /// Why a model cannot be computed.
    type Error;

    /// Most terms that are searched for.
    fn most_terms(&self) -> usize {
        MOST_EFFECTS
    }

    /// How many terms a model has.
    fn terms(&self, model: &Self::Model) -> usize;

    /// Scores all candidates against a model.
    ///
    /// # Errors
    /// That of the problem, as of all that follow.
    fn score(&self, model: &Self::Model) -> Result<Self::Scores, Self::Error>;

    /// Scores again under another covariance those candidates that may reach a share of their critical values.
    ///
    /// # Arguments
    /// - `before`: a model, and the scores against it.
    ///
    /// # Errors
    /// That of the problem.
    fn rescore(
        &self,
        model: &Self::Model,
        before: (&Self::Model, &Self::Scores),
        share: f64,
    ) -> Result<Self::Scores, Self::Error>;

    /// Fits those candidates whose scores reach a share of their critical values; the largest evidence first.
    ///
    /// # Errors
    /// That of the problem.
    fn rank(
        &self,
        model: &Self::Model,
        scores: &Self::Scores,
        share: f64,
    ) -> Result<Vec<Self::Fitted>, Self::Error>;

    /// What speaks for a fitted candidate.
    fn evidence(&self, fitted: &Self::Fitted) -> Evidence;

    /// Chance that noise alone gives any candidate a Δχ² as rare as this one of the family of a fitted candidate.
    fn p(&self, fitted: &Self::Fitted, delta_chi2: f64) -> f64;

    /// Whether two fitted candidates are the same one.
    fn is_same(&self, one: &Self::Fitted, other: &Self::Fitted) -> bool;

    /// Whether a fitted candidate is a term of a model.
    fn is_term(&self, model: &Self::Model, term: usize, fitted: &Self::Fitted) -> bool;

    /// The model with a fitted candidate: parameters and covariance found from each other; `None` if there is no such model.
    ///
    /// # Errors
    /// That of the problem.
    fn with(&self, fitted: &Self::Fitted) -> Result<Option<Self::Model>, Self::Error>;

    /// A model fitted again under the covariance of another; `None` if there is no such model.
    ///
    /// # Errors
    /// That of the problem.
    fn under_covariance_of(
        &self,
        model: &Self::Model,
        other: &Self::Model,
    ) -> Result<Option<Self::Model>, Self::Error>;

    /// A model without one of its terms, under its own covariance.
    ///
    /// # Errors
    /// That of the problem.
    fn without(&self, model: &Self::Model, term: usize) -> Result<Self::Model, Self::Error>;

    /// Whether a fitted candidate may be believed as far as its score goes; outliers may not.
    fn may_be_believed(&self, scores: &Self::Scores, fitted: &Self::Fitted) -> bool {
        let _ = (scores, fitted);
        true
    }

    /// First terms to begin with again, where what was found is not enough.
    ///
    /// # Errors
    /// That of the problem.
    fn other_starts(
        &self,
        start: &Self::Model,
        scores: &Self::Scores,
        found: &Self::Model,
    ) -> Result<Vec<Self::Fitted>, Self::Error> {
        let _ = (start, scores, found);
        Ok(Vec::new())
    }

    /// Whether a model explains more than another that was found before.
    fn explains_more(&self, model: &Self::Model, other: &Self::Model) -> bool {
        let _ = (model, other);
        false
    }

    /// Whether a model is clearly a better fit than another with the same terms.
    fn fits_better(&self, model: &Self::Model, other: &Self::Model) -> bool {
        let _ = (model, other);
        false
    }

    /// Whether a fitted candidate explains clearly more than a curve that has no physics in it would; only then it takes the place of another.
    fn is_sharp(&self, fitted: &Self::Fitted) -> bool {
        let _ = fitted;
        true
    }

    /// Whether rows that were left out are predicted better with a fitted candidate than without.
    ///
    /// # Arguments
    /// - `next`: the model with it.
    ///
    /// # Errors
    /// That of the problem.
    fn is_confirmed(
        &self,
        model: &Self::Model,
        next: &Self::Model,
        fitted: &Self::Fitted,
    ) -> Result<bool, Self::Error> {
        let _ = (model, next, fitted);
        Ok(true)
    }
}

/// A model found by forward selection.
#[derive(Debug, Clone)]
pub struct Selection<M> {
    /// The model.
    pub model: M,
    /// For each step the chance that noise alone gives any candidate as much.
    pub p: Vec<f64>,
}

impl<M> Selection<M> {
    fn of_first(model: M, p: f64) -> Self {
        Self { model, p: vec![p] }
    }
}

/// A candidate beyond its critical value.
struct Accepted<P: ForwardProblem> {
    fitted: P::Fitted,
    model: P::Model,
    p: f64,
}

/// Adds terms to a model, one at a time, the best candidate first.
///
/// # Arguments
/// - `scores`: of all candidates against the start.
///
/// # Errors
/// That of the problem.
pub fn forward_selection<P: ForwardProblem>(
    problem: &P,
    start: &P::Model,
    scores: &P::Scores,
) -> Result<Selection<P::Model>, P::Error> {
    let nothing = || Selection {
        model: start.clone(),
        p: Vec::new(),
    };
    let most = problem.most_terms();
    let mut best = match accept(problem, start, scores)? {
        Some(first) if problem.is_confirmed(start, &first.model, &first.fitted)? => {
            extended(problem, Selection::of_first(first.model, first.p), most)?
        }
        _ => nothing(),
    };
    // One that takes part of what two others leave may bar the way to both, and each of two may be worth believing beside the other alone.
    let mut pair: Option<Selection<P::Model>> = None;
    for other in problem.other_starts(start, scores, &best.model)? {
        let evidence = problem.evidence(&other);
        let judged = evidence.judged(true);
        let Some(model) = problem.with(&other)? else {
            continue;
        };
        let first = Selection::of_first(model, problem.p(&other, judged));
        let found = extended(problem, first, 2)?;
        let is_alone = problem.terms(&found.model) < 2;
        if is_alone && judged <= evidence.critical_value {
            continue;
        }
        let explains_more =
            |other: &Selection<P::Model>| problem.explains_more(&found.model, &other.model);
        if pair.as_ref().is_none_or(explains_more) {
            pair = Some(found);
        }
    }
    if let Some(pair) = pair {
        let found = extended(problem, pair, most)?;
        if problem.explains_more(&found.model, &best.model) {
            best = found;
        }
    }
    Ok(best)
}

/// A selection with what follows it, up to a number of terms.
fn extended<P: ForwardProblem>(
    problem: &P,
    mut found: Selection<P::Model>,
    most: usize,
) -> Result<Selection<P::Model>, P::Error> {
    while found.p.len() < most {
        let scores = problem.score(&found.model)?;
        let Some(Accepted { fitted, model, p }) = accept(problem, &found.model, &scores)? else {
            break;
        };
        // Swaps come first: one term found alone may stand for two, and only the two predict rows left out.
        let next = swap(problem, model)?;
        // Each further term is one more chance to be wrong: it needs as much evidence against no further one as against another.
        let evidence = evidence_of_terms(problem, &next)?;
        if evidence.iter().any(|evidence| *evidence <= STRONG_EVIDENCE)
            || !problem.is_confirmed(&found.model, &next, &fitted)?
        {
            break;
        }
        found.model = next;
        found.p.push(p);
    }
    Ok(found)
}

/// The best candidate, if it exceeds its critical value under the covariance that it leaves.
fn accept<P: ForwardProblem>(
    problem: &P,
    model: &P::Model,
    scores: &P::Scores,
) -> Result<Option<Accepted<P>>, P::Error> {
    let is_worth_a_look = |fitted: &P::Fitted| {
        let evidence = problem.evidence(fitted);
        evidence.delta_chi2 > WORTH_A_LOOK * evidence.critical_value
    };
    let ranked = problem.rank(model, scores, WORTH_A_FIT * WORTH_A_LOOK)?;
    let Some(mut best) = ranked.into_iter().find(is_worth_a_look) else {
        return Ok(None);
    };
    let alone = problem.terms(model) == 0;
    // The same comparison under the covariance that the best candidate leaves, until the one that passes is the one that left it.
    for round in 1..=MOST_EFFECTS {
        let Some(with) = problem.with(&best)? else {
            return Ok(None);
        };
        let Some(rest) = problem.under_covariance_of(model, &with)? else {
            return Ok(None);
        };
        let rescored = problem.rescore(&rest, (model, scores), WORTH_A_FIT)?;
        let passes = |fitted: &P::Fitted| {
            let evidence = problem.evidence(fitted);
            evidence.judged(alone) > evidence.critical_value
                && problem.may_be_believed(&rescored, fitted)
        };
        let again = problem.rank(&rest, &rescored, WORTH_A_FIT)?;
        let Some(passing) = again.into_iter().find(passes) else {
            return Ok(None);
        };
        // Two candidates that pass under each other's covariance would take turns: the last to pass is taken, the swaps decide.
        if problem.is_same(&passing, &best) || round == MOST_EFFECTS {
            let p = problem.p(&passing, problem.evidence(&passing).judged(alone));
            let model = problem.with(&passing)?;
            return Ok(model.map(|model| Accepted {
                fitted: passing,
                model,
                p,
            }));
        }
        best = passing;
    }
    Ok(None)
}

/// Replaces terms one at a time by whatever explains more in their stead.
fn swap<P: ForwardProblem>(problem: &P, mut model: P::Model) -> Result<P::Model, P::Error> {
    for _ in 0..MOST_EFFECTS {
        let mut improved = false;
        for term in 0..problem.terms(&model) {
            let ranked = rivals(problem, &model, term)?;
            let mut ranked = ranked.iter().filter(|one| problem.is_sharp(one));
            let Some(best) = ranked.clone().next() else {
                continue;
            };
            if problem.is_term(&model, term, best) {
                // Fitted anew beside the others a term may come out of a valley that it was in alone.
                if let Some(next) = problem.with(best)?
                    && problem.fits_better(&next, &model)
                {
                    model = next;
                    improved = true;
                }
                continue;
            }
            let own = ranked.find(|one| problem.is_term(&model, term, one));
            let evidence = |fitted: &P::Fitted| problem.evidence(fitted).log_bayes();
            let is_better = own.is_none_or(|own| evidence(best) > evidence(own) + SWAP_GAIN);
            if is_better && let Some(next) = problem.with(best)? {
                model = next;
                improved = true;
            }
        }
        if !improved {
            break;
        }
    }
    Ok(model)
}

/// Log Bayes factor of each term of a model, beside the others.
///
/// # Errors
/// That of the problem.
fn evidence_of_terms<P: ForwardProblem>(
    problem: &P,
    model: &P::Model,
) -> Result<Vec<f64>, P::Error> {
    let evidence = |term: usize| {
        let ranked = rivals(problem, model, term)?;
        let own = ranked.iter().find(|one| problem.is_term(model, term, one));
        Ok(own.map_or(f64::NEG_INFINITY, |own| problem.evidence(own).log_bayes()))
    };
    (0..problem.terms(model)).map(evidence).collect()
}

/// All candidates in the place of one term, the others kept, under the covariance of the model; the largest evidence first.
///
/// # Errors
/// That of the problem.
pub fn rivals<P: ForwardProblem>(
    problem: &P,
    model: &P::Model,
    term: usize,
) -> Result<Vec<P::Fitted>, P::Error> {
    let rest = problem.without(model, term)?;
    let scores = problem.score(&rest)?;
    problem.rank(&rest, &scores, f64::NEG_INFINITY)
}
