//! `stiffbench paper`.

use crate::report::paper_report;
use crate::robot::Robot;

use super::args::PaperArgs;
use super::data::robot_source;
use super::failure::Failure;
use super::outcome::Outcome;

/// The paper's tables beside ours.
pub(super) fn run(args: &PaperArgs) -> Result<Outcome, Failure> {
    let robot = Robot::parse(&robot_source(&args.robot, None)?)?;
    let report = paper_report(&robot)?;
    Ok(Outcome::new("paper", report.text(), report.json()))
}
