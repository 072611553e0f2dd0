//! In which state the runs of a recording begin, by what the laws then leave.
//!
//! A beginning is no parameter of a law but a nuisance: any load before is as likely as any other, and one that is used costs what its grid is
//! worth. Where runs begin is found twice: before the search by the scores of all laws, and after it by what was found.

use stiffbench_beams::physics::Effect;

use super::candidate_scores::best_shapes;
use super::problem_candidates::{CandidateMemo, Candidates};
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::KnownNoise;
use crate::mismatch::observed::{Beginnings, Observations};
use crate::mismatch::problem::{DiagnosisProblem, FittedModel, Model, SearchOptions, State};
use crate::search::constants::STRONG_EVIDENCE;

/// Loads before the first reading that are tried, as shares of the largest, to either side: a slider keeps what lies between once and twice its
/// friction. Numerics.
const LOADS: [f64; 9] = [0.02, 0.04, 0.07, 0.12, 0.2, 0.35, 0.6, 1.0, 1.8];

/// Those of [`LOADS`] that are tried before the search, where all stretches begin alike.
const FEW_LOADS: [f64; 4] = [0.07, 0.2, 0.6, 1.8];

/// Ratios to the best load so far in later rounds. Numerics.
const NEARBY: [[f64; 4]; 6] = [
    [0.77, 0.88, 1.14, 1.3],
    [0.9, 0.95, 1.05, 1.1],
    [0.95, 0.975, 1.025, 1.05],
    [0.97, 0.985, 1.015, 1.03],
    [0.985, 0.993, 1.007, 1.015],
    [0.993, 0.997, 1.003, 1.007],
];

/// Cost of a beginning that is used: the logarithm of how many were as likely before.
fn cost(beginnings: &Beginnings) -> f64 {
    let of_one = (2.0 * LOADS.len() as f64 + 1.0).ln();
    let of_order = if beginnings.goes_on {
        std::f64::consts::LN_2
    } else {
        0.0
    };
    of_order + of_one * beginnings.loaded() as f64
}

/// The readings of a part with the beginnings that the scores of all laws speak for clearly; `None` where they begin virgin.
pub(crate) fn scored_beginnings(
    problem: &DiagnosisProblem<'_>,
    options: &SearchOptions,
) -> Result<Option<Observations>, MismatchError> {
    let observations = problem.observations;
    if !observations.is_recording() {
        return Ok(None);
    }
    let memo = CandidateMemo::default();
    let state = Candidates::new(problem, &memo).first_state(options)?;
    let squares = state.fitted.squares;
    let largest =
        |observations: &Observations| largest_fall(problem, observations, &state, options);
    let virgin = largest(observations)?;
    let independent = problem.independent_values(&state, &state.fitted.model)?;
    let independent = independent.unwrap_or(observations.len() as f64);
    let left = |fall: f64| (squares - fall).max(f64::MIN_POSITIVE);
    let log_bayes = |beginnings: Beginnings| -> Result<(f64, Observations), MismatchError> {
        let cost = cost(&beginnings);
        let begun = observations.with_beginnings(beginnings);
        let fall = largest(&begun)?;
        let log_bayes = 0.5 * independent * (left(virgin) / left(fall)).ln() - cost;
        Ok((log_bayes, begun))
    };
    let mut best: Option<(f64, Observations)> = None;
    let mut take = |beginnings: Beginnings| -> Result<bool, MismatchError> {
        let tried = log_bayes(beginnings)?;
        let least = best
            .as_ref()
            .map_or(STRONG_EVIDENCE, |(log_bayes, _)| *log_bayes);
        let is_better = tried.0 > least;
        if is_better {
            best = Some(tried);
        }
        Ok(is_better)
    };
    let mut chosen = None;
    for goes_on in orders(observations) {
        let stretches = stretches(observations, goes_on);
        let sides = FEW_LOADS.iter().flat_map(|share| [*share, -share]);
        let loads = sides.map(|share| Some(share * observations.largest_load()));
        for load in std::iter::once(None).chain(loads) {
            let loaded_to = load.map_or_else(Vec::new, |load| vec![Some(load); stretches]);
            let beginnings = Beginnings { goes_on, loaded_to };
            if !beginnings.are_virgin() && take(beginnings.clone())? {
                chosen = Some(beginnings);
            }
        }
    }
    for ratio in NEARBY.iter().flatten() {
        let Some(coarse) = &chosen else { break };
        let mut near = coarse.clone();
        for load in near.loaded_to.iter_mut().flatten() {
            *load *= ratio;
        }
        if near.loaded() > 0 && take(near.clone())? {
            chosen = Some(near);
        }
    }
    Ok(best.map(|(_, begun)| begun))
}

