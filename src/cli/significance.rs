//! `stiffbench significance`.

use crate::analysis::{Inputs, fixed_physics};
use crate::fit::{Scope, significance};
use crate::report::{significance_json, significance_with_sequence};
use crate::robot::ModelParameter;
use crate::stiffness::Method;
use crate::test_point::PoseId;

use super::args::SignificanceArgs;
use super::failure::{CliError, Failure};
use super::model::physics_text;
use super::outcome::Outcome;

/// Which constant matters where.
pub(super) fn run(args: &SignificanceArgs) -> Result<Outcome, Failure> {
    let chosen = args.model.resolve()?;
    let pose = match (&args.pose, chosen.robot.poses.first()) {
        (Some(pose), _) => PoseId::new(pose),
        (None, Some(first)) => first.id.clone(),
        (None, None) => {
            return Err(CliError::Argument {
                argument: "--pose".to_owned(),
                problem: format!("{} has no named pose", chosen.source.name),
                help: Some("add [poses.NAME] to the robot file".to_owned()),
            }
            .into());
        }
    };
    let scope = if args.beams_only {
        Scope::Beams
    } else {
        Scope::All
    };
    let mechanism = chosen.mechanism()?;
    let physics = fixed_physics(&chosen, Method::Regression);
    let further = args.parameters.iter();
    let further = further.map(|name| ModelParameter::find(&chosen.robot, mechanism, name));
    let further = further.collect::<Result<Vec<_>, _>>()?;
    let found = significance(
        &chosen.robot,
        mechanism,
        &pose,
        &chosen.factors,
        scope,
        physics.as_ref(),
        &further,
    )?;
    let text = format!(
        "Pose {pose}\n{}\n{}",
        physics_text(&chosen.physics),
        significance_with_sequence(&found)
    );
    Ok(
        Outcome::new("significance", text, significance_json(&found))
            .with_inputs(Inputs::default().with_model(&chosen))
            .with_warnings(chosen.warnings.clone()),
    )
}
