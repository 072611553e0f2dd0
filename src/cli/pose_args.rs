//! One pose: by name, by values of its variables, or both.

use clap::Args;

use crate::analysis::ArgumentError;
use crate::robot::{Pose, Robot};
use crate::test_point::PoseId;

use super::failure::Failure;

/// Options that choose a pose.
#[derive(Debug, Args)]
pub(super) struct PoseArgs {
    /// Named pose of the robot [default: every variable at its nominal value]
    #[arg(long)]
    pose: Option<String>,
    /// Value of a variable, degrees, or metres of one that slides, for example theta2=397.3
    #[arg(long = "set", value_name = "VARIABLE=DEGREES", num_args = 1..)]
    set: Vec<String>,
}

impl PoseArgs {
    /// The pose with its name; `None` if no option names one.
    pub(super) fn chosen(&self, robot: &Robot) -> Result<Option<(String, Pose)>, Failure> {
        if self.pose.is_none() && self.set.is_empty() {
            return Ok(None);
        }
        let (mut name, mut pose) = match &self.pose {
            Some(name) => (name.clone(), robot.pose(&PoseId::new(name))?.clone()),
            None => ("nominal".to_owned(), robot.nominal_pose()),
        };
        for setting in &self.set {
            let value = setting.split_once('=').and_then(|(name, value)| {
                Some((name, value.parse::<f64>().ok().filter(|v| v.is_finite())?))
            });
            let Some((variable, value)) = value else {
                return ArgumentError::refuse(
                    format!("--set {setting}"),
                    "a variable, an equals sign and a number of degrees are needed",
                    "--set theta2=397.3",
                );
            };
            pose.angles_deg[robot.variable(variable)?] = value;
            name = format!("{name}, {variable}={value}");
        }
        Ok(Some((name, pose)))
    }

    /// The pose; the nominal one if no option names one.
    pub(super) fn pose(&self, robot: &Robot) -> Result<Pose, Failure> {
        let chosen = self.chosen(robot)?;
        Ok(chosen.map_or_else(|| robot.nominal_pose(), |(_, pose)| pose))
    }
}

/// What limits a pose lies beyond, in words.
pub(super) fn limits_passed(robot: &Robot, pose: &Pose) -> Vec<String> {
    let violated = robot.violated_limits(pose).into_iter();
    violated
        .map(|violation| {
            format!(
                "the pose lies {:.3e} degrees beyond the limit {}",
                violation.excess_deg, violation.limit
            )
        })
        .collect()
}
