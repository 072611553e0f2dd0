//! What makes readings scatter: reading, gauge steps, run zero, run slope; and the transform that makes that scatter white.
//!
//! ```text
//!   y = prediction + zero(zero id) + slope(run) b + reading error,     b = prediction of the baseline
//!   V = σ² I + q_F²/12 diag(C²) + σ₀² Σ 1 1ᵀ (each zero) + σₛ² Σ b bᵀ (each run)
//! ```
//!
//! The step of the displacement gauge is part of σ; an unloaded reading has exactly zero force and no force step.

use std::ops::Range;

use nalgebra::DMatrix;

use stiffbench_numeric::lanes::{sums_side_by_side, widest};

use super::observations::Observations;
use super::symmetric_root::symmetric_root;

/// Standard deviations of the noise of readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadingNoise {
    /// Of a reading, the step of its gauge included, m.
    pub reading_sd_m: f64,
    /// Of a gauge zero, m.
    pub zero_sd_m: f64,
    /// Of the slope of a run, relative (1).
    pub run_slope_sd: f64,
}

impl ReadingNoise {
    /// How much larger than in another noise the variance is that exceeds it most; not below 1.
    pub(super) fn largest_variance_ratio(&self, other: &Self) -> f64 {
        let ratios = [
            self.reading_sd_m / other.reading_sd_m,
            self.zero_sd_m / other.zero_sd_m,
            self.run_slope_sd / other.run_slope_sd,
        ];
        ratios.into_iter().fold(1.0, f64::max).powi(2)
    }
}

/// Readings that share zeros or runs, and their part of the whitening transform.
#[derive(Debug, Clone)]
struct Group {
    readings: Range<usize>,
    /// Columns of D^(-1/2) U, one after the other: U has a column σ₀ 1 for each zero and σₛ b for each run.
    columns: Vec<f64>,
    /// The same times the matrix that makes (I - columns · this) the symmetric root of (I + columns columnsᵀ)⁻¹.
    weighted: Vec<f64>,
    rank: usize,
}

/// Readings that share zeros or runs, and columns E, one after the other, with V⁻¹ = D⁻¹ - E Eᵀ among them.
#[derive(Debug)]
pub(super) struct RunColumns {
    pub(super) readings: Range<usize>,
    pub(super) columns: Vec<f64>,
}

/// The transform W with Wᵀ W = V⁻¹.
#[derive(Debug, Clone)]
pub(super) struct Whitening {
    groups: Vec<Group>,
    /// D^(-1/2).
    weights: Vec<f64>,
    /// ln det V.
    log_determinant: f64,
    noise: ReadingNoise,
    /// Prediction b of the baseline, which a run's slope multiplies.
    slope_m: Vec<f64>,
}

impl Whitening {
    /// The transform for a noise and a baseline.
    ///
    /// # Arguments
    /// - `slope_m`: prediction of the baseline, m, one a reading.
    /// - `compliance`: displacement per force of the baseline at each reading, m/N.
    pub(super) fn new(
        observations: &Observations,
        noise: &ReadingNoise,
        slope_m: &[f64],
        compliance: &[f64],
    ) -> Self {
        let force_step_n = observations.steps.force_n.unwrap_or(0.0);
        let force_variance = force_step_n * force_step_n / 12.0;
        let weights: Vec<f64> = observations
            .loads
            .iter()
            .zip(compliance)
            .map(|(load, c)| {
                let of_force = if load.force_n == 0.0 {
                    0.0
                } else {
                    force_variance * c * c
                };
                (noise.reading_sd_m * noise.reading_sd_m + of_force)
                    .sqrt()
                    .recip()
            })
            .collect();
        let mut log_determinant: f64 = weights.iter().map(|weight| -2.0 * weight.ln()).sum();
        let groups = groups(observations)
            .map(|readings| {
                let group = Group::new(observations, noise, slope_m, &weights, readings);
                log_determinant += group.1;
                group.0
            })
            .collect();
        Self {
            groups,
            weights,
            log_determinant,
            noise: *noise,
            slope_m: slope_m.to_vec(),
        }
    }

    /// The noise that is made white.
    pub(super) fn noise(&self) -> &ReadingNoise {
        &self.noise
    }

    /// What the slope of a run multiplies, m.
    pub(super) fn slope_m(&self) -> &[f64] {
        &self.slope_m
    }

    /// ln det V.
    pub(super) fn log_determinant(&self) -> f64 {
        self.log_determinant
    }

    /// One over the standard deviation of each reading, without zeros and slopes of runs, 1/m.
    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// What V⁻¹ lacks of D⁻¹, group by group.
    pub(super) fn run_columns(&self) -> impl Iterator<Item = RunColumns> {
        self.groups.iter().map(|group| RunColumns {
            readings: group.readings.clone(),
            columns: group.inverse_columns(&self.weights[group.readings.clone()]),
        })
    }

    /// W times a vector of readings, in place.
    pub(super) fn apply(&self, vector: &mut [f64]) {
        for (value, weight) in vector.iter_mut().zip(&self.weights) {
            *value *= weight;
        }
        Self::symmetric(self.groups.iter(), vector);
    }

