//! Compliances of cells by generalised least squares: what the readings of a session say of the linear structure, in one number a cell.
//!
//! ```text
//!   y = X c + e, cov(e) = V (noise.rs); a column of X holds the forces of one cell
//!   c = L y,   L = (Xᵀ V⁻¹ X)⁻¹ Xᵀ V⁻¹,   cov(c) = (Xᵀ V⁻¹ X)⁻¹
//! ```
//!
//! A linear model that is fitted to them under their covariance has the values and the intervals that it would have by the readings.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Cell, Direction};

use super::covariance::NoiseCovariance;
use super::estimated_noise::EstimatedNoise;
use super::restricted_likelihood::estimate_noise;
use crate::mismatch::observed::{Observations, ReadingNoise};
use crate::search::largest;

/// How often compliances and noise are found from each other: the noise hardly depends on the compliances.
const ROUNDS: usize = 2;

/// Most loads of a run; of more, neighbours are averaged: the line through them stays what it is, and the effort grows with the cube.
const MOST_LOADS: usize = 40;

/// Compliances of all cells of a session, with their covariance.
#[derive(Debug, Clone)]
pub struct CellSlopes {
    /// The readings.
    pub observations: Observations,
    /// The noise of the readings.
    pub noise: ReadingNoise,
    /// Degrees of freedom of the variance of a compliance, the mean over the cells (Satterthwaite).
    pub dof: f64,
    /// Whether the noise is from repeats; else it is the scatter about the lines, and the slope of a run has none.
    pub from_repeats: bool,
    /// Cells whose readings have noise in common.
    pub series: Vec<SeriesSlopes>,
}

/// Compliances of cells whose readings have noise in common: those of the gauges that were read at once.
#[derive(Debug, Clone)]
pub struct SeriesSlopes {
    /// Their cells.
    pub cells: Vec<Cell>,
    /// Direction of their loads.
    pub load: LoadDirection,
    /// Their compliances, m/N.
    pub compliance_m_per_n: DVector<f64>,
    /// Covariance of these, m²/N².
    pub covariance: DMatrix<f64>,
    /// Runs that they were made from.
    pub(crate) runs: Range<usize>,
    /// First of their readings.
    first: usize,
    /// L: a row a cell, a column a reading, 1/N.
    estimator: DMatrix<f64>,
}

impl SeriesSlopes {
    /// The compliance that the estimator of a cell makes of displacements, m/N.
    ///
    /// # Arguments
    /// - `displacement_m`: those of the readings of the series.
    pub(crate) fn estimate(&self, cell: usize, displacement_m: &[f64]) -> f64 {
        let weights = self.estimator.row(cell);
        let products = weights.iter().zip(displacement_m);
        products.map(|(weight, shown)| weight * shown).sum()
    }

    /// Its readings, as they lie in the observations.
    pub(crate) fn readings(&self) -> Range<usize> {
        self.first..self.first + self.estimator.ncols()
    }
}

impl CellSlopes {
    /// Of readings; `None` if a cell was never loaded, or the readings determine no line.
    #[must_use]
    pub fn new(observations: Observations) -> Option<Self> {
        let observations = averaged(observations);
        let mut compliance = plain_slopes(&observations)?;
        let from_repeats = observations.cells.iter().any(|cell| cell.runs.len() > 1);
        let mut found: Option<(EstimatedNoise, NoiseCovariance, Vec<SeriesSlopes>)> = None;
        for _ in 0..ROUNDS {
            let of_reading = |reading| compliance[observations.cell_of(reading)];
            let slopes: Vec<f64> = (0..observations.len()).map(of_reading).collect();
            let forces = observations.loads.iter().map(|load| load.force_n);
            let slope_m: Vec<f64> = slopes
                .iter()
                .zip(forces)
                .map(|(c, force)| c * force)
                .collect();
            let shown = observations.displacement_m.iter().zip(&slope_m);
            let residual_m: Vec<f64> = shown.map(|(shown, line)| shown - line).collect();
            let noise = if from_repeats {
                let warm_start = found.as_ref().map(|(noise, ..)| &noise.noise);
                let linear = (&slope_m[..], slopes.as_slice().into());
                estimate_noise(&observations, &residual_m, linear, warm_start, None, None)
            } else {
                noise_about_lines(&observations, &residual_m)
            };
            let covariance =
                NoiseCovariance::new(&observations, &noise.noise, &slope_m, &slopes[..]);
            let series = all_series(&observations, &covariance)?;
            compliance = series
                .iter()
                .flat_map(|series| series.compliance_m_per_n.iter().copied())
                .collect();
            found = Some((noise, covariance, series));
        }
        let (noise, covariance, series) = found?;
        let dof = degrees_of_freedom(&observations, &noise, &covariance);
        Some(Self {
            noise: noise.noise,
            dof,
            from_repeats,
            series,
            observations,
        })
    }

