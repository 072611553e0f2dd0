//! What a search could find and name at best: the noise is known, every effect is one of the shapes that are searched, fits are linear.
//!
//! Then gains are products of white numbers with vectors, and thousands of sessions take a second. CriticalValues and rules are those of the search.
//! What a real search finds less, it loses to noise that the readings have to tell, to shapes between those that are searched and to fits;
//! what is missed here is missed for want of readings.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use stiffbench_beams::physics::{Law, Place};

use super::baseline::Baseline;
use super::candidate_scores::WhiteCandidate;
use super::critical_values::LawCriticalValues;
use super::error::MismatchError;
use super::observations::Observations;
use super::problem::DiagnosisProblem;
use super::search::SearchOptions;
use crate::search::WhiteSpace;
use crate::search::constants::{ABSORBED, STRONG_EVIDENCE};
use crate::search::{distinguishable, log_bayes, norm};

/// Sessions that share their products.
const TOGETHER: usize = 64;

/// All that is searched on one bench, ready for sessions whose noise is known.
#[derive(Debug)]
pub struct IdealSearch {
    candidates: Vec<Searched>,
    /// White vectors of unit length, what the fit absorbs taken out, one after the other.
    vectors: Vec<f32>,
    length: usize,
}

/// A session as it is found by an observer with known noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IdealSession {
    /// A law passes its limit.
    pub found: bool,
    /// The true law and place are in the set that is named.
    pub named: bool,
    /// How far the likeliest law and place are from the truth, standard errors; 0 if they are the truth.
    pub likeliest_apart: f64,
    /// The same of the farthest in the set.
    pub farthest_apart: f64,
}

/// A law at a place.
#[derive(Debug)]
struct Searched {
    law: Law,
    place: Place,
    wide: bool,
    /// Values that a fit of it has.
    values: usize,
    limit: f64,
    shapes: Vec<UnitShape>,
}

/// A shape of unit length, and how long it may be.
#[derive(Debug, Clone, Copy)]
struct UnitShape {
    /// Number of its first vector.
    vector: usize,
    /// One vector, or two with a phase between them.
    vectors: usize,
    /// Smallest and largest length, standard errors.
    sizes: [f64; 2],
}

/// The best shape of a candidate in one session.
#[derive(Debug, Clone, Copy)]
struct Best {
    candidate: usize,
    shape: usize,
    delta_chi2: f64,
    log_bayes: f64,
}

impl IdealSearch {
    /// All that is searched on a bench.
    ///
    /// # Arguments
    /// - `observations`: readings with nothing missing, for where the gauge stands and for the noise.
    /// - `critical`: those of the bench.
    ///
    /// # Errors
    /// [`MismatchError`].
    pub fn new(
        baseline: &dyn Baseline,
        observations: &Observations,
        options: &SearchOptions,
        critical: &LawCriticalValues,
    ) -> Result<Self, MismatchError> {
        if observations.is_empty() {
            return Err(MismatchError::Empty);
        }
        let positions =
            DiagnosisProblem::new(baseline, observations).positions_at_start(options)?;
        let at_start = observations.with_positions(&positions);
        let bench = DiagnosisProblem::new(baseline, &at_start);
        let state = bench
            .alternate(bench.start(), options.noise)?
            .ok_or(MismatchError::Empty)?;
        let scores = bench.score_laws(&state, &options.without)?;
        let mut ideal = Self {
            candidates: Vec::new(),
            vectors: Vec::new(),
            length: scores.space.length,
        };
        for white in bench.white_shapes(&scores, &state)? {
            ideal.take_in(white, &scores.space, critical);
        }
        Ok(ideal)
    }

    fn take_in(&mut self, white: WhiteCandidate, space: &WhiteSpace, critical: &LawCriticalValues) {
        let mut shapes = Vec::new();
        for shape in white.shapes {
            let scale = shape.shape.scale;
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
            if lengths.iter().any(|length| *length < ABSORBED) {
                continue;
            }
            shapes.push(UnitShape {
                vector: self.vectors.len() / self.length,
                vectors: units.len(),
                sizes: scale.map(|scale| scale * lengths[0]),
            });
            let units = units.iter().flatten();
            self.vectors.extend(units.map(|value| *value as f32));
        }
        let candidate = white.candidate;
        if shapes.is_empty() {
            return;
        }
        self.candidates.push(Searched {
            limit: critical.laws.of(candidate.family()),
            values: candidate.law.parameters.len(),
            law: candidate.law,
            place: candidate.place,
            wide: candidate.wide,
            shapes,
        });
    }