    /// Wᵀ times a white vector, in place.
    pub(super) fn apply_transposed(&self, vector: &mut [f64]) {
        Self::symmetric(self.groups.iter(), vector);
        for (value, weight) in vector.iter_mut().zip(&self.weights) {
            *value *= weight;
        }
    }

    /// W⁻¹ times a white vector, in place: readings, m.
    pub(super) fn apply_inverse(&self, vector: &mut [f64]) {
        Self::symmetric(self.groups.iter(), vector);
        // (I + C Cᵀ)^(1/2) = (I + C Cᵀ) (I + C Cᵀ)^(-1/2)
        for group in &self.groups {
            let part = &mut vector[group.readings.clone()];
            let products: Vec<f64> = group
                .columns
                .chunks(part.len())
                .map(|column| column.iter().zip(part.iter()).map(|(c, x)| c * x).sum())
                .collect();
            for (product, column) in products.iter().zip(group.columns.chunks(part.len())) {
                for (value, c) in part.iter_mut().zip(column) {
                    *value += c * product;
                }
            }
        }
        for (value, weight) in vector.iter_mut().zip(&self.weights) {
            *value /= weight;
        }
    }

    /// W times the part of a vector of readings that lies in `range`, a union of cells; the rest is left alone.
    pub(super) fn apply_range(&self, vector: &mut [f64], range: &Range<usize>) {
        for (value, weight) in vector[range.clone()]
            .iter_mut()
            .zip(&self.weights[range.clone()])
        {
            *value *= weight;
        }
        let first = self
            .groups
            .partition_point(|group| group.readings.start < range.start);
        let groups = self.groups[first..]
            .iter()
            .take_while(|group| group.readings.end <= range.end);
        Self::symmetric(groups, vector);
    }

    fn symmetric<'g>(groups: impl Iterator<Item = &'g Group>, vector: &mut [f64]) {
        widest(
            #[inline(always)]
            || {
                for group in groups {
                    group.symmetric(vector);
                }
            },
        );
    }

    /// Best estimate of each reading without its own error and without its zero, m: where the gauge really stood.
    ///
    /// What scatters in the force and in the slope of a run moved the gauge; what scatters in the reading did not.
    pub(super) fn positions(&self, observations: &Observations, residual_m: &[f64]) -> Vec<f64> {
        // V⁻¹ r, then the best linear prediction of reading error and zero from it (Henderson, Biometrics 31 (1975)).
        let mut solved = residual_m.to_vec();
        self.apply(&mut solved);
        self.apply_transposed(&mut solved);
        let mut positions = observations.displacement_m.clone();
        let (reading, zero) = (
            self.noise.reading_sd_m.powi(2),
            self.noise.zero_sd_m.powi(2),
        );
        for group in &self.groups {
            for_each_zero(observations, &group.readings, |member| {
                let members = || group.readings.clone().filter(|&r| member(r));
                let offset = zero * members().map(|r| solved[r]).sum::<f64>();
                for r in members() {
                    positions[r] -= reading * solved[r] + offset;
                }
            });
        }
        positions
    }

    /// Shares of reading, zero and run slope in the variance of an amplitude estimated along a white vector; the rest is force step.
    pub(super) fn variance_shares(
        &self,
        observations: &Observations,
        white: &[f64],
        scratch: &mut Vec<f64>,
    ) -> [f64; 3] {
        let n = self.weights.len();
        let square: f64 = white.iter().map(|x| x * x).sum();
        if square == 0.0 {
            return [0.0; 3];
        }
        scratch.clear();
        scratch.extend_from_slice(&white[..n]);
        self.apply_transposed(scratch);
        let reading: f64 = scratch.iter().map(|a| a * a).sum();
        let mut zero = 0.0;
        let mut slope = 0.0;
        for group in &self.groups {
            for_each_zero(observations, &group.readings, |member| {
                let sum: f64 = group
                    .readings
                    .clone()
                    .filter(|&r| member(r))
                    .map(|r| scratch[r])
                    .sum();
                zero += sum * sum;
            });
        }
        for run in &observations.runs {
            let sum: f64 = run
                .readings
                .clone()
                .map(|r| scratch[r] * self.slope_m[r])
                .sum();
            slope += sum * sum;
        }
        [
            reading * self.noise.reading_sd_m.powi(2) / square,
            zero * self.noise.zero_sd_m.powi(2) / square,
            slope * self.noise.run_slope_sd.powi(2) / square,
        ]
    }
}

