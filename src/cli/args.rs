//! The arguments of every subcommand.

use std::path::PathBuf;

use clap::builder::RangedU64ValueParser;
use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::bench::NoiseShape;
use crate::least_squares::SigmaMode;
use crate::stiffness::Branches;

use super::compare::CompareArgs;
use super::data_args::DataArgs;
use super::demo::DemoArgs;
use super::diagnose_args::DiagnoseArgs;
use super::gauge::GaugeArgs;
pub use super::global::{Global, ProgressMode};
use super::import::ImportArgs;
use super::numbers::{MOST_LOAD_CASES, MOST_REPLICATES, count_up_to};
pub use super::numbers::{at_least_one, seconds};
use super::option_values::{BRANCHES, OptionValue, one_of};
use super::parameter_args::ParameterArgs;
use super::part::PartArgs;
use super::pose_args::PoseRulesArgs;
use super::procedure::{AxesArgs, ProcedureArgs};
use super::report::ReportArgs;
use super::robot_args::RobotArgs;
use super::session::SessionArgs;
use crate::analysis::BootstrapOver;
use crate::report::VERSION;

/// From two gauges on a robot bench to a stiffness model that can be trusted.
#[derive(Debug, Parser)]
#[command(
    name = "stiffbench",
    version = VERSION,
    about,
    max_term_width = 110,
    after_help = "Examples:\n  stiffbench demo                                  the main job on shipped data\n  stiffbench stiffness my-session                  stiffness with error bars\n  stiffbench fit my-session --train P1,P3          factors, validated on the other poses\n  stiffbench diagnose my-session                   which physics the model leaves out\n  stiffbench robot compliance --pose P1            6 x 6 end compliance"
)]
pub(super) struct Cli {
    /// What all subcommands share.
    #[command(flatten)]
    pub(super) global: Global,
    /// What to do.
    #[command(subcommand)]
    pub(super) command: Command,
}

/// Subcommands.
#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Run the main job on shipped data: stiffness, fit, validation, figures in ./stiffbench-demo
    Demo(DemoArgs),
    /// Show, check and create robot files; compute compliance, significance and maps of the stiffness; export to simulators
    Robot(Box<RobotArgs>),
    /// Import tables of other programs into a session folder: CSV, TSV, LabVIEW, XLSX, testing machines, logs
    Import(Box<ImportArgs>),
    /// Compute stiffness with uncertainty from readings
    Stiffness(StiffnessArgs),
    /// Fit the model's factors to measured stiffness, or joint springs to force and displacement vectors
    Fit(Box<FitArgs>),
    /// Simulate a session: write readings of a virtual robot, with noise, into a session folder
    Simulate(SimulateArgs),
    /// Measure at a bench in guided sessions: plan, run, resume, status, verify, recover, log
    Session(SessionArgs),
    /// Compare two sessions: difference in stiffness with its uncertainty
    Compare(CompareArgs),
    /// Find missing physics: where model and readings differ, which effect explains it, its size and the evidence
    Diagnose(Box<DiagnoseArgs>),
    /// Diagnose and predict a part by a table of force against displacement, without a robot
    Part(PartArgs),
    /// Write a session and its results as one document; `report verify` checks every number in it
    Report(Box<ReportArgs>),
    /// Export readings and stiffness: CSV with a data package, XLSX, Parquet
    Export(super::export::DataExportArgs),
    /// Find, bind, read, record and emulate gauges; show, check and decode by their descriptions
    #[command(alias = "instrument")]
    Gauge(GaugeArgs),
    /// Show the settings in force and where each comes from: configuration file, environment variable or default
    Config(super::config::ConfigArgs),
    /// Check this computer before a session: ports, terminal, disk, configuration
    Doctor(super::doctor::DoctorArgs),
    /// Explain an error code, a law or a verdict, and what to do
    Explain(super::explain::ExplainArgs),
    /// Print shell completions
    #[command(
        after_help = "Examples:\n  stiffbench completions bash > ~/.local/share/bash-completion/completions/stiffbench\n  stiffbench completions fish > ~/.config/fish/completions/stiffbench.fish"
    )]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// What completes a word, one a line, for the scripts of shells
    #[command(name = "__complete", hide = true)]
    Complete {
        /// Of what
        #[arg(value_enum)]
        of: super::complete::CompletedWord,
    },
    /// Print a manual page, or write the pages of all commands as files
    Man(super::help::ManArgs),
}

