//! Variances of the noise from the readings, alone or together with what earlier sessions tell.
//!
//! Restricted likelihood of Patterson and Thompson, Biometrika 58 (1971): the mean of every load step of every cell is left free, so
//! that no physics that repeats itself can pass for noise. What is left is the scatter between runs.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::covariance::{ForceReading, NoiseCovariance};
use super::earlier_noise::EarlierNoise;
use super::estimated_noise::{EstimatedNoise, NoiseBasis};
use super::force_scatter::force_scatter;
use super::free_means::FixedPart;
use crate::mismatch::observed::{GaugeNoise, Observations, ReadingNoise};
use crate::search::constants::{ASKED_FOR, COARSE};
use crate::search::{Precision, SparseRows, largest};
use stiffbench_numeric::statistics::root_mean_square;

/// Standard deviation of the prior of the logarithm of each variance of the noise (1): a factor of seven either way of a standard deviation. By
/// hand (750d6b5).
const PRIOR_LOG_VARIANCE_SD: f64 = 4.0;

/// Relative error of the slope of a run about which that prior lies (1), and of a reading that grows with its displacement. By hand (750d6b5).
const PRIOR_RUN_SLOPE_SD: f64 = 3e-3;

/// Standard deviations are found between these multiples of the start.
const RANGE: f64 = 1e4;

/// Least standard deviation of a reading, where it starts, and where that of a zero does, as shares of the usual displacement.
const LEAST_SD: f64 = 1e-6;
/// See [`LEAST_SD`].
const START_SD: f64 = 1e-3;
/// See [`LEAST_SD`].
const START_ZERO_SD: f64 = 1e-2;

/// What a zero that may be anything scatters by, in largest displacements.
const FREE_ZERO_SD: f64 = 10.0;

/// Largest correlation of neighbouring errors: nearer to one they are a drift.
const MOST_CORRELATED: f64 = 0.98;

/// Finds the variances.
///
/// # Arguments
/// - `residual_m`: readings minus the baseline (and minus effects already found), m.
/// - `slope_m`, `force`: the baseline's prediction at each reading, and what an error of the force moves.
/// - `warm_start`: the noise of a similar baseline, to start from.
/// - `earlier`: how earlier sessions scattered; the noise is the likeliest for these readings and those.
/// - `model`: derivatives of the readings to the parameters, where nothing was repeated: what else is left is the noise.
#[must_use]
pub(crate) fn estimate_noise(
    observations: &Observations,
    residual_m: &[f64],
    (slope_m, force): (&[f64], ForceReading<'_>),
    warm_start: Option<&ReadingNoise>,
    earlier: Option<&EarlierNoise>,
    model: Option<Vec<Vec<f64>>>,
) -> EstimatedNoise {
    let basis = match model {
        Some(_) => NoiseBasis::Fit,
        None if observations.cells.iter().any(|cell| cell.runs.len() > 1) => NoiseBasis::Repeats,
        None => NoiseBasis::Neighbours,
    };
    let is_repeated = basis == NoiseBasis::Repeats && observations.gauges.is_empty();
    let force_sd_n = is_repeated.then(|| force_scatter(observations)).flatten();
    let fixed: Vec<FixedPart> = if let Some(columns) = model {
        vec![FixedPart::of_model(observations, columns)]
    } else {
        let follows_force = force_sd_n.is_none();
        let of_series = |cells| FixedPart::of_series(observations, cells, follows_force);
        observations.series().map(of_series).collect()
    };
    let of_cell = |part: &FixedPart| part.centred(residual_m[part.readings.clone()].to_vec());
    let residual_m: Vec<f64> = fixed.iter().flat_map(of_cell).collect();
    let usual_m = observations.usual_displacement_m();
    let least_m = LEAST_SD * usual_m;
    let floor_m = observations
        .steps
        .displacement_m
        .map_or(0.0, |step| step / 12.0_f64.sqrt())
        .max(least_m);
    let problem = VarianceProblem {
        observations,
        fixed,
        residual_m,
        slope_m,
        force,
        earlier,
        force_sd_n: force_sd_n.unwrap_or(0.0),
        floor_m,
        usual_m,
        free_zero_sd_m: FREE_ZERO_SD * largest(&observations.displacement_m),
    };
    let rough = problem.rough_sd();
    let mut centre = [0.0; VALUES];
    centre[..2].fill((rough * rough).ln());
    centre[2..4].fill(PRIOR_RUN_SLOPE_SD.powi(2).ln());
    centre[OWN_SLOPE] = PRIOR_RUN_SLOPE_SD.powi(2).ln();
    centre[FORCE] = 2.0 * (rough / force.largest().max(f64::MIN_POSITIVE)).ln();
    centre[ROTATION] = 2.0 * problem.rotation_ratio().ln();
    let found = match warm_start {
        Some(noise) => {
            let further = NoiseValues::of(noise, observations, problem.force_sd_n > 0.0);
            let start = problem.values(noise, &centre, further);
            problem.maximise(start, &centre, further)
        }
        None => problem.with_further_parts(&centre, basis),
    };
    let size = found.values.len();
    let covariance = found
        .hessian
        .try_inverse()
        .unwrap_or_else(|| DMatrix::identity(size, size) * 2.0);
    let places = found.further.places();
    let entry = |i: usize, j: usize| {
        let at = |wanted: usize| places.iter().position(|place| *place == wanted);
        let both = at(i).zip(at(j));
        both.map_or(0.0, |(i, j)| covariance[(i, j)])
    };
    let standard_error = |place: usize| entry(place, place).max(0.0).sqrt();
    EstimatedNoise {
        further_se: [0.5 * standard_error(GROWTH), standard_error(CORRELATION)],
        noise: problem.noise(&found.values, found.further),
        covariance: std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))),
        basis,
    }
}