/// Largest fall of the squares by any shape of any law, seen from a state.
pub(crate) fn largest_fall(
    problem: &DiagnosisProblem<'_>,
    observations: &Observations,
    state: &State,
    options: &SearchOptions,
) -> Result<f64, MismatchError> {
    let problem = problem.with_readings(observations);
    let memo = CandidateMemo::default();
    let scores = Candidates::new(&problem, &memo).score_laws(state, &options.without)?;
    let best = best_shapes(&scores.seen).into_iter().flatten();
    let falls = best.map(|shape| shape.best.delta_chi2);
    Ok(falls.fold(0.0, f64::max))
}

/// Whether runs begin anew, and whether they go on, where that differs.
fn orders(observations: &Observations) -> Vec<bool> {
    let goes_on = observations.with_beginnings(Beginnings {
        goes_on: true,
        loaded_to: Vec::new(),
    });
    let differs = goes_on.runs != observations.runs
        || goes_on.histories.len() != observations.histories.len();
    if differs {
        vec![false, true]
    } else {
        vec![false]
    }
}

/// How many stretches of readings go on without a gap.
fn stretches(observations: &Observations, goes_on: bool) -> usize {
    let beginnings = Beginnings {
        goes_on,
        loaded_to: Vec::new(),
    };
    observations.with_beginnings(beginnings).histories.len()
}

/// The readings with the beginnings that a model, or one of its effects alone, speaks for clearly, if they are others than the readings have.
///
/// An effect alone: what a wrong beginning leaves may have been given names.
pub(crate) fn fitted_beginnings(
    problem: &DiagnosisProblem<'_>,
    found: &State,
) -> Result<Option<Observations>, MismatchError> {
    let remembers = |effect: &&Effect| effect.law.history().is_some() || effect.law.is_of_a_joint();
    let model = &found.fitted.model;
    let known = problem.known_effects.len();
    let alone = model.effects[known..].iter().filter(remembers);
    let mut models: Vec<Model> = alone.map(|effect| problem.start().with(effect)).collect();
    if !models.is_empty() && model.effects.len() > known + 1 {
        models.push(model.clone());
    }
    let mut best: Option<(f64, Observations)> = None;
    for model in models {
        let Some(state) = problem.alternate(model, KnownNoise::Given(found.noise))? else {
            continue;
        };
        for goes_on in orders(problem.observations) {
            let Some((fitted, begun)) = best_of_order(problem, &state, goes_on)? else {
                continue;
            };
            let there = State {
                fitted,
                ..state.clone()
            };
            let log_bayes =
                log_bayes_over((&problem.with_readings(&begun), &there), (problem, found))?;
            let least = best.as_ref().map_or(STRONG_EVIDENCE, |(most, _)| *most);
            if log_bayes > least && begun.beginnings != problem.observations.beginnings {
                best = Some((log_bayes, begun));
            }
        }
    }
    Ok(best.map(|(_, begun)| begun))
}