/// Which robot, mechanism and factors, and which physics beside them.
#[derive(Debug, Clone, PartialEq, Eq, Default, Args)]
pub struct ModelArgs {
    /// Name of a shipped robot, or a robot file [default: the session's, else hp-robot]
    #[arg(long, value_name = "NAME|FILE")]
    pub robot: Option<String>,
    /// Mechanism of the robot [default: the session's, else the robot's last]
    #[arg(long, value_name = "NAME")]
    pub mechanism: Option<String>,
    /// Factor set of the robot, or a TOML file with tables beam and link [default: the session's, else m_fsd, else unit]
    #[arg(long, value_name = "NAME|FILE")]
    pub factors: Option<String>,
    /// Model with found physics, as diagnose writes it: supplies robot, mechanism, factors and effects that no option above names
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Effect in addition to the beams, LAW@PLACE:NAME=VALUE,... (docs/physics.md); repeatable
    #[arg(long = "effect", value_name = "EFFECT")]
    pub effects: Vec<String>,
    /// Robot of the configuration and where it stands: used where nothing else names a robot
    #[arg(long, hide = true, num_args = 2)]
    pub default_robot: Option<Vec<String>>,
}

/// The robot that a command works on, with mechanism, factors and physics.
#[derive(Debug, Clone, Args)]
#[command(mut_arg("robot", |option| option.hide(true)))]
pub(super) struct RobotModelArgs {
    /// Name of a shipped robot, or a robot file [default: the model's, else hp-robot]
    #[arg(value_name = "ROBOT", conflicts_with = "robot")]
    named: Option<String>,
    /// Robot, mechanism and factors.
    #[command(flatten)]
    model: ModelArgs,
}

impl RobotModelArgs {
    /// Robot, mechanism, factors and physics.
    pub(super) fn model(&self) -> ModelArgs {
        let mut model = self.model.clone();
        if self.named.is_some() {
            model.robot.clone_from(&self.named);
        }
        model
    }
}

impl ModelArgs {
    /// Whether none of them is given; a configured robot does not count.
    pub(super) fn is_default(&self) -> bool {
        let given = Self {
            default_robot: None,
            ..self.clone()
        };
        given == Self::default()
    }
}

/// Arguments of `stiffness`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench stiffness my-session --budget\n  stiffbench stiffness readings.csv --branches both --json\n  stiffbench stiffness gauge-log.txt --direction x"
)]
pub(super) struct StiffnessArgs {
    /// Session folder, readings file, or table of another program
    pub(super) data: PathBuf,
    /// Branches to use
    #[arg(long, value_parser = one_of(BRANCHES), default_value = "loading")]
    pub(super) branches: Branches,
    /// Magnitude of the smallest load to use, N
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0.0,
        hide_default_value = true
    )]
    pub(super) from_load: f64,
    /// Magnitude of the largest load to use, N
    #[arg(long, value_name = "N", default_value_t = f64::INFINITY, hide_default_value = true)]
    pub(super) to_load: f64,
    /// Print the uncertainty budget of every cell
    #[arg(long)]
    pub(super) budget: bool,
    /// Write the figure of load against displacement into this folder
    #[arg(long, value_name = "FOLDER")]
    pub(super) figures: Option<PathBuf>,
    /// How the data are read.
    #[command(flatten)]
    pub(super) reading: DataArgs,
}

/// Fitting method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodArg {
    /// All training cells at once, with intervals
    LeastSquares,
    /// The paper's nine steps
    Paper,
}

