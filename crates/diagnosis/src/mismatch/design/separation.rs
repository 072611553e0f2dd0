//! How far apart effects lie in given readings, cell by cell, so that plans can be put together from cells.

use std::collections::BTreeSet;

use crate::mismatch::baselines::{prior_sd, start};
use crate::mismatch::candidates::candidates;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::EstimatedNoise;
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, Model};
use crate::search::{Information, Projected, subtract};
use stiffbench_beams::physics::{Effect, Place, SignConstraint};
use stiffbench_units_and_text::test_point::Direction;

use super::bench::DesignBench;

/// Courses of a law that are kept for each rival it may imitate (1): those nearest to it. By judgement (2d002a9).
const IMITATIONS: usize = 6;

/// What the readings of one cell say of factors and effects.
#[derive(Debug, Clone)]
pub(super) struct CellInformation {
    /// Place of the pose among those at hand.
    pub(super) pose: usize,
    pub(super) direction: Direction,
    pub(super) says: Information,
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
        let mut every = Self::plain(fitted);
        for place in 0..count {
            let effect = every.all[place].clone();
            // A period is searched for by its phase as well; its fitted course stands for it.
            let own = known.iter().filter(|candidate| {
                candidate.law == effect.law
                    && candidate.place == effect.place
                    && candidate.law.search.phase.is_none()
            });
            for shape in own.flat_map(|candidate| &candidate.shapes) {
                let values = shape.values.clone();
                every.add_course(
                    place,
                    Effect {
                        values,
                        ..effect.clone()
                    },
                );
            }
        }
        let projected = bench.projected(&every, &bench.cells(&every, done, false)?);
        // Courses that imitate nothing are left out.
        let mut nearest = Self::plain(every.all[..count].to_vec());
        for place in 0..count {
            let rivals = (0..count).filter(|rival| *rival != place);
            let kept: BTreeSet<usize> = rivals
                .flat_map(|rival| {
                    let mut order = every.courses[place][1..].to_vec();
                    let cosine = |course: usize| projected.cosine(course, rival).abs();
                    order.sort_by(|a, b| cosine(*b).total_cmp(&cosine(*a)));
                    order.into_iter().take(IMITATIONS)
                })
                .collect();
            for course in kept {
                nearest.add_course(place, every.all[course].clone());
            }
        }
        Ok(nearest)
    }

    fn add_course(&mut self, place: usize, course: Effect) {
        self.courses[place].push(self.all.len());
        self.all.push(course);
    }

    /// Expected log-likelihood ratio between two fitted effects, whichever is true; the smaller counts.
    pub(super) fn log_lr(&self, projected: &Projected, [a, b]: [usize; 2]) -> f64 {
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

    /// What each cell of readings says of factors and effects.
    ///
    /// # Arguments
    /// - `planned`: whether the readings are yet to be made; what happened in one run does not happen again.
    pub(super) fn cells(
        &self,
        effects: &Effects,
        observations: &Observations,
        planned: bool,
    ) -> Result<Vec<CellInformation>, MismatchError> {
        let bench = self.bench(observations);
        let model = self.model();
        let whitening = bench.whitening(&model, &EstimatedNoise::known(self.noise))?;
        let mut columns = bench.columns(&model)?;
        let mut predictor = bench.predictor();
        let linearised = predictor.linearised(&model.parameters, &[])?;
        predictor.hold_joints(Some(&linearised));
        let mut without = vec![0.0; observations.len()];
        predictor.predict(&model.parameters, &[], &mut without)?;
        for effect in &effects.all {
            let mut with = without.clone();
            if !(planned && matches!(effect.place, Place::Run { .. })) {
                // A joint that is not there changes nothing.
                let acting = std::slice::from_ref(effect);
                predictor.predict(&model.parameters, acting, &mut with)?;
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
                CellInformation {
                    pose: cell.pose,
                    direction: cell.axis(),
                    says: Information::of_columns(&parts),
                }
            })
            .collect())
    }

    /// What cells together leave of effects beside the factors and what is known of these beforehand.
    pub(super) fn projected<'g>(
        &self,
        effects: &Effects,
        cells: impl IntoIterator<Item = &'g CellInformation>,
    ) -> Projected {
        let prior_sd = prior_sd(self.baseline);
        let known = Information::of_prior(&prior_sd, effects.all.len());
        let cells = cells.into_iter();
        let known = cells.fold(known, |known, cell| known.with(&cell.says));
        known.projected(prior_sd.len())
    }
}
