//! How well a model predicts poses it was not fitted to.

use std::ops::Range;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_beams::physics::{Effect, Place};
use stiffbench_units_and_text::quantity::micro;
use stiffbench_units_and_text::test_point::PoseId;

use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::{Observations, ObservedCell};
use crate::mismatch::problem::{DiagnosisProblem, Model, State};
use crate::search::RowVector;

/// Share of an effect's squares in one pose above which the other poses do not determine it (1). By hand (cba106e).
const ONE_POSE: f64 = 0.5;

/// Most poses of which each is left out by itself.
const LEFT_OUT_ALONE: usize = 50;

/// Into how many folds more poses are divided: the effort grows with folds and poses alike.
const FOLDS: usize = 20;

/// How well a model serves in a pose that was left out of its fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeldOut {
    /// The pose.
    pub pose: PoseId,
    /// Root mean square of the residuals, m; in files µm.
    #[serde(
        rename = "rms_um",
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub rms_m: f64,
    /// The same with every reading as a multiple of its noise.
    pub noise_units: f64,
}

/// How well a model serves.
#[derive(Debug, Clone, PartialEq)]
pub struct Quality {
    /// Root mean square of the residuals, each gauge zero fitted, m.
    pub rms_m: f64,
    /// The same in poses that were left out of the fit; `None` with one pose.
    pub held_out_rms_m: Option<f64>,
    /// The same with every reading as a multiple of its noise: 1 is noise alone, however soft the direction; `None` with one pose.
    pub held_out_noise_units: Option<f64>,
    /// Each pose left out; none with one pose.
    pub held_out: Vec<HeldOut>,
    /// Weighted squares over degrees of freedom.
    pub reduced_chi2: f64,
}

/// Into how many folds poses are divided.
pub(crate) fn folds_of(poses: usize) -> usize {
    if poses > LEFT_OUT_ALONE { FOLDS } else { poses }
}

/// Readings to be left out together to ask whether an effect helps where it was not fitted: poses, or, of what is in one pose by its name,
/// the cells of that pose. `None` where one of them carries most: leaving it out asks nothing.
pub(crate) fn folds_that_ask(
    observations: &Observations,
    place: &Place,
    white: &[f64],
) -> Option<Vec<Vec<bool>>> {
    let squares =
        |cell: &ObservedCell| -> f64 { white[cell.readings.clone()].iter().map(|x| x * x).sum() };
    let cells = &observations.cells;
    let whole: f64 = cells.iter().map(squares).sum();
    let carries_most = |part: f64| part > ONE_POSE * whole || whole == 0.0;
    if cells.iter().any(|cell| carries_most(squares(cell))) {
        return None;
    }
    let of_pose = |pose: usize| cells.iter().filter(move |cell| cell.pose == pose);
    let mut poses = 0..observations.poses.len();
    let most = poses.find(|&pose| carries_most(of_pose(pose).map(squares).sum()));
    let is_of_a_pose = matches!(place, Place::JointAngle { pose: Some(_), .. });
    match most {
        Some(pose) if is_of_a_pose => Some(
            of_pose(pose)
                .map(|own| fold(observations, |cell| cell.readings == own.readings))
                .collect(),
        ),
        Some(_) => None,
        None => Some(folds_of_poses(observations)),
    }
}

/// Readings of each pose; of many poses of some together, each pose in the fold of its number.
fn folds_of_poses(observations: &Observations) -> Vec<Vec<bool>> {
    let count = folds_of(observations.poses.len());
    let of_number = |number| fold(observations, |cell| cell.pose % count == number);
    (0..count).map(of_number).collect()
}

/// Readings of the cells that pass.
fn fold(observations: &Observations, passes: impl Fn(&ObservedCell) -> bool) -> Vec<bool> {
    let mut fold = vec![false; observations.len()];
    for cell in observations.cells.iter().filter(|cell| passes(cell)) {
        fold[cell.readings.clone()].fill(true);
    }
    fold
}

/// Models fitted to some readings beside the others, all under the noise of one state.
#[derive(Clone, Copy)]
pub(crate) struct HoldOut<'p, 'a> {
    problem: &'p DiagnosisProblem<'a>,
    state: &'p State,
    /// Whose noise errors are multiples of.
    noise: &'p State,
}

