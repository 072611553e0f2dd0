//! What a fit yields about its parameters: standard errors, correlations, and which of them it cannot determine.

use crate::statistics::student_t_quantile;

use super::error::LeastSquaresError;
use super::identification::{
    UnidentifiedDirection, WhyNotIdentified, direction, reduce_to_echelon,
};
use super::minimise::LeastSquaresFit;
use super::parameter::{Bound, ParameterSet, ValueSource};
use super::singular_values::{SingularValues, norm};

/// Where the standard deviation of the residuals comes from. There is no default: the two answer different questions.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "lowercase")]
pub enum SigmaMode {
    /// The residuals were divided by standard deviations that are known: the covariance is (JᵀJ)⁻¹, intervals are normal, and a reduced
    /// chi-squared far from 1 is a finding about the model or the standard deviations.
    Known,
    /// The residuals are known up to a common factor, which is estimated from their spread: the covariance is s² (JᵀJ)⁻¹ with s² the
    /// reduced chi-squared, intervals are Student's t with n − p degrees of freedom. It presumes that the model fits.
    Estimated,
}

/// What may be set about the covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CovarianceSettings {
    /// Relative accuracy of the entries of the Jacobian: singular values below this share of the largest one (columns
    /// scaled to length 1) are taken as zero.
    pub jacobian_accuracy: f64,
    /// Pairs with a correlation beyond this are listed.
    pub strong_correlation: f64,
    /// In mode `Known`: degrees of freedom of the standard deviations, infinite if they are exact. Standard deviations that were themselves
    /// estimated from repeats make intervals Student's t with these.
    pub known_dof: f64,
}

/// Correlation beyond which two parameters can hardly be distinguished: each would be known more than three times as well if the other were
/// (variance inflation above 10).
pub const STRONG_CORRELATION: f64 = 0.95;

impl Default for CovarianceSettings {
    /// An error of relative size δ in the entries moves a singular value by up to about δ times the largest (Weyl), so a smaller one
    /// cannot be distinguished from zero. Derivatives of a finite-element solution are good to about 1e-16 times the condition of the
    /// stiffness matrix (1e4 to 1e6 here), hence 1e-10. Formulas written out are better; whoever has them may pass less.
    fn default() -> Self {
        Self {
            jacobian_accuracy: 1e-10,
            strong_correlation: STRONG_CORRELATION,
            known_dof: f64::INFINITY,
        }
    }
}

/// Known properties of a parameter besides its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterStatus {
    /// Determined by the data.
    Free,
    /// Kept by the user.
    Fixed,
    /// A multiple of another parameter.
    Tied,
    /// Ended on a bound, which determines it, not the data; it has no standard error and the others are given for this value.
    AtBound(Bound),
    /// Not determined by the data; the value is where the search happened to be.
    NotIdentified {
        /// Why.
        why: WhyNotIdentified,
    },
}

/// A parameter with its uncertainty; units are the parameter's.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterEstimate {
    /// Name of the parameter.
    pub name: String,
    /// Its value at the end of the fit.
    pub value: f64,
    /// What is known of it.
    pub status: ParameterStatus,
    /// Standard error; absent unless the data determine the parameter (`status` states why).
    pub standard_error: Option<f64>,
    /// 95 % interval from Student's t (or the normal distribution), which takes the minimum for a parabola; not cut at bounds.
    pub interval_95: Option<[f64; 2]>,
}

/// Two parameters that the data can hardly distinguish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrongPair {
    /// Index of the one in the full vector.
    pub first: usize,
    /// Index of the other.
    pub second: usize,
    /// Their correlation.
    pub correlation: f64,
}

/// The second-order statement about a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterCovariance {
    /// Which question was answered.
    pub mode: SigmaMode,
    /// One estimate for each parameter, in the order of the full vector.
    pub estimates: Vec<ParameterEstimate>,
    /// Number of residuals minus rank.
    pub dof: usize,
    /// Degrees of freedom of Student's t in the intervals.
    pub interval_dof: f64,
    /// ‖r‖² over the degrees of freedom; absent without any.
    pub reduced_chi_squared: Option<f64>,
    /// Number of independent combinations the data determine.
    pub rank: usize,
    /// Number of parameters that were to be determined: free and not on a bound.
    pub estimated: usize,
    /// Largest over smallest singular value of the Jacobian with columns of length 1; infinite if the smallest is zero.
    pub condition_number: f64,
    /// What the data cannot see.
    pub unidentified: Vec<UnidentifiedDirection>,
    /// Pairs with a correlation beyond the limit, strongest first.
    pub strong_pairs: Vec<StrongPair>,
    /// For each parameter of the full vector its row in `matrix`, for those that have one.
    rows: Vec<Option<usize>>,
    /// Covariance of the determined parameters, symmetric, row after row.
    matrix: Vec<f64>,
}

