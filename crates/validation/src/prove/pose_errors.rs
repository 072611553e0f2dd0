//! Errors of a robot's poses as a linear problem: which column explains what rigid geometry leaves, and may its value be.
//!
//! The recording of the UR5 has no load, so the engine of readings has nothing to work on; the logic is the same: project out what the
//! baseline absorbs, let every candidate try, believe a gain only beyond the limit of the whole search, reject what physics forbids.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::error::ProveError;
use super::orthogonal::unit_beside;
use super::recordings::{ComparedFigure, Recording, RecordingScore};

/// Level of the search.
const LEVEL: f64 = 0.04;

/// Draws of noise for its limit.
const DRAWS: usize = 2_000;

/// Orders of a joint's angle that are tried.
const ORDERS: [u32; 2] = [1, 2];

/// Joints whose angle matters: the sixth turns the tool about itself.
const JOINTS: usize = 5;

/// A value this many standard errors below zero is impossible, not small.
const IMPOSSIBLE: f64 = 2.0;

/// Rows of one pose.
const AXES: usize = 3;

/// A candidate: its name, its columns, whether its value must not be negative.
struct Candidate {
    name: String,
    columns: Vec<Vec<f64>>,
    positive: bool,
}

/// Columns of a table of numbers by name; other fields are passed over.
fn columns(name: &str, text: &str) -> Result<Vec<(String, Vec<f64>)>, ProveError> {
    let wrong = |problem: String| ProveError::Form {
        file: name.to_owned(),
        problem,
    };
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let heads = reader.headers().map_err(|error| wrong(error.to_string()))?;
    let mut out: Vec<(String, Vec<f64>)> =
        heads.iter().map(|h| (h.to_owned(), Vec::new())).collect();
    for record in reader.records() {
        let record = record.map_err(|error| wrong(error.to_string()))?;
        for ((_, column), field) in out.iter_mut().zip(&record) {
            if let Ok(number) = field.parse() {
                column.push(number);
            }
        }
    }
    Ok(out)
}

/// The regressors and angles of the recording.
struct Poses {
    error_mm: Vec<f64>,
    rigid: Vec<Vec<f64>>,
    compliance: Vec<(String, Vec<f64>)>,
    arms: Vec<Vec<f64>>,
    angles_rad: Vec<Vec<f64>>,
}

impl Poses {
    fn read(derived: &str, grid: &str) -> Result<Self, ProveError> {
        let name = "derived_ur5_regressors.csv";
        let derived = columns(name, derived)?;
        let of = |test: &dyn Fn(&str) -> bool| -> Vec<(String, Vec<f64>)> {
            derived
                .iter()
                .filter(|(head, _)| test(head))
                .cloned()
                .collect()
        };
        let values = |found: Vec<(String, Vec<f64>)>| found.into_iter().map(|(_, v)| v).collect();
        let error_mm = of(&|head| head == "error_mm")
            .into_iter()
            .next()
            .map(|(_, values)| values)
            .unwrap_or_default();
        let angles_rad: Vec<Vec<f64>> = columns("ur5_grid_1000.csv", grid)?
            .into_iter()
            .filter(|(head, _)| head.starts_with("joint_"))
            .map(|(_, degrees)| {
                let radians = degrees.iter().map(|angle: &f64| angle.to_radians());
                // One row for each axis of a pose.
                radians.flat_map(|angle| [angle; AXES]).collect()
            })
            .collect();
        let poses = Self {
            rigid: values(of(&|head| head.starts_with("rigid"))),
            compliance: of(&|head| head.contains("_compliance_")),
            arms: values(of(&|head| head.ends_with("_arm_mm_per_rad"))),
            error_mm,
            angles_rad,
        };
        let rows = poses.error_mm.len();
        let all = poses
            .rigid
            .iter()
            .chain(poses.compliance.iter().map(|(_, column)| column))
            .chain(&poses.arms)
            .chain(&poses.angles_rad);
        let complete = rows > 0
            && poses.arms.len() == JOINTS
            && poses.angles_rad.len() >= JOINTS
            && !poses.compliance.is_empty()
            && all.into_iter().all(|column| column.len() == rows);
        if complete {
            Ok(poses)
        } else {
            Err(ProveError::Form {
                file: name.to_owned(),
                problem: "columns are missing, or of unequal length".to_owned(),
            })
        }
    }