/// Where the standard deviation of the residuals comes from.
const SIGMAS: [OptionValue<SigmaMode>; 2] = [
    (
        "known",
        "The stated or pooled uncertainties of the stiffnesses",
        SigmaMode::Known,
    ),
    (
        "estimated",
        "The scatter about the fit",
        SigmaMode::Estimated,
    ),
];

/// Arguments of `fit`.
#[derive(Debug, Args)]
#[command(
    after_help = "DATA may also be a list of stiffness values (columns pose, direction, stiffness_N_per_um and, if known, u_N_per_um), a list of\ncomputed displacements (pose, direction, force_N, displacement_um), or one of the shipped names paper-experiment (Table VI) and\npaper-reference (Table V, finite elements).\n\nExamples:\n  stiffbench fit my-session --train P1,P3\n  stiffbench fit my-session --method paper --train P1,P3 --reference paper-reference\n  stiffbench fit my-session --parameter beam.J=fixed,link.A=free --bootstrap 1000 --seed 1\n  stiffbench fit my-session --parameter joint.A3,base.rx=free,joint.A3=0..1e-4\n  stiffbench fit my-session --model my-session/diagnosis/model.toml\n  stiffbench fit positions.csv --robot my-robot.toml   (elastic calibration: position_x_mm, position_y_mm, position_z_mm, joint_J1_deg ...)"
)]
pub(super) struct FitArgs {
    /// Session folder, readings file, load cases (docs/joint-stiffness.md), list of stiffness values, or a shipped name
    pub(super) data: PathBuf,
    /// Further sessions or load cases of the same robot, fitted together with the first
    #[arg(value_name = "DATA")]
    pub(super) further: Vec<PathBuf>,
    /// Robot, mechanism and factors.
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Fitting method
    #[arg(long, value_enum, default_value_t = MethodArg::LeastSquares)]
    pub(super) method: MethodArg,
    /// Poses to fit, comma-separated; the others are held out [default: all, validated by leaving each out in turn]
    #[arg(long, value_delimiter = ',')]
    pub(super) train: Option<Vec<String>>,
    /// Weights of the training poses in the paper's combination [default: equal]
    #[arg(long, value_delimiter = ',', allow_negative_numbers = true)]
    pub(super) weights: Option<Vec<f64>>,
    /// Reference displacements or stiffness for the single-source steps of the paper's method
    #[arg(long, value_name = "NAME|FILE")]
    pub(super) reference: Option<PathBuf>,
    /// Which parameters of the model are free.
    #[command(flatten)]
    pub(super) parameters: ParameterArgs,
    /// Source of the standard deviation of the residuals [default: known if the data state it]
    #[arg(long, value_parser = one_of(SIGMAS))]
    pub(super) sigma: Option<SigmaMode>,
    /// Number of bootstrap replicates
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(0..=MOST_REPLICATES))]
    pub(super) bootstrap: usize,
    /// What the bootstrap resamples
    #[arg(long, value_enum, default_value_t = BootstrapOver::Runs, requires = "bootstrap")]
    pub(super) bootstrap_over: BootstrapOver,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    /// Search for a lower minimum with a particle swarm and a simplex
    #[arg(long)]
    pub(super) global_search: bool,
    /// Quantity derived from the parameters, with its uncertainty, for example ratio=beam.Iy/beam.Iz or k=1/joint.J2; repeatable
    #[arg(long, value_name = "NAME=EXPRESSION")]
    pub(super) derive: Vec<String>,
    /// Output of fit --json for another model of the same data: compares AICc, F test and errors in unseen poses; repeatable
    #[arg(long, value_name = "FIT.json")]
    pub(super) against: Vec<PathBuf>,
    /// Write the fitted factors as a TOML file for --factors
    #[arg(long, value_name = "FILE")]
    pub(super) save_factors: Option<PathBuf>,
    /// Write the loads that would best determine the open parameters: a procedure (FILE.toml) or a table of load cases to fill in (FILE.csv)
    #[arg(long, value_name = "FILE")]
    pub(super) next: Option<PathBuf>,
    /// Which poses may be planned.
    #[command(flatten)]
    pub(super) rules: PoseRulesArgs,
    /// Write the figures of the fit into this folder
    #[arg(long, value_name = "FOLDER")]
    pub(super) figures: Option<PathBuf>,
    /// How the data are read.
    #[command(flatten)]
    pub(super) reading: DataArgs,
}

