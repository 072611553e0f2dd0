//! How displacements and rotations scatter: from repeats where there are any, else from what a fit leaves.

use std::ops::Range;

use indexmap::IndexMap;
use stiffbench_numeric::statistics::root_mean_square;

use stiffbench_units_and_text::load_direction::LoadDirection;

use super::posed::{PosedLoad, PosedLoadCases, ReadComponent};
use crate::mismatch::{GaugeSteps, ReadingNoise};
use crate::search::constants::ROUNDING;
use crate::search::dot;

/// Loads that differ by less than this share of the larger are one load applied again.
pub(super) const SAME_LOAD: f64 = 0.05;

/// Scatter, as a share of the usual size of a component, below which weights do not grow: a simulation without noise has none.
pub(super) const LEAST_SCATTER: f64 = 1e-9;

/// Rows that hold one component under one load in one pose, each as often as it was read.
pub(super) fn repeated_rows(posed: &PosedLoadCases) -> Vec<Vec<usize>> {
    struct Repeated<'p> {
        load: [f64; 6],
        read: &'p ReadComponent,
        rows: Vec<usize>,
    }
    let mut groups: IndexMap<(usize, usize), Vec<Repeated<'_>>> = IndexMap::new();
    for (row, (case, read)) in posed.rows().enumerate() {
        let groups = groups.entry((case.label, case.pose)).or_default();
        let known = groups
            .iter_mut()
            .find(|known| known.read.unit == read.unit && is_same_load(&known.load, &case.load));
        match known {
            Some(known) => known.rows.push(row),
            None => groups.push(Repeated {
                load: case.load,
                read,
                rows: vec![row],
            }),
        }
    }
    let mut rows: Vec<Vec<usize>> = groups
        .into_values()
        .flatten()
        .map(|known| known.rows)
        .collect();
    rows.sort_by_key(|rows| rows[0]);
    rows
}

/// Root mean square of displacements, m, and of rotations, rad; one of what was not read.
pub(super) fn sizes(posed: &PosedLoadCases) -> [f64; 2] {
    [false, true].map(|rotation| {
        let rows = posed.rows();
        let own = rows.filter(|(_, read)| read.is_rotation() == rotation);
        let size = root_mean_square(own.map(|(_, read)| read.value));
        size.filter(|size| *size > 0.0).unwrap_or(1.0)
    })
}

/// How load cases scatter: each component by itself, and all that was read under a load together, because the size of a load and the
/// slope of a run vary from application to application. Soft cells scatter more than stiff ones by that.
///
/// ```text
///   residual of a case = mean + (error of each component) + slope v,    v = displacement and rotation under the load
/// ```
///
/// Restricted maximum likelihood over the repeats by expectation and maximisation (McLachlan & Krishnan, The EM Algorithm, 2008, section
/// 5.9). Residuals of a fit do not tell both apart from what the model lacks: they give the first part alone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LoadScatter {
    /// Standard deviations of the errors of displacements, m, and of rotations, rad; `None` of what was not read.
    pub(super) sd: [Option<f64>; 2],
    /// Standard deviation of the slope (1).
    pub(super) slope_sd: f64,
    /// Degrees of freedom.
    pub(super) dof: f64,
}

/// What was read together, and how far it is off.
#[derive(Debug, Clone)]
pub(super) struct ScatterCase {
    /// Kind of each component: 0 of displacements, 1 of rotations.
    pub(super) kinds: Vec<usize>,
    /// Each component without error.
    pub(super) values: Vec<f64>,
    /// Independent errors of the case, each as long as `kinds`.
    pub(super) errors: Vec<Vec<f64>>,
    /// Degrees of freedom of each of them.
    pub(super) dof: f64,
}

impl LoadScatter {
    /// From the differences between repeats of one load in one pose; `None` if a kind that was read has no degree of freedom.
    pub(super) fn of_repeats(posed: &PosedLoadCases, residuals: &[f64]) -> Option<Self> {
        let kinds = kinds(posed);
        let groups = repeated_rows(posed).into_iter();
        let parts = groups.map(|rows| {
            let mean = rows.iter().map(|row| residuals[*row]).sum::<f64>() / rows.len() as f64;
            let squares = rows.iter().map(|row| (residuals[*row] - mean).powi(2));
            (
                kinds[rows[0]],
                squares.sum::<f64>(),
                rows.len() as f64 - 1.0,
            )
        });
        let scatter = Self::pooled(parts, 1.0);
        if kinds.iter().any(|kind| scatter.sd[*kind].is_none()) {
            return None;
        }
        let cases = repeated_cases(posed, residuals);
        // The size of an absolute position says nothing of its load.
        if posed.has_positions() || cases.is_empty() {
            return Some(scatter);
        }
        let with_slope = Self::of_cases(&cases, least_scatter(posed));
        Some(Self {
            sd: [0, 1].map(|kind| with_slope.sd[kind].or(scatter.sd[kind])),
            dof: scatter.dof,
            ..with_slope
        })
    }

