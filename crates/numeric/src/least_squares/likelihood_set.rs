//! All values of a parameter that the data allow, whichever minimum they belong to.
//!
//! A profile followed from one minimum misses a second one that fits about as well. Here it is followed from every minimum within reach,
//! and what overlaps is joined; what does not stands apart, as islands. Where minima compete or a profile folds, the rise of ‖r‖² that
//! 95 % of samples stay below is no longer that of the F law (a second chance to fit makes it larger, a fold smaller): there it is drawn,
//! by fits to simulated residuals at the value that is tested.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::covariance::{ParameterCovariance, SigmaMode};
use super::error::LeastSquaresError;
use super::minima::spread;
use super::minimise::{LeastSquaresFit, LeastSquaresSettings, minimise};
use super::parameter::{Bound, ParameterSet};
use super::profile::{
    Conditional, LowerMinimum, ProfileEnd, ProfileSettings, Walk, bounds_of, others, rise_at_95,
};
use super::residual_function::{EvaluationFailure, JacobianView, ResidualFunction};
use crate::statistics::{chi_squared_quantile, normal_quantile};

/// How a set is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LikelihoodSetSettings {
    /// For following profiles.
    pub profile: ProfileSettings,
    /// A minimum within this of the lowest, in units of the residuals' variance, may belong to a set.
    pub near: f64,
    /// Starts that a fold is searched for with at each end, beside the minima.
    pub fold_starts: usize,
    /// Samples from which a limit is drawn; with none the F law is kept everywhere.
    pub draws: usize,
    /// Seed of the samples.
    pub seed: u64,
}

impl Default for LikelihoodSetSettings {
    /// A minimum 10 above the lowest is 3.2 standard errors away from belonging. With 199 samples the probability at the limit is known to
    /// 1.5 %.
    fn default() -> Self {
        Self {
            profile: ProfileSettings::default(),
            near: 10.0,
            fold_starts: 4,
            draws: 199,
            seed: 0,
        }
    }
}

/// The 95 % likelihood-ratio set of one parameter.
#[derive(Debug)]
pub struct LikelihoodSet {
    /// Index of the parameter in the full vector.
    pub parameter: usize,
    /// Its value at the lowest minimum.
    pub estimate: f64,
    /// Lower and upper end of each part, ascending; parts do not touch.
    pub parts: Vec<[ProfileEnd; 2]>,
    /// Whether the limit was drawn: other minima are near, or the profile folds.
    pub drawn: bool,
    /// A lower minimum than any given, if one was met; the set is then worth nothing.
    pub lower_minimum: Option<LowerMinimum>,
}

impl LikelihoodSet {
    /// The parts as intervals, if every end was found.
    #[must_use]
    pub fn closed(&self) -> Option<Vec<[f64; 2]>> {
        let ends = |[lower, upper]: &[ProfileEnd; 2]| Some([lower.closed()?, upper.closed()?]);
        self.parts.iter().map(ends).collect()
    }
}

/// What the sets of all parameters of a fit have in common.
#[derive(Debug, Clone, Copy)]
pub struct Likelihood<'a, N> {
    /// Makes the problem of the fit once more, for a thread of its own.
    pub again: N,
    /// Its parameters.
    pub set: &'a ParameterSet,
    /// Its minima, lowest first (see [`minima`](super::minima)).
    pub minima: &'a [LeastSquaresFit],
    /// Covariance at the lowest minimum.
    pub covariance: &'a ParameterCovariance,
    /// How sets are found.
    pub settings: &'a LikelihoodSetSettings,
}

/// Folds of one profile that are followed; a valley with more has no end worth naming.
const MOST_FOLDS: usize = 8;

