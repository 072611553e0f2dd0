//! What belongs to absolute positions alone: the rigid robot as it was before, the frames, and springs that own weight does not load.

use stiffbench_beams::robot::{ModelParameter, TRACKER_PARAMETERS, TrackedPoses};
use stiffbench_numeric::least_squares::{ParameterCovariance, minimise};
use stiffbench_numeric::statistics::{root_mean_square, student_t_quantile};
use stiffbench_units_and_text::test_point::Direction;

use super::frames::moved_tracker;
use super::problem::{LoadCaseModel, LoadCaseProblem, frames_alone};
use crate::fit::weighed_problem::{WeighedProblem, leave_poses_out};
use crate::fit::{FitError, FittedFrames, FrameParameter};

/// Force that is named as what would determine a spring, N.
const NAMED_FORCE_N: f64 = 100.0;

/// The rigid robot with the frames that fit it best.
pub(in crate::fit) struct RigidRobot {
    /// All coordinates, those of springs zero.
    pub(in crate::fit) coordinates: Vec<f64>,
    /// What it predicts of every row, m.
    pub(in crate::fit) predicted: Vec<f64>,
    /// The same of each pose by a fit to the others.
    pub(in crate::fit) unseen: Vec<Option<f64>>,
}

impl RigidRobot {
    /// Fits the frames alone, with the weights of the problem.
    ///
    /// # Arguments
    /// - `leave_out`: whether each pose is to be left out in turn.
    ///
    /// # Errors
    /// [`FitError`].
    pub(in crate::fit) fn fit(
        model: &LoadCaseModel<'_>,
        problem: &mut LoadCaseProblem<'_>,
        leave_out: bool,
    ) -> Result<Self, FitError> {
        let set = frames_alone(problem.parameters())?;
        let settings = problem.settings();
        let fit = minimise(problem, &set, &settings)?;
        let unseen = if leave_out {
            leave_poses_out(
                problem,
                &set.with_start(&fit.free_values)?,
                &model.posed.labels_of_rows(),
            )?
        } else {
            vec![None; fit.residuals.len()]
        };
        Ok(Self {
            predicted: problem.predictions(&fit.values)?,
            coordinates: fit.values,
            unseen,
        })
    }

    /// Root mean square error in poses that a fit did not know, m.
    fn unseen_m(&self, measured: &[f64]) -> Option<f64> {
        let errors = self.unseen.iter().zip(measured);
        root_mean_square(errors.filter_map(|(unseen, measured)| Some((*unseen)? - measured)))
    }
}

/// The fitted frames with their standard errors.
///
/// # Arguments
/// - `coordinates`: all coordinates of the fit.
/// - `parameters`: how many of them are no frames.
pub(in crate::fit) fn fitted_frames(
    model: &LoadCaseModel<'_>,
    tracker: &TrackedPoses,
    coordinates: &[f64],
    parameters: usize,
    covariance: Option<&ParameterCovariance>,
    rigid: &RigidRobot,
) -> FittedFrames {
    let quantile = covariance.and_then(|found| student_t_quantile(0.975, found.interval_dof));
    let parameter = |place: usize| {
        let found = covariance.map(|found| &found.estimates[parameters + place]);
        let error = found.and_then(|found| found.standard_error);
        FrameParameter {
            name: TRACKER_PARAMETERS[place].into(),
            unit: if TRACKER_PARAMETERS[place].contains(".r") {
                "urad".into()
            } else {
                "um".into()
            },
            standard_error: error,
            half_width_95: error
                .zip(quantile)
                .map(|(error, quantile)| error * quantile),
        }
    };
    FittedFrames {
        frames: moved_tracker(tracker, &coordinates[parameters..]).frames,
        rigid: moved_tracker(tracker, &rigid.coordinates[parameters..]).frames,
        parameters: std::array::from_fn(parameter),
        rigid_unseen_m: rigid.unseen_m(&model.measured()),
    }
}

/// Why positions do not determine a spring by itself, and what would: in words.
///
/// # Arguments
/// - `loaded`: whether own weight or a load acts on it, though frames or other springs do the same.
///
/// # Errors
/// [`FitError`].
pub(in crate::fit) fn why_open(
    model: &LoadCaseModel<'_>,
    spring: &ModelParameter,
    loaded: bool,
) -> Result<String, FitError> {
    let mechanics = model.mechanics(std::slice::from_ref(spring))?;
    let mut best: Option<(f64, Direction, usize)> = None;
    for place in 0..model.posed.poses.len() {
        let derivative = &mechanics.pose(place).gradient[0];
        for axis in Direction::ALL {
            let i = axis.index();
            let moved: f64 = (0..3).map(|k| derivative[k][i].powi(2)).sum();
            if best.is_none_or(|(most, ..)| moved > most * (1.0 + 1e-9)) {
                best = Some((moved, axis, place));
            }
        }
    }
    let why = if loaded {
        "base frame, tool point or other springs move the measured point in the same way"
    } else if model.posed.cases.iter().all(|case| case.load == [0.0; 6]) {
        "the robot's own weight does not load it, or does not move the measured point by it"
    } else {
        "neither the robot's own weight nor the loads of these poses act on it"
    };
    let label = |pose: usize| {
        let mut cases = model.posed.cases.iter();
        let case = cases.find(|case| case.pose == pose);
        case.map(|case| model.posed.labels[case.label].to_string())
    };
    let remedy = best.filter(|(moved, ..)| *moved > 0.0).and_then(|(_, axis, pose)| {
        Some(format!(
            "positions with and without {NAMED_FORCE_N:.0} N along {axis} of the base would determine it, best in pose {}",
            label(pose)?
        ))
    });
    Ok(match remedy {
        Some(remedy) => format!("{why}; {remedy}"),
        None => format!("{why}; no force on the tool would load it in these poses"),
    })
}