/// Logarithm of the evidence for a model and its beginnings against another: each value costs what it is known better by (Schwarz, Annals of
/// Statistics 6, 1978, p. 461).
///
/// # Arguments
/// - `other`: that other model, and the problem with the beginnings that it has.
pub(crate) fn log_bayes_over(
    (problem, state): (&DiagnosisProblem<'_>, &State),
    other: (&DiagnosisProblem<'_>, &State),
) -> Result<f64, MismatchError> {
    let squares = [state, other.1].map(|state| state.fitted.squares.max(f64::MIN_POSITIVE));
    // As many independent values as the better of the two leaves.
    let independent_values = |problem: &DiagnosisProblem<'_>, state: &State| {
        problem.independent_values(state, &state.fitted.model)
    };
    let independent = if squares[0] <= squares[1] {
        independent_values(problem, state)?
    } else {
        independent_values(other.0, other.1)?
    };
    let (fit, count) = match independent {
        Some(count) => (0.5 * count * (squares[1] / squares[0]).ln(), count),
        None => (
            0.5 * (squares[1] - squares[0]),
            problem.observations.len() as f64,
        ),
    };
    let of_values = |state: &State| {
        let values = state.fitted.model.effects.iter().map(Effect::fitted_values);
        0.5 * values.sum::<usize>() as f64 * count.ln()
    };
    let own = of_values(state) + cost(&problem.observations.beginnings);
    let of_other = of_values(other.1) + cost(&other.0.observations.beginnings);
    Ok(fit - own + of_other)
}

/// Each stretch with the load before it that leaves least, and the model fitted in turn; `None` if it cannot be fitted.
fn best_of_order(
    problem: &DiagnosisProblem<'_>,
    state: &State,
    goes_on: bool,
) -> Result<Option<(FittedModel, Observations)>, MismatchError> {
    let observations = problem.observations;
    let largest = observations.largest_load();
    let begun = |loaded_to: &[Option<f64>]| {
        let loaded_to = loaded_to.to_vec();
        observations.with_beginnings(Beginnings { goes_on, loaded_to })
    };
    let now = &observations.beginnings;
    let count = stretches(observations, goes_on);
    let mut loads = if now.goes_on == goes_on && now.loaded_to.len() == count {
        now.loaded_to.clone()
    } else {
        vec![None; count]
    };
    let mut best = state.fitted.clone();
    let grid = LOADS.iter().flat_map(|share| [*share, -share]);
    let grid: Vec<f64> = grid.map(|share| share * largest).collect();
    for round in 0..=NEARBY.len() {
        let ratios = NEARBY
            .get(round.wrapping_sub(1))
            .map_or(&[][..], |near| &near[..]);
        let mut tried: Vec<Vec<Option<f64>>> = vec![loads.clone()];
        if round == 0 {
            tried.extend(grid.iter().map(|load| vec![Some(*load); loads.len()]));
        }
        let near = |ratio: &f64| {
            loads
                .iter()
                .map(|load| load.map(|load| ratio * load))
                .collect()
        };
        tried.extend(ratios.iter().map(near));
        let mut least = vec![f64::INFINITY; loads.len()];
        for trial in tried {
            let left = left_in_stretches(problem, state, &best.model, &begun(&trial))?;
            for (place, left) in left.into_iter().enumerate() {
                if left < least[place] {
                    least[place] = left;
                    loads[place] = trial[place];
                }
            }
        }
        let there = begun(&loads);
        let problem = problem.with_readings(&there);
        let refit = problem.refit(&state.whitening);
        let Some(fitted) = refit.fit(&best.model) else {
            return Ok(None);
        };
        best = fitted;
    }
    Ok(Some((best, begun(&loads))))
}

/// Weighted squares that a model leaves in each stretch.
fn left_in_stretches(
    problem: &DiagnosisProblem<'_>,
    state: &State,
    model: &Model,
    begun: &Observations,
) -> Result<Vec<f64>, MismatchError> {
    let problem = problem.with_readings(begun);
    let refit = problem.refit(&state.whitening);
    let left = refit.residuals(model)?;
    let squares = |readings: std::ops::Range<usize>| match &left {
        Some(left) => left[readings].iter().map(|one| one * one).sum(),
        None => f64::INFINITY,
    };
    let histories = begun.histories.iter();
    Ok(histories.map(|one| squares(one.kept_readings())).collect())
}
