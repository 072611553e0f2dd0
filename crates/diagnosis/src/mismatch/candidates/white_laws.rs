//! All that is searched on a problem as white vectors, for counts of what could be found if the noise were known.

use stiffbench_beams::physics::{Law, Place};

use super::candidate_scores::{ScoredCandidate, WhiteCandidate, WhiteCandidates, white_candidates};
use super::changes::Changes;
use super::critical_values::LawCriticalValues;
use super::problem_candidates::{CandidateMemo, Candidates};
use super::ranking::CandidateScores;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, SearchOptions, State};
use crate::search::constants::ABSORBED;
use crate::search::{WhiteSpace, norm};

/// A law at a place as a search sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct WhiteLaw {
    /// The law.
    pub law: Law,
    /// The place.
    pub place: Place,
    /// Whether it is the wide search of the law.
    pub wide: bool,
    /// Its critical value of Δχ².
    pub critical_value: f64,
    /// Its shapes.
    pub shapes: Vec<WhiteLawShape>,
}

/// A shape of a law, white and projected.
#[derive(Debug, Clone, PartialEq)]
pub struct WhiteLawShape {
    /// One vector of unit length, or two that are orthogonal, of a law with a phase.
    pub units: Vec<Vec<f64>>,
    /// Smallest and largest length, standard errors.
    pub sizes: [f64; 2],
}

/// All that is searched on a problem.
///
/// # Arguments
/// - `observations`: readings with nothing missing, for where the gauge stands and for the noise.
/// - `critical`: those of the problem.
///
/// # Errors
/// [`MismatchError`].
pub fn white_laws(
    baseline: &dyn Baseline,
    observations: &Observations,
    options: &SearchOptions,
    critical: &LawCriticalValues,
) -> Result<Vec<WhiteLaw>, MismatchError> {
    if observations.is_empty() {
        return Err(MismatchError::Empty);
    }
    let positions = DiagnosisProblem::new(baseline, observations).positions_at_start(options)?;
    let at_start = observations.with_positions(&positions);
    let problem = DiagnosisProblem::new(baseline, &at_start);
    let state = problem.state_of(problem.start(), options.noise)?;
    let memo = CandidateMemo::default();
    let candidates = Candidates::new(&problem, &memo);
    let scores = candidates.score_laws(&state, &options.without)?;
    candidates.with_white_shapes(&scores, &state, |searched| {
        let all: Vec<usize> = (0..searched.candidates.len()).collect();
        let white = (searched.white)(&all).into_iter();
        let laws = white.map(|candidate| white_law(candidate, &scores.space, critical));
        laws.filter(|law| !law.shapes.is_empty()).collect()
    })
}

impl Candidates<'_, '_> {
    /// All that is searched, as white vectors that are made when they are wanted: what a view shows, and loose members.
    pub(crate) fn with_white_shapes<T>(
        &self,
        scores: &CandidateScores,
        state: &State,
        work: impl FnOnce(&WhiteCandidates<'_>) -> T,
    ) -> Result<T, MismatchError> {
        let effects = &state.fitted.model.effects;
        let changes = Changes::new(self.problem.observations, &scores.linearised, effects);
        let missing = self.missing_member_shapes(state, &scores.space)?;
        let is_shown = |scored: &&ScoredCandidate| changes.is_some() && !scored.shapes.is_empty();
        let seen: Vec<&ScoredCandidate> = scores.seen.iter().filter(is_shown).collect();
        let candidates = seen.iter().map(|scored| &scored.candidate);
        let white = |places: &[usize]| {
            let is_seen = |place: &&usize| **place < seen.len();
            let shown = places.iter().filter(is_seen).map(|&place| seen[place]);
            let mut white = changes.as_ref().map_or_else(Vec::new, |changes| {
                white_candidates(changes, &scores.space, shown)
            });
            let others = places.iter().filter(|place| !is_seen(place));
            white.extend(others.map(|&place| missing[place - seen.len()].clone()));
            white
        };
        Ok(work(&WhiteCandidates {
            candidates: candidates
                .chain(missing.iter().map(|missing| &missing.candidate))
                .collect(),
            white: &white,
        }))
    }
}

fn white_law(white: WhiteCandidate, space: &WhiteSpace, critical: &LawCriticalValues) -> WhiteLaw {
    let white = white.projected(space);
    let mut shapes = Vec::new();
    for shape in white.shapes {
        let lengths: Vec<f64> = shape
            .vectors
            .iter()
            .map(|unit| norm(&unit.values))
            .collect();
        if lengths.iter().all(|length| *length >= ABSORBED) {
            let units = shape.vectors.iter().zip(&lengths);
            let units = units.map(|(unit, length)| {
                let values = unit.values.iter();
                values.map(|value| value / length).collect()
            });
            shapes.push(WhiteLawShape {
                units: units.collect(),
                sizes: shape.shape.scale.map(|scale| scale * lengths[0]),
            });
        }
    }
    let candidate = white.candidate;
    WhiteLaw {
        critical_value: critical.laws.of(candidate.family()),
        law: candidate.law,
        place: candidate.place,
        wide: candidate.wide,
        shapes,
    }
}