/// Which of its values a noise has: the logarithms of the variances of readings and of the slope of a run, that of the zeros of runs with
/// several readings, those that the readings ask for, and of several gauges the logarithms of their variances over the common one but the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct NoiseValues([bool; VALUES]);

impl NoiseValues {
    /// Without those that readings must ask for.
    fn least(observations: &Observations) -> Self {
        let mut parts = Self([false; VALUES]);
        parts.0[READING] = true;
        parts.0[ZERO] = observations.has_series();
        // Of one load in a run it is common to all gauges, and grows with the displacement.
        parts.0[SLOPE] = observations.loads.iter().any(|load| load.force_n != 0.0);
        // Several sessions keep the proportions that each has alone. Of loads one by one the components are those of one vector, whichever axes they
        // are stated along; and some dozens of each show no scatter of its own well enough to be weighed by.
        if observations.sessions.is_empty() {
            if observations.has_series() {
                let ratios = observations.gauges.len().saturating_sub(1);
                parts.0[FIRST_RATIO..FIRST_RATIO + ratios].fill(true);
            }
            parts.0[ROTATION] = observations
                .cells
                .iter()
                .any(|cell| cell.read.is_rotation());
        }
        parts
    }

    /// Those of a noise.
    ///
    /// # Arguments
    /// - `is_force_known`: whether the scatter of the force was found before.
    fn of(noise: &ReadingNoise, observations: &Observations, is_force_known: bool) -> Self {
        let mut parts = Self::least(observations);
        parts.0[GROWTH] = noise.growth_sd > 0.0;
        parts.0[CORRELATION] = noise.correlation != 0.0;
        parts.0[OWN_SLOPE] = noise.gauges.own_slope_sd > 0.0;
        parts.0[FORCE] = noise.gauges.force_sd_n > 0.0 && !is_force_known;
        parts
    }

    fn has(self, place: usize) -> bool {
        self.0[place]
    }