    fn candidates(&self) -> Vec<Candidate> {
        let mut out: Vec<Candidate> = self
            .compliance
            .iter()
            .map(|(name, column)| Candidate {
                name: format!(
                    "joint-compliance at joint {}",
                    name.trim_start_matches("joint")
                        .chars()
                        .next()
                        .unwrap_or('?')
                ),
                columns: vec![column.clone()],
                positive: true,
            })
            .collect();
        for joint in 0..JOINTS {
            for order in ORDERS {
                let turn = |function: fn(f64) -> f64| -> Vec<f64> {
                    self.arms[joint]
                        .iter()
                        .zip(&self.angles_rad[joint])
                        .map(|(arm, angle)| arm * function(f64::from(order) * angle))
                        .collect()
                };
                out.push(Candidate {
                    name: format!("periodic in joint {}, order {order}", joint + 1),
                    columns: vec![turn(f64::sin), turn(f64::cos)],
                    positive: false,
                });
            }
        }
        out
    }
}

/// A fit by least squares.
struct Linear {
    values: Vec<f64>,
    standard_errors: Vec<f64>,
    squares: f64,
    residuals: Vec<f64>,
}

/// Fits columns to a vector; `None` if they are not independent.
fn fit(columns: &[&Vec<f64>], vector: &[f64]) -> Option<Linear> {
    let lengths: Vec<f64> = columns
        .iter()
        .map(|column| column.iter().map(|x| x * x).sum::<f64>().sqrt())
        .collect();
    let rows = vector.len();
    let matrix = DMatrix::from_fn(rows, columns.len(), |i, j| columns[j][i] / lengths[j]);
    let right = DVector::from_column_slice(vector);
    let normal = (matrix.transpose() * &matrix).cholesky()?;
    let values = normal.solve(&(matrix.transpose() * &right));
    let residuals = &right - &matrix * &values;
    let squares = residuals.norm_squared();
    let variance = squares / (rows - columns.len()) as f64;
    let inverse = normal.inverse();
    Some(Linear {
        standard_errors: (0..columns.len())
            .map(|j| (variance * inverse[(j, j)]).sqrt() / lengths[j])
            .collect(),
        values: values.iter().zip(&lengths).map(|(v, l)| v / l).collect(),
        squares,
        residuals: residuals.iter().copied().collect(),
    })
}

/// Mean distance of the residuals of a pose, mm.
fn mean_distance(residuals: &[f64]) -> f64 {
    let distances = residuals
        .chunks(AXES)
        .map(|pose| pose.iter().map(|x| x * x).sum::<f64>().sqrt());
    distances.sum::<f64>() * AXES as f64 / residuals.len() as f64
}

/// Correlation of neighbouring poses along each axis.
fn lag_1(residuals: &[f64]) -> [f64; AXES] {
    std::array::from_fn(|axis| {
        let along: Vec<f64> = residuals.iter().skip(axis).step_by(AXES).copied().collect();
        let squares: f64 = along.iter().map(|x| x * x).sum();
        let products: f64 = along.windows(2).map(|pair| pair[0] * pair[1]).sum();
        products / squares
    })
}

/// Share of the readings that count as independent: neighbouring poses share a part of their errors (Bartlett's factor for lag 1).
fn independent_share(residuals: &[f64]) -> f64 {
    let mean = lag_1(residuals).iter().sum::<f64>() / AXES as f64;
    let mean = mean.clamp(0.0, 0.99);
    (1.0 - mean) / (1.0 + mean)
}