impl<'p, 'a> HoldOut<'p, 'a> {
    pub(crate) fn new(problem: &'p DiagnosisProblem<'a>, state: &'p State) -> Self {
        Self {
            problem,
            state,
            noise: state,
        }
    }

    /// With errors as multiples of the noise of another state, so that two models are compared in one unit.
    pub(crate) fn in_noise_of(self, noise: &'p State) -> Self {
        Self { noise, ..self }
    }

    /// Residuals in sample and in poses left out one at a time, each gauge zero fitted.
    pub(crate) fn quality(&self) -> Result<Quality, MismatchError> {
        let (observations, fitted) = (self.problem.observations, &self.state.fitted);
        let model = &fitted.model;
        let residuals = self.problem.raw_residuals(model)?;
        let free: usize = model.parameters.len()
            + model
                .effects
                .iter()
                .map(Effect::fitted_values)
                .sum::<usize>();
        let poses = observations.poses.len();
        let folds = if poses > 1 {
            folds_of_poses(observations)
        } else {
            Vec::new()
        };
        let residuals_without: Vec<Vec<f64>> = folds
            .par_iter()
            .map(|held| self.residuals_of_kept(model, held))
            .collect::<Result<_, MismatchError>>()?;
        let of_pose = |pose: usize| {
            let own = fold(observations, |cell| cell.pose == pose);
            let residuals = &residuals_without[pose % folds.len()];
            let (rms_m, white) = self.shown(residuals, &own);
            let count = own.iter().filter(|held| **held).count() as f64;
            (rms_m, white, (white / count).sqrt())
        };
        let predicted = (0..poses).filter(|_| !folds.is_empty()).map(of_pose);
        let predicted: Vec<(f64, f64, f64)> = predicted.collect();
        let squares: f64 = predicted.iter().map(|(_, white, _)| white).sum();
        let names = observations.poses.iter();
        let held_out = names
            .zip(&predicted)
            .map(|(name, &(rms_m, _, noise_units))| HeldOut {
                pose: name.clone(),
                rms_m,
                noise_units,
            })
            .collect();
        let mean = predicted.iter().map(|(rms, ..)| rms * rms).sum::<f64>()
            / predicted.len().max(1) as f64;
        let all = vec![true; residuals.len()];
        let whole = if std::ptr::eq(self.noise, self.state) {
            fitted.squares
        } else {
            self.shown(&residuals, &all).1
        };
        Ok(Quality {
            rms_m: self.rms_about_zeros(&residuals, &all, 0..residuals.len()),
            held_out_rms_m: (poses > 1).then(|| mean.sqrt()),
            held_out_noise_units: (poses > 1).then(|| (squares / residuals.len() as f64).sqrt()),
            held_out,
            reduced_chi2: whole / (residuals.len().saturating_sub(free)).max(1) as f64,
        })
    }

    /// The same parts predicted by two models, each fitted without them: fall of the weighted squares.
    ///
    /// # Arguments
    /// - `folds`: for each part whether a reading belongs to it.
    pub(crate) fn fall(&self, simple: &Model, folds: &[Vec<bool>]) -> Result<f64, MismatchError> {
        let with = self.squares(&self.state.fitted.model, folds)?;
        Ok(self.squares(simple, folds)? - with)
    }

    /// Weighted squares of readings in parts that a model was not fitted to.
    ///
    /// # Arguments
    /// - `folds`: for each part whether a reading belongs to it.
    pub(crate) fn squares(&self, model: &Model, folds: &[Vec<bool>]) -> Result<f64, MismatchError> {
        let squares: Vec<f64> = folds
            .par_iter()
            .map(|held| {
                let residuals = self.residuals_of_kept(model, held)?;
                Ok(self.shown(&residuals, held).1)
            })
            .collect::<Result<_, MismatchError>>()?;
        // Summed in order, so that the number of threads does not show in the last digit.
        Ok(squares.iter().sum())
    }

