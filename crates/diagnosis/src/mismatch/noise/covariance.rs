//! What makes readings scatter: reading, gauge steps, run zero, run slope; and the transform that makes that scatter white.
//!
//! ```text
//!   y = prediction + zero(zero id) + slope(run) b + reading error,     b = prediction of the baseline
//!   V = D^(1/2) R D^(1/2) + σ₀² Σ 1 1ᵀ (each zero) + σₛ² Σ b bᵀ (each run)
//!   D = diag(σ² + g² b² + q_F²/12 C²),    R: ρ^|i - j| within a run, of the scatter alone
//! ```
//!
//! The step of the displacement gauge is part of σ; an unloaded reading has exactly zero force and no force step.
//!
//! Of several gauges that are read at once each has its σ, its zeros and a slope of its own in each run; the slope of a run and the error of
//! the force, through the compliances, are common to all: cov(y_i, y_j) = σ_F² C_i C_j within a reading.

use std::ops::Range;

use crate::mismatch::observed::{GaugeNoise, NoisePart, Observations, ReadingNoise};
use crate::search::largest;
use crate::search::{
    Covariance, LowRankBlock, MOST_STATES, Precision, RowCorrelation, RowErrors, RowStates,
};

/// How the force was read whose error moves readings, with what a force moves by the baseline, m/N, one a reading.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ForceReading<'c> {
    /// By one gauge along the load: displacement per force.
    AlongLoad(&'c [f64]),
    /// By its components along x, y, z of the base, each with an error of its own: displacement per component, zero of one that was not read.
    ByComponents(&'c [[f64; 3]]),
}

impl ForceReading<'_> {
    /// The largest displacement per force, m/N.
    pub(crate) fn largest(&self) -> f64 {
        match self {
            Self::AlongLoad(compliance) => largest(*compliance),
            Self::ByComponents(components) => largest(components.as_flattened()),
        }
    }
}

impl<'c> From<&'c [f64]> for ForceReading<'c> {
    fn from(compliance: &'c [f64]) -> Self {
        Self::AlongLoad(compliance)
    }
}

/// Which components of forces were read: those that act; where most forces act along all three axes, one that is zero was read as zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ReadForces {
    zeros_too: bool,
}

impl ReadForces {
    /// # Arguments
    /// - `loads`: force and moment of each load in the axes of the base.
    pub(crate) fn of(loads: impl Iterator<Item = [f64; 6]>) -> Self {
        let (mut oblique, mut all) = (0_usize, 0_usize);
        for [x, y, z, ..] in loads {
            all += 1;
            oblique += usize::from(x != 0.0 && y != 0.0 && z != 0.0);
        }
        Self {
            zeros_too: 2 * oblique > all,
        }
    }

    /// Whether each component of the force of a load was read.
    pub(crate) fn components(self, [x, y, z, ..]: [f64; 6]) -> [bool; 3] {
        [x, y, z].map(|force| force != 0.0 || self.zeros_too)
    }
}

/// The covariance of readings under a noise, with what it is made of.
#[derive(Debug, Clone)]
pub(crate) struct NoiseCovariance {
    pub(crate) covariance: Covariance,
    pub(crate) noise: ReadingNoise,
    /// Prediction b of the baseline, which a run's slope multiplies, m.
    pub(crate) slope_m: Vec<f64>,
    rows: RowVariances,
    /// The noise of each session.
    parts: Vec<NoisePart>,
}