impl Group {
    /// The symmetric root of (I + columns columnsᵀ)⁻¹ times its part of a vector, in place.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it is compiled for the instructions of its caller"
    )]
    fn symmetric(&self, vector: &mut [f64]) {
        let part = &mut vector[self.readings.clone()];
        let n = part.len();
        let mut products = [0.0; 64];
        for (product, column) in products.iter_mut().zip(self.columns.chunks(n)) {
            *product = sums_side_by_side(column, part);
        }
        for (product, column) in products.iter().zip(self.weighted.chunks(n)) {
            for (value, w) in part.iter_mut().zip(column) {
                *value -= w * product;
            }
        }
    }

    /// The group and its part of ln det V.
    fn new(
        observations: &Observations,
        noise: &ReadingNoise,
        slope_m: &[f64],
        weights: &[f64],
        readings: Range<usize>,
    ) -> (Self, f64) {
        let n = readings.len();
        let mut columns = Vec::with_capacity(2 * n);
        for_each_zero(observations, &readings, |member| {
            columns.extend(readings.clone().map(|r| {
                if member(r) {
                    noise.zero_sd_m * weights[r]
                } else {
                    0.0
                }
            }));
        });
        let mut run = usize::MAX;
        for first in readings.clone() {
            if observations.readings[first].run == run {
                continue;
            }
            run = observations.readings[first].run;
            columns.extend(readings.clone().map(|r| {
                if observations.readings[r].run == run {
                    noise.run_slope_sd * slope_m[r] * weights[r]
                } else {
                    0.0
                }
            }));
        }
        let rank = columns.len() / n;
        let (inner, log_determinant) = symmetric_root(&gram(&columns, n));
        let mut weighted = vec![0.0; rank * n];
        for i in 0..rank {
            for j in 0..rank {
                let share = inner[(j, i)];
                for reading in 0..n {
                    weighted[i * n + reading] += columns[j * n + reading] * share;
                }
            }
        }
        let group = Self {
            readings,
            columns,
            weighted,
            rank,
        };
        debug_assert!(group.rank <= 64);
        (group, log_determinant)
    }
}

impl Group {
    /// E with (D + U Uᵀ)⁻¹ = D⁻¹ - E Eᵀ: D^(-1/2) C L⁻ᵀ with C = D^(-1/2) U and I + Cᵀ C = L Lᵀ.
    fn inverse_columns(&self, weights: &[f64]) -> Vec<f64> {
        let n = self.readings.len();
        let gram = gram(&self.columns, n) + DMatrix::identity(self.rank, self.rank);
        let lower = gram.cholesky().map(nalgebra::Cholesky::unpack);
        let mut out = self.columns.clone();
        for values in out.chunks_mut(n) {
            for (value, weight) in values.iter_mut().zip(weights) {
                *value *= weight;
            }
        }
        for i in 0..self.rank {
            let (before, rest) = out.split_at_mut(i * n);
            let column = &mut rest[..n];
            // Without a factor, which only numbers that are not finite can lack, the result is not finite either.
            let entry = |j: usize| lower.as_ref().map_or(f64::NAN, |lower| lower[(i, j)]);
            for (j, earlier) in before.chunks(n).enumerate() {
                for (value, other) in column.iter_mut().zip(earlier) {
                    *value -= entry(j) * other;
                }
            }
            for value in column {
                *value /= entry(i);
            }
        }
        out
    }
}

/// Products of columns of `n` numbers with each other.
fn gram(columns: &[f64], n: usize) -> DMatrix<f64> {
    let rank = columns.len() / n;
    let column = |index: usize| &columns[index * n..(index + 1) * n];
    DMatrix::from_fn(rank, rank, |i, j| {
        column(i).iter().zip(column(j)).map(|(a, b)| a * b).sum()
    })
}

/// Calls `action` once for each gauge zero of a range, with the test of membership.
fn for_each_zero(
    observations: &Observations,
    readings: &Range<usize>,
    mut action: impl FnMut(&dyn Fn(usize) -> bool),
) {
    let zero_of = |reading: usize| observations.readings[reading].zero;
    let mut seen: Vec<u32> = Vec::new();
    for reading in readings.clone() {
        let zero = zero_of(reading);
        if !seen.contains(&zero) {
            seen.push(zero);
            action(&|other| zero_of(other) == zero);
        }
    }
}

/// Ranges of readings that share no zero and no run with the rest.
///
/// Runs that share a zero lie in one cell; a cell with shared zeros is one group, of at most thirty runs at a time: the rank of a
/// group is bounded, and a zero that spans more is split, which only widens what is allowed to scatter.
fn groups(observations: &Observations) -> impl Iterator<Item = Range<usize>> + '_ {
    const MOST_RUNS: usize = 30;
    observations.cells.iter().flat_map(move |cell| {
        let mut out: Vec<Range<usize>> = Vec::new();
        let mut runs_in_last = 0;
        let mut last_zeros: Vec<u32> = Vec::new();
        for run in &observations.runs[cell.runs.clone()] {
            let zeros: Vec<u32> = observations.readings[run.readings.clone()]
                .iter()
                .map(|reading| reading.zero)
                .collect();
            let shared = zeros.iter().any(|zero| last_zeros.contains(zero));
            match out.last_mut() {
                Some(last) if shared && runs_in_last < MOST_RUNS => {
                    last.end = run.readings.end;
                    runs_in_last += 1;
                    last_zeros.extend(zeros);
                }
                _ => {
                    out.push(run.readings.clone());
                    runs_in_last = 1;
                    last_zeros = zeros;
                }
            }
            last_zeros.sort_unstable();
            last_zeros.dedup();
        }
        out
    })
}
