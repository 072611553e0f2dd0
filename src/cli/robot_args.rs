//! The arguments of `robot`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::args::{ModelArgs, at_least_one, three_numbers};

/// Arguments of `robot`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench robot show\n  stiffbench robot check my-robot.toml\n  stiffbench robot compliance --pose P1 --set theta2=390 --mechanism F --json\n  stiffbench robot workspace --samples 30000 --figure workspace\n  stiffbench robot show --schema > robot.schema.json"
)]
pub(super) struct RobotArgs {
    /// What to look at.
    #[command(subcommand)]
    pub(super) what: RobotCommand,
}

/// Subcommands of `robot`.
#[derive(Debug, Subcommand)]
pub(super) enum RobotCommand {
    /// Bodies, mechanisms, variables, poses, factor sets; the mobility; the schema of robot files
    Show(ShowArgs),
    /// Read a robot file and try every mechanism in every pose
    Check {
        /// Name of a shipped robot, or a robot file
        robot: String,
    },
    /// Random poses under the limits: extreme points, and the projection of the paper's Fig. 3
    Workspace(WorkspaceArgs),
    /// 6 x 6 compliance of the end in a pose
    Compliance(ComplianceArgs),
}

/// Arguments of `robot show`.
#[derive(Debug, Args)]
pub(super) struct ShowArgs {
    /// Name of a shipped robot, or a robot file
    #[arg(value_name = "ROBOT", default_value = "hp-robot")]
    pub(super) robot: String,
    /// Instead: degrees of freedom by the paper's eqs. (1) to (5), and by the rank of the closure conditions
    #[arg(long)]
    pub(super) mobility: bool,
    /// Instead: the JSON Schema of robot files
    #[arg(long, conflicts_with_all = ["robot", "mobility"])]
    pub(super) schema: bool,
}

/// Arguments of `robot workspace`.
#[derive(Debug, Args)]
pub(super) struct WorkspaceArgs {
    /// Name of a shipped robot, or a robot file
    #[arg(default_value = "hp-robot")]
    pub(super) robot: String,
    /// Number of random poses
    #[arg(long, value_name = "N", default_value_t = 30_000, value_parser = at_least_one())]
    pub(super) samples: usize,
    /// Seed of the poses
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    /// Variables to vary, comma-separated [default: all that have a range]
    #[arg(long, value_delimiter = ',', value_name = "VARIABLE,...")]
    pub(super) vary: Option<Vec<String>>,
    /// Write the projection as FILE.svg and FILE.png
    #[arg(long, value_name = "FILE")]
    pub(super) figure: Option<PathBuf>,
}

/// Arguments of `robot compliance`.
#[derive(Debug, Args)]
#[command(mut_arg("robot", |option| option.hide(true)))]
pub(super) struct ComplianceArgs {
    /// Name of a shipped robot, or a robot file [default: the model's, else hp-robot]
    #[arg(value_name = "ROBOT", conflicts_with = "robot")]
    pub(super) shown: Option<String>,
    /// Robot, mechanism and factors.
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Named pose of the robot [default: every variable at its nominal value]
    #[arg(long)]
    pub(super) pose: Option<String>,
    /// Value of a variable, degrees, for example theta2=397.3
    #[arg(long = "set", value_name = "VARIABLE=DEGREES", num_args = 1..)]
    pub(super) set: Vec<String>,
    /// Joints turn freely unless a drive or brake locks them
    #[arg(long)]
    pub(super) pinned: bool,
    /// Beams with shear deformation
    #[arg(long)]
    pub(super) timoshenko: bool,
    /// Load at the end, under which joints that are not linear are taken and an arm of rigid links has the load's own stiffness: force along x, y and z, N [default: the smallest]
    #[arg(long, value_name = "FX,FY,FZ", value_parser = three_numbers, allow_hyphen_values = true)]
    pub(super) load: Option<[f64; 3]>,
}