impl ParameterCovariance {
    /// Covariance of two free parameters (indices in the full vector); `None` unless the data determine both.
    #[must_use]
    pub fn of(&self, first: usize, second: usize) -> Option<f64> {
        let (a, b) = ((*self.rows.get(first)?)?, (*self.rows.get(second)?)?);
        let size = self.rows.iter().flatten().count();
        self.matrix.get(a * size + b).copied()
    }

    /// Correlation of two free parameters (indices in the full vector); `None` unless the data determine both.
    #[must_use]
    pub fn correlation(&self, first: usize, second: usize) -> Option<f64> {
        let product = self.of(first, first)?.sqrt() * self.of(second, second)?.sqrt();
        Some(self.of(first, second)? / product)
    }
}

/// Covariance, standard errors and identifiability at the end of a fit.
///
/// Parameters on a bound are taken as fixed there. (JᵀJ)⁻¹ comes from the singular values of J with columns of length 1, never
/// from JᵀJ itself. If some combination is not determined, the parameters outside it keep their standard errors.
///
/// # Errors
/// `NoDegreesOfFreedom` in mode `Estimated` if no residuals are left over to estimate their spread from.
///
/// # Source
/// Seber and Wild, Nonlinear Regression (1989), eqs. (2.21) and (5.2); Björck, Numerical Methods for Least Squares Problems (1996),
/// section 2.8, for the covariance from a factor of J.
pub fn covariance(
    set: &ParameterSet,
    fit: &LeastSquaresFit,
    mode: SigmaMode,
    settings: &CovarianceSettings,
) -> Result<ParameterCovariance, LeastSquaresError> {
    let spectrum = Spectrum::of(set, fit, settings);
    let rank = spectrum.kept.len();
    let dof = fit.residuals.len().saturating_sub(rank);
    let reduced_chi_squared = (dof > 0).then(|| fit.sum_of_squares() / dof as f64);
    let variance = match (mode, reduced_chi_squared) {
        (SigmaMode::Known, _) => 1.0,
        (SigmaMode::Estimated, Some(s2)) => s2,
        (SigmaMode::Estimated, None) => {
            return Err(LeastSquaresError::NoDegreesOfFreedom {
                residuals: fit.residuals.len(),
                estimated: rank,
            });
        }
    };
    let unidentified = spectrum.unidentified(set);
    let why = why_not(&unidentified, set.parameters().len());
    let determined: Vec<usize> = (0..spectrum.columns.len())
        .filter(|&c| why[spectrum.columns[c].0].is_none())
        .collect();
    let mut rows = vec![None; set.parameters().len()];
    for (row, &c) in determined.iter().enumerate() {
        rows[spectrum.columns[c].0] = Some(row);
    }
    let mut result = ParameterCovariance {
        mode,
        estimates: Vec::new(),
        dof,
        interval_dof: match mode {
            SigmaMode::Known => settings.known_dof,
            SigmaMode::Estimated => dof as f64,
        },
        reduced_chi_squared,
        rank,
        estimated: spectrum.columns.len(),
        condition_number: spectrum.condition_number(),
        unidentified,
        strong_pairs: Vec::new(),
        matrix: spectrum.matrix(&determined, variance),
        rows,
    };
    result.estimates = estimates(set, fit, &result, &why);
    result.strong_pairs = strong_pairs(&result, settings.strong_correlation);
    Ok(result)
}

/// The singular values of the scaled Jacobian of the parameters that are free and not on a bound.
struct Spectrum {
    /// (index in the full vector, length of the column; 0 is not scaled by).
    columns: Vec<(usize, f64)>,
    decomposition: SingularValues,
    kept: Vec<usize>,
    dropped: Vec<usize>,
}

impl Spectrum {
    fn of(set: &ParameterSet, fit: &LeastSquaresFit, settings: &CovarianceSettings) -> Self {
        let chosen: Vec<(usize, &[f64])> = set
            .free_indices()
            .iter()
            .enumerate()
            .filter(|&(free, _)| fit.at_bound[free].is_none())
            .filter_map(|(free, &index)| Some((index, fit.jacobian_column(free)?)))
            .collect();
        let mut decomposition = SingularValues::default();
        decomposition.reshape(fit.residuals.len(), chosen.len());
        let mut columns = Vec::with_capacity(chosen.len());
        for (place, &(index, column)) in chosen.iter().enumerate() {
            let length = norm(column);
            let divisor = if length == 0.0 { 1.0 } else { length };
            for (entry, derivative) in decomposition.column_mut(place).iter_mut().zip(column) {
                *entry = derivative / divisor;
            }
            columns.push((index, length));
        }
        decomposition.right_hand_side_mut().fill(0.0);
        decomposition.decompose();
        let largest = decomposition.values().iter().copied().fold(0.0, f64::max);
        // Rounding alone accounts for a few epsilons a column, whatever accuracy was asked for.
        let share = settings
            .jacobian_accuracy
            .max(chosen.len() as f64 * f64::EPSILON);
        let (kept, dropped) =
            (0..chosen.len()).partition(|&j| decomposition.values()[j] > share * largest);
        Self {
            columns,
            decomposition,
            kept,
            dropped,
        }
    }