    /// Sessions with one effect.
    ///
    /// # Arguments
    /// - `size`: of the effect, standard errors.
    ///
    /// # Returns
    /// One for each session; none where no shape of the law at the place can have the size.
    #[must_use]
    pub fn sessions(
        &self,
        (law, place): (Law, &Place),
        size: f64,
        count: usize,
        seed: u64,
    ) -> Vec<IdealSession> {
        let is_true =
            |searched: &Searched| searched.law == law && searched.place == *place && !searched.wide;
        let Some(truth) = self.candidates.iter().position(is_true) else {
            return Vec::new();
        };
        let possible = |shape: &&UnitShape| (shape.sizes[0]..=shape.sizes[1]).contains(&size);
        let shapes = self.candidates[truth].shapes.iter().filter(possible);
        let shapes: Vec<UnitShape> = shapes.copied().collect();
        if shapes.is_empty() {
            return Vec::new();
        }
        (0..count.div_ceil(TOGETHER))
            .into_par_iter()
            .flat_map_iter(|block| {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(block as u64);
                let sessions = TOGETHER.min(count - block * TOGETHER);
                self.block(truth, &shapes, size, sessions, &mut rng)
            })
            .collect()
    }

    /// Sessions that share their products.
    fn block(
        &self,
        truth: usize,
        shapes: &[UnitShape],
        size: f64,
        sessions: usize,
        rng: &mut ChaCha8Rng,
    ) -> Vec<IdealSession> {
        let mut effects = Vec::new();
        let mut readings: Vec<f32> = Vec::with_capacity(sessions * self.length);
        for _ in 0..sessions {
            let effect = self.null_vectors(shapes, rng);
            readings.extend(effect.iter().map(|share| {
                let noise: f32 = StandardNormal.sample(rng);
                noise + size as f32 * share
            }));
            effects.push(effect);
        }
        let along = self.along(&readings);
        let count = self.vectors.len() / self.length;
        let each = along.chunks(count).zip(&effects);
        each.map(|(along, effect)| self.evaluated(truth, effect, size, along))
            .collect()
    }

    /// One of some shapes, of unit length, as likely as any other; so are its sign, where it is free, and its phase.
    fn null_vectors(&self, shapes: &[UnitShape], rng: &mut ChaCha8Rng) -> Vec<f32> {
        let shape = shapes[rng.random_range(0..shapes.len())];
        let angle = match shape.vectors {
            1 if shape.sizes[0] < 0.0 && rng.random::<bool>() => std::f64::consts::PI,
            1 => 0.0,
            _ => std::f64::consts::TAU * rng.random::<f64>(),
        };
        let (sine, cosine) = angle.sin_cos();
        self.combined(shape, [cosine, sine])
    }

    /// A sum of the vectors of a shape.
    fn combined(&self, shape: UnitShape, factors: [f64; 2]) -> Vec<f32> {
        let mut out = vec![0.0; self.length];
        for (number, factor) in factors.iter().enumerate().take(shape.vectors) {
            let vector = self.vector(shape.vector + number);
            for (value, share) in out.iter_mut().zip(vector) {
                *value += *factor as f32 * share;
            }
        }
        out
    }

    fn vector(&self, number: usize) -> &[f32] {
        &self.vectors[number * self.length..][..self.length]
    }

    /// Products of all vectors with some readings, readings after readings.
    fn along(&self, readings: &[f32]) -> Vec<f32> {
        let count = self.vectors.len() / self.length;
        let sets = readings.len() / self.length;
        let mut along = vec![0.0; count * sets];
        let vectors = MatRef::from_column_major_slice(&self.vectors, self.length, count);
        matmul(
            MatMut::from_column_major_slice_mut(&mut along, count, sets),
            Accum::Replace,
            vectors.transpose(),
            MatRef::from_column_major_slice(readings, self.length, sets),
            1.0,
            Par::Seq,
        );
        along
    }

