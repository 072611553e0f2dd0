//! All that is searched on a bench as white vectors, for counts of what could be found if the noise were known.

use stiffbench_beams::physics::{Law, Place};

use super::baseline::Baseline;
use super::candidate_scores::WhiteCandidate;
use super::critical_values::LawCriticalValues;
use super::error::MismatchError;
use super::observations::Observations;
use super::problem::DiagnosisProblem;
use super::search::SearchOptions;
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

/// All that is searched on a bench.
///
/// # Arguments
/// - `observations`: readings with nothing missing, for where the gauge stands and for the noise.
/// - `critical`: those of the bench.
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
    let bench = DiagnosisProblem::new(baseline, &at_start);
    let state = bench
        .alternate(bench.start(), options.noise)?
        .ok_or(MismatchError::Empty)?;
    let scores = bench.score_laws(&state, &options.without)?;
    let white = bench.white_shapes(&scores, &state)?.into_iter();
    let laws = white.map(|candidate| white_law(candidate, &scores.space, critical));
    Ok(laws.filter(|law| !law.shapes.is_empty()).collect())
}

fn white_law(white: WhiteCandidate, space: &WhiteSpace, critical: &LawCriticalValues) -> WhiteLaw {
    let mut shapes = Vec::new();
    for shape in white.shapes {
        let mut units = shape.vectors;
        let mut lengths = Vec::new();
        for unit in &mut units {
            space.project(unit);
            let length = norm(unit);
            lengths.push(length);
            for value in unit.iter_mut() {
                *value /= length;
            }
        }
        if lengths.iter().all(|length| *length >= ABSORBED) {
            shapes.push(WhiteLawShape {
                units,
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
