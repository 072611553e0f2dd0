//! The arguments of `prove`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::prove::LARGEST_SIZE;

use stiffbench::cli::args::at_least_one;

/// Parts of the proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProvePart {
    /// Blind verdicts on concealed sessions, scored against sealed answers
    Concealed,
    /// False alarms where nothing is missing, and coverage of intervals
    Calibration,
    /// Power and right names against size, law by law
    Power,
    /// Standard errors of the laws on the paper's robot, beside those of an idealised bench
    Errors,
    /// The same readings as a session and as a table of vectors: whether the answers differ, and whether data/doors lists how
    Doors,
}

/// Lists of concealed sessions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SetChoice {
    /// The list with open answers
    Development,
    /// The list that nothing was developed on
    Proof,
    /// The list that was made after that had been scored
    Second,
    /// All
    All,
}

/// Arguments of `prove`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench-validate prove --quick\n  stiffbench-validate prove --out data/concealed/results\n  stiffbench-validate prove --only calibration --trials 200 --seed 7\n  stiffbench-validate prove --only power --laws slip,setting-in --trials 2500"
)]
pub(crate) struct ProveArgs {
    /// A few minutes on two cores: fewer sessions, trials and sizes
    #[arg(long)]
    pub(crate) quick: bool,
    /// These parts only, comma-separated
    #[arg(long, value_enum, value_delimiter = ',', value_name = "PART")]
    pub(crate) only: Vec<ProvePart>,
    /// Lists of concealed sessions
    #[arg(long, value_enum, default_value_t = SetChoice::All)]
    pub(crate) set: SetChoice,
    /// Concealed sessions of each list, chosen evenly by name [default: all; with --quick 12]
    #[arg(long, value_name = "N", value_parser = at_least_one())]
    pub(crate) sessions: Option<usize>,
    /// Benches with nothing missing; each point of a power curve has a twenty-fifth of that [default: 1000; with --quick 60, doors none]
    #[arg(long, value_name = "N", value_parser = at_least_one())]
    pub(crate) trials: Option<usize>,
    /// Laws of the power curves, comma-separated; without pairs [default: all, and pairs; with --quick four]
    #[arg(long, value_delimiter = ',', value_name = "LAW")]
    pub(crate) laws: Vec<String>,
    /// Sizes of the power curves, standard errors, comma-separated [default: 3, 4.5, 6, 8; with --quick 6]
    #[arg(long, value_delimiter = ',', value_name = "SIZE", value_parser = standard_errors)]
    pub(crate) sizes: Vec<f64>,
    /// Power on this robot in its named poses, with loading and unloading; its free springs are free in the baseline [default: the plans of
    /// the concealed sessions]
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) robot: Option<String>,
    /// Sessions of the same bench before each simulated one, which tell its noise too (calibration and power), as with diagnose --earlier
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) earlier: usize,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Folder with `concealed`, as in the repository
    #[arg(long, value_name = "FOLDER", default_value = "data")]
    pub(crate) data: PathBuf,
    /// Folder for verdicts, tables and figures
    #[arg(long, value_name = "FOLDER", default_value = "stiffbench-prove")]
    pub(crate) out: PathBuf,
    /// Another build of stiffbench, whose doors are judged
    #[arg(long, value_name = "FILE", hide = true)]
    pub(crate) program: Option<PathBuf>,
}

/// A size that power can be counted at.
fn standard_errors(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(size) if (1.0..=LARGEST_SIZE).contains(&size) => Ok(size),
        _ => Err(format!(
            "a size is a number of standard errors from 1 to {LARGEST_SIZE}"
        )),
    }
}