    /// What is found and named in one session.
    ///
    /// # Arguments
    /// - `along`: products of all vectors with its readings.
    fn evaluated(&self, truth: usize, effect: &[f32], size: f64, along: &[f32]) -> IdealSession {
        let mut all: Vec<Best> = (0..self.candidates.len())
            .filter_map(|candidate| self.best(candidate, along))
            .collect();
        all.sort_by(|a, b| b.log_bayes.total_cmp(&a.log_bayes));
        let found = all
            .iter()
            .any(|best| best.delta_chi2 > self.candidates[best.candidate].limit);
        let own = &self.candidates[truth];
        let apart = |best: &Best| {
            let other = &self.candidates[best.candidate];
            let at_place = other.place == own.place;
            // A richer law is as near as the simpler one that it contains.
            if at_place && (other.law == own.law || other.law.contains(own.law)) {
                return 0.0;
            }
            self.left_by(other, effect, size)
        };
        let members = self.members(&all, along);
        let is_truth = |best: &Best| {
            let member = &self.candidates[best.candidate];
            member.law == own.law && member.place == own.place
        };
        IdealSession {
            found,
            named: members.iter().any(is_truth),
            likeliest_apart: all.first().map_or(0.0, apart),
            farthest_apart: members.iter().map(apart).fold(0.0, f64::max),
        }
    }

    /// The best shape of a candidate.
    fn best(&self, candidate: usize, along: &[f32]) -> Option<Best> {
        let searched = &self.candidates[candidate];
        let delta_chi2s = searched.shapes.iter().map(|shape| shape.delta_chi2(along));
        let (shape, delta_chi2) = delta_chi2s.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Best {
            candidate,
            shape,
            delta_chi2,
            log_bayes: log_bayes(delta_chi2, searched.limit, searched.values),
        })
    }

    /// The likeliest, and what is named with it, by the rules of verdicts.
    fn members(&self, all: &[Best], along: &[f32]) -> Vec<Best> {
        let Some(winner) = all.first() else {
            return Vec::new();
        };
        let likeliest = &self.candidates[winner.candidate];
        let of_winner = self.direction(winner, along);
        let mut named: Vec<(&str, &Place)> = Vec::new();
        let mut out = Vec::new();
        for best in all {
            let searched = &self.candidates[best.candidate];
            let behind = winner.log_bayes - best.log_bayes;
            let is_simpler = behind < STRONG_EVIDENCE
                && likeliest.law.contains(searched.law)
                && likeliest.place == searched.place;
            let name = (searched.law.name, &searched.place);
            // No cosine brings in what is so far behind.
            if distinguishable(behind, 1.0) || named.contains(&name) {
                continue;
            }
            let cosine = product(&of_winner, &self.direction(best, along));
            if is_simpler || !distinguishable(behind, cosine * cosine) {
                named.push(name);
                out.push(*best);
            }
        }
        out
    }

    /// The effect of a best shape, of unit length.
    fn direction(&self, best: &Best, along: &[f32]) -> Vec<f32> {
        let shape = self.candidates[best.candidate].shapes[best.shape];
        let first = f64::from(along[shape.vector]);
        if shape.vectors == 1 {
            return self.combined(shape, [first.signum(), 0.0]);
        }
        let second = f64::from(along[shape.vector + 1]);
        let length = first.hypot(second).max(f64::MIN_POSITIVE);
        self.combined(shape, [first / length, second / length])
    }

    /// What the shape of a candidate that is most like an effect of a size leaves of it, standard errors.
    fn left_by(&self, searched: &Searched, effect: &[f32], size: f64) -> f64 {
        let delta_chi2 = |shape: &UnitShape| {
            let along = |number| size * product(self.vector(shape.vector + number), effect);
            shape.delta_chi2_along(along(0), || along(1))
        };
        let delta_chi2s = searched.shapes.iter().map(delta_chi2);
        // A loose member may make it worse.
        let most = delta_chi2s.fold(f64::NEG_INFINITY, f64::max);
        (size * size - most).max(0.0).sqrt()
    }
}

impl UnitShape {
    /// Fall of the weighted squares by its best possible length.
    fn delta_chi2(&self, along: &[f32]) -> f64 {
        let along = |number| f64::from(along[self.vector + number]);
        self.delta_chi2_along(along(0), || along(1))
    }

    /// The same from the products of the readings with its first vector and, where it has two, its second.
    fn delta_chi2_along(&self, first: f64, second: impl FnOnce() -> f64) -> f64 {
        if self.vectors > 1 {
            return first * first + second().powi(2);
        }
        let size = first.clamp(self.sizes[0], self.sizes[1]);
        size * (2.0 * first - size)
    }
}

/// Product of two vectors, summed in double precision.
fn product(a: &[f32], b: &[f32]) -> f64 {
    let products = a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b));
    products.sum()
}

#[cfg(test)]
mod tests;
