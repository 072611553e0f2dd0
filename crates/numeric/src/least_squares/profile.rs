//! The interval of one parameter from the objective itself: all values for which refitting the others costs little enough.

use crate::statistics::student_t_quantile;

use super::covariance::{ParameterCovariance, SigmaMode};
use super::error::LeastSquaresError;
use super::minimise::{LeastSquaresFit, LeastSquaresSettings, Termination, minimise};
use super::parameter::{Bound, ParameterRole, ParameterSet};
use super::residual_function::ResidualFunction;
use super::singular_values::norm;

/// How a profile is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileSettings {
    /// For the refits.
    pub refits: LeastSquaresSettings,
    /// An end is found when √(rise/threshold) is 1 to within this.
    pub tolerance: f64,
    /// Refits after which a side is given up.
    pub max_refits: usize,
}

impl Default for ProfileSettings {
    /// 1e-4 of the half-length is far below what an interval is read to; 60 refits reach 1e9 standard errors if need be.
    fn default() -> Self {
        Self {
            refits: LeastSquaresSettings::for_refits(),
            tolerance: 1e-4,
            max_refits: 60,
        }
    }
}

/// One end of a profile interval; values in the parameter's unit.
#[derive(Debug)]
pub enum ProfileEnd {
    /// The objective reaches the threshold here.
    Closed {
        /// The end.
        value: f64,
    },
    /// The parameter's bound comes first; the data alone do not end the interval.
    OpenAtBound {
        /// Which bound.
        bound: Bound,
        /// Where it is.
        value: f64,
        /// Rise of ‖r‖² there as a share of the threshold.
        rise: f64,
    },
    /// The objective does not reach the threshold however far the parameter goes.
    Open {
        /// The furthest value tried.
        value: f64,
        /// Rise of ‖r‖² there as a share of the threshold.
        rise: f64,
    },
    /// The other parameters could not be refitted beyond this value.
    NotFollowed {
        /// The last value with a refit.
        value: f64,
        /// Rise of ‖r‖² there as a share of the threshold.
        rise: f64,
        /// How the refit beyond ended; absent if the model has no value there.
        termination: Option<Termination>,
    },
}

impl ProfileEnd {
    /// The end, if the data give one.
    #[must_use]
    pub fn closed(&self) -> Option<f64> {
        match self {
            Self::Closed { value } => Some(*value),
            Self::OpenAtBound { .. } | Self::Open { .. } | Self::NotFollowed { .. } => None,
        }
    }

    /// How far the profile was followed.
    #[must_use]
    pub fn value(&self) -> f64 {
        match self {
            Self::Closed { value }
            | Self::OpenAtBound { value, .. }
            | Self::Open { value, .. }
            | Self::NotFollowed { value, .. } => *value,
        }
    }
}

/// A better fit met on the way: the fit that was profiled was not at the lowest minimum.
#[derive(Debug, Clone, PartialEq)]
pub struct LowerMinimum {
    /// Values of all parameters there.
    pub values: Vec<f64>,
    /// ‖r‖² there.
    pub sum_of_squares: f64,
}

/// The 95 % profile-likelihood interval of one parameter.
#[derive(Debug)]
pub struct ProfileInterval {
    /// Index of the parameter in the full vector.
    pub parameter: usize,
    /// Its name.
    pub name: String,
    /// Its value at the minimum.
    pub estimate: f64,
    /// Lower end.
    pub lower: ProfileEnd,
    /// Upper end.
    pub upper: ProfileEnd,
    /// Rise of ‖r‖² at a closed end.
    pub threshold: f64,
    /// All parameters at the points on the way whose rise is at most the threshold.
    pub inside: Vec<Vec<f64>>,
    /// A lower minimum than the one profiled, if the refits found one; the interval is then worth nothing.
    pub lower_minimum: Option<LowerMinimum>,
    /// Evaluations of the problem.
    pub evaluations: usize,
}

