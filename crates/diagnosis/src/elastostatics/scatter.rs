//! How displacements and rotations scatter: from repeats where there are any, else from what a fit leaves.

use super::posed::{PosedLoad, PosedLoadCases, ReadComponent};
use crate::search::{Covariance, LowRankBlock};

/// Loads that differ by less than this share of the larger are one load applied again.
const SAME_LOAD: f64 = 0.05;

/// Scatter, as a share of the usual size of a component, below which weights do not grow: a simulation without noise has none.
pub(super) const LEAST_SCATTER: f64 = 1e-9;

/// Sums of squares of displacements and of rotations, with their degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ScatterSums {
    /// Of displacements, m², and of rotations, rad².
    squares: [f64; 2],
    dof: [f64; 2],
}

/// Rows that hold one component under one load in one pose, each as often as it was read.
pub(super) fn repeated_rows(posed: &PosedLoadCases) -> Vec<Vec<usize>> {
    let mut groups: Vec<(&PosedLoad, &ReadComponent, Vec<usize>)> = Vec::new();
    for (row, (case, read)) in posed.rows().enumerate() {
        let known = groups.iter_mut().find(|(first, component, _)| {
            (first.label, first.pose) == (case.label, case.pose)
                && component.unit == read.unit
                && is_same_load(&first.load, &case.load)
        });
        match known {
            Some((.., rows)) => rows.push(row),
            None => groups.push((case, read, vec![row])),
        }
    }
    groups.into_iter().map(|(.., rows)| rows).collect()
}

impl ScatterSums {
    /// From the differences between repeats of one load in one pose; what a model predicts for the loads' differences is taken off.
    pub(super) fn of_repeats(posed: &PosedLoadCases, residuals: &[f64]) -> Self {
        let kinds: Vec<usize> = posed
            .rows()
            .map(|(_, read)| usize::from(read.is_rotation()))
            .collect();
        let mut sums = Self::default();
        for rows in repeated_rows(posed) {
            let kind = kinds[rows[0]];
            let mean = rows.iter().map(|row| residuals[*row]).sum::<f64>() / rows.len() as f64;
            let squares = rows.iter().map(|row| (residuals[*row] - mean).powi(2));
            sums.squares[kind] += squares.sum::<f64>();
            sums.dof[kind] += rows.len() as f64 - 1.0;
        }
        sums
    }

    /// From what a fit leaves of the rows that took part; its parameters are counted against both kinds in proportion to their rows.
    pub(super) fn of_residuals(
        posed: &PosedLoadCases,
        residuals: &[f64],
        takes_part: &[bool],
        parameters: usize,
    ) -> Self {
        let mut sums = Self::default();
        let rows = posed.rows().zip(residuals).zip(takes_part);
        for (((_, read), residual), _) in rows.filter(|(_, takes_part)| **takes_part) {
            let kind = usize::from(read.is_rotation());
            sums.squares[kind] += residual * residual;
            sums.dof[kind] += 1.0;
        }
        let all: f64 = sums.dof.iter().sum();
        if all > 0.0 {
            for dof in &mut sums.dof {
                *dof *= (1.0 - parameters as f64 / all).max(0.0);
            }
        }
        sums
    }

    /// Whether every kind that was read has at least one degree of freedom.
    pub(super) fn serves(&self, posed: &PosedLoadCases) -> bool {
        [false, true].into_iter().all(|rotation| {
            let is_read = posed.rows().any(|(_, read)| read.is_rotation() == rotation);
            !is_read || self.dof[usize::from(rotation)] >= 1.0
        })
    }

    /// Degrees of freedom of both kinds.
    pub(super) fn dof(&self) -> f64 {
        self.dof.iter().sum()
    }

    /// Standard deviation of displacements, m, and of rotations, rad; `None` of what was not read.
    pub(super) fn standard_deviations(&self) -> [Option<f64>; 2] {
        [0, 1].map(|kind| {
            let dof = self.dof[kind];
            (dof > 0.0).then(|| (self.squares[kind] / dof).sqrt())
        })
    }

    /// One over the standard deviation of each row; of rows that do not scatter, one over `least`.
    pub(super) fn weights(&self, posed: &PosedLoadCases, least: [f64; 2]) -> Vec<f64> {
        let of_kind: Vec<f64> = self
            .standard_deviations()
            .into_iter()
            .zip(least)
            .map(|(sd, least)| 1.0 / sd.unwrap_or(least).max(least))
            .collect();
        let rows = posed.rows();
        rows.map(|(_, read)| of_kind[usize::from(read.is_rotation())])
            .collect()
    }
}

/// Root mean square of displacements, m, and of rotations, rad; one of what was not read.
pub(super) fn sizes(posed: &PosedLoadCases) -> [f64; 2] {
    [false, true].map(|rotation| {
        let values: Vec<f64> = posed
            .rows()
            .filter(|(_, read)| read.is_rotation() == rotation)
            .map(|(_, read)| read.value)
            .collect();
        let squares: f64 = values.iter().map(|value| value * value).sum();
        let size = (squares / values.len().max(1) as f64).sqrt();
        if size > 0.0 { size } else { 1.0 }
    })
}

/// Scatter of repeats whose displacement as a whole varies from application to application, as that of a load whose size varies does.
///
/// ```text
///   residual of a case = mean + (error of each component) + slope v,    v = displacement and rotation that were read
/// ```
///
/// Restricted maximum likelihood over the repeats by expectation and maximisation (McLachlan & Krishnan, The EM Algorithm, 2008, section
/// 5.9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SlopeScatter {
    /// Standard deviations of the errors of displacements, m, and of rotations, rad; one of what was not read.
    pub(super) sd: [f64; 2],
    /// Standard deviation of the slope (1).
    pub(super) slope_sd: f64,
}