/// Tries joint compliance and errors periodic in the joint angles on the recorded pose errors.
///
/// # Arguments
/// - `derived`, `grid`: `derived_ur5_regressors.csv` and `ur5_grid_1000.csv`.
///
/// # Errors
/// [`ProveError::Form`].
pub fn score_pose_errors(
    recording: &Recording,
    derived: &str,
    grid: &str,
    seed: u64,
) -> Result<RecordingScore, ProveError> {
    let poses = Poses::read(derived, grid)?;
    let candidates = poses.candidates();
    let limit = limit(&poses, &candidates, seed);
    let singular = || ProveError::Form {
        file: recording.name.clone(),
        problem: "its columns are not independent".to_owned(),
    };
    let with = |extra: &[&Vec<f64>]| {
        let mut all: Vec<&Vec<f64>> = poses.rigid.iter().collect();
        all.extend(extra);
        fit(&all, &poses.error_mm).ok_or_else(singular)
    };
    let rigid = with(&[])?;
    let search = forward(&candidates, limit, &with, &rigid)?;
    let heavy: Vec<&Vec<f64>> = poses.compliance.iter().take(2).map(|(_, c)| c).collect();
    let periodic: Vec<&Vec<f64>> = candidates
        .iter()
        .filter(|candidate| !candidate.positive)
        .flat_map(|candidate| &candidate.columns)
        .collect();
    let (compliant, turning) = (with(&heavy)?, with(&periodic)?);
    let mut all = periodic.clone();
    all.extend(&heavy);
    let both = with(&all)?;
    let rows = poses.error_mm.len() as f64;
    let bic = |simple: &Linear, rich: &Linear| {
        let more = rich.values.len() as f64 - simple.values.len() as f64;
        rows * (simple.squares / rich.squares).ln() - more * rows.ln()
    };
    let value = |linear: &Linear, back: usize| {
        let place = linear.values.len() - back;
        (linear.values[place], linear.standard_errors[place])
    };
    let ours = [
        ("mean-mm-uncalibrated", mean_distance(&poses.error_mm)),
        ("mean-mm-rigid", mean_distance(&rigid.residuals)),
        (
            "mean-mm-rigid-compliance",
            mean_distance(&compliant.residuals),
        ),
        (
            "mean-mm-rigid-two-harmonics",
            mean_distance(&turning.residuals),
        ),
        ("delta-bic-compliance", bic(&rigid, &compliant)),
        ("delta-bic-two-harmonics", bic(&rigid, &turning)),
        (
            "delta-bic-compliance-after-two-harmonics",
            bic(&turning, &both),
        ),
        ("joint-3-compliance-1e-4rad-per-nm", value(&compliant, 1).0),
        ("joint-3-compliance-standard-error", value(&compliant, 1).1),
        ("joint-3-compliance-after-two-harmonics", value(&both, 1).0),
        (
            "joint-3-compliance-after-two-harmonics-standard-error",
            value(&both, 1).1,
        ),
    ];
    let left = lag_1(&search.residuals);
    let poses_count = rows / AXES as f64;
    let is_left = left.iter().any(|r| r.abs() * poses_count.sqrt() > 4.0);
    let verdict = match (is_left, search.chosen.is_empty()) {
        (true, _) => "unknown",
        (false, true) => "nothing-missing",
        (false, false) => "explained",
    };
    let mut expected = vec![recording.verdict.clone()];
    expected.extend(recording.also_right.iter().cloned());
    Ok(RecordingScore {
        name: recording.name.clone(),
        readings: poses.error_mm.len(),
        verdict_is_right: expected.iter().any(|right| right == verdict),
        expected,
        verdict: verdict.to_owned(),
        words: words(verdict, &search, left),
        false_names: search
            .chosen
            .iter()
            .filter(|(name, _)| {
                recording
                    .not
                    .iter()
                    .any(|not| name.starts_with(not.as_str()))
            })
            .map(|(name, _)| name.clone())
            .collect(),
        why: recording.why.clone(),
        figures: ours
            .into_iter()
            .map(|(name, ours)| ComparedFigure {
                name: name.to_owned(),
                known: recording.figures.get(name).copied(),
                ours: Some(ours),
            })
            .collect(),
    })
}

fn words(verdict: &str, search: &Forward, left: [f64; AXES]) -> String {
    let chosen: Vec<String> = search
        .chosen
        .iter()
        .map(|(name, gain)| format!("{name} ({:.0} standard errors)", gain.sqrt()))
        .collect();
    let rejected: Vec<String> = search
        .rejected
        .iter()
        .map(|(name, value, u)| format!("{name}: impossible, {value:.3} +/- {u:.3} 1e-4 rad/(N*m)"))
        .collect();
    format!(
        "{verdict}; {}; rejected: {}; left: correlation of neighbouring poses {:.2}, {:.2}, {:.2}",
        chosen.join(" and "),
        if rejected.is_empty() {
            "nothing".to_owned()
        } else {
            rejected.join(", ")
        },
        left[0],
        left[1],
        left[2]
    )
}

