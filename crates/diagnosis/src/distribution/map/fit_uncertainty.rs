//! What the uncertainty of the fitted factors does to a map.
//!
//! To first order: the derivatives of a stiffness to the logarithms of the factors, exact, times their covariance. A minimum over the poses
//! has the derivatives of its pose (the pose itself stands still to first order), a mean the mean of those of all poses. A principal
//! stiffness has the derivatives along its direction, which stands still to first order too.

use rayon::prelude::*;

use stiffbench_beams::robot::{ModelParameter, MultiPosePredictor, RobotError, Theory};
use stiffbench_numeric::statistics::Estimate;

use super::column::{MapColumn, stiffness_and_unit};
use super::model::MapModel;
use super::statistics::ColumnStatistics;
use super::stiffness_map::StiffnessMap;
use crate::distribution::pose_set::PoseSample;

/// Poses placed at once: few enough to stay in the second-level cache.
const POSES: usize = 64;

/// Rows that a thread takes at a time.
const CHUNK: usize = 2048;

/// How well the factors of a model are known.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FittedCovariance {
    /// The parameters.
    pub parameters: Vec<ModelParameter>,
    /// Covariance of ln a of factors and of the compliance of springs, row by row; zero where a parameter was not fitted.
    pub matrix: Vec<Vec<f64>>,
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

/// Derivatives of a stiffness to the parameters, N/m or N/m per rad/(N·m).
type Gradient = Vec<f64>;

/// Carries the covariance to smallest, largest and mean of every column; `None` for columns about an axis, and where laws are not linear.
///
/// # Errors
/// [`RobotError`] if the model cannot be built; its poses were solved before.
pub fn fit_uncertainty(
    model: &MapModel<'_>,
    map: &StiffnessMap,
    poses: &PoseSample,
    covariance: &FittedCovariance,
    columns: &[(MapColumn, ColumnStatistics)],
) -> Result<Vec<Option<FitUncertainty>>, RobotError> {
    if !model.is_linear() || map.is_empty() {
        return Ok(vec![None; columns.len()]);
    }
    let mut found = vec![None; columns.len()];
    let along: Vec<usize> = (0..columns.len())
        .filter(|&column| !columns[column].0.is_rotational())
        .collect();
    let kinds: Vec<MapColumn> = along.iter().map(|&i| columns[i].0.clone()).collect();
    let means = mean_gradients(model, map, poses, &kinds, &covariance.parameters)?;
    for ((&column, kind), mean) in along.iter().zip(&kinds).zip(&means) {
        let statistics = &columns[column].1;
        let extremes = [&statistics.smallest, &statistics.largest];
        let rows = extremes.map(|extreme| extreme.row);
        let kind = std::slice::from_ref(kind);
        let of_extremes = gradients(model, map, poses, kind, &covariance.parameters, &rows)?;
        let estimate = |value: f64, gradient: &Gradient| Estimate {
            value,
            standard_uncertainty: covariance.carried(gradient),
            dof: covariance.dof.unwrap_or(f64::INFINITY),
        };
        let [smallest, largest] = extremes.map(|extreme| extreme.stiffness_n_per_m);
        found[column] = Some(FitUncertainty {
            smallest: estimate(smallest, &of_extremes[0][0]),
            largest: estimate(largest, &of_extremes[1][0]),
            mean: estimate(statistics.mean.value, mean),
        });
    }
    Ok(found)
}

/// Means of the derivatives over all rows, on all cores.
fn mean_gradients(
    model: &MapModel<'_>,
    map: &StiffnessMap,
    poses: &PoseSample,
    columns: &[MapColumn],
    parameters: &[ModelParameter],
) -> Result<Vec<Gradient>, RobotError> {
    let rows: Vec<usize> = (0..map.len()).collect();
    let nothing = || vec![vec![0.0; parameters.len()]; columns.len()];
    // One sum a chunk, added up in order afterwards: the same bytes for any number of threads.
    let chunks: Vec<Vec<Gradient>> = rows
        .par_chunks(CHUNK)
        .map(|rows| {
            let gradients = gradients(model, map, poses, columns, parameters, rows)?;
            Ok(gradients.iter().fold(nothing(), |sum, more| add(sum, more)))
        })
        .collect::<Result<_, RobotError>>()?;
    let mut sums = chunks.iter().fold(nothing(), |sum, more| add(sum, more));
    for sum in sums.iter_mut().flatten() {
        *sum /= map.len() as f64;
    }
    Ok(sums)
}

impl FittedCovariance {
    /// The standard uncertainty of what has this gradient.
    fn carried(&self, gradient: &[f64]) -> f64 {
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

fn add(mut sum: Vec<Gradient>, more: &[Gradient]) -> Vec<Gradient> {
    for (sum, more) in sum.iter_mut().flatten().zip(more.iter().flatten()) {
        *sum += more;
    }
    sum
}

/// Derivatives of the stiffness of columns in each of the rows: N/m to ln a of a factor, and to the compliance of a spring.
///
/// # Errors
/// [`RobotError`] if the model cannot be built; its poses were solved before.
pub(in crate::distribution) fn gradients(
    model: &MapModel<'_>,
    map: &StiffnessMap,
    poses: &PoseSample,
    columns: &[MapColumn],
    parameters: &[ModelParameter],
    rows: &[usize],
) -> Result<Vec<Vec<Gradient>>, RobotError> {
    let Some(joints) = model.joints() else {
        return Ok(Vec::new());
    };
    let (robot, mechanism) = (model.robot(), model.mechanism());
    let (theory, room) = (Theory::EulerBernoulli, POSES.min(rows.len()));
    // Springs of the model that are no parameters are there too, behind these.
    let springs = model.factors().springs();
    let others = springs.filter(|spring| !parameters.contains(spring));
    let all: Vec<ModelParameter> = parameters.iter().cloned().chain(others).collect();
    let mut predictor = MultiPosePredictor::with(robot, mechanism, joints, theory, &all, room)?;
    let mut pose = robot.nominal_pose();
    predictor.differentiate_whole();
    let mut found = Vec::with_capacity(rows.len());
    for rows in rows.chunks(room) {
        for (index, &row) in rows.iter().enumerate() {
            poses.fill(map.places[row] as usize, &mut pose);
            predictor.place(index, &pose)?;
        }
        predictor.solve(model.factors(), true)?;
        for (index, &row) in rows.iter().enumerate() {
            let compliance = translation(model, &predictor, index, map.end_m(row));
            let mut gradients = vec![vec![f64::NAN; parameters.len()]; columns.len()];
            for (gradient, column) in gradients.iter_mut().zip(columns) {
                let (stiffness, unit) = stiffness_and_unit(column, &compliance);
                let slopes = predictor.whole_gradient(index).iter();
                for (gradient, slope) in gradient.iter_mut().zip(slopes) {
                    // Where nothing yields no parameter changes anything.
                    *gradient = if stiffness.is_finite() {
                        -slope.along(unit) * stiffness * stiffness
                    } else {
                        0.0
                    };
                }
            }
            found.push(gradients);
        }
    }
    Ok(found)
}

/// Displacement of the end per force where a predictor stands, with its base, m/N; not a number where there is none.
fn translation(
    model: &MapModel<'_>,
    predictor: &MultiPosePredictor<'_>,
    index: usize,
    end_m: [f64; 3],
) -> [[f64; 3]; 3] {
    let compliance = predictor.compliance(index);
    compliance.map_or([[f64::NAN; 3]; 3], |compliance| {
        model.on_its_base(&compliance, end_m).translation()
    })
}