    /// Root mean square, m, and weighted squares of some residuals.
    fn shown(&self, residuals: &[f64], held: &[bool]) -> (f64, f64) {
        let is_held = |held: &bool| *held;
        let first = held.iter().position(is_held).unwrap_or(0);
        let rows = first
            ..held
                .iter()
                .rposition(is_held)
                .map_or(first, |last| last + 1);
        let rms_m = self.rms_about_zeros(residuals, held, rows.clone());
        let covariance = &self.noise.whitening.covariance;
        if self.problem.observations.free_zeros {
            let weights = covariance.weights();
            let left = self.about_kept_zeros(residuals, held).into_iter();
            let squares = left.map(|(reading, residual)| (residual * weights[reading]).powi(2));
            return (rms_m, squares.sum());
        }
        let of_held = |row: usize| if held[row] { residuals[row] } else { 0.0 };
        let values = RowVector {
            first,
            values: rows.map(of_held).collect(),
        };
        let white = covariance.whiten_vector(&values);
        (rms_m, white.values.iter().map(|x| x * x).sum())
    }

    /// Readings that were left out minus a model that was fitted to the others, about their zeros, m.
    pub(crate) fn residuals_left_out(
        &self,
        model: &Model,
        held: &[bool],
    ) -> Result<Vec<f64>, MismatchError> {
        let residuals = self.residuals_of_kept(model, held)?;
        let left = self.about_kept_zeros(&residuals, held);
        Ok(left.into_iter().map(|(_, residual)| residual).collect())
    }

    /// All readings minus a model that was fitted to those that were not left out, m: these weigh nothing in the fit.
    fn residuals_of_kept(&self, model: &Model, held: &[bool]) -> Result<Vec<f64>, MismatchError> {
        let whitening = self.state.whitening.without(held);
        let refit = self.problem.refit(&whitening);
        let fitted = refit.fit(model);
        let fitted = fitted.as_ref().map_or(model, |fitted| &fitted.model);
        self.problem.raw_residuals(fitted)
    }

    /// Readings that were left out about their zeros: those of the readings that were kept, their own where none was.
    fn about_kept_zeros(&self, residuals: &[f64], held: &[bool]) -> Vec<(usize, f64)> {
        let observations = self.problem.observations;
        let count = observations.zero_count();
        let weights = self.state.whitening.covariance.weights();
        let mut kept = vec![(0.0, 0.0); count];
        let mut own = vec![(0.0, 0.0); count];
        let zero_of = |reading: usize| observations.readings[reading].zero as usize;
        for (reading, (residual, held)) in residuals.iter().zip(held).enumerate() {
            let sums = if *held { &mut own } else { &mut kept };
            let weight = weights[reading].powi(2);
            sums[zero_of(reading)].0 += weight * residual;
            sums[zero_of(reading)].1 += weight;
        }
        let mean = |(sum, weight): (f64, f64)| sum / weight;
        let left_out = held.iter().enumerate().filter(|(_, held)| **held);
        left_out
            .map(|(reading, _)| {
                let zero = zero_of(reading);
                let sums = if kept[zero].1 > 0.0 {
                    kept[zero]
                } else {
                    own[zero]
                };
                (reading, residuals[reading] - mean(sums))
            })
            .collect()
    }

    /// Root mean square of the readings in a range that count, about the mean of each gauge zero.
    fn rms_about_zeros(&self, residuals: &[f64], counted: &[bool], rows: Range<usize>) -> f64 {
        let observations = self.problem.observations;
        let mut sums = vec![(0.0, 0.0, 0.0); observations.zero_count()];
        let is_rotation = |run: usize| {
            let cell = observations.runs[run].cell;
            observations.cells[cell].read.is_rotation()
        };
        for row in rows {
            let (reading, residual) = (&observations.readings[row], residuals[row]);
            if counted[row] && !is_rotation(reading.run) {
                let sum = &mut sums[reading.zero as usize];
                sum.0 += 1.0;
                sum.1 += residual;
                sum.2 += residual * residual;
            }
        }
        // Of one load in each run nobody can tell the zero.
        let has_zeros = observations.has_series();
        let (mut readings, mut squares) = (0.0, 0.0);
        for (n, sum, square) in sums {
            if n > 0.0 {
                readings += n;
                squares += square - if has_zeros { sum * sum / n } else { 0.0 };
            }
        }
        (squares.max(0.0) / f64::max(readings, 1.0)).sqrt()
    }
}
