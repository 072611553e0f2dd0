//! Arguments of `stiffbench-validate reference`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// Arguments of `reference`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench-validate reference export --pose P1 --load=-50,-100,-300,-500 --out solids\n  stiffbench-validate reference run solids\n  stiffbench-validate reference compare solids\n  stiffbench fit paper-experiment --method paper --train P1 --reference solids/reference.csv\n\nrun needs CalculiX (apt-get install calculix-ccx); compare without a folder shows results that were recorded with it."
)]
pub(crate) struct ReferenceArgs {
    /// What to do.
    #[command(subcommand)]
    pub(crate) what: ReferenceCommand,
}

/// Subcommands of `reference`.
#[derive(Debug, Subcommand)]
pub(crate) enum ReferenceCommand {
    /// Write the robot in a pose as a mesh of solids for CalculiX
    Export(ExportArgs),
    /// Run CalculiX on a model that was exported, and keep the displacements
    Run(ReferenceRunArgs),
    /// The paper's Table IV on it: fitted beams beside the solids, elements, times, largest difference
    Compare(ReferenceCompareArgs),
}

/// Arguments of `reference export`.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Robot file, or the name of a shipped robot
    #[arg(long, value_name = "FILE|NAME", default_value = "hp-robot")]
    pub(crate) robot: String,
    /// Mechanism of the robot [default: the robot's last]
    #[arg(long, value_name = "NAME")]
    pub(crate) mechanism: Option<String>,
    /// Factor set of the robot, or a TOML file with tables beam and link: what the sections are multiplied by
    #[arg(long, value_name = "NAME|FILE", default_value = "unit")]
    pub(crate) factors: String,
    /// Named poses, comma-separated [default: the robot's first]
    #[arg(long, value_delimiter = ',')]
    pub(crate) pose: Vec<String>,
    /// Forces at the end, N, comma-separated; each acts along x, y and z in turn
    #[arg(
        long = "load",
        value_delimiter = ',',
        allow_hyphen_values = true,
        default_value = "-50"
    )]
    pub(crate) loads: Vec<f64>,
    /// Longest side of a solid element, mm
    #[arg(
        long = "size",
        value_name = "MM",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    pub(crate) size_mm: f64,
    /// Large displacements (NLGEOM): several solutions for each load
    #[arg(long)]
    pub(crate) large_displacements: bool,
    /// Folder for the model; it must be empty or not there
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
}

/// Arguments of `reference run`.
#[derive(Debug, Args)]
pub(crate) struct ReferenceRunArgs {
    /// Folder of a model that was exported
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// The program
    #[arg(long, value_name = "PATH", default_value = "ccx")]
    pub(crate) ccx: PathBuf,
    /// Threads CalculiX may use
    #[arg(long, default_value_t = 1, value_parser = stiffbench::cli::args::at_least_one())]
    pub(crate) threads: usize,
}

/// Arguments of `reference compare`.
#[derive(Debug, Args)]
pub(crate) struct ReferenceCompareArgs {
    /// Folder with results, or a reference.json [default: results recorded with hp-robot at P1]
    #[arg(value_name = "DIR|FILE")]
    pub(crate) reference: Option<PathBuf>,
    /// Robot file, or the name of a shipped robot [default: that of the reference]
    #[arg(long, value_name = "FILE|NAME")]
    pub(crate) robot: Option<String>,
}
