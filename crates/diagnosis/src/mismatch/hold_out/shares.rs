//! How much of the misfit the findings explain, in the readings that were fitted and in others that were left out.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_beams::physics::TestObject;

use super::held_out::{HoldOut, folds_of};
use super::unseen_parts::unseen_parts;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::{KnownNoise, NoiseBasis};
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, Model, State};

/// Misfit that can be divided into shares, in standard deviations of what noise leaves (1). Stated.
const VISIBLE_MISFIT: f64 = 3.0;

/// Standard errors of an effect that must remain without a part of the readings, for that part to be predicted.
const DETERMINED: f64 = 2.0;

/// Shares of the misfit (1): beyond what noise leaves.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct MisfitShares {
    /// Of the readings that were fitted; `null` with a reason.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share_of_misfit: Option<f64>,
    /// Of readings that were left out of the fit; `null` with a reason.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share_unseen: Option<f64>,
    /// Why a share is `null`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_reason: Option<NoShareReason>,
}

/// Why there is no share of the misfit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum NoShareReason {
    /// Nobody knows how much of what the fit leaves is noise.
    #[serde(rename = "the scatter is estimated from the residuals of the fit")]
    ScatterOfTheFit,
    /// There is too little of it.
    #[serde(rename = "the misfit is too small to be apportioned")]
    SmallMisfit,
    /// Nothing can be left out.
    #[serde(rename = "no group of readings can be left out so that the others determine it")]
    NothingToLeaveOut,
    /// There is too little of it in what was left out.
    #[serde(rename = "the misfit of readings left out is too small to be apportioned")]
    SmallUnseenMisfit,
}

/// Shares of all findings together and of each place in the answer.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct AllShares {
    pub(crate) together: MisfitShares,
    pub(crate) each: Vec<MisfitShares>,
    pub(crate) steps: Option<MisfitSteps>,
}

/// The misfit divided in the order in which the search found effects, in shares of the misfit without them (1).
#[derive(Debug, Clone, PartialEq)]
pub struct MisfitSteps {
    /// What each place in the answer explains beyond those before it; those of a set count once.
    pub explained: Vec<f64>,
    /// What is left.
    pub left: f64,
    /// What noise alone leaves in any model, beside it.
    pub noise: f64,
}

/// Readings left out together.
type Fold = Vec<bool>;

