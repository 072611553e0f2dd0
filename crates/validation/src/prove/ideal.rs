//! What a search could find and name at best: the noise is known, every effect is one of the shapes that are searched, fits are linear.
//!
//! This is no search of one session but the error rates of the first step of one, over thousands of simulated sessions: every white vector is known
//! beforehand, so that a session costs its products with all of them, 64 sessions at a time. Scores, evidence, critical values and the rule for
//! what is distinguishable are those of the search; the sessions, and how far a rival is from the truth, are what is computed here. What a real
//! search finds less, it loses to noise that the readings have to show, to shapes between those that are searched and to fits; what is missed
//! here is missed for want of readings.

use nalgebra::{DMatrix, DVectorView};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use stiffbench_beams::physics::{Law, Place};
use stiffbench_diagnosis::mismatch::{WhiteLaw, WhiteLawShape};
use stiffbench_diagnosis::search::{
    Moments, PairMoments, STRONG_EVIDENCE, distinguishable, dot, log_bayes,
};

/// Sessions that share their products.
const TOGETHER: usize = 64;

/// All that is searched on one bench, ready for sessions whose noise is known.
#[derive(Debug)]
pub(super) struct IdealSearch {
    candidates: Vec<WhiteLaw>,
    /// For each candidate and shape the number of its first vector.
    first: Vec<Vec<usize>>,
    /// The vectors of all shapes, a row each.
    vectors: DMatrix<f64>,
}

/// A session as it is found by an observer with known noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct IdealSession {
    /// A law exceeds its critical value.
    pub(super) found: bool,
    /// The true law and place are in the set that is named.
    pub(super) named: bool,
    /// How far the likeliest law and place are from the truth, standard errors; 0 if they are the truth.
    pub(super) likeliest_apart: f64,
    /// The same of the farthest in the set.
    pub(super) farthest_apart: f64,
}

/// The best shape of a candidate in one session.
#[derive(Debug, Clone, Copy)]
struct Best<'a> {
    candidate: &'a WhiteLaw,
    shape: &'a WhiteLawShape,
    /// Products of its first and last vector with the readings.
    along: [f64; 2],
    delta_chi2: f64,
    log_bayes: f64,
}

impl IdealSearch {
    /// Makes the shapes of laws ready.
    ///
    /// # Arguments
    /// - `candidates`: all that is searched on a bench; vectors of one length.
    pub(super) fn new(candidates: Vec<WhiteLaw>) -> Self {
        let mut count = 0;
        let mut number = |shape: &WhiteLawShape| {
            let first = count;
            count += shape.units.len();
            first
        };
        let numbers = |law: &WhiteLaw| law.shapes.iter().map(&mut number).collect();
        let first = candidates.iter().map(numbers).collect();
        let shapes = candidates.iter().flat_map(|law| &law.shapes);
        let units: Vec<&Vec<f64>> = shapes.flat_map(|shape| &shape.units).collect();
        let length = units.first().map_or(0, |unit| unit.len());
        Self {
            vectors: DMatrix::from_fn(units.len(), length, |row, column| units[row][column]),
            first,
            candidates,
        }
    }

    /// Sessions with one effect.
    ///
    /// # Arguments
    /// - `size`: of the effect, standard errors.
    ///
    /// # Returns
    /// One for each session; none where no shape of the law at the place can have the size.
    pub(super) fn sessions(
        &self,
        (law, place): (Law, &Place),
        size: f64,
        count: usize,
        seed: u64,
    ) -> Vec<IdealSession> {
        let is_true = |known: &WhiteLaw| known.law == law && known.place == *place && !known.wide;
        let Some(truth) = self.candidates.iter().position(is_true) else {
            return Vec::new();
        };
        let possible = |shape: &&WhiteLawShape| (shape.sizes[0]..=shape.sizes[1]).contains(&size);
        let shapes = self.candidates[truth].shapes.iter().filter(possible);
        let shapes: Vec<&WhiteLawShape> = shapes.collect();
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
        shapes: &[&WhiteLawShape],
        size: f64,
        sessions: usize,
        rng: &mut ChaCha8Rng,
    ) -> Vec<IdealSession> {
        let mut readings = DMatrix::zeros(self.vectors.ncols(), sessions);
        let mut effects = Vec::new();
        for mut of_session in readings.column_iter_mut() {
            let effect = drawn_effect(shapes, rng);
            for (reading, share) in of_session.iter_mut().zip(&effect) {
                let noise: f64 = StandardNormal.sample(rng);
                *reading = noise + size * share;
            }
            effects.push(effect);
        }
        let products = &self.vectors * readings;
        let each = products.column_iter().zip(&effects);
        each.map(|(products, effect)| self.evaluated(truth, effect, size, &products))
            .collect()
    }