impl NoiseCovariance {
    /// The covariance of a noise about a baseline.
    ///
    /// # Arguments
    /// - `slope_m`: prediction of the baseline, m, one a reading.
    /// - `force`: what its error moves.
    pub(crate) fn new<'c>(
        observations: &Observations,
        noise: &ReadingNoise,
        slope_m: &[f64],
        force: impl Into<ForceReading<'c>>,
    ) -> Self {
        let (parts, force) = (observations.noise_parts(noise), force.into());
        let rows = RowVariances::new(&parts, observations, slope_m, force);
        let errors = rows.errors(&parts, observations);
        let blocks = common_parts(&parts, observations, slope_m, force);
        Self {
            covariance: Covariance::with_errors(&rows.whole, &errors, blocks),
            noise: *noise,
            slope_m: slope_m.to_vec(),
            rows,
            parts,
        }
    }

    /// The same with readings that weigh nothing.
    pub(crate) fn without(&self, left_out: &[bool]) -> Self {
        Self {
            covariance: self.covariance.without(left_out),
            ..self.clone()
        }
    }

    /// The inverse of the same covariance, for likelihoods.
    pub(crate) fn precision(
        observations: &Observations,
        noise: &ReadingNoise,
        slope_m: &[f64],
        force: ForceReading<'_>,
    ) -> Precision {
        let parts = observations.noise_parts(noise);
        let rows = RowVariances::new(&parts, observations, slope_m, force);
        let errors = rows.errors(&parts, observations);
        let blocks = common_parts(&parts, observations, slope_m, force);
        Precision::new(&rows.whole, &errors, blocks)
    }

    /// The noise of a reading.
    pub(crate) fn noise_at(&self, reading: usize) -> &ReadingNoise {
        &part_of(&self.parts, reading).noise
    }

    /// Best estimate of each reading without its own error and without its zero, m: where the gauge really stood.
    ///
    /// What scatters in the force and in the slope of a run moved the gauge; what scatters in the reading did not.
    pub(crate) fn positions(&self, observations: &Observations, residual_m: &[f64]) -> Vec<f64> {
        // V⁻¹ r, then the best linear prediction of reading error and zero from it (Henderson, Biometrics 31 (1975)).
        let mut solved = residual_m.to_vec();
        self.covariance.whiten(&mut solved);
        self.covariance.whiten_transposed(&mut solved);
        let mut positions = observations.displacement_m.clone();
        let mut own = solved.clone();
        self.covariance.own_part(&mut own);
        let by_force = self.by_force(observations, &solved);
        for group in self.covariance.block_rows() {
            let zero = self.noise_at(group.start).zero_sd_m.powi(2);
            for_each_zero(observations, group, |member| {
                let members = || group.clone().filter(|&r| member(r));
                let offset = zero * members().map(|r| solved[r]).sum::<f64>();
                for r in members() {
                    positions[r] -= own[r] - by_force[r] + offset;
                }
            });
        }
        positions
    }

    /// The covariance by the error of the force times a vector, one number a reading.
    fn by_force(&self, observations: &Observations, vector: &[f64]) -> Vec<f64> {
        if observations.gauges.is_empty() {
            let weights = self.covariance.weights().iter();
            let variances = weights.zip(&self.rows.own);
            let variances = variances.map(|(weight, own)| (weight * weight).recip() - own);
            return variances
                .zip(vector)
                .map(|(variance, value)| variance * value)
                .collect();
        }
        let force_m = &self.rows.force_m;
        let mut out = vec![0.0; vector.len()];
        for rows in at_once(observations) {
            let sum: f64 = rows.iter().map(|&row| force_m[row] * vector[row]).sum();
            for &row in &rows {
                out[row] = force_m[row] * sum;
            }
        }
        out
    }

    /// Share of its own error in the variance of a reading without zero and slope; the rest is the step of the force.
    pub(crate) fn own_share(&self, reading: usize) -> f64 {
        let weight = self.covariance.weights()[reading];
        let share = self.rows.own[reading] * weight * weight;
        share.clamp(0.0, 1.0)
    }

    /// Shares of reading, zero and run slope in the variance of an amplitude estimated along a white vector; the rest is force step.
    pub(crate) fn variance_shares(
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
        let by_force = self.by_force(observations, scratch);
        let products = scratch.iter().zip(own.iter().zip(&by_force));
        let reading: f64 = products.map(|(a, (own, force))| a * (own - force)).sum();
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
        for group in self.covariance.block_rows() {
            let noise = self.noise_at(group.start);
            for_each_slope(observations, noise, group, |slope_sd, member| {
                let members = group.clone().filter(|&r| member(r));
                let sum: f64 = members.map(|r| scratch[r] * self.slope_m[r]).sum();
                slope += slope_sd.powi(2) * sum * sum;
            });
        }
        [reading / square, zero / square, slope / square]
    }
}