    /// From what a fit leaves of the rows that took part; its parameters are counted against both kinds in proportion to their rows.
    pub(super) fn of_residuals(
        posed: &PosedLoadCases,
        residuals: &[f64],
        takes_part: &[bool],
        parameters: usize,
    ) -> Self {
        let all = takes_part.iter().filter(|takes_part| **takes_part).count();
        let share = (1.0 - parameters as f64 / all.max(1) as f64).max(0.0);
        let kinds = kinds(posed);
        let rows = (0..residuals.len()).filter(|row| takes_part[*row]);
        let parts = rows.map(|row| (kinds[row], residuals[row].powi(2), 1.0));
        Self::pooled(parts, share)
    }

    /// Without a slope, from kinds, sums of squares and their degrees of freedom, of which only a share counts.
    fn pooled(parts: impl Iterator<Item = (usize, f64, f64)>, share: f64) -> Self {
        let (mut squares, mut dof) = ([0.0; 2], [0.0; 2]);
        for (kind, own, own_dof) in parts {
            squares[kind] += own;
            dof[kind] += own_dof;
        }
        dof = dof.map(|dof: f64| dof * share);
        Self {
            sd: [0, 1].map(|kind| (dof[kind] > 0.0).then(|| f64::sqrt(squares[kind] / dof[kind]))),
            slope_sd: 0.0,
            dof: dof.iter().sum(),
        }
    }

    /// Divides the scatter of cases into both parts.
    ///
    /// # Arguments
    /// - `least`: standard deviations below which nothing is asked of displacements and rotations.
    pub(super) fn of_cases(cases: &[ScatterCase], least: [f64; 2]) -> Self {
        /// Rounds: the slope is known to some percent at best.
        const ROUNDS: usize = 100;
        let (mut sd, mut slope_sd) = ([f64::INFINITY; 2], 0.0);
        let mut dof = [0.0; 2];
        for round in 0..=ROUNDS {
            let (mut slopes, mut count) = (0.0, 0.0);
            let (mut squares, mut sizes) = ([0.0; 2], 0.0);
            dof = [0.0; 2];
            for case in cases {
                let product = |other: &[f64]| -> f64 {
                    let terms = case.kinds.iter().zip(&case.values).zip(other);
                    terms
                        .map(|((kind, value), other)| value * other / sd[*kind].powi(2))
                        .sum()
                };
                // Without a slope in the first round.
                let variance = f64::recip(f64::powi(slope_sd, -2) + product(&case.values));
                for errors in &case.errors {
                    let slope = variance * product(errors);
                    slopes += case.dof * (slope * slope + variance);
                    count += case.dof;
                    for ((kind, value), error) in case.kinds.iter().zip(&case.values).zip(errors) {
                        let own = (error - slope * value).powi(2) + variance * value * value;
                        squares[*kind] += case.dof * own;
                        sizes += case.dof * value * value;
                        dof[*kind] += case.dof;
                    }
                }
            }
            for kind in 0..2 {
                sd[kind] = f64::sqrt(squares[kind] / f64::max(dof[kind], f64::MIN_POSITIVE));
                sd[kind] = sd[kind].max(least[kind]);
            }
            // The slope starts where all would be its; one of exactly zero would stay there.
            slope_sd = match round {
                0 => f64::min(f64::sqrt((squares[0] + squares[1]) / sizes), 1.0),
                _ => f64::max(slopes / count, f64::MIN_POSITIVE).sqrt(),
            };
        }
        Self {
            sd: [0, 1].map(|kind| (dof[kind] > 0.0).then_some(sd[kind])),
            slope_sd,
            dof: dof.iter().sum(),
        }
    }

    /// The variance of a value of this kind, and the square of its size.
    pub(super) fn variance(&self, kind: usize, size: f64) -> f64 {
        self.sd[kind].unwrap_or_default().powi(2) + self.slope_sd.powi(2) * size
    }

    /// The scatter of all rows.
    ///
    /// # Arguments
    /// - `values`: every row as it is without error.
    pub(super) fn of_rows(&self, posed: &PosedLoadCases, values: &[f64]) -> RowScatter {
        let least = least_scatter(posed);
        let sd = [0, 1].map(|kind| self.sd[kind].unwrap_or_default().max(least[kind]));
        RowScatter {
            weights: kinds(posed).iter().map(|kind| sd[*kind].recip()).collect(),
            shared: values.iter().map(|value| self.slope_sd * value).collect(),
            cases: posed
                .cases
                .iter()
                .map(|case| case.components.len())
                .collect(),
        }
    }
}

