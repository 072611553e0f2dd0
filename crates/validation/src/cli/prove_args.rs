//! The arguments of `prove`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::prove::DoorJudge;

use stiffbench::cli::args::at_least_one;

/// Standard errors beyond which nothing is left to be counted.
const LARGEST_SIZE: f64 = 50.0;

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
    /// Intervals by every door where the law is stated and not searched, law by law
    Forced,
}

/// Ways into the program by which a law can be stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ForcedDoor {
    /// One displacement gauge along the load
    Session,
    /// Displacement gauges along x, y and z
    ThreeGauges,
    /// 60 loads in any direction, one by one
    LoadCases,
    /// Recordings of a part without a robot
    Part,
}

impl ForcedDoor {
    /// Its name in results.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Session => "session",
            Self::ThreeGauges => DoorJudge::ThreeGauges.name(),
            Self::LoadCases => DoorJudge::LoadCases.name(),
            Self::Part => "part",
        }
    }

    /// What is simulated for it; none of a part.
    pub(crate) fn judge(self) -> Option<DoorJudge> {
        match self {
            Self::Session => Some(DoorJudge::Pair),
            Self::ThreeGauges => Some(DoorJudge::ThreeGauges),
            Self::LoadCases => Some(DoorJudge::LoadCases),
            Self::Part => None,
        }
    }
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
    /// Benches with nothing missing; each point of a power curve, and each law of a size that is stated, has a
    /// twenty-fifth of that [default: 1000; with --quick 60, doors none]
    #[arg(long, value_name = "N", value_parser = at_least_one())]
    pub(crate) trials: Option<usize>,
    /// Laws of the power curves, without pairs, and those that are stated, comma-separated [default: all, and pairs; with --quick four]
    #[arg(long, value_delimiter = ',', value_name = "LAW")]
    pub(crate) laws: Vec<String>,
    /// Sizes of the power curves and of laws that are stated, standard errors, comma-separated [default: 3, 4.5, 6, 8; stated 6, 10, 20; with
    /// --quick 6]
    #[arg(long, value_delimiter = ',', value_name = "SIZE", value_parser = standard_errors)]
    pub(crate) sizes: Vec<f64>,
    /// Doors by which laws are stated, comma-separated [default: all]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "DOOR")]
    doors: Vec<ForcedDoor>,
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

impl ProveArgs {
    /// The doors by which laws are stated.
    pub(crate) fn doors(&self) -> &[ForcedDoor] {
        match self.doors.as_slice() {
            [] => ForcedDoor::value_variants(),
            chosen => chosen,
        }
    }
}

/// A size that is counted at.
fn standard_errors(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(size) if (1.0..=LARGEST_SIZE).contains(&size) => Ok(size),
        _ => Err(format!(
            "a size is a number of standard errors from 1 to {LARGEST_SIZE}"
        )),
    }
}
