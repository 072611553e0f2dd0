//! Which procedure is followed, and what the command line changes in it.

use clap::Args;

use crate::analysis::named_procedure;
use crate::procedure::Procedure;
use crate::shipped::DEFAULT_PROCEDURE;
use crate::test_point::{Direction, PoseId};

use super::failure::Failure;

/// Which procedure, and what differs from it.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Procedure")]
pub(super) struct ProcedureArgs {
    /// Procedure file, or a shipped one: paper, sweeps, load-unload, load-hold-unload, shuffled [default: sweeps]
    #[arg(long, value_name = "NAME|FILE")]
    procedure: Option<String>,
    /// Poses, comma-separated [default: the procedure's, else all of the robot]
    #[arg(long, value_delimiter = ',')]
    poses: Option<Vec<String>>,
    /// Directions, comma-separated [default: the procedure's]
    #[arg(long, value_delimiter = ',')]
    directions: Option<Vec<Direction>>,
    /// Loads in N, comma-separated, signed [default: the procedure's]
    #[arg(
        long = "loads-n",
        alias = "loads-N",
        value_name = "N",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    loads_n: Option<Vec<f64>>,
    /// Repeats [default: the procedure's]
    #[arg(long)]
    repeats: Option<u32>,
    /// The operator stops within this of the target, N [default: the procedure's]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    force_tolerance_n: Option<f64>,
}

/// The procedure that is meant, with the changes of the command line, and what a user should know of its file.
pub(super) fn resolve_procedure(args: &ProcedureArgs) -> Result<(Procedure, Vec<String>), Failure> {
    let name = args.procedure.as_deref().unwrap_or(DEFAULT_PROCEDURE);
    let (mut procedure, warnings) = named_procedure(name)?;
    if let Some(poses) = &args.poses {
        procedure.poses = Some(poses.iter().map(|name| PoseId::new(name)).collect());
    }
    if let Some(directions) = &args.directions {
        procedure.directions.clone_from(directions);
    }
    if let Some(loads_n) = &args.loads_n {
        procedure = procedure.with_loads(loads_n.clone());
    }
    if let Some(repeats) = args.repeats {
        procedure.repeats = repeats;
    }
    if let Some(tolerance_n) = args.force_tolerance_n {
        procedure.settle.force_tolerance_n = tolerance_n;
    }
    procedure.check()?;
    Ok((procedure, warnings))
}
