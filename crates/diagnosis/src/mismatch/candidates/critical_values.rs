//! How large a score must be before it is believed: the whole search on noise alone.
//!
//! On noise alone the score of every shape is a function of white numbers and the shape's vector only. Null samples through all shapes of all
//! candidates give the maximum of each law; one constant for all laws makes the chance that any of them passes exactly the level.

use std::ops::Range;

use stiffbench_beams::physics::{Law, Place};

use super::candidate::Candidate;
use super::candidate_scores::{WhiteCandidate, WhiteCandidates, WhiteShape};
use crate::mismatch::observed::Observations;
use crate::mismatch::unexplained::{PatternScratch, Patterns, places_alike};
use crate::search::WhiteSpace;
use crate::search::constants::{LAW_LEVEL, SAME_DIRECTION, UNEXPLAINED_LEVEL};
use crate::search::{
    self, Batched, NullDistribution, NullNoise, NullShape, NullShapes, ScoreEngine,
    without_duplicates,
};

/// The part of `LAW_LEVEL` for mistakes of the robot file and of the set-up (1). Stated.
const SETUP_LEVEL: f64 = 0.005;

/// Single readings that make one block of rows (1). Of 3,000 load cases 16 take 11 s, 1 takes 17 s, all together 170 s. Numerics.
const ROWS_TOGETHER: usize = 16;

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
pub(crate) fn critical_values(
    observations: &Observations,
    space: &WhiteSpace,
    searched: &WhiteCandidates<'_>,
    patterns: Option<&Patterns<'_>>,
    noise: &NullNoise<'_>,
) -> LawCriticalValues {
    let families: Vec<Family> = {
        let candidates = searched.candidates.iter();
        let mut all: Vec<Family> = candidates.map(|candidate| candidate.family()).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let candidates = searched.candidates.iter();
    let alike = places_alike(candidates.map(|candidate| ShapeGroup::of(candidate)));
    let of_laws = |places: Vec<usize>| -> NullShapes<'_> {
        let families = &families;
        Box::new(move || {
            let white = (searched.white)(&places).into_iter();
            let shapes = white.flat_map(|candidate| {
                let own = candidate.candidate.family();
                let family = families.iter().position(|known| *known == own);
                let shapes = null_shapes(candidate, family.unwrap_or(families.len()));
                without_duplicates(shapes, |unit| space.along_basis(unit), SAME_DIRECTION)
            });
            shapes.collect()
        })
    };
    let laws = alike.into_iter().map(of_laws);
    let patterns = patterns.into_iter().flat_map(|patterns| {
        let alike = patterns.alike().into_iter();
        alike.map(|places| patterns_alike(patterns, places, families.len(), space))
    });
    let groups: Vec<NullShapes<'_>> = laws.chain(patterns).collect();
    // Within a series vectors are alike; of single readings a block costs more than it saves.
    let blocks: Vec<Range<usize>> = if observations.has_series() {
        let cells = observations.cells.iter();
        cells.map(|cell| cell.readings.clone()).collect()
    } else {
        let n = observations.len();
        let starts = (0..n).step_by(ROWS_TOGETHER);
        starts
            .map(|first| first..n.min(first + ROWS_TOGETHER))
            .collect()
    };
    let nothing_left = vec![0.0; space.length];
    let engine = Batched::new(space, &nothing_left);
    let mut maxima = engine.null_maxima(groups, families.len() + 1, &blocks, noise);
    let unexplained = maxima.pop().unwrap_or_default();
    let of_kind = |setup: bool, level: f64| {
        let here = families.iter().zip(&maxima);
        let here = here.filter(|((law, _), _)| law.is_setup() == setup);
        let (families, maxima): (Vec<Family>, Vec<Vec<f64>>) = here
            .map(|(family, maxima)| (*family, maxima.clone()))
            .unzip();
        search::CriticalValues::calibrate(&families, &maxima, level)
    };
    LawCriticalValues {
        laws: search::CriticalValues::together([
            of_kind(false, LAW_LEVEL - SETUP_LEVEL),
            of_kind(true, SETUP_LEVEL),
        ]),
        unexplained: NullDistribution::new(unexplained),
    }
}

/// Patterns that may share bases.
fn patterns_alike<'a>(
    patterns: &'a Patterns<'_>,
    places: Vec<usize>,
    family: usize,
    space: &'a WhiteSpace,
) -> NullShapes<'a> {
    Box::new(move || {
        let mut scratch = PatternScratch::default();
        let white = places.iter().filter_map(|&place| {
            let pattern = patterns.white(place, space, &mut scratch)?;
            Some(NullShape {
                family,
                units: pattern.units,
                length: 1.0,
                multiples: [f64::NEG_INFINITY, f64::INFINITY],
            })
        });
        white.collect()
    })
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
}

impl ShapeGroup {
    fn of(candidate: &Candidate) -> Self {
        match &candidate.place {
            joint @ (Place::Joint(_) | Place::Slide(_)) => Self::Place(joint.clone()),
            Place::Run {
                pose,
                direction,
                repeat,
                gauge,
                ..
            } => Self::Place(Place::Run {
                pose: pose.clone(),
                direction: direction.clone(),
                repeat: *repeat,
                step: 0,
                gauge: *gauge,
            }),
            _ if candidate.law.search.phase.is_some() => Self::Period,
            _ => Self::Law,
        }
    }
}

fn null_shapes(candidate: WhiteCandidate, family: usize) -> Vec<NullShape> {
    let null_shape = |shape: WhiteShape| {
        let length = shape.square.sqrt();
        let mut units = shape.vectors;
        for value in &mut units[0].values {
            *value /= length;
        }
        NullShape {
            family,
            units,
            length,
            multiples: shape.shape.scale,
        }
    };
    candidate.shapes.into_iter().map(null_shape).collect()
}
