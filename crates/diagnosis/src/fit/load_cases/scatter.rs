//! How the rows of load cases scatter, each by itself and together with the others of its case.

use std::ops::Range;

use indexmap::IndexMap;
use stiffbench_numeric::statistics::root_mean_square;

use super::posed::{PosedLoadCases, ReadComponent};
use crate::mismatch::{GaugeSteps, ReadingNoise};
use crate::search::constants::ROUNDING;
use crate::search::dot;

/// Loads that differ by less than this share of the larger are one load applied again.
pub(in crate::fit) const SAME_LOAD: f64 = 0.05;

/// Rows that hold one component under one load in one pose, each as often as it was read.
pub(in crate::fit) fn repeated_rows(posed: &PosedLoadCases) -> Vec<Vec<usize>> {
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
pub(in crate::fit) fn sizes(posed: &PosedLoadCases) -> [f64; 2] {
    [false, true].map(|rotation| {
        let rows = posed.rows();
        let own = rows.filter(|(_, read)| read.is_rotation() == rotation);
        let size = root_mean_square(own.map(|(_, read)| read.value));
        size.filter(|size| *size > 0.0).unwrap_or(1.0)
    })
}

/// Kind of each row: 0 of displacements, 1 of rotations.
pub(in crate::fit) fn kinds(posed: &PosedLoadCases) -> Vec<usize> {
    let rows = posed.rows();
    rows.map(|(_, read)| usize::from(read.is_rotation()))
        .collect()
}

/// Errors that the rows of a load case have in common.
const SHARED: usize = 4;

/// How rows scatter, each by itself and together with the others of its load case.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct RowScatter {
    /// One over the standard deviation of each row by itself; zero of a row that takes no part.
    pub(in crate::fit) weights: Vec<f64>,
    /// The standard deviations of each row that it shares with its load case, signed: by the size of the load, and by its force along x, y, z.
    shared: Vec<[f64; SHARED]>,
    /// Number of rows of each load case.
    cases: Vec<usize>,
}

impl RowScatter {
    /// Each row by itself.
    ///
    /// # Arguments
    /// - `sd`: standard deviations of displacements, m, and of rotations, rad.
    pub(in crate::fit) fn plain(posed: &PosedLoadCases, sd: [f64; 2]) -> Self {
        let kinds = kinds(posed);
        let cases = posed.cases.iter();
        Self {
            weights: kinds.iter().map(|kind| sd[*kind].recip()).collect(),
            shared: vec![[0.0; SHARED]; kinds.len()],
            cases: cases.map(|case| case.components.len()).collect(),
        }
    }

    /// The scatter of load cases under the noise of a session: of each row its own, and what an error of the load moves, common to the rows of a
    /// case.
    ///
    /// # Arguments
    /// - `predicted`: every row as it is without error.
    /// - `components`: what each component of the force moves it by, as of [`ForceReading::ByComponents`](crate::mismatch::ForceReading).
    pub(in crate::fit) fn of_noise(
        posed: &PosedLoadCases,
        steps: GaugeSteps,
        noise: &ReadingNoise,
        predicted: &[f64],
        components: &[[f64; 3]],
    ) -> Self {
        let force_step_n = steps.force_n.unwrap_or(0.0);
        let force_sd_n = f64::hypot(force_step_n / 12.0_f64.sqrt(), noise.gauges.force_sd_n);
        let mut scatter = Self::default();
        let mut rows = predicted.iter().zip(components);
        for case in &posed.cases {
            for (read, (predicted, by_force)) in case.components.iter().zip(&mut rows) {
                let own = noise.own_variance(&read.read_axis(), *predicted)
                    + (noise.gauges.own_slope_sd * predicted).powi(2);
                scatter.weights.push(own.sqrt().recip());
                let [x, y, z] = by_force.map(|moved| force_sd_n * moved);
                let by_size = noise.run_slope_sd * predicted;
                scatter.shared.push([by_size, x, y, z]);
            }
            scatter.cases.push(case.components.len());
        }
        scatter
    }

