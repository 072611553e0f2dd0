//! How large a score must be before it is believed: the whole search on noise alone.
//!
//! On noise alone the score of every shape is a function of white numbers and the shape's vector only. Null samples through all shapes of all
//! candidates give the maximum of each law; one constant for all laws makes the chance that any of them passes exactly the level.

use std::ops::Range;

use rayon::prelude::*;

use stiffbench_beams::physics::{Law, LawKind, Place};

use super::candidate::Candidate;
use super::candidate_scores::{WhiteCandidate, WhiteShape};
use super::observations::Observations;
use super::patterns::{PatternGroup, ResidualPattern};
use super::stratum::Stratum;
use crate::search::WhiteSpace;
use crate::search::constants::{LAW_LEVEL, SAME_DIRECTION, SETUP_LEVEL, UNEXPLAINED_LEVEL};
use crate::search::{
    self, Batched, NullDistribution, NullNoise, NullShape, ScoreEngine, without_duplicates,
};

/// A law, and whether it is its wide search.
pub type Family = (Law, bool);

/// Critical values of Δχ².
#[derive(Debug, Clone, PartialEq)]
pub struct LawCriticalValues {
    /// Of laws.
    pub laws: search::CriticalValues<Family>,
    /// The largest pattern without a law on noise alone.
    pub unexplained: NullDistribution,
}

impl LawCriticalValues {
    /// The critical value of the largest pattern without a law.
    #[must_use]
    pub fn of_unexplained(&self) -> f64 {
        self.unexplained.quantile(1.0 - UNEXPLAINED_LEVEL)
    }
}

/// Works out the critical values of candidates and patterns.
///
/// # Arguments
/// - `noise`: of the null samples.
pub(super) fn critical_values(
    observations: &Observations,
    space: &WhiteSpace,
    candidates: Vec<WhiteCandidate>,
    patterns: Vec<ResidualPattern>,
    noise: &NullNoise<'_>,
) -> LawCriticalValues {
    let families: Vec<Family> = {
        let mut all: Vec<Family> = candidates
            .iter()
            .filter(|c| !c.shapes.is_empty())
            .map(|c| c.candidate.family())
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let mut groups: Vec<ShapeGroup> = Vec::new();
    let of_candidate = |candidate: &Candidate| {
        let family = candidate.family();
        let place = families.iter().position(|known| *known == family);
        let group = number_of(&mut groups, ShapeGroup::of(candidate));
        (group, place.unwrap_or(families.len()))
    };
    let scored = candidates.iter().map(|white| &white.candidate);
    let numbers: Vec<(usize, usize)> = scored.map(of_candidate).collect();
    let mut shapes: Vec<NullShape> = candidates
        .into_par_iter()
        .zip(numbers)
        .flat_map_iter(|(candidate, (group, family))| {
            let shapes = null_shapes(candidate, group, family);
            without_duplicates(shapes, |unit| space.along_basis(unit), SAME_DIRECTION)
        })
        .collect();
    shapes.extend(patterns.into_iter().map(|pattern| {
        let group = match pattern.stratum {
            Stratum::Rest => ShapeGroup::Period,
            _ => ShapeGroup::Pattern(pattern.group),
        };
        NullShape {
            family: families.len(),
            group: number_of(&mut groups, group),
            units: pattern.units,
            length: 1.0,
            multiples: [f64::NEG_INFINITY, f64::INFINITY],
        }
    }));
    let cells: Vec<Range<usize>> = observations
        .cells
        .iter()
        .map(|c| c.readings.clone())
        .collect();
    let nothing_left = vec![0.0; space.length];
    let engine = Batched::new(space, &nothing_left);
    let mut maxima = engine.null_maxima(shapes, families.len() + 1, &cells, noise);
    let unexplained = maxima.families.pop().unwrap_or_default();
    let of_kind = |kind: LawKind, level: f64| {
        let here = families.iter().zip(&maxima.families);
        let here = here.filter(|((law, _), _)| law.kind == kind);
        let (families, maxima): (Vec<Family>, Vec<Vec<f64>>) = here
            .map(|(family, maxima)| (*family, maxima.clone()))
            .unzip();
        search::CriticalValues::calibrate(&families, &maxima, level)
    };
    LawCriticalValues {
        laws: search::CriticalValues::together([
            of_kind(LawKind::Physics, LAW_LEVEL - SETUP_LEVEL),
            of_kind(LawKind::Setup, SETUP_LEVEL),
        ]),
        unexplained: NullDistribution::new(unexplained),
    }
}

/// What shapes share their bases with.
#[derive(PartialEq)]
enum ShapeGroup {
    /// Laws at one joint, or in one run.
    Place(Place),
    /// Periods of gauges.
    Period,
    /// All other laws.
    Law,
    /// Patterns without a law in the same readings.
    Pattern(PatternGroup),
}

impl ShapeGroup {
    fn of(candidate: &Candidate) -> Self {
        match &candidate.place {
            joint @ Place::Joint(_) => Self::Place(joint.clone()),
            Place::Run {
                pose,
                direction,
                repeat,
                ..
            } => Self::Place(Place::Run {
                pose: pose.clone(),
                direction: *direction,
                repeat: *repeat,
                step: 0,
            }),
            _ if candidate.law.search.phase.is_some() => Self::Period,
            _ => Self::Law,
        }
    }
}

/// The place of something in a list, appended where it is new.
fn number_of<T: PartialEq>(known: &mut Vec<T>, wanted: T) -> usize {
    known
        .iter()
        .position(|one| *one == wanted)
        .unwrap_or_else(|| {
            known.push(wanted);
            known.len() - 1
        })
}

fn null_shapes(candidate: WhiteCandidate, group: usize, family: usize) -> Vec<NullShape> {
    let null_shape = |shape: WhiteShape| {
        let length = shape.square.sqrt();
        let mut units = shape.vectors;
        for value in &mut units[0] {
            *value /= length;
        }
        NullShape {
            family,
            group,
            units,
            length,
            multiples: shape.shape.scale,
        }
    };
    candidate.shapes.into_iter().map(null_shape).collect()
}
