//! Variances of the noise from the readings, alone or together with what earlier sessions tell.
//!
//! Restricted likelihood of Patterson and Thompson, Biometrika 58 (1971): the mean of every load step of every cell is left free, so
//! that no physics that repeats itself can pass for noise. What is left is the scatter between runs.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rayon::prelude::*;

use stiffbench_numeric::simd::{sums_side_by_side, widest};

use super::earlier_noise::EarlierNoise;
use super::noise::{NoiseCovariance, ReadingNoise};
use super::observations::Observations;
use crate::search::constants::{PRIOR_LOG_VARIANCE_SD, PRIOR_RUN_SLOPE_SD, SAME_STEP};

/// Standard deviations are found between these multiples of the start.
const RANGE: f64 = 1e4;

/// The noise with what is known of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatedNoise {
    /// The standard deviations.
    pub noise: ReadingNoise,
    /// Covariance of the logarithms of the three variances: reading, zero, run slope.
    pub covariance: [[f64; 3]; 3],
    /// Whether each cell has several runs, so that the scatter between runs is seen apart from the mean.
    pub from_repeats: bool,
}

impl EstimatedNoise {
    /// Degrees of freedom of a variance with these shares of the three (Satterthwaite).
    #[must_use]
    pub fn degrees_of_freedom(&self, shares: [f64; 3]) -> f64 {
        let mut variance = 0.0;
        for i in 0..3 {
            for j in 0..3 {
                variance += shares[i] * self.covariance[i][j] * shares[j];
            }
        }
        // Below two degrees of freedom a quantile carries no information; above a million it is the normal one.
        (2.0 / variance.max(2e-6)).clamp(2.0, 1e6)
    }
}

/// Fixed part of one cell: what may be anything without being noise.
struct FixedPart {
    columns: Vec<Vec<f64>>,
    readings: std::ops::Range<usize>,
}

/// Finds the variances.
///
/// # Arguments
/// - `residual_m`: readings minus the baseline (and minus effects already found), m.
/// - `slope_m`, `compliance`: the baseline's prediction and compliance at each reading.
/// - `warm_start`: the noise of a similar baseline, to start from.
/// - `earlier`: how earlier sessions scattered; the noise is the likeliest for these readings and those.
#[must_use]
pub(super) fn estimate_noise(
    observations: &Observations,
    residual_m: &[f64],
    (slope_m, compliance): (&[f64], &[f64]),
    warm_start: Option<&ReadingNoise>,
    earlier: Option<&EarlierNoise>,
) -> EstimatedNoise {
    let fixed: Vec<FixedPart> = (0..observations.cells.len())
        .map(|cell| fixed_part(observations, cell))
        .collect();
    let from_repeats = observations.cells.iter().any(|cell| cell.runs.len() > 1);
    let floor_m = observations
        .steps
        .displacement_m
        .map_or(1e-9, |step| (step / 12.0_f64.sqrt()).max(1e-9));
    let problem = VarianceProblem {
        observations,
        fixed,
        residual_m,
        slope_m,
        compliance,
        earlier,
        floor_m,
        free_zero_sd_m: 10.0
            * observations
                .displacement_m
                .iter()
                .fold(0.0_f64, |largest, d| largest.max(d.abs())),
    };
    let rough = problem.rough_sd();
    let centre = Vector3::new(
        (rough * rough).ln(),
        (rough * rough).ln(),
        PRIOR_RUN_SLOPE_SD.powi(2).ln(),
    );
    let start = warm_start.map_or(centre, |warm_start| {
        problem.log_variances(warm_start, &centre)
    });
    let (best, hessian) = problem.maximise(start, &centre);
    let covariance = hessian
        .try_inverse()
        .unwrap_or_else(|| Matrix3::identity() * 2.0);
    EstimatedNoise {
        noise: problem.noise(&best),
        covariance: std::array::from_fn(|i| std::array::from_fn(|j| covariance[(i, j)])),
        from_repeats,
    }
}

struct VarianceProblem<'a> {
    observations: &'a Observations,
    fixed: Vec<FixedPart>,
    residual_m: &'a [f64],
    slope_m: &'a [f64],
    compliance: &'a [f64],
    earlier: Option<&'a EarlierNoise>,
    floor_m: f64,
    /// What a zero that may be anything scatters by, m.
    free_zero_sd_m: f64,
}

