//! Every shape of every candidate against the residuals, with the fit's freedom projected out: linear, exact in the shape, in parallel.

use rayon::prelude::*;

use stiffbench_beams::physics::{Effect, JointPath, Place, Shape, Twists};
use stiffbench_numeric::lanes::widest;

use super::candidate::Candidate;
use super::changes::Changes;
use super::products::{Measured, Products};
use super::space::{Space, dot};

/// A candidate with its shapes ready: those that can be seen at all.
#[derive(Debug, Clone)]
pub(super) struct Shaped<S> {
    pub(super) candidate: Candidate,
    pub(super) shapes: Vec<S>,
}

/// A candidate whose shapes were compared with the residuals.
pub(super) type SeenCandidate = Shaped<SeenShape>;

/// A candidate with its shapes as white vectors.
pub(super) type WhiteCandidate = Shaped<WhiteShape>;

/// A shape as the residuals see it.
#[derive(Debug, Clone)]
pub(super) struct SeenShape {
    pub(super) shape: Shape,
    /// Its white square, and its product with the residuals.
    pub(super) seen: Measured,
    /// The same of a law's quarter turn of phase, made orthogonal to the first.
    pub(super) quarter: Option<Measured>,
    /// Largest change of a reading, m.
    pub(super) peak_m: f64,
}

/// A shape as a white vector.
#[derive(Debug, Clone)]
pub(super) struct WhiteShape {
    pub(super) shape: Shape,
    /// One vector, or two for a law with a phase: then orthogonal when projected, the second of unit length.
    pub(super) vectors: Vec<Vec<f64>>,
    /// Square of the first vector when projected.
    pub(super) square: f64,
    /// Largest change of a reading, m.
    pub(super) peak_m: f64,
}

/// What the screen says of a candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Screened {
    /// Place of the best shape.
    pub(super) shape: usize,
    /// Its size, as a multiple of the shape's.
    pub(super) scale: f64,
    /// Drop of the weighted squares.
    pub(super) gain: f64,
    /// The drop that the impossible sign would give, if the law has one.
    pub(super) impossible_gain: f64,
}

/// An effect this many standard errors long at its largest possible size cannot be seen.
const INVISIBLE: f64 = 1e-3;

/// Shapes that one thread takes at a time: a period has hundreds, a slip has one.
const SHAPES_AT_A_TIME: usize = 32;

/// Candidates that one thread takes at a time, so that none is left alone with those that cost most.
const CANDIDATES_AT_A_TIME: usize = 4;

/// Memory of one thread.
struct Scratch {
    /// The joint of the candidate at its turn, and the path there.
    joint: Option<Place>,
    path: Option<JointPath>,
    twists: Twists,
    change_m: [Vec<f64>; 2],
    products: Vec<f64>,
}

impl Scratch {
    fn new(readings: usize) -> Self {
        Self {
            joint: None,
            path: None,
            twists: Twists::default(),
            change_m: [vec![0.0; readings], vec![0.0; readings]],
            products: Vec::new(),
        }
    }
}