/// Kind of each row: 0 of displacements, 1 of rotations.
pub(super) fn kinds(posed: &PosedLoadCases) -> Vec<usize> {
    let rows = posed.rows();
    rows.map(|(_, read)| usize::from(read.is_rotation()))
        .collect()
}

/// How rows scatter, each by itself and together with the others of its load case.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct RowScatter {
    /// One over the standard deviation of each row by itself; zero of a row that takes no part.
    pub(super) weights: Vec<f64>,
    /// The standard deviation of each row that it shares with its load case, signed.
    shared: Vec<f64>,
    /// Number of rows of each load case.
    cases: Vec<usize>,
}

impl RowScatter {
    /// The scatter of load cases under the noise of a session: of each row its own, and what an error of the load moves, common to the rows of a
    /// case.
    ///
    /// # Arguments
    /// - `predicted`: every row as it is without error.
    pub(super) fn of_noise(
        posed: &PosedLoadCases,
        steps: GaugeSteps,
        noise: &ReadingNoise,
        predicted: &[f64],
    ) -> Self {
        let force_step_n = steps.force_n.unwrap_or(0.0);
        let force_variance = force_step_n * force_step_n / 12.0 + noise.gauges.force_sd_n.powi(2);
        let mut scatter = Self::default();
        let mut rows = predicted.iter();
        for case in &posed.cases {
            let amount = LoadDirection::of_wrench(case.load).map_or(0.0, |(_, amount)| amount);
            // Of the load, as a share of it.
            let common = if amount == 0.0 {
                0.0
            } else {
                (noise.run_slope_sd.powi(2) + force_variance / (amount * amount)).sqrt()
            };
            for (read, predicted) in case.components.iter().zip(&mut rows) {
                let own = noise.own_variance(&read.read_axis(), *predicted)
                    + (noise.gauges.own_slope_sd * predicted).powi(2);
                scatter.weights.push(own.sqrt().recip());
                scatter.shared.push(common * predicted);
            }
            scatter.cases.push(case.components.len());
        }
        scatter
    }

    /// Mean share of what a case has in common in the variance of its rows.
    pub(super) fn common_share(&self) -> f64 {
        let rows = self.weights.iter().zip(&self.shared);
        let shares = rows.map(|(weight, shared)| {
            let common = (weight * shared).powi(2);
            common / (1.0 + common)
        });
        shares.sum::<f64>() / self.weights.len().max(1) as f64
    }

    /// The same without some rows.
    pub(super) fn without(&self, is_left_out: impl Fn(usize) -> bool) -> Self {
        let mut without = self.clone();
        for (row, weight) in without.weights.iter_mut().enumerate() {
            if is_left_out(row) {
                *weight = 0.0;
            }
        }
        without
    }

    /// One over the standard deviation of a row by itself.
    pub(super) fn weight(&self, row: usize) -> f64 {
        self.weights[row]
    }

    /// Makes rows white in place.
    pub(super) fn whiten(&self, rows: &mut [f64]) {
        for (row, weight) in rows.iter_mut().zip(&self.weights) {
            *row *= weight;
        }
        for case in self.rows_of_cases() {
            let unit = self.shared[case.clone()]
                .iter()
                .zip(&self.weights[case.clone()]);
            let unit: Vec<f64> = unit.map(|(shared, weight)| shared * weight).collect();
            let squares = dot(&unit, &unit);
            if squares > 0.0 {
                // I - root u uᵀ is the symmetric root of (I + u uᵀ)⁻¹.
                let root = (1.0 - (1.0 + squares).sqrt().recip()) / squares;
                let taken = root * dot(&unit, &rows[case.clone()]);
                for (row, unit) in rows[case].iter_mut().zip(&unit) {
                    *row -= taken * unit;
                }
            }
        }
    }

    /// The sum of the squares of white rows.
    pub(super) fn squares(&self, rows: &[f64]) -> f64 {
        let mut white = rows.to_vec();
        self.whiten(&mut white);
        dot(&white, &white)
    }

    /// The length of a column of white rows; `None` if the rows with weight do not show it.
    pub(super) fn length(&self, column: &[f64]) -> Option<f64> {
        let (length, whole) = (self.squares(column).sqrt(), dot(column, column).sqrt());
        let heaviest = self.weights.iter().copied().fold(0.0, f64::max);
        (length > ROUNDING * whole * heaviest).then_some(length)
    }

