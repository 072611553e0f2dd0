//! Which parameters are free unless the user says.

use stiffbench_beams::robot::{Mechanism, ModelParameter, Robot, RoleInFit};

use crate::fit::FitError;
use crate::parameters::{FitRole, ParameterChoice};
use crate::search::norm;

use super::load_cases::prediction::{PredictedMotions, SeenRows};
use super::load_cases::problem::LoadCaseModel;

/// Links whose own compliance gives less than this share of what was measured, or of what the rigid robot leaves of positions, are rigid: the
/// share is far below any gauge.
const RIGID_SHARE: f64 = 1e-6;

/// The springs that the robot file frees; if it frees none, those of all joints on rigid links (the virtual joint method), else the factors
/// of beams.
#[must_use]
pub fn usual_parameters(robot: &Robot, mechanism: &Mechanism) -> ParameterChoice {
    if is_about_springs(robot, mechanism) {
        spring_choice(robot, mechanism)
    } else {
        ParameterChoice::default()
    }
}

/// Whether the robot file leaves a spring to the fit, or has no beams.
fn is_about_springs(robot: &Robot, mechanism: &Mechanism) -> bool {
    let mut springs = robot.own_springs();
    mechanism.members.is_empty() || springs.any(|(_, spring)| spring.in_fit != RoleInFit::Fixed)
}

/// The same for load cases, where beams that hardly give count as rigid links.
///
/// # Errors
/// [`FitError`] for a pose that cannot be reached, or a structure that carries nothing.
pub fn usual_choice(model: &LoadCaseModel<'_>) -> Result<ParameterChoice, FitError> {
    let (robot, mechanism, posed) = (model.robot, model.mechanism, model.posed);
    if is_about_springs(robot, mechanism) {
        return Ok(spring_choice(robot, mechanism));
    }
    let mut structure = model.start.clone();
    let own = robot.own_springs().map(|(spring, _)| spring);
    for spring in own.chain(model.start.springs()) {
        structure.set(&spring, 0.0);
    }
    let start = &structure;
    let mechanics = LoadCaseModel { start, ..*model }.mechanics(&[])?;
    let motions = PredictedMotions::of(&mechanics, posed, false);
    let own = SeenRows::of(posed, None).changed(&motions.values);
    let seen = SeenRows::of(posed, model.tracker()?.as_ref());
    let measured = seen.left_by_rigid_robot(&model.measured());
    if norm(&own) > RIGID_SHARE * norm(&measured) {
        return Ok(ParameterChoice::default());
    }
    Ok(spring_choice(robot, mechanism))
}

/// The springs that the robot file frees, or those of all joints if it frees none; factors of beams are fixed.
#[must_use]
pub fn spring_choice(robot: &Robot, mechanism: &Mechanism) -> ParameterChoice {
    let mut choice = ParameterChoice::default();
    for beam in ModelParameter::BEAMS {
        choice.set(&beam, FitRole::Fixed);
    }
    let chosen: Vec<_> = robot
        .own_springs()
        .filter(|(_, spring)| spring.in_fit != RoleInFit::Fixed)
        .collect();
    for (parameter, spring) in &chosen {
        let role = match &spring.in_fit {
            RoleInFit::Fixed => FitRole::Fixed,
            RoleInFit::Free => FitRole::Free,
            RoleInFit::Tied(other) => FitRole::TiedTo(other.clone()),
        };
        choice.set(parameter, role);
    }
    if chosen.is_empty() {
        for joint in mechanism.joints(robot) {
            let joint = &robot.joints[joint];
            let own = ModelParameter::of_joint(&joint.name, joint.motion);
            choice.set(&own, FitRole::Free);
        }
    }
    choice
}
