//! What makes readings scatter: reading, gauge steps, run zero, run slope; and the transform that makes that scatter white.
//!
//! ```text
//!   y = prediction + zero(zero id) + slope(run) b + reading error,     b = prediction of the baseline
//!   V = D^(1/2) R D^(1/2) + σ₀² Σ 1 1ᵀ (each zero) + σₛ² Σ b bᵀ (each run)
//!   D = diag(σ² + g² b² + q_F²/12 C²),    R: ρ^|i - j| within a run, of the scatter alone
//! ```
//!
//! The step of the displacement gauge is part of σ; an unloaded reading has exactly zero force and no force step.

use std::ops::Range;

use super::joined_sessions::NoisePart;
use super::observations::Observations;
use crate::search::{Covariance, LowRankBlock, Precision, RowMemory};

/// The noise of readings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReadingNoise {
    /// Standard deviation of a reading, the step of its gauge included, m.
    pub reading_sd_m: f64,
    /// Of a gauge zero, m.
    pub zero_sd_m: f64,
    /// Of the slope of a run, relative (1).
    pub run_slope_sd: f64,
    /// Standard deviation of a reading that grows with the displacement, as a share of it (1).
    pub growth_sd: f64,
    /// Correlation of the error of a reading with that of the reading before it in its run (1): a first-order autoregressive process.
    pub correlation: f64,
}

impl ReadingNoise {
    /// Variance of a reading by itself, without the step of the force, m².
    ///
    /// # Arguments
    /// - `slope_m`: its displacement by the baseline.
    pub(super) fn own_variance(&self, slope_m: f64) -> f64 {
        self.reading_sd_m.powi(2) + (self.growth_sd * slope_m).powi(2)
    }

    /// How much larger than in another noise the variance is that exceeds it most; not below 1.
    pub(super) fn largest_variance_ratio(&self, other: &Self) -> f64 {
        let ratios = [
            self.reading_sd_m / other.reading_sd_m,
            self.zero_sd_m / other.zero_sd_m,
            self.run_slope_sd / other.run_slope_sd,
            if other.growth_sd > 0.0 {
                self.growth_sd / other.growth_sd
            } else {
                1.0
            },
        ];
        ratios.into_iter().fold(1.0, f64::max).powi(2)
    }
}

/// The covariance of readings under a noise, with what it is made of.
#[derive(Debug, Clone)]
pub(super) struct NoiseCovariance {
    pub(super) covariance: Covariance,
    pub(super) noise: ReadingNoise,
    /// Prediction b of the baseline, which a run's slope multiplies, m.
    pub(super) slope_m: Vec<f64>,
    /// The noise of each session.
    parts: Vec<NoisePart>,
}

impl NoiseCovariance {
    /// The covariance of a noise about a baseline.
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
        let parts = observations.noise_parts(noise);
        let variances = variances(&parts, observations, slope_m, compliance);
        let memory = memory(&parts, observations, &variances, slope_m);
        let blocks = common_parts(&parts, observations, slope_m);
        Self {
            covariance: Covariance::with_memory(&variances, &memory, blocks),
            noise: *noise,
            slope_m: slope_m.to_vec(),
            parts,
        }
    }

    /// The inverse of the same covariance, for likelihoods.
    pub(super) fn precision(
        observations: &Observations,
        noise: &ReadingNoise,
        slope_m: &[f64],
        compliance: &[f64],
    ) -> Precision {
        let parts = observations.noise_parts(noise);
        let variances = variances(&parts, observations, slope_m, compliance);
        let memory = memory(&parts, observations, &variances, slope_m);
        let blocks = common_parts(&parts, observations, slope_m);
        Precision::new(&variances, &memory, blocks)
    }

    /// The noise of a reading.
    pub(super) fn noise_at(&self, reading: usize) -> &ReadingNoise {
        &part_of(&self.parts, reading).noise
    }

    /// Best estimate of each reading without its own error and without its zero, m: where the gauge really stood.
    ///
    /// What scatters in the force and in the slope of a run moved the gauge; what scatters in the reading did not.
    pub(super) fn positions(&self, observations: &Observations, residual_m: &[f64]) -> Vec<f64> {
        // V⁻¹ r, then the best linear prediction of reading error and zero from it (Henderson, Biometrics 31 (1975)).
        let mut solved = residual_m.to_vec();
        self.covariance.whiten(&mut solved);
        self.covariance.whiten_transposed(&mut solved);
        let mut positions = observations.displacement_m.clone();
        let mut own = solved.clone();
        self.covariance.own_part(&mut own);
        for group in self.covariance.block_rows() {
            let zero = self.noise_at(group.start).zero_sd_m.powi(2);
            for_each_zero(observations, group, |member| {
                let members = || group.clone().filter(|&r| member(r));
                let offset = zero * members().map(|r| solved[r]).sum::<f64>();
                for r in members() {
                    positions[r] -= own[r] - self.force_variance(r) * solved[r] + offset;
                }
            });
        }
        positions
    }

    /// Variance of a reading by the step of the force, m².
    fn force_variance(&self, reading: usize) -> f64 {
        let weight = self.covariance.weights()[reading];
        (weight * weight).recip() - self.noise_at(reading).own_variance(self.slope_m[reading])
    }

    /// Share of its own error in the variance of a reading without zero and slope; the rest is the step of the force.
    pub(super) fn own_share(&self, reading: usize) -> f64 {
        let weight = self.covariance.weights()[reading];
        let share = self.noise.own_variance(self.slope_m[reading]) * weight * weight;
        share.clamp(0.0, 1.0)
    }

    /// Shares of reading, zero and run slope in the variance of an amplitude estimated along a white vector; the rest is force step.
    pub(super) fn variance_shares(
        &self,
        observations: &Observations,
        white: &[f64],
        scratch: &mut Vec<f64>,
    ) -> [f64; 3] {
        let n = self.slope_m.len();
        let square: f64 = white.iter().map(|x| x * x).sum();
        if square == 0.0 {
            return [0.0; 3];
        }
        scratch.clear();
        scratch.extend_from_slice(&white[..n]);
        self.covariance.whiten_transposed(scratch);
        let mut own = scratch.clone();
        self.covariance.own_part(&mut own);
        let products = scratch.iter().zip(&own).enumerate();
        let reading: f64 = products
            .map(|(r, (a, b))| a * (b - self.force_variance(r) * a))
            .sum();
        let mut zero = 0.0;
        let mut slope = 0.0;
        for group in self.covariance.block_rows() {
            let variance = self.noise_at(group.start).zero_sd_m.powi(2);
            for_each_zero(observations, group, |member| {
                let sum: f64 = group
                    .clone()
                    .filter(|&r| member(r))
                    .map(|r| scratch[r])
                    .sum();
                zero += variance * sum * sum;
            });
        }
        for run in &observations.runs {
            let sum: f64 = run
                .readings
                .clone()
                .map(|r| scratch[r] * self.slope_m[r])
                .sum();
            slope += self.noise_at(run.readings.start).run_slope_sd.powi(2) * sum * sum;
        }
        [reading / square, zero / square, slope / square]
    }
}