    /// Each part that readings may ask for beside these. Without repeats what a model leaves cannot be distinguished from correlated noise, nor
    /// from slopes of a gauge alone.
    fn more(
        self,
        observations: &Observations,
        basis: NoiseBasis,
        is_force_known: bool,
    ) -> impl Iterator<Item = Self> {
        let several = !observations.gauges.is_empty();
        let own_slope = (several || basis == NoiseBasis::Fit).then_some(OWN_SLOPE);
        let force = (!is_force_known).then_some(FORCE);
        let of_gauges = own_slope.into_iter().chain(force);
        let asked = [GROWTH, CORRELATION].into_iter().chain(of_gauges);
        let is_seen =
            |place: &usize| basis == NoiseBasis::Repeats || [GROWTH, FORCE].contains(place);
        let new = asked.filter(|place| !self.has(*place)).filter(is_seen);
        let new: Vec<usize> = new.collect();
        new.into_iter().map(move |place| {
            let mut more = self;
            more.0[place] = true;
            more
        })
    }

    /// For each value that is searched its place among all.
    fn places(self) -> Vec<usize> {
        (0..VALUES).filter(|place| self.has(*place)).collect()
    }
}

/// Number of values of a noise. Behind the logarithms of the variances of reading, zero and slope stand that of the growth, the inverse
/// hyperbolic tangent of the correlation, the ratios of two gauges to the first, and the logarithms of the variances of the slope that a
/// run has in one gauge alone and of the force.
const VALUES: usize = 10;
const READING: usize = 0;
const ZERO: usize = 1;
const SLOPE: usize = 2;
const GROWTH: usize = 3;
const CORRELATION: usize = 4;
const FIRST_RATIO: usize = 5;
const OWN_SLOPE: usize = 7;
const FORCE: usize = 8;
const ROTATION: usize = 9;

/// The likeliest noise with some parts.
struct LikeliestNoise {
    values: DVector<f64>,
    /// Minus twice the logarithm of the likelihood, and half of its second derivatives.
    misfit: f64,
    hessian: DMatrix<f64>,
    further: NoiseValues,
}

/// Centres of the priors of all values.
type Centre = [f64; VALUES];

struct VarianceProblem<'a> {
    observations: &'a Observations,
    fixed: Vec<FixedPart>,
    /// Without the mean of each step.
    residual_m: Vec<f64>,
    slope_m: &'a [f64],
    force: ForceReading<'a>,
    earlier: Option<&'a EarlierNoise>,
    /// Scatter of the force of one gauge that its readings do not follow, N.
    force_sd_n: f64,
    floor_m: f64,
    /// What displacements are of the order of, m.
    usual_m: f64,
    /// What a zero that may be anything scatters by, m.
    free_zero_sd_m: f64,
}