/// The shares of what a search found: all models under the noise of the last.
///
/// # Arguments
/// - `before`, `after`: without and with all that was found.
/// - `found`: each found effect in the order of the model, white and projected.
pub(crate) fn misfit_shares(
    problem: &DiagnosisProblem<'_>,
    [before, after]: [&State; 2],
    found: &[&[f64]],
) -> Result<AllShares, MismatchError> {
    if found.is_empty() {
        return Ok(AllShares::default());
    }
    let under = KnownNoise::Given(after.noise);
    let fitted = |model: Model| problem.state_of(model, under);
    let start = fitted(before.fitted.model.clone())?;
    let last = fitted(after.fitted.model.clone())?;
    let without: Vec<State> = (0..found.len())
        .map(|place| {
            fitted(
                after
                    .fitted
                    .model
                    .without(problem.known_effects.len() + place),
            )
        })
        .collect::<Result<_, _>>()?;
    let readings = problem.observations.len() as f64;
    // Parameters have priors, which count as readings; values of effects have none.
    let dof = |state: &State| -> f64 {
        let effects = state.fitted.model.effects.iter();
        readings
            - effects
                .map(|effect| effect.fitted_values() as f64)
                .sum::<f64>()
    };
    // The noise is known to some percent only: where the last model leaves less, the others are measured by what it leaves.
    let unit = (last.fitted.squares / dof(&last)).min(1.0);
    let excess = |state: &State| (state.fitted.squares / unit - dof(state)).max(0.0);
    let mut levels = vec![excess(&start)];
    for count in 1..found.len() {
        let mut first = after.fitted.model.clone();
        first.effects.truncate(problem.known_effects.len() + count);
        levels.push(excess(&fitted(first)?));
    }
    levels.push(excess(&last));
    let seen = DividedSquares {
        whole: excess(&start),
        noise: 0.0,
        sd: (2.0 * dof(&start)).sqrt(),
        left: excess(&last),
        without: without.iter().map(excess).collect(),
    };
    // Of a scatter that is what the fit leaves nobody knows how much is noise: unseen errors are compared with none at all.
    let is_from_fit = after.noise.basis == NoiseBasis::Fit;
    let known = if is_from_fit { 0.0 } else { readings };
    let folds = folds(problem.observations, found);
    let unseen = if let Some(folds) = &folds {
        let hold_out = HoldOut::new(problem, after);
        let held = |state: &State| hold_out.squares(&state.fitted.model, folds);
        Some(DividedSquares {
            whole: held(&start)?,
            noise: unit * known,
            sd: (2.0 * known).sqrt(),
            left: held(&last)?,
            without: without.iter().map(held).collect::<Result<_, _>>()?,
        })
    } else {
        None
    };
    let reason = |seen: Option<f64>, share: Option<f64>| match (seen, share) {
        (Some(_), Some(_)) => None,
        (None, _) if is_from_fit => Some(NoShareReason::ScatterOfTheFit),
        (None, _) => Some(NoShareReason::SmallMisfit),
        (_, None) if folds.is_none() => Some(NoShareReason::NothingToLeaveOut),
        (_, None) => Some(NoShareReason::SmallUnseenMisfit),
    };
    let shares = |seen: Option<f64>, unseen: Option<f64>| {
        let seen = seen.filter(|_| !is_from_fit);
        MisfitShares {
            share_of_misfit: seen,
            share_unseen: unseen,
            share_reason: reason(seen, unseen),
        }
    };
    let whole = levels[0];
    Ok(AllShares {
        steps: seen
            .together()
            .filter(|_| !is_from_fit)
            .map(|_| MisfitSteps {
                explained: levels
                    .windows(2)
                    .map(|pair| (pair[0] - pair[1]) / whole)
                    .collect(),
                left: excess(&last) / whole,
                noise: dof(&last) / whole,
            }),
        together: shares(
            seen.together(),
            unseen.as_ref().and_then(DividedSquares::together),
        ),
        each: (0..without.len())
            .map(|place| {
                let unseen = unseen.as_ref();
                shares(seen.of(place), unseen.and_then(|unseen| unseen.of(place)))
            })
            .collect(),
    })
}

/// Poses where all others determine what was found, else repeats; of a part what is left out of it in turn; `None` if nothing serves.
fn folds(observations: &Observations, found: &[&[f64]]) -> Option<Vec<Fold>> {
    let cells = &observations.cells;
    let runs = &observations.runs;
    let count = folds_of(observations.poses.len());
    let of_pose = |reading: usize| (cells[observations.cell_of(reading)].pose % count) as u32;
    let of_repeat = |reading: usize| runs[observations.readings[reading].run].repeat;
    let determines = |folds: &Vec<Fold>| {
        let determined = folds.iter().all(|fold| {
            found.iter().all(|white| {
                let white = white.iter().zip(fold);
                let rest = white.filter(|(_, held)| !**held);
                rest.map(|(value, _)| value * value).sum::<f64>().sqrt() > DETERMINED
            })
        });
        folds.len() > 1 && determined
    };
    if observations.object != TestObject::Robot {
        return Some(unseen_parts(observations)).filter(determines);
    }
    let folds = |label: &dyn Fn(usize) -> u32| -> Option<Vec<Fold>> {
        let labels: Vec<u32> = (0..observations.len()).map(label).collect();
        let distinct: BTreeSet<&u32> = labels.iter().collect();
        let fold = |own: &u32| labels.iter().map(|label| label == own).collect();
        Some(distinct.into_iter().map(fold).collect()).filter(determines)
    };
    folds(&of_pose).or_else(|| folds(&of_repeat))
}

/// Squares of models of which one explains part of another.
struct DividedSquares {
    /// Of the baseline.
    whole: f64,
    /// Of noise alone.
    noise: f64,
    /// Standard deviation of the squares of noise.
    sd: f64,
    /// With all findings.
    left: f64,
    /// Without one of them.
    without: Vec<f64>,
}

impl DividedSquares {
    fn share(&self, explained: f64) -> Option<f64> {
        let visible = self.whole - self.noise;
        (visible >= VISIBLE_MISFIT * self.sd).then(|| (explained / visible).clamp(0.0, 1.0))
    }

    fn together(&self) -> Option<f64> {
        self.share(self.whole - self.left.max(self.noise))
    }

    fn of(&self, place: usize) -> Option<f64> {
        self.share(self.without[place] - self.left.max(self.noise))
    }
}
