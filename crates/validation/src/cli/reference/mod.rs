//! `stiffbench-validate reference`.

mod args;
mod calculix;
mod export;

pub(crate) use args::ReferenceArgs;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::reference::ReferenceRecord;
use crate::report::{ReferencePoseSummary, reference_summary};
use stiffbench::analysis::{AnalysisError, ReadError, robot_source, sha256};
use stiffbench::fit::{CellModel, FitError};
use stiffbench::robot::{Mechanism, Robot};
use stiffbench::test_point::{Cell, Direction, PoseId};

use args::{ReferenceCommand, ReferenceCompareArgs};
use stiffbench::cli::args::Global;
use stiffbench::cli::failure::Failure;
use stiffbench::cli::outcome::Outcome;

/// What was recorded with CalculiX, for machines without it.
const RECORDED: &str = include_str!("../../../../../data/reference/hp-robot-P1/reference.json");

const MODEL_FILE: &str = "model.json";
const RECORD_FILE: &str = "reference.json";
const LIST_FILE: &str = "reference.csv";

/// Solutions that are timed: enough for a tenth of a second of work.
const TIMED_SOLVES: u32 = 1000;

/// A reference of solids: written, run, compared.
pub(crate) fn run(args: &ReferenceArgs, global: &Global) -> Result<Outcome, Failure> {
    match &args.what {
        ReferenceCommand::Export(args) => export::export(args),
        ReferenceCommand::Run(args) => calculix::run_calculix(args, global),
        ReferenceCommand::Compare(args) => compare(args),
    }
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|source| {
        if source.kind() == std::io::ErrorKind::NotFound {
            return Failure::from(AnalysisError::NotFound {
                path: path.to_owned(),
                help: "stiffbench-validate reference export writes a model, stiffbench-validate reference run its results".to_owned(),
            });
        }
        ReadError::of(path)(source).into()
    })
}

fn compare(args: &ReferenceCompareArgs) -> Result<Outcome, Failure> {
    let (name, text) = match &args.reference {
        None => ("the recorded reference".to_owned(), RECORDED.to_owned()),
        Some(path) => {
            let file: PathBuf = if path.is_dir() {
                path.join(RECORD_FILE)
            } else {
                path.clone()
            };
            (file.display().to_string(), read(&file)?)
        }
    };
    let record = ReferenceRecord::parse(&name, &text)?;
    record.check_finished(&name)?;
    let source = robot_source(args.robot.as_deref().unwrap_or(&record.model.robot), None)?;
    let robot = Robot::parse(&source)?;
    let mechanism = robot.mechanism(Some(&record.model.mechanism))?;
    let summary = reference_summary(&robot, mechanism, &record, |pose| {
        seconds_per_solve(&robot, mechanism, pose)
    })?;
    let mut warnings = robot.warnings.clone();
    warnings.extend(summary.notes());
    if sha256(&source.text) != record.model.robot_sha256 {
        warnings.push(format!(
            "{} is not the file the reference was made of: its SHA-256 differs",
            source.name
        ));
    }
    Ok(Outcome::new("reference-compare", summary.text(), summary).with_warnings(warnings))
}

/// Time of one solution of the beams fitted to a pose, s.
fn seconds_per_solve(
    robot: &Robot,
    mechanism: &Mechanism,
    pose: &ReferencePoseSummary,
) -> Result<f64, FitError> {
    let factors = pose.factors.of_both_classes();
    let cells = [Cell::new(PoseId::new(&pose.pose), Direction::X)];
    let started = Instant::now();
    for _ in 0..TIMED_SOLVES {
        // As a new run of the paper's program would: structure, assembly, solution.
        CellModel::new(robot, mechanism, &[], &cells)?.stiffness(&factors)?;
    }
    Ok(started.elapsed().as_secs_f64() / f64::from(TIMED_SOLVES))
}
