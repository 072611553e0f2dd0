//! How far apart effects lie in given readings, cell by cell, so that plans can be put together from cells.

use crate::mismatch::baseline::{prior_sd, start};
use crate::mismatch::candidate::candidates;
use crate::mismatch::changes::LinearisedModel;
use crate::mismatch::error::MismatchError;
use crate::mismatch::estimated_noise::EstimatedNoise;
use crate::mismatch::observations::Observations;
use crate::mismatch::problem::DiagnosisProblem;
use crate::mismatch::refit::Model;
use crate::search::constants::IMITATIONS;
use crate::search::subtract;
use stiffbench_beams::physics::{Effect, JointRotations, Place, SignConstraint};
use stiffbench_units_and_text::test_point::Direction;

use super::bench::DesignBench;
use super::gram::{Gram, Projected};

/// Products of one cell.
#[derive(Debug, Clone)]
pub(super) struct CellGram {
    /// Place of the pose among those at hand.
    pub(super) pose: usize,
    pub(super) direction: Direction,
    pub(super) gram: Gram,
}

/// Effects at their fitted values, and other courses of their laws that a rival could take.
pub(super) struct Effects {
    /// The fitted ones first.
    all: Vec<Effect>,
    /// For each fitted effect the places of those that stand for it as a rival, itself among them.
    courses: Vec<Vec<usize>>,
}

impl Effects {
    /// Effects whose laws have no other course.
    pub(super) fn plain(all: Vec<Effect>) -> Self {
        Self {
            courses: (0..all.len()).map(|place| vec![place]).collect(),
            all,
        }
    }

    /// Fitted effects with the courses of their laws that come nearest to each other in the readings already made.
    pub(super) fn new(
        bench: &DesignBench<'_>,
        done: &Observations,
        fitted: Vec<Effect>,
    ) -> Result<Self, MismatchError> {
        let linearised = bench
            .bench(done)
            .predictor()
            .linearised(&bench.model().parameters, &[])?;
        let known = candidates(done, &linearised, &[]);
        let count = fitted.len();
        let mut every = Self {
            all: fitted,
            courses: (0..count).map(|place| vec![place]).collect(),
        };
        for place in 0..count {
            let effect = every.all[place].clone();
            // A period is searched for by its phase as well; its fitted course stands for it.
            let own = known.iter().filter(|candidate| {
                candidate.law == effect.law
                    && candidate.place == effect.place
                    && candidate.law.search.phase.is_none()
            });
            for shape in own.flat_map(|candidate| &candidate.shapes) {
                every.courses[place].push(every.all.len());
                every.all.push(Effect {
                    values: shape.values.clone(),
                    ..effect.clone()
                });
            }
        }
        let projected = bench
            .whole(&every, &bench.cells(&every, done, false)?)
            .projected();
        Ok(every.nearest(&projected, count))
    }

    /// The same without courses that imitate nothing.
    fn nearest(&self, projected: &Projected, count: usize) -> Self {
        let mut all: Vec<Effect> = self.all[..count].to_vec();
        let mut courses: Vec<Vec<usize>> = (0..count).map(|place| vec![place]).collect();
        for place in 0..count {
            let mut kept: Vec<usize> = Vec::new();
            for rival in (0..count).filter(|rival| *rival != place) {
                let mut order = self.courses[place][1..].to_vec();
                let cosine = |course: usize| projected.cosine(course, rival).abs();
                order.sort_by(|a, b| cosine(*b).total_cmp(&cosine(*a)));
                kept.extend(order.into_iter().take(IMITATIONS));
            }
            kept.sort_unstable();
            kept.dedup();
            for course in kept {
                courses[place].push(all.len());
                all.push(self.all[course].clone());
            }
        }
        Self { all, courses }
    }

    /// Expected log-likelihood ratio between two fitted effects, whichever is true; the smaller counts.
    pub(super) fn log_lr(&self, projected: &Projected, a: usize, b: usize) -> f64 {
        let against = |truth: usize, rival: usize| {
            let parameters = self.all[rival].law.parameters;
            let any_sign = parameters
                .first()
                .is_some_and(|parameter| parameter.sign == SignConstraint::Either);
            self.courses[rival]
                .iter()
                .map(|&course| projected.expected_log_lr(truth, course, any_sign))
                .fold(f64::INFINITY, f64::min)
        };
        against(a, b).min(against(b, a))
    }
}

impl<'a> DesignBench<'a> {
    pub(super) fn bench<'b>(&self, observations: &'b Observations) -> DiagnosisProblem<'b>
    where
        'a: 'b,
    {
        DiagnosisProblem::new(self.baseline, observations)
    }

    /// The model without effects.
    pub(super) fn model(&self) -> Model {
        Model {
            parameters: self
                .parameters
                .map_or_else(|| start(self.baseline), <[f64]>::to_vec),
            effects: Vec::new(),
        }
    }

    /// Products of factors and effects in each cell of readings.
    ///
    /// # Arguments
    /// - `planned`: whether the readings are yet to be made; what happened in one run does not happen again.
    pub(super) fn cells(
        &self,
        effects: &Effects,
        observations: &Observations,
        planned: bool,
    ) -> Result<Vec<CellGram>, MismatchError> {
        let bench = self.bench(observations);
        let model = self.model();
        let mut predictor = bench.predictor();
        let whitening =
            bench.whitening(&mut predictor, &model, &EstimatedNoise::known(self.noise))?;
        let mut columns = bench.columns(&mut predictor, &model)?;
        let factors = columns.len();
        let linearised = predictor.linearised(&model.parameters, &[])?;
        let mut without = vec![0.0; observations.len()];
        predictor.predict(&model.parameters, &[], &mut without)?;
        for effect in &effects.all {
            let mut with = without.clone();
            if planned && matches!(effect.place, Place::Run { .. }) {
                // Stays as it is without.
            } else if effect.law.changes_structure() {
                let loose = std::slice::from_ref(effect);
                predictor.predict(&model.parameters, loose, &mut with)?;
            } else {
                predict(&linearised, observations, effect, &mut with);
            }
            subtract(&mut with, 1.0, &without);
            columns.push(with);
        }
        for column in &mut columns {
            whitening.covariance.whiten(column);
        }
        Ok(observations
            .cells
            .iter()
            .map(|cell| {
                let parts: Vec<Vec<f64>> = columns
                    .iter()
                    .map(|column| column[cell.readings.clone()].to_vec())
                    .collect();
                CellGram {
                    pose: cell.pose,
                    direction: cell.axis(),
                    gram: Gram::of_columns(factors, &parts),
                }
            })
            .collect())
    }

    /// Products of cells together, and of what is known of the factors beforehand.
    pub(super) fn whole<'g>(
        &self,
        effects: &Effects,
        cells: impl IntoIterator<Item = &'g CellGram>,
    ) -> Gram {
        let mut gram = Gram::of_prior(&prior_sd(self.baseline), effects.all.len());
        for cell in cells {
            gram.add(&cell.gram);
        }
        gram
    }
}

/// Displacements under an effect; a joint that is not there changes nothing.
fn predict(
    linearised: &LinearisedModel,
    observations: &Observations,
    effect: &Effect,
    out: &mut [f64],
) {
    let mut joint_rotations = JointRotations::default();
    let there = linearised.predict(observations, &[effect], &mut joint_rotations, out);
    if there.is_none() {
        let none = linearised.predict(observations, &[], &mut joint_rotations, out);
        debug_assert!(none.is_some());
    }
}