/// Follows the profile of free parameter number `parameter` (index in the full vector) to both sides.
///
/// # Arguments
/// - `threshold`: rise of ‖r‖² at the ends; that of a 95 % interval is [`rise_at_95`].
///
/// # Errors
/// `UnknownParameter`; `NotFree` for a fixed or tied parameter.
///
/// # Source
/// Bates and Watts, Nonlinear Regression Analysis and Its Applications (1988), section 6.1.2.
pub fn profile(
    problem: &mut dyn ResidualFunction,
    set: &ParameterSet,
    fit: &LeastSquaresFit,
    parameter: usize,
    threshold: f64,
    settings: &ProfileSettings,
) -> Result<ProfileInterval, LeastSquaresError> {
    let (lower_bound, upper_bound) = bounds_of(set, parameter)?;
    let mut walk = Walk::new(problem, set, fit, parameter, threshold, settings);
    let distance = walk.first_distance();
    let lower = walk.end(walk.start(), -distance, lower_bound, Bound::Lower)?;
    let upper = walk.end(walk.start(), distance, upper_bound, Bound::Upper)?;
    Ok(ProfileInterval {
        parameter,
        name: set.parameters()[parameter].name.clone(),
        estimate: fit.values[parameter],
        lower,
        upper,
        threshold,
        inside: walk.inside,
        lower_minimum: walk.lower_minimum,
        evaluations: walk.evaluations,
    })
}

/// Bounds of a free parameter.
///
/// # Errors
/// `UnknownParameter`, `NotFree`.
pub(super) fn bounds_of(
    set: &ParameterSet,
    parameter: usize,
) -> Result<(f64, f64), LeastSquaresError> {
    let count = set.parameters().len();
    let found = set
        .parameters()
        .get(parameter)
        .ok_or(LeastSquaresError::UnknownParameter {
            index: parameter,
            count,
        })?;
    let role = match found.role {
        ParameterRole::Free { lower, upper, .. } => return Ok((lower, upper)),
        ParameterRole::Fixed { .. } => "fixed",
        ParameterRole::TiedTo { .. } => "tied",
    };
    Err(LeastSquaresError::NotFree {
        name: found.name.clone(),
        role,
    })
}

/// Rise of ‖r‖² at the ends of the 95 % interval of one parameter: 3.841 with exactly known standard deviations, s² F(0.95; 1, n − p) with
/// estimated ones, which is s² t² with Student's t for 0.975.
///
/// # Errors
/// `NoDegreesOfFreedom` as for the covariance.
pub fn rise_at_95(
    fit: &LeastSquaresFit,
    covariance: &ParameterCovariance,
) -> Result<f64, LeastSquaresError> {
    let no_dof = || LeastSquaresError::NoDegreesOfFreedom {
        residuals: fit.residuals.len(),
        estimated: covariance.rank,
    };
    let variance = match covariance.mode {
        SigmaMode::Known => 1.0,
        SigmaMode::Estimated => covariance.reduced_chi_squared.ok_or_else(no_dof)?,
    };
    let quantile = student_t_quantile(0.975, covariance.interval_dof).ok_or_else(no_dof)?;
    Ok(variance * quantile * quantile)
}

/// A value of the parameter with the others refitted.
pub(super) struct Conditional {
    pub(super) value: f64,
    /// √(rise/threshold), about linear in the value.
    pub(super) height: f64,
    /// The other free parameters.
    pub(super) others: Vec<f64>,
    /// All parameters.
    pub(super) full: Vec<f64>,
}

/// Follows the profile of one parameter from a minimum.
pub(super) struct Walk<'a> {
    problem: &'a mut dyn ResidualFunction,
    set: &'a ParameterSet,
    /// The minimum that is followed.
    fit: &'a LeastSquaresFit,
    /// ‖r‖² that rises are counted from: that of the lowest minimum.
    pub(super) lowest: f64,
    parameter: usize,
    pub(super) threshold: f64,
    settings: &'a ProfileSettings,
    inside: Vec<Vec<f64>>,
    pub(super) lower_minimum: Option<LowerMinimum>,
    pub(super) evaluations: usize,
}