impl<P, N> Likelihood<'_, N>
where
    P: ResidualFunction,
    N: Fn() -> Option<P> + Sync,
{
    /// The set of free parameter number `parameter` (index in the full vector).
    ///
    /// # Errors
    /// `UnknownParameter`, `NotFree`, `NoDegreesOfFreedom`, as for [`profile`](super::profile); `NoResiduals` without a minimum.
    ///
    /// # Source
    /// Bates and Watts, Nonlinear Regression Analysis and Its Applications (1988), section 6.1; drawn limits: Davison and Hinkley,
    /// Bootstrap Methods and their Application (1997), section 5.4.
    pub fn of(
        &self,
        problem: &mut dyn ResidualFunction,
        parameter: usize,
    ) -> Result<LikelihoodSet, LeastSquaresError> {
        let lowest = self.minima.first().ok_or(LeastSquaresError::NoResiduals)?;
        let common = rise_at_95(lowest, self.covariance)?;
        let near = self.settings.near * self.variance();
        let minima = self.minima.iter();
        let near: Vec<&LeastSquaresFit> = minima
            .filter(|fit| fit.sum_of_squares() - lowest.sum_of_squares() <= near)
            .collect();
        let mut search = SetSearch {
            likelihood: self,
            problem,
            parameter,
            competing: Vec::new(),
            folds: false,
            lower_minimum: None,
        };
        let mut parts = search.compete(&near, common)?;
        let drawn = self.settings.draws > 0 && (search.competing.len() > 1 || search.folds);
        if drawn {
            parts.clear();
            for fit in search.competing.clone() {
                parts.extend(search.part(fit, &|search, at| search.drawn_limit(at, common))?);
            }
        }
        Ok(LikelihoodSet {
            parameter,
            estimate: lowest.values[parameter],
            parts: join(parts),
            drawn,
            lower_minimum: search.lower_minimum,
        })
    }

    /// Variance of the residuals: 1 if it is known, else as estimated.
    fn variance(&self) -> f64 {
        match self.covariance.mode {
            SigmaMode::Known => 1.0,
            SigmaMode::Estimated => self.covariance.reduced_chi_squared.unwrap_or(1.0),
        }
    }

    /// A sample of the residuals' errors, each from its own stream.
    fn errors(&self, draw: usize, count: usize) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(self.settings.seed);
        random.set_stream(draw as u64);
        let dof = self.covariance.interval_dof;
        // Standard deviations that were estimated themselves are all wrong by one factor.
        let scale = match self.covariance.mode {
            SigmaMode::Known if dof.is_finite() => {
                let share = random.random_range(f64::EPSILON..1.0);
                chi_squared_quantile(share, dof).map_or(1.0, |sum| (dof / sum).sqrt())
            }
            _ => self.variance().sqrt(),
        };
        (0..count)
            .map(|_| scale * normal_quantile(random.random_range(f64::EPSILON..1.0)))
            .collect()
    }
}

/// A rise of ‖r‖², or why there is none.
type Rise = Result<f64, LeastSquaresError>;

/// The search for one set.
struct SetSearch<'a, N> {
    likelihood: &'a Likelihood<'a, N>,
    problem: &'a mut dyn ResidualFunction,
    parameter: usize,
    /// Minima that the profile from none of those before leads past, lowest first.
    competing: Vec<&'a LeastSquaresFit>,
    folds: bool,
    lower_minimum: Option<LowerMinimum>,
}