    fn condition_number(&self) -> f64 {
        let values = self.decomposition.values();
        let largest = values.iter().copied().fold(0.0, f64::max);
        let smallest = values.iter().copied().fold(largest, f64::min);
        if largest == 0.0 {
            f64::INFINITY
        } else {
            largest / smallest
        }
    }

    fn unidentified(&self, set: &ParameterSet) -> Vec<UnidentifiedDirection> {
        let mut vectors: Vec<Vec<f64>> = self
            .dropped
            .iter()
            .map(|&j| self.decomposition.right_vector(j).to_vec())
            .collect();
        reduce_to_echelon(&mut vectors);
        let columns: Vec<(usize, &str, f64)> = self
            .columns
            .iter()
            .map(|&(index, length)| (index, set.parameters()[index].name.as_str(), length))
            .collect();
        vectors
            .iter()
            .map(|vector| direction(vector, &columns))
            .collect()
    }

    /// variance × C⁻¹ V S⁻² Vᵀ C⁻¹ for some of the columns, C their lengths.
    fn matrix(&self, determined: &[usize], variance: f64) -> Vec<f64> {
        let mut matrix = Vec::with_capacity(determined.len() * determined.len());
        for &a in determined {
            for &b in determined {
                let sum: f64 = self
                    .kept
                    .iter()
                    .map(|&j| {
                        let (v, s) = (
                            self.decomposition.right_vector(j),
                            self.decomposition.values()[j],
                        );
                        (v[a] / s) * (v[b] / s)
                    })
                    .sum();
                matrix.push(variance * sum / (self.columns[a].1 * self.columns[b].1));
            }
        }
        matrix
    }
}

/// For each parameter of the full vector the direction it is lost in, if it is.
fn why_not(unidentified: &[UnidentifiedDirection], count: usize) -> Vec<Option<WhyNotIdentified>> {
    let mut why = vec![None; count];
    for (direction, found) in unidentified.iter().enumerate() {
        let alone = found.components.len() == 1;
        for component in &found.components {
            why[component.parameter].get_or_insert(if alone {
                WhyNotIdentified::NoEffect
            } else {
                WhyNotIdentified::OnlyInCombination { direction }
            });
        }
    }
    why
}

fn estimates(
    set: &ParameterSet,
    fit: &LeastSquaresFit,
    result: &ParameterCovariance,
    why: &[Option<WhyNotIdentified>],
) -> Vec<ParameterEstimate> {
    let factor = student_t_quantile(0.975, result.interval_dof);
    let of_free = |free: usize| {
        let index = set.free_indices()[free];
        let status = match (fit.at_bound[free], why[index]) {
            (Some(bound), _) => ParameterStatus::AtBound(bound),
            (None, Some(why)) => ParameterStatus::NotIdentified { why },
            (None, None) => ParameterStatus::Free,
        };
        (status, result.of(index, index).map(f64::sqrt))
    };
    set.parameters()
        .iter()
        .enumerate()
        .map(|(index, parameter)| {
            let (status, standard_error) = match set.source(index) {
                ValueSource::Constant { .. } => (ParameterStatus::Fixed, None),
                ValueSource::Free { free } => of_free(free),
                ValueSource::Multiple { free, ratio } => (
                    ParameterStatus::Tied,
                    of_free(free).1.map(|error| error * ratio.abs()),
                ),
            };
            let value = fit.values[index];
            let half = standard_error
                .zip(factor)
                .map(|(error, factor)| error * factor);
            ParameterEstimate {
                name: parameter.name.clone(),
                value,
                status,
                standard_error,
                interval_95: half.map(|half| [value - half, value + half]),
            }
        })
        .collect()
}

fn strong_pairs(result: &ParameterCovariance, limit: f64) -> Vec<StrongPair> {
    let count = result.rows.len();
    let mut pairs: Vec<StrongPair> = (0..count)
        .flat_map(|first| (first + 1..count).map(move |second| (first, second)))
        .filter_map(|(first, second)| {
            let correlation = result.correlation(first, second)?;
            (correlation.abs() > limit).then_some(StrongPair {
                first,
                second,
                correlation,
            })
        })
        .collect();
    pairs.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
    pairs
}

#[cfg(test)]
mod tests;