impl VarianceProblem<'_> {
    fn noise(&self, log_variances: &Vector3<f64>) -> ReadingNoise {
        let [reading, zero, slope] = [0, 1, 2].map(|i| (0.5 * log_variances[i]).exp());
        let zero = if self.observations.free_zeros {
            self.free_zero_sd_m
        } else {
            zero
        };
        ReadingNoise {
            reading_sd_m: reading.hypot(self.floor_m),
            zero_sd_m: zero,
            run_slope_sd: slope,
        }
    }

    /// The logarithms of variances that give a noise, within range of `centre`; a zero that may be anything has none.
    fn log_variances(&self, noise: &ReadingNoise, centre: &Vector3<f64>) -> Vector3<f64> {
        let reading = noise.reading_sd_m.powi(2) - self.floor_m.powi(2);
        let zero = if self.observations.free_zeros {
            centre[1]
        } else {
            2.0 * noise.zero_sd_m.ln()
        };
        let logarithms = Vector3::new(
            reading.max(f64::MIN_POSITIVE).ln(),
            zero,
            2.0 * noise.run_slope_sd.ln(),
        );
        within_range(&logarithms, centre)
    }

    /// A first guess: scatter of differences between runs at the same step.
    fn rough_sd(&self) -> f64 {
        let whitening = self.whitening(&ReadingNoise {
            reading_sd_m: self.floor_m.max(1e-6),
            zero_sd_m: 1e-5,
            run_slope_sd: 5e-3,
        });
        let (squares, _, dof) = self.restricted_sum(&whitening);
        let scale = (squares / (dof as f64).max(1.0)).sqrt();
        (scale * self.floor_m.max(1e-6)).clamp(self.floor_m, 1.0)
    }

    fn whitening(&self, noise: &ReadingNoise) -> NoiseCovariance {
        NoiseCovariance::new(self.observations, noise, self.slope_m, self.compliance)
    }

    /// Weighted squares left after the fixed part, ln det of its normal matrix, and degrees of freedom.
    fn restricted_sum(&self, whitening: &NoiseCovariance) -> (f64, f64, usize) {
        let mut y = self.residual_m.to_vec();
        whitening.covariance.whiten(&mut y);
        let parts = self.fixed.par_iter().map_init(
            || vec![0.0; y.len()],
            |column, part| restricted_part(part, whitening, &y, column),
        );
        let parts: Vec<Option<RestrictedPart>> = parts.collect();
        // Summed in order, so that the number of threads does not show in the last digit.
        let (mut squares, mut log_determinant, mut dof) = (0.0, 0.0, 0);
        for part in parts.into_iter().flatten() {
            squares += part.squares;
            log_determinant += part.log_determinant;
            dof += part.dof;
        }
        (squares, log_determinant, dof)
    }

    /// Minus twice the logarithm of the restricted likelihood, with a wide prior about `centre` for what the data do not determine.
    fn objective(&self, log_variances: &Vector3<f64>, centre: &Vector3<f64>) -> f64 {
        let noise = self.noise(log_variances);
        let whitening = self.whitening(&noise);
        let (squares, log_determinant, _) = self.restricted_sum(&whitening);
        let prior: f64 = (log_variances - centre)
            .iter()
            .map(|d| (d / PRIOR_LOG_VARIANCE_SD).powi(2))
            .sum();
        let earlier = self.earlier.map_or(0.0, |earlier| earlier.misfit(&noise));
        whitening.covariance.log_determinant() + log_determinant + squares + earlier + prior
    }

    /// Newton steps with differences for derivatives: three parameters, a smooth function.
    fn maximise(&self, start: Vector3<f64>, centre: &Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let mut point = start;
        let mut value = self.objective(&point, centre);
        let mut hessian = Matrix3::identity();
        for _ in 0..25 {
            let (gradient, curvature) = self.derivatives(&point, value, centre);
            hessian = 0.5 * curvature;
            let step = damped(&curvature, &gradient);
            let mut moved = false;
            let mut length = 1.0;
            for _ in 0..6 {
                let trial = within_range(&(point + length * step), centre);
                let trial_value = self.objective(&trial, centre);
                if trial_value < value {
                    moved = value - trial_value > 1e-5;
                    point = trial;
                    value = trial_value;
                    break;
                }
                length *= 0.4;
            }
            if !moved {
                break;
            }
        }
        (point, hessian)
    }

    fn derivatives(
        &self,
        point: &Vector3<f64>,
        value: f64,
        centre: &Vector3<f64>,
    ) -> (Vector3<f64>, Matrix3<f64>) {
        const H: f64 = 0.02;
        // Up and down each axis, and up two of them, i and j, at once: these stand at i + j - 1.
        let moves: [&[(usize, f64)]; 9] = [
            &[(0, 1.0)],
            &[(1, 1.0)],
            &[(2, 1.0)],
            &[(0, -1.0)],
            &[(1, -1.0)],
            &[(2, -1.0)],
            &[(1, 1.0), (0, 1.0)],
            &[(2, 1.0), (0, 1.0)],
            &[(2, 1.0), (1, 1.0)],
        ];
        let at = |moves: &&[(usize, f64)]| {
            let mut moved = *point;
            for &(index, by) in *moves {
                moved[index] += by * H;
            }
            self.objective(&moved, centre)
        };
        let values: Vec<f64> = moves.par_iter().with_max_len(1).map(at).collect();
        let (up, down, both) = (&values[..3], &values[3..6], &values[6..]);
        let gradient = Vector3::from_fn(|i, _| (up[i] - down[i]) / (2.0 * H));
        let mut curvature = Matrix3::zeros();
        for i in 0..3 {
            curvature[(i, i)] = (up[i] - 2.0 * value + down[i]) / (H * H);
            for j in 0..i {
                let mixed = (both[i + j - 1] - up[i] - up[j] + value) / (H * H);
                curvature[(i, j)] = mixed;
                curvature[(j, i)] = mixed;
            }
        }
        (gradient, curvature)
    }
}

