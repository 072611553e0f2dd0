//! How large a score must be before it is believed: the maxima of families of candidates over null samples.

use std::collections::BTreeMap;

use rayon::prelude::*;

use stiffbench_numeric::statistics::normal_upper_tail;

use super::constants::{COUNTED, DESIGN_LENGTH, SAMPLES_TOGETHER};

/// Share of null samples by which the number of independent shapes of a family is counted (1): 100 samples. By hand (103a3a2).
const TAIL: f64 = 0.01;

/// No critical value of Δχ² is lower: a likelihood ratio of 20. A loose member has no size to be fitted, and one that changes next to
/// nothing would pass by next to nothing. By hand (6e1a649).
const LEAST_CRITICAL_VALUE: f64 = 6.0;

/// Values of a statistic on noise alone.
#[derive(Debug, Clone, PartialEq)]
pub struct NullDistribution {
    sorted: Vec<f64>,
}

impl NullDistribution {
    /// The distribution of some samples.
    #[must_use]
    pub fn new(mut samples: Vec<f64>) -> Self {
        samples.par_sort_unstable_by(f64::total_cmp);
        Self { sorted: samples }
    }

    /// Chance that noise alone reaches a value (1).
    ///
    /// Beyond the last few samples these show nothing: there the chance falls as that of χ² with one degree of freedom does.
    #[must_use]
    pub fn p(&self, value: f64) -> f64 {
        let count = self.sorted.len();
        let above = count - self.sorted.partition_point(|known| *known < value);
        let counted = |above: usize| (above as f64 + 1.0) / (count as f64 + 1.0);
        if above >= COUNTED || count <= COUNTED {
            return counted(above);
        }
        let last = self.sorted[count - COUNTED];
        let tail = |value: f64| normal_upper_tail(value.max(0.0).sqrt());
        counted(COUNTED) * tail(value) / tail(last).max(f64::MIN_POSITIVE)
    }

    /// The value that a share of the samples does not exceed; beyond the last, the last; infinite without samples.
    #[must_use]
    pub fn quantile(&self, share: f64) -> f64 {
        if self.sorted.is_empty() {
            return f64::INFINITY;
        }
        let place = (share * self.sorted.len() as f64).ceil() as usize;
        self.sorted[place.clamp(1, self.sorted.len()) - 1]
    }

    /// How many independent shapes would exceed a large value as often: for z the root of a high quantile, its level over 2 Φ(-z).
    fn independent_shapes(&self) -> f64 {
        let z = self.quantile(1.0 - TAIL).max(0.0).sqrt();
        TAIL / (2.0 * normal_upper_tail(z)).max(f64::MIN_POSITIVE)
    }
}

/// Critical values of families of candidates, of which noise alone exceeds any with the chance of one level.
#[derive(Debug, Clone, PartialEq)]
pub struct CriticalValues<F> {
    /// For each family: Δχ² that noise alone reaches with the family's share of the level.
    pub values: BTreeMap<F, f64>,
    /// Chance that noise alone exceeds the value of each family.
    pub levels: BTreeMap<F, f64>,
    /// Chance that noise alone exceeds any.
    level: f64,
    maxima: BTreeMap<F, NullDistribution>,
}

impl<F: Ord + Copy + Sync> CriticalValues<F> {
    /// Splits a level between families so that most candidates are found.
    ///
    /// Of all ways to split a level that one is taken which finds the most candidates at the design length μ: where a little more level
    /// would help each family as much. A family whose null samples exceed z² as often as m independent shapes, 2 m Φ(-z), is found with the
    /// chance Φ(μ - z); that of the derivatives is exp(μ z)/m up to a constant, so that
    ///
    /// ```text
    /// z = z₁ + ln(m)/μ
    /// ```
    ///
    /// with one z₁ for all families (the optimal weights of Roeder & Wasserman, Statistical Science 24, 2009, p. 398, for one size of
    /// effect).
    ///
    /// # Arguments
    /// - `maxima`: for each family its largest Δχ² in each null sample.
    #[must_use]
    pub fn calibrate(families: &[F], maxima: &[Vec<f64>], level: f64) -> Self {
        let distributions: Vec<NullDistribution> = maxima
            .par_iter()
            .map(|samples| NullDistribution::new(samples.clone()))
            .collect();
        let further: Vec<f64> = distributions
            .iter()
            .map(|samples| samples.independent_shapes().ln() / DESIGN_LENGTH)
            .collect();
        let values_at = |z: f64| -> Vec<f64> {
            let of_family = |further: &f64| (z + further).max(0.0).powi(2);
            let values = further.iter().map(of_family);
            values
                .map(|value| value.max(LEAST_CRITICAL_VALUE))
                .collect()
        };
        let count = maxima.first().map_or(0, Vec::len);
        let exceeding = |values: &[f64]| {
            let exceeds = |&sample: &usize| {
                let mut both = maxima.iter().zip(values);
                both.any(|(maxima, value)| maxima[sample] > *value)
            };
            let samples = (0..count).into_par_iter().with_min_len(SAMPLES_TOGETHER);
            samples.filter(exceeds).count() as f64 / count.max(1) as f64
        };
        let (mut low, mut high) = (0.0, 20.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if exceeding(&values_at(middle)) > level {
                low = middle;
            } else {
                high = middle;
            }
        }
        let values = values_at(high);
        let levels = distributions.iter().zip(&values);
        let levels: Vec<f64> = levels.map(|(samples, value)| samples.p(*value)).collect();
        Self {
            values: families.iter().copied().zip(values).collect(),
            levels: families.iter().copied().zip(levels).collect(),
            level,
            maxima: families.iter().copied().zip(distributions).collect(),
        }
    }

    /// Families calibrated apart, each to a level of its own: the chances of all are scaled to the sum of the levels.
    #[must_use]
    pub fn together(parts: impl IntoIterator<Item = Self>) -> Self {
        let mut whole = Self {
            values: BTreeMap::new(),
            levels: BTreeMap::new(),
            level: 0.0,
            maxima: BTreeMap::new(),
        };
        for part in parts {
            whole.values.extend(part.values);
            whole.levels.extend(part.levels);
            whole.maxima.extend(part.maxima);
            whole.level += part.level;
        }
        whole
    }

    /// The critical value of a family; of one that had no shape in the null samples, the highest of all.
    #[must_use]
    pub fn of(&self, family: F) -> f64 {
        let highest = || self.values.values().copied().fold(0.0, f64::max);
        self.values.get(&family).copied().unwrap_or_else(highest)
    }

    /// Chance that noise alone gives a family this Δχ² or, for another family, one as rare.
    #[must_use]
    pub fn p(&self, family: F, delta_chi2: f64) -> f64 {
        let Some(maxima) = self.maxima.get(&family) else {
            return 1.0;
        };
        let share = self.levels.get(&family).copied().unwrap_or(1.0);
        // As many times rarer than its level, out of the whole level.
        (maxima.p(delta_chi2) / share * self.level).min(1.0)
    }
}