    /// What is found and named in one session.
    ///
    /// # Arguments
    /// - `products`: of all vectors with its readings.
    fn evaluated(
        &self,
        truth: usize,
        effect: &[f64],
        size: f64,
        products: &DVectorView<'_, f64>,
    ) -> IdealSession {
        let mut all: Vec<Best<'_>> = (0..self.candidates.len())
            .filter_map(|candidate| self.best(candidate, products))
            .collect();
        all.sort_by(|a, b| b.log_bayes.total_cmp(&a.log_bayes));
        let found = all
            .iter()
            .any(|best| best.delta_chi2 > best.candidate.critical_value);
        let own = &self.candidates[truth];
        let apart = |best: &Best<'_>| {
            let other = best.candidate;
            let at_place = other.place == own.place;
            // A richer law is as near as the simpler one that it contains.
            if at_place && (other.law == own.law || other.law.contains(own.law)) {
                return 0.0;
            }
            left_by(other, effect, size)
        };
        let members = members(&all);
        let is_truth =
            |best: &&Best<'_>| best.candidate.law == own.law && best.candidate.place == own.place;
        IdealSession {
            found,
            named: members.iter().any(is_truth),
            likeliest_apart: all.first().map_or(0.0, apart),
            farthest_apart: members.iter().map(|best| apart(best)).fold(0.0, f64::max),
        }
    }

    /// The best shape of a candidate.
    fn best(&self, candidate: usize, products: &DVectorView<'_, f64>) -> Option<Best<'_>> {
        let law = &self.candidates[candidate];
        let along = |shape: usize, unit: usize| products[self.first[candidate][shape] + unit];
        let delta_chi2s = law.shapes.iter().enumerate();
        let delta_chi2s = delta_chi2s
            .map(|(number, shape)| (number, delta_chi2(shape, |unit| along(number, unit))));
        let (number, delta_chi2) = delta_chi2s.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let shape = &law.shapes[number];
        Some(Best {
            candidate: law,
            shape,
            along: [along(number, 0), along(number, shape.units.len() - 1)],
            delta_chi2,
            log_bayes: log_bayes(delta_chi2, law.critical_value, law.law.parameters.len()),
        })
    }
}

/// Fall of the weighted squares by the best possible length of a shape.
///
/// # Arguments
/// - `along`: product of each of its vectors with the readings.
fn delta_chi2(shape: &WhiteLawShape, along: impl Fn(usize) -> f64) -> f64 {
    let unit = |number| Moments {
        square: 1.0,
        product: along(number),
    };
    if shape.units.len() > 1 {
        let [first, second] = [unit(0), unit(1)];
        return PairMoments { first, second }.delta_chi2();
    }
    unit(0).best_within(shape.sizes).delta_chi2
}

/// One of some shapes, of unit length, as likely as any other; so are its sign, where it is free, and its phase.
fn drawn_effect(shapes: &[&WhiteLawShape], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let shape = shapes[rng.random_range(0..shapes.len())];
    let angle = match shape.units.len() {
        1 if shape.sizes[0] < 0.0 && rng.random::<bool>() => std::f64::consts::PI,
        1 => 0.0,
        _ => std::f64::consts::TAU * rng.random::<f64>(),
    };
    let (sine, cosine) = angle.sin_cos();
    combined(shape, [cosine, sine])
}

/// A sum of the vectors of a shape.
fn combined(shape: &WhiteLawShape, factors: [f64; 2]) -> Vec<f64> {
    let mut out = vec![0.0; shape.units[0].len()];
    for (unit, factor) in shape.units.iter().zip(factors) {
        for (value, share) in out.iter_mut().zip(unit) {
            *value += factor * share;
        }
    }
    out
}

/// The likeliest, and what is named with it, by the rules of verdicts.
fn members<'a, 'b>(all: &'b [Best<'a>]) -> Vec<&'b Best<'a>> {
    let Some(winner) = all.first() else {
        return Vec::new();
    };
    let of_winner = winner.direction();
    let mut named: Vec<(&str, &Place)> = Vec::new();
    let mut out = Vec::new();
    for best in all {
        let behind = winner.log_bayes - best.log_bayes;
        let is_simpler = behind < STRONG_EVIDENCE
            && winner.candidate.law.contains(best.candidate.law)
            && winner.candidate.place == best.candidate.place;
        let name = (best.candidate.law.name, &best.candidate.place);
        // No cosine brings in what is so far behind.
        if distinguishable(behind, 1.0) || named.contains(&name) {
            continue;
        }
        let cosine = dot(&of_winner, &best.direction());
        if is_simpler || !distinguishable(behind, cosine * cosine) {
            named.push(name);
            out.push(best);
        }
    }
    out
}

impl Best<'_> {
    /// The effect, of unit length.
    fn direction(&self) -> Vec<f64> {
        let [first, second] = self.along;
        if self.shape.units.len() == 1 {
            return combined(self.shape, [first.signum(), 0.0]);
        }
        let length = first.hypot(second).max(f64::MIN_POSITIVE);
        combined(self.shape, [first / length, second / length])
    }
}

/// What the shape of a law that is most like an effect of a size leaves of it, standard errors.
fn left_by(law: &WhiteLaw, effect: &[f64], size: f64) -> f64 {
    let fall =
        |shape: &WhiteLawShape| delta_chi2(shape, |unit| size * dot(&shape.units[unit], effect));
    // A loose member may make it worse.
    let most = law
        .shapes
        .iter()
        .map(fall)
        .fold(f64::NEG_INFINITY, f64::max);
    (size * size - most).max(0.0).sqrt()
}

#[cfg(test)]
mod tests;