/// Differences between repeats of one load in one pose.
struct RepeatedCase {
    /// Kind of each component.
    kinds: Vec<usize>,
    /// Mean of each component over the repeats.
    mean: Vec<f64>,
    /// Independent contrasts of the residuals of the repeats, each as long as `kinds`.
    contrasts: Vec<Vec<f64>>,
}

impl SlopeScatter {
    /// # Arguments
    /// - `sd`: where the search starts.
    /// - `least`: standard deviations below which nothing is asked.
    pub(super) fn of_repeats(
        posed: &PosedLoadCases,
        residuals: &[f64],
        sd: [f64; 2],
        least: [f64; 2],
    ) -> Self {
        /// Rounds: the slope is known to some percent at best.
        const ROUNDS: usize = 100;
        /// Where the slope starts: a load is seldom applied better.
        const FIRST: f64 = 0.001;
        let cases = repeated_cases(posed, residuals);
        let mut scatter = Self {
            sd,
            slope_sd: FIRST,
        };
        for _ in 0..ROUNDS {
            let (mut slopes, mut count) = (0.0, 0.0);
            let (mut squares, mut of_kind) = ([0.0; 2], [0.0; 2]);
            for case in &cases {
                let product = |other: &[f64]| -> f64 {
                    let terms = case.kinds.iter().zip(&case.mean).zip(other);
                    terms
                        .map(|((kind, mean), other)| mean * other / scatter.sd[*kind].powi(2))
                        .sum()
                };
                let variance = (scatter.slope_sd.powi(-2) + product(&case.mean)).recip();
                for contrast in &case.contrasts {
                    let slope = variance * product(contrast);
                    slopes += slope * slope + variance;
                    count += 1.0;
                    for ((kind, mean), value) in case.kinds.iter().zip(&case.mean).zip(contrast) {
                        squares[*kind] += (value - slope * mean).powi(2) + variance * mean * mean;
                        of_kind[*kind] += 1.0;
                    }
                }
            }
            if count == 0.0 {
                return Self { sd, slope_sd: 0.0 };
            }
            // A slope of exactly zero would stay there.
            scatter.slope_sd = f64::max(slopes / count, f64::MIN_POSITIVE).sqrt();
            for kind in 0..2 {
                if of_kind[kind] > 0.0 {
                    scatter.sd[kind] = f64::max(squares[kind] / of_kind[kind], 0.0).sqrt();
                }
                scatter.sd[kind] = scatter.sd[kind].max(least[kind]);
            }
        }
        scatter
    }

    /// The covariance of all rows.
    pub(super) fn covariance(&self, posed: &PosedLoadCases) -> Covariance {
        let rows: Vec<&ReadComponent> = posed.rows().map(|(_, read)| read).collect();
        let variances: Vec<f64> = rows
            .iter()
            .map(|read| self.sd[usize::from(read.is_rotation())].powi(2))
            .collect();
        let mut first = 0;
        let blocks = posed.cases.iter().map(|case| {
            let rows = first..first + case.components.len();
            first = rows.end;
            let columns = case.components.iter();
            LowRankBlock {
                rows,
                columns: columns.map(|read| self.slope_sd * read.value).collect(),
            }
        });
        Covariance::new(&variances, blocks)
    }
}

/// Loads that were applied several times with the same components read.
fn repeated_cases(posed: &PosedLoadCases, residuals: &[f64]) -> Vec<RepeatedCase> {
    let mut groups: Vec<Vec<(&PosedLoad, &[f64])>> = Vec::new();
    let mut rest = residuals;
    for case in &posed.cases {
        let Some((own, further)) = rest.split_at_checked(case.components.len()) else {
            break;
        };
        rest = further;
        let is_repeat = |first: &PosedLoad| {
            let components = first.components.iter().zip(&case.components);
            (first.label, first.pose) == (case.label, case.pose)
                && first.components.len() == case.components.len()
                && components.into_iter().all(|(a, b)| a.unit == b.unit)
                && is_same_load(&first.load, &case.load)
        };
        match groups.iter_mut().find(|group| is_repeat(group[0].0)) {
            Some(group) => group.push((case, own)),
            None => groups.push(vec![(case, own)]),
        }
    }
    let repeated = groups.iter().filter(|group| group.len() > 1);
    repeated.map(|group| contrasts(group)).collect()
}

/// Helmert contrasts of the repeats.
fn contrasts(group: &[(&PosedLoad, &[f64])]) -> RepeatedCase {
    let components = &group[0].0.components;
    let count = group.len() as f64;
    let mean_of = |component: usize| {
        let values = group
            .iter()
            .map(|(case, _)| case.components[component].value);
        values.sum::<f64>() / count
    };
    let contrast = |repeat: usize| {
        let before = repeat as f64;
        let scale = (before * (before + 1.0)).sqrt().recip();
        let value = |component: usize| {
            let earlier = group[..repeat].iter().map(|(_, own)| own[component]);
            scale * (earlier.sum::<f64>() - before * group[repeat].1[component])
        };
        (0..components.len()).map(value).collect()
    };
    RepeatedCase {
        kinds: components
            .iter()
            .map(|read| usize::from(read.is_rotation()))
            .collect(),
        mean: (0..components.len()).map(mean_of).collect(),
        contrasts: (1..group.len()).map(contrast).collect(),
    }
}

fn is_same_load(one: &[f64; 6], other: &[f64; 6]) -> bool {
    [0, 3].into_iter().all(|first| {
        let length = |of: &dyn Fn(usize) -> f64| -> f64 {
            (first..first + 3)
                .map(|place| of(place).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let larger = length(&|place| one[place]).max(length(&|place| other[place]));
        length(&|place| one[place] - other[place]) <= SAME_LOAD * larger
    })
}
