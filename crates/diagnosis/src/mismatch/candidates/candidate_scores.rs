//! Every shape of every candidate scored against the residuals: linear, exact in the shape, in parallel.

use std::ops::Range;

use rayon::prelude::*;

use stiffbench_beams::physics::{Effect, JointPath, JointRotations, Place, Shape};
use stiffbench_numeric::simd::widest;

use super::candidate::Candidate;
use super::changes::Changes;
use crate::search::WhiteSpace;
use crate::search::{BestAmplitude, Moments, RowVector, ScoreEngine, dot, subtract};

/// White length at its largest possible size, standard errors, below which a shape is left out. Numerics.
const INVISIBLE: f64 = 1e-3;

/// White length of a joint that turns freely, standard errors, up to which no law at that joint is tried: none turns it further. By hand
/// (cba106e).
const HIDDEN_JOINT: f64 = 2.0;

/// A candidate with its shapes ready: those that can be seen at all.
#[derive(Debug, Clone)]
pub(crate) struct Shaped<S> {
    pub(crate) candidate: Candidate,
    pub(crate) shapes: Vec<S>,
}

/// A candidate with the scores of its shapes.
pub(crate) type ScoredCandidate = Shaped<ScoredShape>;

/// A candidate with its shapes as white vectors.
pub(crate) type WhiteCandidate = Shaped<WhiteShape>;

/// Candidates whose white vectors are made when they are wanted: together they would fill the memory.
pub(crate) struct WhiteCandidates<'a> {
    pub(crate) candidates: Vec<&'a Candidate>,
    /// Those at some places, in order.
    pub(crate) white: &'a (dyn Fn(&[usize]) -> Vec<WhiteCandidate> + Sync),
}

/// A shape with its score.
#[derive(Debug, Clone)]
pub(crate) struct ScoredShape {
    pub(crate) shape: Shape,
    pub(crate) moments: Moments,
    /// Those of a law's quarter turn of phase, made orthogonal to the first.
    pub(crate) quarter: Option<Moments>,
    /// Largest change of a reading, m.
    pub(crate) peak_m: f64,
}

/// A shape as a white vector.
#[derive(Debug, Clone)]
pub(crate) struct WhiteShape {
    pub(crate) shape: Shape,
    /// One vector, or two for a law with a phase: then orthogonal when projected, the second of unit length.
    pub(crate) vectors: Vec<RowVector>,
    /// Square of the first vector when projected.
    pub(crate) square: f64,
    /// Largest change of a reading, m.
    pub(crate) peak_m: f64,
}

/// The best shape of a candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BestShape {
    /// Its place among the shapes.
    pub(crate) shape: usize,
    /// Its best amplitude; of the forbidden sign the best of all shapes.
    pub(crate) best: BestAmplitude,
}

/// Shapes that one thread takes at a time: a period has hundreds, a slip has one.
const SHAPES_AT_A_TIME: usize = 32;

/// Candidates that one thread takes at a time, so that none is left alone with those that cost most.
pub(crate) const CANDIDATES_AT_A_TIME: usize = 4;

/// Memory of one thread.
struct Scratch {
    /// The joint of the candidate at its turn, and the path there.
    joint: Option<Place>,
    path: Option<JointPath>,
    joint_rotations: JointRotations,
    change_m: [Vec<f64>; 2],
    products: Vec<f64>,
}

impl Scratch {
    fn new(readings: usize) -> Self {
        Self {
            joint: None,
            path: None,
            joint_rotations: JointRotations::default(),
            change_m: [vec![0.0; readings], vec![0.0; readings]],
            products: Vec::new(),
        }
    }

    /// Makes ready for candidates at a place.
    fn go_to(&mut self, changes: &Changes<'_>, place: &Place) {
        if place.joint().is_none() {
            self.path = None;
            self.joint = None;
        } else if self.joint.as_ref() != Some(place) {
            // Several laws at one joint follow each other.
            self.path = changes.path(place);
            self.joint = Some(place.clone());
        }
    }
}

/// Scores all shapes of candidates.
pub(crate) fn score_candidates(
    changes: &Changes<'_>,
    engine: &impl ScoreEngine,
    candidates: Vec<Candidate>,
) -> Vec<ScoredCandidate> {
    let score = |candidates: Vec<Candidate>| -> Vec<ScoredCandidate> {
        candidates
            .into_par_iter()
            .with_max_len(CANDIDATES_AT_A_TIME)
            .map_init(
                || Scratch::new(changes.readings()),
                |scratch, candidate| {
                    let score = |shape: &Shape, scratch: &mut Scratch| {
                        scored_shape(changes, engine, &candidate, shape, scratch)
                    };
                    let shapes = &candidate.shapes;
                    ScoredCandidate {
                        shapes: each_shape(changes, &candidate.place, shapes, score, scratch),
                        candidate,
                    }
                },
            )
            .collect()
    };
    // A joint that could not be seen if it turned freely cannot be seen under any law: none turns it further.
    let (compliances, rest): (Vec<Candidate>, Vec<Candidate>) = candidates
        .into_iter()
        .partition(|candidate| candidate.law.search.is_freest);
    let mut out = score(compliances);
    let unseen: Vec<Place> = out
        .iter()
        .filter(|scored| !scored.is_observable())
        .map(|scored| scored.candidate.place.clone())
        .collect();
    let rest = rest
        .into_iter()
        .filter(|candidate| !unseen.contains(&candidate.place))
        .collect();
    out.extend(score(rest));
    out
}