impl<'a> Walk<'a> {
    pub(super) fn new(
        problem: &'a mut dyn ResidualFunction,
        set: &'a ParameterSet,
        fit: &'a LeastSquaresFit,
        parameter: usize,
        threshold: f64,
        settings: &'a ProfileSettings,
    ) -> Self {
        Self {
            problem,
            set,
            fit,
            lowest: fit.sum_of_squares(),
            parameter,
            threshold,
            settings,
            inside: Vec::new(),
            lower_minimum: None,
            evaluations: 0,
        }
    }

    /// Distance at which the threshold would be reached if the other parameters did not give way: never too far.
    pub(super) fn first_distance(&self) -> f64 {
        let free = self
            .set
            .free_indices()
            .partition_point(|&index| index < self.parameter);
        let length = self.fit.jacobian_column(free).map_or(0.0, norm);
        if length > 0.0 {
            self.threshold.sqrt() / length
        } else {
            let value = self.fit.values[self.parameter].abs();
            if value > 0.0 { value } else { 1.0 }
        }
    }

    /// Steps outward from `inner` until the threshold is passed, then closes in; `distance` is signed.
    pub(super) fn end(
        &mut self,
        mut inner: Conditional,
        mut distance: f64,
        limit: f64,
        bound: Bound,
    ) -> Result<ProfileEnd, LeastSquaresError> {
        let mut failure: Option<(f64, Option<Termination>)> = None;
        for _ in 0..self.settings.max_refits {
            let rise = inner.height * inner.height;
            if inner.value == limit {
                return Ok(ProfileEnd::OpenAtBound {
                    bound,
                    value: limit,
                    rise,
                });
            }
            let value = match failure.take() {
                Some((beyond, termination)) if self.is_close(inner.value, beyond) => {
                    return Ok(ProfileEnd::NotFollowed {
                        value: inner.value,
                        rise,
                        termination,
                    });
                }
                Some((beyond, termination)) => {
                    failure = Some((beyond, termination));
                    0.5 * (inner.value + beyond)
                }
                None if (limit - inner.value - distance) * distance > 0.0 => inner.value + distance,
                None => limit,
            };
            match self.refit(value, &inner.others)? {
                Ok(outer) if outer.height >= 1.0 => return self.close_in(inner, outer),
                Ok(next) => {
                    distance = self.next_distance(&next);
                    inner = next;
                }
                Err(termination) => failure = Some((value, termination)),
            }
        }
        let (value, rise) = (inner.value, inner.height * inner.height);
        Ok(match failure {
            Some((_, termination)) => ProfileEnd::NotFollowed {
                value,
                rise,
                termination,
            },
            None => ProfileEnd::Open { value, rise },
        })
    }

    /// Whether two values differ by less than an end is asked to be known to.
    fn is_close(&self, a: f64, b: f64) -> bool {
        (a - b).abs() <= self.settings.tolerance * (b - self.fit.values[self.parameter]).abs()
    }

    /// The height grows about linearly: aims at the threshold, but at most four times and at least half as far again.
    fn next_distance(&self, reached: &Conditional) -> f64 {
        let factor = 1.0 / reached.height.max(0.2) - 1.0;
        (reached.value - self.fit.values[self.parameter]) * factor.clamp(0.5, 4.0)
    }

    pub(super) fn start(&self) -> Conditional {
        let rise = self.fit.sum_of_squares() - self.lowest;
        Conditional {
            value: self.fit.values[self.parameter],
            height: (rise.max(0.0) / self.threshold).sqrt(),
            others: others(self.set, self.parameter, &self.fit.free_values),
            full: self.fit.values.clone(),
        }
    }

