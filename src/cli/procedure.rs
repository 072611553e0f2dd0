//! Which procedure is followed, and what the command line changes in it.

use std::str::FromStr;

use clap::Args;

use crate::analysis::{ArgumentError, named_procedure};
use crate::load_direction::{LoadDirection, NotALoadDirection};
use crate::procedure::{Procedure, ProcedureProblem};
use crate::shipped::DEFAULT_PROCEDURE;
use crate::test_point::{Direction, PoseId};

use super::failure::{Failure, refuse_given};

/// Which procedure, and what differs from it.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Procedure")]
pub(super) struct ProcedureArgs {
    /// Procedure file, or a shipped one: paper, sweeps, load-unload, load-hold-unload, shuffled, iso-9283-static-compliance [default: sweeps]
    #[arg(long, value_name = "NAME|FILE")]
    procedure: Option<String>,
    /// Poses, comma-separated [default: the procedure's, else all of the robot]
    #[arg(long, value_delimiter = ',')]
    poses: Option<Vec<String>>,
    /// Directions of the loads, comma-separated: x, y, z, -x, -y, -z, or three numbers of a unit vector [default: the procedure's]
    #[arg(long, allow_hyphen_values = true)]
    directions: Option<LoadDirections>,
    /// Loads in N, comma-separated, signed [default: the procedure's]
    #[arg(
        long = "loads-n",
        alias = "loads-N",
        value_name = "N",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    loads_n: Option<Vec<f64>>,
    /// Rated load, N: the loads of the procedure in proportion, so that the largest has this size
    #[arg(long, value_name = "N", conflicts_with = "loads_n")]
    rated_load_n: Option<f64>,
    /// Repeats [default: the procedure's]
    #[arg(long)]
    repeats: Option<u32>,
    /// Tolerance of the operator around the target force, N [default: the procedure's]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    force_tolerance_n: Option<f64>,
}

/// Where displacements are read.
#[derive(Debug, Args)]
pub(super) struct AxesArgs {
    /// Base axes along which displacement gauges stand, comma-separated: up to x,y,z [default: the procedure's, else one gauge along the load]
    #[arg(long, value_name = "AXES", value_delimiter = ',')]
    displacement_axes: Option<Vec<Direction>>,
}

impl AxesArgs {
    /// Whether they are given.
    pub(super) fn is_given(&self) -> bool {
        self.displacement_axes.is_some()
    }

    /// The procedure with these gauges, checked: with one gauge along the load, loads go along the axes.
    pub(super) fn applied(&self, mut procedure: Procedure) -> Result<Procedure, ProcedureProblem> {
        if let Some(axes) = &self.displacement_axes {
            procedure.displacement_axes.clone_from(axes);
            procedure.displacement_axes.sort_unstable();
        }
        procedure.check()?;
        procedure.check_directions()?;
        Ok(procedure)
    }
}

/// Directions in one argument.
#[derive(Debug, Clone)]
struct LoadDirections(Vec<LoadDirection>);

impl FromStr for LoadDirections {
    type Err = NotALoadDirection;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        LoadDirection::parse_list(text).map(Self)
    }
}

/// What the command line says of a procedure of load cases or positions.
pub(super) struct SingleLoads {
    /// Named poses.
    pub(super) poses: Option<Vec<PoseId>>,
    /// Size of the largest force, N.
    pub(super) largest_n: Option<f64>,
    /// Applications of each load.
    pub(super) repeats: u32,
}

/// What is said of load cases or positions.
///
/// # Arguments
/// - `option`: what asks for them.
pub(super) fn single_loads(
    args: &ProcedureArgs,
    option: &str,
) -> Result<SingleLoads, ArgumentError> {
    let series = [
        ("--procedure", args.procedure.is_some()),
        ("--directions", args.directions.is_some()),
        ("--force-tolerance-n", args.force_tolerance_n.is_some()),
        ("--rated-load-n", args.rated_load_n.is_some()),
    ];
    refuse_given(&series, "it belongs to series of loads", |_| {
        format!("leave it out, or leave out {option}")
    })?;
    let poses = args.poses.as_ref();
    let poses = poses.map(|poses| poses.iter().map(|name| PoseId::new(name)).collect());
    let loads = args.loads_n.as_ref().map(|loads| loads.iter());
    let largest = loads.map(|loads| loads.fold(0.0_f64, |largest, load| largest.max(load.abs())));
    let repeats = args.repeats.unwrap_or(1);
    if largest.is_some_and(|largest| !(largest > 0.0 && largest.is_finite())) || repeats == 0 {
        return Err(ArgumentError::new(
            "--loads-n and --repeats",
            "a force above zero and one repeat at least are needed",
            "--loads-n 500 --repeats 1",
        ));
    }
    Ok(SingleLoads {
        poses,
        largest_n: largest,
        repeats,
    })
}

/// The procedure that is meant, with the changes of the command line, and what a user should know of its file.
pub(super) fn resolve_procedure(args: &ProcedureArgs) -> Result<(Procedure, Vec<String>), Failure> {
    let name = args.procedure.as_deref().unwrap_or(DEFAULT_PROCEDURE);
    let (mut procedure, warnings) = named_procedure(name)?;
    if let Some(poses) = &args.poses {
        procedure.poses = Some(poses.iter().map(|name| PoseId::new(name)).collect());
    }
    if let Some(directions) = &args.directions {
        procedure.directions.clone_from(&directions.0);
    }
    if let Some(loads_n) = &args.loads_n {
        procedure = procedure.with_loads(loads_n.clone());
    }
    if let Some(rated_n) = args.rated_load_n {
        procedure = with_rated_load(procedure, rated_n)?;
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

/// The procedure with its loads in proportion, the largest of the size of the rated load.
fn with_rated_load(procedure: Procedure, rated_n: f64) -> Result<Procedure, ArgumentError> {
    let largest = procedure
        .loads_n
        .iter()
        .fold(0.0_f64, |most, load| most.max(load.abs()));
    if !(rated_n > 0.0 && rated_n.is_finite() && largest > 0.0) {
        return Err(ArgumentError::new(
            format!("--rated-load-n {rated_n}"),
            "a rated load is a force above zero",
            "--rated-load-n 100",
        ));
    }
    // In units of a thousandth, as an operator can set.
    let share = |load: &f64| (1e3 * load / largest * rated_n).round() / 1e3;
    let loads = procedure.loads_n.iter().map(share).collect();
    Ok(procedure.with_loads(loads))
}
