//! What speaks for a law where nothing was repeated, so that what a model leaves may be physics that it does not hold: in the recording of a
//! part, and in a robot whose scatter is known from the fit alone.

use stiffbench_beams::physics::{Effect, LoadPoint, TestObject};

use super::sharpness::against_gradual_change;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::NoiseBasis;
use crate::mismatch::problem::{DiagnosisProblem, FittedModel, Model, State};
use crate::search::{FittedRows, WhiteSpace, dot, largest};

/// Evidence for a law by how much less it leaves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PartEvidence {
    /// How many independent values are as much evidence as what the law leaves.
    pub(crate) independent: f64,
    /// Degrees of freedom with which the size of these is known.
    pub(crate) dof: f64,
    /// Logarithm of the weighted squares without the law over those with it: in the readings it was fitted to or, once these were asked, in
    /// readings it was not fitted to, whichever shows less.
    pub(crate) fall: f64,
    /// Whether readings that it was not fitted to were asked, or there is nothing to ask.
    pub(crate) left_out: bool,
    /// The same of the best shape that was scored, in the readings it was fitted to.
    pub(crate) linear_fall: f64,
    /// The same as `fall` of a smooth curve of as many values, where the law must be better than that.
    pub(crate) fall_of_a_curve: f64,
}

impl PartEvidence {
    /// Where the noise is what the fit without the law leaves: an F against what the law leaves itself. With ν degrees of freedom left,
    /// (ν - 1/2) ln(1 + F/ν) has the quantiles of χ².
    ///
    /// # Arguments
    /// - `left`: degrees of freedom that the fit without the law leaves.
    /// - `dof`: those of the variance of the law's amplitude.
    /// - `delta_chi2`: fall of the weighted squares by the law as fitted and by the best shape that was scored.
    fn in_scatter_of_the_fit(left: f64, dof: f64, delta_chi2: [f64; 2]) -> Self {
        let [fall, linear_fall] = delta_chi2.map(|fall| {
            let share = (fall / left).clamp(0.0, LARGEST_SHARE);
            -(-share).ln_1p()
        });
        Self {
            independent: (left - 1.5).max(0.5),
            dof,
            fall,
            left_out: true,
            linear_fall,
            fall_of_a_curve: f64::NEG_INFINITY,
        }
    }
}

/// Largest share of what a fit leaves that a law can explain (1): what is left then is no more than rounding.
const LARGEST_SHARE: f64 = 1.0 - 1e-9;

/// A candidate that was fitted, not yet weighed.
pub(crate) struct ScoredFit<'c> {
    pub(crate) fitted: &'c FittedModel,
    /// Δχ² of the best shape that was scored.
    pub(crate) linear_delta_chi2: f64,
    /// Its effect, white and projected.
    pub(crate) white: &'c [f64],
    /// Degrees of freedom of the variance of its amplitude.
    pub(crate) dof: f64,
}

impl ScoredFit<'_> {
    /// What speaks for a candidate by what it leaves, `None` where the noise is known from elsewhere, and its log-likelihood relative to a change
    /// without physics in it as far as that is known by itself.
    ///
    /// # Arguments
    /// - `space`, `residuals`: those of the state.
    pub(crate) fn part_evidence(
        &self,
        problem: &DiagnosisProblem<'_>,
        state: &State,
        (space, residuals): (&WhiteSpace, &[f64]),
    ) -> Result<(Option<PartEvidence>, f64), MismatchError> {
        let model = &self.fitted.model;
        let Some(effect) = model.effects.last() else {
            return Ok((None, f64::INFINITY));
        };
        let (before, after) = (state.fitted.squares, self.fitted.squares);
        let independent = problem.independent_values(state, model)?;
        let mut of_a_part = (state.noise.basis == NoiseBasis::Fit).then(|| {
            let of_shape = self.linear_delta_chi2;
            let falls = [before - after, of_shape];
            PartEvidence::in_scatter_of_the_fit(
                left_by(problem, &state.fitted.model),
                self.dof,
                falls,
            )
        });
        if let Some(independent) = independent {
            let fall = (before / after).ln();
            let of_the_shape = (before - self.linear_delta_chi2).max(after);
            of_a_part = Some(PartEvidence {
                independent,
                dof: 1e6,
                fall,
                left_out: independent * fall <= WORTH_LEAVING_OUT,
                linear_fall: (before / of_the_shape).ln(),
                fall_of_a_curve: f64::NEG_INFINITY,
            });
        }
        if effect.law.is_of_one_run() {
            let gradual =
                against_gradual_change(problem.observations, space, residuals, self.white);
            return Ok((of_a_part, gradual));
        }
        let is_alone = state.fitted.model.effects.is_empty();
        let must_be_sharp = problem.observations.object != TestObject::Robot
            && effect.law.search.is_sharp
            && (effect.law.is_gauge_error() || !is_alone);
        if !must_be_sharp {
            return Ok((of_a_part, f64::INFINITY));
        }
        let fall = fall_of_a_curve(
            &problem.observations.loads,
            (space, residuals),
            before,
            effect.fitted_values(),
        );
        Ok(match of_a_part {
            Some(part) => {
                let part = PartEvidence {
                    fall_of_a_curve: fall,
                    ..part
                };
                (Some(part), f64::INFINITY)
            }
            None => (None, 0.5 * (before * (-fall).exp() - after)),
        })
    }
}

/// Degrees of freedom that a model leaves.
fn left_by(problem: &DiagnosisProblem<'_>, model: &Model) -> f64 {
    let values = model.effects.iter().map(Effect::fitted_values);
    let free = model.parameters.len() + values.sum::<usize>();
    problem.observations.len().saturating_sub(free).max(1) as f64
}

/// Logarithm of the weighted squares without and with a smooth curve over what was set: powers, or odd powers.
///
/// # Arguments
/// - `squares`: without it.
/// - `values`: that the curve has.
fn fall_of_a_curve(
    loads: &[LoadPoint],
    (space, residuals): (&WhiteSpace, &[f64]),
    squares: f64,
    values: usize,
) -> f64 {
    let largest = largest(loads.iter().map(|load| &load.force_n));
    let fall = |powers: &mut dyn Iterator<Item = i32>| {
        let mut left = FittedRows::new(residuals.to_vec());
        for power in powers {
            let of_power = |load: &LoadPoint| (load.force_n / largest).powi(power);
            let rows: Vec<f64> = loads.iter().map(of_power).collect();
            left.set_free(space.projected(&rows).into(), 0.0);
        }
        dot(residuals, residuals) - left.squares()
    };
    let count = values as i32;
    let odd = fall(&mut (1..=count).map(|k| 2 * k + 1));
    let fall = fall(&mut (2..2 + count)).max(odd);
    (squares / (squares - fall).max(f64::MIN_POSITIVE)).ln()
}

/// Twice the logarithm of a likelihood ratio from which on parts are left out to see whether a law predicts them: below, nothing is believed.
const WORTH_LEAVING_OUT: f64 = 6.0;