    /// The crossing between a point below the threshold and one above (false position with Illinois' halving).
    fn close_in(
        &mut self,
        mut below: Conditional,
        mut above: Conditional,
    ) -> Result<ProfileEnd, LeastSquaresError> {
        let (mut below_weight, mut above_weight) = (1.0, 1.0);
        for _ in 0..self.settings.max_refits {
            let (f_below, f_above) = (
                (below.height - 1.0) * below_weight,
                (above.height - 1.0) * above_weight,
            );
            let share = f_below / (f_below - f_above);
            let value = below.value + share * (above.value - below.value);
            if (above.height - 1.0).abs() <= self.settings.tolerance
                || value == below.value
                || value == above.value
            {
                break;
            }
            let next = match self.refit(value, &below.others)? {
                Ok(next) => next,
                Err(termination) => {
                    let rise = below.height * below.height;
                    return Ok(ProfileEnd::NotFollowed {
                        value: below.value,
                        rise,
                        termination,
                    });
                }
            };
            if (next.height - 1.0).abs() <= self.settings.tolerance {
                return Ok(ProfileEnd::Closed { value: next.value });
            }
            if next.height >= 1.0 {
                above = next;
                above_weight = 1.0;
                below_weight *= 0.5;
            } else {
                below = next;
                below_weight = 1.0;
                above_weight *= 0.5;
            }
        }
        Ok(ProfileEnd::Closed { value: above.value })
    }

    /// Refits the others with the parameter at `value`; the inner error states how that failed.
    pub(super) fn refit(
        &mut self,
        value: f64,
        start: &[f64],
    ) -> Result<Result<Conditional, Option<Termination>>, LeastSquaresError> {
        let set = self
            .set
            .with_fixed(self.parameter, value)?
            .with_start(start)?;
        let fit = match minimise(self.problem, &set, &self.settings.refits) {
            Ok(fit) => fit,
            Err(LeastSquaresError::StartHasNoValue { .. }) => {
                self.evaluations += 1;
                return Ok(Err(None));
            }
            Err(other) => return Err(other),
        };
        self.evaluations += fit.evaluations;
        let fit = match fit.termination {
            Termination::Converged(_) => fit,
            // Along the floor of a curved valley a fit creeps on, or stalls in the rounding of the model, where its height has long
            // been reached.
            Termination::AtLimit { .. } | Termination::Stalled => {
                let on = set.with_start(&fit.free_values)?;
                let further = minimise(self.problem, &on, &self.settings.refits)?;
                self.evaluations += further.evaluations;
                let fallen = fit.sum_of_squares() - further.sum_of_squares();
                let arrived = further.termination.is_converged()
                    || fallen <= self.settings.tolerance * self.threshold;
                if !arrived {
                    return Ok(Err(Some(further.termination)));
                }
                further
            }
            termination @ Termination::EvaluationFailed(_) => return Ok(Err(Some(termination))),
        };
        let rise = fit.sum_of_squares() - self.lowest;
        // A thousandth of the threshold is beyond what an unfinished minimum explains.
        let best_so_far = self
            .lower_minimum
            .as_ref()
            .map_or(f64::INFINITY, |lower| lower.sum_of_squares);
        if rise < -1e-3 * self.threshold && fit.sum_of_squares() < best_so_far {
            self.lower_minimum = Some(LowerMinimum {
                values: fit.values.clone(),
                sum_of_squares: fit.sum_of_squares(),
            });
        }
        let height = (rise.max(0.0) / self.threshold).sqrt();
        if height <= 1.0 {
            self.inside.push(fit.values.clone());
        }
        Ok(Ok(Conditional {
            value,
            height,
            others: fit.free_values,
            full: fit.values,
        }))
    }
}

/// The free values without that of one parameter.
pub(super) fn others(set: &ParameterSet, parameter: usize, free_values: &[f64]) -> Vec<f64> {
    let all = set.free_indices().iter().zip(free_values);
    all.filter(|&(&index, _)| index != parameter)
        .map(|(_, &value)| value)
        .collect()
}

#[cfg(test)]
mod tests;