    /// Mean share of what a case has in common in the variance of its rows.
    pub(in crate::fit) fn common_share(&self) -> f64 {
        let rows = self.weights.iter().zip(&self.shared);
        let shares = rows.map(|(weight, shared)| {
            let common = weight * weight * dot(shared, shared);
            common / (1.0 + common)
        });
        shares.sum::<f64>() / self.weights.len().max(1) as f64
    }

    /// The same without some rows.
    pub(in crate::fit) fn without(&self, is_left_out: impl Fn(usize) -> bool) -> Self {
        let mut without = self.clone();
        for (row, weight) in without.weights.iter_mut().enumerate() {
            if is_left_out(row) {
                *weight = 0.0;
            }
        }
        without
    }

    /// One over the standard deviation of a row by itself.
    pub(in crate::fit) fn weight(&self, row: usize) -> f64 {
        self.weights[row]
    }

    /// Makes rows white in place.
    pub(in crate::fit) fn whiten(&self, rows: &mut [f64]) {
        for (row, weight) in rows.iter_mut().zip(&self.weights) {
            *row *= weight;
        }
        let mut units: Vec<[f64; SHARED]> = Vec::new();
        for case in self.rows_of_cases() {
            let shared = self.shared[case.clone()].iter();
            let shared = shared.zip(&self.weights[case.clone()]);
            units.clear();
            units.extend(shared.map(|(shared, weight)| shared.map(|sd| sd * weight)));
            let own = &mut rows[case];
            // What is in common, one after the other, each made white by those before: of A + u uᵀ with A = R Rᵀ a root is R times that of I + v vᵀ,
            // v = R⁻¹ u.
            for part in 0..SHARED {
                let squares: f64 = units.iter().map(|unit| unit[part] * unit[part]).sum();
                if squares == 0.0 {
                    continue;
                }
                // I - root u uᵀ is the symmetric root of (I + u uᵀ)⁻¹.
                let root = (1.0 - (1.0 + squares).sqrt().recip()) / squares;
                for later in part + 1..SHARED {
                    let product: f64 = units.iter().map(|unit| unit[part] * unit[later]).sum();
                    for unit in &mut units {
                        unit[later] -= root * product * unit[part];
                    }
                }
                let product = units.iter().zip(&*own).map(|(unit, row)| unit[part] * row);
                let taken = root * product.sum::<f64>();
                for (row, unit) in own.iter_mut().zip(&units) {
                    *row -= taken * unit[part];
                }
            }
        }
    }

    /// The sum of the squares of white rows.
    pub(in crate::fit) fn squares(&self, rows: &[f64]) -> f64 {
        let mut white = rows.to_vec();
        self.whiten(&mut white);
        dot(&white, &white)
    }

    /// The length of a column of white rows; `None` if the rows with weight do not show it.
    pub(in crate::fit) fn length(&self, column: &[f64]) -> Option<f64> {
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

/// The smallest difference between values that differ; infinite if none do.
pub(in crate::fit) fn smallest_step(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]);
    steps
        .filter(|step| *step > 0.0)
        .fold(f64::INFINITY, f64::min)
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

    #[test]
    fn rows_that_share_a_slope_are_white() {
        let scatter = RowScatter {
            weights: vec![0.5, 0.25, 1.0],
            shared: vec![
                [3.0, 0.5, 0.0, 1.0],
                [-1.0, 2.0, 0.0, 0.7],
                [2.0, 0.0, 1.0, 0.0],
            ],
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
            let shared = dot(&scatter.shared[a], &scatter.shared[b]);
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
        // A row that takes no part takes its share of what is in common with it.
        let mut without = [7.0, 4.0, 0.0];
        scatter.without(|row| row == 0).whiten(&mut without);
        assert_eq!(without[0], 0.0);
        let variance = own[1] + common(1, 1);
        assert!((without[1] - 4.0 / variance.sqrt()).abs() < 1e-12);
    }
}