/// The part of a reading.
fn part_of(parts: &[NoisePart], reading: usize) -> &NoisePart {
    let place = parts.partition_point(|part| part.readings.end <= reading);
    &parts[place.min(parts.len() - 1)]
}

/// What each reading has by itself.
#[derive(Debug, Clone)]
struct RowVariances {
    /// By its own errors, m².
    own: Vec<f64>,
    /// What an error of the force by one standard deviation moves, m; nothing where its components were read each by itself.
    force_m: Vec<f64>,
    /// By both, m².
    whole: Vec<f64>,
}

impl RowVariances {
    fn new(
        parts: &[NoisePart],
        observations: &Observations,
        slope_m: &[f64],
        force: ForceReading<'_>,
    ) -> Self {
        let mut rows = Self {
            own: Vec::with_capacity(observations.len()),
            force_m: Vec::with_capacity(observations.len()),
            whole: Vec::with_capacity(observations.len()),
        };
        for part in parts {
            let (noise, force_variance) = (part.noise, part.force_variance());
            for reading in part.readings.clone() {
                let c = match force {
                    ForceReading::AlongLoad(compliance) => compliance[reading],
                    ForceReading::ByComponents(_) => 0.0,
                };
                let of_force = if observations.loads[reading].force_n == 0.0 {
                    0.0
                } else {
                    force_variance * c * c
                };
                let read = &observations.cells[observations.cell_of(reading)].read;
                let own = noise.own_variance(read, slope_m[reading]);
                rows.own.push(own);
                rows.force_m.push(c.signum() * of_force.sqrt());
                rows.whole.push(own + of_force);
            }
        }
        rows
    }

    /// What rows have in common with those before them: scatter remembers, the steps of the gauges do not.
    fn errors(&self, parts: &[NoisePart], observations: &Observations) -> RowErrors {
        let no_memory = parts.iter().all(|part| part.noise.correlation == 0.0);
        if !observations.gauges.is_empty() {
            if no_memory && self.force_m.iter().all(|moved| *moved == 0.0) {
                return RowErrors::Correlated(Vec::new());
            }
            return RowErrors::Common(self.states_in_common(parts, observations));
        }
        if no_memory {
            return RowErrors::Correlated(Vec::new());
        }
        let all = 0..observations.len();
        let mut correlations: Vec<RowCorrelation> = all
            .map(|reading| RowCorrelation {
                correlation: part_of(parts, reading).noise.correlation,
                share: self.remembering_share(parts, reading),
            })
            .collect();
        for run in &observations.runs {
            if let Some(first) = correlations.get_mut(run.readings.start) {
                first.correlation = 0.0;
            }
        }
        RowErrors::Correlated(correlations)
    }

    /// Share of a reading's variance that remembers: its own without the step of the gauge.
    fn remembering_share(&self, parts: &[NoisePart], reading: usize) -> f64 {
        let step_m = part_of(parts, reading).steps.displacement_m.unwrap_or(0.0);
        let of_step = step_m * step_m / 12.0;
        ((self.own[reading] - of_step) / self.whole[reading]).clamp(0.0, 1.0)
    }

    /// The rows of several gauges as they come: each gauge with its correlation, and the error of the force, which begins anew with each reading.
    fn states_in_common(
        &self,
        parts: &[NoisePart],
        observations: &Observations,
    ) -> Vec<RowStates<MOST_STATES>> {
        const FORCE: usize = MOST_STATES - 1;
        let mut out = Vec::with_capacity(observations.len());
        let mut before = None;
        for rows in at_once(observations) {
            for (place, &row) in rows.iter().enumerate() {
                let run = &observations.runs[observations.readings[row].run];
                let cell = &observations.cells[run.cell];
                let axis = cell.axis().index();
                let remembers = part_of(parts, row).noise.correlation;
                // Between the rows of one reading nothing changes but the state of the gauge at its turn.
                let mut correlation = [1.0; MOST_STATES];
                correlation[axis] = remembers;
                if place == 0 {
                    correlation[FORCE] = 0.0;
                    let own = (cell.pose, cell.load.called(), run.session_run);
                    if before.as_ref() != Some(&own) {
                        correlation = [0.0; MOST_STATES];
                        before = Some(own);
                    }
                }
                let mut has = [0.0; MOST_STATES];
                if remembers != 0.0 {
                    has[axis] = self.remembering_share(parts, row).sqrt();
                }
                has[FORCE] = self.force_m[row] / self.whole[row].sqrt();
                out.push(RowStates {
                    row,
                    correlation,
                    has,
                });
            }
        }
        out
    }
}