/// A cell's part of the restricted likelihood.
struct RestrictedPart {
    squares: f64,
    log_determinant: f64,
    dof: usize,
}

/// Weighted squares that the fixed part of a cell leaves, and what else it adds; `None` where the fixed part cannot be determined.
///
/// # Arguments
/// - `white`: the residuals of all readings, white.
/// - `column`: memory for one column.
fn restricted_part(
    part: &FixedPart,
    whitening: &NoiseCovariance,
    white: &[f64],
    column: &mut [f64],
) -> Option<RestrictedPart> {
    let (n, p) = (part.readings.len(), part.columns.len());
    let mut x = DMatrix::zeros(n, p);
    for (index, values) in part.columns.iter().enumerate() {
        column[part.readings.clone()].copy_from_slice(values);
        whitening.covariance.whiten_part(column, &part.readings);
        x.column_mut(index)
            .copy_from_slice(&column[part.readings.clone()]);
    }
    let target = DVector::from_column_slice(&white[part.readings.clone()]);
    let moment = x.tr_mul(&target);
    let factor = products(&x).cholesky()?;
    let solution = factor.solve(&moment);
    let diagonal = factor.l_dirty().diagonal();
    Some(RestrictedPart {
        // Below zero by rounding where the fixed part takes all there is.
        squares: (target.norm_squared() - moment.dot(&solution)).max(0.0),
        log_determinant: diagonal.iter().map(|d| 2.0 * d.ln()).sum(),
        dof: n - p.min(n),
    })
}

/// Products of the columns of a matrix with each other, those below the diagonal: a Cholesky factor needs no others.
fn products(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let count = matrix.ncols();
    let mut out = DMatrix::zeros(count, count);
    let columns: Vec<&[f64]> = matrix.as_slice().chunks_exact(matrix.nrows()).collect();
    widest(
        #[inline(always)]
        || {
            for (j, right) in columns.iter().enumerate() {
                for (i, left) in columns.iter().enumerate().skip(j) {
                    out[(i, j)] = sums_side_by_side(left, right);
                }
            }
        },
    );
    out
}

