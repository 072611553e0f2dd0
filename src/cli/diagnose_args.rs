//! The arguments of `diagnose`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::args::ModelArgs;
use super::data_args::DataArgs;
use super::parameter_args::ParameterArgs;
use super::pose_args::PoseRulesArgs;
use super::specimen_args::SpecimenArgs;

/// Arguments of `diagnose`.
#[derive(Debug, Args)]
#[command(
    after_help = "Writes verdict.txt, diagnosis.json and figures to SESSION/diagnosis. docs/diagnosis.md explains them.\n\nExamples:\n  stiffbench diagnose my-session\n  stiffbench diagnose readings.csv --robot my-robot.toml --out diagnosis --json\n  stiffbench diagnose my-session --earlier last-week --earlier yesterday\n  stiffbench diagnose my-session --without slip,gauge-periodic --no-figures\n  stiffbench diagnose my-session --parameter joint.A3,base.rx=free\n  stiffbench part diagnose cell.csv --map force=load,displacement=travel        a part, without a robot"
)]
pub(super) struct DiagnoseArgs {
    /// Session folder, readings file or load cases (docs/joint-stiffness.md)
    pub(super) data: PathBuf,
    /// Further sessions or load cases of the same robot, diagnosed together with the first
    #[arg(value_name = "DATA")]
    pub(super) further: Vec<PathBuf>,
    /// Robot, mechanism and factors.
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Which parameters of the model are free beside every candidate.
    #[command(flatten)]
    pub(super) parameters: ParameterArgs,
    /// How it is searched, and what is written.
    #[command(flatten)]
    pub(super) search: SearchArgs,
    /// Keep readings that contradict their repeats; they are still listed
    #[arg(long)]
    pub(super) keep_outliers: bool,
    /// Source of the scatter of single readings
    #[arg(long, value_enum, default_value_t = NoiseChoice::Estimated)]
    pub(super) noise: NoiseChoice,
    /// Earlier session on the same bench (folder or readings file), used to estimate the noise; repeatable
    #[arg(long, value_name = "SESSION", conflicts_with = "specimen")]
    pub(super) earlier: Vec<PathBuf>,
    /// How the data are read.
    #[command(flatten)]
    pub(super) reading: DataArgs,
    /// Which poses may be proposed.
    #[command(flatten)]
    pub(super) rules: PoseRulesArgs,
    /// Tables without a robot.
    #[command(flatten)]
    pub(super) specimen: SpecimenArgs,
}

/// What every diagnosis takes, of a robot or a part.
#[derive(Debug, Args)]
pub(super) struct SearchArgs {
    /// Laws to exclude from the search, comma-separated
    #[arg(long, value_delimiter = ',', value_name = "LAW")]
    pub(super) without: Vec<String>,
    /// Seed of the noise simulations that set the critical values
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    /// Folder for the results [default: diagnosis in the session folder; for a bare file nothing is written]
    #[arg(long, value_name = "FOLDER")]
    pub(super) out: Option<PathBuf>,
    /// Write no figures
    #[arg(long)]
    pub(super) no_figures: bool,
}

/// Source of the scatter of single readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum NoiseChoice {
    /// The readings: restricted likelihood of the differences between repeats
    Estimated,
    /// The instrument records of session.toml: step of the displacement gauge and spread when settled; zeros and runs as the readings show
    Records,
}
