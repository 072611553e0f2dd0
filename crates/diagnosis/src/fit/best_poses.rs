//! Which poses of the workspace determine a list of parameters best, before anything is measured.

use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, NamedPose, Robot};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_numeric::vector::{along6, dot6};

use super::load_cases::problem::unloaded_springs;
use super::plan::{PlannedMotion, TriedPose};
use super::proposed_poses::{PoseRules, ProposedWithin};
use crate::fit::FitError;
use crate::mismatch::USUAL_NOISE;
use crate::search::Information;

/// Poses that are tried beside the named ones, spread evenly over the limits.
const TRIED_POSES: usize = 600;

/// Standard deviation to which every parameter is known before any reading, so that the first poses can be compared, in units of what one pose
/// says of it on average: far beyond any measurement.
const VAGUE: f64 = 3e4;

/// Poses with what they determine.
#[derive(Debug, Clone, PartialEq)]
pub struct BestPoses {
    /// The poses, in the order in which they were chosen.
    pub poses: Vec<NamedPose>,
    /// The tool centre in each of them, in the axes of the base, m.
    pub tools_m: Vec<[f64; 3]>,
    /// Poses within the rules among which they were chosen.
    pub tried: usize,
    /// The rules that they keep.
    pub within: ProposedWithin,
    /// For each parameter the expected standard error, in its unit (of a factor that of its logarithm): the Cramér-Rao limit; `None` of
    /// a spring that no load acts on in any pose.
    pub errors: Vec<(ModelParameter, Option<f64>)>,
}

/// The poses, among the named ones and poses spread over the limits, whose readings have the largest determinant of the information on the
/// parameters (D-optimality: Pukelsheim, Optimal Design of Experiments, 2006, section 6.2), by one choice after the other and then exchanges.
///
/// # Arguments
/// - `start`: values of the parameters; errors that grow with the displacement follow from them.
/// - `parameters`: those to be determined, at least one; springs that no load acts on have no part in the choice.
/// - `procedure`: what is read in every pose, on a bench with usual noise.
/// - `rules`, `count`: what is stated of the poses, and their number, at least one.
///
/// # Errors
/// [`FitError::NoPose`] if none keeps the rules; [`FitError::Dependent`] if no choice of poses determines all parameters; for a structure that carries nothing. Poses that cannot be
/// reached are passed over.
pub fn best_poses(
    robot: (&Robot, &Mechanism),
    start: &FittingFactors,
    parameters: &[ModelParameter],
    procedure: &Procedure,
    (rules, count): (&PoseRules, usize),
) -> Result<BestPoses, FitError> {
    let (proposed, within) = ProposedWithin::poses(robot, rules, Vec::new(), TRIED_POSES)?;
    let tried = TriedPose::all(robot, parameters, start, proposed)?;
    let says = tried
        .iter()
        .map(|pose| pose.says(&motions(procedure, pose)));
    let says: Vec<Information> = says.collect();
    let nothing = Information::of_prior(&[], parameters.len() + 1);
    let all = says.iter().fold(nothing, |all, pose| all.with(pose));
    let lengths = all.lengths();
    let unloaded = unloaded_springs(parameters, &lengths, lengths[parameters.len()]);
    let loaded: Vec<usize> = (0..parameters.len()).filter(|i| !unloaded[*i]).collect();
    // Each parameter in units of what one pose says of it on average: the determinant is then a fair number.
    let unit = (tried.len().max(1) as f64).sqrt();
    let scales: Vec<f64> = loaded.iter().map(|place| unit / lengths[*place]).collect();
    let says = says.iter().map(|pose| pose.of_some(&loaded, &scales));
    let says: Vec<Information> = says.collect();
    let vague = Information::of_prior(&vec![VAGUE; loaded.len()], 0);
    let worth = Information::log_determinant;
    let (chosen, known) = vague.best_together(&says, count, &worth);
    let is_determined = |variances: &Vec<f64>| variances.iter().all(|v| *v < 0.5 * VAGUE * VAGUE);
    let variances = known.variances().filter(is_determined);
    let variances = variances.filter(|variances| !variances.is_empty());
    let dependent = || {
        let free: Vec<String> = parameters.iter().map(ToString::to_string).collect();
        let first = free.first().cloned().unwrap_or_default();
        let free = free.join(", ");
        FitError::Dependent { free, first }
    };
    let variances = variances.ok_or_else(dependent)?;
    let error = |place: usize| {
        let i = loaded.iter().position(|known| *known == place)?;
        Some(scales[i] * variances[i].sqrt())
    };
    let errors = parameters.iter().cloned().enumerate();
    Ok(BestPoses {
        errors: errors
            .map(|(place, parameter)| (parameter, error(place)))
            .collect(),
        tried: tried.len(),
        within,
        tools_m: chosen.iter().map(|&place| tried[place].at.tool_m).collect(),
        poses: chosen
            .into_iter()
            .map(|place| NamedPose {
                id: tried[place].at.name.clone(),
                pose: tried[place].at.pose.clone(),
                stated_zy_m: None,
            })
            .collect(),
    })
}

/// The displacements per load that a procedure reads in a pose, with the standard deviations of the slopes of all its runs together, m/N.
fn motions(procedure: &Procedure, pose: &TriedPose) -> Vec<PlannedMotion> {
    let loads_n = &procedure.loads_n;
    let mean_n = loads_n.iter().sum::<f64>() / loads_n.len().max(1) as f64;
    // The squared length of the loads about their mean: the variance of a slope is that of a reading over it.
    let length: f64 = loads_n.iter().map(|load| (load - mean_n).powi(2)).sum();
    let repeats = f64::from(procedure.repeats.max(1));
    let mut motions = Vec::new();
    for direction in &procedure.directions {
        let load = along6(direction.unit_vector());
        let axes = procedure.displacement_axes.iter();
        let mut units: Vec<[f64; 6]> = axes.map(|axis| along6(axis.unit_vector())).collect();
        if units.is_empty() {
            units.push(load);
        }
        motions.extend(units.into_iter().map(|unit| {
            let slope = dot6(unit, pose.mechanics.motion(load));
            let variance = USUAL_NOISE.reading_sd_m.powi(2) / length
                + (USUAL_NOISE.run_slope_sd * slope).powi(2);
            let sd = (variance / repeats).sqrt();
            PlannedMotion { unit, load, sd }
        }));
    }
    motions
}