/// The part of a reading.
fn part_of(parts: &[NoisePart], reading: usize) -> &NoisePart {
    let place = parts.partition_point(|part| part.readings.end <= reading);
    &parts[place.min(parts.len() - 1)]
}

/// What each reading has by itself, m²: its own errors and the step of the force.
fn variances(
    parts: &[NoisePart],
    observations: &Observations,
    slope_m: &[f64],
    compliance: &[f64],
) -> Vec<f64> {
    let of_part = |part: &NoisePart| {
        let force_step_n = part.steps.force_n.unwrap_or(0.0);
        let force_variance = force_step_n * force_step_n / 12.0;
        let noise = part.noise;
        part.readings.clone().map(move |reading| {
            let c = compliance[reading];
            let of_force = if observations.loads[reading].force_n == 0.0 {
                0.0
            } else {
                force_variance * c * c
            };
            noise.own_variance(slope_m[reading]) + of_force
        })
    };
    parts.iter().flat_map(of_part).collect()
}

/// How each reading remembers the one before it, for its variance: none one of another run; empty without any. Scatter remembers, the steps
/// of the gauges do not.
fn memory(
    parts: &[NoisePart],
    observations: &Observations,
    variances: &[f64],
    slope_m: &[f64],
) -> Vec<RowMemory> {
    if parts.iter().all(|part| part.noise.correlation == 0.0) {
        return Vec::new();
    }
    let of_part = |part: &NoisePart| {
        let step_m = part.steps.displacement_m.unwrap_or(0.0);
        let (noise, of_step) = (part.noise, step_m * step_m / 12.0);
        part.readings.clone().map(move |reading| RowMemory {
            correlation: noise.correlation,
            share: ((noise.own_variance(slope_m[reading]) - of_step) / variances[reading])
                .clamp(0.0, 1.0),
        })
    };
    let mut memory: Vec<RowMemory> = parts.iter().flat_map(of_part).collect();
    for run in &observations.runs {
        if let Some(first) = memory.get_mut(run.readings.start) {
            first.correlation = 0.0;
        }
    }
    memory
}

/// What the readings of each group have in common.
fn common_parts(
    parts: &[NoisePart],
    observations: &Observations,
    slope_m: &[f64],
) -> impl Iterator<Item = LowRankBlock> {
    groups(observations).map(move |readings| {
        let noise = &part_of(parts, readings.start).noise;
        common_part(observations, noise, slope_m, readings)
    })
}

/// What readings of a range have in common: a column σ₀ 1 for each zero and σₛ b for each run.
fn common_part(
    observations: &Observations,
    noise: &ReadingNoise,
    slope_m: &[f64],
    readings: Range<usize>,
) -> LowRankBlock {
    let mut columns = Vec::with_capacity(2 * readings.len());
    let only = |member: bool, value: f64| if member { value } else { 0.0 };
    for_each_zero(observations, &readings, |member| {
        let each = readings.clone();
        columns.extend(each.map(|r| only(member(r), noise.zero_sd_m)));
    });
    let mut run = usize::MAX;
    for first in readings.clone() {
        if observations.readings[first].run == run {
            continue;
        }
        run = observations.readings[first].run;
        columns.extend(readings.clone().map(|r| {
            let is_of_run = observations.readings[r].run == run;
            only(is_of_run, noise.run_slope_sd * slope_m[r])
        }));
    }
    LowRankBlock {
        rows: readings,
        columns,
    }
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
pub(super) fn groups(observations: &Observations) -> impl Iterator<Item = Range<usize>> + '_ {
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
