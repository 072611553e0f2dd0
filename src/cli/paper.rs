//! `stiffbench paper`.

use clap::Args;

use crate::report::paper_report;
use crate::robot::Robot;

use super::data::robot_source;
use super::failure::Failure;
use super::outcome::Outcome;

/// Arguments of `paper`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  stiffbench paper --robot hp-robot-host-dominant")]
pub(super) struct PaperArgs {
    /// Robot with the paper's poses and factor sets
    #[arg(long, default_value = "hp-robot")]
    pub(super) robot: String,
}

/// The paper's tables beside ours.
pub(super) fn run(args: &PaperArgs) -> Result<Outcome, Failure> {
    let robot = Robot::parse(&robot_source(&args.robot, None)?)?;
    let report = paper_report(&robot)?;
    Ok(Outcome::new("paper", report.text(), report.json()))
}