/// What a forward search chose and rejected.
struct Forward {
    /// Name and gain.
    chosen: Vec<(String, f64)>,
    /// Name, value and standard error of candidates that would have passed with an impossible value, in the first round.
    rejected: Vec<(String, f64, f64)>,
    residuals: Vec<f64>,
}

/// Fits the rigid columns together with others.
type FitWith<'f, 'c> = dyn Fn(&[&'c Vec<f64>]) -> Result<Linear, ProveError> + 'f;

fn forward<'c>(
    candidates: &'c [Candidate],
    limit: f64,
    with: &FitWith<'_, 'c>,
    rigid: &Linear,
) -> Result<Forward, ProveError> {
    let mut found = Forward {
        chosen: Vec::new(),
        rejected: Vec::new(),
        residuals: rigid.residuals.clone(),
    };
    let mut taken: Vec<&Vec<f64>> = Vec::new();
    let mut squares = rigid.squares;
    let mut free: Vec<&Candidate> = candidates.iter().collect();
    loop {
        let mut best: Option<(f64, usize, Linear)> = None;
        for (place, candidate) in free.iter().enumerate() {
            let mut all = taken.clone();
            all.extend(&candidate.columns);
            let tried = with(&all)?;
            let dof = (tried.residuals.len() - tried.values.len()) as f64;
            let gain = (squares - tried.squares) / (tried.squares / dof)
                * independent_share(&tried.residuals);
            let (value, u) = match (tried.values.last(), tried.standard_errors.last()) {
                (Some(value), Some(u)) => (*value, *u),
                _ => continue,
            };
            if candidate.positive && value < 0.0 {
                if found.chosen.is_empty() && gain > limit && value < -IMPOSSIBLE * u {
                    found.rejected.push((candidate.name.clone(), value, u));
                }
                continue;
            }
            if gain > limit && best.as_ref().is_none_or(|(most, ..)| gain > *most) {
                best = Some((gain, place, tried));
            }
        }
        let Some((gain, place, fitted)) = best else {
            return Ok(found);
        };
        let candidate = free.remove(place);
        taken.extend(&candidate.columns);
        squares = fitted.squares;
        found.residuals = fitted.residuals;
        found.chosen.push((candidate.name.clone(), gain));
    }
}

/// Gain that the whole search exceeds on noise alone with the chance of its level.
fn limit(poses: &Poses, candidates: &[Candidate], seed: u64) -> f64 {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in &poses.rigid {
        basis.extend(unit_beside(column.clone(), &basis));
    }
    let units: Vec<Vec<Vec<f64>>> = candidates
        .iter()
        .map(|candidate| {
            let mut beside = basis.clone();
            let mut own = Vec::new();
            for column in &candidate.columns {
                if let Some(unit) = unit_beside(column.clone(), &beside) {
                    beside.push(unit.clone());
                    own.push(unit);
                }
            }
            own
        })
        .collect();
    let rows = poses.error_mm.len();
    let mut largest: Vec<f64> = (0..DRAWS as u64)
        .into_par_iter()
        .map(|draw| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(0x9e37_79b9) ^ draw);
            let noise: Vec<f64> = (0..rows).map(|_| StandardNormal.sample(&mut rng)).collect();
            let product =
                |unit: &Vec<f64>| -> f64 { unit.iter().zip(&noise).map(|(a, b)| a * b).sum() };
            units
                .iter()
                .zip(candidates)
                .map(|(own, candidate)| {
                    let z: Vec<f64> = own.iter().map(product).collect();
                    if candidate.positive && z.first().is_some_and(|z| *z < 0.0) {
                        0.0
                    } else {
                        z.iter().map(|z| z * z).sum()
                    }
                })
                .fold(0.0, f64::max)
        })
        .collect();
    largest.sort_by(f64::total_cmp);
    largest[((1.0 - LEVEL) * DRAWS as f64) as usize]
}

#[cfg(test)]
mod tests;