    /// The series of a cell and its place there.
    #[must_use]
    pub fn find(&self, cell: &Cell) -> Option<[usize; 2]> {
        let mut series = self.series.iter().enumerate();
        series.find_map(|(number, series)| {
            let place = series.cells.iter().position(|own| own == cell)?;
            Some([number, place])
        })
    }

    /// Stiffness of a cell, N/m, and the standard uncertainty of its logarithm.
    #[must_use]
    pub fn stiffness(&self, cell: &Cell) -> Option<(f64, f64)> {
        let [series, place] = self.find(cell)?;
        let series = &self.series[series];
        let compliance = series.compliance_m_per_n[place];
        let u = series.covariance[(place, place)].sqrt();
        (compliance > 0.0).then(|| (compliance.recip(), u / compliance))
    }
}

/// Readings of long runs, averaged with their neighbours.
fn averaged(observations: Observations) -> Observations {
    let lengths = observations.runs.iter().map(|run| run.readings.len());
    let together = lengths.max().unwrap_or(0).div_ceil(MOST_LOADS);
    if together < 2 {
        return observations;
    }
    let mut groups: Vec<(u32, Range<usize>)> = Vec::new();
    for run in &observations.runs {
        let firsts = run.readings.clone().step_by(together);
        let ends = firsts.map(|first| first..run.readings.end.min(first + together));
        groups.extend((0..).zip(ends));
    }
    let mut is_first = vec![false; observations.len()];
    for (_, group) in &groups {
        is_first[group.start] = true;
    }
    let mut averaged = observations.filtered(&is_first);
    for (place, (step, group)) in groups.into_iter().enumerate() {
        let count = group.len() as f64;
        let forces = observations.loads[group.clone()].iter();
        let load = &mut averaged.loads[place];
        load.force_n = forces.map(|load| load.force_n).sum::<f64>() / count;
        load.step = step;
        averaged.readings[place].hold_number = 0;
        averaged.displacement_m[place] =
            observations.displacement_m[group].iter().sum::<f64>() / count;
    }
    averaged
}

/// Slope of each cell through the origin.
fn plain_slopes(observations: &Observations) -> Option<Vec<f64>> {
    let slope = |readings: Range<usize>| {
        let (mut products, mut squares) = (0.0, 0.0);
        for reading in readings {
            let force_n = observations.loads[reading].force_n;
            products += force_n * observations.displacement_m[reading];
            squares += force_n * force_n;
        }
        (squares > 0.0).then(|| products / squares)
    };
    let cells = observations.cells.iter();
    cells.map(|cell| slope(cell.readings.clone())).collect()
}

/// The noise of readings without repeats: each gauge scatters about the line of its cell, whose zero may be anything.
fn noise_about_lines(observations: &Observations, residual_m: &[f64]) -> EstimatedNoise {
    let (mut squares, mut counts) = ([0.0; 3], [0.0; 3]);
    for cell in &observations.cells {
        let own = cell.readings.clone();
        let forces = || {
            own.clone()
                .map(|reading| observations.loads[reading].force_n)
        };
        let rows = own.len() as f64;
        let (mean_n, mean_m) = (
            forces().sum::<f64>() / rows,
            residual_m[own.clone()].iter().sum::<f64>() / rows,
        );
        let about = || forces().zip(&residual_m[own.clone()]);
        let products: f64 = about().map(|(f, r)| (f - mean_n) * (r - mean_m)).sum();
        let spread: f64 = forces().map(|f| (f - mean_n).powi(2)).sum();
        let all: f64 = about().map(|(_, r)| (r - mean_m).powi(2)).sum();
        let axis = cell.axis().index();
        squares[axis] += (all - products * products / spread.max(f64::MIN_POSITIVE)).max(0.0);
        counts[axis] += (rows - 2.0).max(0.0);
    }
    let step_m = observations.steps.displacement_m.unwrap_or(0.0);
    let least = (step_m * step_m / 12.0).max(1e-18);
    let variance = Direction::ALL.map(|axis| {
        let axis = axis.index();
        (squares[axis] / counts[axis].max(1.0)).max(least)
    });
    let seen = variance
        .iter()
        .zip(counts)
        .filter(|(_, count)| *count > 0.0);
    let logs: Vec<f64> = seen.map(|(variance, _)| 0.5 * variance.ln()).collect();
    let reading_sd_m = (logs.iter().sum::<f64>() / logs.len().max(1) as f64).exp();
    let mut noise = ReadingNoise {
        reading_sd_m,
        zero_sd_m: 10.0 * largest(&observations.displacement_m),
        ..ReadingNoise::default()
    };
    noise.gauges.reading_ratios = variance.map(|variance| variance.sqrt() / reading_sd_m);
    EstimatedNoise::of_readings(noise, counts.iter().sum())
}

