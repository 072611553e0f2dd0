//! `stiffbench robot significance`.

use clap::Args;
use stiffbench_document::Document;

use crate::analysis::{ArgumentError, Inputs, UnknownSprings, fixed_physics};
use crate::fit::{Scope, significance};
use crate::report::{BESIDE_BEAMS, SignificanceReport, physics_document};
use crate::robot::ModelParameter;
use crate::stiffness::Method;
use crate::test_point::PoseId;

use super::args::RobotModelArgs;
use super::{Failure, Outcome};

/// Arguments of `robot significance`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench robot significance --pose P1 --factors unit\n  stiffbench robot significance --pose P3 --factors m_fsd --beams-only\n  stiffbench robot significance --pose P1 --parameters joint.A3,base.rx"
)]
pub(super) struct SignificanceArgs {
    /// Robot, mechanism and factors.
    #[command(flatten)]
    model: RobotModelArgs,
    /// Pose [default: the robot's first]
    #[arg(long)]
    pose: Option<String>,
    /// Change the constants of beams only, as the multi-source steps do
    #[arg(long)]
    beams_only: bool,
    /// Further sections and springs to rank: section.NAME.Iz, joint.NAME, base.rx
    #[arg(long, value_delimiter = ',', value_name = "PARAMETER")]
    parameters: Vec<String>,
}

/// Which constant matters where.
pub(super) fn run(args: &SignificanceArgs) -> Result<Outcome, Failure> {
    let resolved = args.model.model().resolve()?;
    let pose = match (&args.pose, resolved.robot.poses.first()) {
        (Some(pose), _) => PoseId::new(pose),
        (None, Some(first)) => first.id.clone(),
        (None, None) => {
            return ArgumentError::refuse(
                "--pose",
                format!("{} has no named pose", resolved.source.name),
                "add [poses.NAME] to the robot file",
            );
        }
    };
    let scope = if args.beams_only {
        Scope::Beams
    } else {
        Scope::All
    };
    let mechanism = resolved.mechanism()?;
    let physics = fixed_physics(&resolved, Method::Regression);
    UnknownSprings::of(&resolved).refuse(resolved.robot.pose(&pose)?)?;
    let further = args.parameters.iter();
    let further = further.map(|name| ModelParameter::find(&resolved.robot, mechanism, name));
    let further = further.collect::<Result<Vec<_>, _>>()?;
    let found = significance(
        &resolved.robot,
        mechanism,
        &pose,
        &resolved.factors,
        scope,
        physics.as_ref(),
        &further,
    )?;
    let data = SignificanceReport::from(&found);
    let mut document = Document::of(format!("Pose {pose}"));
    document.append(physics_document(BESIDE_BEAMS, &resolved.physics.effects));
    document.append(data.document());
    Ok(Outcome::new("significance", document, data)
        .with_inputs(Inputs::default().with_model(&resolved))
        .with_warnings(resolved.warnings.clone()))
}
