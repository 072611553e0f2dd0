//! Which poses of the workspace determine a list of parameters best, before anything is measured.

use nalgebra::DMatrix;

use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, NamedPose, Robot};
use stiffbench_numeric::vector::along6;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::Direction;

use super::load_cases::problem::unloaded_springs;
use super::plan::{EndCompliance, TriedPose, add_outer, further_poses, motion_along};
use crate::fit::FitError;

/// Poses that are tried beside the named ones, spread evenly over the limits.
const TRIED_POSES: usize = 600;

/// Passes of exchanges after the first choice; each ends where no exchange gains.
const MOST_PASSES: usize = 20;

/// A gain in the logarithm of the determinant below this is none.
const LEAST_GAIN: f64 = 1e-9;

/// Information of which the parameters have some before any reading, so that the first poses can be compared: below any measurement.
const RIDGE: f64 = 1e-9;

/// What is read in every pose.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseReadings {
    /// Directions of the loads.
    pub directions: Vec<LoadDirection>,
    /// Base axes along which displacements are read; empty: along the load.
    pub displacement_axes: Vec<Direction>,
    /// The load steps along each direction, N.
    pub loads_n: Vec<f64>,
    /// Applications of the load steps.
    pub repeats: u32,
    /// Standard deviation of a displacement, m.
    pub reading_sd_m: f64,
    /// Standard deviation of the slope of a run, as a share of it.
    pub run_slope_sd: f64,
}

/// Poses with what they determine.
#[derive(Debug, Clone, PartialEq)]
pub struct BestPoses {
    /// The poses, in the order in which they were chosen.
    pub poses: Vec<NamedPose>,
    /// Poses within the limits among which they were chosen.
    pub tried: usize,
    /// For each parameter the standard error to be expected, in its unit (of a factor that of its logarithm): the Cramér-Rao limit; `None` of
    /// a spring that no load acts on in any pose.
    pub errors: Vec<(ModelParameter, Option<f64>)>,
}

/// The poses, among the named ones and poses spread over the limits, whose readings have the largest determinant of the information on the
/// parameters (D-optimality: Pukelsheim, Optimal Design of Experiments, 2006, section 6.2), by one choice after the other and then exchanges
/// (Fedorov, Theory of Optimal Experiments, 1972, section 3.3).
///
/// # Arguments
/// - `start`: values of the parameters; errors that grow with the displacement follow from them.
/// - `parameters`: those to be determined, at least one; springs that no load acts on have no part in the choice.
/// - `count`: number of poses, at least one.
///
/// # Errors
/// [`FitError::Dependent`] if no choice of poses determines all parameters; for a structure that carries nothing. Poses that cannot be
/// reached are passed over.
pub fn best_poses(
    robot: &Robot,
    mechanism: &Mechanism,
    start: &FittingFactors,
    parameters: &[ModelParameter],
    readings: &PoseReadings,
    count: usize,
) -> Result<BestPoses, FitError> {
    let poses = further_poses(robot, mechanism, TRIED_POSES);
    let tried = TriedPose::all((robot, mechanism), parameters, start, poses.collect())?;
    // Beside the parameters a spring that every load moves along itself.
    let along = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let slopes = tried.iter().map(|TriedPose { mechanics, .. }| {
        let derivatives = [&mechanics.gradient[..], &[along]].concat();
        readings.rows(&mechanics.influence.compliance, &derivatives)
    });
    let mut slopes: Vec<Vec<Vec<f64>>> = slopes.collect();
    let lengths: Vec<f64> = (0..=parameters.len())
        .map(|place| {
            let rows = slopes.iter().flatten().map(|row| row[place] * row[place]);
            rows.sum::<f64>().sqrt()
        })
        .collect();
    let unloaded = unloaded_springs(parameters, &lengths, lengths[parameters.len()]);
    let loaded: Vec<usize> = (0..parameters.len()).filter(|i| !unloaded[*i]).collect();
    for row in slopes.iter_mut().flatten() {
        *row = loaded.iter().map(|place| row[*place]).collect();
    }
    // Each parameter in units of what one pose says of it on average: the determinant is then a fair number.
    let unit = (slopes.len().max(1) as f64).sqrt();
    let scales: Vec<f64> = loaded.iter().map(|place| unit / lengths[*place]).collect();
    let rows = slopes.iter();
    let informations: Vec<DMatrix<f64>> = rows.map(|rows| information(rows, &scales)).collect();
    let chosen = chosen(&informations, count.min(tried.len()));
    let mut sum = DMatrix::zeros(loaded.len(), loaded.len());
    for &place in &chosen {
        sum += &informations[place];
    }
    let inverse = sum.cholesky().map(|factor| factor.inverse());
    let inverse = inverse
        .filter(|inverse| !loaded.is_empty() && inverse.diagonal().max() < 1.0 / RIDGE)
        .ok_or(FitError::Dependent)?;
    let error = |place: usize| {
        let i = loaded.iter().position(|known| *known == place)?;
        Some(scales[i] * inverse[(i, i)].sqrt())
    };
    let errors = parameters.iter().cloned().enumerate();
    Ok(BestPoses {
        errors: errors
            .map(|(place, parameter)| (parameter, error(place)))
            .collect(),
        tried: tried.len(),
        poses: chosen
            .into_iter()
            .map(|place| NamedPose {
                id: tried[place].name.clone(),
                pose: tried[place].pose.clone(),
                stated_zy_m: None,
            })
            .collect(),
    })
}