/// Log variances clamped to [`RANGE`] about a centre.
fn within_range(log_variances: &Vector3<f64>, centre: &Vector3<f64>) -> Vector3<f64> {
    let limit = 2.0 * RANGE.ln();
    log_variances.zip_map(centre, |value, centre| {
        value.clamp(centre - limit, centre + limit)
    })
}

/// Newton step of a curvature made positive.
fn damped(curvature: &Matrix3<f64>, gradient: &Vector3<f64>) -> Vector3<f64> {
    let eigen = curvature.symmetric_eigen();
    let mut step = Vector3::zeros();
    for i in 0..3 {
        let vector = eigen.eigenvectors.column(i).into_owned();
        let value = eigen.eigenvalues[i].abs().max(0.3);
        step -= vector * (vector.dot(gradient) / value);
    }
    let length = step.norm();
    if length > 2.0 {
        step *= 2.0 / length;
    }
    step
}

/// Indicator of each step (and hold) of a cell with several runs, and the force, which differs from its target from run to run; in a
/// cell with one run a smooth curve with a loop.
fn fixed_part(observations: &Observations, cell: usize) -> FixedPart {
    let cell = &observations.cells[cell];
    let readings = cell.readings.clone();
    let loads = &observations.loads[readings.clone()];
    let details = &observations.readings[readings.clone()];
    let force_scale = loads
        .iter()
        .map(|load| load.force_n.abs())
        .fold(0.0, f64::max)
        .max(1e-12);
    let force: Vec<f64> = loads
        .iter()
        .map(|load| load.force_n / force_scale)
        .collect();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut keys: Vec<(u32, u32)> = Vec::new();
    let key = |place: usize| (loads[place].step, details[place].hold_number);
    for place in 0..loads.len() {
        if !keys.contains(&key(place)) {
            keys.push(key(place));
        }
    }
    if cell.runs.len() > 1 && within_steps(&keys, &force, key) < SAME_STEP {
        for wanted in &keys {
            columns.push(
                (0..loads.len())
                    .map(|place| f64::from(u8::from(key(place) == *wanted)))
                    .collect(),
            );
        }
        // Where forces repeat exactly, the force is already in the span of the steps.
        let spread = within_steps(&keys, &force, key);
        if spread > 1e-6 {
            columns.push(force);
        }
    } else {
        let unloading: Vec<f64> = details
            .iter()
            .map(|reading| {
                f64::from(u8::from(
                    reading.branch == stiffbench_units_and_text::test_point::Branch::Unloading,
                ))
            })
            .collect();
        let product =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<f64>>();
        let square = product(&force, &force);
        let all = [
            vec![1.0; force.len()],
            force.clone(),
            square,
            unloading.clone(),
            product(&unloading, &force),
        ];
        for column in all {
            if independent(&columns, &column) {
                columns.push(column);
            }
        }
    }
    FixedPart { columns, readings }
}

/// Root mean square of the force about its mean in each step.
fn within_steps(keys: &[(u32, u32)], force: &[f64], key: impl Fn(usize) -> (u32, u32)) -> f64 {
    let mut squares = 0.0;
    for wanted in keys {
        let members: Vec<f64> = (0..force.len())
            .filter(|&place| key(place) == *wanted)
            .map(|place| force[place])
            .collect();
        let mean = members.iter().sum::<f64>() / members.len().max(1) as f64;
        squares += members.iter().map(|f| (f - mean).powi(2)).sum::<f64>();
    }
    (squares / force.len().max(1) as f64).sqrt()
}

/// Whether a column adds something to those already there.
fn independent(columns: &[Vec<f64>], column: &[f64]) -> bool {
    let mut rest = column.to_vec();
    let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    let whole = length(&rest);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for other in columns {
        let mut vector = other.clone();
        for b in &basis {
            remove(&mut vector, b);
        }
        let norm = length(&vector).sqrt();
        if norm > 0.0 {
            for x in &mut vector {
                *x /= norm;
            }
            remove(&mut rest, &vector);
            basis.push(vector);
        }
    }
    length(&rest) > 1e-8 * whole && whole > 0.0
}

fn remove(vector: &mut [f64], unit: &[f64]) {
    let product: f64 = vector.iter().zip(unit).map(|(a, b)| a * b).sum();
    for (value, u) in vector.iter_mut().zip(unit) {
        *value -= product * u;
    }
}