impl VarianceProblem<'_> {
    fn noise(&self, values: &DVector<f64>, further: NoiseValues) -> ReadingNoise {
        let mut all = [0.0; VALUES];
        for (value, place) in values.iter().zip(further.places()) {
            all[place] = *value;
        }
        let sd = |place: usize| {
            if further.has(place) {
                f64::exp(0.5 * all[place])
            } else {
                0.0
            }
        };
        ReadingNoise {
            reading_sd_m: sd(READING).hypot(self.floor_m),
            zero_sd_m: if self.observations.free_zeros {
                self.free_zero_sd_m
            } else {
                sd(ZERO)
            },
            run_slope_sd: sd(SLOPE),
            growth_sd: sd(GROWTH),
            correlation: all[CORRELATION].tanh(),
            gauges: self.gauge_noise(&all, further),
        }
    }

    fn gauge_noise(&self, all: &Centre, further: NoiseValues) -> GaugeNoise {
        let mut gauges = match self.observations.sessions.first() {
            Some(first) => first.noise.gauges,
            None => GaugeNoise {
                force_sd_n: self.force_sd_n,
                ..GaugeNoise::ALIKE
            },
        };
        if further.has(FIRST_RATIO) {
            let count = self.observations.gauges.len() - 1;
            let others = &all[FIRST_RATIO..FIRST_RATIO + count];
            let logs = std::iter::once(-others.iter().sum::<f64>()).chain(others.iter().copied());
            for (axis, log) in self.observations.gauges.iter().zip(logs) {
                gauges.reading_ratios[axis.index()] = (0.5 * log).exp();
            }
        }
        if further.has(ROTATION) {
            gauges.rotation_ratio = (0.5 * all[ROTATION]).exp();
        }
        if further.has(OWN_SLOPE) {
            gauges.own_slope_sd = (0.5 * all[OWN_SLOPE]).exp();
        }
        if further.has(FORCE) {
            gauges.force_sd_n = (0.5 * all[FORCE]).exp();
        }
        gauges
    }

    /// What rotations scatter by over what displacements do, about what is fixed, rad/m; 1 if either was not read.
    fn rotation_ratio(&self) -> f64 {
        let of_kind = |rotates: bool| {
            let cells = self.observations.cells.iter();
            let own = cells.filter(|cell| cell.read.is_rotation() == rotates);
            let rows = own.flat_map(|cell| cell.readings.clone());
            root_mean_square(rows.map(|row| self.residual_m[row]))
        };
        let both = of_kind(true).zip(of_kind(false));
        let ratio = both.map_or(1.0, |(rotation, displacement)| rotation / displacement);
        if ratio.is_normal() { ratio } else { 1.0 }
    }

    /// The values that give a noise, within range of `centre`; a zero that may be anything has none.
    fn values(&self, noise: &ReadingNoise, centre: &Centre, further: NoiseValues) -> DVector<f64> {
        let reading = noise.reading_sd_m.powi(2) - self.floor_m.powi(2);
        let zero = if self.observations.free_zeros {
            centre[1]
        } else {
            2.0 * noise.zero_sd_m.ln()
        };
        let mut all = [0.0; VALUES];
        all[READING] = reading.max(f64::MIN_POSITIVE).ln();
        all[ZERO] = zero;
        all[SLOPE] = 2.0 * noise.run_slope_sd.ln();
        all[GROWTH] = 2.0 * noise.growth_sd.max(f64::MIN_POSITIVE).ln();
        all[CORRELATION] = noise.correlation.atanh();
        let gauges = &self.observations.gauges;
        for (place, axis) in gauges
            .iter()
            .skip(1)
            .take(OWN_SLOPE - FIRST_RATIO)
            .enumerate()
        {
            all[FIRST_RATIO + place] = 2.0 * noise.gauges.reading_ratios[axis.index()].ln();
        }
        all[ROTATION] = 2.0 * noise.gauges.rotation_ratio.ln();
        all[OWN_SLOPE] = 2.0 * noise.gauges.own_slope_sd.max(f64::MIN_POSITIVE).ln();
        all[FORCE] = 2.0 * noise.gauges.force_sd_n.max(f64::MIN_POSITIVE).ln();
        let places = further.places();
        let values = DVector::from_iterator(places.len(), places.iter().map(|&i| all[i]));
        within_range(&values, centre, further)
    }

    /// The likeliest noise of the first model: the parts that the readings ask for, the one they ask for most first.
    fn with_further_parts(&self, centre: &Centre, basis: NoiseBasis) -> LikeliestNoise {
        let start = |further: NoiseValues| {
            let places = further.places();
            DVector::from_iterator(places.len(), places.iter().map(|&i| centre[i]))
        };
        let least = NoiseValues::least(self.observations);
        let mut best = self.maximise(start(least), centre, least);
        // Each of several sessions has its own; of one load in each run the slope is all that grows; a smooth curve along a run takes whatever
        // grows or is correlated.
        let is_of_series = self.observations.has_series() && self.observations.sessions.is_empty();
        if !is_of_series || basis == NoiseBasis::Neighbours {
            return best;
        }
        loop {
            let more = best
                .further
                .more(self.observations, basis, self.force_sd_n > 0.0);
            let tried = more.map(|more| {
                let noise = self.noise(&best.values, best.further);
                let mut from = self.values(&noise, centre, more);
                for (value, place) in from.iter_mut().zip(more.places()) {
                    let is_new = !best.further.places().contains(&place);
                    if is_new {
                        *value = centre[place];
                    }
                }
                self.maximise(from, centre, more)
            });
            match tried.min_by(|a, b| a.misfit.total_cmp(&b.misfit)) {
                // A coarse gauge has errors of another kind.
                Some(next) if next.misfit < best.misfit - ASKED_FOR && !self.is_coarse(&next) => {
                    best = next;
                }
                _ => return best,
            }
        }
    }

    /// Whether the step of the gauge is what makes readings scatter.
    fn is_coarse(&self, noise: &LikeliestNoise) -> bool {
        let variance = self
            .noise(&noise.values, noise.further)
            .reading_sd_m
            .powi(2);
        let step_m = self.observations.steps.displacement_m.unwrap_or(0.0);
        step_m * step_m / 12.0 > COARSE * variance
    }

    /// A first guess: scatter of differences between runs at the same step.
    fn rough_sd(&self) -> f64 {
        let start_m = self.floor_m.max(START_SD * self.usual_m);
        let precision = self.precision(&ReadingNoise {
            reading_sd_m: start_m,
            zero_sd_m: if self.observations.has_series() {
                START_ZERO_SD * self.usual_m
            } else {
                0.0
            },
            run_slope_sd: 5e-3,
            gauges: GaugeNoise {
                rotation_ratio: self.rotation_ratio(),
                ..GaugeNoise::ALIKE
            },
            ..ReadingNoise::default()
        });
        let (squares, _, dof) = self.restricted_sum(&precision);
        let scale = (squares / (dof as f64).max(1.0)).sqrt();
        (scale * start_m).max(self.floor_m)
    }

    fn precision(&self, noise: &ReadingNoise) -> Precision {
        NoiseCovariance::precision(self.observations, noise, self.slope_m, self.force)
    }

    /// Weighted squares left after the fixed part, ln det of its normal matrix, and degrees of freedom.
    fn restricted_sum(&self, precision: &Precision) -> (f64, f64, usize) {
        let part = |part| restricted_part(part, precision, &self.residual_m);
        let parts: Vec<Option<RestrictedPart>> = self.fixed.par_iter().map(part).collect();
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
    fn objective(&self, values: &DVector<f64>, centre: &Centre, further: NoiseValues) -> f64 {
        let noise = self.noise(values, further);
        let precision = self.precision(&noise);
        let (squares, log_determinant, _) = self.restricted_sum(&precision);
        let places = further.places().into_iter();
        let prior: f64 = values
            .iter()
            .zip(places)
            .map(|(value, place)| ((value - centre[place]) / PRIOR_LOG_VARIANCE_SD).powi(2))
            .sum();
        let earlier = self.earlier.map_or(0.0, |earlier| earlier.misfit(&noise));
        precision.log_determinant() + log_determinant + squares + earlier + prior
    }

    /// Newton steps with differences for derivatives: few parameters, a smooth function.
    fn maximise(
        &self,
        start: DVector<f64>,
        centre: &Centre,
        further: NoiseValues,
    ) -> LikeliestNoise {
        let size = start.len();
        let mut point = start;
        let mut value = self.objective(&point, centre, further);
        let mut hessian = DMatrix::identity(size, size);
        for _ in 0..25 {
            let (gradient, curvature) = self.derivatives(&point, value, centre, further);
            hessian = 0.5 * &curvature;
            let step = damped(&curvature, &gradient);
            let mut moved = false;
            let mut length = 1.0;
            for _ in 0..6 {
                let trial = within_range(&(&point + length * &step), centre, further);
                let trial_value = self.objective(&trial, centre, further);
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
        LikeliestNoise {
            values: point,
            misfit: value,
            hessian,
            further,
        }
    }

    fn derivatives(
        &self,
        point: &DVector<f64>,
        value: f64,
        centre: &Centre,
        further: NoiseValues,
    ) -> (DVector<f64>, DMatrix<f64>) {
        const H: f64 = 0.02;
        let size = point.len();
        // Up each axis, down each axis, and up two of them at once.
        let up = (0..size).map(|i| vec![(i, H)]);
        let down = (0..size).map(|i| vec![(i, -H)]);
        let pairs = (0..size).flat_map(|i| (0..i).map(move |j| (i, j)));
        let both = pairs.clone().map(|(i, j)| vec![(i, H), (j, H)]);
        let moves: Vec<Vec<(usize, f64)>> = up.chain(down).chain(both).collect();
        let at = |moves: &Vec<(usize, f64)>| {
            let mut moved = point.clone();
            for &(index, by) in moves {
                moved[index] += by;
            }
            self.objective(&moved, centre, further)
        };
        let values: Vec<f64> = moves.par_iter().with_max_len(1).map(at).collect();
        let (up, rest) = values.split_at(size);
        let (down, both) = rest.split_at(size);
        let gradient = DVector::from_fn(size, |i, _| (up[i] - down[i]) / (2.0 * H));
        let mut curvature = DMatrix::zeros(size, size);
        for i in 0..size {
            curvature[(i, i)] = (up[i] - 2.0 * value + down[i]) / (H * H);
        }
        for ((i, j), both) in pairs.zip(both) {
            let mixed = (both - up[i] - up[j] + value) / (H * H);
            curvature[(i, j)] = mixed;
            curvature[(j, i)] = mixed;
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
/// ```text
///   Xᵀ V⁻¹ X and Xᵀ V⁻¹ y from the steps of each reading: X has few entries that are not zero
/// ```
///
/// # Arguments
/// - `residual_m`: the residuals of all readings, m.
fn restricted_part(
    part: &FixedPart,
    precision: &Precision,
    residual_m: &[f64],
) -> Option<RestrictedPart> {
    let mut further: Vec<&[f64]> = part.further.iter().map(Vec::as_slice).collect();
    let p = part.steps + further.len();
    further.push(&residual_m[part.readings.clone()]);
    let rows = SparseRows {
        ones: &part.step_of,
        one_columns: part.steps,
        further: &further,
    };
    let mut sums = vec![0.0; (p + 1) * (p + 1)];
    precision.add_products(&part.readings, &rows, &mut sums);
    // The last row: the residuals with the fixed part, and with themselves.
    let moment = DVector::from_column_slice(&sums[p * (p + 1)..p * (p + 1) + p]);
    let squares = sums[p * (p + 1) + p];
    let normal = DMatrix::from_fn(p, p, |i, j| sums[i * (p + 1) + j]);
    let factor = normal.cholesky()?;
    let solution = factor.solve(&moment);
    let diagonal = factor.l_dirty().diagonal();
    let n = part.readings.len();
    Some(RestrictedPart {
        // Below zero by rounding where the fixed part takes all there is.
        squares: (squares - moment.dot(&solution)).max(0.0),
        log_determinant: diagonal.iter().map(|d| 2.0 * d.ln()).sum(),
        dof: n - p.min(n),
    })
}

/// Values clamped to [`RANGE`] about a centre, and the correlation to [`MOST_CORRELATED`].
fn within_range(values: &DVector<f64>, centre: &Centre, further: NoiseValues) -> DVector<f64> {
    let mut values = values.clone();
    for (value, place) in values.iter_mut().zip(further.places()) {
        let limit = if place == CORRELATION {
            MOST_CORRELATED.atanh()
        } else {
            2.0 * RANGE.ln()
        };
        *value = value.clamp(centre[place] - limit, centre[place] + limit);
    }
    values
}

/// Newton step of a curvature made positive.
fn damped(curvature: &DMatrix<f64>, gradient: &DVector<f64>) -> DVector<f64> {
    let eigen = curvature.clone().symmetric_eigen();
    let mut step = DVector::zeros(gradient.len());
    for i in 0..gradient.len() {
        let vector = eigen.eigenvectors.column(i);
        let value = eigen.eigenvalues[i].abs().max(0.3);
        step -= vector * (vector.dot(gradient) / value);
    }
    let length = step.norm();
    if length > 2.0 {
        step *= 2.0 / length;
    }
    step
}
