//! The arguments of `robot`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::args::RobotModelArgs;
use super::map::MapArgs;
use super::numbers::three_numbers;
use super::pose_args::PoseArgs;
use super::robot_export::RobotExportArgs;

/// Arguments of `robot`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench robot show\n  stiffbench robot check my-robot.toml --figures drawn\n  stiffbench robot compliance --pose P1 --set theta2=390 --mechanism F --json\n  stiffbench robot map --samples 5000 --out maps\n  stiffbench robot show --schema > robot.schema.json"
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
    /// Compute the 6 x 6 compliance of the end in a pose
    Compliance(ComplianceArgs),
    /// Map the stiffness over the workspace of each mechanism: statistics, regions of high and low stiffness, the paper's Tables VII to X
    Map(Box<MapArgs>),
    /// Rank the section constants by their effect in each direction (the paper's Table III)
    Significance(SignificanceArgs),
    /// Write the robot with its springs, friction and play for a simulator, or its parameters and compliance as a table
    Export(Box<RobotExportArgs>),
}

/// Arguments of `robot check`.
#[derive(Debug, Args)]
pub(super) struct RobotCheckArgs {
    /// Name of a shipped robot, or a robot file
    pub(super) robot: String,
    /// Draw every pose into this folder (SVG and PNG)
    #[arg(long, value_name = "FOLDER")]
    pub(super) figures: Option<PathBuf>,
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

/// Arguments of `robot compliance`.
#[derive(Debug, Args)]
pub(super) struct ComplianceArgs {
    /// Robot, mechanism and factors.
    #[command(flatten)]
    pub(super) model: RobotModelArgs,
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
    /// Draw the robot in the pose into this folder, displaced by the load of --load (50 N downward without it)
    #[arg(long, value_name = "FOLDER")]
    pub(super) figures: Option<PathBuf>,
}

/// Arguments of `robot significance`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench robot significance --pose P1 --factors unit\n  stiffbench robot significance --pose P3 --factors m_fsd --beams-only\n  stiffbench robot significance --pose P1 --parameters joint.A3,base.rx"
)]
pub(super) struct SignificanceArgs {
    /// Robot, mechanism and factors.
    #[command(flatten)]
    pub(super) model: RobotModelArgs,
    /// Pose [default: the robot's first]
    #[arg(long)]
    pub(super) pose: Option<String>,
    /// Change the constants of beams only, as the multi-source steps do
    #[arg(long)]
    pub(super) beams_only: bool,
    /// Further sections and springs to rank: section.NAME.Iz, joint.NAME, base.rx
    #[arg(long, value_delimiter = ',', value_name = "PARAMETER")]
    pub(super) parameters: Vec<String>,
}