    fn rows_of_cases(&self) -> impl Iterator<Item = Range<usize>> {
        self.cases.iter().scan(0, |first, case| {
            let rows = *first..*first + case;
            *first = rows.end;
            Some(rows)
        })
    }
}

/// Standard deviations below which nothing is asked of displacements, m, and of rotations, rad: a share of their size, and the rounding to the
/// smallest difference between repeats, which no step of a gauge is larger than.
fn least_scatter(posed: &PosedLoadCases) -> [f64; 2] {
    let mut least = sizes(posed).map(|size| LEAST_SCATTER * size);
    let (kinds, values): (Vec<usize>, Vec<f64>) = kinds(posed)
        .into_iter()
        .zip(posed.rows().map(|(_, read)| read.value))
        .unzip();
    for (kind, least) in least.iter_mut().enumerate() {
        let groups = repeated_rows(posed).into_iter();
        let own = groups.filter(|rows| kinds[rows[0]] == kind);
        let steps = own.map(|rows| smallest_step(rows.iter().map(|row| values[*row])));
        let step = steps.fold(f64::INFINITY, f64::min);
        if step.is_finite() {
            *least = least.max(step / 12_f64.sqrt());
        }
    }
    least
}

/// The smallest difference between values that differ; infinite if none do.
pub(super) fn smallest_step(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]);
    steps
        .filter(|step| *step > 0.0)
        .fold(f64::INFINITY, f64::min)
}

/// Loads that were applied several times with the same components read.
fn repeated_cases(posed: &PosedLoadCases, residuals: &[f64]) -> Vec<ScatterCase> {
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
fn contrasts(group: &[(&PosedLoad, &[f64])]) -> ScatterCase {
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
    ScatterCase {
        kinds: components
            .iter()
            .map(|read| usize::from(read.is_rotation()))
            .collect(),
        values: (0..components.len()).map(mean_of).collect(),
        errors: (1..group.len()).map(contrast).collect(),
        dof: 1.0,
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Squares of normal values by their quantiles would hide errors of the search; exact squares show the solution.
    #[test]
    fn exact_squares_give_back_their_variances() {
        let case = |kind: usize, value: f64, variance: f64| ScatterCase {
            kinds: vec![kind],
            values: vec![value],
            errors: vec![vec![variance.sqrt()]],
            dof: 3.0,
        };
        let cases: Vec<ScatterCase> = (0..20)
            .map(|i| {
                let (kind, value) = (i % 2, i as f64);
                case(kind, value, [4.0, 9.0][kind] + 0.5 * value * value)
            })
            .collect();
        let found = LoadScatter::of_cases(&cases, [0.0; 2]);
        assert!((found.variance(0, 0.0) - 4.0).abs() < 0.01, "{found:?}");
        assert!((found.variance(1, 0.0) - 9.0).abs() < 0.01, "{found:?}");
        assert!((found.slope_sd.powi(2) - 0.5).abs() < 0.001, "{found:?}");
        assert!((found.dof - 60.0).abs() < 1e-12);
    }

    #[test]
    fn rows_that_share_a_slope_are_white() {
        let scatter = RowScatter {
            weights: vec![0.5, 0.25, 1.0],
            shared: vec![3.0, -1.0, 2.0],
            cases: vec![2, 1],
        };
        // L V Lᵀ = 1 with V = diag(1/w²) + s sᵀ in each case.
        let white = |mut row: [f64; 3]| {
            scatter.whiten(&mut row);
            row
        };
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(white);
        let own = [4.0, 16.0, 1.0];
        let common = |a: usize, b: usize| {
            let of_one_case = (a < 2) == (b < 2);
            let shared = scatter.shared[a] * scatter.shared[b];
            if of_one_case { shared } else { 0.0 }
        };
        for i in 0..3 {
            for j in 0..3 {
                let terms = (0..9).map(|k| {
                    let (a, b) = (k / 3, k % 3);
                    let v = common(a, b) + if a == b { own[a] } else { 0.0 };
                    columns[a][i] * v * columns[b][j]
                });
                let expected = f64::from(u8::from(i == j));
                let found: f64 = terms.sum();
                assert!((found - expected).abs() < 1e-12, "{i} {j}: {found}");
            }
        }
        // A row that takes no part takes its share of the slope with it.
        let mut without = [7.0, 4.0, 0.0];
        scatter.without(|row| row == 0).whiten(&mut without);
        assert_eq!(without[0], 0.0);
        assert!((without[1] - 4.0 / 17_f64.sqrt()).abs() < 1e-12);
    }
}