/// What there is of each shape at a place, in order.
fn each_shape<S: Sync, T: Send>(
    changes: &Changes<'_>,
    place: &Place,
    shapes: &[S],
    work: impl Fn(&S, &mut Scratch) -> Option<T> + Sync,
    scratch: &mut Scratch,
) -> Vec<T> {
    let work_on = |shapes: &[S], scratch: &mut Scratch| -> Vec<T> {
        scratch.go_to(changes, place);
        let found = shapes.iter().map(|shape| work(shape, scratch));
        found.flatten().collect()
    };
    if shapes.len() <= SHAPES_AT_A_TIME {
        return work_on(shapes, scratch);
    }
    let parts = shapes.par_chunks(SHAPES_AT_A_TIME).with_max_len(1);
    let found = parts.map_init(
        || Scratch::new(changes.readings()),
        |scratch, shapes| work_on(shapes, scratch),
    );
    found.flatten_iter().collect()
}

/// Which changes of readings a shape has left in [`Scratch`].
enum ShapeChange {
    /// Those of its effect, in the first vector; outside these readings it changes nothing, and the vector is not to be read.
    Part(Range<usize>),
    /// Those of its effect in the first vector, and of the same a quarter of a turn further in the second.
    BothPhases,
}

/// Computes what a shape changes; `None` where it cannot be computed.
fn change_of(
    changes: &Changes<'_>,
    candidate: &Candidate,
    shape: &Shape,
    scratch: &mut Scratch,
) -> Option<ShapeChange> {
    let effect = effect_of(candidate, shape);
    let [first, second] = &mut scratch.change_m;
    let joint_rotations = &mut scratch.joint_rotations;
    if let Some(phase) = candidate.law.search.phase {
        changes.of_both_phases(&effect, phase, joint_rotations, [first, second])?;
        return Some(ShapeChange::BothPhases);
    }
    let path = scratch.path.as_ref();
    let range = changes.of(&effect, path, joint_rotations, first)?;
    Some(ShapeChange::Part(range))
}

fn scored_shape(
    changes: &Changes<'_>,
    engine: &impl ScoreEngine,
    candidate: &Candidate,
    shape: &Shape,
    scratch: &mut Scratch,
) -> Option<ScoredShape> {
    let change = change_of(changes, candidate, shape, scratch)?;
    let [first, second] = &scratch.change_m;
    let (moments, quarter, peak_m) = match change {
        ShapeChange::BothPhases => {
            let pair =
                engine.pair_moments([first, second], &(0..first.len()), &mut scratch.products);
            let peak_m = peak(first).max(peak(second));
            (pair.first, Some(pair.second), peak_m)
        }
        ShapeChange::Part(range) => {
            let moments = engine.moments(first, &range, &mut scratch.products);
            (moments, None, peak(&first[range]))
        }
    };
    (moments.square > INVISIBLE * INVISIBLE).then(|| ScoredShape {
        shape: shape.clone(),
        moments,
        quarter,
        peak_m,
    })
}

/// Largest size.
fn peak(values: &[f64]) -> f64 {
    let most = |values: &[f64]| {
        let mut most = [0.0_f64; 8];
        for values in values.chunks(8) {
            for (most, value) in most.iter_mut().zip(values) {
                *most = most.max(value.abs());
            }
        }
        most.into_iter().fold(0.0, f64::max)
    };
    widest(|| most(values))
}

/// Makes the shapes of candidates white vectors, not projected.
pub(crate) fn white_candidates<'s>(
    changes: &Changes<'_>,
    space: &WhiteSpace,
    scored: impl IntoIterator<Item = &'s ScoredCandidate>,
) -> Vec<WhiteCandidate> {
    let mut scratch = Scratch::new(changes.readings());
    let white = |ScoredCandidate { candidate, shapes }: &ScoredCandidate| {
        scratch.go_to(changes, &candidate.place);
        let shapes = shapes.iter();
        WhiteCandidate {
            candidate: candidate.clone(),
            shapes: shapes
                .filter_map(|shape| white_shape(changes, space, candidate, shape, &mut scratch))
                .collect(),
        }
    };
    scored.into_iter().map(white).collect()
}

