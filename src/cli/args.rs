//! The arguments of every subcommand.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use super::compare::CompareArgs;
use super::demo::DemoArgs;
use super::diagnose::DiagnoseArgs;
use super::fit::FitArgs;
use super::gauge::GaugeArgs;
pub use super::global::{Global, ProgressMode};
use super::import::ImportArgs;
pub use super::numbers::{at_least_one, seconds};
use super::part::PartArgs;
use super::report::ReportArgs;
use super::robot::RobotArgs;
use super::session::SessionArgs;
use super::simulate::SimulateArgs;
use super::stiffness::StiffnessArgs;
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
