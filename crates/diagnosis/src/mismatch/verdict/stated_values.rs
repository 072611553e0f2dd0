//! Values of a model that are stated: their standard uncertainties, and their likelihood intervals.

use rayon::prelude::*;

use stiffbench_numeric::least_squares::ProfileEnd;
use stiffbench_numeric::statistics::student_t_quantile;

use crate::mismatch::baselines::prior_sd;
use crate::mismatch::error::MismatchError;
use crate::mismatch::problem::{DiagnosisProblem, FittedModel, Model, State, Stated, ValueProfile};
use crate::search::Information;

/// A value with its standard uncertainty and its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatedValue {
    /// The value, SI.
    pub value: f64,
    /// Its standard uncertainty, SI; `None` where the readings change by steps and a derivative carries no information.
    pub u: Option<f64>,
    /// Degrees of freedom of that uncertainty.
    pub dof: f64,
    /// Its 95 % interval; `None` where the readings say nothing of it.
    pub interval: Option<ValueInterval>,
}

/// All values that readings allow: those at which the weighted squares, all other values refitted, rise by at most F(0.95; 1, dof).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValueInterval {
    /// Its ends, SI.
    pub ends: [f64; 2],
    /// Whether an end is the bound of what is plausible, which the readings do not reach.
    pub is_open: [bool; 2],
}

impl EstimatedValue {
    /// A value with its standard uncertainty and the degrees of freedom of that; its interval is that of Student's t.
    #[must_use]
    pub fn of_covariance(value: f64, (u, dof): (Option<f64>, f64)) -> Self {
        let half = u.zip(student_t_quantile(0.975, dof)).map(|(u, t)| t * u);
        let interval = half.map(|half| ValueInterval {
            ends: [value - half, value + half],
            is_open: [false; 2],
        });
        Self {
            value,
            u,
            dof,
            interval,
        }
    }

    /// Whether an end of the interval is the bound of what is plausible.
    #[must_use]
    pub fn is_open(&self) -> [bool; 2] {
        self.interval.map_or([false; 2], |found| found.is_open)
    }

    /// 95 % interval.
    #[must_use]
    pub fn interval_95(&self) -> Option<[f64; 2]> {
        self.interval.map(|found| found.ends)
    }
}

/// What is stated of a fitted model, with standard uncertainties from its linearisation and likelihood intervals.
///
/// # Arguments
/// - `dof`: degrees of freedom of the noise; those of each value if `None`.
pub(crate) fn estimated_values(
    problem: &DiagnosisProblem<'_>,
    state: &State,
    fitted: &FittedModel,
    stated: &[Stated],
    dof: Option<f64>,
) -> Result<Vec<EstimatedValue>, MismatchError> {
    let (model, scales) = (&fitted.model, problem.scales());
    let covariance = uncertainties(problem, state, model)?;
    let independent = problem.independent_values(state, model)?;
    // What is left goes on from reading to reading: it moves the values as independent errors of that size would.
    let wider = independent.map_or(1.0, |count| (fitted.squares / count).max(1.0).sqrt());
    let linear = |stated: &Stated| {
        let place = stated.place(model.parameters.len(), &model.effects);
        let (u, own_dof) = covariance[place];
        let u = u.filter(|_| !matches!(stated, Stated::Combination { .. }));
        let dof = independent.or(dof).unwrap_or(own_dof).max(2.0);
        EstimatedValue::of_covariance(stated.of(model, scales), (u.map(|u| u * wider), dof))
    };
    let mut values: Vec<EstimatedValue> = stated.iter().map(linear).collect();
    let refit = problem.refit(&state.whitening);
    let lowest = refit.lowest(model);
    let profile = |(stated, value): (&Stated, &EstimatedValue)| {
        let rise = (student_t_quantile(0.975, value.dof)? * wider).powi(2);
        let lowest = lowest.as_ref()?;
        refit.profile((model, lowest), *stated, rise)
    };
    let both = stated.par_iter().zip(&values);
    let profiles: Vec<Option<ValueProfile>> = both.map(profile).collect();
    let inside = profiles.iter().flatten().flat_map(|one| &one.inside);
    let inside: Vec<&Model> = inside.collect();
    for ((value, profile), stated) in values.iter_mut().zip(&profiles).zip(stated) {
        let inside = inside.iter().map(|model| stated.of(model, scales));
        let profile = profile.as_ref();
        value.interval = profile.and_then(|profile| interval(value, profile, inside));
    }
    Ok(values)
}

/// Standard uncertainty of every parameter of a model, and its degrees of freedom; no uncertainty where the readings do not change with it.
fn uncertainties(
    problem: &DiagnosisProblem<'_>,
    state: &State,
    model: &Model,
) -> Result<Vec<(Option<f64>, f64)>, MismatchError> {
    let mut columns = problem.columns(model)?;
    for column in &mut columns {
        state.whitening.covariance.whiten(column);
    }
    let prior_sd = prior_sd(problem.baseline);
    let known = Information::of_prior(&prior_sd, columns.len() - prior_sd.len());
    let known = known.with(&Information::of_columns(&columns));
    let lengths = known.lengths();
    let used: Vec<usize> = (0..columns.len()).filter(|&i| lengths[i] > 0.0).collect();
    // Columns of unit length: factors and compliances differ by many orders of magnitude.
    let units: Vec<f64> = used.iter().map(|&i| lengths[i].recip()).collect();
    let inverse = known.of_some(&used, &units).inverse();
    let mut out = vec![(None, f64::INFINITY); columns.len()];
    let mut scratch = Vec::new();
    for (place, &column) in used.iter().enumerate() {
        // The estimate is the sum of the white readings with these weights.
        let mut weights = vec![0.0; problem.observations.len()];
        for (other, &from) in used.iter().enumerate() {
            let factor = inverse[(place, other)] * units[other];
            for (weight, value) in weights.iter_mut().zip(&columns[from]) {
                *weight += factor * value;
            }
        }
        let shares = state
            .whitening
            .variance_shares(problem.observations, &weights, &mut scratch);
        out[column] = (
            Some(inverse[(place, place)].sqrt() * units[place]),
            state.noise.degrees_of_freedom(shares),
        );
    }
    Ok(out)
}

/// The likelihood interval of a value; `None` without an end.
///
/// # Arguments
/// - `inside`: where the profiles of it and of the other values were inside: past a kink another's may find a way that its own does not.
fn interval(
    value: &EstimatedValue,
    profile: &ValueProfile,
    inside: impl Iterator<Item = f64> + Clone,
) -> Option<ValueInterval> {
    let [least, most] = profile.bounds;
    let found = |end: usize| match profile.ends[end] {
        ProfileEnd::Closed { value } | ProfileEnd::OpenAtBound { value, .. } => Some(value),
        // Where a profile could not be followed to its end the interval is as wide as its linearisation at least.
        ProfileEnd::Open { value: far, .. } | ProfileEnd::NotFollowed { value: far, .. } => {
            let linear = value.interval_95()?[end].clamp(least, most);
            Some([far.min(linear), far.max(linear)][end])
        }
    };
    // Values that move readings by kinks were searched for, and may stand beside the lowest point.
    let inside = inside.chain([value.value]);
    let low = inside.clone().fold(found(0)?, f64::min);
    let high = inside.fold(found(1)?, f64::max);
    Some(ValueInterval {
        ends: [low, high],
        is_open: [low <= least, high >= most],
    })
}