/// Generalised least squares of every series.
fn all_series(
    observations: &Observations,
    covariance: &NoiseCovariance,
) -> Option<Vec<SeriesSlopes>> {
    let mut white_m = observations.displacement_m.clone();
    covariance.covariance.whiten(&mut white_m);
    let columns = white_columns(observations, covariance);
    // V⁻¹ X: no noise is common to two series.
    let mut weighted = columns.clone();
    for column in &mut weighted {
        covariance.covariance.whiten_transposed(column);
    }
    let of_series = |cells: Range<usize>| {
        let (first, last) = (
            observations.cells.get(cells.start)?,
            observations.cells.get(cells.end.checked_sub(1)?)?,
        );
        let rows = first.readings.start..last.readings.end;
        let count = cells.len();
        let white = DMatrix::from_fn(rows.len(), count, |row, cell| {
            columns[cell][rows.start + row]
        });
        let normal = white.transpose() * &white;
        let inverse = normal.cholesky()?.inverse();
        let shown = DVector::from_column_slice(&white_m[rows.clone()]);
        let compliance_m_per_n = &inverse * (white.transpose() * shown);
        let weights = DMatrix::from_fn(count, rows.len(), |cell, row| {
            weighted[cell][rows.start + row]
        });
        let named = cells.clone().map(|cell| &observations.cells[cell]);
        Some(SeriesSlopes {
            cells: named.map(|cell| observations.named(cell)).collect(),
            load: first.load.clone(),
            compliance_m_per_n,
            runs: first.runs.start..last.runs.end,
            first: rows.start,
            estimator: &inverse * weights,
            covariance: inverse,
        })
    };
    observations.series().map(of_series).collect()
}

/// White forces of the cells that are first, second … in their series.
fn white_columns(observations: &Observations, covariance: &NoiseCovariance) -> Vec<Vec<f64>> {
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for cells in observations.series() {
        for (place, cell) in cells.enumerate() {
            if columns.len() == place {
                columns.push(vec![0.0; observations.len()]);
            }
            for reading in observations.cells[cell].readings.clone() {
                columns[place][reading] = observations.loads[reading].force_n;
            }
        }
    }
    for column in &mut columns {
        covariance.covariance.whiten(column);
    }
    columns
}