/// Rows of several gauges that were read at once, as they came: series by series, run by run.
fn at_once(observations: &Observations) -> Vec<Vec<usize>> {
    let mut out: Vec<Vec<usize>> = Vec::new();
    for cells in observations.series() {
        let cells = &observations.cells[cells];
        let (Some(first), Some(last)) = (cells.first(), cells.last()) else {
            continue;
        };
        let key = |row: &usize| {
            let reading = &observations.readings[*row];
            (observations.runs[reading.run].session_run, reading.seq)
        };
        let mut rows: Vec<usize> = (first.readings.start..last.readings.end).collect();
        rows.sort_by_key(key);
        let readings = rows.chunk_by(|a, b| key(a) == key(b));
        out.extend(readings.map(<[usize]>::to_vec));
    }
    out
}

/// What the readings of each group have in common.
fn common_parts(
    parts: &[NoisePart],
    observations: &Observations,
    slope_m: &[f64],
    force: ForceReading<'_>,
) -> impl Iterator<Item = LowRankBlock> {
    groups(observations).map(move |readings| {
        let part = part_of(parts, readings.start);
        common_part(observations, part, slope_m, force, readings)
    })
}

/// What readings of a range have in common: a column σ₀ 1 for each zero and σₛ b for each run, and of a force that was read by its components one for
/// each of them that rounds it, common to all readings that show the same, and one in each run for what else scatters.
fn common_part(
    observations: &Observations,
    part: &NoisePart,
    slope_m: &[f64],
    force: ForceReading<'_>,
    readings: Range<usize>,
) -> LowRankBlock {
    let noise = &part.noise;
    let mut columns = Vec::with_capacity(2 * readings.len());
    let only = |member: bool, value: f64| if member { value } else { 0.0 };
    for_each_zero(observations, &readings, |member| {
        let each = readings.clone();
        columns.extend(each.map(|r| only(member(r), noise.zero_sd_m)));
    });
    for_each_slope(observations, noise, &readings, |slope_sd, member| {
        let each = readings.clone();
        columns.extend(each.map(|r| only(member(r), slope_sd * slope_m[r])));
    });
    if let ForceReading::ByComponents(components) = force {
        let step_sd_n = part.force_step_variance().sqrt();
        let alike = ReadingNoise {
            run_slope_sd: noise.gauges.force_sd_n,
            gauges: GaugeNoise::ALIKE,
            ..*noise
        };
        let acts = |axis: &usize| readings.clone().any(|r| components[r][*axis] != 0.0);
        for axis in (0..3).filter(acts) {
            if step_sd_n > 0.0 {
                for_each_load(observations, &readings, |member| {
                    let each = readings.clone();
                    columns.extend(each.map(|r| only(member(r), step_sd_n * components[r][axis])));
                });
            }
            if alike.run_slope_sd > 0.0 {
                for_each_slope(observations, &alike, &readings, |force_sd_n, member| {
                    let each = readings.clone();
                    columns.extend(each.map(|r| only(member(r), force_sd_n * components[r][axis])));
                });
            }
        }
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

/// Calls `action` once for each load that a range shows, with the test of membership: what the gauge rounds off is the same each time it shows
/// the same.
fn for_each_load(
    observations: &Observations,
    readings: &Range<usize>,
    mut action: impl FnMut(&dyn Fn(usize) -> bool),
) {
    let shown = |reading: usize| observations.loads[reading].force_n.to_bits();
    let mut seen: Vec<u64> = Vec::new();
    for load in readings.clone().map(shown) {
        if !seen.contains(&load) {
            seen.push(load);
            action(&|other| shown(other) == load);
        }
    }
}

/// Calls `action` once for each slope of a run of a range, with its standard deviation and the test of membership: the slope that all gauges
/// have in common, and that of each gauge alone where it has one.
fn for_each_slope(
    observations: &Observations,
    noise: &ReadingNoise,
    readings: &Range<usize>,
    mut action: impl FnMut(f64, &dyn Fn(usize) -> bool),
) {
    let run_of = |reading: usize| observations.readings[reading].run;
    let session_run_of = |reading: usize| observations.runs[run_of(reading)].session_run;
    let mut seen: Vec<u32> = Vec::new();
    let mut run = usize::MAX;
    for first in readings.clone() {
        if run_of(first) == run {
            continue;
        }
        run = run_of(first);
        let session_run = session_run_of(first);
        // A run that was found again after another is the same in all gauges, and another one where there is but one.
        if observations.gauges.is_empty() {
            action(noise.run_slope_sd, &|reading| run_of(reading) == run);
        } else if !seen.contains(&session_run) {
            seen.push(session_run);
            let is_of_run = |reading: usize| session_run_of(reading) == session_run;
            action(noise.run_slope_sd, &is_of_run);
        }
        if noise.gauges.own_slope_sd > 0.0 {
            action(noise.gauges.own_slope_sd, &|reading| run_of(reading) == run);
        }
    }
}

/// Ranges of readings that share no zero, no run and no load applied alone with the rest.
///
/// Runs that share a zero lie in one cell; a cell with shared zeros, or loads one by one that show the same force, is one group, of at most thirty runs at a time: the rank of a
/// group is bounded, and a zero that spans more is split, which only widens what is allowed to scatter. The cells of several gauges that were
/// read at once are one group.
pub(crate) fn groups(observations: &Observations) -> impl Iterator<Item = Range<usize>> + '_ {
    const MOST_RUNS: usize = 30;
    observations.series().flat_map(move |cells| {
        let mut out: Vec<Range<usize>> = Vec::new();
        let cell = &observations.cells[cells.start];
        if cells.len() > 1 {
            out.push(cell.readings.start..observations.cells[cells.end - 1].readings.end);
            return out;
        }
        let mut runs_in_last = 0;
        let mut last_zeros: Vec<u32> = Vec::new();
        for run in &observations.runs[cell.runs.clone()] {
            let zeros: Vec<u32> = observations.readings[run.readings.clone()]
                .iter()
                .map(|reading| reading.zero)
                .collect();
            let of_one = run.readings.len() == 1;
            let same_load = |before: &Range<usize>| {
                let shown = |reading: usize| observations.loads[reading].force_n;
                of_one && shown(before.end - 1) == shown(run.readings.start)
            };
            let shared = out.last().is_some_and(same_load)
                || zeros.iter().any(|zero| last_zeros.contains(zero));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::GaugeSteps;
    use crate::mismatch::observed::tests::two_gauges;

    /// Checks the inverse of a covariance against its entries, by row and column.
    fn assert_covariance_is(
        found: &NoiseCovariance,
        n: usize,
        expected: impl Fn(usize, usize) -> f64,
    ) {
        for column in 0..n {
            let mut unit: Vec<f64> = (0..n).map(|row| expected(row, column)).collect();
            found.covariance.whiten(&mut unit);
            found.covariance.whiten_transposed(&mut unit);
            for (row, value) in unit.iter().enumerate() {
                let identity = f64::from(u8::from(row == column));
                assert!((value - identity).abs() < 1e-9, "{row} {column}: {value}");
            }
        }
    }

    #[test]
    fn a_zero_among_oblique_forces_was_read() {
        let oblique = [3.1, -2.0, 0.4, 0.0, 0.0, 0.0];
        let (flat, along) = (
            [3.1, 0.0, 0.4, 0.0, 0.0, 0.0],
            [0.0, 0.0, 5.0, 0.0, 0.0, 0.0],
        );
        let read = |loads: &[[f64; 6]]| ReadForces::of(loads.iter().copied()).components(flat);
        assert_eq!(read(&[oblique, oblique, flat]), [true; 3]);
        assert_eq!(read(&[along, flat, oblique]), [true, false, true]);
    }

    #[test]
    fn what_gauges_have_in_common_is_common() {
        let noise = ReadingNoise {
            reading_sd_m: 1e-6,
            zero_sd_m: 2e-6,
            run_slope_sd: 0.01,
            growth_sd: 0.0,
            correlation: 0.4,
            gauges: GaugeNoise {
                reading_ratios: [1.0, 1.5, 0.8],
                rotation_ratio: 1.0,
                own_slope_sd: 0.004,
                force_sd_n: 0.05,
            },
        };
        let mut both = two_gauges();
        both.steps = GaugeSteps {
            force_n: Some(0.1),
            displacement_m: Some(1e-6),
        };
        let n = both.len();
        let compliance: Vec<f64> = (0..n)
            .map(|row| if row < n / 2 { 2e-6 } else { -1e-6 })
            .collect();
        let loads = both.loads.iter().zip(&compliance);
        let slope_m: Vec<f64> = loads.map(|(load, c)| c * load.force_n).collect();
        let found = NoiseCovariance::new(&both, &noise, &slope_m, &compliance[..]);
        // By the formulas at the head of this file, row by row.
        let force_variance = 0.1_f64.powi(2) / 12.0 + 0.05_f64.powi(2);
        let ratio = |row: usize| if row < n / 2 { 1.5 } else { 0.8 };
        let expected = |i: usize, j: usize| {
            let (a, b) = (&both.readings[i], &both.readings[j]);
            let session_run = |row: usize| both.runs[both.readings[row].run].session_run;
            let mut sum = 0.0;
            if a.run == b.run {
                let remembered =
                    |row: usize| ((ratio(row) * 1e-6_f64).powi(2) - 1e-12 / 12.0).sqrt();
                let apart = i32::try_from(i.abs_diff(j)).unwrap();
                sum += remembered(i) * remembered(j) * 0.4_f64.powi(apart);
                sum += 0.004_f64.powi(2) * slope_m[i] * slope_m[j];
            }
            if i == j {
                sum += 1e-12 / 12.0;
            }
            if a.zero == b.zero {
                sum += 4e-12;
            }
            if session_run(i) == session_run(j) {
                sum += 1e-4 * slope_m[i] * slope_m[j];
                if a.seq == b.seq && both.loads[i].force_n != 0.0 {
                    sum += force_variance * compliance[i] * compliance[j];
                }
            }
            sum
        };
        assert_covariance_is(&found, n, expected);
    }

    #[test]
    fn what_a_force_is_rounded_by_is_common_to_repeats_that_show_the_same() {
        let noise = ReadingNoise {
            reading_sd_m: 1e-6,
            gauges: GaugeNoise {
                force_sd_n: 0.05,
                ..GaugeNoise::ALIKE
            },
            ..ReadingNoise::default()
        };
        let mut both = two_gauges();
        both.steps = GaugeSteps {
            force_n: Some(0.1),
            displacement_m: None,
        };
        let n = both.len();
        let by_force: Vec<[f64; 3]> = (0..n)
            .map(|row| [2e-6, -1e-6 * (row % 3) as f64, 0.0])
            .collect();
        let slope_m = vec![0.0; n];
        let force = ForceReading::ByComponents(&by_force);
        let found = NoiseCovariance::new(&both, &noise, &slope_m, force);
        let session_run = |row: usize| both.runs[both.readings[row].run].session_run;
        let expected = |i: usize, j: usize| {
            let moved: f64 = by_force[i]
                .iter()
                .zip(by_force[j])
                .map(|(a, b)| a * b)
                .sum();
            let shown = |row: usize| both.loads[row].force_n;
            let step = f64::from(u8::from(shown(i) == shown(j))) * 0.01 / 12.0;
            let scatter = f64::from(u8::from(session_run(i) == session_run(j))) * 0.05_f64.powi(2);
            let own = f64::from(u8::from(i == j)) * 1e-12;
            own + (step + scatter) * moved
        };
        assert!((0..n).any(|i| session_run(i) != session_run(0) && expected(i, 0) != 0.0));
        assert_covariance_is(&found, n, expected);
    }
}
