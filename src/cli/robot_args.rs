//! The arguments of `robot`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::args::ModelArgs;
use super::numbers::{MOST_POSES, count_up_to, three_numbers};
use super::pose_args::PoseArgs;

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
    /// Print bodies, mechanisms, variables, poses and factor sets, or the mobility, or the schema of robot files
    Show(ShowArgs),
    /// Check a robot file in every mechanism and pose: size, mass, stiffness, warnings
    Check(RobotCheckArgs),
    /// Create a robot file from a URDF, a Denavit-Hartenberg table or a template
    New(NewArgs),
    /// Sample random poses within the limits: extreme points, and the projection of the paper's Fig. 3
    Workspace(WorkspaceArgs),
    /// Compute the 6 x 6 compliance of the end in a pose
    Compliance(ComplianceArgs),
}

/// Arguments of `robot check`.
#[derive(Debug, Args)]
pub(super) struct RobotCheckArgs {
    /// Name of a shipped robot, or a robot file
    pub(super) robot: String,
    /// Folder for drawings of every pose (SVG and PNG)
    #[arg(long, value_name = "FOLDER")]
    pub(super) out: Option<PathBuf>,
    /// Do not sketch the poses in the terminal
    #[arg(long)]
    pub(super) no_sketch: bool,
}

/// Arguments of `robot show`.
#[derive(Debug, Args)]
pub(super) struct ShowArgs {
    /// Name of a shipped robot, or a robot file [default: hp-robot]
    #[arg(value_name = "ROBOT")]
    pub(super) robot: Option<String>,
    /// Print the mobility instead: degrees of freedom by the paper's eqs. (1) to (5), and by the rank of the closure conditions
    #[arg(long)]
    pub(super) mobility: bool,
    /// Print the JSON Schema of the format of this robot file instead; without a file, that of stiffbench/robot/2
    #[arg(long, conflicts_with = "mobility")]
    pub(super) schema: bool,
}

/// Arguments of `robot new`.
#[derive(Debug, Args)]
#[command(
    group = clap::ArgGroup::new("from").required(true).args(["urdf", "dh", "template"]),
    after_help = "Examples:\n  stiffbench robot new my-robot.toml --urdf ur10.urdf --tip tool0\n  stiffbench robot new my-robot.toml --dh table.csv --convention modified --controller kuka --check-position 0,-90,90,0,0,0=1500,0,1850\n  stiffbench robot new my-robot.toml --template serial"
)]
pub(super) struct NewArgs {
    /// Robot file to write; must not exist
    #[arg(value_name = "FILE")]
    pub(super) out: PathBuf,
    /// URDF to read; expand a xacro first
    #[arg(long, value_name = "FILE")]
    pub(super) urdf: Option<PathBuf>,
    /// Link of the URDF that is fixed [default: its root]
    #[arg(long, value_name = "LINK", requires = "urdf")]
    pub(super) base: Option<String>,
    /// Link of the URDF that carries the tool [default: its only end]
    #[arg(long, value_name = "LINK", requires = "urdf")]
    pub(super) tip: Option<String>,
    /// Section of the links behind a joint, or of all links, which become beams; for example J2="tube 120x6 aluminium"
    #[arg(long, value_name = "[JOINT=]PROFILE", requires = "urdf")]
    pub(super) section: Vec<String>,
    /// Denavit-Hartenberg table to read, TOML or CSV
    #[arg(long, value_name = "FILE")]
    pub(super) dh: Option<PathBuf>,
    /// Convention of a table that does not state it
    #[arg(long, value_name = "CONVENTION", value_parser = ["standard", "modified"], requires = "dh")]
    pub(super) convention: Option<String>,
    /// Manufacturer whose axis convention for six-axis arms the table follows
    #[arg(long, value_name = "MAKER", value_parser = ["kuka", "fanuc"], requires = "dh")]
    pub(super) controller: Option<String>,
    /// Position of the tool centre, mm, that the controller shows for joint values; repeatable
    #[arg(
        long,
        value_name = "Q1,Q2,...=X,Y,Z",
        requires = "dh",
        allow_hyphen_values = true
    )]
    pub(super) check_position: Vec<String>,
    /// Template to copy: serial, scara, four-bar, parallelogram or gantry
    #[arg(long, value_name = "NAME", value_parser = ["serial", "scara", "four-bar", "parallelogram", "gantry"])]
    pub(super) template: Option<String>,
}

/// Arguments of `robot workspace`.
#[derive(Debug, Args)]
pub(super) struct WorkspaceArgs {
    /// Name of a shipped robot, or a robot file
    #[arg(default_value = "hp-robot")]
    pub(super) robot: String,
    /// Number of random poses
    #[arg(long, value_name = "N", default_value_t = 30_000, value_parser = count_up_to(MOST_POSES))]
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
    /// Which pose.
    #[command(flatten)]
    pub(super) pose: PoseArgs,
    /// Let joints turn freely unless a drive or brake locks them
    #[arg(long)]
    pub(super) pinned: bool,
    /// Include the shear deformation of beams
    #[arg(long)]
    pub(super) timoshenko: bool,
    /// Load at the end for the secant compliance of nonlinear joints and the geometric stiffness of an arm of rigid links: force along x, y and z, N [default: the smallest]
    #[arg(long, value_name = "FX,FY,FZ", value_parser = three_numbers, allow_hyphen_values = true)]
    pub(super) load: Option<[f64; 3]>,
}