impl PoseReadings {
    /// Derivatives of every displacement per load to the parameters, each over its standard deviation.
    fn rows(&self, compliance: &EndCompliance, derivatives: &[EndCompliance]) -> Vec<Vec<f64>> {
        let n = self.loads_n.len().max(1) as f64;
        let mean_n = self.loads_n.iter().sum::<f64>() / n;
        // The squared length of the loads about their mean: the variance of a slope is that of a reading over it.
        let length: f64 = self
            .loads_n
            .iter()
            .map(|load| (load - mean_n).powi(2))
            .sum();
        let mut rows = Vec::new();
        for direction in &self.directions {
            let load = along6(direction.unit_vector());
            let units: Vec<[f64; 6]> = if self.displacement_axes.is_empty() {
                vec![load]
            } else {
                let axes = self.displacement_axes.iter();
                axes.map(|axis| along6(axis.unit_vector())).collect()
            };
            for unit in &units {
                let slope = motion_along(compliance, unit, &load);
                let variance =
                    self.reading_sd_m.powi(2) / length + (self.run_slope_sd * slope).powi(2);
                let sd = (variance / f64::from(self.repeats.max(1))).sqrt();
                let row = derivatives
                    .iter()
                    .map(|matrix| motion_along(matrix, unit, &load) / sd);
                rows.push(row.collect());
            }
        }
        rows
    }
}

/// What the readings of a pose say of the parameters, in units of their scales.
fn information(rows: &[Vec<f64>], scales: &[f64]) -> DMatrix<f64> {
    let size = scales.len();
    let mut matrix = DMatrix::zeros(size, size);
    for row in rows {
        let scaled: Vec<f64> = row.iter().zip(scales).map(|(a, scale)| a * scale).collect();
        add_outer(&mut matrix, &scaled);
    }
    matrix
}

/// Places of the chosen poses.
fn chosen(tried: &[DMatrix<f64>], count: usize) -> Vec<usize> {
    let Some(first) = tried.first() else {
        return Vec::new();
    };
    let size = first.nrows();
    let mut sum = DMatrix::identity(size, size) * RIDGE;
    let mut chosen: Vec<usize> = Vec::new();
    let best = |sum: &DMatrix<f64>, chosen: &[usize]| {
        let free = (0..tried.len()).filter(|place| !chosen.contains(place));
        free.map(|place| (log_determinant(&(sum + &tried[place])), place))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    };
    while chosen.len() < count {
        let Some((_, place)) = best(&sum, &chosen) else {
            break;
        };
        sum += &tried[place];
        chosen.push(place);
    }
    for _ in 0..MOST_PASSES {
        let mut gained = false;
        for slot in 0..chosen.len() {
            let now = log_determinant(&sum);
            let without = &sum - &tried[chosen[slot]];
            if let Some((then, place)) = best(&without, &chosen)
                && then > now + LEAST_GAIN
            {
                sum = without + &tried[place];
                chosen[slot] = place;
                gained = true;
            }
        }
        if !gained {
            break;
        }
    }
    chosen
}

fn log_determinant(matrix: &DMatrix<f64>) -> f64 {
    matrix.clone().cholesky().map_or(f64::NEG_INFINITY, |of| {
        of.l_dirty()
            .diagonal()
            .iter()
            .map(|x| 2.0 * x.ln())
            .sum::<f64>()
    })
}