/// Those of the variance of a compliance, by the mean of its shares over the cells.
fn degrees_of_freedom(
    observations: &Observations,
    noise: &EstimatedNoise,
    covariance: &NoiseCovariance,
) -> f64 {
    let columns = white_columns(observations, covariance);
    let mut scratch = Vec::new();
    let mut mean = [0.0; 3];
    for column in &columns {
        let shares = covariance.variance_shares(observations, column, &mut scratch);
        for (mean, share) in mean.iter_mut().zip(shares) {
            *mean += share / columns.len() as f64;
        }
    }
    noise.degrees_of_freedom(mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::observed::tests::two_gauges;
    use stiffbench_beams::physics::LoadPoint;

    #[test]
    fn slopes_are_those_of_dense_matrices() {
        let mut both = two_gauges();
        let n = both.len();
        let mut noise = ReadingNoise {
            reading_sd_m: 1e-6,
            zero_sd_m: 2e-6,
            run_slope_sd: 0.01,
            ..ReadingNoise::default()
        };
        noise.gauges.force_sd_n = 0.05;
        let truth = |row: usize| if row < n / 2 { 2e-6 } else { -1e-6 };
        let compliance: Vec<f64> = (0..n).map(truth).collect();
        let line = |row: usize| truth(row) * both.loads[row].force_n;
        let slope_m: Vec<f64> = (0..n).map(line).collect();
        let covariance = NoiseCovariance::new(&both, &noise, &slope_m, &compliance[..]);
        // Exact readings have the true slopes, and so do those off by what the weights do not see.
        both.displacement_m.clone_from(&slope_m);
        let exact = all_series(&both, &covariance).unwrap();
        let [series] = &exact[..] else {
            panic!("{} series", exact.len())
        };
        assert!((series.compliance_m_per_n[0] / 2e-6 - 1.0).abs() < 1e-12);
        assert!((series.compliance_m_per_n[1] / -1e-6 - 1.0).abs() < 1e-12);
        for (row, shown) in both.displacement_m.iter_mut().enumerate() {
            *shown += 1e-6 * ((7 * row % 5) as f64 - 2.0);
        }
        let found = all_series(&both, &covariance).unwrap();
        let inverse = DMatrix::from_fn(n, n, |row, column| {
            let mut unit = vec![0.0; n];
            unit[column] = 1.0;
            covariance.covariance.whiten(&mut unit);
            covariance.covariance.whiten_transposed(&mut unit);
            unit[row]
        });
        let forces = DMatrix::from_fn(n, 2, |row, cell| {
            let is_own = usize::from(row >= n / 2) == cell;
            if is_own { both.loads[row].force_n } else { 0.0 }
        });
        let shown = DVector::from_column_slice(&both.displacement_m);
        let normal = (forces.transpose() * &inverse * &forces)
            .try_inverse()
            .unwrap();
        let expected = &normal * forces.transpose() * &inverse * &shown;
        let series = &found[0];
        for cell in 0..2 {
            let (slope, variance) = (expected[cell], normal[(cell, cell)]);
            assert!((series.compliance_m_per_n[cell] - slope).abs() < 1e-9 * slope.abs());
            assert!((series.covariance[(cell, 0)] - normal[(cell, 0)]).abs() < 1e-9 * variance);
            assert!(
                (series.estimate(cell, &both.displacement_m) - slope).abs() < 1e-9 * slope.abs()
            );
        }
    }

    #[test]
    fn long_runs_keep_their_slopes_when_neighbours_are_averaged() {
        let both = two_gauges();
        let mut long = Observations::without_readings(both.steps, both.recorded);
        (long.poses, long.gauges) = (both.poses.clone(), both.gauges.clone());
        for cell in &both.cells {
            long.begin_cell(cell.pose, cell.load.clone(), cell.read);
            for run in &both.runs[cell.runs.clone()] {
                long.begin_run(run.repeat, run.session_run);
                for step in 0..101 {
                    let first = run.readings.start;
                    let load = LoadPoint {
                        force_n: -0.7 * f64::from(step),
                        step,
                        ..both.loads[first]
                    };
                    let scatter_m = 1e-7 * (f64::from(7 * step % 5) - 2.0);
                    let shown_m = 2e-6 * load.force_n + scatter_m;
                    long.push(both.readings[first], load, shown_m);
                }
            }
        }
        let found = CellSlopes::new(long).unwrap();
        assert!(
            found
                .observations
                .runs
                .iter()
                .all(|run| run.readings.len() == 34)
        );
        for series in &found.series {
            for compliance in &series.compliance_m_per_n {
                // A scatter of 0.14 um over 101 loads up to 70 N: three times 0.7 nm/N.
                assert!((compliance - 2e-6).abs() < 2e-9, "{compliance}");
            }
        }
    }

    #[test]
    fn readings_without_repeats_scatter_about_their_lines() {
        let both = two_gauges();
        let first: Vec<bool> = both
            .readings
            .iter()
            .map(|one| both.runs[one.run].repeat == 1)
            .collect();
        let mut once = both.filtered(&first);
        for (row, shown) in once.displacement_m.iter_mut().enumerate() {
            *shown =
                1e-6 * once.loads[row].force_n + 3e-6 + 1e-7 * f64::from(u8::from(row % 2 == 0));
        }
        let found = CellSlopes::new(once).unwrap();
        assert!(!found.from_repeats && found.noise.run_slope_sd == 0.0);
        assert!(
            (4e-8..8e-8).contains(&found.noise.reading_sd_m),
            "{:?}",
            found.noise
        );
        for (slope, u) in found
            .series
            .iter()
            .map(|one| (one.compliance_m_per_n[0], one.covariance[(0, 0)].sqrt()))
        {
            assert!((slope - 1e-6).abs() < 3.0 * u && u < 1e-8, "{slope} {u}");
        }
    }
}