/// Distribution of the errors.
const NOISE_SHAPES: [OptionValue<NoiseShape>; 2] = [
    ("normal", "Normal", NoiseShape::Normal),
    (
        "skewed",
        "Shifted gamma, the same standard deviation, skewness 1",
        NoiseShape::Skewed,
    ),
];

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench simulate my-session --seed 7\n  stiffbench simulate exact --noise-free\n  stiffbench simulate b --true-factor beam.Iy=0.006 --poses P1,P2 --procedure load-unload\n  stiffbench simulate c --procedure my-procedure.toml --repeats 3 --noise-distribution skewed\n  stiffbench simulate sticky --effect 'joint-friction@A3:c=0.1urad/(N*m),friction_moment=26N*m'\n  stiffbench simulate three-gauges --displacement-axes x,y,z --directions x,0,0.7071,0.7071"
)]
pub(super) struct SimulateArgs {
    /// Session folder to create; must not exist
    #[arg(value_name = "SESSION")]
    pub(super) out: PathBuf,
    /// Robot, mechanism and factors (the true ones, unless --true-factor changes them).
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// True value of a factor, for example beam.Iy=0.006
    #[arg(long, value_delimiter = ',', value_name = "FACTOR=VALUE")]
    pub(super) true_factor: Vec<String>,
    /// Seed of the noise
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    /// Standard deviation of a displacement reading, um
    #[arg(long, default_value_t = 3.0, allow_negative_numbers = true)]
    pub(super) reading_sd_um: f64,
    /// Standard deviation of a gauge zero, um
    #[arg(long, default_value_t = 2.5, allow_negative_numbers = true)]
    pub(super) zero_sd_um: f64,
    /// Standard deviation of the slope from run to run, relative
    #[arg(long, default_value_t = 0.004, allow_negative_numbers = true)]
    pub(super) run_slope_sd: f64,
    /// Display step of the displacement gauge, um
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    pub(super) displacement_step_um: f64,
    /// Display step of the force gauge, N
    #[arg(long, default_value_t = 0.1, allow_negative_numbers = true)]
    pub(super) force_step_n: f64,
    /// Distribution of the errors
    #[arg(long, value_parser = one_of(NOISE_SHAPES), default_value = "normal")]
    pub(super) noise_distribution: NoiseShape,
    /// Simulate without noise and without display steps
    #[arg(long)]
    pub(super) noise_free: bool,
    /// Simulate this many load cases instead of series of loads: one load in any direction each, in random poses or those of --poses (docs/joint-stiffness.md)
    #[arg(long, value_name = "N", value_parser = count_up_to(MOST_LOAD_CASES))]
    pub(super) load_cases: Option<usize>,
    /// Simulate this many absolute positions under the robot's own weight instead of series of loads, read by a tracker in an unknown place; with --loads-n every second position has a force
    #[arg(long, value_name = "N", value_parser = count_up_to(MOST_LOAD_CASES), conflicts_with = "load_cases")]
    pub(super) positions: Option<usize>,
    /// Joints keep their state from one run of a pose and direction to the next [default: every run starts from the unloaded state]
    #[arg(long)]
    pub(super) keep_history: bool,
    /// What is measured in which order; last, as its heading would go on.
    #[command(flatten)]
    pub(super) procedure: ProcedureArgs,
    /// Where displacements are read.
    #[command(flatten)]
    pub(super) axes: AxesArgs,
}