impl<'a, P, N> SetSearch<'a, N>
where
    P: ResidualFunction,
    N: Fn() -> Option<P> + Sync,
{
    /// Finds the competing minima and the part of each at a fixed limit.
    ///
    /// A minimum inside the part of another, to which refits of the other parameters lead from there, is the bottom of the same valley: of
    /// a parameter that the data do not determine there are many.
    fn compete(
        &mut self,
        near: &[&'a LeastSquaresFit],
        limit: f64,
    ) -> Result<Vec<[ProfileEnd; 2]>, LeastSquaresError> {
        let set = self.likelihood.set;
        let mut parts: Vec<(&LeastSquaresFit, [ProfileEnd; 2])> = Vec::new();
        for &fit in near {
            let value = fit.values[self.parameter];
            let mut known = false;
            for (other, [lower, upper]) in &parts {
                if (lower.value()..=upper.value()).contains(&value) {
                    let settings = &self.likelihood.settings.profile;
                    let mut walk =
                        Walk::new(self.problem, set, fit, self.parameter, limit, settings);
                    let start = others(set, self.parameter, &other.free_values);
                    known |= walk.refit(value, &start)?.is_ok_and(|led| led.height < 0.1);
                }
            }
            if known {
                continue;
            }
            self.competing.push(fit);
            if let Some(part) = self.part(fit, &|_, _| Ok(limit))? {
                parts.push((fit, part));
            }
        }
        Ok(parts.into_iter().map(|(_, part)| part).collect())
    }

    /// The part of a minimum that belongs to the set. `limit` is the rise allowed at a point, given all parameters there.
    fn part(
        &mut self,
        fit: &LeastSquaresFit,
        limit: &dyn Fn(&Self, &[f64]) -> Rise,
    ) -> Result<Option<[ProfileEnd; 2]>, LeastSquaresError> {
        let (lower_bound, upper_bound) = bounds_of(self.likelihood.set, self.parameter)?;
        let here = limit(self, &fit.values)?;
        let lowest = self.likelihood.minima[0].sum_of_squares();
        if fit.sum_of_squares() - lowest > here {
            return Ok(None);
        }
        let mut end = |bound_value, bound| -> Result<ProfileEnd, LeastSquaresError> {
            let (end, at) = self.side(fit, here, bound_value, bound)?;
            let Some(at) = at.filter(|_| end.closed().is_some()) else {
                return Ok(end);
            };
            let there = limit(self, &at)?;
            if there == here {
                return Ok(end);
            }
            Ok(self.side(fit, there, bound_value, bound)?.0)
        };
        Ok(Some([
            end(lower_bound, Bound::Lower)?,
            end(upper_bound, Bound::Upper)?,
        ]))
    }

    /// Follows the profile from a minimum to one side, on past folds, to where it is `threshold` above the lowest minimum. With all
    /// parameters there.
    fn side(
        &mut self,
        fit: &LeastSquaresFit,
        threshold: f64,
        limit: f64,
        bound: Bound,
    ) -> Result<(ProfileEnd, Option<Vec<f64>>), LeastSquaresError> {
        let Likelihood {
            set,
            minima,
            settings,
            ..
        } = *self.likelihood;
        let mut walk = Walk::new(
            self.problem,
            set,
            fit,
            self.parameter,
            threshold,
            &settings.profile,
        );
        walk.lowest = minima[0].sum_of_squares();
        let outward = match bound {
            Bound::Lower => -1.0,
            Bound::Upper => 1.0,
        };
        let distance = outward * walk.first_distance();
        let mut from = walk.start();
        let mut result = (
            ProfileEnd::Closed { value: from.value },
            Some(from.full.clone()),
        );
        if from.height < 1.0 {
            for _ in 0..MOST_FOLDS {
                let end = walk.end(from, distance, limit, bound)?;
                let Some(value) = end.closed() else {
                    result = (end, None);
                    break;
                };
                let Some(best) = lowest_at(
                    &mut walk,
                    value,
                    set,
                    self.parameter,
                    &self.competing,
                    settings.fold_starts,
                )?
                else {
                    result = (end, None);
                    break;
                };
                // An end is found to a ten-thousandth of its height: what lies a hundredth lower is another branch.
                let another = best.height < 0.99;
                result = (end, Some(best.full.clone()));
                if !another {
                    break;
                }
                self.folds = true;
                from = best;
            }
        }
        if let Some(lower) = walk.lower_minimum.take() {
            let known = self.lower_minimum.as_ref();
            if known.is_none_or(|known| lower.sum_of_squares < known.sum_of_squares) {
                self.lower_minimum = Some(lower);
            }
        }
        Ok(result)
    }

    /// The rise of ‖r‖² that 95 % of samples stay below if the truth is `at`: the parameter's value there is tested against all others.
    fn drawn_limit(&self, at: &[f64], otherwise: f64) -> Rise {
        let likelihood = self.likelihood;
        let set = likelihood.set;
        let index = self.parameter;
        let free_of = |full: &[f64]| -> Vec<f64> {
            set.free_indices().iter().map(|&free| full[free]).collect()
        };
        let starts: Vec<Vec<f64>> = std::iter::once(free_of(at))
            .chain(self.competing.iter().map(|fit| fit.free_values.clone()))
            .collect();
        let tested = set.with_fixed(index, at[index])?;
        let settings = &likelihood.settings.profile.refits;
        let residuals = likelihood.minima[0].residuals.len();
        let dof = likelihood.covariance.dof as f64;
        let variance = likelihood.variance();
        let mut rises: Vec<f64> = (0..likelihood.settings.draws)
            .into_par_iter()
            .map_init(&likelihood.again, |problem, draw| {
                let problem = problem.as_mut()?;
                let mut there = vec![0.0; residuals];
                problem.evaluate(at, &mut there, None).ok()?;
                let errors = likelihood.errors(draw, residuals);
                let shift = there.iter().zip(errors).map(|(r, e)| r + e).collect();
                let mut sample = Shifted { problem, shift };
                let without = starts.iter().map(|start| others(set, index, start));
                let held = best(&mut sample, &tested, without, settings)?;
                let from_held = std::iter::once(free_of(&held.values));
                let all = from_held.chain(starts.iter().cloned());
                let free = best(&mut sample, set, all, settings)?;
                let rise = (held.sum_of_squares() - free.sum_of_squares()).max(0.0);
                Some(match likelihood.covariance.mode {
                    SigmaMode::Known => rise,
                    SigmaMode::Estimated => rise * variance * dof / free.sum_of_squares(),
                })
            })
            .flatten()
            .collect();
        rises.sort_by(f64::total_cmp);
        // The rank whose share of the samples and the data together is 95 %.
        let rank = (0.95 * (rises.len() as f64 + 1.0)).ceil() as usize;
        Ok(rises
            .get(rank.wrapping_sub(1))
            .copied()
            .unwrap_or(otherwise))
    }
}

/// The best refit of the other parameters at a value, from every minimum and some starts besides.
fn lowest_at(
    walk: &mut Walk<'_>,
    value: f64,
    set: &ParameterSet,
    parameter: usize,
    minima: &[&LeastSquaresFit],
    fold_starts: usize,
) -> Result<Option<Conditional>, LeastSquaresError> {
    let from_minima = minima.iter().map(|fit| fit.free_values.clone());
    let starts: Vec<Vec<f64>> = from_minima.chain(spread(set).take(fold_starts)).collect();
    let mut best: Option<Conditional> = None;
    for start in starts {
        if let Ok(found) = walk.refit(value, &others(set, parameter, &start))?
            && best.as_ref().is_none_or(|best| found.height < best.height)
        {
            best = Some(found);
        }
    }
    Ok(best)
}

/// The lowest converged fit from several starts.
fn best(
    problem: &mut dyn ResidualFunction,
    set: &ParameterSet,
    starts: impl Iterator<Item = Vec<f64>>,
    settings: &LeastSquaresSettings,
) -> Option<LeastSquaresFit> {
    starts
        .filter_map(|start| minimise(problem, &set.with_start(&start).ok()?, settings).ok())
        .filter(|fit| fit.termination.is_converged())
        .min_by(|a, b| a.objective.total_cmp(&b.objective))
}

/// Joins parts that overlap.
fn join(mut parts: Vec<[ProfileEnd; 2]>) -> Vec<[ProfileEnd; 2]> {
    parts.sort_by(|a, b| a[0].value().total_cmp(&b[0].value()));
    let mut joined: Vec<[ProfileEnd; 2]> = Vec::new();
    for part in parts {
        match joined.last_mut() {
            // Where an end between two parts was not found, nothing states that they are apart.
            Some([_, upper])
                if part[0].value() <= upper.value()
                    || upper.closed().is_none()
                    || part[0].closed().is_none() =>
            {
                let [_, end] = part;
                if end.value() > upper.value() {
                    *upper = end;
                }
            }
            _ => joined.push(part),
        }
    }
    joined
}

/// A problem with other measured values: its residuals less a constant.
struct Shifted<'a> {
    problem: &'a mut dyn ResidualFunction,
    shift: Vec<f64>,
}

impl ResidualFunction for Shifted<'_> {
    fn residual_count(&self) -> usize {
        self.problem.residual_count()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        self.problem.evaluate(parameters, residuals, jacobian)?;
        for (residual, shift) in residuals.iter_mut().zip(&self.shift) {
            *residual -= shift;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
