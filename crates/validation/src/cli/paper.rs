//! `stiffbench-validate paper`.

use clap::Args;

use stiffbench::report::paper_report;
use stiffbench::robot::Robot;

use stiffbench::analysis::robot_source;
use stiffbench::cli::failure::Failure;
use stiffbench::cli::outcome::Outcome;

/// Arguments of `paper`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  stiffbench-validate paper --robot hp-robot-host-dominant")]
pub(crate) struct PaperArgs {
    /// Robot with the paper's poses and factor sets
    #[arg(long, default_value = "hp-robot")]
    pub(crate) robot: String,
}

/// The paper's tables beside ours.
pub(crate) fn run(args: &PaperArgs) -> Result<Outcome, Failure> {
    let robot = Robot::parse(&robot_source(&args.robot, None)?)?;
    let report = paper_report(&robot)?;
    Ok(Outcome::new("paper", report.document(), report))
}