fn white_shape(
    changes: &Changes<'_>,
    space: &WhiteSpace,
    candidate: &Candidate,
    shape: &ScoredShape,
    scratch: &mut Scratch,
) -> Option<WhiteShape> {
    let change = change_of(changes, candidate, &shape.shape, scratch)?;
    let [first, second] = &scratch.change_m;
    let vectors = match change {
        ShapeChange::BothPhases => {
            let [first, mut second] = [first, second].map(|change_m| space.white(change_m));
            make_orthogonal(space, &first, &mut second);
            vec![RowVector::from(first), RowVector::from(second)]
        }
        ShapeChange::Part(range) => vec![space.white_part(first, &range)],
    };
    Some(WhiteShape {
        shape: shape.shape.clone(),
        square: shape.moments.square,
        vectors,
        peak_m: shape.peak_m,
    })
}

/// Makes the second of two white vectors orthogonal to the first and of unit length, as both are when projected.
fn make_orthogonal(space: &WhiteSpace, first: &[f64], second: &mut [f64]) {
    let [mut own, mut other] = [second.to_vec(), first.to_vec()];
    space.project(&mut own);
    space.project(&mut other);
    let share = dot(&own, &other) / dot(&other, &other);
    subtract(&mut own, share, &other);
    let length = dot(&own, &own).sqrt().max(f64::MIN_POSITIVE);
    for (value, first) in second.iter_mut().zip(first) {
        *value = (*value - share * first) / length;
    }
}

impl WhiteCandidate {
    /// The same with the baseline projected out of its vectors.
    pub(crate) fn projected(mut self, space: &WhiteSpace) -> Self {
        for vector in self.shapes.iter_mut().flat_map(|shape| &mut shape.vectors) {
            let mut whole = vector.whole(space.length);
            space.project(&mut whole);
            *vector = RowVector::from(whole);
        }
        self
    }
}

impl ScoredCandidate {
    /// Whether its largest possible effect is longer than [`HIDDEN_JOINT`].
    fn is_observable(&self) -> bool {
        self.shapes.iter().any(|shape| {
            let largest = shape.shape.scale[1];
            largest == f64::INFINITY
                || largest * largest * shape.moments.square > HIDDEN_JOINT * HIDDEN_JOINT
        })
    }

    /// A candidate whose vectors are known, projected, with its scores.
    pub(crate) fn of(white: &WhiteCandidate, residuals: &[f64]) -> Self {
        let moments = |vector: &RowVector| Moments {
            square: dot(&vector.values, &vector.values),
            product: vector.dot(residuals),
        };
        Self {
            candidate: white.candidate.clone(),
            shapes: white
                .shapes
                .iter()
                .map(|shape| ScoredShape {
                    shape: shape.shape.clone(),
                    moments: moments(&shape.vectors[0]),
                    quarter: shape.vectors.get(1).map(moments),
                    peak_m: shape.peak_m,
                })
                .collect(),
        }
    }
}

/// The effect of a shape.
pub(crate) fn effect_of(candidate: &Candidate, shape: &Shape) -> Effect {
    Effect {
        law: candidate.law,
        place: candidate.place.clone(),
        values: shape.values.clone(),
    }
}

impl ScoredShape {
    /// Its best amplitude; of a law with a phase that along the first of its two vectors.
    pub(crate) fn best(&self) -> BestAmplitude {
        match self.quarter {
            None => self.moments.best_within(self.shape.scale),
            Some(quarter) => BestAmplitude {
                multiple: self.moments.product / self.moments.square,
                delta_chi2: self.moments.delta_chi2() + quarter.delta_chi2(),
                forbidden_delta_chi2: 0.0,
            },
        }
    }

    /// The effect at a size, with its phase from the residuals where it has one.
    pub(crate) fn effect(&self, candidate: &Candidate, scale: f64) -> Effect {
        let mut effect = effect_of(candidate, &self.shape);
        if let (Some(quarter), Some(phase)) = (self.quarter, candidate.law.search.phase) {
            let s = self.moments.product / self.moments.square;
            let c = quarter.product / quarter.square.max(f64::MIN_POSITIVE);
            effect.values[0] *= s.hypot(c);
            effect.values[phase] = c.atan2(s);
            return effect;
        }
        let factor = self.shape.size_factor(scale);
        let sized = |index: usize| index == 0 || candidate.law.parameters[index].is_ratio();
        for (index, value) in effect.values.iter_mut().enumerate() {
            if sized(index) {
                *value *= factor;
            }
        }
        effect
    }
}

/// The best shape of each candidate; `None` for one that cannot be seen.
pub(crate) fn best_shapes(candidates: &[ScoredCandidate]) -> Vec<Option<BestShape>> {
    let best_shape = |candidate: &ScoredCandidate| {
        let mut found: Option<BestShape> = None;
        let mut forbidden = 0.0_f64;
        for (shape, scored) in candidate.shapes.iter().enumerate() {
            let best = scored.best();
            forbidden = forbidden.max(best.forbidden_delta_chi2);
            if found.is_none_or(|found| best.delta_chi2 > found.best.delta_chi2) {
                found = Some(BestShape { shape, best });
            }
        }
        let mut found = found?;
        found.best.forbidden_delta_chi2 = forbidden;
        Some(found)
    };
    candidates.iter().map(best_shape).collect()
}

#[cfg(test)]
mod tests;
