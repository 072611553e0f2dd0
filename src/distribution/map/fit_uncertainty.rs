//! What the uncertainty of the fitted factors does to a map.
//!
//! To first order: the derivatives of a stiffness to the logarithms of the factors, exact, times their covariance. A minimum over the poses
//! has the derivatives of its pose (the pose itself stands still to first order), a mean the mean of those of all poses.

use rayon::prelude::*;

use crate::robot::{BatchPredictor, RobotError, Theory};
use crate::statistics::Estimate;

use super::StiffnessMap;
use super::model::MapModel;
use super::statistics::ColumnStatistics;
use crate::distribution::pose_set::PoseSet;

/// Fitting factors: four of beams, four of links.
const FACTORS: usize = 8;

/// Poses placed at once: few enough to stay in the second-level cache.
const POSES: usize = 64;

/// Rows that a thread takes at a time.
const CHUNK: usize = 2048;

/// How well the factors of a model are known.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FactorCovariance {
    /// Covariance of ln A, ln Iy, ln Iz, ln J of beams, then of links; zero where a factor was not fitted.
    pub matrix: [[f64; FACTORS]; FACTORS],
    /// Its degrees of freedom; `None` where they are without limit.
    pub dof: Option<f64>,
}

/// Characteristic values of a column with the uncertainty that the fit gives them, N/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitUncertainty {
    /// Of the smallest stiffness.
    pub smallest: Estimate,
    /// Of the largest.
    pub largest: Estimate,
    /// Of the mean.
    pub mean: Estimate,
}

/// Derivatives of a stiffness to the logarithms of the factors, N/m.
type Gradient = [f64; FACTORS];

/// Carries the covariance to smallest, largest and mean of every column; `None` for columns that are no global axis, and where laws are not
/// linear.
///
/// # Errors
/// [`RobotError`] if the model cannot be built; its poses were solved before.
pub fn fit_uncertainty(
    model: &MapModel<'_>,
    map: &StiffnessMap,
    poses: &PoseSet,
    covariance: &FactorCovariance,
    statistics: &[ColumnStatistics],
) -> Result<Vec<Option<FitUncertainty>>, RobotError> {
    if !model.is_linear() || map.is_empty() {
        return Ok(vec![None; statistics.len()]);
    }
    let rows: Vec<usize> = (0..map.len()).collect();
    // One sum a chunk, added up in order afterwards: the same bytes for any number of threads.
    let chunks: Vec<[Gradient; 3]> = rows
        .par_chunks(CHUNK)
        .map(|rows| {
            let gradients = gradients(model, map, poses, rows)?;
            Ok(gradients.into_iter().fold([[0.0; FACTORS]; 3], add))
        })
        .collect::<Result<_, RobotError>>()?;
    let count = map.len() as f64;
    let sums = chunks.into_iter().fold([[0.0; FACTORS]; 3], add);
    let mut found = Vec::with_capacity(statistics.len());
    for (column, statistics) in map.columns.iter().zip(statistics) {
        let Some(axis) = column.axis() else {
            found.push(None);
            continue;
        };
        let extremes = [&statistics.smallest, &statistics.largest];
        let of_extremes = gradients(model, map, poses, &extremes.map(|extreme| extreme.row))?;
        let estimate = |value: f64, gradient: Gradient| Estimate {
            value,
            standard_uncertainty: covariance.carried(gradient),
            dof: covariance.dof.unwrap_or(f64::INFINITY),
        };
        found.push(Some(FitUncertainty {
            smallest: estimate(statistics.smallest.stiffness_n_per_m, of_extremes[0][axis]),
            largest: estimate(statistics.largest.stiffness_n_per_m, of_extremes[1][axis]),
            mean: estimate(statistics.mean.value, sums[axis].map(|sum| sum / count)),
        }));
    }
    Ok(found)
}

impl FactorCovariance {
    /// The standard uncertainty of what has this gradient.
    fn carried(&self, gradient: Gradient) -> f64 {
        let rows = self.matrix.iter().zip(gradient);
        let variance: f64 = rows
            .map(|(row, slope)| {
                let across: f64 = row.iter().zip(gradient).map(|(c, g)| c * g).sum();
                slope * across
            })
            .sum();
        // Rounding may leave a variance of nothing slightly below it.
        variance.max(0.0).sqrt()
    }
}

fn add(mut sum: [Gradient; 3], more: [Gradient; 3]) -> [Gradient; 3] {
    for (sum, more) in sum.iter_mut().flatten().zip(more.iter().flatten()) {
        *sum += more;
    }
    sum
}

/// Derivatives of the stiffness along x, y, z in each of the rows.
fn gradients(
    model: &MapModel<'_>,
    map: &StiffnessMap,
    poses: &PoseSet,
    rows: &[usize],
) -> Result<Vec<[Gradient; 3]>, RobotError> {
    let Some(joints) = model.joints() else {
        return Ok(Vec::new());
    };
    let (robot, mechanism) = (model.robot(), model.mechanism());
    let (theory, room) = (Theory::EulerBernoulli, POSES.min(rows.len()));
    let mut batch = BatchPredictor::with(robot, mechanism, joints, theory, room)?;
    let mut pose = robot.nominal_pose();
    let mut found = Vec::with_capacity(rows.len());
    for rows in rows.chunks(room) {
        for (index, &row) in rows.iter().enumerate() {
            poses.fill(map.places[row] as usize, &mut pose);
            batch.place(index, &pose)?;
        }
        batch.solve(model.factors(), true)?;
        for index in 0..rows.len() {
            found.push([0, 1, 2].map(|axis| {
                let compliance = batch.direct_compliance(index, axis).unwrap_or(f64::NAN)
                    + model.rocking_m_per_n(map.end_m(rows[index]), axis);
                let [beam, link] = batch.gradient(index, axis).unwrap_or([[f64::NAN; 4]; 2]);
                let stiffness_squared = compliance.powi(-2);
                std::array::from_fn(|factor| {
                    let slope = if factor < 4 {
                        beam[factor]
                    } else {
                        link[factor - 4]
                    };
                    -slope * stiffness_squared
                })
            }));
        }
    }
    Ok(found)
}
