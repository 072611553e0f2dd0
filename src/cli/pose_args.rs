//! One pose: by name, by values of its variables, or both.

use clap::{Args, value_parser};

use crate::analysis::ArgumentError;
use crate::digits::significant;
use crate::fit::PoseRules;
use crate::robot::{Pose, Robot};
use crate::test_point::PoseId;

use super::failure::Failure;

/// Options that choose a pose.
#[derive(Debug, Args)]
pub(super) struct PoseArgs {
    /// Named pose of the robot [default: every variable at its nominal value]
    #[arg(long)]
    pose: Option<String>,
    /// Value of a variable in degrees, or in metres for a sliding joint, for example theta2=397.3
    #[arg(long = "set", value_name = "VARIABLE=DEGREES", num_args = 1..)]
    set: Vec<String>,
}

/// Options that state which poses may be proposed.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Proposed poses")]
pub(super) struct PoseRulesArgs {
    /// Lowest height of joints and tool in a proposed pose, in base axes [default: that of the robot file, else the base, for new poses]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    floor_mm: Option<f64>,
    /// Smallest distance of the tool from the vertical through the base [default: that of the robot file, else a tenth of the largest in a named pose, for new poses]
    #[arg(long, value_name = "MM")]
    base_radius_mm: Option<f64>,
    /// Smallest distance of a joint from its limits, percent of its range [default: 5, for new poses]
    #[arg(long, value_name = "PERCENT", value_parser = value_parser!(u8).range(0..=49))]
    limit_margin_percent: Option<u8>,
    /// Poses to exclude from the proposals, comma-separated: P2, new187
    #[arg(long, value_delimiter = ',', value_name = "POSES")]
    forbid_poses: Vec<String>,
}

impl PoseRulesArgs {
    /// The rules.
    pub(super) fn rules(&self) -> PoseRules {
        let forbidden = self.forbid_poses.iter();
        PoseRules {
            floor_m: self.floor_mm.map(|floor_mm| 1e-3 * floor_mm),
            base_radius_m: self.base_radius_mm.map(|radius_mm| 1e-3 * radius_mm),
            limit_margin_percent: self.limit_margin_percent.map(f64::from),
            forbidden: forbidden.map(|name| PoseId::new(name)).collect(),
        }
    }
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
}

/// What limits a pose lies beyond, in words.
pub(super) fn limits_passed(robot: &Robot, pose: &Pose) -> Vec<String> {
    let violated = robot.violated_limits(pose).into_iter();
    violated
        .map(|violation| {
            format!(
                "the pose lies {} degrees beyond the limit {}",
                significant(violation.excess_deg, 3),
                violation.limit
            )
        })
        .collect()
}