/// Compares all shapes with the residuals.
pub(super) fn seen_candidates(
    changes: &Changes<'_>,
    products: &Products<'_>,
    candidates: Vec<Candidate>,
) -> Vec<SeenCandidate> {
    let look = |candidates: Vec<Candidate>| -> Vec<SeenCandidate> {
        candidates
            .into_par_iter()
            .with_max_len(CANDIDATES_AT_A_TIME)
            .map_init(
                || Scratch::new(changes.readings()),
                |scratch, candidate| {
                    let look = |shape: &Shape, scratch: &mut Scratch| {
                        seen_shape(changes, products, &candidate, shape, scratch)
                    };
                    let shapes = &candidate.shapes;
                    SeenCandidate {
                        shapes: each_shape(changes, &candidate.place, shapes, look, scratch),
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
    let mut out = look(compliances);
    let unseen: Vec<Place> = out
        .iter()
        .filter(|seen| !seen.can_be_seen())
        .map(|seen| seen.candidate.place.clone())
        .collect();
    let rest = rest
        .into_iter()
        .filter(|candidate| !unseen.contains(&candidate.place))
        .collect();
    out.extend(look(rest));
    out
}

/// What there is of each shape at a place, in order.
fn each_shape<S: Sync, T: Send>(
    changes: &Changes<'_>,
    place: &Place,
    shapes: &[S],
    look: impl Fn(&S, &mut Scratch) -> Option<T> + Sync,
    scratch: &mut Scratch,
) -> Vec<T> {
    let look_at = |shapes: &[S], scratch: &mut Scratch| -> Vec<T> {
        if !matches!(place, Place::Joint(_)) {
            scratch.path = None;
            scratch.joint = None;
        } else if scratch.joint.as_ref() != Some(place) {
            // Several laws at one joint follow each other.
            scratch.path = changes.path(place);
            scratch.joint = Some(place.clone());
        }
        let found = shapes.iter().map(|shape| look(shape, scratch));
        found.flatten().collect()
    };
    if shapes.len() <= SHAPES_AT_A_TIME {
        return look_at(shapes, scratch);
    }
    let parts = shapes.par_chunks(SHAPES_AT_A_TIME).with_max_len(1);
    let found = parts.map_init(
        || Scratch::new(changes.readings()),
        |scratch, shapes| look_at(shapes, scratch),
    );
    found.flatten_iter().collect()
}

fn seen_shape(
    changes: &Changes<'_>,
    products: &Products<'_>,
    candidate: &Candidate,
    shape: &Shape,
    scratch: &mut Scratch,
) -> Option<SeenShape> {
    let effect = effect_of(candidate, shape);
    let [first, second] = &mut scratch.change_m;
    let (seen, quarter, peak_m) = if let Some(phase) = candidate.law.search.phase {
        changes.of_both_phases(&effect, phase, &mut scratch.twists, [first, second])?;
        let pair = products.measure_pair([&*first, &*second], &mut scratch.products);
        let peak_m = peak(first).max(peak(second));
        (pair.first, Some(pair.second), peak_m)
    } else {
        let path = scratch.path.as_ref();
        let range = changes.of(&effect, path, &mut scratch.twists, first)?;
        let seen = products.measure(first, &range, &mut scratch.products);
        (seen, None, peak(&first[range]))
    };
    (seen.square > INVISIBLE * INVISIBLE).then(|| SeenShape {
        shape: shape.clone(),
        seen,
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
pub(super) fn white_candidates<'s>(
    changes: &Changes<'_>,
    space: &Space,
    seen: impl IntoParallelIterator<Item = &'s SeenCandidate, Iter: IndexedParallelIterator>,
) -> Vec<WhiteCandidate> {
    seen.into_par_iter()
        .with_max_len(CANDIDATES_AT_A_TIME)
        .map_init(
            || Scratch::new(changes.readings()),
            |scratch, SeenCandidate { candidate, shapes }| {
                let look = |shape: &SeenShape, scratch: &mut Scratch| {
                    white_shape(changes, space, candidate, shape, scratch)
                };
                WhiteCandidate {
                    candidate: candidate.clone(),
                    shapes: each_shape(changes, &candidate.place, shapes, look, scratch),
                }
            },
        )
        .collect()
}

fn white_shape(
    changes: &Changes<'_>,
    space: &Space,
    candidate: &Candidate,
    shape: &SeenShape,
    scratch: &mut Scratch,
) -> Option<WhiteShape> {
    let effect = effect_of(candidate, &shape.shape);
    let [first, second] = &mut scratch.change_m;
    let vectors = if let Some(phase) = candidate.law.search.phase {
        changes.of_both_phases(&effect, phase, &mut scratch.twists, [first, second])?;
        let [first, mut second] = [&*first, &*second].map(|change_m| space.white(change_m));
        make_orthogonal(space, &first, &mut second);
        vec![first, second]
    } else {
        let path = scratch.path.as_ref();
        let range = changes.of(&effect, path, &mut scratch.twists, first)?;
        vec![space.white_part(first, &range)]
    };
    Some(WhiteShape {
        shape: shape.shape.clone(),
        square: shape.seen.square,
        vectors,
        peak_m: shape.peak_m,
    })
}

/// Makes the second of two white vectors orthogonal to the first and of unit length, as both are when projected.
fn make_orthogonal(space: &Space, first: &[f64], second: &mut [f64]) {
    let [mut own, mut other] = [second.to_vec(), first.to_vec()];
    space.project(&mut own);
    space.project(&mut other);
    let share = dot(&own, &other) / dot(&other, &other);
    for (value, other) in own.iter_mut().zip(&other) {
        *value -= share * other;
    }
    let length = dot(&own, &own).sqrt().max(f64::MIN_POSITIVE);
    for (value, first) in second.iter_mut().zip(first) {
        *value = (*value - share * first) / length;
    }
}

impl WhiteCandidate {
    /// Its vectors.
    pub(super) fn vectors_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        self.shapes.iter_mut().flat_map(|shape| &mut shape.vectors)
    }
}

impl SeenCandidate {
    /// Whether its largest possible effect is longer than two standard errors.
    fn can_be_seen(&self) -> bool {
        self.shapes.iter().any(|shape| {
            let largest = shape.shape.scale[1];
            largest == f64::INFINITY || largest * largest * shape.seen.square > 4.0
        })
    }

    /// A candidate whose vectors are known, compared with residuals.
    pub(super) fn of(white: &WhiteCandidate, residuals: &[f64]) -> Self {
        let measured = |vector: &Vec<f64>| Measured {
            square: dot(vector, vector),
            product: dot(vector, residuals),
        };
        Self {
            candidate: white.candidate.clone(),
            shapes: white
                .shapes
                .iter()
                .map(|shape| SeenShape {
                    shape: shape.shape.clone(),
                    seen: measured(&shape.vectors[0]),
                    quarter: shape.vectors.get(1).map(measured),
                    peak_m: shape.peak_m,
                })
                .collect(),
        }
    }
}

/// The effect of a shape.
pub(super) fn effect_of(candidate: &Candidate, shape: &Shape) -> Effect {
    Effect {
        law: candidate.law,
        place: candidate.place.clone(),
        values: shape.values.clone(),
    }
}

impl SeenShape {
    /// Best size and the drop of the squares; and the drop of the impossible sign.
    pub(super) fn gain(&self) -> (f64, f64, f64) {
        let Measured { square, product } = self.seen;
        if let Some(quarter) = self.quarter {
            let first = product * product / square;
            let other = quarter.product.powi(2) / quarter.square.max(f64::MIN_POSITIVE);
            return (product / square, first + other, 0.0);
        }
        let [lowest, highest] = self.shape.scale;
        let free = product / square;
        let scale = free.clamp(lowest, highest);
        let gain = scale * (2.0 * product - scale * square);
        let impossible = if lowest >= 0.0 && free < 0.0 {
            product * product / square
        } else {
            0.0
        };
        (scale, gain, impossible)
    }

    /// The effect at a size, with its phase from the residuals where it has one.
    pub(super) fn effect(&self, candidate: &Candidate, scale: f64) -> Effect {
        let mut effect = effect_of(candidate, &self.shape);
        if let (Some(quarter), Some(phase)) = (self.quarter, candidate.law.search.phase) {
            let s = self.seen.product / self.seen.square;
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
pub(super) fn screen(candidates: &[SeenCandidate]) -> Vec<Option<Screened>> {
    candidates
        .iter()
        .map(|candidate| {
            let mut best: Option<Screened> = None;
            let mut impossible_gain = 0.0_f64;
            for (place, shape) in candidate.shapes.iter().enumerate() {
                let (scale, gain, impossible) = shape.gain();
                impossible_gain = impossible_gain.max(impossible);
                if best.is_none_or(|best| gain > best.gain) {
                    best = Some(Screened {
                        shape: place,
                        scale,
                        gain,
                        impossible_gain: 0.0,
                    });
                }
            }
            best.map(|best| Screened {
                impossible_gain,
                ..best
            })
        })
        .collect()
}
