//! Errors of a robot's poses as a linear problem: which column explains what rigid geometry leaves, and may its value be.
//!
//! The recording of the UR5 has no load, so that it is no session; the search is the same: rigid geometry is the baseline, each error of a
//! joint a candidate.

use stiffbench_diagnosis::mismatch::MisfitShares;
use stiffbench_diagnosis::search::{ForwardProblem, forward_selection, rivals};

use super::error::ProveError;
use super::pose_search::{LinearFit, NotIndependent, PoseCandidate, PoseSearch};
use super::recording_score::{ComparedFigure, RecordingOutcome, RecordingScore};
use super::recordings::Recording;

/// Orders of a joint's angle that are tried.
const ORDERS: [u32; 2] = [1, 2];

/// Joints whose angle matters: the sixth turns the tool about itself.
const JOINTS: usize = 5;

/// Rows of one pose.
const AXES: usize = 3;

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

    fn candidates(&self) -> Vec<PoseCandidate> {
        let compliance = |(name, column): &(String, Vec<f64>)| {
            let joint = name.trim_start_matches("joint").chars().next();
            PoseCandidate {
                name: format!("joint-compliance at joint {}", joint.unwrap_or('?')),
                columns: vec![column.clone()],
            }
        };
        let mut out: Vec<PoseCandidate> = self.compliance.iter().map(compliance).collect();
        for joint in 0..JOINTS {
            for order in ORDERS {
                let turn = |function: fn(f64) -> f64| -> Vec<f64> {
                    self.arms[joint]
                        .iter()
                        .zip(&self.angles_rad[joint])
                        .map(|(arm, angle)| arm * function(f64::from(order) * angle))
                        .collect()
                };
                out.push(PoseCandidate {
                    name: format!("periodic in joint {}, order {order}", joint + 1),
                    columns: vec![turn(f64::sin), turn(f64::cos)],
                });
            }
        }
        out
    }
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

/// How the answer of a search counts.
fn outcome(
    verdict: &str,
    is_expected: bool,
    first: Option<&String>,
    foreign: &[String],
) -> RecordingOutcome {
    match verdict {
        "explained" if first.is_some_and(|name| foreign.contains(name)) => {
            RecordingOutcome::FalseDominant
        }
        _ if is_expected && foreign.is_empty() => RecordingOutcome::Right,
        "nothing-missing" => RecordingOutcome::Mute,
        _ => RecordingOutcome::NotRight,
    }
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
    let singular = |NotIndependent| ProveError::Form {
        file: recording.name.clone(),
        problem: "its columns are not independent".to_owned(),
    };
    let with = |extra: &[&Vec<f64>]| {
        let mut all: Vec<&Vec<f64>> = poses.rigid.iter().collect();
        all.extend(extra);
        LinearFit::new(&all, &poses.error_mm).map_err(singular)
    };
    let rigid = with(&[])?;
    let candidates = poses.candidates();
    let search = search(&poses, &candidates, seed).map_err(singular)?;
    let heavy: Vec<&Vec<f64>> = poses.compliance.iter().take(2).map(|(_, c)| c).collect();
    let periodic: Vec<&Vec<f64>> = candidates
        .iter()
        .filter(|candidate| candidate.columns.len() > 1)
        .flat_map(|candidate| &candidate.columns)
        .collect();
    let (compliant, turning) = (with(&heavy)?, with(&periodic)?);
    let mut all = periodic.clone();
    all.extend(&heavy);
    let both = with(&all)?;
    let rows = poses.error_mm.len() as f64;
    let bic = |simple: &LinearFit, rich: &LinearFit| {
        let more = rich.values.len() as f64 - simple.values.len() as f64;
        rows * (simple.squares / rich.squares).ln() - more * rows.ln()
    };
    let value = |linear: &LinearFit, back: usize| {
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
    let expected = recording.right_verdicts();
    let is_expected = expected.iter().any(|right| right == verdict);
    let chosen = || search.chosen.iter().map(|(name, _)| name);
    let is_false = |name: &&String| {
        recording
            .not
            .iter()
            .any(|not| name.starts_with(not.as_str()))
    };
    let foreign: Vec<String> = chosen().filter(is_false).cloned().collect();
    Ok(RecordingScore {
        name: recording.name.clone(),
        readings: poses.error_mm.len(),
        expected,
        physics: recording.physics.clone(),
        verdict: verdict.to_owned(),
        grade: None,
        leading: chosen().take(1).cloned().collect(),
        shares: MisfitShares::default(),
        words: words(verdict, &search, left),
        outcome: outcome(verdict, is_expected, chosen().next(), &foreign),
        foreign,
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

fn words(verdict: &str, search: &Found, left: [f64; AXES]) -> String {
    let chosen: Vec<String> = search
        .chosen
        .iter()
        .map(|(name, delta_chi2)| format!("{name} ({:.0} standard errors)", delta_chi2.sqrt()))
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

/// What the search chose and rejected.
struct Found {
    /// Name and Δχ² beside the others.
    chosen: Vec<(String, f64)>,
    /// Name, value and standard error of candidates that would have passed with an impossible value.
    rejected: Vec<(String, f64, f64)>,
    residuals: Vec<f64>,
}

/// Searches for what rigid geometry leaves.
fn search(poses: &Poses, candidates: &[PoseCandidate], seed: u64) -> Result<Found, NotIndependent> {
    let rows = (&poses.error_mm[..], &poses.rigid[..]);
    let problem = PoseSearch::new(rows, candidates, independent_share, seed);
    let start = problem.model(Vec::new())?;
    let scores = problem.score(&start)?;
    let model = forward_selection(&problem, &start, &scores)?.model;
    let mut found = Found {
        chosen: Vec::new(),
        rejected: Vec::new(),
        residuals: model.fit.residuals.clone(),
    };
    for (term, &place) in model.terms.iter().enumerate() {
        let ranked = rivals(&problem, &model, term)?;
        let own = ranked.iter().find(|one| problem.is_term(&model, term, one));
        let delta_chi2 = own.map_or(0.0, |own| problem.evidence(own).delta_chi2);
        let name = candidates[place].name.clone();
        found.chosen.push((name, delta_chi2));
    }
    for score in scores.iter().filter(|score| problem.is_forbidden(score)) {
        let fit = problem.model(vec![score.candidate])?.fit;
        let name = candidates[score.candidate].name.clone();
        if let (Some(value), Some(u)) = (fit.values.last(), fit.standard_errors.last()) {
            found.rejected.push((name, *value, *u));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
